/*
 * surface_path.c -- nearly shortest paths over a surface, between points in its triangles.
 *
 * The graph: a few points inside every edge, joined to those on the other edges of the same triangle (Lanthier, Maheshwari & Sack 1997,
 * "Approximating weighted shortest paths on polyhedral surfaces"). Dijkstra's search with the straight distance to the goal as the
 * estimate (A*) looks at the neighbourhood of the path only. Vertices are not in the graph: a path passes each on one side or the other,
 * and a closed chain of paths parts the vertices by how often an edge is crossed. Within its triangles the path is then straightened.
 */
#include "sinew/geom.h"

#include <stdlib.h>

enum { POINTS = 4 }; /* inside each edge: enough to find the right triangles, up to 5 % too long before it is straightened */

typedef struct reached {
    double estimate; /* of the whole path's length */
    int64_t node;
} reached;

typedef struct node {
    double distance;
    int64_t from;   /* node before; START */
    sn_index via;   /* the triangle that it was reached through */
    sn_index round; /* of the search that set this; others are stale */
    bool done;
} node;

enum { START = -1 };

struct sn_path_finder {
    const sn_mesh *mesh;
    const sn_topology *topology;
    int64_t goal; /* the node behind all points: the path's end */
    node *nodes;  /* (goal + 1) */
    reached *queue;
    size_t queued, capacity;
    sn_index round;
    /* of the search under way */
    const sn_closest *to;
    double shift; /* of the points along their edges */
};

/* ---- the queue ------------------------------------------------------------------------------------------------------------- */

static bool comes_before(reached a, reached b) { return a.estimate < b.estimate || (a.estimate == b.estimate && a.node < b.node); }

static bool push(sn_path_finder *f, reached item) {
    void *queue = f->queue;
    if (!sn_grow(&queue, &f->capacity, f->queued + 1, sizeof *f->queue)) return false;
    f->queue = queue;
    size_t i = f->queued++;
    for (; i > 0 && comes_before(item, f->queue[(i - 1) / 2]); i = (i - 1) / 2) f->queue[i] = f->queue[(i - 1) / 2];
    f->queue[i] = item;
    return true;
}

static reached pop(sn_path_finder *f) {
    reached first = f->queue[0], last = f->queue[--f->queued];
    size_t i = 0;
    for (size_t child = 1; child < f->queued; child = 2 * i + 1) {
        if (child + 1 < f->queued && comes_before(f->queue[child + 1], f->queue[child])) child++;
        if (!comes_before(f->queue[child], last)) break;
        f->queue[i] = f->queue[child];
        i = child;
    }
    f->queue[i] = last;
    return first;
}

/* ---- the graph --------------------------------------------------------------------------------------------------------------- */

static sn_index edge_of(int64_t n) { return (sn_index)(n / POINTS); }

static sn_vec3 position(const sn_path_finder *f, int64_t n) {
    if (n == f->goal) return f->to->point;
    const sn_edge *edge = &f->topology->edges[edge_of(n)];
    double t = ((double)(n % POINTS) + 0.5 + f->shift) / POINTS;
    return sn_lerp(f->mesh->positions[edge->v[0]], f->mesh->positions[edge->v[1]], t);
}

static bool offer(sn_path_finder *f, int64_t n, int64_t from, sn_index via, double distance) {
    node *there = &f->nodes[n];
    if (there->round == f->round && !(distance < there->distance)) return true;
    *there = (node){.distance = distance, .from = from, .via = via, .round = f->round};
    return push(f, (reached){distance + sn_distance(position(f, n), f->to->point), n});
}

/* From a point at p, reached so far at `distance`, to all points on the edges of a triangle but `edge`, and to the goal if it is there. */
static bool cross_triangle(sn_path_finder *f, sn_index triangle, sn_index edge, sn_vec3 p, int64_t from, double distance) {
    if (triangle == f->to->triangle && !offer(f, f->goal, from, triangle, distance + sn_distance(p, f->to->point))) return false;
    for (int k = 0; k < 3; k++) {
        sn_index e = f->topology->triangle_edges[triangle][k];
        if (e == edge || e == SN_NONE) continue;
        for (int64_t n = (int64_t)e * POINTS; n < ((int64_t)e + 1) * POINTS; n++)
            if (!offer(f, n, from, triangle, distance + sn_distance(p, position(f, n)))) return false;
    }
    return true;
}

/* Go on from a point into the triangle beyond it. */
static bool expand(sn_path_finder *f, int64_t n) {
    const node *here = &f->nodes[n];
    const sn_edge *edge = &f->topology->edges[edge_of(n)];
    for (int side = 0; side < 2; side++) {
        sn_index triangle = edge->triangle[side];
        if (triangle == SN_NONE || triangle == here->via) continue;
        if (!cross_triangle(f, triangle, edge_of(n), position(f, n), n, here->distance)) return false;
    }
    return true;
}

static sn_status search(sn_path_finder *f, const sn_closest *from, sn_error *error) {
    bool enough = cross_triangle(f, from->triangle, SN_NONE, from->point, START, 0.0);
    while (enough && f->queued > 0) {
        reached next = pop(f);
        if (f->nodes[next.node].done) continue; /* a longer way to it */
        f->nodes[next.node].done = true;
        if (next.node == f->goal) return SN_OK;
        enough = expand(f, next.node);
    }
    if (!enough) return sn_fail_memory(error, "a path over a surface");
    return sn_fail(error, SN_ERROR_INPUT, "the two points lie on parts of the surface that are not connected");
}

/* ---- the result ---------------------------------------------------------------------------------------------------------------- */

/* The nodes from the goal back to the start make the segments, last first. */
static sn_status trace_back(const sn_path_finder *f, const sn_closest *from, sn_surface_path *out, sn_error *error) {
    sn_index count = 0;
    for (int64_t n = f->goal; n != START; n = f->nodes[n].from) count++;
    out->segments = SN_NEW(sn_path_segment, count);
    if (out->segments == NULL) return sn_fail_memory(error, "a path over a surface");
    out->count = count;
    out->length = f->nodes[f->goal].distance;
    for (int64_t n = f->goal; n != START; n = f->nodes[n].from) {
        int64_t before = f->nodes[n].from;
        sn_index leaves_by = n == f->goal ? SN_NONE : edge_of(n);
        out->segments[--count] =
            (sn_path_segment){f->nodes[n].via, leaves_by, before == START ? from->point : position(f, before), position(f, n)};
    }
    return SN_OK;
}

/* ---- straightening -------------------------------------------------------------------------------------------------------------- */

enum { SWEEPS = 32 };

/* Where the straight way from p to q crosses the line from a to b once both triangles lie flat: 0 at a, 1 at b. */
static double crossing_of(sn_vec3 p, sn_vec3 q, sn_vec3 a, sn_vec3 b) {
    sn_vec3 along = sn_sub(b, a);
    double length2 = fmax(sn_norm2(along), 1e-300);
    double tp = sn_dot(sn_sub(p, a), along) / length2, tq = sn_dot(sn_sub(q, a), along) / length2;
    double hp = sn_distance(p, sn_add_scaled(a, along, tp)), hq = sn_distance(q, sn_add_scaled(a, along, tq));
    return hp + hq > 0.0 ? (tp * hq + tq * hp) / (hp + hq) : 0.5 * (tp + tq);
}

/* Each point goes to where the straight way between its neighbours crosses its edge, again and again; it stays inside the edge, at a
 * margin of the search's own, so that paths do not come to share a point. */
static void straighten(const sn_path_finder *f, sn_surface_path *path) {
    double margin = 0.02 * (1.0 + f->shift);
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (sn_index i = 0; i + 1 < path->count; i++) {
            sn_path_segment *s = &path->segments[i];
            const sn_edge *edge = &f->topology->edges[s->edge];
            sn_vec3 a = f->mesh->positions[edge->v[0]], b = f->mesh->positions[edge->v[1]];
            double t = fmin(fmax(crossing_of(s->from, s[1].to, a, b), margin), 1.0 - margin);
            s->to = s[1].from = sn_lerp(a, b, t);
        }
    path->length = 0.0;
    for (sn_index i = 0; i < path->count; i++) path->length += sn_distance(path->segments[i].from, path->segments[i].to);
}

sn_status sn_path_find(sn_path_finder *f, const sn_closest *from, const sn_closest *to, sn_index turn, sn_surface_path *out,
                       sn_error *error) {
    *out = (sn_surface_path){0};
    f->queued = 0;
    f->round++;
    f->to = to;
    f->shift = 0.6 * (fmod(0.5 + turn * 0.6180339887498949, 1.0) - 0.5); /* golden section: far apart for turns that follow each other */
    sn_status status = search(f, from, error);
    if (status == SN_OK) status = trace_back(f, from, out, error);
    if (status == SN_OK) straighten(f, out);
    return status;
}

sn_status sn_path_finder_create(const sn_mesh *mesh, const sn_topology *topology, sn_path_finder **out, sn_error *error) {
    *out = NULL;
    sn_path_finder *f = SN_NEW(sn_path_finder, 1);
    if (f == NULL) return sn_fail_memory(error, "paths over a surface");
    *f = (sn_path_finder){.mesh = mesh, .topology = topology, .goal = (int64_t)topology->edge_count * POINTS};
    f->nodes = SN_NEW(node, f->goal + 1);
    if (f->nodes == NULL) {
        free(f);
        return sn_fail_memory(error, "paths over a surface");
    }
    *out = f;
    return SN_OK;
}

void sn_path_finder_destroy(sn_path_finder *finder) {
    if (finder == NULL) return;
    free(finder->nodes);
    free(finder->queue);
    free(finder);
}

void sn_surface_path_free(sn_surface_path *path) {
    free(path->segments);
    *path = (sn_surface_path){0};
}
