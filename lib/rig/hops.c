/* hops.c -- the front that runs over the surface from the roots, splitting where it falls apart ([R18] 3.1, figure 1). */
#include <stdlib.h>

#include "tree.h"

/* ---- traversal ---------------------------------------------------------------------------------------------------------- */

typedef struct traversal {
    tree *tree;
    sn_index layer;      /* hops from the roots of the vertices being visited */
    sn_index *hops;      /* (vertex_count) SN_NONE = not seen */
    sn_index *votes;     /* (vertex_count) shared edges by front; all 0 between uses */
    sn_index *seen;      /* (vertex_count) vertices of the layer, ascending */
    sn_index *component; /* (vertex_count) vertices of one component of it */
    sn_index seen_count;
} traversal;

static bool traversal_alloc(traversal *r, tree *t) {
    size_t n = (size_t)t->mesh->vertex_count;
    *r = (traversal){.tree = t};
    r->hops = SN_NEW(sn_index, n);
    r->votes = SN_NEW(sn_index, n);
    r->seen = SN_NEW(sn_index, n);
    r->component = SN_NEW(sn_index, n);
    if (!r->hops || !r->votes || !r->seen || !r->component) return false;
    for (size_t v = 0; v < n; v++) r->hops[v] = SN_NONE;
    return true;
}

static void traversal_free(traversal *r) {
    free(r->hops);
    free(r->votes);
    free(r->seen);
    free(r->component);
}

static int compare_indices(const void *left, const void *right) {
    sn_index a = *(const sn_index *)left, b = *(const sn_index *)right;
    return (a > b) - (a < b);
}

/* From the vertices of one layer to those of the next. */
static void advance(traversal *r, sn_index *before, sn_index before_count) {
    const sn_topology *t = r->tree->topology;
    r->layer++;
    r->seen_count = 0;
    for (sn_index i = 0; i < before_count; i++)
        for (sn_index k = t->vertex_start[before[i]]; k < t->vertex_start[before[i] + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (r->hops[w] != SN_NONE) continue;
            r->hops[w] = r->layer;
            r->seen[r->seen_count++] = w;
        }
    qsort(r->seen, (size_t)r->seen_count, sizeof *r->seen, compare_indices);
}

/* The vertices of the layer that hang together with seed; marked by the front's number to come. */
static sn_index collect_component(traversal *r, sn_index seed) {
    const sn_topology *t = r->tree->topology;
    sn_index count = 0;
    r->component[count++] = seed;
    r->tree->front[seed] = r->tree->count;
    for (sn_index i = 0; i < count; i++)
        for (sn_index k = t->vertex_start[r->component[i]]; k < t->vertex_start[r->component[i] + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (r->hops[w] != r->layer || r->tree->front[w] != SN_NONE) continue;
            r->tree->front[w] = r->tree->count;
            r->component[count++] = w;
        }
    return count;
}

/* The front of the layer before that shares most edges with the component; ties to the lower index. */
static sn_index find_parent(traversal *r, sn_index count) {
    const sn_topology *t = r->tree->topology;
    sn_index best = SN_NONE;
    for (int pass = 0; pass < 2; pass++) /* count, then clear */
        for (sn_index i = 0; i < count; i++)
            for (sn_index k = t->vertex_start[r->component[i]]; k < t->vertex_start[r->component[i] + 1]; k++) {
                sn_index w = t->neighbours[k], f = r->tree->front[w];
                if (r->hops[w] != r->layer - 1) continue;
                sn_index votes = pass == 0 ? ++r->votes[f] : (r->votes[f] = 0);
                if (pass == 1) continue;
                if (best == SN_NONE || votes > r->votes[best] || (votes == r->votes[best] && f < best)) best = f;
            }
    return best;
}

static void weigh_vertex(tree *t, sn_index front, sn_index vertex) {
    sn_vec3 p = sn_sub(t->mesh->positions[vertex], t->origin);
    tree_add_vertex(t, front, vertex);
    t->weight[front] += 1.0;
    t->sum[front] = sn_add(t->sum[front], p);
    t->sum2[front] += sn_norm2(p);
    t->distance_sum[front] += t->distance[vertex];
    t->reach[front] = fmax(t->reach[front], t->distance[vertex]);
}

static bool add_front(traversal *r, sn_index parent, sn_index count, sn_trace *trace) {
    tree *t = r->tree;
    sn_index front = tree_add_front(t, parent);
    t->side[front] = t->part[r->component[0]];
    for (sn_index i = 0; i < count; i++) weigh_vertex(t, front, r->component[i]);
    sn_vec3 p = tree_position(t, front);
    return SN_TRACE(trace, "front", sn_trace_number("sample", front), sn_trace_number("parent", parent), sn_trace_number("hops", r->layer),
                    sn_trace_number("x", p.x), sn_trace_number("y", p.y), sn_trace_number("z", p.z),
                    sn_trace_indices("vertices", r->component, count));
}

static bool start_at_roots(traversal *r, const sn_roots *roots, sn_trace *trace) {
    for (sn_index i = 0; i < roots->count; i++) {
        sn_index v = roots->vertices[i];
        if (r->hops[v] == 0) continue; /* given twice */
        r->hops[v] = 0;
        r->component[r->seen_count] = r->seen[r->seen_count] = v;
        r->seen_count++;
    }
    return add_front(r, SN_NONE, r->seen_count, trace);
}

static sn_status run(traversal *r, const sn_roots *roots, sn_trace *trace) {
    if (start_at_roots(r, roots, trace)) return SN_STOPPED;
    while (r->seen_count > 0) {
        sn_index *before = r->component; /* free between layers */
        for (sn_index i = 0; i < r->seen_count; i++) before[i] = r->seen[i];
        advance(r, before, r->seen_count);
        for (sn_index i = 0; i < r->seen_count; i++) {
            if (r->tree->front[r->seen[i]] != SN_NONE) continue;
            sn_index count = collect_component(r, r->seen[i]);
            if (add_front(r, find_parent(r, count), count, trace)) return SN_STOPPED;
        }
    }
    return SN_OK;
}

sn_status traverse_hops(tree *t, const sn_roots *roots, sn_trace *trace, sn_error *error) {
    traversal r;
    sn_status status = tree_reserve(t, t->mesh->vertex_count, error);
    if (!traversal_alloc(&r, t)) status = sn_fail_memory(error, "the traversal of the surface");
    if (!status) status = run(&r, roots, trace);
    traversal_free(&r);
    return status;
}
