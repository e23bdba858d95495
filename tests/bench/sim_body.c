/*
 * sim_body.c -- a body: 140 muscles of 264 to 270 triangles, each with the structure and the fibre flow that the rig tools make of it.
 * Usage: sim_body [MUSCLES [STIFFNESS]]; 140 and 500 N/m where not given.
 *
 * Each muscle is the fusiform of numerics.md 8, bent, flattened, lopsided and with up to two lobes, by seeded noise, so that its tree
 * branches and its samples are off centre. The far tip follows a length-preserving arc to 90 degrees, by smoothstep, about an axis and in a
 * time of its own; every third muscle contracts on the way, by up to a half, and gets a hundred times as stiff. Drag 5 /s, 24 frames a
 * second, one second, snapshots at T/4, T/2, 3T/4 and T.
 *
 * Two errors per muscle, mass-weighted RMS over its points and the snapshots, over L: that of the solver, against a converged `qn` run of
 * the same substeps; and in all, against a converged run of 64 substeps. Times are of the frames alone; set-up is apart. (`xpbd` keeps
 * areas by rigid rows, `qn` by a barrier: where a triangle is crushed the two solve different problems.)
 */
#include "../unit/sim_scene.h"
#include "sinew/rig.h"

#include <stdio.h>
#include <time.h>

enum { FRAMES = 24, SNAPSHOTS = 4, FINEST = 64 };

typedef struct setting {
    const char *name;
    sn_solver_method method;
    sn_index substeps, iterations; /* 0 = the method's default */
    sn_preconditioning preconditioner;
} setting;

/* A new method, preconditioner or switch is one line here (and, where it needs one, a member of `setting` that use_setting obeys). */
static const setting SETTINGS[] = {
    {"xpbd 1x10", SN_SOLVER_XPBD, 1, 10, SN_PRECONDITION_SCALAR},
    {"xpbd 64x1", SN_SOLVER_XPBD, 64, 1, SN_PRECONDITION_SCALAR},
    {"xpbd default (16x2)", SN_SOLVER_XPBD, 0, 0, SN_PRECONDITION_SCALAR},
    {"qn scalar 3", SN_SOLVER_QN, 1, 3, SN_PRECONDITION_SCALAR},
    {"qn scalar 5", SN_SOLVER_QN, 1, 5, SN_PRECONDITION_SCALAR},
    {"qn scalar 10", SN_SOLVER_QN, 1, 10, SN_PRECONDITION_SCALAR},
    {"qn corotated 2", SN_SOLVER_QN, 1, 2, SN_PRECONDITION_COROTATED},
    {"qn corotated 3", SN_SOLVER_QN, 1, 3, SN_PRECONDITION_COROTATED},
    {"qn corotated 5", SN_SOLVER_QN, 1, 5, SN_PRECONDITION_COROTATED},
    {"qn two-level 3", SN_SOLVER_QN, 1, 3, SN_PRECONDITION_TWO_LEVEL},
    {"qn two-level 5", SN_SOLVER_QN, 1, 5, SN_PRECONDITION_TWO_LEVEL},
};

static void use_setting(sn_scene *scene, const setting *at) {
    scene->solver = sn_solver_defaults(at->method);
    scene->solver.preconditioner = at->preconditioner;
    if (at->substeps > 0) scene->solver.substeps = at->substeps;
    if (at->iterations > 0) scene->solver.iterations = at->iterations;
    scene->solver.preconditioner = at->preconditioner;
    if (at->method == SN_SOLVER_QN) scene->solver.tolerance = 1e-12; /* the iterations are the setting */
}

/* ---- one muscle ------------------------------------------------------------------------------------------------------------- */

static double between(uint64_t *random, double low, double high) { return low + (high - low) * sn_random(random); }

/* What makes a muscle unlike the others: axis, section, lobes. */
typedef struct build {
    double bow, bow_angle, wave, wave_angle; /* of the axis, shares of L; radians */
    double flat, flat_angle;                 /* section: wider by this factor along this angle */
    double shift;                            /* where the belly is thickest: s^shift */
    int lobe_count;
    double lobe_at[2], lobe_angle[2], lobe_height[2]; /* s; radians; shares of the radius there */
} build;

static build draw_build(uint64_t *random) {
    build b = {.bow = between(random, 0.0, 0.15), .bow_angle = between(random, 0.0, 2.0 * SN_PI), .wave = between(random, 0.0, 0.05)};
    b.wave_angle = between(random, 0.0, 2.0 * SN_PI);
    b.flat = between(random, 1.0, 1.8), b.flat_angle = between(random, 0.0, SN_PI);
    b.shift = between(random, 0.7, 1.4);
    b.lobe_count = (int)between(random, 0.0, 2.999);
    for (int i = 0; i < 2; i++) {
        b.lobe_at[i] = between(random, 0.25, 0.75);
        b.lobe_angle[i] = between(random, 0.0, 2.0 * SN_PI);
        b.lobe_height[i] = between(random, 0.5, 1.2);
    }
    return b;
}

/* Factor on the distance from the axis. */
static double lobes(const build *b, double s, double angle) {
    double factor = 1.0;
    for (int i = 0; i < b->lobe_count; i++) {
        double along = (s - b->lobe_at[i]) / 0.12, around = remainder(angle - b->lobe_angle[i], 2.0 * SN_PI) / 0.7;
        factor += b->lobe_height[i] * exp(-along * along - around * around);
    }
    return factor;
}

/* The tips stay where they are. */
static sn_vec3 deform(const build *b, const fusiform *f, sn_vec3 p, uint64_t *random) {
    double s = p.z / f->length, bulge = sin(SN_PI * s), angle = atan2(p.y, p.x), radius = hypot(p.x, p.y);
    if (!(bulge > 1e-9)) return p;
    radius *= pow(fmax(sin(SN_PI * pow(s, b->shift)), 0.2 * bulge) / bulge, 0.8) * lobes(b, s, angle) * between(random, 0.95, 1.05);
    double wide = cos(angle - b->flat_angle) * sqrt(b->flat), thin = sin(angle - b->flat_angle) / sqrt(b->flat);
    double x = radius * (wide * cos(b->flat_angle) - thin * sin(b->flat_angle));
    double y = radius * (wide * sin(b->flat_angle) + thin * cos(b->flat_angle));
    double bow = b->bow * f->length * bulge, wave = b->wave * f->length * sin(2.0 * SN_PI * s);
    return sn_v3(x + bow * cos(b->bow_angle) + wave * cos(b->wave_angle), y + bow * sin(b->bow_angle) + wave * sin(b->wave_angle), p.z);
}

static void rig_muscle(sn_muscle *rig) {
    sn_error error = {0};
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_flow_params flow = sn_flow_defaults();
    flow.field = SN_FIELD_TREE;
    sn_roots_report roots_report = {0};
    sn_structure_report structure_report = {0};
    sn_flow_report flow_report = {0};
    if (sn_roots_select(rig, &roots, NULL, &rig->roots, &roots_report, &error) != SN_OK ||
        sn_structure_build(rig, &structure, NULL, &rig->structure, &structure_report, &error) != SN_OK ||
        sn_flow_fibers(rig, &flow, NULL, &rig->fibers, &flow_report, &error) != SN_OK)
        fail_msg("%s: %s", rig->name, error.text);
}

static void make_body_muscle(sn_scene_muscle *m, const char *bone, sn_index number, double stiffness, uint64_t *random) {
    static const sn_index SIZES[3][2] = {{12, 11}, {15, 9}, {19, 7}};
    fusiform f = FUSIFORM;
    f.rings = SIZES[number % 3][0], f.sectors = SIZES[number % 3][1], f.structure = f.fibers = false;
    sn_scene_muscle_defaults(m);
    make_muscle(&f, &m->rig);
    free(m->rig.attachments[0].bone);
    m->rig.attachments[0].bone = sn_strdup(bone);
    build b = draw_build(random);
    for (sn_index v = 0; v < m->rig.mesh.vertex_count; v++) m->rig.mesh.positions[v] = deform(&b, &f, m->rig.mesh.positions[v], random);
    rig_muscle(&m->rig);
    m->stiffness_relaxed = stiffness;
    m->stiffness_active = 100.0 * stiffness;
    if (number % 3 == 1) set_keys(&m->activation, 0.0, 0.0, 1.0, between(random, 0.5, 1.0));
}

/* ---- the scene ---------------------------------------------------------------------------------------------------------------- */

/* Where the far tip's bone is when the muscle has become an arc of this angle: x -> R (x - tip) + end of the arc. */
static sn_rigid arc_pose(double length, sn_vec3 axis, double angle) {
    sn_vec3 up = sn_v3(0, 0, 1), aside = sn_cross(axis, up), tip = sn_scale(up, length);
    double radius = angle > 1e-9 ? length / angle : 0.0;
    sn_vec3 end = angle > 1e-9 ? sn_add_scaled(sn_scale(up, radius * sin(angle)), aside, radius * (1.0 - cos(angle))) : tip;
    sn_quat turn = sn_quat_axis_angle(axis, angle);
    return (sn_rigid){turn, sn_sub(end, sn_quat_rotate(turn, tip))};
}

static double smoothstep(double t) { return t >= 1.0 ? 1.0 : t * t * (3.0 - 2.0 * t); }

static void make_joint(sn_joint *joint, const char *name, double length, uint64_t *random) {
    enum { KEYS = FRAMES * FINEST + 1 };
    double direction = between(random, 0.0, 2.0 * SN_PI), duration = between(random, 0.7, 1.3);
    *joint =
        (sn_joint){.name = sn_strdup(name), .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = KEYS, .keys = SN_NEW(sn_pose_key, KEYS)};
    for (int i = 0; i < KEYS; i++) {
        double time = i / (24.0 * FINEST);
        sn_vec3 axis = sn_v3(cos(direction), sin(direction), 0);
        joint->keys[i] = (sn_pose_key){time, arc_pose(length, axis, 0.5 * SN_PI * smoothstep(time / duration))};
    }
}

static void make_body(sn_scene *scene, sn_index count, double stiffness) {
    uint64_t random = 2026;
    sn_scene_defaults(scene);
    scene->name = sn_strdup("body");
    scene->bone_count = count + 1, scene->motion.joint_count = count, scene->muscle_count = count;
    scene->bones = SN_NEW(sn_scene_bone, count + 1);
    scene->motion.joints = SN_NEW(sn_joint, count);
    scene->muscles = SN_NEW(sn_scene_muscle, count);
    scene->bones[count] = (sn_scene_bone){.name = sn_strdup("lower"), .uri = sn_strdup("memory"), .meters_per_unit = 1.0, .joint = SN_NONE};
    for (sn_index i = 0; i < count; i++) {
        char name[32];
        snprintf(name, sizeof name, "upper %d", (int)i);
        scene->bones[i] = (sn_scene_bone){.name = sn_strdup(name), .uri = sn_strdup("memory"), .meters_per_unit = 1.0, .joint = i};
        make_joint(&scene->motion.joints[i], name, FUSIFORM.length, &random);
        sn_scene_muscle *m = &scene->muscles[i];
        m->name = sn_strdup(name), m->uri = sn_strdup("memory");
        make_body_muscle(m, name, i, stiffness, &random);
    }
}

/* ---- runs ----------------------------------------------------------------------------------------------------------------------- */

/* Points of all muscles, one after the other, at the four snapshots. */
typedef struct track {
    sn_index points;
    sn_vec3 *at;                     /* (SNAPSHOTS x points) */
    double cpu, wall;                /* seconds a frame */
    double smallest;                 /* triangle at a snapshot, over its rest area */
    int64_t iterations, unconverged; /* of qn: in all; substeps at snapshots that did not end by tolerance or at the energy's minimum */
} track;

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void take_snapshot(const simulation *s, track *t, int snapshot) {
    sn_vec3 *out = t->at + (size_t)snapshot * (size_t)t->points;
    for (sn_index i = 0; i < s->model->muscle_count; i++) {
        const sn_muscle_state *ms = &s->state->muscles[i];
        for (sn_index p = 0; p < s->model->muscles[i].point_count; p++) *out++ = sn_point_position(&ms->points[p]);
        t->smallest = fmin(t->smallest, ms->statistics.smallest_triangle);
        t->unconverged += ms->statistics.stop_reason == SN_STOP_ITERATIONS || ms->statistics.stop_reason == SN_STOP_FAILED;
    }
}

static track run_body(sn_scene *scene, int threads) {
    simulation s = start(scene);
    track t = {.smallest = INFINITY};
    for (sn_index i = 0; i < s.model->muscle_count; i++) t.points += s.model->muscles[i].point_count;
    t.at = SN_NEW(sn_vec3, (size_t)SNAPSHOTS * (size_t)t.points);
    sn_step_options options = {.pool = sn_pool_create(threads)};
    for (int frame = 1; frame <= FRAMES; frame++) {
        double cpu = seconds(CLOCK_PROCESS_CPUTIME_ID), wall = seconds(CLOCK_MONOTONIC);
        step_frames(&s, 1, &options);
        t.cpu += (seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu) / FRAMES, t.wall += (seconds(CLOCK_MONOTONIC) - wall) / FRAMES;
        for (sn_index i = 0; i < s.model->muscle_count; i++) t.iterations += s.state->muscles[i].statistics.iterations;
        if (frame % (FRAMES / SNAPSHOTS) == 0) take_snapshot(&s, &t, frame / (FRAMES / SNAPSHOTS) - 1);
    }
    sn_pool_destroy(options.pool);
    sn_state_destroy(s.model, s.state);
    sn_model_destroy(s.model);
    return t;
}

static track run_converged(sn_scene *scene, sn_index substeps) {
    const setting converged = {"converged", SN_SOLVER_QN, substeps, 2000, SN_PRECONDITION_SCALAR};
    use_setting(scene, &converged);
    scene->solver.tolerance = 1e-9;
    return run_body(scene, 2);
}

/* ---- errors ------------------------------------------------------------------------------------------------------------------------ */

static int compare(const void *a, const void *b) {
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

typedef struct spread {
    double median, high, worst; /* high: the 95th percentile */
    sn_index which;
} spread;

/* Of the muscles' errors. A point that is not finite makes its muscle's error infinite. */
static spread compare_tracks(const sn_model *model, const track *a, const track *b) {
    double *errors = SN_NEW(double, model->muscle_count);
    spread out = {.which = SN_NONE};
    sn_index first = 0;
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
        double sum = 0.0, mass = 0.0;
        for (int k = 0; k < SNAPSHOTS; k++)
            for (sn_index p = 0; p < m->point_count; p++) {
                double w = m->inverse_mass[p];
                if (w == 0.0) continue;
                size_t at = (size_t)k * (size_t)a->points + (size_t)(first + p);
                sum += sn_norm2(sn_sub(a->at[at], b->at[at])) / w, mass += 1.0 / w;
            }
        first += m->point_count;
        errors[i] = isfinite(sum) ? sqrt(sum / mass) / m->diagonal : INFINITY;
        if (out.which == SN_NONE || errors[i] > out.worst) out.worst = errors[i], out.which = i;
    }
    qsort(errors, (size_t)model->muscle_count, sizeof *errors, compare);
    out.median = errors[model->muscle_count / 2];
    out.high = errors[(sn_index)(0.95 * (model->muscle_count - 1) + 0.5)];
    free(errors);
    return out;
}

/* How far a sample is from the mean of the vertices that hang on it, over their mean distance: the median over the body. */
static double off_centre(const sn_scene *scene) {
    double *all = SN_NEW(double, scene->muscle_count * 200), median;
    size_t count = 0;
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        const sn_muscle *rig = &scene->muscles[i].rig;
        for (sn_index k = 0; k < rig->structure.sample_count && k < 200; k++) {
            sn_vec3 mean = sn_v3(0, 0, 0);
            double n = 0.0, away = 0.0;
            for (sn_index v = 0; v < rig->mesh.vertex_count; v++) {
                if (rig->structure.vertex_sample[v] != k) continue;
                mean = sn_add(mean, rig->mesh.positions[v]), n += 1.0;
                away += sn_distance(rig->mesh.positions[v], rig->structure.positions[k]);
            }
            if (n > 0.0) all[count++] = sn_distance(sn_scale(mean, 1.0 / n), rig->structure.positions[k]) * n / away;
        }
    }
    qsort(all, count, sizeof *all, compare);
    median = all[count / 2];
    free(all);
    return median;
}

static void describe(const sn_scene *scene) {
    sn_index samples = 0, branched = 0, triangles = 0, active = 0;
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        const sn_structure *structure = &scene->muscles[i].rig.structure;
        sn_index most = 0;
        for (sn_index k = 0; k < structure->sample_count; k++) most = structure->branches[k] > most ? structure->branches[k] : most;
        samples += structure->sample_count, branched += most >= 2, triangles += scene->muscles[i].rig.mesh.triangle_count;
        active += scene->muscles[i].activation.count > 0;
    }
    printf("%d muscles, %d triangles, %d samples, %d trees with more than two branches, samples off centre by %.2f of their radius, %d "
           "contract; k = %g N/m\n",
           (int)scene->muscle_count, (int)triangles, (int)samples, (int)branched, off_centre(scene), (int)active,
           scene->muscles[0].stiffness_relaxed);
}

/* One line; false: two threads gave other bits than one. */
static bool print_setting(sn_scene *scene, const sn_model *model, const setting *at, const track *same_steps, const track *finest) {
    use_setting(scene, at);
    track one = run_body(scene, 1), two = run_body(scene, 2);
    spread solver = compare_tracks(model, &one, same_steps), total = compare_tracks(model, &one, finest);
    bool same = memcmp(one.at, two.at, (size_t)SNAPSHOTS * (size_t)one.points * sizeof *one.at) == 0;
    printf("%-20s %8.2f %8.2f %8.2f %8.2f %8.1e %8.1e %8.1e %6.1f %5d %9.1e %8.1e%s\n", at->name, 1e3 * one.cpu, 1e3 * one.wall,
           1e3 * two.cpu, 1e3 * two.wall, solver.median, solver.high, solver.worst, solver.worst / solver.median, (int)solver.which,
           total.median, total.worst, same ? "" : "  FAILED: two threads give other bits");
    fflush(stdout);
    free(one.at);
    free(two.at);
    return same;
}

int main(int argc, char **argv) {
    static const sn_index SUBSTEPS[3] = {1, 16, FINEST};
    sn_index count = argc > 1 ? (sn_index)atoi(argv[1]) : 140;
    double stiffness = argc > 2 ? atof(argv[2]) : 500.0;
    if (count < 1 || !(stiffness > 0.0)) return fprintf(stderr, "usage: sim_body [MUSCLES [STIFFNESS]]\n"), 2;
    sn_scene scene;
    track references[3];
    bool same = true;
    setvbuf(stdout, NULL, _IOLBF, 0);
    make_body(&scene, count, stiffness);
    describe(&scene);
    for (int i = 0; i < 3; i++) {
        references[i] = run_converged(&scene, SUBSTEPS[i]);
        printf("converged qn, %2d substeps: %.1f iterations a substep, %d of %d substeps at snapshots not converged, smallest triangle "
               "%.2f of its area\n",
               (int)SUBSTEPS[i], (double)references[i].iterations / (double)(FRAMES * count * SUBSTEPS[i]), (int)references[i].unconverged,
               (int)(SNAPSHOTS * count), references[i].smallest);
    }
    sn_model *model;
    assert_int_equal(sn_model_create(&scene, &model, NULL), SN_OK);
    printf("%-20s %17s %17s %42s %18s\n", "", "1 thread, ms", "2 threads, ms", "error of the solver over L", "error in all");
    printf("%-20s %8s %8s %8s %8s %8s %8s %8s %6s %5s %9s %8s\n", "setting", "cpu", "wall", "cpu", "wall", "median", "95 %", "worst",
           "ratio", "which", "median", "worst");
    for (size_t i = 0; i < sizeof SETTINGS / sizeof *SETTINGS; i++) {
        int r = 0;
        use_setting(&scene, &SETTINGS[i]);
        while (SUBSTEPS[r] != scene.solver.substeps) r++;
        same = print_setting(&scene, model, &SETTINGS[i], &references[r], &references[2]) && same;
    }
    for (int i = 0; i < 3; i++) free(references[i].at);
    sn_model_destroy(model);
    sn_scene_free(&scene);
    return same ? 0 : 1;
}
