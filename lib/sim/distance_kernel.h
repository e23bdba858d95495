/*
 * distance_kernel.h -- inside lib/sim: projecting distance rows, several at a time; in double for distance.c, in single for single.c.
 */
#ifndef SN_SIM_DISTANCE_KERNEL_H
#define SN_SIM_DISTANCE_KERNEL_H

#include "rows.h"
#include "wide.h"

/* What the rows of one sweep share. */
typedef struct distance_rows {
    wide_record *points;
    const sn_index *index;         /* (2 x rows) */
    const double *goals;           /* (rows) */
    const double *softness, *gain; /* (rows) nullable */
    double *lambda;                /* (rows) */
    const bool *pairs;             /* (fours of this kind) single precision: it and the next can be projected together */
} distance_rows;

/* Rows r .. r + lanes - 1, which share no point; returns how many of them had no direction. */
SN_INLINE int64_t project_distances(const distance_rows *in, sn_index r, const sn_sweep *sweep, int lanes) {
    const sn_index *index = in->index + 2 * (size_t)r;
    wide_point p0 = wide_gather(in->points, index, 2, lanes), p1 = wide_gather(in->points, index + 1, 2, lanes);
    wide lambda = sweep->first ? wide_splat(0.0) : wide_load(in->lambda + r, lanes), compliance = wide_splat(sweep->compliance);
    if (in->softness != NULL) compliance = compliance * wide_load(in->softness + r, lanes);
    wide_vec3 d = wide_between(p0, p1);
    wide square = wide_dot(d, d), length = wide_sqrt(square);
    wide_mask good = has_directions(square);
    wide change = (wide_load(in->goals + r, lanes) - length - compliance * lambda) / (p0.w + p1.w + compliance);
    if (in->gain != NULL) change = change * wide_load(in->gain + r, lanes);
    change = change * wide_splat(sweep->gain);
    wide step = change / length;
    wide_store(in->lambda + r, wide_select(good, lambda + change, lambda), lanes);
    wide_scatter(in->points, index, 2, wide_move(p0, d, p0.w * step, good), lanes);
    wide_scatter(in->points, index + 1, 2, wide_move(p1, d, -(p1.w * step), good), lanes);
    return wide_count(~good, lanes);
}

SN_WIDE_KERNEL static int64_t sweep_distances(const distance_rows *in, sn_index begin, sn_index batched, sn_index end,
                                              const sn_sweep *sweep) {
    int64_t skipped = 0;
    for (sn_index first = begin; begin < batched;) {
        if (wide_takes(SN_BATCH_SINGLE) && in->pairs[(begin - first) / SN_BATCH]) {
            skipped += project_distances(in, begin, sweep, SN_BATCH_SINGLE);
            begin += SN_BATCH_SINGLE;
        } else {
            skipped += project_distances(in, begin, sweep, WIDE_BATCH);
            begin += WIDE_BATCH;
        }
    }
    for (; begin < end; begin++) skipped += project_distances(in, begin, sweep, 1);
    return skipped;
}

#endif
