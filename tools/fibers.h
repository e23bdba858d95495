/*
 * fibers.h -- what simulate does with a muscle's volume fibres: carry them, write them and their lengths, compare and check them.
 *
 * All of it is absent unless an option asks for it: then fibers_bind leaves the run empty and every other call returns at once.
 */
#ifndef SINEW_TOOLS_FIBERS_H
#define SINEW_TOOLS_FIBERS_H

#include "cli.h"
#include "frame_files.h"
#include "sinew/fibers.h"
#include "sinew/sim.h"

/* Targets of the command line. */
typedef struct fiber_choices {
    bool frames;         /* --fibers */
    const char *lengths; /* --lengths FILE */
    bool smooth;         /* --smooth-lengths */
    double blend;        /* --blend EXPONENT; 0 = none */
    bool penetration;    /* --penetration */
    double cut;          /* --mvc-cut */
    const char *cache;   /* --embedding-cache FOLDER */
} fiber_choices;

#define FIBERS_CUT 3e-4 /* default of --mvc-cut */

/* One muscle's fibres. fiber_count 0 = it has none. */
typedef struct fiber_muscle {
    sn_fiber_bundle bundle;
    sn_embedding embedding;
    bool cached;        /* the weights came from the cache: their report is empty */
    sn_vec3 *positions; /* (vertex_count) of the surface */
    sn_vec3 *points;    /* (point_count) that follow it */
    double *lengths;    /* (fiber_count) document units */
    sn_fiber_blend blend;
    sn_vec3 *blend_points; /* (point_count); NULL = no blend */
    double *blend_lengths; /* (fiber_count) */
    sn_penetration in_bones, blend_in_bones;
    sn_pc2 *cache;
    sn_line_frames *lines;
} fiber_muscle;

typedef struct fiber_run {
    fiber_choices with;
    const sn_scene *scene;
    const sn_model *model;
    sn_pool *pool;
    fiber_muscle *muscles; /* (model.muscle_count); NULL = nobody asked for fibres */
    sn_bone_probe *probe;  /* NULL = nobody asked for penetration */
    sn_rigid *poses;       /* (joint_count) */
    sn_table *table;       /* of lengths; NULL = none */
    double *row;           /* one row of it */
    double bind_seconds, move_seconds;
    int64_t moves;
} fiber_run;

/* The frames of a muscle's fibres are named after its own. */
#define FIBERS_SUFFIX "-fibers"

/* Did an option ask for fibres? Options that make no sense together are wrong usage and exit. */
bool fibers_wanted(const cli *c, const fiber_choices *with);
/* Bind the fibres of all muscles to their surfaces. SN_ERROR_INPUT where no muscle has any; one without is warned of. The run keeps
 * references to model and pool (nullable). */
SN_MUST_CHECK sn_status fibers_bind(fiber_run *run, const cli *c, const fiber_choices *with, const sn_model *model, sn_pool *pool,
                                    sn_error *error);
/* Open the table of lengths, of `rows` frames; behind those that are there, where resume (nullable) tells that. The fibres are then where
 * the state has them (fibers_move). */
SN_MUST_CHECK sn_status fibers_open_lengths(fiber_run *run, int64_t rows, sn_resume *resume, sn_error *error);
typedef struct fiber_start {
    frame_range range;
    sn_resume *resume; /* nullable: as above */
} fiber_start;
/* Open the frames of one muscle, beside its own at `path`: its extension, if any, gives way to "-fibers". */
SN_MUST_CHECK sn_status fibers_open_frames(fiber_run *run, sn_index muscle, const char *path, const fiber_start *start, sn_error *error);
/* Take the fibres to where the surfaces are. */
void fibers_move(fiber_run *run, const sn_state *state);
/* Write frames and lengths. */
SN_MUST_CHECK sn_status fibers_write(fiber_run *run, sn_index frame, sn_error *error);
SN_MUST_CHECK sn_status fibers_commit(fiber_run *run, sn_error *error);
/* Members of a line of the log, of the report, of a muscle's plan. muscle: in the model. */
void fibers_log(const fiber_run *run, sn_index muscle, sn_json *json);
void fibers_report(const fiber_run *run, sn_json *json);
/* state (nullable): to measure what a frame costs. */
void fibers_plan(const fiber_run *run, const sn_state *state, sn_index muscle, sn_json *json);
void fibers_free(fiber_run *run);

#endif
