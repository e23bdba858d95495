/* gltf_accessor.c -- the numbers of a glTF file: any type of component, normalized or not, packed, strided or sparse (gltf.h). */
#include "gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bytes.h"

static const char *type_name(int type) {
    static const char *const names[] = {"byte", "unsigned byte", "short", "unsigned short", "no type", "unsigned int", "float"};
    return type >= SN_GLTF_BYTE && type <= SN_GLTF_FLOAT ? names[type - SN_GLTF_BYTE] : names[4];
}

bool sn_gltf_is_index(int type) { return type == SN_GLTF_UNSIGNED_BYTE || type == SN_GLTF_UNSIGNED_SHORT || type == SN_GLTF_UNSIGNED_INT; }

sn_status sn_gltf_refuse_type(const sn_json_value *value, int type, bool normalized, const char *wanted, sn_error *error) {
    return sn_json_complain(value, error, "has %scomponents of type %d (%s); %s", normalized ? "normalized " : "", type, type_name(type),
                            wanted);
}

/* Rows of numbers within a view; checked. */
typedef struct rows {
    const unsigned char *bytes;
    size_t stride, size; /* size: of a component */
    int type, width;
    bool normalized;
} rows;

static size_t component_size(size_t type) {
    if (type == SN_GLTF_BYTE || type == SN_GLTF_UNSIGNED_BYTE) return 1;
    if (type == SN_GLTF_SHORT || type == SN_GLTF_UNSIGNED_SHORT) return 2;
    return type == SN_GLTF_UNSIGNED_INT || type == SN_GLTF_FLOAT ? 4 : 0;
}

static double read_component(const rows *r, const unsigned char *at) {
    double value = 0.0, most = 1.0;
    float real;
    uint32_t bits = r->size == 4 ? sn_get_u32(at) : r->size == 2 ? (uint32_t)at[0] | (uint32_t)at[1] << 8 : at[0];
    switch (r->type) {
    case SN_GLTF_BYTE:
        value = (double)(int8_t)(uint8_t)bits, most = 127.0;
        break;
    case SN_GLTF_UNSIGNED_BYTE:
        value = (double)bits, most = 255.0;
        break;
    case SN_GLTF_SHORT:
        value = (double)(int16_t)(uint16_t)bits, most = 32767.0;
        break;
    case SN_GLTF_UNSIGNED_SHORT:
        value = (double)bits, most = 65535.0;
        break;
    case SN_GLTF_UNSIGNED_INT:
        value = (double)bits, most = 4294967295.0;
        break;
    default:
        memcpy(&real, &bits, sizeof real);
        return (double)real;
    }
    return r->normalized ? fmax(value / most, -1.0) : value;
}

static void read_row(const rows *r, size_t row, double *out) {
    for (int k = 0; k < r->width; k++) out[k] = read_component(r, r->bytes + row * r->stride + (size_t)k * r->size);
}

/* `count` rows at byteOffset of the view that `object` names. */
static sn_status find_rows(sn_gltf *g, const sn_json_value *object, sn_index count, rows *r, sn_error *error) {
    sn_json_value view_value = sn_json_member(object, "bufferView"), offset_value = sn_json_member(object, "byteOffset");
    sn_index views = 0, index = SN_NONE;
    size_t offset = 0, row = r->size * (size_t)r->width;
    sn_gltf_view view = {0};
    sn_status status = sn_json_require(&view_value, "a bufferView", error);
    if (status == SN_OK) status = sn_gltf_count(&g->views, &views, error);
    if (status == SN_OK) status = sn_gltf_get_index(&view_value, views, &index, error);
    if (status == SN_OK) status = sn_gltf_get_whole(&offset_value, 9007199254740992.0, &offset, error);
    if (status == SN_OK) status = sn_gltf_read_view(g, index, &view, error);
    if (status != SN_OK) return status;
    r->stride = view.stride > 0 ? view.stride : row;
    if (r->stride < row) return sn_json_complain(object, error, "rows of %zu bytes are %zu bytes apart", row, r->stride);
    if (count > 0 && (offset > view.size || view.size - offset < row || (view.size - offset - row) / r->stride < (size_t)count - 1))
        return sn_json_complain(object, error, "%d rows of %zu bytes from byte %zu on do not fit into its view of %zu bytes", (int)count,
                                row, offset, view.size);
    r->bytes = view.bytes + offset;
    return SN_OK;
}

static sn_status read_type(const sn_json_value *object, rows *r, sn_error *error) {
    sn_json_value value = sn_json_member(object, "componentType");
    size_t type = 0;
    sn_status status = sn_json_require(&value, "a type of component", error);
    if (status == SN_OK) status = sn_gltf_get_whole(&value, 65535.0, &type, error);
    if (status != SN_OK) return status;
    r->type = (int)type;
    r->size = component_size(type);
    return r->size > 0 ? SN_OK : sn_json_mismatch(&value, error, "a type of component of glTF");
}

static sn_status read_shape(const sn_json_value *object, rows *r, sn_index *count, sn_error *error) {
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", NULL};
    static const int widths[] = {1, 2, 3, 4, 16};
    sn_json_value type = sn_json_member(object, "type"), length = sn_json_member(object, "count");
    sn_json_value normalized = sn_json_member(object, "normalized");
    int which = 0;
    size_t number = 0;
    sn_status status = read_type(object, r, error);
    if (status == SN_OK) status = sn_json_require(&type, "a type", error);
    if (status == SN_OK) status = sn_json_get_choice(&type, types, &which, error);
    if (status == SN_OK) status = sn_json_require(&length, "a count", error);
    if (status == SN_OK) status = sn_gltf_get_whole(&length, SN_INDEX_MAX - 1, &number, error);
    if (status == SN_OK) status = sn_json_get_bool(&normalized, &r->normalized, error);
    if (status == SN_OK && r->normalized && r->size == 4)
        status = sn_json_complain(&normalized, error, "numbers of type %d (%s) cannot be normalized", r->type, type_name(r->type));
    r->width = widths[which];
    *count = (sn_index)number;
    return status;
}

/* Rows that stand in for some of the others. */
static sn_status read_sparse(sn_gltf *g, const sn_json_value *sparse, const rows *like, sn_index count, double *out, sn_error *error) {
    sn_json_value length = sn_json_member(sparse, "count"), where = sn_json_member(sparse, "indices"),
                  what = sn_json_member(sparse, "values");
    rows indices = {.width = 1}, values = *like;
    size_t number = 0;
    sn_status status = sn_json_require(&length, "a count", error);
    if (status == SN_OK) status = sn_gltf_get_whole(&length, (double)count, &number, error);
    if (status == SN_OK) status = read_type(&where, &indices, error);
    if (status == SN_OK && !sn_gltf_is_index(indices.type))
        status = sn_gltf_refuse_type(&where, indices.type, false, "indices are unsigned whole numbers", error);
    if (status == SN_OK) status = find_rows(g, &where, (sn_index)number, &indices, error);
    if (status == SN_OK) status = find_rows(g, &what, (sn_index)number, &values, error);
    for (size_t i = 0; i < number && status == SN_OK; i++) {
        double at;
        read_row(&indices, i, &at);
        if (!(at >= 0.0 && at < (double)count)) return sn_json_complain(&where, error, "names row %.10g of %d", at, (int)count);
        read_row(&values, i, out + (size_t)at * (size_t)like->width);
    }
    return status;
}

/* A file of some hundred bytes must not ask for gigabytes: rows of a view are as many as its bytes, zeros are not. */
static sn_status check_zeros(const sn_gltf *g, const sn_json_value *object, sn_index count, sn_error *error) {
    if ((size_t)count <= 65536 + 16 * g->source->file->size) return SN_OK;
    return sn_json_complain(object, error, "is %d rows of zeros, in a file of %zu bytes", (int)count, g->source->file->size);
}

static sn_status fill(sn_gltf *g, const sn_json_value *object, rows *r, sn_index count, double *out, sn_error *error) {
    sn_json_value view = sn_json_member(object, "bufferView"), sparse = sn_json_member(object, "sparse");
    sn_status status = SN_OK;
    if (sn_json_has(&view))
        for (sn_index i = 0; i < count; i++) read_row(r, (size_t)i, out + (size_t)i * (size_t)r->width);
    if (sn_json_has(&sparse)) status = read_sparse(g, &sparse, r, count, out, error);
    return status;
}

sn_status sn_gltf_read_numbers(sn_gltf *g, sn_index accessor, sn_gltf_numbers *out, sn_error *error) {
    sn_json_value object = sn_json_element(&g->accessors, accessor), view = sn_json_member(&object, "bufferView");
    rows r = {0};
    sn_index count = 0;
    *out = (sn_gltf_numbers){0};
    sn_status status = read_shape(&object, &r, &count, error);
    if (status == SN_OK) status = sn_json_has(&view) ? find_rows(g, &object, count, &r, error) : check_zeros(g, &object, count, error);
    if (status != SN_OK) return status;
    *out = (sn_gltf_numbers){SN_NEW(double, (size_t)count *(size_t)r.width), r.width, count, r.type, r.normalized};
    status = out->values != NULL ? fill(g, &object, &r, count, out->values, error) : sn_fail_memory(error, "the numbers");
    if (status == SN_OK) return SN_OK;
    free(out->values);
    *out = (sn_gltf_numbers){0};
    return status;
}
