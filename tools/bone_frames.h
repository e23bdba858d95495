/*
 * bone_frames.h -- simulate --bone-frames: the bones' surfaces where the motion takes them, frame by frame, beside the muscles.
 *
 * Absent unless it is asked for: then bone_frames_open leaves the run empty and every other call returns at once.
 */
#ifndef SINEW_TOOLS_BONE_FRAMES_H
#define SINEW_TOOLS_BONE_FRAMES_H

#include "cli.h"
#include "frame_files.h"
#include "sinew/sim.h"

typedef struct bone_request {
    const char *path;   /* a folder: BONE.pc2 for each, or BONE.0000.ply; "NAME.pvd": all bones in NAME.0000.vtp; NULL = nobody asks */
    bool ply;           /* of a folder */
    const char *output; /* where the muscles' frames go; nullable */
    frame_range range;
    sn_resume *resume;  /* nullable: go on with what is there */
    const sn_state *at; /* with it: the state */
} bone_request;

/* One bone's surface. */
typedef struct bone_target {
    sn_mesh mesh; /* as posed; of a cache its positions alone */
    char *path;   /* of the cache, or of a sequence without its number */
    sn_pc2 *cache;
} bone_target;

typedef struct bone_run {
    const sn_scene *scene;
    sn_index substeps;
    sn_index continued;   /* targets that are gone on with */
    bone_target *targets; /* (scene.bone_count); NULL = none */
    sn_rigid *poses;      /* (joint_count) */
    sn_mesh_frames *frames;
    sn_mesh all; /* with `frames`: all bones, in units of: */
    double meters_per_unit;
} bone_run;

/* The scene's bones are loaded. Wrong usage exits; two bones, or a bone and a muscle, that would share a file are an error. */
SN_MUST_CHECK sn_status bone_frames_open(bone_run *run, const cli *c, const bone_request *request, const sn_scene *scene, sn_error *error);
/* The bones at the moment of a state. */
SN_MUST_CHECK sn_status bone_frames_write(bone_run *run, const sn_state *state, sn_error *error);
SN_MUST_CHECK sn_status bone_frames_commit(bone_run *run, sn_error *error);
void bone_frames_free(bone_run *run);

#endif
