/*
 * distance.c -- fibrous distance constraints on internal, radial and mesh edges.   [R18] 3.3, methods.md 8.1
 *
 * C = |x0 - x1| - sigma(a). Under each of the three laws the square of the goal length is a sum of three terms that depend on the rest
 * shape only, times three factors that depend on activation only; the same for all rows of a muscle:
 *
 *   projected   sigma^2 = |e_across|^2            + c^2 |e_along|^2                     c = (1 - a) / (1 - a0)
 *   isochoric   sigma^2 = (g / c) |e_across|^2    + c^2 |e_along|^2                     g = goal volume ratio
 *   paper       sigma^2 = sum_i u_i^2 (1 - phi_i a)^2 = sum u^2 - 2a sum phi u^2 + a^2 sum phi^2 u^2
 *               with phi = |f| and u = e / (1 - phi a0), both by component ([R18] eqs. 4-7): not invariant under rotation of the rest pose
 */
#include "rows.h"

#include <float.h>
#include <stdlib.h>

/* ---- the laws ------------------------------------------------------------------------------------------------------------- */

/* The fibre axis of an edge from the axes at its ends. Axes have no sign, so the second is turned towards the first; the paper adds
 * them as they are. Opposite ones then cancel: the first stands for both. */
static sn_vec3 edge_axis(sn_fiber_law law, sn_vec3 f1, sn_vec3 f2) {
    bool turn = law != SN_LAW_PAPER && sn_dot(f1, f2) < 0.0;
    sn_vec3 f = sn_normalize(turn ? sn_sub(f1, f2) : sn_add(f1, f2));
    return sn_norm2(f) > 0.0 ? f : f1;
}

static void paper_terms(sn_vec3 edge, sn_vec3 axis, double a0, double terms[SN_LAW_TERMS]) {
    const double e[3] = {edge.x, edge.y, edge.z}, f[3] = {axis.x, axis.y, axis.z};
    terms[0] = terms[1] = terms[2] = 0.0;
    for (int i = 0; i < 3; i++) {
        double phi = fabs(f[i]), u = e[i] / (1.0 - phi * a0);
        terms[0] += u * u;
        terms[1] += phi * u * u;
        terms[2] += phi * phi * u * u;
    }
}

void sn_law_terms(sn_fiber_law law, sn_vec3 edge, sn_vec3 f1, sn_vec3 f2, double a0, double terms[SN_LAW_TERMS]) {
    sn_vec3 axis = edge_axis(law, f1, f2);
    if (law == SN_LAW_PAPER) {
        paper_terms(edge, axis, a0, terms);
        return;
    }
    double along = sn_dot(edge, axis);
    terms[0] = sn_norm2(sn_add_scaled(edge, axis, -along));
    terms[1] = along * along;
    terms[2] = 0.0;
}

static void law_factors(sn_fiber_law law, double a, double a0, double g, double factors[SN_LAW_TERMS]) {
    double c = (1.0 - a) / (1.0 - a0);
    factors[0] = law == SN_LAW_ISOCHORIC ? g / c : 1.0;
    factors[1] = law == SN_LAW_PAPER ? -2.0 * a : c * c;
    factors[2] = law == SN_LAW_PAPER ? a * a : 0.0;
}

static inline double goal_length(const double terms[SN_LAW_TERMS], const double factors[SN_LAW_TERMS]) {
    double square = terms[0] * factors[0] + terms[1] * factors[1] + terms[2] * factors[2];
    return sqrt(fmax(square, 0.0));
}

double sn_goal_length(sn_fiber_law law, const double terms[SN_LAW_TERMS], double a, double a0, double g) {
    double factors[SN_LAW_TERMS];
    law_factors(law, a, a0, g, factors);
    return goal_length(terms, factors);
}

void sn_distance_goals(const sn_model_muscle *m, sn_muscle_state *s) {
    if (s->goal_contraction == s->contraction && s->goal_ratio == s->volume_goal) return;
    double factors[SN_LAW_TERMS];
    double a0 = m->source->contraction * m->source->rest_activation;
    law_factors(m->source->law, s->contraction, a0, s->volume_goal, factors);
    for (sn_index r = 0; r < m->distance_start[SN_DISTANCE_KINDS]; r++) s->goals[r] = goal_length(m->distance_terms[r], factors);
    s->goal_contraction = s->contraction;
    s->goal_ratio = s->volume_goal;
}

/* ---- building the rows ---------------------------------------------------------------------------------------------------- */

static sn_vec3 vertex_axis(const sn_build *build, sn_index vertex) {
    const sn_vec3 *directions = build->source->rig.fibers.directions;
    return directions != NULL ? directions[vertex] : sn_v3(0, 0, 0);
}

static sn_vec3 sample_axis(const sn_build *build, sn_index sample) {
    const sn_vec3 *axes = build->source->rig.structure.axes;
    return axes != NULL ? axes[sample] : sn_v3(0, 0, 0);
}

/* Append a row, unless both of its points are carried by bones. */
static void add_row(const sn_build *build, sn_row_kind kind, sn_index p0, sn_index p1, sn_vec3 f0, sn_vec3 f1) {
    sn_model_muscle *m = build->model;
    if (m->inverse_mass[p0] == 0.0 && m->inverse_mass[p1] == 0.0) {
        build->plan->groups[kind].kinematic++;
        return;
    }
    sn_index row = m->distance_start[kind + 1]++;
    double a0 = build->source->contraction * build->source->rest_activation;
    m->distances[row] = (sn_distance_row){{p0, p1}};
    sn_law_terms(build->source->law, sn_sub(m->rest[p0], m->rest[p1]), f0, f1, a0, m->distance_terms[row]);
}

/* Samples to their parents. */
static void add_internal(const sn_build *build) {
    const sn_structure *structure = &build->source->rig.structure;
    sn_index first = build->model->vertex_count;
    for (sn_index i = 0; i < structure->sample_count; i++) {
        sn_index parent = structure->parents[i];
        if (parent != SN_NONE)
            add_row(build, SN_ROWS_INTERNAL, first + parent, first + i, sample_axis(build, parent), sample_axis(build, i));
    }
}

/* Surface vertices to their samples. */
static void add_radial(const sn_build *build) {
    const sn_structure *structure = &build->source->rig.structure;
    sn_index first = build->model->vertex_count;
    for (sn_index v = 0; v < build->model->vertex_count; v++) {
        sn_index sample = structure->vertex_sample[v];
        if (sample != SN_NONE) add_row(build, SN_ROWS_RADIAL, first + sample, v, sample_axis(build, sample), vertex_axis(build, v));
    }
}

static void add_mesh(const sn_build *build) {
    for (sn_index i = 0; i < build->topology->edge_count; i++) {
        const sn_index *v = build->topology->edges[i].v;
        add_row(build, SN_ROWS_MESH, v[0], v[1], vertex_axis(build, v[0]), vertex_axis(build, v[1]));
    }
}

sn_status sn_distance_build(const sn_build *build, sn_error *error) {
    static void (*const ADD[SN_DISTANCE_KINDS])(const sn_build *) = {add_internal, add_radial, add_mesh};
    sn_model_muscle *m = build->model;
    size_t most = (size_t)build->topology->edge_count + (size_t)build->plan->samples + (size_t)build->plan->vertices;
    if (most > (size_t)SN_INDEX_MAX) return sn_fail_memory(error, "distance rows");
    m->distances = SN_NEW(sn_distance_row, most);
    m->distance_terms = sn_alloc(most, sizeof(*m->distance_terms));
    if (m->distances == NULL || m->distance_terms == NULL) return sn_fail_memory(error, "distance rows");
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++) {
        m->distance_start[kind + 1] = m->distance_start[kind];
        if (build->plan->groups[kind].reason == SN_RUNS) ADD[kind](build);
        build->plan->groups[kind].rows = m->distance_start[kind + 1] - m->distance_start[kind];
    }
    return SN_OK;
}

/* ---- projecting ----------------------------------------------------------------------------------------------------------- */

/* A length that can be projected: long enough to have a direction, and neither NaN nor infinite. */
static inline bool has_direction(double square) { return square >= SN_EDGE_GUARD && square <= DBL_MAX; }

void sn_distance_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, double compliance, bool first) {
    sn_point *points = s->points;
    int64_t skipped = 0;
    for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
        sn_point *p0 = &points[m->distances[r].point[0]], *p1 = &points[m->distances[r].point[1]];
        double lambda = first ? 0.0 : s->distance_lambda[r];
        double dx = p0->x - p1->x, dy = p0->y - p1->y, dz = p0->z - p1->z;
        double square = dx * dx + dy * dy + dz * dz;
        if (!has_direction(square)) {
            s->distance_lambda[r] = lambda;
            skipped++;
            continue;
        }
        double length = sqrt(square);
        double change = (s->goals[r] - length - compliance * lambda) / (p0->w + p1->w + compliance);
        s->distance_lambda[r] = lambda + change;
        double scale0 = p0->w * change / length, scale1 = p1->w * change / length;
        p0->x += scale0 * dx, p0->y += scale0 * dy, p0->z += scale0 * dz;
        p1->x -= scale1 * dx, p1->y -= scale1 * dy, p1->z -= scale1 * dz;
    }
    s->statistics.skipped_edges += skipped;
}

bool sn_distance_constraint(sn_vec3 p0, sn_vec3 p1, double goal, double *value, sn_vec3 gradients[2]) {
    sn_vec3 d = sn_sub(p0, p1);
    double square = sn_norm2(d);
    if (!has_direction(square)) return false;
    double length = sqrt(square);
    *value = length - goal;
    gradients[0] = sn_scale(d, 1.0 / length);
    gradients[1] = sn_neg(gradients[0]);
    return true;
}

sn_residual sn_distance_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind) {
    sn_residual residual = {.worst = SN_NONE};
    double sum = 0.0;
    sn_index begin = m->distance_start[kind], end = m->distance_start[kind + 1];
    for (sn_index r = begin; r < end; r++) {
        const sn_index *point = m->distances[r].point;
        sn_vec3 d = sn_sub(sn_point_position(&s->points[point[0]]), sn_point_position(&s->points[point[1]]));
        double c = fabs(sn_norm(d) - s->goals[r]) / m->mean_edge;
        sum += c * c;
        if (residual.worst == SN_NONE || c > residual.max) residual.max = c, residual.worst = r - begin;
    }
    if (end > begin) residual.rms = sqrt(sum / (end - begin));
    return residual;
}
