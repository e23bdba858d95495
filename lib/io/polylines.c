/* polylines.c -- fibres from a file: the lines of an OBJ file, the fibres of a muscle document, or {"polylines": [{"points": [...]}]}. */
#include "document.h"

#include <stdlib.h>
#include <string.h>

/* ---- JSON ----------------------------------------------------------------------------------------------------------------- */

static sn_status parse_json(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status) return status;
    sn_json_value top = sn_json_top(tree), fibers = sn_json_member(&top, "fibers");
    sn_json_value lines = sn_json_member(sn_json_has(&fibers) ? &fibers : &top, "polylines");
    status = sn_parse_polylines(&lines, out, error);
    sn_json_tree_free(tree);
    return status;
}

/* ---- OBJ: v and l ----------------------------------------------------------------------------------------------------------- */

typedef struct line_reader {
    const char *name, *at, *end; /* end: of the line */
    int64_t line;
    sn_index vertex_count;
    size_t vertex_capacity, line_capacity;
    sn_vec3 *vertices;
    sn_fibers *out;
} line_reader;

static void skip_spaces(line_reader *r) {
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t' || *r->at == '\r')) r->at++;
}

static sn_status complain(const line_reader *r, sn_error *error, const char *what) {
    return sn_fail_at(error, SN_ERROR_INPUT, r->name, r->line, "%s", what);
}

static sn_status read_vertex(line_reader *r, sn_error *error) {
    double p[3];
    for (int i = 0; i < 3; i++) {
        skip_spaces(r);
        if (!sn_scan_number(r->at, r->end, &r->at, &p[i]) || !isfinite(p[i])) return complain(r, error, "a vertex must have three numbers");
    }
    if (r->vertex_count == SN_INDEX_MAX ||
        !sn_grow((void **)&r->vertices, &r->vertex_capacity, (size_t)r->vertex_count + 1, sizeof *r->vertices))
        return sn_fail_memory(error, "the points of the fibres");
    r->vertices[r->vertex_count++] = sn_v3(p[0], p[1], p[2]);
    return SN_OK;
}

static sn_status add_point(line_reader *r, sn_polyline *line, size_t *capacity, int64_t index, sn_error *error) {
    if (index < 0) index += (int64_t)r->vertex_count + 1;
    if (index < 1 || index > r->vertex_count) return complain(r, error, "a line names a vertex that does not come before it");
    if (!sn_grow((void **)&line->points, capacity, (size_t)line->count + 1, sizeof *line->points))
        return sn_fail_memory(error, "the points of the fibres");
    line->points[line->count++] = r->vertices[index - 1];
    return SN_OK;
}

static sn_status read_line(line_reader *r, sn_error *error) {
    sn_fibers *out = r->out;
    if (!sn_grow((void **)&out->polylines, &r->line_capacity, (size_t)out->polyline_count + 1, sizeof *out->polylines))
        return sn_fail_memory(error, "the fibres");
    sn_polyline *line = &out->polylines[out->polyline_count++];
    *line = (sn_polyline){0};
    size_t capacity = 0;
    int64_t index;
    for (skip_spaces(r); r->at < r->end && *r->at != '#'; skip_spaces(r)) {
        if (!sn_scan_integer(r->at, r->end, &r->at, &index)) return complain(r, error, "a line must be made of the numbers of vertices");
        sn_status status = add_point(r, line, &capacity, index, error);
        if (status) return status;
        while (r->at < r->end && *r->at != ' ' && *r->at != '\t' && *r->at != '\r') r->at++; /* /texture */
    }
    return line->count >= 2 ? SN_OK : complain(r, error, "a line must have two vertices or more");
}

static sn_status parse_obj(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    const char *end = blob->data + blob->size;
    line_reader r = {.name = blob->name, .out = out};
    sn_status status = SN_OK;
    for (const char *at = blob->data; at < end && !status;) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        r.end = newline ? newline : end;
        r.at = at;
        r.line++;
        skip_spaces(&r);
        bool keyword = r.end - r.at > 1 && (r.at[1] == ' ' || r.at[1] == '\t');
        char first = keyword ? *r.at++ : '\0';
        if (first == 'v') status = read_vertex(&r, error);
        if (first == 'l') status = read_line(&r, error);
        at = r.end + (newline != NULL);
    }
    free(r.vertices);
    return status;
}

sn_status sn_polylines_read(const char *path, sn_fibers *out, sn_error *error) {
    sn_blob blob = {0};
    *out = (sn_fibers){0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status) return status;
    status = sn_json_detect(&blob) ? parse_json(&blob, out, error) : parse_obj(&blob, out, error);
    if (!status && out->polyline_count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, blob.name, 0,
                            "the file holds no fibre: no line (l) of an OBJ file, no \"polylines\" of a document");
    if (status) sn_fibers_free(out);
    sn_blob_free(&blob);
    return status;
}
