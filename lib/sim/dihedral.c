/*
 * dihedral.c -- local shape: the angle between the two triangles at an edge.   [K21] 2.3, methods.md 8.4, numerics.md 6
 *
 * Triangles (a,b,c) and (b,a,d), seen from outside; e = b - a, n1 = (a-c) x (b-c), n2 = (b-d) x (a-d), both outwards;
 *   theta = atan2((n1 x n2).e/|e|, n1.n2),   C = wrap(theta - theta0) in (-pi, pi]
 * (not arccos, which loses the sign and whose gradient is singular when flat). With q = |n|^2:
 *   g_c = -|e| n1/q1                                      g_a =  ((b-c).e/|e|) n1/q1 + ((b-d).e/|e|) n2/q2
 *   g_d = -|e| n2/q2                                      g_b = -((a-c).e/|e|) n1/q1 - ((a-d).e/|e|) n2/q2
 */
#include "rows.h"

#include <float.h>
#include <stdlib.h>

/* atan(t) for |t| <= 0.66 to 2e-16: t + t z P(z) / Q(z), z = t^2; the coefficients are those of Moshier's Cephes library. */
static inline double arc_tangent(double t) {
    double z = t * t;
    double p = -6.485021904942025371773e1 +
               z * (-1.228866684490136173410e2 +
                    z * (-7.500855792314704667340e1 + z * (-1.615753718733365076637e1 + z * -8.750608600031904122785e-1)));
    double q = 1.945506571482613964425e2 +
               z * (4.853903996359136964868e2 +
                    z * (4.328810604912902668951e2 + z * (1.650270098316988542046e2 + z * (2.485846490142306297962e1 + z))));
    return t + t * (z * p / q);
}

/* The angle in [-pi, pi] whose sine and cosine are in the ratio sine : cosine, not both 0. Ours, not the C library's atan2, whose last bit
 * differs between processors; to 4e-16. */
static inline double angle_of(double sine, double cosine) {
    static const double TAN_PI_8 = 0.41421356237309504880;
    double s = fabs(sine), c = fabs(cosine), low = s < c ? s : c, high = s < c ? c : s;
    bool upper = low > TAN_PI_8 * high; /* atan(low / high) = pi/4 + atan((low - high) / (low + high)) */
    double angle = arc_tangent((upper ? low - high : low) / (upper ? low + high : high));
    if (upper) angle += SN_PI / 4.0;
    if (s > c) angle = SN_PI / 2.0 - angle;
    if (cosine < 0.0) angle = SN_PI - angle;
    return copysign(angle, sine);
}

static inline double wrap(double angle) {
    if (angle > SN_PI) return angle - 2.0 * SN_PI;
    if (angle <= -SN_PI) return angle + 2.0 * SN_PI;
    return angle;
}

/* Value and gradients at points a, b, c, d; false where an area or the edge vanishes, or is not finite. */
static inline bool hinge(const sn_vec3 p[4], double rest, double *value, sn_vec3 g[4]) {
    sn_vec3 e = sn_sub(p[1], p[0]);
    sn_vec3 ac = sn_sub(p[0], p[2]), bc = sn_sub(p[1], p[2]), ad = sn_sub(p[0], p[3]), bd = sn_sub(p[1], p[3]);
    sn_vec3 n1 = sn_cross(ac, bc), n2 = sn_cross(bd, ad);
    double e2 = sn_norm2(e), q1 = sn_norm2(n1), q2 = sn_norm2(n2);
    double least = SN_HINGE_GUARD * e2 * e2;
    if (!(e2 >= SN_EDGE_GUARD && q1 > least && q2 > least && q1 <= DBL_MAX && q2 <= DBL_MAX)) return false;
    double length = sqrt(e2);
    sn_vec3 unit = sn_scale(e, 1.0 / length), m1 = sn_scale(n1, 1.0 / q1), m2 = sn_scale(n2, 1.0 / q2);
    *value = wrap(angle_of(sn_dot(sn_cross(n1, n2), unit), sn_dot(n1, n2)) - rest);
    g[0] = sn_add_scaled(sn_scale(m1, sn_dot(bc, unit)), m2, sn_dot(bd, unit));
    g[1] = sn_neg(sn_add_scaled(sn_scale(m1, sn_dot(ac, unit)), m2, sn_dot(ad, unit)));
    g[2] = sn_scale(m1, -length);
    g[3] = sn_scale(m2, -length);
    return true;
}

bool sn_hinge_constraint(const sn_vec3 p[4], double rest, double *value, sn_vec3 gradients[4]) { return hinge(p, rest, value, gradients); }

/* ---- building the rows ---------------------------------------------------------------------------------------------------- */

/* Does triangle t run from a to b? */
static bool runs_along(const sn_triangle *t, sn_index a, sn_index b) {
    for (int i = 0; i < 3; i++)
        if (t->v[i] == a && t->v[(i + 1) % 3] == b) return true;
    return false;
}

/* The row of an edge with two triangles; false where both triangles run the same way along it: they have no common outside. */
static bool hinge_points(const sn_model_muscle *m, const sn_edge *edge, sn_hinge_row *row) {
    sn_index a = edge->v[0], b = edge->v[1];
    bool first = runs_along(&m->triangles[edge->triangle[0]], a, b), second = runs_along(&m->triangles[edge->triangle[1]], a, b);
    if (first == second) return false;
    *row = (sn_hinge_row){{a, b, edge->opposite[first ? 0 : 1], edge->opposite[first ? 1 : 0]}};
    return true;
}

static void add_hinge(const sn_build *build, const sn_edge *edge) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[SN_ROWS_DIHEDRAL];
    sn_hinge_row row;
    if (edge->triangle_count != 2) return;
    if (!hinge_points(m, edge, &row)) {
        group->degenerate++;
        return;
    }
    sn_vec3 p[4], gradients[4];
    double inverse_mass = 0.0, angle;
    for (int i = 0; i < 4; i++) {
        p[i] = m->rest[row.point[i]];
        inverse_mass += m->inverse_mass[row.point[i]];
    }
    if (!hinge(p, 0.0, &angle, gradients)) {
        group->degenerate++;
    } else if (inverse_mass == 0.0) {
        group->kinematic++;
    } else {
        m->hinges[m->hinge_count] = row;
        m->hinge_angles[m->hinge_count++] = angle;
    }
}

sn_status sn_hinge_build(const sn_build *build, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_plan_group *group = &build->plan->groups[SN_ROWS_DIHEDRAL];
    if (group->reason != SN_RUNS) return SN_OK;
    m->hinges = SN_NEW(sn_hinge_row, build->topology->edge_count);
    m->hinge_angles = SN_NEW(double, build->topology->edge_count);
    if (m->hinges == NULL || m->hinge_angles == NULL) return sn_fail_memory(error, "dihedral rows");
    for (sn_index i = 0; i < build->topology->edge_count; i++) add_hinge(build, &build->topology->edges[i]);
    group->rows = m->hinge_count;
    return SN_OK;
}

/* ---- projecting ----------------------------------------------------------------------------------------------------------- */

static inline void move(sn_point *point, sn_vec3 gradient, double change) {
    double scale = point->w * change;
    point->x += scale * gradient.x, point->y += scale * gradient.y, point->z += scale * gradient.z;
}

static inline void load(const sn_muscle_state *s, const sn_hinge_row *row, sn_vec3 p[4]) {
    for (int i = 0; i < 4; i++) p[i] = sn_point_position(&s->points[row->point[i]]);
}

void sn_hinge_sweep(const sn_model_muscle *m, sn_muscle_state *s, double compliance, bool first) {
    int64_t skipped = 0, clamped = 0;
    for (sn_index r = 0; r < m->hinge_count; r++) {
        const sn_hinge_row *row = &m->hinges[r];
        double lambda = first ? 0.0 : s->hinge_lambda[r], c;
        sn_vec3 p[4], g[4];
        load(s, row, p);
        s->hinge_lambda[r] = lambda;
        if (!hinge(p, m->hinge_angles[r], &c, g)) {
            skipped++;
            continue;
        }
        if (fabs(c) > SN_HINGE_CLAMP) {
            c = copysign(SN_HINGE_CLAMP, c);
            clamped++;
        }
        double sum = 0.0;
        for (int i = 0; i < 4; i++) sum += s->points[row->point[i]].w * sn_norm2(g[i]);
        double change = (-c - compliance * lambda) / (sum + compliance);
        s->hinge_lambda[r] = lambda + change;
        for (int i = 0; i < 4; i++) move(&s->points[row->point[i]], g[i], change);
    }
    s->statistics.skipped_hinges += skipped;
    s->statistics.clamped_hinges += clamped;
}

sn_residual sn_hinge_residual(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_residual residual = {.worst = SN_NONE};
    double sum = 0.0;
    for (sn_index r = 0; r < m->hinge_count; r++) {
        sn_vec3 p[4], g[4];
        double c = 0.0;
        load(s, &m->hinges[r], p);
        if (!hinge(p, m->hinge_angles[r], &c, g)) continue;
        sum += c * c;
        if (residual.worst == SN_NONE || fabs(c) > residual.max) residual.max = fabs(c), residual.worst = r;
    }
    if (m->hinge_count > 0) residual.rms = sqrt(sum / m->hinge_count);
    return residual;
}
