/* test_repair.c -- welding, bad triangles, manifolds, holes, decimation, crossings, distance of surfaces. */
#include "shapes.h"

/* A cylinder of slits: two hemispheres whose equators are separate vertices `gap` apart. */
static sn_mesh cracked_sphere(double gap) {
    enum { ROWS = 11, COLUMNS = 24, EQUATOR = 5 };
    sn_mesh sphere = shape_sphere(ROWS, COLUMNS), mesh = shape_empty(sphere.vertex_count + COLUMNS, sphere.triangle_count);
    memcpy(mesh.positions, sphere.positions, (size_t)sphere.vertex_count * sizeof *mesh.positions);
    memcpy(mesh.triangles, sphere.triangles, (size_t)sphere.triangle_count * sizeof *mesh.triangles);
    for (sn_index c = 0; c < COLUMNS; c++) {
        mesh.positions[sphere.vertex_count + c] = sn_add(sphere.positions[EQUATOR * COLUMNS + c], sn_v3(0, 0, -gap));
    }
    for (sn_index t = 0; t < mesh.triangle_count; t++) {
        sn_triangle *triangle = &mesh.triangles[t];
        double z = 0.0;
        for (int k = 0; k < 3; k++) z += sphere.positions[triangle->v[k]].z;
        for (int k = 0; z < 0.0 && k < 3; k++) {
            sn_index on_equator = triangle->v[k] - EQUATOR * COLUMNS;
            if (on_equator >= 0 && on_equator < COLUMNS) triangle->v[k] = sphere.vertex_count + on_equator;
        }
    }
    sn_mesh_free(&sphere);
    return mesh;
}

/* ---- weld ----------------------------------------------------------------------------------------------------------- */

static void a_crack_within_tolerance_closes(void **state) {
    (void)state;
    sn_mesh mesh = cracked_sphere(1e-7);
    assert_int_equal(shape_inspect(&mesh).boundary_loops, 2);
    sn_index welded = 0, *map = SN_NEW(sn_index, mesh.vertex_count);
    assert_ok(sn_weld(&mesh, 1e-8, &welded, map, NULL));
    assert_int_equal(welded, 0);
    assert_ok(sn_weld(&mesh, 1e-6, &welded, map, NULL));
    assert_int_equal(welded, 24);
    assert_int_equal(map[5 * 24 + 3], map[11 * 24 + 2 + 3]); /* the lowest index of each pair stands for it */
    assert_int_equal(map[5 * 24 + 3], 5 * 24 + 3);
    assert_true(shape_is_sound(&mesh));
    free(map);
    sn_mesh_free(&mesh);
}

static void welding_leaves_clean_input_as_it_is(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), copy;
    assert_ok(sn_mesh_copy(&sphere, &copy, NULL));
    sn_index welded = -1;
    assert_ok(sn_weld(&copy, 1e-6, &welded, NULL, NULL));
    assert_int_equal(welded, 0);
    assert_true(shape_same(&sphere, &copy));
    sn_mesh_free(&copy);
    sn_mesh_free(&sphere);
}

/* Points in a row, each within reach of the next: survivors are farther apart than the tolerance, and no chain eats them all. */
static void welding_does_not_follow_chains(void **state) {
    (void)state;
    enum { N = 100 };
    sn_mesh row = shape_empty(N, 0);
    for (sn_index i = 0; i < N; i++) row.positions[i] = sn_v3(0.6 * i, 0, 0);
    sn_index welded = 0;
    assert_ok(sn_weld(&row, 1.0, &welded, NULL, NULL));
    assert_int_equal(row.vertex_count, N / 2);
    for (sn_index i = 0; i + 1 < row.vertex_count; i++) assert_true(sn_distance(row.positions[i], row.positions[i + 1]) > 1.0);
    sn_mesh_free(&row);
}

/* Against every pair: a point goes to the lowest survivor within reach. */
static void welding_agrees_with_all_pairs(void **state) {
    (void)state;
    enum { N = 400 };
    uint64_t seed = 3;
    for (int round = 0; round < 4; round++) {
        double tolerance = round == 0 ? 0.0 : 0.02 * round;
        sn_mesh cloud = shape_empty(N, 0);
        for (sn_index i = 0; i < N; i++) {
            cloud.positions[i] = sn_v3(sn_random(&seed) - 0.5, sn_random(&seed) - 0.5, 0.1 * sn_random(&seed));
            if (i % 7 == 6) cloud.positions[i] = cloud.positions[i - 6];
        }
        sn_index expected[N], map[N], welded, count = 0, survivor[N];
        for (sn_index i = 0; i < N; i++) {
            sn_index j = 0;
            while (j < count && sn_distance(cloud.positions[survivor[j]], cloud.positions[i]) > tolerance) j++;
            if (j == count) survivor[count++] = i;
            expected[i] = j;
        }
        assert_ok(sn_weld(&cloud, tolerance, &welded, map, NULL));
        assert_int_equal(welded, N - count);
        for (sn_index i = 0; i < N; i++) assert_int_equal(map[i], expected[i]);
        sn_mesh_free(&cloud);
    }
}

static void minus_zero_is_zero(void **state) {
    (void)state;
    sn_mesh pair = shape_empty(2, 0);
    pair.positions[1] = sn_v3(-0.0, 0.0, -0.0);
    sn_index welded = 0;
    assert_ok(sn_weld(&pair, 0.0, &welded, NULL, NULL));
    assert_int_equal(welded, 1);
    sn_mesh_free(&pair);
}

static void attributes_follow_their_vertices(void **state) {
    (void)state;
    sn_mesh mesh = cracked_sphere(1e-9);
    sn_attribute *paint = sn_mesh_add_attribute(&mesh, "height", 1);
    for (sn_index i = 0; i < mesh.vertex_count; i++) paint->values[i] = mesh.positions[i].z;
    sn_index welded = 0, dropped = 0;
    assert_ok(sn_weld(&mesh, 1e-6, &welded, NULL, NULL));
    shape_drop(&mesh, 0);
    bool keep[528] = {false};
    for (sn_index t = 100; t < 400; t++) keep[t] = true;
    sn_mesh_keep_triangles(&mesh, keep);
    assert_ok(sn_drop_unused_vertices(&mesh, &dropped, NULL));
    assert_true(dropped > 0);
    for (sn_index i = 0; i < mesh.vertex_count; i++) assert_near(mesh.attributes[0].values[i], mesh.positions[i].z, 1e-8);
    sn_mesh_free(&mesh);
}

/* ---- bad triangles -------------------------------------------------------------------------------------------------- */

static void duplicates_go_whatever_their_order(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), mesh = shape_empty(8, 15);
    memcpy(mesh.positions, cube.positions, 8 * sizeof *mesh.positions);
    memcpy(mesh.triangles, cube.triangles, 12 * sizeof *mesh.triangles);
    mesh.triangles[12] = (sn_triangle){{2, 1, 0}}; /* as number 0, turned round */
    mesh.triangles[13] = (sn_triangle){{1, 2, 0}}; /* turned over */
    mesh.triangles[14] = (sn_triangle){{4, 4, 5}};
    sn_index degenerate = 0, duplicate = 0;
    assert_ok(sn_drop_bad_triangles(&mesh, &degenerate, &duplicate, NULL));
    assert_int_equal(duplicate, 2);
    assert_int_equal(degenerate, 1);
    assert_true(shape_same(&mesh, &cube));
    sn_mesh_free(&mesh);
    sn_mesh_free(&cube);
}

/* A vertex in the middle of an edge with a triangle of no area beside it: flipping keeps the surface closed. */
static void a_cap_gives_way_without_a_crack(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), mesh = shape_empty(9, 14);
    memcpy(mesh.positions, cube.positions, 8 * sizeof *mesh.positions);
    memcpy(mesh.triangles, cube.triangles, 12 * sizeof *mesh.triangles);
    mesh.positions[8] = sn_v3(0.5, 0, 0); /* on the edge 0-1; of its two triangles only 0 2 1 is split there */
    mesh.triangles[0] = (sn_triangle){{0, 2, 8}};
    mesh.triangles[12] = (sn_triangle){{8, 2, 1}};
    mesh.triangles[13] = (sn_triangle){{0, 8, 1}};
    assert_true(shape_inspect(&mesh).closed);
    assert_int_equal(shape_inspect(&mesh).degenerate_triangles, 1);
    sn_index degenerate = 0, duplicate = 0;
    assert_ok(sn_drop_bad_triangles(&mesh, &degenerate, &duplicate, NULL));
    assert_int_equal(degenerate, 1);
    assert_int_equal(mesh.triangle_count, 14);
    assert_true(shape_is_sound(&mesh));
    assert_near(sn_mesh_volume(&mesh), 1.0, 1e-12);
    sn_mesh_free(&mesh);
    sn_mesh_free(&cube);
}

static void vertices_without_a_number_go_with_their_triangles(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    cube.positions[6].z = NAN;
    sn_index dropped = 0;
    assert_ok(sn_drop_nonfinite_vertices(&cube, &dropped, NULL));
    assert_int_equal(dropped, 1);
    assert_int_equal(cube.vertex_count, 7);
    assert_int_equal(cube.triangle_count, 12 - 5);
    assert_ok(sn_mesh_validate(&cube, NULL));
    sn_mesh_free(&cube);
}

/* ---- manifold ------------------------------------------------------------------------------------------------------- */

static void a_manifold_comes_back_unchanged(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), copy;
    assert_ok(sn_mesh_copy(&sphere, &copy, NULL));
    sn_manifold_report report;
    assert_ok(sn_make_manifold(&copy, &report, NULL));
    assert_true(shape_same(&sphere, &copy) && report.orientable);
    assert_int_equal(report.flipped + report.split_vertices + report.stitched_edges, 0);
    sn_mesh_free(&copy);
    sn_mesh_free(&sphere);
}

/* Vertices, their order and their coordinates stay; only the turned triangles change, and the surface is as it was. */
static void a_turned_patch_is_turned_back(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), copy;
    assert_ok(sn_mesh_copy(&sphere, &copy, NULL));
    for (sn_index t = 100; t < 160; t++) shape_flip(&copy, t);
    sn_manifold_report report;
    assert_ok(sn_make_manifold(&copy, &report, NULL));
    assert_int_equal(report.flipped, 60);
    assert_int_equal(report.split_vertices, 0);
    assert_int_equal(copy.vertex_count, sphere.vertex_count);
    assert_memory_equal(copy.positions, sphere.positions, (size_t)sphere.vertex_count * sizeof *sphere.positions);
    assert_memory_equal(copy.triangles, sphere.triangles, 100 * sizeof *sphere.triangles);
    assert_true(shape_is_sound(&copy));
    assert_near(sn_mesh_volume(&copy), sn_mesh_volume(&sphere), 1e-12);
    sn_mesh_free(&copy);
    sn_mesh_free(&sphere);
}

/* Two cubes that share an edge: four triangles on it. Cut apart, each is closed. */
static void cubes_on_a_common_edge_come_apart(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(1, 1, 0));
    sn_attribute *paint = sn_mesh_add_attribute(&two, "x", 1);
    sn_index welded = 0;
    assert_ok(sn_weld(&two, 1e-9, &welded, NULL, NULL));
    for (sn_index i = 0; i < two.vertex_count; i++) paint->values[i] = two.positions[i].x;
    assert_int_equal(welded, 2);
    assert_int_equal(shape_inspect(&two).nonmanifold_edges, 1);
    sn_manifold_report report;
    assert_ok(sn_make_manifold(&two, &report, NULL));
    sn_mesh_report after = shape_inspect(&two);
    assert_true(after.manifold && after.oriented && after.closed);
    assert_int_equal(after.components, 2);
    assert_int_equal(report.split_vertices, 2);
    assert_near(after.volume, 2.0, 1e-12);
    for (sn_index i = 0; i < two.vertex_count; i++) assert_near(two.attributes[0].values[i], two.positions[i].x, 0.0);
    sn_mesh_free(&two);
    sn_mesh_free(&cube);
}

static void a_moebius_strip_is_called_one_sided(void **state) {
    (void)state;
    sn_mesh strip = shape_moebius(30);
    sn_manifold_report report;
    assert_ok(sn_make_manifold(&strip, &report, NULL));
    assert_false(report.orientable);
    assert_int_equal(shape_inspect(&strip).inconsistent_edges, 0);
    sn_mesh_free(&strip);
}

/* ---- holes ------------------------------------------------------------------------------------------------------------ */

static void holes_are_filled_and_recounted(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40);
    double volume = sn_mesh_volume(&sphere);
    sn_attribute *paint = sn_mesh_add_attribute(&sphere, "one", 1);
    for (sn_index i = 0; i < sphere.vertex_count; i++) paint->values[i] = 1.0;
    shape_drop(&sphere, 900);
    shape_drop(&sphere, 411);
    shape_drop(&sphere, 410);
    sn_index filled = 0, left = -1;
    assert_ok(sn_fill_holes(&sphere, 3, NULL, &filled, &left, NULL));
    assert_int_equal(filled, 1);
    assert_int_equal(left, 4); /* the other hole has four edges */
    assert_ok(sn_fill_holes(&sphere, 0, NULL, &filled, &left, NULL));
    assert_int_equal(filled, 1);
    assert_int_equal(left, 0);
    assert_true(shape_is_sound(&sphere));
    assert_near(sn_mesh_volume(&sphere), volume, 1e-3);
    for (sn_index i = 0; i < sphere.vertex_count; i++) assert_near(sphere.attributes[0].values[i], 1.0, 0.0);
    sn_mesh_free(&sphere);
}

/* A half sphere: one hole of as many edges as there are columns; closed, it has half the volume. */
static void a_half_sphere_gets_its_lid(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(39, 400);
    bool *keep = SN_NEW(bool, sphere.triangle_count);
    for (sn_index t = 0; t < sphere.triangle_count; t++) {
        const sn_index *v = sphere.triangles[t].v;
        keep[t] = sphere.positions[v[0]].z + sphere.positions[v[1]].z + sphere.positions[v[2]].z > 0.0;
    }
    double whole = sn_mesh_volume(&sphere);
    sn_mesh_keep_triangles(&sphere, keep);
    sn_index filled = 0, left = -1;
    assert_ok(sn_fill_holes(&sphere, 0, NULL, &filled, &left, NULL));
    assert_int_equal(filled, 1);
    assert_int_equal(left, 0);
    assert_near(sn_mesh_volume(&sphere), 0.5 * whole, 1e-9);
    free(keep);
    sn_mesh_free(&sphere);
}

static void filling_stops_where_the_trace_asks(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40);
    shape_drop(&sphere, 900);
    shape_drop(&sphere, 410);
    sn_trace trace = {.stop_after = 1};
    sn_index filled = 0, left = -1;
    assert_int_equal(sn_fill_holes(&sphere, 0, &trace, &filled, &left, NULL), SN_STOPPED);
    assert_int_equal(filled, 1);
    assert_int_equal(left, 3);
    assert_ok(sn_mesh_validate(&sphere, NULL));
    sn_mesh_free(&sphere);
}

/* ---- decimation ------------------------------------------------------------------------------------------------------- */

static void decimation_reaches_its_target_and_keeps_the_shape(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(40, 80), fine;
    sn_attribute *paint = sn_mesh_add_attribute(&sphere, "z", 1);
    for (sn_index i = 0; i < sphere.vertex_count; i++) paint->values[i] = sphere.positions[i].z;
    assert_ok(sn_mesh_copy(&sphere, &fine, NULL));
    assert_ok(sn_decimate(&sphere, 1000, NULL, NULL));
    assert_true(sphere.triangle_count <= 1000 && sphere.triangle_count >= 990);
    assert_true(shape_is_sound(&sphere));
    assert_near(sn_mesh_volume(&sphere) / sn_mesh_volume(&fine), 1.0, 0.01);
    double lost = INFINITY, gained = INFINITY;
    assert_ok(sn_one_sided_distance(&fine, &sphere, &lost, NULL));
    assert_ok(sn_one_sided_distance(&sphere, &fine, &gained, NULL));
    assert_true(fmax(lost, gained) < 0.02);
    for (sn_index i = 0; i < sphere.vertex_count; i++) assert_near(sphere.attributes[0].values[i], sphere.positions[i].z, 0.02);
    sn_mesh_free(&fine);
    sn_mesh_free(&sphere);
}

static void decimation_is_the_same_every_time(void **state) {
    (void)state;
    sn_mesh first = shape_sphere(30, 60), second = shape_sphere(30, 60);
    assert_ok(sn_decimate(&first, 500, NULL, NULL));
    assert_ok(sn_decimate(&second, 500, NULL, NULL));
    assert_true(shape_same(&first, &second));
    assert_int_equal(sn_decimate(&first, 3, NULL, NULL), SN_ERROR_USAGE);
    sn_mesh_free(&second);
    sn_mesh_free(&first);
}

/* ---- crossings and distance -------------------------------------------------------------------------------------------- */

static void crossings_are_counted_exactly(void **state) {
    (void)state;
    const sn_vec3 positions[] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0.5, 0.5, -1}, {0.5, 0.5, 1},
                                 {3, 3, 0}, {0, 0, 5}, {1, 0, 5}, {0, 1, 5}};
    const sn_triangle triangles[] = {{{0, 1, 2}}, {{3, 4, 5}}, {{6, 7, 8}}};
    sn_mesh mesh = shape_of(9, positions, 3, triangles);
    sn_index pairs = -1;
    assert_ok(sn_count_self_intersections(&mesh, &pairs, NULL));
    assert_int_equal(pairs, 1);
    sn_mesh_free(&mesh);
}

/* Neighbours share a corner or an edge: no crossing, until one is folded flat onto the other. */
static void neighbours_do_not_cross_unless_folded(void **state) {
    (void)state;
    const sn_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, -1, 0}, {0.9, 0.9, 0}, {0.2, 0.2, -1}};
    const sn_triangle flat[] = {{{0, 1, 2}}, {{1, 0, 3}}}, folded[] = {{{0, 1, 2}}, {{1, 0, 4}}}, corner[] = {{{0, 1, 2}}, {{2, 4, 5}}};
    const struct {
        const sn_triangle *triangles;
        sn_index pairs;
    } cases[] = {{flat, 0}, {folded, 1}, {corner, 0}};
    for (int i = 0; i < 3; i++) {
        sn_mesh mesh = shape_of(6, positions, 2, cases[i].triangles);
        sn_index pairs = -1;
        assert_ok(sn_count_self_intersections(&mesh, &pairs, NULL));
        assert_int_equal(pairs, cases[i].pairs);
        sn_mesh_free(&mesh);
    }
    sn_mesh sphere = shape_sphere(20, 40), two = shape_join(&sphere, &sphere, 1.0, sn_v3(1, 0.1, 0.2));
    sn_index pairs = -1;
    assert_ok(sn_count_self_intersections(&sphere, &pairs, NULL));
    assert_int_equal(pairs, 0);
    assert_ok(sn_count_self_intersections(&two, &pairs, NULL));
    assert_true(pairs > 40); /* the two spheres cut each other along a circle */
    sn_mesh_free(&two);
    sn_mesh_free(&sphere);
}

/* Two cubes on a common corner touch; with their own vertices there they still do no more. */
static void touching_is_not_crossing(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(1, 1, 1));
    sn_index pairs = -1;
    assert_ok(sn_count_self_intersections(&two, &pairs, NULL));
    assert_int_equal(pairs, 0);
    for (sn_index i = 0; i < two.vertex_count; i++) two.positions[i] = sn_add(two.positions[i], sn_v3(1e3, -0.1, 1.0 / 3.0));
    assert_ok(sn_count_self_intersections(&two, &pairs, NULL));
    assert_int_equal(pairs, 0);
    sn_mesh_free(&two);
    two = shape_join(&cube, &cube, 1.0, sn_v3(0.5, 0.5, 0.5));
    bool made[24] = {false}, crosses[24] = {false};
    made[0] = true; /* at z = 0, where the second cube is not */
    assert_ok(sn_find_self_intersections(&two, 0, made, crosses, &pairs, NULL));
    assert_true(pairs > 6);
    for (int t = 0; t < 24; t++) assert_false(crosses[t]);
    assert_ok(sn_find_self_intersections(&two, 0, NULL, crosses, &pairs, NULL));
    assert_true(crosses[2] && !crosses[0]);
    assert_ok(sn_find_self_intersections(&two, 5, NULL, NULL, &pairs, NULL)); /* given up */
    assert_int_equal(pairs, SN_NONE);
    sn_mesh_free(&two);
    sn_mesh_free(&cube);
}

static void new_triangles_are_told_from_old_ones(void **state) {
    (void)state;
    sn_mesh old = shape_cube(), mesh = shape_join(&old, &old, 1.0, sn_v3(0, 0, 0));
    bool is_new[24];
    shape_flip(&mesh, 3); /* turned round, or on other vertices at its place: the same */
    assert_ok(sn_find_new_triangles(&old, &mesh, is_new, NULL));
    for (int t = 0; t < 24; t++) assert_int_equal(is_new[t], t >= 12); /* one stands for one */
    mesh.positions[0].x -= 0.5;
    assert_ok(sn_find_new_triangles(&old, &mesh, is_new, NULL));
    for (int t = 0; t < 12; t++) {
        const sn_index *v = mesh.triangles[t].v;
        assert_int_equal(is_new[t], v[0] == 0 || v[1] == 0 || v[2] == 0);
    }
    sn_mesh_free(&mesh);
    sn_mesh_free(&old);
}

/* A spike pushed through the other side of a sphere is new: it is cut off, and the sphere is whole again. */
static void a_spike_that_repair_has_made_is_taken_back(void **state) {
    (void)state;
    sn_mesh before = shape_sphere(20, 40), mesh = shape_sphere(20, 40);
    mesh.positions[200] = sn_scale(mesh.positions[200], -1.5);
    sn_index pairs = 0, left = -1;
    assert_ok(sn_count_self_intersections(&mesh, &pairs, NULL));
    assert_true(pairs > 0);
    sn_undo_params params = {&before, 0.1 * sn_mesh_area(&before), 0.05};
    assert_ok(sn_undo_crossings(&mesh, &params, &left, NULL));
    assert_int_equal(left, 0);
    assert_true(shape_is_sound(&mesh));
    assert_near(sn_mesh_volume(&mesh), sn_mesh_volume(&before), 0.02 * sn_mesh_volume(&before));
    sn_mesh_free(&mesh);
    sn_mesh_free(&before);
}

static void the_distance_of_a_moved_cube_is_the_move(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), moved = shape_cube();
    for (sn_index i = 0; i < 8; i++) moved.positions[i].x += 0.25;
    double distance = -1.0;
    assert_ok(sn_one_sided_distance(&cube, &moved, &distance, NULL));
    assert_near(distance, 0.25, 1e-12);
    assert_ok(sn_one_sided_distance(&cube, &cube, &distance, NULL));
    assert_near(distance, 0.0, 1e-12);
    sn_mesh_free(&moved);
    sn_mesh_free(&cube);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_crack_within_tolerance_closes),
        cmocka_unit_test(welding_leaves_clean_input_as_it_is),
        cmocka_unit_test(welding_does_not_follow_chains),
        cmocka_unit_test(welding_agrees_with_all_pairs),
        cmocka_unit_test(minus_zero_is_zero),
        cmocka_unit_test(attributes_follow_their_vertices),
        cmocka_unit_test(duplicates_go_whatever_their_order),
        cmocka_unit_test(a_cap_gives_way_without_a_crack),
        cmocka_unit_test(vertices_without_a_number_go_with_their_triangles),
        cmocka_unit_test(a_manifold_comes_back_unchanged),
        cmocka_unit_test(a_turned_patch_is_turned_back),
        cmocka_unit_test(cubes_on_a_common_edge_come_apart),
        cmocka_unit_test(a_moebius_strip_is_called_one_sided),
        cmocka_unit_test(holes_are_filled_and_recounted),
        cmocka_unit_test(a_half_sphere_gets_its_lid),
        cmocka_unit_test(filling_stops_where_the_trace_asks),
        cmocka_unit_test(decimation_reaches_its_target_and_keeps_the_shape),
        cmocka_unit_test(decimation_is_the_same_every_time),
        cmocka_unit_test(crossings_are_counted_exactly),
        cmocka_unit_test(neighbours_do_not_cross_unless_folded),
        cmocka_unit_test(touching_is_not_crossing),
        cmocka_unit_test(new_triangles_are_told_from_old_ones),
        cmocka_unit_test(a_spike_that_repair_has_made_is_taken_back),
        cmocka_unit_test(the_distance_of_a_moved_cube_is_the_move),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
