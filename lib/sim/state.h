/*
 * state.h -- inside lib/sim: the parts of a state: the points of a group; what a muscle is told of a step, its inputs; what the back end
 * remembers, which is its own (backend.h); and statistics, which programs see.
 *
 * The lists name the arrays of each part: type, name, count, and whether a run that is saved and continued keeps them. They make, free,
 * count and save them (kept.h). Counts are in terms of `m`, the muscle's model, or `g`, the group.
 */
#ifndef SN_SIM_STATE_H
#define SN_SIM_STATE_H

#include "group.h"

enum { SN_LEFT = false, SN_KEPT = true }; /* left: it is made anew before it is read */

/* A point in single precision, relative to its muscle's origin. */
typedef struct sn_single_point {
    float x, y, z, w; /* m; over the inverse mass of a mean point */
} sn_single_point;

/* The rigid motion of a muscle's bones over one step: the one that fits their attached points best, by mass. A point that goes along with
 * it has come by d / h, d the solution of d = h velocity + turn x (x - d / 2 - middle), x where it is now: an exact rotation. */
typedef struct sn_bone_motion {
    sn_vec3 middle;   /* m: of the attached points, half way through the step */
    sn_vec3 velocity; /* m/s: of the middle */
    sn_vec3 turn;     /* 2 tan(angle / 2) times the axis */
    double rate;      /* 1 / h, 1/s; 0 = no motion to go along with: the bones rest, or have jumped, or there are none */
} sn_bone_motion;

/* guarded: triangles that have a barrier, under back end `qn`. */
#define SN_INPUT_ARRAYS(X)                                                                                                                 \
    X(double, goals, m->distance_start[SN_DISTANCE_KINDS], SN_LEFT) /* goal lengths, m */                                                  \
    X(sn_rigid, poses, m->site_count, SN_LEFT)                      /* of the sites' bones at the end of the step */                       \
    X(sn_rigid, placed, m->site_count, SN_KEPT)                     /* those that the attached points were put at last */                  \
    X(sn_vec3, targets, m->follower_count, SN_LEFT)                 /* of the followers at the end of the step, m */                       \
    X(sn_rigid, joint_poses, m->pose_count, SN_LEFT)                /* room for those of all joints at a time of the muscle's own */       \
    X(sn_rigid, collider_poses, m->collider_count, SN_KEPT)         /* of the bones it may touch, at the end of the step */                \
    X(sn_rigid, collider_placed, m->collider_count, SN_KEPT)        /* and at its beginning */                                             \
    X(sn_vec3, patches, m->patch_points, SN_KEPT)                   /* of the surfaces it may touch, at the end of the step, m */          \
    X(sn_vec3, patches_placed, m->patch_points, SN_KEPT)            /* and at its beginning */                                             \
    X(sn_box, patch_boxes, m->patch_boxes, SN_LEFT)                 /* around their triangles */                                           \
    X(sn_box, patch_boxes_placed, m->patch_boxes, SN_LEFT)                                                                                 \
    X(sn_index, feet, m->feet_count, SN_LEFT)                               /* of rows: the triangle to walk from */                       \
    X(double, multipliers, m->quasi_newton ? m->contact_count : 0, SN_KEPT) /* of the rows of contact, N */                                \
    X(sn_index, near, m->contact_count, SN_LEFT)                            /* those that may act in the step at hand */                   \
    X(sn_index, slides_on, m->external_count, SN_KEPT) /* of each external row: the target that it slides on, as the group counts */       \
    X(sn_index, slides_at, m->external_count, SN_KEPT) /* and the triangle there: where the next search starts */                          \
    X(bool, guarded, m->quasi_newton ? m->area_count : 0, SN_KEPT)                                                                         \
    /* of the skin, where it was evaluated last: normal and 1 / its square of each triangle; force of its barrier, and of each edge's      \
     * spring and hinge, over lengths (skin.c) */                                                                                          \
    X(sn_point, skin_normals, m->skin_triangle_count, SN_LEFT)                                                                             \
    X(double, skin_kept, m->skin_triangle_count, SN_LEFT)                                                                                  \
    X(double, skin_pushes, m->skin_triangle_count, SN_LEFT)                                                                                \
    X(double, skin_pulls, m->skin_edge_count, SN_LEFT)                                                                                     \
    X(double, skin_turns, m->skin_edge_count, SN_LEFT)

/* What one muscle is told of the step at hand. */
typedef struct sn_inputs {
#define SN_INPUT_MEMBER(type, name, count, kept) type *name;
    SN_INPUT_ARRAYS(SN_INPUT_MEMBER)
#undef SN_INPUT_MEMBER
    double *own[SN_ROW_KINDS];      /* numbers that only their own kind reads, made anew from the others */
    sn_vec3 *volume_gradient;       /* (vertex_count) the back end's: dV/dx at the points that were evaluated or projected last; or NULL */
    sn_index near_count;            /* rows of contact that may act */
    double resolved;                /* how far margins have grown to what is asked, in [0,1] */
    double resolve_begin;           /* s: since when they grow; the first frame of the run that this state comes from */
    double parted;                  /* how far what lies in its target at rest is to have come out, in [0,1] */
    double activation, contraction; /* the input in [0,1]; a = contraction x activation */
    double stiffness, volume_goal;  /* k, N/m; g(a) / g(a0) */
    double goal_contraction, goal_ratio; /* what the goals were made for; NaN = not made yet */
    sn_bone_motion bones;                /* over the last step */
} sn_inputs;

/* A substep that is too long for a group is halved so many times at most; parts are counted in the smallest ones. */
#define SN_MOST_HALVINGS 6
#define SN_SUBSTEP_PARTS (1 << SN_MOST_HALVINGS)
/* Where a bone could pass through it. A muscle that tears is helped by the first three alone. */
#define SN_LEAST_TORN_PARTS (SN_SUBSTEP_PARTS / 8)

/* How far a group has come in a substep. */
typedef struct sn_progress {
    sn_index parts;     /* of SN_SUBSTEP_PARTS that are done; all of them: it has nothing left to do */
    sn_index size;      /* parts of the step at hand; 0 = it sleeps through the substep */
    sn_index iteration; /* of that step that are done */
    sn_index spent;     /* iterations of all steps of this substep, those that were given up among them */
} sn_progress;

#define SN_POINT_ARRAYS(X)                                                                                                                 \
    X(sn_point, points, g->point_count, SN_KEPT)                                                                                           \
    X(sn_vec3, velocities, g->point_count, SN_KEPT)                                                                                        \
    X(sn_vec3, previous, g->point_count, SN_KEPT)                                                                                          \
    X(sn_vec3, target_points, g->target_points, SN_KEPT)             /* of targets that move by themselves, at the end of the step, m */   \
    X(sn_vec3, target_points_placed, g->target_points, SN_KEPT)      /* and at its beginning */                                            \
    X(sn_box, target_boxes, g->target_boxes, SN_LEFT)                /* room for those around targets where they are looked for */         \
    X(sn_vec3, here, g->row_count > 0 ? g->point_count : 0, SN_LEFT) /* where points are in an iteration, or at a frame's end */

/* The points of a group, how far it has come, and its members. */
typedef struct sn_group_state {
#define SN_POINT_MEMBER(type, name, count, kept) type *name;
    SN_POINT_ARRAYS(SN_POINT_MEMBER)
#undef SN_POINT_MEMBER
    sn_muscle_state **members; /* (group.count) */
    sn_progress progress;      /* in the substep at hand, or through with the last one */
    sn_index still;            /* substeps in a row that moved nothing */
    void *memory;              /* the back end's own; nullable */
} sn_group_state;

/* Room for nothing but what is kept (a state that is read), or for all of it. */
SN_MUST_CHECK sn_status sn_state_make(const sn_model *model, bool kept_only, sn_state **out, sn_error *error);
/* Bytes of one group and its members: arrays, structs, what the back end remembers but for factors. */
size_t sn_group_state_bytes(const sn_model *model, const sn_group *g);

#endif
