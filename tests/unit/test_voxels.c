/* test_voxels.c -- voxels of a surface: how many, which are marked and enclosed, and the way out of them. */
#include "shapes.h"

#include "sinew/voxels.h"

static sn_voxels voxels_of(const sn_mesh *mesh, const sn_index size[3]) {
    sn_voxels v;
    assert_ok(sn_voxels_create(mesh, size, &v, NULL));
    assert_ok(sn_voxels_fill(&v, NULL));
    return v;
}

static sn_voxels cubed(const sn_mesh *mesh, sn_index n) {
    sn_index size[3];
    sn_voxels_along(sn_mesh_box(mesh), n, size);
    return voxels_of(mesh, size);
}

static void place(sn_mesh *mesh, double scale, sn_vec3 move) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) mesh->positions[v] = sn_add_scaled(move, mesh->positions[v], scale);
}

static sn_vec3 random_point(double reach, uint64_t *state) {
    return sn_scale(sn_v3(sn_random(state) - 0.5, sn_random(state) - 0.5, sn_random(state) - 0.5), 2.0 * reach);
}

/* ---- sizes ------------------------------------------------------------------------------------------------------------------------ */

static void assert_size(const sn_index size[3], sn_index x, sn_index y, sn_index z) {
    assert_int_equal(size[0], x);
    assert_int_equal(size[1], y);
    assert_int_equal(size[2], z);
}

/* [K21] fig. 3: boxes as long as its counts for 262144 and 8 times as many leave open. */
static void test_sizes_are_those_of_the_paper(void **state) {
    const sn_box pelvis = {{0, 0, 0}, {0.0477, 0.0642, 262.144e-6 / (0.0477 * 0.0642)}};
    const sn_box femur = {{-1, 5, 0}, {-1 + 0.04275, 5 + 0.1762, 262.144e-6 / (0.04275 * 0.1762)}};
    sn_index size[3];
    (void)state;
    sn_voxels_in_all(pelvis, 262144, size);
    assert_size(size, 47, 64, 85);
    sn_voxels_in_all(pelvis, 8 * 262144, size);
    assert_size(size, 95, 128, 171);
    sn_voxels_in_all(femur, 262144, size);
    assert_size(size, 42, 176, 34);
    sn_voxels_in_all(femur, 8 * 262144, size);
    assert_size(size, 85, 352, 69);
}

/* Whole numbers are not lost to rounding; flat and thin boxes have one layer, and never more than was asked for. */
static void test_sizes_of_odd_boxes(void **state) {
    sn_index size[3];
    (void)state;
    for (sn_index n = 1; n <= 200; n++) {
        sn_voxels_in_all((sn_box){{0.1, 0.2, 0.3}, {0.1 + 0.3, 0.2 + 0.3, 0.3 + 0.3}}, n * n * n, size);
        assert_size(size, n, n, n);
    }
    sn_voxels_in_all((sn_box){{0, 0, 0}, {3, 0, 1}}, 300, size);
    assert_size(size, 30, 1, 10);
    sn_voxels_in_all((sn_box){{0, 0, 0}, {1, 1, 1e-9}}, 1000000, size);
    assert_size(size, 1000, 1000, 1);
    sn_voxels_in_all((sn_box){{0, 0, 0}, {1e-9, 1, 1e-12}}, 1000, size);
    assert_size(size, 1, 1000, 1);
    sn_voxels_in_all((sn_box){{0, 0, 0}, {0, 0, 0}}, 1000, size);
    assert_size(size, 1, 1, 1);
    sn_voxels_along((sn_box){{0, 0, 0}, {1, 0, 2}}, 64, size);
    assert_size(size, 64, 1, 64);
}

/* ---- what is marked ---------------------------------------------------------------------------------------------------------------- */

/* The boundary of a box is its outer layer, wherever the box lies; the rest is inside. */
static void test_box(void **state) {
    uint64_t random = 7;
    (void)state;
    for (int i = 0; i < 60; i++) {
        sn_mesh cube = shape_cube();
        place(&cube, 1.0 / (1 + i), i == 0 ? sn_v3(0, 0, 0) : random_point(i < 30 ? 1.0 : 1000.0, &random));
        sn_index n = 3 + i % 14;
        sn_voxels v = cubed(&cube, n);
        assert_int_equal(v.inside, (n - 2) * (n - 2) * (n - 2));
        assert_int_equal(v.boundary, n * n * n - v.inside);
        assert_int_equal(sn_voxels_count(&v), n * n * n);
        assert_true(sn_voxels_bytes(&v) <= (size_t)(n * n * n / 8 + 1));
        assert_true(sn_voxels_at(&v, v.box.low) && sn_voxels_at(&v, v.box.high));
        assert_false(sn_voxels_at(&v, sn_add(v.box.high, sn_scale(v.cell, 0.01))));
        assert_true(sn_voxels_touch(&v, sn_add_scaled(sn_lerp(v.box.low, v.box.high, 0.5), sn_v3(v.cell.x, 0, 0), n / 2.0 + 0.9)));
        assert_false(sn_voxels_touch(&v, sn_add_scaled(sn_lerp(v.box.low, v.box.high, 0.5), sn_v3(v.cell.x, 0, 0), n / 2.0 + 1.1)));
        sn_voxels_free(&v);
        sn_mesh_free(&cube);
    }
}

/* Enclosed cells are within the ball, the ball is within the marked ones, and each point farther than a cell's diagonal is told right. */
static void test_sphere(void **state) {
    sn_mesh sphere = shape_sphere(60, 120);
    sn_voxels v = cubed(&sphere, 64);
    double cell = v.cell.x * v.cell.y * v.cell.z, volume = sn_mesh_volume(&sphere), diagonal = sn_norm(v.cell);
    uint64_t random = 3;
    (void)state;
    assert_true(v.inside * cell < volume && volume < (v.inside + v.boundary) * cell);
    assert_true(v.boundary * cell < 2.0 * diagonal * sn_mesh_area(&sphere));
    for (int i = 0; i < 20000; i++) {
        sn_vec3 p = random_point(1.2, &random);
        double distance = sn_norm(p) - 1.0;
        if (distance > diagonal) assert_false(sn_voxels_at(&v, p));
        if (distance < -0.01) assert_true(sn_voxels_at(&v, p)); /* the facets lie within 0.01 of the sphere */
    }
    sn_voxels_free(&v);
    sn_mesh_free(&sphere);
}

/* A wide hole lets the fill in: a cup has its walls alone; a hole less than a cell wide does not; and a hollow within is the bone's. */
static void test_open_and_hollow(void **state) {
    sn_mesh cup = shape_sphere(60, 120), pricked = shape_sphere(60, 120), inner = shape_sphere(20, 40);
    (void)state;
    for (sn_index t = cup.triangle_count - 1; t >= 0; t--)
        if (cup.positions[cup.triangles[t].v[0]].z > 0.5) shape_drop(&cup, t);
    sn_voxels v = cubed(&cup, 32), whole = cubed(&pricked, 16);
    assert_int_equal(v.inside, 0);
    assert_true(v.boundary > 1000);
    assert_true(sn_voxels_at(&v, sn_v3(0, 0, -0.999)));
    assert_false(sn_voxels_at(&v, sn_v3(0, 0, 0)));
    sn_voxels_free(&v);
    shape_drop(&pricked, 60 * 60);
    v = cubed(&pricked, 16);
    assert_int_equal(v.inside, whole.inside);
    sn_voxels_free(&v);
    sn_mesh hollow = shape_join(&pricked, &inner, 0.5, sn_v3(0, 0, 0));
    v = cubed(&hollow, 16);
    assert_true(sn_voxels_at(&v, sn_v3(0, 0, 0)));
    assert_int_equal(v.inside + v.boundary, whole.inside + whole.boundary);
    sn_voxels_free(&v);
    sn_voxels_free(&whole);
    sn_mesh_free(&hollow);
    sn_mesh_free(&inner);
    sn_mesh_free(&pricked);
    sn_mesh_free(&cup);
}

/* A plate across its box, from edge to edge, parts what is outside in two: both are outside. */
static void test_outside_in_two_parts(void **state) {
    sn_mesh plate = shape_cube();
    (void)state;
    for (sn_index i = 0; i < plate.vertex_count; i++) {
        sn_vec3 *p = &plate.positions[i];
        *p = sn_v3(p->x + 0.1 * (p->y - 0.5), p->x - 0.1 * (p->y - 0.5), p->z);
    }
    sn_voxels v = cubed(&plate, 32);
    assert_true(sn_voxels_at(&v, sn_v3(0.5, 0.5, 0.5)));
    assert_false(sn_voxels_at(&v, sn_v3(0.8, 0.2, 0.5)));
    assert_false(sn_voxels_at(&v, sn_v3(0.2, 0.8, 0.5)));
    sn_voxels_free(&v);
    sn_mesh_free(&plate);
}

static void test_refusals(void **state) {
    const sn_index none[3] = {0, 4, 4}, many[3] = {1024, 1024, 1024}, some[3] = {4, 4, 4};
    sn_mesh cube = shape_cube(), empty = shape_empty(0, 0);
    sn_voxels v;
    sn_error error = {0};
    (void)state;
    assert_int_equal(sn_voxels_create(&cube, none, &v, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_voxels_create(&cube, many, &v, &error), SN_ERROR_USAGE);
    assert_non_null(strstr(error.text, "1073741824"));
    assert_int_equal(sn_voxels_create(&empty, some, &v, &error), SN_ERROR_INPUT);
    cube.positions[2].y = INFINITY;
    assert_int_equal(sn_voxels_create(&cube, some, &v, &error), SN_ERROR_INPUT);
    assert_false(sn_voxels_at(&(sn_voxels){0}, sn_v3(0, 0, 0)));
    sn_mesh_free(&cube);
    sn_mesh_free(&empty);
}

/* ---- the way out ------------------------------------------------------------------------------------------------------------------- */

/* Straight out of the unit cube in 8^3 cells: to the point itself where its cell is the first outside, else a thousandth into that. */
static void test_walk_to_the_first_free_cell(void **state) {
    const sn_vec3 from = {0.55, 0.4, 0.3};
    sn_mesh cube = shape_cube();
    sn_voxels v = cubed(&cube, 8);
    sn_vec3 out;
    (void)state;
    assert_false(sn_voxels_walk(&v, from, sn_v3(0.55, 0.4, 1.1), &out));
    assert_true(out.x == 0.55 && out.y == 0.4 && out.z == 1.1);
    assert_true(sn_voxels_walk(&v, from, sn_v3(0.55, 0.4, 1.2), &out));
    assert_true(out.x == 0.55 && out.y == 0.4);
    assert_near(out.z, 1.0 + 1e-3 / 8.0, 1e-12);
    assert_true(sn_voxels_walk(&v, from, sn_v3(-7.0, 0.4, 0.3), &out));
    assert_near(out.x, -1e-3 / 8.0, 1e-12);
    assert_true(sn_voxels_walk(&v, from, sn_v3(1e6, -1e6, 0.3), &out));
    assert_near(out.y, -1e-3 / 8.0 * sqrt(0.5), 1e-9);
    assert_false(sn_voxels_walk(&v, from, from, &out));
    assert_false(sn_voxels_walk(&v, from, sn_v3(NAN, 0, 0), &out));
    assert_true(sn_voxels_walk(&v, sn_v3(1, 1, 1), sn_v3(3, 3, 3), &out)); /* from the far corner, which is the last cell's */
    assert_near(out.z, 1.0 + 1e-3 / 8.0 / sqrt(3.0), 1e-9);
    sn_voxels_free(&v);
    sn_mesh_free(&cube);
}

/* Any segment out of a ball, in cells that are no cubes: what is passed is marked, what is reached is not, and lies on the segment. */
static void test_walks_out_of_a_ball(void **state) {
    const sn_index size[3] = {20, 31, 47};
    sn_mesh sphere = shape_sphere(30, 60);
    sn_voxels v = voxels_of(&sphere, size);
    uint64_t random = 11;
    int stopped = 0, all_the_way = 0;
    (void)state;
    for (int i = 0; i < 5000; i++) {
        sn_vec3 from = random_point(1.0, &random), to = random_point(1.3, &random), out;
        if (!sn_voxels_at(&v, from) || sn_voxels_at(&v, to)) continue;
        bool stops = sn_voxels_walk(&v, from, to, &out);
        stopped += stops, all_the_way += !stops;
        double length = sn_distance(from, to), gone = sn_distance(from, out), last = gone - 2e-3 * v.cell.x;
        assert_false(sn_voxels_at(&v, out));
        assert_near(sn_distance(sn_lerp(from, to, gone / length), out), 0.0, 1e-12);
        for (int k = 0; stops && k < 200; k++)
            if (last > 0.0) assert_true(sn_voxels_at(&v, sn_lerp(from, to, last * k / 200 / length)));
    }
    assert_true(stopped > 500 && all_the_way > 50);
    sn_voxels_free(&v);
    sn_mesh_free(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes_are_those_of_the_paper),
        cmocka_unit_test(test_sizes_of_odd_boxes),
        cmocka_unit_test(test_box),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_open_and_hollow),
        cmocka_unit_test(test_outside_in_two_parts),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_walk_to_the_first_free_cell),
        cmocka_unit_test(test_walks_out_of_a_ball),
    };
    return cmocka_run_group_tests_name("voxels", tests, NULL, NULL);
}
