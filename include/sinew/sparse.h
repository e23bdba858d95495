/*
 * sparse.h -- symmetric positive definite sparse factor and solve (hides CHOLMOD, simplicial LLt with AMD: the same bits everywhere).
 * rank 1
 */
#ifndef SINEW_SPARSE_H
#define SINEW_SPARSE_H

#include "sinew/base.h"

typedef struct sn_sparse sn_sparse;

/* One entry of a symmetric matrix; give each off-diagonal pair once (row >= column or the reverse, either way); repeats add up. */
typedef struct sn_entry {
    sn_index row, column;
    double value;
} sn_entry;

/* Analyse and factor the n x n matrix. SN_ERROR_INPUT with the row in error->element where it is not positive definite. */
SN_MUST_CHECK sn_status sn_sparse_factor(sn_index n, sn_index entry_count, const sn_entry *entries, sn_sparse **out, sn_error *error);
/* Factor again with other values at the same places (same entries in the same order), keeping the symbolic part. */
SN_MUST_CHECK sn_status sn_sparse_refactor(sn_sparse *factor, const sn_entry *entries, sn_error *error);
/* x = A^-1 b for `columns` right-hand sides, each n long, one after the other; x may be b. Three (points) are
 * solved together, and six in little more time than three. Not for two threads on one factor. */
SN_MUST_CHECK sn_status sn_sparse_solve(sn_sparse *factor, sn_index columns, const double *b, double *x, sn_error *error);
/* Numbers in the factor's lower triangle. */
int64_t sn_sparse_entries(const sn_sparse *factor);
void sn_sparse_destroy(sn_sparse *factor); /* NULL is fine */

#endif
