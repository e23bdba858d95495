/*
 * qn.h -- inside lib/sim: the quasi-Newton back end's energy, preconditioner and scratch. One muscle each.
 */
#ifndef SN_SIM_QN_H
#define SN_SIM_QN_H

#include "rows.h"
#include "sinew/sparse.h"

/* Pairs (step, change of gradient) that L-BFGS remembers. */
enum { SN_QN_MEMORY = 8 };

/* ---- energy.c ---- */

/* What Phi depends on besides the points: the state's inputs, its target y, its guarded triangles. */
typedef struct sn_objective {
    const sn_model_muscle *model;
    const sn_muscle_state *state; /* not its points; its volume_gradient (vertex_count) is left at dV/dx of the points evaluated;
                                     qn->forces is scratch */
    double h;
} sn_objective;

/* Phi at points (point_count; not changed), J; gradient (point_count), N, is zero at carried points. */
double sn_objective_evaluate(const sn_objective *objective, const sn_point *points, sn_vec3 *gradient);

/* ---- precondition.c ---- */

/* An approximate Hessian of Phi without the volume row, scalar, corotated or two-level (precondition.c); the volume row enters as k_V g gT
 * (Sherman-Morrison). */
typedef struct sn_preconditioner sn_preconditioner;
/* Of a group of muscles that are solved together; one alone is a group of one. Below, `points` of the group are those of its members one
 * after the other, and what is given by member is (count). */
SN_MUST_CHECK sn_status sn_preconditioner_create(sn_index count, const sn_model_muscle *const *members, sn_preconditioner **out,
                                                 sn_error *error);
void sn_preconditioner_destroy(sn_preconditioner *p); /* NULL is fine */
/* stiffness and factored_for by member. Go by the corotated matrix, its frames in turns (point_count; sn_preconditioner_turn writes them),
 * or by the scalar one (turns NULL), factored for (h, k), unless *factored_for, the k of the factor that the run goes by (NaN = none), is
 * within a factor of 2 of k: then for that one, if it is not at hand (a run that goes on elsewhere). *changed: *factored_for is now k.
 * false: no memory, no factor. */
bool sn_preconditioner_update(sn_preconditioner *p, double h, const double *stiffness, sn_quat *turns, double *factored_for, bool *changed);
/* Until the next update go by the scalar matrix of the shape at these points (point_count), in place of the rest shape's, for (h, k by
 * member); where that has no factor, by the rest shape's after all. The volume rows are then to be set anew. false: no memory, no factor.
 */
bool sn_preconditioner_stand(sn_preconditioner *p, const sn_point *points, double h, const double *stiffness);
/* Turn the corotated matrix with the muscle at these points (point_count); nothing for the scalar one. */
void sn_preconditioner_turn(sn_preconditioner *p, const sn_point *points);
/* From the next solve on, where there is a coarse space: correct with its Hessian at positions (point_count) for (h, k); NULL: do not. The
 * volume row is then to be set anew. */
void sn_preconditioner_correct(sn_preconditioner *p, const sn_vec3 *positions, double h, const double *stiffness);
/* From the next solve on: the volume rows at volume_gradient g (point_count, vertices are read; copied) with stiffness k_V by
 * member; k_V = 0, or NULL for all: without. */
void sn_preconditioner_set_volume(sn_preconditioner *p, const sn_vec3 *volume_gradient, const double *volume_stiffness);
/* out = (A + k_V g gT)^-1 in, on free points; zero on carried ones. Both (point_count); out may be in. */
bool sn_preconditioner_apply(sn_preconditioner *p, const sn_vec3 *in, sn_vec3 *out);
/* in += A_fk jump + k_V g_f (g_k . jump): what a motion of the carried points adds to the gradient of the free ones. */
void sn_preconditioner_add_jump(const sn_preconditioner *p, const sn_vec3 *jump, const sn_vec3 *volume_gradient,
                                const double *volume_stiffness, sn_vec3 *in);

/* Scratch and factor of one muscle; made with the state under back end `qn` only. */
struct sn_qn {
    sn_preconditioner *preconditioner;
    sn_point *trial;         /* (point_count) */
    sn_point *forces;        /* (point_count) the gradient while it is summed, as records of four */
    sn_vec3 *gradient;       /* (point_count) at the current points */
    sn_vec3 *trial_gradient; /* (point_count) */
    sn_vec3 *direction;      /* (point_count) */
    sn_vec3 *jump;           /* (point_count) */
};

#endif
