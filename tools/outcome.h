/*
 * outcome.h -- what simulate says of its run: frames that broke a limit or exploded, and in the end how it went.
 */
#ifndef SINEW_TOOLS_OUTCOME_H
#define SINEW_TOOLS_OUTCOME_H

#include "cli.h"
#include "sinew/sim.h"

/* ---- --fail-on ------------------------------------------------------------------------------------------------------------------ */

enum { OUTCOME_MOST_LIMITS = 32 };
struct outcome_measure;
typedef struct outcome_limit {
    const char *name;                      /* NULL = it has been broken, and was told */
    const struct outcome_measure *measure; /* NULL = the greatest error of: */
    sn_row_kind kind;
    bool above;
    double value;
} outcome_limit;

/* ---- what is kept of each frame, for the end of the run -------------------------------------------------------------------------- */

/* The work of one muscle in a frame. */
typedef struct outcome_work {
    int64_t iterations, refactorisations, restarts, steps, halvings;
    bool torn;
} outcome_work;

typedef struct outcome_frame {
    sn_index number;
    double seconds;    /* of its step; NaN: it was not stepped, the run began with it */
    sn_index busiest;  /* muscle that cost the most, by iterations, factors and points */
    double share;      /* of the cost of all muscles */
    outcome_work work; /* the busiest's */
} outcome_frame;

/* Frames in a row in which a muscle was torn. */
typedef struct outcome_tear {
    sn_index muscle, first, last;
} outcome_tear;

/* The worst that a figure came to. */
typedef struct outcome_worst {
    double value; /* NaN = there was none */
    sn_index muscle, frame;
} outcome_worst;

/* The figures of which the worst is kept. */
enum { WORST_VOLUME, WORST_EDGE, WORST_TRIANGLE, WORST_PENETRATION, WORST_ITERATIONS, WORST_COUNT };

typedef struct outcome {
    cli *c;
    const sn_model *model;
    int limit_count;
    outcome_limit limits[OUTCOME_MOST_LIMITS];
    size_t frame_count, frame_room, tear_count, tear_room;
    outcome_frame *frames; /* (frame_count) */
    outcome_tear *tears;   /* (tear_count) by their first frames */
    sn_index *last_tear;   /* (model.muscle_count) SN_NONE = it has not been torn yet */
    outcome_worst worst[WORST_COUNT];
    char moment[80]; /* what is looked at, for messages: "frame 12" */
    bool runs_in;    /* that is in the pre-roll's run-in */
    unsigned *told;  /* (model.muscle_count) bits of what was told already: sn_explosion, and leaps */
} outcome;

/* The limits of --fail-on; text is nullable. Bad ones are wrong usage. */
void outcome_parse_limits(outcome *o, cli *c, const char *text);
/* The outcome keeps a reference to the model. */
SN_MUST_CHECK sn_status outcome_start(outcome *o, const sn_model *model, sn_error *error);
/* Is every coordinate finite? Where one is not, and no frame came before, SN_ERROR_INPUT; else that is told as a shortfall and SN_STOPPED
 * is returned: the run ends with the last frame. no_state: the state that was asked for will not be written. */
SN_MUST_CHECK sn_status outcome_check(outcome *o, const sn_state *state, bool no_state, sn_error *error);
/* As outcome_check, of a muscle whose coordinates are finite, but too large for the numbers that its frames are written in. */
SN_MUST_CHECK sn_status outcome_overflows(outcome *o, const sn_state *state, sn_index muscle, bool no_state, sn_error *error);
/* The same on the way to the first frame, and signs of an explosion are told: a sn_watch_run_in, user is the outcome. */
SN_MUST_CHECK sn_status outcome_run_in(void *user, const sn_state *state, double share, sn_error *error);
/* Take down a frame that is finite, and tell which limits it is the first to break, and which muscles have exploded in it. */
SN_MUST_CHECK sn_status outcome_take(outcome *o, const sn_state *state, double seconds, sn_error *error);
/* Say how the run went, not under -q. */
void outcome_say(const outcome *o);
/* Members of the report. */
void outcome_report(const outcome *o, sn_json *json);
void outcome_free(outcome *o);

#endif
