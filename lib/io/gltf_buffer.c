/* gltf_buffer.c -- the bytes of a glTF file: buffers inside the JSON, in the GLB or beside the file, and views of them (gltf.h). */
#include "gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a whole number in the JSON: a double counts that far. */
#define MOST_BYTES 9007199254740992.0

static const char *const compressions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

/* ---- data: uris ---------------------------------------------------------------------------------------------------------------------- */

static int hexadecimal(char c) { return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1; }

/* %3D and so on, in place; returns the new length. */
static size_t decode_percent(char *text, size_t length) {
    size_t out = 0;
    for (size_t i = 0; i < length; i++) {
        int high = text[i] == '%' && i + 2 < length ? hexadecimal(text[i + 1]) : -1, low = high >= 0 ? hexadecimal(text[i + 2]) : -1;
        text[out++] = low >= 0 ? (char)(16 * high + low) : text[i];
        if (low >= 0) i += 2;
    }
    return out;
}

static int base64_digit(unsigned char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* In place; false = it is none. */
static bool decode_base64(char *text, size_t *length) {
    size_t out = 0;
    unsigned bits = 0, digits = 0;
    for (size_t i = 0; i < *length && text[i] != '='; i++) {
        if (strchr(" \t\r\n", text[i]) != NULL && text[i] != '\0') continue;
        int digit = base64_digit((unsigned char)text[i]);
        if (digit < 0) return false;
        bits = bits << 6 | (unsigned)digit;
        if (++digits % 4 != 1) text[out++] = (char)(bits >> (6 - 2 * ((digits - 1) % 4)) & 0xff);
    }
    *length = out;
    return digits % 4 != 1;
}

/* The uri becomes the bytes; it is the blob's from then on, also on failure. */
static bool take_data_uri(char *uri, sn_blob *out) {
    char *comma = strchr(uri, ',');
    *out = (sn_blob){.data = uri};
    if (comma == NULL) return false;
    bool base64 = comma - uri >= 7 && memcmp(comma - 7, ";base64", 7) == 0;
    size_t length = decode_percent(comma + 1, strlen(comma + 1));
    if (base64 && !decode_base64(comma + 1, &length)) return false;
    memmove(uri, comma + 1, length);
    uri[length] = '\0';
    out->size = length;
    return true;
}

/* ---- buffers ------------------------------------------------------------------------------------------------------------------------- */

static sn_status read_uri(const sn_gltf *g, sn_index buffer, char *uri, sn_blob *out, sn_error *error) {
    if (strncmp(uri, "data:", 5) == 0) {
        if (take_data_uri(uri, out)) return SN_OK;
        return sn_fail(error, SN_ERROR_INPUT, "cannot be imported as glTF: the data of buffer %d is no base64", (int)buffer);
    }
    bool found = g->source->read_buffer != NULL && g->source->read_buffer(g->source->context, uri, out);
    sn_status status =
        found ? SN_OK
              : sn_fail(error, SN_ERROR_INPUT,
                        "cannot be imported as glTF: its buffer '%.200s' cannot be read; put it beside the file, or export a GLB, "
                        "which has everything inside",
                        uri);
    free(uri);
    return status;
}

static sn_status load_buffer(sn_gltf *g, sn_index buffer, const sn_json_value *object, sn_error *error) {
    sn_json_value value = sn_json_member(object, "uri");
    char *uri = NULL;
    sn_blob *blob = &g->blobs[buffer];
    sn_status status = sn_json_get_text(&value, &uri, error);
    if (status == SN_OK && uri != NULL) {
        status = read_uri(g, buffer, uri, blob, error);
        g->available[buffer] = true;
    } else if (status == SN_OK) {
        *blob = (sn_blob){.size = buffer == 0 ? g->binary_size : 0};
        blob->data = sn_alloc(blob->size + 1, 1);
        g->available[buffer] = blob->data != NULL;
        if (blob->data == NULL) status = sn_fail_memory(error, "a buffer");
        if (blob->data != NULL && blob->size > 0) memcpy(blob->data, g->binary, blob->size);
    }
    if (status != SN_OK && g->available[buffer]) {
        sn_blob_free(blob);
        g->available[buffer] = false;
    }
    return status;
}

static sn_status get_buffer(sn_gltf *g, sn_index buffer, sn_blob *out, sn_error *error) {
    sn_json_value object = sn_json_element(&g->buffers, buffer), length = sn_json_member(&object, "byteLength");
    size_t told = 0;
    sn_status status = sn_json_require(&length, "a number of bytes", error);
    if (status == SN_OK) status = sn_gltf_get_whole(&length, MOST_BYTES, &told, error);
    if (status == SN_OK && !g->available[buffer]) status = load_buffer(g, buffer, &object, error);
    if (status != SN_OK) return status;
    *out = g->blobs[buffer];
    if (told > out->size)
        return sn_fail(error, SN_ERROR_INPUT, "cannot be imported as glTF: buffer %d holds %zu bytes, not the %zu that it is said to have",
                       (int)buffer, out->size, told);
    out->size = told;
    return SN_OK;
}

/* ---- views --------------------------------------------------------------------------------------------------------------------------- */

/* A compressed view names a buffer beside it that holds the same unpacked; that may be a stand-in without bytes. */
static sn_status check_packed(sn_gltf *g, const sn_json_value *view, sn_index buffer, sn_error *error) {
    sn_json_value object = sn_json_element(&g->buffers, buffer), uri = sn_json_member(&object, "uri");
    bool empty = !sn_json_has(&uri) && (buffer > 0 || g->binary_size == 0);
    for (int i = 0; i < 2; i++)
        if (sn_gltf_has_extension(view, compressions[i]) && (empty || sn_gltf_has_extension(&object, compressions[i])))
            return sn_fail(error, SN_ERROR_INPUT,
                           "has its meshes packed by the extension %s, which is not read; export it without compression", compressions[i]);
    return SN_OK;
}

sn_status sn_gltf_read_view(sn_gltf *g, sn_index index, sn_gltf_view *out, sn_error *error) {
    sn_json_value view = sn_json_element(&g->views, index), buffer_value = sn_json_member(&view, "buffer");
    sn_json_value offset_value = sn_json_member(&view, "byteOffset"), length_value = sn_json_member(&view, "byteLength");
    sn_json_value stride = sn_json_member(&view, "byteStride");
    sn_index buffer = SN_NONE;
    size_t offset = 0, length = 0;
    sn_blob blob = {0};
    *out = (sn_gltf_view){0};
    sn_status status = sn_json_require(&buffer_value, "a buffer", error);
    if (status == SN_OK) status = sn_json_require(&length_value, "a number of bytes", error);
    if (status == SN_OK) status = sn_gltf_get_index(&buffer_value, g->buffer_count, &buffer, error);
    if (status == SN_OK) status = sn_gltf_get_whole(&offset_value, MOST_BYTES, &offset, error);
    if (status == SN_OK) status = sn_gltf_get_whole(&length_value, MOST_BYTES, &length, error);
    if (status == SN_OK) status = sn_gltf_get_whole(&stride, 255.0, &out->stride, error);
    if (status == SN_OK) status = check_packed(g, &view, buffer, error);
    if (status == SN_OK) status = get_buffer(g, buffer, &blob, error);
    if (status != SN_OK) return status;
    if (offset > blob.size || length > blob.size - offset)
        return sn_json_complain(&view, error, "reaches to byte %.0f of a buffer of %zu bytes", (double)offset + (double)length, blob.size);
    out->bytes = (const unsigned char *)blob.data + offset;
    out->size = length;
    return SN_OK;
}
