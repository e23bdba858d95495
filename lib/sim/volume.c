/*
 * volume.c -- the enclosed volume, held at its goal.   [R18] 4.1 (overpressure), [K21] 2.2, methods.md 8.3
 *
 * V = 1/6 sum p_i . (p_j x p_k),  dV/dp_i = 1/6 sum p_j x p_k over the triangles of i,  C = V - g(a)/g(a0) V0.
 * Positions are taken relative to their mean: far from the origin the sums cancel. On a closed surface V does not depend on that choice.
 */
#include "wide.h"
#include "xpbd.h"

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

static sn_status build_volume(const sn_build *build, sn_row_kind kind, sn_error *error) {
    (void)error;
    sn_plan_group *group = &build->plan->groups[kind];
    if (group->reason == SN_OUT_OPEN_SURFACE || group->reason == SN_OUT_FLAT) build->model->rest_volume = NAN; /* nothing to compare with */
    build->model->keeps_volume = group->reason == SN_RUNS && build->plan->kinematic < build->plan->vertices;
    group->rows = build->model->keeps_volume ? 1 : 0;
    group->kinematic = group->reason == SN_RUNS ? 1 - group->rows : 0;
    return SN_OK;
}

/* The volume is far from linear in the positions where the edges pull the muscle far from its goal within one iteration (overpressure): one
 * projection then leaves a per cent or more. It is repeated until what is left is below this share of V0. */
static const double VOLUME_TOLERANCE = 1e-3;

/* One Newton step; false: nothing more to do, or nothing that can be done. */
static bool project(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep) {
    sn_xpbd *memory = sn_xpbd_of(s);
    sn_vec3 *gradient = memory->volume_gradient;
    double compliance = sweep->compliance;
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, gradient);
    double sum = 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++) sum += s->points[i].w * sn_norm2(gradient[i]);
    double residual = s->inputs->volume_goal * m->rest_volume - volume - compliance * memory->volume_lambda;
    double change = sweep->gain * residual / (sum + compliance);
    if (!isfinite(change)) return false; /* a point is not finite: leave the others alone */
    memory->volume_lambda += change;
    for (sn_index i = 0; i < m->vertex_count; i++) {
        sn_point *p = &s->points[i];
        double scale = p->w * change;
        p->x += scale * gradient[i].x, p->y += scale * gradient[i].y, p->z += scale * gradient[i].z;
    }
    /* what is left is of second order: about the square of what there was */
    return residual * residual > VOLUME_TOLERANCE * m->rest_volume * m->rest_volume;
}

static void sweep_kind(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep) {
    (void)kind;
    if (sweep->first) sn_xpbd_of(s)->volume_lambda = 0.0;
    for (int i = 0; i < sweep->projections && project(m, s, sweep); i++) continue;
}

/* ---- the energy ----------------------------------------------------------------------------------------------------------- */

sn_vec3 sn_volume_centre(sn_index count, const sn_point *points) {
    sn_vec3 sum[SN_BATCH] = {{0}}, first = sn_point_position(&points[0]);
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 *lane = &sum[i % SN_BATCH];
        *lane = sn_add(*lane, sn_sub(sn_point_position(&points[i]), first));
    }
    return sn_add_scaled(first, sn_add(sn_add(sum[0], sum[1]), sn_add(sum[2], sum[3])), 1.0 / count);
}

typedef struct triangles {
    const sn_point *points;
    const sn_index *index; /* (3 x triangles) */
    sn_vec3 centre;
    sn_forces gradient; /* 6 dV/dx */
} triangles;

/* Triangles t .. t + lanes - 1, which may share points: six times their volume. */
SN_INLINE void volume_batch(const triangles *in, sn_index t, int lanes, wide_total *volume) {
    const sn_index *index = in->index + 3 * (size_t)t;
    const wide_point centre = {wide_splat(in->centre.x), wide_splat(in->centre.y), wide_splat(in->centre.z), wide_splat(0.0)};
    wide_vec3 p[3];
    wide_records areas[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_between(wide_gather(in->points, index + i, 3, lanes), centre);
    wide_vec3 bc = wide_cross(p[1], p[2]);
    wide_count_in(volume, t, wide_dot(p[0], bc), lanes);
    if (in->gradient.values == NULL) return;
    wide_vec3 ca = wide_cross(p[2], p[0]), ab = wide_cross(p[0], p[1]);
    areas[0] = wide_records_of(bc.x, bc.y, bc.z);
    areas[1] = wide_records_of(ca.x, ca.y, ca.z);
    areas[2] = wide_records_of(ab.x, ab.y, ab.z);
    wide_add_forces(in->gradient, index, 3, areas, lanes);
}

SN_WIDE_KERNEL static double volume_of_triangles(const triangles *in, sn_index end) {
    wide_total volume = {{0}};
    sn_index t = 0;
    for (; t + WIDE_LANES <= end; t += WIDE_LANES) volume_batch(in, t, WIDE_LANES, &volume);
    for (; t < end; t++) volume_batch(in, t, 1, &volume);
    return wide_sum(&volume) / 6.0;
}

/* With a gradient, volume_gradient in the state is left at dV/dx. */
static double energy_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                             sn_forces gradient) {
    (void)kind;
    sn_vec3 *volume_gradient = s->inputs->volume_gradient;
    triangles in = {points, m->triangles->v, sn_volume_centre(m->vertex_count, points), {NULL, 3}};
    if (gradient.values != NULL) in.gradient.values = &volume_gradient->x;
    for (sn_index i = 0; gradient.values != NULL && i < m->vertex_count; i++) volume_gradient[i] = sn_v3(0, 0, 0);
    double c = volume_of_triangles(&in, m->triangle_count) - s->inputs->volume_goal * m->rest_volume;
    for (sn_index i = 0; gradient.values != NULL && i < m->vertex_count; i++) {
        sn_vec3 *g = &volume_gradient[i];
        double *sum = gradient.values + (size_t)i * (size_t)gradient.stride;
        *g = sn_scale(*g, 1.0 / 6.0);
        sum[0] += k * c * g->x, sum[1] += k * c * g->y, sum[2] += k * c * g->z;
    }
    return 0.5 * k * c * c;
}

/* ---- the table ----------------------------------------------------------------------------------------------------------------- */

static bool closed(const sn_topology *topology) {
    for (sn_index i = 0; i < topology->edge_count; i++)
        if (topology->edges[i].triangle_count != 2) return false;
    return topology->edge_count > 0;
}

static sn_left_out reason_of(const sn_build *build) {
    double size = build->model->diagonal, volume = build->model->rest_volume;
    if (!closed(build->topology)) return SN_OUT_OPEN_SURFACE;
    if (!(fabs(volume) > 1e-12 * size * size * size)) return SN_OUT_FLAT;
    return sn_has_stiffness(build->source, build->source->stiffness_volume) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

static double factor_of(const sn_scene_muscle *source) { return source->stiffness_volume; }

static sn_index count_rows(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return m->keeps_volume ? 1 : 0;
}

/* The gradient of the volume. */
static size_t bytes_of_row(const sn_model_muscle *m) { return (size_t)m->vertex_count * sizeof(sn_vec3); }

static void errors_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                           double *errors) {
    (void)kind;
    if (begin < end) *errors = fabs(sn_volume_ratio(m, s) - s->inputs->volume_goal);
}

const sn_row_ops sn_rows_volume = {.info = {"volume", "way to the goal volume, mean edges", "no volume", 0, .inside = false},
                                   .crushes = true,
                                   .per_volume = true,
                                   .reason = reason_of,
                                   .factor = factor_of,
                                   .build = build_volume,
                                   .count = count_rows,
                                   .bytes = bytes_of_row,
                                   .sweep = sweep_kind,
                                   .sweep_single = sn_single_volume_sweep,
                                   .energy = energy_of_kind,
                                   .errors = errors_of_kind};
