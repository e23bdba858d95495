/*
 * holes.c -- hole filling: by triangulations of the border, and by fans where there is none.
 */
#include "sinew/geom.h"

#include <stdlib.h>

#include "bridge.h"
#include "edit.h"

typedef struct hole_count {
    sn_trace *trace;
    sn_index filled;
} hole_count;

static bool hole_filled(void *user, sn_index edges, sn_index triangles) {
    hole_count *count = user;
    count->filled++;
    return SN_TRACE(count->trace, "hole", sn_trace_number("edges", edges), sn_trace_number("triangles", triangles));
}

static sn_status fill_by_library(sn_mesh *mesh, sn_index max_edges, hole_count *count, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_fill_holes(&in, max_edges, hole_filled, count, &out, error);
    bool stopped = status == SN_STOPPED;
    if (status == SN_OK || stopped) status = sn_from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) sn_mesh_replace(mesh, &after);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status == SN_OK && stopped ? SN_STOPPED : status;
}

/* The hole's border, run so that new triangles on it are oriented as the old ones: next (vertex_count), SN_NONE off the border.
 * Returns its number of edges. On an oriented manifold no vertex has two. */
static sn_index find_border(const sn_mesh *mesh, const sn_topology *topology, sn_index *next) {
    sn_index edges = 0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) next[v] = SN_NONE;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e == SN_NONE || topology->edges[e].triangle_count != 1) continue;
            next[mesh->triangles[t].v[(k + 2) % 3]] = mesh->triangles[t].v[(k + 1) % 3];
            edges++;
        }
    }
    return edges;
}

/* Edges of the loop through `start`; 0 where it does not close. */
static sn_index loop_length(const sn_index *next, sn_index start, sn_index most) {
    sn_index length = 0;
    for (sn_index v = start; length <= most; v = next[v]) {
        if (v == SN_NONE) return 0;
        if (v == start && length > 0) return length;
        length++;
    }
    return 0;
}

static void add_triangle(sn_mesh *mesh, sn_index a, sn_index b, sn_index c) {
    if (mesh->triangle_group != NULL) mesh->triangle_group[mesh->triangle_count] = SN_NONE;
    mesh->triangles[mesh->triangle_count++] = (sn_triangle){{a, b, c}};
}

/* A new vertex at the mean of a loop, its attributes the means of the loop's. */
static sn_index add_loop_centre(sn_mesh *mesh, const sn_index *next, sn_index start, sn_index length) {
    sn_index centre = mesh->vertex_count++;
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index i = 0, v = start; i < length; i++, v = next[v]) sum = sn_add_scaled(sum, mesh->positions[v], 1.0 / length);
    mesh->positions[centre] = sum;
    for (sn_index a = 0; a < mesh->attribute_count; a++) {
        size_t components = (size_t)mesh->attributes[a].components;
        double *values = mesh->attributes[a].values;
        for (size_t c = 0; c < components; c++) {
            double mean = 0.0;
            for (sn_index i = 0, v = start; i < length; i++, v = next[v]) mean += values[(size_t)v * components + c] / length;
            values[(size_t)centre * components + c] = mesh->attributes[a].integer ? round(mean) : mean;
        }
    }
    return centre;
}

/* Close a loop that the library would not: three edges by a triangle, more by a fan around their mean. */
static void close_loop(sn_mesh *mesh, sn_index *next, sn_index start, sn_index length) {
    sn_index second = next[start], third = next[second], centre = SN_NONE;
    if (length > 3)
        centre = add_loop_centre(mesh, next, start, length);
    else
        add_triangle(mesh, start, second, third);
    for (sn_index i = 0, v = start; i < length; i++) {
        sn_index after = next[v];
        if (centre != SN_NONE) add_triangle(mesh, v, after, centre);
        next[v] = SN_NONE; /* done */
        v = after;
    }
}

/* Does a loop of three run around a triangle that stands alone? Closing it would double the triangle. */
static bool is_lone_triangle(const sn_topology *topology, const sn_index *next, sn_index start) {
    sn_index e = sn_topology_edge(topology, start, next[start]);
    const sn_index *other = topology->triangle_edges[topology->edges[e].triangle[0]];
    return topology->edges[other[0]].triangle_count == 1 && topology->edges[other[1]].triangle_count == 1 &&
           topology->edges[other[2]].triangle_count == 1;
}

static sn_status close_by_fans(sn_mesh *mesh, sn_index max_edges, hole_count *count, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index before = mesh->vertex_count, *next = SN_NEW(sn_index, before);
    sn_index edges = next != NULL ? find_border(mesh, &topology, next) : 0;
    if (next == NULL || !sn_mesh_make_room(mesh, edges / 3 + 1, edges + 1)) status = sn_fail_memory(error, "filling holes");
    for (sn_index v = 0; status == SN_OK && v < before; v++) {
        sn_index length = next[v] != SN_NONE ? loop_length(next, v, edges) : 0;
        if (length < 3 || length > max_edges || (length == 3 && is_lone_triangle(&topology, next, v))) continue;
        close_loop(mesh, next, v, length);
        if (hole_filled(count, length, length > 3 ? length : 1)) status = SN_STOPPED;
    }
    free(next);
    sn_topology_free(&topology);
    return status;
}

sn_status sn_fill_holes(sn_mesh *mesh, sn_index max_edges, sn_trace *trace, sn_index *filled, sn_index *boundary_left, sn_error *error) {
    *filled = *boundary_left = 0;
    sn_mesh_report found;
    sn_status status = sn_mesh_look_at_edges(mesh, &found, error);
    if (status != SN_OK) return status;
    *boundary_left = found.boundary_edges;
    bool fillable = found.nonmanifold_edges == 0 && found.nonmanifold_vertices == 0 && found.inconsistent_edges == 0;
    if (found.boundary_edges == 0 || !fillable) return SN_OK;
    hole_count count = {.trace = trace};
    sn_index most = max_edges > 0 ? max_edges : SN_INDEX_MAX;
    status = fill_by_library(mesh, most, &count, error);
    if (status == SN_OK) status = close_by_fans(mesh, most, &count, error);
    *filled = count.filled;
    sn_status recounted = status == SN_OK || status == SN_STOPPED ? sn_mesh_look_at_edges(mesh, &found, error) : status;
    *boundary_left = found.boundary_edges;
    return recounted == SN_OK ? status : recounted;
}
