/*
 * fill_shape.c -- the shape of fibres: how much each turns, whether it reverses, how much of the muscle is left empty.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/io.h"
#include "sinew/rig.h"

#define DEGREES (180.0 / SN_PI)

static sn_pool *pool;

typedef struct shape {
    sn_fill_report report;
    double mean_turn, greatest_turn, greatest_bend;         /* degrees; length over chord */
    int sharp, back, reversed, most_reversals, long_fibers; /* fibres that turn by more than 60, 90, 120 degrees at a vertex */
} shape;

static double turn_at(const sn_polyline *line, sn_index k) {
    sn_vec3 a = sn_sub(line->points[k], line->points[k - 1]), b = sn_sub(line->points[k + 1], line->points[k]);
    return atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b)) * DEGREES;
}

static void measure(const sn_fibers *f, shape *s) {
    for (sn_index i = 0; i < f->polyline_count; i++) {
        const sn_polyline *line = &f->polylines[i];
        double turn = 0.0, most = 0.0;
        int reversals = 0;
        for (sn_index k = 1; k + 1 < line->count; k++) {
            double at = turn_at(line, k);
            turn += at;
            most = fmax(most, at);
            reversals += at > 120.0;
        }
        s->mean_turn += turn / f->polyline_count;
        s->greatest_turn = fmax(s->greatest_turn, turn);
        s->sharp += most > 60.0;
        s->back += most > 90.0;
        s->reversed += most > 120.0;
        if (reversals > s->most_reversals) s->most_reversals = reversals;
        double bend = line->length / fmax(sn_distance(line->points[0], line->points[line->count - 1]), 1e-300);
        s->greatest_bend = fmax(s->greatest_bend, bend);
        s->long_fibers += bend > 1.5;
    }
}

static sn_status prepare(sn_muscle *m, sn_error *error) {
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_roots_report roots_report;
    sn_structure_report structure_report;
    sn_status status = sn_roots_select(m, &roots, NULL, &m->roots, &roots_report, error);
    return status ? status : sn_structure_build(m, &structure, NULL, &m->structure, &structure_report, error);
}

static void process(const char *path) {
    sn_muscle m = {.meters_per_unit = 1.0};
    sn_document *document = NULL;
    sn_blob blob = {0};
    sn_error error = {0};
    shape s = {0};
    bool bare = strstr(path, ".json") == NULL;
    sn_fill_params fill = sn_fill_defaults();
    fill.pool = pool;
    sn_status status = bare ? sn_mesh_read(path, &m.mesh, NULL, &error) : sn_blob_read(path, &blob, &error);
    if (!status) status = bare ? prepare(&m, &error) : sn_muscle_parse(&blob, &(sn_read_options){0}, &m, &document, &error);
    sn_fibers_free(&m.fibers);
    if (!status) status = sn_fill_fibers(&m, &fill, NULL, &m.fibers, &s.report, &error);
    const char *slash = strrchr(path, '/');
    if (status) {
        printf("%s\t%s\n", slash ? slash + 1 : path, error.text);
    } else {
        measure(&m.fibers, &s);
        printf("%s\t%d\t%s\t%.3f\t%.4g\t%.1f\t%.1f\t%d\t%d\t%d\t%d\t%.2f\t%d\t%d\t%d\t%s\t%.2f\t%d\n", slash ? slash + 1 : path,
               m.mesh.triangle_count, s.report.chosen.from ? s.report.chosen.from : "-", s.report.empty, s.report.spacing, s.mean_turn,
               s.greatest_turn, s.sharp, s.back, s.reversed, s.most_reversals, s.greatest_bend, s.long_fibers, s.report.outside_before,
               s.report.outside_after, s.report.flux ? "flux" : "length", s.report.muscle_bend, s.report.bent);
    }
    sn_blob_free(&blob);
    sn_document_free(document);
    sn_muscle_free(&m);
}

int main(int argc, char **argv) {
    pool = sn_pool_create(0);
    printf("muscle\ttriangles\tends\tempty\tspacing\tmean_turn\tgreatest_turn\tsharp\tback\treversed\tmost\tbend\tlong\tout_before\tout_"
           "after\trims\tmuscle_bend\tbent\n");
    for (int i = 1; i < argc; i++) process(argv[i]);
    sn_pool_destroy(pool);
    return 0;
}
