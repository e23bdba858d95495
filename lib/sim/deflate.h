/*
 * deflate.h -- inside lib/sim: the volume rows of a group of muscles, beside the one matrix that all of them share.   bodies.md 3
 *
 * H = A + sum k_m g_m g_mT. Woodbury's formula takes a solve with A for each muscle. Here each has s_m = B_m^-1 g_m instead, B_m the
 * muscle's own block of A, with what couplings add to its diagonal: all of them are one solve with a matrix that falls apart into blocks.
 * On the space S of these the inverse is exact, and beside it that of A:   PT = 1 - H S E^-1 ST,  E = ST H S,
 *
 *   H^-1 ~ P A^-1 PT + S E^-1 ST
 *
 * which is symmetric and positive definite (balancing: Mandel 1993). H S is g on the muscle itself, and on others nothing but couplings.
 * Numbers are those of free points as the matrix has them: of one with a row for each point, x of all, then y and z of all; of one with
 * three, point after point.
 */
#ifndef SN_SIM_DEFLATE_H
#define SN_SIM_DEFLATE_H

#include "sinew/sparse.h"

typedef struct sn_deflation sn_deflation;

/* For a matrix with `size` rows for each free point, 1 or 3, whose entries (entry_count; their places count, not their values) are these;
 * the points of member m are those from first[m] to before first[m + 1] (count + 1). NULL: no memory. */
sn_deflation *sn_deflation_create(sn_index count, const sn_index *first, int size, sn_index entry_count, const sn_entry *entries);
void sn_deflation_destroy(sn_deflation *d); /* NULL is fine */
/* The matrix has these values now; the volume rows are to be set anew. false: no memory, no factor. */
bool sn_deflation_factor(sn_deflation *d, const sn_entry *entries);
/* The volume rows: gradient (3 x points; is lost) of each member's volume on its own points, stiffness k_V by member, 0 = no row.
 * false: no memory, no factor. */
bool sn_deflation_set(sn_deflation *d, double *gradient, const double *stiffness);
bool sn_deflation_acts(const sn_deflation *d); /* is there a row? */
/* right = PT right, and E^-1 ST right is kept for the other. */
bool sn_deflation_before(sn_deflation *d, double *right);
/* solution = P solution + S E^-1 ST right. */
bool sn_deflation_after(sn_deflation *d, double *solution);

#endif
