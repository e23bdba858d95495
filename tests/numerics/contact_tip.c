/*
 * contact_tip.c -- the moving tip with a bone in its way: how far `qn` at 10 iterations is from the converged solve of the same steps, how
 * deep vertices are left beyond their margins, and what share of the time contact takes.   numerics.md 7, 8
 *
 *   contact_tip          1k triangles
 *   contact_tip --all    4k and 17k too; 17k takes minutes
 *
 * A capsule of 20 mm radius lies across the fusiform muscle's middle. It touches it at rest (what overlaps at rest would rest there), and
 * comes 10 mm in during the first ten frames, while the tip turns by 57 degrees in steps of 2 and then stops at once and is held for 20
 * frames: on the inner side of the bend, so that the muscle wraps around it, or at its flank, so that it slides along it. Edges of 500 N/m,
 * angles and volume. The converged solve: 2000 iterations, tolerance 1e-10. Limits: 1.2e-3 (RMS over L) in any frame; 0.2 mm beyond the
 * margin in any frame, 0.01 mm in the last. The depth is that of the distance field; printed beside it are what it was before the step's
 * end put vertices out, and the true capsule's. The share: contact's own functions, timed at the end's points, times their calls in a
 * frame, over the frame's time; it is printed, not judged.
 */
#include "../unit/contact_scene.h"
#include "../unit/sim_inside.h"
#include "../../lib/sim/contact.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

static const double MOST_ERROR = 1.2e-3, MOST_DEPTH = 2e-4, MOST_DEPTH_AFTER = 1e-5;
enum { TURNING = 28, HELD = 20, COMING = 10 };

typedef struct problem {
    const char *name;
    sn_index triangles;
    bool flank;
    capsule bone;
    sn_vec3 way; /* of the bone */
} problem;

/* ---- the scene ------------------------------------------------------------------------------------------------------------------ */

/* A centre line of constant length L bends into a circular arc; its end. */
static sn_rigid tip_at(double bend) {
    double length = FUSIFORM.length, chord = bend > 0.0 ? sn_sin(0.5 * bend) / (0.5 * bend) : 1.0;
    sn_vec3 end = sn_v3(0, length * chord * sn_sin(0.5 * bend), length * chord * sn_cos(0.5 * bend));
    return (sn_rigid){sn_quat_axis_angle(sn_v3(1, 0, 0), -bend), sn_sub(end, sn_v3(0, length * sn_sin(bend), length * sn_cos(bend)))};
}

static void turn_tip(sn_scene *scene) {
    sn_pose_key *keys = SN_NEW(sn_pose_key, TURNING + 1);
    for (int i = 0; i <= TURNING; i++) keys[i] = (sn_pose_key){i / scene->rate, tip_at(i * SN_PI / 90.0)};
    sn_joint *joint = &scene->motion.joints[0];
    *joint = (sn_joint){.name = joint->name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = TURNING + 1, .keys = keys};
    scene->bones[0].joint = 0;
    scene->bones[1].joint = SN_NONE;
}

static void place_bone(problem *p) {
    const double radius = 0.02, gap = 0.0011, depth = 0.01; /* the gap is wider than any margin */
    double axis = FUSIFORM.radius + radius + gap, middle = 0.5 * FUSIFORM.length;
    p->bone = p->flank ? (capsule){{{axis, -0.08, middle}, {axis, 0.08, middle}}, radius}
                       : (capsule){{{-0.06, axis, middle}, {0.06, axis, middle}}, radius};
    p->way = sn_scale(p->flank ? sn_v3(1, 0, 0) : sn_v3(0, 1, 0), -(gap + depth));
}

static simulation start_problem(const problem *p, sn_scene *scene, bool converged) {
    fusiform f = FUSIFORM;
    f.structure = false;
    f.sectors = (sn_index)lround(sqrt((double)p->triangles / 3.0));
    f.rings = (sn_index)lround((double)p->triangles / (2.0 * f.sectors));
    make_scene(scene, &f);
    turn_contact_on(scene);
    turn_tip(scene);
    scene->last_frame = TURNING + HELD;
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.substeps = 1;
    scene->solver.iterations = converged ? 2000 : 10;
    if (converged) scene->solver.tolerance = 1e-10;
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
    scene->muscles[0].least_area = 0.0;
    make_capsule(&p->bone, 32, add_solid(scene, "bone", keys_to(0.0, COMING / scene->rate, shifted(p->way)), 2));
    return start(scene);
}

/* ---- what is measured ------------------------------------------------------------------------------------------------------------ */

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* RMS over L, of the free points. */
static double apart(const simulation *a, const simulation *b) {
    const sn_model_muscle *m = &a->model->muscles[0];
    double sum = 0.0;
    sn_index count = 0;
    for (sn_index i = 0; i < m->point_count; i++)
        if (m->inverse_mass[i] > 0.0) sum += sn_norm2(sn_sub(position(a, i), position(b, i))), count++;
    return sqrt(sum / count) / m->diagonal;
}

static double depth(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    return sn_rows_residual(m, &s->state->muscles[0], SN_ROWS_CONTACT, NULL).max * m->mean_edge;
}

/* How deep a vertex was before the step's end put it out: what its multiplier has grown by, over the stiffness. before (contact_count), N:
 * the multipliers of the step's begin; they become those of its end. */
static double soft_depth(const simulation *s, double *before) {
    const sn_model_muscle *m = &s->model->muscles[0];
    const double *now = inputs_of(s)->multipliers;
    double most = 0.0, k = sn_row_stiffness(m, &s->state->muscles[0], SN_ROWS_CONTACT);
    for (sn_index r = 0; r < m->contact_count; r++) most = fmax(most, (now[r] - before[r]) / k);
    memcpy(before, now, (size_t)m->contact_count * sizeof *before);
    return most;
}

/* Beyond the margin of the capsule itself, which has no facets and no grid. */
static double true_depth(const simulation *s, const problem *p) {
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_vec3 way = sn_scale(p->way, fmin(1.0, s->state->frame / (double)COMING));
    double most = 0.0;
    for (sn_index v = 0; v < m->vertex_count; v++)
        if (m->inverse_mass[v] > 0.0)
            most = fmax(most, sn_contacts_of(m)->margin - capsule_distance(&p->bone, sn_sub(position(s, v), way)));
    return most;
}

/* Of contact in a frame, s: once what a step does once, and as often as the energy was asked for. */
static double contact_seconds(const simulation *s, double evaluations) {
    enum { REPEATS = 20 };
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_muscle_state *muscle = &s->state->muscles[0];
    const sn_substep substep = {.h = s->model->substep_duration};
    sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count);
    double begin = seconds(), sum = 0.0;
    for (int i = 0; i < REPEATS; i++) {
        sum += sn_contacts_too_far(m, muscle, &substep);
        sn_contacts_gather(m, muscle, &substep);
        sn_contacts_clear(m, muscle, muscle->points);
        sn_contacts_finish(m, muscle);
    }
    double once = (seconds() - begin) / REPEATS;
    begin = seconds();
    for (int i = 0; i < REPEATS; i++) sum += sn_rows_energy(m, muscle, SN_ROWS_CONTACT, muscle->points, (sn_forces){&gradient->x, 3});
    double each = (seconds() - begin) / REPEATS;
    free(gradient);
    return isfinite(sum) ? once + evaluations * each : NAN;
}

/* ---- a run ----------------------------------------------------------------------------------------------------------------------- */

/* Greatest of any frame, and at the end. */
typedef struct outcome {
    double error, depth, true_depth, depth_after;
    double soft, soft_after; /* before the step's end puts vertices out */
    double seconds;          /* a frame */
    double evaluations;      /* of the energy, a frame, about */
    sn_index contacts;       /* the most */
    int unconverged;         /* frames of the reference */
} outcome;

static void add_frame(const simulation *run, const simulation *reference, const problem *p, outcome *out) {
    const sn_statistics *statistics = &run->state->muscles[0].statistics;
    out->error = fmax(out->error, apart(run, reference));
    out->depth_after = depth(run);
    out->depth = fmax(out->depth, out->depth_after);
    out->true_depth = fmax(out->true_depth, true_depth(run, p));
    out->evaluations += (double)(statistics->iterations + statistics->rejected_steps + 4) / (TURNING + HELD);
    if (statistics->contacts > out->contacts) out->contacts = statistics->contacts;
    out->unconverged += reference->state->muscles[0].statistics.stop_reason == SN_STOP_ITERATIONS;
}

static bool solve(problem *p) {
    sn_scene scenes[2];
    outcome out = {0};
    place_bone(p);
    simulation run = start_problem(p, &scenes[0], false), reference = start_problem(p, &scenes[1], true);
    double *multipliers = SN_NEW(double, run.model->muscles[0].contact_count);
    for (int frame = 0; frame < TURNING + HELD; frame++) {
        double begin = seconds();
        step_frames(&run, 1, NULL);
        out.seconds += (seconds() - begin) / (TURNING + HELD);
        step_frames(&reference, 1, NULL);
        add_frame(&run, &reference, p, &out);
        out.soft_after = soft_depth(&run, multipliers);
        out.soft = fmax(out.soft, out.soft_after);
    }
    bool good = out.error <= MOST_ERROR && out.depth <= MOST_DEPTH && out.depth_after <= MOST_DEPTH_AFTER && out.contacts > 0;
    printf("%s\t%s\t%d\t%.2e\t%.2g\t%.2g\t%.2g\t%.2g\t%.2g\t%d\t%.3g\t%.1f\t%d\n", good ? "passed" : "FAILED", p->name, (int)p->triangles,
           out.error, 1e3 * out.depth, 1e3 * out.depth_after, 1e3 * out.soft, 1e3 * out.soft_after, 1e3 * out.true_depth, (int)out.contacts,
           1e3 * out.seconds, 100.0 * contact_seconds(&run, out.evaluations) / out.seconds, out.unconverged);
    fflush(stdout);
    free(multipliers);
    finish(&run);
    finish(&reference);
    return good;
}

int main(int argc, char **argv) {
    static const sn_index sizes[] = {1000, 4000, 17000};
    int count = argc > 1 && strcmp(argv[1], "--all") == 0 ? 3 : 1, failed = 0;
    printf("verdict\tbone\ttriangles\terror\tdepth mm\tafter mm\tsoft mm\tsoft after mm\tof the capsule mm\tcontacts\tms a frame\tcontact "
           "%%\tnot converged\n");
    for (int i = 0; i < count; i++)
        for (int flank = 0; flank < 2; flank++)
            failed += !solve(&(problem){.name = flank ? "flank" : "inside", .triangles = sizes[i], .flank = flank});
    printf("%d passed, %d failed\n", 2 * count - failed, failed);
    return failed > 0;
}
