/*
 * windings.c -- winding numbers of many points at once: for each point, the signed count of triangles above it. Points are sorted by x and
 * each triangle looks only at those in its range: near linear, unlike solid angles. Exact on closed surfaces save for points within
 * rounding of a projected edge: each shared edge is evaluated in one fixed order, so that neighbours agree on which of them covers a point.
 */
#include <stdlib.h>

#include "tree.h"

typedef struct query {
    double x;
    sn_index point;
} query;

static int compare_queries(const void *left, const void *right) {
    const query *a = left, *b = right;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    return (a->point > b->point) - (a->point < b->point);
}

static sn_index first_not_below(const query *queries, sn_index count, double x) {
    sn_index low = 0, high = count;
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        if (queries[middle].x < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* On which side of the edge a -> b, seen along z, does q lie? Opposite for b -> a, also where the cross product vanishes: then q is taken
 * to be a little off, the same way for all edges, so that those around a vertex agree too. */
static bool is_left(const sn_mesh *mesh, sn_index a, sn_index b, sn_vec3 q) {
    bool swap = a > b;
    sn_vec3 from = mesh->positions[swap ? b : a], to = mesh->positions[swap ? a : b];
    double cross = (to.x - from.x) * (q.y - from.y) - (to.y - from.y) * (q.x - from.x);
    if (cross == 0.0) cross = to.x != from.x ? to.x - from.x : from.y - to.y; /* as if q lay a little higher in y, and less in x */
    bool left = cross > 0.0;
    return left != swap;
}

int triangle_over(const sn_mesh *mesh, sn_triangle t, sn_vec3 q) {
    bool left = is_left(mesh, t.v[0], t.v[1], q);
    if (is_left(mesh, t.v[1], t.v[2], q) != left || is_left(mesh, t.v[2], t.v[0], q) != left) return 0;
    return left ? 1 : -1;
}

/* +1 or -1 where the triangle lies above q and faces up or down, else 0. */
static int covers(const sn_mesh *mesh, sn_triangle t, sn_vec3 q) {
    int facing = triangle_over(mesh, t, q);
    if (facing == 0) return 0;
    sn_vec3 a = mesh->positions[t.v[0]];
    sn_vec3 normal = sn_area_vector(a, mesh->positions[t.v[1]], mesh->positions[t.v[2]]);
    return facing * sn_dot(normal, sn_sub(q, a)) < 0.0 ? facing : 0;
}

static void count_triangle(const sn_mesh *mesh, sn_triangle t, const query *queries, sn_index count, const sn_vec3 *points, int *winding) {
    sn_vec3 a = mesh->positions[t.v[0]], b = mesh->positions[t.v[1]], c = mesh->positions[t.v[2]];
    sn_vec3 low = sn_min3(a, sn_min3(b, c)), high = sn_max3(a, sn_max3(b, c));
    for (sn_index i = first_not_below(queries, count, low.x); i < count && queries[i].x <= high.x; i++) {
        sn_vec3 q = points[queries[i].point];
        if (q.y < low.y || q.y > high.y || q.z > high.z) continue;
        winding[queries[i].point] += covers(mesh, t, q);
    }
}

sn_status count_windings(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, int *winding, sn_error *error) {
    query *queries = SN_NEW(query, count);
    if (!queries) return sn_fail_memory(error, "the test for points outside the surface");
    for (sn_index i = 0; i < count; i++) {
        queries[i] = (query){points[i].x, i};
        winding[i] = 0;
    }
    qsort(queries, (size_t)count, sizeof *queries, compare_queries);
    for (sn_index t = 0; t < mesh->triangle_count; t++) count_triangle(mesh, mesh->triangles[t], queries, count, points, winding);
    free(queries);
    return SN_OK;
}
