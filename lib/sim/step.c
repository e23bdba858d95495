/*
 * step.c -- one frame, substep by substep, muscle by muscle: back end `xpbd`.   [R18] alg. 1, methods.md 8.7, numerics.md 2
 *
 * Substep: inputs; v <- (v + h g) e^(-c h), x <- x + h v; attached vertices to their bones; per iteration every group of rows in order,
 * volume last; v <- (x - x_before) / h. Lambda starts at 0 in each substep (never in each iteration).
 */
#include "rows.h"

/* What the substeps of one frame (or of the pre-roll) share; the muscles only read it. */
typedef struct run {
    const sn_model *model;
    sn_state *state;
    double begin;             /* frame number, as a time in frames, at which the first substep starts */
    bool frozen;              /* time stands still: inputs and poses stay those of `begin` */
    sn_index substep, end;    /* which to do now */
    sn_index last_iterations; /* iterations of substep end - 1; 0 = all */
    bool measure;             /* statistics after the last one */
} run;

static double substep_time(const run *r, sn_index substep) {
    const sn_scene *scene = r->model->scene;
    if (r->frozen) return r->begin / scene->rate;
    return (r->begin + (substep + 1) / (double)scene->solver.substeps) / scene->rate;
}

static const sn_rigid *substep_poses(const run *r, sn_index substep) {
    size_t slot = r->frozen ? 0 : (size_t)substep;
    return r->state->poses + slot * (size_t)r->model->scene->motion.joint_count;
}

/* Where each point would be without constraints. Damping is a rate: exact for any h. */
static void predict(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 gravity, double h) {
    double keep = exp(-m->source->damping * h);
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_point *p = &s->points[i];
        s->previous[i] = sn_point_position(p);
        if (p->w == 0.0) continue;
        sn_vec3 v = s->velocities[i] = sn_scale(sn_add_scaled(s->velocities[i], gravity, h), keep);
        p->x += h * v.x, p->y += h * v.y, p->z += h * v.z;
    }
}

static void project(const sn_model_muscle *m, sn_muscle_state *s, double h, sn_index iterations) {
    double compliance[SN_ROW_KINDS];
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) compliance[kind] = sn_row_compliance(m, s, (sn_row_kind)kind, h);
    for (sn_index i = 0; i < iterations; i++) {
        bool first = i == 0;
        for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++)
            if (compliance[kind] >= 0.0) sn_distance_sweep(m, s, (sn_row_kind)kind, compliance[kind], first);
        if (compliance[SN_ROWS_DIHEDRAL] >= 0.0) sn_hinge_sweep(m, s, compliance[SN_ROWS_DIHEDRAL], first);
        if (m->keeps_volume && compliance[SN_ROWS_VOLUME] >= 0.0) sn_volume_sweep(m, s, compliance[SN_ROWS_VOLUME], first);
    }
}

static void update_velocities(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    for (sn_index i = 0; i < m->point_count; i++)
        s->velocities[i] = sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), 1.0 / h);
}

static void do_substep(const run *r, sn_index muscle, sn_index substep) {
    const sn_model_muscle *m = &r->model->muscles[muscle];
    sn_muscle_state *s = &r->state->muscles[muscle];
    double h = r->model->substep_duration;
    bool partial = r->last_iterations > 0 && substep == r->end - 1;
    sn_index iterations = partial && r->last_iterations < m->iterations ? r->last_iterations : m->iterations;
    sn_inputs_update(m, s, substep_time(r, substep));
    predict(m, s, r->model->scene->gravity, h);
    sn_kinematics_place(m, s, substep_poses(r, substep));
    project(m, s, h, iterations);
    update_velocities(m, s, h);
}

static void do_muscles(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const run *r = user;
    (void)chunk;
    for (sn_index muscle = begin; muscle < end; muscle++) {
        for (sn_index substep = r->substep; substep < r->end; substep++) do_substep(r, muscle, substep);
        if (r->measure) sn_statistics_measure(&r->model->muscles[muscle], &r->state->muscles[muscle]);
    }
}

/* ---- frames --------------------------------------------------------------------------------------------------------------- */

static void prepare_poses(const run *r) {
    const sn_scene *scene = r->model->scene;
    sn_index slots = r->frozen ? 1 : scene->solver.substeps;
    for (sn_index i = 0; i < slots; i++) sn_motion_poses(&scene->motion, substep_time(r, i), (sn_rigid *)substep_poses(r, i));
}

static void clear_counters(sn_state *state, sn_index muscle_count) {
    for (sn_index i = 0; i < muscle_count; i++) {
        sn_statistics *statistics = &state->muscles[i].statistics;
        statistics->skipped_edges = statistics->skipped_hinges = statistics->clamped_hinges = 0;
    }
}

/* One record per muscle for the substep just done; true = stop. */
static bool trace_substep(const run *r, sn_trace *trace) {
    for (sn_index i = 0; i < r->model->muscle_count; i++) {
        const sn_statistics *st = &r->state->muscles[i].statistics;
        if (SN_TRACE(
                trace, "substep", sn_trace_number("frame", r->state->frame), sn_trace_number("substep", r->end),
                sn_trace_text("muscle", r->model->muscles[i].source->name), sn_trace_number("activation", st->activation),
                sn_trace_number("volume_error", st->volume_error), sn_trace_number("internal_rms", st->residuals[SN_ROWS_INTERNAL].rms),
                sn_trace_number("radial_rms", st->residuals[SN_ROWS_RADIAL].rms),
                sn_trace_number("mesh_rms", st->residuals[SN_ROWS_MESH].rms), sn_trace_number("mesh_max", st->residuals[SN_ROWS_MESH].max),
                sn_trace_number("dihedral_rms", st->residuals[SN_ROWS_DIHEDRAL].rms),
                sn_trace_number("dihedral_max", st->residuals[SN_ROWS_DIHEDRAL].max),
                sn_trace_number("smallest_triangle", st->smallest_triangle), sn_trace_number("kinetic_energy", st->kinetic_energy),
                sn_trace_number("nan", st->nan_points)))
            return true;
    }
    return false;
}

/* Do `substeps` substeps: all in one go, or one after the other where somebody watches. */
static sn_status do_run(run *r, sn_index substeps, const sn_step_options *options) {
    sn_pool *pool = options != NULL ? options->pool : NULL;
    sn_trace *trace = options != NULL ? options->trace : NULL;
    bool watched = trace != NULL && (trace->receive != NULL || trace->stop_after >= 0);
    if (sn_trace_stopped(trace)) return SN_STOPPED;
    prepare_poses(r);
    clear_counters(r->state, r->model->muscle_count);
    for (sn_index done = 0; done < substeps; done = r->end) {
        r->substep = done;
        r->end = watched ? done + 1 : substeps;
        r->measure = watched || r->end == substeps;
        sn_index keep = r->last_iterations;
        if (r->end < substeps) r->last_iterations = 0;
        sn_parallel_for(pool, r->model->muscle_count, 1, do_muscles, r);
        r->last_iterations = keep;
        if (watched && trace_substep(r, trace)) return SN_STOPPED;
    }
    return SN_OK;
}

sn_status sn_settle(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    const sn_scene *scene = model->scene;
    double substeps = ceil(scene->preroll / model->substep_duration - 1e-9);
    if (!(substeps >= 1.0)) return SN_OK;
    if (substeps > SN_INDEX_MAX)
        return sn_fail(error, SN_ERROR_USAGE, "a pre-roll of %g s is more than %d substeps; shorten it", scene->preroll, (int)SN_INDEX_MAX);
    run r = {.model = model, .state = state, .begin = scene->first_frame, .frozen = true};
    return do_run(&r, (sn_index)substeps, options);
}

sn_status sn_step(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    sn_index substeps = model->scene->solver.substeps;
    sn_index stop = options != NULL ? options->stop_substep : 0;
    if (stop < 0 || stop > substeps)
        return sn_fail(error, SN_ERROR_USAGE, "cannot stop after substep %d: a frame has %d", (int)stop, (int)substeps);
    run r = {.model = model, .state = state, .begin = state->frame};
    r.last_iterations = stop > 0 ? options->stop_iteration : 0;
    state->frame++;
    sn_status status = do_run(&r, stop > 0 ? stop : substeps, options);
    return status == SN_OK && stop > 0 && (stop < substeps || r.last_iterations > 0) ? SN_STOPPED : status;
}
