/*
 * wide_log.h -- inside lib/sim: the natural logarithm of the wide type; ours, since the C library's differs between processors.
 */
#ifndef SN_SIM_WIDE_LOG_H
#define SN_SIM_WIDE_LOG_H

#include "wide.h"

/* ln x for x in [1e-300, 1e300] to 4e-16 of its size; ours, as the arc tangent of the hinges is (dihedral.c). x = 2^k m with m in
 * [1/sqrt 2, sqrt 2), ln m = 2 artanh s = 2 (s + s^3/3 + ... + s^21/21), s = (m - 1) / (m + 1), |s| < 0.172. */
SN_INLINE wide wide_log(wide x) {
    const uint64_t ROOT_HALF = 0x3fe6a09e667f3bcd, ONE = 0x3ff0000000000000, EXPONENT = 0xfff0000000000000, TWO_52 = 0x4330000000000000;
    wide_bits power = (wide_bits_of(x) - wide_splat_bits(ROOT_HALF)) & wide_splat_bits(EXPONENT); /* k at its place */
    wide k = wide_of_bits(((power + wide_splat_bits(ONE)) >> 52) | wide_splat_bits(TWO_52)) - wide_splat(0x1p52 + 1023.0);
    wide m = wide_of_bits(wide_bits_of(x) - power), one = wide_splat(1.0);
    wide s = (m - one) / (m + one), z = s * s, sum = wide_splat(1.0 / 21.0);
    _Pragma("GCC unroll 10") for (int i = 19; i > 0; i -= 2) sum = sum * z + wide_splat(1.0 / i);
    return k * wide_splat(0.69314718055994530942) + wide_splat(2.0) * s * sum;
}

#endif
