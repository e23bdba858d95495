/*
 * table.c -- numbers over time as rows of text: tab-separated values, or an OpenSim storage file (.sto) where the name ends so.
 *
 * Rows are smoothed on their way out: each round is a filter that holds two rows back, so that a table of any length needs no memory.
 */
#include "mesh_reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One round of x'_i = (x_{i-1} + 4 x_i + x_{i+1}) / 6; the first and the last row of all stay as they are. */
typedef struct smoother {
    int64_t seen;
    double *before, *here; /* (columns) the last two rows that came in */
} smoother;

struct sn_table {
    sn_output *output;
    sn_index columns, smoothed_from;
    int rounds;
    int64_t promised, written; /* rows that a storage file's header tells, and those that are there */
    uint64_t rows_at;          /* where it tells them; 0 = no such header */
    smoother *smoothers;       /* (rounds) */
    double **passing;          /* (rounds) x (columns): what a round hands to the next */
};

static bool ends_with(const char *text, const char *ending) {
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcasecmp(text + length - tail, ending) == 0;
}

static bool is_storage(const char *path) { return ends_with(path, ".sto") || ends_with(path, ".mot"); }

/* ---- the head --------------------------------------------------------------------------------------------------------------- */

/* The lines that OpenSim's readers ask for, in the order of the files that it writes itself. Returns where the number of rows is. */
static uint64_t write_storage_head(sn_output *output, const sn_table_params *params) {
    size_t title = strlen(params->title);
    sn_write_name(output, params->title, false);
    sn_output_print(output, "\nversion=1\nnRows=%lld\nnColumns=%d\ninDegrees=yes\n\n", (long long)params->rows, params->columns);
    sn_output_print(output, "Units are S.I. units (second, meters, Newtons, ...)\nAngles are in degrees.\n\nendheader\n");
    return (title > 0 ? title : 1) + strlen("\nversion=1\nnRows=");
}

static void write_names(sn_output *output, const sn_table_params *params) {
    for (sn_index i = 0; i < params->columns; i++) {
        if (i > 0) sn_output_print(output, "\t");
        sn_write_name(output, params->names[i], false);
    }
    sn_output_print(output, "\n");
}

/* Without the end of its line. */
static void put_row(sn_output *output, sn_index columns, const double *row) {
    for (sn_index i = 0; i < columns; i++) sn_write_number(output, i > 0 ? '\t' : '\0', row[i]);
}

/* As sn_write_name writes it. */
static int written(char c) { return (unsigned char)c <= ' ' || c == 0x7f || c == '\\' ? '_' : c; }

static int compare_written(const void *a, const void *b) {
    const char *x = *(const char *const *)a, *y = *(const char *const *)b;
    for (; *x != '\0' && *y != '\0' && written(*x) == written(*y); x++, y++) {}
    return (*x == '\0' ? 0 : written(*x)) - (*y == '\0' ? 0 : written(*y));
}

/* Names of joints, coordinates and muscles meet here for the first time. */
static sn_status warn_of_twins(const char *path, const sn_table_params *params, sn_error *error) {
    const char **names = sn_alloc((size_t)params->columns, sizeof *names);
    if (names == NULL) return sn_fail_memory(error, "a table");
    for (sn_index i = 0; i < params->columns; i++) names[i] = params->names[i];
    qsort((void *)names, (size_t)params->columns, sizeof *names, compare_written);
    sn_index twin = 1;
    while (twin < params->columns && compare_written(&names[twin - 1], &names[twin]) != 0) twin++;
    if (twin < params->columns)
        sn_log(SN_LOG_WARNING, "%s: two columns have the name \"%s\"; what reads it by names takes one of them for both", path,
               names[twin]);
    free((void *)names);
    return SN_OK;
}

static sn_status allocate(sn_table *table, sn_error *error) {
    size_t columns = (size_t)table->columns;
    bool enough = (table->smoothers = SN_NEW(smoother, table->rounds)) && (table->passing = SN_NEW(double *, table->rounds));
    for (int i = 0; enough && i < table->rounds; i++)
        enough = (table->smoothers[i].before = SN_NEW(double, columns)) && (table->smoothers[i].here = SN_NEW(double, columns)) &&
                 (table->passing[i] = SN_NEW(double, columns));
    return enough ? SN_OK : sn_fail_memory(error, "a table");
}

/* ---- going on with one ------------------------------------------------------------------------------------------------------ */

/* The rows of a table that is there, behind its head; NULL = it has another head. */
static const char *find_rows(const char *path, const sn_table_params *params, const char *text, sn_error *error) {
    sn_output *memory = NULL;
    sn_blob names = {0};
    if (sn_output_open_memory(&memory, error) != SN_OK) return NULL;
    write_names(memory, params);
    if (sn_output_take(memory, path, &names, error) != SN_OK) return NULL;
    const char *at = is_storage(path) ? strstr(text, "\nendheader\n") : text;
    if (at != NULL && is_storage(path)) at += strlen("\nendheader\n");
    bool same = at != NULL && strncmp(at, names.data, names.size) == 0;
    if (!same) (void)sn_fail_at(error, SN_ERROR_USAGE, path, 0, "has other columns than the run would write; name another file");
    if (same) at += names.size;
    sn_blob_free(&names);
    return same ? at : NULL;
}

/* Whole rows from `at` on, at most `most`; *end: behind them. */
static int64_t count_rows(const char *at, int64_t most, const char **end) {
    int64_t count = 0;
    for (const char *line; count < most && (line = strchr(at, '\n')) != NULL; count++) at = line + 1;
    *end = at;
    return count;
}

/* Is the row at `at` that of the state's frame, to the last digit? */
static bool is_row(const sn_table_params *params, const char *at) {
    sn_output *memory = NULL;
    sn_blob row = {0};
    if (sn_output_open_memory(&memory, NULL) != SN_OK) return false;
    put_row(memory, params->columns, params->at_row);
    if (sn_output_take(memory, "", &row, NULL) != SN_OK) return false;
    bool same = strncmp(at, row.data, row.size) == 0;
    sn_blob_free(&row);
    return same;
}

/* Which rows of the text stay: none of a table that is to be written anew. */
static sn_status check_rows(const char *path, const sn_table_params *params, const char *text, sn_blob *keep, sn_error *error) {
    sn_resume *resume = params->resume;
    const char *rows = find_rows(path, params, text, error), *end, *at;
    double time;
    bool goes_on;
    if (rows == NULL) return SN_ERROR_USAGE;
    if (!sn_scan_number(rows, rows + strlen(rows), &end, &time)) return SN_OK;
    double first = rint(time * resume->rate);
    if (!(fabs(first) <= SN_INDEX_MAX) || first / resume->rate != time) return sn_resume_differs(resume, path, error);
    int64_t count = count_rows(rows, INT64_MAX, &end), from = (int64_t)first;
    sn_status status = sn_resume_take(resume, path, from, from + count - 1, &goes_on, error);
    if (status != SN_OK || !goes_on) return status;
    (void)count_rows(rows, resume->frame - from, &at);
    if (params->rounds > 0)
        return sn_fail_at(error, SN_ERROR_USAGE, path, 0, "smoothed lengths cannot be gone on with; name another file to begin one there");
    if (!is_row(params, at) || at[-1] != '\n') return sn_resume_differs(resume, path, error);
    keep->size = (size_t)count_rows(rows, resume->next - from, &end);
    keep->data = sn_strndup(rows, (size_t)(end - rows));
    return keep->data != NULL ? SN_OK : sn_fail_memory(error, "a table");
}

/* keep: the text of the rows that stay, and in its size their count. */
static sn_status find_earlier(const char *path, const sn_table_params *params, sn_blob *keep, sn_error *error) {
    sn_blob text = {0};
    if (params->resume == NULL || !sn_resume_exists(path)) return SN_OK;
    sn_status status = sn_blob_read_bytes(path, &text, error);
    if (status == SN_OK) status = check_rows(path, params, text.data, keep, error);
    sn_blob_free(&text);
    return status;
}

/* ---- opening ---------------------------------------------------------------------------------------------------------------- */

static void write_head(sn_table *table, const char *path, const sn_table_params *params, const sn_blob *earlier) {
    sn_table_params whole = *params;
    table->written = (int64_t)earlier->size;
    table->promised = whole.rows = params->rows + table->written;
    if (is_storage(path)) table->rows_at = write_storage_head(table->output, &whole);
    write_names(table->output, params);
    if (earlier->data != NULL) sn_output_write(table->output, earlier->data, strlen(earlier->data), NULL);
}

sn_status sn_table_create(const char *path, const sn_table_params *params, sn_table **out, sn_error *error) {
    sn_table *table = *out = SN_NEW(sn_table, 1);
    if (table == NULL) return sn_fail_memory(error, "a table");
    table->columns = params->columns;
    table->smoothed_from = params->smoothed_from;
    table->rounds = params->rounds;
    sn_blob earlier = {0};
    sn_status status = allocate(table, error);
    if (status == SN_OK) status = warn_of_twins(path, params, error);
    if (status == SN_OK) status = find_earlier(path, params, &earlier, error);
    if (status == SN_OK) status = sn_output_open(path, false, &table->output, error);
    if (status == SN_OK) write_head(table, path, params, &earlier);
    free(earlier.data);
    if (status == SN_OK) return SN_OK;
    sn_table_abort(table);
    *out = NULL;
    return status;
}

/* ---- rows ------------------------------------------------------------------------------------------------------------------- */

static sn_status write_row(sn_table *table, const double *row, sn_error *error) {
    table->written++;
    put_row(table->output, table->columns, row);
    return sn_output_write(table->output, "\n", 1, error);
}

/* What round `round` gives for a new row, in `out`; false where it holds that row back. */
static bool smooth(const sn_table *table, smoother *s, const double *row, double *out) {
    size_t size = (size_t)table->columns * sizeof *row;
    double *free_row = s->before;
    s->seen++;
    if (s->seen == 1) {
        memcpy(out, row, size);
    } else if (s->seen > 2) {
        memcpy(out, s->here, size);
        for (sn_index i = table->smoothed_from; i < table->columns; i++) out[i] = (s->before[i] + 4.0 * s->here[i] + row[i]) / 6.0;
    }
    memcpy(free_row, row, size);
    s->before = s->here;
    s->here = free_row;
    return s->seen != 2;
}

static sn_status pass_on(sn_table *table, int round, const double *row, sn_error *error) {
    for (; round < table->rounds; round++) {
        if (!smooth(table, &table->smoothers[round], row, table->passing[round])) return SN_OK;
        row = table->passing[round];
    }
    return write_row(table, row, error);
}

sn_status sn_table_append(sn_table *table, const double *row, sn_error *error) { return pass_on(table, 0, row, error); }

/* The last row is still in each round, one after the other. */
static sn_status release(sn_table *table, sn_error *error) {
    sn_status status = SN_OK;
    for (int round = 0; round < table->rounds && status == SN_OK; round++)
        if (table->smoothers[round].seen > 1) status = pass_on(table, round + 1, table->smoothers[round].here, error);
    return status;
}

/* Fewer rows than were promised: the header says so, in as many digits. */
static sn_status correct_head(sn_table *table, sn_error *error) {
    char digits[24], right[24];
    int length = snprintf(digits, sizeof digits, "%lld", (long long)table->promised);
    if (table->rows_at == 0 || table->written > table->promised) return SN_OK;
    snprintf(right, sizeof right, "%0*lld", length, (long long)table->written);
    return sn_output_patch(table->output, table->rows_at, right, (size_t)length, error);
}

sn_status sn_table_publish(sn_table *table, sn_error *error) {
    sn_status status = sn_output_publish(table->output, NULL, error);
    return status == SN_OK ? correct_head(table, error) : status;
}

sn_status sn_table_commit(sn_table *table, sn_error *error) {
    sn_status status = release(table, error);
    if (status == SN_OK) status = correct_head(table, error);
    if (status == SN_OK) {
        status = sn_output_commit(table->output, error);
        table->output = NULL;
    }
    sn_table_abort(table);
    return status;
}

void sn_table_abort(sn_table *table) {
    if (table == NULL) return;
    sn_output_abort(table->output);
    for (int i = 0; i < table->rounds; i++) {
        if (table->smoothers != NULL) free(table->smoothers[i].before);
        if (table->smoothers != NULL) free(table->smoothers[i].here);
        if (table->passing != NULL) free(table->passing[i]);
    }
    free(table->smoothers);
    free(table->passing);
    free(table);
}
