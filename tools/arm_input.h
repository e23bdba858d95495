/* arm_input.h -- what moment-arm works on: lengths, the coordinate, the other coordinates, out of tables and motions. */
#ifndef SINEW_TOOLS_ARM_INPUT_H
#define SINEW_TOOLS_ARM_INPUT_H

#include "cli.h"
#include "sinew/arm_files.h"

/* What the command line says of it. */
typedef struct arm_choices {
    const char *coordinate, *motion; /* motion: nullable */
    int unit;                        /* index into arm_unit_names; negative = not given */
    int length_unit;                 /* into cli_unit_names; negative = not given */
    cli_list muscles;                /* patterns; none = all */
} arm_choices;
extern const char *const arm_unit_names[]; /* "degrees", "radians", "m", "cm", "mm"; NULL at the end */

/* All of it; arm_input_free leaves all zeros. */
typedef struct arm_input {
    sn_columns table, motion_table; /* the latter empty where there is none */
    sn_motion motion;               /* of a document */
    bool has_motion, is_document;
    const char *coordinate; /* as it is called in its file */
    const char *file;       /* which one that is */
    bool is_way;
    double *values;   /* (rows) of the coordinate: radians or metres; NaN = the row is not used */
    sn_index unused;  /* rows without a value of it */
    sn_index between; /* rows whose value is between two of the motion's */
    sn_index fiber_count, muscle_count, other_count;
    sn_index *columns;    /* (fiber_count) of the table */
    bool *is_length;      /* (columns of the table) also those of muscles that are not wanted */
    double **lengths;     /* (fiber_count) x (rows): m */
    sn_index *muscle_of;  /* (fiber_count) */
    char **muscles;       /* (muscle_count) */
    sn_arm_other *others; /* (other_count) names and values owned */
    sn_index missing;     /* lengths that are not told */
} arm_input;

/* Read the table of lengths (c->inputs.items[0]) and the motion. Warnings say what is left out. */
SN_MUST_CHECK sn_status arm_input_load(cli *c, const arm_choices *with, arm_input *out, sn_error *error);
/* Choose the coordinate, the lengths and the others. */
SN_MUST_CHECK sn_status arm_input_choose(cli *c, const arm_choices *with, arm_input *in, sn_error *error);
/* Print each column of the table and of the motion, and what its name says that it is. */
SN_MUST_CHECK sn_status arm_input_list(const arm_input *in, sn_error *error);
sn_arm_input arm_input_view(const arm_input *in); /* lives as long as *in */
void arm_input_free(arm_input *in);

#endif
