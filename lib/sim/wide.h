/*
 * wide.h -- inside lib/sim: several rows at a time. One type, two builds: four lanes of double, or (CONFIG=scalar) one. The same bits from
 * both: rows come in batches of four that share no point (batch.c), every operation here is exact or correctly rounded, nothing is
 * contracted, and lanes never mix.
 *
 * A kernel is a plain function marked SN_WIDE_KERNEL: compiled for AVX2 and for the base instruction set, chosen when the program starts.
 * Tried and left: 8 lanes of AVX-512 (no faster here: the divider is the limit), approximate reciprocals (differ between processors).
 */
#ifndef SN_SIM_WIDE_H
#define SN_SIM_WIDE_H

#include "rows.h"

#include <float.h>
#include <string.h>

#define SN_BATCH 4        /* rows of a batch, in every build: the order of the rows must not depend on it */
#define SN_BATCH_SINGLE 8 /* two batches that share no point either: a register of single precision */

#define SN_UNROLL _Pragma("GCC unroll 4") /* -O2 leaves short loops, and the arrays they walk, in memory */
#define SN_INLINE static inline __attribute__((always_inline, unused))

#if !defined(SN_SCALAR) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define SN_WIDE_KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define SN_WIDE_KERNEL
#endif

#ifdef SN_WIDE_SINGLE /* defined before by single.c */
#include "wide_single.h"
#else

typedef sn_point wide_record;

#define WIDE_MOST DBL_MAX
#define WIDE_HINGE_GUARD SN_HINGE_GUARD

#ifndef SN_SCALAR

enum { WIDE_LANES = SN_BATCH };
typedef double wide __attribute__((vector_size(32)));
typedef int64_t wide_mask __attribute__((vector_size(32)));
typedef uint64_t wide_bits __attribute__((vector_size(32)));
typedef double wide_half __attribute__((vector_size(16)));

SN_INLINE wide wide_splat(double a) { return (wide){a, a, a, a}; }
SN_INLINE wide wide_sqrt(wide a) { return (wide){sqrt(a[0]), sqrt(a[1]), sqrt(a[2]), sqrt(a[3])}; }
SN_INLINE wide_mask wide_less(wide a, wide b) { return a < b; }
SN_INLINE wide_bits wide_splat_bits(uint64_t a) { return (wide_bits){a, a, a, a}; }
SN_INLINE wide_bits wide_bits_of(wide a) { return (wide_bits)a; }
SN_INLINE wide wide_of_bits(wide_bits a) { return (wide)a; }
SN_INLINE bool wide_any(wide_mask mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
SN_INLINE wide wide_select(wide_mask mask, wide a, wide b) { return (wide)(((wide_mask)a & mask) | ((wide_mask)b & ~mask)); }
SN_INLINE wide wide_copysign(wide size, wide sign) {
    const wide_mask bit = (wide_mask){INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};
    return (wide)(((wide_mask)size & ~bit) | ((wide_mask)sign & bit));
}
/* Lanes of the first `lanes` where the mask holds. */
SN_INLINE int64_t wide_count(wide_mask mask, int lanes) {
    int64_t count = 0;
    for (int i = 0; i < lanes; i++) count -= mask[i];
    return count;
}

/* Numbers of rows side by side; with fewer lanes than four, the first stands in all of them and alone is stored. */
SN_INLINE wide wide_load(const double *from, int lanes) {
    if (lanes != WIDE_LANES) return wide_splat(*from);
    wide a;
    memcpy(&a, from, sizeof a);
    return a;
}
SN_INLINE void wide_store(double *to, wide a, int lanes) {
    if (lanes == WIDE_LANES)
        memcpy(to, &a, sizeof a);
    else
        *to = a[0];
}

typedef struct wide_point {
    wide x, y, z, w;
} wide_point;

SN_INLINE wide_point transpose(wide a, wide b, wide c, wide d) {
    wide ab = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    wide cd = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return (wide_point){__builtin_shufflevector(ab, cd, 0, 1, 4, 5), __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5),
                        __builtin_shufflevector(ab, cd, 2, 3, 6, 7), __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7)};
}
SN_INLINE wide load_record(const sn_point *p) {
    wide a;
    memcpy(&a, p, sizeof a);
    return a;
}
/* Points index[0], index[stride], ... of consecutive rows. */
SN_INLINE wide_point wide_gather(const sn_point *points, const sn_index *index, int stride, int lanes) {
    int s = lanes == WIDE_LANES ? stride : 0;
    return transpose(load_record(&points[index[0]]), load_record(&points[index[s]]), load_record(&points[index[2 * s]]),
                     load_record(&points[index[3 * s]]));
}
SN_INLINE void wide_scatter(sn_point *points, const sn_index *index, int stride, wide_point p, int lanes) {
    wide_point record = transpose(p.x, p.y, p.z, p.w);
    memcpy(&points[index[0]], &record.x, sizeof record.x);
    if (lanes != WIDE_LANES) return;
    memcpy(&points[index[stride]], &record.y, sizeof record.y);
    memcpy(&points[index[2 * stride]], &record.z, sizeof record.z);
    memcpy(&points[index[3 * stride]], &record.w, sizeof record.w);
}

/* Consecutive points; with fewer lanes than four, the first. */
SN_INLINE wide_point wide_load_points(const sn_point *p, int lanes) {
    int s = lanes == WIDE_LANES ? 1 : 0;
    return transpose(load_record(p), load_record(p + s), load_record(p + 2 * s), load_record(p + 3 * s));
}
SN_INLINE void wide_store_points(sn_point *to, wide_point p, int lanes) {
    wide_point record = transpose(p.x, p.y, p.z, p.w);
    memcpy(to, &record, (size_t)lanes * sizeof *to);
}
SN_INLINE wide_point wide_load_vectors(const sn_vec3 *v, int lanes) {
    int s = lanes == WIDE_LANES ? 1 : 0;
    return transpose((wide){v[0].x, v[0].y, v[0].z, 0.0}, (wide){v[s].x, v[s].y, v[s].z, 0.0},
                     (wide){v[2 * s].x, v[2 * s].y, v[2 * s].z, 0.0}, (wide){v[3 * s].x, v[3 * s].y, v[3 * s].z, 0.0});
}
/* Numbers index[0], index[stride], ... of consecutive rows. */
SN_INLINE wide wide_pick(const double *values, const sn_index *index, int stride, int lanes) {
    int s = lanes == WIDE_LANES ? stride : 0;
    return (wide){values[index[0]], values[index[s]], values[index[2 * s]], values[index[3 * s]]};
}
/* Lanes whose flag is set. */
SN_INLINE wide_mask wide_flags(const bool *flag, int lanes) {
    int s = lanes == WIDE_LANES ? 1 : 0;
    return -(wide_mask){flag[0], flag[s], flag[2 * s], flag[3 * s]};
}

/* Vectors of rows side by side as one record per row. */
typedef struct wide_records {
    wide row[SN_BATCH];
} wide_records;

SN_INLINE wide_records wide_records_of(wide x, wide y, wide z) {
    wide_point p = transpose(x, y, z, wide_splat(0.0));
    return (wide_records){{p.x, p.y, p.z, p.w}};
}
SN_INLINE wide_records wide_opposite(wide_records records) {
    for (int lane = 0; lane < SN_BATCH; lane++) records.row[lane] = -records.row[lane];
    return records;
}
SN_INLINE void wide_add_record(sn_forces sum, sn_index point, const wide_records *records, int lane) {
    double *to = sum.values + (size_t)point * (size_t)sum.stride;
    wide record = records->row[lane];
    if (sum.stride == 4) {
        wide a;
        memcpy(&a, to, sizeof a);
        a += record;
        memcpy(to, &a, sizeof a);
    } else {
        wide_half low;
        memcpy(&low, to, sizeof low);
        low += __builtin_shufflevector(record, record, 0, 1);
        memcpy(to, &low, sizeof low);
        to[2] += record[2];
    }
}

#else /* the scalar twin */

enum { WIDE_LANES = 1 };
typedef double wide;
typedef int64_t wide_mask; /* 0 or -1 */
typedef uint64_t wide_bits;

SN_INLINE wide wide_splat(double a) { return a; }
SN_INLINE wide wide_sqrt(wide a) { return sqrt(a); }
SN_INLINE wide_mask wide_less(wide a, wide b) { return a < b ? -1 : 0; }
SN_INLINE wide_bits wide_splat_bits(uint64_t a) { return a; }
SN_INLINE wide_bits wide_bits_of(wide a) {
    wide_bits bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}
SN_INLINE wide wide_of_bits(wide_bits bits) {
    wide a;
    memcpy(&a, &bits, sizeof a);
    return a;
}
SN_INLINE bool wide_any(wide_mask mask) { return mask != 0; }
SN_INLINE wide wide_select(wide_mask mask, wide a, wide b) { return mask != 0 ? a : b; }
SN_INLINE wide wide_copysign(wide size, wide sign) { return copysign(size, sign); }
SN_INLINE int64_t wide_count(wide_mask mask, int lanes) { return -mask * lanes; }
SN_INLINE wide wide_load(const double *from, int lanes) { return (void)lanes, *from; }
SN_INLINE void wide_store(double *to, wide a, int lanes) { (void)lanes, *to = a; }

typedef sn_point wide_point;

SN_INLINE wide_point wide_gather(const sn_point *points, const sn_index *index, int stride, int lanes) {
    return (void)stride, (void)lanes, points[*index];
}
SN_INLINE void wide_scatter(sn_point *points, const sn_index *index, int stride, wide_point p, int lanes) {
    (void)stride, (void)lanes, points[*index] = p;
}
SN_INLINE wide_point wide_load_points(const sn_point *p, int lanes) { return (void)lanes, *p; }
SN_INLINE void wide_store_points(sn_point *to, wide_point p, int lanes) { (void)lanes, *to = p; }
SN_INLINE wide_point wide_load_vectors(const sn_vec3 *v, int lanes) { return (void)lanes, (wide_point){v->x, v->y, v->z, 0.0}; }
SN_INLINE wide wide_pick(const double *values, const sn_index *index, int stride, int lanes) {
    return (void)stride, (void)lanes, values[*index];
}
SN_INLINE wide_mask wide_flags(const bool *flag, int lanes) { return (void)lanes, *flag ? -1 : 0; }

typedef sn_vec3 wide_records;

SN_INLINE wide_records wide_records_of(wide x, wide y, wide z) { return (wide_records){x, y, z}; }
SN_INLINE wide_records wide_opposite(wide_records record) { return (wide_records){-record.x, -record.y, -record.z}; }
SN_INLINE void wide_add_record(sn_forces sum, sn_index point, const wide_records *record, int lane) {
    double *to = sum.values + (size_t)point * (size_t)sum.stride;
    (void)lane, to[0] += record->x, to[1] += record->y, to[2] += record->z;
}

#endif
#endif

/* ---- the same in both builds ---------------------------------------------------------------------------------------------- */

SN_INLINE wide wide_abs(wide a) { return wide_copysign(a, wide_splat(1.0)); }

/* Rows taken at a time where they come in batches of four, and whether so many can be. */
enum { WIDE_BATCH = WIDE_LANES < SN_BATCH ? WIDE_LANES : SN_BATCH };
SN_INLINE bool wide_takes(int rows) { return rows <= WIDE_LANES; }

typedef struct wide_vec3 {
    wide x, y, z;
} wide_vec3;

SN_INLINE wide_vec3 wide_between(wide_point a, wide_point b) { return (wide_vec3){a.x - b.x, a.y - b.y, a.z - b.z}; } /* a - b */
SN_INLINE wide_vec3 wide_scale(wide_vec3 a, wide s) { return (wide_vec3){a.x * s, a.y * s, a.z * s}; }
SN_INLINE wide_vec3 wide_add(wide_vec3 a, wide_vec3 b) { return (wide_vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
SN_INLINE wide wide_dot(wide_vec3 a, wide_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SN_INLINE wide_vec3 wide_cross(wide_vec3 a, wide_vec3 b) {
    return (wide_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* p moved by gradient x step where the mask holds; elsewhere it keeps its bits. */
SN_INLINE wide_point wide_move(wide_point p, wide_vec3 gradient, wide step, wide_mask mask) {
    p.x = wide_select(mask, p.x + gradient.x * step, p.x);
    p.y = wide_select(mask, p.y + gradient.y * step, p.y);
    p.z = wide_select(mask, p.z + gradient.z * step, p.z);
    return p;
}

/* Lengths, by their squares, that have a direction: not too short, and neither infinite nor NaN. */
SN_INLINE wide_mask has_directions(wide square) {
    return ~wide_less(square, wide_splat(SN_EDGE_GUARD)) & ~wide_less(wide_splat(WIDE_MOST), square) &
           wide_less(wide_splat(-1.0), square); /* and no NaN */
}

#ifndef SN_WIDE_SINGLE /* ---- energies and forces: in double alone */

/* a where the mask holds, elsewhere what can be added to anything without changing a bit of it. */
SN_INLINE wide wide_or_nothing(wide_mask mask, wide a) { return wide_select(mask, a, wide_splat(-0.0)); }

/* A sum over rows, by their number modulo four: the same order in both builds. */
typedef struct wide_total {
    double lane[SN_BATCH];
} wide_total;

SN_INLINE void wide_count_in(wide_total *total, sn_index row, wide value, int lanes) {
    double *to = lanes == SN_BATCH ? total->lane : &total->lane[row % SN_BATCH];
    wide_store(to, wide_load(to, lanes) + value, lanes);
}
SN_INLINE double wide_sum(const wide_total *total) { return (total->lane[0] + total->lane[1]) + (total->lane[2] + total->lane[3]); }

/* Add the forces of consecutive rows, which may share points, to the `size` points of each: row after row. */
SN_INLINE void wide_add_forces(sn_forces sum, const sn_index *index, int size, const wide_records *forces, int lanes) {
    SN_UNROLL
    for (int lane = 0; lane < lanes; lane++) SN_UNROLL
    for (int i = 0; i < size; i++) wide_add_record(sum, index[lane * size + i], &forces[i], lane);
}

#endif
#endif
