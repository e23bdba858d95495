/* triangulate.c -- ears are cut off, inner points inserted one by one, edges flipped until they are Delaunay (Lawson 1977). */
#include "triangulate.h"

#include <stdlib.h>

/* Twice the area of a, b, c; positive anticlockwise. */
static double turn(polygon_point a, polygon_point b, polygon_point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

static double turn_of(const polygon_mesh *m, sn_index a, sn_index b, sn_index c) { return turn(m->points[a], m->points[b], m->points[c]); }

static sn_status mesh_alloc(polygon_mesh *m, sn_index corners, sn_index inner, sn_error *error) {
    *m = (polygon_mesh){.corners = corners};
    m->points = SN_NEW(polygon_point, corners + inner);
    m->triangles = sn_alloc((size_t)(corners + 2 * inner), sizeof *m->triangles);
    m->across = sn_alloc((size_t)(corners + 2 * inner), sizeof *m->across);
    if (m->points && m->triangles && m->across) return SN_OK;
    polygon_free(m);
    return sn_fail_memory(error, "a slice");
}

void polygon_free(polygon_mesh *m) {
    free(m->points);
    free(m->triangles);
    free(m->across);
    *m = (polygon_mesh){0};
}

/* ---- ears ------------------------------------------------------------------------------------------------------------------ */

/* What is left of the polygon, as a ring; and beyond the edge from each corner to the next one, the triangle already cut off there. */
typedef struct ring {
    sn_index *before, *after, *triangle;
    int *opposite; /* the corner of that triangle opposite to the edge */
} ring;

static bool ring_alloc(ring *r, sn_index count) {
    r->before = SN_NEW(sn_index, count);
    r->after = SN_NEW(sn_index, count);
    r->triangle = SN_NEW(sn_index, count);
    r->opposite = SN_NEW(int, count);
    if (!r->before || !r->after || !r->triangle || !r->opposite) return false;
    for (sn_index i = 0; i < count; i++) {
        r->before[i] = i == 0 ? count - 1 : i - 1;
        r->after[i] = i + 1 == count ? 0 : i + 1;
        r->triangle[i] = SN_NONE;
    }
    return true;
}

static void ring_free(ring *r) {
    free(r->before);
    free(r->after);
    free(r->triangle);
    free(r->opposite);
}

static bool is_ear(const polygon_mesh *m, const ring *r, sn_index i) {
    sn_index p = r->before[i], n = r->after[i];
    if (!(turn_of(m, p, i, n) > 0.0)) return false;
    for (sn_index k = r->after[n]; k != p; k = r->after[k])
        if (turn_of(m, p, i, k) >= 0.0 && turn_of(m, i, n, k) >= 0.0 && turn_of(m, n, p, k) >= 0.0) return false;
    return true;
}

/* The next ear from `start`; where a polygon that crosses itself has none, the corner that turns most. */
static sn_index find_ear(const polygon_mesh *m, const ring *r, sn_index start, sn_index left) {
    sn_index most = start, i = start;
    double widest = -INFINITY;
    for (sn_index k = 0; k < left; k++, i = r->after[i]) {
        if (is_ear(m, r, i)) return i;
        double here = turn_of(m, r->before[i], i, r->after[i]);
        if (here > widest) {
            widest = here;
            most = i;
        }
    }
    return most;
}

static void join(polygon_mesh *m, sn_index triangle, int corner, const ring *r, sn_index edge) {
    sn_index other = r->triangle[edge];
    m->across[triangle][corner] = other;
    if (other != SN_NONE) m->across[other][r->opposite[edge]] = triangle;
}

static void cut_ears(polygon_mesh *m, ring *r) {
    sn_index i = 0;
    for (sn_index left = m->corners; left >= 3; left--) {
        i = left > 3 ? find_ear(m, r, i, left) : i;
        sn_index p = r->before[i], n = r->after[i], t = m->triangle_count++;
        m->triangles[t][0] = p;
        m->triangles[t][1] = i;
        m->triangles[t][2] = n;
        join(m, t, 2, r, p);
        join(m, t, 0, r, i);
        m->across[t][1] = SN_NONE;
        if (left == 3) join(m, t, 1, r, n);
        r->triangle[p] = t;
        r->opposite[p] = 1;
        r->after[p] = n;
        r->before[n] = p;
        i = r->after[n]; /* not the same corner again: fans make needles */
    }
}

/* ---- flips ------------------------------------------------------------------------------------------------------------------- */

static int corner_towards(const polygon_mesh *m, sn_index triangle, sn_index other) {
    for (int c = 0; c < 3; c++)
        if (m->across[triangle][c] == other) return c;
    return -1;
}

/* Is d inside the circle through a, b, c (anticlockwise)? */
static bool in_circle(polygon_point a, polygon_point b, polygon_point c, polygon_point d) {
    double ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
    double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    double value = a2 * (bx * cy - by * cx) - b2 * (ax * cy - ay * cx) + c2 * (ax * by - ay * bx);
    return value > 1e-12 * (a2 + b2 + c2) * (a2 + b2 + c2); /* four points on a circle: leave them */
}

static void set_triangle(polygon_mesh *m, sn_index t, const sn_index v[3], const sn_index across[3]) {
    for (int c = 0; c < 3; c++) {
        m->triangles[t][c] = v[c];
        m->across[t][c] = across[c];
    }
}

static void replace_across(polygon_mesh *m, sn_index triangle, sn_index from, sn_index to) {
    if (triangle == SN_NONE) return;
    int c = corner_towards(m, triangle, from);
    if (c >= 0) m->across[triangle][c] = to;
}

/* Triangle t = (a, b, e) and the one beyond the edge opposite to a, (o, e, b), become (a, b, o) and (a, o, e) where that is Delaunay. */
static bool flip(polygon_mesh *m, sn_index t, int c) {
    sn_index s = m->across[t][c];
    if (s == SN_NONE || s == t) return false;
    int d = corner_towards(m, s, t);
    sn_index a = m->triangles[t][c], b = m->triangles[t][(c + 1) % 3], e = m->triangles[t][(c + 2) % 3], o = m->triangles[s][d];
    if (!(turn_of(m, a, b, o) > 0.0) || !(turn_of(m, a, o, e) > 0.0)) return false;
    if (!in_circle(m->points[a], m->points[b], m->points[e], m->points[o])) return false;
    sn_index n1 = m->across[s][(d + 1) % 3], n2 = m->across[s][(d + 2) % 3];
    sn_index n3 = m->across[t][(c + 1) % 3], n4 = m->across[t][(c + 2) % 3];
    set_triangle(m, t, (sn_index[3]){a, b, o}, (sn_index[3]){n1, s, n4});
    set_triangle(m, s, (sn_index[3]){a, o, e}, (sn_index[3]){n2, n3, t});
    replace_across(m, n1, s, t);
    replace_across(m, n3, t, s);
    return true;
}

enum { MOST_SWEEPS = 60 };

static void flip_all(polygon_mesh *m) {
    bool flipped = true;
    for (int sweep = 0; flipped && sweep < MOST_SWEEPS; sweep++) {
        flipped = false;
        for (sn_index t = 0; t < m->triangle_count; t++)
            for (int c = 0; c < 3; c++) flipped |= flip(m, t, c);
    }
}

/* ---- inner points ------------------------------------------------------------------------------------------------------------ */

sn_index polygon_locate(const polygon_view *view, polygon_point at, sn_index hint, double weights[3]) {
    const polygon_point *points = view->points;
    sn_index t = hint >= 0 && hint < view->triangle_count ? hint : 0;
    for (sn_index step = 0; step < view->triangle_count && t != SN_NONE; step++) {
        const sn_index *v = view->triangles[t];
        double w[3] = {turn(at, points[v[1]], points[v[2]]), turn(points[v[0]], at, points[v[2]]), turn(points[v[0]], points[v[1]], at)};
        double area = turn(points[v[0]], points[v[1]], points[v[2]]);
        int least = w[0] < w[1] ? (w[0] < w[2] ? 0 : 2) : (w[1] < w[2] ? 1 : 2);
        if (area > 0.0 && w[least] >= -1e-12 * area) {
            for (int c = 0; weights && c < 3; c++) weights[c] = w[c] / area;
            return t;
        }
        t = view->across[t][least];
    }
    return SN_NONE;
}

/* One triangle becomes three; flips go outwards from the new vertex, which is corner 0 of every triangle on the stack. */
static void insert(polygon_mesh *m, polygon_point at, sn_index t, sn_index *stack) {
    sn_index v = m->vertex_count++, s = m->triangle_count, r = s + 1;
    const sn_index a = m->triangles[t][0], b = m->triangles[t][1], c = m->triangles[t][2];
    const sn_index na = m->across[t][0], nb = m->across[t][1], nc = m->across[t][2];
    m->triangle_count += 2;
    m->points[v] = at;
    set_triangle(m, t, (sn_index[3]){v, b, c}, (sn_index[3]){na, s, r});
    set_triangle(m, s, (sn_index[3]){v, c, a}, (sn_index[3]){nb, r, t});
    set_triangle(m, r, (sn_index[3]){v, a, b}, (sn_index[3]){nc, t, s});
    replace_across(m, nb, t, s);
    replace_across(m, nc, t, r);
    sn_index top = 0;
    stack[top++] = t;
    stack[top++] = s;
    stack[top++] = r;
    while (top > 0) {
        sn_index here = stack[--top], beyond = m->across[here][0];
        if (!flip(m, here, 0) || top + 2 > m->triangle_count) continue;
        stack[top++] = here;
        stack[top++] = beyond;
    }
}

static bool near_corner(const polygon_mesh *m, polygon_point at, double distance) {
    for (sn_index i = 0; i < m->corners; i++)
        if (sn_length2(m->points[i].x - at.x, m->points[i].y - at.y) < distance) return true;
    return false;
}

static void insert_grid(polygon_mesh *m, double spacing, sn_index most, sn_index *stack) {
    polygon_point low = m->points[0], high = low;
    for (sn_index i = 1; i < m->corners; i++) {
        low = (polygon_point){fmin(low.x, m->points[i].x), fmin(low.y, m->points[i].y)};
        high = (polygon_point){fmax(high.x, m->points[i].x), fmax(high.y, m->points[i].y)};
    }
    double step = spacing * 0.86602540378443865; /* rows of a triangular grid */
    sn_index hint = 0, inserted = 0;
    int row = 0;
    for (double y = low.y + 0.5 * step; y < high.y; y += step, row++)
        for (double x = low.x + (row % 2 ? 0.5 : 0.25) * spacing; x < high.x && inserted < most; x += spacing) {
            polygon_point at = {x, y};
            const polygon_view view = {m->points, m->triangle_count, m->triangles, m->across}; /* it grows */
            sn_index t = polygon_locate(&view, at, hint, NULL);
            if (t == SN_NONE) continue;
            hint = t;
            if (near_corner(m, at, 0.5 * spacing)) continue;
            insert(m, at, t, stack);
            inserted++;
        }
}

sn_status polygon_triangulate(sn_index count, const polygon_point *corners, double spacing, sn_index most_inner, polygon_mesh *out,
                              sn_error *error) {
    ring r = {0};
    sn_status status = mesh_alloc(out, count, most_inner, error);
    if (status) return status;
    sn_index *stack = SN_NEW(sn_index, count + 2 * most_inner + 4);
    if (ring_alloc(&r, count) && stack) {
        for (sn_index i = 0; i < count; i++) out->points[i] = corners[i];
        out->vertex_count = count;
        cut_ears(out, &r);
        flip_all(out);
        if (spacing > 0.0) insert_grid(out, spacing, most_inner, stack);
    } else {
        status = sn_fail_memory(error, "a slice");
    }
    ring_free(&r);
    free(stack);
    if (status) polygon_free(out);
    return status;
}
