/* test_readers.c -- what every text reader has in common: numbers, counts, line ends and byte order marks, by tables over all of them. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sinew/io.h"

/* ---- all readers ---------------------------------------------------------------------------------------------------- */

/* A text with one coordinate or number left open; `sum` tells what was read of it apart. */
typedef struct reader_case {
    const char *name, *text; /* text: a format for one word */
    int line;                /* of that word */
    sn_status (*read)(const char *path, double *sum, sn_error *error);
} reader_case;

static sn_status read_mesh(const char *path, double *sum, sn_error *error) {
    sn_mesh mesh;
    sn_status status = sn_mesh_read(path, &mesh, NULL, error);
    if (status != SN_OK) return status;
    *sum = mesh.triangle_count;
    for (sn_index i = 0; i < mesh.vertex_count; i++) *sum += mesh.positions[i].x + 3 * mesh.positions[i].y + 7 * mesh.positions[i].z;
    sn_mesh_free(&mesh);
    return SN_OK;
}

static sn_status read_fibers(const char *path, double *sum, sn_error *error) {
    sn_fibers fibers;
    sn_status status = sn_polylines_read(path, &fibers, NULL, error);
    if (status != SN_OK) return status;
    *sum = 1000 * fibers.polyline_count;
    for (sn_index i = 0; i < fibers.polyline_count; i++)
        for (sn_index k = 0; k < fibers.polylines[i].count; k++) *sum += 10 + sn_dot(fibers.polylines[i].points[k], sn_v3(1, 3, 7));
    sn_fibers_free(&fibers);
    return SN_OK;
}

static sn_status read_sites(const char *path, double *sum, sn_error *error) {
    sn_index count;
    sn_end_site *sites;
    sn_space space;
    sn_status status = sn_sites_read(path, &count, &sites, &space, error);
    if (status != SN_OK) return status;
    *sum = 1000 * count;
    for (sn_index i = 0; i < count; i++) *sum += (sites[i].end == 1 ? 100 : 10) + sn_dot(sites[i].point, sn_v3(1, 3, 7));
    free(sites);
    return SN_OK;
}

static sn_status read_landmarks(const char *path, double *sum, sn_error *error) {
    sn_landmarks all;
    sn_status status = sn_landmarks_read(path, &all, error);
    if (status != SN_OK) return status;
    *sum = 1000 * all.count;
    for (sn_index i = 0; i < all.count; i++)
        for (sn_index k = 0; k < all.areas[i].count; k++)
            *sum += (double)strlen(all.areas[i].bone) + sn_dot(all.areas[i].landmarks[k], sn_v3(1, 3, 7));
    sn_landmarks_free(&all);
    return SN_OK;
}

static const reader_case readers[] = {
    {"a.obj", "v 0 0 0\nv 1 0 %s\nv 0 1 0\nf 1 2 3\n", 2, read_mesh},
    {"a.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
     "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 %s\n0 1 0\n3 0 1 2\n",
     11, read_mesh},
    {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 %s\n0 1 0\n3 0 1 2\n", 4, read_mesh},
    {"a.stl", "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 %s\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n", 5,
     read_mesh},
    {"a.vtk", "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0\n1 0 %s\n0 1 0\nPOLYGONS 1 4\n3 0 1 2\n", 7,
     read_mesh},
    {"a.vtp",
     "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n<PolyData>\n<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">\n<Points>\n"
     "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n1 0 %s\n0 1 0\n</DataArray>\n</Points>\n<Polys>\n"
     "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n0 1 2\n</DataArray>\n"
     "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n3\n</DataArray>\n</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n",
     8, read_mesh},
    {"fibres.obj", "v 0 0 0\nv 1 0 %s\nv 0 1 0\nl 1 2 3\n", 2, read_fibers},
    {"sites.txt", "origin 0 0 0\ninsertion 1 0 %s\n", 2, read_sites},
    {"landmarks.tsv", "bone\tarea\tx\ty\tz\nb\t\t0\t0\t0\nb\t\t1\t0\t%s\nb\t\t0\t1\t0\n", 3, read_landmarks},
};
enum { READERS = sizeof readers / sizeof *readers };

/* ---- helpers -------------------------------------------------------------------------------------------------------- */

static char folder[64];

static int enter(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/sinew-readers-XXXXXX");
    return mkdtemp(folder) != NULL && chdir(folder) == 0 ? 0 : -1;
}

static int leave(void **state) {
    (void)state;
    for (int i = 0; i < READERS; i++) unlink(readers[i].name);
    unlink("a");
    unlink("b.stl");
    unlink("a.ply");
    return chdir("/") == 0 && rmdir(folder) == 0 ? 0 : -1;
}

static void write_bytes(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* The reader's text with this word in it. */
static const char *text_with(const reader_case *r, const char *word) {
    static char text[2048];
    const char *hole = strstr(r->text, "%s");
    snprintf(text, sizeof text, "%.*s%s%s", (int)(hole - r->text), r->text, word, hole + 2);
    return text;
}

static double read_text(const reader_case *r, const char *text, size_t size) {
    double sum = NAN;
    sn_error error = {0};
    write_bytes(r->name, text, size);
    if (r->read(r->name, &sum, &error) != SN_OK) fail_msg("%s:%d: %s", r->name, (int)error.line, error.text);
    return sum;
}

static void refuse(const reader_case *r, const char *text, size_t size, int line, const char *words) {
    double sum = NAN;
    sn_error error = {0};
    write_bytes(r->name, text, size);
    if (r->read(r->name, &sum, &error) == SN_OK) fail_msg("%s was read (%g), but '%s' was expected: %s", r->name, sum, words, text);
    if (strstr(error.text, words) == NULL) fail_msg("%s: '%s' does not say '%s'", r->name, error.text, words);
    if (line > 0 && error.line != line) fail_msg("%s: line %d, not %d: %s", r->name, (int)error.line, line, error.text);
}

/* ---- numbers -------------------------------------------------------------------------------------------------------- */

/* A token is a number as a whole: nothing of it is cut off as a comment, a unit or the other side of a decimal comma. */
static void what_is_no_number_is_refused_everywhere(void **state) {
    (void)state;
    static const char *const words[] = {"-1.#IND", "1.#QNAN", "1.#INF",    "-1.#INF00", "1.#IND000", "1.#J",  "1.#",    "1#2",
                                        "1#",      "nan",     "-nan(ind)", "inf",       "1.5.2",     "1e",    "0x10",   "--1",
                                        "1mm",     "1;5",     "1e400",     "nan(",      "1.#QNAN0x", "1_000", "1.5e+-3"};
    for (int i = 0; i < READERS; i++)
        for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
            const char *text = text_with(&readers[i], words[k]);
            refuse(&readers[i], text, strlen(text), readers[i].line, "");
        }
}

static void windows_names_are_not_finite_numbers(void **state) {
    (void)state;
    static const char *const words[] = {"-1.#IND", "1.#QNAN", "1.#INF00", "-nan(ind)", "nan(snan)"};
    for (int i = 0; i < 6; i++) /* meshes */
        for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
            const char *text = text_with(&readers[i], words[k]);
            refuse(&readers[i], text, strlen(text), readers[i].line, "not a finite number");
        }
}

static void a_decimal_comma_is_refused(void **state) {
    (void)state;
    for (int i = 0; i < READERS; i++) {
        const char *text = text_with(&readers[i], "1,5");
        refuse(&readers[i], text, strlen(text), readers[i].line, "");
    }
}

/* In a column that nobody uses the value is passed over, and what stands behind it is read. */
static void unused_columns_may_hold_anything(void **state) {
    (void)state;
    sn_mesh mesh;
    sn_error error = {0};
    const char *text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float nx\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 -1.#IND 0 0\n1 1.#QNAN 0 5\n0 1.#INF 1 0\n"
                       "3 0 1 2\n";
    write_bytes("a", text, strlen(text));
    assert_int_equal(sn_mesh_read("a", &mesh, NULL, &error), SN_OK);
    assert_true(mesh.positions[1].z == 5.0 && mesh.positions[2].y == 1.0);
    assert_true(isnan(sn_mesh_attribute(&mesh, "nx")->values[0]) && isinf(sn_mesh_attribute(&mesh, "nx")->values[2]));
    sn_mesh_free(&mesh);
}

/* ---- comments, lines, marks ------------------------------------------------------------------------------------------- */

static size_t with_line_ends(const char *text, const char *line_end, char *out) {
    char *at = out;
    for (; *text != '\0'; text++) {
        if (*text != '\n') {
            *at++ = *text;
            continue;
        }
        memcpy(at, line_end, strlen(line_end));
        at += strlen(line_end);
    }
    *at = '\0';
    return (size_t)(at - out);
}

static void marks_and_line_ends_change_nothing(void **state) {
    (void)state;
    static const char *const ends[] = {"\n", "\r\n", "\r"};
    for (int i = 0; i < READERS; i++) {
        const char *plain = text_with(&readers[i], "2.5");
        double expected = read_text(&readers[i], plain, strlen(plain));
        for (int k = 0; k < 6; k++) {
            char text[4096] = "\xef\xbb\xbf";
            size_t mark = k >= 3 ? 3 : 0, size = mark + with_line_ends(plain, ends[k % 3], text + mark);
            assert_true(read_text(&readers[i], text, size) == expected);
        }
    }
}

static void wide_text_is_refused_by_name(void **state) {
    (void)state;
    for (int i = 0; i < READERS; i++)
        for (int k = 0; k < 4; k++) {
            const char *plain = text_with(&readers[i], "2.5");
            char text[4096];
            size_t size = 0, length = strlen(plain);
            bool big = k % 2 == 1;
            if (k < 2) memcpy(text, big ? "\xfe\xff" : "\xff\xfe", size = 2);
            for (size_t j = 0; j < length; j++) text[size++] = big ? '\0' : plain[j], text[size++] = big ? plain[j] : '\0';
            refuse(&readers[i], text, size, 0, "UTF-16");
        }
}

/* What has no signature is bytes: 16-bit indices look like letters between zeros. */
static void bytes_are_left_alone(void **state) {
    (void)state;
    const unsigned char bytes[8] = {0x20, 0, 0x21, 0, 0x22, 0, 0x23, 0};
    sn_blob blob;
    sn_error error = {0};
    write_bytes("a", bytes, sizeof bytes);
    assert_int_equal(sn_blob_read_bytes("a", &blob, &error), SN_OK);
    assert_memory_equal(blob.data, bytes, sizeof bytes);
    assert_int_equal(blob.size, sizeof bytes);
    sn_blob_free(&blob);
    write_bytes("a", "\x1f\x8b\x08garbage that is no gzip file", 31);
    assert_int_equal(sn_blob_read("a", &blob, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "unpacked"));
}

/* ---- counts --------------------------------------------------------------------------------------------------------- */

/* What stands behind what a header counts is never dropped without a word: two files in one, or a count that is too small. */
static void counts_are_held_against_the_content(void **state) {
    (void)state;
    static const struct {
        int reader; /* of `readers` */
        const char *from, *to, *first, *second;
    } cases[] = {
        {1, "3 0 1 2\n", "3 0 1 2\n3 0 2 1\n", "counts 1 faces", "1 more lines"},
        {1, "3 0 1 2\n", "3 0 1 2\n\n3 0 2 1\n3 0 2 1\n", "counts 1 faces", "2 more lines"},
        {1, "vertex 3", "vertex 2", "", ""},
        {2, "3 0 1 2\n", "3 0 1 2\n3 0 2 1\n", "counts 1 faces", "1 more lines"},
        {2, "3 0 1 2\n", "3 0 1 2\nOFF\n3 1 0\n", "counts 1 faces", "2 more lines"},
        {2, "3 1 0", "2 1 0", "", ""},
        {4, "POLYGONS 1 4\n3 0 1 2", "POLYGONS 1 8\n3 0 1 2\n3 0 2 1", "1 cells", "4 of their numbers"},
        {4, "POLYGONS 1 4\n3 0 1 2", "POLYGONS 1 4\n3 0 1 2\n3 0 2 1", "", ""},
        {4, "POLYGONS 1 4\n3 0 1 2", "POLYGONS 2 6\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2 0 2 1", "3 vertices",
         "6 are"},
        {4, "POINTS 3", "POINTS 2", "", ""},
        {5, ">\n3\n<", ">\n3 6\n<", "1 numbers of offsets", "holds 2"},
        {5, "0 1 2\n", "0 1 2 0 2 1\n", "3 numbers of connectivity", "holds 6"},
        {5, "NumberOfPoints=\"3\"", "NumberOfPoints=\"2\"", "6 numbers of points", "holds 9"},
        {5, "NumberOfPolys=\"1\"", "NumberOfPolys=\"0\"", "0 numbers of offsets", "holds 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *text = text_with(&readers[cases[i].reader], "2.5"), *at = strstr(text, cases[i].from);
        char changed[4096];
        assert_non_null(at);
        snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, cases[i].to, at + strlen(cases[i].from));
        refuse(&readers[cases[i].reader], changed, strlen(changed), 0, cases[i].first);
        refuse(&readers[cases[i].reader], changed, strlen(changed), 0, cases[i].second);
    }
}

static void put_stl(unsigned char *at, uint32_t counted, int triangles) {
    memset(at, 0, 84 + 50 * (size_t)triangles);
    for (int i = 0; i < 4; i++) at[80 + i] = (unsigned char)(counted >> 8 * i);
    for (int t = 0; t < triangles; t++)
        for (int c = 0; c < 3; c++) {
            float p[3] = {c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f, (float)t};
            memcpy(at + 84 + 50 * t + 12 + 12 * c, p, sizeof p);
        }
}

static void binary_counts_are_held_against_the_content(void **state) {
    (void)state;
    const reader_case binary = {"b.stl", NULL, 0, read_mesh};
    unsigned char two[2 * (84 + 200)];
    put_stl(two, 0, 4);
    refuse(&binary, (char *)two, 284, 0, "counts 0 triangles, but the file has room for 4");
    put_stl(two, 2, 4);
    refuse(&binary, (char *)two, 284, 0, "counts 2 triangles, but the file has room for 4");
    put_stl(two, 4, 4);
    put_stl(two + 284, 4, 4);
    refuse(&binary, (char *)two, 568, 0, "counts 4 triangles");
    memset(two + 284, 0, 284); /* padding is nothing */
    read_text(&binary, (char *)two, 568);
    static const char head[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
        "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    char ply[512];
    size_t size = sizeof head - 1;
    memcpy(ply, head, size);
    memcpy(ply + size, "\0\0\0\1\0\0\0\1\0\3\0\1\2", 13);
    read_text(&binary, ply, size + 13);
    memcpy(ply + size + 13, "\3\0\2\1", 4);
    refuse(&binary, ply, size + 17, 0, "counts 1 faces, but 4 more bytes");
}

/* ---- strips of triangles in PLY ------------------------------------------------------------------------------------------ */

/* PLY with four points and these lists, in one of the three encodings; type: of the vertices' numbers. */
static size_t strips_ply(char *out, size_t size, int encoding, const char *type, const int lists[][12], int list_count) {
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    size_t at = (size_t)snprintf(out, size,
                                 "ply\nformat %s 1.0\nelement vertex 4\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
                                 "element tristrips %d\nproperty list int %s vertex_indices\nend_header\n",
                                 formats[encoding], list_count, type);
    static const unsigned char points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            at += encoding == 0 ? (size_t)snprintf(out + at, size - at, "%d%c", points[i][k], k < 2 ? ' ' : '\n')
                                : (size_t)((out[at] = (char)points[i][k]), 1);
    for (int i = 0; i < list_count; i++) {
        for (int k = 0; k <= lists[i][0]; k++) {
            uint32_t bits = (uint32_t)lists[i][k];
            if (encoding == 0) at += (size_t)snprintf(out + at, size - at, "%d ", lists[i][k]);
            for (int b = 0; b < 4 && encoding > 0; b++) out[at++] = (char)(bits >> 8 * (encoding == 1 ? b : 3 - b));
        }
        if (encoding == 0) out[at++] = '\n';
    }
    return at;
}

static sn_mesh strips_mesh(int encoding, const char *type, const int lists[][12], int list_count) {
    char text[1024];
    sn_blob blob = {(char *)(uintptr_t) "a.ply", text, strips_ply(text, sizeof text, encoding, type, lists, list_count)};
    sn_mesh mesh;
    sn_error error = {0};
    if (sn_mesh_parse(&blob, false, &mesh, &error) != SN_OK) fail_msg("%s", error.text);
    return mesh;
}

/* Of the tetrahedron (0,0,0) (1,0,0) (0,1,0) (0,0,1), faces outward: as large as it is, so that every other triangle is turned over. */
static double volume_of(const sn_mesh *mesh) {
    double sum = 0.0;
    for (sn_index i = 0; i < mesh->triangle_count; i++) {
        const sn_index *v = mesh->triangles[i].v;
        sum += sn_dot(mesh->positions[v[0]], sn_cross(mesh->positions[v[1]], mesh->positions[v[2]])) / 6.0;
    }
    return sum;
}

static void strips_of_a_ply_file_are_triangles(void **state) {
    (void)state;
    /* a count and the vertices */
    static const int one[][12] = {{6, 3, 0, 1, 2, 3, 0}};
    static const int ended[][12] = {{7, 3, 0, 1, 2, 3, 0, -1}};
    static const int two[][12] = {{9, 0, 2, 1, 3, -1, 3, 2, 0, 1}}; /* two strips of two triangles */
    static const int four[][12] = {{11, 0, 2, 1, -1, 0, 1, 3, -1, 0, 3, 2}, {3, 1, 2, 3}};
    static const int lists[][12] = {{4, 0, 2, 1, 3}, {4, 3, 2, 0, 1}};
    static const int sewn[][12] = {{10, 0, 2, 1, 3, 3, 3, 3, 2, 0, 1}}; /* by triangles of two equal corners */
    static const int idle[][12] = {{9, -1, -1, 3, 0, 1, 2, 3, 0, -1}, {0}};
    static const struct {
        const int (*lists)[12];
        int count;
    } cases[] = {{one, 1}, {ended, 1}, {two, 1}, {four, 2}, {lists, 2}, {sewn, 1}, {idle, 2}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
        for (int encoding = 0; encoding < 3; encoding++)
            for (int is_unsigned = 0; is_unsigned < 2; is_unsigned++) {
                if (encoding == 0 && is_unsigned) continue; /* no -1 in text that is unsigned */
                sn_mesh mesh = strips_mesh(encoding, is_unsigned ? "uint" : "int", cases[c].lists, cases[c].count);
                assert_int_equal(mesh.vertex_count, 4);
                assert_int_equal(mesh.triangle_count, 4);
                if (fabs(volume_of(&mesh) - 1.0 / 6.0) > 1e-12) fail_msg("case %zu: volume %g", c, volume_of(&mesh));
                assert_int_equal(sn_mesh_validate(&mesh, NULL), SN_OK);
                sn_mesh_free(&mesh);
            }
}

#define STRIPS_HEAD "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"

static void strips_and_faces_are_one_mesh(void **state) {
    (void)state;
    static const reader_case r = {"a.ply", NULL, 0, read_mesh};
    static const char both[] =
        STRIPS_HEAD "element face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\nproperty uchar flags\n"
                    "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n"
                    "9 4 3 2 0 -1\n";
    static const char broken[][160] = {
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 4\n",
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 -2 1\n",
        "element tristrips 1\nproperty list int float vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n",
        "element tristrips 1\nproperty list int int other\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n",
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 0 1 2\n",
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 1 2 3\n",
        "element tristrips 0\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"};
    static const char *const words[] = {
        "vertex 4", "vertex -2", "whole numbers", "tristrips need a property list", "expected a number", "counts 1 faces, but 1 more lines",
        "no faces"};
    read_text(&r, both, sizeof both - 1);
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        char text[512];
        int length = snprintf(text, sizeof text, STRIPS_HEAD "%s", broken[i]);
        refuse(&r, text, (size_t)length, 0, words[i]);
    }
    const int cut[][12] = {{6, 3, 0, 1, 2, 3, 0}};
    char binary[512];
    size_t size = strips_ply(binary, sizeof binary, 1, "int", cut, 1);
    refuse(&r, binary, size - 2, 0, "cut short");
}

/* ---- fibres -------------------------------------------------------------------------------------------------------------- */

static sn_fibers fibers_of(const char *text) {
    sn_fibers fibers;
    sn_error error = {0};
    write_bytes("a", text, strlen(text));
    if (sn_polylines_read("a", &fibers, NULL, &error) != SN_OK) fail_msg("%d: %s", (int)error.line, error.text);
    return fibers;
}

static void expect_line(const sn_fibers *fibers, sn_index line, const char *xs) {
    char found[64] = "";
    for (sn_index k = 0; k < fibers->polylines[line].count; k++)
        snprintf(found + strlen(found), sizeof found - strlen(found), "%g", fibers->polylines[line].points[k].x);
    assert_string_equal(found, xs);
}

#define POINTS "v 1 0 0\nv 2 0 0\nv 3 0 0\nv 4 0 0\nv 5 0 0\nv 6 0 0\nv 7 0 0\n"

static void segments_are_joined_end_to_end(void **state) {
    (void)state;
    sn_fibers f = fibers_of(POINTS "l 2 3\nl 1 2\nl 4 3\nl 6 7\nl 6 5\n"); /* in any order and direction */
    assert_int_equal(f.polyline_count, 2);
    expect_line(&f, 0, "1234");
    expect_line(&f, 1, "567");
    sn_fibers_free(&f);
    f = fibers_of(POINTS "l 1 2\nl 2 3\nl 2 4\n"); /* where three meet nothing is joined */
    assert_int_equal(f.polyline_count, 3);
    sn_fibers_free(&f);
    f = fibers_of(POINTS "l 1 2 3\nl 3 4 5\nl 5 6\n"); /* whole lines stay as they are */
    assert_int_equal(f.polyline_count, 3);
    expect_line(&f, 2, "56");
    sn_fibers_free(&f);
    f = fibers_of(POINTS "l 1 2\nl 2 3\nl 3 1\n"); /* a ring ends where it began */
    assert_int_equal(f.polyline_count, 1);
    assert_int_equal(f.polylines[0].count, 4);
    sn_fibers_free(&f);
}

static void lines_go_on_behind_a_backslash(void **state) {
    (void)state;
    sn_fibers f = fibers_of("v 1 0 \\\n0\nv 2 0 0\nv 3 0 0\nl 1 2 \\\r\n3 # the end\n");
    assert_int_equal(f.polyline_count, 1);
    expect_line(&f, 0, "123");
    sn_fibers_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_no_number_is_refused_everywhere),
        cmocka_unit_test(windows_names_are_not_finite_numbers),
        cmocka_unit_test(a_decimal_comma_is_refused),
        cmocka_unit_test(unused_columns_may_hold_anything),
        cmocka_unit_test(marks_and_line_ends_change_nothing),
        cmocka_unit_test(wide_text_is_refused_by_name),
        cmocka_unit_test(bytes_are_left_alone),
        cmocka_unit_test(counts_are_held_against_the_content),
        cmocka_unit_test(binary_counts_are_held_against_the_content),
        cmocka_unit_test(strips_of_a_ply_file_are_triangles),
        cmocka_unit_test(strips_and_faces_are_one_mesh),
        cmocka_unit_test(segments_are_joined_end_to_end),
        cmocka_unit_test(lines_go_on_behind_a_backslash),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
