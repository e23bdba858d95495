/*
 * volume.c -- the enclosed volume, held at its goal.   [R18] 4.1 (overpressure), [K21] 2.2, methods.md 8.3
 *
 * V = 1/6 sum p_i . (p_j x p_k),  dV/dp_i = 1/6 sum p_j x p_k over the triangles of i,  C = V - g(a)/g(a0) V0.
 * Positions are taken relative to their mean: far from the origin the sums cancel. On a closed surface V does not depend on that choice.
 */
#include "rows.h"

static sn_vec3 mean_point(sn_index count, const sn_point *points) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < count; i++) sum = sn_add(sum, sn_sub(sn_point_position(&points[i]), sn_point_position(&points[0])));
    return sn_add_scaled(sn_point_position(&points[0]), sum, 1.0 / count);
}

static inline void add_to(sn_vec3 *sum, sn_vec3 a) { *sum = sn_add_scaled(*sum, a, 1.0 / 6.0); }

double sn_volume_constraint(sn_index vertex_count, const sn_point *points, sn_index triangle_count, const sn_triangle *triangles,
                            sn_vec3 *gradients) {
    if (vertex_count <= 0) return 0.0;
    sn_vec3 centre = mean_point(vertex_count, points);
    double volume = 0.0;
    for (sn_index i = 0; gradients != NULL && i < vertex_count; i++) gradients[i] = sn_v3(0, 0, 0);
    for (sn_index t = 0; t < triangle_count; t++) {
        const sn_index *v = triangles[t].v;
        sn_vec3 a = sn_sub(sn_point_position(&points[v[0]]), centre), b = sn_sub(sn_point_position(&points[v[1]]), centre);
        sn_vec3 c = sn_sub(sn_point_position(&points[v[2]]), centre), bc = sn_cross(b, c);
        volume += sn_dot(a, bc);
        if (gradients == NULL) continue;
        add_to(&gradients[v[0]], bc);
        add_to(&gradients[v[1]], sn_cross(c, a));
        add_to(&gradients[v[2]], sn_cross(a, b));
    }
    return volume / 6.0;
}

double sn_volume_ratio(const sn_model_muscle *m, const sn_muscle_state *s) {
    return sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, NULL) / m->rest_volume;
}

void sn_volume_build(const sn_build *build) {
    sn_plan_group *group = &build->plan->groups[SN_ROWS_VOLUME];
    if (group->reason == SN_OUT_OPEN_SURFACE || group->reason == SN_OUT_FLAT) build->model->rest_volume = NAN; /* nothing to compare with */
    build->model->keeps_volume = group->reason == SN_RUNS && build->plan->kinematic < build->plan->vertices;
    group->rows = build->model->keeps_volume ? 1 : 0;
    group->kinematic = group->reason == SN_RUNS ? 1 - group->rows : 0;
}

/* The volume is far from linear in the positions where the edges pull the muscle far from its goal within one iteration (overpressure): one
 * projection then leaves a per cent or more. It is repeated until what is left is below this share of V0. */
static const double VOLUME_TOLERANCE = 1e-3;

/* One Newton step; false: nothing more to do, or nothing that can be done. */
static bool project(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep) {
    double compliance = sweep->compliance;
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, s->volume_gradient);
    double sum = 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++) sum += s->points[i].w * sn_norm2(s->volume_gradient[i]);
    double residual = s->volume_goal * m->rest_volume - volume - compliance * s->volume_lambda;
    double change = sweep->gain * residual / (sum + compliance);
    if (!isfinite(change)) return false; /* a point is not finite: leave the others alone */
    s->volume_lambda += change;
    for (sn_index i = 0; i < m->vertex_count; i++) {
        sn_point *p = &s->points[i];
        double scale = p->w * change;
        p->x += scale * s->volume_gradient[i].x, p->y += scale * s->volume_gradient[i].y, p->z += scale * s->volume_gradient[i].z;
    }
    /* what is left is of second order: about the square of what there was */
    return residual * residual > VOLUME_TOLERANCE * m->rest_volume * m->rest_volume;
}

void sn_volume_sweep(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep) {
    if (sweep->first) s->volume_lambda = 0.0;
    for (int i = 0; i < sweep->projections && project(m, s, sweep); i++) continue;
}

double sn_volume_energy(const sn_model_muscle *m, sn_muscle_state *s, double k, sn_vec3 *gradient) {
    if (!m->keeps_volume) return 0.0;
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, s->volume_gradient);
    double c = volume - s->volume_goal * m->rest_volume;
    for (sn_index i = 0; gradient != NULL && i < m->vertex_count; i++)
        gradient[i] = sn_add_scaled(gradient[i], s->volume_gradient[i], k * c);
    return 0.5 * k * c * c;
}
