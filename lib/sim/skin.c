/*
 * skin.c -- all that a closed surface holds of energy under `qn`, and its gradient, in three passes: over triangles, over edges, over
 * triangles again. The same rows as the kinds mesh, dihedral, area and volume have (distance.c, dihedral.c, area.c, volume.c), whose
 * equations are there; here each triangle's normal and each edge's length is found once for all of them, and each triangle adds its forces
 * to its vertices once.   bodies.md 5
 *
 * In a triangle with corners p0, p1, p2, sides e0 = p2 - p1, e1 = p0 - p2, e2 = p1 - p0 (opposite to the corners, e0 + e1 + e2 = 0), n = e2
 * x -e1 and q = |n|^2: hinges   a side whose angle is off by C pulls with F = k_b C / |e|; all three move the corner v by (-e_v . sum F_i
 * e_i) n / q springs  a side pulls with S = k (|e| - goal) / |e|, of which each of its two triangles takes half: T_i = S_i e_i / 2; corner
 * v feels T_j - T_k, j and k the corners that follow it volume   6 dV/dx of a corner is the sum of n of its triangles on a closed surface,
 * and 6 V that of p0 . n barrier  with B'(J) and J = |n| / (2 A0): corner v feels -P e_v x n, P = k A0 B' / (2 A0 |n|)
 */
#include "skin.h"
#include "angle_kernel.h"
#include "area_kernel.h"

#include <stdlib.h>

/* ---- which muscles have one --------------------------------------------------------------------------------------------------------- */

static bool is_two_sided(const sn_model_muscle *m, const sn_edge *edge) {
    return edge->triangle_count == 2 && sn_triangle_runs(&m->triangles[edge->triangle[0]], edge->v[0], edge->v[1]) !=
                                            sn_triangle_runs(&m->triangles[edge->triangle[1]], edge->v[0], edge->v[1]);
}

/* A closed surface of springs and hinges. */
static bool is_skin(const sn_build *build) {
    const sn_model_muscle *m = build->model;
    if (!m->quasi_newton || m->hinge_count == 0 || m->distance_start[SN_ROWS_MESH + 1] == m->distance_start[SN_ROWS_MESH]) return false;
    for (sn_index i = 0; i < build->topology->edge_count; i++)
        if (!is_two_sided(m, &build->topology->edges[i])) return false;
    return build->topology->edge_count > 0;
}

/* ---- building ------------------------------------------------------------------------------------------------------------------------ */

static bool make_room(const sn_build *build) {
    sn_model_muscle *m = build->model;
    m->skin_edge_count = build->topology->edge_count;
    m->skin_triangle_count = m->triangle_count;
    const size_t edges = (size_t)m->skin_edge_count, triangles = (size_t)m->skin_triangle_count;
    bool made = (m->skin_edges = SN_NEW(sn_skin_edge, edges)) != NULL;
    made = (m->skin_springs = SN_NEW(double, edges)) != NULL && made;
    made = (m->skin_hinges = SN_NEW(double, edges)) != NULL && made;
    made = (m->skin_angles = SN_NEW(double, edges)) != NULL && made;
    made = (m->skin_sides = SN_NEW(sn_triangle, triangles)) != NULL && made;
    made = (m->skin_area_rows = SN_NEW(sn_index, triangles)) != NULL && made;
    return (m->skin_area_scales = SN_NEW(double, triangles)) != NULL && made;
}

/* Edges with a spring come first, in the order of its row; place (edges): where each edge of the topology is. */
static void order_edges(const sn_build *build, sn_index *place) {
    const sn_model_muscle *m = build->model;
    const sn_index first = m->distance_start[SN_ROWS_MESH], count = m->distance_start[SN_ROWS_MESH + 1] - first;
    sn_index next = count;
    for (sn_index e = 0; e < m->skin_edge_count; e++) place[e] = SN_NONE;
    for (sn_index r = 0; r < count; r++) {
        const sn_index *p = m->distances[first + r].point;
        place[sn_topology_edge(build->topology, p[0], p[1])] = r;
        m->skin_springs[r] = m->distance_softness != NULL ? 1.0 / m->distance_softness[first + r] : 1.0;
    }
    for (sn_index e = 0; e < m->skin_edge_count; e++)
        if (place[e] == SN_NONE) place[e] = next++;
}

static void take_edges(const sn_build *build, const sn_index *place) {
    const sn_model_muscle *m = build->model;
    for (sn_index e = 0; e < m->skin_edge_count; e++) {
        const sn_edge *edge = &build->topology->edges[e];
        bool first = sn_triangle_runs(&m->triangles[edge->triangle[0]], edge->v[0], edge->v[1]);
        m->skin_edges[place[e]] = (sn_skin_edge){{edge->v[0], edge->v[1], edge->triangle[!first], edge->triangle[first]}};
    }
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_index e = place[sn_topology_edge(build->topology, m->hinges[r].point[0], m->hinges[r].point[1])];
        m->skin_angles[e] = m->hinge_angles[r];
        m->skin_hinges[e] = m->hinge_softness != NULL ? 1.0 / m->hinge_softness[r] : 1.0;
    }
}

/* Rows of areas are the triangles in their order, but for those that are left out. */
static void take_triangles(const sn_build *build, const sn_index *place) {
    const sn_model_muscle *m = build->model;
    sn_index row = 0;
    for (sn_index t = 0; t < m->skin_triangle_count; t++) {
        const sn_index *v = m->triangles[t].v, *p = row < m->area_count ? m->areas[row].point : NULL;
        bool has = p != NULL && p[0] == v[0] && p[1] == v[1] && p[2] == v[2];
        for (int i = 0; i < 3; i++) m->skin_sides[t].v[i] = place[build->topology->triangle_edges[t][i]];
        m->skin_area_rows[t] = has ? row : SN_NONE;
        m->skin_area_scales[t] = has ? m->area_scales[row] : 0.0;
        row += has;
    }
}

sn_status sn_skin_build(const sn_build *build, sn_error *error) {
    if (!is_skin(build)) return SN_OK;
    sn_index *place = SN_NEW(sn_index, build->topology->edge_count);
    sn_status status = place != NULL && make_room(build) ? SN_OK : sn_fail_memory(error, "the surface's rows");
    if (status == SN_OK) {
        order_edges(build, place);
        take_edges(build, place);
        take_triangles(build, place);
    }
    free(place);
    return status;
}

bool sn_skin_has(const sn_model_muscle *m, sn_row_kind kind) {
    if (m->skin_edge_count == 0) return false;
    return kind == SN_ROWS_MESH || kind == SN_ROWS_DIHEDRAL || kind == SN_ROWS_AREA || kind == SN_ROWS_VOLUME;
}

/* ---- triangles: normals, the volume, barriers ---------------------------------------------------------------------------------------- */

typedef struct skin {
    const sn_model_muscle *m;
    const sn_inputs *inputs;
    const sn_point *points;
    const double *goals; /* of the edges with a spring */
    sn_vec3 centre;
    double k, k_hinge, k_area;
    sn_forces gradient;
} skin;

/* Which triangles from t on have a barrier. */
SN_INLINE wide_mask guarded(const skin *in, sn_index t, int lanes) {
    bool flags[SN_BATCH];
    for (int i = 0; i < lanes; i++) {
        sn_index row = in->m->skin_area_rows[t + i];
        flags[i] = row != SN_NONE && in->inputs->guarded[row];
    }
    return wide_flags(flags, lanes);
}

/* Triangles t .. t + lanes - 1. */
SN_INLINE void normal_batch(const skin *in, sn_index t, int lanes, wide_total *volume, wide_total *energy) {
    const sn_index *index = in->m->triangles->v + 3 * (size_t)t;
    const wide_point centre = {wide_splat(in->centre.x), wide_splat(in->centre.y), wide_splat(in->centre.z), wide_splat(0.0)};
    wide_point p[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_gather(in->points, index + i, 3, lanes);
    wide zero = wide_splat(0.0), one = wide_splat(1.0);
    wide_vec3 n = wide_cross(wide_between(p[1], p[0]), wide_between(p[2], p[0]));
    wide q = wide_dot(n, n), size = wide_sqrt(q), scale = wide_load(in->m->skin_area_scales + t, lanes), j = size * scale, slope;
    wide_mask good = wide_less(zero, q) & ~wide_less(wide_splat(WIDE_MOST), q);
    wide_store_points(in->inputs->skin_normals + t, (wide_point){n.x, n.y, n.z, wide_select(good, one / q, zero)}, lanes);
    wide_count_in(volume, t, wide_dot(wide_between(p[0], centre), n), lanes);
    wide push = zero;
    wide_mask small = wide_less(zero, scale) & ~wide_less(one, j); /* or not a number */
    if (in->k_area > 0.0 && wide_any(small)) {
        small &= guarded(in, t, lanes);
        wide half = wide_splat(0.5 * in->k_area), height = barrier(j, &slope);
        wide_count_in(energy, t, wide_or_nothing(small, half / scale * height), lanes);
        push = wide_select(small & wide_less(wide_splat(SN_AREA_GUARD), j * j), half * slope / size, zero);
    }
    wide_store(in->inputs->skin_pushes + t, push, lanes);
}

/* Six times the volume; *energy: of the barriers. */
SN_WIDE_KERNEL static double pass_of_normals(const skin *in, double *energy) {
    wide_total volume = {{0}}, barriers = {{0}};
    sn_index t = 0, end = in->m->skin_triangle_count;
    for (; t + WIDE_LANES <= end; t += WIDE_LANES) normal_batch(in, t, WIDE_LANES, &volume, &barriers);
    for (; t < end; t++) normal_batch(in, t, 1, &volume, &barriers);
    *energy = wide_sum(&barriers);
    return wide_sum(&volume);
}

/* ---- edges: springs and hinges --------------------------------------------------------------------------------------------------------
 */

/* Edges e .. e + lanes - 1, all of them with a spring, or none. */
SN_INLINE void edge_batch(const skin *in, sn_index e, int lanes, bool springs, wide_total *stretch, wide_total *bend) {
    enum { STRIDE = 4 };
    const sn_index *index = in->m->skin_edges->at + STRIDE * (size_t)e;
    wide_point a = wide_gather(in->points, index, STRIDE, lanes), b = wide_gather(in->points, index + 1, STRIDE, lanes);
    wide_point r1 = wide_gather(in->inputs->skin_normals, index + 2, STRIDE, lanes),
               r2 = wide_gather(in->inputs->skin_normals, index + 3, STRIDE, lanes);
    wide_vec3 along = wide_between(b, a), n1 = {r1.x, r1.y, r1.z}, n2 = {r2.x, r2.y, r2.z};
    wide zero = wide_splat(0.0), e2 = wide_dot(along, along), length = wide_sqrt(e2), over = wide_splat(1.0) / length, pull = zero;
    if (springs) {
        wide_mask straight = has_directions(e2);
        wide goal = wide_load(in->goals + e, lanes), k = wide_splat(in->k) * wide_load(in->m->skin_springs + e, lanes);
        wide c = wide_select(straight, length - goal, goal), force = k * c;
        wide_count_in(stretch, e, wide_splat(0.5) * force * c, lanes);
        pull = wide_select(straight, force * over, zero);
    }
    wide least = wide_splat(WIDE_HINGE_GUARD) * e2 * e2, q1 = wide_dot(n1, n1), q2 = wide_dot(n2, n2), most = wide_splat(WIDE_MOST);
    wide factor = wide_load(in->m->skin_hinges + e, lanes), k = wide_splat(in->k_hinge) * factor;
    wide_mask bends = wide_less(zero, factor) & ~wide_less(e2, wide_splat(SN_EDGE_GUARD)) & wide_less(least, q1) & wide_less(least, q2) &
                      ~wide_less(most, q1) & ~wide_less(most, q2);
    wide c = wrap(angle_of(wide_dot(wide_cross(n1, n2), along) * over, wide_dot(n1, n2)) - wide_load(in->m->skin_angles + e, lanes));
    wide force = k * c;
    wide_count_in(bend, e, wide_or_nothing(bends, wide_splat(0.5) * force * c), lanes);
    wide_store(in->inputs->skin_pulls + e, pull, lanes);
    wide_store(in->inputs->skin_turns + e, wide_select(bends, force * over, zero), lanes);
}

/* Energy of springs and hinges. */
SN_WIDE_KERNEL static double pass_of_edges(const skin *in) {
    wide_total stretch = {{0}}, bend = {{0}};
    sn_index e = 0, held = in->m->distance_start[SN_ROWS_MESH + 1] - in->m->distance_start[SN_ROWS_MESH], end = in->m->skin_edge_count;
    for (; e + WIDE_LANES <= held; e += WIDE_LANES) edge_batch(in, e, WIDE_LANES, true, &stretch, &bend);
    for (; e < held; e++) edge_batch(in, e, 1, true, &stretch, &bend);
    for (; e < end; e++) edge_batch(in, e, 1, false, &stretch, &bend);
    return wide_sum(&stretch) + wide_sum(&bend);
}

/* ---- triangles: all forces ------------------------------------------------------------------------------------------------------------
 */

SN_INLINE wide_vec3 less(wide_vec3 a, wide_vec3 b) { return (wide_vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }

/* pressure: k_V C / 6. */
SN_INLINE void force_batch(const skin *in, sn_index t, wide pressure, int lanes) {
    const sn_index *index = in->m->triangles->v + 3 * (size_t)t, *sides = in->m->skin_sides->v + 3 * (size_t)t;
    wide_point p[3], record = wide_load_points(in->inputs->skin_normals + t, lanes);
    wide_vec3 n = {record.x, record.y, record.z}, e[3], pull[3], turn;
    wide push = wide_load(in->inputs->skin_pushes + t, lanes);
    wide_records forces[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_gather(in->points, index + i, 3, lanes);
    SN_UNROLL
    for (int i = 0; i < 3; i++) {
        e[i] = wide_between(p[(i + 2) % 3], p[(i + 1) % 3]);
        pull[i] = wide_scale(e[i], wide_splat(0.5) * wide_pick(in->inputs->skin_pulls, sides + i, 3, lanes));
        wide_vec3 side = wide_scale(e[i], wide_pick(in->inputs->skin_turns, sides + i, 3, lanes));
        turn = i == 0 ? side : wide_add(turn, side);
    }
    SN_UNROLL
    for (int i = 0; i < 3; i++) {
        wide along = pressure - wide_dot(e[i], turn) * record.w;
        wide_vec3 f = wide_add(wide_scale(n, along), less(pull[(i + 1) % 3], pull[(i + 2) % 3]));
        f = less(f, wide_scale(wide_cross(e[i], n), push));
        forces[i] = wide_records_of(f.x, f.y, f.z);
    }
    wide_add_forces(in->gradient, index, 3, forces, lanes);
}

SN_WIDE_KERNEL static void pass_of_forces(const skin *in, double pressure) {
    wide all = wide_splat(pressure);
    sn_index t = 0, end = in->m->skin_triangle_count;
    for (; t + WIDE_LANES <= end; t += WIDE_LANES) force_batch(in, t, all, WIDE_LANES);
    for (; t < end; t++) force_batch(in, t, all, 1);
}

double sn_skin_evaluate(const sn_model_muscle *m, const sn_muscle_state *s, const sn_point *points, sn_forces gradient) {
    const skin in = {.m = m,
                     .inputs = s->inputs,
                     .points = points,
                     .goals = s->inputs->goals + m->distance_start[SN_ROWS_MESH],
                     .centre = m->keeps_volume ? sn_volume_centre(m->vertex_count, points) : sn_v3(0, 0, 0),
                     .k = sn_row_stiffness(m, s, SN_ROWS_MESH),
                     .k_hinge = sn_row_stiffness(m, s, SN_ROWS_DIHEDRAL),
                     .k_area = m->area_count > 0 ? sn_row_stiffness(m, s, SN_ROWS_AREA) : 0.0,
                     .gradient = gradient};
    double energy, volume = pass_of_normals(&in, &energy) / 6.0, pressure = 0.0;
    energy += pass_of_edges(&in);
    if (m->keeps_volume) {
        double c = volume - s->inputs->volume_goal * m->rest_volume, k = sn_row_stiffness(m, s, SN_ROWS_VOLUME);
        energy += 0.5 * k * c * c;
        pressure = k * c / 6.0;
    }
    pass_of_forces(&in, pressure);
    return energy;
}

void sn_skin_keep(const sn_model_muscle *m, const sn_muscle_state *s) {
    for (sn_index t = 0; t < m->skin_triangle_count; t++) s->inputs->skin_kept[t] = s->inputs->skin_normals[t].w;
}

bool sn_skin_keeps_areas(const sn_model_muscle *m, const sn_muscle_state *s, double least) {
    const sn_inputs *in = s->inputs;
    for (sn_index t = 0; t < m->skin_triangle_count; t++) {
        sn_index row = m->skin_area_rows[t];
        double before = in->skin_kept[t], now = in->skin_normals[t].w; /* 1 / |n|^2; 0: it has no plane */
        if (row == SN_NONE || !in->guarded[row] || before == 0.0) continue;
        if (now == 0.0 || before < least * least * now) return false;
    }
    return true;
}

void sn_skin_volume_gradient(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_vec3 *gradient = s->inputs->volume_gradient;
    for (sn_index v = 0; v < m->vertex_count; v++) gradient[v] = sn_v3(0, 0, 0);
    for (sn_index t = 0; t < m->skin_triangle_count; t++) {
        sn_vec3 n = sn_point_position(&s->inputs->skin_normals[t]);
        for (int i = 0; i < 3; i++) gradient[m->triangles[t].v[i]] = sn_add(gradient[m->triangles[t].v[i]], n);
    }
    for (sn_index v = 0; v < m->vertex_count; v++) gradient[v] = sn_scale(gradient[v], 1.0 / 6.0);
}
