/*
 * test_attach.c -- attachments of a slab of vertices between two boxes of bone, where every distance is known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "sinew/rig.h"

/* ---- shapes ---------------------------------------------------------------------------------------------------------------- */

static void set_box(sn_mesh *mesh, sn_vec3 low, sn_vec3 high) {
    static const sn_triangle triangles[12] = {{{0, 2, 1}}, {{1, 2, 3}}, {{4, 5, 6}}, {{5, 7, 6}}, {{0, 1, 4}}, {{1, 5, 4}},
                                              {{2, 6, 3}}, {{3, 6, 7}}, {{0, 4, 2}}, {{2, 4, 6}}, {{1, 3, 5}}, {{3, 7, 5}}};
    assert_int_equal(sn_mesh_alloc(mesh, 8, 12, NULL), SN_OK);
    for (int i = 0; i < 8; i++)
        mesh->positions[i] = sn_v3(i & 1 ? high.x : low.x, i >> 1 & 1 ? high.y : low.y, i >> 2 & 1 ? high.z : low.z);
    memcpy(mesh->triangles, triangles, sizeof triangles);
}

/* A muscle as a strip along x: vertex 2i at (i, 0, 0), 2i + 1 at (i, 1, 0), for i = 0 .. length. */
static sn_muscle strip(sn_index length) {
    sn_muscle muscle = {.meters_per_unit = 1};
    assert_int_equal(sn_mesh_alloc(&muscle.mesh, 2 * length + 2, 2 * length, NULL), SN_OK);
    for (sn_index v = 0; v < muscle.mesh.vertex_count; v++) muscle.mesh.positions[v] = sn_v3(v / 2, v % 2, 0);
    for (sn_index i = 0; i < length; i++) {
        muscle.mesh.triangles[2 * i] = (sn_triangle){{2 * i, 2 * i + 2, 2 * i + 1}};
        muscle.mesh.triangles[2 * i + 1] = (sn_triangle){{2 * i + 1, 2 * i + 2, 2 * i + 3}};
    }
    return muscle;
}

enum { LENGTH = 10, VERTICES = 2 * LENGTH + 2 };

/* The strip and two bones: "left" ends at x = 1.5, "right" begins at x = 8.5; "moon" is far away. */
typedef struct fixture {
    sn_muscle muscle;
    sn_mesh left, right, moon;
    sn_attach_bone bones[3];
    sn_attach_params params;
    sn_attachment_list attachments;
    sn_attach_report report;
    sn_error error;
} fixture;

static int set_up(void **state) {
    fixture *f = SN_NEW(fixture, 1);
    f->muscle = strip(LENGTH);
    set_box(&f->left, sn_v3(-1, -1, -1), sn_v3(1.5, 2, 1));
    set_box(&f->right, sn_v3(8.5, -1, -1), sn_v3(11, 2, 1));
    set_box(&f->moon, sn_v3(1000, 0, 0), sn_v3(1001, 1, 1));
    f->bones[0] = (sn_attach_bone){"left", &f->left, false};
    f->bones[1] = (sn_attach_bone){"right", &f->right, false};
    f->bones[2] = (sn_attach_bone){"moon", &f->moon, false};
    f->params = sn_attach_defaults();
    *state = f;
    return 0;
}

static void forget(fixture *f) {
    sn_attachments_free(f->attachments.items, f->attachments.count);
    sn_attach_report_free(&f->report);
    f->attachments = (sn_attachment_list){0};
}

static int tear_down(void **state) {
    fixture *f = *state;
    forget(f);
    sn_muscle_free(&f->muscle);
    sn_mesh_free(&f->left), sn_mesh_free(&f->right), sn_mesh_free(&f->moon);
    free(f);
    return 0;
}

static sn_status detect(fixture *f, sn_trace *trace) {
    forget(f);
    f->params.bone_count = 3;
    f->params.bones = f->bones;
    return sn_attach_detect(&f->muscle, &f->params, trace, &f->attachments, &f->report, &f->error);
}

static void assert_attachment(const sn_attachment *a, const char *bone, const char *method, sn_index first, sn_index last) {
    assert_string_equal(a->bone, bone);
    assert_string_equal(a->method, method);
    assert_int_equal(a->count, last - first + 1);
    for (sn_index i = 0; i < a->count; i++) assert_int_equal(a->vertices[i], first + i);
}

/* ---- rules --------------------------------------------------------------------------------------------------------------------- */

static void contact_takes_vertices_inside(void **state) {
    fixture *f = *state;
    f->params.methods = SN_ATTACH_CONTACT;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 2);
    assert_attachment(&f->attachments.items[0], "left", "contact", 0, 3);              /* x = 0, 1 */
    assert_attachment(&f->attachments.items[1], "right", "contact", 18, VERTICES - 1); /* x = 9, 10 */
    assert_true(f->attachments.items[0].distances[0] == -1.0 && f->attachments.items[0].distances[2] == -0.5);
    assert_int_equal(f->report.attached, 8);
}

/* A vertex on the surface is in contact: the signed distance is 0 there. */
static void contact_takes_vertices_on_the_surface(void **state) {
    fixture *f = *state;
    f->params.methods = SN_ATTACH_CONTACT;
    for (int i = 0; i < 8; i++) f->left.positions[i].x = fmin(f->left.positions[i].x, 1.0);
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "left", "contact", 0, 3);
    assert_true(f->attachments.items[0].distances[2] == 0.0);
}

static void proximity_takes_vertices_closer_than_the_distance(void **state) {
    fixture *f = *state;
    f->params.methods = SN_ATTACH_PROXIMITY;
    f->params.distance = 1.5;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "left", "proximity", 0, 5); /* x = 2 at 0.5; x = 3 at 1.5 is not closer */
    f->params.distance = 1.5000001;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "left", "proximity", 0, 7);
    f->params.methods |= SN_ATTACH_CONTACT;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "left", "contact+proximity", 0, 7);
}

/* The mean edge of the strip: 20 edges along, 11 across, 10 diagonals. Alone proximity reaches that far, with contact a tenth. */
static void default_distance_follows_the_mean_edge(void **state) {
    fixture *f = *state;
    double edge = (31 + 10 * sqrt(2)) / 41;
    for (int i = 0; i < 8; i++) {
        if (f->left.positions[i].x > 0) f->left.positions[i].x = 3 - 0.99 * edge;
        if (f->right.positions[i].x < 10) f->right.positions[i].x = 7 + 1.01 * edge;
    }
    f->params.methods = SN_ATTACH_PROXIMITY;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "left", "proximity", 0, 7);    /* x = 3 */
    assert_attachment(&f->attachments.items[1], "right", "proximity", 16, 21); /* not x = 7 */
    f->params = sn_attach_defaults();
    for (int within = 0; within < 2; within++) {
        for (int i = 0; i < 8; i++) {
            if (f->left.positions[i].x > 0) f->left.positions[i].x = 3 - (within ? 0.099 : 0.101) * edge;
        }
        assert_int_equal(detect(f, NULL), SN_OK);
        assert_attachment(&f->attachments.items[0], "left", within ? "contact+proximity" : "contact", 0, within ? 7 : 5);
    }
}

static void a_vertex_goes_to_the_nearest_bone(void **state) {
    fixture *f = *state;
    f->params.distance = 100;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 2);
    assert_attachment(&f->attachments.items[0], "left", "contact+proximity", 0, 11); /* x = 5 is 3.5 from both: the bone given first */
    assert_attachment(&f->attachments.items[1], "right", "contact+proximity", 12, VERTICES - 1);
    sn_attach_bone swap = f->bones[0];
    f->bones[0] = f->bones[1], f->bones[1] = swap;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_attachment(&f->attachments.items[0], "right", "contact+proximity", 10, VERTICES - 1);
    assert_attachment(&f->attachments.items[1], "left", "contact+proximity", 0, 9);
}

static void every_pair_is_reported(void **state) {
    fixture *f = *state;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->report.pair_count, 3);
    const sn_attach_pair *pairs = f->report.pairs;
    assert_true(pairs[0].bone == 0 && pairs[0].vertices == 4 && !pairs[0].culled && pairs[0].nearest == -1.0);
    assert_true(pairs[1].bone == 1 && pairs[1].vertices == 4 && !pairs[1].culled && pairs[1].nearest == -1.0);
    assert_true(pairs[2].bone == 2 && pairs[2].vertices == 0 && pairs[2].culled && pairs[2].nearest == 990.0);
}

static void nothing_in_reach_is_no_error(void **state) {
    fixture *f = *state;
    for (sn_index v = 0; v < VERTICES; v++) f->muscle.mesh.positions[v].z += 50;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 0);
    assert_int_equal(f->report.attached, 0);
    assert_true(f->report.pairs[0].culled && f->report.pairs[0].nearest == 49.0);
}

/* ---- pins ------------------------------------------------------------------------------------------------------------------------- */

static void pins_come_first(void **state) {
    fixture *f = *state;
    const sn_index tip[] = {0, 1, 6};
    const sn_attach_pin pins[2] = {{"right", {.kind = SN_SELECT_INDICES, .count = 3, .indices = tip}},
                                   {"tail", {.kind = SN_SELECT_INDICES, .count = 2, .indices = tip + 1}}};
    f->params.pins = pins;
    f->params.pin_count = 2;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 2);
    assert_attachment(&f->attachments.items[0], "left", "contact", 2, 3);
    assert_string_equal(f->attachments.items[1].method, "pin+contact");
    const sn_index expected[] = {0, 1, 6, 18, 19, 20, 21}; /* the later pin to "tail" finds its vertices taken */
    assert_int_equal(f->attachments.items[1].count, 7);
    assert_memory_equal(f->attachments.items[1].vertices, expected, sizeof expected);
    assert_true(f->attachments.items[1].distances[0] == 8.5 && f->attachments.items[1].distances[2] == 5.5);
}

static void a_pin_needs_no_mesh(void **state) {
    fixture *f = *state;
    const sn_attach_pin pin = {"talus", {.kind = SN_SELECT_BOX, .point = {-1, -1, -1}, .other = {0.5, 2, 1}}};
    f->params = (sn_attach_params){.distance = -1, .pin_count = 1, .pins = &pin};
    f->params.bone_count = 0;
    assert_int_equal(sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &f->error), SN_OK);
    assert_int_equal(f->attachments.count, 1);
    assert_attachment(&f->attachments.items[0], "talus", "pin", 0, 1);
    assert_null(f->attachments.items[0].distances);
    assert_int_equal(f->report.pair_count, 0);
}

/* A pin to a bone that would be culled still has its distance measured. */
static void a_pinned_bone_is_not_culled(void **state) {
    fixture *f = *state;
    const sn_attach_pin pin = {"moon", {.kind = SN_SELECT_NEAR, .point = {5, 0, 0}, .count = 1}};
    f->params.pins = &pin;
    f->params.pin_count = 1;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(f->attachments.count, 3);
    assert_attachment(&f->attachments.items[2], "moon", "pin", 10, 10);
    assert_true(f->attachments.items[2].distances[0] == 995.0);
    assert_false(f->report.pairs[2].culled);
}

/* ---- steps, threads, refusals -------------------------------------------------------------------------------------------------------- */

static void it_stops_after_n_bones(void **state) {
    fixture *f = *state;
    for (int n = 0; n <= 3; n++) {
        sn_trace trace = {.stop_after = n};
        assert_int_equal(detect(f, &trace), SN_STOPPED);
        assert_int_equal(f->report.pair_count, n);
        assert_int_equal(f->attachments.count, n < 2 ? n : 2);
        assert_int_equal(trace.steps, n);
    }
    sn_trace trace = {.stop_after = 4};
    assert_int_equal(detect(f, &trace), SN_OK);
}

/* A long ragged strip over bones with curved distances: the same bits on one and on four threads. */
static void threads_agree(void **state) {
    fixture *f = *state;
    sn_muscle_free(&f->muscle);
    f->muscle = strip(5000);
    uint64_t seed = 1;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        sn_vec3 *p = &f->muscle.mesh.positions[v];
        *p = sn_v3(p->x * 0.002 + 0.01 * sn_random(&seed), p->y + 3 * sn_random(&seed), 3 * sn_random(&seed));
    }
    f->params.distance = 2;
    f->params.threads = 1;
    assert_int_equal(detect(f, NULL), SN_OK);
    fixture one = *f;
    f->attachments = (sn_attachment_list){0}, f->report = (sn_attach_report){0};
    f->params.threads = 4;
    assert_int_equal(detect(f, NULL), SN_OK);
    assert_int_equal(one.attachments.count, f->attachments.count);
    assert_true(f->report.attached > 1000);
    for (sn_index a = 0; a < f->attachments.count; a++) {
        assert_int_equal(one.attachments.items[a].count, f->attachments.items[a].count);
        size_t count = (size_t)f->attachments.items[a].count;
        assert_memory_equal(one.attachments.items[a].vertices, f->attachments.items[a].vertices, count * sizeof(sn_index));
        assert_memory_equal(one.attachments.items[a].distances, f->attachments.items[a].distances, count * sizeof(double));
    }
    for (sn_index p = 0; p < 3; p++) assert_true(one.report.pairs[p].nearest == f->report.pairs[p].nearest);
    sn_attachments_free(one.attachments.items, one.attachments.count);
    sn_attach_report_free(&one.report);
}

static void bad_input_is_refused(void **state) {
    fixture *f = *state;
    f->bones[2].name = "left";
    assert_int_equal(detect(f, NULL), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "left"));
    f->bones[2].name = "moon";
    f->moon.positions[3].y = NAN;
    assert_int_equal(detect(f, NULL), SN_ERROR_INPUT);
    assert_non_null(strstr(f->error.text, "moon"));
    f->moon.positions[3].y = 1;
    const sn_attach_pin pin = {"left", {.kind = SN_SELECT_SPHERE, .point = {0, 0, 99}, .radius = 1}};
    f->params.pins = &pin;
    f->params.pin_count = 1;
    assert_int_equal(detect(f, NULL), SN_ERROR_INPUT); /* the pin holds no vertex */
    assert_non_null(strstr(f->error.text, "left"));
    f->params.pin_count = 0;
    f->params.distance = INFINITY;
    assert_int_equal(detect(f, NULL), SN_ERROR_USAGE);
    assert_int_equal(f->attachments.count, 0);
    assert_null(f->attachments.items);
}

/* ---- how bones hold ----------------------------------------------------------------------------------------------------------- */

static sn_attachment hold(char *bone, sn_index count, sn_index *vertices) {
    return (sn_attachment){.bone = bone, .count = count, .vertices = vertices};
}

/* A vertex inside the strip stands for half a square; those within a tenth of the length are 21 on its side and 19 on the other. */
static void grips_are_measured(void **state) {
    (void)state;
    sn_index one[] = {100}, some[] = {100, 101, 110, 120, 140}, tip[] = {0, 1, 2, 3};
    sn_attachment held[] = {hold("a", 1, one), hold("b", 5, some), hold("c", 4, tip), hold("d", 0, NULL)};
    sn_muscle muscle = strip(100);
    sn_grip grips[4];
    muscle.attachments = held;
    muscle.attachment_count = 4;
    assert_int_equal(sn_muscle_grips(&muscle, grips, NULL), SN_OK);
    assert_true(fabs(grips[0].share - 1.0 / 40.0) < 1e-12 && grips[0].patches == 1 && grips[0].largest == 1);
    assert_true(grips[1].patches == 4 && grips[1].largest == 2 && grips[1].share > 0.01 && grips[1].share <= 1.0);
    assert_true(grips[2].patches == 1 && grips[2].largest == 4 && grips[3].patches == 0 && isnan(grips[3].share));
    const sn_grip_quality expected[] = {SN_GRIP_GOOD, SN_GRIP_SPECKLED, SN_GRIP_GOOD, SN_GRIP_GOOD};
    for (int i = 0; i < 4; i++) assert_int_equal(sn_grip_judge(&held[i], &grips[i]), expected[i]);
    assert_null(sn_muscle_only_bone(&muscle));
    muscle.attachments = held + 2; /* the other one holds nothing */
    muscle.attachment_count = 2;
    assert_string_equal(sn_muscle_only_bone(&muscle), "c");
    sn_mesh_free(&muscle.mesh);
    muscle = strip(1000); /* one vertex of 201 + 199 */
    muscle.attachments = held;
    muscle.attachment_count = 1;
    one[0] = 1000;
    assert_int_equal(sn_muscle_grips(&muscle, grips, NULL), SN_OK);
    assert_true(fabs(grips[0].share - 1.0 / 400.0) < 1e-12);
    assert_int_equal(sn_grip_judge(&held[0], &grips[0]), SN_GRIP_SLIGHT);
    sn_mesh_free(&muscle.mesh);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(contact_takes_vertices_inside),
        TEST(contact_takes_vertices_on_the_surface),
        TEST(proximity_takes_vertices_closer_than_the_distance),
        TEST(default_distance_follows_the_mean_edge),
        TEST(a_vertex_goes_to_the_nearest_bone),
        TEST(every_pair_is_reported),
        TEST(nothing_in_reach_is_no_error),
        TEST(pins_come_first),
        TEST(a_pin_needs_no_mesh),
        TEST(a_pinned_bone_is_not_culled),
        TEST(it_stops_after_n_bones),
        TEST(threads_agree),
        TEST(bad_input_is_refused),
        cmocka_unit_test(grips_are_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
