/*
 * embedding_file.c -- the weights of an embedding kept beside a document, so that they need not be made again.
 *
 * "SINEWEMBEDDING1\n" (16 bytes); the content hash as text, padded with 0 to 72 bytes; count of points and of surface vertices (uint32).
 * Then for each point: count of weights (uint32), 1 if a list of vertices follows or 0 if all vertices are meant in order (uint32), that
 * list (uint32 each), the weights (float64 each). All little-endian.
 */
#include "bytes.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/io.h"

enum { SIGNATURE = 16, HEADER = SIGNATURE + SN_HASH_LENGTH + 8 };
static const char signature[SIGNATURE + 1] = "SINEWEMBEDDING1\n";

/* ---- writing --------------------------------------------------------------------------------------------------------------- */

static sn_status write_row(const sn_embedding_row *row, sn_output *output, sn_error *error) {
    size_t count = (size_t)row->count, list = row->vertices ? 4 * count : 0, size = 8 + list + 8 * count;
    unsigned char *bytes = SN_NEW(unsigned char, size);
    if (!bytes) return sn_fail_memory(error, "writing an embedding");
    sn_put_u32(bytes, (uint32_t)row->count);
    sn_put_u32(bytes + 4, row->vertices != NULL);
    for (size_t i = 0; i < count && row->vertices; i++) sn_put_u32(bytes + 8 + 4 * i, (uint32_t)row->vertices[i]);
    for (size_t i = 0; i < count; i++) sn_put_f64(bytes + 8 + list + 8 * i, row->weights[i]);
    sn_status status = sn_output_write(output, bytes, size, error);
    free(bytes);
    return status;
}

sn_status sn_embedding_save(const sn_embedding *embedding, const char *hash, sn_output *output, sn_error *error) {
    unsigned char header[HEADER] = {0};
    memcpy(header, signature, SIGNATURE);
    strncpy((char *)header + SIGNATURE, hash, SN_HASH_LENGTH - 1);
    sn_put_u32(header + SIGNATURE + SN_HASH_LENGTH, (uint32_t)embedding->point_count);
    sn_put_u32(header + SIGNATURE + SN_HASH_LENGTH + 4, (uint32_t)embedding->vertex_count);
    sn_status status = sn_output_write(output, header, sizeof header, error);
    for (sn_index i = 0; i < embedding->point_count && !status; i++) status = write_row(&embedding->rows[i], output, error);
    return status;
}

/* ---- reading --------------------------------------------------------------------------------------------------------------- */

typedef struct reader {
    const unsigned char *at, *end;
} reader;

static bool read_row(reader *r, sn_index vertex_count, sn_embedding_row *row, sn_error *error) {
    if (r->end - r->at < 8) return false;
    uint32_t count = sn_get_u32(r->at), listed = sn_get_u32(r->at + 4);
    size_t each = listed ? 12 : 8;
    r->at += 8;
    if (listed > 1 || count > (uint32_t)vertex_count || (!listed && count != (uint32_t)vertex_count)) return false;
    if ((size_t)(r->end - r->at) < each * count) return false;
    row->count = (sn_index)count;
    row->weights = SN_NEW(double, count);
    if (listed) row->vertices = SN_NEW(sn_index, count);
    if (!row->weights || (listed && !row->vertices)) return sn_fail_memory(error, "an embedding") == SN_OK;
    for (uint32_t i = 0; i < count && listed; i++, r->at += 4) {
        uint32_t vertex = sn_get_u32(r->at);
        if (vertex >= (uint32_t)vertex_count) return false;
        row->vertices[i] = (sn_index)vertex;
    }
    for (uint32_t i = 0; i < count; i++, r->at += 8) {
        row->weights[i] = sn_get_f64(r->at);
        if (!isfinite(row->weights[i])) return false;
    }
    return true;
}

static bool read_rows(reader *r, sn_embedding *out, sn_error *error) {
    uint32_t points = sn_get_u32(r->at), vertices = sn_get_u32(r->at + 4);
    r->at += 8;
    if (points > SN_INDEX_MAX || vertices > SN_INDEX_MAX || (size_t)points > (size_t)(r->end - r->at) / 8) return false;
    *out = (sn_embedding){.point_count = (sn_index)points, .vertex_count = (sn_index)vertices, .rows = SN_NEW(sn_embedding_row, points)};
    if (!out->rows) return sn_fail_memory(error, "an embedding") == SN_OK;
    for (sn_index i = 0; i < out->point_count; i++)
        if (!read_row(r, out->vertex_count, &out->rows[i], error)) return false;
    return r->at == r->end;
}

sn_status sn_embedding_load(const sn_blob *blob, const char *hash, sn_embedding *out, sn_error *error) {
    *out = (sn_embedding){0};
    const unsigned char *bytes = (const unsigned char *)blob->data;
    if (blob->size < HEADER || memcmp(bytes, signature, SIGNATURE) != 0)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "this is no file of embedding weights");
    if (strncmp(blob->data + SIGNATURE, hash, SN_HASH_LENGTH) != 0)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                          "these weights were made for another surface, other fibres or other options");
    reader r = {bytes + SIGNATURE + SN_HASH_LENGTH, bytes + blob->size};
    sn_error inner = {0};
    if (read_rows(&r, out, &inner)) return SN_OK;
    sn_embedding_free(out);
    if (inner.code == SN_ERROR_MEMORY) return sn_fail_memory(error, "an embedding");
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "the file of embedding weights is damaged; remove it and it is made anew");
}
