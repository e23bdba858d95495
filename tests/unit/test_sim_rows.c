/* test_sim_rows.c -- single constraints: gradients against central differences to 1e-7, invariance, known values, guards. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "sinew/sim.h"

static uint64_t random_state = 5;

static sn_vec3 random_vector(void) {
    return sn_v3(2.0 * sn_random(&random_state) - 1.0, 2.0 * sn_random(&random_state) - 1.0, 2.0 * sn_random(&random_state) - 1.0);
}

typedef double (*value_function)(const sn_vec3 *p);

/* Every component of every gradient of f at p, step 1e-5 (error of the differences about 1e-10 x the third derivative). */
static void check_gradients(value_function f, sn_vec3 *p, const sn_vec3 *gradients, int count) {
    double scale = 1.0, step = 1e-5;
    for (int i = 0; i < count; i++) scale = fmax(scale, sn_norm(gradients[i]));
    for (int k = 0; k < 3 * count; k++) {
        double *x = (double *)p + k, keep = *x;
        *x = keep + step;
        double above = f(p);
        *x = keep - step;
        double below = f(p);
        *x = keep;
        assert_true(fabs((above - below) / (2.0 * step) - ((const double *)gradients)[k]) < 1e-7 * scale * scale * scale);
    }
}

static double distance_value(const sn_vec3 *p) {
    double value = NAN;
    sn_vec3 gradients[2];
    assert_true(sn_distance_constraint(p[0], p[1], 0.7, &value, gradients));
    return value;
}

static void distance_gradients_are_right(void **state) {
    (void)state;
    for (int i = 0; i < 100; i++) {
        sn_vec3 p[2] = {random_vector(), random_vector()}, gradients[2];
        double value;
        if (sn_distance(p[0], p[1]) < 0.2) continue;
        assert_true(sn_distance_constraint(p[0], p[1], 0.7, &value, gradients));
        assert_true(fabs(value - (sn_distance(p[0], p[1]) - 0.7)) < 1e-15);
        check_gradients(distance_value, p, gradients, 2);
    }
}

static double hinge_rest;

static double hinge_value(const sn_vec3 *p) {
    double value = NAN;
    sn_vec3 gradients[4];
    assert_true(sn_hinge_constraint(p, hinge_rest, &value, gradients));
    return value;
}

/* Two triangles of decent shape, folded to any angle. */
static void random_hinge(sn_vec3 p[4]) {
    double fold = 5.8 * (sn_random(&random_state) - 0.5); /* stays away from the jump at +-pi */
    p[0] = sn_v3(0, 0, 0);
    p[1] = sn_v3(1, 0, 0);
    p[2] = sn_v3(0.2 + 0.6 * sn_random(&random_state), 0.5 + 0.5 * sn_random(&random_state), 0);
    double height = 0.5 + 0.5 * sn_random(&random_state);
    p[3] = sn_v3(0.2 + 0.6 * sn_random(&random_state), -height * cos(fold), height * sin(fold));
    sn_quat turn = sn_quat_normalize((sn_quat){0.3, sn_random(&random_state), sn_random(&random_state), sn_random(&random_state)});
    for (int i = 0; i < 4; i++) p[i] = sn_quat_rotate(turn, p[i]);
}

static void hinge_gradients_are_right_and_move_nothing_as_a_whole(void **state) {
    (void)state;
    for (int i = 0; i < 300; i++) {
        sn_vec3 p[4], g[4], force = {0, 0, 0}, torque = {0, 0, 0};
        double value;
        random_hinge(p);
        hinge_rest = 0.0;
        assert_true(sn_hinge_constraint(p, hinge_rest, &value, g));
        check_gradients(hinge_value, p, g, 4);
        for (int k = 0; k < 4; k++) {
            force = sn_add(force, g[k]);
            torque = sn_add(torque, sn_cross(p[k], g[k]));
        }
        assert_true(sn_norm(force) < 1e-12 && sn_norm(torque) < 1e-12);
    }
}

/* a flat pair has angle 0; folded upwards (towards the outside) by a right angle: -pi/2, downwards: +pi/2 */
static void hinge_angle_has_a_sign(void **state) {
    (void)state;
    sn_vec3 p[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}}, g[4];
    double value;
    assert_true(sn_hinge_constraint(p, 0.0, &value, g));
    assert_true(fabs(value) < 1e-15);
    p[3] = sn_v3(0.5, 0, 1);
    assert_true(sn_hinge_constraint(p, 0.0, &value, g));
    assert_true(fabs(value + SN_PI / 2) < 1e-15);
    p[3] = sn_v3(0.5, 0, -1);
    assert_true(sn_hinge_constraint(p, 0.0, &value, g));
    assert_true(fabs(value - SN_PI / 2) < 1e-15);
    assert_true(sn_hinge_constraint(p, -3.0, &value, g)); /* 1.57 + 3 goes round to the short way */
    assert_true(fabs(value - (SN_PI / 2 + 3.0 - 2.0 * SN_PI)) < 1e-15);
}

/* the angle that two triangles were folded by, all the way round */
static void hinge_angle_is_right_to_the_last_bits(void **state) {
    (void)state;
    for (int i = -1000; i <= 1000; i++) {
        double fold = SN_PI * i / 1000.0, value;
        sn_vec3 p[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -cos(fold), sin(fold)}}, g[4];
        assert_true(sn_hinge_constraint(p, 0.0, &value, g));
        assert_true(fabs(value - atan2(-sin(fold), cos(fold))) < 1e-15 || fabs(fold) == SN_PI);
        assert_true(fabs(fabs(value) - fabs(fold)) < 2e-15);
    }
}

static void guards_hold(void **state) {
    (void)state;
    sn_vec3 g[4], line[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0.5, -1, 0}}, same[4] = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
    double value = 42.0;
    assert_false(sn_distance_constraint(sn_v3(1, 1, 1), sn_v3(1, 1, 1 + 5e-13), 0.1, &value, g));
    assert_false(sn_distance_constraint(sn_v3(NAN, 0, 0), sn_v3(1, 0, 0), 0.1, &value, g));
    assert_false(sn_distance_constraint(sn_v3(1e200, 0, 0), sn_v3(-1e200, 0, 0), 0.1, &value, g));
    assert_false(sn_hinge_constraint(line, 0.0, &value, g));
    assert_false(sn_hinge_constraint(same, 0.0, &value, g));
    line[2].y = NAN;
    assert_false(sn_hinge_constraint(line, 0.0, &value, g));
    assert_true(value == 42.0);
}

/* ---- least area, anisotropy ------------------------------------------------------------------------------------------------ */

static double area_value(const sn_vec3 *p) {
    double value = NAN;
    sn_vec3 gradients[3];
    assert_true(sn_area_constraint(p, 0.4, 0.5, &value, gradients));
    return value;
}

/* numerics.md 9: J = |n| / (2 A0), gradients (d2 x u) / (2 A0) and (u x d1) / (2 A0) */
static void area_gradients_are_right_and_move_nothing_as_a_whole(void **state) {
    (void)state;
    for (int i = 0; i < 200; i++) {
        sn_vec3 p[3] = {random_vector(), random_vector(), random_vector()}, g[3];
        double area = 0.5 * sn_norm(sn_cross(sn_sub(p[1], p[0]), sn_sub(p[2], p[0]))), value;
        if (area < 0.1) continue;
        assert_true(sn_area_constraint(p, 0.4, 0.5, &value, g));
        assert_true(fabs(value - (area / 0.4 - 0.5)) < 1e-14);
        check_gradients(area_value, p, g, 3);
        assert_true(sn_norm(sn_add(sn_add(g[0], g[1]), g[2])) < 1e-13);
    }
}

static void a_triangle_without_a_plane_is_left_alone(void **state) {
    (void)state;
    sn_vec3 line[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, g[3];
    double value = 42.0;
    assert_false(sn_area_constraint(line, 0.4, 0.5, &value, g));
    line[1].y = NAN;
    assert_false(sn_area_constraint(line, 0.4, 0.5, &value, g));
    assert_true(value == 42.0);
}

/* [K21] eq. 9 with |u.v|: 0 along the fibre either way, 1 across it, 1 - cos 60 between */
static void anisotropy_is_one_less_the_cosine(void **state) {
    (void)state;
    sn_vec3 fiber = sn_v3(0, 0, 2);
    assert_true(sn_anisotropy_factor(sn_v3(0, 0, -3), fiber) == 0.0);
    assert_true(sn_anisotropy_factor(sn_v3(5, 0, 0), fiber) == 1.0);
    assert_true(fabs(sn_anisotropy_factor(sn_v3(sqrt(3.0), 0, 1), fiber) - 0.5) < 1e-15);
    assert_true(sn_anisotropy_factor(sn_v3(1, 1, 1), sn_v3(0, 0, 0)) == 1.0);
}

/* ---- volume: the unit cube ------------------------------------------------------------------------------------------------ */

static const sn_triangle CUBE[12] = {{{0, 2, 1}}, {{0, 3, 2}}, {{4, 5, 6}}, {{4, 6, 7}}, {{0, 1, 5}}, {{0, 5, 4}},
                                     {{1, 2, 6}}, {{1, 6, 5}}, {{2, 3, 7}}, {{2, 7, 6}}, {{3, 0, 4}}, {{3, 4, 7}}};

static void make_cube(sn_vec3 *p, sn_vec3 offset) {
    for (int i = 0; i < 8; i++) p[i] = sn_add(offset, sn_v3(i % 4 == 1 || i % 4 == 2, i % 4 >= 2, i >= 4));
}

static double cube_volume(const sn_vec3 *p) {
    sn_point points[8];
    for (int i = 0; i < 8; i++) points[i] = (sn_point){p[i].x, p[i].y, p[i].z, 1.0};
    return sn_volume_constraint(8, points, 12, CUBE, NULL);
}

static void volume_of_a_cube_is_one_here_and_a_kilometre_away(void **state) {
    (void)state;
    sn_vec3 p[8];
    make_cube(p, sn_v3(0, 0, 0));
    assert_true(fabs(cube_volume(p) - 1.0) < 1e-15);
    make_cube(p, sn_v3(1000.1, -1000.2, 1000.3));
    assert_true(fabs(cube_volume(p) - 1.0) < 1e-12);
}

static void volume_gradients_are_right(void **state) {
    (void)state;
    for (int k = 0; k < 50; k++) {
        sn_vec3 p[8], gradients[8];
        sn_point points[8];
        make_cube(p, random_vector());
        for (int i = 0; i < 8; i++) {
            p[i] = sn_add_scaled(p[i], random_vector(), 0.3);
            points[i] = (sn_point){p[i].x, p[i].y, p[i].z, 1.0};
        }
        double volume = sn_volume_constraint(8, points, 12, CUBE, gradients);
        assert_true(fabs(volume - cube_volume(p)) < 1e-15);
        check_gradients(cube_volume, p, gradients, 8);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distance_gradients_are_right),
        cmocka_unit_test(hinge_gradients_are_right_and_move_nothing_as_a_whole),
        cmocka_unit_test(hinge_angle_has_a_sign),
        cmocka_unit_test(hinge_angle_is_right_to_the_last_bits),
        cmocka_unit_test(guards_hold),
        cmocka_unit_test(area_gradients_are_right_and_move_nothing_as_a_whole),
        cmocka_unit_test(a_triangle_without_a_plane_is_left_alone),
        cmocka_unit_test(anisotropy_is_one_less_the_cosine),
        cmocka_unit_test(volume_of_a_cube_is_one_here_and_a_kilometre_away),
        cmocka_unit_test(volume_gradients_are_right),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
