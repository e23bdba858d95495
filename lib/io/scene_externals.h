/* scene_externals.h -- the external constraints of a scene document. Private to lib/io. */
#ifndef SINEW_IO_SCENE_EXTERNALS_H
#define SINEW_IO_SCENE_EXTERNALS_H

#include "document.h"

/* The member "externals" of a scene; nothing where it is absent. */
SN_MUST_CHECK sn_status sn_scene_externals_parse(const sn_json_value *value, sn_external_settings *out, sn_error *error);
/* "externals": false of a muscle. */
SN_MUST_CHECK sn_status sn_scene_externals_left_out(const sn_json_value *object, bool *left_out, sn_error *error);
void sn_scene_externals_write(const sn_scene *scene, sn_json *json);

#endif
