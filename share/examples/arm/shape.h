/*
 * shape.h -- a body of anatomy.h as an implicit surface: f < 0 inside, about the distance in metres near the surface.
 */
#ifndef ARM_SHAPE_H
#define ARM_SHAPE_H

#include "anatomy.h"
#include "sinew/mesh.h"

enum { SHAPE_STEPS = 6, SHAPE_MAX_NODES = (ARM_MAX_SECTIONS - 1) * SHAPE_STEPS + 1 };

typedef struct shape_node {
    sn_vec3 centre, tangent;
    double wide, thick;
    sn_vec3 to_next;     /* along the centre line to the next node */
    double over_length2; /* 1 / |to_next|^2 */
} shape_node;

typedef struct shape_tube {
    bool carve;
    double blend;
    sn_vec3 across;
    int count;
    shape_node nodes[SHAPE_MAX_NODES];
} shape_tube;

typedef struct shape {
    int count;
    shape_tube tubes[ARM_MAX_TUBES];
    sn_box box; /* holds the whole surface */
} shape;

/* Fritsch-Carlson's condition by its simplest sufficient rule: no slope at an extremum, else the harmonic mean. Keeps radii between
 * those of the sections and leaves straight tubes straight. */
static double shape_slope(double before, double after) { return before * after <= 0.0 ? 0.0 : 2.0 * before * after / (before + after); }

/* Cubic Hermite through b and c of the values a, b, c, d at equal steps, monotone between its knots. */
static double shape_monotone(double a, double b, double c, double d, double t) {
    double m0 = shape_slope(b - a, c - b), m1 = shape_slope(c - b, d - c), s = 1.0 - t;
    return s * s * (1 + 2 * t) * b + t * s * s * m0 + t * t * (1 + 2 * s) * c - t * t * s * m1;
}

/* Catmull-Rom. */
static double shape_spline(double a, double b, double c, double d, double t) {
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

static shape_node shape_node_between(const arm_section *s, int count, int span, double t) {
    const arm_section *a = &s[span > 0 ? span - 1 : 0], *b = &s[span], *c = &s[span + 1], *d = &s[span + 2 < count ? span + 2 : span + 1];
    const double meters = 1e-3;
    shape_node node = {.wide = meters * shape_monotone(a->wide, b->wide, c->wide, d->wide, t),
                       .thick = meters * shape_monotone(a->thick, b->thick, c->thick, d->thick, t)};
    node.centre = sn_scale(
        sn_v3(shape_spline(a->x, b->x, c->x, d->x, t), shape_spline(a->y, b->y, c->y, d->y, t), shape_spline(a->z, b->z, c->z, d->z, t)),
        meters);
    return node;
}

static void shape_tube_tangents(shape_tube *tube) {
    for (int i = 0; i < tube->count; i++) {
        const shape_node *before = &tube->nodes[i > 0 ? i - 1 : 0], *after = &tube->nodes[i + 1 < tube->count ? i + 1 : i];
        tube->nodes[i].tangent = sn_normalize(sn_sub(after->centre, before->centre));
        tube->nodes[i].to_next = sn_sub(after->centre, tube->nodes[i].centre);
        tube->nodes[i].over_length2 = 1.0 / fmax(sn_norm2(tube->nodes[i].to_next), 1e-18);
    }
}

static void shape_tube_build(const arm_tube *from, shape_tube *tube) {
    tube->carve = from->carve;
    tube->blend = 1e-3 * from->blend;
    tube->across = sn_v3(from->across[0], from->across[1], from->across[2]);
    tube->count = (from->count - 1) * SHAPE_STEPS + 1;
    for (int i = 0; i < tube->count; i++) {
        int span = i / SHAPE_STEPS < from->count - 1 ? i / SHAPE_STEPS : from->count - 2;
        tube->nodes[i] = shape_node_between(from->sections, from->count, span, (double)(i - span * SHAPE_STEPS) / SHAPE_STEPS);
    }
    shape_tube_tangents(tube);
}

static void shape_build(const arm_body *body, shape *out) {
    out->count = body->count;
    out->box = (sn_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < body->count; i++) {
        shape_tube *tube = &out->tubes[i];
        shape_tube_build(&body->tubes[i], tube);
        for (int k = 0; k < tube->count && !tube->carve; k++) {
            double reach = fmax(tube->nodes[k].wide, tube->nodes[k].thick) + tube->blend;
            out->box.low = sn_min3(out->box.low, sn_sub(tube->nodes[k].centre, sn_v3(reach, reach, reach)));
            out->box.high = sn_max3(out->box.high, sn_add(tube->nodes[k].centre, sn_v3(reach, reach, reach)));
        }
    }
}

/* The point of the tube's centre line closest to p. */
static shape_node shape_tube_closest(const shape_tube *tube, sn_vec3 p) {
    double best = INFINITY, best_t = 0.0;
    int segment = 0;
    for (int i = 0; i + 1 < tube->count; i++) {
        const shape_node *a = &tube->nodes[i];
        sn_vec3 offset = sn_sub(p, a->centre);
        double t = sn_dot(offset, a->to_next) * a->over_length2;
        t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
        double distance = sn_norm2(sn_add_scaled(offset, a->to_next, -t));
        if (distance < best) { best = distance, best_t = t, segment = i; }
    }
    const shape_node *a = &tube->nodes[segment], *b = a + 1;
    return (shape_node){.centre = sn_lerp(a->centre, b->centre, best_t),
                        .tangent = sn_normalize(sn_lerp(a->tangent, b->tangent, best_t)),
                        .wide = a->wide + best_t * (b->wide - a->wide),
                        .thick = a->thick + best_t * (b->thick - a->thick)};
}

/* First-order distance to the ellipse around the closest point of the centre line: with q = offset / radii, d = |q| (|q| - 1) /
 * |q / radii|. Ends are rounded by half an ellipsoid. *radius (nullable): the smaller half axis there. */
static double shape_tube_distance(const shape_tube *tube, sn_vec3 p, double *radius) {
    shape_node node = shape_tube_closest(tube, p);
    sn_vec3 offset = sn_sub(p, node.centre);
    sn_vec3 wide = sn_normalize(sn_add_scaled(tube->across, node.tangent, -sn_dot(tube->across, node.tangent)));
    sn_vec3 thick = sn_cross(node.tangent, wide);
    double round = fmin(node.wide, node.thick);
    if (radius) *radius = round;
    sn_vec3 q = sn_v3(sn_dot(offset, wide) / node.wide, sn_dot(offset, thick) / node.thick, sn_dot(offset, node.tangent) / round);
    double length = sn_norm(q), slope = sn_norm(sn_v3(q.x / node.wide, q.y / node.thick, q.z / round));
    return slope > 0.0 ? length * (length - 1.0) / slope : -round;
}

/* Polynomial smooth minimum: differs from min(a, b) only where |a - b| < width. */
static double shape_smooth_min(double a, double b, double width) {
    double h = width > 0.0 ? fmax(width - fabs(a - b), 0.0) / width : 0.0;
    return fmin(a, b) - 0.25 * width * h * h;
}

static double shape_distance(const shape *s, sn_vec3 p) {
    double f = shape_tube_distance(&s->tubes[0], p, NULL);
    for (int i = 1; i < s->count; i++) {
        double d = shape_tube_distance(&s->tubes[i], p, NULL);
        f = s->tubes[i].carve ? -shape_smooth_min(-f, d, s->tubes[i].blend) : shape_smooth_min(f, d, s->tubes[i].blend);
    }
    return f;
}

/* The longest edge that still follows the surface at p: five or six to the way around the tube there, which is the one nearest to p. */
static double shape_edge_limit(const shape *s, sn_vec3 p) {
    double nearest = INFINITY, limit = INFINITY, radius;
    for (int i = 0; i < s->count; i++) {
        double d = s->tubes[i].carve ? INFINITY : fabs(shape_tube_distance(&s->tubes[i], p, &radius));
        if (d < nearest) { nearest = d, limit = 1.2 * radius; }
    }
    return limit;
}

/* f and its gradient at p, from four values at the corners of a small tetrahedron. */
static sn_vec3 shape_gradient(const shape *s, sn_vec3 p, double *value) {
    const double h = 1e-6; /* m */
    double a = shape_distance(s, sn_v3(p.x + h, p.y - h, p.z - h)), b = shape_distance(s, sn_v3(p.x - h, p.y - h, p.z + h));
    double c = shape_distance(s, sn_v3(p.x - h, p.y + h, p.z - h)), d = shape_distance(s, sn_v3(p.x + h, p.y + h, p.z + h));
    *value = 0.25 * (a + b + c + d);
    return sn_scale(sn_v3(a - b - c + d, -a - b + c + d, -a + b - c + d), 0.25 / h);
}

/* Newton steps along the gradient, each at most `reach` long: a second one only where the first was long enough to leave more than
 * about a micrometre. *normal is the unit gradient at the last. */
static sn_vec3 shape_project(const shape *s, sn_vec3 p, double reach, sn_vec3 *normal) {
    const double short_step = 1e-4; /* m */
    for (int step = 0; step < 2; step++) {
        double f;
        sn_vec3 gradient = shape_gradient(s, p, &f);
        double slope2 = fmax(sn_norm2(gradient), 1e-4), length = fabs(f) / sqrt(slope2);
        p = sn_add_scaled(p, gradient, -f / slope2 * (length > reach ? reach / length : 1.0));
        *normal = sn_normalize(gradient);
        if (length < short_step) break;
    }
    return p;
}

#endif
