/*
 * fill_anatomy.c -- real muscles decomposed into 100 fibres of 15 segments, in process: one TSV line a muscle, then a table.
 *
 *   DATA=FOLDER fill_anatomy        every 24th of the 38 muscles of leg-vhf and the 253 of dog-dmcontrol, and those of `hard`
 *   DATA=FOLDER fill_anatomy all    all of them
 *   fill_anatomy MESH...            these surfaces
 *
 * A muscle passes if all fibres are there, none of their vertices lies outside the volume (signed distance, a test the filling itself does
 * not rest on) and every end of the muscle is reached. A whole set passes if enough muscles had less than 1 % of the vertices outside
 * before they were pulled in. Then the fibres of a leg muscle are bound to its surface: the error on an affine map, and of a cut in
 * bending.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "sinew/embedding.h"
#include "sinew/geom.h"
#include "sinew/io.h"
#include "sinew/rig.h"

enum { EVERY = 24, LEAST_TIMED = 18000, MOST_TIMED = 22000 };

typedef struct outcome {
    sn_fill_report report;
    sn_index outside; /* by signed distance */
    double seconds, after_field;
    const char *failure; /* NULL = passed */
} outcome;

typedef struct totals {
    int passed, failed, few_outside;
    double seconds, after_field;
    double timed, timed_after_field; /* the most that one of about 20k triangles took */
    long vertices, outside_before, outside_after;
} totals;

static sn_pool *pool;

/* Processor time of all threads: what else the machine does leaves it alone. */
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The first level is cut when the field is known. */
static void note_first_level(void *user, int64_t number, const char *stage, const sn_trace_value *values, int count) {
    (void)number, (void)values, (void)count;
    double *first = user;
    if (*first == 0.0 && strcmp(stage, "level") == 0) *first = now();
}

static sn_status fill_muscle(sn_muscle *m, outcome *o, sn_error *error) {
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_fill_params fill = sn_fill_defaults();
    sn_roots_report roots_report;
    sn_structure_report structure_report;
    fill.pool = pool;
    sn_status status = sn_roots_select(m, &roots, NULL, &m->roots, &roots_report, error);
    if (status == SN_OK) status = sn_structure_build(m, &structure, NULL, &m->structure, &structure_report, error);
    if (status != SN_OK) return status;
    double first_level = 0.0, start = now();
    sn_trace trace = {.receive = note_first_level, .user = &first_level, .stop_after = -1};
    status = sn_fill_fibers(m, &fill, &trace, &m->fibers, &o->report, error);
    o->seconds = now() - start;
    o->after_field = now() - first_level;
    return status;
}

static sn_status count_outside(const sn_muscle *m, sn_index *outside, sn_error *error) {
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(&m->mesh, &surface, error);
    double tolerance = 1e-9 * sn_box_diagonal(sn_mesh_box(&m->mesh));
    *outside = 0;
    for (sn_index i = 0; i < m->fibers.polyline_count && status == SN_OK; i++)
        for (sn_index k = 0; k < m->fibers.polylines[i].count; k++)
            *outside += sn_surface_signed_distance(surface, m->fibers.polylines[i].points[k], NULL) > tolerance;
    sn_surface_destroy(surface);
    return status;
}

static const char *judge(const sn_muscle *m, const outcome *o) {
    if (m->fibers.polyline_count != 100) return "not 100 fibres";
    for (sn_index i = 0; i < m->fibers.polyline_count; i++) {
        if (m->fibers.polylines[i].count != 16) return "a fibre without its 15 segments";
        for (sn_index k = 0; k < 16; k++)
            if (!sn_finite3(m->fibers.polylines[i].points[k])) return "a vertex that is not finite";
    }
    if (o->outside > 0) return "fibre vertices outside the volume";
    return o->report.leaves_reached < o->report.leaf_loops ? "an end of the muscle without a fibre" : NULL;
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static double share_outside(const outcome *o) {
    return o->report.vertices > 0 ? (double)o->report.outside_before / o->report.vertices : 1.0;
}

static void print_header(void) {
    printf("muscle\ttriangles\tends\tloops\tmost_loops\toutside_before\toutside_after\tlength\tpennation\tms\tafter_field_ms\tresult\n");
}

static void print_line(const char *path, const sn_muscle *m, const outcome *o) {
    const sn_fill_report *r = &o->report;
    printf("%s\t%d\t%d\t%d\t%d\t%d\t%d\t%.4g\t%.1f\t%.0f\t%.0f\t%s\n", base_name(path), m->mesh.triangle_count, r->leaf_loops, r->loops,
           r->most_loops, r->outside_before, o->outside, r->mean_length, r->mean_pennation * 180.0 / SN_PI, 1e3 * o->seconds,
           1e3 * o->after_field, o->failure ? o->failure : "ok");
}

static void add(totals *t, const outcome *o, sn_index triangles) {
    t->passed += o->failure == NULL;
    t->failed += o->failure != NULL;
    t->few_outside += share_outside(o) < 0.01;
    t->vertices += o->report.vertices;
    t->outside_before += o->report.outside_before;
    t->outside_after += o->outside;
    t->seconds += o->seconds;
    t->after_field += o->after_field;
    if (triangles < LEAST_TIMED || triangles > MOST_TIMED) return;
    t->timed = fmax(t->timed, o->seconds);
    t->timed_after_field = fmax(t->timed_after_field, o->after_field);
}

static void process(const char *path, totals *t) {
    sn_muscle m = {.meters_per_unit = 1.0};
    sn_error error = {0};
    outcome o = {0};
    sn_status status = sn_mesh_read(path, &m.mesh, NULL, &error);
    if (status == SN_OK) status = fill_muscle(&m, &o, &error);
    if (status == SN_OK) status = count_outside(&m, &o.outside, &error);
    o.failure = status == SN_OK ? judge(&m, &o) : error.text;
    print_line(path, &m, &o);
    add(t, &o, m.mesh.triangle_count);
    sn_muscle_free(&m);
}

/* ---- embedding ---------------------------------------------------------------------------------------------------------------------- */

static sn_vec3 sheared(sn_vec3 p) { return sn_v3(1.2 * p.x + 0.3 * p.y - 40.0, 0.9 * p.y - 0.2 * p.z, 0.1 * p.x + 1.5 * p.z + 7.0); }

/* Bent about the x axis by 40 degrees over the height of the box. */
static sn_vec3 bent(sn_vec3 p, sn_box box) {
    double turn = 40.0 / 180.0 * SN_PI * (p.z - box.low.z) / (box.high.z - box.low.z);
    double y = p.y - 0.5 * (box.low.y + box.high.y), z = p.z - box.low.z;
    return sn_v3(p.x, y * cos(turn) + z * sin(turn), z * cos(turn) - y * sin(turn));
}

typedef struct binding {
    const sn_muscle *muscle;
    sn_index count;
    sn_vec3 *points;          /* (count) */
    sn_vec3 *moved, *surface; /* (count), (vertex_count) */
} binding;

static double affine_error(binding *b, const sn_embedding *e) {
    double worst = 0.0;
    for (sn_index v = 0; v < b->muscle->mesh.vertex_count; v++) b->surface[v] = sheared(b->muscle->mesh.positions[v]);
    sn_embedding_apply(e, b->surface, pool, b->moved);
    for (sn_index i = 0; i < b->count; i++) worst = fmax(worst, sn_distance(b->moved[i], sheared(b->points[i])));
    return worst;
}

/* Mean distance of the points by two embeddings, in bending. */
static double bending_error(binding *b, const sn_embedding *all, const sn_embedding *few) {
    sn_vec3 *other = SN_NEW(sn_vec3, b->count);
    if (other == NULL) return NAN;
    sn_box box = sn_mesh_box(&b->muscle->mesh);
    for (sn_index v = 0; v < b->muscle->mesh.vertex_count; v++) b->surface[v] = bent(b->muscle->mesh.positions[v], box);
    sn_embedding_apply(all, b->surface, pool, b->moved);
    sn_embedding_apply(few, b->surface, pool, other);
    double sum = 0.0;
    for (sn_index i = 0; i < b->count; i++) sum += sn_distance(b->moved[i], other[i]);
    free(other);
    return sum / (double)b->count;
}

static sn_status measure_embedding(binding *b, totals *t, sn_error *error) {
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding all = {0}, few = {0};
    params.pool = pool;
    double start = now(), diagonal = sn_box_diagonal(sn_mesh_box(&b->muscle->mesh));
    sn_status status = sn_embedding_build(&b->muscle->mesh, b->count, b->points, &params, &all, error);
    double seconds = now() - start;
    params.cut = 3e-4;
    if (status == SN_OK) status = sn_embedding_build(&b->muscle->mesh, b->count, b->points, &params, &few, error);
    if (status == SN_OK) {
        double affine = affine_error(b, &all), affine_cut = affine_error(b, &few), bending = bending_error(b, &all, &few);
        printf("embedding: %d points in %d triangles: %.2f s of processor time; largest error on an affine map %.2g of the size, cut at "
               "3e-4 %.2g; the cut in a "
               "bend of 40 degrees: %.3f on average, of %.0f; weights dropped %.3f of 1\n",
               b->count, b->muscle->mesh.triangle_count, seconds, affine / diagonal, affine_cut / diagonal, bending, diagonal,
               few.report.dropped_mean);
        bool good = affine <= 1e-9 * diagonal && affine_cut <= 1e-9 * diagonal && bending <= 2e-3 * diagonal;
        t->passed += good;
        t->failed += !good;
    }
    sn_embedding_free(&all);
    sn_embedding_free(&few);
    return status;
}

/* Every `step`-th fibre vertex. */
static sn_status bind(const sn_muscle *m, sn_index step, totals *t, sn_error *error) {
    binding b = {.muscle = m, .points = SN_NEW(sn_vec3, 1600), .moved = SN_NEW(sn_vec3, 1600)};
    b.surface = SN_NEW(sn_vec3, m->mesh.vertex_count);
    sn_status status = b.points && b.moved && b.surface ? SN_OK : sn_fail_memory(error, "the points");
    for (sn_index i = 0, n = 0; status == SN_OK && i < m->fibers.polyline_count; i++)
        for (sn_index k = 0; k < m->fibers.polylines[i].count && b.count < 1600; k++)
            if (n++ % step == 0) b.points[b.count++] = m->fibers.polylines[i].points[k];
    if (status == SN_OK) status = measure_embedding(&b, t, error);
    free(b.points);
    free(b.moved);
    free(b.surface);
    return status;
}

static void process_embedding(const char *data, sn_index step, totals *t) {
    char path[4096];
    sn_muscle m = {.meters_per_unit = 1e-3};
    sn_error error = {0};
    outcome o = {0};
    snprintf(path, sizeof path, "%s/leg-vhf/meshes/VHF_Left_Muscle_PeroneusLongus_smooth.ply", data);
    sn_status status = sn_mesh_read(path, &m.mesh, NULL, &error);
    if (status == SN_OK) status = fill_muscle(&m, &o, &error);
    if (status == SN_OK) status = bind(&m, step, t, &error);
    if (status != SN_OK) printf("embedding: %s\n", error.text);
    t->failed += status != SN_OK;
    sn_muscle_free(&m);
}

/* ---- sets ---------------------------------------------------------------------------------------------------------------- */

/* Arched sheets, several heads, many tendons. */
static const char *const hard[] = {"VHF_Left_Muscle_GluteusMaximus_smooth.ply", "VHF_Left_Muscle_VastusIntermedius_smooth.ply",
                                   "MUSCm.gastrocnemius_L.stl", "MUSCm.flexor_digitorum_profundus_L(2).stl"};

static bool is_hard(const char *name, size_t length) {
    for (size_t i = 0; i < sizeof hard / sizeof *hard; i++)
        if (strlen(hard[i]) == length && strncmp(hard[i], name, length) == 0) return true;
    return false;
}

static void process_set(const char *data, const char *name, bool all, totals *t) {
    char path[4096];
    sn_blob manifest;
    sn_error error = {0};
    snprintf(path, sizeof path, "%s/%s/manifest.tsv", data, name);
    if (sn_blob_read(path, &manifest, &error) != SN_OK) {
        printf("%s\n", error.text);
        t->failed++;
        return;
    }
    char *rest = NULL;
    int number = 0;
    for (char *line = strtok_r(manifest.data, "\n", &rest); line != NULL; line = strtok_r(NULL, "\n", &rest)) {
        char *kind = strchr(line, '\t');
        if (kind == NULL || strncmp(kind, "\tmuscle\t", 8) != 0) continue;
        if (number++ % EVERY != 0 && !all && !is_hard(line, (size_t)(kind - line))) continue;
        snprintf(path, sizeof path, "%s/%s/meshes/%.*s", data, name, (int)(kind - line), line);
        process(path, t);
    }
    sn_blob_free(&manifest);
}

static void print_totals(const char *name, const totals *t) {
    int count = t->passed + t->failed;
    printf("%s: %d of %d muscles had less than 1 %% of their fibre vertices outside before the pull (%ld of %ld); after it %ld; processor "
           "time "
           "%.0f ms on average, %.0f after the field; at most %.0f and %.0f for 18k to 22k triangles\n",
           name, t->few_outside, count, t->outside_before, t->vertices, t->outside_after, 1e3 * t->seconds / count,
           1e3 * t->after_field / count, 1e3 * t->timed, 1e3 * t->timed_after_field);
}

/* Counts that a study of methods over these muscles reached with a harmonic map of the slices. */
static const struct {
    const char *name;
    int muscles, few_outside;
} sets[] = {{"leg-vhf", 38, 31}, {"dog-dmcontrol", 253, 235}};

static int finish(int passed, int failed) {
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}

static int run_sets(const char *data, bool all) {
    totals sum = {0};
    print_header();
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        totals t = {0};
        process_set(data, sets[i].name, all, &t);
        print_totals(sets[i].name, &t);
        bool complete = !all || (t.passed + t.failed == sets[i].muscles && t.few_outside >= sets[i].few_outside);
        sum.passed += t.passed + complete;
        sum.failed += t.failed + !complete;
    }
    process_embedding(data, all ? 1 : 8, &sum);
    return finish(sum.passed, sum.failed);
}

static int run_files(int count, char **paths) {
    totals t = {0};
    print_header();
    for (int i = 0; i < count; i++) process(paths[i], &t);
    print_totals("all", &t);
    return finish(t.passed, t.failed);
}

static bool exists(const char *data) {
    char path[4096];
    snprintf(path, sizeof path, "%s/leg-vhf/manifest.tsv", data);
    FILE *file = fopen(path, "r");
    if (file != NULL) fclose(file);
    return file != NULL;
}

int main(int argc, char **argv) {
    const char *data = getenv("DATA");
    bool all = argc == 2 && strcmp(argv[1], "all") == 0;
    int code = 0;
    pool = sn_pool_create(0);
    if (pool == NULL) return finish(0, 1);
    if (argc > 1 && !all)
        code = run_files(argc - 1, argv + 1);
    else if (data != NULL && exists(data))
        code = run_sets(data, all);
    else
        printf("no real anatomy at %s: skipped\n1 passed, 0 failed\n", data ? data : "$DATA");
    sn_pool_destroy(pool);
    return code;
}
