/*
 * wrap.c -- a new closed surface around triangles that no exact repair can close.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "bridge.h"

static sn_status wrap_by_library(const sn_mesh *mesh, double alpha, double offset, sn_mesh *out, sn_error *error) {
    sn_bridge_mesh in = {0}, around = {0};
    sn_bridge_frame where;
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_wrap(&in, alpha / where.size, offset / where.size, &around, error);
    sn_mesh bare = {.vertex_count = mesh->vertex_count, .positions = mesh->positions};
    if (status == SN_OK) status = sn_from_bridge(&bare, &in, &around, where, out, error);
    sn_bridge_free(&in);
    sn_bridge_free(&around);
    return status;
}

#define REST 0.25 /* share of the offset that is left between soup and wrap */

/* The way from every vertex of the wrap back towards the soup, all but that: back (vertex_count). */
static void find_ways_back(const sn_mesh *wrap, const sn_surface *soup, double offset, sn_vec3 *back) {
    for (sn_index v = 0; v < wrap->vertex_count; v++) {
        sn_closest closest = sn_surface_closest(soup, wrap->positions[v], INFINITY);
        double way = fmin(offset * (1.0 - REST), closest.distance - offset * REST);
        if (!(way > 0.0)) continue; /* zero already */
        back[v] = sn_scale(sn_sub(closest.point, wrap->positions[v]), way / closest.distance);
    }
}

/* Shares of the way back that are tried until no triangles cross; none is the last. */
static const double tried_shares[] = {1.0, 0.75, 0.5, 0.25};

static sn_status draw_back(sn_mesh *wrap, const sn_vec3 *back, sn_error *error) {
    sn_mesh drawn;
    sn_status status = sn_mesh_copy(wrap, &drawn, error);
    for (size_t i = 0; status == SN_OK && i < sizeof tried_shares / sizeof *tried_shares; i++) {
        sn_index crossings = 0;
        sn_mesh_report found = {0};
        for (sn_index v = 0; v < wrap->vertex_count; v++) {
            drawn.positions[v] = sn_add_scaled(wrap->positions[v], back[v], tried_shares[i]);
        }
        status = sn_mesh_inspect(&drawn, &found, error);
        if (status == SN_OK) status = sn_count_self_intersections(&drawn, &crossings, error);
        if (status == SN_OK && crossings == 0 && found.manifold && found.volume > 0.0) {
            memcpy(wrap->positions, drawn.positions, (size_t)wrap->vertex_count * sizeof *wrap->positions);
            break;
        }
    }
    sn_mesh_free(&drawn);
    return status;
}

sn_status sn_wrap(const sn_mesh *mesh, double alpha, double offset, sn_mesh *out, sn_error *error) {
    *out = (sn_mesh){0};
    if (!(alpha > 0.0) || !(offset > 0.0)) return sn_fail(error, SN_ERROR_USAGE, "a wrap needs an alpha and an offset above 0");
    sn_surface *soup = NULL;
    sn_vec3 *back = NULL;
    sn_status status = wrap_by_library(mesh, alpha, offset, out, error);
    if (status == SN_OK && out->triangle_count == 0) {
        status = sn_fail(error, SN_ERROR_INTERNAL, "the wrap is empty: with an alpha of %g, no part of the surface is wide enough", alpha);
    }
    if (status == SN_OK) status = sn_surface_create_plain(mesh, &soup, error);
    if (status == SN_OK) {
        back = SN_NEW(sn_vec3, out->vertex_count);
        if (back == NULL) status = sn_fail_memory(error, "wrapping");
    }
    if (status == SN_OK) {
        find_ways_back(out, soup, offset, back);
        status = draw_back(out, back, error);
    }
    free(back);
    sn_surface_destroy(soup);
    if (status != SN_OK) sn_mesh_free(out);
    return status;
}
