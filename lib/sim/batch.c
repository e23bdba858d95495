/*
 * batch.c -- an order of rows in which each four in a row share no point, so that a kernel can project the four at once and get what it
 * gets one after the other.   numerics.md 3: local batches keep the convergence of the sequential order; a global colouring does not
 *
 * Four such batches in a row share no point either, where there are enough rows: then no batch waits for the one before it.
 */
#include "rows.h"
#include "wide.h"

#include <stdlib.h>

enum { MOST = 4 * SN_BATCH, WINDOW = 256 }; /* rows of a run of batches; how far ahead it looks for them */

typedef struct batcher {
    sn_index count, size;   /* rows; points of a row */
    const sn_index *points; /* (count x size) */
    sn_index *next;         /* (count) the rows that are left, as a list */
    sn_index *stamp;        /* (point_count) the run that used a point last */
    sn_index run;
} batcher;

/* Claim the points of a row for this run; false where one of them is taken. */
static bool claim(const batcher *b, sn_index row) {
    const sn_index *p = b->points + (size_t)row * (size_t)b->size;
    for (sn_index i = 0; i < b->size; i++)
        if (b->stamp[p[i]] == b->run) return false;
    for (sn_index i = 0; i < b->size; i++) b->stamp[p[i]] = b->run;
    return true;
}

/* The first rows of the list that share no point; returns how many. */
static int find_run(const batcher *b, sn_index first, sn_index rows[MOST]) {
    int found = 0;
    for (int looked = 0; first != SN_NONE && found < MOST && looked < WINDOW; looked++, first = b->next[first])
        if (claim(b, first)) rows[found++] = first;
    return found;
}

/* Cut `count` rows out of the list; they are in its order. */
static void cut(const batcher *b, sn_index *first, const sn_index *rows, int count) {
    sn_index *link = first;
    for (int i = 0; i < count; i++) {
        while (*link != rows[i]) link = &b->next[*link];
        *link = b->next[rows[i]];
    }
}

/* Whole batches grow from the front of `order`; a row that finds no three others goes to the back. Returns how many are in batches. */
static sn_index fill_order(batcher *b, sn_index *order) {
    sn_index front = 0, back = b->count, first = b->count > 0 ? 0 : SN_NONE, rows[MOST];
    for (b->run = 0; first != SN_NONE; b->run++) {
        int found = find_run(b, first, rows), kept = found - found % SN_BATCH;
        cut(b, &first, rows, kept > 0 ? kept : 1);
        for (int i = 0; i < kept; i++) order[front++] = rows[i];
        if (kept == 0) order[--back] = rows[0];
    }
    for (sn_index low = front, high = b->count - 1; low < high; low++, high--) { /* they too in their order */
        sn_index row = order[low];
        order[low] = order[high];
        order[high] = row;
    }
    return front;
}

sn_status sn_batch_order(const sn_point_rows *rows, sn_index *order, sn_index *batched, sn_error *error) {
    batcher b = {rows->count, rows->size, rows->points, SN_NEW(sn_index, rows->count), SN_NEW(sn_index, rows->point_count), 0};
    bool made = b.next != NULL && b.stamp != NULL;
    for (sn_index i = 0; made && i < rows->point_count; i++) b.stamp[i] = SN_NONE;
    for (sn_index i = 0; made && i < rows->count; i++) b.next[i] = i + 1 < rows->count ? i + 1 : SN_NONE;
    if (made) *batched = fill_order(&b, order);
    free(b.next);
    free(b.stamp);
    return made ? SN_OK : sn_fail_memory(error, "the order of rows");
}

/* Is none of `count` points among the next `count`? */
static bool share_nothing(sn_index count, const sn_index *points) {
    for (sn_index i = 0; i < count; i++)
        for (sn_index k = count; k < 2 * count; k++)
            if (points[i] == points[k]) return false;
    return true;
}

void sn_batch_pair(sn_index batched, sn_index size, const sn_index *points, bool *pairs) {
    sn_index batches = batched / SN_BATCH, count = SN_BATCH * size;
    for (sn_index b = 0; b < batches; b++) pairs[b] = b + 1 < batches && share_nothing(count, points + (size_t)b * (size_t)count);
}

sn_status sn_batch_sort(void *array, sn_index count, size_t size, const sn_index *order, sn_error *error) {
    if (array == NULL || count == 0) return SN_OK;
    char *sorted = sn_alloc((size_t)count, size), *rows = array;
    if (sorted == NULL) return sn_fail_memory(error, "the order of rows");
    for (sn_index i = 0; i < count; i++) memcpy(sorted + (size_t)i * size, rows + (size_t)order[i] * size, size);
    memcpy(rows, sorted, (size_t)count * size);
    free(sorted);
    return SN_OK;
}
