/*
 * bridge.c -- meshes to the arrays of the CGAL bridge and back, validated on the way there and checked on the way back.
 */
#include "bridge.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"

void sn_bridge_free(sn_bridge_mesh *mesh) {
    free(mesh->points);
    free(mesh->triangles);
    free(mesh->vertex_origin);
    free(mesh->triangle_origin);
    *mesh = (sn_bridge_mesh){0};
}

static sn_status find_frame(const sn_mesh *mesh, sn_bridge_frame *out, sn_error *error) {
    sn_status status = sn_mesh_validate(mesh, error);
    if (status != SN_OK) return status;
    sn_box box = sn_mesh_box(mesh);
    *out = (sn_bridge_frame){sn_lerp(box.low, box.high, 0.5), sn_box_diagonal(box)};
    if (out->size > 0.0 && isfinite(out->size)) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "the surface has no extent that can be computed with (diagonal %g)", out->size);
}

/* Triangles with a repeated index must be gone: CGAL does not expect them. */
sn_status sn_bridge_check_indices(const sn_mesh *mesh, sn_error *error) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!sn_triangle_repeats_index(mesh->triangles[t])) continue;
        return sn_fail(error, SN_ERROR_INPUT, "triangle %d names a vertex twice; drop degenerate triangles first", t);
    }
    return SN_OK;
}

sn_status sn_to_bridge(const sn_mesh *mesh, sn_bridge_mesh *out, sn_bridge_frame *where, sn_error *error) {
    *out = (sn_bridge_mesh){.vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count};
    sn_status status = find_frame(mesh, where, error);
    if (status != SN_OK) return status;
    out->points = sn_alloc((size_t)mesh->vertex_count, 3 * sizeof *out->points);
    out->triangles = sn_alloc((size_t)mesh->triangle_count, 3 * sizeof *out->triangles);
    if (out->points == NULL || out->triangles == NULL) {
        sn_bridge_free(out);
        return sn_fail_memory(error, "repairing a mesh");
    }
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_vec3 q = sn_scale(sn_sub(mesh->positions[i], where->centre), 1.0 / where->size);
        memcpy(out->points + 3 * (size_t)i, (double[]){q.x, q.y, q.z}, 3 * sizeof(double));
    }
    memcpy(out->triangles, mesh->triangles, (size_t)mesh->triangle_count * sizeof *mesh->triangles);
    return SN_OK;
}

/* A vertex that the library left where it was gets the very coordinates it had. */
static sn_vec3 position_back(const sn_mesh *before, const sn_bridge_mesh *in, const sn_bridge_mesh *out, sn_bridge_frame where,
                             sn_index i) {
    sn_index origin = out->vertex_origin[i];
    const double *q = out->points + 3 * (size_t)i;
    bool unmoved = origin != SN_NONE && memcmp(q, in->points + 3 * (size_t)origin, 3 * sizeof *q) == 0;
    return unmoved ? before->positions[origin] : sn_add_scaled(where.centre, sn_v3(q[0], q[1], q[2]), where.size);
}

static sn_status check_back(const sn_bridge_mesh *out, sn_error *error) {
    for (size_t i = 0; i < 3 * (size_t)out->vertex_count; i++) {
        if (!isfinite(out->points[i]))
            return sn_fail(error, SN_ERROR_INTERNAL, "the repair library returned a coordinate that is not finite");
    }
    for (size_t i = 0; i < 3 * (size_t)out->triangle_count; i++) {
        if (out->triangles[i] < 0 || out->triangles[i] >= out->vertex_count) {
            return sn_fail(error, SN_ERROR_INTERNAL, "the repair library returned an index out of range");
        }
    }
    return SN_OK;
}

static void carry_attributes(const sn_mesh *before, const sn_index *vertex_origin, sn_mesh *after) {
    for (sn_index a = 0; a < before->attribute_count; a++) {
        size_t components = (size_t)before->attributes[a].components;
        for (sn_index i = 0; i < after->vertex_count; i++) {
            if (vertex_origin[i] == SN_NONE) continue;
            memcpy(after->attributes[a].values + (size_t)i * components,
                   before->attributes[a].values + (size_t)vertex_origin[i] * components, components * sizeof(double));
        }
    }
}

/* *after is the mesh that came back, with the attributes and groups of the vertices and triangles that it came from. */
sn_status sn_from_bridge(const sn_mesh *before, const sn_bridge_mesh *in, const sn_bridge_mesh *out, sn_bridge_frame where, sn_mesh *after,
                         sn_error *error) {
    sn_status status = check_back(out, error);
    if (status == SN_OK) status = sn_mesh_alloc(after, out->vertex_count, out->triangle_count, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < out->vertex_count; i++) after->positions[i] = position_back(before, in, out, where, i);
    memcpy(after->triangles, out->triangles, (size_t)out->triangle_count * sizeof *after->triangles);
    if (!sn_mesh_copy_names(before, after)) {
        sn_mesh_free(after);
        return sn_fail_memory(error, "repairing a mesh");
    }
    carry_attributes(before, out->vertex_origin, after);
    for (sn_index t = 0; after->triangle_group != NULL && t < after->triangle_count; t++) {
        sn_index origin = out->triangle_origin[t];
        after->triangle_group[t] = origin != SN_NONE ? before->triangle_group[origin] : SN_NONE;
    }
    return SN_OK;
}

void sn_mesh_replace(sn_mesh *mesh, sn_mesh *by) {
    sn_mesh_free(mesh);
    *mesh = *by;
    *by = (sn_mesh){0};
}
