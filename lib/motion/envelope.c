/*
 * envelope.c -- a surface bound to bones: what it is, and where poses carry it.
 */
#include "sinew/envelope.h"

#include <stdlib.h>
#include <string.h>

const char *const sn_envelope_method_names[] = {"blend", "wrap", NULL};

enum { GRAIN = 1024 }; /* vertices a thread takes at once */

void sn_envelope_free(sn_envelope *envelope) {
    for (sn_index b = 0; envelope->bones != NULL && b < envelope->bone_count; b++) free(envelope->bones[b]);
    free(envelope->bones);
    free(envelope->influences);
    free(envelope->name);
    sn_mesh_free(&envelope->mesh);
    *envelope = (sn_envelope){0};
}

/* ---- validity ----------------------------------------------------------------------------------------------------------------- */

static sn_status check_names(const sn_envelope *envelope, sn_error *error) {
    for (sn_index b = 0; b < envelope->bone_count; b++) {
        if (envelope->bones[b] == NULL) return sn_fail(error, SN_ERROR_INPUT, "bone %d of the envelope has no name", b);
        for (sn_index other = 0; other < b; other++)
            if (strcmp(envelope->bones[b], envelope->bones[other]) == 0)
                return sn_fail(error, SN_ERROR_INPUT, "two bones of the envelope are called \"%s\"", envelope->bones[b]);
    }
    return SN_OK;
}

/* Bones in range, each once, weights above 0 with the sum 1. */
static bool is_sound(const sn_influence *influence, sn_index bone_count) {
    double sum = 0.0;
    if (influence->count < 1 || influence->count > SN_INFLUENCE_LIMIT) return false;
    for (sn_index k = 0; k < influence->count; k++) {
        if (influence->bones[k] < 0 || influence->bones[k] >= bone_count || !(influence->weights[k] > 0.0)) return false;
        for (sn_index other = 0; other < k; other++)
            if (influence->bones[other] == influence->bones[k]) return false;
        if (k > 0 && influence->weights[k] > influence->weights[k - 1]) return false;
        sum += influence->weights[k];
    }
    return influence->count == 1 ? sum == 1.0 : fabs(sum - 1.0) <= 1e-9;
}

sn_status sn_envelope_validate(const sn_envelope *envelope, sn_error *error) {
    sn_status status = sn_mesh_validate(&envelope->mesh, error);
    if (status == SN_OK) status = check_names(envelope, error);
    for (sn_index v = 0; v < envelope->mesh.vertex_count && status == SN_OK; v++) {
        if (is_sound(&envelope->influences[v], envelope->bone_count)) continue;
        if (error != NULL) error->element = v;
        status =
            sn_fail(error, SN_ERROR_INPUT,
                    "vertex %d of the envelope is not carried by one to four bones, each once, the heaviest first, with weights above 0 "
                    "that sum to 1; bind it anew with envelope-bind",
                    v);
    }
    return status;
}

/* ---- deformation -------------------------------------------------------------------------------------------------------------- */

typedef struct deform_work {
    const sn_envelope *envelope;
    const sn_rigid *poses;
    sn_vec3 *positions;
} deform_work;

static void add_quat(sn_quat *sum, sn_quat q, double weight) {
    sum->w += weight * q.w;
    sum->x += weight * q.x;
    sum->y += weight * q.y;
    sum->z += weight * q.z;
}

/* poses: of the bones that carry the vertex. The sum of them as dual quaternions r + e t r / 2, each on the hemisphere of the first, over
 * the length of its real part. That is at least the first's weight, 1/4: no two poses cancel. */
static sn_vec3 blend(const sn_influence *influence, const sn_rigid *poses, sn_vec3 rest) {
    sn_quat real = {0, 0, 0, 0}, dual = {0, 0, 0, 0}, first = poses[0].rotation;
    for (sn_index k = 0; k < influence->count; k++) {
        const sn_rigid *pose = &poses[k];
        double weight = sn_quat_dot(first, pose->rotation) < 0.0 ? -influence->weights[k] : influence->weights[k];
        sn_quat shift = {0.0, pose->translation.x, pose->translation.y, pose->translation.z};
        add_quat(&real, pose->rotation, weight);
        add_quat(&dual, sn_quat_multiply(shift, pose->rotation), weight); /* twice the dual part */
    }
    double squared = sn_quat_dot(real, real);
    sn_quat way = sn_quat_multiply(dual, sn_quat_conjugate(real));
    sn_vec3 turned = sn_quat_rotate(sn_quat_normalize(real), rest);
    return sn_add(turned, sn_v3(way.x / squared, way.y / squared, way.z / squared));
}

/* The mean of where each bone carries the vertex. */
static sn_vec3 wrap(const sn_influence *influence, const sn_rigid *poses, sn_vec3 rest) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index k = 0; k < influence->count; k++) sum = sn_add_scaled(sum, sn_rigid_apply(poses[k], rest), influence->weights[k]);
    return sum;
}

sn_vec3 sn_envelope_vertex(const sn_envelope *envelope, sn_index vertex, const sn_rigid *poses) {
    const sn_influence *influence = &envelope->influences[vertex];
    sn_vec3 rest = envelope->mesh.positions[vertex];
    if (influence->count == 1) return sn_rigid_apply(poses[0], rest);
    return envelope->method == SN_ENVELOPE_WRAP ? wrap(influence, poses, rest) : blend(influence, poses, rest);
}

static void deform_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const deform_work *w = user;
    sn_rigid poses[SN_INFLUENCE_LIMIT];
    (void)chunk;
    for (sn_index v = begin; v < end; v++) {
        const sn_influence *influence = &w->envelope->influences[v];
        for (sn_index k = 0; k < influence->count; k++) poses[k] = w->poses[influence->bones[k]];
        w->positions[v] = sn_envelope_vertex(w->envelope, v, poses);
    }
}

void sn_envelope_deform(const sn_envelope *envelope, const sn_rigid *poses, sn_pool *pool, sn_vec3 *positions) {
    deform_work work = {envelope, poses, positions};
    sn_parallel_for(pool, envelope->mesh.vertex_count, GRAIN, deform_range, &work);
}
