/*
 * step.c -- one frame, substep by substep, muscle by muscle; the back end does the rest.   [R18] alg. 1, methods.md 8.7
 *
 * Muscles run side by side, each through all substeps of the frame in one thread; where somebody watches, all of them through one
 * iteration after the other. Both give the same bits, and so does a run that stops anywhere and goes on.
 */
#include "rows.h"

#include <stdlib.h>

const sn_backend *sn_backend_of(const sn_scene *scene) {
    switch (scene->solver.method) {
    case SN_SOLVER_XPBD:
        return &sn_backend_xpbd;
    case SN_SOLVER_QN:
        return &sn_backend_qn;
    }
    return &sn_backend_xpbd;
}

/* How far into a frame: substeps done, and iterations of the next one. */
typedef struct moment {
    sn_index substep, iteration;
} moment;

static bool before(moment a, moment b) { return a.substep < b.substep || (a.substep == b.substep && a.iteration < b.iteration); }

/* What the substeps of one frame (or of the pre-roll) share; the muscles only read it. */
typedef struct run {
    const sn_model *model;
    sn_state *state;
    const sn_backend *backend;
    double begin;         /* frame number, as a time in frames, at which the first substep starts */
    bool frozen;          /* time stands still: inputs and poses stay those of `begin` */
    moment from, to;      /* what to do now */
    bool measure;         /* statistics at the end */
    sn_index run_in;      /* substeps of all of the pre-roll's run-in; 0 = this is no part of it */
    sn_index run_in_done; /* before this run */
    bool goes_on;         /* what is counted adds to what was */
    sn_point *start;      /* (points of all muscles, one after the other) where they are before an iteration; NULL = nobody asks */
} run;

/* When so many parts of a substep are done. */
static double time_of(const run *r, sn_index substep, sn_index parts) {
    const sn_scene *scene = r->model->scene;
    if (r->frozen) return r->begin / scene->rate;
    return (r->begin + (substep + parts / (double)SN_SUBSTEP_PARTS) / (double)sn_solver_substeps(&scene->solver)) / scene->rate;
}

static double substep_time(const run *r, sn_index substep) { return time_of(r, substep, SN_SUBSTEP_PARTS); }

/* How far the bones are from rest to the first frame, when so many parts of a substep of the run-in are done: eased, they set out and
 * arrive at rest. */
static double run_in_share(const run *r, sn_index substep, sn_index parts) {
    double t = fmin((r->run_in_done + substep + parts / (double)SN_SUBSTEP_PARTS) / r->run_in, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/* Of all joints, at the end of a substep. */
static sn_rigid *substep_poses(const run *r, sn_index substep) {
    size_t slot = r->frozen && r->run_in == 0 ? 0 : (size_t)substep;
    return r->state->poses + slot * (size_t)r->model->scene->motion.joint_count;
}

/* What a muscle is told of the moment in a substep when so many of its parts are done: only there do muscles that halve their steps need
 * poses of their own. */
static void take_poses(const run *r, const sn_model_muscle *m, sn_muscle_state *s, sn_index substep, sn_index parts) {
    const sn_motion *motion = &r->model->scene->motion;
    bool between = parts < SN_SUBSTEP_PARTS && r->run_in > 0;
    if (!between && (parts == SN_SUBSTEP_PARTS || r->frozen))
        sn_kinematics_aim(m, s, substep_poses(r, substep));
    else if (!between)
        sn_kinematics_aim_at(m, s, motion, time_of(r, substep, parts));
    for (sn_index i = 0; between && i < m->site_count; i++) {
        double share = run_in_share(r, substep, parts), time = time_of(r, substep, parts);
        if (m->sites[i].joint != SN_NONE) s->poses[i] = sn_motion_run_in_pose(motion, m->sites[i].joint, time, share);
    }
}

/* Does the work of this run end in or with this substep? */
static bool is_last(const run *r, sn_index substep) {
    return substep == r->to.substep || (r->to.iteration == 0 && substep + 1 == r->to.substep);
}

/* A muscle is at rest when no point of it would get farther than this share of its diagonal in a frame. What is left of its way is at most
 * some hundred times as much: the slowest modes lose a hundredth of their speed in a frame. */
static const double REST = 1e-13;

/* Count the substeps in a row that moved nothing. */
static void watch_rest(const run *r, const sn_model_muscle *m, sn_muscle_state *s) {
    double most = REST * m->diagonal / r->model->frame_duration;
    bool still = true;
    for (sn_index i = 0; still && i < m->point_count; i++) still = sn_norm2(s->velocities[i]) <= most * most;
    s->still = still ? s->still + (s->still < SN_INDEX_MAX) : 0;
    if (still) s->pair_count = s->pair_next = 0; /* whether it sleeps or not: what moves it next finds it the same */
}

/* If it does not move in the step at hand, either, may it sleep from there on? Then this step is the last that can be measured. */
static bool may_fall_asleep(const run *r, const sn_muscle_state *s) {
    const sn_solver_settings *solver = &r->model->scene->solver;
    return solver->sleep && s->still + 1 >= sn_solver_substeps(solver);
}

/* After a frame at rest a muscle sleeps until an input changes. */
static bool sleeps(const run *r, const sn_model_muscle *m, sn_muscle_state *s, sn_index substep) {
    const sn_scene *scene = r->model->scene;
    bool rested = scene->solver.sleep && s->still >= sn_solver_substeps(&scene->solver);
    if (rested && sn_channel_at(&m->source->activation, substep_time(r, substep)) == s->activation && !sn_kinematics_moved(m, s))
        return true;
    if (rested) s->still = 0;
    return false;
}

/* A muscle's part of r->start. */
static sn_point *start_of(const run *r, sn_index muscle) {
    sn_point *start = r->start;
    for (sn_index i = 0; start != NULL && i < muscle; i++) start += r->model->muscles[i].point_count;
    return start;
}

/* The step at hand, or so many iterations of it that the muscle has spent `until` of them in the substep. */
static void do_step(const run *r, sn_index muscle, sn_index substep, sn_index until) {
    const sn_model_muscle *m = &r->model->muscles[muscle];
    sn_muscle_state *s = &r->state->muscles[muscle];
    sn_progress *at = &s->progress;
    sn_index parts = at->parts + at->size, wanted = until - at->spent, left = m->iterations - at->iteration;
    sn_index done = wanted < left ? wanted : left, end = at->iteration + done;
    const sn_substep part = {.h = r->model->substep_duration * (at->size / (double)SN_SUBSTEP_PARTS),
                             .gravity = r->model->scene->gravity,
                             .rules = sn_scheme_rules_of(&r->model->scene->solver),
                             .begin = at->iteration,
                             .end = end,
                             .may_halve = r->model->halves && at->size > 1,
                             .halved = at->size < SN_SUBSTEP_PARTS,
                             .measure = r->measure && end == m->iterations && (is_last(r, substep) || may_fall_asleep(r, s)),
                             .start = start_of(r, muscle)};
    take_poses(r, m, s, substep, parts);
    sn_inputs_update(m, s, time_of(r, substep, parts));
    sn_verdict verdict = r->backend->substep(m, s, &part);
    if (verdict != SN_STEP_REFUSED) at->spent += done;
    if (verdict != SN_STEP_HOLDS) {
        at->size /= 2, at->iteration = 0;
        s->statistics.halvings++;
        return;
    }
    at->iteration = end;
    if (end < m->iterations) return;
    at->parts = parts, at->iteration = 0;
    s->statistics.steps++;
    watch_rest(r, m, s);
}

/* One substep, from its start or from where the muscle is in it, until it has spent so many iterations or is through. false: it sleeps. */
static bool do_substep(const run *r, sn_index muscle, sn_index substep, bool fresh, sn_index until) {
    const sn_model_muscle *m = &r->model->muscles[muscle];
    sn_muscle_state *s = &r->state->muscles[muscle];
    sn_progress *at = &s->progress;
    if (fresh) {
        *at = (sn_progress){.size = SN_SUBSTEP_PARTS};
        take_poses(r, m, s, substep, SN_SUBSTEP_PARTS);
        if (sleeps(r, m, s, substep)) at->size = 0;
    }
    s->statistics.asleep = at->size == 0;
    if (at->size == 0) { /* it counts the iterations that it would have made */
        at->spent = until < m->iterations ? until : m->iterations;
        at->parts = at->spent == m->iterations ? SN_SUBSTEP_PARTS : 0;
    }
    while (at->parts < SN_SUBSTEP_PARTS && at->spent < until && at->size > 0) do_step(r, muscle, substep, until);
    return at->size > 0;
}

/* false: it has slept all the time, and what its statistics say still holds. */
static bool do_muscle(const run *r, sn_index muscle) {
    bool awake = false;
    for (sn_index substep = r->from.substep; substep <= r->to.substep; substep++) {
        bool fresh = substep > r->from.substep || r->from.iteration == 0;
        sn_index until = substep == r->to.substep ? r->to.iteration : SN_INDEX_MAX;
        if (until > 0) awake = do_substep(r, muscle, substep, fresh, until) || awake;
    }
    return awake;
}

static void do_muscles(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const run *r = user;
    (void)chunk;
    for (sn_index muscle = begin; muscle < end; muscle++)
        if (do_muscle(r, muscle) && r->measure) sn_statistics_measure(&r->model->muscles[muscle], &r->state->muscles[muscle]);
}

/* ---- frames --------------------------------------------------------------------------------------------------------------- */

static void prepare_poses(const run *r) {
    const sn_scene *scene = r->model->scene;
    sn_index slots = r->frozen && r->run_in == 0 ? 1 : sn_solver_substeps(&scene->solver);
    for (sn_index i = 0; i < slots; i++) {
        double share = r->run_in > 0 ? run_in_share(r, i, SN_SUBSTEP_PARTS) : 1.0;
        sn_motion_run_in_poses(&scene->motion, substep_time(r, i), share, substep_poses(r, i));
    }
}

static void clear_counters(sn_state *state, sn_index muscle_count) {
    for (sn_index i = 0; i < muscle_count; i++) {
        sn_statistics *statistics = &state->muscles[i].statistics;
        statistics->skipped_edges = statistics->skipped_hinges = statistics->clamped_hinges = 0;
        statistics->held_triangles = statistics->skipped_triangles = statistics->torn_substeps = 0;
        statistics->iterations = statistics->rejected_steps = statistics->refactorisations = statistics->restarts = 0;
        statistics->steps = statistics->halvings = 0;
    }
}

/* How far the last iteration moved a point that no bone carries, on average over the mean edge ([K21] fig. 7); NaN under qn. */
static double mean_move(const run *r, sn_index muscle) {
    const sn_model_muscle *m = &r->model->muscles[muscle];
    const sn_muscle_state *s = &r->state->muscles[muscle];
    const sn_point *start = start_of(r, muscle);
    double sum = 0.0;
    sn_index free_points = 0;
    if (m->quasi_newton) return NAN;
    for (sn_index i = 0; !s->statistics.asleep && i < m->point_count; i++) {
        if (m->inverse_mass[i] == 0.0) continue;
        sum += sn_distance(sn_point_position(&s->points[i]), sn_point_position(&start[i]));
        free_points++;
    }
    return free_points > 0 ? sum / (free_points * m->mean_edge) : 0.0;
}

/* One record per muscle for the iteration just done; true = stop. */
static bool trace_iteration(const run *r, moment done, sn_trace *trace) {
    for (sn_index i = 0; i < r->model->muscle_count; i++) {
        const sn_statistics *st = &r->state->muscles[i].statistics;
        if (r->state->muscles[i].progress.spent < done.iteration) continue; /* it was through before */
        if (SN_TRACE(trace, "iteration", sn_trace_number("frame", r->state->frame), sn_trace_number("substep", done.substep + 1),
                     sn_trace_number("iteration", done.iteration), sn_trace_text("muscle", r->model->muscles[i].source->name),
                     sn_trace_number("activation", st->activation), sn_trace_number("volume_error", st->volume_error),
                     sn_trace_number("internal_rms", st->residuals[SN_ROWS_INTERNAL].rms),
                     sn_trace_number("radial_rms", st->residuals[SN_ROWS_RADIAL].rms),
                     sn_trace_number("mesh_rms", st->residuals[SN_ROWS_MESH].rms),
                     sn_trace_number("mesh_max", st->residuals[SN_ROWS_MESH].max),
                     sn_trace_number("dihedral_rms", st->residuals[SN_ROWS_DIHEDRAL].rms),
                     sn_trace_number("dihedral_max", st->residuals[SN_ROWS_DIHEDRAL].max),
                     sn_trace_number("smallest_triangle", st->smallest_triangle), sn_trace_number("kinetic_energy", st->kinetic_energy),
                     sn_trace_number("nan", st->nan_points), sn_trace_number("mean_move", mean_move(r, i))))
            return true;
    }
    return false;
}

/* Are all muscles through with the substep? */
static bool all_through(const run *r) {
    for (sn_index i = 0; i < r->model->muscle_count; i++)
        if (r->state->muscles[i].progress.parts < SN_SUBSTEP_PARTS) return false;
    return true;
}

/* Where a run that was to go to `to` has come: the last iteration of a substep is the start of the next one. */
static moment reached(const run *r, moment to) { return to.iteration > 0 && all_through(r) ? (moment){to.substep + 1, 0} : to; }

/* Iteration after iteration, with a record of each; where it stops, the state says how far it came. */
static sn_status watch(run *r, moment last, sn_pool *pool, sn_trace *trace) {
    r->measure = true;
    while (before(r->from, last)) {
        r->to = (moment){r->from.substep, r->from.iteration + 1};
        sn_parallel_for(pool, r->model->muscle_count, 1, do_muscles, r);
        moment done = r->to;
        r->from = reached(r, done);
        r->state->substep = r->from.substep;
        r->state->iteration = r->from.iteration;
        if (trace_iteration(r, done, trace)) return SN_STOPPED;
    }
    return SN_OK;
}

static sn_status do_watched(run *r, moment last, sn_pool *pool, sn_trace *trace, sn_error *error) {
    size_t points = 0;
    for (sn_index i = 0; i < r->model->muscle_count; i++) points += (size_t)r->model->muscles[i].point_count;
    r->start = SN_NEW(sn_point, points);
    if (r->start == NULL) return sn_fail_memory(error, "the trace");
    sn_status status = watch(r, last, pool, trace);
    free(r->start);
    r->start = NULL;
    return status;
}

/* From r->from to `last`: in one go, or step by step where somebody watches. */
static sn_status do_run(run *r, moment last, const sn_step_options *options, sn_error *error) {
    sn_pool *pool = options != NULL ? options->pool : NULL;
    sn_trace *trace = options != NULL ? options->trace : NULL;
    if (sn_trace_stopped(trace)) return SN_STOPPED;
    r->backend = sn_backend_of(r->model->scene);
    prepare_poses(r);
    if (r->from.substep == 0 && r->from.iteration == 0 && !r->goes_on) clear_counters(r->state, r->model->muscle_count);
    if (trace != NULL && (trace->receive != NULL || trace->stop_after >= 0)) return do_watched(r, last, pool, trace, error);
    r->to = last;
    r->measure = true;
    sn_parallel_for(pool, r->model->muscle_count, 1, do_muscles, r);
    return SN_OK;
}

/* ---- the pre-roll ----------------------------------------------------------------------------------------------------------- */

/* The bones go from rest to the first frame, a frame's time after the other. */
static sn_status run_in(run *r, sn_index substeps, const sn_step_options *options, sn_error *error) {
    sn_index frame = sn_solver_substeps(&r->model->scene->solver);
    sn_status status = SN_OK;
    r->run_in = substeps;
    for (; r->run_in_done < substeps && status == SN_OK; r->goes_on = true) {
        sn_index left = substeps - r->run_in_done, now = left < frame ? left : frame;
        r->from = (moment){0, 0};
        status = do_run(r, (moment){now, 0}, options, error);
        if (status != SN_OK) return status;
        r->run_in_done += now;
        if (options != NULL && options->watch != NULL) status = options->watch(options->user, r->state, run_in_share(r, 0, 0), error);
    }
    r->run_in = 0;
    return status;
}

/* Whole substeps, rounded up. */
static double substeps_in(const sn_model *model, double seconds) { return fmax(ceil(seconds / model->substep_duration - 1e-9), 0.0); }

sn_status sn_settle(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    const sn_scene *scene = model->scene;
    double moving = sn_scene_runs_in(scene) ? fmax(substeps_in(model, scene->run_in), 1.0) : 0.0; /* it must arrive */
    double substeps = fmax(substeps_in(model, scene->preroll), moving);
    if (!(substeps >= 1.0)) return SN_OK;
    if (substeps > SN_INDEX_MAX)
        return sn_fail(error, SN_ERROR_USAGE, "a pre-roll of %g s is more than %d substeps; shorten it", scene->preroll, (int)SN_INDEX_MAX);
    run r = {.model = model, .state = state, .begin = scene->first_frame, .frozen = true};
    sn_status status = run_in(&r, (sn_index)moving, options, error);
    r.from = (moment){0, 0};
    if (status == SN_OK && substeps > moving) status = do_run(&r, (moment){(sn_index)(substeps - moving), 0}, options, error);
    if (status == SN_OK) state->substep = state->iteration = 0;
    return status;
}

sn_status sn_hold(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    sn_index substeps = sn_solver_substeps(&model->scene->solver);
    if (state->substep != 0 || state->iteration != 0)
        return sn_fail(error, SN_ERROR_USAGE, "cannot hold a state in the middle of its frame");
    run r = {.model = model, .state = state, .begin = state->frame, .frozen = true};
    sn_status status = do_run(&r, (moment){substeps, 0}, options, error);
    if (status == SN_OK) state->substep = state->iteration = 0;
    return status;
}

/* Where the options stop within a frame; the frame's end where they do not. */
static moment stop_of(const sn_model *model, const sn_step_options *options) {
    if (options == NULL || options->stop_substep == 0) return (moment){sn_solver_substeps(&model->scene->solver), 0};
    if (options->stop_iteration == 0) return (moment){options->stop_substep, 0};
    return (moment){options->stop_substep - 1, options->stop_iteration};
}

sn_status sn_step(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    sn_index substeps = sn_solver_substeps(&model->scene->solver);
    if (options != NULL && (options->stop_substep < 0 || options->stop_substep > substeps || options->stop_iteration < 0))
        return sn_fail(error, SN_ERROR_USAGE, "cannot stop after substep %d: a frame has %d", (int)options->stop_substep, (int)substeps);
    moment from = {state->substep, state->iteration}, stop = stop_of(model, options);
    bool fresh = from.substep == 0 && from.iteration == 0;
    if (before(stop, from)) return sn_fail(error, SN_ERROR_USAGE, "cannot stop there: the state is beyond it already");
    run r = {.model = model, .state = state, .begin = fresh ? state->frame : state->frame - 1, .from = from};
    if (fresh) state->frame++;
    sn_status status = do_run(&r, stop, options, error);
    if (status != SN_OK) return status;
    stop = reached(&r, stop);
    bool whole = stop.substep == substeps;
    state->substep = whole ? 0 : stop.substep;
    state->iteration = whole ? 0 : stop.iteration;
    return options != NULL && options->stop_substep > 0 && !whole ? SN_STOPPED : SN_OK;
}
