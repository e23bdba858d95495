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
#include "distance_kernel.h"
#include "xpbd.h"

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

static void set_goals(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind) {
    double factors[SN_LAW_TERMS], a0 = m->contracts ? m->source->contraction * m->source->rest_activation : 0.0;
    law_factors(m->source->law, s->inputs->contraction, a0, s->inputs->volume_goal, factors);
    for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
        const double *share = m->distance_share;
        if (share != NULL) law_factors(m->source->law, share[r] * s->inputs->contraction, share[r] * a0, s->inputs->volume_goal, factors);
        s->inputs->goals[r] = goal_length(m->distance_terms[r], factors);
    }
}

/* ---- what runs, and building the rows ------------------------------------------------------------------------------------- */

static sn_left_out reason_inside(const sn_build *build) {
    if (build->source->rig.structure.sample_count == 0) return SN_OUT_NO_STRUCTURE;
    return sn_has_stiffness(build->source, build->source->stiffness_internal) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

static sn_left_out reason_mesh(const sn_build *build) {
    if (!sn_has_stiffness(build->source, 1.0)) return SN_OUT_NO_STIFFNESS;
    return build->source->stretch == SN_STRETCH_MEMBRANE ? SN_OUT_MEMBRANE : SN_RUNS;
}

static double factor_inside(const sn_scene_muscle *source) { return source->stiffness_internal; }

static sn_vec3 vertex_axis(const sn_build *build, sn_index vertex) {
    const sn_vec3 *directions = build->source->rig.fibers.directions;
    return directions != NULL ? directions[vertex] : sn_v3(0, 0, 0);
}

static sn_vec3 sample_axis(const sn_build *build, sn_index sample) {
    const sn_vec3 *axes = build->source->rig.structure.axes;
    return axes != NULL ? axes[sample] : sn_v3(0, 0, 0);
}

double sn_anisotropy_factor(sn_vec3 edge, sn_vec3 fiber) { return fmax(0.0, 1.0 - fabs(sn_dot(sn_normalize(edge), sn_normalize(fiber)))); }

/* The mean of a map over the vertices of a row; the samples inside have no map: they take that of the surface. */
static double map_mean(const sn_build *build, const char *attribute, sn_index p0, sn_index p1) {
    const double *values = sn_mesh_attribute(&build->source->rig.mesh, attribute)->values;
    bool first = p0 < build->model->vertex_count, second = p1 < build->model->vertex_count;
    if (!first && !second) return 1.0;
    return ((first ? values[p0] : values[p1]) + (second ? values[p1] : values[p0])) / 2.0;
}

/* Share of the contraction that a row has: what is tendon has none. */
static double contraction_share(const sn_build *build, sn_index p0, sn_index p1) {
    const char *map = build->source->activation_map;
    double share = map != NULL ? map_mean(build, map, p0, p1) : 1.0;
    return build->tendon != NULL ? share * (1.0 - (build->tendon[p0] + build->tendon[p1]) / 2.0) : share;
}

/* Factors of one row on stiffness, correction and contraction. */
static void set_factors(const sn_build *build, sn_row_kind kind, sn_index row, sn_vec3 axis, double area) {
    sn_model_muscle *m = build->model;
    const sn_index *p = m->distances[row].point;
    sn_vec3 edge = sn_sub(m->rest[p[0]], m->rest[p[1]]);
    double stiffness = 1.0, yielding = kind == SN_ROWS_MESH ? sn_anisotropy_factor(edge, axis) : 1.0;
    /* a spring stands for the strip of membrane beside it: k (2 / sqrt 3) (A1 + A2) / l^2, 1 between equilateral triangles */
    if (build->scaled && kind == SN_ROWS_MESH) stiffness = fmin(fmax(2.0 / sqrt(3.0) * area / sn_norm2(edge), 0.2), 5.0);
    if (build->source->stiffness_map != NULL) stiffness *= map_mean(build, build->source->stiffness_map, p[0], p[1]);
    if (build->anisotropy == SN_ANISOTROPY_XPBD) stiffness *= fmax(yielding, 1e-6);
    if (m->distance_softness != NULL) m->distance_softness[row] = 1.0 / stiffness;
    if (m->distance_gain != NULL) m->distance_gain[row] = yielding;
    if (m->distance_share != NULL) m->distance_share[row] = contraction_share(build, p[0], p[1]);
}

/* An end of a row: its point, and the fibre axis there. */
typedef struct row_end {
    sn_index point;
    sn_vec3 axis;
} row_end;

static row_end end_at_sample(const sn_build *build, sn_index sample) {
    return (row_end){build->sample_points[sample], sample_axis(build, sample)};
}

static row_end end_at_vertex(const sn_build *build, sn_index vertex) { return (row_end){vertex, vertex_axis(build, vertex)}; }

/* Append a row, unless both of its points are carried by bones. area: of the triangles beside it, m^2. */
static void add_row(const sn_build *build, sn_row_kind kind, row_end a, row_end b, double area) {
    sn_model_muscle *m = build->model;
    if (m->inverse_mass[a.point] == 0.0 && m->inverse_mass[b.point] == 0.0) {
        build->plan->groups[kind].kinematic++;
        return;
    }
    sn_index row = m->distance_start[kind + 1]++;
    m->distances[row] = (sn_distance_row){{a.point, b.point}};
    set_factors(build, kind, row, edge_axis(build->source->law, a.axis, b.axis), area);
    double share = m->distance_share != NULL ? m->distance_share[row] : 1.0;
    double a0 = m->contracts ? share * build->source->contraction * build->source->rest_activation : 0.0;
    sn_law_terms(build->source->law, sn_sub(m->rest[a.point], m->rest[b.point]), a.axis, b.axis, a0, m->distance_terms[row]);
}

/* Samples to the samples above them. */
static void add_internal(const sn_build *build) {
    for (sn_index i = 0; i < build->source->rig.structure.sample_count; i++) {
        sn_index parent = build->sample_parents[i];
        if (parent != SN_NONE) add_row(build, SN_ROWS_INTERNAL, end_at_sample(build, parent), end_at_sample(build, i), 0.0);
    }
}

/* Surface vertices to their samples; from sixteen places of the surface in turn, since neighbours hang on the same sample and would wait
 * for each other. */
static void add_radial(const sn_build *build) {
    enum { PLACES = 16 };
    const sn_structure *structure = &build->source->rig.structure;
    sn_index first = build->model->vertex_count, run = (first + PLACES - 1) / PLACES;
    for (sn_index i = 0; i < run; i++) {
        for (sn_index place = 0; place < PLACES; place++) {
            sn_index v = place * run + i, sample = v < first ? structure->vertex_sample[v] : SN_NONE;
            if (sample != SN_NONE) add_row(build, SN_ROWS_RADIAL, end_at_sample(build, sample), end_at_vertex(build, v), 0.0);
        }
    }
}

static void add_mesh(const sn_build *build) {
    for (sn_index i = 0; i < build->topology->edge_count; i++) {
        const sn_edge *edge = &build->topology->edges[i];
        const sn_index *v = edge->v;
        double area = 0.0;
        for (int k = 0; k < 2; k++) area += edge->triangle[k] != SN_NONE ? build->model->rest_area[edge->triangle[k]] : 0.0;
        add_row(build, SN_ROWS_MESH, end_at_vertex(build, v[0]), end_at_vertex(build, v[1]), area);
    }
}

/* Rows of one kind into batches. */
static sn_status batch_kind(const sn_build *build, sn_row_kind kind, sn_index *order, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_index begin = m->distance_start[kind], count = m->distance_start[kind + 1] - begin;
    const struct {
        void *array;
        size_t size;
    } columns[] = {
        {m->distances + begin, sizeof *m->distances},
        {m->distance_terms + begin, sizeof *m->distance_terms},
        {m->distance_softness != NULL ? m->distance_softness + begin : NULL, sizeof(double)},
        {m->distance_gain != NULL ? m->distance_gain + begin : NULL, sizeof(double)},
        {m->distance_share != NULL ? m->distance_share + begin : NULL, sizeof(double)},
    };
    sn_status status =
        sn_batch_order(&(sn_point_rows){count, 2, m->distances[begin].point, m->point_count}, order, &m->distance_batched[kind], error);
    for (size_t i = 0; status == SN_OK && i < sizeof columns / sizeof *columns; i++)
        status = sn_batch_sort(columns[i].array, count, columns[i].size, order, error);
    if (status == SN_OK && m->single) sn_batch_pair(m->distance_batched[kind], 2, m->distances[begin].point, m->distance_pairs + begin / 4);
    return status;
}

static sn_status alloc_rows(const sn_build *build, size_t most, sn_error *error) {
    sn_model_muscle *m = build->model;
    const sn_scene_muscle *source = build->source;
    bool soft = build->scaled || source->stiffness_map != NULL || build->anisotropy == SN_ANISOTROPY_XPBD, made = true;
    made = (m->distances = SN_NEW(sn_distance_row, most + 1)) != NULL && made;
    made = (m->distance_terms = sn_alloc(most, sizeof(*m->distance_terms))) != NULL && made;
    if (soft) made = (m->distance_softness = SN_NEW(double, most)) != NULL && made;
    if (build->anisotropy == SN_ANISOTROPY_PBD) made = (m->distance_gain = SN_NEW(double, most)) != NULL && made;
    if (source->activation_map != NULL || build->tendon != NULL) made = (m->distance_share = SN_NEW(double, most)) != NULL && made;
    if (m->single) made = (m->distance_pairs = SN_NEW(bool, most / 4)) != NULL && made;
    return made ? SN_OK : sn_fail_memory(error, "distance rows");
}

/* All of them: they are in one array, one kind after the other. */
static sn_status build_distances(const sn_build *build, sn_row_kind first, sn_error *error) {
    (void)first;
    static void (*const ADD[SN_DISTANCE_KINDS])(const sn_build *) = {add_internal, add_radial, add_mesh};
    sn_model_muscle *m = build->model;
    size_t most = (size_t)build->topology->edge_count + (size_t)build->plan->samples + (size_t)build->plan->vertices;
    if (most > (size_t)SN_INDEX_MAX / 2) return sn_fail_memory(error, "distance rows");
    sn_index *order = SN_NEW(sn_index, most);
    sn_status status = order != NULL ? alloc_rows(build, most, error) : sn_fail_memory(error, "distance rows");
    for (int kind = 0; status == SN_OK && kind < SN_DISTANCE_KINDS; kind++) {
        m->distance_start[kind + 1] = m->distance_start[kind];
        if (build->plan->groups[kind].reason == SN_RUNS) ADD[kind](build);
        build->plan->groups[kind].rows = m->distance_start[kind + 1] - m->distance_start[kind];
        status = batch_kind(build, (sn_row_kind)kind, order, error);
    }
    free(order);
    return status;
}

/* ---- projecting ----------------------------------------------------------------------------------------------------------- */

/* A length that can be projected: long enough to have a direction, and neither NaN nor infinite. */
static inline bool has_direction(double square) { return square >= SN_EDGE_GUARD && square <= DBL_MAX; }

static void sweep_kind(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep) {
    const distance_rows in = {
        s->points, m->distances->point, s->inputs->goals, m->distance_softness, m->distance_gain, sn_xpbd_of(s)->distance_lambda, NULL};
    sn_index begin = m->distance_start[kind], end = m->distance_start[kind + 1];
    s->statistics.skipped_edges += sweep_distances(&in, begin, begin + m->distance_batched[kind], end, sweep);
}

/* ---- the energy ----------------------------------------------------------------------------------------------------------- */

typedef struct springs {
    const sn_point *points;
    const sn_index *index;  /* (2 x rows) */
    const double *goals;    /* (rows) */
    const double *softness; /* (rows) nullable */
    double k;
    sn_forces gradient;
} springs;

/* Rows r .. r + lanes - 1. A row without direction has no gradient, but all of its energy. */
SN_INLINE void energy_batch(const springs *in, sn_index r, sn_index number, int lanes, wide_total *energy) {
    const sn_index *index = in->index + 2 * (size_t)r;
    wide_vec3 d = wide_between(wide_gather(in->points, index, 2, lanes), wide_gather(in->points, index + 1, 2, lanes));
    wide square = wide_dot(d, d), length = wide_sqrt(square), goal = wide_load(in->goals + r, lanes), k = wide_splat(in->k);
    wide_mask good = has_directions(square);
    if (in->softness != NULL) k = k / wide_load(in->softness + r, lanes);
    wide c = wide_select(good, length - goal, goal), force = k * c;
    wide_count_in(energy, number, wide_splat(0.5) * force * c, lanes);
    if (in->gradient.values == NULL) return;
    wide_vec3 pull = wide_scale(d, force / length);
    wide_records first = wide_records_of(wide_or_nothing(good, pull.x), wide_or_nothing(good, pull.y), wide_or_nothing(good, pull.z));
    const wide_records forces[2] = {first, wide_opposite(first)};
    wide_add_forces(in->gradient, index, 2, forces, lanes);
}

SN_WIDE_KERNEL static double energy_of_rows(const springs *in, sn_index begin, sn_index end) {
    wide_total energy = {{0}};
    sn_index r = begin;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) energy_batch(in, r, r - begin, WIDE_LANES, &energy);
    for (; r < end; r++) energy_batch(in, r, r - begin, 1, &energy);
    return wide_sum(&energy);
}

static double energy_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                             sn_forces gradient) {
    const springs in = {points, m->distances->point, s->inputs->goals, m->distance_softness, k, gradient};
    return energy_of_rows(&in, m->distance_start[kind], m->distance_start[kind + 1]);
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

/* ---- errors --------------------------------------------------------------------------------------------------------------- */

/* Rows r .. r + lanes - 1, over the unit of length. */
SN_INLINE void error_batch(const springs *in, sn_index r, double unit, int lanes, double *error) {
    const sn_index *index = in->index + 2 * (size_t)r;
    wide_vec3 d = wide_between(wide_gather(in->points, index, 2, lanes), wide_gather(in->points, index + 1, 2, lanes));
    wide c = wide_sqrt(wide_dot(d, d)) - wide_load(in->goals + r, lanes);
    wide_store(error, wide_abs(c) / wide_splat(unit), lanes);
}

SN_WIDE_KERNEL static void errors_of_rows(const springs *in, sn_index begin, sn_index end, double unit, double *errors) {
    sn_index r = begin;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) error_batch(in, r, unit, WIDE_LANES, errors + (r - begin));
    for (; r < end; r++) error_batch(in, r, unit, 1, errors + (r - begin));
}

static void errors_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                           double *errors) {
    const springs in = {.points = s->points, .index = m->distances->point, .goals = s->inputs->goals};
    errors_of_rows(&in, m->distance_start[kind] + begin, m->distance_start[kind] + end, m->mean_edge, errors);
}

/* ---- the longest edge ------------------------------------------------------------------------------------------------------ */

static double least_goal(const sn_model_muscle *m) { return SN_LEAST_GOAL * m->mean_edge; }

/* Of rows: goal lengths, errors over `unit` = the mean edge; a goal below `least` counts as that. */
typedef struct goals_and_errors {
    const double *goals, *errors;
    double unit, least;
} goals_and_errors;

/* By its error a row is no longer than goal + error x mean edge, to rounding: may one of `lanes` rows be longer over its goal than `ratio`?
 */
SN_INLINE bool may_be_longer(const goals_and_errors *in, sn_index r, double ratio, int lanes) {
    wide goal = wide_load(in->goals + r, lanes), floor = wide_splat(in->least), slack = wide_splat(1.0 + 1e-12);
    wide most = slack * (goal + wide_load(in->errors + r, lanes) * wide_splat(in->unit));
    return wide_any(wide_less(wide_splat(ratio) * wide_select(wide_less(goal, floor), floor, goal), most));
}

/* The first row from r on that may be longer, to within a batch; end where there is none. */
SN_WIDE_KERNEL static sn_index next_longer(const goals_and_errors *in, double ratio, sn_index r, sn_index end) {
    for (; r + WIDE_LANES <= end; r += WIDE_LANES)
        if (may_be_longer(in, r, ratio, WIDE_LANES)) return r;
    for (; r < end; r++)
        if (may_be_longer(in, r, ratio, 1)) return r;
    return end;
}

static void compare_edge(const sn_model_muscle *m, const sn_muscle_state *s, sn_index row, sn_longest_edge *longest) {
    const sn_index *p = m->distances[row].point;
    double length = sn_distance(sn_point_position(&s->points[p[0]]), sn_point_position(&s->points[p[1]]));
    double ratio = length / fmax(s->inputs->goals[row], least_goal(m));
    if (ratio > longest->ratio) *longest = (sn_longest_edge){ratio, {p[0], p[1]}};
}

static void longest_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_row_span *span,
                            sn_longest_edge *longest) {
    sn_index first = m->distance_start[kind] + span->begin, count = span->end - span->begin;
    const goals_and_errors in = {s->inputs->goals + first, span->errors, m->mean_edge, least_goal(m)};
    for (sn_index r = 0; r < count; r += SN_BATCH) {
        r = next_longer(&in, longest->ratio, r, count);
        for (sn_index i = r; i < count && i < r + SN_BATCH; i++) compare_edge(m, s, first + i, longest);
    }
}

/* ---- at another shape -------------------------------------------------------------------------------------------------------- */

/* A spring between two points bounds its Hessian by k (e_i - e_j)(e_i - e_j)T on each axis (numerics.md 2). */
static bool linearise(const sn_model_muscle *m, sn_row_kind kind, const sn_vec3 *at, sn_rest_visit visit, void *user) {
    double factor = kind == SN_ROWS_MESH ? 1.0 : m->source->stiffness_internal;
    for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
        const sn_index *point = m->distances[r].point;
        sn_vec3 along = sn_normalize(sn_sub(at[point[0]], at[point[1]]));
        sn_rest_row row = {.count = 2, .point = point, .weight = {1.0, -1.0}, .gradient = {along, sn_neg(along)}};
        row.scale = m->distance_softness != NULL ? factor / m->distance_softness[r] : factor;
        if (!visit(user, &row)) return false;
    }
    return true;
}

/* ---- the table ----------------------------------------------------------------------------------------------------------------- */

static sn_index count_rows(const sn_model_muscle *m, sn_row_kind kind) { return m->distance_start[kind + 1] - m->distance_start[kind]; }

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    return m->distances[m->distance_start[kind] + row].point;
}

/* With goal, and lambda under xpbd; of an array that is NULL there are none. */
static size_t bytes_of_row(const sn_model_muscle *m) {
    const void *extra[] = {m->distance_softness, m->distance_gain, m->distance_share};
    size_t bytes = sizeof(sn_distance_row) + sizeof(*m->distance_terms) + (m->quasi_newton ? 1 : 2) * sizeof(double);
    for (int i = 0; i < 3; i++) bytes += extra[i] != NULL ? sizeof(double) : 0;
    return bytes;
}

#define DISTANCE_OPS                                                                                                                       \
    .count = count_rows, .points = points_of, .bytes = bytes_of_row, .goals = set_goals, .sweep = sweep_kind,                              \
    .sweep_single = sn_single_distance_sweep, .energy = energy_of_kind, .linearise = linearise, .errors = errors_of_kind

const sn_row_ops sn_rows_internal = {
    .info = {"internal", "error of internal edges, mean edges", "no length", 2, .inside = true, .spring = true},
    .reason = reason_inside,
    .factor = factor_inside,
    .build = build_distances,
    DISTANCE_OPS};

const sn_row_ops sn_rows_radial = {.info = {"radial", "error of connections, mean edges", "no length", 2, .inside = true, .spring = true},
                                   .reason = reason_inside,
                                   .factor = factor_inside,
                                   DISTANCE_OPS};

const sn_row_ops sn_rows_mesh = {.info = {"mesh", "error of surface edges, mean edges", "no length", 2, .spring = true},
                                 .crushes = true,
                                 .reason = reason_mesh,
                                 .longest = longest_of_kind,
                                 DISTANCE_OPS};
