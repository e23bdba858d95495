/* test_scene.c -- the scene document: every default filled in, a fixed point when written, every mistake named. */
#include "documents.h"

static const char *const rig =
    "{\"format\":\"sinew-muscle\",\"version\":1,\"name\":\"biceps\",\"metersPerUnit\":0.001,\"mesh\":{\"vertices\":["
    "0,0,0,1,0,0,0,1,0,0,0,1],\"triangles\":[0,2,1,0,1,3,1,2,3,0,3,2]},\"attachments\":[{\"bone\":\"humerus\","
    "\"vertices\":[0]}]}";

static const char *const activation = "{\"channels\":{\"biceps\":{\"times\":[0,1],\"values\":[0,1]},\n"
                                      "\"second\":{\"times\":[0,0.5,2],\"values\":[0.1,0.2,0.7],\"interpolation\":\"smooth\"}}}";

static const char *const motion = "{\"format\":\"sinew-motion\",\"version\":1,\"metersPerUnit\":1,\"rate\":10,\"joints\":[\n"
                                  "{\"name\":\"elbow\",\"type\":\"hinge\",\"axis\":[0,1,0],\"point\":[0,0,0.5],"
                                  "\"keys\":[{\"frame\":0,\"degrees\":0},{\"frame\":10,\"degrees\":90}]}]}";

static const char *const scene_text =
    "{\"format\": \"sinew-scene\", \"version\": 1, \"name\": \"arm\", \"metersPerUnit\": 0.001,\n"
    " \"rate\": 30, \"frames\": [1,90], \"preroll\": 0.5, \"runIn\": 0.25, \"gravity\": [0,0,-9.81], \"solver\": {\"substeps\": 16},\n"
    " \"motion\": {\"joints\": [\n"
    "  {\"name\": \"elbow\", \"type\": \"hinge\", \"axis\": [1,2,3], \"point\": [1.7,23.456789,300.1],\n"
    "   \"keys\": [[0,0],[3.1,120.3]], \"interpolation\": \"smooth\"},\n"
    "  {\"name\": \"ramp\", \"parent\": \"elbow\", \"type\": \"hinge\", \"axis\": [0,0,1], \"point\": [0,0,7], \"degreesPerFrame\": "
    "-0.5},\n"
    "  {\"name\": \"fixed\", \"type\": \"hinge\", \"axis\": [0,0,1], \"point\": [0,0,0], \"degrees\": 12.34},\n"
    "  {\"name\": \"free\", \"type\": \"pose\", \"keys\": [\n"
    "   {\"frame\": 3, \"rotation\": [0.5,0.5,0.5,0.5], \"translation\": [1.1,2.2,3.3]},\n"
    "   {\"time\": 1, \"rotation\": [0.1,0.2,0.3,0.92736185]},\n"
    "   {\"time\": 2, \"matrix\": [0,-1,0,5.1, 1,0,0,6.7, 0,0,1,7.9, 0,0,0,1]}]}]},\n"
    " \"bones\": [{\"name\": \"humerus\", \"mesh\": \"humerus.obj\"},\n"
    "  {\"name\": \"radius\", \"mesh\": \"radius.obj\", \"units\": \"cm\", \"joint\": \"elbow\"}],\n"
    " \"muscles\": [{\"rig\": \"biceps.muscle.json\", \"activation\": {\"keys\": [[0,0],[1,0.3]]}, \"contraction\": 0.3, \"tone\": 0.05, "
    "\"restLength\": 0.9, \"volumeRatio\": "
    "1.3},\n"
    "  {\"name\": \"second\", \"rig\": \"biceps.muscle.json\", \"activation\": {\"uri\": \"x.activation.json\"}, \"law\": \"isochoric\",\n"
    "   \"volumeRatio\": [[0,1],[0.5,1.2],[1,1.3]], \"stiffness\": {\"active\": 1e6}},\n"
    "  {\"rig\": \"nowhere/triceps.muscle.json\", \"enabled\": false}]}\n";

static int write_files(void **state) {
    if (make_folder(state) != 0) return -1;
    write_file("biceps.muscle.json", rig);
    write_file("x.activation.json", activation);
    write_file("x.motion.json", motion);
    write_file("humerus.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write_file("radius.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\nf 1 2 4\n");
    return 0;
}

static sn_scene read_text(const char *text, bool load_bones) {
    sn_scene scene;
    sn_error error = {0};
    sn_blob blob = blob_of("t.scene.json", text);
    if (sn_scene_parse(&blob, load_bones, &scene, &error) != SN_OK) fail_msg("%s: %s", error.file, error.text);
    sn_blob_free(&blob);
    return scene;
}

static char *write_text(const sn_scene *scene) {
    sn_output *output = open_output();
    sn_json *json = sn_json_begin(output, true);
    sn_json_object(json, NULL);
    sn_scene_write(scene, json);
    assert_int_equal(sn_json_end(json, NULL), SN_OK);
    return commit_output(output);
}

static void assert_near(double a, double b) {
    if (!(fabs(a - b) <= 1e-12 * (1.0 + fabs(b)))) fail_msg("%.17g is not %.17g", a, b);
}

/* ---- defaults --------------------------------------------------------------------------------------------------------- */

static void an_empty_scene_has_every_default(void **state) {
    (void)state;
    sn_scene scene = read_text("{\"format\":\"sinew-scene\",\"version\":1,\"muscles\":[{\"rig\":\"biceps.muscle.json\"}],"
                               "\"bones\":[{\"name\":\"humerus\",\"mesh\":\"none.obj\"}]}",
                               false);
    const sn_scene_muscle *m = &scene.muscles[0];
    assert_true(scene.meters_per_unit == 1 && scene.rate == 24 && scene.first_frame == 0 && scene.last_frame == 0 && scene.preroll == 0 &&
                scene.run_in == 0);
    assert_true(sn_norm(scene.gravity) == 0);
    assert_true(scene.solver.method == SN_SOLVER_QN && scene.solver.substeps == SN_SUBSTEPS_AUTO && scene.solver.iterations == 10);
    assert_int_equal(scene.solver.threads, 0);
    assert_true(m->enabled && m->law == SN_LAW_PROJECTED && m->contraction == 0.5 && m->rest_activation == 0 && m->iterations == 0);
    assert_true(m->tone == 0 && m->rest_length == 1);
    assert_true(m->stiffness_relaxed == 5e5 && m->stiffness_active == 5e7 && m->stiffness_internal == 1 && m->stiffness_dihedral == 7.5e-5);
    assert_true(m->stiffness_volume == 4000 && m->density == 1060 && m->damping == 5 && m->volume_ratio.count == 0);
    assert_true(m->activation.count == 0 && m->activation.constant == 0);
    assert_string_equal(m->name, "biceps");
    assert_int_equal(scene.bones[0].joint, SN_NONE);
    assert_int_equal(scene.bones[0].mesh.vertex_count, 0); /* never opened */
    sn_scene_free(&scene);
}

/* ---- what is read ----------------------------------------------------------------------------------------------------- */

static void lengths_angles_and_times_are_si(void **state) {
    (void)state;
    sn_scene scene = read_text(scene_text, true);
    const sn_joint *elbow = &scene.motion.joints[0], *ramp = &scene.motion.joints[1], *pose = &scene.motion.joints[3];
    assert_near(elbow->point.y, 0.023456789);
    assert_near(sn_norm(elbow->axis), 1);
    assert_near(elbow->angle.values[1], 120.3 * SN_PI / 180);
    assert_int_equal(elbow->angle.interpolation, SN_INTERPOLATE_SMOOTH);
    assert_int_equal(ramp->parent, 0);
    assert_near(ramp->angle.times[0], 1.0 / 30);
    assert_near(ramp->angle.times[1], 3);
    assert_near(ramp->angle.values[1], -0.5 * 89 * SN_PI / 180);
    assert_near(scene.motion.joints[2].angle.constant, 12.34 * SN_PI / 180);
    assert_near(pose->keys[0].time, 0.1);
    assert_near(scene.run_in, 0.25);
    assert_near(pose->keys[0].pose.translation.z, 0.0033);
    sn_vec3 turned = sn_rigid_apply(pose->keys[2].pose, sn_v3(1, 0, 0)); /* the matrix turns x to y */
    assert_near(turned.x, 0.0051);
    assert_near(turned.y, 1.0067);
    assert_int_equal(scene.bones[0].mesh.vertex_count, 3);
    assert_true(scene.bones[0].meters_per_unit == 0.001); /* the scene's */
    assert_true(scene.bones[1].meters_per_unit == 0.01);
    assert_int_equal(scene.bones[1].joint, 0);
    sn_scene_free(&scene);
}

static void muscles_are_read(void **state) {
    (void)state;
    sn_scene scene = read_text(scene_text, false);
    const sn_scene_muscle *first = &scene.muscles[0], *second = &scene.muscles[1], *third = &scene.muscles[2];
    assert_int_equal(scene.muscle_count, 3);
    assert_int_equal(first->rig.mesh.vertex_count, 4);
    assert_near(sn_channel_at(&first->activation, 0.5), 0.15);
    assert_true(first->volume_ratio.count == 2 && first->volume_ratio.y[0] == 1 && first->volume_ratio.y[1] == 1.3);
    assert_int_equal(second->activation.count, 3); /* the channel of the muscle's name */
    assert_true(second->activation.values[2] == 0.7);
    assert_int_equal(second->activation.interpolation, SN_INTERPOLATE_SMOOTH);
    assert_int_equal(second->law, SN_LAW_ISOCHORIC);
    assert_true(second->stiffness_active == 1e6 && second->stiffness_relaxed == 5e5);
    assert_true(second->volume_ratio.count == 3);
    assert_false(third->enabled);
    assert_string_equal(third->name, "triceps");
    assert_int_equal(third->rig.mesh.vertex_count, 0); /* never opened */
    sn_scene_free(&scene);
}

static void a_motion_document_has_its_own_unit_and_rate(void **state) {
    (void)state;
    sn_scene scene =
        read_text("{\"format\":\"sinew-scene\",\"version\":1,\"metersPerUnit\":0.001,\"motion\":{\"uri\":\"x.motion.json\"}}", false);
    assert_int_equal(scene.motion.joint_count, 1);
    assert_near(scene.motion.joints[0].point.z, 0.5);
    assert_near(sn_channel_at(&scene.motion.joints[0].angle, 0.5), SN_PI / 4);
    sn_scene_free(&scene);
}

/* ---- what is written -------------------------------------------------------------------------------------------------- */

/* Points, angles and rotations come back as the very same doubles, whatever the unit. */
static void reading_what_was_written_is_the_same_scene(void **state) {
    (void)state;
    sn_scene first = read_text(scene_text, false);
    char *text = write_text(&first);
    sn_scene second = read_text(text, false);
    char *again = write_text(&second);
    assert_string_equal(text, again);
    assert_memory_equal(&first.motion.joints[0].point, &second.motion.joints[0].point, sizeof(sn_vec3));
    assert_memory_equal(&first.motion.joints[0].axis, &second.motion.joints[0].axis, sizeof(sn_vec3));
    for (int j = 0; j < 2; j++)
        assert_memory_equal(first.motion.joints[j].angle.values, second.motion.joints[j].angle.values, 2 * sizeof(double));
    assert_true(first.motion.joints[2].angle.constant == second.motion.joints[2].angle.constant);
    assert_memory_equal(first.motion.joints[3].keys, second.motion.joints[3].keys, 3 * sizeof(sn_pose_key));
    assert_true(second.run_in == 0.25);
    assert_contains(text, "\"point\": [1.7,23.456789,300.1]");
    assert_contains(text, "\"keys\": [[0,0],[3.1,120.3]]");
    free(text);
    free(again);
    sn_scene_free(&first);
    sn_scene_free(&second);
}

/* Every angle of a tenth of a degree, every tenth of a millimetre: none drifts when written and read again. */
static void units_do_not_make_numbers_drift(void **state) {
    (void)state;
    char text[512];
    for (int i = 1; i <= 1000; i++) {
        snprintf(
            text, sizeof text,
            "{\"format\":\"sinew-scene\",\"version\":1,\"metersPerUnit\":0.001,\"motion\":{\"joints\":[{\"name\":\"j\",\"type\":\"hinge\","
            "\"axis\":[%d,3,7],\"point\":[%g,%g,0],\"degrees\":%g}]}}",
            i, i * 0.1, i * -3.7, i * 0.1);
        sn_scene first = read_text(text, false);
        char *written = write_text(&first);
        sn_scene second = read_text(written, false);
        assert_memory_equal(&first.motion.joints[0].axis, &second.motion.joints[0].axis, sizeof(sn_vec3));
        assert_memory_equal(&first.motion.joints[0].point, &second.motion.joints[0].point, sizeof(sn_vec3));
        assert_true(first.motion.joints[0].angle.constant == second.motion.joints[0].angle.constant);
        free(written);
        sn_scene_free(&first);
        sn_scene_free(&second);
    }
}

/* ---- what is wrong ------------------------------------------------------------------------------------------------------- */

static void expect_error(const char *text, const char *file, int64_t line, const char *part) {
    sn_scene scene;
    sn_error error = {0};
    sn_blob blob = blob_of("t.scene.json", text);
    if (sn_scene_parse(&blob, false, &scene, &error) == SN_OK) fail_msg("no error, but expected: %s", part);
    assert_contains(error.text, part);
    assert_string_equal(error.file, path_of(file));
    if (line >= 0) assert_int_equal(error.line, line);
    assert_int_equal(scene.muscle_count, 0);
    sn_blob_free(&blob);
}

static void every_mistake_is_named(void **state) {
    (void)state;
    static const struct {
        const char *old, *new;
        int line;
        const char *part;
    } mistakes[] = {
        {"sinew-scene", "sinew-muscle", 1, "format: expected \"sinew-scene\""},
        {"\"version\": 1", "\"version\": 3", 1, "use a newer sinew"},
        {"0.001", "0", 1, "metersPerUnit: expected a number above 0"},
        {"\"rate\": 30", "\"rate\": -30", 2, "rate: expected a number above 0, found -30"},
        {"[1,90]", "[1,90.5]", 2, "frames: expected two whole frame numbers"},
        {"[1,90]", "[90,1]", 2, "frames: the last frame comes before the first"},
        {"[1,90]", "[1]", 2, "frames: expected an array of 2 numbers, found one of 1"},
        {"-9.81", "\"down\"", 2, "gravity[2]: expected a number, found \"down\""},
        {"\"substeps\": 16", "\"substeps\": 0", 2, "solver.substeps: expected a whole number in [1,"},
        {"\"substeps\": 16", "\"method\": \"fem\"", 2, "solver.method: expected \"xpbd\" or \"qn\", found \"fem\""},
        {"\"substeps\": 16", "\"scheme\": \"kohout\", \"hinges\": \"paper\"", 2,
         "solver.hinges: expected \"scheme\", \"published\" or \"printed\", found \"paper\""},
        {"\"type\": \"hinge\", \"axis\": [1,2,3]", "\"type\": \"ball\", \"axis\": [1,2,3]", 4,
         "motion.joints[0].type: expected \"hinge\" or \"pose\""},
        {"[1,2,3]", "[0,0,0]", 4, "motion.joints[0].axis: the axis has no length"},
        {"[3.1,120.3]", "[0,120.3]", 5, "motion.joints[0].keys[1]: the key is not later"},
        {"[3.1,120.3]", "[3.1]", 5, "motion.joints[0].keys[1]: expected an array of 2 numbers"},
        {"[3.1,120.3]", "3.1", 5, "motion.joints[0].keys[1]"},
        {"[[0,0],[3.1,120.3]]", "[0,0]", 5, "motion.joints[0].keys[0]: expected an object, found a number"},
        {"\"smooth\"", "\"cubic\"", 5, "motion.joints[0].interpolation: expected \"linear\" or \"smooth\""},
        {"\"parent\": \"elbow\"", "\"parent\": \"free\"", 6, "there is no joint \"free\" before this one"},
        {"\"name\": \"ramp\"", "\"name\": \"elbow\"", 6, "motion.joints[1].name: a joint before it has the same name"},
        {"\"degreesPerFrame\": -0.5", "\"degreesPerFrame\": 1, \"degrees\": 1", 6, "only one of"},
        {"{\"frame\": 3, ", "{", 9, "motion.joints[3].keys[0]: expected either \"time\" (seconds) or \"frame\""},
        {"[0.5,0.5,0.5,0.5]", "[1,0.5,0.5,0.5]", 9, "motion.joints[3].keys[0].rotation: the quaternion"},
        {"[0,-1,0,5.1, 1", "[0,-2,0,5.1, 1", 11, "scales, shears or mirrors"},
        {"[0,-1,0,5.1, 1", "[0,1,0,5.1, 1", 11, "scales, shears or mirrors"},
        {"7.9, 0,0,0,1]", "7.9, 1,0,0,1]", 11, "the last row of the matrix"},
        {"\"name\": \"radius\"", "\"name\": \"humerus\"", -1, "two bones have the name \"humerus\""},
        {"\"mesh\": \"radius.obj\", ", "", 13, "bones[1].mesh: expected the file"},
        {"\"units\": \"cm\"", "\"units\": \"ell\"", 13, "bones[1].units: expected \"m\", \"cm\""},
        {"\"units\": \"cm\"", "\"units\": 0", 13, "bones[1].units: expected a number above 0"},
        {"\"joint\": \"elbow\"", "\"joint\": \"knee\"", 13, "bones[1].joint: the motion has no joint \"knee\""},
        {"\"name\": \"humerus\"", "\"name\": \"ulna\"", -1, "is attached to the bone \"humerus\", which the scene does not have"},
        {"[1,0.3]", "[1,1.3]", 14, "muscles[0].activation.keys[1]: expected [time, activation]"},
        {"{\"keys\": [[0,0],[1,0.3]]}", "1.5", 14, "muscles[0].activation: expected a number in [0,1], found 1.5"},
        {"{\"keys\": [[0,0],[1,0.3]]}", "\"full\"", 14, "muscles[0].activation: expected a number in [0,1], {\"keys\""},
        {"\"contraction\": 0.3", "\"contraction\": 1", 14, "muscles[0].contraction: expected a number in [0,0.99], found 1"},
        {"\"volumeRatio\": 1.3", "\"volumeRatio\": 0", 14, "muscles[0].volumeRatio: expected a number above 0"},
        {"\"law\": \"isochoric\"", "\"law\": \"hill\"", 15,
         "muscles[1].law: expected \"projected\", \"paper\" or \"isochoric\", found \"hill\""},
        {"[0.5,1.2]", "[0,1.2]", 16, "muscles[1].volumeRatio[1]: the activations do not ascend"},
        {"[0.5,1.2]", "[0.5,-1]", 16, "muscles[1].volumeRatio[1]: expected [activation in [0,1], value above 0]"},
        {"1e6", "-1", 16, "muscles[1].stiffness.active: expected a number of at least 0, found -1"},
        {"\"name\": \"second\"", "\"name\": \"biceps\"", -1, "two muscles have the name \"biceps\""},
        {"\"enabled\": false", "\"enabled\": 0", 17, "muscles[2].enabled: expected true or false, found 0"},
        {"{\"rig\": \"nowhere/triceps.muscle.json\", ", "{", 17, "muscles[2].rig: expected the file"},
    };
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
        char *text = replace(scene_text, mistakes[i].old, mistakes[i].new);
        expect_error(text, "t.scene.json", mistakes[i].line, mistakes[i].part);
        free(text);
    }
}

/* An error in a file that the scene names is told of that file. */
static void errors_name_the_file_that_is_wrong(void **state) {
    (void)state;
    char *missing = replace(scene_text, "biceps.muscle.json", "none.muscle.json"), *damaged = replace(rig, "0,3,2]", "0,9,2]"),
         *bad = replace(scene_text, "biceps.muscle.json", "bad.muscle.json"), *late = replace(activation, "[0,0.5,2]", "[0,0.5,0.5]"),
         *channel = replace(scene_text, "\"x.activation.json\"", "\"x.activation.json\", \"channel\": \"third\""),
         *slow = replace(scene_text, "x.activation.json", "late.activation.json");
    write_file("bad.muscle.json", damaged);
    write_file("late.activation.json", late);
    expect_error(missing, "none.muscle.json", -1, "No such file");
    expect_error(bad, "bad.muscle.json", 1, "mesh.triangles[10]: expected a whole number in [0,3], found 9");
    expect_error(channel, "x.activation.json", 1, "channels: there is no channel \"third\"");
    expect_error(slow, "late.activation.json", 2, "channels.second.times: sample 2 is not later");
    free(missing), free(damaged), free(bad), free(late), free(channel), free(slow);
}

static void mistyped_members_are_warned_of(void **state) {
    char *text = replace(scene_text, "\"contraction\"", "\"contration\"");
    (void)state;
    sn_scene scene = read_text(text, false);
    assert_contains(logged, "t.scene.json:14: muscles[0]: sinew knows no member contration (did you mean contraction?) here");
    sn_scene_free(&scene);
    free(text);
}

static void truncation_is_an_error(void **state) {
    (void)state;
    for (size_t length = 0; length + 2 < strlen(scene_text); length++) {
        sn_scene scene;
        sn_error error = {0};
        sn_blob blob = blob_of("t.scene.json", scene_text);
        blob.data[length] = '\0';
        blob.size = length;
        assert_int_not_equal(sn_scene_parse(&blob, false, &scene, &error), SN_OK);
        assert_true(error.text[0] != '\0');
        sn_blob_free(&blob);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_scene_has_every_default),
        cmocka_unit_test(lengths_angles_and_times_are_si),
        cmocka_unit_test(muscles_are_read),
        cmocka_unit_test(a_motion_document_has_its_own_unit_and_rate),
        cmocka_unit_test(reading_what_was_written_is_the_same_scene),
        cmocka_unit_test(units_do_not_make_numbers_drift),
        cmocka_unit_test(every_mistake_is_named),
        cmocka_unit_test(errors_name_the_file_that_is_wrong),
        cmocka_unit_test_setup(mistyped_members_are_warned_of, forget_log),
        cmocka_unit_test(truncation_is_an_error),
    };
    return cmocka_run_group_tests_name("scene", tests, write_files, remove_folder);
}
