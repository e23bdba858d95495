/*
 * levels.h -- a muscle cut across by levels along its length: sections, how they hang together, and their line of centroids. Private to
 * lib/rig.
 *
 * The field is the signed distance along the surface from the curve half-way between the muscle's two tips: its levels run across, however
 * the muscle bends and branches, and none of it rests on roots, attachments or fibres.
 */
#ifndef SINEW_RIG_LEVELS_H
#define SINEW_RIG_LEVELS_H

#include "sinew/geom.h"

/* One connected curve of one level: the rim of a section. */
typedef struct level_loop {
    sn_index level;
    double area, perimeter; /* of the section it bounds; area of the fan about its middle where it is open */
    sn_vec3 centre;         /* of the rim, by length */
} level_loop;

/* Loops and connected patches of vertices between two levels are nodes of a graph: loops first, then patches. */
typedef struct levels {
    const sn_mesh *mesh;
    const sn_topology *topology;
    double *along; /* (vertex_count) the field; NaN off the largest component */
    double low, step;
    sn_index level_count;
    sn_index *band;        /* (vertex_count) how many levels lie below it; SN_NONE off the largest component */
    sn_index *piece_start; /* (triangle_count + 1) first piece of each triangle: its lowest level */
    sn_index *piece;       /* (pieces) the loop of each */
    sn_index loop_count, node_count;
    level_loop *loops;     /* (loop_count) */
    sn_index *vertex_node; /* (vertex_count) patch; off the largest component one that nothing hangs on */
    sn_index *link_start;  /* (node_count + 1) */
    sn_index *links;       /* neighbours of each node, some more than once */
    sn_vec3 *centre;       /* (level_count) of all sections of a level, by area */
} levels;

/* SN_ERROR_INPUT where the surface has no length to cut. */
SN_MUST_CHECK sn_status levels_build(const sn_mesh *mesh, const sn_topology *topology, levels *out, sn_error *error);
void levels_free(levels *l);
/* The direction of the line of centroids where the field is `along`: unit, over a tenth of the muscle's length to either side, and
 * not over the outermost twelfth at either end. */
sn_vec3 levels_direction(const levels *l, double along);

/* Which loops are tendon, from 0 (muscle) to 1: long thin parts, and what hangs on them (lib/rig/tendon_map.c). loop (loop_count); thin,
 * slender as in sn_architecture_params. */
SN_MUST_CHECK sn_status levels_find_tendons(const levels *l, double thin, double slender, double *loop, sn_error *error);

#endif
