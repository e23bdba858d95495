/* test_exact.c -- elementary functions: correct rounding where it is hardest, special values, errors of the quick ones, threads. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/exact.h"
#include "sinew/thread.h"

enum { SAMPLES = 20000 };

static double between(uint64_t *seed, double low, double high) { return low + (high - low) * sn_random(seed); }

/* sn_pow and sn_atan2 with one argument held. */
static double power_of_two(double x) { return sn_pow(2.0, x); }
static double arc_tangent(double x) { return sn_atan2(x, 1.0); }

/*
 * Arguments from the tables of V. Lefevre and J.-M. Muller, "Worst cases for correct rounding of the elementary functions in double
 * precision" (2003): the true value lies within 2^-49 to 2^-73 of a unit in the last place from where the rounding changes. The last rows
 * of exp are about the least subnormal: half of it is where 0 begins. The values were computed to 120 digits with decimal arithmetic, from
 * the series and by Newton's method, without MPFR.
 */
static const struct {
    double (*function)(double);
    double x, value;
} HARD[] = {
    {sn_exp, 0x1.9e9cbbfd6080bp-31, 0x1.000000033d398p+0},
    {sn_exp, -0x1.ed318efb627eap-27, 0x1.ffffff84b39c5p-1},
    {sn_exp, 0x1.d77fd13d27fffp-11, 0x1.003af6c37c1d3p+0},
    {sn_exp, 0x1.aca7ae8da5a7bp+0, 0x1.557d4acd7e557p+2},
    {sn_exp, 0x1.c44ce0d716a1ap+4, 0x1.b890ca8637ae2p+40},
    {sn_exp, -0x1.74385446d71c3p+9, 0x1p-1074},
    {sn_exp, -0x1.74910d52d3051p+9, 0x1p-1074},
    {sn_exp, -0x1.74910d52d3052p+9, 0.0},
    {sn_ln, 0x1.0000000000001p+0, 0x1.fffffffffffffp-53},
    {sn_ln, 0x1.91a8dff540ff7p+2, 0x1.d6336a88077aap+0},
    {sn_ln, 0x1.ac50b409c8aeep+8, 0x1.83d4bcdebb3f4p+2},
    {sn_sin, 0x1.e0000000001c2p-20, 0x1.dfffffffff02ep-20},
    {sn_sin, 0x1.9283586503fe0p-5, 0x1.9259e3708bd3ap-5},
    {sn_sin, 0x1.fe767739d0f6dp-2, 0x1.e9950730c4696p-2},
    {sn_sin, 0x1.d98c4c612718dp-1, 0x1.98dcd09337793p-1},
    {sn_sin, 0x1.6756745770a51p+1, 0x1.4ff350e412821p-2},
    {sn_cos, 0x1.2000000000f30p-18, 0x1.ffffffffebc00p-1},
    {sn_cos, 0x1.06b505550e6b2p-9, 0x1.ffffbc9a3fbfep-1},
    {sn_cos, 0x1.549ec0c0c5afap-5, 0x1.ff8eb6a91ecb0p-1},
    {sn_cos, 0x1.7cb7648526f99p-1, 0x1.78daf01036d0dp-1},
    {sn_cos, 0x1.6b8a6273d7c21p+0, 0x1.337fc5b072c53p-3},
    {sn_tan, 0x1.67fffffffa114p-18, 0x1.6800000008e62p-18},
    {sn_tan, 0x1.50486b2f87014p-5, 0x1.5078cebff9c73p-5},
    {sn_tan, 0x1.d696bfa988db9p-2, 0x1.fac71cd34eea7p-2},
    {sn_tan, 0x1.46ac372243536p-1, 0x1.7ba49f739829fp-1},
    {sn_acos, 0x1.fd737be914578p-11, 0x1.91e006d41d8d9p+0},
    {sn_acos, 0x1.4182199998587p-1, 0x1.c8a538ae83d1fp-1},
    {sn_acos, 0x1.e45a1c93651ecp-1, 0x1.520dc553f6b24p-2},
    {sn_acos, 0x1.f10fc61e2c78fp-1, 0x1.efeef61d39ac2p-3},
    {arc_tangent, 0x1.0fc9f1fabe658p-5, 0x1.0fb06ede9973ap-5},
    {arc_tangent, 0x1.5389e6df41979p-4, 0x1.52c39ef070cadp-4},
    {arc_tangent, 0x1.0f6e5d9960397p-2, 0x1.09544b71ad4a7p-2},
    {arc_tangent, 0x1.7ba49f739829fp-1, 0x1.46ac372243536p-1},
    {power_of_two, 0x1.16a76ec41b516p-1, 0x1.7550685a42c64p+0},
    {power_of_two, 0x1.3e34fa6ab969ep-1, 0x1.89d948a94fe17p+0},
    {power_of_two, 0x1.b32a6c92d1185p-1, 0x1.cd6b37edeceafp+0},
    {power_of_two, 0x1.25dd9eedac79ap+0, 0x1.1ba39ff28e3eap+1},
};

static void hard_cases_are_rounded_correctly(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof HARD / sizeof *HARD; i++)
        if (HARD[i].function(HARD[i].x) != HARD[i].value) fail_msg("row %zu: %a, not %a", i, HARD[i].function(HARD[i].x), HARD[i].value);
}

/* ---- against the C library ----------------------------------------------------------------------------------------------------- */

typedef double (*one_argument)(double);
typedef double (*two_arguments)(double, double);

static const struct {
    one_argument ours, theirs, quick;
    long double (*longer)(long double);
    double low, high;
} UNARY[] = {{sn_exp, exp, sn_quick_exp, expl, -740, 709}, {sn_ln, log, sn_quick_log, logl, 1e-3, 1e3},
             {sn_log2, log2, NULL, log2l, 1e-3, 1e3},      {sn_log10, log10, NULL, log10l, 1e-3, 1e3},
             {sn_sin, sin, NULL, sinl, -30, 30},           {sn_cos, cos, NULL, cosl, -30, 30},
             {sn_tan, tan, NULL, tanl, -30, 30},           {sn_acos, acos, NULL, acosl, -1, 1}};

static const struct {
    two_arguments ours, theirs, quick;
    long double (*longer)(long double, long double);
} BINARY[] = {{sn_atan2, atan2, sn_quick_atan2, atan2l}, {sn_pow, pow, NULL, powl}};

/* Error of a value in units of the true one's last place. */
static double units(double value, long double true_value) {
    double size = fabs((double)true_value), unit = fmax(nextafter(size, INFINITY) - size, 0x1p-1074);
    return (double)(fabsl((long double)value - true_value) / unit);
}

/* NaN for NaN, the sign of a zero, and no more than a unit apart. */
static void assert_like(double ours, double theirs, const char *what, double x, double y) {
    bool same = isnan(theirs) ? isnan(ours) : ours == theirs || units(ours, (long double)theirs) <= 1.0;
    if (!same || (!isnan(theirs) && !signbit(ours) != !signbit(theirs))) fail_msg("%s(%g, %g): %g, not %g", what, x, y, ours, theirs);
}

static const double SPECIAL[] = {0.0,       -0.0,  1.0,    -1.0,    2.0,      -2.0,  3.0,    -3.0, 0.5,      -0.5,      1e-320, -1e-320,
                                 0x1p-1022, 1e300, -1e300, DBL_MAX, -DBL_MAX, 750.0, -750.0, 1e22, INFINITY, -INFINITY, NAN};
enum { SPECIALS = sizeof SPECIAL / sizeof *SPECIAL };

static void special_values_are_those_of_c(void **state) {
    (void)state;
    for (size_t i = 0; i < SPECIALS; i++) {
        double x = SPECIAL[i];
        for (size_t f = 0; f < sizeof UNARY / sizeof *UNARY; f++) {
            assert_like(UNARY[f].ours(x), UNARY[f].theirs(x), "a function of exact.c", x, (double)f);
            if (UNARY[f].quick) assert_like(UNARY[f].quick(x), UNARY[f].theirs(x), "a function of quick.c", x, (double)f);
        }
        for (size_t k = 0; k < SPECIALS; k++)
            for (size_t f = 0; f < sizeof BINARY / sizeof *BINARY; f++) {
                assert_like(BINARY[f].ours(x, SPECIAL[k]), BINARY[f].theirs(x, SPECIAL[k]), "a function of exact.c", x, SPECIAL[k]);
                if (BINARY[f].quick)
                    assert_like(BINARY[f].quick(x, SPECIAL[k]), BINARY[f].theirs(x, SPECIAL[k]), "a function of quick.c", x, SPECIAL[k]);
            }
    }
    double sine, cosine;
    sn_sincos(2.0, &sine, &cosine);
    assert_true(sine == sn_sin(2.0) && cosine == sn_cos(2.0));
}

/* Half a unit, and what long double is itself wrong by: it has eleven bits more. */
static const double HALF = 0.5 + 0x1p-9;

static void every_value_is_the_nearest_double(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < SAMPLES; i++) {
        for (size_t f = 0; f < sizeof UNARY / sizeof *UNARY; f++) {
            double x = between(&seed, UNARY[f].low, UNARY[f].high);
            if (units(UNARY[f].ours(x), UNARY[f].longer(x)) > HALF) fail_msg("function %zu at %a", f, x);
        }
        double y = between(&seed, -3, 3), x = between(&seed, -3, 3);
        if (units(sn_atan2(y, x), atan2l(y, x)) > HALF) fail_msg("atan2(%a, %a)", y, x);
        if (units(sn_pow(fabs(x), y), powl(fabs(x), y)) > HALF) fail_msg("pow(%a, %a)", fabs(x), y);
    }
}

/* Of any size, where digits are lost if any are. */
static double of_any_size(uint64_t *seed) { return between(seed, -1, 1) * ldexp(1.0, (int)between(seed, -60, 60)); }

static void quick_functions_keep_their_bounds(void **state) {
    (void)state;
    uint64_t seed = 2;
    double angle = 0.0, exponential = 0.0, logarithm = 0.0, power = 0.0;
    for (int i = 0; i < 20 * SAMPLES; i++) {
        double x = of_any_size(&seed), y = i % 2 ? of_any_size(&seed) : between(&seed, -2, 2) * x;
        angle = fmax(angle, units(sn_quick_atan2(y, x), atan2l(y, x)));
        double e = i % 2 ? between(&seed, -708, 709) : between(&seed, -2, 2);
        exponential = fmax(exponential, units(sn_quick_exp(e), expl(e)));
        double l = i % 2 ? ldexp(between(&seed, 1, 2), (int)between(&seed, -1022, 1023)) : between(&seed, 0.5, 2);
        logarithm = fmax(logarithm, units(sn_quick_log(l), logl(l)));
        double base = sn_random(&seed), exponent = between(&seed, 0.01, 10);
        double excess = units(sn_quick_pow(base, exponent), powl(base, exponent)) - 3.0 * fabs(exponent * log(base));
        power = fmax(power, excess);
    }
    if (!(angle < 2.5 && exponential < 1.0 && logarithm < 1.0 && power < 2.0))
        fail_msg("atan2 %g, exp %g, log %g, pow %g units", angle, exponential, logarithm, power);
    assert_true(sn_quick_pow(0.0, 0.4) == 0.0 && sn_quick_pow(1.0, 7.0) == 1.0);
}

static void quick_sine_and_cosine_keep_their_bounds(void **state) {
    (void)state;
    uint64_t seed = 3;
    double worst = 0.0, s, c;
    for (int i = 0; i < 20 * SAMPLES; i++) {
        double quarters = floor(between(&seed, -6000, 6000)) * 0.5 * 3.14159265358979323846; /* where digits are lost if any are */
        double x = i % 4 == 0 ? of_any_size(&seed) : i % 4 == 1 ? quarters : i % 4 == 2 ? between(&seed, -7, 7) : between(&seed, -1e4, 1e4);
        sn_quick_sincos(x, &s, &c);
        worst = fmax(worst, fabs(x) <= 1e4 ? fmax(units(s, sinl((long double)x)), units(c, cosl((long double)x))) : 0.0);
        if (!(worst < 1.0)) fail_msg("at %a: %g units", x, worst);
    }
    for (size_t i = 0; i < SPECIALS; i++) {
        sn_quick_sincos(SPECIAL[i], &s, &c);
        assert_like(s, sn_sin(SPECIAL[i]), "sn_quick_sincos", SPECIAL[i], 0.0);
        assert_like(c, sn_cos(SPECIAL[i]), "sn_quick_sincos", SPECIAL[i], 1.0);
    }
}

/* ---- threads --------------------------------------------------------------------------------------------------------------------- */

static void fill(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    double *values = user;
    for (sn_index i = begin; i < end; i++) values[i] = sn_pow(sn_exp(-0.01 * i), 0.8) + sn_acos(sn_sin(i));
}

/* Every thread has its own pi and ln 2 (AddressSanitizer's build tells of those that nobody frees). */
static void threads_get_the_same(void **state) {
    (void)state;
    static double one[SAMPLES], four[SAMPLES];
    sn_pool *pool = sn_pool_create(4);
    sn_parallel_for(NULL, SAMPLES, 64, fill, one);
    sn_parallel_for(pool, SAMPLES, 64, fill, four);
    sn_pool_destroy(pool);
    assert_memory_equal(one, four, sizeof one);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hard_cases_are_rounded_correctly),        cmocka_unit_test(special_values_are_those_of_c),
        cmocka_unit_test(every_value_is_the_nearest_double),       cmocka_unit_test(quick_functions_keep_their_bounds),
        cmocka_unit_test(quick_sine_and_cosine_keep_their_bounds), cmocka_unit_test(threads_get_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
