/*
 * motion.h -- key frames and joints; bone poses over time; keyed channels.   rank 2
 *
 * A pose is the rigid motion of a bone away from its rest place. Lengths are metres, angles radians, times seconds.
 */
#ifndef SINEW_MOTION_H
#define SINEW_MOTION_H

#include "sinew/vec.h"

typedef enum sn_interpolation { SN_INTERPOLATE_LINEAR, SN_INTERPOLATE_SMOOTH } sn_interpolation; /* smooth: smoothstep between keys */

extern const char *const sn_interpolation_names[]; /* "linear", "smooth"; NULL at the end */

/* A scalar over time: keys in ascending time; outside them the end values hold. count 0 = the constant `constant`. */
typedef struct sn_channel {
    double constant;
    sn_index count;
    double *times, *values; /* (count) owned */
    sn_interpolation interpolation;
} sn_channel;

typedef enum sn_joint_kind { SN_JOINT_HINGE, SN_JOINT_POSE } sn_joint_kind;

typedef struct sn_pose_key {
    double time;
    sn_rigid pose;
} sn_pose_key;

/* A joint moves the bones bound to it, and its child joints. HINGE: turn by `angle` about the axis through point; POSE: keys. */
typedef struct sn_joint {
    char *name;
    sn_index parent; /* SN_NONE = the world */
    sn_joint_kind kind;
    sn_vec3 axis, point; /* HINGE: unit axis; in the rest pose's world frame */
    sn_channel angle;    /* HINGE: radians */
    sn_index key_count;  /* POSE: slerp and linear between keys (relative to the rest pose, in the parent's frame) */
    sn_pose_key *keys;   /* (key_count) owned */
    sn_interpolation interpolation;
    /* What an imported motion tells beside. Between keys it is the centre `rest` that moves linearly; else nothing depends on these. */
    bool has_rest, has_end;
    sn_vec3 rest;          /* has_rest: place of the joint's centre in the rest pose, world */
    sn_quat rest_rotation; /* has_rest: of the joint's frame in the rest pose, world */
    sn_vec3 end;           /* has_end: end of the segment in the rest pose, world */
} sn_joint;

/* A coordinate by which the source of a motion tells its joints: a hinge's angle, a channel. Sample k is at k / rate. */
typedef struct sn_coordinate {
    char *name;  /* owned */
    char *unit;  /* owned: "rad", "m" or "" */
    double rate; /* samples a second */
    sn_index count;
    double *values; /* (count) owned */
} sn_coordinate;

/* A bone that an importer or a fit has bound to a joint. Its surface is in the rest pose, in the world; nothing here reads it. */
typedef struct sn_motion_bone {
    char *name;             /* owned */
    char *path;             /* owned: of the mesh; where it is relative, from the working directory */
    double meters_per_unit; /* of the mesh, where its file does not say; 0 = not told */
    sn_index joint;         /* SN_NONE = never moves */
} sn_motion_bone;

typedef struct sn_motion {
    sn_index joint_count;
    sn_joint *joints; /* (joint_count) parents before children; owned */
    sn_index coordinate_count;
    sn_coordinate *coordinates; /* (coordinate_count) owned */
    sn_index bone_count;
    sn_motion_bone *bones; /* (bone_count) owned */
} sn_motion;

double sn_channel_at(const sn_channel *channel, double time);
/* World pose of one joint at `time`, where others are not wanted; to rounding that of sn_motion_poses. */
sn_rigid sn_motion_pose(const sn_motion *motion, sn_index joint, double time);
/* World pose of every joint at `time`: poses (joint_count). */
void sn_motion_poses(const sn_motion *motion, double time, sn_rigid *poses);
/* World poses on the way from rest (share 0) to the pose at `time` (share 1, to the bit), which joints take together: a hinge by its angle,
 * a joint with a rest place by slerp about it, any other along the screw of its pose (lib/motion/run_in.c). */
sn_rigid sn_motion_run_in_pose(const sn_motion *motion, sn_index joint, double time, double share);
void sn_motion_run_in_poses(const sn_motion *motion, double time, double share, sn_rigid *poses); /* poses (joint_count) */
/* Linear between samples; outside them the end values hold; 0 where there is none. */
double sn_coordinate_at(const sn_coordinate *coordinate, double time);
SN_MUST_CHECK sn_status sn_motion_validate(const sn_motion *motion, sn_error *error);
void sn_channel_free(sn_channel *channel);
void sn_motion_free(sn_motion *motion);
/* NULL: there is not enough memory, or there are none. */
sn_motion_bone *sn_motion_bones_copy(const sn_motion_bone *bones, sn_index count);
void sn_motion_bones_free(sn_motion_bone *bones, sn_index count);

#endif
