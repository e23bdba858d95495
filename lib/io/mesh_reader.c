/*
 * mesh_reader.c -- the cursor over a mesh file, and the mesh that grows while it is read.
 */
#include "mesh_reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- places and errors ---------------------------------------------------------------------------------------------- */

sn_status sn_reader_fail(const sn_reader *reader, sn_index element, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (reader->line > 0) {
        sn_fail_at(reader->error, SN_ERROR_INPUT, reader->blob->name, reader->line, "%s", text);
    } else {
        long long offset = (long long)(reader->at - reader->blob->data);
        sn_fail_at(reader->error, SN_ERROR_INPUT, reader->blob->name, 0, "byte %lld: %s", offset, text);
    }
    if (reader->error != NULL) reader->error->element = element;
    return SN_ERROR_INPUT;
}

/* ---- text ----------------------------------------------------------------------------------------------------------- */

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/* Bytes of the line end at `at`: LF, CR LF or CR. */
static size_t line_end_length(const sn_reader *reader, const char *at) {
    return at[0] == '\r' && at + 1 < reader->end && at[1] == '\n' ? 2 : 1;
}

static bool is_joined(const sn_reader *reader) {
    return reader->continues && *reader->at == '\\' && reader->at + 1 < reader->end && is_line_end(reader->at[1]);
}

static void skip_join(sn_reader *reader) {
    reader->at += 1 + line_end_length(reader, reader->at + 1);
    reader->line++;
}

static void skip_blanks(sn_reader *reader) {
    while (reader->at < reader->end) {
        if (is_blank(*reader->at) || (*reader->at == ',' && reader->commas)) {
            reader->at++;
        } else if (is_joined(reader)) {
            skip_join(reader);
        } else {
            return;
        }
    }
}

bool sn_reader_at_line_end(sn_reader *reader) {
    skip_blanks(reader);
    return reader->at == reader->end || is_line_end(*reader->at) || *reader->at == '#';
}

bool sn_reader_next_line(sn_reader *reader) {
    bool comment = false; /* a backslash in a comment joins nothing */
    bool begins = true;   /* a '#' within a token begins no comment */
    while (reader->at < reader->end && !is_line_end(*reader->at)) {
        comment = comment || (begins && *reader->at == '#');
        begins = is_blank(*reader->at);
        if (!comment && is_joined(reader)) {
            skip_join(reader);
        } else {
            reader->at++;
        }
    }
    if (reader->at == reader->end) return false;
    reader->at += line_end_length(reader, reader->at);
    if (reader->line > 0) reader->line++;
    return reader->at < reader->end;
}

bool sn_reader_find_line(sn_reader *reader) {
    while (sn_reader_at_line_end(reader)) {
        if (!sn_reader_next_line(reader)) return false;
    }
    return true;
}

bool sn_reader_ends_token(const sn_reader *reader, const char *at) {
    return at == reader->end || is_blank(*at) || (*at == ',' && reader->commas) || is_line_end(*at) || (*at == '\\' && reader->continues);
}

sn_reader sn_reader_of(const sn_blob *blob, sn_error *error) {
    sn_reader reader = {.blob = blob, .error = error, .at = blob->data, .end = blob->data + blob->size, .line = 1, .highest_corner = -1};
    reader.at += sn_byte_order_mark(blob->data, blob->size);
    return reader;
}

sn_span sn_reader_word(sn_reader *reader) {
    if (sn_reader_at_line_end(reader)) return (sn_span){reader->at, 0};
    const char *start = reader->at;
    while (!sn_reader_ends_token(reader, reader->at)) reader->at++;
    if (reader->at == start) reader->at++; /* a lone backslash */
    return (sn_span){start, (size_t)(reader->at - start)};
}

sn_span sn_reader_rest(sn_reader *reader) {
    skip_blanks(reader);
    const char *start = reader->at;
    while (reader->at < reader->end && !is_line_end(*reader->at)) reader->at++;
    const char *last = reader->at;
    while (last > start && is_blank(last[-1])) last--;
    return (sn_span){start, (size_t)(last - start)};
}

bool sn_span_is(sn_span span, const char *text) { return strlen(text) == span.length && memcmp(span.text, text, span.length) == 0; }

bool sn_span_is_like(sn_span span, const char *text) {
    return strlen(text) == span.length && strncasecmp(text, span.text, span.length) == 0;
}

sn_span sn_span_trim(sn_span span) {
    while (span.length > 0 && sn_is_blank(*span.text)) span = (sn_span){span.text + 1, span.length - 1};
    while (span.length > 0 && sn_is_blank(span.text[span.length - 1])) span.length--;
    return span;
}

sn_status sn_text_complain(sn_error *error, const sn_blob *blob, int64_t line, const char *format, va_list arguments) {
    char text[512];
    vsnprintf(text, sizeof text, format, arguments);
    for (char *c = text; *c != '\0'; c++)
        if ((unsigned char)*c < ' ') *c = ' ';
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, line, "%s", text);
}

const char *sn_reader_found(sn_reader *reader, char *buffer) {
    if (sn_reader_at_line_end(reader)) return "the end of the line";
    const char *at = reader->at;
    size_t length = 0;
    while (length < 40 && !sn_reader_ends_token(reader, at)) {
        char c = *at++;
        buffer[++length] = c >= ' ' && c <= '~' ? c : '?';
    }
    buffer[0] = buffer[length + 1] = '\'';
    buffer[length + 2] = '\0';
    return buffer;
}

bool sn_reader_number(sn_reader *reader, double *out) {
    skip_blanks(reader);
    const char *next;
    if (!sn_scan_number(reader->at, reader->end, &next, out) || !sn_reader_ends_token(reader, next)) return false;
    reader->at = next;
    return true;
}

bool sn_reader_integer(sn_reader *reader, int64_t *out) {
    skip_blanks(reader);
    const char *next;
    if (!sn_scan_integer(reader->at, reader->end, &next, out) || !sn_reader_ends_token(reader, next)) return false;
    reader->at = next;
    return true;
}

sn_status sn_reader_position(sn_reader *reader, sn_vec3 *out) {
    double *coordinate[3] = {&out->x, &out->y, &out->z};
    for (int i = 0; i < 3; i++) {
        char found[48];
        if (sn_reader_number(reader, coordinate[i])) continue;
        sn_index vertex = reader->mesh.vertex_count;
        return sn_reader_fail(reader, vertex, "vertex %d needs a number for %c, not %s", (int)vertex, "xyz"[i],
                              sn_reader_found(reader, found));
    }
    return SN_OK;
}

static size_t bytes_behind(const sn_reader *reader) {
    const char *last = reader->end;
    while (last > reader->at && (last[-1] == '\0' || is_blank(last[-1]) || is_line_end(last[-1]))) last--;
    return (size_t)(last - reader->at);
}

sn_status sn_reader_expect_end(sn_reader *reader, int64_t counted, const char *what) {
    bool text = reader->line > 0;
    int64_t rest = text ? 0 : (int64_t)bytes_behind(reader);
    sn_reader ahead = *reader;
    while (text && sn_reader_find_line(&ahead)) {
        rest++;
        if (!sn_reader_next_line(&ahead)) break;
    }
    if (rest == 0) return SN_OK;
    return sn_reader_fail(
        reader, SN_NONE,
        "the header counts %lld %s, but %lld %s follow; correct the count, or take apart files that stand behind each other",
        (long long)counted, what, (long long)rest, text ? "more lines" : "more bytes");
}

/* ---- equal things --------------------------------------------------------------------------------------------------- */

uint64_t sn_hash_bytes(const void *data, size_t size) {
    const unsigned char *bytes = data;
    uint64_t hash = 0xcbf29ce484222325ULL; /* FNV-1a */
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 0x100000001b3ULL;
    return hash ^ (hash >> 32);
}

static sn_index *find_slot(const sn_index_table *table, sn_index candidate, const void *things, sn_hash_function hash,
                           sn_equal_function equal) {
    size_t at = (size_t)hash(things, candidate) & (table->size - 1);
    while (table->slots[at] != SN_NONE && !equal(things, table->slots[at], candidate)) at = (at + 1) & (table->size - 1);
    return &table->slots[at];
}

static bool grow_table(sn_index_table *table, const void *things, sn_hash_function hash, sn_equal_function equal) {
    sn_index_table larger = {.size = table->size > 0 ? 4 * table->size : 64, .count = table->count};
    larger.slots = SN_NEW(sn_index, larger.size);
    if (larger.slots == NULL) return false;
    for (size_t i = 0; i < larger.size; i++) larger.slots[i] = SN_NONE;
    for (size_t i = 0; i < table->size; i++) {
        if (table->slots[i] != SN_NONE) *find_slot(&larger, table->slots[i], things, hash, equal) = table->slots[i];
    }
    free(table->slots);
    *table = larger;
    return true;
}

sn_index sn_index_table_intern(sn_index_table *table, sn_index candidate, const void *things, sn_hash_function hash,
                               sn_equal_function equal) {
    if (2 * (table->count + 1) > table->size && !grow_table(table, things, hash, equal)) return SN_NONE;
    sn_index *slot = find_slot(table, candidate, things, hash, equal);
    if (*slot == SN_NONE) {
        *slot = candidate;
        table->count++;
    }
    return *slot;
}

/* ---- the mesh ------------------------------------------------------------------------------------------------------- */

/* Indices are 32 bits wide: what is more is refused, not counted on from below zero. */
static sn_status too_many(const sn_reader *reader, const char *what) {
    return sn_reader_fail(reader, SN_NONE, "there are more than the %d %s that can be counted; take the file apart", (int)SN_INDEX_MAX,
                          what);
}

static bool reserve_vertices(sn_reader *reader, size_t count) {
    return count <= SN_INDEX_MAX && sn_grow((void **)&reader->mesh.positions, &reader->vertex_capacity, count, sizeof(sn_vec3));
}

static bool reserve_triangles(sn_reader *reader, size_t count) {
    return count <= SN_INDEX_MAX && sn_grow((void **)&reader->mesh.triangles, &reader->triangle_capacity, count, sizeof(sn_triangle));
}

sn_status sn_reader_reserve(sn_reader *reader, int64_t vertices, int64_t triangles) {
    if (vertices > SN_INDEX_MAX || triangles > SN_INDEX_MAX) {
        return sn_reader_fail(reader, SN_NONE, "%lld vertices and %lld faces are more than the %d that can be counted", (long long)vertices,
                              (long long)triangles, (int)SN_INDEX_MAX);
    }
    if (!reserve_vertices(reader, (size_t)vertices)) return sn_fail_memory(reader->error, "vertices");
    if (!reserve_triangles(reader, (size_t)triangles)) return sn_fail_memory(reader->error, "triangles");
    return SN_OK;
}

sn_status sn_reader_add_vertex(sn_reader *reader, sn_vec3 position) {
    sn_index vertex = reader->mesh.vertex_count;
    if (!reader->allow_nonfinite && !sn_finite3(position)) {
        return sn_reader_fail(reader, vertex,
                              "vertex %d has a coordinate that is not a finite number (%g %g %g); correct it; mesh-clean "
                              "--repair-nonfinite drops such vertices",
                              (int)vertex, position.x, position.y, position.z);
    }
    if (vertex == SN_INDEX_MAX) return too_many(reader, "vertices");
    if ((size_t)vertex >= reader->vertex_capacity && !reserve_vertices(reader, (size_t)vertex + 1)) {
        return sn_fail_memory(reader->error, "vertices");
    }
    reader->mesh.positions[vertex] = position;
    reader->mesh.vertex_count = vertex + 1;
    return SN_OK;
}

/* What has no value of its own is NaN until the end, when it is known whether 1 or 255 is white. */
sn_status sn_reader_add_colour(sn_reader *reader, const double *colour, int count) {
    size_t vertices = (size_t)reader->mesh.vertex_count, known = reader->colour_count;
    if (!sn_grow((void **)&reader->colours, &reader->colour_capacity, 4 * vertices, sizeof(double))) {
        return sn_fail_memory(reader->error, "vertex colours");
    }
    for (size_t i = 4 * known; i < 4 * vertices; i++) reader->colours[i] = NAN;
    for (int i = 0; i < count; i++) reader->colours[4 * (vertices - 1) + (size_t)i] = colour[i];
    reader->has_alpha = reader->has_alpha || count == 4;
    reader->colour_count = vertices;
    return SN_OK;
}

sn_status sn_reader_add_corner(sn_reader *reader, int64_t vertex) {
    if (vertex < 0 || vertex > SN_INDEX_MAX) {
        return sn_reader_fail(reader, SN_NONE, "a face names vertex %lld, which cannot be", (long long)(vertex + reader->first_index));
    }
    if (vertex > reader->highest_corner) {
        reader->highest_corner = vertex;
        reader->highest_place = reader->line > 0 ? reader->line : reader->at - reader->blob->data;
    }
    if (reader->corner_count == reader->corner_capacity &&
        !sn_grow((void **)&reader->corners, &reader->corner_capacity, reader->corner_count + 1, sizeof(sn_index))) {
        return sn_fail_memory(reader->error, "a face");
    }
    reader->corners[reader->corner_count++] = (sn_index)vertex;
    return SN_OK;
}

/* Set the group of the triangles that have none yet, up to the last. */
static bool mark_group(sn_reader *reader, sn_index first, sn_index group) {
    sn_mesh *mesh = &reader->mesh;
    bool begins = mesh->triangle_group == NULL;
    if (!sn_grow((void **)&mesh->triangle_group, &reader->triangle_group_capacity, (size_t)mesh->triangle_count, sizeof(sn_index))) {
        return false;
    }
    for (sn_index i = begins ? 0 : first; i < mesh->triangle_count; i++) mesh->triangle_group[i] = i < first ? SN_NONE : group;
    return true;
}

bool sn_reader_may_take(const sn_reader *reader, double more) {
    enum { ALWAYS = 48 << 20, FACTOR = 10 };
    double taken = (double)reader->blob->size + (double)reader->vertex_capacity * sizeof(sn_vec3) +
                   (double)reader->triangle_capacity * sizeof(sn_triangle);
    for (sn_index i = 0; i < reader->mesh.attribute_count; i++) {
        taken += (double)reader->mesh.attributes[i].components * (double)reader->mesh.vertex_count * sizeof(double);
    }
    return taken + more <= FACTOR * (double)reader->blob->size + ALWAYS;
}

/* Room for `count` triangles, within the file's share of memory: a byte a corner can make a triangle each. */
static sn_status grow_triangles(sn_reader *reader, size_t count) {
    if (count > SN_INDEX_MAX) return too_many(reader, "triangles");
    if (count <= reader->triangle_capacity) return SN_OK;
    double doubled = 2.0 * (double)reader->triangle_capacity;
    double more = fmax((double)count, doubled) - (double)reader->triangle_capacity;
    if (!sn_reader_may_take(reader, more * sizeof(sn_triangle))) {
        return sn_reader_fail(reader, SN_NONE, "the faces so far need more than ten times the memory of the file; it is damaged");
    }
    return reserve_triangles(reader, count) ? SN_OK : sn_fail_memory(reader->error, "triangles");
}

sn_status sn_reader_add_face(sn_reader *reader, sn_index group) {
    sn_mesh *mesh = &reader->mesh;
    size_t corners = reader->corner_count;
    reader->corner_count = 0;
    if (corners < 3) {
        reader->thin_faces++;
        return SN_OK;
    }
    size_t first = (size_t)mesh->triangle_count, count = first + corners - 2;
    sn_status status = grow_triangles(reader, count);
    if (status != SN_OK) return status;
    const sn_index *v = reader->corners;
    for (size_t i = 2; i < corners; i++) mesh->triangles[first + i - 2] = (sn_triangle){{v[0], v[i - 1], v[i]}};
    mesh->triangle_count = (sn_index)count;
    if (mesh->group_count > 0 && !mark_group(reader, (sn_index)first, group)) return sn_fail_memory(reader->error, "triangle groups");
    if (corners == 3) return SN_OK;
    if (!sn_grow((void **)&reader->polygons, &reader->polygon_capacity, reader->polygon_count + 1, sizeof(sn_polygon))) {
        return sn_fail_memory(reader->error, "polygons");
    }
    reader->polygons[reader->polygon_count++] = (sn_polygon){(sn_index)first, (sn_index)corners};
    return SN_OK;
}

sn_status sn_reader_add_strip(sn_reader *reader) {
    sn_mesh *mesh = &reader->mesh;
    size_t corners = reader->corner_count;
    reader->corner_count = 0;
    if (corners < 3) {
        reader->thin_faces++;
        return SN_OK;
    }
    size_t count = (size_t)mesh->triangle_count + corners - 2;
    sn_status status = grow_triangles(reader, count);
    if (status != SN_OK) return status;
    const sn_index *v = reader->corners;
    for (size_t i = 0; i + 2 < corners; i++) {
        size_t turned = i % 2;
        if (v[i] == v[i + 1] || v[i + 1] == v[i + 2] || v[i + 2] == v[i]) continue; /* a seam: strips are sewn together by such */
        mesh->triangles[mesh->triangle_count++] = (sn_triangle){{v[i + turned], v[i + 1 - turned], v[i + 2]}};
    }
    return SN_OK;
}

sn_status sn_reader_add_line(sn_reader *reader) {
    sn_line_set *lines = reader->lines;
    size_t count = reader->corner_count, before = (size_t)lines->corner_count;
    reader->corner_count = 0;
    if (count < 2) {
        lines->thin += lines->thin < SN_INDEX_MAX;
        return SN_OK;
    }
    if (before + count > SN_INDEX_MAX) return too_many(reader, "points of lines");
    if (!sn_grow((void **)&lines->starts, &lines->start_capacity, (size_t)lines->line_count + 2, sizeof(sn_index)) ||
        !sn_grow((void **)&lines->corners, &lines->corner_capacity, before + count, sizeof(sn_index)))
        return sn_fail_memory(reader->error, "the points of the lines");
    memcpy(lines->corners + before, reader->corners, count * sizeof(sn_index));
    lines->starts[lines->line_count++] = (sn_index)before;
    lines->starts[lines->line_count] = lines->corner_count = (sn_index)(before + count);
    return SN_OK;
}

sn_status sn_reader_add_attribute(sn_reader *reader, const char *name, int64_t components, bool integer, sn_attribute **out) {
    *out = NULL;
    bool taken = sn_mesh_attribute(&reader->mesh, name) != NULL;
    if (taken || !sn_reader_may_take(reader, (double)components * (double)reader->mesh.vertex_count * sizeof(double))) {
        sn_log(SN_LOG_WARNING, "%s: the point data '%.64s' are left out: %s", reader->blob->name, name,
               taken ? "others before have the same name" : "they would take more than their share of memory");
        return SN_OK;
    }
    *out = sn_mesh_add_attribute(&reader->mesh, name, (sn_index)components);
    if (*out == NULL) return sn_fail_memory(reader->error, "vertex attributes");
    (*out)->integer = integer;
    return SN_OK;
}

static uint64_t hash_name(const void *names, sn_index i) {
    const char *name = ((char *const *)names)[i];
    return sn_hash_bytes(name, strlen(name));
}

static bool equal_names(const void *names, sn_index i, sn_index j) {
    return strcmp(((char *const *)names)[i], ((char *const *)names)[j]) == 0;
}

sn_status sn_reader_group(sn_reader *reader, sn_span name, sn_index *out) {
    sn_mesh *mesh = &reader->mesh;
    if (mesh->group_count == SN_INDEX_MAX) return too_many(reader, "groups");
    if (!sn_grow((void **)&mesh->group_names, &reader->group_capacity, (size_t)mesh->group_count + 1, sizeof(char *))) {
        return sn_fail_memory(reader->error, "group names");
    }
    char *copy = sn_strndup(name.text, name.length);
    if (copy == NULL) return sn_fail_memory(reader->error, "group names");
    mesh->group_names[mesh->group_count] = copy;
    *out = sn_index_table_intern(&reader->group_table, mesh->group_count, mesh->group_names, hash_name, equal_names);
    if (*out == mesh->group_count) {
        mesh->group_count++;
        return SN_OK;
    }
    free(copy);
    return *out == SN_NONE ? sn_fail_memory(reader->error, "group names") : SN_OK;
}
