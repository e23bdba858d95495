/*
 * contact.h -- inside lib/sim: which bones a muscle may touch, a row for each of its vertices (or samples of its triangles) and each of
 * those bones, and what a step does with them.   bodies.md 2, numerics.md 7
 *
 * C = phi(x) - m: phi the signed distance to the bone in its own frame, m the margin that the row keeps, at most what it had at rest.
 */
#ifndef SN_SIM_CONTACT_H
#define SN_SIM_CONTACT_H

#include "backend.h"
#include "rows.h"
#include "sinew/distance_field.h"
#include "sinew/voxels.h"

/* ---- contact_reach.c: before any muscle is built ------------------------------------------------------------------------------------ */

/* Which bones come near which muscle over the motion, and the fields of those bones. */
struct sn_contact_plan {
    sn_index muscle_count, bone_count; /* of the scene */
    bool *reach;                       /* (muscle_count x bone_count) */
    sn_distance_field *fields;         /* (bone_count) empty where no muscle comes near */
    double *thickness;                 /* (bone_count) m */
    sn_voxels *voxels;                 /* (bone_count) the same, where the collision is by voxels; else NULL */
};

/* *out stays NULL where contact is off. */
SN_MUST_CHECK sn_status sn_contact_plan_create(const sn_scene *scene, const sn_model_options *options, struct sn_contact_plan **out,
                                               sn_error *error);
void sn_contact_plan_destroy(struct sn_contact_plan *plan); /* NULL is fine */

/* ---- the rows of one muscle: m->own[SN_ROWS_CONTACT] (contact_build.c) ------------------------------------------------------------- */

typedef struct sn_collider {
    sn_index bone, joint; /* of the scene; joint SN_NONE = it never moves */
    const sn_distance_field *field;
    const sn_voxels *voxels; /* NULL = it is kept out by its field; else that only tells how deep it is (contact_voxels.c) */
    double limit;            /* m: a surface that passes by farther in a step could pass through */
    sn_index begin, end;     /* its rows */
} sn_collider;

/* A vertex (weight 1, 0, 0) or a point of a triangle. */
typedef struct sn_contact_row {
    sn_index point[3];
    float weight[3];
    float margin; /* m; below the asked one where it was nearer at rest; negative: it overlaps at rest */
} sn_contact_row;

typedef struct sn_contacts {
    sn_collider *colliders; /* (m->collider_count) in the order of the scene's bones */
    sn_contact_row *rows;   /* (m->contact_count) by collider */
    double margin;          /* m: asked for */
    double friction;
    double begin, resolve; /* s: margins grow to what is asked from `begin` on, in `resolve`; 0 = never */
    bool by_voxels;        /* of all colliders */
    sn_bone_hits bone_hits;
} sn_contacts;

static inline const sn_contacts *sn_contacts_of(const sn_model_muscle *m) { return m->own[SN_ROWS_CONTACT]; }

sn_left_out sn_contacts_reason(const sn_build *build);
SN_MUST_CHECK sn_status sn_contacts_build(const sn_build *build, sn_row_kind kind, sn_error *error);
void sn_contacts_destroy(sn_model_muscle *m, sn_row_kind kind);

/* ---- one row (contact.c) ---------------------------------------------------------------------------------------------------------------
 */

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
/* May any of its points be nearer to the bone than `reach`? into: from the world into the bone's frame. Phi at a point differs from that at
 * the middle by no more than the radius. */
bool sn_contact_block_is_near(const sn_collider *collider, sn_rigid into, const sn_contact_block *block, double reach);
/* Where a row's point is. */
sn_vec3 sn_contact_point(const sn_contact_row *row, const sn_point *points);
/* A row's mean of one vector of each point. */
sn_vec3 sn_contact_mean(const sn_contact_row *row, const sn_vec3 *of_points);

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
