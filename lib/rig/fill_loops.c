/*
 * fill_loops.c -- which loop follows which, and how fibres are shared out where loops split or merge: by area, in strips across the way
 * that parts them.
 */
#include "fill_loops.h"

#include <stdlib.h>
#include <string.h>

/* ---- loops ------------------------------------------------------------------------------------------------------------------ */

static sn_vec3 crossing(const cutting *c, sn_index edge, double level) {
    const sn_edge *e = &c->topology->edges[edge];
    double u0 = c->u[e->v[0]], u1 = c->u[e->v[1]], t = (level - u0) / (u1 - u0);
    if (!(t >= 0.0 && t <= 1.0)) t = 0.5;
    return sn_lerp(c->mesh->positions[e->v[0]], c->mesh->positions[e->v[1]], t);
}

static sn_index high_end(const cutting *c, sn_index edge) {
    const sn_edge *e = &c->topology->edges[edge];
    return c->u[e->v[0]] < c->u[e->v[1]] ? e->v[1] : e->v[0];
}

static sn_index low_end(const cutting *c, sn_index edge) {
    const sn_edge *e = &c->topology->edges[edge];
    return e->v[0] + e->v[1] - high_end(c, edge);
}

static sn_vec3 rising(const cutting *c, const cut_curve *curve) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = curve->first; i < curve->first + curve->count; i++)
        sum = sn_add(sum, sn_sub(c->mesh->positions[high_end(c, c->edges[i])], c->mesh->positions[low_end(c, c->edges[i])]));
    return sum;
}

static void turn_round(cutting *c, const cut_curve *curve) {
    for (sn_index i = curve->first, j = curve->first + curve->count - 1; i < j; i++, j--) {
        sn_vec3 p = c->points[i];
        sn_index e = c->edges[i];
        c->points[i] = c->points[j];
        c->edges[i] = c->edges[j];
        c->points[j] = p;
        c->edges[j] = e;
    }
}

static sn_vec3 mean_of(const cutting *c, const cut_curve *curve) {
    sn_vec3 sum = {0, 0, 0}, first = c->points[curve->first];
    for (sn_index i = 0; i < curve->count; i++) sum = sn_add(sum, sn_sub(c->points[curve->first + i], first));
    return sn_add_scaled(first, sum, 1.0 / (double)curve->count);
}

/* Area vector and centroid of the polygon, as a fan about the mean of its points. */
static void measure_loop(cutting *c, const cut_curve *curve, fill_loop *loop) {
    sn_vec3 mean = mean_of(c, curve), area = {0, 0, 0}, moment = {0, 0, 0};
    for (int pass = 0; pass < 2; pass++) {
        sn_vec3 normal = sn_normalize(area);
        double sum = 0.0;
        for (sn_index i = 0; i < curve->count; i++) {
            sn_vec3 a = sn_sub(c->points[curve->first + i], mean), b = sn_sub(c->points[curve->first + (i + 1) % curve->count], mean);
            sn_vec3 twice = sn_cross(a, b);
            if (pass == 0) area = sn_add_scaled(area, twice, 0.5);
            double weight = sn_dot(twice, normal);
            moment = sn_add_scaled(moment, sn_add(a, b), weight / 3.0);
            sum += weight;
        }
        if (pass == 1 && sum > 0.0) mean = sn_add_scaled(mean, moment, 1.0 / sum);
    }
    loop->area = sn_norm(area);
    loop->normal = sn_normalize(area);
    loop->centroid = mean;
}

static bool make_room(cutting *c, sn_index points) {
    size_t loops = (size_t)c->out->loop_count + 1, all = (size_t)c->point_count + (size_t)points;
    return sn_grow((void **)&c->out->loops, &c->loop_capacity, loops, sizeof *c->out->loops) &&
           sn_grow((void **)&c->curves, &c->curve_capacity, loops, sizeof *c->curves) &&
           sn_grow((void **)&c->edges, &c->edge_capacity, all, sizeof *c->edges) &&
           sn_grow((void **)&c->points, &c->point_capacity, all, sizeof *c->points);
}

sn_status cutting_add_loop(cutting *c, sn_index level, sn_index count, const sn_index *edges, sn_error *error) {
    if (!make_room(c, count)) return sn_fail_memory(error, "the slices of the muscle");
    cut_curve curve = {c->point_count, count};
    for (sn_index i = 0; i < count; i++) {
        c->edges[curve.first + i] = edges[i];
        c->points[curve.first + i] = crossing(c, edges[i], c->out->u[level]);
    }
    fill_loop loop = {.level = level};
    sn_vec3 up = rising(c, &curve);
    measure_loop(c, &curve, &loop);
    if (sn_dot(loop.normal, up) < 0.0) {
        turn_round(c, &curve);
        loop.normal = sn_neg(loop.normal);
    }
    if (!(sn_norm2(loop.normal) > 0.0)) loop.normal = sn_norm2(up) > 0.0 ? sn_normalize(up) : sn_v3(0, 0, 1);
    c->point_count += count;
    c->curves[c->out->loop_count] = curve;
    c->out->loops[c->out->loop_count++] = loop;
    return SN_OK;
}

void cutting_free(cutting *c) {
    free(c->curves);
    free(c->edges);
    free(c->points);
}

/* ---- what hangs together between two levels ------------------------------------------------------------------------------------ */

/* Disjoint sets of vertices (0 .. V - 1) and of the faces of loops: V + 2 loop is the one towards rising u, V + 2 loop + 1 the other. */
typedef struct bands {
    sn_index *parent;
    sn_index *band;      /* (vertex_count) levels at or below the vertex */
    sn_index *edge_loop; /* (edge_count) loop of the level before that crosses it */
} bands;

static sn_index find(sn_index *parent, sn_index i) {
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void unite(sn_index *parent, sn_index a, sn_index b) {
    a = find(parent, a);
    b = find(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static sn_index levels_below(const fill_levels *l, double u) {
    sn_index low = 0, high = l->level_count;
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        if (l->u[middle] <= u)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void unite_loop(const cutting *c, bands *b, sn_index loop) {
    sn_index vertices = c->mesh->vertex_count, level = c->out->loops[loop].level;
    for (sn_index i = c->curves[loop].first; i < c->curves[loop].first + c->curves[loop].count; i++) {
        sn_index edge = c->edges[i], low = low_end(c, edge), high = high_end(c, edge), before = b->edge_loop[edge];
        if (b->band[high] == level + 1) unite(b->parent, vertices + 2 * loop, high);
        if (b->band[low] == level) unite(b->parent, vertices + 2 * loop + 1, low);
        if (before != SN_NONE && c->out->loops[before].level == level - 1) unite(b->parent, vertices + 2 * loop + 1, vertices + 2 * before);
        b->edge_loop[edge] = loop;
    }
}

static bool bands_create(const cutting *c, bands *b) {
    sn_index vertices = c->mesh->vertex_count, nodes = vertices + 2 * c->out->loop_count;
    *b = (bands){SN_NEW(sn_index, nodes), SN_NEW(sn_index, vertices), SN_NEW(sn_index, c->topology->edge_count)};
    if (!b->parent || !b->band || !b->edge_loop) return false;
    for (sn_index i = 0; i < nodes; i++) b->parent[i] = i;
    for (sn_index v = 0; v < vertices; v++) b->band[v] = levels_below(c->out, c->u[v]);
    for (sn_index e = 0; e < c->topology->edge_count; e++) {
        const sn_index *v = c->topology->edges[e].v;
        b->edge_loop[e] = SN_NONE;
        if (b->band[v[0]] == b->band[v[1]]) unite(b->parent, v[0], v[1]);
    }
    for (sn_index l = 0; l < c->out->loop_count; l++) unite_loop(c, b, l);
    return true;
}

static void bands_free(bands *b) {
    free(b->parent);
    free(b->band);
    free(b->edge_loop);
}

/* ---- sharing out ---------------------------------------------------------------------------------------------------------------- */

enum { GROUP = 64 }; /* loops of one level that hang together; more are left unreached */

/* The loops before and after a band that hang together. */
typedef struct group {
    sn_index count[2];
    sn_index loops[2][GROUP];
} group;

/* The way from loop to loop on the side that has more of them: between the two farthest apart. */
static sn_vec3 parting_way(const fill_levels *l, const group *g) {
    int side = g->count[1] >= g->count[0] ? 1 : 0;
    sn_vec3 way = {0, 0, 0};
    for (sn_index i = 0; i < g->count[side]; i++)
        for (sn_index k = i + 1; k < g->count[side]; k++) {
            sn_vec3 d = sn_sub(l->loops[g->loops[side][k]].centroid, l->loops[g->loops[side][i]].centroid);
            if (sn_norm2(d) > sn_norm2(way)) way = d;
        }
    return way;
}

static void sort_along(const fill_levels *l, sn_vec3 way, sn_index count, sn_index *loops) {
    for (sn_index i = 1; i < count; i++)
        for (sn_index k = i; k > 0; k--) {
            double here = sn_dot(l->loops[loops[k]].centroid, way), before = sn_dot(l->loops[loops[k - 1]].centroid, way);
            if (here >= before) break;
            sn_index t = loops[k];
            loops[k] = loops[k - 1];
            loops[k - 1] = t;
        }
}

/* bounds[i] .. bounds[i + 1]: the share of loop i, by area. */
static void share_out(const fill_levels *l, sn_index count, const sn_index *loops, double *bounds) {
    double sum = 0.0;
    for (sn_index i = 0; i < count; i++) sum += l->loops[loops[i]].area + 1e-300;
    bounds[0] = 0.0;
    for (sn_index i = 0; i < count; i++) bounds[i + 1] = bounds[i] + (l->loops[loops[i]].area + 1e-300) / sum;
    bounds[count] = 1.0;
}

/* Quarter turns from the square's x to the side that lies most along `way`. */
static int quarter_of(const fill_loop *loop, sn_vec3 way) {
    double best = -INFINITY;
    int quarter = 0;
    for (int q = 0; q < 4; q++) {
        double along = sn_dot(sn_normalize(rim_axis(loop, q % 2)), way) * (q < 2 ? 1.0 : -1.0);
        if (along > best + 1e-12) {
            best = along;
            quarter = q;
        }
    }
    return quarter;
}

static sn_status add_link(fill_link **links, sn_index *count, fill_link link, sn_error *error) {
    fill_link *grown = sn_realloc(*links, (size_t)*count + 1, sizeof **links);
    if (!grown) return sn_fail_memory(error, "the slices of the muscle");
    *links = grown;
    grown[(*count)++] = link;
    return SN_OK;
}

/* Links where the shares of the two sides overlap. */
static sn_status link_shares(fill_levels *l, const group *g, sn_vec3 way, sn_error *error) {
    double bounds[2][GROUP + 1];
    sn_status status = SN_OK;
    for (int s = 0; s < 2; s++) share_out(l, g->count[s], g->loops[s], bounds[s]);
    for (sn_index i = 0; i < g->count[0] && !status; i++)
        for (sn_index k = 0; k < g->count[1] && !status; k++) {
            double low = fmax(bounds[0][i], bounds[1][k]), high = fmin(bounds[0][i + 1], bounds[1][k + 1]);
            double from = bounds[0][i + 1] - bounds[0][i], to = bounds[1][k + 1] - bounds[1][k];
            if (!(high - low > 1e-6 * fmin(from, to)) || !(high > low)) continue;
            fill_loop *a = &l->loops[g->loops[0][i]], *b = &l->loops[g->loops[1][k]];
            fill_link link = {.loop = g->loops[1][k],
                              .turn_from = quarter_of(a, way),
                              .turn_to = quarter_of(b, way),
                              .from = {(low - bounds[0][i]) / from, (high - bounds[0][i]) / from},
                              .to = {(low - bounds[1][k]) / to, (high - bounds[1][k]) / to}};
            status = add_link(&a->links, &a->link_count, link, error);
        }
    return status;
}

/* One loop follows one: its rim begins where the other's does. */
static sn_status continue_loop(cutting *c, sn_index from, sn_index to, sn_error *error) {
    const fill_loop *loop = &c->out->loops[from];
    sn_vec3 target[RIM];
    for (int k = 0; k < RIM; k++) target[k] = sn_sub(loop->rim[k], loop->centroid);
    sn_status status = rim_fit(c, to, loop->side, target, error);
    fill_link link = {.loop = to, .from = {0.0, 1.0}, .to = {0.0, 1.0}};
    return status ? status : add_link(&c->out->loops[from].links, &c->out->loops[from].link_count, link, error);
}

static sn_index nearest(const fill_levels *l, sn_index count, const sn_index *loops, sn_vec3 p) {
    sn_index best = loops[0];
    for (sn_index i = 1; i < count; i++)
        if (sn_distance(l->loops[loops[i]].centroid, p) < sn_distance(l->loops[best].centroid, p)) best = loops[i];
    return best;
}

/* Loops split or merge: new rims take their directions from the nearest loop before. */
static sn_status share_group(cutting *c, group *g, sn_error *error) {
    fill_levels *l = c->out;
    sn_status status = SN_OK;
    for (sn_index k = 0; k < g->count[1] && !status; k++) {
        sn_index to = g->loops[1][k], from = nearest(l, g->count[0], g->loops[0], l->loops[to].centroid);
        sn_vec3 target[RIM];
        double width, depth, side = rim_rectangle(c, to, rim_axis(&l->loops[from], 0), target, &width, &depth);
        status = rim_fit(c, to, side, target, error);
    }
    if (status) return status;
    sn_vec3 way = parting_way(l, g);
    for (int s = 0; s < 2; s++) sort_along(l, way, g->count[s], g->loops[s]);
    return link_shares(l, g, way, error);
}

static sn_status link_group(cutting *c, group *g, sn_trace *trace, sn_error *error) {
    for (sn_index k = 0; k < g->count[1]; k++) c->out->loops[g->loops[1][k]].reached = true;
    if (g->count[0] == 1 && g->count[1] == 1) return continue_loop(c, g->loops[0][0], g->loops[1][0], error);
    sn_status status = share_group(c, g, error);
    if (status) return status;
    bool stop =
        SN_TRACE(trace, g->count[1] > g->count[0] ? "split" : "merge", sn_trace_number("level", c->out->loops[g->loops[1][0]].level),
                 sn_trace_number("before", g->count[0]), sn_trace_number("after", g->count[1]));
    return stop ? SN_STOPPED : SN_OK;
}

/* All reached loops of `from` and what follows them on `to`, the next level up or down. */
static sn_status link_levels(cutting *c, bands *b, sn_index from, sn_index to, sn_trace *trace, sn_error *error) {
    const fill_levels *l = c->out;
    sn_index base = c->mesh->vertex_count, face[2] = {to > from ? 0 : 1, to > from ? 1 : 0};
    const sn_index levels[2] = {from, to};
    sn_status status = SN_OK;
    for (sn_index i = l->first[from]; i < l->first[from + 1] && !status; i++) {
        sn_index root = find(b->parent, base + 2 * i + face[0]);
        group g = {.count = {0, 0}};
        for (int s = 0; s < 2; s++)
            for (sn_index k = l->first[levels[s]]; k < l->first[levels[s] + 1]; k++)
                if (find(b->parent, base + 2 * k + face[s]) == root && g.count[s] < GROUP && (s == 1 || l->loops[k].reached))
                    g.loops[s][g.count[s]++] = k;
        if (g.count[0] > 0 && g.count[1] > 0 && g.loops[0][0] == i) status = link_group(c, &g, trace, error);
    }
    return status;
}

/* The trunk's own loops share the whole square. */
static sn_status start_trunk(cutting *c, double turn, sn_error *error) {
    fill_levels *l = c->out;
    group g = {.count = {0, 0}};
    sn_index widest = l->first[l->trunk];
    for (sn_index k = l->first[l->trunk]; k < l->first[l->trunk + 1]; k++) {
        if (g.count[1] < GROUP) g.loops[1][g.count[1]++] = k;
        if (l->loops[k].area > l->loops[widest].area) widest = k;
    }
    sn_vec3 x = rim_widest(c, widest, turn);
    sn_status status = SN_OK;
    for (sn_index k = 0; k < g.count[1] && !status; k++) {
        sn_vec3 target[RIM];
        double width, depth, side = rim_rectangle(c, g.loops[1][k], x, target, &width, &depth);
        status = rim_fit(c, g.loops[1][k], side, target, error);
        l->loops[g.loops[1][k]].reached = true;
        if (g.loops[1][k] != widest) continue;
        l->width = width;
        l->depth = depth;
    }
    double bounds[GROUP + 1];
    sn_vec3 way = parting_way(l, &g);
    sort_along(l, way, g.count[1], g.loops[1]);
    share_out(l, g.count[1], g.loops[1], bounds);
    for (sn_index k = 0; k < g.count[1] && !status; k++) {
        int quarter = g.count[1] > 1 ? quarter_of(&l->loops[g.loops[1][k]], way) : 0;
        fill_link link = {.loop = g.loops[1][k], .turn_to = quarter, .from = {bounds[k], bounds[k + 1]}, .to = {0.0, 1.0}};
        status = add_link(&l->roots, &l->root_count, link, error);
    }
    return status;
}

sn_status cutting_link(cutting *c, double turn, sn_trace *trace, sn_error *error) {
    fill_levels *l = c->out;
    bands b;
    sn_status status = bands_create(c, &b) ? start_trunk(c, turn, error) : sn_fail_memory(error, "the slices of the muscle");
    for (sn_index i = l->trunk; i + 1 < l->level_count && !status; i++) status = link_levels(c, &b, i, i + 1, trace, error);
    for (sn_index i = l->trunk; i > 0 && !status; i--) status = link_levels(c, &b, i, i - 1, trace, error);
    bands_free(&b);
    return status;
}
