/* scalar.h -- the numbers of binary mesh files: types, sizes, byte orders. */
#ifndef SN_IO_SCALAR_H
#define SN_IO_SCALAR_H

#include "sinew/mesh.h"

typedef enum sn_scalar {
    SN_INT8,
    SN_UINT8,
    SN_INT16,
    SN_UINT16,
    SN_INT32,
    SN_UINT32,
    SN_INT64,
    SN_UINT64,
    SN_FLOAT32,
    SN_FLOAT64
} sn_scalar;

size_t sn_scalar_size(sn_scalar type); /* bytes */
bool sn_scalar_is_integer(sn_scalar type);
/* The number at bytes, in the byte order of the file. 64-bit integers past 2^53 are rounded. */
double sn_scalar_decode(const unsigned char *bytes, sn_scalar type, bool big_endian);
/* Put value, which the type must be able to hold, at bytes; SN_UINT8, SN_INT32, SN_INT64 and SN_FLOAT64 only: what we write. */
void sn_scalar_encode(double value, sn_scalar type, bool big_endian, unsigned char *bytes);
/* The smallest of SN_UINT8, SN_INT32 and SN_FLOAT64 that holds every value of the attribute exactly. */
sn_scalar sn_scalar_of_attribute(const sn_attribute *attribute, sn_index vertex_count);

/* Binary STL, by its size: "solid" at the front proves nothing. Here since whoever reads bytes asks for it. */
bool sn_stl_is_binary(const char *data, size_t size);

/* Warn where single precision, in which `what` is written, moves one of these points by more than a hundred-thousandth of their extent, as
 * it does far from the origin. false: it does not. */
bool sn_warn_of_rounding(const char *what, sn_index count, const sn_vec3 *points);

#endif
