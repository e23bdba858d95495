/* fit_align.h -- what the parts of the fit share. Private to lib/motion. */
#ifndef SINEW_MOTION_FIT_ALIGN_H
#define SINEW_MOTION_FIT_ALIGN_H

#include "sinew/motion_fit.h"

/* The least rotation that takes one unit vector to another; half a turn about some axis where they are opposite. */
sn_quat sn_fit_least_turn(sn_vec3 from, sn_vec3 to);
/* What turns the source's rest pose onto the body's at one joint, given that of its parent (the identity for the root), world. */
SN_MUST_CHECK sn_status sn_fit_align_joint(const sn_fit_body *body, const sn_clip *source, sn_index joint, sn_quat parent, sn_quat *out,
                                           sn_error *error);

/* Does the foot at `top` stand, from each frame to the next: out (frame_count)? The lowest of the source's joints that drive it, and of
 * their ends, goes slower than `speed`: by the source, so that what a fit makes slide is not left out. */
void sn_fit_stands(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, sn_index top, double speed, bool *out);
/* Turn and shift the clip so that the floor of standing feet is level, at z = 0. */
SN_MUST_CHECK sn_status sn_fit_put_on_floor(const sn_fit_body *body, const sn_clip *source, sn_fit_result *fit, sn_error *error);

#endif
