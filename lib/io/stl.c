/*
 * stl.c -- STL, ASCII and binary. Its triangles name no vertices: equal coordinates are welded exactly, in order of first appearance.
 *
 * Format: 3D Systems, StereoLithography Interface Specification (1989). Normals are not read: they follow from the winding.
 */
#include "mesh_reader.h"
#include "scalar.h"

#include <stdlib.h>
#include <string.h>

enum { HEADER = 80, RECORD = 50, START = HEADER + 4 };

/* Numbers of files are little-endian, whatever the machine. */
static uint32_t read_u32(const unsigned char *b) {
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static double read_f32(const unsigned char *bytes) {
    uint32_t bits = read_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* ---- weld ----------------------------------------------------------------------------------------------------------- */

/* Bits to compare coordinates by: adding zero makes -0 equal 0, and bits make equal NaNs equal. */
static void coordinate_bits(sn_vec3 p, uint64_t bits[3]) {
    double coordinates[3] = {p.x + 0.0, p.y + 0.0, p.z + 0.0};
    memcpy(bits, coordinates, sizeof coordinates);
}

static uint64_t hash_position(const void *positions, sn_index i) {
    uint64_t bits[3], hash = 0;
    coordinate_bits(((const sn_vec3 *)positions)[i], bits);
    for (int c = 0; c < 3; c++) {
        hash = (hash ^ bits[c]) * 0x9e3779b97f4a7c15ULL;
        hash ^= hash >> 32;
    }
    return hash;
}

static bool equal_positions(const void *positions, sn_index i, sn_index j) {
    uint64_t a[3], b[3];
    coordinate_bits(((const sn_vec3 *)positions)[i], a);
    coordinate_bits(((const sn_vec3 *)positions)[j], b);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* A corner at position: a vertex that is there already, or a new one. */
static sn_status add_corner(sn_reader *reader, sn_index_table *welded, sn_vec3 position) {
    sn_index vertex = reader->mesh.vertex_count;
    sn_status status = sn_reader_add_vertex(reader, position);
    if (status != SN_OK) return status;
    sn_index first = sn_index_table_intern(welded, vertex, reader->mesh.positions, hash_position, equal_positions);
    if (first == SN_NONE) return sn_fail_memory(reader->error, "a table of vertices");
    if (first != vertex) reader->mesh.vertex_count = vertex;
    return sn_reader_add_corner(reader, first);
}

/* ---- reading -------------------------------------------------------------------------------------------------------- */

static sn_status read_triangle(sn_reader *reader, sn_index_table *welded) {
    const unsigned char *record = (const unsigned char *)reader->at;
    for (size_t corner = 0; corner < 3; corner++) {
        const unsigned char *bytes = record + 12 + 12 * corner;
        sn_vec3 position = sn_v3(read_f32(bytes), read_f32(bytes + 4), read_f32(bytes + 8));
        reader->at = (const char *)bytes; /* the place an error names */
        sn_status status = add_corner(reader, welded, position);
        if (status != SN_OK) return status;
    }
    reader->at = (const char *)record + RECORD;
    return sn_reader_add_face(reader, SN_NONE);
}

/* Behind the triangles that the header counts. */
static sn_status expect_end(sn_reader *reader, uint32_t count) {
    size_t rest = sn_reader_left(reader);
    if (rest < RECORD) return sn_reader_expect_end(reader, count, "triangles");
    if (sn_reader_expect_end(&(sn_reader){.blob = reader->blob, .at = reader->at, .end = reader->end}, count, "triangles") == SN_OK)
        return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "the header counts %lu triangles, but the file has room for %zu%s", (unsigned long)count,
                          count + rest / RECORD, rest % RECORD == 0 ? "; correct the count" : "; are these two files in one?");
}

static sn_status read_binary(sn_reader *reader, sn_index_table *welded) {
    reader->line = 0;
    reader->at = reader->blob->data;
    if (sn_reader_left(reader) < START) {
        return sn_reader_fail(reader, SN_NONE, "the file ends after %zu bytes, within the header of a binary STL file", reader->blob->size);
    }
    reader->at += HEADER;
    uint32_t count = read_u32((const unsigned char *)reader->at);
    uint64_t needed = START + (uint64_t)RECORD * count;
    if (needed > reader->blob->size) {
        return sn_reader_fail(reader, SN_NONE,
                              "the header promises %lu triangles, which take %llu bytes, but the file has %zu; it is cut short",
                              (unsigned long)count, (unsigned long long)needed, reader->blob->size);
    }
    reader->at += 4;
    sn_status status = sn_reader_reserve(reader, (int64_t)(count / 2), count);
    for (uint32_t i = 0; status == SN_OK && i < count; i++) status = read_triangle(reader, welded);
    return status == SN_OK ? expect_end(reader, count) : status;
}

/* Text of STL is a row of words; lines matter to messages only. */
static sn_span next_word(sn_reader *reader) { return sn_reader_find_line(reader) ? sn_reader_word(reader) : (sn_span){reader->end, 0}; }

static sn_status expect(sn_reader *reader, const char *wanted) {
    sn_span word = next_word(reader);
    if (sn_span_is_like(word, wanted)) return SN_OK;
    if (word.length == 0) return sn_reader_fail(reader, SN_NONE, "the file ends where '%s' should stand; it is cut short", wanted);
    char found[48];
    reader->at = word.text;
    return sn_reader_fail(reader, SN_NONE, "expected '%s', found %s", wanted, sn_reader_found(reader, found));
}

/* Behind "facet": its normal is passed over, its loop is a face. */
static sn_status read_facet(sn_reader *reader, sn_index_table *welded) {
    sn_reader_next_line(reader);
    sn_status status = expect(reader, "outer");
    if (status == SN_OK) status = expect(reader, "loop");
    for (int corner = 0; status == SN_OK && corner < 3; corner++) {
        sn_vec3 position;
        status = expect(reader, "vertex");
        if (status == SN_OK) status = sn_reader_position(reader, &position);
        if (status == SN_OK) status = add_corner(reader, welded, position);
    }
    if (status == SN_OK) status = expect(reader, "endloop");
    if (status == SN_OK) status = expect(reader, "endfacet");
    return status == SN_OK ? sn_reader_add_face(reader, SN_NONE) : status;
}

/* Any number of solids, one after the other. */
static sn_status read_text(sn_reader *reader, sn_index_table *welded) {
    bool inside = false;
    for (;;) {
        sn_span word = next_word(reader);
        sn_status status = SN_OK;
        if (word.length == 0 && !inside) return SN_OK;
        if (inside && sn_span_is_like(word, "facet")) {
            status = read_facet(reader, welded);
        } else if (sn_span_is_like(word, inside ? "endsolid" : "solid")) {
            sn_reader_next_line(reader); /* the rest is its name */
            inside = !inside;
        } else {
            reader->at = word.text;
            status = expect(reader, inside ? "facet" : "solid");
        }
        if (status != SN_OK) return status;
    }
}

/* Is this text? A binary file cut short may still begin with "solid". */
static bool is_text(const sn_reader *reader) {
    size_t size = sn_reader_left(reader), looked_at = size < 512 ? size : 512;
    return memchr(reader->at, '\0', looked_at) == NULL;
}

sn_status sn_stl_parse(sn_reader *reader) {
    sn_index_table welded = {0};
    bool binary = sn_stl_is_binary(reader->blob->data, reader->blob->size) || !is_text(reader);
    sn_status status = binary ? read_binary(reader, &welded) : read_text(reader, &welded);
    free(welded.slots);
    return status;
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

static sn_vec3 unit_normal(const sn_mesh *mesh, sn_index triangle) {
    const sn_index *v = mesh->triangles[triangle].v;
    const sn_vec3 *p = mesh->positions;
    return sn_normalize(sn_area_vector(p[v[0]], p[v[1]], p[v[2]]));
}

static unsigned char *put_u32(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; i++) *at++ = (unsigned char)(value >> (8 * i));
    return at;
}

static unsigned char *put_vec3(unsigned char *at, sn_vec3 value) {
    float coordinates[3] = {(float)value.x, (float)value.y, (float)value.z};
    for (int i = 0; i < 3; i++) {
        uint32_t bits;
        memcpy(&bits, &coordinates[i], sizeof bits);
        at = put_u32(at, bits);
    }
    return at;
}

static void write_binary(const sn_mesh *mesh, sn_output *output) {
    unsigned char header[START] = "binary STL";
    put_u32(header + HEADER, (uint32_t)mesh->triangle_count);
    sn_output_write(output, header, sizeof header, NULL);
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        unsigned char record[RECORD] = {0}, *at = put_vec3(record, unit_normal(mesh, i));
        for (int j = 0; j < 3; j++) at = put_vec3(at, mesh->positions[mesh->triangles[i].v[j]]);
        sn_output_write(output, record, sizeof record, NULL);
    }
}

static void write_text(const sn_mesh *mesh, sn_output *output) {
    sn_output_print(output, "solid mesh\n");
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        sn_output_print(output, "facet normal");
        sn_write_vec3(output, ' ', unit_normal(mesh, i));
        sn_output_print(output, "\nouter loop\n");
        for (int j = 0; j < 3; j++) {
            sn_output_print(output, "vertex");
            sn_write_vec3(output, ' ', mesh->positions[mesh->triangles[i].v[j]]);
            sn_output_print(output, "\n");
        }
        sn_output_print(output, "endloop\nendfacet\n");
    }
    sn_output_print(output, "endsolid mesh\n");
}

void sn_stl_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output) {
    if (encoding == SN_ENCODING_ASCII) {
        write_text(mesh, output);
    } else {
        (void)sn_warn_of_rounding("STL", mesh->vertex_count, mesh->positions);
        write_binary(mesh, output);
    }
}
