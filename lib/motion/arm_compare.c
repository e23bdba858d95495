/* arm_compare.c -- moment arms against measured curves: how far apart, how much of the bands is shared, which sign. */
#include "sinew/moment_arm.h"

#include <stdlib.h>

/* What is looked at of one measured angle. */
typedef struct point {
    double angle, mean, lower, upper; /* of the muscle's fibres */
    double arm, low, high;            /* measured; low and high NaN = no band */
} point;

static bool in_gap(const sn_arms *arms, sn_index muscle, double angle) {
    const double *mean = arms->muscles[muscle].mean;
    sn_index last = arms->sample_count - 1, k = 0;
    while (k + 1 < last && arms->angles[k + 1] <= angle) k++;
    return isnan(mean[k]) || isnan(mean[k + 1]);
}

/* false where the muscle has no arm at that angle. */
static bool make_point(const sn_arms *arms, sn_index muscle, const sn_measured_arm *measured, sn_index i, point *out) {
    double angle = measured->angles[i];
    *out = (point){.angle = angle,
                   .lower = INFINITY,
                   .upper = -INFINITY,
                   .arm = measured->arms[i],
                   .low = measured->lower[i],
                   .high = measured->upper[i]};
    if (!(angle >= arms->low && angle <= arms->high) || in_gap(arms, muscle, angle)) return false;
    sn_index count = 0;
    for (sn_index f = 0; f < arms->fiber_count; f++) {
        double arm = arms->muscle_of[f] == muscle ? sn_arm_of_fiber(arms, f, angle) : NAN;
        if (isnan(arm)) continue;
        out->mean += arm;
        out->lower = fmin(out->lower, arm);
        out->upper = fmax(out->upper, arm);
        count++;
    }
    out->mean /= count;
    return count > 0;
}

static double shared(const point *p) { return fmax(0.0, fmin(p->upper, p->high) - fmax(p->lower, p->low)); }
static double covered(const point *p) { return (p->upper - p->lower) + (p->high - p->low) - shared(p); }

/* Area that both bands cover over the area that either does; of one point the same of lengths. NaN where one has no width at all. */
static double overlap_of(const point *points, sn_index count) {
    double both = 0.0, either = 0.0, here = 0.0, there = 0.0;
    for (sn_index i = 0; i < count; i++) {
        double width = count == 1 ? 1.0 : 0.0; /* trapezoids: half the way to each neighbour */
        if (i > 0) width += 0.5 * (points[i].angle - points[i - 1].angle);
        if (i + 1 < count) width += 0.5 * (points[i + 1].angle - points[i].angle);
        if (isnan(points[i].low) || isnan(points[i].high)) continue;
        both += width * shared(&points[i]);
        either += width * covered(&points[i]);
        here += width * (points[i].upper - points[i].lower);
        there += width * (points[i].high - points[i].low);
    }
    return here > 0.0 && there > 0.0 ? both / either : NAN;
}

static void count_point(const point *p, double sign_from, sn_index counts[4]) {
    bool banded = !isnan(p->low) && !isnan(p->high);
    counts[0] += banded;
    counts[1] += banded && p->mean >= p->low && p->mean <= p->high;
    if (!(fabs(p->mean) > sign_from && fabs(p->arm) > sign_from)) return;
    counts[2]++;
    counts[3] += (p->mean > 0.0) == (p->arm > 0.0);
}

static void compare_points(const point *points, sn_index count, double sign_from, sn_arm_comparison *out) {
    double square = 0.0, sum = 0.0;
    sn_index counts[4] = {0}; /* with a band, inside it; with a sign, the same */
    for (sn_index i = 0; i < count; i++) {
        double apart = points[i].mean - points[i].arm;
        square += apart * apart;
        sum += apart;
        count_point(&points[i], sign_from, counts);
    }
    out->low = points[0].angle;
    out->high = points[count - 1].angle;
    out->rms = sqrt(square / count);
    out->bias = sum / count;
    out->overlap = overlap_of(points, count);
    out->inside = counts[0] > 0 ? (double)counts[1] / counts[0] : NAN;
    out->sign = counts[2] > 0 ? (double)counts[3] / counts[2] : NAN;
    out->sign_points = counts[2];
}

sn_status sn_arm_compare(const sn_arms *arms, sn_index muscle, const sn_measured_arm *measured, double sign_from, sn_arm_comparison *out,
                         sn_error *error) {
    point *points = SN_NEW(point, measured->count);
    if (points == NULL) return sn_fail_memory(error, "a comparison of arms");
    *out = (sn_arm_comparison){.low = NAN, .high = NAN, .rms = NAN, .bias = NAN, .overlap = NAN, .inside = NAN, .sign = NAN};
    for (sn_index i = 0; i < measured->count; i++)
        if (make_point(arms, muscle, measured, i, &points[out->points]))
            out->points++;
        else
            out->outside++;
    if (out->points > 0) compare_points(points, out->points, sign_from, out);
    free(points);
    return SN_OK;
}

void sn_measured_arms_free(sn_measured_arms *all) {
    for (sn_index i = 0; i < all->count; i++) {
        sn_measured_arm *a = &all->items[i];
        free(a->muscle);
        free(a->angles);
        free(a->arms);
        free(a->lower);
        free(a->upper);
    }
    free(all->items);
    *all = (sn_measured_arms){0};
}
