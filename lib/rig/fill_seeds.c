/* fill_seeds.c -- where fibres pass the trunk: evenly over its real section, and so that every end of the muscle gets one. */
#include <stdlib.h>

#include "fill_loops.h"
#include "sinew/numeric.h"
#include "triangulate.h"

enum { TRIES = 6, MORE_SEEDS = 20, STARTS = 16 };
#define EDGE 0.02 /* of the square: fibres keep off the surface */

static bool is_end_to_end(const sn_fill_params *params) {
    return params->template == SN_FILL_PARALLEL || params->template == SN_FILL_FAN || params->template == SN_FILL_CURVED;
}

/* ---- even over the section ------------------------------------------------------------------------------------------------------- */

/* The trunk's slice seen along its normal. */
typedef struct face {
    const fill_slice *slice;
    polygon_point *points; /* (slice->vertex_count) */
    polygon_point low, high;
} face;

static bool face_create(const fill_loop *loop, face *out) {
    sn_vec3 x = sn_normalize(rim_axis(loop, 0));
    x = sn_normalize(sn_add_scaled(x, loop->normal, -sn_dot(x, loop->normal)));
    sn_vec3 y = sn_cross(loop->normal, x);
    *out = (face){.slice = &loop->slice, .low = {INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY}};
    out->points = SN_NEW(polygon_point, loop->slice.vertex_count);
    if (!out->points) return false;
    for (sn_index i = 0; i < loop->slice.vertex_count; i++) {
        sn_vec3 d = sn_sub(loop->slice.positions[i], loop->centroid);
        polygon_point p = {sn_dot(d, x), sn_dot(d, y)};
        out->low = (polygon_point){fmin(out->low.x, p.x), fmin(out->low.y, p.y)};
        out->high = (polygon_point){fmax(out->high.x, p.x), fmax(out->high.y, p.y)};
        out->points[i] = p;
    }
    return true;
}

static double keep_off(double x) { return fmin(fmax(x, EDGE), 1.0 - EDGE); }

/* The place in the square of a place in the section's box; false outside the section. A walk may get stuck at a bay: it starts anew. */
static bool seed_at(const face *f, const double at[2], fill_uv *out) {
    polygon_point p = {f->low.x + at[0] * (f->high.x - f->low.x), f->low.y + at[1] * (f->high.y - f->low.y)};
    const fill_slice *s = f->slice;
    const polygon_view view = {f->points, s->triangle_count, s->triangles, s->across};
    double w[3];
    sn_index t = SN_NONE;
    for (sn_index k = 0; t == SN_NONE && k < STARTS; k++) t = polygon_locate(&view, p, k * s->triangle_count / STARTS, w);
    if (t == SN_NONE) return false;
    *out = (fill_uv){0.0, 0.0};
    for (int c = 0; c < 3; c++) {
        out->x += w[c] * s->square[s->triangles[t][c]].x;
        out->y += w[c] * s->square[s->triangles[t][c]].y;
    }
    *out = (fill_uv){keep_off(out->x), keep_off(out->y)};
    return true;
}

/* Sobol points of the section's box that lie in the section; returns how many of `count` were found. */
static sn_index spread_over(const face *f, sn_index count, const double *numbers, sn_index number_count, fill_uv *out) {
    sn_index found = 0;
    for (sn_index i = 0; i < number_count && found < count; i++) found += seed_at(f, numbers + 2 * (size_t)i, &out[found]);
    return found;
}

/* `count` seeds: from the section where the template runs from end to end through one trunk, otherwise from the unit square. */
sn_status fill_even_places(const fill_levels *l, const sn_fill_params *params, sn_index count, fill_uv *out, sn_error *error) {
    bool real = is_end_to_end(params) && params->map == SN_FILL_HARMONIC && l->root_count == 1;
    sn_index tries = real ? TRIES * count : count, found = 0;
    double *numbers = SN_NEW(double, 2 * (size_t)tries);
    face f = {0};
    sn_status status = numbers ? sn_sobol(2, tries, numbers, error) : sn_fail_memory(error, "the fibres' seeds");
    if (!status && real) {
        if (face_create(&l->loops[l->roots[0].loop], &f))
            found = spread_over(&f, count, numbers, tries, out);
        else
            status = sn_fail_memory(error, "the fibres' seeds");
    }
    double low = is_end_to_end(params) ? EDGE : 0.0;
    for (; !status && found < count; found++)
        out[found] = (fill_uv){low + (1.0 - 2.0 * low) * numbers[2 * found], low + (1.0 - 2.0 * low) * numbers[2 * found + 1]};
    free(f.points);
    free(numbers);
    return status;
}

/* ---- every end -------------------------------------------------------------------------------------------------------------------- */

/* Add `by` to the count of fibres at the two loops where a fibre through the seed ends. */
static void count_ends(const fill_levels *l, fill_uv seed, sn_index *count, sn_index by, sn_index loops[2]) {
    for (int k = 0; k < 2; k++) {
        fill_uv at = seed;
        loops[k] = fill_carry(l, k == 0 ? 0 : l->level_count - 1, seed, &at);
        if (loops[k] != SN_NONE) count[loops[k]] += by;
    }
}

static bool is_end(const fill_levels *l, sn_index loop) {
    return l->loops[loop].reached && (l->loops[loop].level == 0 || l->loops[loop].level == l->level_count - 1);
}

static sn_index ends_without(const fill_levels *l, const sn_index *count) {
    sn_index without = 0;
    for (sn_index i = 0; i < l->loop_count; i++) without += is_end(l, i) && count[i] == 0;
    return without;
}

static bool any_at(const sn_index *count, const sn_index loops[2], sn_index fibers) {
    return (loops[0] != SN_NONE && count[loops[0]] == fibers) || (loops[1] != SN_NONE && count[loops[1]] == fibers);
}

/* A seed that reaches an end no other reaches takes the place of the last one that is not the only one at its ends. */
static void replace_seeds(const fill_levels *l, sn_index fibers, fill_uv *seeds, const fill_uv *more, sn_index more_count,
                          sn_index *count) {
    sn_index victim = fibers - 1, loops[2];
    for (sn_index i = 0; i < more_count && victim >= 0; i++) {
        count_ends(l, more[i], count, 1, loops);
        if (!any_at(count, loops, 1)) {
            count_ends(l, more[i], count, -1, loops);
            continue;
        }
        for (; victim >= 0; victim--) {
            count_ends(l, seeds[victim], count, -1, loops);
            if (!any_at(count, loops, 0)) break;
            count_ends(l, seeds[victim], count, 1, loops);
        }
        if (victim >= 0) seeds[victim--] = more[i];
    }
}

static sn_status reach_ends(const fill_levels *l, const sn_fill_params *params, fill_uv *seeds, sn_index *count, sn_error *error) {
    sn_index loops[2];
    for (sn_index i = 0; i < params->fibers; i++) count_ends(l, seeds[i], count, 1, loops);
    if (!is_end_to_end(params) || params->fibers > 100000 || ends_without(l, count) == 0) return SN_OK;
    sn_index more = MORE_SEEDS * params->fibers;
    fill_uv *candidates = SN_NEW(fill_uv, more);
    sn_status status = candidates ? fill_even_places(l, params, more, candidates, error) : sn_fail_memory(error, "the fibres' seeds");
    if (!status) replace_seeds(l, params->fibers, seeds, candidates, more, count);
    free(candidates);
    return status;
}

sn_status fill_make_seeds(const fill_levels *l, const sn_fill_params *params, fill_uv *seeds, sn_fill_report *report, sn_error *error) {
    sn_index *count = SN_NEW(sn_index, l->loop_count);
    sn_status status = count ? fill_even_places(l, params, params->fibers, seeds, error) : sn_fail_memory(error, "the fibres' seeds");
    if (!status) status = reach_ends(l, params, seeds, count, error);
    for (sn_index i = 0; i < l->loop_count && !status; i++) {
        if (!is_end(l, i)) continue;
        report->leaf_loops++;
        report->leaves_reached += count[i] > 0;
    }
    free(count);
    return status;
}
