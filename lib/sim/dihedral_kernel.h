/*
 * dihedral_kernel.h -- inside lib/sim: the angle of hinges and their projection, several at a time; in double for dihedral.c, in single for
 * single.c. The equations are in dihedral.c.
 */
#ifndef SN_SIM_DIHEDRAL_KERNEL_H
#define SN_SIM_DIHEDRAL_KERNEL_H

#include "rows.h"
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

/* Value and gradients at points a, b, c, d; false where an area or the edge vanishes, or is not finite. */
SN_INLINE wide_mask hinge(const wide_point p[4], wide rest, wide *value, wide_vec3 g[4]) {
    wide_vec3 e = wide_between(p[1], p[0]), ac = wide_between(p[0], p[2]), bc = wide_between(p[1], p[2]);
    wide_vec3 ad = wide_between(p[0], p[3]), bd = wide_between(p[1], p[3]);
    wide_vec3 n1 = wide_cross(ac, bc), n2 = wide_cross(bd, ad);
    wide e2 = wide_dot(e, e), q1 = wide_dot(n1, n1), q2 = wide_dot(n2, n2), least = wide_splat(WIDE_HINGE_GUARD) * e2 * e2;
    wide most = wide_splat(WIDE_MOST);
    wide_mask good = ~wide_less(e2, wide_splat(SN_EDGE_GUARD)) & wide_less(least, q1) & wide_less(least, q2) & ~wide_less(most, q1) &
                     ~wide_less(most, q2); /* a NaN is in one of the areas, and less than nothing */
    wide length = wide_sqrt(e2), one = wide_splat(1.0);
    wide_vec3 unit = wide_scale(e, one / length), m1 = wide_scale(n1, one / q1), m2 = wide_scale(n2, one / q2);
    *value = wrap(angle_of(wide_dot(wide_cross(n1, n2), unit), wide_dot(n1, n2)) - rest);
    g[0] = wide_add(wide_scale(m1, wide_dot(bc, unit)), wide_scale(m2, wide_dot(bd, unit)));
    g[1] = wide_add(wide_scale(m1, -wide_dot(ac, unit)), wide_scale(m2, -wide_dot(ad, unit)));
    g[2] = wide_scale(m1, -length);
    g[3] = wide_scale(m2, -length);
    return good;
}

/* The limits of the published program (dihedral.c) in metres: on sum |q|^2, on lambda, and on 1 - d^2 of flat and of closed hinges. */
#define PUBLISHED_LEAST_SQUARE 1e2 /* 1/m^2 */
#define PUBLISHED_LEAST 1e-7       /* m^2 */
#define PUBLISHED_MOST 1e-5        /* m^2 */
#define PUBLISHED_FLAT 2e-10

/* What the rows of one sweep share. */
typedef struct hinge_rows {
    wide_record *points;
    const sn_index *index;  /* (4 x rows) */
    const double *angles;   /* (rows) */
    const double *softness; /* (rows) nullable */
    double *lambda;         /* (rows) */
    const bool *pairs;      /* (fours) single precision: it and the next can be projected together */
} hinge_rows;

typedef struct hinge_tally {
    int64_t skipped, clamped;
} hinge_tally;

/* The factor on w g of each point that C and its gradients call for, within the bounds of the sweep. */
SN_INLINE wide constraint_change(const wide_point p[4], const wide_vec3 g[4], wide c, wide lambda, wide compliance, const sn_sweep *sweep) {
    wide sum = wide_splat(0.0), farthest = sum;
    SN_UNROLL
    for (int i = 0; i < 4; i++) {
        wide moved = p[i].w * wide_dot(g[i], g[i]);
        sum = sum + moved;
        moved = p[i].w * moved;
        farthest = wide_select(wide_less(farthest, moved), moved, farthest);
    }
    wide change = wide_splat(sweep->gain) * (-c - compliance * lambda) / (sum + compliance);
    /* an arm that is stretched to many times its length would throw its end as far: no point moves farther than most_step */
    wide step = wide_sqrt(farthest) * wide_abs(change), most = wide_splat(sweep->most_step);
    return wide_select(wide_less(most, step), change * (most / step), change);
}

/* The same factor by the published program's rule, at the angle theta; *acts is narrowed to the hinges that it does not leave out. The
 * gradients of c and d are along the normals: sin theta by their product keeps its digits where they are nearly parallel. */
SN_INLINE wide published_change(const wide_point p[4], const wide_vec3 g[4], wide theta, wide rest, double gain, wide_mask *acts) {
    wide squares = wide_splat(0.0), weights = squares;
    SN_UNROLL
    for (int i = 0; i < 4; i++) squares = squares + wide_dot(g[i], g[i]), weights = weights + p[i].w;
    wide_vec3 normal = wide_cross(g[2], g[3]);
    wide sine2 = wide_dot(normal, normal) / (wide_dot(g[2], g[2]) * wide_dot(g[3], g[3])), sine = wide_sqrt(sine2);
    wide least = wide_splat(PUBLISHED_LEAST_SQUARE), q2 = sine2 * squares;
    q2 = wide_select(wide_less(q2, least), least, q2);
    wide lambda = wide_splat(4.0 * gain) * sine * (wide_abs(theta) - wide_abs(rest)) / (q2 * weights);
    *acts = *acts & wide_less(wide_splat(PUBLISHED_LEAST), lambda) & wide_less(lambda, wide_splat(PUBLISHED_MOST)) &
            wide_less(wide_splat(PUBLISHED_FLAT), sine2);
    return wide_copysign(lambda * sine, -theta);
}

/* Rows r .. r + lanes - 1, which share no point. */
SN_INLINE void project_hinges(const hinge_rows *in, sn_index r, const sn_sweep *sweep, int lanes, hinge_tally *out) {
    const sn_index *index = in->index + 4 * (size_t)r;
    wide_point p[4];
    wide_vec3 g[4];
    wide c, rest = wide_load(in->angles + r, lanes), compliance = wide_splat(sweep->compliance), change;
    SN_UNROLL
    for (int i = 0; i < 4; i++) p[i] = wide_gather(in->points, index + i, 4, lanes);
    wide_mask good = hinge(p, sweep->published ? wide_splat(0.0) : rest, &c, g), acts = good;
    wide lambda = sweep->first ? wide_splat(0.0) : wide_load(in->lambda + r, lanes);
    if (sweep->published) {
        change = published_change(p, g, c, rest, sweep->gain, &acts);
    } else {
        wide_mask far = wide_less(wide_splat(sweep->clamp), wide_abs(c)) & good;
        out->clamped += wide_count(far, lanes);
        c = wide_select(far, wide_copysign(wide_splat(sweep->clamp), c), c);
        if (in->softness != NULL) compliance = compliance * wide_load(in->softness + r, lanes);
        change = constraint_change(p, g, c, lambda, compliance, sweep);
    }
    wide_store(in->lambda + r, wide_select(acts, lambda + change, lambda), lanes);
    SN_UNROLL
    for (int i = 0; i < 4; i++) wide_scatter(in->points, index + i, 4, wide_move(p[i], g[i], p[i].w * change, acts), lanes);
    out->skipped += wide_count(~good, lanes);
}

SN_WIDE_KERNEL static hinge_tally sweep_hinges(const hinge_rows *in, sn_index batched, sn_index end, const sn_sweep *sweep) {
    hinge_tally out = {0, 0};
    sn_index r = 0;
    while (r < batched) {
        if (wide_takes(SN_BATCH_SINGLE) && in->pairs[r / SN_BATCH]) {
            project_hinges(in, r, sweep, SN_BATCH_SINGLE, &out);
            r += SN_BATCH_SINGLE;
        } else {
            project_hinges(in, r, sweep, WIDE_BATCH, &out);
            r += WIDE_BATCH;
        }
    }
    for (; r < end; r++) project_hinges(in, r, sweep, 1, &out);
    return out;
}

#endif
