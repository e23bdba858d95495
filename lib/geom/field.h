/*
 * field.h -- the weights of the cotangent Laplacian; private to lib/geom.
 */
#ifndef SINEW_GEOM_FIELD_H
#define SINEW_GEOM_FIELD_H

#include "sinew/mesh.h"

/* w = (cot alpha + cot beta) / 2 over the angles opposite to the edge, kept within 1e-3 and 1e3. */
double sn_edge_weight(const sn_mesh *mesh, const sn_edge *edge);

#endif
