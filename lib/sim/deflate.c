/*
 * deflate.c -- the volume rows of a group of muscles.   See deflate.h
 */
#include "deflate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entry of the matrix between two members. */
typedef struct link {
    sn_index entry; /* of the matrix */
    sn_index row, column;
    sn_index members[2];
    sn_index pair; /* entry of E */
} link;

struct sn_deflation {
    sn_index count, rows; /* of the matrix */
    int columns;          /* right-hand sides that it is solved for */
    sn_index *first;      /* (count + 1) rows */
    sn_index own_count;   /* entries of the blocks of the members */
    sn_index *own;        /* (own_count) which entries of the matrix they are */
    sn_entry *own_entries;
    sn_sparse *blocks;
    size_t link_count, link_capacity;
    link *links;      /* (link_count) by pair of members */
    double *values;   /* (link_count) */
    double *gradient; /* (columns x rows) H s on the member itself */
    double *solved;   /* (columns x rows) s, scaled so that E has 1 on its diagonal */
    double *amount;   /* (count) what is kept between before and after */
    double *room;     /* (2 count) */
    bool *acts;       /* (count) it has a volume row */
    bool any;
    sn_index pair_count;
    sn_entry *coarse_entries; /* (count + pair_count) E: the diagonal, then pairs */
    sn_sparse *coarse;
};

/* ---- made and unmade ---------------------------------------------------------------------------------------------------------------- */

/* Members of all rows. */
static sn_index *members_of(const sn_deflation *d) {
    sn_index *of = SN_NEW(sn_index, d->rows);
    for (sn_index m = 0; m < d->count && of != NULL; m++)
        for (sn_index i = d->first[m]; i < d->first[m + 1]; i++) of[i] = m;
    return of;
}

static int compare_links(const void *a, const void *b) {
    const link *p = a, *q = b;
    for (int i = 0; i < 2; i++)
        if (p->members[i] != q->members[i]) return p->members[i] < q->members[i] ? -1 : 1;
    return (p->entry > q->entry) - (p->entry < q->entry);
}

static bool sort_entries(sn_deflation *d, sn_index entry_count, const sn_entry *entries) {
    sn_index *of = members_of(d);
    bool enough = of != NULL && (d->own = SN_NEW(sn_index, entry_count)) != NULL;
    for (sn_index i = 0; i < entry_count && enough; i++) {
        sn_index a = of[entries[i].row], b = of[entries[i].column];
        if (a == b) {
            d->own[d->own_count++] = i;
            continue;
        }
        enough = sn_grow((void **)&d->links, &d->link_capacity, d->link_count + 1, sizeof *d->links);
        if (enough) d->links[d->link_count++] = (link){i, entries[i].row, entries[i].column, {a, b}, 0};
    }
    free(of);
    return enough;
}

/* E has an entry for each pair of members that are linked. */
static bool make_pairs(sn_deflation *d) {
    if (d->link_count > 0) qsort(d->links, d->link_count, sizeof *d->links, compare_links);
    d->coarse_entries = SN_NEW(sn_entry, (size_t)d->count + d->link_count);
    if (d->coarse_entries == NULL) return false;
    for (sn_index m = 0; m < d->count; m++) d->coarse_entries[m] = (sn_entry){m, m, 1.0};
    for (size_t i = 0; i < d->link_count; i++) {
        link *l = &d->links[i];
        const link *before = i > 0 ? l - 1 : NULL;
        bool fresh = before == NULL || memcmp(before->members, l->members, sizeof l->members) != 0;
        if (fresh) d->coarse_entries[d->count + d->pair_count++] = (sn_entry){l->members[0], l->members[1], 0.0};
        l->pair = d->count + d->pair_count - 1;
    }
    return true;
}

static bool take_rows(sn_deflation *d, const sn_index *first, int size) {
    if ((d->first = SN_NEW(sn_index, (size_t)d->count + 1)) == NULL) return false;
    for (sn_index m = 0; m <= d->count; m++) d->first[m] = size * first[m];
    d->rows = d->first[d->count];
    d->columns = 3 / size;
    return true;
}

static bool make_room(sn_deflation *d) {
    size_t numbers = (size_t)d->columns * (size_t)d->rows, count = (size_t)d->count;
    return (d->own_entries = SN_NEW(sn_entry, d->own_count)) != NULL && (d->values = SN_NEW(double, d->link_count)) != NULL &&
           (d->gradient = SN_NEW(double, numbers)) != NULL && (d->solved = SN_NEW(double, numbers)) != NULL &&
           (d->amount = SN_NEW(double, count)) != NULL && (d->room = SN_NEW(double, 2 * count)) != NULL &&
           (d->acts = SN_NEW(bool, count)) != NULL;
}

sn_deflation *sn_deflation_create(sn_index count, const sn_index *first, int size, sn_index entry_count, const sn_entry *entries) {
    sn_deflation *d = SN_NEW(sn_deflation, 1);
    if (d == NULL) return NULL;
    *d = (sn_deflation){.count = count};
    if (take_rows(d, first, size) && sort_entries(d, entry_count, entries) && make_pairs(d) && make_room(d)) return d;
    sn_deflation_destroy(d);
    return NULL;
}

void sn_deflation_destroy(sn_deflation *d) {
    if (d == NULL) return;
    sn_sparse_destroy(d->blocks);
    sn_sparse_destroy(d->coarse);
    free(d->first);
    free(d->own);
    free(d->own_entries);
    free(d->links);
    free(d->values);
    free(d->gradient);
    free(d->solved);
    free(d->amount);
    free(d->room);
    free(d->acts);
    free(d->coarse_entries);
    free(d);
}

/* ---- what it is made of now ---------------------------------------------------------------------------------------------- */

static bool factor(sn_sparse **matrix, sn_index n, sn_index count, const sn_entry *entries) {
    sn_status status = *matrix == NULL ? sn_sparse_factor(n, count, entries, matrix, NULL) : sn_sparse_refactor(*matrix, entries, NULL);
    return status == SN_OK;
}

bool sn_deflation_factor(sn_deflation *d, const sn_entry *entries) {
    for (sn_index i = 0; i < d->own_count; i++) d->own_entries[i] = entries[d->own[i]];
    for (size_t i = 0; i < d->link_count; i++) d->values[i] = entries[d->links[i].entry].value;
    d->any = false;
    return factor(&d->blocks, d->rows, d->own_count, d->own_entries);
}

/* Over the points of a member. */
static double product(const sn_deflation *d, sn_index member, const double *a, const double *b) {
    double sum = 0.0;
    for (int axis = 0; axis < d->columns; axis++) {
        const double *p = a + (size_t)axis * (size_t)d->rows, *q = b + (size_t)axis * (size_t)d->rows;
        for (sn_index i = d->first[member]; i < d->first[member + 1]; i++) sum += p[i] * q[i];
    }
    return sum;
}

static void scale(const sn_deflation *d, sn_index member, double by, double *a) {
    for (int axis = 0; axis < d->columns; axis++) {
        double *p = a + (size_t)axis * (size_t)d->rows;
        for (sn_index i = d->first[member]; i < d->first[member + 1]; i++) p[i] *= by;
    }
}

/* One entry's share of a product of two vectors. */
static double linked(const sn_deflation *d, const link *l, const double *a, const double *b) {
    size_t n = (size_t)d->rows, end = n * (size_t)d->columns;
    const double *p = a + l->row, *q = b + l->column;
    double sum = 0.0;
    for (size_t i = 0; i < end; i += n) sum += p[i] * q[i];
    return sum;
}

/* s and H s of a member, so scaled that s H s = 1. */
static void take_member(sn_deflation *d, sn_index m, double stiffness) {
    double along = stiffness > 0.0 ? product(d, m, d->gradient, d->solved) : 0.0, stiff = 1.0 + stiffness * along;
    d->acts[m] = along > 0.0 && isfinite(along * stiff);
    d->any = d->any || d->acts[m];
    double unit = d->acts[m] ? 1.0 / sqrt(along * stiff) : 0.0;
    scale(d, m, unit, d->solved);
    scale(d, m, unit * stiff, d->gradient);
}

bool sn_deflation_set(sn_deflation *d, double *gradient, const double *stiffness) {
    d->any = false;
    memcpy(d->gradient, gradient, (size_t)d->columns * (size_t)d->rows * sizeof *gradient);
    if (sn_sparse_solve(d->blocks, d->columns, gradient, d->solved, NULL) != SN_OK) return false;
    for (sn_index m = 0; m < d->count; m++) take_member(d, m, stiffness[m]);
    for (sn_index i = 0; i < d->pair_count; i++) d->coarse_entries[d->count + i].value = 0.0;
    for (size_t i = 0; i < d->link_count; i++)
        d->coarse_entries[d->links[i].pair].value += d->values[i] * linked(d, &d->links[i], d->solved, d->solved);
    return !d->any || factor(&d->coarse, d->count, d->count + d->pair_count, d->coarse_entries);
}

bool sn_deflation_acts(const sn_deflation *d) { return d->any; }

/* ---- applied ------------------------------------------------------------------------------------------------------------ */

/* in -= H S amount */
static void take_away(const sn_deflation *d, const double *amount, double *in) {
    size_t n = (size_t)d->rows;
    for (sn_index m = 0; m < d->count; m++)
        for (int axis = 0; axis < d->columns && d->acts[m]; axis++)
            for (size_t i = (size_t)axis * n + (size_t)d->first[m], end = (size_t)axis * n + (size_t)d->first[m + 1]; i < end; i++)
                in[i] -= amount[m] * d->gradient[i];
    for (size_t i = 0; i < d->link_count; i++) {
        const link *l = &d->links[i];
        double by_row = d->values[i] * amount[l->members[0]], by_column = d->values[i] * amount[l->members[1]];
        for (size_t at = 0; at < n * (size_t)d->columns; at += n) {
            in[at + (size_t)l->row] -= by_column * d->solved[at + (size_t)l->column];
            in[at + (size_t)l->column] -= by_row * d->solved[at + (size_t)l->row];
        }
    }
}

bool sn_deflation_before(sn_deflation *d, double *right) {
    for (sn_index m = 0; m < d->count; m++) d->room[m] = d->acts[m] ? product(d, m, d->solved, right) : 0.0;
    if (sn_sparse_solve(d->coarse, 1, d->room, d->amount, NULL) != SN_OK) return false;
    take_away(d, d->amount, right);
    return true;
}

/* (H S)T of solution: what is left of a volume row's share in it. */
static void look_along(const sn_deflation *d, const double *solution, double *out) {
    for (sn_index m = 0; m < d->count; m++) out[m] = d->acts[m] ? product(d, m, d->gradient, solution) : 0.0;
    for (size_t i = 0; i < d->link_count; i++) {
        const link *l = &d->links[i];
        out[l->members[0]] += d->values[i] * linked(d, l, d->solved, solution);
        out[l->members[1]] += d->values[i] * linked(d, l, solution, d->solved); /* where there is no row, s is 0 */
    }
}

bool sn_deflation_after(sn_deflation *d, double *solution) {
    double *less = d->room + d->count; /* E^-1 (H S)T solution */
    size_t n = (size_t)d->rows;
    look_along(d, solution, d->room);
    if (sn_sparse_solve(d->coarse, 1, d->room, less, NULL) != SN_OK) return false;
    for (sn_index m = 0; m < d->count; m++) {
        double by = d->amount[m] - less[m];
        for (int axis = 0; axis < d->columns && d->acts[m]; axis++)
            for (size_t i = (size_t)axis * n + (size_t)d->first[m], end = (size_t)axis * n + (size_t)d->first[m + 1]; i < end; i++)
                solution[i] += by * d->solved[i];
    }
    return true;
}
