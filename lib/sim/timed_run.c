/*
 * timed_run.c -- one run of a scene, timed, with its points at some moments.
 */
#include "rows.h"
#include "sinew/error_time.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

static double clock_seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct timed_run {
    const sn_scene *scene;
    const sn_run_request *request;
    sn_run_result *result;
    sn_model *model;
    sn_state *state;
    double cpu, wall; /* s of stepping so far */
} timed_run;

static clockid_t processor_clock(const timed_run *r) {
    return r->request->pool == NULL ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID;
}

/* ---- before and after the steps ------------------------------------------------------------------------------------------------- */

static sn_status prepare(timed_run *r, sn_error *error) {
    double started = clock_seconds(CLOCK_MONOTONIC);
    sn_step_options options = {.pool = r->request->pool};
    sn_status status = sn_model_create(r->scene, &r->model, error);
    if (status == SN_OK) status = sn_state_create(r->model, &r->state, error);
    if (status == SN_OK) status = sn_settle(r->model, r->state, &options, error);
    r->result->setup = clock_seconds(CLOCK_MONOTONIC) - started;
    return status;
}

static sn_status make_room(timed_run *r, sn_error *error) {
    sn_run_result *out = r->result;
    size_t points = 0, moments = (size_t)r->request->moment_count;
    for (sn_index i = 0; i < r->model->muscle_count; i++) points += (size_t)r->model->muscles[i].point_count;
    if (points > SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "the scene has more points than can be counted");
    out->track.point_count = (sn_index)points;
    out->track.positions = points > 0 && moments > SIZE_MAX / points ? NULL : SN_NEW(sn_vec3, points * moments);
    out->moments = SN_NEW(sn_index, moments);
    out->cpu = SN_NEW(double, moments);
    out->wall = SN_NEW(double, moments);
    return out->track.positions != NULL && out->moments != NULL && out->cpu != NULL && out->wall != NULL
               ? SN_OK
               : sn_fail_memory(error, "the points of a run");
}

static void record(timed_run *r) {
    sn_track *track = &r->result->track;
    sn_vec3 *out = track->positions + (size_t)track->moment_count * (size_t)track->point_count;
    r->result->moments[track->moment_count] = r->result->frames;
    r->result->cpu[track->moment_count] = r->cpu;
    r->result->wall[track->moment_count++] = r->wall;
    for (sn_index i = 0; i < r->model->muscle_count; i++)
        for (sn_index k = 0; k < r->model->muscles[i].point_count; k++) *out++ = sn_point_position(&r->state->muscles[i].points[k]);
}

/* ---- frame after frame ------------------------------------------------------------------------------------------------------------ */

static void count_frame(timed_run *r) {
    sn_run_result *out = r->result;
    bool quasi_newton = r->scene->solver.method == SN_SOLVER_QN;
    out->frames++;
    for (sn_index i = 0; i < r->model->muscle_count; i++)
        out->strain = fmax(out->strain, sn_largest_strain(&r->model->muscles[i], &r->state->muscles[i]));
    for (sn_index i = 0; quasi_newton && i < r->model->muscle_count; i++) {
        const sn_statistics *s = &r->state->muscles[i].statistics;
        if (s->asleep) continue;
        out->iterations += s->iterations;
        out->rejected_steps += s->rejected_steps;
        out->refactorisations += s->refactorisations;
        out->restarts += s->restarts;
        out->unconverged += s->stop_reason == SN_STOP_ITERATIONS || s->stop_reason == SN_STOP_FAILED;
    }
}

static sn_status step_frame(timed_run *r, sn_error *error) {
    sn_step_options options = {.pool = r->request->pool};
    bool hold = r->state->frame == r->scene->last_frame;
    double wall = clock_seconds(CLOCK_MONOTONIC), cpu = clock_seconds(processor_clock(r));
    sn_status status = hold ? sn_hold(r->model, r->state, &options, error) : sn_step(r->model, r->state, &options, error);
    r->cpu += clock_seconds(processor_clock(r)) - cpu;
    r->wall += clock_seconds(CLOCK_MONOTONIC) - wall;
    count_frame(r);
    return status;
}

static bool is_finite(const timed_run *r) {
    for (sn_index i = 0; i < r->model->muscle_count; i++)
        if (r->state->muscles[i].statistics.nan_points > 0) return false;
    return true;
}

/* Would no point move by more than the request's share of its muscle's diagonal in a frame? */
static bool rests(const timed_run *r) {
    if (!(r->request->rest > 0.0) || r->result->frames <= r->scene->last_frame - r->scene->first_frame) return false;
    for (sn_index i = 0; i < r->model->muscle_count; i++) {
        const sn_model_muscle *m = &r->model->muscles[i];
        double most = r->request->rest * m->diagonal / r->model->frame_duration;
        for (sn_index k = 0; k < m->point_count; k++)
            if (!(sn_norm2(r->state->muscles[i].velocities[k]) <= most * most)) return false;
    }
    return true;
}

/* Up to the last moment, or until there is nothing more to be learnt; a run that has come to rest ends with a moment of its own. */
static sn_status run_frames(timed_run *r, sn_error *error) {
    const sn_run_request *q = r->request;
    const sn_track *track = &r->result->track;
    sn_status status = SN_OK;
    while (status == SN_OK) {
        bool rested = rests(r);
        if (rested || q->moments[track->moment_count] == r->result->frames) record(r);
        if (rested || track->moment_count == q->moment_count || !is_finite(r)) break;
        r->result->over_time = r->cpu > q->most_seconds;
        if (r->result->over_time) break;
        status = step_frame(r, error);
    }
    return status;
}

static void summarise(timed_run *r) {
    sn_run_result *out = r->result;
    out->residual = NAN;
    for (sn_index i = 0; i < r->model->muscle_count; i++) {
        const sn_statistics *s = &r->state->muscles[i].statistics;
        out->nan_points += s->nan_points;
        out->elastic_energy += s->elastic_energy;
        if (!(s->residual <= out->residual)) out->residual = s->residual;
    }
}

sn_status sn_run_timed(const sn_scene *scene, const sn_run_request *request, sn_run_result *out, sn_error *error) {
    *out = (sn_run_result){0};
    timed_run r = {.scene = scene, .request = request, .result = out};
    sn_status status = prepare(&r, error);
    if (status == SN_OK) status = make_room(&r, error);
    if (status == SN_OK) status = run_frames(&r, error);
    if (status == SN_OK) summarise(&r);
    if (r.model != NULL) sn_state_destroy(r.model, r.state);
    sn_model_destroy(r.model);
    if (status != SN_OK) sn_run_free(out);
    return status;
}

void sn_run_free(sn_run_result *result) {
    sn_track_free(&result->track);
    free(result->moments);
    free(result->cpu);
    free(result->wall);
    *result = (sn_run_result){0};
}
