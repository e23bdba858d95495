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

/* Of rows begin to end - 1 of a kind. */
static void errors_of(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end, double *errors) {
    switch (kind) {
    case SN_ROWS_DIHEDRAL:
        sn_hinge_errors(m, s, begin, end, errors);
        break;
    case SN_ROWS_AREA:
        sn_area_errors(m, s, begin, end, errors);
        break;
    case SN_ROWS_MEMBRANE:
        sn_membrane_errors(m, s, begin, end, errors);
        break;
    case SN_ROWS_VOLUME:
        if (begin < end) *errors = fabs(sn_volume_ratio(m, s) - s->volume_goal);
        break;
    default:
        sn_distance_errors(m, s, m->distance_start[kind] + begin, m->distance_start[kind] + end, errors);
    }
}

static void count_error(sn_residual *residual, sn_index row, double error) {
    if (residual->worst == SN_NONE || error > residual->max) residual->max = error, residual->worst = row;
}

sn_row_kind sn_stretch_kind(const sn_model_muscle *m) { return m->membrane_count > 0 ? SN_ROWS_MEMBRANE : SN_ROWS_MESH; }

static void look_for_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end,
                             const double *errors, sn_longest_edge *longest) {
    if (kind == SN_ROWS_MEMBRANE)
        sn_membrane_longest(m, s, begin, end, errors, longest);
    else
        sn_distance_longest(m, s, m->distance_start[kind] + begin, m->distance_start[kind] + end, errors, longest);
}

sn_residual sn_rows_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_longest_edge *longest) {
    enum { BLOCK = 256 };
    double errors[BLOCK], sum = 0.0;
    sn_residual residual = {.worst = SN_NONE};
    sn_index count = row_count(m, kind);
    for (sn_index begin = 0; begin < count; begin += BLOCK) {
        sn_index rows = count - begin < BLOCK ? count - begin : BLOCK;
        errors_of(m, s, kind, begin, begin + rows, errors);
        if (longest != NULL) look_for_longest(m, s, kind, begin, begin + rows, errors, longest);
        for (sn_index i = 0; i < rows; i++) {
            if (kind == SN_ROWS_DIHEDRAL && isnan(errors[i])) continue; /* it has no angle now */
            sum += errors[i] * errors[i];
            count_error(&residual, begin + i, errors[i]);
        }
    }
    if (count > 0) residual.rms = sqrt(sum / count);
    return residual;
}

double sn_largest_strain(const sn_model_muscle *m, const sn_muscle_state *s) {
    double most = 0.0;
    for (sn_index t = 0; t < m->triangle_count; t++) {
        for (int i = 0; i < 3; i++) {
            sn_index a = m->triangles[t].v[i], b = m->triangles[t].v[(i + 1) % 3];
            double rest = sn_distance(m->rest[a], m->rest[b]);
            double length = sn_distance(sn_point_position(&s->points[a]), sn_point_position(&s->points[b]));
            if (rest > 0.0) most = fmax(most, fabs(length / rest - 1.0));
        }
    }
    return most;
}

void sn_rest_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_longest_edge *longest) {
    for (sn_index t = 0; t < m->triangle_count; t++) {
        for (int i = 0; i < 3; i++) {
            sn_index a = m->triangles[t].v[i], b = m->triangles[t].v[(i + 1) % 3];
            double goal = fmax(sn_distance(m->rest[a], m->rest[b]), SN_LEAST_GOAL * m->mean_edge);
            double ratio = sn_distance(sn_point_position(&s->points[a]), sn_point_position(&s->points[b])) / goal;
            if (ratio > longest->ratio) *longest = (sn_longest_edge){ratio, {a, b}};
        }
    }
}

void sn_row_errors(const sn_model *model, const sn_state *state, sn_index muscle, sn_row_kind kind, double *errors) {
    errors_of(&model->muscles[muscle], &state->muscles[muscle], kind, 0, sn_row_count(model, muscle, kind), errors);
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
