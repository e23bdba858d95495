/* fit_align.h -- private to fit.c and fit_align.c. */
#ifndef SINEW_MOTION_FIT_ALIGN_H
#define SINEW_MOTION_FIT_ALIGN_H

#include "sinew/motion_fit.h"

/* The least rotation that takes one unit vector to another; half a turn about some axis where they are opposite. */
sn_quat sn_fit_least_turn(sn_vec3 from, sn_vec3 to);
/* What turns the source's rest pose onto the body's at one joint, given that of its parent (the identity for the root), world. */
SN_MUST_CHECK sn_status sn_fit_align_joint(const sn_fit_body *body, const sn_clip *source, sn_index joint, sn_quat parent, sn_quat *out,
                                           sn_error *error);

#endif
