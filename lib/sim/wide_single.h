/*
 * wide_single.h -- inside lib/sim, included by wide.h: the same operations on eight lanes of float, for the kernels of single.c. Rows come
 * in batches of eight; numbers of rows stay doubles in memory and are rounded when they are loaded.
 */
#ifndef SN_SIM_WIDE_SINGLE_H
#define SN_SIM_WIDE_SINGLE_H

typedef sn_single_point wide_record;

#define WIDE_MOST FLT_MAX
/* What rounding leaves of the areas of triangles without one is larger than in double. */
#define WIDE_HINGE_GUARD 1e-8
#define WIDE_AREA_GUARD 1e-12

#ifndef SN_SCALAR

enum { WIDE_LANES = SN_BATCH_SINGLE };
typedef float wide __attribute__((vector_size(32)));
typedef int32_t wide_mask __attribute__((vector_size(32)));
typedef float single_record __attribute__((vector_size(16)));
typedef double eight_doubles __attribute__((vector_size(64)));
typedef double four_doubles __attribute__((vector_size(32)));

SN_INLINE wide wide_splat(double value) {
    const float a = (float)value;
    return (wide){a, a, a, a, a, a, a, a};
}
SN_INLINE wide wide_sqrt(wide a) {
    return (wide){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3]), sqrtf(a[4]), sqrtf(a[5]), sqrtf(a[6]), sqrtf(a[7])};
}
SN_INLINE wide_mask wide_less(wide a, wide b) { return a < b; }
SN_INLINE bool wide_any(wide_mask mask) {
    int64_t words[4];
    memcpy(words, &mask, sizeof words);
    return (words[0] | words[1] | words[2] | words[3]) != 0;
}
SN_INLINE wide wide_select(wide_mask mask, wide a, wide b) { return (wide)(((wide_mask)a & mask) | ((wide_mask)b & ~mask)); }
SN_INLINE wide wide_copysign(wide size, wide sign) {
    const wide_mask bit = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    return (wide)(((wide_mask)size & ~bit) | ((wide_mask)sign & bit));
}
SN_INLINE int64_t wide_count(wide_mask mask, int lanes) {
    int64_t count = 0;
    if (lanes == WIDE_LANES && !wide_any(mask)) return 0;
    for (int i = 0; i < lanes; i++) count -= mask[i];
    return count;
}

SN_INLINE wide wide_load(const double *from, int lanes) {
    if (lanes == 1) return wide_splat(*from);
    eight_doubles a;
    four_doubles low;
    memcpy(&low, from, sizeof low);
    if (lanes == WIDE_LANES)
        memcpy(&a, from, sizeof a);
    else
        a = __builtin_shufflevector(low, low, 0, 1, 2, 3, 4, 5, 6, 7);
    return __builtin_convertvector(a, wide);
}
SN_INLINE void wide_store(double *to, wide a, int lanes) {
    eight_doubles all = __builtin_convertvector(a, eight_doubles);
    memcpy(to, &all, (size_t)lanes * sizeof *to);
}

typedef struct wide_point {
    wide x, y, z, w;
} wide_point;

/* Four by four in either half: from records 0 and 4, 1 and 5, 2 and 6, 3 and 7 to x, y, z, w; and back. */
SN_INLINE wide_point transpose(wide a, wide b, wide c, wide d) {
    wide ab = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13), ab1 = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    wide cd = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13), cd1 = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
    return (wide_point){
        __builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13), __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15),
        __builtin_shufflevector(ab1, cd1, 0, 1, 8, 9, 4, 5, 12, 13), __builtin_shufflevector(ab1, cd1, 2, 3, 10, 11, 6, 7, 14, 15)};
}
SN_INLINE wide load_records(const sn_single_point *p, const sn_single_point *q) {
    single_record a, b;
    memcpy(&a, p, sizeof a);
    memcpy(&b, q, sizeof b);
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
}
/* Lanes beyond those asked for repeat the first ones, or the first. */
SN_INLINE wide_point wide_gather(const sn_single_point *points, const sn_index *index, int stride, int lanes) {
    const int s = lanes == 1 ? 0 : stride, upper = lanes == WIDE_LANES ? 4 * stride : 0;
    return transpose(load_records(&points[index[0]], &points[index[upper]]), load_records(&points[index[s]], &points[index[upper + s]]),
                     load_records(&points[index[2 * s]], &points[index[upper + 2 * s]]),
                     load_records(&points[index[3 * s]], &points[index[upper + 3 * s]]));
}
SN_INLINE void wide_scatter(sn_single_point *points, const sn_index *index, int stride, wide_point p, int lanes) {
    wide_point pair = transpose(p.x, p.y, p.z, p.w);
    const wide records[4] = {pair.x, pair.y, pair.z, pair.w};
    SN_UNROLL
    for (int i = 0; i < 4; i++) {
        single_record low = __builtin_shufflevector(records[i], records[i], 0, 1, 2, 3);
        single_record high = __builtin_shufflevector(records[i], records[i], 4, 5, 6, 7);
        if (i < lanes) memcpy(&points[index[i * stride]], &low, sizeof low);
        if (i + 4 < lanes) memcpy(&points[index[(i + 4) * stride]], &high, sizeof high);
    }
}
/* Add x, y, z of rows side by side to the points of each, row after row: they may share points. */
SN_INLINE void wide_add_vectors(sn_single_point *sum, const sn_index *index, int size, const wide_point *vectors, int lanes) {
    single_record record[3][SN_BATCH_SINGLE];
    for (int i = 0; i < size; i++) {
        wide_point pair = transpose(vectors[i].x, vectors[i].y, vectors[i].z, vectors[i].w);
        const wide halves[4] = {pair.x, pair.y, pair.z, pair.w};
        SN_UNROLL
        for (int k = 0; k < 4; k++) {
            record[i][k] = __builtin_shufflevector(halves[k], halves[k], 0, 1, 2, 3);
            record[i][k + 4] = __builtin_shufflevector(halves[k], halves[k], 4, 5, 6, 7);
        }
    }
    for (int lane = 0; lane < lanes; lane++) {
        for (int i = 0; i < size; i++) {
            sn_single_point *to = &sum[index[lane * size + i]];
            single_record a;
            memcpy(&a, to, sizeof a);
            a += record[i][lane];
            memcpy(to, &a, sizeof a);
        }
    }
}

#else /* the scalar twin */

enum { WIDE_LANES = 1 };
typedef float wide;
typedef int32_t wide_mask; /* 0 or -1 */

SN_INLINE wide wide_splat(double a) { return (float)a; }
SN_INLINE wide wide_sqrt(wide a) { return sqrtf(a); }
SN_INLINE wide_mask wide_less(wide a, wide b) { return a < b ? -1 : 0; }
SN_INLINE bool wide_any(wide_mask mask) { return mask != 0; }
SN_INLINE wide wide_select(wide_mask mask, wide a, wide b) { return mask != 0 ? a : b; }
SN_INLINE wide wide_copysign(wide size, wide sign) { return copysignf(size, sign); }
SN_INLINE int64_t wide_count(wide_mask mask, int lanes) { return -mask * lanes; }
SN_INLINE wide wide_load(const double *from, int lanes) { return (void)lanes, (float)*from; }
SN_INLINE void wide_store(double *to, wide a, int lanes) { (void)lanes, *to = (double)a; }

typedef sn_single_point wide_point;

SN_INLINE wide_point wide_gather(const sn_single_point *points, const sn_index *index, int stride, int lanes) {
    return (void)stride, (void)lanes, points[*index];
}
SN_INLINE void wide_scatter(sn_single_point *points, const sn_index *index, int stride, wide_point p, int lanes) {
    (void)stride, (void)lanes, points[*index] = p;
}
SN_INLINE void wide_add_vectors(sn_single_point *sum, const sn_index *index, int size, const wide_point *vectors, int lanes) {
    (void)lanes;
    for (int i = 0; i < size; i++) {
        sn_single_point *to = &sum[index[i]];
        to->x += vectors[i].x, to->y += vectors[i].y, to->z += vectors[i].z, to->w += vectors[i].w;
    }
}

#endif
#endif
