/*
 * test_view_externals.c -- rows of external constraints in space and in a section: what is drawn where, and what is refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "shapes.h"
#include "sinew/view.h"

/* A unit sphere with three rows (slide, soft, none) on another at x = 2.1, in decimetres. */
typedef struct fixture {
    sn_muscle muscle;
    sn_mesh neighbour;
    sn_external external;
    sn_index vertices[3], triangles[3];
    double barycentric[9], distances[3], minimum[3], weights[9];
    sn_view_target target;
    sn_view_targets targets, none;
    sn_view view;
    sn_error error;
} fixture;

static int set_up(void **state) {
    fixture *f = SN_NEW(fixture, 1);
    f->muscle = (sn_muscle){.meters_per_unit = 0.1, .mesh = shape_sphere(24, 48)};
    f->neighbour = shape_sphere(24, 48);
    for (sn_index v = 0; v < f->neighbour.vertex_count; v++) f->neighbour.positions[v].x += 2.1;
    f->external = (sn_external){.target = sn_strdup("triceps"), .fascia = sn_strdup("deep"), .count = 3};
    f->external.vertices = f->vertices, f->external.triangles = f->triangles, f->external.barycentric = f->barycentric;
    f->external.distances = f->distances, f->external.minimum = f->minimum, f->external.weights = f->weights;
    f->weights[0] = 1.0;
    f->weights[4] = 1.0;
    for (sn_index k = 0; k < 3; k++) {
        f->vertices[k] = 11 * 48 + k; /* next to the equator, near x = 1 */
        f->triangles[k] = 20 * k;
        f->barycentric[3 * k] = 1.0;
        f->distances[k] =
            sn_distance(f->muscle.mesh.positions[f->vertices[k]], f->neighbour.positions[f->neighbour.triangles[f->triangles[k]].v[0]]);
    }
    f->muscle.has_externals = true;
    f->muscle.external_count = 1;
    f->muscle.externals = &f->external;
    f->target = (sn_view_target){"triceps", &f->neighbour, 0.1};
    f->targets = (sn_view_targets){1, &f->target};
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    f->muscle.external_count = 0, f->muscle.externals = NULL;
    free(f->external.target), free(f->external.fascia);
    sn_muscle_free(&f->muscle);
    sn_mesh_free(&f->neighbour);
    sn_view_free(&f->view);
    free(f);
    return 0;
}

static bool has_entry(const sn_view *view, const char *text) {
    for (size_t i = 0; i < view->entry_count; i++)
        if (strcmp(view->entries[i].text, text) == 0) return true;
    return false;
}

static void rows_go_from_vertex_to_target_and_tell_what_acts(void **state) {
    fixture *f = *state;
    assert_int_equal(sn_view_add_externals(&f->view, &f->muscle, &f->targets, &f->error), SN_OK);
    assert_int_equal(f->view.tube_count, 3);
    assert_int_equal(f->view.mesh_count, 1); /* the target */
    for (sn_index k = 0; k < 3; k++) {
        const sn_view_tube *t = &f->view.tubes[k];
        assert_true(sn_distance(t->a, sn_scale(f->muscle.mesh.positions[f->vertices[k]], 0.1)) < 1e-15);
        assert_true(fabs(sn_distance(t->a, t->b) - 0.1 * f->distances[k]) < 1e-12);
        for (sn_index other = 0; other < k; other++) assert_memory_not_equal(&t->color, &f->view.tubes[other].color, sizeof t->color);
    }
    assert_true(has_entry(&f->view, "row: slide") && has_entry(&f->view, "row: soft") && has_entry(&f->view, "row without weight"));
    assert_false(has_entry(&f->view, "row: hard"));
}

static void without_the_target_a_row_is_a_dot(void **state) {
    fixture *f = *state;
    assert_int_equal(sn_view_add_externals(&f->view, &f->muscle, &f->none, &f->error), SN_OK);
    assert_int_equal(f->view.tube_count, 3);
    assert_int_equal(f->view.mesh_count, 0);
    assert_memory_equal(&f->view.tubes[0].a, &f->view.tubes[0].b, sizeof(sn_vec3));
}

/* Rows of another mesh of that name would be drawn anywhere. */
static void a_target_that_has_changed_is_refused(void **state) {
    fixture *f = *state;
    f->neighbour.positions[f->neighbour.triangles[20].v[0]].z += 0.01;
    assert_int_equal(sn_view_add_externals(&f->view, &f->muscle, &f->targets, &f->error), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "target \"triceps\""));
    f->triangles[1] = f->neighbour.triangle_count;
    assert_int_equal(sn_view_add_externals(&f->view, &f->muscle, &f->targets, &f->error), SN_ERROR_INPUT);
}

static void vertices_are_painted_by_target(void **state) {
    fixture *f = *state;
    assert_int_equal(sn_view_add_muscle(&f->view, &f->muscle, SN_SHOW_EXTERNALS, &f->error), SN_OK);
    sn_index painted = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) painted += f->view.meshes[0].paint[v] == 0;
    assert_int_equal(painted, 3);
    assert_true(has_entry(&f->view, "faces triceps"));
}

/* A section through the middle: circles of radius 0.1 in the plane (facets: 1 % less), rows near it on it, others left out. */
static void a_section_lies_in_its_plane(void **state) {
    fixture *f = *state;
    sn_view_section section = {.muscle = &f->muscle, .targets = &f->targets, .bones = &f->none, .normal = {0, 0, 3}, .depth = 0.02};
    assert_int_equal(sn_view_add_section(&f->view, &section, &f->error), SN_OK);
    size_t outlines = 0, rows = 0;
    for (size_t i = 0; i < f->view.tube_count; i++) {
        const sn_view_tube *t = &f->view.tubes[i];
        assert_true(fabs(t->a.z) < 1e-15 && fabs(t->b.z) < 1e-15);
        double mine = sn_norm(t->a), its = sn_distance(t->a, sn_v3(0.21, 0, 0));
        bool outline = t->radius > 0.0012;
        if (outline) assert_true((mine > 0.098 && mine < 0.1001) || (its > 0.098 && its < 0.1001));
        outlines += outline;
        rows += !outline;
    }
    assert_true(outlines >= 2 * 48);
    assert_int_equal(rows, 3);
    sn_view_free(&f->view);
    section.depth = 0.0;
    assert_int_equal(sn_view_add_section(&f->view, &section, &f->error), SN_OK);
    assert_int_equal(f->view.tube_count, outlines);
    section.point.z = 0.5;
    sn_view_free(&f->view);
    assert_int_equal(sn_view_add_section(&f->view, &section, &f->error), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "does not cut"));
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(rows_go_from_vertex_to_target_and_tell_what_acts),
        TEST(without_the_target_a_row_is_a_dot),
        TEST(a_target_that_has_changed_is_refused),
        TEST(vertices_are_painted_by_target),
        TEST(a_section_lies_in_its_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
