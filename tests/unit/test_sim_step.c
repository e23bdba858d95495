/* test_sim_step.c -- whole steps: rest, momentum, invariance, bones, volume, damping, free flight, threads, what is off, stops, NaN. */
#include "sim_scene.h"

static const double TURN = -30.0 * SN_PI / 180.0;

/* The usual run: activation 0 -> 1 and the hinge to -30 degrees over a second. */
static void make_usual(sn_scene *scene, const fusiform *f) {
    make_scene(scene, f);
    scene->muscles[0].contraction = 0.3;
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, TURN);
}

static const sn_statistics *statistics(const simulation *s) { return &s->state->muscles[0].statistics; }

static void rest_stays_at_rest_under_every_law(void **state) {
    (void)state;
    for (int law = 0; law < 3; law++) {
        for (int k = 0; k < 2; k++) {
            sn_scene scene;
            make_scene(&scene, &FUSIFORM);
            scene.muscles[0].law = (sn_fiber_law)law;
            scene.muscles[0].rest_activation = scene.muscles[0].activation.constant = 0.8 * k; /* a = a0 = 0 and 0.4 */
            simulation s = start(&scene);
            step_frames(&s, 12, NULL);
            assert_true(greatest_move(&s) < 1e-9);
            assert_true(statistics(&s)->kinetic_energy < 1e-12);
            finish(&s);
        }
    }
}

static sn_vec3 momentum(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < m->point_count; i++) sum = sn_add_scaled(sum, s->state->muscles[0].velocities[i], 1.0 / m->inverse_mass[i]);
    return sum;
}

static void momentum_is_conserved_without_attachments(void **state) {
    (void)state;
    fusiform f = FUSIFORM;
    sn_scene scene;
    uint64_t random = 3;
    f.pinned = 0.0;
    make_usual(&scene, &f);
    scene.muscles[0].damping = 0.0;
    simulation s = start(&scene);
    double size = 0.0;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) {
        s.state->muscles[0].velocities[i] = sn_v3(sn_random(&random), sn_random(&random) - 0.5, 0.5);
        size += sn_norm(s.state->muscles[0].velocities[i]) / s.model->muscles[0].inverse_mass[i];
    }
    sn_vec3 before = momentum(&s);
    step_frames(&s, 5, NULL);
    assert_true(sn_distance(momentum(&s), before) < 1e-10 * size);
    finish(&s);
}

/* numerics.md 5: a scene turned and moved 1 km away gives the same to 1e-7 L. */
static void a_scene_turned_and_a_kilometre_away_gives_the_same(void **state) {
    (void)state;
    static const sn_fiber_law laws[] = {SN_LAW_PROJECTED, SN_LAW_ISOCHORIC};
    for (int k = 0; k < 2; k++) {
        sn_rigid by = {sn_quat_normalize((sn_quat){0.3, -0.5, 0.7, 0.2}), {600, -700, 400}};
        sn_scene here, there;
        make_usual(&here, &FUSIFORM);
        make_usual(&there, &FUSIFORM);
        here.muscles[0].law = there.muscles[0].law = laws[k];
        turn_and_move(&there, by);
        simulation a = start(&here), b = start(&there);
        step_frames(&a, 24, NULL);
        step_frames(&b, 24, NULL);
        double most = 0.0;
        for (sn_index i = 0; i < a.model->muscles[0].point_count; i++)
            most = fmax(most, sn_distance(sn_rigid_apply(by, position(&a, i)), position(&b, i)));
        assert_true(most < 1e-7 * a.model->muscles[0].diagonal);
        assert_true(greatest_move(&a) > 0.01); /* and something did move */
        finish(&a);
        finish(&b);
    }
}

static void attached_vertices_are_exactly_on_their_bones(void **state) {
    (void)state;
    fusiform f = FUSIFORM;
    f.meters_per_unit = 0.001;
    sn_scene scene;
    make_usual(&scene, &f);
    simulation s = start(&scene);
    const sn_muscle *rig = &scene.muscles[0].rig;
    for (int frame = 0; frame <= 24; frame++) {
        sn_rigid pose;
        sn_motion_poses(&scene.motion, s.state->frame / scene.rate, &pose);
        for (sn_index a = 0; a < rig->attachment_count; a++) {
            assert_true(rig->attachments[a].count > 10);
            for (sn_index i = 0; i < rig->attachments[a].count; i++) {
                sn_index v = rig->attachments[a].vertices[i];
                sn_vec3 rest = sn_scale(rig->mesh.positions[v], rig->meters_per_unit), p = position(&s, v);
                sn_vec3 want = strcmp(rig->attachments[a].bone, "lower") == 0 ? sn_rigid_apply(pose, rest) : rest;
                assert_true(p.x == want.x && p.y == want.y && p.z == want.z);
            }
        }
        step_frames(&s, 1, NULL);
    }
    finish(&s);
}

static void volume_stays_at_its_goal_and_reaches_a_new_one(void **state) {
    (void)state;
    static const double ratios[] = {1.0, 1.5};
    for (int k = 0; k < 2; k++) {
        sn_scene scene;
        make_usual(&scene, &FUSIFORM);
        sn_scene_muscle *m = &scene.muscles[0];
        m->volume_ratio = (sn_knots){2, SN_NEW(double, 2), SN_NEW(double, 2)};
        m->volume_ratio.x[1] = m->volume_ratio.y[0] = 1.0;
        m->volume_ratio.y[1] = ratios[k];
        simulation s = start(&scene);
        for (int frame = 0; frame < 30; frame++) {
            step_frames(&s, 1, NULL);
            assert_true(fabs(statistics(&s)->volume_error) < 0.01);
            assert_int_equal(statistics(&s)->nan_points, 0);
        }
        assert_true(fabs(statistics(&s)->volume_ratio - ratios[k]) < 0.01);
        assert_true(statistics(&s)->kinetic_energy < 1e-4); /* a quiet muscle: nothing pumps energy into it */
        finish(&s);
    }
}

/* A free muscle without stiffness: every point flies on its own. */
static void make_free(sn_scene *scene, double damping, sn_vec3 gravity) {
    fusiform f = FUSIFORM;
    f.pinned = 0.0;
    make_scene(scene, &f);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 0.0;
    scene->muscles[0].damping = damping;
    scene->gravity = gravity;
}

static void damping_is_an_exact_rate(void **state) {
    (void)state;
    for (sn_index substeps = 1; substeps <= 64; substeps *= 8) {
        sn_scene scene;
        make_free(&scene, 3.0, sn_v3(0, 0, 0));
        scene.solver.substeps = substeps;
        simulation s = start(&scene);
        s.state->muscles[0].velocities[7] = sn_v3(2, 0, -1);
        step_frames(&s, 6, NULL);
        double keep = exp(-3.0 * 6.0 / 24.0);
        assert_true(sn_distance(s.state->muscles[0].velocities[7], sn_v3(2 * keep, 0, -keep)) < 1e-10);
        finish(&s);
    }
}

/* x_n = x_0 + n h v_0 + h^2 g n (n + 1) / 2: n steps of v += h g, x += h v. */
static void no_stiffness_is_free_flight(void **state) {
    (void)state;
    sn_scene scene;
    make_free(&scene, 0.0, sn_v3(0, 0, -9.81));
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) assert_int_equal(s.model->plan.muscles[0].groups[kind].rows, 0);
    for (sn_index i = 0; i < m->point_count; i++) s.state->muscles[0].velocities[i] = sn_v3(0.001 * i, 0, 1);
    step_frames(&s, 10, NULL);
    double n = 10.0 * scene.solver.substeps, h = s.model->substep_duration;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 want = sn_add(m->rest[i], sn_v3(n * h * 0.001 * i, 0, n * h - 9.81 * h * h * n * (n + 1.0) / 2.0));
        assert_true(sn_distance(position(&s, i), want) < 1e-10);
    }
    finish(&s);
}

static void mass_is_density_times_volume(void **state) {
    (void)state;
    for (int structure = 0; structure < 2; structure++) {
        fusiform f = FUSIFORM;
        sn_scene scene;
        f.pinned = 0.0;
        f.structure = structure == 1;
        make_scene(&scene, &f);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        double mass = 0.0;
        for (sn_index i = 0; i < m->point_count; i++) mass += 1.0 / m->inverse_mass[i];
        assert_true(fabs(mass / (1060.0 * m->rest_volume) - 1.0) < 1e-12);
        finish(&s);
    }
}

static bool same_points(const simulation *a, const simulation *b, sn_index muscle) {
    const sn_model_muscle *m = &a->model->muscles[muscle];
    const sn_muscle_state *s = &a->state->muscles[muscle], *t = &b->state->muscles[muscle];
    if (m->point_count != b->model->muscles[muscle].point_count) return false;
    return memcmp(s->points, t->points, (size_t)m->point_count * sizeof *s->points) == 0 &&
           memcmp(s->velocities, t->velocities, (size_t)m->point_count * sizeof *s->velocities) == 0;
}

static void threads_change_no_bit(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation runs[3];
    for (int k = 0; k < 3; k++) {
        fusiform small = FUSIFORM;
        small.rings = 12;
        make_usual(&scenes[k], &FUSIFORM);
        add_muscle(&scenes[k], "second", &small);
        add_muscle(&scenes[k], "third", &FUSIFORM);
        scenes[k].muscles[2].law = SN_LAW_ISOCHORIC;
        sn_step_options options = {.pool = sn_pool_create(k + 1)};
        assert_non_null(options.pool);
        runs[k] = start(&scenes[k]);
        step_frames(&runs[k], 8, &options);
        sn_pool_destroy(options.pool);
    }
    for (int k = 1; k < 3; k++)
        for (sn_index m = 0; m < 3; m++) assert_true(same_points(&runs[0], &runs[k], m));
    for (int k = 0; k < 3; k++) finish(&runs[k]);
}

/* A structure that has no stiffness leaves no trace: same bytes out, same memory. */
static void off_equals_absent(void **state) {
    (void)state;
    fusiform without = FUSIFORM;
    without.structure = false;
    sn_scene off, absent;
    make_usual(&off, &FUSIFORM);
    make_usual(&absent, &without);
    off.muscles[0].stiffness_internal = 0.0;
    simulation a = start(&off), b = start(&absent);
    step_frames(&a, 8, NULL);
    step_frames(&b, 8, NULL);
    const sn_plan_muscle *p = a.model->plan.muscles, *q = b.model->plan.muscles;
    assert_true(same_points(&a, &b, 0));
    assert_true(p->model_bytes == q->model_bytes && p->state_bytes == q->state_bytes);
    assert_int_equal(p->groups[SN_ROWS_RADIAL].reason, SN_OUT_NO_STIFFNESS);
    assert_int_equal(q->groups[SN_ROWS_RADIAL].reason, SN_OUT_NO_STRUCTURE);
    finish(&a);
    finish(&b);
}

/* Three samples on which no vertex hangs: a root above the root, one between samples 1 and 2, and a leaf. */
static void add_bare_samples(sn_structure *s) {
    sn_index n = s->sample_count, next = 0, place[64];
    sn_structure with = {.sample_count = n + 3, .positions = SN_NEW(sn_vec3, n + 3), .parents = SN_NEW(sn_index, n + 3)};
    with.axes = SN_NEW(sn_vec3, n + 3);
    assert_true(n > 2 && n < 64 && s->parents[2] == 1);
    with.positions[next] = sn_v3(1, 2, 3), with.parents[next++] = SN_NONE;
    for (sn_index i = 0; i < n; i++) {
        if (i == 2) with.positions[next] = sn_v3(0, 0, 0.5), with.parents[next] = place[1], next++;
        with.positions[next] = s->positions[i], with.axes[next] = s->axes[i];
        with.parents[next] = i == 0 ? 0 : i == 2 ? next - 1 : place[s->parents[i]];
        place[i] = next++;
    }
    with.positions[next] = sn_v3(1, 1, 1), with.parents[next] = place[n - 1];
    free(s->positions), free(s->parents), free(s->axes);
    s->sample_count = with.sample_count, s->positions = with.positions, s->parents = with.parents, s->axes = with.axes;
    s->branches = sn_realloc(s->branches, (size_t)n + 3, sizeof *s->branches);
    for (sn_index i = n; i < n + 3; i++) s->branches[i] = 0;
}

/* Samples that carry nothing are left out, and their neighbours joined: the same bits as from a structure that never had them. */
static void bare_samples_equal_absent(void **state) {
    (void)state;
    sn_scene with, without;
    make_usual(&with, &FUSIFORM);
    make_usual(&without, &FUSIFORM);
    sn_structure *structure = &with.muscles[0].rig.structure;
    sn_index n = structure->sample_count;
    add_bare_samples(structure);
    for (sn_index v = 0; v < with.muscles[0].rig.mesh.vertex_count; v++)
        structure->vertex_sample[v] += structure->vertex_sample[v] < 2 ? 1 : 2;
    simulation a = start(&with), b = start(&without);
    step_frames(&a, 8, NULL);
    step_frames(&b, 8, NULL);
    assert_true(same_points(&a, &b, 0));
    assert_int_equal(a.model->plan.muscles[0].samples, n);
    assert_int_equal(a.model->plan.muscles[0].bare_samples, 3);
    assert_int_equal(a.model->plan.muscles[0].groups[SN_ROWS_INTERNAL].rows, n - 1);
    assert_int_equal(a.model->muscles[0].samples[2], 4);
    finish(&a);
    finish(&b);
}

/* A disabled muscle beside the others changes no bit of theirs. */
static void disabled_equals_absent(void **state) {
    (void)state;
    sn_scene one, two;
    make_usual(&one, &FUSIFORM);
    make_usual(&two, &FUSIFORM);
    add_muscle(&two, "asleep", &FUSIFORM);
    two.muscles[1].enabled = false;
    simulation a = start(&one), b = start(&two);
    step_frames(&a, 3, NULL);
    step_frames(&b, 3, NULL);
    assert_int_equal(b.model->muscle_count, 1);
    assert_true(same_points(&a, &b, 0));
    finish(&a);
    finish(&b);
}

/* A sliver, a doubled vertex, a ring without width: nothing blows up. */
static void degenerate_triangles_do_not_blow_up(void **state) {
    (void)state;
    sn_scene scene;
    make_usual(&scene, &FUSIFORM);
    sn_mesh *mesh = &scene.muscles[0].rig.mesh;
    sn_vec3 *p = mesh->positions + 12 * 16;
    p[1] = p[0];
    p[5] = sn_lerp(p[4], p[6], 1e-6);
    for (int i = 0; i < 16; i++) mesh->positions[8 * 16 + i] = sn_v3(0, 0, mesh->positions[8 * 16 + i].z);
    simulation s = start(&scene);
    assert_true(s.model->plan.muscles[0].groups[SN_ROWS_DIHEDRAL].degenerate > 0);
    for (int frame = 0; frame < 30; frame++) {
        step_frames(&s, 1, NULL);
        assert_int_equal(statistics(&s)->nan_points, 0);
    }
    assert_true(greatest_move(&s) < 2.0 * s.model->muscles[0].diagonal);
    finish(&s);
}

/* What is not finite is counted and named, rows at it are skipped, and it does not spread to what hangs on it. */
static void nan_is_counted_and_does_not_spread(void **state) {
    (void)state;
    sn_scene scene;
    make_usual(&scene, &FUSIFORM);
    simulation s = start(&scene);
    s.state->muscles[0].points[100].y = NAN;
    step_frames(&s, 3, NULL);
    assert_int_equal(statistics(&s)->nan_points, 1);
    assert_int_equal(statistics(&s)->first_nan, 100);
    assert_true(statistics(&s)->skipped_edges > 0 && statistics(&s)->skipped_hinges > 0);
    finish(&s);
}

static void bones_away_from_rest_carry_the_muscle_along(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    sn_pose_key *key = SN_NEW(sn_pose_key, 1);
    *key = (sn_pose_key){0.0, {sn_quat_axis_angle(sn_v3(0, 1, 0), 2.0), {10, 20, 30}}};
    sn_joint *joint = &scene.motion.joints[0];
    *joint = (sn_joint){.name = joint->name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 1, .keys = key};
    scene.bones[0].joint = 0; /* both ends move as one */
    simulation s = start(&scene);
    for (int frame = 0; frame < 3; frame++) {
        for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
            assert_true(sn_distance(position(&s, i), sn_rigid_apply(key->pose, s.model->muscles[0].rest[i])) < 1e-9);
        step_frames(&s, 1, NULL);
    }
    finish(&s);
}

/* The pre-roll leaves what a second of frames with the same inputs would, at the first frame. */
static void settling_is_a_run_with_constant_inputs(void **state) {
    (void)state;
    sn_scene settled, stepped;
    make_scene(&settled, &FUSIFORM);
    make_scene(&stepped, &FUSIFORM);
    settled.muscles[0].activation.constant = stepped.muscles[0].activation.constant = 0.5;
    settled.preroll = 0.5;
    simulation a = start(&settled), b = start(&stepped);
    assert_int_equal(sn_settle(a.model, a.state, NULL, NULL), SN_OK);
    step_frames(&b, 12, NULL);
    assert_int_equal(a.state->frame, 0);
    assert_true(same_points(&a, &b, 0));
    assert_true(greatest_move(&a) > 1e-4);
    finish(&a);
    finish(&b);
}

/* ---- stops and traces ------------------------------------------------------------------------------------------------------- */

typedef struct counter {
    int records, volumes;
} counter;

static void count_record(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    counter *c = user;
    (void)number;
    assert_string_equal(stage, "iteration");
    c->records++;
    for (int i = 0; i < value_count; i++) c->volumes += strcmp(values[i].name, "volume_error") == 0 && fabs(values[i].number) < 0.01;
}

static void watching_changes_nothing(void **state) {
    (void)state;
    sn_scene watched, alone;
    counter c = {0};
    sn_trace trace = {.receive = count_record, .user = &c, .stop_after = -1};
    sn_step_options options = {.trace = &trace};
    make_usual(&watched, &FUSIFORM);
    make_usual(&alone, &FUSIFORM);
    simulation a = start(&watched), b = start(&alone);
    step_frames(&a, 3, &options);
    step_frames(&b, 3, NULL);
    assert_true(same_points(&a, &b, 0));
    assert_int_equal(c.records, 3 * watched.solver.substeps * watched.solver.iterations);
    assert_int_equal(c.volumes, c.records);
    finish(&a);
    finish(&b);
}

static void a_step_stops_where_it_is_told(void **state) {
    (void)state;
    sn_scene scenes[4];
    simulation runs[4];
    static const sn_step_options stops[4] = {{.stop_substep = 3}, {.stop_substep = 3, .stop_iteration = 1}, {.stop_substep = 2}, {0}};
    for (int k = 0; k < 4; k++) {
        make_usual(&scenes[k], &FUSIFORM);
        runs[k] = start(&scenes[k]);
        step_frames(&runs[k], 2, NULL);
        assert_int_equal(sn_step(runs[k].model, runs[k].state, &stops[k], NULL), k < 3 ? SN_STOPPED : SN_OK);
        assert_int_equal(runs[k].state->frame, 3);
        for (int l = 0; l < k; l++) assert_false(same_points(&runs[k], &runs[l], 0));
    }
    sn_error error = {0};
    sn_step_options beyond = {.stop_substep = scenes[3].solver.substeps + 1};
    assert_int_equal(sn_step(runs[3].model, runs[3].state, &beyond, &error), SN_ERROR_USAGE);
    for (int k = 0; k < 4; k++) finish(&runs[k]);
}

/* Stopped at odd places and gone on from there, the same bits as a run in one go; also where the muscles have different iterations. */
static void a_stopped_step_goes_on_to_the_same_bits(void **state) {
    (void)state;
    static const sn_index stops[][2] = {{3, 1}, {3, 2}, {5, 0}, {5, 1}, {16, 2}};
    sn_scene scenes[2];
    simulation runs[2];
    for (int k = 0; k < 2; k++) {
        make_usual(&scenes[k], &FUSIFORM);
        scenes[k].solver.iterations = 3;
        add_muscle(&scenes[k], "second", &FUSIFORM);
        scenes[k].muscles[1].iterations = 1;
        runs[k] = start(&scenes[k]);
        step_frames(&runs[k], 1, NULL);
    }
    for (int i = 0; i < 5; i++) {
        sn_step_options options = {.stop_substep = stops[i][0], .stop_iteration = stops[i][1]};
        if (i == 2) options.stop_iteration = 0; /* where a whole substep ends */
        sn_status status = sn_step(runs[0].model, runs[0].state, &options, NULL);
        assert_int_equal(status, i == 3 ? SN_ERROR_USAGE : SN_STOPPED);
    }
    step_frames(&runs[0], 2, NULL);
    step_frames(&runs[1], 2, NULL);
    assert_int_equal(runs[0].state->frame, runs[1].state->frame);
    assert_true(same_points(&runs[0], &runs[1], 0) && same_points(&runs[0], &runs[1], 1));
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

/* A muscle that has come to rest sleeps until an input changes, where it would be without sleeping, to 1e-9 L; and costs nothing. */
static void sleep_moves_nothing(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    sn_index slept = 0, after = 0;
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &FUSIFORM);
        scenes[k].muscles[0].damping = 30.0;
        scenes[k].muscles[0].contraction = 0.1;
        set_keys(&scenes[k].muscles[0].activation, 12.0, 0.0, 12.5, 1.0); /* rest, then an input */
        set_keys(&scenes[k].motion.joints[0].angle, 0.0, -0.05, 0.5, 0.0);
        scenes[k].solver.sleep = k == 0;
        runs[k] = start(&scenes[k]);
    }
    double most = 0.0;
    for (int frame = 1; frame <= 13 * 24; frame++) {
        for (int k = 0; k < 2; k++) step_frames(&runs[k], 1, NULL);
        assert_false(statistics(&runs[1])->asleep);
        slept += statistics(&runs[0])->asleep;
        after += statistics(&runs[0])->asleep && frame > 12 * 24;
        for (sn_index i = 0; i < runs[0].model->muscles[0].point_count; i++)
            most = fmax(most, sn_distance(position(&runs[0], i), position(&runs[1], i)));
    }
    assert_true(slept > 24);
    assert_int_equal(after, 0);
    assert_true(most < 1e-9 * runs[0].model->muscles[0].diagonal);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

static void ignore_record(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    (void)user, (void)number, (void)stage, (void)values, (void)value_count;
}

/* A muscle that falls asleep on the way, in a pre-roll or between the substeps of a frame, is measured where it lies: as where each
 * iteration is watched. */
static void what_fell_asleep_is_measured(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    sn_trace trace = {.receive = ignore_record, .stop_after = -1};
    for (int k = 0; k < 2; k++) {
        const sn_step_options options = {.trace = k == 0 ? NULL : &trace};
        make_scene(&scenes[k], &FUSIFORM);
        scenes[k].muscles[0].damping = 30.0;
        scenes[k].gravity = sn_v3(0, 0, -9.81);
        scenes[k].preroll = 8.0;
        runs[k] = start(&scenes[k]);
        assert_int_equal(sn_settle(runs[k].model, runs[k].state, &options, NULL), SN_OK);
    }
    const sn_statistics *s = statistics(&runs[0]), *watched = statistics(&runs[1]);
    assert_true(s->asleep && watched->asleep);
    assert_true(s->residuals[SN_ROWS_MESH].max > 1e-9); /* it hangs */
    assert_true(s->residuals[SN_ROWS_MESH].max == watched->residuals[SN_ROWS_MESH].max);
    assert_true(s->volume_ratio == watched->volume_ratio && s->kinetic_energy == watched->kinetic_energy);
    assert_true(s->residual == watched->residual && s->elastic_energy == watched->elastic_energy);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

/* ---- refusals and plans ------------------------------------------------------------------------------------------------------ */

static void a_bone_that_is_missing_is_named(void **state) {
    (void)state;
    sn_scene scene;
    sn_model *model;
    sn_error error = {0};
    make_scene(&scene, &FUSIFORM);
    strcpy(scene.bones[1].name, "other");
    assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
    assert_null(model);
    assert_non_null(strstr(error.text, "lower"));
    sn_scene_free(&scene);
}

static void an_open_surface_keeps_no_volume(void **state) {
    (void)state;
    sn_scene scene;
    make_usual(&scene, &FUSIFORM);
    scene.muscles[0].rig.mesh.triangle_count -= 2;
    simulation s = start(&scene);
    step_frames(&s, 6, NULL);
    assert_int_equal(s.model->plan.muscles[0].groups[SN_ROWS_VOLUME].reason, SN_OUT_OPEN_SURFACE);
    assert_true(isnan(statistics(&s)->volume_ratio) && isnan(statistics(&s)->volume_error));
    assert_int_equal(statistics(&s)->nan_points, 0);
    finish(&s);
}

/* numerics.md 1: the plan's k h^2 w, and what it means: far below 1 a stiffness is felt, far above it is not. */
static void the_plan_tells_where_a_stiffness_is_felt(void **state) {
    (void)state;
    static const double stiffness[] = {1.0, 4.0, 5e5, 2e6};
    double stretch[4], rigidity[4];
    for (int k = 0; k < 4; k++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = stiffness[k];
        scene.gravity = sn_v3(0, -9.81, 0);
        simulation s = start(&scene);
        step_frames(&s, 48, NULL);
        stretch[k] = statistics(&s)->residuals[SN_ROWS_MESH].rms;
        rigidity[k] = s.model->plan.muscles[0].groups[SN_ROWS_MESH].rigidity[0];
        double h = s.model->substep_duration, w = s.model->muscles[0].point_count / s.model->muscles[0].mass;
        assert_true(fabs(rigidity[k] / (stiffness[k] * h * h * w) - 1.0) < 1e-12);
        finish(&s);
    }
    assert_true(rigidity[1] < 1.0 && rigidity[2] > 100.0);
    assert_true(stretch[1] < 0.7 * stretch[0]);
    assert_true(fabs(stretch[3] / stretch[2] - 1.0) < 0.05);
}

/* Rows whose points are all on bones are not built; the rest add up to the edges. */
static void rows_between_bones_are_left_out(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_plan_group *mesh = &s.model->plan.muscles[0].groups[SN_ROWS_MESH];
    assert_true(mesh->kinematic > 0);
    assert_int_equal(mesh->rows + mesh->kinematic, 3 * s.model->muscles[0].triangle_count / 2);
    for (sn_index r = 0; r < s.model->muscles[0].distance_start[SN_DISTANCE_KINDS]; r++) {
        const sn_index *point = s.model->muscles[0].distances[r].point;
        assert_true(s.model->muscles[0].inverse_mass[point[0]] + s.model->muscles[0].inverse_mass[point[1]] > 0.0);
    }
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rest_stays_at_rest_under_every_law),
        cmocka_unit_test(momentum_is_conserved_without_attachments),
        cmocka_unit_test(a_scene_turned_and_a_kilometre_away_gives_the_same),
        cmocka_unit_test(attached_vertices_are_exactly_on_their_bones),
        cmocka_unit_test(volume_stays_at_its_goal_and_reaches_a_new_one),
        cmocka_unit_test(damping_is_an_exact_rate),
        cmocka_unit_test(no_stiffness_is_free_flight),
        cmocka_unit_test(mass_is_density_times_volume),
        cmocka_unit_test(threads_change_no_bit),
        cmocka_unit_test(off_equals_absent),
        cmocka_unit_test(disabled_equals_absent),
        cmocka_unit_test(degenerate_triangles_do_not_blow_up),
        cmocka_unit_test(nan_is_counted_and_does_not_spread),
        cmocka_unit_test(bones_away_from_rest_carry_the_muscle_along),
        cmocka_unit_test(settling_is_a_run_with_constant_inputs),
        cmocka_unit_test(watching_changes_nothing),
        cmocka_unit_test(a_step_stops_where_it_is_told),
        cmocka_unit_test(a_stopped_step_goes_on_to_the_same_bits),
        cmocka_unit_test(sleep_moves_nothing),
        cmocka_unit_test(what_fell_asleep_is_measured),
        cmocka_unit_test(a_bone_that_is_missing_is_named),
        cmocka_unit_test(an_open_surface_keeps_no_volume),
        cmocka_unit_test(the_plan_tells_where_a_stiffness_is_felt),
        cmocka_unit_test(rows_between_bones_are_left_out),
        cmocka_unit_test(bare_samples_equal_absent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
