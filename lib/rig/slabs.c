/*
 * slabs.c -- the Reeb tree of the distance from the roots: levels a step apart cut the faces into slabs, and each connected slab hangs on
 * the one it touches towards the roots.
 *
 * What is cut is the surface, not the set of its vertices: bands of vertices one edge wide fall apart wherever edges are longer than the
 * band, and their number depends on the mesh. A piece is the part of one triangle within one band; pieces of the same band on either side
 * of an edge hang together where the edge passes through the band. Bands are half open, so this holds to the last bit.
 */
#include <stdlib.h>

#include "sinew/sets.h"
#include "tree.h"

/* A piece without area still has to be somewhere: it weighs as much as this share of the mean triangle, as a point. */
#define LEAST_WEIGHT 1e-9

typedef struct slicing {
    tree *tree;
    double step, least_weight;
    sn_index *band;  /* (vertex_count) */
    sn_index *start; /* (triangle_count + 1) first piece of each triangle: its lowest band */
    sn_index *link;  /* (pieces) union-find forest, then the slab of each piece */
    sn_index slab_count;
    sn_index *parent; /* (slabs) */
} slicing;

/* ---- pieces --------------------------------------------------------------------------------------------------------------- */

static sn_index lowest_band(const slicing *s, sn_triangle t) {
    sn_index a = s->band[t.v[0]], b = s->band[t.v[1]], c = s->band[t.v[2]];
    return a < b ? (a < c ? a : c) : (b < c ? b : c);
}

static sn_index highest_band(const slicing *s, sn_triangle t) {
    sn_index a = s->band[t.v[0]], b = s->band[t.v[1]], c = s->band[t.v[2]];
    return a > b ? (a > c ? a : c) : (b > c ? b : c);
}

static sn_status too_fine(sn_error *error) {
    return sn_fail(error, SN_ERROR_INPUT, "the surface is too large to be cut into slabs; decimate it with mesh-clean --triangles");
}

static sn_status number_pieces(slicing *s, sn_error *error) {
    const sn_mesh *mesh = s->tree->mesh;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        double band = floor(s->tree->distance[v] / s->step);
        if (!(band < (double)SN_INDEX_MAX)) return too_fine(error);
        s->band[v] = (sn_index)band;
    }
    int64_t count = 0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        s->start[t] = (sn_index)count;
        count += (int64_t)highest_band(s, mesh->triangles[t]) - lowest_band(s, mesh->triangles[t]) + 1;
        if (count >= SN_INDEX_MAX) return too_fine(error);
    }
    s->start[mesh->triangle_count] = (sn_index)count;
    return SN_OK;
}

static sn_index piece_at(const slicing *s, sn_index triangle, sn_index band) {
    return s->start[triangle] + band - lowest_band(s, s->tree->mesh->triangles[triangle]);
}

/* ---- slabs ---------------------------------------------------------------------------------------------------------------- */

/* Across edges; and all pieces of band 0, which the roots hold together. */
static void join_pieces(slicing *s) {
    const sn_topology *t = s->tree->topology;
    for (sn_index p = 0; p < s->start[t->triangle_count]; p++) s->link[p] = p;
    for (sn_index e = 0; e < t->edge_count; e++) {
        const sn_edge *edge = &t->edges[e];
        if (edge->triangle[1] == SN_NONE) continue;
        sn_index a = s->band[edge->v[0]], b = s->band[edge->v[1]];
        for (sn_index k = a < b ? a : b; k <= (a < b ? b : a); k++)
            sn_join_sets(s->link, piece_at(s, edge->triangle[0], k), piece_at(s, edge->triangle[1], k));
    }
    sn_index root = SN_NONE;
    for (sn_index i = 0; i < t->triangle_count; i++) {
        if (lowest_band(s, s->tree->mesh->triangles[i]) > 0) continue;
        if (root == SN_NONE) root = s->start[i];
        sn_join_sets(s->link, root, s->start[i]);
    }
}

static void count_roots(const slicing *s, sn_index *per_band) {
    for (sn_index t = 0; t < s->tree->mesh->triangle_count; t++)
        for (sn_index p = s->start[t], band = lowest_band(s, s->tree->mesh->triangles[t]); p < s->start[t + 1]; p++, band++)
            if (s->link[p] == p) per_band[band]++;
}

/* Number slabs by band, then by lowest piece, so that parents come before children; link becomes the slab of each piece. */
static sn_status number_slabs(slicing *s, sn_error *error) {
    const sn_mesh *mesh = s->tree->mesh;
    sn_index pieces = s->start[mesh->triangle_count], highest = 0;
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        if (s->band[v] > highest) highest = s->band[v];
    sn_index *next = SN_NEW(sn_index, (size_t)highest + 2); /* the next number of each band */
    if (!next) return sn_fail_memory(error, "the slabs of the surface");
    count_roots(s, next + 1);
    for (sn_index k = 0; k <= highest; k++) next[k + 1] += next[k];
    s->slab_count = next[highest + 1];
    for (sn_index p = 0; p < pieces; p++) s->link[p] = sn_set_of(s->link, p);
    for (sn_index t = 0; t < mesh->triangle_count; t++) /* a piece's root comes before it: its number is there, as -1 - number */
        for (sn_index p = s->start[t], band = lowest_band(s, mesh->triangles[t]); p < s->start[t + 1]; p++, band++)
            s->link[p] = s->link[p] == p ? -1 - next[band]++ : s->link[s->link[p]];
    for (sn_index p = 0; p < pieces; p++) s->link[p] = -1 - s->link[p];
    free(next);
    return SN_OK;
}

/* ---- what each slab weighs --------------------------------------------------------------------------------------------------- */

/* A corner of a piece: a point relative to the tree's origin, and its distance from the roots. */
typedef struct corner {
    sn_vec3 point;
    double distance;
} corner;

enum { MAX_CORNERS = 5 }; /* a triangle between two parallel lines */

/* Keep what lies on one side of a level: sign = 1 above it, -1 below it. */
static int clip(const corner *in, int count, double level, double sign, corner *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const corner *a = &in[i], *b = &in[(i + 1) % count];
        double above_a = sign * (a->distance - level), above_b = sign * (b->distance - level);
        if (above_a >= 0.0) out[kept++] = *a;
        if ((above_a > 0.0 && above_b < 0.0) || (above_a < 0.0 && above_b > 0.0))
            out[kept++] = (corner){sn_lerp(a->point, b->point, above_a / (above_a - above_b)), level};
    }
    return kept;
}

static void weigh_point(tree *t, sn_index front, corner c, double weight) {
    t->weight[front] += weight;
    t->sum[front] = sn_add_scaled(t->sum[front], c.point, weight);
    t->sum2[front] += weight * sn_norm2(c.point);
    t->distance_sum[front] += weight * c.distance;
    t->reach[front] = fmax(t->reach[front], c.distance);
}

/* Area, its first and second moments and its distances: over a triangle of area A the integral of |x|^2 is A/12 (sum |p|^2 + |sum p|^2). */
static void weigh_triangle(tree *t, sn_index front, corner a, corner b, corner c, double least) {
    double area = sn_norm(sn_area_vector(a.point, b.point, c.point)) * 0.5;
    sn_vec3 sum = sn_add(a.point, sn_add(b.point, c.point));
    corner middle = {sn_scale(sum, 1.0 / 3.0), (a.distance + b.distance + c.distance) / 3.0};
    if (!(area > least)) {
        weigh_point(t, front, middle, least);
        return;
    }
    t->weight[front] += area;
    t->sum[front] = sn_add_scaled(t->sum[front], middle.point, area);
    t->sum2[front] += area / 12.0 * (sn_norm2(a.point) + sn_norm2(b.point) + sn_norm2(c.point) + sn_norm2(sum));
    t->distance_sum[front] += area * middle.distance;
    t->reach[front] = fmax(t->reach[front], fmax(a.distance, fmax(b.distance, c.distance)));
}

static void weigh_piece(const slicing *s, sn_index triangle, sn_index band, sn_index front) {
    const sn_index *v = s->tree->mesh->triangles[triangle].v;
    corner whole[MAX_CORNERS], below[MAX_CORNERS], piece[MAX_CORNERS];
    for (int k = 0; k < 3; k++) whole[k] = (corner){sn_sub(s->tree->mesh->positions[v[k]], s->tree->origin), s->tree->distance[v[k]]};
    int count = clip(whole, 3, (band + 1.0) * s->step, -1.0, below);
    count = clip(below, count, band * s->step, 1.0, piece);
    for (int k = 1; k + 1 < count; k++) weigh_triangle(s->tree, front, piece[0], piece[k], piece[k + 1], s->least_weight);
    if (count > 0 && count < 3) weigh_point(s->tree, front, piece[0], s->least_weight);
    if (count == 0) weigh_point(s->tree, front, whole[0], s->least_weight); /* rounding: the band touches one corner */
}

static void weigh_slabs(slicing *s) {
    const tree *t = s->tree;
    for (sn_index i = 0; i < t->mesh->triangle_count; i++) {
        const sn_index *v = t->mesh->triangles[i].v;
        for (sn_index p = s->start[i], band = lowest_band(s, t->mesh->triangles[i]); p < s->start[i + 1]; p++, band++) {
            sn_index slab = s->link[p];
            weigh_piece(s, i, band, slab);
            for (int k = 0; k < 3; k++)
                if (t->part[v[k]] < t->side[slab]) t->side[slab] = t->part[v[k]];
        }
    }
}

/* ---- the tree -------------------------------------------------------------------------------------------------------------- */

/* The lowest slab that it touches in the band below; on a surface without handles there is one. */
static void find_parents(slicing *s) {
    for (sn_index i = 0; i < s->slab_count; i++) s->parent[i] = SN_NONE;
    for (sn_index t = 0; t < s->tree->mesh->triangle_count; t++)
        for (sn_index p = s->start[t] + 1; p < s->start[t + 1]; p++) {
            sn_index *parent = &s->parent[s->link[p]];
            if (*parent == SN_NONE || s->link[p - 1] < *parent) *parent = s->link[p - 1];
        }
}

static void list_vertices(slicing *s) {
    tree *t = s->tree;
    for (sn_index v = 0; v < t->mesh->vertex_count; v++) {
        sn_index triangle = t->topology->vertex_triangles[t->topology->corner_start[v]];
        tree_add_vertex(t, s->link[piece_at(s, triangle, s->band[v])], v);
    }
}

static sn_status plant_tree(slicing *s, sn_error *error) {
    sn_status status = tree_reserve(s->tree, s->slab_count, error);
    s->parent = SN_NEW(sn_index, s->slab_count);
    if (!status && !s->parent) status = sn_fail_memory(error, "the slabs of the surface");
    if (status) return status;
    find_parents(s);
    for (sn_index i = 0; i < s->slab_count; i++) tree_add_front(s->tree, s->parent[i]);
    weigh_slabs(s);
    list_vertices(s);
    s->tree->side[0] = SN_INDEX_MAX;
    return SN_OK;
}

/* Forget the slabs from `count` on. */
static void cut_back(tree *t, sn_index count) {
    for (sn_index v = 0; v < t->mesh->vertex_count; v++)
        if (t->front[v] >= count) t->front[v] = SN_NONE;
    t->count = count;
}

static sn_status show_slabs(slicing *s, sn_trace *trace) {
    tree *t = s->tree;
    for (sn_index i = 0; i < t->count; i++) {
        sn_index count = 0;
        for (sn_index v = t->first[i]; v != SN_NONE && sn_trace_wanted(trace); v = t->next[v]) s->band[count++] = v; /* done with */
        sn_vec3 p = tree_position(t, i);
        if (SN_TRACE(trace, "slab", sn_trace_number("sample", i), sn_trace_number("parent", t->parent[i]),
                     sn_trace_number("distance", t->distance_sum[i] / t->weight[i]), sn_trace_number("area", t->weight[i]),
                     sn_trace_number("x", p.x), sn_trace_number("y", p.y), sn_trace_number("z", p.z),
                     sn_trace_indices("vertices", s->band, count))) {
            cut_back(t, i + 1);
            return SN_STOPPED;
        }
    }
    return SN_OK;
}

static sn_status slice(slicing *s, sn_trace *trace, sn_error *error) {
    sn_status status = number_pieces(s, error);
    if (status) return status;
    s->link = SN_NEW(sn_index, s->start[s->tree->mesh->triangle_count]);
    if (!s->link) return sn_fail_memory(error, "the slabs of the surface");
    join_pieces(s);
    status = number_slabs(s, error);
    if (!status) status = plant_tree(s, error);
    return status ? status : show_slabs(s, trace);
}

sn_status traverse_slabs(tree *t, double step, sn_trace *trace, sn_error *error) {
    const sn_mesh *mesh = t->mesh;
    slicing s = {.tree = t, .step = step};
    s.least_weight = fmax(LEAST_WEIGHT * sn_mesh_area(mesh) / (double)mesh->triangle_count, 1e-300);
    s.band = SN_NEW(sn_index, mesh->vertex_count);
    s.start = SN_NEW(sn_index, (size_t)mesh->triangle_count + 1);
    sn_status status = s.band && s.start ? slice(&s, trace, error) : sn_fail_memory(error, "the slabs of the surface");
    free(s.band);
    free(s.start);
    free(s.link);
    free(s.parent);
    return status;
}
