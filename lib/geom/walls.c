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

/* What a round of dropping looks at; arrays by patch have a place for every triangle, as a patch's name is one. */
typedef struct wall_round {
    const sn_mesh *mesh;
    const sn_topology *topology;
    sn_index *name;     /* (triangle_count) of a triangle's patch */
    sn_index *last;     /* (edge_count) the patch that touched an edge last: meeting it again means that the patch lies on both sides */
    sn_index *start;    /* (triangle_count + 1) by patch: into members */
    sn_index *members;  /* (triangle_count) patch by patch */
    patch *patches;     /* (triangle_count) */
    bool *taken, *goes; /* (edge_count) by a patch that goes; (triangle_count) by patch */
} wall_round;

static bool round_alloc(wall_round *r) {
    size_t triangles = (size_t)r->mesh->triangle_count, edges = (size_t)r->topology->edge_count;
    r->last = SN_NEW(sn_index, edges);
    r->start = SN_NEW(sn_index, triangles + 1);
    r->members = SN_NEW(sn_index, triangles);
    r->patches = SN_NEW(patch, triangles);
    r->taken = SN_NEW(bool, edges);
    r->goes = SN_NEW(bool, triangles);
    return r->last && r->start && r->members && r->patches && r->taken && r->goes;
}

static void round_free(wall_round *r) {
    free(r->name);
    free(r->last);
    free(r->start);
    free(r->members);
    free(r->patches);
    free(r->taken);
    free(r->goes);
}

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

static void measure_patches(wall_round *r) {
    const sn_topology *topology = r->topology;
    for (sn_index e = 0; e < topology->edge_count; e++) r->last[e] = SN_NONE;
    for (sn_index t = 0; t < r->mesh->triangle_count; t++) {
        patch *p = &r->patches[r->name[t]];
        p->name = r->name[t];
        p->triangles++;
        p->area += area_of(r->mesh, t);
    }
    for (sn_index t = 0; t < r->mesh->triangle_count; t++) {
        patch *p = &r->patches[r->name[t]];
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e == SN_NONE || topology->edges[e].triangle_count <= 2) continue;
            if (topology->edges[e].triangle_count % 2 == 0 || r->last[e] == p->name) p->holds = true;
            p->joints++;
            r->last[e] = p->name;
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

/* Does a patch have an edge that is taken? With `take`, its edges with three triangles or more are from then on. */
static bool patch_blocked(wall_round *r, sn_index name, bool take) {
    bool blocked = false;
    for (sn_index m = r->start[name]; m < r->start[name + 1]; m++)
        for (int k = 0; k < 3; k++) {
            sn_index e = r->topology->triangle_edges[r->members[m]][k];
            if (e == SN_NONE || r->topology->edges[e].triangle_count <= 2) continue;
            blocked = blocked || r->taken[e];
            if (take) r->taken[e] = true;
        }
    return blocked;
}

/* Two patches on one edge cannot both go in the same round: the first of `count` does. */
static void choose(wall_round *r, sn_index count) {
    for (sn_index i = 0; i < count; i++) {
        sn_index name = r->patches[i].name;
        r->goes[name] = !patch_blocked(r, name, false);
        if (r->goes[name]) patch_blocked(r, name, true);
    }
}

static sn_status drop_round(sn_mesh *mesh, const sn_topology *topology, sn_index *dropped, sn_error *error) {
    sn_index count = mesh->triangle_count;
    wall_round r = {.mesh = mesh, .topology = topology};
    sn_status status = name_patches(mesh, topology, &r.name, error);
    if (status != SN_OK) return status;
    bool *keep = SN_NEW(bool, count), enough = round_alloc(&r) && keep;
    if (enough) {
        measure_patches(&r);
        sn_counting_sort(count, NULL, r.name, count, r.start, r.members);
        choose(&r, gather(r.patches, count));
        for (sn_index t = 0; t < count; t++) keep[t] = !r.goes[r.name[t]];
        sn_mesh_keep_triangles(mesh, keep);
        *dropped += count - mesh->triangle_count;
    }
    round_free(&r);
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
