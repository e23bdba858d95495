/*
 * embedding_apply.c -- move the points of an embedding: sums of weights times positions, four weights at a time.
 *
 * The sum over a row is made of four partial sums, over every fourth weight, added as (0 + 1) + (2 + 3): the same bits from the wide and
 * the scalar build and for any number of threads. Four positions are three quads as they lie in memory, x y z x | y z x y | z x y z, and
 * the weights are spread to match: nothing has to be sorted into arrays of x, y and z first. Rows of all vertices come in pairs, which
 * read the positions once; they are bound by the memory that holds the weights.
 */
#include "sinew/embedding.h"

#include <string.h>

enum { LANES = 4, GRAIN = 8 }; /* GRAIN: points a chunk, even */

/* Partial sums of x, y and z. */
typedef struct sums {
    sn_vec3 lane[LANES];
} sums;

static sn_vec3 total(const sums *s) { return sn_add(sn_add(s->lane[0], s->lane[1]), sn_add(s->lane[2], s->lane[3])); }

/* The weights of a row that are left over after the fours. */
static void add_rest(sums *s, const sn_embedding_row *row, const sn_vec3 *positions) {
    for (sn_index k = row->count - row->count % LANES; k < row->count; k++)
        s->lane[k % LANES] = sn_add_scaled(s->lane[k % LANES], positions[k], row->weights[k]);
}

#if !defined(SN_SCALAR) && !defined(__clang__) /* clang has no __builtin_shuffle */

typedef double quad __attribute__((vector_size(32)));
typedef int64_t quad_index __attribute__((vector_size(32)));
typedef struct quads {
    quad a, b, c;
} quads;

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define WIDE_KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define WIDE_KERNEL
#endif
#define INLINE static inline __attribute__((always_inline))

INLINE quad load(const double *from) {
    quad q;
    memcpy(&q, from, sizeof q);
    return q;
}

/* sum += weight x position of four vertices, p their twelve coordinates. */
INLINE void add_four(quads *sum, const double *weights, const quads *p) {
    quad w = load(weights);
    sum->a += __builtin_shuffle(w, (quad_index){0, 0, 0, 1}) * p->a;
    sum->b += __builtin_shuffle(w, (quad_index){1, 1, 2, 2}) * p->b;
    sum->c += __builtin_shuffle(w, (quad_index){2, 3, 3, 3}) * p->c;
}

INLINE sums unpack(const quads *q) {
    return (sums){{{q->a[0], q->a[1], q->a[2]}, {q->a[3], q->b[0], q->b[1]}, {q->b[2], q->b[3], q->c[0]}, {q->c[1], q->c[2], q->c[3]}}};
}

/* Two rows of `count` weights each, over all vertices in their order. */
WIDE_KERNEL static void sum_pair(const double *first, const double *second, const sn_vec3 *positions, sn_index count, sums out[2]) {
    quads s = {{0}, {0}, {0}}, t = s;
    const double *coordinates = (const double *)positions;
    for (sn_index k = 0; k + LANES <= count; k += LANES) {
        const double *at = coordinates + 3 * (size_t)k;
        quads p = {load(at), load(at + 4), load(at + 8)};
        add_four(&s, first + k, &p);
        add_four(&t, second + k, &p);
    }
    out[0] = unpack(&s);
    out[1] = unpack(&t);
}

#else /* the scalar twin */

static sums sum_fours(const double *weights, const sn_vec3 *positions, sn_index count) {
    sums s = {0};
    for (sn_index k = 0; k < count - count % LANES; k++) s.lane[k % LANES] = sn_add_scaled(s.lane[k % LANES], positions[k], weights[k]);
    return s;
}

static void sum_pair(const double *first, const double *second, const sn_vec3 *positions, sn_index count, sums out[2]) {
    out[0] = sum_fours(first, positions, count);
    out[1] = sum_fours(second, positions, count);
}

#endif

_Static_assert(sizeof(sn_vec3) == 3 * sizeof(double), "positions are read as coordinates side by side");

static void apply_pair(const sn_embedding_row *first, const sn_embedding_row *second, const sn_vec3 *positions, sn_vec3 out[2]) {
    sums s[2];
    sum_pair(first->weights, second->weights, positions, first->count, s);
    add_rest(&s[0], first, positions);
    add_rest(&s[1], second, positions);
    out[0] = total(&s[0]);
    out[1] = total(&s[1]);
}

/* The same four partial sums, kept in registers. */
static sn_vec3 apply_sparse(const sn_embedding_row *row, const sn_vec3 *positions) {
    const sn_index *v = row->vertices;
    const double *w = row->weights;
    sn_vec3 a = {0, 0, 0}, b = a, c = a, d = a;
    sn_index k = 0;
    for (; k + LANES <= row->count; k += LANES) {
        a = sn_add_scaled(a, positions[v[k]], w[k]);
        b = sn_add_scaled(b, positions[v[k + 1]], w[k + 1]);
        c = sn_add_scaled(c, positions[v[k + 2]], w[k + 2]);
        d = sn_add_scaled(d, positions[v[k + 3]], w[k + 3]);
    }
    if (k < row->count) a = sn_add_scaled(a, positions[v[k]], w[k]);
    if (k + 1 < row->count) b = sn_add_scaled(b, positions[v[k + 1]], w[k + 1]);
    if (k + 2 < row->count) c = sn_add_scaled(c, positions[v[k + 2]], w[k + 2]);
    return sn_add(sn_add(a, b), sn_add(c, d));
}

typedef struct application {
    const sn_embedding *embedding;
    const sn_vec3 *positions;
    sn_vec3 *points;
} application;

static void apply_chunk(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const application *a = user;
    const sn_embedding_row *rows = a->embedding->rows;
    (void)chunk;
    for (sn_index i = begin; i < end;) {
        sn_vec3 pair[2];
        if (rows[i].vertices != NULL) {
            a->points[i] = apply_sparse(&rows[i], a->positions);
            i++;
            continue;
        }
        sn_index second = i + 1 < end && rows[i + 1].vertices == NULL ? i + 1 : i;
        apply_pair(&rows[i], &rows[second], a->positions, pair);
        a->points[i] = pair[0];
        a->points[second] = second > i ? pair[1] : pair[0];
        i = second + 1;
    }
}

void sn_embedding_apply(const sn_embedding *embedding, const sn_vec3 *positions, sn_pool *pool, sn_vec3 *points) {
    application a = {embedding, positions, points};
    sn_parallel_for(pool, embedding->point_count, GRAIN, apply_chunk, &a);
}
