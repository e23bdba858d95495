/*
 * rows.h -- inside lib/sim: building the rows of one muscle, projecting them, measuring them. One source per constraint.
 */
#ifndef SN_SIM_ROWS_H
#define SN_SIM_ROWS_H

#include "sinew/sim.h"

/* What the builders of one muscle's rows share. */
typedef struct sn_build {
    const sn_scene *scene;
    const sn_scene_muscle *source;
    const sn_topology *topology;
    sn_model_muscle *model;
    sn_plan_muscle *plan;
    sn_index *sample_points;  /* (samples of the structure) its point; SN_NONE: it is left out */
    sn_index *sample_parents; /* (the same) the sample that it is joined to; SN_NONE: none, or it is left out */
    bool scaled;              /* stiffness by area */
    sn_anisotropy anisotropy; /* as it runs: NONE, PBD or XPBD */
} sn_build;

/* ---- scheme.c ---- */

typedef struct sn_scheme_rules {
    int count;
    sn_row_kind order[8];      /* (count) as they are projected; a kind may come more than once */
    double gain[SN_ROW_KINDS]; /* factor on each correction */
    double hinge_clamp;        /* rad */
    double hinge_step;         /* most move of a point by one hinge, mean edges */
    bool hinges_published;     /* hinges by the rule of [K21]'s program (dihedral.c), which has limits of its own, instead */
    int volume_projections;    /* at most */
    double most_speed;         /* of a point, beside its bones: diagonals of the muscle per second; 0 = any */
    double keep;               /* factor on the velocities per step; 0 = the muscle's rate of damping */
    bool damps_all;            /* damping acts on the whole velocity, after the force, and not beside the bones alone */
    bool plain;                /* no compliance: plain position based dynamics */
    bool unit_mass;            /* points of 1 kg */
    bool contracts;            /* activation shortens, stiffens and swells */
    bool scales;               /* stiffness by area, where the muscle wants it */
    bool yields;               /* anisotropy where the muscle leaves it to the scheme */
} sn_scheme_rules;

const sn_scheme_rules *sn_scheme_rules_of(const sn_solver_settings *solver);
int sn_scheme_sweeps(sn_scheme scheme, sn_row_kind kind); /* in an iteration; 0 = it has no such rows */

/* How one group is projected now. */
typedef struct sn_sweep {
    double compliance; /* alpha / h^2 */
    double gain;       /* factor on the correction */
    double clamp;      /* of hinges, rad */
    double most_step;  /* of a point by one hinge, m */
    bool published;    /* hinges by the rule of [K21]'s program */
    int projections;   /* of the volume, at most */
    bool first;        /* lambda starts at 0 */
} sn_sweep;

/* Sums of forces on points: x, y, z of point i at values[stride i]. stride: 3 (sn_vec3) or 4 (whole records, whose fourth number is
 * overwritten; faster). values NULL: the energy alone is wanted. */
typedef struct sn_forces {
    double *values;
    int stride;
} sn_forces;

/* Energy of one kind of rows at the state's points, J; its gradient goes to the scratch of back end `qn`. */
double sn_rows_evaluate(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind);

/* ---- the back ends: which of them steps is decided by sn_backend_of (step.c) and nowhere else ---- */

/* One step of one muscle (a substep, or a part of one), or some of its iterations: those from `begin` to before `end`. The inputs and the
 * poses of the bones in the state are those of its end. */
typedef struct sn_substep {
    double h;        /* s */
    sn_vec3 gravity; /* m/s^2 */
    const sn_scheme_rules *rules;
    sn_index begin, end; /* iterations; the step starts with 0 and ends with m->iterations */
    bool may_halve;      /* it may be given up for two of half the length */
    bool halved;         /* it is one of those */
    bool measure;        /* leave the residual at the end in the statistics */
    sn_point *start;     /* (points) nullable; xpbd: where they are when the iterations begin */
} sn_substep;

typedef enum sn_verdict {
    SN_STEP_HOLDS,
    SN_STEP_REFUSED, /* too long, before any iteration: the state is as it was before the step */
    SN_STEP_GIVEN_UP /* too long, after all of them: the same */
} sn_verdict;

typedef struct sn_backend {
    const char *name;
    sn_verdict (*substep)(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep);
    sn_status (*create)(const sn_model_muscle *m, sn_muscle_state *s, sn_error *error); /* nullable: scratch of its own */
    void (*destroy)(sn_muscle_state *s);                                                /* nullable; also after a create that failed */
} sn_backend;

extern const sn_backend sn_backend_xpbd; /* xpbd.c */
extern const sn_backend sn_backend_qn;   /* qn.c */
const sn_backend *sn_backend_of(const sn_scene *scene);

/* ---- plan.c ---- */
/* Which groups run: reasons only, before a row exists. */
void sn_plan_decide(const sn_build *build);
/* After the rows are built: groups left empty, bytes. */
void sn_plan_count(const sn_build *build);

/* ---- batch.c ---- */
/* An order of rows of `size` points each, points (count x size): the first *batched rows come in fours that share no point. */
SN_MUST_CHECK sn_status sn_batch_order(sn_index count, sn_index size, const sn_index *points, sn_index point_count, sn_index *order,
                                       sn_index *batched, sn_error *error);
/* For rows in that order: pairs (batched / 4), true where a four and the next one share no point either. */
void sn_batch_pair(sn_index batched, sn_index size, const sn_index *points, bool *pairs);
/* Put an array (count) of elements of `size` bytes into that order; NULL is fine. */
SN_MUST_CHECK sn_status sn_batch_sort(void *array, sn_index count, size_t size, const sn_index *order, sn_error *error);

/* ---- kinematic.c ---- */
SN_MUST_CHECK sn_status sn_kinematics_build(const sn_build *build, sn_error *error);
/* Leave the poses of the sites' bones in the state: those of all joints, or those at `time`. */
void sn_kinematics_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *joint_poses);
void sn_kinematics_aim_at(const sn_model_muscle *m, sn_muscle_state *s, const sn_motion *motion, double time);
/* Put every attached vertex where its bone carries it: exactly pose(rest). */
void sn_kinematics_place(const sn_model_muscle *m, sn_muscle_state *s);
/* Are they anywhere else than where sn_kinematics_place put them last? */
bool sn_kinematics_moved(const sn_model_muscle *m, const sn_muscle_state *s);
/* The whole muscle, carried along with its bones to `points` (point_count): where a run starts. */
void sn_kinematics_carry(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points);

/* Leaves the motion of the bones over the step of h s that ends here in the state, from the velocities of the attached points. Bones whose
 * velocity changes by more than `most`, m/s, in a step have jumped: that is no motion; 0 = they may change as they like. */
void sn_kinematics_watch_bones(const sn_model_muscle *m, sn_muscle_state *s, double h, double most);
/* The velocity over the last step of a point that went along with the bones and is at x now; zero where they rest. */
sn_vec3 sn_bone_motion_at(const sn_bone_motion *bones, sn_vec3 x);
/* The velocity of a point after damping by the factor `keep`, beside the bones. */
sn_vec3 sn_damped_velocity(const sn_muscle_state *s, sn_index point, double keep);
/* A bone that jumps throws the muscle after it: no tissue is faster, beside its bones, than some tens of its lengths a second. Bounds the
 * velocities of the free points by `most`, m/s; 0 = not at all. */
void sn_kinematics_limit_speed(const sn_model_muscle *m, sn_muscle_state *s, double most);

/* ---- samples.c ---- */
/* Points for the samples of the structure: those on which a vertex hangs, where the plan has any. */
SN_MUST_CHECK sn_status sn_samples_build(sn_build *build, sn_error *error);
void sn_samples_release(sn_build *build); /* what only the builders need */

/* ---- distance.c ---- */
SN_MUST_CHECK sn_status sn_distance_build(const sn_build *build, sn_error *error);
/* Goal lengths for the contraction and volume goal in the state; nothing is done where those have not changed. */
void sn_distance_goals(const sn_model_muscle *m, sn_muscle_state *s);
/* One Gauss-Seidel sweep. */
void sn_distance_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
/* Sum of k C^2 / 2, J; its gradient is added to gradient (point_count), N. */
double sn_distance_energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, double k, sn_forces gradient);
/* |C| of rows begin to end - 1, among those of all distance kinds, over the mean edge. */
void sn_distance_errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, double *errors);

/* The longest edge so far, over its goal. */
typedef struct sn_longest_edge {
    double ratio; /* 0 = none yet */
    sn_index point[2];
} sn_longest_edge;
/* Go on with rows begin to end - 1, whose errors are at hand: they tell which of them need a closer look. */
void sn_distance_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, const double *errors,
                         sn_longest_edge *longest);

/* ---- dihedral.c ---- */
SN_MUST_CHECK sn_status sn_hinge_build(const sn_build *build, sn_error *error);
void sn_hinge_sweep(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep);
double sn_hinge_energy(const sn_model_muscle *m, const sn_muscle_state *s, double k, sn_forces gradient);
/* |C| of rows begin to end - 1, rad; NaN: it has no angle. */
void sn_hinge_errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, double *errors);

/* ---- area.c ---- */
SN_MUST_CHECK sn_status sn_area_build(const sn_build *build, sn_error *error);
void sn_area_sweep(const sn_model_muscle *m, sn_muscle_state *s);
/* What rows begin to end - 1 lack of their least area, over A0. */
void sn_area_errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, double *errors);

/* ---- membrane.c ---- */
SN_MUST_CHECK sn_status sn_membrane_build(const sn_build *build, sn_error *error);
/* Goal shapes for the contraction and volume goal in the state. */
void sn_membrane_goals(const sn_model_muscle *m, sn_muscle_state *s);
double sn_membrane_energy(const sn_model_muscle *m, const sn_muscle_state *s, double k, sn_forces gradient);
/* |1/2 (FT F - I)|, Green's strain, of rows begin to end - 1. */
void sn_membrane_errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, double *errors);

/* As sn_distance_longest, of the edges of triangles. */
void sn_membrane_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, const double *errors,
                         sn_longest_edge *longest);

/* ---- volume.c ---- */
void sn_volume_build(const sn_build *build);
double sn_volume_ratio(const sn_model_muscle *m, const sn_muscle_state *s); /* V / V0 */
void sn_volume_sweep(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep);
/* With a gradient, volume_gradient in the state is left at dV/dx. */
double sn_volume_energy(const sn_model_muscle *m, sn_muscle_state *s, double k, sn_forces gradient);

/* ---- single.c: the sweeps in single precision ---- */
float sn_single_weight(const sn_model_muscle *m, sn_index point);   /* inverse mass in floats: over that of a mean point */
void sn_single_enter(const sn_model_muscle *m, sn_muscle_state *s); /* single_points from points, about a new origin */
void sn_single_leave(const sn_model_muscle *m, sn_muscle_state *s); /* and back; attached points keep theirs */
void sn_single_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);

/* ---- inputs.c ---- */
/* Activation, contraction, stiffness, volume goal and goal lengths at `time`. */
void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time);
/* Stiffness of one kind of rows now, before the factors of single rows; 0 = none. */
double sn_row_stiffness(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind);

/* ---- errors.c ---- */
/* Of the errors of all rows of a kind but the volume; longest: nullable, and for SN_ROWS_MESH and SN_ROWS_MEMBRANE only. */
sn_residual sn_rows_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_longest_edge *longest);
/* What the surface is stretched by: SN_ROWS_MEMBRANE where it runs, else SN_ROWS_MESH. */
sn_row_kind sn_stretch_kind(const sn_model_muscle *m);
/* Where neither of them has a row: the edge longest over its length at rest. */
void sn_rest_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_longest_edge *longest);
/* Greatest |l / l0 - 1| of any edge of the surface against its length at rest. */
double sn_largest_strain(const sn_model_muscle *m, const sn_muscle_state *s);

/* ---- statistics.c ---- */
/* |dPhi/dx| / (k L) from inertia's share of the gradient, inertia (point_count), N: m (v - v predicted) / h. It is overwritten. */
double sn_residual_measure(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *inertia);
void sn_statistics_measure(const sn_model_muscle *m, sn_muscle_state *s);

#endif
