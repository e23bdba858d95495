/* scene_list.h -- what would be in a scene, a line each: scene-build --list. */
#ifndef SINEW_TOOLS_SCENE_LIST_H
#define SINEW_TOOLS_SCENE_LIST_H

#include "cli.h"
#include "sinew/scene_build.h"

/* To standard output, fields parted by tabs. Returns SN_STOPPED, as nothing is left to be done. */
SN_MUST_CHECK sn_status scene_list_print(const sn_scene_draft *draft, sn_error *error);

#endif
