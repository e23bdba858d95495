/*
 * vtk.c -- legacy VTK files of PolyData, as text and as binary (big-endian), versions 1 to 5.1.
 *
 * Format: The VTK User's Guide, "VTK File Formats", and vtkPolyDataReader. Polygons and triangle strips are the surface; vertices, data of
 * cells and data of the whole are passed over, lines too unless the reader takes them. Numbers of the points become attributes under their
 * own names.
 */
#include "mesh_reader.h"
#include "scalar.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char magic[] = "# vtk DataFile Version";

static const struct {
    const char *name;
    sn_scalar type;
} scalar_types[] = {
    {"float", SN_FLOAT32},
    {"double", SN_FLOAT64},
    {"int", SN_INT32},
    {"unsigned_int", SN_UINT32},
    {"long", SN_INT64},
    {"unsigned_long", SN_UINT64},
    {"char", SN_INT8},
    {"signed_char", SN_INT8},
    {"unsigned_char", SN_UINT8},
    {"short", SN_INT16},
    {"unsigned_short", SN_UINT16},
    {"vtkIdType", SN_INT32},
    {"vtktypeint64", SN_INT64},
    {"vtktypeuint64", SN_UINT64},
    {"vtktypeint32", SN_INT32},
    {"vtktypeuint32", SN_UINT32},
    {"vtktypeint16", SN_INT16},
    {"vtktypeuint16", SN_UINT16},
    {"vtktypeint8", SN_INT8},
    {"vtktypeuint8", SN_UINT8},
    {"vtktypefloat32", SN_FLOAT32},
    {"vtktypefloat64", SN_FLOAT64},
};

typedef enum value_kind { NUMBERS, BITS, STRINGS } value_kind;
typedef struct value_type {
    value_kind kind;
    sn_scalar scalar;
} value_type;

/* Whose data the arrays are that follow. */
typedef enum data_of { OF_ALL, OF_POINTS, OF_CELLS } data_of;

typedef struct vtk_file {
    sn_reader *reader;
    bool binary, has_points;
    data_of section;
    int64_t rows;       /* of each array in the section */
    int64_t components; /* of the last array */
} vtk_file;

/* A name for %.*s, cut where it is too long for a message. */
#define SHOWN(span) (int)((span).length < 64 ? (span).length : 64), (span).text

/* ---- words ---------------------------------------------------------------------------------------------------------- */

static sn_status fail_found(vtk_file *file, const char *expected) {
    char found[48];
    return sn_reader_fail(file->reader, SN_NONE, "expected %s, found %s", expected, sn_reader_found(file->reader, found));
}

/* The same for what stands on a line of its own. */
static sn_status fail_next(vtk_file *file, const char *expected) {
    sn_reader_find_line(file->reader);
    return fail_found(file, expected);
}

static sn_status read_count(vtk_file *file, const char *what, int64_t *out) {
    if (sn_reader_integer(file->reader, out) && *out >= 0) return SN_OK;
    return fail_found(file, what);
}

static bool find_type(sn_span word, value_type *out) {
    *out = (value_type){.kind = sn_span_is_like(word, "bit") ? BITS : STRINGS};
    if (out->kind == BITS || sn_span_is_like(word, "string") || sn_span_is_like(word, "utf8_string")) return true;
    for (size_t i = 0; i < sizeof scalar_types / sizeof *scalar_types; i++) {
        if (!sn_span_is_like(word, scalar_types[i].name)) continue;
        *out = (value_type){.kind = NUMBERS, .scalar = scalar_types[i].type};
        return true;
    }
    return false;
}

static sn_status read_type(vtk_file *file, value_type *out) {
    const char *start = file->reader->at;
    if (find_type(sn_reader_word(file->reader), out)) return SN_OK;
    file->reader->at = start;
    return fail_found(file, "a type such as float or int");
}

static sn_status read_number_type(vtk_file *file, sn_scalar *out) {
    value_type type;
    sn_status status = read_type(file, &type);
    if (status == SN_OK && type.kind != NUMBERS) return sn_reader_fail(file->reader, SN_NONE, "only numbers can stand here");
    *out = type.scalar;
    return status;
}

/* Is the next word this one? If so it is taken; if not the cursor stays: what follows may be binary. */
static bool take_word(vtk_file *file, const char *word) {
    sn_reader *reader = file->reader;
    const char *at = reader->at;
    int64_t line = reader->line;
    if (sn_reader_find_line(reader) && sn_span_is_like(sn_reader_word(reader), word)) return true;
    reader->at = at;
    reader->line = line;
    return false;
}

/* ---- values --------------------------------------------------------------------------------------------------------- */

/* Binary values begin behind the line of their declaration. Are there `count` of them, at least by the size of the file? */
static sn_status begin_values(vtk_file *file, sn_scalar type, int64_t count, const char *what) {
    sn_reader *reader = file->reader;
    if (file->binary) {
        const char *newline = memchr(reader->at, '\n', sn_reader_left(reader));
        reader->at = newline != NULL ? newline + 1 : reader->end;
    }
    uint64_t left = sn_reader_left(reader), most = file->binary ? left / sn_scalar_size(type) : (left + 1) / 2;
    if ((uint64_t)count <= most) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "%lld numbers of %s are promised, more than the rest of the file (%llu bytes) can hold",
                          (long long)count, what, (unsigned long long)left);
}

static sn_status read_value(vtk_file *file, sn_scalar type, const char *what, double *out) {
    sn_reader *reader = file->reader;
    if (file->binary) {
        const unsigned char *bytes = sn_reader_take(reader, sn_scalar_size(type));
        if (bytes == NULL) return sn_reader_fail(reader, SN_NONE, "the file ends within %s; it is cut short", what);
        *out = sn_scalar_decode(bytes, type, true);
        return SN_OK;
    }
    char found[48];
    if (!sn_reader_find_line(reader)) return sn_reader_fail(reader, SN_NONE, "the file ends within %s; it is cut short", what);
    if (sn_reader_number(reader, out)) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "expected a number of %s, found %s", what, sn_reader_found(reader, found));
}

static sn_status skip_values(vtk_file *file, sn_scalar type, int64_t count, const char *what) {
    double ignored;
    sn_status status = begin_values(file, type, count, what);
    if (status == SN_OK && file->binary) {
        file->reader->at += (size_t)count * sn_scalar_size(type);
        return SN_OK;
    }
    for (int64_t i = 0; status == SN_OK && i < count; i++) status = read_value(file, type, what, &ignored);
    return status;
}

/* A string's length in binary: its top two bits say how many bytes it takes (vtkDataWriter). */
static bool take_string(sn_reader *reader) {
    if (sn_reader_left(reader) == 0) return false;
    int form = 3 - ((unsigned char)*reader->at >> 6);
    const unsigned char *bytes = sn_reader_take(reader, (size_t)1 << form);
    if (bytes == NULL) return false;
    uint64_t length = bytes[0] & 0x3f;
    for (int i = 1; i < 1 << form; i++) length = length << 8 | bytes[i];
    return length <= sn_reader_left(reader) && sn_reader_take(reader, (size_t)length) != NULL;
}

/* In text a string is a line. */
static sn_status skip_strings(vtk_file *file, int64_t count) {
    sn_reader *reader = file->reader;
    sn_status status = begin_values(file, SN_UINT8, count / 2, "strings"); /* a line is one byte at least */
    for (int64_t i = 0; status == SN_OK && i < count; i++) {
        bool there = file->binary ? take_string(reader) : sn_reader_next_line(reader);
        if (!there) status = sn_reader_fail(reader, SN_NONE, "the file ends within strings; it is cut short");
    }
    if (status == SN_OK && !file->binary) sn_reader_next_line(reader);
    return status;
}

static sn_status skip_array(vtk_file *file, value_type type, int64_t rows, int64_t components, const char *what) {
    if (components > 0 && rows > INT64_MAX / components) return sn_reader_fail(file->reader, SN_NONE, "%s are impossibly many", what);
    int64_t count = rows * components;
    if (type.kind == STRINGS) return skip_strings(file, count);
    if (type.kind == BITS) return skip_values(file, SN_UINT8, file->binary ? count / 8 + (count % 8 > 0) : count, what);
    return skip_values(file, type.scalar, count, what);
}

/* ---- points and cells ----------------------------------------------------------------------------------------------- */

static sn_status read_points(vtk_file *file) {
    sn_reader *reader = file->reader;
    int64_t count = 0;
    sn_scalar type = SN_FLOAT32;
    sn_status status = read_count(file, "the count of points", &count);
    if (status == SN_OK && file->has_points) return sn_reader_fail(reader, SN_NONE, "the file has POINTS twice");
    if (status == SN_OK && count > SN_INDEX_MAX) return sn_reader_reserve(reader, count, 0);
    if (status == SN_OK) status = read_number_type(file, &type);
    if (status == SN_OK) status = begin_values(file, type, 3 * count, "points");
    if (status == SN_OK) status = sn_reader_reserve(reader, count, 0);
    file->has_points = true;
    file->components = 3;
    for (int64_t i = 0; status == SN_OK && i < count; i++) {
        double x[3] = {0, 0, 0};
        for (int c = 0; status == SN_OK && c < 3; c++) status = read_value(file, type, "points", &x[c]);
        if (status == SN_OK) status = sn_reader_add_vertex(reader, sn_v3(x[0], x[1], x[2]));
    }
    return status;
}

typedef enum cell_kind { POLYGONS, STRIPS, LINE_CELLS, PASSED_OVER } cell_kind;

static sn_status read_corner(vtk_file *file, sn_scalar type) {
    double vertex = 0.0;
    sn_status status = read_value(file, type, "cells", &vertex);
    if (status != SN_OK) return status;
    if (!(vertex >= 0.0 && vertex <= SN_INDEX_MAX) || vertex != floor(vertex)) {
        return sn_reader_fail(file->reader, SN_NONE, "a %s names vertex %.17g, which cannot be",
                              file->reader->lines != NULL ? "line" : "face", vertex);
    }
    return sn_reader_add_corner(file->reader, (int64_t)vertex);
}

static sn_status read_cell(vtk_file *file, cell_kind kind, sn_scalar type, int64_t corners) {
    for (int64_t i = 0; i < corners; i++) {
        sn_status status = read_corner(file, type);
        if (status != SN_OK) return status;
    }
    if (kind == LINE_CELLS) return sn_reader_add_line(file->reader);
    return kind == STRIPS ? sn_reader_add_strip(file->reader) : sn_reader_add_face(file->reader, SN_NONE);
}

/* Rows "count vertex vertex ...", `size` numbers in all. */
static sn_status read_rows(vtk_file *file, cell_kind kind, int64_t cells, int64_t size) {
    if (kind == PASSED_OVER) return skip_values(file, SN_INT32, size, "cells");
    sn_status status = begin_values(file, SN_INT32, size, "cells");
    for (int64_t i = 0; status == SN_OK && i < cells; i++) {
        double corners = 0.0;
        if (size-- < 1) return sn_reader_fail(file->reader, SN_NONE, "the cells have more numbers than were promised");
        status = read_value(file, SN_INT32, "cells", &corners);
        if (status != SN_OK) return status;
        if (!(corners >= 0.0 && corners <= (double)size) || corners != floor(corners)) {
            return sn_reader_fail(file->reader, SN_NONE, "cell %lld has the impossible count of %.17g vertices", (long long)i, corners);
        }
        size -= (int64_t)corners;
        status = read_cell(file, kind, SN_INT32, (int64_t)corners);
    }
    if (status == SN_OK && size > 0) {
        return sn_reader_fail(file->reader, SN_NONE, "the %lld cells that are counted leave %lld of their numbers over; correct the counts",
                              (long long)cells, (long long)size);
    }
    return status;
}

/* Where each cell begins among the corners, and where the last one ends. */
static sn_status read_offsets(vtk_file *file, int64_t count, int64_t corners, int64_t **out) {
    sn_scalar type = SN_INT64;
    sn_status status = read_number_type(file, &type);
    if (status == SN_OK) status = begin_values(file, type, count, "OFFSETS");
    if (status != SN_OK) return status;
    int64_t *offsets = *out = SN_NEW(int64_t, count);
    if (offsets == NULL) return sn_fail_memory(file->reader->error, "cells");
    for (int64_t i = 0; i < count; i++) {
        double value = 0.0;
        status = read_value(file, type, "OFFSETS", &value);
        if (status != SN_OK) return status;
        double least = i > 0 ? (double)offsets[i - 1] : 0.0;
        if (!(value >= least && value <= (double)corners)) {
            return sn_reader_fail(file->reader, SN_NONE, "offset %lld of the cells is %.17g; offsets ascend up to the %lld vertices of all",
                                  (long long)i, value, (long long)corners);
        }
        offsets[i] = (int64_t)value;
    }
    return SN_OK;
}

/* Version 5: OFFSETS and CONNECTIVITY apart. */
static sn_status read_split_cells(vtk_file *file, cell_kind kind, int64_t count, int64_t corners) {
    int64_t *offsets = NULL;
    sn_scalar type = SN_INT64;
    sn_status status = read_offsets(file, count, corners, &offsets);
    if (status == SN_OK && !take_word(file, "CONNECTIVITY")) status = fail_next(file, "CONNECTIVITY");
    if (status == SN_OK) status = read_number_type(file, &type);
    if (status == SN_OK && kind == PASSED_OVER) {
        status = skip_values(file, type, corners, "CONNECTIVITY");
    } else if (status == SN_OK) {
        status = begin_values(file, type, corners, "CONNECTIVITY");
        int64_t used = count > 0 ? offsets[count - 1] - offsets[0] : 0;
        if (status == SN_OK && used != corners) {
            status = sn_reader_fail(file->reader, SN_NONE, "the cells name %lld vertices by their offsets, but %lld are counted",
                                    (long long)used, (long long)corners);
        }
        for (int64_t i = 0; status == SN_OK && i + 1 < count; i++) status = read_cell(file, kind, type, offsets[i + 1] - offsets[i]);
    }
    free(offsets);
    return status;
}

static sn_status read_cells(vtk_file *file, cell_kind kind) {
    int64_t count = 0, size = 0;
    sn_status status = read_count(file, "the count of cells", &count);
    if (status == SN_OK) status = read_count(file, "the count of the cells' numbers", &size);
    if (status != SN_OK) return status;
    return take_word(file, "OFFSETS") ? read_split_cells(file, kind, count, size) : read_rows(file, kind, count, size);
}

/* ---- data ----------------------------------------------------------------------------------------------------------- */

/* Names are written with %20 for a blank and so on. */
static char *decode_name(sn_span span) {
    char *name = sn_strndup(span.text, span.length);
    if (name == NULL) return NULL;
    size_t length = 0;
    for (const char *at = name; *at != '\0'; at++) {
        char digits[3] = {at[0] == '%' ? at[1] : '\0', at[0] == '%' && at[1] != '\0' ? at[2] : '\0', '\0'}, *end;
        long code = strtol(digits, &end, 16);
        bool coded = end == digits + 2 && digits[0] != '-' && digits[0] != '+' && digits[0] != ' ' && code > 0;
        name[length++] = coded ? (char)code : *at;
        if (coded) at += 2;
    }
    name[length] = '\0';
    return name;
}

static sn_status read_attribute(vtk_file *file, sn_span name, sn_scalar type, int64_t components) {
    sn_reader *reader = file->reader;
    int64_t count = components * reader->mesh.vertex_count;
    sn_attribute *attribute = NULL;
    sn_status status = begin_values(file, type, count, "point data");
    if (status != SN_OK) return status;
    char *decoded = decode_name(name);
    if (decoded == NULL) return sn_fail_memory(reader->error, "vertex attributes");
    status = sn_reader_add_attribute(reader, decoded, components, sn_scalar_is_integer(type), &attribute);
    free(decoded);
    double ignored;
    for (int64_t i = 0; status == SN_OK && i < count; i++) {
        status = read_value(file, type, "point data", attribute != NULL ? &attribute->values[i] : &ignored);
    }
    return status;
}

static sn_status read_array(vtk_file *file, sn_span name, value_type type, int64_t rows, int64_t components) {
    file->components = components;
    bool kept = file->reader->lines == NULL && file->section == OF_POINTS && type.kind == NUMBERS &&
                rows == file->reader->mesh.vertex_count && components >= 1;
    if (kept && components <= SN_INDEX_MAX / (rows > 0 ? rows : 1)) return read_attribute(file, name, type.scalar, components);
    return skip_array(file, type, rows, components, "data");
}

static sn_status read_name(vtk_file *file, sn_span *out) {
    *out = sn_reader_word(file->reader);
    return out->length > 0 ? SN_OK : fail_found(file, "the name of an array");
}

/* NAME TYPE, with a fixed number of components. */
static sn_status read_plain_data(vtk_file *file, int64_t components) {
    sn_span name;
    value_type type;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_type(file, &type);
    return status == SN_OK ? read_array(file, name, type, file->rows, components) : status;
}

static sn_status read_scalars(vtk_file *file) {
    sn_span name;
    value_type type;
    int64_t components = 1;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_type(file, &type);
    if (status == SN_OK && !sn_reader_at_line_end(file->reader)) status = read_count(file, "the count of components", &components);
    if (status != SN_OK) return status;
    take_word(file, "LOOKUP_TABLE"); /* and its name, up to the end of that line */
    if (!file->binary) sn_reader_rest(file->reader);
    return read_array(file, name, type, file->rows, components);
}

/* Numbers 0..1 in text, bytes in binary. */
static sn_status read_colour_scalars(vtk_file *file) {
    sn_span name;
    int64_t components = 0;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_count(file, "the count of components", &components);
    if (status != SN_OK) return status;
    value_type type = {.kind = NUMBERS, .scalar = file->binary ? SN_UINT8 : SN_FLOAT32};
    return read_array(file, name, type, file->rows, components);
}

static sn_status read_lookup_table(vtk_file *file) {
    sn_span name;
    int64_t size = 0;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_count(file, "the size of a lookup table", &size);
    value_type type = {.kind = NUMBERS, .scalar = SN_UINT8};
    return status == SN_OK ? skip_array(file, type, size, 4, "a lookup table") : status;
}

static sn_status read_texture_coordinates(vtk_file *file) {
    sn_span name;
    int64_t components = 0;
    value_type type;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_count(file, "the count of texture coordinates", &components);
    if (status == SN_OK) status = read_type(file, &type);
    return status == SN_OK ? read_array(file, name, type, file->rows, components) : status;
}

/* What is known about the last array: lines up to a blank one. Names of components, a line each, may be blank. */
static sn_status skip_metadata(vtk_file *file) {
    sn_reader *reader = file->reader;
    while (sn_reader_next_line(reader) && !sn_reader_at_line_end(reader)) {
        bool names = sn_span_is_like(sn_reader_word(reader), "COMPONENT_NAMES");
        for (int64_t i = 0; names && i < file->components && sn_reader_next_line(reader); i++) continue;
    }
    return SN_OK;
}

static sn_status read_field_array(vtk_file *file) {
    while (take_word(file, "METADATA")) {
        sn_status status = skip_metadata(file);
        if (status != SN_OK) return status;
    }
    if (!sn_reader_find_line(file->reader)) return sn_reader_fail(file->reader, SN_NONE, "the file ends within a FIELD; it is cut short");
    sn_span name;
    int64_t components = 0, rows = 0;
    value_type type;
    sn_status status = read_name(file, &name);
    if (status == SN_OK && sn_span_is(name, "NULL_ARRAY")) return SN_OK;
    if (status == SN_OK) status = read_count(file, "the count of components", &components);
    if (status == SN_OK) status = read_count(file, "the count of rows", &rows);
    if (status == SN_OK) status = read_type(file, &type);
    return status == SN_OK ? read_array(file, name, type, rows, components) : status;
}

static sn_status read_field(vtk_file *file) {
    sn_span name;
    int64_t count = 0;
    sn_status status = read_name(file, &name);
    if (status == SN_OK) status = read_count(file, "the count of arrays", &count);
    for (int64_t i = 0; status == SN_OK && i < count; i++) status = read_field_array(file);
    return status;
}

static sn_status begin_section(vtk_file *file, data_of section) {
    sn_status status = read_count(file, "the count of rows", &file->rows);
    if (status != SN_OK) return status;
    file->section = section;
    if (section == OF_CELLS || file->rows == file->reader->mesh.vertex_count) return SN_OK;
    return sn_reader_fail(file->reader, SN_NONE, "POINT_DATA has %lld rows for %d points", (long long)file->rows,
                          (int)file->reader->mesh.vertex_count);
}

/* ---- the file ------------------------------------------------------------------------------------------------------- */

typedef enum keyword {
    POINTS,
    VERTICES,
    LINES,
    POLYGONS_WORD,
    TRIANGLE_STRIPS,
    POINT_DATA,
    CELL_DATA,
    SCALARS,
    COLOR_SCALARS,
    LOOKUP_TABLE,
    VECTORS,
    NORMALS,
    TEXTURE_COORDINATES,
    TENSORS,
    TENSORS6,
    GLOBAL_IDS,
    PEDIGREE_IDS,
    EDGE_FLAGS,
    FIELD,
    METADATA,
    KEYWORD_COUNT
} keyword;

static const char *const keywords[KEYWORD_COUNT] = {
    "POINTS",        "VERTICES",     "LINES",   "POLYGONS", "TRIANGLE_STRIPS",     "POINT_DATA", "CELL_DATA", "SCALARS",
    "COLOR_SCALARS", "LOOKUP_TABLE", "VECTORS", "NORMALS",  "TEXTURE_COORDINATES", "TENSORS",    "TENSORS6",  "GLOBAL_IDS",
    "PEDIGREE_IDS",  "EDGE_FLAGS",   "FIELD",   "METADATA",
};

static keyword find_keyword(sn_span word) {
    int i = 0;
    while (i < KEYWORD_COUNT && !sn_span_is_like(word, keywords[i])) i++;
    return (keyword)i;
}

static sn_status read_section(vtk_file *file, keyword word) {
    switch (word) {
    case POINTS:
        return read_points(file);
    case VERTICES:
        return read_cells(file, PASSED_OVER);
    case LINES:
        return read_cells(file, file->reader->lines != NULL ? LINE_CELLS : PASSED_OVER);
    case POLYGONS_WORD:
        return read_cells(file, file->reader->lines != NULL ? PASSED_OVER : POLYGONS);
    case TRIANGLE_STRIPS:
        return read_cells(file, file->reader->lines != NULL ? PASSED_OVER : STRIPS);
    case POINT_DATA:
        return begin_section(file, OF_POINTS);
    case CELL_DATA:
        return begin_section(file, OF_CELLS);
    case SCALARS:
        return read_scalars(file);
    case COLOR_SCALARS:
        return read_colour_scalars(file);
    case LOOKUP_TABLE:
        return read_lookup_table(file);
    case VECTORS:
    case NORMALS:
        return read_plain_data(file, 3);
    case TEXTURE_COORDINATES:
        return read_texture_coordinates(file);
    case TENSORS:
        return read_plain_data(file, 9);
    case TENSORS6:
        return read_plain_data(file, 6);
    case GLOBAL_IDS:
    case PEDIGREE_IDS:
    case EDGE_FLAGS:
        return read_plain_data(file, 1);
    case FIELD:
        return read_field(file);
    case METADATA:
        return skip_metadata(file);
    case KEYWORD_COUNT:
        break;
    }
    return fail_found(file, "a keyword of PolyData, such as POINTS or POLYGONS");
}

bool sn_vtk_is(const sn_blob *blob) { return blob->size >= sizeof magic - 1 && strncasecmp(blob->data, magic, sizeof magic - 1) == 0; }

/* Two lines of any text, the encoding, the kind of data. */
static sn_status read_header(vtk_file *file) {
    sn_reader *reader = file->reader;
    bool there = sn_reader_next_line(reader) && sn_reader_next_line(reader) && sn_reader_find_line(reader);
    if (!there) return sn_reader_fail(reader, SN_NONE, "the header ends before ASCII or BINARY; the file is cut short");
    const char *start = reader->at;
    sn_span word = sn_reader_word(reader);
    file->binary = sn_span_is_like(word, "BINARY");
    if (!file->binary && !sn_span_is_like(word, "ASCII")) {
        reader->at = start;
        return fail_found(file, "ASCII or BINARY in the third line");
    }
    if (!take_word(file, "DATASET")) return fail_next(file, "DATASET POLYDATA");
    word = sn_reader_word(reader);
    if (sn_span_is_like(word, "POLYDATA")) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "the data set is %.*s, not POLYDATA; extract its surface in ParaView and save that",
                          SHOWN(word));
}

sn_status sn_vtk_parse(sn_reader *reader) {
    vtk_file file = {.reader = reader};
    sn_status status = read_header(&file);
    if (status == SN_OK && file.binary) reader->line = 0;
    while (status == SN_OK && sn_reader_find_line(reader)) {
        const char *start = reader->at;
        keyword word = find_keyword(sn_reader_word(reader));
        if (word == KEYWORD_COUNT) reader->at = start;
        status = read_section(&file, word);
    }
    return status;
}
