/* measured_arms.c -- moment arms as they were measured: a row for each muscle and angle. */
#include "cells.h"
#include "sinew/arm_files.h"

#include <stdlib.h>
#include <string.h>

#define LONGEST_ARM 0.5 /* m */

/* Columns by what they hold. */
enum { MUSCLE, COORDINATE, ANGLE, ARM, SPREAD, LOWER, UPPER, KINDS };

typedef struct measured_row {
    sn_span muscle;
    sn_index order;
    double angle, arm, lower, upper;
} measured_row;

typedef struct reader {
    sn_cells cells;
    sn_measured_choice *choice;
    sn_index column[KINDS]; /* SN_NONE = there is none */
    double scale[KINDS];    /* to metres and radians */
    sn_span *row;           /* (columns) */
    size_t capacity;
    sn_index count;
    measured_row *rows; /* (count) */
} reader;

/* ---- columns -------------------------------------------------------------------------------------------------------------------- */

static sn_status take_column(reader *r, int kind, sn_index column, double scale) {
    if (r->column[kind] != SN_NONE)
        return sn_cells_fail(&r->cells, "the columns \"%.60s\" and \"%.60s\" hold the same", r->cells.names[r->column[kind]],
                             r->cells.names[column]);
    r->column[kind] = column;
    r->scale[kind] = scale;
    return SN_OK;
}

static sn_status find_columns(reader *r) {
    static const struct {
        const char *name;
        int kind;
        double scale;
    } known[] = {{"muscle", MUSCLE, 1.0},         {"coordinate", COORDINATE, 1.0}, {"angle.rad", ANGLE, 1.0},
                 {"angle", ANGLE, SN_PI / 180.0}, {"position", ANGLE, 1.0},        {"arm", ARM, 1.0},
                 {"arm.cm", ARM, 0.01},           {"arm.mm", ARM, 0.001},          {"sd", SPREAD, 1.0},
                 {"sd.cm", SPREAD, 0.01},         {"sd.mm", SPREAD, 0.001},        {"lower", LOWER, 1.0},
                 {"lower.cm", LOWER, 0.01},       {"lower.mm", LOWER, 0.001},      {"upper", UPPER, 1.0},
                 {"upper.cm", UPPER, 0.01},       {"upper.mm", UPPER, 0.001}};
    sn_status status = SN_OK;
    for (int k = 0; k < KINDS; k++) r->column[k] = SN_NONE;
    for (sn_index c = 0; c < r->cells.column_count && status == SN_OK; c++)
        for (size_t i = 0; i < sizeof known / sizeof *known && status == SN_OK; i++)
            if (strcmp(r->cells.names[c], known[i].name) == 0) status = take_column(r, known[i].kind, c, known[i].scale);
    return status;
}

static sn_status check_columns(const reader *r) {
    static const char *const needed[] = {"muscle", NULL, NULL, "arm (metres), arm.cm or arm.mm"};
    for (int k = MUSCLE; k <= ARM; k++) {
        const char *name = k == ANGLE ? r->choice->is_way ? "position (metres)" : "angle (degrees) or angle.rad" : needed[k];
        if (name != NULL && r->column[k] == SN_NONE) return sn_cells_fail(&r->cells, "there is no column %s", name);
    }
    if (r->choice->is_way != (strcmp(r->cells.names[r->column[ANGLE]], "position") == 0))
        return sn_cells_fail(&r->cells, "the column \"%s\" does not fit a coordinate that is %s", r->cells.names[r->column[ANGLE]],
                             r->choice->is_way ? "a way" : "an angle");
    if ((r->column[LOWER] == SN_NONE) != (r->column[UPPER] == SN_NONE))
        return sn_cells_fail(&r->cells, "a band needs both lower and upper");
    return SN_OK;
}

/* ---- rows ----------------------------------------------------------------------------------------------------------------------- */

static sn_status read_value(const reader *r, int kind, double *out) {
    *out = NAN;
    if (r->column[kind] == SN_NONE) return SN_OK;
    sn_status status = sn_cells_number(&r->cells, r->column[kind], r->row[r->column[kind]], out);
    *out *= r->scale[kind];
    return status;
}

static sn_status check_row(const reader *r, const measured_row *row, double spread) {
    if (!isfinite(row->angle)) return sn_cells_fail(&r->cells, "an arm without an angle");
    if (!r->choice->is_way && !(fabs(row->arm) <= LONGEST_ARM))
        return sn_cells_fail(&r->cells, "an arm of %g m: is it in mm? Call the column arm.mm, or arm.cm", row->arm);
    if (spread < 0.0) return sn_cells_fail(&r->cells, "a standard deviation is negative");
    if (row->lower > row->upper) return sn_cells_fail(&r->cells, "lower is above upper");
    if (row->muscle.length == 0) return sn_cells_fail(&r->cells, "a row without a muscle");
    return SN_OK;
}

static bool is_of_coordinate(const reader *r) {
    const char *wanted, *is;
    size_t wanted_length, length;
    if (r->column[COORDINATE] == SN_NONE) return true;
    char name[256];
    sn_span cell = r->row[r->column[COORDINATE]];
    if (cell.length >= sizeof name) return false;
    memcpy(name, cell.text, cell.length);
    name[cell.length] = '\0';
    sn_column_read_name(name, &is, &length);
    sn_column_read_name(r->choice->coordinate, &wanted, &wanted_length);
    return length == wanted_length && memcmp(is, wanted, length) == 0;
}

static sn_status add_row(reader *r, const measured_row *row) {
    void *rows = r->rows;
    if (!sn_grow(&rows, &r->capacity, (size_t)r->count + 1, sizeof *row)) return sn_fail_memory(r->cells.error, "measured arms");
    r->rows = rows;
    r->rows[r->count++] = *row;
    return SN_OK;
}

static sn_status read_row(reader *r) {
    measured_row row = {.muscle = r->row[r->column[MUSCLE]], .order = r->count};
    double spread = NAN;
    if (!is_of_coordinate(r)) {
        r->choice->skipped++;
        return SN_OK;
    }
    sn_status status = read_value(r, ANGLE, &row.angle);
    if (status == SN_OK) status = read_value(r, ARM, &row.arm);
    if (status == SN_OK) status = read_value(r, SPREAD, &spread);
    if (status == SN_OK) status = read_value(r, LOWER, &row.lower);
    if (status == SN_OK) status = read_value(r, UPPER, &row.upper);
    if (status != SN_OK || isnan(row.arm)) return status;
    if (isnan(row.lower) || isnan(row.upper)) {
        row.lower = row.arm - spread;
        row.upper = row.arm + spread;
    }
    status = check_row(r, &row, spread);
    return status == SN_OK ? add_row(r, &row) : status;
}

static sn_status read_rows(reader *r) {
    bool more = true;
    sn_status status = SN_OK;
    while (status == SN_OK && more) {
        status = sn_cells_next(&r->cells, r->row, &more);
        if (status == SN_OK && more) status = read_row(r);
    }
    if (status != SN_OK || r->count > 0) return status;
    return r->choice->skipped > 0 ? sn_cells_fail(&r->cells, "no row is of the coordinate \"%.100s\"", r->choice->coordinate)
                                  : sn_cells_fail(&r->cells, "there is no row with an arm");
}

/* ---- by muscles ------------------------------------------------------------------------------------------------------------------- */

static int compare_names(const measured_row *a, const measured_row *b) {
    size_t shorter = a->muscle.length < b->muscle.length ? a->muscle.length : b->muscle.length;
    int order = memcmp(a->muscle.text, b->muscle.text, shorter);
    return order != 0 ? order : (a->muscle.length > b->muscle.length) - (a->muscle.length < b->muscle.length);
}

static int compare_rows(const void *a, const void *b) {
    const measured_row *x = a, *y = b;
    int order = compare_names(x, y);
    if (order == 0) order = (x->angle > y->angle) - (x->angle < y->angle);
    return order != 0 ? order : (x->order > y->order) - (x->order < y->order);
}

static bool fill(sn_measured_arm *arm, const measured_row *rows, sn_index count) {
    *arm = (sn_measured_arm){.muscle = sn_strndup(rows->muscle.text, rows->muscle.length), .count = count};
    arm->angles = SN_NEW(double, count);
    arm->arms = SN_NEW(double, count);
    arm->lower = SN_NEW(double, count);
    arm->upper = SN_NEW(double, count);
    if (!arm->muscle || !arm->angles || !arm->arms || !arm->lower || !arm->upper) return false;
    for (sn_index i = 0; i < count; i++) {
        arm->angles[i] = rows[i].angle;
        arm->arms[i] = rows[i].arm;
        arm->lower[i] = rows[i].lower;
        arm->upper[i] = rows[i].upper;
    }
    return true;
}

static sn_status gather(const reader *r, sn_measured_arms *out) {
    out->items = SN_NEW(sn_measured_arm, r->count);
    bool enough = out->items != NULL;
    qsort(r->rows, (size_t)r->count, sizeof *r->rows, compare_rows);
    for (sn_index from = 0, next; enough && from < r->count; from = next) {
        for (next = from + 1; next < r->count && compare_names(&r->rows[from], &r->rows[next]) == 0;) next++;
        enough = fill(&out->items[out->count++], &r->rows[from], next - from);
    }
    return enough ? SN_OK : sn_fail_memory(r->cells.error, "measured arms");
}

sn_status sn_measured_arms_parse(const sn_blob *blob, sn_measured_choice *choice, sn_measured_arms *out, sn_error *error) {
    reader r = {.choice = choice};
    *out = (sn_measured_arms){0};
    choice->skipped = 0;
    sn_status status = sn_cells_begin(blob, &r.cells, error);
    if (status == SN_OK) status = find_columns(&r);
    if (status == SN_OK) status = check_columns(&r);
    if (status == SN_OK && (r.row = SN_NEW(sn_span, r.cells.column_count)) == NULL) status = sn_fail_memory(error, "measured arms");
    if (status == SN_OK) status = read_rows(&r);
    if (status == SN_OK) status = gather(&r, out);
    if (status != SN_OK) sn_measured_arms_free(out);
    sn_cells_free(&r.cells);
    free(r.row);
    free(r.rows);
    return status;
}
