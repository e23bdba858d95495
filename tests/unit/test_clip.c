/* test_clip.c -- recorded motions: the filter's gain and ends, resampling, jumps, cropping, the way to joints with keys and back. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/motion_clip.h"

enum { FRAMES = 601 };
static const double RATE = 120.0;

/* A chain of three joints; names "a", "b", "c"; one coordinate "a.rx". */
static sn_clip chain(sn_index frames) {
    sn_clip clip;
    assert_int_equal(sn_clip_create(frames, 3, 1, &clip, NULL), SN_OK);
    clip.rate = RATE;
    for (sn_index j = 0; j < 3; j++) {
        clip.joints[j].name = sn_strdup((const char[][2]){"a", "b", "c"}[j]);
        clip.joints[j].parent = j - 1;
        clip.joints[j].rest = sn_v3(0.1, 0.3 * j, -0.2);
    }
    clip.coordinates[0].name = sn_strdup("a.rx");
    clip.coordinates[0].unit = sn_strdup("rad");
    return clip;
}

/* Every joint turns about its own axis; the root moves too. */
static sn_clip moving(sn_index frames, double hertz) {
    sn_clip clip = chain(frames);
    const sn_vec3 axes[] = {{1, 0, 0}, {0, 0.6, 0.8}, {0, 0, 1}};
    for (sn_index f = 0; f < frames; f++) {
        double angle = 0.5 * sin(2.0 * SN_PI * hertz * f / RATE);
        for (sn_index j = 0; j < 3; j++)
            clip.joints[j].poses[f] =
                (sn_rigid){sn_quat_axis_angle(axes[j], angle * (j + 1)), j == 0 ? sn_v3(angle, 1, 0) : sn_v3(0, 0, 0)};
        clip.coordinates[0].values[f] = angle;
    }
    sn_clip_to_world(&clip);
    return clip;
}

/* Where the joint's centre is, by its own pose and by its parent's: the same, where the joint only turns. */
static void assert_together(const sn_clip *clip, double tolerance) {
    for (sn_index j = 1; j < clip->joint_count; j++)
        for (sn_index f = 0; f < clip->frame_count; f++) {
            const sn_clip_joint *joint = &clip->joints[j];
            sn_vec3 own = sn_rigid_apply(joint->poses[f], joint->rest);
            assert_true(sn_distance(own, sn_rigid_apply(clip->joints[joint->parent].poses[f], joint->rest)) < tolerance);
        }
}

static void local_poses_become_world_poses_and_come_back(void **state) {
    (void)state;
    sn_clip clip = moving(50, 3.0), same = moving(50, 3.0);
    assert_together(&clip, 1e-14);
    sn_clip_to_local(&clip);
    for (sn_index f = 0; f < 50; f++) assert_true(sn_norm(clip.joints[2].poses[f].translation) < 1e-14);
    sn_clip_to_world(&clip);
    for (sn_index j = 0; j < 3; j++)
        for (sn_index f = 0; f < 50; f++) {
            assert_true(sn_distance(clip.joints[j].poses[f].translation, same.joints[j].poses[f].translation) < 1e-14);
            assert_true(fabs(sn_quat_dot(clip.joints[j].poses[f].rotation, same.joints[j].poses[f].rotation)) > 1.0 - 1e-14);
        }
    sn_clip_free(&clip);
    sn_clip_free(&same);
}

/* Amplitude of a sine of the frequency in the middle of the coordinate, after the filter; and its lag as a share of the amplitude. */
static double gain(double hertz, double cutoff, double *quadrature) {
    sn_clip clip = moving(FRAMES, hertz);
    assert_int_equal(sn_clip_filter(&clip, cutoff, NULL, NULL), SN_OK);
    double in_phase = 0.0, power = 0.0;
    *quadrature = 0.0;
    for (sn_index f = 180; f < 420; f++) { /* two seconds: whole periods */
        double s = sin(2.0 * SN_PI * hertz * f / RATE), c = cos(2.0 * SN_PI * hertz * f / RATE);
        in_phase += s * clip.coordinates[0].values[f];
        *quadrature += c * clip.coordinates[0].values[f];
        power += 0.5 * s * s;
    }
    assert_together(&clip, 1e-12);
    sn_clip_free(&clip);
    *quadrature /= power;
    return in_phase / power;
}

/* |H|^2 of order 4, cutoff moved so that both passes have 1/sqrt 2 there: 1 / (1 + (sqrt 2 - 1) (W/Wc)^8), W = tan(pi f / rate). */
static void filter_has_the_gain_of_butterworth_twice_and_no_lag(void **state) {
    (void)state;
    const double tones[] = {1.0, 3.0, 6.0, 8.0, 12.0, 20.0}, cutoff = 6.0;
    for (size_t i = 0; i < sizeof tones / sizeof *tones; i++) {
        double quadrature, ratio = tan(SN_PI * tones[i] / RATE) / tan(SN_PI * cutoff / RATE);
        double expected = 1.0 / (1.0 + (sqrt(2.0) - 1.0) * pow(ratio, 8.0)), found = gain(tones[i], cutoff, &quadrature);
        if (!(fabs(found - expected) < 1e-4 && fabs(quadrature) < 1e-4))
            fail_msg("%g Hz: gain %g, not %g; quadrature %g", tones[i], found, expected, quadrature);
    }
    double quadrature;
    assert_true(fabs(gain(6.0, 6.0, &quadrature) - sqrt(0.5)) < 1e-4);
}

/* Point reflection at the ends: a straight line goes through, from the first frame to the last. */
static void filter_keeps_constants_and_straight_lines(void **state) {
    (void)state;
    sn_clip clip = chain(FRAMES);
    for (sn_index f = 0; f < FRAMES; f++) {
        clip.joints[0].poses[f].translation = sn_v3(0.01 * f, 0.25, 1.0 - 0.002 * f);
        clip.coordinates[0].values[f] = 0.003 * f - 1.0;
    }
    assert_int_equal(sn_clip_filter(&clip, 6.0, NULL, NULL), SN_OK);
    for (sn_index f = 0; f < FRAMES; f++) {
        assert_true(sn_distance(clip.joints[0].poses[f].translation, sn_v3(0.01 * f, 0.25, 1.0 - 0.002 * f)) < 1e-6);
        assert_true(fabs(clip.coordinates[0].values[f] - (0.003 * f - 1.0)) < 1e-6);
        assert_true(clip.joints[1].poses[f].rotation.w > 1.0 - 1e-12);
    }
    sn_clip_free(&clip);
}

/* The sign of a quaternion says nothing, nor do whole turns of an angle: filtered, they are the same as without. */
static void signs_and_whole_turns_do_not_matter(void **state) {
    (void)state;
    sn_clip clip = moving(200, 2.0), other = moving(200, 2.0);
    for (sn_index f = 0; f < 200; f++) {
        sn_quat *q = &other.joints[1].poses[f].rotation;
        if (f % 3 == 0) *q = (sn_quat){-q->w, -q->x, -q->y, -q->z};
        if (f >= 70) other.coordinates[0].values[f] += 2.0 * SN_PI;
    }
    assert_int_equal(sn_clip_filter(&clip, 4.0, NULL, NULL), SN_OK);
    assert_int_equal(sn_clip_filter(&other, 4.0, NULL, NULL), SN_OK);
    for (sn_index f = 0; f < 200; f++) {
        assert_true(fabs(sn_quat_dot(clip.joints[2].poses[f].rotation, other.joints[2].poses[f].rotation)) > 1.0 - 1e-12);
        assert_true(fabs(clip.coordinates[0].values[f] - other.coordinates[0].values[f]) < 1e-12);
    }
    sn_clip_free(&clip);
    sn_clip_free(&other);
}

/* Joint b is turned by 170 degrees from frame 40 on. */
static sn_clip flipping(void) {
    sn_clip clip = chain(100);
    for (sn_index f = 40; f < 100; f++) {
        sn_clip_to_local(&clip);
        clip.joints[1].poses[f].rotation = sn_quat_axis_angle(sn_v3(0, 0, 1), 170.0 * SN_PI / 180.0);
        sn_clip_to_world(&clip);
    }
    return clip;
}

static void jumps_are_found_and_neither_filtered_nor_blended(void **state) {
    (void)state;
    sn_clip clip = flipping();
    sn_clip_jump *jumps;
    sn_index count;
    assert_int_equal(sn_clip_jumps(&clip, &jumps, &count, NULL), SN_OK);
    assert_int_equal(count, 1); /* c goes along with b: against its parent it has not turned */
    assert_true(jumps[0].joint == 1 && jumps[0].frame == 40 && fabs(jumps[0].angle - 170.0 * SN_PI / 180.0) < 1e-9);
    free(jumps);
    assert_int_equal(sn_clip_filter(&clip, 6.0, NULL, NULL), SN_OK);
    assert_int_equal(sn_clip_resample(&clip, 1000.0, NULL), SN_OK);
    for (sn_index f = 0; f < clip.frame_count; f++) {
        double half = 0.5 * (f / 1000.0 * RATE < 39.5 ? 0.0 : 170.0 * SN_PI / 180.0);
        assert_true(fabs(fabs(clip.joints[1].poses[f].rotation.w) - cos(half)) < 1e-9);
    }
    sn_clip_free(&clip);
}

static void resampling_keeps_what_falls_on_old_frames_and_slerps_between(void **state) {
    (void)state;
    sn_clip clip = moving(121, 1.0), old = moving(121, 1.0);
    assert_int_equal(sn_clip_resample(&clip, 240.0, NULL), SN_OK);
    assert_int_equal(clip.frame_count, 241);
    assert_true(clip.rate == 240.0);
    assert_together(&clip, 1e-14);
    for (sn_index f = 0; f < 241; f++) {
        sn_quat expected = sn_quat_slerp(old.joints[0].poses[f / 2].rotation, old.joints[0].poses[(f + 1) / 2].rotation, 0.5 * (f % 2));
        assert_true(fabs(sn_quat_dot(clip.joints[0].poses[f].rotation, expected)) > 1.0 - 1e-14);
        double a = old.coordinates[0].values[f / 2], b = old.coordinates[0].values[(f + 1) / 2];
        assert_true(fabs(clip.coordinates[0].values[f] - (f % 2 ? 0.5 * (a + b) : a)) < 1e-15);
    }
    assert_int_equal(sn_clip_resample(&clip, 50.0, NULL), SN_OK);
    assert_int_equal(clip.frame_count, 51); /* the last, at 1 s, is there still */
    sn_clip_free(&clip);
    sn_clip_free(&old);
}

static void cropping_keeps_the_frames_between(void **state) {
    (void)state;
    sn_clip clip = moving(100, 1.0), old = moving(100, 1.0);
    sn_error error = {0};
    assert_int_equal(sn_clip_crop(&clip, 30, 40, &error), SN_OK);
    assert_int_equal(clip.frame_count, 11);
    for (sn_index f = 0; f < 11; f++) {
        assert_memory_equal(&clip.joints[2].poses[f], &old.joints[2].poses[f + 30], sizeof(sn_rigid));
        assert_true(clip.coordinates[0].values[f] == old.coordinates[0].values[f + 30]);
    }
    assert_int_equal(sn_clip_crop(&clip, 5, 11, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_clip_crop(&clip, -1, 5, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_clip_crop(&clip, 6, 5, &error), SN_ERROR_USAGE);
    sn_clip_free(&clip);
    sn_clip_free(&old);
}

static void a_clip_becomes_joints_with_keys_and_comes_back(void **state) {
    (void)state;
    sn_clip clip = moving(40, 2.0), back;
    sn_motion motion;
    sn_rigid poses[3];
    assert_int_equal(sn_clip_to_motion(&clip, &motion, NULL), SN_OK);
    assert_int_equal(sn_motion_validate(&motion, NULL), SN_OK);
    for (sn_index f = 0; f < 40; f++) {
        sn_motion_poses(&motion, f / RATE, poses);
        for (sn_index j = 0; j < 3; j++)
            assert_true(sn_distance(sn_rigid_apply(poses[j], sn_v3(1, 2, 3)), sn_rigid_apply(clip.joints[j].poses[f], sn_v3(1, 2, 3))) <
                        1e-13);
        assert_true(fabs(sn_coordinate_at(&motion.coordinates[0], f / RATE) - clip.coordinates[0].values[f]) < 1e-14);
    }
    assert_true(sn_coordinate_at(&motion.coordinates[0], -1.0) == clip.coordinates[0].values[0]);
    assert_true(sn_coordinate_at(&motion.coordinates[0], 9.0) == clip.coordinates[0].values[39]);
    assert_int_equal(sn_clip_from_motion(&motion, RATE, &back, NULL), SN_OK);
    assert_int_equal(back.frame_count, 40);
    assert_true(sn_distance(back.joints[2].rest, clip.joints[2].rest) == 0.0);
    for (sn_index f = 0; f < 40; f++)
        assert_true(sn_distance(back.joints[2].poses[f].translation, clip.joints[2].poses[f].translation) < 1e-13);
    sn_clip_free(&clip);
    sn_clip_free(&back);
    sn_motion_free(&motion);
}

/* y up to z up: what was at (x, y, z) is at (x, -z, y), at rest and moved. */
static void turning_up_turns_every_place(void **state) {
    (void)state;
    sn_clip clip = moving(20, 2.0), old = moving(20, 2.0);
    sn_clip_turn_y_up(&clip);
    for (sn_index f = 0; f < 20; f++) {
        sn_vec3 p = sn_rigid_apply(old.joints[2].poses[f], sn_v3(1, 2, 3)), q = sn_rigid_apply(clip.joints[2].poses[f], sn_v3(1, -3, 2));
        assert_true(sn_distance(q, sn_v3(p.x, -p.z, p.y)) < 1e-14);
    }
    sn_vec3 y = sn_quat_rotate(clip.joints[0].rest_rotation, sn_v3(0, 1, 0));
    assert_true(sn_distance(y, sn_v3(0, 0, 1)) < 1e-15);
    sn_clip_free(&clip);
    sn_clip_free(&old);
}

static void a_trace_stops_between_joints(void **state) {
    (void)state;
    sn_clip clip = moving(100, 20.0), old = moving(100, 20.0);
    sn_trace trace = {.stop_after = 1};
    assert_int_equal(sn_clip_filter(&clip, 6.0, &trace, NULL), SN_STOPPED);
    assert_int_equal(sn_clip_validate(&clip, NULL), SN_OK);
    assert_true(fabs(clip.joints[0].poses[50].rotation.x) < 0.1 * fabs(old.joints[0].poses[31].rotation.x)); /* filtered */
    assert_true(clip.coordinates[0].values[31] == old.coordinates[0].values[31]);                            /* not yet */
    sn_clip_free(&clip);
    sn_clip_free(&old);
}

static void what_is_not_sound_is_refused(void **state) {
    (void)state;
    sn_error error = {0};
    sn_clip clip = moving(10, 1.0);
    assert_int_equal(sn_clip_filter(&clip, 60.0, NULL, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_clip_filter(&clip, 0.0, NULL, &error), SN_ERROR_USAGE);
    assert_int_equal(sn_clip_validate(&clip, &error), SN_OK);
    clip.joints[1].parent = 1;
    assert_int_equal(sn_clip_validate(&clip, &error), SN_ERROR_INPUT);
    clip.joints[1].parent = 0;
    clip.joints[2].name[0] = 'b';
    assert_int_equal(sn_clip_validate(&clip, &error), SN_ERROR_INPUT);
    clip.joints[2].name[0] = 'c';
    clip.coordinates[0].values[7] = NAN;
    assert_int_equal(sn_clip_validate(&clip, &error), SN_ERROR_INPUT);
    sn_clip_free(&clip);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(local_poses_become_world_poses_and_come_back),
        cmocka_unit_test(filter_has_the_gain_of_butterworth_twice_and_no_lag),
        cmocka_unit_test(filter_keeps_constants_and_straight_lines),
        cmocka_unit_test(signs_and_whole_turns_do_not_matter),
        cmocka_unit_test(jumps_are_found_and_neither_filtered_nor_blended),
        cmocka_unit_test(resampling_keeps_what_falls_on_old_frames_and_slerps_between),
        cmocka_unit_test(cropping_keeps_the_frames_between),
        cmocka_unit_test(a_clip_becomes_joints_with_keys_and_comes_back),
        cmocka_unit_test(turning_up_turns_every_place),
        cmocka_unit_test(a_trace_stops_between_joints),
        cmocka_unit_test(what_is_not_sound_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
