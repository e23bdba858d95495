/*
 * energy.c -- the energy of one implicit Euler step and its gradient, over the same rows that `xpbd` projects.   numerics.md 2, 9
 *
 *   Phi(x) = 1/2 |x - y|^2_M / h^2 + sum_distances k/2 C^2 + sum_hinges k_b/2 C^2 + k_V/2 (V - goal)^2 + sum_areas B(J)
 *            + sum_membranes (membrane.c)
 *   B(J) = -k A0 (J - 1)^2 ln J for J < 1, J = area / A0: the area rows as an energy, since springs do not resist a triangle's loss of
 *   area. Triangles that the substep found collapsed have no barrier: it would hold them on the wrong side of a fold.
 */
#include "qn.h"
#include "wide_log.h"

/* Below this share of its rest area a triangle's barrier goes on as a straight line: finite, and continuous with its slope. */
static const double BARRIER_LINEAR = 1e-3;

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

/* ---- areas ---------------------------------------------------------------------------------------------------------------- */

/* B(J) and dB/dJ over k A0, for J < 1. */
SN_INLINE wide barrier(wide j, wide *slope) {
    wide least = wide_splat(BARRIER_LINEAR), at = wide_select(wide_less(least, j), j, least);
    wide gap = at - wide_splat(1.0), ln = wide_log(at);
    *slope = -(wide_splat(2.0) * gap * ln + gap * gap / at);
    return *slope * (j - at) - gap * gap * ln;
}

typedef struct barriers {
    const sn_point *points;
    const sn_index *index; /* (3 x rows) */
    const double *scales;  /* (rows) */
    const bool *guarded;   /* (rows) */
    double k;
    sn_forces gradient;
} barriers;

/* Rows r .. r + lanes - 1, which may share points. */
SN_INLINE void area_batch(const barriers *in, sn_index r, int lanes, wide_total *energy) {
    const sn_index *index = in->index + 3 * (size_t)r;
    wide_point p[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_gather(in->points, index + i, 3, lanes);
    wide_vec3 d1 = wide_between(p[1], p[0]), d2 = wide_between(p[2], p[0]), n = wide_cross(d1, d2);
    wide scale = wide_load(in->scales + r, lanes), size = wide_sqrt(wide_dot(n, n)), j = size * scale, slope;
    wide_mask small = ~wide_less(wide_splat(1.0), j); /* or not a number */
    if (!wide_any(small)) return;
    small &= wide_flags(in->guarded + r, lanes);
    wide half = wide_splat(0.5 * in->k), height = barrier(j, &slope);
    wide_count_in(energy, r, wide_or_nothing(small, half / scale * height), lanes);
    small &= wide_less(wide_splat(SN_AREA_GUARD), j * j);
    wide push = half * slope / size; /* k A0 dB/dJ dJ/d|n| / |n| */
    wide_vec3 g1 = wide_scale(wide_cross(d2, n), push), g2 = wide_scale(wide_cross(n, d1), push);
    const wide_records forces[3] = {
        wide_records_of(wide_or_nothing(small, -(g1.x + g2.x)), wide_or_nothing(small, -(g1.y + g2.y)),
                        wide_or_nothing(small, -(g1.z + g2.z))),
        wide_records_of(wide_or_nothing(small, g1.x), wide_or_nothing(small, g1.y), wide_or_nothing(small, g1.z)),
        wide_records_of(wide_or_nothing(small, g2.x), wide_or_nothing(small, g2.y), wide_or_nothing(small, g2.z)),
    };
    wide_add_forces(in->gradient, index, 3, forces, lanes);
}

SN_WIDE_KERNEL static double energy_of_areas(const barriers *in, sn_index end) {
    wide_total energy = {{0}};
    sn_index r = 0;
    for (; r + WIDE_LANES <= end; r += WIDE_LANES) area_batch(in, r, WIDE_LANES, &energy);
    for (; r < end; r++) area_batch(in, r, 1, &energy);
    return wide_sum(&energy);
}

static double areas(const sn_objective *o, const sn_point *points, sn_forces gradient) {
    const sn_model_muscle *m = o->model;
    double k = sn_row_stiffness(m, o->state, SN_ROWS_AREA);
    if (!(k > 0.0) || m->area_count == 0 || m->membrane_count > 0) return 0.0; /* a membrane has a barrier of its own */
    const barriers in = {points, m->areas->point, m->area_scales, o->state->guarded, k, gradient};
    return energy_of_areas(&in, m->area_count);
}

/* ---- all of it ------------------------------------------------------------------------------------------------------------ */

/* Of one kind of rows, at the points of the state; added to the forces. */
static double energy_of(const sn_objective *o, sn_muscle_state *at, sn_row_kind kind, sn_forces forces) {
    const sn_model_muscle *m = o->model;
    double k = sn_row_stiffness(m, at, kind);
    switch (kind) {
    case SN_ROWS_DIHEDRAL:
        return sn_hinge_energy(m, at, k, forces);
    case SN_ROWS_AREA:
        return areas(o, at->points, forces);
    case SN_ROWS_MEMBRANE:
        return sn_membrane_energy(m, at, k, forces);
    case SN_ROWS_VOLUME:
        return m->keeps_volume ? sn_volume_energy(m, at, k, forces) : 0.0;
    default:
        return sn_distance_energy(m, at, kind, k, forces);
    }
}

double sn_rows_evaluate(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind) {
    const sn_objective objective = {.model = m, .state = s};
    return energy_of(&objective, s, kind, (sn_forces){&s->qn->forces->x, 4});
}

double sn_objective_evaluate(const sn_objective *objective, sn_point *points, sn_vec3 *gradient) {
    const sn_model_muscle *m = objective->model;
    sn_muscle_state at = *objective->state; /* the same inputs at other points */
    at.points = points;
    const sn_forces forces = {&at.qn->forces->x, 4};
    const free_points free_ones = {points, at.target, 1.0 / (objective->h * objective->h), at.qn->forces};
    double energy = inertia(&free_ones, m->point_count);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) energy += energy_of(objective, &at, (sn_row_kind)kind, forces);
    for (sn_index i = 0; i < m->point_count; i++) gradient[i] = points[i].w == 0.0 ? sn_v3(0, 0, 0) : sn_point_position(&at.qn->forces[i]);
    return energy;
}
