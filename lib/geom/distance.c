/* distance.c -- shortest distance along the edges of a surface (Dijkstra). Apart from field.c: its users need no sparse solver. */
#include <stdlib.h>

#include "queue.h"
#include "sinew/geom.h"

static bool start_at(sn_queue *q, sn_index count, const sn_index *sources, double *distance) {
    for (sn_index i = 0; i < count; i++) {
        if (distance[sources[i]] == 0.0) continue; /* given twice */
        distance[sources[i]] = 0.0;
        if (!sn_queue_push(q, (sn_reached){0.0, sources[i]})) return false;
    }
    return true;
}

static bool relax_neighbours(const sn_mesh *mesh, const sn_topology *t, sn_queue *q, sn_reached here, double *distance) {
    for (sn_index k = t->vertex_start[here.vertex]; k < t->vertex_start[here.vertex + 1]; k++) {
        sn_index w = t->neighbours[k];
        double through = here.distance + sn_distance(mesh->positions[here.vertex], mesh->positions[w]);
        if (!(through < distance[w])) continue;
        distance[w] = through;
        if (!sn_queue_push(q, (sn_reached){through, w})) return false;
    }
    return true;
}

sn_status sn_edge_distance(const sn_mesh *mesh, const sn_topology *topology, sn_index source_count, const sn_index *sources,
                           double *distance, sn_error *error) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) distance[v] = INFINITY;
    for (sn_index i = 0; i < source_count; i++)
        if (sources[i] < 0 || sources[i] >= mesh->vertex_count)
            return sn_fail(error, SN_ERROR_INPUT, "distances are to start at vertex %d, which the mesh does not have", (int)sources[i]);
    sn_queue q = {0};
    bool enough = start_at(&q, source_count, sources, distance);
    while (enough && q.count > 0) {
        sn_reached here = sn_queue_pop(&q);
        if (here.distance > distance[here.vertex]) continue; /* reached on a shorter way since */
        enough = relax_neighbours(mesh, topology, &q, here, distance);
    }
    free(q.items);
    return enough ? SN_OK : sn_fail_memory(error, "the queue of a distance field");
}
