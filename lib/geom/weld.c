/*
 * weld.c -- joining of vertices within a tolerance by a hashed grid; dropping of bad triangles and unused vertices.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"

/* ---- representatives ------------------------------------------------------------------------------------------------ */

/* Buckets of representatives, chained. With a tolerance the grid's cells are two tolerances wide: the ball around a point touches
 * at most two cells along each axis. */
typedef struct grid {
    const sn_vec3 *positions;
    sn_vec3 origin;
    double tolerance, cell;
    uint64_t mask;
    sn_index *head, *next; /* (mask + 1), (vertex_count) */
} grid;

/* Cells finer than this share of the box cannot be told apart in doubles. */
#define FINEST_CELL 1e-15

static uint64_t mix(uint64_t hash, uint64_t value) {
    hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
    return hash ^ (hash >> 29);
}

static uint64_t bits_of(double value) {
    double positive_zero = value + 0.0; /* -0 becomes 0 */
    uint64_t bits;
    memcpy(&bits, &positive_zero, sizeof bits);
    return bits;
}

static uint64_t exact_bucket(const grid *g, sn_vec3 p) { return mix(mix(mix(0, bits_of(p.x)), bits_of(p.y)), bits_of(p.z)) & g->mask; }

static uint64_t cell_bucket(const grid *g, double x, double y, double z) {
    return mix(mix(mix(0, (uint64_t)(int64_t)x), (uint64_t)(int64_t)y), (uint64_t)(int64_t)z) & g->mask;
}

static uint64_t own_bucket(const grid *g, sn_vec3 p) {
    if (g->tolerance <= 0.0) return exact_bucket(g, p);
    sn_vec3 q = sn_scale(sn_sub(p, g->origin), 1.0 / g->cell);
    return cell_bucket(g, floor(q.x), floor(q.y), floor(q.z));
}

/* Buckets that may hold a representative within reach of p; at most 8. */
static int buckets_near(const grid *g, sn_vec3 p, uint64_t buckets[8]) {
    if (g->tolerance <= 0.0) {
        buckets[0] = exact_bucket(g, p);
        return 1;
    }
    int count = 0;
    sn_vec3 q = sn_scale(sn_sub(p, g->origin), 1.0 / g->cell);
    double reach = g->tolerance / g->cell * (1.0 + 1e-9);
    sn_vec3 low = sn_v3(floor(q.x - reach), floor(q.y - reach), floor(q.z - reach));
    sn_vec3 high = sn_v3(floor(q.x + reach), floor(q.y + reach), floor(q.z + reach));
    for (double x = low.x; x <= high.x && x <= low.x + 1.0; x += 1.0) {
        for (double y = low.y; y <= high.y && y <= low.y + 1.0; y += 1.0) {
            for (double z = low.z; z <= high.z && z <= low.z + 1.0; z += 1.0) buckets[count++] = cell_bucket(g, x, y, z);
        }
    }
    return count;
}

static sn_index lowest_within_reach(const grid *g, sn_vec3 p) {
    uint64_t buckets[8];
    int count = buckets_near(g, p, buckets);
    sn_index lowest = SN_NONE;
    for (int b = 0; b < count; b++) {
        for (sn_index r = g->head[buckets[b]]; r != SN_NONE; r = g->next[r]) {
            bool nearer = sn_norm2(sn_sub(g->positions[r], p)) <= g->tolerance * g->tolerance;
            if (nearer && (lowest == SN_NONE || r < lowest)) lowest = r;
        }
    }
    return lowest;
}

static sn_status grid_create(const sn_mesh *mesh, double tolerance, grid *g, sn_error *error) {
    sn_box box = sn_mesh_box(mesh);
    size_t buckets = 16;
    while (buckets < 2 * (size_t)mesh->vertex_count) buckets *= 2;
    *g = (grid){.positions = mesh->positions, .origin = box.low, .tolerance = tolerance, .mask = buckets - 1};
    g->cell = fmax(2.0 * tolerance, FINEST_CELL * sn_box_diagonal(box));
    g->head = SN_NEW(sn_index, buckets);
    g->next = SN_NEW(sn_index, mesh->vertex_count);
    if (g->head != NULL && g->next != NULL) {
        memset(g->head, 0xff, buckets * sizeof *g->head); /* SN_NONE */
        return SN_OK;
    }
    free(g->head);
    free(g->next);
    return sn_fail_memory(error, "welding");
}

sn_status sn_find_representatives(const sn_mesh *mesh, double tolerance, sn_index *representative, sn_error *error) {
    grid g;
    sn_status status = grid_create(mesh, tolerance, &g, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_index found = lowest_within_reach(&g, mesh->positions[i]);
        representative[i] = found != SN_NONE ? found : i;
        if (found != SN_NONE) continue;
        uint64_t bucket = own_bucket(&g, mesh->positions[i]);
        g.next[i] = g.head[bucket];
        g.head[bucket] = i;
    }
    free(g.head);
    free(g.next);
    return SN_OK;
}

/* ---- weld ----------------------------------------------------------------------------------------------------------- */

sn_status sn_drop_collapsed(sn_mesh *mesh, sn_error *error) {
    bool *keep = SN_NEW(bool, mesh->triangle_count);
    if (keep == NULL) return sn_fail_memory(error, "welding");
    for (sn_index t = 0; t < mesh->triangle_count; t++) keep[t] = !sn_triangle_repeats_index(mesh->triangles[t]);
    sn_mesh_keep_triangles(mesh, keep);
    free(keep);
    return SN_OK;
}

sn_index sn_number_representatives(sn_index count, sn_index *map) {
    sn_index next = 0;
    for (sn_index i = 0; i < count; i++) map[i] = map[i] == i ? next++ : map[map[i]];
    return next;
}

sn_status sn_weld(sn_mesh *mesh, double tolerance, sn_index *welded, sn_index *new_index, sn_error *error) {
    *welded = 0;
    sn_index before = mesh->vertex_count;
    sn_index *map = SN_NEW(sn_index, before);
    if (map == NULL) return sn_fail_memory(error, "welding");
    sn_status status = sn_find_representatives(mesh, tolerance, map, error);
    if (status == SN_OK) {
        sn_index count = sn_number_representatives(before, map);
        *welded = before - count;
        if (new_index != NULL && before > 0) memcpy(new_index, map, (size_t)before * sizeof *map);
        if (count < before) {
            sn_mesh_renumber(mesh, map, count);
            status = sn_drop_collapsed(mesh, error);
        }
    }
    free(map);
    return status;
}

/* ---- bad triangles -------------------------------------------------------------------------------------------------- */

static sn_status mark_first_of_triples(const sn_mesh *mesh, bool *keep, sn_index *dropped, sn_error *error) {
    sn_index count = mesh->triangle_count;
    sn_index *order = SN_NEW(sn_index, count);
    sn_triangle *triples = SN_NEW(sn_triangle, count);
    sn_status status = order != NULL && triples != NULL ? sn_sort_triples(mesh, order, triples, error)
                                                        : sn_fail_memory(error, "finding duplicate triangles");
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        keep[order[i]] = i == 0 || !sn_same_triple(triples[order[i - 1]], triples[order[i]]);
        if (!keep[order[i]]) (*dropped)++;
    }
    free(order);
    free(triples);
    return status;
}

static sn_triangle with_corner(sn_triangle t, sn_index from, sn_index to) {
    for (int k = 0; k < 3; k++) {
        if (t.v[k] == from) t.v[k] = to;
    }
    return t;
}

/* A triangle without area whose middle corner lies on its longest edge: splitting the neighbour across that edge at the corner
 * takes its place, and the surface stays closed. false = not possible here. */
static bool flip_cap(sn_mesh *mesh, const sn_topology *topology, sn_index t, bool *touched) {
    sn_triangle cap = mesh->triangles[t];
    int k = sn_triangle_longest_edge(mesh, cap);
    const sn_edge *edge = &topology->edges[topology->triangle_edges[t][k]];
    if (edge->triangle_count != 2) return false;
    int other = edge->triangle[0] == t ? 1 : 0;
    sn_index neighbour = edge->triangle[other], apex = edge->opposite[other];
    sn_index middle = cap.v[k], a = cap.v[(k + 1) % 3], b = cap.v[(k + 2) % 3];
    if (touched[middle] || touched[a] || touched[b] || touched[apex]) return false;
    if (apex == middle || sn_topology_edge(topology, middle, apex) != SN_NONE) return false;
    sn_triangle first = with_corner(mesh->triangles[neighbour], a, middle), second = with_corner(mesh->triangles[neighbour], b, middle);
    if (sn_triangle_is_degenerate(mesh, first) || sn_triangle_is_degenerate(mesh, second)) return false;
    mesh->triangles[t] = first;
    mesh->triangles[neighbour] = second;
    touched[middle] = touched[a] = touched[b] = touched[apex] = true;
    return true;
}

static sn_index count_degenerate(const sn_mesh *mesh) {
    sn_index count = 0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) count += sn_triangle_is_degenerate(mesh, mesh->triangles[t]);
    return count;
}

/* One round of flips: triangles around a flip wait for the next round, where the adjacency is right again. */
static sn_status flip_caps(sn_mesh *mesh, sn_index *flipped, sn_error *error) {
    *flipped = 0;
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    bool *touched = SN_NEW(bool, mesh->vertex_count);
    for (sn_index t = 0; touched != NULL && t < mesh->triangle_count; t++) {
        if (sn_triangle_is_degenerate(mesh, mesh->triangles[t]) && !sn_triangle_repeats_index(mesh->triangles[t])) {
            *flipped += flip_cap(mesh, &topology, t, touched);
        }
    }
    sn_topology_free(&topology);
    if (touched == NULL) return sn_fail_memory(error, "flipping edges");
    free(touched);
    return SN_OK;
}

#define MOST_FLIP_ROUNDS 16

static sn_status replace_degenerate(sn_mesh *mesh, sn_index *degenerate, bool *keep, sn_error *error) {
    *degenerate = count_degenerate(mesh);
    sn_index left = *degenerate, flipped = 1;
    sn_status status = SN_OK;
    for (int round = 0; status == SN_OK && left > 0 && flipped > 0 && round < MOST_FLIP_ROUNDS; round++) {
        status = flip_caps(mesh, &flipped, error);
        left = count_degenerate(mesh);
    }
    if (status != SN_OK || left == 0) return status;
    for (sn_index t = 0; t < mesh->triangle_count; t++) keep[t] = !sn_triangle_is_degenerate(mesh, mesh->triangles[t]);
    sn_mesh_keep_triangles(mesh, keep);
    return SN_OK;
}

sn_status sn_drop_bad_triangles(sn_mesh *mesh, sn_index *degenerate, sn_index *duplicate, sn_error *error) {
    *degenerate = *duplicate = 0;
    bool *keep = SN_NEW(bool, mesh->triangle_count);
    if (keep == NULL) return sn_fail_memory(error, "dropping triangles");
    sn_status status = mark_first_of_triples(mesh, keep, duplicate, error);
    if (status == SN_OK && *duplicate > 0) sn_mesh_keep_triangles(mesh, keep);
    if (status == SN_OK) status = replace_degenerate(mesh, degenerate, keep, error);
    free(keep);
    return status;
}

/* ---- vertices ------------------------------------------------------------------------------------------------------- */

/* Keep the vertices that are marked with anything but SN_NONE. */
static sn_index keep_marked(sn_mesh *mesh, sn_index *mark) {
    sn_index count = 0, before = mesh->vertex_count;
    for (sn_index i = 0; i < before; i++) {
        if (mark[i] != SN_NONE) mark[i] = count++;
    }
    if (count < before) sn_mesh_renumber(mesh, mark, count);
    return before - count;
}

sn_status sn_drop_unused_vertices(sn_mesh *mesh, sn_index *dropped, sn_error *error) {
    *dropped = 0;
    sn_index *mark = SN_NEW(sn_index, mesh->vertex_count);
    if (mark == NULL) return sn_fail_memory(error, "dropping vertices");
    for (sn_index i = 0; i < mesh->vertex_count; i++) mark[i] = SN_NONE;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) mark[mesh->triangles[t].v[k]] = 0;
    }
    *dropped = keep_marked(mesh, mark);
    free(mark);
    return SN_OK;
}

sn_status sn_drop_nonfinite_vertices(sn_mesh *mesh, sn_index *dropped, sn_error *error) {
    *dropped = 0;
    sn_index *mark = SN_NEW(sn_index, mesh->vertex_count);
    bool *keep = SN_NEW(bool, mesh->triangle_count);
    if (mark != NULL && keep != NULL) {
        for (sn_index i = 0; i < mesh->vertex_count; i++) mark[i] = sn_finite3(mesh->positions[i]) ? 0 : SN_NONE;
        for (sn_index t = 0; t < mesh->triangle_count; t++) {
            const sn_index *v = mesh->triangles[t].v;
            keep[t] = mark[v[0]] != SN_NONE && mark[v[1]] != SN_NONE && mark[v[2]] != SN_NONE;
        }
        sn_mesh_keep_triangles(mesh, keep);
        *dropped = keep_marked(mesh, mark);
    }
    sn_status status = mark != NULL && keep != NULL ? SN_OK : sn_fail_memory(error, "dropping vertices");
    free(mark);
    free(keep);
    return status;
}
