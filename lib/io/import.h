/* import.h -- formats that sinew does not read itself. Private to lib/io. */
#ifndef SINEW_IO_IMPORT_H
#define SINEW_IO_IMPORT_H

#include "sinew/io.h"

/* Read a mesh of a format that sn_import_detect knows, in a child process. Errors are one sentence, also where the child dies,
 * hangs, asks for too much memory or answers nonsense. */
SN_MUST_CHECK sn_status sn_import_parse(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error);

/* Is this JSON text a glTF file: an "asset" on the top level, and no "format" before it (lib/io/detect.c)? */
bool sn_gltf_detect(const sn_blob *blob);

#endif
