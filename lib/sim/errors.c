/*
 * errors.c -- the error of every row by itself, for pictures and tests: what the statistics sum up.   numerics.md 4
 */
#include "rows.h"

sn_index sn_row_count(const sn_model *model, sn_index muscle, sn_row_kind kind) {
    return sn_row_ops_of(kind)->count(&model->muscles[muscle], kind);
}

bool sn_model_tied(const sn_model *model) {
    bool tied = false;
    for (sn_index i = 0; i < model->muscle_count; i++) tied = tied || sn_row_count(model, i, SN_ROWS_EXTERNAL) > 0;
    return tied;
}

int sn_row_points(const sn_model *model, sn_index muscle, sn_row_kind kind, sn_index row, sn_index points[4]) {
    const sn_row_ops *ops = sn_row_ops_of(kind);
    int count = ops->info.points;
    for (int i = 0; i < count; i++) points[i] = ops->points(&model->muscles[muscle], kind, row)[i];
    while (count > 1 && points[count - 1] == points[0]) count--; /* a row of contact that is a vertex */
    return count;
}

static void count_error(sn_residual *residual, sn_index row, double error) {
    if (residual->worst == SN_NONE || error > residual->max) residual->max = error, residual->worst = row;
}

sn_row_kind sn_stretch_kind(const sn_model_muscle *m) {
    int found = SN_NONE;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->longest != NULL && (found == SN_NONE || ops->count(m, (sn_row_kind)kind) > 0)) found = kind;
    }
    return (sn_row_kind)found;
}

sn_residual sn_rows_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_longest_edge *longest) {
    enum { BLOCK = 256 };
    const sn_row_ops *ops = sn_row_ops_of(kind);
    double errors[BLOCK], sum = 0.0;
    sn_residual residual = {.worst = SN_NONE};
    sn_index count = ops->count(m, kind);
    for (sn_index begin = 0; begin < count; begin += BLOCK) {
        sn_index rows = count - begin < BLOCK ? count - begin : BLOCK;
        ops->errors(m, s, kind, begin, begin + rows, errors);
        if (longest != NULL) ops->longest(m, s, kind, &(sn_row_span){begin, begin + rows, errors}, longest);
        for (sn_index i = 0; i < rows; i++) {
            if (ops->guarded && isnan(errors[i])) continue; /* it has no value now */
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
    sn_index count = sn_row_count(model, muscle, kind);
    if (count > 0) sn_row_ops_of(kind)->errors(&model->muscles[muscle], &state->muscles[muscle], kind, 0, count, errors);
}

void sn_volume_moves(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *gradients, double *moves) {
    const sn_model_muscle *m = &model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, gradients), sum = 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++) sum += s->points[i].w * sn_norm2(gradients[i]);
    double c = m->keeps_volume ? fabs(volume - s->inputs->volume_goal * m->rest_volume) : 0.0;
    for (sn_index i = 0; i < m->vertex_count; i++)
        moves[i] = sum > 0.0 ? s->points[i].w * sn_norm(gradients[i]) * c / (sum * m->mean_edge) : 0.0;
}
