/*
 * remesh.h -- isotropic remeshing of a closed surface to an edge length, on its implicit shape.
 *
 * Botsch and Kobbelt 2004: split long edges, collapse short ones, flip, relax in the tangent plane, go back to the surface; a few
 * rounds. Collapses keep the link condition, so a closed manifold stays one and keeps its genus. The mesh is a corner table: corner
 * c of triangle c / 3 lies at vertex[c] and faces the edge whose other side is corner opposite[c].
 */
#ifndef ARM_REMESH_H
#define ARM_REMESH_H

#include <stdlib.h>
#include <string.h>

#include "shape.h"

typedef struct remesher {
    const shape *shape;
    double length;    /* edge length aimed at, m */
    sn_index count;   /* vertices, dead ones too */
    sn_index corners; /* 3 x triangles, dead ones too */
    sn_vec3 *positions;
    sn_vec3 *normals;    /* of the shape */
    double *lengths;     /* edge length aimed at around each vertex: shorter on thin tendons and sharp rims */
    sn_index *corner_of; /* one corner of each vertex; SN_NONE = dead */
    sn_index *mark;      /* scratch for the link condition: last stamp */
    sn_index stamp;
    sn_index *vertex, *opposite; /* (corners) vertex SN_NONE = dead triangle */
    size_t position_capacity, normal_capacity, length_capacity, corner_of_capacity, mark_capacity, vertex_capacity, opposite_capacity;
} remesher;

static sn_index next_corner(sn_index c) { return c % 3 == 2 ? c - 2 : c + 1; }
static sn_index previous_corner(sn_index c) { return c % 3 == 0 ? c + 2 : c - 1; }
/* The next corner at the same vertex, counter-clockwise. */
static sn_index turn(const remesher *r, sn_index c) { return next_corner(r->opposite[next_corner(c)]); }

static void pair(remesher *r, sn_index a, sn_index b) {
    r->opposite[a] = b;
    r->opposite[b] = a;
}

static bool reserve(remesher *r, size_t vertices, size_t corners) {
    return sn_grow((void **)&r->positions, &r->position_capacity, vertices, sizeof *r->positions) &&
           sn_grow((void **)&r->normals, &r->normal_capacity, vertices, sizeof *r->normals) &&
           sn_grow((void **)&r->lengths, &r->length_capacity, vertices, sizeof *r->lengths) &&
           sn_grow((void **)&r->corner_of, &r->corner_of_capacity, vertices, sizeof *r->corner_of) &&
           sn_grow((void **)&r->mark, &r->mark_capacity, vertices, sizeof *r->mark) &&
           sn_grow((void **)&r->vertex, &r->vertex_capacity, corners, sizeof *r->vertex) &&
           sn_grow((void **)&r->opposite, &r->opposite_capacity, corners, sizeof *r->opposite);
}

/* ---- in and out --------------------------------------------------------------------------------------------------- */

static sn_status remesher_load(remesher *r, const sn_mesh *mesh, sn_error *error) {
    sn_topology topology = {0};
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    r->count = mesh->vertex_count;
    r->corners = 3 * mesh->triangle_count;
    if (!reserve(r, (size_t)r->count, (size_t)r->corners)) {
        sn_topology_free(&topology);
        return sn_fail_memory(error, "the corner table");
    }
    memcpy(r->positions, mesh->positions, (size_t)r->count * sizeof *r->positions);
    memset(r->mark, 0, (size_t)r->count * sizeof *r->mark);
    for (sn_index c = 0; c < r->corners; c++) {
        const sn_edge *edge = &topology.edges[topology.triangle_edges[c / 3][c % 3]];
        sn_index other = edge->triangle[edge->triangle[0] == c / 3], far = edge->opposite[edge->triangle[0] == c / 3];
        const sn_index *v = mesh->triangles[other].v;
        r->vertex[c] = mesh->triangles[c / 3].v[c % 3];
        r->opposite[c] = 3 * other + (v[0] == far ? 0 : v[1] == far ? 1 : 2);
        r->corner_of[r->vertex[c]] = c;
    }
    sn_topology_free(&topology);
    return SN_OK;
}

static sn_status remesher_store(const remesher *r, sn_mesh *out, sn_error *error) {
    sn_index *number = SN_NEW(sn_index, r->count), vertices = 0, triangles = 0;
    if (!number) return sn_fail_memory(error, "the new vertex numbers");
    for (sn_index i = 0; i < r->count; i++)
        if (r->corner_of[i] != SN_NONE) number[i] = vertices++;
    for (sn_index c = 0; c < r->corners; c += 3) triangles += r->vertex[c] != SN_NONE;
    sn_status status = sn_mesh_alloc(out, vertices, triangles, error);
    if (status == SN_OK) {
        for (sn_index i = 0; i < r->count; i++)
            if (r->corner_of[i] != SN_NONE) out->positions[number[i]] = r->positions[i];
        for (sn_index c = 0, t = 0; c < r->corners; c += 3)
            if (r->vertex[c] != SN_NONE)
                out->triangles[t++] = (sn_triangle){{number[r->vertex[c]], number[r->vertex[c + 1]], number[r->vertex[c + 2]]}};
    }
    free(number);
    return status;
}

static void remesher_free(remesher *r) {
    free(r->positions);
    free(r->normals);
    free(r->lengths);
    free(r->corner_of);
    free(r->mark);
    free(r->vertex);
    free(r->opposite);
}

/* ---- small questions ---------------------------------------------------------------------------------------------- */

/* How long the edge from a to b is over how long it should be. */
static double stretch(const remesher *r, sn_index a, sn_vec3 at_a, sn_index b) {
    return sn_distance(at_a, r->positions[b]) / fmin(r->lengths[a], r->lengths[b]);
}

static double edge_stretch(const remesher *r, sn_index c) {
    sn_index a = r->vertex[next_corner(c)];
    return stretch(r, a, r->positions[a], r->vertex[previous_corner(c)]);
}

static int valence(const remesher *r, sn_index v) {
    int n = 0;
    sn_index c = r->corner_of[v];
    do n++, c = turn(r, c);
    while (c != r->corner_of[v]);
    return n;
}

static bool adjacent(const remesher *r, sn_index a, sn_index b) {
    sn_index c = r->corner_of[a];
    do {
        if (r->vertex[next_corner(c)] == b) return true;
        c = turn(r, c);
    } while (c != r->corner_of[a]);
    return false;
}

/* Would the triangle of corner c keep facing the same way with its corner at `to`? */
static bool keeps_facing(const remesher *r, sn_index c, sn_vec3 to) {
    sn_vec3 from = r->positions[r->vertex[c]], a = r->positions[r->vertex[next_corner(c)]], b = r->positions[r->vertex[previous_corner(c)]];
    sn_vec3 before = sn_normalize(sn_area_vector(from, a, b)), after = sn_normalize(sn_area_vector(to, a, b));
    return sn_dot(before, after) > 0.5;
}

/* Put v on the surface, starting from p. */
static void place(remesher *r, sn_index v, sn_vec3 p) {
    r->positions[v] = shape_project(r->shape, p, 0.5 * r->length, &r->normals[v]);
    r->lengths[v] = fmin(r->length, shape_edge_limit(r->shape, r->positions[v]));
}

/* ---- the four steps ------------------------------------------------------------------------------------------------ */

/* Cut the edge facing corner c in its middle. */
static bool split_edge(remesher *r, sn_index c) {
    sn_index o = r->opposite[c], a = next_corner(c), b = previous_corner(c), oa = previous_corner(o), ob = next_corner(o);
    sn_index m = r->count, c2 = r->corners, o2 = r->corners + 3;
    if (!reserve(r, (size_t)m + 1, (size_t)o2 + 3)) return false;
    place(r, m, sn_lerp(r->positions[r->vertex[a]], r->positions[r->vertex[b]], 0.5));
    r->mark[m] = 0;
    r->vertex[c2] = r->vertex[c], r->vertex[c2 + 1] = m, r->vertex[c2 + 2] = r->vertex[b];
    r->vertex[o2] = r->vertex[o], r->vertex[o2 + 1] = r->vertex[ob], r->vertex[o2 + 2] = m;
    pair(r, c2 + 1, r->opposite[a]);
    pair(r, o2 + 2, r->opposite[oa]);
    r->corner_of[r->vertex[b]] = c2 + 2;
    r->vertex[b] = m;
    r->vertex[ob] = m;
    r->corner_of[m] = b;
    pair(r, a, c2 + 2);
    pair(r, oa, o2 + 1);
    pair(r, c2, o2);
    r->count++;
    r->corners += 6;
    return true;
}

static bool split_long_edges(remesher *r) {
    for (sn_index c = 0, end = r->corners; c < end; c++)
        if (r->vertex[c] != SN_NONE && c < r->opposite[c] && edge_stretch(r, c) > 4.0 / 3.0 && !split_edge(r, c)) return false;
    return true;
}

/* Exactly the two corners facing an edge may see both its ends (link condition). */
static int common_neighbours(remesher *r, sn_index a, sn_index b) {
    int common = 0;
    sn_index c = r->corner_of[a];
    r->stamp++;
    do r->mark[r->vertex[next_corner(c)]] = r->stamp, c = turn(r, c);
    while (c != r->corner_of[a]);
    c = r->corner_of[b];
    do common += r->mark[r->vertex[next_corner(c)]] == r->stamp, c = turn(r, c);
    while (c != r->corner_of[b]);
    return common;
}

/* Moving v to `to` turns no triangle over (those with `other` vanish) and makes no long edge. */
static bool may_move(const remesher *r, sn_index v, sn_index other, sn_vec3 to) {
    sn_index c = r->corner_of[v];
    do {
        sn_index a = r->vertex[next_corner(c)], b = r->vertex[previous_corner(c)];
        if (a != other && b != other && !keeps_facing(r, c, to)) return false;
        if (a != other && stretch(r, v, to, a) > 4.0 / 3.0) return false;
        c = turn(r, c);
    } while (c != r->corner_of[v]);
    return true;
}

/* Merge b into a; c faces the edge. */
static void collapse_edge(remesher *r, sn_index c, sn_vec3 to) {
    sn_index ca = next_corner(c), cb = previous_corner(c), o = r->opposite[c], oa = previous_corner(o), ob = next_corner(o);
    sn_index a = r->vertex[ca], b = r->vertex[cb], p = r->vertex[c], q = r->vertex[o], k = r->corner_of[b];
    do {
        sn_index following = turn(r, k);
        r->vertex[k] = a;
        k = following;
    } while (k != r->corner_of[b]);
    sn_index past_a = r->opposite[ca], past_oa = r->opposite[oa];
    pair(r, past_a, r->opposite[cb]);
    pair(r, past_oa, r->opposite[ob]);
    r->corner_of[a] = previous_corner(past_a);
    r->corner_of[p] = next_corner(past_a);
    r->corner_of[q] = previous_corner(past_oa);
    r->corner_of[b] = SN_NONE;
    for (int i = 0; i < 3; i++) r->vertex[3 * (c / 3) + i] = r->vertex[3 * (o / 3) + i] = SN_NONE;
    place(r, a, to);
}

static void collapse_short_edges(remesher *r) {
    for (sn_index c = 0; c < r->corners; c++) {
        if (r->vertex[c] == SN_NONE || edge_stretch(r, c) > 0.8) continue;
        sn_index a = r->vertex[next_corner(c)], b = r->vertex[previous_corner(c)];
        sn_vec3 middle = sn_lerp(r->positions[a], r->positions[b], 0.5);
        if (valence(r, r->vertex[c]) <= 4 || valence(r, r->vertex[r->opposite[c]]) <= 4 || common_neighbours(r, a, b) != 2) continue;
        if (may_move(r, a, b, middle) && may_move(r, b, a, middle)) collapse_edge(r, c, middle);
    }
}

/* Cosine of the angle at p in the triangle p, a, b. */
static double angle_cosine(sn_vec3 p, sn_vec3 a, sn_vec3 b) { return sn_dot(sn_normalize(sn_sub(a, p)), sn_normalize(sn_sub(b, p))); }

/* Should and may the edge facing corner c be flipped? It should where the two angles facing it exceed 180 degrees together (Delaunay). */
static bool wants_flip(const remesher *r, sn_index c) {
    sn_index vp = r->vertex[c], vq = r->vertex[r->opposite[c]], va = r->vertex[next_corner(c)], vb = r->vertex[previous_corner(c)];
    sn_vec3 p = r->positions[vp], q = r->positions[vq], a = r->positions[va], b = r->positions[vb];
    if (angle_cosine(p, a, b) + angle_cosine(q, a, b) >= -1e-3) return false;
    if (valence(r, va) <= 4 || valence(r, vb) <= 4 || adjacent(r, vp, vq)) return false;
    sn_vec3 before = sn_add(sn_area_vector(p, a, b), sn_area_vector(q, b, a));
    sn_vec3 first = sn_normalize(sn_area_vector(p, a, q)), second = sn_normalize(sn_area_vector(q, b, p));
    return sn_dot(first, second) > 0.5 && sn_dot(first, before) > 0.0 && sn_dot(second, before) > 0.0;
}

/* Triangles (p,a,b) and (q,b,a) become (p,a,q) and (q,b,p). */
static void flip_edge(remesher *r, sn_index c) {
    sn_index o = r->opposite[c], ca = next_corner(c), cb = previous_corner(c), ob = next_corner(o), oa = previous_corner(o);
    sn_index beyond_pb = r->opposite[ca], beyond_qa = r->opposite[ob];
    r->corner_of[r->vertex[ca]] = ca;
    r->corner_of[r->vertex[cb]] = ob;
    r->vertex[cb] = r->vertex[o];
    r->vertex[oa] = r->vertex[c];
    r->corner_of[r->vertex[c]] = c;
    r->corner_of[r->vertex[o]] = o;
    pair(r, c, beyond_qa);
    pair(r, o, beyond_pb);
    pair(r, ca, ob);
}

static void flip_edges(remesher *r) {
    for (sn_index c = 0; c < r->corners; c++)
        if (r->vertex[c] != SN_NONE && c < r->opposite[c] && wants_flip(r, c)) flip_edge(r, c);
}

/* Area-weighted mean of the centres of the triangles around v. */
static sn_vec3 ring_centre(const remesher *r, sn_index v) {
    sn_vec3 sum = {0, 0, 0}, p = r->positions[v];
    double total = 0.0;
    sn_index c = r->corner_of[v];
    do {
        sn_vec3 a = r->positions[r->vertex[next_corner(c)]], b = r->positions[r->vertex[previous_corner(c)]];
        double area = sn_norm(sn_area_vector(p, a, b));
        sum = sn_add_scaled(sum, sn_add(p, sn_add(a, b)), area / 3.0);
        total += area;
        c = turn(r, c);
    } while (c != r->corner_of[v]);
    return total > 0.0 ? sn_scale(sum, 1.0 / total) : p;
}

static bool ring_keeps_facing(const remesher *r, sn_index v, sn_vec3 to) {
    sn_index c = r->corner_of[v];
    do {
        if (!keeps_facing(r, c, to)) return false;
        c = turn(r, c);
    } while (c != r->corner_of[v]);
    return true;
}

/* Move every vertex towards the centre of its ring, in the tangent plane, and back onto the surface. */
static void relax(remesher *r) {
    for (sn_index v = 0; v < r->count; v++) {
        if (r->corner_of[v] == SN_NONE) continue;
        sn_vec3 step = sn_sub(ring_centre(r, v), r->positions[v]);
        step = sn_add_scaled(step, r->normals[v], -sn_dot(step, r->normals[v]));
        sn_vec3 to = sn_add_scaled(r->positions[v], step, 0.8);
        if (ring_keeps_facing(r, v, to)) place(r, v, to);
    }
}

static void settle(remesher *r) {
    for (sn_index v = 0; v < r->count; v++) place(r, v, r->positions[v]);
}

/* Remesh the closed surface `mesh` of `s` in place to edges of about `length` metres. */
static sn_status remesh(const shape *s, double length, sn_mesh *mesh, sn_error *error) {
    enum { ROUNDS = 8, LAST_ROUNDS = 4 };
    remesher r = {.shape = s, .length = length};
    sn_mesh result = {0};
    sn_status status = remesher_load(&r, mesh, error);
    if (status == SN_OK) settle(&r);
    for (int round = 0; status == SN_OK && round < ROUNDS + LAST_ROUNDS; round++) {
        if (round < ROUNDS && !split_long_edges(&r)) status = sn_fail_memory(error, "the refined surface");
        if (round < ROUNDS) collapse_short_edges(&r);
        flip_edges(&r);
        relax(&r);
    }
    if (status == SN_OK) status = remesher_store(&r, &result, error);
    remesher_free(&r);
    if (status != SN_OK) return status;
    sn_mesh_free(mesh);
    *mesh = result;
    return SN_OK;
}

#endif
