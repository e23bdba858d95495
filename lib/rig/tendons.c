/*
 * tendons.c -- weights of external constraints by rule: near its attachments a muscle is tendon, farther it is belly ([R18] 4.3).
 */
#include "sinew/rig.h"

#include <stdlib.h>

/* Share of the muscle's length that counts as tendon. */
static const double TENDON_SHARE = 0.1;

static sn_vec3 farthest(const sn_mesh *mesh, sn_vec3 from) {
    sn_vec3 best = from;
    double most = 0.0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        double distance = sn_distance(mesh->positions[v], from);
        if (distance > most) most = distance, best = mesh->positions[v];
    }
    return best;
}

double sn_tendon_default(const sn_muscle *muscle) {
    if (muscle->mesh.vertex_count == 0) return 0.0;
    sn_vec3 tip = farthest(&muscle->mesh, muscle->mesh.positions[0]);
    return TENDON_SHARE * sn_distance(tip, farthest(&muscle->mesh, tip));
}

static double smooth_step(double t) {
    t = fmin(fmax(t, 0.0), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/* The vertices of all attachments. *out (*count) is owned by the caller. */
static sn_status gather(const sn_muscle *muscle, sn_index *count, sn_index **out, sn_error *error) {
    *count = 0;
    for (sn_index i = 0; i < muscle->attachment_count; i++) *count += muscle->attachments[i].count;
    if (*count == 0)
        return sn_fail(error, SN_ERROR_INPUT,
                       "weights by rule need attachments, and the muscle has none: name its bones, or give the weights");
    sn_index *next = *out = SN_NEW(sn_index, *count);
    if (*out == NULL) return sn_fail_memory(error, "the tendons");
    for (sn_index i = 0; i < muscle->attachment_count; i++)
        for (sn_index k = 0; k < muscle->attachments[i].count; k++) *next++ = muscle->attachments[i].vertices[k];
    return SN_OK;
}

sn_status sn_tendon_slide(const sn_muscle *muscle, double distance, double *slide, sn_error *error) {
    sn_topology topology = {0};
    sn_index count, *sources = NULL;
    if (!(distance > 0.0 && isfinite(distance))) return sn_fail(error, SN_ERROR_USAGE, "the length of a tendon must be greater than 0");
    sn_status status = gather(muscle, &count, &sources, error);
    if (status == SN_OK) status = sn_topology_build(&muscle->mesh, &topology, error);
    if (status == SN_OK) status = sn_geodesic_distance(&muscle->mesh, &topology, count, sources, slide, error);
    for (sn_index v = 0; v < muscle->mesh.vertex_count && status == SN_OK; v++) slide[v] = smooth_step(slide[v] / distance);
    sn_topology_free(&topology);
    free(sources);
    return status;
}
