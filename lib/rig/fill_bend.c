/*
 * fill_bend.c -- templates bent by superficial fibres that the user gives, from a dissection perhaps (after Kohout and Cholt 2017).
 *
 * The levels cut a given fibre; each cut is looked up in the trunk's square: which place leads to the point of the slice nearest to it. So
 * the fibre becomes a path in the square, and where the template itself would lead a fibre elsewhere from the same place of the middle
 * level, the difference is its bend. A fibre of the template is bent by the mean of all bends, each weighted by the inverse square of the
 * distance between the two at the given fibre's middle level: one that starts there follows the given fibre.
 */
#include <stdlib.h>

#include "fill.h"

enum { GRID = 13, REFINEMENTS = 12 };
#define REACH 0.05      /* of the diagonal: a given fibre farther from the surface than this is not one of this muscle */
#define NEAR 1e-6       /* squared distance in the square below which two fibres are one */
#define KEEP 0.01       /* cost of leaving the place of the level before, against the misfit over the size of the slice, both squared */
#define LEAST_SIZE 0.02 /* of the diagonal, for that size: where slices shrink to a point the place before is kept */
#define MARGIN 0.02     /* of the square: fibres keep off the surface */

/* ---- where the levels cut the given fibres ------------------------------------------------------------------------------------------ */

/* u at a point of the surface. */
static double value_at(const fill_field *field, const sn_closest *at) {
    const sn_index *v = field->mesh->triangles[at->triangle].v;
    const double *u = field->u;
    return at->barycentric[0] * u[v[0]] + at->barycentric[1] * u[v[1]] + at->barycentric[2] * u[v[2]];
}

/* Looks given points up in the field. */
typedef struct ruler {
    const fill_field *field;
    sn_surface *surface; /* of the field's mesh */
    double reach;        /* no point may be farther from it */
    double farthest;     /* of all so far */
} ruler;

static sn_status measure_line(ruler *r, sn_index number, const sn_polyline *given, fill_bend_line *out, sn_error *error) {
    if (given->count < 2) return sn_fail(error, SN_ERROR_INPUT, "superficial fibre %d has fewer than two points", number);
    if (!(out->values = SN_NEW(double, given->count))) return sn_fail_memory(error, "the superficial fibres");
    for (sn_index k = 0; k < given->count; k++) {
        if (!sn_finite3(given->points[k]))
            return sn_fail(error, SN_ERROR_INPUT, "superficial fibre %d has a point that is not finite", number);
        sn_closest at = sn_surface_closest(r->surface, given->points[k], r->reach);
        if (at.triangle == SN_NONE)
            return sn_fail(error, SN_ERROR_INPUT,
                           "superficial fibre %d is more than %.3g away from the muscle: is it in the muscle's unit?", number, r->reach);
        out->values[k] = value_at(r->field, &at);
        r->farthest = fmax(r->farthest, at.distance);
    }
    return SN_OK;
}

sn_status fill_bend_measure(const fill_field *field, const sn_fill_params *params, fill_bend *out, double *farthest, sn_error *error) {
    ruler r = {.field = field, .reach = REACH * sn_box_diagonal(sn_mesh_box(field->mesh)), .farthest = *farthest};
    *out = (fill_bend){.count = params->bend_count, .lines = SN_NEW(fill_bend_line, params->bend_count)};
    if (!out->lines) return sn_fail_memory(error, "the superficial fibres");
    sn_status status = sn_surface_create_plain(field->mesh, &r.surface, error);
    for (sn_index i = 0; i < out->count && !status; i++) status = measure_line(&r, i, &params->bend_lines[i], &out->lines[i], error);
    *farthest = r.farthest;
    sn_surface_destroy(r.surface);
    return status;
}

/* Where the given fibre first crosses u; false where it does not. */
static bool cut(const sn_polyline *given, const double *values, double u, sn_vec3 *out) {
    for (sn_index k = 0; k + 1 < given->count; k++) {
        double a = values[k] - u, b = values[k + 1] - u;
        if (a * b > 0.0 || a == b) continue;
        *out = sn_lerp(given->points[k], given->points[k + 1], a / (a - b));
        return true;
    }
    return false;
}

/* The levels that cut it, which follow each other, and of those the nearest to the trunk. */
static bool find_span(const fill_levels *l, const sn_polyline *given, fill_bend_line *line) {
    sn_vec3 ignored;
    line->first = line->last = SN_NONE;
    for (sn_index i = 0; i < l->level_count; i++) {
        if (!cut(given, line->values, l->u[i], &ignored)) continue;
        if (line->first == SN_NONE) line->first = i;
        line->last = i;
    }
    line->middle = l->trunk < line->first ? line->first : l->trunk > line->last ? line->last : l->trunk;
    return line->first != SN_NONE && line->last > line->first;
}

/* ---- the same in the trunk's square -------------------------------------------------------------------------------------------------- */

typedef struct search {
    const fill_levels *levels;
    sn_fill_map map;
    sn_index level;
    sn_vec3 goal;
    double size;   /* of the slice */
    bool has_last; /* the place on the level before */
    fill_uv last;
} search;

/* Of the place `at`: misfit over size, and how far it is from the last one, squared. */
static double cost(const search *s, fill_uv at) {
    sn_vec3 p;
    if (!fill_place(s->levels, s->map, s->level, at, at, &p)) return INFINITY;
    double dx = at.x - s->last.x, dy = at.y - s->last.y;
    return sn_norm2(sn_sub(p, s->goal)) / (s->size * s->size) + (s->has_last ? KEEP * (dx * dx + dy * dy) : 0.0);
}

static double clamp(double x) { return fmin(fmax(x, 0.0), 1.0); }

/* The cheapest place: of a grid, then of the eight around it, with steps that halve where none is cheaper. */
static fill_uv find_place(const search *s) {
    fill_uv best = s->has_last ? s->last : (fill_uv){0.5, 0.5};
    double least = cost(s, best), step = 1.0 / (GRID - 1);
    for (int i = 0; i < GRID * GRID; i++) {
        fill_uv at = {(i % GRID) * step, (double)(i / GRID) * step};
        double here = cost(s, at);
        if (here >= least) continue;
        least = here;
        best = at;
    }
    for (int round = 0; round < REFINEMENTS; round++) {
        fill_uv around = best;
        for (int i = 0; i < 9; i++) {
            fill_uv at = {clamp(around.x + (i % 3 - 1) * step), clamp(around.y + (double)(i / 3 - 1) * step)};
            double here = cost(s, at);
            if (here >= least) continue;
            least = here;
            best = at;
        }
        if (best.x == around.x && best.y == around.y) step *= 0.5;
    }
    return best;
}

static double size_of(const fill_levels *l, sn_index level, double least) {
    double area = 0.0;
    for (sn_index i = l->first[level]; i < l->first[level + 1]; i++) area += l->loops[i].area;
    return fmax(sqrt(area), least);
}

/* From the middle to both ends, each place near the one before. */
static void follow_line(const fill_levels *l, const sn_fill_params *params, const sn_polyline *given, double least_size,
                        fill_bend_line *line) {
    for (int way = -1; way <= 1; way += 2) {
        search s = {.levels = l, .map = params->map, .has_last = way > 0, .last = line->path[line->middle]};
        for (sn_index i = line->middle + (way > 0); i >= line->first && i <= line->last; i += way) {
            s.level = i;
            s.size = size_of(l, i, least_size);
            (void)cut(given, line->values, l->u[i], &s.goal);
            s.last = line->path[i] = find_place(&s);
            s.has_last = true;
        }
    }
}

/* ---- bends --------------------------------------------------------------------------------------------------------------------------- */

/* The seed that the template leads through x on a level; x of the template grows with the seed's. */
static double seed_through(const sn_fill_params *params, const fill_levels *l, double x, sn_index level) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (low + high);
        if (fill_template_across(params, l, middle, level) < x)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

/* Beyond its ends a given fibre bends as at them. */
static void find_bends(const sn_fill_params *params, const fill_levels *l, fill_bend_line *line) {
    double seed = seed_through(params, l, line->path[line->middle].x, line->middle);
    for (sn_index i = 0; i < l->level_count; i++) {
        sn_index at = i < line->first ? line->first : i > line->last ? line->last : i;
        line->bend[i].x = line->path[at].x - fill_template_across(params, l, seed, at);
        line->bend[i].y = line->path[at].y - line->path[line->middle].y;
    }
}

typedef struct finding {
    const fill_levels *levels;
    const sn_fill_params *params;
    double least_size;
    fill_bend *bend;
} finding;

static void find_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const finding *f = user;
    (void)chunk;
    for (sn_index i = begin; i < end; i++) {
        follow_line(f->levels, f->params, &f->params->bend_lines[i], f->least_size, &f->bend->lines[i]);
        find_bends(f->params, f->levels, &f->bend->lines[i]);
    }
}

sn_status fill_bend_find(const fill_levels *l, const sn_fill_params *params, double diagonal, fill_bend *bend, sn_error *error) {
    finding f = {l, params, LEAST_SIZE * diagonal, bend};
    for (sn_index i = 0; i < bend->count; i++) {
        fill_bend_line *line = &bend->lines[i];
        if (!find_span(l, &params->bend_lines[i], line))
            return sn_fail(error, SN_ERROR_INPUT,
                           "superficial fibre %d crosses fewer than two of the muscle's %d levels; it must run along it", i,
                           l->level_count);
        line->path = SN_NEW(fill_uv, l->level_count);
        line->bend = SN_NEW(fill_uv, l->level_count);
        if (!line->path || !line->bend) return sn_fail_memory(error, "the superficial fibres");
    }
    sn_parallel_for(params->pool, bend->count, 1, find_range, &f);
    return SN_OK;
}

static double keep_off(double x) { return fmin(fmax(x, MARGIN), 1.0 - MARGIN); }

void fill_bend_nodes(const fill_bend *bend, sn_index level_count, fill_node *nodes) {
    fill_uv moved[TEMPLATE_NODES] = {{0, 0}};
    double weights = 0.0;
    for (sn_index j = 0; j < bend->count; j++) {
        const fill_bend_line *line = &bend->lines[j];
        fill_uv here = nodes[line->middle].at, there = line->path[line->middle];
        double dx = here.x - there.x, dy = here.y - there.y, weight = 1.0 / (dx * dx + dy * dy + NEAR);
        for (sn_index i = 0; i < level_count; i++) {
            moved[i].x += weight * line->bend[i].x;
            moved[i].y += weight * line->bend[i].y;
        }
        weights += weight;
    }
    for (sn_index i = 0; i < level_count && weights > 0.0; i++) {
        nodes[i].at.x = keep_off(nodes[i].at.x + moved[i].x / weights);
        nodes[i].at.y = keep_off(nodes[i].at.y + moved[i].y / weights);
    }
}

void fill_bend_free(fill_bend *bend) {
    for (sn_index i = 0; bend->lines && i < bend->count; i++) {
        free(bend->lines[i].values);
        free(bend->lines[i].path);
        free(bend->lines[i].bend);
    }
    free(bend->lines);
    *bend = (fill_bend){0};
}
