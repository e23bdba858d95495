/* test_sim_run_in.c -- the pre-roll's run-in is a motion like any other: same points as frames that bend the same way; who watches it. */
#include "sim_scene.h"

static const double TURN = -70.0 * SN_PI / 180.0;

static void choose(sn_scene *scene, sn_solver_method method, sn_index substeps) {
    sn_solver_change(&scene->solver, method);
    if (substeps > 0) scene->solver.substeps = substeps;
}

/* Half a second of run-in and nothing else, to a hinge that is bent from the first frame on. */
static void make_bent(sn_scene *scene, sn_solver_method method, sn_index substeps) {
    make_scene(scene, &FUSIFORM);
    choose(scene, method, substeps);
    scene->muscles[0].activation.constant = 0.3;
    scene->motion.joints[0].angle.constant = TURN;
    scene->preroll = scene->run_in = 0.5;
}

/* The same way over twelve frames, from rest: smoothstep of the angle is smoothstep of the share. */
static void make_bending(sn_scene *scene, sn_solver_method method, sn_index substeps) {
    make_bent(scene, method, substeps);
    scene->preroll = scene->run_in = 0.0;
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, TURN);
    scene->motion.joints[0].angle.interpolation = SN_INTERPOLATE_SMOOTH;
}

static double greatest_difference(const simulation *a, const simulation *b) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++) most = fmax(most, sn_distance(position(a, i), position(b, i)));
    return most;
}

static void a_run_in_is_the_motion_it_describes(void **state) {
    (void)state;
    static const struct {
        sn_solver_method method;
        sn_index substeps;
    } runs[] = {{SN_SOLVER_QN, 0}, {SN_SOLVER_QN, 3}, {SN_SOLVER_XPBD, 16}, {SN_SOLVER_XPBD, 5}};
    for (size_t k = 0; k < sizeof runs / sizeof *runs; k++) {
        sn_scene bent, bending;
        make_bent(&bent, runs[k].method, runs[k].substeps);
        make_bending(&bending, runs[k].method, runs[k].substeps);
        simulation a = start(&bent), b = start(&bending);
        assert_true(greatest_move(&a) == 0.0); /* it begins at rest, though the first frame is bent */
        assert_int_equal(sn_settle(a.model, a.state, NULL, NULL), SN_OK);
        step_frames(&b, 12, NULL);
        assert_int_equal(a.state->frame, 0);
        assert_int_equal(a.state->substep, 0);
        assert_true(greatest_move(&a) > 0.01);
        assert_true(greatest_difference(&a, &b) < 1e-9);
        /* what was counted on the way is the first frame's: all steps, not only the last frame's */
        sn_index substeps = sn_solver_substeps(&bent.solver);
        assert_true(a.state->muscles[0].statistics.steps >= 12 * substeps);
        assert_true(b.state->muscles[0].statistics.steps < 12 * substeps);
        finish(&a);
        finish(&b);
    }
}

/* Half a run-in and half a hold: the hold begins where the first frame is. */
static void what_is_left_of_the_preroll_holds(void **state) {
    (void)state;
    sn_scene bent, held;
    make_bent(&bent, SN_SOLVER_QN, 0);
    make_bent(&held, SN_SOLVER_QN, 0);
    held.preroll = 1.0;
    simulation a = start(&bent), b = start(&held);
    assert_int_equal(sn_settle(a.model, a.state, NULL, NULL), SN_OK);
    for (int frame = 0; frame < 12; frame++) assert_int_equal(sn_hold(a.model, a.state, NULL, NULL), SN_OK);
    assert_int_equal(sn_settle(b.model, b.state, NULL, NULL), SN_OK);
    assert_true(greatest_difference(&a, &b) == 0.0);
    finish(&a);
    finish(&b);
}

typedef struct watcher {
    int calls;
    double shares[64];
    int stop_at; /* call at which it ends the run-in; 0 = none */
} watcher;

static sn_status look(void *user, const sn_state *state, double share, sn_error *error) {
    watcher *w = user;
    assert_int_equal(state->frame, 0);
    assert_true(w->calls < 64);
    w->shares[w->calls++] = share;
    return w->calls == w->stop_at ? sn_fail(error, SN_ERROR_INPUT, "enough") : SN_OK;
}

static void somebody_watches_frame_by_frame(void **state) {
    (void)state;
    sn_scene bent;
    watcher w = {0};
    sn_error error = {0};
    make_bent(&bent, SN_SOLVER_XPBD, 4);
    bent.run_in = 0.5 - 1.0 / 96.0; /* 47 substeps: eleven frames and three quarters */
    simulation s = start(&bent);
    const sn_step_options options = {.watch = look, .user = &w};
    assert_int_equal(sn_settle(s.model, s.state, &options, NULL), SN_OK);
    assert_int_equal(w.calls, 12);
    for (int i = 0; i < w.calls; i++) {
        double t = fmin(4.0 * (i + 1) / 47.0, 1.0);
        assert_true(fabs(w.shares[i] - t * t * (3.0 - 2.0 * t)) < 1e-12);
    }
    assert_true(w.shares[11] == 1.0);
    sn_state_reset(s.model, s.state);
    w = (watcher){.stop_at = 5};
    assert_int_equal(sn_settle(s.model, s.state, &options, &error), SN_ERROR_INPUT);
    assert_string_equal(error.text, "enough");
    assert_int_equal(w.calls, 5);
    finish(&s);
}

/* A pre-roll shorter than a substep still arrives. */
static void a_run_in_of_no_time_arrives(void **state) {
    (void)state;
    sn_scene bent;
    make_bent(&bent, SN_SOLVER_QN, 0);
    bent.preroll = bent.run_in = 1e-15;
    simulation s = start(&bent);
    assert_int_equal(sn_settle(s.model, s.state, NULL, NULL), SN_OK);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index i = 0; i < m->site_count; i++)
        for (sn_index k = m->sites[i].begin; k < m->sites[i].end; k++) {
            sn_vec3 rest = m->rest[m->kinematic_points[k]];
            sn_vec3 goal = m->sites[i].joint == SN_NONE ? rest : sn_rigid_apply(sn_motion_pose(&bent.motion, m->sites[i].joint, 0.0), rest);
            assert_true(sn_distance(position(&s, m->kinematic_points[k]), goal) < 1e-12);
        }
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_in_is_the_motion_it_describes),
        cmocka_unit_test(what_is_left_of_the_preroll_holds),
        cmocka_unit_test(somebody_watches_frame_by_frame),
        cmocka_unit_test(a_run_in_of_no_time_arrives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
