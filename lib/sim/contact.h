/*
 * contact.h -- inside lib/sim: which bones, and which surfaces that change their shape, a muscle may touch; a row for each of its vertices
 * (or samples of its triangles) and each of those; and what a step does with them.   bodies.md 2, numerics.md 7
 *
 * C = phi(x) - m: phi the signed distance to the bone in its own frame, or to the surface as it is at the end of the step; m the margin
 * that the row keeps, at most what it had at rest. A collider is a bone or the part of a surface that comes near the muscle, its patch.
 */
#ifndef SN_SIM_CONTACT_H
#define SN_SIM_CONTACT_H

#include "backend.h"
#include "rows.h"
#include "sinew/distance_field.h"
#include "sinew/moving.h"
#include "sinew/voxels.h"

/* Of a body of that volume and surface, of a rod its diameter; 0: it encloses nothing, or that is not known (NaN). */
static inline double sn_thickness(double volume, double area) {
    double thickness = area > 0.0 ? 4.0 * fabs(volume) / area : 0.0;
    return thickness > 0.0 ? thickness : 0.0;
}

/* ---- contact_reach.c: before any muscle is built ------------------------------------------------------------------------------------ */

/* A surface of the scene that muscles may touch. */
typedef struct sn_contact_surface {
    sn_moving moving;    /* vertices at one place are one; empty where nobody touches it */
    sn_index *vertices;  /* (moving.vertex_count) of the surface's mesh */
    double thickness;    /* m; 0 = it encloses nothing */
    sn_index first_leaf; /* of those of all surfaces */
    sn_vec3 *positions;  /* (moving.vertex_count) room, while the motion is looked at */
    sn_box *boxes;
} sn_contact_surface;

/* Which bones come near which muscle over the motion, and the fields of those bones; which parts of surfaces do. */
struct sn_contact_plan {
    sn_index muscle_count, bone_count;  /* of the scene */
    bool *reach;                        /* (muscle_count x bone_count) */
    sn_distance_field *fields;          /* (bone_count) empty where no muscle comes near */
    double *thickness;                  /* (bone_count) m */
    sn_voxels *voxels;                  /* (bone_count) the same, where the collision is by voxels; else NULL */
    sn_index surface_count, leaf_count; /* of the scene; of those that may be touched */
    sn_contact_surface *surfaces;       /* (surface_count) */
    bool *touched;                      /* (muscle_count x leaf_count) */
};

/* *out stays NULL where contact is off. */
SN_MUST_CHECK sn_status sn_contact_plan_create(const sn_scene *scene, const sn_model_options *options, struct sn_contact_plan **out,
                                               sn_error *error);
void sn_contact_plan_destroy(struct sn_contact_plan *plan); /* NULL is fine */

/* ---- contact_patch.c: surfaces of the scene, before any muscle is built --------------------------------------------------------------
 */

/* Those that may be touched. SN_ERROR_INPUT: one is not loaded, or has no two sides. */
SN_MUST_CHECK sn_status sn_contact_surfaces_make(const sn_scene *scene, struct sn_contact_plan *plan, sn_error *error);
/* Mark what comes near muscles at a moment: boxes (muscle_count) of those; one that is empty takes no part. */
void sn_contact_surfaces_look(const sn_scene *scene, const sn_surface_moment *at, const sn_box *boxes, struct sn_contact_plan *plan);
void sn_contact_surfaces_free(struct sn_contact_plan *plan);
bool sn_contact_surface_near(const struct sn_contact_plan *plan, sn_index muscle, sn_index surface);

/* ---- the rows of one muscle: m->own[SN_ROWS_CONTACT] (contact_build.c) ------------------------------------------------------------- */

/* What a muscle may touch of a surface: its triangles where the muscle comes over the motion. */
typedef struct sn_patch {
    const sn_scene_surface *surface;
    sn_moving moving;
    sn_index *vertices;                          /* (moving.vertex_count) of the surface's mesh */
    sn_index first_point, first_box, first_foot; /* in the state's arrays */
} sn_patch;

typedef struct sn_collider {
    sn_index bone, joint;           /* of the scene, a surface's as sn_scene_touched_name counts them; joint SN_NONE = it never moves */
    const sn_distance_field *field; /* NULL: it is a patch */
    sn_patch *patch;                /* owned; NULL: it is a bone */
    const sn_voxels *voxels;        /* NULL = it is kept out by its field; else that only tells how deep it is (contact_voxels.c) */
    double limit;                   /* m: a surface that passes by farther in a step could pass through */
    sn_index begin, end;            /* its rows */
} sn_collider;

/* A vertex (weight 1, 0, 0) or a point of a triangle. */
typedef struct sn_contact_row {
    sn_index point[3];
    float weight[3];
    float margin; /* m; below the asked one where it was nearer at rest; negative: it overlaps at rest */
} sn_contact_row;

typedef struct sn_contacts {
    sn_collider *colliders; /* (m->collider_count) in the order of the scene's bones, then of its surfaces */
    sn_contact_row *rows;   /* (m->contact_count) by collider */
    double margin;          /* m: asked for */
    double friction;
    double begin, resolve; /* s: of a run that starts anew, margins grow to what is asked from `begin` on, in `resolve`; 0 = never */
    bool by_voxels;        /* of all colliders */
    sn_bone_hits bone_hits;
} sn_contacts;

static inline const sn_contacts *sn_contacts_of(const sn_model_muscle *m) { return m->own[SN_ROWS_CONTACT]; }

/* The part of a surface that comes near a muscle (contact_patch.c). */
SN_MUST_CHECK sn_status sn_patch_make(const struct sn_contact_plan *plan, sn_index muscle, sn_index surface, sn_patch *out,
                                      sn_error *error);
void sn_patch_free(sn_patch *patch); /* of the heap; NULL is fine */

sn_left_out sn_contacts_reason(const sn_build *build);
SN_MUST_CHECK sn_status sn_contacts_build(const sn_build *build, sn_row_kind kind, sn_error *error);
void sn_contacts_destroy(sn_model_muscle *m, sn_row_kind kind);

/* ---- one row (contact.c) ---------------------------------------------------------------------------------------------------------------
 */

/* Phi of row r's point, where it is now, m. */
double sn_contact_distance(const sn_model_muscle *m, const sn_muscle_state *s, const sn_collider *collider, sn_index r);
double sn_contact_margin(const sn_contacts *contacts, const sn_muscle_state *s, const sn_contact_row *row); /* now, m */
/* Move its points so that C >= 0, by its own gradient; `rubs`: with friction. false: it was, or there is no way out. */
bool sn_contact_project(const sn_model_muscle *m, sn_muscle_state *s, const sn_collider *collider, sn_index r, bool rubs);

/* ---- rows that stand together, passed over at once (contact_block.c) ------------------------------------------------------------------
 */

enum { SN_CONTACT_BLOCK = 32 };

/* Rows begin to end - 1 of a collider, their points in a ball. */
typedef struct sn_contact_block {
    sn_index begin, end;
    sn_vec3 middle;
    double radius;
} sn_contact_block;

/* That of row `begin` and those after it, where `before` (point_count) has the points, or, NULL, the state's `points`. */
sn_contact_block sn_contact_block_at(const sn_contacts *contacts, const sn_collider *collider, sn_index begin, const sn_point *points,
                                     const sn_vec3 *before);
/* Where a row's point is. */
sn_vec3 sn_contact_point(const sn_contact_row *row, const sn_point *points);
/* A row's mean of one vector of each point. */
sn_vec3 sn_contact_mean(const sn_contact_row *row, const sn_vec3 *of_points);

/* ---- what comes near in a step (contact_near.c) ------------------------------------------------------------------------------------
 */

/* A muscle in a step. */
typedef struct sn_contact_whole {
    sn_box box;   /* of its points before the step */
    sn_vec3 way;  /* mean way of its attached points in the step */
    double reach; /* how far beside that way a point may come, m */
    sn_vec3 pull; /* what the weight adds to the way of a point that flies, m */
    double h;     /* s */
    double flies; /* how far beside the mean way a point comes that does, at most, m */
} sn_contact_whole;

/* Where a row's point starts and the two ways that it may take: along with the muscle, and where it flies. */
typedef struct sn_contact_start {
    sn_vec3 from, along, flying;
} sn_contact_start;

/* A collider in a step. */
typedef struct sn_approach {
    const sn_collider *collider;
    sn_rigid before, after; /* bone: from the world into its frame, before the step and after it */
    double turn;            /* bone: how far the step's turn carries a point that is 1 m off its axis, m */
    sn_moving_shape was, is;
    sn_index *feet; /* patch: (its rows) the triangle to walk from */
} sn_approach;

sn_approach sn_approach_of(const sn_model_muscle *m, const sn_muscle_state *s, sn_index collider);
/* Could any point of the muscle come to it in the step? By the ball around the muscle's box. */
bool sn_approach_whole(const sn_approach *a, const sn_contact_whole *w, double margin);
/* How far from a block's middle a point would have to be to come as near as `reach`, on one of the two ways: of none that is in the block
 * if not below its radius. */
double sn_approach_block(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w, double reach);
/* Could a point of a near block, `far` its sn_approach_block? Of a bone the row itself is asked as quickly. */
bool sn_approach_may(const sn_approach *a, const sn_contact_block *b, double far, sn_vec3 from);
/* Could the point of row r? */
bool sn_approach_row(const sn_approach *a, sn_index r, const sn_contact_start *at, double reach);
/* Is the point of row r passed by farther than is safe on its way, and comes nearer than `margin`? */
bool sn_approach_passes(const sn_approach *a, sn_index r, sn_vec3 from, sn_vec3 to, double margin);
/* Is everything passed by slowly enough that nothing passes through? */
bool sn_approach_is_slow(const sn_approach *a, const sn_contact_whole *w);
/* Phi at the middle of a block at the end of the step; from any point's it differs by no more than that is away from the middle. */
double sn_approach_distance(const sn_approach *a, const sn_contact_block *b);
/* So: may any point of the block be nearer than `reach`? May the point p of it? */
bool sn_approach_block_is_near(const sn_contact_block *b, double distance, double reach);
bool sn_approach_row_is_near(const sn_approach *a, const sn_contact_block *b, double distance, sn_vec3 p, double reach);

/* ---- patches in a step (contact_surface.c) ----------------------------------------------------------------------------------------- */

/* Where the vertices are at that moment, and the boxes around them and around where they were placed. */
void sn_patches_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at);
/* The boxes alone: of a state that was read. */
void sn_patches_fit(const sn_model_muscle *m, sn_muscle_state *s);
/* What was placed is what is aimed at. */
void sn_patches_keep(const sn_model_muscle *m, sn_muscle_state *s);
sn_moving_shape sn_patch_shape(const sn_patch *patch, const sn_muscle_state *s);        /* at the end of the step */
sn_moving_shape sn_patch_shape_before(const sn_patch *patch, const sn_muscle_state *s); /* at its beginning */
bool sn_patch_moved(const sn_patch *patch, const sn_muscle_state *s);
/* Walks of row r start at the triangle nearest to p, of all the patch, from now on; nothing for a bone. */
void sn_patch_find(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p);
/* Signed distance of p, row r's point, by walking, and the gradient (nullable). */
double sn_patch_distance(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p, sn_vec3 *gradient);
/* The same by the nearest point of all the patch. */
double sn_patch_distance_exact(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p);
/* How far the surface carries the point nearest to p in the step. */
sn_vec3 sn_patch_way(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p);

/* ---- by voxels (contact_voxels.c); the others hand over to these where the muscle's contacts are by voxels --------------------------- */

/* Those of one bone, whose mesh is in metres. */
SN_MUST_CHECK sn_status sn_contact_voxels_make(const sn_scene *scene, const sn_mesh *mesh, sn_voxels *out, sn_error *error);
/* One pass over the rows, by the two rules of [K21] 3.2. */
void sn_contact_voxels_sweep(const sn_model_muscle *m, sn_muscle_state *s);
/* After the iterations, before velocities are taken: vertices that stop. */
void sn_contact_voxels_finish(const sn_model_muscle *m, sn_muscle_state *s);
/* Is the vertex of a row in touch with the bone, as far as voxels tell? */
bool sn_contact_voxels_touch(const sn_collider *collider, const sn_rigid *pose, sn_vec3 at);

/* ---- a step (contact_step.c); each does nothing for a muscle without contacts ------------------------------------------------------- */

/* The poses of the colliders at that moment; at->poses may be NULL. */
void sn_contacts_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at);
/* Margins grow from the first frame of this run on, however it is stopped and continued. */
void sn_contacts_begin(const sn_model_muscle *m, sn_muscle_state *s);
/* They are where they start; nothing pushes. */
void sn_contacts_reset(const sn_model_muscle *m, sn_muscle_state *s);
/* Has a collider moved that is near the muscle, or a margin grown, in the step that began at `since` (s)? */
bool sn_contacts_moved(const sn_model_muscle *m, const sn_muscle_state *s, double since);
/* A group that slept through a step: the colliders have come this far. */
void sn_contacts_sleep(const sn_model_muscle *m, sn_muscle_state *s);
/* Would a bone pass by a point that it may hit, or fly into it, farther than is safe? The points are those before the step, the attached
 * ones too. */
bool sn_contacts_too_far(const sn_model_muscle *m, const sn_muscle_state *s, const sn_substep *substep);
/* The rows that may act in the step, whose `previous` points are set and whose attached points are placed. */
void sn_contacts_gather(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep);
/* Move near points (point_count) that are beyond their margins out of the bones, one row after the other; false: there were none. */
bool sn_contacts_clear(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points);
/* qn: multipliers for the next step, from stiffness k, N/m. The share of the acting rows that have begun or ceased to act. */
double sn_contacts_update(const sn_model_muscle *m, sn_muscle_state *s, double k);
/* No vertex is left beyond its margin, also one that nobody thought near; the colliders have come this far. */
void sn_contacts_finish(const sn_model_muscle *m, sn_muscle_state *s);
/* Contacts, and the deepest vertex. */
void sn_contacts_measure(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out);

#endif
