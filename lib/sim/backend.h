/*
 * backend.h -- inside lib/sim: what steps a group. A step is a row of stages (step.c), of which a back end has three: it starts from the
 * inputs of the step's end, iterates, finishes. What it remembers from one to the next is its own, and it has its own list of it.
 */
#ifndef SN_SIM_BACKEND_H
#define SN_SIM_BACKEND_H

#include "kept.h"
#include "rows.h"

/* One step of one group (a substep, or a part of one), or some of its iterations: those from `begin` to before `end`. The inputs and the
 * poses of the bones in the state are those of its end. */
typedef struct sn_substep {
    double h;        /* s */
    sn_vec3 gravity; /* m/s^2 */
    const sn_scheme_rules *rules;
    sn_index begin, end; /* iterations; the step starts with 0 and ends with the group's */
    bool may_halve;      /* it may be given up for two of half the length */
    bool halved;         /* it is one of those */
    bool measure;        /* leave the residual at the end in the statistics */
    sn_point *before;    /* (points) nullable; xpbd: where they are when the iterations begin */
} sn_substep;

typedef enum sn_verdict {
    SN_STEP_HOLDS,
    SN_STEP_REFUSED, /* too long, before any iteration: the state is as it was before the step */
    SN_STEP_GIVEN_UP /* too long, after all of them: the same */
} sn_verdict;

/* Stages and memory of a back end; what is NULL it does not need. */
typedef struct sn_backend {
    const char *name;
    sn_verdict (*start)(const sn_group *g, sn_group_state *s, const sn_substep *substep);
    void (*resume)(const sn_group *g, sn_group_state *s, const sn_substep *substep); /* in the middle of a step, in place of the start */
    void (*iterate)(const sn_group *g, sn_group_state *s, const sn_substep *substep);
    sn_verdict (*finish)(const sn_group *g, sn_group_state *s, const sn_substep *substep);
    void (*rest)(sn_group_state *s); /* nothing has moved: what it has learnt of the way here is of no use */

    /* kept_only: room for nothing but what is kept. destroy also after a create that failed. */
    sn_status (*create)(const sn_group *g, sn_group_state *s, bool kept_only, sn_error *error);
    void (*destroy)(const sn_group *g, sn_group_state *s);
    void (*reset)(const sn_group *g, sn_group_state *s); /* before a run; points and inputs are those of its start */
    size_t (*bytes)(const sn_group *g);
    /* Stop and go on: numbers and arrays through the cursor; the first member that no run leaves like this; into another state. */
    void (*pass_numbers)(sn_cursor *c, const sn_group *g, sn_group_state *s);
    void (*pass_arrays)(sn_cursor *c, const sn_group *g, sn_group_state *s);
    const char *(*fault)(const sn_group *g, const sn_group_state *s);
    void (*take)(const sn_group *g, const sn_group_state *read, sn_group_state *s);
} sn_backend;

extern const sn_backend sn_backend_xpbd;                /* xpbd.c */
extern const sn_backend sn_backend_qn;                  /* qn.c */
const sn_backend *sn_backend_of(const sn_scene *scene); /* backend.c */

#endif
