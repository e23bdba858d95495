/*
 * cleaning.h -- what the stages of sn_clean share. Private to lib/rig.
 */
#ifndef SINEW_RIG_CLEANING_H
#define SINEW_RIG_CLEANING_H

#include "sinew/rig.h"

/* `found` describes the mesh as it is: a stage that changes it looks again. */
typedef struct sn_cleaning {
    const sn_clean_params *params;
    sn_trace *trace;
    const sn_mesh *input; /* finite */
    sn_mesh *mesh;
    sn_mesh_report found;
    sn_clean_report *report;
    sn_error *error;
} sn_cleaning;

SN_MUST_CHECK sn_status sn_cleaning_look(sn_cleaning *c);
/* Nothing left is an error: `after` says after what. */
SN_MUST_CHECK sn_status sn_cleaning_need_triangles(const sn_cleaning *c, const char *after);
/* Turn components that are inside out. */
SN_MUST_CHECK sn_status sn_cleaning_outward(sn_cleaning *c);
/* The same vertices and triangles in the same order. */
bool sn_cleaning_is_same(const sn_mesh *a, const sn_mesh *b);
/* Pairs of triangles that cross now, in found.self_intersections; still -1 where there are too many to tell (clean_crossings.c). */
SN_MUST_CHECK sn_status sn_cleaning_count_crossings(sn_cleaning *c);
/* Where repair has made crossings: cut them out and fill anew. */
SN_MUST_CHECK sn_status sn_cleaning_undo_crossings(sn_cleaning *c);
/* More than the input has? Not where either was not counted. */
bool sn_cleaning_has_more_crossings(const sn_cleaning *c);
/* Counts for the report, where what changed can have changed them. */
SN_MUST_CHECK sn_status sn_cleaning_report_crossings(sn_cleaning *c);
/* Keep the largest components, and list the others in the report (clean_keep.c). */
SN_MUST_CHECK sn_status sn_cleaning_keep(sn_cleaning *c);
/* How much of the input is lost by now; wrap where that, or what is still open, asks for it (clean_wrap.c). */
SN_MUST_CHECK sn_status sn_cleaning_measure_loss(sn_cleaning *c);
SN_MUST_CHECK sn_status sn_cleaning_wrap(sn_cleaning *c);
/* Remesh, decimate, smooth and flip slivers on request, keeping the volume (clean_refine.c). */
SN_MUST_CHECK sn_status sn_cleaning_refine(sn_cleaning *c);

/* Nearer than this share of the diagonal a triangle of the input counts as still there. */
#define SN_LOST_REACH 0.005
/* A closed surface with less volume than this share of area x diagonal is a sheet, folded flat. */
#define SN_TINY_VOLUME 1e-9
bool sn_cleaning_is_flat(const sn_mesh_report *found);

static inline sn_status sn_stop_if(bool stop) { return stop ? SN_STOPPED : SN_OK; }

#endif
