/*
 * single.c -- back end `xpbd` in single precision: the same rows, projected eight at a time.   numerics.md 1, 3
 *
 * Within a substep the points are floats relative to the muscle's origin, so that a muscle a kilometre away keeps its digits; what a
 * substep starts and ends with (positions, velocities, the attached points at their bones) stays in double, and so do sums over all rows.
 */
#define SN_WIDE_SINGLE
#include "dihedral_kernel.h"
#include "distance_kernel.h"
#include "xpbd.h"

#include <stdlib.h>

/* ---- to single and back ----------------------------------------------------------------------------------------------------- */

/* The middle of the attached points, which are where their bones are whatever happens to the others; of all where none is attached. */
static sn_vec3 middle(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_vec3 low = sn_v3(DBL_MAX, DBL_MAX, DBL_MAX), high = sn_neg(low);
    sn_index count = m->kinematic_count > 0 ? m->kinematic_count : m->point_count;
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 p = sn_point_position(&s->points[m->kinematic_count > 0 ? m->kinematic_points[i] : i]);
        if (!sn_finite3(p)) continue;
        low = sn_v3(fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z));
        high = sn_v3(fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z));
    }
    return sn_add_scaled(low, sn_sub(high, low), 0.5);
}

/* Inverse masses are in floats over that of a mean point, and compliances over it too: of whatever size the muscle is, its numbers are. */
static double mean_mass(const sn_model_muscle *m) { return m->mass / m->point_count; }

float sn_single_weight(const sn_model_muscle *m, sn_index point) { return (float)(m->inverse_mass[point] * mean_mass(m)); }

void sn_single_enter(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_xpbd *memory = sn_xpbd_of(s);
    sn_vec3 origin = *memory->origin = middle(m, s);
    double mass = mean_mass(m);
    for (sn_index i = 0; i < m->point_count; i++) {
        const sn_point *p = &s->points[i];
        sn_vec3 at = sn_sub(sn_point_position(p), origin);
        memory->single_points[i] = (sn_single_point){(float)at.x, (float)at.y, (float)at.z, (float)(p->w * mass)};
    }
}

void sn_single_leave(const sn_model_muscle *m, sn_muscle_state *s) {
    const sn_xpbd *memory = sn_xpbd_of(s);
    sn_vec3 origin = *memory->origin;
    for (sn_index i = 0; i < m->point_count; i++) {
        const sn_single_point *p = &memory->single_points[i];
        if (p->w == 0.0F) continue; /* exactly where its bone has it */
        s->points[i].x = origin.x + (double)p->x, s->points[i].y = origin.y + (double)p->y, s->points[i].z = origin.z + (double)p->z;
    }
}

/* ---- areas ------------------------------------------------------------------------------------------------------------------ */

typedef struct area_rows {
    sn_single_point *points;
    const sn_index *index; /* (3 x rows) */
    const double *scales;  /* (rows) */
    double least;
    const bool *pairs; /* (fours) it and the next can be projected together */
} area_rows;

typedef struct area_tally {
    int64_t held, skipped;
} area_tally;

/* Rows r .. r + lanes - 1, which share no point. The equations are in area.c. */
SN_INLINE void project_areas(const area_rows *in, sn_index r, int lanes, area_tally *out) {
    const sn_index *index = in->index + 3 * (size_t)r;
    wide_point p[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_gather(in->points, index + i, 3, lanes);
    wide_vec3 d1 = wide_between(p[1], p[0]), d2 = wide_between(p[2], p[0]), n = wide_cross(d1, d2);
    wide scale = wide_load(in->scales + r, lanes), least = wide_splat(in->least), scaled = scale * scale, square = wide_dot(n, n) * scaled;
    wide_mask small = ~wide_less(least * least, square);
    if (!wide_any(small)) return;
    wide_mask good = small & wide_less(wide_splat(WIDE_AREA_GUARD), square) & ~wide_less(wide_splat(WIDE_MOST), square);
    wide ratio = wide_sqrt(square), sum = wide_splat(0.0);
    wide_vec3 u = wide_scale(n, scaled / ratio), g[3];
    g[1] = wide_cross(d2, u), g[2] = wide_cross(u, d1), g[0] = wide_scale(wide_add(g[1], g[2]), wide_splat(-1.0));
    SN_UNROLL
    for (int i = 0; i < 3; i++) sum = sum + p[i].w * wide_dot(g[i], g[i]);
    wide change = (least - ratio) / sum;
    SN_UNROLL
    for (int i = 0; i < 3; i++) wide_scatter(in->points, index + i, 3, wide_move(p[i], g[i], p[i].w * change, good), lanes);
    out->held += wide_count(good, lanes);
    out->skipped += wide_count(small & ~good, lanes);
}

SN_WIDE_KERNEL static area_tally sweep_areas(const area_rows *in, sn_index batched, sn_index end) {
    area_tally out = {0, 0};
    sn_index r = 0;
    while (r < batched) {
        if (wide_takes(SN_BATCH_SINGLE) && in->pairs[r / SN_BATCH]) {
            project_areas(in, r, SN_BATCH_SINGLE, &out);
            r += SN_BATCH_SINGLE;
        } else {
            project_areas(in, r, WIDE_BATCH, &out);
            r += WIDE_BATCH;
        }
    }
    for (; r < end; r++) project_areas(in, r, 1, &out);
    return out;
}

/* ---- volume ----------------------------------------------------------------------------------------------------------------- */

typedef struct volume_sum {
    double lane[SN_BATCH_SINGLE];
} volume_sum;

SN_INLINE void add_lanes(volume_sum *sum, sn_index row, wide value, int lanes) {
    double *to = lanes == SN_BATCH_SINGLE ? sum->lane : &sum->lane[row % SN_BATCH_SINGLE], values[SN_BATCH_SINGLE];
    wide_store(values, value, lanes);
    for (int i = 0; i < lanes; i++) to[i] += values[i];
}

static double total(const volume_sum *sum) {
    const double *a = sum->lane;
    return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}

typedef struct volume_rows {
    const sn_single_point *points;
    const sn_index *index;     /* (3 x triangles) */
    sn_single_point *gradient; /* 6 dV/dx */
} volume_rows;

/* Triangles t .. t + lanes - 1, which may share points: six times their volume, as seen from the origin. */
SN_INLINE void volume_batch(const volume_rows *in, sn_index t, int lanes, volume_sum *volume) {
    const sn_index *index = in->index + 3 * (size_t)t;
    const wide_point origin = {wide_splat(0.0), wide_splat(0.0), wide_splat(0.0), wide_splat(0.0)};
    wide_vec3 p[3];
    SN_UNROLL
    for (int i = 0; i < 3; i++) p[i] = wide_between(wide_gather(in->points, index + i, 3, lanes), origin);
    wide_vec3 bc = wide_cross(p[1], p[2]), ca = wide_cross(p[2], p[0]), ab = wide_cross(p[0], p[1]);
    const wide_point areas[3] = {{bc.x, bc.y, bc.z, origin.w}, {ca.x, ca.y, ca.z, origin.w}, {ab.x, ab.y, ab.z, origin.w}};
    add_lanes(volume, t, wide_dot(p[0], bc), lanes);
    wide_add_vectors(in->gradient, index, 3, areas, lanes);
}

SN_WIDE_KERNEL static double volume_of(const volume_rows *in, sn_index end) {
    volume_sum volume = {{0}};
    sn_index t = 0;
    for (; t + WIDE_LANES <= end; t += WIDE_LANES) volume_batch(in, t, WIDE_LANES, &volume);
    for (; t < end; t++) volume_batch(in, t, 1, &volume);
    return total(&volume) / 6.0;
}

/* As in volume.c. */
static const double VOLUME_TOLERANCE = 1e-3;

/* One Newton step; false: nothing more to do, or nothing that can be done. */
static bool project_volume(const sn_model_muscle *m, sn_muscle_state *s, const sn_sweep *sweep) {
    sn_xpbd *memory = sn_xpbd_of(s);
    sn_single_point *points = memory->single_points, *gradient = memory->single_gradient;
    const volume_rows in = {points, m->triangles->v, gradient};
    memset(gradient, 0, (size_t)m->vertex_count * sizeof *gradient);
    double volume = volume_of(&in, m->triangle_count), sum[4] = {0};
    for (sn_index i = 0; i < m->vertex_count; i++) {
        const sn_single_point *g = &gradient[i];
        sum[i % 4] += (double)(points[i].w * (g->x * g->x + g->y * g->y + g->z * g->z));
    }
    double square = ((sum[0] + sum[1]) + (sum[2] + sum[3])) / 36.0;
    double residual = s->inputs->volume_goal * m->rest_volume - volume - sweep->compliance * memory->volume_lambda;
    double change = sweep->gain * residual / (square + sweep->compliance);
    if (!isfinite(change)) return false; /* a point is not finite: leave the others alone */
    memory->volume_lambda += change;
    float step = (float)(change / 6.0);
    for (sn_index i = 0; i < m->vertex_count; i++) {
        float scale = points[i].w * step;
        points[i].x += scale * gradient[i].x, points[i].y += scale * gradient[i].y, points[i].z += scale * gradient[i].z;
    }
    return residual * residual > VOLUME_TOLERANCE * m->rest_volume * m->rest_volume;
}

/* ---- one sweep -------------------------------------------------------------------------------------------------------------- */

/* Inverse masses are over that of a mean point here. */
static sn_sweep in_floats(const sn_model_muscle *m, const sn_sweep *in_double) {
    sn_sweep sweep = *in_double;
    sweep.compliance *= mean_mass(m);
    return sweep;
}

void sn_single_distance_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *in_double) {
    const sn_sweep sweep = in_floats(m, in_double);
    sn_index begin = m->distance_start[kind], end = m->distance_start[kind + 1];
    const distance_rows in = {sn_xpbd_of(s)->single_points, m->distances->point, s->inputs->goals,
                              m->distance_softness,         m->distance_gain,    sn_xpbd_of(s)->distance_lambda,
                              m->distance_pairs + begin / 4};
    s->statistics.skipped_edges += sweep_distances(&in, begin, begin + m->distance_batched[kind], end, &sweep);
}

void sn_single_hinge_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *in_double) {
    (void)kind;
    const sn_sweep sweep = in_floats(m, in_double);
    const hinge_rows in = {sn_xpbd_of(s)->single_points, m->hinges->point, m->hinge_angles, m->hinge_softness,
                           sn_xpbd_of(s)->hinge_lambda,  m->hinge_pairs};
    hinge_tally done = sweep_hinges(&in, m->hinge_batched, m->hinge_count, &sweep);
    s->statistics.skipped_hinges += done.skipped;
    s->statistics.clamped_hinges += done.clamped;
}

void sn_single_area_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *in_double) {
    (void)kind, (void)in_double;
    const area_rows in = {sn_xpbd_of(s)->single_points, m->areas->point, m->area_scales, m->source->least_area, m->area_pairs};
    area_tally done = sweep_areas(&in, m->area_batched, m->area_count);
    s->statistics.held_triangles += done.held;
    s->statistics.skipped_triangles += done.skipped;
}

void sn_single_volume_sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *in_double) {
    (void)kind;
    const sn_sweep sweep = in_floats(m, in_double);
    if (sweep.first) sn_xpbd_of(s)->volume_lambda = 0.0;
    for (int i = 0; i < sweep.projections && project_volume(m, s, &sweep); i++) continue;
}
