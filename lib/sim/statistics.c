/*
 * statistics.c -- how far a muscle is from what its constraints ask for.   numerics.md 4
 */
#include "contact.h"

static void measure_volume(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out) {
    double ratio = sn_volume_ratio(m, s), error = ratio - s->inputs->volume_goal;
    out->volume_ratio = ratio;
    out->volume_goal = s->inputs->volume_goal;
    out->volume_error = out->volume_ratio / s->inputs->volume_goal - 1.0;
    out->residuals[SN_ROWS_VOLUME] = m->keeps_volume ? (sn_residual){fabs(error), fabs(error), 0} : (sn_residual){.worst = SN_NONE};
}

static void measure_triangles(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out) {
    out->smallest_triangle = NAN;
    out->smallest_triangle_index = SN_NONE;
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = m->triangles[t].v;
        if (!(m->rest_area[t] > 0.0)) continue;
        sn_vec3 a = sn_point_position(&s->points[v[0]]), b = sn_point_position(&s->points[v[1]]), c = sn_point_position(&s->points[v[2]]);
        double ratio = 0.5 * sn_norm(sn_area_vector(a, b, c)) / m->rest_area[t];
        if (out->smallest_triangle_index != SN_NONE && !(ratio < out->smallest_triangle)) continue;
        out->smallest_triangle = ratio;
        out->smallest_triangle_index = t;
    }
}

static void measure_points(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out) {
    out->kinetic_energy = 0.0;
    out->nan_points = 0;
    out->first_nan = SN_NONE;
    for (sn_index i = 0; i < m->point_count; i++) {
        if (m->inverse_mass[i] > 0.0) out->kinetic_energy += 0.5 * sn_norm2(s->velocities[i]) / m->inverse_mass[i];
        if (sn_finite3(sn_point_position(&s->points[i]))) continue;
        if (out->nan_points++ == 0) out->first_nan = i;
    }
}

/* Every row as if it could give way; rigid ones hold no energy. gradient (point_count) is added to, but by those that other muscles share.
 */
static double elastic_energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_forces gradient) {
    double energy = 0.0;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        const sn_forces to = {ops->shared ? NULL : gradient.values, gradient.stride};
        if (!ops->rigid) energy += sn_rows_energy(m, s, (sn_row_kind)kind, s->points, to);
    }
    return energy;
}

double sn_residual_measure(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *inertia) {
    double sum = 0.0;
    s->statistics.elastic_energy = elastic_energy(m, s, (sn_forces){&inertia->x, 3});
    for (sn_index i = 0; i < m->point_count; i++)
        if (m->inverse_mass[i] > 0.0) sum += sn_norm2(inertia[i]);
    return s->inputs->stiffness > 0.0 && !m->coupled ? sqrt(sum) / (s->inputs->stiffness * m->diagonal) : NAN;
}

/* The errors of all rows but those of all points, which have been measured, and what the surface's say: its longest edge, and whether it is
 * torn. */
static void measure_rows(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out) {
    sn_longest_edge longest = {0.0, {SN_NONE, SN_NONE}};
    int stretch = (int)sn_stretch_kind(m);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++)
        if (sn_row_info_of((sn_row_kind)kind)->points > 0)
            out->residuals[kind] = sn_rows_residual(m, s, (sn_row_kind)kind, kind == stretch ? &longest : NULL);
    const sn_residual *off = &out->residuals[stretch];
    if (off->worst == SN_NONE) sn_rest_longest(m, s, &longest);
    out->largest_edge[0] = longest.point[0], out->largest_edge[1] = longest.point[1];
    out->largest_edge_ratio = longest.point[0] != SN_NONE ? longest.ratio : NAN;
    out->torn = out->torn_substeps > 0 || off->max > SN_FAR_STRETCHED || off->rms > SN_FAR_IN_THE_MEAN;
}

unsigned sn_explosions(const sn_statistics *s) {
    unsigned signs = 0;
    if (s->nan_points > 0) signs |= SN_EXPLODED_POINTS;
    if (fabs(s->volume_error) > SN_EXPLODED_VOLUME_ERROR) signs |= SN_EXPLODED_VOLUME; /* NaN: no volume */
    if (s->largest_edge_ratio > SN_EXPLODED_EDGE_RATIO) signs |= SN_EXPLODED_EDGE;
    if (s->stop_reason == SN_STOP_FAILED) signs |= SN_EXPLODED_SOLVER;
    return signs;
}

void sn_statistics_measure(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_statistics *out = &s->statistics;
    out->activation = s->inputs->activation;
    out->contraction = s->inputs->contraction;
    out->stiffness = s->inputs->stiffness;
    measure_points(m, s, out);
    measure_triangles(m, s, out);
    measure_volume(m, s, out);
    measure_rows(m, s, out);
    sn_contacts_measure(m, s, out);
    out->elastic_energy = elastic_energy(m, s, (sn_forces){NULL, 3});
}
