/*
 * tips.h -- the overall shape of a surface: components, genus, and its two far ends. Private to lib/rig.
 */
#ifndef SINEW_RIG_TIPS_H
#define SINEW_RIG_TIPS_H

#include "sinew/geom.h"

typedef struct surface_survey {
    sn_index components;
    double genus;         /* summed over components; NaN where the surface is not closed */
    sn_index main_vertex; /* lowest vertex of the component with most triangles */
} surface_survey;

SN_MUST_CHECK sn_status survey_surface(const sn_mesh *mesh, const sn_topology *topology, surface_survey *out, sn_error *error);

typedef struct tips {
    sn_index end[2]; /* end[0] < end[1] */
    double length;   /* L: the shortest way between them along the surface */
    bool eigen;      /* the extremes of the Fiedler eigenfunction */
} tips;

/* The two ends of the component that holds vertex `seed`: the vertex farthest from it, the one farthest from that, and so on until L grows
 * by less than 0.1 % (one double sweep had not converged on 53 of 291 real muscles). Each sweep is a trace step. */
SN_MUST_CHECK sn_status find_tips(const sn_mesh *mesh, const sn_topology *topology, sn_index seed, sn_trace *trace, tips *out,
                                  sn_error *error);

/* The same by the Fiedler eigenfunction, whose two extremes they are: less drawn to a thin spur than the farthest vertex is.
 * SN_ERROR_INPUT where the surface is not of one component. */
SN_MUST_CHECK sn_status find_tips_by_eigenfunction(const sn_mesh *mesh, const sn_topology *topology, const surface_survey *survey,
                                                   sn_trace *trace, tips *out, sn_error *error);

#endif
