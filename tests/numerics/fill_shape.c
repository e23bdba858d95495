/*
 * fill_shape.c -- the shape of 100 fibres of 15 segments from tip to tip: how much each turns, how many turn back, how much of the muscle
 * they leave empty, and how many bend more than it does. One TSV line a muscle, then sums.
 *
 *   DATA=FOLDER fill_shape        every 24th of the muscles of leg-vhf and dog-dmcontrol, and those of `aside`
 *   DATA=FOLDER fill_shape all    all of them
 *   fill_shape FILE...            these surfaces, or muscle documents with the ends that they have
 *
 * Those of `aside` have parts without an end of their own, at which fibres turned aside and back: 54 of 100 by more than 120 degrees in the
 * diaphragm, 44 in the gluteus minimus, 23 in the serratus ventralis. In the longissimus cervicis 31 still do: passing them by would leave
 * one of its heads too few fibres.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/io.h"
#include "sinew/rig.h"

#define DEGREES (180.0 / SN_PI)
#define BACK 120.0 /* degrees between two segments: the fibre turns back */

enum { EVERY = 24 };

static sn_pool *pool;
static int passed, failed;

static void verdict(bool good, const char *what) {
    passed += good;
    failed += !good;
    if (!good) printf("NOT REACHED: %s\n", what);
}

typedef struct shape {
    sn_fill_report report;
    double mean_turn, greatest_turn; /* degrees, from end to end */
    int back;                        /* fibres that turn back */
} shape;

typedef struct sums {
    int muscles, back, empty, bent;
    double turn;
} sums;

static double turn_at(const sn_polyline *line, sn_index k) {
    sn_vec3 a = sn_sub(line->points[k], line->points[k - 1]), b = sn_sub(line->points[k + 1], line->points[k]);
    return atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b)) * DEGREES;
}

static void measure(const sn_fibers *f, shape *s) {
    for (sn_index i = 0; i < f->polyline_count; i++) {
        const sn_polyline *line = &f->polylines[i];
        double turn = 0.0, most = 0.0;
        for (sn_index k = 1; k + 1 < line->count; k++) {
            turn += turn_at(line, k);
            most = fmax(most, turn_at(line, k));
        }
        s->mean_turn += turn / f->polyline_count;
        s->greatest_turn = fmax(s->greatest_turn, turn);
        s->back += most > BACK;
    }
}

static sn_status read_surface(const char *path, sn_muscle *m, sn_error *error) {
    sn_roots_params roots = sn_roots_defaults();
    sn_structure_params structure = sn_structure_defaults();
    sn_roots_report roots_report;
    sn_structure_report structure_report;
    sn_status status = sn_mesh_read(path, &m->mesh, NULL, error);
    if (!status) status = sn_roots_select(m, &roots, NULL, &m->roots, &roots_report, error);
    return status ? status : sn_structure_build(m, &structure, NULL, &m->structure, &structure_report, error);
}

static sn_status read_document(const char *path, sn_muscle *m, sn_error *error) {
    sn_blob blob = {0};
    sn_document *document = NULL;
    sn_status status = sn_blob_read(path, &blob, error);
    if (!status) status = sn_muscle_parse(&blob, &(sn_read_options){0}, m, &document, error);
    sn_document_free(document);
    sn_blob_free(&blob);
    sn_fibers_free(&m->fibers);
    return status;
}

/* Returns how many fibres turn back, -1 where there are none. */
static int process(const char *path, sums *t) {
    sn_muscle m = {.meters_per_unit = 1.0};
    sn_error error = {0};
    shape s = {0};
    sn_fill_params fill = sn_fill_defaults();
    fill.pool = pool;
    sn_status status = strstr(path, ".json") ? read_document(path, &m, &error) : read_surface(path, &m, &error);
    if (!status) status = sn_fill_fibers(&m, &fill, NULL, &m.fibers, &s.report, &error);
    const sn_fill_report *r = &s.report;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (status) {
        printf("%s\t%s\n", name, error.text);
        verdict(false, name);
    } else {
        measure(&m.fibers, &s);
        printf("%s\t%d\t%s\t%s\t%.1f\t%.1f\t%d\t%.3f\t%.4g\t%.2f\t%d\n", name, m.mesh.triangle_count, r->chosen.from,
               r->flux ? "flux" : "length", s.mean_turn, s.greatest_turn, s.back, r->empty, r->spacing, r->greatest_bend, r->bent);
        t->muscles++;
        t->back += s.back;
        t->turn += s.mean_turn;
        t->empty += r->empty > 0.1;
        t->bent += r->bent > 0;
    }
    sn_muscle_free(&m);
    return status ? -1 : s.back;
}

/* ---- sets ------------------------------------------------------------------------------------------------------------------------ */

static const char *const aside[] = {"MUSCdiaphragma.stl",

                                    "MUSCm.tranversus_abdominis_R.stl", "MUSCMm.thoracis_serratus_ventr_L.stl",
                                    "VHF_Left_Muscle_GluteusMinimus_smooth.ply", "VHF_Left_Muscle_ObturatorInternus_smooth.ply"};

static bool is_aside(const char *name) {
    for (size_t i = 0; i < sizeof aside / sizeof *aside; i++)
        if (strcmp(aside[i], name) == 0) return true;
    return false;
}

static sums process_set(const char *data, const char *name, bool all) {
    char path[4096], file[512];
    sn_blob manifest = {0};
    sn_error error = {0};
    sums t = {0};
    int number = 0;
    snprintf(path, sizeof path, "%s/%s/manifest.tsv", data, name);
    if (sn_blob_read(path, &manifest, &error)) verdict(false, error.text);
    for (const char *line = manifest.data; line && *line; line = strchr(line, '\n'), line += line != NULL) {
        const char *kind = strchr(line, '\t');
        if (!kind || strncmp(kind, "\tmuscle\t", 8) != 0) continue;
        snprintf(file, sizeof file, "%.*s", (int)(kind - line), line);
        if (number++ % EVERY != 0 && !all && !is_aside(file)) continue;
        snprintf(path, sizeof path, "%s/%s/meshes/%s", data, name, file);
        int back = process(path, &t);
        if (is_aside(file)) verdict(back == 0, file);
    }
    printf(
        "%s: %d muscles; fibres turn by %.1f degrees on average; %d of them turn back; %d muscles have more than a tenth empty, %d fibres "
        "that bend more than they do\n",
        name, t.muscles, t.turn / fmax(t.muscles, 1.0), t.back, t.empty, t.bent);
    sn_blob_free(&manifest);
    return t;
}

static bool exists(const char *data) {
    char path[4096];
    snprintf(path, sizeof path, "%s/dog-dmcontrol/manifest.tsv", data);
    FILE *file = fopen(path, "r");
    if (file != NULL) fclose(file);
    return file != NULL;
}

static void process_sets(const char *data, bool all) {
    sums leg = process_set(data, "leg-vhf", all), dog = process_set(data, "dog-dmcontrol", all);
    if (!all) return;
    verdict(leg.muscles == 38 && dog.muscles == 253, "38 and 253 muscles");
    verdict(leg.back == 0, "no fibre of a leg turns back");
    verdict(dog.back <= 300, "300 of the dog's 25,300 fibres turn back; 406 did");
    verdict(dog.turn <= 120.0 * dog.muscles && leg.turn <= 120.0 * leg.muscles, "fibres turn by no more than 120 degrees on average");
}

int main(int argc, char **argv) {
    const char *data = getenv("DATA");
    bool all = argc == 2 && strcmp(argv[1], "all") == 0;
    sums t = {0};
    pool = sn_pool_create(0);
    if (pool == NULL) return 1;
    printf("muscle\ttriangles\tends\tslices\tmean_turn\tgreatest_turn\tback\tempty\tspacing\tlength_over_chord\tbent\n");
    if (argc > 1 && !all)
        for (int i = 1; i < argc; i++) verdict(process(argv[i], &t) >= 0, argv[i]);
    else if (data != NULL && exists(data))
        process_sets(data, all);
    else
        printf("no real anatomy at %s: skipped\n", data ? data : "$DATA"), passed++;
    sn_pool_destroy(pool);
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
