/* attach_detection.h -- a detection of attachments under way, which its stages hand on. Private to lib/rig. */
#ifndef SINEW_RIG_ATTACH_DETECTION_H
#define SINEW_RIG_ATTACH_DETECTION_H

#include "attach.h"

/* A "holder" is what a vertex may hang on: the bones in the order given, then bones that only pins or areas name. */
typedef struct detection {
    const sn_muscle *muscle;
    const sn_attach_params *params;
    sn_trace *trace;
    sn_attach_report *report;
    sn_topology topology;
    sn_box box;           /* of the muscle */
    double area;          /* of the muscle */
    double reach;         /* proximity: closer than this; 0 without */
    double pair_distance; /* of the pair rule */
    sn_index holder_count;
    const char **holders;  /* (holder_count) names; borrowed */
    bool *has_area;        /* (holder_count) an area names it: it holds nothing by contact or proximity */
    sn_index *holder_of;   /* (vertex_count) SN_NONE = free */
    double *distance;      /* (vertex_count) signed, to the holder; NaN = not known */
    double *runner_up;     /* (vertex_count) signed, to the nearest other bone that would take it; INFINITY = none */
    unsigned char *reason; /* (vertex_count) sn_attach_reason that attached it */
    double *candidate;     /* (vertex_count) signed, to the bone under search; INFINITY = out of reach */
    sn_index *list;        /* (vertex_count) scratch */
    double *chunk_nearest; /* (chunks) */
    double *vertex_area;   /* (vertex_count) a third of the triangles around it */
    double *along;         /* (vertex_count) 0 at one tip of the muscle, 1 at the other; NaN on other components, or not known yet */
    double length;         /* from tip to tip along the surface, document units; 0 = not known yet */
    sn_index tip[2];       /* the vertices at the tips */
} detection;

/* ---- attach.c ---------------------------------------------------------------------------------------------------------- */

void attach_hold(detection *d, sn_index v, sn_index holder, double distance, sn_attach_reason reason);
/* Vertices that the user gave to a bone: no other bone takes them, and none loses them. */
bool attach_is_given(const detection *d, sn_index v);
/* Bones with areas, and all bones where only pins and areas count, hold nothing by distance. */
bool attach_holds_by_distance(const detection *d, sn_index bone);
bool attach_holds_any(const detection *d, sn_index holder);
/* The vertices that a holder has now, ascending, in list (vertex_count). */
sn_index attach_held(const detection *d, sn_index holder, sn_index *list);
/* candidate: the signed distance of every vertex to the bone, where it is within reach; the least of them. */
double attach_measure(detection *d, const sn_bone_search *search, sn_index bone, double reach);

/* ---- attach_patch.c: areas instead of speckles -------------------------------------------------------------------------- */

/* What a bone holds by distance becomes compact patches: gaps closed, holes filled, crumbs dropped, borders smoothed. Into the bone's pair
 * of the report goes what was changed. */
SN_MUST_CHECK sn_status attach_make_patches(detection *d, sn_error *error);
/* Pieces of what a bone holds: piece (vertex_count) is the number of a vertex's piece, from 0, SN_NONE where the bone does not hold it.
 * Pieces are in the order of their lowest vertices. */
SN_MUST_CHECK sn_status attach_pieces(const detection *d, sn_index bone, sn_index *piece, sn_index *count, sn_error *error);

/* ---- attach_slide.c: tendons that slide --------------------------------------------------------------------------------- */

/* along, length, tip: the muscle from tip to tip. */
SN_MUST_CHECK sn_status attach_find_along(detection *d, sn_error *error);
/* Says of every pair where along the muscle it holds, how thick the muscle is there and whether that looks like sliding: of the whole pair,
 * or, with lets_go, of each piece, and those that slide are let go. */
SN_MUST_CHECK sn_status attach_find_sliding(detection *d, bool lets_go, sn_error *error);

/* ---- attach_tip.c: tips that touch nothing ------------------------------------------------------------------------------ */

/* A tip that nothing holds goes to the bone that the muscle plainly runs to. */
SN_MUST_CHECK sn_status attach_take_tips(detection *d, sn_error *error);

#endif
