/*
 * hausdorff.c -- greatest distance between two surfaces, sampled.
 */
#include "sinew/geom.h"

#include <stdlib.h>

static double distance_to(const sn_surface *surface, sn_vec3 point) { return sn_surface_closest(surface, point, INFINITY).distance; }

/* Corners and centres of the triangles of `mesh` against the other surface; vertices that no triangle uses are no part of it. */
static double greatest_distance(const sn_mesh *mesh, const sn_surface *other, bool *seen) {
    double greatest = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 sum = sn_v3(0, 0, 0);
        for (int k = 0; k < 3; k++) {
            sum = sn_add(sum, mesh->positions[v[k]]);
            if (seen[v[k]]) continue;
            seen[v[k]] = true;
            greatest = fmax(greatest, distance_to(other, mesh->positions[v[k]]));
        }
        greatest = fmax(greatest, distance_to(other, sn_scale(sum, 1.0 / 3.0)));
    }
    return greatest;
}

sn_status sn_one_sided_distance(const sn_mesh *from, const sn_mesh *to, double *out, sn_error *error) {
    *out = 0.0;
    bool *seen = SN_NEW(bool, from->vertex_count);
    if (seen == NULL) return sn_fail_memory(error, "comparing surfaces");
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(to, &surface, error);
    if (status == SN_OK) *out = greatest_distance(from, surface, seen);
    sn_surface_destroy(surface);
    free(seen);
    return status;
}

sn_status sn_hausdorff(const sn_mesh *a, const sn_mesh *b, double *out, sn_error *error) {
    double forth = 0.0, back = 0.0;
    sn_status status = sn_one_sided_distance(a, b, &forth, error);
    if (status == SN_OK) status = sn_one_sided_distance(b, a, &back, error);
    *out = fmax(forth, back);
    return status;
}
