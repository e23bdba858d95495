/*
 * decimate.c -- decimation, attributes and groups following by closest point.
 */
#include "sinew/geom.h"

#include "bridge.h"

static sn_status collapse_edges(sn_mesh *mesh, sn_index target, bool bounded, const bool *held, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_decimate(&in, target, bounded, held, &out, error);
    if (status == SN_OK) status = sn_from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = sn_carry_attributes(mesh, &after, error);
    if (status == SN_OK) sn_mesh_replace(mesh, &after);
    sn_mesh_free(&after);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status;
}

sn_status sn_decimate(sn_mesh *mesh, sn_index target_triangles, const bool *held, sn_error *error) {
    if (target_triangles < 4)
        return sn_fail(error, SN_ERROR_USAGE, "a closed surface needs at least 4 triangles, not %d", target_triangles);
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK && mesh->triangle_count > target_triangles) status = collapse_edges(mesh, target_triangles, true, held, error);
    if (status == SN_OK && held == NULL && mesh->triangle_count > target_triangles)
        status = collapse_edges(mesh, target_triangles, false, NULL, error);
    return status;
}
