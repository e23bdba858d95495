/*
 * lengths.c -- how a simulation changed the surface edges of a muscle along and across its fibres.   [K21] figure 8, in figures
 *
 *   lengths RIG.muscle.json FRAMES.pc2 [OTHER.pc2]
 *
 * Prints a line per frame, with tabs: frame; mean length of the edges along the fibres over that at rest; the same across; rms of the
 * edges' change of length over the mean edge; and how far the points are from those of OTHER's frame, rms over the mean edge (nan without).
 * An edge at angle phi to the fibre counts cos^2 phi along and sin^2 phi across.
 */
#include <stdio.h>
#include <stdlib.h>

#include "sinew/io.h"

/* What the frames are measured against: the edges at rest. */
typedef struct rest {
    sn_muscle muscle;
    sn_topology topology;
    double *share; /* (edges) cos^2 phi */
    double mean_edge;
} rest;

static double edge_length(const rest *r, const sn_vec3 *positions, sn_index edge) {
    const sn_index *v = r->topology.edges[edge].v;
    return sn_distance(positions[v[0]], positions[v[1]]);
}

/* cos^2 of the angle between an edge and the fibre at its ends; directions have no sign. */
static double share_along(const rest *r, sn_index edge) {
    const sn_index *v = r->topology.edges[edge].v;
    const sn_vec3 *positions = r->muscle.mesh.positions, *f = r->muscle.fibers.directions;
    sn_vec3 axis = sn_dot(f[v[0]], f[v[1]]) < 0.0 ? sn_sub(f[v[0]], f[v[1]]) : sn_add(f[v[0]], f[v[1]]);
    double cosine = sn_dot(sn_normalize(sn_sub(positions[v[1]], positions[v[0]])), sn_normalize(axis));
    return cosine * cosine;
}

static sn_status rest_load(rest *r, const char *path, sn_error *error) {
    sn_blob blob = {0};
    sn_document *document = NULL;
    const sn_read_options options = {0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (!status) status = sn_muscle_parse(&blob, &options, &r->muscle, &document, error);
    sn_document_free(document);
    sn_blob_free(&blob);
    if (!status && !r->muscle.fibers.directions)
        status = sn_fail(error, SN_ERROR_INPUT, "it has no fibre directions; fiber-flow makes them");
    if (!status) status = sn_topology_build(&r->muscle.mesh, &r->topology, error);
    if (!status && !(r->share = SN_NEW(double, r->topology.edge_count))) status = sn_fail_memory(error, "the edges");
    for (sn_index i = 0; !status && i < r->topology.edge_count; i++) {
        r->share[i] = share_along(r, i);
        r->mean_edge += edge_length(r, r->muscle.mesh.positions, i) / r->topology.edge_count;
    }
    if (status) sn_error_set_file(error, path);
    return status;
}

static sn_status frames_load(const rest *r, const char *path, sn_pc2_data *frames, sn_error *error) {
    sn_status status = sn_pc2_read(path, frames, error);
    if (!status && frames->point_count != r->muscle.mesh.vertex_count)
        status = sn_fail(error, SN_ERROR_INPUT, "the frames have %d points, and the muscle %d vertices", frames->point_count,
                         r->muscle.mesh.vertex_count);
    if (status) sn_error_set_file(error, path);
    return status;
}

static void frame_positions(const sn_pc2_data *frames, sn_index frame, sn_vec3 *positions) {
    const float *x = frames->positions + 3 * (size_t)frame * (size_t)frames->point_count;
    for (sn_index i = 0; i < frames->point_count; i++, x += 3) positions[i] = sn_v3((double)x[0], (double)x[1], (double)x[2]);
}

/* Root mean square distance of two sets of points over the mean edge. */
static double apart(const rest *r, const sn_vec3 *a, const sn_vec3 *b) {
    double sum = 0.0;
    for (sn_index i = 0; i < r->muscle.mesh.vertex_count; i++) sum += sn_norm2(sn_sub(a[i], b[i]));
    return sqrt(sum / r->muscle.mesh.vertex_count) / r->mean_edge;
}

static void print_frame(const rest *r, double number, const sn_vec3 *positions, double away) {
    double along[2] = {0}, across[2] = {0}, squares = 0.0;
    for (sn_index i = 0; i < r->topology.edge_count; i++) {
        double was = edge_length(r, r->muscle.mesh.positions, i), is = edge_length(r, positions, i), share = r->share[i];
        along[0] += share * was, along[1] += share * is;
        across[0] += (1.0 - share) * was, across[1] += (1.0 - share) * is;
        squares += (is - was) * (is - was);
    }
    double change = sqrt(squares / r->topology.edge_count) / r->mean_edge;
    printf("%g\t%.6f\t%.6f\t%.6f\t%.6f\n", number, along[1] / along[0], across[1] / across[0], change, away);
}

static sn_status print_frames(const rest *r, const sn_pc2_data *frames, const sn_pc2_data *other, sn_error *error) {
    sn_vec3 *here = SN_NEW(sn_vec3, frames->point_count), *there = SN_NEW(sn_vec3, frames->point_count);
    sn_status status = here && there ? SN_OK : sn_fail_memory(error, "a frame");
    printf("frame\talong\tacross\trms\tapart\n");
    for (sn_index f = 0; f < frames->sample_count && !status; f++) {
        bool both = other->positions && f < other->sample_count;
        frame_positions(frames, f, here);
        if (both) frame_positions(other, f, there);
        print_frame(r, frames->start_frame + f * frames->sample_rate, here, both ? apart(r, here, there) : NAN);
    }
    free(here);
    free(there);
    return status;
}

int main(int argc, char **argv) {
    if (argc != 3 && argc != 4) {
        fprintf(stderr, "Usage: lengths RIG.muscle.json FRAMES.pc2 [OTHER.pc2]\n");
        return 2;
    }
    rest r = {0};
    sn_pc2_data frames = {0}, other = {0};
    sn_error error = {0};
    sn_status status = rest_load(&r, argv[1], &error);
    if (!status) status = frames_load(&r, argv[2], &frames, &error);
    if (!status && argc == 4) status = frames_load(&r, argv[3], &other, &error);
    if (!status) status = print_frames(&r, &frames, &other, &error);
    if (status) fprintf(stderr, "lengths: %s%s%s\n", error.file, error.file[0] ? ": " : "", error.text);
    sn_pc2_free(&frames);
    sn_pc2_free(&other);
    sn_topology_free(&r.topology);
    sn_muscle_free(&r.muscle);
    free(r.share);
    return status ? 1 : fflush(stdout) == 0 ? 0 : 1;
}
