/*
 * decimate.c -- decimation, with attributes and groups carried over by closest point.
 */
#include "sinew/geom.h"

#include "bridge.h"

static double value_at(const sn_mesh *mesh, const sn_attribute *attribute, sn_index component, const sn_closest *closest) {
    double value = 0.0;
    for (int k = 0; k < 3; k++) {
        sn_index v = mesh->triangles[closest->triangle].v[k];
        value += closest->barycentric[k] * attribute->values[(size_t)v * (size_t)attribute->components + (size_t)component];
    }
    return attribute->integer ? round(value) : value;
}

static void carry_values(const sn_mesh *before, const sn_surface *surface, sn_mesh *after) {
    for (sn_index i = 0; i < after->vertex_count; i++) {
        sn_closest closest = sn_surface_closest(surface, after->positions[i], INFINITY);
        for (sn_index a = 0; a < before->attribute_count && closest.triangle != SN_NONE; a++) {
            const sn_attribute *from = &before->attributes[a];
            double *values = after->attributes[a].values + (size_t)i * (size_t)from->components;
            for (sn_index c = 0; c < from->components; c++) values[c] = value_at(before, from, c, &closest);
        }
    }
}

/* A triangle goes to the group at its centre. */
static void carry_groups(const sn_mesh *before, const sn_surface *surface, sn_mesh *after) {
    for (sn_index t = 0; after->triangle_group != NULL && t < after->triangle_count; t++) {
        const sn_index *v = after->triangles[t].v;
        sn_vec3 sum = sn_add(after->positions[v[0]], sn_add(after->positions[v[1]], after->positions[v[2]]));
        sn_closest closest = sn_surface_closest(surface, sn_scale(sum, 1.0 / 3.0), INFINITY);
        after->triangle_group[t] = closest.triangle != SN_NONE ? before->triangle_group[closest.triangle] : SN_NONE;
    }
}

static sn_status carry_over(const sn_mesh *before, sn_mesh *after, sn_error *error) {
    if (before->attribute_count == 0 && before->group_count == 0) return SN_OK;
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(before, &surface, error);
    if (status == SN_OK) {
        carry_values(before, surface, after);
        carry_groups(before, surface, after);
    }
    sn_surface_destroy(surface);
    return status;
}

static sn_status collapse_edges(sn_mesh *mesh, sn_index target, bool bounded, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_decimate(&in, target, bounded, &out, error);
    if (status == SN_OK) status = sn_from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = carry_over(mesh, &after, error);
    if (status == SN_OK) sn_mesh_replace(mesh, &after);
    sn_mesh_free(&after);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status;
}

sn_status sn_decimate(sn_mesh *mesh, sn_index target_triangles, sn_error *error) {
    if (target_triangles < 4)
        return sn_fail(error, SN_ERROR_USAGE, "a closed surface needs at least 4 triangles, not %d", target_triangles);
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK && mesh->triangle_count > target_triangles) status = collapse_edges(mesh, target_triangles, true, error);
    if (status == SN_OK && mesh->triangle_count > target_triangles) status = collapse_edges(mesh, target_triangles, false, error);
    return status;
}
