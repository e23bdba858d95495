/*
 * triangular.c -- forward and backward substitution with the columns of a sparse Cholesky factor, three or six right-hand sides side by
 * side.
 *
 * A right-hand side's three numbers and a spare one are one register, so that an entry of L costs one multiplication and one subtraction.
 * Neighbouring columns often have the same rows below them (the matrix is ordered by postorder of the elimination tree); up to four such
 * columns are taken together: each row below is then read and written once for all of them. A large factor is not in any cache: six
 * right-hand sides in one go then cost little more than three.
 */
#include "triangular.h"

#include <string.h>

#define INLINE static inline __attribute__((always_inline))

#ifndef SN_SCALAR

typedef double quad __attribute__((vector_size(32)));

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define KERNEL
#endif

INLINE quad load(const double *from) {
    quad a;
    memcpy(&a, from, sizeof a);
    return a;
}
INLINE void store(double *to, quad a) { memcpy(to, &a, sizeof a); }
INLINE quad scaled(quad a, double s) { return a * s; }
INLINE quad less_scaled(quad a, quad b, double s) { return a - b * s; } /* a - s b */

#else /* the scalar twin */

typedef struct quad {
    double x, y, z;
} quad;
#define KERNEL

INLINE quad load(const double *from) { return (quad){from[0], from[1], from[2]}; }
INLINE void store(double *to, quad a) { to[0] = a.x, to[1] = a.y, to[2] = a.z; }
INLINE quad scaled(quad a, double s) { return (quad){a.x * s, a.y * s, a.z * s}; }
INLINE quad less_scaled(quad a, quad b, double s) { return (quad){a.x - b.x * s, a.y - b.y * s, a.z - b.z * s}; }

#endif

enum { MOST = 4, MOST_QUADS = 2 };     /* columns taken together */
#define UNROLL _Pragma("GCC unroll 4") /* -O2 leaves short loops, and what they index, in memory */

/* Is what is below column j + 1 what is below column j? */
INLINE bool continues(const sn_lower *l, sn_index j) {
    return l->count[j] == l->count[j + 1] + 1 && l->count[j] > 1 && l->rows[l->start[j] + 1] == j + 1;
}

INLINE double at(const sn_lower *l, int below, sn_index column) { return l->values[l->start[column] + below]; }

/* L y = b in columns j .. j + width - 1, then what they take from the rows below. */
INLINE void forward(const sn_lower *l, sn_index j, int width, int quads, double *x) {
    quad y[MOST][MOST_QUADS];
    const double *column[MOST];
    const sn_index last = j + width - 1, stride = 4 * quads;
    UNROLL
    for (int c = 0; c < width; c++) {
        UNROLL
        for (int q = 0; q < quads; q++) {
            double *to = x + (size_t)stride * (size_t)(j + c) + 4 * q;
            y[c][q] = load(to);
            UNROLL
            for (int b = 0; b < c; b++) y[c][q] = less_scaled(y[c][q], y[b][q], at(l, c - b, j + b));
            y[c][q] = scaled(y[c][q], l->inverses[j + c]);
            store(to, y[c][q]);
        }
        column[c] = l->values + l->start[j + c] + (width - c);
    }
    const int *rows = l->rows + l->start[last] + 1;
    for (int i = 0; i < l->count[last] - 1; i++) {
        UNROLL
        for (int q = 0; q < quads; q++) {
            double *to = x + (size_t)stride * (size_t)rows[i] + 4 * q;
            quad sum = load(to);
            UNROLL
            for (int c = 0; c < width; c++) sum = less_scaled(sum, y[c][q], column[c][i]);
            store(to, sum);
        }
    }
}

/* LT x = y in columns j .. j + width - 1, from the rows below. */
INLINE void backward(const sn_lower *l, sn_index j, int width, int quads, double *x) {
    quad sum[MOST][MOST_QUADS];
    const double *column[MOST];
    const sn_index last = j + width - 1, stride = 4 * quads;
    UNROLL
    for (int c = 0; c < width; c++) {
        UNROLL
        for (int q = 0; q < quads; q++) sum[c][q] = load(x + (size_t)stride * (size_t)(j + c) + 4 * q);
        column[c] = l->values + l->start[j + c] + (width - c);
    }
    const int *rows = l->rows + l->start[last] + 1;
    for (int i = 0; i < l->count[last] - 1; i++) {
        UNROLL
        for (int q = 0; q < quads; q++) {
            quad below = load(x + (size_t)stride * (size_t)rows[i] + 4 * q);
            UNROLL
            for (int c = 0; c < width; c++) sum[c][q] = less_scaled(sum[c][q], below, column[c][i]);
        }
    }
    UNROLL
    for (int c = width - 1; c >= 0; c--) {
        UNROLL
        for (int q = 0; q < quads; q++) {
            UNROLL
            for (int b = c + 1; b < width; b++) sum[c][q] = less_scaled(sum[c][q], sum[b][q], at(l, b - c, j + c));
            sum[c][q] = scaled(sum[c][q], l->inverses[j + c]);
            store(x + (size_t)stride * (size_t)(j + c) + 4 * q, sum[c][q]);
        }
    }
}

INLINE void substitute(const sn_lower *l, int quads, double *x) {
    int width;
    for (sn_index j = 0; j < l->n; j += width) {
        for (width = 1; width < MOST && j + width < l->n && continues(l, j + width - 1);) width++;
        if (width == 4) forward(l, j, 4, quads, x);
        if (width == 3) forward(l, j, 3, quads, x);
        if (width == 2) forward(l, j, 2, quads, x);
        if (width == 1) forward(l, j, 1, quads, x);
    }
    for (sn_index end = l->n; end > 0; end -= width) {
        for (width = 1; width < MOST && end - width > 0 && continues(l, end - width - 1);) width++;
        if (width == 4) backward(l, end - 4, 4, quads, x);
        if (width == 3) backward(l, end - 3, 3, quads, x);
        if (width == 2) backward(l, end - 2, 2, quads, x);
        if (width == 1) backward(l, end - 1, 1, quads, x);
    }
}

KERNEL static void substitute_one(const sn_lower *l, double *x) { substitute(l, 1, x); }
KERNEL static void substitute_two(const sn_lower *l, double *x) { substitute(l, 2, x); }

void sn_triangular_solve(const sn_lower *l, int triples, double *records) {
    if (triples == 1)
        substitute_one(l, records);
    else
        substitute_two(l, records);
}
