/* test_clean.c -- sn_clean: clean input stays as it is; wrecks become closed, oriented manifolds or a clear error. */
#include "shapes.h"

#include "sinew/rig.h"

static sn_status clean_with(const sn_mesh *mesh, const sn_clean_params *params, sn_mesh *out, sn_clean_report *report) {
    sn_error error = {0};
    sn_status status = sn_clean(mesh, params, NULL, out, report, &error);
    if (status != SN_OK) assert_true(error.text[0] != '\0'); /* never without a sentence */
    return status;
}

/* Clean with the defaults, expect success and a sound result; the report stays with the caller. */
static sn_mesh clean_to_sound(const sn_mesh *mesh, sn_clean_report *report) {
    sn_clean_params params = sn_clean_defaults();
    sn_mesh out;
    assert_ok(clean_with(mesh, &params, &out, report));
    assert_true(shape_is_sound(&out));
    assert_true(report->after.closed && report->after.manifold && report->after.oriented && report->after.outward);
    return out;
}

static void finish(sn_mesh *mesh, sn_mesh *out, sn_clean_report *report) {
    sn_clean_report_free(report);
    sn_mesh_free(out);
    sn_mesh_free(mesh);
}

static void clean_input_comes_out_as_it_was(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(30, 60);
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&sphere, &report);
    assert_true(report.unchanged);
    assert_true(shape_same(&sphere, &out));
    assert_near(report.hausdorff, 0.0, 0.0);
    finish(&sphere, &out, &report);
}

/* All of the sample's dirt at once: a crack, doubled and turned triangles, a hole, a loose shell, a stray vertex. */
static void a_dirty_sphere_is_as_good_as_the_clean_one(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), speck = shape_cube();
    double volume = sn_mesh_volume(&sphere);
    sn_mesh mesh = shape_join(&sphere, &speck, 0.05, sn_v3(3, 0, 0));
    shape_drop(&mesh, 900);
    for (sn_index t = 100; t < 140; t++) shape_flip(&mesh, t);
    mesh.triangles = sn_realloc(mesh.triangles, (size_t)mesh.triangle_count + 2, sizeof *mesh.triangles);
    mesh.triangles[mesh.triangle_count++] = mesh.triangles[500];
    mesh.triangles[mesh.triangle_count++] = (sn_triangle){{7, 7, 8}};
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&mesh, &report);
    assert_int_equal(report.dropped_count, 1);
    assert_int_equal(report.dropped[0].triangles, 12);
    assert_near(report.dropped[0].area, 6.0 * 0.05 * 0.05, 1e-12);
    assert_near(report.dropped[0].volume, 0.05 * 0.05 * 0.05, 1e-12);
    assert_near(sn_distance(report.dropped[0].centre, sn_v3(3.025, 0.025, 0.025)), 0.0, 1e-9);
    assert_int_equal(report.flipped_triangles, 40);
    assert_int_equal(report.duplicate, 1);
    assert_int_equal(report.degenerate, 1);
    assert_int_equal(report.holes_filled, 1);
    assert_int_equal(out.vertex_count, sphere.vertex_count);
    assert_near(sn_mesh_volume(&out), volume, 1e-3);
    assert_memory_equal(out.positions, sphere.positions, (size_t)sphere.vertex_count * sizeof *sphere.positions);
    sn_mesh_free(&speck);
    sn_mesh_free(&sphere);
    finish(&mesh, &out, &report);
}

static void cleaning_twice_changes_nothing_more(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(1, 1, 0)), once, twice;
    sn_clean_params params = sn_clean_defaults();
    params.keep = 0;
    sn_clean_report report;
    assert_ok(clean_with(&two, &params, &once, &report));
    sn_clean_report_free(&report);
    assert_ok(clean_with(&once, &params, &twice, &report));
    assert_true(report.unchanged);
    assert_true(shape_same(&once, &twice));
    sn_mesh_free(&once);
    sn_mesh_free(&cube);
    finish(&two, &twice, &report);
}

/* Bodies that touch at a corner only, each closed but one of them badly wound: welding them would tear them apart again. */
static void touching_bodies_are_not_welded(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(1, 1, 1)), out;
    shape_flip(&two, 15);
    sn_clean_params params = sn_clean_defaults();
    params.keep = 0;
    sn_clean_report report;
    assert_ok(clean_with(&two, &params, &out, &report));
    assert_int_equal(report.welded, 0);
    assert_int_equal(report.flipped_triangles, 1);
    assert_int_equal(report.split_vertices, 0);
    assert_memory_equal(out.positions, two.positions, 16 * sizeof *two.positions);
    assert_true(shape_is_sound(&out));
    sn_mesh_free(&cube);
    finish(&two, &out, &report);
}

static void a_soup_of_separate_triangles_is_welded(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), soup = shape_empty(3 * sphere.triangle_count, sphere.triangle_count);
    uint64_t seed = 11;
    for (sn_index t = 0; t < sphere.triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_vec3 jitter = sn_v3(1e-8 * sn_random(&seed), 1e-8 * sn_random(&seed), 1e-8 * sn_random(&seed));
            soup.positions[3 * t + k] = sn_add(sphere.positions[sphere.triangles[t].v[k]], jitter);
            soup.triangles[t].v[k] = 3 * t + k;
        }
    }
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&soup, &report);
    assert_int_equal(out.vertex_count, sphere.vertex_count);
    assert_int_equal(out.triangle_count, sphere.triangle_count);
    sn_mesh_free(&sphere);
    finish(&soup, &out, &report);
}

static void inside_out_is_turned(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20);
    for (sn_index t = 0; t < sphere.triangle_count; t++) shape_flip(&sphere, t);
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&sphere, &report);
    assert_int_equal(report.flipped_components, 1);
    assert_true(sn_mesh_volume(&out) > 4.0);
    finish(&sphere, &out, &report);
}

static void a_doubled_surface_becomes_single(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20), twice = shape_join(&sphere, &sphere, 1.0, sn_v3(0, 0, 0));
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&twice, &report);
    assert_int_equal(report.duplicate, sphere.triangle_count);
    assert_true(shape_same(&out, &sphere));
    sn_mesh_free(&sphere);
    finish(&twice, &out, &report);
}

/* A sphere with a fin: a loose triangle on one of its edges. */
static void a_fin_does_not_open_the_surface(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20), mesh = shape_empty(sphere.vertex_count + 1, sphere.triangle_count + 1);
    memcpy(mesh.positions, sphere.positions, (size_t)sphere.vertex_count * sizeof *mesh.positions);
    memcpy(mesh.triangles, sphere.triangles, (size_t)sphere.triangle_count * sizeof *mesh.triangles);
    const sn_index *edge = mesh.triangles[205].v;
    mesh.positions[sphere.vertex_count] = sn_scale(mesh.positions[edge[0]], 1.5);
    mesh.triangles[sphere.triangle_count] = (sn_triangle){{edge[0], edge[1], sphere.vertex_count}};
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&mesh, &report);
    assert_near(sn_mesh_volume(&out), sn_mesh_volume(&sphere), 1e-9);
    sn_mesh_free(&sphere);
    finish(&mesh, &out, &report);
}

/* Cubes glued side by side, both keeping the wall between them: the body around both is what is left. */
static void an_inner_wall_goes(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(0, 0, 1));
    sn_clean_report report;
    sn_mesh out = clean_to_sound(&two, &report);
    assert_int_equal(out.vertex_count, 12);
    assert_int_equal(out.triangle_count, 20);
    assert_near(sn_mesh_volume(&out), 2.0, 1e-12);
    sn_mesh_free(&cube);
    finish(&two, &out, &report);
}

static void a_one_sided_surface_is_reported(void **state) {
    (void)state;
    sn_mesh strip = shape_moebius(30), out;
    sn_clean_params params = sn_clean_defaults();
    sn_clean_report report;
    assert_ok(clean_with(&strip, &params, &out, &report));
    assert_false(report.orientable);
    finish(&strip, &out, &report);
}

static void what_is_no_surface_is_a_clear_error(void **state) {
    (void)state;
    sn_clean_params params = sn_clean_defaults();
    sn_clean_report report;
    sn_mesh out, none = {0}, cube = shape_cube();
    assert_int_equal(clean_with(&none, &params, &out, &report), SN_ERROR_INPUT);
    cube.positions[3].x = NAN;
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    for (sn_index i = 0; i < 8; i++) cube.positions[i] = sn_v3(2, 3, 4);
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    for (sn_index i = 0; i < 8; i++) cube.positions[i] = sn_v3(i, 0, 0);
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    cube.positions[0] = sn_v3(1e300, 1e300, -1e300);
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    cube.triangles[4].v[1] = 99;
    cube.positions[0] = sn_v3(0, 1, 0);
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    params.repair_nonfinite = true;
    cube.positions[0].x = NAN;
    assert_int_equal(clean_with(&cube, &params, &out, &report), SN_ERROR_INPUT);
    sn_mesh_free(&cube);
}

static void vertices_without_a_number_are_repaired_on_request(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), out;
    sphere.positions[333].y = INFINITY;
    sn_clean_params params = sn_clean_defaults();
    params.repair_nonfinite = true;
    sn_clean_report report;
    assert_ok(clean_with(&sphere, &params, &out, &report));
    assert_int_equal(report.nonfinite_vertices, 1);
    assert_int_equal(report.holes_filled, 1);
    assert_true(shape_is_sound(&out));
    finish(&sphere, &out, &report);
}

static void size_and_place_do_not_matter(void **state) {
    (void)state;
    const double sizes[] = {1e-30, 1e-3, 1e9, 1e30};
    for (int i = 0; i < 4; i++) {
        sn_mesh sphere = shape_sphere(12, 24);
        shape_drop(&sphere, 205);
        shape_flip(&sphere, 9);
        for (sn_index v = 0; v < sphere.vertex_count; v++) {
            sphere.positions[v] = sn_scale(sn_add(sphere.positions[v], sn_v3(100, -200, 300)), sizes[i]);
        }
        sn_clean_report report;
        sn_mesh out = clean_to_sound(&sphere, &report);
        assert_int_equal(report.holes_filled, 1);
        assert_int_equal(report.flipped_triangles, 1);
        finish(&sphere, &out, &report);
    }
}

static void each_step_can_be_the_last(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20), cube = shape_cube(), mesh = shape_join(&sphere, &cube, 0.1, sn_v3(3, 0, 0));
    shape_flip(&mesh, 11);
    shape_drop(&mesh, 205);
    sn_clean_params params = sn_clean_defaults();
    sn_trace whole = {.stop_after = -1};
    sn_clean_report report;
    sn_mesh out;
    assert_ok(sn_clean(&mesh, &params, &whole, &out, &report, NULL));
    sn_clean_report_free(&report);
    sn_mesh_free(&out);
    assert_true(whole.steps >= 6);
    for (int64_t stop = 0; stop <= whole.steps; stop++) {
        sn_trace trace = {.stop_after = stop};
        assert_int_equal(sn_clean(&mesh, &params, &trace, &out, &report, NULL), SN_STOPPED);
        assert_int_equal(trace.steps, stop);
        assert_ok(sn_mesh_validate(&out, NULL));
        sn_clean_report_free(&report);
        sn_mesh_free(&out);
    }
    sn_mesh_free(&sphere);
    sn_mesh_free(&cube);
    sn_mesh_free(&mesh);
}

/* Whatever the soup, a result or a sentence; a result says of itself what it is. */
static void random_soups_do_no_harm(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 300; round++) {
        sn_index vertices = 3 + round % 17, triangles = 1 + round % 40;
        sn_mesh soup = shape_empty(vertices, triangles), out;
        for (sn_index i = 0; i < vertices; i++) {
            soup.positions[i] = sn_v3(floor(3.0 * sn_random(&seed)), floor(3.0 * sn_random(&seed)), round % 3 ? sn_random(&seed) : 0.0);
        }
        for (sn_index t = 0; t < triangles; t++) {
            for (int k = 0; k < 3; k++) soup.triangles[t].v[k] = (sn_index)(sn_random(&seed) * vertices);
        }
        sn_clean_params params = sn_clean_defaults();
        params.keep = round % 2;
        params.triangles = round % 5 == 0 ? 6 : 0;
        sn_clean_report report;
        sn_status status = clean_with(&soup, &params, &out, &report);
        assert_true(status == SN_OK || status == SN_ERROR_INPUT);
        if (status == SN_OK) {
            assert_ok(sn_mesh_validate(&out, NULL));
            assert_true(report.after.manifold && report.after.oriented);
            assert_int_equal(shape_inspect(&out).boundary_edges, report.after.boundary_edges);
            sn_clean_report_free(&report);
            sn_mesh_free(&out);
        }
        sn_mesh_free(&soup);
    }
}

/* ---- crossings -------------------------------------------------------------------------------------------------------------- */

/* A sphere with its vertices moved at random, and holes of up to four triangles. */
static sn_mesh crumpled(uint64_t seed) {
    sn_mesh mesh = shape_sphere(14, 28);
    double most = 0.1 + 0.3 * sn_random(&seed);
    for (sn_index i = 0; i < mesh.vertex_count; i++) {
        sn_vec3 move = sn_v3(sn_random(&seed) - 0.5, sn_random(&seed) - 0.5, sn_random(&seed) - 0.5);
        mesh.positions[i] = sn_add_scaled(mesh.positions[i], move, most);
    }
    for (int i = 0; i < 12; i++) {
        sn_index first = (sn_index)(sn_random(&seed) * (mesh.triangle_count - 4));
        for (int k = 0; k < 4; k++) shape_drop(&mesh, first);
    }
    return mesh;
}

/* Two spheres, one in the other by half, with holes where they cut each other. */
static sn_mesh interpenetrating(uint64_t seed) {
    sn_mesh one = shape_sphere(12, 24);
    sn_mesh mesh = shape_join(&one, &one, 0.8, sn_v3(0.3 + sn_random(&seed), 0.1 * sn_random(&seed), 0.2));
    for (int i = 0; i < 30; i++) shape_drop(&mesh, (sn_index)(sn_random(&seed) * mesh.triangle_count));
    sn_mesh_free(&one);
    return mesh;
}

/* A sheet (t^2, t^3 - t, v), which goes through itself at t = 1 and t = -1. */
static sn_mesh folded_sheet(uint64_t seed) {
    const sn_index rows = 6, columns = 24;
    sn_mesh mesh = shape_empty((rows + 1) * (columns + 1), 2 * rows * columns);
    for (sn_index r = 0; r <= rows; r++) {
        for (sn_index c = 0; c <= columns; c++) {
            double t = 3.0 * c / columns - 1.5 + 0.02 * sn_random(&seed);
            mesh.positions[r * (columns + 1) + c] = sn_v3(t * t, t * t * t - t, 0.3 * r);
        }
    }
    for (sn_index i = 0; i < rows * columns; i++) {
        sn_index a = i / columns * (columns + 1) + i % columns, b = a + columns + 1;
        mesh.triangles[2 * i] = (sn_triangle){{a, a + 1, b + 1}};
        mesh.triangles[2 * i + 1] = (sn_triangle){{a, b + 1, b}};
    }
    return mesh;
}

static sn_mesh ugly(int kind, uint64_t seed) {
    return kind == 0 ? crumpled(seed) : kind == 1 ? interpenetrating(seed) : folded_sheet(seed);
}

/* The report's counts are those of the meshes; more at the end is in crossings_made. Returns it. */
static sn_index check_crossings(const sn_mesh *mesh, const sn_mesh *out, const sn_clean_report *report) {
    sn_index before = -1, after = -1;
    assert_ok(sn_count_self_intersections(mesh, &before, NULL));
    assert_ok(sn_count_self_intersections(out, &after, NULL));
    assert_int_equal(report->before.self_intersections, before);
    assert_int_equal(report->after.self_intersections, after);
    assert_int_equal(report->crossings_made, after > before ? after - before : 0);
    assert_false(report->crossings_uncounted);
    return report->crossings_made;
}

static void repair_makes_no_crossings_or_says_so(void **state) {
    (void)state;
    int more = 0;
    sn_index undone = 0;
    for (int i = 0; i < 6; i++) {
        for (int mode = 0; mode < 2; mode++) {
            sn_mesh mesh = ugly(i % 3, 17u + (uint64_t)i), out;
            sn_clean_params params = sn_clean_defaults();
            sn_clean_report report;
            params.keep = i % 2;
            params.full = mode == 1;
            assert_ok(clean_with(&mesh, &params, &out, &report));
            sn_index made = check_crossings(&mesh, &out, &report);
            if (mode > 0) assert_int_equal(made, 0); /* where all else fails there is a wrap */
            more += made > 0;
            undone += report.undone_crossings;
            finish(&mesh, &out, &report);
        }
    }
    assert_true(more <= 3 && undone > 100); /* more: of 6 by exact repair; the sheets cannot be closed without */
}

/* What asked for changes makes none either: sides of a plate that are nearer than the step is wide. */
static void no_step_pushes_one_side_through_the_other(void **state) {
    (void)state;
    for (int step = 0; step < 4; step++) {
        sn_mesh mesh = shape_sphere(24, 48), out;
        for (sn_index i = 0; i < mesh.vertex_count; i++) {
            sn_vec3 *p = &mesh.positions[i];
            p->z = 0.01 * p->z + 0.2 * sin(7.0 * p->x) * cos(5.0 * p->y);
        }
        sn_clean_params params = sn_clean_defaults();
        sn_clean_report report;
        params.edge_length = step == 0 ? 0.15 : 0.0;
        params.triangles = step == 1 ? 300 : 0;
        params.smooth = step == 2 ? 10 : 0;
        params.flip_slivers = step == 3;
        assert_ok(clean_with(&mesh, &params, &out, &report));
        assert_true(report.after.closed && report.after.manifold);
        if (!report.unchanged) check_crossings(&mesh, &out, &report);
        if (step >= 2) assert_int_equal(report.crossings_made, 0);
        if (step == 1) assert_true(out.triangle_count <= 300);
        finish(&mesh, &out, &report);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_input_comes_out_as_it_was),
        cmocka_unit_test(a_dirty_sphere_is_as_good_as_the_clean_one),
        cmocka_unit_test(cleaning_twice_changes_nothing_more),
        cmocka_unit_test(touching_bodies_are_not_welded),
        cmocka_unit_test(a_soup_of_separate_triangles_is_welded),
        cmocka_unit_test(inside_out_is_turned),
        cmocka_unit_test(a_doubled_surface_becomes_single),
        cmocka_unit_test(a_fin_does_not_open_the_surface),
        cmocka_unit_test(an_inner_wall_goes),
        cmocka_unit_test(a_one_sided_surface_is_reported),
        cmocka_unit_test(what_is_no_surface_is_a_clear_error),
        cmocka_unit_test(vertices_without_a_number_are_repaired_on_request),
        cmocka_unit_test(size_and_place_do_not_matter),
        cmocka_unit_test(each_step_can_be_the_last),
        cmocka_unit_test(random_soups_do_no_harm),
        cmocka_unit_test(repair_makes_no_crossings_or_says_so),
        cmocka_unit_test(no_step_pushes_one_side_through_the_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
