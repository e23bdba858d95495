/*
 * reference.c -- what errors are measured against: converged runs of `qn`, extrapolated to h -> 0, and how sure that is.   numerics.md 4
 *
 * Implicit Euler's error is c h + O(h^2). With S substeps, R(S) = 2 x(S) - x(S/2) is then off by O(h^2), and R(S/2) by four times as much:
 * their distance is three times the error of R(S), an honest floor. That holds only where halving the step halves what is left, so it is
 * believed only where the last three rungs say so. XPBD would be no reference: iterated to convergence it differs from implicit Euler by
 * the square of a step's motion, since it adds up corrections along the gradients of its iterates.
 */
#include "sinew/error_time.h"

#include <stdlib.h>
#include <string.h>

sn_reference_params sn_reference_defaults(void) {
    return (sn_reference_params){
        .floor = 1e-5, .most_substeps = 64, .tolerance = 1e-9, .iterations = 2000, .rest = 1e-11, .most_held = 4000};
}

void sn_reference_free(sn_reference *reference) {
    for (sn_index i = 0; reference->rungs != NULL && i < reference->rung_count; i++) sn_track_free(&reference->rungs[i].track);
    free(reference->rungs);
    sn_track_free(&reference->track);
    *reference = (sn_reference){0};
}

/* ---- one rung --------------------------------------------------------------------------------------------------------------------- */

static void choose_solver(sn_scene *scene, const sn_reference_params *params, sn_index substeps) {
    sn_setting converged = {.method = SN_SOLVER_QN};
    sn_setting_apply(&converged, scene);
    scene->solver.substeps = substeps;
    scene->solver.iterations = params->iterations;
    scene->solver.tolerance = params->tolerance;
    scene->solver.preconditioner = SN_PRECONDITION_SCALAR; /* the one that converges on every muscle tried */
}

/* A run with so many substeps, appended to the rungs. */
static sn_status add_rung(sn_scene *scene, const sn_run_request *request, const sn_reference_params *params, sn_index substeps,
                          sn_reference *reference, sn_error *error) {
    sn_run_result run;
    sn_rung *rungs = sn_realloc(reference->rungs, (size_t)reference->rung_count + 1, sizeof *rungs);
    if (rungs == NULL) return sn_fail_memory(error, "the reference");
    reference->rungs = rungs;
    choose_solver(scene, params, substeps);
    sn_status status = sn_run_timed(scene, request, &run, error);
    if (status != SN_OK) return status;
    sn_index last = run.track.moment_count - 1;
    rungs[reference->rung_count++] = (sn_rung){.substeps = substeps,
                                               .track = run.track,
                                               .seconds = last >= 0 ? run.cpu[last] : 0.0,
                                               .unconverged = run.unconverged,
                                               .strain = run.strain,
                                               .step = NAN,
                                               .error = NAN};
    run.track = (sn_track){0};
    if (run.nan_points > 0)
        status = sn_fail(error, SN_ERROR_INPUT, "the reference (qn, %d substeps) is no longer finite after %d frames", (int)substeps,
                         (int)run.frames);
    sn_log(SN_LOG_INFO, "reference: %d substeps took %.3g s, %lld iterations", (int)substeps, rungs[reference->rung_count - 1].seconds,
           (long long)run.iterations);
    sn_run_free(&run);
    return status;
}

static double distance(const sn_yardstick *yardstick, const sn_track *a, const sn_track *b) {
    return sn_difference_between(yardstick, a->moment_count, a->positions, b->positions, NULL).worst;
}

/* ---- extrapolation ---------------------------------------------------------------------------------------------------------------- */

/* out = 2 fine - coarse. */
static sn_status extrapolate(const sn_track *coarse, const sn_track *fine, sn_track *out, sn_error *error) {
    size_t count = (size_t)fine->moment_count * (size_t)fine->point_count;
    sn_vec3 *positions = SN_NEW(sn_vec3, count);
    if (positions == NULL) return sn_fail_memory(error, "the reference");
    for (size_t i = 0; i < count; i++) positions[i] = sn_add(fine->positions[i], sn_sub(fine->positions[i], coarse->positions[i]));
    sn_track_free(out);
    *out = (sn_track){.moment_count = fine->moment_count, .point_count = fine->point_count, .positions = positions};
    return SN_OK;
}

/* The rungs whose substeps are 1, 2, 4, ... come first. */
static sn_index doubled_rungs(const sn_reference *reference) {
    sn_index n = 0;
    while (n < reference->rung_count && reference->rungs[n].substeps == (sn_index)1 << n) n++;
    return n;
}

/* Robust slope of log2 error over log2 h through the rungs that the reference was not made of, far above the floor. */
static void fit_order(sn_reference *reference, sn_index rung_count) {
    double x[32], y[32], intercept;
    sn_index n = 0;
    for (sn_index i = 0; i + 2 < rung_count && n < 32; i++) {
        const sn_rung *rung = &reference->rungs[i];
        if (rung->unconverged > 0 || !(rung->error >= SN_CLAIM_FLOORS * reference->floor)) continue;
        x[n] = -sn_log2((double)rung->substeps);
        y[n++] = sn_log2(rung->error);
    }
    reference->fitted_rungs = n;
    reference->fitted = NAN;
    if (!sn_fit_line_robust(n, x, y, &intercept, &reference->fitted)) reference->fitted = NAN;
}

/* Richardson's value and floor from the last three of n rungs; false: out of memory. */
static sn_status use_richardson(const sn_yardstick *yardstick, sn_reference *reference, sn_index n, sn_error *error) {
    const sn_rung *r = reference->rungs;
    sn_track twin = {0}, value = {0};
    sn_status status = extrapolate(&r[n - 2].track, &r[n - 1].track, &value, error);
    if (status == SN_OK) status = extrapolate(&r[n - 3].track, &r[n - 2].track, &twin, error);
    double floor = status == SN_OK ? distance(yardstick, &value, &twin) : INFINITY;
    reference->extrapolated = floor < reference->floor;
    if (reference->extrapolated) {
        sn_track_free(&reference->track);
        reference->track = value;
        reference->floor = floor;
        value = (sn_track){0};
    }
    sn_track_free(&value);
    sn_track_free(&twin);
    return status;
}

static sn_status copy_track(const sn_track *from, sn_track *to, sn_error *error) { return extrapolate(from, from, to, error); }

sn_status sn_reference_extrapolate(const sn_yardstick *yardstick, sn_reference *reference, sn_error *error) {
    sn_index n = doubled_rungs(reference);
    sn_rung *r = reference->rungs;
    for (sn_index i = 1; i < n; i++) r[i].step = distance(yardstick, &r[i].track, &r[i - 1].track);
    reference->extrapolated = false;
    reference->floor = n > 1 ? r[n - 1].step : INFINITY;
    reference->order = n > 2 ? sn_log2(r[n - 2].step / r[n - 1].step) : NAN;
    sn_status status = n > 0 ? copy_track(&r[n - 1].track, &reference->track, error) : SN_OK;
    bool first_order = reference->order >= SN_ORDER_LOW && reference->order <= SN_ORDER_HIGH;
    if (status == SN_OK && first_order) status = use_richardson(yardstick, reference, n, error);
    for (sn_index i = 0; status == SN_OK && i < reference->rung_count; i++)
        r[i].error = distance(yardstick, &r[i].track, &reference->track);
    fit_order(reference, n);
    return status;
}

sn_status sn_reference_motion(const sn_reference_task *task, sn_reference *out, sn_error *error) {
    const sn_reference_params *params = task->params;
    sn_status status = SN_OK;
    *out = (sn_reference){.floor = INFINITY, .order = NAN, .fitted = NAN};
    for (sn_index substeps = 1; status == SN_OK && substeps <= params->most_substeps; substeps *= 2) {
        status = add_rung(task->scene, task->request, params, substeps, out, error);
        if (status == SN_OK) status = sn_reference_extrapolate(task->yardstick, out, error);
        if (out->rung_count > 2 && out->floor <= params->floor) break;
    }
    if (status != SN_OK) sn_reference_free(out);
    return status;
}

/* ---- the equilibrium ---------------------------------------------------------------------------------------------------------------- */

sn_status sn_reference_rest(const sn_reference_task *task, sn_reference *out, sn_error *error) {
    sn_scene *scene = task->scene;
    const sn_reference_params *params = task->params;
    sn_index last = scene->last_frame - scene->first_frame + params->most_held;
    sn_run_request held = *task->request;
    held.moments = &last;
    held.moment_count = 1;
    held.rest = params->rest;
    *out = (sn_reference){.floor = INFINITY, .order = NAN, .fitted = NAN};
    sn_status status = add_rung(scene, &held, params, 1, out, error);
    if (status == SN_OK) status = add_rung(scene, &held, params, 2, out, error);
    if (status == SN_OK) status = copy_track(&out->rungs[1].track, &out->track, error);
    if (status == SN_OK)
        out->floor = out->rungs[1].step = out->rungs[0].error = distance(task->yardstick, &out->rungs[0].track, &out->track);
    if (status == SN_OK) out->rungs[1].error = 0.0;
    if (status != SN_OK) sn_reference_free(out);
    return status;
}

/* ---- converged solves of a setting's own steps --------------------------------------------------------------------------- */

sn_status sn_reference_solve(const sn_reference_task *task, sn_index substeps, sn_reference *reference, const sn_rung **out,
                             sn_error *error) {
    sn_status status = SN_OK;
    sn_index i = 0;
    while (i < reference->rung_count && reference->rungs[i].substeps != substeps) i++;
    if (i == reference->rung_count) status = add_rung(task->scene, task->request, task->params, substeps, reference, error);
    if (status != SN_OK) return status;
    sn_rung *rung = &reference->rungs[i];
    if (isnan(rung->error)) rung->error = distance(task->yardstick, &rung->track, &reference->track);
    *out = rung;
    return SN_OK;
}
