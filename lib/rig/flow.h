/*
 * flow.h -- where fibre directions come from, before they are laid into the surface. Private to lib/rig.
 */
#ifndef SINEW_RIG_FLOW_H
#define SINEW_RIG_FLOW_H

#include "ends.h"

/* What directions are found for. */
typedef struct flow_input {
    const sn_muscle *muscle;
    const sn_topology *topology;
    const sn_flow_params *params;
    sn_trace *trace;
} flow_input;

/* The ends that the harmonic field runs between (ends_choose); out is freed by the caller, also on failure. lib/rig/flow_harmonic.c */
SN_MUST_CHECK sn_status flow_find_ends(const sn_muscle *muscle, const sn_topology *topology, const sn_flow_params *params, ends *out,
                                       sn_error *error);
/* Gradient of the harmonic field between the muscle's ends: the area-weighted mean of its triangles' at every vertex; zero within the ends
 * themselves. Trace stage "field". lib/rig/flow_harmonic.c */
SN_MUST_CHECK sn_status harmonic_directions(const flow_input *in, const ends *e, sn_vec3 *directions, sn_error *error);

/* Tangent of the nearest segment of the polylines at every vertex. lib/rig/flow_nearest.c */
SN_MUST_CHECK sn_status nearest_tangents(const sn_mesh *mesh, sn_index count, const sn_polyline *polylines, sn_vec3 *directions,
                                         double *farthest, sn_error *error);

#endif
