/* test_rebuild.c -- cracks, wraps, remeshing, smoothing, slivers, painted values, what is lost, and the child that may never end. */
#include "shapes.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "../../lib/geom/child.h"

/* A quad above a gap and two below it: the border below has a vertex in the middle of the edge above. */
static void a_border_vertex_next_to_an_edge_splits_it(void **state) {
    (void)state;
    const sn_vec3 positions[9] = {{0, 0, 0},     {2, 0, 0},     {2, 1, 0},  {0, 1, 0}, {0, -0.01, 0},
                                  {1, -0.01, 0}, {2, -0.01, 0}, {0, -1, 0}, {2, -1, 0}};
    const sn_triangle triangles[5] = {{{0, 1, 2}}, {{0, 2, 3}}, {{7, 5, 4}}, {{7, 8, 5}}, {{8, 6, 5}}};
    sn_mesh mesh = shape_of(9, positions, 5, triangles);
    sn_crack_report report;
    assert_ok(sn_close_cracks(&mesh, 0.0, &report, NULL));
    assert_int_equal(report.vertices, 3);
    assert_near(report.widest, 0.01, 1e-12);
    sn_mesh_report found = shape_inspect(&mesh);
    assert_int_equal(found.triangles, 6);
    assert_int_equal(found.components, 1);
    assert_int_equal(found.boundary_edges, 6);
    assert_int_equal(found.nonmanifold_edges + found.inconsistent_edges, 0);
    sn_mesh_free(&mesh);
}

static void what_lies_too_far_apart_is_no_crack(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two;
    shape_drop(&cube, 0);
    two = shape_join(&cube, &cube, 1.0, sn_v3(0, 0, -1.3));
    sn_crack_report report;
    assert_ok(sn_close_cracks(&two, 0.0, &report, NULL));
    assert_int_equal(report.vertices, 0);
    assert_ok(sn_close_cracks(&two, 0.2, &report, NULL)); /* told so, but the walls are 0.3 apart */
    assert_int_equal(report.vertices, 0);
    sn_mesh_free(&two);
    sn_mesh_free(&cube);
}

/* Through a hole narrower than twice alpha a wrap does not look inside. */
static void a_wrap_closes_what_is_open(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), wrapped, again;
    double volume = sn_mesh_volume(&sphere), far = 0.0;
    shape_drop(&sphere, 700);
    shape_drop(&sphere, 300);
    assert_ok(sn_wrap(&sphere, 0.15, 0.02, &wrapped, NULL));
    assert_true(shape_is_sound(&wrapped));
    assert_near(sn_mesh_volume(&wrapped) / volume, 1.0, 0.03);
    assert_ok(sn_one_sided_distance(&wrapped, &sphere, &far, NULL));
    assert_true(far < 0.05);
    sn_index crossings = 1;
    assert_ok(sn_count_self_intersections(&wrapped, &crossings, NULL));
    assert_int_equal(crossings, 0);
    assert_ok(sn_wrap(&sphere, 0.15, 0.02, &again, NULL));
    assert_true(shape_same(&wrapped, &again));
    sn_mesh_free(&again);
    assert_int_equal(sn_wrap(&sphere, 0.0, 0.02, &again, NULL), SN_ERROR_USAGE);
    sn_mesh_free(&wrapped);
    sn_mesh_free(&sphere);
}

/* A sheet without thickness becomes a thin body around itself: here 2 x 1, about half an offset thick. */
static void a_wrapped_sheet_has_two_sides(void **state) {
    (void)state;
    const sn_vec3 positions[4] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
    const sn_triangle triangles[2] = {{{0, 1, 2}}, {{0, 2, 3}}};
    sn_mesh sheet = shape_of(4, positions, 2, triangles), wrapped;
    assert_ok(sn_wrap(&sheet, 0.1, 0.02, &wrapped, NULL));
    assert_true(shape_is_sound(&wrapped));
    assert_near(sn_mesh_area(&wrapped), 4.0, 0.2);
    assert_true(sn_mesh_volume(&wrapped) > 2.0 * 0.009 && sn_mesh_volume(&wrapped) < 2.0 * 0.045);
    sn_mesh_free(&wrapped);
    sn_mesh_free(&sheet);
}

static void remeshing_gives_edges_of_one_length(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40);
    double volume = sn_mesh_volume(&sphere);
    assert_int_equal(sn_remesh(&sphere, 5.0, NULL, NULL), SN_ERROR_USAGE);
    assert_int_equal(sn_remesh(&sphere, 1e-5, NULL, NULL), SN_ERROR_USAGE);
    assert_ok(sn_remesh(&sphere, 0.1, NULL, NULL));
    assert_ok(sn_restore_volume(&sphere, volume, NULL));
    sn_mesh_report found = shape_inspect(&sphere);
    assert_true(shape_is_sound(&sphere));
    assert_near(found.edge_mean, 0.1, 0.02);
    assert_true(found.edge_max < 0.17 && found.worst_quality > 0.3);
    assert_near(found.volume / volume, 1.0, 1e-9);
    sn_mesh_free(&sphere);
}

/* Noise goes, the radius stays: Taubin's filter passes what is long and damps what is short. */
static void smoothing_takes_noise_and_leaves_size(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(30, 60);
    double volume = sn_mesh_volume(&sphere), before = 0.0, after = 0.0;
    uint64_t seed = 5;
    assert_ok(sn_remesh(&sphere, 0.1, NULL, NULL));
    for (sn_index v = 0; v < sphere.vertex_count; v++) {
        double noise = 1.0 + 0.02 * (sn_random(&seed) - 0.5);
        sphere.positions[v] = sn_scale(sphere.positions[v], noise);
        before += pow(sn_norm(sphere.positions[v]) - 1.0, 2.0);
    }
    assert_ok(sn_smooth(&sphere, 10, NULL, NULL));
    assert_ok(sn_restore_volume(&sphere, volume, NULL));
    for (sn_index v = 0; v < sphere.vertex_count; v++) after += pow(sn_norm(sphere.positions[v]) - 1.0, 2.0);
    assert_true(after < 0.3 * before);
    assert_near(sn_mesh_volume(&sphere) / volume, 1.0, 1e-9);
    assert_true(shape_is_sound(&sphere));
    sn_mesh_free(&sphere);
}

/* Borders stay, and an open surface has no volume to restore. */
static double nearest_vertex(const sn_mesh *mesh, sn_vec3 p) {
    double nearest = INFINITY;
    for (sn_index v = 0; v < mesh->vertex_count; v++) nearest = fmin(nearest, sn_distance(mesh->positions[v], p));
    return nearest;
}

/* What is held keeps its vertices, to rounding; the rest is worked on. */
static void what_is_held_is_left_alone(void **state) {
    (void)state;
    for (int step = 0; step < 3; step++) {
        sn_mesh sphere = shape_sphere(20, 40), mesh = shape_sphere(20, 40);
        bool *held = SN_NEW(bool, mesh.vertex_count);
        for (sn_index v = 0; v < mesh.vertex_count; v++) held[v] = mesh.positions[v].z > 0.3;
        if (step == 0) assert_ok(sn_smooth(&mesh, 3, held, NULL));
        if (step == 1) assert_ok(sn_decimate(&mesh, 1200, held, NULL));
        if (step == 2) assert_ok(sn_remesh(&mesh, 0.3, held, NULL));
        sn_index gone = 0;
        for (sn_index v = 0; v < sphere.vertex_count; v++) {
            bool stays = nearest_vertex(&mesh, sphere.positions[v]) < 1e-12;
            if (sphere.positions[v].z > 0.5) assert_true(stays);
            gone += !stays;
        }
        assert_true(gone > 100);
        free(held);
        sn_mesh_free(&mesh);
        sn_mesh_free(&sphere);
    }
}

static void smoothing_leaves_borders(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    shape_drop(&cube, 0);
    sn_vec3 corners[3] = {cube.positions[0], cube.positions[2], cube.positions[1]}, other = cube.positions[7];
    assert_ok(sn_smooth(&cube, 3, NULL, NULL));
    assert_ok(sn_restore_volume(&cube, 5.0, NULL));
    assert_near(sn_distance(corners[0], cube.positions[0]) + sn_distance(corners[1], cube.positions[2]), 0.0, 0.0);
    assert_near(sn_distance(corners[2], cube.positions[1]), 0.0, 0.0);
    assert_true(sn_distance(other, cube.positions[7]) > 1e-3);
    sn_mesh_free(&cube);
}

/* A long flat quad cut along the wrong diagonal, one corner nearly on it. */
static void a_flat_sliver_is_flipped_away(void **state) {
    (void)state;
    const sn_vec3 positions[4] = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -0.01, 0}};
    const sn_triangle triangles[2] = {{{0, 1, 2}}, {{1, 0, 3}}};
    sn_mesh mesh = shape_of(4, positions, 2, triangles);
    sn_index flipped = 0;
    assert_int_equal(shape_inspect(&mesh).sliver_triangles, 1);
    assert_ok(sn_flip_slivers(&mesh, NULL, &flipped, NULL));
    assert_int_equal(flipped, 1);
    sn_mesh_report found = shape_inspect(&mesh);
    assert_int_equal(found.sliver_triangles, 0);
    assert_int_equal(found.inconsistent_edges, 0);
    mesh.positions[3].z = -1.0; /* folded: a ridge is no sliver to flip */
    mesh.triangles[0] = triangles[0];
    mesh.triangles[1] = triangles[1];
    assert_ok(sn_flip_slivers(&mesh, NULL, &flipped, NULL));
    assert_int_equal(flipped, 0);
    sn_mesh_free(&mesh);
}

static void what_is_inside_is_not_lost_what_sticks_out_is(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), more = shape_join(&cube, &cube, 1.0, sn_v3(0, 0, 0));
    for (sn_index v = 8; v < 16; v++) more.positions[v] = sn_lerp(sn_v3(0.5, 0.5, 0.5), more.positions[v], 0.5);
    double lost = -1.0;
    assert_ok(sn_lost_area(&more, &cube, 0.01, &lost, NULL));
    assert_near(lost, 0.0, 0.0); /* a smaller cube inside */
    for (sn_index v = 8; v < 16; v++) more.positions[v].x += 3.0;
    assert_ok(sn_lost_area(&more, &cube, 0.01, &lost, NULL));
    assert_near(lost, 6.0 * 0.25, 1e-12); /* and beside it */
    assert_ok(sn_lost_area(&cube, &cube, 0.01, &lost, NULL));
    assert_near(lost, 0.0, 0.0);
    sn_mesh_free(&more);
    sn_mesh_free(&cube);
}

static void labels_are_carried_unmixed(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(20, 40), wrapped;
    sn_attribute *height = sn_mesh_add_attribute(&sphere, "height", 1);
    for (sn_index v = 0; v < sphere.vertex_count; v++) height->values[v] = sphere.positions[v].z;
    sn_attribute *label = sn_mesh_add_attribute(&sphere, "label", 1);
    label->integer = true;
    for (sn_index v = 0; v < sphere.vertex_count; v++) label->values[v] = sphere.positions[v].z > 0.0 ? 3.0 : 250.0;
    assert_ok(sn_wrap(&sphere, 0.15, 0.02, &wrapped, NULL));
    assert_ok(sn_carry_attributes(&sphere, &wrapped, NULL));
    const sn_attribute *heights = sn_mesh_attribute(&wrapped, "height"), *labels = sn_mesh_attribute(&wrapped, "label");
    assert_true(heights != NULL && labels != NULL && labels->integer);
    for (sn_index v = 0; v < wrapped.vertex_count; v++) {
        assert_near(heights->values[v], wrapped.positions[v].z, 0.05);
        assert_true(labels->values[v] == 3.0 || labels->values[v] == 250.0);
    }
    sn_mesh_free(&wrapped);
    sn_mesh_free(&sphere);
}

/* ---- the child ---------------------------------------------------------------------------------------------------------- */

static bool answer_twice(void *user, int out) {
    int n = 2 * *(int *)user;
    return sn_child_write(out, &n, sizeof n);
}

static bool never_end(void *user, int out) {
    (void)user;
    (void)out;
    while (sleep(1) == 0) continue;
    return true;
}

static bool work_for_ever(void *user, int out) {
    volatile unsigned turns = 0;
    (void)user;
    (void)out;
    for (;;) turns = turns + 1;
    return true;
}

/* Where several of these share a processor, each has its time all the same. */
static bool work_a_while(void *user, int out) {
    (void)user;
    clock_t most = CLOCKS_PER_SEC / 5;
    while (clock() < most) continue;
    return sn_child_write(out, "done", 4);
}

static bool die(void *user, int out) {
    (void)out;
    raise(*(int *)user);
    return true;
}

static bool talk_for_ever(void *user, int out) {
    char words[4096] = {0};
    (void)user;
    while (sn_child_write(out, words, sizeof words)) continue;
    return true;
}

static bool give_up(void *user, int out) {
    (void)user;
    (void)out;
    return false;
}

static bool hold_on(void *user, int out) {
    (void)out;
    return write(*(int *)user, "x", 1) == 1 && never_end(NULL, out);
}

/* The child holds an end of a pipe: when it is gone, the other end reads to its end. */
static void a_child_dies_with_its_parent(void **state) {
    (void)state;
    int ends[2];
    char byte;
    assert_int_equal(pipe(ends), 0);
    pid_t parent = fork();
    if (parent == 0) {
        sn_child_answer answer;
        close(ends[0]);
        _exit(sn_child_run(hold_on, &ends[1], &(sn_child_limits){.seconds = 300.0, .most_answer = 100}, &answer, NULL) == SN_OK);
    }
    close(ends[1]);
    assert_int_equal(read(ends[0], &byte, 1), 1);
    assert_int_equal(kill(parent, SIGKILL), 0);
    assert_int_equal(read(ends[0], &byte, 1), 0);
    close(ends[0]);
    assert_int_equal(waitpid(parent, NULL, 0), parent);
}

static void a_child_answers(void **state) {
    (void)state;
    int n = 21;
    sn_child_answer answer = {.ended_early = true};
    assert_ok(sn_child_run(answer_twice, &n, &(sn_child_limits){.seconds = 300.0, .most_answer = 100}, &answer, NULL));
    assert_int_equal(answer.size, sizeof n);
    assert_int_equal(*(int *)answer.bytes, 42);
    assert_false(answer.ended_early);
    free(answer.bytes);
}

/* Whatever a child does, this process goes on with a sentence; it is late only where it never ends. */
static void a_child_that_fails_dies_or_never_ends_is_an_error(void **state) {
    (void)state;
    const struct {
        sn_child_work work;
        int signal;
        bool late;
    } cases[] = {{never_end, 0, true},  {work_for_ever, 0, true}, {die, SIGSEGV, false},
                 {die, SIGKILL, false}, {give_up, 0, false},      {talk_for_ever, 0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int number = cases[i].signal;
        sn_child_answer answer = {.bytes = &number, .size = 7};
        sn_error error = {0};
        sn_child_limits limits = {.seconds = cases[i].late ? 0.3 : 300.0, .most_answer = 1 << 20};
        assert_int_equal(sn_child_run(cases[i].work, &number, &limits, &answer, &error), SN_ERROR_INTERNAL);
        assert_null(answer.bytes);
        assert_int_equal(answer.size, 0);
        assert_int_equal(answer.ended_early, cases[i].late);
        assert_true(error.text[0] != '\0');
    }
}

/* A fifth of a second of work under a limit of half of one, beside twelve others that never end: by the clock on the wall it would be late.
 */
static void a_loaded_machine_ends_no_child_early(void **state) {
    (void)state;
    pid_t others[12];
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if ((others[i] = fork()) == 0)
            for (;;) (void)getpid();
    sn_child_answer answer = {0};
    sn_status status = sn_child_run(work_a_while, NULL, &(sn_child_limits){.seconds = 0.5, .most_answer = 100}, &answer, NULL);
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        kill(others[i], SIGKILL);
        waitpid(others[i], NULL, 0);
    }
    assert_int_equal(status, SN_OK);
    assert_int_equal(answer.size, 4);
    free(answer.bytes);
}

static void crossings_are_removed_or_left_but_never_made_worse(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(10, 20);
    assert_ok(sn_remesh(&sphere, 0.15, NULL, NULL));
    for (sn_index v = 0; v < sphere.vertex_count; v++) { /* a dent that comes out below */
        sn_vec3 *p = &sphere.positions[v];
        if (p->z > 0.0 && p->x * p->x + p->y * p->y < 0.02) p->z -= 2.3;
    }
    sn_index before = 0, left = 0, counted = 0;
    bool late = false;
    assert_ok(sn_count_self_intersections(&sphere, &before, NULL));
    assert_true(before > 0);
    assert_ok(sn_remove_self_intersections(&sphere, 20.0, &left, &late, NULL));
    assert_ok(sn_count_self_intersections(&sphere, &counted, NULL));
    assert_int_equal(counted, left);
    assert_true(left <= before);
    sn_mesh_report found = shape_inspect(&sphere);
    assert_true(found.closed && found.manifold && found.oriented);
    sn_mesh_free(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_border_vertex_next_to_an_edge_splits_it),
        cmocka_unit_test(what_lies_too_far_apart_is_no_crack),
        cmocka_unit_test(a_wrap_closes_what_is_open),
        cmocka_unit_test(a_wrapped_sheet_has_two_sides),
        cmocka_unit_test(remeshing_gives_edges_of_one_length),
        cmocka_unit_test(smoothing_takes_noise_and_leaves_size),
        cmocka_unit_test(smoothing_leaves_borders),
        cmocka_unit_test(what_is_held_is_left_alone),
        cmocka_unit_test(a_flat_sliver_is_flipped_away),
        cmocka_unit_test(what_is_inside_is_not_lost_what_sticks_out_is),
        cmocka_unit_test(labels_are_carried_unmixed),
        cmocka_unit_test(a_child_answers),
        cmocka_unit_test(a_child_dies_with_its_parent),
        cmocka_unit_test(a_child_that_fails_dies_or_never_ends_is_an_error),
        cmocka_unit_test(a_loaded_machine_ends_no_child_early),
        cmocka_unit_test(crossings_are_removed_or_left_but_never_made_worse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
