/* frame_files.c -- folders of frames, and sequences of meshes in them. */
#include "frame_files.h"

#include <dirent.h>
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

char *frame_number(const char *prefix, sn_index frame, const char *suffix) {
    size_t size = strlen(prefix) + strlen(suffix) + 32;
    char *path = sn_alloc(size, 1);
    if (path != NULL) snprintf(path, size, "%s.%04d%s", prefix, (int)frame, suffix);
    return path;
}

/* The number of a file of the sequence whose last part is `base`: "BASE.0012.ply", and no other way to write 12. */
static bool number_of(const char *name, const char *base, const char *suffix, sn_index *frame) {
    size_t length = strlen(base), all = strlen(name), tail = strlen(suffix);
    int64_t number;
    const char *next;
    char digits[32];
    if (all <= length + 1 + tail || strncmp(name, base, length) != 0 || name[length] != '.' || strcmp(name + all - tail, suffix) != 0)
        return false;
    const char *from = name + length + 1, *end = name + all - tail;
    if (!sn_scan_integer(from, end, &next, &number) || next != end || number < -SN_INDEX_MAX || number > SN_INDEX_MAX) return false;
    *frame = (sn_index)number;
    snprintf(digits, sizeof digits, "%04d", (int)number);
    return strlen(digits) == (size_t)(end - from) && strncmp(digits, from, strlen(digits)) == 0;
}

sn_status frame_sequence_find(const char *prefix, const char *suffix, frame_sequence *out, sn_error *error) {
    const char *slash = strrchr(prefix, '/'), *base = slash != NULL ? slash + 1 : prefix;
    char *folder = slash == NULL ? sn_strdup(".") : sn_strndup(prefix, (size_t)(slash - prefix) + 1);
    *out = (frame_sequence){0};
    if (folder == NULL) return sn_fail_memory(error, "the frames");
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory != NULL && (entry = readdir(directory)) != NULL;) {
        sn_index frame;
        if (!number_of(entry->d_name, base, suffix, &frame)) continue;
        if (out->count == 0 || frame < out->first) out->first = frame;
        if (out->count == 0 || frame > out->last) out->last = frame;
        out->count++;
    }
    if (directory != NULL) closedir(directory);
    free(folder);
    return SN_OK;
}

sn_status frame_sequence_check(const char *prefix, const char *suffix, const frame_range *range, sn_error *error) {
    frame_sequence there;
    sn_status status = frame_sequence_find(prefix, suffix, &there, error);
    bool below = !range->goes_on && there.first < range->first;
    if (status != SN_OK || there.count == 0 || (!below && there.last <= range->last)) return status;
    char *path = frame_number(prefix, below ? there.first : there.last, suffix);
    if (path == NULL) return sn_fail_memory(error, "the frames");
    status = sn_fail_at(
        error, SN_ERROR_USAGE, path, 0,
        "is of an older sequence, whose frames %ld to %ld would mix with the run's, %ld to %ld; remove it, or name another folder",
        (long)there.first, (long)there.last, (long)range->first, (long)range->last);
    free(path);
    return status;
}

sn_status frame_write_ply(const char *prefix, sn_index frame, const sn_mesh *mesh, sn_error *error) {
    char *path = frame_number(prefix, frame, ".ply");
    sn_output *output = NULL;
    if (path == NULL) return sn_fail_memory(error, "the frames");
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = sn_mesh_write(mesh, SN_MESH_PLY, SN_ENCODING_LITTLE, output, error);
    if (status == SN_OK)
        status = sn_output_commit(output, error);
    else
        sn_output_abort(output);
    free(path);
    return status;
}
