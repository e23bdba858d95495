/* field.c -- harmonic fields on a surface by the cotangent Laplacian. */
#include <stdlib.h>

#include "sinew/geom.h"
#include "sinew/sparse.h"

/* ---- cotangent weights ---------------------------------------------------------------------------------------------- */

/* Weights are kept within these: obtuse triangles give negative ones, which break the maximum principle, and needles huge ones. */
#define WEIGHT_LOW 1e-3
#define WEIGHT_HIGH 1e3

/* cot of the angle at apex between its directions to a and b; 0 where the triangle has no area. */
static double cotangent(sn_vec3 apex, sn_vec3 a, sn_vec3 b) {
    sn_vec3 u = sn_sub(a, apex), v = sn_sub(b, apex);
    double sine = sn_norm(sn_cross(u, v));
    return sine > 0.0 ? sn_dot(u, v) / sine : 0.0;
}

double sn_edge_weight(const sn_mesh *mesh, const sn_edge *edge) {
    const sn_vec3 *p = mesh->positions;
    double sum = 0.0;
    for (int side = 0; side < 2; side++)
        if (edge->opposite[side] != SN_NONE) sum += cotangent(p[edge->opposite[side]], p[edge->v[0]], p[edge->v[1]]);
    return fmin(fmax(0.5 * sum, WEIGHT_LOW), WEIGHT_HIGH);
}

/* ---- harmonic field --------------------------------------------------------------------------------------------------- */

enum { UNREACHED = -2, FIXED = -1 }; /* what `unknown` says of a vertex that is not one */

typedef struct harmonic {
    const sn_mesh *mesh;
    const sn_topology *topology;
    sn_index *unknown; /* (vertex_count) index among the unknowns, or FIXED or UNREACHED */
    sn_index *stack;   /* (vertex_count) */
    sn_index unknown_count, entry_count;
    sn_entry *entries; /* (unknowns + edges) */
    double *right;     /* (vertex_count) */
} harmonic;

static bool harmonic_alloc(harmonic *h) {
    size_t vertices = (size_t)h->mesh->vertex_count;
    h->unknown = SN_NEW(sn_index, vertices);
    h->stack = SN_NEW(sn_index, vertices);
    h->entries = SN_NEW(sn_entry, vertices + (size_t)h->topology->edge_count);
    h->right = SN_NEW(double, vertices);
    return h->unknown && h->stack && h->entries && h->right;
}

static void harmonic_free(harmonic *h) {
    free(h->unknown);
    free(h->stack);
    free(h->entries);
    free(h->right);
}

static sn_status set_fixed(harmonic *h, const sn_fixed_values *fixed, double *u, sn_error *error) {
    for (sn_index v = 0; v < h->mesh->vertex_count; v++) {
        h->unknown[v] = UNREACHED;
        u[v] = NAN;
    }
    for (sn_index i = 0; i < fixed->count; i++) {
        sn_index v = fixed->vertices[i];
        if (v < 0 || v >= h->mesh->vertex_count || !isfinite(fixed->values[i]))
            return sn_fail(error, SN_ERROR_INPUT, "fixed value %d of a harmonic field is not finite or not at a vertex", (int)i);
        h->unknown[v] = FIXED;
        u[v] = fixed->values[i];
    }
    return SN_OK;
}

/* Every vertex that a fixed one can reach is an unknown; numbered in vertex order. */
static void number_unknowns(harmonic *h) {
    const sn_topology *t = h->topology;
    sn_index top = 0;
    for (sn_index v = 0; v < h->mesh->vertex_count; v++)
        if (h->unknown[v] == FIXED) h->stack[top++] = v;
    while (top > 0) {
        sn_index v = h->stack[--top];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++)
            if (h->unknown[t->neighbours[k]] == UNREACHED) {
                h->unknown[t->neighbours[k]] = 0;
                h->stack[top++] = t->neighbours[k];
            }
    }
    for (sn_index v = 0; v < h->mesh->vertex_count; v++)
        if (h->unknown[v] >= 0) h->unknown[v] = h->unknown_count++;
}

/* sum_j w_ij (u_i - u_j) = 0 at every unknown; known u_j go to the right-hand side. */
static void assemble(harmonic *h, const double *u) {
    sn_entry *diagonal = h->entries;
    for (sn_index i = 0; i < h->unknown_count; i++) diagonal[i] = (sn_entry){i, i, 0.0};
    h->entry_count = h->unknown_count;
    for (sn_index e = 0; e < h->topology->edge_count; e++) {
        const sn_edge *edge = &h->topology->edges[e];
        sn_index i = h->unknown[edge->v[0]], j = h->unknown[edge->v[1]];
        if (i < 0 && j < 0) continue;
        double w = sn_edge_weight(h->mesh, edge);
        if (i >= 0) diagonal[i].value += w;
        if (j >= 0) diagonal[j].value += w;
        if (i >= 0 && j >= 0) h->entries[h->entry_count++] = (sn_entry){j, i, -w};
        if (i >= 0 && j < 0) h->right[i] += w * u[edge->v[1]];
        if (j >= 0 && i < 0) h->right[j] += w * u[edge->v[0]];
    }
}

static sn_status solve_unknowns(harmonic *h, double *u, sn_error *error) {
    if (h->unknown_count == 0) return SN_OK;
    assemble(h, u);
    sn_sparse *factor = NULL;
    sn_status status = sn_sparse_factor(h->unknown_count, h->entry_count, h->entries, &factor, error);
    if (!status) status = sn_sparse_solve(factor, 1, h->right, h->right, error);
    for (sn_index v = 0; !status && v < h->mesh->vertex_count; v++)
        if (h->unknown[v] >= 0) u[v] = h->right[h->unknown[v]];
    sn_sparse_destroy(factor);
    return status;
}

sn_status sn_harmonic_field(const sn_mesh *mesh, const sn_topology *topology, const sn_fixed_values *fixed, double *u, sn_error *error) {
    harmonic h = {.mesh = mesh, .topology = topology};
    sn_status status = harmonic_alloc(&h) ? SN_OK : sn_fail_memory(error, "a harmonic field");
    if (!status) status = set_fixed(&h, fixed, u, error);
    if (!status) {
        number_unknowns(&h);
        status = solve_unknowns(&h, u, error);
    }
    harmonic_free(&h);
    return status;
}
