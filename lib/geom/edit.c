/*
 * edit.c -- taking elements out of a mesh with all that hangs on them.
 */
#include "edit.h"

#include <stdlib.h>
#include <string.h>

#include "order.h"

bool sn_triangle_repeats_index(sn_triangle t) { return t.v[0] == t.v[1] || t.v[1] == t.v[2] || t.v[2] == t.v[0]; }

bool sn_triangle_is_degenerate(const sn_mesh *mesh, sn_triangle t) {
    if (sn_triangle_repeats_index(t)) return true;
    sn_vec3 a = mesh->positions[t.v[0]], b = mesh->positions[t.v[1]], c = mesh->positions[t.v[2]];
    double longest = fmax(sn_norm2(sn_sub(b, a)), fmax(sn_norm2(sn_sub(c, b)), sn_norm2(sn_sub(a, c))));
    return !(sn_norm(sn_area_vector(a, b, c)) > SN_DEGENERATE_HEIGHT * longest);
}

double sn_triangle_quality(sn_vec3 a, sn_vec3 b, sn_vec3 c) {
    double squares = sn_norm2(sn_sub(b, a)) + sn_norm2(sn_sub(c, b)) + sn_norm2(sn_sub(a, c));
    return squares > 0.0 ? 2.0 * sqrt(3.0) * sn_norm(sn_area_vector(a, b, c)) / squares : 0.0;
}

int sn_triangle_longest_edge(const sn_mesh *mesh, sn_triangle t) {
    int longest = 0;
    double best = -1.0;
    for (int k = 0; k < 3; k++) {
        double length = sn_norm2(sn_sub(mesh->positions[t.v[(k + 1) % 3]], mesh->positions[t.v[(k + 2) % 3]]));
        if (length > best) {
            best = length;
            longest = k;
        }
    }
    return longest;
}

void sn_mesh_keep_triangles(sn_mesh *mesh, const bool *keep) {
    sn_index count = 0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!keep[t]) continue;
        mesh->triangles[count] = mesh->triangles[t];
        if (mesh->triangle_group != NULL) mesh->triangle_group[count] = mesh->triangle_group[t];
        count++;
    }
    mesh->triangle_count = count;
}

static void move_attributes(sn_mesh *mesh, sn_index from, sn_index to) {
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        size_t components = (size_t)mesh->attributes[i].components;
        double *values = mesh->attributes[i].values;
        memmove(values + (size_t)to * components, values + (size_t)from * components, components * sizeof *values);
    }
}

void sn_mesh_renumber(sn_mesh *mesh, const sn_index *new_index, sn_index count) {
    sn_index next = 0;
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        if (new_index[i] != next) continue; /* dropped, or not the first of its place */
        mesh->positions[next] = mesh->positions[i];
        move_attributes(mesh, i, next);
        next++;
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) mesh->triangles[t].v[k] = new_index[mesh->triangles[t].v[k]];
    }
    mesh->vertex_count = count;
}

bool sn_mesh_make_room(sn_mesh *mesh, sn_index vertices, sn_index triangles) {
    size_t v = (size_t)mesh->vertex_count + (size_t)vertices, t = (size_t)mesh->triangle_count + (size_t)triangles;
    sn_vec3 *positions = sn_realloc(mesh->positions, v, sizeof *positions);
    if (positions != NULL) mesh->positions = positions;
    sn_triangle *grown = sn_realloc(mesh->triangles, t, sizeof *grown);
    if (grown != NULL) mesh->triangles = grown;
    bool enough = positions != NULL && grown != NULL;
    for (sn_index a = 0; a < mesh->attribute_count; a++) {
        double *values = sn_realloc(mesh->attributes[a].values, v * (size_t)mesh->attributes[a].components, sizeof *values);
        if (values != NULL) mesh->attributes[a].values = values;
        enough = enough && values != NULL;
    }
    if (mesh->triangle_group == NULL) return enough;
    sn_index *group = sn_realloc(mesh->triangle_group, t, sizeof *group);
    if (group != NULL) mesh->triangle_group = group;
    return enough && group != NULL;
}

static void swap_if_greater(sn_index *a, sn_index *b) {
    if (*a <= *b) return;
    sn_index kept = *a;
    *a = *b;
    *b = kept;
}

static sn_triangle ascending(sn_triangle t) {
    swap_if_greater(&t.v[0], &t.v[1]);
    swap_if_greater(&t.v[1], &t.v[2]);
    swap_if_greater(&t.v[0], &t.v[1]);
    return t;
}

bool sn_same_triple(sn_triangle a, sn_triangle b) { return a.v[0] == b.v[0] && a.v[1] == b.v[1] && a.v[2] == b.v[2]; }

/* By the highest corner first, by the lowest last: the sorts are stable. */
sn_status sn_sort_triples(const sn_mesh *mesh, sn_index *order, sn_triangle *triples, sn_error *error) {
    sn_index count = mesh->triangle_count;
    sn_index *key = SN_NEW(sn_index, count), *from = SN_NEW(sn_index, count), *start = SN_NEW(sn_index, (size_t)mesh->vertex_count + 1);
    bool enough = key != NULL && from != NULL && start != NULL;
    for (sn_index t = 0; enough && t < count; t++) {
        triples[t] = ascending(mesh->triangles[t]);
        from[t] = t;
    }
    for (int corner = 2; enough && corner >= 0; corner--) {
        for (sn_index t = 0; t < count; t++) key[t] = triples[t].v[corner];
        sn_counting_sort(count, from, key, mesh->vertex_count, start, order);
        memcpy(from, order, (size_t)count * sizeof *from);
    }
    free(key);
    free(from);
    free(start);
    return enough ? SN_OK : sn_fail_memory(error, "sorting triangles");
}
