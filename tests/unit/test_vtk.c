/*
 * test_vtk.c -- legacy VTK and VTK XML PolyData: what is read, what is refused and where, and that VTK itself agrees (tests/vtk-check.py).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sinew/io.h"
#include "sinew/muscle.h"

/* ---- helpers -------------------------------------------------------------------------------------------------------- */

static sn_status parse_bytes(const char *bytes, size_t size, sn_mesh *out, sn_error *error) {
    sn_blob blob = {.name = (char *)"x", .size = size};
    blob.data = malloc(size + 1); /* exactly as long as the file: a sanitizer sees the first byte too many */
    assert_non_null(blob.data);
    memcpy(blob.data, bytes, size);
    blob.data[size] = '\0';
    *error = (sn_error){0};
    sn_status status = sn_mesh_parse(&blob, false, out, error);
    free(blob.data);
    return status;
}

static sn_mesh read_bytes(const char *bytes, size_t size) {
    sn_mesh mesh;
    sn_error error;
    if (parse_bytes(bytes, size, &mesh, &error) != SN_OK) fail_msg("%s:%d: %s", error.file, (int)error.line, error.text);
    assert_int_equal(sn_mesh_validate(&mesh, NULL), SN_OK);
    return mesh;
}

static sn_mesh read_text(const char *text) { return read_bytes(text, strlen(text)); }

/* The file is refused at this line (0 = a byte is named), with these words. */
static void refuse_bytes(const char *bytes, size_t size, int line, const char *words) {
    sn_mesh mesh;
    sn_error error;
    sn_status status = parse_bytes(bytes, size, &mesh, &error);
    if (status == SN_OK) fail_msg("the file was read, but '%s' was expected", words);
    assert_int_equal(status, SN_ERROR_INPUT);
    assert_string_equal(error.file, "x");
    if (strstr(error.text, words) == NULL) fail_msg("'%s' does not say '%s'", error.text, words);
    assert_int_equal(error.line, line);
    assert_null(mesh.positions);
}

static void refuse(const char *text, int line, const char *words) { refuse_bytes(text, strlen(text), line, words); }

static void expect_triangle(const sn_mesh *mesh, sn_index triangle, sn_index a, sn_index b, sn_index c) {
    assert_in_range(triangle, 0, mesh->triangle_count - 1);
    const sn_index *v = mesh->triangles[triangle].v;
    if (v[0] != a || v[1] != b || v[2] != c) fail_msg("triangle %d is %d %d %d", triangle, v[0], v[1], v[2]);
}

/* The attribute of this name and width, whose value number `at` is `value`. */
static void expect_number(const sn_mesh *mesh, const char *name, sn_index components, sn_index at, double value) {
    const sn_attribute *attribute = sn_mesh_attribute(mesh, name);
    if (attribute == NULL) fail_msg("there is no attribute %s", name);
    assert_int_equal(attribute->components, components);
    if (attribute->values[at] != value) fail_msg("%s is %.17g at %d, not %.17g", name, attribute->values[at], at, value);
}

/* ---- legacy VTK ----------------------------------------------------------------------------------------------------- */

#define LEGACY(kind) "# vtk DataFile Version 3.0\nany # title \\\n" kind "\nDATASET POLYDATA\n"
#define FOUR "POINTS 4 float\n0 0 0 1 0 0\n0 1 0\n0 0 1\n"
#define FACES "POLYGONS 2 9\n3 0 2 1\n4 0 1 2 3\n"

static void legacy_text_is_read_with_its_point_data(void **state) {
    (void)state;
    sn_mesh mesh = read_text(
        LEGACY("ASCII") "\n\nFIELD FieldData 2\nwords 1 2 string\nPOINTS 3 float\n\nn 2 2 int\n1 2 3 4\nMETADATA\n"
                        "INFORMATION 1\nNAME x LOCATION y\nDATA 2 0 1\n\n" FOUR "\nMETADATA\nCOMPONENT_NAMES\nX\n\n\nINFORMATION 0\n\n"
                        "VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\n" FACES "TRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"
                        "CELL_DATA 5\nSCALARS c int 2\nLOOKUP_TABLE t\n0 1 2 3 4 5 6 7 8 9\nLOOKUP_TABLE t 1\n0 0 0 1\n"
                        "POINT_DATA 4\nscalars a%20b Float\nLOOKUP_TABLE default\n.5 1 1.5 2\nNORMALS n double\n"
                        "1 0 0 0 1 0 0 0 1 0 0 2\nFIELD FieldData 3\nNULL_ARRAY\nbytes 1 4 unsigned_char\n0 1 2 255\n"
                        "METADATA\nINFORMATION 0\n\nshort 1 3 int\n1 2 3\nCOLOR_SCALARS c 1\n0 1 0 1\n"
                        "TEXTURE_COORDINATES uv 2 float\n0 0 1 0 0 1 1 1\n");
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.triangle_count, 5);
    expect_triangle(&mesh, 0, 0, 2, 1);
    expect_triangle(&mesh, 3, 0, 1, 2);
    expect_triangle(&mesh, 4, 2, 1, 3); /* every other triangle of a strip is turned over */
    assert_int_equal(mesh.attribute_count, 5);
    expect_number(&mesh, "a b", 1, 2, 1.5);
    expect_number(&mesh, "n", 3, 11, 2.0);
    expect_number(&mesh, "bytes", 1, 3, 255.0);
    assert_true(sn_mesh_attribute(&mesh, "bytes")->integer);
    expect_number(&mesh, "uv", 2, 2, 1.0);
    sn_mesh_free(&mesh);
}

static void legacy_keywords_may_be_in_any_case(void **state) {
    (void)state;
    sn_mesh mesh = read_text("# VTK DATAFILE VERSION 1.0\r\n\r\nascii\r\ndataset polydata\r\npoints 3 DOUBLE\r\n0 0 0 1 0 0 0 1 0\r\n"
                             "polygons 1 4\r\n3 0 1 2");
    expect_triangle(&mesh, 0, 0, 1, 2);
    sn_mesh_free(&mesh);
}

static void legacy_version_five_has_offsets(void **state) {
    (void)state;
    sn_mesh mesh = read_text(LEGACY("ASCII") FOUR "LINES 2 2\nOFFSETS vtktypeint64\n0 2\nCONNECTIVITY vtktypeint64\n0 1\n"
                                                  "POLYGONS 3 7\noffsets vtktypeint64\n0 3 7\nconnectivity vtktypeint64\n0 2 1 0 1 2 3\n");
    assert_int_equal(mesh.triangle_count, 3);
    expect_triangle(&mesh, 2, 0, 2, 3);
    sn_mesh_free(&mesh);
    refuse(LEGACY("ASCII") FOUR "POLYGONS 3 7\nOFFSETS int\n0 3 2\nCONNECTIVITY int\n0 2 1 0 1 2 3\n", 11, "offsets ascend");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 3 7\nOFFSETS int\n0 3 8\nCONNECTIVITY int\n0 2 1 0 1 2 3\n", 11, "7 vertices of all");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 2 3\nOFFSETS int\n0 3\nPOINT_DATA 4\n", 12, "CONNECTIVITY");
}

static void legacy_binary_is_big_endian(void **state) {
    (void)state;
    static const char file[] = LEGACY("BINARY") "POINTS 3 short\n\0\0\0\0\0\0\0\1\0\0\0\0\0\0\1\0\0\0\n" /* (0 0 0) (1 0 0) (0 256 0) */
                                                "POLYGONS 1 4\n\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2\n\nCELL_DATA 1\nSCALARS c bit 1\n"
                                                "LOOKUP_TABLE t\n#\nPOINT_DATA 3\nSCALARS s unsigned_char\nLOOKUP_TABLE t\n\n#\377\n";
    sn_mesh mesh = read_bytes(file, sizeof file - 1);
    assert_int_equal(mesh.vertex_count, 3);
    assert_true(mesh.positions[1].x == 1.0);
    assert_true(mesh.positions[2].y == 256.0);
    expect_triangle(&mesh, 0, 0, 1, 2);
    expect_number(&mesh, "s", 1, 0, 10.0); /* a line feed and a comment's sign are values here */
    expect_number(&mesh, "s", 1, 1, 35.0);
    expect_number(&mesh, "s", 1, 2, 255.0);
    sn_mesh_free(&mesh);
    for (size_t size = 30; size + 120 < sizeof file; size++) {
        sn_error error;
        if (parse_bytes(file, size, &mesh, &error) == SN_OK) fail_msg("%d bytes were read", (int)size);
    }
}

static void legacy_errors_name_the_place(void **state) {
    (void)state;
    refuse("# vtk DataFile Version 3.0\nx\n", 3, "cut short");
    refuse("# vtk DataFile Version 3.0\nx\nBINAR\n", 3, "found 'BINAR'");
    refuse("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n", 4, "UNSTRUCTURED_GRID, not POLYDATA");
    refuse(LEGACY("ASCII") "POINTS 1000000000 float\n0 0 0\n", 5, "more than the rest of the file");
    refuse(LEGACY("ASCII") "POINTS 4000000000 float\n0 0 0\n", 5, "more than");
    refuse(LEGACY("ASCII") "POINTS -1 float\n0 0 0\n", 5, "count of points");
    refuse(LEGACY("ASCII") "POINTS 1 float\n0 0 x\n", 6, "found 'x'");
    refuse(LEGACY("ASCII") "POINTS 1 complex\n0 0 0\n", 5, "found 'complex'");
    refuse(LEGACY("ASCII") FOUR FOUR, 9, "twice");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 1 4\n3 0 1 4\n", 10, "names vertex 4");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 1 4\n3 0 1 -1\n", 10, "cannot be");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 1 4\n9 0 1 2\n", 10, "impossible count");
    refuse(LEGACY("ASCII") FOUR "POLYGONS 1 1000000000\n9 0 1 2\n", 9, "more than the rest");
    refuse(LEGACY("ASCII") FOUR FACES "POINT_DATA 5\n", 12, "5 rows for 4 points");
    refuse(LEGACY("ASCII") FOUR FACES "GRAPH 5\n", 12, "found 'GRAPH'");
    refuse(LEGACY("ASCII") FOUR FACES "POINT_DATA 4\nSCALARS s float 1000000\nLOOKUP_TABLE x\n1 2 3 4\n", 14, "more than the rest");
    refuse(LEGACY("ASCII") FOUR, 0, "no faces");
}

/* ---- VTK XML -------------------------------------------------------------------------------------------------------- */

#define HEAD "<?xml version='1.0'?>\n<!-- made by hand -->\n<VTKFile type='PolyData' version='0.1' byte_order='LittleEndian'>\n<PolyData>\n"
#define TAIL "</PolyData></VTKFile>\n"
#define PIECE(points, polys) "<Piece NumberOfPoints='" points "' NumberOfPolys='" polys "'>\n"
#define POINTS(values) "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>" values "</DataArray></Points>"
#define CELLS(name, connectivity, offsets)                                                                                                 \
    "<" name "><DataArray type='Int32' Name='connectivity' format='ascii'>" connectivity "</DataArray>"                                    \
    "<DataArray type='Int32' Name='offsets' format='ascii'>" offsets "</DataArray></" name ">"
#define DATA(name, width, values)                                                                                                          \
    "<PointData><DataArray type='Float64' Name='" name "' NumberOfComponents='" width "'>" values "</DataArray></PointData>"
#define CORNERS "0 0 0 1 0 0 0 1 0\n"

static void xml_pieces_become_one_mesh(void **state) {
    (void)state;
    sn_mesh mesh = read_text(HEAD PIECE("3", "1") DATA("a", "1", "1 2 3") POINTS(CORNERS) CELLS("Polys", "0 1 2", "3") "</Piece>" PIECE(
        "0", "0") "</Piece><Piece NumberOfPoints='3' NumberOfStrips='1' NumberOfVerts='1'>" CELLS("Verts", "0", "1") POINTS(CORNERS)
                                 CELLS("Strips", "0 1 2 0", "4")
                                     DATA("a", "1", "4 5 6<InformationKey><Value>7</Value></InformationKey> ") "</Piece>" TAIL);
    assert_int_equal(mesh.vertex_count, 6);
    assert_int_equal(mesh.triangle_count, 3);
    expect_triangle(&mesh, 0, 0, 1, 2);
    expect_triangle(&mesh, 1, 3, 4, 5);
    expect_triangle(&mesh, 2, 5, 4, 3);
    expect_number(&mesh, "a", 1, 0, 1.0);
    expect_number(&mesh, "a", 1, 5, 6.0);
    sn_mesh_free(&mesh);
}

static void xml_data_that_not_all_pieces_have_are_left_out(void **state) {
    (void)state;
    sn_mesh mesh = read_text(HEAD PIECE("3", "1") DATA("a", "1", "1 2 3") POINTS(CORNERS) CELLS("Polys", "0 1 2", "3") "</Piece>" PIECE(
        "3", "1") DATA("b", "1", "1 2 3") POINTS(CORNERS) CELLS("Polys", "0 1 2", "3") "</Piece>" TAIL);
    assert_int_equal(mesh.attribute_count, 0);
    sn_mesh_free(&mesh);
}

#define ONE(points, cells) HEAD PIECE("3", "1") points cells "</Piece>" TAIL
#define GOOD_CELLS CELLS("Polys", "0 1 2", "3")

static void xml_errors_name_the_place(void **state) {
    (void)state;
    refuse("<VTKFile type='UnstructuredGrid'>\n", 1, "not of UnstructuredGrid");
    refuse("<VTKFile type='PolyData' byte_order='Middle'>\n", 1, "byte order");
    refuse(HEAD "<Piece NumberOfPoints='x'>", 5, "NumberOfPoints must be a count");
    refuse(HEAD "</Piece>", 5, "XML is broken");
    refuse(HEAD PIECE("3", "1"), 6, "XML is broken");
    refuse(ONE("", GOOD_CELLS), 5, "no points");
    refuse(ONE(POINTS("0 0 0 1 0"), GOOD_CELLS), 6, "9 numbers of points");
    refuse(ONE(POINTS("0 0 0 1 0 0 0 one 0"), GOOD_CELLS), 6, "found 'one'");
    refuse(ONE(POINTS("0 0 0 1 0 0 0 1         "), GOOD_CELLS), 6, "end too soon");
    refuse(ONE(POINTS(CORNERS), ""), 5, "without connectivity");
    refuse(ONE(POINTS(CORNERS), CELLS("Polys", "0 1 3", "3")), 7, "names vertex 3");
    refuse(ONE(POINTS(CORNERS), CELLS("Polys", "0 1 -2", "3")), 7, "names vertex -2");
    refuse(ONE(POINTS(CORNERS), CELLS("Polys", "0 1 2", "300")), 7, "300 numbers of connectivity");
    refuse(HEAD PIECE("3", "2") POINTS(CORNERS) CELLS("Polys", "0 1 2", "3 2") "</Piece>" TAIL, 7, "offsets ascend");
    refuse(HEAD PIECE("3000000000", "2") POINTS(CORNERS) "</Piece>" TAIL, 5, "more points than");
    refuse(HEAD PIECE("2000000000", "2") POINTS(CORNERS) "</Piece>" TAIL, 6, "there is room for");
    refuse(HEAD PIECE("3", "1") POINTS("") "</Piece>" TAIL, 6, "there is room for 0");
    refuse(ONE(POINTS(CORNERS) DATA("a", "9", "1 2 3"), GOOD_CELLS), 7, "27 numbers of point data");
    refuse(HEAD PIECE("3", "0") POINTS(CORNERS) "</Piece>" TAIL, 0, "no faces");
}

static void xml_tricks_are_refused(void **state) {
    (void)state;
    refuse("<?xml version='1.0'?>\n<!DOCTYPE v [<!ENTITY a '1 1 1'><!ENTITY b '&a;&a;&a;'>]>\n<VTKFile type='PolyData'>&b;</VTKFile>", 2,
           "document type");
    char deep[2000] = "<VTKFile type='PolyData'>";
    for (int i = 0; i < 200; i++) strcat(deep, "<a>");
    refuse(deep, 1, "nested too deep");
}

/* Three points and a triangle as appended data; %s is the compressor and the encoding. */
#define APPENDED(compressor, encoding)                                                                                                     \
    "<VTKFile type='PolyData' byte_order='LittleEndian' " compressor "><PolyData>" PIECE(                                                  \
        "3", "1") "<Points><DataArray type='Int8' format='appended' NumberOfComponents='3' offset='0'/></Points>" GOOD_CELLS               \
                  "</Piece></PolyData><AppendedData encoding='" encoding "'>\n  _"
#define ZLIB "compressor='vtkZLibDataCompressor'"

static void xml_appended_bytes_are_read_and_checked(void **state) {
    (void)state;
    static const char raw[] = APPENDED("", "raw") "\11\0\0\0\0\0\0\1\0\0\0\1\0</AppendedData></VTKFile>";
    sn_mesh mesh = read_bytes(raw, sizeof raw - 1);
    assert_true(mesh.positions[1].x == 1.0);
    assert_true(mesh.positions[2].y == 1.0);
    sn_mesh_free(&mesh);
    mesh = read_text(APPENDED("", "base64") "CQAAAAAAAAEAAAABAA==</AppendedData></VTKFile>"); /* the same thirteen bytes */
    assert_true(mesh.positions[2].y == 1.0);
    sn_mesh_free(&mesh);
    mesh = read_text(APPENDED("", "base64") "CQAAAA==AAAAAQAAAAEA"); /* the count encoded by itself */
    assert_true(mesh.positions[2].y == 1.0);
    sn_mesh_free(&mesh);
    mesh = read_text("<!-- <X3D> -->" APPENDED("", "base64") "CQAAAAAAAAEAAAABAA=="); /* other formats' words prove nothing */
    sn_mesh_free(&mesh);
    refuse(APPENDED("", "base64") "CQAAAAAAAAEAAAA", 0, "damaged or cut short");
    refuse(APPENDED("", "base64") "CQAAAAAAAAE?AAABAA==", 0, "damaged or cut short");
    refuse(APPENDED("", "hex") "09", 2, "encoding");
    static const char large[] = APPENDED("", "raw") "\377\377\377\377\0\0\0";
    refuse_bytes(large, sizeof large - 1, 0, "damaged or cut short");
    refuse(APPENDED("compressor='vtkLZ4DataCompressor'", "base64") "CQAAAA==", 0, "zlib or without compression");
}

static void xml_bombs_are_refused(void **state) {
    (void)state;
    /* a block of 4 GB from a few bytes; 4 billion blocks; an empty block that promises 9 bytes */
    static const char giant[] = APPENDED(ZLIB, "raw") "\1\0\0\0\377\377\377\377\0\0\0\0\4\0\0\0xxxx";
    static const char many[] = APPENDED(ZLIB, "raw") "\377\377\377\377\377\377\377\377\0\0\0\0\4\0\0\0xxxx";
    static const char empty[] = APPENDED(ZLIB, "raw") "\1\0\0\0\11\0\0\0\0\0\0\0\10\0\0\0x\234\3\0\0\0\0\1";
    refuse_bytes(giant, sizeof giant - 1, 0, "more than ten times the file");
    refuse_bytes(many, sizeof many - 1, 0, "damaged or cut short");
    refuse_bytes(empty, sizeof empty - 1, 0, "damaged or cut short");
}

/* ---- writing -------------------------------------------------------------------------------------------------------- */

static void write_file(const sn_mesh *mesh, const char *path, sn_mesh_format format, sn_mesh_encoding encoding) {
    sn_output *output;
    sn_error error = {0};
    assert_int_equal(sn_output_open(path, false, &output, &error), SN_OK);
    if (sn_mesh_write(mesh, format, encoding, output, &error) != SN_OK) fail_msg("%s", error.text);
    assert_int_equal(sn_output_commit(output, &error), SN_OK);
}

static sn_mesh read_file(const char *path) {
    sn_mesh mesh;
    sn_error error = {0};
    if (sn_mesh_read(path, &mesh, NULL, &error) != SN_OK) fail_msg("%s:%d: %s", error.file, (int)error.line, error.text);
    return mesh;
}

/* Same points up to `tolerance`, same triangles; every attribute of `want` is in `got`, as exact, if attributes are asked for. */
static void expect_same(const sn_mesh *got, const sn_mesh *want, double tolerance, bool attributes, const char *where) {
    if (got->vertex_count != want->vertex_count || got->triangle_count != want->triangle_count) {
        fail_msg("%s has %d vertices, %d triangles", where, got->vertex_count, got->triangle_count);
    }
    for (sn_index i = 0; i < want->vertex_count; i++) {
        if (!(sn_distance(got->positions[i], want->positions[i]) <= tolerance)) fail_msg("%s: vertex %d differs", where, i);
    }
    for (sn_index t = 0; t < want->triangle_count; t++) {
        if (memcmp(&got->triangles[t], &want->triangles[t], sizeof(sn_triangle)) != 0) fail_msg("%s: triangle %d differs", where, t);
    }
    for (sn_index a = 0; attributes && a < want->attribute_count; a++) {
        const sn_attribute *x = &want->attributes[a], *y = sn_mesh_attribute(got, x->name);
        if (y == NULL || y->components != x->components) fail_msg("%s has no %s as wide", where, x->name);
        for (sn_index i = 0; i < want->vertex_count * x->components; i++) {
            if (!(fabs(x->values[i] - y->values[i]) <= tolerance * fmax(1.0, fabs(x->values[i]))))
                fail_msg("%s: %s differs", where, x->name);
        }
    }
}

/* A tetrahedron with every kind of attribute and a name that XML must escape. */
static sn_mesh painted_tetrahedron(const char *odd_name) {
    static const sn_vec3 positions[] = {{0, 0, 0}, {1.0 / 3.0, 0, 1e-300}, {0, -0.1, 1e300}, {0.1, 0.2, 0.3}};
    static const sn_triangle triangles[] = {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}};
    const char *const names[] = {"part", "sample", "fiber", odd_name};
    static const sn_index widths[] = {1, 1, 3, 2};
    sn_mesh mesh;
    assert_int_equal(sn_mesh_alloc(&mesh, 4, 4, NULL), SN_OK);
    memcpy(mesh.positions, positions, sizeof positions);
    memcpy(mesh.triangles, triangles, sizeof triangles);
    for (int k = 0; k < 4; k++) {
        sn_attribute *attribute = sn_mesh_add_attribute(&mesh, names[k], widths[k]);
        assert_non_null(attribute);
        attribute->integer = k < 2;
        for (sn_index i = 0; i < 4 * widths[k]; i++) attribute->values[i] = k == 0 ? 80.0 * i : k == 1 ? 100.0 * i - 1.0 : 1.0 / (i + 3);
    }
    assert_true(sn_attribute_add_label(&mesh.attributes[0], "ulna & <radius>"));
    assert_true(sn_attribute_add_label(&mesh.attributes[0], "h\303\274fte"));
    return mesh;
}

static const struct {
    const char *name;
    sn_mesh_format format;
    sn_mesh_encoding encoding;
} forms[] = {{"text.vtp", SN_MESH_VTP, SN_ENCODING_ASCII},    {"default.vtp", SN_MESH_VTP, SN_ENCODING_DEFAULT},
             {"little.vtp", SN_MESH_VTP, SN_ENCODING_LITTLE}, {"big.vtp", SN_MESH_VTP, SN_ENCODING_BIG},
             {"text.ply", SN_MESH_PLY, SN_ENCODING_ASCII},    {"little.ply", SN_MESH_PLY, SN_ENCODING_LITTLE},
             {"big.ply", SN_MESH_PLY, SN_ENCODING_BIG}};
enum { FORM_COUNT = sizeof forms / sizeof *forms, VTP_FORMS = 4 };

static char folder[64];
static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/sinew-vtk-XXXXXX");
    return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state) {
    (void)state;
    DIR *dir = opendir(folder);
    char path[512];
    for (struct dirent *entry; dir != NULL && (entry = readdir(dir)) != NULL;) {
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.') unlink(path);
    }
    if (dir != NULL) closedir(dir);
    return rmdir(folder);
}

static void what_is_written_is_read_back_exactly(void **state) {
    (void)state;
    sn_mesh mesh = painted_tetrahedron("a<b> & \"c\"");
    for (int i = 0; i < VTP_FORMS; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", folder, forms[i].name);
        write_file(&mesh, path, forms[i].format, forms[i].encoding);
        sn_mesh back = read_file(path);
        expect_same(&back, &mesh, 0.0, true, forms[i].name);
        assert_int_equal(back.attribute_count, mesh.attribute_count);
        assert_true(sn_mesh_attribute(&back, "part")->integer);
        sn_mesh_free(&back);
    }
    sn_mesh_free(&mesh);
}

static void sections_are_painted_on_the_mesh(void **state) {
    (void)state;
    sn_mesh painted, mesh = painted_tetrahedron("a<b> & \"c\"");
    sn_vec3 directions[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0.8, 0}};
    sn_index samples[] = {0, 1, SN_NONE, 1}, root[] = {2}, first[] = {0, 3}, second[] = {1};
    sn_attachment attachments[] = {{.bone = (char *)"ulna", .count = 2, .vertices = first},
                                   {.bone = (char *)"radius", .count = 1, .vertices = second}};
    sn_muscle muscle = {.mesh = mesh, .roots = {.count = 1, .vertices = root}, .structure = {.sample_count = 2, .vertex_sample = samples}};
    muscle.fibers.directions = directions;
    muscle.attachments = attachments;
    muscle.attachment_count = 2;
    assert_int_equal(sn_muscle_paint(&muscle, &painted, NULL), SN_OK);
    assert_int_equal(painted.attribute_count, 6); /* "fiber" and "sample" of the mesh give way */
    expect_number(&painted, "fiber", 3, 10, 0.8);
    expect_number(&painted, "sample", 1, 2, -1.0);
    expect_number(&painted, "attachment", 1, 0, 0.0);
    expect_number(&painted, "attachment", 1, 1, 1.0);
    expect_number(&painted, "attachment", 1, 2, -1.0);
    expect_number(&painted, "root", 1, 2, 1.0);
    expect_number(&painted, "part", 1, 3, 240.0);
    const sn_attribute *attachment = sn_mesh_attribute(&painted, "attachment");
    assert_int_equal(attachment->label_count, 2);
    assert_string_equal(attachment->labels[1], "radius");
    assert_int_equal(sn_mesh_attribute(&painted, "part")->label_count, 2); /* a copy keeps them */
    sn_mesh_free(&painted);
    sn_mesh_free(&mesh);
}

/* ---- VTK itself ----------------------------------------------------------------------------------------------------- */

/* Skips the test where VTK is not installed: call it before anything is allocated. */
static void need_vtk(void) {
    if (system("/usr/bin/python3 -c 'import vtkmodules.vtkIOXML' 2>/dev/null") == 0) return;
    print_message("skipped: python3-vtk9 is not installed, which is a second opinion on our files\n");
    skip();
}

/* Run tests/vtk-check.py; its stdout goes to `words`. */
static void ask_vtk(const char *arguments, char *words, size_t size) {
    char command[1024];
    snprintf(command, sizeof command, "/usr/bin/python3 tests/vtk-check.py %s 2>/dev/null", arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t got = fread(words, 1, size - 1, pipe);
    words[got] = '\0';
    int code = pclose(pipe);
    if (!WIFEXITED(code) || WEXITSTATUS(code) != 0) fail_msg("vtk-check.py %s fails", arguments);
}

static void vtk_reads_what_we_write(void **state) {
    (void)state;
    need_vtk();
    sn_mesh mesh = painted_tetrahedron("a (b)"); /* VTK writes names without escaping them */
    mesh.positions[1].z = 0.125;                 /* VTK's PLY reader has single precision */
    mesh.positions[2].z = 100.0;
    for (int i = 0; i < FORM_COUNT; i++) {
        char path[256], copy[400], words[512];
        snprintf(path, sizeof path, "%s/%s", folder, forms[i].name);
        snprintf(copy, sizeof copy, "copy %s %s/copy.vtp", path, folder);
        write_file(&mesh, path, forms[i].format, forms[i].encoding);
        ask_vtk(copy, words, sizeof words);
        snprintf(path, sizeof path, "%s/copy.vtp", folder);
        sn_mesh back = read_file(path);
        bool exact = forms[i].format == SN_MESH_VTP;
        expect_same(&back, &mesh, exact ? 0.0 : 1e-5, exact, forms[i].name); /* VTK's PLY reader knows no arrays but colours */
        if (exact && strcmp(words, "part_names ulna & <radius> h\303\274fte\n") != 0)
            fail_msg("%s: the labels are %s", forms[i].name, words);
        sn_mesh_free(&back);
    }
    sn_mesh_free(&mesh);
}

/* All forms of one mesh by VTK: compared with its raw appended one, text up to the digits that VTK writes. */
static void we_read_what_vtk_writes(void **state) {
    (void)state;
    need_vtk();
    char arguments[128], path[512], words[64];
    snprintf(arguments, sizeof arguments, "write %s", folder);
    ask_vtk(arguments, words, sizeof words);
    snprintf(path, sizeof path, "%s/appended-plain-little-32-raw.vtp", folder);
    sn_mesh reference = read_file(path);
    static const char *const names[] = {"activation share", "fiber", "part", "number", "wide", "Normals"};
    static const sn_index widths[] = {1, 3, 1, 1, 5, 3};
    for (int k = 0; k < 6; k++) expect_number(&reference, names[k], widths[k], 0, k == 3 ? -500.0 : 0.0);
    expect_number(&reference, "activation share", 1, 5, 5.0 / 7.0);
    expect_number(&reference, "wide", 5, 5 * 9 + 2, 7.0);
    int read = 0, refused = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
        bool legacy = strstr(entry->d_name, ".vtk") != NULL;
        if (!legacy && strstr(entry->d_name, "-32-") == NULL && strstr(entry->d_name, "-64-") == NULL) continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        sn_mesh mesh;
        sn_error error = {0};
        sn_status status = sn_mesh_read(path, &mesh, NULL, &error);
        if (strstr(entry->d_name, "lz4") != NULL && strncmp(entry->d_name, "ascii", 5) != 0) {
            assert_int_equal(status, SN_ERROR_INPUT);
            if (strstr(error.text, "vtkLZ4DataCompressor") == NULL) fail_msg("%s: %s", entry->d_name, error.text);
            refused++;
            continue;
        }
        if (status != SN_OK) fail_msg("%s:%d: %s", error.file, (int)error.line, error.text);
        bool twice = strstr(entry->d_name, "-64-") != NULL; /* each of two pieces is the whole here */
        if (!twice) expect_same(&mesh, &reference, strncmp(entry->d_name, "ascii", 5) == 0 ? 1e-5 : 0.0, true, entry->d_name);
        if (twice) {
            assert_int_equal(mesh.vertex_count, 2 * reference.vertex_count);
            assert_int_equal(mesh.triangle_count, 2 * reference.triangle_count);
            assert_true(fabs(sn_mesh_area(&mesh) - 2.0 * sn_mesh_area(&reference)) < 1e-4);
            expect_number(&mesh, "wide", 5, 5 * (reference.vertex_count + 9) + 2, 7.0);
        }
        read++;
        sn_mesh_free(&mesh);
    }
    closedir(dir);
    sn_mesh_free(&reference);
    assert_int_equal(read, 40);
    assert_int_equal(refused, 12);
}

/* ---- real files ----------------------------------------------------------------------------------------------------- */

static void real_vtp_files_have_their_counts(void **state) {
    (void)state;
    const char *data = getenv("DATA");
    char path[512], line[4096];
    snprintf(path, sizeof path, "%s/gait-opensim/manifest.tsv", data != NULL ? data : "");
    FILE *manifest = data != NULL ? fopen(path, "r") : NULL;
    if (manifest == NULL) {
        print_message("skipped: gait-opensim is not there\n");
        skip();
    }
    int files = 0;
    while (fgets(line, sizeof line, manifest) != NULL) {
        char name[128];
        int triangles;
        if (sscanf(line, "%127[^\t]\t%*s\t%*s\t%d", name, &triangles) != 2) continue;
        snprintf(path, sizeof path, "%s/gait-opensim/meshes/%s", data, name);
        sn_mesh mesh = read_file(path);
        if (mesh.triangle_count != triangles) fail_msg("%s has %d triangles, not %d", name, mesh.triangle_count, triangles);
        sn_mesh_free(&mesh);
        files++;
    }
    fclose(manifest);
    assert_int_equal(files, 33);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(legacy_text_is_read_with_its_point_data),
        cmocka_unit_test(legacy_keywords_may_be_in_any_case),
        cmocka_unit_test(legacy_version_five_has_offsets),
        cmocka_unit_test(legacy_binary_is_big_endian),
        cmocka_unit_test(legacy_errors_name_the_place),
        cmocka_unit_test(xml_pieces_become_one_mesh),
        cmocka_unit_test(xml_data_that_not_all_pieces_have_are_left_out),
        cmocka_unit_test(xml_errors_name_the_place),
        cmocka_unit_test(xml_tricks_are_refused),
        cmocka_unit_test(xml_appended_bytes_are_read_and_checked),
        cmocka_unit_test(xml_bombs_are_refused),
        cmocka_unit_test(what_is_written_is_read_back_exactly),
        cmocka_unit_test(sections_are_painted_on_the_mesh),
        cmocka_unit_test(vtk_reads_what_we_write),
        cmocka_unit_test(we_read_what_vtk_writes),
        cmocka_unit_test(real_vtp_files_have_their_counts),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
