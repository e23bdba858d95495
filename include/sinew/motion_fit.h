/*
 * motion_fit.h -- a recorded motion on a body's own bones: the table that binds them, joint centres by rule, the fit, what came of it. rank
 * 2
 *
 * Each bone hangs rigidly on one joint (Romeo et al. 2018, 4.2). The rotations of the source, relative to its rest pose turned onto that of
 * the body, go about the body's own centres, down the body's own tree: joints that the source lets slide do not come apart here. Lengths
 * are metres, angles radians, z is up.
 */
#ifndef SINEW_MOTION_FIT_H
#define SINEW_MOTION_FIT_H

#include "sinew/geom.h"
#include "sinew/motion_clip.h"
#include "sinew/thread.h"

/* ---- the table (lib/motion/fit_rows.c; read from text by sn_fit_table_parse in io.h) --------------------------------------------- */

enum { SN_FIT_REGIONS = 4 };

typedef enum sn_fit_region_kind {
    SN_FIT_BALL, /* within `length` of the point `vector` */
    SN_FIT_FAR   /* within `length`, measured along `vector`, of the vertex that lies farthest in that direction */
} sn_fit_region_kind;
typedef struct sn_fit_region {
    sn_fit_region_kind kind;
    sn_vec3 vector;
    double length;
} sn_fit_region;

/* Vertices of the bones whose names match; each region narrows what those before it have left. */
typedef struct sn_fit_selection {
    char *bones; /* a pattern: sn_fit_matches; owned */
    sn_index region_count;
    sn_fit_region regions[SN_FIT_REGIONS];
} sn_fit_selection;

typedef enum sn_fit_rule_kind {
    SN_FIT_POINT,  /* given */
    SN_FIT_MEAN,   /* of a selection */
    SN_FIT_SPHERE, /* centre of the sphere through a selection */
    SN_FIT_MIDDLE, /* between the means of two selections */
    SN_FIT_AXIS    /* between the centres of the spheres through two: a hinge's axis runs through both */
} sn_fit_rule_kind;
extern const char *const sn_fit_rule_names[]; /* "point", "mean", ...; NULL at the end */
/* How many selections a rule of this kind has: 0, 1 or 2. */
sn_index sn_fit_rule_selections(sn_fit_rule_kind kind);

typedef struct sn_fit_rule {
    sn_fit_rule_kind kind;
    sn_vec3 point;
    sn_fit_selection selections[2];
} sn_fit_rule;

/* A place on the body, and where it is in the source: the rest place of a joint, or of its end ("NAME.end"). */
typedef struct sn_fit_point {
    char *name;   /* owned */
    char *source; /* owned; "a|b": the first that the source has; NULL = nowhere */
    sn_fit_rule rule;
    int64_t line; /* of the table */
} sn_fit_point;

/* A direction from one point to another, on the body and in the source alike. */
typedef struct sn_fit_direction {
    bool given;
    bool level;        /* of its heading alone: up stays up */
    char *names[2];    /* owned; [0] NULL = the joint's own centre */
    sn_index from, to; /* of points; set by sn_fit_table_link */
} sn_fit_direction;

/* Joint i's centre and source are point i. */
typedef struct sn_fit_joint {
    char *parent_name;      /* owned; NULL = none */
    sn_index parent;        /* set by sn_fit_table_link */
    bool inherits;          /* its rest pose is turned as its parent's, by no direction of its own */
    sn_fit_direction along; /* its segment; not given and not inherits: to its only child's centre */
    sn_fit_direction aside; /* what settles the turn about the segment */
} sn_fit_joint;

typedef struct sn_fit_bone_row {
    char *pattern, *joint_name; /* owned */
    double meters_per_unit;     /* 0 = the table's */
    sn_index joint;
    int64_t line;
} sn_fit_bone_row;

/* A leg: hip, knee, ankle. A foot: a joint, with all that hangs on it. */
typedef struct sn_fit_leg {
    char *names[3]; /* owned */
    sn_index joints[3];
    int64_t line;
} sn_fit_leg;
typedef struct sn_fit_foot_row {
    char *name; /* owned */
    sn_index joint;
    int64_t line;
} sn_fit_foot_row;

/* Bones whose surfaces meet at a joint: those that match one pattern, and those that match the other. */
typedef struct sn_fit_meet {
    char *joint_name, *patterns[2]; /* owned */
    sn_index joint;
    int64_t line;
} sn_fit_meet;

typedef struct sn_fit_table {
    char *name;             /* of its file, for messages; owned */
    double meters_per_unit; /* of its lengths, already applied, and of meshes that tell no unit */
    char *folder;           /* of the bones' meshes, from the working directory; owned; NULL = not told */
    sn_index joint_count, point_count;
    sn_fit_point *points; /* (point_count) those of the joints come first */
    sn_fit_joint *joints; /* (joint_count) once linked: parents before children */
    sn_index bone_count, leg_count, foot_count, meet_count;
    sn_fit_bone_row *bones; /* the first that matches a bone binds it */
    sn_fit_leg *legs;
    sn_fit_foot_row *feet;
    sn_fit_meet *meets;
} sn_fit_table;

/* `*` stands for any characters, `?` for one; upper and lower case differ. */
bool sn_fit_matches(const char *pattern, const char *name);
/* Find what names mean, and put parents before children. SN_ERROR_INPUT names the line: a name that is unknown or stands twice, a cycle,
 * none or several joints without a parent. */
SN_MUST_CHECK sn_status sn_fit_table_link(sn_fit_table *table, sn_error *error);
/* The row that binds a bone of this name; SN_NONE = none. */
sn_index sn_fit_table_row(const sn_fit_table *table, const char *bone);
void sn_fit_table_free(sn_fit_table *table); /* leaves all zeros */

/* ---- the body (lib/motion/fit_body.c fit_sphere.c) ------------------------------------------------------------------------------- */

/* Fewer vertices, a root mean square beyond this share of the radius, less of the sphere covered, or more of the selection left out: that
 * is no sphere. */
enum { SN_FIT_SPHERE_VERTICES = 6 };
#define SN_FIT_SPHERE_RMS 0.1
#define SN_FIT_SPHERE_COVERAGE 0.05
#define SN_FIT_SPHERE_LEFT_OUT 0.4

typedef struct sn_fit_sphere {
    sn_vec3 centre;
    double radius, rms;      /* of the vertices used, about the surface of the sphere */
    double coverage;         /* area of the triangles with all corners used, over that of the sphere */
    sn_index selected, used; /* vertices; the others lay too far from the rest */
} sn_fit_sphere;

/* Vertices and triangles of one or several meshes. */
typedef struct sn_fit_patch {
    sn_index point_count, triangle_count;
    const sn_vec3 *points;
    const sn_triangle *triangles;
} sn_fit_patch;
/* The sphere of least squared distances through the points, those left out one round after the other that lie beyond 3 standard deviations
 * (of the median) and a hundredth of the radius. SN_ERROR_INPUT tells why it is no sphere. */
SN_MUST_CHECK sn_status sn_fit_sphere_robust(const sn_fit_patch *patch, sn_fit_sphere *out, sn_error *error);

typedef struct sn_fit_bone {
    const char *name, *path; /* not owned */
    double meters_per_unit;  /* of the mesh's file */
    const sn_mesh *mesh;     /* in metres, z up; not owned */
    sn_index row, joint;     /* set by sn_fit_body_create; SN_NONE = no row binds it */
} sn_fit_bone;

typedef struct sn_fit_place {
    sn_vec3 centre;
    sn_index sphere_count;
    sn_fit_sphere spheres[2];
} sn_fit_place;

typedef struct sn_fit_body {
    const sn_fit_table *table; /* linked; must outlive it */
    sn_index bone_count;
    sn_fit_bone *bones;   /* (bone_count) owned */
    sn_fit_place *places; /* (table->point_count) owned */
} sn_fit_body;

/* bones (count; copied). SN_ERROR_INPUT names the table's line: a selection without a vertex, what is no sphere, no bone bound at all. */
SN_MUST_CHECK sn_status sn_fit_body_create(const sn_fit_table *table, sn_index count, const sn_fit_bone *bones, sn_fit_body *out,
                                           sn_error *error);
void sn_fit_body_free(sn_fit_body *body); /* leaves all zeros */
/* Is joint j the joint `top`, or below it? */
bool sn_fit_below(const sn_fit_table *table, sn_index j, sn_index top);

/* ---- the fit (lib/motion/fit.c fit_align.c) ------------------------------------------------------------------------------------- */

typedef struct sn_fit_params {
    bool align;   /* turn the source's rest pose onto the body's; else the two are taken to agree */
    double scale; /* of the way of the root; 0 = the ratio of the lengths of the legs, 1 where the table names none */
    bool ground;  /* turn and shift the whole motion so that the floor that standing feet tell is level, at z = 0 */
} sn_fit_params;
#define SN_FIT_DEFAULTS ((sn_fit_params){.align = true, .scale = 0.0, .ground = true})

typedef struct sn_fit_result {
    sn_clip clip;                  /* the body's joints, the table's order; its bones; coordinates of the source */
    sn_index *sources;             /* (joint_count) of the source; SN_NONE = moves with its parent */
    sn_quat *alignment;            /* (joint_count) turns the source's rest pose onto the body's, world */
    double scale, leg, source_leg; /* mean lengths hip-knee-ankle; 0 = the table names no leg */
    bool floor, levelled;          /* standing feet tell a floor; the motion has been turned to level it */
    double slope;                  /* of the floor, before, along the feet's way, radians; 0 = they do not tell it */
    sn_vec3 uphill;                /* unit, horizontal */
    double raised;                 /* by which the motion was shifted in height */
} sn_fit_result;

/* A foot stands while the source's goes slower, m/s. A floor that is steeper, radians, is a slope, not a capture out of level: it stays. */
#define SN_FIT_STANCE_SPEED 0.5
#define SN_FIT_SLOPE_LIMIT 0.05235987755982988 /* 3 degrees */

/*
 * Each frame: bone of joint j turns by R_j(t) A_j^-1, R_j the source's rotation away from rest, A_j the alignment; centres follow the
 * body's tree. The middle of the hips (first joints of the legs; the root where there are none) is at `scale` times that of the source.
 * A_j starts as that of the parent. Level: a turn about the vertical until headings agree. Else: the least turn until the direction `along`
 * agrees, then one about it until `aside` does, where that is given.
 * SN_ERROR_INPUT: a joint is not in the source, a direction has no length.
 */
SN_MUST_CHECK sn_status sn_motion_fit(const sn_fit_body *body, const sn_clip *source, const sn_fit_params *params, sn_fit_result *out,
                                      sn_error *error);
void sn_fit_result_free(sn_fit_result *result);
/* The joint of the source that "a|b" names; *end: it is that joint's end. SN_NONE = none. */
sn_index sn_fit_find_source(const sn_clip *source, const char *names, bool *end);
/* Joints of the source that turn against their parents by more than a degree, and drive nothing: out (joint_count of the source). */
SN_MUST_CHECK sn_status sn_fit_idle_sources(const sn_fit_result *result, const sn_clip *source, bool *out, sn_error *error);

/* The turn of a joint against its parent, away from rest: least and greatest angle, and of its rotation vector along x, y and z. */
typedef struct sn_fit_range {
    double low[4], high[4]; /* angle, x, y, z */
} sn_fit_range;
sn_fit_range sn_fit_joint_range(const sn_clip *fitted, sn_index joint);

/* ---- what came of it (lib/motion/fit_gap.c fit_feet.c) --------------------------------------------------------------------------- */

/* How near the surfaces come that meet at a joint: those of its bones to those of its parent's, or what a `meet` row names. Negative where
 * one lies within the other: by how much. */
typedef struct sn_fit_gap {
    sn_index joint;
    sn_index bones[2]; /* nearest to each other at rest: of the joint, of its parent */
    double rest, least, greatest;
    sn_index least_frame, greatest_frame;
} sn_fit_gap;
/* Exact to `tolerance`, at every `every`th frame and the last. Steps of the trace: "gap", one a joint; *count says how many are done.
 * *out is allocated. */
typedef struct sn_fit_gap_params {
    double tolerance;
    sn_index every;
    sn_pool *pool; /* nullable */
} sn_fit_gap_params;
SN_MUST_CHECK sn_status sn_fit_gaps(const sn_fit_body *body, const sn_clip *fitted, const sn_fit_gap_params *params, sn_trace *trace,
                                    sn_fit_gap **out, sn_index *count, sn_error *error);

/* A foot near the ground. The point of contact is the vertex that is lowest in a frame; from one frame to the next it goes as the foot
 * carries that vertex. A foot that rolls from heel to toe does not move by this measure, one that slides does. */
typedef struct sn_fit_stance {
    sn_index first, last; /* frames */
    double travel;        /* horizontal: the farthest that the point of contact gets from where it was at any time before */
    double path;          /* its length */
} sn_fit_stance;
typedef struct sn_fit_foot {
    sn_index joint;
    double lowest; /* vertex over the motion: its height */
    sn_index lowest_frame;
    sn_index stance_count;
    sn_fit_stance *stances; /* (stance_count) owned */
} sn_fit_foot;
typedef struct sn_fit_foot_params {
    double
        height;   /* a foot stands while its lowest vertex is less than this above the floor (its lowest height, where there is none) ... */
    double speed; /* ... and the lowest of the source's joints that drive it, or their ends, goes slower than this: m/s */
} sn_fit_foot_params;
/* One for each `foot` row, in their order; *out is allocated, freed by sn_fit_feet_free. source: what the motion was fitted from: speed
 * is judged by the source, so that what the fit makes slide is not left out. */
SN_MUST_CHECK sn_status sn_fit_feet(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source,
                                    const sn_fit_foot_params *params, sn_fit_foot **out, sn_error *error);
void sn_fit_feet_free(sn_fit_foot *feet, sn_index count);
/* The lowest vertex of the bones at a joint or below it in each frame: out (frame_count). False: there is none. */
typedef struct sn_fit_contact {
    sn_vec3 at;
    sn_index bone, vertex;
} sn_fit_contact;
bool sn_fit_contacts(const sn_fit_body *body, const sn_clip *fitted, sn_index top, sn_fit_contact *out);

#endif
