/* A state as a picture: colours, marks and words say what the rows say. */
#include "sim_scene.h"
#include "sinew/view.h"

#include <stdio.h>

/* At rest but for one vertex of the surface, which is out by half an edge. */
static simulation dented(sn_scene *scene, sn_index *moved) {
    make_scene(scene, &FUSIFORM);
    simulation s = start(scene);
    *moved = s.model->muscles[0].vertex_count / 2;
    s.state->muscles[0].points[*moved].x += 0.5 * s.model->muscles[0].mean_edge;
    return s;
}

static sn_view draw(const simulation *s, sn_row_kind kind, double range, unsigned show) {
    sn_view view = {0};
    sn_error error = {0};
    const sn_state_look look = {(sn_state_figure)kind, range, show};
    if (sn_view_add_state(&view, s->model, s->state, &look, &error) != SN_OK) fail_msg("%s", error.text);
    return view;
}

static bool is_color(sn_color a, sn_color b) { return fabs(a.r - b.r) + fabs(a.g - b.g) + fabs(a.b - b.b) < 1e-12; }

static double worst_error(const simulation *s, sn_row_kind kind, sn_index *row) {
    sn_index count = sn_row_count(s->model, 0, kind);
    double *errors = SN_NEW(double, count);
    sn_row_errors(s->model, s->state, 0, kind, errors);
    *row = 0;
    for (sn_index i = 1; i < count; i++)
        if (errors[i] > errors[*row]) *row = i;
    double worst = errors[*row];
    free(errors);
    return worst;
}

static void the_surface_has_the_colour_of_its_worst_row(void **state) {
    (void)state;
    static const sn_row_kind kinds[] = {SN_ROWS_MESH, SN_ROWS_DIHEDRAL};
    sn_scene scene;
    sn_index moved, row;
    simulation s = dented(&scene, &moved);
    for (int k = 0; k < 2; k++) {
        double worst = worst_error(&s, kinds[k], &row);
        sn_view view = draw(&s, kinds[k], 2.0 * worst, SN_SHOW_AUTO);
        assert_int_equal(view.mesh_count, 1);
        const sn_view_mesh *mesh = &view.meshes[0];
        assert_true(mesh->opacity >= 1.0 && is_color(mesh->colors[moved], sn_scale_color(0.5)));
        assert_true(is_color(mesh->colors[0], sn_scale_color(0.0)));
        assert_true(sn_distance(mesh->positions[moved], position(&s, moved)) == 0.0);
        assert_non_null(view.scale.text);
        assert_true(view.scale.high == 2.0 * worst && !view.scale.open);
        sn_view_free(&view);
    }
    finish(&s);
}

static void the_worst_row_has_a_ring_and_a_name(void **state) {
    (void)state;
    sn_scene scene;
    sn_index moved, row, points[4];
    simulation s = dented(&scene, &moved);
    double worst = worst_error(&s, SN_ROWS_MESH, &row);
    sn_row_points(s.model, 0, SN_ROWS_MESH, row, points);
    sn_view view = draw(&s, SN_ROWS_MESH, 0.25 * worst, SN_SHOW_AUTO);
    assert_int_equal(view.ring_count, 1);
    assert_true(sn_distance(view.rings[0], sn_lerp(position(&s, points[0]), position(&s, points[1]), 0.5)) < 1e-12);
    char words[64];
    snprintf(words, sizeof words, "vertices %d, %d", points[0], points[1]);
    assert_non_null(strstr(view.subtitle, words));
    assert_true(view.scale.open);
    sn_view_free(&view);
    finish(&s);
}

static void a_state_without_error_has_no_ring(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    sn_view view = draw(&s, SN_ROWS_AREA, NAN, SN_SHOW_AUTO);
    assert_int_equal(view.ring_count, 0);
    assert_string_equal(view.subtitle, "area: no error");
    assert_true(view.scale.high == 1.0);
    sn_view_free(&view);
    finish(&s);
}

/* Internal edges are drawn inside a translucent surface, each in the colour of its own error. */
static void internal_edges_have_colours_of_their_own(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    sn_index sample = s.model->muscles[0].vertex_count + s.model->plan.muscles[0].samples - 1, row;
    s.state->muscles[0].points[sample].z += 0.3 * s.model->muscles[0].mean_edge;
    double worst = worst_error(&s, SN_ROWS_INTERNAL, &row);
    const unsigned both = SN_SHOW_AUTO | SN_SHOW_STRUCTURE;
    for (int k = 0; k < 2; k++) {
        sn_view view = draw(&s, k == 0 ? SN_ROWS_INTERNAL : SN_ROWS_MESH, 2.0 * worst, both);
        sn_index halves = 0, zeros = 0;
        for (size_t i = 0; i < view.tube_count; i++) {
            halves += is_color(view.tubes[i].color, sn_scale_color(0.5));
            zeros += is_color(view.tubes[i].color, sn_scale_color(0.0));
        }
        assert_true(view.meshes[0].opacity < 1.0 && (view.meshes[0].colors != NULL) == (k == 1));
        assert_int_equal(halves, 1);
        assert_int_equal(zeros, sn_row_count(s.model, 0, SN_ROWS_INTERNAL) - 1);
        sn_view_free(&view);
    }
    finish(&s);
}

static void a_collapsed_hinge_is_the_worst_of_all(void **state) {
    (void)state;
    sn_scene scene;
    sn_index moved, points[4];
    simulation s = dented(&scene, &moved);
    sn_row_points(s.model, 0, SN_ROWS_DIHEDRAL, 0, points);
    s.state->muscles[0].points[points[2]] = s.state->muscles[0].points[points[0]];
    sn_view view = draw(&s, SN_ROWS_DIHEDRAL, 1.0, SN_SHOW_AUTO);
    assert_non_null(strstr(view.subtitle, "no angle"));
    assert_true(view.scale.open && is_color(view.meshes[0].colors[points[0]], sn_scale_color(1.0)));
    sn_view_free(&view);
    finish(&s);
}

static void the_range_is_round_and_holds_most_rows(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.2, 0.6);
    simulation s = start(&scene);
    step_frames(&s, 4, NULL);
    double range;
    assert_int_equal(sn_view_state_range(s.model, s.state, (sn_state_figure)SN_ROWS_MESH, &range, NULL), SN_OK);
    sn_index count = sn_row_count(s.model, 0, SN_ROWS_MESH), below = 0, far_below = 0;
    double *errors = SN_NEW(double, count), digit = range / pow(10.0, floor(log10(range) + 1e-9));
    sn_row_errors(s.model, s.state, 0, SN_ROWS_MESH, errors);
    for (sn_index i = 0; i < count; i++) {
        below += errors[i] <= range;
        far_below += errors[i] <= 0.39 * range;
    }
    assert_true(below >= 0.97 * count && far_below < 0.985 * count);
    assert_true(fabs(digit - 1.0) < 1e-9 || fabs(digit - 2.0) < 1e-9 || fabs(digit - 5.0) < 1e-9);
    free(errors);
    finish(&s);
}

static void the_time_is_that_of_the_moment(void **state) {
    (void)state;
    static const sn_step_options half = {.stop_substep = 3, .stop_iteration = 1};
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    step_frames(&s, 2, NULL);
    assert_true(sn_view_state_frame(s.model, s.state) == 2.0);
    assert_int_equal(sn_step(s.model, s.state, &half, NULL), SN_STOPPED);
    assert_true(fabs(sn_view_state_frame(s.model, s.state) - (2.0 + 3.0 / scene.solver.substeps)) < 1e-12);
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_surface_has_the_colour_of_its_worst_row),
        cmocka_unit_test(the_worst_row_has_a_ring_and_a_name),
        cmocka_unit_test(a_state_without_error_has_no_ring),
        cmocka_unit_test(internal_edges_have_colours_of_their_own),
        cmocka_unit_test(a_collapsed_hinge_is_the_worst_of_all),
        cmocka_unit_test(the_range_is_round_and_holds_most_rows),
        cmocka_unit_test(the_time_is_that_of_the_moment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
