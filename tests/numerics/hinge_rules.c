/*
 * hinge_rules.c -- what is left of a muscle under the scheme `kohout` at its paper's setting, one step a frame.
 * Usage: hinge_rules [SCENE published|printed|none ITERATIONS]; `none` leaves the hinges out, to tell what they do.
 *
 * Prints a line per muscle with tabs: muscle; triangles; rule; iterations; frames; volume error at the end and the worst on the way, %;
 * mean and greatest strain |l / l0 - 1| of edges at the end, %; rms of the hinges' errors, rad; the smallest triangle over its rest area;
 * seconds of processor time, of all muscles together; verdict. A muscle passes where every frame is finite and its volume within 5 % of its
 * goal at the end. Without arguments a fusiform muscle of 768 triangles whose lower end turns by 2 degrees a frame, under all of them.
 */
#include "../unit/sim_scene.h"
#include "sinew/io.h"

#include <stdio.h>
#include <time.h>

static const double MOST_VOLUME_ERROR = 0.05;
static const char *const RULES[] = {"none", "published", "printed"}; /* from 1 in the order of sn_hinge_rule */
enum { RULE_COUNT = sizeof RULES / sizeof *RULES };
static int passed, failed;

static void set_solver(sn_scene *scene, int rule, sn_index iterations) {
    scene->solver = sn_solver_defaults(SN_SOLVER_XPBD);
    scene->solver.scheme = SN_SCHEME_KOHOUT;
    scene->solver.hinges = (sn_hinge_rule)rule;
    scene->solver.substeps = 1;
    scene->solver.iterations = iterations;
    for (sn_index i = 0; rule == 0 && i < scene->muscle_count; i++) scene->muscles[i].stiffness_dihedral = 0.0;
}

/* What the frames of one muscle were like so far. */
typedef struct history {
    double worst_volume;
    bool finite;
} history;

static void look(const simulation *s, history *muscles) {
    for (sn_index i = 0; i < s->model->muscle_count; i++) {
        const sn_statistics *st = &s->state->muscles[i].statistics;
        muscles[i].finite = muscles[i].finite && st->nan_points == 0 && isfinite(st->volume_error);
        muscles[i].worst_volume = fmax(muscles[i].worst_volume, fabs(st->volume_error));
    }
}

/* Mean and greatest |l / l0 - 1| of the surface edges that have a free end. */
static void measure_strain(const sn_model_muscle *m, const sn_muscle_state *s, double *mean, double *most) {
    sn_index begin = m->distance_start[SN_ROWS_MESH], end = m->distance_start[SN_ROWS_MESH + 1];
    *mean = *most = 0.0;
    for (sn_index r = begin; r < end; r++) {
        const sn_index *p = m->distances[r].point;
        double now = sn_distance(sn_point_position(&s->points[p[0]]), sn_point_position(&s->points[p[1]]));
        double strain = fabs(now / sn_distance(m->rest[p[0]], m->rest[p[1]]) - 1.0);
        *mean += strain / (end - begin);
        *most = fmax(*most, strain);
    }
}

static void report(const simulation *s, sn_index muscle, int rule, const history *seen, double seconds) {
    const sn_model_muscle *m = &s->model->muscles[muscle];
    const sn_statistics *st = &s->state->muscles[muscle].statistics;
    double mean, most;
    measure_strain(m, &s->state->muscles[muscle], &mean, &most);
    bool good = seen->finite && fabs(st->volume_error) < MOST_VOLUME_ERROR;
    printf("%s\t%d\t%s\t%d\t%d\t%.4f\t%.4f\t%.2f\t%.0f\t%.3f\t%.3f\t%.2f\t%s\n", m->source->name, (int)m->triangle_count, RULES[rule],
           (int)m->iterations, (int)(s->scene->last_frame - s->scene->first_frame), 100.0 * st->volume_error, 100.0 * seen->worst_volume,
           100.0 * mean, 100.0 * most, m->hinge_count > 0 ? st->residuals[SN_ROWS_DIHEDRAL].rms : NAN, st->smallest_triangle, seconds,
           good ? "passed" : "FAILED");
    fflush(stdout);
    *(good ? &passed : &failed) += 1;
}

static void run(sn_scene *scene, int rule, sn_index iterations) {
    clock_t began = clock();
    set_solver(scene, rule, iterations);
    simulation s = start(scene);
    history *muscles = SN_NEW(history, s.model->muscle_count);
    assert_non_null(muscles);
    for (sn_index i = 0; i < s.model->muscle_count; i++) muscles[i].finite = true;
    for (sn_index frame = scene->first_frame; frame < scene->last_frame; frame++) {
        step_frames(&s, 1, NULL);
        look(&s, muscles);
    }
    double seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
    for (sn_index i = 0; i < s.model->muscle_count; i++) report(&s, i, rule, &muscles[i], seconds);
    free(muscles);
    finish(&s);
}

static void load(const char *path, sn_scene *scene) {
    sn_blob blob = {0};
    sn_error error = {0};
    sn_status status = sn_blob_read(path, &blob, &error);
    if (status == SN_OK) status = sn_scene_parse(&blob, false, scene, &error);
    if (status != SN_OK) fail_msg("%s: %s", path, error.text);
    sn_blob_free(&blob);
}

static void run_fusiform(void) {
    static const sn_index ITERATIONS[] = {1, 3, 10, 100};
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        for (int i = 0; i < 4; i++) {
            sn_scene scene;
            make_scene(&scene, &FUSIFORM);
            scene.last_frame = 45;
            set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 45.0 / scene.rate, SN_PI / 2.0);
            run(&scene, rule, ITERATIONS[i]);
        }
    }
}

int main(int argc, char **argv) {
    int rule = argc == 4 ? RULE_COUNT - 1 : 0;
    while (argc == 4 && rule >= 0 && strcmp(argv[2], RULES[rule]) != 0) rule--;
    if ((argc != 1 && argc != 4) || rule < 0 || (argc == 4 && atoi(argv[3]) < 1)) {
        fprintf(stderr, "usage: hinge_rules [SCENE published|printed|none ITERATIONS]\n");
        return 2;
    }
    if (argc == 4) {
        sn_scene scene;
        load(argv[1], &scene);
        run(&scene, rule, atoi(argv[3]));
    } else {
        run_fusiform();
        printf("%d passed, %d failed\n", passed, failed);
    }
    return failed > 0;
}
