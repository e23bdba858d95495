/* clip.h -- clips as output. */
#ifndef SINEW_TOOLS_CLIP_H
#define SINEW_TOOLS_CLIP_H

#include "cli.h"

/* Write a clip to the output as a motion document, with a history behind that of `source`, which it was made from (nullable: no motion
 * document). */
SN_MUST_CHECK sn_status cli_save_clip(const cli *c, const sn_clip *clip, const sn_blob *source, sn_error *error);

#endif
