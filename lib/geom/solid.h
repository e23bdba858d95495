/*
 * solid.h -- which triangles bound a solid. Private to lib/geom.
 */
#ifndef SINEW_GEOM_SOLID_H
#define SINEW_GEOM_SOLID_H

#include "sinew/distance_field.h"

/* Sort the triangles of a closed surface, turned outwards: first those with a side outside, then those with the solid on both sides. Each
 * kind keeps its order; the report has their numbers. */
SN_MUST_CHECK sn_status sn_sort_out_inner(sn_mesh *mesh, sn_pool *pool, sn_solid_report *report, sn_error *error);

#endif
