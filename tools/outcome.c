/*
 * outcome.c -- what simulate says of its run: frames that broke a limit or exploded, and in the end how it went.
 *
 * The library's statistics judge; here it is put into words, with what may help by what the run was made with.
 */
#include "outcome.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *name_of(const outcome *o, sn_index muscle) { return o->model->muscles[muscle].source->name; }

/* ---- --fail-on ------------------------------------------------------------------------------------------------------------------ */

typedef struct outcome_measure {
    const char *name;
    double (*read)(const sn_statistics *);
} outcome_measure;

static double read_volume(const sn_statistics *s) { return fabs(s->volume_error); }
static double read_nan(const sn_statistics *s) { return s->nan_points; }
static double read_triangle(const sn_statistics *s) { return s->smallest_triangle; }
static double read_edge(const sn_statistics *s) { return s->largest_edge_ratio; }
static double read_energy(const sn_statistics *s) { return s->kinetic_energy; }
static double read_elastic(const sn_statistics *s) { return s->elastic_energy; }
static double read_residual(const sn_statistics *s) { return s->residual; }
static double read_skipped(const sn_statistics *s) { return (double)(s->skipped_edges + s->skipped_hinges + s->skipped_triangles); }
static double read_clamped(const sn_statistics *s) { return (double)s->clamped_hinges; }
static double read_penetration(const sn_statistics *s) { return s->penetration; }
static double read_entered(const sn_statistics *s) { return s->entered; }
static double read_torn(const sn_statistics *s) { return s->torn; }

/* Beside these the greatest error of every kind of rows, by its name. */
static const outcome_measure MEASURES[] = {
    {"volume", read_volume},   {"nan", read_nan},         {"triangle", read_triangle},       {"edge", read_edge},
    {"energy", read_energy},   {"elastic", read_elastic}, {"residual", read_residual},       {"skipped", read_skipped},
    {"clamped", read_clamped}, {"torn", read_torn},       {"penetration", read_penetration}, {"entered", read_entered},
};
enum { MEASURE_COUNT = sizeof MEASURES / sizeof *MEASURES };

static bool equals(const char *name, const char *text, size_t length) { return strlen(name) == length && strncmp(name, text, length) == 0; }

static bool parse_limit(const char *text, const char *end, outcome_limit *out) {
    size_t name = strcspn(text, "<>,");
    const char *next;
    if (text[name] != '<' && text[name] != '>') return false;
    out->above = text[name] == '>';
    out->name = NULL;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++)
        if (equals(sn_row_kind_name((sn_row_kind)kind), text, name))
            out->name = sn_row_kind_name((sn_row_kind)kind), out->kind = (sn_row_kind)kind;
    out->measure = NULL;
    for (int i = 0; i < MEASURE_COUNT; i++)
        if (equals(MEASURES[i].name, text, name)) out->name = MEASURES[i].name, out->measure = &MEASURES[i];
    return out->name != NULL && sn_scan_number(text + name + 1, end, &next, &out->value) && next == end && isfinite(out->value);
}

void outcome_parse_limits(outcome *o, cli *c, const char *text) {
    o->c = c;
    o->limit_count = 0;
    if (text == NULL) return;
    if (*text == '\0') cli_usage_error(c, "--fail-on: it names no limit; write NAME>VALUE or NAME<VALUE");
    for (const char *end; *text != '\0'; text = *end == ',' ? end + 1 : end) {
        end = text + strcspn(text, ",");
        if (o->limit_count == OUTCOME_MOST_LIMITS) cli_usage_error(c, "--fail-on takes at most %d limits", OUTCOME_MOST_LIMITS);
        if (!parse_limit(text, end, &o->limits[o->limit_count++]))
            cli_usage_error(c, "--fail-on: cannot read \"%.*s\": write NAME>VALUE or NAME<VALUE", (int)(end - text), text);
    }
}

/* Each limit is reported where it is broken first, and only then. */
static void check_limits(outcome *o, const sn_state *state) {
    for (int k = 0; k < o->limit_count; k++) {
        outcome_limit *l = &o->limits[k];
        for (sn_index i = 0; l->name != NULL && i < o->model->muscle_count; i++) {
            const sn_statistics *s = &state->muscles[i].statistics;
            if (o->model->muscles[i].source->unseen) continue;
            double value = l->measure != NULL ? l->measure->read(s) : s->residuals[l->kind].max;
            if (l->above ? !(value > l->value) : !(value < l->value)) continue;
            cli_shortfall(o->c, "frame %d, muscle \"%s\": %s is %g, %s the limit of %g", (int)state->frame, name_of(o, i), l->name, value,
                          l->above ? "above" : "below", l->value);
            l->name = NULL;
        }
    }
}

/* ---- explosions ----------------------------------------------------------------------------------------------------------------- */

/* The box of the points that bones carry: how large it is, over how large it is at rest. 1 where there are none, or they are one point. */
static double spread_of_bones(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_box now = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}, rest = now;
    for (sn_index k = 0; k < m->kinematic_count; k++) {
        sn_index p = m->kinematic_points[k];
        sn_vec3 at = sn_point_position(&s->points[p]);
        now = (sn_box){sn_min3(now.low, at), sn_max3(now.high, at)};
        rest = (sn_box){sn_min3(rest.low, m->rest[p]), sn_max3(rest.high, m->rest[p])};
    }
    double before = sn_box_diagonal(rest);
    return before > 0.0 ? sn_box_diagonal(now) / before : 1.0;
}

/* Half a sentence: what may help a muscle of this run that has this sign of an explosion. */
static const char *help(const outcome *o, const sn_state *state, sn_index muscle, sn_explosion sign) {
    const sn_solver_settings *solver = &o->model->scene->solver;
    const sn_model_muscle *m = &o->model->muscles[muscle];
    const sn_muscle_state *s = &state->muscles[muscle];
    if (o->runs_in) return "a longer run-in may help";
    if (spread_of_bones(m, s) > 3.0) return "its bones have gone far apart: look at their motion and units";
    if (sign == SN_EXPLODED_VOLUME && !m->keeps_volume) return "nothing keeps its volume (see --plan): give it a volume stiffness";
    if (solver->scheme != SN_SCHEME_GUARDED) return "--scheme guarded, --solver qn or more --iterations may help";
    if (solver->method == SN_SOLVER_XPBD && solver->precision == SN_PRECISION_SINGLE)
        return "--precision double, more --substeps or --solver qn may help";
    if (solver->method == SN_SOLVER_XPBD) return "more --substeps, more --iterations or --solver qn may help";
    if (s->statistics.stop_reason == SN_STOP_FAILED) return "a lower stiffness, or less weight, may help";
    if (s->statistics.torn) return "bones that move fast or goals that it cannot reach have torn it: more --substeps may help";
    return "more --iterations or --substeps may help";
}

static void tell_explosion(outcome *o, const sn_state *state, sn_index muscle, sn_explosion sign) {
    const sn_statistics *s = &state->muscles[muscle].statistics;
    const char *name = name_of(o, muscle), *may_help = help(o, state, muscle, sign);
    if (sign == SN_EXPLODED_SOLVER)
        cli_shortfall(o->c, "%s: the solver has failed on muscle \"%s\", its matrix could not be factored or solved; %s", o->moment, name,
                      may_help);
    else if (sign == SN_EXPLODED_VOLUME)
        cli_shortfall(o->c, "%s: muscle \"%s\" has exploded, its volume is %.4g times its goal; %s", o->moment, name, 1.0 + s->volume_error,
                      may_help);
    else
        cli_shortfall(o->c, "%s: muscle \"%s\" has exploded, its edge between vertices %d and %d is %.4g times its goal length; %s",
                      o->moment, name, (int)s->largest_edge[0], (int)s->largest_edge[1], s->largest_edge_ratio, may_help);
}

/* A bit of outcome.told beside those of sn_explosion. */
enum { TOLD_LEAPS = 1 << 16 };

/* Each sign is told once of each muscle, where it shows first: later frames only follow from that one. */
static void check_explosions(outcome *o, const sn_state *state) {
    static const sn_explosion SIGNS[] = {SN_EXPLODED_VOLUME, SN_EXPLODED_EDGE, SN_EXPLODED_SOLVER};
    for (sn_index i = 0; i < o->model->muscle_count; i++) {
        unsigned fresh = sn_explosions(&state->muscles[i].statistics) & ~o->told[i];
        for (size_t k = 0; k < sizeof SIGNS / sizeof *SIGNS; k++)
            if (fresh & SIGNS[k]) tell_explosion(o, state, i, SIGNS[k]);
        o->told[i] |= fresh;
    }
}

static sn_status check_points(outcome *o, const sn_state *state, bool no_state, sn_error *error) {
    for (sn_index i = 0; i < o->model->muscle_count; i++) {
        const sn_statistics *s = &state->muscles[i].statistics;
        if (!(sn_explosions(s) & SN_EXPLODED_POINTS)) continue;
        const char *may_help = help(o, state, i, SN_EXPLODED_POINTS);
        if (o->frame_count == 0)
            return sn_fail(error, SN_ERROR_INPUT, "%s: muscle \"%s\" has %d points that are not finite, point %d first; %s", o->moment,
                           name_of(o, i), (int)s->nan_points, (int)s->first_nan, may_help);
        cli_shortfall(
            o->c, "frame %d: muscle \"%s\" has exploded, %d of its points are not finite, point %d first; the run ends with frame %d%s; %s",
            (int)state->frame, name_of(o, i), (int)s->nan_points, (int)s->first_nan, (int)o->frames[o->frame_count - 1].number,
            no_state ? ", and writes no state" : "", may_help);
        o->told[i] |= SN_EXPLODED_POINTS;
        return SN_STOPPED;
    }
    return SN_OK;
}

sn_status outcome_run_in(void *user, const sn_state *state, double share, sn_error *error) {
    outcome *o = user;
    o->runs_in = true;
    snprintf(o->moment, sizeof o->moment, "the run-in, %.0f %% of the way to frame %d", 100.0 * share, (int)state->frame);
    sn_status status = check_points(o, state, false, error);
    if (status == SN_OK) check_explosions(o, state);
    o->runs_in = false;
    return status;
}

sn_status outcome_check(outcome *o, const sn_state *state, bool no_state, sn_error *error) {
    snprintf(o->moment, sizeof o->moment, "frame %d", (int)state->frame);
    return check_points(o, state, no_state, error);
}

sn_status outcome_overflows(outcome *o, const sn_state *state, sn_index muscle, bool no_state, sn_error *error) {
    static const char what[] = "is farther away than the single precision of a point cache can tell; --format ply can";
    int frame = (int)state->frame;
    if (o->frame_count == 0) return sn_fail(error, SN_ERROR_INPUT, "frame %d: muscle \"%s\" %s", frame, name_of(o, muscle), what);
    cli_shortfall(o->c, "frame %d: muscle \"%s\" %s; the run ends with frame %d%s", frame, name_of(o, muscle), what,
                  (int)o->frames[o->frame_count - 1].number, no_state ? ", and writes no state" : "");
    o->told[muscle] |= SN_EXPLODED_POINTS;
    return SN_STOPPED;
}

/* ---- frame after frame ---------------------------------------------------------------------------------------------------------- */

sn_status outcome_start(outcome *o, const sn_model *model, sn_error *error) {
    o->model = model;
    o->told = SN_NEW(unsigned, model->muscle_count);
    o->last_tear = SN_NEW(sn_index, model->muscle_count);
    if (o->told == NULL || o->last_tear == NULL) return sn_fail_memory(error, "the run");
    for (sn_index i = 0; i < model->muscle_count; i++) o->last_tear[i] = SN_NONE;
    for (int k = 0; k < WORST_COUNT; k++) o->worst[k] = (outcome_worst){NAN, SN_NONE, SN_NONE};
    return SN_OK;
}

/* The first of equal ones stays. */
static void keep_worst(outcome_worst *worst, double value, bool worse, sn_index muscle, sn_index frame) {
    if (isnan(worst->value) ? !isnan(value) : worse) *worst = (outcome_worst){value, muscle, frame};
}

static void compare(outcome *o, const sn_statistics *s, sn_index muscle, sn_index frame) {
    outcome_worst *w = o->worst;
    double iterations = o->model->scene->solver.method == SN_SOLVER_QN ? (double)s->iterations : NAN;
    keep_worst(&w[WORST_VOLUME], s->volume_error, fabs(s->volume_error) > fabs(w[WORST_VOLUME].value), muscle, frame);
    keep_worst(&w[WORST_EDGE], s->largest_edge_ratio, s->largest_edge_ratio > w[WORST_EDGE].value, muscle, frame);
    keep_worst(&w[WORST_TRIANGLE], s->smallest_triangle, s->smallest_triangle < w[WORST_TRIANGLE].value, muscle, frame);
    double depth = s->penetration > 0.0 ? s->penetration : NAN;
    keep_worst(&w[WORST_PENETRATION], depth, depth > w[WORST_PENETRATION].value, muscle, frame);
    keep_worst(&w[WORST_ITERATIONS], iterations, iterations > w[WORST_ITERATIONS].value, muscle, frame);
}

/* A factor of a matrix takes about as long as this many iterations. */
enum { FACTOR_ITERATIONS = 4 };

static double cost_of(const outcome *o, const sn_statistics *s, sn_index muscle) {
    return (double)(s->iterations + FACTOR_ITERATIONS * s->refactorisations) * o->model->muscles[muscle].point_count;
}

/* Who made the frame as long as it is? */
static void find_busiest(const outcome *o, const sn_state *state, outcome_frame *frame) {
    double sum = 0.0, most = 0.0;
    for (sn_index i = 0; i < o->model->muscle_count; i++) {
        const sn_statistics *s = &state->muscles[i].statistics;
        double cost = s->asleep ? 0.0 : cost_of(o, s, i);
        sum += cost;
        if (!(cost > most)) continue;
        most = cost;
        frame->busiest = i;
        frame->work = (outcome_work){s->iterations, s->refactorisations, s->restarts, s->steps, s->halvings, s->torn};
    }
    frame->share = sum > 0.0 ? most / sum : 0.0;
}

static bool add_frame(outcome *o, const sn_state *state, double seconds) {
    if (!sn_grow((void **)&o->frames, &o->frame_room, o->frame_count + 1, sizeof *o->frames)) return false;
    outcome_frame *frame = &o->frames[o->frame_count++];
    *frame = (outcome_frame){.number = state->frame, .seconds = seconds, .busiest = SN_NONE};
    find_busiest(o, state, frame);
    return true;
}

static bool add_tear(outcome *o, sn_index muscle, sn_index frame) {
    sn_index last = o->last_tear[muscle];
    if (last != SN_NONE && o->tears[last].last + 1 >= frame) {
        o->tears[last].last = frame;
        return true;
    }
    if (o->tear_count == SN_INDEX_MAX || !sn_grow((void **)&o->tears, &o->tear_room, o->tear_count + 1, sizeof *o->tears)) return false;
    o->last_tear[muscle] = (sn_index)o->tear_count;
    o->tears[o->tear_count++] = (outcome_tear){muscle, frame, frame};
    return true;
}

/* In the first frame in which a bone is too fast for contact. */
static void check_leaps(outcome *o, const sn_state *state, sn_index muscle) {
    if (state->muscles[muscle].statistics.leaps == 0 || (o->told[muscle] & TOLD_LEAPS)) return;
    o->told[muscle] |= TOLD_LEAPS;
    cli_warn(o->c, "%s: a bone goes too far in the shortest of steps for contact with muscle \"%s\", and may have passed through it",
             o->moment, name_of(o, muscle));
}

sn_status outcome_take(outcome *o, const sn_state *state, double seconds, sn_error *error) {
    bool added = add_frame(o, state, seconds);
    for (sn_index i = 0; added && i < o->model->muscle_count; i++) {
        const sn_statistics *s = &state->muscles[i].statistics;
        if (o->model->muscles[i].source->frozen.sample_count > 0) continue;
        if (s->torn) added = add_tear(o, i, state->frame);
        compare(o, s, i, state->frame);
        check_leaps(o, state, i);
    }
    if (!added) return sn_fail_memory(error, "the figures of the frames");
    check_limits(o, state);
    check_explosions(o, state);
    return SN_OK;
}

/* ---- the end -------------------------------------------------------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median and greatest seconds of the frames that were stepped; how many they are. */
static size_t time_frames(const outcome *o, double *median, double *longest) {
    double *seconds = SN_NEW(double, o->frame_count);
    size_t n = 0;
    *median = *longest = NAN;
    for (size_t i = 0; seconds != NULL && i < o->frame_count; i++)
        if (!isnan(o->frames[i].seconds)) seconds[n++] = o->frames[i].seconds;
    if (n > 0) {
        qsort(seconds, n, sizeof *seconds, compare_numbers);
        *median = seconds[n / 2];
        *longest = seconds[n - 1];
    }
    free(seconds);
    return n;
}

/* "muscle was torn in frames 12-17, 40", as many as there is room for. */
static void say_torn(const outcome *o, sn_index muscle) {
    char text[160] = "";
    size_t used = 0;
    bool several = false;
    for (size_t i = 0; i < o->tear_count; i++) {
        const outcome_tear *tear = &o->tears[i];
        if (tear->muscle != muscle) continue;
        several = several || used > 0 || tear->last > tear->first;
        if (used >= sizeof text - 40) continue;
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%d", used > 0 ? ", " : "", (int)tear->first);
        if (tear->last > tear->first) used += (size_t)snprintf(text + used, sizeof text - used, "-%d", (int)tear->last);
        if (used >= sizeof text - 40) snprintf(text + used, sizeof text - used, ", ...");
    }
    if (used > 0) cli_tell(o->c, "muscle \"%s\" was torn in frame%s %s", name_of(o, muscle), several ? "s" : "", text);
}

/* A frame that takes so many times the median is told of; so many of them at most. */
static const double SLOW = 4.0;
enum { SLOW_FRAMES = 3 };

/* Why the busiest muscle cost so much. */
static void explain(const outcome *o, const outcome_frame *frame, size_t size, char *out) {
    const outcome_work *w = &frame->work;
    const char *name = frame->busiest != SN_NONE ? name_of(o, frame->busiest) : "";
    if (frame->busiest == SN_NONE) /* xpbd does the same in each frame */
        snprintf(out, size, "no muscle did more than in others: the machine was busy");
    else if (w->torn || w->halvings > 0 || w->restarts > 0)
        snprintf(out, size, "muscle \"%s\" %s%s%stook %lld iterations in %lld steps, and %lld factors of its matrix", name,
                 w->torn ? "was torn, " : "", w->halvings > 0 ? "halved its steps, " : "", w->restarts > 0 ? "began anew, " : "",
                 (long long)w->iterations, (long long)w->steps, (long long)w->refactorisations);
    else if (w->refactorisations > 0)
        snprintf(out, size, "muscle \"%s\" factored its matrix anew, for another stiffness", name);
    else
        snprintf(out, size, "muscle \"%s\" did most, %lld iterations; else the machine was busy", name, (long long)w->iterations);
}

static void say_slow(const outcome *o, double median) {
    int told = 0;
    for (size_t i = 0; i < o->frame_count && told < SLOW_FRAMES; i++) {
        const outcome_frame *frame = &o->frames[i];
        char why[320];
        bool first = i < 2 && frame->work.steps <= 1; /* in which every matrix is made */
        if (!(frame->seconds > SLOW * median) || first) continue;
        explain(o, frame, sizeof why, why);
        cli_tell(o->c, "frame %d took %.3g ms, %.1f times the median: %s", (int)frame->number, 1e3 * frame->seconds,
                 frame->seconds / median, why);
        told++;
    }
}

/* Who and when: "(biceps, frame 12)"; nothing where the figure has no value. */
static bool find_worst(const outcome *o, int which, size_t size, char *where) {
    const outcome_worst *w = &o->worst[which];
    if (w->muscle == SN_NONE) return false;
    snprintf(where, size, "muscle \"%s\", frame %d", name_of(o, w->muscle), (int)w->frame);
    return true;
}

void outcome_say(const outcome *o) {
    double median, longest;
    char where[160];
    if (o->model->muscle_count == 0) return;
    size_t stepped = time_frames(o, &median, &longest);
    if (o->frame_count > 0 && stepped == 0) cli_tell(o->c, "1 frame");
    if (stepped > 0) cli_tell(o->c, "%d frame%s, %.3g ms each (median)", (int)o->frame_count, o->frame_count == 1 ? "" : "s", 1e3 * median);
    double volume = o->worst[WORST_VOLUME].value;
    if (find_worst(o, WORST_VOLUME, sizeof where, where) && fabs(volume) < 1.0)
        cli_tell(o->c, "volume farthest from its goal: %+.2g %% (%s)", 100.0 * volume, where);
    else if (!isnan(volume))
        cli_tell(o->c, "volume farthest from its goal: %.4g times it (%s)", 1.0 + volume, where);
    if (find_worst(o, WORST_EDGE, sizeof where, where))
        cli_tell(o->c, "longest edge: %.4g times its goal length (%s)", o->worst[WORST_EDGE].value, where);
    if (find_worst(o, WORST_TRIANGLE, sizeof where, where))
        cli_tell(o->c, "smallest triangle: %.2g of its rest area (%s)", o->worst[WORST_TRIANGLE].value, where);
    if (find_worst(o, WORST_PENETRATION, sizeof where, where))
        cli_tell(o->c, "deepest in a bone, beyond its rest: %.3g mm (%s)", 1e3 * o->worst[WORST_PENETRATION].value, where);
    if (find_worst(o, WORST_ITERATIONS, sizeof where, where) && o->worst[WORST_ITERATIONS].value > 0.0)
        cli_tell(o->c, "most iterations in a frame: %.0f (%s)", o->worst[WORST_ITERATIONS].value, where);
    for (sn_index i = 0; i < o->model->muscle_count; i++) say_torn(o, i);
    say_slow(o, median);
}

/* ---- the report ----------------------------------------------------------------------------------------------------------------- */

static void report_worst(const outcome *o, int which, const char *name, sn_json *json) {
    const outcome_worst *w = &o->worst[which];
    if (w->muscle == SN_NONE) return;
    sn_json_object(json, name);
    sn_json_number(json, "value", w->value);
    sn_json_text(json, "muscle", name_of(o, w->muscle));
    sn_json_integer(json, "frame", w->frame);
    sn_json_close(json);
}

static void report_torn(const outcome *o, sn_index muscle, sn_json *json) {
    if (o->last_tear[muscle] == SN_NONE) return;
    sn_json_object(json, NULL);
    sn_json_text(json, "muscle", name_of(o, muscle));
    sn_json_array(json, "frames");
    for (size_t i = 0; i < o->tear_count; i++)
        if (o->tears[i].muscle == muscle) sn_json_indices(json, NULL, (const sn_index[]){o->tears[i].first, o->tears[i].last}, 2);
    sn_json_close(json);
    sn_json_close(json);
}

static void report_exploded(const outcome *o, sn_index muscle, sn_json *json) {
    static const char *const NAMES[] = {"points", "volume", "edge", "solver"}; /* in the order of the bits of sn_explosion */
    if (o->told[muscle] == 0) return;
    sn_json_object(json, NULL);
    sn_json_text(json, "muscle", name_of(o, muscle));
    sn_json_array(json, "signs");
    for (int k = 0; k < 4; k++)
        if (o->told[muscle] & 1u << k) sn_json_text(json, NULL, NAMES[k]);
    sn_json_close(json);
    sn_json_close(json);
}

void outcome_report(const outcome *o, sn_json *json) {
    double median, longest;
    size_t stepped = time_frames(o, &median, &longest);
    sn_json_integer(json, "frames", (int64_t)o->frame_count);
    sn_json_integer(json, "steppedFrames", (int64_t)stepped);
    if (stepped > 0) {
        sn_json_number(json, "medianFrameSeconds", median);
        sn_json_number(json, "longestFrameSeconds", longest);
    }
    sn_json_object(json, "outcome");
    report_worst(o, WORST_VOLUME, "volumeError", json);
    report_worst(o, WORST_EDGE, "largestEdgeRatio", json);
    report_worst(o, WORST_TRIANGLE, "smallestTriangle", json);
    report_worst(o, WORST_PENETRATION, "penetration", json);
    report_worst(o, WORST_ITERATIONS, "mostIterations", json);
    sn_json_array(json, "torn");
    for (sn_index i = 0; i < o->model->muscle_count; i++) report_torn(o, i, json);
    sn_json_close(json);
    sn_json_array(json, "exploded");
    for (sn_index i = 0; i < o->model->muscle_count; i++) report_exploded(o, i, json);
    sn_json_close(json);
    sn_json_close(json);
}

void outcome_free(outcome *o) {
    free(o->frames);
    free(o->tears);
    free(o->last_tear);
    free(o->told);
}
