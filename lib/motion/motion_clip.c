/* motion_clip.c -- a clip's beginning and end. */
#include "sinew/motion_clip.h"

#include <stdlib.h>

static bool allocate(sn_clip *clip) {
    size_t frames = (size_t)clip->frame_count;
    if ((clip->joints = SN_NEW(sn_clip_joint, clip->joint_count)) == NULL) return false;
    if ((clip->coordinates = SN_NEW(sn_clip_coordinate, clip->coordinate_count)) == NULL) return false;
    for (sn_index i = 0; i < clip->joint_count; i++) {
        sn_clip_joint *joint = &clip->joints[i];
        joint->parent = SN_NONE;
        joint->rest_rotation = sn_quat_identity();
        if ((joint->poses = SN_NEW(sn_rigid, frames)) == NULL) return false;
        for (size_t k = 0; k < frames; k++) joint->poses[k] = sn_rigid_identity();
    }
    for (sn_index i = 0; i < clip->coordinate_count; i++)
        if ((clip->coordinates[i].values = SN_NEW(double, frames)) == NULL) return false;
    return true;
}

sn_status sn_clip_create(sn_index frame_count, sn_index joint_count, sn_index coordinate_count, sn_clip *out, sn_error *error) {
    *out = (sn_clip){.frame_count = frame_count, .joint_count = joint_count, .coordinate_count = coordinate_count};
    if (allocate(out)) return SN_OK;
    sn_clip_free(out);
    return sn_fail_memory(error, "a motion");
}

void sn_clip_free(sn_clip *clip) {
    for (sn_index i = 0; clip->joints != NULL && i < clip->joint_count; i++) {
        free(clip->joints[i].name);
        free(clip->joints[i].poses);
    }
    for (sn_index i = 0; clip->coordinates != NULL && i < clip->coordinate_count; i++) {
        free(clip->coordinates[i].name);
        free(clip->coordinates[i].unit);
        free(clip->coordinates[i].values);
    }
    free(clip->joints);
    free(clip->coordinates);
    free(clip->name);
    *clip = (sn_clip){0};
}
