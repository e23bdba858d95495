/*
 * sim_rows.c -- what a row costs: ns per row and kind, ms per iteration, at five sizes and in both precisions, on one core; beside a bare
 * loop over the same rows as the yardstick of the machine. And what back end `qn` pays: ns per row of energy and gradient, and where an
 * iteration goes. Prints two tables.
 */
#include "../unit/sim_inside.h"

#include <stdio.h>
#include <time.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct job {
    simulation *s;
    sn_row_kind kind;
    void (*run)(const struct job *);
} job;

static void project(const job *j) { sn_project(j->s->model, j->s->state, 0, j->kind); }

/* The plainest distance projection there is: no mass, no compliance, no guard, one row after the other. */
static void bare_mesh(const job *j) {
    const sn_model_muscle *m = &j->s->model->muscles[0];
    sn_muscle_state *s = &j->s->state->muscles[0];
    const double *goals = s->inputs->goals;
    for (sn_index r = m->distance_start[SN_ROWS_MESH]; r < m->distance_start[SN_ROWS_MESH + 1]; r++) {
        sn_point *p = &s->points[m->distances[r].point[0]], *q = &s->points[m->distances[r].point[1]];
        double dx = p->x - q->x, dy = p->y - q->y, dz = p->z - q->z, length = sqrt(dx * dx + dy * dy + dz * dz);
        double scale = 0.5 * (goals[r] - length) / length;
        p->x += scale * dx, p->y += scale * dy, p->z += scale * dz;
        q->x -= scale * dx, q->y -= scale * dy, q->z -= scale * dz;
    }
}

/* The same for hinges: the C library's arc tangent, equal masses, no guard. */
static void bare_hinges(const job *j) {
    const sn_model_muscle *m = &j->s->model->muscles[0];
    sn_point *points = j->s->state->muscles[0].points;
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_vec3 p[4], g[4];
        double sum = 0.0;
        for (int i = 0; i < 4; i++) p[i] = sn_point_position(&points[m->hinges[r].point[i]]);
        sn_vec3 e = sn_sub(p[1], p[0]), ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
        sn_vec3 n1 = sn_cross(ac, bc), n2 = sn_cross(bd, ad), unit = sn_normalize(e);
        sn_vec3 m1 = sn_scale(n1, 1.0 / sn_norm2(n1)), m2 = sn_scale(n2, 1.0 / sn_norm2(n2));
        double c = atan2(sn_dot(sn_cross(n1, n2), unit), sn_dot(n1, n2)) - m->hinge_angles[r];
        g[0] = sn_add(sn_scale(m1, sn_dot(bc, unit)), sn_scale(m2, sn_dot(bd, unit)));
        g[1] = sn_neg(sn_add(sn_scale(m1, sn_dot(ac, unit)), sn_scale(m2, sn_dot(ad, unit))));
        g[2] = sn_scale(m1, -sn_norm(e));
        g[3] = sn_scale(m2, -sn_norm(e));
        for (int i = 0; i < 4; i++) sum += sn_norm2(g[i]);
        for (int i = 0; i < 4; i++) {
            sn_point *q = &points[m->hinges[r].point[i]];
            q->x -= c / sum * g[i].x, q->y -= c / sum * g[i].y, q->z -= c / sum * g[i].z;
        }
    }
}

/* And the volume: its sum over the triangles, and no gradient. */
static double kept;
static void bare_volume(const job *j) {
    const sn_model_muscle *m = &j->s->model->muscles[0];
    kept += sn_volume_constraint(m->vertex_count, j->s->state->muscles[0].points, m->triangle_count, m->triangles, NULL);
}

static int compare(const void *a, const void *b) {
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

/* Least CPU seconds of one run out of 15 timings, each long enough to be measured: what the machine does when nobody disturbs it. */
static double measure(const job *j) {
    double times[15];
    int repeat = 1;
    for (double t = 0.0; t < 2e-3 && repeat < 1 << 20; repeat *= 2) {
        t = now();
        for (int i = 0; i < repeat; i++) j->run(j);
        t = now() - t;
    }
    for (int k = 0; k < 15; k++) {
        double start = now();
        for (int i = 0; i < repeat; i++) j->run(j);
        times[k] = (now() - start) / repeat;
    }
    qsort(times, 15, sizeof *times, compare);
    return times[0];
}

static void bench(sn_index rings, sn_index sectors, sn_precision precision) {
    fusiform f = FUSIFORM;
    sn_scene scene;
    f.rings = rings, f.sectors = sectors, f.structure = true;
    make_scene(&scene, &f);
    scene.muscles[0].stiffness_relaxed = 500.0; /* nothing rests: each sweep moves every point */
    scene.solver.sleep = false;
    scene.solver.precision = precision;
    simulation s = start(&scene);
    step_frames(&s, 1, NULL);
    const sn_plan_muscle *plan = &s.model->plan.muscles[0];
    double iteration = 0.0, bare_times[3];
    static void (*const BARE[3])(const job *) = {bare_mesh, bare_hinges, bare_volume};
    const sn_index bare_rows[3] = {plan->groups[SN_ROWS_MESH].rows, plan->groups[SN_ROWS_DIHEDRAL].rows, plan->triangles};
    for (int k = 0; k < 3; k++) bare_times[k] = 1e9 * measure(&(job){&s, SN_ROWS_MESH, BARE[k]}) / bare_rows[k];
    printf("%9d %9s", (int)plan->triangles, precision == SN_PRECISION_SINGLE ? "single" : "double");
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        if (plan->groups[kind].rows == 0) continue; /* a membrane takes the place of springs */
        double t = measure(&(job){&s, (sn_row_kind)kind, project});
        if (kind == SN_ROWS_MESH || kind == SN_ROWS_DIHEDRAL || kind == SN_ROWS_VOLUME) iteration += t;
        printf(" %9.2f", 1e9 * t / (kind == SN_ROWS_VOLUME ? plan->triangles : plan->groups[kind].rows));
    }
    double start_time = now();
    step_frames(&s, 2, NULL);
    double frame = (now() - start_time) / 2.0;
    for (int k = 0; k < 3; k++) printf(" %9.2f", bare_times[k]);
    printf(" %12.3f %11.2f %12.0f\n", 1e3 * iteration, 1e3 * frame, (double)(plan->model_bytes + plan->state_bytes) / plan->vertices);
    finish(&s);
}

/* ---- back end qn ------------------------------------------------------------------------------------------------------------ */

static sn_forces forces_of(const simulation *s) { return (sn_forces){&qn_of(s)->forces->x, 4}; }

static void energy_of_kind(const job *j) {
    const sn_muscle_state *s = &j->s->state->muscles[0];
    kept += sn_rows_energy(&j->s->model->muscles[0], s, j->kind, s->points, forces_of(j->s));
}

/* All of them, inertia and areas too. */
static void evaluate(const job *j) {
    sn_muscle_state *s = &j->s->state->muscles[0];
    const sn_objective objective = objective_of(j->s, j->s->model->substep_duration);
    kept += sn_objective_evaluate(&objective, s->points, qn_of(j->s)->trial_gradient);
}

static void solve(const job *j) {
    sn_qn *qn = qn_of(j->s);
    static const double STIFFNESS = 1.0;
    sn_preconditioner_set_volume(qn->preconditioner, qn->volume_gradient, &STIFFNESS);
    assert_true(sn_preconditioner_apply(qn->preconditioner, qn->gradient, qn->direction));
}

/* The two loops of L-BFGS over all pairs, as they are plainest. */
static void two_loops(const job *j) {
    sn_qn *qn = qn_of(j->s);
    size_t n = (size_t)j->s->model->muscles[0].point_count;
    sn_vec3 *d = qn->direction;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t pair = 0; pair < SN_QN_MEMORY; pair++) {
            const sn_vec3 *a = (pass == 0 ? qn->pair_steps : qn->pair_changes) + pair * n;
            const sn_vec3 *b = (pass == 0 ? qn->pair_changes : qn->pair_steps) + pair * n;
            double sum = 0.0;
            for (size_t i = 0; i < n; i++) sum += sn_dot(a[i], d[i]);
            for (size_t i = 0; i < n; i++) d[i] = sn_add_scaled(d[i], b[i], 1e-9 * sum);
        }
    }
}

/* One muscle that contracts and bends, stopped where pairs and volume are at hand. */
static void bench_qn(sn_index rings, sn_index sectors) {
    fusiform f = FUSIFORM;
    sn_scene scene;
    f.rings = rings, f.sectors = sectors, f.structure = true;
    make_scene(&scene, &f);
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    scene.solver.sleep = false;
    scene.solver.tolerance = 0.0;
    set_keys(&scene.muscles[0].activation, 0.0, 0.0, 0.5, 1.0);
    set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.5, -0.5);
    simulation s = start(&scene);
    step_frames(&s, 4, NULL);
    const sn_plan_muscle *plan = &s.model->plan.muscles[0];
    printf("%9d", (int)plan->triangles);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        if (kind == SN_ROWS_AREA || plan->groups[kind].rows == 0) continue;
        double t = measure(&(job){&s, (sn_row_kind)kind, energy_of_kind});
        printf(" %9.2f", 1e9 * t / (kind == SN_ROWS_VOLUME ? plan->triangles : plan->groups[kind].rows));
    }
    double evaluation = measure(&(job){&s, SN_ROWS_MESH, evaluate}), solution = measure(&(job){&s, SN_ROWS_MESH, solve});
    double loops = measure(&(job){&s, SN_ROWS_MESH, two_loops}), begin = now();
    int64_t iterations = 0, rejected = 0;
    for (int i = 0; i < 4; i++) {
        step_frames(&s, 1, NULL);
        iterations += s.state->muscles[0].statistics.iterations, rejected += s.state->muscles[0].statistics.rejected_steps;
    }
    double iteration = (now() - begin) / (double)iterations;
    printf(" %12.3f %9.3f %9.3f %12.3f %9.1f %9.2f\n", 1e3 * evaluation, 1e3 * solution, 1e3 * loops, 1e3 * iteration,
           (double)iterations / 4.0, (double)rejected / (double)iterations);
    finish(&s);
}

int main(void) {
    static const sn_index sizes[][2] = {{24, 21}, {48, 42}, {98, 87}, {146, 130}, {240, 208}};
    printf("ns per row (volume: per triangle), one core; iteration: mesh + dihedral + volume; frame: 16 substeps x 2 iterations\n"
           "bare: a plain loop over the same rows, without masses, compliance and guards\n");
    printf("%9s %9s %9s %9s %9s %9s %9s %9s %9s %9s %9s %12s %11s %12s\n", "triangles", "precision", "internal", "radial", "mesh",
           "dihedral", "area", "volume", "bare-mesh", "bare-dih", "bare-vol", "ms/iteration", "ms/frame", "bytes/vertex");
    for (int i = 0; i < 5; i++)
        for (int precision = 0; precision < 2; precision++) bench(sizes[i][0], sizes[i][1], (sn_precision)precision);
    printf(
        "\nqn: ns per row of energy and gradient (volume: per triangle); evaluation: all rows, areas and inertia, once; solve: one\n"
        "application of the preconditioner; l-bfgs: the two loops over 8 pairs; iteration: those three and the rest, the start of a step\n"
        "and the factorisation of its matrix too\n");
    printf("%9s %9s %9s %9s %9s %9s %12s %9s %9s %12s %9s %9s\n", "triangles", "internal", "radial", "mesh", "dihedral", "volume",
           "ms/evaluate", "ms/solve", "ms/l-bfgs", "ms/iteration", "it/frame", "rejected");
    for (int i = 0; i < 5; i++) bench_qn(sizes[i][0], sizes[i][1]);
    return 0;
}
