/* motion_view.h -- the part of rig-view that draws motion documents. */
#ifndef SINEW_TOOLS_MOTION_VIEW_H
#define SINEW_TOOLS_MOTION_VIEW_H

#include "frame_list.h"
#include "sinew/view.h"

typedef struct motion_request {
    const cli *c;
    const char *path;  /* for messages and the title */
    unsigned show;     /* bits of sn_view_show */
    frame_list frames; /* empty = as spread says */
    int64_t spread;    /* this many frames, evenly over the motion; 0 = its first alone */
} motion_request;

/* The picture of one frame. */
typedef struct motion_picture {
    sn_view view;
    char *caption; /* owned */
} motion_picture;

/* One picture a frame, each on the same floor: the lowest of the joints over the motion, and of the bones in these frames. Meshes of the
 * bones are read only where `show` has them; one that cannot be read is an error. *out and all in it is the caller's. */
SN_MUST_CHECK sn_status motion_pictures(const motion_request *request, const sn_blob *blob, motion_picture **out, sn_index *count,
                                        sn_error *error);
void motion_pictures_free(motion_picture *pictures, sn_index count);

#endif
