/*
 * implicit_euler.c -- an independent reference for the solvers: implicit Euler of the same energies by Newton's method. Usage:
 * implicit_euler
 *
 * Nothing of lib/sim computes here: energies and gradients are written anew from numerics.md 2, 6 and 9 and methods.md 8, one element at a
 * time; Hessians are differences of those gradients; the whole matrix is dense and factored by a Cholesky of its own, shifted where it is
 * not positive definite; Armijo's rule. From the model come the rows and the factors on their stiffness.
 *
 *   Phi(x) = sum m |x - y|^2 / (2 h^2) + sum k_i/2 (l - sigma)^2 + sum b_i/2 wrap(theta - theta0)^2 + k_V/2 (V - g V0)^2
 *            + sum -k A0 (J - 1)^2 ln J  (J < 1),       y = x + h (u + (v - u) e^(-c h)) + h^2 g
 *
 * u is the velocity of the muscle's bones: of the rigid motion that fits the attached points best.
 *
 * Checks: its gradients against differences of its energies, and those of the library against its own; converged `qn` after several steps
 * against it; converged `xpbd` down to its floor, which falls with the square of a step's motion. Prints a line each, then "N passed, N
 * failed".
 */
#include "../unit/sim_inside.h"

#include <stdio.h>

static int passed, failed;

static void verdict(const char *name, bool good, const char *figures) {
    printf("%-66s %s  %s\n", name, good ? "passed" : "FAILED", figures);
    fflush(stdout);
    if (good)
        passed++;
    else
        failed++;
}

/* ---- elements ----------------------------------------------------------------------------------------------------------------- */

typedef enum kind { SPRING, HINGE, BARRIER, KINDS } kind;
static const char *const KIND_NAMES[KINDS] = {"distance", "dihedral", "area barrier"};

typedef struct element {
    kind kind;
    int count; /* of its points */
    sn_index point[4];
    double k, rest; /* stiffness; sigma (m), theta0 (rad) or A0 (m^2) */
} element;

/* k/2 (|x0 - x1| - sigma)^2 */
static double spring(const element *e, const sn_vec3 *x, sn_vec3 *g) {
    sn_vec3 d = sn_sub(x[0], x[1]);
    double length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z), c = length - e->rest;
    g[0] = sn_scale(d, e->k * c / length);
    g[1] = sn_scale(d, -e->k * c / length);
    return 0.5 * e->k * c * c;
}

/* b/2 wrap(theta - theta0)^2, theta = atan2((n1 x n2).e/|e|, n1.n2): numerics.md 6 */
static double hinge(const element *e, const sn_vec3 *x, sn_vec3 *g) {
    sn_vec3 a = x[0], b = x[1], c = x[2], d = x[3], ba = sn_sub(b, a);
    double length = sn_norm(ba);
    sn_vec3 unit = sn_scale(ba, 1.0 / length), n1 = sn_cross(sn_sub(a, c), sn_sub(b, c)), n2 = sn_cross(sn_sub(b, d), sn_sub(a, d));
    double theta = atan2(sn_dot(sn_cross(n1, n2), unit), sn_dot(n1, n2)), angle = remainder(theta - e->rest, 2.0 * SN_PI);
    sn_vec3 m1 = sn_scale(n1, 1.0 / sn_dot(n1, n1)), m2 = sn_scale(n2, 1.0 / sn_dot(n2, n2));
    double s = e->k * angle;
    g[0] = sn_scale(sn_add(sn_scale(m1, sn_dot(sn_sub(b, c), unit)), sn_scale(m2, sn_dot(sn_sub(b, d), unit))), s);
    g[1] = sn_scale(sn_add(sn_scale(m1, sn_dot(sn_sub(a, c), unit)), sn_scale(m2, sn_dot(sn_sub(a, d), unit))), -s);
    g[2] = sn_scale(m1, -s * length);
    g[3] = sn_scale(m2, -s * length);
    return 0.5 * e->k * angle * angle;
}

/* -k A0 (J - 1)^2 ln J below J = 1, J = area / A0: numerics.md 9 */
static double barrier(const element *e, const sn_vec3 *x, sn_vec3 *g) {
    sn_vec3 p = sn_sub(x[1], x[0]), q = sn_sub(x[2], x[0]), n = sn_cross(p, q);
    double size = sn_norm(n), j = 0.5 * size / e->rest;
    g[0] = g[1] = g[2] = sn_v3(0, 0, 0);
    if (j >= 1.0) return 0.0;
    double slope = -e->k * e->rest * (2.0 * (j - 1.0) * log(j) + (j - 1.0) * (j - 1.0) / j), push = slope / (2.0 * e->rest * size);
    g[1] = sn_scale(sn_cross(q, n), push); /* dE/dJ dJ/dx */
    g[2] = sn_scale(sn_cross(n, p), push);
    g[0] = sn_neg(sn_add(g[1], g[2]));
    return -e->k * e->rest * (j - 1.0) * (j - 1.0) * log(j);
}

static double element_energy(const element *e, const sn_vec3 *x, sn_vec3 *g) {
    static double (*const ENERGIES[KINDS])(const element *, const sn_vec3 *, sn_vec3 *) = {spring, hinge, barrier};
    return ENERGIES[e->kind](e, x, g);
}

/* ---- the problem: one muscle and what one step minimises ---------------------------------------------------------------------------- */

typedef struct problem {
    const sn_scene *scene;
    const sn_model_muscle *m; /* rows, masses, triangles; no number of it changes */
    sn_index n, element_count, free_count;
    element *elements;
    sn_index *free_of;  /* (n) SN_NONE = carried */
    sn_vec3 *x, *v, *y; /* (n) */
    double h, volume_k, volume_goal, volume0;
    bool barriers;
} problem;

static sn_vec3 axis_at(const problem *p, sn_index point) {
    const sn_muscle *rig = &p->m->source->rig;
    if (point >= p->m->vertex_count) return rig->structure.axes[point - p->m->vertex_count];
    return rig->fibers.directions != NULL ? rig->fibers.directions[point] : sn_v3(0, 0, 0);
}

/* methods.md 8.1: |c e_along + e_across| (projected), |c e_along + sqrt(g/c) e_across| (isochoric), c = (1 - a) / (1 - a0) */
static double goal_length(const problem *p, sn_index i, sn_index j, double c, double g) {
    sn_vec3 e = sn_sub(p->m->rest[i], p->m->rest[j]), f1 = axis_at(p, i), f2 = axis_at(p, j);
    sn_vec3 f = sn_add(f1, sn_dot(f1, f2) < 0.0 ? sn_neg(f2) : f2);
    double size = sn_norm(f);
    f = size > 0.0 ? sn_scale(f, 1.0 / size) : f1;
    sn_vec3 along = sn_scale(f, sn_dot(e, f)), across = sn_sub(e, along);
    double wider = p->m->source->law == SN_LAW_ISOCHORIC ? sqrt(g / c) : 1.0;
    return sn_norm(sn_add(sn_scale(along, c), sn_scale(across, wider)));
}

/* Between the two stiffnesses in log scale; between the knots 0 and 1 of the volume ratio in a straight line (a curve of two knots). */
static double stiffness_at(const sn_scene_muscle *m, double activation) {
    return m->stiffness_relaxed * pow(m->stiffness_active / m->stiffness_relaxed, activation);
}
static double ratio_at(const sn_knots *knots, double activation) {
    return knots->count == 0 ? 1.0 : knots->y[0] + (knots->y[1] - knots->y[0]) * (activation - knots->x[0]) / (knots->x[1] - knots->x[0]);
}

static double linear_key(const sn_channel *channel, double time) {
    if (channel->count == 0) return channel->constant;
    double t = (time - channel->times[0]) / (channel->times[1] - channel->times[0]);
    return channel->values[0] + (channel->values[1] - channel->values[0]) * fmin(fmax(t, 0.0), 1.0);
}

/* Elements for the inputs at `time`. */
static void make_elements(problem *p, double time) {
    const sn_model_muscle *m = p->m;
    const sn_scene_muscle *source = m->source;
    double activation = linear_key(&source->activation, time), k = stiffness_at(source, activation);
    double c = (1.0 - source->contraction * activation) / (1.0 - source->contraction * source->rest_activation);
    p->volume_goal = ratio_at(&source->volume_ratio, activation) / ratio_at(&source->volume_ratio, source->rest_activation);
    p->volume_k = m->keeps_volume ? source->stiffness_volume * k / p->volume0 : 0.0;
    element *e = p->elements;
    for (sn_index r = 0; r < m->distance_start[SN_DISTANCE_KINDS]; r++) {
        const sn_index *q = m->distances[r].point;
        double factor = r < m->distance_start[SN_ROWS_MESH] ? source->stiffness_internal : 1.0;
        if (m->distance_softness != NULL) factor /= m->distance_softness[r];
        *e++ = (element){SPRING, 2, {q[0], q[1]}, k * factor, goal_length(p, q[0], q[1], c, p->volume_goal)};
    }
    for (sn_index r = 0; r < m->hinge_count; r++) {
        const sn_index *q = m->hinges[r].point;
        double factor = source->stiffness_dihedral / (m->hinge_softness != NULL ? m->hinge_softness[r] : 1.0);
        *e++ = (element){HINGE, 4, {q[0], q[1], q[2], q[3]}, k * factor, m->hinge_angles[r]};
    }
    for (sn_index r = 0; p->barriers && r < m->area_count; r++) {
        const sn_index *q = m->areas[r].point;
        double area = 0.5 * sn_norm(sn_cross(sn_sub(m->rest[q[1]], m->rest[q[0]]), sn_sub(m->rest[q[2]], m->rest[q[0]])));
        *e++ = (element){BARRIER, 3, {q[0], q[1], q[2]}, k, area};
    }
    p->element_count = (sn_index)(e - p->elements);
}

static double volume(const problem *p, const sn_vec3 *x, sn_vec3 *g) {
    double sum = 0.0;
    for (sn_index i = 0; i < p->n; i++) g[i] = sn_v3(0, 0, 0);
    for (sn_index t = 0; t < p->m->triangle_count; t++) {
        const sn_index *v = p->m->triangles[t].v;
        sn_vec3 a = x[v[0]], b = x[v[1]], c = x[v[2]];
        sum += sn_dot(a, sn_cross(b, c)) / 6.0;
        g[v[0]] = sn_add_scaled(g[v[0]], sn_cross(b, c), 1.0 / 6.0);
        g[v[1]] = sn_add_scaled(g[v[1]], sn_cross(c, a), 1.0 / 6.0);
        g[v[2]] = sn_add_scaled(g[v[2]], sn_cross(a, b), 1.0 / 6.0);
    }
    return sum;
}

/* Phi at x and its gradient; volume_gradient (n) is left at dV/dx, *over at k_V (V - goal). */
static double objective(const problem *p, const sn_vec3 *x, sn_vec3 *g, sn_vec3 *volume_gradient, double *over) {
    double energy = 0.0, c = volume(p, x, volume_gradient) - p->volume_goal * p->volume0;
    *over = p->volume_k * c;
    energy += 0.5 * p->volume_k * c * c;
    for (sn_index i = 0; i < p->n; i++) {
        g[i] = sn_scale(volume_gradient[i], *over);
        if (p->free_of[i] == SN_NONE) continue;
        double mass = 1.0 / (p->m->inverse_mass[i] * p->h * p->h);
        sn_vec3 away = sn_sub(x[i], p->y[i]);
        energy += 0.5 * mass * sn_dot(away, away);
        g[i] = sn_add_scaled(g[i], away, mass);
    }
    for (sn_index r = 0; r < p->element_count; r++) {
        const element *e = &p->elements[r];
        sn_vec3 at[4], part[4];
        for (int i = 0; i < e->count; i++) at[i] = x[e->point[i]];
        energy += element_energy(e, at, part);
        for (int i = 0; i < e->count; i++) g[e->point[i]] = sn_add(g[e->point[i]], part[i]);
    }
    for (sn_index i = 0; i < p->n; i++)
        if (p->free_of[i] == SN_NONE) g[i] = sn_v3(0, 0, 0);
    return energy;
}

/* ---- the Hessian --------------------------------------------------------------------------------------------------------- */

static double *coordinate(sn_vec3 *v, int c) { return c == 0 ? &v->x : c == 1 ? &v->y : &v->z; }

/* The lower triangle of a dense matrix of 3 x free unknowns. */
static void add_to(const problem *p, double *matrix, sn_index i, int ci, sn_index j, int cj, double value) {
    if (p->free_of[i] == SN_NONE || p->free_of[j] == SN_NONE) return;
    size_t n = 3 * (size_t)p->free_count, row = 3 * (size_t)p->free_of[i] + (size_t)ci, column = 3 * (size_t)p->free_of[j] + (size_t)cj;
    if (column <= row) matrix[row * n + column] += value;
}

/* Central differences of the element's own gradient. */
static void add_element(const problem *p, double *matrix, const sn_vec3 *x, const element *e) {
    const double step = 1e-6 * p->m->mean_edge;
    sn_vec3 at[4], high[4], low[4];
    for (int i = 0; i < e->count; i++) at[i] = x[e->point[i]];
    for (int j = 0; j < e->count; j++)
        for (int cj = 0; cj < 3; cj++) {
            double *q = coordinate(&at[j], cj), kept = *q;
            *q = kept + step, element_energy(e, at, high);
            *q = kept - step, element_energy(e, at, low);
            *q = kept;
            for (int i = 0; i < e->count; i++)
                for (int ci = 0; ci < 3; ci++)
                    add_to(p, matrix, e->point[i], ci, e->point[j], cj,
                           (*coordinate(&high[i], ci) - *coordinate(&low[i], ci)) / (2.0 * step));
        }
}

/* over times the second derivative of V: d2V / da db = -[c]x / 6 and so on round the triangle. */
static void add_volume(const problem *p, double *matrix, const sn_vec3 *x, const sn_vec3 *g, double over) {
    for (sn_index i = 0; i < p->m->vertex_count; i++)
        for (sn_index j = 0; j < p->m->vertex_count; j++)
            for (int ci = 0; ci < 3; ci++)
                for (int cj = 0; cj < 3; cj++) {
                    sn_vec3 a = g[i], b = g[j];
                    add_to(p, matrix, i, ci, j, cj, p->volume_k * *coordinate(&a, ci) * *coordinate(&b, cj));
                }
    for (sn_index t = 0; t < p->m->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const sn_index *v = p->m->triangles[t].v;
            sn_index i = v[k], j = v[(k + 1) % 3];
            sn_vec3 c = sn_scale(x[v[(k + 2) % 3]], over / 6.0);
            const double cross[3][3] = {{0, c.z, -c.y}, {-c.z, 0, c.x}, {c.y, -c.x, 0}}; /* d(b x c)/db */
            for (int ci = 0; ci < 3; ci++)
                for (int cj = 0; cj < 3; cj++) {
                    add_to(p, matrix, i, ci, j, cj, cross[ci][cj]);
                    add_to(p, matrix, j, cj, i, ci, cross[ci][cj]);
                }
        }
}

static void make_hessian(const problem *p, double *matrix, const sn_vec3 *x, const sn_vec3 *volume_gradient, double over) {
    size_t n = 3 * (size_t)p->free_count;
    memset(matrix, 0, n * n * sizeof *matrix);
    for (sn_index i = 0; i < p->n; i++)
        for (int c = 0; c < 3; c++)
            add_to(p, matrix, i, c, i, c, p->free_of[i] == SN_NONE ? 0.0 : 1.0 / (p->m->inverse_mass[i] * p->h * p->h));
    for (sn_index r = 0; r < p->element_count; r++) add_element(p, matrix, x, &p->elements[r]);
    if (p->volume_k > 0.0) add_volume(p, matrix, x, volume_gradient, over);
}

/* L LT of the lower triangle, in place; false: not positive definite. */
static bool cholesky(double *a, size_t n) {
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            const double *p = a + i * n, *q = a + j * n;
            double s[4] = {0, 0, 0, 0};
            size_t k = 0;
            for (; k + 4 <= j; k += 4)
                for (size_t l = 0; l < 4; l++) s[l] += p[k + l] * q[k + l];
            for (; k < j; k++) s[0] += p[k] * q[k];
            double left = p[j] - (s[0] + s[1] + s[2] + s[3]);
            if (i == j && !(left > 0.0)) return false;
            a[i * n + j] = i == j ? sqrt(left) : left / q[j];
        }
    }
    return true;
}

static void solve(const double *a, size_t n, double *b) {
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++) b[i] -= a[i * n + k] * b[k];
        b[i] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        b[i] /= a[i * n + i];
        for (size_t k = 0; k < i; k++) b[k] -= a[i * n + k] * b[i];
    }
}

/* ---- Newton -------------------------------------------------------------------------------------------------------------- */

/* The matrix, shifted as far as it takes to be positive definite, factored. */
static void factor(double *matrix, double *kept, size_t n) {
    double largest = 0.0, shift = 0.0;
    for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs(matrix[i * n + i]));
    memcpy(kept, matrix, n * n * sizeof *kept);
    while (!cholesky(matrix, n)) {
        shift = shift > 0.0 ? 4.0 * shift : 1e-6 * largest;
        memcpy(matrix, kept, n * n * sizeof *kept);
        for (size_t i = 0; i < n; i++) matrix[i * n + i] += shift;
    }
}

/* From p->x, whose carried points are in place, to the minimum of Phi. Returns the last full step over L. */
static double minimise(problem *p) {
    size_t n = 3 * (size_t)p->free_count, bytes = (size_t)p->n * sizeof(sn_vec3);
    double *matrix = SN_NEW(double, n *n), *kept = SN_NEW(double, n *n), *d = SN_NEW(double, n), over, longest = INFINITY, last = INFINITY;
    sn_vec3 *g = SN_NEW(sn_vec3, p->n), *trial = SN_NEW(sn_vec3, p->n), *gv = SN_NEW(sn_vec3, p->n);
    /* to rounding: until steps that are small already shrink no further */
    for (int iteration = 0; iteration < 100 && longest > 1e-12 && !(longest < 1e-9 && longest > 0.1 * last); iteration++) {
        last = longest;
        double energy = objective(p, p->x, g, gv, &over), slope = 0.0, length = 1.0;
        make_hessian(p, matrix, p->x, gv, over);
        factor(matrix, kept, n);
        for (sn_index i = 0; i < p->n; i++)
            for (int c = 0; c < 3 && p->free_of[i] != SN_NONE; c++) d[3 * p->free_of[i] + c] = -*coordinate(&g[i], c);
        solve(matrix, n, d);
        longest = 0.0;
        for (sn_index i = 0; i < p->n; i++)
            for (int c = 0; c < 3 && p->free_of[i] != SN_NONE; c++) {
                slope += *coordinate(&g[i], c) * d[3 * p->free_of[i] + c];
                longest = fmax(longest, fabs(d[3 * p->free_of[i] + c]) / p->m->diagonal);
            }
        for (int halving = 0; halving < 40; halving++, length *= 0.5) {
            memcpy(trial, p->x, bytes);
            for (sn_index i = 0; i < p->n; i++)
                for (int c = 0; c < 3 && p->free_of[i] != SN_NONE; c++) *coordinate(&trial[i], c) += length * d[3 * p->free_of[i] + c];
            double found = objective(p, trial, g, gv, &over);
            if (found <= energy + 1e-4 * length * slope || longest < 1e-9) break; /* below that the energy is all rounding */
        }
        memcpy(p->x, trial, bytes);
    }
    free(matrix), free(kept), free(d), free(g), free(trial), free(gv);
    return longest;
}

/* ---- steps --------------------------------------------------------------------------------------------------------------- */

static problem make_problem(const simulation *s, bool barriers) {
    const sn_model_muscle *m = &s->model->muscles[0];
    problem p = {.scene = s->scene, .m = m, .n = m->point_count, .h = s->model->substep_duration, .barriers = barriers};
    p.elements = SN_NEW(element, m->distance_start[SN_DISTANCE_KINDS] + m->hinge_count + m->area_count);
    p.free_of = SN_NEW(sn_index, p.n);
    p.x = SN_NEW(sn_vec3, p.n), p.v = SN_NEW(sn_vec3, p.n), p.y = SN_NEW(sn_vec3, p.n);
    for (sn_index i = 0; i < p.n; i++) {
        p.free_of[i] = m->inverse_mass[i] > 0.0 ? p.free_count++ : SN_NONE;
        p.x[i] = m->rest[i];
        p.v[i] = sn_v3(0, 0, 0);
    }
    p.volume0 = volume(&p, p.x, p.y);
    return p;
}

static void free_problem(problem *p) { free(p->elements), free(p->free_of), free(p->x), free(p->v), free(p->y); }

/* Attached points of bone "lower" turn about the x axis through the origin, the others stay. */
static void place_carried(problem *p, double time) {
    double angle = linear_key(&p->scene->motion.joints[0].angle, time), c = cos(angle), s = sin(angle);
    for (sn_index i = 0; i < p->m->site_count; i++) {
        const sn_site *site = &p->m->sites[i];
        for (sn_index k = site->begin; k < site->end && site->joint != SN_NONE; k++) {
            sn_vec3 r = p->m->rest[p->m->kinematic_points[k]];
            p->x[p->m->kinematic_points[k]] = sn_v3(r.x, c * r.y - s * r.z, s * r.y + c * r.z);
        }
    }
}

/* Gauss and Jordan, with pivots; a (6 x 7) is left reduced, its last column the solution. */
static void solve6(double a[6][7]) {
    for (int c = 0; c < 6; c++) {
        int best = c;
        for (int r = c; r < 6; r++)
            if (fabs(a[r][c]) > fabs(a[best][c])) best = r;
        for (int k = 0; k < 7; k++) {
            double kept = a[c][k];
            a[c][k] = a[best][k], a[best][k] = kept;
        }
        for (int k = 6; k >= c; k--) a[c][k] /= a[c][c];
        for (int r = 0; r < 6; r++)
            for (int k = 6; k >= c && r != c; k--) a[r][k] -= a[r][c] * a[c][k];
    }
}

/* The rotation over the last step, by Cayley: x - x' = d + b x (x + x') / 2. Columns of what is linear in (d, b) at the middle m. */
static void add_rows(double a[6][7], sn_vec3 m, sn_vec3 moved, double mass) {
    const double rows[3][6] = {{1, 0, 0, 0, m.z, -m.y}, {0, 1, 0, -m.z, 0, m.x}, {0, 0, 1, m.y, -m.x, 0}};
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j < 6; j++) a[i][j] += mass * rows[c][i] * rows[c][j];
            a[i][6] += mass * rows[c][i] * *coordinate(&moved, c);
        }
}

/* (d, b) of the attached points' motion over the last step, by least squares. */
static void fit_bones(const problem *p, double out[6]) {
    double a[6][7] = {{0}};
    for (sn_index k = 0; k < p->m->kinematic_count; k++) {
        sn_index i = p->m->kinematic_points[k];
        sn_vec3 moved = sn_scale(p->v[i], p->h);
        add_rows(a, sn_add_scaled(p->x[i], moved, -0.5), moved, p->m->kinematic_mass[k]);
    }
    if (p->m->kinematic_count > 0) solve6(a);
    for (int i = 0; i < 6; i++) out[i] = a[i][6];
}

/* Of a point that went along with them and is at x: x' = x - h u solves the same equation; by iteration, |b| being small. */
static sn_vec3 velocity_of_bones(const problem *p, const double bones[6], sn_vec3 x) {
    sn_vec3 moved = sn_v3(0, 0, 0);
    for (int i = 0; i < 60; i++) {
        sn_vec3 m = sn_add_scaled(x, moved, -0.5);
        moved = sn_add(sn_v3(bones[0], bones[1], bones[2]), sn_cross(sn_v3(bones[3], bones[4], bones[5]), m));
    }
    return sn_scale(moved, 1.0 / p->h);
}

/* One step to `time`; returns how far it is from converged, over L. */
static double reference_step(problem *p, double time) {
    sn_vec3 *before = SN_NEW(sn_vec3, p->n);
    double keep = exp(-p->m->source->damping * p->h), bones[6];
    memcpy(before, p->x, (size_t)p->n * sizeof *before);
    fit_bones(p, bones);
    for (sn_index i = 0; i < p->n; i++) {
        sn_vec3 u = velocity_of_bones(p, bones, p->x[i]), v = sn_add_scaled(u, sn_sub(p->v[i], u), keep);
        p->y[i] = sn_add_scaled(p->x[i], sn_add_scaled(v, p->scene->gravity, p->h), p->h);
    }
    make_elements(p, time);
    place_carried(p, time);
    double left = minimise(p);
    for (sn_index i = 0; i < p->n; i++) p->v[i] = sn_scale(sn_sub(p->x[i], before[i]), 1.0 / p->h);
    free(before);
    return left;
}

static double difference(const problem *p, const simulation *s) {
    double most = 0.0;
    for (sn_index i = 0; i < p->n; i++) most = fmax(most, sn_distance(p->x[i], position(s, i)));
    return most / p->m->diagonal;
}

static double motion(const simulation *s) { return greatest_move(s) / s->model->muscles[0].diagonal; }

/* ---- gradients ----------------------------------------------------------------------------------------------------------- */

/* A muscle in the middle of a bend, shaken, with every kind of row at work. */
static void make_shaken(sn_scene *scene) {
    fusiform f = FUSIFORM;
    f.rings = 12, f.sectors = 11;
    make_scene(scene, &f);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->muscles[0].contraction = 0.4;
    scene->muscles[0].activation.constant = 0.7;
}

static void shake(sn_vec3 *x, sn_index n, const sn_index *free_of, double most) {
    uint64_t random = 7;
    for (sn_index i = 0; i < n; i++)
        if (free_of[i] != SN_NONE)
            x[i] = sn_add_scaled(x[i], sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, sn_random(&random) - 0.5), most);
}

/* Richardson's extrapolation of central differences: of order step^4. */
static double derivative(const element *e, sn_vec3 *x, double *q, double step) {
    double kept = *q, d[2];
    sn_vec3 unused[4];
    for (int k = 0; k < 2; k++) {
        double h = k == 0 ? step : 0.5 * step;
        *q = kept + h;
        double high = element_energy(e, x, unused);
        *q = kept - h;
        d[k] = (high - element_energy(e, x, unused)) / (2.0 * h);
        *q = kept;
    }
    return (4.0 * d[1] - d[0]) / 3.0;
}

/* Of the elements of one kind: greatest difference of the gradient from differences, over the greatest gradient. */
static void element_gradients(const problem *p, kind of) {
    double worst = 0.0, largest = 0.0;
    for (sn_index r = 0; r < p->element_count; r++) {
        const element *e = &p->elements[r];
        sn_vec3 x[4], g[4];
        if (e->kind != of) continue;
        for (int i = 0; i < e->count; i++) x[i] = p->x[e->point[i]];
        element_energy(e, x, g);
        for (int i = 0; i < e->count; i++)
            for (int c = 0; c < 3; c++) {
                double found = *coordinate(&g[i], c);
                largest = fmax(largest, fabs(found));
                worst = fmax(worst, fabs(derivative(e, x, coordinate(&x[i], c), 1e-4 * p->m->mean_edge) - found));
            }
    }
    char name[80], figures[80];
    snprintf(name, sizeof name, "gradient of the %s energy against differences", KIND_NAMES[of]);
    snprintf(figures, sizeof figures, "%.1e of the largest", worst / largest);
    verdict(name, largest > 0.0 && worst < 1e-7 * largest, figures);
}

/* V is linear in each coordinate: its differences are exact to rounding. */
static void volume_gradient(problem *p) {
    sn_vec3 *g = SN_NEW(sn_vec3, p->n), *unused = SN_NEW(sn_vec3, p->n);
    double worst = 0.0, largest = 0.0, step = 0.1 * p->m->mean_edge;
    volume(p, p->x, g);
    for (sn_index i = 0; i < p->m->vertex_count; i++)
        for (int c = 0; c < 3; c++) {
            double *q = coordinate(&p->x[i], c), kept = *q;
            *q = kept + step;
            double high = volume(p, p->x, unused);
            *q = kept - step;
            double low = volume(p, p->x, unused);
            *q = kept;
            largest = fmax(largest, fabs(*coordinate(&g[i], c)));
            worst = fmax(worst, fabs((high - low) / (2.0 * step) - *coordinate(&g[i], c)));
        }
    char figures[80];
    snprintf(figures, sizeof figures, "%.1e of the largest", worst / largest);
    verdict("gradient of the volume against differences", worst < 1e-7 * largest, figures);
    free(g), free(unused);
}

/* The library's whole gradient, against the one whose parts have just been checked. */
static void whole_gradient(problem *p, simulation *s) {
    sn_vec3 *mine = SN_NEW(sn_vec3, p->n), *theirs = SN_NEW(sn_vec3, p->n), *gv = SN_NEW(sn_vec3, p->n);
    sn_muscle_state *state = &s->state->muscles[0];
    double over, worst = 0.0, largest = 0.0;
    for (sn_index i = 0; i < p->n; i++) {
        state->points[i].x = p->x[i].x, state->points[i].y = p->x[i].y, state->points[i].z = p->x[i].z;
        qn_of(s)->target[i] = p->y[i];
    }
    for (sn_index r = 0; r < p->m->area_count; r++) state->inputs->guarded[r] = true;
    const sn_objective their = objective_of(s, p->h);
    double energy = objective(p, p->x, mine, gv, &over), their_energy = sn_objective_evaluate(&their, state->points, theirs);
    for (sn_index i = 0; i < p->n; i++) {
        largest = fmax(largest, sn_norm(mine[i]));
        worst = fmax(worst, sn_distance(mine[i], theirs[i]));
    }
    char figures[120];
    snprintf(figures, sizeof figures, "%.1e of the largest; energies %.1e", worst / largest, fabs(energy / their_energy - 1.0));
    verdict("the library's whole gradient and energy against these", worst < 1e-10 * largest && fabs(energy / their_energy - 1.0) < 1e-10,
            figures);
    free(mine), free(theirs), free(gv);
}

static void gradients(void) {
    sn_scene scene;
    make_shaken(&scene);
    simulation s = start(&scene);
    problem p = make_problem(&s, true);
    memcpy(p.y, p.x, (size_t)p.n * sizeof *p.y);
    shake(p.x, p.n, p.free_of, 0.3 * p.m->mean_edge);
    make_elements(&p, 0.0);
    for (int k = 0; k < KINDS; k++) element_gradients(&p, (kind)k);
    volume_gradient(&p);
    whole_gradient(&p, &s);
    free_problem(&p);
    finish(&s);
}

/* ---- qn ------------------------------------------------------------------------------------------------------------------ */

typedef struct scenario {
    const char *name;
    sn_index rings, sectors, frames;
    bool structure;
    double relaxed, active; /* N/m */
    double activation;      /* at the end of a second */
    sn_fiber_law law;
    double volume_ratio; /* at activation 1 */
    double turn;         /* rad in a second */
    double gravity;
} scenario;

static void make_scenario(sn_scene *scene, const scenario *by) {
    fusiform f = FUSIFORM;
    f.rings = by->rings, f.sectors = by->sectors, f.structure = by->structure;
    make_scene(scene, &f);
    sn_scene_muscle *m = &scene->muscles[0];
    m->stiffness_relaxed = by->relaxed, m->stiffness_active = by->active;
    m->law = by->law;
    if (by->activation > 0.0) set_keys(&m->activation, 0.0, 0.0, 1.0, by->activation);
    if (by->volume_ratio != 1.0) {
        m->volume_ratio = (sn_knots){.count = 2, .x = SN_NEW(double, 2), .y = SN_NEW(double, 2)};
        m->volume_ratio.x[1] = 1.0, m->volume_ratio.y[0] = 1.0, m->volume_ratio.y[1] = by->volume_ratio;
    }
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, by->turn);
    scene->gravity = sn_v3(0, by->gravity, 0);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.iterations = 400;
    scene->solver.tolerance = 1e-9;
}

static void qn_agrees(const scenario *by) {
    sn_scene scene;
    make_scenario(&scene, by);
    simulation s = start(&scene);
    problem p = make_problem(&s, true);
    double left = 0.0, most = 0.0;
    int64_t iterations = 0;
    for (sn_index frame = 1; frame <= by->frames; frame++) {
        step_frames(&s, 1, NULL);
        iterations += s.state->muscles[0].statistics.iterations;
        left = fmax(left, reference_step(&p, frame / scene.rate));
        most = fmax(most, difference(&p, &s));
    }
    char name[120], figures[160];
    snprintf(name, sizeof name, "qn, %s", by->name);
    snprintf(figures, sizeof figures, "%.1e L after %d steps, moved by %.2f L, %d triangles, %.0f iterations a step", most, (int)by->frames,
             motion(&s), (int)p.m->triangle_count, (double)iterations / by->frames);
    verdict(name, most < 1e-6 && left < 1e-9, figures);
    free_problem(&p);
    finish(&s);
}

/* ---- xpbd ---------------------------------------------------------------------------------------------------------------- */

/* One step in which the bone turns by turn x h, soft enough for xpbd to converge (k h^2 w of order 1); no barrier: no area row acts. */
static double xpbd_floor(double h, double *moved) {
    const scenario by = {"", 12, 11, 1, true, 0.5, 0.5, 0.0, SN_LAW_PROJECTED, 1.0, -1.0, 0.0};
    sn_scene scene;
    make_scenario(&scene, &by);
    scene.rate = 1.0 / h;
    scene.solver = sn_solver_defaults(SN_SOLVER_XPBD);
    scene.solver.substeps = 1;
    scene.solver.iterations = 20000;
    scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = 2.0 / (24.0 * 24.0 * h * h); /* the same k h^2 */
    scene.muscles[0].stiffness_volume = 40.0;
    simulation s = start(&scene);
    problem p = make_problem(&s, false);
    step_frames(&s, 1, NULL);
    double left = reference_step(&p, h), found = difference(&p, &s);
    assert_int_equal(s.state->muscles[0].statistics.held_triangles, 0);
    assert_true(left < 1e-10);
    *moved = motion(&s);
    free_problem(&p);
    finish(&s);
    return found;
}

static void xpbd_agrees_to_its_floor(void) {
    double floors[4], moved[4];
    for (int i = 0; i < 4; i++) floors[i] = xpbd_floor(1.0 / (24 << i), &moved[i]);
    double order = log2(floors[0] / floors[3]) / log2(moved[0] / moved[3]);
    char figures[160];
    snprintf(figures, sizeof figures, "%.1e %.1e %.1e %.1e L in steps that move by %.1e to %.1e L: order %.2f", floors[0], floors[1],
             floors[2], floors[3], moved[0], moved[3], order);
    verdict("xpbd, converged: its floor is the square of a step's motion",
            floors[0] < 10.0 * moved[0] * moved[0] && order > 1.7 && order < 2.5, figures);
}

int main(void) {
    static const scenario SCENARIOS[] = {
        {"soft, gravity, no structure", 12, 11, 8, false, 500, 500, 0.0, SN_LAW_PROJECTED, 1.0, -1.0, -9.81},
        {"soft, structure, activation", 12, 11, 8, true, 500, 5e4, 1.0, SN_LAW_PROJECTED, 1.0, -1.0, 0.0},
        {"the papers' stiffness, structure, activation", 12, 11, 8, true, 5e5, 5e7, 1.0, SN_LAW_PROJECTED, 1.0, -1.0, 0.0},
        {"isochoric, volume gain 1.5, activation", 12, 11, 8, true, 5e5, 5e7, 1.0, SN_LAW_ISOCHORIC, 1.5, -0.5, 0.0},
        {"768 triangles, structure, activation", 24, 16, 3, true, 5e5, 5e7, 1.0, SN_LAW_PROJECTED, 1.0, -1.0, 0.0},
    };
    gradients();
    for (size_t i = 0; i < sizeof SCENARIOS / sizeof *SCENARIOS; i++) qn_agrees(&SCENARIOS[i]);
    xpbd_agrees_to_its_floor();
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
