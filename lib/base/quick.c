/* quick.c -- elementary functions for inner loops, of + - * / and sqrt alone: a few units in the last place, the same on every machine. */
#include "sinew/exact.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ln 2 in two pieces: k times the first is exact for |k| < 2^20. */
static const double LN2_HIGH = 0x1.62e42feep-1, LN2_LOW = 0x1.a39ef35793c76p-33;

/* pi in two pieces. */
static const double PI = 3.14159265358979323846, PI_LOW = 1.2246467991473531772e-16;

static uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double of_bits(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static double power_of_two(int64_t k) { return of_bits((uint64_t)(1023 + k) << 52); } /* -1022 <= k <= 1023 */

/* atan t for |t| <= 0.66: t + t z P(z) / Q(z), z = t^2; the coefficients are those of Moshier's Cephes library, as in the hinges' rows. */
static double arc_tangent(double t) {
    double z = t * t;
    double p = ((((-8.750608600031904122785e-1 * z + -1.615753718733365076637e1) * z + -7.500855792314704667340e1) * z +
                 -1.228866684490136173410e2) *
                    z +
                -6.485021904942025371773e1);
    double q = (((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z +
                 4.853903996359136964868e2) *
                    z +
                1.945506571482613964425e2);
    return t + t * (z * p / q);
}

/* Of no vector and of infinite ones, as atan2 has it; huge ones a power of two smaller. */
static double angle_of_extreme(double y, double x) {
    if (isnan(x) || isnan(y)) return x + y;
    if (isinf(x) || isinf(y)) return sn_quick_atan2(copysign(isinf(y), y), copysign(isinf(x), x));
    if (y != 0.0 || x != 0.0) return sn_quick_atan2(0x1p-64 * y, 0x1p-64 * x);
    return copysign(signbit(x) ? PI : 0.0, y);
}

double sn_quick_atan2(double y, double x) {
    double s = fabs(y), c = fabs(x), low = s < c ? s : c, high = s < c ? c : s;
    if (!(high > 0.0 && high < 1e300 && low >= 0.0)) return angle_of_extreme(y, x);
    /* tan pi/8: beyond it atan(low/high) = pi/4 + atan((low - high)/(low + high)) */
    double angle = low > 0.41421356237309504880 * high ? 0.25 * PI + (arc_tangent((low - high) / (low + high)) + 0.25 * PI_LOW)
                                                       : arc_tangent(low / high);
    if (c < s) angle = 0.5 * PI - (angle - 0.5 * PI_LOW);
    if (signbit(x)) angle = PI - (angle - PI_LOW);
    return copysign(angle, y);
}

/* x = k ln 2 + r, |r| <= ln 2 / 2: 2^k (1 + r + r^2/2 + ... + r^13/13!). */
double sn_quick_exp(double x) {
    if (!(x <= 710.0)) return x + INFINITY; /* of a NaN NaN */
    if (x < -746.0) return 0.0;
    double k = floor(x * 1.44269504088896340736 + 0.5), high = x - k * LN2_HIGH, low = k * LN2_LOW;
    double r = high - low, lost = (high - r) - low, sum = 1.0 / 6227020800.0;
    static const double INVERSE_FACTORIAL[] = {1.0 / 2,     1.0 / 6,      1.0 / 24,      1.0 / 120,      1.0 / 720,      1.0 / 5040,
                                               1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600};
    for (int i = 10; i >= 0; i--) sum = sum * r + INVERSE_FACTORIAL[i];
    double half = floor(0.5 * k); /* 2^k alone may overflow */
    return power_of_two((int64_t)half) * ((1.0 + (r + (r * r * sum + lost))) * power_of_two((int64_t)(k - half)));
}

static double log_of_extreme(double x) {
    if (x > 0.0) return x <= DBL_MAX ? sn_quick_log(0x1p64 * x) - 64.0 * LN2_HIGH - 64.0 * LN2_LOW : x;
    return x == 0.0 ? -INFINITY : NAN;
}

/* x = 2^k m, m in [1/sqrt 2, sqrt 2); with s = f/(2 + f), f = m - 1: ln m = f - f^2/2 + s (f^2/2 + R), R = 2 s^2/3 + 2 s^4/5 + ... */
double sn_quick_log(double x) {
    if (!(x >= DBL_MIN && x <= DBL_MAX)) return log_of_extreme(x);
    const uint64_t ROOT_HALF = 0x3fe6a09e667f3bcd;
    int64_t k = (int64_t)(bits_of(x) - ROOT_HALF) >> 52;
    double f = of_bits(bits_of(x) - ((uint64_t)k << 52)) - 1.0, s = f / (2.0 + f), z = s * s, sum = 2.0 / 21.0;
    for (int i = 19; i > 1; i -= 2) sum = sum * z + 2.0 / i;
    double half = 0.5 * f * f, power = (double)k;
    return power * LN2_HIGH - ((half - (s * (half + z * sum) + power * LN2_LOW)) - f);
}

double sn_quick_pow(double x, double y) { return sn_quick_exp(y * sn_quick_log(x)); }
