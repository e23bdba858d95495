/*
 * manifold.c -- orientation of a surface and its repair where it is not a manifold.
 */
#include "sinew/geom.h"

#include <stdlib.h>

#include "bridge.h"
#include "edit.h"

static bool same_direction(const sn_mesh *mesh, const sn_edge *edge) {
    bool forward[2] = {false, false};
    for (int side = 0; side < 2; side++) {
        const sn_index *v = mesh->triangles[edge->triangle[side]].v;
        for (int k = 0; k < 3; k++) forward[side] |= v[k] == edge->v[0] && v[(k + 1) % 3] == edge->v[1];
    }
    return forward[0] == forward[1];
}

/* What gives every triangle a side, 1 or -1; 0 = none yet. */
typedef struct sides {
    const sn_mesh *mesh;
    const sn_topology *topology;
    signed char *side; /* (triangle_count) */
    sn_index *queue;   /* (triangle_count) */
    sn_index tail;     /* the queue's end */
} sides;

/* The neighbours of t across manifold edges take the side that agrees with it; false where one has the other side already. */
static bool spread_side(sides *s, sn_index t) {
    for (int k = 0; k < 3; k++) {
        sn_index e = s->topology->triangle_edges[t][k];
        if (e == SN_NONE || s->topology->edges[e].triangle_count != 2) continue;
        const sn_edge *edge = &s->topology->edges[e];
        sn_index other = edge->triangle[0] == t ? edge->triangle[1] : edge->triangle[0];
        signed char wanted = same_direction(s->mesh, edge) ? (signed char)-s->side[t] : s->side[t];
        if (s->side[other] == -wanted) return false;
        if (s->side[other] == 0) s->queue[s->tail++] = other;
        s->side[other] = wanted;
    }
    return true;
}

/* Sides on which all neighbours agree: possible on a two-sided surface only. */
static bool can_be_oriented(sides *s) {
    for (sn_index seed = 0; seed < s->mesh->triangle_count; seed++) {
        if (s->side[seed] != 0) continue;
        s->tail = 0;
        s->side[seed] = 1;
        s->queue[s->tail++] = seed;
        for (sn_index head = 0; head < s->tail; head++) {
            if (!spread_side(s, s->queue[head])) return false;
        }
    }
    return true;
}

static void flip(sn_triangle *triangle) {
    sn_index kept = triangle->v[1];
    triangle->v[1] = triangle->v[2];
    triangle->v[2] = kept;
}

static double twice_area(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* Where most of a component was turned, turn it all back: the smaller part was the wrong one. was_flipped (triangle_count). */
static sn_status keep_majority(sn_mesh *mesh, bool *was_flipped, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index *component = SN_NEW(sn_index, mesh->triangle_count);
    sn_index count = component != NULL ? sn_mesh_components(mesh, &topology, component) : 0;
    double *balance = SN_NEW(double, count);
    if (component != NULL && balance != NULL) {
        for (sn_index t = 0; t < mesh->triangle_count; t++) {
            balance[component[t]] += was_flipped[t] ? twice_area(mesh, t) : -twice_area(mesh, t);
        }
        for (sn_index t = 0; t < mesh->triangle_count; t++) {
            if (balance[component[t]] <= 0.0) continue;
            flip(&mesh->triangles[t]);
            was_flipped[t] = !was_flipped[t];
        }
    } else {
        status = sn_fail_memory(error, "orienting a mesh");
    }
    free(balance);
    free(component);
    sn_topology_free(&topology);
    return status;
}

/* Turn the triangles of the other side; the rest of the mesh is not touched. */
static sn_status turn_sides(sn_mesh *mesh, const signed char *side, sn_index *flipped, sn_error *error) {
    bool *was_flipped = SN_NEW(bool, mesh->triangle_count);
    if (was_flipped == NULL) return sn_fail_memory(error, "orienting a mesh");
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        was_flipped[t] = side[t] < 0;
        if (was_flipped[t]) flip(&mesh->triangles[t]);
    }
    sn_status status = keep_majority(mesh, was_flipped, error);
    for (sn_index t = 0; t < mesh->triangle_count; t++) *flipped += was_flipped[t];
    free(was_flipped);
    return status;
}

/* A two-sided surface whose edges carry one or two triangles can be oriented in place; turn = false only looks. */
static sn_status orient_in_place(sn_mesh *mesh, bool turn, sn_manifold_report *report, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sides s = {.mesh = mesh, .topology = &topology};
    s.side = SN_NEW(signed char, mesh->triangle_count);
    s.queue = SN_NEW(sn_index, mesh->triangle_count);
    if (s.side != NULL && s.queue != NULL) {
        report->orientable = can_be_oriented(&s);
        if (report->orientable && turn) status = turn_sides(mesh, s.side, &report->flipped, error);
    } else {
        status = sn_fail_memory(error, "orienting a mesh");
    }
    free(s.side);
    free(s.queue);
    sn_topology_free(&topology);
    return status;
}

static sn_status settle_orientation(const sn_bridge_mesh *in, const sn_bridge_mesh *out, sn_mesh *mesh, sn_index *flipped,
                                    sn_error *error) {
    bool *was_flipped = SN_NEW(bool, mesh->triangle_count);
    if (was_flipped == NULL) return sn_fail_memory(error, "orienting a mesh");
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_index second = out->vertex_origin[out->triangles[3 * (size_t)t + 1]];
        was_flipped[t] = second != in->triangles[3 * (size_t)out->triangle_origin[t] + 1];
    }
    sn_status status = keep_majority(mesh, was_flipped, error);
    for (sn_index t = 0; t < mesh->triangle_count; t++) *flipped += was_flipped[t];
    free(was_flipped);
    return status;
}

static sn_status orient_and_stitch(sn_mesh *mesh, sn_manifold_report *report, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_bridge_orientation done = {0};
    sn_mesh after = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_make_manifold(&in, &out, &done, error);
    if (status == SN_OK) status = sn_from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = settle_orientation(&in, &out, &after, &report->flipped, error);
    if (status == SN_OK) {
        report->split_vertices = done.split_vertices;
        report->stitched_edges = done.stitched_edges;
        sn_mesh_replace(mesh, &after);
    }
    sn_mesh_free(&after);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status;
}

sn_status sn_make_manifold(sn_mesh *mesh, sn_manifold_report *report, sn_error *error) {
    *report = (sn_manifold_report){.orientable = true};
    sn_mesh_report found;
    sn_status status = sn_mesh_look_at_edges(mesh, &found, error);
    if (status == SN_OK && found.nonmanifold_edges > 0) {
        status = sn_drop_walls(mesh, &report->wall_triangles, error);
        if (status == SN_OK && report->wall_triangles > 0) status = sn_mesh_look_at_edges(mesh, &found, error);
    }
    bool manifold = found.nonmanifold_edges == 0 && found.nonmanifold_vertices == 0;
    if (status != SN_OK || mesh->triangle_count == 0 || (manifold && found.inconsistent_edges == 0)) return status;
    status = orient_in_place(mesh, manifold, report, error);
    if (status == SN_OK && !(manifold && report->orientable)) status = orient_and_stitch(mesh, report, error);
    return status;
}
