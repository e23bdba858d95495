/*
 * mesh.c -- storage of the indexed triangle mesh and its validation.
 */
#include "sinew/mesh.h"

#include <stdlib.h>
#include <string.h>

sn_status sn_mesh_alloc(sn_mesh *mesh, sn_index vertex_count, sn_index triangle_count, sn_error *error) {
    *mesh = (sn_mesh){0};
    if (vertex_count < 0 || triangle_count < 0) return sn_fail(error, SN_ERROR_INPUT, "a mesh cannot have a negative number of elements");
    mesh->positions = SN_NEW(sn_vec3, vertex_count);
    mesh->triangles = SN_NEW(sn_triangle, triangle_count);
    if (mesh->positions == NULL || mesh->triangles == NULL) {
        sn_mesh_free(mesh);
        return sn_fail_memory(error, "a mesh");
    }
    mesh->vertex_count = vertex_count;
    mesh->triangle_count = triangle_count;
    return SN_OK;
}

static bool copy_attributes(const sn_mesh *from, sn_mesh *to) {
    for (sn_index i = 0; i < from->attribute_count; i++) {
        const sn_attribute *source = &from->attributes[i];
        sn_attribute *copy = sn_mesh_add_attribute(to, source->name, source->components);
        if (copy == NULL) return false;
        copy->integer = source->integer;
        for (sn_index k = 0; k < source->label_count; k++) {
            if (!sn_attribute_add_label(copy, source->labels[k])) return false;
        }
        memcpy(copy->values, source->values, (size_t)from->vertex_count * (size_t)source->components * sizeof(double));
    }
    return true;
}

static bool copy_groups(const sn_mesh *from, sn_mesh *to) {
    if (from->group_count == 0) return true;
    to->triangle_group = SN_NEW(sn_index, from->triangle_count);
    to->group_names = SN_NEW(char *, from->group_count);
    if (to->triangle_group == NULL || to->group_names == NULL) return false;
    to->group_count = from->group_count;
    for (sn_index i = 0; i < from->group_count; i++) {
        to->group_names[i] = sn_strdup(from->group_names[i]);
        if (to->group_names[i] == NULL && from->group_names[i] != NULL) return false;
    }
    memcpy(to->triangle_group, from->triangle_group, (size_t)from->triangle_count * sizeof(sn_index));
    return true;
}

sn_status sn_mesh_copy(const sn_mesh *from, sn_mesh *to, sn_error *error) {
    sn_status status = sn_mesh_alloc(to, from->vertex_count, from->triangle_count, error);
    if (status != SN_OK) return status;
    if (from->vertex_count > 0) memcpy(to->positions, from->positions, (size_t)from->vertex_count * sizeof *to->positions);
    if (from->triangle_count > 0) memcpy(to->triangles, from->triangles, (size_t)from->triangle_count * sizeof *to->triangles);
    if (copy_attributes(from, to) && copy_groups(from, to)) return SN_OK;
    sn_mesh_free(to);
    return sn_fail_memory(error, "a copy of a mesh");
}

sn_attribute *sn_mesh_add_attribute(sn_mesh *mesh, const char *name, sn_index components) {
    size_t count = (size_t)mesh->attribute_count;
    sn_attribute *grown = sn_realloc(mesh->attributes, count + 1, sizeof *grown);
    if (grown == NULL) return NULL;
    mesh->attributes = grown;
    sn_attribute added = {.components = components};
    added.name = sn_strdup(name);
    added.values = SN_NEW(double, (size_t)mesh->vertex_count *(size_t)components);
    if (added.name == NULL || added.values == NULL) {
        free(added.name);
        free(added.values);
        return NULL;
    }
    grown[count] = added;
    mesh->attribute_count++;
    return &grown[count];
}

bool sn_attribute_add_label(sn_attribute *attribute, const char *text) {
    char *copy = sn_strdup(text);
    char **grown = copy != NULL ? sn_realloc(attribute->labels, (size_t)attribute->label_count + 1, sizeof *grown) : NULL;
    if (grown == NULL) {
        free(copy);
        return false;
    }
    attribute->labels = grown;
    grown[attribute->label_count++] = copy;
    return true;
}

static void free_attribute(sn_attribute *attribute) {
    for (sn_index i = 0; i < attribute->label_count; i++) free(attribute->labels[i]);
    free(attribute->labels);
    free(attribute->name);
    free(attribute->values);
}

void sn_mesh_remove_attribute(sn_mesh *mesh, const char *name) {
    sn_index kept = 0;
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        if (strcmp(mesh->attributes[i].name, name) == 0) {
            free_attribute(&mesh->attributes[i]);
        } else {
            mesh->attributes[kept++] = mesh->attributes[i];
        }
    }
    mesh->attribute_count = kept;
}

const sn_attribute *sn_mesh_attribute(const sn_mesh *mesh, const char *name) {
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        if (strcmp(mesh->attributes[i].name, name) == 0) return &mesh->attributes[i];
    }
    return NULL;
}

void sn_mesh_free(sn_mesh *mesh) {
    if (mesh == NULL) return;
    for (sn_index i = 0; i < mesh->attribute_count; i++) free_attribute(&mesh->attributes[i]);
    for (sn_index i = 0; i < mesh->group_count; i++) free(mesh->group_names[i]);
    free(mesh->attributes);
    free(mesh->group_names);
    free(mesh->triangle_group);
    free(mesh->positions);
    free(mesh->triangles);
    *mesh = (sn_mesh){0};
}

static sn_status fail_at_element(sn_error *error, sn_index element, sn_status status) {
    if (error != NULL) error->element = element;
    return status;
}

sn_status sn_mesh_validate(const sn_mesh *mesh, sn_error *error) {
    if (mesh->triangle_count <= 0) return sn_fail(error, SN_ERROR_INPUT, "the mesh has no triangles; a surface is needed");
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        if (sn_finite3(mesh->positions[i])) continue;
        sn_status status = sn_fail(error, SN_ERROR_INPUT,
                                   "vertex %d has a coordinate that is not a finite number; "
                                   "mesh-clean --repair-nonfinite drops such vertices",
                                   i);
        return fail_at_element(error, i, status);
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_index v = mesh->triangles[t].v[k];
            if (v >= 0 && v < mesh->vertex_count) continue;
            sn_status status = sn_fail(error, SN_ERROR_INPUT, "triangle %d names vertex %d, but the mesh has vertices 0 to %d", t, v,
                                       mesh->vertex_count - 1);
            return fail_at_element(error, t, status);
        }
    }
    return SN_OK;
}
