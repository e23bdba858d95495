/*
 * cracks.c -- closing of cracks: borders that run side by side are joined, vertex to vertex or vertex to edge.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"
#include "order.h"

/* A crack is narrower than this share of the shortest of the edges on its two sides. */
#define NARROW 0.25
/* Every round joins vertices or splits edges for good; joining opens the way to the next. */
#define MOST_ROUNDS 8
/* Cells finer than this share of the box cannot be told apart in doubles. */
#define FINEST_CELL 1e-15

/* The border edges, found again by a hashed grid of points along them, half a cell apart. */
typedef struct borders {
    const sn_mesh *mesh;
    sn_topology topology;
    sn_index edge_count;
    sn_index *edges;  /* (edge_count) of the topology */
    double *shortest; /* (vertex_count) of the border edges at a vertex; INFINITY off the border */
    double tolerance; /* 0 = by NARROW */
    double cell;
    sn_vec3 origin;
    uint64_t mask;
    size_t entry_count, entry_capacity;
    int64_t *head; /* (mask + 1) last entry of a bucket; -1 = none */
    struct entry {
        sn_index edge;
        int64_t next;
    } * entries;
} borders;

/* What a border vertex lies next to: an edge that is not its own, at `share` of the way along it. */
typedef struct neighbour {
    sn_index edge;
    double share, distance;
} neighbour;

static void borders_free(borders *b) {
    sn_topology_free(&b->topology);
    free(b->edges);
    free(b->shortest);
    free(b->head);
    free(b->entries);
}

static double length_of(const borders *b, sn_index e) {
    const sn_index *v = b->topology.edges[e].v;
    return sn_distance(b->mesh->positions[v[0]], b->mesh->positions[v[1]]);
}

/* ---- the grid ----------------------------------------------------------------------------------------------------------- */

static uint64_t bucket_of(const borders *b, double x, double y, double z) {
    uint64_t hash = (uint64_t)(int64_t)x * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 29) ^ (uint64_t)(int64_t)y) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ (hash >> 29) ^ (uint64_t)(int64_t)z) * 0x94d049bb133111ebu;
    return (hash ^ (hash >> 29)) & b->mask;
}

static sn_vec3 cell_of(const borders *b, sn_vec3 p) {
    sn_vec3 q = sn_scale(sn_sub(p, b->origin), 1.0 / b->cell);
    return sn_v3(floor(q.x), floor(q.y), floor(q.z));
}

static bool enter_edge(borders *b, sn_index e) {
    const sn_index *v = b->topology.edges[e].v;
    double steps = ceil(2.0 * length_of(b, e) / b->cell);
    for (double i = 0.0; i <= steps; i += 1.0) {
        sn_vec3 at = cell_of(b, sn_lerp(b->mesh->positions[v[0]], b->mesh->positions[v[1]], steps > 0.0 ? i / steps : 0.0));
        uint64_t bucket = bucket_of(b, at.x, at.y, at.z);
        if (b->head[bucket] >= 0 && b->entries[b->head[bucket]].edge == e) continue;
        if (!sn_grow((void **)&b->entries, &b->entry_capacity, b->entry_count + 1, sizeof *b->entries)) return false;
        b->entries[b->entry_count] = (struct entry){e, b->head[bucket]};
        b->head[bucket] = (int64_t)b->entry_count++;
    }
    return true;
}

/* The mean length keeps the number of entries linear in the edges, however long the longest is. */
static bool enter_edges(borders *b) {
    double sum = 0.0;
    for (sn_index i = 0; i < b->edge_count; i++) sum += length_of(b, b->edges[i]);
    sn_box box = sn_mesh_box(b->mesh);
    b->cell = fmax(fmax(sum / b->edge_count, 4.0 * b->tolerance), FINEST_CELL * sn_box_diagonal(box));
    b->origin = box.low;
    size_t buckets = 16;
    while (buckets < 4 * (size_t)b->edge_count) buckets *= 2;
    b->mask = buckets - 1;
    b->head = SN_NEW(int64_t, buckets);
    if (b->head == NULL || !(b->cell > 0.0)) return b->head != NULL;
    memset(b->head, 0xff, buckets * sizeof *b->head);
    for (sn_index i = 0; i < b->edge_count; i++) {
        if (!enter_edge(b, b->edges[i])) return false;
    }
    return true;
}

static void take_edge(borders *b, sn_index e) {
    double length = length_of(b, e);
    for (int k = 0; k < 2; k++) {
        double *shortest = &b->shortest[b->topology.edges[e].v[k]];
        *shortest = fmin(*shortest, length);
    }
    b->edges[b->edge_count++] = e;
}

static sn_status borders_create(const sn_mesh *mesh, double tolerance, borders *b, sn_error *error) {
    *b = (borders){.mesh = mesh, .tolerance = tolerance};
    sn_status status = sn_topology_build(mesh, &b->topology, error);
    if (status != SN_OK) return status;
    b->edges = SN_NEW(sn_index, b->topology.edge_count);
    b->shortest = SN_NEW(double, mesh->vertex_count);
    bool enough = b->edges != NULL && b->shortest != NULL;
    for (sn_index v = 0; enough && v < mesh->vertex_count; v++) b->shortest[v] = INFINITY;
    for (sn_index e = 0; enough && e < b->topology.edge_count; e++) {
        if (b->topology.edges[e].triangle_count == 1) take_edge(b, e);
    }
    if (enough && b->edge_count > 0) enough = enter_edges(b);
    if (enough) return SN_OK;
    borders_free(b);
    return sn_fail_memory(error, "closing cracks");
}

/* ---- nearest borders ------------------------------------------------------------------------------------------------------ */

static void try_edge(const borders *b, sn_index v, sn_index e, neighbour *best) {
    const sn_edge *edge = &b->topology.edges[e];
    if (edge->v[0] == v || edge->v[1] == v || edge->opposite[0] == v) return;
    sn_vec3 from = b->mesh->positions[edge->v[0]], along = sn_sub(b->mesh->positions[edge->v[1]], from);
    double square = sn_norm2(along), share = 0.0;
    if (square > 0.0) share = fmin(1.0, fmax(0.0, sn_dot(sn_sub(b->mesh->positions[v], from), along) / square));
    double distance = sn_distance(b->mesh->positions[v], sn_add_scaled(from, along, share));
    double reach = b->tolerance > 0.0 ? b->tolerance : NARROW * fmin(b->shortest[v], fmin(sqrt(square), b->cell));
    bool nearer = best->edge == SN_NONE || distance < best->distance || (distance == best->distance && e < best->edge);
    if (distance <= reach && nearer) *best = (neighbour){e, share, distance};
}

/* The nearest border edge within reach; reaches are at most a quarter of a cell, and points along edges half a cell apart. */
static neighbour nearest_edge(const borders *b, sn_index v) {
    neighbour best = {.edge = SN_NONE};
    sn_vec3 at = cell_of(b, b->mesh->positions[v]);
    for (double x = at.x - 1.0; x <= at.x + 1.0; x += 1.0) {
        for (double y = at.y - 1.0; y <= at.y + 1.0; y += 1.0) {
            for (double z = at.z - 1.0; z <= at.z + 1.0; z += 1.0) {
                for (int64_t i = b->head[bucket_of(b, x, y, z)]; i >= 0; i = b->entries[i].next) try_edge(b, v, b->entries[i].edge, &best);
            }
        }
    }
    return best;
}

/* ---- joining -------------------------------------------------------------------------------------------------------------- */

/* A border vertex to be put into an edge. */
typedef struct insertion {
    sn_index edge, vertex;
    double share;
} insertion;

typedef struct plan {
    sn_index *set; /* (vertex_count) disjoint sets of vertices to be joined */
    insertion *insertions;
    sn_index joined, insertion_count;
    double widest;
} plan;

/* The end of the edge that v may be joined with: within the same reach as the edge itself. SN_NONE = neither. */
static sn_index near_end(const borders *b, sn_index v, neighbour n) {
    const sn_edge *edge = &b->topology.edges[n.edge];
    sn_index end = edge->v[n.share < 0.5 ? 0 : 1];
    double reach = b->tolerance > 0.0 ? b->tolerance : NARROW * fmin(b->shortest[v], b->shortest[end]);
    return sn_distance(b->mesh->positions[v], b->mesh->positions[end]) <= reach ? end : SN_NONE;
}

static void plan_vertex(const borders *b, sn_index v, plan *p) {
    neighbour n = nearest_edge(b, v);
    if (n.edge == SN_NONE) return;
    sn_index end = near_end(b, v, n);
    if (end == SN_NONE && n.share > 0.0 && n.share < 1.0) {
        p->insertions[p->insertion_count++] = (insertion){n.edge, v, n.share};
    } else if (end != SN_NONE && sn_topology_edge(&b->topology, v, end) == SN_NONE && sn_set_find(p->set, v) != sn_set_find(p->set, end)) {
        sn_set_join(p->set, v, end);
        p->joined++;
    } else {
        return;
    }
    p->widest = fmax(p->widest, n.distance);
}

static int along_edges(const void *left, const void *right) {
    const insertion *a = left, *b = right;
    if (a->edge != b->edge) return a->edge < b->edge ? -1 : 1;
    if (a->share != b->share) return a->share < b->share ? -1 : 1;
    return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

/* Split the triangle t at vertex v on its edge (from, to): t keeps the part at `from`, a new triangle gets the rest. */
static void split_triangle(sn_mesh *mesh, sn_index *t, sn_index to, sn_index from, sn_index v) {
    sn_triangle near = mesh->triangles[*t], far = near;
    for (int k = 0; k < 3; k++) {
        if (near.v[k] == to) near.v[k] = v;
        if (far.v[k] == from) far.v[k] = v;
    }
    mesh->triangles[*t] = near;
    if (mesh->triangle_group != NULL) mesh->triangle_group[mesh->triangle_count] = mesh->triangle_group[*t];
    *t = mesh->triangle_count++;
    mesh->triangles[*t] = far;
}

/* One edge of a triangle in a round: the others wait for adjacency to be right again. Returns how many vertices went in. */
static sn_index insert_vertices(sn_mesh *mesh, const borders *b, const plan *p, bool *touched) {
    sn_index inserted = 0;
    for (sn_index i = 0, end; i < p->insertion_count; i = end) {
        const sn_edge *edge = &b->topology.edges[p->insertions[i].edge];
        sn_index t = edge->triangle[0], from = edge->v[0];
        for (end = i; end < p->insertion_count && p->insertions[end].edge == p->insertions[i].edge;) end++;
        if (touched[t]) continue;
        touched[t] = true;
        for (sn_index j = i; j < end; j++) {
            sn_index v = p->insertions[j].vertex;
            if (p->set[v] != v || v == from) continue; /* joined with a neighbour instead */
            split_triangle(mesh, &t, edge->v[1], from, v);
            from = v;
            inserted++;
        }
    }
    return inserted;
}

static sn_status carry_out(sn_mesh *mesh, const borders *b, plan *p, sn_index *changed, sn_error *error) {
    bool *touched = SN_NEW(bool, mesh->triangle_count);
    bool enough = touched != NULL && sn_mesh_make_room(mesh, 0, p->insertion_count);
    if (enough) {
        qsort(p->insertions, (size_t)p->insertion_count, sizeof *p->insertions, along_edges);
        *changed = p->joined + insert_vertices(mesh, b, p, touched);
        if (p->joined > 0) sn_mesh_renumber(mesh, p->set, sn_number_representatives(mesh->vertex_count, p->set));
    }
    free(touched);
    return enough ? sn_drop_collapsed(mesh, error) : sn_fail_memory(error, "closing cracks");
}

static sn_status close_round(sn_mesh *mesh, double tolerance, sn_crack_report *report, sn_index *changed, sn_error *error) {
    *changed = 0;
    borders b;
    sn_status status = borders_create(mesh, tolerance, &b, error);
    if (status != SN_OK) return status;
    plan p = {.set = SN_NEW(sn_index, mesh->vertex_count), .insertions = SN_NEW(insertion, mesh->vertex_count)};
    if (p.set == NULL || p.insertions == NULL) status = sn_fail_memory(error, "closing cracks");
    for (sn_index v = 0; status == SN_OK && v < mesh->vertex_count; v++) p.set[v] = v;
    for (sn_index v = 0; status == SN_OK && v < mesh->vertex_count && b.cell > 0.0; v++) {
        if (isfinite(b.shortest[v])) plan_vertex(&b, v, &p);
    }
    for (sn_index v = 0; status == SN_OK && v < mesh->vertex_count; v++) p.set[v] = sn_set_find(p.set, v);
    if (status == SN_OK && p.joined + p.insertion_count > 0) status = carry_out(mesh, &b, &p, changed, error);
    report->vertices += *changed;
    report->widest = fmax(report->widest, p.widest);
    free(p.set);
    free(p.insertions);
    borders_free(&b);
    return status;
}

sn_status sn_close_cracks(sn_mesh *mesh, double tolerance, sn_crack_report *report, sn_error *error) {
    *report = (sn_crack_report){0};
    sn_status status = sn_mesh_validate(mesh, error);
    sn_index changed = 1;
    for (int round = 0; status == SN_OK && changed > 0 && mesh->triangle_count > 0 && round < MOST_ROUNDS; round++) {
        status = close_round(mesh, tolerance, report, &changed, error);
    }
    return status;
}
