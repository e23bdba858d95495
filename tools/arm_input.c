/* arm_input.c -- what moment-arm works on: lengths, the coordinate, the other coordinates, out of tables and motions. */
#include "arm_input.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/model_files.h"

#define DEGREES (180.0 / SN_PI)
#define LONGEST 3.0 /* m, of a length whose unit nobody has told */
#define FULL_TURN (2.0 * SN_PI)
#define UNKNOWN_LEAST 1e-9 /* a coordinate of no known unit moves by this */

const char *const arm_unit_names[] = {"degrees", "radians", "m", "cm", "mm", NULL};
enum { IN_DEGREES, IN_RADIANS, IN_METERS, IN_CENTIMETERS, IN_MILLIMETERS, UNIT_NOT_TOLD = -1 };
static const double unit_scale[] = {SN_PI / 180.0, 1.0, 1.0, 0.01, 0.001};
static bool is_way_unit(int unit) { return unit >= IN_METERS; }

/* ---- files ---------------------------------------------------------------------------------------------------------------------- */

static sn_status load_motion(const char *path, arm_input *out, sn_error *error) {
    sn_blob blob = {0};
    double rate;
    char *name = NULL;
    sn_status status = sn_blob_read(path, &blob, error);
    if (status != SN_OK) return status;
    out->has_motion = true;
    out->is_document = sn_motion_document_detect(&blob);
    if (out->is_document)
        status = sn_motion_document_parse(&blob, &out->motion, &name, &rate, error);
    else
        status = sn_number_table_parse(&blob, &out->motion_table, error);
    if (status == SN_OK && !out->is_document && out->motion_table.times == NULL)
        status = sn_fail_at(error, SN_ERROR_INPUT, path, 0, "the first column of a motion must be the time");
    free(name);
    sn_blob_free(&blob);
    return status;
}

static int compare_names(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

/* Two columns of one name would count twice, or the first alone. */
static sn_status check_names(const sn_columns *t, sn_error *error) {
    sn_status status = SN_OK;
    char **names = SN_NEW(char *, t->column_count);
    if (names == NULL) return sn_fail_memory(error, "the names of columns");
    for (sn_index i = 0; i < t->column_count; i++) names[i] = t->names[i];
    qsort(names, (size_t)t->column_count, sizeof *names, compare_names);
    for (sn_index i = 1; i < t->column_count && status == SN_OK; i++)
        if (strcmp(names[i - 1], names[i]) == 0)
            status = sn_fail_at(error, SN_ERROR_INPUT, t->name, t->names_line, "two columns are called \"%.120s\"", names[i]);
    free(names);
    return status;
}

sn_status arm_input_load(cli *c, const arm_choices *with, arm_input *out, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(c->inputs.items[0], &blob, error);
    if (status == SN_OK) {
        sn_hash(blob.data, blob.size, c->input_hash);
        status = sn_number_table_parse(&blob, &out->table, error);
        if (status == SN_OK) status = check_names(&out->table, error);
    }
    sn_blob_free(&blob);
    if (status == SN_OK && with->motion != NULL) status = load_motion(with->motion, out, error);
    if (status == SN_OK && out->has_motion && out->table.times == NULL)
        status = sn_fail_at(error, SN_ERROR_INPUT, out->table.name, 0, "the first column must be the time, as --motion is matched by it");
    return status;
}

/* ---- coordinates, wherever they are ------------------------------------------------------------------------------------------------ */

/* A coordinate of a table, of a motion document, or a hinge's angle in one. */
typedef struct place {
    const sn_columns *columns; /* NULL = the document */
    sn_index index;            /* column; in the document coordinates first, then joints */
    const char *name, *stem;
    size_t length; /* of the stem */
    int unit;      /* UNIT_NOT_TOLD where nobody tells it */
    bool named;    /* its name tells the unit */
} place;

typedef struct places {
    size_t count, capacity;
    place *items;
} places;

static sn_status add_place(places *all, const place *p, sn_error *error) {
    void *items = all->items;
    if (!sn_grow(&items, &all->capacity, all->count + 1, sizeof *p)) return sn_fail_memory(error, "the coordinates");
    all->items = items;
    all->items[all->count++] = *p;
    return SN_OK;
}

static bool is_length(const arm_input *in, const sn_columns *columns, sn_index column) {
    return columns == &in->table && in->is_length[column];
}

/* false: the column is no coordinate. */
static bool read_column(const sn_columns *columns, sn_index column, place *out) {
    *out = (place){.columns = columns, .index = column, .name = columns->names[column], .unit = UNIT_NOT_TOLD, .named = true};
    switch (sn_column_read_name(out->name, &out->stem, &out->length)) {
    case SN_COLUMN_DEGREES:
        out->unit = IN_DEGREES;
        return true;
    case SN_COLUMN_RADIANS:
        out->unit = IN_RADIANS;
        return true;
    case SN_COLUMN_METERS:
        out->unit = IN_METERS;
        return true;
    case SN_COLUMN_VALUE:
    case SN_COLUMN_PLAIN:
        break;
    default:
        return false;
    }
    out->named = false;
    if (columns->degrees_told && !sn_column_is_way(out->stem, out->length)) out->unit = columns->degrees ? IN_DEGREES : IN_RADIANS;
    return true;
}

static sn_status add_columns(const arm_input *in, const sn_columns *columns, places *all, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < columns->column_count && status == SN_OK; i++) {
        place p;
        if (!is_length(in, columns, i) && read_column(columns, i, &p)) status = add_place(all, &p, error);
    }
    return status;
}

static sn_status add_document(const sn_motion *motion, places *all, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < motion->coordinate_count && status == SN_OK; i++) {
        const sn_coordinate *c = &motion->coordinates[i];
        place p = {.index = i, .name = c->name, .stem = c->name, .length = strlen(c->name), .unit = UNIT_NOT_TOLD, .named = true};
        if (strcmp(c->unit, "rad") == 0) p.unit = IN_RADIANS;
        if (strcmp(c->unit, "m") == 0) p.unit = IN_METERS;
        status = add_place(all, &p, error);
    }
    for (sn_index i = 0; i < motion->joint_count && status == SN_OK; i++) {
        const char *name = motion->joints[i].name;
        place p = {
            .index = motion->coordinate_count + i, .name = name, .stem = name, .length = strlen(name), .unit = IN_RADIANS, .named = true};
        if (motion->joints[i].kind == SN_JOINT_HINGE) status = add_place(all, &p, error);
    }
    return status;
}

static sn_status add_motion(const arm_input *in, places *all, sn_error *error) {
    return in->is_document ? add_document(&in->motion, all, error) : add_columns(in, &in->motion_table, all, error);
}

static bool same_stem(const place *a, const place *b) { return a->length == b->length && memcmp(a->stem, b->stem, a->length) == 0; }

/* ---- values --------------------------------------------------------------------------------------------------------------------- */

static double of_document(const sn_motion *motion, sn_index index, double time) {
    if (index >= motion->coordinate_count) return sn_channel_at(&motion->joints[index - motion->coordinate_count].angle, time);
    const sn_coordinate *c = &motion->coordinates[index];
    double slack = 1e-3 / c->rate;
    return time >= -slack && time <= (c->count - 1) / c->rate + slack ? sn_coordinate_at(c, time) : NAN;
}

/* Of the place, at each row of the table; NaN where there is none. The scale is not applied. */
static void read_values(const arm_input *in, const place *p, double *out) {
    const sn_columns *table = &in->table;
    double step = p->columns != NULL && p->columns != table ? sn_columns_median_step(p->columns) : 0.0;
    for (sn_index i = 0; i < table->row_count; i++) {
        if (p->columns == table)
            out[i] = table->values[(size_t)i * (size_t)table->column_count + (size_t)p->index];
        else if (p->columns != NULL)
            out[i] = sn_columns_at(p->columns, p->index, step, table->times[i]);
        else
            out[i] = of_document(&in->motion, p->index, table->times[i]);
        if (!isfinite(out[i])) out[i] = NAN;
    }
}

static double range_of(const double *values, sn_index count) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < count; i++) {
        if (isnan(values[i])) continue;
        low = fmin(low, values[i]);
        high = fmax(high, values[i]);
    }
    return low <= high ? high - low : 0.0;
}

static void scale_by(double *values, sn_index count, double scale) {
    for (sn_index i = 0; i < count; i++) values[i] *= scale;
}

/* ---- the coordinate ------------------------------------------------------------------------------------------------------------- */

static void list_words(const char *const *words, size_t size, char *list) {
    size_t used = 0;
    for (size_t i = 0; words[i] != NULL && used + 4 < size; i++)
        used += (size_t)snprintf(list + used, size - used, "%s%s", i > 0 ? ", " : "", words[i]);
}

static sn_status no_such_coordinate(const arm_choices *with, const char *file, const places *all, sn_error *error) {
    char list[400] = "";
    char **words = SN_NEW(char *, all->count + 1);
    bool enough = words != NULL;
    for (size_t i = 0; enough && i < all->count; i++) enough = (words[i] = sn_strndup(all->items[i].stem, all->items[i].length)) != NULL;
    const char *meant = enough ? sn_nearest_word(with->coordinate, SIZE_MAX, (const char *const *)words) : NULL;
    if (enough) list_words((const char *const *)words, sizeof list, list);
    if (!enough)
        (void)sn_fail_memory(error, "the coordinates");
    else if (all->count == 0)
        (void)sn_fail_at(error, SN_ERROR_INPUT, file, 0, "there is no coordinate at all; --motion FILE names where they are");
    else
        (void)sn_fail_at(error, SN_ERROR_INPUT, file, 0, "there is no coordinate \"%.80s\"%s%.320s%s", with->coordinate,
                         meant != NULL ? "; did you mean \"" : ", but ", meant != NULL ? meant : list, meant != NULL ? "\"?" : "");
    for (size_t i = 0; words != NULL && i < all->count; i++) free(words[i]);
    free(words);
    return enough ? SN_ERROR_INPUT : SN_ERROR_MEMORY;
}

/* By its whole name, else by its stem, if that is one's alone. A document's coordinate goes before a hinge of the same name. */
static sn_status find_place(const arm_choices *with, const char *file, const places *all, place *out, sn_error *error) {
    const place *found = NULL;
    for (size_t i = 0; i < all->count && found == NULL; i++)
        if (strcmp(all->items[i].name, with->coordinate) == 0) found = &all->items[i];
    for (size_t i = 0; i < all->count && (found == NULL || strcmp(found->name, with->coordinate) != 0); i++) {
        const place *p = &all->items[i];
        if (strlen(with->coordinate) != p->length || memcmp(p->stem, with->coordinate, p->length) != 0) continue;
        if (found != NULL)
            return sn_fail_at(error, SN_ERROR_INPUT, file, 0, "\"%.80s\" may be \"%.120s\" or \"%.120s\"; write which", with->coordinate,
                              found->name, p->name);
        found = p;
    }
    if (found == NULL) return no_such_coordinate(with, file, all, error);
    *out = *found;
    return SN_OK;
}

static sn_status choose_unit(const arm_choices *with, const char *file, place *p, sn_error *error) {
    int told = p->unit;
    if (with->unit >= 0 && p->named && told != UNIT_NOT_TOLD && told != with->unit)
        return sn_fail_at(error, SN_ERROR_USAGE, file, 0, "\"%.120s\" is in %s, not in %s", p->name, arm_unit_names[told],
                          arm_unit_names[with->unit]);
    if (with->unit >= 0) p->unit = with->unit;
    if (p->unit != UNIT_NOT_TOLD) return SN_OK;
    if (sn_column_is_way(p->stem, p->length))
        return sn_fail_at(error, SN_ERROR_INPUT, file, 0,
                          "\"%.120s\" may be a way, as OpenSim calls them so; say --unit m, or --unit degrees", p->name);
    return sn_fail_at(error, SN_ERROR_INPUT, file, 0, "nothing tells the unit of \"%.120s\"; say --unit degrees, radians or m", p->name);
}

/* Radians that are degrees, and degrees that may be radians. values: in radians. */
static sn_status check_angle(const cli *c, const arm_choices *with, const place *p, double range, sn_error *error) {
    if (p->unit == IN_RADIANS && range > FULL_TURN * (1.0 + 1e-9)) {
        if (with->unit < 0 && !p->named)
            return sn_fail_at(error, SN_ERROR_INPUT, p->columns->name, 0,
                              "\"%.120s\" moves by %.4g radians, more than a full turn: if these are degrees, say --unit degrees", p->name,
                              range);
        cli_warn(c, "\"%s\" moves by %.4g radians, more than a full turn: are these degrees?", p->name, range);
    }
    if (p->unit == IN_DEGREES && with->unit < 0 && !p->named && range * DEGREES < FULL_TURN)
        cli_warn(c, "\"%s\" moves by %.3g degrees in all; if these are radians, say --unit radians", p->name, range * DEGREES);
    return SN_OK;
}

/* Rows whose time is not one of the motion's. */
static sn_index count_between(const arm_input *in, const place *p) {
    sn_index count = 0, k = 0;
    double slack = 1e-3 * sn_columns_median_step(p->columns);
    for (sn_index i = 0; i < in->table.row_count; i++) {
        while (k + 1 < p->columns->row_count && p->columns->times[k] < in->table.times[i] - slack) k++;
        count += !isnan(in->values[i]) && fabs(p->columns->times[k] - in->table.times[i]) > slack;
    }
    return count;
}

static void warn_of_rows(const cli *c, arm_input *in) {
    sn_index rows = in->table.row_count;
    for (sn_index i = 0; i < rows; i++) in->unused += isnan(in->values[i]);
    if (in->unused > 0)
        cli_warn(c, "%s: %d of %d rows are not used, as \"%s\" has no value there%s", in->table.name, in->unused, rows, in->coordinate,
                 in->has_motion ? " (before, behind or in a gap of the motion, or not a number)" : "");
}

static sn_status choose_coordinate(const cli *c, const arm_choices *with, arm_input *in, place *p, sn_error *error) {
    places all = {0};
    in->file = in->has_motion ? with->motion : in->table.name;
    sn_status status = in->has_motion ? add_motion(in, &all, error) : add_columns(in, &in->table, &all, error);
    if (status == SN_OK) status = find_place(with, in->file, &all, p, error);
    free(all.items);
    if (status == SN_OK) status = choose_unit(with, in->file, p, error);
    if (status != SN_OK) return status;
    in->coordinate = p->name;
    in->is_way = is_way_unit(p->unit);
    in->values = SN_NEW(double, in->table.row_count);
    if (in->values == NULL) return sn_fail_memory(error, "a coordinate");
    read_values(in, p, in->values);
    scale_by(in->values, in->table.row_count, unit_scale[p->unit]);
    if (p->columns == &in->motion_table) in->between = count_between(in, p);
    warn_of_rows(c, in);
    return in->is_way ? SN_OK : check_angle(c, with, p, range_of(in->values, in->table.row_count), error);
}

/* ---- the others ----------------------------------------------------------------------------------------------------------------- */

static sn_status add_other(arm_input *in, const place *p, sn_error *error) {
    double *values = SN_NEW(double, in->table.row_count);
    sn_arm_other *other = &in->others[in->other_count];
    char *name = sn_strndup(p->stem, p->length);
    if (values == NULL || name == NULL) {
        free(values);
        free(name);
        return sn_fail_memory(error, "the other coordinates");
    }
    read_values(in, p, values);
    if (p->unit != UNIT_NOT_TOLD) scale_by(values, in->table.row_count, unit_scale[p->unit]);
    double least = is_way_unit(p->unit) || sn_column_is_way(p->stem, p->length) ? SN_ARM_LEAST_WAY
                   : p->unit == UNIT_NOT_TOLD                                   ? UNKNOWN_LEAST
                                                                                : SN_ARM_LEAST_ANGLE;
    in->other_count++;
    *other = (sn_arm_other){.name = name, .values = values, .least = least};
    return SN_OK;
}

static bool is_known(const place *p, const places *all, size_t before) {
    for (size_t i = 0; i < before; i++)
        if (same_stem(p, &all->items[i])) return true;
    return false;
}

/* All but the coordinate, each stem once: the motion's before the table's. */
static sn_status choose_others(arm_input *in, const place *coordinate, sn_error *error) {
    places all = {0};
    sn_status status = in->has_motion ? add_motion(in, &all, error) : SN_OK;
    if (status == SN_OK) status = add_columns(in, &in->table, &all, error);
    if (status == SN_OK && (in->others = SN_NEW(sn_arm_other, all.count)) == NULL) status = sn_fail_memory(error, "the other coordinates");
    for (size_t i = 0; i < all.count && status == SN_OK; i++)
        if (!same_stem(&all.items[i], coordinate) && !is_known(&all.items[i], &all, i)) status = add_other(in, &all.items[i], error);
    free(all.items);
    return status;
}

/* ---- lengths -------------------------------------------------------------------------------------------------------------------- */

static double value_of(const sn_columns *t, sn_index row, sn_index column) {
    return t->values[(size_t)row * (size_t)t->column_count + (size_t)column];
}

static bool is_positive(const sn_columns *t, sn_index column) {
    sn_index there = 0;
    for (sn_index i = 0; i < t->row_count; i++) {
        double value = value_of(t, i, column);
        if (isnan(value)) continue;
        if (!(value > 0.0 && isfinite(value))) return false;
        there++;
    }
    return there > 0;
}

static bool is_wanted(const arm_choices *with, const char *stem, size_t length) {
    char name[256];
    if (with->muscles.count == 0) return true;
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), stem);
    for (int i = 0; i < with->muscles.count; i++)
        if (sn_pattern_matches(with->muscles.items[i], name)) return true;
    return false;
}

/* Plain columns: is this the coordinate by its name? */
static bool is_coordinate(const arm_input *in, const arm_choices *with, const char *name) {
    return !in->has_motion && strcmp(name, with->coordinate) == 0;
}

/* The columns that are lengths by their names; where no name says so, all plain ones with positive numbers. */
static void choose_columns(const cli *c, const arm_choices *with, arm_input *in) {
    const sn_columns *t = &in->table;
    sn_index named = 0, plain = 0, not_positive = 0;
    const char *stem, *example = NULL;
    size_t length;
    for (sn_index i = 0; i < t->column_count; i++) {
        sn_column_kind kind = sn_column_read_name(t->names[i], &stem, &length);
        named += kind == SN_COLUMN_FIBER || kind == SN_COLUMN_LENGTH;
    }
    for (sn_index i = 0; i < t->column_count; i++) {
        sn_column_kind kind = sn_column_read_name(t->names[i], &stem, &length);
        bool taken = kind == SN_COLUMN_FIBER || kind == SN_COLUMN_LENGTH;
        if (named == 0 && kind == SN_COLUMN_PLAIN && !is_coordinate(in, with, t->names[i])) {
            taken = is_positive(t, i);
            plain += taken;
            not_positive += !taken;
            if (!taken && example == NULL) example = t->names[i];
        }
        in->is_length[i] = taken;
        if (taken && is_wanted(with, stem, length)) in->columns[in->fiber_count++] = i;
    }
    if (plain > 0)
        cli_warn(c, "%s: no name of a column says that it is a length (NAME.1, PATH|length); taken for lengths: the %d that are positive",
                 t->name, plain);
    if (not_positive > 0)
        cli_warn(c, "%s: %d columns are no lengths, as they have numbers that are not positive: \"%s\"%s", t->name, not_positive, example,
                 not_positive > 1 ? " and others" : "");
}

static sn_status find_muscle(arm_input *in, const char *stem, size_t length, sn_index *out, sn_error *error) {
    for (sn_index i = in->muscle_count - 1; i >= 0; i--) {
        *out = i;
        if (strlen(in->muscles[i]) == length && memcmp(in->muscles[i], stem, length) == 0) return SN_OK;
    }
    *out = in->muscle_count;
    if ((in->muscles[in->muscle_count] = sn_strndup(stem, length)) == NULL) return sn_fail_memory(error, "the muscles");
    in->muscle_count++;
    return SN_OK;
}

static sn_status name_muscles(arm_input *in, sn_error *error) {
    sn_status status = SN_OK;
    in->muscles = SN_NEW(char *, in->fiber_count);
    in->muscle_of = SN_NEW(sn_index, in->fiber_count);
    in->lengths = SN_NEW(double *, in->fiber_count);
    if (!in->muscles || !in->muscle_of || !in->lengths) return sn_fail_memory(error, "the lengths");
    for (sn_index f = 0; f < in->fiber_count && status == SN_OK; f++) {
        const char *stem;
        size_t length;
        sn_column_read_name(in->table.names[in->columns[f]], &stem, &length);
        status = find_muscle(in, stem, length, &in->muscle_of[f], error);
    }
    return status;
}

static sn_status read_lengths(arm_input *in, sn_index fiber, double scale, sn_error *error) {
    const sn_columns *t = &in->table;
    const char *name = t->names[in->columns[fiber]];
    sn_index there = 0;
    double *to = in->lengths[fiber] = SN_NEW(double, t->row_count);
    if (to == NULL) return sn_fail_memory(error, "the lengths");
    for (sn_index i = 0; i < t->row_count; i++) {
        to[i] = value_of(t, i, in->columns[fiber]);
        if (isnan(to[i])) {
            in->missing++;
            continue;
        }
        if (!(to[i] > 0.0 && isfinite(to[i])))
            return sn_fail_at(error, SN_ERROR_INPUT, t->name, 0, "\"%.120s\" is no length: %g in row %d", name, to[i], (int)i + 1);
        to[i] *= scale;
        there++;
    }
    return there > 0 ? SN_OK : sn_fail_at(error, SN_ERROR_INPUT, t->name, 0, "\"%.120s\" has no number at all", name);
}

static sn_status check_unit(const arm_input *in, sn_error *error) {
    double most = 0.0;
    sn_index of = 0;
    for (sn_index f = 0; f < in->fiber_count; f++)
        for (sn_index i = 0; i < in->table.row_count; i++) {
            if (!(in->lengths[f][i] > most)) continue;
            most = in->lengths[f][i];
            of = f;
        }
    if (!(most > LONGEST)) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, in->table.name, 0,
                      "\"%.120s\" is %.4g m long: if these are millimetres, say --length-unit mm (or cm; or m, if it is so)",
                      in->table.names[in->columns[of]], most);
}

static sn_status check_patterns(const arm_choices *with, const arm_input *in, sn_error *error) {
    for (int i = 0; i < with->muscles.count; i++) {
        bool found = false;
        for (sn_index m = 0; m < in->muscle_count && !found; m++) found = sn_pattern_matches(with->muscles.items[i], in->muscles[m]);
        if (!found)
            return sn_fail_at(error, SN_ERROR_INPUT, in->table.name, 0, "--muscles: nothing is called \"%.100s\"", with->muscles.items[i]);
    }
    return SN_OK;
}

static sn_status choose_lengths(const cli *c, const arm_choices *with, arm_input *in, sn_error *error) {
    in->columns = SN_NEW(sn_index, in->table.column_count);
    in->is_length = SN_NEW(bool, in->table.column_count);
    if (in->columns == NULL || in->is_length == NULL) return sn_fail_memory(error, "the lengths");
    choose_columns(c, with, in);
    if (in->fiber_count == 0 && with->muscles.count == 0)
        return sn_fail_at(error, SN_ERROR_INPUT, in->table.name, 0, "no column holds lengths; --list shows what the columns are taken for");
    double scale = with->length_unit >= 0 ? cli_unit_meters[with->length_unit] : 1.0;
    sn_status status = name_muscles(in, error);
    if (status == SN_OK) status = check_patterns(with, in, error);
    for (sn_index f = 0; f < in->fiber_count && status == SN_OK; f++) status = read_lengths(in, f, scale, error);
    if (status == SN_OK && with->length_unit < 0) status = check_unit(in, error);
    if (status == SN_OK && in->missing > 0)
        cli_warn(c, "%s: %d lengths are missing; each fibre is fitted to those that it has", in->table.name, in->missing);
    return status;
}

sn_status arm_input_choose(cli *c, const arm_choices *with, arm_input *in, sn_error *error) {
    place coordinate = {0};
    sn_status status = choose_lengths(c, with, in, error);
    if (status == SN_OK) status = choose_coordinate(c, with, in, &coordinate, error);
    if (status == SN_OK) status = choose_others(in, &coordinate, error);
    return status;
}

/* ---- list ----------------------------------------------------------------------------------------------------------------------- */

static void print_line(sn_output *output, const char *file, const char *name, const char *what, int unit) {
    sn_output_print(output, "%s\t", file);
    for (; *name != '\0'; name++) sn_output_write(output, (unsigned char)*name < ' ' ? " " : name, 1, NULL);
    sn_output_print(output, "\t%s\t%s\n", what, unit != UNIT_NOT_TOLD ? arm_unit_names[unit] : "-");
}

static void print_columns(sn_output *output, const char *file, const sn_columns *columns) {
    for (sn_index i = 0; i < columns->column_count; i++) {
        const char *stem;
        size_t length;
        place p;
        sn_column_kind kind = sn_column_read_name(columns->names[i], &stem, &length);
        bool coordinate = read_column(columns, i, &p);
        const char *what = kind == SN_COLUMN_FIBER || kind == SN_COLUMN_LENGTH ? "length"
                           : kind == SN_COLUMN_PLAIN && file[0] == 't'         ? "plain"
                           : coordinate                                        ? "coordinate"
                                                                               : "other";
        print_line(output, file, columns->names[i], what, strcmp(what, "length") == 0 ? UNIT_NOT_TOLD : p.unit);
    }
}

sn_status arm_input_list(const arm_input *in, sn_error *error) {
    sn_output *output;
    places all = {0};
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    print_columns(output, "table", &in->table);
    if (in->has_motion && !in->is_document) print_columns(output, "motion", &in->motion_table);
    if (in->is_document) status = add_document(&in->motion, &all, error);
    for (size_t i = 0; i < all.count; i++) print_line(output, "motion", all.items[i].name, "coordinate", all.items[i].unit);
    free(all.items);
    if (status == SN_OK) status = sn_output_commit(output, error);
    return status == SN_OK ? SN_STOPPED : status;
}

/* ---- all ------------------------------------------------------------------------------------------------------------------------ */

sn_arm_input arm_input_view(const arm_input *in) {
    return (sn_arm_input){.row_count = in->table.row_count,
                          .coordinate = in->values,
                          .fiber_count = in->fiber_count,
                          .lengths = (const double *const *)in->lengths,
                          .muscle_count = in->muscle_count,
                          .muscles = (const char *const *)in->muscles,
                          .muscle_of = in->muscle_of,
                          .other_count = in->other_count,
                          .others = in->others};
}

void arm_input_free(arm_input *in) {
    for (sn_index i = 0; in->lengths != NULL && i < in->fiber_count; i++) free(in->lengths[i]);
    for (sn_index i = 0; i < in->muscle_count; i++) free(in->muscles[i]);
    for (sn_index i = 0; i < in->other_count; i++) {
        free((void *)(uintptr_t)in->others[i].name);
        free((void *)(uintptr_t)in->others[i].values);
    }
    free(in->values);
    free(in->columns);
    free(in->is_length);
    free(in->lengths);
    free(in->muscle_of);
    free(in->muscles);
    free(in->others);
    sn_columns_free(&in->table);
    sn_columns_free(&in->motion_table);
    sn_motion_free(&in->motion);
    *in = (arm_input){0};
}
