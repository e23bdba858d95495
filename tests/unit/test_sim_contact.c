/* test_sim_contact.c -- contact of muscles with bones (contact*.c): rows, energies, margins, friction, reach, sleep, stopping, and contact
 * off. */
#include "contact_scene.h"

#include "../../lib/sim/contact.h"
#include "sim_inside.h"

static const sn_solver_method METHODS[2] = {SN_SOLVER_XPBD, SN_SOLVER_QN};

/* A rod across the fusiform's middle, beside it (x), so deep in it when it has come there. */
static const double ROD = 0.02;

static void make_pressed(sn_scene *scene, sn_solver_method method, double depth, double seconds) {
    fusiform small = FUSIFORM;
    small.rings = 15, small.sectors = 10, small.structure = false;
    make_scene(scene, &small);
    turn_contact_on(scene);
    scene->solver = sn_solver_defaults(method);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    double away = 0.002;
    capsule rod = {{{0.03 + ROD + away, -0.08, 0.1}, {0.03 + ROD + away, 0.08, 0.1}}, ROD};
    sn_pose_key *keys = keys_to(0.0, seconds, shifted(sn_v3(-(depth + away), 0, 0)));
    make_capsule(&rod, 8, add_solid(scene, "rod", keys, 2));
}

#define assert_near(a, b, most) assert_true(fabs((a) - (b)) <= (most))

/* How far beyond its margin the worst row is, m. */
static double deepest(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    return sn_rows_residual(m, &s->state->muscles[0], SN_ROWS_CONTACT, NULL).max * m->mean_edge;
}

/* ---- rows --------------------------------------------------------------------------------------------------------------------- */

/* Along random ways of all points: the slope that the gradient says, and that of the energy itself. */
static void gradients_are_of_the_energy(void **state) {
    (void)state;
    sn_scene scene;
    make_pressed(&scene, SN_SOLVER_QN, 0.01, 0.3);
    scene.contact.samples = 1;
    simulation s = start(&scene);
    step_frames(&s, 5, NULL);
    const sn_model_muscle *m = &s.model->muscles[0];
    const sn_muscle_state *muscle = &s.state->muscles[0];
    assert_true(muscle->inputs->near_count > 20);
    sn_point *at = SN_NEW(sn_point, m->point_count);
    sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count), *way = SN_NEW(sn_vec3, m->point_count);
    uint64_t random = 5;
    for (int trial = 0; trial < 10; trial++) {
        double energies[2], slope = 0.0, step = 1e-8, k = 5e3;
        for (sn_index i = 0; i < muscle->inputs->near_count; i++) muscle->inputs->multipliers[muscle->inputs->near[i]] = sn_random(&random);
        memset(gradient, 0, (size_t)m->point_count * sizeof *gradient);
        memcpy(at, muscle->points, (size_t)m->point_count * sizeof *at);
        for (sn_index i = 0; i < m->point_count; i++) { /* off the margin, where the projection has left them */
            at[i].x += 2e-3 * sn_random(&random);
            way[i] = sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, sn_random(&random) - 0.5);
        }
        assert_true(sn_rows_contact.energy(m, muscle, SN_ROWS_CONTACT, at, k, (sn_forces){&gradient->x, 3}) > 0.0);
        for (sn_index i = 0; i < m->point_count; i++) slope += sn_dot(gradient[i], way[i]);
        for (int side = 0; side < 2; side++) {
            for (sn_index i = 0; i < m->point_count; i++)
                sn_put(&at[i], sn_add_scaled(sn_point_position(&at[i]), way[i], side == 0 ? -step : 2.0 * step));
            energies[side] = sn_rows_contact.energy(m, muscle, SN_ROWS_CONTACT, at, k, (sn_forces){NULL, 3});
        }
        assert_true(fabs((energies[1] - energies[0]) / (2.0 * step) - slope) < 1e-5 * (1.0 + fabs(slope)));
    }
    free(at);
    free(gradient);
    free(way);
    finish(&s);
}

/* Bones push and never pull; after every step no vertex is in them. */
static void bones_push_and_are_not_entered(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_pressed(&scene, METHODS[i], 0.01, 0.4);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        double most = 0.0;
        for (int frame = 0; frame < 24; frame++) {
            step_frames(&s, 1, NULL);
            assert_true(deepest(&s) < 1e-9);
            for (sn_index r = 0; m->quasi_newton && r < m->contact_count; r++) {
                assert_true(inputs_of(&s)->multipliers[r] >= 0.0);
                most = fmax(most, inputs_of(&s)->multipliers[r]);
            }
        }
        assert_true(!m->quasi_newton || most > 0.0);
        assert_true(s.state->muscles[0].statistics.contacts > 0);
        assert_true(greatest_move(&s) > 0.005); /* it has gone out of the way */
        finish(&s);
    }
}

/* A ball around the lower tip, as the bone that holds it, and as one that does not. */
static void what_hangs_on_a_bone_does_not_feel_it_there(void **state) {
    (void)state;
    sn_scene scene;
    capsule ball = {{{0, 0, 0}, {0, 0, 0}}, 0.04};
    make_scene(&scene, &FUSIFORM);
    turn_contact_on(&scene);
    make_capsule(&ball, 6, &scene.bones[1].mesh);
    scene.bones[1].passable = false;
    make_capsule(&ball, 6, add_solid(&scene, "ball", NULL, 0));
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    const sn_contacts *contacts = sn_contacts_of(m);
    const sn_attachment *lower = &scene.muscles[0].rig.attachments[1];
    double top = 0.0, spacing = FUSIFORM.length / (FUSIFORM.rings + 1.0), lowest[2] = {INFINITY, INFINITY};
    for (sn_index i = 0; i < lower->count; i++) top = fmax(top, m->rest[lower->vertices[i]].z);
    assert_int_equal(m->collider_count, 2);
    for (sn_index c = 0; c < 2; c++)
        for (sn_index r = contacts->colliders[c].begin; r < contacts->colliders[c].end; r++)
            lowest[c] = fmin(lowest[c], m->rest[contacts->rows[r].point[0]].z);
    assert_int_equal(contacts->colliders[0].bone, 1);
    assert_near(lowest[0], top + 3.0 * spacing, 1e-9); /* two rings of edges are left out */
    assert_near(lowest[1], top + spacing, 1e-9);       /* the other one holds all that is free */
    finish(&s);
}

/* ---- what overlaps at rest ------------------------------------------------------------------------------------------------- */

static void make_overlap(sn_scene *scene, sn_solver_method method, double resolve, capsule *ball) {
    fusiform small = FUSIFORM;
    small.rings = 15, small.sectors = 10, small.structure = false;
    make_scene(scene, &small);
    turn_contact_on(scene);
    scene->solver = sn_solver_defaults(method);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    scene->contact.margin = 0.001;
    scene->contact.resolve = resolve;
    *ball = (capsule){{{0.045, 0, 0.1}, {0.045, 0, 0.1}}, 0.02}; /* 5 mm deep */
    make_capsule(ball, 12, add_solid(scene, "ball", NULL, 0));
}

static double nearest(const simulation *s, const capsule *bone) {
    double least = INFINITY;
    for (sn_index v = 0; v < s->model->muscles[0].vertex_count; v++) least = fmin(least, capsule_distance(bone, position(s, v)));
    return least;
}

static void what_overlaps_at_rest_stays(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        capsule ball;
        make_overlap(&scene, METHODS[i], 0.0, &ball);
        simulation s = start(&scene);
        double before = nearest(&s, &ball);
        assert_true(before < -0.001);
        step_frames(&s, 12, NULL);
        assert_true(greatest_move(&s) < 1e-9);
        assert_true(s.state->muscles[0].statistics.penetration < 1e-9);
        finish(&s);
    }
}

/* Margins grow evenly from where they were at rest to what is asked: half of it after half of the time. */
static void overlap_is_resolved_in_time(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        capsule ball;
        make_overlap(&scene, METHODS[i], 1.0, &ball);
        simulation s = start(&scene);
        double before = nearest(&s, &ball);
        step_frames(&s, 12, NULL);
        assert_true(nearest(&s, &ball) > 0.5 * (before + 0.001) - 3e-4); /* as exact as the field and the ball's facets */
        assert_true(nearest(&s, &ball) < 0.0);
        step_frames(&s, 12, NULL);
        assert_true(nearest(&s, &ball) > 0.001 - 3e-4);
        step_frames(&s, 12, NULL);
        assert_true(nearest(&s, &ball) > 0.001 - 3e-4 && nearest(&s, &ball) < 0.001 + 3e-4);
        finish(&s);
    }
}

/* ---- reach, sleep, stopping, off ------------------------------------------------------------------------------------------- */

static void far_bones_are_left_out(void **state) {
    (void)state;
    sn_scene scene;
    make_pressed(&scene, SN_SOLVER_QN, 0.01, 0.4);
    capsule far = {{{1, 0, 0}, {1, 0, 0}}, 0.02};
    make_capsule(&far, 4, add_solid(&scene, "far", NULL, 0));
    simulation s = start(&scene);
    assert_int_equal(s.model->muscles[0].collider_count, 1);
    assert_int_equal(s.model->plan.muscles[0].bone_count, 1);
    assert_int_equal(s.model->plan.muscles[0].bones[0], 2);
    assert_non_null(sn_model_field(s.model, 2));
    assert_null(sn_model_field(s.model, 3));
    finish(&s);
}

/* A muscle at rest, two bones that come after a second: one to it, the other not. */
static void sleepers_wake_for_what_comes(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int comes = 0; comes < 2; comes++) {
            sn_scene scene;
            capsule ball = {{{0.08, 0, 0.1}, {0.08, 0, 0.1}}, 0.02};
            make_scene(&scene, &FUSIFORM);
            turn_contact_on(&scene);
            scene.solver = sn_solver_defaults(METHODS[i]);
            scene.last_frame = 40;
            make_capsule(&ball, 6,
                         add_solid(&scene, "ball", keys_to(1.0, 1.4, shifted(comes ? sn_v3(-0.035, 0, 0) : sn_v3(-0.01, 0, 0))), 2));
            simulation s = start(&scene);
            assert_int_equal(s.model->muscles[0].collider_count, 1);
            step_frames(&s, 24, NULL);
            assert_true(s.state->muscles[0].statistics.asleep);
            step_frames(&s, 14, NULL);
            assert_int_equal(s.state->muscles[0].statistics.asleep, !comes);
            assert_int_equal(greatest_move(&s) > 1e-3, comes);
            assert_true(deepest(&s) < 1e-9);
            finish(&s);
        }
}

/* In the middle of a substep, through bytes and in another state. */
static void a_step_goes_on_where_it_stopped(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_pressed(&scenes[k], METHODS[i], 0.015, 0.2);
            scenes[k].solver.iterations = 3;
            runs[k] = start(&scenes[k]);
        }
        for (int frame = 0; frame < 8; frame++) {
            const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 1 + frame % 2};
            step_frames(&runs[0], 1, NULL);
            stop_and_reload(&runs[1], &stop);
            step_frames(&runs[1], 1, NULL);
            assert_same_muscle(&runs[0], 0, &runs[1], 0);
        }
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

static void off_is_absent(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        make_pressed(&scenes[0], METHODS[i], 0.015, 0.2);
        make_pressed(&scenes[1], METHODS[i], 0.015, 0.2);
        scenes[0].contact = (sn_contact_settings){.enabled = false};
        scenes[1].bones[2].passable = true;
        for (int k = 0; k < 2; k++) {
            set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, 0.3, -0.4);
            runs[k] = start(&scenes[k]);
            step_frames(&runs[k], 8, NULL);
            assert_int_equal(runs[k].model->muscles[0].contact_count, 0);
        }
        assert_same_muscle(&runs[0], 0, &runs[1], 0);
        assert_int_equal(sn_group_state_bytes(runs[0].model, &runs[0].model->groups[0]),
                         sn_group_state_bytes(runs[1].model, &runs[1].model->groups[0]));
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

/* ---- friction --------------------------------------------------------------------------------------------------------------- */

/* A stiff cube of 4 cm on a plane that is tilted by `tilt`: it is the weight that is. */
static void make_block(sn_scene *scene, double friction, double tilt) {
    make_scene(scene, &FUSIFORM);
    sn_scene_muscle *m = &scene->muscles[0];
    sn_muscle_free(&m->rig);
    m->rig = (sn_muscle){.name = sn_strdup("block"), .meters_per_unit = 1.0, .has_attachments = true};
    make_box(sn_v3(-0.02, -0.02, 0.0002), sn_v3(0.02, 0.02, 0.0402), &m->rig.mesh);
    turn_contact_on(scene);
    m->stiffness_relaxed = m->stiffness_active = 1e6;
    m->damping = 0.0;
    scene->contact.friction = friction;
    scene->contact.margin = 0.0002;
    scene->contact.cell = 0.005;
    scene->gravity = sn_v3(9.81 * sn_sin(tilt), 0, -9.81 * sn_cos(tilt));
    make_box(sn_v3(-0.2, -0.2, -0.1), sn_v3(0.2, 0.2, 0.0), add_solid(scene, "plane", NULL, 0));
}

static sn_vec3 middle_of(const simulation *s) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index v = 0; v < s->model->muscles[0].vertex_count; v++)
        sum = sn_add_scaled(sum, position(s, v), 1.0 / s->model->muscles[0].vertex_count);
    return sum;
}

/* How far the block slides down in a quarter of a second, m. */
static double slide(double friction, double tilt) {
    sn_scene scene;
    make_block(&scene, friction, tilt);
    simulation s = start(&scene);
    double before = middle_of(&s).x;
    step_frames(&s, 6, NULL);
    double way = middle_of(&s).x - before;
    assert_true(deepest(&s) < 1e-9);
    finish(&s);
    return way;
}

/* Coulomb: it sticks below the cone's angle; above it, and without friction, it slides as fast as the law says. */
static void blocks_slide_above_the_cone_only(void **state) {
    (void)state;
    double t2 = 0.25 * 0.25 / 2.0, steep = 0.6, flat = 0.35; /* rad; the cone's is atan 0.5 = 0.464 */
    assert_true(fabs(slide(0.5, flat)) < 2e-4);
    double free_fall = 9.81 * sn_sin(steep) * t2, rubbed = free_fall - 0.5 * 9.81 * sn_cos(steep) * t2;
    assert_near(slide(0.0, steep), free_fall, 0.05 * free_fall);
    assert_near(slide(0.5, steep), rubbed, 0.1 * free_fall);
}

/* Without friction a plane takes no momentum along it, and what falls on it does not bounce higher than it came from. */
static void momentum_along_a_plane_is_kept(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_block(&scene, 0.0, 0.0);
        scene.solver = sn_solver_defaults(METHODS[i]);
        simulation s = start(&scene);
        sn_muscle_state *m = &s.state->muscles[0];
        double height = middle_of(&s).z;
        for (sn_index v = 0; v < s.model->muscles[0].point_count; v++) m->velocities[v] = sn_v3(0.1, 0.05, 0.0);
        sn_vec3 before = middle_of(&s);
        for (int frame = 0; frame < 12; frame++) {
            step_frames(&s, 1, NULL);
            assert_true(middle_of(&s).z < height + 1e-4 && middle_of(&s).z > 0.015);
        }
        sn_vec3 way = sn_sub(middle_of(&s), before);
        assert_near(way.x, 0.05, 5e-4);
        assert_near(way.y, 0.025, 5e-4);
        finish(&s);
    }
}

/* However stiff a free block is, and however many iterations it gets, it lies where it lay: 1e6 N/m threw one 15 m high. */
static void stiff_blocks_lie_still(void **state) {
    (void)state;
    static const double stiffness[] = {1e4, 1e6};
    for (int i = 0; i < 4; i++) {
        sn_scene scene;
        make_block(&scene, 0.0, 0.0);
        scene.solver = sn_solver_defaults(SN_SOLVER_QN);
        scene.solver.iterations = i % 2 == 0 ? 10 : 100;
        scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = stiffness[i / 2];
        simulation s = start(&scene);
        for (int frame = 0; frame < 24; frame++) {
            step_frames(&s, 1, NULL);
            assert_near(middle_of(&s).z, 0.0202, 2e-5);
        }
        finish(&s);
    }
}

/* What is dropped fast is stopped by a bone thinner than its way in a step. */
static void what_falls_is_caught(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_block(&scene, 0.0, 0.0);
        scene.solver = sn_solver_defaults(METHODS[i]);
        scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = 1e4;
        sn_mesh *plate = &scene.bones[2].mesh;
        for (sn_index v = 0; v < plate->vertex_count; v++) plate->positions[v].z *= 0.1; /* 1 cm */
        simulation s = start(&scene);
        sn_muscle_state *m = &s.state->muscles[0];
        for (sn_index v = 0; v < s.model->muscles[0].point_count; v++) {
            m->points[v].z += 0.05;
            m->velocities[v] = sn_v3(0, 0, -3.0);
        }
        step_frames(&s, 12, NULL);
        for (sn_index v = 0; v < s.model->muscles[0].vertex_count; v++) assert_true(position(&s, v).z > 0.0);
        finish(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_are_of_the_energy),
        cmocka_unit_test(bones_push_and_are_not_entered),
        cmocka_unit_test(what_hangs_on_a_bone_does_not_feel_it_there),
        cmocka_unit_test(what_overlaps_at_rest_stays),
        cmocka_unit_test(overlap_is_resolved_in_time),
        cmocka_unit_test(far_bones_are_left_out),
        cmocka_unit_test(sleepers_wake_for_what_comes),
        cmocka_unit_test(a_step_goes_on_where_it_stopped),
        cmocka_unit_test(off_is_absent),
        cmocka_unit_test(blocks_slide_above_the_cone_only),
        cmocka_unit_test(momentum_along_a_plane_is_kept),
        cmocka_unit_test(stiff_blocks_lie_still),
        cmocka_unit_test(what_falls_is_caught),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
