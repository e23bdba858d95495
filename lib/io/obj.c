/*
 * obj.c -- Wavefront OBJ: v, f, g, o and usemtl; what else a file says is passed over.
 *
 * Specification: Alias|Wavefront, Advanced Visualizer manual, appendix B1. Colours behind a vertex (v x y z r g b) are common practice.
 */
#include "mesh_reader.h"

#include <string.h>

typedef struct obj_state {
    sn_index group;
    bool has_groups; /* g or o was seen: materials are no groups then */
} obj_state;

/* v x y z [w] or v x y z r g b. The weight w matters to curves only. */
static sn_status read_vertex(sn_reader *reader) {
    sn_vec3 position;
    sn_status status = sn_reader_position(reader, &position);
    if (status == SN_OK) status = sn_reader_add_vertex(reader, position);
    if (status != SN_OK) return status;
    double extra[3];
    int count = 0;
    while (count < 3 && sn_reader_number(reader, &extra[count])) count++;
    return count == 3 ? sn_reader_add_colour(reader, extra, 3) : SN_OK;
}

/* Behind "/vt", "/vt/vn" or "//vn"; false where something else follows the index. */
static bool skip_references(sn_reader *reader) {
    for (int slashes = 0; !sn_reader_ends_token(reader, reader->at); reader->at++) {
        char c = *reader->at;
        if (c == '/' ? ++slashes > 2 : (slashes == 0 || (c != '-' && (c < '0' || c > '9')))) return false;
    }
    return true;
}

/* One corner: v, v/vt, v//vn or v/vt/vn, from 1, or from -1 backwards. */
static sn_status read_corner(sn_reader *reader) {
    const char *start = reader->at, *next;
    int64_t vertex;
    bool good = sn_scan_integer(reader->at, reader->end, &next, &vertex);
    if (good) reader->at = next;
    if (!good || vertex == 0 || !skip_references(reader)) {
        char found[48];
        reader->at = start;
        return sn_reader_fail(reader, SN_NONE, "a face's corner must be the number of a vertex, from 1 or from -1 backwards, not %s",
                              sn_reader_found(reader, found));
    }
    if (vertex < 0 && -vertex > reader->mesh.vertex_count) {
        return sn_reader_fail(reader, SN_NONE, "a face names vertex %lld, but only %d vertices come before it", (long long)vertex,
                              (int)reader->mesh.vertex_count);
    }
    return sn_reader_add_corner(reader, vertex > 0 ? vertex - 1 : reader->mesh.vertex_count + vertex);
}

static sn_status read_face(sn_reader *reader, sn_index group) {
    while (!sn_reader_at_line_end(reader)) {
        sn_status status = read_corner(reader);
        if (status != SN_OK) return status;
    }
    return sn_reader_add_face(reader, group);
}

static sn_status read_group(sn_reader *reader, obj_state *state, bool is_material) {
    sn_span name = sn_reader_rest(reader);
    if (is_material && state->has_groups) return SN_OK;
    state->has_groups = !is_material;
    if (name.length > 0) return sn_reader_group(reader, name, &state->group);
    state->group = SN_NONE;
    return SN_OK;
}

static sn_status read_statement(sn_reader *reader, obj_state *state) {
    sn_span word = sn_reader_word(reader);
    if (sn_span_is(word, "v")) return read_vertex(reader);
    if (sn_span_is(word, "f") || sn_span_is(word, "fo")) return read_face(reader, state->group);
    if (sn_span_is(word, "g") || sn_span_is(word, "o")) return read_group(reader, state, false);
    if (sn_span_is(word, "usemtl")) return read_group(reader, state, true);
    return SN_OK;
}

sn_status sn_obj_parse(sn_reader *reader) {
    obj_state state = {.group = SN_NONE};
    reader->continues = true;
    reader->first_index = 1;
    do {
        sn_status status = read_statement(reader, &state);
        if (status != SN_OK) return status;
    } while (sn_reader_next_line(reader));
    return SN_OK;
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

static void write_vertices(const sn_mesh *mesh, sn_output *output) {
    const sn_attribute *colour[3];
    bool coloured = sn_mesh_colours(mesh, colour);
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_output_write(output, "v", 1, NULL);
        sn_write_vec3(output, ' ', mesh->positions[i]);
        for (int c = 0; coloured && c < 3; c++) { sn_write_number(output, ' ', colour[c]->values[i] / (colour[c]->integer ? 255.0 : 1.0)); }
        sn_output_write(output, "\n", 1, NULL);
    }
}

static void write_group(const sn_mesh *mesh, sn_index group, sn_output *output) {
    sn_output_write(output, "g", 1, NULL);
    if (group != SN_NONE && mesh->group_names[group] != NULL) {
        sn_output_write(output, " ", 1, NULL);
        sn_write_name(output, mesh->group_names[group], true);
    }
    sn_output_write(output, "\n", 1, NULL);
}

void sn_obj_write(const sn_mesh *mesh, sn_output *output) {
    write_vertices(mesh, output);
    sn_index group = SN_NONE;
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        if (mesh->group_count > 0 && mesh->triangle_group[i] != group) {
            group = mesh->triangle_group[i];
            write_group(mesh, group, output);
        }
        const sn_index *v = mesh->triangles[i].v;
        sn_output_write(output, "f", 1, NULL);
        for (int j = 0; j < 3; j++) sn_write_number(output, ' ', (double)v[j] + 1.0);
        sn_output_write(output, "\n", 1, NULL);
    }
}
