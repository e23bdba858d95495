/* moment-arm.c -- moment arms of fibres: -dl/dtheta of their lengths over a coordinate, and against measured curves. */
#include "arm_input.h"
#include "chart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static arm_choices with = {.unit = -1, .length_unit = -1};
static const char *fibers_file, *against_file, *chart_file, *title;
static int64_t knots, samples = 91;
static bool total, list;

static const cli_option options[] = {
    {0, "coordinate", "NAME", CLI_TEXT, &with.coordinate, CLI_RESULT, 0, 0, NULL,
     "the coordinate theta: a column of INPUT, or of --motion; needed, but for --list"},
    {0, "motion", "FILE", CLI_TEXT, &with.motion, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "take coordinates from FILE, matched by time: a table (.mot, .sto, TSV) or a motion document"},
    {0, "unit", "UNIT", CLI_CHOICE, &with.unit, CLI_RESULT, 0, 0, arm_unit_names,
     "of the coordinate, where nothing tells it: degrees, radians; of a way: m, cm, mm"},
    {0, "length-unit", "UNIT", CLI_CHOICE, &with.length_unit, CLI_RESULT, 0, 0, cli_unit_names, "of the lengths: m (default), cm, mm"},
    {0, "muscles", "PATTERN", CLI_LIST, &with.muscles, CLI_RESULT, 0, 0, NULL,
     "only muscles that match; may be given again (default: all)"},
    {0, "knots", "N", CLI_INTEGER, &knots, CLI_RESULT, 2, SN_ARM_MOST_KNOTS, NULL,
     "knots of the splines, both ends among them (default: by cross-validation, for each muscle)"},
    {0, "samples", "N", CLI_INTEGER, &samples, CLI_RESULT, 2, 100000, NULL, "angles at which arms are told (default 91)"},
    {0, "total", NULL, CLI_FLAG, &total, CLI_RESULT, 0, 0, NULL,
     "the derivative along the motion is what is wanted, whatever other coordinates do: no shortfall where they move"},
    {0, "fibers", "FILE", CLI_TEXT, &fibers_file, CLI_WRITES, 0, 0, NULL,
     "write the arm of every fibre to FILE: .tsv by angle; .sto, .mot by time"},
    {0, "against", "FILE", CLI_TEXT, &against_file, CLI_READS, 0, 0, NULL,
     "compare with measured arms, a table, and print how they agree; arms go to --output alone then"},
    {0, "chart", "FILE", CLI_TEXT, &chart_file, CLI_WRITES, 0, 0, NULL, "draw arms over the coordinate to FILE, .svg or .png"},
    {0, "title", "TEXT", CLI_TEXT, &title, 0, 0, 0, NULL, "title of the chart (default: the coordinate)"},
    {0, "list", NULL, CLI_FLAG, &list, 0, 0, 0, NULL, "print the columns and what they are taken for, and do nothing else"},
};

static const cli_tool tool = {
    "moment-arm",
    "moment arms from lengths over a coordinate: -dl/dtheta of every fibre, by sweeps; against measured curves",
    CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_HAS_REPORT,
    options,
    sizeof options / sizeof *options,
    "INPUT is a table of lengths, as of simulate --lengths or OpenSim. An output of .sto or .mot is by time. A chart needs gnuplot.",
    ".tsv, .sto, .mot"};

/* What one run holds. */
typedef struct job {
    cli c;
    arm_input input;
    sn_arms arms;
    sn_measured_choice choice;
    sn_measured_arms measured;
    sn_arm_comparison *comparisons; /* (measured.count) */
    sn_index *muscle_of;            /* (measured.count): SN_NONE = no such muscle */
} job;

static double angle_scale(const job *j) { return j->input.is_way ? 1.0 : 180.0 / SN_PI; }
static const char *angle_name(const job *j) { return j->input.is_way ? "position" : "angle"; }
static const char *angle_unit(const job *j) { return j->input.is_way ? "m" : "degrees"; }

static bool ends_with(const char *text, const char *ending) {
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcasecmp(text + length - tail, ending) == 0;
}
static bool is_storage(const char *path) { return ends_with(path, ".sto") || ends_with(path, ".mot"); }

/* ---- what has come of it ------------------------------------------------------------------------------------------------------------ */

/* As people read it: "0.31 mm"; of a way "0.031". */
static const char *say_arm(const job *j, double arm, char text[32]) {
    if (j->input.is_way)
        snprintf(text, 32, "%.3g", arm);
    else
        snprintf(text, 32, "%.3g mm", 1e3 * arm);
    return text;
}

static void warn_of_gaps(const job *j) {
    const sn_arms *a = &j->arms;
    double scale = angle_scale(j);
    if (a->gap_count > 0)
        cli_warn(&j->c, "no row has %s from %.4g to %.4g %s: no arms are told in such gaps, %d of %d angles", j->input.coordinate,
                 a->gap_from * scale, (a->gap_from + a->widest_gap) * scale, angle_unit(j), a->gap_count, a->sample_count);
}

#define NOISY_SHARE 0.1 /* of the largest arm */
#define NOISY_ARM 1e-4  /* m */
#define LONG_ARM 0.3    /* m */
#define LONG_STRETCH 3.0
#define LEFT_SHARE 0.1   /* of the lengths' variation */
#define LEFT_LENGTH 1e-4 /* m */

/* Lengths that differ at one angle, and no known coordinate that could have done it. */
static void warn_of_residuals(const job *j) {
    sn_index count = 0, first = SN_NONE;
    for (sn_index i = 0; i < j->arms.muscle_count; i++) {
        const sn_muscle_arms *m = &j->arms.muscles[i];
        if (m->kind != SN_ARM_ALONE || !(m->sweep_residual > LEFT_LENGTH && m->sweep_residual > LEFT_SHARE * m->variation)) continue;
        if (count++ == 0) first = i;
    }
    if (count == 0) return;
    cli_warn(&j->c,
             "the lengths of %d of %d muscles are no curve of \"%s\": those of \"%s\" are %.3g mm off in the root mean square, of %.3g mm "
             "that they "
             "vary; activation, motion without rest, or a coordinate that is not in the tables",
             count, j->arms.muscle_count, j->input.coordinate, j->input.muscles[first], 1e3 * j->arms.muscles[first].sweep_residual,
             1e3 * j->arms.muscles[first].variation);
}

static void warn_of_muscles(const job *j) {
    sn_index noisy = 0, worst = SN_NONE, longest = SN_NONE, stretched = 0;
    char noise[32], arm[32];
    for (sn_index i = 0; i < j->arms.muscle_count; i++) {
        const sn_muscle_arms *m = &j->arms.muscles[i], *most = j->arms.muscles;
        if (m->stretch > most[stretched].stretch) stretched = i;
        if (m->kind == SN_ARM_MIXED) continue; /* no moment arm: that is said elsewhere */
        if (worst == SN_NONE) worst = longest = i;
        noisy += m->noise_mean > NOISY_SHARE * m->largest && m->noise_mean > NOISY_ARM;
        if (m->noise_mean > most[worst].noise_mean) worst = i;
        if (m->largest > most[longest].largest) longest = i;
    }
    if (j->arms.muscle_count == 0) return;
    const sn_muscle_arms *all = j->arms.muscles;
    if (noisy > 0)
        cli_warn(&j->c, "the arms of %d of %d muscles are noisy: \"%s\" has a standard error of %s, and its largest arm is %s", noisy,
                 j->arms.muscle_count, j->input.muscles[worst], say_arm(j, all[worst].noise_mean, noise),
                 say_arm(j, all[worst].largest, arm));
    if (!j->input.is_way && longest != SN_NONE && all[longest].largest > LONG_ARM)
        cli_warn(&j->c, "\"%s\" has an arm of %.3g m: are the lengths in mm (--length-unit), or is the coordinate in radians (--unit)?",
                 j->input.muscles[longest], all[longest].largest);
    if (all[stretched].stretch > LONG_STRETCH)
        cli_warn(&j->c, "a fibre of \"%s\" changes its length by a factor of %.3g: is that a length?", j->input.muscles[stretched],
                 all[stretched].stretch);
}

/* Muscles that the other coordinates may have to do with: one sentence for each kind. */
static void tell_company_of(job *j, sn_arm_kind kind, const char *why) {
    sn_index count = 0, first = SN_NONE;
    char bound[32];
    for (sn_index i = 0; i < j->arms.muscle_count; i++) {
        if (j->arms.muscles[i].kind != kind) continue;
        count++;
        if (first == SN_NONE) first = i;
    }
    if (count == 0) return;
    const sn_muscle_arms *m = &j->arms.muscles[first];
    const char *other = j->input.others[m->other].name, *name = j->input.muscles[first];
    snprintf(bound, sizeof bound, "any amount");
    if (isfinite(m->other_bound)) say_arm(j, m->other_bound, bound);
    if (total)
        cli_say(&j->c, "%d of %d muscles, \"%s\" first: \"%s\" %s, and may have added %s", count, j->arms.muscle_count, name, other, why,
                bound);
    else
        cli_shortfall(
            &j->c,
            "%d of %d muscles have no moment arm here but a derivative along the motion, \"%s\" first: \"%s\" %s, and may have added "
            "%s; choose others by --muscles, hold it, or say --total",
            count, j->arms.muscle_count, name, other, why, bound);
}

/* Over the muscles whose arms are moment arms; over all where none is. */
typedef struct summary {
    double noise, hysteresis;
    sn_index count;
} summary;

static summary sum_up(const sn_arms *a, bool all) {
    summary s = {.hysteresis = NAN};
    for (sn_index i = 0; i < a->muscle_count; i++) {
        if (!all && a->muscles[i].kind != SN_ARM_ALONE) continue;
        s.noise = fmax(s.noise, a->muscles[i].noise_mean);
        s.hysteresis = fmax(s.hysteresis, a->muscles[i].hysteresis); /* fmax leaves out NaN */
        s.count++;
    }
    return s;
}

static void say_summary(const job *j) {
    const sn_arms *a = &j->arms;
    double scale = angle_scale(j);
    sn_index up = 0;
    char text[32], apart[80] = "one way alone";
    for (sn_index i = 0; i < a->sweeps.count; i++) up += a->sweeps.items[i].up;
    summary s = sum_up(a, false);
    if (s.count == 0) s = sum_up(a, true);
    if (!isnan(s.hysteresis)) snprintf(apart, sizeof apart, "up and down differ by %s at most", say_arm(j, s.hysteresis, text));
    cli_tell(&j->c, "%d muscles, %d fibres over \"%s\" from %.4g to %.4g %s, %d ways up and %d down: %s; noise of the arms: %s at most",
             a->muscle_count, a->fiber_count, j->input.coordinate, a->low * scale, a->high * scale, angle_unit(j), up, a->sweeps.count - up,
             apart, say_arm(j, s.noise, text));
    if (j->input.is_way)
        cli_tell(&j->c, "\"%s\" is a way, so that arms have no unit: metres of length a metre of way", j->input.coordinate);
}

static void tell(job *j) {
    say_summary(j);
    warn_of_gaps(j);
    warn_of_muscles(j);
    warn_of_residuals(j);
    tell_company_of(j, SN_ARM_WITH_IT, "moves along with it");
    tell_company_of(j, SN_ARM_MIXED, "moves too");
}

/* ---- the table of muscles ----------------------------------------------------------------------------------------------------------- */

static void write_cell(sn_output *output, double value) {
    char text[32] = "NaN";
    if (isfinite(value)) sn_format_number(value, text);
    sn_output_print(output, "\t%s", text);
}

static void write_word(sn_output *output, const char *text) {
    for (; *text != '\0'; text++) sn_output_write(output, (unsigned char)*text < ' ' ? " " : text, 1, NULL);
}

static void write_muscle(sn_output *output, const job *j, sn_index muscle) {
    const sn_muscle_arms *m = &j->arms.muscles[muscle];
    const double *const columns[] = {m->mean, m->spread, m->lower, m->upper, m->noise, m->up, m->down};
    for (sn_index k = 0; k < j->arms.sample_count; k++) {
        write_word(output, j->input.muscles[muscle]);
        sn_output_print(output, "\t");
        write_word(output, j->input.coordinate);
        write_cell(output, j->arms.angles[k] * angle_scale(j));
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) write_cell(output, columns[i][k]);
        sn_output_print(output, "\t%d\n", m->fiber_count);
    }
}

static sn_status write_muscles(const job *j, const char *path, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open(path, false, &output, error);
    if (status != SN_OK) return status;
    sn_output_print(output, "muscle\tcoordinate\t%s\tarm\tsd\tlower\tupper\tnoise\tup\tdown\tfibers\n", angle_name(j));
    for (sn_index i = 0; i < j->arms.muscle_count; i++) write_muscle(output, j, i);
    return sn_output_commit(output, error);
}

/* ---- tables of numbers ------------------------------------------------------------------------------------------------------------ */

/* Rows of arms: by time at every row of the input that is used, else by angle. */
typedef struct sheet {
    bool by_time, of_fibers;
    sn_index columns, first; /* first: columns before those of arms */
    const char **names;      /* (columns) */
    char (*words)[300];      /* (columns) */
    double *row;             /* (columns) */
} sheet;

static bool is_done(const job *j, sn_index fiber) { return j->input.muscle_of[fiber] < j->arms.muscle_count; }

/* As its column is called, where that is a fibre's name. */
static void name_fiber(const job *j, sn_index fiber, int number, char *out, size_t size) {
    const char *name = j->input.table.names[j->input.columns[fiber]], *stem;
    size_t length;
    if (sn_column_read_name(name, &stem, &length) == SN_COLUMN_FIBER)
        snprintf(out, size, "%.280s", name);
    else
        snprintf(out, size, "%.280s.%d", j->input.muscles[j->input.muscle_of[fiber]], number);
}

static void name_sheet(const job *j, sheet *s) {
    const char *stem;
    size_t length;
    sn_index n = 0;
    sn_column_read_name(j->input.coordinate, &stem, &length);
    if (s->by_time) snprintf(s->words[n++], sizeof *s->words, "time");
    if (s->by_time)
        snprintf(s->words[n++], sizeof *s->words, "%.*s.%s", (int)(length < 280 ? length : 280), stem, j->input.is_way ? "m" : "angle");
    else
        snprintf(s->words[n++], sizeof *s->words, "%s", angle_name(j));
    for (sn_index i = 0; i < j->arms.muscle_count; i++) {
        sn_index number = 0;
        if (!s->of_fibers) snprintf(s->words[n++], sizeof *s->words, "%.280s", j->input.muscles[i]);
        for (sn_index f = 0; s->of_fibers && f < j->arms.fiber_count; f++)
            if (j->input.muscle_of[f] == i) name_fiber(j, f, ++number, s->words[n++], sizeof *s->words);
    }
    for (sn_index i = 0; i < s->columns; i++) s->names[i] = s->words[i];
}

/* NaN where the fibre has no length. */
static double fiber_at_row(const job *j, sn_index fiber, sn_index row) {
    return isnan(j->input.lengths[fiber][row]) ? NAN : sn_arm_of_fiber(&j->arms, fiber, j->input.values[row]);
}

static void fill_sheet(const job *j, const sheet *s, sn_index row) {
    double *to = s->row, angle = s->by_time ? j->input.values[row] : j->arms.angles[row];
    if (s->by_time) *to++ = j->input.table.times[row];
    *to++ = angle * angle_scale(j);
    for (sn_index i = 0; i < j->arms.muscle_count; i++) {
        if (!s->of_fibers) *to++ = sn_arm_of_muscle(&j->arms, i, angle);
        for (sn_index f = 0; s->of_fibers && f < j->arms.fiber_count; f++)
            if (j->input.muscle_of[f] == i) *to++ = s->by_time ? fiber_at_row(j, f, row) : j->arms.fibers[f][row];
    }
}

static sn_status write_sheet_rows(const job *j, const sheet *s, sn_table *table, sn_error *error) {
    sn_index rows = s->by_time ? j->input.table.row_count : j->arms.sample_count;
    sn_status status = SN_OK;
    for (sn_index k = 0; k < rows && status == SN_OK; k++) {
        if (s->by_time && isnan(j->input.values[k])) continue;
        fill_sheet(j, s, k);
        status = sn_table_append(table, s->row, error);
    }
    return status;
}

static sn_status write_sheet(const job *j, const char *path, bool of_fibers, sn_error *error) {
    sn_table *table = NULL;
    sheet s = {.by_time = is_storage(path), .of_fibers = of_fibers};
    sn_index columns = j->arms.muscle_count, rows = s.by_time ? j->input.table.row_count - j->input.unused : j->arms.sample_count;
    if (of_fibers)
        for (sn_index f = columns = 0; f < j->arms.fiber_count; f++) columns += is_done(j, f);
    s.columns = columns + 1 + s.by_time;
    s.names = sn_alloc((size_t)s.columns, sizeof *s.names);
    s.words = sn_alloc((size_t)s.columns, sizeof *s.words);
    s.row = SN_NEW(double, s.columns);
    sn_status status = s.names && s.words && s.row ? SN_OK : sn_fail_memory(error, "a table");
    if (status == SN_OK) name_sheet(j, &s);
    sn_table_params params = {.title = "moment arms, m", .rows = rows, .columns = s.columns, .names = s.names};
    if (status == SN_OK) status = sn_table_create(path, &params, &table, error);
    if (status == SN_OK) status = write_sheet_rows(j, &s, table, error);
    if (status == SN_OK)
        status = sn_table_commit(table, error);
    else
        sn_table_abort(table);
    free((void *)s.names);
    free(s.words);
    free(s.row);
    return status;
}

/* ---- against measured curves -------------------------------------------------------------------------------------------------------- */

static sn_index find_muscle(const job *j, const char *name) {
    for (sn_index i = 0; i < j->arms.muscle_count; i++)
        if (strcmp(j->input.muscles[i], name) == 0) return i;
    return SN_NONE;
}

static sn_status load_measured(job *j, sn_error *error) {
    sn_blob blob = {0};
    j->choice = (sn_measured_choice){.coordinate = j->input.coordinate, .is_way = j->input.is_way};
    sn_status status = sn_blob_read(against_file, &blob, error);
    if (status == SN_OK) status = sn_measured_arms_parse(&blob, &j->choice, &j->measured, error);
    sn_blob_free(&blob);
    return status;
}

static void warn_of_measured(const job *j, sn_index missing, const char *example) {
    if (missing > 0)
        cli_warn(&j->c, "%s: %d of %d measured muscles are not in the table of lengths: \"%s\"%s", against_file, missing, j->measured.count,
                 example, missing > 1 ? " and others" : "");
    for (sn_index i = 0; i < j->measured.count; i++) {
        const sn_arm_comparison *p = &j->comparisons[i];
        const char *name = j->measured.items[i].muscle;
        if (j->muscle_of[i] == SN_NONE) continue;
        if (p->points == 0) cli_warn(&j->c, "%s: no measured angle of \"%s\" is one that the lengths have", against_file, name);
        if (p->sign_points >= 3 && p->sign < 0.5)
            cli_warn(
                &j->c,
                "%s: \"%s\" has the other sign at most angles; an arm is positive here where the muscle shortens as the coordinate grows",
                against_file, name);
    }
}

static sn_status compare_all(job *j, sn_error *error) {
    sn_index missing = 0;
    const char *example = NULL;
    sn_status status = load_measured(j, error);
    if (status != SN_OK) return status;
    j->comparisons = SN_NEW(sn_arm_comparison, j->measured.count);
    j->muscle_of = SN_NEW(sn_index, j->measured.count);
    if (j->comparisons == NULL || j->muscle_of == NULL) return sn_fail_memory(error, "the comparison");
    for (sn_index i = 0; i < j->measured.count && status == SN_OK; i++) {
        const sn_measured_arm *m = &j->measured.items[i];
        if ((j->muscle_of[i] = find_muscle(j, m->muscle)) == SN_NONE) {
            if (missing++ == 0) example = m->muscle;
            continue;
        }
        status = sn_arm_compare(&j->arms, j->muscle_of[i], m, j->input.is_way ? 0.01 : SN_ARM_SIGN_FROM, &j->comparisons[i], error);
    }
    if (status == SN_OK && missing == j->measured.count)
        return sn_fail_at(error, SN_ERROR_INPUT, against_file, 0, "none of its muscles is in the table of lengths: \"%.100s\"", example);
    if (status == SN_OK) warn_of_measured(j, missing, example);
    return status;
}

static void print_comparison(sn_output *output, const job *j, sn_index i) {
    const sn_arm_comparison *p = &j->comparisons[i];
    const double values[] = {p->low * angle_scale(j), p->high * angle_scale(j), p->rms,         p->bias,
                             100.0 * p->overlap,      100.0 * p->inside,        100.0 * p->sign};
    write_word(output, j->measured.items[i].muscle);
    sn_output_print(output, "\t%d\t%d", p->points, p->outside);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++)
        if (isfinite(values[k]))
            sn_output_print(output, "\t%.6g", values[k]);
        else
            sn_output_print(output, "\t-");
    sn_output_print(output, "\n");
}

static sn_status print_comparisons(const job *j, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    sn_output_print(output, "muscle\tpoints\toutside\tfrom\tto\trms\tbias\toverlap_percent\tinside_percent\tsign_percent\n");
    for (sn_index i = 0; i < j->measured.count; i++)
        if (j->muscle_of[i] != SN_NONE) print_comparison(output, j, i);
    return sn_output_commit(output, error);
}

/* ---- report ------------------------------------------------------------------------------------------------------------------------- */

static void report_coordinate(sn_json *json, const job *j) {
    const sn_arms *a = &j->arms;
    double scale = angle_scale(j);
    sn_json_object(json, "coordinate");
    sn_json_text(json, "name", j->input.coordinate);
    sn_json_text(json, "file", j->input.file);
    sn_json_text(json, "unit", angle_unit(j));
    sn_json_number(json, "least", a->low * scale);
    sn_json_number(json, "greatest", a->high * scale);
    sn_json_integer(json, "values", a->angle_count);
    sn_json_integer(json, "rows", j->input.table.row_count);
    sn_json_integer(json, "unusedRows", j->input.unused);
    sn_json_integer(json, "interpolatedRows", j->input.between);
    sn_json_number(json, "widestGap", a->widest_gap * scale);
    sn_json_close(json);
}

static void report_sweep(sn_json *json, const job *j, const sn_sweep *sweep) {
    double scale = angle_scale(j);
    sn_json_object(json, NULL);
    sn_json_text(json, "way", sweep->up ? "up" : "down");
    sn_json_integer(json, "firstRow", sweep->first);
    sn_json_integer(json, "lastRow", sweep->last);
    sn_json_number(json, "from", j->input.values[sweep->first] * scale);
    sn_json_number(json, "to", j->input.values[sweep->last] * scale);
    sn_json_close(json);
}

static void report_other(sn_json *json, const job *j, sn_index i) {
    const sn_arm_company *company = &j->arms.company[i];
    sn_json_object(json, NULL);
    sn_json_text(json, "name", j->input.others[i].name);
    sn_json_bool(json, "moves", company->moves);
    sn_json_number(json, "range", company->range);
    sn_json_number(json, "explained", company->explained);
    sn_json_close(json);
}

static void report_hysteresis(sn_json *json, const sn_muscle_arms *m) {
    if (isnan(m->hysteresis)) {
        sn_json_null(json, "hysteresis");
        return;
    }
    sn_json_object(json, "hysteresis");
    sn_json_number(json, "greatest", m->hysteresis);
    sn_json_number(json, "rms", m->hysteresis_rms);
    sn_json_number(json, "greatestOfRange", m->range > 0.0 ? m->hysteresis / m->range : NAN);
    sn_json_number(json, "rmsOfRange", m->range > 0.0 ? m->hysteresis_rms / m->range : NAN);
    sn_json_number(json, "greatestOfLargest", m->largest > 0.0 ? m->hysteresis / m->largest : NAN);
    sn_json_close(json);
}

static void report_muscle(sn_json *json, const job *j, sn_index i) {
    const sn_muscle_arms *m = &j->arms.muscles[i];
    sn_json_object(json, NULL);
    sn_json_text(json, "name", j->input.muscles[i]);
    sn_json_integer(json, "fibers", m->fiber_count);
    sn_json_integer(json, "missingLengths", m->missing);
    sn_json_integer(json, "knots", m->knots);
    sn_json_number(json, "residual", m->residual);
    sn_json_number(json, "sweepResidual", m->sweep_residual);
    sn_json_number(json, "variation", m->variation);
    sn_json_number(json, "noise", m->noise_mean);
    sn_json_number(json, "range", m->range);
    sn_json_number(json, "largest", m->largest);
    report_hysteresis(json, m);
    sn_json_text(json, "others", sn_arm_kind_names[m->kind]);
    sn_json_text(json, "other", m->other != SN_NONE ? j->input.others[m->other].name : NULL);
    sn_json_number(json, "otherBound", m->other != SN_NONE ? m->other_bound : NAN);
    sn_json_close(json);
}

static void report_comparison(sn_json *json, const job *j, sn_index i) {
    const sn_arm_comparison *p = &j->comparisons[i];
    double scale = angle_scale(j);
    sn_json_object(json, NULL);
    sn_json_text(json, "muscle", j->measured.items[i].muscle);
    sn_json_integer(json, "points", p->points);
    sn_json_integer(json, "outside", p->outside);
    sn_json_number(json, "from", p->low * scale);
    sn_json_number(json, "to", p->high * scale);
    sn_json_number(json, "rms", p->rms);
    sn_json_number(json, "bias", p->bias);
    sn_json_number(json, "overlap", p->overlap);
    sn_json_number(json, "inside", p->inside);
    sn_json_number(json, "sign", p->sign);
    sn_json_close(json);
}

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    report_coordinate(json, j);
    sn_json_array(json, "sweeps");
    for (sn_index i = 0; i < j->arms.sweeps.count; i++) report_sweep(json, j, &j->arms.sweeps.items[i]);
    sn_json_close(json);
    sn_json_array(json, "otherCoordinates");
    for (sn_index i = 0; i < j->arms.other_count; i++) report_other(json, j, i);
    sn_json_close(json);
    sn_json_array(json, "muscles");
    for (sn_index i = 0; i < j->arms.muscle_count; i++) report_muscle(json, j, i);
    sn_json_close(json);
    if (against_file == NULL) return;
    sn_json_array(json, "against");
    for (sn_index i = 0; i < j->measured.count; i++)
        if (j->muscle_of[i] != SN_NONE) report_comparison(json, j, i);
    sn_json_close(json);
}

/* ---- chart -------------------------------------------------------------------------------------------------------------------------- */

/* More panels than this make no chart that can be read. */
enum { MOST_PANELS = 24 };

/* Arms in mm (of a way as they are) over degrees or metres. */
static double chart_scale(const job *j) { return j->input.is_way ? 1.0 : 1e3; }

static void print_title(sn_output *output, const job *j, sn_index muscle) {
    char words[160];
    snprintf(words, sizeof words, "%.100s, %d %s", j->input.muscles[muscle], j->arms.muscles[muscle].fiber_count,
             j->arms.muscles[muscle].fiber_count > 1 ? "fibres" : "fibre");
    for (char *c = words; *c != '\0'; c++)
        if (*c == '"' || *c == '\\' || (unsigned char)*c < ' ') *c = '_';
    sn_output_print(output, "\"%s\"\n", words);
}

static void print_arms(sn_output *output, const job *j, sn_index muscle) {
    const sn_muscle_arms *m = &j->arms.muscles[muscle];
    const double *const columns[] = {m->mean, m->lower, m->upper, m->up, m->down};
    print_title(output, j, muscle);
    for (sn_index k = 0; k < j->arms.sample_count; k++) {
        sn_output_print(output, "%.9g", j->arms.angles[k] * angle_scale(j));
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) write_cell(output, columns[i][k] * chart_scale(j));
        sn_output_print(output, "\n");
    }
    sn_output_print(output, "\n\n");
}

/* One row of NaN where nothing was measured: gnuplot counts blocks. */
static void print_measured(sn_output *output, const job *j, sn_index muscle) {
    sn_index i = 0;
    while (i < j->measured.count && j->muscle_of[i] != muscle) i++;
    sn_output_print(output, "\"measured\"\n");
    if (i == j->measured.count) sn_output_print(output, "0\tNaN\tNaN\tNaN\n");
    for (sn_index k = 0; i < j->measured.count && k < j->measured.items[i].count; k++) {
        const sn_measured_arm *m = &j->measured.items[i];
        sn_output_print(output, "%.9g", m->angles[k] * angle_scale(j));
        write_cell(output, m->arms[k] * chart_scale(j));
        write_cell(output, m->lower[k] * chart_scale(j));
        write_cell(output, m->upper[k] * chart_scale(j));
        sn_output_print(output, "\n");
    }
    sn_output_print(output, "\n\n");
}

static sn_status write_chart_data(const job *j, sn_index panels, const char *path, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open(path, true, &output, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < panels; i++) {
        print_arms(output, j, i);
        print_measured(output, j, i);
    }
    return sn_output_commit(output, error);
}

/* gnuplot, a child, reads the data by the number of a file that has no name. */
static sn_status draw_panels(job *j, sn_index panels, sn_error *error) {
    char path[64], number[16], label[300];
    const char *stem;
    size_t length;
    int data = memfd_create("moment-arm", 0);
    if (data < 0) return sn_fail(error, SN_ERROR_IO, "no room for the data of a chart");
    snprintf(path, sizeof path, "/proc/self/fd/%d", data);
    snprintf(number, sizeof number, "%d", (int)panels);
    sn_column_read_name(j->input.coordinate, &stem, &length);
    snprintf(label, sizeof label, "%.*s, %s", (int)(length < 250 ? length : 250), stem, angle_unit(j));
    sn_status status = write_chart_data(j, panels, path, error);
    if (status == SN_OK)
        chart_draw(&j->c, "moment-arm.gp",
                   (const char *const[]){path, chart_file, title != NULL ? title : "", number, label,
                                         j->input.is_way ? "moment arm, m/m" : "moment arm, mm", NULL});
    close(data);
    return status;
}

static sn_status draw_chart(job *j, sn_error *error) {
    sn_index count = j->arms.muscle_count;
    if (chart_file == NULL || count == 0) return SN_OK;
    if (count > MOST_PANELS)
        cli_warn(&j->c, "the chart shows the first %d of %d muscles; --muscles chooses others", MOST_PANELS, (int)count);
    return draw_panels(j, count < MOST_PANELS ? count : MOST_PANELS, error);
}

/* ---- work --------------------------------------------------------------------------------------------------------------------------- */

static sn_status measure(job *j, sn_error *error) {
    sn_arm_params params = SN_ARM_PARAMS;
    sn_arm_input input = arm_input_view(&j->input);
    params.knots = (sn_index)knots;
    params.samples = (sn_index)samples;
    params.is_way = j->input.is_way;
    params.trace = &j->c.trace;
    return sn_moment_arms(&input, &params, &j->arms, error);
}

static sn_status save(job *j, sn_error *error) {
    sn_status status = SN_OK;
    if (against_file == NULL || strcmp(j->c.output, "-") != 0)
        status = is_storage(j->c.output) ? write_sheet(j, j->c.output, false, error) : write_muscles(j, j->c.output, error);
    if (status == SN_OK && fibers_file != NULL) status = write_sheet(j, fibers_file, true, error);
    if (status == SN_OK && against_file != NULL) status = print_comparisons(j, error);
    if (status == SN_OK) status = draw_chart(j, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

static sn_status check_times(const job *j, sn_error *error) {
    bool wanted = is_storage(j->c.output) || (fibers_file != NULL && is_storage(fibers_file));
    if (!wanted || j->input.table.times != NULL) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, j->input.table.name, 0, "a storage file is by time, and the first column is not \"time\"");
}

static sn_status find_arms(job *j, sn_error *error) {
    sn_status status = arm_input_load(&j->c, &with, &j->input, error);
    if (status == SN_OK && list) return arm_input_list(&j->input, error);
    if (status == SN_OK) status = check_times(j, error);
    if (status == SN_OK) status = arm_input_choose(&j->c, &with, &j->input, error);
    if (status == SN_OK) status = measure(j, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, j->input.table.name != NULL ? j->input.table.name : j->c.inputs.items[0]);
        return status;
    }
    tell(j);
    status = against_file != NULL ? compare_all(j, error) : SN_OK;
    return status == SN_OK ? save(j, error) : status;
}

static void check_usage(const cli *c) {
    if (with.coordinate == NULL && !list) cli_usage_error(c, "--coordinate NAME is missing");
    if (fibers_file != NULL && strcmp(fibers_file, "-") == 0)
        cli_usage_error(c, "--fibers needs a file: the arms are on the standard output");
    if (against_file != NULL && cli_given(c, "output") && strcmp(c->output, "-") == 0)
        cli_usage_error(c, "--against prints its table to the standard output; name a file for --output");
    if (chart_file != NULL && !ends_with(chart_file, ".svg") && !ends_with(chart_file, ".png"))
        cli_usage_error(c, "--chart: the name of a chart ends in .svg or .png, not as '%s'", chart_file);
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    check_usage(&j.c);
    sn_status status = find_arms(&j, &error);
    sn_arms_free(&j.arms);
    sn_measured_arms_free(&j.measured);
    arm_input_free(&j.input);
    free(j.comparisons);
    free(j.muscle_of);
    return cli_finish(&j.c, status, &error);
}
