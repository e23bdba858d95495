/*
 * fill_spread.c -- fibres from area to area: points that are even over the origin areas, as many that are even over the insertion areas, a
 * way through the slices for each, and pairs of them.
 *
 * A way is a place of the trunk's square and leads to both ends. Places are even over the trunk's section; those that lead to one loop of
 * an end level are given to the points of the area behind that loop, as many as these are, so that the sum of squared distances is least.
 * Then the origins' and the insertions' ways are paired by where they begin, pass the trunk and end: also the least sum.
 */
#include <stdlib.h>

#include "fill.h"

enum { PLACES_A_FIBER = 20, MANY_FIBERS = 5000, FEW_PLACES = 4, PAIR_WIDTH = 9 };

/* Places of the trunk and where they lead. */
typedef struct trunk_ways {
    sn_index count;
    fill_uv *places;    /* (count) */
    sn_vec3 *points[3]; /* (count) in space: on the first level, the trunk, the last level */
    sn_index *loops[2]; /* (count) on the first and the last level; SN_NONE = the way ends before */
} trunk_ways;

typedef struct spreading {
    const fill_levels *levels;
    const fill_areas *areas;
    const sn_fill_params *params;
    trunk_ways ways;
    sn_vec3 *points[2];  /* (fibers) of the areas */
    sn_index *loops[2];  /* (fibers) that lead there */
    sn_index *way_of[2]; /* (fibers) */
} spreading;

/* ---- ways ---------------------------------------------------------------------------------------------------------------------- */

static sn_index end_level(const fill_levels *l, int side) { return side == 0 ? 0 : l->level_count - 1; }

static void follow_ways(void *user, sn_index begin, sn_index end, sn_index chunk) {
    spreading *s = user;
    trunk_ways *w = &s->ways;
    const fill_levels *l = s->levels;
    const sn_index levels[3] = {0, l->trunk, l->level_count - 1};
    (void)chunk;
    for (sn_index i = begin; i < end; i++)
        for (int k = 0; k < 3; k++) {
            fill_uv at = w->places[i];
            sn_index loop = fill_carry(l, levels[k], at, &at), hint = 0;
            if (k != 1) w->loops[k / 2][i] = loop;
            w->points[k][i] = loop != SN_NONE ? fill_slice_at(&l->loops[loop].slice, at, &hint) : sn_v3(0, 0, 0);
        }
}

static sn_status find_ways(spreading *s, sn_error *error) {
    trunk_ways *w = &s->ways;
    w->count = s->params->fibers * (s->params->fibers > MANY_FIBERS ? FEW_PLACES : PLACES_A_FIBER);
    w->places = SN_NEW(fill_uv, w->count);
    bool made = w->places != NULL;
    for (int k = 0; k < 3; k++) made &= (w->points[k] = SN_NEW(sn_vec3, w->count)) != NULL;
    for (int k = 0; k < 2; k++) made &= (w->loops[k] = SN_NEW(sn_index, w->count)) != NULL;
    sn_status status =
        made ? fill_even_places(s->levels, s->params, w->count, w->places, error) : sn_fail_memory(error, "the fibres' ways");
    if (!status) sn_parallel_for(s->params->pool, w->count, 64, follow_ways, s);
    return status;
}

/* ---- points of an area and the loops before them --------------------------------------------------------------------------------------
 */

static double slice_distance2(const fill_slice *slice, sn_vec3 p) {
    double least = INFINITY;
    for (sn_index t = 0; t < slice->triangle_count; t++) {
        const sn_index *v = slice->triangles[t];
        sn_vec3 q = sn_closest_on_triangle(p, slice->positions[v[0]], slice->positions[v[1]], slice->positions[v[2]], NULL);
        least = fmin(least, sn_norm2(sn_sub(q, p)));
    }
    return least;
}

/* The nearest loop of the end level that a way leads to. */
static void find_loops(spreading *s, int side, const sn_index *way_count) {
    const fill_levels *l = s->levels;
    sn_index level = end_level(l, side);
    for (sn_index i = 0; i < s->params->fibers; i++) {
        sn_index only = SN_NONE, choices = 0;
        for (sn_index k = l->first[level]; k < l->first[level + 1]; k++)
            if (way_count[k] > 0) {
                only = k;
                choices++;
            }
        double least = INFINITY;
        s->loops[side][i] = only;
        for (sn_index k = l->first[level]; choices > 1 && k < l->first[level + 1]; k++) {
            double d = way_count[k] > 0 ? slice_distance2(&l->loops[k].slice, s->points[side][i]) : INFINITY;
            if (d < least) s->loops[side][i] = k;
            least = fmin(least, d);
        }
    }
}

/* The first `count` ways that lead to the loop, again from the first where there are fewer. */
static void take_ways(const spreading *s, int side, sn_index loop, sn_index count, sn_index *out) {
    sn_index found = 0;
    for (sn_index i = 0; i < s->ways.count && found < count; i++)
        if (s->ways.loops[side][i] == loop) out[found++] = i;
    for (sn_index i = found; found > 0 && i < count; i++) out[i] = out[i % found];
}

static void set3(double *out, sn_vec3 p) {
    out[0] = p.x;
    out[1] = p.y;
    out[2] = p.z;
}

/* Room to pair up to as many points as there are fibres. */
typedef struct pairing {
    double *from, *to;               /* (fibers x PAIR_WIDTH) */
    sn_index *points, *ways, *match; /* (fibers) */
} pairing;

static sn_status give_loop(spreading *s, int side, sn_index loop, pairing *p, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < s->params->fibers; i++)
        if (s->loops[side][i] == loop) p->points[count++] = i;
    take_ways(s, side, loop, count, p->ways);
    for (sn_index i = 0; i < count; i++) {
        set3(p->from + 3 * (size_t)i, s->points[side][p->points[i]]);
        set3(p->to + 3 * (size_t)i, s->ways.points[2 * side][p->ways[i]]);
    }
    sn_status status = fill_match(count, &(fill_features){3, p->from}, &(fill_features){3, p->to}, p->match, error);
    for (sn_index i = 0; i < count && !status; i++) s->way_of[side][p->points[i]] = p->ways[p->match[i]];
    return status;
}

static sn_status give_ways(spreading *s, int side, pairing *p, sn_error *error) {
    const fill_levels *l = s->levels;
    sn_index level = end_level(l, side), *way_count = SN_NEW(sn_index, l->loop_count), reached = 0;
    if (!way_count) return sn_fail_memory(error, "the fibres' ways");
    for (sn_index i = 0; i < s->ways.count; i++)
        if (s->ways.loops[side][i] != SN_NONE) {
            way_count[s->ways.loops[side][i]]++;
            reached++;
        }
    sn_status status = fill_sample_area(s->areas->mesh, s->areas->member[side], s->params->fibers, s->points[side], error);
    if (!status && reached == 0)
        status = sn_fail(error, SN_ERROR_INPUT, "no way leads through the muscle's slices to its %s", side == 0 ? "origin" : "insertion");
    if (!status) find_loops(s, side, way_count);
    for (sn_index k = l->first[level]; k < l->first[level + 1] && !status; k++)
        if (way_count[k] > 0) status = give_loop(s, side, k, p, error);
    free(way_count);
    return status;
}

/* ---- pairs ---------------------------------------------------------------------------------------------------------------------- */

static sn_status pair_ends(spreading *s, pairing *p, fill_path *paths, sn_error *error) {
    const trunk_ways *w = &s->ways;
    sn_index fibers = s->params->fibers;
    for (int side = 0; side < 2; side++)
        for (sn_index i = 0; i < fibers; i++) {
            double *out = (side == 0 ? p->from : p->to) + PAIR_WIDTH * (size_t)i;
            sn_index way = s->way_of[side][i];
            for (int k = 0; k < 3; k++) set3(out + 3 * k, k == 2 * side ? s->points[side][i] : w->points[k][way]);
        }
    sn_status status = fill_match(fibers, &(fill_features){PAIR_WIDTH, p->from}, &(fill_features){PAIR_WIDTH, p->to}, p->match, error);
    for (sn_index i = 0; i < fibers && !status; i++)
        for (int side = 0; side < 2; side++) {
            sn_index k = side == 0 ? i : p->match[i];
            paths[i].end[side] = s->points[side][k];
            paths[i].way[side] = w->places[s->way_of[side][k]];
            paths[i].loop[side] = s->loops[side][k];
            paths[i].radius[side] = sqrt(s->levels->loops[s->loops[side][k]].area / SN_PI);
        }
    return status;
}

static bool spreading_alloc(spreading *s, pairing *p) {
    sn_index fibers = s->params->fibers;
    *p = (pairing){SN_NEW(double, PAIR_WIDTH *(size_t)fibers), SN_NEW(double, PAIR_WIDTH *(size_t)fibers), SN_NEW(sn_index, fibers),
                   SN_NEW(sn_index, fibers), SN_NEW(sn_index, fibers)};
    bool made = p->from && p->to && p->points && p->ways && p->match;
    for (int side = 0; side < 2; side++) {
        s->points[side] = SN_NEW(sn_vec3, fibers);
        s->loops[side] = SN_NEW(sn_index, fibers);
        s->way_of[side] = SN_NEW(sn_index, fibers);
        made &= s->points[side] && s->loops[side] && s->way_of[side];
    }
    return made;
}

static void spreading_free(spreading *s, pairing *p) {
    free(p->from);
    free(p->to);
    free(p->points);
    free(p->ways);
    free(p->match);
    free(s->ways.places);
    for (int k = 0; k < 3; k++) free(s->ways.points[k]);
    for (int side = 0; side < 2; side++) {
        free(s->ways.loops[side]);
        free(s->points[side]);
        free(s->loops[side]);
        free(s->way_of[side]);
    }
}

sn_status fill_spread_ends(const fill_levels *levels, const fill_areas *areas, const sn_fill_params *params, fill_path *paths,
                           sn_error *error) {
    spreading s = {.levels = levels, .areas = areas, .params = params};
    pairing p;
    sn_status status = spreading_alloc(&s, &p) ? find_ways(&s, error) : sn_fail_memory(error, "the ends of the fibres");
    for (int side = 0; side < 2 && !status; side++) status = give_ways(&s, side, &p, error);
    if (!status) status = pair_ends(&s, &p, paths, error);
    spreading_free(&s, &p);
    return status;
}
