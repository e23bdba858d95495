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

#endif
