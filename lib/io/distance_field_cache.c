/*
 * distance_field_cache.c -- a folder of distance fields under the names of what they were built from.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sinew/distance_field.h"
#include "sinew/io.h"

/* FOLDER/HEX.field; NULL = out of memory. */
static char *cache_path(const char *folder, const char *hash) {
    const char *colon = strchr(hash, ':'), *name = colon != NULL ? colon + 1 : hash;
    size_t size = strlen(folder) + strlen(name) + sizeof "/.field";
    char *path = SN_NEW(char, size);
    if (path == NULL) return NULL;
    strcpy(path, folder);
    strcat(strcat(strcat(path, "/"), name), ".field");
    return path;
}

static bool read_cached(const char *path, const char *hash, sn_distance_field *out) {
    sn_blob blob;
    sn_error error = {0};
    if (access(path, F_OK) != 0) return false;
    sn_status status = sn_blob_read_bytes(path, &blob, &error);
    if (status == SN_OK) {
        status = sn_distance_field_load(&blob, hash, out, &error);
        sn_blob_free(&blob);
    }
    if (status != SN_OK) sn_log(SN_LOG_WARNING, "%s: %s; the field is built again", path, error.text);
    return status == SN_OK;
}

/* A field that cannot be kept is as good as one that is: a word in the log is all. */
static void keep(const char *folder, const char *path, const char *hash, const sn_distance_field *field) {
    sn_output *output = NULL;
    sn_error error = {0};
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) sn_log(SN_LOG_WARNING, "%s: cannot make this folder: %s", folder, strerror(errno));
    sn_status status = sn_output_open(path, false, &output, &error);
    if (status == SN_OK) status = sn_distance_field_save(field, hash, output, &error);
    if (status == SN_OK)
        status = sn_output_commit(output, &error);
    else
        sn_output_abort(output);
    if (status != SN_OK) sn_log(SN_LOG_WARNING, "%s: %s; the distance field is not kept", path, error.text);
}

sn_status sn_distance_field_cached(const char *folder, const sn_mesh *mesh, const sn_distance_field_params *params, sn_distance_field *out,
                                   bool *was_read, sn_error *error) {
    char hash[SN_HASH_LENGTH];
    *out = (sn_distance_field){0};
    *was_read = false;
    if (folder == NULL) return sn_distance_field_create(mesh, params, out, error);
    sn_status status = sn_distance_field_hash(mesh, params, hash, error);
    if (status != SN_OK) return status;
    char *path = cache_path(folder, hash);
    if (path == NULL) return sn_fail_memory(error, "a path");
    *was_read = read_cached(path, hash, out);
    if (!*was_read) {
        status = sn_distance_field_create(mesh, params, out, error);
        if (status == SN_OK) keep(folder, path, hash, out);
    }
    free(path);
    return status;
}
