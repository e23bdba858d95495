/*
 * order.c -- stable counting sort by indices, and disjoint sets.
 */
#include "order.h"

#include <string.h>

void sn_counting_sort(sn_index count, const sn_index *from, const sn_index *key, sn_index key_count, sn_index *start, sn_index *to) {
    memset(start, 0, ((size_t)key_count + 1) * sizeof *start);
    for (sn_index i = 0; i < count; i++) start[key[i] + 1]++;
    for (sn_index k = 0; k < key_count; k++) start[k + 1] += start[k];
    for (sn_index i = 0; i < count; i++) {
        sn_index item = from != NULL ? from[i] : i;
        to[start[key[item]]++] = item;
    }
    /* every start has moved to the next one's place: move them back */
    memmove(start + 1, start, (size_t)key_count * sizeof *start);
    start[0] = 0;
}

sn_index sn_set_find(sn_index *parent, sn_index i) {
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

void sn_set_join(sn_index *parent, sn_index a, sn_index b) {
    a = sn_set_find(parent, a);
    b = sn_set_find(parent, b);
    if (a < b) parent[b] = a;
    if (b < a) parent[a] = b;
}
