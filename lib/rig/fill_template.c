/* fill_template.c -- fibres as curves in the unit square x [0,1]; z is the share of the line of action. */
#include "fill.h"

#define INSET 0.02      /* fibres keep off the square's boundary: they lie in the muscle, not on it */
#define LEAST_SHARE 0.3 /* of an oblique fibre that must lie between the muscle's ends */

static double inset(double x) { return INSET + (1.0 - 2.0 * INSET) * x; }

static double section(const fill_levels *l, sn_index level) {
    double sum = 0.0;
    for (sn_index i = l->first[level]; i < l->first[level + 1]; i++)
        if (l->loops[i].reached) sum += l->loops[i].area;
    return sum;
}

/* ---- from end to end: x as a function of z ------------------------------------------------------------------------------------ */

typedef struct shape {
    const sn_fill_params *params;
    bool narrow_last; /* fan: the insertions' end is the narrow one */
} shape;

static double across(const shape *s, double x, double z) {
    if (s->params->template == SN_FILL_FAN) {
        double t = s->narrow_last ? z : 1.0 - z;
        return 0.5 + (x - 0.5) * (1.0 - (1.0 - s->params->narrow) * t);
    }
    if (s->params->template == SN_FILL_CURVED) return x + 4.0 * s->params->bow * z * (1.0 - z) * x * (1.0 - x);
    return x;
}

double fill_template_across(const sn_fill_params *params, const fill_levels *l, double seed, sn_index level) {
    shape s = {params, section(l, l->level_count - 1) <= section(l, 0)};
    return across(&s, seed, l->z[level]);
}

static sn_index from_end_to_end(const sn_fill_params *params, const fill_levels *l, fill_uv seed, fill_node nodes[TEMPLATE_NODES]) {
    shape s = {params, section(l, l->level_count - 1) <= section(l, 0)};
    for (sn_index i = 0; i < l->level_count; i++) nodes[i] = (fill_node){{across(&s, seed.x, l->z[i]), seed.y}, l->z[i]};
    return l->level_count;
}

/* ---- oblique: straight lines, cut off at the muscle's ends ----------------------------------------------------------------------- */

/* A fibre from x = from to x = to rises by |to - from| width / tan(angle) along the line of action. */
static sn_index oblique(const sn_fill_params *params, const fill_levels *l, double from, double to, fill_uv seed,
                        fill_node nodes[TEMPLATE_NODES]) {
    double rise = fabs(to - from) * l->width / (sn_tan(params->angle) * l->length);
    double low = -(1.0 - LEAST_SHARE) * rise, high = 1.0 - LEAST_SHARE * rise;
    if (high < low) { /* longer than the muscle: any fibre crosses the middle */
        low = fmin(0.0, 0.5 - rise);
        high = fmax(1.0 - rise, 0.5 - rise);
    }
    double start = low + (high - low) * seed.x, begin = fmax(0.0, -start / rise), end = fmin(1.0, (1.0 - start) / rise);
    for (sn_index i = 0; i < l->level_count; i++) {
        double t = begin + (end - begin) * (double)i / (double)(l->level_count - 1);
        nodes[i] = (fill_node){{from + (to - from) * t, inset(seed.y)}, fmin(fmax(start + rise * t, 0.0), 1.0)};
    }
    return l->level_count;
}

/* ---- the user's ---------------------------------------------------------------------------------------------------------------------- */

/* de Casteljau */
static sn_vec3 bezier(const sn_fill_curve *curve, double t) {
    sn_vec3 p[FILL_CURVE_POINTS];
    for (sn_index i = 0; i < curve->count; i++) p[i] = curve->points[i];
    for (sn_index left = curve->count - 1; left > 0; left--)
        for (sn_index i = 0; i < left; i++) p[i] = sn_lerp(p[i], p[i + 1], t);
    return p[0];
}

/* The curves' shapes, their starts moved to the seed, blended by how near those starts are. A curve that starts at the seed is met exactly.
 */
static sn_vec3 blended(const sn_fill_params *params, fill_uv seed, double t) {
    sn_vec3 sum = {0, 0, 0};
    double weights = 0.0;
    for (sn_index c = 0; c < params->curve_count; c++) {
        sn_vec3 start = params->curves[c].points[0], here = bezier(&params->curves[c], t);
        double dx = seed.x - start.x, dy = seed.y - start.y, weight = 1.0 / (dx * dx + dy * dy + 1e-9);
        sum = sn_add_scaled(sum, sn_v3(here.x + dx, here.y + dy, here.z), weight);
        weights += weight;
    }
    return sn_scale(sum, 1.0 / weights);
}

static double clamp(double x) { return fmin(fmax(x, 0.0), 1.0); }

static sn_index as_given(const sn_fill_params *params, const fill_levels *l, fill_uv seed, fill_node nodes[TEMPLATE_NODES]) {
    for (sn_index i = 0; i < l->level_count; i++) {
        sn_vec3 p = blended(params, (fill_uv){inset(seed.x), inset(seed.y)}, (double)i / (double)(l->level_count - 1));
        nodes[i] = (fill_node){{inset(clamp(p.x)), inset(clamp(p.y))}, clamp(p.z)};
    }
    return l->level_count;
}

sn_index fill_template_fiber(const sn_fill_params *params, const fill_levels *l, fill_uv seed, sn_index fiber,
                             fill_node nodes[TEMPLATE_NODES]) {
    switch (params->template) {
    case SN_FILL_PENNATE:
        return oblique(params, l, INSET, 1.0 - INSET, seed, nodes);
    case SN_FILL_BIPENNATE:
        return oblique(params, l, fiber % 2 == 0 ? INSET : 1.0 - INSET, 0.5, seed, nodes);
    case SN_FILL_USER:
        return as_given(params, l, seed, nodes);
    default:
        return from_end_to_end(params, l, seed, nodes);
    }
}
