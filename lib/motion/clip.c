/*
 * clip.c -- a recorded motion: its memory and checks, poses in the world and in the parents' frames, jumps, frames to keep.
 */
#include "sinew/motion_clip.h"

#include <stdlib.h>
#include <string.h>

/* How far from 1 the squared length of a quaternion may be. */
static const double UNIT_TOLERANCE = 1e-6;

/* ---- memory ------------------------------------------------------------------------------------------------------------------ */

static bool allocate_joint(sn_clip_joint *joint, sn_index frame_count) {
    joint->parent = SN_NONE;
    joint->rest_rotation = sn_quat_identity();
    joint->poses = SN_NEW(sn_rigid, frame_count);
    for (sn_index f = 0; joint->poses != NULL && f < frame_count; f++) joint->poses[f] = sn_rigid_identity();
    return joint->poses != NULL;
}

sn_status sn_clip_create(sn_index frame_count, sn_index joint_count, sn_index coordinate_count, sn_clip *out, sn_error *error) {
    *out = (sn_clip){.frame_count = frame_count, .meters_per_unit_of_source = 1.0};
    out->joints = SN_NEW(sn_clip_joint, joint_count);
    out->coordinates = SN_NEW(sn_clip_coordinate, coordinate_count);
    bool enough = out->joints != NULL && out->coordinates != NULL;
    for (sn_index j = 0; j < joint_count && enough; j++) {
        out->joint_count = j + 1;
        enough = allocate_joint(&out->joints[j], frame_count);
    }
    for (sn_index c = 0; c < coordinate_count && enough; c++) {
        out->coordinate_count = c + 1;
        enough = (out->coordinates[c].values = SN_NEW(double, frame_count)) != NULL;
    }
    if (enough) return SN_OK;
    sn_clip_free(out);
    return sn_fail_memory(error, "the frames of a motion");
}

void sn_clip_free(sn_clip *clip) {
    if (clip == NULL) return;
    for (sn_index j = 0; j < clip->joint_count; j++) {
        free(clip->joints[j].name);
        free(clip->joints[j].poses);
    }
    for (sn_index c = 0; c < clip->coordinate_count; c++) {
        free(clip->coordinates[c].name);
        free(clip->coordinates[c].unit);
        free(clip->coordinates[c].values);
    }
    sn_motion_bones_free(clip->bones, clip->bone_count);
    for (sn_index i = 0; i < clip->animation_count; i++) free(clip->animations[i].name);
    free(clip->animations);
    free(clip->joints);
    free(clip->coordinates);
    free(clip->name);
    *clip = (sn_clip){0};
}

/* ---- checks ------------------------------------------------------------------------------------------------------------------ */

static bool is_unit(sn_quat q) { return fabs(sn_quat_dot(q, q) - 1.0) <= UNIT_TOLERANCE; }

static int compare_names(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

/* A name that stands twice among count; NULL = none. names is sorted. */
static const char *find_twin(const char **names, sn_index count) {
    qsort((void *)names, (size_t)count, sizeof *names, compare_names);
    for (sn_index i = 1; i < count; i++)
        if (strcmp(names[i - 1], names[i]) == 0) return names[i];
    return NULL;
}

static sn_status check_names(const sn_clip *clip, bool joints, sn_error *error) {
    sn_index count = joints ? clip->joint_count : clip->coordinate_count;
    const char *what = joints ? "joint" : "coordinate", **names = sn_alloc((size_t)count, sizeof *names);
    sn_status status = names != NULL ? SN_OK : sn_fail_memory(error, "names");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        names[i] = joints ? clip->joints[i].name : clip->coordinates[i].name;
        if (names[i] == NULL || *names[i] == '\0') status = sn_fail(error, SN_ERROR_INPUT, "%s %d has no name", what, i + 1);
    }
    const char *twin = status == SN_OK ? find_twin(names, count) : NULL;
    if (twin != NULL) status = sn_fail(error, SN_ERROR_INPUT, "two %ss have the name \"%s\"; rename one", what, twin);
    free((void *)names);
    return status;
}

static sn_status check_joint(const sn_clip *clip, sn_index j, sn_error *error) {
    const sn_clip_joint *joint = &clip->joints[j];
    if (joint->parent != SN_NONE && (joint->parent < 0 || joint->parent >= j))
        return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its parent must come before it", joint->name);
    if (!sn_finite3(joint->rest) || !is_unit(joint->rest_rotation) || (joint->has_end && !sn_finite3(joint->end)))
        return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its rest place is not finite", joint->name);
    for (sn_index f = 0; f < clip->frame_count; f++)
        if (!sn_finite3(joint->poses[f].translation) || !is_unit(joint->poses[f].rotation))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its pose in frame %d is not finite; are lengths or angles huge?",
                           joint->name, f);
    return SN_OK;
}

static sn_status check_coordinate(const sn_clip *clip, sn_index c, sn_error *error) {
    const sn_clip_coordinate *coordinate = &clip->coordinates[c];
    if (coordinate->unit == NULL) return sn_fail(error, SN_ERROR_INPUT, "coordinate \"%s\" has no unit", coordinate->name);
    for (sn_index f = 0; f < clip->frame_count; f++)
        if (!isfinite(coordinate->values[f]))
            return sn_fail(error, SN_ERROR_INPUT, "coordinate \"%s\" is not finite in frame %d", coordinate->name, f);
    return SN_OK;
}

sn_status sn_clip_validate(const sn_clip *clip, sn_error *error) {
    if (clip->frame_count < 1) return sn_fail(error, SN_ERROR_INPUT, "the motion has no frame");
    if (clip->joint_count < 1) return sn_fail(error, SN_ERROR_INPUT, "the motion has no joint");
    if (!(clip->rate > 0.0) || !isfinite(clip->rate))
        return sn_fail(error, SN_ERROR_INPUT, "the rate of the motion, %g, is not positive", clip->rate);
    sn_status status = check_names(clip, true, error);
    if (status == SN_OK) status = check_names(clip, false, error);
    for (sn_index j = 0; j < clip->joint_count && status == SN_OK; j++) status = check_joint(clip, j, error);
    for (sn_index c = 0; c < clip->coordinate_count && status == SN_OK; c++) status = check_coordinate(clip, c, error);
    return status;
}

/* ---- poses in the parents' frames ---------------------------------------------------------------------------------------------- */

sn_rigid sn_clip_about(sn_vec3 centre, sn_rigid local) {
    sn_vec3 moved = sn_add(centre, local.translation);
    return (sn_rigid){local.rotation, sn_sub(moved, sn_quat_rotate(local.rotation, centre))};
}

void sn_clip_to_local(sn_clip *clip) {
    for (sn_index j = clip->joint_count - 1; j >= 0; j--) { /* children first: they need their parents' world poses */
        sn_clip_joint *joint = &clip->joints[j];
        const sn_rigid *parent = joint->parent != SN_NONE ? clip->joints[joint->parent].poses : NULL;
        for (sn_index f = 0; f < clip->frame_count; f++) {
            sn_rigid pose = joint->poses[f];
            if (parent != NULL) pose = sn_rigid_compose(sn_rigid_inverse(parent[f]), pose);
            pose.translation = sn_sub(sn_rigid_apply(pose, joint->rest), joint->rest);
            joint->poses[f] = pose;
        }
    }
}

void sn_clip_to_world(sn_clip *clip) {
    for (sn_index j = 0; j < clip->joint_count; j++) {
        sn_clip_joint *joint = &clip->joints[j];
        const sn_rigid *parent = joint->parent != SN_NONE ? clip->joints[joint->parent].poses : NULL;
        for (sn_index f = 0; f < clip->frame_count; f++) {
            sn_rigid pose = sn_clip_about(joint->rest, joint->poses[f]);
            if (parent != NULL) pose = sn_rigid_compose(parent[f], pose);
            pose.rotation = sn_quat_normalize(pose.rotation);
            joint->poses[f] = pose;
        }
    }
}

/* ---- the up axis ---------------------------------------------------------------------------------------------------------------- */

static sn_vec3 turn_vector(sn_vec3 v) { return sn_v3(v.x, 0.0 - v.z, v.y); } /* no -0, which would be written as 0 */

/* The same rotation about the turned axis. */
static sn_quat turn_rotation(sn_quat q) { return (sn_quat){q.w, q.x, 0.0 - q.z, q.y}; }

void sn_clip_turn_y_up(sn_clip *clip) {
    static const double HALF_ROOT = 0.70710678118654752440;
    const sn_quat quarter = {HALF_ROOT, HALF_ROOT, 0, 0}; /* of a turn about x */
    for (sn_index j = 0; j < clip->joint_count; j++) {
        sn_clip_joint *joint = &clip->joints[j];
        joint->rest = turn_vector(joint->rest);
        joint->end = turn_vector(joint->end);
        joint->rest_rotation = sn_quat_normalize(sn_quat_multiply(quarter, joint->rest_rotation));
        for (sn_index f = 0; f < clip->frame_count; f++)
            joint->poses[f] = (sn_rigid){turn_rotation(joint->poses[f].rotation), turn_vector(joint->poses[f].translation)};
    }
}

/* ---- jumps ---------------------------------------------------------------------------------------------------------------------- */

/* Rotation in the parent's frame. */
static sn_quat local_rotation(const sn_clip *clip, sn_index j, sn_index f) {
    sn_index parent = clip->joints[j].parent;
    sn_quat q = clip->joints[j].poses[f].rotation;
    return parent == SN_NONE ? q : sn_quat_multiply(sn_quat_conjugate(clip->joints[parent].poses[f].rotation), q);
}

sn_status sn_clip_jumps(const sn_clip *clip, sn_clip_jump **out, sn_index *count, sn_error *error) {
    const double least = sn_cos(0.5 * SN_CLIP_JUMP);
    size_t capacity = 0;
    sn_quat *before = SN_NEW(sn_quat, clip->joint_count);
    *out = NULL;
    *count = 0;
    if (before == NULL) return sn_fail_memory(error, "jumps");
    for (sn_index f = 0; f < clip->frame_count; f++) {
        for (sn_index j = 0; j < clip->joint_count; j++) {
            sn_quat q = local_rotation(clip, j, f);
            double cosine = f > 0 ? fabs(sn_quat_dot(before[j], q)) : 1.0;
            before[j] = q;
            if (cosine > least) continue;
            if (!sn_grow((void **)out, &capacity, (size_t)*count + 1, sizeof **out)) {
                free(before);
                free(*out);
                *out = NULL;
                *count = 0;
                return sn_fail_memory(error, "jumps");
            }
            (*out)[(*count)++] = (sn_clip_jump){j, f, 2.0 * sn_acos(fmin(cosine, 1.0))};
        }
    }
    free(before);
    return SN_OK;
}

/* ---- frames to keep --------------------------------------------------------------------------------------------------------------- */

sn_status sn_clip_crop(sn_clip *clip, sn_index first, sn_index last, sn_error *error) {
    if (first < 0 || last < first || last >= clip->frame_count)
        return sn_fail(error, SN_ERROR_USAGE, "frames %d to %d are not there: the motion has the frames 0 to %d", first, last,
                       clip->frame_count - 1);
    size_t count = (size_t)(last - first) + 1;
    for (sn_index j = 0; j < clip->joint_count; j++)
        memmove(clip->joints[j].poses, clip->joints[j].poses + first, count * sizeof(sn_rigid));
    for (sn_index c = 0; c < clip->coordinate_count; c++)
        memmove(clip->coordinates[c].values, clip->coordinates[c].values + first, count * sizeof(double));
    clip->frame_count = (sn_index)count;
    return SN_OK;
}
