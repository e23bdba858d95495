/*
 * grips.h -- warnings of bones that hold a muscle badly: of attach-detect, which finds them, and of simulate, which suffers from them.
 */
#ifndef SINEW_TOOLS_GRIPS_H
#define SINEW_TOOLS_GRIPS_H

#include "cli.h"

/* Warn where one bone alone holds the muscle, where a bone holds next to nothing of the end it is at, and where it holds speckles. The name
 * is nullable. Nothing changes but the standard error. */
SN_MUST_CHECK sn_status grips_warn(const cli *c, const char *name, const sn_muscle *muscle, sn_error *error);

#endif
