/*
 * two_level.h -- inside lib/sim: what a muscle resists when its sections move as rigid bodies, beside the scalar matrix.   numerics.md 7
 */
#ifndef SN_SIM_TWO_LEVEL_H
#define SN_SIM_TWO_LEVEL_H

#include "sinew/sim.h"

enum { SN_COARSE_OVERLAP = 2 }; /* sections that a point belongs to, at most */
enum { SN_COARSE_MODES = 6 };   /* of a section: translations along x, y, z, then rotations about them, through its middle */

/* The coarse space Z of one muscle: column 6 c + k is mode k of section c, times the points' weights in it; zero at carried points. */
typedef struct sn_two_level {
    const sn_model_muscle *model;          /* NULL = there is none */
    sn_index count, size;                  /* sections; 6 x as many columns */
    sn_index (*member)[SN_COARSE_OVERLAP]; /* (points) sections of a point, the nearest first; SN_NONE behind the last */
    double (*weight)[SN_COARSE_OVERLAP];   /* (points) theirs, 1 in sum; 0 at carried points */
    double *total;                         /* (count) sum of the weights */
    sn_vec3 *middle;                       /* (count) weighted means of the free points, m */
    sn_vec3 *at;                           /* (points) where H was taken, m */
    double *factor;                        /* (size x size) U of ZT H Z = UT U, by rows; below the diagonal nothing */
    double *inverse;                       /* (size) 1 / U_jj; 0 = a mode that the others already make, left out */
    double *amount;                        /* (size) of each column: what sn_two_level_solve found */
} sn_two_level;

/* Sections of the rest shape and all memory. *out is empty where no point is free. false: no memory. */
bool sn_two_level_create(const sn_model_muscle *m, sn_two_level *out);
void sn_two_level_free(sn_two_level *t);
/* Modes and ZT H Z at positions (points; copied), H = M / h^2 + k sum scale g gT over the rows there (Gauss-Newton), free points only;
 * without areas and volume. */
void sn_two_level_update(sn_two_level *t, const sn_vec3 *positions, double h, double stiffness);
/* amount = (ZT H Z)^-1 ZT in; in (points). */
void sn_two_level_solve(sn_two_level *t, const sn_vec3 *in);
/* out (points) += share Z amount. */
void sn_two_level_add(const sn_two_level *t, double share, sn_vec3 *out);

#endif
