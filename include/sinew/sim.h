/*
 * sim.h -- the simulation: one constraint table per muscle, a model that never changes, a state that steps, statistics.   rank 3
 *
 * Everything here is in metres, kilograms, seconds and radians; only sn_state_positions() gives document units back.
 * Names follow methods.md: C is a constraint's value, w an inverse mass, k a stiffness, alpha = 1/k a compliance, h a time step.
 *
 *   sn_model_create     scene -> model: decides what runs (the plan), builds the rows of every constraint once
 *   sn_state_create     the arrays that a run writes; sn_state_reset puts them at the scene's first frame
 *   sn_settle           the pre-roll: time passes with the inputs of the first frame
 *   sn_step             one frame further; writes the state only; no printing or I/O, and under `xpbd` no allocation
 *
 * Back end `xpbd` ([R18] alg. 1, guarded): per substep predict, carry the attached vertices with their bones, then per iteration
 * project internal, radial and mesh distances, dihedral angles, least areas, and last the volume. Back end `qn`: per substep minimise the
 * energy of the same rows and of inertia by a quasi-Newton method; its matrix is factored in the first step and whenever the stiffness has
 * doubled or halved; so is it where a step is taken in halves. Muscles run in parallel, each one in one thread and in row order, so that
 * the bits do not depend on the number of threads.
 */
#ifndef SINEW_SIM_H
#define SINEW_SIM_H

#include "sinew/numeric.h"
#include "sinew/scene.h"
#include "sinew/thread.h"
#include "sinew/trace.h"

/* ---- the plan: what runs, what was left out, and why ------------------------------------------------------------------ */

/* The kinds of rows, in the order in which the guarded scheme projects them, and everybody tells of them: SN_ROWS_ID, and the name. A new
 * kind is one line here, and one source with its sn_row_ops (lib/sim/rows.h). The membrane, of `qn` only, runs in place of the mesh's rows.
 */
#define SN_ROW_LIST(X)                                                                                                                     \
    X(INTERNAL, internal)                                                                                                                  \
    X(RADIAL, radial)                                                                                                                      \
    X(MESH, mesh)                                                                                                                          \
    X(DIHEDRAL, dihedral)                                                                                                                  \
    X(AREA, area)                                                                                                                          \
    X(MEMBRANE, membrane)                                                                                                                  \
    X(VOLUME, volume)                                                                                                                      \
    X(EXTERNAL, external)                                                                                                                  \
    X(CONTACT, contact)

/* By the list. */
typedef enum sn_row_kind {
#define SN_ROW_KIND(id, name) SN_ROWS_##id,
    SN_ROW_LIST(SN_ROW_KIND)
#undef SN_ROW_KIND
        SN_ROW_KINDS
} sn_row_kind;
#define SN_DISTANCE_KINDS 3 /* the first three are distances */

/* Why a group of rows does not run. */
typedef enum sn_left_out {
    SN_RUNS,             /* not left out */
    SN_OUT_NO_STIFFNESS, /* its stiffness is 0 at every activation */
    SN_OUT_SETTING,      /* the scene switches it off */
    SN_OUT_SCHEME,       /* the scheme has no such rows */
    SN_OUT_MEMBRANE,     /* the membrane takes its place */
    SN_OUT_NO_STRUCTURE, /* the document has no internal structure */
    SN_OUT_OPEN_SURFACE, /* an open surface encloses no volume */
    SN_OUT_FLAT,         /* the rest volume is 0 */
    SN_OUT_NO_BONE,      /* no bone comes near it over the motion */
    SN_OUT_NO_TARGET,    /* the document has no candidates for them, or none whose target takes part */
    SN_OUT_NOTHING       /* no row is left: every point is carried by a bone, or degenerate at rest */
} sn_left_out;

/* One group of rows of one muscle. */
typedef struct sn_plan_group {
    sn_left_out reason;  /* SN_RUNS, or why it does not */
    sn_index rows;       /* that run */
    int sweeps;          /* over them in an iteration */
    sn_index kinematic;  /* rows left out because every point of theirs is carried by a bone */
    sn_index degenerate; /* rows left out because their rest shape has no length or no area (guards below) */
    size_t bytes;        /* of the rows, in model and state */
    double rigidity[2];  /* distances: k h^2 w relaxed and active, w of the mean point; far above 1 the rows are rigid, whatever k is */
} sn_plan_group;

/* One muscle of the scene. */
typedef struct sn_plan_muscle {
    const char *name;                      /* the scene's */
    bool enabled;                          /* false: nothing of it is in the model */
    bool fibers;                           /* false: no fibre directions, so that it does not contract */
    sn_index vertices, samples, triangles; /* that are in the model; samples: those on which a vertex hangs */
    sn_index bare_samples;                 /* of the structure, left out: no vertex hangs on them */
    sn_index kinematic;                    /* vertices carried by bones */
    sn_index iterations;                   /* per substep */
    sn_plan_group groups[SN_ROW_KINDS];    /* by sn_row_kind */
    sn_index bone_count;                   /* contact: bones and surfaces that come near it over the motion */
    sn_index *bones;                       /* (bone_count) as sn_scene_touched_name counts them; owned */
    sn_index overlaps;                     /* contact: rows whose points are inside of a bone at rest */
    double overlap;                        /* m: the deepest of them */
    sn_index ties_inside;                  /* external: vertices that lie in what they slide on at rest */
    double deepest_tie;                    /* m: the deepest of them */
    size_t model_bytes, state_bytes;       /* of its arrays and structs, the back end's scratch by point among them; without curves' knots,
                                              what muscles share (fields of bones) and the matrix of `qn` (sn_trial_matrix_bytes) */
} sn_plan_muscle;

/* What a scene comes to; owned by the model. */
typedef struct sn_plan {
    sn_index muscle_count;
    sn_plan_muscle *muscles; /* (muscle_count) one per muscle of the scene, disabled ones too */
} sn_plan;

/* What a picture or a table needs to know of a kind. */
typedef struct sn_row_info {
    const char *name;   /* "internal", "radial", "mesh", "dihedral", "area", "membrane", "volume", "external", "contact" */
    const char *errors; /* what its errors are, and their unit: "error of surface edges, mean edges" */
    const char *lacks;  /* what a row whose error is not a number lacks: "no angle" */
    int points;         /* of a row; 0 = all vertices, in one row */
    bool inside;        /* rows of the internal structure: lines inside of the surface */
    bool spring;        /* distances: their rigidity is told (sn_plan_group) */
} sn_row_info;
const sn_row_info *sn_row_info_of(sn_row_kind kind);
const char *sn_row_kind_name(sn_row_kind kind);
const char *sn_left_out_text(sn_left_out reason); /* half a sentence; "" for SN_RUNS */

/* ---- the constraint table --------------------------------------------------------------------------------------------- */

/* Two points: C = |x0 - x1| - sigma. */
typedef struct sn_distance_row {
    sn_index point[2]; /* of the muscle */
} sn_distance_row;

/* The two triangles (a,b,c) and (b,a,d) at edge a-b: C = wrap(theta - theta0). */
typedef struct sn_hinge_row {
    sn_index point[4]; /* a, b, c, d */
} sn_hinge_row;

/* A triangle: J = |n| / (2 A0) >= the scene's least area. */
typedef struct sn_area_row {
    sn_index point[3]; /* of the surface, counter-clockwise from outside */
} sn_area_row;

/* The square of a goal length is a sum of terms (of the row) times factors (of the activation); see distance.c. */
#define SN_LAW_TERMS 3

/* An edge of a closed surface: its ends; the triangle that runs from the first to the second, and the other. */
typedef struct sn_skin_edge {
    sn_index at[4];
} sn_skin_edge;

/* Vertices that move with one bone or joint, rigidly, or with a surface, each by its follower: kinematic_points[begin .. end - 1]. */
typedef struct sn_site {
    sn_index joint;          /* SN_NONE = the bone never moves, or it is a surface */
    sn_index surface;        /* of the scene; SN_NONE = it is a bone */
    bool frozen;             /* all of the muscle's vertices, as its track has them */
    sn_index begin, end;     /* of kinematic_points */
    sn_index first_follower; /* surface or frozen: that of kinematic_points[begin] */
    sn_index middle;         /* surface: the follower nearest to the centre, whose tangent frame is the site's pose */
    sn_vec3 centre;          /* mean rest position, m */
} sn_site;

/* The terms of one row's goal length, m^2. */
typedef double sn_goal_terms[SN_LAW_TERMS];

/* Is an array of the model there whenever its count is above 0, or may an option leave it out? Must it be the same for a state to fit? */
enum { SN_PRESENT = false, SN_NULLABLE = true };
enum { SN_UNFITTED = false, SN_FITTED = true };

/* Arrays of one muscle's model: type, name, count in terms of `m` (the muscle), may it be NULL, does a state have to fit it. Each is as
 * long as its count once the model is made. Factors of rows: NULL = 1 for all. */
#define SN_MODEL_ARRAYS(X)                                                                                                                 \
    X(sn_index, samples, m->point_count - m->vertex_count, SN_PRESENT, SN_UNFITTED) /* which of the structure's a point stands for */      \
    X(sn_vec3, rest, m->point_count, SN_PRESENT, SN_FITTED)                         /* m */                                                \
    X(double, inverse_mass, m->point_count, SN_PRESENT, SN_FITTED)                  /* 1/kg; 0 = carried by a bone */                      \
    X(sn_triangle, triangles, m->triangle_count, SN_PRESENT, SN_UNFITTED)           /* of the surface */                                   \
    X(double, rest_area, m->triangle_count, SN_PRESENT, SN_UNFITTED)                /* m^2 */                                              \
    X(sn_index, kinematic_points, m->kinematic_count, SN_PRESENT, SN_UNFITTED)      /* carried by bones; grouped by site */                \
    X(double, kinematic_mass, m->kinematic_count, SN_PRESENT, SN_UNFITTED) /* kg, by which they weigh in the motion of the bones */        \
    X(sn_site, sites, m->site_count, SN_PRESENT, SN_UNFITTED)              /* one per attachment with vertices */                          \
    X(sn_follower, followers, m->follower_count, SN_PRESENT,                                                                               \
      SN_UNFITTED) /* of those kinematic points that go with a surface; of a frozen muscle: not used */                                    \
    /* distances of all three kinds; factors on the stiffness (1 over it), on the correction ([K21] 3.1, PBD form), and the share of the   \
     * contraction by the activation map; pairs: those of batch b of a kind are at distance_start[kind] / 4 + b */                         \
    X(sn_distance_row, distances, m->distance_start[SN_DISTANCE_KINDS], SN_PRESENT, SN_FITTED)                                             \
    X(sn_goal_terms, distance_terms, m->distance_start[SN_DISTANCE_KINDS], SN_PRESENT, SN_UNFITTED)                                        \
    X(double, distance_softness, m->distance_start[SN_DISTANCE_KINDS], SN_NULLABLE, SN_UNFITTED)                                           \
    X(double, distance_gain, m->distance_start[SN_DISTANCE_KINDS], SN_NULLABLE, SN_UNFITTED)                                               \
    X(double, distance_share, m->distance_start[SN_DISTANCE_KINDS], SN_NULLABLE, SN_UNFITTED)                                              \
    X(bool, distance_pairs, m->distance_start[SN_DISTANCE_KINDS] / 4, SN_NULLABLE, SN_UNFITTED)                                            \
    /* hinges: theta0, rad; 1 / factor on the stiffness */                                                                                 \
    X(sn_hinge_row, hinges, m->hinge_count, SN_PRESENT, SN_FITTED)                                                                         \
    X(double, hinge_angles, m->hinge_count, SN_PRESENT, SN_UNFITTED)                                                                       \
    X(double, hinge_softness, m->hinge_count, SN_NULLABLE, SN_UNFITTED)                                                                    \
    X(bool, hinge_pairs, m->hinge_batched / 4, SN_NULLABLE, SN_UNFITTED)                                                                   \
    /* least areas: 1 / (2 A0), 1/m^2 */                                                                                                   \
    X(sn_area_row, areas, m->area_count, SN_PRESENT, SN_UNFITTED)                                                                          \
    X(double, area_scales, m->area_count, SN_PRESENT, SN_UNFITTED)                                                                         \
    X(bool, area_pairs, m->area_batched / 4, SN_NULLABLE, SN_UNFITTED)                                                                     \
    /* skin (lib/sim/skin.c), under `qn`: edges, those with a mesh row first and in its order; factors on the stiffness of springs and     \
     * hinges (0 = none), rest angles; of each triangle: the edge opposite to each corner; its row of area, or SN_NONE, and that's scale   \
     */                                                                                                                                    \
    X(sn_skin_edge, skin_edges, m->skin_edge_count, SN_PRESENT, SN_UNFITTED)                                                               \
    X(double, skin_springs, m->skin_edge_count, SN_PRESENT, SN_UNFITTED)                                                                   \
    X(double, skin_hinges, m->skin_edge_count, SN_PRESENT, SN_UNFITTED)                                                                    \
    X(double, skin_angles, m->skin_edge_count, SN_PRESENT, SN_UNFITTED)                                                                    \
    X(sn_triangle, skin_sides, m->skin_triangle_count, SN_PRESENT, SN_UNFITTED)                                                            \
    X(sn_index, skin_area_rows, m->skin_triangle_count, SN_PRESENT, SN_UNFITTED)                                                           \
    X(double, skin_area_scales, m->skin_triangle_count, SN_PRESENT, SN_UNFITTED)

/* One muscle, immutable. Points are the surface vertices in document order, then the samples on which a vertex hangs. */
typedef struct sn_model_muscle {
    const sn_scene_muscle *source; /* in the scene */
    sn_index group, member;        /* of the model; the muscle's place in it */
#define SN_MODEL_MEMBER(type, name, count, nullable, fitted) type *name;
    SN_MODEL_ARRAYS(SN_MODEL_MEMBER)
#undef SN_MODEL_MEMBER
    sn_index vertex_count, point_count, triangle_count; /* of the surface; with the samples */
    sn_index kinematic_count, site_count;               /* points that bones carry, and by how many attachments */
    sn_index external_count;                            /* vertices that external constraints tie to something */
    sn_index collider_count, contact_count;             /* bones and surfaces that it may touch, and rows of contact */
    sn_index patch_points, patch_boxes, feet_count;     /* vertices and boxes of those surfaces; rows of contact with them, the last ones */
    sn_index follower_count, pose_count;                /* points that surfaces carry; where there are any: joints of the scene */
    sn_index distance_start[SN_DISTANCE_KINDS + 1];     /* rows of kind k are distance_start[k] .. distance_start[k + 1] - 1 */
    sn_index distance_batched[SN_DISTANCE_KINDS];       /* so many of each kind come first, in fours that share no point */
    sn_index hinge_count, hinge_batched;                /* rows; those that come first, in fours */
    sn_index area_count, area_batched;                  /* the same */
    sn_index skin_edge_count, skin_triangle_count;      /* edges and triangles that are evaluated together; 0 = the muscle has no skin */
    void *own[SN_ROW_KINDS];                            /* rows that only their own kind reads */
    bool keeps_volume;                                  /* the volume row runs */
    double rest_volume;                                 /* V0, m^3; NaN for an open or flat surface */
    sn_curve *stiffness_curve;                          /* ln k over activation; NULL = straight from relaxed to active */
    sn_curve *volume_ratio;                             /* g(activation); NULL = 1 */
    double rest_ratio;                                  /* g(rest activation) */
    double mass;                                        /* kg, all points together */
    double mean_edge, diagonal;                         /* m */
    sn_index iterations;                                /* per substep */
    bool coupled;                                       /* its group has external constraints */
    bool contracts;                                     /* activation is felt: not under the scheme `kohout` */
    bool single;       /* projected in single precision; then, and only then, pairs: this four of rows and the next share no point */
    bool quasi_newton; /* the back end is `qn` */
    bool corotated;    /* qn: by the rest shape's Hessian, turned with the muscle, where the shape allows it */
    bool two_level;    /* qn: the scalar matrix and a coarse space of sections, where the shape allows it */
    double tolerance;  /* qn: stop when a whole step moves no point by more than this share of the diagonal */
} sn_model_muscle;

/* Muscles that are solved together (lib/sim/group.h). */
struct sn_group;

/* What a scene is made into once; a run never changes it. */
typedef struct sn_model {
    const sn_scene *scene;           /* the caller's */
    sn_plan plan;                    /* of all of its muscles */
    struct sn_contact_plan *contact; /* nullable: fields of bones (lib/sim/contact.h) */
    sn_index muscle_count;
    sn_model_muscle *muscles; /* (muscle_count) the enabled ones, in the scene's order */
    sn_index group_count;
    struct sn_group *groups; /* (group_count) each muscle is in one of them */
    double frame_duration;   /* s */
    double substep_duration; /* h, s */
    bool halves;             /* qn: a muscle may take a substep in halves, and those again */
} sn_model;

/* Makes the distance field of a bone (sn_distance_field_create), or takes it from somewhere: mesh in metres. */
struct sn_distance_field;
struct sn_distance_field_params;
struct sn_voxels;
typedef sn_status sn_field_source(void *user, const sn_scene_bone *bone, const sn_mesh *mesh, const struct sn_distance_field_params *params,
                                  struct sn_distance_field *out, sn_error *error);

typedef struct sn_model_options {
    sn_pool *pool;           /* nullable: one thread */
    sn_field_source *fields; /* nullable: they are made */
    void *user;              /* of fields */
} sn_model_options;

/* Validate the scene, plan, build every row. The scene must outlive the model and keep still. Contact needs the meshes of the bones. */
SN_MUST_CHECK sn_status sn_model_create(const sn_scene *scene, sn_model **out, sn_error *error);
SN_MUST_CHECK sn_status sn_model_create_with(const sn_scene *scene, const sn_model_options *options, sn_model **out, sn_error *error);
/* The distance field of a bone of the scene; NULL = contact is off, or no muscle comes near it. */
const struct sn_distance_field *sn_model_field(const sn_model *model, sn_index bone);
/* The voxels of a bone; NULL = the same, or the collision is not by voxels. */
const struct sn_voxels *sn_model_voxels(const sn_model *model, sn_index bone);
/* The name of statistics.entered_target of a muscle of this model (by its place in model.muscles). */
const char *sn_model_target_name(const sn_model *model, sn_index muscle, sn_index target);
/* How many triangles of a surface of the scene may touch one of its muscles. */
sn_index sn_model_patch_size(const sn_model *model, sn_index muscle, sn_index surface);
void sn_model_destroy(sn_model *model); /* NULL is fine */

/* ---- statistics: numbers, not text -------------------------------------------------------------------------------------- */

/* Of |C| over the rows of one kind. */
typedef struct sn_residual {
    double rms, max; /* root mean square, greatest */
    sn_index worst;  /* row of its kind; SN_NONE = there is none */
} sn_residual;

/* Why a substep of back end `qn` ended. */
typedef enum sn_stop_reason {
    SN_STOP_ITERATIONS, /* after all of its iterations */
    SN_STOP_TOLERANCE,  /* a whole step was below the tolerance */
    SN_STOP_STALLED,    /* no step lowered the energy: it is at its minimum to rounding */
    SN_STOP_FAILED      /* the matrix could not be factored or solved (no memory, a number that is not finite) */
} sn_stop_reason;
const char *sn_stop_reason_name(sn_stop_reason reason); /* "iterations", "tolerance", "stalled", "failed" */

/* Of one muscle at one moment. Errors of lengths are over the mean edge, of angles in radians, of the volume over V0. */
typedef struct sn_statistics {
    double activation, contraction;      /* the input in [0,1]; a = contraction x activation */
    double stiffness;                    /* k, N/m */
    double volume_ratio;                 /* V / V0; NaN for an open surface */
    double volume_goal;                  /* g(a) / g(a0) */
    double volume_error;                 /* V / (goal V0) - 1 */
    sn_residual residuals[SN_ROW_KINDS]; /* by sn_row_kind */
    double smallest_triangle;            /* least area over rest area; NaN where no triangle has a rest area */
    sn_index smallest_triangle_index;    /* SN_NONE = none */
    double largest_edge_ratio;           /* greatest length over goal length of an edge of the surface, see SN_LEAST_GOAL; NaN = no edge */
    sn_index largest_edge[2];            /* its vertices, of equal ones the first; SN_NONE = none */
    sn_index contacts;                   /* rows of contact that push */
    double overlap;                      /* m: how deep the deepest vertex is in a bone, at rest or not; 0 = none is */
    double penetration;                  /* m: how much deeper than at rest the deepest vertex is in a bone; 0 = none is */
    sn_index penetration_vertex, penetration_bone; /* which that is, and of what (sn_scene_touched_name); SN_NONE = none */
    double entered; /* m: how much deeper than at rest the deepest tied vertex is in what it is tied to; 0 = none is */
    sn_index entered_vertex, entered_target; /* which that is, and of what (sn_model_target_name); SN_NONE = none */
    bool torn;                      /* far from any shape of rest (SN_FAR_...) now or, under qn, where a substep of the frame began */
    double residual;                /* |dPhi/dx| / (k L) of the last substep, Phi = |x - y|^2_M / (2 h^2) + E; NaN inside a substep */
    double kinetic_energy;          /* J */
    double elastic_energy;          /* J: sum of k C^2 / 2 over the rows, as if none were rigid */
    sn_index nan_points, first_nan; /* points whose position is not finite; the first of them or SN_NONE */
    bool asleep;                    /* at rest, with inputs that keep still: it was not stepped */
    int64_t skipped_edges, skipped_hinges; /* projections in the last frame that a guard left out */
    int64_t clamped_hinges;                /* and that the dihedral clamp limited */
    int64_t held_triangles;                /* projections of triangles below their least area */
    int64_t skipped_triangles;             /* and those of triangles without a plane, which a guard left out */
    /* back end `qn`, over the last frame; zero under xpbd */
    int64_t iterations, rejected_steps, refactorisations; /* steps: those that would have raised the energy */
    int64_t steps;                                        /* under xpbd too: substeps, or the parts in which they were taken */
    int64_t halvings;                                     /* steps that were too long, and were given up for two of half the length */
    int64_t leaps;         /* steps, the shortest there are, in which a bone still went too far for contact: it may have passed through */
    int64_t torn_substeps; /* that began torn */
    int64_t restarts;      /* wrecked shapes that were given up for the rest pose, carried along with the bones */
    sn_stop_reason stop_reason; /* of the last substep */
} sn_statistics;

/* The edges of the surface are those of the rows SN_ROWS_MESH; under the membrane those of its triangles, against the goal shape; where
 * neither runs, all of them against their rest lengths. A goal below this share of the mean edge counts as this long: an edge that is
 * (nearly) to vanish has no ratio of its own, and is too long where the mean edge would be. An edge whose length is NaN does not count. */
#define SN_LEAST_GOAL 0.1

/* An edge of the surface as far as the first from its goal, in mean edges (or such a strain of the membrane), or all of them as far as the
 * second in the root mean square: the muscle is torn. */
#define SN_FAR_STRETCHED 3.0
#define SN_FAR_IN_THE_MEAN 0.5

/* What no muscle does: signs that a run has exploded, as bits. */
typedef enum sn_explosion {
    SN_EXPLODED_POINTS = 1, /* a coordinate is not finite */
    SN_EXPLODED_VOLUME = 2, /* the volume is off its goal by more than SN_EXPLODED_VOLUME_ERROR; whether or not the volume is kept */
    SN_EXPLODED_EDGE = 4,   /* an edge of the surface is longer than SN_EXPLODED_EDGE_RATIO times its goal */
    SN_EXPLODED_SOLVER = 8  /* qn: the last step failed (SN_STOP_FAILED): the free points are where inertia, or nothing, has put them */
} sn_explosion;
#define SN_EXPLODED_VOLUME_ERROR 0.5
#define SN_EXPLODED_EDGE_RATIO 10.0
/* The bits of sn_explosion that hold; 0 = none. */
unsigned sn_explosions(const sn_statistics *statistics);

/* ---- the state ------------------------------------------------------------------------------------------------------------ */

/* Position and inverse mass side by side: one record of 32 bytes is what a projection reads and writes. */
typedef struct sn_point {
    double x, y, z, w; /* m; 1/kg */
} sn_point;

/* Without its mass. */
static inline sn_vec3 sn_point_position(const sn_point *p) { return sn_v3(p->x, p->y, p->z); }

struct sn_inputs;
/* One muscle of a run: its part of the points of its group, what it is told of the step at hand (lib/sim/state.h), what its back end
 * remembers of it, and what can be said of it. */
typedef struct sn_muscle_state {
    sn_point *points;         /* (point_count) */
    sn_vec3 *velocities;      /* (point_count) m/s */
    sn_vec3 *previous;        /* (point_count) m: where the step at hand began, or room for other use after it */
    struct sn_inputs *inputs; /* of the step at hand, or of the last one */
    void *memory;             /* the back end's own; nullable */
    sn_statistics statistics; /* at the end of the last step */
} sn_muscle_state;

/* A run: of the model that it was made for, which is handed in beside it. */
typedef struct sn_state {
    sn_index frame;                /* the frame that the state has reached, or is in the middle of */
    sn_index substep;              /* where it was stopped in the middle of `frame`: substeps done; 0 = all of them */
    sn_index iteration;            /* and iterations of the substep after those; 0 = none */
    sn_muscle_state *muscles;      /* (model.muscle_count) */
    struct sn_group_state *groups; /* (model.group_count) lib/sim/state.h */
    sn_rigid *poses;               /* (substeps x joints) of the frame being stepped */
} sn_state;

/* Arrays for every muscle of the model, put at the first frame (sn_state_reset). */
SN_MUST_CHECK sn_status sn_state_create(const sn_model *model, sn_state **out, sn_error *error);
void sn_state_destroy(const sn_model *model, sn_state *state); /* NULL is fine */
/* The first frame, before any pre-roll: at rest where that has a run-in; else carried along where the first frame's bones are away from
 * their rest place (each point by the poses of its muscle's bones, weighted by the inverse square of its distance to each bone's
 * attachment). */
void sn_state_reset(const sn_model *model, sn_state *state);
/* Positions of a muscle's surface vertices in its document's unit and order: positions (vertex_count). */
void sn_state_positions(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *positions);

/* ---- stop and go on (restart.c) ------------------------------------------------------------------------------------------- */

/* The state as bytes (malloc'ed, the caller frees), with version and checksum, at the end of a frame or in the middle of it. */
SN_MUST_CHECK sn_status sn_state_pack(const sn_model *model, const sn_state *state, char **bytes, size_t *size, sn_error *error);
/* Back into a state of the same model. SN_ERROR_INPUT where the bytes are damaged or forged (a number that no run comes to, whatever the
 * checksum says) or another model's: the state is as it was. Of any frame: that it is one of the scene's is for the caller to ask. */
SN_MUST_CHECK sn_status sn_state_unpack(const sn_model *model, const char *bytes, size_t size, sn_state *state, sn_error *error);
/* The frame that the next step ends: the state's own where it was stopped in the middle of it, else the one after. */
sn_index sn_state_next_frame(const sn_state *state);

/* ---- stepping ------------------------------------------------------------------------------------------------------------- */

/* Looks at the muscles during a run-in; share: of the way to the first frame's poses, in (0,1]. Another status than SN_OK ends it. */
typedef sn_status sn_watch_run_in(void *user, const sn_state *state, double share, sn_error *error);

/* How far to step, and who watches. */
typedef struct sn_step_options {
    sn_pool *pool;           /* nullable: one thread */
    sn_trace *trace;         /* nullable: one step per substep and muscle, with its residuals */
    sn_index stop_substep;   /* 1..substeps: stop after this substep of the frame; 0 = do all */
    sn_index stop_iteration; /* with stop_substep: after this iteration in it; 0 = all */
    sn_watch_run_in *watch;  /* nullable: sn_settle */
    void *user;              /* of watch */
} sn_step_options;

/* The scene's pre-roll: whole substeps, rounded up, with the bones and activations of the first frame; in its run-in (sn_scene_runs_in) the
 * bones come from rest, by the smoothstep of its time. options->watch sees the muscles whenever a frame's time of the run-in is over, and
 * at its end. What is done counts for the first frame. A pre-roll that the trace or the watch has stopped does not go on. */
SN_MUST_CHECK sn_status sn_settle(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error);
/* The time of one frame passes with the bones and activations of the state's frame, whose number stays. */
SN_MUST_CHECK sn_status sn_hold(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error);
/* From frame state->frame to the next; or, from a state that was stopped in the middle of its frame, to the end of that frame, with the
 * bits of a run that was not stopped. SN_STOPPED: stopped on the way, by the options or the trace. options NULL = none. */
SN_MUST_CHECK sn_status sn_step(const sn_model *model, sn_state *state, const sn_step_options *options, sn_error *error);

/* Project the rows of one kind of a muscle once, as the first iteration of a substep does under `xpbd`; under `qn` evaluate their energy
 * and its gradient: to measure what they cost. */
void sn_project(const sn_model *model, sn_state *state, sn_index muscle, sn_row_kind kind);

/* The matrix that a group goes by under `qn` (model->muscles[i].group), at rest and relaxed, as a thing of its own: what it costs can be
 * told before anything runs. A muscle that nothing ties to others has a group of its own. */
typedef struct sn_trial_matrix sn_trial_matrix;
SN_MUST_CHECK sn_status sn_trial_matrix_create(const sn_model *model, sn_index group, sn_trial_matrix **out, sn_error *error);
/* Analyse and factor it; called again, factor it again. */
SN_MUST_CHECK sn_status sn_trial_matrix_factor(sn_trial_matrix *trial, sn_error *error);
/* One direction of a step, as an iteration asks for it. */
SN_MUST_CHECK sn_status sn_trial_matrix_solve(sn_trial_matrix *trial, sn_error *error);
int64_t sn_trial_matrix_entries(const sn_trial_matrix *trial); /* numbers in the factor */
/* Of the factor, the matrix it is made from, and what is solved with them: what a run holds beside the plan's state_bytes. */
size_t sn_trial_matrix_bytes(const sn_trial_matrix *trial);
void sn_trial_matrix_destroy(sn_trial_matrix *trial); /* NULL is fine */

/* ---- errors row by row (errors.c): what sn_residual is the sum of --------------------------------------------------------- */

/* Rows of a kind that run; of the volume 1 or 0. */
sn_index sn_row_count(const sn_model *model, sn_index muscle, sn_row_kind kind);
/* Whether any muscle has rows of kind `external`: it is tied to others, or to what moves by itself. */
bool sn_model_tied(const sn_model *model);
/* The points of a row. Returns how many (sn_row_info); 0 for the volume, which has all vertices. */
int sn_row_points(const sn_model *model, sn_index muscle, sn_row_kind kind, sn_index row, sn_index points[4]);
/* |C| of every row of a kind now: errors (sn_row_count), in the units of sn_statistics; NaN: a hinge that has no angle (its guard). */
void sn_row_errors(const sn_model *model, const sn_state *state, sn_index muscle, sn_row_kind kind, double *errors);
/* How far one rigid projection of the volume would move each vertex, w_i |dV/dx_i| |C| / sum w |dV/dx|^2, over the mean edge:
 * moves (vertex_count), zeros where no volume is kept; gradients (vertex_count) is scratch, and holds dV/dx then. */
void sn_volume_moves(const sn_model *model, const sn_state *state, sn_index muscle, sn_vec3 *gradients, double *moves);

/* Contact at the vertices (contact_show.c): what bones press with, Pa, under `qn` (else SN_ERROR_INPUT); how much deeper than at rest
 * vertices are in bones, m, 0 = not. Both (vertex_count). */
SN_MUST_CHECK sn_status sn_contact_pressures(const sn_model *model, const sn_state *state, sn_index muscle, double *pressures,
                                             sn_error *error);
void sn_contact_depths(const sn_model *model, const sn_state *state, sn_index muscle, double *depths);

/* ---- single constraints: value and gradients, for tests, pictures and other back ends ------------------------------------- */

/* Guards (numerics.md 5): an edge with l^2 below the first has no direction; a hinge with |n|^2 <= the second x |e|^4 has no angle. */
#define SN_EDGE_GUARD 1e-24
#define SN_HINGE_GUARD 1e-12
/* A triangle with J^2 below this has no plane to be opened in. */
#define SN_AREA_GUARD 1e-24
/* A dihedral error beyond this is projected as this: it removes the blow-ups (numerics.md 2). Radians. */
#define SN_HINGE_CLAMP 0.3

/* C = |p0 - p1| - goal, gradients[i] = dC/dp_i; false where the guard holds (then nothing is written). */
bool sn_distance_constraint(sn_vec3 p0, sn_vec3 p1, double goal, double *value, sn_vec3 gradients[2]);
/* C = wrap(theta - rest), theta = atan2((n1 x n2).e, n1.n2), n1 = (a-c) x (b-c), n2 = (b-d) x (a-d); p = {a,b,c,d}; false: guard. */
bool sn_hinge_constraint(const sn_vec3 p[4], double rest, double *value, sn_vec3 gradients[4]);
/* C = |n| / (2 rest_area) - least; unilateral: it is projected where C < 0 only; false: guard. */
bool sn_area_constraint(const sn_vec3 p[3], double rest_area, double least, double *value, sn_vec3 gradients[3]);
/* [K21] eq. 9 with the absolute value that it leaves out: 1 - |u.v|, u and v of any length; 1 where one of them vanishes. */
double sn_anisotropy_factor(sn_vec3 edge, sn_vec3 fiber);
/* V = 1/6 sum p_i . (p_j x p_k) relative to the mean point; gradients (vertex_count, nullable) are dV/dp_i. */
double sn_volume_constraint(sn_index vertex_count, const sn_point *points, sn_index triangle_count, const sn_triangle *triangles,
                            sn_vec3 *gradients);
/* Goal length of a distance row with these terms at contraction a (of rest contraction a0) and goal volume ratio g. */
double sn_goal_length(sn_fiber_law law, const double terms[SN_LAW_TERMS], double a, double a0, double g);
/* Terms of an edge e (m) with fibre axes f1, f2 at its ends (unit, or zero where there is none), for rest contraction a0. */
void sn_law_terms(sn_fiber_law law, sn_vec3 edge, sn_vec3 f1, sn_vec3 f2, double a0, double terms[SN_LAW_TERMS]);

#endif
