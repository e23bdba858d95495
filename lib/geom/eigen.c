/*
 * eigen.c -- the Fiedler eigenfunction of a surface: the slowest of its vibrations, whose two extremes are the far ends of the shape.
 *
 * K x = lambda M x with the cotangent Laplacian K and vertex areas M. Inverse iteration with K + shift M, which is positive definite; the
 * constant, the eigenfunction of lambda = 0, is taken out of every iterate.
 */
#include <stdlib.h>

#include "sinew/geom.h"
#include "sinew/sparse.h"

enum { MAX_ITERATIONS = 60 };
#define CONVERGED 1e-6 /* change of the Rayleigh quotient */
#define SHIFT 1e-3     /* times 1 / area: lambda area is of order 1 and above */

typedef struct iteration {
    const sn_mesh *mesh;
    const sn_topology *topology;
    double *area; /* (vertex_count) of a vertex: a third of its triangles */
    double total;
    sn_entry *entries; /* (vertices + edges) */
    sn_sparse *factor;
    double *right; /* (vertex_count) */
} iteration;

static void weigh_vertices(iteration *it) {
    const sn_vec3 *p = it->mesh->positions;
    for (sn_index t = 0; t < it->mesh->triangle_count; t++) {
        const sn_index *v = it->mesh->triangles[t].v;
        double area = 0.5 * sn_norm(sn_area_vector(p[v[0]], p[v[1]], p[v[2]]));
        for (int c = 0; c < 3; c++) it->area[v[c]] += area / 3.0;
        it->total += area;
    }
    double least = 1e-12 * it->total / (double)it->mesh->vertex_count; /* a vertex without area must not have an infinite frequency */
    for (sn_index v = 0; v < it->mesh->vertex_count; v++) it->area[v] = fmax(it->area[v], least);
}

static sn_status factor_shifted(iteration *it, sn_error *error) {
    sn_index n = it->mesh->vertex_count, count = n;
    for (sn_index v = 0; v < n; v++) it->entries[v] = (sn_entry){v, v, SHIFT * it->area[v] / it->total};
    for (sn_index e = 0; e < it->topology->edge_count; e++) {
        const sn_edge *edge = &it->topology->edges[e];
        double w = sn_edge_weight(it->mesh, edge);
        it->entries[edge->v[0]].value += w;
        it->entries[edge->v[1]].value += w;
        it->entries[count++] = (sn_entry){edge->v[1], edge->v[0], -w};
    }
    return sn_sparse_factor(n, count, it->entries, &it->factor, error);
}

/* Take out the constant, then scale to x' M x = 1; returns the length before that. */
static double normalize(const iteration *it, double *x) {
    double mean = 0.0, length = 0.0;
    for (sn_index v = 0; v < it->mesh->vertex_count; v++) mean += it->area[v] * x[v];
    mean /= it->total;
    for (sn_index v = 0; v < it->mesh->vertex_count; v++) length += it->area[v] * (x[v] - mean) * (x[v] - mean);
    length = sqrt(length);
    for (sn_index v = 0; v < it->mesh->vertex_count; v++) x[v] = length > 0.0 ? (x[v] - mean) / length : 0.0;
    return length;
}

static sn_status iterate(iteration *it, double *x, sn_error *error) {
    double before = 0.0;
    normalize(it, x);
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        for (sn_index v = 0; v < it->mesh->vertex_count; v++) it->right[v] = it->area[v] * x[v];
        sn_status status = sn_sparse_solve(it->factor, 1, it->right, x, error);
        if (status) return status;
        double growth = normalize(it, x);
        if (fabs(growth - before) <= CONVERGED * growth) break;
        before = growth;
    }
    return SN_OK;
}

sn_status sn_fiedler_field(const sn_mesh *mesh, const sn_topology *topology, double *u, sn_error *error) {
    size_t n = (size_t)mesh->vertex_count;
    iteration it = {.mesh = mesh, .topology = topology};
    it.area = SN_NEW(double, n);
    it.right = SN_NEW(double, n);
    it.entries = SN_NEW(sn_entry, n + (size_t)topology->edge_count);
    sn_status status = it.area && it.right && it.entries ? SN_OK : sn_fail_memory(error, "the slowest vibration of the surface");
    if (!status) {
        weigh_vertices(&it);
        status = factor_shifted(&it, error);
    }
    if (!status) status = iterate(&it, u, error);
    sn_sparse_destroy(it.factor);
    free(it.area);
    free(it.right);
    free(it.entries);
    return status;
}
