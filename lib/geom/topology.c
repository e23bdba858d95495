/*
 * topology.c -- edges and adjacency of a mesh by counting sort: linear time, the same on every machine.
 */
#include "sinew/mesh.h"

#include <stdlib.h>

#include "edit.h"
#include "order.h"

/* The three half-edges of each triangle as (low, high) vertex pairs; half-edge 3t+k lies opposite to corner k. */
typedef struct half_edges {
    sn_index count;
    sn_index *low, *high; /* (count) */
    sn_index *order;      /* (count) half-edges sorted by (low, high) */
} half_edges;

static void half_edges_free(half_edges *half) {
    free(half->low);
    free(half->high);
    free(half->order);
}

/* Triangles with a repeated index have no edges: their half-edges get the pair (0, 0) and are skipped later. */
static void half_edges_fill(const sn_mesh *mesh, half_edges *half) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_triangle triangle = mesh->triangles[t];
        bool skip = sn_triangle_repeats_index(triangle);
        for (int k = 0; k < 3; k++) {
            sn_index a = triangle.v[(k + 1) % 3], b = triangle.v[(k + 2) % 3];
            half->low[3 * t + k] = skip ? 0 : (a < b ? a : b);
            half->high[3 * t + k] = skip ? 0 : (a < b ? b : a);
        }
    }
}

static sn_status half_edges_build(const sn_mesh *mesh, half_edges *half, sn_error *error) {
    sn_index count = 3 * mesh->triangle_count;
    *half = (half_edges){.count = count};
    half->low = SN_NEW(sn_index, count);
    half->high = SN_NEW(sn_index, count);
    half->order = SN_NEW(sn_index, count);
    sn_index *by_high = SN_NEW(sn_index, count);
    sn_index *start = SN_NEW(sn_index, (size_t)mesh->vertex_count + 1);
    bool enough = half->low && half->high && half->order && by_high && start;
    if (enough) {
        half_edges_fill(mesh, half);
        sn_counting_sort(count, NULL, half->high, mesh->vertex_count, start, by_high);
        sn_counting_sort(count, by_high, half->low, mesh->vertex_count, start, half->order);
    }
    free(by_high);
    free(start);
    if (enough) return SN_OK;
    half_edges_free(half);
    return sn_fail_memory(error, "the edges of a mesh");
}

static bool same_edge(const half_edges *half, sn_index a, sn_index b) {
    return half->low[a] == half->low[b] && half->high[a] == half->high[b];
}

static bool is_edge(const half_edges *half, sn_index h) { return half->low[h] != half->high[h]; }

static sn_index count_edges(const half_edges *half) {
    sn_index edges = 0;
    for (sn_index i = 0; i < half->count; i++) {
        sn_index h = half->order[i];
        if (is_edge(half, h) && (i == 0 || !same_edge(half, half->order[i - 1], h))) edges++;
    }
    return edges;
}

/* Stable sorting left the triangles of an edge in ascending order. */
static void fill_edges(const sn_mesh *mesh, const half_edges *half, sn_topology *topology) {
    sn_index e = -1;
    for (sn_index i = 0; i < half->count; i++) {
        sn_index h = half->order[i], t = h / 3, k = h % 3;
        if (!is_edge(half, h)) {
            topology->triangle_edges[t][k] = SN_NONE;
            continue;
        }
        if (e < 0 || topology->edges[e].v[0] != half->low[h] || topology->edges[e].v[1] != half->high[h]) {
            topology->edges[++e] = (sn_edge){.v = {half->low[h], half->high[h]}, .triangle = {-1, -1}, .opposite = {-1, -1}};
        }
        sn_edge *edge = &topology->edges[e];
        topology->triangle_edges[t][k] = e;
        if (edge->triangle_count < 2) {
            edge->triangle[edge->triangle_count] = t;
            edge->opposite[edge->triangle_count] = mesh->triangles[t].v[k];
        }
        edge->triangle_count++;
    }
}

/* Edges in order give every vertex first its lower neighbours, ascending, then its higher ones. */
static void fill_neighbours(sn_topology *topology) {
    sn_index *start = topology->vertex_start;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        for (int k = 0; k < 2; k++) start[topology->edges[e].v[k] + 1]++;
    }
    for (sn_index v = 0; v < topology->vertex_count; v++) start[v + 1] += start[v];
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        for (int k = 0; k < 2; k++) {
            sn_index place = start[edge->v[k]]++;
            topology->neighbours[place] = edge->v[1 - k];
            topology->vertex_edges[place] = e;
        }
    }
    for (sn_index v = topology->vertex_count; v > 0; v--) start[v] = start[v - 1];
    start[0] = 0;
}

static void fill_vertex_triangles(const sn_mesh *mesh, sn_topology *topology) {
    const sn_index *corners = mesh->triangles[0].v; /* 3 triangle_count indices in a row */
    sn_counting_sort(3 * mesh->triangle_count, NULL, corners, mesh->vertex_count, topology->corner_start, topology->vertex_triangles);
    for (sn_index i = 0; i < 3 * mesh->triangle_count; i++) topology->vertex_triangles[i] /= 3;
}
_Static_assert(sizeof(sn_triangle) == 3 * sizeof(sn_index), "triangles are read as a flat array of indices");

static bool topology_alloc(const sn_mesh *mesh, sn_index edge_count, sn_topology *out) {
    *out = (sn_topology){.vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count, .edge_count = edge_count};
    out->edges = SN_NEW(sn_edge, edge_count);
    out->triangle_edges = sn_alloc((size_t)mesh->triangle_count, sizeof *out->triangle_edges);
    out->vertex_start = SN_NEW(sn_index, (size_t)mesh->vertex_count + 1);
    out->neighbours = SN_NEW(sn_index, 2 * (size_t)edge_count);
    out->vertex_edges = SN_NEW(sn_index, 2 * (size_t)edge_count);
    out->corner_start = SN_NEW(sn_index, (size_t)mesh->vertex_count + 1);
    out->vertex_triangles = SN_NEW(sn_index, 3 * (size_t)mesh->triangle_count);
    return out->edges && out->triangle_edges && out->vertex_start && out->neighbours && out->vertex_edges && out->corner_start &&
           out->vertex_triangles;
}

sn_status sn_topology_build(const sn_mesh *mesh, sn_topology *out, sn_error *error) {
    *out = (sn_topology){0};
    if (mesh->triangle_count > SN_INDEX_MAX / 6) {
        return sn_fail(error, SN_ERROR_INPUT, "%d triangles are more than can be indexed; decimate the mesh first", mesh->triangle_count);
    }
    half_edges half;
    sn_status status = half_edges_build(mesh, &half, error);
    if (status != SN_OK) return status;
    if (topology_alloc(mesh, count_edges(&half), out)) {
        fill_edges(mesh, &half, out);
        fill_neighbours(out);
        if (mesh->triangle_count > 0) fill_vertex_triangles(mesh, out);
    } else {
        sn_topology_free(out);
        status = sn_fail_memory(error, "the adjacency of a mesh");
    }
    half_edges_free(&half);
    return status;
}

void sn_topology_free(sn_topology *topology) {
    if (topology == NULL) return;
    free(topology->edges);
    free(topology->triangle_edges);
    free(topology->vertex_start);
    free(topology->neighbours);
    free(topology->vertex_edges);
    free(topology->corner_start);
    free(topology->vertex_triangles);
    *topology = (sn_topology){0};
}

sn_index sn_topology_edge(const sn_topology *topology, sn_index a, sn_index b) {
    sn_index low = topology->vertex_start[a], high = topology->vertex_start[a + 1];
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        if (topology->neighbours[middle] < b)
            low = middle + 1;
        else
            high = middle;
    }
    bool found = low < topology->vertex_start[a + 1] && topology->neighbours[low] == b;
    return found ? topology->vertex_edges[low] : SN_NONE;
}

sn_index sn_mesh_components(const sn_mesh *mesh, const sn_topology *topology, sn_index *component) {
    sn_index count = 0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) component[t] = t;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e != SN_NONE && topology->edges[e].triangle[0] != t) sn_set_join(component, t, topology->edges[e].triangle[0]);
        }
    }
    /* a set's parent is never above its member: it has its number already */
    for (sn_index t = 0; t < mesh->triangle_count; t++) component[t] = component[t] == t ? count++ : component[component[t]];
    return count;
}
