/*
 * distance_field.h -- the signed distance to a rigid surface, tabulated: value and gradient of a point in a few nanoseconds.   rank 1
 *
 * Near the surface a grid of cubes ("bricks") of 8^3 cells holds the distance at every corner; elsewhere, deep inside too, a grid of four
 * cells' width does. Both are interpolated trilinearly, and meet without a step: corners that a brick shares with the coarse grid take
 * its values. Memory goes with the area of the surface; the coarse grid takes 36 bytes for 512 cells of the box.
 *
 * All lengths are in the unit of the mesh (metres, in the frame of the bone). Negative inside.
 */
#ifndef SINEW_DISTANCE_FIELD_H
#define SINEW_DISTANCE_FIELD_H

#include "sinew/mesh.h"
#include "sinew/thread.h"

/* ---- the solid that a surface stands for (lib/geom/solid.c solid_inner.c) ------------------------------------------- */

/* What was done to a surface to make it bound a solid. */
typedef struct sn_solid_report {
    sn_index joined_vertices;    /* at the same place as another, to 1e-7 of the diagonal */
    sn_index dropped_triangles;  /* without area, or a second time on the same vertices: a layer that lies on another */
    sn_index caps;               /* loops of border edges, or of edges whose triangles disagree, that were closed */
    sn_index cap_triangles;      /* by these, the last but for inner ones */
    sn_index turned;             /* components turned outwards */
    bool inside_out;             /* all of the surface was turned */
    sn_index inner_triangles;    /* with the solid on both of their sides: walls inside, overlaps of pieces; they bound nothing */
    sn_index boundary_triangles; /* the others, which come first */
    double volume;               /* enclosed, overlaps counted as often as they are; 0 for a sheet */
} sn_solid_report;

/* A surface, however it is kept, as the boundary of a solid: vertices at one place are joined, layers on each other are one, border loops
 * are closed by the triangulation of least area (Barequet, Sharir 1995; cones where longer than 200 edges), pieces are turned outwards,
 * cavities stay. The winding number of *out is an integer off the surface, and not 0 inside. The boundary comes first in *out, then
 * what lies within the solid. A sheet that encloses nothing comes back as it is, closed by itself, with no inside. Edges whose triangles
 * run the same way (badly wound) count as borders. SN_ERROR_INPUT: not a valid mesh, or no triangle has an area. pool may be NULL; the
 * result is the same. */
SN_MUST_CHECK sn_status sn_solid_surface(const sn_mesh *mesh, sn_pool *pool, sn_mesh *out, sn_solid_report *report, sn_error *error);

/* ---- the field (lib/geom/distance_field.c, distance_field_build.c) --------------------------------------------------------- */

enum {
    SN_BRICK_CELLS = 8,                    /* along an axis */
    SN_BRICK_CORNERS = SN_BRICK_CELLS + 1, /* along an axis */
    SN_BRICK_VALUES = SN_BRICK_CORNERS * SN_BRICK_CORNERS * SN_BRICK_CORNERS,
    SN_COARSE_CELLS = 4, /* width of the coarse grid, in cells */
};

typedef struct sn_distance_field_params {
    double cell;   /* width of a cell; > 0 */
    double band;   /* cells: corners nearer to the surface than this hold its distance to the rounding of a float; 1 to 16, default 3 */
    sn_pool *pool; /* NULL = the caller's thread; the field is the same */
} sn_distance_field_params;

/* Everything is plain data; read it with the functions below. */
typedef struct sn_distance_field {
    double cell, band;      /* band in the mesh's unit */
    sn_vec3 origin;         /* the lowest corner */
    sn_index bricks[3];     /* along x, y, z, each >= 1 */
    sn_box box;             /* of the surface itself; the bricks reach farther by a cell more than the band, at least */
    sn_index brick_count;   /* that hold values */
    sn_index *brick;        /* (bricks x y z; x runs fastest) which values, or SN_NONE = coarse */
    float *values;          /* (brick_count x SN_BRICK_VALUES), x runs fastest */
    float *coarse;          /* ((2 bricks + 1) of x y z), x runs fastest */
    sn_solid_report report; /* of how it was built */
} sn_distance_field;

sn_distance_field_params sn_distance_field_defaults(double cell);
/* The distance to the boundary of the solid that mesh stands for (sn_solid_surface). At corners of the grid within the band it is exact;
 * elsewhere in bricks too, but for faces shared with the coarse grid. A sheet that encloses nothing has distances >= 0.
 * SN_ERROR_INPUT: as sn_solid_surface. SN_ERROR_USAGE: cell or band out of range, or a cell so small that more than 1 GB or 2^31 cells
 * would be taken; the sentence names one that fits. The same bits for any number of threads. */
SN_MUST_CHECK sn_status sn_distance_field_create(const sn_mesh *mesh, const sn_distance_field_params *params, sn_distance_field *out,
                                                 sn_error *error);
void sn_distance_field_free(sn_distance_field *field); /* frees what it owns and zeroes it */
/* The interpolated distance at p, and its exact gradient (nullable; of one side where p lies between cells). It is continuous within the
 * grid. Outside of the grid: the distance to the surface's box, which is less than the true one and more than the band, and its gradient.
 * NaN where p is not finite. */
double sn_distance_field_at(const sn_distance_field *field, sn_vec3 p, sn_vec3 *gradient);
/* The same for many points; gradients is nullable. */
void sn_distance_field_at_all(const sn_distance_field *field, sn_index count, const sn_vec3 *points, double *values, sn_vec3 *gradients);
/* Is p surely outside and farther than `distance` (>= 0) from the surface? Cheap; false where it would take a closer look. The ball of
 * radius r around p is farther than d where farther(p, d + r). */
bool sn_distance_field_farther(const sn_distance_field *field, sn_vec3 p, double distance);
sn_box sn_distance_field_box(const sn_distance_field *field);   /* what the grid covers */
size_t sn_distance_field_bytes(const sn_distance_field *field); /* of memory */
/* Sizes fit each other, brick numbers run upwards, every number is finite and none larger than the grid's diagonal allows. False for what
 * sn_distance_field_create cannot have made. */
bool sn_distance_field_is_valid(const sn_distance_field *field);
/* Names what a field depends on: positions, triangles, cell, band and the version of the method. */
SN_MUST_CHECK sn_status sn_distance_field_hash(const sn_mesh *mesh, const sn_distance_field_params *params, char out[SN_HASH_LENGTH],
                                               sn_error *error);

#endif
