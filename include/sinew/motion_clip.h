/*
 * motion_clip.h -- a motion as a file holds it: joints and their poses, frame by frame.   rank 2
 *
 * What every reader of motions fills. Lengths are metres, angles radians. A motion document is written from it.
 */
#ifndef SINEW_MOTION_CLIP_H
#define SINEW_MOTION_CLIP_H

#include "sinew/motion.h"

/* A coordinate over time: a hinge's angle, a slider's way. */
typedef struct sn_clip_coordinate {
    char *name;     /* no two alike */
    char *unit;     /* "rad", "m" */
    double *values; /* (frame_count) */
} sn_clip_coordinate;

typedef struct sn_clip_joint {
    char *name;
    sn_index parent;       /* SN_NONE = the world */
    sn_vec3 rest;          /* joint centre in the rest pose, world */
    sn_quat rest_rotation; /* world */
    sn_rigid *poses;       /* (frame_count) world pose away from rest: the identity at rest */
} sn_clip_joint;

typedef struct sn_clip {
    char *name;
    double rate; /* frames a second */
    sn_index frame_count, joint_count;
    sn_clip_joint *joints; /* (joint_count) parents before children; owned, with all that is in them */
    sn_index coordinate_count;
    sn_clip_coordinate *coordinates; /* (coordinate_count) owned */
} sn_clip;

/* Every array, poses the identity, names NULL, parents SN_NONE; the caller fills it. *out is empty on failure. */
SN_MUST_CHECK sn_status sn_clip_create(sn_index frame_count, sn_index joint_count, sn_index coordinate_count, sn_clip *out,
                                       sn_error *error);
void sn_clip_free(sn_clip *clip); /* leaves all zeros */

#endif
