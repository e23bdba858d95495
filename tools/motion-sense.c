/* motion-sense.c -- sensors on a motion: what they read, and the activations of muscles that they give. */
#include "chart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const char *sensors_file, *muscles_file, *readings_file, *chart_file, *title;
static double rate, cutoff;
static bool list;

static const cli_option options[] = {
    {0, "sensors", "FILE", CLI_TEXT, &sensors_file, CLI_RESULT | CLI_FILE, 0, 0, NULL, "the sensors document; needed, but for --list"},
    {0, "muscles", "FILE", CLI_TEXT, &muscles_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "names that patterns match: a scene, or a name a line (default: those of the sensors document)"},
    {0, "rate", "HZ", CLI_NUMBER, &rate, CLI_RESULT, 1e-3, 1e5, NULL,
     "samples a second of what is written (default: the motion's rate, times what makes it 120 or more)"},
    {0, "filter", "HZ", CLI_NUMBER, &cutoff, CLI_RESULT, 0, 1e5, NULL,
     "low-pass of the motion before it is measured, instead of the document's filters; 0 for none"},
    {0, "readings", "FILE", CLI_TEXT, &readings_file, CLI_WRITES, 0, 0, NULL,
     "write what each sensor reads and how it activates to FILE, a table (.sto: OpenSim's, else TSV)"},
    {0, "chart", "FILE", CLI_TEXT, &chart_file, CLI_WRITES, 0, 0, NULL, "draw readings and activations to FILE, .svg or .png"},
    {0, "title", "TEXT", CLI_TEXT, &title, 0, 0, 0, NULL, "title of the chart (default: the document's name)"},
    {0, "list", NULL, CLI_FLAG, &list, 0, 0, 0, NULL, "print the motion's joints, the sensors and the channels, and do nothing else"},
};

static const cli_tool tool = {"motion-sense",
                              "activations of muscles from a motion: angles, velocities, accelerations, distances, triggers",
                              CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_HAS_REPORT | CLI_HAS_HISTORY,
                              options,
                              sizeof options / sizeof *options,
                              "An output of .tsv, .sto or .mot is a table of activations. A chart needs gnuplot.",
                              ".json, .tsv, .sto, .mot"};

/* What one run holds. */
typedef struct job {
    cli c;
    sn_blob motion, document, names;
    sn_muscle_names muscles;
    sn_clip clip;
    sn_sensors sensors;
    sn_sense sense;
} job;

/* ---- reading ------------------------------------------------------------------------------------------------------------------------ */

static sn_status load_motion(job *j, sn_error *error) {
    sn_status status = sn_blob_read(j->c.inputs.items[0], &j->motion, error);
    if (status != SN_OK) return status;
    sn_hash(j->motion.data, j->motion.size, j->c.input_hash);
    const char *format = sn_clip_detect(&j->motion);
    if (format != NULL && strcmp(format, "motion document") != 0 && strcmp(format, "BVH") != 0)
        return sn_fail_at(error, SN_ERROR_INPUT, j->motion.name, 0, "is %s; make a motion document of it with motion-import", format);
    return sn_clip_parse(&j->motion, NULL, &(sn_clip_options){0}, &j->clip, error);
}

static sn_status load_sensors(job *j, sn_error *error) {
    sn_status status = SN_OK;
    if (sensors_file == NULL) return SN_OK;
    if (muscles_file != NULL) status = sn_blob_read(muscles_file, &j->names, error);
    if (status == SN_OK && muscles_file != NULL) status = sn_muscle_names_parse(&j->names, &j->muscles, error);
    if (status == SN_OK) status = sn_blob_read(sensors_file, &j->document, error);
    return status == SN_OK ? sn_sensors_parse(&j->document, muscles_file != NULL ? &j->muscles : NULL, &j->sensors, error) : status;
}

static void warn_of_jumps(const job *j, const sn_clip_jump *jumps, sn_index count) {
    if (count == 0) return;
    cli_warn(&j->c, "%s: '%s' turns by %.0f degrees from frame %d to %d%s; what is read there is the jump", j->motion.name,
             j->clip.joints[jumps->joint].name, jumps->angle * (180.0 / SN_PI), jumps->frame - 1, jumps->frame,
             count > 1 ? ", and there are more such jumps" : "");
}

static sn_status look_for_jumps(job *j, sn_error *error) {
    sn_clip_jump *jumps = NULL;
    sn_index count = 0;
    sn_status status = sn_clip_jumps(&j->clip, &jumps, &count, error);
    if (status == SN_OK) warn_of_jumps(j, jumps, count);
    free(jumps);
    return status;
}

static double cutoff_of(const job *j, const sn_sensor *sensor) {
    return cli_given(&j->c, "filter") ? cutoff : sensor->cutoff >= 0.0 ? sensor->cutoff : j->sensors.cutoff;
}

/* A filter that the motion cannot have, as its rate is too low to hold what the filter would take. */
static void warn_of_filters(const job *j) {
    double most = 0.0;
    for (sn_index i = 0; i < j->sensors.sensor_count; i++) most = fmax(most, cutoff_of(j, &j->sensors.sensors[i]));
    if (most > 0.0 && most >= 0.5 * j->clip.rate)
        cli_warn(&j->c, "a filter of %g Hz has nothing to take from %g frames a second: left out", most, j->clip.rate);
}

/* ---- what has come of it ------------------------------------------------------------------------------------------------------------ */

static void range_of(const double *values, sn_index count, double *least, double *most) {
    *least = *most = values[0];
    for (sn_index k = 1; k < count; k++) {
        *least = fmin(*least, values[k]);
        *most = fmax(*most, values[k]);
    }
}

/* Is the reading one and the same but for rounding? Nothing is wrong with what it does not do then. */
static bool is_still(double least, double most) { return most - least <= 1e-9 * fmax(1.0, fmax(fabs(least), fabs(most))); }

/* Times of a trigger that are longer than all of the motion (and than a second) have been told in milliseconds. */
static void warn_of_times(const job *j, const char *kind, const char *called, const sn_trigger *trigger) {
    const struct {
        const char *name;
        double value;
    } times[] = {{"attack", trigger->attack}, {"hold", trigger->hold}, {"decay", trigger->decay}};
    double motion = (j->clip.frame_count - 1) / j->clip.rate;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++)
        if (times[i].value > fmax(motion, 1.0))
            cli_warn(&j->c, "%s '%s': the %s of its trigger, %g s, is longer than the motion, %.4g s; times are in seconds", kind, called,
                     times[i].name, times[i].value, motion);
}

static void warn_of_sensor(const job *j, sn_index i) {
    const sn_sensor *sensor = &j->sensors.sensors[i];
    double scale = sn_sensor_scale(sensor->kind), least, most, low, high;
    range_of(j->sense.readings[i], j->sense.sample_count, &least, &most);
    range_of(j->sense.sensed[i], j->sense.sample_count, &low, &high);
    const sn_firings *firings = &j->sense.sensor_firings[i];
    if (sensor->has_trigger) warn_of_times(j, "sensor", sensor->name, &sensor->trigger);
    if (sensor->has_trigger && firings->count == 0)
        cli_warn(&j->c, "sensor '%s' never fires: it %s its threshold; it reads from %.4g to %.4g %s", sensor->name,
                 firings->from_start ? "starts beyond" : "never passes", least * scale, most * scale, sn_sensor_unit(sensor->kind));
    else if (!sensor->has_trigger && sensor->knot_count > 0 && low == high && !is_still(least, most))
        cli_warn(&j->c, "sensor '%s' activates by %g throughout: it reads from %.4g to %.4g %s, where its curve is level", sensor->name,
                 low, least * scale, most * scale, sn_sensor_unit(sensor->kind));
}

static void warn_of_results(const job *j) {
    for (sn_index i = 0; i < j->sense.sensor_count; i++) warn_of_sensor(j, i);
    for (sn_index i = 0; i < j->sense.channel_count; i++) {
        const sn_firings *firings = &j->sense.channel_firings[i];
        const sn_sense_channel *channel = &j->sensors.channels[i];
        if (channel->has_trigger) warn_of_times(j, "channel", channel->name, &channel->trigger);
        if (channel->has_trigger && firings->count == 0)
            cli_warn(&j->c, "the trigger of channel '%s' never fires: it %s its threshold", j->sensors.channels[i].name,
                     firings->from_start ? "starts beyond" : "never passes");
        if (j->sense.cut[i] > 0.0)
            cli_say(&j->c, "channel '%s' is cut to [0,1] for %.3g %% of the time", j->sensors.channels[i].name, 100.0 * j->sense.cut[i]);
    }
}

/* ---- list --------------------------------------------------------------------------------------------------------------------------- */

/* One field of a line of fields parted by tabs. */
static void print_field(sn_output *output, const char *text) {
    sn_output_write(output, "\t", 1, NULL);
    for (; *text != '\0'; text++) sn_output_write(output, (unsigned char)*text < ' ' ? " " : text, 1, NULL);
}

static void print_joint(sn_output *output, const sn_clip *clip, sn_index i) {
    const sn_clip_joint *joint = &clip->joints[i];
    sn_output_print(output, "joint");
    print_field(output, joint->name);
    print_field(output, joint->parent != SN_NONE ? clip->joints[joint->parent].name : "-");
    print_field(output, joint->has_end ? "end" : "-");
    sn_output_print(output, "\n");
}

static void print_sensor(sn_output *output, const sn_sensor *sensor) {
    sn_output_print(output, "sensor");
    print_field(output, sensor->name);
    print_field(output, sn_sensor_kind_names[sensor->kind]);
    print_field(output, sn_sensor_unit(sensor->kind));
    print_field(output, sensor->place.joint != NULL ? sensor->place.joint : "world");
    sn_output_print(output, "\n");
}

static void print_channel(sn_output *output, const sn_sensors *sensors, const sn_sense_channel *channel) {
    sn_output_print(output, "channel");
    print_field(output, channel->name);
    print_field(output, sn_combination_names[channel->combination]);
    for (sn_index i = 0; i < channel->input_count; i++) print_field(output, sensors->sensors[channel->inputs[i].sensor].name);
    sn_output_print(output, "\n");
}

static sn_status print_list(const job *j, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < j->clip.joint_count; i++) print_joint(output, &j->clip, i);
    for (sn_index i = 0; i < j->sensors.sensor_count; i++) print_sensor(output, &j->sensors.sensors[i]);
    for (sn_index i = 0; i < j->sensors.channel_count; i++) print_channel(output, &j->sensors, &j->sensors.channels[i]);
    status = sn_output_commit(output, error);
    return status == SN_OK ? SN_STOPPED : status;
}

/* ---- report ------------------------------------------------------------------------------------------------------------------------- */

static void write_firings(sn_json *json, const sn_firings *firings) {
    sn_json_numbers(json, "fired", firings->times, (size_t)firings->count);
    if (firings->from_start) sn_json_bool(json, "onFromStart", true);
}

static void write_range(sn_json *json, const double *values, sn_index count, double scale) {
    double least, most;
    range_of(values, count, &least, &most);
    sn_json_number(json, "least", least * scale);
    sn_json_number(json, "greatest", most * scale);
}

static void report_sensor(sn_json *json, const job *j, sn_index i) {
    const sn_sensor *sensor = &j->sensors.sensors[i];
    sn_json_object(json, NULL);
    sn_json_text(json, "name", sensor->name);
    sn_json_text(json, "type", sn_sensor_kind_names[sensor->kind]);
    sn_json_text(json, "unit", sn_sensor_unit(sensor->kind));
    sn_json_number(json, "filter", cutoff_of(j, sensor) < 0.5 * j->clip.rate ? cutoff_of(j, sensor) : 0.0);
    write_range(json, j->sense.readings[i], j->sense.sample_count, sn_sensor_scale(sensor->kind));
    if (sensor->has_trigger) write_firings(json, &j->sense.sensor_firings[i]);
    sn_json_close(json);
}

static void report_channel(sn_json *json, const job *j, sn_index i) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", j->sensors.channels[i].name);
    write_range(json, j->sense.activations[i], j->sense.sample_count, 1.0);
    sn_json_number(json, "cut", j->sense.cut[i]);
    if (j->sensors.channels[i].has_trigger) write_firings(json, &j->sense.channel_firings[i]);
    sn_json_close(json);
}

static sn_index output_count(const sn_sense *sense) { return (sense->sample_count - 1) / sense->stride + 1; }

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    sn_json_integer(json, "frames", j->clip.frame_count);
    sn_json_number(json, "frameRate", j->clip.rate);
    sn_json_integer(json, "samples", output_count(&j->sense));
    sn_json_number(json, "rate", j->sense.rate);
    sn_json_array(json, "sensors");
    for (sn_index i = 0; i < j->sense.sensor_count; i++) report_sensor(json, j, i);
    sn_json_close(json);
    sn_json_array(json, "channels");
    for (sn_index i = 0; i < j->sense.channel_count; i++) report_channel(json, j, i);
    sn_json_close(json);
}

/* ---- tables ------------------------------------------------------------------------------------------------------------------------- */

/* A column of a table: every stride-th of the values, times scale. */
typedef struct column {
    char *name; /* owned */
    const double *values;
    double scale;
} column;

typedef struct columns {
    sn_index count;
    column *items; /* (count) owned; the first one, the time, has no values */
} columns;

static void free_columns(columns *all) {
    for (sn_index i = 0; i < all->count; i++) free(all->items[i].name);
    free(all->items);
}

static bool add_column(columns *all, const char *name, const char *ending, const double *values, double scale) {
    size_t size = strlen(name) + strlen(ending) + 1;
    column *new = &all->items[all->count];
    if ((new->name = sn_alloc(size, 1)) == NULL) return false;
    snprintf(new->name, size, "%s%s", name, ending);
    new->values = values;
    new->scale = scale;
    all->count++;
    return true;
}

/* Readings, each with the activation that it gives, if it gives one. */
static bool add_readings(const job *j, columns *all) {
    bool enough = true;
    for (sn_index i = 0; i < j->sense.sensor_count && enough; i++) {
        const sn_sensor *sensor = &j->sensors.sensors[i];
        enough = add_column(all, sensor->name, "", j->sense.readings[i], sn_sensor_scale(sensor->kind));
        if (enough && (sensor->knot_count > 0 || sensor->has_trigger))
            enough = add_column(all, sensor->name, ".activation", j->sense.sensed[i], 1.0);
    }
    return enough;
}

static bool add_channels(const job *j, columns *all) {
    bool enough = true;
    for (sn_index i = 0; i < j->sense.channel_count && enough; i++)
        enough = add_column(all, j->sensors.channels[i].name, "", j->sense.activations[i], 1.0);
    return enough;
}

static sn_status choose_columns(const job *j, bool readings, bool channels, columns *out, sn_error *error) {
    *out = (columns){0};
    out->items = SN_NEW(column, 1 + 2 * j->sense.sensor_count + j->sense.channel_count);
    bool enough = out->items != NULL && add_column(out, "time", "", NULL, 1.0) && (!readings || add_readings(j, out)) &&
                  (!channels || add_channels(j, out));
    return enough ? SN_OK : sn_fail_memory(error, "a table");
}

static void fill_row(const job *j, const columns *all, sn_index k, double *row) {
    row[0] = j->sense.begin + k / j->sense.rate;
    for (sn_index i = 1; i < all->count; i++) row[i] = all->items[i].values[(size_t)k * (size_t)j->sense.stride] * all->items[i].scale;
}

static sn_status write_rows(const job *j, const columns *all, sn_table *table, sn_error *error) {
    sn_status status = SN_OK;
    double *row = SN_NEW(double, all->count);
    if (row == NULL) return sn_fail_memory(error, "a table");
    for (sn_index k = 0; k < output_count(&j->sense) && status == SN_OK; k++) {
        fill_row(j, all, k, row);
        status = sn_table_append(table, row, error);
    }
    free(row);
    return status;
}

static sn_status write_columns(const job *j, const columns *all, const char *path, sn_error *error) {
    sn_table *table = NULL;
    const char **names = sn_alloc((size_t)all->count, sizeof *names);
    if (names == NULL) return sn_fail_memory(error, "a table");
    for (sn_index i = 0; i < all->count; i++) names[i] = all->items[i].name;
    sn_table_params params = {.title = j->sensors.name != NULL ? j->sensors.name : "motion-sense",
                              .rows = output_count(&j->sense),
                              .columns = all->count,
                              .names = names};
    sn_status status = sn_table_create(path, &params, &table, error);
    free(names);
    if (status == SN_OK) status = write_rows(j, all, table, error);
    if (status == SN_OK) return sn_table_commit(table, error);
    sn_table_abort(table);
    return status;
}

static sn_status write_table(const job *j, const char *path, bool readings, sn_error *error) {
    columns all;
    sn_status status = choose_columns(j, readings, !readings, &all, error);
    if (status == SN_OK) status = write_columns(j, &all, path, error);
    free_columns(&all);
    return status;
}

/* ---- the document --------------------------------------------------------------------------------------------------------------- */

static sn_status write_activations(const job *j, const sn_history_entry *entry, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open(j->c.output, false, &output, error);
    if (status != SN_OK) return status;
    status = sn_activation_document_write(&j->sensors, &j->sense, entry, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static bool ends_with(const char *text, const char *ending) {
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcasecmp(text + length - tail, ending) == 0;
}

static sn_status save(job *j, sn_error *error) {
    cli_history history = {0};
    const char *path = j->c.output;
    if (ends_with(path, ".tsv") || ends_with(path, ".sto") || ends_with(path, ".mot")) return write_table(j, path, false, error);
    sn_status status = j->c.history ? cli_history_make(&j->c, &history, error) : SN_OK;
    if (status == SN_OK) status = write_activations(j, j->c.history ? &history.entry : NULL, error);
    cli_history_free(&history);
    return status;
}

/* ---- chart -------------------------------------------------------------------------------------------------------------------------- */

/* More panels than this make no chart that can be read. */
enum { MOST_PANELS = 24 };

/* What a panel shows; NULL and NaN: nothing. */
typedef struct panel {
    const char *name, *unit;
    const double *readings, *activations;
    double scale, threshold;
} panel;

static panel panel_of_sensor(const job *j, sn_index i) {
    const sn_sensor *sensor = &j->sensors.sensors[i];
    double scale = sn_sensor_scale(sensor->kind);
    bool active = sensor->knot_count > 0 || sensor->has_trigger,
         by_reading = sensor->has_trigger && sensor->knot_count == 0; /* else the threshold is an activation */
    return (panel){.name = sensor->name,
                   .unit = sn_sensor_unit(sensor->kind),
                   .readings = j->sense.readings[i],
                   .activations = active ? j->sense.sensed[i] : NULL,
                   .scale = scale,
                   .threshold = by_reading ? sensor->trigger.threshold * scale : NAN};
}

/* A channel that only hands on a sensor, or does what the one before it does, shows nothing new. */
static bool shows_new(const job *j, sn_index i) {
    const sn_sense_channel *channel = &j->sensors.channels[i], *before = i > 0 ? channel - 1 : NULL;
    const double *of_sensor = j->sense.sensed[channel->inputs[0].sensor], *values = j->sense.activations[i];
    size_t size = (size_t)j->sense.sample_count * sizeof *values;
    if (channel->input_count == 1 && memcmp(of_sensor, values, size) == 0) return false;
    return before == NULL || memcmp(j->sense.activations[i - 1], values, size) != 0;
}

/* Sensors, then channels; at most MOST_PANELS are kept, all are counted. */
static sn_index choose_panels(const job *j, panel panels[MOST_PANELS]) {
    sn_index count = 0;
    for (sn_index i = 0; i < j->sense.sensor_count; i++, count++)
        if (count < MOST_PANELS) panels[count] = panel_of_sensor(j, i);
    for (sn_index i = 0; i < j->sense.channel_count; i++) {
        if (!shows_new(j, i)) continue;
        if (count < MOST_PANELS)
            panels[count] =
                (panel){.name = j->sensors.channels[i].name, .unit = "", .activations = j->sense.activations[i], .threshold = NAN};
        count++;
    }
    return count;
}

static void print_number_or_none(sn_output *output, bool there, double value) {
    char text[32] = "NaN";
    if (there) sn_format_number(value, text);
    print_field(output, text);
}

/* A block for share/plots/motion-sense.gp: a quoted title, then lines of time, reading, activation and threshold. */
static void print_panel(sn_output *output, const job *j, const panel *p) {
    char words[160];
    snprintf(words, sizeof words, "%.100s%s%s", p->name, p->unit[0] != '\0' ? ", " : "", p->unit);
    for (char *c = words; *c != '\0'; c++)
        if (*c == '"' || *c == '\\' || (unsigned char)*c < ' ') *c = '_';
    sn_output_print(output, "\"%s\"\n", words);
    for (sn_index k = 0; k < output_count(&j->sense); k++) {
        size_t at = (size_t)k * (size_t)j->sense.stride;
        sn_output_print(output, "%.9g", j->sense.begin + k / j->sense.rate);
        print_number_or_none(output, p->readings != NULL, p->readings != NULL ? p->readings[at] * p->scale : 0.0);
        print_number_or_none(output, p->activations != NULL, p->activations != NULL ? p->activations[at] : 0.0);
        print_number_or_none(output, isfinite(p->threshold), p->threshold);
        sn_output_print(output, "\n");
    }
    sn_output_print(output, "\n\n");
}

static sn_status write_chart_data(const job *j, const panel *panels, sn_index count, const char *path, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open(path, true, &output, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < count; i++) print_panel(output, j, &panels[i]);
    return sn_output_commit(output, error);
}

/* gnuplot, a child, reads the data by the number of a file that has no name. */
static sn_status draw_panels(job *j, const panel *panels, sn_index count, sn_error *error) {
    char path[64], number[16], sensors[16];
    const char *head = title != NULL ? title : j->sensors.name != NULL ? j->sensors.name : "";
    int data = memfd_create("motion-sense", 0);
    if (data < 0) return sn_fail(error, SN_ERROR_IO, "no room for the data of a chart");
    snprintf(path, sizeof path, "/proc/self/fd/%d", data);
    snprintf(number, sizeof number, "%d", (int)count);
    snprintf(sensors, sizeof sensors, "%d", (int)j->sense.sensor_count);
    sn_status status = write_chart_data(j, panels, count, path, error);
    if (status == SN_OK) chart_draw(&j->c, "motion-sense.gp", (const char *const[]){path, chart_file, head, number, sensors, NULL});
    close(data);
    return status;
}

static sn_status draw_chart(job *j, sn_error *error) {
    panel panels[MOST_PANELS];
    if (chart_file == NULL || j->sense.sensor_count == 0) return SN_OK;
    sn_index count = choose_panels(j, panels);
    if (count > MOST_PANELS)
        cli_warn(&j->c, "the chart shows the first %d of %d sensors and channels; --readings has all sensors", MOST_PANELS, (int)count);
    return draw_panels(j, panels, count < MOST_PANELS ? count : MOST_PANELS, error);
}

/* ---- work --------------------------------------------------------------------------------------------------------------------------- */

static sn_status measure(job *j, sn_error *error) {
    sn_sense_params params = SN_SENSE_PARAMS;
    params.trace = &j->c.trace;
    if (rate > 0.0) params.rate = rate;
    if (cli_given(&j->c, "filter")) params.cutoff = cutoff;
    sn_status status = look_for_jumps(j, error);
    if (status != SN_OK) return status;
    warn_of_filters(j);
    return sn_sense_run(&j->sensors, &j->clip, &params, &j->sense, error);
}

static sn_status sense_motion(job *j, sn_error *error) {
    sn_status status = load_motion(j, error);
    if (status == SN_OK) status = load_sensors(j, error);
    if (status == SN_OK && list) return print_list(j, error);
    if (status == SN_OK) status = measure(j, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, j->document.name != NULL ? j->document.name : j->motion.name);
        return status;
    }
    if (status == SN_OK) warn_of_results(j);
    cli_say(&j->c, "%d sensors, %d channels, %d samples at %g Hz", (int)j->sense.sensor_count, (int)j->sense.channel_count,
            (int)output_count(&j->sense), j->sense.rate);
    status = save(j, error);
    if (status == SN_OK && readings_file != NULL) status = write_table(j, readings_file, true, error);
    if (status == SN_OK) status = draw_chart(j, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

static void check_usage(const cli *c) {
    if (sensors_file == NULL && !list) cli_usage_error(c, "--sensors FILE is missing");
    if (readings_file != NULL && strcmp(readings_file, "-") == 0 && strcmp(c->output, "-") == 0)
        cli_usage_error(c, "--readings and --output cannot both go to the standard output");
    if (chart_file != NULL && !ends_with(chart_file, ".svg") && !ends_with(chart_file, ".png"))
        cli_usage_error(c, "--chart: the name of a chart ends in .svg or .png, not as '%s'", chart_file);
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    check_usage(&j.c);
    sn_status status = sense_motion(&j, &error);
    sn_sense_free(&j.sense);
    sn_sensors_free(&j.sensors);
    sn_clip_free(&j.clip);
    sn_muscle_names_free(&j.muscles);
    sn_blob_free(&j.motion);
    sn_blob_free(&j.document);
    sn_blob_free(&j.names);
    return cli_finish(&j.c, status, &error);
}
