/*
 * group.h -- inside lib/sim: muscles that are solved together. Their points stand one after the other in one array of the state, of which
 * each muscle has its part. A group steps at its own times.   bodies.md 3
 */
#ifndef SN_SIM_GROUP_H
#define SN_SIM_GROUP_H

#include "sinew/sim.h"

typedef struct sn_group {
    sn_index count;                  /* members */
    sn_index *muscles;               /* (count) of the model */
    const sn_model_muscle **members; /* (count) the same */
    sn_index *first;                 /* (count + 1) of the group's points: where those of each member begin */
    sn_index point_count;            /* of all members */
    sn_index iterations;             /* per substep: those of the member that has the most */
    sn_index substeps;               /* a frame, before any is halved */
    double substep_duration;         /* s */
    bool halves;                     /* it may take a substep in halves, and those again, where a muscle tears */
    bool large;                      /* its matrix takes far longer to factor than a step: it is factored for other stiffness alone */
    bool keeps_volume;               /* one of its members does */
    bool corotated, two_level;       /* all of them go by that matrix; some have that coarse space */
    /* external constraints (external.h); nothing of it where no row ties a member to anything */
    sn_index target_count;
    struct sn_external_target *targets;   /* (target_count) */
    sn_index target_points, target_boxes; /* vertices of those that move by themselves; boxes of all of them */
    sn_index row_count;                   /* of all members */
    bool one_way;                         /* scheme romeo: each moves its own vertex alone, and looks for its target in each iteration */
} sn_group;

/* The groups of the model's muscles: those that external constraints tie to each other, directly or over others, by name; each of the
 * others is one of its own. */
SN_MUST_CHECK sn_status sn_groups_build(sn_model *model, sn_error *error);
void sn_groups_free(sn_model *model);
/* One group of these muscles (count), to be freed. */
SN_MUST_CHECK sn_status sn_group_create(const sn_model *model, sn_index count, const sn_index *muscles, sn_group *out, sn_error *error);
void sn_group_free(sn_group *group); /* leaves all zeros */
/* A frame's substeps in the group that has the most; the scene's where there is none. */
sn_index sn_most_substeps(const sn_model *model);

#endif
