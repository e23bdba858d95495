/* view.c -- what a picture shows: growing, copying, freeing. */
#include "sinew/view.h"

#include <stdlib.h>
#include <string.h>

static void mesh_free(sn_view_mesh *mesh) {
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->paints);
    free(mesh->paint);
}

void sn_view_free(sn_view *view) {
    for (size_t i = 0; i < view->mesh_count; i++) mesh_free(&view->meshes[i]);
    for (size_t i = 0; i < view->entry_count; i++) free(view->entries[i].text);
    free(view->meshes);
    free(view->tubes);
    free(view->entries);
    free(view->title);
    free(view->subtitle);
    *view = (sn_view){0};
}

sn_status sn_view_add_mesh(sn_view *view, const sn_mesh *mesh, double meters_per_unit, const sn_rigid *pose, sn_color color,
                           sn_view_mesh **out, sn_error *error) {
    sn_view_mesh copy = {.vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count, .color = color, .opacity = 1.0};
    copy.positions = SN_NEW(sn_vec3, mesh->vertex_count);
    copy.triangles = SN_NEW(sn_triangle, mesh->triangle_count);
    if (!copy.positions || !copy.triangles ||
        !sn_grow((void **)&view->meshes, &view->mesh_capacity, view->mesh_count + 1, sizeof(sn_view_mesh))) {
        mesh_free(&copy);
        return sn_fail_memory(error, "a mesh of the picture");
    }
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_vec3 p = sn_scale(mesh->positions[i], meters_per_unit);
        copy.positions[i] = pose ? sn_rigid_apply(*pose, p) : p;
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

sn_status sn_view_add_entry(sn_view *view, sn_view_mark mark, sn_color color, const char *text, sn_error *error) {
    for (size_t i = 0; i < view->entry_count; i++)
        if (strcmp(view->entries[i].text, text) == 0) return SN_OK;
    char *copy = sn_strdup(text);
    if (!copy || !sn_grow((void **)&view->entries, &view->entry_capacity, view->entry_count + 1, sizeof(sn_view_entry))) {
        free(copy);
        return sn_fail_memory(error, "the legend");
    }
    view->entries[view->entry_count++] = (sn_view_entry){copy, mark, color};
    return SN_OK;
}
