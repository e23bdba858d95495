/*
 * stiffness.c -- what the scene says of a muscle's stiffness.   [R18] 3.3
 */
#include "rows.h"

bool sn_has_stiffness(const sn_scene_muscle *source, double factor) {
    return factor > 0.0 && (source->stiffness_relaxed > 0.0 || source->stiffness_active > 0.0);
}

double sn_stiffness_at(const sn_model_muscle *m, double activation) {
    const sn_scene_muscle *source = m->source;
    if (m->stiffness_curve != NULL) return sn_exp(sn_curve_at(m->stiffness_curve, activation));
    double relaxed = source->stiffness_relaxed, active = source->stiffness_active;
    if (relaxed == active || activation <= 0.0) return relaxed;
    if (activation >= 1.0) return active;
    if (relaxed <= 0.0 || active <= 0.0) return 0.0;
    return sn_exp((1.0 - activation) * sn_ln(relaxed) + activation * sn_ln(active));
}
