/* numeric.c -- curves, splines by least squares, eigenvalues, robust fits (the only user of GSL). */
#include "sinew/numeric.h"

#include <gsl/gsl_bspline.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_interp.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_multifit_nlinear.h>
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

/* ---- spheres: in units of the points' spread about their mean ---------------------------------------------------------------- */

typedef struct sphere_points {
    sn_index count;
    const sn_vec3 *points;
    sn_vec3 mean;
    double spread; /* root mean square distance from the mean */
} sphere_points;

static sn_vec3 scaled_point(const sphere_points *s, size_t i) { return sn_scale(sn_sub(s->points[i], s->mean), 1.0 / s->spread); }

static bool scale_points(sphere_points *s) {
    double sum = 0.0;
    for (sn_index i = 0; i < s->count; i++) s->mean = sn_add_scaled(s->mean, s->points[i], 1.0 / s->count);
    for (sn_index i = 0; i < s->count; i++) sum += sn_norm2(sn_sub(s->points[i], s->mean));
    s->spread = sqrt(sum / s->count);
    return isfinite(s->spread) && s->spread > 1e-12 * (1.0 + sn_norm(s->mean));
}

/* |p|^2 = 2 c.p + k, k = r^2 - |c|^2: least squares by normal equations, which are well scaled here. x = c, r. */
static bool sphere_algebraic(const sphere_points *s, double x[4]) {
    double normal[16] = {0}, right[4] = {0};
    for (sn_index i = 0; i < s->count; i++) {
        sn_vec3 p = scaled_point(s, (size_t)i);
        const double row[4] = {2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0};
        for (int j = 0; j < 4; j++) {
            for (int k = 0; k < 4; k++) normal[4 * j + k] += row[j] * row[k];
            right[j] += row[j] * sn_norm2(p);
        }
    }
    gsl_matrix_view a = gsl_matrix_view_array(normal, 4, 4);
    gsl_vector_view b = gsl_vector_view_array(right, 4), solution = gsl_vector_view_array(x, 4);
    if (gsl_linalg_cholesky_decomp1(&a.matrix) != GSL_SUCCESS) return false;
    for (int j = 0; j < 4; j++)
        if (!(normal[5 * j] > 1e-5 * sqrt((double)s->count))) return false; /* flat: a direction that the points do not tell */
    if (gsl_linalg_cholesky_solve(&a.matrix, &b.vector, &solution.vector) != GSL_SUCCESS) return false;
    double square = x[3] + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    x[3] = sqrt(square);
    return isfinite(x[3]) && square > 0.0;
}

static int sphere_residuals(const gsl_vector *x, void *data, gsl_vector *f) {
    const sphere_points *s = data;
    sn_vec3 c = sn_v3(gsl_vector_get(x, 0), gsl_vector_get(x, 1), gsl_vector_get(x, 2));
    for (size_t i = 0; i < (size_t)s->count; i++) gsl_vector_set(f, i, sn_distance(scaled_point(s, i), c) - gsl_vector_get(x, 3));
    return GSL_SUCCESS;
}

static int sphere_slopes(const gsl_vector *x, void *data, gsl_matrix *slopes) {
    const sphere_points *s = data;
    sn_vec3 c = sn_v3(gsl_vector_get(x, 0), gsl_vector_get(x, 1), gsl_vector_get(x, 2));
    for (size_t i = 0; i < (size_t)s->count; i++) {
        sn_vec3 out = sn_normalize(sn_sub(scaled_point(s, i), c));
        gsl_matrix_set(slopes, i, 0, -out.x);
        gsl_matrix_set(slopes, i, 1, -out.y);
        gsl_matrix_set(slopes, i, 2, -out.z);
        gsl_matrix_set(slopes, i, 3, -1.0);
    }
    return GSL_SUCCESS;
}

/* x, the algebraic fit, becomes the geometric one. Out of iterations the fit at hand is still a good one. */
static bool sphere_geometric(const sphere_points *s, double x[4]) {
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.solver = gsl_multifit_nlinear_solver_cholesky; /* sums and roots alone: the same bits everywhere */
    gsl_multifit_nlinear_fdf problem = {
        .f = sphere_residuals, .df = sphere_slopes, .n = (size_t)s->count, .p = 4, .params = (void *)(uintptr_t)s};
    gsl_multifit_nlinear_workspace *work = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, problem.n, 4);
    if (work == NULL) return false;
    gsl_vector_view start = gsl_vector_view_array(x, 4);
    int info = 0;
    bool good = gsl_multifit_nlinear_init(&start.vector, &problem, work) == GSL_SUCCESS;
    if (good) gsl_multifit_nlinear_driver(100, 1e-12, 1e-12, 0.0, NULL, NULL, &info, work);
    for (size_t j = 0; good && j < 4; j++) x[j] = gsl_vector_get(gsl_multifit_nlinear_position(work), j);
    gsl_multifit_nlinear_free(work);
    return good && isfinite(x[0] + x[1] + x[2] + x[3]) && x[3] > 0.0;
}

bool sn_least_squares_sphere(sn_index count, const sn_vec3 *points, sn_vec3 *centre, double *radius) {
    sphere_points s = {.count = count, .points = points};
    double x[4] = {0};
    gsl_set_error_handler_off();
    if (count < 4 || !scale_points(&s) || !sphere_algebraic(&s, x) || !sphere_geometric(&s, x)) return false;
    *centre = sn_add_scaled(s.mean, sn_v3(x[0], x[1], x[2]), s.spread);
    *radius = x[3] * s.spread;
    return true;
}

/* ---- splines by least squares --------------------------------------------------------------------------------------------------- */

enum { SPLINE_ORDER = 4 }; /* cubic: as many B-splines are not 0 at any place */
/* A pivot of the normal equations this much smaller than the largest is a coefficient that the data does not tell. */
#define SPLINE_LEAST_PIVOT 1e-6

typedef struct spline_row {
    size_t first;                /* of the B-splines that are not 0 */
    double values[SPLINE_ORDER]; /* theirs */
} spline_row;

struct sn_spline_fit {
    double low, high;
    size_t size;
    gsl_bspline_workspace *basis;
    gsl_matrix *nonzero, *factor; /* (order x 2): values and slopes at one place; (size x size): Cholesky's */
    gsl_vector *work;             /* (size) */
    sn_index count;
    spline_row *rows; /* (count) of the design */
};

sn_status sn_spline_fit_create(double low, double high, sn_index intervals, sn_spline_fit **out, sn_error *error) {
    *out = NULL;
    if (!isfinite(low) || !isfinite(high) || !(low < high) || intervals < 1)
        return sn_fail(error, SN_ERROR_USAGE, "no spline of %d pieces from %g to %g", intervals, low, high);
    gsl_set_error_handler_off();
    sn_spline_fit *fit = *out = SN_NEW(sn_spline_fit, 1);
    if (fit == NULL) return sn_fail_memory(error, "a spline");
    *fit = (sn_spline_fit){.low = low, .high = high, .size = (size_t)intervals + SPLINE_ORDER - 1};
    fit->basis = gsl_bspline_alloc(SPLINE_ORDER, (size_t)intervals + 1);
    fit->nonzero = gsl_matrix_alloc(SPLINE_ORDER, 2);
    fit->factor = gsl_matrix_alloc(fit->size, fit->size);
    fit->work = gsl_vector_alloc(fit->size);
    if (fit->basis != NULL && fit->nonzero != NULL && fit->factor != NULL && fit->work != NULL &&
        gsl_bspline_knots_uniform(low, high, fit->basis) == GSL_SUCCESS)
        return SN_OK;
    sn_spline_fit_destroy(fit);
    *out = NULL;
    return sn_fail_memory(error, "a spline");
}

void sn_spline_fit_destroy(sn_spline_fit *fit) {
    if (fit == NULL) return;
    if (fit->basis != NULL) gsl_bspline_free(fit->basis);
    gsl_matrix_free(fit->nonzero);
    gsl_matrix_free(fit->factor);
    gsl_vector_free(fit->work);
    free(fit->rows);
    free(fit);
}

sn_index sn_spline_fit_size(const sn_spline_fit *fit) { return (sn_index)fit->size; }

/* The B-splines that are not 0 at x, or their slopes (derivative 1). */
static spline_row spline_row_at(const sn_spline_fit *fit, double x, size_t derivative) {
    spline_row row = {0};
    size_t last;
    /* cannot fail inside the domain */
    gsl_bspline_deriv_eval_nonzero(fmin(fmax(x, fit->low), fit->high), 1, fit->nonzero, &row.first, &last, fit->basis);
    for (size_t j = 0; j < SPLINE_ORDER; j++) row.values[j] = gsl_matrix_get(fit->nonzero, j, derivative);
    return row;
}

static void add_to_normal(gsl_matrix *normal, const spline_row *row) {
    for (size_t j = 0; j < SPLINE_ORDER; j++)
        for (size_t k = 0; k < SPLINE_ORDER; k++)
            *gsl_matrix_ptr(normal, row->first + j, row->first + k) += row->values[j] * row->values[k];
}

static bool factor_normal(const sn_spline_fit *fit) {
    double least = INFINITY, most = 0.0;
    if (gsl_linalg_cholesky_decomp1(fit->factor) != GSL_SUCCESS) return false;
    for (size_t j = 0; j < fit->size; j++) {
        least = fmin(least, gsl_matrix_get(fit->factor, j, j));
        most = fmax(most, gsl_matrix_get(fit->factor, j, j));
    }
    return least > SPLINE_LEAST_PIVOT * most;
}

sn_status sn_spline_fit_design(sn_spline_fit *fit, sn_index count, const double *x, sn_error *error) {
    free(fit->rows);
    fit->count = count;
    fit->rows = SN_NEW(spline_row, count);
    if (fit->rows == NULL) return sn_fail_memory(error, "a spline");
    gsl_matrix_set_zero(fit->factor);
    for (sn_index i = 0; i < count; i++) {
        fit->rows[i] = spline_row_at(fit, x[i], 0);
        add_to_normal(fit->factor, &fit->rows[i]);
    }
    return factor_normal(fit)
               ? SN_OK
               : sn_fail(error, SN_ERROR_INPUT, "%d values do not determine a spline of %d coefficients", count, (int)fit->size);
}

static double spline_sum(const spline_row *row, const double *coefficients) {
    double sum = 0.0;
    for (size_t j = 0; j < SPLINE_ORDER; j++) sum += row->values[j] * coefficients[row->first + j];
    return sum;
}

double sn_spline_fit_solve(const sn_spline_fit *fit, const double *y, double *coefficients) {
    gsl_vector_view solution = gsl_vector_view_array(coefficients, fit->size);
    double mean = 0.0, left = 0.0;
    for (sn_index i = 0; i < fit->count; i++) mean += y[i] / fit->count; /* taken off: the B-splines of any place sum to 1 */
    gsl_vector_set_zero(&solution.vector);
    for (sn_index i = 0; i < fit->count; i++)
        for (size_t j = 0; j < SPLINE_ORDER; j++) coefficients[fit->rows[i].first + j] += fit->rows[i].values[j] * (y[i] - mean);
    gsl_linalg_cholesky_svx(fit->factor, &solution.vector);
    for (size_t j = 0; j < fit->size; j++) coefficients[j] += mean;
    for (sn_index i = 0; i < fit->count; i++) {
        double off = y[i] - spline_sum(&fit->rows[i], coefficients);
        left += off * off;
    }
    return left;
}

double sn_spline_fit_at(const sn_spline_fit *fit, const double *coefficients, double x, double *slope) {
    spline_row row = spline_row_at(fit, x, 1);
    if (slope != NULL) *slope = spline_sum(&row, coefficients);
    row = spline_row_at(fit, x, 0);
    return spline_sum(&row, coefficients);
}

/* |L^-1 b'|, L L^T the normal equations. */
double sn_spline_fit_slope_error(const sn_spline_fit *fit, double x) {
    spline_row row = spline_row_at(fit, x, 1);
    double sum = 0.0;
    gsl_vector_set_zero(fit->work);
    for (size_t j = 0; j < SPLINE_ORDER; j++) gsl_vector_set(fit->work, row.first + j, row.values[j]);
    for (size_t j = 0; j < fit->size; j++) { /* forward substitution */
        double value = gsl_vector_get(fit->work, j);
        for (size_t k = 0; k < j; k++) value -= gsl_matrix_get(fit->factor, j, k) * gsl_vector_get(fit->work, k);
        value /= gsl_matrix_get(fit->factor, j, j);
        gsl_vector_set(fit->work, j, value);
        sum += value * value;
    }
    return sqrt(sum);
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
