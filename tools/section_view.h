/*
 * section_view.h -- the part of rig-view that draws candidates for external constraints, in space and in a section.
 */
#ifndef SINEW_TOOLS_SECTION_VIEW_H
#define SINEW_TOOLS_SECTION_VIEW_H

#include "bones.h"
#include "sinew/view.h"

/* The rigs of --neighbours. */
typedef struct rig_list {
    bone_list files;
    sn_muscle *muscles; /* (files.count) */
    char **names;       /* (files.count) as attach-detect --muscles calls them */
} rig_list;

SN_MUST_CHECK sn_status rigs_load(const cli *c, const cli_list *lists, rig_list *out, sn_error *error); /* wrong usage exits */
void rigs_free(rig_list *rigs);

typedef struct section_request {
    const char *plane; /* px,py,pz,nx,ny,nz in the muscle's unit, or an axis: across the middle of the muscle's box */
    sn_length depth;   /* value < 0: a mean edge */
    const bone_list *bones;
    const rig_list *rigs;
} section_request;

void section_check(const cli *c, const char *plane, sn_length depth); /* wrong usage exits */
sn_camera section_camera(const char *plane); /* looks at it from the side that its normal points to; z up, or y where that is the normal */
SN_MUST_CHECK sn_status section_add(sn_view *view, const sn_muscle *muscle, const section_request *request, sn_error *error);
SN_MUST_CHECK sn_status rows_add(sn_view *view, const sn_muscle *muscle, const rig_list *rigs, sn_error *error);

#endif
