/*
 * angle_kernel.h -- inside lib/sim: angles by their sines and cosines, several at a time, in double or in single.
 */
#ifndef SN_SIM_ANGLE_KERNEL_H
#define SN_SIM_ANGLE_KERNEL_H

#include "wide.h"

#ifdef SN_WIDE_SINGLE

/* atan(t) for |t| <= tan pi/8 to 1e-8: t - t^3/3 + ...; the coefficients are those of Moshier's Cephes library. */
SN_INLINE wide arc_tangent(wide t) {
    wide z = t * t, p = wide_splat(8.05374449538e-2);
    p = p * z + wide_splat(-1.38776856032e-1);
    p = p * z + wide_splat(1.99777106478e-1);
    p = p * z + wide_splat(-3.33329491539e-1);
    return p * z * t + t;
}

#else

/* atan(t) for |t| <= 0.66 to 2e-16: t + t z P(z) / Q(z), z = t^2; the coefficients are those of Moshier's Cephes library. */
SN_INLINE wide arc_tangent(wide t) {
    wide z = t * t;
    wide p = wide_splat(-8.750608600031904122785e-1);
    p = p * z + wide_splat(-1.615753718733365076637e1);
    p = p * z + wide_splat(-7.500855792314704667340e1);
    p = p * z + wide_splat(-1.228866684490136173410e2);
    p = p * z + wide_splat(-6.485021904942025371773e1);
    wide q = z + wide_splat(2.485846490142306297962e1);
    q = q * z + wide_splat(1.650270098316988542046e2);
    q = q * z + wide_splat(4.328810604912902668951e2);
    q = q * z + wide_splat(4.853903996359136964868e2);
    q = q * z + wide_splat(1.945506571482613964425e2);
    return t + t * (z * p / q);
}

#endif

/* The angle in [-pi, pi] whose sine and cosine are in the ratio sine : cosine, not both 0. Ours, not the C library's atan2, whose last bit
 * differs between processors; to 4e-16, in single to 2e-7. */
SN_INLINE wide angle_of(wide sine, wide cosine) {
    wide s = wide_abs(sine), c = wide_abs(cosine);
    wide_mask steep = wide_less(c, s);
    wide low = wide_select(steep, c, s), high = wide_select(steep, s, c);
    wide_mask upper =
        wide_less(wide_splat(0.41421356237309504880) * high, low); /* tan pi/8; atan(low/high) = pi/4 + atan((low-high)/(low+high)) */
    wide angle = arc_tangent(wide_select(upper, low - high, low) / wide_select(upper, low + high, high));
    angle = wide_select(upper, angle + wide_splat(SN_PI / 4.0), angle);
    angle = wide_select(steep, wide_splat(SN_PI / 2.0) - angle, angle);
    angle = wide_select(wide_less(cosine, wide_splat(0.0)), wide_splat(SN_PI) - angle, angle);
    return wide_copysign(angle, sine);
}

/* Into (-pi, pi], from (-3 pi, 3 pi). */
SN_INLINE wide wrap(wide angle) {
    wide turn = wide_splat(2.0 * SN_PI), half = wide_splat(SN_PI);
    wide lower = wide_select(wide_less(half, angle), angle - turn, angle);
    return wide_select(wide_less(-half, angle), lower, angle + turn);
}

#endif
