/*
 * error_time.h -- error against run time: timed runs, differences between them, the reference, observed orders, the Pareto front.   rank 3
 *
 * Errors are distances over L, the diagonal of a muscle's rest box, so that they have no unit; times are seconds. numerics.md 4.
 * A run is sampled at moments: numbers of frames since the scene's first. A moment beyond the scene's last frame is one of a hold: the
 * last frame's inputs stay as they are while time passes.
 */
#ifndef SINEW_ERROR_TIME_H
#define SINEW_ERROR_TIME_H

#include "sinew/setting.h"
#include "sinew/sim.h"

/* ---- differences (error_norm.c) ------------------------------------------------------------------------------------------- */

/* What distances between two runs of a scene are weighted and measured with. The points of a moment are those of all of the model's
 * muscles, one muscle after the other: the surface's vertices, then the samples. */
typedef struct sn_yardstick {
    sn_index muscle_count, point_count;
    sn_index *start;  /* (muscle_count + 1) a muscle's points are start[i] .. start[i + 1] - 1 */
    double *mass;     /* (point_count) kg; 0 = carried by a bone: not compared */
    double *diagonal; /* (muscle_count) L, m */
} sn_yardstick;
SN_MUST_CHECK sn_status sn_yardstick_create(const sn_model *model, sn_yardstick *out, sn_error *error);
void sn_yardstick_free(sn_yardstick *yardstick);

/* Where all points were at some moments. */
typedef struct sn_track {
    sn_index moment_count, point_count;
    sn_vec3 *positions; /* (moment_count x point_count) m */
} sn_track;
void sn_track_free(sn_track *track);

/* Over several moments together. NaN where a point of either run is not finite. */
typedef struct sn_difference {
    double worst;           /* RMS of the worst muscle, each point weighted by its mass: the one that claims are made with */
    double scene;           /* RMS over the points of all muscles */
    double most;            /* of any single point */
    sn_index muscle, point; /* which one: a vertex of the muscle, or, from its vertices on, a sample inside; SN_NONE = all are alike */
} sn_difference;
/* a, b: (moment_count x yardstick's points); muscles (muscle_count, nullable): the RMS of each. */
sn_difference sn_difference_between(const sn_yardstick *yardstick, sn_index moment_count, const sn_vec3 *a, const sn_vec3 *b,
                                    double *muscles);

/* ---- timed runs (timed_run.c) ------------------------------------------------------------------------------------------------ */

typedef struct sn_run_request {
    sn_index moment_count;
    const sn_index *moments; /* (moment_count) ascending, >= 0 */
    double rest;             /* a hold ends where no point would move by more than this share of L in a frame; 0 = never */
    double most_seconds;     /* a run ends where its steps have taken longer than this, of processor time; INFINITY = never */
    sn_pool *pool;           /* NULL = one thread; its processor time is then that of the calling thread, else the process's */
} sn_run_request;

typedef struct sn_run_result {
    sn_track track;     /* of the moments that it came to */
    sn_index *moments;  /* (track.moment_count) the request's, and last of all when it came to rest */
    double *cpu, *wall; /* (track.moment_count) s of stepping up to each: without set-up and pre-roll */
    double setup;       /* s of wall time: model, state, pre-roll */
    bool over_time;     /* ended by most_seconds */
    sn_index frames;    /* stepped, held ones too */
    int64_t iterations, rejected_steps, refactorisations, restarts; /* qn; over all muscles */
    sn_index unconverged;  /* qn: pairs of muscle and frame whose last substep ended after all of its iterations, or failed */
    sn_index nan_points;   /* at the last moment */
    double residual;       /* |dPhi/dx| / (k L) of the worst muscle at the end; NaN = none has one */
    double elastic_energy; /* J, at the end, over all muscles */
    double strain;         /* greatest of any surface edge, |l / l0 - 1| against its length at rest, at the end of any frame */
} sn_run_result;
/* The scene from its first frame under its solver settings. A run that is no longer finite, or over time, is a result, not an error. */
SN_MUST_CHECK sn_status sn_run_timed(const sn_scene *scene, const sn_run_request *request, sn_run_result *out, sn_error *error);
void sn_run_free(sn_run_result *result);

/* ---- the reference (reference.c) ----------------------------------------------------------------------------------------------- */

/* A converged run of `qn` at one number of substeps. */
typedef struct sn_rung {
    sn_index substeps;
    sn_track track;
    double seconds;       /* processor time */
    sn_index unconverged; /* as in sn_run_result */
    double strain;        /* as in sn_run_result */
    double step;          /* difference (worst) to the rung of half as many substeps; NaN = that is not there */
    double error;         /* and to the reference */
} sn_rung;

typedef struct sn_reference {
    sn_index rung_count;
    sn_rung *rungs;    /* (rung_count) with 1, 2, 4, ... substeps */
    sn_track track;    /* what errors are measured against */
    bool extrapolated; /* 2 x(S) - x(S/2), Richardson's for errors of first order; else the last rung itself */
    double floor;      /* its own uncertainty: the difference to its twin, the same made with half of the substeps */
    double order;      /* observed between the last three rungs: log2 of the ratio of their steps; NaN = fewer rungs */
    double fitted;     /* order by a robust fit of log2 error over log2 step through the rungs far above the floor; NaN = too few */
    sn_index fitted_rungs;
} sn_reference;

typedef struct sn_reference_params {
    double floor;           /* more substeps until the floor is not above this; default 1e-5 */
    sn_index most_substeps; /* and no more than these; default 64 */
    double tolerance;       /* of each solve; default 1e-9: far below it the energy is flat to rounding */
    sn_index iterations;    /* at most; default 2000 */
    double rest;            /* static: the equilibrium is reached where no point moves by more in a frame; default 1e-11 */
    sn_index most_held;     /* static: frames of the hold at most; default 4000 */
} sn_reference_params;
sn_reference_params sn_reference_defaults(void);

/* What a reference is made for. */
typedef struct sn_reference_task {
    sn_scene *scene; /* its solver settings are changed */
    const sn_yardstick *yardstick;
    const sn_run_request *request;
    const sn_reference_params *params;
} sn_reference_task;

/* Extrapolation is trusted where the observed order is within these. */
#define SN_ORDER_LOW 0.8
#define SN_ORDER_HIGH 1.25
/* Errors below so many floors are not claimed, and not fitted. */
#define SN_CLAIM_FLOORS 10.0

/* h -> 0: rungs of 1, 2, 4, ... substeps until the floor is low enough. The scene's solver settings are
 * then those of the last rung. */
SN_MUST_CHECK sn_status sn_reference_motion(const sn_reference_task *task, sn_reference *out, sn_error *error);
/* The equilibrium that the last frame's inputs lead to; its twin comes there with 2 substeps. Its track has one moment. */
SN_MUST_CHECK sn_status sn_reference_rest(const sn_reference_task *task, sn_reference *out, sn_error *error);
/* A converged run with so many substeps, appended to the rungs where it is not among them (a rung off the powers of two has no step). */
SN_MUST_CHECK sn_status sn_reference_solve(const sn_reference_task *task, sn_index substeps, sn_reference *reference, const sn_rung **out,
                                           sn_error *error);
void sn_reference_free(sn_reference *reference);
/* track, floor, order of the rungs at hand (their steps and errors too), as sn_reference_motion makes them: for tests. */
SN_MUST_CHECK sn_status sn_reference_extrapolate(const sn_yardstick *yardstick, sn_reference *reference, sn_error *error);

/* ---- the diagram (pareto.c) ------------------------------------------------------------------------------------------------------ */

/* Is no other point better in one of both and at least as good in the other? NaN and infinity are on no front. Of equals the first. */
void sn_pareto_front(sn_index count, const double *seconds, const double *errors, bool *front);

/* One setting, measured. */
typedef struct sn_measured_setting {
    sn_setting setting;
    sn_index runs;
    double setup; /* s, median */
    bool over_time;
    sn_index frames;
    int64_t iterations, rejected_steps, refactorisations, restarts;
    sn_index unconverged, nan_points;
    double residual, elastic_energy, strain;
    double solved_strain;  /* that of the converged solve of the same steps; NaN = not measured */
    double *muscle_errors; /* (muscle_count) total RMS over L at its last point; NULL = no point */
} sn_measured_setting;

/* A point of the diagram: a setting; for the equilibrium a setting and how long it was held. */
typedef struct sn_error_point {
    sn_index setting;
    sn_index held;        /* frames beyond the scene's last */
    sn_difference total;  /* against the reference */
    sn_difference solver; /* against the converged solve of the same steps; NaN = not measured */
    double cpu, wall;     /* s, median over the runs */
    bool claimed;         /* total.worst is at least SN_CLAIM_FLOORS floors */
    bool front;           /* on the front of total.worst over cpu, among the claimed ones, and none of the others surely better */
} sn_error_point;

typedef struct sn_error_time {
    char scene_hash[SN_HASH_LENGTH]; /* of the scene document's bytes */
    char *scene_name;                /* nullable */
    bool equilibrium;                /* static: distances to the equilibrium */
    sn_index first_frame, last_frame;
    double rate;
    int threads;
    sn_index muscle_count;
    char **muscle_names;       /* (muscle_count) the enabled ones */
    sn_index *muscle_vertices; /* (muscle_count) */
    sn_index moment_count;
    sn_index *moments;      /* (moment_count) as in sn_run_request */
    sn_reference reference; /* tracks are empty in one that was read */
    sn_index setting_count, point_count;
    sn_measured_setting *settings; /* (setting_count) */
    sn_error_point *points;        /* (point_count) */
} sn_error_time;
void sn_error_time_free(sn_error_time *report);

/* Fill `claimed` and `front` of every point. */
SN_MUST_CHECK sn_status sn_error_time_judge(sn_error_time *report, sn_error *error);
/* The point with the least processor time whose error, with the floor on top, is not above `error`; of the family alone where one is
 * given (nullable). NULL = none. */
const sn_error_point *sn_error_time_cheapest(const sn_error_time *report, double error, const char *family);
/* "qn substeps=2 iterations=5: 8.1e-04 L in 0.11 s"; with "after N held frames" for an equilibrium. */
void sn_error_time_words(const sn_error_time *report, const sn_error_point *point, size_t size, char *out);
/* Errors that reports name the cheapest settings for: 0.1, 0.03, 0.01, ..., 1e-5. */
#define SN_ERROR_TARGETS 9
#define SN_ERROR_TARGET(i) ((i) % 2 == 0 ? sn_pow(10.0, -1 - (i) / 2) : 3.0 * sn_pow(10.0, -2 - (i) / 2))

#endif
