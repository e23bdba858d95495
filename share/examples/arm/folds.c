/*
 * folds.c -- how far the surface of a muscle has folded: the angles between neighbouring triangles against those at rest.
 *
 *   folds RIG.muscle.json SHAPE...
 *
 * SHAPE is a mesh with the vertices of the rig in their order, as simulate --format ply writes them. Prints a line for each, with tabs: its
 * name; the largest change of an angle away from rest, degrees; the change that 99 % of the edges stay below; the root mean square; and the
 * vertices of the edge with the largest. A rest shape has sharp edges of its own, so the angle itself tells nothing. A bend that is spread
 * over many edges changes each by its curvature times the width of its triangles: the finer the mesh, the less. A fold is one edge's own.
 */
#include <stdio.h>
#include <stdlib.h>

#include "sinew/exact.h"
#include "sinew/io.h"

static const double degrees = 180.0 / SN_PI;

/* The angles of the edges between two triangles, in a shape. */
typedef struct angles {
    sn_index count;
    sn_index *edges; /* (count) of the topology */
    double *rest;    /* (count) radians */
    double *change;  /* (count) of the shape at hand, radians, >= 0 */
} angles;

/* Angle between the triangles beside an edge, -pi to pi: 0 where they are in one plane, signed by the side to which they fold. */
static double dihedral(const sn_edge *edge, const sn_vec3 *p) {
    sn_vec3 from = p[edge->v[0]], axis = sn_sub(p[edge->v[1]], from);
    sn_vec3 left = sn_cross(axis, sn_sub(p[edge->opposite[0]], from)), right = sn_cross(sn_sub(p[edge->opposite[1]], from), axis);
    return sn_atan2(sn_dot(sn_cross(left, right), sn_normalize(axis)), sn_dot(left, right));
}

static sn_status angles_make(const sn_topology *topology, const sn_vec3 *positions, angles *a, sn_error *error) {
    a->edges = SN_NEW(sn_index, topology->edge_count);
    a->rest = SN_NEW(double, topology->edge_count);
    a->change = SN_NEW(double, topology->edge_count);
    if (!a->edges || !a->rest || !a->change) return sn_fail_memory(error, "the angles");
    for (sn_index i = 0; i < topology->edge_count; i++) {
        if (topology->edges[i].triangle_count != 2) continue;
        a->edges[a->count] = i;
        a->rest[a->count++] = dihedral(&topology->edges[i], positions);
    }
    return a->count ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "no two of its triangles are neighbours; mesh-clean welds them");
}

static void angles_free(angles *a) {
    free(a->edges);
    free(a->rest);
    free(a->change);
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_shape(const char *name, const sn_topology *topology, const sn_vec3 *positions, angles *a) {
    sn_index worst = 0;
    double squares = 0.0;
    for (sn_index i = 0; i < a->count; i++) {
        double change = fabs(dihedral(&topology->edges[a->edges[i]], positions) - a->rest[i]);
        a->change[i] = change > SN_PI ? 2.0 * SN_PI - change : change;
        squares += a->change[i] * a->change[i];
        if (a->change[i] > a->change[worst]) worst = i;
    }
    const sn_index *v = topology->edges[a->edges[worst]].v;
    double largest = degrees * a->change[worst], rms = degrees * sqrt(squares / a->count);
    qsort(a->change, (size_t)a->count, sizeof *a->change, ascending);
    printf("%s\t%.2f\t%.2f\t%.2f\t%d\t%d\n", name, largest, degrees * a->change[(sn_index)(0.99 * a->count)], rms, v[0], v[1]);
}

static sn_status measure(const char *path, const sn_topology *topology, angles *a, sn_error *error) {
    sn_mesh shape = {0};
    sn_status status = sn_mesh_read(path, &shape, NULL, error);
    if (!status && shape.vertex_count != topology->vertex_count)
        status = sn_fail(error, SN_ERROR_INPUT, "it has %d vertices, and the muscle %d; give the shapes that simulate made of it",
                         shape.vertex_count, topology->vertex_count);
    if (status)
        sn_error_set_file(error, path);
    else
        print_shape(path, topology, shape.positions, a);
    sn_mesh_free(&shape);
    return status;
}

static sn_status read_rig(const char *path, sn_muscle *muscle, sn_error *error) {
    sn_blob blob = {0};
    sn_document *document = NULL;
    const sn_read_options options = {0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (!status) status = sn_muscle_parse(&blob, &options, muscle, &document, error);
    sn_document_free(document);
    sn_blob_free(&blob);
    return status;
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "Usage: folds RIG.muscle.json SHAPE...\n");
        return 2;
    }
    sn_muscle muscle = {0};
    sn_topology topology = {0};
    angles a = {0};
    sn_error error = {0};
    sn_status status = read_rig(argv[1], &muscle, &error);
    if (!status) status = sn_topology_build(&muscle.mesh, &topology, &error);
    if (!status) status = angles_make(&topology, muscle.mesh.positions, &a, &error);
    if (status) sn_error_set_file(&error, argv[1]);
    if (!status) printf("shape\tlargest\tp99\trms\ta\tb\n");
    for (int i = 2; i < argc && !status; i++) status = measure(argv[i], &topology, &a, &error);
    if (status) fprintf(stderr, "folds: %s%s%s\n", error.file, error.file[0] ? ": " : "", error.text);
    angles_free(&a);
    sn_topology_free(&topology);
    sn_muscle_free(&muscle);
    return status ? 1 : fflush(stdout) == 0 ? 0 : 1;
}
