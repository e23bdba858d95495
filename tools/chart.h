/*
 * chart.h -- charts by gnuplot, run as a child.
 */
#ifndef CHART_H
#define CHART_H

#include "cli.h"

/* Run "gnuplot -c share/plots/SCRIPT ARGUMENTS..." (NULL at their end); they are ARG1, ARG2, ... in the script. false: no chart was made,
 * as gnuplot or the script is missing, or has failed: cli_shortfall has said so. */
bool chart_draw(cli *c, const char *script, const char *const *arguments);

#endif
