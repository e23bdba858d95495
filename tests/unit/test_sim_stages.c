/* test_sim_stages.c -- groups of muscles and the stages of their steps (group.c, step.c): together or alone, at their own times, watched,
 * stopped and continued. */
#include "sim_inside.h"

/* Two muscles, the second smaller and on the same bones; both bend and contract. */
static void make_pair(sn_scene *scene, sn_solver_method method) {
    fusiform small = FUSIFORM, other = FUSIFORM;
    small.rings = 9, small.sectors = 6;
    other.rings = 8, other.sectors = 5, other.structure = false;
    make_scene(scene, &small);
    add_muscle(scene, "other", &other);
    scene->solver = sn_solver_defaults(method);
    scene->solver.substeps = 2;
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, -0.7);
    for (int i = 0; i < 2; i++) set_keys(&scene->muscles[i].activation, 0.0, 0.0, 0.5, 0.4);
}

/* All muscles in one group; its state anew. */
static simulation start_together(sn_scene *scene) {
    simulation s = {.scene = scene};
    assert_int_equal(sn_model_create(scene, &s.model, NULL), SN_OK);
    for (sn_index i = 0; i < s.model->group_count; i++) sn_group_free(&s.model->groups[i]);
    s.model->group_count = 1;
    assert_int_equal(sn_group_create(s.model, 2, (const sn_index[2]){0, 1}, &s.model->groups[0], NULL), SN_OK);
    for (sn_index i = 0; i < 2; i++) s.model->muscles[i].group = 0, s.model->muscles[i].member = i;
    assert_int_equal(sn_state_create(s.model, &s.state, NULL), SN_OK);
    return s;
}

/* The second muscle takes so many substeps a frame. */
static simulation start_with_own_substeps(sn_scene *scene, sn_index substeps) {
    simulation s = {.scene = scene};
    assert_int_equal(sn_model_create(scene, &s.model, NULL), SN_OK);
    s.model->groups[1].substeps = substeps;
    s.model->groups[1].substep_duration = s.model->frame_duration / substeps;
    assert_int_equal(sn_state_create(s.model, &s.state, NULL), SN_OK);
    return s;
}

static void assert_same(const simulation *a, const simulation *b, sn_index muscle) {
    const sn_muscle_state *x = &a->state->muscles[muscle], *y = &b->state->muscles[muscle];
    size_t n = (size_t)a->model->muscles[muscle].point_count;
    assert_memory_equal(x->points, y->points, n * sizeof *x->points);
    assert_memory_equal(x->velocities, y->velocities, n * sizeof *x->velocities);
}

/* Greatest distance of a point in one run from where it is in the other, diagonals. */
static double apart(const simulation *a, const simulation *b, sn_index muscle) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[muscle].point_count; i++)
        most = fmax(most, sn_distance(sn_point_position(&a->state->muscles[muscle].points[i]),
                                      sn_point_position(&b->state->muscles[muscle].points[i])));
    return most / a->model->muscles[muscle].diagonal;
}

static void count_steps(void *user, int64_t number, const char *stage, const sn_trace_value *values, int count) {
    (void)number, (void)stage, (void)values, (void)count;
    ++*(int *)user;
}

/* Rows of one muscle know nothing of the other's: Gauss-Seidel does the same to both, in one group or in two. */
static void xpbd_together_is_as_alone(void **state) {
    (void)state;
    sn_scene scenes[2];
    for (int k = 0; k < 2; k++) make_pair(&scenes[k], SN_SOLVER_XPBD);
    scenes[0].muscles[1].iterations = scenes[1].muscles[1].iterations = 5;
    simulation alone = start(&scenes[0]), together = start_together(&scenes[1]);
    for (int frame = 0; frame < 3; frame++) {
        step_frames(&alone, 1, NULL);
        step_frames(&together, 1, NULL);
        for (sn_index i = 0; i < 2; i++) assert_same(&alone, &together, i);
    }
    finish(&alone);
    finish(&together);
}

/* Under qn the search is one for both; where it ends is the same. */
static void qn_together_converges_to_what_it_does_alone(void **state) {
    (void)state;
    for (int matrix = SN_PRECONDITION_SCALAR; matrix <= SN_PRECONDITION_TWO_LEVEL; matrix++) {
        sn_scene scenes[2];
        for (int k = 0; k < 2; k++) {
            make_pair(&scenes[k], SN_SOLVER_QN);
            scenes[k].solver.preconditioner = (sn_preconditioning)matrix;
            scenes[k].solver.iterations = 200;
            scenes[k].solver.tolerance = 1e-10;
        }
        simulation alone = start(&scenes[0]), together = start_together(&scenes[1]);
        step_frames(&alone, 4, NULL);
        step_frames(&together, 4, NULL);
        for (sn_index i = 0; i < 2; i++) {
            assert_true(apart(&alone, &together, i) < 1e-6);
            assert_true(fabs(together.state->muscles[i].statistics.volume_error) < 1e-3);
            assert_true(together.state->muscles[i].statistics.residual < 1e-6);
        }
        assert_true(greatest_move(&together) > 1e-3);
        finish(&alone);
        finish(&together);
    }
}

/* Stopped in the middle of a step, saved, read elsewhere and gone on with; watched; and in one go. */
static void a_group_stops_and_goes_on(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation runs[3];
    int seen = 0;
    char *bytes;
    size_t size;
    sn_trace trace = {.receive = count_steps, .user = &seen, .stop_after = -1};
    for (int k = 0; k < 3; k++) {
        make_pair(&scenes[k], SN_SOLVER_QN);
        runs[k] = start_together(&scenes[k]);
    }
    step_frames(&runs[0], 3, NULL);
    step_frames(&runs[1], 2, NULL);
    assert_int_equal(sn_step(runs[1].model, runs[1].state, &(sn_step_options){.stop_substep = 2, .stop_iteration = 3}, NULL), SN_STOPPED);
    assert_int_equal(sn_state_pack(runs[1].model, runs[1].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(runs[2].model, bytes, size, runs[2].state, NULL), SN_OK);
    free(bytes);
    step_frames(&runs[2], 1, &(sn_step_options){.trace = &trace});
    assert_true(seen > 0);
    for (sn_index i = 0; i < 2; i++) assert_same(&runs[0], &runs[2], i);
    for (int k = 0; k < 3; k++) finish(&runs[k]);
}

/* A group with three substeps beside one with two: each is as in a scene where all have as many; also after a pre-roll. */
static void a_group_steps_at_its_own_times(void **state) {
    (void)state;
    for (int method = SN_SOLVER_XPBD; method <= SN_SOLVER_QN; method++) {
        sn_scene scenes[3];
        for (int k = 0; k < 3; k++) {
            make_pair(&scenes[k], (sn_solver_method)method);
            scenes[k].preroll = 0.1;
        }
        scenes[2].solver.substeps = 3;
        simulation own = start_with_own_substeps(&scenes[0], 3), two = start(&scenes[1]), three = start(&scenes[2]);
        simulation *all[] = {&own, &two, &three};
        for (int k = 0; k < 3; k++) {
            assert_int_equal(sn_settle(all[k]->model, all[k]->state, NULL, NULL), SN_OK);
            step_frames(all[k], 3, NULL);
        }
        assert_same(&own, &two, 0);
        assert_same(&own, &three, 1);
        for (int k = 0; k < 3; k++) finish(all[k]);
    }
}

/* The group with fewer substeps is through when the other stops in its last; nothing happens to it twice. */
static void groups_of_different_times_stop_and_go_on(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    int seen = 0;
    sn_trace trace = {.receive = count_steps, .user = &seen, .stop_after = -1};
    for (int k = 0; k < 2; k++) {
        make_pair(&scenes[k], SN_SOLVER_QN);
        runs[k] = start_with_own_substeps(&scenes[k], 3);
    }
    step_frames(&runs[0], 2, NULL);
    assert_int_equal(sn_step(runs[1].model, runs[1].state, &(sn_step_options){.stop_substep = 3, .stop_iteration = 2}, NULL), SN_STOPPED);
    step_frames(&runs[1], 1, NULL);
    step_frames(&runs[1], 1, &(sn_step_options){.trace = &trace});
    assert_true(seen > 0);
    for (sn_index i = 0; i < 2; i++) assert_same(&runs[0], &runs[1], i);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(xpbd_together_is_as_alone),
        cmocka_unit_test(qn_together_converges_to_what_it_does_alone),
        cmocka_unit_test(a_group_stops_and_goes_on),
        cmocka_unit_test(a_group_steps_at_its_own_times),
        cmocka_unit_test(groups_of_different_times_stop_and_go_on),
    };
    return cmocka_run_group_tests_name("stages", tests, NULL, NULL);
}
