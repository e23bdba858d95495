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
} sn_build;

/* ---- the back ends: which of them steps is decided by sn_backend_of (step.c) and nowhere else ---- */

/* One substep of one muscle, or a part of its iterations: those from `begin` to before `end`. The inputs are up to date. */
typedef struct sn_substep {
    double h;              /* s */
    sn_vec3 gravity;       /* m/s^2 */
    const sn_rigid *poses; /* (joints) at the substep's end */
    sn_index begin, end;   /* iterations; the substep starts with 0 and ends with m->iterations */
} sn_substep;

typedef struct sn_backend {
    const char *name;
    void (*substep)(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep);
} sn_backend;

extern const sn_backend sn_backend_xpbd; /* xpbd.c */
const sn_backend *sn_backend_of(const sn_scene *scene);

/* ---- plan.c ---- */
/* Which groups run: reasons only, before a row exists. */
void sn_plan_decide(const sn_build *build);
/* After the rows are built: groups left empty, bytes. */
void sn_plan_count(const sn_build *build);

/* ---- kinematic.c ---- */
SN_MUST_CHECK sn_status sn_kinematics_build(const sn_build *build, sn_error *error);
/* Put every attached vertex where its bone carries it: exactly pose(rest). poses (joints). */
void sn_kinematics_place(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *poses);
/* The whole muscle, carried along with its bones: where a run starts. */
void sn_kinematics_carry(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *poses);

/* ---- distance.c ---- */
SN_MUST_CHECK sn_status sn_distance_build(const sn_build *build, sn_error *error);
/* Goal lengths for the contraction and volume goal in the state; nothing is done where those have not changed. */
void sn_distance_goals(const sn_model_muscle *m, sn_muscle_state *s);
/* One Gauss-Seidel sweep; compliance is alpha / h^2; `first`: lambda starts at 0. */
void sn_distance_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, double compliance, bool first);
sn_residual sn_distance_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind);

/* ---- dihedral.c ---- */
SN_MUST_CHECK sn_status sn_hinge_build(const sn_build *build, sn_error *error);
void sn_hinge_sweep(const sn_model_muscle *m, sn_muscle_state *s, double compliance, bool first);
sn_residual sn_hinge_residual(const sn_model_muscle *m, const sn_muscle_state *s);

/* ---- volume.c ---- */
void sn_volume_build(const sn_build *build);
void sn_volume_sweep(const sn_model_muscle *m, sn_muscle_state *s, double compliance, bool first);

/* ---- inputs.c ---- */
/* Activation, contraction, stiffness, volume goal and goal lengths at `time`. */
void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time);
/* alpha / h^2 of one kind of rows at the state's stiffness; negative = no stiffness now: do not project. */
double sn_row_compliance(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, double h);

/* ---- statistics.c ---- */
void sn_statistics_measure(const sn_model_muscle *m, sn_muscle_state *s);

#endif
