/*
 * solid_inner.c -- triangles of a closed surface that have the solid on both sides: walls within, parts that overlap.
 *
 * The winding number tells, but costs some ten microseconds a point. Where no edge goes through another triangle it does not change along
 * the surface, so patches without crossings are judged by a few of their triangles; crossing ones, and patches with an inner triangle
 * among the few, by each.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "solid.h"
#include "winding_tree.h"

enum { GRAIN = 64, SAMPLES = 16, MOST_HITS = 64 };
/* How far beside a triangle its sides are looked at, in the root of its area. */
static const double beside = 1e-3;

typedef struct inner {
    const sn_mesh *mesh;
    const sn_surface *surface;
    const sn_topology *topology;
    sn_winding_tree tree;
    bool *crossed;  /* (triangle_count) goes through another */
    sn_index *ask;  /* (triangle_count) the triangles to judge */
    sn_index count; /* of them */
    bool *boundary; /* (triangle_count) */
} inner;

/* ---- one triangle ------------------------------------------------------------------------------------------------------------- */

static bool inside_at(const inner *in, sn_vec3 p) { return fabs(sn_winding_tree_number(&in->tree, p)) > 0.5; }

/* Has the triangle the solid on both sides, at seven points of it? Where in doubt it is boundary. */
static bool is_inner(const inner *in, sn_triangle t) {
    static const double weights[7][3] = {{1, 1, 1}, {18, 1, 1}, {1, 18, 1}, {1, 1, 18}, {10, 10, 1}, {1, 10, 10}, {10, 1, 10}};
    const sn_vec3 *p = in->mesh->positions;
    sn_vec3 area = sn_area_vector(p[t.v[0]], p[t.v[1]], p[t.v[2]]);
    sn_vec3 step = sn_scale(sn_normalize(area), beside * sqrt(0.5 * sn_norm(area)));
    for (int i = 0; i < 7; i++) {
        const double *w = weights[i];
        sn_vec3 at = sn_add_scaled(sn_add_scaled(sn_scale(p[t.v[0]], w[0]), p[t.v[1]], w[1]), p[t.v[2]], w[2]);
        at = sn_scale(at, 1.0 / (w[0] + w[1] + w[2]));
        if (!inside_at(in, sn_add(at, step)) || !inside_at(in, sn_sub(at, step))) return false;
    }
    return true;
}

static void judge(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const inner *in = user;
    (void)chunk;
    for (sn_index i = begin; i < end; i++) in->boundary[in->ask[i]] = !is_inner(in, in->mesh->triangles[in->ask[i]]);
}

/* ---- crossings ------------------------------------------------------------------------------------------------------------------ */

static bool touches(sn_triangle t, const sn_index end[2]) {
    for (int k = 0; k < 3; k++)
        if (t.v[k] == end[0] || t.v[k] == end[1]) return true;
    return false;
}

/* Mark the triangles that the edge goes through, and its own where it does. Those at its ends do not count. */
static void mark_crossed(inner *in, const sn_edge *edge) {
    sn_vec3 from = in->mesh->positions[edge->v[0]], along = sn_sub(in->mesh->positions[edge->v[1]], from);
    double length = sn_norm(along), near = 0.0;
    for (int i = 0; i < MOST_HITS; i++) {
        sn_ray_hit hit = sn_surface_ray(in->surface, from, along, near, length);
        if (hit.triangle == SN_NONE) return;
        near = hit.distance;
        if (touches(in->mesh->triangles[hit.triangle], edge->v)) continue;
        in->crossed[hit.triangle] = true;
        for (int k = 0; k < 2; k++)
            if (edge->triangle[k] != SN_NONE) in->crossed[edge->triangle[k]] = true;
    }
    for (int k = 0; k < 2; k++)
        if (edge->triangle[k] != SN_NONE) in->crossed[edge->triangle[k]] = true;
}

/* ---- patches ---------------------------------------------------------------------------------------------------------------------- */

/* Triangles reached from seed over edges of two, none of them crossed. patch (triangle_count); `boundary` marks what was reached. */
static sn_index flood(inner *in, sn_index seed, sn_index *patch) {
    sn_index size = 0;
    patch[size++] = seed;
    in->boundary[seed] = true;
    for (sn_index i = 0; i < size; i++) {
        for (int k = 0; k < 3; k++) {
            sn_index e = in->topology->triangle_edges[patch[i]][k];
            const sn_edge *edge = e != SN_NONE ? &in->topology->edges[e] : NULL;
            if (edge == NULL || edge->triangle_count != 2) continue;
            sn_index next = edge->triangle[edge->triangle[0] == patch[i]];
            if (in->boundary[next] || in->crossed[next]) continue;
            in->boundary[next] = true;
            patch[size++] = next;
        }
    }
    return size;
}

/* Of every patch, all triangles where a sample of them has an inner one. patch (triangle_count) */
static void list_doubtful(inner *in, sn_index *patch) {
    for (sn_index t = 0; t < in->mesh->triangle_count; t++)
        if (in->crossed[t]) in->ask[in->count++] = t;
    for (sn_index t = 0; t < in->mesh->triangle_count; t++) {
        if (in->boundary[t] || in->crossed[t]) continue;
        sn_index size = flood(in, t, patch), step = size > SAMPLES ? size / SAMPLES : 1;
        bool found = false;
        for (sn_index i = 0; i < size && !found; i += step) found = is_inner(in, in->mesh->triangles[patch[i]]);
        for (sn_index i = 0; i < size && found; i++) in->ask[in->count++] = patch[i];
    }
}

static sn_status find_boundary(inner *in, sn_pool *pool, sn_error *error) {
    sn_index *patch = SN_NEW(sn_index, in->mesh->triangle_count);
    if (patch == NULL) return sn_fail_memory(error, "the inside of a surface");
    for (sn_index e = 0; e < in->topology->edge_count; e++) mark_crossed(in, &in->topology->edges[e]);
    list_doubtful(in, patch);
    free(patch);
    sn_parallel_for(pool, in->count, GRAIN, judge, in);
    return SN_OK;
}

/* ---- all of it -------------------------------------------------------------------------------------------------------------------- */

/* sorted (triangle_count) */
static void sort_by_boundary(sn_mesh *mesh, const bool *boundary, sn_triangle *sorted, sn_solid_report *report) {
    sn_index count = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (sn_index t = 0; t < mesh->triangle_count; t++)
            if (boundary[t] == (pass == 0)) sorted[count++] = mesh->triangles[t];
        if (pass == 0) report->boundary_triangles = count;
    }
    report->inner_triangles = count - report->boundary_triangles;
    memcpy(mesh->triangles, sorted, (size_t)count * sizeof *sorted);
}

sn_status sn_sort_out_inner(sn_mesh *mesh, sn_pool *pool, sn_solid_report *report, sn_error *error) {
    sn_index count = mesh->triangle_count;
    inner in = {.mesh = mesh, .crossed = SN_NEW(bool, count), .ask = SN_NEW(sn_index, count), .boundary = SN_NEW(bool, count)};
    sn_mesh sorted = {.vertex_count = mesh->vertex_count, .positions = mesh->positions, .triangle_count = count};
    sorted.triangles = SN_NEW(sn_triangle, count);
    sn_topology topology = {0};
    sn_surface *surface = NULL;
    bool enough = in.crossed != NULL && in.ask != NULL && in.boundary != NULL && sorted.triangles != NULL;
    sn_status status = enough ? sn_topology_build(mesh, &topology, error) : sn_fail_memory(error, "the inside of a surface");
    if (status == SN_OK) status = sn_surface_create_plain(mesh, &surface, error);
    if (status == SN_OK) {
        memcpy(sorted.triangles, mesh->triangles, (size_t)count * sizeof *sorted.triangles);
        status = sn_winding_tree_build(&sorted, &in.tree, error);
        in.topology = &topology;
        in.surface = surface;
    }
    if (status == SN_OK) status = find_boundary(&in, pool, error);
    if (status == SN_OK) sort_by_boundary(mesh, in.boundary, sorted.triangles, report);
    sn_surface_destroy(surface);
    sn_topology_free(&topology);
    sn_winding_tree_free(&in.tree);
    free(in.crossed);
    free(in.ask);
    free(in.boundary);
    free(sorted.triangles);
    return status;
}
