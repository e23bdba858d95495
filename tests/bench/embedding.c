/*
 * embedding.c -- what it costs to bind 1,600 fibre vertices to a muscle and to move them: at three sizes, with the cut that simulate takes
 * and with all weights, on one thread and on all; beside a bare sum of all the weights, what the machine's memory gives. Prints a table.
 */
#include "../unit/sim_scene.h"

#include <stdio.h>
#include <time.h>

#include "sinew/fibers.h"
#include "sinew/rig.h"

static double now(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct bound {
    sn_mesh mesh;
    sn_fiber_bundle bundle;
    sn_vec3 *points;
} bound;

static void apply(const bound *b, const sn_embedding *e, sn_pool *pool) { sn_embedding_apply(e, b->mesh.positions, pool, b->points); }

static void bare_sum(const bound *b, const sn_embedding *e, sn_pool *pool) {
    double sum[4] = {0};
    (void)pool;
    for (sn_index i = 0; i < e->point_count; i++)
        for (sn_index k = 0; k + 4 <= e->rows[i].count; k += 4)
            for (int lane = 0; lane < 4; lane++) sum[lane] += e->rows[i].weights[k + lane];
    b->points[0].x = sum[0] + sum[1] + sum[2] + sum[3];
}

/* Milliseconds of a call: the least of several, wall clock. */
static double least_of(void (*run)(const bound *, const sn_embedding *, sn_pool *), const bound *b, const sn_embedding *e, sn_pool *pool) {
    double least = INFINITY;
    for (int i = 0; i < 30; i++) {
        double started = now(CLOCK_MONOTONIC);
        run(b, e, pool);
        least = fmin(least, now(CLOCK_MONOTONIC) - started);
    }
    return 1e3 * least;
}

static void print_row(const bound *b, double cut, sn_pool *pool) {
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding e;
    params.cut = cut;
    params.pool = pool;
    double wall = now(CLOCK_MONOTONIC), work = now(CLOCK_PROCESS_CPUTIME_ID);
    assert_int_equal(sn_embedding_build(&b->mesh, b->bundle.point_count, b->bundle.points, &params, &e, NULL), SN_OK);
    wall = now(CLOCK_MONOTONIC) - wall;
    work = now(CLOCK_PROCESS_CPUTIME_ID) - work;
    printf("%9d %6d %7g %10lld %8.2f %8.2f %10.2f %10.2f %10.2f\n", b->mesh.triangle_count, b->bundle.point_count, cut,
           (long long)e.report.weights, wall, work, least_of(apply, b, &e, NULL), least_of(apply, b, &e, pool),
           least_of(bare_sum, b, &e, NULL));
    sn_embedding_free(&e);
}

int main(void) {
    const sn_index sizes[3][2] = {{60, 34}, {120, 72}, {130, 78}};
    sn_pool *pool = sn_pool_create(0);
    printf("%9s %6s %7s %10s %8s %8s %10s %10s %10s\n", "triangles", "points", "cut", "weights", "bind s", "cpu s", "move ms", "threads ms",
           "bare ms");
    for (int i = 0; i < 3; i++) {
        fusiform shape = FUSIFORM;
        sn_muscle muscle = {.meters_per_unit = 1.0};
        sn_fill_params fill = sn_fill_defaults();
        sn_fill_report filled;
        shape.rings = sizes[i][0];
        shape.sectors = sizes[i][1];
        make_surface(&shape, &muscle.mesh);
        assert_int_equal(sn_fill_fibers(&muscle, &fill, NULL, &muscle.fibers, &filled, NULL), SN_OK);
        bound b = {.mesh = muscle.mesh};
        assert_int_equal(sn_fiber_bundle_create(&muscle.fibers, &b.bundle, NULL), SN_OK);
        b.points = SN_NEW(sn_vec3, b.bundle.point_count);
        print_row(&b, 3e-4, pool);
        print_row(&b, 0.0, pool);
        free(b.points);
        sn_fiber_bundle_free(&b.bundle);
        sn_muscle_free(&muscle);
    }
    sn_pool_destroy(pool);
    return 0;
}
