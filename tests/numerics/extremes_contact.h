/*
 * extremes_contact.h -- the rows of numerics.md 5 with bones in the way; part of sim_extremes.c.
 *
 * A fusiform muscle of 400 triangles and 500 N/m, and bones that press on it. In every case all stays finite and within 2 L of the bones;
 * no vertex is left beyond its margin by more than 1e-6 m; no bone's axis is left inside the muscle: it would have been pierced.
 */
#ifndef EXTREMES_CONTACT_H
#define EXTREMES_CONTACT_H

#include "../unit/contact_scene.h"

enum { MOST_BONES = 2 };

/* The capsules of a scene as they are at rest, and the joints that move them. */
static capsule rods[MOST_BONES];
static int rod_count;

static void make_soft(sn_scene *scene, double pinned) {
    fusiform small = FUSIFORM;
    small.rings = 17, small.sectors = 12, small.structure = false, small.pinned = pinned;
    make_scene(scene, &small);
    turn_contact_on(scene);
    scene->solver = sn_solver_defaults(solver);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    scene->last_frame = 200;
    rod_count = 0;
}

/* Along y; x, z: of its axis. keys: nullable, taken. */
static void add_rod(sn_scene *scene, double x, double z, double radius, sn_pose_key *keys, sn_index key_count) {
    rods[rod_count] = (capsule){{{x, -0.08, z}, {x, 0.08, z}}, radius};
    make_capsule(&rods[rod_count], 6, add_solid(scene, rod_count == 0 ? "rod" : "other rod", keys, key_count));
    rod_count++;
}

/* How often the muscle's surface winds around p. */
static double winding(const simulation *s, sn_vec3 p) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double sum = 0.0;
    for (sn_index t = 0; t < m->triangle_count; t++) {
        sn_vec3 a = sn_sub(position(s, m->triangles[t].v[0]), p), b = sn_sub(position(s, m->triangles[t].v[1]), p);
        sn_vec3 c = sn_sub(position(s, m->triangles[t].v[2]), p);
        double x = sn_norm(a), y = sn_norm(b), z = sn_norm(c);
        sum += 2.0 * atan2(sn_dot(a, sn_cross(b, c)), x * y * z + sn_dot(a, b) * z + sn_dot(b, c) * x + sn_dot(c, a) * y);
    }
    return sum / (4.0 * SN_PI);
}

/* Is a point of a bone's axis inside the muscle's surface? */
static bool is_pierced(const simulation *s) {
    for (int i = 0; i < rod_count; i++) {
        sn_index joint = s->scene->bones[s->scene->bone_count - rod_count + i].joint;
        sn_rigid pose =
            joint == SN_NONE ? sn_rigid_identity() : sn_motion_run_in_pose(&s->scene->motion, joint, s->state->frame / s->scene->rate, 1.0);
        for (int k = 0; k <= 40; k++) {
            sn_vec3 p = sn_add_scaled(rods[i].end[0], sn_sub(rods[i].end[1], rods[i].end[0]), k / 40.0);
            if (fabs(winding(s, sn_rigid_apply(pose, p))) > 0.5) return true;
        }
    }
    return false;
}

/* How far beyond its margin the worst row is, m. */
static double deepest(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    return sn_rows_residual(m, &s->state->muscles[0], SN_ROWS_CONTACT, NULL).max * m->mean_edge;
}

/* Greatest distance of a point from the middle of the rest pose, over L. */
static double strayed(const simulation *s) {
    double most = 0.0;
    for (sn_index i = 0; i < s->model->muscles[0].point_count; i++) {
        if (!sn_finite3(position(s, i))) return INFINITY;
        most = fmax(most, sn_distance(position(s, i), sn_v3(0, 0, 0.1)));
    }
    return most / s->model->muscles[0].diagonal;
}

static double fastest(const simulation *s) {
    double most = 0.0;
    for (sn_index i = 0; i < s->model->muscles[0].point_count; i++) most = fmax(most, sn_norm(s->state->muscles[0].velocities[i]));
    return most / s->model->muscles[0].diagonal;
}

typedef struct pressing {
    double far, deepest; /* the greatest after any frame: over L; m */
} pressing;

static void press(simulation *s, sn_index frames, pressing *sum) {
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        sum->far = fmax(sum->far, strayed(s));
        sum->deepest = fmax(sum->deepest, deepest(s));
    }
}

static bool holds(const simulation *s, const pressing *sum) { return sum->far < 2.0 && sum->deepest < 1e-6 && !is_pierced(s); }

static void contact_verdict(const char *name, simulation *s, const pressing *sum, bool good, double error) {
    char remark[120];
    snprintf(remark, sizeof remark, "contact: deepest %.2g mm, smallest triangle %.3f%s", 1e3 * sum->deepest,
             s->state->muscles[0].statistics.smallest_triangle, is_pierced(s) ? ", PIERCED" : "");
    verdict(name, good && holds(s, sum), sum->far, error, remark);
    finish(s);
}

/* ---- bones that jump and spin -------------------------------------------------------------------------------------------- */

/* From beside the muscle into its middle, out on the other side, and back to where it was: each in the time from one frame to the next. */
static void teleports(void) {
    static const double ways[4] = {0.0, -0.06, -0.12, 0.0};
    sn_pose_key *keys = SN_NEW(sn_pose_key, 8);
    for (int i = 0; i < 4; i++) {
        keys[2 * i] = (sn_pose_key){i / 2.0, shifted(sn_v3(ways[i], 0, 0))};
        keys[2 * i + 1] = (sn_pose_key){(i + 1) / 2.0 - 1.0 / 24.0, shifted(sn_v3(ways[i], 0, 0))};
    }
    sn_scene scene;
    make_soft(&scene, FUSIFORM.pinned);
    add_rod(&scene, 0.06, 0.1, 0.01, keys, 8);
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 23, &sum);
    bool good = holds(&s, &sum); /* in it */
    press(&s, 12, &sum);
    good = good && holds(&s, &sum); /* through it */
    press(&s, 13 + 60, &sum);
    double error = rest_error(&s);
    contact_verdict("contact: a bone teleports into, through and out", &s, &sum, good && error < most_error(), error);
}

/* About its own length, so that nothing of it comes nearer: as if it did not. */
static void spins(void) {
    sn_vec3 at[2000];
    double error = 0.0;
    for (int spinning = 0; spinning < 2; spinning++) {
        sn_pose_key *keys = SN_NEW(sn_pose_key, 61);
        for (int i = 0; i < 61; i++) {
            double in = -0.012 * fmin(1.0, i / 12.0);
            sn_quat turn = sn_quat_axis_angle(sn_v3(0, 1, 0), spinning * i * SN_PI / 9.0);
            sn_vec3 axis = sn_v3(0.052, 0, 0.1);
            keys[i] = (sn_pose_key){i / 24.0, {turn, sn_add(sn_sub(axis, sn_quat_rotate(turn, axis)), sn_v3(in, 0, 0))}};
        }
        sn_scene scene;
        make_soft(&scene, FUSIFORM.pinned);
        add_rod(&scene, 0.052, 0.1, 0.02, keys, 61);
        simulation s = start(&scene);
        pressing sum = {0};
        press(&s, 60, &sum);
        const sn_model_muscle *m = &s.model->muscles[0];
        for (sn_index i = 0; i < m->point_count; i++) {
            if (spinning) error = fmax(error, sn_distance(at[i], position(&s, i)) / m->diagonal);
            at[i] = position(&s, i);
        }
        contact_verdict(spinning ? "contact: a bone spins by 20 degrees a frame" : "contact: the same bone does not", &s, &sum,
                        error < 5e-3, error);
    }
}

/* ---- bones that bear, squeeze and press ------------------------------------------------------------------------------------- */

/* A free muscle falls 2 cm on two rods, and comes to lie there. */
static void dropped(void) {
    sn_scene scene;
    make_soft(&scene, 0.0);
    scene.gravity = sn_v3(-9.81, 0, 0);
    scene.muscles[0].damping = 5.0;
    add_rod(&scene, -0.06, 0.06, 0.01, NULL, 0);
    add_rod(&scene, -0.06, 0.14, 0.01, NULL, 0);
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 96, &sum);
    double speed = fastest(&s), height = INFINITY, highest = -INFINITY;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
        height = fmin(height, position(&s, i).x), highest = fmax(highest, position(&s, i).x);
    contact_verdict("contact: a muscle dropped on two bones", &s, &sum, highest > -0.06 && height > -0.2 && speed < 0.5, speed);
}

/* Two plates come together by 0.9 mm a frame until the muscle is half as high. */
static void squeezed(void) {
    sn_scene scene;
    make_soft(&scene, FUSIFORM.pinned);
    double seconds = 0.030 / 0.0009 / 24.0;
    for (int side = 0; side < 2; side++) {
        double x = side == 0 ? 0.031 : -0.051, way = side == 0 ? -0.016 : 0.016;
        make_box(sn_v3(x, -0.1, 0.05), sn_v3(x + 0.02, 0.1, 0.15),
                 add_solid(&scene, side == 0 ? "plate" : "other plate", keys_to(0.0, seconds, shifted(sn_v3(way, 0, 0))), 2));
    }
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 48, &sum);
    double widest = 0.0;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
        if (fabs(position(&s, i).z - 0.1) < 0.04) widest = fmax(widest, fabs(position(&s, i).x));
    contact_verdict("contact: squeezed to half its height", &s, &sum,
                    widest < 0.0151 && s.state->muscles[0].statistics.smallest_triangle > 0.01, widest);
}

/* How a rod presses on the muscle 1 cm deep in half a second, and stays. */
static void make_pressed(sn_scene *scene) {
    make_soft(scene, FUSIFORM.pinned);
    add_rod(scene, 0.052, 0.1, 0.02, keys_to(0.0, 0.5, shifted(sn_v3(-0.012, 0, 0))), 2);
}

/* At rest on a bone, awake: no drift, no jitter. */
static void rests(void) {
    sn_scene scene;
    make_pressed(&scene);
    scene.solver.sleep = false;
    scene.gravity = sn_v3(9.81, 0, 0);
    simulation s = start(&scene);
    pressing sum = {0};
    sn_index frames = all_of_it ? 10000 : 300;
    press(&s, frames / 2, &sum);
    sn_vec3 *before = SN_NEW(sn_vec3, s.model->muscles[0].point_count);
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) before[i] = position(&s, i);
    press(&s, frames - frames / 2, &sum);
    double drift = 0.0, speed = fastest(&s);
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++) drift = fmax(drift, sn_distance(before[i], position(&s, i)));
    free(before);
    char name[100];
    snprintf(name, sizeof name, "contact: %d frames at rest, drift %.1e L", (int)frames, drift / s.model->muscles[0].diagonal);
    bool still = solver == SN_SOLVER_XPBD || (speed < 1e-9 && drift / s.model->muscles[0].diagonal < 1e-7);
    contact_verdict(name, &s, &sum, still, speed);
}

static void activated(void) {
    sn_scene scene;
    make_pressed(&scene);
    set_keys(&scene.muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 48, &sum);
    contact_verdict("contact: activation from 0 to 1", &s, &sum, true, fastest(&s));
}

/* ---- every setting of the solver --------------------------------------------------------------------------------------------- */

static void each_setting(void) {
    for (int substeps = 0; substeps < 3; substeps++)
        for (int kind = 0; kind < 3; kind++) {
            bool qn = solver == SN_SOLVER_QN;
            if (!qn && kind == 2) continue;
            sn_scene scene;
            char name[100];
            make_pressed(&scene);
            scene.solver.substeps = qn ? 2 * substeps : 8 << substeps; /* 0: auto */
            if (qn)
                scene.solver.preconditioner = (sn_preconditioning)kind;
            else
                scene.solver.precision = (sn_precision)kind;
            simulation s = start(&scene);
            pressing sum = {0};
            press(&s, 36, &sum);
            snprintf(name, sizeof name, "contact: %s, substeps %d%s", qn ? sn_preconditioning_names[kind] : sn_precision_names[kind],
                     (int)scene.solver.substeps, scene.solver.substeps == 0 ? " (auto)" : "");
            contact_verdict(name, &s, &sum, true, 0.0);
        }
}

static void contacts(void) {
    if (subject != NULL) return; /* they are made for the fusiform muscle */
    teleports();
    spins();
    dropped();
    squeezed();
    rests();
    activated();
    each_setting();
}

#endif
