/* test_run_in.c -- from rest to a motion's first frame: joints stay together on the way, by their own centres, axes and screws. */
#include "shapes.h"

#include "sinew/motion_clip.h"
#include "sinew/scene.h"

#include <string.h>

/* A hinge, a joint with a rest place on it that turns and is shifted, one without a place that turns about an unknown centre, and one that
 * is shifted alone. */
enum { HINGE, BALL, LOOSE, SHIFT, JOINTS };
static const sn_vec3 BALL_CENTRE = {0.3, 0.1, 0.2}, LOOSE_CENTRE = {-4.0, 7.0, 11.0}, WAY = {0.05, -0.02, 0.01};

static sn_quat turn(double x, double y, double z, double angle) { return sn_quat_axis_angle(sn_normalize(sn_v3(x, y, z)), angle); }

static void add_key(sn_joint *joint, sn_rigid pose) {
    joint->kind = SN_JOINT_POSE;
    joint->keys = SN_NEW(sn_pose_key, 1);
    joint->keys[0] = (sn_pose_key){0.0, pose};
    joint->key_count = 1;
}

static sn_motion tree(void) {
    static const char *const names[JOINTS] = {"hinge", "ball", "loose", "shift"};
    sn_motion motion = {.joint_count = JOINTS, .joints = SN_NEW(sn_joint, JOINTS)};
    for (sn_index j = 0; j < JOINTS; j++) {
        motion.joints[j].name = sn_strdup(names[j]);
        motion.joints[j].parent = j - 1;
    }
    motion.joints[HINGE].parent = SN_NONE;
    motion.joints[HINGE].axis = sn_v3(0, 1, 0);
    motion.joints[HINGE].point = sn_v3(0.1, 0.0, 0.4);
    motion.joints[HINGE].angle.constant = 4.0; /* beyond half a turn: the long way, as a hinge goes */
    add_key(&motion.joints[BALL], sn_clip_about(BALL_CENTRE, (sn_rigid){turn(1, 2, 3, 2.5), WAY}));
    motion.joints[BALL].has_rest = true;
    motion.joints[BALL].rest = BALL_CENTRE;
    motion.joints[BALL].rest_rotation = sn_quat_identity();
    add_key(&motion.joints[LOOSE], sn_clip_about(LOOSE_CENTRE, (sn_rigid){turn(-1, 0, 2, 3.0), {0, 0, 0}}));
    add_key(&motion.joints[SHIFT], (sn_rigid){sn_quat_identity(), WAY});
    assert_ok(sn_motion_validate(&motion, NULL));
    return motion;
}

static void check_same(sn_rigid a, sn_rigid b, double tolerance) {
    assert_true(fabs(fabs(sn_quat_dot(a.rotation, b.rotation)) - 1.0) <= tolerance);
    assert_true(sn_distance(a.translation, b.translation) <= tolerance);
}

static sn_rigid local(const sn_rigid *poses, sn_index j) { return sn_rigid_compose(sn_rigid_inverse(poses[j - 1]), poses[j]); }

static void test_the_ends_are_rest_and_the_frame_to_the_bit(void **state) {
    (void)state;
    sn_motion motion = tree();
    sn_rigid poses[JOINTS], frame[JOINTS];
    sn_motion_poses(&motion, 0.0, frame);
    sn_motion_run_in_poses(&motion, 0.0, 1.0, poses);
    assert_memory_equal(poses, frame, sizeof frame);
    sn_motion_run_in_poses(&motion, 0.0, 0.0, poses);
    for (sn_index j = 0; j < JOINTS; j++) check_same(poses[j], sn_rigid_identity(), 0.0);
    /* and it comes near the frame before it is there */
    sn_motion_run_in_poses(&motion, 0.0, 1.0 - 1e-12, poses);
    for (sn_index j = 0; j < JOINTS; j++) check_same(poses[j], frame[j], 1e-9);
    sn_motion_free(&motion);
}

static void test_joints_stay_together_on_the_way(void **state) {
    (void)state;
    sn_motion motion = tree();
    for (int k = 1; k < 20; k++) {
        double s = k / 20.0;
        sn_rigid poses[JOINTS];
        sn_motion_run_in_poses(&motion, 0.0, s, poses);
        for (sn_index j = 0; j < JOINTS; j++) check_same(sn_motion_run_in_pose(&motion, j, 0.0, s), poses[j], 1e-13);
        check_same(poses[HINGE], sn_clip_about(motion.joints[HINGE].point, (sn_rigid){turn(0, 1, 0, 4.0 * s), {0, 0, 0}}), 1e-13);
        /* the ball's centre goes straight in its parent, and turns about its axis by a share of the angle */
        check_same(local(poses, BALL), sn_clip_about(BALL_CENTRE, (sn_rigid){turn(1, 2, 3, 2.5 * s), sn_scale(WAY, s)}), 1e-12);
        /* nobody told the centre of the loose one: it stays all the same */
        check_same(local(poses, LOOSE), sn_clip_about(LOOSE_CENTRE, (sn_rigid){turn(-1, 0, 2, 3.0 * s), {0, 0, 0}}), 1e-11);
        check_same(local(poses, SHIFT), (sn_rigid){sn_quat_identity(), sn_scale(WAY, s)}, 1e-12);
    }
    sn_motion_free(&motion);
}

/* The screw of a turn by next to nothing, and of one by next to half a turn, written with either sign. */
static void test_screws_at_their_limits(void **state) {
    (void)state;
    static const double angles[] = {1e-13, 1e-9, 3e-7, 1e-3, 3.14159, SN_PI};
    for (size_t k = 0; k < 2 * sizeof angles / sizeof *angles; k++) {
        double angle = angles[k / 2];
        sn_motion motion = {.joint_count = 1, .joints = SN_NEW(sn_joint, 1)};
        motion.joints[0] = (sn_joint){.name = sn_strdup("a"), .parent = SN_NONE};
        sn_rigid pose = sn_clip_about(sn_v3(1, 2, 3), (sn_rigid){turn(0, 0, 1, angle), {0, 0, 0.5}});
        if (k % 2) pose.rotation = (sn_quat){-pose.rotation.w, -pose.rotation.x, -pose.rotation.y, -pose.rotation.z};
        add_key(&motion.joints[0], pose);
        sn_rigid half = sn_motion_run_in_pose(&motion, 0, 0.0, 0.5);
        check_same(half, sn_clip_about(sn_v3(1, 2, 3), (sn_rigid){turn(0, 0, 1, 0.5 * angle), {0, 0, 0.25}}), 1e-8);
        sn_motion_free(&motion);
    }
}

static void test_a_first_frame_at_rest_needs_none(void **state) {
    (void)state;
    sn_scene scene;
    sn_scene_defaults(&scene);
    scene.motion = tree();
    assert_false(sn_scene_runs_in(&scene)); /* none is asked for */
    scene.preroll = scene.run_in = 1.0;
    assert_true(sn_scene_runs_in(&scene));
    scene.motion.joints[HINGE].angle.constant = 0.0;
    for (sn_index j = BALL; j < JOINTS; j++) scene.motion.joints[j].keys[0].pose = sn_rigid_identity();
    assert_false(sn_scene_runs_in(&scene));
    scene.motion.joints[SHIFT].keys[0].pose.translation.x = 1e-9;
    assert_true(sn_scene_runs_in(&scene));
    sn_error error = {0};
    scene.preroll = 0.5;
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "runIn is 1 s"));
    scene.run_in = NAN;
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    sn_scene_free(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_ends_are_rest_and_the_frame_to_the_bit),
        cmocka_unit_test(test_joints_stay_together_on_the_way),
        cmocka_unit_test(test_screws_at_their_limits),
        cmocka_unit_test(test_a_first_frame_at_rest_needs_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
