/* tree.c -- the storage of the traversal tree, and what every traversal needs: distances from the roots and the sides of the roots. */
#include "tree.h"

#include <stdlib.h>

/* ---- storage ------------------------------------------------------------------------------------------------------------ */

/* Label the parts of the surface without the roots by their lowest vertex; stack has room for all vertices. */
static void label_parts(tree *t, const sn_roots *roots, sn_index *stack) {
    const sn_topology *topology = t->topology;
    for (sn_index v = 0; v < topology->vertex_count; v++) t->part[v] = SN_NONE;
    for (sn_index i = 0; i < roots->count; i++) t->part[roots->vertices[i]] = SN_INDEX_MAX;
    for (sn_index seed = 0; seed < topology->vertex_count; seed++) {
        if (t->part[seed] != SN_NONE) continue;
        sn_index top = 0;
        t->part[seed] = seed;
        stack[top++] = seed;
        while (top > 0) {
            sn_index v = stack[--top];
            for (sn_index k = topology->vertex_start[v]; k < topology->vertex_start[v + 1]; k++)
                if (t->part[topology->neighbours[k]] == SN_NONE) {
                    t->part[topology->neighbours[k]] = seed;
                    stack[top++] = topology->neighbours[k];
                }
        }
    }
}

sn_status tree_create(const sn_mesh *mesh, const sn_topology *topology, const sn_roots *roots, tree *out, sn_error *error) {
    size_t n = (size_t)mesh->vertex_count;
    sn_box box = sn_mesh_box(mesh);
    *out = (tree){.mesh = mesh, .topology = topology, .origin = sn_lerp(box.low, box.high, 0.5)};
    out->distance = SN_NEW(double, n);
    out->part = SN_NEW(sn_index, n);
    out->front = SN_NEW(sn_index, n);
    out->next = SN_NEW(sn_index, n);
    if (!out->distance || !out->part || !out->front || !out->next) {
        tree_free(out);
        return sn_fail_memory(error, "the traversal of the surface");
    }
    label_parts(out, roots, out->next);
    for (size_t v = 0; v < n; v++) out->front[v] = out->next[v] = SN_NONE;
    return sn_geodesic_distance(mesh, topology, roots->count, roots->vertices, out->distance, error);
}

sn_status tree_reserve(tree *t, sn_index fronts, sn_error *error) {
    size_t n = (size_t)fronts;
    t->parent = SN_NEW(sn_index, n);
    t->depth = SN_NEW(sn_index, n);
    t->side = SN_NEW(sn_index, n);
    t->first = SN_NEW(sn_index, n);
    t->last = SN_NEW(sn_index, n);
    t->weight = SN_NEW(double, n);
    t->sum = SN_NEW(sn_vec3, n);
    t->sum2 = SN_NEW(double, n);
    t->distance_sum = SN_NEW(double, n);
    t->reach = SN_NEW(double, n);
    bool enough = t->parent && t->depth && t->side && t->first && t->last && t->weight && t->sum && t->sum2 && t->distance_sum && t->reach;
    return enough ? SN_OK : sn_fail_memory(error, "the fronts of the traversal");
}

void tree_free(tree *t) {
    free(t->distance);
    free(t->part);
    free(t->front);
    free(t->next);
    free(t->parent);
    free(t->depth);
    free(t->side);
    free(t->first);
    free(t->last);
    free(t->weight);
    free(t->sum);
    free(t->sum2);
    free(t->distance_sum);
    free(t->reach);
    *t = (tree){0};
}

/* ---- fronts --------------------------------------------------------------------------------------------------------------- */

sn_index tree_add_front(tree *t, sn_index parent) {
    sn_index front = t->count++;
    t->parent[front] = parent;
    t->depth[front] = parent == SN_NONE ? 0 : t->depth[parent] + 1;
    t->side[front] = SN_INDEX_MAX;
    t->first[front] = t->last[front] = SN_NONE;
    return front;
}

void tree_add_vertex(tree *t, sn_index front, sn_index vertex) {
    if (t->first[front] == SN_NONE)
        t->first[front] = vertex;
    else
        t->next[t->last[front]] = vertex;
    t->last[front] = vertex;
    t->next[vertex] = SN_NONE;
    t->front[vertex] = front;
}

sn_vec3 tree_position(const tree *t, sn_index front) { return sn_add_scaled(t->origin, t->sum[front], 1.0 / t->weight[front]); }

double tree_radius(const tree *t, sn_index front) {
    double share = 1.0 / t->weight[front];
    return sqrt(fmax(0.0, t->sum2[front] * share - sn_norm2(sn_scale(t->sum[front], share))));
}

static void move_front(tree *t, sn_index from, sn_index to) {
    t->parent[to] = t->parent[from];
    t->side[to] = t->side[from];
    t->first[to] = t->first[from];
    t->last[to] = t->last[from];
    t->weight[to] = t->weight[from];
    t->sum[to] = t->sum[from];
    t->sum2[to] = t->sum2[from];
    t->distance_sum[to] = t->distance_sum[from];
    t->reach[to] = t->reach[from];
    for (sn_index v = t->first[to]; v != SN_NONE; v = t->next[v]) t->front[v] = to;
}

void tree_compact(tree *t) {
    sn_index *number = t->depth; /* the new numbers, until the depths are counted afresh */
    sn_index kept = 0;
    for (sn_index f = 0; f < t->count; f++)
        if (t->weight[f] > 0.0) number[f] = kept++;
    for (sn_index f = 0; f < t->count; f++)
        if (t->weight[f] > 0.0 && t->parent[f] != SN_NONE) t->parent[f] = number[t->parent[f]];
    for (sn_index f = 0, to = 0; f < t->count; f++)
        if (t->weight[f] > 0.0) move_front(t, f, to++);
    t->count = kept;
    for (sn_index f = 0; f < kept; f++) t->depth[f] = t->parent[f] == SN_NONE ? 0 : t->depth[t->parent[f]] + 1;
}
