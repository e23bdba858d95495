/*
 * xpbd.c -- back end `xpbd`: the stages of one step.   [R18] alg. 1, methods.md 8.7, numerics.md 2
 *
 * Start: v <- u + (v - u) e^(-c h) + h g, x <- x + h v, u the velocity of the bones there (kinematic.c); attached vertices to their bones.
 * Iterate: every kind of rows in order, volume last. Finish: v <- (x - x_before) / h. Lambda starts at 0 in each step (never in each
 * iteration). The papers' schemes damp all of the velocity, and after the force: v <- (v + h g) e^(-c h).
 */
#include "xpbd.h"

#include "backend.h"
#include "contact.h"
#include "external.h"

/* ---- stages ----------------------------------------------------------------------------------------------------------------- */

/* Where each point would be without constraints. Damping is a rate: exact for any h. */
static void predict(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    double h = substep->h, keep = substep->rules->keep > 0.0 ? substep->rules->keep : sn_exp(-m->source->damping * h);
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_point *p = &s->points[i];
        s->previous[i] = sn_point_position(p);
        if (p->w == 0.0) continue;
        sn_vec3 v = s->velocities[i] = substep->rules->damps_all ? sn_scale(sn_add_scaled(s->velocities[i], substep->gravity, h), keep)
                                                                 : sn_add_scaled(sn_damped_velocity(s, i, keep), substep->gravity, h);
        p->x += h * v.x, p->y += h * v.y, p->z += h * v.z;
    }
}

static sn_verdict start(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        predict(m, s->members[i], substep);
        sn_kinematics_place(m, s->members[i]);
        sn_contacts_gather(m, s->members[i], substep);
        if (m->single) sn_single_enter(m, s->members[i]);
    }
    sn_externals_find(g, s);
    return SN_STEP_HOLDS;
}

static void resume(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    for (sn_index i = 0; i < g->count; i++) sn_contacts_gather(g->members[i], s->members[i], substep);
    sn_externals_find(g, s);
}

static void project_kind(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_scheme_rules *rules, double h,
                         bool first) {
    const sn_row_ops *ops = sn_row_ops_of(kind);
    double stiffness = sn_row_stiffness(m, s, kind);
    if (!(stiffness > 0.0) || ops->sweep == NULL || ops->count(m, kind) == 0) return;
    const sn_sweep sweep = {.compliance = rules->plain ? 0.0 : 1.0 / (stiffness * h * h),
                            .gain = rules->gain[kind] != 0.0 ? rules->gain[kind] : 1.0,
                            .clamp = rules->hinge_clamp,
                            .most_step = rules->hinge_step * m->mean_edge,
                            .published = rules->hinges_published,
                            .projections = rules->volume_projections,
                            .one_way = rules->one_way,
                            .first = first};
    (m->single ? ops->sweep_single : ops->sweep)(m, s, kind, &sweep);
}

/* One iteration of one muscle. */
static void project(const sn_group *g, sn_group_state *s, sn_index member, const sn_substep *substep, sn_index iteration) {
    const sn_model_muscle *m = g->members[member];
    sn_row_kind order[SN_MOST_SWEEPS];
    int count = sn_scheme_order(substep->rules, order);
    if (iteration >= m->iterations) return;
    if (g->one_way) sn_externals_update(g, s, member);
    for (int k = 0; k < count; k++) project_kind(m, s->members[member], order[k], substep->rules, substep->h, iteration == 0);
    if (g->one_way) sn_externals_went(g, s, member);
}

static void iterate(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    if (substep->before != NULL) memcpy(substep->before, s->points, (size_t)g->point_count * sizeof *s->points);
    if (g->one_way) sn_externals_begin(g, s);
    for (sn_index k = substep->begin; k < substep->end; k++)
        for (sn_index i = 0; i < g->count; i++) project(g, s, i, substep, k);
    for (sn_index i = 0; i < g->count; i++) {
        if (g->members[i]->single) sn_single_leave(g->members[i], s->members[i]);
        s->members[i]->statistics.residual = NAN;
    }
}

static sn_vec3 velocity(const sn_muscle_state *s, sn_index i, double h) {
    return sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), 1.0 / h);
}

/* The positions before the step are needed no more: they make room for inertia's force, m (v - v predicted) / h. */
static void measure_residual(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 v = velocity(s, i, h);
        double mass = m->inverse_mass[i] > 0.0 ? 1.0 / m->inverse_mass[i] : 0.0;
        s->previous[i] = sn_scale(sn_sub(v, s->velocities[i]), mass / h);
        s->velocities[i] = v;
    }
    s->statistics.residual = sn_residual_measure(m, s, s->previous);
}

static void update_velocities(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    if (substep->measure)
        measure_residual(m, s, substep->h);
    else
        for (sn_index i = 0; i < m->point_count; i++) s->velocities[i] = velocity(s, i, substep->h);
    double most = substep->rules->most_speed * m->diagonal;
    sn_kinematics_watch_bones(m, s, substep->h, most);
    sn_kinematics_limit_speed(m, s, most);
}

/* Until here the velocities are the predicted ones. */
static sn_verdict finish(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    for (sn_index i = 0; i < g->count; i++) {
        sn_contacts_finish(g->members[i], s->members[i]);
        update_velocities(g->members[i], s->members[i], substep);
    }
    sn_externals_keep(g, s);
    return SN_STEP_HOLDS;
}

void sn_project(const sn_model *model, sn_state *state, sn_index muscle, sn_row_kind kind) {
    if (model->scene->solver.method == SN_SOLVER_QN) {
        sn_rows_evaluate(model, state, muscle, kind);
        return;
    }
    const sn_scheme_rules *rules = sn_scheme_rules_of(&model->scene->solver);
    project_kind(&model->muscles[muscle], &state->muscles[muscle], kind, rules, model->substep_duration, true);
}

/* ---- memory ----------------------------------------------------------------------------------------------------------------- */

static bool make_member(const sn_model_muscle *m, sn_muscle_state *s, bool kept_only) {
    sn_xpbd *part = s->memory = SN_NEW(sn_xpbd, 1);
    bool made = part != NULL;
    if (!made) return false;
    SN_XPBD_ARRAYS(SN_MAKE_ARRAY)
    s->inputs->volume_gradient = part->volume_gradient;
    return made;
}

static sn_status create(const sn_group *g, sn_group_state *s, bool kept_only, sn_error *error) {
    bool made = true;
    for (sn_index i = 0; i < g->count; i++) made = made && make_member(g->members[i], s->members[i], kept_only);
    return made ? SN_OK : sn_fail_memory(error, "the state");
}

static void destroy(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        sn_xpbd *part = s->members[i] != NULL ? s->members[i]->memory : NULL;
        if (part == NULL) continue;
        SN_XPBD_ARRAYS(SN_FREE_ARRAY)
        free(part);
    }
}

static void reset(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++)
        if (g->members[i]->single) sn_single_enter(g->members[i], s->members[i]);
}

static size_t bytes_of(const sn_group *g) {
    size_t bytes = 0;
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        bytes += sizeof(sn_xpbd);
        SN_XPBD_ARRAYS(SN_ADD_BYTES)
    }
    return bytes;
}

#define KEPT_NUMBERS(X) X(volume_lambda, isfinite(part->volume_lambda))

static void pass_numbers(sn_cursor *c, const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        sn_xpbd *part = sn_xpbd_of(s->members[i]);
        KEPT_NUMBERS(SN_PASS_NUMBER)
    }
}

static void pass_arrays(sn_cursor *c, const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        sn_xpbd *part = sn_xpbd_of(s->members[i]);
        SN_XPBD_ARRAYS(SN_PASS_ARRAY)
    }
}

/* Points in single precision are as heavy as the model's. */
static bool weights_fit(const sn_model_muscle *m, const sn_xpbd *part) {
    for (sn_index i = 0; m->single && i < m->point_count; i++)
        if (part->single_points[i].w != sn_single_weight(m, i)) return false;
    return true;
}

static const char *fault(const sn_group *g, const sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        const sn_xpbd *part = sn_xpbd_of(s->members[i]);
        KEPT_NUMBERS(SN_CHECK_NUMBER)
        SN_XPBD_ARRAYS(SN_CHECK_ARRAY)
        if (!weights_fit(m, part)) return "points";
    }
    return NULL;
}

static void take(const sn_group *g, const sn_group_state *from, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        const sn_xpbd *read = sn_xpbd_of(from->members[i]);
        sn_xpbd *part = sn_xpbd_of(s->members[i]);
        KEPT_NUMBERS(SN_TAKE_NUMBER)
        SN_XPBD_ARRAYS(SN_TAKE_ARRAY)
    }
}

const sn_backend sn_backend_xpbd = {.name = "xpbd",
                                    .start = start,
                                    .resume = resume,
                                    .iterate = iterate,
                                    .finish = finish,
                                    .create = create,
                                    .destroy = destroy,
                                    .reset = reset,
                                    .bytes = bytes_of,
                                    .pass_numbers = pass_numbers,
                                    .pass_arrays = pass_arrays,
                                    .fault = fault,
                                    .take = take};
