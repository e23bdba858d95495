/* test_view_fibers.c -- fibres through the volume: tubes in the picture, told apart by colour, seen through the surface. */
#include "shapes.h"

#include "sinew/muscle.h"
#include "sinew/view.h"

/* A sphere with `count` straight fibres of three points through it. */
static sn_muscle with_fibers(sn_index count, bool directions) {
    sn_muscle muscle = {.meters_per_unit = 1e-3, .mesh = shape_sphere(8, 16)};
    muscle.fibers.polylines = SN_NEW(sn_polyline, count);
    muscle.fibers.polyline_count = count;
    for (sn_index i = 0; i < count; i++) {
        double x = -0.5 + (double)i / count;
        muscle.fibers.polylines[i] = (sn_polyline){.count = 3, .points = SN_NEW(sn_vec3, 3)};
        for (int k = 0; k < 3; k++) muscle.fibers.polylines[i].points[k] = sn_v3(x, 0.0, 0.4 * (k - 1));
    }
    if (directions) muscle.fibers.directions = SN_NEW(sn_vec3, muscle.mesh.vertex_count);
    return muscle;
}

static bool same_color(sn_color a, sn_color b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

static void test_every_segment_is_a_tube(void **state) {
    (void)state;
    for (int directions = 0; directions < 2; directions++) {
        sn_muscle muscle = with_fibers(10, directions);
        sn_view view = {0};
        assert_ok(sn_view_add_muscle(&view, &muscle, SN_SHOW_AUTO, NULL));
        assert_int_equal(view.tube_count, 20); /* directions on the surface give way */
        assert_near(view.tubes[0].b.z - view.tubes[0].a.z, 0.4e-3, 1e-15);
        assert_true(same_color(view.tubes[0].color, view.tubes[1].color));
        for (size_t i = 0; i < view.tube_count; i++)
            for (size_t k = 0; k < i; k++) assert_true(i / 2 == k / 2 || !same_color(view.tubes[i].color, view.tubes[k].color));
        assert_true(view.meshes[0].opacity < 0.5);
        assert_int_equal(view.entry_count, 1);
        assert_string_equal(view.entries[0].text, "fibres");
        assert_string_equal(view.entries[0].detail, "10");
        sn_view_free(&view);
        sn_muscle_free(&muscle);
    }
}

static void test_of_many_a_selection_is_drawn(void **state) {
    (void)state;
    sn_muscle muscle = with_fibers(1000, false);
    sn_view view = {0};
    assert_ok(sn_view_add_muscle(&view, &muscle, SN_SHOW_AUTO, NULL));
    assert_int_equal(view.tube_count, 2 * 334); /* every third */
    assert_string_equal(view.entries[0].detail, "334 of 1000");
    sn_view_free(&view);
    sn_muscle_free(&muscle);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_segment_is_a_tube),
        cmocka_unit_test(test_of_many_a_selection_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
