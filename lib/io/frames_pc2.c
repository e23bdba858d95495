/*
 * frames_pc2.c -- PC2 point caches, as Maya, Houdini and Blender read them.
 *
 * 32 bytes of header: "POINTCACHE2\0", version 1, count of points, start frame and sample rate (float32), count of samples; then x, y, z of
 * every point, sample by sample, as float32. All little-endian.
 */
#include "bytes.h"
#include "scalar.h"
#include "sinew/io.h"

#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEADER = 32, SAMPLES_AT = 28 };
static const char signature[12] = "POINTCACHE2";

struct sn_pc2 {
    sn_output *output;
    sn_index point_count, sample_count;
    unsigned char *row; /* one sample's bytes */
    char *path;
    bool warned;
    bool uncounted; /* of a cache that is gone on with: the header may still count samples that go with the first write */
};

/* Without its output. */
static sn_status make_cache(const char *path, sn_index point_count, sn_pc2 **out, sn_error *error) {
    sn_pc2 *cache = *out = SN_NEW(sn_pc2, 1);
    if (cache == NULL) return sn_fail_memory(error, "a point cache");
    cache->point_count = point_count;
    cache->row = SN_NEW(unsigned char, 12 * (size_t)point_count);
    cache->path = sn_strdup(path);
    return cache->row != NULL && cache->path != NULL ? SN_OK : sn_fail_memory(error, "a point cache");
}

static sn_status write_header(const sn_pc2 *cache, double start_frame, double sample_rate, sn_error *error) {
    unsigned char header[HEADER];
    memcpy(header, signature, sizeof signature);
    sn_put_u32(header + 12, 1);
    sn_put_u32(header + 16, (uint32_t)cache->point_count);
    sn_put_f32(header + 20, (float)start_frame);
    sn_put_f32(header + 24, (float)sample_rate);
    sn_put_u32(header + SAMPLES_AT, 0);
    return sn_output_write(cache->output, header, sizeof header, error);
}

sn_status sn_pc2_create(const char *path, sn_index point_count, double start_frame, double sample_rate, sn_pc2 **out, sn_error *error) {
    *out = NULL;
    if (point_count < 1) return sn_fail(error, SN_ERROR_USAGE, "a point cache needs at least one point");
    sn_pc2 *cache;
    sn_status status = make_cache(path, point_count, &cache, error);
    if (status == SN_OK) status = sn_output_open(path, false, &cache->output, error);
    if (status == SN_OK) status = write_header(cache, start_frame, sample_rate, error);
    if (status != SN_OK) {
        sn_pc2_abort(cache);
        return status;
    }
    *out = cache;
    return SN_OK;
}

static sn_status check_range(const sn_pc2 *cache, const sn_vec3 *positions, sn_error *error) {
    for (sn_index i = 0; i < cache->point_count; i++) {
        sn_vec3 p = positions[i];
        if (fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) <= (double)FLT_MAX && sn_finite3(p)) continue;
        return sn_fail_at(error, SN_ERROR_INPUT, cache->path, 0, "point %d (%g %g %g) is farther away than the single precision of a point "
                          "cache can tell; write a format of doubles", (int)i, p.x, p.y, p.z);
    }
    return SN_OK;
}

static void fill_row(sn_pc2 *cache, const sn_vec3 *positions) {
    unsigned char *at = cache->row;
    for (sn_index i = 0; i < cache->point_count; i++, at += 12) {
        sn_put_f32(at, (float)positions[i].x);
        sn_put_f32(at + 4, (float)positions[i].y);
        sn_put_f32(at + 8, (float)positions[i].z);
    }
}

static sn_status write_count(sn_pc2 *cache, sn_error *error) {
    unsigned char count[4];
    sn_put_u32(count, (uint32_t)cache->sample_count);
    return sn_output_patch(cache->output, SAMPLES_AT, count, sizeof count, error);
}

sn_status sn_pc2_append(sn_pc2 *cache, const sn_vec3 *positions, sn_error *error) {
    if (cache->sample_count == SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "a point cache cannot count more samples");
    sn_status status = check_range(cache, positions, error);
    if (status != SN_OK) return status;
    cache->warned = cache->warned || sn_warn_of_rounding(cache->path, cache->point_count, positions);
    fill_row(cache, positions);
    if (cache->uncounted && write_count(cache, error) != SN_OK) return SN_ERROR_IO;
    cache->uncounted = false;
    cache->sample_count++;
    return sn_output_write(cache->output, cache->row, 12 * (size_t)cache->point_count, error);
}

sn_status sn_pc2_publish(sn_pc2 *cache, sn_error *error) {
    sn_status status = sn_output_publish(cache->output, NULL, error); /* first the sample, then the count */
    return status == SN_OK ? write_count(cache, error) : status;
}

sn_status sn_pc2_commit(sn_pc2 *cache, sn_error *error) {
    sn_status status = write_count(cache, error);
    if (status == SN_OK) {
        status = sn_output_commit(cache->output, error);
        cache->output = NULL;
    }
    sn_pc2_abort(cache);
    return status;
}

void sn_pc2_abort(sn_pc2 *cache) {
    if (cache == NULL) return;
    sn_output_abort(cache->output);
    free(cache->row);
    free(cache->path);
    free(cache);
}

/* ---- reading -------------------------------------------------------------------------------------------------------- */

/* A file that does not end where its header says; ragged: in the middle of a sample. */
static void warn_of_count(const sn_blob *blob, uint32_t samples, uint64_t held, bool ragged) {
    if (held > samples)
        sn_log(SN_LOG_WARNING, "%s: the header counts %lu samples, but the file has room for %llu; those behind are left out", blob->name,
               (unsigned long)samples, (unsigned long long)held);
    else if (held < samples)
        sn_log(SN_LOG_WARNING, "%s: the header counts %lu samples, but the file is cut short: the %llu that are whole are taken",
               blob->name, (unsigned long)samples, (unsigned long long)held);
    else if (ragged)
        sn_log(SN_LOG_WARNING, "%s: the file ends in the middle of a sample behind the %lu that are whole; it is left out", blob->name,
               (unsigned long)samples);
}

static sn_status read_header(const sn_blob *blob, sn_pc2_data *out, sn_error *error) {
    const unsigned char *bytes = (const unsigned char *)blob->data;
    if (blob->size < HEADER || memcmp(bytes, signature, sizeof signature) != 0) {
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is not a PC2 point cache");
    }
    uint32_t version = sn_get_u32(bytes + 12), points = sn_get_u32(bytes + 16), samples = sn_get_u32(bytes + SAMPLES_AT);
    if (version != 1) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "byte 12: version %lu is not known", (unsigned long)version);
    if (points > SN_INDEX_MAX || samples > SN_INDEX_MAX || points == 0) {
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "byte 16: %lu points and %lu samples cannot be", (unsigned long)points,
                          (unsigned long)samples);
    }
    uint64_t held = (blob->size - HEADER) / 12 / points;
    if (held < 1 && samples > 0)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                          "byte 28: the header promises %lu samples of %lu points, and the file (%zu bytes) holds none; it is cut short",
                          (unsigned long)samples, (unsigned long)points, blob->size);
    warn_of_count(blob, samples, held, (blob->size - HEADER) % (12 * (uint64_t)points) != 0);
    if (samples > held) samples = (uint32_t)held;
    out->point_count = (sn_index)points;
    out->sample_count = (sn_index)samples;
    out->start_frame = (double)sn_get_f32(bytes + 20);
    out->sample_rate = (double)sn_get_f32(bytes + 24);
    return SN_OK;
}

static sn_status read_samples(const sn_blob *blob, sn_pc2_data *out, sn_error *error) {
    size_t count = 3 * (size_t)out->point_count * (size_t)out->sample_count;
    out->positions = SN_NEW(float, count);
    if (out->positions == NULL) return sn_fail_memory(error, "a point cache");
    const unsigned char *bytes = (const unsigned char *)blob->data + HEADER;
    for (size_t i = 0; i < count; i++) out->positions[i] = sn_get_f32(bytes + 4 * i);
    return SN_OK;
}

sn_status sn_pc2_read(const char *path, sn_pc2_data *out, sn_error *error) {
    *out = (sn_pc2_data){0};
    sn_blob blob;
    sn_status status = sn_blob_read_bytes(path, &blob, error);
    if (status != SN_OK) return status;
    status = read_header(&blob, out, error);
    if (status == SN_OK) status = read_samples(&blob, out, error);
    if (status != SN_OK) sn_pc2_free(out);
    sn_blob_free(&blob);
    return status;
}

void sn_pc2_free(sn_pc2_data *data) {
    free(data->positions);
    *data = (sn_pc2_data){0};
}

/* ---- going on with one ------------------------------------------------------------------------------------------------ */

/* The header, by the size of the file; the samples are not read. */
static sn_status look_at(char *path, int fd, sn_pc2_data *out, sn_error *error) {
    struct stat info;
    char header[HEADER];
    if (fstat(fd, &info) != 0 || pread(fd, header, HEADER, 0) != HEADER)
        return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "is not a PC2 point cache");
    sn_blob blob = {.name = path, .data = header, .size = (size_t)info.st_size};
    return read_header(&blob, out, error);
}

/* Is the sample of the state's frame the one in the cache's row? */
static bool has_row(const sn_pc2 *cache, int fd, sn_index sample) {
    size_t size = 12 * (size_t)cache->point_count;
    unsigned char *there = sn_alloc(size, 1);
    off_t at = HEADER + (off_t)sample * (off_t)size;
    bool same = there != NULL && pread(fd, there, size, at) == (ssize_t)size && memcmp(there, cache->row, size) == 0;
    free(there);
    return same;
}

static sn_status check_cache(const sn_pc2 *cache, int fd, sn_resume *resume, sn_index *keep, sn_error *error) {
    sn_pc2_data data = {0};
    bool goes_on;
    sn_status status = look_at(cache->path, fd, &data, error);
    if (status != SN_OK) return status;
    if (data.point_count != cache->point_count)
        return sn_fail_at(error, SN_ERROR_USAGE, cache->path, 0,
                          "has %ld points, and the run has %ld: it is of another; name another file or folder", (long)data.point_count,
                          (long)cache->point_count);
    if (data.sample_rate != 1.0 || !(fabs(data.start_frame) <= SN_INDEX_MAX) || data.start_frame != floor(data.start_frame))
        return sn_fail_at(error, SN_ERROR_USAGE, cache->path, 0, "has frames %g apart from frame %g on: no run has written it",
                          data.sample_rate, data.start_frame);
    int64_t first = (int64_t)data.start_frame;
    status = sn_resume_take(resume, cache->path, first, first + data.sample_count - 1, &goes_on, error);
    *keep = status == SN_OK && goes_on ? (sn_index)(resume->next - first) : 0;
    if (*keep == 0 || has_row(cache, fd, (sn_index)(resume->frame - first))) return status;
    return sn_resume_differs(resume, cache->path, error);
}

sn_status sn_pc2_resume(const char *path, sn_index point_count, sn_resume *resume, const sn_vec3 *positions, sn_pc2 **out,
                        sn_error *error) {
    *out = NULL;
    if (!sn_resume_exists(path)) return SN_OK;
    sn_pc2 *cache;
    sn_status status = make_cache(path, point_count, &cache, error);
    int fd = status == SN_OK ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (status == SN_OK && fd < 0) status = sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be opened: %s", strerror(errno));
    if (status == SN_OK) {
        fill_row(cache, positions);
        status = check_cache(cache, fd, resume, &cache->sample_count, error);
    }
    if (fd >= 0) close(fd);
    uint64_t keep = HEADER + 12 * (uint64_t)point_count * (uint64_t)(cache != NULL ? cache->sample_count : 0);
    if (status == SN_OK && cache->sample_count > 0) status = sn_output_open_behind(path, keep, false, &cache->output, error);
    if (status == SN_OK && cache->sample_count > 0) {
        cache->uncounted = true;
        *out = cache;
        return SN_OK;
    }
    sn_pc2_abort(cache);
    return status;
}
