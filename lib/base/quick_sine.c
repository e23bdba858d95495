/* quick_sine.c -- sine and cosine for inner loops. Apart from quick.c, whose users need no MPFR. */
#include "sinew/exact.h"

#include <math.h>

/* pi/2 in three pieces of 33, 33 and 53 bits: k times the first two is exact for |k| < 2^20, and what the third lacks shows beyond 1e5
 * (Cody & Waite 1980; the pieces of fdlibm). */
static const double HALF_PI_1 = 0x1.921fb544p+0, HALF_PI_2 = 0x1.0b4611a6p-34, HALF_PI_3 = 0x1.3198a2e037073p-69;

/* a + b rounded, and what the rounding lost (Knuth 1969). */
static double sum_exactly(double a, double b, double *lost) {
    double sum = a + b, of_b = sum - a;
    *lost = (a - (sum - of_b)) + (b - of_b);
    return sum;
}

/* sin(r + tail) and cos(r + tail), |r| <= pi/4, by fdlibm's polynomials. */
static double sine_near_zero(double r, double tail) {
    double z = r * r, v = z * r;
    double p = 8.33333333332248946124e-03 +
               z * (-1.98412698298579493134e-04 +
                    z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
    return r - ((z * (0.5 * tail - v * p) - tail) - v * -1.66666666666666324348e-01);
}

static double cosine_near_zero(double r, double tail) {
    double z = r * r, half = 0.5 * z, w = 1.0 - half;
    double p = z * (4.16666666666666019037e-02 +
                    z * (-1.38888888888741095749e-03 +
                         z * (2.48015872894767294178e-05 +
                              z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    return w + (((1.0 - w) - half) + (z * p - r * tail));
}

void sn_quick_sincos(double x, double *sine, double *cosine) {
    if (!(fabs(x) <= 1e4) || fabs(x) < 1e-8) { /* a small sine keeps the digits of x, also of a subnormal one */
        sn_sincos(x, sine, cosine);
        return;
    }
    double k = floor(x * 0.63661977236758134308 + 0.5), lost, tail;
    double b = sum_exactly(x - k * HALF_PI_1, -k * HALF_PI_2, &lost), r = sum_exactly(b, lost - k * HALF_PI_3, &tail);
    double s = sine_near_zero(r, tail), c = cosine_near_zero(r, tail);
    int64_t quarter = (int64_t)k & 3;
    *sine = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
    *cosine = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
}
