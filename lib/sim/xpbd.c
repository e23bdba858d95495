/*
 * xpbd.c -- back end `xpbd`: one substep of one muscle.   [R18] alg. 1, methods.md 8.7, numerics.md 2
 *
 * v <- u + (v - u) e^(-c h) + h g, x <- x + h v, u the velocity of the bones there (kinematic.c); attached vertices to their bones; per
 * iteration every group of rows in order, volume last; v <- (x - x_before) / h. Lambda starts at 0 in each substep (never in each
 * iteration). The papers' schemes damp all of the velocity, and after the force: v <- (v + h g) e^(-c h).
 */
#include "rows.h"

#include <string.h>

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
                            .first = first};
    (m->single ? ops->sweep_single : ops->sweep)(m, s, kind, &sweep);
}

static void project(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    sn_row_kind order[SN_MOST_SWEEPS];
    int count = sn_scheme_order(substep->rules, order);
    for (sn_index i = substep->begin; i < substep->end; i++)
        for (int k = 0; k < count; k++) project_kind(m, s, order[k], substep->rules, substep->h, i == 0);
}

void sn_project(const sn_model *model, sn_state *state, sn_index muscle, sn_row_kind kind) {
    if (model->scene->solver.method == SN_SOLVER_QN) {
        sn_rows_evaluate(&model->muscles[muscle], &state->muscles[muscle], kind);
        return;
    }
    const sn_scheme_rules *rules = sn_scheme_rules_of(&model->scene->solver);
    project_kind(&model->muscles[muscle], &state->muscles[muscle], kind, rules, model->substep_duration, true);
}

static sn_vec3 velocity(const sn_muscle_state *s, sn_index i, double h) {
    return sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), 1.0 / h);
}

/* The positions before the substep are needed no more: they make room for inertia's force, m (v - v predicted) / h. */
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

static sn_verdict xpbd_substep(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    if (substep->begin == 0) {
        predict(m, s, substep);
        sn_kinematics_place(m, s);
        if (m->single) sn_single_enter(m, s);
    }
    if (substep->start != NULL) memcpy(substep->start, s->points, (size_t)m->point_count * sizeof *s->points);
    project(m, s, substep);
    if (m->single) sn_single_leave(m, s);
    s->statistics.residual = NAN;
    if (substep->end == m->iterations) update_velocities(m, s, substep); /* until then they are the predicted ones */
    return SN_STEP_HOLDS;
}

const sn_backend sn_backend_xpbd = {.name = "xpbd", .substep = xpbd_substep};
