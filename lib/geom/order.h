/*
 * order.h -- stable counting sort by indices, linear in items and keys; private to lib/geom.
 */
#ifndef SINEW_GEOM_ORDER_H
#define SINEW_GEOM_ORDER_H

#include "sinew/base.h"

/* The order of `count` items by key (count), each in 0 .. key_count - 1, lowest first; equal keys keep the order of `from`
 * (nullable: 0, 1, 2, ...). start (key_count + 1) is scratch, and on return the first place of each key in `to`. */
void sn_counting_sort(sn_index count, const sn_index *from, const sn_index *key, sn_index key_count, sn_index *start, sn_index *to);

/* Disjoint sets of 0 .. n-1, each named by its lowest member: start with parent[i] = i. */
sn_index sn_set_find(sn_index *parent, sn_index i);
void sn_set_join(sn_index *parent, sn_index a, sn_index b);

#endif
