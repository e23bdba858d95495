/* Level sets of a scalar field on a surface: curves through cut edges, and vertex rings beside them. */
#include "section.h"

#include <stdlib.h>
#include <string.h>

sn_status section_create(const sn_mesh *mesh, const sn_topology *topology, section *out, sn_error *error) {
    *out = (section){.mesh = mesh, .topology = topology};
    out->cut_edges = SN_NEW(sn_index, topology->edge_count);
    out->low = SN_NEW(bool, mesh->vertex_count);
    out->edge_stamp = SN_NEW(uint32_t, topology->edge_count);
    out->vertex_stamp = SN_NEW(uint32_t, mesh->vertex_count);
    out->stack = SN_NEW(sn_index, mesh->vertex_count);
    if (out->cut_edges && out->low && out->edge_stamp && out->vertex_stamp && out->stack) return SN_OK;
    section_free(out);
    return sn_fail_memory(error, "the sections of the surface");
}

void section_free(section *s) {
    free(s->curves);
    free(s->cut_edges);
    free(s->low);
    free(s->edge_stamp);
    free(s->vertex_stamp);
    free(s->stack);
    *s = (section){0};
}

/* A fresh mark that no edge and no vertex carries. */
static uint32_t fresh_stamp(section *s) {
    if (s->stamp == UINT32_MAX) {
        memset(s->edge_stamp, 0, (size_t)s->topology->edge_count * sizeof *s->edge_stamp);
        memset(s->vertex_stamp, 0, (size_t)s->mesh->vertex_count * sizeof *s->vertex_stamp);
        s->stamp = 0;
    }
    return ++s->stamp;
}

/* ---- curves ------------------------------------------------------------------------------------------------------- */

static bool is_cut(const section *s, sn_index edge) {
    const sn_edge *e = &s->topology->edges[edge];
    return s->low[e->v[0]] != s->low[e->v[1]];
}

/* Where the level crosses a cut edge. */
static sn_vec3 crossing(const section *s, sn_index edge) {
    const sn_edge *e = &s->topology->edges[edge];
    double u0 = s->u[e->v[0]], u1 = s->u[e->v[1]];
    double t = u1 != u0 ? (s->level - u0) / (u1 - u0) : 0.5;
    if (!(t >= 0.0 && t <= 1.0)) t = 0.5;
    return sn_lerp(s->mesh->positions[e->v[0]], s->mesh->positions[e->v[1]], t);
}

/* The cut edge of triangle other than `edge`; SN_NONE where a defect leaves none. */
static sn_index next_cut(const section *s, sn_index triangle, sn_index edge) {
    for (int c = 0; c < 3; c++) {
        sn_index other = s->topology->triangle_edges[triangle][c];
        if (other != SN_NONE && other != edge && is_cut(s, other)) return other;
    }
    return SN_NONE;
}

static sn_index across(const section *s, sn_index edge, sn_index triangle) {
    const sn_edge *e = &s->topology->edges[edge];
    if (e->triangle_count != 2) return SN_NONE; /* a border, or more sheets than a curve can follow */
    return e->triangle[0] == triangle ? e->triangle[1] : e->triangle[0];
}

/* Follow the curve from `edge` into `triangle`, appending cut edges; true when it came back to where it started. */
static bool follow(section *s, sn_index start, sn_index triangle) {
    sn_index edge = start;
    while (triangle != SN_NONE) {
        edge = next_cut(s, triangle, edge);
        if (edge == start) return true;
        if (edge == SN_NONE || s->edge_stamp[edge] == s->stamp) return false;
        s->edge_stamp[edge] = s->stamp;
        s->cut_edges[s->cut_count++] = edge;
        triangle = across(s, edge, triangle);
    }
    return false;
}

static void reverse(sn_index count, sn_index *values) {
    for (sn_index i = 0, j = count - 1; i < j; i++, j--) {
        sn_index t = values[i];
        values[i] = values[j];
        values[j] = t;
    }
}

static sn_vec3 curve_mean(const section *s, const section_curve *curve) {
    const sn_index *edges = s->cut_edges + curve->first;
    sn_vec3 first = crossing(s, edges[0]), before = first, sum = {0, 0, 0};
    double length = 0.0;
    for (sn_index i = 1; i < curve->count + (curve->closed ? 1 : 0); i++) {
        sn_vec3 here = crossing(s, edges[i % curve->count]);
        double step = sn_distance(before, here);
        sum = sn_add_scaled(sum, sn_sub(sn_lerp(before, here, 0.5), first), step);
        length += step;
        before = here;
    }
    return length > 0.0 ? sn_add_scaled(first, sum, 1.0 / length) : first;
}

static bool trace_curve(section *s, sn_index edge) {
    if (!sn_grow((void **)&s->curves, &s->curve_capacity, (size_t)s->curve_count + 1, sizeof *s->curves)) return false;
    section_curve *curve = &s->curves[s->curve_count++];
    *curve = (section_curve){.first = s->cut_count};
    const sn_edge *e = &s->topology->edges[edge];
    s->edge_stamp[edge] = s->stamp;
    s->cut_edges[s->cut_count++] = edge;
    curve->closed = follow(s, edge, e->triangle[0]);
    if (!curve->closed && e->triangle[1] != SN_NONE) {
        reverse(s->cut_count - curve->first, s->cut_edges + curve->first);
        curve->closed = follow(s, edge, e->triangle[1]);
    }
    curve->count = s->cut_count - curve->first;
    curve->closed = curve->closed && curve->count >= 3;
    curve->mean = curve_mean(s, curve);
    return true;
}

sn_status section_cut(section *s, const double *u, double level, sn_error *error) {
    s->u = u;
    s->level = level;
    s->curve_count = s->cut_count = 0;
    for (sn_index v = 0; v < s->mesh->vertex_count; v++) s->low[v] = u[v] < level;
    fresh_stamp(s);
    for (sn_index e = 0; e < s->topology->edge_count; e++)
        if (is_cut(s, e) && s->edge_stamp[e] != s->stamp && !trace_curve(s, e)) return sn_fail_memory(error, "the curves of a section");
    return SN_OK;
}

/* ---- rings -------------------------------------------------------------------------------------------------------- */

/* The walk of vertices on one side of the curve, without repeats next to each other. */
static sn_index side_walk(const section *s, const section_curve *curve, section_side side, sn_index *walk) {
    sn_index count = 0;
    for (sn_index i = 0; i < curve->count; i++) {
        const sn_edge *e = &s->topology->edges[s->cut_edges[curve->first + i]];
        sn_index low = s->low[e->v[0]] ? e->v[0] : e->v[1];
        sn_index vertex = side == SECTION_LOW ? low : e->v[0] + e->v[1] - low;
        if (count == 0 || walk[count - 1] != vertex) walk[count++] = vertex;
    }
    if (curve->closed)
        while (count > 1 && walk[count - 1] == walk[0]) count--;
    return count;
}

static bool visits_once(section *s, sn_index count, const sn_index *walk) {
    uint32_t mark = fresh_stamp(s);
    for (sn_index i = 0; i < count; i++) {
        if (s->vertex_stamp[walk[i]] == mark) return false;
        s->vertex_stamp[walk[i]] = mark;
    }
    return true;
}

/* Keep the longest simple loop of a closed walk: the walk is read onto a stack; a vertex that is on it already closes a loop, which is
 * taken off. What is left at the end is a simple loop too. */
static sn_index longest_simple_loop(section *s, sn_index count, sn_index *walk) {
    uint32_t mark = fresh_stamp(s);
    sn_index top = 0, best_count = 0;
    sn_index *best = s->stack; /* as long as all vertices: a loop fits */
    for (sn_index i = 0; i < count; i++) {
        sn_index vertex = walk[i];
        if (s->vertex_stamp[vertex] == mark) {
            sn_index begin = top - 1;
            while (walk[begin] != vertex) begin--;
            if (top - begin > best_count) memcpy(best, walk + begin, (size_t)(best_count = top - begin) * sizeof *best);
            while (top > begin) s->vertex_stamp[walk[--top]] = 0;
        }
        s->vertex_stamp[vertex] = mark;
        walk[top++] = vertex; /* top <= i: what is overwritten has been read */
    }
    if (top >= best_count) return top;
    memcpy(walk, best, (size_t)best_count * sizeof *walk);
    return best_count;
}

sn_index section_ring(section *s, const section_curve *curve, section_side side, sn_index *ring, bool *simple) {
    sn_index count = side_walk(s, curve, side, ring);
    *simple = visits_once(s, count, ring);
    if (!*simple) count = longest_simple_loop(s, count, ring);
    return count;
}

void section_ring_canonical(sn_index count, sn_index *ring) {
    if (count < 3) return;
    sn_index lowest = 0;
    for (sn_index i = 1; i < count; i++)
        if (ring[i] < ring[lowest]) lowest = i;
    bool backwards = ring[(lowest + count - 1) % count] < ring[(lowest + 1) % count];
    /* rotation to the left by `lowest` is three reversals */
    reverse(lowest, ring);
    reverse(count - lowest, ring + lowest);
    reverse(count, ring);
    if (backwards) reverse(count - 1, ring + 1);
}

bool section_ring_closed(section *s, sn_index count, const sn_index *ring) {
    if (count < 3 || !visits_once(s, count, ring)) return false;
    for (sn_index i = 0; i < count; i++)
        if (sn_topology_edge(s->topology, ring[i], ring[(i + 1) % count]) == SN_NONE) return false;
    return true;
}

/* ---- parts -------------------------------------------------------------------------------------------------------- */

/* Marks what is joined to the seed without passing vertices that are marked with `border` or already with `mark`. */
static void flood_off(section *s, uint32_t border, uint32_t mark, sn_index seed) {
    const sn_topology *t = s->topology;
    sn_index top = 0;
    s->vertex_stamp[seed] = mark;
    s->stack[top++] = seed;
    while (top > 0) {
        sn_index v = s->stack[--top];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (s->vertex_stamp[w] == mark || s->vertex_stamp[w] == border) continue;
            s->vertex_stamp[w] = mark;
            s->stack[top++] = w;
        }
    }
}

sn_index section_parts(section *s, sn_index count, const sn_index *vertices) {
    const sn_topology *t = s->topology;
    uint32_t mark = fresh_stamp(s);
    for (sn_index i = 0; i < count; i++) s->vertex_stamp[vertices[i]] = mark;
    sn_index parts = 0;
    for (sn_index i = 0; i < count; i++)
        for (sn_index k = t->vertex_start[vertices[i]]; k < t->vertex_start[vertices[i] + 1]; k++)
            if (s->vertex_stamp[t->neighbours[k]] != mark) {
                flood_off(s, mark, mark, t->neighbours[k]);
                parts++;
            }
    return parts;
}

bool section_separates(section *s, sn_index count, const sn_index *vertices, const sn_fixed_values *ends) {
    uint32_t border = fresh_stamp(s), mark = fresh_stamp(s);
    if (mark < border) border = fresh_stamp(s); /* the stamps began anew */
    for (sn_index i = 0; i < count; i++) s->vertex_stamp[vertices[i]] = border;
    bool low = false, high = false;
    for (sn_index i = 0; i < ends->count; i++) {
        sn_index v = ends->vertices[i];
        if (ends->values[i] != 0.0 || s->vertex_stamp[v] == border) continue;
        if (s->vertex_stamp[v] != mark) flood_off(s, border, mark, v);
        low = true;
    }
    for (sn_index i = 0; i < ends->count; i++) {
        sn_index v = ends->vertices[i];
        if (ends->values[i] == 0.0 || s->vertex_stamp[v] == border) continue;
        if (s->vertex_stamp[v] == mark) return false;
        high = true;
    }
    return low && high;
}
