/*
 * inspect.c -- every defect and measure of a mesh in one report.
 */
#include "sinew/mesh.h"

#include <stdlib.h>

#include "edit.h"
#include "order.h"

/* ---- counts over triangles and vertices ----------------------------------------------------------------------------- */

static void count_unused(const sn_mesh *mesh, const sn_topology *topology, sn_mesh_report *out) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        if (topology->corner_start[v] == topology->corner_start[v + 1]) out->unused_vertices++;
    }
}

static sn_status count_duplicate_vertices(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error) {
    sn_index *representative = SN_NEW(sn_index, mesh->vertex_count);
    if (representative == NULL) return sn_fail_memory(error, "inspecting a mesh");
    sn_status status = sn_find_representatives(mesh, 0.0, representative, error);
    for (sn_index i = 0; status == SN_OK && i < mesh->vertex_count; i++) out->duplicate_vertices += representative[i] != i;
    free(representative);
    return status;
}

static sn_status count_duplicate_triangles(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error) {
    sn_index *order = SN_NEW(sn_index, mesh->triangle_count);
    sn_triangle *triples = SN_NEW(sn_triangle, mesh->triangle_count);
    sn_status status =
        order != NULL && triples != NULL ? sn_sort_triples(mesh, order, triples, error) : sn_fail_memory(error, "inspecting a mesh");
    for (sn_index i = 1; status == SN_OK && i < mesh->triangle_count; i++) {
        out->duplicate_triangles += sn_same_triple(triples[order[i - 1]], triples[order[i]]);
    }
    free(order);
    free(triples);
    return status;
}

static void measure_triangles(const sn_mesh *mesh, sn_mesh_report *out) {
    out->worst_quality = mesh->triangle_count > 0 ? 1.0 : 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double quality = sn_triangle_quality(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]);
        bool degenerate = sn_triangle_is_degenerate(mesh, mesh->triangles[t]);
        out->degenerate_triangles += degenerate;
        out->sliver_triangles += !degenerate && quality < SN_SLIVER_QUALITY;
        out->worst_quality = fmin(out->worst_quality, quality);
    }
}

/* ---- edges ---------------------------------------------------------------------------------------------------------- */

/* Does the triangle run from edge->v[0] to edge->v[1]? */
static bool runs_forward(const sn_mesh *mesh, const sn_edge *edge, sn_index triangle) {
    const sn_index *v = mesh->triangles[triangle].v;
    for (int k = 0; k < 3; k++) {
        if (v[k] == edge->v[0]) return v[(k + 1) % 3] == edge->v[1];
    }
    return false;
}

static void count_edges(const sn_mesh *mesh, const sn_topology *topology, sn_mesh_report *out) {
    out->edges = topology->edge_count;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        double length = sn_distance(mesh->positions[edge->v[0]], mesh->positions[edge->v[1]]);
        out->edge_min = e == 0 ? length : fmin(out->edge_min, length);
        out->edge_max = fmax(out->edge_max, length);
        out->boundary_edges += edge->triangle_count == 1;
        out->nonmanifold_edges += edge->triangle_count > 2;
        if (edge->triangle_count == 2) {
            out->inconsistent_edges += runs_forward(mesh, edge, edge->triangle[0]) == runs_forward(mesh, edge, edge->triangle[1]);
        }
    }
    out->edge_mean = sn_mesh_mean_edge(mesh, topology);
}

/* Connected parts of the boundary; parent (vertex_count) is scratch. */
static sn_index count_boundary_loops(const sn_topology *topology, sn_index *parent) {
    sn_index vertices = 0, joined = 0;
    for (sn_index v = 0; v < topology->vertex_count; v++) parent[v] = SN_NONE;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        if (edge->triangle_count != 1) continue;
        for (int k = 0; k < 2; k++) {
            if (parent[edge->v[k]] != SN_NONE) continue;
            parent[edge->v[k]] = edge->v[k];
            vertices++;
        }
        if (sn_set_find(parent, edge->v[0]) == sn_set_find(parent, edge->v[1])) continue;
        sn_set_join(parent, edge->v[0], edge->v[1]);
        joined++;
    }
    return vertices - joined;
}

/* ---- fans ----------------------------------------------------------------------------------------------------------- */

static int corner_of(const sn_mesh *mesh, sn_index triangle, sn_index vertex) {
    const sn_index *v = mesh->triangles[triangle].v;
    return v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
}

/* Corners at a vertex that are joined by edges form a fan: a manifold vertex has one. parent (3 triangle_count) and fans (vertex_count) are
 * scratch. */
static sn_index count_pinched_vertices(const sn_mesh *mesh, const sn_topology *topology, sn_index *parent, sn_index *fans) {
    for (sn_index c = 0; c < 3 * mesh->triangle_count; c++) parent[c] = c;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            if (topology->triangle_edges[t][k] == SN_NONE) continue;
            const sn_edge *edge = &topology->edges[topology->triangle_edges[t][k]];
            sn_index first = edge->triangle[0];
            if (first == t) continue;
            for (int end = 0; end < 2; end++) {
                sn_set_join(parent, 3 * t + corner_of(mesh, t, edge->v[end]), 3 * first + corner_of(mesh, first, edge->v[end]));
            }
        }
    }
    sn_index pinched = 0;
    for (sn_index c = 0; c < 3 * mesh->triangle_count; c++) {
        bool is_fan = parent[c] == c && topology->triangle_edges[c / 3][0] != SN_NONE;
        if (is_fan && ++fans[mesh->triangles[c / 3].v[c % 3]] == 2) pinched++;
    }
    return pinched;
}

static sn_status count_loops_and_fans(const sn_mesh *mesh, const sn_topology *topology, sn_mesh_report *out, sn_error *error) {
    size_t corners = 3 * (size_t)mesh->triangle_count, vertices = (size_t)mesh->vertex_count;
    sn_index *parent = SN_NEW(sn_index, corners > vertices ? corners : vertices), *fans = SN_NEW(sn_index, vertices);
    bool enough = parent != NULL && fans != NULL;
    if (enough) {
        out->boundary_loops = count_boundary_loops(topology, parent);
        out->nonmanifold_vertices = count_pinched_vertices(mesh, topology, parent, fans);
    }
    free(parent);
    free(fans);
    return enough ? SN_OK : sn_fail_memory(error, "inspecting a mesh");
}

sn_status sn_mesh_look_at_edges(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error) {
    *out = (sn_mesh_report){.vertices = mesh->vertex_count, .triangles = mesh->triangle_count};
    sn_topology topology;
    sn_status status = mesh->triangle_count > 0 ? sn_mesh_validate(mesh, error) : SN_OK;
    if (status == SN_OK) status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    count_edges(mesh, &topology, out);
    status = count_loops_and_fans(mesh, &topology, out, error);
    sn_topology_free(&topology);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------------------------------ */

static sn_status count_components(const sn_mesh *mesh, const sn_topology *topology, sn_mesh_report *out, sn_error *error) {
    sn_index *component = SN_NEW(sn_index, mesh->triangle_count);
    if (component == NULL) return sn_fail_memory(error, "inspecting a mesh");
    out->components = sn_mesh_components(mesh, topology, component);
    bool *inverted = SN_NEW(bool, out->components);
    sn_status status =
        inverted != NULL ? sn_find_inverted(mesh, out->components, component, inverted, error) : sn_fail_memory(error, "inspecting a mesh");
    out->outward = status == SN_OK && out->components > 0;
    for (sn_index c = 0; status == SN_OK && c < out->components; c++) {
        if (inverted[c]) out->outward = false;
    }
    free(inverted);
    free(component);
    return status;
}

static void conclude(const sn_mesh *mesh, sn_mesh_report *out) {
    bool whole = mesh->triangle_count > 0 && out->degenerate_triangles == 0;
    out->closed = mesh->triangle_count > 0 && out->boundary_edges == 0;
    out->manifold = whole && out->nonmanifold_edges == 0 && out->nonmanifold_vertices == 0;
    out->oriented = mesh->triangle_count > 0 && out->inconsistent_edges == 0;
    out->outward = out->outward && out->oriented;
    /* Euler: V - E + F = 2 components - 2 genus */
    double euler = (double)out->vertices - out->unused_vertices - out->edges + out->triangles;
    out->genus = out->closed && out->manifold && out->oriented ? out->components - 0.5 * euler : NAN;
}

sn_status sn_mesh_inspect(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error) {
    *out = (sn_mesh_report){.vertices = mesh->vertex_count, .triangles = mesh->triangle_count, .self_intersections = -1, .genus = NAN};
    sn_status status = mesh->triangle_count > 0 ? sn_mesh_validate(mesh, error) : SN_OK;
    if (status != SN_OK) return status;
    sn_topology topology;
    status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    count_unused(mesh, &topology, out);
    measure_triangles(mesh, out);
    count_edges(mesh, &topology, out);
    status = count_duplicate_vertices(mesh, out, error);
    if (status == SN_OK) status = count_duplicate_triangles(mesh, out, error);
    if (status == SN_OK) status = count_loops_and_fans(mesh, &topology, out, error);
    if (status == SN_OK) status = count_components(mesh, &topology, out, error);
    sn_topology_free(&topology);
    out->area = sn_mesh_area(mesh);
    out->volume = sn_mesh_volume(mesh);
    out->box = sn_mesh_box(mesh);
    out->diagonal = sn_box_diagonal(out->box);
    conclude(mesh, out);
    return status;
}

/* Of a surface's edges or triangles. */
static const double AMBIGUOUS_SHARE = 0.01;

sn_status sn_mesh_warn_of_sides(const sn_mesh *mesh, const char *name, sn_error *error) {
    sn_mesh_report r;
    sn_status status = sn_mesh_inspect(mesh, &r, error);
    if (status != SN_OK) return status;
    double edges = AMBIGUOUS_SHARE * r.edges, triangles = AMBIGUOUS_SHARE * r.triangles;
    if (r.duplicate_triangles > triangles || r.inconsistent_edges > edges || r.nonmanifold_edges > edges)
        sn_log(
            SN_LOG_WARNING,
            "bone \"%s\": %ld of %ld triangles stand twice, %ld edges lie between triangles of opposite winding, and %ld are in more than "
            "two: what is inside cannot be told, and contact with it is wrong; mesh-clean mends it",
            name, (long)r.duplicate_triangles, (long)r.triangles, (long)r.inconsistent_edges, (long)r.nonmanifold_edges);
    return SN_OK;
}
