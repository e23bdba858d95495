/*
 * scene.h -- bones + muscles + motion + solver settings. Plain data, everything owned by the scene.   rank 2
 *
 * Meshes of bones and muscles are as in their files (document units, with meters_per_unit); times in seconds, angles in radians.
 */
#ifndef SINEW_SCENE_H
#define SINEW_SCENE_H

#include "sinew/motion.h"
#include "sinew/muscle.h"
#include "sinew/scene_surface.h"

/* Names of the values of an enumeration, in its order, NULL at the end: one table for documents, settings in text and options. */
extern const char *const sn_fiber_law_names[];       /* "projected", "paper", "isochoric" */
extern const char *const sn_anisotropy_names[];      /* "scheme", "none", "pbd", "xpbd" */
extern const char *const sn_stretch_names[];         /* "springs", "membrane" */
extern const char *const sn_solver_method_names[];   /* "xpbd", "qn" */
extern const char *const sn_scheme_names[];          /* "guarded", "romeo", "kohout" */
extern const char *const sn_hinge_rule_names[];      /* "scheme", "published", "printed" */
extern const char *const sn_preconditioning_names[]; /* "scalar", "corotated", "two-level" */
extern const char *const sn_precision_names[];       /* "double", "single" */
extern const char *const sn_collision_names[];       /* "scheme", "field", "voxel" */
extern const char *const sn_bone_hits_names[];       /* "follow", "stop", "ignore" */

typedef struct sn_scene_bone {
    char *name;
    char *uri;              /* as written in the document */
    double meters_per_unit; /* of the mesh */
    bool unit_certain;      /* the document has told it, or the mesh was loaded, whose file may tell another than is taken without */
    sn_mesh mesh;           /* empty until loaded: a run that needs no bone surface never loads one */
    sn_space space;         /* that its file says, once loaded */
    sn_index joint;         /* SN_NONE = never moves */
    bool passable;          /* no muscle feels it; default false */
} sn_scene_bone;

/* How muscles are kept out of bones. FIELD: rows on distance fields. VOXEL: the voxels of [K21] and its two rules, under `xpbd` only.
 * SCHEME: VOXEL under the scheme `kohout`, else FIELD. */
typedef enum sn_collision { SN_COLLISION_SCHEME, SN_COLLISION_FIELD, SN_COLLISION_VOXEL } sn_collision;

/* VOXEL: what becomes of a vertex onto which a bone has moved. FOLLOW: it goes along with the bone, as [K21] 3.2 has it; STOP: it does, and
 * has no velocity then (5); IGNORE: nothing (fig. 10). */
typedef enum sn_bone_hits { SN_BONE_HITS_FOLLOW, SN_BONE_HITS_STOP, SN_BONE_HITS_IGNORE } sn_bone_hits;

#define SN_DEFAULT_VOXELS 64 /* along each axis: [K21] fig. 3 */

/* Contact of muscles with bones (bodies.md 2); off by default. */
typedef struct sn_contact_settings {
    bool enabled;
    double margin;    /* m, that vertices keep from bones; 0 = a tenth of the muscle's mean edge. What is nearer at rest may stay as near */
    double cell;      /* m, of the bones' distance fields; 0 = a third of the finest mean edge in reach, or a sixth of the bone's
                         thickness */
    double friction;  /* Coulomb's, under `xpbd`; default 0 */
    double resolve;   /* s, in which margins grow to what is asked where muscles overlap bones at rest; default 0: they stay */
    sn_index samples; /* points inside of each triangle that are held out, too: 0 (default), 1 or 3 */
    sn_collision collision;
    sn_bone_hits bone_hits;
    sn_index voxels;       /* of each bone's box, along each axis; 0 = SN_DEFAULT_VOXELS */
    sn_index voxels_total; /* or about so many in all, as near to cubes as that goes: n_max of [K21] 3.2; 0 = by `voxels` */
} sn_contact_settings;

#define SN_EXTERNAL_STIFFNESS 10.0 /* over that of the muscle's edges (bodies.md 3) */

/* External constraints ([R18] 4.3) of the candidates in the rigs; off by default. */
typedef struct sn_external_settings {
    bool enabled;
    double stiffness;                            /* over that of the muscle's edges; 0 to 1e12; default SN_EXTERNAL_STIFFNESS */
    bool no_slide, no_soft, no_hard, no_minimum; /* such rows are left out */
    double resolve;                              /* s, in which what lies in its target at rest comes out; default 0: it stays */
} sn_external_settings;

/* How a fibre shortens its edges with activation: the goal lengths of sn_goal_length (sim.h). */
typedef enum sn_fiber_law { SN_LAW_PROJECTED, SN_LAW_PAPER, SN_LAW_ISOCHORIC } sn_fiber_law;

/* [K21] 3.1: an edge along the fibres yields. k = 1 - |u.v| (edge and fibre direction) multiplies the correction (PBD form) or the
 * stiffness (XPBD form) of the surface edges. SCHEME: the PBD form under the scheme `kohout`, else none. */
typedef enum sn_anisotropy { SN_ANISOTROPY_SCHEME, SN_ANISOTROPY_NONE, SN_ANISOTROPY_PBD, SN_ANISOTROPY_XPBD } sn_anisotropy;

/* What resists the stretching of the surface: springs along its edges, the papers' model; or a neo-Hookean membrane (numerics.md 9). */
typedef enum sn_stretch { SN_STRETCH_SPRINGS, SN_STRETCH_MEMBRANE } sn_stretch;

/* A graph of knots (x ascending); 0 knots = the default of its use. */
typedef struct sn_knots {
    sn_index count;
    double *x, *y;
} sn_knots;

typedef struct sn_scene_muscle {
    char *name;
    char *uri;
    sn_muscle rig;
    sn_channel activation;  /* in [0,1] */
    double contraction;     /* a = contraction x activation; in [0,0.99]; default 0.5 */
    double rest_activation; /* a0 = contraction x rest_activation; in [0,1]; default 0 */
    double tone;            /* no activation is below this; in [0,1]; default 0 */
    double rest_length;     /* of the fibres, over the one they have in the rest shape: 0.9 = they would be a tenth shorter if nothing held
                               them (bodies.md 4); in [0.1,1]; default 1 */
    sn_fiber_law law;
    sn_stretch stretch;        /* default springs; membrane under `qn` only, and not with the law `paper` */
    double stiffness_relaxed;  /* N/m, default 5e5: interpolated to active in log scale by activation; 0 = none at all */
    double stiffness_active;   /* N/m, default 5e7 */
    double stiffness_internal; /* factor on the stiffness of internal and radial rows; default 1; 0 = no internal structure */
    double stiffness_dihedral; /* k_b / k in m^2: hinge stiffness over edge stiffness; default 7.5e-5; 0 = none */
    double stiffness_volume;   /* k_V V0 / k: default 4000; 0 = none */
    bool stiffness_scaled;     /* edges and hinges by the area beside them (numerics.md 9); default true */
    sn_knots stiffness_curve;  /* activation in [0,1] -> N/m, in log scale; 0 knots = straight from relaxed to active */
    char *activation_map;      /* vertex attribute of the rig's mesh in [0,1]: share of the contraction; NULL = 1 everywhere */
    char *tendon_map;          /* vertex attribute in [0,1]: 1 = tendon, which does not contract; NULL = muscle everywhere */
    char *stiffness_map;       /* vertex attribute above 0: factor on the stiffness of distances; NULL = 1 everywhere */
    sn_anisotropy anisotropy;
    double least_area;      /* no triangle below this share of its rest area; in [0,1); default 0.5; 0 = no such rows */
    sn_knots volume_ratio;  /* activation in [0,1] -> goal volume over rest volume; default 1 */
    double density;         /* kg/m^3; default 1060 */
    bool unit_mass;         /* every point 1 kg, whatever the density; default false */
    double damping;         /* rate, 1/s, of the velocity beside the rigid motion of the bones; weight is not damped; default 5 */
    sn_index iterations;    /* per substep; 0 = the solver's */
    bool enabled;           /* false = left out */
    bool untouched;         /* no bone is felt; default false */
    bool unbound;           /* none of its external constraints acts, and none of others on it; default false */
    sn_vertex_track frozen; /* where all of its vertices are over time, m; no samples (default): it is simulated */
    bool unseen;            /* there for the others: neither logged nor written; default false */
} sn_scene_muscle;

/* QN is the default: the error for the time is less (error-time). */
typedef enum sn_solver_method { SN_SOLVER_XPBD, SN_SOLVER_QN } sn_solver_method;

/* How `xpbd` goes about it: guarded is sinew's own; the others are the papers', to the letter ([R18] alg. 1, [K21] alg. 2). */
typedef enum sn_scheme { SN_SCHEME_GUARDED, SN_SCHEME_ROMEO, SN_SCHEME_KOHOUT } sn_scheme;

/* What the scheme `kohout` does at a hinge. PUBLISHED: as the program of its authors does; PRINTED: by the paper's equations, bounded.
 * SCHEME: PUBLISHED under `kohout`; the other schemes have their own and no choice. */
typedef enum sn_hinge_rule { SN_HINGES_SCHEME, SN_HINGES_PUBLISHED, SN_HINGES_PRINTED } sn_hinge_rule;

/* The matrix that `qn` goes by (numerics.md 2, 7): one number for x, y and z of two points; the Hessian of the rest shape, turned with
 * the muscle; or the first and, beside it, the rigid motions of sections. */
typedef enum sn_preconditioning { SN_PRECONDITION_SCALAR, SN_PRECONDITION_COROTATED, SN_PRECONDITION_TWO_LEVEL } sn_preconditioning;

/* Of the projections under `xpbd`: single keeps points and inputs in double and projects in floats near the muscle's middle. */
typedef enum sn_precision { SN_PRECISION_DOUBLE, SN_PRECISION_SINGLE } sn_precision;

/* qn: one a frame, and where that is too long for a muscle it takes it in halves, and those again. */
#define SN_SUBSTEPS_AUTO 0

typedef struct sn_solver_settings {
    sn_solver_method method;
    sn_scheme scheme;
    sn_hinge_rule hinges; /* kohout; default SCHEME */
    sn_precision precision;
    sn_index substeps;   /* per frame; default 16 under xpbd, SN_SUBSTEPS_AUTO under qn */
    sn_index iterations; /* per substep; xpbd: default 2, since a single one lets rows that disagree pump energy into the muscle; qn: at
                            most this many, default 10 */
    double tolerance;    /* qn: a substep ends when a whole step moves no point by more than this share of the diagonal; default 1e-5 */
    sn_preconditioning preconditioner; /* qn; default scalar */
    int threads;                       /* 0 = all */
    bool sleep; /* a muscle at rest whose inputs keep still is not stepped; default true; moves nothing by 1e-9 of its size */
} sn_solver_settings;

/* Frames are numbered from -SN_FRAME_LIMIT to SN_FRAME_LIMIT: differences of two, and the one after, are sn_index too. */
#define SN_FRAME_LIMIT 100000000

typedef struct sn_scene {
    char *name;
    double meters_per_unit; /* of points and lengths in the scene document itself: hinges, key translations */
    sn_index bone_count;
    sn_scene_bone *bones;
    sn_index surface_count;
    sn_scene_surface *surfaces; /* (surface_count) envelopes and driven meshes */
    sn_index muscle_count;
    sn_scene_muscle *muscles;
    sn_motion motion;
    sn_contact_settings contact;
    sn_external_settings externals;
    sn_vec3 gravity;                  /* m/s^2; default 0 */
    double rate;                      /* frames per second; default 24 */
    sn_index first_frame, last_frame; /* inclusive; frame f is at time f / rate; default 0, 0 */
    double preroll;                   /* seconds of settling at the first frame's inputs before it; default 0 */
    double run_in;                    /* seconds of the pre-roll in which the bones first go from rest to the first frame; default 0 */
    sn_solver_settings solver;
} sn_scene;

/* What a muscle may be attached to, by name: it is sought among bones, surfaces, then joints, as a rigid part of which it moves. */
typedef enum sn_carrier_kind { SN_CARRIER_NONE, SN_CARRIER_BONE, SN_CARRIER_SURFACE, SN_CARRIER_JOINT } sn_carrier_kind;
typedef struct sn_carrier {
    sn_carrier_kind kind;
    sn_index index; /* of the scene's bones, surfaces, or its motion's joints */
} sn_carrier;
sn_carrier sn_scene_carrier(const sn_scene *scene, const char *name); /* name is nullable */
/* The name of a bone, or, from bone_count on, of a surface: whatever a muscle may touch. */
const char *sn_scene_touched_name(const sn_scene *scene, sn_index touched);
/* Is an enabled muscle attached to this surface, or tied to it by external constraints? */
bool sn_scene_surface_carries(const sn_scene *scene, sn_index surface);
/* Warn of loaded surfaces whose frames do not reach from the scene's first to its last. */
void sn_scene_warn_of_times(const sn_scene *scene);

void sn_scene_free(sn_scene *scene);
/* What a muscle's activation comes to at `time`, and how much its fibres shorten then, as a share of their length: 1 - rest_length (1 -
 * contraction x activation). */
double sn_muscle_activation(const sn_scene_muscle *muscle, double time);
double sn_muscle_contraction(const sn_scene_muscle *muscle, double activation);
void sn_scene_muscle_defaults(sn_scene_muscle *muscle); /* fills every default of an otherwise zeroed muscle */
void sn_scene_defaults(sn_scene *scene);
sn_solver_settings sn_solver_defaults(sn_solver_method method);
/* FIELD or VOXEL. */
sn_collision sn_scene_collision(const sn_scene *scene);
/* Does the pre-roll begin at rest and move bones? Not where the first frame is the rest pose, to the bit. */
bool sn_scene_runs_in(const sn_scene *scene);
sn_index sn_solver_substeps(const sn_solver_settings *settings); /* per frame, before any is halved */
/* To that method, with its defaults but the threads and the sleep there are; nothing where it is that method already. */
void sn_solver_change(sn_solver_settings *settings, sn_solver_method method);
/* Which muscles a run of some of them needs: wanted, needed (muscle_count). Those wanted, and what external constraints tie to them,
 * directly or over others; `nearest`: directly, and what these are tied to, as that may be nearer to them. */
SN_MUST_CHECK sn_status sn_scene_choose(const sn_scene *scene, const bool *wanted, bool nearest, bool *needed, sn_error *error);
/* Have a muscle go as a track of its vertices says, which the scene then owns: whatever is tied to it holds on to that. Nothing of its own
 * is stepped. SN_ERROR_INPUT: other vertices, a track that does not reach from the scene's first frame to its last,
 * or one whose attached vertices are not where the scene's bones take them. */
SN_MUST_CHECK sn_status sn_scene_freeze(sn_scene *scene, sn_index muscle, sn_vertex_track *track, sn_error *error);
/* Ranges, indices, names: SN_ERROR_INPUT naming bone or muscle and the value; attachments to what the scene lacks are an error, and so are
 * those to a surface that is not loaded. */
SN_MUST_CHECK sn_status sn_scene_validate(const sn_scene *scene, sn_error *error);

#endif
