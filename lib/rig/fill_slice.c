/*
 * fill_slice.c -- the harmonic map of a slice onto the unit square.
 *
 * The slice is triangulated; its rim goes to the boundary of the square and every inner vertex to the weighted mean of its neighbours. With
 * positive weights and a convex image no triangle turns over (Tutte 1963; Floater 2003), so every point of the square has one place in the
 * polygon, however concave that is. Out of its plane the slice is harmonic too: it spans its rim.
 */
#include <stdlib.h>

#include "fill.h"
#include "triangulate.h"

enum { MOST_INNER = 256 };
#define LEAST_SPACING 1e-3 /* of inner points, against the perimeter */
#define LEAST_WEIGHT 1e-3  /* of an edge: cotangents may be negative beside the rim */

void fill_square_rim(int wide, fill_uv out[RIM]) {
    int high = RIM / 2 - wide, k = 0;
    for (int i = 0; i < wide; i++) out[k++] = (fill_uv){(double)i / wide, 0.0};
    for (int i = 0; i < high; i++) out[k++] = (fill_uv){1.0, (double)i / high};
    for (int i = 0; i < wide; i++) out[k++] = (fill_uv){1.0 - (double)i / wide, 1.0};
    for (int i = 0; i < high; i++) out[k++] = (fill_uv){0.0, 1.0 - (double)i / high};
}

/* ---- the polygon's plane --------------------------------------------------------------------------------------------------- */

typedef struct slice_plane {
    sn_vec3 origin, x, y, normal;
} slice_plane;

static slice_plane plane_of(const sn_vec3 rim[RIM]) {
    slice_plane p = {.origin = {0, 0, 0}};
    for (int k = 0; k < RIM; k++) p.origin = sn_add_scaled(p.origin, rim[k], 1.0 / RIM);
    sn_vec3 area = {0, 0, 0};
    for (int k = 0; k < RIM; k++) area = sn_add(area, sn_cross(sn_sub(rim[k], p.origin), sn_sub(rim[(k + 1) % RIM], p.origin)));
    p.normal = sn_normalize(area);
    if (!(sn_norm2(p.normal) > 0.0)) p.normal = sn_v3(0, 0, 1);
    sn_vec3 aside = fabs(p.normal.x) < 0.6 ? sn_v3(1, 0, 0) : sn_v3(0, 1, 0);
    p.x = sn_normalize(sn_cross(aside, p.normal));
    p.y = sn_cross(p.normal, p.x);
    return p;
}

static double polygon_area(const polygon_point points[RIM]) {
    double sum = 0.0;
    for (int k = 0; k < RIM; k++) sum += points[k].x * points[(k + 1) % RIM].y - points[k].y * points[(k + 1) % RIM].x;
    return 0.5 * sum;
}

/* Distance of inner points: three across the thickness, but no finer than the rim asks for and no more than there is room for. A rim whose
 * sides cover each other has no area to speak of, and a box of any size. */
static double inner_spacing(const polygon_point points[RIM]) {
    double perimeter = 0.0, area = fmax(polygon_area(points), 0.0);
    for (int k = 0; k < RIM; k++) perimeter += sn_length2(points[(k + 1) % RIM].x - points[k].x, points[(k + 1) % RIM].y - points[k].y);
    if (!(perimeter > 0.0)) return 0.0;
    double thickness = 2.0 * area / perimeter;
    return fmax(fmax(fmin(1.6 * perimeter / RIM, 0.6 * thickness), sqrt(area / (0.8 * MOST_INNER))), LEAST_SPACING * perimeter);
}

/* ---- the harmonic map ------------------------------------------------------------------------------------------------------- */

typedef struct slice_edge {
    sn_index a, b;
    double weight;
} slice_edge;

enum { FIELDS = 3 }; /* x and y in the square, and the height over the plane */

typedef struct laplace {
    sn_index first, count; /* unknowns: vertices first .. first + count - 1 */
    sn_index edge_count;
    slice_edge *edges;
    double *diagonal, *x, *r, *p, *q; /* (count) */
} laplace;

static double half_cotangent(polygon_point apex, polygon_point a, polygon_point b) {
    double ux = a.x - apex.x, uy = a.y - apex.y, vx = b.x - apex.x, vy = b.y - apex.y;
    double sine = fabs(ux * vy - uy * vx);
    return sine > 0.0 ? fmin(0.5 * (ux * vx + uy * vy) / sine, 1e3) : 0.0;
}

static double edge_weight(const polygon_mesh *m, sn_index t, int c) {
    const sn_index *v = m->triangles[t];
    double weight = half_cotangent(m->points[v[c]], m->points[v[(c + 1) % 3]], m->points[v[(c + 2) % 3]]);
    sn_index s = m->across[t][c];
    for (int d = 0; s != SN_NONE && d < 3; d++)
        if (m->across[s][d] == t)
            weight += half_cotangent(m->points[m->triangles[s][d]], m->points[v[(c + 1) % 3]], m->points[v[(c + 2) % 3]]);
    return fmax(weight, LEAST_WEIGHT);
}

static bool laplace_create(const polygon_mesh *m, laplace *l) {
    *l = (laplace){.first = m->corners, .count = m->vertex_count - m->corners};
    l->edges = SN_NEW(slice_edge, 3 * m->triangle_count);
    l->diagonal = SN_NEW(double, 5 * l->count);
    if (!l->edges || !l->diagonal) return false;
    l->x = l->diagonal + l->count;
    l->r = l->x + l->count;
    l->p = l->r + l->count;
    l->q = l->p + l->count;
    for (sn_index t = 0; t < m->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            sn_index a = m->triangles[t][(c + 1) % 3], b = m->triangles[t][(c + 2) % 3], s = m->across[t][c];
            if ((s != SN_NONE && s < t) || (a < l->first && b < l->first)) continue;
            slice_edge e = {a, b, edge_weight(m, t, c)};
            l->edges[l->edge_count++] = e;
            if (a >= l->first) l->diagonal[a - l->first] += e.weight;
            if (b >= l->first) l->diagonal[b - l->first] += e.weight;
        }
    return true;
}

static void laplace_free(laplace *l) {
    free(l->edges);
    free(l->diagonal);
}

/* q = A p */
static void apply(const laplace *l) {
    for (sn_index i = 0; i < l->count; i++) l->q[i] = l->diagonal[i] * l->p[i];
    for (sn_index e = 0; e < l->edge_count; e++) {
        sn_index a = l->edges[e].a - l->first, b = l->edges[e].b - l->first;
        if (a < 0 || b < 0) continue;
        l->q[a] -= l->edges[e].weight * l->p[b];
        l->q[b] -= l->edges[e].weight * l->p[a];
    }
}

static double preconditioned(const laplace *l) {
    double sum = 0.0;
    for (sn_index i = 0; i < l->count; i++) sum += l->r[i] * l->r[i] / l->diagonal[i];
    return sum;
}

/* Conjugate gradients, diagonally preconditioned, from zero: few hundred unknowns at most. rim (first) holds the fixed values. */
static void solve(laplace *l, const double *rim) {
    for (sn_index i = 0; i < l->count; i++) l->x[i] = l->r[i] = 0.0;
    for (sn_index e = 0; e < l->edge_count; e++) {
        sn_index a = l->edges[e].a, b = l->edges[e].b;
        if (a < l->first) l->r[b - l->first] += l->edges[e].weight * rim[a];
        if (b < l->first) l->r[a - l->first] += l->edges[e].weight * rim[b];
    }
    for (sn_index i = 0; i < l->count; i++) l->p[i] = l->r[i] / l->diagonal[i];
    double rho = preconditioned(l), goal = 1e-24 * rho;
    for (sn_index step = 0; step < 4 * l->count && rho > goal; step++) {
        apply(l);
        double pq = 0.0;
        for (sn_index i = 0; i < l->count; i++) pq += l->p[i] * l->q[i];
        if (!(pq > 0.0)) return;
        double alpha = rho / pq;
        for (sn_index i = 0; i < l->count; i++) {
            l->x[i] += alpha * l->p[i];
            l->r[i] -= alpha * l->q[i];
        }
        double next = preconditioned(l), beta = next / rho;
        for (sn_index i = 0; i < l->count; i++) l->p[i] = l->r[i] / l->diagonal[i] + beta * l->p[i];
        rho = next;
    }
}

static sn_status map_to_square(const polygon_mesh *m, const slice_plane *plane, const sn_vec3 rim[RIM], int wide, fill_slice *out,
                               sn_error *error) {
    double values[FIELDS][RIM];
    laplace l;
    fill_square_rim(wide, out->square);
    for (int k = 0; k < RIM; k++) {
        values[0][k] = out->square[k].x;
        values[1][k] = out->square[k].y;
        values[2][k] = sn_dot(sn_sub(rim[k], plane->origin), plane->normal);
        out->positions[k] = rim[k];
    }
    bool made = laplace_create(m, &l);
    for (int field = 0; made && field < FIELDS; field++) {
        solve(&l, values[field]);
        for (sn_index i = 0; i < l.count; i++) {
            sn_index v = l.first + i;
            if (field == 0) out->square[v].x = l.x[i];
            if (field == 1) out->square[v].y = l.x[i];
            if (field < 2) continue;
            sn_vec3 flat = sn_add_scaled(sn_add_scaled(plane->origin, plane->x, m->points[v].x), plane->y, m->points[v].y);
            out->positions[v] = sn_add_scaled(flat, plane->normal, l.x[i]);
        }
    }
    laplace_free(&l);
    return made ? SN_OK : sn_fail_memory(error, "a slice");
}

sn_status fill_slice_build(const sn_vec3 rim[RIM], int wide, fill_slice *out, sn_error *error) {
    slice_plane plane = plane_of(rim);
    polygon_point corners[RIM];
    polygon_mesh m;
    *out = (fill_slice){0};
    for (int k = 0; k < RIM; k++) {
        sn_vec3 d = sn_sub(rim[k], plane.origin);
        corners[k] = (polygon_point){sn_dot(d, plane.x), sn_dot(d, plane.y)};
    }
    sn_status status = polygon_triangulate(RIM, corners, inner_spacing(corners), MOST_INNER, &m, error);
    if (status) return status;
    *out = (fill_slice){.vertex_count = m.vertex_count, .triangle_count = m.triangle_count, .triangles = m.triangles, .across = m.across};
    m.triangles = m.across = NULL;
    out->positions = SN_NEW(sn_vec3, m.vertex_count);
    out->square = SN_NEW(fill_uv, m.vertex_count);
    polygon_mesh view = m;
    view.triangles = out->triangles;
    view.across = out->across;
    if (out->positions && out->square)
        status = map_to_square(&view, &plane, rim, wide, out, error);
    else
        status = sn_fail_memory(error, "a slice");
    polygon_free(&m);
    if (status) fill_slice_free(out);
    return status;
}

void fill_slice_free(fill_slice *slice) {
    free(slice->positions);
    free(slice->square);
    free(slice->triangles);
    free(slice->across);
    *slice = (fill_slice){0};
}

/* ---- places ------------------------------------------------------------------------------------------------------------------- */

_Static_assert(sizeof(fill_uv) == sizeof(polygon_point), "a place in the square is a point of the plane");

/* Where the walk from the hint gets lost among flattened triangles, every triangle is a start. */
static sn_index search(const fill_slice *s, polygon_point at, sn_index hint, double weights[3]) {
    const polygon_view view = {(const polygon_point *)s->square, s->triangle_count, s->triangles, s->across};
    sn_index t = polygon_locate(&view, at, hint, weights);
    for (sn_index start = 0; t == SN_NONE && start < s->triangle_count; start += 7) t = polygon_locate(&view, at, start, weights);
    return t;
}

sn_vec3 fill_slice_at(const fill_slice *slice, fill_uv at, sn_index *hint) {
    double weights[3] = {1.0, 0.0, 0.0};
    const double edge = 1e-9;
    polygon_point inside = {fmin(fmax(at.x, edge), 1.0 - edge), fmin(fmax(at.y, edge), 1.0 - edge)};
    sn_index t = search(slice, inside, *hint, weights);
    *hint = t != SN_NONE ? t : 0;
    const sn_index *v = slice->triangles[*hint];
    sn_vec3 p = sn_scale(slice->positions[v[0]], weights[0]);
    return sn_add_scaled(sn_add_scaled(p, slice->positions[v[1]], weights[1]), slice->positions[v[2]], weights[2]);
}

/* w_k = (tan(alpha_{k-1} / 2) + tan(alpha_k / 2)) / r_k (Floater 2003) in the square, applied to the rim. */
sn_vec3 fill_mean_value_at(const sn_vec3 rim[RIM], int wide, fill_uv at) {
    fill_uv square[RIM];
    double half_tangent[RIM], sum = 0.0;
    fill_square_rim(wide, square);
    const double edge = 1e-6; /* on the boundary the formula divides by zero */
    fill_uv p = {fmin(fmax(at.x, edge), 1.0 - edge), fmin(fmax(at.y, edge), 1.0 - edge)};
    for (int k = 0; k < RIM; k++) {
        fill_uv a = square[k], b = square[(k + 1) % RIM];
        double ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y;
        half_tangent[k] = (sn_length2(ax, ay) * sn_length2(bx, by) - (ax * bx + ay * by)) / (ax * by - ay * bx);
    }
    sn_vec3 out = {0, 0, 0};
    for (int k = 0; k < RIM; k++) {
        double w = (half_tangent[(k + RIM - 1) % RIM] + half_tangent[k]) / sn_length2(square[k].x - p.x, square[k].y - p.y);
        out = sn_add_scaled(out, rim[k], w);
        sum += w;
    }
    return sn_scale(out, 1.0 / sum);
}
