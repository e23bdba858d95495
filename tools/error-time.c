/*
 * error-time -- run a scene under many solver settings, and draw what error each of them leaves for the time that it takes.
 */
#include "chart.h"
#include "cli.h"
#include "sinew/error_time.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- options -------------------------------------------------------------------------------------------------------------- */

/* The settings of the default sweeps. */
static const char *const QUICK =
    "xpbd substeps=1 iterations=16\nxpbd substeps=4 iterations=4\nxpbd substeps=16 iterations=1\n"
    "xpbd substeps=16 iterations=2\nxpbd substeps=64 iterations=1\nxpbd substeps=256 iterations=1\n"
    "qn substeps=1 iterations=3\nqn substeps=1 iterations=5\nqn substeps=1 iterations=10\n"
    "qn substeps=2 iterations=5\nqn substeps=4 iterations=5\nqn substeps=8 iterations=5\n"
    "qn substeps=1 iterations=3 preconditioner=corotated\nqn substeps=1 iterations=5 preconditioner=corotated\n"
    "qn substeps=1 iterations=10 preconditioner=corotated\nqn substeps=2 iterations=5 preconditioner=corotated\n"
    "qn substeps=4 iterations=5 preconditioner=corotated\n"
    "qn substeps=1 iterations=3 preconditioner=two-level\nqn substeps=1 iterations=5 preconditioner=two-level\n"
    "qn substeps=1 iterations=10 preconditioner=two-level\nqn substeps=2 iterations=5 preconditioner=two-level\n";
static const char *const FULL =
    "xpbd substeps=1 iterations=4\nxpbd substeps=1 iterations=16\nxpbd substeps=1 iterations=64\nxpbd substeps=1 iterations=256\n"
    "xpbd substeps=4 iterations=1\nxpbd substeps=4 iterations=4\nxpbd substeps=4 iterations=16\nxpbd substeps=4 iterations=64\n"
    "xpbd substeps=16 iterations=1\nxpbd substeps=16 iterations=2\nxpbd substeps=16 iterations=4\nxpbd substeps=16 iterations=16\n"
    "xpbd substeps=64 iterations=1\nxpbd substeps=64 iterations=2\nxpbd substeps=64 iterations=4\n"
    "xpbd substeps=256 iterations=1\nxpbd substeps=320 iterations=1\nxpbd substeps=256 iterations=2\n"
    "xpbd substeps=512 iterations=1\nxpbd substeps=1024 iterations=1\n"
    "qn substeps=1 iterations=2\nqn substeps=1 iterations=3\nqn substeps=1 iterations=5\nqn substeps=1 iterations=10\n"
    "qn substeps=1 iterations=20\nqn substeps=2 iterations=3\nqn substeps=2 iterations=5\nqn substeps=2 iterations=10\n"
    "qn substeps=2 iterations=20\nqn substeps=4 iterations=3\nqn substeps=4 iterations=5\nqn substeps=4 iterations=10\n"
    "qn substeps=8 iterations=3\nqn substeps=8 iterations=5\nqn substeps=8 iterations=10\nqn substeps=16 iterations=3\n"
    "qn substeps=16 iterations=5\nqn substeps=32 iterations=3\nqn substeps=32 iterations=5\n"
    "qn substeps=1 iterations=3 preconditioner=corotated\nqn substeps=1 iterations=5 preconditioner=corotated\n"
    "qn substeps=1 iterations=10 preconditioner=corotated\nqn substeps=2 iterations=5 preconditioner=corotated\n"
    "qn substeps=4 iterations=5 preconditioner=corotated\n"
    "qn substeps=1 iterations=3 preconditioner=two-level\nqn substeps=1 iterations=5 preconditioner=two-level\n"
    "qn substeps=1 iterations=10 preconditioner=two-level\nqn substeps=2 iterations=5 preconditioner=two-level\n"
    "qn substeps=4 iterations=5 preconditioner=two-level\n"
    "xpbd substeps=16 iterations=1 precision=single\nxpbd substeps=16 iterations=4 precision=single\n"
    "xpbd substeps=64 iterations=1 precision=single\nxpbd substeps=64 iterations=4 precision=single\n"
    "xpbd substeps=256 iterations=1 precision=single\nxpbd substeps=320 iterations=1 precision=single\nxpbd substeps=256 iterations=2 "
    "precision=single\n";

enum { SWEEP_QUICK, SWEEP_FULL };
static const char *const SWEEPS[] = {"quick", "full", NULL};

typedef struct choices {
    const char *settings, *frames, *title;
    int64_t runs, threads, reference, hold;
    double floor, most_seconds;
    int sweep, stretch;
    bool equilibrium;
} choices;

static choices given = {.runs = 5, .threads = 1, .reference = 64, .hold = 256, .floor = 1e-5, .most_seconds = 60.0};

static const cli_option OPTIONS[] = {
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "What is measured:"},
    {0, "settings", "FILE", CLI_TEXT, &given.settings, CLI_READS, 0, 0, NULL, "settings, one a line: \"qn substeps=2 iterations=5\""},
    {0, "sweep", "HOW", CLI_CHOICE, &given.sweep, 0, 0, 0, SWEEPS,
     "the built-in settings instead: quick (default; 21 of them) or full (56)"},
    {0, "static", NULL, CLI_FLAG, &given.equilibrium, 0, 0, 0, NULL,
     "hold the last frame until the muscles rest: distance to the equilibrium"},
    {0, "hold", "N", CLI_INTEGER, &given.hold, 0, 1, 1e6, NULL, "static: hold it so many frames at most (default 256)"},
    {0, "frames", "A:B", CLI_TEXT, &given.frames, 0, 0, 0, NULL, "frames A to B instead of the scene's"},
    {0, "stretch", "MODEL", CLI_CHOICE, &given.stretch, 0, 0, 0, sn_stretch_names,
     "what resists the stretching of all surfaces, for the settings and their reference: springs, or (qn) a membrane"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "How it is measured:"},
    {0, "runs", "N", CLI_INTEGER, &given.runs, 0, 1, 1000, NULL, "run each setting so often, and take the median of the times (default 5)"},
    {0, "most-seconds", "S", CLI_NUMBER, &given.most_seconds, 0, 1e-3, 1e9, NULL,
     "end a setting after so much processor time, all of its runs together (default 60)"},
    {0, "reference", "N", CLI_INTEGER, &given.reference, 0, 4, 65536, NULL, "the reference has at most so many substeps (default 64)"},
    {0, "floor", "SHARE", CLI_NUMBER, &given.floor, 0, 0, 1, NULL,
     "and fewer where its uncertainty is not above this share of the diagonal (default 1e-5)"},
    {0, "threads", "N", CLI_INTEGER, &given.threads, 0, 1, 1024, NULL, "use N threads (default 1): muscles run side by side"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "Output:"},
    {0, "title", "TEXT", CLI_TEXT, &given.title, 0, 0, 0, NULL, "title of the chart (default: the scene's name)"},
};

static const cli_tool TOOL = {
    .name = "error-time",
    .summary = "Measure the error of solver settings on a scene against the time that they take.",
    .shared = CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_SPACE,
    .options = OPTIONS,
    .option_count = sizeof OPTIONS / sizeof *OPTIONS,
    .notes = "-o FOLDER gets error-time.tsv, .json, .dat, .svg and .png; without it the table goes to standard output.\n"
             "A chart needs gnuplot.",
};

/* ---- the job -------------------------------------------------------------------------------------------------------------- */

typedef struct job {
    cli c;
    sn_scene scene;
    sn_setting *settings; /* (report.setting_count) */
    sn_yardstick yardstick;
    sn_pool *pool;
    sn_run_request request;
    sn_reference_params params;
    sn_error_time report;
    size_t point_capacity;
} job;

static sn_status make_folder(const char *path, sn_error *error) {
    struct stat status;
    if ((stat(path, &status) == 0 && S_ISDIR(status.st_mode)) || mkdir(path, 0777) == 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot make this folder: %s", strerror(errno));
}

/* ---- the scene and the settings --------------------------------------------------------------------------------------------- */

static void apply_frames(job *j) {
    const char *text = given.frames, *end = text != NULL ? text + strlen(text) : NULL;
    int64_t a = 0, b = 0;
    if (text == NULL) return;
    bool good = sn_scan_integer(text, end, &text, &a) && *text == ':' && sn_scan_integer(text + 1, end, &text, &b) && text == end;
    if (!good || a > b) cli_usage_error(&j->c, "--frames %s: write A:B with A not greater than B", given.frames);
    if (a < -SN_FRAME_LIMIT || b > SN_FRAME_LIMIT)
        cli_usage_error(&j->c, "--frames %s: frames go from %d to %d", given.frames, -SN_FRAME_LIMIT, SN_FRAME_LIMIT);
    j->scene.first_frame = (sn_index)a;
    j->scene.last_frame = (sn_index)b;
}

static sn_status load_scene(job *j, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(j->c.inputs.items[0], &blob, error);
    if (status != SN_OK) return status;
    sn_hash(blob.data, blob.size, j->report.scene_hash);
    status = sn_scene_parse(&blob, false, &j->scene, error);
    if (status == SN_OK) status = sn_scene_check_bones(blob.name, &j->scene, error);
    if (status == SN_OK) {
        apply_frames(j);
        j->scene.solver.threads = (int)given.threads;
        for (sn_index i = 0; cli_given(&j->c, "stretch") && i < j->scene.muscle_count; i++)
            j->scene.muscles[i].stretch = (sn_stretch)given.stretch;
        if (j->scene.last_frame - j->scene.first_frame < 1)
            status = sn_fail(error, SN_ERROR_INPUT, "the scene has one frame: there is no motion to measure; give it more with \"frames\"");
    }
    if (status != SN_OK) sn_error_set_file(error, blob.name);
    sn_blob_free(&blob);
    return status;
}

static sn_status load_settings(job *j, sn_error *error) {
    sn_index *count = &j->report.setting_count;
    sn_blob blob = {0};
    if (given.settings == NULL) {
        const char *text = given.sweep == SWEEP_FULL ? FULL : QUICK;
        return sn_settings_parse(text, strlen(text), &j->settings, count, error);
    }
    sn_status status = sn_blob_read(given.settings, &blob, error);
    if (status == SN_OK) status = sn_settings_parse(blob.data, blob.size, &j->settings, count, error);
    if (status != SN_OK) sn_error_set_file(error, given.settings);
    sn_blob_free(&blob);
    return status;
}

/* Whether the setting asks for the corotated matrix. */
static bool goes_corotated(job *j, const sn_setting *setting) {
    sn_setting_apply(setting, &j->scene);
    return j->scene.solver.method == SN_SOLVER_QN && j->scene.solver.preconditioner == SN_PRECONDITION_COROTATED;
}

/* Tied muscles go by the scalar matrix, whatever a setting asks for: the corotated one would be measured a second time as another. */
static sn_status leave_out_corotated(job *j, sn_error *error) {
    sn_index kept = 0, *count = &j->report.setting_count, given_count = *count;
    for (sn_index i = 0; i < given_count; i++)
        if (!goes_corotated(j, &j->settings[i])) j->settings[kept++] = j->settings[i];
    *count = kept;
    if (kept == 0)
        return sn_fail(error, SN_ERROR_INPUT,
                       "all settings ask for the corotated matrix, which muscles that are tied to each other do not go by");
    if (given.settings != NULL && kept < given_count)
        cli_warn(&j->c, "muscles that are tied to each other go by the scalar matrix: %d settings with the corotated one are left out",
                 (int)(given_count - kept));
    return SN_OK;
}

/* The names, and the masses that differences are weighted with: those of the reference's model. */
static sn_status describe_scene(job *j, sn_error *error) {
    sn_error_time *r = &j->report;
    sn_model *model = NULL;
    sn_setting_apply(&(sn_setting){.method = SN_SOLVER_QN}, &j->scene);
    sn_status status = sn_model_create(&j->scene, &model, error);
    if (status != SN_OK) sn_error_set_file(error, j->c.inputs.items[0]);
    if (status == SN_OK && model->muscle_count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, j->c.inputs.items[0], 0, "the scene has no muscle that is enabled");
    if (status == SN_OK) status = sn_yardstick_create(model, &j->yardstick, error);
    sn_index count = status == SN_OK ? model->muscle_count : 0;
    r->muscle_names = SN_NEW(char *, count);
    r->muscle_vertices = SN_NEW(sn_index, count);
    if (status == SN_OK && (r->muscle_names == NULL || r->muscle_vertices == NULL)) status = sn_fail_memory(error, "the report");
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        r->muscle_count = i + 1;
        r->muscle_names[i] = sn_strdup(model->muscles[i].source->name);
        r->muscle_vertices[i] = model->muscles[i].vertex_count;
        if (r->muscle_names[i] == NULL) status = sn_fail_memory(error, "the report");
    }
    if (status == SN_OK && sn_model_tied(model)) status = leave_out_corotated(j, error);
    r->scene_name = sn_strdup(j->scene.name);
    r->equilibrium = given.equilibrium;
    r->first_frame = j->scene.first_frame;
    r->last_frame = j->scene.last_frame;
    r->rate = j->scene.rate;
    r->threads = (int)given.threads;
    sn_model_destroy(model);
    return status;
}

/* A quarter, half, three quarters and all of the motion; or its end, and after 1, 2, 4, ... held frames. */
static sn_status choose_moments(job *j, sn_error *error) {
    sn_index frames = j->scene.last_frame - j->scene.first_frame, n = 0;
    sn_index *moments = j->report.moments = SN_NEW(sn_index, 40);
    if (moments == NULL) return sn_fail_memory(error, "the report");
    for (int quarter = 1; !given.equilibrium && quarter <= 4; quarter++) {
        sn_index moment = (sn_index)lround(frames * 0.25 * quarter);
        if (moment > 0 && (n == 0 || moment > moments[n - 1])) moments[n++] = moment;
    }
    if (given.equilibrium) moments[n++] = frames;
    for (int64_t held = 1; given.equilibrium && held < given.hold; held *= 2) moments[n++] = frames + (sn_index)held;
    if (given.equilibrium) moments[n++] = frames + (sn_index)given.hold;
    j->report.moment_count = n;
    j->request = (sn_run_request){
        .moments = moments, .moment_count = n, .rest = given.equilibrium ? 1e-10 : 0.0, .most_seconds = INFINITY, .pool = j->pool};
    return SN_OK;
}

/* ---- the reference --------------------------------------------------------------------------------------------------------- */

static void say_reference(const job *j) {
    const sn_reference *r = &j->report.reference;
    sn_index unconverged = 0;
    for (sn_index i = 0; i < r->rung_count; i++) unconverged += r->rungs[i].unconverged;
    cli_say(&j->c, "reference: qn, %d substeps%s; floor %.2g L", (int)r->rungs[r->rung_count - 1].substeps,
            r->extrapolated ? ", extrapolated to h = 0" : "", r->floor);
    if (unconverged > 0)
        cli_warn(&j->c, "%d solves of the reference ended before they converged: its floor says what that is worth", (int)unconverged);
    if (isfinite(r->fitted)) cli_say(&j->c, "observed order of converged solves: %.2f (%d step sizes)", r->fitted, (int)r->fitted_rungs);
    if (!given.equilibrium && r->floor > given.floor)
        cli_warn(&j->c, "the reference's floor is %.2g L, above %.2g; --reference with more substeps may lower it", r->floor, given.floor);
}

static sn_status make_reference(job *j, sn_error *error) {
    sn_reference *r = &j->report.reference;
    j->params = sn_reference_defaults();
    j->params.floor = given.floor;
    j->params.most_substeps = (sn_index)given.reference;
    /* a step solved to a tolerance t is off by about t itself (measured: 5e-8 L for 1e-7), so that a hundredth of the floor is enough;
     * an equilibrium is crept up to by many steps */
    j->params.tolerance = fmax(j->params.tolerance, fmin((given.equilibrium ? 1e-4 : 1e-2) * given.floor, 1e-5));
    j->params.rest = fmax(j->params.rest, 1e-2 * j->params.tolerance);
    const sn_reference_task task = {&j->scene, &j->yardstick, &j->request, &j->params};
    sn_status status = given.equilibrium ? sn_reference_rest(&task, r, error) : sn_reference_motion(&task, r, error);
    if (status == SN_OK) say_reference(j);
    return status;
}

/* ---- one setting ------------------------------------------------------------------------------------------------------------ */

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, sn_index count) {
    qsort(values, (size_t)count, sizeof *values, compare_numbers);
    return count % 2 == 1 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

/* The runs of one setting: the first one's figures, the times of all. */
typedef struct repeated {
    sn_run_result first;
    sn_index runs;
    double *cpu, *wall; /* (runs x moments) */
    double *setup;      /* (runs) */
} repeated;

static void free_repeated(repeated *r) {
    sn_run_free(&r->first);
    free(r->cpu);
    free(r->wall);
    free(r->setup);
}

static void keep_times(const job *j, repeated *r, const sn_run_result *run) {
    size_t at = (size_t)r->runs * (size_t)j->request.moment_count, bytes = (size_t)run->track.moment_count * sizeof *r->cpu;
    memcpy(r->cpu + at, run->cpu, bytes);
    memcpy(r->wall + at, run->wall, bytes);
    r->setup[r->runs++] = run->setup;
}

/* Again and again, as often as asked for, or as long as there is time. */
static sn_status run_again(job *j, repeated *r, sn_error *error) {
    sn_index moments = r->first.track.moment_count;
    double each = moments > 0 ? r->first.cpu[moments - 1] : INFINITY;
    sn_status status = SN_OK;
    while (status == SN_OK && r->runs < given.runs && (r->runs + 1) * each <= given.most_seconds) {
        sn_run_result run;
        status = sn_run_timed(&j->scene, &j->request, &run, error);
        if (status == SN_OK && run.track.moment_count == moments) keep_times(j, r, &run);
        if (status == SN_OK && run.track.moment_count != moments) each = INFINITY; /* out of time */
        if (status == SN_OK) sn_run_free(&run);
    }
    return status;
}

static sn_status run_setting(job *j, repeated *r, sn_error *error) {
    size_t moments = (size_t)j->request.moment_count;
    *r = (repeated){.cpu = SN_NEW(double, moments *(size_t)given.runs),
                    .wall = SN_NEW(double, moments *(size_t)given.runs),
                    .setup = SN_NEW(double, given.runs)};
    if (r->cpu == NULL || r->wall == NULL || r->setup == NULL) return sn_fail_memory(error, "the times");
    j->request.most_seconds = given.most_seconds;
    sn_status status = sn_run_timed(&j->scene, &j->request, &r->first, error);
    if (status != SN_OK) return status;
    keep_times(j, r, &r->first);
    return run_again(j, r, error);
}

static double median_time(const job *j, const repeated *r, const double *times, sn_index moment, double *scratch) {
    for (sn_index i = 0; i < r->runs; i++) scratch[i] = times[(size_t)i * (size_t)j->request.moment_count + (size_t)moment];
    return median(scratch, r->runs);
}

static sn_status add_point(job *j, const sn_error_point *point, sn_error *error) {
    sn_error_time *report = &j->report;
    if (!sn_grow((void **)&report->points, &j->point_capacity, (size_t)report->point_count + 1, sizeof *report->points))
        return sn_fail_memory(error, "the report");
    report->points[report->point_count++] = *point;
    return SN_OK;
}

/* Against h -> 0, and under qn against a converged solve of the same steps. */
static sn_status add_motion_point(job *j, const repeated *r, sn_index setting, sn_error *error) {
    sn_measured_setting *s = &j->report.settings[setting];
    const sn_track *track = &r->first.track;
    sn_index moments = track->moment_count;
    double scratch[1000];
    sn_error_point p = {.setting = setting,
                        .total = {NAN, NAN, NAN, SN_NONE, SN_NONE},
                        .solver = {NAN, NAN, NAN, SN_NONE, SN_NONE},
                        .cpu = NAN,
                        .wall = NAN};
    if (moments < j->request.moment_count) return add_point(j, &p, error); /* over time, or no longer finite */
    p.cpu = median_time(j, r, r->cpu, moments - 1, scratch);
    p.wall = median_time(j, r, r->wall, moments - 1, scratch);
    p.total = sn_difference_between(&j->yardstick, moments, track->positions, j->report.reference.track.positions, s->muscle_errors);
    if (s->setting.method == SN_SOLVER_QN) {
        const sn_rung *rung;
        sn_run_request request = j->request;
        request.most_seconds = INFINITY;
        const sn_reference_task task = {&j->scene, &j->yardstick, &request, &j->params};
        sn_status status = sn_reference_solve(&task, sn_solver_substeps(&j->scene.solver), &j->report.reference, &rung, error);
        if (status != SN_OK) return status;
        p.solver = sn_difference_between(&j->yardstick, moments, track->positions, rung->track.positions, NULL);
        s->solved_strain = rung->strain;
    }
    return add_point(j, &p, error);
}

/* One for each moment of the hold. */
static sn_status add_rest_points(job *j, const repeated *r, sn_index setting, sn_error *error) {
    const sn_track *track = &r->first.track;
    sn_index frames = j->report.last_frame - j->report.first_frame;
    sn_status status = SN_OK;
    double scratch[1000];
    for (sn_index k = 0; status == SN_OK && k < track->moment_count; k++) {
        sn_error_point p = {.setting = setting, .held = r->first.moments[k] - frames, .solver = {NAN, NAN, NAN}};
        p.cpu = median_time(j, r, r->cpu, k, scratch);
        p.wall = median_time(j, r, r->wall, k, scratch);
        p.total = sn_difference_between(&j->yardstick, 1, track->positions + (size_t)k * (size_t)track->point_count,
                                        j->report.reference.track.positions, j->report.settings[setting].muscle_errors);
        status = add_point(j, &p, error);
    }
    return status;
}

static void keep_figures(sn_measured_setting *s, repeated *r) {
    s->runs = r->runs;
    s->setup = median(r->setup, r->runs);
    s->over_time = r->first.over_time;
    s->frames = r->first.frames;
    s->iterations = r->first.iterations;
    s->rejected_steps = r->first.rejected_steps;
    s->refactorisations = r->first.refactorisations;
    s->restarts = r->first.restarts;
    s->unconverged = r->first.unconverged;
    s->nan_points = r->first.nan_points;
    s->residual = r->first.residual;
    s->elastic_energy = r->first.elastic_energy;
    s->strain = r->first.strain;
    s->solved_strain = NAN;
}

static void say_setting(const job *j, sn_index setting) {
    const sn_measured_setting *s = &j->report.settings[setting];
    const sn_error_point *last = j->report.point_count > 0 ? &j->report.points[j->report.point_count - 1] : NULL;
    char words[SN_SETTING_LENGTH + 128], name[SN_SETTING_LENGTH];
    sn_setting_format(&s->setting, name);
    if (s->nan_points > 0)
        cli_warn(&j->c, "%s: %d points are no longer finite after %d frames", name, (int)s->nan_points, (int)s->frames);
    else if (s->over_time)
        cli_warn(&j->c, "%s: not done after %g s of processor time, at frame %d; --most-seconds allows more", name, given.most_seconds,
                 (int)s->frames);
    if (last == NULL || last->setting != setting || !isfinite(last->total.worst)) return;
    sn_error_time_words(&j->report, last, sizeof words, words);
    cli_say(&j->c, "%s", words);
}

static sn_status measure_setting(job *j, sn_index setting, sn_error *error) {
    sn_measured_setting *s = &j->report.settings[setting];
    repeated r;
    s->setting = j->settings[setting];
    if ((s->muscle_errors = SN_NEW(double, j->yardstick.muscle_count)) == NULL) return sn_fail_memory(error, "the report");
    sn_setting_apply(&s->setting, &j->scene);
    sn_status status = run_setting(j, &r, error);
    if (status == SN_OK) keep_figures(s, &r);
    if (status == SN_OK) status = given.equilibrium ? add_rest_points(j, &r, setting, error) : add_motion_point(j, &r, setting, error);
    free_repeated(&r);
    if (status == SN_OK) say_setting(j, setting);
    return status;
}

static sn_status measure_settings(job *j, sn_error *error) {
    sn_status status = SN_OK;
    j->report.settings = SN_NEW(sn_measured_setting, j->report.setting_count);
    if (j->report.settings == NULL) return sn_fail_memory(error, "the report");
    for (sn_index i = 0; status == SN_OK && i < j->report.setting_count; i++) {
        cli_progress(&j->c, i, j->report.setting_count, "setting");
        status = measure_setting(j, i, error);
    }
    return status == SN_OK ? sn_error_time_judge(&j->report, error) : status;
}

/* ---- output ------------------------------------------------------------------------------------------------------------------- */

/* Who writes a file of the folder. */
typedef sn_status (*writer)(job *j, sn_output *output, sn_error *error);

static sn_index family_count; /* what write_chart found, for the plot */

static sn_status write_table(job *j, sn_output *output, sn_error *error) {
    (void)error; /* commit returns it */
    return sn_error_time_write_table(&j->report, output);
}
static sn_status write_report(job *j, sn_output *output, sn_error *error) { return sn_error_time_write(&j->report, output, error); }
static sn_status write_chart(job *j, sn_output *output, sn_error *error) {
    return sn_error_time_write_chart(&j->report, output, &family_count, error);
}

static sn_status write_file(job *j, const char *path, writer write, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = write(j, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status name_file(const job *j, const char *extension, size_t size, char *path, sn_error *error) {
    if (snprintf(path, size, "%s/error-time.%s", j->c.output, extension) < (int)size) return SN_OK;
    return sn_fail(error, SN_ERROR_USAGE, "the name of the folder is too long; choose a shorter one");
}

static sn_status draw_chart(job *j, const char *data, sn_error *error) {
    char svg[4096], png[4096], floor[48], families[16];
    const char *title = given.title != NULL ? given.title : j->scene.name != NULL ? j->scene.name : "error against run time";
    sn_status status = name_file(j, "svg", sizeof svg, svg, error);
    if (status == SN_OK) status = name_file(j, "png", sizeof png, png, error);
    if (status != SN_OK) return status;
    snprintf(floor, sizeof floor, "%.17g", j->report.reference.floor);
    snprintf(families, sizeof families, "%d", (int)family_count);
    bool solver = false;
    for (sn_index i = 0; i < j->report.point_count; i++) solver = solver || isfinite(j->report.points[i].solver.worst);
    const char *const arguments[] = {
        data, svg, png, title, floor, families, solver ? "1" : "0", given.equilibrium ? "equilibrium" : "motion", NULL};
    chart_draw(&j->c, "error-time.gp", arguments);
    return SN_OK;
}

static sn_status write_folder(job *j, sn_error *error) {
    static const struct {
        const char *extension;
        writer write;
    } files[] = {{"tsv", write_table}, {"json", write_report}, {"dat", write_chart}};
    char path[4096];
    sn_status status = SN_OK;
    for (size_t i = 0; status == SN_OK && i < sizeof files / sizeof *files; i++) {
        status = name_file(j, files[i].extension, sizeof path, path, error);
        if (status == SN_OK) status = write_file(j, path, files[i].write, error);
    }
    return status == SN_OK ? draw_chart(j, path, error) : status;
}

/* The front from the fastest to the most exact. */
static void say_front(const job *j) {
    const sn_error_time *r = &j->report;
    char words[SN_SETTING_LENGTH + 128];
    double after = -1.0;
    for (;;) {
        const sn_error_point *next = NULL;
        for (sn_index i = 0; i < r->point_count; i++)
            if (r->points[i].front && r->points[i].cpu > after && (next == NULL || r->points[i].cpu < next->cpu)) next = &r->points[i];
        if (next == NULL) return;
        sn_error_time_words(r, next, sizeof words, words);
        cli_say(&j->c, "on the Pareto front: %s", words);
        after = next->cpu;
    }
}

static sn_status work(job *j, sn_error *error) {
    bool folder = cli_given(&j->c, "output") && strcmp(j->c.output, "-") != 0;
    sn_status status = load_settings(j, error);
    if (status == SN_OK) status = load_scene(j, error);
    if (status == SN_OK) status = describe_scene(j, error);
    if (status == SN_OK && given.threads > 1 && (j->pool = sn_pool_create((int)given.threads)) == NULL)
        status = sn_fail_memory(error, "the threads");
    if (status == SN_OK) status = choose_moments(j, error);
    if (status == SN_OK && folder) status = make_folder(j->c.output, error);
    if (status == SN_OK) status = make_reference(j, error);
    if (status == SN_OK) status = measure_settings(j, error);
    if (status != SN_OK) return status;
    say_front(j);
    return folder ? write_folder(j, error) : write_file(j, "-", write_table, error);
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &TOOL, argc, argv);
    if (given.settings != NULL && cli_given(&j.c, "sweep")) cli_usage_error(&j.c, "--settings and --sweep exclude each other");
    sn_status status = work(&j, &error);
    sn_error_time_free(&j.report);
    sn_yardstick_free(&j.yardstick);
    sn_pool_destroy(j.pool);
    sn_scene_free(&j.scene);
    free(j.settings);
    return cli_finish(&j.c, status, &error);
}
