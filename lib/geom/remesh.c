/*
 * remesh.c -- isotropic remeshing, within limits that are looked at before the library starts.
 */
#include "sinew/geom.h"

#include "bridge.h"

#define ITERATIONS 3
#define MOST_TRIANGLES 1e7
/* A surface of fewer equilateral triangles than this would be no more than a simplex. */
#define LEAST_TRIANGLES 16

/* Equilateral triangles with this edge: sqrt(3)/4 length^2 each. */
static sn_status check_length(const sn_mesh_report *found, double edge_length, sn_error *error) {
    double triangles = found->area / (0.25 * sqrt(3.0) * edge_length * edge_length);
    if (!(edge_length > 0.0) || triangles > MOST_TRIANGLES) {
        return sn_fail(error, SN_ERROR_USAGE, "edges of %g would make %.3g triangles of this surface; ask for longer ones", edge_length,
                       triangles);
    }
    if (triangles >= LEAST_TRIANGLES) return SN_OK;
    return sn_fail(error, SN_ERROR_USAGE, "edges of %g are too long for a surface with a diagonal of %g; ask for shorter ones", edge_length,
                   found->diagonal);
}

static sn_status check_result(const sn_mesh *after, const sn_mesh_report *found, sn_error *error) {
    sn_mesh_report now = {0};
    sn_status status = after->triangle_count > 0 ? sn_mesh_inspect(after, &now, error) : SN_OK;
    if (status != SN_OK || (now.manifold && now.oriented && now.closed == found->closed)) return status;
    return sn_fail(error, SN_ERROR_INTERNAL, "remeshing broke the surface; another edge length may do, or decimation");
}

sn_status sn_remesh(sn_mesh *mesh, double edge_length, const bool *held, sn_error *error) {
    sn_mesh_report found;
    sn_status status = sn_mesh_inspect(mesh, &found, error);
    if (status == SN_OK) status = check_length(&found, edge_length, error);
    if (status == SN_OK && (!found.manifold || !found.oriented)) {
        status = sn_fail(error, SN_ERROR_INPUT, "only an oriented manifold can be remeshed");
    }
    if (status != SN_OK) return status;
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    sn_bridge_frame where;
    status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_remesh(&in, edge_length / where.size, ITERATIONS, held, &out, error);
    if (status == SN_OK) status = sn_from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = check_result(&after, &found, error);
    if (status == SN_OK) status = sn_carry_attributes(mesh, &after, error);
    if (status == SN_OK) sn_mesh_replace(mesh, &after);
    sn_mesh_free(&after);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status;
}
