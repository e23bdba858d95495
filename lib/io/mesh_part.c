/* mesh_part.c -- the meshes of one file: the objects of a scene, the groups of an OBJ file. */
#include <stdlib.h>
#include <string.h>

#include "sinew/geom.h"
#include "sinew/io.h"

/* Triangles of no group are a part of their own, behind the groups. */
static sn_index part_of(const sn_mesh *mesh, sn_index triangle) {
    sn_index group = mesh->group_count > 0 ? mesh->triangle_group[triangle] : SN_NONE;
    return group != SN_NONE ? group : mesh->group_count;
}

/* Count triangles, and vertices by the last part that each was seen in: parts that are apart in the file are counted apart. */
static sn_status count_elements(const sn_mesh *mesh, sn_mesh_part *parts, sn_index count, sn_error *error) {
    size_t *start = SN_NEW(size_t, count + 1);
    sn_index *order = SN_NEW(sn_index, mesh->triangle_count), *seen = SN_NEW(sn_index, mesh->vertex_count);
    sn_status status = start && order && seen ? SN_OK : sn_fail_memory(error, "the meshes of a file");
    if (status == SN_OK) {
        for (sn_index t = 0; t < mesh->triangle_count; t++) parts[part_of(mesh, t)].triangles++;
        for (sn_index p = 0; p < count; p++) start[p + 1] = start[p] + (size_t)parts[p].triangles;
        for (sn_index t = 0; t < mesh->triangle_count; t++) order[start[part_of(mesh, t)]++] = t;
        for (size_t i = 0; i < (size_t)mesh->triangle_count; i++) {
            sn_index part = part_of(mesh, order[i]);
            for (int k = 0; k < 3; k++) {
                sn_index v = mesh->triangles[order[i]].v[k];
                if (seen[v] != part + 1) parts[part].vertices++;
                seen[v] = part + 1;
            }
        }
    }
    free(seen);
    free(order);
    free(start);
    return status;
}

sn_status sn_mesh_parts(const sn_mesh *mesh, sn_mesh_part **out, sn_index *count, sn_error *error) {
    *count = mesh->group_count + 1;
    *out = SN_NEW(sn_mesh_part, *count);
    if (*out == NULL) return sn_fail_memory(error, "the meshes of a file");
    for (sn_index i = 0; i < *count; i++) (*out)[i].name = i < mesh->group_count && mesh->group_names[i] ? mesh->group_names[i] : "";
    sn_status status = count_elements(mesh, *out, *count, error);
    if (status == SN_OK && mesh->group_count > 0 && (*out)[mesh->group_count].triangles == 0) (*count)--;
    if (status != SN_OK) {
        free(*out);
        *out = NULL;
    }
    return status;
}

/* The part of that name, else of that number; SN_NONE, with an error, where there is none or more than one. */
static sn_index find_part(const sn_mesh_part *parts, sn_index count, const char *which, sn_error *error) {
    sn_index found = SN_NONE, second = SN_NONE;
    for (sn_index i = 0; i < count; i++) {
        if (*which == '\0' || strcmp(parts[i].name, which) != 0) continue;
        if (found == SN_NONE)
            found = i;
        else if (second == SN_NONE)
            second = i;
    }
    if (second != SN_NONE) {
        sn_fail(error, SN_ERROR_INPUT, "more than one mesh is called '%s': give its number, such as %d or %d", which, (int)found + 1,
                (int)second + 1);
        return SN_NONE;
    }
    if (found != SN_NONE) return found;
    int64_t number;
    if (sn_parse_integer(which, 1, count, &number, NULL) == SN_OK) return (sn_index)number - 1;
    sn_fail(error, SN_ERROR_INPUT, "has %d mesh%s, numbered from 1, and none is '%s'; --list shows them", (int)count,
            count == 1 ? "" : "es", which);
    return SN_NONE;
}

/* Make part the only group. */
static sn_status keep_part(sn_mesh *mesh, sn_index part, sn_error *error) {
    bool *keep = SN_NEW(bool, mesh->triangle_count);
    sn_index dropped;
    if (keep == NULL) return sn_fail_memory(error, "a selection of triangles");
    for (sn_index t = 0; t < mesh->triangle_count; t++) keep[t] = part_of(mesh, t) == part;
    sn_mesh_keep_triangles(mesh, keep);
    free(keep);
    for (sn_index g = 0; g < mesh->group_count; g++)
        if (g != part) free(mesh->group_names[g]);
    if (part < mesh->group_count) {
        mesh->group_names[0] = mesh->group_names[part];
        mesh->group_count = 1;
        memset(mesh->triangle_group, 0, (size_t)mesh->triangle_count * sizeof *mesh->triangle_group);
    } else {
        free(mesh->group_names);
        free(mesh->triangle_group);
        mesh->group_names = NULL;
        mesh->triangle_group = NULL;
        mesh->group_count = 0;
    }
    return sn_drop_unused_vertices(mesh, &dropped, error);
}

sn_status sn_mesh_select(sn_mesh *mesh, const char *which, sn_error *error) {
    sn_mesh_part *parts;
    sn_index count;
    sn_status status = sn_mesh_parts(mesh, &parts, &count, error);
    if (status != SN_OK) return status;
    sn_index part = find_part(parts, count, which, error);
    if (part == SN_NONE) {
        status = SN_ERROR_INPUT;
    } else if (parts[part].triangles == 0) {
        status = sn_fail(error, SN_ERROR_INPUT, "mesh '%s' has no faces; --list shows the others", which);
    }
    free(parts);
    return status == SN_OK ? keep_part(mesh, part, error) : status;
}
