/*
 * rows.h -- inside lib/sim: building the rows of one muscle, projecting them, measuring them. One source per constraint.
 */
#ifndef SN_SIM_ROWS_H
#define SN_SIM_ROWS_H

#include "state.h"

/* What the builders of one muscle's rows share. */
typedef struct sn_build {
    const sn_scene *scene;
    const sn_scene_muscle *source;
    const sn_topology *topology;
    sn_model_muscle *model;
    sn_plan_muscle *plan;
    sn_index *sample_points;               /* (samples of the structure) its point; SN_NONE: it is left out */
    sn_index *sample_parents;              /* (the same) the sample that it is joined to; SN_NONE: none, or it is left out */
    double *tendon;                        /* (points) share of tendon, 0 to 1; NULL: the muscle has no such map */
    bool scaled;                           /* stiffness by area */
    sn_anisotropy anisotropy;              /* as it runs: NONE, PBD or XPBD */
    const struct sn_contact_plan *contact; /* NULL = contact is off */
} sn_build;

/* A point's new place. */
static inline void sn_put(sn_point *point, sn_vec3 position) { point->x = position.x, point->y = position.y, point->z = position.z; }

/* ---- scheme.c ---- */

typedef struct sn_scheme_rules {
    int count;
    sn_row_kind order[5];      /* (count) as they are projected; 0 = in the order of the table, with the least areas after what crushes */
    double gain[SN_ROW_KINDS]; /* factor on each correction; 0 = 1 */
    double hinge_clamp;        /* rad */
    double hinge_step;         /* most move of a point by one hinge, mean edges */
    bool hinges_published;     /* hinges by the rule of [K21]'s program (dihedral.c), which has limits of its own, instead */
    int volume_projections;    /* at most */
    double most_speed;         /* of a point, beside its bones: diagonals of the muscle per second; 0 = any */
    double keep;               /* factor on the velocities per step; 0 = the muscle's rate of damping */
    bool damps_all;            /* damping acts on the whole velocity, after the force, and not beside the bones alone */
    bool plain;                /* no compliance: plain position based dynamics */
    bool unit_mass;            /* points of 1 kg */
    bool contracts;            /* activation shortens, stiffens and swells */
    bool scales;               /* stiffness by area, where the muscle wants it */
    bool one_way;              /* external constraints move their own vertex alone, towards targets as they are, blended by [R18] eq. 14 */
    bool yields;               /* anisotropy where the muscle leaves it to the scheme */
} sn_scheme_rules;

const sn_scheme_rules *sn_scheme_rules_of(const sn_solver_settings *solver);
enum { SN_MOST_SWEEPS = 2 * SN_ROW_KINDS };
/* The kinds as they are projected in an iteration; one may come more than once. Returns how many. */
int sn_scheme_order(const sn_scheme_rules *rules, sn_row_kind order[SN_MOST_SWEEPS]);
int sn_scheme_sweeps(const sn_solver_settings *solver, sn_row_kind kind); /* in an iteration; 0 = it has no such rows */

/* How one group is projected now. */
typedef struct sn_sweep {
    double compliance; /* alpha / h^2 */
    double gain;       /* factor on the correction */
    double clamp;      /* of hinges, rad */
    double most_step;  /* of a point by one hinge, m */
    bool published;    /* hinges by the rule of [K21]'s program */
    int projections;   /* of the volume, at most */
    bool one_way;      /* external constraints: of the vertex alone */
    bool first;        /* lambda starts at 0 */
} sn_sweep;

/* Sums of forces on points: x, y, z of point i at values[stride i]. stride: 3 (sn_vec3) or 4 (whole records, whose fourth number is
 * overwritten; faster). values NULL: the energy alone is wanted. */
typedef struct sn_forces {
    double *values;
    int stride;
} sn_forces;

/* Energy of one kind of rows of a muscle at the state's points, J; its gradient goes to the scratch of back end `qn`. */
double sn_rows_evaluate(const sn_model *model, const sn_state *state, sn_index muscle, sn_row_kind kind);

/* ---- plan.c ---- */
/* Which groups run: reasons only, before a row exists. */
void sn_plan_decide(const sn_build *build);
/* After the rows are built: groups left empty, bytes of the model. */
void sn_plan_count(const sn_build *build);

/* ---- batch.c ---- */
/* Rows of `size` points each: points (count x size), below point_count. */
typedef struct sn_point_rows {
    sn_index count, size;
    const sn_index *points;
    sn_index point_count;
} sn_point_rows;
/* An order of rows: the first *batched come in fours that share no point. order (rows.count) */
SN_MUST_CHECK sn_status sn_batch_order(const sn_point_rows *rows, sn_index *order, sn_index *batched, sn_error *error);
/* For rows in that order: pairs (batched / 4), true where a four and the next one share no point either. */
void sn_batch_pair(sn_index batched, sn_index size, const sn_index *points, bool *pairs);
/* Put an array (count) of elements of `size` bytes into that order; NULL is fine. */
SN_MUST_CHECK sn_status sn_batch_sort(void *array, sn_index count, size_t size, const sn_index *order, sn_error *error);

/* ---- kinematic.c ---- */
SN_MUST_CHECK sn_status sn_kinematics_build(const sn_build *build, sn_error *error);
/* Leave the poses of the sites' bones in the state, and where followers of surfaces go. at->poses NULL: nobody has those of all joints at
 * that moment. */
void sn_kinematics_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at);
/* The moment with the poses of all joints, which the state has room for where m->pose_count > 0. */
sn_surface_moment sn_kinematics_moment(sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at);
/* Put every attached vertex where its bone carries it: exactly pose(rest); or its surface. */
void sn_kinematics_place(const sn_model_muscle *m, sn_muscle_state *s);
/* Where the k-th kinematic point, one of that site, will be put. */
sn_vec3 sn_kinematics_target(const sn_model_muscle *m, const sn_muscle_state *s, sn_index site, sn_index k);
/* Are they anywhere else than where sn_kinematics_place put them last? */
bool sn_kinematics_moved(const sn_model_muscle *m, const sn_muscle_state *s);
/* The whole muscle, carried along with its bones to `points` (point_count): where a run starts. */
void sn_kinematics_carry(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points);

/* Leaves the motion of the bones over the step of h s that ends here in the state, from the velocities of the attached points. Bones whose
 * velocity changes by more than `most`, m/s, in a step have jumped: that is no motion; 0 = they may change as they like. */
void sn_kinematics_watch_bones(const sn_model_muscle *m, sn_muscle_state *s, double h, double most);
/* The velocity over the last step of a point that went along with the bones and is at x now; zero where they rest. */
sn_vec3 sn_bone_motion_at(const sn_bone_motion *bones, sn_vec3 x);
/* The velocity of a point after damping by the factor `keep`, beside the bones. */
sn_vec3 sn_damped_velocity(const sn_muscle_state *s, sn_index point, double keep);
/* A bone that jumps throws the muscle after it: no tissue is faster, beside its bones, than some tens of its lengths a second. Bounds the
 * velocities of the free points by `most`, m/s; 0 = not at all. */
void sn_kinematics_limit_speed(const sn_model_muscle *m, sn_muscle_state *s, double most);

/* ---- samples.c ---- */
/* Points for the samples of the structure: those on which a vertex hangs, where the plan has any. */
SN_MUST_CHECK sn_status sn_samples_build(sn_build *build, sn_error *error);
void sn_samples_release(sn_build *build); /* what only the builders need */

/* ---- the table of kinds: one source each ---- */

/* Rows begin to end - 1 of a kind, and their errors (end - begin). */
typedef struct sn_row_span {
    sn_index begin, end;
    const double *errors;
} sn_row_span;

/* The longest edge so far, over its goal. */
typedef struct sn_longest_edge {
    double ratio; /* 0 = none yet */
    sn_index point[2];
} sn_longest_edge;

/* An elastic row at some shape: its energy is about scale k / 2 (sum gradient . u)^2 for small displacements u, and its Hessian on each
 * axis at most scale k K KT. */
typedef struct sn_rest_row {
    int count; /* points, at most 4 */
    const sn_index *point;
    double weight[4];    /* K */
    sn_vec3 gradient[4]; /* of its C */
    double scale;        /* stiffness over k */
} sn_rest_row;
typedef bool (*sn_rest_visit)(void *user, const sn_rest_row *row);

/* All that is known of a kind of rows. Plan, scheme, back ends, statistics, pictures and benches ask this table, and nobody else asks which
 * kind it is. What is NULL the kind does not have. Several kinds may share functions, and so they are told theirs. Rows that only it reads,
 * and numbers of a run that are made anew from the inputs, it keeps in m->own[kind] and in the inputs' own[kind]. */
typedef struct sn_row_ops {
    sn_row_info info;
    bool rigid;      /* its rows hold no energy that counts as elastic: a limit */
    bool guarded;    /* a row may have no value at some shapes, and is passed over there */
    bool shared;     /* its rows have points of other members of the group, too, numbered from the muscle's first one */
    bool crushes;    /* projecting it may flatten triangles: the guarded scheme holds the least areas after it */
    bool per_volume; /* its stiffness is over the rest volume */
    /* Before anything is built: SN_RUNS, or why the scene needs no such rows. */
    sn_left_out (*reason)(const sn_build *build);
    /* Over the edges' stiffness k; NULL = 1. */
    double (*factor)(const sn_scene_muscle *source);
    /* Build the rows of this kind; NULL: the kind before it has built them too. Not called with `reason` other than SN_RUNS where it is
     * alone. */
    sn_status (*build)(const sn_build *build, sn_row_kind kind, sn_error *error);
    void (*destroy)(sn_model_muscle *m, sn_row_kind kind);           /* what is in m->own */
    size_t (*own_bytes)(const sn_model_muscle *m, sn_row_kind kind); /* of that */
    sn_index (*count)(const sn_model_muscle *m, sn_row_kind kind);
    const sn_index *(*points)(const sn_model_muscle *m, sn_row_kind kind, sn_index row); /* (info.points) */
    size_t (*bytes)(const sn_model_muscle *m);                                           /* of one row in model and state */
    size_t (*own)(const sn_model_muscle *m, sn_row_kind kind);                           /* numbers in the inputs' own */
    /* Goals for the contraction and the volume goal in the state, where those have changed. */
    void (*goals)(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind);
    /* Back end `xpbd`: one Gauss-Seidel sweep, in double and in single precision. */
    void (*sweep)(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
    void (*sweep_single)(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
    /* Energy at these points (point_count) for stiffness k, J; its gradient is added to `gradient`, N. The state's inputs and goals count,
     * its points do not. */
    double (*energy)(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                     sn_forces gradient);
    /* Back end `qn`: call visit for each row at `at` (point_count); false: visit returned false. */
    bool (*linearise)(const sn_model_muscle *m, sn_row_kind kind, const sn_vec3 *at, sn_rest_visit visit, void *user);
    /* |C| of rows begin to end - 1 at the state's points, in the unit of info.errors; NaN: it has no value now. */
    void (*errors)(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end, double *errors);
    /* Kinds that the surface is stretched by: go on with these rows, whose errors tell which need a closer look. */
    void (*longest)(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_row_span *span,
                    sn_longest_edge *longest);
} sn_row_ops;

#define SN_ROW_OPS(id, name) extern const sn_row_ops sn_rows_##name;
SN_ROW_LIST(SN_ROW_OPS)
#undef SN_ROW_OPS

/* ---- samples.c ---- */
/* How much of each point is tendon: a vertex by the muscle's map, a sample by the mean of the vertices that hang on it. build->tendon, the
 * caller's; stays NULL where there is no map. */
SN_MUST_CHECK sn_status sn_tendons_of_points(sn_build *build, sn_error *error);

/* ---- stiffness.c ---- */
/* Does a stiffness of this share of the edges' ever differ from 0? */
bool sn_has_stiffness(const sn_scene_muscle *source, double factor);
/* k of the edges, N/m: between relaxed and active in log scale; a stiffness of 0 at one end is 0 at every activation but the other end's.
 */
double sn_stiffness_at(const sn_model_muscle *m, double activation);

/* ---- row_table.c ---- */
const sn_row_ops *sn_row_ops_of(sn_row_kind kind);
/* Stiffness of one kind of rows now, before the factors of single rows; 0 = none. */
double sn_row_stiffness(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind);
/* Energy of one kind of rows at these points, J; its gradient is added. */
double sn_rows_energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, sn_forces gradient);
/* Goals for the contraction and volume goal in the state; nothing is done where those have not changed. */
void sn_rows_goals(const sn_model_muscle *m, sn_muscle_state *s);
/* Calls visit for each elastic row at positions (point_count), in the order of the table; false: visit returned false. */
bool sn_rows_at(const sn_model_muscle *m, const sn_vec3 *positions, sn_rest_visit visit, void *user);
SN_MUST_CHECK sn_status sn_rows_build(const sn_build *build, sn_error *error);
void sn_rows_destroy(sn_model_muscle *m); /* what kinds keep to themselves */

/* ---- volume.c ---- */
double sn_volume_ratio(const sn_model_muscle *m, const sn_muscle_state *s); /* V / V0 */
/* The mean of points (count), in four sums: what volumes are taken about. */
sn_vec3 sn_volume_centre(sn_index count, const sn_point *points);

/* ---- single.c: the sweeps in single precision ---- */
float sn_single_weight(const sn_model_muscle *m, sn_index point);   /* inverse mass in floats: over that of a mean point */
void sn_single_enter(const sn_model_muscle *m, sn_muscle_state *s); /* single_points from points, about a new origin */
void sn_single_leave(const sn_model_muscle *m, sn_muscle_state *s); /* and back; attached points keep theirs */
void sn_single_distance_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
void sn_single_hinge_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
void sn_single_area_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);
void sn_single_volume_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *sweep);

/* ---- inputs.c ---- */
/* Activation, contraction, stiffness, volume goal and goal lengths at `time`. */
void sn_inputs_update(const sn_model_muscle *m, sn_muscle_state *s, double time);
/* ---- errors.c ---- */
/* Of the errors of all rows of a kind; longest: nullable, for kinds that the surface is stretched by. */
sn_residual sn_rows_residual(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_longest_edge *longest);
/* What the surface is stretched by: of the kinds that have a longest edge the last one that runs, or the first. */
sn_row_kind sn_stretch_kind(const sn_model_muscle *m);
/* Where neither of them has a row: the edge longest over its length at rest. */
void sn_rest_longest(const sn_model_muscle *m, const sn_muscle_state *s, sn_longest_edge *longest);
/* Greatest |l / l0 - 1| of any edge of the surface against its length at rest. */
double sn_largest_strain(const sn_model_muscle *m, const sn_muscle_state *s);

/* ---- statistics.c ---- */
/* |dPhi/dx| / (k L) from inertia's share of the gradient, inertia (point_count), N: m (v - v predicted) / h. It is overwritten. NaN of a
 * muscle that is tied to others: their rows are not at hand. */
double sn_residual_measure(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *inertia);
void sn_statistics_measure(const sn_model_muscle *m, sn_muscle_state *s);

#endif
