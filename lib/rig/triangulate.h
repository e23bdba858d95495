/*
 * triangulate.h -- a plane polygon as triangles. Private to lib/rig.
 */
#ifndef SINEW_RIG_TRIANGULATE_H
#define SINEW_RIG_TRIANGULATE_H

#include "sinew/vec.h"

typedef struct polygon_point {
    double x, y;
} polygon_point;

/* A constrained Delaunay triangulation; vertices 0 .. corners - 1 are the polygon's, the others lie inside. */
typedef struct polygon_mesh {
    sn_index corners, vertex_count, triangle_count;
    polygon_point *points;    /* (vertex_count) */
    sn_index (*triangles)[3]; /* (triangle_count) anticlockwise */
    sn_index (*across)[3];    /* (triangle_count) the triangle beyond the edge opposite to corner 0, 1, 2; SN_NONE = the rim */
} polygon_mesh;

/* corners (count >= 3) anticlockwise; inner points on a triangular grid about `spacing` apart, at most `most_inner`. A polygon that crosses
 * itself is triangulated as far as its topology goes: some triangles are then turned over. */
SN_MUST_CHECK sn_status polygon_triangulate(sn_index count, const polygon_point *corners, double spacing, sn_index most_inner,
                                            polygon_mesh *out, sn_error *error);
/* Triangles in the plane, as in a polygon_mesh; all borrowed. */
typedef struct polygon_view {
    const polygon_point *points;
    sn_index triangle_count;
    sn_index (*triangles)[3], (*across)[3];
} polygon_view;
/* The triangle that holds `at`, searched from `hint`; SN_NONE = none. weights (nullable) are barycentric. */
sn_index polygon_locate(const polygon_view *view, polygon_point at, sn_index hint, double weights[3]);
void polygon_free(polygon_mesh *mesh);

#endif
