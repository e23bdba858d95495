/*
 * hausdorff.c -- greatest distance between two surfaces, sampled; what one has lost of the other.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "edit.h"

/* What of `from` lies in `to` as it is, vertex by vertex and triangle by triangle: it has no distance. */
typedef struct common {
    bool *vertices, *triangles;
} common;

static void common_free(common *c) {
    free(c->vertices);
    free(c->triangles);
}

/* Both meshes as one, vertices replaced by the first with the same coordinates. `to` comes first. */
static sn_status join_meshes(const sn_mesh *to, const sn_mesh *from, sn_mesh *both, sn_error *error) {
    if (to->vertex_count > SN_INDEX_MAX - from->vertex_count || to->triangle_count > SN_INDEX_MAX / 6 - from->triangle_count) {
        return sn_fail(error, SN_ERROR_INPUT, "the surfaces are too large to be compared");
    }
    sn_status status = sn_mesh_alloc(both, to->vertex_count + from->vertex_count, to->triangle_count + from->triangle_count, error);
    if (status != SN_OK) return status;
    memcpy(both->positions, to->positions, (size_t)to->vertex_count * sizeof *to->positions);
    memcpy(both->positions + to->vertex_count, from->positions, (size_t)from->vertex_count * sizeof *from->positions);
    sn_index *same = SN_NEW(sn_index, both->vertex_count);
    status = same != NULL ? sn_find_representatives(both, 0.0, same, error) : sn_fail_memory(error, "comparing surfaces");
    for (sn_index t = 0; status == SN_OK && t < both->triangle_count; t++) {
        bool first = t < to->triangle_count;
        const sn_index *v = first ? to->triangles[t].v : from->triangles[t - to->triangle_count].v;
        for (int k = 0; k < 3; k++) both->triangles[t].v[k] = same[first ? v[k] : v[k] + to->vertex_count];
    }
    free(same);
    if (status != SN_OK) sn_mesh_free(both);
    return status;
}

/* used (vertex_count of both): the vertex is a corner in `to`. */
static void mark_vertices(const sn_mesh *to, const sn_mesh *from, const sn_mesh *both, bool *used, common *c) {
    for (sn_index t = 0; t < to->triangle_count; t++) {
        for (int k = 0; k < 3; k++) used[both->triangles[t].v[k]] = true;
    }
    for (sn_index t = 0; t < from->triangle_count; t++) {
        for (int k = 0; k < 3; k++) { c->vertices[from->triangles[t].v[k]] = used[both->triangles[to->triangle_count + t].v[k]]; }
    }
}

/* Of triangles with the same corners the lowest comes first: in `to`, if any is. */
static void mark_triangles(const sn_mesh *to, sn_index count, const sn_index *order, const sn_triangle *triples, common *c) {
    bool in_both = false;
    for (sn_index i = 0; i < count; i++) {
        bool same = i > 0 && sn_same_triple(triples[order[i - 1]], triples[order[i]]);
        in_both = same ? in_both : order[i] < to->triangle_count;
        if (order[i] >= to->triangle_count) c->triangles[order[i] - to->triangle_count] = in_both;
    }
}

static sn_status find_common(const sn_mesh *to, const sn_mesh *from, common *c, sn_error *error) {
    sn_mesh both = {0};
    *c = (common){SN_NEW(bool, from->vertex_count), SN_NEW(bool, from->triangle_count)};
    sn_status status = join_meshes(to, from, &both, error);
    if (status != SN_OK) return status;
    bool *used = SN_NEW(bool, both.vertex_count);
    sn_index *order = SN_NEW(sn_index, both.triangle_count);
    sn_triangle *triples = SN_NEW(sn_triangle, both.triangle_count);
    bool enough = c->vertices && c->triangles && used && order && triples;
    status = enough ? sn_sort_triples(&both, order, triples, error) : sn_fail_memory(error, "comparing surfaces");
    if (status == SN_OK) {
        mark_vertices(to, from, &both, used, c);
        mark_triangles(to, both.triangle_count, order, triples, c);
    }
    free(used);
    free(order);
    free(triples);
    sn_mesh_free(&both);
    return status;
}

static double distance_to(const sn_surface *surface, sn_vec3 point) { return sn_surface_closest(surface, point, INFINITY).distance; }

/* Corners and centres of the triangles against the other surface; vertices that no triangle uses are no part of it. */
static double greatest_distance(const sn_mesh *mesh, common *c, const sn_surface *other) {
    double greatest = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (c->triangles[t]) continue;
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 sum = sn_v3(0, 0, 0);
        for (int k = 0; k < 3; k++) {
            sum = sn_add(sum, mesh->positions[v[k]]);
            if (c->vertices[v[k]]) continue;
            c->vertices[v[k]] = true; /* once is enough */
            greatest = fmax(greatest, distance_to(other, mesh->positions[v[k]]));
        }
        greatest = fmax(greatest, distance_to(other, sn_scale(sum, 1.0 / 3.0)));
    }
    return greatest;
}

static bool is_all_common(const sn_mesh *mesh, const common *c) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!c->triangles[t]) return false;
    }
    return true;
}

sn_status sn_one_sided_distance(const sn_mesh *from, const sn_mesh *to, double *out, sn_error *error) {
    *out = 0.0;
    common c;
    sn_surface *surface = NULL;
    sn_status status = find_common(to, from, &c, error);
    if (status == SN_OK && !is_all_common(from, &c)) {
        status = sn_surface_create_plain(to, &surface, error);
        if (status == SN_OK) *out = greatest_distance(from, &c, surface);
    }
    sn_surface_destroy(surface);
    common_free(&c);
    return status;
}

static bool is_lost(const sn_surface *surface, sn_vec3 point, double reach) {
    return sn_surface_closest(surface, point, reach).triangle == SN_NONE && sn_surface_signed_distance(surface, point, NULL) > 0.0;
}

sn_status sn_lost_area(const sn_mesh *from, const sn_mesh *to, double reach, double *out, sn_error *error) {
    *out = 0.0;
    common c;
    sn_surface *surface = NULL;
    sn_status status = find_common(to, from, &c, error);
    if (status == SN_OK && !is_all_common(from, &c)) status = sn_surface_create(to, &surface, error);
    for (sn_index t = 0; surface != NULL && t < from->triangle_count; t++) {
        const sn_index *v = from->triangles[t].v;
        sn_vec3 p = from->positions[v[0]], q = from->positions[v[1]], r = from->positions[v[2]];
        if (!c.triangles[t] && is_lost(surface, sn_scale(sn_add(p, sn_add(q, r)), 1.0 / 3.0), reach)) {
            *out += 0.5 * sn_norm(sn_area_vector(p, q, r));
        }
    }
    sn_surface_destroy(surface);
    common_free(&c);
    return status;
}
