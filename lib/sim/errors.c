/*
 * errors.c -- the error of every row by itself, for pictures and tests: what the statistics sum up.   numerics.md 4
 */
#include "rows.h"

static sn_index row_count(const sn_model_muscle *m, sn_row_kind kind) {
    switch (kind) {
    case SN_ROWS_DIHEDRAL:
        return m->hinge_count;
    case SN_ROWS_AREA:
        return m->area_count;
    case SN_ROWS_MEMBRANE:
        return m->membrane_count;
    case SN_ROWS_VOLUME:
        return m->keeps_volume ? 1 : 0;
    default:
        return kind < SN_DISTANCE_KINDS ? m->distance_start[kind + 1] - m->distance_start[kind] : 0;
    }
}

sn_index sn_row_count(const sn_model *model, sn_index muscle, sn_row_kind kind) { return row_count(&model->muscles[muscle], kind); }

static int copy_points(int count, const sn_index *from, sn_index *to) {
    for (int i = 0; i < count; i++) to[i] = from[i];
    return count;
}

int sn_row_points(const sn_model *model, sn_index muscle, sn_row_kind kind, sn_index row, sn_index points[4]) {
    const sn_model_muscle *m = &model->muscles[muscle];
    if (kind < SN_DISTANCE_KINDS) return copy_points(2, m->distances[m->distance_start[kind] + row].point, points);
    if (kind == SN_ROWS_DIHEDRAL) return copy_points(4, m->hinges[row].point, points);
    if (kind == SN_ROWS_AREA) return copy_points(3, m->areas[row].point, points);
    if (kind == SN_ROWS_MEMBRANE) return copy_points(3, m->membrane_points[row].point, points);
    return 0;
}

static double row_error(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index row) {
    if (kind < SN_DISTANCE_KINDS) return sn_distance_error(m, s, m->distance_start[kind] + row);
    if (kind == SN_ROWS_DIHEDRAL) return sn_hinge_error(m, s, row);
    if (kind == SN_ROWS_AREA) return sn_area_error(m, s, row);
    if (kind == SN_ROWS_MEMBRANE) return sn_membrane_error(m, s, row);
    return fabs(sn_volume_ratio(m, s) - s->volume_goal);
}

sn_residual sn_rows_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind) {
    sn_residual residual = {.worst = SN_NONE};
    sn_index count = row_count(m, kind);
    double sum = 0.0;
    for (sn_index r = 0; r < count; r++) {
        double c = row_error(m, s, kind, r);
        if (kind == SN_ROWS_DIHEDRAL && isnan(c)) continue; /* it has no angle now */
        sum += c * c;
        if (residual.worst == SN_NONE || c > residual.max) residual.max = c, residual.worst = r;
    }
    if (count > 0) residual.rms = sqrt(sum / count);
    return residual;
}

void sn_row_errors(const sn_model *model, const sn_state *state, sn_index muscle, sn_row_kind kind, double *errors) {
    sn_index count = sn_row_count(model, muscle, kind);
    for (sn_index r = 0; r < count; r++) errors[r] = row_error(&model->muscles[muscle], &state->muscles[muscle], kind, r);
}

void sn_volume_moves(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *gradients, double *moves) {
    const sn_model_muscle *m = &model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, gradients), sum = 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++) sum += s->points[i].w * sn_norm2(gradients[i]);
    double c = m->keeps_volume ? fabs(volume - s->volume_goal * m->rest_volume) : 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++)
        moves[i] = sum > 0.0 ? s->points[i].w * sn_norm(gradients[i]) * c / (sum * m->mean_edge) : 0.0;
}
