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

/* ---- oblique: straight lines, cut off at the muscle's sides and ends ---------------------------------------------------------------- */

/* The muscle as oblique fibres of one depth (y) find it. */
typedef struct strip {
    const fill_levels *levels;
    double y;
    double width[TEMPLATE_NODES]; /* by level: from x = INSET to 1 - INSET */
    double slope;                 /* across over z: tan(angle) times the length of the line of action */
} strip;

static void measure_strip(const sn_fill_params *params, const fill_levels *l, double y, strip *out) {
    *out = (strip){.levels = l, .y = y, .slope = sn_tan(params->angle) * l->length};
    for (sn_index i = 0; i < l->level_count; i++) {
        sn_vec3 a, b;
        fill_uv guide = {0.5, y};
        bool both = fill_place(l, params->map, i, guide, (fill_uv){INSET, y}, &a) &&
                    fill_place(l, params->map, i, guide, (fill_uv){1.0 - INSET, y}, &b);
        out->width[i] = both ? sn_distance(a, b) : 0.0;
    }
}

static double width_at(const strip *s, double z) {
    const fill_levels *l = s->levels;
    sn_index i = 0;
    while (i + 2 < l->level_count && l->z[i + 1] < z) i++;
    double step = l->z[i + 1] - l->z[i], t = step > 0.0 ? fmin(fmax((z - l->z[i]) / step, 0.0), 1.0) : 0.0;
    return s->width[i] + t * (s->width[i + 1] - s->width[i]);
}

/* Where a line that is in the middle at z = from meets the side, going up (way 1) or down (-1); at the muscle's end where it does not. */
static double side_from(const strip *s, double from, double way) {
    double before = from, step = 1.0 / (4 * TEMPLATE_NODES);
    for (double z = from + way * step; z > 0.0 && z < 1.0; before = z, z += way * step) {
        double off = s->slope * fabs(z - from) - 0.5 * width_at(s, z);
        if (off < 0.0) continue;
        double inside = 0.5 * width_at(s, before) - s->slope * fabs(before - from);
        return before + way * step * (inside + off > 0.0 ? fmax(inside, 0.0) / (inside + off) : 0.0);
    }
    return way > 0.0 ? 1.0 : 0.0;
}

/* Nodes at equal steps of z on the line that is in the middle at z = through and goes towards x = 1 (way 1) or 0 (-1). */
static sn_index oblique(const strip *s, const double span[2], double through, double way, fill_node nodes[TEMPLATE_NODES]) {
    sn_index count = s->levels->level_count;
    for (sn_index i = 0; i < count; i++) {
        double z = span[0] + (span[1] - span[0]) * (double)i / (double)(count - 1), width = width_at(s, z);
        double share = width > 0.0 ? way * s->slope * (z - through) / width : 0.0;
        nodes[i] = (fill_node){{0.5 + (1.0 - 2.0 * INSET) * fmin(fmax(share, -0.5), 0.5), s->y}, z};
    }
    return count;
}

static sn_index from_side_to_side(const sn_fill_params *params, const fill_levels *l, fill_uv seed, fill_node nodes[TEMPLATE_NODES]) {
    strip s;
    measure_strip(params, l, inset(seed.y), &s);
    double through = inset(seed.x), span[2] = {side_from(&s, through, -1.0), side_from(&s, through, 1.0)};
    return oblique(&s, span, through, 1.0, nodes);
}

/* From x = 0 (way 1) or x = 1 (-1) to the middle. */
static sn_index from_side_to_middle(const sn_fill_params *params, const fill_levels *l, fill_uv seed, double way,
                                    fill_node nodes[TEMPLATE_NODES]) {
    strip s;
    measure_strip(params, l, inset(seed.y), &s);
    double least = fmin(LEAST_SHARE * 0.5 * s.width[0] / s.slope, 0.9), through = least + (1.0 - least) * fmax(seed.x, INSET);
    double span[2] = {side_from(&s, through, -1.0), through};
    return oblique(&s, span, through, way, nodes);
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
        return from_side_to_side(params, l, seed, nodes);
    case SN_FILL_BIPENNATE:
        return from_side_to_middle(params, l, seed, fiber % 2 == 0 ? 1.0 : -1.0, nodes);
    case SN_FILL_USER:
        return as_given(params, l, seed, nodes);
    default:
        return from_end_to_end(params, l, seed, nodes);
    }
}
