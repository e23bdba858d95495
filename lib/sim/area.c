/*
 * area.c -- no triangle shrinks to nothing: a unilateral row per triangle.   numerics.md 9
 *
 * J = |n| / (2 A0) with n = d1 x d2, d1 = x1 - x0, d2 = x2 - x0. C = J - least, projected only where C < 0, and then rigidly:
 * springs do not resist the loss of area, and below a triangle's collapse nothing has a direction any more.
 *   g1 = d2 x u / (2 A0),  g2 = u x d1 / (2 A0),  g0 = -g1 - g2,  u = n / |n|
 */
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
    sn_status status = sn_batch_order(n, 3, m->areas->point, m->vertex_count, order, &m->area_batched, error);
    if (status == SN_OK) status = sn_batch_sort(m->areas, n, sizeof *m->areas, order, error);
    if (status == SN_OK) status = sn_batch_sort(m->area_scales, n, sizeof *m->area_scales, order, error);
    free(order);
    if (status != SN_OK) return status;
    if ((m->area_pairs = SN_NEW(bool, m->area_batched / 4)) == NULL) return sn_fail_memory(error, "area rows");
    sn_batch_pair(m->area_batched, 3, m->areas->point, m->area_pairs);
    return SN_OK;
}

sn_status sn_area_build(const sn_build *build, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[SN_ROWS_AREA];
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

void sn_area_sweep(const sn_model_muscle *m, sn_muscle_state *s) {
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

void sn_area_errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_index begin, sn_index end, double *errors) {
    for (sn_index r = begin; r < end; r++) {
        sn_vec3 x[3];
        for (int i = 0; i < 3; i++) x[i] = sn_point_position(&s->points[m->areas[r].point[i]]);
        double ratio = sn_norm(sn_cross(sn_sub(x[1], x[0]), sn_sub(x[2], x[0]))) * m->area_scales[r];
        *errors++ = fmax(m->source->least_area - ratio, 0.0);
    }
}
