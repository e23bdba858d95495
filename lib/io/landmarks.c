/*
 * landmarks.c -- landmarks around attachment areas, from JSON or from lines with tabs.
 */
#include "json.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_AREAS = 4096, COLUMNS = 5 };

void sn_landmarks_free(sn_landmarks *landmarks) {
    sn_landmark_areas_free(landmarks->areas, landmarks->count);
    *landmarks = (sn_landmarks){0};
}

/* ---- JSON ------------------------------------------------------------------------------------------------------------------- */

static sn_status parse_flat(const sn_json_value *value, sn_landmark_area *out, sn_error *error) {
    double *coordinates = NULL;
    sn_index count = 0;
    sn_status status = sn_json_get_numbers(value, 3, -1, &count, &coordinates, error);
    if (status != SN_OK) return status;
    out->landmarks = (sn_vec3 *)coordinates;
    out->count = count / 3;
    return SN_OK;
}

/* [[x,y,z], ...], or the same numbers flat. */
static sn_status parse_points(const sn_json_value *value, sn_landmark_area *out, sn_error *error) {
    sn_json_value first = sn_json_element(value, 0);
    sn_status status = sn_json_require(value, "points [[x,y,z], ...] along the boundary", error);
    if (status == SN_OK) status = sn_json_expect_array(value, error);
    if (status != SN_OK) return status;
    if (!sn_json_has(&first)) return parse_flat(value, out, error);
    sn_index count = sn_json_length(value);
    if ((out->landmarks = SN_NEW(sn_vec3, count)) == NULL) return sn_fail_memory(error, "landmarks");
    out->count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value point = sn_json_element(value, i);
        status = sn_json_require(&point, "a point [x,y,z]", error);
        if (status == SN_OK) status = sn_json_get_vec3(&point, &out->landmarks[i], error);
    }
    return status;
}

static sn_status parse_area(const sn_json_value *value, sn_landmark_area *out, sn_error *error) {
    static const char *const members[] = {"bone", "name", "landmarks", NULL};
    sn_json_value bone = sn_json_member(value, "bone"), name = sn_json_member(value, "name"),
                  landmarks = sn_json_member(value, "landmarks");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_check_members(value, members, error);
    if (status == SN_OK) status = sn_json_require(&bone, "the name of a bone", error);
    if (status == SN_OK) status = sn_json_get_text(&bone, &out->bone, error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    return status == SN_OK ? parse_points(&landmarks, out, error) : status;
}

static sn_status parse_json(const sn_blob *blob, sn_landmarks *out, sn_error *error) {
    static const char *const known[] = {"format", "version", "name", "metersPerUnit", "areas", NULL};
    sn_json_tree *tree = NULL;
    sn_index count = 0;
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), areas = sn_json_member(&top, "areas"), unit = sn_json_member(&top, "metersPerUnit");
    status = sn_json_check_members(&top, known, error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, &out->meters_per_unit, error);
    if (status == SN_OK) status = sn_json_require(&areas, "a list of areas, each with \"bone\" and \"landmarks\"", error);
    if (status == SN_OK) status = sn_json_expect_list(&areas, MOST_AREAS, &count, error);
    if (status == SN_OK && (out->areas = SN_NEW(sn_landmark_area, count)) == NULL) status = sn_fail_memory(error, "landmarks");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value area = sn_json_element(&areas, i);
        out->count = i + 1;
        status = parse_area(&area, &out->areas[i], error);
    }
    sn_json_tree_free(tree);
    return status;
}

/* ---- lines with tabs ------------------------------------------------------------------------------------------------------------ */

typedef struct cell {
    const char *text;
    size_t length;
} cell;

static bool is_blank(char c) { return c == ' ' || c == '\r'; }

/* Cells of the line from text up to end, without blanks around them; how many there are, of which at most COLUMNS are kept. */
static int split_line(const char *text, const char *end, cell cells[COLUMNS]) {
    int count = 0;
    while (true) {
        const char *tab = memchr(text, '\t', (size_t)(end - text)), *stop = tab != NULL ? tab : end, *from = text, *to = stop;
        while (from < to && is_blank(*from)) from++;
        while (to > from && is_blank(to[-1])) to--;
        if (count < COLUMNS) cells[count] = (cell){from, (size_t)(to - from)};
        count++;
        if (tab == NULL) return count;
        text = tab + 1;
    }
}

static bool same(const char *name, cell c) {
    return name == NULL ? c.length == 0 : strlen(name) == c.length && memcmp(name, c.text, c.length) == 0;
}

/* Reads lines into areas. */
typedef struct line_reader {
    const sn_blob *blob;
    int64_t line; /* under way, from 1 */
    sn_landmarks *out;
    size_t capacity; /* of out->areas */
} line_reader;

/* The area of a line: an old one, or a new one at the end. NULL = out of memory, or too many. */
static sn_landmark_area *find_area(line_reader *r, const cell cells[COLUMNS]) {
    sn_landmarks *out = r->out;
    for (sn_index i = 0; i < out->count; i++)
        if (same(out->areas[i].bone, cells[0]) && same(out->areas[i].name, cells[1])) return &out->areas[i];
    void *areas = out->areas;
    if (out->count >= MOST_AREAS || !sn_grow(&areas, &r->capacity, (size_t)out->count + 1, sizeof *out->areas)) return NULL;
    out->areas = areas;
    sn_landmark_area *area = &out->areas[out->count++];
    *area = (sn_landmark_area){.bone = sn_strndup(cells[0].text, cells[0].length)};
    if (cells[1].length > 0) area->name = sn_strndup(cells[1].text, cells[1].length);
    return area->bone != NULL && (area->name != NULL || cells[1].length == 0) ? area : NULL;
}

static bool add_landmark(sn_landmark_area *area, sn_vec3 point) {
    sn_index count = area->count;
    bool full = count == 0 || (count >= 8 && (count & (count - 1)) == 0); /* room doubles from 8 */
    if (full) {
        sn_vec3 *more = sn_realloc(area->landmarks, count == 0 ? 8 : 2 * (size_t)count, sizeof *more);
        if (more == NULL) return false;
        area->landmarks = more;
    }
    area->landmarks[area->count++] = point;
    return true;
}

static bool read_coordinate(cell c, double *out) {
    const char *next;
    return c.length > 0 && sn_scan_number(c.text, c.text + c.length, &next, out) && next == c.text + c.length && isfinite(*out);
}

static sn_status parse_line(line_reader *r, const char *text, const char *end, sn_error *error) {
    cell cells[COLUMNS];
    double xyz[3] = {0};
    int count = split_line(text, end, cells);
    if ((count == 1 && cells[0].length == 0) || (cells[0].length > 0 && *cells[0].text == '#')) return SN_OK;
    if (r->line == 1 && count >= 2 && same("bone", cells[0])) return SN_OK; /* names of the columns */
    bool good = count == COLUMNS && cells[0].length > 0;
    for (int k = 0; k < 3 && good; k++) good = read_coordinate(cells[2 + k], &xyz[k]);
    if (!good)
        return sn_fail_at(error, SN_ERROR_INPUT, r->blob->name, r->line,
                          "not a landmark: write bone, area, x, y, z with a tab between them");
    sn_landmark_area *area = find_area(r, cells);
    if (area == NULL || !add_landmark(area, sn_v3(xyz[0], xyz[1], xyz[2]))) return sn_fail_memory(error, "landmarks");
    return SN_OK;
}

static sn_status parse_lines(const sn_blob *blob, sn_landmarks *out, sn_error *error) {
    sn_status status = SN_OK;
    line_reader r = {.blob = blob, .line = 1, .out = out};
    sn_text_lines lines = sn_text_lines_of(blob->data, blob->size);
    for (const char *text, *end; status == SN_OK && sn_text_next_line(&lines, &text, &end);) {
        r.line = lines.line;
        status = parse_line(&r, text, end, error);
    }
    return status;
}

/* ---- either ----------------------------------------------------------------------------------------------------------------------- */

sn_status sn_landmarks_read(const char *path, sn_landmarks *out, sn_error *error) {
    sn_blob blob = {0};
    *out = (sn_landmarks){0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status != SN_OK) return status;
    status = sn_json_detect(&blob) ? parse_json(&blob, out, error) : parse_lines(&blob, out, error);
    out->space = sn_blob_space(&blob);
    if (status == SN_OK && out->count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, blob.name, 0, "names no area; write bone, area, x, y, z a line, or JSON");
    if (status != SN_OK) {
        sn_error_set_file(error, blob.name);
        sn_landmarks_free(out);
    }
    sn_blob_free(&blob);
    return status;
}
