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
    double reach;      /* an area with a landmark farther from the surface is left out; the caller's to set */
    sn_area_kind kind; /* what landmarks are; the caller's to set */
    double line_width; /* of the band along a line; < 0 = the mean distance of its landmarks from the surface; the caller's to set */
} sn_area_ground;

SN_MUST_CHECK sn_status sn_area_ground_create(const sn_muscle *muscle, const sn_topology *topology, sn_area_ground *out, sn_error *error);
void sn_area_ground_free(sn_area_ground *ground);
/* inside (vertex_count): the vertices of the patch; none where the area is left out (report->left_out); where the trace stopped, those
 * along what was drawn of its boundary. */
SN_MUST_CHECK sn_status sn_area_patch(const sn_area_ground *ground, const sn_landmark_area *area, sn_trace *trace, bool *inside,
                                      sn_attach_area *report, sn_error *error);

/* ---- attach_line.c: landmarks in a row ------------------------------------------------------------------------------------- */

/* The landmarks from the first to the last by straight steps, document units; of eight and more their zigzag is smoothed first. */
typedef struct sn_landmark_walk {
    double length, longest; /* of all steps; of the longest */
    double closing;         /* from the last landmark to the first */
} sn_landmark_walk;

/* The test of sn_area_kind. At least two landmarks. */
bool sn_landmarks_in_line(const sn_landmark_area *area, sn_landmark_walk *walk);
/* Puts the landmarks of a straight row (within 1 % of its length) into their order along it; order (count) is a permutation on entry.
 * True where that changed anything but the sense. */
bool sn_line_order(const sn_landmark_area *area, sn_index *order);

typedef struct sn_line {
    sn_index count;
    const sn_surface_path *paths; /* (count) one behind the other */
    double width;                 /* document units */
} sn_line;

/* inside (vertex_count), all false on entry: the corners of the triangles that the line runs through, and what is joined to them over
 * vertices within half the width. area: that of the vertices. */
SN_MUST_CHECK sn_status sn_line_band(const sn_area_ground *ground, const sn_line *line, bool *inside, double *area, sn_error *error);

#endif
