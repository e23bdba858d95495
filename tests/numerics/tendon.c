/*
 * tendon.c -- what substeps of their own save: a strap 2 mm thick with edges of 1.2 mm, one end of it moved. Usage: tendon
 *
 * For each motion the work of `--substeps auto` beside that of 1, 2 and 4 substeps: iterations, and 4 for each factor of a matrix, which
 * takes about as long. It is at most 1.15 times that of the best number that leaves no triangle below 5 % of its rest area, and leaves none
 * itself. Prints a line for each, then "N passed, N failed".
 */
#include "../unit/sim_scene.h"

#include <stdio.h>

static const double LENGTH = 0.12, WIDTH = 0.008, THICKNESS = 0.002, EDGE = 0.0012;
static const double PINNED = 0.004; /* m, at each end */
enum { ALONG = 100, ACROSS = 7, THROUGH = 2, AROUND = 2 * (ACROSS + THROUGH), FRAMES = 30 };

static int passed, failed;

/* ---- the strap: rings of AROUND vertices, closed by a fan from the middle of each end ------------------------------------------------ */

static sn_vec3 corner(int k, double z) {
    double x = k < ACROSS ? k : k < ACROSS + THROUGH ? ACROSS : k < 2 * ACROSS + THROUGH ? 2 * ACROSS + THROUGH - k : 0;
    double y = k < ACROSS ? 0 : k < ACROSS + THROUGH ? k - ACROSS : k < 2 * ACROSS + THROUGH ? THROUGH : AROUND - k;
    return sn_v3(WIDTH * (x / ACROSS - 0.5), THICKNESS * (y / THROUGH - 0.5), z);
}

static void add_triangle(sn_mesh *mesh, sn_index *count, sn_index a, sn_index b, sn_index c) {
    mesh->triangles[(*count)++] = (sn_triangle){{a, b, c}};
}

static void make_strap_surface(sn_mesh *mesh) {
    const sn_index rings = ALONG + 1, low = rings * AROUND, high = low + 1;
    sn_index count = 0;
    assert_int_equal(sn_mesh_alloc(mesh, rings * AROUND + 2, 2 * ALONG * AROUND + 2 * AROUND, NULL), SN_OK);
    for (sn_index r = 0; r < rings; r++)
        for (int k = 0; k < AROUND; k++) mesh->positions[r * AROUND + k] = corner(k, LENGTH * r / ALONG);
    mesh->positions[low] = sn_v3(0, 0, -0.5 * EDGE);
    mesh->positions[high] = sn_v3(0, 0, LENGTH + 0.5 * EDGE);
    for (int k = 0; k < AROUND; k++) {
        int next = (k + 1) % AROUND;
        add_triangle(mesh, &count, low, next, k);
        add_triangle(mesh, &count, high, ALONG * AROUND + k, ALONG * AROUND + next);
        for (sn_index r = 0; r < ALONG; r++) {
            sn_index a = r * AROUND + k, b = r * AROUND + next, c = a + AROUND, d = b + AROUND;
            add_triangle(mesh, &count, a, b, (r + k) % 2 == 0 ? d : c);
            add_triangle(mesh, &count, (r + k) % 2 == 0 ? a : b, d, c);
        }
    }
}

static void pin(sn_muscle *muscle, int i, const char *bone, double low, double high) {
    sn_attachment *a = &muscle->attachments[i];
    *a = (sn_attachment){.bone = sn_strdup(bone), .method = sn_strdup("pin"), .vertices = SN_NEW(sn_index, muscle->mesh.vertex_count)};
    for (sn_index v = 0; v < muscle->mesh.vertex_count; v++) {
        double z = muscle->mesh.positions[v].z;
        if (z >= low && z <= high) a->vertices[a->count++] = v;
    }
}

/* ---- its motions --------------------------------------------------------------------------------------------------------- */

typedef enum motion { SWING, SIDEWAYS, SLACKEN, FOLD } motion;

/* After so many frames at `speed`, m a frame. */
static sn_rigid pose_at(motion kind, double speed, int frame) {
    double way = speed * frame, angle = way / (kind == FOLD ? 0.02 : 0.5 * LENGTH), z = kind == FOLD ? LENGTH - 0.02 : 0.5 * LENGTH;
    switch (kind) {
    case SIDEWAYS:
        return (sn_rigid){sn_quat_identity(), sn_v3(0, way, 0)};
    case SLACKEN: /* to half of its length, then still */
        return (sn_rigid){sn_quat_identity(), sn_v3(0, 0, -fmin(way, 0.5 * LENGTH))};
    default: /* about an axis across the strap, in its middle, or 20 mm from the end */
        return (sn_rigid){sn_quat_axis_angle(sn_v3(1, 0, 0), angle), sn_v3(0, z * sin(angle), z - z * cos(angle))};
    }
}

static void make_tendon(sn_scene *scene, motion kind, double speed, sn_index substeps) {
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.substeps = substeps;
    sn_muscle *rig = &scene->muscles[0].rig;
    sn_muscle_free(rig);
    *rig = (sn_muscle){.name = sn_strdup("tendon"), .meters_per_unit = 1.0, .has_attachments = true, .attachment_count = 2};
    rig->attachments = SN_NEW(sn_attachment, 2);
    make_strap_surface(&rig->mesh);
    pin(rig, 0, "upper", -1.0, PINNED);
    pin(rig, 1, "lower", LENGTH - PINNED, 1.0);
    sn_joint *joint = &scene->motion.joints[0];
    joint->kind = SN_JOINT_POSE;
    joint->key_count = FRAMES + 1;
    joint->keys = SN_NEW(sn_pose_key, FRAMES + 1);
    for (int f = 0; f <= FRAMES; f++) joint->keys[f] = (sn_pose_key){f / scene->rate, pose_at(kind, speed, f)};
}

/* ---- what a run costs ---------------------------------------------------------------------------------------------------- */

typedef struct cost {
    int64_t steps, work;
    double smallest;
} cost;

static cost run(motion kind, double speed, sn_index substeps) {
    sn_scene scene;
    make_tendon(&scene, kind, speed, substeps);
    simulation s = start(&scene);
    cost sum = {.smallest = INFINITY};
    for (int f = 0; f < FRAMES; f++) {
        step_frames(&s, 1, NULL);
        const sn_statistics *st = &s.state->muscles[0].statistics;
        sum.steps += st->steps;
        sum.work += st->iterations + 4 * st->refactorisations;
        sum.smallest = fmin(sum.smallest, st->smallest_triangle);
    }
    finish(&s);
    return sum;
}

static void compare(const char *name, motion kind, double speed) {
    static const sn_index NUMBERS[] = {1, 2, 4};
    cost automatic = run(kind, speed, SN_SUBSTEPS_AUTO), best = {.work = INT64_MAX};
    for (int i = 0; i < 3; i++) {
        cost c = run(kind, speed, NUMBERS[i]);
        if (c.smallest > 0.05 && c.work < best.work) best = c;
    }
    bool good = automatic.smallest > 0.05 && (double)automatic.work <= 1.15 * (double)best.work;
    printf("%-9s %3.0f mm a frame  auto: %3d steps, work %4d, least triangle %.2f; best number %d: work %4d, %.2f  %s\n", name, 1e3 * speed,
           (int)automatic.steps, (int)automatic.work, automatic.smallest, (int)best.steps / FRAMES, (int)best.work, best.smallest,
           good ? "passed" : "FAILED");
    good ? passed++ : failed++;
}

int main(void) {
    static const double SPEEDS[] = {0.003, 0.012};
    for (int i = 0; i < 2; i++) {
        compare("swing", SWING, SPEEDS[i]);
        compare("sideways", SIDEWAYS, SPEEDS[i]);
        compare("slacken", SLACKEN, SPEEDS[i]);
        compare("fold", FOLD, SPEEDS[i]);
    }
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
