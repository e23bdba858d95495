/*
 * neighbours.h -- the part of attach-detect that finds where a muscle rubs on its neighbours: candidates for external constraints.
 */
#ifndef SINEW_TOOLS_NEIGHBOURS_H
#define SINEW_TOOLS_NEIGHBOURS_H

#include "bones.h"
#include "sinew/rig.h"

/* Where the weights of slide, soft and hard come from. */
typedef enum weight_source { WEIGHTS_UNIFORM, WEIGHTS_PAINTED, WEIGHTS_RULE } weight_source;
extern const char *const weight_source_names[]; /* NULL at the end */
extern const char *const weight_names[3];       /* "slide", "soft", "hard": the options, and the painted maps */

/* What the command line asks for; lengths with value < 0 and weights that are NULL were not given. */
typedef struct neighbour_request {
    cli_list glue, lists, obstacles; /* --glue [NAME=]FILE, --muscles LIST, --obstacles LIST */
    const char *envelope;            /* [NAME=]FILE; nullable */
    sn_length reach, minimum, tendon;
    int64_t targets; /* of a vertex; 0 = all */
    bool hidden;
    int source;             /* weight_source */
    int hold;               /* what tendons do: 1 soft, 2 hard */
    const char *weights[3]; /* a number or the name of a map */
} neighbour_request;

typedef struct neighbour_target {
    sn_muscle muscle; /* its mesh in the muscle's unit */
    char *name;
    const char *list; /* that names it; NULL = an option does */
} neighbour_target;

/* What was searched and found; all zeros at first. */
typedef struct neighbour_result {
    bone_list muscles, obstacles; /* those of the lists; `used`: near by box */
    int listed, passed_over;      /* muscles of the lists; those too far by box */
    int itself;                   /* files of the lists that are the muscle itself */
    char *twin;                   /* the name of one that has the mesh, but not the name, of the muscle; NULL = there is none */
    double nearest;               /* gap of the boxes of the nearest muscle passed over, document units; INFINITY = none was */
    double reach, tendon;         /* in use, document units; tendon 0 = no rule */
    size_t target_count;
    neighbour_target *targets; /* (target_count) */
    sn_neighbours_found found; /* its items go to the muscle */
} neighbour_result;

bool neighbours_wanted(const neighbour_request *request);
/* Name the muscles and obstacles of the lists. Wrong usage exits. */
SN_MUST_CHECK sn_status neighbours_name(const cli *c, const neighbour_request *request, neighbour_result *out, sn_error *error);
/* Find the neighbours and make them the muscle's externals; the bones given for attachments, in the muscle's unit, hide what is behind
 * them. SN_STOPPED where the trace stopped. */
SN_MUST_CHECK sn_status neighbours_find(cli *c, const neighbour_request *request, const bone_list *bones, sn_muscle *muscle,
                                        neighbour_result *out, sn_error *error);
/* Warnings, and under -v what was found. */
void neighbours_say(const cli *c, const neighbour_result *result, const sn_muscle *muscle);
/* Members "externals" and "neighbours" of the open object. */
void neighbours_write(sn_json *json, const neighbour_result *result, const sn_muscle *muscle);
/* For the history: the hash of one --muscles or --obstacles LIST: names and meshes of those near by box. */
SN_MUST_CHECK sn_status neighbours_hash(const neighbour_result *result, const char *value, char out[SN_HASH_LENGTH], sn_error *error);
bool neighbours_listed(const neighbour_result *result, const char *value); /* is it a list of ours? */
void neighbours_free(neighbour_result *result);

#endif
