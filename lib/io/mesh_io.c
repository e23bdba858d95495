/*
 * mesh_io.c -- which format a file has, and what every format's reader and writer ends in.
 */
#include "import.h"
#include "mesh_reader.h"
#include "scalar.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct format_entry {
    sn_mesh_format format;
    const char *name, *extension;
    sn_status (*parse)(sn_reader *reader);
} format_entry;

static const format_entry formats[] = {
    {SN_MESH_OBJ, "OBJ", ".obj", sn_obj_parse}, {SN_MESH_PLY, "PLY", ".ply", sn_ply_parse}, {SN_MESH_STL, "STL", ".stl", sn_stl_parse},
    {SN_MESH_OFF, "OFF", ".off", sn_off_parse}, {SN_MESH_VTK, "VTK", ".vtk", sn_vtk_parse}, {SN_MESH_VTP, "VTP", ".vtp", sn_vtp_parse},
};
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

const char *sn_mesh_format_name(sn_mesh_format format) {
    for (int i = 0; i < FORMAT_COUNT; i++) {
        if (formats[i].format == format) return formats[i].name;
    }
    return "unknown";
}

sn_mesh_format sn_mesh_format_from_name(const char *path) {
    const char *dot = path != NULL ? strrchr(path, '.') : NULL;
    for (int i = 0; dot != NULL && i < FORMAT_COUNT; i++) {
        if (strcasecmp(dot, formats[i].extension) == 0) return formats[i].format;
    }
    return SN_MESH_UNKNOWN;
}

/* ---- detection ------------------------------------------------------------------------------------------------------ */

static bool is_obj_keyword(sn_span word) {
    static const char *const keywords[] = {"v", "vn", "vt", "vp", "f", "fo", "l", "p", "o", "g", "s", "mtllib", "usemtl", "mg"};
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++) {
        if (sn_span_is(word, keywords[i])) return true;
    }
    return false;
}

sn_mesh_format sn_mesh_detect(const sn_blob *blob) {
    if (blob->size == 0) return SN_MESH_UNKNOWN;
    if (sn_vtk_is(blob)) return SN_MESH_VTK;
    if (sn_vtp_is(blob)) return SN_MESH_VTP;
    if (sn_stl_is_binary(blob->data, blob->size)) return SN_MESH_STL;
    sn_reader reader = sn_reader_of(blob, NULL);
    if (sn_reader_find_line(&reader)) {
        sn_span word = sn_reader_word(&reader);
        if (sn_span_is(word, "ply")) return SN_MESH_PLY;
        if (sn_off_keyword(word)) return SN_MESH_OFF;
        if (sn_span_is_like(word, "solid")) return SN_MESH_STL;
        if (is_obj_keyword(word)) return SN_MESH_OBJ;
        if (word.text[0] == '{') return SN_MESH_UNKNOWN;
    }
    return sn_mesh_format_from_name(blob->name);
}

/* ---- reading -------------------------------------------------------------------------------------------------------- */

/* Colours in 0..1 that are whole 255ths, as far as six digits tell, become integers 0..255. */
static bool are_bytes(const double *values, size_t count, double scale) {
    for (size_t i = 0; i < count; i++) {
        double v = values[i] * scale;
        if (!(v >= -1e-3 && v <= 255.001) || fabs(v - nearbyint(v)) > 1e-3) return false;
    }
    return true;
}

/* Make white what has no colour; returns what turns the values into 0..255. */
static double fill_colours(double *values, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = fmax(most, values[i]);
    for (size_t i = 0; i < count; i++) {
        if (isnan(values[i])) values[i] = most > 1.0 ? 255.0 : 1.0;
    }
    return most > 1.0 ? 1.0 : 255.0;
}

static sn_status add_colours(sn_reader *reader) {
    static const char *const names[] = {"red", "green", "blue", "alpha"};
    sn_mesh *mesh = &reader->mesh;
    if (reader->colour_count == 0) return SN_OK;
    size_t vertices = (size_t)mesh->vertex_count;
    sn_status status = sn_reader_add_colour(reader, NULL, 0);
    if (status != SN_OK) return status;
    double scale = fill_colours(reader->colours, 4 * vertices);
    bool bytes = are_bytes(reader->colours, 4 * vertices, scale);
    for (int c = 0; c < (reader->has_alpha ? 4 : 3); c++) {
        sn_attribute *attribute = sn_mesh_add_attribute(mesh, names[c], 1);
        if (attribute == NULL) return sn_fail_memory(reader->error, "vertex colours");
        attribute->integer = bytes;
        for (size_t i = 0; i < vertices; i++) {
            double value = reader->colours[4 * i + (size_t)c];
            attribute->values[i] = bytes ? nearbyint(value * scale) : value;
        }
    }
    return SN_OK;
}

static sn_status check_faces(sn_reader *reader) {
    const sn_mesh *mesh = &reader->mesh;
    const char *name = reader->blob->name;
    if (mesh->triangle_count == 0) {
        return sn_fail_at(reader->error, SN_ERROR_INPUT, name, 0, "has no faces; a surface of triangles or polygons is needed");
    }
    if (reader->highest_corner < mesh->vertex_count) return SN_OK;
    long long corner = (long long)(reader->highest_corner + reader->first_index);
    if (reader->line > 0) {
        return sn_fail_at(reader->error, SN_ERROR_INPUT, name, reader->highest_place,
                          "a face names vertex %lld (counting from %d), but the file has %d vertices", corner, (int)reader->first_index,
                          (int)mesh->vertex_count);
    }
    return sn_fail_at(reader->error, SN_ERROR_INPUT, name, 0, "byte %lld: a face names vertex %lld, but the file has %d vertices",
                      (long long)reader->highest_place, corner, (int)mesh->vertex_count);
}

/* Give back the room that was not used. Where that fails the larger block stays. */
static void shrink(sn_reader *reader) {
    sn_mesh *mesh = &reader->mesh;
    sn_vec3 *positions = sn_realloc(mesh->positions, (size_t)mesh->vertex_count, sizeof *positions);
    if (positions != NULL) mesh->positions = positions;
    sn_triangle *triangles = sn_realloc(mesh->triangles, (size_t)mesh->triangle_count, sizeof *triangles);
    if (triangles != NULL) mesh->triangles = triangles;
}

static sn_status finish(sn_reader *reader) {
    sn_status status = check_faces(reader);
    if (status == SN_OK) {
        shrink(reader); /* before colours take their room */
        status = add_colours(reader);
    }
    if (status != SN_OK) return status;
    sn_reader_cut_polygons(reader);
    if (reader->thin_faces > 0) {
        sn_log(SN_LOG_WARNING, "%s: %lld faces of fewer than three corners were left out", reader->blob->name,
               (long long)reader->thin_faces);
    }
    return SN_OK;
}

static sn_status parse_as(const format_entry *format, const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_error *error) {
    sn_reader reader = sn_reader_of(blob, error);
    reader.allow_nonfinite = allow_nonfinite;
    sn_status status = format->parse(&reader);
    if (status == SN_OK) status = finish(&reader);
    free(reader.polygons);
    free(reader.corners);
    free(reader.colours);
    free(reader.group_table.slots);
    if (status == SN_OK) {
        *out = reader.mesh;
    } else {
        sn_mesh_free(&reader.mesh);
        sn_error_set_file(error, blob->name);
    }
    return status;
}

sn_status sn_mesh_parse(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_error *error) {
    sn_mesh_frame frame;
    return sn_mesh_parse_frame(blob, allow_nonfinite, out, &frame, error);
}

/* A header's comments are at the beginning. */
enum { SPACE_WITHIN = 1024 };

sn_space sn_blob_space(const sn_blob *blob) {
    return sn_space_settle(blob->name, sn_space_find(blob->data, blob->size < SPACE_WITHIN ? blob->size : SPACE_WITHIN));
}

static sn_status import(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    sn_status status = sn_import_parse(blob, allow_nonfinite, out, frame, error);
    frame->space = sn_space_told();
    return status;
}

sn_status sn_mesh_parse_frame(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    *out = (sn_mesh){0};
    *frame = (sn_mesh_frame){0};
    if (blob->size == 0) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is empty; a mesh is needed");
    /* their headers and raw bytes may say anything */
    bool ours = sn_stl_is_binary(blob->data, blob->size) || sn_vtk_is(blob) || sn_vtp_is(blob);
    if (!ours && sn_import_detect(blob) != NULL) return import(blob, allow_nonfinite, out, frame, error);
    sn_mesh_format format = sn_mesh_detect(blob);
    frame->space = sn_blob_space(blob);
    for (int i = 0; i < FORMAT_COUNT; i++) {
        if (formats[i].format == format) return parse_as(&formats[i], blob, allow_nonfinite, out, error);
    }
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                      "is in no known mesh format; OBJ, PLY, STL, OFF, VTK and VTP, glTF, FBX, Collada and 3DS are read");
}

sn_status sn_mesh_read(const char *path, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    *out = (sn_mesh){0};
    sn_mesh_frame own = {0};
    sn_blob blob = {0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status == SN_OK) status = sn_mesh_parse_frame(&blob, false, out, &own, error);
    if (frame != NULL) *frame = own;
    sn_blob_free(&blob);
    return status;
}

void sn_mesh_convert(sn_mesh *mesh, double scale, bool up_y) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 p = mesh->positions[v];
        if (up_y) p = sn_v3(p.x, -p.z, p.y);
        mesh->positions[v] = scale == 1.0 ? p : sn_scale(p, scale);
    }
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

void sn_write_number(sn_output *output, char separator, double value) {
    char text[40];
    int length = 0;
    if (separator != '\0') text[length++] = separator;
    length += sn_format_number(value, text + length);
    sn_output_write(output, text, (size_t)length, NULL);
}

void sn_write_vec3(sn_output *output, char separator, sn_vec3 value) {
    sn_write_number(output, separator, value.x);
    sn_write_number(output, ' ', value.y);
    sn_write_number(output, ' ', value.z);
}

void sn_write_name(sn_output *output, const char *name, bool spaces) {
    if (*name == '\0') sn_output_write(output, "_", 1, NULL);
    for (; *name != '\0'; name++) {
        unsigned char c = (unsigned char)*name;
        char safe = c < ' ' || c == 0x7f || c == '\\' || (c == ' ' && !spaces) ? '_' : (char)c;
        sn_output_write(output, &safe, 1, NULL);
    }
}

bool sn_mesh_colours(const sn_mesh *mesh, const sn_attribute *channels[3]) {
    static const char *const names[] = {"red", "green", "blue"};
    for (int i = 0; i < 3; i++) {
        channels[i] = sn_mesh_attribute(mesh, names[i]);
        if (channels[i] == NULL || channels[i]->components != 1) return false;
    }
    return true;
}

/* Do all coordinates fit what the format can hold? Binary STL has single precision. */
static sn_status check_coordinates(const sn_mesh *mesh, double limit, const char *format, sn_error *error) {
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_vec3 p = mesh->positions[i];
        if (fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) <= limit && sn_finite3(p)) continue;
        sn_fail(error, SN_ERROR_INPUT, "vertex %d (%g %g %g) cannot be written as %s", (int)i, p.x, p.y, p.z, format);
        if (error != NULL) error->element = i;
        return SN_ERROR_INPUT;
    }
    return SN_OK;
}

bool sn_mesh_format_has_attributes(sn_mesh_format format) { return format == SN_MESH_PLY || format == SN_MESH_VTP; }

static bool is_colour(const char *name) { return strcmp(name, "red") == 0 || strcmp(name, "green") == 0 || strcmp(name, "blue") == 0; }

/* One warning for a mesh whose attributes the format cannot hold; OBJ and OFF hold colours. */
static void warn_of_losses(const sn_mesh *mesh, sn_mesh_format format) {
    const sn_attribute *channels[3];
    bool coloured = format != SN_MESH_STL && sn_mesh_colours(mesh, channels);
    const char *first = NULL;
    int lost = 0;
    for (sn_index i = 0; i < mesh->attribute_count && !sn_mesh_format_has_attributes(format); i++) {
        const char *name = mesh->attributes[i].name;
        if (coloured && is_colour(name)) continue;
        if (lost++ == 0) first = name;
    }
    if (lost == 0) return;
    sn_log(SN_LOG_WARNING, "%s cannot hold vertex attributes: '%.64s'%s left out; PLY and VTP hold them", sn_mesh_format_name(format),
           first, lost > 1 ? " and others are" : " is");
}

sn_status sn_mesh_write(const sn_mesh *mesh, sn_mesh_format format, sn_mesh_encoding encoding, sn_output *output, sn_error *error) {
    bool binary = encoding == SN_ENCODING_LITTLE || encoding == SN_ENCODING_BIG;
    if ((binary && (format == SN_MESH_OBJ || format == SN_MESH_OFF)) || (format == SN_MESH_STL && encoding == SN_ENCODING_BIG)) {
        return sn_fail(error, SN_ERROR_USAGE, "%s has no such encoding; PLY and VTP have all of them", sn_mesh_format_name(format));
    }
    double limit = format == SN_MESH_STL && encoding != SN_ENCODING_ASCII ? 3.4028234663852886e38 : 1.7976931348623157e308;
    sn_status status = check_coordinates(mesh, limit, sn_mesh_format_name(format), error);
    if (status != SN_OK) return status;
    warn_of_losses(mesh, format);
    switch (format) {
    case SN_MESH_OBJ:
        sn_obj_write(mesh, output);
        break;
    case SN_MESH_PLY:
        status = sn_ply_write(mesh, encoding, output, error);
        break;
    case SN_MESH_STL:
        sn_stl_write(mesh, encoding, output);
        break;
    case SN_MESH_OFF:
        sn_off_write(mesh, output);
        break;
    case SN_MESH_VTP:
        status = sn_vtp_write(mesh, encoding, output, error);
        break;
    case SN_MESH_VTK:
        return sn_fail(error, SN_ERROR_USAGE,
                       "legacy VTK is read but not written; name an output .vtp, which VTK and ParaView read as well");
    case SN_MESH_UNKNOWN:
        return sn_fail(error, SN_ERROR_USAGE, "the mesh format is not known; name an output .ply, .vtp, .obj, .stl or .off");
    }
    return status == SN_OK ? sn_output_write(output, "", 0, error) : status;
}
