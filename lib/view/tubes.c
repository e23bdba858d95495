/* tubes.c -- capsules and spheres, met exactly by parallel rays. */
#include "render.h"

/* Highest z at (x, y) on the sphere; -INFINITY = missed. */
static double sphere_top(sn_vec3 c, double r, double x, double y) {
    double d2 = (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y);
    return d2 <= r * r ? c.z + sqrt(r * r - d2) : -INFINITY;
}

/* Highest z on the cylinder wall between the ends: |m - (m.u)u| = r with m = (x,y,z) - a, quadratic in z. */
static double wall_top(const tube *t, sn_vec3 u, double length, double x, double y) {
    sn_vec3 q = sn_v3(x - t->a.x, y - t->a.y, 0.0);
    double along = sn_dot(q, u), a = 1.0 - u.z * u.z;
    if (a < 1e-9) return -INFINITY; /* seen end on: the caps are all there is */
    double b = -along * u.z, c = sn_norm2(q) - along * along - t->radius * t->radius;
    double root = b * b - a * c;
    if (root < 0.0) return -INFINITY;
    double z = (-b + sqrt(root)) / a, s = along + z * u.z;
    return s >= 0.0 && s <= length ? t->a.z + z : -INFINITY;
}

static sn_vec3 normal_at(const tube *t, sn_vec3 u, double length, sn_vec3 p) {
    double s = fmin(fmax(sn_dot(sn_sub(p, t->a), u), 0.0), length);
    return sn_normalize(sn_sub(p, sn_add_scaled(t->a, u, s)));
}

static void draw(band *b, const tube *t, sn_vec3 low, sn_vec3 high) {
    double bottom = b->top - (b->height - 1) * b->step;
    sn_index row0 = (sn_index)fmax(ceil((b->top - fmin(high.y, b->top)) / b->step), 0.0);
    sn_index row1 = (sn_index)floor((b->top - fmax(low.y, bottom)) / b->step);
    sn_index column0 = (sn_index)fmax(ceil((fmax(low.x, b->left) - b->left) / b->step), 0.0);
    sn_index column1 = (sn_index)floor((fmin(high.x, b->left + (b->width - 1) * b->step) - b->left) / b->step);
    sn_vec3 axis = sn_sub(t->b, t->a), u = sn_normalize(axis);
    double length = sn_norm(axis);
    for (sn_index row = row0; row <= row1 && row < b->height; row++)
        for (sn_index column = column0; column <= column1 && column < b->width; column++) {
            double x = b->left + column * b->step, y = b->top - row * b->step;
            double z = fmax(sphere_top(t->a, t->radius, x, y), sphere_top(t->b, t->radius, x, y));
            if (length > 0.0) z = fmax(z, wall_top(t, u, length, x, y));
            sample *s = &b->samples[(size_t)row * (size_t)b->width + (size_t)column];
            if (!((float)z > s->depth)) continue;
            sn_vec3 n = normal_at(t, u, length, sn_v3(x, y, z));
            *s = (sample){shade(t->color, n, 1.0f, 0.25f), (float)z, (float)z, -2};
        }
}

void tubes_draw(band *b, size_t count, const tube *tubes) {
    double bottom = b->top - (b->height - 1) * b->step, right = b->left + (b->width - 1) * b->step;
    for (size_t i = 0; i < count; i++) {
        const tube *t = &tubes[i];
        sn_vec3 reach = sn_v3(t->radius, t->radius, t->radius);
        sn_vec3 low = sn_sub(sn_min3(t->a, t->b), reach), high = sn_add(sn_max3(t->a, t->b), reach);
        if (high.y >= bottom && low.y <= b->top && high.x >= b->left && low.x <= right) draw(b, t, low, high);
    }
}
