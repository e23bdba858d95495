/* cells.c -- tables of text: rows of cells under a row of names, parted by tabs, semicolons, commas or blanks. */
#include "cells.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_COLUMNS = 65536 };

sn_status sn_cells_fail(const sn_cells *cells, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    sn_status status = sn_text_complain(cells->error, cells->blob, cells->line, format, arguments);
    va_end(arguments);
    return status;
}

/* The next line that is no comment and not empty. */
static bool next_line(sn_cells *cells, sn_span *out) {
    const char *text, *end;
    while (sn_text_next_line(&cells->lines, &text, &end)) {
        sn_span all = sn_span_trim((sn_span){text, (size_t)(end - text)});
        if (all.length == 0 || *all.text == '#') continue;
        cells->line = cells->lines.line;
        *out = (sn_span){text, (size_t)(end - text)};
        return true;
    }
    return false;
}

static char find_mark(sn_span line) {
    static const char marks[] = "\t;,";
    for (const char *mark = marks; *mark != '\0'; mark++)
        if (memchr(line.text, *mark, line.length) != NULL) return *mark;
    return ' ';
}

/* Take a cell off the line; false = there is none left. A line that ends with a mark ends with an empty cell. */
static bool next_cell(const sn_cells *cells, sn_span *line, sn_span *out) {
    char mark = cells->mark;
    if (line->text == NULL) return false;
    if (mark == ' ') *line = sn_span_trim(*line);
    if (mark == ' ' && line->length == 0) return false;
    size_t length = 0;
    while (length < line->length && (mark == ' ' ? !sn_is_blank(line->text[length]) : line->text[length] != mark)) length++;
    *out = sn_span_trim((sn_span){line->text, length});
    *line = length < line->length ? (sn_span){line->text + length + 1, line->length - length - 1} : (sn_span){NULL, 0};
    return true;
}

/* ---- names ---------------------------------------------------------------------------------------------------------------------- */

static sn_span unquote(sn_span s) {
    bool quoted = s.length >= 2 && *s.text == '"' && s.text[s.length - 1] == '"';
    return quoted ? (sn_span){s.text + 1, s.length - 2} : s;
}

static sn_status add_name(sn_cells *cells, size_t *capacity, sn_span name) {
    void *names = cells->names;
    if (cells->column_count == MOST_COLUMNS) return sn_cells_fail(cells, "there are more than %d columns", (int)MOST_COLUMNS);
    if (!sn_grow(&names, capacity, (size_t)cells->column_count + 1, sizeof *cells->names)) return sn_fail_memory(cells->error, "a table");
    cells->names = names;
    char *copy = cells->names[cells->column_count] = sn_strndup(name.text, name.length);
    if (copy == NULL) return sn_fail_memory(cells->error, "a table");
    cells->column_count++;
    for (; *copy != '\0'; copy++)
        if ((unsigned char)*copy < ' ') *copy = '_';
    return SN_OK;
}

/* Marks at the end of a line that stand before nothing. */
static sn_span without_tail(const sn_cells *cells, sn_span line) {
    while (line.length > 0 && (sn_is_blank(line.text[line.length - 1]) || line.text[line.length - 1] == cells->mark)) line.length--;
    return line;
}

static sn_status read_names(sn_cells *cells, sn_span line) {
    size_t capacity = 0;
    sn_span cell;
    double number;
    const char *next;
    cells->mark = find_mark(line);
    line = without_tail(cells, line);
    while (next_cell(cells, &line, &cell)) {
        cell = unquote(cell);
        if (cell.length == 0) return sn_cells_fail(cells, "column %d has no name", (int)cells->column_count + 1);
        if (sn_scan_number(cell.text, cell.text + cell.length, &next, &number) && next == cell.text + cell.length)
            return sn_cells_fail(cells, "\"%.*s\" stands where the names of the columns should; the first row must name them",
                                 (int)(cell.length < 40 ? cell.length : 40), cell.text);
        sn_status status = add_name(cells, &capacity, cell);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

sn_status sn_cells_begin(const sn_blob *blob, sn_cells *out, sn_error *error) {
    sn_span line;
    *out = (sn_cells){.blob = blob, .error = error, .lines = sn_text_lines_of(blob->data, blob->size)};
    if (!next_line(out, &line)) return sn_cells_fail(out, "there is no row of names");
    sn_status status = read_names(out, line);
    if (status != SN_OK) sn_cells_free(out);
    return status;
}

/* ---- rows ----------------------------------------------------------------------------------------------------------------------- */

sn_status sn_cells_next(sn_cells *cells, sn_span *out, bool *more) {
    sn_span line, cell;
    sn_index count = 0;
    *more = next_line(cells, &line);
    if (!*more) return SN_OK;
    for (; next_cell(cells, &line, &cell); count++) {
        if (count < cells->column_count) out[count] = unquote(cell);
        if (count >= cells->column_count && cell.length > 0)
            return sn_cells_fail(cells, "the row has more cells than there are columns (%d)%s", (int)cells->column_count,
                                 cells->mark == ',' ? "; where commas are decimal marks, write points" : "");
    }
    if (count < cells->column_count)
        return sn_cells_fail(cells, "the row has %d cells and there are %d columns", (int)count, (int)cells->column_count);
    return SN_OK;
}

sn_status sn_cells_number(const sn_cells *cells, sn_index column, sn_span cell, double *out) {
    const char *next, *stop = cell.text + cell.length;
    *out = NAN;
    if (cell.length == 0 || (sn_scan_number(cell.text, stop, &next, out) && next == stop)) return SN_OK;
    bool comma = memchr(cell.text, ',', cell.length) != NULL;
    return sn_cells_fail(cells, "column \"%.100s\": \"%.*s\" is no number%s", cells->names[column],
                         (int)(cell.length < 40 ? cell.length : 40), cell.text, comma ? "; write decimal points, not commas" : "");
}

void sn_cells_free(sn_cells *cells) {
    for (sn_index i = 0; i < cells->column_count; i++) free(cells->names[i]);
    free(cells->names);
    cells->names = NULL;
    cells->column_count = 0;
}
