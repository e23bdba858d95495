/* bytes.h -- numbers in files, little-endian or big-endian whatever the machine is. Private to lib/io. */
#ifndef SINEW_IO_BYTES_H
#define SINEW_IO_BYTES_H

#include <stdint.h>
#include <string.h>

/* ---- little-endian ------------------------------------------------------------------------------------------------------------- */

static inline void sn_put_u32(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> (8 * i));
}

static inline uint32_t sn_get_u32(const unsigned char *b) {
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static inline void sn_put_f32(unsigned char *at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    sn_put_u32(at, bits);
}

static inline float sn_get_f32(const unsigned char *at) {
    uint32_t bits = sn_get_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void sn_put_f64(unsigned char *at, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    sn_put_u32(at, (uint32_t)bits);
    sn_put_u32(at + 4, (uint32_t)(bits >> 32));
}

static inline double sn_get_f64(const unsigned char *at) {
    uint64_t bits = (uint64_t)sn_get_u32(at) | (uint64_t)sn_get_u32(at + 4) << 32;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ---- big-endian ------------------------------------------------------------------------------------------------------------------ */

static inline uint32_t sn_get_u32_big(const unsigned char *b) {
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | (uint32_t)b[3];
}

static inline float sn_get_f32_big(const unsigned char *at) {
    uint32_t bits = sn_get_u32_big(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
