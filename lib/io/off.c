/*
 * off.c -- the Object File Format of Geomview: OFF, COFF (vertex colours), NOFF (vertex normals) and CNOFF, as text.
 *
 * Format: Geomview manual, chapter "OFF Files". Normals become the attributes nx, ny, nz; colours of faces are passed over.
 */
#include "mesh_reader.h"

#include <string.h>

typedef struct off_header {
    bool colours, normals;
    int64_t vertices, faces;
} off_header;

/* Behind a prefix letter of the keyword. */
static bool take_letter(sn_span *word, char letter) {
    if (word->length == 0 || *word->text != letter) return false;
    word->text++;
    word->length--;
    return true;
}

static bool read_keyword(sn_span word, off_header *header) {
    if (word.length >= 2 && memcmp(word.text, "ST", 2) == 0) return false;
    header->colours = take_letter(&word, 'C');
    header->normals = take_letter(&word, 'N');
    header->colours = take_letter(&word, 'C') || header->colours;
    return sn_span_is(word, "OFF");
}

/* Any variant, also those that are refused with a clear word: 4OFF, nOFF, STOFF. */
bool sn_off_keyword(sn_span word) {
    if (word.length < 3 || word.length > 8) return false;
    for (size_t i = 0; i + 3 < word.length; i++) {
        if (strchr("STCN4n", word.text[i]) == NULL) return false;
    }
    return memcmp(word.text + word.length - 3, "OFF", 3) == 0;
}

/* Each row of a file takes at least two bytes a number, but for the last of all. */
static sn_status check_counts(sn_reader *reader, const off_header *header) {
    uint64_t left = sn_reader_left(reader) + 1;
    bool possible = header->vertices >= 0 && header->faces >= 0 && (uint64_t)header->vertices <= left / 6 &&
                    (uint64_t)header->faces <= left / 2 && 6 * (uint64_t)header->vertices + 2 * (uint64_t)header->faces <= left;
    if (possible) return SN_OK;
    return sn_reader_fail(reader, SN_NONE,
                          "the header promises %lld vertices and %lld faces, more than the rest of the file (%zu bytes) can hold",
                          (long long)header->vertices, (long long)header->faces, sn_reader_left(reader));
}

static sn_status read_header(sn_reader *reader, off_header *header) {
    const char *start = reader->at;
    if (sn_reader_find_line(reader)) start = reader->at;
    sn_span word = sn_reader_word(reader);
    if (sn_off_keyword(word)) {
        if (!read_keyword(word, header)) {
            return sn_reader_fail(reader, SN_NONE,
                                  "OFF with texture coordinates or other than three dimensions is not read; save it as plain OFF");
        }
    } else {
        reader->at = start; /* the keyword may be left out */
    }
    char found[48];
    if (!sn_reader_find_line(reader) || !sn_reader_integer(reader, &header->vertices) || !sn_reader_integer(reader, &header->faces)) {
        return sn_reader_fail(reader, SN_NONE, "expected the counts of vertices and faces, found %s", sn_reader_found(reader, found));
    }
    sn_reader_next_line(reader); /* the count of edges is not needed */
    return check_counts(reader, header);
}

static sn_status read_normal(sn_reader *reader) {
    for (sn_index i = 0; i < 3; i++) {
        double *values = reader->mesh.attributes[i].values;
        char found[48];
        if (sn_reader_number(reader, &values[reader->mesh.vertex_count - 1])) continue;
        return sn_reader_fail(reader, reader->mesh.vertex_count - 1, "vertex %d needs a normal of three numbers, found %s",
                              (int)reader->mesh.vertex_count - 1, sn_reader_found(reader, found));
    }
    return SN_OK;
}

static sn_status read_colour(sn_reader *reader) {
    double colour[4];
    int count = 0;
    while (count < 4 && sn_reader_number(reader, &colour[count])) count++;
    if (count >= 3) return sn_reader_add_colour(reader, colour, count);
    return sn_reader_fail(reader, reader->mesh.vertex_count - 1, "vertex %d needs a colour of three or four numbers",
                          (int)reader->mesh.vertex_count - 1);
}

static sn_status read_vertex(sn_reader *reader, const off_header *header) {
    if (!sn_reader_find_line(reader)) {
        return sn_reader_fail(reader, SN_NONE, "the file ends before vertex %d of %lld", (int)reader->mesh.vertex_count,
                              (long long)header->vertices);
    }
    sn_vec3 position;
    sn_status status = sn_reader_position(reader, &position);
    if (status == SN_OK) status = sn_reader_add_vertex(reader, position);
    if (status == SN_OK && header->normals) status = read_normal(reader);
    if (status == SN_OK && header->colours) status = read_colour(reader);
    sn_reader_next_line(reader);
    return status;
}

static sn_status read_face(sn_reader *reader, int64_t face, const off_header *header) {
    if (!sn_reader_find_line(reader)) {
        return sn_reader_fail(reader, SN_NONE, "the file ends before face %lld of %lld", (long long)face, (long long)header->faces);
    }
    int64_t count, vertex;
    char found[48];
    if (!sn_reader_integer(reader, &count) || count < 0) {
        return sn_reader_fail(reader, SN_NONE, "face %lld needs a count of corners, found %s", (long long)face,
                              sn_reader_found(reader, found));
    }
    for (int64_t i = 0; i < count; i++) {
        if (!sn_reader_integer(reader, &vertex)) {
            return sn_reader_fail(reader, SN_NONE, "face %lld needs %lld vertices, found %s for number %lld", (long long)face,
                                  (long long)count, sn_reader_found(reader, found), (long long)i + 1);
        }
        sn_status status = sn_reader_add_corner(reader, vertex);
        if (status != SN_OK) return status;
    }
    sn_status status = sn_reader_add_face(reader, SN_NONE);
    sn_reader_next_line(reader);
    return status;
}

/* Attributes are sized by the mesh's count of vertices, which is known from the header. */
static sn_status add_normals(sn_reader *reader, int64_t vertices) {
    static const char *const names[] = {"nx", "ny", "nz"};
    reader->mesh.vertex_count = (sn_index)vertices;
    bool good = true;
    for (int i = 0; good && i < 3; i++) good = sn_mesh_add_attribute(&reader->mesh, names[i], 1) != NULL;
    reader->mesh.vertex_count = 0;
    return good ? SN_OK : sn_fail_memory(reader->error, "vertex normals");
}

sn_status sn_off_parse(sn_reader *reader) {
    off_header header = {0};
    sn_status status = read_header(reader, &header);
    if (status == SN_OK) status = sn_reader_reserve(reader, header.vertices, header.faces);
    if (status == SN_OK && header.normals) status = add_normals(reader, header.vertices);
    for (int64_t i = 0; status == SN_OK && i < header.vertices; i++) status = read_vertex(reader, &header);
    for (int64_t i = 0; status == SN_OK && i < header.faces; i++) status = read_face(reader, i, &header);
    return status == SN_OK ? sn_reader_expect_end(reader, header.faces, "faces") : status;
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

void sn_off_write(const sn_mesh *mesh, sn_output *output) {
    const sn_attribute *colour[3];
    bool coloured = sn_mesh_colours(mesh, colour);
    sn_output_print(output, "%s\n%d %d 0\n", coloured ? "COFF" : "OFF", (int)mesh->vertex_count, (int)mesh->triangle_count);
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_write_vec3(output, '\0', mesh->positions[i]);
        for (int c = 0; coloured && c < 3; c++) sn_write_number(output, ' ', colour[c]->values[i]);
        sn_output_write(output, "\n", 1, NULL);
    }
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        const sn_index *v = mesh->triangles[i].v;
        sn_output_write(output, "3", 1, NULL);
        for (int j = 0; j < 3; j++) sn_write_number(output, ' ', (double)v[j]);
        sn_output_write(output, "\n", 1, NULL);
    }
}
