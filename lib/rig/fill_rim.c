/*
 * fill_rim.c -- the boundary of the square laid around a loop, by its length or by the field's flux through it.
 *
 * Flux is the integral of |grad u| along the loop. What flows through a level flows through the next one, so that points at equal steps of
 * flux follow the field. A part of the muscle without an end of its own, into which a loop runs and out again where its level passes by,
 * has hardly any flux but much length: by length all fibres turn aside there, each by its share, and back on the levels behind.
 */
#include <stdlib.h>

#include "fill_loops.h"

#define LENGTH_PART 0.2 /* by flux: what a loop's length counts for against it */
enum { DENSE = 256 };   /* places where the rim is tried to begin */

/* A closed curve by length or by flux. */
typedef struct curve {
    sn_index count;
    const sn_vec3 *points;
    double *way; /* (count + 1) */
} curve;

/* What flows through a cut edge: the discrete field's own flux, of which each vertex passes on as much as it gets. */
static double flux_through(const cutting *c, sn_index edge) {
    const sn_edge *e = &c->topology->edges[edge];
    return sn_edge_weight(c->mesh, e) * fabs(c->u[e->v[1]] - c->u[e->v[0]]);
}

/* The flux of each step, by its two edges, and for a part its length. */
static void weigh_steps(const cutting *c, const sn_index *edges, curve *k) {
    double length = 0.0, flux = 0.0;
    for (sn_index i = 0; i < k->count; i++) {
        length += k->way[i + 1];
        flux += flux_through(c, edges[i]);
    }
    if (!(flux > 0.0) || !(length > 0.0)) return;
    double part = LENGTH_PART * flux / length;
    for (sn_index i = 0; i < k->count; i++)
        k->way[i + 1] = part * k->way[i + 1] + 0.5 * (flux_through(c, edges[i]) + flux_through(c, edges[(i + 1) % k->count]));
}

static bool curve_create(const cutting *c, sn_index loop, curve *out) {
    const cut_curve *cut = &c->curves[loop];
    *out = (curve){.count = cut->count, .points = c->points + cut->first, .way = SN_NEW(double, cut->count + 1)};
    if (!out->way) return false;
    for (sn_index i = 0; i < out->count; i++) out->way[i + 1] = sn_distance(out->points[i], out->points[(i + 1) % out->count]);
    if (c->by_flux) weigh_steps(c, c->edges + cut->first, out);
    for (sn_index i = 0; i < out->count; i++) out->way[i + 1] += out->way[i];
    return true;
}

static sn_vec3 curve_at(const curve *k, double s) {
    double length = k->way[k->count];
    if (!(length > 0.0)) return k->points[0];
    s -= length * floor(s / length);
    sn_index low = 0, high = k->count - 1;
    while (low < high) {
        sn_index middle = low + (high - low + 1) / 2;
        if (k->way[middle] <= s)
            low = middle;
        else
            high = middle - 1;
    }
    double step = k->way[low + 1] - k->way[low];
    return sn_lerp(k->points[low], k->points[(low + 1) % k->count], step > 0.0 ? (s - k->way[low]) / step : 0.0);
}

/* Points of a side for its share of the loop's length. */
static int wide_of(double side) {
    int wide = (int)lround(RIM * side);
    return wide < RIM / 16 ? RIM / 16 : wide > RIM / 2 - RIM / 16 ? RIM / 2 - RIM / 16 : wide;
}

/* Shares of the loop's length at which the rim's points lie. */
static void rim_shares(double side, int wide, double out[RIM]) {
    const double share[2] = {side, 0.5 - side};
    const int points[2] = {wide, RIM / 2 - wide};
    double start = 0.0;
    for (int k = 0, s = 0; s < 4; s++) {
        for (int i = 0; i < points[s % 2]; i++) out[k++] = start + share[s % 2] * i / points[s % 2];
        start += share[s % 2];
    }
}

static double agreement(const sn_vec3 dense[DENSE], int begin, const int index[RIM], const sn_vec3 target[RIM]) {
    double sum = 0.0;
    for (int k = 0; k < RIM; k++) sum += sn_dot(dense[(begin + index[k]) % DENSE], target[k]);
    return sum;
}

/* The beginning of best agreement, refined by the parabola through it and its neighbours; in steps of the dense points. */
static double best_beginning(const sn_vec3 dense[DENSE], const int index[RIM], const sn_vec3 target[RIM]) {
    double value[DENSE];
    int best = 0;
    for (int b = 0; b < DENSE; b++) {
        value[b] = agreement(dense, b, index, target);
        if (value[b] > value[best]) best = b;
    }
    double before = value[(best + DENSE - 1) % DENSE], after = value[(best + 1) % DENSE], bend = before - 2.0 * value[best] + after;
    return best + (bend < 0.0 ? 0.5 * (before - after) / bend : 0.0);
}

sn_status rim_fit(const cutting *c, sn_index number, double side, const sn_vec3 target[RIM], sn_error *error) {
    fill_loop *loop = &c->out->loops[number];
    curve k;
    if (!curve_create(c, number, &k)) return sn_fail_memory(error, "the rim of a slice");
    double length = k.way[k.count], share[RIM];
    sn_vec3 dense[DENSE];
    int index[RIM];
    loop->side = side;
    loop->wide = wide_of(side);
    rim_shares(side, loop->wide, share);
    for (int i = 0; i < DENSE; i++) dense[i] = sn_sub(curve_at(&k, length * i / DENSE), loop->centroid);
    for (int i = 0; i < RIM; i++) index[i] = (int)lround(share[i] * DENSE);
    double begin = best_beginning(dense, index, target) / DENSE;
    for (int i = 0; i < RIM; i++) loop->rim[i] = curve_at(&k, length * (begin + share[i]));
    free(k.way);
    return SN_OK;
}

static double extent(const cutting *c, sn_index loop, sn_vec3 along) {
    const sn_vec3 *p = c->points + c->curves[loop].first;
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < c->curves[loop].count; i++) {
        double at = sn_dot(sn_sub(p[i], p[0]), along);
        low = fmin(low, at);
        high = fmax(high, at);
    }
    return high - low;
}

double rim_rectangle(const cutting *c, sn_index number, sn_vec3 along, sn_vec3 target[RIM], double *width, double *depth) {
    const fill_loop *loop = &c->out->loops[number];
    sn_vec3 x = sn_normalize(sn_add_scaled(along, loop->normal, -sn_dot(along, loop->normal)));
    if (!(sn_norm2(x) > 0.0)) x = rim_widest(c, number, 0.0);
    sn_vec3 y = sn_cross(loop->normal, x);
    fill_uv square[RIM];
    *width = extent(c, number, x);
    *depth = extent(c, number, y);
    double side = *width + *depth > 0.0 ? 0.5 * *width / (*width + *depth) : 0.25;
    side = fmin(fmax(side, 1.0 / 16.0), 7.0 / 16.0);
    fill_square_rim(wide_of(side), square);
    for (int k = 0; k < RIM; k++) target[k] = sn_add(sn_scale(x, (square[k].x - 0.5) * *width), sn_scale(y, (square[k].y - 0.5) * *depth));
    return side;
}

sn_vec3 rim_widest(const cutting *c, sn_index number, double turn) {
    const fill_loop *loop = &c->out->loops[number];
    const sn_vec3 *p = c->points + c->curves[number].first;
    sn_index count = c->curves[number].count;
    sn_vec3 aside = fabs(loop->normal.x) < 0.6 ? sn_v3(1, 0, 0) : sn_v3(0, 1, 0);
    sn_vec3 e = sn_normalize(sn_cross(aside, loop->normal)), f = sn_cross(loop->normal, e);
    double ee = 0.0, ef = 0.0, ff = 0.0;
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 d = sn_sub(sn_lerp(p[i], p[(i + 1) % count], 0.5), loop->centroid);
        double weight = sn_distance(p[i], p[(i + 1) % count]), a = sn_dot(d, e), b = sn_dot(d, f);
        ee += weight * a * a;
        ef += weight * a * b;
        ff += weight * b * b;
    }
    double angle = 0.5 * sn_atan2(2.0 * ef, ee - ff);
    sn_vec3 x = sn_add(sn_scale(e, sn_cos(angle)), sn_scale(f, sn_sin(angle)));
    double largest = fabs(x.x) >= fabs(x.y) && fabs(x.x) >= fabs(x.z) ? x.x : fabs(x.y) >= fabs(x.z) ? x.y : x.z;
    if (largest < 0.0) x = sn_neg(x); /* of the two ways the one that does not depend on where the loop begins */
    return sn_add(sn_scale(x, sn_cos(turn)), sn_scale(sn_cross(loop->normal, x), sn_sin(turn)));
}

sn_vec3 rim_axis(const fill_loop *loop, int axis) {
    fill_uv square[RIM];
    sn_vec3 sum = {0, 0, 0};
    fill_square_rim(loop->wide, square);
    for (int k = 0; k < RIM; k++)
        sum = sn_add_scaled(sum, sn_sub(loop->rim[k], loop->centroid), (axis == 0 ? square[k].x : square[k].y) - 0.5);
    return sum;
}
