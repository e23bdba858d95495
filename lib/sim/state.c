/*
 * state.c -- the arrays that a run writes: made, put at the start, read.
 */
#include "backend.h"
#include "contact.h"
#include "external.h"

_Static_assert(sizeof(sn_point) == 32, "a point is one record of four doubles");
_Static_assert(sizeof(sn_distance_row) == 8 && sizeof(sn_hinge_row) == 16, "rows are packed indices");

/* ---- room ------------------------------------------------------------------------------------------------------------------- */

static bool make_own(const sn_model_muscle *m, sn_inputs *inputs) {
    bool made = true;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->own != NULL) made = (inputs->own[kind] = SN_NEW(double, ops->own(m, (sn_row_kind)kind))) != NULL && made;
    }
    return made;
}

/* One muscle: its inputs, and its part of the points of its group. */
static bool make_member(const sn_model_muscle *m, sn_group_state *group, sn_index first, bool kept_only, sn_muscle_state *s) {
    sn_inputs *part = s->inputs = SN_NEW(sn_inputs, 1);
    bool made = part != NULL;
    s->points = group->points + first;
    s->velocities = group->velocities + first;
    s->previous = group->previous + first;
    if (!made) return false;
    SN_INPUT_ARRAYS(SN_MAKE_ARRAY)
    return made && (kept_only || make_own(m, part));
}

static sn_status make_group(const sn_group *g, bool kept_only, sn_state *state, sn_group_state *part, sn_error *error) {
    bool made = (part->members = SN_NEW(sn_muscle_state *, g->count)) != NULL;
    SN_POINT_ARRAYS(SN_MAKE_ARRAY)
    for (sn_index i = 0; made && i < g->count; i++) {
        part->members[i] = &state->muscles[g->muscles[i]];
        made = make_member(g->members[i], part, g->first[i], kept_only, part->members[i]);
    }
    return made ? SN_OK : sn_fail_memory(error, "the state");
}

/* Poses of all joints at the ends of the substeps. */
static bool make_poses(const sn_model *model, sn_state *state) {
    size_t joints = (size_t)model->scene->motion.joint_count, substeps = (size_t)sn_solver_substeps(&model->scene->solver);
    state->poses = joints > 0 && substeps > SIZE_MAX / joints ? NULL : SN_NEW(sn_rigid, joints * substeps);
    return state->poses != NULL;
}

sn_status sn_state_make(const sn_model *model, bool kept_only, sn_state **out, sn_error *error) {
    const sn_backend *backend = sn_backend_of(model->scene);
    sn_state *state = *out = SN_NEW(sn_state, 1);
    if (state == NULL) return sn_fail_memory(error, "the state");
    state->muscles = SN_NEW(sn_muscle_state, model->muscle_count);
    state->groups = SN_NEW(sn_group_state, model->group_count);
    bool made = state->muscles != NULL && state->groups != NULL && (kept_only || make_poses(model, state));
    sn_status status = made ? SN_OK : sn_fail_memory(error, "the state");
    for (sn_index i = 0; status == SN_OK && i < model->group_count; i++) {
        status = make_group(&model->groups[i], kept_only, state, &state->groups[i], error);
        if (status == SN_OK) status = backend->create(&model->groups[i], &state->groups[i], kept_only, error);
    }
    if (status == SN_OK) return SN_OK;
    sn_state_destroy(model, state);
    *out = NULL;
    return status;
}

sn_status sn_state_create(const sn_model *model, sn_state **out, sn_error *error) {
    sn_status status = sn_state_make(model, false, out, error);
    if (status == SN_OK) sn_state_reset(model, *out);
    return status;
}

static void free_inputs(sn_inputs *part) {
    if (part == NULL) return;
    SN_INPUT_ARRAYS(SN_FREE_ARRAY)
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) free(part->own[kind]);
    free(part);
}

static void free_group(const sn_backend *backend, const sn_group *g, sn_group_state *part) {
    if (part->members != NULL) {
        backend->destroy(g, part);
        for (sn_index i = 0; i < g->count; i++)
            if (part->members[i] != NULL) free_inputs(part->members[i]->inputs);
    }
    SN_POINT_ARRAYS(SN_FREE_ARRAY)
    free(part->members);
}

void sn_state_destroy(const sn_model *model, sn_state *state) {
    if (state == NULL) return;
    const sn_backend *backend = sn_backend_of(model->scene);
    for (sn_index i = 0; state->groups != NULL && i < model->group_count; i++) free_group(backend, &model->groups[i], &state->groups[i]);
    free(state->muscles);
    free(state->groups);
    free(state->poses);
    free(state);
}

static size_t member_bytes(const sn_model_muscle *m) {
    size_t bytes = sizeof(sn_muscle_state) + sizeof(sn_inputs);
    SN_INPUT_ARRAYS(SN_ADD_BYTES)
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->own != NULL) bytes += ops->own(m, (sn_row_kind)kind) * sizeof(double);
    }
    return bytes;
}

size_t sn_group_state_bytes(const sn_model *model, const sn_group *g) {
    size_t bytes = sizeof(sn_group_state) + (size_t)g->count * sizeof(sn_muscle_state *);
    SN_POINT_ARRAYS(SN_ADD_BYTES)
    for (sn_index i = 0; i < g->count; i++) bytes += member_bytes(g->members[i]);
    return bytes + sn_backend_of(model->scene)->bytes(g);
}

/* ---- the start of a run ----------------------------------------------------------------------------------------------------- */

static void reset_muscle(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    sn_inputs *in = s->inputs;
    in->activation = in->goal_contraction = in->goal_ratio = NAN; /* nothing has been made for any input yet */
    in->bones = (sn_bone_motion){.rate = 0.0};
    s->statistics = (sn_statistics){.residual = NAN};
    for (sn_index i = 0; i < m->point_count; i++) {
        s->points[i].w = m->inverse_mass[i];
        s->velocities[i] = sn_v3(0, 0, 0);
    }
    sn_contacts_begin(m, s);
    sn_kinematics_aim(m, s, scene, at);
    sn_contacts_aim(m, s, scene, at);
    sn_contacts_reset(m, s);
    sn_kinematics_carry(m, s, s->points);
    sn_kinematics_place(m, s);
    sn_inputs_update(m, s, at->time);
}

/* What ties its members to each other and to what moves by itself. */
static void reset_externals(const sn_group *g, sn_group_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    if (g->row_count == 0) return;
    for (sn_index i = 0; i < g->count; i++) s->members[i]->inputs->resolve_begin = scene->first_frame / scene->rate;
    sn_externals_aim(g, s, scene, at);
    sn_externals_keep(g, s);
    for (sn_index i = 0; i < g->point_count; i++) s->previous[i] = sn_point_position(&s->points[i]);
    sn_externals_reset(g, s);
    sn_externals_find(g, s);
}

void sn_state_reset(const sn_model *model, sn_state *state) {
    const sn_scene *scene = model->scene;
    const sn_surface_moment at = {state->poses, scene->first_frame / scene->rate, sn_scene_runs_in(scene) ? 0.0 : 1.0};
    const sn_backend *backend = sn_backend_of(model->scene);
    state->frame = model->scene->first_frame;
    state->substep = state->iteration = 0;
    sn_motion_run_in_poses(&scene->motion, at.time, at.share, state->poses);
    for (sn_index i = 0; i < model->muscle_count; i++) reset_muscle(&model->muscles[i], &state->muscles[i], scene, &at);
    for (sn_index i = 0; i < model->group_count; i++) {
        state->groups[i].progress = (sn_progress){.parts = SN_SUBSTEP_PARTS, .size = SN_SUBSTEP_PARTS};
        state->groups[i].still = 0;
        reset_externals(&model->groups[i], &state->groups[i], scene, &at);
        backend->reset(&model->groups[i], &state->groups[i]);
    }
    for (sn_index i = 0; i < model->muscle_count; i++) sn_statistics_measure(&model->muscles[i], &state->muscles[i]);
    for (sn_index i = 0; i < model->group_count; i++) sn_externals_measure(&model->groups[i], &state->groups[i]);
}

void sn_state_positions(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *positions) {
    const sn_model_muscle *m = &model->muscles[muscle];
    double unit = m->source->rig.meters_per_unit;
    for (sn_index i = 0; i < m->vertex_count; i++) {
        const sn_point *p = &state->muscles[muscle].points[i];
        positions[i] = sn_v3(p->x / unit, p->y / unit, p->z / unit);
    }
}
