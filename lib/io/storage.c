/* storage.c -- OpenSim's motion and storage files (.mot, .sto): a header, names of columns, rows of numbers. */
#include "sinew/model_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh_reader.h"

enum { MOST_COLUMNS = 65536, MOST_HEADER_LINES = 10000 };

typedef struct storage {
    const sn_blob *blob;
    sn_error *error;
    sn_text_lines lines;
    int64_t line;          /* of the line that was read last */
    int64_t rows, columns; /* that the header promises; -1 = it does not say */
    bool degrees_given;
    bool tabs; /* names may have blanks in them */
    size_t row_capacity, value_capacity, name_capacity;
    sn_columns *out;
} storage;

static sn_status fail_here(const storage *s, const char *format, ...) SN_PRINTF(2, 3);
static sn_status fail_here(const storage *s, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    sn_status status = sn_text_complain(s->error, s->blob, s->line, format, arguments);
    va_end(arguments);
    return status;
}

/* The next line without blanks around it; false at the end of the file. */
static bool next_line(storage *s, sn_span *out) {
    const char *text, *end;
    if (!sn_text_next_line(&s->lines, &text, &end)) return false;
    *out = sn_span_trim((sn_span){text, (size_t)(end - text)});
    s->line = s->lines.line;
    return true;
}

/* The next word of a line, or what stands up to the next tab; it is taken off. */
static sn_span next_cell(sn_span *line, bool tabs) {
    *line = sn_span_trim(*line);
    size_t length = 0;
    while (length < line->length && !(tabs ? line->text[length] == '\t' : sn_is_blank(line->text[length]))) length++;
    sn_span cell = sn_span_trim((sn_span){line->text, length});
    *line = sn_span_trim((sn_span){line->text + length, line->length - length});
    return cell;
}

/* ---- the header -------------------------------------------------------------------------------------------------------------------- */

/* The value of a line "KEY=VALUE" or "KEY VALUE"; text NULL = it is another key. */
static sn_span value_of(sn_span line, const char *key) {
    size_t length = strlen(key);
    if (line.length <= length || !sn_span_is_like((sn_span){line.text, length}, key)) return (sn_span){NULL, 0};
    if (line.text[length] != '=' && !sn_is_blank(line.text[length])) return (sn_span){NULL, 0};
    sn_span value = sn_span_trim((sn_span){line.text + length, line.length - length});
    return *value.text == '=' ? sn_span_trim((sn_span){value.text + 1, value.length - 1}) : value;
}

static sn_status read_count(const storage *s, sn_span line, const char *key, int64_t *out) {
    sn_span value = value_of(line, key);
    const char *next;
    if (value.text == NULL) return SN_OK;
    if (sn_scan_integer(value.text, value.text + value.length, &next, out) && next == value.text + value.length && *out >= 0) return SN_OK;
    return fail_here(s, "%s is no count", key);
}

static sn_status read_degrees(storage *s, sn_span line) {
    sn_span value = value_of(line, "inDegrees");
    if (value.text != NULL) {
        bool yes = sn_span_is_like(value, "yes") || sn_span_is_like(value, "y") || sn_span_is_like(value, "true");
        bool no = sn_span_is_like(value, "no") || sn_span_is_like(value, "n") || sn_span_is_like(value, "false");
        if (!yes && !no) return fail_here(s, "inDegrees is neither yes nor no");
        s->out->degrees = yes;
        s->degrees_given = true;
    } else if (!s->degrees_given && (sn_span_is(line, "Angles are in degrees.") || value_of(line, "datacolumns").text != NULL)) {
        s->out->degrees = true; /* older files have no inDegrees, and SIMM knows degrees alone */
    }
    return SN_OK;
}

static sn_status read_header(storage *s) {
    sn_span line;
    sn_status status = SN_OK;
    while (status == SN_OK && s->line < MOST_HEADER_LINES && next_line(s, &line)) {
        if (sn_span_is_like(line, "endheader")) return SN_OK;
        status = read_count(s, line, "nRows", &s->rows);
        if (status == SN_OK) status = read_count(s, line, "nColumns", &s->columns);
        if (status == SN_OK) status = read_count(s, line, "datarows", &s->rows);
        if (status == SN_OK) status = read_count(s, line, "datacolumns", &s->columns);
        if (status == SN_OK) status = read_degrees(s, line);
    }
    return status == SN_OK ? fail_here(s, "there is no line \"endheader\"; OpenSim's motion and storage files have one") : status;
}

/* ---- names --------------------------------------------------------------------------------------------------------------------------- */

static sn_status add_name(storage *s, sn_span name) {
    void *names = s->out->names;
    if (s->out->column_count == MOST_COLUMNS) return fail_here(s, "there are more than %d columns", (int)MOST_COLUMNS);
    if (!sn_grow(&names, &s->name_capacity, (size_t)s->out->column_count + 1, sizeof *s->out->names))
        return sn_fail_memory(s->error, "a motion");
    s->out->names = names;
    char *copy = s->out->names[s->out->column_count] = sn_strndup(name.text, name.length);
    if (copy == NULL) return sn_fail_memory(s->error, "a motion");
    for (; *copy != '\0'; copy++)
        if ((unsigned char)*copy < ' ') *copy = '_';
    s->out->column_count++;
    return SN_OK;
}

static sn_status read_names(storage *s) {
    sn_span line = {"", 0};
    while (line.length == 0)
        if (!next_line(s, &line)) return fail_here(s, "no row of names follows \"endheader\"");
    s->out->names_line = s->line;
    s->tabs = memchr(line.text, '\t', line.length) != NULL;
    if (!sn_span_is_like(next_cell(&line, s->tabs), "time")) return fail_here(s, "the first column is not \"time\"");
    sn_status status = SN_OK;
    while (line.length > 0 && status == SN_OK) status = add_name(s, next_cell(&line, s->tabs));
    if (status == SN_OK && s->columns >= 0 && s->columns != (int64_t)s->out->column_count + 1)
        return fail_here(s, "there are %lld columns and the header says nColumns=%lld", (long long)s->out->column_count + 1,
                         (long long)s->columns);
    return status;
}

/* ---- rows ------------------------------------------------------------------------------------------------------------------------------
 */

static const char *column_name(const storage *s, sn_index column) { return column == 0 ? "time" : s->out->names[column - 1]; }

static sn_status make_room(storage *s) {
    void *times = s->out->times, *values = s->out->values;
    size_t row = (size_t)s->out->row_count, columns = (size_t)s->out->column_count;
    bool enough = s->out->row_count < SN_INDEX_MAX && sn_grow(&times, &s->row_capacity, row + 1, sizeof(double));
    s->out->times = times;
    enough = enough && sn_grow(&values, &s->value_capacity, (row + 1) * columns + 1, sizeof(double));
    s->out->values = values;
    return enough ? SN_OK : sn_fail_memory(s->error, "a motion");
}

static sn_status read_row(storage *s, sn_span line) {
    sn_index columns = s->out->column_count + 1, column = 0;
    for (sn_span cell = next_cell(&line, false); cell.length > 0; cell = next_cell(&line, false), column++) {
        double value;
        const char *next, *stop = cell.text + cell.length;
        if (column == columns) return fail_here(s, "the row has more numbers than there are columns (%d)", (int)columns);
        if (!sn_scan_number(cell.text, stop, &next, &value) || next != stop)
            return fail_here(s, "column \"%.100s\": \"%.*s\" is no number", column_name(s, column),
                             (int)(cell.length < 40 ? cell.length : 40), cell.text);
        if (column == 0) {
            sn_status status = make_room(s);
            if (status != SN_OK) return status;
            s->out->times[s->out->row_count] = value;
        } else {
            s->out->values[(size_t)s->out->row_count * (size_t)(columns - 1) + (size_t)column - 1] = value;
        }
    }
    if (column < columns) return fail_here(s, "the row has %d numbers and there are %d columns", (int)column, (int)columns);
    s->out->row_count++;
    return SN_OK;
}

static sn_status read_rows(storage *s) {
    sn_span line;
    sn_status status = SN_OK;
    bool ended = false;
    while (status == SN_OK && next_line(s, &line)) {
        if (line.length == 0) {
            ended = s->out->row_count > 0;
            continue;
        }
        if (ended) return fail_here(s, "a row follows an empty line; take the empty line out");
        if (s->out->row_count == 0) s->out->first_line = s->line;
        status = read_row(s, line);
    }
    if (status == SN_OK && s->rows >= 0 && s->rows != s->out->row_count)
        return fail_here(s, "there are %d rows and the header says nRows=%lld; is the file whole?", (int)s->out->row_count,
                         (long long)s->rows);
    return status == SN_OK && s->out->row_count == 0 ? fail_here(s, "there is no row") : status;
}

/* ---- all
 * ---------------------------------------------------------------------------------------------------------------------------------- */

bool sn_storage_detect(const sn_blob *blob) {
    storage s = {.lines = sn_text_lines_of(blob->data, blob->size)};
    sn_span line;
    while (s.line < 200 && next_line(&s, &line))
        if (sn_span_is_like(line, "endheader")) return true;
    return false;
}

sn_status sn_storage_parse(const sn_blob *blob, sn_columns *out, sn_error *error) {
    storage s = {.blob = blob, .error = error, .lines = sn_text_lines_of(blob->data, blob->size), .rows = -1, .columns = -1, .out = out};
    *out = (sn_columns){0};
    sn_status status = (out->name = sn_strdup(blob->name)) != NULL ? SN_OK : sn_fail_memory(error, "a motion");
    if (status == SN_OK) status = read_header(&s);
    if (status == SN_OK) status = read_names(&s);
    if (status == SN_OK) status = read_rows(&s);
    out->degrees_told = s.degrees_given || out->degrees;
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_columns_free(out);
    return status;
}
