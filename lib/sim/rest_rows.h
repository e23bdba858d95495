/*
 * rest_rows.h -- inside lib/sim: every elastic row of a muscle linearised at its rest shape, or at another one, for the matrices of the
 * quasi-Newton back end.
 */
#ifndef SN_SIM_REST_ROWS_H
#define SN_SIM_REST_ROWS_H

#include "rows.h"

/* Its energy is about scale k / 2 (sum gradient . u)^2 for small displacements u, and its Hessian on each axis at most scale k K KT. */
typedef struct sn_rest_row {
    int count; /* points, at most 4 */
    const sn_index *point;
    double weight[4];    /* K */
    sn_vec3 gradient[4]; /* of its C */
    double scale;        /* stiffness over k */
} sn_rest_row;

/* Calls visit for each row at positions (points), in the order of the table; false: visit returned false. */
bool sn_rows_at(const sn_model_muscle *m, const sn_vec3 *positions, bool (*visit)(void *user, const sn_rest_row *row), void *user);

#endif
