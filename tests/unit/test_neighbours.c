/*
 * test_neighbours.c -- candidates for external constraints between sheets and spheres where every distance is known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "shapes.h"
#include "sinew/rig.h"

/* Unit spheres side by side along x: the muscle at 0, a neighbour at 2.1, 0.1 away; a shell of radius 1.2 around the muscle. */
typedef struct fixture {
    sn_muscle muscle;
    sn_mesh neighbour, shell;
    sn_neighbour targets[4];
    sn_neighbours_params params;
    sn_index count;
    sn_external *externals; /* those of `found` */
    sn_neighbours_found found;
    sn_error error;
} fixture;

static int set_up(void **state) {
    fixture *f = SN_NEW(fixture, 1);
    f->muscle = (sn_muscle){.meters_per_unit = 1, .mesh = shape_sphere(24, 48)};
    f->neighbour = shape_sphere(24, 48);
    f->shell = shape_sphere(24, 48);
    for (sn_index v = 0; v < f->shell.vertex_count; v++) f->shell.positions[v] = sn_scale(f->shell.positions[v], 1.2);
    for (sn_index v = 0; v < f->neighbour.vertex_count; v++) f->neighbour.positions[v].x += 2.1;
    f->targets[0] = (sn_neighbour){"triceps", &f->neighbour, false};
    f->targets[1] = (sn_neighbour){"skin", &f->shell, true};
    f->params = sn_neighbours_defaults();
    f->params.reach = 0.25;
    *state = f;
    return 0;
}

static void forget(fixture *f) {
    sn_neighbours_free(&f->found);
    f->externals = NULL;
    f->count = 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    forget(f);
    sn_muscle_free(&f->muscle);
    sn_mesh_free(&f->neighbour), sn_mesh_free(&f->shell);
    free(f);
    return 0;
}

static sn_status find(fixture *f, sn_index targets, sn_trace *trace) {
    forget(f);
    f->params.target_count = targets;
    f->params.targets = f->targets;
    sn_status status = sn_find_neighbours(&f->muscle, &f->params, trace, &f->found, &f->error);
    f->count = f->found.count;
    f->externals = f->found.items;
    return status;
}

static sn_vec3 point_of(const sn_external *e, sn_index k, const sn_mesh *target) {
    const sn_index *v = target->triangles[e->triangles[k]].v;
    sn_vec3 p = {0, 0, 0};
    for (int c = 0; c < 3; c++) p = sn_add_scaled(p, target->positions[v[c]], e->barycentric[3 * k + c]);
    return p;
}

static void surfaces_that_face_each_other_are_joined(void **state) {
    fixture *f = *state;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_int_equal(f->count, 1);
    const sn_external *e = &f->externals[0];
    assert_string_equal(e->target, "triceps");
    assert_string_equal(e->fascia, "deep");
    assert_true(e->count > 20);
    for (sn_index k = 0; k < e->count; k++) {
        sn_vec3 p = f->muscle.mesh.positions[e->vertices[k]];
        assert_true(p.x > 0.8); /* within reach only near the other sphere */
        assert_true(fabs(sn_distance(p, point_of(e, k, &f->neighbour)) - e->distances[k]) < 1e-12);
        assert_true(e->distances[k] > 0.09 && e->distances[k] <= 0.25);
        assert_true(e->weights[3 * k] == 1.0 && e->weights[3 * k + 1] == 0.0 && e->weights[3 * k + 2] == 0.0);
    }
}

/* The muscle's own neighbour turned inside out agrees in its normals: nothing faces it. */
static void surfaces_that_look_the_same_way_are_not(void **state) {
    fixture *f = *state;
    for (sn_index t = 0; t < f->neighbour.triangle_count; t++) shape_flip(&f->neighbour, t);
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_int_equal(f->count, 0);
}

/* Every vertex that faces no neighbour is held in by the envelope, and no other is. */
static void the_envelope_holds_what_faces_nothing(void **state) {
    fixture *f = *state;
    assert_int_equal(find(f, 2, NULL), SN_OK);
    assert_int_equal(f->count, 2);
    const sn_external *deep = &f->externals[0], *shallow = &f->externals[1];
    assert_string_equal(shallow->target, "skin");
    assert_string_equal(shallow->fascia, "superficial");
    assert_int_equal(deep->count + shallow->count, f->muscle.mesh.vertex_count);
    for (sn_index i = 0, k = 0; k < shallow->count; k++) {
        while (i < deep->count && deep->vertices[i] < shallow->vertices[k]) i++;
        assert_true(i == deep->count || deep->vertices[i] != shallow->vertices[k]);
        assert_true(shallow->distances[k] < 0.0); /* the muscle is in its envelope */
    }
}

static void minimum_distance_never_pushes_at_rest(void **state) {
    fixture *f = *state;
    f->params.minimum = 0.15;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    bool less = false, full = false;
    for (sn_index k = 0; k < f->externals[0].count; k++) {
        assert_true(f->externals[0].minimum[k] == fmin(0.15, f->externals[0].distances[k]));
        less = less || f->externals[0].minimum[k] < 0.15;
        full = full || f->externals[0].minimum[k] == 0.15;
    }
    assert_true(less && full);
}

static void weights_come_from_maps(void **state) {
    fixture *f = *state;
    double *map = SN_NEW(double, f->muscle.mesh.vertex_count);
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) map[v] = f->muscle.mesh.positions[v].y + 0.5; /* -0.5 to 1.5: clamped */
    f->params.maps[1] = map;
    f->params.weights[2] = 0.25;
    f->params.reach = 5;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    for (sn_index k = 0; k < f->externals[0].count; k++) {
        double y = f->muscle.mesh.positions[f->externals[0].vertices[k]].y;
        assert_true(f->externals[0].weights[3 * k + 1] == fmin(fmax(y + 0.5, 0.0), 1.0));
        assert_true(f->externals[0].weights[3 * k + 2] == 0.25);
    }
    free(map);
}

static void it_stops_after_n_targets_and_threads_agree(void **state) {
    fixture *f = *state;
    for (int n = 0; n <= 2; n++) {
        sn_trace trace = {.stop_after = n};
        assert_int_equal(find(f, 2, &trace), SN_STOPPED);
        assert_int_equal(f->count, n < 1 ? 0 : 1); /* the second step: deep fascia to the envelope, which agrees everywhere */
    }
    f->params.threads = 1;
    assert_int_equal(find(f, 2, NULL), SN_OK);
    sn_neighbours_found kept = f->found;
    sn_external *one = f->externals;
    sn_index count = f->count;
    f->found = (sn_neighbours_found){0};
    f->params.threads = 3;
    assert_int_equal(find(f, 2, NULL), SN_OK);
    assert_int_equal(count, f->count);
    for (sn_index i = 0; i < count; i++) {
        assert_int_equal(one[i].count, f->externals[i].count);
        assert_memory_equal(one[i].distances, f->externals[i].distances, (size_t)one[i].count * sizeof(double));
        assert_memory_equal(one[i].triangles, f->externals[i].triangles, (size_t)one[i].count * sizeof(sn_index));
    }
    sn_neighbours_free(&kept);
}

static void bad_requests_are_refused(void **state) {
    fixture *f = *state;
    f->params.weights[0] = 1.5;
    assert_int_equal(find(f, 1, NULL), SN_ERROR_USAGE);
    f->params.weights[0] = 1;
    f->targets[1].name = "triceps";
    assert_int_equal(find(f, 2, NULL), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "\"triceps\" is given twice"));
    f->targets[1].name = "skin";
    f->shell.triangle_count = 0;
    assert_int_equal(find(f, 2, NULL), SN_ERROR_INPUT); /* an empty envelope */
    assert_non_null(strstr(f->error.text, "target \"skin\""));
    assert_null(f->externals);
}

/* A sheet between the muscle and its neighbour: it is the one target, and what is behind it is none; with `hidden` it is. */
static void what_is_behind_another_surface_is_no_neighbour(void **state) {
    fixture *f = *state;
    sn_mesh wall = shape_sphere(24, 48);
    for (sn_index v = 0; v < wall.vertex_count; v++) { /* a disc of radius 2 in the gap between the spheres, 0.02 thick */
        sn_vec3 p = wall.positions[v];
        wall.positions[v] = sn_v3(1.05 + 0.01 * p.x, 2 * p.y, 2 * p.z);
    }
    assert_int_equal(find(f, 1, NULL), SN_OK);
    sn_index before = f->externals[0].count;
    f->targets[1] = (sn_neighbour){"wall", &wall, false};
    assert_int_equal(find(f, 2, NULL), SN_OK);
    assert_int_equal(f->count, 1);
    assert_string_equal(f->externals[0].target, "wall");
    assert_int_equal(f->found.hidden, before);
    f->params.hidden = true;
    assert_int_equal(find(f, 2, NULL), SN_OK);
    assert_int_equal(f->count, 2);
    assert_int_equal(f->externals[0].count, before);
    f->params.hidden = false;
    const sn_mesh *obstacle = &wall; /* a bone hides, but is no target */
    f->params.obstacle_count = 1;
    f->params.obstacles = &obstacle;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_int_equal(f->count, 0);
    assert_int_equal(f->found.hidden, before);
    assert_int_equal(f->found.without, f->muscle.mesh.vertex_count);
    sn_mesh_free(&wall);
}

/* The same neighbour three times, ever farther: with `most` the nearest ones stay, in whatever order they are given. */
static void the_nearest_targets_are_kept(void **state) {
    fixture *f = *state;
    sn_mesh copies[2];
    const char *names[3] = {"near", "middle", "far"};
    const sn_mesh *meshes[3] = {&f->neighbour, &copies[0], &copies[1]};
    for (int i = 0; i < 2; i++) {
        copies[i] = shape_sphere(24, 48);
        for (sn_index v = 0; v < copies[i].vertex_count; v++) copies[i].positions[v].x += 2.11 + 0.01 * i;
    }
    f->params.hidden = true; /* each is before the next */
    for (int turn = 0; turn < 3; turn++) {
        for (int i = 0; i < 3; i++) f->targets[i] = (sn_neighbour){names[(i + turn) % 3], meshes[(i + turn) % 3], false};
        f->params.most = 0;
        assert_int_equal(find(f, 3, NULL), SN_OK);
        sn_index farthest = 0;
        for (sn_index i = 0; i < 3; i++)
            if (strcmp(f->externals[i].target, "far") == 0) farthest = f->externals[i].count;
        assert_int_equal(f->found.surplus, 0);
        f->params.most = 2;
        assert_int_equal(find(f, 3, NULL), SN_OK);
        assert_int_equal(f->count, 2);
        assert_int_equal(f->found.surplus, farthest);
        for (sn_index i = 0; i < 2; i++) assert_string_not_equal(f->externals[i].target, "far");
        f->params.most = 1;
        assert_int_equal(find(f, 3, NULL), SN_OK);
        assert_int_equal(f->count, 1);
        assert_string_equal(f->externals[0].target, "near");
    }
    for (int i = 0; i < 2; i++) sn_mesh_free(&copies[i]);
}

/* Of a muscle that has entered its neighbour by 0.2 the vertices inside it have rows with negative distances. */
static void an_overlap_is_kept_as_it_is(void **state) {
    fixture *f = *state;
    for (sn_index v = 0; v < f->neighbour.vertex_count; v++) f->neighbour.positions[v].x -= 0.3;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    const sn_external *e = &f->externals[0];
    sn_index inside = 0, held = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        sn_vec3 p = f->muscle.mesh.positions[v];
        inside += sn_distance(p, sn_v3(1.8, 0, 0)) < 0.995; /* the neighbour's facets are up to 0.003 inside its sphere */
    }
    for (sn_index k = 0; k < e->count; k++) {
        held += e->distances[k] < 0.0;
        assert_true(e->distances[k] > -0.21 && e->minimum[k] <= e->distances[k]);
    }
    assert_true(inside > 3 && held >= inside);
}

/* A thin lid over the muscle's tip, which pokes 0.01 through it: from there the neighbour behind the lid is seen, from elsewhere not. */
static void what_a_vertex_has_entered_a_little_hides_nothing(void **state) {
    fixture *f = *state;
    sn_mesh lid = shape_sphere(24, 48);
    for (sn_index v = 0; v < lid.vertex_count; v++) {
        sn_vec3 p = lid.positions[v];
        lid.positions[v] = sn_v3(0.99 + 0.02 * p.x, 2 * p.y, 2 * p.z);
    }
    const sn_mesh *obstacle = &lid;
    f->params.obstacle_count = 1;
    f->params.obstacles = &obstacle;
    for (int inside_out = 0; inside_out < 2; inside_out++) {
        assert_int_equal(find(f, 1, NULL), SN_OK);
        assert_int_equal(f->count, 1);
        assert_true(f->found.hidden > 0);
        for (sn_index k = 0; k < f->externals[0].count; k++) assert_true(f->muscle.mesh.positions[f->externals[0].vertices[k]].x > 0.97);
        for (sn_index t = 0; t < lid.triangle_count; t++) shape_flip(&lid, t);
    }
    sn_mesh_free(&lid);
}

static void a_target_out_of_reach_is_not_searched(void **state) {
    fixture *f = *state;
    for (sn_index v = 0; v < f->neighbour.vertex_count; v++) f->neighbour.positions[v].x += 0.16;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_int_equal(f->found.culled, 1);
    assert_int_equal(f->count, 0);
    f->params.reach = 0.27; /* of the boxes: 0.26 apart */
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_int_equal(f->found.culled, 0);
    assert_true(f->count == 1);
}

static void maps_out_of_range_are_counted_and_others_refused(void **state) {
    fixture *f = *state;
    double *map = SN_NEW(double, f->muscle.mesh.vertex_count);
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) map[v] = 255;
    f->params.maps[0] = map;
    assert_int_equal(find(f, 1, NULL), SN_OK);
    assert_true(f->found.clamped > 0 && f->found.clamped == f->externals[0].count);
    map[7] = NAN;
    assert_int_equal(find(f, 1, NULL), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "vertex 7"));
    free(map);
}

/* [R18] eqs. 11-13, and 0 where the paper divides by 0. */
static void weights_share_what_sliding_leaves(void **state) {
    (void)state;
    static const double in[][3] = {{1, 0, 0}, {0.25, 1, 0}, {0.25, 0.5, 1}, {0.5, 0, 0}, {0, 0, 0}, {1, 1, 1}};
    static const double want[][3] = {{1, 0, 0}, {0.25, 0.75, 0}, {0.25, 0.25, 0.5}, {0.5, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    for (size_t i = 0; i < sizeof in / sizeof *in; i++) {
        double out[3];
        sn_external_blend(in[i], out);
        for (int k = 0; k < 3; k++) assert_true(fabs(out[k] - want[i][k]) < 1e-15);
    }
}

/* By rule: 0 where a bone holds, 1/2 half way, 1 beyond, along the surface (on the unit sphere: the angle from the pole). */
static void tendons_end_at_their_length(void **state) {
    fixture *f = *state;
    sn_index vertices[] = {24 * 48}; /* the pole */
    sn_attachment bone = {.bone = (char[]){"ulna"}, .count = 1, .vertices = vertices};
    double *slide = SN_NEW(double, f->muscle.mesh.vertex_count);
    assert_int_equal(sn_tendon_slide(&f->muscle, 1.0, slide, &f->error), SN_ERROR_INPUT); /* nothing holds it */
    f->muscle.attachments = &bone;
    f->muscle.attachment_count = 1;
    assert_int_equal(sn_tendon_slide(&f->muscle, 0.0, slide, &f->error), SN_ERROR_USAGE);
    assert_int_equal(sn_tendon_slide(&f->muscle, 1.0, slide, &f->error), SN_OK);
    sn_vec3 pole = f->muscle.mesh.positions[vertices[0]];
    double worst = 0.0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        double chord = sn_distance(f->muscle.mesh.positions[v], pole), t = fmin(2.0 * asin(fmin(0.5 * chord, 1.0)), 1.0);
        worst = fmax(worst, fabs(slide[v] - t * t * (3.0 - 2.0 * t)));
    }
    f->muscle.attachments = NULL;
    f->muscle.attachment_count = 0;
    assert_true(worst < 0.05 && slide[vertices[0]] == 0.0);
    assert_true(fabs(sn_tendon_default(&f->muscle) - 0.2) < 0.01);
    free(slide);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(surfaces_that_face_each_other_are_joined),
        TEST(surfaces_that_look_the_same_way_are_not),
        TEST(the_envelope_holds_what_faces_nothing),
        TEST(minimum_distance_never_pushes_at_rest),
        TEST(weights_come_from_maps),
        TEST(it_stops_after_n_targets_and_threads_agree),
        TEST(bad_requests_are_refused),
        TEST(what_is_behind_another_surface_is_no_neighbour),
        TEST(the_nearest_targets_are_kept),
        TEST(an_overlap_is_kept_as_it_is),
        TEST(what_a_vertex_has_entered_a_little_hides_nothing),
        TEST(a_target_out_of_reach_is_not_searched),
        TEST(maps_out_of_range_are_counted_and_others_refused),
        TEST(weights_share_what_sliding_leaves),
        TEST(tendons_end_at_their_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
