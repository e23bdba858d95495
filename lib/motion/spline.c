/*
 * spline.c -- splines of the 5th degree through evenly spaced values, as B-splines.
 *
 * Of n values, the knots are the first and the last (six times each) and all but two at each end between them: n B-splines, n values. Their
 * matrix is banded and totally positive, so that it is eliminated without looking for pivots (de Boor and Pinkus 1977).
 */
#include "spline.h"

#include <math.h>
#include <stdlib.h>

static int width_of(const sn_spline *s) { return 2 * s->degree + 1; }

/* Knot k of the count + degree + 1. */
static double knot(const sn_spline *s, sn_index k) {
    if (k <= s->degree) return 0.0;
    if (k >= s->count) return (double)s->count - 1.0;
    return (double)k - (s->degree + 1) / 2.0; /* between the ends there are knots only of the full degree, which is odd */
}

/* The last knot that is not above x, of those with an interval behind them. */
static sn_index interval_of(const sn_spline *s, double x) {
    sn_index low = s->degree, high = s->count - 1;
    double at = floor(x) + (s->degree + 1) / 2;
    return at <= low ? low : at >= high ? high : (sn_index)at;
}

/* Cox and de Boor's recursion over the degree (de Boor 1978, chapter X). */
void sn_spline_weights(const sn_spline *s, double x, sn_index *first, double weights[SN_SPLINE_MOST]) {
    sn_index at = interval_of(s, x);
    *first = at - s->degree;
    weights[0] = 1.0;
    for (int d = 1; d <= s->degree; d++) {
        double carried = 0.0;
        for (int r = 0; r < d; r++) {
            double right = knot(s, at + r + 1) - x, left = x - knot(s, at + 1 - d + r), share = weights[r] / (right + left);
            weights[r] = carried + right * share;
            carried = left * share;
        }
        weights[d] = carried;
    }
}

static void fill_matrix(sn_spline *s) {
    for (sn_index i = 0; i < s->count; i++) {
        sn_index first;
        double weights[SN_SPLINE_MOST], *row = s->factors + (size_t)i * (size_t)width_of(s);
        sn_spline_weights(s, i, &first, weights);
        for (int k = 0; k <= s->degree; k++) {
            sn_index column = first + k - i + s->degree;
            if (column >= 0 && column < width_of(s)) row[column] = weights[k];
        }
    }
}

/* Row i, column j of the band. */
static double *entry(const sn_spline *s, sn_index i, sn_index j) {
    return &s->factors[(size_t)i * (size_t)width_of(s) + (size_t)(j - i + s->degree)];
}

static sn_index end_of_band(const sn_spline *s, sn_index k) { return s->count - 1 - k < s->degree ? s->count - 1 : k + s->degree; }

static void eliminate(sn_spline *s) {
    for (sn_index k = 0; k < s->count; k++)
        for (sn_index i = k + 1; i <= end_of_band(s, k); i++) {
            double factor = *entry(s, i, k) / *entry(s, k, k);
            *entry(s, i, k) = factor;
            for (sn_index j = k + 1; j <= end_of_band(s, k); j++) *entry(s, i, j) -= factor * *entry(s, k, j);
        }
}

sn_status sn_spline_create(sn_index count, sn_spline *out, sn_error *error) {
    *out = (sn_spline){.count = count, .degree = count > SN_SPLINE_DEGREE ? SN_SPLINE_DEGREE : count - 1};
    out->factors = sn_alloc((size_t)count * (size_t)width_of(out), sizeof *out->factors);
    if (out->factors == NULL) return sn_fail_memory(error, "a spline");
    fill_matrix(out);
    eliminate(out);
    return SN_OK;
}

void sn_spline_free(sn_spline *spline) {
    free(spline->factors);
    *spline = (sn_spline){0};
}

void sn_spline_solve(const sn_spline *s, double *values) {
    for (sn_index k = 0; k < s->count; k++)
        for (sn_index i = k + 1; i <= end_of_band(s, k); i++) values[i] -= *entry(s, i, k) * values[k];
    for (sn_index k = s->count - 1; k >= 0; k--) {
        for (sn_index j = k + 1; j <= end_of_band(s, k); j++) values[k] -= *entry(s, k, j) * values[j];
        values[k] /= *entry(s, k, k);
    }
}
