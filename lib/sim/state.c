/*
 * state.c -- the arrays that a run writes: made, put at the start, read.
 */
#include "rows.h"

#include <stdlib.h>

_Static_assert(sizeof(sn_point) == 32, "a point is one record of four doubles");
_Static_assert(sizeof(sn_distance_row) == 8 && sizeof(sn_hinge_row) == 16, "rows are packed indices");

static bool make_arrays(const sn_model_muscle *m, sn_muscle_state *s) {
    bool made = true;
#define MAKE(type, name, count, kept) made = (s->name = SN_NEW(type, count)) != NULL && made;
    SN_STATE_ARRAYS(MAKE)
#undef MAKE
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->own != NULL) made = (s->own[kind] = SN_NEW(double, ops->own(m, (sn_row_kind)kind))) != NULL && made;
    }
    return made;
}

static void free_arrays(sn_muscle_state *s) {
#define FREE(type, name, count, kept) free(s->name);
    SN_STATE_ARRAYS(FREE)
#undef FREE
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) free(s->own[kind]);
}

sn_status sn_state_create(const sn_model *model, sn_state **out, sn_error *error) {
    *out = NULL;
    sn_state *state = SN_NEW(sn_state, 1);
    if (state == NULL) return sn_fail_memory(error, "the state");
    size_t joints = (size_t)model->scene->motion.joint_count, substeps = (size_t)sn_solver_substeps(&model->scene->solver);
    state->muscles = SN_NEW(sn_muscle_state, model->muscle_count);
    state->poses = joints > 0 && substeps > SIZE_MAX / joints ? NULL : SN_NEW(sn_rigid, joints * substeps);
    bool made = state->muscles != NULL && state->poses != NULL;
    for (sn_index i = 0; made && i < model->muscle_count; i++) made = make_arrays(&model->muscles[i], &state->muscles[i]);
    sn_status status = made ? SN_OK : sn_fail_memory(error, "the state");
    const sn_backend *backend = sn_backend_of(model->scene);
    for (sn_index i = 0; backend->create != NULL && status == SN_OK && i < model->muscle_count; i++)
        status = backend->create(&model->muscles[i], &state->muscles[i], error);
    if (status != SN_OK) {
        sn_state_destroy(model, state);
        return status;
    }
    sn_state_reset(model, state);
    *out = state;
    return SN_OK;
}

void sn_state_destroy(const sn_model *model, sn_state *state) {
    if (state == NULL) return;
    const sn_backend *backend = sn_backend_of(model->scene);
    for (sn_index i = 0; state->muscles != NULL && i < model->muscle_count; i++) {
        if (backend->destroy != NULL) backend->destroy(&state->muscles[i]);
        free_arrays(&state->muscles[i]);
    }
    free(state->muscles);
    free(state->poses);
    free(state);
}

static void reset_muscle(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *poses, double time) {
    s->activation = s->goal_contraction = s->goal_ratio = NAN; /* nothing has been made for any input yet */
    s->statistics = (sn_statistics){.residual = NAN};
    s->still = 0;
    s->bones = (sn_bone_motion){.rate = 0.0};
    s->pair_count = s->pair_next = 0;
    s->factor_stiffness = NAN;
    s->stopped = SN_STOP_ITERATIONS;
    s->turned = s->torn = s->abrupt = false;
    s->stretch_before = 0.0;
    s->progress = (sn_progress){.parts = SN_SUBSTEP_PARTS, .size = SN_SUBSTEP_PARTS};
    for (sn_index i = 0; i < m->point_count; i++) {
        s->points[i].w = m->inverse_mass[i];
        s->velocities[i] = sn_v3(0, 0, 0);
    }
    sn_kinematics_aim(m, s, poses);
    sn_kinematics_carry(m, s, s->points);
    sn_kinematics_place(m, s);
    if (m->single) sn_single_enter(m, s);
    sn_inputs_update(m, s, time);
    sn_statistics_measure(m, s);
}

void sn_state_reset(const sn_model *model, sn_state *state) {
    double time = model->scene->first_frame / model->scene->rate;
    state->frame = model->scene->first_frame;
    state->substep = state->iteration = 0;
    sn_motion_run_in_poses(&model->scene->motion, time, sn_scene_runs_in(model->scene) ? 0.0 : 1.0, state->poses);
    for (sn_index i = 0; i < model->muscle_count; i++) reset_muscle(&model->muscles[i], &state->muscles[i], state->poses, time);
}

void sn_state_positions(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *positions) {
    const sn_model_muscle *m = &model->muscles[muscle];
    double unit = m->source->rig.meters_per_unit;
    for (sn_index i = 0; i < m->vertex_count; i++) {
        const sn_point *p = &state->muscles[muscle].points[i];
        positions[i] = sn_v3(p->x / unit, p->y / unit, p->z / unit);
    }
}
