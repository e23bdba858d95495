/*
 * motion_models.c -- models of bodies on joints, and motions of them: OpenSim's documents and motions, MuJoCo's models.
 * Usage: motion_models                           every check; those that need real models find them in DATA, and python3 checks them
 *        motion_models --write MODEL MOTION|- OUT     the motion of a model's bodies as lines of numbers, for tests/model-fk.py
 *
 * Without arguments: each kind of joint and function on a small model of its own, against what it does by its definition; broken files;
 * then gait-opensim, gait1018-opensim and dog-dmcontrol against tests/model-fk.py, which shares no line with the library.
 */
#include "sinew/model_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int passed, failed;
static int warnings;
static char last_warning[1024];

static void check(bool held, const char *what) {
    *(held ? &passed : &failed) += 1;
    if (!held) printf("FAILED: %s\n", what);
}

static void on_log(void *user, sn_log_level level, const char *text) {
    (void)user;
    if (level != SN_LOG_WARNING) return;
    warnings++;
    snprintf(last_warning, sizeof last_warning, "%s", text);
}

/* ---- reading ----------------------------------------------------------------------------------------------------------------------- */

static sn_blob blob_of(char *name, const char *text) {
    return (sn_blob){.name = name, .data = (char *)(uintptr_t)text, .size = strlen(text)};
}

static sn_status parse_model(const sn_blob *blob, sn_skeleton *out, sn_error *error) {
    return sn_mjcf_detect(blob) ? sn_mjcf_parse(blob, out, error) : sn_osim_parse(blob, out, error);
}

/* A model and a motion of it, in memory; motion NULL = at rest. */
static sn_status animate(const char *model, const char *motion, sn_clip *out, sn_error *error) {
    char model_name[] = "model", motion_name[] = "motion.mot";
    sn_blob model_blob = blob_of(model_name, model), motion_blob = blob_of(motion_name, motion != NULL ? motion : "");
    sn_skeleton skeleton = {0};
    sn_columns columns = {0};
    *out = (sn_clip){0};
    sn_status status = parse_model(&model_blob, &skeleton, error);
    if (status == SN_OK && motion != NULL) status = sn_storage_parse(&motion_blob, &columns, error);
    if (status == SN_OK) status = sn_skeleton_animate(&skeleton, motion != NULL ? &columns : NULL, out, error);
    sn_columns_free(&columns);
    sn_skeleton_free(&skeleton);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------------------------- */

static void write_clip(FILE *file, const sn_clip *clip) {
    fprintf(file, "rate\t%.17g\t%d\n", clip->rate, (int)clip->frame_count);
    for (sn_index i = 0; i < clip->coordinate_count; i++) {
        fprintf(file, "coordinate\t%s\t%s", clip->coordinates[i].name, clip->coordinates[i].unit);
        for (sn_index k = 0; k < clip->frame_count; k++) fprintf(file, "\t%.17g", clip->coordinates[i].values[k]);
        fprintf(file, "\n");
    }
    for (sn_index i = 0; i < clip->joint_count; i++) {
        const sn_clip_joint *j = &clip->joints[i];
        sn_quat q = j->rest_rotation;
        fprintf(file, "joint\t%s\t%s\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\n", j->name,
                j->parent == SN_NONE ? "" : clip->joints[j->parent].name, j->rest.x, j->rest.y, j->rest.z, q.w, q.x, q.y, q.z);
        for (sn_index k = 0; k < clip->frame_count; k++) {
            sn_rigid p = j->poses[k];
            fprintf(file, "pose\t%d\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\n", (int)k, p.rotation.w, p.rotation.x, p.rotation.y,
                    p.rotation.z, p.translation.x, p.translation.y, p.translation.z);
        }
    }
}

static int write_files(const char *model, const char *motion, const char *out) {
    sn_blob model_blob = {0}, motion_blob = {0};
    sn_error error = {0};
    sn_skeleton skeleton = {0};
    sn_columns columns = {0};
    sn_clip clip = {0};
    bool moves = strcmp(motion, "-") != 0;
    sn_status status = sn_blob_read(model, &model_blob, &error);
    if (status == SN_OK) status = parse_model(&model_blob, &skeleton, &error);
    if (status == SN_OK && moves) status = sn_blob_read(motion, &motion_blob, &error);
    if (status == SN_OK && moves) status = sn_storage_parse(&motion_blob, &columns, &error);
    if (status == SN_OK) status = sn_skeleton_animate(&skeleton, moves ? &columns : NULL, &clip, &error);
    FILE *file = status == SN_OK ? fopen(out, "w") : NULL;
    if (file != NULL) write_clip(file, &clip);
    bool good = file != NULL && fclose(file) == 0;
    if (status != SN_OK) printf("%s:%lld: %s\n", error.file, (long long)error.line, error.text);
    sn_clip_free(&clip);
    sn_columns_free(&columns);
    sn_skeleton_free(&skeleton);
    sn_blob_free(&model_blob);
    sn_blob_free(&motion_blob);
    return good ? 0 : 1;
}

/* ---- one joint each ------------------------------------------------------------------------------------------------------------------ */

#define DOCUMENT_4(joints, rest)                                                                                                           \
    "<?xml version=\"1.0\"?>\n<OpenSimDocument Version=\"40000\"><Model name=\"m\"><Ground name=\"ground\"/>"                              \
    "<BodySet name=\"bodyset\"><objects><Body name=\"a\"/></objects></BodySet>"                                                            \
    "<JointSet name=\"jointset\"><objects>" joints "</objects></JointSet>" rest "</Model></OpenSimDocument>\n"
#define FRAME(name, parent, where, turned)                                                                                                 \
    "<PhysicalOffsetFrame name=\"" name "\"><socket_parent>" parent "</socket_parent><translation>" where                                  \
    "</translation><orientation>" turned "</orientation></PhysicalOffsetFrame>"
#define QUARTER "1.5707963267948966"
/* The parent's side: at (1, 2, 3), its x along the world's y. The child's side: 0.1 along its own x. */
#define FRAMES                                                                                                                             \
    "<frames>" FRAME("ground_offset", "/ground", "1 2 3", "0 0 " QUARTER) FRAME("a_offset", "/bodyset/a", "0.1 0 0", "0 0 0") "</frames>"
#define COORDINATE(name) "<Coordinate name=\"" name "\"><default_value>0</default_value></Coordinate>"
#define JOINT_4(kind, coordinates, more)                                                                                                   \
    "<" kind " name=\"j\"><socket_parent_frame>ground_offset</socket_parent_frame><socket_child_frame>a_offset</socket_child_frame>"       \
    "<coordinates>" coordinates "</coordinates>" FRAMES more "</" kind ">"
/* The same with both frames at the bodies' origins. */
#define BARE_4(kind, parent, child, coordinates, more)                                                                                     \
    "<" kind " name=\"j\"><socket_parent_frame>" parent "</socket_parent_frame><socket_child_frame>" child "</socket_child_frame>"         \
    "<coordinates>" coordinates "</coordinates>" more "</" kind ">"
#define AXIS(name, coordinate, axis, function)                                                                                             \
    "<TransformAxis name=\"" name "\"><coordinates>" coordinate "</coordinates><axis>" axis "</axis>" function "</TransformAxis>"
#define CUSTOM(coordinates, axes)                                                                                                          \
    DOCUMENT_4(BARE_4("CustomJoint", "/ground", "/bodyset/a", coordinates, "<SpatialTransform>" axes "</SpatialTransform>"), "")
#define KNOTS(kind, x, y) "<" kind " name=\"function\"><x>" x "</x><y>" y "</y></" kind ">"
#define TIMES(scale, kind, x, y)                                                                                                           \
    "<MultiplierFunction name=\"function\"><function><" kind "><x>" x "</x><y>" y "</y></" kind "></function><scale>" scale                \
    "</scale></MultiplierFunction>"
#define DOCUMENT_3(bodies)                                                                                                                 \
    "<OpenSimDocument Version=\"30000\"><Model name=\"m\"><BodySet><objects><Body name=\"ground\"><Joint/></Body>" bodies                  \
    "</objects></BodySet></Model></OpenSimDocument>\n"
#define BODY_3(name, kind, parent, where, turned, coordinate, type, more)                                                                  \
    "<Body name=\"" name "\"><Joint><" kind " name=\"j" name "\"><parent_body>" parent "</parent_body><location_in_parent>" where          \
    "</location_in_parent><orientation_in_parent>" turned                                                                                  \
    "</orientation_in_parent><location>0 0 0</location><orientation>0 0 0</orientation>"                                                   \
    "<CoordinateSet><objects><Coordinate name=\"" coordinate "\"><motion_type>" type                                                       \
    "</motion_type><default_value>0</default_value></Coordinate></objects></CoordinateSet>" more "</" kind "></Joint></Body>"
#define MOTION(names, row) "m\nversion=1\nnRows=1\ninDegrees=yes\nendheader\ntime\t" names "\n0\t" row "\n"
#define DOG(bodies) "<mujoco><compiler angle=\"degree\"/>" bodies "</mujoco>"

/* What a motion does to a point of a body that is at `point` in the rest pose, worked out by hand. */
typedef struct example {
    const char *name, *model, *motion, *body;
    sn_vec3 rest, point, moved;
} example;

static const example examples[] = {
    {"a slider goes along x of its parent's side, and no degree is one of its metres",
     DOCUMENT_4(JOINT_4("SliderJoint", COORDINATE("q"), ""), ""),
     MOTION("q", "0.25"),
     "a",
     {1, 1.9, 3},
     {1, 2, 3},
     {1, 2.25, 3}},
    {"a pin turns about z of both sides",
     DOCUMENT_4(JOINT_4("PinJoint", COORDINATE("q"), ""), ""),
     MOTION("q", "90"),
     "a",
     {1, 1.9, 3},
     {1, 1.9, 3},
     {1.1, 2, 3}},
    {"a weld holds", DOCUMENT_4(JOINT_4("WeldJoint", "", ""), ""), NULL, "a", {1, 1.9, 3}, {5, 6, 7}, {5, 6, 7}},
    {"a ball turns about x, then its own y",
     DOCUMENT_4(BARE_4("BallJoint", "/ground", "/bodyset/a", COORDINATE("x") COORDINATE("y") COORDINATE("z"), ""), ""),
     MOTION("x\ty", "90\t90"),
     "a",
     {0, 0, 0},
     {1, 0, 3},
     {3, 1, 0}},
    {"a ball turns about its own z last",
     DOCUMENT_4(BARE_4("BallJoint", "ground", "a", COORDINATE("x") COORDINATE("y") COORDINATE("z"), ""), ""),
     MOTION("x\tz", "90\t90"),
     "a",
     {0, 0, 0},
     {1, 2, 0},
     {-2, 0, 1}},
    {"a gimbal turns as a ball",
     DOCUMENT_4(BARE_4("GimbalJoint", "ground", "a", COORDINATE("x") COORDINATE("y") COORDINATE("z"), ""), ""),
     MOTION("x\ty", "90\t90"),
     "a",
     {0, 0, 0},
     {1, 0, 3},
     {3, 1, 0}},
    {"a universal joint turns about x, then its own y",
     DOCUMENT_4(BARE_4("UniversalJoint", "ground", "a", COORDINATE("x") COORDINATE("y"), ""), ""),
     MOTION("x\ty", "90\t90"),
     "a",
     {0, 0, 0},
     {1, 0, 3},
     {3, 1, 0}},
    {"a free joint shifts along the parent's axes; columns by path",
     DOCUMENT_4(BARE_4("FreeJoint", "ground", "a",
                       COORDINATE("rx") COORDINATE("ry") COORDINATE("rz") COORDINATE("tx") COORDINATE("ty") COORDINATE("tz"), ""),
                ""),
     MOTION("/jointset/j/rz/value\t/jointset/j/tx/value\t/jointset/j/ty/value\t/jointset/j/tz/value", "90\t1\t2\t3"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {1, 3, 3}},
    {"a planar joint: angle, then x and y of the parent",
     DOCUMENT_4(BARE_4("PlanarJoint", "ground", "a", COORDINATE("r") COORDINATE("x") COORDINATE("y"), ""), ""),
     MOTION("r\tx\ty", "90\t1\t2"),
     "a",
     {0, 0, 0},
     {1, 0, 5},
     {1, 3, 5}},
    {"coordinates that a document leaves out are there by their number",
     DOCUMENT_4(BARE_4("PinJoint", "ground", "a", "", ""), ""),
     MOTION("j_coord_0", "90"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {0, 1, 0}},
    {"a joint may be gone through from its child",
     DOCUMENT_4(BARE_4("PinJoint", "/bodyset/a", "/ground", COORDINATE("q"), ""), ""),
     MOTION("q", "90"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {0, -1, 0}},
    {"version 3: location and orientation in the parent",
     DOCUMENT_3(BODY_3("a", "PinJoint", "ground", "1 2 3", QUARTER " 0 0", "q", "rotational", "")),
     MOTION("q", "90"),
     "a",
     {1, 2, 3},
     {2, 2, 3},
     {1, 2, 4}},
    {"version 3: a reversed joint turns the other way round",
     DOCUMENT_3(BODY_3("a", "PinJoint", "ground", "1 2 3", "0 0 0", "q", "rotational", "<reverse>true</reverse>")),
     MOTION("q", "90"),
     "a",
     {1, 2, 3},
     {2, 2, 3},
     {1, 1, 3}},
    {"version 3: bodies may be listed before their parents",
     DOCUMENT_3(BODY_3("b", "PinJoint", "a", "1 0 0", "0 0 0", "p", "rotational", "")
                    BODY_3("a", "PinJoint", "ground", "1 0 0", "0 0 0", "q", "rotational", "")),
     MOTION("q\tp", "90\t90"),
     "b",
     {2, 0, 0},
     {3, 0, 0},
     {0, 1, 0}},
    {"lines between knots, and on past the last",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "1 0 0", TIMES("2", "PiecewiseLinearFunction", "0 1 2", "0 2 3"))
                                 AXIS("translation2", "q", "0 1 0", KNOTS("PiecewiseLinearFunction", "4 5", "7 8"))),
     MOTION("q", "3"),
     "a",
     {0, 3, 0},
     {0, 3, 0},
     {8, 6, 0}},
    {"lines between knots: within",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "1 0 0", KNOTS("PiecewiseLinearFunction", "0 1 2", "0 2 3"))),
     MOTION("q", "1.5"),
     "a",
     {0, 0, 0},
     {0, 0, 0},
     {2.5, 0, 0}},
    {"a spline through five points of a cubic is that cubic",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "1 0 0", KNOTS("SimmSpline", "-1 0 0.5 2 3", "0 0 -0.375 6 24"))),
     MOTION("q", "1.3"),
     "a",
     {0, 0, 0},
     {0, 0, 0},
     {1.3 * 1.3 * 1.3 - 1.3, 0, 0}},
    {"a spline is straight past its last knot, and before its first",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "1 0 0", KNOTS("SimmSpline", "-1 0 0.5 2 3", "0 0 -0.375 6 24"))
                                 AXIS("translation2", "q", "0 1 0", KNOTS("SimmSpline", "5 6 6.5 8 9", "0 0 -0.375 6 24"))),
     MOTION("q", "4"),
     "a",
     {0, -10, 0},
     {0, -10, 0},
     {24 + 26, -2, 0}},
    {"a spline through three points is a parabola, through two a line",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "1 0 0", KNOTS("SimmSpline", "0 1 3", "0 1 9"))
                                 AXIS("translation2", "q", "0 1 0", KNOTS("SimmSpline", "0 4", "0 2"))),
     MOTION("q", "2"),
     "a",
     {0, 0, 0},
     {0, 0, 0},
     {4, 1, 0}},
    {"a polynomial, the highest power first; a constant",
     CUSTOM(COORDINATE("q"), AXIS("translation1", "q", "2 0 0",
                                  "<PolynomialFunction name=\"function\"><coefficients>1 2 3</coefficients></PolynomialFunction>")
                                 AXIS("translation3", "", "0 0 1", "<Constant name=\"function\"><value>0.5</value></Constant>")),
     MOTION("q", "2"),
     "a",
     {3, 0, 0.5},
     {3, 0, 0.5},
     {11, 0, 0.5}},
    {"three turns of a custom joint, each about axes that those before it have turned",
     CUSTOM(COORDINATE("q") COORDINATE("p"),
            AXIS("rotation1", "q", "0 0 1", "")
                AXIS("rotation2", "p", "1 0 0", "<LinearFunction name=\"function\"><coefficients>1 0</coefficients></LinearFunction>")),
     MOTION("q\tp", "90\t90"),
     "a",
     {0, 0, 0},
     {1, 2, 0},
     {0, 1, 2}},
    {"a coordinate that no axis turns by as it is, is not in degrees",
     CUSTOM(COORDINATE("q"), AXIS("rotation1", "q", "0 0 1",
                                  "<LinearFunction name=\"function\"><coefficients>" QUARTER " 0</coefficients></LinearFunction>")),
     MOTION("q", "1"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {0, 1, 0}},
    {"MuJoCo: a hinge about a line, less its reference",
     DOG("<worldbody><body name=\"a\" pos=\"1 0 0\"><joint name=\"q\" axis=\"0 0 2\" pos=\"0 1 0\" ref=\"10\"/></body></worldbody>"),
     MOTION("q", "100"),
     "a",
     {1, 1, 0},
     {1, 0, 0},
     {2, 1, 0}},
    {"MuJoCo: a slide along an axis that the hinge before it has turned",
     DOG("<worldbody><body name=\"a\"><joint name=\"q\" axis=\"0 0 1\"/><joint name=\"s\" type=\"slide\" axis=\"1 0 "
         "0\"/></body></worldbody>"),
     MOTION("q\ts", "90\t0.5"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {0, 1.5, 0}},
    {"MuJoCo: a ball by its rotation vector",
     DOG("<worldbody><body name=\"a\" pos=\"0 0 1\"><joint name=\"q\" type=\"ball\" pos=\"0 0 1\"/></body></worldbody>"),
     MOTION("q_rx\tq_ry\tq_rz", "69.28203230275508\t69.28203230275508\t69.28203230275508"),
     "a",
     {0, 0, 2},
     {1, 0, 2},
     {0, 1, 2}},
    {"MuJoCo: a free body goes in the world's axes",
     DOG("<worldbody><body name=\"a\" pos=\"0 0 1\" euler=\"90 0 0\"><freejoint name=\"f\"/></body></worldbody>"),
     MOTION("f_tx\tf_rz", "2\t90"),
     "a",
     {0, 0, 1},
     {1, 0, 1},
     {2, 1, 1}},
    {"MuJoCo: classes within classes, childclass, frames, orders of angles, radians",
     "<mujoco><compiler angle=\"radian\" eulerseq=\"ZYX\"/><default><joint type=\"slide\" axis=\"0 1 0\"/><default class=\"c\"><joint "
     "pos=\"1 0 0\"/>"
     "<default class=\"d\"><joint type=\"hinge\" axis=\"0 0 1\"/></default></default></default><worldbody><frame pos=\"0 0 1\"><body "
     "name=\"a\" "
     "childclass=\"d\" euler=\"" QUARTER " 0 " QUARTER "\"><joint name=\"q\"/></body></frame></worldbody></mujoco>",
     MOTION("q", "90"),
     "a",
     {0, 0, 2},
     {0, 0, 1},
     {1, 0, 2}},
    {"MuJoCo: an orientation by its axes, and by its z",
     DOG("<worldbody><body name=\"b\" xyaxes=\"0 1 0 -1 0 0\"><body name=\"a\" zaxis=\"1 0 0\"><joint "
         "name=\"q\"/></body></body></worldbody>"),
     MOTION("q", "90"),
     "a",
     {0, 0, 0},
     {1, 0, 0},
     {0, 0, -1}},
};

static const sn_clip_joint *find_joint(const sn_clip *clip, const char *name) {
    for (sn_index i = 0; i < clip->joint_count; i++)
        if (strcmp(clip->joints[i].name, name) == 0) return &clip->joints[i];
    return NULL;
}

static void try_example(const example *e) {
    sn_clip clip;
    sn_error error = {0};
    char said[1200];
    if (animate(e->model, e->motion, &clip, &error) != SN_OK) {
        snprintf(said, sizeof said, "%s: %s (line %lld)", e->name, error.text, (long long)error.line);
        check(false, said);
        return;
    }
    const sn_clip_joint *joint = find_joint(&clip, e->body);
    sn_vec3 moved = sn_rigid_apply(joint->poses[clip.frame_count - 1], e->point);
    bool good = sn_distance(joint->rest, e->rest) < 1e-12 && sn_distance(moved, e->moved) < 1e-12;
    snprintf(said, sizeof said, "%s: rest %g %g %g, moved %g %g %g", e->name, joint->rest.x, joint->rest.y, joint->rest.z, moved.x, moved.y,
             moved.z);
    check(good, said);
    sn_clip_free(&clip);
}

/* ---- coordinates --------------------------------------------------------------------------------------------------------------------- */

#define PINS                                                                                                                               \
    "<OpenSimDocument Version=\"40000\"><Model><Ground name=\"ground\"/><BodySet><objects><Body name=\"a\"/><Body name=\"b\"/><Body "      \
    "name=\"c\"/></objects></BodySet><JointSet><objects>"
#define PIN(name, parent, child, more)                                                                                                     \
    "<PinJoint name=\"" name "\"><socket_parent_frame>/bodyset/" parent "</socket_parent_frame><socket_child_frame>/bodyset/" child        \
    "</socket_child_frame><coordinates><Coordinate name=\"" name "_q\">" more "</Coordinate></coordinates></PinJoint>"
#define COUPLER(dependent, independent, slope, scale)                                                                                      \
    "<CoordinateCouplerConstraint><isEnforced>true</isEnforced><coupled_coordinates_function><LinearFunction><coefficients>" slope         \
    " 0.5</coefficients></LinearFunction></coupled_coordinates_function><independent_coordinate_names>" independent                        \
    "</independent_coordinate_names><dependent_coordinate_name>" dependent "</dependent_coordinate_name><scale_factor>" scale              \
    "</scale_factor></CoordinateCouplerConstraint>"
#define END_PINS(constraints)                                                                                                              \
    "</objects></JointSet><ConstraintSet><objects>" constraints "</objects></ConstraintSet></Model></OpenSimDocument>"
#define THREE_PINS(first, constraints)                                                                                                     \
    PINS PIN("j", "ground", "a", first) PIN("k", "a", "b", "") PIN("l", "b", "c", "") END_PINS(constraints)

/* The value of a coordinate in the last frame of a motion; NAN where it cannot be read. */
static double value_after(const char *model, const char *motion, const char *coordinate) {
    sn_clip clip;
    sn_error error = {0};
    double value = NAN;
    warnings = 0;
    if (animate(model, motion, &clip, &error) != SN_OK) {
        printf("%s:%lld: %s\n", error.file, (long long)error.line, error.text);
        return NAN;
    }
    for (sn_index i = 0; i < clip.coordinate_count; i++)
        if (strcmp(clip.coordinates[i].name, coordinate) == 0) value = clip.coordinates[i].values[clip.frame_count - 1];
    sn_clip_free(&clip);
    return value;
}

static bool near(double a, double b) { return fabs(a - b) <= 1e-14 * (1.0 + fabs(b)); }

static void check_coordinates(void) {
    static const char plain[] = THREE_PINS("<default_value>0.2</default_value>", "");
    static const char clamped[] = THREE_PINS("<range>-1 1</range><clamped>true</clamped>", "");
    static const char locked[] = THREE_PINS("<default_value>0.2</default_value><locked>true</locked>", "");
    /* c depends on b, which depends on a, listed the wrong way round: b = 2 (3 a + 0.5), c = -(1 b + 0.5) */
    static const char coupled[] = THREE_PINS("", COUPLER("l_q", "k_q", "1", "-1") COUPLER("k_q", "j_q", "3", "2"));
    double quarter = SN_PI / 2.0;
    check(near(value_after(plain, MOTION("j_q\tk_q", "90\t1"), "j_q"), quarter) && warnings == 0,
          "degrees become radians, and nothing is said");
    check(near(value_after(plain, "m\ninDegrees=no\nendheader\ntime\tj_q\n0\t1.5\n", "j_q"), 1.5), "radians stay");
    check(near(value_after(plain, "m\nendheader\ntime\tj_q\n0\t1.5\n", "j_q"), 1.5), "without a word numbers are radians");
    check(near(value_after(plain, "m\ndatacolumns 2\ndatarows 1\nendheader\ntime j_q\n0 90\n", "j_q"), quarter),
          "SIMM's motions are degrees");
    check(value_after(plain, MOTION("k_q", "1"), "j_q") == 0.2, "what a motion lacks stays at its default");
    check(value_after(plain, NULL, "j_q") == 0.2, "without a motion all is at its default");
    check(value_after(plain, MOTION("j_q\tactivation\tforce\t/jointset/j/j_q/speed", "0\t1\t2\t3"), "j_q") == 0.0 && warnings == 1 &&
              strstr(last_warning, "3 of 4 columns") != NULL && strstr(last_warning, "activation, force") != NULL,
          "columns that the model lacks: one warning");
    check(value_after(clamped, MOTION("j_q", "90"), "j_q") == 1.0 && warnings == 1, "a clamped coordinate stays in its range, said once");
    check(value_after(locked, MOTION("j_q", "90"), "j_q") == 0.2 && warnings == 1, "a locked coordinate stays at its default, said once");
    check(value_after(locked, "m\nendheader\ntime\tj_q\n0\t0.2\n", "j_q") == 0.2 && warnings == 0, "a locked one that a file leaves there");
    check(near(value_after(coupled, MOTION("j_q", "90"), "k_q"), 2.0 * (3.0 * quarter + 0.5)), "a coupler sets what depends on it");
    check(near(value_after(coupled, MOTION("j_q\tl_q", "90\t7"), "l_q"), -(6.0 * quarter + 1.0 + 0.5)),
          "couplers in a row, over the motion");
    check(near(value_after(coupled, NULL, "l_q"), -1.5), "couplers hold at rest");
}

static void check_times(void) {
    static const char plain[] = THREE_PINS("", "");
    static const char uneven[] = "m\nnRows=3\ninDegrees=no\nendheader\ntime\tj_q\n2\t0\n2.1\t1\n2.4\t2.5\n";
    static const char even[] = "m\ninDegrees=no\nendheader\ntime\tj_q\n0.016\t0\n0.033\t1\n0.050\t2\n0.066\t3\n";
    sn_clip clip;
    sn_error error = {0};
    warnings = 0;
    check(animate(plain, uneven, &clip, &error) == SN_OK && clip.rate == 5.0 && clip.frame_count == 3 && warnings == 1 &&
              near(clip.coordinates[0].values[1], 1.5) && clip.coordinates[0].values[2] == 2.5,
          "uneven times are resampled by straight lines, said once");
    sn_clip_free(&clip);
    warnings = 0;
    check(animate(plain, even, &clip, &error) == SN_OK && near(clip.rate, 60.0) && warnings == 0 && clip.coordinates[0].values[2] == 2.0,
          "times that were rounded to a millisecond are even: the rows are the frames");
    sn_clip_free(&clip);
}

/* ---- meshes ----------------------------------------------------------------------------------------------------------------------------
 */

static void check_mesh(const char *model, sn_index number, const char *body, const char *file, sn_vec3 point, sn_vec3 shown,
                       const char *what) {
    char name[] = "model";
    sn_blob blob = blob_of(name, model);
    sn_skeleton s;
    sn_error error = {0};
    if (parse_model(&blob, &s, &error) != SN_OK || number >= s.mesh_count) {
        printf("%s:%lld: %s\n", error.file, (long long)error.line, error.text);
        check(false, what);
        return;
    }
    const sn_skeleton_mesh *m = &s.meshes[number];
    sn_vec3 scaled = sn_v3(m->scale.x * point.x, m->scale.y * point.y, m->scale.z * point.z);
    bool on = body == NULL ? m->body == SN_NONE : m->body != SN_NONE && strcmp(s.bodies[m->body].name, body) == 0;
    check(on && strcmp(m->file, file) == 0 && sn_distance(sn_rigid_apply(m->frame, scaled), shown) < 1e-12, what);
    sn_skeleton_free(&s);
}

static void check_meshes(void) {
    static const char four[] =
        "<OpenSimDocument Version=\"40000\"><Model><Ground name=\"ground\"><attached_geometry><Mesh "
        "name=\"g\"><mesh_file>floor.vtp</mesh_file></Mesh>"
        "</attached_geometry></Ground><BodySet><objects><Body name=\"a\"><components><PhysicalOffsetFrame "
        "name=\"shown\"><attached_geometry><Mesh "
        "name=\"m\"><socket_frame>..</socket_frame><scale_factors>2 3 4</scale_factors><mesh_file>a &amp; b.vtp</mesh_file></Mesh>"
        "</attached_geometry><socket_parent>..</socket_parent><translation>1 0 0</translation><orientation>0 0 " QUARTER
        "</orientation></PhysicalOffsetFrame></components></Body></objects></BodySet><JointSet><objects>" PIN("j", "ground", "a", "")
            END_PINS("");
    static const char three[] =
        DOCUMENT_3("<Body name=\"a\"><Joint><WeldJoint "
                   "name=\"w\"><parent_body>ground</parent_body></WeldJoint></Joint><VisibleObject><GeometrySet><objects>"
                   "<DisplayGeometry><geometry_file>f.vtp</geometry_file><transform>0 0 " QUARTER
                   " 1 1 1</transform><scale_factors>2 2 2</scale_factors>"
                   "</DisplayGeometry></objects></GeometrySet><scale_factors>3 3 3</scale_factors><transform>0 0 0 0 0 "
                   "1</transform></VisibleObject></Body>");
    static const char dog[] =
        DOG("<compiler meshdir=\"bones\"/><default><geom type=\"mesh\"/><mesh scale=\"2 2 2\"/></default><asset><mesh "
            "file=\"sub/femur.stl\"/></asset><worldbody><body name=\"a\"><geom mesh=\"femur\" pos=\"1 0 0\" quat=\"0 0 0 1\"/>"
            "</body></worldbody>");
    static const char reference[] =
        DOG("<asset><mesh name=\"m\" file=\"m.stl\" scale=\"2 2 2\" refpos=\"1 0 0\" refquat=\"1 0 0 1\"/></asset><worldbody><body "
            "name=\"a\"><geom type=\"capsule\" mesh=\"m\"/><geom type=\"mesh\" mesh=\"m\" pos=\"0 0 5\"/></body></worldbody>");
    check_mesh(four, 0, NULL, "floor.vtp", sn_v3(1, 2, 3), sn_v3(1, 2, 3), "a mesh of the ground");
    check_mesh(four, 1, "a", "a & b.vtp", sn_v3(1, 1, 1), sn_v3(-2, 2, 4), "a mesh of an offset frame, with its scale");
    check_mesh(three, 0, "a", "f.vtp", sn_v3(1, 0, 0), sn_v3(3, 9, 4), "a mesh of version 3 under its body's scale and transform");
    check_mesh(dog, 0, "a", "bones/sub/femur.stl", sn_v3(1, 1, 1), sn_v3(-1, -2, 2), "a mesh of MuJoCo's by its asset");
    /* (2, 0, 0) less (1, 0, 0), turned by -90 degrees about z, times 2 */
    check_mesh(reference, 0, "a", "m.stl", sn_v3(2, 0, 0), sn_v3(0, -2, 5),
               "a mesh of MuJoCo's out of its own frame; a fitted capsule is none");
}

/* ---- broken files
 * ------------------------------------------------------------------------------------------------------------------------ */

/* A file that is refused: at which line (0 = any), and a part of what is said. */
typedef struct refusal {
    const char *model, *motion;
    int64_t line;
    const char *said;
} refusal;

#define GOOD THREE_PINS("", "")
static const refusal refusals[] = {
    {"<OpenSimDocument Version=\"40000\">\n<Model>\n", NULL, 3, "XML is broken"},
    {"<Other/>", NULL, 1, "not an OpenSim document"},
    {"<OpenSimDocument Version=\"10000\"><Model/></OpenSimDocument>", NULL, 1, "version 10000"},
    {"<OpenSimDocument Version=\"40000\"/>", NULL, 1, "no model"},
    {"<OpenSimDocument Version=\"40000\">\n<Model/></OpenSimDocument>", NULL, 2, "no body"},
    {DOCUMENT_4(BARE_4("ScapulothoracicJoint", "ground", "a", "", ""), ""), NULL, 2, "is not read"},
    {DOCUMENT_4(BARE_4("PinJoint", "ground", "nowhere", "", ""), ""), NULL, 2, "no body or frame \"nowhere\""},
    {DOCUMENT_4(BARE_4("PinJoint", "ground", "a", COORDINATE("q") COORDINATE("p"), ""), ""), NULL, 2, "a PinJoint has 1"},
    {DOCUMENT_4(BARE_4("PinJoint", "ground", "a", "\n<Coordinate name=\"q\">\n<range>1 x</range></Coordinate>", ""), ""), NULL, 3,
     "\"x\" is no finite number"},
    {DOCUMENT_4(BARE_4("PinJoint", "ground", "a", COORDINATE("q"), "") BARE_4("PinJoint", "a", "ground", COORDINATE("p"), ""), ""), NULL, 2,
     "loop"},
    {DOCUMENT_4(BARE_4("PinJoint", "ground", "a", COORDINATE("q") "",
                       "<frames>" FRAME("f", "g", "0 0 0", "0 0 0") FRAME("g", "f", "0 0 0", "0 0 0") "</frames>"),
                "") "",
     NULL, -1, NULL}, /* a ring of frames that nothing asks for does no harm */
    {DOCUMENT_4(BARE_4("PinJoint", "f", "a", COORDINATE("q"),
                       "<frames>" FRAME("f", "g", "0 0 0", "0 0 0") FRAME("g", "f", "0 0 0", "0 0 0") "</frames>"),
                ""),
     NULL, 2, "without an end"},
    {CUSTOM(COORDINATE("q"), AXIS("rotation1", "p", "0 0 1", "")), NULL, 2, "no coordinate \"p\""},
    {CUSTOM(COORDINATE("q"), AXIS("rotation1", "q", "0 0 0", "")), NULL, 2, "no length"},
    {CUSTOM(COORDINATE("q"), AXIS("rotation1", "q", "0 0 1", "<Sine name=\"function\"/>")), NULL, 2, "function Sine is not known"},
    {CUSTOM(COORDINATE("q"), AXIS("rotation1", "q", "0 0 1", KNOTS("SimmSpline", "0 1 2", "0 1"))), NULL, 2, "3 numbers x and 2 numbers y"},
    {CUSTOM(COORDINATE("q"), AXIS("rotation1", "q", "0 0 1", KNOTS("SimmSpline", "0 2 1", "0 1 2"))), NULL, 2, "knot 3"},
    {THREE_PINS("", COUPLER("k_q", "l_q", "1", "1") COUPLER("l_q", "k_q", "1", "1")), NULL, 0, "depends on itself"},
    {THREE_PINS("", COUPLER("k_q", "j_q", "1", "1") COUPLER("k_q", "j_q", "1", "1")), NULL, 0, "two couplers"},
    {THREE_PINS("", COUPLER("k_q", "no", "1", "1")), NULL, 1, "no coordinate \"no\""},
    {"<!DOCTYPE x [<!ENTITY y \"z\">]>\n<OpenSimDocument/>", NULL, 1, "document type"},
    {"<mujoco><worldbody>\n<joint/></worldbody></mujoco>", NULL, 2, "in no body"},
    {"<mujoco><worldbody><body>\n<joint type=\"screw\"/></body></worldbody></mujoco>", NULL, 2, "another type"},
    {"<mujoco><worldbody><body>\n<joint class=\"none\"/></body></worldbody></mujoco>", NULL, 2, "no default class"},
    {"<mujoco><worldbody><body><body>\n<freejoint/></body></body></worldbody></mujoco>", NULL, 2, "free joint"},
    {"<mujoco><worldbody><body name=\"a\"/><body name=\"a\"/></worldbody></mujoco>", NULL, 0, "two bodies"},
    {"<mujoco><compiler eulerseq=\"xyq\"/></mujoco>", NULL, 1, "eulerseq"},
    {"<mujoco><worldbody><geom mesh=\"gone\"/></worldbody></mujoco>", NULL, 1, "no mesh \"gone\""},
    {"<mujoco><asset><mesh name=\"m\" file=\"m\" scale=\"1 2 1\" refquat=\"1 1 0 0\"/></asset><worldbody><geom type=\"mesh\" "
     "mesh=\"m\"/></worldbody></mujoco>",
     NULL, 1, "scaled unevenly"},
    {GOOD, "no header\n", 1, "endheader"},
    {GOOD, "m\nnRows=two\nendheader\ntime j_q\n0 1\n", 2, "nRows is no count"},
    {GOOD, "m\ninDegrees=maybe\nendheader\ntime j_q\n0 1\n", 2, "inDegrees"},
    {GOOD, "m\nendheader\n", 2, "no row of names"},
    {GOOD, "m\nendheader\nj_q time\n0 1\n", 3, "first column"},
    {GOOD, "m\nnColumns=3\nendheader\ntime j_q\n0 1\n", 4, "nColumns=3"},
    {GOOD, "m\nnRows=3\nendheader\ntime j_q\n0 1\n0.1 1\n", 6, "2 rows and the header says nRows=3"},
    {GOOD, "m\nendheader\ntime j_q\n", 3, "no row"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n0.1 x\n", 5, "\"x\" is no number"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n0.1\n", 5, "1 numbers"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n0.1 2 3\n", 5, "more numbers"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n0.1 nan\n", 5, "not finite"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n0 1\n", 5, "not later"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n1 1e300\n", 5, "too large"},
    {GOOD, "m\nendheader\ntime j_q\n0 1\n\n0.1 1\n", 6, "empty line"},
    {GOOD, "m\nendheader\ntime j_q /jointset/j/j_q/value\n0 1 1\n", 3, "two columns"},
    {GOOD, "m\nendheader\ntime other\n0 1\n", 3, "no column is a coordinate"},
};

static void try_refusal(const refusal *r) {
    sn_clip clip;
    sn_error error = {0};
    char said[1400];
    sn_status status = animate(r->model, r->motion, &clip, &error);
    bool refused = status == SN_ERROR_INPUT && r->said != NULL && strstr(error.text, r->said) != NULL && error.file[0] != '\0';
    bool good = r->line < 0 ? status == SN_OK : refused && (r->line == 0 || error.line == r->line);
    snprintf(said, sizeof said, "refused for \"%s\" at line %lld: status %d, %s:%lld: %s", r->said != NULL ? r->said : "nothing",
             (long long)r->line, (int)status, error.file, (long long)error.line, error.text);
    check(good, said);
    sn_clip_free(&clip);
}

/* ---- real models
 * -------------------------------------------------------------------------------------------------------------------------- */

static const char dog_motion[] = "dog\nnRows=3\nnColumns=7\ninDegrees=yes\nendheader\n"
                                 "time\thip_L_extend\thip_L_abduct\tknee_L\tscapula_L_extend\tL_3_bend\tCa_10_bend\n"
                                 "0\t0\t0\t0\t0\t0\t0\n0.1\t30\t10\t-20\t12\t5\t7\n0.2\t-60\t20\t-90\t-20\t-15\t14\n";

/* Write a motion by this library and have the program judge it. */
static void judge(const char *mode, const char *folder, const char *model, const char *motion, const char *lengths) {
    char model_path[512], motion_path[512], out[64], command[2400];
    const char *data = getenv("DATA") != NULL ? getenv("DATA") : "../shared/data";
    snprintf(model_path, sizeof model_path, "%s/%s/%s", data, folder, model);
    if (motion[0] == '/' || motion[0] == '-')
        snprintf(motion_path, sizeof motion_path, "%s", motion);
    else
        snprintf(motion_path, sizeof motion_path, "%s/%s/%s", data, folder, motion);
    snprintf(out, sizeof out, "/tmp/motion-models-%d.tsv", (int)getpid());
    if (access(model_path, R_OK) != 0 || system("python3 -c '' 2>/dev/null") != 0) {
        printf("skipped: %s of %s (no such data, or no python3)\n", mode, folder);
        return;
    }
    bool good = write_files(model_path, motion_path, out) == 0;
    if (lengths == NULL)
        snprintf(command, sizeof command, "tests/model-fk.py %s '%s' '%s' '%s'", mode, model_path, motion_path, out);
    else
        snprintf(command, sizeof command, "tests/model-fk.py %s '%s' '%s' '%s/%s/%s'", mode, model_path, out, data, folder, lengths);
    printf("%s, %s: ", folder, mode);
    fflush(stdout);
    check(good && system(command) == 0, command);
    unlink(out);
}

static void check_real_models(void) {
    char path[64];
    snprintf(path, sizeof path, "/tmp/motion-models-%d.mot", (int)getpid());
    FILE *file = fopen(path, "w");
    bool written = file != NULL && fputs(dog_motion, file) >= 0;
    check(file != NULL && fclose(file) == 0 && written, "a motion of the dog is written");
    judge("origins", "gait-opensim", "motion/subject01_simbody_adjusted.osim", "motion/subject01_walk1_ik.mot", NULL);
    judge("origins", "gait-opensim", "motion/subject01_simbody_adjusted.osim", "motion/subject02_running_ik.mot", NULL);
    judge("origins", "gait-opensim", "motion/subject01_simbody_adjusted.osim", "-", NULL);
    judge("origins", "gait1018-opensim", "walk_gait1018_subject01.osim", "walk_gait1018_state_reference.mot", NULL);
    judge("lengths", "gait1018-opensim", "walk_gait1018_subject01.osim", "walk_gait1018_state_reference.mot",
          "walk_gait1018_muscle_lengths.sto");
    judge("mjcf", "dog-dmcontrol", "dog.xml", "-", NULL);
    judge("mjcf", "dog-dmcontrol", "dog.xml", path, NULL);
    unlink(path);
}

int main(int argc, char **argv) {
    sn_log_set(on_log, NULL);
    if (argc == 5 && strcmp(argv[1], "--write") == 0) return write_files(argv[2], argv[3], argv[4]);
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) try_example(&examples[i]);
    check_coordinates();
    check_times();
    check_meshes();
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) try_refusal(&refusals[i]);
    check_real_models();
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
