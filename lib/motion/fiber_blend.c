/* fiber_blend.c -- fibres carried by the bones at their two ends, without a muscle around them ([K21] 5; Modenese and Kohout 2020). */
#include "sinew/fibers.h"

#include <stdlib.h>
#include <string.h>

/* Joint of the bone of that name; the scene is valid, so it has one. */
static sn_index joint_of(const sn_scene *scene, const char *bone) {
    for (sn_index b = 0; b < scene->bone_count; b++)
        if (strcmp(scene->bones[b].name, bone) == 0) return scene->bones[b].joint;
    return SN_NONE;
}

/* The attachment with the vertex nearest to p; SN_NONE = nothing is attached. */
static sn_index nearest_attachment(const sn_muscle *muscle, sn_vec3 p) {
    sn_index found = SN_NONE;
    double nearest = INFINITY;
    for (sn_index a = 0; a < muscle->attachment_count; a++)
        for (sn_index i = 0; i < muscle->attachments[a].count; i++) {
            double distance = sn_norm2(sn_sub(muscle->mesh.positions[muscle->attachments[a].vertices[i]], p));
            if (distance >= nearest) continue;
            nearest = distance;
            found = a;
        }
    return found;
}

static sn_status find_joints(const sn_scene *scene, const sn_muscle *muscle, const sn_fiber_bundle *bundle, sn_fiber_blend *out,
                             sn_error *error) {
    for (sn_index i = 0; i < bundle->fiber_count; i++)
        for (int end = 0; end < 2; end++) {
            sn_vec3 p = bundle->points[end == 0 ? bundle->start[i] : bundle->start[i + 1] - 1];
            sn_index a = nearest_attachment(muscle, p);
            if (a == SN_NONE)
                return sn_fail(error, SN_ERROR_INPUT,
                               "the muscle is attached to no bone, so there is nothing to blend its fibres between (attach-detect attaches "
                               "it)");
            out->joints[2 * i + end] = joint_of(scene, muscle->attachments[a].bone);
        }
    return SN_OK;
}

static void find_weights(const sn_fiber_bundle *bundle, double exponent, double *weights) {
    for (sn_index i = 0; i < bundle->fiber_count; i++) {
        double before = 0.0;
        for (sn_index k = bundle->start[i]; k < bundle->start[i + 1]; k++) {
            if (k > bundle->start[i]) before += sn_distance(bundle->points[k - 1], bundle->points[k]);
            weights[k] = sn_quick_pow(before / bundle->rest_length[i], exponent);
        }
    }
}

sn_status sn_fiber_blend_create(const sn_scene *scene, const sn_muscle *muscle, const sn_fiber_bundle *bundle, double exponent,
                                sn_fiber_blend *out, sn_error *error) {
    *out = (sn_fiber_blend){.meters_per_unit = muscle->meters_per_unit};
    if (!(exponent > 0.0 && isfinite(exponent))) return sn_fail(error, SN_ERROR_USAGE, "the exponent of a blend must be above 0");
    out->joints = SN_NEW(sn_index, 2 * (size_t)bundle->fiber_count);
    out->weights = SN_NEW(double, bundle->point_count);
    bool enough = out->joints != NULL && out->weights != NULL;
    sn_status status = enough ? find_joints(scene, muscle, bundle, out, error) : sn_fail_memory(error, "the blend of the fibres");
    if (status == SN_OK)
        find_weights(bundle, exponent, out->weights);
    else
        sn_fiber_blend_free(out);
    return status;
}

void sn_fiber_blend_free(sn_fiber_blend *blend) {
    free(blend->joints);
    free(blend->weights);
    *blend = (sn_fiber_blend){0};
}

void sn_fiber_blend_apply(const sn_fiber_blend *blend, const sn_fiber_bundle *bundle, const sn_rigid *poses, sn_vec3 *points) {
    double unit = blend->meters_per_unit;
    for (sn_index i = 0; i < bundle->fiber_count; i++) {
        sn_index origin = blend->joints[2 * i], insertion = blend->joints[2 * i + 1];
        sn_rigid first = origin == SN_NONE ? sn_rigid_identity() : poses[origin];
        sn_rigid last = insertion == SN_NONE ? sn_rigid_identity() : poses[insertion];
        for (sn_index k = bundle->start[i]; k < bundle->start[i + 1]; k++) {
            sn_vec3 x = sn_scale(bundle->points[k], unit);
            points[k] = sn_scale(sn_lerp(sn_rigid_apply(first, x), sn_rigid_apply(last, x), blend->weights[k]), 1.0 / unit);
        }
    }
}
