/*
 * energy.c -- the energy of one implicit Euler step and its gradient, over the same rows that `xpbd` projects.   numerics.md 2, 9
 *
 *   Phi(x) = 1/2 |x - y|^2_M / h^2 + the energies of all kinds of rows (row_table.c)
 */
#include "qn.h"
#include "skin.h"
#include "wide.h"

#include <string.h>

/* ---- inertia -------------------------------------------------------------------------------------------------------------- */

typedef struct free_points {
    const sn_point *points;
    const sn_vec3 *target;
    double scale;     /* 1 / h^2 */
    sn_point *forces; /* made */
} free_points;

/* Points i .. i + lanes - 1: m |x - y|^2 / (2 h^2); a carried point has none. */
SN_INLINE void inertia_batch(const free_points *in, sn_index i, int lanes, wide_total *energy) {
    wide_point p = wide_load_points(in->points + i, lanes);
    wide zero = wide_splat(0.0), mass = wide_splat(in->scale) / p.w;
    wide_mask is_free = wide_less(zero, p.w);
    wide_vec3 away = wide_between(p, wide_load_vectors(in->target + i, lanes)), force = wide_scale(away, mass);
    wide_point out = {wide_select(is_free, force.x, zero), wide_select(is_free, force.y, zero), wide_select(is_free, force.z, zero), zero};
    wide_count_in(energy, i, wide_select(is_free, wide_splat(0.5) * mass * wide_dot(away, away), zero), lanes);
    wide_store_points(in->forces + i, out, lanes);
}

SN_WIDE_KERNEL static double inertia(const free_points *in, sn_index count) {
    wide_total energy = {{0}};
    sn_index i = 0;
    for (; i + WIDE_LANES <= count; i += WIDE_LANES) inertia_batch(in, i, WIDE_LANES, &energy);
    for (; i < count; i++) inertia_batch(in, i, 1, &energy);
    return wide_sum(&energy);
}

/* ---- all of it ------------------------------------------------------------------------------------------------------------ */

double sn_rows_evaluate(const sn_model *model, const sn_state *state, sn_index muscle, sn_row_kind kind) {
    const sn_model_muscle *m = &model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    sn_point *forces = sn_qn_of(&state->groups[m->group])->forces + model->groups[m->group].first[m->member];
    memset(forces, 0, (size_t)m->point_count * sizeof *forces); /* rows add to what is there: call after call would be more */
    return sn_rows_energy(m, s, kind, s->points, (sn_forces){&forces->x, 4});
}

/* `energy` and those of all rows of one muscle; forces (point_count). */
static double add_rows(const sn_model_muscle *m, const sn_muscle_state *s, const sn_point *points, sn_point *forces, double energy) {
    const sn_forces to = {&forces->x, 4};
    if (m->skin_edge_count > 0) energy += sn_skin_evaluate(m, s, points, to);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++)
        if (!sn_skin_has(m, (sn_row_kind)kind)) energy += sn_rows_energy(m, s, (sn_row_kind)kind, points, to);
    return energy;
}

double sn_objective_evaluate(const sn_objective *objective, const sn_point *points, sn_vec3 *gradient) {
    const sn_group *g = objective->group;
    const sn_qn *qn = sn_qn_of(objective->state);
    const free_points free_ones = {points, qn->target, 1.0 / (objective->h * objective->h), qn->forces};
    double energy = inertia(&free_ones, g->point_count);
    for (sn_index i = 0; i < g->count; i++)
        energy = add_rows(g->members[i], objective->state->members[i], points + g->first[i], qn->forces + g->first[i], energy);
    for (sn_index i = 0; i < g->point_count; i++) gradient[i] = points[i].w == 0.0 ? sn_v3(0, 0, 0) : sn_point_position(&qn->forces[i]);
    return energy;
}
