/* Which files are imported, what a child leaves behind, and the parts of a mesh. */
#include <errno.h>
#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "sinew/io.h"

static sn_blob blob_of(const char *data, size_t size) { return (sn_blob){(char *)"a.bin", (char *)(uintptr_t)data, size}; }

static void expect_kind(const char *data, size_t size, const char *kind) {
    sn_blob blob = blob_of(data, size);
    const char *found = sn_import_detect(&blob);
    if (kind == NULL)
        assert_null(found);
    else
        assert_string_equal(found, kind);
}

#define EXPECT_KIND(text, kind) expect_kind(text, sizeof(text) - 1, kind)

/* ---- detection -------------------------------------------------------------------------------------------------------- */

static void formats_are_known_by_their_content(void **state) {
    (void)state;
    EXPECT_KIND("glTF\2\0\0\0....", "glb");
    EXPECT_KIND("Kaydara FBX Binary  \0\x1a\0", "fbx");
    EXPECT_KIND("; FBX 7.4.0 project file\n", "fbx");
    EXPECT_KIND("FBXHeaderExtension:  {\n", "fbx");
    EXPECT_KIND("xof 0303txt 0032\n", "x");
    EXPECT_KIND("FORM....LWO2", "lwo");
    EXPECT_KIND("MM\x10\0\0\0\2\0\x0a\0\0\0\3\0\0\0", "3ds");
    EXPECT_KIND("\xef\xbb\xbf<?xml version=\"1.0\"?>\n<!-- x -->\n<COLLADA version=\"1.4.1\">", "dae");
    EXPECT_KIND("<X3D version='3.0'>", "x3d");
    EXPECT_KIND("  0\r\nSECTION\r\n", "dxf");
    EXPECT_KIND("{\"asset\": {\"version\": \"2.0\"}}", "gltf");
    EXPECT_KIND(" {\"scenes\": [{\"nodes\": [0, {\"}\": 1}]}], \"asset\": {}}", "gltf");
}

static void what_sinew_reads_itself_and_noise_are_not_imported(void **state) {
    (void)state;
    EXPECT_KIND("", NULL);
    EXPECT_KIND("v 0 0 0\n", NULL);
    EXPECT_KIND("ply\nformat ascii 1.0\n", NULL);
    EXPECT_KIND("solid glTF\n", NULL);
    EXPECT_KIND("OFF\n", NULL);
    EXPECT_KIND("# vtk DataFile Version 3.0\n", NULL);
    EXPECT_KIND("<?xml version=\"1.0\"?><VTKFile type=\"PolyData\">", NULL);
    EXPECT_KIND("{\"format\": \"sinew-muscle\", \"asset\": {}}", NULL);
    EXPECT_KIND("{\"asset\": 1}", NULL);
    EXPECT_KIND("{\"asset\": ", NULL);
    EXPECT_KIND("{\"nodes\": [{\"asset\": {}}]}", NULL);
    EXPECT_KIND("MM\x10\1\0\0\2\0\x0a\0\0\0\3\0\0\0", NULL); /* longer than the file */
    EXPECT_KIND("MM", NULL);
    EXPECT_KIND("glT", NULL);
    uint64_t seed = 9;
    for (int round = 0; round < 2000; round++) {
        char noise[64];
        for (size_t i = 0; i < sizeof noise; i++) noise[i] = (char)(unsigned char)(256.0 * sn_random(&seed));
        expect_kind(noise, sizeof noise, NULL);
    }
}

/* ---- the child ---------------------------------------------------------------------------------------------------------- */

static char folder[] = "/tmp/sinew-import-XXXXXX";

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) == NULL || setenv("SINEW_LIBEXEC", folder, 1) != 0;
}

static int remove_folder(void **state) {
    (void)state;
    char path[64];
    snprintf(path, sizeof path, "%s/mesh-import", folder);
    return unlink(path) != 0 || rmdir(folder) != 0;
}

/* A shell script in place of mesh-import. */
static void pretend(const char *script) {
    char path[64];
    snprintf(path, sizeof path, "%s/mesh-import", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "#!/bin/sh\n%s\n", script);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0755), 0);
}

static int open_descriptors(void) {
    DIR *all = opendir("/proc/self/fd");
    assert_non_null(all);
    int count = 0;
    while (readdir(all) != NULL) count++;
    closedir(all);
    return count;
}

static const char one_triangle[] =
    "printf 'ply\\nformat ascii 1.0\\ncomment metersPerUnit 0.0254\\ncomment up y\\ncomment mesh 1 a b\\n"
    "element vertex 3\\nproperty double x\\nproperty double y\\nproperty double z\\n"
    "element face 1\\nproperty list int int vertex_indices\\nend_header\\n0 0 0\\n1 0 0\\n0 1 0\\n3 0 1 2\\n'";

static void expect_failure(const char *script, const char *words) {
    sn_blob blob = blob_of("glTF\2\0\0\0....", 12);
    sn_mesh mesh;
    sn_error error = {0};
    pretend(script);
    assert_int_not_equal(sn_mesh_parse(&blob, false, &mesh, &error), SN_OK);
    assert_string_equal(error.file, "a.bin");
    if (strstr(error.text, words) == NULL) fail_msg("'%s' does not say '%s'", error.text, words);
    assert_null(mesh.positions);
}

/* Whatever the child does: no zombie, no open file, and SIGPIPE is nobody's. */
static void nothing_of_a_child_stays(void **state) {
    (void)state;
    signal(SIGPIPE, SIG_DFL);
    int before = open_descriptors();
    expect_failure("kill -SEGV $$", "crash");
    expect_failure("echo nonsense; sleep 100", "no mesh");
    expect_failure("echo 'mesh-import: a.bin: no such luck' >&2; exit 1", "no such luck");
    expect_failure("exec 0<&-; exit 3", "status 3");
    expect_failure("cat > /dev/null; exit 0", "no mesh");
    assert_int_equal(open_descriptors(), before);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

static void an_answer_brings_unit_axis_and_names(void **state) {
    (void)state;
    sn_blob blob = blob_of("glTF\2\0\0\0....", 12);
    sn_mesh mesh;
    sn_mesh_frame frame;
    sn_error error = {0};
    pretend(one_triangle);
    if (sn_mesh_parse_frame(&blob, false, &mesh, &frame, &error) != SN_OK) fail_msg("%s", error.text);
    assert_true(frame.meters_per_unit == 0.0254);
    assert_int_equal(frame.up, SN_UP_Y);
    assert_int_equal(mesh.group_count, 1);
    assert_string_equal(mesh.group_names[0], "a b");
    assert_int_equal(mesh.triangle_group[0], 0);
    sn_mesh_free(&mesh);
}

/* The host may have ignored SIGCHLD: then the system reaps the child, and the answer counts. */
static void an_ignored_sigchld_is_no_matter(void **state) {
    (void)state;
    sn_blob blob = blob_of("glTF\2\0\0\0....", 12);
    sn_mesh mesh;
    sn_error error = {0};
    pretend(one_triangle);
    signal(SIGCHLD, SIG_IGN);
    sn_status status = sn_mesh_parse(&blob, false, &mesh, &error);
    signal(SIGCHLD, SIG_DFL);
    if (status != SN_OK) fail_msg("%s", error.text);
    sn_mesh_free(&mesh);
}

/* ---- parts -------------------------------------------------------------------------------------------------------------- */

/* Two tetrahedra that share vertex 0; the second is of the group, a lone triangle of none. */
static sn_mesh parts_mesh(void) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv -1 0 0\nv 0 -1 0\nv 0 0 -1\n"
                               "g 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\ng b\nf 1 5 6\nf 1 7 5\nf 5 7 6\nf 6 7 1\ng\nf 2 3 5\n";
    sn_blob blob = {(char *)"a.obj", (char *)(uintptr_t)text, sizeof text - 1};
    sn_mesh mesh;
    assert_int_equal(sn_mesh_parse(&blob, false, &mesh, NULL), SN_OK);
    return mesh;
}

static void parts_are_counted(void **state) {
    (void)state;
    sn_mesh mesh = parts_mesh();
    sn_mesh_part *parts;
    sn_index count;
    assert_int_equal(sn_mesh_parts(&mesh, &parts, &count, NULL), SN_OK);
    assert_int_equal(count, 3);
    static const sn_mesh_part wanted[] = {{"2", 4, 4}, {"b", 4, 4}, {"", 3, 1}};
    for (int i = 0; i < 3; i++) {
        assert_string_equal(parts[i].name, wanted[i].name);
        assert_int_equal(parts[i].vertices, wanted[i].vertices);
        assert_int_equal(parts[i].triangles, wanted[i].triangles);
    }
    free(parts);
    sn_mesh_free(&mesh);
}

/* A name that is a number comes before the number. */
static void a_part_is_selected_with_its_vertices_in_order(void **state) {
    (void)state;
    static const struct {
        const char *which, *name;
        double first_x;
        sn_index vertices, triangles;
    } cases[] = {{"2", "2", 0.0, 4, 4}, {"b", "b", 0.0, 4, 4}, {"3", NULL, 1.0, 3, 1}, {"1", "2", 0.0, 4, 4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_mesh mesh = parts_mesh();
        assert_int_equal(sn_mesh_select(&mesh, cases[i].which, NULL), SN_OK);
        assert_int_equal(mesh.vertex_count, cases[i].vertices);
        assert_int_equal(mesh.triangle_count, cases[i].triangles);
        assert_true(mesh.positions[0].x == cases[i].first_x);
        assert_int_equal(mesh.group_count, cases[i].name != NULL ? 1 : 0);
        if (cases[i].name != NULL) assert_string_equal(mesh.group_names[0], cases[i].name);
        assert_int_equal(sn_mesh_validate(&mesh, NULL), SN_OK);
        sn_mesh_free(&mesh);
    }
}

static void a_part_that_is_not_there_is_an_error(void **state) {
    (void)state;
    sn_mesh mesh = parts_mesh();
    static const char *const wrong[] = {"c", "0", "4", "-1", "", "1.5"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        sn_error error = {0};
        assert_int_equal(sn_mesh_select(&mesh, wrong[i], &error), SN_ERROR_INPUT);
        assert_non_null(strstr(error.text, "3 meshes"));
    }
    mesh.group_names[0][0] = 'b';
    sn_error error = {0};
    assert_int_equal(sn_mesh_select(&mesh, "b", &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "1 or 2"));
    assert_int_equal(mesh.triangle_count, 9);
    sn_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formats_are_known_by_their_content),
        cmocka_unit_test(what_sinew_reads_itself_and_noise_are_not_imported),
        cmocka_unit_test(nothing_of_a_child_stays),
        cmocka_unit_test(an_answer_brings_unit_axis_and_names),
        cmocka_unit_test(an_ignored_sigchld_is_no_matter),
        cmocka_unit_test(parts_are_counted),
        cmocka_unit_test(a_part_is_selected_with_its_vertices_in_order),
        cmocka_unit_test(a_part_that_is_not_there_is_an_error),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
