/*
 * motion.c -- world poses of a joint tree, its checks, its end.
 */
#include "sinew/motion.h"

#include <stdlib.h>
#include <string.h>

#include "interpolate.h"

/* How far from 1 the length of a hinge axis or of a key's quaternion may be. */
static const double UNIT_TOLERANCE = 1e-6;

sn_rigid sn_motion_pose(const sn_motion *motion, sn_index joint, double time) {
    sn_rigid pose = sn_joint_pose(&motion->joints[joint], time);
    for (sn_index j = motion->joints[joint].parent; j != SN_NONE; j = motion->joints[j].parent)
        pose = sn_rigid_compose(sn_joint_pose(&motion->joints[j], time), pose);
    return pose;
}

void sn_motion_poses(const sn_motion *motion, double time, sn_rigid *poses) {
    for (sn_index j = 0; j < motion->joint_count; j++) {
        const sn_joint *joint = &motion->joints[j];
        sn_rigid local = sn_joint_pose(joint, time);
        poses[j] = joint->parent == SN_NONE ? local : sn_rigid_compose(poses[joint->parent], local);
    }
}

double sn_coordinate_at(const sn_coordinate *coordinate, double time) {
    if (coordinate->count <= 0) return 0.0;
    double last = (double)coordinate->count - 1.0, at = fmin(fmax(time * coordinate->rate, 0.0), last),
           low = fmin(floor(at), fmax(last - 1.0, 0.0));
    sn_index k = (sn_index)low;
    if (last == 0.0 || at == low) return coordinate->values[k];
    return at == low + 1.0 ? coordinate->values[k + 1]
                           : coordinate->values[k] + (at - low) * (coordinate->values[k + 1] - coordinate->values[k]);
}

static const char *joint_name(const sn_joint *joint) { return joint->name != NULL ? joint->name : "(unnamed)"; }

static sn_status check_angle(const sn_joint *joint, sn_error *error) {
    const sn_channel *angle = &joint->angle;
    const char *name = joint_name(joint);
    if (!isfinite(angle->constant)) return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its angle is not finite", name);
    for (sn_index i = 0; i < angle->count; i++) {
        if (!isfinite(angle->times[i]) || !isfinite(angle->values[i]))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": key %d of its angle is not finite", name, (int)i);
        if (i > 0 && !(angle->times[i] > angle->times[i - 1]))
            return sn_fail(error, SN_ERROR_INPUT,
                           "joint \"%s\": key %d of its angle is not later than the key before it; sort the keys by time", name, (int)i);
    }
    return SN_OK;
}

static sn_status check_hinge(const sn_joint *joint, sn_error *error) {
    const char *name = joint_name(joint);
    if (!sn_finite3(joint->axis) || !(fabs(sn_norm(joint->axis) - 1.0) <= UNIT_TOLERANCE))
        return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": the axis of a hinge must be a unit vector", name);
    if (!sn_finite3(joint->point)) return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": the hinge's point is not finite", name);
    return check_angle(joint, error);
}

static sn_status check_keys(const sn_joint *joint, sn_error *error) {
    const char *name = joint_name(joint);
    for (sn_index i = 0; i < joint->key_count; i++) {
        const sn_pose_key *key = &joint->keys[i];
        double length = sqrt(sn_quat_dot(key->pose.rotation, key->pose.rotation));
        if (!isfinite(key->time) || !sn_finite3(key->pose.translation))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": key %d is not finite", name, (int)i);
        if (!(fabs(length - 1.0) <= UNIT_TOLERANCE))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": the rotation of key %d must be a unit quaternion (its length is %g)", name,
                           (int)i, length);
        if (i > 0 && !(key->time > joint->keys[i - 1].time))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": key %d is not later than the key before it; sort the keys by time", name,
                           (int)i);
    }
    return SN_OK;
}

static int compare_names(const void *a, const void *b) { return strcmp(*(const char *const *)a, *(const char *const *)b); }

/* A table of them has a column for each. */
static sn_status check_coordinate_names(const sn_motion *motion, sn_error *error) {
    const char **names = SN_NEW(const char *, motion->coordinate_count), *twice = NULL;
    if (names == NULL) return sn_fail_memory(error, "the coordinates");
    for (sn_index c = 0; c < motion->coordinate_count; c++) names[c] = motion->coordinates[c].name;
    qsort(names, (size_t)motion->coordinate_count, sizeof *names, compare_names);
    for (sn_index c = 1; c < motion->coordinate_count && twice == NULL; c++)
        if (strcmp(names[c], names[c - 1]) == 0) twice = names[c];
    free(names);
    return twice == NULL ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "two coordinates have the name \"%.100s\"; give one another name", twice);
}

static sn_status check_coordinates(const sn_motion *motion, sn_error *error) {
    for (sn_index c = 0; c < motion->coordinate_count; c++) {
        const sn_coordinate *coordinate = &motion->coordinates[c];
        if (coordinate->name == NULL || coordinate->unit == NULL || !(coordinate->rate > 0.0))
            return sn_fail(error, SN_ERROR_INPUT, "coordinate %d has no name, no unit or no rate", c + 1);
        for (sn_index k = 0; k < coordinate->count; k++)
            if (!isfinite(coordinate->values[k]))
                return sn_fail(error, SN_ERROR_INPUT, "coordinate \"%s\": sample %d is not finite", coordinate->name, k);
    }
    return check_coordinate_names(motion, error);
}

static sn_status check_bones(const sn_motion *motion, sn_error *error) {
    for (sn_index b = 0; b < motion->bone_count; b++) {
        const sn_motion_bone *bone = &motion->bones[b];
        if (bone->name == NULL || bone->path == NULL) return sn_fail(error, SN_ERROR_INPUT, "bone %d has no name or no mesh", b + 1);
        if (bone->joint != SN_NONE && (bone->joint < 0 || bone->joint >= motion->joint_count))
            return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\" is on joint %d; there are %d", bone->name, bone->joint + 1,
                           motion->joint_count);
    }
    return SN_OK;
}

sn_status sn_motion_validate(const sn_motion *motion, sn_error *error) {
    for (sn_index j = 0; j < motion->joint_count; j++) {
        const sn_joint *joint = &motion->joints[j];
        if (joint->parent != SN_NONE && (joint->parent < 0 || joint->parent >= j))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its parent must come before it", joint_name(joint));
        sn_status status = joint->kind == SN_JOINT_HINGE ? check_hinge(joint, error) : check_keys(joint, error);
        if (status != SN_OK) return status;
        if (joint->has_rest && !sn_finite3(joint->rest))
            return sn_fail(error, SN_ERROR_INPUT, "joint \"%s\": its rest place is not finite", joint_name(joint));
    }
    sn_status status = check_coordinates(motion, error);
    return status == SN_OK ? check_bones(motion, error) : status;
}

sn_motion_bone *sn_motion_bones_copy(const sn_motion_bone *bones, sn_index count) {
    sn_motion_bone *copy = count > 0 ? SN_NEW(sn_motion_bone, count) : NULL;
    for (sn_index b = 0; copy != NULL && b < count; b++) {
        copy[b] = bones[b];
        copy[b].name = sn_strdup(bones[b].name);
        copy[b].path = sn_strdup(bones[b].path);
        if (copy[b].name != NULL && copy[b].path != NULL) continue;
        sn_motion_bones_free(copy, b + 1);
        return NULL;
    }
    return copy;
}

void sn_motion_bones_free(sn_motion_bone *bones, sn_index count) {
    for (sn_index b = 0; b < count; b++) {
        free(bones[b].name);
        free(bones[b].path);
    }
    free(bones);
}

void sn_motion_free(sn_motion *motion) {
    if (motion == NULL) return;
    for (sn_index j = 0; j < motion->joint_count; j++) {
        free(motion->joints[j].name);
        sn_channel_free(&motion->joints[j].angle);
        free(motion->joints[j].keys);
    }
    for (sn_index c = 0; c < motion->coordinate_count; c++) {
        free(motion->coordinates[c].name);
        free(motion->coordinates[c].unit);
        free(motion->coordinates[c].values);
    }
    sn_motion_bones_free(motion->bones, motion->bone_count);
    free(motion->joints);
    free(motion->coordinates);
    *motion = (sn_motion){0};
}
