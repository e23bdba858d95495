/*
 * area.c -- no triangle shrinks to nothing: a unilateral row per triangle.   numerics.md 9
 *
 * J = |n| / (2 A0) with n = d1 x d2, d1 = x1 - x0, d2 = x2 - x0. C = J - least, projected only where C < 0, and then rigidly:
 * springs do not resist the loss of area, and below a triangle's collapse nothing has a direction any more.
 *   g1 = d2 x u / (2 A0),  g2 = u x d1 / (2 A0),  g0 = -g1 - g2,  u = n / |n|
 *
 * Under `qn` the rows are a barrier, B(J) = -k A0 (J - 1)^2 ln J for J < 1. Triangles that the step found collapsed have none: it would
 * hold them on the wrong side of a fold.
 */
#include "area_kernel.h"
#include "rows.h"

#include <float.h>
#include <stdlib.h>

/* J and its gradients; false where the triangle has no plane (J^2 below the guard, or not finite). */
static inline bool area_ratio(const sn_vec3 p[3], double scale, double *ratio, sn_vec3 g[3]) {
    sn_vec3 d1 = sn_sub(p[1], p[0]), d2 = sn_sub(p[2], p[0]), n = sn_cross(d1, d2);
    double square = sn_norm2(n) * scale * scale;
    if (!(square > SN_AREA_GUARD && square <= DBL_MAX)) return false;
    *ratio = sqrt(square);
    sn_vec3 u = sn_scale(n, scale * scale / *ratio); /* unit normal times scale */
    g[1] = sn_cross(d2, u);
    g[2] = sn_cross(u, d1);
    g[0] = sn_neg(sn_add(g[1], g[2]));
    return true;
}

bool sn_area_constraint(const sn_vec3 p[3], double rest_area, double least, double *value, sn_vec3 gradients[3]) {
    if (!area_ratio(p, 0.5 / rest_area, value, gradients)) return false;
    *value -= least;
    return true;
}

static sn_status batch_areas(sn_model_muscle *m, sn_error *error) {
    sn_index n = m->area_count, *order = SN_NEW(sn_index, n);
    if (order == NULL) return sn_fail_memory(error, "area rows");
    sn_status status = sn_batch_order(&(sn_point_rows){n, 3, m->areas->point, m->vertex_count}, order, &m->area_batched, error);
    if (status == SN_OK) status = sn_batch_sort(m->areas, n, sizeof *m->areas, order, error);
    if (status == SN_OK) status = sn_batch_sort(m->area_scales, n, sizeof *m->area_scales, order, error);
    free(order);
    if (status != SN_OK) return status;
    if ((m->area_pairs = SN_NEW(bool, m->area_batched / 4)) == NULL) return sn_fail_memory(error, "area rows");
    sn_batch_pair(m->area_batched, 3, m->areas->point, m->area_pairs);
    return SN_OK;
}

static sn_status build_areas(const sn_build *build, sn_row_kind kind, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[kind];
    if (group->reason != SN_RUNS) return SN_OK;
    m->areas = SN_NEW(sn_area_row, m->triangle_count);
    m->area_scales = SN_NEW(double, m->triangle_count);
    if (m->areas == NULL || m->area_scales == NULL) return sn_fail_memory(error, "area rows");
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = m->triangles[t].v;
        if (!(m->rest_area[t] > 1e-12 * m->mean_edge * m->mean_edge)) {
            group->degenerate++;
        } else if (m->inverse_mass[v[0]] + m->inverse_mass[v[1]] + m->inverse_mass[v[2]] == 0.0) {
            group->kinematic++;
        } else {
            m->areas[m->area_count] = (sn_area_row){{v[0], v[1], v[2]}};
            m->area_scales[m->area_count++] = 0.5 / m->rest_area[t];
        }
    }
    group->rows = m->area_count;
    return m->single ? batch_areas(m, error) : SN_OK;
}

static inline void move(sn_point *point, sn_vec3 gradient, double change) {
    double scale = point->w * change;
    point->x += scale * gradient.x, point->y += scale * gradient.y, point->z += scale * gradient.z;
}

static void sweep_kind(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep) {
    (void)kind, (void)sweep;
    double least = m->source->least_area, square = least * least;
    for (sn_index r = 0; r < m->area_count; r++) {
        sn_point *p[3];
        sn_vec3 x[3], g[3];
        double scale = m->area_scales[r], ratio;
        for (int i = 0; i < 3; i++) x[i] = sn_point_position(p[i] = &s->points[m->areas[r].point[i]]);
        if (sn_norm2(sn_cross(sn_sub(x[1], x[0]), sn_sub(x[2], x[0]))) * scale * scale >= square) continue;
        if (!area_ratio(x, scale, &ratio, g)) {
            s->statistics.skipped_triangles++;
            continue;
        }
        double sum = 0.0;
        for (int i = 0; i < 3; i++) sum += p[i]->w * sn_norm2(g[i]);
        double change = (least - ratio) / sum;
        s->statistics.held_triangles++;
        for (int i = 0; i < 3; i++) move(p[i], g[i], change);
    }
}

static void errors_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                           double *errors) {
    (void)kind;
    for (sn_index r = begin; r < end; r++) {
        sn_vec3 x[3];
        for (int i = 0; i < 3; i++) x[i] = sn_point_position(&s->points[m->areas[r].point[i]]);
        double ratio = sn_norm(sn_cross(sn_sub(x[1], x[0]), sn_sub(x[2], x[0]))) * m->area_scales[r];
        *errors++ = fmax(m->source->least_area - ratio, 0.0);
    }
}

/* ---- the energy of back end `qn` --------------------------------------------------------------------------------------------- */

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

static double energy_of_kind(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                             sn_forces gradient) {
    (void)kind;
    bool membrane = m->own[SN_ROWS_MEMBRANE] != NULL; /* it has a barrier of its own */
    if (!(k > 0.0) || membrane) return 0.0;
    const barriers in = {points, m->areas->point, m->area_scales, s->inputs->guarded, k, gradient};
    return energy_of_areas(&in, m->area_count);
}

/* ---- the table ----------------------------------------------------------------------------------------------------------------- */

static sn_left_out reason_of(const sn_build *build) {
    if (!(build->source->least_area > 0.0)) return SN_OUT_SETTING;
    return sn_has_stiffness(build->source, 1.0) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

static sn_index count_rows(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return m->area_count;
}

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    (void)kind;
    return m->areas[row].point;
}

static size_t bytes_of_row(const sn_model_muscle *m) { return sizeof(sn_area_row) + sizeof(double) + (m->quasi_newton ? sizeof(bool) : 0); }

const sn_row_ops sn_rows_area = {.info = {"area", "area below the least, of the rest area", "no area", 3, .inside = false},
                                 .rigid = true,
                                 .reason = reason_of,
                                 .build = build_areas,
                                 .count = count_rows,
                                 .points = points_of,
                                 .bytes = bytes_of_row,
                                 .sweep = sweep_kind,
                                 .sweep_single = sn_single_area_sweep,
                                 .energy = energy_of_kind,
                                 .errors = errors_of_kind};
