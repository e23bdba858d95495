/* scene_surfaces.h -- the surfaces of a scene document. Private to lib/io. */
#ifndef SINEW_IO_SCENE_SURFACES_H
#define SINEW_IO_SCENE_SURFACES_H

#include "motion_document.h"

/* What the document says of each; an absent list leaves the scene without. */
SN_MUST_CHECK sn_status sn_scene_surfaces_parse(const sn_json_value *value, sn_scene *scene, sn_error *error);
/* Load the files of those that carry an enabled muscle, or of all. The scene's motion, bones and muscles have been read. */
SN_MUST_CHECK sn_status sn_scene_surfaces_load(const char *document, bool all, sn_scene *scene, sn_error *error);
void sn_scene_surfaces_write(const sn_scene *scene, sn_json *json);

#endif
