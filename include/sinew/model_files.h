/*
 * model_files.h -- models of bodies on joints, and the numbers that move them, out of files.   rank 3
 */
#ifndef SINEW_MODEL_FILES_H
#define SINEW_MODEL_FILES_H

#include "sinew/io.h"
#include "sinew/skeleton.h"

/*
 * OpenSim's models (lib/io/osim.c, osim_joint.c, osim_function.c), documents of version 3 and 4: bodies; joints of kind Pin, Slider, Weld,
 * Ball, Free, Universal, Gimbal, Planar and Custom with functions Constant, LinearFunction, PolynomialFunction, SimmSpline,
 * PiecewiseLinearFunction and MultiplierFunction; offset frames; coordinates; couplers; meshes. Other joints and functions are refused. A
 * coordinate is an angle where the file says rotational or, in version 4, where it turns about an axis as it is. A body on no joint is put
 * on the ground, said by a warning. Errors name the line.
 */
bool sn_osim_detect(const sn_blob *blob);
SN_MUST_CHECK sn_status sn_osim_parse(const sn_blob *blob, sn_skeleton *out, sn_error *error);

/*
 * MuJoCo's models (lib/io/mjcf.c): the tree of bodies, joints (hinge, slide, ball, free), frames, default classes, angles and orientations
 * as the compiler section says, geoms that are meshes. Files to include are not read, said by a warning. A coordinate has its joint's name;
 * a ball joint has three, NAME_rx, NAME_ry, NAME_rz: its rotation vector away from rest; a free joint also NAME_tx, NAME_ty, NAME_tz: how
 * far the body has gone from its place, in the world's axes. Lengths are taken as metres.
 */
bool sn_mjcf_detect(const sn_blob *blob);
SN_MUST_CHECK sn_status sn_mjcf_parse(const sn_blob *blob, sn_skeleton *out, sn_error *error);

/*
 * OpenSim's motion and storage files (lib/io/storage.c): a header up to "endheader" (nRows and nColumns are checked, inDegrees; SIMM's
 * datarows and datacolumns too), names, rows. The first column is the time. Numbers may be NaN until they are used. Errors name the line.
 */
bool sn_storage_detect(const sn_blob *blob);
SN_MUST_CHECK sn_status sn_storage_parse(const sn_blob *blob, sn_columns *out, sn_error *error);

/*
 * The mesh files that show a model's bodies (lib/io/model_bones.c), for the rest pose that sn_clip_parse makes of it. A file is looked for
 * in the folders given, beside the model, and in Geometry beside it, each by the model's path and then by the name alone. A bone is called
 * by its file (OpenSim) or its geom (MuJoCo), with _2, _3, ... where that is taken. The same file twice at the same place is one bone.
 */
typedef struct sn_model_bone {
    char *name;     /* owned; no two alike, fit to name a file */
    char *path;     /* owned: of the mesh file, which is there */
    sn_index joint; /* of the clip; SN_NONE = on the ground */
    sn_vec3 scale;  /* a vertex p of the file is frame(scale * p) in the model's world at rest, in its unit and axes */
    sn_rigid frame;
} sn_model_bone;

typedef struct sn_model_bones {
    sn_index count, missing;
    sn_model_bone *bones; /* (count) in the order of the model */
    char *first_missing;  /* owned; NULL = none is */
    double meters_per_unit;
    bool up_y;
} sn_model_bones;

/* For sn_clip_options: find them while the model is read. Files that are not there are left out, said by one warning; SN_ERROR_INPUT where
 * all are, where the model names none, and of a motion without a model. */
typedef struct sn_bone_search {
    const char *const *folders; /* (folder_count) */
    int folder_count;
    sn_model_bones *found; /* free with sn_model_bones_free, also on failure */
} sn_bone_search;

/* The mesh of one, in the rest pose: metres, z up, vertices in the file's order, no attributes. */
SN_MUST_CHECK sn_status sn_model_bones_load(const sn_model_bones *bones, sn_index index, sn_mesh *out, sn_error *error);
void sn_model_bones_free(sn_model_bones *bones); /* leaves all zeros */

#endif
