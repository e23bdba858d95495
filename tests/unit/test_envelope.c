/* test_envelope.c -- envelopes: rigid where one bone carries, rigid as a whole, weights that do not jump, q and -q alike, documents. */
#include "sinew/io.h"

#include "shapes.h"

#include <stdio.h>

enum { BONES = 6 };

static sn_vec3 moved(sn_vec3 p, double scale, sn_vec3 by) { return sn_add(sn_scale(p, scale), by); }

static sn_mesh ball(double radius, sn_vec3 centre) {
    sn_mesh mesh = shape_sphere(7, 12);
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v] = moved(mesh.positions[v], radius, centre);
    return mesh;
}

/* A row of balls 0.1 m apart along x, a bone each, under a tube-like sphere stretched over them. */
typedef struct row {
    sn_mesh meshes[BONES], skin;
    sn_envelope_bone bones[BONES];
    sn_envelope_params params;
} row;

static row make_row(sn_envelope_method method) {
    static const char *const names[BONES] = {"a", "b", "c", "d", "e", "f"};
    row r = {.params = {.method = method, .reach = 0.05}};
    for (sn_index b = 0; b < BONES; b++) {
        r.meshes[b] = ball(0.03, sn_v3(0.1 * b, 0, 0));
        r.bones[b] = (sn_envelope_bone){names[b], NULL, b};
    }
    r.skin = shape_sphere(40, 16);
    for (sn_index v = 0; v < r.skin.vertex_count; v++) {
        sn_vec3 p = r.skin.positions[v];
        r.skin.positions[v] = sn_v3(0.25 + 0.3 * p.z, 0.05 * p.x, 0.05 * p.y);
    }
    return r;
}

static sn_envelope bind_row(row *r) {
    sn_envelope envelope;
    for (sn_index b = 0; b < BONES; b++) r->bones[b].mesh = &r->meshes[b];
    assert_ok(sn_envelope_bind(&r->skin, BONES, r->bones, &r->params, &envelope, NULL));
    return envelope;
}

static void free_row(row *r) {
    for (sn_index b = 0; b < BONES; b++) sn_mesh_free(&r->meshes[b]);
    sn_mesh_free(&r->skin);
}

/* Some pose: turned far about a slanted axis, moved by a metre. */
static sn_rigid some_pose(uint64_t *seed) {
    sn_vec3 axis = sn_normalize(sn_v3(sn_random(seed) - 0.5, sn_random(seed) - 0.5, sn_random(seed) - 0.5));
    sn_vec3 shift = sn_v3(sn_random(seed), sn_random(seed), -sn_random(seed));
    return (sn_rigid){sn_quat_axis_angle(axis, 6.0 * sn_random(seed)), shift};
}

static const sn_envelope_method methods[] = {SN_ENVELOPE_BLEND, SN_ENVELOPE_WRAP};

static void a_vertex_on_one_bone_goes_exactly_with_it(void **state) {
    (void)state;
    for (int m = 0; m < 2; m++) {
        uint64_t seed = 1;
        row r = make_row(methods[m]);
        sn_envelope envelope = bind_row(&r);
        sn_vec3 *places = SN_NEW(sn_vec3, r.skin.vertex_count);
        sn_rigid poses[BONES];
        sn_index alone = 0, shared = 0;
        for (sn_index b = 0; b < BONES; b++) poses[b] = some_pose(&seed);
        sn_envelope_deform(&envelope, poses, NULL, places);
        for (sn_index v = 0; v < r.skin.vertex_count; v++) {
            const sn_influence *influence = &envelope.influences[v];
            sn_vec3 rigid = sn_rigid_apply(poses[influence->bones[0]], r.skin.positions[v]);
            if (influence->count == 1) {
                assert_true(influence->weights[0] == 1.0);
                assert_near(sn_distance(places[v], rigid), 0.0, 1e-12);
            }
            alone += influence->count == 1;
            shared += influence->count > 1 && sn_distance(places[v], rigid) > 1e-3;
        }
        assert_true(alone > 20 && shared > 100);
        free(places);
        sn_envelope_free(&envelope);
        free_row(&r);
    }
}

/* One motion for all bones is that of the envelope, whatever the sign of each quaternion. */
static void bones_that_move_as_one_move_the_envelope_rigidly(void **state) {
    (void)state;
    for (int m = 0; m < 2; m++) {
        uint64_t seed = 7;
        row r = make_row(methods[m]);
        sn_envelope envelope = bind_row(&r);
        sn_vec3 *places = SN_NEW(sn_vec3, r.skin.vertex_count);
        for (int trial = 0; trial < 20; trial++) {
            sn_rigid pose = some_pose(&seed), poses[BONES];
            for (sn_index b = 0; b < BONES; b++) {
                sn_quat q = pose.rotation;
                poses[b] = pose;
                if ((b + trial) % 2 == 1) poses[b].rotation = (sn_quat){-q.w, -q.x, -q.y, -q.z};
            }
            sn_envelope_deform(&envelope, poses, NULL, places);
            for (sn_index v = 0; v < r.skin.vertex_count; v++)
                assert_near(sn_distance(places[v], sn_rigid_apply(pose, r.skin.positions[v])), 0.0, 1e-12);
        }
        free(places);
        sn_envelope_free(&envelope);
        free_row(&r);
    }
}

/* A turn by 350 degrees is one by -10: half of it, on the midline, is -5 and not 175. */
static void a_turn_of_350_degrees_is_one_of_minus_10(void **state) {
    (void)state;
    const sn_vec3 axis = {0, 0, 1};
    row r = make_row(SN_ENVELOPE_BLEND);
    sn_envelope envelope = bind_row(&r);
    sn_vec3 *there = SN_NEW(sn_vec3, r.skin.vertex_count), *back = SN_NEW(sn_vec3, r.skin.vertex_count);
    sn_rigid poses[BONES];
    for (sn_index b = 0; b < BONES; b++) poses[b] = (sn_rigid){sn_quat_axis_angle(axis, b % 2 ? SN_PI * 350.0 / 180.0 : 0.0), {0, 0, 0}};
    assert_true(sn_quat_dot(poses[0].rotation, poses[1].rotation) < -0.9);
    sn_envelope_deform(&envelope, poses, NULL, there);
    for (sn_index b = 0; b < BONES; b++) poses[b].rotation = sn_quat_axis_angle(axis, b % 2 ? -SN_PI / 18.0 : 0.0);
    sn_envelope_deform(&envelope, poses, NULL, back);
    sn_index shared = 0;
    for (sn_index v = 0; v < r.skin.vertex_count; v++) {
        sn_vec3 rest = r.skin.positions[v];
        assert_near(sn_distance(there[v], back[v]), 0.0, 1e-12);
        /* about the origin: nowhere farther than a turn by 10 degrees takes it */
        assert_true(sn_distance(there[v], rest) <= 2.0 * sin(SN_PI / 36.0) * sn_norm(rest) + 1e-12);
        assert_near(sn_norm(there[v]), sn_norm(rest), 1e-12); /* all poses turn about the origin, and so does their blend */
        shared += envelope.influences[v].count > 1;
    }
    assert_true(shared > 100);
    free(there);
    free(back);
    sn_envelope_free(&envelope);
    free_row(&r);
}

/* Wrap draws in what turns apart by half a turn; the blend of dual quaternions does not. */
static void blend_keeps_the_distance_where_wrap_draws_in(void **state) {
    (void)state;
    double nearest[2] = {INFINITY, INFINITY};
    for (int m = 0; m < 2; m++) {
        row r = make_row(methods[m]);
        sn_envelope envelope = bind_row(&r);
        sn_vec3 *places = SN_NEW(sn_vec3, r.skin.vertex_count);
        sn_rigid poses[BONES];
        for (sn_index b = 0; b < BONES; b++) poses[b] = (sn_rigid){sn_quat_axis_angle(sn_v3(1, 0, 0), 2.8 * (b % 2)), {0, 0, 0}};
        sn_envelope_deform(&envelope, poses, NULL, places);
        for (sn_index v = 0; v < r.skin.vertex_count; v++) {
            double before = sn_length2(r.skin.positions[v].y, r.skin.positions[v].z), after = sn_length2(places[v].y, places[v].z);
            if (before > 0.03) nearest[m] = fmin(nearest[m], after / before);
        }
        free(places);
        sn_envelope_free(&envelope);
        free_row(&r);
    }
    assert_near(nearest[0], 1.0, 1e-12);
    assert_true(nearest[1] < 0.3);
}

/* ---- weights --------------------------------------------------------------------------------------------------------------------- */

static void weights_of(const sn_envelope *envelope, sn_index v, double weights[BONES]) {
    double sum = 0.0;
    for (sn_index b = 0; b < BONES; b++) weights[b] = 0.0;
    for (sn_index k = 0; k < envelope->influences[v].count; k++) {
        weights[envelope->influences[v].bones[k]] = envelope->influences[v].weights[k];
        sum += envelope->influences[v].weights[k];
    }
    assert_near(sum, 1.0, 1e-15);
}

/* Vertices every 0.2 mm along a line: from one to the next no weight changes by more than what the slope of the weights allows. */
static sn_mesh line(sn_vec3 from, sn_vec3 to, sn_index count) {
    sn_mesh mesh = shape_empty(count, count - 2);
    for (sn_index v = 0; v < count; v++) mesh.positions[v] = sn_lerp(from, to, v / (count - 1.0));
    for (sn_index t = 0; t < count - 2; t++) mesh.triangles[t] = (sn_triangle){{t, t + 1, t + 2}};
    return mesh;
}

/* The greatest change of a weight over the length of the step, by one vertex to the next. */
static double steepest(row *r, sn_vec3 from, sn_vec3 to, sn_index count, sn_index *most) {
    double last[BONES], now[BONES], steep = 0.0, step = sn_distance(from, to) / (count - 1.0);
    sn_envelope envelope;
    sn_mesh_free(&r->skin);
    r->skin = line(from, to, count);
    envelope = bind_row(r);
    *most = 0;
    for (sn_index v = 0; v < count; v++) {
        weights_of(&envelope, v, now);
        for (sn_index b = 0; v > 0 && b < BONES; b++) steep = fmax(steep, fabs(now[b] - last[b]) / step);
        if (envelope.influences[v].count > *most) *most = envelope.influences[v].count;
        memcpy(last, now, sizeof now);
    }
    sn_envelope_free(&envelope);
    return steep;
}

static void weights_between_two_bones_never_jump(void **state) {
    (void)state;
    row r = make_row(SN_ENVELOPE_BLEND);
    sn_index most;
    /* d - d0 goes twice as fast as the vertex between two bones, and twice reach is the way from 1 to 0: at most 1.25 / reach */
    double steep = steepest(&r, sn_v3(0, 0.04, 0), sn_v3(0.1, 0.04, 0), 1000, &most);
    assert_true(most == 2 && steep > 0.8 / r.params.reach && steep <= 1.2500001 / r.params.reach);
    /* finer steps are not steeper, as they would be over a jump */
    double finer = steepest(&r, sn_v3(0, 0.04, 0), sn_v3(0.1, 0.04, 0), 16000, &most);
    assert_true(finer <= 1.02 * steep);
    free_row(&r);
}

/* Also where the fourth nearest of six bones changes. */
static void weights_do_not_jump_where_the_fourth_bone_changes(void **state) {
    (void)state;
    row r = make_row(SN_ENVELOPE_BLEND);
    sn_index most;
    r.params.reach = 0.5;
    double steep = steepest(&r, sn_v3(-0.05, 0.3, 0.01), sn_v3(0.55, 0.25, 0), 1500, &most);
    double finer = steepest(&r, sn_v3(-0.05, 0.3, 0.01), sn_v3(0.55, 0.25, 0), 24000, &most);
    assert_int_equal(most, SN_INFLUENCE_LIMIT);
    assert_true(finer <= 1.1 * steep);
    free_row(&r);
}

/* Bones on one joint are as one: the nearest of them carries, and those of other joints keep their places among the four. */
static void bones_of_one_joint_do_not_crowd_out_others(void **state) {
    (void)state;
    row r = make_row(SN_ENVELOPE_BLEND);
    r.params.reach = 0.3;
    for (sn_index b = 0; b < BONES - 1; b++) r.bones[b].joint = 0;
    sn_envelope envelope = bind_row(&r);
    sn_index both = 0;
    for (sn_index v = 0; v < r.skin.vertex_count; v++) {
        const sn_influence *influence = &envelope.influences[v];
        assert_true(influence->count <= 2);
        both += influence->count == 2;
        if (influence->count == 2) assert_true((influence->bones[0] == BONES - 1) != (influence->bones[1] == BONES - 1));
    }
    assert_true(both > 100);
    sn_envelope_free(&envelope);
    free_row(&r);
}

static void threads_make_no_difference(void **state) {
    (void)state;
    row r = make_row(SN_ENVELOPE_BLEND);
    sn_envelope one = bind_row(&r);
    r.params.pool = sn_pool_create(4);
    sn_envelope four = bind_row(&r);
    assert_memory_equal(one.influences, four.influences, (size_t)r.skin.vertex_count * sizeof *one.influences);
    sn_pool_destroy(r.params.pool);
    sn_envelope_free(&one);
    sn_envelope_free(&four);
    free_row(&r);
}

/* ---- measures ---------------------------------------------------------------------------------------------------------------------- */

/* A bone that leaves the envelope by a known way, and triangles that shrink by a known factor. */
static void what_comes_out_and_what_shrinks_is_measured(void **state) {
    (void)state;
    sn_mesh skin = ball(0.1, sn_v3(0, 0, 0)), bone = ball(0.05, sn_v3(0, 0, 0)), far_bone = ball(0.01, sn_v3(0, 0, 0.03));
    sn_envelope_bone bones[] = {{"near", &bone, 0}, {"far", &far_bone, 1}};
    const sn_envelope_params params = {.reach = 1e-3};
    sn_envelope envelope;
    sn_envelope_frame frame;
    assert_ok(sn_envelope_bind(&skin, 2, bones, &params, &envelope, NULL));
    assert_ok(sn_envelope_measure(&envelope, bones, NULL, NULL, &frame, NULL));
    assert_near(frame.least_area, 1.0, 0.0);
    assert_true(frame.small == 0 && frame.outside == 0 && frame.deep == 0);
    assert_true(frame.deepest < -0.04);
    sn_rigid poses[2] = {sn_rigid_identity(), {sn_quat_identity(), {0, 0, 0.2}}};
    assert_ok(sn_envelope_measure(&envelope, bones, poses, NULL, &frame, NULL));
    assert_near(frame.deepest, 0.03 + 0.01 + 0.2 - 0.1, 1e-12); /* pole above pole */
    assert_int_equal(frame.bone, 1);
    assert_near(sn_distance(far_bone.positions[frame.vertex], sn_v3(0, 0, 0.04)), 0.0, 1e-12);
    assert_int_equal(frame.outside, far_bone.vertex_count);
    assert_int_equal(frame.deep, far_bone.vertex_count);
    for (sn_index v = 0; v < skin.vertex_count; v++) envelope.influences[v] = (sn_influence){2, {0, 1}, {0.5, 0.5}};
    envelope.method = SN_ENVELOPE_WRAP;
    poses[1] = (sn_rigid){sn_quat_axis_angle(sn_v3(0, 0, 1), 2.0 * SN_PI / 3.0), {0, 0, 0}}; /* the mean halves x and y */
    assert_ok(sn_envelope_measure(&envelope, bones, poses, NULL, &frame, NULL));
    assert_true(frame.least_area > 0.2499 && frame.least_area < 0.3);
    assert_true(frame.small == 0 && frame.outside > 0);
    sn_envelope_free(&envelope);
    sn_mesh_free(&skin);
    sn_mesh_free(&bone);
    sn_mesh_free(&far_bone);
}

/* ---- documents ----------------------------------------------------------------------------------------------------------------------- */

static sn_status parse_text(const char *text, sn_envelope *out, sn_error *error) {
    char name[] = "x.envelope.json", *data = sn_strdup(text);
    sn_blob blob = {.name = name, .data = data, .size = strlen(text)};
    *error = (sn_error){0};
    sn_status status = sn_envelope_parse(&blob, out, error);
    free(data);
    return status;
}

static void a_document_gives_back_the_same_bits(void **state) {
    (void)state;
    const char *path = "test_envelope.tmp.envelope.json";
    row r = make_row(SN_ENVELOPE_WRAP);
    sn_envelope envelope = bind_row(&r), back;
    sn_output *output;
    sn_blob blob;
    envelope.name = sn_strdup("skin \"1\"");
    assert_ok(sn_output_open(path, false, &output, NULL));
    assert_ok(sn_envelope_write(&envelope, NULL, NULL, output, NULL));
    assert_ok(sn_output_commit(output, NULL));
    assert_ok(sn_blob_read(path, &blob, NULL));
    remove(path);
    assert_true(sn_envelope_detect(&blob));
    assert_ok(sn_envelope_parse(&blob, &back, NULL));
    assert_string_equal(back.name, envelope.name);
    assert_true(back.method == SN_ENVELOPE_WRAP && back.reach == envelope.reach && back.bone_count == BONES);
    for (sn_index b = 0; b < BONES; b++) assert_string_equal(back.bones[b], envelope.bones[b]);
    assert_int_equal(back.mesh.vertex_count, r.skin.vertex_count);
    assert_memory_equal(back.mesh.positions, r.skin.positions, (size_t)r.skin.vertex_count * sizeof(sn_vec3));
    assert_memory_equal(back.mesh.triangles, r.skin.triangles, (size_t)r.skin.triangle_count * sizeof(sn_triangle));
    assert_memory_equal(back.influences, envelope.influences, (size_t)r.skin.vertex_count * sizeof(sn_influence));
    sn_blob_free(&blob);
    sn_envelope_free(&back);
    sn_envelope_free(&envelope);
    free_row(&r);
}

#define HEAD "{\"format\":\"sinew-envelope\",\"version\":1,"
#define MESH "\"mesh\":{\"vertices\":[0,0,0,1,0,0,0,1,0],\"triangles\":[0,1,2]},"
#define NAMES "\"bones\":[\"a\",\"b\"],"

static void a_unit_is_obeyed(void **state) {
    (void)state;
    sn_envelope envelope;
    sn_error error;
    assert_ok(parse_text(HEAD "\"metersPerUnit\":0.01,\"reach\":4," MESH NAMES
                              "\"influences\":{\"counts\":[1,2,1],\"bones\":[0,0,1,1],\"weights\":[1,0.75,0.25,1]}}",
                         &envelope, &error));
    assert_near(envelope.mesh.positions[1].x, 0.01, 1e-17);
    assert_near(envelope.reach, 0.04, 1e-17);
    assert_int_equal(envelope.influences[1].bones[1], 1);
    assert_true(envelope.method == SN_ENVELOPE_BLEND);
    sn_envelope_free(&envelope);
}

static void broken_documents_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {HEAD MESH NAMES "\"method\":\"mix\",\"influences\":{\"counts\":[1,1,1],\"bones\":[0,0,0],\"weights\":[1,1,1]}}", "method"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1],\"bones\":[0,0],\"weights\":[1,1]}}", "counts"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,5],\"bones\":[0,0,0,0,0,0,0],\"weights\":[1,1,1,1,1,1,1]}}", "counts"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,0,1],\"bones\":[0,0],\"weights\":[1,1]}}", "counts"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,1],\"bones\":[0,2,0],\"weights\":[1,1,1]}}", "bones"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,1],\"bones\":[0,-1,0],\"weights\":[1,1,1]}}", "bones"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,1],\"bones\":[0,0,0],\"weights\":[1,1]}}", "weights"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,1],\"bones\":[0,0,0],\"weights\":[1,0.9,1]}}", "vertex 1"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,2],\"bones\":[0,0,0,1],\"weights\":[1,1,1.5,-0.5]}}", "vertex 2"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,2],\"bones\":[0,0,1,1],\"weights\":[1,1,0.5,0.5]}}", "vertex 2"},
        {HEAD MESH NAMES "\"influences\":{\"counts\":[1,1,2],\"bones\":[0,0,0,1],\"weights\":[1,1,0.4,0.6]}}", "vertex 2"},
        {HEAD MESH "\"bones\":[\"a\",\"a\"],\"influences\":{\"counts\":[1,1,1],\"bones\":[0,0,0],\"weights\":[1,1,1]}}", "called \"a\""},
        {HEAD MESH "\"bones\":[],\"influences\":{\"counts\":[1,1,1],\"bones\":[0,0,0],\"weights\":[1,1,1]}}", "at least one bone"},
        {HEAD NAMES "\"influences\":{\"counts\":[],\"bones\":[],\"weights\":[]}}", "mesh"},
        {HEAD MESH NAMES "\"reach\":0}", "reach"},
        {HEAD MESH NAMES "\"name\":\"x\"}", "influences"},
        {"{\"format\":\"sinew-envelope\",\"version\":2}", "version"},
        {"{\"format\":\"sinew-muscle\",\"version\":1}", "format"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_envelope envelope;
        sn_error error;
        if (parse_text(cases[i].text, &envelope, &error) != SN_ERROR_INPUT) fail_msg("taken: %s", cases[i].text);
        if (strstr(error.text, cases[i].says) == NULL) fail_msg("%s does not say %s", error.text, cases[i].says);
        assert_string_equal(error.file, "x.envelope.json");
        assert_null(envelope.mesh.positions);
    }
}

static void senseless_requests_are_refused(void **state) {
    (void)state;
    row r = make_row(SN_ENVELOPE_BLEND);
    sn_envelope envelope;
    sn_error error = {0};
    static const double reaches[] = {0.0, -1.0, NAN, INFINITY};
    for (sn_index b = 0; b < BONES; b++) r.bones[b].mesh = &r.meshes[b];
    for (int i = 0; i < 4; i++) {
        r.params.reach = reaches[i];
        assert_int_equal(sn_envelope_bind(&r.skin, BONES, r.bones, &r.params, &envelope, &error), SN_ERROR_USAGE);
    }
    r.params.reach = 0.1;
    assert_int_equal(sn_envelope_bind(&r.skin, 0, r.bones, &r.params, &envelope, &error), SN_ERROR_INPUT);
    r.bones[1].name = "a";
    assert_int_equal(sn_envelope_bind(&r.skin, BONES, r.bones, &r.params, &envelope, &error), SN_ERROR_INPUT);
    free_row(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_vertex_on_one_bone_goes_exactly_with_it),
        cmocka_unit_test(bones_that_move_as_one_move_the_envelope_rigidly),
        cmocka_unit_test(a_turn_of_350_degrees_is_one_of_minus_10),
        cmocka_unit_test(blend_keeps_the_distance_where_wrap_draws_in),
        cmocka_unit_test(weights_between_two_bones_never_jump),
        cmocka_unit_test(weights_do_not_jump_where_the_fourth_bone_changes),
        cmocka_unit_test(bones_of_one_joint_do_not_crowd_out_others),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(what_comes_out_and_what_shrinks_is_measured),
        cmocka_unit_test(a_document_gives_back_the_same_bits),
        cmocka_unit_test(a_unit_is_obeyed),
        cmocka_unit_test(broken_documents_are_refused),
        cmocka_unit_test(senseless_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
