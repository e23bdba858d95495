/*
 * motion_clip.h -- a motion as it was recorded: a tree of joints, sampled at one rate; filter, resampling, cropping.   rank 2
 *
 * What the readers of motion files fill (sn_clip_parse in io.h) and what a motion document is written from. Lengths are metres, angles
 * radians, times seconds; frame k is at k / rate.
 */
#ifndef SINEW_MOTION_CLIP_H
#define SINEW_MOTION_CLIP_H

#include "sinew/motion.h"
#include "sinew/trace.h"

/* A generalised coordinate of the source: a channel of BVH, a degree of freedom of ASF, a coordinate of OpenSim. It keeps the source's
 * axes, also where the clip has been turned from y up to z up. */
typedef struct sn_clip_coordinate {
    char *name;     /* owned; no two alike */
    char *unit;     /* owned: "rad", "m", or "" = a number without one */
    double *values; /* (frame_count) owned */
} sn_clip_coordinate;

typedef struct sn_clip_joint {
    char *name;            /* owned; no two alike */
    sn_index parent;       /* SN_NONE = the world */
    sn_vec3 rest;          /* place of the joint's centre in the source's rest pose: metres, world */
    sn_quat rest_rotation; /* of the joint's frame in the rest pose, world */
    bool placeless;        /* the source does not tell where the joint is at rest: `rest` is the origin, and means nothing */
    bool has_end;          /* `end`: where the segment ends that has no further joint (End Site, length of a bone), rest pose, world */
    sn_vec3 end;
    sn_rigid *poses; /* (frame_count) owned: world, away from rest: what a bone bound to the joint does, p -> R p + t */
} sn_clip_joint;

/* One of the animations that the source holds. */
typedef struct sn_clip_animation {
    char *name; /* owned; may be empty */
    double seconds;
} sn_clip_animation;

typedef struct sn_clip {
    char *name;         /* owned, nullable */
    const char *format; /* of the source, for messages: "BVH"; not owned */
    double rate;        /* frames a second */
    double begin;       /* seconds: when frame 0 was in the motion that this was sampled from (sn_clip_from_motion); else 0 */
    bool rate_assumed;  /* the source says none */
    sn_index frame_count, joint_count;
    sn_clip_joint *joints; /* (joint_count) parents before children; owned */
    sn_index coordinate_count;
    sn_clip_coordinate *coordinates; /* (coordinate_count) owned */
    sn_index bone_count;
    sn_motion_bone *bones; /* (bone_count) owned */
    sn_index animation_count;
    sn_clip_animation *animations; /* (animation_count) of the source, where it can hold several; owned */
    double meters_per_unit_of_source;
} sn_clip;

/* Every array, poses the identity, names NULL, parents SN_NONE; the caller fills it. *out is empty on failure. */
SN_MUST_CHECK sn_status sn_clip_create(sn_index frame_count, sn_index joint_count, sn_index coordinate_count, sn_clip *out,
                                       sn_error *error);
void sn_clip_free(sn_clip *clip);
/* At least a frame and a joint, parents before children, names there and distinct, all numbers finite, quaternions of length 1. */
SN_MUST_CHECK sn_status sn_clip_validate(const sn_clip *clip, sn_error *error);

/*
 * Poses as their source tells them: `rotation` away from rest in the parent's frame, and in `translation` how far the joint's centre has
 * moved from its rest place in that frame (zero for a joint that only turns). A filter or an interpolation of these two keeps joints
 * together, which one of rigid motions would not. In place; the world poses come back to rounding.
 */
void sn_clip_to_local(sn_clip *clip);
void sn_clip_to_world(sn_clip *clip);
/* The rigid motion p -> R (p - c) + c + d about the joint's rest centre c. */
sn_rigid sn_clip_about(sn_vec3 centre, sn_rigid local);

/* Turn y up to z up: (x, y, z) becomes (x, -z, y), exactly. Coordinates keep their axes. */
void sn_clip_turn_y_up(sn_clip *clip);

/* A joint that turns by more than SN_CLIP_JUMP from one frame to the next, relative to its parent. No recording at a usable rate shows
 * that: an angle has flipped, or takes have been joined. */
#define SN_CLIP_JUMP 2.617993877991494 /* 150 degrees */
typedef struct sn_clip_jump {
    sn_index joint, frame; /* from frame - 1 to frame */
    double angle;
} sn_clip_jump;
/* By frame, then joint; *out is allocated. */
SN_MUST_CHECK sn_status sn_clip_jumps(const sn_clip *clip, sn_clip_jump **out, sn_index *count, sn_error *error);

/*
 * Low-pass without lag: a Butterworth filter of 4th order forwards and backwards (Winter 2009, 2.2.4.4), so that the amplitude at `cutoff`
 * Hz is 1/sqrt 2 after both passes. It goes over rotations (as quaternions on one hemisphere, normalised after), shifts of the joints'
 * centres, and coordinates (angles unwrapped). Beyond its ends a signal goes on as its point reflection, so that they keep their values.
 * What lies between two jumps is filtered by itself. Steps of the trace: "filter", one a joint, then one for the coordinates; where it
 * stops, what follows is left as it was.
 * SN_ERROR_USAGE: the cutoff is not above 0 and below half of the rate.
 */
SN_MUST_CHECK sn_status sn_clip_filter(sn_clip *clip, double cutoff, sn_trace *trace, sn_error *error);

/* At another rate, from the first frame to the last that is not beyond the end: slerp, and linear; next to a jump the nearer frame. */
SN_MUST_CHECK sn_status sn_clip_resample(sn_clip *clip, double rate, sn_error *error);

/* Keep frames first..last, both; SN_ERROR_USAGE where the clip has not got them. */
SN_MUST_CHECK sn_status sn_clip_crop(sn_clip *clip, sn_index first, sn_index last, sn_error *error);

/* As joints of a motion, a key a frame, with rest places and coordinates. */
SN_MUST_CHECK sn_status sn_clip_to_motion(const sn_clip *clip, sn_motion *out, sn_error *error);
/* How many frames that would be: from time 0, or the first key where that is earlier, to the last key. */
double sn_clip_frames_of(const sn_motion *motion, double rate);
/* A motion sampled at `rate` from time 0, or its first key where that is earlier, to its last key. Joints without a
 * rest place have it at a hinge's point, else at the origin. */
SN_MUST_CHECK sn_status sn_clip_from_motion(const sn_motion *motion, double rate, sn_clip *out, sn_error *error);

#endif
