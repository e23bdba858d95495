/*
 * sparse.c -- symmetric sparse factor and solve by CHOLMOD: simplicial LLt with AMD ordering, which is plain C without BLAS and so gives
 * the same bits everywhere, and is also the faster one below about a thousand unknowns. The only file that knows CHOLMOD.
 */
#include "sinew/sparse.h"
#include "triangular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

struct sn_sparse {
    sn_index n, entry_count;
    sn_index *slot; /* (entry_count) where each entry is added in the matrix's values */
    cholmod_common common;
    cholmod_sparse *matrix; /* lower triangle by columns, rows ascending */
    cholmod_factor *factor;
    cholmod_dense *solution, *work_y, *work_e; /* kept between solves: a solve of the same width allocates nothing */
    double *inverses;                          /* (n) 1 / diagonal of L */
    double *records;                           /* (n x 8) of a solve with three or six right-hand sides */
};

/* ---- the matrix ----------------------------------------------------------------------------------------------------- */

static sn_index column_of(sn_entry e) { return e.row < e.column ? e.row : e.column; }
static sn_index row_of(sn_entry e) { return e.row < e.column ? e.column : e.row; }

static sn_status check_entries(sn_index n, sn_index entry_count, const sn_entry *entries, sn_error *error) {
    if (n < 1 || entry_count < 0) return sn_fail(error, SN_ERROR_INPUT, "a matrix of %d rows cannot be factored", (int)n);
    for (sn_index i = 0; i < entry_count; i++) {
        sn_entry e = entries[i];
        if (e.row < 0 || e.row >= n || e.column < 0 || e.column >= n)
            return sn_fail(error, SN_ERROR_INPUT, "matrix entry (%d, %d) is outside %d x %d", (int)e.row, (int)e.column, (int)n, (int)n);
        if (!isfinite(e.value)) {
            sn_fail(error, SN_ERROR_INPUT, "matrix entry (%d, %d) is not finite", (int)e.row, (int)e.column);
            if (error) error->element = e.row;
            return SN_ERROR_INPUT;
        }
    }
    return SN_OK;
}

/* Stable counting sort of order[] (NULL: as they come) by the row or column of its entries; start (n + 1) is scratch. */
static void sort_entries(const sn_sparse *s, const sn_entry *entries, sn_index (*key)(sn_entry), sn_index *start, const sn_index *order,
                         sn_index *sorted) {
    memset(start, 0, ((size_t)s->n + 1) * sizeof *start);
    for (sn_index i = 0; i < s->entry_count; i++) start[key(entries[i]) + 1]++;
    for (sn_index k = 0; k < s->n; k++) start[k + 1] += start[k];
    for (sn_index i = 0; i < s->entry_count; i++) {
        sn_index e = order ? order[i] : i;
        sorted[start[key(entries[e])]++] = e;
    }
}

/* Give every entry its place among the distinct ones, which come by column, then row; returns how many there are. */
static sn_index assign_slots(sn_index count, const sn_entry *entries, const sn_index *sorted, sn_index *slot) {
    sn_index used = 0;
    for (sn_index i = 0; i < count; i++) {
        sn_entry e = entries[sorted[i]];
        bool repeats = i > 0 && column_of(e) == column_of(entries[sorted[i - 1]]) && row_of(e) == row_of(entries[sorted[i - 1]]);
        if (!repeats) used++;
        slot[sorted[i]] = used - 1;
    }
    return used;
}

static void fill_pattern(const sn_sparse *s, const sn_entry *entries) {
    int *start = s->matrix->p, *rows = s->matrix->i;
    memset(start, 0, ((size_t)s->n + 1) * sizeof *start);
    for (sn_index i = 0; i < s->entry_count; i++) {
        rows[s->slot[i]] = row_of(entries[i]);
        int *end = &start[column_of(entries[i]) + 1]; /* a column ends behind its last slot */
        if (*end <= s->slot[i]) *end = s->slot[i] + 1;
    }
    for (sn_index k = 0; k < s->n; k++)
        if (start[k + 1] < start[k]) start[k + 1] = start[k]; /* an empty column */
}

static void fill_values(const sn_sparse *s, const sn_entry *entries) {
    double *values = s->matrix->x;
    memset(values, 0, s->matrix->nzmax * sizeof *values);
    for (sn_index i = 0; i < s->entry_count; i++) values[s->slot[i]] += entries[i].value;
}

static bool build_matrix(sn_sparse *s, const sn_entry *entries) {
    size_t count = (size_t)s->entry_count;
    s->slot = SN_NEW(sn_index, count);
    sn_index *by_row = SN_NEW(sn_index, count), *sorted = SN_NEW(sn_index, count), *start = SN_NEW(sn_index, (size_t)s->n + 1);
    if (s->slot && by_row && sorted && start) {
        sort_entries(s, entries, row_of, start, NULL, by_row);
        sort_entries(s, entries, column_of, start, by_row, sorted);
        sn_index used = assign_slots(s->entry_count, entries, sorted, s->slot);
        size_t n = (size_t)s->n;
        s->matrix = cholmod_allocate_sparse(n, n, (size_t)used, true, true, -1, CHOLMOD_REAL, &s->common);
    }
    free(by_row);
    free(sorted);
    free(start);
    if (!s->matrix) return false;
    fill_pattern(s, entries);
    fill_values(s, entries);
    return true;
}

/* ---- factor and solve ------------------------------------------------------------------------------------------------ */

static void configure(cholmod_common *common) {
    cholmod_start(common);
    common->print = 0; /* silent: what went wrong is read from `status` */
    common->error_handler = NULL;
    common->supernodal = CHOLMOD_SIMPLICIAL;
    common->final_ll = true;
    common->nmethods = 1;
    common->method[0].ordering = CHOLMOD_AMD;
    common->postorder = true;
    common->quick_return_if_not_posdef = true;
}

/* The row of the matrix where the factorisation met a pivot that is not positive. */
static sn_index failing_row(const sn_sparse *s) {
    const int *order = s->factor->Perm;
    size_t minor = s->factor->minor;
    if (minor >= (size_t)s->n) return SN_NONE;
    return order ? order[minor] : (sn_index)minor;
}

static sn_status factor_values(sn_sparse *s, sn_error *error) {
    cholmod_factorize(s->matrix, s->factor, &s->common);
    if (s->common.status == CHOLMOD_OK) {
        const double *values = s->factor->x;
        const int *start = s->factor->p;
        for (sn_index j = 0; j < s->n; j++) s->inverses[j] = 1.0 / values[start[j]];
        return SN_OK;
    }
    if (s->common.status == CHOLMOD_NOT_POSDEF) {
        sn_index row = failing_row(s);
        sn_fail(error, SN_ERROR_INPUT, "the matrix is not positive definite: its pivot in column %d is not positive", (int)row);
        if (error) error->element = row;
        return SN_ERROR_INPUT;
    }
    if (s->common.status == CHOLMOD_OUT_OF_MEMORY || s->common.status == CHOLMOD_TOO_LARGE)
        return sn_fail_memory(error, "the factor of a sparse matrix");
    return sn_fail(error, SN_ERROR_INTERNAL, "the sparse factorisation failed (CHOLMOD status %d)", s->common.status);
}

sn_status sn_sparse_factor(sn_index n, sn_index entry_count, const sn_entry *entries, sn_sparse **out, sn_error *error) {
    *out = NULL;
    sn_status status = check_entries(n, entry_count, entries, error);
    if (status) return status;
    sn_sparse *s = SN_NEW(sn_sparse, 1);
    if (!s) return sn_fail_memory(error, "a sparse matrix");
    s->n = n;
    s->entry_count = entry_count;
    s->inverses = SN_NEW(double, n);
    s->records = sn_alloc((size_t)n, 8 * sizeof(double));
    configure(&s->common);
    if (s->inverses && s->records && build_matrix(s, entries)) s->factor = cholmod_analyze(s->matrix, &s->common);
    status = s->factor ? factor_values(s, error) : sn_fail_memory(error, "the analysis of a sparse matrix");
    if (status)
        sn_sparse_destroy(s);
    else
        *out = s;
    return status;
}

sn_status sn_sparse_refactor(sn_sparse *factor, const sn_entry *entries, sn_error *error) {
    sn_status status = check_entries(factor->n, factor->entry_count, entries, error);
    if (status) return status;
    fill_values(factor, entries);
    return factor_values(factor, error);
}

/* Three right-hand sides are points; a register holds them. */
static void solve_triples(const sn_sparse *s, int triples, const double *b, double *x) {
    const cholmod_factor *f = s->factor;
    const int *order = f->Perm;
    const sn_lower lower = {s->n, f->p, f->nz, f->i, f->x, s->inverses};
    size_t n = (size_t)s->n, columns = 3 * (size_t)triples, stride = 4 * (size_t)triples;
    for (size_t k = 0; k < n; k++) {
        double *to = s->records + stride * k;
        for (size_t c = 0; c < columns; c++) to[c + c / 3] = b[c * n + (size_t)order[k]];
        for (size_t c = 3; c < stride; c += 4) to[c] = 0.0;
    }
    sn_triangular_solve(&lower, triples, s->records);
    for (size_t k = 0; k < n; k++)
        for (size_t c = 0; c < columns; c++) x[c * n + (size_t)order[k]] = s->records[stride * k + c + c / 3];
}

sn_status sn_sparse_solve(sn_sparse *factor, sn_index columns, const double *b, double *x, sn_error *error) {
    if (columns < 1) return SN_OK;
    size_t n = (size_t)factor->n, size = n * (size_t)columns;
    if (factor->factor->minor < n) return sn_fail(error, SN_ERROR_INPUT, "the matrix has no factor: its last factorisation failed");
    if (columns == 3 || columns == 6) {
        solve_triples(factor, columns / 3, b, x);
        return SN_OK;
    }
    cholmod_dense right = {.nrow = n, .ncol = (size_t)columns, .nzmax = size, .d = n, .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE};
    right.x = (void *)(uintptr_t)b; /* only read */
    bool solved =
        cholmod_solve2(CHOLMOD_A, factor->factor, &right, NULL, &factor->solution, NULL, &factor->work_y, &factor->work_e, &factor->common);
    if (!solved) return sn_fail_memory(error, "the solution of a sparse system");
    memcpy(x, factor->solution->x, size * sizeof *x);
    return SN_OK;
}

int64_t sn_sparse_entries(const sn_sparse *factor) {
    const int *counts = factor->factor->nz;
    int64_t sum = 0;
    for (sn_index j = 0; j < factor->n; j++) sum += counts[j];
    return sum;
}

/* ---- the rest -------------------------------------------------------------------------------------------------------- */

void sn_sparse_destroy(sn_sparse *factor) {
    if (!factor) return;
    cholmod_common *common = &factor->common;
    cholmod_free_dense(&factor->solution, common);
    cholmod_free_dense(&factor->work_y, common);
    cholmod_free_dense(&factor->work_e, common);
    cholmod_free_factor(&factor->factor, common);
    cholmod_free_sparse(&factor->matrix, common);
    cholmod_finish(common);
    free(factor->slot);
    free(factor->inverses);
    free(factor->records);
    free(factor);
}
