/*
 * walls.c -- fins and walls inside: patches of a surface that leave it a manifold by going.
 */
#include "sinew/geom.h"

#include <stdlib.h>

#include "edit.h"
#include "order.h"

/* A patch: triangles joined by edges that carry exactly two. */
typedef struct patch {
    sn_index name; /* its lowest triangle */
    sn_index triangles;
    double area;
    sn_index joints; /* its edges that carry an odd number of triangles, three or more */
    bool holds;      /* it must stay: an edge carries an even number above two, or the patch twice */
} patch;

static sn_status name_patches(const sn_mesh *mesh, const sn_topology *topology, sn_index **out, sn_error *error) {
    sn_index *name = SN_NEW(sn_index, mesh->triangle_count);
    *out = name;
    if (name == NULL) return sn_fail_memory(error, "finding walls");
    for (sn_index t = 0; t < mesh->triangle_count; t++) name[t] = t;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        if (edge->triangle_count == 2) sn_set_join(name, edge->triangle[0], edge->triangle[1]);
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) name[t] = name[name[t]]; /* parents come first */
    return SN_OK;
}

static double area_of(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return 0.5 * sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* last (edge_count) holds the patch that touched an edge last: meeting it again means the patch lies on both sides. */
static void measure_patches(const sn_mesh *mesh, const sn_topology *topology, const sn_index *name, sn_index *last, patch *patches) {
    for (sn_index e = 0; e < topology->edge_count; e++) last[e] = SN_NONE;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        patch *p = &patches[name[t]];
        p->name = name[t];
        p->triangles++;
        p->area += area_of(mesh, t);
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        patch *p = &patches[name[t]];
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e == SN_NONE || topology->edges[e].triangle_count <= 2) continue;
            if (topology->edges[e].triangle_count % 2 == 0 || last[e] == name[t]) p->holds = true;
            p->joints++;
            last[e] = name[t];
        }
    }
}

static int smaller_first(const void *left, const void *right) {
    const patch *a = left, *b = right;
    if (a->area != b->area) return a->area < b->area ? -1 : 1;
    return (a->name > b->name) - (a->name < b->name);
}

/* Gather what may go, smallest first; returns how many. */
static sn_index gather(patch *patches, sn_index count) {
    sn_index gathered = 0;
    for (sn_index i = 0; i < count; i++) {
        if (patches[i].triangles > 0 && patches[i].joints > 0 && !patches[i].holds) patches[gathered++] = patches[i];
    }
    qsort(patches, (size_t)gathered, sizeof *patches, smaller_first);
    return gathered;
}

/* Two patches on one edge cannot both go in the same round. taken (edge_count), goes (triangle_count by patch name). */
static void choose(const sn_topology *topology, const patch *patches, sn_index count, const sn_index *start, const sn_index *members,
                   bool *taken, bool *goes) {
    for (sn_index i = 0; i < count; i++) {
        bool blocked = false;
        sn_index first = start[patches[i].name], end = start[patches[i].name + 1];
        for (int mark = 0; mark < 2 && !blocked; mark++) {
            for (sn_index m = first; m < end; m++) {
                for (int k = 0; k < 3; k++) {
                    sn_index e = topology->triangle_edges[members[m]][k];
                    if (e == SN_NONE || topology->edges[e].triangle_count <= 2) continue;
                    if (mark == 0)
                        blocked = blocked || taken[e];
                    else
                        taken[e] = true;
                }
            }
        }
        goes[patches[i].name] = !blocked;
    }
}

static sn_status drop_round(sn_mesh *mesh, const sn_topology *topology, sn_index *dropped, sn_error *error) {
    sn_index count = mesh->triangle_count, *name = NULL;
    sn_status status = name_patches(mesh, topology, &name, error);
    if (status != SN_OK) return status;
    sn_index *last = SN_NEW(sn_index, topology->edge_count), *start = SN_NEW(sn_index, (size_t)count + 1),
             *members = SN_NEW(sn_index, count);
    patch *patches = SN_NEW(patch, count);
    bool *taken = SN_NEW(bool, topology->edge_count), *goes = SN_NEW(bool, count), *keep = SN_NEW(bool, count);
    bool enough = last && start && members && patches && taken && goes && keep;
    if (enough) {
        measure_patches(mesh, topology, name, last, patches);
        sn_counting_sort(count, NULL, name, count, start, members);
        choose(topology, patches, gather(patches, count), start, members, taken, goes);
        for (sn_index t = 0; t < count; t++) keep[t] = !goes[name[t]];
        sn_mesh_keep_triangles(mesh, keep);
        *dropped += count - mesh->triangle_count;
    }
    free(name);
    free(last);
    free(start);
    free(members);
    free(patches);
    free(taken);
    free(goes);
    free(keep);
    return enough ? SN_OK : sn_fail_memory(error, "finding walls");
}

/* Every round that drops something drops a triangle at least; the bound is for surfaces made of nothing but walls. */
#define MOST_WALL_ROUNDS 100

sn_status sn_drop_walls(sn_mesh *mesh, sn_index *dropped, sn_error *error) {
    *dropped = 0;
    sn_status status = SN_OK;
    sn_index before = SN_NONE;
    for (int round = 0; status == SN_OK && *dropped != before && mesh->triangle_count > 0 && round < MOST_WALL_ROUNDS; round++) {
        sn_topology topology;
        before = round == 0 ? 0 : *dropped;
        status = sn_topology_build(mesh, &topology, error);
        if (status == SN_OK) status = drop_round(mesh, &topology, dropped, error);
        sn_topology_free(&topology);
    }
    sn_index unused = 0;
    if (status == SN_OK && *dropped > 0) status = sn_drop_unused_vertices(mesh, &unused, error);
    return status;
}
