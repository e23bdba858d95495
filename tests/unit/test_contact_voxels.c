/* test_contact_voxels.c -- the collision of [K21] 3.2 in a step: walk back, follow, stop, ignore; and what a run with it keeps. */
#include "sim_inside.h"

#include "../../lib/sim/contact.h"

static const double HALF = 0.02; /* of the bone, a cube beside the muscle */

/* The muscle along z, and a cube at x = `away` beside its middle, which joint 1 carries to x = `goal` in half a second. */
static void make_collision(sn_scene *scene, double away, double goal) {
    make_scene(scene, &FUSIFORM);
    scene->bones[0].passable = scene->bones[1].passable = true;
    scene->bones = sn_realloc(scene->bones, 3, sizeof *scene->bones);
    scene->bones[2] = (sn_scene_bone){.name = sn_strdup("cube"), .uri = sn_strdup("cube.stl"), .meters_per_unit = 0.5, .joint = 1};
    give_bone_cube(&scene->bones[2], sn_v3(away, 0, 0.1), HALF);
    scene->bone_count = 3;
    scene->motion.joints = sn_realloc(scene->motion.joints, 2, sizeof *scene->motion.joints);
    scene->motion.joint_count = 2;
    sn_pose_key *keys = SN_NEW(sn_pose_key, 2);
    keys[0] = (sn_pose_key){0.0, sn_rigid_identity()};
    keys[1] = (sn_pose_key){0.5, {sn_quat_axis_angle(sn_v3(0, 0, 1), 0.3), sn_v3(goal - away, 0, 0)}};
    scene->motion.joints[1] =
        (sn_joint){.name = sn_strdup("slide"), .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 2, .keys = keys};
    scene->solver.scheme = SN_SCHEME_KOHOUT;
    scene->solver.substeps = 1;
    scene->solver.iterations = 3;
    scene->last_frame = 12;
    scene->contact.enabled = true;
    scene->contact.voxels = 8;
}

/* The first vertex that no bone carries. */
static sn_index free_vertex(const simulation *s) {
    sn_index v = 0;
    while (s->model->muscles[0].inverse_mass[v] == 0.0) v++;
    return v;
}

static void put_vertex(const simulation *s, sn_index v, sn_vec3 before, sn_vec3 now) {
    sn_muscle_state *m = &s->state->muscles[0];
    m->previous[v] = before;
    m->points[v].x = now.x, m->points[v].y = now.y, m->points[v].z = now.z;
}

static void assert_at(const simulation *s, sn_index v, sn_vec3 at, double within) {
    double off = sn_distance(position(s, v), at);
    if (!(off <= within)) fail_msg("vertex %d is off by %g", (int)v, off);
}

/* ---- the two rules ------------------------------------------------------------------------------------------------------------------- */

/* The cube's 8 cells along x are 5 mm wide; its left face is at x = 0.05. */
static void test_walk_back(void **state) {
    sn_scene scene;
    make_collision(&scene, 0.07, 0.07);
    simulation s = start(&scene);
    sn_index v = free_vertex(&s);
    (void)state;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) s.state->muscles[0].previous[i] = position(&s, i);
    put_vertex(&s, v, sn_v3(0.02, 0.001, 0.1), sn_v3(0.08, 0.001, 0.1));
    sn_project(s.model, s.state, 0, SN_ROWS_CONTACT);
    assert_at(&s, v, sn_v3(0.05 - 5e-6, 0.001, 0.1), 1e-12);
    put_vertex(&s, v, sn_v3(0.048, 0.001, 0.1), sn_v3(0.08, 0.001, 0.1)); /* from the cell beside the cube: all the way */
    sn_project(s.model, s.state, 0, SN_ROWS_CONTACT);
    assert_at(&s, v, sn_v3(0.048, 0.001, 0.1), 0.0);
    put_vertex(&s, v, sn_v3(0.02, 0.001, 0.1), sn_v3(0.049, 0.001, 0.1)); /* it is outside: nothing */
    sn_project(s.model, s.state, 0, SN_ROWS_CONTACT);
    assert_at(&s, v, sn_v3(0.049, 0.001, 0.1), 0.0);
    put_vertex(&s, v, sn_v3(0.02, 0.001, 0.1), sn_v3(0.17, 0.001, 0.1)); /* beyond the cube: nothing, as in the paper */
    sn_project(s.model, s.state, 0, SN_ROWS_CONTACT);
    assert_at(&s, v, sn_v3(0.17, 0.001, 0.1), 0.0);
    finish(&s);
}

/* The cube has turned and come by 30 mm, onto the vertex: that goes as the cube has gone. */
static void test_follow_and_ignore(void **state) {
    (void)state;
    for (int hits = SN_BONE_HITS_FOLLOW; hits <= SN_BONE_HITS_IGNORE; hits++) {
        sn_scene scene;
        make_collision(&scene, 0.07, 0.07);
        scene.contact.bone_hits = (sn_bone_hits)hits;
        simulation s = start(&scene);
        sn_index v = free_vertex(&s);
        const sn_rigid from = {sn_quat_axis_angle(sn_v3(0, 1, 0), 0.2), {0.01, 0, 0}},
                       to = {sn_quat_axis_angle(sn_v3(0, 0, 1), 0.3), {-0.03, 0, 0}};
        for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) s.state->muscles[0].previous[i] = position(&s, i);
        inputs_of(&s)->collider_placed[0] = from;
        inputs_of(&s)->collider_poses[0] = to;
        sn_vec3 before = sn_rigid_apply(to, sn_v3(0.06, 0.002, 0.105)), now = sn_rigid_apply(to, sn_v3(0.071, -0.003, 0.1));
        put_vertex(&s, v, before, now);
        sn_project(s.model, s.state, 0, SN_ROWS_CONTACT);
        sn_vec3 carried = sn_rigid_apply(to, sn_rigid_apply(sn_rigid_inverse(from), before));
        assert_at(&s, v, hits == SN_BONE_HITS_IGNORE ? now : carried, 1e-12);
        finish(&s);
    }
}

/* Where a vertex is, in the frame of the cube now. */
static bool in_cube(const simulation *s, sn_vec3 p) {
    sn_rigid back = sn_rigid_inverse(inputs_of(s)->collider_poses[0]);
    return sn_voxels_at(sn_model_voxels(s->model, 2), sn_rigid_apply(back, p));
}

static sn_vec3 *copy_points(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_vec3 *points = SN_NEW(sn_vec3, m->point_count);
    for (sn_index i = 0; i < m->point_count; i++) points[i] = position(s, i);
    return points;
}

/* A cube pushed into the muscle. What it moves onto goes as it does, out of its way; no other vertex is in it after a step. Stopped ones
 * have no velocity then. Ignored ones stay in it. */
static void push(sn_bone_hits hits) {
    sn_scene scene;
    sn_index carried = 0, inside = 0;
    make_collision(&scene, 0.055, 0.03);
    scene.contact.bone_hits = hits;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index frame = 0; frame < 12; frame++) {
        sn_vec3 *before = copy_points(&s);
        sn_rigid placed = inputs_of(&s)->collider_placed[0];
        step_frames(&s, 1, NULL);
        sn_rigid motion = sn_rigid_compose(inputs_of(&s)->collider_poses[0], sn_rigid_inverse(placed));
        for (sn_index v = 0; v < m->vertex_count; v++) {
            if (m->inverse_mass[v] == 0.0) continue;
            inside += in_cube(&s, position(&s, v));
            if (!in_cube(&s, before[v]) || sn_distance(position(&s, v), sn_rigid_apply(motion, before[v])) > 1e-15) continue;
            carried++;
            double speed = sn_norm(s.state->muscles[0].velocities[v]), way = sn_distance(position(&s, v), before[v]);
            assert_true(way > 1e-3);
            assert_true(fabs(speed - (hits == SN_BONE_HITS_STOP ? 0.0 : way * scene.rate)) < 1e-9);
        }
        free(before);
    }
    assert_true(s.state->muscles[0].statistics.contacts > 0);
    if (hits == SN_BONE_HITS_IGNORE)
        assert_true(carried == 0 && inside > 50);
    else
        assert_true(carried > 50 && inside == 0);
    finish(&s);
}

static void test_a_bone_that_comes(void **state) {
    (void)state;
    push(SN_BONE_HITS_FOLLOW);
    push(SN_BONE_HITS_STOP);
    push(SN_BONE_HITS_IGNORE);
}

/* A cube in the muscle at rest that leaves: what lies in its voxels stays in the same place of them, as long as it is in them. */
static void test_overlap_at_rest_goes_along(void **state) {
    sn_scene scene;
    sn_index carried = 0;
    (void)state;
    make_collision(&scene, 0.04, 0.05);
    simulation s = start(&scene);
    for (sn_index frame = 0; frame < 12; frame++) {
        sn_vec3 *before = copy_points(&s);
        sn_rigid placed = inputs_of(&s)->collider_placed[0];
        step_frames(&s, 1, NULL);
        sn_rigid motion = sn_rigid_compose(inputs_of(&s)->collider_poses[0], sn_rigid_inverse(placed));
        for (sn_index v = 0; v < s.model->muscles[0].vertex_count; v++) {
            if (s.model->muscles[0].inverse_mass[v] == 0.0 || !in_cube(&s, position(&s, v))) continue;
            carried++;
            assert_at(&s, v, sn_rigid_apply(motion, before[v]), 1e-12);
        }
        free(before);
    }
    assert_true(carried > 12 * 5);
    finish(&s);
}

/* ---- what is asked about, and told ------------------------------------------------------------------------------------------------- */

/* Every vertex that no bone carries, about every bone that comes near; the statistics tell how deep, as the true surface has it. */
static void test_rows_and_statistics(void **state) {
    sn_scene scene;
    make_collision(&scene, 0.055, 0.03);
    scene.contact.bone_hits = SN_BONE_HITS_IGNORE;
    scene.contact.cell = 5e-4;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_index free_points = 0;
    double deepest = 0.0;
    (void)state;
    for (sn_index v = 0; v < m->vertex_count; v++) free_points += m->inverse_mass[v] > 0.0;
    assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_CONTACT), free_points);
    step_frames(&s, 12, NULL);
    sn_rigid back = sn_rigid_inverse(inputs_of(&s)->collider_poses[0]);
    for (sn_index v = 0; v < m->vertex_count; v++) {
        sn_vec3 p = sn_sub(sn_rigid_apply(back, position(&s, v)), sn_v3(0.055, 0, 0.1));
        if (m->inverse_mass[v] > 0.0) deepest = fmax(deepest, HALF - fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
    }
    const sn_statistics *st = &s.state->muscles[0].statistics;
    assert_true(deepest > 1e-3);
    assert_true(fabs(st->penetration - deepest) < 1.5e-4);
    assert_int_equal(st->penetration_bone, 2);
    finish(&s);
}

/* Off is absent: no voxels, no rows, and without a bone near neither. */
static void test_absent(void **state) {
    sn_scene scene;
    (void)state;
    make_collision(&scene, 0.055, 0.03);
    scene.contact.enabled = false;
    simulation s = start(&scene);
    assert_null(sn_model_voxels(s.model, 2));
    assert_int_equal(sn_row_count(s.model, 0, SN_ROWS_CONTACT), 0);
    finish(&s);
    make_collision(&scene, 1.0, 1.1);
    s = start(&scene);
    assert_null(sn_model_voxels(s.model, 2));
    assert_int_equal(s.model->plan.muscles[0].groups[SN_ROWS_CONTACT].reason, SN_OUT_NO_BONE);
    finish(&s);
    make_collision(&scene, 0.055, 0.03);
    scene.contact.collision = SN_COLLISION_FIELD;
    s = start(&scene);
    assert_null(sn_model_voxels(s.model, 2));
    assert_non_null(sn_model_field(s.model, 2));
    finish(&s);
}

static void test_sizes(void **state) {
    sn_scene scene;
    (void)state;
    make_collision(&scene, 0.055, 0.03);
    scene.contact.voxels = 0;
    simulation s = start(&scene);
    assert_int_equal(sn_voxels_count(sn_model_voxels(s.model, 2)), 64 * 64 * 64);
    finish(&s);
    make_collision(&scene, 0.055, 0.03);
    scene.contact.voxels = 0, scene.contact.voxels_total = 1001;
    s = start(&scene);
    assert_int_equal(sn_voxels_count(sn_model_voxels(s.model, 2)), 1000);
    finish(&s);
}

static void assert_refused(const sn_scene *scene, const char *word) {
    sn_error error = {0};
    assert_int_equal(sn_scene_validate(scene, &error), SN_ERROR_INPUT);
    if (strstr(error.text, word) == NULL) fail_msg("\"%s\" does not speak of %s", error.text, word);
}

static void test_refusals(void **state) {
    sn_scene scene;
    (void)state;
    make_collision(&scene, 0.055, 0.03);
    assert_int_equal(sn_scene_validate(&scene, NULL), SN_OK);
    scene.contact.voxels = 513;
    assert_refused(&scene, "512");
    scene.contact.voxels = 8, scene.contact.voxels_total = 8;
    assert_refused(&scene, "exclude");
    scene.contact.voxels = 0, scene.contact.voxels_total = -1;
    assert_refused(&scene, "voxelsTotal");
    scene.contact.voxels_total = 0;
    scene.contact.collision = SN_COLLISION_VOXEL;
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    assert_refused(&scene, "xpbd");
    scene.contact.enabled = false;
    assert_int_equal(sn_scene_validate(&scene, NULL), SN_OK);
    sn_scene_free(&scene);
}

/* ---- the same bits ------------------------------------------------------------------------------------------------------------------- */

/* After 12 frames; with `stops` each is left in its middle, goes away to bytes and comes back. */
static void run_to_the_end(sn_precision precision, sn_bone_hits hits, bool stops, sn_vec3 *out) {
    sn_scene scene;
    make_collision(&scene, 0.055, 0.03);
    scene.solver.substeps = 3;
    scene.solver.precision = precision;
    scene.contact.bone_hits = hits;
    simulation s = start(&scene);
    for (sn_index frame = 0; frame < 12; frame++) {
        sn_step_options options = {.stop_substep = 1 + frame % 3, .stop_iteration = 1 + frame % 2};
        char *bytes;
        size_t size;
        if (stops) {
            assert_int_equal(sn_step(s.model, s.state, &options, NULL), SN_STOPPED);
            assert_int_equal(sn_state_pack(s.model, s.state, &bytes, &size, NULL), SN_OK);
            sn_state_destroy(s.model, s.state);
            assert_int_equal(sn_state_create(s.model, &s.state, NULL), SN_OK);
            assert_int_equal(sn_state_unpack(s.model, bytes, size, s.state, NULL), SN_OK);
            free(bytes);
        }
        step_frames(&s, 1, NULL);
    }
    sn_state_positions(s.model, s.state, 0, out);
    finish(&s);
}

static void test_stopped_and_continued(void **state) {
    enum { VERTICES = 24 * 16 + 2 };
    static sn_vec3 whole[VERTICES], pieces[VERTICES], other[VERTICES];
    (void)state;
    for (int precision = SN_PRECISION_DOUBLE; precision <= SN_PRECISION_SINGLE; precision++)
        for (int hits = SN_BONE_HITS_FOLLOW; hits <= SN_BONE_HITS_IGNORE; hits++) {
            run_to_the_end((sn_precision)precision, (sn_bone_hits)hits, false, whole);
            run_to_the_end((sn_precision)precision, (sn_bone_hits)hits, true, pieces);
            assert_memory_equal(whole, pieces, sizeof whole);
            if (hits > SN_BONE_HITS_FOLLOW) assert_memory_not_equal(whole, other, sizeof whole);
            memcpy(other, whole, sizeof whole);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_walk_back),
        cmocka_unit_test(test_follow_and_ignore),
        cmocka_unit_test(test_a_bone_that_comes),
        cmocka_unit_test(test_overlap_at_rest_goes_along),
        cmocka_unit_test(test_rows_and_statistics),
        cmocka_unit_test(test_absent),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_stopped_and_continued),
    };
    return cmocka_run_group_tests_name("contact_voxels", tests, NULL, NULL);
}
