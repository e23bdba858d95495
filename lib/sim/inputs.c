/*
 * inputs.c -- what activation does at one moment: contraction, stiffness, volume goal, goal lengths, compliances.   methods.md 8.1, 8.3
 */
#include "rows.h"

/* Between relaxed and active in log scale ([R18] 3.3); a stiffness of 0 at one end is 0 at every activation but the other end's. */
static double stiffness_at(const sn_model_muscle *m, double activation) {
    const sn_scene_muscle *source = m->source;
    if (m->stiffness_curve != NULL) return sn_exp(sn_curve_at(m->stiffness_curve, activation));
    double relaxed = source->stiffness_relaxed, active = source->stiffness_active;
    if (relaxed == active || activation <= 0.0) return relaxed;
    if (activation >= 1.0) return active;
    if (relaxed <= 0.0 || active <= 0.0) return 0.0;
    return sn_exp((1.0 - activation) * sn_ln(relaxed) + activation * sn_ln(active));
}

void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time) {
    double activation = sn_channel_at(&m->source->activation, time);
    s->inputs->contraction = m->contracts ? m->source->contraction * activation : 0.0;
    if (activation != s->inputs->activation) {
        s->inputs->stiffness = stiffness_at(m, m->contracts ? activation : 0.0);
        s->inputs->volume_goal = m->volume_ratio != NULL && m->contracts ? sn_curve_at(m->volume_ratio, activation) / m->rest_ratio : 1.0;
        s->inputs->activation = activation;
    }
    sn_rows_goals(m, s);
}
