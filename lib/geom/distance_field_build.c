/*
 * distance_field_build.c -- tables of signed distances.
 *
 * Distances are those to the closest triangle of the solid's boundary, in double (sn_surface_closest). Signs come from the winding number
 * of the closed surface, which is an integer: evaluated at few corners, and carried on from one corner to the next where their distances
 * say that no surface passes between. So pieces that overlap, cross or lie within each other need no case of their own, and no sign
 * hangs on a normal.
 */
#include "sinew/distance_field.h"
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "winding_tree.h"

enum { N = SN_BRICK_CELLS, CORNERS = N * N * N, GRAIN = 64 };

/* Limits, and what a brick is taken to need in advance. */
static const double most_bytes = 1e9, most_cells = 2147483648.0;
/* Nearer to the surface than this share of a cell the sign of a corner is no ground for others. */
static const double on_surface = 1e-6;

typedef struct build {
    sn_distance_field *field;
    const sn_mesh *boundary;
    sn_surface *surface; /* of boundary */
    sn_winding_tree winding;
    sn_index count;       /* of bricks that may be needed */
    sn_index *candidates; /* (count) their places, upwards */
    bool *needed;         /* (count) */
    sn_index coarse[3];   /* corners of the coarse grid */
    size_t coarse_count;
} build;

/* ---- the grid's size ---------------------------------------------------------------------------------------------------------- */

static double bricks_along(double length, double cell, double band) { return ceil((length / cell + 2.0 * (band + 1.01)) / N); }

/* About what a field takes: the grid, and bricks for the area, of which some are dropped again. */
static double estimate_bytes(sn_vec3 size, double area, double cell, double band) {
    double places = bricks_along(size.x, cell, band) * bricks_along(size.y, cell, band) * bricks_along(size.z, cell, band);
    double width = N * cell, layers = 2.0 + 2.0 * band / N;
    double bricks = fmin(places, 1.1 * layers * area / (width * width) + 8.0);
    return 36.0 * places + 4.0 * SN_BRICK_VALUES * bricks;
}

static double estimate_cells(sn_vec3 size, double cell, double band) {
    return (double)CORNERS * bricks_along(size.x, cell, band) * bricks_along(size.y, cell, band) * bricks_along(size.z, cell, band);
}

static sn_status check_params(const sn_distance_field_params *p, sn_error *error) {
    if (!(p->cell > 0.0 && p->cell <= 1e9))
        return sn_fail(error, SN_ERROR_USAGE, "a distance field's cell is %g, and must be a length above 0 and up to 1e9", p->cell);
    if (!(p->band >= 1.0 && p->band <= 16.0))
        return sn_fail(error, SN_ERROR_USAGE, "a distance field's band is %g cells; 1 to 16 are possible, 3 is usual", p->band);
    return SN_OK;
}

/* The smallest cell, of three digits or so, that a field fits with. */
static double cell_that_fits(sn_vec3 size, double area, double cell, double band) {
    while (isfinite(cell) && (estimate_bytes(size, area, cell, band) > most_bytes || estimate_cells(size, cell, band) > most_cells))
        cell *= 1.05;
    return cell;
}

/* Corners must differ by more than the rounding of their coordinates. */
static sn_status check_place(const sn_distance_field *f, sn_error *error) {
    sn_vec3 far = sn_max3(f->box.high, sn_neg(f->box.low));
    double most = fmax(fmax(fabs(far.x), fabs(far.y)), fabs(far.z));
    if (f->cell > 1e-9 * most && isfinite(most)) return SN_OK;
    return sn_fail(error, SN_ERROR_USAGE, "cells of %g cannot be told apart at coordinates of %.3g; move the surface to the origin",
                   f->cell, most);
}

static sn_status check_size(const build *b, sn_error *error) {
    const sn_distance_field *f = b->field;
    sn_vec3 size = sn_sub(f->box.high, f->box.low);
    double area = sn_mesh_area(b->boundary), band = f->band / f->cell, fits = cell_that_fits(size, area, f->cell, band);
    if (fits == f->cell) return SN_OK;
    return sn_fail(error, SN_ERROR_USAGE,
                   "a distance field of cells of %g would take more than about 1 GB for this surface; a cell of %.3g fits", f->cell,
                   1.01 * fits);
}

/* As many bricks as the surface and the band need, around the middle of its box. */
static void lay_out(build *b) {
    sn_distance_field *f = b->field;
    sn_vec3 size = sn_sub(f->box.high, f->box.low), middle = sn_lerp(f->box.low, f->box.high, 0.5);
    const double length[3] = {size.x, size.y, size.z};
    b->coarse_count = 1;
    for (int k = 0; k < 3; k++) {
        f->bricks[k] = (sn_index)bricks_along(length[k], f->cell, f->band / f->cell);
        b->coarse[k] = 2 * f->bricks[k] + 1;
        b->coarse_count *= (size_t)b->coarse[k];
    }
    double half = 0.5 * N * f->cell;
    f->origin = sn_sub(middle, sn_v3(half * f->bricks[0], half * f->bricks[1], half * f->bricks[2]));
}

/* ---- distances ------------------------------------------------------------------------------------------------------------------- */

static sn_vec3 corner_point(const sn_distance_field *f, sn_index i, sn_index j, sn_index k) {
    return sn_v3(f->origin.x + i * f->cell, f->origin.y + j * f->cell, f->origin.z + k * f->cell);
}

/* The distance of p, which is `step` away from a point that has the distance `known` (INFINITY = not known). */
static double distance_near(const build *b, sn_vec3 p, double known, double step) {
    sn_closest c = sn_surface_closest(b->surface, p, (known + step) * (1.0 + 1e-9));
    return c.triangle != SN_NONE ? c.distance : sn_surface_closest(b->surface, p, INFINITY).distance;
}

static bool is_inside(const build *b, sn_vec3 p) { return fabs(sn_winding_tree_number(&b->winding, p)) > 0.5; }

/* Rows of the coarse grid, without sign. */
static void measure_coarse_rows(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const build *b = user;
    (void)chunk;
    for (sn_index row = begin; row < end; row++) {
        float *values = b->field->coarse + (size_t)row * (size_t)b->coarse[0];
        sn_index j = SN_COARSE_CELLS * (row % b->coarse[1]), k = SN_COARSE_CELLS * (row / b->coarse[1]);
        double known = INFINITY;
        for (sn_index i = 0; i < b->coarse[0]; i++) {
            known = distance_near(b, corner_point(b->field, SN_COARSE_CELLS * i, j, k), known, SN_COARSE_CELLS * b->field->cell);
            values[i] = (float)known;
        }
    }
}

/* ---- signs ----------------------------------------------------------------------------------------------------------------------- */

/* Corners of a box of n[0] x n[1] x n[2], x fastest, `step` apart: their distances, which get the signs. */
typedef struct block {
    const build *build;
    sn_index n[3], low[3]; /* low: the first corner, in cells */
    sn_index cells;        /* from one corner to the next */
    double step;
    float *values;   /* (count) */
    bool *signed_;   /* (count) has its sign */
    sn_index *queue; /* (count) */
} block;

static bool block_inside(const block *g, sn_index at) {
    sn_index i = at % g->n[0], j = at / g->n[0] % g->n[1], k = at / g->n[0] / g->n[1];
    const sn_distance_field *f = g->build->field;
    return is_inside(g->build, corner_point(f, g->low[0] + i * g->cells, g->low[1] + j * g->cells, g->low[2] + k * g->cells));
}

/* Nothing of the surface lies between two corners whose balls touch. */
static void carry_sign(block *g, sn_index from, sn_index to, sn_index *tail) {
    if (g->signed_[to]) return;
    float a = g->values[from], b = g->values[to];
    if (!((double)fabsf(a) + (double)b > g->step * (1.0 + 1e-6))) return;
    if (a < 0.0f) g->values[to] = -b;
    g->signed_[to] = true;
    g->queue[(*tail)++] = to;
}

/* Carry signs on from the corners queue[0 .. tail - 1]. */
static void spread_signs(block *g, sn_index tail) {
    sn_index row = g->n[0], layer = g->n[0] * g->n[1];
    for (sn_index head = 0; head < tail; head++) {
        sn_index at = g->queue[head], i = at % row, j = at / row % g->n[1], k = at / layer;
        if ((double)fabsf(g->values[at]) < on_surface * g->step) continue;
        if (i > 0) carry_sign(g, at, at - 1, &tail);
        if (i + 1 < g->n[0]) carry_sign(g, at, at + 1, &tail);
        if (j > 0) carry_sign(g, at, at - row, &tail);
        if (j + 1 < g->n[1]) carry_sign(g, at, at + row, &tail);
        if (k > 0) carry_sign(g, at, at - layer, &tail);
        if (k + 1 < g->n[2]) carry_sign(g, at, at + layer, &tail);
    }
}

/* Ask the winding number for corners that no sign was carried to. */
static void sign_rest(block *g) {
    sn_index count = g->n[0] * g->n[1] * g->n[2];
    for (sn_index at = 0; at < count; at++) {
        if (g->signed_[at]) continue;
        if (block_inside(g, at)) g->values[at] = -g->values[at];
        g->signed_[at] = true;
        g->queue[0] = at;
        spread_signs(g, 1);
    }
}

static sn_status sign_coarse(build *b, sn_error *error) {
    block g = {.build = b, .n = {b->coarse[0], b->coarse[1], b->coarse[2]}, .cells = SN_COARSE_CELLS, .values = b->field->coarse};
    g.step = SN_COARSE_CELLS * b->field->cell;
    g.signed_ = SN_NEW(bool, b->coarse_count);
    g.queue = SN_NEW(sn_index, b->coarse_count);
    bool enough = g.signed_ != NULL && g.queue != NULL;
    if (enough) sign_rest(&g);
    free(g.signed_);
    free(g.queue);
    return enough ? SN_OK : sn_fail_memory(error, "a distance field");
}

static sn_status measure_coarse(build *b, sn_pool *pool, sn_error *error) {
    b->field->coarse = SN_NEW(float, b->coarse_count);
    if (b->field->coarse == NULL) return sn_fail_memory(error, "a distance field");
    sn_parallel_for(pool, b->coarse[1] * b->coarse[2], 4, measure_coarse_rows, b);
    return sign_coarse(b, error);
}

/* ---- bricks ---------------------------------------------------------------------------------------------------------------------- */

static size_t coarse_place(const build *b, sn_index i, sn_index j, sn_index k) {
    return (size_t)i + (size_t)b->coarse[0] * ((size_t)j + (size_t)b->coarse[1] * (size_t)k);
}

static void brick_at(const sn_distance_field *f, sn_index place, sn_index at[3]) {
    at[0] = place % f->bricks[0];
    at[1] = place / f->bricks[0] % f->bricks[1];
    at[2] = place / f->bricks[0] / f->bricks[1];
}

/* May a point of the brick be within the band? None is farther from its coarse corners than half their cube's diagonal. */
static bool may_be_needed(const build *b, sn_index place) {
    sn_index at[3];
    brick_at(b->field, place, at);
    double reach = b->field->band + 0.5 * SN_COARSE_CELLS * 1.7321 * b->field->cell;
    for (sn_index c = 0; c < 27; c++) {
        size_t corner = coarse_place(b, 2 * at[0] + c % 3, 2 * at[1] + c / 3 % 3, 2 * at[2] + c / 9);
        if ((double)fabsf(b->field->coarse[corner]) <= reach) return true;
    }
    return false;
}

static sn_status find_candidates(build *b, sn_error *error) {
    sn_distance_field *f = b->field;
    sn_index places = f->bricks[0] * f->bricks[1] * f->bricks[2];
    f->brick = SN_NEW(sn_index, places);
    b->candidates = SN_NEW(sn_index, places);
    if (f->brick == NULL || b->candidates == NULL) return sn_fail_memory(error, "a distance field");
    for (sn_index i = 0; i < places; i++) {
        f->brick[i] = SN_NONE;
        if (may_be_needed(b, i)) b->candidates[b->count++] = i;
    }
    double bytes = (double)b->count * SN_BRICK_VALUES * sizeof(float);
    if (bytes > 2.0 * most_bytes)
        return sn_fail(error, SN_ERROR_USAGE, "a distance field of cells of %g would take %.1f GB; a cell of %.3g would take half a GB",
                       f->cell, 1e-9 * bytes, f->cell * sqrt(2e-9 * bytes));
    f->values = SN_NEW(float, (size_t)b->count *SN_BRICK_VALUES);
    b->needed = SN_NEW(bool, b->count);
    return f->values != NULL && b->needed != NULL ? SN_OK : sn_fail_memory(error, "a distance field");
}

/* Distances of the 8^3 corners that are the brick's own, x fastest; those it shares with the next ones are theirs. */
static void measure_own_corners(const block *g) {
    const build *b = g->build;
    for (sn_index at = 0; at < CORNERS; at++) {
        sn_index before = at % N > 0 ? 1 : at / N % N > 0 ? N : N * N;
        double known = at > 0 ? (double)g->values[at - before] * (1.0 + 1e-6) : INFINITY;
        sn_vec3 p = corner_point(b->field, g->low[0] + at % N, g->low[1] + at / N % N, g->low[2] + at / (N * N));
        g->values[at] = (float)distance_near(b, p, known, g->step);
    }
}

/* Signs begin at the corners of the coarse grid. */
static void sign_own_corners(block *g, const sn_index brick[3]) {
    sn_index tail = 0;
    for (sn_index c = 0; c < 8; c++) {
        sn_index i = c % 2, j = c / 2 % 2, k = c / 4, at = SN_COARSE_CELLS * (i + N * (j + N * k));
        const build *b = g->build;
        float coarse = b->field->coarse[coarse_place(b, 2 * brick[0] + i, 2 * brick[1] + j, 2 * brick[2] + k)];
        if (coarse < 0.0f) g->values[at] = -g->values[at];
        g->signed_[at] = true;
        g->queue[tail++] = at;
    }
    spread_signs(g, tail);
    sign_rest(g);
}

/* Fill candidates; a brick is needed where a point of it may be within the band: none is farther than a cell's diagonal from its corners.
 */
static void fill_bricks(void *user, sn_index begin, sn_index end, sn_index chunk) {
    build *b = user;
    const sn_distance_field *f = b->field;
    float own[CORNERS];
    bool has_sign[CORNERS];
    sn_index queue[CORNERS], brick[3];
    (void)chunk;
    for (sn_index c = begin; c < end; c++) {
        brick_at(f, b->candidates[c], brick);
        block g = {b, {N, N, N}, {N * brick[0], N * brick[1], N * brick[2]}, 1, f->cell, own, has_sign, queue};
        memset(has_sign, 0, sizeof has_sign);
        measure_own_corners(&g);
        sign_own_corners(&g, brick);
        float *values = f->values + (size_t)c * SN_BRICK_VALUES;
        double least = INFINITY;
        for (sn_index at = 0; at < CORNERS; at++) {
            values[at % N + SN_BRICK_CORNERS * (at / N % N + SN_BRICK_CORNERS * (at / (N * N)))] = own[at];
            least = fmin(least, (double)fabsf(own[at]));
        }
        b->needed[c] = least <= f->band + 1.7321 * f->cell;
    }
}

static void keep_needed(build *b) {
    sn_distance_field *f = b->field;
    for (sn_index c = 0; c < b->count; c++) {
        if (!b->needed[c]) continue;
        sn_index brick = f->brick_count++;
        f->brick[b->candidates[c]] = brick;
        b->candidates[brick] = b->candidates[c];
        float *to = f->values + (size_t)brick * SN_BRICK_VALUES;
        if (brick != c) memcpy(to, f->values + (size_t)c * SN_BRICK_VALUES, SN_BRICK_VALUES * sizeof *to);
    }
    b->count = f->brick_count;
    float *fitting = sn_realloc(f->values, (size_t)f->brick_count * SN_BRICK_VALUES, sizeof *fitting);
    if (fitting != NULL) f->values = fitting;
}

/* ---- where bricks meet ------------------------------------------------------------------------------------------------------------ */

/* Do all bricks around corner c (in cells) hold values? */
static bool is_among_bricks(const sn_distance_field *f, const sn_index c[3]) {
    for (sn_index side = 0; side < 8; side++) {
        sn_index at[3];
        for (int k = 0; k < 3; k++) {
            bool below = c[k] % N == 0 && (side >> k & 1);
            at[k] = c[k] / N - below;
            if (at[k] < 0 || at[k] >= f->bricks[k]) return false;
        }
        if (f->brick[at[0] + f->bricks[0] * (at[1] + f->bricks[1] * at[2])] == SN_NONE) return false;
    }
    return true;
}

/* What the coarse grid gives at corner c. Along axes that c lies on no coarse corner of, its weight is a number of quarters. */
static float coarse_value(const build *b, const sn_index c[3]) {
    double sum = 0.0;
    for (sn_index side = 0; side < 8; side++) {
        double weight = 1.0;
        sn_index at[3];
        for (int k = 0; k < 3; k++) {
            double share = (double)(c[k] % SN_COARSE_CELLS) / SN_COARSE_CELLS;
            bool upper = side >> k & 1;
            weight *= upper ? share : 1.0 - share;
            at[k] = c[k] / SN_COARSE_CELLS + (upper && share > 0.0);
        }
        sum += weight * (double)b->field->coarse[coarse_place(b, at[0], at[1], at[2])];
    }
    return (float)sum;
}

/* The brick whose own corner c is. */
static const float *own_value(const sn_distance_field *f, const sn_index c[3]) {
    sn_index brick = f->brick[c[0] / N + f->bricks[0] * (c[1] / N + f->bricks[1] * (c[2] / N))];
    return f->values + (size_t)brick * SN_BRICK_VALUES + c[0] % N + SN_BRICK_CORNERS * (c[1] % N + SN_BRICK_CORNERS * (c[2] % N));
}

/* A brick's outer corners: the value of the brick that owns it, or the coarse grid's where that begins. The values that are read here are
 * of corners among bricks, and their owners do not change them. */
static void join_bricks(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const build *b = user;
    const sn_distance_field *f = b->field;
    (void)chunk;
    for (sn_index brick = begin; brick < end; brick++) {
        sn_index at[3];
        brick_at(f, b->candidates[brick], at);
        for (sn_index i = 0; i < SN_BRICK_VALUES; i++) {
            sn_index l[3] = {i % SN_BRICK_CORNERS, i / SN_BRICK_CORNERS % SN_BRICK_CORNERS, i / (SN_BRICK_CORNERS * SN_BRICK_CORNERS)};
            if (l[0] % N != 0 && l[1] % N != 0 && l[2] % N != 0) continue;
            const sn_index c[3] = {N * at[0] + l[0], N * at[1] + l[1], N * at[2] + l[2]};
            float *value = f->values + (size_t)brick * SN_BRICK_VALUES + i;
            if (!is_among_bricks(f, c))
                *value = coarse_value(b, c);
            else if (l[0] == N || l[1] == N || l[2] == N)
                *value = *own_value(f, c);
        }
    }
}

/* ---- all of it --------------------------------------------------------------------------------------------------------------------- */

static sn_status fill(build *b, const sn_distance_field_params *params, sn_error *error) {
    b->field->box = sn_mesh_box(b->boundary);
    sn_status status = check_place(b->field, error);
    if (status == SN_OK) status = check_size(b, error);
    if (status != SN_OK) return status;
    lay_out(b);
    status = sn_surface_create_plain(b->boundary, &b->surface, error);
    if (status == SN_OK) status = measure_coarse(b, params->pool, error);
    if (status == SN_OK) status = find_candidates(b, error);
    if (status != SN_OK) return status;
    sn_parallel_for(params->pool, b->count, 1, fill_bricks, b);
    keep_needed(b);
    sn_parallel_for(params->pool, b->count, GRAIN, join_bricks, b);
    return SN_OK;
}

sn_status sn_distance_field_create(const sn_mesh *mesh, const sn_distance_field_params *params, sn_distance_field *out, sn_error *error) {
    *out = (sn_distance_field){.cell = params->cell, .band = params->band * params->cell};
    sn_mesh solid = {0};
    sn_status status = check_params(params, error);
    if (status == SN_OK) status = sn_solid_surface(mesh, params->pool, &solid, &out->report, error);
    if (status != SN_OK) return status;
    sn_mesh boundary = solid, closed = solid;
    boundary.triangle_count = out->report.boundary_triangles;
    closed.triangles = SN_NEW(sn_triangle, solid.triangle_count); /* the tree sorts them */
    build b = {.field = out, .boundary = &boundary};
    if (closed.triangles == NULL) status = sn_fail_memory(error, "a distance field");
    if (status == SN_OK) {
        memcpy(closed.triangles, solid.triangles, (size_t)solid.triangle_count * sizeof *closed.triangles);
        status = sn_winding_tree_build(&closed, &b.winding, error);
    }
    if (status == SN_OK) status = fill(&b, params, error);
    sn_surface_destroy(b.surface);
    sn_winding_tree_free(&b.winding);
    free(b.candidates);
    free(b.needed);
    free(closed.triangles);
    sn_mesh_free(&solid);
    if (status != SN_OK) sn_distance_field_free(out);
    return status;
}
