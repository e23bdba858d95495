/* fibers.c -- fibre directions as short lines along the surface, each walked over the triangles step by step. */
#include "show.h"

#include <stdlib.h>

enum { MARKS = 1200, STEPS = 5, POLYLINES = 400 };
static const double RADIUS = 0.0007;

/* The direction field at a point of the surface: corners' directions, signs aligned with `along`, weighted, made tangent. */
static sn_vec3 direction_at(const sn_muscle *muscle, const sn_closest *at, sn_vec3 along) {
    const sn_index *v = muscle->mesh.triangles[at->triangle].v;
    const sn_vec3 *p = muscle->mesh.positions;
    sn_vec3 sum = {0, 0, 0};
    for (int c = 0; c < 3; c++) {
        sn_vec3 f = muscle->fibers.directions[v[c]];
        sum = sn_add_scaled(sum, f, sn_dot(f, along) < 0.0 ? -at->barycentric[c] : at->barycentric[c]);
    }
    sn_vec3 n = sn_normalize(sn_area_vector(p[v[0]], p[v[1]], p[v[2]]));
    return sn_normalize(sn_add_scaled(sum, n, -sn_dot(sum, n)));
}

/* Walk from a vertex along the field, or against it. */
static sn_status walk(sn_view *view, const sn_muscle *muscle, const sn_surface *surface, sn_index vertex, double length, double sign,
                      sn_error *error) {
    double step = length / STEPS, unit = muscle->meters_per_unit;
    sn_vec3 here = muscle->mesh.positions[vertex], along = sn_scale(muscle->fibers.directions[vertex], sign);
    for (int i = 0; i < STEPS && sn_norm2(along) > 0.0; i++) {
        sn_closest next = sn_surface_closest(surface, sn_add_scaled(here, along, step), 2.0 * step);
        if (next.triangle == SN_NONE) break;
        sn_view_tube tube = {sn_scale(here, unit), sn_scale(next.point, unit), RADIUS, COLOR_FIBER};
        sn_status status = sn_view_add_tube(view, tube, error);
        if (status) return status;
        along = direction_at(muscle, &next, along);
        here = next.point;
    }
    return SN_OK;
}

static sn_status show_directions(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    sn_index count = 0, *marks = NULL;
    sn_surface *surface = NULL;
    double spacing;
    sn_status status = spread_vertices(&muscle->mesh, MARKS, &count, &marks, &spacing, error);
    if (!status) status = sn_surface_create(&muscle->mesh, &surface, error);
    double length = fmax(0.75 * spacing, 0.006 * sn_box_diagonal(sn_mesh_box(&muscle->mesh)));
    for (sn_index i = 0; i < count && !status; i++) {
        status = walk(view, muscle, surface, marks[i], length, 1.0, error);
        if (!status) status = walk(view, muscle, surface, marks[i], length, -1.0, error);
    }
    sn_surface_destroy(surface);
    free(marks);
    return status;
}

static sn_status show_polylines(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    const sn_fibers *fibers = &muscle->fibers;
    const double unit = muscle->meters_per_unit;
    sn_index step = fibers->polyline_count > 0 ? (fibers->polyline_count - 1) / POLYLINES + 1 : 1;
    sn_status status = SN_OK;
    for (sn_index i = 0; i < fibers->polyline_count; i += step)
        for (sn_index k = 1; k < fibers->polylines[i].count && !status; k++) {
            const sn_vec3 *p = fibers->polylines[i].points;
            status = sn_view_add_tube(view, (sn_view_tube){sn_scale(p[k - 1], unit), sn_scale(p[k], unit), RADIUS, COLOR_FIBER}, error);
        }
    return status;
}

sn_status show_fibers(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    sn_status status = muscle->fibers.directions ? show_directions(view, muscle, error) : SN_OK;
    if (!status) status = show_polylines(view, muscle, error);
    if (!status) status = sn_view_add_entry(view, SN_MARK_LINE, COLOR_FIBER, "fibre directions", error);
    return status;
}
