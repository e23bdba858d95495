/*
 * slivers.c -- flips of the longest edges of thin triangles.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"

#define MOST_ROUNDS 16
/* cos 5 degrees: beyond it a flip would show. */
#define FLAT_ENOUGH 0.99619469809174555

static double quality_of(const sn_mesh *mesh, sn_triangle t) {
    return sn_triangle_quality(mesh->positions[t.v[0]], mesh->positions[t.v[1]], mesh->positions[t.v[2]]);
}

static sn_vec3 normal_of(const sn_mesh *mesh, sn_triangle t) {
    return sn_normalize(sn_area_vector(mesh->positions[t.v[0]], mesh->positions[t.v[1]], mesh->positions[t.v[2]]));
}

/* The two triangles on the other diagonal are better, and lie as the better of the old two does. */
static bool improves(const sn_mesh *mesh, sn_triangle old, sn_triangle neighbour, sn_triangle first, sn_triangle second) {
    double before = fmin(quality_of(mesh, old), quality_of(mesh, neighbour));
    double after = fmin(quality_of(mesh, first), quality_of(mesh, second));
    sn_vec3 normal = normal_of(mesh, quality_of(mesh, old) < quality_of(mesh, neighbour) ? neighbour : old);
    return after > before && sn_dot(normal, normal_of(mesh, first)) > FLAT_ENOUGH && sn_dot(normal, normal_of(mesh, second)) > FLAT_ENOUGH;
}

/* Turn the longest edge of t; false = not possible or no better. touched (vertex_count): adjacency is no longer right there. */
static bool flip_longest(sn_mesh *mesh, const sn_topology *topology, sn_index t, bool *touched) {
    sn_triangle old = mesh->triangles[t];
    int k = sn_triangle_longest_edge(mesh, old);
    const sn_edge *edge = &topology->edges[topology->triangle_edges[t][k]];
    if (edge->triangle_count != 2) return false;
    int other = edge->triangle[0] == t ? 1 : 0;
    sn_index neighbour = edge->triangle[other], far = edge->opposite[other];
    sn_index near = old.v[k], a = old.v[(k + 1) % 3], b = old.v[(k + 2) % 3];
    if (touched[near] || touched[far] || touched[a] || touched[b]) return false;
    if (far == near || sn_topology_edge(topology, near, far) != SN_NONE) return false;
    sn_triangle first = {{near, a, far}}, second = {{near, far, b}};
    if (!improves(mesh, old, mesh->triangles[neighbour], first, second)) return false;
    mesh->triangles[t] = first;
    mesh->triangles[neighbour] = second;
    touched[near] = touched[far] = touched[a] = touched[b] = true;
    return true;
}

static sn_status flip_round(sn_mesh *mesh, const bool *held, sn_index *flipped, sn_error *error) {
    sn_topology topology;
    *flipped = 0;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    bool *touched = SN_NEW(bool, mesh->vertex_count);
    if (touched != NULL && held != NULL) memcpy(touched, held, (size_t)mesh->vertex_count * sizeof *touched);
    for (sn_index t = 0; touched != NULL && t < mesh->triangle_count; t++) {
        bool thin = !sn_triangle_repeats_index(mesh->triangles[t]) && quality_of(mesh, mesh->triangles[t]) < SN_SLIVER_QUALITY;
        if (thin) *flipped += flip_longest(mesh, &topology, t, touched);
    }
    sn_topology_free(&topology);
    if (touched == NULL) return sn_fail_memory(error, "flipping slivers");
    free(touched);
    return SN_OK;
}

sn_status sn_flip_slivers(sn_mesh *mesh, const bool *held, sn_index *flipped, sn_error *error) {
    *flipped = 0;
    sn_index now = 1;
    sn_status status = sn_mesh_validate(mesh, error);
    for (int round = 0; status == SN_OK && now > 0 && round < MOST_ROUNDS; round++) {
        status = flip_round(mesh, held, &now, error);
        *flipped += now;
    }
    return status;
}
