/* fibers.c -- fibre directions as short lines along the surface, each walked over the triangles step by step. */
#include "show.h"

#include <stdio.h>
#include <stdlib.h>

enum { MARKS = 1200, STEPS = 5, POLYLINES = 400 };
static const double RADIUS = 0.0007, VOLUME_RADIUS = 0.0011;

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

/* Draws short lines over the surface of a muscle. */
typedef struct brush {
    sn_view *view;
    const sn_muscle *muscle;
    const sn_surface *surface;
    double length; /* of a line, to each side of its vertex; in the muscle's unit */
} brush;

/* Walk from a vertex along the field (sign 1), or against it (-1). */
static sn_status walk(const brush *b, sn_index vertex, double sign, sn_error *error) {
    const sn_muscle *muscle = b->muscle;
    double step = b->length / STEPS, unit = muscle->meters_per_unit;
    sn_vec3 here = muscle->mesh.positions[vertex], along = sn_scale(muscle->fibers.directions[vertex], sign);
    for (int i = 0; i < STEPS && sn_norm2(along) > 0.0; i++) {
        sn_closest next = sn_surface_closest(b->surface, sn_add_scaled(here, along, step), 2.0 * step);
        if (next.triangle == SN_NONE) break;
        sn_view_tube tube = {sn_scale(here, unit), sn_scale(next.point, unit), RADIUS, COLOR_FIBER};
        sn_status status = sn_view_add_tube(b->view, tube, error);
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
    if (!status) status = sn_surface_create_plain(&muscle->mesh, &surface, error);
    const brush b = {view, muscle, surface, fmax(0.75 * spacing, 0.006 * sn_box_diagonal(sn_mesh_box(&muscle->mesh)))};
    for (sn_index i = 0; i < count && !status; i++) {
        status = walk(&b, marks[i], 1.0, error);
        if (!status) status = walk(&b, marks[i], -1.0, error);
    }
    sn_surface_destroy(surface);
    free(marks);
    return status;
}

/* Fibre i's colour: neighbours in a bundle come from anywhere in the list, so that hues a golden angle apart tell them from each other. */
static sn_color fiber_color(sn_index i) {
    double hue = fmod(0.08 + 0.61803398875 * i, 1.0);
    double r = 0.5 + 0.5 * sn_cos(2.0 * SN_PI * hue), g = 0.5 + 0.5 * sn_cos(2.0 * SN_PI * (hue - 1.0 / 3.0)),
           b = 0.5 + 0.5 * sn_cos(2.0 * SN_PI * (hue - 2.0 / 3.0));
    return (sn_color){0.15 + 0.85 * r, 0.15 + 0.75 * g, 0.15 + 0.85 * b};
}

static sn_status show_polyline(sn_view *view, const sn_polyline *line, double unit, sn_color color, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index k = 1; k < line->count && !status; k++) {
        sn_view_tube tube = {sn_scale(line->points[k - 1], unit), sn_scale(line->points[k], unit), VOLUME_RADIUS, color};
        status = sn_view_add_tube(view, tube, error);
    }
    return status;
}

static sn_status show_polylines(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    const sn_fibers *fibers = &muscle->fibers;
    sn_index step = (fibers->polyline_count - 1) / POLYLINES + 1, shown = 0;
    sn_status status = SN_OK;
    for (sn_index i = 0; i < fibers->polyline_count && !status; i += step, shown++)
        status = show_polyline(view, &fibers->polylines[i], muscle->meters_per_unit, fiber_color(shown), error);
    if (status) return status;
    char detail[64];
    if (shown < fibers->polyline_count)
        snprintf(detail, sizeof detail, "%d of %d", shown, fibers->polyline_count);
    else
        snprintf(detail, sizeof detail, "%d", shown);
    return sn_view_add_entry_detail(view, SN_MARK_LINE, fiber_color(0), "fibres", detail, error);
}

/* Fibres through the volume come after the directions on the surface that led to them, and would be hidden by these. */
sn_status show_fibers(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    if (muscle->fibers.polyline_count > 0) return show_polylines(view, muscle, error);
    sn_status status = muscle->fibers.directions ? show_directions(view, muscle, error) : SN_OK;
    if (!status) status = sn_view_add_entry(view, SN_MARK_LINE, COLOR_FIBER, "fibre directions", error);
    return status;
}
