/*
 * contact_show.c -- contact at the vertices, for pictures: what bones press with, and how deep vertices are.
 */
#include "contact.h"

#include <stdlib.h>

/* A third of the area of each triangle at a vertex, at the state's points, m^2: areas (vertex_count). */
static void measure_areas(const sn_model_muscle *m, const sn_muscle_state *s, double *areas) {
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = m->triangles[t].v;
        sn_vec3 a = sn_point_position(&s->points[v[0]]), b = sn_point_position(&s->points[v[1]]), c = sn_point_position(&s->points[v[2]]);
        double third = sn_norm(sn_area_vector(a, b, c)) / 6.0;
        for (int i = 0; i < 3; i++) areas[v[i]] += third;
    }
}

static void sum_forces(const sn_model_muscle *m, const sn_muscle_state *s, double *forces) {
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index r = 0; r < m->contact_count; r++)
        for (int i = 0; i < 3; i++) forces[contacts->rows[r].point[i]] += s->inputs->multipliers[r] * (double)contacts->rows[r].weight[i];
}

sn_status sn_contact_pressures(const sn_model *model, const sn_state *state, sn_index muscle, double *pressures, sn_error *error) {
    const sn_model_muscle *m = &model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    if (!m->quasi_newton)
        return sn_fail(error, SN_ERROR_INPUT, "contact has a pressure under the solver qn alone; xpbd moves vertices without a force");
    double *areas = SN_NEW(double, m->vertex_count);
    if (areas == NULL) return sn_fail_memory(error, "the pressure of contact");
    for (sn_index v = 0; v < m->vertex_count; v++) pressures[v] = 0.0;
    measure_areas(m, s, areas);
    if (m->contact_count > 0) sum_forces(m, s, pressures);
    for (sn_index v = 0; v < m->vertex_count; v++) pressures[v] = areas[v] > 0.0 ? pressures[v] / areas[v] : 0.0;
    free(areas);
    return SN_OK;
}

void sn_contact_depths(const sn_model *model, const sn_state *state, sn_index muscle, double *depths) {
    const sn_model_muscle *m = &model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index v = 0; v < m->vertex_count; v++) depths[v] = 0.0;
    for (sn_index c = 0; c < m->collider_count; c++) {
        const sn_collider *collider = &contacts->colliders[c];
        for (sn_index r = collider->begin; r < collider->end; r++) {
            const sn_contact_row *row = &contacts->rows[r];
            double depth = fmin(0.0, (double)row->margin) - sn_contact_distance(m, s, collider, r);
            for (int i = 0; i < 3 && row->weight[i] > 0.0f; i++) depths[row->point[i]] = fmax(depths[row->point[i]], depth);
        }
    }
}
