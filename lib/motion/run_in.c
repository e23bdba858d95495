/*
 * run_in.c -- from the rest pose to a pose of the motion: the way that bones take before a simulation's first frame.
 *
 * Down the tree, each joint by its own: a hinge by a share of its angle; a joint whose centre is known turns about it by slerp while the
 * centre goes straight; any other goes along the screw that its pose is (Chasles), on which the centre of a mere turn stays where it is. So
 * joints that hold together at both ends do so on the way.
 */
#include "interpolate.h"

#include "sinew/exact.h"
#include "sinew/scene.h"

/* Below this sine of half the angle a turn has no axis that could be trusted: what is left is a shift. */
static const double LEAST_TURN = 1e-7;

static sn_rigid about(sn_vec3 centre, sn_vec3 moved, sn_quat rotation) {
    return (sn_rigid){rotation, sn_sub(moved, sn_quat_rotate(rotation, centre))};
}

/* A share of the screw that takes rest to pose: with the axis u through c, the angle a and the way d along it, the turn by share x a about
 * the same axis and share x d. c is where the axis is nearest to the origin: (t' + cot(a/2) u x t') / 2, t' the translation across u. */
static sn_rigid along_screw(sn_rigid pose, double share) {
    sn_quat q = pose.rotation;
    if (q.w < 0.0) q = (sn_quat){-q.w, -q.x, -q.y, -q.z};
    sn_vec3 v = sn_v3(q.x, q.y, q.z);
    double sine = sn_norm(v);
    if (!(sine > LEAST_TURN)) return (sn_rigid){sn_quat_slerp(sn_quat_identity(), q, share), sn_scale(pose.translation, share)};
    sn_vec3 u = sn_scale(v, 1.0 / sine);
    double way = sn_dot(pose.translation, u), angle = 2.0 * sn_atan2(sine, q.w);
    sn_vec3 across = sn_add_scaled(pose.translation, u, -way);
    sn_vec3 centre = sn_scale(sn_add_scaled(across, sn_cross(u, across), q.w / sine), 0.5);
    return about(centre, sn_add_scaled(centre, u, share * way), sn_quat_axis_angle(u, share * angle));
}

/* In the parent's frame. */
static sn_rigid local_pose(const sn_joint *joint, double time, double share) {
    if (joint->kind == SN_JOINT_HINGE)
        return about(joint->point, joint->point, sn_quat_axis_angle(joint->axis, share * sn_channel_at(&joint->angle, time)));
    sn_rigid pose = sn_joint_pose(joint, time);
    if (!joint->has_rest) return along_screw(pose, share);
    sn_vec3 centre = sn_lerp(joint->rest, sn_rigid_apply(pose, joint->rest), share);
    return about(joint->rest, centre, sn_quat_slerp(sn_quat_identity(), pose.rotation, share));
}

sn_rigid sn_motion_run_in_pose(const sn_motion *motion, sn_index joint, double time, double share) {
    if (share >= 1.0) return sn_motion_pose(motion, joint, time);
    if (!(share > 0.0)) return sn_rigid_identity();
    sn_rigid pose = local_pose(&motion->joints[joint], time, share);
    for (sn_index j = motion->joints[joint].parent; j != SN_NONE; j = motion->joints[j].parent)
        pose = sn_rigid_compose(local_pose(&motion->joints[j], time, share), pose);
    return pose;
}

void sn_motion_run_in_poses(const sn_motion *motion, double time, double share, sn_rigid *poses) {
    if (share >= 1.0) {
        sn_motion_poses(motion, time, poses);
        return;
    }
    for (sn_index j = 0; j < motion->joint_count; j++) {
        sn_index parent = motion->joints[j].parent;
        sn_rigid local = share > 0.0 ? local_pose(&motion->joints[j], time, share) : sn_rigid_identity();
        poses[j] = parent == SN_NONE ? local : sn_rigid_compose(poses[parent], local);
    }
}

static bool is_rest(sn_rigid pose) {
    return fabs(pose.rotation.w) == 1.0 && pose.translation.x == 0.0 && pose.translation.y == 0.0 && pose.translation.z == 0.0;
}

bool sn_scene_runs_in(const sn_scene *scene) {
    double time = scene->first_frame / scene->rate;
    if (!(scene->run_in > 0.0)) return false;
    for (sn_index i = 0; i < scene->surface_count; i++)
        if (scene->surfaces[i].loaded && scene->surfaces[i].kind == SN_SURFACE_DRIVEN) return true;
    for (sn_index j = 0; j < scene->motion.joint_count; j++)
        if (!is_rest(sn_joint_pose(&scene->motion.joints[j], time))) return true;
    return false;
}
