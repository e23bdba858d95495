/* folder.c -- the files of a folder as inputs, in an order that no file system changes. */
#include "folder.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>

bool folder_is(const char *path) {
    DIR *folder = opendir(path);
    if (folder != NULL) closedir(folder);
    return folder != NULL;
}

static int compare_entries(const struct dirent **a, const struct dirent **b) { return strcmp((*a)->d_name, (*b)->d_name); }

static char *join_path(const char *folder, const char *name) {
    size_t length = strlen(folder), slash = length > 0 && folder[length - 1] == '/' ? 0 : 1;
    char *path = sn_alloc(length + slash + strlen(name) + 1, 1);
    if (path == NULL) return NULL;
    memcpy(path, folder, length);
    path[length] = '/';
    memcpy(path + length + slash, name, strlen(name));
    return path;
}

sn_status folder_list(const char *folder, bool (*wanted)(const char *name), char ***paths, int *count, sn_error *error) {
    struct dirent **entries = NULL;
    int all = scandir(folder, &entries, NULL, compare_entries);
    *count = 0;
    *paths = all >= 0 ? SN_NEW(char *, all) : NULL;
    if (all < 0) return sn_fail_at(error, SN_ERROR_IO, folder, 0, "the folder cannot be read");
    bool made = *paths != NULL;
    for (int i = 0; i < all; i++) {
        if (made && wanted(entries[i]->d_name)) made = ((*paths)[(*count)++] = join_path(folder, entries[i]->d_name)) != NULL;
        free(entries[i]);
    }
    free(entries);
    if (made) return SN_OK;
    folder_free(*paths, *count);
    *paths = NULL, *count = 0;
    return sn_fail_memory(error, "the files of a folder");
}

void folder_free(char **paths, int count) {
    for (int i = 0; i < count && paths != NULL; i++) free(paths[i]);
    free(paths);
}
