/* scene_contact.h -- contact in scene documents. Private to lib/io. */
#ifndef SINEW_IO_SCENE_CONTACT_H
#define SINEW_IO_SCENE_CONTACT_H

#include "document.h"

/* Of the scene. Lengths are metres. */
SN_MUST_CHECK sn_status sn_contact_parse(const sn_json_value *value, sn_contact_settings *out, sn_error *error);
void sn_contact_write(const sn_scene *scene, sn_json *json);
/* "contact": false of a bone or a muscle. */
SN_MUST_CHECK sn_status sn_contact_left_out_parse(const sn_json_value *object, bool *left_out, sn_error *error);

#endif
