/* fill_loops.h -- loops while they are cut and linked. Private to lib/rig's filling. */
#ifndef SINEW_RIG_FILL_LOOPS_H
#define SINEW_RIG_FILL_LOOPS_H

#include "fill.h"

/* The curve of a loop as it was cut: edges and crossings first .. first + count - 1 of the cutting, anticlockwise about rising u. */
typedef struct cut_curve {
    sn_index first, count;
} cut_curve;

typedef struct cutting {
    const sn_mesh *mesh;
    const sn_topology *topology;
    const double *u;
    fill_levels *out;
    cut_curve *curves; /* (out->loop_count) */
    sn_index *edges;   /* (point_count) */
    sn_vec3 *points;   /* (point_count) */
    sn_index point_count;
    bool by_flux; /* rims lie at equal steps of the field's flux through their loops, not of these loops' length */
    size_t loop_capacity, curve_capacity, edge_capacity, point_capacity;
} cutting;

/* A loop through these cut edges, in order. */
SN_MUST_CHECK sn_status cutting_add_loop(cutting *c, sn_index level, sn_index count, const sn_index *edges, sn_error *error);
/* From the trunk outwards: rims that correspond, and the links between loops. turn: of the square about the line of action. */
SN_MUST_CHECK sn_status cutting_link(cutting *c, double turn, sn_trace *trace, sn_error *error);
void cutting_free(cutting *c);

/* Lay the square's boundary around a loop so that its points, relative to its centroid, agree best with target (K21: least sum of squared
 * distances), `side` being the share of the loop's length that one side along x takes. (fill_rim.c) */
SN_MUST_CHECK sn_status rim_fit(const cutting *c, sn_index loop, double side, const sn_vec3 target[RIM], sn_error *error);
/* A rectangle for a target, its x along `x`, as wide and deep as the loop; returns its share for rim_fit. (fill_rim.c) */
double rim_rectangle(const cutting *c, sn_index loop, sn_vec3 x, sn_vec3 target[RIM], double *width, double *depth);
/* The way in which the loop is widest, turned by `turn` about its normal. (fill_rim.c) */
sn_vec3 rim_widest(const cutting *c, sn_index loop, double turn);
/* Where the square's x or y (axis 0, 1) runs on a loop whose rim is laid; any length. (fill_rim.c) */
sn_vec3 rim_axis(const fill_loop *loop, int axis);

#endif
