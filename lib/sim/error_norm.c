/*
 * error_norm.c -- how far two runs of a scene are apart.   numerics.md 4
 */
#include "sinew/error_time.h"

#include <stdlib.h>

sn_status sn_yardstick_create(const sn_model *model, sn_yardstick *out, sn_error *error) {
    size_t points = 0;
    for (sn_index i = 0; i < model->muscle_count; i++) points += (size_t)model->muscles[i].point_count;
    if (points > SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "the scene has more points than can be counted");
    *out = (sn_yardstick){.muscle_count = model->muscle_count,
                          .point_count = (sn_index)points,
                          .start = SN_NEW(sn_index, (size_t)model->muscle_count + 1),
                          .mass = SN_NEW(double, points),
                          .diagonal = SN_NEW(double, model->muscle_count)};
    if (out->start == NULL || out->mass == NULL || out->diagonal == NULL) {
        sn_yardstick_free(out);
        return sn_fail_memory(error, "the comparison");
    }
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
        double *mass = out->mass + out->start[i];
        for (sn_index k = 0; k < m->point_count; k++) mass[k] = m->inverse_mass[k] > 0.0 ? 1.0 / m->inverse_mass[k] : 0.0;
        out->diagonal[i] = m->diagonal;
        out->start[i + 1] = out->start[i] + m->point_count;
    }
    return SN_OK;
}

void sn_yardstick_free(sn_yardstick *yardstick) {
    free(yardstick->start);
    free(yardstick->mass);
    free(yardstick->diagonal);
    *yardstick = (sn_yardstick){0};
}

void sn_track_free(sn_track *track) {
    free(track->positions);
    *track = (sn_track){0};
}

/* Sums of mass and of mass times squared distance over L; the greatest square and the muscle's point that has it. */
typedef struct sums {
    double mass, square, most;
    sn_index point;
} sums;

static sums add_up(const sn_yardstick *yardstick, sn_index muscle, sn_index moment_count, const sn_vec3 *a, const sn_vec3 *b) {
    sums sum = {.point = SN_NONE};
    double scale = 1.0 / (yardstick->diagonal[muscle] * yardstick->diagonal[muscle]);
    for (sn_index moment = 0; moment < moment_count; moment++) {
        size_t at = (size_t)moment * (size_t)yardstick->point_count;
        for (sn_index i = yardstick->start[muscle]; i < yardstick->start[muscle + 1]; i++) {
            if (yardstick->mass[i] == 0.0) continue;
            double square = scale * sn_norm2(sn_sub(a[at + (size_t)i], b[at + (size_t)i]));
            sum.mass += yardstick->mass[i];
            sum.square += yardstick->mass[i] * square;
            if (square <= sum.most || isnan(sum.most)) continue; /* NaN stays */
            sum.most = square;
            sum.point = i - yardstick->start[muscle];
        }
    }
    return sum;
}

static double root_mean(sums sum) { return sum.mass > 0.0 ? sqrt(sum.square / sum.mass) : 0.0; }

sn_difference sn_difference_between(const sn_yardstick *yardstick, sn_index moment_count, const sn_vec3 *a, const sn_vec3 *b,
                                    double *muscles) {
    sn_difference difference = {.muscle = SN_NONE, .point = SN_NONE};
    sums all = {0};
    for (sn_index i = 0; i < yardstick->muscle_count; i++) {
        sums sum = add_up(yardstick, i, moment_count, a, b);
        double rms = root_mean(sum), most = sqrt(sum.most);
        if (!(rms <= difference.worst)) difference.worst = isnan(difference.worst) ? NAN : rms;
        if (!(most <= difference.most) && !isnan(difference.most)) {
            difference.most = most;
            difference.muscle = i, difference.point = sum.point;
        }
        if (muscles != NULL) muscles[i] = rms;
        all.mass += sum.mass;
        all.square += sum.square;
    }
    difference.scene = root_mean(all);
    return difference;
}
