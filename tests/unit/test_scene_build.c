/* test_scene_build.c -- parts of a scene put together: frames of motions, how far they begin from rest, bones and joints, settings. */
#include "shapes.h"

#include "sinew/scene_build.h"

#include <string.h>

/* A motion with a hinge whose keys are at those times, s, and those degrees. */
static sn_motion hinge(sn_index count, const double *times, const double *degrees) {
    sn_motion motion = {.joint_count = 1, .joints = SN_NEW(sn_joint, 1)};
    sn_joint *joint = &motion.joints[0];
    *joint = (sn_joint){.name = sn_strdup("elbow"), .parent = SN_NONE, .kind = SN_JOINT_HINGE, .axis = {0, 0, 1}, .point = {1, 0, 0}};
    joint->angle.count = count;
    joint->angle.times = SN_NEW(double, count);
    joint->angle.values = SN_NEW(double, count);
    for (sn_index i = 0; i < count; i++) {
        joint->angle.times[i] = times[i];
        joint->angle.values[i] = degrees[i] * SN_PI / 180.0;
    }
    return motion;
}

static void put(sn_scene_draft *draft, double first, double last, double degrees, double rate) {
    sn_motion motion = hinge(2, (const double[]){first, last}, (const double[]){degrees, 90.0});
    sn_draft_defaults(draft);
    assert_ok(sn_draft_put_motion(draft, &motion, rate, "x.motion.json", NULL));
    assert_null(motion.joints);
}

static void frames_are_from_zero_or_the_first_key_to_the_last(void **state) {
    (void)state;
    static const struct {
        double first, last, rate;
        sn_index from, to;
    } cases[] = {{0.0, 2.0, 24.0, 0, 48},  {0.25, 2.0, 24.0, 0, 48}, {-0.5, 1.0, 24.0, -12, 24}, {-0.51, 1.0, 10.0, -6, 10},
                 {0.0, 1.01, 10.0, 0, 11}, {0.0, 0.1, 30.0, 0, 3},   {-2.0, -1.0, 10.0, -20, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sn_scene_draft draft;
        put(&draft, cases[k].first, cases[k].last, 0.0, cases[k].rate);
        assert_int_equal(draft.first_frame, cases[k].from);
        assert_int_equal(draft.last_frame, cases[k].to);
        draft.rate *= 2.0;
        assert_ok(sn_draft_spread(&draft, NULL));
        assert_true(draft.last_frame >= 2 * cases[k].to - 1 && draft.last_frame <= 2 * cases[k].to);
        draft.rate = 1e12;
        assert_int_equal(sn_draft_spread(&draft, NULL), SN_ERROR_INPUT);
        sn_draft_free(&draft);
    }
}

static void add(sn_scene_draft *draft, const char *name) {
    char path[] = "bone.ply";
    char *copy = sn_strdup(name);
    const sn_motion_bone bone = {.name = copy, .path = path};
    assert_ok(sn_draft_add_bone(draft, &bone, NULL));
    free(copy);
}

/* Only joints that move a bone count, and turns by how much whatever the way. */
static void a_start_away_from_rest_is_measured_where_bones_are(void **state) {
    (void)state;
    sn_scene_draft draft;
    double angle, distance;
    put(&draft, 0.0, 1.0, -30.0, 10.0);
    add(&draft, "table");
    assert_ok(sn_draft_away(&draft, &angle, &distance, NULL));
    assert_true(angle == 0.0 && distance == 0.0);
    add(&draft, "elbow"); /* it hangs on the joint of its name */
    assert_int_equal(sn_draft_find_bone(&draft, "elbow")->bone.joint, 0);
    assert_ok(sn_draft_away(&draft, &angle, &distance, NULL));
    assert_true(fabs(angle - SN_PI / 6.0) < 1e-12 && distance < 1e-15);
    draft.first_frame = 10;
    assert_ok(sn_draft_away(&draft, &angle, &distance, NULL));
    assert_true(fabs(angle - SN_PI / 2.0) < 1e-12);
    sn_draft_free(&draft);
}

static void bindings_are_by_pattern_and_name_what_they_do_not_find(void **state) {
    (void)state;
    sn_scene_draft draft;
    sn_error error;
    put(&draft, 0.0, 1.0, 0.0, 10.0);
    add(&draft, "ulna_r");
    add(&draft, "radius_r");
    add(&draft, "humerus");
    assert_ok(sn_draft_bind(&draft, "*_r=elbow", NULL));
    assert_int_equal(sn_draft_find_bone(&draft, "ulna_r")->bone.joint, 0);
    assert_int_equal(sn_draft_find_bone(&draft, "radius_r")->bone.joint, 0);
    assert_int_equal(sn_draft_find_bone(&draft, "humerus")->bone.joint, SN_NONE);
    assert_int_equal(sn_draft_bind(&draft, "*_l=elbow", &error), SN_ERROR_INPUT);
    assert_int_equal(sn_draft_bind(&draft, "humerus=knee", &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "\"knee\""));
    assert_int_equal(sn_draft_bind(&draft, "humerus=", &error), SN_ERROR_USAGE);
    assert_int_equal(sn_draft_bind(&draft, "=elbow", &error), SN_ERROR_USAGE);
    char name[] = "humerus", path[] = "other.ply";
    const sn_motion_bone again = {.name = name, .path = path};
    assert_int_equal(sn_draft_add_bone(&draft, &again, &error), SN_ERROR_INPUT);
    sn_draft_free(&draft);
}

static void muscle(sn_scene_draft *draft, const char *name) {
    static sn_draft_muscle muscles[2];
    sn_draft_muscle *m = &muscles[draft->muscle_count++];
    *m = (sn_draft_muscle){.name = sn_strdup(name), .path = sn_strdup("rig.muscle.json")};
    draft->muscles = muscles;
}

static const char *setting(const sn_draft_muscle *m, const char *member) {
    for (int i = 0; i < SN_DRAFT_MEMBERS; i++)
        if (strcmp(sn_draft_members[i], member) == 0) return m->settings[i];
    fail();
    return NULL;
}

/* Names may hold dots; the member is what a muscle of a scene has. */
static void settings_find_their_member_behind_any_dots(void **state) {
    (void)state;
    sn_scene_draft draft;
    sn_error error;
    sn_draft_defaults(&draft);
    muscle(&draft, "m. biceps");
    muscle(&draft, "triceps.tone");
    sn_draft_muscle *m = draft.muscles;
    assert_ok(sn_draft_set(&draft, "m. b*.stiffness.relaxed=1e5", NULL));
    assert_string_equal(setting(&m[0], "stiffness.relaxed"), "1e5");
    assert_null(setting(&m[1], "stiffness.relaxed"));
    assert_ok(sn_draft_set(&draft, "triceps.tone.restLength=0.9", NULL));
    assert_string_equal(setting(&m[1], "restLength"), "0.9");
    assert_ok(sn_draft_set(&draft, "*.law=isochoric", NULL));
    assert_ok(sn_draft_set(&draft, "m*.law=\"paper\"", NULL));
    assert_string_equal(setting(&m[0], "law"), "\"paper\"");
    assert_string_equal(setting(&m[1], "law"), "isochoric");
    static const char *const wrong[] = {
        "*.rig=x",   "*.name=x", "*.stiffness=1",    "*.tone",      "*.tone=",        "*.tone=-1", "*.tone=[1",
        "*.tone=1e", "*.law=1",  "*.iterations=1.5", "*.enabled=1", "*.activation=2", "tone=1"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) assert_int_equal(sn_draft_set(&draft, wrong[k], &error), SN_ERROR_USAGE);
    assert_int_equal(sn_draft_set(&draft, "x.tone=1", &error), SN_ERROR_INPUT);
    for (sn_index i = 0; i < 2; i++) {
        free(m[i].name);
        free(m[i].path);
        for (int k = 0; k < SN_DRAFT_MEMBERS; k++) free(m[i].settings[k]);
    }
}

static void channels_have_names_and_there_is_one(void **state) {
    (void)state;
    char name[] = "x.json", good[] = "{\"channels\": {\"a\": {}, \"b b\": {}}}", none[] = "{\"channels\": {}}", other[] = "{\"a\": 1}";
    const sn_blob blobs[] = {{name, good, sizeof good - 1}, {name, none, sizeof none - 1}, {name, other, sizeof other - 1}};
    sn_muscle_names names;
    sn_error error;
    assert_ok(sn_activation_names_parse(&blobs[0], &names, NULL));
    assert_int_equal(names.count, 2);
    assert_string_equal(names.names[1], "b b");
    sn_muscle_names_free(&names);
    for (int k = 1; k < 3; k++) {
        assert_int_equal(sn_activation_names_parse(&blobs[k], &names, &error), SN_ERROR_INPUT);
        assert_null(names.names);
        assert_string_equal(error.file, "x.json");
    }
}

static void text_in_memory_is_what_was_written(void **state) {
    (void)state;
    sn_output *output;
    sn_blob blob;
    assert_ok(sn_output_open_memory(&output, NULL));
    for (int i = 0; i < 100000; i++) sn_output_print(output, "%d\n", i % 10);
    assert_ok(sn_output_take(output, "-", &blob, NULL));
    assert_string_equal(blob.name, "<stdout>");
    assert_int_equal(blob.size, 200000);
    assert_int_equal(strlen(blob.data), 200000);
    assert_memory_equal(blob.data + 199998, "9\n", 2);
    sn_blob_free(&blob);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_from_zero_or_the_first_key_to_the_last),
        cmocka_unit_test(a_start_away_from_rest_is_measured_where_bones_are),
        cmocka_unit_test(bindings_are_by_pattern_and_name_what_they_do_not_find),
        cmocka_unit_test(settings_find_their_member_behind_any_dots),
        cmocka_unit_test(channels_have_names_and_there_is_one),
        cmocka_unit_test(text_in_memory_is_what_was_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
