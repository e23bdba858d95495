/*
 * polylines.c -- fibres from a file: the lines of an OBJ file or of VTK PolyData (VTP and legacy), the fibres of a muscle document, or
 * {"polylines": [{"points": [...]}]}.
 */
#include "document.h"
#include "mesh_reader.h"

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

static void free_lines(sn_line_set *lines) {
    free(lines->starts);
    free(lines->corners);
}

static sn_status too_many(const char *what, sn_error *error) {
    return sn_fail(error, SN_ERROR_INPUT, "there are more than the %d %s that can be counted; take the file apart", (int)SN_INDEX_MAX,
                   what);
}

static sn_status begin_line(sn_line_set *lines, sn_error *error) {
    if (lines->line_count == SN_INDEX_MAX) return too_many("fibres", error);
    if (!sn_grow((void **)&lines->starts, &lines->start_capacity, (size_t)lines->line_count + 2, sizeof(sn_index)))
        return sn_fail_memory(error, "the fibres");
    lines->starts[lines->line_count++] = lines->corner_count;
    lines->starts[lines->line_count] = lines->corner_count;
    return SN_OK;
}

static sn_status add_corner(sn_line_set *lines, sn_index vertex, sn_error *error) {
    if (lines->corner_count == SN_INDEX_MAX) return too_many("points of fibres", error);
    if (!sn_grow((void **)&lines->corners, &lines->corner_capacity, (size_t)lines->corner_count + 1, sizeof(sn_index)))
        return sn_fail_memory(error, "the points of the fibres");
    lines->corners[lines->corner_count++] = vertex;
    lines->starts[lines->line_count] = lines->corner_count;
    return SN_OK;
}

static sn_status read_vertex(sn_reader *r) {
    sn_vec3 position;
    sn_status status = sn_reader_position(r, &position);
    return status == SN_OK ? sn_reader_add_vertex(r, position) : status;
}

/* v, or v/vt; from 1, or from -1 backwards. */
static sn_status read_line_corner(sn_reader *r, sn_line_set *lines) {
    const char *start = r->at, *next;
    char found[48];
    int64_t vertex;
    bool good = sn_scan_integer(r->at, r->end, &next, &vertex);
    if (good) r->at = next;
    for (; good && !sn_reader_ends_token(r, r->at); r->at++) good = *r->at == '/' || *r->at == '-' || (*r->at >= '0' && *r->at <= '9');
    if (!good) {
        r->at = start;
        return sn_reader_fail(r, SN_NONE, "a line must be made of the numbers of vertices, not %s", sn_reader_found(r, found));
    }
    if (vertex < 0) vertex += (int64_t)r->mesh.vertex_count + 1;
    if (vertex < 1 || vertex > r->mesh.vertex_count)
        return sn_reader_fail(r, SN_NONE, "a line names a vertex that does not come before it");
    return add_corner(lines, (sn_index)(vertex - 1), r->error);
}

static sn_status read_line(sn_reader *r, sn_line_set *lines) {
    sn_status status = begin_line(lines, r->error);
    while (status == SN_OK && !sn_reader_at_line_end(r)) status = read_line_corner(r, lines);
    if (status != SN_OK) return status;
    if (lines->corner_count - lines->starts[lines->line_count - 1] >= 2) return SN_OK;
    return sn_reader_fail(r, SN_NONE, "a line must have two vertices or more");
}

static sn_status read_statements(sn_reader *r, sn_line_set *lines) {
    r->continues = true;
    do {
        sn_span word = sn_reader_word(r);
        sn_status status = sn_span_is(word, "v") ? read_vertex(r) : sn_span_is(word, "l") ? read_line(r, lines) : SN_OK;
        if (status != SN_OK) return status;
    } while (sn_reader_next_line(r));
    return SN_OK;
}

/* ---- segments that make a curve ---------------------------------------------------------------------------------------------- */

/* Programs that know edges alone write a curve as lines of two points. Each vertex knows the segments at it. */
typedef struct segments {
    const sn_line_set *lines;
    sn_index *at[2]; /* (vertices) the first and the second segment that ends here; SN_NONE = none */
    sn_index *count; /* (vertices) of line ends and inner corners; joined are those that only two segments share */
    bool *used;      /* (lines) */
} segments;

static sn_index corners_of(const sn_line_set *lines, sn_index line) { return lines->starts[line + 1] - lines->starts[line]; }

static bool is_segment(const sn_line_set *lines, sn_index line) {
    const sn_index *v = lines->corners + lines->starts[line];
    return corners_of(lines, line) == 2 && v[0] != v[1];
}

static void note_corners(segments *s, sn_index line) {
    bool segment = is_segment(s->lines, line);
    for (sn_index k = s->lines->starts[line]; k < s->lines->starts[line + 1]; k++) {
        sn_index v = s->lines->corners[k];
        if (segment && s->count[v] < 2) s->at[s->count[v]][v] = line;
        s->count[v] += segment ? 1 : 3; /* where another line passes nothing is joined */
    }
}

/* The segment that goes on from `line` at vertex v; SN_NONE = none, or more than one. */
static sn_index next_segment(const segments *s, sn_index line, sn_index v) {
    if (s->count[v] != 2) return SN_NONE;
    sn_index other = s->at[s->at[0][v] == line][v];
    return other != SN_NONE && !s->used[other] ? other : SN_NONE;
}

static sn_index other_end(const segments *s, sn_index line, sn_index v) {
    const sn_index *ends = s->lines->corners + s->lines->starts[line];
    return ends[ends[0] == v];
}

/* The end of the chain of `line`, walking over its end v against its direction; *first is the segment there. */
static sn_index walk_back(const segments *s, sn_index line, sn_index v, sn_index *first) {
    sn_index begin = line;
    for (sn_index more = line; (more = next_segment(s, more, v)) != SN_NONE && more != begin; line = more) v = other_end(s, more, v);
    *first = line;
    return v;
}

/* The chain that `line` is in, from its first end on, as a new line. */
static sn_status add_chain(segments *s, sn_index line, sn_line_set *out, sn_error *error) {
    sn_index first, v = walk_back(s, line, s->lines->corners[s->lines->starts[line]], &first);
    sn_status status = begin_line(out, error);
    if (status == SN_OK) status = add_corner(out, v, error);
    for (line = first; line != SN_NONE && status == SN_OK; line = next_segment(s, line, v)) {
        s->used[line] = true;
        v = other_end(s, line, v);
        status = add_corner(out, v, error);
    }
    return status;
}

static sn_status add_whole(const sn_line_set *lines, sn_index line, sn_line_set *out, sn_error *error) {
    sn_status status = begin_line(out, error);
    for (sn_index k = lines->starts[line]; k < lines->starts[line + 1] && status == SN_OK; k++)
        status = add_corner(out, lines->corners[k], error);
    return status;
}

/* Lines of two points that meet end to end become one; the order is that of the first of each. */
static sn_status join_segments(const sn_line_set *lines, sn_index vertex_count, sn_line_set *out, sn_error *error) {
    segments s = {.lines = lines,
                  .at = {SN_NEW(sn_index, vertex_count), SN_NEW(sn_index, vertex_count)},
                  .count = SN_NEW(sn_index, vertex_count),
                  .used = SN_NEW(bool, lines->line_count)};
    bool room = s.at[0] != NULL && s.at[1] != NULL && s.count != NULL && s.used != NULL;
    sn_status status = room ? SN_OK : sn_fail_memory(error, "the fibres");
    for (sn_index v = 0; v < vertex_count && room; v++) s.at[0][v] = s.at[1][v] = SN_NONE;
    for (sn_index i = 0; i < lines->line_count && room; i++) note_corners(&s, i);
    for (sn_index i = 0; i < lines->line_count && status == SN_OK; i++) {
        if (s.used[i]) continue;
        status = is_segment(lines, i) ? add_chain(&s, i, out, error) : add_whole(lines, i, out, error);
    }
    free(s.at[0]);
    free(s.at[1]);
    free(s.count);
    free(s.used);
    return status;
}

/* ---- from lines to fibres ------------------------------------------------------------------------------------------------------ */

static sn_status copy_lines(const sn_line_set *lines, const sn_vec3 *positions, sn_fibers *out, sn_error *error) {
    if ((out->polylines = SN_NEW(sn_polyline, lines->line_count)) == NULL) return sn_fail_memory(error, "the fibres");
    for (sn_index i = 0; i < lines->line_count; i++) {
        sn_polyline *line = &out->polylines[out->polyline_count++];
        sn_index count = corners_of(lines, i);
        *line = (sn_polyline){.points = SN_NEW(sn_vec3, count)};
        if (line->points == NULL) return sn_fail_memory(error, "the points of the fibres");
        line->count = count;
        for (sn_index k = 0; k < count; k++) line->points[k] = positions[lines->corners[lines->starts[i] + k]];
    }
    return SN_OK;
}

static sn_status make_fibers(const sn_reader *r, const sn_line_set *lines, sn_fibers *out) {
    sn_line_set joined = {0};
    sn_status status = lines->line_count > 0 ? join_segments(lines, r->mesh.vertex_count, &joined, r->error) : SN_OK;
    if (status == SN_OK && joined.line_count < lines->line_count)
        sn_log(SN_LOG_WARNING, "%s: %d lines, of them many of two points, are joined where they meet end to end: %d fibres", r->blob->name,
               (int)lines->line_count, (int)joined.line_count);
    if (status == SN_OK && joined.line_count > 0) status = copy_lines(&joined, r->mesh.positions, out, r->error);
    free_lines(&joined);
    return status;
}

/* What comes with a mesh as its file is read. */
static void free_reader(sn_reader *r, sn_line_set *lines) {
    sn_mesh_free(&r->mesh);
    free(r->corners);
    free(r->polygons);
    free(r->colours);
    free_lines(lines);
}

static sn_status parse_obj(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    sn_reader r = sn_reader_of(blob, error);
    sn_line_set lines = {0};
    sn_status status = read_statements(&r, &lines);
    if (status == SN_OK) status = make_fibers(&r, &lines, out);
    free_reader(&r, &lines);
    return status;
}

/* ---- VTK ----------------------------------------------------------------------------------------------------------------------- */

static sn_status check_lines(const sn_reader *r, const sn_line_set *lines) {
    for (sn_index k = 0; k < lines->corner_count; k++)
        if (lines->corners[k] >= r->mesh.vertex_count)
            return sn_fail_at(r->error, SN_ERROR_INPUT, r->blob->name, 0, "a line names vertex %d, but the file has %d",
                              (int)lines->corners[k], (int)r->mesh.vertex_count);
    if (lines->thin > 0) sn_log(SN_LOG_WARNING, "%s: %d lines of fewer than two points are left out", r->blob->name, (int)lines->thin);
    return SN_OK;
}

static sn_status parse_vtk(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    sn_reader r = sn_reader_of(blob, error);
    sn_line_set lines = {0};
    r.lines = &lines;
    sn_status status = sn_vtp_is(blob) ? sn_vtp_parse(&r) : sn_vtk_parse(&r);
    if (status == SN_OK) status = check_lines(&r, &lines);
    if (status == SN_OK) status = make_fibers(&r, &lines, out);
    free_reader(&r, &lines);
    return status;
}

bool sn_polylines_detect(const sn_blob *blob) {
    static const char *const words[] = {"v", "vn", "vt", "vp", "l", "p", "o", "g", "s", "mtllib", "usemtl"};
    if (blob->size == 0) return false;
    if (sn_vtp_is(blob) || sn_vtk_is(blob)) return true;
    sn_reader r = sn_reader_of(blob, NULL);
    if (!sn_reader_find_line(&r)) return false;
    sn_span word = sn_reader_word(&r);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (sn_span_is(word, words[i])) return true;
    return false;
}

sn_status sn_polylines_parse(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    *out = (sn_fibers){0};
    sn_status status = sn_json_detect(blob)                 ? parse_json(blob, out, error)
                       : sn_vtp_is(blob) || sn_vtk_is(blob) ? parse_vtk(blob, out, error)
                                                            : parse_obj(blob, out, error);
    if (!status && out->polyline_count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                            "the file holds no fibre: no line (l) of an OBJ file, no line of VTK PolyData, no \"polylines\" of a document");
    for (sn_index i = 0; i < out->polyline_count && !status; i++)
        if (out->polylines[i].count < 2)
            status = sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "fibre %d of %d has fewer than two points", (int)i + 1,
                                (int)out->polyline_count);
    if (status) sn_fibers_free(out);
    return status;
}

sn_status sn_polylines_read(const char *path, sn_fibers *out, sn_space *space, sn_error *error) {
    sn_blob blob = {0};
    *out = (sn_fibers){0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status) return status;
    if (space != NULL) *space = sn_blob_space(&blob);
    status = sn_polylines_parse(&blob, out, error);
    sn_blob_free(&blob);
    return status;
}
