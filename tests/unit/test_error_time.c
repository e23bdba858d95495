/* test_error_time.c -- norms, holds, timed runs, extrapolation and orders, the Pareto front, the cheapest setting. */
#include "sim_scene.h"

#include "sinew/error_time.h"

/* ---- norms ------------------------------------------------------------------------------------------------------------------ */

/* Two muscles: points 0-2 with L = 2, the third of them carried; point 3 with L = 4. */
static sn_yardstick two_muscles(void) {
    sn_yardstick y = {.muscle_count = 2, .point_count = 4, .start = SN_NEW(sn_index, 3), .mass = SN_NEW(double, 4)};
    y.diagonal = SN_NEW(double, 2);
    y.start[1] = 3, y.start[2] = 4;
    y.mass[0] = 1.0, y.mass[1] = 3.0, y.mass[3] = 6.0;
    y.diagonal[0] = 2.0, y.diagonal[1] = 4.0;
    return y;
}

static void distances_are_weighted_by_mass_and_over_the_diagonal(void **state) {
    (void)state;
    sn_yardstick y = two_muscles();
    sn_vec3 a[8] = {{0}}, b[8] = {{0}};
    double muscles[2];
    b[0] = sn_v3(2, 0, 0);        /* 1 kg, 1 L */
    b[1] = sn_v3(0, 0, 4);        /* 3 kg, 2 L */
    b[2] = sn_v3(1e6, 0, 0);      /* carried */
    b[4 + 3] = sn_v3(0, -8.0, 0); /* 6 kg, 2 L, at the second moment */
    sn_difference d = sn_difference_between(&y, 2, a, b, muscles);
    assert_true(fabs(muscles[0] - sqrt((1.0 + 3.0 * 4.0) / (2.0 * 4.0))) < 1e-15);
    assert_true(fabs(muscles[1] - sqrt(6.0 * 4.0 / (2.0 * 6.0))) < 1e-15);
    assert_true(d.worst == fmax(muscles[0], muscles[1]));
    assert_true(fabs(d.scene - sqrt((13.0 + 24.0) / 20.0)) < 1e-15);
    assert_true(fabs(d.most - 2.0) < 1e-15);
    d = sn_difference_between(&y, 1, a, b, NULL);
    assert_true(fabs(d.worst - sqrt(13.0 / 4.0)) < 1e-15);
    sn_yardstick_free(&y);
}

static void what_is_not_finite_is_never_small(void **state) {
    (void)state;
    sn_yardstick y = two_muscles();
    for (sn_index bad = 0; bad < 4; bad++) {
        sn_vec3 a[4] = {{0}}, b[4] = {{0}};
        b[bad].y = NAN;
        b[3].x = 1.0;
        sn_difference d = sn_difference_between(&y, 1, a, b, NULL);
        assert_int_equal(isnan(d.worst) && isnan(d.scene) && isnan(d.most), y.mass[bad] > 0.0);
    }
    sn_yardstick_free(&y);
}

/* ---- runs --------------------------------------------------------------------------------------------------------------------- */

static const fusiform SMALL = {.rings = 9, .sectors = 6, .length = 0.2, .radius = 0.03, .meters_per_unit = 1.0, .pinned = 0.15};

/* Frames 0 to 4; the joint turns on after them. */
static void make_turning(sn_scene *scene) {
    make_scene(scene, &SMALL);
    scene->last_frame = 4;
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, -1.0);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
}

static void a_hold_keeps_the_inputs_and_lets_time_pass(void **state) {
    (void)state;
    sn_scene scene;
    make_turning(&scene);
    simulation s = start(&scene);
    step_frames(&s, 4, NULL);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_index carried = 0, free_point = 0; /* carried: by the turning bone, off its axis */
    for (sn_index i = 0; i < m->kinematic_count; i++)
        if (m->rest[m->kinematic_points[i]].z < 0.1 && fabs(m->rest[m->kinematic_points[i]].y) > 1e-3) carried = m->kinematic_points[i];
    while (s.state->muscles[0].points[free_point].w == 0.0) free_point++;
    sn_vec3 bone = position(&s, carried), before = position(&s, free_point);
    for (int i = 0; i < 60; i++) assert_int_equal(sn_hold(s.model, s.state, NULL, NULL), SN_OK);
    assert_int_equal(s.state->frame, 4);
    assert_true(sn_distance(bone, position(&s, carried)) < 1e-15);
    assert_true(sn_distance(before, position(&s, free_point)) > 1e-6);
    sn_vec3 after = position(&s, free_point);
    assert_int_equal(sn_hold(s.model, s.state, NULL, NULL), SN_OK);
    assert_true(sn_distance(after, position(&s, free_point)) < 0.01 * sn_distance(before, after)); /* it comes to rest */
    step_frames(&s, 1, NULL);
    assert_true(sn_distance(bone, position(&s, carried)) > 1e-4); /* and the motion goes on from there */
    finish(&s);
}

static void a_timed_run_is_the_plain_run(void **state) {
    (void)state;
    sn_scene scene;
    make_turning(&scene);
    const sn_index moments[] = {1, 4, 6};
    sn_run_request request = {.moment_count = 3, .moments = moments, .most_seconds = INFINITY};
    sn_run_result run;
    assert_int_equal(sn_run_timed(&scene, &request, &run, NULL), SN_OK);
    assert_int_equal(run.track.moment_count, 3);
    assert_int_equal(run.frames, 6);
    assert_true(run.iterations >= 6 && run.cpu[0] > 0.0 && run.cpu[1] > run.cpu[0] && run.cpu[2] > run.cpu[1]);
    simulation s = start(&scene);
    for (sn_index frame = 1, at = 0; frame <= 6; frame++) {
        if (frame <= 4)
            step_frames(&s, 1, NULL);
        else
            assert_int_equal(sn_hold(s.model, s.state, NULL, NULL), SN_OK);
        if (frame != moments[at]) continue;
        for (sn_index i = 0; i < run.track.point_count; i++) {
            sn_vec3 p = position(&s, i), q = run.track.positions[at * run.track.point_count + i];
            assert_true(p.x == q.x && p.y == q.y && p.z == q.z);
        }
        at++;
    }
    sn_run_free(&run);
    finish(&s);
}

static void a_run_ends_at_rest_or_out_of_time(void **state) {
    (void)state;
    sn_scene scene;
    make_turning(&scene);
    const sn_index last = 4 + 100000;
    sn_run_request request = {.moment_count = 1, .moments = &last, .rest = 1e-6, .most_seconds = INFINITY};
    sn_run_result run;
    assert_int_equal(sn_run_timed(&scene, &request, &run, NULL), SN_OK);
    assert_int_equal(run.track.moment_count, 1);
    assert_true(run.moments[0] > 4 && run.moments[0] < 1000);
    sn_run_free(&run);
    request.rest = 0.0;
    request.most_seconds = 1e-9;
    assert_int_equal(sn_run_timed(&scene, &request, &run, NULL), SN_OK);
    assert_true(run.over_time && run.track.moment_count == 0 && run.frames == 1);
    sn_run_free(&run);
    sn_scene_free(&scene);
}

/* ---- the reference ------------------------------------------------------------------------------------------------------------ */

/* Rungs of one point at x(h) = 1 + c h^p + d h^2, h = 1 / substeps. */
static void fill_rungs(sn_reference *r, sn_index count, double c, double p, double d) {
    *r = (sn_reference){.rung_count = count, .rungs = SN_NEW(sn_rung, count)};
    for (sn_index i = 0; i < count; i++) {
        double h = pow(0.5, i);
        r->rungs[i] = (sn_rung){.substeps = 1 << i, .track = {.moment_count = 1, .point_count = 1, .positions = SN_NEW(sn_vec3, 1)}};
        r->rungs[i].track.positions[0].x = 1.0 + c * pow(h, p) + d * h * h;
    }
}

static sn_yardstick one_point(void) {
    sn_yardstick y = {.muscle_count = 1, .point_count = 1, .start = SN_NEW(sn_index, 2), .mass = SN_NEW(double, 1)};
    y.diagonal = SN_NEW(double, 1);
    y.start[1] = 1, y.mass[0] = y.diagonal[0] = 1.0;
    return y;
}

static void errors_of_first_order_are_extrapolated(void **state) {
    (void)state;
    sn_yardstick y = one_point();
    sn_reference r;
    fill_rungs(&r, 7, 1e-2, 1.0, 1e-3);
    assert_int_equal(sn_reference_extrapolate(&y, &r, NULL), SN_OK);
    double left = fabs(r.track.positions[0].x - 1.0), plain = fabs(r.rungs[6].track.positions[0].x - 1.0);
    assert_true(r.extrapolated && left < 0.02 * plain);
    assert_true(left <= r.floor && r.floor < 4.0 * left); /* three times the error is what it should be */
    assert_true(fabs(r.order - 1.0) < 0.05);
    assert_true(r.fitted_rungs >= 3 && fabs(r.fitted - 1.0) < 0.1);
    assert_true(fabs(r.rungs[0].error - 0.011) < 1e-5 && isnan(r.rungs[0].step) == false);
    sn_reference_free(&r);
    sn_yardstick_free(&y);
}

static void other_orders_are_left_alone(void **state) {
    (void)state;
    sn_yardstick y = one_point();
    for (int half = 0; half < 2; half++) {
        sn_reference r;
        fill_rungs(&r, 7, 1e-2, half ? 0.5 : 2.0, 0.0);
        assert_int_equal(sn_reference_extrapolate(&y, &r, NULL), SN_OK);
        assert_false(r.extrapolated);
        assert_true(r.track.positions[0].x == r.rungs[6].track.positions[0].x);
        assert_true(r.floor == r.rungs[6].step);
        assert_true(fabs(r.order - (half ? 0.5 : 2.0)) < 1e-6);
        sn_reference_free(&r);
    }
    sn_yardstick_free(&y);
}

/* The reference of 32 substeps is as near to the run with 512 as its floor says. */
static void the_floor_is_honest(void **state) {
    (void)state;
    sn_scene scene;
    make_turning(&scene);
    scene.muscles[0].damping = 200.0; /* no mode swings: the steps are soon of first order */
    sn_model *model;
    sn_yardstick y;
    sn_reference r, fine;
    const sn_index moments[] = {2, 4};
    sn_run_request request = {.moment_count = 2, .moments = moments, .most_seconds = INFINITY};
    sn_reference_params params = sn_reference_defaults();
    assert_int_equal(sn_model_create(&scene, &model, NULL), SN_OK);
    assert_int_equal(sn_yardstick_create(model, &y, NULL), SN_OK);
    params.floor = 0.0;
    params.most_substeps = 32;
    assert_int_equal(sn_reference_motion(&(sn_reference_task){&scene, &y, &request, &params}, &r, NULL), SN_OK);
    params.most_substeps = 512;
    assert_int_equal(sn_reference_motion(&(sn_reference_task){&scene, &y, &request, &params}, &fine, NULL), SN_OK);
    double away = sn_difference_between(&y, 2, r.track.positions, fine.track.positions, NULL).worst;
    print_message("floor %.2e, away %.2e, order %.2f, extrapolated %d; fine: floor %.2e, order %.2f\n", r.floor, away, r.order,
                  r.extrapolated, fine.floor, fine.order);
    assert_int_equal(r.rung_count, 6);
    assert_true(r.extrapolated && away <= r.floor);
    assert_true(r.floor < 0.5 * r.rungs[5].step);
    sn_reference_free(&r);
    sn_reference_free(&fine);
    sn_yardstick_free(&y);
    sn_model_destroy(model);
    sn_scene_free(&scene);
}

static void two_ways_lead_to_one_equilibrium(void **state) {
    (void)state;
    sn_scene scene;
    make_turning(&scene);
    sn_model *model;
    sn_yardstick y;
    sn_reference r;
    sn_run_request request = {.most_seconds = INFINITY};
    sn_reference_params params = sn_reference_defaults();
    assert_int_equal(sn_model_create(&scene, &model, NULL), SN_OK);
    assert_int_equal(sn_yardstick_create(model, &y, NULL), SN_OK);
    assert_int_equal(sn_reference_rest(&(sn_reference_task){&scene, &y, &request, &params}, &r, NULL), SN_OK);
    assert_int_equal(r.rung_count, 2);
    assert_int_equal(r.track.moment_count, 1);
    assert_true(r.floor < 1e-7);
    sn_reference_free(&r);
    sn_yardstick_free(&y);
    sn_model_destroy(model);
    sn_scene_free(&scene);
}

/* ---- the diagram ---------------------------------------------------------------------------------------------------------------- */

static void the_front_has_what_nothing_beats(void **state) {
    (void)state;
    const double seconds[] = {1, 2, 3, 1, 2, 1, NAN, 0.5, 4};
    const double errors[] = {5, 3, 3, 6, 1, 5, 0, INFINITY, 0.5};
    const bool expected[] = {true, false, false, false, true, false, false, false, true};
    bool front[9];
    sn_pareto_front(9, seconds, errors, front);
    for (int i = 0; i < 9; i++) assert_int_equal(front[i], expected[i]);
    sn_pareto_front(0, NULL, NULL, NULL);
}

static void claims_keep_away_from_the_floor(void **state) {
    (void)state;
    sn_error_time report = {.reference.floor = 1e-4, .setting_count = 2, .point_count = 4};
    report.settings = SN_NEW(sn_measured_setting, 2);
    report.points = SN_NEW(sn_error_point, 4);
    report.settings[1].setting.method = SN_SOLVER_QN;
    const double errors[] = {1e-2, 1e-3, 5e-4, NAN}, seconds[] = {1.0, 4.0, 2.0, 0.1}; /* the third surely beats the second */
    for (sn_index i = 0; i < 4; i++) report.points[i] = (sn_error_point){.setting = i / 2, .total.worst = errors[i], .cpu = seconds[i]};
    assert_int_equal(sn_error_time_judge(&report, NULL), SN_OK);
    assert_true(report.points[0].claimed && report.points[1].claimed && !report.points[2].claimed && !report.points[3].claimed);
    assert_true(report.points[0].front && !report.points[1].front && !report.points[2].front && !report.points[3].front);
    assert_ptr_equal(sn_error_time_cheapest(&report, 1.0, NULL), &report.points[0]);
    assert_ptr_equal(sn_error_time_cheapest(&report, 1e-3, NULL), &report.points[2]);
    assert_ptr_equal(sn_error_time_cheapest(&report, 1.2e-3, "xpbd"), &report.points[1]);
    assert_null(sn_error_time_cheapest(&report, 1e-3, "xpbd")); /* 1e-3 with the floor on top is more */
    assert_null(sn_error_time_cheapest(&report, 5.5e-4, NULL));
    sn_error_time_free(&report);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_weighted_by_mass_and_over_the_diagonal),
        cmocka_unit_test(what_is_not_finite_is_never_small),
        cmocka_unit_test(a_hold_keeps_the_inputs_and_lets_time_pass),
        cmocka_unit_test(a_timed_run_is_the_plain_run),
        cmocka_unit_test(a_run_ends_at_rest_or_out_of_time),
        cmocka_unit_test(errors_of_first_order_are_extrapolated),
        cmocka_unit_test(other_orders_are_left_alone),
        cmocka_unit_test(the_floor_is_honest),
        cmocka_unit_test(two_ways_lead_to_one_equilibrium),
        cmocka_unit_test(the_front_has_what_nothing_beats),
        cmocka_unit_test(claims_keep_away_from_the_floor),
    };
    return cmocka_run_group_tests_name("error-time", tests, NULL, NULL);
}
