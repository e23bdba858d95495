/* fill_levels.c -- levels of the field at equal steps of length, the loops on them, and which loop follows which. */
#include <stdlib.h>

#include "fill_loops.h"
#include "section.h"

/* ---- levels ---------------------------------------------------------------------------------------------------------------- */

/* The range of u in bins. */
typedef struct bins {
    sn_index count;
    double *edges; /* (count + 1) ascending from 0 to 1 */
    double *way;   /* (count + 1) along the surface from u = 0 to each edge */
    double *area;  /* (count) twice the area of its triangles */
    double *rise;  /* (count) integral of |grad u| over them, doubled too */
} bins;

enum { MOST_BINS = 512, LEAST_BINS = 8, VERTICES_A_BIN = 16 };
#define END_SHARE 0.004 /* of the length: the first and the last level are this far from the ends, where u is constant */

static int compare_numbers(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* Bins with as many vertices each; sorted (vertex_count) is scratch. */
static void make_bins(const double *u, sn_index vertex_count, double *sorted, bins *out) {
    double *edges = out->edges;
    sn_index count = 0;
    for (sn_index v = 0; v < vertex_count; v++)
        if (u[v] > 0.0 && u[v] < 1.0) sorted[count++] = u[v];
    qsort(sorted, (size_t)count, sizeof *sorted, compare_numbers);
    sn_index wanted = count / VERTICES_A_BIN;
    wanted = wanted < LEAST_BINS ? LEAST_BINS : wanted > MOST_BINS ? MOST_BINS : wanted;
    sn_index used = 0;
    edges[0] = 0.0;
    for (sn_index b = 1; b < wanted && count > 0; b++) {
        double edge = sorted[(sn_index)((int64_t)b * count / wanted)];
        if (edge > edges[used]) edges[++used] = edge;
    }
    edges[++used] = 1.0;
    out->count = used;
}

static sn_index bin_of(const bins *in, double value) {
    sn_index low = 0, high = in->count - 1;
    while (low < high) {
        sn_index middle = low + (high - low + 1) / 2;
        if (in->edges[middle] <= value)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

/* |grad u| of a triangle. */
static double slope(const sn_vec3 p[3], const double u[3]) {
    sn_vec3 area = sn_area_vector(p[0], p[1], p[2]), sum = {0, 0, 0};
    for (int c = 0; c < 3; c++) sum = sn_add_scaled(sum, sn_sub(p[(c + 2) % 3], p[(c + 1) % 3]), u[c]);
    double twice = sn_norm(area);
    return twice > 0.0 ? sn_norm(sum) / twice : 0.0;
}

/* The way along the surface from u = 0 to each bin's edge: ds/du is the mean of 1/|grad u| over the level curve, that is area over length
 * times du, and the integral of |grad u| over a bin is length times du (coarea). */
static void measure_way(const sn_mesh *mesh, const double *u, bins *s) {
    double all_area = 0.0, all_rise = 0.0;
    for (sn_index b = 0; b < s->count; b++) s->area[b] = s->rise[b] = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        const sn_vec3 p[3] = {mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]};
        const double value[3] = {u[v[0]], u[v[1]], u[v[2]]};
        double mean = (value[0] + value[1] + value[2]) / 3.0, g = slope(p, value);
        if (!(g > 0.0) || !(mean > 0.0 && mean < 1.0)) continue;
        double a = sn_norm(sn_area_vector(p[0], p[1], p[2]));
        sn_index b = bin_of(s, mean);
        s->area[b] += a;
        s->rise[b] += a * g;
        all_area += a;
        all_rise += a * g;
    }
    s->way[0] = 0.0;
    for (sn_index b = 0; b < s->count; b++) {
        double each = s->rise[b] > 0.0 ? s->area[b] / s->rise[b] : all_rise > 0.0 ? all_area / all_rise : 0.0;
        s->way[b + 1] = s->way[b] + (s->edges[b + 1] - s->edges[b]) * each;
    }
}

static void place_levels(const bins *in, sn_index count, double *levels) {
    const double *edges = in->edges, *way = in->way;
    sn_index b = 0;
    for (sn_index i = 0; i < count; i++) {
        double share = END_SHARE + (1.0 - 2.0 * END_SHARE) * (double)i / (double)(count - 1), s = share * way[in->count];
        while (b + 1 < in->count && way[b + 1] < s) b++;
        double step = way[b + 1] - way[b];
        levels[i] = edges[b] + (step > 0.0 ? (s - way[b]) / step : 0.5) * (edges[b + 1] - edges[b]);
    }
}

static sn_status choose_levels(const sn_mesh *mesh, const double *u, sn_index count, double *levels, sn_error *error) {
    double *sorted = SN_NEW(double, mesh->vertex_count), *work = SN_NEW(double, 4 * (MOST_BINS + 1));
    sn_status status = SN_OK;
    if (sorted && work) {
        enum { EACH = MOST_BINS + 1 };
        bins s = {.edges = work, .way = work + EACH, .area = work + 2 * EACH, .rise = work + 3 * EACH};
        make_bins(u, mesh->vertex_count, sorted, &s);
        measure_way(mesh, u, &s);
        if (s.way[s.count] > 0.0 && isfinite(s.way[s.count]))
            place_levels(&s, count, levels);
        else
            status = sn_fail(error, SN_ERROR_INPUT,
                             "no way leads from the fibres' origins to their insertions: the ends cover the whole surface");
    } else {
        status = sn_fail_memory(error, "the levels of the fibres");
    }
    free(sorted);
    free(work);
    return status;
}

/* ---- cutting ----------------------------------------------------------------------------------------------------------------- */

static sn_status cut_level(section *s, cutting *c, sn_index level, sn_trace *trace, sn_error *error) {
    sn_status status = section_cut(s, c->u, c->out->u[level], error);
    sn_index before = c->out->loop_count;
    c->out->first[level] = before;
    for (sn_index i = 0; i < s->curve_count && !status; i++)
        if (s->curves[i].count >= 3) status = cutting_add_loop(c, level, s->curves[i].count, s->cut_edges + s->curves[i].first, error);
    c->out->first[level + 1] = c->out->loop_count;
    if (status) return status;
    bool stop = SN_TRACE(trace, "level", sn_trace_number("number", level), sn_trace_number("u", c->out->u[level]),
                         sn_trace_number("loops", c->out->loop_count - before));
    return stop ? SN_STOPPED : SN_OK;
}

static sn_status cut_levels(cutting *c, sn_trace *trace, sn_error *error) {
    section s;
    sn_status status = section_create(c->mesh, c->topology, &s, error);
    if (status) return status;
    for (sn_index i = 0; i < c->out->level_count && !status; i++) status = cut_level(&s, c, i, trace, error);
    section_free(&s);
    return status;
}

/* ---- measures along the muscle -------------------------------------------------------------------------------------------------- */

static double level_area(const fill_levels *l, sn_index level) {
    double sum = 0.0;
    for (sn_index i = l->first[level]; i < l->first[level + 1]; i++) sum += l->loops[i].area;
    return sum;
}

/* The level with the fewest loops, of these the one with the greatest section: from there fibres are led to both ends. */
static sn_index choose_trunk(const fill_levels *l) {
    sn_index best = SN_NONE, fewest = SN_INDEX_MAX;
    double greatest = -1.0;
    for (sn_index i = 0; i < l->level_count; i++) {
        sn_index loops = l->first[i + 1] - l->first[i];
        double area = level_area(l, i);
        if (loops == 0 || loops > fewest || (loops == fewest && area <= greatest)) continue;
        best = i;
        fewest = loops;
        greatest = area;
    }
    return best;
}

static void find_centres(fill_levels *l) {
    for (sn_index i = 0; i < l->level_count; i++) {
        double sum = 0.0;
        sn_vec3 centre = {0, 0, 0};
        for (sn_index k = l->first[i]; k < l->first[i + 1]; k++) {
            if (!l->loops[k].reached) continue;
            double weight = l->loops[k].area + 1e-300;
            centre = sn_add_scaled(centre, l->loops[k].centroid, weight);
            sum += weight;
        }
        l->centre[i] = sum > 0.0 ? sn_scale(centre, 1.0 / sum) : l->centre[i > 0 ? i - 1 : 0];
    }
}

/* Mean way of the centroids from one level to the next, by area: where heads split the mean of the heads' ways. */
static double mean_step(const fill_levels *l, sn_index lower) {
    double sum = 0.0, way = 0.0;
    for (sn_index k = l->first[lower]; k < l->first[lower + 2]; k++) {
        const fill_loop *loop = &l->loops[k];
        for (sn_index i = 0; i < loop->link_count; i++) {
            const fill_loop *to = &l->loops[loop->links[i].loop];
            if (to->level + loop->level != 2 * lower + 1) continue;
            double weight = fmin(loop->area, to->area) + 1e-300;
            way += weight * sn_distance(loop->centroid, to->centroid);
            sum += weight;
        }
    }
    return sum > 0.0 ? way / sum : 0.0;
}

static sn_status measure(fill_levels *l, sn_error *error) {
    find_centres(l);
    for (sn_index i = 1; i < l->level_count; i++) l->z[i] = l->z[i - 1] + mean_step(l, i - 1);
    l->length = l->z[l->level_count - 1];
    if (!(l->length > 0.0))
        return sn_fail(error, SN_ERROR_INPUT, "the slices do not follow each other from end to end; clean the surface first");
    for (sn_index i = 0; i < l->level_count; i++) l->z[i] /= l->length;
    return SN_OK;
}

/* ---- the whole --------------------------------------------------------------------------------------------------------------------- */

static sn_status levels_alloc(fill_levels *l, sn_index count, sn_error *error) {
    *l = (fill_levels){.level_count = count};
    l->u = SN_NEW(double, count);
    l->z = SN_NEW(double, count);
    l->centre = SN_NEW(sn_vec3, count);
    l->first = SN_NEW(sn_index, count + 1);
    return l->u && l->z && l->centre && l->first ? SN_OK : sn_fail_memory(error, "the levels of the fibres");
}

sn_status fill_levels_build(const fill_field *field, const fill_levels_params *params, sn_trace *trace, fill_levels *out, sn_error *error) {
    cutting c = {.mesh = field->mesh, .topology = field->topology, .u = field->u, .out = out, .by_flux = params->flux};
    sn_status status = levels_alloc(out, params->count, error);
    if (!status) status = choose_levels(field->mesh, field->u, params->count, out->u, error);
    if (!status) status = cut_levels(&c, trace, error);
    if (!status && (out->trunk = choose_trunk(out)) == SN_NONE)
        status = sn_fail(error, SN_ERROR_INPUT, "no level between the ends cuts the surface in a loop; clean the surface first");
    if (!status) status = cutting_link(&c, params->turn, trace, error);
    if (!status) status = measure(out, error);
    cutting_free(&c);
    if (status) fill_levels_free(out);
    return status;
}

void fill_levels_free(fill_levels *l) {
    for (sn_index i = 0; i < l->loop_count; i++) {
        free(l->loops[i].links);
        fill_slice_free(&l->loops[i].slice);
    }
    free(l->loops);
    free(l->roots);
    free(l->u);
    free(l->z);
    free(l->centre);
    free(l->first);
    *l = (fill_levels){0};
}

/* ---- from the trunk outwards ------------------------------------------------------------------------------------------------------- */

/* A quarter of a turn about the middle of the square, `quarters` times. */
static fill_uv rotate(fill_uv at, int quarters) {
    for (int i = 0; i < (quarters & 3); i++) at = (fill_uv){1.0 - at.y, at.x};
    return at;
}

/* Off the strip, along x: 0 inside. */
static double off_strip(const fill_link *link, fill_uv at) {
    double x = rotate(at, 4 - link->turn_from).x;
    return fmax(fmax(link->from[0] - x, x - link->from[1]), 0.0);
}

static fill_uv through(const fill_link *link, fill_uv at) {
    fill_uv p = rotate(at, 4 - link->turn_from);
    double share = (p.x - link->from[0]) / (link->from[1] - link->from[0]);
    p.x = link->to[0] + fmin(fmax(share, 0.0), 1.0) * (link->to[1] - link->to[0]);
    return rotate(p, link->turn_to);
}

/* Through the link whose strip holds `guide`; SN_NONE = no link leads to the level. */
static sn_index follow(const fill_levels *l, const fill_link *links, sn_index count, sn_index level, fill_uv *at, fill_uv *guide) {
    const fill_link *best = NULL;
    double least = INFINITY;
    for (sn_index i = 0; i < count; i++) {
        if (l->loops[links[i].loop].level != level || off_strip(&links[i], *guide) >= least) continue;
        least = off_strip(&links[i], *guide);
        best = &links[i];
    }
    if (!best) return SN_NONE;
    *at = through(best, *at);
    *guide = through(best, *guide);
    return best->loop;
}

sn_index fill_carry(const fill_levels *l, sn_index level, fill_uv guide, fill_uv *at) {
    sn_index loop = follow(l, l->roots, l->root_count, l->trunk, at, &guide), step = level > l->trunk ? 1 : -1;
    for (sn_index i = l->trunk; loop != SN_NONE && i != level; i += step)
        loop = follow(l, l->loops[loop].links, l->loops[loop].link_count, i + step, at, &guide);
    return loop;
}
