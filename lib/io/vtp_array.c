/*
 * vtp_array.c -- the values of one array of a VTK XML file: text, base64, raw bytes, or zlib blocks of either.
 *
 * Format: VTK, "VTK XML Formats", and vtkXMLDataParser. Bytes stand behind their count; packed ones behind the count of blocks, the size of
 * a block, the size of the last one where it is shorter (else 0), and the packed size of each.
 */
#include "vtp_array.h"

#include "codec.h"

#include <stdlib.h>
#include <string.h>

static sn_status fail_short(const sn_vtp_values *values) {
    return sn_reader_fail(values->reader, SN_NONE, "%s are damaged or cut short", values->what);
}

static sn_status check_count(const sn_vtp_values *values, uint64_t most, int64_t least) {
    if (most >= (uint64_t)least) return SN_OK;
    return sn_reader_fail(values->reader, SN_NONE, "%lld numbers of %s are promised, but there is room for %llu", (long long)least,
                          values->what, (unsigned long long)most);
}

/* ---- packed and plain bytes ----------------------------------------------------------------------------------------- */

static bool read_size(sn_byte_source *source, const sn_vtp_layout *layout, uint64_t *out) {
    unsigned char bytes[8];
    size_t size = layout->long_header ? 8 : 4;
    if (!sn_byte_source_read(source, bytes, size)) return false;
    *out = 0;
    for (size_t i = 0; i < size; i++) *out |= (uint64_t)bytes[i] << 8 * (layout->big_endian ? size - 1 - i : i);
    return true;
}

static sn_status open_plain(sn_vtp_values *values, sn_byte_source *source, const sn_vtp_layout *layout, int64_t least) {
    uint64_t size;
    if (!read_size(source, layout, &size) || size > sn_byte_source_left(source)) return fail_short(values);
    values->count = (size_t)size / sn_scalar_size(values->type);
    sn_status status = check_count(values, values->count, least);
    if (status != SN_OK) return status;
    values->bytes = source->at;
    if (!source->base64) return SN_OK;
    values->bytes = values->owned = sn_alloc((size_t)size, 1);
    if (values->owned == NULL) return sn_fail_memory(values->reader->error, values->what);
    return sn_byte_source_read(source, values->owned, (size_t)size) ? SN_OK : fail_short(values);
}

typedef struct block_table {
    uint64_t count, size, last_size; /* last_size: of the last block, also where it is a whole one */
    uint64_t *packed;                /* (count) */
} block_table;

/* Bytes of all blocks; UINT64_MAX where that is out of all bounds. */
static uint64_t total_size(const block_table *table) {
    if (table->count == 0) return 0;
    if (table->size > 0 && table->count - 1 > (UINT64_MAX - table->last_size) / table->size) return UINT64_MAX;
    return (table->count - 1) * table->size + table->last_size;
}

static sn_status read_table(sn_vtp_values *values, sn_byte_source *source, const sn_vtp_layout *layout, block_table *table) {
    bool good = read_size(source, layout, &table->count);
    if (!good) return fail_short(values);
    if (table->count > 0) {
        good = read_size(source, layout, &table->size) && read_size(source, layout, &table->last_size);
        if (good && table->last_size == 0) table->last_size = table->size;
    }
    if (!good || table->count > sn_byte_source_left(source) / (layout->long_header ? 8 : 4)) return fail_short(values);
    table->packed = SN_NEW(uint64_t, table->count);
    if (table->packed == NULL) return sn_fail_memory(values->reader->error, values->what);
    for (uint64_t i = 0; good && i < table->count; i++) good = read_size(source, layout, &table->packed[i]);
    return good ? SN_OK : fail_short(values);
}

/* One block from the source to `out`. */
static sn_status unpack_block(sn_vtp_values *values, sn_byte_source *source, uint64_t packed_size, unsigned char *out, uint64_t size) {
    if (packed_size > sn_byte_source_left(source)) return fail_short(values);
    if (!source->base64) {
        bool good = sn_unpack(source->at, (size_t)packed_size, out, (size_t)size);
        source->at += packed_size;
        return good ? SN_OK : fail_short(values);
    }
    unsigned char *packed = sn_alloc((size_t)packed_size, 1);
    if (packed == NULL) return sn_fail_memory(values->reader->error, values->what);
    bool good = sn_byte_source_read(source, packed, (size_t)packed_size) && sn_unpack(packed, (size_t)packed_size, out, (size_t)size);
    free(packed);
    return good ? SN_OK : fail_short(values);
}

static sn_status unpack_blocks(sn_vtp_values *values, sn_byte_source *source, const block_table *table, int64_t least) {
    enum { MOST_A_VALUE = 12 }; /* bytes that a number can take in the mesh: a corner of a polygon, a triangle */
    uint64_t size = total_size(table);
    size_t width = sn_scalar_size(values->type);
    if (!sn_reader_may_take(values->reader, (double)size + (double)(size / width) * MOST_A_VALUE)) {
        return sn_reader_fail(values->reader, SN_NONE, "%s unpack to more than ten times the file; save it without compression",
                              values->what);
    }
    sn_status status = check_count(values, size / width, least);
    if (status != SN_OK) return status;
    values->count = (size_t)size / width;
    values->bytes = values->owned = sn_alloc((size_t)size, 1);
    if (values->owned == NULL) return sn_fail_memory(values->reader->error, values->what);
    for (uint64_t i = 0; status == SN_OK && i < table->count; i++) {
        uint64_t block = i + 1 < table->count ? table->size : table->last_size;
        status = unpack_block(values, source, table->packed[i], values->owned + i * table->size, block);
    }
    return status;
}

static sn_status open_packed(sn_vtp_values *values, sn_byte_source *source, const sn_vtp_layout *layout, int64_t least) {
    block_table table = {0};
    sn_status status = read_table(values, source, layout, &table);
    if (status == SN_OK) status = unpack_blocks(values, source, &table, least);
    free(table.packed);
    return status;
}

/* ---- the places ----------------------------------------------------------------------------------------------------- */

static sn_status open_binary(sn_vtp_values *values, sn_byte_source *source, const sn_vtp_layout *layout, int64_t least) {
    values->reader->line = 0;
    values->reader->at = (const char *)source->at;
    values->reader->end = (const char *)source->end;
    if (layout->compressor[0] == '\0') return open_plain(values, source, layout, least);
    if (strcmp(layout->compressor, "vtkZLibDataCompressor") == 0) return open_packed(values, source, layout, least);
    return sn_reader_fail(values->reader, SN_NONE, "the file is packed by %s; save it with zlib or without compression",
                          layout->compressor);
}

static sn_status open_appended(sn_vtp_values *values, const sn_vtp_layout *layout, const sn_vtp_array *array, int64_t least) {
    const sn_blob *blob = values->reader->blob;
    if (!layout->has_appended || array->offset < 0 || (uint64_t)array->offset > blob->size - layout->appended_begin) {
        values->reader->line = array->line;
        return sn_reader_fail(values->reader, SN_NONE, "%s lie at offset %lld of the appended data, which is not in the file", values->what,
                              (long long)array->offset);
    }
    const unsigned char *data = (const unsigned char *)blob->data;
    sn_byte_source source = {
        .at = data + layout->appended_begin + array->offset, .end = data + blob->size, .base64 = layout->appended_base64};
    return open_binary(values, &source, layout, least);
}

sn_status sn_vtp_open(sn_reader *reader, const sn_vtp_layout *layout, const sn_vtp_array *array, int64_t least, const char *what,
                      sn_vtp_values *out) {
    *out = (sn_vtp_values){.reader = reader, .what = what, .type = array->type, .big_endian = layout->big_endian};
    const char *data = reader->blob->data;
    reader->at = data + array->begin;
    reader->end = data + array->end;
    reader->line = array->line;
    if (!array->numeric) return sn_reader_fail(reader, SN_NONE, "%s must be numbers such as Float32 or Int32", what);
    if (array->place == SN_VTP_APPENDED) return open_appended(out, layout, array, least);
    if (array->place == SN_VTP_INLINE) {
        sn_byte_source source = {.at = (const unsigned char *)reader->at, .end = (const unsigned char *)reader->end, .base64 = true};
        return open_binary(out, &source, layout, least);
    }
    out->text = true;
    return check_count(out, (uint64_t)(array->end - array->begin + 1) / 2, least);
}

sn_status sn_vtp_next(sn_vtp_values *values, double *out) {
    sn_reader *reader = values->reader;
    if (!values->text) {
        if (values->next == values->count) return fail_short(values);
        *out = sn_scalar_decode(values->bytes + values->next++ * sn_scalar_size(values->type), values->type, values->big_endian);
        return SN_OK;
    }
    char found[48];
    if (!sn_reader_find_line(reader)) return sn_reader_fail(reader, SN_NONE, "%s end too soon; there must be more numbers", values->what);
    values->next++;
    if (sn_reader_number(reader, out)) return SN_OK;
    return sn_reader_fail(reader, SN_NONE, "expected a number of %s, found %s", values->what, sn_reader_found(reader, found));
}

sn_status sn_vtp_expect_end(sn_vtp_values *values) {
    size_t read = values->next, held = values->count;
    if (values->text) {
        sn_reader ahead = *values->reader;
        for (held = read; sn_reader_find_line(&ahead); held++) sn_reader_word(&ahead);
    }
    if (held == read) return SN_OK;
    return sn_reader_fail(values->reader, SN_NONE,
                          "by the piece's counts there are %zu numbers of %s, but the file holds %zu; correct the counts", read,
                          values->what, held);
}

void sn_vtp_close(sn_vtp_values *values) {
    free(values->owned);
    values->owned = NULL;
}
