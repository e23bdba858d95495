/*
 * clip_convert.c -- a clip as joints with a key a frame, and a motion of any joints sampled as a clip.
 */
#include "sinew/motion_clip.h"

#include <stdlib.h>
#include <string.h>

/* ---- to a motion ----------------------------------------------------------------------------------------------------------------- */

static sn_status convert_joint(const sn_clip *clip, sn_index j, sn_joint *out, sn_error *error) {
    const sn_clip_joint *joint = &clip->joints[j];
    const sn_rigid *parent = joint->parent != SN_NONE ? clip->joints[joint->parent].poses : NULL;
    *out = (sn_joint){.parent = joint->parent,
                      .kind = SN_JOINT_POSE,
                      .has_rest = !joint->placeless,
                      .rest = joint->rest,
                      .rest_rotation = joint->rest_rotation,
                      .has_end = joint->has_end,
                      .end = joint->end};
    out->name = sn_strdup(joint->name);
    out->keys = SN_NEW(sn_pose_key, clip->frame_count);
    if (out->name == NULL || out->keys == NULL) return sn_fail_memory(error, "the keys of a joint");
    out->key_count = clip->frame_count;
    for (sn_index f = 0; f < clip->frame_count; f++) {
        sn_rigid pose = joint->poses[f];
        if (parent != NULL) pose = sn_rigid_compose(sn_rigid_inverse(parent[f]), pose);
        out->keys[f] = (sn_pose_key){f / clip->rate, {sn_quat_normalize(pose.rotation), pose.translation}};
    }
    return SN_OK;
}

static sn_status convert_coordinate(const sn_clip *clip, sn_index c, sn_coordinate *out, sn_error *error) {
    const sn_clip_coordinate *coordinate = &clip->coordinates[c];
    *out = (sn_coordinate){.name = sn_strdup(coordinate->name), .unit = sn_strdup(coordinate->unit), .rate = clip->rate};
    out->values = SN_NEW(double, clip->frame_count);
    if (out->name == NULL || out->unit == NULL || out->values == NULL) return sn_fail_memory(error, "a coordinate");
    out->count = clip->frame_count;
    memcpy(out->values, coordinate->values, (size_t)clip->frame_count * sizeof(double));
    return SN_OK;
}

static sn_status copy_bones(const sn_motion_bone *from, sn_index count, sn_motion_bone **to, sn_index *to_count, sn_error *error) {
    *to = sn_motion_bones_copy(from, count);
    *to_count = *to != NULL ? count : 0;
    return *to_count == count ? SN_OK : sn_fail_memory(error, "bones");
}

sn_status sn_clip_to_motion(const sn_clip *clip, sn_motion *out, sn_error *error) {
    *out = (sn_motion){.joints = SN_NEW(sn_joint, clip->joint_count), .coordinates = SN_NEW(sn_coordinate, clip->coordinate_count)};
    sn_status status = out->joints != NULL && out->coordinates != NULL ? SN_OK : sn_fail_memory(error, "a motion");
    for (sn_index j = 0; j < clip->joint_count && status == SN_OK; j++) {
        out->joint_count = j + 1;
        status = convert_joint(clip, j, &out->joints[j], error);
    }
    for (sn_index c = 0; c < clip->coordinate_count && status == SN_OK; c++) {
        out->coordinate_count = c + 1;
        status = convert_coordinate(clip, c, &out->coordinates[c], error);
    }
    if (status == SN_OK) status = copy_bones(clip->bones, clip->bone_count, &out->bones, &out->bone_count, error);
    if (status != SN_OK) sn_motion_free(out);
    return status;
}

/* ---- from a motion --------------------------------------------------------------------------------------------------------------- */

/* When the first key of all is, if before `begin`, and the last. */
static void extend_span(const sn_joint *joint, double *begin, double *end) {
    bool hinge = joint->kind == SN_JOINT_HINGE;
    sn_index count = hinge ? joint->angle.count : joint->key_count;
    if (count == 0) return;
    *begin = fmin(*begin, hinge ? joint->angle.times[0] : joint->keys[0].time);
    *end = fmax(*end, hinge ? joint->angle.times[count - 1] : joint->keys[count - 1].time);
}

static sn_status fill_joint(const sn_joint *from, sn_clip_joint *to, sn_error *error) {
    to->parent = from->parent;
    to->placeless = !from->has_rest && from->kind != SN_JOINT_HINGE;
    to->rest = from->has_rest ? from->rest : from->kind == SN_JOINT_HINGE ? from->point : sn_v3(0, 0, 0);
    if (from->has_rest) to->rest_rotation = from->rest_rotation;
    to->has_end = from->has_end;
    to->end = from->end;
    to->name = sn_strdup(from->name);
    return to->name != NULL ? SN_OK : sn_fail_memory(error, "a name");
}

static sn_status fill_poses(const sn_motion *motion, double begin, sn_clip *clip, sn_error *error) {
    sn_rigid *poses = SN_NEW(sn_rigid, motion->joint_count);
    if (poses == NULL) return sn_fail_memory(error, "poses");
    for (sn_index f = 0; f < clip->frame_count; f++) {
        sn_motion_poses(motion, begin + f / clip->rate, poses);
        for (sn_index j = 0; j < clip->joint_count; j++) {
            clip->joints[j].poses[f] = poses[j];
            clip->joints[j].poses[f].rotation = sn_quat_normalize(poses[j].rotation);
        }
    }
    free(poses);
    return SN_OK;
}

static sn_status fill_coordinate(const sn_coordinate *from, double begin, const sn_clip *clip, sn_clip_coordinate *to, sn_error *error) {
    to->name = sn_strdup(from->name);
    to->unit = sn_strdup(from->unit);
    for (sn_index f = 0; f < clip->frame_count; f++) to->values[f] = sn_coordinate_at(from, begin + f / clip->rate);
    return to->name != NULL && to->unit != NULL ? SN_OK : sn_fail_memory(error, "a coordinate");
}

/* The time of the first frame; *frames is how many there are. */
static double span_of(const sn_motion *motion, double rate, double *frames) {
    double begin = 0.0, end = 0.0;
    for (sn_index j = 0; j < motion->joint_count; j++) extend_span(&motion->joints[j], &begin, &end);
    *frames = floor((end - begin) * rate + 1e-6) + 1.0; /* times are multiples of 1/rate only to rounding */
    return begin;
}

double sn_clip_frames_of(const sn_motion *motion, double rate) {
    double frames;
    span_of(motion, rate, &frames);
    return frames;
}

sn_status sn_clip_from_motion(const sn_motion *motion, double rate, sn_clip *out, sn_error *error) {
    double frames, begin = span_of(motion, rate, &frames);
    *out = (sn_clip){0};
    if (!(frames < SN_INDEX_MAX / 2)) return sn_fail(error, SN_ERROR_INPUT, "the motion is too long to sample at %g Hz", rate);
    sn_status status = sn_clip_create((sn_index)frames, motion->joint_count, motion->coordinate_count, out, error);
    out->rate = rate;
    out->begin = begin;
    for (sn_index j = 0; j < motion->joint_count && status == SN_OK; j++) status = fill_joint(&motion->joints[j], &out->joints[j], error);
    for (sn_index c = 0; c < motion->coordinate_count && status == SN_OK; c++)
        status = fill_coordinate(&motion->coordinates[c], begin, out, &out->coordinates[c], error);
    if (status == SN_OK) status = fill_poses(motion, begin, out, error);
    if (status == SN_OK) status = copy_bones(motion->bones, motion->bone_count, &out->bones, &out->bone_count, error);
    if (status != SN_OK) sn_clip_free(out);
    return status;
}
