/*
 * distance_field.c -- value and gradient of a tabulated distance; what holds of every table. Building one: distance_field_build.c.
 */
#include "sinew/distance_field.h"

#include <stdlib.h>
#include <string.h>

sn_distance_field_params sn_distance_field_defaults(double cell) { return (sn_distance_field_params){.cell = cell, .band = 3.0}; }

void sn_distance_field_free(sn_distance_field *field) {
    free(field->brick);
    free(field->values);
    free(field->coarse);
    *field = (sn_distance_field){0};
}

/* ---- value and gradient ---------------------------------------------------------------------------------------------------- */

/* A cube of the grid with the place of a point in it. */
typedef struct cube {
    const float *corner; /* the lowest; the next along x is corner[1] */
    size_t y, z;         /* to the next corner along y and z */
    double u, v, w;      /* in [0, 1] */
} cube;

/* The trilinear interpolant in the cube and its derivatives by u, v, w. */
static inline double interpolate(const cube *c, sn_vec3 *slope) {
    const float *a = c->corner, *b = a + c->y, *d = a + c->z, *e = d + c->y;
    double x00 = (double)a[1] - (double)a[0], x10 = (double)b[1] - (double)b[0];
    double x01 = (double)d[1] - (double)d[0], x11 = (double)e[1] - (double)e[0];
    double p00 = (double)a[0] + c->u * x00, p10 = (double)b[0] + c->u * x10;
    double p01 = (double)d[0] + c->u * x01, p11 = (double)e[0] + c->u * x11;
    double y0 = p10 - p00, y1 = p11 - p01, q0 = p00 + c->v * y0, q1 = p01 + c->v * y1;
    double x0 = x00 + c->v * (x10 - x00), x1 = x01 + c->v * (x11 - x01);
    slope->x = x0 + c->w * (x1 - x0);
    slope->y = y0 + c->w * (y1 - y0);
    slope->z = q1 - q0;
    return q0 + c->w * (q1 - q0);
}

/* The cell of a coordinate in [0, count]; the last one ends with its upper face. */
static inline sn_index cell_of(double x, sn_index count) {
    sn_index i = (sn_index)x;
    return i < count ? i : count - 1;
}

/* The cube of four cells' width that q, in cells, lies in. */
static inline cube coarse_cube(const sn_distance_field *f, sn_vec3 q) {
    const double per = 1.0 / SN_COARSE_CELLS;
    sn_index i = cell_of(q.x * per, 2 * f->bricks[0]), j = cell_of(q.y * per, 2 * f->bricks[1]), k = cell_of(q.z * per, 2 * f->bricks[2]);
    size_t y = 2 * (size_t)f->bricks[0] + 1, z = y * (2 * (size_t)f->bricks[1] + 1);
    return (cube){f->coarse + (size_t)i + (size_t)j * y + (size_t)k * z, y, z, q.x * per - i, q.y * per - j, q.z * per - k};
}

/* The smallest cube that holds values around q; *width in cells. */
static inline cube cube_at(const sn_distance_field *f, sn_vec3 q, double *width) {
    enum { N = SN_BRICK_CELLS };
    sn_index i = cell_of(q.x, N * f->bricks[0]), j = cell_of(q.y, N * f->bricks[1]), k = cell_of(q.z, N * f->bricks[2]);
    size_t at = (size_t)(i / N) + (size_t)f->bricks[0] * ((size_t)(j / N) + (size_t)f->bricks[1] * (size_t)(k / N));
    sn_index brick = f->brick[at];
    *width = brick == SN_NONE ? (double)SN_COARSE_CELLS : 1.0;
    if (brick == SN_NONE) return coarse_cube(f, q);
    size_t y = SN_BRICK_CORNERS, z = SN_BRICK_CORNERS * SN_BRICK_CORNERS;
    const float *values = f->values + (size_t)brick * SN_BRICK_VALUES;
    return (cube){values + (size_t)(i % N) + (size_t)(j % N) * y + (size_t)(k % N) * z, y, z, q.x - i, q.y - j, q.z - k};
}

static double beyond(double x, double low, double high) { return x < low ? x - low : x > high ? x - high : 0.0; }

/* From the surface's box to p; zero within. */
static sn_vec3 from_box(const sn_distance_field *f, sn_vec3 p) {
    return sn_v3(beyond(p.x, f->box.low.x, f->box.high.x), beyond(p.y, f->box.low.y, f->box.high.y),
                 beyond(p.z, f->box.low.z, f->box.high.z));
}

static double at_outside(const sn_distance_field *f, sn_vec3 p, sn_vec3 *gradient) {
    sn_vec3 away = from_box(f, p);
    if (gradient != NULL) *gradient = sn_normalize(away);
    return sn_finite3(p) ? sn_norm(away) : NAN;
}

static inline bool in_grid(const sn_distance_field *f, sn_vec3 q) {
    enum { N = SN_BRICK_CELLS };
    return q.x >= 0.0 && q.y >= 0.0 && q.z >= 0.0 && q.x <= N * f->bricks[0] && q.y <= N * f->bricks[1] && q.z <= N * f->bricks[2];
}

static inline double value_at(const sn_distance_field *f, double per_cell, sn_vec3 p, sn_vec3 *gradient) {
    sn_vec3 slope, q = sn_scale(sn_sub(p, f->origin), per_cell);
    double width;
    if (!in_grid(f, q)) return at_outside(f, p, gradient);
    cube c = cube_at(f, q, &width);
    double value = interpolate(&c, &slope);
    if (gradient != NULL) *gradient = sn_scale(slope, per_cell / width);
    return value;
}

double sn_distance_field_at(const sn_distance_field *field, sn_vec3 p, sn_vec3 *gradient) {
    return value_at(field, 1.0 / field->cell, p, gradient);
}

void sn_distance_field_at_all(const sn_distance_field *field, sn_index count, const sn_vec3 *points, double *values, sn_vec3 *gradients) {
    double per_cell = 1.0 / field->cell;
    for (sn_index i = 0; i < count; i++) values[i] = value_at(field, per_cell, points[i], gradients != NULL ? gradients + i : NULL);
}

static inline double larger(double a, double b) { return a > b ? a : b; } /* a line of branches in fmax costs more than the rest */

static inline double box_distance2(const sn_box *box, sn_vec3 p) {
    double x = larger(larger(box->low.x - p.x, p.x - box->high.x), 0.0);
    double y = larger(larger(box->low.y - p.y, p.y - box->high.y), 0.0);
    double z = larger(larger(box->low.z - p.z, p.z - box->high.z), 0.0);
    return x * x + y * y + z * z;
}

/* The coarse corners hold distances, which change no faster than a point moves. */
bool sn_distance_field_farther(const sn_distance_field *field, sn_vec3 p, double distance) {
    if (!(distance >= 0.0)) return false;
    if (box_distance2(&field->box, p) > distance * distance) return sn_finite3(p);
    sn_vec3 q = sn_scale(sn_sub(p, field->origin), 1.0 / (SN_COARSE_CELLS * field->cell));
    const sn_index *n = field->bricks;
    if (!(q.x >= 0.0 && q.y >= 0.0 && q.z >= 0.0 && q.x <= 2 * n[0] && q.y <= 2 * n[1] && q.z <= 2 * n[2])) return false;
    sn_index i = (sn_index)(q.x + 0.5), j = (sn_index)(q.y + 0.5), k = (sn_index)(q.z + 0.5);
    double away2 = sn_norm2(sn_v3(q.x - i, q.y - j, q.z - k)), width = SN_COARSE_CELLS * field->cell;
    size_t row = 2 * (size_t)n[0] + 1, layer = row * (2 * (size_t)n[1] + 1);
    double left = (double)field->coarse[(size_t)i + (size_t)j * row + (size_t)k * layer] * (1.0 - 1e-6) - distance;
    return left > 0.0 && left * left > away2 * width * width * (1.0 + 1e-9);
}

/* ---- what holds of every field ----------------------------------------------------------------------------------------------- */

sn_box sn_distance_field_box(const sn_distance_field *field) {
    const sn_index *n = field->bricks;
    double width = SN_BRICK_CELLS * field->cell;
    return (sn_box){field->origin, sn_add(field->origin, sn_v3(width * n[0], width * n[1], width * n[2]))};
}

static size_t brick_places(const sn_distance_field *f) { return (size_t)f->bricks[0] * (size_t)f->bricks[1] * (size_t)f->bricks[2]; }

static size_t coarse_places(const sn_distance_field *f) {
    return (2 * (size_t)f->bricks[0] + 1) * (2 * (size_t)f->bricks[1] + 1) * (2 * (size_t)f->bricks[2] + 1);
}

size_t sn_distance_field_bytes(const sn_distance_field *field) {
    size_t bricks = (size_t)field->brick_count * SN_BRICK_VALUES * sizeof *field->values;
    return sizeof *field + bricks + brick_places(field) * sizeof *field->brick + coarse_places(field) * sizeof *field->coarse;
}

static bool all_within(const float *values, size_t count, double bound) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs((double)values[i]) <= bound)) return false;
    return true;
}

static bool box_fits(const sn_distance_field *f) {
    sn_box grid = sn_distance_field_box(f);
    sn_vec3 low = sn_sub(f->box.low, grid.low), high = sn_sub(grid.high, f->box.high), size = sn_sub(f->box.high, f->box.low);
    double least = fmin(fmin(low.x, fmin(low.y, low.z)), fmin(high.x, fmin(high.y, high.z)));
    return sn_finite3(grid.low) && sn_finite3(grid.high) && least >= f->band && fmin(size.x, fmin(size.y, size.z)) >= 0.0;
}

bool sn_distance_field_is_valid(const sn_distance_field *field) {
    const sn_distance_field *f = field;
    double band = f->band / f->cell;
    if (!(f->cell > 0.0) || !isfinite(f->cell) || !(band > 0.99 && band < 16.01) || f->brick_count < 0) return false;
    for (int k = 0; k < 3; k++)
        if (f->bricks[k] < 1 || f->bricks[k] > SN_INDEX_MAX / SN_BRICK_CELLS) return false;
    if (!box_fits(f)) return false;
    sn_index next = 0;
    for (size_t i = 0; i < brick_places(f); i++)
        if (f->brick[i] != SN_NONE && f->brick[i] != next++) return false;
    double bound = 1.001 * sn_box_diagonal(sn_distance_field_box(f));
    return next == f->brick_count && all_within(f->coarse, coarse_places(f), bound) &&
           all_within(f->values, (size_t)f->brick_count * SN_BRICK_VALUES, bound);
}

sn_status sn_distance_field_hash(const sn_mesh *mesh, const sn_distance_field_params *params, char out[SN_HASH_LENGTH], sn_error *error) {
    const double numbers[5] = {1.0 /* version of the method */, (double)mesh->vertex_count, (double)mesh->triangle_count, params->cell,
                               params->band};
    size_t vertices = (size_t)mesh->vertex_count * sizeof *mesh->positions;
    size_t triangles = (size_t)mesh->triangle_count * sizeof *mesh->triangles;
    char *bytes = sn_alloc(sizeof numbers + vertices + triangles, 1);
    if (bytes == NULL) return sn_fail_memory(error, "the name of a distance field");
    memcpy(bytes, numbers, sizeof numbers);
    if (vertices > 0) memcpy(bytes + sizeof numbers, mesh->positions, vertices);
    if (triangles > 0) memcpy(bytes + sizeof numbers + vertices, mesh->triangles, triangles);
    sn_hash(bytes, sizeof numbers + vertices + triangles, out);
    free(bytes);
    return SN_OK;
}
