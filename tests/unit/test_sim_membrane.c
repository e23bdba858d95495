/* test_sim_membrane.c -- the neo-Hookean membrane (numerics.md 9) and the corotated matrix: gradient, goal shapes, settings, restarts. */
#include "sim_scene.h"

#include "../../lib/sim/qn.h"

static void make_membrane(sn_scene *scene, const fusiform *f) {
    make_scene(scene, f);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->muscles[0].stretch = SN_STRETCH_MEMBRANE;
}

/* dE/dx against central differences, relative to the largest force, at a crumpled pose and a goal shape that is not the rest shape. */
static void the_gradient_is_that_of_the_energy(void **state) {
    (void)state;
    static const sn_fiber_law LAWS[] = {SN_LAW_PROJECTED, SN_LAW_ISOCHORIC};
    for (int law = 0; law < 2; law++) {
        sn_scene scene;
        make_membrane(&scene, &FUSIFORM);
        scene.muscles[0].law = LAWS[law];
        scene.muscles[0].activation.constant = 0.6;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        sn_muscle_state *ms = &s.state->muscles[0];
        sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count);
        uint64_t random = 5;
        for (sn_index i = 0; i < m->point_count; i++) {
            double *c[3] = {&ms->points[i].x, &ms->points[i].y, &ms->points[i].z};
            for (int k = 0; k < 3; k++) *c[k] += 4e-3 * (sn_random(&random) - 0.5);
        }
        sn_rows_membrane.energy(m, ms, SN_ROWS_MEMBRANE, ms->points, 1.0, (sn_forces){&gradient->x, 3});
        double largest = 0.0, worst = 0.0, e = 1e-7;
        for (sn_index i = 0; i < m->vertex_count; i += 7) {
            double *c[3] = {&ms->points[i].x, &ms->points[i].y, &ms->points[i].z};
            const double found[3] = {gradient[i].x, gradient[i].y, gradient[i].z};
            for (int k = 0; k < 3; k++) {
                double at = *c[k];
                *c[k] = at + e;
                double high = sn_rows_membrane.energy(m, ms, SN_ROWS_MEMBRANE, ms->points, 1.0, (sn_forces){NULL, 3});
                *c[k] = at - e;
                double low = sn_rows_membrane.energy(m, ms, SN_ROWS_MEMBRANE, ms->points, 1.0, (sn_forces){NULL, 3});
                *c[k] = at;
                largest = fmax(largest, fabs(found[k]));
                worst = fmax(worst, fabs((high - low) / (2.0 * e) - found[k]));
            }
        }
        assert_true(worst < 1e-7 * largest);
        free(gradient);
        finish(&s);
    }
}

/* A square sheet of 1 cm with fibres along x, alone in space. */
static void make_sheet(sn_scene *scene, sn_fiber_law law, double activation) {
    enum { SIDE = 5 };
    fusiform f = FUSIFORM;
    f.pinned = 0.0, f.structure = f.fibers = false;
    make_membrane(scene, &f);
    sn_muscle *rig = &scene->muscles[0].rig;
    sn_mesh_free(&rig->mesh);
    assert_int_equal(sn_mesh_alloc(&rig->mesh, SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1), NULL), SN_OK);
    rig->fibers.directions = SN_NEW(sn_vec3, SIDE * SIDE);
    sn_triangle *t = rig->mesh.triangles;
    for (sn_index i = 0; i < SIDE * SIDE; i++) {
        rig->mesh.positions[i] = sn_v3(0.01 * (i % SIDE) / (SIDE - 1), 0.01 * (i / SIDE) / (SIDE - 1), 0.0);
        rig->fibers.directions[i] = sn_v3(i % 2 == 0 ? 1.0 : -1.0, 0, 0); /* axes have no sign */
        if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
        *t++ = (sn_triangle){{i, i + 1, i + SIDE}};
        *t++ = (sn_triangle){{i + 1, i + SIDE + 1, i + SIDE}};
    }
    scene->muscles[0].law = law;
    scene->muscles[0].activation.constant = activation;
    scene->muscles[0].damping = 20.0;
    scene->solver.iterations = 100;
}

/* methods.md 8.1: along the fibres (1 - a) of the length; across them 1 (projected) or 1 / sqrt(1 - a) (isochoric, g = 1). */
static void a_sheet_contracts_along_its_fibers(void **state) {
    (void)state;
    for (int law = 0; law < 2; law++) {
        sn_scene scene;
        make_sheet(&scene, law == 0 ? SN_LAW_PROJECTED : SN_LAW_ISOCHORIC, 0.8);
        simulation s = start(&scene);
        step_frames(&s, 60, NULL);
        double along = sn_distance(position(&s, 10), position(&s, 14)), across = sn_distance(position(&s, 2), position(&s, 22));
        double c = 1.0 - 0.5 * 0.8;
        assert_true(fabs(along / (0.01 * c) - 1.0) < 1e-6);
        assert_true(fabs(across / (law == 0 ? 0.01 : 0.01 / sqrt(c)) - 1.0) < 1e-6);
        finish(&s);
    }
}

static void rest_stays_at_rest(void **state) {
    (void)state;
    for (int corotated = 0; corotated < 2; corotated++) {
        sn_scene scene;
        make_membrane(&scene, &FUSIFORM);
        scene.muscles[0].rest_activation = scene.muscles[0].activation.constant = 0.8;
        scene.solver.preconditioner = (sn_preconditioning)corotated;
        simulation s = start(&scene);
        step_frames(&s, 5, NULL);
        assert_true(greatest_move(&s) < 1e-9);
        finish(&s);
    }
}

static void bend(sn_scene *scene, sn_stretch stretch, sn_preconditioning preconditioner) {
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.preconditioner = preconditioner;
    scene->muscles[0].stretch = stretch;
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, -1.0);
}

/* Both matrices lead to the same minimum of each step, with springs and with a membrane. */
static void matrices_do_not_change_the_solution(void **state) {
    (void)state;
    for (int stretch = 0; stretch < 2; stretch++) {
        sn_scene scenes[2];
        simulation s[2];
        for (int k = 0; k < 2; k++) {
            bend(&scenes[k], (sn_stretch)stretch, (sn_preconditioning)k);
            scenes[k].solver.iterations = 500;
            scenes[k].solver.tolerance = 1e-9;
            s[k] = start(&scenes[k]);
            step_frames(&s[k], 12, NULL);
        }
        double most = 0.0;
        for (sn_index i = 0; i < s[0].model->muscles[0].point_count; i++)
            most = fmax(most, sn_distance(position(&s[0], i), position(&s[1], i)));
        assert_true(most < 1e-6 * s[0].model->muscles[0].diagonal);
        finish(&s[0]);
        finish(&s[1]);
    }
}

static int64_t iterations_of(sn_preconditioning preconditioner) {
    sn_scene scene;
    int64_t sum = 0;
    bend(&scene, SN_STRETCH_SPRINGS, preconditioner);
    sn_channel_free(&scene.muscles[0].activation);
    scene.solver.iterations = 500;
    scene.solver.tolerance = 1e-7;
    simulation s = start(&scene);
    for (int frame = 0; frame < 24; frame++) {
        step_frames(&s, 1, NULL);
        sum += s.state->muscles[0].statistics.iterations;
    }
    finish(&s);
    return sum;
}

/* What the corotated matrix is for: fewer iterations to the same tolerance, here less than two thirds. */
static void knowing_directions_saves_iterations(void **state) {
    (void)state;
    assert_true(3 * iterations_of(SN_PRECONDITION_COROTATED) < 2 * iterations_of(SN_PRECONDITION_SCALAR));
}

/* Stopped in the middle of a substep, packed, unpacked elsewhere: the frames of the corotated matrix come along. */
static void a_stop_changes_no_bit(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    for (int k = 0; k < 2; k++) {
        bend(&scenes[k], SN_STRETCH_MEMBRANE, SN_PRECONDITION_COROTATED);
        s[k] = start(&scenes[k]);
        step_frames(&s[k], 5, NULL);
    }
    const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 2};
    char *bytes;
    size_t size;
    assert_int_equal(sn_step(s[0].model, s[0].state, &stop, NULL), SN_STOPPED);
    assert_int_equal(sn_state_pack(s[0].model, s[0].state, &bytes, &size, NULL), SN_OK);
    sn_state_destroy(s[0].model, s[0].state);
    assert_int_equal(sn_state_create(s[0].model, &s[0].state, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s[0].model, bytes, size, s[0].state, NULL), SN_OK);
    free(bytes);
    step_frames(&s[0], 3, NULL);
    step_frames(&s[1], 3, NULL);
    size_t points = (size_t)s[0].model->muscles[0].point_count * sizeof(sn_point);
    assert_memory_equal(s[0].state->muscles[0].points, s[1].state->muscles[0].points, points);
    finish(&s[0]);
    finish(&s[1]);
}

/* Crushed to 1 % across, the membrane comes back without a triangle turned over: ln J stands in the way. */
static void a_crushed_muscle_recovers(void **state) {
    (void)state;
    sn_scene scene;
    make_membrane(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index i = 0; i < m->point_count; i++)
        if (m->inverse_mass[i] > 0.0) s.state->muscles[0].points[i].x *= 0.01;
    step_frames(&s, 60, NULL);
    assert_true(greatest_move(&s) < 1e-6 * m->diagonal);
    finish(&s);
}

/* The error of each row is Green's strain |1/2 (FT F - I)|: of a sheet drawn out to (1 + e) along x, e + e^2/2 in every triangle. */
static void errors_of_rows_are_strains(void **state) {
    (void)state;
    sn_scene scene;
    make_sheet(&scene, SN_LAW_PROJECTED, 0.0);
    simulation s = start(&scene);
    const double e = 0.125;
    double errors[32];
    for (sn_index i = 0; i < 25; i++) s.state->muscles[0].points[i].x *= 1.0 + e;
    assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_MEMBRANE), 32);
    assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_MESH), 0);
    sn_row_errors(s.model, s.state, 0, SN_ROWS_MEMBRANE, errors);
    for (int i = 0; i < 32; i++) assert_true(fabs(errors[i] - (e + 0.5 * e * e)) < 1e-12);
    assert_true(fabs(sn_rows_residual(&s.model->muscles[0], &s.state->muscles[0], SN_ROWS_MEMBRANE, NULL).rms - (e + 0.5 * e * e)) < 1e-12);
    finish(&s);
}

static void impossible_settings_are_refused(void **state) {
    (void)state;
    sn_scene scene;
    sn_error error = {0};
    make_membrane(&scene, &FUSIFORM);
    assert_int_equal(sn_scene_validate(&scene, &error), SN_OK);
    scene.muscles[0].law = SN_LAW_PAPER;
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "a membrane has none"));
    scene.muscles[0].law = SN_LAW_PROJECTED;
    scene.solver = sn_solver_defaults(SN_SOLVER_XPBD);
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "needs the solver method qn"));
    scene.muscles[0].stretch = SN_STRETCH_SPRINGS;
    scene.solver.preconditioner = SN_PRECONDITION_COROTATED;
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "solver.preconditioner"));
    scene.solver.preconditioner = SN_PRECONDITION_SCALAR;
    simulation s = start(&scene);
    sn_project(s.model, s.state, 0, SN_ROWS_MEMBRANE); /* xpbd has no such rows: nothing happens */
    assert_true(greatest_move(&s) == 0.0);
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_gradient_is_that_of_the_energy),
        cmocka_unit_test(a_sheet_contracts_along_its_fibers),
        cmocka_unit_test(rest_stays_at_rest),
        cmocka_unit_test(matrices_do_not_change_the_solution),
        cmocka_unit_test(knowing_directions_saves_iterations),
        cmocka_unit_test(a_stop_changes_no_bit),
        cmocka_unit_test(a_crushed_muscle_recovers),
        cmocka_unit_test(errors_of_rows_are_strains),
        cmocka_unit_test(impossible_settings_are_refused),
    };
    return cmocka_run_group_tests_name("membrane", tests, NULL, NULL);
}
