/* The error of every row by itself: the same that the statistics sum up, and what the points say. */
#include "sim_scene.h"

/* Bent, contracting and in the middle of a frame. */
static simulation bent(sn_scene *scene, const fusiform *f) {
    static const sn_step_options half = {.stop_substep = 3, .stop_iteration = 1};
    make_scene(scene, f);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.2, 0.6);
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 0.2, 1.0);
    scene->muscles[0].contraction = 0.4;
    simulation s = start(scene);
    step_frames(&s, 2, NULL);
    assert_int_equal(sn_step(s.model, s.state, &half, NULL), SN_STOPPED);
    return s;
}

static double *errors_of(const simulation *s, sn_row_kind kind, sn_index *count) {
    *count = sn_row_count(s->model, 0, kind);
    double *errors = SN_NEW(double, *count);
    assert_non_null(errors);
    sn_row_errors(s->model, s->state, 0, kind, errors);
    return errors;
}

static void errors_sum_up_to_the_statistics(void **state) {
    (void)state;
    sn_scene scene;
    simulation s = bent(&scene, &FUSIFORM);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_residual *r = &s.state->muscles[0].statistics.residuals[kind];
        sn_index count;
        double *errors = errors_of(&s, (sn_row_kind)kind, &count), sum = 0.0, most = 0.0;
        assert_int_equal(count, s.model->plan.muscles[0].groups[kind].rows);
        assert_true((count > 0) == (kind != SN_ROWS_MEMBRANE && kind != SN_ROWS_EXTERNAL &&
                                    kind != SN_ROWS_CONTACT)); /* springs run in its place; contact is off */
        if (count == 0) {
            free(errors);
            continue;
        }
        for (sn_index i = 0; i < count; i++) {
            sum += errors[i] * errors[i];
            most = fmax(most, errors[i]);
        }
        assert_true(fabs(sqrt(sum / count) - r->rms) <= 1e-14 * r->rms);
        assert_true(memcmp(&most, &r->max, sizeof most) == 0);
        assert_true(memcmp(&errors[r->worst], &r->max, sizeof most) == 0);
        if (kind != SN_ROWS_AREA) assert_true(r->max > 0.0);
        free(errors);
    }
    finish(&s);
}

/* At rest the rows have no error; with one vertex moved, those at it have, by what its edges have become longer. */
static void a_vertex_out_of_place_shows_at_its_rows(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    const sn_index moved = m->vertex_count / 2;
    s.state->muscles[0].points[moved].x += 0.5 * m->mean_edge;
    for (int kind = 0; kind < SN_ROWS_VOLUME; kind++) {
        sn_index count, points[4], touched = 0;
        double *errors = errors_of(&s, (sn_row_kind)kind, &count);
        for (sn_index i = 0; i < count; i++) {
            int n = sn_row_points(s.model, 0, (sn_row_kind)kind, i, points);
            assert_int_equal(n, kind < SN_DISTANCE_KINDS ? 2 : kind == SN_ROWS_DIHEDRAL ? 4 : 3);
            bool at_it = false;
            for (int k = 0; k < n; k++) at_it = at_it || points[k] == moved;
            touched += at_it;
            if (!at_it) assert_true(errors[i] < 1e-12);
            if (at_it && kind == SN_ROWS_MESH) {
                double was = sn_distance(m->rest[points[0]], m->rest[points[1]]),
                       is = sn_distance(position(&s, points[0]), position(&s, points[1]));
                assert_true(fabs(errors[i] - fabs(is - was) / m->mean_edge) < 1e-12);
            }
        }
        assert_true((touched > 0) == (kind != SN_ROWS_INTERNAL && kind != SN_ROWS_MEMBRANE));
        free(errors);
    }
    finish(&s);
}

static void a_collapsed_hinge_has_no_error(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    sn_index count, points[4];
    assert_int_equal(sn_row_points(s.model, 0, SN_ROWS_DIHEDRAL, 0, points), 4);
    s.state->muscles[0].points[points[2]] = s.state->muscles[0].points[points[0]];
    double *errors = errors_of(&s, SN_ROWS_DIHEDRAL, &count);
    assert_true(isnan(errors[0]));
    free(errors);
    finish(&s);
}

/* The way to the goal volume is the way that a rigid projection of the volume goes; no row, no way. */
static void the_way_to_the_volume_is_that_of_its_projection(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = 1e30;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index i = 0; i < m->vertex_count; i++) s.state->muscles[0].points[i].x *= 1.001; /* 0.1 % more volume */
    sn_vec3 *gradients = SN_NEW(sn_vec3, m->vertex_count), *before = SN_NEW(sn_vec3, m->vertex_count);
    double *moves = SN_NEW(double, m->vertex_count), most = 0.0;
    sn_volume_moves(s.model, s.state, 0, gradients, moves);
    for (sn_index i = 0; i < m->vertex_count; i++) before[i] = position(&s, i);
    sn_project(s.model, s.state, 0, SN_ROWS_VOLUME);
    for (sn_index i = 0; i < m->vertex_count; i++) {
        assert_true(fabs(sn_distance(position(&s, i), before[i]) / m->mean_edge - moves[i]) < 1e-12);
        if (m->inverse_mass[i] == 0.0) assert_true(moves[i] == 0.0);
        most = fmax(most, moves[i]);
    }
    assert_true(most > 1e-5);
    free(gradients);
    free(before);
    free(moves);
    finish(&s);
}

/* ---- how far an iteration moves a point ----------------------------------------------------------------------------------------- */

typedef struct watch {
    double moves[8];
    int count;
} watch;

static void take_move(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    watch *w = user;
    (void)number, (void)stage;
    for (int i = 0; i < value_count; i++)
        if (strcmp(values[i].name, "mean_move") == 0 && w->count < 8) w->moves[w->count++] = values[i].number;
}

/* [K21] figure 7: the second iteration's mean move, against the points of two runs that stop before and after it. */
static void the_trace_tells_how_far_an_iteration_moves(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation runs[3];
    watch w = {0};
    sn_trace trace = {.receive = take_move, .user = &w, .stop_after = -1};
    for (int k = 0; k < 3; k++) {
        const sn_step_options options = {.stop_substep = 1, .stop_iteration = k + 1, .trace = k == 2 ? &trace : NULL};
        make_scene(&scenes[k], &FUSIFORM);
        scenes[k].solver.iterations = 4;
        set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, 0.2, 0.6);
        runs[k] = start(&scenes[k]);
        assert_int_equal(sn_step(runs[k].model, runs[k].state, &options, NULL), SN_STOPPED);
    }
    const sn_model_muscle *m = &runs[0].model->muscles[0];
    double sum = 0.0;
    sn_index free_points = 0;
    for (sn_index i = 0; i < m->point_count; i++) {
        sum += sn_distance(position(&runs[0], i), position(&runs[1], i));
        free_points += m->inverse_mass[i] > 0.0;
    }
    assert_int_equal(w.count, 3);
    assert_true(w.moves[1] > 0.0 && fabs(w.moves[1] - sum / (free_points * m->mean_edge)) < 1e-12 * w.moves[1]);
    for (int k = 0; k < 3; k++) finish(&runs[k]);
}

static void under_qn_there_is_no_such_move(void **state) {
    (void)state;
    sn_scene scene;
    watch w = {0};
    sn_trace trace = {.receive = take_move, .user = &w, .stop_after = -1};
    const sn_step_options options = {.trace = &trace};
    make_scene(&scene, &FUSIFORM);
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    simulation s = start(&scene);
    step_frames(&s, 1, &options);
    assert_true(w.count > 0 && isnan(w.moves[0]));
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_sum_up_to_the_statistics),
        cmocka_unit_test(a_vertex_out_of_place_shows_at_its_rows),
        cmocka_unit_test(a_collapsed_hinge_has_no_error),
        cmocka_unit_test(the_way_to_the_volume_is_that_of_its_projection),
        cmocka_unit_test(the_trace_tells_how_far_an_iteration_moves),
        cmocka_unit_test(under_qn_there_is_no_such_move),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
