/* attach.h -- what the rules of attachment share. Private to lib/rig. */
#ifndef SINEW_RIG_ATTACH_H
#define SINEW_RIG_ATTACH_H

#include "sinew/rig.h"
#include "sinew/voxels.h"

/* One bone under search. */
typedef struct sn_bone_search {
    const sn_mesh *muscle;
    const sn_mesh *bone;
    const sn_surface *surface; /* of the bone */
    sn_box box;                /* of the bone */
    sn_pool *pool;
} sn_bone_search;

/* ---- attach_pairs.c: is this bone near this muscle? ------------------------------------------------------------------ */

typedef struct sn_pair_probe {
    double area_share; /* of the muscle's surface that lies within the distance of the bone */
    bool penetrates;   /* some point of the surface is in the bone */
} sn_pair_probe;

/* Dense samples of the muscle's surface against the bone; `area` is that of the muscle. */
SN_MUST_CHECK sn_status sn_probe_pair(const sn_bone_search *search, double distance, double area, sn_pair_probe *out, sn_error *error);

/* ---- attach_area.c: patches with landmarks around them ------------------------------------------------------------------ */

/* What every area of one muscle is drawn on. */
typedef struct sn_area_ground {
    const sn_muscle *muscle;
    const sn_topology *topology;
    sn_surface *surface;
    sn_path_finder *finder;
    double *vertex_area; /* (vertex_count) a third of the triangles around it */
    double total_area;
    double reach; /* a landmark farther from the surface is an error; the caller's to set */
} sn_area_ground;

SN_MUST_CHECK sn_status sn_area_ground_create(const sn_muscle *muscle, const sn_topology *topology, sn_area_ground *out, sn_error *error);
void sn_area_ground_free(sn_area_ground *ground);
/* inside (vertex_count): the vertices of the patch; where the trace stopped, those along what was drawn of its boundary. */
SN_MUST_CHECK sn_status sn_area_patch(const sn_area_ground *ground, const sn_landmark_area *area, sn_trace *trace, bool *inside,
                                      sn_attach_area *report, sn_error *error);

#endif
