/*
 * envelope_measure.c -- what a pose does to an envelope: triangles that shrink, bones that come out of it.
 */
#include "sinew/envelope.h"

#include <stdlib.h>

enum { GRAIN = 64 };

/* A vertex of a bone, in the order of bones and vertices. */
typedef struct measure_work {
    const sn_envelope_bone *bones;
    const sn_rigid *poses; /* NULL = rest */
    const sn_surface *surface;
    const sn_index *starts; /* (bone_count + 1) where each bone's vertices begin */
    double *distances;      /* (starts[bone_count]) */
} measure_work;

static sn_index bone_of(const measure_work *w, sn_index i) {
    sn_index b = 0;
    while (w->starts[b + 1] <= i) b++;
    return b;
}

static void measure_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const measure_work *w = user;
    sn_index b = bone_of(w, begin);
    (void)chunk;
    for (sn_index i = begin; i < end; i++) {
        while (w->starts[b + 1] <= i) b++;
        sn_vec3 rest = w->bones[b].mesh->positions[i - w->starts[b]];
        w->distances[i] = sn_surface_signed_distance(w->surface, w->poses != NULL ? sn_rigid_apply(w->poses[b], rest) : rest, NULL);
    }
}

static double area(const sn_vec3 *positions, sn_triangle t) {
    return 0.5 * sn_norm(sn_area_vector(positions[t.v[0]], positions[t.v[1]], positions[t.v[2]]));
}

static void measure_areas(const sn_envelope *envelope, const sn_vec3 *positions, sn_envelope_frame *out) {
    out->least_area = INFINITY;
    out->triangle = SN_NONE;
    for (sn_index t = 0; t < envelope->mesh.triangle_count; t++) {
        double rest = area(envelope->mesh.positions, envelope->mesh.triangles[t]);
        if (!(rest > 0.0)) continue;
        double ratio = area(positions, envelope->mesh.triangles[t]) / rest;
        out->small += ratio < SN_ENVELOPE_SMALL;
        if (!(ratio < out->least_area)) continue;
        out->least_area = ratio;
        out->triangle = t;
    }
}

static void count_outside(const measure_work *w, sn_index total, sn_envelope_frame *out) {
    sn_index farthest = 0;
    for (sn_index i = 0; i < total; i++) {
        out->outside += w->distances[i] > 0.0;
        out->deep += w->distances[i] > SN_ENVELOPE_DEEP;
        if (w->distances[i] > w->distances[farthest]) farthest = i;
    }
    out->deepest = w->distances[farthest];
    out->bone = bone_of(w, farthest);
    out->vertex = farthest - w->starts[out->bone];
}

static sn_status measure_bones(const sn_mesh *moved, measure_work *w, sn_index total, sn_pool *pool, sn_error *error) {
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(moved, &surface, error);
    if (status == SN_OK) {
        w->surface = surface;
        sn_parallel_for(pool, total, GRAIN, measure_range, w);
    }
    sn_surface_destroy(surface);
    return status;
}

/* The envelope's mesh with the moved vertices: it lends the triangles. */
static sn_status move(const sn_envelope *envelope, const sn_rigid *poses, sn_pool *pool, sn_mesh *moved, sn_error *error) {
    *moved = (sn_mesh){.vertex_count = envelope->mesh.vertex_count,
                       .triangle_count = envelope->mesh.triangle_count,
                       .triangles = envelope->mesh.triangles};
    moved->positions = SN_NEW(sn_vec3, moved->vertex_count);
    if (moved->positions == NULL) return sn_fail_memory(error, "a moved envelope");
    for (sn_index v = 0; v < moved->vertex_count; v++) moved->positions[v] = envelope->mesh.positions[v];
    if (poses != NULL) sn_envelope_deform(envelope, poses, pool, moved->positions);
    return SN_OK;
}

sn_status sn_envelope_measure(const sn_envelope *envelope, const sn_envelope_bone *bones, const sn_rigid *poses, sn_pool *pool,
                              sn_envelope_frame *out, sn_error *error) {
    sn_mesh moved;
    sn_index *starts = SN_NEW(sn_index, envelope->bone_count + 1);
    measure_work work = {.bones = bones, .poses = poses, .starts = starts};
    *out = (sn_envelope_frame){0};
    sn_status status = move(envelope, poses, pool, &moved, error);
    if (status == SN_OK && starts == NULL) status = sn_fail_memory(error, "a moved envelope");
    if (status == SN_OK) {
        for (sn_index b = 0; b < envelope->bone_count; b++) starts[b + 1] = starts[b] + bones[b].mesh->vertex_count;
        sn_index total = starts[envelope->bone_count];
        work.distances = SN_NEW(double, total);
        status = work.distances != NULL ? measure_bones(&moved, &work, total, pool, error) : sn_fail_memory(error, "a moved envelope");
        if (status == SN_OK) measure_areas(envelope, moved.positions, out);
        if (status == SN_OK) count_outside(&work, total, out);
    }
    free(work.distances);
    free(starts);
    free(moved.positions);
    return status;
}
