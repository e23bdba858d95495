/* test_mesh_io.c -- OBJ, PLY, STL and OFF: what is read, what is refused and where, and that writing loses nothing. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../../lib/io/mesh_reader.h"

/* ---- helpers -------------------------------------------------------------------------------------------------------- */

static sn_status parse_bytes(const char *name, const void *bytes, size_t size, bool nonfinite, sn_mesh *out, sn_error *error) {
    sn_blob blob = {.name = (char *)(uintptr_t)name, .size = size};
    blob.data = malloc(size + 1); /* exactly as long as the file: a sanitizer sees the first byte too many */
    assert_non_null(blob.data);
    memcpy(blob.data, bytes, size);
    blob.data[size] = '\0';
    *error = (sn_error){0};
    sn_status status = sn_mesh_parse(&blob, nonfinite, out, error);
    free(blob.data);
    return status;
}

static sn_mesh read_text(const char *name, const char *text) {
    sn_mesh mesh;
    sn_error error;
    if (parse_bytes(name, text, strlen(text), false, &mesh, &error) != SN_OK) {
        fail_msg("%s:%d: %s", error.file, (int)error.line, error.text);
    }
    assert_int_equal(sn_mesh_validate(&mesh, NULL), SN_OK);
    return mesh;
}

/* The file is refused at this line, with these words. */
static void refuse_bytes(const char *name, const void *bytes, size_t size, int line, const char *words) {
    sn_mesh mesh;
    sn_error error;
    sn_status status = parse_bytes(name, bytes, size, false, &mesh, &error);
    if (status == SN_OK) fail_msg("%s was read, but '%s' was expected", name, words);
    assert_int_equal(status, SN_ERROR_INPUT);
    assert_string_equal(error.file, name);
    if (strstr(error.text, words) == NULL) fail_msg("'%s' does not say '%s'", error.text, words);
    assert_int_equal(error.line, line);
    assert_null(strchr(error.text, '\n'));
    assert_null(mesh.positions);
}

static void refuse(const char *name, const char *text, int line, const char *words) { refuse_bytes(name, text, strlen(text), line, words); }

static void expect_triangle(const sn_mesh *mesh, sn_index triangle, sn_index a, sn_index b, sn_index c) {
    const sn_index *v = mesh->triangles[triangle].v;
    if (v[0] != a || v[1] != b || v[2] != c) fail_msg("triangle %d is %d %d %d", triangle, v[0], v[1], v[2]);
}

static void expect_position(const sn_mesh *mesh, sn_index vertex, double x, double y, double z) {
    sn_vec3 p = mesh->positions[vertex];
    if (p.x != x || p.y != y || p.z != z) fail_msg("vertex %d is %.17g %.17g %.17g", vertex, p.x, p.y, p.z);
}

static double value_of(const sn_mesh *mesh, const char *name, sn_index vertex) {
    const sn_attribute *attribute = sn_mesh_attribute(mesh, name);
    if (attribute == NULL) fail_msg("there is no attribute %s", name);
    return attribute->values[vertex];
}

/* Write to a file and take its bytes. */
static sn_blob write_mesh(const sn_mesh *mesh, sn_mesh_format format, sn_mesh_encoding encoding) {
    char path[] = "/tmp/sinew-mesh-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    sn_output *output;
    sn_error error = {0};
    sn_blob blob;
    assert_int_equal(sn_output_open(path, false, &output, &error), SN_OK);
    if (sn_mesh_write(mesh, format, encoding, output, &error) != SN_OK) fail_msg("%s", error.text);
    assert_int_equal(sn_output_commit(output, &error), SN_OK);
    assert_int_equal(sn_blob_read(path, &blob, &error), SN_OK);
    unlink(path);
    return blob;
}

static sn_mesh round_trip(const sn_mesh *mesh, sn_mesh_format format, sn_mesh_encoding encoding) {
    sn_blob blob = write_mesh(mesh, format, encoding);
    sn_mesh back;
    sn_error error = {0};
    assert_int_equal(sn_mesh_detect(&blob), format); /* its name says nothing */
    if (sn_mesh_parse(&blob, false, &back, &error) != SN_OK) fail_msg("%d: %s", (int)error.line, error.text);
    sn_blob_free(&blob);
    return back;
}

/* ---- OBJ ------------------------------------------------------------------------------------------------------------ */

static void obj_reads_every_form_of_a_corner(void **state) {
    (void)state;
    sn_mesh mesh = read_text("a.obj", "# comment\n\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 # one\nv 0 1 0 1.0\nvt 0 0\nvn 0 0 1\n"
                                      "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\ns off\nf -3/-1/-1 2 3");
    assert_int_equal(mesh.vertex_count, 3);
    assert_int_equal(mesh.triangle_count, 6);
    for (sn_index i = 0; i < 6; i++) expect_triangle(&mesh, i, 0, 1, 2);
    assert_int_equal(mesh.attribute_count, 0);
    assert_int_equal(mesh.group_count, 0);
    assert_null(mesh.triangle_group);
    sn_mesh_free(&mesh);
}

static void obj_reads_every_line_end_and_continued_lines(void **state) {
    (void)state;
    static const char *const files[] = {"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
                                        "v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n 2\\\n 3\n",
                                        "# C:\\a\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
                                        "\xef\xbb\xbfv 0 0 0\n v\t1  0 0 \nv 0 1 0\nf 1 2 3 "};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        sn_mesh mesh = read_text("a.obj", files[i]);
        assert_int_equal(mesh.vertex_count, 3);
        assert_int_equal(mesh.triangle_count, 1);
        expect_triangle(&mesh, 0, 0, 1, 2);
        sn_mesh_free(&mesh);
    }
}

static void obj_faces_may_come_before_their_vertices(void **state) {
    (void)state;
    sn_mesh mesh = read_text("a.obj", "f 3 1 2\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    expect_triangle(&mesh, 0, 2, 0, 1);
    sn_mesh_free(&mesh);
}

static void convex_polygons_become_fans(void **state) {
    (void)state;
    sn_mesh mesh = read_text("a.obj", "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\nf 1 2 3 4\n");
    assert_int_equal(mesh.triangle_count, 5);
    expect_triangle(&mesh, 0, 0, 1, 2);
    expect_triangle(&mesh, 1, 0, 2, 3);
    expect_triangle(&mesh, 2, 0, 3, 4);
    expect_triangle(&mesh, 4, 0, 2, 3);
    sn_mesh_free(&mesh);
}

/* Cut along its inside, a polygon's triangles all face its way and their areas add up to its own. */
static void polygons_that_are_not_convex_are_cut_along_their_inside(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double area;
    } cases[] = {
        {"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n", 10.0},                                 /* a notch */
        {"v 0 0 0\nv 4 4 0\nv 1 1 3\nv -4 -4 5\nv 0 0 1\nf 5 1 2 3 4\n", -1.0},                               /* upright; area below */
        {"v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nf 1 2 3 4 5 6\n", 9.0},                       /* corners on a side */
        {"v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 2 0\nv 3 2 0\nv 3 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8\n", 7.0}, /* a C */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_mesh mesh = read_text("a.obj", cases[i].text);
        sn_vec3 whole = {0, 0, 0};
        double sum = 0.0;
        for (sn_index t = 0; t < mesh.triangle_count; t++) {
            const sn_index *v = mesh.triangles[t].v;
            sn_vec3 area = sn_area_vector(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]);
            assert_true(sn_norm(area) > 1e-9);
            whole = sn_add(whole, area);
            sum += 0.5 * sn_norm(area);
        }
        assert_true(fabs(0.5 * sn_norm(whole) - sum) < 1e-9);
        if (cases[i].area > 0.0) assert_true(fabs(sum - cases[i].area) < 1e-9);
        sn_mesh_free(&mesh);
    }
}

static void obj_keeps_groups_by_name(void **state) {
    (void)state;
    sn_mesh mesh = read_text("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng left head\nf 1 2 3\nusemtl red\nf 1 2 3\no body \nf 1 2 3\n"
                                      "g left head\nf 1 2 3\ng\nf 1 2 3\n");
    static const sn_index groups[] = {SN_NONE, 0, 0, 1, 0, SN_NONE};
    assert_int_equal(mesh.group_count, 2);
    assert_string_equal(mesh.group_names[0], "left head");
    assert_string_equal(mesh.group_names[1], "body");
    for (int i = 0; i < 6; i++) assert_int_equal(mesh.triangle_group[i], groups[i]);
    sn_mesh back = round_trip(&mesh, SN_MESH_OBJ, SN_ENCODING_DEFAULT);
    assert_int_equal(back.group_count, 2);
    assert_string_equal(back.group_names[0], "left head");
    assert_memory_equal(back.triangle_group, groups, sizeof groups);
    sn_mesh_free(&back);
    sn_mesh_free(&mesh);
    mesh = read_text("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"); /* materials where there is nothing else */
    assert_string_equal(mesh.group_names[mesh.triangle_group[0]], "red");
    sn_mesh_free(&mesh);
}

static void obj_colours_become_attributes(void **state) {
    (void)state;
    sn_mesh mesh = read_text("a.obj", "v 0 0 0\nv 1 0 0 1 0.501961 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert_true(sn_mesh_attribute(&mesh, "green")->integer);
    assert_true(value_of(&mesh, "red", 0) == 255.0); /* white where none is given */
    assert_true(value_of(&mesh, "green", 1) == 128.0);
    assert_true(value_of(&mesh, "blue", 2) == 0.0);
    sn_mesh back = round_trip(&mesh, SN_MESH_OBJ, SN_ENCODING_DEFAULT);
    assert_true(sn_mesh_attribute(&back, "green")->integer);
    assert_true(value_of(&back, "green", 1) == 128.0);
    sn_mesh_free(&back);
    sn_mesh_free(&mesh);
    mesh = read_text("a.obj", "v 0 0 0 0.1 0.2 0.33333\nv 1 0 0 1 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert_false(sn_mesh_attribute(&mesh, "blue")->integer);
    assert_true(value_of(&mesh, "blue", 0) == 0.33333);
    sn_mesh_free(&mesh);
}

static void obj_errors_name_the_line(void **state) {
    (void)state;
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n", 4, "vertex 4");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", 4, "'0'");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", 4, "vertex -4");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3x\n", 4, "'3x'");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/1/1/1\n", 4, "'3/1/1/1'");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", 4, "number of a vertex");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4294967297\n", 4, "4294967297");
    refuse("a.obj", "v 0 0 0\nv 1 zero 0\nf 1 1 1\n", 2, "'zero'");
    refuse("a.obj", "v 0 0 0\nv 1 0\nf 1 1 1\n", 2, "the end of the line");
    refuse("a.obj", "v 0 0 0\nv 1 \\\n 0 1e\nf 1 1 1\n", 3, "'1e'");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", 0, "has no faces");
    refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nl 1 2 3\n", 0, "has no faces");
    refuse("a.obj", "", 0, "is empty");
}

static void non_finite_coordinates_are_named_unless_allowed(void **state) {
    (void)state;
    static const char *const files[] = {"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0 0\nv 0 -inf 0\nv 0 1 0\nf 1 2 3\n",
                                        "v 0 0 0\nv 0 0 1e999\nv 0 1 0\nf 1 2 3\n"};
    for (size_t i = 0; i < 3; i++) {
        refuse("a.obj", files[i], 2, "vertex 1");
        sn_mesh mesh;
        sn_error error;
        assert_int_equal(parse_bytes("a.obj", files[i], strlen(files[i]), false, &mesh, &error), SN_ERROR_INPUT);
        assert_int_equal(error.element, 1);
        assert_int_equal(parse_bytes("a.obj", files[i], strlen(files[i]), true, &mesh, &error), SN_OK);
        assert_false(sn_finite3(mesh.positions[1]));
        sn_mesh_free(&mesh);
    }
}

/* ---- PLY ------------------------------------------------------------------------------------------------------------ */

static void ply_keeps_attributes_and_passes_over_the_rest(void **state) {
    (void)state;
    sn_mesh mesh = read_text(
        "a.ply", "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\nelement camera 1\nproperty float view\n"
                 "property list uchar float more\nelement vertex 4\nproperty uchar red\nproperty float x\nproperty list uchar int skip\n"
                 "property double y\nproperty double z\nproperty float painted\nelement face 2\nproperty uchar flag\n"
                 "property list uchar uint vertex_index\nproperty list uchar float uv\nelement edge 1\nproperty int a\nend_header\n"
                 "7 2 1.5 2.5\n255 0 0 0.1 0 0.5\n\n128 1 1 9 0.1 0 -1\n0 1 2 8 9 1.1 0 nan\n1 0 0 1.1 0 1e-300\n"
                 "0 3 0 1 2 0\n1 4 0 1 2 3 2 0.5 0.5\n12\n");
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.triangle_count, 3);
    expect_position(&mesh, 2, 1, 1.1, 0);
    expect_triangle(&mesh, 2, 0, 2, 3);
    assert_int_equal(mesh.attribute_count, 2);
    assert_true(sn_mesh_attribute(&mesh, "red")->integer);
    assert_false(sn_mesh_attribute(&mesh, "painted")->integer);
    assert_true(value_of(&mesh, "red", 1) == 128.0 && value_of(&mesh, "painted", 3) == 1e-300);
    sn_mesh_free(&mesh);
}

static size_t append_number(unsigned char *at, double value, const char *type, bool big) {
    static const int64_t one = 1;
    unsigned char bytes[8];
    size_t size = 0;
#define PUT(c_type)                                                                                                                        \
    do {                                                                                                                                   \
        c_type number = (c_type)value;                                                                                                     \
        size = sizeof number;                                                                                                              \
        memcpy(bytes, &number, size);                                                                                                      \
    } while (0)
    if (strcmp(type, "char") == 0 || strcmp(type, "int8") == 0) PUT(int8_t);
    if (strcmp(type, "uchar") == 0 || strcmp(type, "uint8") == 0) PUT(uint8_t);
    if (strcmp(type, "short") == 0 || strcmp(type, "int16") == 0) PUT(int16_t);
    if (strcmp(type, "ushort") == 0 || strcmp(type, "uint16") == 0) PUT(uint16_t);
    if (strcmp(type, "int") == 0 || strcmp(type, "int32") == 0) PUT(int32_t);
    if (strcmp(type, "uint") == 0 || strcmp(type, "uint32") == 0) PUT(uint32_t);
    if (strcmp(type, "float") == 0 || strcmp(type, "float32") == 0) PUT(float);
    if (strcmp(type, "double") == 0 || strcmp(type, "float64") == 0) PUT(double);
#undef PUT
    bool host_big = *(const unsigned char *)&one == 0;
    for (size_t i = 0; i < size; i++) at[i] = bytes[big == host_big ? i : size - 1 - i];
    return size;
}

static void ply_reads_every_scalar_type_in_both_byte_orders(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double value;
    } types[] = {{"char", -100},       {"uchar", 200},       {"short", -30000},    {"ushort", 60000},
                 {"int", -2000000000}, {"uint", 4000000000}, {"float", 0.25},      {"double", 1e-9},
                 {"int8", -1},         {"uint8", 255},       {"int16", -2},        {"uint16", 65535},
                 {"int32", 70000},     {"uint32", 3e9},      {"float32", -1234.5}, {"float64", 1.0 / 3.0}};
    for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
        for (int big = 0; big < 2; big++) {
            unsigned char file[1024];
            size_t size =
                (size_t)snprintf((char *)file, sizeof file,
                                 "ply\nformat binary_%s_endian 1.0\nelement vertex 3\nproperty float x\nproperty %s value\n"
                                 "property double y\nproperty float z\nelement face 1\nproperty list ushort short vertex_indices\n"
                                 "end_header\n",
                                 big ? "big" : "little", types[t].name);
            for (int v = 0; v < 3; v++) {
                size += append_number(file + size, v == 1, "float", big);
                size += append_number(file + size, types[t].value, types[t].name, big);
                size += append_number(file + size, v == 2, "double", big);
                size += append_number(file + size, 0.1, "float", big);
            }
            size += append_number(file + size, 3, "ushort", big);
            for (int v = 0; v < 3; v++) size += append_number(file + size, v, "short", big);
            sn_mesh mesh;
            sn_error error;
            if (parse_bytes("a.ply", file, size, false, &mesh, &error) != SN_OK) fail_msg("%s: %s", types[t].name, error.text);
            expect_position(&mesh, 1, 1, 0, (double)0.1f);
            expect_triangle(&mesh, 0, 0, 1, 2);
            assert_true(value_of(&mesh, "value", 2) == types[t].value);
            sn_mesh_free(&mesh);
            refuse_bytes("a.ply", file, size - 1, 0, "byte "); /* one byte short */
        }
    }
}

static void ply_header_may_end_lines_in_any_way(void **state) {
    (void)state;
    static const char *const ends[] = {"\n", "\r\n", "\r"};
    for (size_t e = 0; e < 3; e++) {
        static const char *const lines[] = {"ply",
                                            "format binary_little_endian 1.0",
                                            "element vertex 3",
                                            "property uchar x",
                                            "property uchar y",
                                            "property uchar z",
                                            "element face 1",
                                            "property list uchar uchar vertex_indices",
                                            "end_header"};
        char file[512];
        size_t size = 0;
        for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
            size += (size_t)snprintf(file + size, sizeof file - size, "%s%s", lines[i], ends[e]);
        }
        memcpy(file + size, "\n\r\n\1\0\0\0\1\0\3\0\1\2", 13); /* data that look like line ends */
        sn_mesh mesh;
        sn_error error;
        if (parse_bytes("a.ply", file, size + 13, false, &mesh, &error) != SN_OK) fail_msg("%d: %s", (int)e, error.text);
        expect_position(&mesh, 0, 10, 13, 10);
        expect_triangle(&mesh, 0, 0, 1, 2);
        sn_mesh_free(&mesh);
    }
}

#define PLY_START "ply\nformat ascii 1.0\n"
#define PLY_XYZ "property float x\nproperty float y\nproperty float z\n"
#define PLY_FACE "property list uchar int vertex_indices\n"

static void ply_errors_name_the_line(void **state) {
    (void)state;
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", 11,
           "the end of the line");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n", 11,
           "'x'");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0 0 4\n0 1 0\n3 0 1 2\n", 11,
           "more values");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 13,
           "vertex 3");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", 13,
           "vertex -1");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", 13,
           "1.5");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", 11,
           "vertex 1");
    refuse("a.ply", PLY_START "element vertex 3\n" PLY_XYZ "element face 2\n" PLY_FACE "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n    ", 14,
           "the file ends before");
    refuse("a.ply", PLY_START "element vertex 3\nproperty float x\nelement face 1\n" PLY_FACE "end_header\n0 \n0 \n0 \n0 0\n", 7,
           "x, y and z");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ "property float x\nelement face 1\n" PLY_FACE "end_header\n0 0 0 0\n3 0 0 0\n",
           10, "each once");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ "property quad w\n", 7, "type");
    refuse("a.ply", PLY_START "element vertex -1\n", 3, "count");
    refuse("a.ply", PLY_START "elephant vertex 1\n", 3, "'elephant'");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ, 7, "end_header");
    refuse("a.ply", "ply\nformat binary 1.0\n", 2, "format");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ "element face 0\n" PLY_FACE "end_header\n0 0 0\n", 0, "has no faces");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ "end_header\n0 0 0\n", 0, "has no faces");
}

/* A header's promise is held against the file before anything is allocated. */
static void false_counts_are_refused(void **state) {
    (void)state;
    refuse("a.ply", PLY_START "element vertex 4000000000\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n0 0 0\n", 9,
           "promises 4000000000");
    refuse("a.ply", PLY_START "element vertex 1\n" PLY_XYZ "element face 4000000000\n" PLY_FACE "end_header\n0 0 0\n", 9,
           "promises 4000000000");
    refuse("a.ply", PLY_START "element vertex 9223372036854775807\n" PLY_XYZ "element face 1\n" PLY_FACE "end_header\n", 9, "promises");
    refuse("a.ply", PLY_START "element vertex 99999999999999999999\n", 3, "count");
    refuse("a.off", "OFF\n2000000000 1 0\n0 0 0\n", 3, "promises 2000000000");
    refuse("a.off", "OFF\n3 2000000000 0\n0 0 0\n", 3, "promises 3 vertices and 2000000000");
    static const char empty[] = PLY_START "element vertex 3\n" PLY_XYZ "element face 1\n" PLY_FACE
                                          "element nothing 4000000000\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    sn_mesh mesh = read_text("a.ply", empty); /* rows without values take no time and no space */
    assert_int_equal(mesh.triangle_count, 1);
    sn_mesh_free(&mesh);
}

/* ---- STL ------------------------------------------------------------------------------------------------------------ */

static size_t binary_stl(unsigned char *file, const float (*corners)[3], uint32_t triangles, const char *header) {
    memset(file, 0, 84 + 50 * (size_t)triangles);
    memcpy(file, header, strlen(header));
    append_number(file + 80, triangles, "uint", false);
    for (uint32_t t = 0; t < triangles; t++) {
        for (size_t i = 0; i < 9; i++)
            append_number(file + 84 + 50 * t + 12 + 4 * i, (double)corners[3 * t + i / 3][i % 3], "float", false);
    }
    return 84 + 50 * (size_t)triangles;
}

static void stl_welds_equal_coordinates_in_order(void **state) {
    (void)state;
    static const float corners[][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, -0.0f}, {1, 0, 0}, {5, 5, 5}};
    static const char *const headers[] = {"binary", "solid but binary"};
    for (int i = 0; i < 2; i++) {
        unsigned char file[512];
        size_t size = binary_stl(file, corners, 2, headers[i]);
        sn_mesh mesh;
        sn_error error;
        if (parse_bytes("noname", file, size, false, &mesh, &error) != SN_OK) fail_msg("%s", error.text);
        assert_int_equal(mesh.vertex_count, 4);
        assert_int_equal(mesh.triangle_count, 2);
        expect_triangle(&mesh, 0, 0, 1, 2);
        expect_triangle(&mesh, 1, 1, 0, 3);
        expect_position(&mesh, 3, 5, 5, 5);
        sn_mesh_free(&mesh);
        refuse_bytes("a.stl", file, size - 1, 0, "cut short");
        refuse_bytes("a.stl", file, 40, 0, "within the header");
    }
}

static void stl_errors_name_the_byte(void **state) {
    (void)state;
    static const float corners[][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {5, NAN, 5}};
    unsigned char file[512];
    size_t size = binary_stl(file, corners, 2, "x");
    refuse_bytes("a.stl", file, size, 0, "byte 170: vertex 3"); /* 84 + 50 + 12 + 2 * 12 */
    memset(file + 80, 0xff, 4);
    refuse_bytes("a.stl", file, size, 0, "promises 4294967295 triangles");
    memset(file + 80, 0, 4);
    refuse_bytes("a.stl", file, 84, 0, "has no faces");
}

static void stl_text_is_read_word_by_word(void **state) {
    (void)state;
    sn_mesh mesh =
        read_text("a.stl", "solid a b c\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex 0 1 0\n"
                           "  endloop\n endfacet\nendsolid a b c\nsolid\nfacet normal nan nan nan\nouter loop\nvertex 1 0 0\n"
                           "vertex 0 0 -0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid\n");
    assert_int_equal(mesh.vertex_count, 4);
    expect_triangle(&mesh, 1, 1, 0, 3);
    sn_mesh_free(&mesh);
    mesh = read_text("?", "SOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 1 0\nENDLOOP\nENDFACET\nENDSOLID\n");
    assert_int_equal(mesh.triangle_count, 1);
    sn_mesh_free(&mesh);
    refuse("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0\n", 5, "the end of the line");
    refuse("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 inf\n", 5, "vertex 1");
    refuse("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\n", 5, "expected 'vertex', found 'endloop'");
    refuse("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", 5, "cut short");
    refuse("a.stl", "solid x\nendsolid x\n", 0, "has no faces");
    refuse("a.stl", "solid x\n", 2, "cut short");
}

/* ---- OFF ------------------------------------------------------------------------------------------------------------ */

static void off_reads_its_variants(void **state) {
    (void)state;
    static const char *const files[] = {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "OFF 3 1 3\n0 0 0 \n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n",
                                        "# c\nOFF # c\n\n3 1 # c\n# c\n0 0 0 # c\n\n1 0 0\n0 1 0\n3 0 1 2",
                                        "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        sn_mesh mesh = read_text("a.off", files[i]);
        assert_int_equal(mesh.vertex_count, 3);
        expect_triangle(&mesh, 0, 0, 1, 2);
        sn_mesh_free(&mesh);
    }
    sn_mesh mesh = read_text("?", "COFF\n3 1 0\n0 0 0 255 128 0 255\n1 0 0 0 0 0 255\n0 1 0 1 2 3 4\n3 0 1 2\n");
    assert_true(value_of(&mesh, "green", 0) == 128.0 && value_of(&mesh, "alpha", 2) == 4.0 && sn_mesh_attribute(&mesh, "red")->integer);
    sn_mesh_free(&mesh);
    mesh = read_text("?", "CNOFF\n3 1 0\n0 0 0 0 0 1 0.5 0.123 1\n1 0 0 0 0 1 0 0 0\n0 1 0 0 0 1 0 0 0\n3 0 1 2\n");
    assert_true(value_of(&mesh, "nz", 2) == 1.0 && value_of(&mesh, "green", 0) == 0.123);
    sn_mesh_free(&mesh);
}

static void off_errors_name_the_line(void **state) {
    (void)state;
    refuse("a.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", 4, "vertex 1");
    refuse("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 6, "vertex 3");
    refuse("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", 6, "the end of the line");
    refuse("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000000 0 1 2\n", 6, "found the end");
    refuse("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 7, "face 1 of 2");
    refuse("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", 0, "has no faces");
    refuse("a.off", "4OFF\n3 1 0\n", 1, "three dimensions");
    refuse("a.off", "OFF BINARY\n", 1, "'BINARY'");
    refuse("a.off", "COFF\n3 1 0\n0 0 0 1 1\n1 0 0 1 1 1\n0 1 0 1 1 1\n3 0 1 2\n", 3, "colour");
    refuse("a.off", "NOFF\n3 1 0\n0 0 0 1 1\n1 0 0 1 1 1\n0 1 0 1 1 1\n3 0 1 2\n", 3, "normal");
}

/* ---- all of them ---------------------------------------------------------------------------------------------------- */

static void the_format_is_found_from_content(void **state) {
    (void)state;
    static const struct {
        const char *name, *text;
        sn_mesh_format format;
    } cases[] = {
        {"x.stl", "ply\nformat", SN_MESH_PLY},   {"x.ply", "# c\nv 0 0 0\n", SN_MESH_OBJ},   {"x", "solid a\n", SN_MESH_STL},
        {"x.obj", "COFF\n1 1 1\n", SN_MESH_OFF}, {"x.obj", "{ \"a\": 1 }", SN_MESH_UNKNOWN}, {"x.off", "3 1 0\n", SN_MESH_OFF},
        {"x", "hello", SN_MESH_UNKNOWN},         {"x.OBJ", "# nothing", SN_MESH_OBJ},        {"x", "", SN_MESH_UNKNOWN},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_blob blob = {(char *)(uintptr_t)cases[i].name, (char *)(uintptr_t)cases[i].text, strlen(cases[i].text)};
        assert_int_equal(sn_mesh_detect(&blob), cases[i].format);
    }
    refuse("x.txt", "hello", 0, "no known mesh format");
    assert_int_equal(sn_mesh_format_from_name("a.b/c.Ply"), SN_MESH_PLY);
    assert_int_equal(sn_mesh_format_from_name(NULL), SN_MESH_UNKNOWN);
    assert_string_equal(sn_mesh_format_name(SN_MESH_STL), "STL");
}

/* Coordinates of every size, most of which need all 17 digits; each vertex in a triangle, first appearances in order. */
static sn_mesh awkward_mesh(bool single) {
    enum { VERTICES = 300 };
    sn_mesh mesh;
    uint64_t seed = 7;
    assert_int_equal(sn_mesh_alloc(&mesh, VERTICES, VERTICES - 2, NULL), SN_OK);
    for (sn_index i = 0; i < VERTICES; i++) {
        double c[3];
        for (int j = 0; j < 3; j++) {
            c[j] = (sn_random(&seed) - 0.5) * pow(10.0, floor(30.0 * sn_random(&seed)) - 15.0);
            if (single) c[j] = (double)(float)c[j];
        }
        mesh.positions[i] = sn_v3(c[0], c[1], c[2]);
    }
    for (sn_index i = 0; i < VERTICES - 2; i++) mesh.triangles[i] = (sn_triangle){{i, i + 1, i + 2}};
    return mesh;
}

static void add_values(sn_mesh *mesh, const char *name, bool integer, double scale) {
    uint64_t seed = 3;
    sn_attribute *attribute = sn_mesh_add_attribute(mesh, name, 1);
    assert_non_null(attribute);
    attribute->integer = integer;
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        double value = scale * sn_random(&seed);
        attribute->values[i] = integer ? floor(value) : value;
    }
}

static void expect_same(const sn_mesh *a, const sn_mesh *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, (size_t)a->vertex_count * sizeof(sn_vec3));
    assert_memory_equal(a->triangles, b->triangles, (size_t)a->triangle_count * sizeof(sn_triangle));
}

static void every_format_and_encoding_gives_the_same_mesh_back(void **state) {
    (void)state;
    static const struct {
        sn_mesh_format format;
        sn_mesh_encoding encoding;
        bool single;
    } cases[] = {{SN_MESH_OBJ, SN_ENCODING_DEFAULT, false}, {SN_MESH_OFF, SN_ENCODING_ASCII, false},
                 {SN_MESH_PLY, SN_ENCODING_ASCII, false},   {SN_MESH_PLY, SN_ENCODING_LITTLE, false},
                 {SN_MESH_PLY, SN_ENCODING_BIG, false},     {SN_MESH_PLY, SN_ENCODING_DEFAULT, false},
                 {SN_MESH_STL, SN_ENCODING_ASCII, false},   {SN_MESH_STL, SN_ENCODING_DEFAULT, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_mesh mesh = awkward_mesh(cases[i].single);
        sn_mesh back = round_trip(&mesh, cases[i].format, cases[i].encoding);
        expect_same(&mesh, &back);
        sn_mesh_free(&back);
        sn_mesh_free(&mesh);
    }
}

static void ply_gives_attributes_back(void **state) {
    (void)state;
    static const sn_mesh_encoding encodings[] = {SN_ENCODING_ASCII, SN_ENCODING_LITTLE, SN_ENCODING_BIG};
    static const char *const names[] = {"red", "weight", "label"};
    for (int e = 0; e < 3; e++) {
        sn_mesh mesh = awkward_mesh(false);
        add_values(&mesh, names[0], true, 256.0);
        add_values(&mesh, names[1], false, 1.0);
        add_values(&mesh, names[2], true, -1e6);
        sn_mesh back = round_trip(&mesh, SN_MESH_PLY, encodings[e]);
        expect_same(&mesh, &back);
        assert_int_equal(back.attribute_count, 3);
        for (int a = 0; a < 3; a++) {
            assert_string_equal(back.attributes[a].name, names[a]);
            assert_int_equal(back.attributes[a].integer, mesh.attributes[a].integer);
            assert_memory_equal(back.attributes[a].values, mesh.attributes[a].values, (size_t)mesh.vertex_count * sizeof(double));
        }
        sn_blob blob = write_mesh(&mesh, SN_MESH_PLY, encodings[e]);
        assert_non_null(strstr(blob.data, "property uchar red\nproperty double weight\nproperty int label\n"));
        sn_blob_free(&blob);
        sn_mesh_free(&back);
        sn_mesh_free(&mesh);
    }
}

static void colours_survive_in_every_format_that_has_them(void **state) {
    (void)state;
    static const sn_mesh_format with_colours[] = {SN_MESH_OBJ, SN_MESH_OFF, SN_MESH_PLY};
    static const char *const names[] = {"red", "green", "blue"};
    for (int f = 0; f < 3; f++) {
        sn_mesh mesh = awkward_mesh(false);
        for (int c = 0; c < 3; c++) add_values(&mesh, names[c], true, 256.0);
        sn_mesh back = round_trip(&mesh, with_colours[f], SN_ENCODING_DEFAULT);
        for (int c = 0; c < 3; c++) {
            assert_true(sn_mesh_attribute(&back, names[c])->integer);
            assert_memory_equal(sn_mesh_attribute(&back, names[c])->values, mesh.attributes[c].values,
                                (size_t)mesh.vertex_count * sizeof(double));
        }
        sn_mesh_free(&back);
        sn_mesh_free(&mesh);
    }
}

static void ply_names_properties_apart(void **state) {
    (void)state;
    static const char *const names[] = {"a b", "a_b", "a\nb", "x", "", "fiber_1"};
    sn_mesh mesh = awkward_mesh(false);
    for (int i = 0; i < 6; i++) add_values(&mesh, names[i], true, 256.0);
    sn_attribute *wide = sn_mesh_add_attribute(&mesh, "fiber", 2);
    assert_non_null(wide);
    assert_true(sn_attribute_add_label(wide, "ul\nna"));
    sn_blob blob = write_mesh(&mesh, SN_MESH_PLY, SN_ENCODING_ASCII);
    assert_non_null(strstr(blob.data, "uchar a_b\nproperty uchar a_b_\nproperty uchar a_b__\nproperty uchar x_\nproperty uchar _\n"
                                      "property uchar fiber_1\nproperty double fiber_0\nproperty double fiber_1_\n"));
    assert_non_null(strstr(blob.data, "comment fiber 0 ul_na\n"));
    sn_blob_free(&blob);
    sn_mesh back = round_trip(&mesh, SN_MESH_PLY, SN_ENCODING_LITTLE);
    assert_int_equal(back.attribute_count, 8);
    sn_mesh_free(&back);
    sn_mesh_free(&mesh);
}

static void count_warning(void *count, sn_log_level level, const char *text) {
    if (level == SN_LOG_WARNING && strstr(text, "cannot hold vertex attributes: 'painted' and others") != NULL) ++*(int *)count;
}

static void formats_without_attributes_say_so_once(void **state) {
    (void)state;
    static const sn_mesh_format formats[] = {SN_MESH_OBJ, SN_MESH_OFF, SN_MESH_STL, SN_MESH_PLY, SN_MESH_VTP};
    for (int f = 0; f < 5; f++) {
        sn_mesh mesh = awkward_mesh(false);
        add_values(&mesh, "painted", true, 256.0);
        add_values(&mesh, "other", true, 256.0);
        int warnings = 0;
        sn_log_set(count_warning, &warnings);
        sn_blob blob = write_mesh(&mesh, formats[f], SN_ENCODING_DEFAULT);
        sn_log_set(NULL, NULL);
        assert_int_equal(warnings, f < 3 ? 1 : 0);
        sn_blob_free(&blob);
        sn_mesh_free(&mesh);
    }
}

static void what_a_format_cannot_hold_is_not_written(void **state) {
    (void)state;
    sn_mesh mesh = awkward_mesh(false);
    sn_output *output;
    sn_error error = {0};
    assert_int_equal(sn_output_open("/dev/null", false, &output, NULL), SN_OK);
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_OBJ, SN_ENCODING_BIG, output, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_STL, SN_ENCODING_BIG, output, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_UNKNOWN, SN_ENCODING_DEFAULT, output, &error), SN_ERROR_USAGE);
    mesh.positions[5].y = 1e39; /* more than a float holds */
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_STL, SN_ENCODING_DEFAULT, output, &error), SN_ERROR_INPUT);
    assert_int_equal(error.element, 5);
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_PLY, SN_ENCODING_DEFAULT, output, &error), SN_OK);
    mesh.positions[5].y = NAN;
    assert_int_equal(sn_mesh_write(&mesh, SN_MESH_PLY, SN_ENCODING_DEFAULT, output, &error), SN_ERROR_INPUT);
    sn_output_abort(output);
    sn_mesh_free(&mesh);
}

/* ---- real files: the counts of their manifests ----------------------------------------------------------------------- */

static void expect_manifest_counts(const char *data, const char *set) {
    char path[1024], line[4096], file[256];
    int triangles, vertices, seen = 0;
    snprintf(path, sizeof path, "%s/%s/manifest.tsv", data, set);
    FILE *manifest = fopen(path, "r");
    if (manifest == NULL) {
        print_message("%s is absent: skipped\n", path);
        skip();
    }
    while (fgets(line, sizeof line, manifest) != NULL) {
        if (sscanf(line, "%255[^\t]\t%*[^\t]\t%*[^\t]\t%d\t%d", file, &triangles, &vertices) != 3) continue; /* the title line */
        snprintf(path, sizeof path, "%s/%s/meshes/%s", data, set, file);
        sn_mesh mesh;
        sn_error error = {0};
        if (sn_mesh_read(path, &mesh, NULL, &error) != SN_OK) fail_msg("%s: %s", error.file, error.text);
        if (mesh.triangle_count != triangles || mesh.vertex_count != vertices) {
            fail_msg("%s: %d vertices and %d triangles, not %d and %d", path, mesh.vertex_count, mesh.triangle_count, vertices, triangles);
        }
        sn_mesh_free(&mesh);
        seen++;
    }
    fclose(manifest);
    assert_true(seen > 0);
}

static const char *data_folder(void) { return getenv("DATA") != NULL ? getenv("DATA") : "../shared/data"; }

static void real_ply_files_have_their_counts(void **state) {
    (void)state;
    expect_manifest_counts(data_folder(), "leg-vhf");
}

static void real_stl_files_have_their_counts(void **state) {
    (void)state;
    expect_manifest_counts(data_folder(), "dog-dmcontrol");
}

static void real_obj_files_have_their_counts(void **state) {
    (void)state;
    expect_manifest_counts(data_folder(), "body-bp3d-low");
}

/* ---- counters ------------------------------------------------------------------------------------------------------- */

/* The last thing that a counter of 32 bits holds has been read: a file of gigabytes, so the reader is put there by hand. */
static void more_than_can_be_counted_is_refused_with_a_sentence(void **state) {
    (void)state;
    sn_error error = {0};
    sn_blob blob = {.name = (char[]){"huge.obj"}, .data = (char[]){""}, .size = 0};
    sn_reader full = sn_reader_of(&blob, &error);
    sn_index corners[3] = {0, 1, 2};
    sn_line_set lines = {.thin = SN_INDEX_MAX, .corner_count = SN_INDEX_MAX - 1};
    full.mesh.vertex_count = full.mesh.triangle_count = full.mesh.group_count = SN_INDEX_MAX;
    full.lines = &lines;
    full.corners = corners;
    assert_int_equal(sn_reader_add_vertex(&full, sn_v3(0, 0, 0)), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "more than the 2147483647 vertices"));
    full.corner_count = 3;
    assert_int_equal(sn_reader_add_face(&full, SN_NONE), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "2147483647 triangles"));
    full.corner_count = 3;
    assert_int_equal(sn_reader_add_strip(&full), SN_ERROR_INPUT);
    full.corner_count = 3;
    assert_int_equal(sn_reader_add_line(&full), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "2147483647 points of lines"));
    full.corner_count = 1;
    assert_int_equal(sn_reader_add_line(&full), SN_OK);
    assert_int_equal(lines.thin, SN_INDEX_MAX);
    sn_index group;
    assert_int_equal(sn_reader_group(&full, (sn_span){"g", 1}, &group), SN_ERROR_INPUT);
    assert_int_equal(full.mesh.vertex_count, SN_INDEX_MAX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(obj_reads_every_form_of_a_corner),
        cmocka_unit_test(obj_reads_every_line_end_and_continued_lines),
        cmocka_unit_test(obj_faces_may_come_before_their_vertices),
        cmocka_unit_test(convex_polygons_become_fans),
        cmocka_unit_test(polygons_that_are_not_convex_are_cut_along_their_inside),
        cmocka_unit_test(obj_keeps_groups_by_name),
        cmocka_unit_test(obj_colours_become_attributes),
        cmocka_unit_test(obj_errors_name_the_line),
        cmocka_unit_test(non_finite_coordinates_are_named_unless_allowed),
        cmocka_unit_test(ply_keeps_attributes_and_passes_over_the_rest),
        cmocka_unit_test(ply_reads_every_scalar_type_in_both_byte_orders),
        cmocka_unit_test(ply_header_may_end_lines_in_any_way),
        cmocka_unit_test(ply_errors_name_the_line),
        cmocka_unit_test(false_counts_are_refused),
        cmocka_unit_test(stl_welds_equal_coordinates_in_order),
        cmocka_unit_test(stl_errors_name_the_byte),
        cmocka_unit_test(stl_text_is_read_word_by_word),
        cmocka_unit_test(off_reads_its_variants),
        cmocka_unit_test(off_errors_name_the_line),
        cmocka_unit_test(the_format_is_found_from_content),
        cmocka_unit_test(every_format_and_encoding_gives_the_same_mesh_back),
        cmocka_unit_test(ply_gives_attributes_back),
        cmocka_unit_test(colours_survive_in_every_format_that_has_them),
        cmocka_unit_test(ply_names_properties_apart),
        cmocka_unit_test(formats_without_attributes_say_so_once),
        cmocka_unit_test(what_a_format_cannot_hold_is_not_written),
        cmocka_unit_test(more_than_can_be_counted_is_refused_with_a_sentence),
        cmocka_unit_test(real_ply_files_have_their_counts),
        cmocka_unit_test(real_stl_files_have_their_counts),
        cmocka_unit_test(real_obj_files_have_their_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
