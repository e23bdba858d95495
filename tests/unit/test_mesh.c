/* test_mesh.c -- storage, validation, measures and defects of a mesh. */
#include "shapes.h"

static void a_copy_owns_all_of_its_parts(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), copy;
    sn_attribute *paint = sn_mesh_add_attribute(&cube, "paint", 2);
    paint->values[15] = 0.25;
    paint->integer = true;
    cube.group_count = 1;
    cube.group_names = SN_NEW(char *, 1);
    cube.group_names[0] = sn_strdup("belly");
    cube.triangle_group = SN_NEW(sn_index, cube.triangle_count);
    cube.triangle_group[11] = SN_NONE;
    assert_ok(sn_mesh_copy(&cube, &copy, NULL));
    sn_mesh_free(&cube);
    assert_null(cube.positions);
    const sn_attribute *kept = sn_mesh_attribute(&copy, "paint");
    assert_non_null(kept);
    assert_true(kept->integer && kept->components == 2);
    assert_near(kept->values[15], 0.25, 0.0);
    assert_string_equal(copy.group_names[0], "belly");
    assert_int_equal(copy.triangle_group[11], SN_NONE);
    assert_null(sn_mesh_attribute(&copy, "other"));
    sn_mesh_free(&copy);
    sn_mesh_free(&copy); /* an empty mesh is fine */
}

static void kept_triangles_keep_order_and_groups(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    cube.group_count = 1;
    cube.group_names = SN_NEW(char *, 1);
    cube.triangle_group = SN_NEW(sn_index, cube.triangle_count);
    for (sn_index t = 0; t < cube.triangle_count; t++) cube.triangle_group[t] = t % 2 == 0 ? 0 : SN_NONE;
    bool keep[12] = {false, true, false, false, true};
    sn_mesh_keep_triangles(&cube, keep);
    assert_int_equal(cube.triangle_count, 2);
    assert_int_equal(cube.triangles[0].v[1], 3); /* number 1 was 0 3 2 */
    assert_int_equal(cube.triangle_group[0], SN_NONE);
    assert_int_equal(cube.triangle_group[1], 0);
    sn_mesh_free(&cube);
}

static void validation_names_the_first_offender(void **state) {
    (void)state;
    sn_error error = {.element = -1};
    sn_mesh cube = shape_cube();
    assert_ok(sn_mesh_validate(&cube, NULL));
    cube.positions[5].y = NAN;
    cube.positions[6].x = INFINITY;
    assert_int_equal(sn_mesh_validate(&cube, &error), SN_ERROR_INPUT);
    assert_int_equal(error.element, 5);
    cube.positions[5].y = cube.positions[6].x = 0.0;
    cube.triangles[7].v[2] = 8;
    assert_int_equal(sn_mesh_validate(&cube, &error), SN_ERROR_INPUT);
    assert_int_equal(error.element, 7);
    cube.triangles[7].v[2] = -1;
    assert_int_equal(sn_mesh_validate(&cube, &error), SN_ERROR_INPUT);
    cube.triangle_count = 0;
    assert_int_equal(sn_mesh_validate(&cube, &error), SN_ERROR_INPUT);
    cube.triangle_count = 12;
    sn_mesh_free(&cube);
}

/* The plain sum of p . (q x r) loses every digit at 1e9 from the origin: 1e27 times eps. */
static void measures_of_a_cube_hold_far_from_the_origin(void **state) {
    (void)state;
    const double far[] = {0.0, 1e3, 1e6, 1e9};
    for (int i = 0; i < 4; i++) {
        sn_mesh cube = shape_cube();
        for (sn_index v = 0; v < 8; v++) cube.positions[v] = sn_add(cube.positions[v], sn_v3(far[i], -far[i], far[i]));
        assert_near(sn_mesh_volume(&cube), 1.0, 1e-12);
        assert_near(sn_mesh_area(&cube), 6.0, 1e-12);
        assert_near(sn_box_diagonal(sn_mesh_box(&cube)), sqrt(3.0), 1e-12);
        sn_vec3 centroid = sn_mesh_volume_centroid(&cube);
        assert_near(sn_distance(centroid, sn_v3(far[i] + 0.5, 0.5 - far[i], far[i] + 0.5)), 0.0, 1e-6);
        sn_mesh_free(&cube);
    }
}

static void a_tetrahedron_has_its_centroid_at_the_mean_of_its_corners(void **state) {
    (void)state;
    const sn_vec3 positions[4] = {{0, 0, 0}, {3, 0, 0}, {0, 5, 0}, {0, 0, 7}};
    const sn_triangle triangles[4] = {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}};
    sn_mesh mesh = shape_of(4, positions, 4, triangles);
    assert_near(sn_mesh_volume(&mesh), 3.0 * 5.0 * 7.0 / 6.0, 1e-12);
    assert_near(sn_distance(sn_mesh_volume_centroid(&mesh), sn_v3(0.75, 1.25, 1.75)), 0.0, 1e-12);
    sn_mesh_free(&mesh);
}

/* The inscribed polyhedron's volume approaches 4/3 pi with the square of the spacing: twice as fine, a quarter of the error. */
static void a_sphere_converges_to_its_volume_with_second_order(void **state) {
    (void)state;
    double error[2];
    for (int i = 0; i < 2; i++) {
        sn_mesh sphere = shape_sphere(32 << i, 64 << i);
        error[i] = 4.0 / 3.0 * SN_PI - sn_mesh_volume(&sphere);
        sn_mesh_free(&sphere);
    }
    assert_true(error[1] > 0.0);
    assert_near(error[0] / error[1], 4.0, 0.2);
}

static void normals_of_a_sphere_point_outwards(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(40, 80);
    sn_vec3 *normals = SN_NEW(sn_vec3, sphere.vertex_count);
    sn_mesh_vertex_normals(&sphere, normals);
    for (sn_index v = 0; v < sphere.vertex_count; v++) {
        assert_near(sn_norm(normals[v]), 1.0, 1e-12);
        assert_true(sn_dot(normals[v], sphere.positions[v]) > 0.99);
    }
    free(normals);
    sn_mesh_free(&sphere);
}

static void an_empty_box_has_no_diagonal(void **state) {
    (void)state;
    sn_mesh none = {0};
    assert_near(sn_box_diagonal(sn_mesh_box(&none)), 0.0, 0.0);
    assert_near(sn_mesh_volume(&none), 0.0, 0.0);
    assert_near(sn_mesh_area(&none), 0.0, 0.0);
}

static void a_clean_sphere_has_no_defect(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20);
    sn_mesh_report r = shape_inspect(&sphere);
    assert_true(r.closed && r.manifold && r.oriented && r.outward);
    assert_int_equal(r.vertices, 202);
    assert_int_equal(r.triangles, 400);
    assert_int_equal(r.edges, 600);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.self_intersections, -1);
    assert_int_equal(r.boundary_edges + r.boundary_loops + r.nonmanifold_edges + r.nonmanifold_vertices + r.inconsistent_edges, 0);
    assert_int_equal(r.unused_vertices + r.duplicate_vertices + r.degenerate_triangles + r.duplicate_triangles, 0);
    assert_near(r.genus, 0.0, 0.0);
    assert_true(r.worst_quality > 0.0 && r.worst_quality < 1.0);
    sn_mesh_free(&sphere);
}

/* A grid closed both ways has Euler characteristic 0: a torus, genus 1. */
static void a_torus_has_genus_one(void **state) {
    (void)state;
    enum { N = 12 };
    sn_mesh mesh = shape_empty(N * N, 2 * N * N);
    for (sn_index i = 0; i < N; i++) {
        for (sn_index j = 0; j < N; j++) {
            double u = 2.0 * SN_PI * i / N, v = 2.0 * SN_PI * j / N, radius = 3.0 + cos(v);
            mesh.positions[i * N + j] = sn_v3(radius * cos(u), radius * sin(u), sin(v));
            sn_index a = i * N + j, b = (i + 1) % N * N + j, c = (i + 1) % N * N + (j + 1) % N, d = i * N + (j + 1) % N;
            mesh.triangles[2 * a] = (sn_triangle){{a, b, c}};
            mesh.triangles[2 * a + 1] = (sn_triangle){{a, c, d}};
        }
    }
    sn_mesh_report r = shape_inspect(&mesh);
    assert_near(r.genus, 1.0, 0.0);
    assert_true(r.outward);
    sn_mesh_free(&mesh);
}

static void each_defect_is_counted(void **state) {
    (void)state;
    const sn_vec3 positions[9] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {5, 5, 5}, {0, 1, 0}, {0.5, 0, 0}, {-1, 0, 0}};
    const sn_triangle triangles[] = {
        {{0, 1, 2}}, {{1, 0, 3}}, {{0, 1, 4}}, /* three on the edge 0-1 */
        {{2, 1, 0}},                           /* the first again, turned over */
        {{0, 0, 3}}, {{0, 7, 1}},              /* a repeated index; no area */
        {{0, 8, 8}},
    };
    sn_mesh mesh = shape_of(9, positions, 7, triangles);
    sn_mesh_report r = shape_inspect(&mesh);
    assert_int_equal(r.duplicate_triangles, 1);
    assert_int_equal(r.degenerate_triangles, 3);
    assert_int_equal(r.duplicate_vertices, 1); /* 6 is where 2 is */
    assert_int_equal(r.unused_vertices, 2);    /* 5 and 6 */
    assert_int_equal(r.nonmanifold_edges, 1);  /* 0-1 */
    assert_false(r.manifold);
    assert_true(isnan(r.genus));
    sn_mesh_free(&mesh);
}

static void two_fans_at_a_vertex_are_a_pinch(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(1, 1, 1));
    for (sn_index t = 12; t < 24; t++) {
        for (int k = 0; k < 3; k++) {
            if (two.triangles[t].v[k] == 8) two.triangles[t].v[k] = 6; /* the corner where they touch */
        }
    }
    sn_mesh_report r = shape_inspect(&two);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.nonmanifold_edges, 0);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_true(r.closed && !r.manifold);
    sn_mesh_free(&two);
    sn_mesh_free(&cube);
}

static void holes_and_turned_triangles_are_counted(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20);
    shape_flip(&sphere, 7);
    shape_drop(&sphere, 310);
    shape_drop(&sphere, 110);
    sn_mesh_report r = shape_inspect(&sphere);
    assert_int_equal(r.boundary_edges, 6);
    assert_int_equal(r.boundary_loops, 2);
    assert_int_equal(r.inconsistent_edges, 3);
    assert_false(r.closed || r.oriented);
    sn_mesh_free(&sphere);
}

static void a_cavity_is_not_inside_out(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(8, 16), inner = shape_sphere(8, 16);
    for (sn_index t = 0; t < inner.triangle_count; t++) shape_flip(&inner, t);
    sn_mesh hollow = shape_join(&sphere, &inner, 0.5, sn_v3(0, 0, 0)), apart = shape_join(&sphere, &inner, 0.5, sn_v3(4, 0, 0));
    assert_true(shape_inspect(&hollow).outward);
    assert_false(shape_inspect(&apart).outward);
    sn_index flipped = -1;
    assert_ok(sn_orient_outward(&hollow, &flipped, NULL));
    assert_int_equal(flipped, 0);
    assert_ok(sn_orient_outward(&apart, &flipped, NULL));
    assert_int_equal(flipped, 1);
    assert_true(shape_inspect(&apart).outward);
    sn_mesh_free(&apart);
    sn_mesh_free(&hollow);
    sn_mesh_free(&inner);
    sn_mesh_free(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_owns_all_of_its_parts),
        cmocka_unit_test(kept_triangles_keep_order_and_groups),
        cmocka_unit_test(validation_names_the_first_offender),
        cmocka_unit_test(measures_of_a_cube_hold_far_from_the_origin),
        cmocka_unit_test(a_tetrahedron_has_its_centroid_at_the_mean_of_its_corners),
        cmocka_unit_test(a_sphere_converges_to_its_volume_with_second_order),
        cmocka_unit_test(normals_of_a_sphere_point_outwards),
        cmocka_unit_test(an_empty_box_has_no_diagonal),
        cmocka_unit_test(a_clean_sphere_has_no_defect),
        cmocka_unit_test(a_torus_has_genus_one),
        cmocka_unit_test(each_defect_is_counted),
        cmocka_unit_test(two_fans_at_a_vertex_are_a_pinch),
        cmocka_unit_test(holes_and_turned_triangles_are_counted),
        cmocka_unit_test(a_cavity_is_not_inside_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
