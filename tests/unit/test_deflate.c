/* test_deflate.c -- the volume rows of a group (deflate.c): where members are not linked the inverse is that of the matrix with the rows;
 * where they are it is symmetric, positive, exact along what deflation takes out, and near for the rest. */
#include "shapes.h"

#include "../../lib/sim/deflate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MEMBERS = 3, POINTS = 12, NUMBERS = 3 * POINTS, MOST_ENTRIES = 64 };

static const sn_index FIRST[MEMBERS + 1] = {0, 5, 6, POINTS};

/* A chain of springs in each member, mass on all points, and links between members. */
typedef struct problem {
    sn_index count;
    sn_entry entries[MOST_ENTRIES];
    double gradient[NUMBERS], stiffness[MEMBERS];
    sn_sparse *matrix;
    sn_deflation *deflation;
} problem;

static double noise(unsigned *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return (double)(*seed >> 8) / (1 << 24) - 0.5;
}

static void add_spring(problem *p, sn_index a, sn_index b, double k) {
    p->entries[p->count++] = (sn_entry){a, a, k};
    p->entries[p->count++] = (sn_entry){b, b, k};
    p->entries[p->count++] = (sn_entry){b, a, -k};
}

static void make(problem *p, double link, double volume) {
    unsigned seed = 7;
    *p = (problem){.count = 0};
    for (sn_index i = 0; i < POINTS; i++) p->entries[p->count++] = (sn_entry){i, i, 0.3 + 0.1 * i};
    for (sn_index m = 0; m < MEMBERS; m++) {
        for (sn_index i = FIRST[m]; i + 1 < FIRST[m + 1]; i++) add_spring(p, i, i + 1, 1.0 + m);
        p->stiffness[m] = m == 1 ? 0.0 : volume * (1.0 + m); /* one that keeps no volume */
    }
    if (link > 0.0) add_spring(p, 2, 7, link), add_spring(p, 3, 8, link), add_spring(p, 5, 9, link);
    for (int i = 0; i < NUMBERS; i++) p->gradient[i] = noise(&seed);
    double room[NUMBERS];
    memcpy(room, p->gradient, sizeof room);
    assert_int_equal(sn_sparse_factor(POINTS, p->count, p->entries, &p->matrix, NULL), SN_OK);
    p->deflation = sn_deflation_create(MEMBERS, FIRST, 1, p->count, p->entries);
    assert_non_null(p->deflation);
    assert_true(sn_deflation_factor(p->deflation, p->entries));
    assert_true(sn_deflation_set(p->deflation, room, p->stiffness));
}

static void unmake(problem *p) {
    sn_sparse_destroy(p->matrix);
    sn_deflation_destroy(p->deflation);
}

/* (A + sum k g gT) v */
static void times(const problem *p, const double *v, double *out) {
    memset(out, 0, NUMBERS * sizeof *out);
    for (int axis = 0; axis < 3; axis++)
        for (sn_index e = 0; e < p->count; e++) {
            sn_index r = p->entries[e].row + axis * POINTS, c = p->entries[e].column + axis * POINTS;
            out[r] += p->entries[e].value * v[c];
            if (r != c) out[c] += p->entries[e].value * v[r];
        }
    for (sn_index m = 0; m < MEMBERS; m++) {
        double along = 0.0;
        for (int axis = 0; axis < 3; axis++)
            for (sn_index i = FIRST[m]; i < FIRST[m + 1]; i++) along += p->gradient[axis * POINTS + i] * v[axis * POINTS + i];
        for (int axis = 0; axis < 3; axis++)
            for (sn_index i = FIRST[m]; i < FIRST[m + 1]; i++)
                out[axis * POINTS + i] += p->stiffness[m] * along * p->gradient[axis * POINTS + i];
    }
}

static void solve(problem *p, const double *in, double *out) {
    double right[NUMBERS];
    memcpy(right, in, sizeof right);
    if (sn_deflation_acts(p->deflation)) assert_true(sn_deflation_before(p->deflation, right));
    assert_int_equal(sn_sparse_solve(p->matrix, 3, right, out, NULL), SN_OK);
    if (sn_deflation_acts(p->deflation)) assert_true(sn_deflation_after(p->deflation, out));
}

static double dot(const double *a, const double *b) {
    double sum = 0.0;
    for (int i = 0; i < NUMBERS; i++) sum += a[i] * b[i];
    return sum;
}

static void random_vector(unsigned seed, double *out) {
    for (int i = 0; i < NUMBERS; i++) out[i] = noise(&seed);
}

/* |x - y| / |y| */
static double off(const double *x, const double *y) {
    double sum = 0.0;
    for (int i = 0; i < NUMBERS; i++) sum += (x[i] - y[i]) * (x[i] - y[i]);
    return sqrt(sum / dot(y, y));
}

static void without_links_it_is_the_inverse(void **state) {
    (void)state;
    static const double volumes[3] = {0.0, 5.0, 1e8};
    for (int i = 0; i < 3; i++) {
        problem p;
        double v[NUMBERS], product[NUMBERS], back[NUMBERS];
        make(&p, 0.0, volumes[i]);
        assert_int_equal(sn_deflation_acts(p.deflation), volumes[i] > 0.0);
        random_vector(3, v);
        times(&p, v, product);
        solve(&p, product, back);
        assert_true(off(back, v) < 1e-7);
        unmake(&p);
    }
}

static void with_links_it_is_symmetric_and_positive_and_near(void **state) {
    (void)state;
    problem p;
    double a[NUMBERS], b[NUMBERS], pa[NUMBERS], pb[NUMBERS];
    make(&p, 2.0, 1e4);
    for (unsigned seed = 1; seed < 20; seed++) {
        random_vector(seed, a);
        random_vector(seed + 100, b);
        solve(&p, a, pa);
        solve(&p, b, pb);
        assert_true(fabs(dot(a, pb) - dot(b, pa)) < 1e-10 * (fabs(dot(a, pa)) + fabs(dot(b, pb))));
        assert_true(dot(a, pa) > 0.0);
        times(&p, pa, pb); /* H P a: as large as a along everything, where the row's k is ten thousand times the springs' */
        assert_true(dot(pa, pb) > 0.2 * dot(a, pa) && dot(pa, pb) < 5.0 * dot(a, pa));
    }
    unmake(&p);
}

/* s of a member, by its own block: what the inverse is exact along. */
static void along_the_volumes_it_is_exact(void **state) {
    (void)state;
    problem p, alone;
    double right[NUMBERS] = {0}, s[NUMBERS], product[NUMBERS], back[NUMBERS];
    make(&p, 2.0, 50.0);
    make(&alone, 0.0, 0.0);
    alone.count = p.count - 9; /* the links' diagonals stay */
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2; i++) alone.entries[alone.count++] = p.entries[p.count - 9 + 3 * k + i];
    sn_sparse_destroy(alone.matrix);
    assert_int_equal(sn_sparse_factor(POINTS, alone.count, alone.entries, &alone.matrix, NULL), SN_OK);
    for (int axis = 0; axis < 3; axis++)
        for (sn_index i = FIRST[2]; i < FIRST[3]; i++) right[axis * POINTS + i] = p.gradient[axis * POINTS + i];
    assert_int_equal(sn_sparse_solve(alone.matrix, 3, right, s, NULL), SN_OK);
    times(&p, s, product);
    solve(&p, product, back);
    assert_true(off(back, s) < 1e-10);
    unmake(&p);
    unmake(&alone);
}

static void rows_that_are_nothing_are_left_out(void **state) {
    (void)state;
    problem p;
    double room[NUMBERS] = {0}, a[NUMBERS], x[NUMBERS], y[NUMBERS];
    make(&p, 2.0, 5.0);
    assert_true(sn_deflation_set(p.deflation, room, p.stiffness)); /* collapsed to a point: no gradient */
    assert_false(sn_deflation_acts(p.deflation));
    random_vector(5, a);
    solve(&p, a, x);
    assert_int_equal(sn_sparse_solve(p.matrix, 3, a, y, NULL), SN_OK);
    assert_memory_equal(x, y, sizeof x);
    unmake(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_links_it_is_the_inverse),
        cmocka_unit_test(with_links_it_is_symmetric_and_positive_and_near),
        cmocka_unit_test(along_the_volumes_it_is_exact),
        cmocka_unit_test(rows_that_are_nothing_are_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
