/* test_scene_surface.c -- muscles on surfaces: what follows an envelope or a driven mesh, how they are found, stepped, stopped and woken.
 */
#include "sim_scene.h"

static const double TURN = -40.0 * SN_PI / 180.0;

/* An envelope over a scene's bones: the fusiform's own shape, a third wider; the lower half on "lower", the upper on "upper", between
 * them on both. */
static void add_envelope(sn_scene *scene, const char *name, double blended) {
    fusiform wide = FUSIFORM;
    wide.radius *= 4.0 / 3.0;
    scene->surfaces = SN_NEW(sn_scene_surface, 1);
    scene->surface_count = 1;
    sn_scene_surface *s = scene->surfaces;
    *s = (sn_scene_surface){.name = sn_strdup(name), .uri = sn_strdup("memory"), .loaded = true};
    make_surface(&wide, &s->envelope.mesh);
    s->envelope.bone_count = 2;
    s->envelope.bones = SN_NEW(char *, 2);
    s->envelope.bones[0] = sn_strdup("upper"), s->envelope.bones[1] = sn_strdup("lower");
    s->joints = SN_NEW(sn_index, 2);
    s->joints[0] = SN_NONE, s->joints[1] = 0;
    s->envelope.influences = SN_NEW(sn_influence, s->envelope.mesh.vertex_count);
    for (sn_index v = 0; v < s->envelope.mesh.vertex_count; v++) {
        double z = s->envelope.mesh.positions[v].z / wide.length;
        bool both = fabs(z - 0.5) < blended;
        s->envelope.influences[v] = (sn_influence){.count = both ? 2 : 1, .bones = {z < 0.5, z >= 0.5}, .weights = {both ? 0.5 : 1.0, 0.5}};
    }
}

static void rename_attachment(sn_scene *scene, sn_index attachment, const char *name) {
    sn_attachment *a = &scene->muscles[0].rig.attachments[attachment];
    free(a->bone);
    a->bone = sn_strdup(name);
}

/* Attach the middle of the muscle to the envelope, too. */
static void attach_middle(sn_scene *scene, const char *name) {
    sn_muscle *rig = &scene->muscles[0].rig;
    rig->attachments = sn_realloc(rig->attachments, 3, sizeof *rig->attachments);
    sn_attachment *a = &rig->attachments[rig->attachment_count++];
    *a = (sn_attachment){.bone = sn_strdup(name), .method = sn_strdup("pin"), .vertices = SN_NEW(sn_index, rig->mesh.vertex_count)};
    for (sn_index v = 0; v < rig->mesh.vertex_count; v++)
        if (fabs(rig->mesh.positions[v].z / FUSIFORM.length - 0.5) < 0.1) a->vertices[a->count++] = v;
    assert_true(a->count > 20);
}

/* ---- followers -------------------------------------------------------------------------------------------------------------------- */

static void what_is_on_one_bone_follows_it_rigidly(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    add_envelope(&scene, "skin", 0.1);
    const sn_vec3 points[] = {{0.01, 0.02, 0.03}, {0.1, 0.0, 0.18}, {0.0, 0.0, 0.05}, {-0.02, 0.01, 0.19}};
    sn_follower followers[4];
    double farthest;
    assert_int_equal(sn_followers_bind(&scene.surfaces[0], 4, points, followers, &farthest, NULL), SN_OK);
    assert_true(farthest > 0.05 && farthest < 0.1);
    const sn_rigid poses[] = {{sn_quat_axis_angle(sn_normalize(sn_v3(1, 2, 3)), 1.1), {0.3, -0.2, 0.1}}};
    const sn_surface_moment at = {poses, 0.0, 1.0};
    for (int i = 0; i < 4; i++) {
        sn_rigid pose = points[i].z < 0.1 ? poses[0] : sn_rigid_identity();
        assert_true(sn_distance(sn_follower_place(&scene.surfaces[0], &at, &followers[i]), sn_rigid_apply(pose, points[i])) < 1e-14);
        sn_rigid told = sn_follower_pose(&scene.surfaces[0], &at, &followers[i]);
        assert_true(sn_distance(sn_rigid_apply(told, points[i]), sn_rigid_apply(pose, points[i])) < 1e-14);
    }
    sn_scene_free(&scene);
}

/* A square that a host stretches along x by 3, turns about z by 90 degrees and lifts, in one second. */
static void make_square(sn_scene_surface *s, bool collapse) {
    static const double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    *s = (sn_scene_surface){.name = sn_strdup("square"), .kind = SN_SURFACE_DRIVEN, .loaded = true};
    assert_int_equal(sn_mesh_alloc(&s->envelope.mesh, 4, 2, NULL), SN_OK);
    s->envelope.mesh.triangles[0] = (sn_triangle){{0, 1, 2}}, s->envelope.mesh.triangles[1] = (sn_triangle){{0, 2, 3}};
    s->track = (sn_vertex_track){2, 4, SN_NEW(double, 2), SN_NEW(float, 24)};
    s->track.times[1] = 1.0;
    for (int v = 0; v < 4; v++) {
        const double *c = corners[v];
        s->envelope.mesh.positions[v] = sn_v3(c[0], c[1], c[2]);
        const double moved[3] = {collapse ? 0.0 : -c[1], 3.0 * c[0], 5.0};
        for (int i = 0; i < 3; i++) s->track.positions[3 * v + i] = (float)c[i], s->track.positions[12 + 3 * v + i] = (float)moved[i];
    }
}

static void what_follows_a_driven_mesh_keeps_its_distance(void **state) {
    (void)state;
    sn_scene_surface s;
    sn_follower f;
    const sn_vec3 point = {0.75, 0.25, 0.125};
    make_square(&s, false);
    assert_int_equal(sn_followers_bind(&s, 1, &point, &f, NULL, NULL), SN_OK);
    sn_surface_moment at = {NULL, 1.0, 1.0};
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), sn_v3(-0.25, 2.25, 5.125)) < 1e-12); /* stretched along, as far above */
    at.time = 0.0;
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), point) < 1e-15);
    at.time = -7.0;
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), point) < 1e-15);
    at.time = 9.0;
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), sn_v3(-0.25, 2.25, 5.125)) < 1e-12);
    at = (sn_surface_moment){NULL, 1.0, 0.0}; /* a run-in that has not begun: at rest, whatever the time */
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), point) < 1e-15);
    at.share = 0.5; /* corners half way: (0, 0, 2.5), (0.5, 1.5, 2.5), (0, 2, 2.5) */
    sn_vec3 half = sn_follower_place(&s, &at, &f);
    assert_true(fabs(half.z - 2.625) < 1e-12);
    sn_scene_surface_free(&s);
}

static void a_triangle_without_area_leaves_its_frame(void **state) {
    (void)state;
    sn_scene_surface s;
    sn_follower f;
    const sn_vec3 point = {0.75, 0.25, 0.125};
    make_square(&s, true);
    assert_int_equal(sn_followers_bind(&s, 1, &point, &f, NULL, NULL), SN_OK);
    const sn_surface_moment at = {NULL, 1.0, 1.0};
    assert_true(sn_distance(sn_follower_place(&s, &at, &f), sn_v3(0.0, 2.25, 5.125)) < 1e-12);
    for (int i = 0; i < 4; i++) s.envelope.mesh.positions[i] = sn_v3(1, 1, 1);
    sn_error error = {0};
    assert_int_equal(sn_followers_bind(&s, 1, &point, &f, NULL, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "\"square\""));
    sn_scene_surface_free(&s);
}

/* ---- names ------------------------------------------------------------------------------------------------------------------------- */

static void a_name_is_sought_among_bones_then_surfaces_then_joints(void **state) {
    (void)state;
    sn_scene scene;
    sn_error error = {0};
    make_scene(&scene, &FUSIFORM);
    add_envelope(&scene, "hinge", 0.0); /* the joint's name */
    assert_int_equal(sn_scene_carrier(&scene, "lower").kind, SN_CARRIER_BONE);
    assert_int_equal(sn_scene_carrier(&scene, "lower").index, 1);
    assert_int_equal(sn_scene_carrier(&scene, "hinge").kind, SN_CARRIER_SURFACE);
    free(scene.surfaces[0].name);
    scene.surfaces[0].name = sn_strdup("skin");
    assert_int_equal(sn_scene_carrier(&scene, "hinge").kind, SN_CARRIER_JOINT);
    assert_int_equal(sn_scene_carrier(&scene, "nothing").kind, SN_CARRIER_NONE);
    assert_int_equal(sn_scene_carrier(&scene, NULL).kind, SN_CARRIER_NONE);
    assert_int_equal(sn_scene_validate(&scene, &error), SN_OK);
    free(scene.surfaces[0].name);
    scene.surfaces[0].name = sn_strdup("upper");
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "\"upper\""));
    sn_scene_free(&scene);
}

static void an_unloaded_surface_holds_nobody(void **state) {
    (void)state;
    sn_scene scene;
    sn_error error = {0};
    make_scene(&scene, &FUSIFORM);
    add_envelope(&scene, "skin", 0.0);
    scene.surfaces[0].loaded = false;
    assert_int_equal(sn_scene_validate(&scene, &error), SN_OK);
    assert_false(sn_scene_surface_carries(&scene, 0));
    rename_attachment(&scene, 1, "skin");
    assert_true(sn_scene_surface_carries(&scene, 0));
    assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
    scene.muscles[0].enabled = false;
    assert_false(sn_scene_surface_carries(&scene, 0));
    assert_int_equal(sn_scene_validate(&scene, &error), SN_OK);
    sn_scene_free(&scene);
}

/* ---- in a run ----------------------------------------------------------------------------------------------------------------------- */

static void bend(sn_scene *scene, sn_solver_method method) {
    sn_solver_change(&scene->solver, method);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, TURN);
}

static double greatest_difference(const simulation *a, const simulation *b) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++) most = fmax(most, sn_distance(position(a, i), position(b, i)));
    return most;
}

/* On a joint by its name, and on an envelope all on one bone, a muscle does as on the bone. */
static void joint_and_rigid_envelope_are_the_bone(void **state) {
    (void)state;
    for (int method = 0; method < 2; method++) {
        sn_scene scenes[3];
        simulation runs[3];
        for (int i = 0; i < 3; i++) {
            make_scene(&scenes[i], &FUSIFORM);
            bend(&scenes[i], method ? SN_SOLVER_QN : SN_SOLVER_XPBD);
            if (i == 2) add_envelope(&scenes[i], "skin", 0.0);
            if (i > 0) rename_attachment(&scenes[i], 1, i == 1 ? "hinge" : "skin");
            runs[i] = start(&scenes[i]);
            step_frames(&runs[i], 14, NULL);
        }
        assert_true(greatest_move(&runs[0]) > 0.005);
        assert_true(greatest_difference(&runs[0], &runs[1]) == 0.0);
        assert_true(greatest_difference(&runs[0], &runs[2]) < 1e-9);
        for (int i = 0; i < 3; i++) finish(&runs[i]);
    }
}

/* Points between two bones are where the surface takes them at every frame's end, whether steps are halved or not. */
static void followers_are_where_the_surface_is(void **state) {
    (void)state;
    for (int method = 0; method < 3; method++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        bend(&scene, method ? SN_SOLVER_QN : SN_SOLVER_XPBD);
        if (method == 2) set_keys(&scene.motion.joints[0].angle, 0.2, 0.0, 0.24, 3.0 * TURN); /* a jump: steps are halved */
        add_envelope(&scene, "skin", 0.2);
        attach_middle(&scene, "skin");
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        const sn_site *site = &m->sites[2];
        assert_int_equal(site->surface, 0);
        int64_t halvings = 0;
        for (int frame = 1; frame <= 10; frame++) {
            step_frames(&s, 1, NULL);
            halvings += s.state->muscles[0].statistics.halvings;
            sn_rigid poses[1];
            sn_motion_poses(&scene.motion, frame / scene.rate, poses);
            const sn_surface_moment at = {poses, frame / scene.rate, 1.0};
            for (sn_index k = site->begin; k < site->end; k++) {
                sn_vec3 want = sn_follower_place(&scene.surfaces[0], &at, &m->followers[site->first_follower + k - site->begin]);
                assert_true(sn_distance(position(&s, m->kinematic_points[k]), want) < 1e-12);
            }
        }
        assert_int_equal(s.state->muscles[0].statistics.nan_points, 0);
        assert_true(method < 2 || halvings > 0);
        finish(&s);
    }
}

static void stopped_and_continued_gives_the_same_bits(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    for (int i = 0; i < 2; i++) {
        make_scene(&scenes[i], &FUSIFORM);
        bend(&scenes[i], SN_SOLVER_QN);
        add_envelope(&scenes[i], "skin", 0.2);
        attach_middle(&scenes[i], "skin");
        runs[i] = start(&scenes[i]);
    }
    step_frames(&runs[0], 6, NULL);
    step_frames(&runs[1], 2, NULL);
    const sn_step_options inside = {.stop_substep = 1, .stop_iteration = 3};
    assert_int_equal(sn_step(runs[1].model, runs[1].state, &inside, NULL), SN_STOPPED);
    char *bytes;
    size_t size;
    assert_int_equal(sn_state_pack(runs[1].model, runs[1].state, &bytes, &size, NULL), SN_OK);
    sn_state_destroy(runs[1].model, runs[1].state);
    assert_int_equal(sn_state_create(runs[1].model, &runs[1].state, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(runs[1].model, bytes, size, runs[1].state, NULL), SN_OK);
    free(bytes);
    step_frames(&runs[1], 4, NULL);
    assert_int_equal(runs[1].state->frame, 6);
    assert_true(greatest_difference(&runs[0], &runs[1]) == 0.0);
    for (int i = 0; i < 2; i++) finish(&runs[i]);
}

/* A muscle that sleeps on a driven mesh wakes when that moves, and only then; one pinned corner of it is enough. */
static void a_moving_surface_wakes_a_muscle(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    sn_solver_change(&scene.solver, SN_SOLVER_QN);
    add_envelope(&scene, "skin", 0.0);
    sn_scene_surface *s = &scene.surfaces[0];
    sn_index n = s->envelope.mesh.vertex_count;
    s->kind = SN_SURFACE_DRIVEN;
    s->track = (sn_vertex_track){3, n, SN_NEW(double, 3), SN_NEW(float, 9 * (size_t)n)};
    s->track.times[1] = 200.0 / 24.0, s->track.times[2] = 210.0 / 24.0;
    for (sn_index k = 0; k < 3 * n; k++) {
        sn_vec3 p = s->envelope.mesh.positions[k % n];
        float *to = s->track.positions + 3 * k;
        to[0] = (float)(p.x + (k >= 2 * n ? 0.01 : 0.0)), to[1] = (float)p.y, to[2] = (float)p.z;
    }
    rename_attachment(&scene, 1, "skin");
    simulation run = start(&scene);
    step_frames(&run, 199, NULL);
    assert_true(run.state->muscles[0].statistics.asleep);
    step_frames(&run, 2, NULL);
    assert_false(run.state->muscles[0].statistics.asleep);
    step_frames(&run, 9, NULL);
    assert_true(greatest_move(&run) > 0.0099);
    finish(&run);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_on_one_bone_follows_it_rigidly),
        cmocka_unit_test(what_follows_a_driven_mesh_keeps_its_distance),
        cmocka_unit_test(a_triangle_without_area_leaves_its_frame),
        cmocka_unit_test(a_name_is_sought_among_bones_then_surfaces_then_joints),
        cmocka_unit_test(an_unloaded_surface_holds_nobody),
        cmocka_unit_test(joint_and_rigid_envelope_are_the_bone),
        cmocka_unit_test(followers_are_where_the_surface_is),
        cmocka_unit_test(stopped_and_continued_gives_the_same_bits),
        cmocka_unit_test(a_moving_surface_wakes_a_muscle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
