/*
 * ply.c -- the Stanford polygon format: ASCII and binary of both byte orders.
 *
 * Format: G. Turk, The PLY Polygon File Format (1994). Scalars of vertices other than x, y, z become attributes under their own names;
 * lists of vertices, and elements other than vertices, faces and tristrips, are passed over. The scans of the Stanford repository have
 * strips of triangles in place of faces: lists in which -1 begins the next strip.
 */
#include "mesh_reader.h"
#include "scalar.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *sized_name;
    sn_scalar type;
} scalar_types[] = {
    {"char", "int8", SN_INT8},  {"uchar", "uint8", SN_UINT8},  {"short", "int16", SN_INT16},     {"ushort", "uint16", SN_UINT16},
    {"int", "int32", SN_INT32}, {"uint", "uint32", SN_UINT32}, {"float", "float32", SN_FLOAT32}, {"double", "float64", SN_FLOAT64},
};
enum { TYPE_COUNT = sizeof scalar_types / sizeof *scalar_types };

/* Where the values of a property go. */
typedef enum target { SKIP, COORDINATE, ATTRIBUTE, CORNERS, STRIPS } target;

typedef struct property {
    sn_span name;
    bool list;
    sn_scalar type, count_type;
    target target;
    sn_index slot; /* 0..2 = x, y, z; or the attribute */
} property;

typedef struct element {
    sn_span name;
    int64_t count;
    size_t first, property_count; /* into the header's properties */
} element;

enum { MOST_ELEMENTS = 64, MOST_PROPERTIES = 1024 };

typedef struct header {
    sn_mesh_encoding encoding;
    size_t element_count, property_count;
    element elements[MOST_ELEMENTS];
    property properties[MOST_PROPERTIES];
} header;

/* A name for %.*s, cut where it is too long for a message. */
#define SHOWN(span) (int)((span).length < 64 ? (span).length : 64), (span).text

/* ---- the header ----------------------------------------------------------------------------------------------------- */

static bool read_type(sn_span word, sn_scalar *out) {
    for (int i = 0; i < TYPE_COUNT; i++) {
        if (!sn_span_is(word, scalar_types[i].name) && !sn_span_is(word, scalar_types[i].sized_name)) continue;
        *out = scalar_types[i].type;
        return true;
    }
    return false;
}

static sn_status read_format(sn_reader *reader, header *h) {
    sn_span word = sn_reader_word(reader);
    h->encoding = sn_span_is(word, "ascii")                  ? SN_ENCODING_ASCII
                  : sn_span_is(word, "binary_little_endian") ? SN_ENCODING_LITTLE
                  : sn_span_is(word, "binary_big_endian")    ? SN_ENCODING_BIG
                                                             : SN_ENCODING_DEFAULT;
    if (h->encoding != SN_ENCODING_DEFAULT && sn_span_is(sn_reader_word(reader), "1.0")) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "the format must be ascii, binary_little_endian or binary_big_endian, version 1.0");
}

static sn_status read_element(sn_reader *reader, header *h) {
    if (h->element_count == MOST_ELEMENTS) return sn_reader_fail(reader, SN_NONE, "the header has more than %d elements", MOST_ELEMENTS);
    element *e = &h->elements[h->element_count];
    *e = (element){.name = sn_reader_word(reader), .first = h->property_count};
    char found[48];
    if (e->name.length == 0 || !sn_reader_integer(reader, &e->count) || e->count < 0) {
        return sn_reader_fail(reader, SN_NONE, "an element needs a name and a count, found %s", sn_reader_found(reader, found));
    }
    for (size_t i = 0; i < h->element_count; i++) {
        sn_span other = h->elements[i].name;
        if (other.length == e->name.length && memcmp(other.text, e->name.text, other.length) == 0) {
            return sn_reader_fail(reader, SN_NONE, "element %.*s is declared twice", SHOWN(e->name));
        }
    }
    h->element_count++;
    return SN_OK;
}

static bool read_property_types(sn_reader *reader, property *p) {
    sn_span word = sn_reader_word(reader);
    p->list = sn_span_is(word, "list");
    if (!p->list) return read_type(word, &p->type);
    return read_type(sn_reader_word(reader), &p->count_type) && sn_scalar_is_integer(p->count_type) &&
           read_type(sn_reader_word(reader), &p->type);
}

static sn_status read_property(sn_reader *reader, header *h) {
    if (h->element_count == 0) return sn_reader_fail(reader, SN_NONE, "a property stands before the first element");
    if (h->property_count == MOST_PROPERTIES)
        return sn_reader_fail(reader, SN_NONE, "the header has more than %d properties", MOST_PROPERTIES);
    property p = {0};
    if (!read_property_types(reader, &p)) {
        return sn_reader_fail(reader, SN_NONE, "a property needs a type such as float, uchar or list uchar int");
    }
    p.name = sn_reader_word(reader);
    if (p.name.length == 0) return sn_reader_fail(reader, SN_NONE, "a property needs a name");
    h->properties[h->property_count++] = p;
    h->elements[h->element_count - 1].property_count++;
    return SN_OK;
}

/* Binary data begin behind the line of end_header: where lines end in CR alone, a following LF is data. */
static void begin_data(sn_reader *reader, const header *h) {
    const char *first = memchr(reader->blob->data, '\r', reader->blob->size);
    bool bare_return = first != NULL && first + 1 < reader->end && first[1] != '\n' && first < reader->at;
    while (reader->at < reader->end && *reader->at != '\n' && *reader->at != '\r') reader->at++;
    if (bare_return && reader->at < reader->end) {
        reader->at++;
    } else {
        sn_reader_next_line(reader);
    }
    if (h->encoding != SN_ENCODING_ASCII) reader->line = 0;
}

static sn_status read_header(sn_reader *reader, header *h) {
    sn_reader_find_line(reader);
    sn_reader_word(reader); /* ply */
    while (sn_reader_next_line(reader)) {
        sn_span word = sn_reader_word(reader);
        sn_status status = SN_OK;
        if (sn_span_is(word, "format")) {
            status = read_format(reader, h);
        } else if (sn_span_is(word, "element")) {
            status = read_element(reader, h);
        } else if (sn_span_is(word, "property")) {
            status = read_property(reader, h);
        } else if (sn_span_is(word, "end_header")) {
            if (h->encoding == SN_ENCODING_DEFAULT) return sn_reader_fail(reader, SN_NONE, "the header names no format");
            return SN_OK;
        } else if (word.length > 0 && !sn_span_is(word, "comment") && !sn_span_is(word, "obj_info")) {
            char found[48];
            reader->at = word.text;
            return sn_reader_fail(reader, SN_NONE, "the header says %s, which is no PLY keyword", sn_reader_found(reader, found));
        }
        if (status != SN_OK) return status;
    }
    return sn_reader_fail(reader, SN_NONE, "the header has no end_header; the file is cut short");
}

/* ---- what the header promises, against the file --------------------------------------------------------------------- */

/* The fewest bytes that an element's row can take; in text a digit and a separator a value. */
static uint64_t least_bytes(const header *h, const element *e) {
    uint64_t bytes = 0;
    for (size_t i = 0; i < e->property_count; i++) {
        const property *p = &h->properties[e->first + i];
        bytes += h->encoding == SN_ENCODING_ASCII ? 2 : sn_scalar_size(p->list ? p->count_type : p->type);
    }
    return bytes;
}

static sn_status check_counts(sn_reader *reader, const header *h) {
    uint64_t left = sn_reader_left(reader) + (h->encoding == SN_ENCODING_ASCII); /* the last separator may be missing */
    for (size_t i = 0; i < h->element_count; i++) {
        const element *e = &h->elements[i];
        uint64_t row = least_bytes(h, e);
        if (row > 0 && (uint64_t)e->count > left / row) {
            return sn_reader_fail(reader, SN_NONE,
                                  "the header promises %lld of element %.*s, more than the rest of the file (%zu bytes) can hold",
                                  (long long)e->count, SHOWN(e->name), sn_reader_left(reader));
        }
        left -= row * (uint64_t)e->count;
    }
    return SN_OK;
}

/* ---- the vertices --------------------------------------------------------------------------------------------------- */

static const element *find_element(const header *h, const char *name) {
    for (size_t i = 0; i < h->element_count; i++) {
        if (sn_span_is(h->elements[i].name, name)) return &h->elements[i];
    }
    return NULL;
}

static sn_status add_attribute(sn_reader *reader, property *p) {
    char name[256];
    size_t length = p->name.length < sizeof name - 1 ? p->name.length : sizeof name - 1;
    memcpy(name, p->name.text, length);
    name[length] = '\0';
    if (sn_mesh_attribute(&reader->mesh, name) != NULL) return sn_reader_fail(reader, SN_NONE, "the vertices have two properties %s", name);
    sn_attribute *attribute = sn_mesh_add_attribute(&reader->mesh, name, 1);
    if (attribute == NULL) return sn_fail_memory(reader->error, "vertex attributes");
    attribute->integer = sn_scalar_is_integer(p->type);
    p->target = ATTRIBUTE;
    p->slot = reader->mesh.attribute_count - 1;
    return SN_OK;
}

/* Say where each property of the vertices goes. Attributes are sized by the mesh's count of vertices. */
static sn_status plan_vertices(sn_reader *reader, header *h, const element *vertices) {
    static const char *const axes[] = {"x", "y", "z"};
    int found[3] = {0, 0, 0};
    reader->mesh.vertex_count = (sn_index)vertices->count;
    for (size_t i = 0; i < vertices->property_count; i++) {
        property *p = &h->properties[vertices->first + i];
        if (p->list) continue;
        for (sn_index c = 0; c < 3; c++) {
            if (!sn_span_is(p->name, axes[c])) continue;
            p->target = COORDINATE;
            p->slot = c;
            found[c]++;
        }
        sn_status status = p->target == COORDINATE ? SN_OK : add_attribute(reader, p);
        if (status != SN_OK) return status;
    }
    reader->mesh.vertex_count = 0;
    if (found[0] == 1 && found[1] == 1 && found[2] == 1) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "the vertices need the properties x, y and z, each once");
}

/* lists: what those of this element are, CORNERS or STRIPS. */
static sn_status plan_faces(sn_reader *reader, header *h, const element *faces, target lists) {
    for (size_t i = 0; i < faces->property_count; i++) {
        property *p = &h->properties[faces->first + i];
        if (!p->list || (!sn_span_is(p->name, "vertex_indices") && !sn_span_is(p->name, "vertex_index"))) continue;
        if (!sn_scalar_is_integer(p->type)) return sn_reader_fail(reader, SN_NONE, "vertex_indices must be whole numbers, such as int");
        p->target = lists;
        return SN_OK;
    }
    return sn_reader_fail(reader, SN_NONE, "the %s need a property list vertex_indices", lists == CORNERS ? "faces" : "tristrips");
}

static int64_t count_of(const header *h, const char *name) {
    const element *e = find_element(h, name);
    return e != NULL ? e->count : 0;
}

static sn_status plan(sn_reader *reader, header *h) {
    const element *vertices = find_element(h, "vertex");
    int64_t faces = count_of(h, "face"), strips = count_of(h, "tristrips");
    if (vertices == NULL) return sn_reader_fail(reader, SN_NONE, "the header declares no element vertex");
    sn_status status = check_counts(reader, h);
    if (status == SN_OK && faces == 0 && strips == 0) {
        return sn_fail_at(reader->error, SN_ERROR_INPUT, reader->blob->name, 0,
                          "has no faces by its header; a surface of triangles or polygons is needed");
    }
    if (status == SN_OK) status = sn_reader_reserve(reader, vertices->count, faces);
    if (status == SN_OK) status = plan_vertices(reader, h, vertices);
    if (status == SN_OK && faces > 0) status = plan_faces(reader, h, find_element(h, "face"), CORNERS);
    if (status == SN_OK && strips > 0) status = plan_faces(reader, h, find_element(h, "tristrips"), STRIPS);
    return status;
}

/* ---- the data ------------------------------------------------------------------------------------------------------- */

/* One value of a row. Text values stand on the row's line. */
static sn_status read_value(sn_reader *reader, const header *h, sn_scalar type, const property *p, double *out) {
    if (h->encoding == SN_ENCODING_ASCII) {
        char found[48];
        if (sn_reader_number(reader, out)) return SN_OK;
        return sn_reader_fail(reader, SN_NONE, "expected a number for %.*s, found %s", SHOWN(p->name), sn_reader_found(reader, found));
    }
    const unsigned char *bytes = sn_reader_take(reader, sn_scalar_size(type));
    if (bytes == NULL) return sn_reader_fail(reader, SN_NONE, "the file ends within its data; it is cut short");
    *out = sn_scalar_decode(bytes, type, h->encoding == SN_ENCODING_BIG);
    return SN_OK;
}

/* A vertex of a face or a strip. -1, also where it has become unsigned, ends a strip; the last one ends with its list. */
static sn_status take_corner(sn_reader *reader, const property *p, double value) {
    bool end = p->target == STRIPS && (value == -1.0 || (p->type == SN_UINT32 && value == 4294967295.0));
    if (end) return sn_reader_add_strip(reader);
    if (!(fabs(value) <= 4294967295.0) || value != floor(value)) {
        return sn_reader_fail(reader, SN_NONE, "a face names vertex %g, which cannot be", value);
    }
    return sn_reader_add_corner(reader, (int64_t)value);
}

static sn_status read_list(sn_reader *reader, const header *h, const property *p) {
    double count = 0.0, value = 0.0;
    sn_status status = read_value(reader, h, p->count_type, p, &count);
    if (status != SN_OK) return status;
    if (!(count >= 0.0 && count <= (double)SN_INDEX_MAX) || count != floor(count)) {
        return sn_reader_fail(reader, SN_NONE, "a list has the impossible length %g", count);
    }
    for (int64_t i = 0; i < (int64_t)count; i++) {
        status = read_value(reader, h, p->type, p, &value);
        if (status == SN_OK && p->target != SKIP) status = take_corner(reader, p, value);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

static sn_status read_row(sn_reader *reader, const header *h, const element *e, sn_index row, double position[3]) {
    for (size_t i = 0; i < e->property_count; i++) {
        const property *p = &h->properties[e->first + i];
        double value = 0.0;
        sn_status status = p->list ? read_list(reader, h, p) : read_value(reader, h, p->type, p, &value);
        if (status != SN_OK) return status;
        if (p->target == COORDINATE) position[p->slot] = value;
        if (p->target == ATTRIBUTE) reader->mesh.attributes[p->slot].values[row] = value;
    }
    return SN_OK;
}

/* In text: to the line of a row. */
static sn_status find_row(sn_reader *reader, const element *e, int64_t row) {
    if (sn_reader_find_line(reader)) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "the file ends before number %lld of %lld of element %.*s", (long long)row, (long long)e->count,
                          SHOWN(e->name));
}

static sn_status end_row(sn_reader *reader, const element *e) {
    char found[48];
    if (!sn_reader_at_line_end(reader)) {
        return sn_reader_fail(reader, SN_NONE, "the row has more values than the header declares for element %.*s: %s", SHOWN(e->name),
                              sn_reader_found(reader, found));
    }
    sn_reader_next_line(reader);
    return SN_OK;
}

static sn_status read_elements(sn_reader *reader, const header *h, const element *e) {
    bool text = h->encoding == SN_ENCODING_ASCII, vertices = sn_span_is(e->name, "vertex"), faces = sn_span_is(e->name, "face");
    bool strips = sn_span_is(e->name, "tristrips");
    if (e->property_count == 0) return SN_OK;
    for (int64_t row = 0; row < e->count; row++) {
        double position[3] = {0, 0, 0};
        sn_status status = text ? find_row(reader, e, row) : SN_OK;
        const char *start = reader->at;
        if (status == SN_OK) status = read_row(reader, h, e, (sn_index)row, position);
        if (status == SN_OK && vertices) {
            const char *next = reader->at;
            reader->at = start; /* the place an error names */
            status = sn_reader_add_vertex(reader, sn_v3(position[0], position[1], position[2]));
            if (status == SN_OK) reader->at = next;
        }
        if (status == SN_OK && faces) status = sn_reader_add_face(reader, SN_NONE);
        if (status == SN_OK && strips && reader->corner_count > 0) status = sn_reader_add_strip(reader);
        if (status == SN_OK && text) status = end_row(reader, e);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

sn_status sn_ply_parse(sn_reader *reader) {
    header *h = SN_NEW(header, 1);
    if (h == NULL) return sn_fail_memory(reader->error, "a PLY header");
    sn_status status = read_header(reader, h);
    if (status == SN_OK) status = plan(reader, h);
    if (status == SN_OK) begin_data(reader, h);
    for (size_t i = 0; status == SN_OK && i < h->element_count; i++) status = read_elements(reader, h, &h->elements[i]);
    if (status == SN_OK) status = sn_reader_expect_end(reader, count_of(h, "face") + count_of(h, "tristrips"), "faces");
    free(h);
    return status;
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

static const char *type_name(sn_scalar type) {
    for (int i = 0; i < TYPE_COUNT; i++) {
        if (scalar_types[i].type == type) return scalar_types[i].name;
    }
    return "double";
}

/* A property of its own for each component, behind x, y and z. */
static bool name_properties(const sn_mesh *mesh, sn_name_list *names) {
    bool good = sn_name_list_add(names, "x", false) && sn_name_list_add(names, "y", false) && sn_name_list_add(names, "z", false);
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        const sn_attribute *attribute = &mesh->attributes[i];
        for (sn_index c = 0; good && c < attribute->components; c++) {
            char *name = NULL;
            int length =
                attribute->components > 1 ? asprintf(&name, "%s_%d", attribute->name, (int)c) : asprintf(&name, "%s", attribute->name);
            good = length >= 0 && sn_name_list_add(names, name, false);
            if (length >= 0) free(name);
        }
    }
    return good;
}

/* What the values of an attribute stand for: "comment attachment 0 ulna". */
static void write_labels(const sn_mesh *mesh, sn_output *output) {
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        const sn_attribute *attribute = &mesh->attributes[i];
        for (sn_index k = 0; k < attribute->label_count; k++) {
            sn_output_print(output, "comment ");
            sn_write_name(output, attribute->name, false);
            sn_output_print(output, " %d ", (int)k);
            sn_write_name(output, attribute->labels[k], true);
            sn_output_print(output, "\n");
        }
    }
}

static void write_header(const sn_mesh *mesh, sn_mesh_encoding encoding, const sn_scalar *types, const sn_name_list *names,
                         sn_output *output) {
    const char *format = encoding == SN_ENCODING_ASCII ? "ascii"
                         : encoding == SN_ENCODING_BIG ? "binary_big_endian"
                                                       : "binary_little_endian";
    sn_output_print(output, "ply\nformat %s 1.0\n", format);
    write_labels(mesh, output);
    sn_output_print(output, "element vertex %d\n", (int)mesh->vertex_count);
    for (size_t i = 0; i < 3; i++) sn_output_print(output, "property double %s\n", names->items[i]);
    size_t column = 3;
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        for (sn_index c = 0; c < mesh->attributes[i].components; c++) {
            sn_output_print(output, "property %s %s\n", type_name(types[i]), names->items[column++]);
        }
    }
    sn_output_print(output, "element face %d\nproperty list uchar int vertex_indices\nend_header\n", (int)mesh->triangle_count);
}

static void write_value(double value, sn_scalar type, sn_mesh_encoding encoding, bool first, sn_output *output) {
    if (encoding == SN_ENCODING_ASCII) {
        sn_write_number(output, first ? '\0' : ' ', value);
        return;
    }
    unsigned char bytes[8];
    sn_scalar_encode(value, type, encoding == SN_ENCODING_BIG, bytes);
    sn_output_write(output, bytes, sn_scalar_size(type), NULL);
}

static void write_vertex(const sn_mesh *mesh, sn_index vertex, sn_mesh_encoding encoding, const sn_scalar *types, sn_output *output) {
    sn_vec3 p = mesh->positions[vertex];
    write_value(p.x, SN_FLOAT64, encoding, true, output);
    write_value(p.y, SN_FLOAT64, encoding, false, output);
    write_value(p.z, SN_FLOAT64, encoding, false, output);
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        const sn_attribute *attribute = &mesh->attributes[i];
        for (sn_index c = 0; c < attribute->components; c++) {
            write_value(attribute->values[vertex * attribute->components + c], types[i], encoding, false, output);
        }
    }
    if (encoding == SN_ENCODING_ASCII) sn_output_write(output, "\n", 1, NULL);
}

static void write_data(const sn_mesh *mesh, sn_mesh_encoding encoding, const sn_scalar *types, sn_output *output) {
    for (sn_index i = 0; i < mesh->vertex_count; i++) write_vertex(mesh, i, encoding, types, output);
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        write_value(3.0, SN_UINT8, encoding, true, output);
        for (int j = 0; j < 3; j++) write_value((double)mesh->triangles[i].v[j], SN_INT32, encoding, false, output);
        if (encoding == SN_ENCODING_ASCII) sn_output_write(output, "\n", 1, NULL);
    }
}

sn_status sn_ply_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output, sn_error *error) {
    sn_name_list names = {0};
    sn_scalar *types = SN_NEW(sn_scalar, mesh->attribute_count);
    bool good = types != NULL && name_properties(mesh, &names);
    for (sn_index i = 0; good && i < mesh->attribute_count; i++) {
        types[i] = sn_scalar_of_attribute(&mesh->attributes[i], mesh->vertex_count);
    }
    if (good) {
        write_header(mesh, encoding, types, &names, output);
        write_data(mesh, encoding, types, output);
    }
    free(types);
    sn_name_list_free(&names);
    return good ? SN_OK : sn_fail_memory(error, "the names of attributes");
}
