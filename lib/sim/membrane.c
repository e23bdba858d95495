/*
 * membrane.c -- the surface as a neo-Hookean membrane, in place of springs along its edges; back end `qn` only.   numerics.md 9
 *
 * Per triangle F = [x1 - x0, x2 - x0] D, f1 and f2 its columns, D the inverse of the goal shape's edges, J = |d1 x d2| / (2 A), A the goal
 * shape's area, mu = lambda = (sqrt 3 / 4) k:
 *   E = A [ mu/2 (|f1|^2 + |f2|^2 - 2 - 2 ln J) + lambda/2 ln^2 J ]
 *   g1 = A mu (f1 D00 + f2 D01) + c d2 x n,  g2 = A mu (f1 D10 + f2 D11) + c n x d1,  g0 = -g1 - g2,  c = (lambda ln J - mu) / (2J), |n| =
 * 1 ln J keeps triangles from collapsing. The fibre law acts on the goal shape: rest edges times c f fT + s t tT in the triangle's plane, f
 * along the fibre, t across it; c = (1 - a) / (1 - a0); s = 1 (projected) or sqrt(g / c) (isochoric).
 */
#include "rows.h"
#include "wide_log.h"

#include <stdlib.h>

/* Below this J its logarithm goes on as a straight line: finite, and continuous with its slope. */
static const double LOG_LINEAR = 1e-3;

/* ---- the rows ----------------------------------------------------------------------------------------------------------------- */

/* A triangle as a membrane: its rest edges in the plane, and what activation and maps do to it. */
typedef struct membrane_row {
    sn_index point[3];
    double edge[2][2]; /* m; [0] along the fibre, [1] across it; columns are x1 - x0 and x2 - x0 */
    double share;      /* of the contraction */
    double softness;   /* 1 / factor on the stiffness */
} membrane_row;

/* What the model keeps: m->own. */
typedef struct membrane_rows {
    sn_index count;
    membrane_row *rows; /* (count) */
    sn_index *index;    /* (3 x count) their points once more, side by side for the kernels */
} membrane_rows;

/* Of a row, in s->inputs->own: D00, D01, D10, D11 of the goal shape (1/m), its area A (m^2), A mu / k; each one after the other for all
 * rows. */
enum { GOALS = 6 };

static const membrane_rows *rows_of(const sn_model_muscle *m) { return m->own[SN_ROWS_MEMBRANE]; }

static double *goals_of(const sn_muscle_state *s) { return s->inputs->own[SN_ROWS_MEMBRANE]; }

/* The fibre axis of a triangle in its plane (unit), or any axis in it where there is none; false: none. */
static bool triangle_axis(const sn_build *build, const sn_index *v, sn_vec3 edge, sn_vec3 normal, sn_vec3 *axis) {
    const sn_vec3 *directions = build->source->rig.fibers.directions;
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (int i = 0; directions != NULL && i < 3; i++) {
        double sign = sn_dot(directions[v[i]], directions[v[0]]) < 0.0 ? -1.0 : 1.0; /* axes have no sign */
        sum = sn_add_scaled(sum, directions[v[i]], sign);
    }
    sum = sn_add_scaled(sum, normal, -sn_dot(sum, normal));
    *axis = sn_normalize(sum);
    if (sn_norm2(sum) > 1e-12) return true;
    *axis = sn_normalize(edge);
    return false;
}

static double map_mean(const sn_build *build, const char *attribute, const sn_index *v) {
    const double *values = sn_mesh_attribute(&build->source->rig.mesh, attribute)->values;
    return (values[v[0]] + values[v[1]] + values[v[2]]) / 3.0;
}

static void add_triangle(const sn_build *build, membrane_rows *all, const sn_index *v) {
    const sn_model_muscle *m = build->model;
    sn_index row = all->count++;
    sn_vec3 e1 = sn_sub(m->rest[v[1]], m->rest[v[0]]), e2 = sn_sub(m->rest[v[2]], m->rest[v[0]]), axis;
    sn_vec3 normal = sn_normalize(sn_cross(e1, e2));
    bool along_fiber = triangle_axis(build, v, e1, normal, &axis);
    sn_vec3 across = sn_cross(normal, axis);
    membrane_row *to = &all->rows[row];
    *to = (membrane_row){.point = {v[0], v[1], v[2]},
                         .edge = {{sn_dot(e1, axis), sn_dot(e2, axis)}, {sn_dot(e1, across), sn_dot(e2, across)}},
                         .share = along_fiber};
    if (build->source->activation_map != NULL) to->share *= map_mean(build, build->source->activation_map, v);
    if (build->source->tendon_map != NULL) to->share *= 1.0 - map_mean(build, build->source->tendon_map, v);
    to->softness = build->source->stiffness_map != NULL ? 1.0 / map_mean(build, build->source->stiffness_map, v) : 1.0;
    for (int i = 0; i < 3; i++) all->index[3 * (size_t)row + (size_t)i] = v[i];
}

static void destroy_membranes(sn_model_muscle *m, sn_row_kind kind) {
    membrane_rows *all = m->own[kind];
    if (all == NULL) return;
    free(all->rows);
    free(all->index);
    free(all);
    m->own[kind] = NULL;
}

/* What degenerate and carried triangles have left free. */
static void fit_rows(membrane_rows *all) {
    membrane_row *rows = sn_realloc(all->rows, (size_t)all->count, sizeof *rows);
    sn_index *index = sn_realloc(all->index, 3 * (size_t)all->count, sizeof *index);
    if (rows != NULL) all->rows = rows;
    if (index != NULL) all->index = index;
}

static sn_status build_membranes(const sn_build *build, sn_row_kind kind, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[kind];
    if (group->reason != SN_RUNS) return SN_OK;
    membrane_rows *all = m->own[kind] = SN_NEW(membrane_rows, 1);
    if (all != NULL) all->rows = SN_NEW(membrane_row, m->triangle_count);
    if (all != NULL) all->index = SN_NEW(sn_index, 3 * (size_t)m->triangle_count);
    if (all == NULL || all->rows == NULL || all->index == NULL) return sn_fail_memory(error, "membrane rows");
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = m->triangles[t].v;
        if (!(m->rest_area[t] > 1e-12 * m->mean_edge * m->mean_edge))
            group->degenerate++;
        else if (m->inverse_mass[v[0]] + m->inverse_mass[v[1]] + m->inverse_mass[v[2]] == 0.0)
            group->kinematic++;
        else
            add_triangle(build, all, v);
    }
    group->rows = all->count;
    fit_rows(all);
    return SN_OK;
}

static sn_index count_rows(const sn_model_muscle *m, sn_row_kind kind) {
    const membrane_rows *all = m->own[kind];
    return all != NULL ? all->count : 0;
}

/* ---- the goal shape ----------------------------------------------------------------------------------------------------------- */

static void set_goals(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind) {
    size_t n = (size_t)count_rows(m, kind);
    double a0 = m->source->contraction * m->source->rest_activation, *goal = goals_of(s);
    for (size_t r = 0; r < n; r++) {
        const membrane_row *row = &rows_of(m)->rows[r];
        double c = (1.0 - row->share * s->inputs->contraction) / (1.0 - row->share * a0);
        double across = m->source->law == SN_LAW_ISOCHORIC ? sqrt(s->inputs->volume_goal / c) : 1.0;
        double determinant = row->edge[0][0] * row->edge[1][1] - row->edge[0][1] * row->edge[1][0];
        goal[r] = row->edge[1][1] / (c * determinant);
        goal[n + r] = -row->edge[0][1] / (across * determinant);
        goal[2 * n + r] = -row->edge[1][0] / (c * determinant);
        goal[3 * n + r] = row->edge[0][0] / (across * determinant);
        goal[4 * n + r] = 0.5 * c * across * fabs(determinant);
        goal[5 * n + r] = goal[4 * n + r] * sqrt(3.0) / (4.0 * row->softness); /* A mu / k */
    }
}

/* ---- energy ------------------------------------------------------------------------------------------------------------------- */

typedef struct membranes {
    const sn_point *points;
    const sn_index *index; /* (3 x rows) */
    const double *goals;   /* (GOALS x rows) one after the other */
    size_t rows;
    double k;
    sn_forces gradient;
} membranes;

/* ln x and its slope, straight below LOG_LINEAR. */
SN_INLINE wide bounded_log(wide x, wide *slope) {
    wide least = wide_splat(LOG_LINEAR), at = wide_select(wide_less(least, x), x, least);
    *slope = wide_splat(1.0) / at;
    return wide_log(at) + (x - at) * *slope;
}

/* Rows r .. r + lanes - 1, which may share points. */
SN_INLINE void membrane_batch(const membranes *in, sn_index r, int lanes, wide_total *energy) {
    const sn_index *index = in->index + 3 * (size_t)r;
    const double *goal = in->goals + r;
    wide_point p[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_gather(in->points, index + i, 3, lanes);
    wide d00 = wide_load(goal, lanes), d01 = wide_load(goal + in->rows, lanes), d10 = wide_load(goal + 2 * in->rows, lanes);
    wide d11 = wide_load(goal + 3 * in->rows, lanes), area = wide_load(goal + 4 * in->rows, lanes);
    wide mu = wide_load(goal + 5 * in->rows, lanes) * wide_splat(in->k), half = wide_splat(0.5), slope; /* times A */
    wide_vec3 d1 = wide_between(p[1], p[0]), d2 = wide_between(p[2], p[0]), n = wide_cross(d1, d2);
    wide_vec3 f1 = wide_add(wide_scale(d1, d00), wide_scale(d2, d10)), f2 = wide_add(wide_scale(d1, d01), wide_scale(d2, d11));
    wide size = wide_sqrt(wide_dot(n, n)), j = half * size / area, ln = bounded_log(j, &slope);
    wide stretch = wide_dot(f1, f1) + wide_dot(f2, f2) - wide_splat(2.0);
    wide_count_in(energy, r, mu * (half * stretch - ln + half * ln * ln), lanes);
    if (in->gradient.values == NULL) return;
    wide_mask open = wide_less(wide_splat(SN_AREA_GUARD), j * j); /* no plane, no push */
    wide push = wide_or_nothing(open, half * mu / area * (ln - wide_splat(1.0)) * slope / size);
    wide_vec3 g1 = wide_scale(wide_add(wide_scale(f1, d00), wide_scale(f2, d01)), mu);
    wide_vec3 g2 = wide_scale(wide_add(wide_scale(f1, d10), wide_scale(f2, d11)), mu);
    g1 = wide_add(g1, wide_scale(wide_cross(d2, n), push));
    g2 = wide_add(g2, wide_scale(wide_cross(n, d1), push));
    const wide_records forces[3] = {wide_records_of(-(g1.x + g2.x), -(g1.y + g2.y), -(g1.z + g2.z)), wide_records_of(g1.x, g1.y, g1.z),
                                    wide_records_of(g2.x, g2.y, g2.z)};
    wide_add_forces(in->gradient, index, 3, forces, lanes);
}

SN_WIDE_KERNEL static double energy_of_membranes(const membranes *in, sn_index end) {
    wide_total energy = {{0}};
    sn_index r = 0;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) membrane_batch(in, r, WIDE_LANES, &energy);
    for (; r < end; r++) membrane_batch(in, r, 1, &energy);
    return wide_sum(&energy);
}

static double energy_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                             sn_forces gradient) {
    if (!(k > 0.0)) return 0.0;
    const membranes in = {points, rows_of(m)->index, goals_of(s), (size_t)count_rows(m, kind), k, gradient};
    return energy_of_membranes(&in, count_rows(m, kind));
}

/* |1/2 (FT F - I)| of one triangle. */
static double strain(const sn_model_muscle *m, const sn_muscle_state *s, sn_index row) {
    const sn_index *v = rows_of(m)->rows[row].point;
    const double *goal = goals_of(s) + row;
    size_t n = (size_t)rows_of(m)->count;
    sn_vec3 origin = sn_point_position(&s->points[v[0]]);
    sn_vec3 d1 = sn_sub(sn_point_position(&s->points[v[1]]), origin), d2 = sn_sub(sn_point_position(&s->points[v[2]]), origin);
    sn_vec3 f1 = sn_add(sn_scale(d1, goal[0]), sn_scale(d2, goal[2 * n])), f2 = sn_add(sn_scale(d1, goal[n]), sn_scale(d2, goal[3 * n]));
    double e1 = sn_norm2(f1) - 1.0, e2 = sn_norm2(f2) - 1.0, shear = sn_dot(f1, f2);
    return 0.5 * sqrt(e1 * e1 + e2 * e2 + 2.0 * shear * shear);
}

static void errors_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                           double *errors) {
    (void)kind;
    for (sn_index r = begin; r < end; r++) *errors++ = strain(m, s, r);
}

/* One edge, now and in the goal shape, between two points; least: the goal that any shorter one counts as. */
static void compare_edge(double now, double goal, double least, const sn_index points[2], sn_longest_edge *longest) {
    double ratio = now / fmax(goal, least);
    if (ratio > longest->ratio) *longest = (sn_longest_edge){ratio, {points[0], points[1]}};
}

/* The edges of the goal shape are the columns of the inverse of D, and their difference. */
static void compare_edges(const sn_model_muscle *m, const sn_muscle_state *s, sn_index row, sn_longest_edge *longest) {
    const sn_index *v = rows_of(m)->rows[row].point;
    const double *goal = goals_of(s) + row;
    size_t n = (size_t)rows_of(m)->count;
    double scale = 1.0 / (goal[0] * goal[3 * n] - goal[n] * goal[2 * n]);
    double x1 = scale * goal[3 * n], y1 = -scale * goal[2 * n], x2 = -scale * goal[n], y2 = scale * goal[0];
    sn_vec3 origin = sn_point_position(&s->points[v[0]]);
    sn_vec3 d1 = sn_sub(sn_point_position(&s->points[v[1]]), origin), d2 = sn_sub(sn_point_position(&s->points[v[2]]), origin);
    double x3 = x2 - x1, y3 = y2 - y1, least = SN_LEAST_GOAL * m->mean_edge;
    compare_edge(sn_norm(d1), sqrt(x1 * x1 + y1 * y1), least, (const sn_index[2]){v[0], v[1]}, longest);
    compare_edge(sn_norm(d2), sqrt(x2 * x2 + y2 * y2), least, (const sn_index[2]){v[0], v[2]}, longest);
    compare_edge(sn_norm(sn_sub(d2, d1)), sqrt(x3 * x3 + y3 * y3), least, (const sn_index[2]){v[1], v[2]}, longest);
}

/* No direction is stretched by more than the root of 1 + 2 |E|, E Green's strain: most triangles need no closer look. */
static void longest_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_row_span *span,
                            sn_longest_edge *longest) {
    (void)kind;
    for (sn_index r = span->begin; r < span->end; r++)
        if (longest->ratio * longest->ratio < (1.0 + 1e-12) * (1.0 + 2.0 * span->errors[r - span->begin])) compare_edges(m, s, r, longest);
}

/* ---- at another shape -------------------------------------------------------------------------------------------------------- */

/* A triangle of the membrane at rest: its strains along and across the fibre, its shear and its dilation for the matrix that knows
 * directions, 2 mu times the cotangent Laplacian for the scalar one. */
static bool linearise_row(const membrane_row *membrane, const sn_vec3 *at, sn_rest_visit visit, void *user) {
    const sn_index *v = membrane->point;
    sn_vec3 p[3], b[3], normal;
    for (int i = 0; i < 3; i++) p[i] = at[v[i]];
    normal = sn_area_vector(p[0], p[1], p[2]);
    double twice = sn_norm(normal), mu = sqrt(3.0) / (4.0 * membrane->softness), area = 0.5 * twice;
    for (int i = 0; i < 3; i++) b[i] = sn_scale(sn_cross(normal, sn_sub(p[(i + 2) % 3], p[(i + 1) % 3])), 1.0 / (twice * twice));
    sn_vec3 t1 = sn_normalize(sn_sub(p[1], p[0])), t2 = sn_cross(sn_normalize(normal), t1);
    sn_rest_row strain[4];
    for (int k = 0; k < 4; k++) strain[k] = (sn_rest_row){.count = 3, .point = v, .scale = (k == 3 ? 1.0 : 2.0) * mu * area};
    for (int i = 0; i < 3; i++) {
        double b1 = sn_dot(b[i], t1), b2 = sn_dot(b[i], t2);
        strain[0].gradient[i] = sn_scale(t1, b1);
        strain[1].gradient[i] = sn_scale(t2, b2);
        strain[2].gradient[i] = sn_scale(sn_add(sn_scale(t2, b1), sn_scale(t1, b2)), sqrt(0.5));
        strain[3].gradient[i] = b[i];
    }
    bool going = true;
    for (int k = 0; k < 4 && going; k++) going = visit(user, &strain[k]);
    for (int i = 0; i < 3 && going; i++) {
        double cotangent = -sn_dot(sn_sub(p[(i + 1) % 3], p[i]), sn_sub(p[i], p[(i + 2) % 3])) / twice; /* of the corner at p[i] */
        const sn_index edge[2] = {v[(i + 1) % 3], v[(i + 2) % 3]};
        const sn_rest_row row = {.count = 2, .point = edge, .weight = {1.0, -1.0}, .scale = mu * cotangent};
        going = visit(user, &row);
    }
    return going;
}

static bool linearise(const sn_model_muscle *m, sn_row_kind kind, const sn_vec3 *at, sn_rest_visit visit, void *user) {
    bool going = true;
    for (sn_index r = 0; r < count_rows(m, kind) && going; r++) going = linearise_row(&rows_of(m)->rows[r], at, visit, user);
    return going;
}

/* ---- the table ----------------------------------------------------------------------------------------------------------------- */

static sn_left_out reason_of(const sn_build *build) {
    if (build->source->stretch != SN_STRETCH_MEMBRANE) return SN_OUT_SETTING;
    return sn_has_stiffness(build->source, 1.0) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    (void)kind;
    return rows_of(m)->rows[row].point;
}

static size_t bytes_of_row(const sn_model_muscle *m) {
    (void)m;
    return sizeof(membrane_row) + 3 * sizeof(sn_index) + GOALS * sizeof(double);
}

static size_t own_bytes(const sn_model_muscle *m, sn_row_kind kind) {
    size_t row = sizeof(membrane_row) + 3 * sizeof(sn_index);
    return m->own[kind] != NULL ? sizeof(membrane_rows) + row * (size_t)count_rows(m, kind) : 0;
}

static size_t own_numbers(const sn_model_muscle *m, sn_row_kind kind) { return GOALS * (size_t)count_rows(m, kind); }

const sn_row_ops sn_rows_membrane = {.info = {"membrane", "strain of the membrane", "no strain", 3, .inside = false},
                                     .reason = reason_of,
                                     .build = build_membranes,
                                     .destroy = destroy_membranes,
                                     .own_bytes = own_bytes,
                                     .count = count_rows,
                                     .points = points_of,
                                     .bytes = bytes_of_row,
                                     .own = own_numbers,
                                     .goals = set_goals,
                                     .energy = energy_of_kind,
                                     .linearise = linearise,
                                     .errors = errors_of_kind,
                                     .longest = longest_of_kind};
