/* cli_given.h -- private to cli.c, cli_files.c and chain.c: the options as they stood on the command line. */
#ifndef SINEW_CLI_GIVEN_H
#define SINEW_CLI_GIVEN_H

#include "cli.h"

typedef struct cli_given {
    const cli_option *option;
    const char *value; /* NULL for flags */
} cli_given_option;

/* The options that a tool takes, its own first, then the shared ones; NULL after the last. */
const cli_option *cli_option_at(const cli_tool *tool, int index);
/* Wrong usage where two options, or one and an input, name one file that is written; an error where an output cannot be. (cli_files.c) */
SN_MUST_CHECK sn_status cli_check_files(const cli *c, sn_error *error);

#endif
