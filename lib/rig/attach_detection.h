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
    sn_index *area_of;     /* (vertex_count) the area given that took it; SN_NONE = none */
    double *distance;      /* (vertex_count) signed, to the holder; NaN = not known */
    double *runner_up;     /* (vertex_count) signed, to the nearest other bone that would take it; INFINITY = none */
    unsigned char *reason; /* (vertex_count) sn_attach_reason that attached it */
    double *candidate;     /* (vertex_count) signed, to the bone under search; INFINITY = out of reach */
    sn_index *list;        /* (vertex_count) scratch */
    double *chunk_nearest; /* (chunks) */
    double *vertex_area;   /* (vertex_count) a third of the triangles around it */
    double *along;         /* (vertex_count) 0 at one tip of the muscle, 1 at the other; NaN on other components, or not known yet */
    double *fiber_ends;    /* (2 x polylines of the muscle) how far along each end of a fibre lies; NULL = there are none */
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
/* Do the document's fibres pass a stretch of the muscle: some end before it, some behind it, and none at it? False without fibres. */
bool attach_fibers_pass(const detection *d, double low, double high);
/* Says of every pair where along the muscle it holds, how thick the muscle is there and whether that looks like sliding: of the whole pair,
 * or, with lets_go, of each piece, and those that slide are let go. */
SN_MUST_CHECK sn_status attach_find_sliding(detection *d, bool lets_go, sn_error *error);

/* How thick the muscle is: surface area of each twentieth of it, relative to the largest; and six times the largest area: each triangle
 * counts with its double area at each of its corners. */
enum { GIRTH_SLICES = 20 };
typedef struct girth_profile {
    double girth[GIRTH_SLICES], largest;
} girth_profile;
void attach_measure_girth(const detection *d, girth_profile *p);
/* Lets a vertex go, as a tendon slides there. */
void attach_let_slide(detection *d, sn_index v, sn_attach_pair *pair);

/* ---- attach_run.c: tendons that run along a bone ------------------------------------------------------------------------- */

/* A patch that runs along a tendon, as the long head of biceps runs along its groove, is let go but for its end; the end goes to the bone
 * that the tendon runs on to, where there is one. */
SN_MUST_CHECK sn_status attach_let_runs_go(detection *d, sn_error *error);

/* ---- attach_tip.c: tips that touch nothing ------------------------------------------------------------------------------ */

/* A tip that nothing holds goes to the bone that the muscle plainly runs to. */
SN_MUST_CHECK sn_status attach_take_tips(detection *d, sn_error *error);
/* How far along from a tip a vertex is: 0 at the tip, 1 at the other. */
double attach_from_tip(const detection *d, int end, sn_index v);
/* The bone nearest to a tip within 5 % of the length, no farther from it than `than` is, which does not count, nor do bones that hold
 * something; SN_NONE = there is none. */
SN_MUST_CHECK sn_status attach_next_bone(const detection *d, sn_index than, int end, sn_index *bone, sn_error *error);
/* The bone takes what lies at a tip nearest to it. */
SN_MUST_CHECK sn_status attach_take_tip(detection *d, sn_index bone, int end, sn_error *error);

#endif
