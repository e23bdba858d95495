/* number_table.c -- tables of numbers, as of lengths and coordinates: OpenSim's storage, or text with a row of names. */
#include "cells.h"
#include "sinew/arm_files.h"
#include "sinew/model_files.h"

#include <stdlib.h>
#include <string.h>

/* ---- reading -------------------------------------------------------------------------------------------------------------------- */

typedef struct table {
    sn_cells cells;
    sn_span *row; /* (columns) */
    bool timed;   /* the first column is the time */
    size_t time_capacity, value_capacity;
    sn_columns *out;
} table;

/* The table takes the names. */
static sn_status take_names(table *t) {
    sn_columns *out = t->out;
    sn_index count = t->cells.column_count;
    t->timed = sn_span_is_like((sn_span){t->cells.names[0], strlen(t->cells.names[0])}, "time");
    out->names = SN_NEW(char *, count);
    t->row = SN_NEW(sn_span, count);
    if (out->names == NULL || t->row == NULL) return sn_fail_memory(t->cells.error, "a table");
    for (sn_index i = t->timed; i < count; i++) {
        out->names[out->column_count] = sn_strdup(t->cells.names[i]);
        if (out->names[out->column_count++] == NULL) return sn_fail_memory(t->cells.error, "a table");
    }
    out->names_line = t->cells.line;
    return SN_OK;
}

static sn_status make_room(table *t) {
    void *times = t->out->times, *values = t->out->values;
    size_t rows = (size_t)t->out->row_count + 1, columns = (size_t)t->out->column_count;
    bool enough = t->out->row_count < SN_INDEX_MAX && (!t->timed || sn_grow(&times, &t->time_capacity, rows, sizeof(double)));
    t->out->times = times;
    enough = enough && sn_grow(&values, &t->value_capacity, rows * columns + 1, sizeof(double));
    t->out->values = values;
    return enough ? SN_OK : sn_fail_memory(t->cells.error, "a table");
}

static sn_status read_row(table *t) {
    sn_columns *out = t->out;
    sn_status status = make_room(t);
    if (out->row_count == 0) out->first_line = t->cells.line;
    double *to = status == SN_OK ? &out->values[(size_t)out->row_count * (size_t)out->column_count] : NULL;
    if (status == SN_OK && t->timed) status = sn_cells_number(&t->cells, 0, t->row[0], &out->times[out->row_count]);
    for (sn_index i = 0; i < out->column_count && status == SN_OK; i++)
        status = sn_cells_number(&t->cells, i + t->timed, t->row[i + t->timed], &to[i]);
    out->row_count += status == SN_OK;
    return status;
}

static sn_status read_rows(table *t) {
    bool more = true;
    sn_status status = SN_OK;
    while (status == SN_OK && more) {
        status = sn_cells_next(&t->cells, t->row, &more);
        if (status == SN_OK && more) status = read_row(t);
    }
    return status == SN_OK && t->out->row_count == 0 ? sn_cells_fail(&t->cells, "there is no row of numbers") : status;
}

static sn_status parse_text(const sn_blob *blob, sn_columns *out, sn_error *error) {
    table t = {.out = out};
    *out = (sn_columns){.name = sn_strdup(blob->name)};
    if (out->name == NULL) return sn_fail_memory(error, "a table");
    sn_status status = sn_cells_begin(blob, &t.cells, error);
    if (status == SN_OK) status = take_names(&t);
    if (status == SN_OK && out->column_count == 0) status = sn_cells_fail(&t.cells, "there is no column beside the time");
    if (status == SN_OK) status = read_rows(&t);
    sn_cells_free(&t.cells);
    free(t.row);
    return status;
}

static sn_status check_times(const sn_columns *c, sn_error *error) {
    for (sn_index i = 0; c->times != NULL && i < c->row_count; i++) {
        if (!isfinite(c->times[i])) return sn_fail_at(error, SN_ERROR_INPUT, c->name, 0, "the time of row %d is not finite", (int)i + 1);
        if (i > 0 && !(c->times[i] > c->times[i - 1]))
            return sn_fail_at(error, SN_ERROR_INPUT, c->name, 0,
                              "the times must ascend, and row %d is at %.9g s behind %.9g s; sort the rows", (int)i + 1, c->times[i],
                              c->times[i - 1]);
    }
    return SN_OK;
}

sn_status sn_number_table_parse(const sn_blob *blob, sn_columns *out, sn_error *error) {
    sn_status status = sn_storage_detect(blob) ? sn_storage_parse(blob, out, error) : parse_text(blob, out, error);
    if (status == SN_OK) status = check_times(out, error);
    if (status != SN_OK) sn_columns_free(out);
    return status;
}

/* ---- looking up ----------------------------------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double sn_columns_median_step(const sn_columns *c) {
    sn_index count = c->times != NULL ? c->row_count - 1 : 0;
    double *steps = SN_NEW(double, count), median = 0.0;
    for (sn_index i = 0; steps != NULL && i < count; i++) steps[i] = c->times[i + 1] - c->times[i];
    if (steps != NULL && count > 0) {
        qsort(steps, (size_t)count, sizeof *steps, compare);
        median = steps[count / 2];
    }
    free(steps);
    return median;
}

#define TIME_ROUNDING 1e-3 /* of a step: times in text are rounded */

double sn_columns_at(const sn_columns *c, sn_index column, double median_step, double time) {
    sn_index low = 0, high = c->row_count - 1;
    double slack = TIME_ROUNDING * median_step;
    if (time < c->times[0] - slack || time > c->times[high] + slack) return NAN;
    while (high - low > 1) {
        sn_index middle = low + (high - low) / 2;
        if (c->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    const double *values = c->values + column;
    double a = values[(size_t)low * (size_t)c->column_count], b = values[(size_t)high * (size_t)c->column_count];
    if (fabs(time - c->times[low]) <= slack) return a;
    if (fabs(time - c->times[high]) <= slack) return b;
    if (c->times[high] - c->times[low] > SN_TABLE_GAP * median_step) return NAN;
    return a + (b - a) * (time - c->times[low]) / (c->times[high] - c->times[low]);
}

/* ---- names of columns ------------------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *name, size_t length, const char *ending) {
    size_t tail = strlen(ending);
    return length > tail && memcmp(name + length - tail, ending, tail) == 0;
}

/* "NAME.7": the length of NAME, else 0. */
static size_t before_number(const char *name, size_t length) {
    size_t at = length;
    while (at > 0 && name[at - 1] >= '0' && name[at - 1] <= '9') at--;
    return at < length && at > 1 && name[at - 1] == '.' ? at - 1 : 0;
}

/* What stands behind the last slash. */
static void last_part(const char **stem, size_t *length) {
    for (size_t i = *length; i > 0; i--) {
        if ((*stem)[i - 1] != '/') continue;
        *stem += i;
        *length -= i;
        return;
    }
}

sn_column_kind sn_column_read_name(const char *name, const char **stem, size_t *length) {
    static const struct {
        const char *ending;
        sn_column_kind kind;
        bool path; /* the stem is the last part of what is left */
    } endings[] = {{".angle", SN_COLUMN_DEGREES, false},
                   {".rad", SN_COLUMN_RADIANS, false},
                   {".m", SN_COLUMN_METERS, false},
                   {"|length", SN_COLUMN_LENGTH, true},
                   {"/value", SN_COLUMN_VALUE, true}};
    size_t whole = strlen(name);
    *stem = name;
    *length = before_number(name, whole);
    if (*length > 0) return SN_COLUMN_FIBER;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        if (!ends_with(name, whole, endings[i].ending)) continue;
        *length = whole - strlen(endings[i].ending);
        if (endings[i].path) last_part(stem, length);
        return endings[i].kind;
    }
    *length = whole;
    return *name == '/' || strchr(name, '|') != NULL ? SN_COLUMN_OTHER : SN_COLUMN_PLAIN;
}

bool sn_column_is_way(const char *stem, size_t length) {
    return ends_with(stem, length, "_tx") || ends_with(stem, length, "_ty") || ends_with(stem, length, "_tz");
}
