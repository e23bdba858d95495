/* test_fiber_fill.c -- fibres through generated muscles of known angles and lengths; ends, splits, slices, seeds. */
#include "shapes.h"

#include "rig_shapes.h"

#include "sinew/embedding.h"
#include "sinew/numeric.h"
#include "sinew/rig.h"

enum { WIDE = 24, DEEP = 12, LONG = 80 };
static const double WIDTH = 24.0, DEPTH = 12.0, LENGTH = 160.0;

static sn_index bar_vertex(sn_index ring, sn_index k) { return ring * 2 * (WIDE + DEEP) + (k + 2 * (WIDE + DEEP)) % (2 * (WIDE + DEEP)); }

/* A bar along z, WIDTH (x) by DEPTH (y) by LENGTH, its mesh fine around and closed by a fan at each end; the fans' middles come last. */
static sn_mesh bar(void) {
    const sn_index around = 2 * (WIDE + DEEP), rings = LONG + 1;
    sn_mesh m = shape_empty(around * rings + 2, 2 * around * LONG + 2 * around);
    sn_index t = 0, low = around * rings, high = low + 1;
    for (sn_index r = 0; r < rings; r++)
        for (sn_index k = 0; k < around; k++) {
            sn_index a = k, x = a < WIDE ? a : a < WIDE + DEEP ? WIDE : a < 2 * WIDE + DEEP ? 2 * WIDE + DEEP - a : 0;
            sn_index y = a < WIDE ? 0 : a < WIDE + DEEP ? a - WIDE : a < 2 * WIDE + DEEP ? DEEP : around - a;
            m.positions[bar_vertex(r, k)] = sn_v3(WIDTH * x / WIDE, DEPTH * y / DEEP, LENGTH * r / LONG);
        }
    m.positions[low] = sn_v3(0.5 * WIDTH, 0.5 * DEPTH, 0.0);
    m.positions[high] = sn_v3(0.5 * WIDTH, 0.5 * DEPTH, LENGTH);
    for (sn_index k = 0; k < around; k++) {
        for (sn_index r = 0; r < LONG; r++) {
            m.triangles[t++] = (sn_triangle){{bar_vertex(r, k), bar_vertex(r, k + 1), bar_vertex(r + 1, k + 1)}};
            m.triangles[t++] = (sn_triangle){{bar_vertex(r, k), bar_vertex(r + 1, k + 1), bar_vertex(r + 1, k)}};
        }
        m.triangles[t++] = (sn_triangle){{low, bar_vertex(0, k + 1), bar_vertex(0, k)}};
        m.triangles[t++] = (sn_triangle){{high, bar_vertex(LONG, k), bar_vertex(LONG, k + 1)}};
    }
    return m;
}

/* Params for the bar: its two faces are the ends. *lists is to be freed. */
static sn_fill_params bar_params(sn_index **lists) {
    const sn_index around = 2 * (WIDE + DEEP);
    *lists = SN_NEW(sn_index, 2 * around + 2);
    for (sn_index k = 0; k < around; k++) {
        (*lists)[k] = bar_vertex(0, k);
        (*lists)[around + 1 + k] = bar_vertex(LONG, k);
    }
    (*lists)[around] = around * (LONG + 1);
    (*lists)[2 * around + 1] = around * (LONG + 1) + 1;
    sn_fill_params p = sn_fill_defaults();
    p.origin = *lists;
    p.insertion = *lists + around + 1;
    p.origin_count = p.insertion_count = around + 1;
    return p;
}

static sn_fibers filled(const sn_mesh *mesh, const sn_fill_params *params, sn_fill_report *report) {
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = *mesh};
    sn_fibers fibers;
    sn_error error = {0};
    sn_status status = sn_fill_fibers(&muscle, params, NULL, &fibers, report, &error);
    if (status != SN_OK) fail_msg("fibres: %s", error.text);
    assert_int_equal(report->outside_after, 0);
    return fibers;
}

/* Degrees between the chord of a fibre and the z axis. */
static double chord_angle(const sn_polyline *line) {
    sn_vec3 d = sn_sub(line->points[line->count - 1], line->points[0]);
    return atan2(hypot(d.x, d.y), fabs(d.z)) * 180.0 / SN_PI;
}

static void test_parallel_fibres_are_straight(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists);
    sn_fill_report report;
    sn_fibers fibers = filled(&mesh, &params, &report);
    assert_int_equal(fibers.polyline_count, 100);
    assert_int_equal(report.outside_before, 0);
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        assert_int_equal(line->count, 16);
        assert_true(chord_angle(line) < 0.2);
        assert_true(line->pennation * 180.0 / SN_PI < 1.0);
        /* from the first level to the last: 0.4 % of the length is left at each end */
        assert_near(line->length, 0.992 * LENGTH, 1e-3 * LENGTH);
        for (sn_index k = 1; k < line->count; k++)
            assert_near(sn_distance(line->points[k - 1], line->points[k]), line->length / 15.0, 1e-3 * line->length);
    }
    assert_near(report.area, WIDTH * DEPTH, 0.02 * WIDTH * DEPTH);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Seeds are even over the section: each quarter of it has a quarter of the fibres. */
static void test_fibres_are_even_over_the_section(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists, quarter[4] = {0};
    sn_fill_params params = bar_params(&lists);
    sn_fill_report report;
    params.fibers = 400;
    sn_fibers fibers = filled(&mesh, &params, &report);
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        sn_vec3 p = fibers.polylines[i].points[8];
        quarter[(p.x > 0.5 * WIDTH) + 2 * (p.y > 0.5 * DEPTH)]++;
    }
    for (int q = 0; q < 4; q++) assert_in_range(quarter[q], 90, 110);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Uni- and bipennate fibres on a bar have the angle asked for, all of them, within 2 degrees. */
static void test_pennate_angles(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    const double degrees[3] = {12.0, 20.0, 35.0};
    for (int k = 0; k < 6; k++) {
        sn_index *lists;
        sn_fill_params params = bar_params(&lists);
        sn_fill_report report;
        params.template = k % 2 ? SN_FILL_BIPENNATE : SN_FILL_PENNATE;
        params.angle = degrees[k / 2] * SN_PI / 180.0;
        sn_fibers fibers = filled(&mesh, &params, &report);
        assert_int_equal(fibers.polyline_count, 100);
        for (sn_index i = 0; i < fibers.polyline_count; i++) {
            assert_near(chord_angle(&fibers.polylines[i]), degrees[k / 2], 2.0);
            assert_near(fibers.polylines[i].pennation * 180.0 / SN_PI, degrees[k / 2], 2.0);
        }
        sn_fibers_free(&fibers);
        free(lists);
    }
    sn_mesh_free(&mesh);
}

/* Turned by 90 degrees they run through the depth, not the width: shorter by their ratio. */
static void test_turn(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    double greatest[2];
    for (int k = 0; k < 2; k++) {
        sn_index *lists;
        sn_fill_params params = bar_params(&lists);
        sn_fill_report report;
        params.template = SN_FILL_PENNATE;
        params.turn = k * 0.5 * SN_PI;
        sn_fibers fibers = filled(&mesh, &params, &report);
        greatest[k] = report.greatest_length;
        assert_near(report.mean_pennation * 180.0 / SN_PI, 20.0, 2.0);
        sn_fibers_free(&fibers);
        free(lists);
    }
    assert_near(greatest[0] / greatest[1], WIDTH / DEPTH, 0.1);
    sn_mesh_free(&mesh);
}

/* A fan on a bar: a fibre at x from the middle at the wide end is at `narrow` times that at the other: the angle is known for each. */
static void test_fan_angles(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists);
    sn_fill_report report;
    params.template = SN_FILL_FAN;
    params.narrow = 0.2;
    sn_fibers fibers = filled(&mesh, &params, &report);
    double widest = 0.0;
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        sn_vec3 first = line->points[0], last = line->points[line->count - 1];
        double a = fabs(first.x - 0.5 * WIDTH), b = fabs(last.x - 0.5 * WIDTH), wide = fmax(a, b);
        double expected = atan2(0.8 * wide, 0.992 * LENGTH) * 180.0 / SN_PI;
        assert_near(chord_angle(line), expected, 0.3);
        widest = fmax(widest, expected);
    }
    assert_true(widest > 2.5);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* A curve of the user's through the middle is met where a seed is its start; here one straight oblique curve: every fibre has its angle. */
static void test_user_curve(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists);
    sn_fill_report report;
    const sn_vec3 points[2] = {{0.5, 0.5, 0.0}, {0.5, 0.5, 1.0}};
    const sn_fill_curve curve = {2, points};
    params.template = SN_FILL_USER;
    params.curve_count = 1;
    params.curves = &curve;
    sn_fibers fibers = filled(&mesh, &params, &report);
    for (sn_index i = 0; i < fibers.polyline_count; i++) assert_true(chord_angle(&fibers.polylines[i]) < 0.2);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Bend a bar's z into a circle of radius 100 about the y axis. */
static sn_vec3 bent(sn_vec3 p) {
    double turn = p.z / 100.0, radius = 100.0 + p.x;
    return sn_v3(radius * cos(turn) - 100.0, p.y, radius * sin(turn));
}

/* ---- superficial fibres -------------------------------------------------------------------------------------------------------- */

enum { GIVEN = 12, GIVEN_POINTS = 41 };

/* Six lines on each of the bar's wide sides, from x = 4 to 20 where they are straight, swung out by `swing` sin(pi z / L) in x. */
static void swung_lines(double swing, sn_polyline lines[GIVEN]) {
    for (sn_index i = 0; i < GIVEN; i++) {
        lines[i] = (sn_polyline){.count = GIVEN_POINTS, .points = SN_NEW(sn_vec3, GIVEN_POINTS)};
        for (sn_index k = 0; k < GIVEN_POINTS; k++) {
            double z = (i % 3 == 2 ? 1.0 - k / (GIVEN_POINTS - 1.0) : k / (GIVEN_POINTS - 1.0)) * LENGTH; /* some run downwards */
            lines[i].points[k] = sn_v3(4.0 + 3.2 * (i / 2) + swing * sin(SN_PI * z / LENGTH), i % 2 ? DEPTH : 0.0, z);
        }
    }
}

static void free_lines(sn_polyline lines[GIVEN]) {
    for (sn_index i = 0; i < GIVEN; i++) free(lines[i].points);
}

/* Fibres away from the narrow sides swing as the given ones do, deep ones too, to a tenth of the swing. */
static void test_superficial_fibres_bend_the_template(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists, seen = 0;
    sn_fill_params params = bar_params(&lists);
    sn_polyline lines[GIVEN];
    sn_fill_report report;
    const double swing = 3.0;
    swung_lines(swing, lines);
    params.bend_lines = lines;
    params.bend_count = GIVEN;
    sn_fibers fibers = filled(&mesh, &params, &report);
    assert_int_equal(fibers.polyline_count, 100);
    assert_true(report.bend_farthest < 1e-9);
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_vec3 *p = fibers.polylines[i].points;
        double base = 0.5 * (p[7].x + p[8].x) - swing;
        if (base < 4.0 || base > WIDTH - 7.0) continue;
        seen++;
        for (sn_index k = 0; k < 16; k++) assert_near(p[k].x, base + swing * sin(SN_PI * p[k].z / LENGTH), 0.1 * swing);
    }
    assert_true(seen > 30);
    sn_fibers_free(&fibers);
    free_lines(lines);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Given fibres that run as the template does leave it as it is. */
static void test_straight_superficial_fibres_bend_nothing(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists);
    sn_polyline lines[GIVEN];
    sn_fill_report report;
    sn_fibers plain = filled(&mesh, &params, &report);
    swung_lines(0.0, lines);
    params.bend_lines = lines;
    params.bend_count = GIVEN;
    sn_fibers fibers = filled(&mesh, &params, &report);
    for (sn_index i = 0; i < 100; i++)
        for (sn_index k = 0; k < 16; k++)
            assert_true(sn_distance(fibers.polylines[i].points[k], plain.polylines[i].points[k]) < 0.02 * WIDTH);
    sn_fibers_free(&plain);
    sn_fibers_free(&fibers);
    free_lines(lines);
    free(lists);
    sn_mesh_free(&mesh);
}

static sn_status bent_with(const sn_mesh *mesh, sn_fill_params params, sn_polyline *line, sn_error *error) {
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = *mesh};
    sn_fibers fibers;
    sn_fill_report report;
    params.bend_lines = line;
    params.bend_count = 1;
    sn_status status = sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, error);
    sn_fibers_free(&fibers);
    return status;
}

static void test_superficial_fibres_that_cannot_bend(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists), pennate = params;
    sn_vec3 across[2] = {{2, 0, 80}, {20, 0, 80.01}}, away[2] = {{2, -90, 20}, {2, -90, 100}}, bad[2] = {{2, 0, 20}, {NAN, 0, 100}};
    sn_polyline line = {.count = 2, .points = across};
    sn_error error = {0};
    assert_int_equal(bent_with(&mesh, params, &line, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "must run along it"));
    line.points = away;
    assert_int_equal(bent_with(&mesh, params, &line, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "unit"));
    line.points = bad;
    assert_int_equal(bent_with(&mesh, params, &line, &error), SN_ERROR_INPUT);
    line.count = 1;
    assert_int_equal(bent_with(&mesh, params, &line, &error), SN_ERROR_INPUT);
    pennate.template = SN_FILL_PENNATE;
    assert_int_equal(bent_with(&mesh, pennate, &line, &error), SN_ERROR_USAGE);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Fibres of the straight bar, bound to its surface and moved with it: on an affine map exactly, in a bend inside and of the analytic
 * lengths. */
static void test_fibres_follow_the_surface(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists;
    sn_fill_params params = bar_params(&lists);
    params.fibers = 12;
    sn_fill_report report;
    sn_fibers fibers = filled(&mesh, &params, &report);
    sn_vec3 points[12 * 16], moved[12 * 16];
    for (int i = 0; i < 12; i++) memcpy(points + 16 * i, fibers.polylines[i].points, 16 * sizeof *points);
    sn_embedding embedding;
    sn_embedding_params with = sn_embedding_defaults();
    assert_ok(sn_embedding_build(&mesh, 12 * 16, points, &with, &embedding, NULL));
    sn_vec3 *surface = SN_NEW(sn_vec3, mesh.vertex_count);
    for (sn_index v = 0; v < mesh.vertex_count; v++) {
        sn_vec3 p = mesh.positions[v];
        surface[v] = sn_v3(1.3 * p.x + 0.2 * p.z, p.y - 0.3 * p.x, 1.1 * p.z + 5.0);
    }
    sn_embedding_apply(&embedding, surface, NULL, moved);
    for (int i = 0; i < 12 * 16; i++) {
        sn_vec3 p = points[i];
        assert_true(sn_distance(moved[i], sn_v3(1.3 * p.x + 0.2 * p.z, p.y - 0.3 * p.x, 1.1 * p.z + 5.0)) < 1e-9 * LENGTH);
    }
    for (sn_index v = 0; v < mesh.vertex_count; v++) surface[v] = bent(mesh.positions[v]);
    sn_embedding_apply(&embedding, surface, NULL, moved);
    sn_mesh curved = mesh;
    curved.positions = surface;
    sn_surface *inside;
    assert_ok(sn_surface_create(&curved, &inside, NULL));
    for (int i = 0; i < 12; i++) {
        double length = 0.0, expected = 0.0;
        for (int k = 0; k < 16; k++) assert_true(sn_surface_signed_distance(inside, moved[16 * i + k], NULL) < 0.0);
        for (int k = 1; k < 16; k++) {
            length += sn_distance(moved[16 * i + k - 1], moved[16 * i + k]);
            expected += sn_distance(bent(points[16 * i + k - 1]), bent(points[16 * i + k]));
        }
        assert_near(length, expected, 1e-2 * expected);
    }
    sn_surface_destroy(inside);
    free(surface);
    sn_embedding_free(&embedding);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* A stem and two prongs: fibres split over both by area, and some reach each. */
static void test_split(void **state) {
    (void)state;
    sn_mesh mesh = blocks(two_prongs);
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = mesh};
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_fill_params params = sn_fill_defaults();
    sn_roots_report roots_report;
    sn_structure_report structure_report;
    sn_fill_report report;
    sn_fibers fibers;
    assert_ok(sn_roots_select(&muscle, &roots, NULL, &muscle.roots, &roots_report, NULL));
    assert_ok(sn_structure_build(&muscle, &structure, NULL, &muscle.structure, &structure_report, NULL));
    assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, NULL));
    assert_int_equal(report.leaves, 3);
    assert_int_equal(report.leaf_loops, 3);
    assert_int_equal(report.leaves_reached, 3);
    assert_int_equal(report.outside_after, 0);
    int prong[2] = {0};
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        sn_vec3 top = line->points[0].z > line->points[line->count - 1].z ? line->points[0] : line->points[line->count - 1];
        assert_true(top.z > 30.0);
        prong[top.x > 14.0]++;
    }
    assert_in_range(prong[0], 40, 60); /* the prongs are as thick as each other */
    assert_in_range(prong[1], 40, 60);
    sn_fibers_free(&fibers);
    sn_muscle_free(&muscle);
}

/* Fibres that bow aside by half the muscle's width stay in their prong: none crosses the gap between the two. */
static void test_fibres_do_not_change_heads(void **state) {
    (void)state;
    sn_mesh mesh = blocks(two_prongs);
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = mesh};
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_fill_params params = sn_fill_defaults();
    sn_roots_report roots_report;
    sn_structure_report structure_report;
    sn_fill_report report;
    sn_fibers fibers;
    const sn_vec3 points[3] = {{0.1, 0.5, 0.0}, {0.9, 0.5, 0.5}, {0.1, 0.5, 1.0}};
    const sn_fill_curve curve = {3, points};
    params.template = SN_FILL_USER;
    params.curve_count = 1;
    params.curves = &curve;
    params.segments = 40;
    assert_ok(sn_roots_select(&muscle, &roots, NULL, &muscle.roots, &roots_report, NULL));
    assert_ok(sn_structure_build(&muscle, &structure, NULL, &muscle.structure, &structure_report, NULL));
    assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, NULL));
    for (sn_index i = 0; i < fibers.polyline_count; i++)
        for (sn_index k = 1; k < fibers.polylines[i].count; k++) {
            sn_vec3 a = fibers.polylines[i].points[k - 1], b = fibers.polylines[i].points[k];
            if (a.z > 24.0 && b.z > 24.0) assert_true((a.x < 14.0) == (b.x < 14.0));
        }
    sn_fibers_free(&fibers);
    sn_muscle_free(&muscle);
}

/* A spindle held at both ends, and touched by a bone at its side near one of them: the touch is no end, fibres pass by it. */
static void test_a_touch_is_no_end(void **state) {
    (void)state;
    enum { RINGS = 60, SECTORS = 24, PATCH = 3 };
    sn_mesh mesh = spindle(RINGS, SECTORS, 100.0, 12.0);
    sn_index low = 0, high = mesh.vertex_count - 1, touch[PATCH] = {1 + 15 * SECTORS, 2 + 15 * SECTORS, 3 + 15 * SECTORS};
    sn_attachment attachments[3] = {{.bone = "a", .count = 1, .vertices = &low},
                                    {.bone = "b", .count = 1, .vertices = &high},
                                    {.bone = "c", .count = PATCH, .vertices = touch}};
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = mesh, .has_attachments = true, .attachment_count = 3, .attachments = attachments};
    sn_fill_params params = sn_fill_defaults();
    sn_fill_report report;
    sn_fibers fibers;
    assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, NULL));
    assert_int_equal(report.ends, SN_FILL_ENDS_ATTACHMENTS);
    assert_int_equal(report.leaf_loops, 2);
    assert_true(report.least_length > 95.0);
    sn_fibers_free(&fibers);
    sn_mesh_free(&mesh);
}

/* ---- from area to area --------------------------------------------------------------------------------------------------------- */

/* Areas on the bar's face y = 0: two origins beside each other at its low end, one about three times as long as the other, and an
 * insertion. */
enum { AREAS = 3 };
static int bar_area(sn_vec3 p) {
    if (p.y > 0.0 || p.x < 2.0 || p.x > 22.0 || p.z < 10.0 || p.z > 150.0) return SN_NONE;
    if (p.z >= 130.0) return 2;
    return p.x <= 8.0 && p.z <= 40.0 ? 0 : p.x >= 16.0 && p.z <= 20.0 ? 1 : SN_NONE;
}

static sn_muscle bar_with_areas(sn_mesh mesh, sn_index *lists, sn_attachment attachments[AREAS]) {
    static char *const bones[AREAS] = {"a", "b", "c"};
    for (int k = 0; k < AREAS; k++) {
        attachments[k] = (sn_attachment){.bone = bones[k], .method = "area", .vertices = lists + k * mesh.vertex_count};
        for (sn_index v = 0; v < mesh.vertex_count; v++)
            if (bar_area(mesh.positions[v]) == k) attachments[k].vertices[attachments[k].count++] = v;
    }
    return (sn_muscle){
        .meters_per_unit = 1.0, .mesh = mesh, .has_attachments = true, .attachment_count = AREAS, .attachments = attachments};
}

/* The area that a point on the bar lies in, or half an edge from. */
static int area_near(sn_vec3 p) {
    assert_near(p.y, 0.0, 1e-9);
    assert_true(p.x > 1.0 && p.x < 23.0 && p.z > 8.0 && p.z < 152.0);
    if (p.z >= 129.0) return 2;
    return p.x <= 8.5 && p.z <= 41.0 ? 0 : p.x >= 15.5 && p.z <= 21.0 ? 1 : SN_NONE;
}

/* Every fibre from an origin to the insertion, each area with its share by area, its quarters too. */
static void test_ends_are_even_over_areas(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists = SN_NEW(sn_index, AREAS * mesh.vertex_count);
    sn_attachment attachments[AREAS];
    sn_muscle muscle = bar_with_areas(mesh, lists, attachments);
    sn_fill_params params = sn_fill_defaults();
    sn_fill_report report;
    sn_fibers fibers;
    params.fibers = 120;
    assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, NULL));
    assert_true(report.spread);
    assert_int_equal(fibers.polyline_count, 120);
    assert_int_equal(report.outside_after, 0);
    int count[AREAS] = {0}, quarter[2] = {0};
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        sn_vec3 ends[2] = {line->points[0], line->points[line->count - 1]};
        int area[2] = {area_near(ends[0]), area_near(ends[1])};
        assert_true(area[0] != SN_NONE && area[1] != SN_NONE && (area[0] == 2) != (area[1] == 2));
        for (int k = 0; k < 2; k++) {
            count[area[k]]++;
            if (area[k] == 2) quarter[ends[k].x > 12.0]++;
        }
        double turned = 0.0;
        for (sn_index k = 2; k < line->count; k++) {
            sn_vec3 a = sn_sub(line->points[k - 1], line->points[k - 2]), b = sn_sub(line->points[k], line->points[k - 1]);
            turned += atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b));
        }
        assert_true(turned < 0.75 * SN_PI); /* no zigzag */
        assert_true(line->length < 1.15 * sn_distance(ends[0], ends[1]));
    }
    double origins = 7.0 * 32.0 + 7.0 * 12.0; /* vertices stand for half an edge beyond them */
    assert_near(count[0], 120.0 * 7.0 * 32.0 / origins, 4.0);
    assert_near(count[1], 120.0 * 7.0 * 12.0 / origins, 4.0);
    assert_near(quarter[0], 60.0, 4.0);
    assert_near(report.areas[0] + report.areas[1], origins + 21.0 * 22.0, 0.03 * origins);
    sn_fibers_free(&fibers);
    free(lists);
    sn_mesh_free(&mesh);
}

/* Spread, the fibres do not depend on the threads; not spread, they pass the middle of the muscle as ever. More fibres than are paired at
 * once have their ends in the areas, too. */
static void test_spreading_is_the_same_on_any_number_of_threads(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists = SN_NEW(sn_index, AREAS * mesh.vertex_count);
    sn_attachment attachments[AREAS];
    sn_muscle muscle = bar_with_areas(mesh, lists, attachments);
    sn_fibers fibers[2];
    for (int k = 0; k < 2; k++) {
        sn_fill_params params = sn_fill_defaults();
        sn_fill_report report;
        params.fibers = 700;
        params.pool = k == 0 ? NULL : sn_pool_create(3);
        assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers[k], &report, NULL));
        sn_pool_destroy(params.pool);
    }
    assert_int_equal(fibers[0].polyline_count, 700);
    for (sn_index i = 0; i < 700; i++) {
        const sn_polyline *line = &fibers[0].polylines[i];
        assert_memory_equal(line->points, fibers[1].polylines[i].points, 16 * sizeof(sn_vec3));
        assert_true((area_near(line->points[0]) == 2) != (area_near(line->points[15]) == 2));
        assert_true(line->length < 1.2 * sn_distance(line->points[0], line->points[15])); /* paired well */
    }
    sn_fibers_free(&fibers[0]);
    sn_fibers_free(&fibers[1]);
    free(lists);
    sn_mesh_free(&mesh);
}

/* What asks for another template, or not to spread, gets what it got without areas to spread over. */
static void test_not_spread_where_a_template_is_asked_for(void **state) {
    (void)state;
    sn_mesh mesh = bar();
    sn_index *lists = SN_NEW(sn_index, AREAS * mesh.vertex_count);
    sn_attachment attachments[AREAS];
    sn_muscle muscle = bar_with_areas(mesh, lists, attachments);
    for (int k = 0; k < 3; k++) {
        sn_fill_params params = sn_fill_defaults();
        sn_fill_report report;
        sn_fibers fibers;
        if (k == 0) params.spread = false;
        if (k == 1) params.template = SN_FILL_CURVED;
        if (k == 2) params.use_attachments = false;
        assert_ok(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, NULL));
        assert_false(report.spread);
        assert_true(report.length_deviation > 0.0);
        sn_fibers_free(&fibers);
    }
    free(lists);
    sn_mesh_free(&mesh);
}

/* The angle that is asked for comes out also where the muscle is not as wide everywhere, and its sections are round. */
static void test_angles_of_a_fusiform(void **state) {
    (void)state;
    sn_mesh mesh = spindle(80, 32, 200.0, 20.0);
    for (int k = 0; k < 6; k++) {
        sn_fill_params params = sn_fill_defaults();
        sn_fill_report report;
        double degrees = 10.0 * (k / 2 + 1);
        params.template = k % 2 ? SN_FILL_BIPENNATE : SN_FILL_PENNATE;
        params.angle = degrees * SN_PI / 180.0;
        sn_fibers fibers = filled(&mesh, &params, &report);
        assert_near(report.mean_pennation * 180.0 / SN_PI, degrees, 2.0);
        sn_fibers_free(&fibers);
    }
    sn_mesh_free(&mesh);
}

static void test_threads_give_the_same_fibres(void **state) {
    (void)state;
    sn_mesh mesh = spindle(40, 24, 100.0, 12.0);
    sn_fibers fibers[2];
    for (int k = 0; k < 2; k++) {
        sn_fill_params params = sn_fill_defaults();
        sn_fill_report report;
        params.pool = k == 0 ? NULL : sn_pool_create(3);
        fibers[k] = filled(&mesh, &params, &report);
        sn_pool_destroy(params.pool);
    }
    for (sn_index i = 0; i < 100; i++)
        assert_memory_equal(fibers[0].polylines[i].points, fibers[1].polylines[i].points, 16 * sizeof(sn_vec3));
    sn_fibers_free(&fibers[0]);
    sn_fibers_free(&fibers[1]);
    sn_mesh_free(&mesh);
}

/* A section like a C: the harmonic map keeps every vertex inside before any pull, the paper's map does not. */
static bool gutter(int x, int y, int z) {
    bool plate = x >= 6 && x < 30 && y >= 6 && y < 26, bay = x >= 10 && x < 26 && y >= 10;
    return plate && !bay && z >= 2 && z < 38;
}

static void test_concave_sections(void **state) {
    (void)state;
    sn_mesh mesh = blocks(gutter);
    sn_index outside[2];
    for (int k = 0; k < 2; k++) {
        sn_fill_params params = sn_fill_defaults();
        sn_fill_report report;
        params.map = k == 0 ? SN_FILL_HARMONIC : SN_FILL_MEAN_VALUE;
        sn_fibers fibers = filled(&mesh, &params, &report);
        outside[k] = report.outside_before;
        sn_fibers_free(&fibers);
    }
    assert_true(outside[0] * 5 < outside[1]);
    sn_mesh_free(&mesh);
}

static void test_impossible_requests(void **state) {
    (void)state;
    sn_mesh mesh = spindle(20, 12, 100.0, 12.0);
    sn_muscle muscle = {.meters_per_unit = 1.0, .mesh = mesh};
    sn_fibers fibers;
    sn_fill_report report;
    sn_error error = {0};
    sn_fill_params params = sn_fill_defaults();
    params.fibers = 0;
    assert_int_equal(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, &error), SN_ERROR_USAGE);
    params = sn_fill_defaults();
    params.template = SN_FILL_USER;
    assert_int_equal(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, &error), SN_ERROR_USAGE);
    params = sn_fill_defaults();
    const sn_index one = 3, far = 100000;
    params.origin = params.insertion = &one;
    params.origin_count = params.insertion_count = 1;
    assert_int_equal(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, &error), SN_ERROR_INPUT);
    params.insertion = &far;
    assert_int_equal(sn_fill_fibers(&muscle, &params, NULL, &fibers, &report, &error), SN_ERROR_INPUT);
    assert_null(fibers.polylines);
    sn_mesh_free(&mesh);
}

static void test_sobol(void **state) {
    (void)state;
    double points[2 * 64];
    int cells[16] = {0};
    assert_ok(sn_sobol(2, 64, points, NULL));
    assert_near(points[0], 0.5, 0.0); /* the sequence begins (1/2, 1/2), (3/4, 1/4), (1/4, 3/4) */
    assert_near(points[2], 0.75, 0.0);
    assert_near(points[3], 0.25, 0.0);
    for (int i = 0; i < 64; i++) cells[(int)(points[2 * i] * 4) + 4 * (int)(points[2 * i + 1] * 4)]++;
    for (int c = 0; c < 16; c++) assert_in_range(cells[c], 3, 5); /* 64 points, 4 a cell but for the one at 0 that is left out */
    assert_int_equal(sn_sobol(41, 1, points, NULL), SN_ERROR_USAGE);
}

/* Fibres that fill a bar leave nothing empty; those that end at a quarter of it leave what is farther than five spacings beyond. */
static void test_what_is_left_empty(void **state) {
    (void)state;
    const sn_index around = 2 * (WIDE + DEEP), ring = LONG / 4;
    sn_mesh mesh = bar();
    sn_index *lists, *low = SN_NEW(sn_index, around);
    sn_fill_params params = bar_params(&lists);
    sn_fill_report report;
    sn_fibers fibers = filled(&mesh, &params, &report);
    assert_true(report.empty == 0.0);
    assert_near(report.spacing, sqrt(WIDTH * DEPTH / 100.0 / 0.992), 0.02);
    assert_true(report.greatest_bend < 1.01);
    assert_true(report.bent == 0 && !report.flux);
    sn_fibers_free(&fibers);
    for (sn_index k = 0; k < around; k++) low[k] = bar_vertex(ring, k);
    params.insertion = low;
    params.insertion_count = around;
    fibers = filled(&mesh, &params, &report);
    assert_near(report.spacing, sqrt(WIDTH * DEPTH * 4.0 / 100.0 / 0.992), 0.05);
    assert_near(report.empty, 0.75 - SN_FILL_FAR * report.spacing / LENGTH, 0.01);
    sn_fibers_free(&fibers);
    free(low);
    free(lists);
    sn_mesh_free(&mesh);
}

/* From one half of a face to its other half: fibres bend back, the bar does not. */
static void test_fibres_that_bend_back(void **state) {
    (void)state;
    const sn_index around = 2 * (WIDE + DEEP);
    sn_mesh mesh = bar();
    sn_index *sides = SN_NEW(sn_index, 2 * around), counts[2] = {0, 0};
    for (sn_index k = 0; k < around; k++) {
        sn_index v = bar_vertex(0, k);
        double x = mesh.positions[v].x;
        if (x < 0.3 * WIDTH) sides[counts[0]++] = v;
        if (x > 0.7 * WIDTH) sides[around + counts[1]++] = v;
    }
    sn_fill_params params = sn_fill_defaults();
    sn_fill_report report;
    params.origin = sides;
    params.insertion = sides + around;
    params.origin_count = counts[0];
    params.insertion_count = counts[1];
    sn_fibers fibers = filled(&mesh, &params, &report);
    sn_index bent = 0;
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        bent += line->length > SN_FILL_BENT * report.muscle_bend * sn_distance(line->points[0], line->points[line->count - 1]);
    }
    assert_true(report.muscle_bend > 1.0 && report.muscle_bend < 1.2);
    assert_true(bent > 0 && report.bent == bent);
    sn_fibers_free(&fibers);
    free(sides);
    sn_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parallel_fibres_are_straight),
        cmocka_unit_test(test_fibres_are_even_over_the_section),
        cmocka_unit_test(test_pennate_angles),
        cmocka_unit_test(test_turn),
        cmocka_unit_test(test_fan_angles),
        cmocka_unit_test(test_user_curve),
        cmocka_unit_test(test_superficial_fibres_bend_the_template),
        cmocka_unit_test(test_straight_superficial_fibres_bend_nothing),
        cmocka_unit_test(test_superficial_fibres_that_cannot_bend),
        cmocka_unit_test(test_fibres_follow_the_surface),
        cmocka_unit_test(test_split),
        cmocka_unit_test(test_fibres_do_not_change_heads),
        cmocka_unit_test(test_a_touch_is_no_end),
        cmocka_unit_test(test_ends_are_even_over_areas),
        cmocka_unit_test(test_spreading_is_the_same_on_any_number_of_threads),
        cmocka_unit_test(test_not_spread_where_a_template_is_asked_for),
        cmocka_unit_test(test_angles_of_a_fusiform),
        cmocka_unit_test(test_threads_give_the_same_fibres),
        cmocka_unit_test(test_concave_sections),
        cmocka_unit_test(test_impossible_requests),
        cmocka_unit_test(test_sobol),
        cmocka_unit_test(test_what_is_left_empty),
        cmocka_unit_test(test_fibres_that_bend_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
