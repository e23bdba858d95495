/*
 * wrecks.c -- thousands of wrecks with known truth: a closed body is broken in ways drawn at random, several at once, and cleaned. What
 * comes out must be a closed, oriented manifold that encloses the volume of the whole body, and must not change when cleaned again. Usage:
 * wrecks [DRAWS [SEED]]; prints every failure with its seed and recipe, then "N passed, N failed".
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/rig.h"

#define ROWS 9
#define COLUMNS 14
#define RING(r) ((sn_index)((r)*COLUMNS))

/* ---- drawing ---------------------------------------------------------------------------------------------------------- */

static uint64_t seed;
static double draw(double low, double high) { return low + (high - low) * sn_random(&seed); }
static sn_index draw_index(sn_index count) {
    sn_index i = (sn_index)(sn_random(&seed) * count);
    return i < count ? i : count - 1;
}
static bool draw_true(double chance) { return sn_random(&seed) < chance; }

/* ---- the whole body --------------------------------------------------------------------------------------------------- */

#define MOST_VERTICES 20000
#define MOST_TRIANGLES 10000

typedef struct wreck {
    sn_mesh mesh;
    double volume, edge; /* of the whole body; the shortest edge between rings near the middle */
    double slack;        /* how much of the volume the damage may cost */
    bool has_nan, is_split;
    char recipe[512];
} wreck;

static void note(wreck *w, const char *what) {
    size_t used = strlen(w->recipe);
    snprintf(w->recipe + used, sizeof w->recipe - used, " %s", what);
}

static void add_triangle(sn_mesh *m, sn_index a, sn_index b, sn_index c) { m->triangles[m->triangle_count++] = (sn_triangle){{a, b, c}}; }

static sn_index add_vertex(sn_mesh *m, sn_vec3 p) {
    m->positions[m->vertex_count] = p;
    return m->vertex_count++;
}

/* An ellipsoid of rings and two poles, the north first triangle fan last. */
static bool build_body(wreck *w) {
    *w = (wreck){.slack = 1e-9};
    if (sn_mesh_alloc(&w->mesh, MOST_VERTICES, MOST_TRIANGLES, NULL) != SN_OK) return false;
    sn_mesh *m = &w->mesh;
    m->vertex_count = m->triangle_count = 0;
    sn_vec3 radii = sn_v3(draw(0.5, 1.0), draw(0.5, 1.0), draw(1.0, 2.5));
    sn_vec3 centre = sn_v3(draw(-5, 5), draw(-5, 5), draw(-5, 5));
    for (int r = 0; r < ROWS; r++) {
        double polar = SN_PI * (r + 1) / (ROWS + 1);
        for (int c = 0; c < COLUMNS; c++) {
            double turn = 2.0 * SN_PI * c / COLUMNS;
            sn_vec3 p = sn_v3(radii.x * sin(polar) * cos(turn), radii.y * sin(polar) * sin(turn), radii.z * cos(polar));
            add_vertex(m, sn_add(centre, p));
        }
    }
    sn_index north = add_vertex(m, sn_add(centre, sn_v3(0, 0, radii.z))), south = add_vertex(m, sn_add(centre, sn_v3(0, 0, -radii.z)));
    for (sn_index c = 0; c < COLUMNS; c++) {
        sn_index next = (c + 1) % COLUMNS;
        add_triangle(m, north, c, next);
        add_triangle(m, south, RING(ROWS - 1) + next, RING(ROWS - 1) + c);
        for (sn_index r = 0; r + 1 < ROWS; r++) {
            sn_index a = RING(r) + c, b = RING(r) + next;
            add_triangle(m, a, a + COLUMNS, b + COLUMNS);
            add_triangle(m, a, b + COLUMNS, b);
        }
    }
    w->volume = sn_mesh_volume(m);
    w->edge = sn_distance(m->positions[RING(4)], m->positions[RING(4) + 1]);
    for (int c = 0; c < COLUMNS; c++)
        w->edge = fmin(w->edge, sn_distance(m->positions[RING(4) + c], m->positions[RING(4) + (c + 1) % COLUMNS]));
    return true;
}

/* ---- damage ----------------------------------------------------------------------------------------------------------- */

/* Cut along the middle ring, part or all of the way around, and open it by at most a fifth of its edges. */
static void crack(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_index count = 2 + draw_index(COLUMNS - 1), old = m->vertex_count; /* 2 .. COLUMNS */
    double gap = w->edge * pow(10.0, draw(-9.0, -0.7));
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 p = m->positions[RING(4) + i];
        add_vertex(m, sn_add(p, sn_v3(0, 0, gap)));
    }
    /* triangles above the ring take the copies: those that have a corner in ring 3 */
    for (sn_index t = 0; t < m->triangle_count; t++) {
        bool above = false;
        for (int k = 0; k < 3; k++) above = above || (m->triangles[t].v[k] >= RING(3) && m->triangles[t].v[k] < RING(4));
        for (int k = 0; above && k < 3; k++) {
            sn_index v = m->triangles[t].v[k];
            if (v >= RING(4) && v < RING(4) + count) m->triangles[t].v[k] = old + v - RING(4);
        }
    }
    w->slack += 0.05;
    note(w, "crack");
}

/* Holes of a triangle or two in every fourth column of the rows below the middle. */
static void open_holes(wreck *w) {
    sn_index base = 0, columns = 1 + draw_index(3);
    for (sn_index t = 0; t < w->mesh.triangle_count; t++) {
        const sn_index *v = w->mesh.triangles[t].v;
        bool goes = false;
        for (sn_index i = 0; i < columns; i++) goes = goes || (v[0] == RING(6) + 4 * i && v[1] == RING(7) + 4 * i);
        if (!goes) w->mesh.triangles[base++] = w->mesh.triangles[t];
    }
    w->mesh.triangle_count = base;
    w->slack += 0.02;
    note(w, "holes");
}

static void flip_patch(wreck *w) {
    sn_index count = 1 + draw_index(w->mesh.triangle_count / 3), first = draw_index(w->mesh.triangle_count - count);
    for (sn_index t = first; t < first + count; t++) {
        sn_index kept = w->mesh.triangles[t].v[1];
        w->mesh.triangles[t].v[1] = w->mesh.triangles[t].v[2];
        w->mesh.triangles[t].v[2] = kept;
    }
    note(w, "flipped");
}

static void turn_inside_out(wreck *w) {
    for (sn_index t = 0; t < w->mesh.triangle_count; t++) {
        sn_index kept = w->mesh.triangles[t].v[1];
        w->mesh.triangles[t].v[1] = w->mesh.triangles[t].v[2];
        w->mesh.triangles[t].v[2] = kept;
    }
    note(w, "inside-out");
}

/* All triangles once more, on the same vertices or on copies of them. */
static void double_shell(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_index count = m->triangle_count, vertices = m->vertex_count;
    bool copies = draw_true(0.5);
    for (sn_index v = 0; copies && v < vertices; v++) add_vertex(m, m->positions[v]);
    for (sn_index t = 0; t < count; t++) {
        const sn_index *v = m->triangles[t].v;
        sn_index shift = copies ? vertices : 0;
        add_triangle(m, v[0] + shift, v[1] + shift, v[2] + shift);
    }
    note(w, copies ? "doubled-apart" : "doubled");
}

/* Triangles that stand on an edge of the surface, in the rows next to the north pole, which nothing else touches. */
static void add_fins(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_index fins = 1 + draw_index(3);
    for (sn_index i = 0; i < fins; i++) {
        sn_index a = RING(1) + 4 * i, b = a + 1;
        sn_vec3 out = sn_sub(m->positions[a], m->positions[RING(1) + (4 * i + COLUMNS / 2) % COLUMNS]);
        sn_index tip = add_vertex(m, sn_add_scaled(m->positions[a], out, draw(0.05, 0.2)));
        add_triangle(m, a, b, tip);
    }
    note(w, "fins");
}

/* The same body again, smaller and elsewhere: it is dropped. */
static void add_copy(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_index count = m->triangle_count, vertices = m->vertex_count;
    for (sn_index v = 0; v < vertices; v++) add_vertex(m, sn_add(sn_scale(m->positions[v], 0.5), sn_v3(30, 0, 0)));
    for (sn_index t = 0; t < count; t++) {
        const sn_index *v = m->triangles[t].v;
        add_triangle(m, v[0] + vertices, v[1] + vertices, v[2] + vertices);
    }
    note(w, "copy");
}

static void add_strays(wreck *w) {
    sn_mesh *m = &w->mesh;
    add_vertex(m, sn_v3(draw(-1, 1), 0, 0));
    sn_index v = draw_index(ROWS * COLUMNS);
    add_triangle(m, v, v, v + 1);
    note(w, "strays");
}

/* A soup: every corner a vertex of its own, off by at most 1e-8. */
static void fall_apart(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_mesh old;
    if (sn_mesh_copy(m, &old, NULL) != SN_OK) return;
    m->vertex_count = 0;
    for (sn_index t = 0; t < old.triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_vec3 jitter = sn_v3(draw(-1e-8, 1e-8), draw(-1e-8, 1e-8), draw(-1e-8, 1e-8));
            m->triangles[t].v[k] = add_vertex(m, sn_add(old.positions[old.triangles[t].v[k]], jitter));
        }
    }
    sn_mesh_free(&old);
    w->slack += 1e-6;
    note(w, "soup");
}

static void poison(wreck *w) {
    sn_mesh *m = &w->mesh;
    sn_index v = add_vertex(m, sn_v3(draw_true(0.5) ? NAN : INFINITY, 0, 0));
    add_triangle(m, v, draw_index(ROWS * COLUMNS), 0);
    w->has_nan = true;
    note(w, "nan");
}

static bool make_wreck(wreck *w) {
    if (!build_body(w)) return false;
    if (draw_true(0.4)) crack(w);
    if (draw_true(0.4)) open_holes(w);
    if (draw_true(0.3)) flip_patch(w);
    if (draw_true(0.3)) turn_inside_out(w);
    if (draw_true(0.3)) add_fins(w);
    if (draw_true(0.3)) double_shell(w);
    if (draw_true(0.3)) add_copy(w);
    if (draw_true(0.3)) add_strays(w);
    if (draw_true(0.2)) fall_apart(w);
    if (draw_true(0.1)) poison(w);
    return true;
}

/* ---- truth ------------------------------------------------------------------------------------------------------------ */

static bool say(const wreck *w, uint64_t start, const char *what, double value, double wanted) {
    printf("seed %llu:%s: %s: %.9g, wanted %.9g\n", (unsigned long long)start, w->recipe, what, value, wanted);
    return false;
}

static bool is_sound(const sn_mesh_report *r) {
    return r->closed && r->manifold && r->oriented && r->outward && r->degenerate_triangles == 0 && r->duplicate_triangles == 0;
}

/* Cleaned again with the same wishes, nothing changes. */
static bool stays(const wreck *w, uint64_t start, const sn_mesh *cleaned, const sn_clean_params *params) {
    sn_mesh again = {0};
    sn_clean_report report = {0};
    sn_status status = sn_clean(cleaned, params, NULL, &again, &report, NULL);
    bool unchanged = status == SN_OK && report.unchanged;
    if (status == SN_OK) sn_clean_report_free(&report);
    sn_mesh_free(&again);
    return unchanged ||
           say(w, start, params->keep == 1 ? "cleaned again it changes" : "cleaned again with all components it changes", 1, 0);
}

static bool judge(const wreck *w, uint64_t start, const sn_mesh *out, const sn_clean_report *r, const sn_clean_params *params) {
    if (!is_sound(&r->after)) return say(w, start, "not sound; boundary edges", r->after.boundary_edges, 0);
    if (params->keep == 1) {
        if (r->after.components != 1) return say(w, start, "components", r->after.components, 1);
        if (r->after.genus != 0.0) return say(w, start, "genus", r->after.genus, 0);
        double change = fabs(r->after.volume / w->volume - 1.0);
        if (change > w->slack) return say(w, start, "volume", r->after.volume, w->volume);
    }
    return stays(w, start, out, params);
}

static bool refused(const wreck *w, uint64_t start) {
    sn_clean_params params = sn_clean_defaults();
    sn_mesh out = {0};
    sn_clean_report report = {0};
    sn_error error = {0};
    sn_status status = sn_clean(&w->mesh, &params, NULL, &out, &report, &error);
    bool good = status == SN_ERROR_INPUT && strstr(error.text, "finite") != NULL;
    if (status == SN_OK) sn_clean_report_free(&report);
    sn_mesh_free(&out);
    return good || say(w, start, "not refused; status", (double)status, SN_ERROR_INPUT);
}

static bool clean_one(const wreck *w, uint64_t start, sn_index keep) {
    sn_clean_params params = sn_clean_defaults();
    params.keep = keep;
    params.repair_nonfinite = w->has_nan;
    sn_mesh out = {0};
    sn_clean_report report = {0};
    sn_error error = {0};
    if (sn_clean(&w->mesh, &params, NULL, &out, &report, &error) != SN_OK) return say(w, start, error.text, 1, 0);
    bool good = judge(w, start, &out, &report, &params);
    sn_clean_report_free(&report);
    sn_mesh_free(&out);
    return good;
}

int main(int argc, char **argv) {
    long draws = argc > 1 ? strtol(argv[1], NULL, 10) : 2000, passed = 0, failed = 0;
    uint64_t first = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    for (long i = 0; i < draws; i++) {
        wreck w;
        uint64_t start = first + (uint64_t)i;
        seed = start * 0x9e3779b97f4a7c15u;
        bool good = make_wreck(&w);
        if (good && w.has_nan) good = refused(&w, start);
        if (good) good = clean_one(&w, start, 1) && clean_one(&w, start, 0);
        *(good ? &passed : &failed) += 1;
        sn_mesh_free(&w.mesh);
    }
    printf("%ld passed, %ld failed\n", passed, failed);
    return failed > 0;
}
