/*
 * solid.c -- any surface as the boundary of a solid: closed, turned outwards, overlaps made one.
 *
 * The edges that more triangles run along in one direction than in the other make up closed loops, whatever the surface: each triangle's
 * own boundary is one. With every loop closed the winding number is an integer everywhere off the surface.
 */
#include "sinew/distance_field.h"
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "solid.h"

/* Vertices this close, in diagonals, are one: what rounding to single precision leaves of layers on each other. */
static const double weld_share = 1e-7;
/* A longer loop is closed by a cone: the triangulation of least area takes the third power of its length. */
enum { CONE_FROM = 201 };

/* ---- loops of unmatched edges ------------------------------------------------------------------------------------------------ */

typedef struct borders {
    sn_index count;
    sn_index (*edges)[2]; /* (count) directed as the cap needs them, by their first vertex */
    sn_index *start;      /* (vertex_count + 1) into edges; start[v] moves on as edges are used */
    sn_index *end;        /* (vertex_count) */
} borders;

static void borders_free(borders *b) {
    free(b->edges);
    free(b->start);
    free(b->end);
}

/* How many more triangles run along each edge from v[0] to v[1] than back. */
static void net_directions(const sn_mesh *mesh, const sn_topology *topology, sn_index *net) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e != SN_NONE) net[e] += v[(k + 1) % 3] == topology->edges[e].v[0] ? 1 : -1;
        }
    }
}

/* The first vertex of what the cap needs along edge e. */
static int needed_from(sn_index net) { return net > 0 ? 1 : 0; }

static void sort_borders(const sn_topology *topology, const sn_index *net, borders *b) {
    for (sn_index e = 0; e < topology->edge_count; e++)
        if (net[e] != 0) b->start[topology->edges[e].v[needed_from(net[e])] + 1] += abs(net[e]);
    for (sn_index v = 0; v < topology->vertex_count; v++) b->start[v + 1] += b->start[v];
    memcpy(b->end, b->start, (size_t)topology->vertex_count * sizeof *b->end);
    for (sn_index e = 0; e < topology->edge_count; e++) {
        for (sn_index i = 0; i < abs(net[e]); i++) {
            const sn_index *v = topology->edges[e].v;
            int from = needed_from(net[e]);
            sn_index *place = b->edges[b->end[v[from]]++];
            place[0] = v[from];
            place[1] = v[1 - from];
        }
    }
}

static sn_status find_borders(const sn_mesh *mesh, borders *b, sn_error *error) {
    sn_topology topology;
    *b = (borders){0};
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index *net = SN_NEW(sn_index, topology.edge_count);
    if (net != NULL) net_directions(mesh, &topology, net);
    for (sn_index e = 0; net != NULL && e < topology.edge_count; e++) b->count += abs(net[e]);
    b->edges = sn_alloc((size_t)b->count, sizeof *b->edges);
    b->start = SN_NEW(sn_index, (size_t)mesh->vertex_count + 1);
    b->end = SN_NEW(sn_index, mesh->vertex_count);
    if (net != NULL && b->edges != NULL && b->start != NULL && b->end != NULL)
        sort_borders(&topology, net, b);
    else
        status = sn_fail_memory(error, "the border of a surface");
    free(net);
    sn_topology_free(&topology);
    return status;
}

/* ---- caps ---------------------------------------------------------------------------------------------------------------------- */

typedef struct capping {
    sn_mesh *mesh;
    size_t vertices, triangles; /* room for */
    sn_index caps;
    double *area;    /* (n x n) least area of what closes vertices i .. j of the loop */
    sn_index *split; /* (n x n) the third vertex of the triangle on i, j */
    size_t room;     /* of both */
} capping;

static bool add_cap_triangle(capping *c, sn_index i, sn_index j, sn_index k) {
    sn_mesh *m = c->mesh;
    void *triangles = m->triangles;
    if (m->triangle_count == SN_INDEX_MAX) return false;
    if (!sn_grow(&triangles, &c->triangles, (size_t)m->triangle_count + 1, sizeof *m->triangles)) return false;
    m->triangles = triangles;
    m->triangles[m->triangle_count++] = (sn_triangle){{i, j, k}};
    return true;
}

static bool add_cone(capping *c, const sn_index *loop, sn_index count) {
    sn_mesh *m = c->mesh;
    void *positions = m->positions;
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = 0; i < count; i++) sum = sn_add(sum, m->positions[loop[i]]);
    if (m->vertex_count == SN_INDEX_MAX) return false;
    if (!sn_grow(&positions, &c->vertices, (size_t)m->vertex_count + 1, sizeof *m->positions)) return false;
    m->positions = positions;
    sn_index apex = m->vertex_count++;
    m->positions[apex] = sn_scale(sum, 1.0 / count);
    for (sn_index i = 0; i < count; i++)
        if (!add_cap_triangle(c, loop[i], loop[(i + 1) % count], apex)) return false;
    return true;
}

static double triangle_area(const sn_mesh *mesh, sn_index a, sn_index b, sn_index c) {
    return 0.5 * sn_norm(sn_area_vector(mesh->positions[a], mesh->positions[b], mesh->positions[c]));
}

/* Least areas of all runs of the loop, short ones first. */
static void find_least_areas(capping *c, const sn_index *loop, sn_index n) {
    for (sn_index i = 0; i + 1 < n; i++) c->area[(size_t)i * (size_t)n + (size_t)i + 1] = 0.0;
    for (sn_index length = 2; length < n; length++) {
        for (sn_index i = 0; i + length < n; i++) {
            sn_index j = i + length;
            double *best = &c->area[(size_t)i * (size_t)n + (size_t)j];
            *best = INFINITY;
            for (sn_index k = i + 1; k < j; k++) {
                double area = c->area[(size_t)i * (size_t)n + (size_t)k] + c->area[(size_t)k * (size_t)n + (size_t)j] +
                              triangle_area(c->mesh, loop[i], loop[k], loop[j]);
                if (!(area < *best)) continue;
                *best = area;
                c->split[(size_t)i * (size_t)n + (size_t)j] = k;
            }
        }
    }
}

static bool add_run(capping *c, const sn_index *loop, sn_index n, sn_index i, sn_index j) {
    if (j - i < 2) return true;
    sn_index k = c->split[(size_t)i * (size_t)n + (size_t)j];
    return add_cap_triangle(c, loop[i], loop[k], loop[j]) && add_run(c, loop, n, i, k) && add_run(c, loop, n, k, j);
}

static bool add_cap(capping *c, const sn_index *loop, sn_index n) {
    c->caps++;
    if (n >= CONE_FROM) return add_cone(c, loop, n);
    size_t needed = (size_t)n * (size_t)n, room = c->room;
    void *area = c->area, *split = c->split;
    if (!sn_grow(&area, &room, needed, sizeof *c->area)) return false;
    c->area = area;
    if (!sn_grow(&split, &c->room, needed, sizeof *c->split)) return false;
    c->split = split;
    find_least_areas(c, loop, n);
    return add_run(c, loop, n, 0, n - 1);
}

/* Walk unused edges from vertex `first` until it has none, and cap every loop as soon as it closes. Every vertex has as many edges in as
 * out, so the walk ends nowhere else. path (border edges + 1); place (vertex_count) is SN_NONE of what is not on the path. */
static bool cap_from(capping *c, borders *b, sn_index first, sn_index *path, sn_index *place) {
    sn_index length = 0;
    path[length] = first;
    place[first] = length++;
    while (length > 1 || b->start[first] < b->end[first]) {
        sn_index next = b->edges[b->start[path[length - 1]]++][1];
        if (place[next] == SN_NONE) {
            path[length] = next;
            place[next] = length++;
            continue;
        }
        sn_index base = place[next];
        if (!add_cap(c, path + base, length - base)) return false;
        while (length > base + 1) place[path[--length]] = SN_NONE;
    }
    place[first] = SN_NONE;
    return true;
}

static sn_status close_loops(sn_mesh *mesh, sn_solid_report *report, sn_error *error) {
    borders b;
    sn_index before = mesh->triangle_count, vertices = mesh->vertex_count;
    capping c = {.mesh = mesh, .vertices = (size_t)mesh->vertex_count, .triangles = (size_t)mesh->triangle_count};
    sn_status status = find_borders(mesh, &b, error);
    sn_index *path = SN_NEW(sn_index, (size_t)b.count + 1), *place = SN_NEW(sn_index, vertices);
    bool enough = path != NULL && place != NULL;
    for (sn_index v = 0; enough && v < vertices; v++) place[v] = SN_NONE;
    for (sn_index v = 0; enough && status == SN_OK && v < vertices; v++) enough = cap_from(&c, &b, v, path, place);
    if (status == SN_OK && !enough) status = sn_fail_memory(error, "closing a surface");
    report->caps = c.caps;
    report->cap_triangles = mesh->triangle_count - before;
    free(c.area);
    free(c.split);
    free(path);
    free(place);
    borders_free(&b);
    return status;
}

/* ---- orientation ---------------------------------------------------------------------------------------------------------------- */

static void turn_all(sn_mesh *mesh) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_index kept = mesh->triangles[t].v[1];
        mesh->triangles[t].v[1] = mesh->triangles[t].v[2];
        mesh->triangles[t].v[2] = kept;
    }
}

static sn_status turn_outwards(sn_mesh *mesh, sn_solid_report *report, sn_error *error) {
    report->inside_out = sn_mesh_volume(mesh) < 0.0;
    if (report->inside_out) turn_all(mesh);
    sn_status status = sn_orient_outward(mesh, &report->turned, error);
    report->volume = sn_mesh_volume(mesh);
    return status;
}

/* ---- all of it ------------------------------------------------------------------------------------------------------------------- */

/* Positions and triangles alone: attributes have nothing to say here. */
static sn_status copy_bare(const sn_mesh *from, sn_mesh *to, sn_error *error) {
    sn_status status = sn_mesh_validate(from, error);
    if (status == SN_OK) status = sn_mesh_alloc(to, from->vertex_count, from->triangle_count, error);
    if (status != SN_OK) return status;
    memcpy(to->positions, from->positions, (size_t)from->vertex_count * sizeof *to->positions);
    memcpy(to->triangles, from->triangles, (size_t)from->triangle_count * sizeof *to->triangles);
    return SN_OK;
}

static sn_status join_layers(sn_mesh *mesh, sn_solid_report *report, sn_error *error) {
    sn_index degenerate = 0, duplicate = 0, count = mesh->triangle_count;
    sn_status status = sn_weld(mesh, weld_share * sn_box_diagonal(sn_mesh_box(mesh)), &report->joined_vertices, NULL, error);
    if (status == SN_OK) status = sn_drop_bad_triangles(mesh, &degenerate, &duplicate, error);
    report->dropped_triangles = count - mesh->triangle_count;
    if (status == SN_OK && mesh->triangle_count == 0)
        status =
            sn_fail(error, SN_ERROR_INPUT, "no triangle of the surface has an area, so nothing is near it or in it; give another mesh");
    return status;
}

sn_status sn_solid_surface(const sn_mesh *mesh, sn_pool *pool, sn_mesh *out, sn_solid_report *report, sn_error *error) {
    *out = (sn_mesh){0};
    *report = (sn_solid_report){0};
    sn_status status = copy_bare(mesh, out, error);
    if (status == SN_OK) status = join_layers(out, report, error);
    if (status == SN_OK) status = close_loops(out, report, error);
    if (status == SN_OK) status = turn_outwards(out, report, error);
    if (status == SN_OK) status = sn_sort_out_inner(out, pool, report, error);
    if (status != SN_OK) sn_mesh_free(out);
    return status;
}
