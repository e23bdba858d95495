/* Fibre flow: unit, tangent, along the muscle, an axis field; and a direction everywhere, however bad the surface. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "rig_shapes.h"
#include "sinew/rig.h"

#define DEGREES (180.0 / SN_PI)

static sn_muscle structured(sn_mesh mesh) {
    sn_muscle m = {.meters_per_unit = 1, .mesh = mesh};
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_error error = {0};
    if (sn_roots_select(&m, &roots, NULL, &m.roots, NULL, &error)) fail_msg("%s", error.text);
    if (sn_structure_build(&m, &structure, NULL, &m.structure, NULL, &error)) fail_msg("%s", error.text);
    return m;
}

static sn_flow_report flow(sn_muscle *m, sn_flow_params params) {
    sn_flow_report report;
    sn_error error = {0};
    sn_fibers_free(&m->fibers);
    if (sn_flow_fibers(m, &params, NULL, &m->fibers, &report, &error)) fail_msg("%s", error.text);
    return report;
}

static void check_directions(const sn_muscle *m) {
    sn_vec3 *normals = SN_NEW(sn_vec3, m->mesh.vertex_count);
    sn_mesh_vertex_normals(&m->mesh, normals);
    for (sn_index v = 0; v < m->mesh.vertex_count; v++) {
        sn_vec3 f = m->fibers.directions[v];
        assert_true(fabs(sn_norm(f) - 1.0) < 1e-9);
        assert_true(fabs(sn_dot(f, normals[v])) < 1e-6);
    }
    free(normals);
}

/* Greatest angle between a fibre and the meridian, away from the poles. */
static double meridian_error(const sn_muscle *m) {
    double worst = 0.0;
    for (sn_index v = 0; v < m->mesh.vertex_count; v++) {
        sn_vec3 p = m->mesh.positions[v], f = m->fibers.directions[v];
        if (fabs(p.z) > 0.08) continue;
        sn_vec3 around = sn_normalize(sn_v3(-p.y, p.x, 0)); /* a meridian has no part around the axis */
        worst = fmax(worst, asin(fmin(1.0, fabs(sn_dot(f, around)))));
    }
    return worst * DEGREES;
}

static void a_spindle_flows_along_its_meridians(void **state) {
    (void)state;
    sn_muscle m = structured(spindle(31, 12, 0.2, 0.03));
    sn_flow_report r = flow(&m, sn_flow_defaults());
    check_directions(&m);
    assert_true(meridian_error(&m) < 1.0); /* not 0: the diagonals of the mesh tilt its normals */
    assert_int_equal(r.by_field + r.by_neighbours + r.by_convention, m.mesh.vertex_count);
    assert_int_equal(r.by_neighbours, 2); /* the poles, where the muscle's axis is the normal */
    assert_true(r.max_normal_dot < 1e-6);
    sn_muscle_free(&m);
}

static void directions_point_to_the_roots_from_both_sides(void **state) {
    (void)state;
    sn_muscle m = structured(spindle(31, 12, 0.2, 0.03));
    flow(&m, sn_flow_defaults());
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) {
        double z = m.mesh.positions[v].z;
        if (fabs(z) > 0.01 && fabs(z) < 0.08) assert_true(m.fibers.directions[v].z * z < 0.0);
    }
    sn_muscle_free(&m);
}

/* delta changes sign at the roots: as vectors the two sides cancel, as axes they agree. */
static void alignment_heals_the_roots(void **state) {
    (void)state;
    sn_muscle m = structured(blocks(two_prongs));
    sn_flow_params literal = {.weights = SN_FLOW_PAPER, .smooth = 0, .align = false};
    sn_flow_report paper = flow(&m, literal);
    check_directions(&m);
    literal.align = true;
    sn_flow_report aligned = flow(&m, literal);
    check_directions(&m);
    assert_true(aligned.percentile95_angle < paper.percentile95_angle);
    assert_true(aligned.by_neighbours + aligned.by_convention <= paper.by_neighbours + paper.by_convention);
    sn_muscle_free(&m);
}

static void smoothing_lowers_the_angles_between_neighbours(void **state) {
    (void)state;
    sn_muscle m = structured(blocks(two_prongs));
    sn_flow_params params = sn_flow_defaults();
    double before = 100.0;
    for (params.smooth = 0; params.smooth <= 4; params.smooth++) {
        sn_flow_report r = flow(&m, params);
        check_directions(&m);
        assert_true(r.mean_angle < before);
        before = r.mean_angle;
    }
    sn_muscle_free(&m);
}

/* A structure of one sample with this axis, for surfaces that no structure fits. */
static sn_muscle one_sample(sn_mesh mesh, sn_vec3 axis) {
    sn_muscle m = {.meters_per_unit = 1, .mesh = mesh};
    m.structure = (sn_structure){.sample_count = 1, .spacing = 1};
    m.structure.positions = SN_NEW(sn_vec3, 1);
    m.structure.axes = SN_NEW(sn_vec3, 1);
    m.structure.parents = SN_NEW(sn_index, 1);
    m.structure.branches = SN_NEW(sn_index, 1);
    m.structure.vertex_sample = SN_NEW(sn_index, mesh.vertex_count);
    m.structure.parents[0] = SN_NONE;
    m.structure.axes[0] = axis;
    return m;
}

static sn_mesh square_sheet(void) {
    sn_mesh m = {0};
    if (sn_mesh_alloc(&m, 5, 2, NULL)) abort();
    for (sn_index v = 0; v < 4; v++) m.positions[v] = sn_v3(v % 2, v / 2, 0); /* vertex 4 is in no triangle */
    m.triangles[0] = (sn_triangle){{0, 1, 3}};
    m.triangles[1] = (sn_triangle){{0, 3, 2}};
    return m;
}

static void where_nothing_says_anything_convention_does(void **state) {
    (void)state;
    sn_muscle m = one_sample(square_sheet(), sn_v3(0, 0, 1));
    sn_flow_report r = flow(&m, sn_flow_defaults());
    check_directions(&m);
    assert_int_equal(r.by_convention, 5);
    for (sn_index v = 0; v < 5; v++) assert_true(m.fibers.directions[v].x == 1.0);
    sn_muscle_free(&m);
}

/* Two triangles back to back: every vertex normal is zero, and so needs a stand-in. */
static void a_pillow_without_normals_gets_directions(void **state) {
    (void)state;
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_alloc(&mesh, 3, 2, NULL), SN_OK);
    mesh.positions[1] = sn_v3(1, 0, 0);
    mesh.positions[2] = sn_v3(0, 1, 0);
    mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
    mesh.triangles[1] = (sn_triangle){{0, 2, 1}};
    sn_muscle m = one_sample(mesh, sn_normalize(sn_v3(1, 1, 1)));
    flow(&m, sn_flow_defaults());
    check_directions(&m);
    for (sn_index v = 0; v < 3; v++) assert_true(fabs(m.fibers.directions[v].z) < 1e-12); /* in the triangles' plane */
    sn_muscle_free(&m);
}

static void all_vertices_in_one_point_get_directions(void **state) {
    (void)state;
    sn_mesh mesh = spindle(3, 5, 0.2, 0.03);
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v] = sn_v3(1, 2, 3);
    sn_muscle m = one_sample(mesh, sn_v3(0, 0, 1));
    flow(&m, sn_flow_defaults());
    check_directions(&m);
    sn_muscle_free(&m);
}

static void an_unfinished_structure_is_an_error_that_helps(void **state) {
    (void)state;
    sn_flow_params params = sn_flow_defaults();
    sn_fibers fibers;
    sn_error error = {0};
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(5, 6, 0.2, 0.03)};
    assert_int_equal(sn_flow_fibers(&m, &params, NULL, &fibers, NULL, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "build-structure"));
    sn_muscle_free(&m);
    m = one_sample(spindle(5, 6, 0.2, 0.03), sn_v3(0, 0, 1));
    m.structure.vertex_sample[7] = SN_NONE;
    assert_int_equal(sn_flow_fibers(&m, &params, NULL, &fibers, NULL, &error), SN_ERROR_INPUT);
    assert_int_equal(error.element, 7);
    sn_muscle_free(&m);
}

static void stopping_anywhere_leaves_valid_directions_or_none(void **state) {
    (void)state;
    sn_muscle m = structured(spindle(31, 12, 0.2, 0.03));
    sn_flow_params params = sn_flow_defaults();
    sn_status status = SN_STOPPED;
    for (int64_t n = 0; status == SN_STOPPED; n++) {
        sn_trace trace = {.stop_after = n};
        sn_fibers_free(&m.fibers);
        status = sn_flow_fibers(&m, &params, &trace, &m.fibers, NULL, NULL);
        assert_true(trace.steps <= n && n < 10);
        if (n == 0)
            assert_null(m.fibers.directions);
        else
            check_directions(&m);
    }
    assert_int_equal(status, SN_OK);
    sn_muscle_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spindle_flows_along_its_meridians),
        cmocka_unit_test(directions_point_to_the_roots_from_both_sides),
        cmocka_unit_test(alignment_heals_the_roots),
        cmocka_unit_test(smoothing_lowers_the_angles_between_neighbours),
        cmocka_unit_test(where_nothing_says_anything_convention_does),
        cmocka_unit_test(a_pillow_without_normals_gets_directions),
        cmocka_unit_test(all_vertices_in_one_point_get_directions),
        cmocka_unit_test(an_unfinished_structure_is_an_error_that_helps),
        cmocka_unit_test(stopping_anywhere_leaves_valid_directions_or_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
