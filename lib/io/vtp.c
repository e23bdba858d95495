/*
 * vtp.c -- VTK XML PolyData, serial: its elements are walked first, then the arrays are read that make the mesh.
 *
 * Pieces become one mesh, their points behind one another. Polys and Strips are the surface; Verts, CellData and FieldData are passed over.
 * Arrays of PointData that all pieces have become attributes. Where the reader takes lines, Lines are read in place of all these.
 */
#include "mesh_reader.h"
#include "vtp_array.h"
#include "xml.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum section { OTHER, POINT_DATA, POINTS, LINES, POLYS, STRIPS } section;

typedef struct piece {
    int64_t points, lines, polys, strips;
    int64_t line;
    size_t first_array, array_count;
} piece;

enum { MOST_PIECES = 16384, MOST_ARRAYS = 65536, MOST_ARRAYS_A_PIECE = 1024 };

typedef struct vtp_file {
    sn_reader *reader;
    sn_vtp_layout layout;
    piece *pieces;
    size_t piece_count, piece_capacity;
    sn_vtp_array *arrays;
    size_t array_count, array_capacity;

    /* while walking */
    bool in_data, in_piece, in_array;
    bool content_ends; /* of the array walked: what follows are notes on it */
    section section;
} vtp_file;

/* ---- the elements --------------------------------------------------------------------------------------------------- */

static sn_status fail_tag(const vtp_file *file, const sn_xml_tag *tag, const char *what, const char *found) {
    return sn_fail_at(file->reader->error, SN_ERROR_INPUT, file->reader->blob->name, tag->line, "%s %.64s", what, found);
}

static bool is_named(const sn_xml_tag *tag, const char *name) { return strcmp(tag->name, name) == 0; }

static const char *attribute_or(const sn_xml_tag *tag, const char *name, const char *otherwise) {
    const char *value = sn_xml_attribute(tag, name);
    return value != NULL ? value : otherwise;
}

/* A whole number of at least 0, or `otherwise` where there is none. */
static sn_status read_count(const vtp_file *file, const sn_xml_tag *tag, const char *name, int64_t otherwise, int64_t *out) {
    const char *value = sn_xml_attribute(tag, name);
    *out = otherwise;
    if (value == NULL) return SN_OK;
    const char *end = value + strlen(value), *next;
    while (*value == ' ') value++;
    if (sn_scan_integer(value, end, &next, out) && *next == '\0' && *out >= 0) return SN_OK;
    char what[96];
    snprintf(what, sizeof what, "%s must be a count, not", name);
    return fail_tag(file, tag, what, value);
}

static sn_status start_file(vtp_file *file, const sn_xml_tag *tag) {
    const char *type = attribute_or(tag, "type", "nothing"), *order = attribute_or(tag, "byte_order", "LittleEndian");
    const char *header = attribute_or(tag, "header_type", "UInt32");
    if (!is_named(tag, "VTKFile")) return fail_tag(file, tag, "a VTK file is expected, not", tag->name);
    if (strcmp(type, "PolyData") != 0) {
        return fail_tag(file, tag, "a VTK file of PolyData is needed (in ParaView: Extract Surface, save as .vtp), not of", type);
    }
    file->layout.big_endian = strcmp(order, "BigEndian") == 0;
    if (!file->layout.big_endian && strcmp(order, "LittleEndian") != 0) return fail_tag(file, tag, "the byte order is unknown:", order);
    file->layout.long_header = strcmp(header, "UInt64") == 0;
    if (!file->layout.long_header && strcmp(header, "UInt32") != 0) return fail_tag(file, tag, "the header type is unknown:", header);
    snprintf(file->layout.compressor, sizeof file->layout.compressor, "%s", attribute_or(tag, "compressor", ""));
    return SN_OK;
}

/* The data follow the first '_'; they need not be XML. */
static sn_status start_appended(vtp_file *file, const sn_xml_tag *tag) {
    const sn_blob *blob = file->reader->blob;
    size_t at = tag->end;
    while (at < blob->size && memchr(" \t\r\n", blob->data[at], 4) != NULL) at++;
    if (at == blob->size || blob->data[at] != '_') return fail_tag(file, tag, "appended data must begin with", "'_'");
    const char *encoding = attribute_or(tag, "encoding", "base64");
    file->layout.appended_base64 = strcmp(encoding, "base64") == 0;
    if (!file->layout.appended_base64 && strcmp(encoding, "raw") != 0) {
        return fail_tag(file, tag, "the encoding of the appended data is unknown:", encoding);
    }
    file->layout.has_appended = true;
    file->layout.appended_begin = at + 1;
    return SN_STOPPED;
}

static sn_status start_piece(vtp_file *file, const sn_xml_tag *tag) {
    if (file->piece_count == MOST_PIECES) return fail_tag(file, tag, "the file has too many", "pieces");
    if (!sn_grow((void **)&file->pieces, &file->piece_capacity, file->piece_count + 1, sizeof(piece))) {
        return sn_fail_memory(file->reader->error, "pieces");
    }
    piece *p = &file->pieces[file->piece_count++];
    *p = (piece){.line = tag->line, .first_array = file->array_count};
    file->in_piece = true;
    sn_status status = read_count(file, tag, "NumberOfPoints", 0, &p->points);
    if (status == SN_OK) status = read_count(file, tag, "NumberOfLines", 0, &p->lines);
    if (status == SN_OK) status = read_count(file, tag, "NumberOfPolys", 0, &p->polys);
    return status == SN_OK ? read_count(file, tag, "NumberOfStrips", 0, &p->strips) : status;
}

static void start_section(vtp_file *file, const sn_xml_tag *tag) {
    bool lines = file->reader->lines != NULL;
    file->section = is_named(tag, "Points")      ? POINTS
                    : is_named(tag, "Lines")     ? (lines ? LINES : OTHER)
                    : lines                      ? OTHER
                    : is_named(tag, "PointData") ? POINT_DATA
                    : is_named(tag, "Polys")     ? POLYS
                    : is_named(tag, "Strips")    ? STRIPS
                                                 : OTHER;
}

static bool find_type(const char *name, sn_scalar *out) {
    static const char *const names[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                        "UInt32", "Int64", "UInt64", "Float32", "Float64"}; /* in the order of sn_scalar */
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(name, names[i]) != 0) continue;
        *out = (sn_scalar)i;
        return true;
    }
    return false;
}

static sn_status start_array(vtp_file *file, const sn_xml_tag *tag) {
    piece *p = &file->pieces[file->piece_count - 1];
    if (file->array_count == MOST_ARRAYS || p->array_count++ == MOST_ARRAYS_A_PIECE)
        return fail_tag(file, tag, "the file has too many", "arrays");
    if (!sn_grow((void **)&file->arrays, &file->array_capacity, file->array_count + 1, sizeof(sn_vtp_array))) {
        return sn_fail_memory(file->reader->error, "arrays");
    }
    const char *format = attribute_or(tag, "format", "ascii");
    sn_vtp_array *array = &file->arrays[file->array_count++];
    *array = (sn_vtp_array){.section = (int)file->section, .begin = tag->end, .end = tag->end, .line = tag->line};
    array->name = sn_strdup(attribute_or(tag, "Name", ""));
    if (array->name == NULL) return sn_fail_memory(file->reader->error, "the name of an array");
    array->numeric = find_type(attribute_or(tag, "type", ""), &array->type);
    array->place = strcmp(format, "appended") == 0 ? SN_VTP_APPENDED : strcmp(format, "binary") == 0 ? SN_VTP_INLINE : SN_VTP_TEXT;
    if (array->place == SN_VTP_TEXT && strcmp(format, "ascii") != 0) return fail_tag(file, tag, "the format is unknown:", format);
    file->in_array = true;
    file->content_ends = false;
    sn_status status = read_count(file, tag, "NumberOfComponents", 1, &array->components);
    return status == SN_OK ? read_count(file, tag, "offset", -1, &array->offset) : status;
}

/* Notes on an array stand before or behind its values. */
static void start_note(vtp_file *file, const sn_xml_tag *tag) {
    sn_vtp_array *array = &file->arrays[file->array_count - 1];
    const char *data = file->reader->blob->data;
    size_t at = array->begin;
    while (at < tag->begin && memchr(" \t\r\n", data[at], 4) != NULL) at++;
    if (file->content_ends || at == tag->begin) return;
    array->end = tag->begin;
    file->content_ends = true;
}

static sn_status on_start(void *user, const sn_xml_tag *tag) {
    vtp_file *file = user;
    switch (tag->depth) {
    case 0:
        return start_file(file, tag);
    case 1:
        file->in_data = is_named(tag, "PolyData");
        return is_named(tag, "AppendedData") ? start_appended(file, tag) : SN_OK;
    case 2:
        return file->in_data && is_named(tag, "Piece") ? start_piece(file, tag) : SN_OK;
    case 3:
        if (file->in_piece) start_section(file, tag);
        return SN_OK;
    case 4:
        return file->section != OTHER && is_named(tag, "DataArray") ? start_array(file, tag) : SN_OK;
    case 5:
        if (file->in_array) start_note(file, tag);
        return SN_OK;
    default:
        return SN_OK;
    }
}

static sn_status on_end(void *user, const sn_xml_tag *tag) {
    vtp_file *file = user;
    sn_vtp_array *array = file->in_array ? &file->arrays[file->array_count - 1] : NULL;
    if (tag->depth == 5 && array != NULL && !file->content_ends) {
        array->begin = array->end = tag->end;
        array->line = tag->line;
    } else if (tag->depth == 4) {
        if (array != NULL && !file->content_ends) array->end = tag->begin;
        file->in_array = false;
    } else if (tag->depth == 3) {
        file->section = OTHER;
    } else if (tag->depth == 2) {
        file->in_piece = false;
    }
    return SN_OK;
}

/* ---- the mesh ------------------------------------------------------------------------------------------------------- */

/* The array of a section, of this name (NULL = any); NULL = there is none. */
static const sn_vtp_array *find_array(const vtp_file *file, size_t piece_index, section wanted, const char *name) {
    const piece *p = &file->pieces[piece_index];
    for (size_t i = p->first_array; i < p->first_array + p->array_count; i++) {
        const sn_vtp_array *array = &file->arrays[i];
        if (array->section == (int)wanted && (name == NULL || strcmp(array->name, name) == 0)) return array;
    }
    return NULL;
}

static sn_status fail_piece(const vtp_file *file, size_t piece_index, const char *what) {
    return sn_fail_at(file->reader->error, SN_ERROR_INPUT, file->reader->blob->name, file->pieces[piece_index].line, "the piece %s", what);
}

/* Where a piece counts none of what an array is for, the array must be empty. */
static sn_status expect_none(vtp_file *file, size_t piece_index, section kind, const char *name, const char *what) {
    const sn_vtp_array *array = find_array(file, piece_index, kind, name);
    sn_vtp_values values = {0};
    sn_error *error = file->reader->error;
    if (array == NULL) return SN_OK;
    file->reader->error = NULL; /* an empty element need not be an array */
    sn_status status = sn_vtp_open(file->reader, &file->layout, array, 0, what, &values);
    file->reader->error = error;
    status = status == SN_OK ? sn_vtp_expect_end(&values) : SN_OK;
    sn_vtp_close(&values);
    return status;
}

static sn_status read_points(vtp_file *file, size_t piece_index) {
    sn_reader *reader = file->reader;
    int64_t count = file->pieces[piece_index].points;
    const sn_vtp_array *array = find_array(file, piece_index, POINTS, NULL);
    sn_vtp_values values = {0};
    if (count == 0) return expect_none(file, piece_index, POINTS, NULL, "points");
    if (array == NULL || (array->components != 3 && array->components != 1))
        return fail_piece(file, piece_index, "has no points of three numbers");
    if (count > SN_INDEX_MAX - reader->mesh.vertex_count) return fail_piece(file, piece_index, "has more points than can be counted");
    sn_status status = sn_vtp_open(reader, &file->layout, array, 3 * count, "points", &values);
    if (status == SN_OK) status = sn_reader_reserve(reader, reader->mesh.vertex_count + count, 0);
    for (int64_t i = 0; status == SN_OK && i < count; i++) {
        double x[3] = {0, 0, 0};
        for (int c = 0; status == SN_OK && c < 3; c++) status = sn_vtp_next(&values, &x[c]);
        if (status == SN_OK) status = sn_reader_add_vertex(reader, sn_v3(x[0], x[1], x[2]));
    }
    if (status == SN_OK) status = sn_vtp_expect_end(&values);
    sn_vtp_close(&values);
    return status;
}

/* Where each cell ends among the corners. */
static sn_status read_offsets(vtp_file *file, const sn_vtp_array *array, int64_t count, int64_t **out) {
    sn_vtp_values values = {0};
    sn_status status = sn_vtp_open(file->reader, &file->layout, array, count, "offsets", &values);
    if (status == SN_OK && (*out = SN_NEW(int64_t, count)) == NULL) status = sn_fail_memory(file->reader->error, "cells");
    double before = 0.0;
    for (int64_t i = 0; status == SN_OK && i < count; i++) {
        double value = 0.0;
        status = sn_vtp_next(&values, &value);
        if (status != SN_OK) break;
        if (!(value >= before && value <= 9e15)) {
            status = sn_reader_fail(file->reader, SN_NONE, "offset %lld of the cells is %.17g after %.17g; offsets ascend", (long long)i,
                                    value, before);
            break;
        }
        (*out)[i] = (int64_t)value;
        before = value;
    }
    if (status == SN_OK) status = sn_vtp_expect_end(&values);
    sn_vtp_close(&values);
    return status;
}

/* Cells of one kind in a piece. */
typedef struct cell_block {
    section kind;
    int64_t count;
    int64_t *ends;  /* (count) of each cell among the corners */
    sn_index first; /* vertex of the mesh that is the piece's first point */
    int64_t points; /* of the piece */
} cell_block;

static sn_status read_corner(vtp_file *file, sn_vtp_values *values, const cell_block *cells) {
    double vertex = 0.0;
    sn_status status = sn_vtp_next(values, &vertex);
    if (status != SN_OK) return status;
    if (vertex >= 0.0 && vertex < (double)cells->points && vertex == floor(vertex)) {
        return sn_reader_add_corner(file->reader, cells->first + (int64_t)vertex);
    }
    return sn_reader_fail(file->reader, SN_NONE, "a %s names vertex %.17g, but the piece has %lld points",
                          cells->kind == LINES ? "line" : "face", vertex, (long long)cells->points);
}

static sn_status read_connectivity(vtp_file *file, const sn_vtp_array *array, const cell_block *cells) {
    sn_reader *reader = file->reader;
    sn_vtp_values values = {0};
    bool lines = cells->kind == LINES;
    int64_t corners = cells->ends[cells->count - 1], triangles = lines ? 0 : corners - 2 * cells->count;
    sn_status status = sn_vtp_open(reader, &file->layout, array, corners, "connectivity", &values);
    if (status == SN_OK && triangles > 0) status = sn_reader_reserve(reader, 0, reader->mesh.triangle_count + triangles);
    for (int64_t i = 0; status == SN_OK && i < cells->count; i++) {
        int64_t begin = i > 0 ? cells->ends[i - 1] : 0;
        for (int64_t k = begin; status == SN_OK && k < cells->ends[i]; k++) status = read_corner(file, &values, cells);
        if (status != SN_OK) break;
        if (lines)
            status = sn_reader_add_line(reader);
        else
            status = cells->kind == STRIPS ? sn_reader_add_strip(reader) : sn_reader_add_face(reader, SN_NONE);
    }
    if (status == SN_OK) status = sn_vtp_expect_end(&values);
    sn_vtp_close(&values);
    return status;
}

static sn_status read_cells(vtp_file *file, size_t piece_index, section kind, int64_t count, sn_index first) {
    if (count == 0) return expect_none(file, piece_index, kind, "offsets", "offsets");
    const sn_vtp_array *offsets = find_array(file, piece_index, kind, "offsets");
    const sn_vtp_array *connectivity = find_array(file, piece_index, kind, "connectivity");
    if (offsets == NULL || connectivity == NULL) return fail_piece(file, piece_index, "has cells without connectivity and offsets");
    cell_block cells = {.kind = kind, .count = count, .first = first, .points = file->pieces[piece_index].points};
    sn_status status = read_offsets(file, offsets, count, &cells.ends);
    if (status == SN_OK) status = read_connectivity(file, connectivity, &cells);
    free(cells.ends);
    return status;
}

/* ---- point data ----------------------------------------------------------------------------------------------------- */

/* Has every piece with points this array, as wide? */
static bool is_everywhere(const vtp_file *file, const sn_vtp_array *array) {
    for (size_t i = 0; i < file->piece_count; i++) {
        if (file->pieces[i].points == 0) continue;
        const sn_vtp_array *other = find_array(file, i, POINT_DATA, array->name);
        if (other == NULL || !other->numeric || other->components != array->components) return false;
    }
    return true;
}

static sn_status read_rows(vtp_file *file, size_t piece_index, const sn_vtp_array *first_array, sn_index first, sn_attribute **attribute) {
    const sn_vtp_array *array = find_array(file, piece_index, POINT_DATA, first_array->name);
    int64_t components = array->components, count = file->pieces[piece_index].points * components;
    bool begins = array == first_array;
    sn_vtp_values values = {0};
    sn_status status = sn_vtp_open(file->reader, &file->layout, array, count, "point data", &values);
    if (status == SN_OK && begins) {
        const char *name = *array->name != '\0' ? array->name : "data";
        status = sn_reader_add_attribute(file->reader, name, components, sn_scalar_is_integer(array->type), attribute);
    }
    for (int64_t i = 0; status == SN_OK && *attribute != NULL && i < count; i++) {
        status = sn_vtp_next(&values, &(*attribute)->values[first * components + i]);
    }
    if (status == SN_OK && *attribute != NULL) status = sn_vtp_expect_end(&values);
    sn_vtp_close(&values);
    return status;
}

static sn_status read_attribute(vtp_file *file, const sn_vtp_array *array) {
    int64_t vertices = file->reader->mesh.vertex_count;
    if (!array->numeric || array->components == 0) return SN_OK;
    if (array->components > SN_INDEX_MAX / vertices || !is_everywhere(file, array)) {
        sn_log(SN_LOG_WARNING, "%s: the point data '%.64s' are left out: not all pieces have them alike", file->reader->blob->name,
               array->name);
        return SN_OK;
    }
    sn_attribute *attribute = NULL;
    sn_status status = SN_OK;
    sn_index first = 0;
    for (size_t i = 0; status == SN_OK && i < file->piece_count; i++) {
        if (file->pieces[i].points > 0) status = read_rows(file, i, array, first, &attribute);
        first += (sn_index)file->pieces[i].points;
    }
    return status;
}

static sn_status read_point_data(vtp_file *file) {
    size_t piece_index = 0;
    while (piece_index < file->piece_count && file->pieces[piece_index].points == 0) piece_index++;
    if (piece_index == file->piece_count) return SN_OK;
    const piece *p = &file->pieces[piece_index];
    sn_status status = SN_OK;
    for (size_t i = p->first_array; status == SN_OK && i < p->first_array + p->array_count; i++) {
        const sn_vtp_array *array = &file->arrays[i];
        bool wanted = array->section == (int)POINT_DATA && find_array(file, piece_index, POINT_DATA, array->name) == array;
        if (wanted) status = read_attribute(file, array);
    }
    return status;
}

/* ---- the file ------------------------------------------------------------------------------------------------------- */

static sn_status read_mesh(vtp_file *file) {
    sn_status status = SN_OK;
    for (size_t i = 0; status == SN_OK && i < file->piece_count; i++) status = read_points(file, i);
    sn_index first = 0;
    for (size_t i = 0; status == SN_OK && i < file->piece_count; i++) {
        const piece *p = &file->pieces[i];
        if (file->reader->lines != NULL) {
            status = read_cells(file, i, LINES, p->lines, first);
        } else {
            status = read_cells(file, i, POLYS, p->polys, first);
            if (status == SN_OK) status = read_cells(file, i, STRIPS, p->strips, first);
        }
        first += (sn_index)p->points;
    }
    return status == SN_OK ? read_point_data(file) : status;
}

sn_status sn_vtp_parse(sn_reader *reader) {
    vtp_file file = {.reader = reader};
    sn_status status = sn_xml_walk(reader->blob, on_start, on_end, &file, reader->error);
    if (status == SN_OK) status = read_mesh(&file);
    for (size_t i = 0; i < file.array_count; i++) free(file.arrays[i].name);
    free(file.arrays);
    free(file.pieces);
    return status;
}

/* The first element is a VTKFile: whatever stands before it. */
bool sn_vtp_is(const sn_blob *blob) {
    static const char root[] = "<VTKFile";
    const char *at = blob->data, *end = blob->data + blob->size;
    at += sn_byte_order_mark(at, blob->size);
    for (;;) {
        while (at < end && memchr(" \t\r\n", *at, 4) != NULL) at++;
        if ((size_t)(end - at) < sizeof root || *at != '<') return false;
        if (memcmp(at, root, sizeof root - 1) == 0) return true;
        if (at[1] != '?' && at[1] != '!') return false;
        if (at[1] == '!' && at[2] == 'D') return memmem(at, (size_t)(end - at), root, sizeof root - 1) != NULL; /* a document type */
        const char *close = memcmp(at, "<!--", 4) == 0 ? memmem(at, (size_t)(end - at), "-->", 3) : memchr(at, '>', (size_t)(end - at));
        if (close == NULL) return false;
        at = close + (*close == '-' ? 3 : 1);
    }
}
