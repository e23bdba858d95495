/* scalar.c -- the numbers of binary mesh files, read and written byte by byte: no alignment and no byte order of the machine matters. */
#include "scalar.h"

#include <math.h>
#include <string.h>

size_t sn_scalar_size(sn_scalar type) {
    static const unsigned char sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[type];
}

bool sn_scalar_is_integer(sn_scalar type) { return type < SN_FLOAT32; }

static double decode_float(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static double decode_double(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

double sn_scalar_decode(const unsigned char *bytes, sn_scalar type, bool big_endian) {
    size_t size = sn_scalar_size(type);
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++) bits |= (uint64_t)bytes[i] << 8 * (big_endian ? size - 1 - i : i);
    switch (type) {
    case SN_INT8:
        return (double)(int8_t)bits;
    case SN_INT16:
        return (double)(int16_t)bits;
    case SN_INT32:
        return (double)(int32_t)bits;
    case SN_INT64:
        return (double)(int64_t)bits;
    case SN_FLOAT32:
        return decode_float((uint32_t)bits);
    case SN_FLOAT64:
        return decode_double(bits);
    default:
        return (double)bits;
    }
}

static uint64_t bits_of(double value, sn_scalar type) {
    uint64_t bits = 0;
    if (type == SN_UINT8) return (uint64_t)(uint8_t)value;
    if (type == SN_INT32) return (uint64_t)(uint32_t)(int32_t)value;
    if (type == SN_INT64) return (uint64_t)(int64_t)value;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

void sn_scalar_encode(double value, sn_scalar type, bool big_endian, unsigned char *bytes) {
    size_t size = sn_scalar_size(type);
    uint64_t bits = bits_of(value, type);
    for (size_t i = 0; i < size; i++) bytes[i] = (unsigned char)(bits >> 8 * (big_endian ? size - 1 - i : i));
}

sn_scalar sn_scalar_of_attribute(const sn_attribute *attribute, sn_index vertex_count) {
    sn_scalar type = attribute->integer ? SN_UINT8 : SN_FLOAT64;
    for (size_t i = 0; i < (size_t)vertex_count * (size_t)attribute->components && type != SN_FLOAT64; i++) {
        double v = attribute->values[i];
        if (!(v >= INT32_MIN && v <= INT32_MAX) || v != floor(v)) {
            type = SN_FLOAT64;
        } else if (v < 0.0 || v > 255.0) {
            type = SN_INT32;
        }
    }
    return type;
}

bool sn_stl_is_binary(const char *data, size_t size) {
    enum { HEADER = 80, START = HEADER + 4, RECORD = 50 };
    return size >= START && START + RECORD * sn_scalar_decode((const unsigned char *)data + HEADER, SN_UINT32, false) == (double)size;
}

/* Of the points' extent. */
static const double MOST_ROUNDING = 1e-5;

static double rounding_of(double x) { return fabs((double)(float)x - x); }

bool sn_warn_of_rounding(const char *what, sn_index count, const sn_vec3 *points) {
    sn_box box = SN_EMPTY_BOX;
    double most = 0.0;
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 p = points[i];
        sn_box_add(&box, p);
        most = fmax(most, fmax(rounding_of(p.x), fmax(rounding_of(p.y), rounding_of(p.z))));
    }
    double extent = sn_norm(sn_sub(box.high, box.low));
    if (!(most > MOST_ROUNDING * extent) || !(extent > 0.0)) return false;
    sn_log(SN_LOG_WARNING,
           "%s: single precision moves points by up to %.2g, %.2g of their extent of %.3g, as they lie far from the origin; bring "
           "them nearer, or write a format of doubles",
           what, most, most / extent, extent);
    return true;
}
