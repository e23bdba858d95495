/*
 * frames_vtp.c -- lines that move, for ParaView and VTK: a VTP file (XML PolyData, numbers as appended raw bytes) per frame, and a PVD
 * collection that gives each its time.
 */
#include "collection.h"
#include "scalar.h"

#include <stdlib.h>
#include <string.h>

struct sn_line_frames {
    sn_collection collection;
    sn_index line_count, point_count;
    sn_index *start; /* (line_count + 1) */
    double *rest;    /* (line_count) rest lengths */
    double *stretch; /* (line_count) of the frame at hand */
};

static sn_status allocate(sn_line_frames *frames, const sn_index *start, const double *rest, sn_error *error) {
    size_t lines = (size_t)frames->line_count;
    frames->start = SN_NEW(sn_index, lines + 1);
    frames->rest = SN_NEW(double, lines);
    frames->stretch = SN_NEW(double, lines);
    bool enough = frames->start && frames->rest && frames->stretch;
    if (!enough) return sn_fail_memory(error, "the frames of the fibres");
    memcpy(frames->start, start, (lines + 1) * sizeof *start);
    memcpy(frames->rest, rest, lines * sizeof *rest);
    return SN_OK;
}

sn_status sn_line_frames_create(const char *prefix, sn_index line_count, const sn_index *start, const double *rest_lengths,
                                sn_line_frames **out, sn_error *error) {
    sn_line_frames *frames = *out = SN_NEW(sn_line_frames, 1);
    if (frames == NULL) return sn_fail_memory(error, "the frames of the fibres");
    frames->line_count = line_count;
    frames->point_count = start[line_count];
    sn_status status = allocate(frames, start, rest_lengths, error);
    if (status == SN_OK) status = sn_collection_open(&frames->collection, prefix, error);
    if (status == SN_OK) return SN_OK;
    sn_line_frames_abort(frames);
    *out = NULL;
    return status;
}

/* ---- one frame -------------------------------------------------------------------------------------------------------------- */

static void write_u64(sn_output *output, uint64_t value) {
    unsigned char bytes[8];
    for (int i = 0; i < 8; i++) bytes[i] = (unsigned char)(value >> 8 * i);
    sn_output_write(output, bytes, sizeof bytes, NULL);
}

static void write_f64(sn_output *output, double value) {
    unsigned char bytes[8];
    sn_scalar_encode(value, SN_FLOAT64, false, bytes);
    sn_output_write(output, bytes, sizeof bytes, NULL);
}

/* Name an array of `numbers` 64-bit numbers that follows behind the elements. */
static void name_array(sn_output *output, const char *type, const char *name, int components, size_t numbers, uint64_t *offset) {
    sn_output_print(output, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%llu\"/>\n", type,
                    name, components, (unsigned long long)*offset);
    *offset += 8 + 8 * numbers;
}

static void write_elements(const sn_line_frames *frames, sn_output *output) {
    size_t points = (size_t)frames->point_count, lines = (size_t)frames->line_count;
    uint64_t offset = 0;
    sn_output_print(output, "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
                            "header_type=\"UInt64\">\n<PolyData>\n");
    sn_output_print(output,
                    "<Piece NumberOfPoints=\"%d\" NumberOfVerts=\"0\" NumberOfLines=\"%d\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n",
                    frames->point_count, frames->line_count);
    sn_output_print(output, "<Points>\n");
    name_array(output, "Float64", "Points", 3, 3 * points, &offset);
    sn_output_print(output, "</Points>\n<Lines>\n");
    name_array(output, "Int64", "connectivity", 1, points, &offset);
    name_array(output, "Int64", "offsets", 1, lines, &offset);
    sn_output_print(output, "</Lines>\n<CellData>\n");
    name_array(output, "Float64", "length", 1, lines, &offset);
    name_array(output, "Float64", "stretch", 1, lines, &offset);
    sn_output_print(output, "</CellData>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
}

static void write_numbers(sn_output *output, const double *values, size_t count) {
    write_u64(output, 8 * count);
    for (size_t i = 0; i < count; i++) write_f64(output, values[i]);
}

/* In the order in which write_elements has named them. */
static void write_arrays(const sn_line_frames *frames, const sn_vec3 *points, const double *lengths, sn_output *output) {
    write_u64(output, 24 * (uint64_t)frames->point_count);
    for (sn_index k = 0; k < frames->point_count; k++) {
        write_f64(output, points[k].x);
        write_f64(output, points[k].y);
        write_f64(output, points[k].z);
    }
    write_u64(output, 8 * (uint64_t)frames->point_count);
    for (sn_index k = 0; k < frames->point_count; k++) write_u64(output, (uint64_t)k);
    write_u64(output, 8 * (uint64_t)frames->line_count);
    for (sn_index i = 0; i < frames->line_count; i++) write_u64(output, (uint64_t)frames->start[i + 1]);
    write_numbers(output, lengths, (size_t)frames->line_count);
    for (sn_index i = 0; i < frames->line_count; i++) frames->stretch[i] = lengths[i] / frames->rest[i];
    write_numbers(output, frames->stretch, (size_t)frames->line_count);
    sn_output_print(output, "\n</AppendedData>\n</VTKFile>\n");
}

sn_status sn_line_frames_append(sn_line_frames *frames, sn_index frame, double time, const sn_vec3 *points, const double *lengths,
                                sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(sn_collection_frame(&frames->collection, frame), false, &output, error);
    if (status != SN_OK) return status;
    write_elements(frames, output);
    write_arrays(frames, points, lengths, output);
    status = sn_output_commit(output, error); /* a failed write comes out here */
    return status == SN_OK ? sn_collection_list(&frames->collection, time, error) : status;
}

/* ---- the end ---------------------------------------------------------------------------------------------------------------- */

sn_status sn_line_frames_resume(sn_line_frames *frames, sn_resume *resume, bool *goes_on, sn_error *error) {
    return sn_collection_resume(&frames->collection, resume, goes_on, error);
}

sn_status sn_line_frames_commit(sn_line_frames *frames, sn_error *error) {
    sn_status status = sn_collection_close(&frames->collection, error);
    sn_line_frames_abort(frames);
    return status;
}

void sn_line_frames_abort(sn_line_frames *frames) {
    if (frames == NULL) return;
    sn_collection_drop(&frames->collection);
    free(frames->start);
    free(frames->rest);
    free(frames->stretch);
    free(frames);
}
