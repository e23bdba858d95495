/* frame_files.c -- folders of frames, and sequences of meshes in them. */
#include "frame_files.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool frame_folder_is(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

sn_status frame_folder_make(const char *path, sn_error *error) {
    if (frame_folder_is(path) || mkdir(path, 0777) == 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot make this folder: %s", strerror(errno));
}

/* Letter i of a name as a file has it; a dot before it would hide the file. */
static char in_file(const char *name, size_t i) { return name[i] == '/' || (i == 0 && name[i] == '.') ? '_' : name[i]; }

char *frame_path(const char *folder, const char *name, const char *suffix) {
    size_t size = strlen(folder) + strlen(name) + strlen(suffix) + 2;
    char *path = sn_alloc(size, 1);
    if (path == NULL) return NULL;
    size_t start = (size_t)snprintf(path, size, "%s%s", folder, folder[strlen(folder) - 1] == '/' ? "" : "/");
    snprintf(path + start, size - start, "%s%s", name, suffix);
    for (size_t i = 0; i < strlen(name); i++) path[start + i] = in_file(name, i);
    return path;
}

bool frame_names_clash(const char *a, const char *b, const char *suffix) {
    size_t length = strlen(b);
    if (strlen(a) != length + strlen(suffix)) return false;
    for (size_t i = 0; i < length; i++)
        if (in_file(a, i) != in_file(b, i)) return false;
    for (size_t i = 0; suffix[i] != '\0'; i++)
        if (in_file(a, length + i) != suffix[i]) return false;
    return true;
}

sn_status frame_write_ply(const char *prefix, sn_index frame, const sn_mesh *mesh, sn_error *error) {
    size_t size = strlen(prefix) + 32;
    char *path = sn_alloc(size, 1);
    sn_output *output = NULL;
    if (path == NULL) return sn_fail_memory(error, "the frames");
    snprintf(path, size, "%s.%04d.ply", prefix, (int)frame);
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = sn_mesh_write(mesh, SN_MESH_PLY, SN_ENCODING_LITTLE, output, error);
    if (status == SN_OK)
        status = sn_output_commit(output, error);
    else
        sn_output_abort(output);
    free(path);
    return status;
}
