/*
 * embedding.h -- points bound to a surface by 3-D mean value coordinates (Ju, Schaefer and Warren 2005; [K21] eq. 8): where the surface
 * goes, they go.   rank 1
 *
 * x = sum w_j p_j with sum w_j = 1 at rest, to about 1e-15 of the size: what the formulas leave is taken up by one 4 x 4 moment correction
 * of the weights. So an affine map of the surface maps the points exactly. All lengths are in the unit of the mesh.
 */
#ifndef SINEW_EMBEDDING_H
#define SINEW_EMBEDDING_H

#include "sinew/mesh.h"
#include "sinew/thread.h"

/* The weights of one point. */
typedef struct sn_embedding_row {
    sn_index count;     /* weights */
    sn_index *vertices; /* (count) of the surface; NULL = all, in order */
    double *weights;    /* (count) */
} sn_embedding_row;

typedef struct sn_embedding_params {
    double near;   /* a point nearer to the surface than this share of the box diagonal hangs on its closest triangle; default 1e-7.
                      There the formulas divide by the sines of angles near 0 and pi */
    double cut;    /* drop weights below this (sum of weights = 1), then correct the moments; 0 (default) = keep all; < 0.1 */
    sn_pool *pool; /* NULL = the caller's thread; the weights are the same */
} sn_embedding_params;

typedef struct sn_embedding_report {
    sn_index near_points; /* bound to one triangle */
    int64_t weights;      /* kept, in all */
    double correction;    /* largest |x - sum w p| / diagonal, or |1 - sum w|, before the correction */
    double error;         /* the same after it */
    double dropped_mean;  /* of a point's dropped weights, the sum of their sizes: a vertex that moves by d against what its neighbours */
    double dropped_worst; /* do moves the point by at most dropped x d less or more than all weights would; 0 without a cut */
} sn_embedding_report;

typedef struct sn_embedding {
    sn_index point_count, vertex_count;
    sn_embedding_row *rows;     /* (point_count) */
    sn_embedding_report report; /* of how it was built; zeros in one that was read */
} sn_embedding;

sn_embedding_params sn_embedding_defaults(void);
/* Weights of `count` points. The surface should be closed, the points inside; outside, too, the weights are right unless they vanish in
 * sum (SN_ERROR_INPUT). The same bits for any number of threads. */
SN_MUST_CHECK sn_status sn_embedding_build(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding_params *params,
                                           sn_embedding *out, sn_error *error);
/* points (point_count) = sum w_j positions_j; positions (vertex_count). pool may be NULL. */
void sn_embedding_apply(const sn_embedding *embedding, const sn_vec3 *positions, sn_pool *pool, sn_vec3 *points);
/* Names what the weights depend on: surface, points and params. */
SN_MUST_CHECK sn_status sn_embedding_hash(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding_params *params,
                                          char out[SN_HASH_LENGTH], sn_error *error);
void sn_embedding_free(sn_embedding *embedding); /* frees what it owns and zeroes it */

#endif
