/*
 * external.c -- external constraints: energies, projection, errors of rows that hold on to what external_step.c has found.   [R18] 4.3
 */
#include "external.h"

#include <stdlib.h>

/* What |u| of a soft row is divided by where u vanishes, m. */
static const double LEAST_LENGTH = 1e-12;

/* ---- a row --------------------------------------------------------------------------------------------------------------------------- */

/* From the point of a target to the row's vertex. */
static sn_vec3 away_from(const sn_external_foot *foot, sn_vec3 at, const sn_point *points) {
    sn_vec3 place = foot->place;
    for (int k = 0; k < 3; k++)
        if (foot->weight[k] != 0.0) place = sn_add_scaled(place, sn_point_position(&points[foot->point[k]]), foot->weight[k]);
    return sn_sub(at, place);
}

/* A force that pulls the vertex one way and its target the other: of the gradient, force per m. */
static void pull(const sn_external_foot *foot, sn_index point, sn_vec3 gradient, sn_forces out) {
    if (out.values == NULL) return;
    double *to = out.values + (ptrdiff_t)out.stride * point;
    to[0] += gradient.x, to[1] += gradient.y, to[2] += gradient.z;
    for (int k = 0; k < 3; k++) {
        if (foot->weight[k] == 0.0) continue;
        to = out.values + (ptrdiff_t)out.stride * foot->point[k];
        to[0] -= foot->weight[k] * gradient.x, to[1] -= foot->weight[k] * gradient.y, to[2] -= foot->weight[k] * gradient.z;
    }
}

static double slide_energy(const sn_external_row *row, const sn_external_hold *hold, const sn_point *points, double parted, double k,
                           sn_forces out) {
    sn_vec3 u = away_from(&hold->slide, sn_point_position(&points[row->point]), points);
    double along = sn_dot(hold->normal, u), c = along - sn_external_kept(row->distance, parted),
           below = fmin(0.0, along - sn_external_kept(row->least, parted));
    k *= hold->slide.share;
    double slide = k * row->weights[SN_EXTERNAL_SLIDE], least = row->least > -INFINITY ? k - slide : 0.0;
    if (slide * c != 0.0 || least * below != 0.0) pull(&hold->slide, row->point, sn_scale(hold->normal, slide * c + least * below), out);
    return 0.5 * (slide * c * c + least * below * below);
}

static double bound_energy(const sn_external_row *row, const sn_external_hold *hold, const sn_point *points, double k, sn_forces out) {
    sn_vec3 u = away_from(&hold->bound, sn_point_position(&points[row->point]), points), off = sn_sub(u, hold->offset);
    double length = sn_norm(u), c = length - row->bound;
    k *= hold->bound.share;
    double soft = k * row->weights[SN_EXTERNAL_SOFT], hard = k * row->weights[SN_EXTERNAL_HARD];
    sn_vec3 gradient = sn_scale(u, soft * c / fmax(length, LEAST_LENGTH));
    pull(&hold->bound, row->point, sn_add_scaled(gradient, off, hard), out);
    return 0.5 * (soft * c * c + hard * sn_norm2(off));
}

static bool is_bound(const sn_external_row *row) { return row->weights[SN_EXTERNAL_SOFT] > 0.0 || row->weights[SN_EXTERNAL_HARD] > 0.0; }

static double energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                     sn_forces gradient) {
    const sn_externals *all = m->own[kind];
    const sn_external_hold *holds = sn_external_holds_of(s);
    double sum = 0.0, stiffness = k * all->factor;
    for (sn_index r = 0; r < m->external_count; r++) {
        const sn_external_row *row = &all->rows[r];
        if (holds[r].normal.x != 0.0 || holds[r].normal.y != 0.0 || holds[r].normal.z != 0.0)
            sum += slide_energy(row, &holds[r], points, s->inputs->parted, stiffness, gradient);
        if (is_bound(row)) sum += bound_energy(row, &holds[r], points, stiffness, gradient);
    }
    return sum;
}

/* ---- back end `xpbd` ------------------------------------------------------------------------------------------------------------------
 */

/* The sum of w over the points, each by the square of its weight. */
static double mobility_of(const sn_external_foot *foot, sn_index point, const sn_point *points) {
    double sum = points[point].w;
    for (int k = 0; k < 3; k++)
        if (foot->weight[k] != 0.0) sum += foot->weight[k] * foot->weight[k] * points[foot->point[k]].w;
    return sum;
}

static void shift(const sn_external_foot *foot, sn_index point, sn_vec3 way, sn_point *points) {
    sn_point *p = &points[point];
    p->x += p->w * way.x, p->y += p->w * way.y, p->z += p->w * way.z;
    for (int k = 0; k < 3; k++) {
        if (foot->weight[k] == 0.0) continue;
        p = &points[foot->point[k]];
        double share = -foot->weight[k] * p->w;
        p->x += share * way.x, p->y += share * way.y, p->z += share * way.z;
    }
}

/* One correction along a unit direction by C of a row of stiffness weight x k; of each sweep, without a memory of those before: the rows
 * are far stiffer than a step, and what differs is within the sweep. */
static void correct(const sn_external_foot *foot, sn_index point, sn_vec3 direction, double c, double compliance, sn_point *points) {
    double mobility = mobility_of(foot, point, points);
    if (!(mobility > 0.0) || !(foot->share > 0.0) || c == 0.0) return;
    shift(foot, point, sn_scale(direction, -c / (mobility + compliance / foot->share)), points);
}

static void project_row(const sn_external_row *row, const sn_external_hold *hold, double parted, double compliance, sn_point *points) {
    const double *w = row->weights;
    sn_vec3 n = hold->normal;
    if (n.x != 0.0 || n.y != 0.0 || n.z != 0.0) {
        double c =
            sn_dot(n, away_from(&hold->slide, sn_point_position(&points[row->point]), points)) - sn_external_kept(row->distance, parted);
        if (w[SN_EXTERNAL_SLIDE] > 0.0) correct(&hold->slide, row->point, n, c, compliance / w[SN_EXTERNAL_SLIDE], points);
        c = sn_dot(n, away_from(&hold->slide, sn_point_position(&points[row->point]), points)) - sn_external_kept(row->least, parted);
        if (c < 0.0) correct(&hold->slide, row->point, n, c, compliance / (1.0 - w[SN_EXTERNAL_SLIDE]), points);
    }
    if (w[SN_EXTERNAL_SOFT] > 0.0) {
        sn_vec3 u = away_from(&hold->bound, sn_point_position(&points[row->point]), points);
        double length = sn_norm(u);
        if (length > LEAST_LENGTH)
            correct(&hold->bound, row->point, sn_scale(u, 1.0 / length), length - row->bound, compliance / w[SN_EXTERNAL_SOFT], points);
    }
    if (w[SN_EXTERNAL_HARD] > 0.0) {
        sn_vec3 off = sn_sub(away_from(&hold->bound, sn_point_position(&points[row->point]), points), hold->offset);
        double length = sn_norm(off);
        if (length > 0.0) correct(&hold->bound, row->point, sn_scale(off, 1.0 / length), length, compliance / w[SN_EXTERNAL_HARD], points);
    }
}

/* [R18] eq. 14: of the vertex alone, the mean of what each type would move it by; none nearer than its minimum. */
static void project_one_way(const sn_external_row *row, const sn_external_hold *hold, double parted, double compliance, sn_point *points) {
    const double *w = row->weights;
    sn_point *p = &points[row->point];
    sn_vec3 at = sn_point_position(p), n = hold->normal, move = {0, 0, 0};
    bool slides = sn_norm2(n) > 0.0;
    double along = slides ? sn_dot(n, away_from(&hold->slide, at, points)) : 0.0;
    if (slides) move = sn_scale(n, w[SN_EXTERNAL_SLIDE] * (sn_external_kept(row->distance, parted) - along));
    if (is_bound(row)) {
        sn_vec3 u = away_from(&hold->bound, at, points);
        double length = sn_norm(u);
        if (length > LEAST_LENGTH) move = sn_add_scaled(move, u, w[SN_EXTERNAL_SOFT] * (row->bound - length) / length);
        move = sn_add_scaled(move, sn_sub(hold->offset, u), w[SN_EXTERNAL_HARD]);
    }
    if (slides) move = sn_add_scaled(move, n, fmax(0.0, sn_external_kept(row->least, parted) - along - sn_dot(n, move)));
    sn_put(p, sn_add_scaled(at, move, p->w > 0.0 ? p->w / (p->w + compliance) : 0.0));
}

static void sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *how) {
    const sn_externals *all = m->own[kind];
    const sn_external_hold *holds = sn_external_holds_of(s);
    double compliance = all->factor > 0.0 ? how->compliance / all->factor : INFINITY;
    for (sn_index r = 0; r < m->external_count && isfinite(compliance); r++)
        (how->one_way ? project_one_way : project_row)(&all->rows[r], &holds[r], s->inputs->parted, compliance, s->points);
}

/* ---- back end `qn`: the matrix --------------------------------------------------------------------------------------------------------
 */

/* As if it held in all directions, at the triangle that it is bound to: the closest one is another in almost every step, and this as good
 * (bodies.md 3). */
bool sn_externals_at_bind(const sn_group *g, sn_index member, sn_rest_visit visit, void *user) {
    const sn_model_muscle *m = g->members[member];
    const sn_externals *all = sn_externals_of(m);
    bool going = true;
    for (sn_index r = 0; r < m->external_count && going; r++) {
        const sn_external_row *row = &all->rows[r];
        const sn_external_target *t = &g->targets[all->candidates[row->begin]];
        sn_index points[4] = {row->point};
        sn_rest_row at = {.count = t->member != SN_NONE ? 4 : 1, .point = points, .weight = {1.0}};
        at.scale = all->factor * (row->weights[0] + row->weights[1] + row->weights[2]);
        for (int k = 0; k < 3 && t->member != SN_NONE; k++) {
            points[k + 1] = g->first[t->member] + t->moving.triangles[row->triangle].v[k] - g->first[member];
            at.weight[k + 1] = -row->barycentric[k];
        }
        if (at.scale > 0.0) going = visit(user, &at);
    }
    return going;
}

/* ---- what there is to say -------------------------------------------------------------------------------------------------------------
 */

static sn_left_out reason(const sn_build *build) {
    const sn_external_settings *settings = &build->scene->externals;
    if (!settings->enabled || build->source->unbound) return SN_OUT_SETTING;
    if (!(settings->stiffness > 0.0) || !sn_has_stiffness(build->source, 1.0)) return SN_OUT_NO_STIFFNESS;
    return build->source->rig.external_count > 0 ? SN_RUNS : SN_OUT_NO_TARGET;
}

static sn_index count(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return m->external_count;
}

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    const sn_externals *all = m->own[kind];
    return &all->rows[row].point;
}

/* |C| of the heaviest of its types, mean edges. */
static void errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end, double *out) {
    const sn_externals *all = m->own[kind];
    const sn_external_hold *holds = sn_external_holds_of(s);
    for (sn_index r = begin; r < end; r++) {
        const sn_external_row *row = &all->rows[r];
        sn_vec3 at = sn_point_position(&s->points[row->point]), u = away_from(&holds[r].slide, at, s->points),
                b = away_from(&holds[r].bound, at, s->points);
        double along = sn_dot(holds[r].normal, u), parted = s->inputs->parted;
        double error = fmax(0.0, sn_external_kept(row->least, parted) - along);
        bool held = sn_norm2(holds[r].normal) > 0.0;
        if (!held) error = 0.0;
        if (held && row->weights[SN_EXTERNAL_SLIDE] > 0.0) error = fmax(error, fabs(along - sn_external_kept(row->distance, parted)));
        if (row->weights[SN_EXTERNAL_SOFT] > 0.0) error = fmax(error, fabs(sn_norm(b) - row->bound));
        if (row->weights[SN_EXTERNAL_HARD] > 0.0) error = fmax(error, sn_distance(b, holds[r].offset));
        out[r - begin] = error / m->mean_edge;
    }
}

const char *sn_model_target_name(const sn_model *model, sn_index muscle, sn_index target) {
    const sn_group *g = &model->groups[model->muscles[muscle].group];
    const sn_external_target *t = &g->targets[target];
    return t->member != SN_NONE ? g->members[t->member]->source->name : sn_scene_touched_name(model->scene, t->touched);
}

static size_t own(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return (size_t)m->external_count * (sizeof(sn_external_hold) / sizeof(double));
}

static size_t row_bytes(const sn_model_muscle *m) {
    (void)m;
    return sizeof(sn_external_row) + sizeof(sn_external_hold);
}

static size_t own_bytes(const sn_model_muscle *m, sn_row_kind kind) {
    const sn_externals *all = m->own[kind];
    if (all == NULL) return 0;
    return sizeof *all + (size_t)m->external_count * sizeof *all->rows +
           (size_t)all->candidate_count * (sizeof *all->candidates + sizeof *all->rest_sides);
}

static void destroy(sn_model_muscle *m, sn_row_kind kind) {
    sn_externals *all = m->own[kind];
    if (all == NULL) return;
    free(all->rows);
    free(all->candidates);
    free(all->rest_sides);
    free(all);
    m->own[kind] = NULL;
}

const sn_row_ops sn_rows_external = {
    .info = {.name = "external", .errors = "error of external constraints, mean edges", .lacks = "", .points = 1},
    .shared = true,
    .reason = reason,
    .destroy = destroy,
    .own_bytes = own_bytes,
    .count = count,
    .points = points_of,
    .bytes = row_bytes,
    .own = own,
    .sweep = sweep,
    .energy = energy,
    .errors = errors,
};
