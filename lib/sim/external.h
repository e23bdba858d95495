/*
 * external.h -- inside lib/sim: external constraints: a vertex of a muscle and the surface of another muscle, of a bone, of an envelope or
 * a driven mesh.   [R18] 4.3, bodies.md 3, methods.md 8.5
 *
 * Slide: C = n.(x - q) - d0, q the nearest point of all of the vertex's targets where the step begins, n the unit gradient of the signed
 * distance there, both frozen for the step. A target that it was outside of at rest and has entered comes before all that are nearer. Soft:
 * C = |x - q0| - |d0|, q0 the point of the target that it was bound to. Hard: C = x - t, t at its place in the tangent frame of that point.
 * Minimum: the slide's n.(x - q) >= least, with what the slide's weight leaves of 1: what slides alone keeps its distance anyway. Muscles
 * that touch each other so are a group.
 *
 * Rows belong to the muscle of the vertex. Their points are numbered from its own first one: those of other members are below 0, or beyond
 * its last. A row between two muscles is as stiff as the softer of them makes it. With the k of its own, one that is a million times as
 * stiff as its neighbour tore that: all that a line search sees of the energy is then the stiff one's. What a target moves by itself
 * (bones, surfaces of the scene) is told once a step, at its end.
 */
#ifndef SN_SIM_EXTERNAL_H
#define SN_SIM_EXTERNAL_H

#include "group.h"
#include "rows.h"
#include "sinew/moving.h"
#include "sinew/sets.h"

enum { SN_EXTERNAL_SLIDE, SN_EXTERNAL_SOFT, SN_EXTERNAL_HARD, SN_EXTERNAL_TYPES };

/* A surface that vertices of a group are tied to. */
typedef struct sn_external_target {
    sn_index member;      /* of the group; SN_NONE: it moves by itself */
    sn_index touched;     /* else: a bone or a surface, as sn_scene_touched_name counts them */
    sn_moving moving;     /* of its triangles; of a surface: of those near to the group */
    sn_index *vertices;   /* (moving.vertex_count) by itself: of the scene's mesh; NULL of a member */
    bool closed;          /* it has no rim: one is in it or out of it */
    sn_index first_point; /* by itself: of the group's target points */
    sn_index first_box;   /* of the group's target boxes */
} sn_external_target;

/* A vertex. */
typedef struct sn_external_row {
    sn_index point;      /* of its muscle */
    sn_index begin, end; /* of its targets: numbers in sn_externals.candidates, the one that it is bound to first */
    sn_index triangle;   /* of that one's moving mesh */
    double barycentric[3];
    double weights[SN_EXTERNAL_TYPES]; /* by eqs 11 to 13 */
    double distance;                   /* to the nearest of all targets at rest, m; negative: in it */
    double bound;                      /* to the point that it is bound to, m */
    double least;                      /* minimum distance, m; -infinity: none; it weighs 1 less the slide's weight */
    sn_vec3 offset;                    /* hard: in that point's tangent frame, m */
} sn_external_row;

/* Those of one muscle: m->own[SN_ROWS_EXTERNAL]. */
typedef struct sn_externals {
    sn_external_row *rows; /* (m->external_count) by point */
    sn_index *candidates;  /* targets of the group */
    double *rest_sides;    /* (candidate_count) signed distance of the vertex to that target at rest, m */
    sn_index candidate_count;
    double factor; /* stiffness over that of the muscle's edges */
} sn_externals;

/* A point of a target, as a mean of up to three points of the group, or at a place of its own. */
typedef struct sn_external_foot {
    sn_index point[3]; /* from the muscle's first; of no use where weight is 0 */
    double weight[3];
    sn_vec3 place; /* where the target moves by itself; weights are 0 */
    double share;  /* stiffness over that of the vertex's muscle: 1, or less where the target is the softer one */
} sn_external_foot;

/* A row in the step at hand. */
typedef struct sn_external_hold {
    sn_external_foot slide, bound;
    sn_vec3 normal; /* unit; zero: there is none */
    sn_vec3 offset; /* hard: in the world */
} sn_external_hold;

static inline const sn_externals *sn_externals_of(const sn_model_muscle *m) { return m->own[SN_ROWS_EXTERNAL]; }
static inline sn_external_hold *sn_external_holds_of(const sn_muscle_state *s) { return (void *)s->inputs->own[SN_ROWS_EXTERNAL]; }

/* ---- external_build.c ---- */

/* What a distance at rest is to be by now: of what lies in its target less and less. parted: sn_inputs. */
static inline double sn_external_kept(double distance, double parted) { return distance < 0.0 ? (1.0 - parted) * distance : distance; }

/* Which muscles (model->muscle_count) touch each other: a number for each, the same in one group: parents (muscle_count), as sn_set_of
 * finds them. SN_ERROR_INPUT: a target that the scene does not have, or a candidate that does not fit it. */
SN_MUST_CHECK sn_status sn_externals_join(const sn_model *model, sn_index *parents, sn_error *error);
/* Targets and rows of the members of a group, which has its members and points. */
SN_MUST_CHECK sn_status sn_externals_build(sn_model *model, sn_group *g, sn_error *error);
void sn_external_targets_free(sn_group *g);
/* The tangent frame of a triangle: unit axes along its first edge, across it, along its normal; zeros where it has none. */
void sn_external_frame(const sn_moving_shape *shape, sn_index triangle, sn_vec3 axes[3]);

/* ---- external_step.c; each does nothing for a group without such rows ---- */

/* Where targets that move by themselves are at that moment, the end of the step. */
void sn_externals_aim(const sn_group *g, sn_group_state *s, const sn_scene *scene, const sn_surface_moment *at);
/* They have come this far. */
void sn_externals_keep(const sn_group *g, sn_group_state *s);
bool sn_externals_moved(const sn_group *g, const sn_group_state *s);
/* Each row slides on the point that it is bound to. */
void sn_externals_reset(const sn_group *g, sn_group_state *s);
/* Does each slide on one of its targets? Not in a state that is damaged. */
bool sn_externals_sound(const sn_group *g, const sn_group_state *s);
/* What each row holds on to in the step, whose `previous` points are set. Asked again it says the same. */
void sn_externals_find(const sn_group *g, sn_group_state *s);
/* Of a group that goes one way: where points and targets are as an iteration begins; what the rows of a member hold on to now; that member
 * has been moved. */
void sn_externals_begin(const sn_group *g, sn_group_state *s);
void sn_externals_update(const sn_group *g, sn_group_state *s, sn_index member);
void sn_externals_went(const sn_group *g, sn_group_state *s, sn_index member);
/* How deep the vertices of each member are in what they slide on, where points and targets are now: into its statistics. What a step began
 * with is of no use here: a bone that is fast takes a vertex far from the plane that it held on to. */
void sn_externals_measure(const sn_group *g, sn_group_state *s);

/* ---- external.c ---- */

/* What a row of the matrix is: a visit for each row that ties free points, with weights over the group's points from the muscle's first,
 * and a scale over the muscle's k. false: visit returned false. */
bool sn_externals_at_bind(const sn_group *g, sn_index member, sn_rest_visit visit, void *user);

#endif
