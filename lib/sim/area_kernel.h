/*
 * area_kernel.h -- inside lib/sim: the barrier of a triangle's area, several at a time.   numerics.md 9
 */
#ifndef SN_SIM_AREA_KERNEL_H
#define SN_SIM_AREA_KERNEL_H

#include "wide.h"
#include "wide_log.h"

/* Below this share of its rest area a triangle's barrier goes on as a straight line: finite, and continuous with its slope. */
#define BARRIER_LINEAR 1e-3

/* B(J) = -(J - 1)^2 ln J and dB/dJ, over k A0, for J < 1. */
SN_INLINE wide barrier(wide j, wide *slope) {
    wide least = wide_splat(BARRIER_LINEAR), at = wide_select(wide_less(least, j), j, least);
    wide gap = at - wide_splat(1.0), ln = wide_log(at);
    *slope = -(wide_splat(2.0) * gap * ln + gap * gap / at);
    return *slope * (j - at) - gap * gap * ln;
}

#endif
