/* Signs of an explosion, the longest edge, tears: what the statistics say of runs that go wrong, and do not say of those that go well. */
#include "../../lib/sim/rows.h"
#include "sim_inside.h"

static sn_statistics *statistics(const simulation *s) { return &s->state->muscles[0].statistics; }
static void measure(simulation *s) { sn_statistics_measure(&s->model->muscles[0], &s->state->muscles[0]); }
static sn_point *point(const simulation *s, sn_index i) { return &s->state->muscles[0].points[i]; }

/* The far bone moves by `way` along -z within a millisecond, half-way into the second frame. */
static void jump(sn_scene *scene, double way) {
    sn_joint *joint = &scene->motion.joints[0];
    joint->kind = SN_JOINT_POSE;
    joint->key_count = 2;
    joint->keys = SN_NEW(sn_pose_key, 2);
    joint->keys[0] = (sn_pose_key){1.5 / 24, sn_rigid_identity()};
    joint->keys[1] = (sn_pose_key){1.5 / 24 + 1e-3, {{1, 0, 0, 0}, {0, 0, -way}}};
}

static double length(const simulation *s, sn_index a, sn_index b) { return sn_distance(position(s, a), position(s, b)); }

/* ---- the longest edge ------------------------------------------------------------------------------------------------------- */

/* Bent and contracting; the greatest ratio over all rows, one by one. */
static void the_longest_edge_is_that_of_all_rows(void **state) {
    (void)state;
    for (int frame = 0; frame < 6; frame++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.1, 1.2);
        set_keys(&scene.muscles[0].activation, 0.0, 0.0, 0.2, 1.0);
        simulation s = start(&scene);
        step_frames(&s, frame, NULL);
        const sn_model_muscle *m = &s.model->muscles[0];
        double most = 0.0;
        sn_index points[4], at[2] = {SN_NONE, SN_NONE};
        for (sn_index r = 0; r < sn_row_count(s.model, 0, SN_ROWS_MESH); r++) {
            sn_row_points(s.model, 0, SN_ROWS_MESH, r, points);
            double goal = inputs_of(&s)->goals[m->distance_start[SN_ROWS_MESH] + r];
            double ratio = length(&s, points[0], points[1]) / fmax(goal, SN_LEAST_GOAL * m->mean_edge);
            if (ratio > most) most = ratio, at[0] = points[0], at[1] = points[1];
        }
        assert_true(statistics(&s)->largest_edge_ratio == most);
        assert_memory_equal(statistics(&s)->largest_edge, at, sizeof at);
        assert_true(frame == 0 ? fabs(most - 1.0) < 1e-12 : most > 1.05); /* at rest every edge has its goal length */
        finish(&s);
    }
}

/* Stretched to four times its length along z: no edge by more, and those along z by as much; under each of the three ways to judge. */
static void a_stretched_surface_says_how_far(void **state) {
    (void)state;
    for (int way = 0; way < 3; way++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver = sn_solver_defaults(SN_SOLVER_QN);
        if (way == 1) scene.muscles[0].stretch = SN_STRETCH_MEMBRANE;
        if (way == 2) scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = 0.0;
        simulation s = start(&scene);
        assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_MESH) > 0, way == 0);
        assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_MEMBRANE) > 0, way == 1);
        measure(&s);
        assert_true(fabs(statistics(&s)->largest_edge_ratio - 1.0) < 1e-9);
        for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) point(&s, i)->z *= 4.0;
        measure(&s);
        double ratio = statistics(&s)->largest_edge_ratio;
        const sn_index *e = statistics(&s)->largest_edge;
        assert_true(ratio <= 4.0 + 1e-9 && ratio > 3.0);
        double rest = sn_distance(s.model->muscles[0].rest[e[0]], s.model->muscles[0].rest[e[1]]);
        assert_true(fabs(length(&s, e[0], e[1]) / rest - ratio) < 1e-9);
        finish(&s);
    }
}

/* Of the membrane: the greatest over the edges of all triangles, whatever the bound by the strain passes over. */
static void the_membrane_looks_at_every_edge_that_counts(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    scene.muscles[0].stretch = SN_STRETCH_MEMBRANE;
    set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.1, 1.2);
    simulation s = start(&scene);
    step_frames(&s, 3, NULL);
    const sn_model_muscle *m = &s.model->muscles[0];
    double most = 0.0;
    sn_index points[4];
    for (sn_index r = 0; r < sn_row_count(s.model, 0, SN_ROWS_MEMBRANE); r++)
        for (int i = 0; i < 3; i++) {
            sn_row_points(s.model, 0, SN_ROWS_MEMBRANE, r, points);
            sn_index a = points[i], b = points[(i + 1) % 3];
            most = fmax(most, length(&s, a, b) / fmax(sn_distance(m->rest[a], m->rest[b]), SN_LEAST_GOAL * m->mean_edge));
        }
    assert_true(most > 1.05 && fabs(statistics(&s)->largest_edge_ratio / most - 1.0) < 1e-9);
    finish(&s);
}

/* An edge that is to vanish has no ratio of its own: as long as the mean edge it is ten times what counts, a thousandth of it nothing. */
static void a_goal_of_nothing_is_no_explosion(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_index row = m->distance_start[SN_ROWS_MESH] + 7;
    const sn_index *p = m->distances[row].point;
    inputs_of(&s)->goals[row] = 0.0;
    measure(&s);
    assert_true(fabs(statistics(&s)->largest_edge_ratio - length(&s, p[0], p[1]) / (0.1 * m->mean_edge)) < 1e-9);
    *point(&s, p[1]) = *point(&s, p[0]);
    point(&s, p[1])->x += 1e-3 * m->mean_edge;
    measure(&s);
    assert_true(statistics(&s)->largest_edge_ratio < 5.0); /* its neighbours are longer now */
    assert_false(statistics(&s)->largest_edge[0] == p[0] && statistics(&s)->largest_edge[1] == p[1]);
    finish(&s);
}

/* ---- signs of an explosion -------------------------------------------------------------------------------------------------- */

static void each_sign_has_its_threshold(void **state) {
    (void)state;
    sn_statistics s = {.volume_error = 0.5, .largest_edge_ratio = 10.0};
    assert_int_equal(sn_explosions(&s), 0);
    s.volume_error = -0.5000001;
    assert_int_equal(sn_explosions(&s), SN_EXPLODED_VOLUME);
    s.volume_error = 0.5000001;
    assert_int_equal(sn_explosions(&s), SN_EXPLODED_VOLUME);
    s.largest_edge_ratio = 10.0000001;
    s.nan_points = 1;
    assert_int_equal(sn_explosions(&s), SN_EXPLODED_VOLUME | SN_EXPLODED_EDGE | SN_EXPLODED_POINTS);
    s = (sn_statistics){
        .volume_error = NAN, .largest_edge_ratio = NAN, .stop_reason = SN_STOP_STALLED}; /* an open surface without an edge */
    assert_int_equal(sn_explosions(&s), 0);
    s.stop_reason = SN_STOP_FAILED;
    assert_int_equal(sn_explosions(&s), SN_EXPLODED_SOLVER);
}

/* A muscle that is blown up, whether or not its volume is kept; one point far out; one point that is nowhere. */
static void shapes_that_exploded_show_it(void **state) {
    (void)state;
    for (int kept = 0; kept < 2; kept++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        if (!kept) scene.muscles[0].stiffness_volume = 0.0;
        simulation s = start(&scene);
        assert_int_equal(s.model->muscles[0].keeps_volume, kept);
        measure(&s);
        assert_int_equal(sn_explosions(statistics(&s)), 0);
        for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) point(&s, i)->x *= 1.6;
        measure(&s);
        assert_int_equal(sn_explosions(statistics(&s)), SN_EXPLODED_VOLUME);
        sn_state_reset(s.model, s.state);
        point(&s, 100)->x += 30.0 * s.model->muscles[0].mean_edge;
        measure(&s);
        assert_true(sn_explosions(statistics(&s)) & SN_EXPLODED_EDGE);
        assert_true(statistics(&s)->largest_edge[0] == 100 || statistics(&s)->largest_edge[1] == 100);
        point(&s, 100)->x = NAN;
        measure(&s);
        assert_int_equal(sn_explosions(statistics(&s)), SN_EXPLODED_POINTS); /* its edges and the volume have no length and no size */
        finish(&s);
    }
}

/* A quiet motion gives no sign under any solver and scheme, and the jump of a bone by two lengths does under all of them. */
static void runs_explode_where_they_do(void **state) {
    (void)state;
    for (int kind = 0; kind < 8; kind++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        bool jumps = kind % 2;
        if (kind / 2 == 1) scene.solver = sn_solver_defaults(SN_SOLVER_QN);
        if (kind / 2 >= 2) scene.solver.scheme = kind / 2 == 2 ? SN_SCHEME_ROMEO : SN_SCHEME_KOHOUT;
        if (jumps)
            jump(&scene, 10.0 * FUSIFORM.length);
        else
            set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 1.0, 0.3);
        simulation s = start(&scene);
        unsigned signs = 0;
        for (int frame = 0; frame < 6; frame++) {
            step_frames(&s, 1, NULL);
            signs |= sn_explosions(statistics(&s));
            if (frame == 0) assert_int_equal(signs, 0); /* before the jump */
            assert_int_equal(statistics(&s)->nan_points, 0);
        }
        assert_int_equal((signs & SN_EXPLODED_EDGE) != 0, jumps);
        if (!jumps) assert_int_equal(signs, 0);
        finish(&s);
    }
}

/* ---- tears ------------------------------------------------------------------------------------------------------------------ */

/* Ten lengths tear a muscle for good; half a length a substep of qn, which mends it: the frames after that do not say it any more. */
static void a_jump_tears_in_its_frame(void **state) {
    (void)state;
    for (int method = 0; method < 2; method++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver = sn_solver_defaults(method == 0 ? SN_SOLVER_XPBD : SN_SOLVER_QN);
        jump(&scene, (method == 0 ? 10.0 : 0.5) * FUSIFORM.length);
        simulation s = start(&scene);
        step_frames(&s, 1, NULL);
        assert_false(statistics(&s)->torn);
        assert_true(statistics(&s)->torn_substeps == 0);
        step_frames(&s, 1, NULL);
        assert_true(statistics(&s)->torn);
        assert_int_equal(statistics(&s)->torn_substeps > 0, method == 1);
        for (int frame = 0; frame < 4; frame++) {
            step_frames(&s, 1, NULL);
            const sn_residual *off = &statistics(&s)->residuals[SN_ROWS_MESH];
            bool far = off->max > SN_FAR_STRETCHED || off->rms > SN_FAR_IN_THE_MEAN;
            assert_int_equal(statistics(&s)->torn, far || statistics(&s)->torn_substeps > 0);
        }
        assert_int_equal(statistics(&s)->torn, method == 0);
        finish(&s);
    }
}

/* A substep that began torn counts for its frame after a stop within the frame, too. */
static void a_stop_does_not_forget_a_tear(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &FUSIFORM);
        scenes[k].solver = sn_solver_defaults(SN_SOLVER_QN);
        scenes[k].solver.substeps = 8;
        jump(&scenes[k], 0.5 * FUSIFORM.length);
        runs[k] = start(&scenes[k]);
    }
    step_frames(&runs[0], 2, NULL);
    const sn_step_options stop = {.stop_substep = 7};
    char *bytes;
    size_t size;
    step_frames(&runs[1], 1, NULL);
    assert_int_equal(sn_step(runs[1].model, runs[1].state, &stop, NULL), SN_STOPPED);
    assert_int_equal(sn_state_pack(runs[1].model, runs[1].state, &bytes, &size, NULL), SN_OK);
    sn_state_reset(runs[1].model, runs[1].state);
    assert_int_equal(sn_state_unpack(runs[1].model, bytes, size, runs[1].state, NULL), SN_OK);
    step_frames(&runs[1], 1, NULL);
    assert_true(statistics(&runs[0])->torn_substeps > 0 && statistics(&runs[0])->torn);
    assert_true(statistics(&runs[1])->torn_substeps == statistics(&runs[0])->torn_substeps && statistics(&runs[1])->torn);
    free(bytes);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_longest_edge_is_that_of_all_rows),
        cmocka_unit_test(a_stretched_surface_says_how_far),
        cmocka_unit_test(the_membrane_looks_at_every_edge_that_counts),
        cmocka_unit_test(a_goal_of_nothing_is_no_explosion),
        cmocka_unit_test(each_sign_has_its_threshold),
        cmocka_unit_test(shapes_that_exploded_show_it),
        cmocka_unit_test(runs_explode_where_they_do),
        cmocka_unit_test(a_jump_tears_in_its_frame),
        cmocka_unit_test(a_stop_does_not_forget_a_tear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
