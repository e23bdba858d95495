/*
 * fit_sphere.c -- a sphere through part of a bone: robust, and refused where it is none.
 */
#include "sinew/motion_fit.h"
#include "sinew/numeric.h"

#include <stdlib.h>

enum { ROUNDS = 20 };
/* Of the median absolute deviation, for the standard deviation of a normal distribution. */
static const double DEVIATION_OF_MEDIAN = 1.4826;

typedef struct sphere_work {
    sn_index count;
    bool *used;      /* (count) */
    sn_vec3 *points; /* (count) those used, first */
    double *offsets; /* (count) from the surface of the sphere: sorted, of those used */
} sphere_work;

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double offset_of(const sn_fit_sphere *sphere, sn_vec3 p) { return fabs(sn_distance(p, sphere->centre) - sphere->radius); }

static sn_status fit_used(const sn_fit_patch *patch, sphere_work *w, sn_fit_sphere *out, sn_error *error) {
    double sum = 0.0;
    out->used = 0;
    for (sn_index i = 0; i < patch->point_count; i++)
        if (w->used[i]) w->points[out->used++] = patch->points[i];
    if (out->used < SN_FIT_SPHERE_VERTICES)
        return sn_fail(error, SN_ERROR_INPUT, "%d vertices are too few for a sphere, which needs %d; take a larger region", out->used,
                       SN_FIT_SPHERE_VERTICES);
    if (!sn_least_squares_sphere(out->used, w->points, &out->centre, &out->radius))
        return sn_fail(error, SN_ERROR_INPUT, "the %d vertices lie flat and tell no sphere; take another region", out->used);
    for (sn_index i = 0; i < out->used; i++) sum += sn_norm2(sn_v3(offset_of(out, w->points[i]), 0, 0));
    out->rms = sqrt(sum / out->used);
    return SN_OK;
}

/* Use what lies within the limit of the sphere at hand; true where that changes anything. */
static bool choose(const sn_fit_patch *patch, sphere_work *w, const sn_fit_sphere *sphere) {
    bool changed = false;
    for (sn_index i = 0; i < sphere->used; i++) w->offsets[i] = offset_of(sphere, w->points[i]);
    qsort(w->offsets, (size_t)sphere->used, sizeof *w->offsets, compare);
    double limit = fmax(3.0 * DEVIATION_OF_MEDIAN * w->offsets[sphere->used / 2], 0.01 * sphere->radius);
    for (sn_index i = 0; i < patch->point_count; i++) {
        bool use = offset_of(sphere, patch->points[i]) <= limit;
        changed = changed || use != w->used[i];
        w->used[i] = use;
    }
    return changed;
}

static double coverage(const sn_fit_patch *patch, const sphere_work *w, double radius) {
    double twice = 0.0;
    for (sn_index t = 0; t < patch->triangle_count; t++) {
        const sn_index *v = patch->triangles[t].v;
        if (w->used[v[0]] && w->used[v[1]] && w->used[v[2]])
            twice += sn_norm(sn_area_vector(patch->points[v[0]], patch->points[v[1]], patch->points[v[2]]));
    }
    return 0.5 * twice / (4.0 * SN_PI * radius * radius);
}

static sn_status judge(const sn_fit_sphere *s, sn_error *error) {
    const char *wrong = s->rms > SN_FIT_SPHERE_RMS * s->radius                   ? "they lie too far from it"
                        : s->coverage < SN_FIT_SPHERE_COVERAGE                   ? "they cover too little of it"
                        : s->used < (1.0 - SN_FIT_SPHERE_LEFT_OUT) * s->selected ? "too many of them had to be left out"
                                                                                 : NULL;
    if (wrong == NULL) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT,
                   "no sphere: the best one has a radius of %.2f mm, %d of %d vertices are used, off by %.2f mm rms, and cover %.1f %% of "
                   "it: %s; take another region",
                   1e3 * s->radius, s->used, s->selected, 1e3 * s->rms, 100.0 * s->coverage, wrong);
}

static sn_status fit_rounds(const sn_fit_patch *patch, sphere_work *w, sn_fit_sphere *out, sn_error *error) {
    sn_status status = fit_used(patch, w, out, error);
    for (int round = 0; round < ROUNDS && status == SN_OK && choose(patch, w, out); round++) status = fit_used(patch, w, out, error);
    return status;
}

sn_status sn_fit_sphere_robust(const sn_fit_patch *patch, sn_fit_sphere *out, sn_error *error) {
    size_t count = (size_t)patch->point_count;
    sphere_work w = {patch->point_count, SN_NEW(bool, count), SN_NEW(sn_vec3, count), SN_NEW(double, count)};
    *out = (sn_fit_sphere){.selected = patch->point_count};
    sn_status status = w.used != NULL && w.points != NULL && w.offsets != NULL ? SN_OK : sn_fail_memory(error, "a sphere");
    for (size_t i = 0; i < count && status == SN_OK; i++) w.used[i] = true;
    if (status == SN_OK) status = fit_rounds(patch, &w, out, error);
    if (status == SN_OK) {
        out->coverage = coverage(patch, &w, out->radius);
        status = judge(out, error);
    }
    free(w.used);
    free(w.points);
    free(w.offsets);
    return status;
}
