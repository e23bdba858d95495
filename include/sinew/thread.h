/*
 * thread.h -- parallel loops with fixed chunks.   rank 0
 *
 * The chunks depend on count and grain only, never on the number of threads: a caller that reduces per chunk and adds the chunks
 * in order gets the same bits on one thread or four.
 */
#ifndef SINEW_THREAD_H
#define SINEW_THREAD_H

#include "sinew/base.h"

typedef struct sn_pool sn_pool;

/* Work on [begin, end) of chunk `chunk`. */
typedef void (*sn_range_function)(void *user, sn_index begin, sn_index end, sn_index chunk);

/* A pool of `threads` (>= 1, the caller counts as one; 0 = as many as this process may use). NULL = out of memory or threads. */
sn_pool *sn_pool_create(int threads);
void sn_pool_destroy(sn_pool *pool); /* NULL is fine */
int sn_pool_threads(const sn_pool *pool); /* NULL counts as 1 */

/* Call function on consecutive chunks of `grain` (>= 1) elements; returns when all are done. pool NULL = on the caller's thread.
 * Must not be called from inside function. */
void sn_parallel_for(sn_pool *pool, sn_index count, sn_index grain, sn_range_function function, void *user);
static inline sn_index sn_chunk_count(sn_index count, sn_index grain) { return count <= 0 ? 0 : (count - 1) / grain + 1; }

#endif
