/* thread.c -- a pool that runs fixed chunks; which thread takes which chunk never matters to the result. */
#include "sinew/thread.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

struct sn_pool {
    int threads, started; /* helpers that run, without the caller */
    pthread_t *helpers;
    pthread_mutex_t lock;
    pthread_cond_t work, done;
    uint64_t round; /* grows by one with every loop; under the lock */
    int busy;       /* helpers still in this round; under the lock */
    bool quit;
    /* the loop at hand */
    sn_range_function function;
    void *user;
    sn_index count, grain;
    _Atomic sn_index next_chunk;
};

static void run_chunks(sn_pool *pool) {
    sn_index chunks = sn_chunk_count(pool->count, pool->grain);
    for (;;) {
        sn_index chunk = atomic_fetch_add_explicit(&pool->next_chunk, 1, memory_order_relaxed);
        if (chunk >= chunks) return;
        sn_index begin = chunk * pool->grain;
        sn_index end = pool->count - begin < pool->grain ? pool->count : begin + pool->grain;
        pool->function(pool->user, begin, end, chunk);
    }
}

static void *helper_main(void *argument) {
    sn_pool *pool = argument;
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->quit && pool->round == seen) pthread_cond_wait(&pool->work, &pool->lock);
        if (pool->quit) break;
        seen = pool->round;
        pthread_mutex_unlock(&pool->lock);
        run_chunks(pool);
        pthread_mutex_lock(&pool->lock);
        if (--pool->busy == 0) pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static int usable_processors(void) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    int count = CPU_COUNT(&set);
    return count > 0 ? count : 1;
}

sn_pool *sn_pool_create(int threads) {
    sn_pool *pool = SN_NEW(sn_pool, 1);
    if (pool == NULL) return NULL;
    pool->threads = threads > 0 ? threads : usable_processors();
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, NULL);
    pool->helpers = SN_NEW(pthread_t, pool->threads);
    if (pool->helpers == NULL) goto failed;
    for (; pool->started < pool->threads - 1; pool->started++)
        if (pthread_create(&pool->helpers[pool->started], NULL, helper_main, pool) != 0) goto failed;
    return pool;
failed:
    sn_pool_destroy(pool);
    return NULL;
}

void sn_pool_destroy(sn_pool *pool) {
    if (pool == NULL) return;
    pthread_mutex_lock(&pool->lock);
    pool->quit = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->started; i++) pthread_join(pool->helpers[i], NULL);
    pthread_cond_destroy(&pool->work);
    pthread_cond_destroy(&pool->done);
    pthread_mutex_destroy(&pool->lock);
    free(pool->helpers);
    free(pool);
}

int sn_pool_threads(const sn_pool *pool) { return pool == NULL ? 1 : pool->threads; }

void sn_parallel_for(sn_pool *pool, sn_index count, sn_index grain, sn_range_function function, void *user) {
    if (count <= 0) return;
    if (pool == NULL || pool->started == 0 || count <= grain) {
        sn_pool serial = {.function = function, .user = user, .count = count, .grain = grain};
        run_chunks(&serial);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->function = function;
    pool->user = user;
    pool->count = count;
    pool->grain = grain;
    atomic_store_explicit(&pool->next_chunk, 0, memory_order_relaxed);
    pool->busy = pool->started;
    pool->round++;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    run_chunks(pool);
    pthread_mutex_lock(&pool->lock);
    while (pool->busy > 0) pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}
