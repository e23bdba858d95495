/*
 * rest_rows.c -- the rows of the constraint table at the rest shape or at any other.   numerics.md 2
 *
 * A spring between two points bounds its Hessian by k (e_i - e_j)(e_i - e_j)T on each axis; a hinge its by k_b K KT with the rest weights
 *   K_c = |e|/|n1|, K_d = |e|/|n2|, K_a = -(b-c).e/|n1| - (b-d).e/|n2|, K_b = (a-c).e/|n1| + (a-d).e/|n2|   (e a unit vector here)
 */
#include "rest_rows.h"

static bool visit_distances(const sn_model_muscle *m, const sn_vec3 *at, bool (*visit)(void *, const sn_rest_row *), void *user) {
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++) {
        double factor = kind == SN_ROWS_MESH ? 1.0 : m->source->stiffness_internal;
        for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
            const sn_index *point = m->distances[r].point;
            sn_vec3 along = sn_normalize(sn_sub(at[point[0]], at[point[1]]));
            sn_rest_row row = {.count = 2, .point = point, .weight = {1.0, -1.0}, .gradient = {along, sn_neg(along)}};
            row.scale = m->distance_softness != NULL ? factor / m->distance_softness[r] : factor;
            if (!visit(user, &row)) return false;
        }
    }
    return true;
}

/* The gradients of sn_hinge_constraint, bit for bit, without its angle: the matrices need none. */
static bool hinge_gradients(const sn_vec3 p[4], sn_vec3 gradient[4]) {
    sn_vec3 e = sn_sub(p[1], p[0]), ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
    sn_vec3 n1 = sn_cross(ac, bc), n2 = sn_cross(bd, ad);
    double e2 = sn_norm2(e), q1 = sn_norm2(n1), q2 = sn_norm2(n2), least = SN_HINGE_GUARD * e2 * e2, length = sqrt(e2);
    if (e2 < SN_EDGE_GUARD || !(q1 > least && q2 > least) || !isfinite(q1) || !isfinite(q2)) return false;
    sn_vec3 unit = sn_scale(e, 1.0 / length), m1 = sn_scale(n1, 1.0 / q1), m2 = sn_scale(n2, 1.0 / q2);
    gradient[0] = sn_add(sn_scale(m1, sn_dot(bc, unit)), sn_scale(m2, sn_dot(bd, unit)));
    gradient[1] = sn_add(sn_scale(m1, -sn_dot(ac, unit)), sn_scale(m2, -sn_dot(ad, unit)));
    gradient[2] = sn_scale(m1, -length);
    gradient[3] = sn_scale(m2, -length);
    return true;
}

/* The weights of a hinge at rest; the rows were built from hinges that have them. */
static void hinge_weights(const sn_vec3 p[4], double weight[4]) {
    sn_vec3 e = sn_sub(p[1], p[0]), ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
    double length = sn_norm(e), n1 = sn_norm(sn_cross(ac, bc)), n2 = sn_norm(sn_cross(bd, ad));
    sn_vec3 unit = sn_scale(e, 1.0 / length);
    weight[0] = -sn_dot(bc, unit) / n1 - sn_dot(bd, unit) / n2;
    weight[1] = sn_dot(ac, unit) / n1 + sn_dot(ad, unit) / n2;
    weight[2] = length / n1;
    weight[3] = length / n2;
}

static bool visit_hinges(const sn_model_muscle *m, const sn_vec3 *at, bool (*visit)(void *, const sn_rest_row *), void *user) {
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_rest_row row = {.count = 4, .point = m->hinges[r].point, .scale = m->source->stiffness_dihedral};
        sn_vec3 p[4];
        for (int i = 0; i < 4; i++) p[i] = at[row.point[i]];
        if (!hinge_gradients(p, row.gradient)) continue;
        hinge_weights(p, row.weight);
        if (m->hinge_softness != NULL) row.scale /= m->hinge_softness[r];
        if (!visit(user, &row)) return false;
    }
    return true;
}

/* A triangle of the membrane at rest: its strains along and across the fibre, its shear and its dilation for the matrix that knows
 * directions, 2 mu times the cotangent Laplacian for the scalar one. */
static bool visit_membrane(const sn_model_muscle *m, const sn_vec3 *at, sn_index r, bool (*visit)(void *, const sn_rest_row *),
                           void *user) {
    const sn_index *v = m->membrane_points[r].point;
    sn_vec3 p[3], b[3], normal;
    for (int i = 0; i < 3; i++) p[i] = at[v[i]];
    normal = sn_area_vector(p[0], p[1], p[2]);
    double twice = sn_norm(normal), mu = sqrt(3.0) / (4.0 * m->membranes[r].softness), area = 0.5 * twice;
    for (int i = 0; i < 3; i++) b[i] = sn_scale(sn_cross(normal, sn_sub(p[(i + 2) % 3], p[(i + 1) % 3])), 1.0 / (twice * twice));
    sn_vec3 t1 = sn_normalize(sn_sub(p[1], p[0])), t2 = sn_cross(sn_normalize(normal), t1);
    sn_rest_row strain[4];
    for (int k = 0; k < 4; k++) strain[k] = (sn_rest_row){.count = 3, .point = v, .scale = (k == 3 ? 1.0 : 2.0) * mu * area};
    for (int i = 0; i < 3; i++) {
        double b1 = sn_dot(b[i], t1), b2 = sn_dot(b[i], t2);
        strain[0].gradient[i] = sn_scale(t1, b1);
        strain[1].gradient[i] = sn_scale(t2, b2);
        strain[2].gradient[i] = sn_scale(sn_add(sn_scale(t2, b1), sn_scale(t1, b2)), sqrt(0.5));
        strain[3].gradient[i] = b[i];
    }
    bool going = true;
    for (int k = 0; k < 4 && going; k++) going = visit(user, &strain[k]);
    for (int i = 0; i < 3 && going; i++) {
        double cotangent = -sn_dot(sn_sub(p[(i + 1) % 3], p[i]), sn_sub(p[i], p[(i + 2) % 3])) / twice; /* of the corner at p[i] */
        const sn_index edge[2] = {v[(i + 1) % 3], v[(i + 2) % 3]};
        const sn_rest_row row = {.count = 2, .point = edge, .weight = {1.0, -1.0}, .scale = mu * cotangent};
        going = visit(user, &row);
    }
    return going;
}

static bool visit_membranes(const sn_model_muscle *m, const sn_vec3 *at, bool (*visit)(void *, const sn_rest_row *), void *user) {
    bool going = true;
    for (sn_index r = 0; r < m->membrane_count && going; r++) going = visit_membrane(m, at, r, visit, user);
    return going;
}

bool sn_rows_at(const sn_model_muscle *m, const sn_vec3 *positions, bool (*visit)(void *user, const sn_rest_row *row), void *user) {
    return visit_distances(m, positions, visit, user) && visit_membranes(m, positions, visit, user) &&
           visit_hinges(m, positions, visit, user);
}
