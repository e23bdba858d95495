/* test_motion.c -- channels and poses: values at and between keys, hinges, chains of joints, refusals. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/motion.h"

#define NEAR(a, b) assert_true(fabs((a) - (b)) < 1e-14)
#define NEAR_VECTOR(a, b) assert_true(sn_distance((a), (b)) < 1e-14)

static sn_joint hinge(sn_index parent, sn_vec3 axis, sn_vec3 point, double angle) {
    return (sn_joint){.parent = parent, .kind = SN_JOINT_HINGE, .axis = axis, .point = point, .angle.constant = angle};
}

static void channel_without_keys_is_its_constant(void **state) {
    (void)state;
    sn_channel c = {.constant = 0.25};
    assert_true(sn_channel_at(&c, -5.0) == 0.25 && sn_channel_at(&c, 7.0) == 0.25);
}

static void channel_holds_its_ends_and_is_linear_between(void **state) {
    (void)state;
    double times[] = {1.0, 2.0, 4.0}, values[] = {10.0, 20.0, 0.0};
    sn_channel c = {.count = 3, .times = times, .values = values};
    assert_true(sn_channel_at(&c, 0.0) == 10.0 && sn_channel_at(&c, 9.0) == 0.0);
    assert_true(sn_channel_at(&c, 2.0) == 20.0); /* exact at a key */
    NEAR(sn_channel_at(&c, 1.25), 12.5);
    NEAR(sn_channel_at(&c, 3.0), 10.0);
}

static void smooth_channel_follows_3t2_minus_2t3(void **state) {
    (void)state;
    double times[] = {0.0, 2.0}, values[] = {0.0, 1.0};
    sn_channel c = {.count = 2, .times = times, .values = values, .interpolation = SN_INTERPOLATE_SMOOTH};
    for (int i = 0; i <= 20; i++) {
        double t = i / 20.0;
        NEAR(sn_channel_at(&c, 2.0 * t), 3.0 * t * t - 2.0 * t * t * t);
    }
}

/* The search for the interval must agree with a walk over all keys. */
static void channel_finds_the_right_interval(void **state) {
    (void)state;
    double times[37], values[37];
    uint64_t random = 7;
    for (int i = 0; i < 37; i++) {
        times[i] = (i > 0 ? times[i - 1] : 0.0) + 0.01 + sn_random(&random);
        values[i] = sn_random(&random);
    }
    sn_channel c = {.count = 37, .times = times, .values = values};
    for (int k = 0; k < 500; k++) {
        double t = times[0] + (times[36] - times[0]) * sn_random(&random);
        int i = 0;
        while (times[i + 1] <= t) i++;
        NEAR(sn_channel_at(&c, t), values[i] + (t - times[i]) / (times[i + 1] - times[i]) * (values[i + 1] - values[i]));
    }
}

static void hinge_turns_about_its_point(void **state) {
    (void)state;
    sn_joint joint = hinge(SN_NONE, sn_v3(0, 0, 1), sn_v3(1, 0, 5), SN_PI / 2);
    sn_motion motion = {.joint_count = 1, .joints = &joint};
    sn_rigid pose;
    sn_motion_poses(&motion, 0.0, &pose);
    NEAR_VECTOR(sn_rigid_apply(pose, sn_v3(2, 0, 0)), sn_v3(1, 1, 0));
    NEAR_VECTOR(sn_rigid_apply(pose, joint.point), joint.point);
}

static void hinge_at_angle_0_moves_nothing_at_all(void **state) {
    (void)state;
    sn_joint joint = hinge(SN_NONE, sn_v3(0.6, 0, 0.8), sn_v3(0.1, 1000.7, -3.3), 0.0);
    sn_motion motion = {.joint_count = 1, .joints = &joint};
    sn_rigid pose;
    sn_motion_poses(&motion, 0.0, &pose);
    sn_vec3 p = sn_v3(0.1234567, -765.4321, 1e-9), q = sn_rigid_apply(pose, p);
    assert_true(q.x == p.x && q.y == p.y && q.z == p.z);
}

/* A child's axis and point are given in the rest pose's world; its parent carries them along. */
static void child_joint_is_carried_by_its_parent(void **state) {
    (void)state;
    sn_joint joints[] = {hinge(SN_NONE, sn_v3(0, 0, 1), sn_v3(0, 0, 0), SN_PI / 2), hinge(0, sn_v3(0, 0, 1), sn_v3(1, 0, 0), SN_PI / 2)};
    sn_motion motion = {.joint_count = 2, .joints = joints};
    sn_rigid poses[2];
    sn_motion_poses(&motion, 0.0, poses);
    NEAR_VECTOR(sn_rigid_apply(poses[1], sn_v3(1, 0, 0)), sn_v3(0, 1, 0));  /* the elbow, moved by the shoulder */
    NEAR_VECTOR(sn_rigid_apply(poses[1], sn_v3(2, 0, 0)), sn_v3(-1, 1, 0)); /* the hand: forearm folded back by another quarter */
}

static void key_poses_are_interpolated_on_the_shorter_way(void **state) {
    (void)state;
    sn_quat quarter = sn_quat_axis_angle(sn_v3(0, 0, 1), SN_PI / 2);
    sn_quat negative = {-quarter.w, -quarter.x, -quarter.y, -quarter.z}; /* the same rotation */
    for (int i = 0; i < 2; i++) {
        sn_pose_key keys[] = {{1.0, sn_rigid_identity()}, {3.0, {i == 0 ? quarter : negative, {4, 0, 0}}}};
        sn_joint joint = {.parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 2, .keys = keys};
        sn_motion motion = {.joint_count = 1, .joints = &joint};
        sn_rigid pose;
        sn_motion_poses(&motion, 2.0, &pose);
        NEAR_VECTOR(sn_rigid_apply(pose, sn_v3(1, 0, 0)), sn_v3(2 + sqrt(0.5), sqrt(0.5), 0));
        sn_motion_poses(&motion, 9.0, &pose);
        NEAR_VECTOR(sn_rigid_apply(pose, sn_v3(1, 0, 0)), sn_v3(4, 1, 0));
    }
}

static void refuse(sn_joint *joints, sn_index count, const char *word) {
    sn_motion motion = {.joint_count = count, .joints = joints};
    sn_error error = {0};
    assert_int_equal(sn_motion_validate(&motion, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, word));
    assert_non_null(strstr(error.text, "knee"));
}

static void bad_joints_are_refused_by_name(void **state) {
    (void)state;
    char name[] = "knee";
    double times[] = {1.0, 1.0}, values[] = {0.0, 1.0};
    sn_joint good = hinge(SN_NONE, sn_v3(0, 1, 0), sn_v3(0, 0, 0), 1.0), bad;
    good.name = name;
    sn_motion motion = {.joint_count = 1, .joints = &good};
    assert_int_equal(sn_motion_validate(&motion, NULL), SN_OK);
    bad = good, bad.axis = sn_v3(0, 2, 0);
    refuse(&bad, 1, "unit vector");
    bad = good, bad.point.x = NAN;
    refuse(&bad, 1, "point");
    bad = good, bad.parent = 0;
    refuse(&bad, 1, "parent");
    bad = good, bad.angle = (sn_channel){.count = 2, .times = times, .values = values};
    refuse(&bad, 1, "later");
    sn_pose_key key = {0.0, {{1, 1, 0, 0}, {0, 0, 0}}};
    bad = (sn_joint){.name = name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 1, .keys = &key};
    refuse(&bad, 1, "quaternion");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channel_without_keys_is_its_constant), cmocka_unit_test(channel_holds_its_ends_and_is_linear_between),
        cmocka_unit_test(smooth_channel_follows_3t2_minus_2t3), cmocka_unit_test(channel_finds_the_right_interval),
        cmocka_unit_test(hinge_turns_about_its_point),          cmocka_unit_test(hinge_at_angle_0_moves_nothing_at_all),
        cmocka_unit_test(child_joint_is_carried_by_its_parent), cmocka_unit_test(key_poses_are_interpolated_on_the_shorter_way),
        cmocka_unit_test(bad_joints_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
