/*
 * error_time_document.c -- what error-time measured, as a table, as a report, as data for a chart, and the report read again.
 */
#include "json.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/error_time.h"

static const char *const ERRORS[] = {"motion", "equilibrium", NULL}; /* sn_error_time.equilibrium */
enum { MOST_MUSCLES = 1 << 16, MOST_SETTINGS = 1 << 16, MOST_POINTS = 1 << 20 };

/* ---- the table ------------------------------------------------------------------------------------------------------------------- */

static const char *verdict_of(const sn_error_point *p) {
    if (!isfinite(p->total.worst)) return "failed";
    return p->front ? "front" : p->claimed ? "good" : "floor";
}

static void write_row(const sn_error_time *report, const sn_error_point *p, sn_output *output) {
    const sn_measured_setting *s = &report->settings[p->setting];
    char setting[SN_SETTING_LENGTH], family[SN_SETTING_LENGTH];
    int frames = (int)report->last_frame - (int)report->first_frame + (int)p->held;
    sn_setting_format(&s->setting, setting);
    sn_setting_family(&s->setting, family);
    sn_output_print(output, "%s\t%s\t%d\t%.4g\t%.4g\t%.4g\t%.4g\t", setting, family, (int)p->held, p->total.worst, p->total.scene,
                    p->total.most, p->solver.worst);
    sn_output_print(output, "%.4g\t%.4g\t%.4g\t%.4g\t%d\t", p->cpu, p->wall, 1e3 * p->cpu / frames, s->setup, (int)s->runs);
    sn_output_print(output, "%.2f\t%.3g\t%.4g\t%.4g\t%.4g\t%s\n", (double)s->iterations / (s->frames > 0 ? s->frames : 1), s->residual,
                    s->elastic_energy, s->strain, s->solved_strain, verdict_of(p));
}

sn_status sn_error_time_write_table(const sn_error_time *report, sn_output *output) {
    sn_status status = sn_output_print(
        output, "setting\tfamily\theld\ttotal_error\tscene_error\tfarthest_error\tsolver_error\tcpu_s\twall_s\t"
                "cpu_ms_per_frame\tsetup_s\truns\titerations_per_frame\tresidual\telastic_J\tlargest_strain\tsolved_strain\tverdict\n");
    for (sn_index i = 0; i < report->point_count; i++) write_row(report, &report->points[i], output);
    return status;
}

/* ---- data for a chart -------------------------------------------------------------------------------------------------------------- */

/* Which of a block's points there are. */
typedef enum block { CLAIMED, TOTAL_FRONT, SOLVER_FRONT, DROPPED } block;

/* Times and errors of all points; infinite where the block does not show one. */
typedef struct shown {
    double *seconds, *errors; /* (point_count) */
    bool *wanted;             /* (point_count) */
} shown;

static void free_shown(shown *s) {
    free(s->seconds);
    free(s->errors);
    free(s->wanted);
}

static bool in_block(const sn_error_time *report, const sn_error_point *p, const char *family, block what) {
    char name[SN_SETTING_LENGTH];
    sn_setting_family(&report->settings[p->setting].setting, name);
    if (family != NULL && strcmp(name, family) != 0) return false;
    return what == DROPPED ? !p->claimed : what == SOLVER_FRONT || p->claimed;
}

static sn_status choose_shown(const sn_error_time *report, const char *family, block what, shown *s, sn_error *error) {
    sn_index n = report->point_count;
    *s = (shown){SN_NEW(double, n), SN_NEW(double, n), SN_NEW(bool, n)};
    if (s->seconds == NULL || s->errors == NULL || s->wanted == NULL) return sn_fail_memory(error, "the chart");
    for (sn_index i = 0; i < n; i++) {
        const sn_error_point *p = &report->points[i];
        s->seconds[i] = p->cpu;
        s->errors[i] = !in_block(report, p, family, what) ? INFINITY : what == SOLVER_FRONT ? p->solver.worst : p->total.worst;
        s->wanted[i] = isfinite(s->errors[i]);
    }
    if (what == TOTAL_FRONT || what == SOLVER_FRONT) sn_pareto_front(n, s->seconds, s->errors, s->wanted);
    return SN_OK;
}

/* The next wanted point in order of time, no longer wanted; SN_NONE = there is none. */
static sn_index take_next(shown *s, sn_index count) {
    sn_index next = SN_NONE;
    for (sn_index i = 0; i < count; i++)
        if (s->wanted[i] && (next == SN_NONE || s->seconds[i] < s->seconds[next])) next = i;
    if (next != SN_NONE) s->wanted[next] = false;
    return next;
}

/* The points of one family (NULL = all) that a block shows, sorted by time; each line: seconds, total error, solver error. */
static sn_status write_block(const sn_error_time *report, const char *family, block what, const char *title, sn_output *output,
                             sn_error *error) {
    shown s;
    sn_status status = choose_shown(report, family, what, &s, error);
    if (status == SN_OK) sn_output_print(output, "\"%s\"\n", title);
    for (sn_index i; status == SN_OK && (i = take_next(&s, report->point_count)) != SN_NONE;)
        sn_output_print(output, "%.6g %.6g %.6g\n", s.seconds[i], report->points[i].total.worst, report->points[i].solver.worst);
    free_shown(&s);
    /* gnuplot passes over blocks without data */
    return status == SN_OK ? sn_output_print(output, "NaN NaN NaN\n\n\n") : status;
}

/* Is setting i the first of its family? */
static bool is_new_family(const sn_error_time *report, sn_index i, char family[SN_SETTING_LENGTH]) {
    char other[SN_SETTING_LENGTH];
    sn_setting_family(&report->settings[i].setting, family);
    for (sn_index k = 0; k < i; k++) {
        sn_setting_family(&report->settings[k].setting, other);
        if (strcmp(family, other) == 0) return false;
    }
    return true;
}

sn_status sn_error_time_write_chart(const sn_error_time *report, sn_output *output, sn_index *family_count, sn_error *error) {
    char family[SN_SETTING_LENGTH];
    sn_status status = SN_OK;
    *family_count = 0;
    for (sn_index i = 0; status == SN_OK && i < report->setting_count; i++) {
        if (!is_new_family(report, i, family)) continue;
        ++*family_count;
        status = write_block(report, family, CLAIMED, family, output, error);
        if (status == SN_OK) status = write_block(report, family, TOTAL_FRONT, family, output, error);
        if (status == SN_OK) status = write_block(report, family, SOLVER_FRONT, family, output, error);
    }
    if (status == SN_OK) status = write_block(report, NULL, TOTAL_FRONT, "Pareto front", output, error);
    if (status == SN_OK) status = write_block(report, NULL, DROPPED, "below 10 floors", output, error);
    return status;
}

/* ---- the report ---------------------------------------------------------------------------------------------------------------------- */

static void write_scene_members(const sn_error_time *report, sn_json *json) {
    sn_json_object(json, "scene");
    sn_json_text(json, "hash", report->scene_hash);
    sn_json_text(json, "name", report->scene_name);
    sn_json_indices(json, "frames", (const sn_index[]){report->first_frame, report->last_frame}, 2);
    sn_json_number(json, "rate", report->rate);
    sn_json_array(json, "muscles");
    for (sn_index i = 0; i < report->muscle_count; i++) {
        sn_json_object(json, NULL);
        sn_json_text(json, "name", report->muscle_names[i]);
        sn_json_integer(json, "vertices", report->muscle_vertices[i]);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_close(json);
}

static void write_reference(const sn_reference *reference, sn_json *json) {
    sn_json_object(json, "reference");
    sn_json_number(json, "floor", reference->floor);
    sn_json_bool(json, "extrapolated", reference->extrapolated);
    sn_json_number(json, "order", reference->order);
    sn_json_number(json, "fittedOrder", reference->fitted);
    sn_json_integer(json, "fittedRungs", reference->fitted_rungs);
    sn_json_array(json, "rungs");
    for (sn_index i = 0; i < reference->rung_count; i++) {
        const sn_rung *rung = &reference->rungs[i];
        sn_json_object(json, NULL);
        sn_json_integer(json, "substeps", rung->substeps);
        sn_json_number(json, "cpuSeconds", rung->seconds);
        sn_json_integer(json, "unconverged", rung->unconverged);
        sn_json_number(json, "largestStrain", rung->strain);
        sn_json_number(json, "step", rung->step);
        sn_json_number(json, "error", rung->error);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_close(json);
}

/* Which point was farthest off. */
static void write_farthest(const sn_error_time *report, const sn_difference *total, sn_json *json) {
    if (total->muscle == SN_NONE) return;
    sn_index vertices = report->muscle_vertices[total->muscle];
    bool inside = total->point >= vertices;
    sn_json_object(json, "farthest");
    sn_json_text(json, "muscle", report->muscle_names[total->muscle]);
    sn_json_integer(json, inside ? "sample" : "vertex", inside ? total->point - vertices : total->point);
    sn_json_close(json);
}

static void write_point(const sn_error_time *report, const sn_error_point *p, sn_json *json) {
    sn_json_object_line(json, NULL);
    sn_json_integer(json, "held", p->held);
    sn_json_number(json, "error", p->total.worst);
    sn_json_number(json, "sceneError", p->total.scene);
    sn_json_number(json, "farthestError", p->total.most);
    write_farthest(report, &p->total, json);
    sn_json_number(json, "solverError", p->solver.worst);
    sn_json_number(json, "cpuSeconds", p->cpu);
    sn_json_number(json, "wallSeconds", p->wall);
    sn_json_bool(json, "claimed", p->claimed);
    sn_json_bool(json, "front", p->front);
    sn_json_close(json);
}

static void write_setting(const sn_error_time *report, sn_index i, sn_json *json) {
    const sn_measured_setting *s = &report->settings[i];
    char text[SN_SETTING_LENGTH];
    sn_json_object(json, NULL);
    sn_setting_format(&s->setting, text);
    sn_json_text(json, "setting", text);
    sn_setting_family(&s->setting, text);
    sn_json_text(json, "family", text);
    sn_json_integer(json, "runs", s->runs);
    sn_json_bool(json, "overTime", s->over_time);
    sn_json_number(json, "setupSeconds", s->setup);
    sn_json_integer(json, "frames", s->frames);
    sn_json_integer(json, "iterations", s->iterations);
    sn_json_integer(json, "rejectedSteps", s->rejected_steps);
    sn_json_integer(json, "refactorisations", s->refactorisations);
    sn_json_integer(json, "restarts", s->restarts);
    sn_json_integer(json, "unconverged", s->unconverged);
    sn_json_integer(json, "nan", s->nan_points);
    sn_json_number(json, "residual", s->residual);
    sn_json_number(json, "elasticEnergy", s->elastic_energy);
    sn_json_number(json, "largestStrain", s->strain);
    sn_json_number(json, "solvedStrain", s->solved_strain);
    if (s->muscle_errors != NULL) sn_json_numbers(json, "muscleErrors", s->muscle_errors, (size_t)report->muscle_count);
    sn_json_array(json, "points");
    for (sn_index k = 0; k < report->point_count; k++)
        if (report->points[k].setting == i) write_point(report, &report->points[k], json);
    sn_json_close(json);
    sn_json_close(json);
}

static void write_front(const sn_error_time *report, sn_json *json) {
    sn_json_array(json, "front");
    for (sn_index i = 0; i < report->point_count; i++) {
        char words[SN_SETTING_LENGTH + 128];
        if (!report->points[i].front) continue;
        sn_error_time_words(report, &report->points[i], sizeof words, words);
        sn_json_text(json, NULL, words);
    }
    sn_json_close(json);
}

static void write_target(const sn_error_time *report, double target, sn_json *json) {
    char family[SN_SETTING_LENGTH], setting[SN_SETTING_LENGTH];
    sn_json_object(json, NULL);
    sn_json_number(json, "error", target);
    sn_json_array(json, "cheapest");
    for (sn_index i = 0; i < report->setting_count; i++) {
        if (!is_new_family(report, i, family)) continue;
        const sn_error_point *p = sn_error_time_cheapest(report, target, family);
        sn_json_object_line(json, NULL);
        sn_json_text(json, "family", family);
        if (p != NULL) sn_setting_format(&report->settings[p->setting].setting, setting);
        sn_json_text(json, "setting", p != NULL ? setting : NULL);
        sn_json_number(json, "cpuSeconds", p != NULL ? p->cpu : NAN);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_close(json);
}

sn_status sn_error_time_write(const sn_error_time *report, sn_output *output, sn_error *error) {
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return sn_fail_memory(error, "the report");
    sn_json_object(json, NULL);
    sn_json_text(json, "format", "sinew-error-time");
    sn_json_integer(json, "version", 1);
    sn_json_text(json, "errors", ERRORS[report->equilibrium]);
    sn_json_integer(json, "threads", report->threads);
    write_scene_members(report, json);
    sn_json_indices(json, "moments", report->moments, (size_t)report->moment_count);
    write_reference(&report->reference, json);
    sn_json_array(json, "settings");
    for (sn_index i = 0; i < report->setting_count; i++) write_setting(report, i, json);
    sn_json_close(json);
    write_front(report, json);
    sn_json_array(json, "targets");
    for (int i = 0; i < SN_ERROR_TARGETS; i++) write_target(report, SN_ERROR_TARGET(i), json);
    sn_json_close(json);
    sn_json_close(json);
    return sn_json_end(json, error);
}

/* ---- reading it ---------------------------------------------------------------------------------------------------------- */

static sn_status parse_muscles(const sn_json_value *muscles, sn_error_time *out, sn_error *error) {
    static const char *const known[] = {"name", "vertices", NULL};
    sn_status status = sn_json_require(muscles, "a list of muscles", error);
    sn_index count = 0;
    if (status == SN_OK) status = sn_json_expect_list(muscles, MOST_MUSCLES, &count, error);
    if (status != SN_OK) return status;
    out->muscle_names = SN_NEW(char *, count);
    out->muscle_vertices = SN_NEW(sn_index, count);
    if (out->muscle_names == NULL || out->muscle_vertices == NULL) return sn_fail_memory(error, "the report");
    out->muscle_count = count;
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_json_value muscle = sn_json_element(muscles, i), name = sn_json_member(&muscle, "name"),
                      vertices = sn_json_member(&muscle, "vertices");
        status = sn_json_check_members(&muscle, known, error);
        if (status == SN_OK) status = sn_json_require(&name, "the name of a muscle", error);
        if (status == SN_OK) status = sn_json_get_text(&name, &out->muscle_names[i], error);
        if (status == SN_OK) status = sn_json_require(&vertices, "its number of vertices", error);
        if (status == SN_OK) status = sn_json_get_index(&vertices, 0, SN_INDEX_MAX, &out->muscle_vertices[i], error);
    }
    return status;
}

static sn_status parse_scene(const sn_json_value *scene, sn_error_time *out, sn_error *error) {
    sn_json_value hash = sn_json_member(scene, "hash"), muscles = sn_json_member(scene, "muscles"), name = sn_json_member(scene, "name");
    char *text = NULL;
    sn_status status = sn_json_require(&hash, "the hash of a scene", error);
    if (status == SN_OK) status = sn_json_get_text(&hash, &text, error);
    if (status == SN_OK && strlen(text) >= SN_HASH_LENGTH) status = sn_json_mismatch(&hash, error, "the hash of a scene");
    if (status == SN_OK) memcpy(out->scene_hash, text, strlen(text) + 1);
    free(text);
    if (status == SN_OK && sn_json_has(&name)) status = sn_json_get_text(&name, &out->scene_name, error);
    return status == SN_OK ? parse_muscles(&muscles, out, error) : status;
}

/* A number, or NaN where it is null or missing. */
static sn_status parse_number(const sn_json_value *object, const char *key, double *out, sn_error *error) {
    sn_json_value value = sn_json_member(object, key);
    *out = NAN;
    return sn_json_get_number(&value, 0.0, INFINITY, out, error);
}

static sn_status parse_point(const sn_json_value *value, sn_index setting, sn_error_time *out, size_t *capacity, sn_error *error) {
    if (out->point_count >= MOST_POINTS || !sn_grow((void **)&out->points, capacity, (size_t)out->point_count + 1, sizeof *out->points))
        return sn_fail_memory(error, "the report");
    sn_error_point *p = &out->points[out->point_count++];
    sn_json_value held = sn_json_member(value, "held");
    *p = (sn_error_point){.setting = setting, .total = {.muscle = SN_NONE}, .solver = {NAN, NAN, NAN, SN_NONE, SN_NONE}};
    sn_status status = sn_json_get_index(&held, 0, SN_INDEX_MAX, &p->held, error);
    if (status == SN_OK) status = parse_number(value, "error", &p->total.worst, error);
    if (status == SN_OK) status = parse_number(value, "sceneError", &p->total.scene, error);
    if (status == SN_OK) status = parse_number(value, "farthestError", &p->total.most, error);
    if (status == SN_OK) status = parse_number(value, "solverError", &p->solver.worst, error);
    if (status == SN_OK) status = parse_number(value, "cpuSeconds", &p->cpu, error);
    return status == SN_OK ? parse_number(value, "wallSeconds", &p->wall, error) : status;
}

static sn_status parse_setting(const sn_json_value *value, sn_index i, sn_error_time *out, size_t *capacity, sn_error *error) {
    sn_json_value text = sn_json_member(value, "setting"), points = sn_json_member(value, "points");
    sn_error inner = {0};
    char *words = NULL;
    sn_index count = 0;
    sn_status status = sn_json_require(&text, "a setting", error);
    if (status == SN_OK) status = sn_json_get_text(&text, &words, error);
    if (status == SN_OK && sn_setting_parse(words, &out->settings[i].setting, &inner) != SN_OK)
        status = sn_json_complain(&text, error, "%s", inner.text);
    free(words);
    if (status == SN_OK) status = sn_json_require(&points, "its points", error);
    if (status == SN_OK) status = sn_json_expect_list(&points, MOST_SETTINGS, &count, error);
    for (sn_index k = 0; status == SN_OK && k < count; k++) {
        sn_json_value point = sn_json_element(&points, k);
        status = parse_point(&point, i, out, capacity, error);
    }
    return status;
}

static sn_status parse_settings(const sn_json_value *settings, sn_error_time *out, sn_error *error) {
    size_t capacity = 0;
    sn_index count = 0;
    sn_status status = sn_json_require(settings, "a list of settings", error);
    if (status == SN_OK) status = sn_json_expect_list(settings, MOST_SETTINGS, &count, error);
    if (status != SN_OK) return status;
    if ((out->settings = SN_NEW(sn_measured_setting, count)) == NULL) return sn_fail_memory(error, "the report");
    out->setting_count = count;
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_json_value setting = sn_json_element(settings, i);
        status = parse_setting(&setting, i, out, &capacity, error);
    }
    return status;
}

sn_status sn_error_time_parse(const sn_blob *blob, sn_error_time *out, sn_error *error) {
    static const char *const known[] = {"format",    "version",  "errors", "threads", "scene", "moments",
                                        "reference", "settings", "front",  "targets", NULL};
    sn_json_tree *tree = NULL;
    int errors = 0;
    *out = (sn_error_time){0};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), scene = sn_json_member(&top, "scene"), settings = sn_json_member(&top, "settings"),
                  reference = sn_json_member(&top, "reference"), kind = sn_json_member(&top, "errors"),
                  floor = sn_json_member(&reference, "floor");
    status = sn_json_expect_format(&top, "sinew-error-time", 1, error);
    if (status == SN_OK) status = sn_json_check_members(&top, known, error);
    if (status == SN_OK) status = sn_json_get_choice(&kind, ERRORS, &errors, error);
    if (status == SN_OK) status = parse_scene(&scene, out, error);
    if (status == SN_OK) status = sn_json_require(&floor, "the reference's floor", error);
    if (status == SN_OK) status = sn_json_get_number(&floor, 0.0, INFINITY, &out->reference.floor, error);
    if (status == SN_OK) status = parse_settings(&settings, out, error);
    out->equilibrium = errors == 1;
    sn_json_tree_free(tree);
    if (status == SN_OK) status = sn_error_time_judge(out, error);
    if (status != SN_OK) sn_error_time_free(out);
    return status;
}
