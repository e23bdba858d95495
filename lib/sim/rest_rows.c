/*
 * rest_rows.c -- the rows of the constraint table at the rest shape.   numerics.md 2
 *
 * A spring between two points bounds its Hessian by k (e_i - e_j)(e_i - e_j)T on each axis; a hinge its by k_b K KT with the rest weights
 *   K_c = |e|/|n1|, K_d = |e|/|n2|, K_a = -(b-c).e/|n1| - (b-d).e/|n2|, K_b = (a-c).e/|n1| + (a-d).e/|n2|   (e a unit vector here)
 */
#include "rest_rows.h"

static bool visit_distances(const sn_model_muscle *m, bool (*visit)(void *, const sn_rest_row *), void *user) {
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++) {
        double factor = kind == SN_ROWS_MESH ? 1.0 : m->source->stiffness_internal;
        for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
            const sn_index *point = m->distances[r].point;
            sn_vec3 along = sn_normalize(sn_sub(m->rest[point[0]], m->rest[point[1]]));
            sn_rest_row row = {.count = 2, .point = point, .weight = {1.0, -1.0}, .gradient = {along, sn_neg(along)}};
            row.scale = m->distance_softness != NULL ? factor / m->distance_softness[r] : factor;
            if (!visit(user, &row)) return false;
        }
    }
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

static bool visit_hinges(const sn_model_muscle *m, bool (*visit)(void *, const sn_rest_row *), void *user) {
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_rest_row row = {.count = 4, .point = m->hinges[r].point, .scale = m->source->stiffness_dihedral};
        sn_vec3 p[4];
        double angle;
        for (int i = 0; i < 4; i++) p[i] = m->rest[row.point[i]];
        if (!sn_hinge_constraint(p, 0.0, &angle, row.gradient)) continue;
        hinge_weights(p, row.weight);
        if (m->hinge_softness != NULL) row.scale /= m->hinge_softness[r];
        if (!visit(user, &row)) return false;
    }
    return true;
}

bool sn_rest_rows(const sn_model_muscle *m, bool (*visit)(void *user, const sn_rest_row *row), void *user) {
    return visit_distances(m, visit, user) && visit_hinges(m, visit, user);
}
