/*
 * pose.c -- the pose of one joint in its parent's frame: a hinge's turn, or the place between two key poses.
 */
#include "interpolate.h"

/* Turn by `angle` about the axis through the joint's point c: p -> R (p - c) + c. */
static sn_rigid hinge_pose(const sn_joint *joint, double angle) {
    sn_quat rotation = sn_quat_axis_angle(joint->axis, angle);
    return (sn_rigid){rotation, sn_sub(joint->point, sn_quat_rotate(rotation, joint->point))};
}

/* Between two keys of a joint whose centre is known it is the centre that moves along a straight line: one that only turns stays in its
 * socket, where a translation interpolated by itself would leave it on the way. */
static sn_rigid between_about_rest(const sn_joint *joint, const sn_rigid *a, const sn_rigid *b, double t) {
    sn_vec3 centre = sn_lerp(sn_rigid_apply(*a, joint->rest), sn_rigid_apply(*b, joint->rest), t);
    sn_quat rotation = sn_quat_slerp(a->rotation, b->rotation, t);
    return (sn_rigid){rotation, sn_sub(centre, sn_quat_rotate(rotation, joint->rest))};
}

static sn_rigid keyed_pose(const sn_joint *joint, double time) {
    if (joint->key_count <= 0) return sn_rigid_identity();
    sn_index last = joint->key_count - 1;
    if (!(time > joint->keys[0].time)) return joint->keys[0].pose;
    if (time >= joint->keys[last].time) return joint->keys[last].pose;
    sn_index low = 0;
    for (sn_index high = last; high - low > 1;) {
        sn_index middle = low + (high - low) / 2;
        if (joint->keys[middle].time <= time)
            low = middle;
        else
            high = middle;
    }
    const sn_pose_key *a = &joint->keys[low], *b = &joint->keys[low + 1];
    double t = sn_ease(joint->interpolation, a->time, b->time, time);
    if (joint->has_rest) return between_about_rest(joint, &a->pose, &b->pose, t);
    return (sn_rigid){sn_quat_slerp(a->pose.rotation, b->pose.rotation, t), sn_lerp(a->pose.translation, b->pose.translation, t)};
}

sn_rigid sn_joint_pose(const sn_joint *joint, double time) {
    return joint->kind == SN_JOINT_HINGE ? hinge_pose(joint, sn_channel_at(&joint->angle, time)) : keyed_pose(joint, time);
}
