/*
 * fibers.h -- volume fibres of a muscle in motion: their lengths, the skinning blend that they are compared with, and what runs through
 * bones.   rank 2
 *
 * The fibres themselves follow the surface by embedding.h. Points are in the unit of the muscle's document, poses in metres.
 */
#ifndef SINEW_FIBERS_H
#define SINEW_FIBERS_H

#include "sinew/embedding.h"
#include "sinew/scene.h"

/* The polylines of a muscle in one array of points. */
typedef struct sn_fiber_bundle {
    sn_index fiber_count, point_count;
    sn_index *start;     /* (fiber_count + 1) fibre i has the points start[i] .. start[i + 1] - 1 */
    sn_vec3 *points;     /* (point_count) at rest */
    double *rest_length; /* (fiber_count) */
} sn_fiber_bundle;

/* SN_ERROR_INPUT where there is no fibre, or one of no length. */
SN_MUST_CHECK sn_status sn_fiber_bundle_create(const sn_fibers *fibers, sn_fiber_bundle *out, sn_error *error);
void sn_fiber_bundle_free(sn_fiber_bundle *bundle); /* frees what it owns and zeroes it */
/* lengths (fiber_count) of the fibres with their points at `points` (point_count), in the same unit. */
void sn_fiber_lengths(const sn_fiber_bundle *bundle, const sn_vec3 *points, double *lengths);

/* ---- the skinning blend of Modenese and Kohout, as [K21] 5 tells it ---------------------------------------------------------- */

/* x' = (1 - w) T_o x + w T_i x, w = s^exponent: T_o and T_i are the motions of the bones that the fibre's first and last point hang on, s
 * the share of the fibre's rest length that lies before x. */
typedef struct sn_fiber_blend {
    double meters_per_unit;
    sn_index *joints; /* (2 x fiber_count) of the origin's and the insertion's bone; SN_NONE = it never moves */
    double *weights;  /* (point_count) w */
} sn_fiber_blend;

/* The bone at a fibre's end is the one with the attached vertex that is nearest to it. SN_ERROR_INPUT where nothing is attached; exponent
 * must be above 0. */
SN_MUST_CHECK sn_status sn_fiber_blend_create(const sn_scene *scene, const sn_muscle *muscle, const sn_fiber_bundle *bundle,
                                              double exponent, sn_fiber_blend *out, sn_error *error);
void sn_fiber_blend_free(sn_fiber_blend *blend); /* frees what it owns and zeroes it */
/* points (point_count) with the scene's joints at `poses`. */
void sn_fiber_blend_apply(const sn_fiber_blend *blend, const sn_fiber_bundle *bundle, const sn_rigid *poses, sn_vec3 *points);

/* ---- fibres in bones --------------------------------------------------------------------------------------------------------- */

/* Search structures over the bones of a scene, which must outlive them and have their meshes loaded. */
typedef struct sn_bone_probe sn_bone_probe;

typedef struct sn_penetration {
    sn_index inside; /* points inside a bone */
    double deepest;  /* m, how far below its surface; 0 = none is inside */
    sn_index bone;   /* where that is; SN_NONE = nowhere */
} sn_penetration;

SN_MUST_CHECK sn_status sn_bone_probe_create(const sn_scene *scene, sn_bone_probe **out, sn_error *error);
void sn_bone_probe_destroy(sn_bone_probe *probe); /* NULL is fine */
sn_penetration sn_bone_probe_points(sn_bone_probe *probe, const sn_rigid *poses, sn_index count, const sn_vec3 *points,
                                    double meters_per_unit);

#endif
