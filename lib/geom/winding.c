/*
 * winding.c -- inside or outside, and closest points on one triangle, without a search structure.
 */
#include "sinew/geom.h"

#include "winding_tree.h"

/* ---- generalised winding number (Jacobson, Kavan, Sorkine-Hornung 2013) ------------------------------------------------- */

/* Solid angle of the triangle (a,b,c) seen from the origin (van Oosterom & Strackee 1983, eq. 8); from a point in its plane 0. */
double sn_solid_angle(sn_vec3 a, sn_vec3 b, sn_vec3 c) {
    double determinant = sn_dot(a, sn_cross(b, c));
    if (determinant == 0.0) return 0.0;
    double la = sn_norm(a), lb = sn_norm(b), lc = sn_norm(c);
    return 2.0 * sn_quick_atan2(determinant, la * lb * lc + sn_dot(a, b) * lc + sn_dot(b, c) * la + sn_dot(c, a) * lb);
}

double sn_winding_number(const sn_mesh *mesh, sn_vec3 point) {
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sum += sn_solid_angle(sn_sub(mesh->positions[v[0]], point), sn_sub(mesh->positions[v[1]], point),
                              sn_sub(mesh->positions[v[2]], point));
    }
    return sum / (4.0 * SN_PI);
}

/* ---- closest point on a triangle ------------------------------------------------------------------------------------------ */

/* A triangle lower than this share of its longest side has no usable normal: it counts as its three sides. */
static const double flat = 1e-12;

typedef struct corner_weights {
    double w[3];
} corner_weights;

/* Parameter in [0,1] of the point of segment a + t ab closest to a + ap; 0 on a segment of no length. */
static double segment_parameter(sn_vec3 ap, sn_vec3 ab) {
    double along = sn_dot(ap, ab), length2 = sn_norm2(ab);
    if (!(along > 0.0)) return 0.0;
    return along < length2 ? along / length2 : 1.0;
}

static sn_vec3 weighted(sn_vec3 a, sn_vec3 ab, sn_vec3 ac, corner_weights k) {
    if (k.w[0] == 1.0) return a; /* exactly the corner: the same bits from every triangle around it */
    return sn_add(a, sn_add_scaled(sn_scale(ab, k.w[1]), ac, k.w[2]));
}

/* The closest of the three sides; ties to the first. */
static corner_weights closest_side(sn_vec3 point, const sn_vec3 corner[3]) {
    corner_weights best = {{1, 0, 0}};
    double best2 = INFINITY;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        sn_vec3 side = sn_sub(corner[j], corner[i]);
        double t = segment_parameter(sn_sub(point, corner[i]), side);
        double distance2 = sn_norm2(sn_sub(point, sn_add_scaled(corner[i], side, t)));
        if (!(distance2 < best2)) continue;
        best2 = distance2;
        best = (corner_weights){{0, 0, 0}};
        best.w[i] = 1.0 - t;
        best.w[j] = t;
    }
    return best;
}

/* Voronoi regions of corners, sides and face (Ericson, Real-Time Collision Detection, 5.1.5); the areas come from the normal, not from
 * differences of products of dot products: on slivers these cancel with the square of the shape, cross products only with its first power.
 */
static corner_weights closest_weights(sn_vec3 point, const sn_vec3 corner[3]) {
    sn_vec3 ab = sn_sub(corner[1], corner[0]), ac = sn_sub(corner[2], corner[0]);
    sn_vec3 ap = sn_sub(point, corner[0]), bp = sn_sub(point, corner[1]), cp = sn_sub(point, corner[2]);
    sn_vec3 normal = sn_cross(ab, ac);
    double longest2 = fmax(sn_norm2(ab), sn_norm2(ac));
    if (!(sn_norm2(normal) > flat * flat * longest2 * longest2)) return closest_side(point, corner);

    double ab_ap = sn_dot(ab, ap), ac_ap = sn_dot(ac, ap);
    if (ab_ap <= 0.0 && ac_ap <= 0.0) return (corner_weights){{1, 0, 0}};
    double ab_bp = sn_dot(ab, bp), ac_bp = sn_dot(ac, bp);
    if (ab_bp >= 0.0 && ac_bp <= ab_bp) return (corner_weights){{0, 1, 0}};
    double ab_cp = sn_dot(ab, cp), ac_cp = sn_dot(ac, cp);
    if (ac_cp >= 0.0 && ab_cp <= ac_cp) return (corner_weights){{0, 0, 1}};

    double area_c = sn_dot(normal, sn_cross(ap, bp));
    if (area_c <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0) {
        double t = ab_ap / (ab_ap - ab_bp);
        return (corner_weights){{1.0 - t, t, 0}};
    }
    double area_b = sn_dot(normal, sn_cross(cp, ap));
    if (area_b <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0) {
        double t = ac_ap / (ac_ap - ac_cp);
        return (corner_weights){{1.0 - t, 0, t}};
    }
    double area_a = sn_dot(normal, sn_cross(bp, cp)), bc_bp = ac_bp - ab_bp, cb_cp = ab_cp - ac_cp;
    if (area_a <= 0.0 && bc_bp >= 0.0 && cb_cp >= 0.0) {
        double t = bc_bp / (bc_bp + cb_cp);
        return (corner_weights){{0, 1.0 - t, t}};
    }
    if (!(area_a > 0.0 && area_b > 0.0 && area_c > 0.0)) return closest_side(point, corner); /* rounding left a gap between regions */
    double sum = area_a + area_b + area_c;
    return (corner_weights){{area_a / sum, area_b / sum, area_c / sum}};
}

sn_vec3 sn_closest_on_triangle(sn_vec3 point, sn_vec3 a, sn_vec3 b, sn_vec3 c, double barycentric[3]) {
    const sn_vec3 corner[3] = {a, b, c};
    corner_weights k = closest_weights(point, corner);
    for (int i = 0; i < 3; i++) {
        if (barycentric != NULL) barycentric[i] = k.w[i];
    }
    if (k.w[1] == 1.0) return b;
    if (k.w[2] == 1.0) return c;
    return weighted(a, sn_sub(b, a), sn_sub(c, a), k);
}
