/*
 * dihedral.c -- local shape: the angle between the two triangles at an edge.   [K21] 2.3, methods.md 8.4, numerics.md 6
 *
 * Triangles (a,b,c) and (b,a,d), seen from outside; e = b - a, n1 = (a-c) x (b-c), n2 = (b-d) x (a-d), both outwards;
 *   theta = atan2((n1 x n2).e/|e|, n1.n2),   C = wrap(theta - theta0) in (-pi, pi]
 * (not arccos, which loses the sign and whose gradient is singular when flat). With q = |n|^2:
 *   g_c = -|e| n1/q1                                      g_a =  ((b-c).e/|e|) n1/q1 + ((b-d).e/|e|) n2/q2
 *   g_d = -|e| n2/q2                                      g_b = -((a-c).e/|e|) n1/q1 - ((a-d).e/|e|) n2/q2
 *
 * The program of [K21] (github.com/cervenkam/muscle-deformation-PBD, src/pbd.cxx) does otherwise. With d the cosine between the normals
 * (a-b) x (c-b) and (a-b) x (d-b), which is -1 where the hinge is flat, phi0 = |theta0|, q_i the vectors of Mueller et al. 2007 and s =
 * 0.9: lambda = -4 s sqrt(1 - d^2) (acos d - (pi - phi0)) / (max(1e-4, sum |q|^2) sum w),   dp_i = lambda w_i q_i unless |d| > 1 - 1e-10,
 * lambda < 0.1 or lambda > 10. So it flattens hinges that are bent more than at rest, to whichever side, and lets all others be. In the
 * terms from above acos d = pi - |theta|, sqrt(1 - d^2) = |sin theta| and q_i = -sin theta g_i. Its limits are in the unit of its data, the
 * millimetre: 1e-4 mm^-2, 0.1 and 10 mm^2. Here they are the same lengths whatever the unit of a document is, so that a muscle moves alike
 * in metres and in millimetres, and as it does there.
 */
#include "dihedral_kernel.h"
#include "xpbd.h"

#include <stdlib.h>

bool sn_hinge_constraint(const sn_vec3 p[4], double rest, double *value, sn_vec3 gradients[4]) {
    static const sn_index FIRST = 0;
    wide_point points[4];
    wide_vec3 g[4];
    wide c;
    for (int i = 0; i < 4; i++) {
        const sn_point point = {p[i].x, p[i].y, p[i].z, 0.0};
        points[i] = wide_gather(&point, &FIRST, 0, 1);
    }
    if (wide_count(hinge(points, wide_splat(rest), &c, g), 1) == 0) return false;
    wide_store(value, c, 1);
    for (int i = 0; i < 4; i++) {
        wide_store(&gradients[i].x, g[i].x, 1);
        wide_store(&gradients[i].y, g[i].y, 1);
        wide_store(&gradients[i].z, g[i].z, 1);
    }
    return true;
}

/* ---- building the rows ---------------------------------------------------------------------------------------------------- */

/* The row of an edge with two triangles; false where both triangles run the same way along it: they have no common outside. */
static bool hinge_points(const sn_model_muscle *m, const sn_edge *edge, sn_hinge_row *row) {
    sn_index a = edge->v[0], b = edge->v[1];
    bool first = sn_triangle_runs(&m->triangles[edge->triangle[0]], a, b),
         second = sn_triangle_runs(&m->triangles[edge->triangle[1]], a, b);
    if (first == second) return false;
    *row = (sn_hinge_row){{a, b, edge->opposite[first ? 0 : 1], edge->opposite[first ? 1 : 0]}};
    return true;
}

static void add_hinge(const sn_build *build, const sn_edge *edge) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[SN_ROWS_DIHEDRAL];
    sn_hinge_row row;
    if (edge->triangle_count != 2) return;
    if (!hinge_points(m, edge, &row)) {
        group->degenerate++;
        return;
    }
    sn_vec3 p[4], gradients[4];
    double inverse_mass = 0.0, angle;
    for (int i = 0; i < 4; i++) {
        p[i] = m->rest[row.point[i]];
        inverse_mass += m->inverse_mass[row.point[i]];
    }
    if (!sn_hinge_constraint(p, 0.0, &angle, gradients)) {
        group->degenerate++;
    } else if (inverse_mass == 0.0) {
        group->kinematic++;
    } else {
        if (m->hinge_softness != NULL) {
            double area = m->rest_area[edge->triangle[0]] + m->rest_area[edge->triangle[1]];
            m->hinge_softness[m->hinge_count] = 2.0 / sqrt(3.0) * area / sn_norm2(sn_sub(p[0], p[1]));
        }
        m->hinges[m->hinge_count] = row;
        m->hinge_angles[m->hinge_count++] = angle;
    }
}

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* k_i sum |g_i|^2 at rest over k: how stiff a hinge is for its points. */
static double rest_rigidity(const sn_model_muscle *m, sn_index row) {
    sn_vec3 p[4], g[4];
    double angle, sum = 0.0;
    for (int i = 0; i < 4; i++) p[i] = m->rest[m->hinges[row].point[i]];
    if (!sn_hinge_constraint(p, 0.0, &angle, g)) return 0.0;
    for (int i = 0; i < 4; i++) sum += sn_norm2(g[i]);
    return sum / m->hinge_softness[row];
}

/* A hinge between slivers is stiffer than all others together: cap it at so many times the median. */
static const double RIGIDITY_CAP = 10.0;

static sn_status cap_rigidity(sn_model_muscle *m, sn_error *error) {
    if (m->hinge_softness == NULL || m->hinge_count == 0) return SN_OK;
    double *sorted = SN_NEW(double, m->hinge_count);
    if (sorted == NULL) return sn_fail_memory(error, "dihedral rows");
    for (sn_index r = 0; r < m->hinge_count; r++) sorted[r] = rest_rigidity(m, r);
    qsort(sorted, (size_t)m->hinge_count, sizeof *sorted, compare_numbers);
    double most = RIGIDITY_CAP * sorted[m->hinge_count / 2];
    for (sn_index r = 0; r < m->hinge_count; r++) m->hinge_softness[r] *= fmax(1.0, rest_rigidity(m, r) / most);
    free(sorted);
    return SN_OK;
}

static sn_status batch_hinges(sn_model_muscle *m, sn_error *error) {
    sn_index n = m->hinge_count, *order = SN_NEW(sn_index, n);
    if (order == NULL) return sn_fail_memory(error, "dihedral rows");
    sn_status status = sn_batch_order(&(sn_point_rows){n, 4, m->hinges->point, m->vertex_count}, order, &m->hinge_batched, error);
    if (status == SN_OK) status = sn_batch_sort(m->hinges, n, sizeof *m->hinges, order, error);
    if (status == SN_OK) status = sn_batch_sort(m->hinge_angles, n, sizeof *m->hinge_angles, order, error);
    if (status == SN_OK) status = sn_batch_sort(m->hinge_softness, n, sizeof *m->hinge_softness, order, error);
    free(order);
    if (status != SN_OK || !m->single) return status;
    if ((m->hinge_pairs = SN_NEW(bool, m->hinge_batched / 4)) == NULL) return sn_fail_memory(error, "dihedral rows");
    sn_batch_pair(m->hinge_batched, 4, m->hinges->point, m->hinge_pairs);
    return SN_OK;
}

static sn_status build_hinges(const sn_build *build, sn_row_kind kind, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[kind];
    if (group->reason != SN_RUNS) return SN_OK;
    size_t most = (size_t)build->topology->edge_count;
    m->hinges = SN_NEW(sn_hinge_row, most);
    m->hinge_angles = SN_NEW(double, most);
    if (build->scaled) m->hinge_softness = SN_NEW(double, most);
    if (m->hinges == NULL || m->hinge_angles == NULL || (build->scaled && m->hinge_softness == NULL))
        return sn_fail_memory(error, "dihedral rows");
    for (sn_index i = 0; i < build->topology->edge_count; i++) add_hinge(build, &build->topology->edges[i]);
    group->rows = m->hinge_count;
    sn_status status = cap_rigidity(m, error);
    return status == SN_OK ? batch_hinges(m, error) : status;
}

/* ---- projecting ----------------------------------------------------------------------------------------------------------- */

static void sweep_kind(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep) {
    (void)kind;
    const hinge_rows in = {s->points, m->hinges->point, m->hinge_angles, m->hinge_softness, sn_xpbd_of(s)->hinge_lambda, NULL};
    hinge_tally done = sweep_hinges(&in, m->hinge_batched, m->hinge_count, sweep);
    s->statistics.skipped_hinges += done.skipped;
    s->statistics.clamped_hinges += done.clamped;
}

/* ---- the energy ----------------------------------------------------------------------------------------------------------- */

typedef struct hinges {
    const sn_point *points;
    const sn_index *index;  /* (4 x rows) */
    const double *angles;   /* (rows) */
    const double *softness; /* (rows) nullable */
    double k;
    sn_forces gradient;
} hinges;

/* Rows r .. r + lanes - 1. */
SN_INLINE void energy_batch(const hinges *in, sn_index r, int lanes, wide_total *energy) {
    const sn_index *index = in->index + 4 * (size_t)r;
    wide_point p[4];
    wide_vec3 g[4];
    wide_records forces[4];
    wide c, k = wide_splat(in->k);
    SN_UNROLL
    for (int i = 0; i < 4; i++) p[i] = wide_gather(in->points, index + i, 4, lanes);
    wide_mask good = hinge(p, wide_load(in->angles + r, lanes), &c, g);
    if (in->softness != NULL) k = k / wide_load(in->softness + r, lanes);
    wide force = k * c;
    wide_count_in(energy, r, wide_or_nothing(good, wide_splat(0.5) * force * c), lanes);
    if (in->gradient.values == NULL) return;
    SN_UNROLL
    for (int i = 0; i < 4; i++) {
        wide_vec3 f = wide_scale(g[i], force);
        forces[i] = wide_records_of(wide_or_nothing(good, f.x), wide_or_nothing(good, f.y), wide_or_nothing(good, f.z));
    }
    wide_add_forces(in->gradient, index, 4, forces, lanes);
}

SN_WIDE_KERNEL static double energy_of_rows(const hinges *in, sn_index end) {
    wide_total energy = {{0}};
    sn_index r = 0;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) energy_batch(in, r, WIDE_LANES, &energy);
    for (; r < end; r++) energy_batch(in, r, 1, &energy);
    return wide_sum(&energy);
}

static double energy_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                             sn_forces gradient) {
    (void)s, (void)kind;
    const hinges in = {points, m->hinges->point, m->hinge_angles, m->hinge_softness, k, gradient};
    return energy_of_rows(&in, m->hinge_count);
}

/* ---- errors --------------------------------------------------------------------------------------------------------------- */

/* Rows r .. r + lanes - 1. */
SN_INLINE void error_batch(const hinges *in, sn_index r, int lanes, double *error) {
    wide_point p[4];
    wide_vec3 g[4];
    wide c;
    SN_UNROLL
    for (int i = 0; i < 4; i++) p[i] = wide_gather(in->points, in->index + 4 * (size_t)r + i, 4, lanes);
    wide_mask good = hinge(p, wide_load(in->angles + r, lanes), &c, g);
    wide_store(error, wide_select(good, wide_abs(c), wide_splat(NAN)), lanes);
}

SN_WIDE_KERNEL static void errors_of_rows(const hinges *in, sn_index begin, sn_index end, double *errors) {
    sn_index r = begin;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) error_batch(in, r, WIDE_LANES, errors + (r - begin));
    for (; r < end; r++) error_batch(in, r, 1, errors + (r - begin));
}

static void errors_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                           double *errors) {
    (void)kind;
    const hinges in = {.points = s->points, .index = m->hinges->point, .angles = m->hinge_angles};
    errors_of_rows(&in, begin, end, errors);
}

/* ---- at another shape -------------------------------------------------------------------------------------------------------- */

/* The gradients of sn_hinge_constraint, bit for bit, without its angle: the matrices need none. */
static bool hinge_gradients(const sn_vec3 p[4], sn_vec3 gradient[4]) {
    sn_vec3 e = sn_sub(p[1], p[0]), ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
    sn_vec3 n1 = sn_cross(ac, bc), n2 = sn_cross(bd, ad);
    double e2 = sn_norm2(e), q1 = sn_norm2(n1), q2 = sn_norm2(n2), least = SN_HINGE_GUARD * e2 * e2, length = sqrt(e2);
    if (e2 < SN_EDGE_GUARD || !(q1 > least && q2 > least) || !isfinite(q1) || !isfinite(q2)) return false;
    sn_vec3 unit = sn_scale(e, 1.0 / length), m1 = sn_scale(n1, 1.0 / q1), m2 = sn_scale(n2, 1.0 / q2);
    gradient[0] = sn_add(sn_scale(m1, sn_dot(bc, unit)), sn_scale(m2, sn_dot(bd, unit)));
    gradient[1] = sn_add(sn_scale(m1, -sn_dot(ac, unit)), sn_scale(m2, -sn_dot(ad, unit)));
    gradient[2] = sn_scale(m1, -length);
    gradient[3] = sn_scale(m2, -length);
    return true;
}

/* K of a hinge, by which k_b K KT bounds its Hessian on each axis (numerics.md 2): the rows were built from hinges that have them.
 *   K_c = |e|/|n1|, K_d = |e|/|n2|, K_a = -(b-c).e/|n1| - (b-d).e/|n2|, K_b = (a-c).e/|n1| + (a-d).e/|n2|   (e a unit vector here) */
static void hinge_weights(const sn_vec3 p[4], double weight[4]) {
    sn_vec3 e = sn_sub(p[1], p[0]), ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
    double length = sn_norm(e), n1 = sn_norm(sn_cross(ac, bc)), n2 = sn_norm(sn_cross(bd, ad));
    sn_vec3 unit = sn_scale(e, 1.0 / length);
    weight[0] = -sn_dot(bc, unit) / n1 - sn_dot(bd, unit) / n2;
    weight[1] = sn_dot(ac, unit) / n1 + sn_dot(ad, unit) / n2;
    weight[2] = length / n1;
    weight[3] = length / n2;
}

static bool linearise(const sn_model_muscle *m, sn_row_kind kind, const sn_vec3 *at, sn_rest_visit visit, void *user) {
    (void)kind;
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_rest_row row = {.count = 4, .point = m->hinges[r].point, .scale = m->source->stiffness_dihedral};
        sn_vec3 p[4];
        for (int i = 0; i < 4; i++) p[i] = at[row.point[i]];
        if (!hinge_gradients(p, row.gradient)) continue;
        hinge_weights(p, row.weight);
        if (m->hinge_softness != NULL) row.scale /= m->hinge_softness[r];
        if (!visit(user, &row)) return false;
    }
    return true;
}

/* ---- the table ----------------------------------------------------------------------------------------------------------------- */

static double factor_of(const sn_scene_muscle *source) { return source->stiffness_dihedral; }

static sn_left_out reason_of(const sn_build *build) {
    return sn_has_stiffness(build->source, build->source->stiffness_dihedral) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

static sn_index count_rows(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return m->hinge_count;
}

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    (void)kind;
    return m->hinges[row].point;
}

/* Rest angle, factor on the softness, lambda. */
static size_t bytes_of_row(const sn_model_muscle *m) {
    size_t numbers = (m->hinge_softness != NULL ? 2U : 1U) + (m->quasi_newton ? 0U : 1U);
    return sizeof(sn_hinge_row) + numbers * sizeof(double);
}

const sn_row_ops sn_rows_dihedral = {.info = {"dihedral", "error of dihedral angles, rad", "no angle", 4, .inside = false},
                                     .guarded = true,
                                     .crushes = true,
                                     .reason = reason_of,
                                     .factor = factor_of,
                                     .build = build_hinges,
                                     .count = count_rows,
                                     .points = points_of,
                                     .bytes = bytes_of_row,
                                     .sweep = sweep_kind,
                                     .sweep_single = sn_single_hinge_sweep,
                                     .energy = energy_of_kind,
                                     .linearise = linearise,
                                     .errors = errors_of_kind};
