/*
 * frames_pc2.c -- PC2 point caches, as Maya, Houdini and Blender read them.
 *
 * 32 bytes of header: "POINTCACHE2\0", version 1, count of points, start frame and sample rate (float32), count of samples; then x, y, z of
 * every point, sample by sample, as float32. All little-endian.
 */
#include "bytes.h"
#include "scalar.h"
#include "sinew/io.h"

#include <stdlib.h>
#include <string.h>

enum { HEADER = 32, SAMPLES_AT = 28 };
static const char signature[12] = "POINTCACHE2";

struct sn_pc2 {
    sn_output *output;
    sn_index point_count, sample_count;
    unsigned char *row; /* one sample's bytes */
    char *path;
    bool warned;
};

sn_status sn_pc2_create(const char *path, sn_index point_count, double start_frame, double sample_rate, sn_pc2 **out, sn_error *error) {
    *out = NULL;
    if (point_count < 1) return sn_fail(error, SN_ERROR_USAGE, "a point cache needs at least one point");
    sn_pc2 *cache = SN_NEW(sn_pc2, 1);
    if (cache == NULL) return sn_fail_memory(error, "a point cache");
    cache->point_count = point_count;
    cache->row = SN_NEW(unsigned char, 12 * (size_t)point_count);
    cache->path = sn_strdup(path);
    sn_status status = cache->row != NULL && cache->path != NULL ? sn_output_open(path, false, &cache->output, error)
                                                                 : sn_fail_memory(error, "a point cache");
    if (status == SN_OK) {
        unsigned char header[HEADER];
        memcpy(header, signature, sizeof signature);
        sn_put_u32(header + 12, 1);
        sn_put_u32(header + 16, (uint32_t)point_count);
        sn_put_f32(header + 20, (float)start_frame);
        sn_put_f32(header + 24, (float)sample_rate);
        sn_put_u32(header + SAMPLES_AT, 0);
        status = sn_output_write(cache->output, header, sizeof header, error);
    }
    if (status != SN_OK) {
        sn_pc2_abort(cache);
        return status;
    }
    *out = cache;
    return SN_OK;
}

sn_status sn_pc2_append(sn_pc2 *cache, const sn_vec3 *positions, sn_error *error) {
    if (cache->sample_count == SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "a point cache cannot count more samples");
    unsigned char *at = cache->row;
    cache->warned = cache->warned || sn_warn_of_rounding(cache->path, cache->point_count, positions);
    for (sn_index i = 0; i < cache->point_count; i++, at += 12) {
        sn_put_f32(at, (float)positions[i].x);
        sn_put_f32(at + 4, (float)positions[i].y);
        sn_put_f32(at + 8, (float)positions[i].z);
    }
    cache->sample_count++;
    return sn_output_write(cache->output, cache->row, 12 * (size_t)cache->point_count, error);
}

sn_status sn_pc2_commit(sn_pc2 *cache, sn_error *error) {
    unsigned char count[4];
    sn_put_u32(count, (uint32_t)cache->sample_count);
    sn_status status = sn_output_patch(cache->output, SAMPLES_AT, count, sizeof count, error);
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
    if (samples > (blob->size - HEADER) / 12 / points) {
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                          "byte 28: the header promises %lu samples of %lu points, more than the file (%zu bytes) holds; it is cut short",
                          (unsigned long)samples, (unsigned long)points, blob->size);
    }
    uint64_t held = (blob->size - HEADER) / 12 / points;
    if (held > samples)
        sn_log(SN_LOG_WARNING, "%s: the header counts %lu samples, but the file has room for %llu; those behind are left out", blob->name,
               (unsigned long)samples, (unsigned long long)held);
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
