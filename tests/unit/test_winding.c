/*
 * test_winding.c -- winding numbers and closest points on one triangle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "sinew/geom.h"

#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static double between(uint64_t *seed, double low, double high) { return low + (high - low) * sn_random(seed); }
static sn_vec3 random_point(uint64_t *seed, double half) {
    double x = between(seed, -half, half), y = between(seed, -half, half), z = between(seed, -half, half);
    return sn_v3(x, y, z);
}

/* ---- closest point ---------------------------------------------------------------------------------------------------- */

/* q is the point of the convex hull of the corners closest to p if and only if (p - q).(x - q) <= 0 for every corner x. */
static void assert_closest(sn_vec3 p, const sn_vec3 corner[3], double tolerance) {
    double w[3];
    sn_vec3 q = sn_closest_on_triangle(p, corner[0], corner[1], corner[2], w);
    double size = 0, sum = 0;
    sn_vec3 combined = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        assert_true(w[k] >= 0.0 && w[k] <= 1.0);
        sum += w[k];
        combined = sn_add_scaled(combined, corner[k], w[k]);
        size = fmax(size, fmax(sn_distance(corner[k], corner[(k + 1) % 3]), sn_distance(p, corner[k])));
    }
    assert_near(sum, 1.0, 1e-12);
    assert_true(sn_distance(combined, q) <= 1e-14 * size + 1e-14 * sn_norm(q));
    for (int k = 0; k < 3; k++) assert_true(sn_dot(sn_sub(p, q), sn_sub(corner[k], q)) <= tolerance * size * size);
}

static void closest_point_is_optimal(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 20000; i++) {
        sn_vec3 corner[3] = {random_point(&seed, 1), random_point(&seed, 1), random_point(&seed, 1)};
        assert_closest(random_point(&seed, 2), corner, 1e-13);
    }
}

/* Needles and caps down to a height of 1e-15 of their length, where plain formulas cancel. */
static void closest_point_on_slivers(void **state) {
    (void)state;
    uint64_t seed = 2;
    for (int i = 0; i < 20000; i++) {
        double height = pow(10.0, between(&seed, -15, -2));
        sn_vec3 a = random_point(&seed, 1), b = random_point(&seed, 1);
        sn_vec3 c = sn_add_scaled(sn_lerp(a, b, between(&seed, -0.5, 1.5)), random_point(&seed, 1), height);
        sn_vec3 corner[3] = {a, b, c};
        sn_vec3 p = sn_add_scaled(sn_lerp(a, b, between(&seed, -0.5, 1.5)), random_point(&seed, 1), pow(10.0, between(&seed, -6, 0)));
        assert_closest(p, corner, 1e-7);
    }
}

static void closest_point_on_degenerate_triangles(void **state) {
    (void)state;
    const sn_vec3 a = {0, 0, 0}, b = {1, 0, 0}, c = {3, 0, 0};
    double w[3];
    /* collinear, whatever the order of the corners */
    const sn_vec3 order[6][3] = {{a, b, c}, {a, c, b}, {b, a, c}, {b, c, a}, {c, a, b}, {c, b, a}};
    for (int i = 0; i < 6; i++) {
        sn_vec3 q = sn_closest_on_triangle(sn_v3(2, 1, 0), order[i][0], order[i][1], order[i][2], w);
        assert_near(sn_distance(q, sn_v3(2, 0, 0)), 0, 1e-15);
        assert_closest(sn_v3(-1, 2, 3), order[i], 1e-15);
        assert_closest(sn_v3(5, 2, 3), order[i], 1e-15);
    }
    /* two corners, or all three, in one place */
    sn_vec3 q = sn_closest_on_triangle(sn_v3(0.5, 1, 0), a, a, b, w);
    assert_near(sn_distance(q, sn_v3(0.5, 0, 0)), 0, 1e-15);
    q = sn_closest_on_triangle(sn_v3(4, 5, 6), c, c, c, w);
    assert_true(sn_distance(q, c) == 0.0);
    assert_true(w[0] == 1.0 && w[1] == 0.0 && w[2] == 0.0);
    assert_true(sn_finite3(sn_closest_on_triangle(b, a, b, c, NULL)));
}

/* A corner is found to the bit from every triangle around it, so that ties between them are ties. */
static void closest_corner_is_exact(void **state) {
    (void)state;
    const sn_vec3 tip = {0.1, 0.2, 0.7}, p = {0.3, 0.3, 5.0};
    uint64_t seed = 3;
    for (int i = 0; i < 1000; i++) {
        sn_vec3 a = random_point(&seed, 1), b = random_point(&seed, 1);
        a.z = fmin(a.z, 0), b.z = fmin(b.z, 0);
        const sn_vec3 turn[3] = {sn_closest_on_triangle(p, tip, a, b, NULL), sn_closest_on_triangle(p, b, tip, a, NULL),
                                 sn_closest_on_triangle(p, a, b, tip, NULL)};
        for (int k = 0; k < 3; k++) assert_true(turn[k].x == tip.x && turn[k].y == tip.y && turn[k].z == tip.z);
    }
}

/* ---- winding number ----------------------------------------------------------------------------------------------------- */

static sn_triangle cube_triangles[12] = {{{0, 2, 1}}, {{1, 2, 3}}, {{4, 5, 6}}, {{5, 7, 6}}, {{0, 1, 4}}, {{1, 5, 4}},
                                         {{2, 6, 3}}, {{3, 6, 7}}, {{0, 4, 2}}, {{2, 4, 6}}, {{1, 3, 5}}, {{3, 7, 5}}};
/* The cube [0,1]^3 moved by `offset`; closed and outwards. */
static sn_mesh cube(sn_vec3 positions[8], sn_vec3 offset) {
    for (int i = 0; i < 8; i++) positions[i] = sn_add(offset, sn_v3(i & 1, i >> 1 & 1, i >> 2 & 1));
    return (sn_mesh){.vertex_count = 8, .triangle_count = 12, .positions = positions, .triangles = cube_triangles};
}

static void winding_number_of_a_cube(void **state) {
    (void)state;
    sn_vec3 positions[8];
    const sn_vec3 offset[2] = {{0, 0, 0}, {1e6, -1e6, 1e6}};
    for (int far = 0; far < 2; far++) {
        sn_mesh mesh = cube(positions, offset[far]);
        uint64_t seed = 4;
        for (int i = 0; i < 1000; i++) {
            sn_vec3 p = random_point(&seed, 2);
            bool inside = p.x > 0 && p.y > 0 && p.z > 0 && p.x < 1 && p.y < 1 && p.z < 1;
            assert_near(sn_winding_number(&mesh, sn_add(offset[far], p)), inside ? 1.0 : 0.0, 1e-6);
        }
    }
}

/* From its centre every face of a cube fills a sixth of the view. */
static void winding_number_of_an_open_cube(void **state) {
    (void)state;
    sn_vec3 positions[8];
    sn_mesh mesh = cube(positions, sn_v3(0, 0, 0));
    for (sn_index faces = 1; faces <= 6; faces++) {
        mesh.triangle_count = 2 * faces;
        assert_near(sn_winding_number(&mesh, sn_v3(0.5, 0.5, 0.5)), faces / 6.0, 1e-14);
    }
}

static void winding_number_on_the_surface(void **state) {
    (void)state;
    sn_vec3 positions[8];
    sn_mesh mesh = cube(positions, sn_v3(0, 0, 0));
    assert_near(sn_winding_number(&mesh, sn_v3(0.3, 0.4, 0)), 0.5, 1e-14); /* on a face */
    assert_near(sn_winding_number(&mesh, sn_v3(0.3, 0, 0)), 0.25, 1e-14);  /* on an edge */
    assert_near(sn_winding_number(&mesh, sn_v3(1, 1, 1)), 0.125, 1e-14);   /* at a corner */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closest_point_is_optimal),
        cmocka_unit_test(closest_point_on_slivers),
        cmocka_unit_test(closest_point_on_degenerate_triangles),
        cmocka_unit_test(closest_corner_is_exact),
        cmocka_unit_test(winding_number_of_a_cube),
        cmocka_unit_test(winding_number_of_an_open_cube),
        cmocka_unit_test(winding_number_on_the_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
