/*
 * moving.h -- a surface whose vertices move while its triangles stay: the nearest of its points, by walking from the last one or exactly,
 * and on which side of it a point is.   rank 1   bodies.md 2, 3
 *
 * The triangles are fixed and shared by all who ask; where the vertices are, each holds for itself (sn_moving_shape).
 */
#ifndef SINEW_MOVING_H
#define SINEW_MOVING_H

#include "sinew/geom.h"

typedef struct sn_moving {
    sn_index vertex_count, triangle_count;
    sn_triangle *triangles; /* (triangle_count) in the order of a space-filling curve at rest */
    sn_index *sources;      /* (triangle_count) which of the mesh each was */
    sn_index (*across)[3];  /* (triangle_count) the triangle beyond the edge opposite to corner 0, 1, 2; SN_NONE = it is on the rim */
    bool *rim;              /* (vertex_count) on an edge that has one triangle */
    sn_index *corner_start; /* (vertex_count + 1) into corners */
    sn_index *corners;      /* (3 triangle_count) triangles at each vertex */
    int depth;              /* of the tree of boxes, a binary heap: node 1 has all triangles, 2i and 2i + 1 the halves of i */
} sn_moving;

/* Of a valid mesh; its vertices keep their numbers. SN_ERROR_INPUT: an edge has more than two triangles, or two that run the same way, so
 * that it has no two sides. */
SN_MUST_CHECK sn_status sn_moving_create(const sn_mesh *mesh, sn_moving *out, sn_error *error);
/* Of any valid mesh: such edges are on the rim. */
SN_MUST_CHECK sn_status sn_moving_create_any(const sn_mesh *mesh, sn_moving *out, sn_error *error);
/* The triangles t with keep[t] (triangle_count), and the vertices on them: vertices (whole->vertex_count) gets the number of each in
 * `whole`. Edges to triangles that are left out are on the rim. At least one triangle must be kept. */
SN_MUST_CHECK sn_status sn_moving_part(const sn_moving *whole, const bool *keep, sn_moving *out, sn_index *vertices, sn_error *error);
void sn_moving_free(sn_moving *moving); /* frees what it owns and zeroes it */
size_t sn_moving_bytes(const sn_moving *moving);

/* ---- boxes --------------------------------------------------------------------------------------------------------------------- */

sn_index sn_moving_box_count(const sn_moving *moving);
sn_index sn_moving_leaf_count(const sn_moving *moving);
/* The leaf that holds a triangle. */
sn_index sn_moving_leaf(const sn_moving *moving, sn_index triangle);
/* Around the triangles at positions (vertex_count): boxes (sn_moving_box_count); box 0 is not used. */
void sn_moving_fit(const sn_moving *moving, const sn_vec3 *positions, sn_box *boxes);
/* Leaves whose boxes meet `box`: touched (sn_moving_leaf_count) becomes true for those; the others stay as they are. */
void sn_moving_touch(const sn_moving *moving, const sn_box *boxes, const sn_box *box, bool *touched);

/* ---- nearest points ------------------------------------------------------------------------------------------------------------ */

/* The surface at one moment. */
typedef struct sn_moving_shape {
    const sn_moving *moving;
    const sn_vec3 *positions; /* (vertex_count) */
    const sn_box *boxes;      /* of sn_moving_fit at these positions */
} sn_moving_shape;

/* From a triangle to neighbours that are nearer as long as there are any: the nearest point of the surface around there. from: any number;
 * one that no triangle has is taken for the first. p must be finite. */
sn_closest sn_moving_walk(const sn_moving_shape *shape, sn_index from, sn_vec3 p);
/* The nearest point of the whole surface; of triangles as near the first. It is the same wherever the search starts, but for its time. */
sn_closest sn_moving_closest(const sn_moving_shape *shape, sn_index from, sn_vec3 p);
/* The signed distance of p, of which `foot` is the nearest point, and its unit gradient (nullable): negative behind the surface, by the
 * angle-weighted pseudonormal (Baerentzen & Aanaes 2005). Beside the rim there is no behind: a foot on it has a distance >= 0. Zero
 * gradient where foot and p are one point and the triangle has no area. */
double sn_moving_side(const sn_moving_shape *shape, const sn_closest *foot, sn_vec3 p, sn_vec3 *gradient);
/* Where a point of the surface (triangle, barycentric) is in another shape of it. */
sn_vec3 sn_moving_point(const sn_moving_shape *shape, const sn_closest *foot);

#endif
