/*
 * setting.h -- solver settings in text: "qn substeps=2 iterations=5".   rank 3
 *
 * A setting is a method and what is chosen for it, KEY=VALUE with blanks between; what is not said has the method's default. The keys are
 * rows of one table (lib/sim/setting.c): a new solver option is a new row there.
 */
#ifndef SINEW_SETTING_H
#define SINEW_SETTING_H

#include "sinew/scene.h"

#define SN_SETTING_KEYS 16    /* most keys that the table may have */
#define SN_SETTING_LENGTH 512 /* bytes that hold any setting in text */

typedef struct sn_setting {
    sn_solver_method method;
    unsigned given;                 /* bit i: key i of the table */
    double values[SN_SETTING_KEYS]; /* of the given keys; of a word its place among the words */
} sn_setting;

/* SN_ERROR_INPUT: an unknown method, key or word, a number out of range, a key twice, a key that the method has not. */
SN_MUST_CHECK sn_status sn_setting_parse(const char *text, sn_setting *out, sn_error *error);
/* A setting a line; "#" begins a comment. *out (*count of them, at least one) is freed by the caller. Errors carry the line. */
SN_MUST_CHECK sn_status sn_settings_parse(const char *text, size_t size, sn_setting **out, sn_index *count, sn_error *error);
/* Canonical text: the method, then the given keys in the table's order. */
void sn_setting_format(const sn_setting *setting, char out[SN_SETTING_LENGTH]);
/* What settings on one line of a chart share: the method, and the words that are not the default. */
void sn_setting_family(const sn_setting *setting, char out[SN_SETTING_LENGTH]);
/* Into the scene: the method's defaults, then what is given. Threads and sleep stay the scene's; a muscle's own number of iterations gives
 * way, so that one setting means the same for all of them. */
void sn_setting_apply(const sn_setting *setting, sn_scene *scene);

#endif
