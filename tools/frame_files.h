/* frame_files.h -- where simulate puts frames: folders, names of files in them, sequences of meshes. */
#ifndef SINEW_TOOLS_FRAME_FILES_H
#define SINEW_TOOLS_FRAME_FILES_H

#include "cli.h"

bool frame_folder_is(const char *path);
SN_MUST_CHECK sn_status frame_folder_make(const char *path, sn_error *error); /* it may be there */
/* "FOLDER/NAME" and a suffix; a '/' in the name becomes '_', and a dot that it begins with. NULL = out of memory. */
char *frame_path(const char *folder, const char *name, const char *suffix);
/* Are the names of two things one name as files, that of b with a suffix? */
bool frame_names_clash(const char *a, const char *b, const char *suffix);
/* PREFIX.0000.ply, numbered by frame; it appears whole. */
SN_MUST_CHECK sn_status frame_write_ply(const char *prefix, sn_index frame, const sn_mesh *mesh, sn_error *error);

#endif
