/*
 * interpolate.h -- where a time lies between two keys; the pose of one joint.
 */
#ifndef SN_MOTION_INTERPOLATE_H
#define SN_MOTION_INTERPOLATE_H

#include "sinew/motion.h"

/* Share of the way from key time `begin` to `end` (end > begin) at `time`: 0..1, eased by smoothstep 3t^2 - 2t^3 where asked for. */
static inline double sn_ease(sn_interpolation interpolation, double begin, double end, double time) {
    double t = (time - begin) / (end - begin);
    return interpolation == SN_INTERPOLATE_SMOOTH ? t * t * (3.0 - 2.0 * t) : t;
}

/* Pose of one joint relative to its parent (pose.c). */
sn_rigid sn_joint_pose(const sn_joint *joint, double time);

#endif
