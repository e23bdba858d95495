/*
 * skeleton.h -- bodies on joints with coordinates: the models that OpenSim and MuJoCo write.   rank 2
 *
 * A body's frame is its parent's frame after a row of moves, the first one outermost: fixed ones, and turns and shifts by functions of the
 * model's coordinates. So every kind of joint is the same data: a pin is one turn about z; OpenSim's CustomJoint three shifts and three
 * turns; MuJoCo's hinge a turn about a line. Lengths are metres, angles radians.
 */
#ifndef SINEW_SKELETON_H
#define SINEW_SKELETON_H

#include "sinew/motion_clip.h"

/* ---- functions of one variable (lib/motion/function.c) ------------------------------------------------------------------------- */

typedef enum sn_function_kind {
    SN_FUNCTION_POLYNOMIAL, /* y_0 t^(n-1) + ... + y_(n-1): constants and lines too */
    SN_FUNCTION_LINES,      /* straight between the knots, and on outside of them: OpenSim's PiecewiseLinearFunction */
    SN_FUNCTION_SPLINE      /* cubic through the knots, straight outside of them: OpenSim's SimmSpline */
} sn_function_kind;
typedef struct sn_function sn_function;
typedef struct sn_function_numbers {
    sn_index count;  /* >= 1; >= 2 with knots */
    const double *x; /* (count) ascending, finite; not read for a polynomial */
    const double *y; /* (count) finite */
} sn_function_numbers;
/* Numbers are copied. The value is multiplied by scale. The spline is Forsythe, Malcolm and Moler's (1977): its third derivative at each
 * end is that of the cubic through the four points there; three points give a parabola, two a line. */
SN_MUST_CHECK sn_status sn_function_create(sn_function_kind kind, sn_function_numbers numbers, double scale, sn_function **out,
                                           sn_error *error);
double sn_function_at(const sn_function *function, double t);
bool sn_function_constant(const sn_function *function); /* the same value everywhere, by its form */
bool sn_function_identity(const sn_function *function); /* t itself, but for a constant added */
void sn_function_free(sn_function *function);           /* NULL is fine */

/* ---- the skeleton (lib/motion/skeleton.c) ---------------------------------------------------------------------------------------- */

typedef enum sn_move_kind {
    SN_MOVE_FIXED,
    SN_MOVE_TURN,  /* about axis, by the function of the first coordinate */
    SN_MOVE_SHIFT, /* along axis, by the same */
    SN_MOVE_SPIN   /* by the rotation vector of three coordinates */
} sn_move_kind;

typedef struct sn_move {
    sn_move_kind kind;
    bool inverse;            /* the other way round: of a joint that is gone through from its child */
    sn_rigid fixed;          /* FIXED */
    sn_vec3 axis;            /* TURN, SHIFT: unit */
    sn_index coordinates[3]; /* TURN, SHIFT: the first */
    sn_function *function;   /* TURN, SHIFT: owned; NULL = the coordinate itself */
} sn_move;

typedef struct sn_skeleton_body {
    char *name;
    sn_index parent; /* SN_NONE = the world */
    sn_vec3 centre;  /* where its joint's centre is, in its own frame */
    sn_index move_count;
    sn_move *moves; /* (move_count) owned */
} sn_skeleton_body;

typedef struct sn_skeleton_coordinate {
    char *name, *joint; /* joint: the one it belongs to; NULL = none is known */
    bool angular;       /* an angle: its unit is the radian */
    bool degrees;       /* a motion file "in degrees" holds it in degrees. Not so for OpenSim's coupled coordinates */
    bool locked;        /* stays at rest */
    bool clamped;       /* is kept within low and high */
    double rest, low, high;
} sn_skeleton_coordinate;

/* dependent = function(independent), whatever a motion says. */
typedef struct sn_skeleton_coupler {
    sn_index dependent, independent;
    sn_function *function; /* owned */
} sn_skeleton_coupler;

/* A mesh file that shows a body: a vertex p of the file is frame(scale * p) in the body's frame. */
typedef struct sn_skeleton_mesh {
    sn_index body; /* SN_NONE = the world */
    char *name, *file;
    sn_vec3 scale;
    sn_rigid frame;
} sn_skeleton_mesh;

typedef struct sn_skeleton {
    char *name;
    bool up_y; /* y is up (OpenSim); else z (MuJoCo) */
    sn_index body_count, coordinate_count, coupler_count, mesh_count;
    sn_skeleton_body *bodies; /* parents before children; all owned */
    sn_skeleton_coordinate *coordinates;
    sn_skeleton_coupler *couplers; /* what one depends on comes before it */
    sn_skeleton_mesh *meshes;
} sn_skeleton;

/* Add a move at the end; owns its function, also where this fails. */
SN_MUST_CHECK sn_status sn_skeleton_add_move(sn_skeleton_body *body, sn_move move, sn_error *error);
/* The moves first .. end - 1 the other way round. */
void sn_skeleton_reverse_moves(sn_skeleton_body *body, sn_index first, sn_index end);
/* Put couplers in order, and check that bodies and coordinates are named, each name once (of coordinates: in its joint), parents come
 * before children, and all numbers are finite. SN_ERROR_INPUT names what is wrong. */
SN_MUST_CHECK sn_status sn_skeleton_finish(sn_skeleton *skeleton, sn_error *error);
/* The coordinate that a column of a motion speaks of: by its name, or by its path ".../JOINT/COORDINATE/value"; SN_NONE = none. */
sn_index sn_skeleton_find_coordinate(const sn_skeleton *skeleton, const char *column);
/* Coordinates at rest: values (coordinate_count), within their limits, coupled. */
void sn_skeleton_rest(const sn_skeleton *skeleton, double *values);
/* Set what couplers determine. */
void sn_skeleton_couple(const sn_skeleton *skeleton, double *values);
/* World frame of every body: frames (body_count). */
void sn_skeleton_frames(const sn_skeleton *skeleton, const double *values, sn_rigid *frames);
void sn_skeleton_free_body(sn_skeleton_body *body); /* leaves all zeros */
void sn_skeleton_free(sn_skeleton *skeleton);       /* the same */

/* ---- numbers over time, and what a skeleton makes of them (lib/motion/animate.c) --------------------------------------------------- */

typedef struct sn_columns {
    char *name;                     /* of the file, for messages */
    bool degrees;                   /* angles are in degrees */
    bool degrees_told;              /* the file says whether they are */
    int64_t names_line, first_line; /* of the file: where the names and row 0 are; 0 = not known */
    sn_index row_count, column_count;
    char **names;   /* (column_count) without the time */
    double *times;  /* (row_count) ascending, seconds */
    double *values; /* (row_count x column_count) */
} sn_columns;
void sn_columns_free(sn_columns *columns); /* leaves all zeros */

/* The motion of a skeleton: a clip's joint for each body, its coordinates beside them. The rest pose is that of the coordinates at rest.
 * Coordinates that no column names stay at rest; columns that name none are left out, said by one warning. Times that are even to 5 % of
 * a step are taken as even; others are resampled to their mean rate by straight lines between the rows, said by a warning. A clip begins
 * at its first row, whatever its time. columns NULL: one frame, at rest. */
SN_MUST_CHECK sn_status sn_skeleton_animate(const sn_skeleton *skeleton, const sn_columns *columns, sn_clip *out, sn_error *error);

#endif
