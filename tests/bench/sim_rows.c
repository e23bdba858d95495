/*
 * sim_rows.c -- what a row costs: ns per row and kind, ms per iteration, at five sizes, on one core; beside a bare loop over the same rows
 * as the yardstick of the machine. Prints a table.
 */
#include "../unit/sim_scene.h"

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
static void bare(const job *j) {
    const sn_model_muscle *m = &j->s->model->muscles[0];
    sn_muscle_state *s = &j->s->state->muscles[0];
    for (sn_index r = m->distance_start[SN_ROWS_MESH]; r < m->distance_start[SN_ROWS_MESH + 1]; r++) {
        sn_point *p = &s->points[m->distances[r].point[0]], *q = &s->points[m->distances[r].point[1]];
        double dx = p->x - q->x, dy = p->y - q->y, dz = p->z - q->z, length = sqrt(dx * dx + dy * dy + dz * dz);
        double scale = 0.5 * (s->goals[r] - length) / length;
        p->x += scale * dx, p->y += scale * dy, p->z += scale * dz;
        q->x -= scale * dx, q->y -= scale * dy, q->z -= scale * dz;
    }
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

static void bench(sn_index rings, sn_index sectors) {
    fusiform f = FUSIFORM;
    sn_scene scene;
    f.rings = rings, f.sectors = sectors, f.structure = true;
    make_scene(&scene, &f);
    scene.muscles[0].stiffness_relaxed = 500.0; /* nothing rests: each sweep moves every point */
    simulation s = start(&scene);
    step_frames(&s, 1, NULL);
    const sn_plan_muscle *plan = &s.model->plan.muscles[0];
    double iteration = 0.0, bare_time = measure(&(job){&s, SN_ROWS_MESH, bare});
    printf("%9d", (int)plan->triangles);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        double t = measure(&(job){&s, (sn_row_kind)kind, project});
        if (kind == SN_ROWS_MESH || kind == SN_ROWS_DIHEDRAL || kind == SN_ROWS_VOLUME) iteration += t;
        printf(" %9.2f", 1e9 * t / (kind == SN_ROWS_VOLUME ? plan->triangles : plan->groups[kind].rows));
    }
    double start_time = now();
    step_frames(&s, 2, NULL);
    double frame = (now() - start_time) / 2.0;
    printf(" %9.2f %12.3f %11.2f %11.0f\n", 1e9 * bare_time / plan->groups[SN_ROWS_MESH].rows, 1e3 * iteration, 1e3 * frame,
           (double)(plan->model_bytes + plan->state_bytes) / plan->vertices);
    finish(&s);
}

int main(void) {
    static const sn_index sizes[][2] = {{24, 21}, {48, 42}, {98, 87}, {146, 130}, {240, 208}};
    printf("ns per row (volume: per triangle), one core, double; iteration: mesh + dihedral + volume; bare: a plain loop over the mesh "
           "rows\n");
    printf("%9s %9s %9s %9s %9s %9s %9s %9s %12s %11s %11s\n", "triangles", "internal", "radial", "mesh", "dihedral", "area", "volume",
           "bare", "ms/iteration", "ms/frame", "bytes/vertex");
    for (int i = 0; i < 5; i++) bench(sizes[i][0], sizes[i][1]);
    return 0;
}
