/*
 * fill_refine.c -- a finer surface for the field: every triangle in four, the middles of the edges for new vertices. On few triangles the
 * field is known at too few places for its flux to be told.
 */
#include <stdlib.h>

#include "fill.h"

enum { ENOUGH = 6000, MOST_ROUNDS = 4 };

/* Vertices stay; the middle of edge e is vertex_count + e. */
static sn_status split_edges(const sn_mesh *mesh, const sn_topology *t, sn_mesh *out, sn_error *error) {
    sn_index vertices = mesh->vertex_count;
    sn_status status = sn_mesh_alloc(out, vertices + t->edge_count, 4 * mesh->triangle_count, error);
    if (status) return status;
    for (sn_index v = 0; v < vertices; v++) out->positions[v] = mesh->positions[v];
    for (sn_index e = 0; e < t->edge_count; e++)
        out->positions[vertices + e] = sn_lerp(mesh->positions[t->edges[e].v[0]], mesh->positions[t->edges[e].v[1]], 0.5);
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        const sn_index *v = mesh->triangles[i].v, *e = t->triangle_edges[i];
        const sn_index m[3] = {vertices + e[0], vertices + e[1], vertices + e[2]};
        sn_triangle *four = out->triangles + 4 * (size_t)i;
        four[0] = (sn_triangle){{v[0], m[2], m[1]}};
        four[1] = (sn_triangle){{m[2], v[1], m[0]}};
        four[2] = (sn_triangle){{m[1], m[0], v[2]}};
        four[3] = (sn_triangle){{m[0], m[1], m[2]}};
    }
    return SN_OK;
}

/* Between two ends of one value the middle is one, too. */
static sn_status add_middles(const sn_topology *t, sn_index vertices, fill_fixed *fixed, sn_error *error) {
    char *value = SN_NEW(char, vertices); /* 1, 2: an end of value 0, 1 */
    size_t most = (size_t)vertices + (size_t)t->edge_count;
    sn_index *numbers = sn_realloc(fixed->vertices, most, sizeof *numbers);
    if (numbers) fixed->vertices = numbers;
    double *values = sn_realloc(fixed->values, most, sizeof *values);
    if (values) fixed->values = values;
    if (value && numbers && values) {
        for (sn_index i = 0; i < fixed->count; i++) value[numbers[i]] = values[i] != 0.0 ? 2 : 1;
        for (sn_index e = 0; e < t->edge_count; e++) {
            const sn_index *v = t->edges[e].v;
            if (!value[v[0]] || value[v[0]] != value[v[1]]) continue;
            numbers[fixed->count] = vertices + e;
            values[fixed->count++] = value[v[0]] - 1;
        }
    }
    bool made = value && numbers && values;
    free(value);
    return made ? SN_OK : sn_fail_memory(error, "a finer surface");
}

static bool can_split(const sn_topology *t) {
    for (sn_index i = 0; i < t->triangle_count; i++)
        if (t->triangle_edges[i][0] == SN_NONE) return false;
    return true;
}

sn_status fill_refine(const sn_mesh *mesh, const sn_topology *topology, fill_fixed *fixed, sn_mesh *out, sn_topology *out_topology,
                      sn_error *error) {
    const sn_mesh *from = mesh;
    const sn_topology *t = topology;
    sn_status status = SN_OK;
    *out = (sn_mesh){0};
    *out_topology = (sn_topology){0};
    for (int round = 0; round < MOST_ROUNDS && from->triangle_count < ENOUGH && can_split(t) && !status; round++) {
        sn_mesh finer = {0};
        sn_topology around = {0};
        status = split_edges(from, t, &finer, error);
        if (!status) status = add_middles(t, from->vertex_count, fixed, error);
        if (!status) status = sn_topology_build(&finer, &around, error);
        sn_mesh_free(out);
        sn_topology_free(out_topology);
        *out = finer;
        *out_topology = around;
        from = out;
        t = out_topology;
    }
    return status;
}
