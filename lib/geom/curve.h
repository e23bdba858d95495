/*
 * curve.h -- triangles in the order of a space-filling curve, so that consecutive ones are near each other; private to lib/geom.
 */
#ifndef SINEW_GEOM_CURVE_H
#define SINEW_GEOM_CURVE_H

#include "sinew/mesh.h"

/* order (triangle_count): the triangles by where their centres lie along the curve (Morton 1966, 21 bits of each axis); of those at one
 * place the one with the lower vertices, then the lower number first. */
SN_MUST_CHECK sn_status sn_curve_order(const sn_mesh *mesh, sn_index *order, sn_error *error);

#endif
