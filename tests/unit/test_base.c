/* test_base.c -- status, memory, numbers in text, hash, trace, threads. */
#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/numeric.h"
#include "sinew/thread.h"
#include "sinew/trace.h"

static void error_keeps_its_file(void **state) {
    (void)state;
    sn_error error = {0};
    sn_error_set_file(&error, "a.ply");
    assert_int_equal(sn_fail(&error, SN_ERROR_INPUT, "vertex %d is bad", 7), SN_ERROR_INPUT);
    assert_string_equal(error.file, "a.ply");
    assert_string_equal(error.text, "vertex 7 is bad");
    assert_int_equal(sn_fail(NULL, SN_ERROR_IO, "nobody listens"), SN_ERROR_IO);
    sn_fail(&error, SN_ERROR_INPUT, "%s again", error.text); /* an argument may be the error's own text */
    assert_string_equal(error.text, "vertex 7 is bad again");
}

static void allocation_refuses_overflow(void **state) {
    (void)state;
    assert_null(sn_alloc(SIZE_MAX / 2, 3));
    void *none = sn_alloc(0, 8);
    assert_non_null(none);
    free(none);
    int *items = NULL;
    size_t capacity = 0;
    for (size_t i = 0; i < 1000; i++) {
        assert_true(sn_grow((void **)&items, &capacity, i + 1, sizeof *items));
        items[i] = (int)i;
    }
    assert_int_equal(items[999], 999);
    assert_false(sn_grow((void **)&items, &capacity, SIZE_MAX / 2, sizeof *items));
    free(items);
}

/* Every number is read as strtod reads it: exact fast path, many digits, extreme exponents. */
static void numbers_scan_like_strtod(void **state) {
    (void)state;
    const char *const texts[] = {"0",
                                 "-0",
                                 "1",
                                 "0.1",
                                 "-2.5e-3",
                                 "123456789.123456789",
                                 "9007199254740993",
                                 "1e22",
                                 "1e23",
                                 "1e-22",
                                 "1e308",
                                 "1e-320",
                                 "1e400",
                                 ".5",
                                 "5.",
                                 "0.30000000000000004441",
                                 "17976931348623157e292",
                                 "4.9406564584124654e-324",
                                 "1.7976931348623157e308",
                                 "00012.50"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        const char *next;
        double value;
        assert_true(sn_scan_number(texts[i], texts[i] + strlen(texts[i]), &next, &value));
        assert_ptr_equal(next, texts[i] + strlen(texts[i]));
        double expected = strtod(texts[i], NULL);
        assert_memory_equal(&value, &expected, sizeof value);
    }
}

/* Random bit patterns survive writing and reading, in a comma locale too. */
static void numbers_round_trip(void **state) {
    (void)state;
    setlocale(LC_ALL, "de_DE.UTF-8"); /* where it is installed */
    uint64_t seed = 1;
    for (int i = 0; i < 200000; i++) {
        double value = (sn_random(&seed) - 0.5) * pow(10.0, floor(sn_random(&seed) * 600.0 - 300.0));
        if (i % 3 == 0) value = (double)(float)value;
        char text[32];
        int length = sn_format_number(value, text);
        assert_int_equal(length, (int)strlen(text));
        const char *next;
        double back;
        assert_true(sn_scan_number(text, text + length, &next, &back));
        assert_true(back == value);
    }
    char text[32];
    sn_format_number(-0.0, text);
    assert_string_equal(text, "0");
    sn_format_number(0.1, text);
    assert_string_equal(text, "0.1");
    sn_format_number(-12345678.0, text);
    assert_string_equal(text, "-12345678");
    sn_format_number(-0.00005, text);
    assert_string_equal(text, "-0.00005");
    sn_format_number(20.0, text);
    assert_string_equal(text, "20");
    sn_format_number(1013.25, text);
    assert_string_equal(text, "1013.25");
    setlocale(LC_ALL, "C");
}

static void scanning_stops_at_the_end(void **state) {
    (void)state;
    const char text[] = "12.5e3";
    const char *next;
    double value;
    assert_true(sn_scan_number(text, text + 3, &next, &value)); /* "12." */
    assert_true(value == 12.0);
    assert_true(sn_scan_number(text, text + 5, &next, &value)); /* "12.5e" is 12.5 and an e */
    assert_true(value == 12.5 && next == text + 4);
    assert_false(sn_scan_number("-", "-" + 1, &next, &value));
    assert_false(sn_scan_number("e5", "e5" + 2, &next, &value));
    assert_true(sn_scan_number("-Inf", "-Inf" + 4, &next, &value) && isinf(value) && value < 0);
    int64_t integer;
    const char least[] = "-9223372036854775808", past[] = "9223372036854775808";
    assert_true(sn_scan_integer(least, least + sizeof least - 1, &next, &integer) && integer == INT64_MIN);
    assert_false(sn_scan_integer(past, past + sizeof past - 1, &next, &integer));
}

static void options_parse_strictly(void **state) {
    (void)state;
    sn_error error = {0};
    double number, three[3];
    int64_t integer;
    sn_length length;
    assert_int_equal(sn_parse_number("1.5", &number, &error), SN_OK);
    const char *const bad_numbers[] = {"", "1.5x", " 1", "1 ", "nan", "inf", "0x10", "1,5", "--1"};
    for (size_t i = 0; i < sizeof bad_numbers / sizeof *bad_numbers; i++)
        assert_int_equal(sn_parse_number(bad_numbers[i], &number, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_integer("12", 0, 12, &integer, &error), SN_OK);
    assert_int_equal(sn_parse_integer("13", 0, 12, &integer, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_integer("1e1", 0, 12, &integer, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_numbers("1,2,3", 3, three, &error), SN_OK);
    assert_true(three[2] == 3.0);
    assert_int_equal(sn_parse_numbers("1,2", 3, three, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_numbers("1,2,3,4", 3, three, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_numbers("1,,3", 3, three, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_length("6mm", &length, &error), SN_OK);
    assert_true(fabs(sn_length_meters(length, 1.0) - 0.006) < 1e-18);
    assert_int_equal(sn_parse_length("6", &length, &error), SN_OK);
    assert_true(fabs(sn_length_meters(length, 0.001) - 0.006) < 1e-18);
    assert_int_equal(sn_parse_length("6 mm", &length, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_parse_length("6yd", &length, &error), SN_ERROR_USAGE);
}

/* FIPS 180-4's example. */
static void hash_is_sha256(void **state) {
    (void)state;
    char hash[SN_HASH_LENGTH];
    sn_hash("abc", 3, hash);
    assert_string_equal(hash, "sha256:ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static void count_step(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    assert_string_equal(stage, "front");
    assert_int_equal(value_count, 2);
    assert_true(values[0].number == 3.0);
    *(int64_t *)user = number;
}

static void trace_stops_where_asked(void **state) {
    (void)state;
    int64_t last = 0;
    sn_trace trace = {.receive = count_step, .user = &last, .stop_after = 3};
    const sn_index indices[] = {4, 5};
    int done = 0;
    do done++;
    while (!SN_TRACE(&trace, "front", sn_trace_number("vertices", 3), sn_trace_indices("front", indices, 2)));
    assert_int_equal(done, 3);
    assert_int_equal(last, 3);
    assert_true(sn_trace_stopped(&trace));
    assert_false(SN_TRACE(NULL, "front", sn_trace_number("x", 0)));
    sn_trace none = {.stop_after = 0};
    assert_true(sn_trace_stopped(&none));
}

typedef struct sum_job {
    const double *values;
    double partial[64];
} sum_job;

static void sum_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    sum_job *job = user;
    for (sn_index i = begin; i < end; i++) job->partial[chunk] += job->values[i];
}

static double parallel_sum(const double *values, sn_index count, int threads) {
    sum_job job = {.values = values};
    sn_pool *pool = threads > 0 ? sn_pool_create(threads) : NULL;
    for (int repeat = 0; repeat < 200; repeat++) {
        memset(job.partial, 0, sizeof job.partial);
        sn_parallel_for(pool, count, 157, sum_range, &job);
    }
    sn_pool_destroy(pool);
    double sum = 0.0;
    for (sn_index chunk = 0; chunk < sn_chunk_count(count, 157); chunk++) sum += job.partial[chunk];
    return sum;
}

static void threads_do_not_change_bits(void **state) {
    (void)state;
    double values[10000];
    uint64_t seed = 5;
    for (int i = 0; i < 10000; i++) values[i] = sn_random(&seed) * 1e-3 + 1.0 / (i + 1);
    double one = parallel_sum(values, 10000, 0);
    for (int threads = 1; threads <= 4; threads++) assert_true(parallel_sum(values, 10000, threads) == one);
    assert_true(parallel_sum(values, 0, 2) == 0.0);
}

/* Steffen's curve stays inside its data where a cubic spline overshoots; the ends hold. */
static void curve_is_monotone(void **state) {
    (void)state;
    const double x[] = {0, 1, 2, 3, 4}, y[] = {0, 0, 1, 1, 1};
    sn_curve *curve;
    sn_error error = {0};
    assert_int_equal(sn_curve_create(5, x, y, &curve, &error), SN_OK);
    double before = -1.0;
    for (double at = -1.0; at <= 6.0; at += 0.01) {
        double value = sn_curve_at(curve, at);
        assert_true(value >= 0.0 && value <= 1.0 && value >= before);
        before = value;
    }
    assert_true(sn_curve_at(curve, 2.0) == 1.0 && sn_curve_at(curve, 99.0) == 1.0);
    sn_curve_destroy(curve);
    assert_int_equal(sn_curve_create(2, x, y, &curve, &error), SN_OK);
    assert_true(sn_curve_at(curve, 0.5) == 0.0);
    sn_curve_destroy(curve);
    const double back[] = {0, 2, 1};
    assert_int_equal(sn_curve_create(3, back, y, &curve, &error), SN_ERROR_INPUT);
}

/* A v = lambda v, ascending. */
static void eigenvectors_solve(void **state) {
    (void)state;
    const sn_mat3 a = {{{4, 1, 0.5}, {1, 3, -0.25}, {0.5, -0.25, 9}}};
    double values[3];
    sn_mat3 v;
    assert_true(sn_eigen_symmetric3(&a, values, &v));
    assert_true(values[0] <= values[1] && values[1] <= values[2]);
    for (int k = 0; k < 3; k++) {
        sn_vec3 column = sn_v3(v.m[0][k], v.m[1][k], v.m[2][k]);
        assert_true(sn_distance(sn_mat3_apply(&a, column), sn_scale(column, values[k])) < 1e-12);
        assert_true(fabs(sn_norm(column) - 1.0) < 1e-12);
    }
    const sn_mat3 bad = {{{NAN, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    assert_false(sn_eigen_symmetric3(&bad, values, &v));
}

/* Two wild outliers do not move the robust line. */
static void robust_fit_ignores_outliers(void **state) {
    (void)state;
    double x[12], y[12], intercept, slope;
    for (int i = 0; i < 12; i++) {
        x[i] = i;
        y[i] = 1.0 + 2.0 * i + 1e-3 * ((i % 3) - 1);
    }
    y[3] = 60.0;
    y[10] = -40.0;
    assert_true(sn_fit_line_robust(12, x, y, &intercept, &slope));
    assert_true(fabs(slope - 2.0) < 1e-2 && fabs(intercept - 1.0) < 1e-2);
    const double constant[] = {1, 1, 1, 1};
    assert_false(sn_fit_line_robust(4, constant, y, &intercept, &slope));
}

/* A quaternion turns as its angle says; a rigid motion and its inverse cancel. */
static void rigid_motions_invert(void **state) {
    (void)state;
    sn_rigid turn = {sn_quat_axis_angle(sn_v3(0, 0, 1), SN_PI / 2), sn_v3(1, 2, 3)};
    assert_true(sn_distance(sn_rigid_apply(turn, sn_v3(1, 0, 0)), sn_v3(1, 3, 3)) < 1e-15);
    sn_vec3 p = sn_v3(0.3, -7, 2);
    assert_true(sn_distance(sn_rigid_apply(sn_rigid_inverse(turn), sn_rigid_apply(turn, p)), p) < 1e-14);
    sn_quat half = sn_quat_slerp(sn_quat_identity(), turn.rotation, 0.5);
    assert_true(sn_distance(sn_quat_rotate(half, sn_v3(1, 0, 0)), sn_v3(sqrt(0.5), sqrt(0.5), 0)) < 1e-15);
}

/* Nobody is told that he meant something else altogether. */
static void mistyped_words_are_found(void **state) {
    (void)state;
    const char *const known[] = {"method", "metersPerUnit", "mm", "iterations", "obj", NULL};
    const struct {
        const char *word, *meant;
    } cases[] = {{"metod", "method"},
                 {"mehtod", "method"},
                 {"METHOD", "method"},
                 {"meters_per_unit", "metersPerUnit"},
                 {"iteration", "iterations"},
                 {"cm", NULL},
                 {"off", NULL},
                 {"colour", NULL},
                 {"", NULL},
                 {"__", NULL},
                 {"m", NULL},
                 {"objj", "obj"},
                 {"iterationsiterations", NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *nearest = sn_nearest_word(cases[i].word, SIZE_MAX, known);
        assert_true((nearest == NULL) == (cases[i].meant == NULL));
        if (nearest != NULL) assert_string_equal(nearest, cases[i].meant);
    }
    assert_string_equal(sn_nearest_word("metod=3", 5, known), "method");
    char endless[5000];
    memset(endless, 'm', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    assert_null(sn_nearest_word(endless, SIZE_MAX, known));
    assert_int_equal(sn_word_distance("kitten", SIZE_MAX, "kittne"), 1); /* a swap is one edit */
    assert_int_equal(sn_word_distance("kitten", SIZE_MAX, "sitting"), INT_MAX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_keeps_its_file),
        cmocka_unit_test(allocation_refuses_overflow),
        cmocka_unit_test(numbers_scan_like_strtod),
        cmocka_unit_test(numbers_round_trip),
        cmocka_unit_test(scanning_stops_at_the_end),
        cmocka_unit_test(options_parse_strictly),
        cmocka_unit_test(hash_is_sha256),
        cmocka_unit_test(trace_stops_where_asked),
        cmocka_unit_test(threads_do_not_change_bits),
        cmocka_unit_test(curve_is_monotone),
        cmocka_unit_test(eigenvectors_solve),
        cmocka_unit_test(robust_fit_ignores_outliers),
        cmocka_unit_test(rigid_motions_invert),
        cmocka_unit_test(mistyped_words_are_found),
    };
    return cmocka_run_group_tests_name("base", tests, NULL, NULL);
}
