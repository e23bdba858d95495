/*
 * dog_sites.h -- where the muscles of dog-dmcontrol attach, by its attachments.tsv.
 */
#ifndef TESTS_DOG_SITES_H
#define TESTS_DOG_SITES_H

#include <string.h>

#include "sinew/io.h"
#include "sinew/vec.h"

#define SITES_COMPACT 0.25 /* sites of an end lie within this share of the distance of the ends from their mean */

enum { MOST_SITES = 64 };

/* The sites of one muscle, in the order of the table. */
typedef struct site_list {
    sn_index count, far[2]; /* far: the two farthest apart */
    sn_vec3 points[MOST_SITES];
    int end[MOST_SITES]; /* which of the two each is nearer to */
} site_list;

/* Column `index` of a line of tab-separated values; NULL where the line, or all that follows it, has fewer. */
static inline const char *column(const char *line, int index) {
    while (index-- > 0 && line) {
        line = strchr(line, '\t');
        if (line) line++;
    }
    return line;
}

/* The sites that the table has for the muscle in `file`. */
static inline void find_sites(const sn_blob *table, const char *file, site_list *out) {
    size_t length = strlen(file);
    out->count = 0;
    for (const char *line = table->data; line && *line; line = strchr(line, '\n'), line += line != NULL) {
        const char *name = column(line, 6), *end = line + strcspn(line, "\n"), *point = column(line, 2);
        if (!name || name >= end || strncmp(name, file, length) != 0 || name[length] != '\t' || out->count == MOST_SITES) continue;
        double p[3];
        bool good = true;
        for (int i = 0; i < 3; i++) good = good && sn_scan_number(point, end, &point, &p[i]) && point++ < end;
        if (good) out->points[out->count++] = sn_v3(p[0], p[1], p[2]);
    }
}

/* Two groups, around the two sites farthest apart; true where both are compact. */
static inline bool group_sites(site_list *l) {
    l->far[0] = l->far[1] = 0;
    for (sn_index i = 0; i < l->count; i++)
        for (sn_index j = i + 1; j < l->count; j++)
            if (sn_distance(l->points[i], l->points[j]) > sn_distance(l->points[l->far[0]], l->points[l->far[1]])) {
                l->far[0] = i;
                l->far[1] = j;
            }
    if (l->far[0] == l->far[1]) return false;
    sn_vec3 mean[2] = {{0, 0, 0}, {0, 0, 0}};
    double count[2] = {0, 0}, spread = 0.0;
    for (sn_index i = 0; i < l->count; i++) {
        l->end[i] = sn_distance(l->points[i], l->points[l->far[1]]) < sn_distance(l->points[i], l->points[l->far[0]]);
        mean[l->end[i]] = sn_add(mean[l->end[i]], l->points[i]);
        count[l->end[i]] += 1.0;
    }
    for (int e = 0; e < 2; e++) mean[e] = sn_scale(mean[e], 1.0 / count[e]);
    for (sn_index i = 0; i < l->count; i++) spread = fmax(spread, sn_distance(l->points[i], mean[l->end[i]]));
    return spread <= SITES_COMPACT * sn_distance(mean[0], mean[1]);
}

#endif
