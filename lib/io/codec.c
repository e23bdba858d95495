/* codec.c -- base64 and zlib for VTK's XML files, gzip for any: the only user of zlib. */
#include "codec.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

static bool is_blank(unsigned char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/* 0..63; 64 for '=', -1 for what is no base64. */
static int value_of(unsigned char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : c == '=' ? 64 : -1;
}

/* The next four characters, to one to three bytes. */
static bool decode_group(sn_byte_source *source) {
    int values[4], count = 0;
    while (count < 4 && source->at < source->end) {
        unsigned char c = *source->at++;
        if (is_blank(c)) continue;
        int value = value_of(c);
        bool pad_before = count > 0 && values[count - 1] == 64;
        if (value < 0 || (value == 64 && count < 2) || (pad_before && value != 64)) return false;
        values[count++] = value;
    }
    if (count < 4) return false;
    source->pending_count = values[2] == 64 ? 1 : values[3] == 64 ? 2 : 3;
    source->pending_first = 0;
    unsigned bits = (unsigned)values[0] << 18 | (unsigned)values[1] << 12 | ((unsigned)values[2] & 63U) << 6 | ((unsigned)values[3] & 63U);
    for (int i = 0; i < 3; i++) source->pending[i] = (unsigned char)(bits >> (16 - 8 * i));
    return true;
}

bool sn_byte_source_read(sn_byte_source *source, void *out, size_t size) {
    unsigned char *bytes = out;
    if (!source->base64) {
        if ((size_t)(source->end - source->at) < size) return false;
        memcpy(bytes, source->at, size);
        source->at += size;
        return true;
    }
    for (size_t i = 0; i < size; i++) {
        if (source->pending_first == source->pending_count && !decode_group(source)) return false;
        bytes[i] = source->pending[source->pending_first++];
    }
    return true;
}

size_t sn_byte_source_left(const sn_byte_source *source) {
    size_t left = (size_t)(source->end - source->at);
    return source->base64 ? left / 4 * 3 + (size_t)(source->pending_count - source->pending_first) : left;
}

bool sn_unpack(const void *packed, size_t packed_size, void *out, size_t size) {
    uLongf got = (uLongf)size;
    if (packed_size > ULONG_MAX || size > ULONG_MAX) return false;
    return uncompress(out, &got, packed, (uLong)packed_size) == Z_OK && got == size;
}

bool sn_gzip_is(const void *data, size_t size) {
    const unsigned char *bytes = data;
    return size >= 18 && bytes[0] == 0x1f && bytes[1] == 0x8b && bytes[2] == Z_DEFLATED;
}

/* Inflate one member after the other up to the end of the file. */
static sn_status inflate_members(z_stream *stream, size_t most, char **out, size_t *size) {
    enum { STEP = 1 << 16 };
    size_t capacity = 0;
    for (;;) {
        if (*size > most) return SN_ERROR_INPUT;
        if (!sn_grow((void **)out, &capacity, *size + STEP + 1, 1)) return SN_ERROR_MEMORY;
        stream->next_out = (Bytef *)*out + *size;
        stream->avail_out = STEP;
        int result = inflate(stream, Z_NO_FLUSH);
        *size += STEP - stream->avail_out;
        if (result == Z_STREAM_END && stream->avail_in == 0) return *size <= most ? SN_OK : SN_ERROR_INPUT;
        if (result == Z_STREAM_END) result = inflateReset(stream);
        if (result != Z_OK) return result == Z_MEM_ERROR ? SN_ERROR_MEMORY : SN_ERROR_INPUT;
    }
}

sn_status sn_gunzip(const void *packed, size_t packed_size, size_t most, char **out, size_t *out_size) {
    enum { GZIP = 16 };
    z_stream stream = {.next_in = (Bytef *)(uintptr_t)packed, .avail_in = (uInt)packed_size};
    *out = NULL;
    *out_size = 0;
    if (packed_size > UINT_MAX) return SN_ERROR_INPUT;
    if (inflateInit2(&stream, MAX_WBITS + GZIP) != Z_OK) return SN_ERROR_MEMORY;
    sn_status status = inflate_members(&stream, most, out, out_size);
    inflateEnd(&stream);
    if (status == SN_OK) {
        (*out)[*out_size] = '\0';
        return SN_OK;
    }
    free(*out);
    *out = NULL;
    return status;
}
