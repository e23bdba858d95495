/*
 * fill_match.c -- points paired so that the sum of squared distances is least: the Hungarian method with shortest augmenting paths (Kuhn
 * 1955; Jonker & Volgenant 1987). Many points are first parted into halves across their longest way, both sets alike.
 */
#include <stdlib.h>

#include "fill.h"

enum { MOST_AT_ONCE = 256 };

typedef struct matching {
    const fill_features *from, *to;
    sn_index *a, *b; /* (count) numbers in from and to, in the order of the halves */
    double *cost;    /* (MOST_AT_ONCE x MOST_AT_ONCE) */
    sn_index *match; /* (count) the result */
} matching;

static double distance2(const fill_features *a, sn_index i, const fill_features *b, sn_index k) {
    double sum = 0.0;
    for (sn_index d = 0; d < a->width; d++) {
        double off = a->values[(size_t)i * (size_t)a->width + (size_t)d] - b->values[(size_t)k * (size_t)b->width + (size_t)d];
        sum += off * off;
    }
    return sum;
}

/* ---- a few ------------------------------------------------------------------------------------------------------------------------ */

/* Potentials of rows and columns, the row of each column, and one search; index 0 stands for none. */
typedef struct hungarian {
    sn_index row_of[MOST_AT_ONCE + 1], before[MOST_AT_ONCE + 1];
    double row[MOST_AT_ONCE + 1], column[MOST_AT_ONCE + 1], slack[MOST_AT_ONCE + 1];
    bool seen[MOST_AT_ONCE + 1];
} hungarian;

/* Look along the row of `at`: the nearest unseen column, potentials moved by the slack there. */
static sn_index next_column(hungarian *h, const double *cost, sn_index n, sn_index at) {
    sn_index r = h->row_of[at], best = 0;
    double least = INFINITY;
    for (sn_index c = 1; c <= n; c++) {
        if (h->seen[c]) continue;
        double reduced = cost[(r - 1) * MOST_AT_ONCE + c - 1] - h->row[r] - h->column[c];
        if (reduced < h->slack[c]) {
            h->slack[c] = reduced;
            h->before[c] = at;
        }
        if (h->slack[c] >= least) continue;
        least = h->slack[c];
        best = c;
    }
    for (sn_index c = 0; c <= n; c++) {
        if (h->seen[c]) {
            h->row[h->row_of[c]] += least;
            h->column[c] -= least;
        } else {
            h->slack[c] -= least;
        }
    }
    return best;
}

static void solve(const double *cost, sn_index n, hungarian *h) {
    for (sn_index c = 0; c <= n; c++) {
        h->row_of[c] = 0;
        h->row[c] = h->column[c] = 0.0;
    }
    for (sn_index r = 1; r <= n; r++) {
        for (sn_index c = 0; c <= n; c++) {
            h->slack[c] = INFINITY;
            h->seen[c] = false;
        }
        sn_index at = 0;
        h->row_of[0] = r;
        do {
            h->seen[at] = true;
            at = next_column(h, cost, n, at);
        } while (h->row_of[at] != 0);
        for (; at != 0; at = h->before[at]) h->row_of[at] = h->row_of[h->before[at]];
    }
}

static void match_few(matching *m, sn_index first, sn_index count, hungarian *h) {
    for (sn_index i = 0; i < count; i++)
        for (sn_index k = 0; k < count; k++) m->cost[i * MOST_AT_ONCE + k] = distance2(m->from, m->a[first + i], m->to, m->b[first + k]);
    solve(m->cost, count, h);
    for (sn_index c = 1; c <= count; c++) m->match[m->a[first + h->row_of[c] - 1]] = m->b[first + c - 1];
}

/* ---- many ------------------------------------------------------------------------------------------------------------------------- */

typedef struct keyed {
    double key;
    sn_index number;
} keyed;

static int compare_keys(const void *left, const void *right) {
    const keyed *a = left, *b = right;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->number > b->number) - (a->number < b->number);
}

static double extent(const fill_features *f, const sn_index *items, sn_index count, sn_index axis) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < count; i++) {
        double x = f->values[(size_t)items[i] * (size_t)f->width + (size_t)axis];
        low = fmin(low, x);
        high = fmax(high, x);
    }
    return high - low;
}

static void sort_along(const fill_features *f, sn_index *items, sn_index count, sn_index axis, keyed *work) {
    for (sn_index i = 0; i < count; i++) work[i] = (keyed){f->values[(size_t)items[i] * (size_t)f->width + (size_t)axis], items[i]};
    qsort(work, (size_t)count, sizeof *work, compare_keys);
    for (sn_index i = 0; i < count; i++) items[i] = work[i].number;
}

static void match_range(matching *m, sn_index first, sn_index count, keyed *work, hungarian *h) {
    if (count <= MOST_AT_ONCE) {
        match_few(m, first, count, h);
        return;
    }
    sn_index axis = 0;
    double widest = -1.0;
    for (sn_index d = 0; d < m->from->width; d++) {
        double both = fmin(extent(m->from, m->a + first, count, d), extent(m->to, m->b + first, count, d));
        if (both > widest) axis = d;
        widest = fmax(widest, both);
    }
    sort_along(m->from, m->a + first, count, axis, work);
    sort_along(m->to, m->b + first, count, axis, work);
    match_range(m, first, count / 2, work, h);
    match_range(m, first + count / 2, count - count / 2, work, h);
}

sn_status fill_match(sn_index count, const fill_features *from, const fill_features *to, sn_index *match, sn_error *error) {
    if (count == 0) return SN_OK;
    matching m = {.from = from, .to = to, .match = match};
    m.a = SN_NEW(sn_index, count);
    m.b = SN_NEW(sn_index, count);
    m.cost = SN_NEW(double, MOST_AT_ONCE *MOST_AT_ONCE);
    keyed *work = SN_NEW(keyed, count);
    hungarian *h = SN_NEW(hungarian, 1);
    bool made = m.a && m.b && m.cost && work && h;
    for (sn_index i = 0; made && i < count; i++) m.a[i] = m.b[i] = i;
    if (made) match_range(&m, 0, count, work, h);
    free(m.a);
    free(m.b);
    free(m.cost);
    free(work);
    free(h);
    return made ? SN_OK : sn_fail_memory(error, "the pairs of the fibres' ends");
}
