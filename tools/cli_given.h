/* cli_given.h -- private to cli.c and chain.c: the options as they stood on the command line. */
#ifndef SINEW_CLI_GIVEN_H
#define SINEW_CLI_GIVEN_H

#include "cli.h"

typedef struct cli_given {
    const cli_option *option;
    const char *value; /* NULL for flags */
} cli_given_option;

/* The options that a tool takes, its own first, then the shared ones; NULL after the last. */
const cli_option *cli_option_at(const cli_tool *tool, int index);

#endif
