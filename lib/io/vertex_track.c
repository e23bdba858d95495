/*
 * vertex_track.c -- meshes that a host deforms, as it keeps them: PC2 and MDD point caches, numbered meshes.
 *
 * MDD (LightWave): int32 counts of frames and points; the time of each frame, s; x, y, z of every point, frame by frame. All big-endian,
 * the numbers float32.
 */
#include "bytes.h"
#include "sinew/io.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- all kinds ----------------------------------------------------------------------------------------------------------------- */

static sn_status make_track(sn_index samples, sn_index vertices, sn_vertex_track *out, sn_error *error) {
    *out = (sn_vertex_track){samples, vertices, SN_NEW(double, samples), SN_NEW(float, 3 * (size_t)samples * (size_t)vertices)};
    return out->times != NULL && out->positions != NULL ? SN_OK : sn_fail_memory(error, "the frames of a mesh");
}

static sn_status check_count(const char *path, sn_index found, const sn_track_options *options, sn_error *error) {
    if (found == options->vertex_count) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "has %ld points, but the mesh that it moves has %ld vertices", (long)found,
                      (long)options->vertex_count);
}

/* To metres, z up. */
static sn_status convert(const char *path, const sn_track_options *options, sn_vertex_track *track, sn_error *error) {
    float scale = (float)options->meters_per_unit;
    for (size_t i = 0; i < (size_t)track->sample_count * (size_t)track->vertex_count; i++) {
        float *p = track->positions + 3 * i, y = p[1], z = p[2];
        p[0] *= scale, p[1] = (options->up_y ? -z : y) * scale, p[2] = (options->up_y ? y : z) * scale;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "frame %zu: a coordinate of point %zu is not finite",
                              i / (size_t)track->vertex_count, i % (size_t)track->vertex_count);
    }
    return SN_OK;
}

/* As they are, not as a header promises them: steps may be lost in rounding. */
static sn_status check_times(const char *path, const sn_vertex_track *track, sn_error *error) {
    for (sn_index i = 0; i < track->sample_count; i++)
        if (!isfinite(track->times[i]) || (i > 0 && !(track->times[i] > track->times[i - 1])))
            return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "the time of frame %ld, %g s, is not later than that before it", (long)i,
                              track->times[i]);
    return SN_OK;
}

/* ---- PC2 ----------------------------------------------------------------------------------------------------------------------- */

static sn_status read_pc2(const char *path, const sn_track_options *options, sn_vertex_track *out, sn_error *error) {
    sn_pc2_data data;
    sn_status status = sn_pc2_read(path, &data, error);
    if (status != SN_OK) return status;
    status = check_count(path, data.point_count, options, error);
    if (status == SN_OK && data.sample_count < 1) status = sn_fail_at(error, SN_ERROR_INPUT, path, 0, "has no frames");
    if (status == SN_OK && data.sample_count > 1 && !(data.sample_rate > 0.0 && isfinite(data.start_frame)))
        status = sn_fail_at(error, SN_ERROR_INPUT, path, 0, "byte 20: frames %g apart from frame %g on cannot be", data.sample_rate,
                            data.start_frame);
    if (status == SN_OK && (out->times = SN_NEW(double, data.sample_count)) == NULL) status = sn_fail_memory(error, "a point cache");
    if (status == SN_OK) {
        out->sample_count = data.sample_count;
        out->vertex_count = data.point_count;
        out->positions = data.positions;
        data.positions = NULL;
        for (sn_index i = 0; i < out->sample_count; i++) out->times[i] = (data.start_frame + i * data.sample_rate) / options->rate;
        status = check_times(path, out, error);
    }
    sn_pc2_free(&data);
    return status;
}

/* ---- MDD ----------------------------------------------------------------------------------------------------------------------- */

enum { MDD_HEADER = 8 };

/* No signature tells an MDD; its size does. */
static sn_status check_mdd(const sn_blob *blob, sn_index *frames, sn_index *points, sn_error *error) {
    uint32_t counts[2] = {0, 0};
    for (int i = 0; i < 2 && blob->size >= MDD_HEADER; i++) counts[i] = sn_get_u32_big((const unsigned char *)blob->data + 4 * i);
    *frames = (sn_index)counts[0], *points = (sn_index)counts[1];
    if (counts[0] < 1 || counts[1] < 1 || counts[0] > SN_INDEX_MAX || counts[1] > SN_INDEX_MAX)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is neither a PC2 nor an MDD point cache");
    uint64_t size = MDD_HEADER + (uint64_t)counts[0] * 4 + (uint64_t)counts[0] * counts[1] * 12;
    if (size == blob->size) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                      "is neither a PC2 point cache nor, by its size, an MDD: %lu frames of %lu points would be %llu bytes, it has %zu",
                      (unsigned long)counts[0], (unsigned long)counts[1], (unsigned long long)size, blob->size);
}

static sn_status read_mdd(const sn_blob *blob, const sn_track_options *options, sn_vertex_track *out, sn_error *error) {
    sn_index frames, points;
    sn_status status = check_mdd(blob, &frames, &points, error);
    if (status == SN_OK) status = check_count(blob->name, points, options, error);
    if (status == SN_OK) status = make_track(frames, points, out, error);
    if (status != SN_OK) return status;
    const unsigned char *at = (const unsigned char *)blob->data + MDD_HEADER;
    for (sn_index i = 0; i < frames; i++) out->times[i] = options->rate_told ? i / options->rate : (double)sn_get_f32_big(at + 4 * i);
    at += 4 * (size_t)frames;
    for (size_t i = 0; i < 3 * (size_t)frames * (size_t)points; i++) out->positions[i] = sn_get_f32_big(at + 4 * i);
    return check_times(blob->name, out, error);
}

static sn_status read_cache(const char *path, const sn_track_options *options, sn_vertex_track *out, sn_error *error) {
    sn_blob blob;
    sn_status status = sn_file_check(path, error);
    if (status == SN_OK) status = sn_blob_read_bytes(path, &blob, error);
    if (status != SN_OK) return status;
    bool pc2 = blob.size >= 11 && memcmp(blob.data, "POINTCACHE2", 11) == 0;
    if (!pc2) status = read_mdd(&blob, options, out, error);
    sn_blob_free(&blob);
    return pc2 ? read_pc2(path, options, out, error) : status;
}

/* ---- numbered meshes ----------------------------------------------------------------------------------------------------------- */

/* FOLDER/PREFIX####SUFFIX: the number of '#' does not count. */
typedef struct sequence {
    char *folder; /* with its slash; "" = the working directory */
    char *prefix; /* in the same allocation */
    const char *suffix;
    sn_index count;
    size_t capacity;
    struct numbered {
        long number;
        char *path;
    } * files; /* (count) */
} sequence;

static sn_status split_pattern(const char *pattern, sequence *s, sn_error *error) {
    const char *slash = strrchr(pattern, '/'), *name = slash != NULL ? slash + 1 : pattern;
    const char *hash = strchr(name, '#'), *rest = hash + strspn(hash, "#");
    size_t folder = (size_t)(name - pattern), prefix = (size_t)(hash - name);
    if (strchr(rest, '#') != NULL) return sn_fail_at(error, SN_ERROR_INPUT, pattern, 0, "'#' stands for the frame's number, in one place");
    if ((s->folder = sn_alloc(folder + prefix + 2, 1)) == NULL) return sn_fail_memory(error, "a path");
    memcpy(s->folder, pattern, folder);
    s->prefix = s->folder + folder + 1;
    memcpy(s->prefix, name, prefix);
    s->suffix = rest;
    return SN_OK;
}

/* Is this a file of the sequence, and which? */
static bool number_of(const sequence *s, const char *name, long *number) {
    size_t prefix = strlen(s->prefix), length = strlen(name), suffix = strlen(s->suffix);
    if (length <= prefix + suffix || strncmp(name, s->prefix, prefix) != 0 || strcmp(name + length - suffix, s->suffix) != 0) return false;
    const char *digits = name + prefix + (name[prefix] == '-'), *end = name + length - suffix;
    if (digits >= end || end - digits > 9) return false;
    for (const char *c = digits; c < end; c++)
        if (!isdigit((unsigned char)*c)) return false;
    *number = strtol(name + prefix, NULL, 10);
    return true;
}

static sn_status add_file(sequence *s, const char *name, sn_error *error) {
    long number;
    if (!number_of(s, name, &number)) return SN_OK;
    if (s->count == SN_INDEX_MAX || !sn_grow((void **)&s->files, &s->capacity, (size_t)s->count + 1, sizeof *s->files))
        return sn_fail_memory(error, "the frames of a mesh");
    size_t size = strlen(s->folder) + strlen(name) + 1;
    char *path = sn_alloc(size, 1);
    if (path == NULL) return sn_fail_memory(error, "the frames of a mesh");
    snprintf(path, size, "%s%s", s->folder, name);
    s->files[s->count++] = (struct numbered){number, path};
    return SN_OK;
}

static int compare_numbers(const void *a, const void *b) {
    const struct numbered *p = a, *q = b;
    return p->number != q->number ? (p->number > q->number) - (p->number < q->number) : strcmp(p->path, q->path);
}

static sn_status list_files(const char *pattern, sequence *s, sn_error *error) {
    sn_status status = split_pattern(pattern, s, error);
    if (status != SN_OK) return status;
    DIR *folder = opendir(*s->folder != '\0' ? s->folder : ".");
    if (folder == NULL) return sn_fail_at(error, SN_ERROR_IO, pattern, 0, "its folder cannot be read");
    for (struct dirent *entry; status == SN_OK && (entry = readdir(folder)) != NULL;) status = add_file(s, entry->d_name, error);
    closedir(folder);
    if (status != SN_OK) return status;
    if (s->count == 0) return sn_fail_at(error, SN_ERROR_INPUT, pattern, 0, "there is no file of that name with a number in place of '#'");
    qsort(s->files, (size_t)s->count, sizeof *s->files, compare_numbers);
    for (sn_index i = 1; i < s->count; i++)
        if (s->files[i].number == s->files[i - 1].number)
            return sn_fail_at(error, SN_ERROR_INPUT, s->files[i].path, 0, "has the number of %s", s->files[i - 1].path);
    return SN_OK;
}

static void warn_of_gaps(const char *pattern, const sequence *s) {
    long missing = s->files[s->count - 1].number - s->files[0].number + 1 - s->count;
    if (missing > 0)
        sn_log(SN_LOG_WARNING, "%s: %ld of the frames from %ld to %ld are missing; the mesh goes straight between their neighbours",
               pattern, missing, s->files[0].number, s->files[s->count - 1].number);
}

static sn_status read_file(const char *path, const sn_track_options *options, float *positions, sn_error *error) {
    sn_mesh mesh;
    sn_status status = sn_file_check(path, error);
    if (status == SN_OK) status = sn_mesh_read(path, &mesh, NULL, error);
    if (status != SN_OK) return status;
    status = check_count(path, mesh.vertex_count, options, error);
    for (sn_index v = 0; v < mesh.vertex_count && status == SN_OK; v++, positions += 3) {
        sn_vec3 p = mesh.positions[v];
        positions[0] = (float)p.x, positions[1] = (float)p.y, positions[2] = (float)p.z;
    }
    sn_mesh_free(&mesh);
    return status;
}

static sn_status read_sequence(const char *pattern, const sn_track_options *options, sn_vertex_track *out, sn_error *error) {
    sequence s = {0};
    sn_status status = list_files(pattern, &s, error);
    if (status == SN_OK) warn_of_gaps(pattern, &s);
    if (status == SN_OK) status = make_track(s.count, options->vertex_count, out, error);
    for (sn_index i = 0; i < s.count && status == SN_OK; i++) {
        out->times[i] = (double)s.files[i].number / options->rate;
        status = read_file(s.files[i].path, options, out->positions + 3 * (size_t)i * (size_t)options->vertex_count, error);
    }
    for (sn_index i = 0; i < s.count; i++) free(s.files[i].path);
    free(s.files);
    free(s.folder);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------------------------------------------ */

sn_status sn_vertex_track_read(const char *path, const sn_track_options *options, sn_vertex_track *out, sn_error *error) {
    const char *slash = strrchr(path, '/');
    bool numbered = strchr(slash != NULL ? slash : path, '#') != NULL;
    *out = (sn_vertex_track){0};
    sn_status status = numbered ? read_sequence(path, options, out, error) : read_cache(path, options, out, error);
    if (status == SN_OK) status = convert(path, options, out, error);
    if (status != SN_OK) sn_vertex_track_free(out);
    return status;
}
