/*
 * intersections.c -- pairs of triangles that cross.
 */
#include "sinew/geom.h"

#include "bridge.h"

sn_status sn_count_self_intersections(const sn_mesh *mesh, sn_index *pairs, sn_error *error) {
    *pairs = 0;
    sn_bridge_mesh in = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_count_intersections(&in, pairs, error);
    sn_bridge_free(&in);
    return status;
}
