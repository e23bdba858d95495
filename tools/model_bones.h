/* model_bones.h -- the bones of a model as files of their own: of motion-import, and of scene-build. */
#ifndef SINEW_TOOLS_MODEL_BONES_H
#define SINEW_TOOLS_MODEL_BONES_H

#include "cli.h"
#include "sinew/model_files.h"

/* Make the folder, where it is not there. */
SN_MUST_CHECK sn_status model_bones_folder(const char *path, sn_error *error);
/* "FOLDER/NAMEENDING"; NULL = out of memory. */
char *model_bones_path(const char *folder, const char *name, const char *ending);
/* Write each into the folder, which is made, as a PLY file in metres, and list it in the clip on its joint. A trace that stops leaves the
 * others out (SN_STOPPED). */
SN_MUST_CHECK sn_status model_bones_save(cli *c, const sn_model_bones *bones, const char *folder, sn_clip *clip, sn_error *error);

#endif
