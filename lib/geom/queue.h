/*
 * queue.h -- the binary heap of the distance fields, nearest vertex first; private to lib/geom.
 */
#ifndef SINEW_GEOM_QUEUE_H
#define SINEW_GEOM_QUEUE_H

#include "sinew/base.h"

typedef struct sn_reached {
    double distance;
    sn_index vertex;
} sn_reached;

/* Equal distances come by vertex, so that the order never depends on history. All zeros is an empty queue; free items at the end. */
typedef struct sn_queue {
    sn_reached *items;
    size_t count, capacity;
} sn_queue;

static inline bool sn_comes_before(sn_reached a, sn_reached b) {
    return a.distance < b.distance || (a.distance == b.distance && a.vertex < b.vertex);
}

/* false = out of memory. */
static inline bool sn_queue_push(sn_queue *q, sn_reached item) {
    if (!sn_grow((void **)&q->items, &q->capacity, q->count + 1, sizeof *q->items)) return false;
    size_t i = q->count++;
    for (; i > 0 && sn_comes_before(item, q->items[(i - 1) / 2]); i = (i - 1) / 2) q->items[i] = q->items[(i - 1) / 2];
    q->items[i] = item;
    return true;
}

/* Of a queue that is not empty. */
static inline sn_reached sn_queue_pop(sn_queue *q) {
    sn_reached first = q->items[0], last = q->items[--q->count];
    size_t i = 0;
    for (size_t child = 1; child < q->count; child = 2 * i + 1) {
        if (child + 1 < q->count && sn_comes_before(q->items[child + 1], q->items[child])) child++;
        if (!sn_comes_before(q->items[child], last)) break;
        q->items[i] = q->items[child];
        i = child;
    }
    q->items[i] = last;
    return first;
}

#endif
