/* model_bones.c -- the bones of a model as files of their own. */
#include "model_bones.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

sn_status model_bones_folder(const char *path, sn_error *error) {
    struct stat info;
    if ((stat(path, &info) == 0 && S_ISDIR(info.st_mode)) || mkdir(path, 0777) == 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot make this folder: %s", strerror(errno));
}

char *model_bones_path(const char *folder, const char *name, const char *ending) {
    size_t length = strlen(folder), size = length + strlen(name) + strlen(ending) + 2;
    char *path = sn_alloc(size, 1);
    if (path != NULL) snprintf(path, size, "%s%s%s%s", folder, length > 0 && folder[length - 1] == '/' ? "" : "/", name, ending);
    return path;
}

static sn_status write_bone(const sn_mesh *mesh, const char *path, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = sn_mesh_write(mesh, SN_MESH_PLY, SN_ENCODING_DEFAULT, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

/* Its file, and its entry in the clip. */
static sn_status save_bone(const sn_model_bones *bones, sn_index index, const char *folder, sn_clip *clip, sn_error *error) {
    const sn_model_bone *from = &bones->bones[index];
    sn_motion_bone *to = &clip->bones[clip->bone_count];
    sn_mesh mesh = {0};
    *to = (sn_motion_bone){
        .name = sn_strdup(from->name), .path = model_bones_path(folder, from->name, ".ply"), .meters_per_unit = 1.0, .joint = from->joint};
    clip->bone_count++;
    if (to->name == NULL || to->path == NULL) return sn_fail_memory(error, "a bone");
    sn_status status = sn_model_bones_load(bones, index, &mesh, error);
    if (status == SN_OK) status = write_bone(&mesh, to->path, error);
    sn_mesh_free(&mesh);
    return status;
}

sn_status model_bones_save(cli *c, const sn_model_bones *bones, const char *folder, sn_clip *clip, sn_error *error) {
    sn_status status = model_bones_folder(folder, error);
    if (status == SN_OK && (clip->bones = SN_NEW(sn_motion_bone, bones->count)) == NULL) status = sn_fail_memory(error, "bones");
    for (sn_index i = 0; i < bones->count && status == SN_OK; i++) {
        status = save_bone(bones, i, folder, clip, error);
        if (status == SN_OK && SN_TRACE(&c->trace, "bone", sn_trace_text("name", bones->bones[i].name))) return SN_STOPPED;
    }
    if (status == SN_OK) cli_say(c, "%d bones in %s", clip->bone_count, folder);
    return status;
}
