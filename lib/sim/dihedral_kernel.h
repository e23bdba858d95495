/*
 * dihedral_kernel.h -- inside lib/sim: hinges, their gradients and their projection, several at a time; in double for dihedral.c, in single
 * for single.c. The equations are in dihedral.c.
 */
#ifndef SN_SIM_DIHEDRAL_KERNEL_H
#define SN_SIM_DIHEDRAL_KERNEL_H

#include "angle_kernel.h"
#include "rows.h"

/* Value and gradients at points a, b, c, d; false where an area or the edge vanishes, or is not finite. */
SN_INLINE wide_mask hinge(const wide_point p[4], wide rest, wide *value, wide_vec3 g[4]) {
    wide_vec3 e = wide_between(p[1], p[0]), ac = wide_between(p[0], p[2]), bc = wide_between(p[1], p[2]);
    wide_vec3 ad = wide_between(p[0], p[3]), bd = wide_between(p[1], p[3]);
    wide_vec3 n1 = wide_cross(ac, bc), n2 = wide_cross(bd, ad);
    wide e2 = wide_dot(e, e), q1 = wide_dot(n1, n1), q2 = wide_dot(n2, n2), least = wide_splat(WIDE_HINGE_GUARD) * e2 * e2;
    wide most = wide_splat(WIDE_MOST);
    wide_mask good = ~wide_less(e2, wide_splat(SN_EDGE_GUARD)) & wide_less(least, q1) & wide_less(least, q2) & ~wide_less(most, q1) &
                     ~wide_less(most, q2); /* a NaN is in one of the areas, and less than nothing */
    wide length = wide_sqrt(e2), one = wide_splat(1.0);
    wide_vec3 unit = wide_scale(e, one / length), m1 = wide_scale(n1, one / q1), m2 = wide_scale(n2, one / q2);
    *value = wrap(angle_of(wide_dot(wide_cross(n1, n2), unit), wide_dot(n1, n2)) - rest);
    g[0] = wide_add(wide_scale(m1, wide_dot(bc, unit)), wide_scale(m2, wide_dot(bd, unit)));
    g[1] = wide_add(wide_scale(m1, -wide_dot(ac, unit)), wide_scale(m2, -wide_dot(ad, unit)));
    g[2] = wide_scale(m1, -length);
    g[3] = wide_scale(m2, -length);
    return good;
}

/* The limits of the published program (dihedral.c) in metres: on sum |q|^2, on lambda, and on 1 - d^2 of flat and of closed hinges. */
#define PUBLISHED_LEAST_SQUARE 1e2 /* 1/m^2 */
#define PUBLISHED_LEAST 1e-7       /* m^2 */
#define PUBLISHED_MOST 1e-5        /* m^2 */
#define PUBLISHED_FLAT 2e-10

/* What the rows of one sweep share. */
typedef struct hinge_rows {
    wide_record *points;
    const sn_index *index;  /* (4 x rows) */
    const double *angles;   /* (rows) */
    const double *softness; /* (rows) nullable */
    double *lambda;         /* (rows) */
    const bool *pairs;      /* (fours) single precision: it and the next can be projected together */
} hinge_rows;

typedef struct hinge_tally {
    int64_t skipped, clamped;
} hinge_tally;

/* The factor on w g of each point that C and its gradients call for, within the bounds of the sweep. */
SN_INLINE wide constraint_change(const wide_point p[4], const wide_vec3 g[4], wide c, wide lambda, wide compliance, const sn_sweep *sweep) {
    wide sum = wide_splat(0.0), farthest = sum;
    SN_UNROLL
    for (int i = 0; i < 4; i++) {
        wide moved = p[i].w * wide_dot(g[i], g[i]);
        sum = sum + moved;
        moved = p[i].w * moved;
        farthest = wide_select(wide_less(farthest, moved), moved, farthest);
    }
    wide change = wide_splat(sweep->gain) * (-c - compliance * lambda) / (sum + compliance);
    /* an arm that is stretched to many times its length would throw its end as far: no point moves farther than most_step */
    wide step = wide_sqrt(farthest) * wide_abs(change), most = wide_splat(sweep->most_step);
    return wide_select(wide_less(most, step), change * (most / step), change);
}

/* The same factor by the published program's rule, at the angle theta; *acts is narrowed to the hinges that it does not leave out. The
 * gradients of c and d are along the normals: sin theta by their product keeps its digits where they are nearly parallel. */
SN_INLINE wide published_change(const wide_point p[4], const wide_vec3 g[4], wide theta, wide rest, double gain, wide_mask *acts) {
    wide squares = wide_splat(0.0), weights = squares;
    SN_UNROLL
    for (int i = 0; i < 4; i++) squares = squares + wide_dot(g[i], g[i]), weights = weights + p[i].w;
    wide_vec3 normal = wide_cross(g[2], g[3]);
    wide sine2 = wide_dot(normal, normal) / (wide_dot(g[2], g[2]) * wide_dot(g[3], g[3])), sine = wide_sqrt(sine2);
    wide least = wide_splat(PUBLISHED_LEAST_SQUARE), q2 = sine2 * squares;
    q2 = wide_select(wide_less(q2, least), least, q2);
    wide lambda = wide_splat(4.0 * gain) * sine * (wide_abs(theta) - wide_abs(rest)) / (q2 * weights);
    *acts = *acts & wide_less(wide_splat(PUBLISHED_LEAST), lambda) & wide_less(lambda, wide_splat(PUBLISHED_MOST)) &
            wide_less(wide_splat(PUBLISHED_FLAT), sine2);
    return wide_copysign(lambda * sine, -theta);
}

/* Rows r .. r + lanes - 1, which share no point. */
SN_INLINE void project_hinges(const hinge_rows *in, sn_index r, const sn_sweep *sweep, int lanes, hinge_tally *out) {
    const sn_index *index = in->index + 4 * (size_t)r;
    wide_point p[4];
    wide_vec3 g[4];
    wide c, rest = wide_load(in->angles + r, lanes), compliance = wide_splat(sweep->compliance), change;
    SN_UNROLL
    for (int i = 0; i < 4; i++) p[i] = wide_gather(in->points, index + i, 4, lanes);
    wide_mask good = hinge(p, sweep->published ? wide_splat(0.0) : rest, &c, g), acts = good;
    wide lambda = sweep->first ? wide_splat(0.0) : wide_load(in->lambda + r, lanes);
    if (sweep->published) {
        change = published_change(p, g, c, rest, sweep->gain, &acts);
    } else {
        wide_mask far = wide_less(wide_splat(sweep->clamp), wide_abs(c)) & good;
        out->clamped += wide_count(far, lanes);
        c = wide_select(far, wide_copysign(wide_splat(sweep->clamp), c), c);
        if (in->softness != NULL) compliance = compliance * wide_load(in->softness + r, lanes);
        change = constraint_change(p, g, c, lambda, compliance, sweep);
    }
    wide_store(in->lambda + r, wide_select(acts, lambda + change, lambda), lanes);
    SN_UNROLL
    for (int i = 0; i < 4; i++) wide_scatter(in->points, index + i, 4, wide_move(p[i], g[i], p[i].w * change, acts), lanes);
    out->skipped += wide_count(~good, lanes);
}

SN_WIDE_KERNEL static hinge_tally sweep_hinges(const hinge_rows *in, sn_index batched, sn_index end, const sn_sweep *sweep) {
    hinge_tally out = {0, 0};
    sn_index r = 0;
    while (r < batched) {
        if (wide_takes(SN_BATCH_SINGLE) && in->pairs[r / SN_BATCH]) {
            project_hinges(in, r, sweep, SN_BATCH_SINGLE, &out);
            r += SN_BATCH_SINGLE;
        } else {
            project_hinges(in, r, sweep, WIDE_BATCH, &out);
            r += WIDE_BATCH;
        }
    }
    for (; r < end; r++) project_hinges(in, r, sweep, 1, &out);
    return out;
}

#endif
