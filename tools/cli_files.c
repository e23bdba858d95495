/* cli_files.c -- the files that a command line names: none twice, no output that cannot be written; before any work. */
#include "cli_given.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct named_file {
    const cli_option *option; /* NULL = an input */
    const char *path;
} named_file;

typedef struct named_files {
    int count;
    named_file *items;
} named_files;

/* ---- what there is ------------------------------------------------------------------------------------------------------------- */

static bool is_overruled(const cli *c, int index) {
    const cli_option *option = c->given[index].option;
    for (int i = index + 1; i < c->given_count && option->kind != CLI_LIST; i++)
        if (c->given[i].option == option) return true;
    return false;
}

/* The file behind "NAME=FILE" or "FILE". */
static const char *file_of(const cli_option *option, const char *value) {
    const char *equals = option->flags & CLI_FILE ? strchr(value, '=') : NULL;
    return equals != NULL && equals[1] != '\0' ? equals + 1 : value;
}

static void collect(const cli *c, named_files *out) {
    out->items = sn_alloc((size_t)c->given_count + (size_t)c->inputs.count + 1, sizeof *out->items);
    for (int i = 0; out->items != NULL && i < c->given_count; i++) {
        const cli_option *option = c->given[i].option;
        if (!(option->flags & (CLI_WRITES | CLI_READS | CLI_FILE | CLI_FILES)) || is_overruled(c, i)) continue;
        out->items[out->count++] = (named_file){option, file_of(option, c->given[i].value)};
    }
    for (int i = 0; out->items != NULL && i < c->inputs.count; i++) out->items[out->count++] = (named_file){NULL, c->inputs.items[i]};
}

static bool is_written(const named_file *f) { return f->option != NULL && (f->option->flags & CLI_WRITES) != 0; }
static bool is_standard(const char *path) { return *path == '\0' || strcmp(path, "-") == 0; }

/* The folder that a path is in, without slashes behind it: in `out`, with room for the path and "." */
static void folder_of(const char *path, char *out) {
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') length--;
    while (length > 0 && path[length - 1] != '/') length--;
    while (length > 1 && path[length - 1] == '/') length--;
    memcpy(out, path, length);
    snprintf(out + length, 2, "%s", length == 0 ? "." : "");
}

/* ---- one file twice ------------------------------------------------------------------------------------------------------------ */

static bool same_inode(const struct stat *a, const struct stat *b) { return a->st_dev == b->st_dev && a->st_ino == b->st_ino; }

/* Of two that are not there: the same name in the same folder. */
static bool same_missing(const char *a, const char *b) {
    struct stat one, other;
    const char *last = strrchr(a, '/'), *other_last = strrchr(b, '/');
    char *folders[2] = {sn_alloc(strlen(a) + 2, 1), sn_alloc(strlen(b) + 2, 1)};
    bool same =
        folders[0] != NULL && folders[1] != NULL && strcmp(last != NULL ? last + 1 : a, other_last != NULL ? other_last + 1 : b) == 0;
    if (same) folder_of(a, folders[0]);
    if (same) folder_of(b, folders[1]);
    same = same && stat(folders[0], &one) == 0 && stat(folders[1], &other) == 0 && same_inode(&one, &other);
    free(folders[0]);
    free(folders[1]);
    return same || strcmp(a, b) == 0;
}

/* Devices and pipes may be written by whoever likes to. */
static bool same_file(const char *a, const char *b) {
    struct stat one, other;
    if (is_standard(a) || is_standard(b)) return false;
    bool there = stat(a, &one) == 0, other_there = stat(b, &other) == 0;
    if (there != other_there) return false;
    if (!there) return same_missing(a, b);
    return (S_ISREG(one.st_mode) || S_ISDIR(one.st_mode)) && same_inode(&one, &other);
}

/* -o over the one input, which is read whole before it is written; a state over the one that a run goes on from. */
static bool may_be_one(const cli *c, const named_file *a, const named_file *b) {
    if (!is_written(a) && !is_written(b)) return true;
    const named_file *in = is_written(a) ? b : a, *out = is_written(a) ? a : b;
    if (is_written(in)) return (in->option->flags & CLI_FOLDER) && (out->option->flags & CLI_FOLDER); /* several may write into one */
    if (in->option == NULL) return (c->tool->shared & CLI_TAKES_INPUT) && strcmp(out->option->name, "output") == 0;
    return (in->option->flags & CLI_STATE) && (out->option->flags & CLI_STATE);
}

static const char *dashes(const named_file *f) { return f->option != NULL ? "--" : ""; }
static const char *word(const named_file *f) { return f->option != NULL ? f->option->name : "the input"; }

static void check_twice(const cli *c, const named_files *files) {
    for (int i = 0; i < files->count; i++)
        for (int k = 0; k < i; k++) {
            const named_file *a = &files->items[k], *b = &files->items[i];
            if (may_be_one(c, a, b) || !same_file(a->path, b->path)) continue;
            cli_usage_error(c, "%s%s %s and %s%s %s are one file, and what is written would replace the other", dashes(a), word(a), a->path,
                            dashes(b), word(b), b->path);
        }
}

/* ---- outputs that cannot be written ---------------------------------------------------------------------------------------------- */

static sn_status refuse(const char *path, sn_error *error) {
    return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be written: %s", strerror(errno));
}

/* Is the folder one that another output will make? */
static bool is_output(const named_files *files, const char *folder) {
    for (int i = 0; i < files->count; i++)
        if (is_written(&files->items[i]) && (files->items[i].option->flags & CLI_FOLDER) && same_missing(files->items[i].path, folder))
            return true;
    return false;
}

/* Files are written beside their names, and then take them. */
static sn_status try_folder(const named_files *files, const char *path, sn_error *error) {
    struct stat info;
    char *folder = sn_alloc(strlen(path) + 2, 1);
    if (folder == NULL) return sn_fail_memory(error, "a path");
    folder_of(path, folder);
    bool good = access(folder, W_OK | X_OK) == 0;
    int reason = errno;
    if (!good && reason == ENOENT) good = is_output(files, folder);
    if (good && stat(folder, &info) == 0 && !S_ISDIR(info.st_mode)) good = false, reason = ENOTDIR;
    free(folder);
    errno = reason;
    return good ? SN_OK : refuse(path, error);
}

static sn_status try_output(const named_files *files, const named_file *file, sn_error *error) {
    struct stat info;
    bool folder = (file->option->flags & CLI_FOLDER) != 0;
    if (is_standard(file->path) || strchr(file->path, '#') != NULL) return SN_OK;
    if (stat(file->path, &info) != 0) return errno == ENOENT ? try_folder(files, file->path, error) : refuse(file->path, error);
    if (!S_ISDIR(info.st_mode) && (file->option->flags & CLI_CACHE))
        return sn_fail_at(error, SN_ERROR_IO, file->path, 0, "is not a folder, which a cache is");
    if (S_ISDIR(info.st_mode) && !folder) return sn_fail_at(error, SN_ERROR_IO, file->path, 0, "is a directory; name a file in it");
    if (access(file->path, S_ISDIR(info.st_mode) ? W_OK | X_OK : W_OK) != 0) return refuse(file->path, error);
    return S_ISREG(info.st_mode) && !(file->option->flags & CLI_IN_PLACE) ? try_folder(files, file->path, error) : SN_OK;
}

sn_status cli_check_files(const cli *c, sn_error *error) {
    named_files files = {0};
    sn_status status = SN_OK;
    collect(c, &files);
    if (files.items == NULL) return sn_fail_memory(error, "the command line");
    check_twice(c, &files);
    for (int i = 0; i < files.count && status == SN_OK; i++)
        if (is_written(&files.items[i])) status = try_output(&files, &files.items[i], error);
    free(files.items);
    return status;
}
