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
/* PREFIX.0000 and a suffix, numbered by frame. NULL = out of memory. */
char *frame_number(const char *prefix, sn_index frame, const char *suffix);
/* Files that are there under such names. count 0 = none, or no such folder. */
typedef struct frame_sequence {
    int64_t count;
    sn_index first, last;
} frame_sequence;
SN_MUST_CHECK sn_status frame_sequence_find(const char *prefix, const char *suffix, frame_sequence *out, sn_error *error);
/* The frames that a run will write; goes_on: behind those that an earlier one has written. */
typedef struct frame_range {
    sn_index first, last;
    bool goes_on;
} frame_range;
/* SN_ERROR_USAGE where there are files of the sequence that the run would neither write nor go on with. */
SN_MUST_CHECK sn_status frame_sequence_check(const char *prefix, const char *suffix, const frame_range *range, sn_error *error);
/* PREFIX.0000.ply, numbered by frame; it appears whole. */
SN_MUST_CHECK sn_status frame_write_ply(const char *prefix, sn_index frame, const sn_mesh *mesh, sn_error *error);

#endif
