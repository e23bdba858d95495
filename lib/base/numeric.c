/* numeric.c -- curves, eigenvalues, robust fits (the only user of GSL). */
#include "sinew/numeric.h"

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_interp.h>
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_qrng.h>
#include <stdlib.h>
#include <string.h>

struct sn_curve {
    sn_index count;
    double *x, *y;       /* (count) */
    gsl_interp *steffen; /* NULL for fewer than 3 knots */
};

static sn_status check_knots(sn_index count, const double *x, const double *y, sn_error *error) {
    if (count < 1) return sn_fail(error, SN_ERROR_INPUT, "a curve needs at least one knot");
    for (sn_index i = 0; i < count; i++) {
        if (!isfinite(x[i]) || !isfinite(y[i])) return sn_fail(error, SN_ERROR_INPUT, "knot %d of a curve is not finite", i);
        if (i > 0 && !(x[i] > x[i - 1]))
            return sn_fail(error, SN_ERROR_INPUT, "knots of a curve must ascend, but knot %d is at %g after %g", i, x[i], x[i - 1]);
    }
    return SN_OK;
}

/* GSL's default handler aborts the process: off, and every status is looked at instead. */
static sn_status make_steffen(sn_curve *curve, sn_error *error) {
    if (curve->count < 3) return SN_OK;
    gsl_set_error_handler_off();
    curve->steffen = gsl_interp_alloc(gsl_interp_steffen, (size_t)curve->count);
    if (curve->steffen == NULL) return sn_fail_memory(error, "a curve");
    if (gsl_interp_init(curve->steffen, curve->x, curve->y, (size_t)curve->count) != GSL_SUCCESS)
        return sn_fail(error, SN_ERROR_INTERNAL, "no monotone curve through these knots");
    return SN_OK;
}

sn_status sn_curve_create(sn_index count, const double *x, const double *y, sn_curve **out, sn_error *error) {
    *out = NULL;
    sn_status status = check_knots(count, x, y, error);
    if (status != SN_OK) return status;
    sn_curve *curve = SN_NEW(sn_curve, 1);
    if (curve == NULL) return sn_fail_memory(error, "a curve");
    curve->count = count;
    curve->x = SN_NEW(double, count);
    curve->y = SN_NEW(double, count);
    if (curve->x == NULL || curve->y == NULL) {
        status = sn_fail_memory(error, "a curve");
        goto failed;
    }
    memcpy(curve->x, x, (size_t)count * sizeof *x);
    memcpy(curve->y, y, (size_t)count * sizeof *y);
    status = make_steffen(curve, error);
    if (status != SN_OK) goto failed;
    *out = curve;
    return SN_OK;
failed:
    sn_curve_destroy(curve);
    return status;
}

void sn_curve_destroy(sn_curve *curve) {
    if (curve == NULL) return;
    if (curve->steffen != NULL) gsl_interp_free(curve->steffen);
    free(curve->x);
    free(curve->y);
    free(curve);
}

double sn_curve_at(const sn_curve *curve, double x) {
    sn_index last = curve->count - 1;
    if (!(x > curve->x[0])) return curve->y[0];
    if (x >= curve->x[last]) return curve->y[last];
    if (curve->steffen == NULL) {
        double t = (x - curve->x[0]) / (curve->x[1] - curve->x[0]);
        return curve->y[0] + t * (curve->y[1] - curve->y[0]);
    }
    double y = 0.0;
    gsl_interp_eval_e(curve->steffen, curve->x, curve->y, x, NULL, &y); /* cannot fail inside the domain */
    return y;
}

bool sn_eigen_symmetric3(const sn_mat3 *matrix, double values[3], sn_mat3 *vectors) {
    double a[9], v[9], d[3];
    for (int i = 0; i < 9; i++) {
        a[i] = matrix->m[i / 3][i % 3];
        if (!isfinite(a[i])) return false;
    }
    gsl_set_error_handler_off();
    gsl_eigen_symmv_workspace *work = gsl_eigen_symmv_alloc(3);
    if (work == NULL) return false;
    gsl_matrix_view av = gsl_matrix_view_array(a, 3, 3), vv = gsl_matrix_view_array(v, 3, 3);
    gsl_vector_view dv = gsl_vector_view_array(d, 3);
    bool good = gsl_eigen_symmv(&av.matrix, &dv.vector, &vv.matrix, work) == GSL_SUCCESS;
    gsl_eigen_symmv_free(work);
    if (!good) return false;
    gsl_eigen_symmv_sort(&dv.vector, &vv.matrix, GSL_EIGEN_SORT_VAL_ASC);
    for (int i = 0; i < 9; i++) vectors->m[i / 3][i % 3] = v[i];
    memcpy(values, d, sizeof d);
    return true;
}

/* GSL's fit over constant x returns success and NaN: ask first. */
static bool varies(sn_index count, const double *x) {
    for (sn_index i = 1; i < count; i++)
        if (x[i] != x[0]) return true;
    return false;
}

bool sn_fit_line_robust(sn_index count, const double *x, const double *y, double *intercept, double *slope) {
    if (count < 3 || !varies(count, x)) return false;
    gsl_set_error_handler_off();
    size_t n = (size_t)count;
    gsl_matrix *design = gsl_matrix_alloc(n, 2), *covariance = gsl_matrix_alloc(2, 2);
    gsl_vector *values = gsl_vector_alloc(n), *line = gsl_vector_alloc(2);
    gsl_multifit_robust_workspace *work = gsl_multifit_robust_alloc(gsl_multifit_robust_bisquare, n, 2);
    bool good = design != NULL && covariance != NULL && values != NULL && line != NULL && work != NULL;
    for (size_t i = 0; good && i < n; i++) {
        gsl_matrix_set(design, i, 0, 1.0);
        gsl_matrix_set(design, i, 1, x[i]);
        gsl_vector_set(values, i, y[i]);
    }
    int status = good ? gsl_multifit_robust(design, values, line, covariance, work) : GSL_ENOMEM;
    good = good && (status == GSL_SUCCESS || status == GSL_EMAXITER); /* out of iterations: the fit at hand is still robust */
    if (good) {
        *intercept = gsl_vector_get(line, 0);
        *slope = gsl_vector_get(line, 1);
        good = isfinite(*intercept) && isfinite(*slope);
    }
    if (work != NULL) gsl_multifit_robust_free(work);
    gsl_vector_free(line);
    gsl_vector_free(values);
    gsl_matrix_free(covariance);
    gsl_matrix_free(design);
    return good;
}

sn_status sn_sobol(sn_index dimensions, sn_index count, double *out, sn_error *error) {
    if (dimensions < 1 || dimensions > 40)
        return sn_fail(error, SN_ERROR_USAGE, "a Sobol sequence has 1 to 40 dimensions, not %d", dimensions);
    gsl_set_error_handler_off();
    gsl_qrng *sequence = gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)dimensions);
    if (sequence == NULL) return sn_fail_memory(error, "a Sobol sequence");
    sn_status status = SN_OK;
    for (sn_index i = 0; i < count && status == SN_OK; i++)
        if (gsl_qrng_get(sequence, out + (size_t)i * (size_t)dimensions) != GSL_SUCCESS)
            status = sn_fail(error, SN_ERROR_INTERNAL, "the Sobol sequence ends at point %d", i);
    gsl_qrng_free(sequence);
    return status;
}
