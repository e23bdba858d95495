/* test_sim_properties.c -- what holds of a step whichever back end makes it, each with its equation. See test_sim_step.c for xpbd alone. */
#include "sim_scene.h"

#define assert_below(value, limit)                                                                                                         \
    do {                                                                                                                                   \
        double value_ = (value), limit_ = (limit);                                                                                         \
        if (!(value_ < limit_)) fail_msg("%s = %g is not below %g", #value, value_, limit_);                                               \
    } while (0)
static const sn_statistics *statistics(const simulation *s) { return &s->state->muscles[0].statistics; }

/* The back ends in turn: what they are asked for, and how far off their answer may be. qn is solved until nothing moves. */
typedef struct back_end {
    sn_solver_method method;
    sn_preconditioning preconditioner;
    double error;
} back_end;
static const back_end BACK_ENDS[] = {{SN_SOLVER_XPBD, SN_PRECONDITION_SCALAR, 1e-5},
                                     {SN_SOLVER_QN, SN_PRECONDITION_SCALAR, 1e-5},
                                     {SN_SOLVER_QN, SN_PRECONDITION_COROTATED, 1e-5}};
enum { BACK_END_COUNT = 3 };

static void use(sn_scene *scene, const back_end *by) {
    scene->solver = sn_solver_defaults(by->method);
    scene->solver.preconditioner = by->preconditioner;
    if (by->method != SN_SOLVER_QN) return;
    scene->solver.iterations = 300;
    scene->solver.tolerance = 1e-9;
}

static void set_ratio(sn_scene_muscle *m, double ratio) {
    m->volume_ratio = (sn_knots){2, SN_NEW(double, 2), SN_NEW(double, 2)};
    m->volume_ratio.x[1] = m->volume_ratio.y[0] = 1.0;
    m->volume_ratio.y[1] = ratio;
}

/* C = V - g(a)/g(a0) V0 and sigma(a0) = |e|: the rest shape rests at a = a0 != 0, with a volume ratio too (methods.md 8.1, 8.3). */
static void the_rest_shape_rests_at_its_own_activation(void **state) {
    (void)state;
    for (int i = 0; i < BACK_END_COUNT; i++)
        for (int law = 0; law < 3; law++) {
            sn_scene scene;
            make_scene(&scene, &FUSIFORM);
            use(&scene, &BACK_ENDS[i]);
            scene.muscles[0].law = (sn_fiber_law)law;
            scene.muscles[0].rest_activation = scene.muscles[0].activation.constant = 0.6;
            set_ratio(&scene.muscles[0], 1.5);
            simulation s = start(&scene);
            step_frames(&s, 5, NULL);
            assert_true(greatest_move(&s) < 1e-9);
            finish(&s);
        }
}

/* sum m v is what it was: inner forces come in pairs (Newton's third law), and nothing is damped. */
static void momentum_is_conserved(void **state) {
    (void)state;
    for (int i = 0; i < BACK_END_COUNT; i++) {
        fusiform f = FUSIFORM;
        sn_scene scene;
        uint64_t random = 3;
        f.pinned = 0.0;
        make_scene(&scene, &f);
        use(&scene, &BACK_ENDS[i]);
        scene.muscles[0].damping = 0.0;
        set_keys(&scene.muscles[0].activation, 0.0, 0.0, 0.5, 1.0);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        sn_vec3 before = sn_v3(0, 0, 0), after = before, *v = s.state->muscles[0].velocities;
        double size = 0.0;
        for (sn_index p = 0; p < m->point_count; p++) {
            v[p] = sn_v3(0.02 * sn_random(&random), 0.02 * sn_random(&random), 0.5);
            before = sn_add_scaled(before, v[p], 1.0 / m->inverse_mass[p]);
            size += sn_norm(v[p]) / m->inverse_mass[p];
        }
        step_frames(&s, 5, NULL);
        for (sn_index p = 0; p < m->point_count; p++) after = sn_add_scaled(after, v[p], 1.0 / m->inverse_mass[p]);
        assert_below(sn_distance(before, after) / size, 1e-6);
        assert_true(statistics(&s)->restarts == 0);
        finish(&s);
    }
}

/* x(R scene + t) = R x(scene) + t, to 1e-7 L at a distance of 1 km (numerics.md 5). */
static void a_scene_turned_and_a_kilometre_away_gives_the_same(void **state) {
    (void)state;
    const sn_rigid by = {sn_quat_normalize((sn_quat){0.3, -0.5, 0.7, 0.2}), {600, -700, 400}};
    for (int i = 0; i < BACK_END_COUNT; i++)
        for (int law = 0; law < 3; law += 2) {
            sn_scene scenes[2];
            simulation s[2];
            double most = 0.0;
            for (int k = 0; k < 2; k++) {
                make_scene(&scenes[k], &FUSIFORM);
                use(&scenes[k], &BACK_ENDS[i]);
                scenes[k].muscles[0].law = (sn_fiber_law)law;
                scenes[k].muscles[0].contraction = 0.3;
                set_keys(&scenes[k].muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
                set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, 1.0, -0.5);
                if (k == 1) turn_and_move(&scenes[k], by);
                s[k] = start(&scenes[k]);
                step_frames(&s[k], 8, NULL); /* later it buckles under the law isochoric, this way or that */
            }
            for (sn_index p = 0; p < s[0].model->muscles[0].point_count; p++)
                most = fmax(most, sn_distance(sn_rigid_apply(by, position(&s[0], p)), position(&s[1], p)));
            assert_below(most / s[0].model->muscles[0].diagonal, 1e-7);
            assert_true(greatest_move(&s[0]) > 0.002);
            for (int k = 0; k < 2; k++) finish(&s[k]);
        }
}

/* A muscle that hangs on nothing, its fibres all along z. */
static void make_parallel(sn_scene *scene, sn_fiber_law law) {
    fusiform f = FUSIFORM;
    f.pinned = 0.0;
    make_scene(scene, &f);
    sn_scene_muscle *m = &scene->muscles[0];
    for (sn_index v = 0; v < m->rig.mesh.vertex_count; v++) m->rig.fibers.directions[v] = sn_v3(0, 0, 1);
    m->law = law;
    m->contraction = 0.2;
    set_keys(&m->activation, 0.0, 0.0, 2.0, 1.0); /* slowly: such a shell may also buckle */
    m->stiffness_dihedral = 0.0;
    m->least_area = 0.0;
    m->damping = 30.0;
    if (law != SN_LAW_ISOCHORIC) set_ratio(m, 0.8);
}

/* sigma = |c e_along + w e_across| with one axis everywhere is what diag(w, w, c) makes of the rest shape, c = (1-a)/(1-a0): the muscle
 * takes that shape, no row is strained. w = 1 under projected and (along an axis) paper, sqrt(g/c) under isochoric. The goal
 * volume is that of this shape: a shell of springs alone has other ones too. */
static void a_muscle_of_parallel_fibres_takes_the_shape_of_its_law(void **state) {
    (void)state;
    for (int i = 0; i < BACK_END_COUNT; i++)
        for (int law = 0; law < 3; law++) {
            sn_scene scene;
            make_parallel(&scene, (sn_fiber_law)law);
            use(&scene, &BACK_ENDS[i]);
            simulation s = start(&scene);
            const sn_model_muscle *m = &s.model->muscles[0];
            double c = 0.8, w = law == SN_LAW_ISOCHORIC ? sqrt(1.0 / c) : 1.0, most = 0.0;
            step_frames(&s, 96, NULL);
            sn_vec3 centre = sn_v3(0, 0, 0), rest = centre;
            for (sn_index p = 0; p < m->point_count; p++) {
                centre = sn_add_scaled(centre, position(&s, p), 1.0 / m->point_count);
                rest = sn_add_scaled(rest, m->rest[p], 1.0 / m->point_count);
            }
            for (sn_index p = 0; p < m->point_count; p++) {
                sn_vec3 r = sn_sub(m->rest[p], rest), want = sn_v3(w * r.x, w * r.y, c * r.z);
                most = fmax(most, sn_distance(sn_sub(position(&s, p), centre), want) / m->diagonal);
            }
            assert_below(most, BACK_ENDS[i].error);
            finish(&s);
        }
}

/* Fibres of 0.8 of their length in the rest shape, and no activation: c = rest length, whatever pulls; the volume keeps. bodies.md 4 */
static void a_passive_muscle_is_as_long_as_its_fibres(void **state) {
    (void)state;
    for (int i = 0; i < BACK_END_COUNT; i++) {
        sn_scene scene;
        make_parallel(&scene, SN_LAW_ISOCHORIC);
        use(&scene, &BACK_ENDS[i]);
        sn_channel_free(&scene.muscles[0].activation);
        scene.muscles[0].activation = (sn_channel){.constant = 0.0};
        scene.muscles[0].rest_length = 0.8;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        step_frames(&s, 96, NULL);
        sn_vec3 low = position(&s, 0), high = low, rest_low = m->rest[0], rest_high = rest_low;
        for (sn_index p = 1; p < m->point_count; p++) {
            low = sn_min3(low, position(&s, p)), high = sn_max3(high, position(&s, p));
            rest_low = sn_min3(rest_low, m->rest[p]), rest_high = sn_max3(rest_high, m->rest[p]);
        }
        assert_below(fabs((high.z - low.z) / (rest_high.z - rest_low.z) - 0.8), 1e-3);
        assert_below(fabs((high.x - low.x) / (rest_high.x - rest_low.x) - sqrt(1.0 / 0.8)), 1e-3);
        assert_below(fabs(statistics(&s)->volume_error), 1e-3);
        finish(&s);
    }
}

/* Below the tone there is no activation; above it the tone is nothing. */
static void tone_is_a_floor_of_activation(void **state) {
    (void)state;
    for (int i = 0; i < BACK_END_COUNT; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_scene(&scenes[k], &FUSIFORM);
            use(&scenes[k], &BACK_ENDS[i]);
            set_keys(&scenes[k].muscles[0].activation, 0.125, k == 0 ? 0.3 : 0.1, 0.25, 0.8);
        }
        scenes[1].muscles[0].tone = 0.3;
        for (int k = 0; k < 2; k++) runs[k] = start(&scenes[k]);
        step_frames(&runs[0], 3, NULL);
        step_frames(&runs[1], 3, NULL);
        assert_memory_equal(runs[0].state->muscles[0].points, runs[1].state->muscles[0].points,
                            (size_t)runs[0].model->muscles[0].point_count * sizeof(sn_point));
        assert_true(statistics(&runs[1])->activation == 0.3);
        step_frames(&runs[1], 4, NULL);
        assert_true(statistics(&runs[1])->activation == 0.8);
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

/* V = g(a)/g(a0) V0 ([R18] 4.1). */
static void a_goal_volume_is_reached(void **state) {
    (void)state;
    static const double RATIOS[] = {1.0, 1.3, 1.5, 2.0}; /* [R18] fig. 17 */
    for (int i = 0; i < BACK_END_COUNT; i++)
        for (int k = 0; k < 4; k++) {
            sn_scene scene;
            make_scene(&scene, &FUSIFORM);
            use(&scene, &BACK_ENDS[i]);
            scene.muscles[0].law = SN_LAW_ISOCHORIC; /* lengths that fit the volume */
            scene.muscles[0].contraction = 0.2;
            set_ratio(&scene.muscles[0], RATIOS[k]);
            set_keys(&scene.muscles[0].activation, 0.0, 0.0, 0.5, 1.0);
            simulation s = start(&scene);
            step_frames(&s, 30, NULL);
            assert_int_equal(statistics(&s)->nan_points, 0);
            assert_true(fabs(statistics(&s)->volume_ratio / RATIOS[k] - 1.0) < 0.02);
            finish(&s);
        }
}

/* One triangle, two of its corners on bones; the third is pulled away from them along x. */
static void make_triangle(sn_scene *scene, double k_h2_w) {
    fusiform f = FUSIFORM;
    make_scene(scene, &f);
    sn_scene_muscle *m = &scene->muscles[0];
    sn_muscle_free(&m->rig);
    m->rig = (sn_muscle){.name = sn_strdup("triangle"), .meters_per_unit = 1.0, .has_attachments = true, .attachment_count = 1};
    assert_int_equal(sn_mesh_alloc(&m->rig.mesh, 3, 1, NULL), SN_OK);
    m->rig.mesh.positions[0] = sn_v3(0, -0.02, 0);
    m->rig.mesh.positions[1] = sn_v3(0, 0.02, 0);
    m->rig.mesh.positions[2] = sn_v3(0.1, 0, 0);
    m->rig.mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
    m->rig.attachments = SN_NEW(sn_attachment, 1);
    m->rig.attachments[0] =
        (sn_attachment){.bone = sn_strdup("upper"), .method = sn_strdup("pin"), .count = 2, .vertices = SN_NEW(sn_index, 2)};
    m->rig.attachments[0].vertices[1] = 1;
    m->stiffness_scaled = false;
    m->unit_mass = true;
    m->stiffness_relaxed = m->stiffness_active = k_h2_w * 24.0 * 24.0;
    scene->gravity = sn_v3(1.6, 0, 0);
}

/* A row gives way by k h^2 w alone (numerics.md 1): one implicit step solves m (x - y) / h^2 + 2 k (l - l0) x / l = 0, l^2 = x^2 + b^2,
 * y = x0 + h^2 g. At k h^2 w >> 1 it is rigid, whatever k. xpbd sums along the gradients of its iterates: off by the square of
 * the step. */
static void a_row_gives_way_by_k_h2_w(void **state) {
    (void)state;
    static const double RIGIDITIES[] = {0.1, 1.0, 10.0, 1e4};
    for (int i = 0; i < BACK_END_COUNT; i++)
        for (int k = 0; k < 4; k++) {
            sn_scene scene;
            make_triangle(&scene, RIGIDITIES[k]);
            use(&scene, &BACK_ENDS[i]);
            scene.solver.substeps = 1;
            scene.solver.iterations = 1000;
            simulation s = start(&scene);
            double h = s.model->substep_duration, y = 0.1 + h * h * 1.6, low = 0.1, high = y;
            double l0 = sqrt(0.1 * 0.1 + 0.02 * 0.02);
            for (int halving = 0; halving < 100; halving++) { /* the force grows with x */
                double x = 0.5 * (low + high), l = sqrt(x * x + 0.02 * 0.02);
                double force = x - y + 2.0 * RIGIDITIES[k] * (l - l0) * x / l;
                *(force > 0.0 ? &high : &low) = x;
            }
            step_frames(&s, 1, NULL);
            double moved = position(&s, 2).x - 0.1, want = 0.5 * (low + high) - 0.1;
            assert_below(hypot(position(&s, 2).y, position(&s, 2).z), BACK_ENDS[i].error);
            assert_below(fabs(moved - want), (BACK_ENDS[i].method == SN_SOLVER_QN ? 1e-9 : 0.1 * (y - 0.1) * (y - 0.1) / 0.1));
            if (RIGIDITIES[k] > 1e3) assert_true(moved < 1e-3 * (y - 0.1));
            finish(&s);
        }
}

/* A muscle that sleeps is where it would be if it did not, to 1e-9 L; it wakes when an input changes. */
static void compare_sleep(sn_preconditioning preconditioner) {
    sn_scene scenes[2];
    simulation s[2];
    sn_index slept = 0, after = 0;
    double most = 0.0;
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &FUSIFORM);
        scenes[k].solver = sn_solver_defaults(SN_SOLVER_QN);
        scenes[k].solver.preconditioner = preconditioner;
        scenes[k].solver.sleep = k == 0;
        scenes[k].muscles[0].damping = 30.0;
        scenes[k].muscles[0].contraction = 0.1;
        set_keys(&scenes[k].muscles[0].activation, 12.0, 0.0, 12.5, 1.0); /* rest, then an input */
        set_keys(&scenes[k].motion.joints[0].angle, 0.0, -0.05, 0.5, 0.0);
        s[k] = start(&scenes[k]);
    }
    for (int frame = 1; frame <= 13 * 24; frame++) {
        for (int k = 0; k < 2; k++) step_frames(&s[k], 1, NULL);
        assert_false(statistics(&s[1])->asleep);
        slept += statistics(&s[0])->asleep;
        after += statistics(&s[0])->asleep && frame > 12 * 24;
        for (sn_index i = 0; i < s[0].model->muscles[0].point_count; i++)
            most = fmax(most, sn_distance(position(&s[0], i), position(&s[1], i)));
    }
    assert_true(slept > 24);
    assert_int_equal(after, 0);
    assert_below(most / s[0].model->muscles[0].diagonal, 1e-9);
    for (int k = 0; k < 2; k++) finish(&s[k]);
}

static void sleep_moves_nothing_under_qn(void **state) {
    (void)state;
    compare_sleep(SN_PRECONDITION_COROTATED);
    compare_sleep(SN_PRECONDITION_SCALAR);
}

/* ---- weight and damping ------------------------------------------------------------------------------------------------------- */

/* A small fusiform, its bones both on joint 0. */
static void make_carried(sn_scene *scene, double damping, const back_end *by) {
    fusiform f = FUSIFORM;
    f.rings = 12, f.sectors = 11;
    make_scene(scene, &f);
    use(scene, by);
    scene->bones[0].joint = scene->bones[1].joint = 0;
    scene->solver.sleep = false;
    scene->gravity = sn_v3(9.81, 0, 0);
    scene->muscles[0].damping = damping;
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 5e4;
}

/* Until the pull of the bones' motion has died away. */
enum { SETTLED = 144 };

/* Greatest distance between the points of two simulations, the first taken back by `back`, over L. */
static double differ(const simulation *a, const simulation *b, sn_rigid back) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++)
        most = fmax(most, sn_distance(sn_rigid_apply(back, position(a, i)), position(b, i)));
    return most / a->model->muscles[0].diagonal;
}

/* m (x - y) / h^2 = m g at rest, whatever damping and step: weight is no velocity, and is not damped. */
static void a_muscle_at_rest_bears_its_whole_weight(void **state) {
    (void)state;
    static const double DAMPINGS[] = {1.0, 5.0, 20.0};
    for (int b = 0; b < 2; b++) {
        simulation s[9];
        sn_scene scenes[9];
        int count = 0;
        for (sn_index substeps = 1; substeps <= (BACK_ENDS[b].method == SN_SOLVER_QN ? 16 : 1); substeps *= 4)
            for (int i = 0; i < 3; i++, count++) {
                make_carried(&scenes[count], DAMPINGS[i], &BACK_ENDS[b]);
                if (BACK_ENDS[b].method == SN_SOLVER_QN) scenes[count].solver.substeps = substeps;
                s[count] = start(&scenes[count]);
                step_frames(&s[count], SETTLED, NULL);
            }
        assert_true(greatest_move(&s[0]) > 1e-5);
        for (int i = 1; i < count; i++) assert_below(differ(&s[i], &s[0], sn_rigid_identity()), 1e-6);
        for (int i = 0; i < count; i++) finish(&s[i]);
    }
}

static void move_both_bones(sn_scene *scene, sn_vec3 velocity, double seconds) {
    sn_joint *joint = &scene->motion.joints[0];
    joint->kind = SN_JOINT_POSE;
    joint->key_count = 2;
    joint->keys = SN_NEW(sn_pose_key, 2);
    joint->keys[0].pose = joint->keys[1].pose = sn_rigid_identity();
    joint->keys[1].time = seconds;
    joint->keys[1].pose.translation = sn_scale(velocity, seconds);
}

/* Carried along at any constant speed a muscle has the shape that it has at rest. */
static void constant_speed_is_no_force(void **state) {
    (void)state;
    for (int b = 0; b < 2; b++) {
        simulation s[2];
        sn_scene scenes[2];
        const double seconds = SETTLED / 24.0;
        for (int k = 0; k < 2; k++) {
            make_carried(&scenes[k], 20.0, &BACK_ENDS[b]);
            if (k == 0) move_both_bones(&scenes[k], sn_v3(3, 0, 4), seconds);
            s[k] = start(&scenes[k]);
            step_frames(&s[k], SETTLED, NULL);
        }
        assert_below(differ(&s[0], &s[1], (sn_rigid){sn_quat_identity(), sn_v3(-3 * seconds, 0, -4 * seconds)}), 1e-9);
        for (int k = 0; k < 2; k++) finish(&s[k]);
    }
}

/* And turned at a constant rate, 15 degrees a frame, it has one shape, that which the turning alone gives it: no damping acts on it. */
static void constant_turning_is_not_damped(void **state) {
    (void)state;
    const double seconds = SETTLED / 24.0, turns = SETTLED / 24.0;
    simulation s[2];
    sn_scene scenes[2];
    for (int k = 0; k < 2; k++) {
        make_carried(&scenes[k], k == 0 ? 5.0 : 40.0, &BACK_ENDS[1]);
        scenes[k].gravity = sn_v3(0, 0, 0);
        scenes[k].solver.tolerance = 1e-12;
        set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, seconds, 2.0 * SN_PI * turns);
        s[k] = start(&scenes[k]);
        step_frames(&s[k], SETTLED, NULL);
    }
    assert_true(greatest_move(&s[0]) > 1e-7); /* it is pulled outwards */
    assert_below(differ(&s[0], &s[1], sn_rigid_identity()), 1e-9);
    for (int k = 0; k < 2; k++) finish(&s[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rest_shape_rests_at_its_own_activation),
        cmocka_unit_test(momentum_is_conserved),
        cmocka_unit_test(a_scene_turned_and_a_kilometre_away_gives_the_same),
        cmocka_unit_test(a_muscle_of_parallel_fibres_takes_the_shape_of_its_law),
        cmocka_unit_test(a_passive_muscle_is_as_long_as_its_fibres),
        cmocka_unit_test(tone_is_a_floor_of_activation),
        cmocka_unit_test(a_goal_volume_is_reached),
        cmocka_unit_test(a_row_gives_way_by_k_h2_w),
        cmocka_unit_test(sleep_moves_nothing_under_qn),
        cmocka_unit_test(a_muscle_at_rest_bears_its_whole_weight),
        cmocka_unit_test(constant_speed_is_no_force),
        cmocka_unit_test(constant_turning_is_not_damped),
    };
    return cmocka_run_group_tests_name("properties", tests, NULL, NULL);
}
