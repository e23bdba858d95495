/*
 * smooth.c -- smoothing without shrinkage (Taubin 1995, A signal processing approach to fair surface design), and volume put back.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#define LAMBDA 0.5
#define MU (-0.53)

static void mark_borders(const sn_topology *topology, bool *fixed) {
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        if (edge->triangle_count != 2) fixed[edge->v[0]] = fixed[edge->v[1]] = true;
    }
}

/* p += weight (mean of the neighbours - p) */
static void diffuse(sn_mesh *mesh, const sn_topology *topology, const bool *fixed, double weight, sn_vec3 *next) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_index first = topology->vertex_start[v], end = topology->vertex_start[v + 1];
        sn_vec3 sum = sn_v3(0, 0, 0);
        for (sn_index i = first; i < end; i++) sum = sn_add(sum, mesh->positions[topology->neighbours[i]]);
        bool moves = end > first && !fixed[v];
        next[v] = moves ? sn_lerp(mesh->positions[v], sn_scale(sum, 1.0 / (end - first)), weight) : mesh->positions[v];
    }
    memcpy(mesh->positions, next, (size_t)mesh->vertex_count * sizeof *next);
}

sn_status sn_smooth(sn_mesh *mesh, sn_index rounds, const bool *held, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK) status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    bool *fixed = SN_NEW(bool, mesh->vertex_count);
    sn_vec3 *next = SN_NEW(sn_vec3, mesh->vertex_count);
    if (fixed != NULL && next != NULL) {
        if (held != NULL) memcpy(fixed, held, (size_t)mesh->vertex_count * sizeof *fixed);
        mark_borders(&topology, fixed);
        for (sn_index i = 0; i < rounds; i++) {
            diffuse(mesh, &topology, fixed, LAMBDA, next);
            diffuse(mesh, &topology, fixed, MU, next);
        }
    } else {
        status = sn_fail_memory(error, "smoothing");
    }
    free(fixed);
    free(next);
    sn_topology_free(&topology);
    return status;
}

/* ---- volume ------------------------------------------------------------------------------------------------------------- */

#define MOST_STEPS 8
#define CLOSE_ENOUGH 1e-9
/* Farther than this share of the mean edge the surface would fold. */
#define FARTHEST 0.1

/* Change of volume for a unit step of every vertex along its normal: a third of each area vector weighs on each corner. */
static double volume_rate(const sn_mesh *mesh, const sn_vec3 *normals) {
    double rate = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 area = sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]);
        rate += sn_dot(area, sn_add(normals[v[0]], sn_add(normals[v[1]], normals[v[2]]))) / 6.0;
    }
    return rate;
}

sn_status sn_restore_volume(sn_mesh *mesh, double volume, sn_error *error) {
    sn_mesh_report found;
    sn_status status = sn_mesh_inspect(mesh, &found, error);
    if (status != SN_OK || !found.closed || !found.oriented) return status;
    sn_vec3 *normals = SN_NEW(sn_vec3, mesh->vertex_count);
    if (normals == NULL) return sn_fail_memory(error, "restoring a volume");
    double room = FARTHEST * found.edge_mean;
    for (int step = 0; step < MOST_STEPS && room > 0.0; step++) {
        double missing = volume - sn_mesh_volume(mesh);
        if (fabs(missing) <= CLOSE_ENOUGH * fabs(volume)) break;
        sn_mesh_vertex_normals(mesh, normals);
        double rate = volume_rate(mesh, normals);
        if (!(rate > 0.0)) break;
        double way = fmax(-room, fmin(room, missing / rate));
        for (sn_index v = 0; v < mesh->vertex_count; v++) mesh->positions[v] = sn_add_scaled(mesh->positions[v], normals[v], way);
        room -= fabs(way);
    }
    free(normals);
    return SN_OK;
}
