/* distance.c -- shortest distance along the edges of a surface (Dijkstra). Apart from field.c: its users need no sparse solver. */
#include <stdlib.h>

#include "sinew/geom.h"

typedef struct reached {
    double distance;
    sn_index vertex;
} reached;

/* A binary heap, nearest first; equal distances by vertex, so that the order never depends on history. */
typedef struct queue {
    reached *items;
    size_t count, capacity;
} queue;

static bool comes_before(reached a, reached b) { return a.distance < b.distance || (a.distance == b.distance && a.vertex < b.vertex); }

static bool queue_push(queue *q, reached item) {
    if (!sn_grow((void **)&q->items, &q->capacity, q->count + 1, sizeof *q->items)) return false;
    size_t i = q->count++;
    for (; i > 0 && comes_before(item, q->items[(i - 1) / 2]); i = (i - 1) / 2) q->items[i] = q->items[(i - 1) / 2];
    q->items[i] = item;
    return true;
}

static reached queue_pop(queue *q) {
    reached first = q->items[0], last = q->items[--q->count];
    size_t i = 0;
    for (size_t child = 1; child < q->count; child = 2 * i + 1) {
        if (child + 1 < q->count && comes_before(q->items[child + 1], q->items[child])) child++;
        if (!comes_before(q->items[child], last)) break;
        q->items[i] = q->items[child];
        i = child;
    }
    q->items[i] = last;
    return first;
}

static bool start_at(queue *q, sn_index count, const sn_index *sources, double *distance) {
    for (sn_index i = 0; i < count; i++) {
        if (distance[sources[i]] == 0.0) continue; /* given twice */
        distance[sources[i]] = 0.0;
        if (!queue_push(q, (reached){0.0, sources[i]})) return false;
    }
    return true;
}

static bool relax_neighbours(const sn_mesh *mesh, const sn_topology *t, queue *q, reached here, double *distance, sn_index *from) {
    for (sn_index k = t->vertex_start[here.vertex]; k < t->vertex_start[here.vertex + 1]; k++) {
        sn_index w = t->neighbours[k];
        double through = here.distance + sn_distance(mesh->positions[here.vertex], mesh->positions[w]);
        if (!(through < distance[w])) continue;
        distance[w] = through;
        if (from) from[w] = here.vertex;
        if (!queue_push(q, (reached){through, w})) return false;
    }
    return true;
}

sn_status sn_edge_distance(const sn_mesh *mesh, const sn_topology *topology, sn_index source_count, const sn_index *sources,
                           double *distance, sn_index *from, sn_error *error) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        distance[v] = INFINITY;
        if (from) from[v] = SN_NONE;
    }
    for (sn_index i = 0; i < source_count; i++)
        if (sources[i] < 0 || sources[i] >= mesh->vertex_count)
            return sn_fail(error, SN_ERROR_INPUT, "distances are to start at vertex %d, which the mesh does not have", (int)sources[i]);
    queue q = {0};
    bool enough = start_at(&q, source_count, sources, distance);
    while (enough && q.count > 0) {
        reached here = queue_pop(&q);
        if (here.distance > distance[here.vertex]) continue; /* reached on a shorter way since */
        enough = relax_neighbours(mesh, topology, &q, here, distance, from);
    }
    free(q.items);
    return enough ? SN_OK : sn_fail_memory(error, "the queue of a distance field");
}
