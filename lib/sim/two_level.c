/*
 * two_level.c -- the coarse half of the two-level preconditioner A^-1 + Z (ZT H Z)^-1 ZT.   numerics.md 7
 *
 * The scalar matrix is blind to rotations: a twist that costs springs and hinges next to nothing is as stiff to it as any other motion of
 * that wavelength. Z has such motions: sections of the muscle that move as rigid bodies, blended into each other. Each point belongs to the
 * two nearest centres with weights (1 - d / d_3)^2, d_3 the distance of the third, so that a row touches few sections and ZT H Z is
 * gathered row by row. Its factor is dense; columns that depend on others (a section of one point cannot turn) are left out.
 */
#include "two_level.h"

#include "frames.h"
#include "rows.h"

#include <stdlib.h>
#include <string.h>

/* Vertices to a section, and the most sections: beyond them the dense factor costs more than it saves. */
enum { SECTION_VERTICES = 12, MOST_SECTIONS = 24, LEAST_SECTIONS = 2 };
/* A pivot below this share of its column's own diagonal is rounding. */
static const double DEPENDENT = 1e-11;

/* ---- made and unmade -------------------------------------------------------------------------------------------------------- */

static bool alloc_sections(sn_two_level *t) {
    size_t points = (size_t)t->model->point_count, size = (size_t)t->size;
    t->member = sn_alloc(points, sizeof *t->member);
    t->weight = sn_alloc(points, sizeof *t->weight);
    t->total = SN_NEW(double, t->count);
    t->middle = SN_NEW(sn_vec3, t->count);
    t->at = SN_NEW(sn_vec3, points);
    t->factor = SN_NEW(double, size *size);
    t->inverse = SN_NEW(double, size);
    t->amount = SN_NEW(double, size);
    return t->member != NULL && t->weight != NULL && t->total != NULL && t->middle != NULL && t->at != NULL && t->factor != NULL &&
           t->inverse != NULL && t->amount != NULL;
}

/* Weights of a point in the first of the sections that the frames found for it. */
static void weigh(sn_two_level *t, const sn_frames *frames, sn_index point) {
    const sn_model_muscle *m = t->model;
    double distance[SN_COARSE_OVERLAP + 1], sum = 0.0;
    int found = 0;
    for (; found <= SN_COARSE_OVERLAP && frames->member[point][found] != SN_NONE; found++)
        distance[found] = sn_distance(m->rest[point], m->rest[frames->centres[frames->member[point][found]]]);
    int used = found > SN_COARSE_OVERLAP ? SN_COARSE_OVERLAP : found;
    double reach = found > SN_COARSE_OVERLAP ? distance[SN_COARSE_OVERLAP] : 2.0 * distance[used - 1];
    for (int k = 0; k < SN_COARSE_OVERLAP; k++) {
        double share = k < used && reach > 0.0 ? 1.0 - distance[k] / reach : 0.0;
        t->member[point][k] = k < used ? frames->member[point][k] : SN_NONE;
        t->weight[point][k] = share * share + (k == 0 ? 1e-6 : 0.0); /* equally far from all of them: with the first */
        sum += t->weight[point][k];
    }
    for (int k = 0; k < used; k++) {
        t->weight[point][k] = m->inverse_mass[point] > 0.0 ? t->weight[point][k] / sum : 0.0;
        t->total[t->member[point][k]] += t->weight[point][k];
    }
}

bool sn_two_level_create(const sn_model_muscle *m, sn_two_level *out) {
    *out = (sn_two_level){0};
    if (m->kinematic_count == m->vertex_count && m->point_count == m->vertex_count) return true;
    sn_frames frames;
    sn_index most = m->vertex_count / SECTION_VERTICES;
    most = most < LEAST_SECTIONS ? LEAST_SECTIONS : most > MOST_SECTIONS ? MOST_SECTIONS : most;
    if (!sn_frames_create(m, most, &frames)) return false;
    *out = (sn_two_level){.model = m, .count = frames.count, .size = SN_COARSE_MODES * frames.count};
    bool made = alloc_sections(out);
    for (sn_index i = 0; made && i < m->point_count; i++) weigh(out, &frames, i);
    sn_frames_free(&frames);
    if (!made) sn_two_level_free(out);
    return made;
}

void sn_two_level_free(sn_two_level *t) {
    free(t->member);
    free(t->weight);
    free(t->total);
    free(t->middle);
    free(t->at);
    free(t->factor);
    free(t->inverse);
    free(t->amount);
    *t = (sn_two_level){0};
}

/* ---- ZT H Z ----------------------------------------------------------------------------------------------------------------- */

static void find_middles(sn_two_level *t) {
    for (sn_index c = 0; c < t->count; c++) t->middle[c] = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < t->model->point_count; i++) {
        for (int k = 0; k < SN_COARSE_OVERLAP && t->member[i][k] != SN_NONE; k++) {
            sn_index c = t->member[i][k];
            if (t->weight[i][k] > 0.0) t->middle[c] = sn_add_scaled(t->middle[c], t->at[i], t->weight[i][k] / t->total[c]);
        }
    }
}

/* Where a force acts on the columns: sum += ZT (force at the point), the six of its k-th section. */
static inline void add_wrench(const sn_two_level *t, sn_index point, int k, sn_vec3 force, double sum[SN_COARSE_MODES]) {
    sn_vec3 f = sn_scale(force, t->weight[point][k]), torque = sn_cross(sn_sub(t->at[point], t->middle[t->member[point][k]]), f);
    sum[0] += f.x, sum[1] += f.y, sum[2] += f.z;
    sum[3] += torque.x, sum[4] += torque.y, sum[5] += torque.z;
}

/* ZT g of one row: nonzero in few sections. */
typedef struct coarse_row {
    int count;
    sn_index section[4 * SN_COARSE_OVERLAP];
    double value[4 * SN_COARSE_OVERLAP][SN_COARSE_MODES];
} coarse_row;

static double *values_of(coarse_row *row, sn_index section) {
    int at = 0;
    while (at < row->count && row->section[at] != section) at++;
    if (at == row->count) {
        row->section[row->count++] = section;
        memset(row->value[at], 0, sizeof row->value[at]);
    }
    return row->value[at];
}

static void project_row(const sn_two_level *t, int count, const sn_index *point, const sn_vec3 *gradient, coarse_row *out) {
    out->count = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < SN_COARSE_OVERLAP; k++)
            if (t->weight[point[i]][k] > 0.0) add_wrench(t, point[i], k, gradient[i], values_of(out, t->member[point[i]][k]));
}

/* Upper triangle += scale v vT. */
static void add_square(sn_two_level *t, const coarse_row *row, double scale) {
    for (int a = 0; a < row->count; a++) {
        for (int b = 0; b < row->count; b++) {
            if (row->section[a] > row->section[b]) continue;
            double *block = t->factor + SN_COARSE_MODES * ((size_t)row->section[a] * (size_t)t->size + (size_t)row->section[b]);
            for (int r = 0; r < SN_COARSE_MODES; r++, block += t->size) {
                double left = scale * row->value[a][r];
                for (int c = 0; c < SN_COARSE_MODES; c++) block[c] += left * row->value[b][c];
            }
        }
    }
}

typedef struct gatherer {
    sn_two_level *t;
    double stiffness;
} gatherer;

static bool gather_row(void *user, const sn_rest_row *row) {
    const gatherer *to = user;
    coarse_row projected;
    project_row(to->t, row->count, row->point, row->gradient, &projected);
    add_square(to->t, &projected, to->stiffness * row->scale);
    return true;
}

static void gather_masses(sn_two_level *t, double h) {
    static const sn_vec3 AXES[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const sn_model_muscle *m = t->model;
    for (sn_index i = 0; i < m->point_count; i++) {
        if (!(m->inverse_mass[i] > 0.0)) continue;
        for (int axis = 0; axis < 3; axis++) {
            coarse_row projected;
            project_row(t, 1, &i, &AXES[axis], &projected);
            add_square(t, &projected, 1.0 / (m->inverse_mass[i] * h * h));
        }
    }
}

/* U of the matrix in its place, row after row; a row whose pivot is rounding is left out. */
static void factorise(sn_two_level *t) {
    size_t n = (size_t)t->size;
    double *own = t->amount; /* the diagonal before anything was taken from it */
    for (size_t j = 0; j < n; j++) own[j] = t->factor[j * n + j];
    for (size_t k = 0; k < n; k++) {
        double *row = t->factor + k * n, pivot = row[k];
        t->inverse[k] = pivot > DEPENDENT * own[k] ? 1.0 / sqrt(pivot) : 0.0;
        for (size_t j = k; j < n; j++) row[j] *= t->inverse[k];
        for (size_t i = k + 1; i < n; i++) {
            if (row[i] == 0.0) continue;
            double *below = t->factor + i * n, share = row[i];
            for (size_t j = i; j < n; j++) below[j] -= share * row[j];
        }
    }
}

void sn_two_level_update(sn_two_level *t, const sn_vec3 *positions, double h, double stiffness) {
    gatherer to = {t, stiffness};
    memcpy(t->at, positions, (size_t)t->model->point_count * sizeof *t->at);
    memset(t->factor, 0, (size_t)t->size * (size_t)t->size * sizeof *t->factor);
    find_middles(t);
    gather_masses(t, h);
    sn_rows_at(t->model, t->at, gather_row, &to);
    factorise(t);
}

/* ---- apply ------------------------------------------------------------------------------------------------------------------ */

void sn_two_level_solve(sn_two_level *t, const sn_vec3 *in) {
    size_t n = (size_t)t->size;
    double *x = t->amount;
    memset(x, 0, n * sizeof *x);
    for (sn_index i = 0; i < t->model->point_count; i++)
        for (int k = 0; k < SN_COARSE_OVERLAP; k++)
            if (t->weight[i][k] > 0.0) add_wrench(t, i, k, in[i], x + SN_COARSE_MODES * t->member[i][k]);
    for (size_t k = 0; k < n; k++) {
        const double *row = t->factor + k * n;
        x[k] *= t->inverse[k];
        for (size_t j = k + 1; j < n; j++) x[j] -= row[j] * x[k];
    }
    for (size_t k = n; k-- > 0;) {
        const double *row = t->factor + k * n;
        for (size_t j = k + 1; j < n; j++) x[k] -= row[j] * x[j];
        x[k] *= t->inverse[k];
    }
}

void sn_two_level_add(const sn_two_level *t, double share, sn_vec3 *out) {
    for (sn_index i = 0; i < t->model->point_count; i++) {
        for (int k = 0; k < SN_COARSE_OVERLAP; k++) {
            if (!(t->weight[i][k] > 0.0)) continue;
            const double *a = t->amount + SN_COARSE_MODES * t->member[i][k];
            sn_vec3 arm = sn_sub(t->at[i], t->middle[t->member[i][k]]);
            sn_vec3 move = sn_add(sn_v3(a[0], a[1], a[2]), sn_cross(sn_v3(a[3], a[4], a[5]), arm));
            out[i] = sn_add_scaled(out[i], move, share * t->weight[i][k]);
        }
    }
}
