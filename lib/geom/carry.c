/*
 * carry.c -- attributes and groups from one surface to another that lies near it, by closest point.
 */
#include "sinew/geom.h"

#include <stdlib.h>

#include "edit.h"

static int heaviest_corner(const sn_closest *closest) {
    int heaviest = 0;
    for (int k = 1; k < 3; k++) {
        if (closest->barycentric[k] > closest->barycentric[heaviest]) heaviest = k;
    }
    return heaviest;
}

/* Labels and colours are not mixed: they come from the nearest corner. */
static double value_at(const sn_mesh *mesh, const sn_attribute *attribute, sn_index component, const sn_closest *closest) {
    const sn_index *v = mesh->triangles[closest->triangle].v;
    const double *values = attribute->values + component;
    size_t stride = (size_t)attribute->components;
    if (attribute->integer) return values[(size_t)v[heaviest_corner(closest)] * stride];
    double value = 0.0;
    for (int k = 0; k < 3; k++) value += closest->barycentric[k] * values[(size_t)v[k] * stride];
    return value;
}

static void carry_values(const sn_mesh *from, const sn_surface *surface, sn_mesh *to) {
    for (sn_index i = 0; i < to->vertex_count; i++) {
        sn_closest closest = sn_surface_closest(surface, to->positions[i], INFINITY);
        for (sn_index a = 0; a < from->attribute_count && closest.triangle != SN_NONE; a++) {
            const sn_attribute *attribute = &from->attributes[a];
            double *values = to->attributes[a].values + (size_t)i * (size_t)attribute->components;
            for (sn_index c = 0; c < attribute->components; c++) values[c] = value_at(from, attribute, c, &closest);
        }
    }
}

/* A triangle goes to the group at its centre. */
static void carry_groups(const sn_mesh *from, const sn_surface *surface, sn_mesh *to) {
    for (sn_index t = 0; to->triangle_group != NULL && t < to->triangle_count; t++) {
        const sn_index *v = to->triangles[t].v;
        sn_vec3 sum = sn_add(to->positions[v[0]], sn_add(to->positions[v[1]], to->positions[v[2]]));
        sn_closest closest = sn_surface_closest(surface, sn_scale(sum, 1.0 / 3.0), INFINITY);
        to->triangle_group[t] = closest.triangle != SN_NONE ? from->triangle_group[closest.triangle] : SN_NONE;
    }
}

bool sn_mesh_copy_names(const sn_mesh *from, sn_mesh *to) {
    for (sn_index i = 0; i < from->attribute_count; i++) {
        sn_attribute *copy = sn_mesh_add_attribute(to, from->attributes[i].name, from->attributes[i].components);
        if (copy == NULL) return false;
        copy->integer = from->attributes[i].integer;
    }
    if (from->group_count == 0) return true;
    to->triangle_group = SN_NEW(sn_index, to->triangle_count);
    to->group_names = SN_NEW(char *, from->group_count);
    if (to->triangle_group == NULL || to->group_names == NULL) return false;
    to->group_count = from->group_count;
    for (sn_index i = 0; i < from->group_count; i++) {
        to->group_names[i] = sn_strdup(from->group_names[i]);
        if (to->group_names[i] == NULL && from->group_names[i] != NULL) return false;
    }
    return true;
}

sn_status sn_carry_attributes(const sn_mesh *from, sn_mesh *to, sn_error *error) {
    if (from->attribute_count == 0 && from->group_count == 0) return SN_OK;
    bool named = to->attribute_count > 0 || to->group_count > 0;
    if (!named && !sn_mesh_copy_names(from, to)) return sn_fail_memory(error, "carrying painted values over");
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create_plain(from, &surface, error);
    if (status == SN_OK) {
        carry_values(from, surface, to);
        carry_groups(from, surface, to);
    }
    sn_surface_destroy(surface);
    return status;
}
