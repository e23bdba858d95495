/*
 * polygon.c -- faces of more than three corners: a fan where the polygon is convex, ears cut off where it is not.
 *
 * G. H. Meisters, Polygons have ears, American Mathematical Monthly 82 (1975): every simple polygon has two corners that can be cut off.
 * The corners are projected along the polygon's own normal (Newell's sum), so that nearly planar faces are cut as well.
 */
#include "mesh_reader.h"

#include <stdlib.h>

/* Cutting ears takes up to the square of the corners; past this a fan has to do. */
enum { MOST_CORNERS = 512 };

typedef struct point {
    double x, y;
} point;

/* Twice the signed area of (a, b, c). */
static double turn(point a, point b, point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

static sn_index fan_corner(const sn_triangle *fan, sn_index i) { return i < 2 ? fan[0].v[i] : fan[i - 2].v[2]; }

/* Project the corners so that the polygon runs counter-clockwise; returns twice its area, 0 where it has none. */
static double project(const sn_vec3 *positions, const sn_triangle *fan, sn_index count, point *out) {
    sn_vec3 origin = positions[fan_corner(fan, 0)], normal = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < count - 2; i++) {
        const sn_index *v = fan[i].v;
        normal = sn_add(normal, sn_area_vector(positions[v[0]], positions[v[1]], positions[v[2]]));
    }
    double area = sn_norm(normal);
    sn_vec3 axis = sn_normalize(normal);
    sn_vec3 side = fabs(axis.x) < 0.6 ? sn_v3(1, 0, 0) : sn_v3(0, 1, 0);
    sn_vec3 u = sn_normalize(sn_cross(side, axis)), v = sn_cross(axis, u);
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 d = sn_sub(positions[fan_corner(fan, i)], origin);
        out[i] = (point){sn_dot(d, u), sn_dot(d, v)};
    }
    return area;
}

static bool is_convex(const point *p, sn_index count, double least) {
    for (sn_index i = 0; i < count; i++) {
        if (!(turn(p[i], p[(i + 1) % count], p[(i + 2) % count]) > least)) return false;
    }
    return true;
}

static bool same(point a, point b) { return a.x == b.x && a.y == b.y; }

/* Does triangle (a, b, c) hold q, which is none of its corners? */
static bool holds(point a, point b, point c, point q) {
    if (same(q, a) || same(q, b) || same(q, c)) return false;
    return turn(a, b, q) >= 0.0 && turn(b, c, q) >= 0.0 && turn(c, a, q) >= 0.0;
}

/* Is corner `at` of the remaining ring an ear? */
static bool is_ear(const point *p, const sn_index *ring, sn_index left, sn_index at, double least) {
    sn_index before = (at + left - 1) % left, after = (at + 1) % left;
    point a = p[ring[before]], b = p[ring[at]], c = p[ring[after]];
    if (!(turn(a, b, c) > least)) return false;
    for (sn_index i = 0; i < left; i++) {
        if (i != before && i != at && i != after && holds(a, b, c, p[ring[i]])) return false;
    }
    return true;
}

/* Cut `count` corners into count - 2 triangles of corner numbers; false where no ear is left (the polygon crosses itself). */
static bool cut_ears(const point *p, sn_index count, double least, sn_triangle *out) {
    sn_index ring[MOST_CORNERS];
    for (sn_index i = 0; i < count; i++) ring[i] = i;
    sn_index at = 1, missed = 0, made = 0;
    for (sn_index left = count; left > 3;) {
        if (is_ear(p, ring, left, at % left, least)) {
            at %= left;
            out[made++] = (sn_triangle){{ring[(at + left - 1) % left], ring[at], ring[(at + 1) % left]}};
            for (sn_index i = at; i + 1 < left; i++) ring[i] = ring[i + 1];
            left--;
            missed = 0;
        } else {
            at = (at + 1) % left;
            if (++missed > left) return false;
        }
    }
    out[made] = (sn_triangle){{ring[0], ring[1], ring[2]}};
    return turn(p[ring[0]], p[ring[1]], p[ring[2]]) > least;
}

static void cut_polygon(const sn_mesh *mesh, sn_polygon polygon, point *p, sn_triangle *cut) {
    sn_triangle *fan = &mesh->triangles[polygon.first_triangle];
    sn_index count = polygon.corner_count;
    double least = 1e-12 * project(mesh->positions, fan, count, p);
    if (!(least > 0.0) || is_convex(p, count, least) || !cut_ears(p, count, least, cut)) return;
    for (sn_index i = 0; i < count - 2; i++) {
        for (int j = 0; j < 3; j++) cut[i].v[j] = fan_corner(fan, cut[i].v[j]);
    }
    for (sn_index i = 0; i < count - 2; i++) fan[i] = cut[i];
}

void sn_reader_cut_polygons(sn_reader *reader) {
    point corners[MOST_CORNERS];
    sn_triangle cut[MOST_CORNERS];
    for (size_t i = 0; i < reader->polygon_count; i++) {
        if (reader->polygons[i].corner_count <= MOST_CORNERS) cut_polygon(&reader->mesh, reader->polygons[i], corners, cut);
    }
}
