/* test_view_motion.c -- motion documents: read as they stand, and drawn: joints where their poses take them, bones with them, the floor. */
#include "shapes.h"

#include "sinew/io.h"
#include "sinew/view.h"

#include <string.h>

/* A thigh that swings about y at the hip (0,0,1), a shin that hangs on it by a pose joint, an ankle without a place, a toe. */
static const char DOCUMENT[] =
    "{\"format\": \"sinew-motion\", \"version\": 1, \"name\": \"leg\", \"metersPerUnit\": 0.01, \"rate\": 10, \"joints\": ["
    "{\"name\": \"lhip\", \"type\": \"hinge\", \"axis\": [0,1,0], \"point\": [0,0,100], \"keys\": [[0,0],[1,-90]]},"
    "{\"name\": \"rhip\", \"type\": \"hinge\", \"axis\": [0,1,0], \"point\": [0,-20,100], \"degrees\": 0},"
    "{\"name\": \"shin\", \"parent\": \"lhip\", \"type\": \"pose\", \"rest\": [0,0,50], \"end\": [0,0,10], \"keys\": [{\"frame\": 0},"
    " {\"frame\": 10, \"rotation\": [0.6,0,0.8,0], \"translation\": [-48,0,64]}]},"
    "{\"name\": \"ankle\", \"parent\": \"shin\", \"type\": \"pose\", \"keys\": [{\"frame\": 0}]},"
    "{\"name\": \"toe_R\", \"parent\": \"ankle\", \"type\": \"pose\", \"rest\": [10,0,0], \"keys\": [{\"frame\": 0}]}],"
    "\"coordinates\": [{\"name\": \"swing\", \"unit\": \"rad\", \"values\": [0,1]}],"
    "\"bones\": [{\"name\": \"tibia\", \"mesh\": \"tibia.ply\", \"units\": \"cm\", \"joint\": \"shin\"},"
    "{\"name\": \"table\", \"mesh\": \"/table.ply\"}]}";

static sn_motion leg(double *rate) {
    char *name, path[] = "there/leg.motion.json";
    sn_motion motion;
    const sn_blob blob = {.data = (char *)(uintptr_t)DOCUMENT, .size = strlen(DOCUMENT), .name = path};
    assert_true(sn_motion_document_detect(&blob));
    assert_ok(sn_motion_document_parse(&blob, &motion, &name, rate, NULL));
    assert_string_equal(name, "leg");
    free(name);
    return motion;
}

static void test_a_document_is_read_as_it_stands(void **state) {
    (void)state;
    double rate;
    sn_motion motion = leg(&rate);
    assert_near(rate, 10.0, 0.0);
    assert_int_equal(motion.joint_count, 5);
    assert_int_equal(motion.joints[0].kind, SN_JOINT_HINGE); /* not sampled */
    assert_int_equal(motion.joints[0].angle.count, 2);
    assert_near(motion.joints[0].point.z, 1.0, 1e-15);
    assert_int_equal(motion.coordinate_count, 1);
    assert_int_equal(motion.bone_count, 2);
    assert_string_equal(motion.bones[0].path, "there/tibia.ply");
    assert_string_equal(motion.bones[1].path, "/table.ply");
    assert_int_equal(motion.bones[0].joint, 2);
    assert_int_equal(motion.bones[1].joint, SN_NONE);
    sn_motion_free(&motion);
}

static void test_a_broken_document_is_told(void **state) {
    (void)state;
    char text[] = "{\"format\": \"sinew-motion\", \"version\": 1,\n \"joints\": [{\"name\": \"a\", \"type\": \"pose\", \"keys\": []}]}",
         path[] = "a.json", *name;
    const sn_blob blob = {.data = text, .size = strlen(text), .name = path};
    sn_motion motion;
    sn_error error = {0};
    double rate;
    assert_int_equal(sn_motion_document_parse(&blob, &motion, &name, &rate, &error), SN_ERROR_INPUT);
    assert_string_equal(error.file, "a.json");
    assert_int_equal(error.line, 2);
    assert_null(name);
    assert_null(motion.joints);
}

static void test_a_missing_surface_names_its_bone(void **state) {
    (void)state;
    char name[] = "tibia", path[] = "no/such.ply";
    const sn_motion_bone bone = {name, path, 0.0, SN_NONE};
    sn_mesh mesh;
    sn_mesh_frame frame;
    sn_error error = {0};
    assert_int_not_equal(sn_motion_bone_load(&bone, 1.0, &mesh, &frame, &error), SN_OK);
    assert_non_null(strstr(error.text, "tibia"));
    assert_string_equal(error.file, path);
}

static bool is_at(sn_vec3 p, double x, double y, double z) { return sn_distance(p, sn_v3(x, y, z)) < 1e-12; }

static bool has_tube(const sn_view *view, sn_vec3 a, sn_vec3 b) {
    for (size_t i = 0; i < view->tube_count; i++)
        if (sn_distance(view->tubes[i].a, a) < 1e-12 && sn_distance(view->tubes[i].b, b) < 1e-12) return true;
    return false;
}

/* By hand: at 1 s the hip has turned (0,0,-1) to (1,0,0); the knee is at (0.5,0,1). There the shin turns by the angle whose half has the
 * cosine 0.6, so that its sine is 0.96 and its cosine -0.28, about the knee: rest -> knee is unmoved by the key. */
static void test_sticks_are_where_poses_take_them(void **state) {
    (void)state;
    double rate;
    sn_motion motion = leg(&rate);
    sn_view rest = {0}, view = {0};
    assert_ok(sn_view_add_motion(&rest, &motion, NULL, 0.0, SN_SHOW_JOINTS, NULL));
    assert_true(has_tube(&rest, sn_v3(0, 0, 1), sn_v3(0, 0, 0.5)));
    assert_true(has_tube(&rest, sn_v3(0, 0, 0.5), sn_v3(0, 0, 0.1)));
    assert_true(has_tube(&rest, sn_v3(0, 0, 0.5), sn_v3(0.1, 0, 0))); /* the toe hangs on the shin: the ankle has no place */
    assert_ok(sn_view_add_motion(&view, &motion, NULL, 1.0, SN_SHOW_AUTO, NULL));
    assert_true(has_tube(&view, sn_v3(0, 0, 1), sn_v3(0.5, 0, 1)));
    /* in the hip's frame the shin points from (0,0,-1) to (-0.96,0,0.28); the hip turns (x,z) to (-z,x) */
    assert_true(has_tube(&view, sn_v3(0.5, 0, 1), sn_v3(0.5 - 0.4 * 0.28, 0, 1 - 0.4 * 0.96)));
    assert_int_equal(view.tube_count, rest.tube_count);
    assert_int_equal(view.tube_count, 4 + 3); /* four dots, two segments, one end */
    assert_int_equal(sn_motion_placeless(&motion), 1);
    sn_view_free(&rest);
    sn_view_free(&view);
    sn_motion_free(&motion);
}

static void test_left_and_right_are_told_apart(void **state) {
    (void)state;
    double rate;
    sn_motion motion = leg(&rate);
    sn_view view = {0};
    assert_ok(sn_view_add_motion(&view, &motion, NULL, 0.0, SN_SHOW_JOINTS, NULL));
    assert_int_equal(view.entry_count, 3);
    assert_string_equal(view.entries[1].text, "left");
    assert_string_equal(view.entries[2].text, "right");
    sn_color left = view.entries[1].color, right = view.entries[2].color;
    for (size_t i = 0; i < view.tube_count; i++) {
        if (is_at(view.tubes[i].b, 0, 0, 1)) assert_near(view.tubes[i].color.b, left.b, 0.0);     /* lhip, as there is an rhip */
        if (is_at(view.tubes[i].b, 0, -0.2, 1)) assert_near(view.tubes[i].color.b, right.b, 0.0); /* rhip */
        if (is_at(view.tubes[i].b, 0.1, 0, 0)) assert_near(view.tubes[i].color.b, right.b, 0.0);  /* toe_R */
        if (is_at(view.tubes[i].b, 0, 0, 0.5)) assert_near(view.tubes[i].color.b, view.entries[0].color.b, 0.0); /* shin */
    }
    sn_view_free(&view);
    sn_motion_free(&motion);
}

static void test_bones_go_with_their_joints(void **state) {
    (void)state;
    double rate;
    sn_motion motion = leg(&rate);
    sn_mesh meshes[2] = {shape_sphere(6, 8), {0}}; /* the second was not loaded */
    sn_view view = {0}, sticks = {0};
    assert_ok(sn_view_add_motion(&view, &motion, meshes, 0.7, SN_SHOW_AUTO, NULL));
    assert_int_equal(view.mesh_count, 1);
    sn_rigid pose = sn_motion_pose(&motion, 2, 0.7);
    for (sn_index i = 0; i < meshes[0].vertex_count; i++)
        assert_true(sn_distance(view.meshes[0].positions[i], sn_rigid_apply(pose, meshes[0].positions[i])) < 1e-12);
    assert_true(view.meshes[0].opacity < 1.0 && view.tube_count > 0);
    assert_ok(sn_view_add_motion(&sticks, &motion, meshes, 0.7, SN_SHOW_JOINTS, NULL));
    assert_int_equal(sticks.mesh_count, 0);
    sn_view_free(&view);
    sn_view_free(&sticks);
    sn_mesh_free(&meshes[0]);
    sn_motion_free(&motion);
}

static void test_the_floor_is_the_lowest(void **state) {
    (void)state;
    double rate;
    sn_motion motion = leg(&rate);
    sn_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    assert_ok(sn_motion_extend(&motion, 0.0, &box, NULL));
    assert_true(is_at(box.low, 0, -0.2, 0) && is_at(box.high, 0.1, 0, 1));
    sn_view view = {0};
    assert_ok(sn_view_add_ground(&view, box, NULL));
    assert_true(view.tube_count >= 4 && view.tube_count < 60);
    sn_box ground = sn_view_box(&view);
    assert_true(ground.low.x <= 0 && ground.high.x >= 0.1 && ground.low.y <= -0.2 && ground.high.y >= 0);
    assert_near(ground.high.z - ground.low.z, 0.0, 0.0);
    assert_near(ground.low.z, 0.0, 1e-15);
    /* far away and tiny: a bounded number of lines */
    sn_view far = {0};
    assert_ok(sn_view_add_ground(&far, (sn_box){{1e17, 0, 0}, {1e17 + 64, 1e-3, 1e-3}}, NULL));
    assert_true(far.tube_count < 250);
    sn_view_free(&far);
    sn_view_free(&view);
    sn_motion_free(&motion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_document_is_read_as_it_stands),  cmocka_unit_test(test_a_broken_document_is_told),
        cmocka_unit_test(test_a_missing_surface_names_its_bone), cmocka_unit_test(test_sticks_are_where_poses_take_them),
        cmocka_unit_test(test_left_and_right_are_told_apart),    cmocka_unit_test(test_bones_go_with_their_joints),
        cmocka_unit_test(test_the_floor_is_the_lowest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
