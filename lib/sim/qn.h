/*
 * qn.h -- inside lib/sim: what the quasi-Newton back end remembers of a group; its energy; its matrix; how a step starts; its fallbacks.
 */
#ifndef SN_SIM_QN_H
#define SN_SIM_QN_H

#include "backend.h"
#include "sinew/sparse.h"

/* Pairs (step, change of gradient) that L-BFGS remembers. */
enum { SN_QN_MEMORY = 8 };

typedef struct sn_preconditioner sn_preconditioner;

/* Arrays over the points of a group, but where a count says otherwise. What is kept: where inertia takes each point; frames of the
 * corotated matrix; where the sections of the two-level matrix were placed; dV/dx of the matrix; k that the matrix is factored for, N/m by
 * member, NaN = none yet. */
#define SN_QN_ARRAYS(X)                                                                                                                    \
    X(sn_vec3, target, g->point_count, SN_KEPT)                                                                                            \
    X(sn_quat, turns, g->corotated ? g->point_count : 0, SN_KEPT)                                                                          \
    X(sn_vec3, section_points, g->two_level ? g->point_count : 0, SN_KEPT)                                                                 \
    X(sn_vec3, row_gradient, g->keeps_volume ? g->point_count : 0, SN_KEPT)                                                                \
    X(sn_vec3, volume_gradient, g->keeps_volume ? g->point_count : 0, SN_LEFT)                                                             \
    X(sn_point, trial, g->point_count, SN_LEFT)                                                                                            \
    X(sn_point, forces, g->point_count, SN_LEFT)  /* the gradient while it is summed, as records of four */                                \
    X(sn_vec3, gradient, g->point_count, SN_LEFT) /* at the current points */                                                              \
    X(sn_vec3, trial_gradient, g->point_count, SN_LEFT)                                                                                    \
    X(sn_vec3, direction, g->point_count, SN_LEFT)                                                                                         \
    X(sn_vec3, jump, g->point_count, SN_LEFT)                                                                                              \
    X(double, stiffness, g->count, SN_LEFT)        /* k of each member now */                                                              \
    X(double, volume_stiffness, g->count, SN_LEFT) /* k_V */                                                                               \
    X(double, longest, g->count, SN_LEFT)          /* way of a member's point in the direction at hand, m */                               \
    X(bool, torn_members, g->count, SN_LEFT)       /* scratch */
/* Kept, but held to what they may be by their number alone: of dead pairs anything may be left. */
#define SN_QN_PAIR_ARRAYS(X)                                                                                                               \
    X(sn_vec3, pair_steps, SN_QN_MEMORY *(size_t)g->point_count, SN_KEPT)                                                                  \
    X(sn_vec3, pair_changes, SN_QN_MEMORY *(size_t)g->point_count, SN_KEPT)                                                                \
    X(double, pair_products, SN_QN_MEMORY, SN_KEPT)                                                                                        \
    X(double, factor_stiffness, g->count, SN_KEPT)

/* What the back end remembers of one group. */
typedef struct sn_qn {
#define SN_QN_MEMBER(type, name, count, kept) type *name;
    SN_QN_ARRAYS(SN_QN_MEMBER)
    SN_QN_PAIR_ARRAYS(SN_QN_MEMBER)
#undef SN_QN_MEMBER
    sn_index pair_count, pair_next; /* pairs at hand, and the slot of the next */
    sn_stop_reason stopped;         /* why the step needs no further iteration; SN_STOP_ITERATIONS = it may */
    double stretch_before;          /* greatest error of the surfaces where the step began; infinite: one was torn already */
    bool torn;                      /* the step began far from any shape of rest: more effort */
    bool abrupt;                    /* bones set out, or stop, by many edges: more effort too */
    bool turned;                    /* the step goes by the corotated or the two-level matrix */
    double energy;                  /* Phi at the points, J */
    sn_preconditioner *preconditioner;
} sn_qn;

/* A group's. */
static inline sn_qn *sn_qn_of(const sn_group_state *s) { return s->memory; }

/* ---- energy.c ---- */

/* What Phi depends on besides the points: inputs of the members, where inertia takes the points, which triangles are guarded. */
typedef struct sn_objective {
    const sn_group *group;
    const sn_group_state
        *state; /* not its points; what sn_qn_find_volume_gradient needs is left of the points evaluated; forces are scratch */
    double h;
} sn_objective;

/* Phi at points (point_count; not changed), J; gradient (point_count), N, is zero at carried points. */
double sn_objective_evaluate(const sn_objective *objective, const sn_point *points, sn_vec3 *gradient);

/* ---- precondition.c ---- */

/* An approximate Hessian of Phi without the volume rows, scalar, corotated or two-level (precondition.c), of a group of muscles that are
 * solved together; the volume rows enter as k_V g gT, that of a muscle alone exactly, those of a group by deflation (deflate.h). Below,
 * `points` of the group are those of its members one after the other, and what is given by member is (count). */
SN_MUST_CHECK sn_status sn_preconditioner_create(sn_index count, const sn_model_muscle *const *members, sn_preconditioner **out,
                                                 sn_error *error);
/* The scalar matrix knows the external constraints of the group from here on, at the triangles that they are bound to; nothing where it has
 * none. Each counts with the k of the softer of its muscles. */
SN_MUST_CHECK sn_status sn_preconditioner_couple(sn_preconditioner *p, const sn_group *g, sn_error *error);
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
/* out = (A + k_V g gT)^-1 in, or what deflation makes of it, on free points; zero on carried ones. Both (point_count); out may be in. */
bool sn_preconditioner_apply(sn_preconditioner *p, const sn_vec3 *in, sn_vec3 *out);
/* Numbers in the factor that it goes by; 0: there is none yet. */
int64_t sn_preconditioner_entries(const sn_preconditioner *p);
/* Bytes of all it holds: blocks, factors, what it solves with; without the deflation of a group and the frames of the corotated matrix. */
size_t sn_preconditioner_bytes(const sn_preconditioner *p);
/* in += A_fk jump + k_V g_f (g_k . jump): what a motion of the carried points adds to the gradient of the free ones. */
void sn_preconditioner_add_jump(const sn_preconditioner *p, const sn_vec3 *jump, const sn_vec3 *volume_gradient,
                                const double *volume_stiffness, sn_vec3 *in);

/* ---- qn_matrix.c ---- */

/* What L-BFGS has learnt is of no use from here on. */
void sn_qn_forget_pairs(sn_qn *qn);
/* No further iteration in this step; SN_STOP_ITERATIONS: there may be. */
void sn_qn_stop(sn_group_state *s, const sn_group *g, sn_stop_reason reason);
/* From here on the matrix has the volume rows with this gradient (point_count). */
void sn_qn_set_volume_rows(sn_qn *qn, const sn_vec3 *gradient);
/* dV/dx of the points that were evaluated last, of all members, is in volume_gradient. */
void sn_qn_find_volume_gradient(const sn_group *g, sn_group_state *s);
/* With the gradient of the points that were evaluated last. */
void sn_qn_take_volume_gradient(const sn_group *g, sn_group_state *s);
/* Stiffness of each member, and k_V, now. */
void sn_qn_take_stiffness(const sn_group *g, sn_group_state *s);
/* The matrix that the step goes by. false: no memory, no factor. */
bool sn_qn_go_by(const sn_group *g, sn_group_state *s, double h, bool *changed);
/* From here on the matrix is that of the group as it is torn: near a collapsed triangle the rest shape's is too soft by orders of
 * magnitude, and a step that is too long for one hinge is cut short for all of the muscle. */
void sn_qn_take_matrix_here(const sn_group *g, sn_group_state *s, double h);
/* Twice the area of a triangle. */
double sn_qn_double_area(const sn_point *points, const sn_index *v);

/* ---- qn_start.c ---- */

/* From the inputs of the step's end to the points where its iterations begin: energy, gradient and matrix are there. false: the step is
 * too long. */
bool sn_qn_start(const sn_group *g, sn_group_state *s, const sn_substep *substep);
/* In the middle of a step: what the start has left, made again from the state. */
void sn_qn_resume(const sn_group *g, sn_group_state *s, const sn_substep *substep);

/* ---- qn_fallback.c: when a muscle, or the step, is beyond what the method is for ---- */

/* An edge as far as the first from its goal, in mean edges (or such a strain), all of them as far as the second in the mean, or a bone that
 * has jumped: the matrix of the rest shape says little then, and each iteration that the scene allows stands for several. */
#define SN_QN_FAR_STRETCHED SN_FAR_STRETCHED
#define SN_QN_FAR_IN_THE_MEAN SN_FAR_IN_THE_MEAN
/* A bone that moves a point by this share of the diagonal more or less than in the step before has jumped. */
#define SN_QN_FAR 0.2

/* How the members stand where a step begins or ends. */
typedef struct sn_condition {
    sn_index collapsed;  /* triangles below a twentieth of their rest area */
    sn_residual stretch; /* of the surfaces from their goal shapes, the greatest: edges over the mean edge, or strains */
} sn_condition;

/* Gives up members that are wrecks, marks the triangles that have a barrier, and says how the group stands then. */
sn_condition sn_qn_look(const sn_group *g, sn_group_state *s, double h);
bool sn_qn_is_stretched(const sn_residual *stretch, bool fast);
/* Of a muscle that is torn, or pressed on a bone, inertia and the predictor may make a worse wreck: begin where it was if that is better.
 * stays (count): those members, NULL: all. */
void sn_qn_try_staying(const sn_group *g, sn_group_state *s, double h, const bool *stays);
/* Is a member far from any shape of rest? */
bool sn_qn_is_torn(const sn_group *g, const sn_group_state *s, sn_index member, bool fast);
/* Other starts where a member is torn or a bone has jumped; is more effort needed? */
bool sn_qn_mend_start(const sn_group *g, sn_group_state *s, double h, bool jumped, bool fast);
/* Does the step, as far as it has come, tear a group that was whole? */
bool sn_qn_tears(const sn_group *g, const sn_group_state *s);
/* As it was before the step; the velocities are still those. */
void sn_qn_go_back(const sn_group *g, sn_group_state *s);
/* Begin at the trial's points instead where the energy is lower there: energy and gradients are those of the state's points then. */
void sn_qn_prefer_trial(const sn_group *g, sn_group_state *s, double h);

#endif
