/*
 * sets.h -- disjoint sets of numbers, each named by its lowest one.   rank 0
 */
#ifndef SINEW_SETS_H
#define SINEW_SETS_H

#include "sinew/base.h"

/* The name of the set that i is in; parents[i] = i at first, for each a set of its own. Shortens the way there. */
static inline sn_index sn_set_of(sn_index *parents, sn_index i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

/* Make one set of the two that a and b are in. */
static inline void sn_join_sets(sn_index *parents, sn_index a, sn_index b) {
    a = sn_set_of(parents, a), b = sn_set_of(parents, b);
    parents[a > b ? a : b] = a < b ? a : b;
}

#endif
