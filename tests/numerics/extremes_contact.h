/*
 * extremes_contact.h -- the rows of numerics.md 5 with bones in the way; part of sim_extremes.c.
 *
 * A fusiform muscle of 400 triangles and 500 N/m, or a document's with 500 N/m, and bones that press on it. Lengths are the fusiform's,
 * whose radius is 0.03 m and whose length 0.2 m: a document's muscle has them in its own frame, those across it times its thickness, those
 * along times its length. In every case all stays finite and within 2 L of the bones; no vertex is left beyond its margin by more than 1e-6
 * m; no bone's axis is left inside the muscle: it would have been pierced.
 */
#ifndef EXTREMES_CONTACT_H
#define EXTREMES_CONTACT_H

#include "../unit/contact_scene.h"

enum { MOST_BONES = 2 };

/* The capsules of a scene as they are at rest, and the joints that move them. */
static capsule rods[MOST_BONES];
static int rod_count;

/* Where the muscle stands: x across where it is thinnest, z along it, and how long the fusiform's lengths are along each. */
static struct {
    sn_vec3 middle, x, y, z;
    double across, wide, along;
    double swell; /* by how much rods are thicker than the fusiform's, so that they do not slip between vertices */
} stand;

static const double STAND_RADIUS = 0.03, STAND_LENGTH = 0.2;

static sn_vec3 place(double x, double y, double z) {
    sn_vec3 p = sn_add_scaled(stand.middle, stand.x, x * stand.across);
    p = sn_add_scaled(p, stand.y, y * stand.wide);
    return sn_add_scaled(p, stand.z, (z - 0.5 * STAND_LENGTH) * stand.along);
}

static sn_vec3 across(double x) { return sn_scale(stand.x, x * stand.across); }

static double height_of(sn_vec3 p) { return sn_dot(sn_sub(p, stand.middle), stand.x) / stand.across; }

/* Least and greatest height of a rig's vertices within `around` of z. */
static void heights_at(const sn_muscle *rig, double z, double around, double out[2]) {
    out[0] = INFINITY, out[1] = -INFINITY;
    for (sn_index v = 0; v < rig->mesh.vertex_count; v++) {
        sn_vec3 p = sn_scale(rig->mesh.positions[v], rig->meters_per_unit);
        double at = sn_dot(sn_sub(p, stand.middle), stand.z) / stand.along + 0.5 * STAND_LENGTH, height = height_of(p);
        if (fabs(at - z) < around) out[0] = fmin(out[0], height), out[1] = fmax(out[1], height);
    }
}

/* How thick it is about its middle, across a direction. */
static double thickness(const sn_muscle *rig, sn_vec3 direction, double out[2]) {
    stand.x = direction, stand.across = 1.0;
    heights_at(rig, 0.5 * STAND_LENGTH, 0.02, out);
    return out[1] - out[0];
}

/* m */
static double mean_edge_of(const sn_muscle *rig) {
    const sn_mesh *mesh = &rig->mesh;
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            sum += sn_distance(mesh->positions[mesh->triangles[t].v[k]], mesh->positions[mesh->triangles[t].v[(k + 1) % 3]]);
    return sum / (3.0 * mesh->triangle_count) * rig->meters_per_unit;
}

/* Along the way between the farthest ends that two sweeps find; across it where it is thinnest of 18 directions. */
static void stand_on(const sn_muscle *rig) {
    const sn_mesh *mesh = &rig->mesh;
    sn_index end[2] = {0, 0};
    for (int sweep = 0; sweep < 4; sweep++)
        for (sn_index v = 0; v < mesh->vertex_count; v++)
            if (sn_distance(mesh->positions[v], mesh->positions[end[1 - sweep % 2]]) >
                sn_distance(mesh->positions[end[sweep % 2]], mesh->positions[end[1 - sweep % 2]]))
                end[sweep % 2] = v;
    sn_vec3 a = sn_scale(mesh->positions[end[0]], rig->meters_per_unit), b = sn_scale(mesh->positions[end[1]], rig->meters_per_unit);
    stand.middle = sn_scale(sn_add(a, b), 0.5), stand.z = sn_normalize(sn_sub(b, a));
    stand.along = sn_distance(a, b) / STAND_LENGTH;
    sn_vec3 start = sn_normalize(sn_cross(fabs(stand.z.z) < 0.9 ? sn_v3(0, 0, 1) : sn_v3(1, 0, 0), stand.z)), thin = start;
    double least = INFINITY, h[2];
    for (int k = 0; k < 18; k++) {
        sn_vec3 direction = sn_quat_rotate(sn_quat_axis_angle(stand.z, SN_PI * k / 18), start);
        double found = thickness(rig, direction, h);
        if (found < least) least = found, thin = direction;
    }
    stand.y = sn_cross(stand.z, thin);
    stand.wide = fmax(thickness(rig, stand.y, h), least) / (2.0 * STAND_RADIUS);
    stand.middle = sn_add_scaled(stand.middle, stand.y, 0.5 * (h[0] + h[1]));
    thickness(rig, thin, h);
    stand.middle = sn_add_scaled(stand.middle, stand.x, 0.5 * (h[0] + h[1]));
    stand.across = least / (2.0 * STAND_RADIUS);
    stand.swell = fmax(0.0, 2.0 * mean_edge_of(rig) / stand.across - 0.01);
}

/* Of the attachments only what lies at the ends holds: where bones come, they would meet vertices that cannot give way. */
static void hold_by_the_ends(sn_muscle *rig) {
    for (sn_index i = 0; i < rig->attachment_count; i++) {
        sn_attachment *a = &rig->attachments[i];
        sn_index kept = 0;
        for (sn_index k = 0; k < a->count; k++) {
            sn_vec3 p = sn_sub(sn_scale(rig->mesh.positions[a->vertices[k]], rig->meters_per_unit), stand.middle);
            if (fabs(sn_dot(p, stand.z)) > 0.3 * STAND_LENGTH * stand.along) a->vertices[kept++] = a->vertices[k];
        }
        if (kept > 0) a->count = kept;
    }
}

static void let_go(sn_muscle *rig) {
    sn_attachments_free(rig->attachments, rig->attachment_count);
    rig->attachments = NULL;
    rig->attachment_count = 0;
}

static void make_soft(sn_scene *scene, double pinned) {
    if (subject == NULL) {
        fusiform small = FUSIFORM;
        small.rings = 17, small.sectors = 12, small.structure = false, small.pinned = pinned;
        make_scene(scene, &small);
        stand.middle = sn_v3(0, 0, 0.5 * STAND_LENGTH), stand.x = sn_v3(1, 0, 0), stand.y = sn_v3(0, 1, 0), stand.z = sn_v3(0, 0, 1);
        stand.across = stand.wide = stand.along = 1.0, stand.swell = 0.0;
    } else {
        load_subject(scene);
        stand_on(&scene->muscles[0].rig);
        hold_by_the_ends(&scene->muscles[0].rig);
        if (pinned == 0.0) let_go(&scene->muscles[0].rig);
    }
    turn_contact_on(scene);
    scene->solver = sn_solver_defaults(solver);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    scene->last_frame = 200;
    rod_count = 0;
}

/* Along y; x, z: of its axis, to which `swell` comes, away from the muscle. keys: nullable, taken. */
static void add_rod(sn_scene *scene, double x, double z, double radius, sn_pose_key *keys, sn_index key_count) {
    x += x > 0.0 ? stand.swell : -stand.swell;
    rods[rod_count] = (capsule){{place(x, -0.08, z), place(x, 0.08, z)}, (radius + stand.swell) * stand.across};
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
        most = fmax(most, sn_distance(position(s, i), stand.middle));
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
    sn_index touches;    /* frames with contacts: without any, a case says nothing */
} pressing;

static void press(simulation *s, sn_index frames, pressing *sum) {
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        sum->far = fmax(sum->far, strayed(s));
        sum->deepest = fmax(sum->deepest, deepest(s));
        sum->touches += s->state->muscles[0].statistics.contacts > 0;
    }
}

static bool holds(const simulation *s, const pressing *sum) {
    return sum->far < 2.0 && sum->deepest < 1e-6 && sum->touches > 0 && !is_pierced(s);
}

/* What xpbd, far from converged, makes of a document's muscle is told, but for points that are lost or in a bone. */
static void contact_verdict(const char *name, simulation *s, const pressing *sum, bool good, double error) {
    char remark[160];
    snprintf(remark, sizeof remark, "contact: deepest %.2g mm, smallest triangle %.3f, %d frames touching%s", 1e3 * sum->deepest,
             s->state->muscles[0].statistics.smallest_triangle, (int)sum->touches, is_pierced(s) ? ", PIERCED" : "");
    bool reported = subject != NULL && solver == SN_SOLVER_XPBD && sum->far < 2.0 && sum->deepest < 1e-6 && sum->touches > 0;
    if (reported && !(good && holds(s, sum)))
        line(name, "reported", sum->far, error, remark);
    else
        verdict(name, good && holds(s, sum), sum->far, error, remark);
    finish(s);
}

/* ---- bones that jump and spin -------------------------------------------------------------------------------------------- */

/* From beside the muscle into its middle, out on the other side, and back to where it was: each in the time from one frame to the next. */
static void teleports(void) {
    sn_scene scene;
    make_soft(&scene, FUSIFORM.pinned);
    const double ways[4] = {0.0, -0.06 - stand.swell, -0.12 - 2.0 * stand.swell, 0.0};
    sn_pose_key *keys = SN_NEW(sn_pose_key, 8);
    for (int i = 0; i < 4; i++) {
        keys[2 * i] = (sn_pose_key){i / 2.0, shifted(across(ways[i]))};
        keys[2 * i + 1] = (sn_pose_key){(i + 1) / 2.0 - 1.0 / 24.0, shifted(across(ways[i]))};
    }
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
    sn_vec3 *at = NULL;
    double error = 0.0;
    for (int spinning = 0; spinning < 2; spinning++) {
        sn_scene scene;
        make_soft(&scene, FUSIFORM.pinned);
        sn_pose_key *keys = SN_NEW(sn_pose_key, 61);
        for (int i = 0; i < 61; i++) {
            double in = -0.012 * fmin(1.0, i / 12.0);
            sn_quat turn = sn_quat_axis_angle(stand.y, spinning * i * SN_PI / 9.0);
            sn_vec3 axis = place(0.052 + stand.swell, 0, 0.1);
            keys[i] = (sn_pose_key){i / 24.0, {turn, sn_add(sn_sub(axis, sn_quat_rotate(turn, axis)), across(in))}};
        }
        add_rod(&scene, 0.052, 0.1, 0.02, keys, 61);
        simulation s = start(&scene);
        pressing sum = {0};
        press(&s, 60, &sum);
        const sn_model_muscle *m = &s.model->muscles[0];
        if (at == NULL) at = SN_NEW(sn_vec3, m->point_count);
        for (sn_index i = 0; i < m->point_count; i++) {
            if (spinning) error = fmax(error, sn_distance(at[i], position(&s, i)) / m->diagonal);
            at[i] = position(&s, i);
        }
        contact_verdict(spinning ? "contact: a bone spins by 20 degrees a frame" : "contact: the same bone does not", &s, &sum,
                        error < 5e-3, error);
    }
    free(at);
}

/* ---- bones that bear, squeeze and press ------------------------------------------------------------------------------------- */

typedef struct span {
    double low, high;
} span;

/* Between two heights, as far as `width` to either side, over a part of the length. keys: nullable, taken. */
static void add_plate(sn_scene *scene, const char *name, span x, double width, span z, sn_pose_key *keys, sn_index key_count) {
    sn_mesh *plate = add_solid(scene, name, keys, key_count);
    make_box(sn_v3(x.low, -width, z.low), sn_v3(x.high, width, z.high), plate);
    for (sn_index v = 0; v < plate->vertex_count; v++)
        plate->positions[v] = place(plate->positions[v].x, plate->positions[v].y, plate->positions[v].z);
}

/* A free muscle falls 2 cm on two rods, and comes to lie there; a document's, which would roll off them, on a plate. */
static void dropped(void) {
    sn_scene scene;
    make_soft(&scene, 0.0);
    scene.gravity = sn_scale(stand.x, -9.81);
    scene.muscles[0].damping = 5.0;
    if (subject == NULL) {
        add_rod(&scene, -0.06, 0.06, 0.01, NULL, 0);
        add_rod(&scene, -0.06, 0.14, 0.01, NULL, 0);
    } else {
        double h[2];
        heights_at(&scene.muscles[0].rig, 0.5 * STAND_LENGTH, STAND_LENGTH, h);
        add_plate(&scene, "plate", (span){h[0] - 0.08, h[0] - 0.02}, 0.6, (span){-0.2, 0.4}, NULL, 0);
    }
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 96, &sum);
    double speed = fastest(&s), height = INFINITY, highest = -INFINITY;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
        height = fmin(height, height_of(position(&s, i))), highest = fmax(highest, height_of(position(&s, i)));
    contact_verdict("contact: a muscle dropped on two bones", &s, &sum,
                    (subject != NULL || (highest > -0.06 && height > -0.2)) && speed < 0.5, speed);
}

/* Two plates come together by 0.9 mm a frame until the muscle is half as high. */
static void squeezed(void) {
    sn_scene scene;
    make_soft(&scene, FUSIFORM.pinned);
    double h[2] = {-STAND_RADIUS, STAND_RADIUS}, width = subject == NULL ? 0.1 : 0.3;
    if (subject != NULL) heights_at(&scene.muscles[0].rig, 0.5 * STAND_LENGTH, 0.06, h);
    double way = 0.25 * (h[1] - h[0]) + 0.001, middle = 0.5 * (h[0] + h[1]), seconds = 2.0 * (way - 0.001) / 0.0009 / 24.0;
    add_plate(&scene, "plate", (span){h[1] + 0.001, h[1] + 0.021}, width, (span){0.05, 0.15}, keys_to(0.0, seconds, shifted(across(-way))),
              2);
    add_plate(&scene, "other plate", (span){h[0] - 0.021, h[0] - 0.001}, width, (span){0.05, 0.15},
              keys_to(0.0, seconds, shifted(across(way))), 2);
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, (sn_index)(24.0 * seconds) + 15, &sum);
    double widest = 0.0;
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
        if (fabs(sn_dot(sn_sub(position(&s, i), stand.middle), stand.z)) < 0.04 * stand.along)
            widest = fmax(widest, fabs(height_of(position(&s, i)) - middle));
    contact_verdict("contact: squeezed to half its height", &s, &sum,
                    widest < 0.25 * (h[1] - h[0]) + 1e-4 && s.state->muscles[0].statistics.smallest_triangle > 0.01, widest);
}

/* How a rod presses on the muscle 1 cm deep in half a second, and stays. */
static void make_pressed(sn_scene *scene) {
    make_soft(scene, FUSIFORM.pinned);
    add_rod(scene, 0.052, 0.1, 0.02, keys_to(0.0, 0.5, shifted(across(-0.012))), 2);
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
    set_keys(&scene.muscles[0].activation, 0.5, 0.0, 1.5, 1.0); /* when the bone is there */
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 60, &sum);
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
    teleports();
    spins();
    dropped();
    squeezed();
    rests();
    activated();
    each_setting();
}

#endif
