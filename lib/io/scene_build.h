/* scene_build.h -- what the parts of building a scene share. Private to lib/io. */
#ifndef SINEW_IO_SCENE_BUILD_H
#define SINEW_IO_SCENE_BUILD_H

#include "document.h"
#include "sinew/scene_build.h"

/* ---- scene_build_write.c ------------------------------------------------------------------------------------------------------- */

/* A scene of this muscle alone, without its rig, and of this member's value alone: text to judge the value by. */
SN_MUST_CHECK sn_status sn_draft_probe(const sn_scene_draft *draft, const sn_draft_muscle *muscle, int member, sn_blob *out,
                                       sn_error *error);

/* ---- scene_build_set.c --------------------------------------------------------------------------------------------------------- */

/* The value that a setting's text is, as the member "value" of an object: JSON, or a word as a string. Free with sn_json_tree_free. */
SN_MUST_CHECK sn_status sn_draft_value_parse(const char *text, sn_json_tree **out, sn_error *error);

/* ---- scene_document.c ---------------------------------------------------------------------------------------------------------- */

/* sn_scene_parse with bones, where the rigs have been read: rigs (one for each muscle of the text) are taken out of the list and left all
 * zeros. */
SN_MUST_CHECK sn_status sn_scene_parse_around(const sn_blob *blob, sn_muscle *rigs, sn_scene *out, sn_error *error);

#endif
