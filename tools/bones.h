/* bones.h -- the bones that a tool is given: --bone [NAME=]FILE and --bones LIST, a file or a folder of meshes. Lists of muscles too. */
#ifndef SINEW_TOOLS_BONES_H
#define SINEW_TOOLS_BONES_H

#include "cli.h"

typedef struct bone {
    char *name, *file; /* owned */
    bool named;        /* the list or the option gives the name; false: it is the file's base name */
    const char *list;  /* the --bones that names it, as given; NULL = named by --bone */
    bool used;         /* set by the tool: the result depends on its mesh */
    sn_mesh mesh;      /* once loaded: z up */
    double own_unit;   /* metres per unit that the file says; 0 = it says nothing */
    sn_space space;    /* that the file says */
    double scale;      /* that its own unit was scaled by */
    sn_status status;  /* of its loading, with error */
    sn_error error;
} bone;

typedef struct bone_list {
    size_t count, capacity;
    bone *items;
    bool rigs; /* set before naming: of muscles' rigs, in folders *.muscle.json; default bones, in folders every mesh */
    /* set before loading: */
    double meters_per_unit; /* to scale the meshes to; 0 = leave them in their own unit */
    double given_unit;      /* metres per unit of every file, whatever it says; 0 = what it says, or else meters_per_unit */
    bool up_y, up_given;    /* y is up in files that do not say, or in all */
} bone_list;

/* Name the bones of --bone (in `files`), then those of --bones (in `lists`). Wrong usage exits. */
SN_MUST_CHECK sn_status bones_name(const cli *c, const cli_list *files, const cli_list *lists, bone_list *out, sn_error *error);
/* Read all meshes, in parallel. The first that failed, in the order given, is the error. */
SN_MUST_CHECK sn_status bones_load(bone_list *list, int threads, sn_error *error);
/* Are all in one space with the muscle (NULL: with each other), as far as it is told? Beside bones of another it would be put on the other
 * side's. */
SN_MUST_CHECK sn_status bones_check_spaces(const bone_list *list, const sn_muscle *muscle, sn_error *error);
/* For the history: the hash of one --bones LIST, over the names of its bones and the contents of those used (a cli_hash_function). */
SN_MUST_CHECK sn_status bones_hash(const void *list, const char *value, char out[SN_HASH_LENGTH], sn_error *error);
void bones_free(bone_list *list);

#endif
