/*
 * inputs.c -- what activation does at one moment: contraction, stiffness, volume goal, goal lengths, compliances.   methods.md 8.1, 8.3
 */
#include "rows.h"

void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time) {
    double activation = sn_muscle_activation(m->source, time);
    s->inputs->contraction = m->contracts ? sn_muscle_contraction(m->source, activation) : 0.0;
    if (activation != s->inputs->activation) {
        s->inputs->stiffness = sn_stiffness_at(m, m->contracts ? activation : 0.0);
        s->inputs->volume_goal = m->volume_ratio != NULL && m->contracts ? sn_curve_at(m->volume_ratio, activation) / m->rest_ratio : 1.0;
        s->inputs->activation = activation;
    }
    sn_rows_goals(m, s);
}
