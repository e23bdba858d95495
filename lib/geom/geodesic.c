/*
 * geodesic.c -- distance along a surface by fast marching (Kimmel, Sethian 1998): vertices are accepted nearest first; each triangle with
 * two accepted corners offers the third the arrival of a plane wave that crosses it. Unlike the way along edges it hardly depends on how
 * the surface is cut into triangles.
 */
#include <stdlib.h>

#include "queue.h"
#include "sinew/geom.h"

typedef struct marching {
    const sn_mesh *mesh;
    const sn_topology *topology;
    double *distance;
    bool *accepted; /* (vertex_count) */
    sn_queue queue;
} marching;

static bool offer(marching *m, sn_index vertex, double distance) {
    if (m->accepted[vertex] || !(distance < m->distance[vertex])) return true;
    m->distance[vertex] = distance;
    return sn_queue_push(&m->queue, (sn_reached){distance, vertex});
}

/* When a plane wave that reaches a and b at da and db reaches c: u with |grad u| = 1, that is (d - u)' Q (d - u) = 1 for the inverse Q of
 * the Gram matrix of a - c and b - c. INFINITY where the wave would come from outside the triangle's angle at c. */
static double wave_arrival(sn_vec3 a, sn_vec3 b, sn_vec3 c, double da, double db) {
    sn_vec3 e = sn_sub(a, c), f = sn_sub(b, c);
    double ee = sn_norm2(e), ef = sn_dot(e, f), ff = sn_norm2(f), determinant = ee * ff - ef * ef;
    if (!(determinant > 1e-24 * ee * ff)) return INFINITY;
    double near = fmin(da, db); /* relative to it nothing cancels far from the source */
    da -= near;
    db -= near;
    double sum = (ee + ff - 2.0 * ef) / determinant; /* 1' Q 1 */
    double mixed = ((ff - ef) * da + (ee - ef) * db) / determinant;
    double square = (ff * da * da - 2.0 * ef * da * db + ee * db * db) / determinant;
    double discriminant = mixed * mixed - sum * (square - 1.0);
    if (!(discriminant >= 0.0) || !(sum > 0.0)) return INFINITY;
    double u = (mixed + sqrt(discriminant)) / sum, ga = da - u, gb = db - u;
    bool inside = ff * ga - ef * gb <= 0.0 && ee * gb - ef * ga <= 0.0;
    return inside && u >= 0.0 ? near + u : INFINITY;
}

/* What an accepted vertex means for the others of one of its triangles. */
static bool cross_triangle(marching *m, sn_index vertex, sn_index triangle) {
    const sn_index *v = m->mesh->triangles[triangle].v;
    const sn_vec3 *p = m->mesh->positions;
    for (int k = 0; k < 3; k++) {
        sn_index to = v[k], other = v[(k + 1) % 3] == vertex ? v[(k + 2) % 3] : v[(k + 1) % 3];
        if (to == vertex || m->accepted[to]) continue;
        double arrival = m->distance[vertex] + sn_distance(p[vertex], p[to]);
        if (other != vertex && m->accepted[other])
            arrival = fmin(arrival, wave_arrival(p[vertex], p[other], p[to], m->distance[vertex], m->distance[other]));
        if (!offer(m, to, arrival)) return false;
    }
    return true;
}

static bool march(marching *m) {
    while (m->queue.count > 0) {
        sn_reached here = sn_queue_pop(&m->queue);
        if (m->accepted[here.vertex]) continue;
        m->accepted[here.vertex] = true;
        const sn_topology *t = m->topology;
        for (sn_index k = t->corner_start[here.vertex]; k < t->corner_start[here.vertex + 1]; k++)
            if (!cross_triangle(m, here.vertex, t->vertex_triangles[k])) return false;
    }
    return true;
}

sn_status sn_geodesic_distance(const sn_mesh *mesh, const sn_topology *topology, sn_index source_count, const sn_index *sources,
                               double *distance, sn_error *error) {
    marching m = {.mesh = mesh, .topology = topology, .distance = distance, .accepted = SN_NEW(bool, mesh->vertex_count)};
    sn_status status = SN_OK;
    bool enough = m.accepted != NULL;
    for (sn_index v = 0; v < mesh->vertex_count; v++) distance[v] = INFINITY;
    for (sn_index i = 0; enough && !status && i < source_count; i++)
        if (sources[i] < 0 || sources[i] >= mesh->vertex_count)
            status = sn_fail(error, SN_ERROR_INPUT, "distances are to start at vertex %d, which the mesh does not have", (int)sources[i]);
        else
            enough = offer(&m, sources[i], 0.0);
    if (enough && !status) enough = march(&m);
    if (!enough) status = sn_fail_memory(error, "the distances along the surface");
    free(m.accepted);
    free(m.queue.items);
    return status;
}
