/* documents.h -- what the tests of documents share: a folder of their own, texts as blobs, output as text, what the log has said. */
#ifndef SINEW_TESTS_DOCUMENTS_H
#define SINEW_TESTS_DOCUMENTS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "sinew/io.h"

static char folder[64];
static char logged[8192]; /* every message since the last reset, one a line */

static inline void keep_log(void *user, sn_log_level level, const char *text) {
    (void)user;
    (void)level;
    size_t used = strlen(logged);
    snprintf(logged + used, sizeof logged - used, "%s\n", text);
}

static inline int make_folder(void **state) {
    (void)state;
    sn_log_set(keep_log, NULL);
    strcpy(folder, "/tmp/sinew-test-XXXXXX");
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static inline int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static inline int forget_log(void **state) {
    (void)state;
    logged[0] = '\0';
    return 0;
}

/* A path in the folder; one at a time. */
static inline const char *path_of(const char *name) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* A file of the folder that has not been written: its name is what errors and relative paths go by. */
static inline sn_blob blob_of(const char *name, const char *text) {
    sn_blob blob = {.name = sn_strdup(path_of(name)), .data = sn_strdup(text), .size = strlen(text)};
    assert_non_null(blob.name);
    assert_non_null(blob.data);
    return blob;
}

static inline void write_file(const char *name, const char *text) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static inline sn_output *open_output(void) {
    sn_output *output;
    assert_int_equal(sn_output_open(path_of("output"), false, &output, NULL), SN_OK);
    return output;
}

/* What was written to open_output(); allocated. */
static inline char *commit_output(sn_output *output) {
    sn_blob blob;
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    assert_int_equal(sn_blob_read(path_of("output"), &blob, NULL), SN_OK);
    char *text = sn_strdup(blob.data);
    sn_blob_free(&blob);
    return text;
}

/* text with the first `old` replaced; allocated. */
static inline char *replace(const char *text, const char *old, const char *new) {
    const char *at = strstr(text, old);
    assert_non_null(at);
    size_t size = strlen(text) + strlen(new) + 1;
    char *result = sn_alloc(size, 1);
    assert_non_null(result);
    snprintf(result, size, "%.*s%s%s", (int)(at - text), text, new, at + strlen(old));
    return result;
}

static inline void assert_contains(const char *text, const char *part) {
    if (strstr(text, part) == NULL) fail_msg("'%s' is not in '%s'", part, text);
}

static inline void assert_lacks(const char *text, const char *part) {
    if (strstr(text, part) != NULL) fail_msg("'%s' is in '%s'", part, text);
}

#endif
