/*
 * triangular.h -- inside lib/geom: x = (L LT)^-1 b for three or six right-hand sides at a time.
 */
#ifndef SN_GEOM_TRIANGULAR_H
#define SN_GEOM_TRIANGULAR_H

#include "sinew/base.h"

/* L by columns: column j has count[j] rows from start[j] on, ascending, the first of them j itself. Borrowed. */
typedef struct sn_lower {
    sn_index n;
    const int *start, *count, *rows;
    const double *values;
    const double *inverses; /* (n) 1 / L_jj */
} sn_lower;

/* In place; triples: 1 or 2. records (n x 4 triples): of each row the right-hand sides side by side, three and a spare number, then three
 * and one more. The same bits with and without AVX, alone and in pairs. */
void sn_triangular_solve(const sn_lower *l, int triples, double *records);

#endif
