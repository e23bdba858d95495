/* view.c -- what a picture shows: growing, copying, freeing. */
#include "sinew/view.h"

#include <stdlib.h>
#include <string.h>

static void mesh_free(sn_view_mesh *mesh) {
    free(mesh->name);
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->paints);
    free(mesh->paint);
    free(mesh->colors);
}

void sn_view_free(sn_view *view) {
    for (size_t i = 0; i < view->mesh_count; i++) mesh_free(&view->meshes[i]);
    for (size_t i = 0; i < view->entry_count; i++) {
        free(view->entries[i].text);
        free(view->entries[i].detail);
    }
    sn_palette_free(&view->own_palette);
    free(view->scale.text);
    free(view->rings);
    free(view->meshes);
    free(view->tubes);
    free(view->entries);
    free(view->title);
    free(view->subtitle);
    *view = (sn_view){0};
}

sn_status sn_view_add_mesh(sn_view *view, const sn_mesh *mesh, sn_placement placement, sn_color color, sn_view_mesh **out,
                           sn_error *error) {
    sn_view_mesh copy = {.vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count, .color = color, .opacity = 1.0};
    copy.positions = SN_NEW(sn_vec3, mesh->vertex_count);
    copy.triangles = SN_NEW(sn_triangle, mesh->triangle_count);
    if (!copy.positions || !copy.triangles ||
        !sn_grow((void **)&view->meshes, &view->mesh_capacity, view->mesh_count + 1, sizeof(sn_view_mesh))) {
        mesh_free(&copy);
        return sn_fail_memory(error, "a mesh of the picture");
    }
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_vec3 p = sn_scale(mesh->positions[i], placement.meters_per_unit);
        copy.positions[i] = placement.pose ? sn_rigid_apply(*placement.pose, p) : p;
    }
    if (mesh->triangle_count > 0) memcpy(copy.triangles, mesh->triangles, (size_t)mesh->triangle_count * sizeof(sn_triangle));
    view->meshes[view->mesh_count] = copy;
    if (out) *out = &view->meshes[view->mesh_count];
    view->mesh_count++;
    return SN_OK;
}

sn_status sn_view_add_tube(sn_view *view, sn_view_tube tube, sn_error *error) {
    if (!sn_grow((void **)&view->tubes, &view->tube_capacity, view->tube_count + 1, sizeof tube))
        return sn_fail_memory(error, "the lines of the picture");
    view->tubes[view->tube_count++] = tube;
    return SN_OK;
}

static bool same_color(sn_color a, sn_color b) { return !(fabs(a.r - b.r) + fabs(a.g - b.g) + fabs(a.b - b.b) > 0.0); }

sn_status sn_view_add_entry_detail(sn_view *view, sn_view_mark mark, sn_color color, const char *text, const char *detail,
                                   sn_error *error) {
    for (size_t i = 0; i < view->entry_count; i++) {
        sn_view_entry *known = &view->entries[i];
        if (strcmp(known->text, text) != 0 || !same_color(known->color, color)) continue;
        if (known->detail && (!detail || strcmp(known->detail, detail) != 0)) {
            free(known->detail);
            known->detail = NULL;
        }
        return SN_OK;
    }
    sn_view_entry entry = {sn_strdup(text), detail ? sn_strdup(detail) : NULL, mark, color};
    if (!entry.text || (detail && !entry.detail) ||
        !sn_grow((void **)&view->entries, &view->entry_capacity, view->entry_count + 1, sizeof(sn_view_entry))) {
        free(entry.text);
        free(entry.detail);
        return sn_fail_memory(error, "the legend");
    }
    view->entries[view->entry_count++] = entry;
    return SN_OK;
}

sn_status sn_view_add_entry(sn_view *view, sn_view_mark mark, sn_color color, const char *text, sn_error *error) {
    return sn_view_add_entry_detail(view, mark, color, text, NULL, error);
}

sn_status sn_view_add_ring(sn_view *view, sn_vec3 at, sn_error *error) {
    if (!sn_grow((void **)&view->rings, &view->ring_capacity, view->ring_count + 1, sizeof at))
        return sn_fail_memory(error, "the marks of the picture");
    view->rings[view->ring_count++] = at;
    return SN_OK;
}

size_t sn_view_focus(sn_view *view, const char *pattern) {
    size_t count = 0;
    for (size_t i = 0; i < view->mesh_count; i++) {
        sn_view_mesh *mesh = &view->meshes[i];
        if (!mesh->name || !sn_pattern_matches(pattern, mesh->name)) continue;
        mesh->focus = true;
        count++;
    }
    return count;
}

/* From a cool blue over yellow and red to purple: told apart by their hue, as light and shade change the brightness. */
sn_color sn_scale_color(double t) {
    static const sn_color stops[6] = {{0.56, 0.72, 0.86}, {0.80, 0.88, 0.80}, {0.97, 0.87, 0.48},
                                      {0.95, 0.58, 0.20}, {0.83, 0.18, 0.17}, {0.46, 0.05, 0.42}};
    double at = 5.0 * (t < 1.0 ? fmax(t, 0.0) : 1.0);
    int below = at < 4.0 ? (int)at : 4;
    double share = at - below;
    const sn_color *a = &stops[below], *b = &stops[below + 1];
    return (sn_color){a->r + (b->r - a->r) * share, a->g + (b->g - a->g) * share, a->b + (b->b - a->b) * share};
}
