/* Sparse factor and solve: exact solutions, what is rejected, and the same bits however it is asked. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/sparse.h"
#include "sinew/vec.h"

enum { N = 200 };

/* -u'' = f on a line of N inner points, spacing 1 / (N + 1): 2 on the diagonal, -1 beside it. The off-diagonal ones alternate between the
 * triangles. */
static sn_index line_laplacian(sn_entry *entries, double shift) {
    sn_index count = 0;
    for (sn_index i = 0; i < N; i++) {
        entries[count++] = (sn_entry){i, i, 1.5 + shift};
        entries[count++] = (sn_entry){i, i, 0.5};
        if (i > 0) entries[count++] = i % 2 ? (sn_entry){i, i - 1, -1.0} : (sn_entry){i - 1, i, -1.0};
    }
    return count;
}

static sn_sparse *factor(sn_index n, sn_index count, const sn_entry *entries) {
    sn_sparse *f = NULL;
    sn_error error = {0};
    if (sn_sparse_factor(n, count, entries, &f, &error)) fail_msg("%s", error.text);
    return f;
}

static void constant_load_gives_the_parabola(void **state) {
    (void)state;
    sn_entry entries[3 * N];
    sn_sparse *f = factor(N, line_laplacian(entries, 0.0), entries);
    double x[N], h = 1.0 / (N + 1);
    for (int i = 0; i < N; i++) x[i] = h * h;
    assert_int_equal(sn_sparse_solve(f, 1, x, x, NULL), SN_OK);
    for (int i = 0; i < N; i++) { /* u = s (1 - s) / 2, which the second difference reproduces exactly */
        double s = h * (i + 1);
        assert_true(fabs(x[i] - 0.5 * s * (1.0 - s)) < 1e-12);
    }
    sn_sparse_destroy(f);
}

static void several_columns_are_the_single_ones(void **state) {
    (void)state;
    sn_entry entries[3 * N];
    sn_sparse *f = factor(N, line_laplacian(entries, 0.1), entries);
    double *b = SN_NEW(double, 5 * N), *all = SN_NEW(double, 5 * N), one[N];
    uint64_t seed = 1;
    for (int i = 0; i < 5 * N; i++) b[i] = sn_random(&seed) - 0.5;
    assert_int_equal(sn_sparse_solve(f, 5, b, all, NULL), SN_OK);
    for (int c = 0; c < 5; c++) {
        assert_int_equal(sn_sparse_solve(f, 1, b + c * N, one, NULL), SN_OK);
        for (int i = 0; i < N; i++) assert_true(fabs(one[i] - all[c * N + i]) < 1e-13);
    }
    free(b);
    free(all);
    sn_sparse_destroy(f);
}

/* A grid fills its factor, so that neighbouring columns share their rows; three and six columns take another way than one does. */
static void points_are_solved_as_single_columns_are(void **state) {
    (void)state;
    enum { SIDE = 23, SIZE = SIDE * SIDE };
    sn_entry *entries = SN_NEW(sn_entry, 3 * SIZE);
    double *b = SN_NEW(double, 6 * SIZE), *six = SN_NEW(double, 6 * SIZE), *three = SN_NEW(double, 6 * SIZE), one[SIZE];
    sn_index count = 0;
    uint64_t seed = 3;
    for (sn_index i = 0; i < SIZE; i++) {
        entries[count++] = (sn_entry){i, i, 4.1};
        if (i % SIDE > 0) entries[count++] = (sn_entry){i, i - 1, -1.0};
        if (i >= SIDE) entries[count++] = (sn_entry){i, i - SIDE, -1.0};
    }
    for (int i = 0; i < 6 * SIZE; i++) b[i] = sn_random(&seed) - 0.5;
    sn_sparse *f = factor(SIZE, count, entries);
    assert_int_equal(sn_sparse_solve(f, 6, b, six, NULL), SN_OK);
    for (int half = 0; half < 2; half++) assert_int_equal(sn_sparse_solve(f, 3, b + 3 * half * SIZE, three + 3 * half * SIZE, NULL), SN_OK);
    assert_memory_equal(three, six, 6 * SIZE * sizeof *six);
    for (int c = 0; c < 6; c++) {
        assert_int_equal(sn_sparse_solve(f, 1, b + c * SIZE, one, NULL), SN_OK);
        for (int i = 0; i < SIZE; i++) assert_true(fabs(one[i] - six[c * SIZE + i]) < 1e-13);
    }
    free(entries);
    free(b);
    free(six);
    free(three);
    sn_sparse_destroy(f);
}

static void a_refactor_is_a_fresh_factor(void **state) {
    (void)state;
    sn_entry before[3 * N], after[3 * N];
    sn_index count = line_laplacian(before, 0.0);
    line_laplacian(after, 0.7);
    sn_sparse *reused = factor(N, count, before), *fresh = factor(N, count, after);
    double b[N], x[N], y[N];
    for (int i = 0; i < N; i++) b[i] = i % 7 - 3.0;
    assert_int_equal(sn_sparse_refactor(reused, after, NULL), SN_OK);
    assert_int_equal(sn_sparse_solve(reused, 1, b, x, NULL), SN_OK);
    assert_int_equal(sn_sparse_solve(fresh, 1, b, y, NULL), SN_OK);
    assert_memory_equal(x, y, sizeof x);
    sn_sparse_destroy(reused);
    sn_sparse_destroy(fresh);
}

static void an_indefinite_matrix_names_its_row(void **state) {
    (void)state;
    sn_entry entries[] = {{0, 0, 1}, {1, 1, 1}, {2, 2, -1}, {3, 3, 1}};
    sn_sparse *f = NULL;
    sn_error error = {0};
    assert_int_equal(sn_sparse_factor(4, 4, entries, &f, &error), SN_ERROR_INPUT);
    assert_null(f);
    assert_int_equal(error.element, 2);
    assert_non_null(strstr(error.text, "positive definite"));
}

static void a_refactor_may_fail_and_be_mended(void **state) {
    (void)state;
    sn_entry entries[] = {{0, 0, 2}, {1, 1, 2}, {0, 1, 1}};
    sn_sparse *f = factor(2, 3, entries);
    double x[2] = {3, 3};
    entries[2].value = 5;
    assert_int_equal(sn_sparse_refactor(f, entries, NULL), SN_ERROR_INPUT);
    assert_int_equal(sn_sparse_solve(f, 1, x, x, NULL), SN_ERROR_INPUT);
    entries[2].value = 1;
    assert_int_equal(sn_sparse_refactor(f, entries, NULL), SN_OK);
    assert_int_equal(sn_sparse_solve(f, 1, x, x, NULL), SN_OK);
    assert_true(fabs(x[0] - 1.0) < 1e-15 && fabs(x[1] - 1.0) < 1e-15);
    sn_sparse_destroy(f);
}

static void bad_entries_are_rejected(void **state) {
    (void)state;
    const sn_entry bad[] = {{0, 2, 1}, {-1, 0, 1}, {0, 0, NAN}, {1, 1, INFINITY}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sn_sparse *f = NULL;
        assert_int_equal(sn_sparse_factor(2, 1, &bad[i], &f, NULL), SN_ERROR_INPUT);
        assert_null(f);
    }
    sn_sparse *f = NULL;
    assert_int_equal(sn_sparse_factor(0, 0, NULL, &f, NULL), SN_ERROR_INPUT);
    assert_int_equal(sn_sparse_factor(3, 1, &(sn_entry){1, 1, 1}, &f, NULL), SN_ERROR_INPUT); /* empty columns: singular */
    sn_sparse_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_load_gives_the_parabola),
        cmocka_unit_test(several_columns_are_the_single_ones),
        cmocka_unit_test(points_are_solved_as_single_columns_are),
        cmocka_unit_test(a_refactor_is_a_fresh_factor),
        cmocka_unit_test(an_indefinite_matrix_names_its_row),
        cmocka_unit_test(a_refactor_may_fail_and_be_mended),
        cmocka_unit_test(bad_entries_are_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
