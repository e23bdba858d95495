/*
 * step.c -- a frame as a table of stages over groups; the back end has three of them.   [R18] alg. 1, methods.md 8.7
 *
 * Groups run side by side, each through all substeps of the frame in one thread; where somebody watches, all of them through one
 * iteration after the other. Both give the same bits, and so does a run that stops anywhere and goes on: stepping, watching, stopping and
 * sleeping go through the same stages.
 */
#include "backend.h"
#include "contact.h"
#include "external.h"

/* How far into a frame: substeps done, and iterations of the next one. */
typedef struct moment {
    sn_index substep, iteration;
} moment;

static bool before(moment a, moment b) { return a.substep < b.substep || (a.substep == b.substep && a.iteration < b.iteration); }

/* What the substeps of one frame (or of the pre-roll) share; the groups only read it. */
typedef struct run {
    const sn_model *model;
    sn_state *state;
    const sn_backend *backend;
    double begin;       /* frame number, as a time in frames, at which the first substep starts */
    bool frozen;        /* time stands still: inputs and poses stay those of `begin` */
    double seconds;     /* frozen: how long */
    double run_in;      /* s: of all of the pre-roll's run-in, in which bones come from rest to `begin`; 0 = this is no part of it */
    double run_in_done; /* s: of it, before this run */
    bool goes_on;       /* what is counted adds to what was */
    moment from, to;    /* what to do now */
    bool measure;       /* statistics at the end */
    sn_point *before;   /* (points of all groups, one after the other) where they are before an iteration; NULL = nobody asks */
} run;

/* ---- the times of a group ----------------------------------------------------------------------------------------------------- */

/* A frame's, or those that the time frozen takes, rounded up. */
static double substeps_in(const run *r, const sn_group *g) {
    return r->frozen ? ceil(r->seconds / g->substep_duration - 1e-9) : (double)g->substeps;
}

/* Of the group that has the most. */
static double most_substeps(const run *r) {
    double most = 0.0;
    for (sn_index i = 0; i < r->model->group_count; i++) most = fmax(most, substeps_in(r, &r->model->groups[i]));
    return most;
}

/* When so many parts of a substep are done. */
static double time_of(const run *r, const sn_group *g, sn_index substep, sn_index parts) {
    const sn_scene *scene = r->model->scene;
    if (r->frozen) return r->begin / scene->rate;
    return (r->begin + (substep + parts / (double)SN_SUBSTEP_PARTS) / (double)g->substeps) / scene->rate;
}

/* How far the bones are from rest to the first frame, so many seconds after this run's start: eased, they set out and arrive at rest. */
static double run_in_share(const run *r, double seconds) {
    double t = r->run_in > 0.0 ? fmin((r->run_in_done + seconds) / r->run_in, 1.0) : 1.0;
    return t * t * (3.0 - 2.0 * t);
}

/* Do the bones stay where they are all the time? */
static bool stands(const run *r) { return r->frozen && r->run_in == 0.0; }

/* Of all joints, at the end of a substep of the scene's. */
static sn_rigid *shared_poses(const run *r, sn_index substep) {
    size_t slot = stands(r) ? 0 : (size_t)substep;
    return r->state->poses + slot * (size_t)r->model->scene->motion.joint_count;
}

/* The poses of a group's bones when so many parts of a substep are done: where all groups ask for them they are at hand; a group that
 * halves its steps, or has its own number of them, asks for its own. */
static void take_poses(const run *r, const sn_group *g, sn_group_state *s, sn_index substep, sn_index parts) {
    const sn_scene *scene = r->model->scene;
    bool shared = stands(r) || (parts == SN_SUBSTEP_PARTS && g->substeps == sn_solver_substeps(&scene->solver));
    const sn_surface_moment at = {.poses = shared ? shared_poses(r, substep) : NULL,
                                  .time = time_of(r, g, substep, parts),
                                  .share = run_in_share(r, (substep + parts / (double)SN_SUBSTEP_PARTS) * g->substep_duration)};
    for (sn_index i = 0; i < g->count; i++) {
        sn_kinematics_aim(g->members[i], s->members[i], scene, &at);
        sn_contacts_aim(g->members[i], s->members[i], scene, &at);
    }
    sn_externals_aim(g, s, scene, &at);
}

/* ---- rest ----------------------------------------------------------------------------------------------------------------------- */

/* A muscle is at rest when no point of it would get farther than this share of its diagonal in a frame. What is left of its way is at most
 * some hundred times as much: the slowest modes lose a hundredth of their speed in a frame. */
static const double REST = 1e-13;

static bool is_still(const run *r, const sn_model_muscle *m, const sn_muscle_state *s) {
    double most = REST * m->diagonal / r->model->frame_duration;
    for (sn_index i = 0; i < m->point_count; i++)
        if (!(sn_norm2(s->velocities[i]) <= most * most)) return false;
    return true;
}

/* Of a group that rests: does anything that it is told differ from what it was told last? */
static bool is_woken(const sn_group *g, const sn_group_state *s, double time) {
    if (sn_externals_moved(g, s)) return true;
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        bool same = sn_muscle_activation(m->source, time) == s->members[i]->inputs->activation;
        if (!same || sn_kinematics_moved(m, s->members[i]) || sn_contacts_moved(m, s->members[i], time - g->substep_duration)) return true;
    }
    return false;
}

/* After a frame at rest a group sleeps until an input changes. */
static bool sleeps(const run *r, const sn_group *g, sn_group_state *s, sn_index substep) {
    bool rested = r->model->scene->solver.sleep && s->still >= g->substeps;
    if (rested) take_poses(r, g, s, substep, SN_SUBSTEP_PARTS);
    bool woken = rested && is_woken(g, s, time_of(r, g, substep, SN_SUBSTEP_PARTS));
    if (woken) s->still = 0;
    for (sn_index i = 0; rested && !woken && i < g->count; i++) sn_contacts_sleep(g->members[i], s->members[i]);
    return rested && !woken;
}

/* ---- a step as stages ------------------------------------------------------------------------------------------------------------- */

/* The step at hand of one group, or so many of its iterations. */
typedef struct step {
    const run *r;
    const sn_group *g;
    sn_group_state *s;
    sn_index substep, parts; /* it ends when so many parts of that substep are done */
    sn_substep part;
} step;

/* Stages: what a step does, in this order. One that has nothing to do in the iterations at hand does nothing. Where a verdict is that the
 * step does not hold, the others are left out. */
static sn_verdict stage_poses(const step *at) {
    take_poses(at->r, at->g, at->s, at->substep, at->parts);
    return SN_STEP_HOLDS;
}

static sn_verdict stage_inputs(const step *at) {
    double time = time_of(at->r, at->g, at->substep, at->parts);
    for (sn_index i = 0; i < at->g->count; i++) sn_inputs_update(at->g->members[i], at->s->members[i], time);
    return SN_STEP_HOLDS;
}

/* Bones that would pass by too far make it too long; so that none passes through a muscle thinner than its way. */
static sn_verdict stage_sweep(const step *at) {
    if (at->part.begin > 0) return SN_STEP_HOLDS;
    for (sn_index i = 0; i < at->g->count; i++) {
        if (!sn_contacts_too_far(at->g->members[i], at->s->members[i], &at->part)) continue;
        if (at->s->progress.size > 1) return SN_STEP_REFUSED;
        at->s->members[i]->statistics.leaps++; /* there is no shorter one */
    }
    return SN_STEP_HOLDS;
}

static sn_verdict stage_start(const step *at) {
    const sn_backend *backend = at->r->backend;
    if (at->part.begin == 0) return backend->start(at->g, at->s, &at->part);
    backend->resume(at->g, at->s, &at->part);
    return SN_STEP_HOLDS;
}

static sn_verdict stage_iterate(const step *at) {
    at->r->backend->iterate(at->g, at->s, &at->part);
    return SN_STEP_HOLDS;
}

static bool ends(const step *at) { return at->part.end == at->g->iterations; }

static sn_verdict stage_finish(const step *at) { return ends(at) ? at->r->backend->finish(at->g, at->s, &at->part) : SN_STEP_HOLDS; }

/* Count the substeps in a row that moved nothing. */
static sn_verdict stage_rest(const step *at) {
    sn_group_state *s = at->s;
    bool still = true;
    if (!ends(at)) return SN_STEP_HOLDS;
    for (sn_index i = 0; still && i < at->g->count; i++) still = is_still(at->r, at->g->members[i], s->members[i]);
    s->still = still ? s->still + (s->still < SN_INDEX_MAX) : 0;
    if (still && at->r->backend->rest != NULL) at->r->backend->rest(s); /* whether it sleeps or not: what moves it next finds it the same */
    return SN_STEP_HOLDS;
}

static sn_verdict (*const STAGES[])(const step *at) = {stage_poses,   stage_inputs, stage_sweep, stage_start,
                                                       stage_iterate, stage_finish, stage_rest};

/* ---- a substep of a group: one step, or the halves of it ---------------------------------------------------------------------------- */

/* Does the work of this run end in or with this substep? */
static bool is_last(const run *r, const sn_group *g, sn_index substep) {
    return substep == r->to.substep || (r->to.iteration == 0 && substep + 1 == r->to.substep) || substep + 1 >= substeps_in(r, g);
}

/* If it does not move in the step at hand, either, may it sleep from there on? Then this step is the last that can be measured. */
static bool may_fall_asleep(const run *r, const sn_group *g, const sn_group_state *s) {
    return r->model->scene->solver.sleep && s->still + 1 >= g->substeps;
}

/* A group's part of r->before. */
static sn_point *before_of(const run *r, const sn_group *group) {
    sn_point *points = r->before;
    for (const sn_group *g = r->model->groups; points != NULL && g < group; g++) points += g->point_count;
    return points;
}

/* The step at hand, or so many iterations of it that the group has spent `until` of them in the substep. */
static step step_of(const run *r, const sn_group *g, sn_group_state *s, sn_index substep, sn_index until) {
    const sn_progress *at = &s->progress;
    sn_index wanted = until - at->spent, left = g->iterations - at->iteration, end = at->iteration + (wanted < left ? wanted : left);
    bool last = is_last(r, g, substep) || may_fall_asleep(r, g, s);
    return (step){.r = r,
                  .g = g,
                  .s = s,
                  .substep = substep,
                  .parts = at->parts + at->size,
                  .part = {.h = g->substep_duration * (at->size / (double)SN_SUBSTEP_PARTS),
                           .gravity = r->model->scene->gravity,
                           .rules = sn_scheme_rules_of(&r->model->scene->solver),
                           .begin = at->iteration,
                           .end = end,
                           .may_halve = g->halves && at->size > SN_LEAST_TORN_PARTS,
                           .halved = at->size < SN_SUBSTEP_PARTS,
                           .measure = r->measure && end == g->iterations && last,
                           .before = before_of(r, g)}};
}

static sn_verdict run_stages(const step *at) {
    sn_verdict verdict = SN_STEP_HOLDS;
    for (size_t i = 0; i < sizeof STAGES / sizeof *STAGES && verdict == SN_STEP_HOLDS; i++) verdict = STAGES[i](at);
    return verdict;
}

static void do_step(const run *r, const sn_group *g, sn_group_state *s, sn_index substep, sn_index until) {
    const step now = step_of(r, g, s, substep, until);
    sn_progress *at = &s->progress;
    sn_verdict verdict = run_stages(&now);
    if (verdict != SN_STEP_REFUSED) at->spent += now.part.end - now.part.begin;
    if (verdict != SN_STEP_HOLDS) {
        at->size /= 2, at->iteration = 0;
        for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.halvings++;
        return;
    }
    at->iteration = now.part.end;
    if (!ends(&now)) return;
    at->parts = now.parts, at->iteration = 0;
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.steps++;
}

/* One substep, from its start or from where the group is in it, until it has spent so many iterations or is through. false: it sleeps. */
static bool do_substep(const run *r, sn_index group, sn_index substep, bool fresh, sn_index until) {
    const sn_group *g = &r->model->groups[group];
    sn_group_state *s = &r->state->groups[group];
    sn_progress *at = &s->progress;
    if (fresh) {
        *at = (sn_progress){.size = SN_SUBSTEP_PARTS};
        if (sleeps(r, g, s, substep)) at->size = 0;
    }
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.asleep = at->size == 0;
    if (at->size == 0) { /* it counts the iterations that it would have made */
        at->spent = until < g->iterations ? until : g->iterations;
        at->parts = at->spent == g->iterations ? SN_SUBSTEP_PARTS : 0;
    }
    while (at->parts < SN_SUBSTEP_PARTS && at->spent < until && at->size > 0) do_step(r, g, s, substep, until);
    return at->size > 0;
}

/* ---- a frame of a group --------------------------------------------------------------------------------------------------------- */

/* false: it has slept all the time, and what its statistics say still holds. */
static bool do_group(const run *r, sn_index group) {
    double substeps = substeps_in(r, &r->model->groups[group]);
    bool awake = false;
    for (sn_index substep = r->from.substep; substep <= r->to.substep && substep < substeps; substep++) {
        bool fresh = substep > r->from.substep || r->from.iteration == 0;
        sn_index until = substep == r->to.substep ? r->to.iteration : SN_INDEX_MAX;
        if (until > 0) awake = do_substep(r, group, substep, fresh, until) || awake;
    }
    return awake;
}

static void do_groups(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const run *r = user;
    (void)chunk;
    for (sn_index group = begin; group < end; group++) {
        const sn_group *g = &r->model->groups[group];
        if (!do_group(r, group) || !r->measure) continue;
        for (sn_index i = 0; i < g->count; i++) sn_statistics_measure(g->members[i], r->state->groups[group].members[i]);
        sn_externals_measure(g, &r->state->groups[group]);
    }
}

/* ---- frames --------------------------------------------------------------------------------------------------------------- */

/* At the ends of the scene's substeps. */
static void prepare_poses(const run *r) {
    const sn_scene *scene = r->model->scene;
    sn_index slots = stands(r) ? 1 : sn_solver_substeps(&scene->solver);
    for (sn_index i = 0; i < slots; i++) {
        double time = (r->frozen ? r->begin : r->begin + (i + 1.0) / (double)slots) / scene->rate;
        sn_motion_run_in_poses(&scene->motion, time, run_in_share(r, (i + 1.0) * r->model->substep_duration), shared_poses(r, i));
    }
}

static void clear_counters(sn_state *state, sn_index muscle_count) {
    for (sn_index i = 0; i < muscle_count; i++) {
        sn_statistics *statistics = &state->muscles[i].statistics;
        statistics->skipped_edges = statistics->skipped_hinges = statistics->clamped_hinges = 0;
        statistics->held_triangles = statistics->skipped_triangles = statistics->torn_substeps = 0;
        statistics->iterations = statistics->rejected_steps = statistics->refactorisations = statistics->restarts = 0;
        statistics->steps = statistics->halvings = statistics->leaps = 0;
    }
}

/* How far the last iteration moved a point that no bone carries, on average over the mean edge ([K21] fig. 7); NaN under qn. */
static double mean_move(const run *r, sn_index muscle) {
    const sn_model_muscle *m = &r->model->muscles[muscle];
    const sn_muscle_state *s = &r->state->muscles[muscle];
    const sn_group *g = &r->model->groups[m->group];
    const sn_point *start = before_of(r, g) + g->first[m->member];
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

/* What a record tells of the rows: NAME_rms and NAME_max of every kind whose rows have points of their own. */
static int trace_rows(const sn_statistics *st, sn_trace_value *values) {
    static const char *const names[SN_ROW_KINDS][2] = {
#define NAMES(id, name) {#name "_rms", #name "_max"},
        SN_ROW_LIST(NAMES)
#undef NAMES
    };
    int count = 0;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        if (sn_row_info_of((sn_row_kind)kind)->points == 0) continue;
        values[count++] = sn_trace_number(names[kind][0], st->residuals[kind].rms);
        values[count++] = sn_trace_number(names[kind][1], st->residuals[kind].max);
    }
    return count;
}

static bool trace_muscle(const run *r, sn_index muscle, moment done, sn_trace *trace) {
    const sn_statistics *st = &r->state->muscles[muscle].statistics;
    sn_trace_value values[10 + 2 * SN_ROW_KINDS] = {
        sn_trace_number("frame", r->state->frame),     sn_trace_number("substep", done.substep + 1),
        sn_trace_number("iteration", done.iteration),  sn_trace_text("muscle", r->model->muscles[muscle].source->name),
        sn_trace_number("activation", st->activation), sn_trace_number("volume_error", st->volume_error)};
    int count = 6 + trace_rows(st, values + 6);
    values[count++] = sn_trace_number("smallest_triangle", st->smallest_triangle);
    values[count++] = sn_trace_number("kinetic_energy", st->kinetic_energy);
    values[count++] = sn_trace_number("nan", st->nan_points);
    values[count++] = sn_trace_number("mean_move", mean_move(r, muscle));
    return sn_trace_step(trace, "iteration", values, count);
}

/* One record per muscle for the iteration just done; true = stop. */
static bool trace_iteration(const run *r, moment done, sn_trace *trace) {
    for (sn_index i = 0; i < r->model->muscle_count; i++) {
        if (r->state->groups[r->model->muscles[i].group].progress.spent < done.iteration) continue; /* it was through before */
        if (trace_muscle(r, i, done, trace)) return true;
    }
    return false;
}

/* Are all groups through with the substep? */
static bool all_through(const run *r) {
    for (sn_index i = 0; i < r->model->group_count; i++)
        if (r->state->groups[i].progress.parts < SN_SUBSTEP_PARTS) return false;
    return true;
}

/* Where a run that was to go to `to` has come: the last iteration of a substep is the start of the next one. */
static moment reached(const run *r, moment to) { return to.iteration > 0 && all_through(r) ? (moment){to.substep + 1, 0} : to; }

/* Iteration after iteration, with a record of each; where it stops, the state says how far it came. */
static sn_status watch(run *r, moment last, sn_pool *pool, sn_trace *trace) {
    r->measure = true;
    while (before(r->from, last)) {
        r->to = (moment){r->from.substep, r->from.iteration + 1};
        sn_parallel_for(pool, r->model->group_count, 1, do_groups, r);
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
    for (sn_index i = 0; i < r->model->group_count; i++) points += (size_t)r->model->groups[i].point_count;
    r->before = SN_NEW(sn_point, points);
    if (r->before == NULL) return sn_fail_memory(error, "the trace");
    sn_status status = watch(r, last, pool, trace);
    free(r->before);
    r->before = NULL;
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
    sn_parallel_for(pool, r->model->group_count, 1, do_groups, r);
    return SN_OK;
}

/* ---- time stands still ------------------------------------------------------------------------------------------------------ */

/* So many seconds with the inputs of frame r->begin, and its poses but for a run-in. */
static sn_status freeze(run *r, double seconds, const sn_step_options *options, sn_error *error) {
    r->frozen = true;
    r->seconds = seconds;
    r->from = (moment){0, 0};
    double substeps = most_substeps(r);
    if (!(substeps >= 1.0)) return SN_OK;
    if (substeps > SN_INDEX_MAX)
        return sn_fail(error, SN_ERROR_USAGE, "a pre-roll of %g s is more than %d substeps; shorten it", seconds, (int)SN_INDEX_MAX);
    return do_run(r, (moment){(sn_index)substeps, 0}, options, error);
}

/* The bones go from rest to the first frame, a frame's time after the other. */
static sn_status run_in(run *r, double seconds, const sn_step_options *options, sn_error *error) {
    sn_status status = SN_OK;
    r->run_in = seconds;
    for (double left = seconds; left > 1e-9 * seconds && status == SN_OK; left = seconds - r->run_in_done, r->goes_on = true) {
        double now = fmin(left, r->model->frame_duration);
        status = freeze(r, now, options, error);
        if (status != SN_OK) return status;
        r->run_in_done += now;
        if (options != NULL && options->watch != NULL) status = options->watch(options->user, r->state, run_in_share(r, 0.0), error);
    }
    r->run_in = 0.0;
    return status;
}

/* In whole substeps, rounded up. */
static double rounded_up(const sn_model *model, double seconds) {
    return fmax(ceil(seconds / model->substep_duration - 1e-9), 0.0) * model->substep_duration;
}

sn_status sn_settle(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    const sn_scene *scene = model->scene;
    double moving = sn_scene_runs_in(scene) ? fmax(rounded_up(model, scene->run_in), model->substep_duration) : 0.0; /* it must arrive */
    double all = fmax(rounded_up(model, scene->preroll), moving);
    run r = {.model = model, .state = state, .begin = scene->first_frame};
    sn_status status = moving > 0.0 ? run_in(&r, moving, options, error) : SN_OK;
    if (status == SN_OK) status = freeze(&r, all - moving, options, error);
    if (status == SN_OK) state->substep = state->iteration = 0;
    return status;
}

sn_status sn_hold(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    if (state->substep != 0 || state->iteration != 0)
        return sn_fail(error, SN_ERROR_USAGE, "cannot hold a state in the middle of its frame");
    run r = {.model = model, .state = state, .begin = state->frame};
    sn_status status = freeze(&r, model->frame_duration, options, error);
    if (status == SN_OK) state->substep = state->iteration = 0;
    return status;
}

/* Where the options stop within a frame; the frame's end where they do not. */
static moment stop_of(sn_index substeps, const sn_step_options *options) {
    if (options == NULL || options->stop_substep == 0) return (moment){substeps, 0};
    if (options->stop_iteration == 0) return (moment){options->stop_substep, 0};
    return (moment){options->stop_substep - 1, options->stop_iteration};
}

sn_status sn_step(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error) {
    moment from = {state->substep, state->iteration};
    bool fresh = from.substep == 0 && from.iteration == 0;
    run r = {.model = model, .state = state, .begin = fresh ? state->frame : state->frame - 1, .from = from};
    sn_index substeps = sn_most_substeps(model);
    if (options != NULL && (options->stop_substep < 0 || options->stop_substep > substeps || options->stop_iteration < 0))
        return sn_fail(error, SN_ERROR_USAGE, "cannot stop after substep %d: a frame has %d", (int)options->stop_substep, (int)substeps);
    moment stop = stop_of(substeps, options);
    if (before(stop, from)) return sn_fail(error, SN_ERROR_USAGE, "cannot stop there: the state is beyond it already");
    if (fresh) state->frame++;
    sn_status status = do_run(&r, stop, options, error);
    if (status != SN_OK) return status;
    stop = reached(&r, stop);
    bool whole = stop.substep == substeps;
    state->substep = whole ? 0 : stop.substep;
    state->iteration = whole ? 0 : stop.iteration;
    return options != NULL && options->stop_substep > 0 && !whole ? SN_STOPPED : SN_OK;
}
