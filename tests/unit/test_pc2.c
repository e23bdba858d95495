/* test_pc2.c -- PC2 point caches: the bytes that other programs expect, and files that lie. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sinew/io.h"

static char path[256];

static int make_name(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/sinew-pc2-XXXXXX", base != NULL ? base : "/tmp");
    int fd = mkstemp(path);
    if (fd >= 0) close(fd);
    return fd < 0;
}

static int remove_name(void **state) {
    (void)state;
    return unlink(path);
}

static void write_cache(int points, int samples) {
    sn_pc2 *cache;
    sn_vec3 positions[8] = {{0, 0, 0}};
    assert_int_equal(sn_pc2_create(path, points, 1.0, 0.5, &cache, NULL), SN_OK);
    for (int s = 0; s < samples; s++) {
        for (int i = 0; i < points; i++) positions[i] = sn_v3(i + 0.5, s, -1.0 / 3.0);
        assert_int_equal(sn_pc2_append(cache, positions, NULL), SN_OK);
    }
    assert_int_equal(sn_pc2_commit(cache, NULL), SN_OK);
}

/* Layout as in Blender's source/blender/modifiers/intern/MOD_meshcache_pc2.c. */
static void the_header_is_as_specified(void **state) {
    (void)state;
    static const unsigned char header[32] = {'P', 'O', 'I', 'N', 'T', 'C', 'A',  'C',  'H', 'E', '2', 0,    1, 0, 0, 0,
                                             3,   0,   0,   0,   0,   0,   0x80, 0x3f, 0,   0,   0,   0x3f, 2, 0, 0, 0};
    write_cache(3, 2);
    sn_blob blob;
    assert_int_equal(sn_blob_read(path, &blob, NULL), SN_OK);
    assert_int_equal(blob.size, 32 + 2 * 3 * 12);
    assert_memory_equal(blob.data, header, sizeof header);
    sn_blob_free(&blob);
}

static void what_was_written_is_read(void **state) {
    (void)state;
    write_cache(5, 7);
    sn_pc2_data data;
    assert_int_equal(sn_pc2_read(path, &data, NULL), SN_OK);
    assert_int_equal(data.point_count, 5);
    assert_int_equal(data.sample_count, 7);
    assert_true(data.start_frame == 1.0 && data.sample_rate == 0.5);
    for (int s = 0; s < 7; s++) {
        for (int i = 0; i < 5; i++) {
            const float *p = &data.positions[3 * (5 * s + i)];
            assert_true(p[0] == (float)(i + 0.5) && p[1] == (float)s && p[2] == (float)(-1.0 / 3.0));
        }
    }
    sn_pc2_free(&data);
}

static void expect_refused(const unsigned char *bytes, size_t size, const char *word) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    sn_pc2_data data;
    sn_error error = {0};
    assert_int_equal(sn_pc2_read(path, &data, &error), SN_ERROR_INPUT);
    assert_string_equal(error.file, path);
    assert_non_null(strstr(error.text, word));
    assert_null(data.positions);
}

static void files_that_lie_are_refused(void **state) {
    (void)state;
    write_cache(3, 2);
    sn_blob blob;
    assert_int_equal(sn_blob_read(path, &blob, NULL), SN_OK);
    unsigned char *bytes = (unsigned char *)blob.data;
    expect_refused(bytes, 20, "not a PC2");
    expect_refused(bytes, 32 + 35, "cut short"); /* no whole sample */
    memset(bytes + 28, 0xff, 4);
    expect_refused(bytes, blob.size, "cannot be");
    bytes[12] = 9;
    expect_refused(bytes, blob.size, "version");
    sn_blob_free(&blob);
}

/* A run that was killed, or a disk that was full. */
static void of_a_file_cut_short_the_whole_samples_are_read(void **state) {
    (void)state;
    for (int lost = 0; lost <= 2; lost++) {
        write_cache(3, 2);
        assert_int_equal(truncate(path, 32 + 2 * 36 - (lost == 2 ? 36 : lost)), 0);
        sn_pc2_data data;
        assert_int_equal(sn_pc2_read(path, &data, NULL), SN_OK);
        assert_int_equal(data.sample_count, lost == 0 ? 2 : 1);
        sn_pc2_free(&data);
    }
}

/* Each time that it is published it is whole, though nothing ends it. */
static void what_is_published_outlives_its_writer(void **state) {
    (void)state;
    sn_vec3 positions[3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
    sn_pc2 *cache;
    sn_pc2_data data;
    write_cache(5, 7);
    assert_int_equal(sn_pc2_create(path, 3, 4.0, 1.0, &cache, NULL), SN_OK);
    for (int samples = 1; samples <= 3; samples++) {
        assert_int_equal(sn_pc2_append(cache, positions, NULL), SN_OK);
        assert_int_equal(sn_pc2_publish(cache, NULL), SN_OK);
        assert_int_equal(sn_pc2_read(path, &data, NULL), SN_OK);
        assert_true(data.point_count == 3 && data.sample_count == samples && data.start_frame == 4.0);
        sn_pc2_free(&data);
    }
    sn_pc2_abort(cache);
    sn_resume resume = {.frame = 5, .next = 6, .rate = 24, .reached = 5};
    assert_int_equal(sn_pc2_resume(path, 3, &resume, positions, &cache, NULL), SN_OK);
    assert_non_null(cache);
    assert_int_equal(resume.reached, 6);
    assert_int_equal(sn_pc2_append(cache, positions, NULL), SN_OK); /* in the place of frame 6 */
    assert_int_equal(sn_pc2_commit(cache, NULL), SN_OK);
    assert_int_equal(sn_pc2_read(path, &data, NULL), SN_OK);
    assert_int_equal(data.sample_count, 3);
    sn_pc2_free(&data);
}

static void an_aborted_cache_changes_nothing(void **state) {
    (void)state;
    write_cache(3, 2);
    sn_pc2 *cache;
    sn_vec3 positions[4] = {{0, 0, 0}};
    assert_int_equal(sn_pc2_create(path, 4, 0.0, 1.0, &cache, NULL), SN_OK);
    assert_int_equal(sn_pc2_append(cache, positions, NULL), SN_OK);
    sn_pc2_abort(cache);
    sn_pc2_abort(NULL);
    sn_pc2_data data;
    assert_int_equal(sn_pc2_read(path, &data, NULL), SN_OK);
    assert_int_equal(data.point_count, 3);
    sn_pc2_free(&data);
    assert_int_equal(sn_pc2_create(path, 0, 0.0, 1.0, &cache, NULL), SN_ERROR_USAGE);
}

static void test_points_beyond_single_precision_are_refused_by_number(void **state) {
    (void)state;
    char folder[] = "/tmp/sinew-pc2-XXXXXX", file[64];
    assert_non_null(mkdtemp(folder));
    snprintf(file, sizeof file, "%s/far.pc2", folder);
    sn_pc2 *cache;
    sn_error error = {0};
    assert_int_equal(sn_pc2_create(file, 2, 0.0, 1.0, &cache, &error), SN_OK);
    sn_vec3 points[2] = {{0.0, 1.0, 2.0}, {0.0, -3.4e38, 0.0}};
    assert_int_equal(sn_pc2_append(cache, points, &error), SN_OK);
    points[1].y = -3.5e38;
    assert_int_equal(sn_pc2_append(cache, points, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "point 1"));
    assert_string_equal(error.file, file);
    assert_int_equal(sn_pc2_commit(cache, &error), SN_OK); /* what went before is kept */
    sn_pc2_data data;
    assert_int_equal(sn_pc2_read(file, &data, &error), SN_OK);
    assert_int_equal(data.sample_count, 1);
    sn_pc2_free(&data);
    remove(file);
    remove(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points_beyond_single_precision_are_refused_by_number),
        cmocka_unit_test(the_header_is_as_specified),
        cmocka_unit_test(what_was_written_is_read),
        cmocka_unit_test(files_that_lie_are_refused),
        cmocka_unit_test(of_a_file_cut_short_the_whole_samples_are_read),
        cmocka_unit_test(what_is_published_outlives_its_writer),
        cmocka_unit_test(an_aborted_cache_changes_nothing),
    };
    return cmocka_run_group_tests(tests, make_name, remove_name);
}
