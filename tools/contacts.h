/*
 * contacts.h -- the part of simulate that has to do with contact: its options, the fields of bones, what is said of it.
 */
#ifndef SINEW_TOOLS_CONTACTS_H
#define SINEW_TOOLS_CONTACTS_H

#include "cli.h"
#include "sinew/sim.h"

typedef struct contact_choices {
    bool on, off;
    sn_length margin, cell;
    double friction, resolve;
    int64_t samples;
    const char *cache;
    int collision, bone_hits;
    const char *voxels; /* "N" or "total:N" */
} contact_choices;

/* How the fields of bones were come by. */
typedef struct contact_run {
    const cli *c;
    const char *cache;
    double seconds; /* that they took */
    sn_index built, read;
    bool by_voxels;
} contact_run;

/* Do options ask for contact? Wrong usage exits. */
bool contacts_wanted(const cli *c, const contact_choices *given);
void contacts_apply(const cli *c, const contact_choices *given, sn_scene *scene);
/* The model, with fields built, or read from the cache. */
SN_MUST_CHECK sn_status contacts_model(contact_run *run, const sn_scene *scene, sn_pool *pool, sn_model **out, sn_error *error);
/* Members of a line of the log; of a muscle in the plan; and of the whole plan or report. Nothing where contact is off. */
void contacts_log(const sn_model *model, const sn_statistics *s, const sn_plan_muscle *plan, sn_json *json);
/* How much lay in bones at rest, and does now; nothing where none did. */
void contacts_say(const cli *c, const sn_model *model, const sn_state *state);
void contacts_plan_muscle(const sn_model *model, const sn_plan_muscle *plan, sn_json *json);
void contacts_plan(const contact_run *run, const sn_model *model, sn_json *json);

#endif
