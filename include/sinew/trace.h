/*
 * trace.h -- the step callback that shows inner steps and can stop.   rank 0
 *
 * A long algorithm reports every inner step that a rigger would want to see (a traversal front, a pruned twig, a filled hole).
 * The receiver may stop it there; the algorithm then returns SN_STOPPED with a valid partial result.
 */
#ifndef SINEW_TRACE_H
#define SINEW_TRACE_H

#include "sinew/base.h"

typedef enum sn_trace_kind { SN_TRACE_NUMBER, SN_TRACE_TEXT, SN_TRACE_INDICES } sn_trace_kind;

typedef struct sn_trace_value {
    const char *name;
    sn_trace_kind kind;
    double number;           /* SN_TRACE_NUMBER; NaN is written as null */
    const char *text;        /* SN_TRACE_TEXT */
    const sn_index *indices; /* SN_TRACE_INDICES: count of them */
    sn_index count;
} sn_trace_value;

static inline sn_trace_value sn_trace_number(const char *name, double number) {
    return (sn_trace_value){.name = name, .kind = SN_TRACE_NUMBER, .number = number};
}
static inline sn_trace_value sn_trace_text(const char *name, const char *text) {
    return (sn_trace_value){.name = name, .kind = SN_TRACE_TEXT, .text = text};
}
static inline sn_trace_value sn_trace_indices(const char *name, const sn_index *indices, sn_index count) {
    return (sn_trace_value){.name = name, .kind = SN_TRACE_INDICES, .indices = indices, .count = count};
}

typedef struct sn_trace {
    /* Receives step `number` (from 1) of stage ("front", "prune", ...); nullable. Values live until it returns. */
    void (*receive)(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count);
    void *user;
    int64_t steps;      /* done so far; start at 0 */
    int64_t stop_after; /* stop once `steps` reaches it; negative = never */
} sn_trace;

/* Report one finished step; true = stop now (return SN_STOPPED with what there is). trace may be NULL. */
bool sn_trace_step(sn_trace *trace, const char *stage, const sn_trace_value *values, int value_count);
/* True where nothing more may be done: stop_after has been reached (also 0, before the first step). */
bool sn_trace_stopped(const sn_trace *trace);
/* True if somebody looks: lets a caller skip the making of expensive values. */
static inline bool sn_trace_wanted(const sn_trace *trace) { return trace != NULL && trace->receive != NULL; }

#define SN_TRACE(trace, stage, ...)                                                    \
    sn_trace_step((trace), (stage), (const sn_trace_value[]){__VA_ARGS__},              \
                  (int)(sizeof((const sn_trace_value[]){__VA_ARGS__}) / sizeof(sn_trace_value)))

#endif
