/*
 * test_area.c -- attachment areas from landmarks, paths over a surface, the pair rule, voxels, reasons and confidence, on shapes where the
 * answer is known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "rig_shapes.h"
#include "shapes.h"
#include "sinew/rig.h"

/* A sheet in the plane z = 0: vertex (i, j) at index j (columns + 1) + i. */
static sn_mesh sheet(sn_index columns, sn_index rows) {
    sn_mesh mesh = shape_empty((columns + 1) * (rows + 1), 2 * columns * rows);
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v] = sn_v3(v % (columns + 1), v / (columns + 1), 0);
    for (sn_index q = 0; q < columns * rows; q++) {
        sn_index a = q / columns * (columns + 1) + q % columns, b = a + 1, c = a + columns + 1, d = c + 1;
        mesh.triangles[2 * q] = (sn_triangle){{a, b, d}};
        mesh.triangles[2 * q + 1] = (sn_triangle){{a, d, c}};
    }
    return mesh;
}

enum { MOST = 4 };

typedef struct fixture {
    sn_muscle muscle;
    sn_landmark_area areas[MOST];
    sn_vec3 points[MOST][16];
    sn_attach_params params;
    sn_attachment_list attachments;
    sn_attach_report report;
    sn_error error;
} fixture;

static int set_up(void **state) {
    fixture *f = SN_NEW(fixture, 1);
    f->muscle = (sn_muscle){.meters_per_unit = 0.001, .mesh = sheet(30, 20)};
    f->params = sn_attach_defaults();
    f->params.methods = 0;
    f->params.areas = f->areas;
    *state = f;
    return 0;
}

static void forget(fixture *f) {
    sn_attachments_free(f->attachments.items, f->attachments.count);
    sn_attach_report_free(&f->report);
    f->attachments = (sn_attachment_list){0};
}

static int tear_down(void **state) {
    fixture *f = *state;
    forget(f);
    sn_muscle_free(&f->muscle);
    free(f);
    return 0;
}

static void add_area(fixture *f, char *bone, char *name, sn_index count, const sn_vec3 *points) {
    sn_index a = f->params.area_count++;
    memcpy(f->points[a], points, (size_t)count * sizeof *points);
    f->areas[a] = (sn_landmark_area){bone, name, count, f->points[a]};
}

static sn_status detect(fixture *f, sn_trace *trace) {
    forget(f);
    f->error = (sn_error){0};
    f->params.bone_count = 0;
    return sn_attach_detect(&f->muscle, &f->params, trace, &f->attachments, &f->report, &f->error);
}

static void assert_refused(fixture *f, const char *part) {
    assert_int_equal(detect(f, NULL), SN_ERROR_INPUT);
    if (strstr(f->error.text, part) == NULL) fail_msg("'%s' is not in '%s'", part, f->error.text);
    assert_null(f->attachments.items);
}

/* Exactly the vertices with x in (x0, x1) and y in (y0, y1). */
static void assert_rectangle(const fixture *f, const sn_attachment *a, double x0, double x1, double y0, double y1) {
    sn_index next = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        sn_vec3 p = f->muscle.mesh.positions[v];
        bool held = next < a->count && a->vertices[next] == v;
        next += held;
        assert_int_equal(held, p.x > x0 && p.x < x1 && p.y > y0 && p.y < y1);
    }
}

static const sn_vec3 rectangle[4] = {{4.5, 3.5, 0.2}, {12.5, 3.5, -0.1}, {12.5, 9.5, 0.3}, {4.5, 9.5, 0}};

/* ---- areas ------------------------------------------------------------------------------------------------------------------------ */

static void landmarks_enclose_their_patch(void **state) {
    fixture *f = *state;
    add_area(f, "ulna", "insertion", 4, rectangle);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 1);
    assert_string_equal(f->attachments.items[0].bone, "ulna");
    assert_string_equal(f->attachments.items[0].method, "area");
    assert_rectangle(f, &f->attachments.items[0], 4.5, 12.5, 3.5, 9.5);
    assert_null(f->attachments.items[0].distances); /* the bone has no mesh */
    assert_true(f->attachments.items[0].confidence[0] == 1.0);
    assert_int_equal(f->attachments.items[0].reasons[0], SN_REASON_AREA);
    assert_int_equal(f->report.area_count, 1);
    assert_false(f->report.areas[0].reordered);
    assert_true(fabs(f->report.areas[0].boundary - 28.0) < 0.5); /* 2 (8 + 6), a little longer over the points on edges */
    assert_true(f->report.areas[0].boundary >= 27.5);
    assert_true(f->report.areas[0].farthest == 0.3);
}

static void the_sense_of_the_boundary_does_not_matter(void **state) {
    fixture *f = *state;
    const sn_vec3 back[4] = {rectangle[3], rectangle[2], rectangle[1], rectangle[0]};
    add_area(f, "ulna", NULL, 4, back);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_rectangle(f, &f->attachments.items[0], 4.5, 12.5, 3.5, 9.5);
}

static void a_crossing_boundary_is_put_in_order(void **state) {
    fixture *f = *state;
    const sn_vec3 bow_tie[4] = {rectangle[0], rectangle[2], rectangle[1], rectangle[3]};
    add_area(f, "ulna", NULL, 4, bow_tie);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].reordered);
    assert_rectangle(f, &f->attachments.items[0], 4.5, 12.5, 3.5, 9.5);
}

static void a_bone_may_have_two_areas_and_the_first_area_wins(void **state) {
    fixture *f = *state;
    const sn_vec3 second[4] = {{20.5, 10.5, 0}, {25.5, 10.5, 0}, {25.5, 15.5, 0}, {20.5, 15.5, 0}};
    const sn_vec3 third[4] = {{10.5, 3.5, 0}, {15.5, 3.5, 0}, {15.5, 9.5, 0}, {10.5, 9.5, 0}};
    add_area(f, "ulna", "a", 4, rectangle);
    add_area(f, "ulna", "b", 4, second);
    add_area(f, "radius", "c", 4, third);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 2);
    assert_int_equal(f->attachments.items[0].count, 8 * 6 + 5 * 5);
    assert_rectangle(f, &f->attachments.items[1], 12.5, 15.5, 3.5, 9.5); /* what "a" left of it */
}

/* On a sphere the smaller side of a parallel is the cap. */
static void the_patch_is_the_smaller_side(void **state) {
    fixture *f = *state;
    sn_mesh_free(&f->muscle.mesh);
    f->muscle.mesh = shape_sphere(30, 60);
    sn_vec3 ring[12];
    for (int i = 0; i < 12; i++) ring[i] = sn_v3(0.8 * cos(i * SN_PI / 6), 0.8 * sin(i * SN_PI / 6), -0.6);
    add_area(f, "ulna", NULL, 12, ring);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(fabs(f->report.areas[0].area_share - 0.2) < 0.03); /* (1 - 0.6) / 2 */
    for (sn_index i = 0; i < f->attachments.items[0].count; i++)
        assert_true(f->muscle.mesh.positions[f->attachments.items[0].vertices[i]].z < -0.55);
}

static void a_patch_without_vertices_takes_the_nearest(void **state) {
    fixture *f = *state;
    const sn_vec3 tiny[3] = {{5.1, 5.1, 0}, {5.3, 5.1, 0}, {5.2, 5.05, 0}};
    add_area(f, "ulna", NULL, 3, tiny);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].coarse);
    assert_int_equal(f->attachments.items[0].count, 1);
    assert_int_equal(f->attachments.items[0].vertices[0], 5 * 31 + 5);
}

/* ---- lines ---------------------------------------------------------------------------------------------------------------------- */

/* The same 30 x 20 mm of sheet, its vertices so far apart. */
static void set_spacing(fixture *f, double spacing) {
    sn_mesh_free(&f->muscle.mesh);
    f->muscle.mesh = sheet((sn_index)(30 / spacing), (sn_index)(20 / spacing));
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) f->muscle.mesh.positions[v] = sn_scale(f->muscle.mesh.positions[v], spacing);
}

typedef sn_vec3 curve(double t);
static sn_vec3 across(double t) { return sn_v3(4.3 + 21.1 * t, 12.2 - 6.3 * t, 0); }
static sn_vec3 along_edge(double t) { return sn_v3(3.1 + 24.2 * t, 0.1, 0); }
static sn_vec3 bent(double t) { return sn_v3(15 + 9.1 * cos(SN_PI * (0.1 + 0.7 * t)), 6 + 9.1 * sin(SN_PI * (0.1 + 0.7 * t)), 0); }

static sn_vec3 half_round(double t) { return sn_v3(15 + 9.1 * cos(SN_PI * (0.05 + 0.9 * t)), 6 + 9.1 * sin(SN_PI * (0.05 + 0.9 * t)), 0); }

static double distance_to_curve(curve *line, sn_vec3 p) {
    double least = INFINITY;
    for (int i = 0; i <= 400; i++) least = fmin(least, sn_distance(line(i / 400.0), p));
    return least;
}

/* The band holds what lies within half its width, and nothing farther than that and the triangles that the line runs through. */
static void assert_band(const fixture *f, curve *line, double width, double slack) {
    const sn_attachment *a = &f->attachments.items[0];
    double edge = sn_distance(f->muscle.mesh.positions[0], f->muscle.mesh.positions[1]);
    sn_index next = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        double distance = distance_to_curve(line, f->muscle.mesh.positions[v]);
        bool held = next < a->count && a->vertices[next] == v;
        next += held;
        if (distance < 0.5 * width - slack) assert_true(held);
        if (distance > fmax(0.5 * width, sqrt(2) * edge) + slack) assert_false(held);
    }
}

static char femur[] = "femur";

static void set_line(fixture *f, curve *line, sn_index count, double noise, double height) {
    static sn_vec3 points[64];
    static char name[] = "line";
    uint64_t random = 11;
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 off = sn_v3(noise * (2 * sn_random(&random) - 1), noise * (2 * sn_random(&random) - 1), height);
        points[i] = sn_add(line(count > 1 ? (double)i / (count - 1) : 0.5), off);
    }
    f->params.area_count = 1;
    f->areas[0] = (sn_landmark_area){femur, name, count, points};
}

static void landmarks_in_a_row_are_a_band(void **state) {
    fixture *f = *state;
    static curve *const curves[3] = {across, along_edge, bent};
    static const double spacings[3] = {2, 1, 0.5}, lengths[3] = {22.0, 24.2, 20.0};
    for (int s = 0; s < 3; s++)
        for (int c = 0; c < 3; c++)
            for (sn_index count = c == 2 ? 9 : 2; count <= 16; count += count < 3 ? 1 : 13) {
                set_spacing(f, spacings[s]);
                set_line(f, curves[c], count, 0, 1.5);
                f->params.line_width = -1;
                assert_int_equal(detect(f, NULL), SN_OK);
                assert_true(f->report.areas[0].line && !f->report.areas[0].reordered);
                assert_true(fabs(f->report.areas[0].width - 1.5) < 1e-9); /* the mean distance of the landmarks */
                assert_true(fabs(f->report.areas[0].boundary - lengths[c]) < 0.04 * lengths[c]);
                assert_band(f, curves[c], 1.5, 0.3);
                f->params.line_width = 4;
                assert_int_equal(detect(f, NULL), SN_OK);
                assert_band(f, curves[c], 4, 0.3);
                assert_false(f->report.areas[0].coarse);
            }
}

static void noisy_lines_are_lines(void **state) {
    fixture *f = *state;
    static const sn_index counts[4] = {5, 11, 24, 40};
    f->params.line_width = 3;
    for (int c = 0; c < 2; c++)
        for (int n = 0; n < 4; n++) {
            set_line(f, c ? bent : across, counts[n], 0.5, 0);
            if (c && n == 0) continue; /* five landmarks around more than a third of a circle close as well as they do not */
            assert_int_equal(detect(f, NULL), SN_OK);
            assert_true(f->report.areas[0].line);
            assert_band(f, c ? bent : across, 3, 0.9);
        }
}

/* Boundaries of every size and number of landmarks, thin ones from each of their corners, are not taken for lines. */
static void closed_boundaries_are_no_lines(void **state) {
    fixture *f = *state;
    static sn_vec3 ring[16];
    for (double radius = 0.2; radius < 9.9; radius *= 1.5)
        for (int count = 3; count <= 16; count++) {
            for (int i = 0; i < count; i++)
                ring[i] = sn_v3(15.2 + radius * cos(2 * SN_PI * i / count), 10.1 + 0.5 * radius * sin(2 * SN_PI * i / count), 0);
            f->params.area_count = 1;
            f->areas[0] = (sn_landmark_area){femur, NULL, count, ring};
            assert_int_equal(detect(f, NULL), SN_OK);
            assert_false(f->report.areas[0].line || f->report.areas[0].doubtful);
        }
    for (int start = 0; start < 4; start++) {
        static const sn_vec3 thin[4] = {{4.5, 8.5, 0}, {24.5, 8.5, 0}, {24.5, 9.5, 0}, {4.5, 9.5, 0}};
        for (int i = 0; i < 4; i++) ring[i] = thin[(i + start) % 4];
        f->areas[0].count = 4;
        assert_int_equal(detect(f, NULL), SN_OK);
        assert_false(f->report.areas[0].line);
        assert_rectangle(f, &f->attachments.items[0], 4.5, 24.5, 8.5, 9.5);
    }
}

static void three_landmarks_are_a_line_only_in_a_row(void **state) {
    fixture *f = *state;
    static sn_vec3 points[3] = {{4.5, 8.5, 0}, {20.5, 8.5, 0}, {12.5, 9.3, 0}}; /* the last between the others */
    f->params.area_count = 1;
    f->areas[0] = (sn_landmark_area){femur, NULL, 3, points};
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].line);
    points[2].y = 14.5;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_false(f->report.areas[0].line);
    f->params.area_kind = SN_AREA_LINE; /* said so */
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].line);
}

/* Out of order in a straight row: put into order, and told; the same band. */
static void a_straight_row_is_put_in_order(void **state) {
    fixture *f = *state;
    static sn_vec3 points[7];
    static const int order[7] = {3, 0, 6, 1, 5, 2, 4};
    for (int i = 0; i < 7; i++) points[i] = across(order[i] / 6.0);
    f->params.area_count = 1;
    f->params.line_width = 3;
    f->areas[0] = (sn_landmark_area){femur, NULL, 7, points};
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].line && f->report.areas[0].reordered);
    assert_band(f, across, 3, 0.3);
    assert_true(fabs(f->report.areas[0].boundary - 22.0) < 1.0);
}

/* A boundary that is left open on one side, and a line that bends back, are told of. */
static void doubtful_kinds_are_told_of(void **state) {
    fixture *f = *state;
    set_line(f, half_round, 16, 0, 0);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].line && f->report.areas[0].doubtful);
    set_line(f, half_round, 5, 0, 0);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(!f->report.areas[0].line && f->report.areas[0].doubtful);
    set_line(f, across, 9, 0, 0);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_false(f->report.areas[0].doubtful);
}

static void a_band_on_a_coarse_mesh_says_so(void **state) {
    fixture *f = *state;
    set_spacing(f, 2);
    set_line(f, across, 5, 0, 0);
    f->params.line_width = 0.3;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].coarse && f->report.areas[0].mean_width > 0.6);
}

static void an_area_far_off_is_left_out_and_the_rest_is_done(void **state) {
    fixture *f = *state;
    sn_vec3 off[4];
    for (int i = 0; i < 4; i++) off[i] = sn_add(rectangle[i], sn_v3(0, 0, i == 2 ? 40 : 0));
    add_area(f, "femur", "far", 4, off);
    add_area(f, "ulna", "near", 4, rectangle);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].left_out && f->report.areas[0].far == 2 && fabs(f->report.areas[0].farthest - 40.3) < 1e-9);
    assert_int_equal(f->report.areas[0].vertices, 0);
    assert_false(f->report.areas[1].left_out);
    assert_int_equal(f->attachments.count, 1);
    assert_string_equal(f->attachments.items[0].bone, "ulna");
    assert_rectangle(f, &f->attachments.items[0], 4.5, 12.5, 3.5, 9.5);
    f->params.area_count = 1; /* nothing is left to do */
    assert_refused(f, "area \"far\" on bone \"femur\": landmark 3 lies 40.3 mm off the muscle, and the limit is 10 mm");
}

/* ---- ends --------------------------------------------------------------------------------------------------------------------- */

static void a_name_tells_the_end_by_one_of_its_words(void **state) {
    (void)state;
    static const char *const origins[] = {"origin", "Origin 1", "origins", "deep ORIGIN", "deepOrigin", "2_origin_b", "origin/deep"};
    static const char *const insertions[] = {"insertion", "insertion_2", "deep insertion", "Insertions", "superficialInsertion3"};
    static const char *const doubtful[] = {"orgin",     "original",      "inserton", "origin to insertion",
                                           "no origin", "non-insertion", "orig.",    "insert"};
    static const char *const others[] = {"", "area", "head", "linea aspera", "margin", "ridge"};
    bool in_doubt;
    for (size_t i = 0; i < sizeof origins / sizeof *origins; i++)
        if (sn_area_end(origins[i], &in_doubt) != SN_END_ORIGIN || in_doubt) fail_msg("%s", origins[i]);
    for (size_t i = 0; i < sizeof insertions / sizeof *insertions; i++)
        if (sn_area_end(insertions[i], &in_doubt) != SN_END_INSERTION || in_doubt) fail_msg("%s", insertions[i]);
    for (size_t i = 0; i < sizeof doubtful / sizeof *doubtful; i++)
        if (sn_area_end(doubtful[i], &in_doubt) != SN_END_UNKNOWN || !in_doubt) fail_msg("%s", doubtful[i]);
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (sn_area_end(others[i], &in_doubt) != SN_END_UNKNOWN || in_doubt) fail_msg("%s", others[i]);
    assert_true(sn_area_end(NULL, &in_doubt) == SN_END_UNKNOWN && !in_doubt);
}

/* Both ends on one bone: an attachment for each, and one for an area that is at neither. */
static void one_bone_may_hold_both_ends(void **state) {
    fixture *f = *state;
    sn_vec3 far[4], third[4];
    for (int i = 0; i < 4; i++) far[i] = sn_add(rectangle[i], sn_v3(12, 0, 0)), third[i] = sn_add(rectangle[i], sn_v3(0, 8, 0));
    add_area(f, "skull", "insertion", 4, rectangle);
    add_area(f, "skull", "the origin", 4, far);
    add_area(f, "skull", "ridge", 4, third);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 3);
    for (int k = 0; k < 3; k++) assert_string_equal(f->attachments.items[k].bone, "skull");
    assert_int_equal(f->attachments.items[0].end, SN_END_UNKNOWN);
    assert_int_equal(f->attachments.items[1].end, SN_END_ORIGIN);
    assert_int_equal(f->attachments.items[2].end, SN_END_INSERTION);
    assert_rectangle(f, &f->attachments.items[0], 4.5, 12.5, 11.5, 17.5);
    assert_rectangle(f, &f->attachments.items[1], 16.5, 24.5, 3.5, 9.5);
    assert_rectangle(f, &f->attachments.items[2], 4.5, 12.5, 3.5, 9.5);
    assert_true(f->report.areas[0].end == SN_END_INSERTION && f->report.areas[1].end == SN_END_ORIGIN);
    f->muscle.attachment_count = f->attachments.count; /* the document takes both */
    f->muscle.attachments = f->attachments.items;
    assert_int_equal(sn_muscle_validate(&f->muscle, &f->error), SN_OK);
    f->muscle.attachment_count = 0;
    f->muscle.attachments = NULL;
}

/* What a later area loses to one before it, or to pins, is counted; areas of one bone at one end share what is common. */
static void what_overlaps_is_told(void **state) {
    fixture *f = *state;
    sn_vec3 moved[4];
    for (int i = 0; i < 4; i++) moved[i] = sn_add(rectangle[i], sn_v3(4, 0, 0));
    add_area(f, "ulna", "insertion", 4, rectangle);
    add_area(f, "radius", "insertion", 4, moved);
    assert_int_equal(detect(f, NULL), SN_OK);
    const sn_attach_area *a = f->report.areas;
    assert_true(a[0].lost.vertices == 0 && a[0].lost_to == SN_NONE);
    assert_true(a[1].vertices == 48 && a[1].lost.vertices == 24 && a[1].lost_to == 0); /* 8 x 6 vertices, half of them common */
    assert_true(fabs(a[1].lost.area - 24.0) < 1e-9);
    assert_int_equal(f->attachments.items[1].count, 24);
    f->areas[1].bone = f->areas[0].bone;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[1].lost.vertices == 0 && f->attachments.count == 1 && f->attachments.items[0].count == 72);
    f->areas[1].name = "origin";
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[1].lost.vertices == 24 && f->attachments.count == 2);
    f->params.area_count = 1;
    sn_attach_pin pin = {.bone = "scapula", .selector = {.kind = SN_SELECT_BOX, .point = {4.5, 3.5, -1}, .other = {6.5, 9.5, 1}}};
    f->params.pin_count = 1;
    f->params.pins = &pin;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_true(f->report.areas[0].lost.vertices == 12 && f->report.areas[0].lost_to == SN_NONE);
}

/* ---- impossible areas -------------------------------------------------------------------------------------------------------------- */

static void impossible_areas_are_refused_by_name(void **state) {
    fixture *f = *state;
    add_area(f, "ulna", "insertion", 1, rectangle);
    assert_refused(f, "area \"insertion\" on bone \"ulna\" has 1 landmark; a boundary needs at least 3, a line 2");
    f->areas[0].count = 2;
    f->params.area_kind = SN_AREA_BOUNDARY;
    assert_refused(f, "area \"insertion\" on bone \"ulna\" has 2 landmarks; a boundary needs at least 3");
    f->areas[0].count = 4;
    f->points[0][0] = rectangle[0], f->points[0][1] = rectangle[1], f->points[0][2] = rectangle[2], f->points[0][3] = rectangle[3];
    f->points[0][2].z = 10.5;
    assert_refused(f, "landmark 3 lies 10.5 mm off the muscle, and the limit is 10 mm");
    f->params.landmark_reach = 11;
    assert_int_equal(detect(f, NULL), SN_OK);
    f->points[0][2].z = NAN;
    assert_refused(f, "landmark 3 is not finite");
}

static void a_boundary_over_two_components_does_not_close(void **state) {
    fixture *f = *state;
    f->muscle.mesh = joined(f->muscle.mesh, sheet(5, 5)); /* the second 1000 away */
    const sn_vec3 split[3] = {{2.5, 2.5, 0}, {1002.5, 2.5, 0}, {5.5, 7.5, 0}};
    add_area(f, "ulna", NULL, 3, split);
    f->params.area_kind = SN_AREA_BOUNDARY;
    assert_refused(f, "the area on bone \"ulna\": its boundary does not close: landmarks 1 and 2");
    f->params.area_kind = SN_AREA_AUTO; /* in a row */
    assert_refused(f, "the area on bone \"ulna\": its line breaks: landmarks 3 and 2");
}

static void a_boundary_around_a_handle_is_refused(void **state) {
    fixture *f = *state;
    sn_mesh_free(&f->muscle.mesh);
    f->muscle.mesh = blocks(hoop);
    sn_box box = sn_mesh_box(&f->muscle.mesh);
    sn_vec3 middle = sn_lerp(box.low, box.high, 0.5);
    double thick = box.high.y - box.low.y, wide = box.high.x - box.low.x;
    sn_vec3 at = sn_v3(box.low.x + 0.125 * wide, middle.y, middle.z); /* the middle of one side of the hoop: a ring around it */
    const sn_vec3 ring[4] = {sn_add(at, sn_v3(0, -0.5 * thick, 0)), sn_add(at, sn_v3(0.125 * wide, 0, 0)),
                             sn_add(at, sn_v3(0, 0.5 * thick, 0)), sn_add(at, sn_v3(-0.125 * wide, 0, 0))};
    add_area(f, "ulna", NULL, 4, ring);
    f->params.landmark_reach = thick;
    assert_refused(f, "runs around a handle");
}

static void a_bone_that_is_not_there_is_refused(void **state) {
    fixture *f = *state;
    sn_mesh cube = shape_cube();
    const sn_attach_bone bone = {"radius", &cube, false};
    add_area(f, "ulna", NULL, 4, rectangle);
    f->params.bone_count = 1;
    f->params.bones = &bone;
    assert_int_equal(sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "the landmarks name bone \"ulna\", which is not among the bones given"));
    sn_mesh_free(&cube);
}

/* ---- steps ------------------------------------------------------------------------------------------------------------------------ */

/* 4 landmarks, 4 paths, the patch; every partial result is one attachment that grows along the boundary. */
static void every_step_of_an_area_can_be_stopped_at(void **state) {
    fixture *f = *state;
    sn_index before = 0;
    add_area(f, "ulna", NULL, 4, rectangle);
    for (int n = 0; n < 9; n++) {
        sn_trace trace = {.stop_after = n};
        assert_int_equal(detect(f, &trace), SN_STOPPED);
        assert_int_equal(f->attachments.count, n > 0);
        sn_index held = n > 0 ? f->attachments.items[0].count : 0;
        assert_true(n == 4 || n == 5 ? held >= before : held > before || n == 0 || n == 8);
        before = held;
    }
    sn_trace trace = {.stop_after = 10};
    assert_int_equal(detect(f, &trace), SN_OK);
    assert_int_equal(trace.steps, 9);
}

/* ---- the bones of a list ------------------------------------------------------------------------------------------------------------ */

static void set_box(sn_mesh *mesh, sn_vec3 low, sn_vec3 high) {
    *mesh = shape_cube();
    for (int i = 0; i < 8; i++) {
        sn_vec3 p = mesh->positions[i];
        mesh->positions[i] = sn_v3(p.x > 0 ? high.x : low.x, p.y > 0 ? high.y : low.y, p.z > 0 ? high.z : low.z);
    }
}

static sn_status detect_listed(fixture *f, const char *name, const sn_mesh *mesh) {
    const sn_attach_bone bone = {name, mesh, true};
    forget(f);
    f->params.bone_count = 1;
    f->params.bones = &bone;
    return sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error);
}

/* The sheet is 30 x 20 mm: 0.8 % of it are 4.8 square mm. */
static void a_listed_bone_needs_its_share_of_the_area(void **state) {
    fixture *f = *state;
    sn_mesh bone;
    f->params.methods = SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY;
    f->params.distance = 1.2;
    set_box(&bone, sn_v3(-8, 8.4, 1), sn_v3(-1.5, 8.6, 2)); /* 1.8 mm off the border: some 0.7 square mm within 2 mm */
    assert_int_equal(detect_listed(f, "small", &bone), SN_OK);
    assert_int_equal(f->attachments.count, 0);
    assert_false(f->report.pairs[0].nearby);
    assert_true(f->report.pairs[0].area_share < 0.008);
    sn_mesh_free(&bone);
    set_box(&bone, sn_v3(10, 8, 1), sn_v3(13, 11, 2)); /* 1 mm above: (3 + 2 sqrt 3)^2 less the corners, of 600 square mm */
    assert_int_equal(detect_listed(f, "large", &bone), SN_OK);
    assert_true(f->report.pairs[0].nearby && !f->report.pairs[0].penetrates);
    double share = (9 + 4 * 3 * sqrt(3) + 3 * SN_PI) / 600;
    assert_true(fabs(f->report.pairs[0].area_share - share) < 0.02 * share);
    assert_int_equal(f->attachments.items[0].count, 16);
    sn_mesh_free(&bone);
}

/* A bone through the middle of one triangle: no vertex is in it, none near; the pair is found, and the nearest vertices hold it. */
static void a_bone_between_the_vertices_is_found(void **state) {
    fixture *f = *state;
    sn_mesh bone;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) f->muscle.mesh.positions[v] = sn_scale(f->muscle.mesh.positions[v], 10);
    f->params.methods = SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY;
    set_box(&bone, sn_v3(55, 51, -20), sn_v3(57, 53, 20));
    assert_int_equal(detect_listed(f, "needle", &bone), SN_OK);
    assert_true(f->report.pairs[0].nearby && f->report.pairs[0].penetrates && f->report.pairs[0].nearest > 2.0);
    assert_int_equal(f->attachments.count, 1);
    assert_int_equal(f->attachments.items[0].count, 1);
    assert_int_equal(f->attachments.items[0].vertices[0], 5 * 31 + 6); /* (60, 50) */
    assert_int_equal(f->attachments.items[0].reasons[0], SN_REASON_NEAREST);
    assert_string_equal(f->attachments.items[0].method, "nearest");
    sn_mesh_free(&bone);
}

/* ---- voxels ---------------------------------------------------------------------------------------------------------------------- */

/* A box of 8 x 8 x 8 mm in 4^3 cells: the boundary cells are those of the outer layer. Open at the top it has no inside by itself, but the
 * cells are the same. Vertices of the sheet through its middle: the outer layer of cells, 2 mm wide. */
static void voxels_hold_the_cells_of_the_surface(void **state) {
    fixture *f = *state;
    sn_mesh bone;
    set_box(&bone, sn_v3(9.5, 5.5, -4), sn_v3(17.5, 13.5, 4));
    const sn_attach_bone given = {"box", &bone, false};
    f->params.methods = SN_ATTACH_CONTACT;
    f->params.voxels = 64;
    f->params.bone_count = 1;
    f->params.bones = &given;
    assert_int_equal(sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error), SN_OK);
    assert_int_equal(f->attachments.items[0].count, 64); /* all are inside anyway: a vertex in a boundary cell and inside is in contact */
    assert_int_equal(f->attachments.items[0].reasons[0], SN_REASON_CONTACT);
    forget(f);
    for (int i = 0; i < 4; i++) shape_drop(&bone, 0); /* bottom and top: a tube along z, whose inside is uncertain at its ends only */
    sn_vec3 lift = sn_v3(0, 0, 3.5); /* the sheet near the open end: the winding number is below a half there, the walls' cells are not */
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) f->muscle.mesh.positions[v] = sn_add(f->muscle.mesh.positions[v], lift);
    f->params.bone_count = 1;
    f->params.bones = &given;
    assert_int_equal(sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error), SN_OK);
    for (sn_index i = 0; i < f->attachments.items[0].count; i++) {
        sn_vec3 p = f->muscle.mesh.positions[f->attachments.items[0].vertices[i]];
        bool wall = p.x < 11.5 || p.x > 15.5 || p.y < 7.5 || p.y > 11.5;
        if (f->attachments.items[0].reasons[i] == SN_REASON_VOXEL) assert_true(wall);
    }
    sn_index walls = 0;
    for (sn_index i = 0; i < f->attachments.items[0].count; i++) {
        sn_vec3 p = f->muscle.mesh.positions[f->attachments.items[0].vertices[i]];
        walls += p.x < 11.5 || p.x > 15.5 || p.y < 7.5 || p.y > 11.5;
    }
    assert_int_equal(walls, 64 - 16);
    sn_mesh_free(&bone);
}

/* ---- confidence ------------------------------------------------------------------------------------------------------------------- */

/* 0.5 on the surface to 1 at 2 mm inside; down to 0 at the reach outside; between two bones as near, half. */
static void confidence_follows_depth_and_margin(void **state) {
    fixture *f = *state;
    sn_mesh left, right;
    set_box(&left, sn_v3(-5, -5, -5), sn_v3(10, 30, 5));
    set_box(&right, sn_v3(14, -5, -5), sn_v3(40, 30, 5));
    const sn_attach_bone bones[2] = {{"left", &left, false}, {"right", &right, false}};
    f->params.methods = SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY;
    f->params.distance = 4;
    f->params.bone_count = 2;
    f->params.bones = bones;
    assert_int_equal(sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error), SN_OK);
    static const double expected[13] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 0.75, 0.5, 0.375, 0.125};
    for (sn_index i = 0; i < f->attachments.items[0].count; i++) {
        int x = (int)f->muscle.mesh.positions[f->attachments.items[0].vertices[i]].x;
        assert_true(x <= 12 && fabs(f->attachments.items[0].confidence[i] - expected[x]) < 1e-12);
    }
    sn_mesh_free(&left);
    sn_mesh_free(&right);
}

/* ---- paths --------------------------------------------------------------------------------------------------------------------------- */

/* On a plane the shortest path is straight: the one found is at most 1 % longer, and its segments join. */
static void paths_are_nearly_straight(void **state) {
    fixture *f = *state;
    sn_topology topology;
    sn_surface *surface;
    sn_path_finder *finder;
    sn_surface_path path;
    uint64_t random = 3;
    assert_int_equal(sn_topology_build(&f->muscle.mesh, &topology, NULL), SN_OK);
    assert_int_equal(sn_surface_create_plain(&f->muscle.mesh, &surface, NULL), SN_OK);
    assert_int_equal(sn_path_finder_create(&f->muscle.mesh, &topology, &finder, NULL), SN_OK);
    for (int i = 0; i < 40; i++) {
        sn_closest ends[2];
        for (int k = 0; k < 2; k++)
            ends[k] = sn_surface_closest(surface, sn_v3(30 * sn_random(&random), 20 * sn_random(&random), 0), INFINITY);
        assert_int_equal(sn_path_find(finder, &ends[0], &ends[1], i, &path, NULL), SN_OK);
        double straight = sn_distance(ends[0].point, ends[1].point), sum = 0.0;
        for (sn_index s = 0; s < path.count; s++) {
            sum += sn_distance(path.segments[s].from, path.segments[s].to);
            if (s > 0) assert_true(sn_distance(path.segments[s - 1].to, path.segments[s].from) == 0.0);
            assert_int_equal(path.segments[s].edge == SN_NONE, s == path.count - 1);
        }
        assert_true(fabs(sum - path.length) < 1e-9 && path.length >= straight - 1e-9);
        assert_true(path.length <= 1.01 * straight + 0.01);
        sn_surface_path_free(&path);
    }
    sn_path_finder_destroy(finder);
    sn_surface_destroy(surface);
    sn_topology_free(&topology);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(landmarks_enclose_their_patch),
        TEST(a_name_tells_the_end_by_one_of_its_words),
        TEST(one_bone_may_hold_both_ends),
        TEST(what_overlaps_is_told),
        TEST(the_sense_of_the_boundary_does_not_matter),
        TEST(a_crossing_boundary_is_put_in_order),
        TEST(a_bone_may_have_two_areas_and_the_first_area_wins),
        TEST(the_patch_is_the_smaller_side),
        TEST(a_patch_without_vertices_takes_the_nearest),
        TEST(landmarks_in_a_row_are_a_band),
        TEST(noisy_lines_are_lines),
        TEST(closed_boundaries_are_no_lines),
        TEST(three_landmarks_are_a_line_only_in_a_row),
        TEST(a_straight_row_is_put_in_order),
        TEST(doubtful_kinds_are_told_of),
        TEST(a_band_on_a_coarse_mesh_says_so),
        TEST(an_area_far_off_is_left_out_and_the_rest_is_done),
        TEST(impossible_areas_are_refused_by_name),
        TEST(a_boundary_over_two_components_does_not_close),
        TEST(a_boundary_around_a_handle_is_refused),
        TEST(a_bone_that_is_not_there_is_refused),
        TEST(every_step_of_an_area_can_be_stopped_at),
        TEST(a_listed_bone_needs_its_share_of_the_area),
        TEST(a_bone_between_the_vertices_is_found),
        TEST(voxels_hold_the_cells_of_the_surface),
        TEST(confidence_follows_depth_and_margin),
        TEST(paths_are_nearly_straight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
