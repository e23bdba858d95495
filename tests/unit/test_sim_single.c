/* test_sim_single.c -- `xpbd` in single precision: what holds in double to rounding holds here to single accuracy. */
#include "sim_inside.h"

/* A muscle that contracts, swells and bends. */
static void make_usual(sn_scene *scene, const fusiform *f, sn_precision precision) {
    make_scene(scene, f);
    scene->solver.precision = precision;
    scene->muscles[0].contraction = 0.3;
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 0.5, 1.0);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, -0.5);
}

static double greatest_difference(const simulation *a, const simulation *b, sn_rigid by) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++)
        most = fmax(most, sn_distance(sn_rigid_apply(by, position(a, i)), position(b, i)));
    return most / a->model->muscles[0].diagonal;
}

static void rest_stays_at_rest(void **state) {
    (void)state;
    for (int law = 0; law < 3; law++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver.precision = SN_PRECISION_SINGLE;
        scene.muscles[0].law = (sn_fiber_law)law;
        scene.muscles[0].rest_activation = scene.muscles[0].activation.constant = 0.8;
        simulation s = start(&scene);
        step_frames(&s, 48, NULL);
        assert_true(greatest_move(&s) < 1e-5 * s.model->muscles[0].diagonal);
        finish(&s);
    }
}

/* The rows are projected in the same order: what differs is rounding. */
static void the_motion_is_that_of_double_precision(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    for (int k = 0; k < 2; k++) {
        make_usual(&scenes[k], &FUSIFORM, (sn_precision)k);
        s[k] = start(&scenes[k]);
        step_frames(&s[k], 18, NULL);
    }
    double moved = greatest_move(&s[0]) / s[0].model->muscles[0].diagonal, apart = greatest_difference(&s[0], &s[1], sn_rigid_identity());
    assert_true(moved > 0.04);
    assert_true(apart < 1e-5);
    assert_true(apart > 0.0); /* it is another precision */
    finish(&s[0]);
    finish(&s[1]);
}

static void volume_reaches_its_goal(void **state) {
    (void)state;
    sn_scene scene;
    make_usual(&scene, &FUSIFORM, SN_PRECISION_SINGLE);
    sn_knots *ratio = &scene.muscles[0].volume_ratio;
    ratio->count = 2;
    ratio->x = SN_NEW(double, 2);
    ratio->y = SN_NEW(double, 2);
    ratio->x[1] = 1.0, ratio->y[0] = 1.0, ratio->y[1] = 1.5;
    simulation s = start(&scene);
    for (int frame = 0; frame < 30; frame++) {
        step_frames(&s, 1, NULL);
        if (frame >= 20) assert_true(fabs(s.state->muscles[0].statistics.volume_error) < 1e-4);
    }
    assert_true(s.state->muscles[0].statistics.volume_ratio > 1.49);
    finish(&s);
}

/* A float counts a kilometre in steps of 6e-5 m; relative to the muscle's middle nothing of that is felt. */
static void a_kilometre_away_it_is_the_same(void **state) {
    (void)state;
    sn_rigid by = {sn_quat_normalize((sn_quat){0.3, -0.5, 0.7, 0.2}), {600, -700, 400}};
    sn_scene here, there;
    make_usual(&here, &FUSIFORM, SN_PRECISION_SINGLE);
    make_usual(&there, &FUSIFORM, SN_PRECISION_SINGLE);
    turn_and_move(&there, by);
    simulation a = start(&here), b = start(&there);
    step_frames(&a, 18, NULL);
    step_frames(&b, 18, NULL);
    double apart = greatest_difference(&a, &b, by);
    assert_true(apart < 1e-5);
    finish(&a);
    finish(&b);
}

/* From two tenths of a millimetre to two hundred metres, with stiffness for such masses (numerics.md 1: k h^2 w is what is felt). */
static void size_does_not_matter(void **state) {
    (void)state;
    static const double scales[] = {1e-3, 1e3};
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation s[2];
        fusiform f = FUSIFORM;
        f.length *= scales[i], f.radius *= scales[i];
        for (int k = 0; k < 2; k++) {
            make_usual(&scenes[k], &f, (sn_precision)k);
            scenes[k].muscles[0].stiffness_relaxed *= pow(scales[i], 3.0);
            scenes[k].muscles[0].stiffness_active *= pow(scales[i], 3.0);
            scenes[k].muscles[0].stiffness_dihedral *= pow(scales[i], 2.0);
            s[k] = start(&scenes[k]);
            step_frames(&s[k], 12, NULL);
        }
        double apart = greatest_difference(&s[0], &s[1], sn_rigid_identity());
        assert_true(apart < 1e-5);
        assert_int_equal(s[1].state->muscles[0].statistics.skipped_hinges, s[0].state->muscles[0].statistics.skipped_hinges);
        finish(&s[0]);
        finish(&s[1]);
    }
}

static void attached_points_are_exactly_on_their_bones(void **state) {
    (void)state;
    sn_scene scene;
    make_usual(&scene, &FUSIFORM, SN_PRECISION_SINGLE);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (int frame = 1; frame <= 12; frame++) {
        sn_rigid pose;
        step_frames(&s, 1, NULL);
        sn_motion_poses(&scene.motion, s.state->frame / scene.rate, &pose);
        for (sn_index site = 0; site < m->site_count; site++) {
            for (sn_index k = m->sites[site].begin; k < m->sites[site].end; k++) {
                sn_index v = m->kinematic_points[k];
                sn_vec3 want = m->sites[site].joint == SN_NONE ? m->rest[v] : sn_rigid_apply(pose, m->rest[v]), p = position(&s, v);
                assert_true(p.x == want.x && p.y == want.y && p.z == want.z);
            }
        }
    }
    assert_true(m->site_count == 2);
    finish(&s);
}

/* What is off is absent: a scene in double has no array of it, and says so in its plan. */
static void double_precision_pays_nothing(void **state) {
    (void)state;
    size_t bytes[2];
    for (int k = 0; k < 2; k++) {
        sn_scene scene;
        make_usual(&scene, &FUSIFORM, (sn_precision)k);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        bytes[k] = s.model->plan.muscles[0].state_bytes;
        assert_true(m->single == (k == 1) && (m->distance_pairs != NULL) == (k == 1) && (m->hinge_pairs != NULL) == (k == 1));
        if (k == 1)
            assert_int_equal(bytes[1] - bytes[0], (size_t)(m->point_count + m->vertex_count) * sizeof(sn_single_point) + sizeof(sn_vec3));
        finish(&s);
    }
}

/* A state of one precision is no start for the other. */
static void states_of_the_other_precision_are_refused(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    char *bytes;
    size_t size;
    sn_error error = {0};
    for (int k = 0; k < 2; k++) {
        make_usual(&scenes[k], &FUSIFORM, (sn_precision)k);
        s[k] = start(&scenes[k]);
    }
    assert_int_equal(sn_state_pack(s[0].model, s[0].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s[1].model, bytes, size, s[1].state, &error), SN_ERROR_INPUT);
    free(bytes);
    finish(&s[0]);
    finish(&s[1]);
}

static void it_is_for_xpbd_only(void **state) {
    (void)state;
    sn_scene scene;
    sn_model *model = NULL;
    sn_error error = {0};
    make_usual(&scene, &FUSIFORM, SN_PRECISION_SINGLE);
    scene.solver.method = SN_SOLVER_QN;
    assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "solver.precision"));
    sn_scene_free(&scene);
}

/* A point that is not finite reaches others by no row; wild ones come back. */
static void wild_points_do_no_harm(void **state) {
    (void)state;
    for (int nan = 0; nan < 2; nan++) {
        sn_scene scene;
        make_usual(&scene, &FUSIFORM, SN_PRECISION_SINGLE);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        sn_muscle_state *ms = &s.state->muscles[0];
        uint64_t random = 7;
        for (sn_index i = 0; i < m->point_count && !nan; i++)
            if (ms->points[i].w > 0.0) ms->points[i].x += 0.5 * (sn_random(&random) - 0.5), ms->points[i].z += sn_random(&random) - 0.5;
        if (nan) ms->points[m->vertex_count / 2].x = NAN;
        step_frames(&s, 24, NULL);
        assert_int_equal(ms->statistics.nan_points, nan);
        for (sn_index i = 0; i < m->point_count; i++)
            if (!nan || i != m->vertex_count / 2) assert_true(sn_distance(position(&s, i), m->rest[i]) < 3.0 * m->diagonal);
        finish(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rest_stays_at_rest),
        cmocka_unit_test(the_motion_is_that_of_double_precision),
        cmocka_unit_test(volume_reaches_its_goal),
        cmocka_unit_test(a_kilometre_away_it_is_the_same),
        cmocka_unit_test(size_does_not_matter),
        cmocka_unit_test(attached_points_are_exactly_on_their_bones),
        cmocka_unit_test(double_precision_pays_nothing),
        cmocka_unit_test(states_of_the_other_precision_are_refused),
        cmocka_unit_test(it_is_for_xpbd_only),
        cmocka_unit_test(wild_points_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
