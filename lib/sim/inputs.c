/*
 * inputs.c -- what activation does at one moment: contraction, stiffness, volume goal, goal lengths, compliances.   methods.md 8.1, 8.3
 */
#include "rows.h"

/* Between relaxed and active in log scale ([R18] 3.3); a stiffness of 0 at one end is 0 at every activation but the other end's. */
static double stiffness_at(const sn_scene_muscle *source, double activation) {
    double relaxed = source->stiffness_relaxed, active = source->stiffness_active;
    if (relaxed == active || activation <= 0.0) return relaxed;
    if (activation >= 1.0) return active;
    if (relaxed <= 0.0 || active <= 0.0) return 0.0;
    return exp((1.0 - activation) * log(relaxed) + activation * log(active));
}

void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time) {
    double activation = sn_channel_at(&m->source->activation, time);
    s->contraction = m->source->contraction * activation;
    if (activation != s->activation) {
        s->stiffness = stiffness_at(m->source, activation);
        s->volume_goal = m->volume_ratio != NULL ? sn_curve_at(m->volume_ratio, activation) / m->rest_ratio : 1.0;
        s->activation = activation;
    }
    sn_distance_goals(m, s);
}

double sn_row_compliance(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, double h) {
    const sn_scene_muscle *source = m->source;
    double k = s->stiffness;
    switch (kind) {
    case SN_ROWS_INTERNAL:
    case SN_ROWS_RADIAL:
        k *= source->stiffness_internal;
        break;
    case SN_ROWS_DIHEDRAL:
        k *= source->stiffness_dihedral;
        break;
    case SN_ROWS_VOLUME:
        k *= source->stiffness_volume / fabs(m->rest_volume);
        break;
    default:
        break;
    }
    return k > 0.0 ? 1.0 / (k * h * h) : -1.0;
}
