/* test_stream.c -- whole files in, all or nothing out. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sinew/io.h"

static char folder[256];

static const char *in_folder(const char *name) {
    static char path[4][512];
    static int next;
    char *out = path[next++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", folder, name);
    return out;
}

static void put_file(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static void expect_content(const char *path, const char *text) {
    sn_blob blob;
    sn_error error = {0};
    assert_int_equal(sn_blob_read(path, &blob, &error), SN_OK);
    assert_int_equal(blob.size, strlen(text));
    assert_string_equal(blob.data, text);
    sn_blob_free(&blob);
}

static int files_in_folder(void) {
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    int count = 0;
    while (readdir(dir) != NULL) count++;
    closedir(dir);
    return count - 2;
}

static int make_folder(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/sinew-stream-XXXXXX", base != NULL ? base : "/tmp");
    return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state) {
    (void)state;
    DIR *dir = opendir(folder);
    if (dir == NULL) return 1;
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
        if (entry->d_name[0] != '.' || strlen(entry->d_name) > 2) unlink(in_folder(entry->d_name));
    }
    closedir(dir);
    return rmdir(folder);
}

static sn_output *open_output(const char *path, bool stream) {
    sn_output *output;
    sn_error error = {0};
    sn_status status = sn_output_open(path, stream, &output, &error);
    if (status != SN_OK) fail_msg("%s: %s", error.file, error.text);
    return output;
}

static void reads_files_pipes_and_nothing(void **state) {
    (void)state;
    put_file(in_folder("empty"), "");
    expect_content(in_folder("empty"), "");
    put_file(in_folder("some"), "one\ntwo");
    expect_content(in_folder("some"), "one\ntwo");
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(write(ends[1], "piped", 5), 5);
    close(ends[1]);
    int saved = dup(STDIN_FILENO);
    dup2(ends[0], STDIN_FILENO);
    sn_blob blob;
    sn_error error = {0};
    assert_int_equal(sn_blob_read("-", &blob, &error), SN_OK);
    dup2(saved, STDIN_FILENO);
    close(saved);
    close(ends[0]);
    assert_string_equal(blob.name, "<stdin>");
    assert_string_equal(blob.data, "piped");
    sn_blob_free(&blob);
}

static void names_what_cannot_be_read(void **state) {
    (void)state;
    sn_blob blob;
    sn_error error = {0};
    assert_int_equal(sn_blob_read("/no/such/file", &blob, &error), SN_ERROR_IO);
    assert_string_equal(error.file, "/no/such/file");
    assert_non_null(strstr(error.text, "No such file"));
    error = (sn_error){0};
    assert_int_equal(sn_blob_read(folder, &blob, &error), SN_ERROR_IO);
    assert_non_null(strstr(error.text, "directory"));
}

static void nothing_is_seen_before_commit(void **state) {
    (void)state;
    const char *path = in_folder("target");
    put_file(path, "old");
    int before = files_in_folder();
    sn_output *output = open_output(path, false);
    assert_int_equal(sn_output_write(output, "new", 3, NULL), SN_OK);
    expect_content(path, "old");
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    expect_content(path, "new");
    assert_int_equal(files_in_folder(), before);
}

static void an_aborted_output_leaves_no_trace(void **state) {
    (void)state;
    int before = files_in_folder();
    sn_output *output = open_output(in_folder("never"), false);
    for (int i = 0; i < 100000; i++) sn_output_print(output, "%d\n", i);
    sn_output_abort(output);
    assert_int_equal(access(in_folder("never"), F_OK), -1);
    assert_int_equal(files_in_folder(), before);
}

static void modes_are_those_of_the_target_or_the_umask(void **state) {
    (void)state;
    struct stat info;
    mode_t old = umask(027);
    assert_int_equal(sn_output_commit(open_output(in_folder("fresh"), false), NULL), SN_OK);
    umask(old);
    assert_int_equal(stat(in_folder("fresh"), &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(chmod(in_folder("fresh"), 0604), 0);
    assert_int_equal(sn_output_commit(open_output(in_folder("fresh"), false), NULL), SN_OK);
    assert_int_equal(stat(in_folder("fresh"), &info), 0);
    assert_int_equal(info.st_mode & 0777, 0604);
}

static void a_link_stays_a_link(void **state) {
    (void)state;
    put_file(in_folder("real"), "old");
    assert_int_equal(symlink("real", in_folder("link")), 0);
    sn_output *output = open_output(in_folder("link"), false);
    sn_output_print(output, "through");
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    struct stat info;
    assert_int_equal(lstat(in_folder("link"), &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    expect_content(in_folder("real"), "through");
}

static void large_output_and_long_prints_arrive_whole(void **state) {
    (void)state;
    size_t size = 300000;
    char *text = malloc(size + 1);
    assert_non_null(text);
    for (size_t i = 0; i < size; i++) text[i] = (char)('a' + i % 26);
    text[size] = '\0';
    sn_output *output = open_output(in_folder("large"), false);
    sn_output_print(output, "%s", text);
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    expect_content(in_folder("large"), text);
    free(text);
}

static void patches_early_bytes(void **state) {
    (void)state;
    sn_output *output = open_output(in_folder("patched"), false);
    for (int i = 0; i < 20000; i++) sn_output_write(output, "0123456789", 10, NULL);
    assert_int_equal(sn_output_patch(output, 3, "xyz", 3, NULL), SN_OK);
    assert_int_equal(sn_output_patch(output, 199998, "xyz", 3, NULL), SN_ERROR_USAGE);
    sn_output_print(output, "end");
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    sn_blob blob;
    assert_int_equal(sn_blob_read(in_folder("patched"), &blob, NULL), SN_OK);
    assert_int_equal(blob.size, 200003);
    assert_memory_equal(blob.data, "012xyz6789", 10);
    assert_string_equal(blob.data + 200000, "end");
    sn_blob_free(&blob);
}

static void a_full_device_is_an_error(void **state) {
    (void)state;
    sn_error error = {0};
    sn_output *output = open_output("/dev/full", false);
    sn_output_print(output, "something");
    assert_int_equal(sn_output_commit(output, &error), SN_ERROR_IO);
    assert_string_equal(error.file, "/dev/full");
    assert_non_null(strstr(error.text, "No space left"));
    struct stat info;
    assert_int_equal(stat("/dev/full", &info), 0);
    assert_true(S_ISCHR(info.st_mode)); /* written to, not replaced */
}

static void the_first_failure_is_kept(void **state) {
    (void)state;
    sn_error error = {0};
    sn_output *output = open_output("/dev/full", true);
    assert_int_equal(sn_output_write(output, "line\n", 5, &error), SN_ERROR_IO);
    assert_int_equal(sn_output_print(output, "more\n"), SN_ERROR_IO);
    assert_int_equal(sn_output_commit(output, &error), SN_ERROR_IO);
}

static void stdout_is_silent_until_commit(void **state) {
    (void)state;
    int saved = dup(STDOUT_FILENO), ends[2];
    assert_int_equal(pipe(ends), 0);
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    dup2(ends[1], STDOUT_FILENO);
    sn_output *output = open_output("-", false);
    sn_output_print(output, "held\n");
    char got[16];
    ssize_t early = read(ends[0], got, sizeof got);
    sn_status status = sn_output_commit(output, NULL);
    ssize_t late = read(ends[0], got, sizeof got);
    output = open_output("-", true);
    sn_output_print(output, "whole\npart");
    ssize_t lines = read(ends[0], got, sizeof got);
    sn_output_abort(output);
    ssize_t rest = read(ends[0], got, sizeof got);
    dup2(saved, STDOUT_FILENO);
    close(saved);
    close(ends[0]);
    close(ends[1]);
    assert_int_equal(early, -1);
    assert_int_equal(status, SN_OK);
    assert_int_equal(late, 5);
    assert_int_equal(lines, 6); /* whole lines only */
    assert_int_equal(rest, -1);
}

static void a_stream_to_a_file_shows_whole_lines(void **state) {
    (void)state;
    put_file(in_folder("log"), "an older and longer log\n");
    sn_output *output = open_output(in_folder("log"), true);
    expect_content(in_folder("log"), "an older and longer log\n");
    sn_output_print(output, "first\nsec");
    expect_content(in_folder("log"), "first\n");
    sn_output_print(output, "ond\n");
    assert_int_equal(sn_output_commit(output, NULL), SN_OK);
    expect_content(in_folder("log"), "first\nsecond\n");
}

static void names_what_cannot_be_written(void **state) {
    (void)state;
    sn_output *output;
    sn_error error = {0};
    assert_int_equal(sn_output_open("/no/such/folder/file", false, &output, &error), SN_ERROR_IO);
    assert_string_equal(error.file, "/no/such/folder/file");
    assert_null(output);
    error = (sn_error){0};
    assert_int_equal(sn_output_open(folder, false, &output, &error), SN_ERROR_IO);
    assert_non_null(strstr(error.text, "directory"));
    assert_int_equal(sn_output_open("", false, &output, &error), SN_ERROR_IO);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_files_pipes_and_nothing),
        cmocka_unit_test(names_what_cannot_be_read),
        cmocka_unit_test(nothing_is_seen_before_commit),
        cmocka_unit_test(an_aborted_output_leaves_no_trace),
        cmocka_unit_test(modes_are_those_of_the_target_or_the_umask),
        cmocka_unit_test(a_link_stays_a_link),
        cmocka_unit_test(large_output_and_long_prints_arrive_whole),
        cmocka_unit_test(patches_early_bytes),
        cmocka_unit_test(a_full_device_is_an_error),
        cmocka_unit_test(the_first_failure_is_kept),
        cmocka_unit_test(stdout_is_silent_until_commit),
        cmocka_unit_test(a_stream_to_a_file_shows_whole_lines),
        cmocka_unit_test(names_what_cannot_be_written),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
