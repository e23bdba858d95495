/*
 * xpbd_extremes.c -- numerics.md 5, column `xpbd`, the cases without bones in the way, on the generated fusiform muscle.
 *
 * A case passes when every frame is finite, no point is ever farther than 2 L from where the muscle's bones have
 * been, and, where the inputs go back to normal, the muscle does too. Prints a table, then "N passed, N failed".
 */
#include "../unit/sim_scene.h"

#include <stdio.h>

static int passed, failed;

static void verdict(const char *name, bool good, double far, double error) {
    printf("%-58s %s  farthest %.2e L  error %.2e\n", name, good ? "passed" : "FAILED", far, error);
    if (good)
        passed++;
    else
        failed++;
}

/* The box of the attached points, grown by where they are now. */
static void grow(const simulation *s, sn_box *box) {
    const sn_model_muscle *m = &s->model->muscles[0];
    for (sn_index i = 0; i < m->kinematic_count; i++) {
        box->low = sn_min3(box->low, position(s, m->kinematic_points[i]));
        box->high = sn_max3(box->high, position(s, m->kinematic_points[i]));
    }
}

/* Greatest distance of a point from the box, over L; infinite where a point is not finite. */
static double farthest(const simulation *s, sn_box box) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = position(s, i);
        if (!sn_finite3(p)) return INFINITY;
        most = fmax(most, sn_distance(p, sn_max3(box.low, sn_min3(p, box.high))));
    }
    return most / m->diagonal;
}

/* RMS distance from the rest pose, over L. */
static double rest_error(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double sum = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) sum += sn_norm2(sn_sub(position(s, i), m->rest[i]));
    return sqrt(sum / m->point_count) / m->diagonal;
}

static double run(simulation *s, sn_index frames) {
    sn_box box = {sn_v3(INFINITY, INFINITY, INFINITY), sn_v3(-INFINITY, -INFINITY, -INFINITY)};
    double far = 0.0;
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        grow(s, &box);
        far = fmax(far, farthest(s, box));
    }
    return far;
}

/* ---- stiffness, step, activation ------------------------------------------------------------------------------------------ */

static void stiffness_and_step(void) {
    static const double stiffness[] = {0, 1, 1e3, 5e5, 1e9, 1e12}, steps[] = {1.0 / 24, 1.0 / 240, 1e-3, 1e-5};
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 4; j++) {
            sn_scene scene;
            char name[80];
            make_scene(&scene, &FUSIFORM);
            scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = stiffness[i];
            scene.muscles[0].activation.constant = 0.5;
            set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 20.0 * steps[j], -0.5);
            scene.rate = 1.0 / (steps[j] * scene.solver.substeps);
            simulation s = start(&scene);
            double far = run(&s, 20);
            snprintf(name, sizeof name, "stiffness %g N/m, step %.3g s", stiffness[i], steps[j]);
            verdict(name, far < 2.0, far, 0.0);
            finish(&s);
        }
    }
}

static void activations(void) {
    static const double levels[] = {0, 0.5, 0.95, 0.99};
    for (int law = 0; law < 3; law++) {
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                sn_scene scene;
                char name[80];
                make_scene(&scene, &FUSIFORM);
                scene.muscles[0].law = (sn_fiber_law)law;
                scene.muscles[0].contraction = 0.99;
                scene.muscles[0].rest_activation = levels[j] / 0.99;
                set_keys(&scene.muscles[0].activation, 0.0, levels[j] / 0.99, 0.5, levels[i] / 0.99);
                simulation s = start(&scene);
                double far = run(&s, 24);
                snprintf(name, sizeof name, "a %g from a0 %g, law %s", levels[i], levels[j], sn_fiber_law_name(scene.muscles[0].law));
                double longer = (1.0 - levels[i]) / (1.0 - levels[j]); /* a muscle at rest at a0 = 0.99 wants to be 100 times as long */
                verdict(name, far < 2.0 * fmax(1.0, longer), far, 0.0);
                finish(&s);
            }
        }
    }
}

/* ---- violent motion, and back ------------------------------------------------------------------------------------------------ */

static void move_and_return(const char *name, sn_rigid away, sn_index frames_away, double limit) {
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    sn_joint *joint = &scene.motion.joints[0];
    double back = frames_away / scene.rate, instant = 1e-6;
    sn_pose_key *keys = SN_NEW(sn_pose_key, 4);
    keys[0] = (sn_pose_key){1.0 / 24 - instant, sn_rigid_identity()};
    keys[1] = (sn_pose_key){1.0 / 24, away};
    keys[2] = (sn_pose_key){1.0 / 24 + back - instant, away};
    keys[3] = (sn_pose_key){1.0 / 24 + back, sn_rigid_identity()};
    *joint = (sn_joint){.name = joint->name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 4, .keys = keys};
    simulation s = start(&scene);
    double far = run(&s, 1 + frames_away + 60), error = rest_error(&s);
    verdict(name, far < limit && error < 5e-2, far, error);
    finish(&s);
}

static void violent_motion(void) {
    sn_rigid right_angle = {sn_quat_axis_angle(sn_v3(1, 0, 0), SN_PI / 2), {0, 0, 0}}, far = {sn_quat_identity(), {10, 0, 0}};
    move_and_return("an end teleports by 90 degrees for 12 frames", right_angle, 12, 2.0);
    move_and_return("an end jumps 50 L away for 20 frames", far, 20, 2.0);
}

/* ---- ugly starts ----------------------------------------------------------------------------------------------------------------- */

static sn_vec3 flattened(sn_vec3 p, uint64_t *random) {
    (void)random;
    return sn_v3(p.x, 0, p.z);
}
static sn_vec3 in_one_point(sn_vec3 p, uint64_t *random) {
    (void)random;
    (void)p;
    return sn_v3(0, 0, 0.1);
}
static sn_vec3 shaken(sn_vec3 p, uint64_t *random) {
    return sn_add(p, sn_v3(0.02 * (sn_random(random) - 0.5), 0.02 * (sn_random(random) - 0.5), 0.02 * (sn_random(random) - 0.5)));
}

static void start_from(const char *name, sn_vec3 (*place)(sn_vec3 rest, uint64_t *random), double tolerance) {
    sn_scene scene;
    uint64_t random = 1;
    make_scene(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = place(m->rest[i], &random);
        if (m->inverse_mass[i] > 0.0) s.state->muscles[0].points[i] = (sn_point){p.x, p.y, p.z, m->inverse_mass[i]};
    }
    double far = run(&s, 120), error = rest_error(&s);
    verdict(name, far < 2.0 && error < tolerance, far, error);
    finish(&s);
}

static void ugly_starts(void) {
    start_from("start: all points coincide", in_one_point, 5e-2);
    start_from("start: flattened to a plane", flattened, 5e-2);
    start_from("start: every point moved by up to 10 mm", shaken, 5e-2);
}

int main(void) {
    stiffness_and_step();
    activations();
    violent_motion();
    ugly_starts();
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
