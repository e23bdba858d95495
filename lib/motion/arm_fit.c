/* arm_fit.c -- splines through lengths at the rows of one way of a coordinate. */
#include "moment_arm.h"

#include <stdlib.h>

enum { ANGLES_A_PIECE = 4 };
#define SAME_ANGLE 1e-9 /* of the range */

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static sn_index count_angles(const double *x, sn_index count, double *sorted) {
    sn_index angles = count > 0;
    for (sn_index i = 0; i < count; i++) sorted[i] = x[i];
    qsort(sorted, (size_t)count, sizeof *sorted, compare);
    double near = count > 0 ? SAME_ANGLE * (sorted[count - 1] - sorted[0]) : 0.0;
    for (sn_index i = 1; i < count; i++) angles += sorted[i] - sorted[i - 1] > near;
    return angles;
}

sn_status sn_arm_way_make(const double *coordinate, sn_index *rows, sn_index count, arm_way *out, sn_error *error) {
    *out = (arm_way){.count = count, .rows = rows, .low = INFINITY, .high = -INFINITY};
    double *sorted = SN_NEW(double, count);
    out->x = SN_NEW(double, count);
    if (rows == NULL || sorted == NULL || out->x == NULL) {
        free(sorted);
        sn_arm_way_free(out);
        return sn_fail_memory(error, "the rows of a coordinate");
    }
    for (sn_index i = 0; i < count; i++) {
        out->x[i] = coordinate[rows[i]];
        out->low = fmin(out->low, out->x[i]);
        out->high = fmax(out->high, out->x[i]);
    }
    out->angles = count_angles(out->x, count, sorted);
    free(sorted);
    return SN_OK;
}

void sn_arm_way_free(arm_way *way) {
    free(way->rows);
    free(way->x);
    *way = (arm_way){0};
}

bool sn_arm_way_holds(const arm_way *way, sn_index pieces) {
    return way->angles >= SN_ARM_FEWEST_ANGLES && way->angles / ANGLES_A_PIECE >= pieces;
}

/* The rows at which there are values have a design of their own; the coefficients mean the same. */
static sn_status fit_some(sn_index pieces, const arm_way *way, const double *x, const double *y, double *coefficients, arm_fit *fit) {
    sn_spline_fit *own = NULL;
    sn_status status = sn_spline_fit_create(way->low, way->high, pieces, &own, NULL);
    if (status == SN_OK) {
        fit->determined = sn_spline_fit_design(own, fit->count, x, NULL) == SN_OK;
        if (fit->determined) fit->left = sn_spline_fit_solve(own, y, coefficients);
    }
    sn_spline_fit_destroy(own);
    return status;
}

sn_status sn_arm_fit_values(const sn_spline_fit *whole, const arm_way *way, const double *values, double *coefficients, arm_fit *out,
                            sn_error *error) {
    double *x = SN_NEW(double, way->count), *y = SN_NEW(double, way->count);
    sn_status status = x != NULL && y != NULL ? SN_OK : sn_fail_memory(error, "a fit");
    *out = (arm_fit){0};
    for (sn_index i = 0; i < way->count && status == SN_OK; i++) {
        double value = values[way->rows[i]];
        if (isnan(value)) continue;
        x[out->count] = way->x[i];
        y[out->count++] = value;
    }
    if (status == SN_OK && out->count == way->count) {
        out->determined = true;
        out->left = sn_spline_fit_solve(whole, y, coefficients);
    } else if (status == SN_OK && fit_some(sn_spline_fit_size(whole) - 3, way, x, y, coefficients, out) != SN_OK) {
        status = sn_fail_memory(error, "a fit");
    }
    free(x);
    free(y);
    return status;
}

sn_status sn_arm_design(const arm_way *way, sn_index *pieces, sn_spline_fit **out, sn_error *error) {
    *out = NULL;
    for (; *pieces > 0; (*pieces)--) {
        if (!sn_arm_way_holds(way, *pieces)) continue;
        sn_status status = sn_spline_fit_create(way->low, way->high, *pieces, out, error);
        if (status != SN_OK) return status;
        status = sn_spline_fit_design(*out, way->count, way->x, NULL);
        if (status == SN_OK) return SN_OK;
        sn_spline_fit_destroy(*out);
        *out = NULL;
        if (status != SN_ERROR_INPUT) return sn_fail_memory(error, "a fit");
    }
    return SN_OK;
}
