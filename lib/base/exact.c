/* exact.c -- correctly rounded elementary functions (the only user of MPFR in C). */
#include "sinew/exact.h"

#include <mpfr.h>
#include <pthread.h>
#include <stdlib.h>

enum { DOUBLE_BITS = 53, LEAST_EXPONENT = -1073, GREATEST_EXPONENT = 1024 }; /* of doubles as MPFR writes them: 0.1...b x 2^e */

/* A double as MPFR holds it: its limbs are on the stack. */
typedef struct number {
    mpfr_t value;
    mp_limb_t limbs[(DOUBLE_BITS + GMP_NUMB_BITS - 1) / GMP_NUMB_BITS];
} number;

/* ---- MPFR's caches --------------------------------------------------------------------------------------------------------------- */

/* MPFR keeps pi and ln 2 for every thread: they go when the thread ends, and the first one's when the program does. */
static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_key_t key;
static _Thread_local bool registered;

static void free_cache(void *unused) {
    (void)unused;
    mpfr_free_cache();
}

static void free_last_cache(void) { mpfr_free_cache(); }

static void prepare(void) {
    pthread_key_create(&key, free_cache);
    atexit(free_last_cache);
}

static void register_thread(void) {
    pthread_once(&once, prepare);
    pthread_setspecific(key, &registered); /* any pointer but NULL: its destructor runs */
    registered = true;
}

/* ---- one call ---------------------------------------------------------------------------------------------------------------------- */

/* The exponents that a number may have while one call runs: those of doubles, so that what MPFR rounds is a double. */
typedef struct exponents {
    mpfr_exp_t least, greatest;
} exponents;

static exponents begin(void) {
    if (!registered) register_thread();
    exponents callers = {mpfr_get_emin(), mpfr_get_emax()};
    mpfr_set_emin(LEAST_EXPONENT);
    mpfr_set_emax(GREATEST_EXPONENT);
    return callers;
}

static void number_init(number *n, double x) {
    mpfr_custom_init(n->limbs, DOUBLE_BITS);
    mpfr_custom_init_set(n->value, MPFR_NAN_KIND, 0, DOUBLE_BITS, n->limbs);
    mpfr_set_d(n->value, x, MPFR_RNDN); /* exact */
}

/* `rounding` is what MPFR returned: on which side of the true value the result is. A subnormal is rounded once more, as if for the first
 * time. */
static double end(number *result, int rounding, exponents callers) {
    mpfr_subnormalize(result->value, rounding, MPFR_RNDN);
    double value = mpfr_get_d(result->value, MPFR_RNDN);
    mpfr_set_emin(callers.least);
    mpfr_set_emax(callers.greatest);
    return value;
}

typedef int (*unary)(mpfr_ptr result, mpfr_srcptr x, mpfr_rnd_t rounding);
typedef int (*binary)(mpfr_ptr result, mpfr_srcptr x, mpfr_srcptr y, mpfr_rnd_t rounding);

static double call(unary function, double x) {
    exponents callers = begin();
    number a, result;
    number_init(&a, x);
    number_init(&result, 0.0);
    return end(&result, function(result.value, a.value, MPFR_RNDN), callers);
}

static double call2(binary function, double x, double y) {
    exponents callers = begin();
    number a, b, result;
    number_init(&a, x);
    number_init(&b, y);
    number_init(&result, 0.0);
    return end(&result, function(result.value, a.value, b.value, MPFR_RNDN), callers);
}

double sn_exp(double x) { return call(mpfr_exp, x); }
double sn_ln(double x) { return call(mpfr_log, x); }
double sn_log2(double x) { return call(mpfr_log2, x); }
double sn_log10(double x) { return call(mpfr_log10, x); }
double sn_sin(double x) { return call(mpfr_sin, x); }
double sn_cos(double x) { return call(mpfr_cos, x); }
void sn_sincos(double x, double *sine, double *cosine) {
    *sine = sn_sin(x);
    *cosine = sn_cos(x);
}

double sn_tan(double x) { return call(mpfr_tan, x); }
double sn_acos(double x) { return call(mpfr_acos, x); }
double sn_atan2(double y, double x) { return call2(mpfr_atan2, y, x); }
double sn_pow(double x, double y) { return call2(mpfr_pow, x, y); }
