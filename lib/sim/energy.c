/*
 * energy.c -- the energy of one implicit Euler step and its gradient, over the same rows that `xpbd` projects.   numerics.md 2, 9
 *
 *   Phi(x) = 1/2 |x - y|^2_M / h^2 + sum_distances k/2 C^2 + sum_hinges k_b/2 C^2 + k_V/2 (V - goal)^2 + sum_areas B(J)
 *   B(J) = -k A0 (J - 1)^2 ln J for J < 1, J = area / A0: the area rows as an energy, since springs do not resist a triangle's loss of
 *   area. Triangles that the substep found collapsed have no barrier: it would hold them on the wrong side of a fold.
 */
#include "qn.h"

/* Below this share of its rest area a triangle's barrier goes on as a straight line: finite, and continuous with its slope. */
static const double BARRIER_LINEAR = 1e-3;

static inline void add(sn_vec3 *sum, sn_vec3 a, double scale) { *sum = sn_add_scaled(*sum, a, scale); }

static double inertia(const sn_objective *o, const sn_point *points, sn_vec3 *gradient) {
    double energy = 0.0, scale = 1.0 / (o->h * o->h);
    for (sn_index i = 0; i < o->model->point_count; i++) {
        gradient[i] = sn_v3(0, 0, 0);
        if (points[i].w == 0.0) continue;
        sn_vec3 away = sn_sub(sn_point_position(&points[i]), o->state->target[i]);
        double mass = scale / points[i].w;
        gradient[i] = sn_scale(away, mass);
        energy += 0.5 * mass * sn_norm2(away);
    }
    return energy;
}

/* B(J) and dB/dJ over k A0. */
static double barrier(double j, double *slope) {
    double at = j > BARRIER_LINEAR ? j : BARRIER_LINEAR, gap = at - 1.0, logarithm = log(at);
    *slope = -(2.0 * gap * logarithm + gap * gap / at);
    return -gap * gap * logarithm + *slope * (j - at);
}

static double areas(const sn_objective *o, const sn_point *points, sn_vec3 *gradient) {
    const sn_model_muscle *m = o->model;
    double k = sn_row_stiffness(m, o->state, SN_ROWS_AREA), energy = 0.0;
    for (sn_index r = 0; k > 0.0 && r < m->area_count; r++) {
        const sn_index *v = m->areas[r].point;
        double scale = m->area_scales[r], slope;
        sn_vec3 a = sn_point_position(&points[v[0]]);
        sn_vec3 d1 = sn_sub(sn_point_position(&points[v[1]]), a), d2 = sn_sub(sn_point_position(&points[v[2]]), a), n = sn_cross(d1, d2);
        double size = sn_norm(n), ratio = size * scale;
        if (ratio >= 1.0 || !o->state->guarded[r]) continue;
        energy += k * 0.5 / scale * barrier(ratio, &slope);
        if (!(ratio * ratio > SN_AREA_GUARD)) continue; /* no plane to push in */
        double push = 0.5 * k * slope / size;           /* k A0 dB/dJ dJ/d|n| / |n| */
        sn_vec3 g1 = sn_cross(d2, n), g2 = sn_cross(n, d1);
        add(&gradient[v[1]], g1, push);
        add(&gradient[v[2]], g2, push);
        add(&gradient[v[0]], sn_add(g1, g2), -push);
    }
    return energy;
}

double sn_objective_evaluate(const sn_objective *objective, sn_point *points, sn_vec3 *gradient) {
    const sn_model_muscle *m = objective->model;
    sn_muscle_state at = *objective->state; /* the same inputs at other points */
    at.points = points;
    double energy = inertia(objective, points, gradient);
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++)
        energy += sn_distance_energy(m, &at, (sn_row_kind)kind, sn_row_stiffness(m, &at, (sn_row_kind)kind), gradient);
    energy += sn_hinge_energy(m, &at, sn_row_stiffness(m, &at, SN_ROWS_DIHEDRAL), gradient);
    energy += areas(objective, points, gradient);
    if (m->keeps_volume) energy += sn_volume_energy(m, &at, sn_row_stiffness(m, &at, SN_ROWS_VOLUME), gradient);
    for (sn_index i = 0; i < m->point_count; i++)
        if (points[i].w == 0.0) gradient[i] = sn_v3(0, 0, 0);
    return energy;
}
