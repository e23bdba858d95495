/* function.c -- functions of one variable: polynomials, straight lines between knots, and OpenSim's spline. */
#include "sinew/skeleton.h"

#include <stdlib.h>
#include <string.h>

/* Knots nearer than this count as so far apart: what OpenSim does with knots that fall together. */
static const double LEAST_STEP = 1e-7;

struct sn_function {
    sn_function_kind kind;
    sn_index count;
    double scale;
    double *y; /* (count) at the knots; or coefficients, the highest power first. All arrays are one block */
    double *x; /* (count) knots; NULL = a polynomial */
    double *s; /* (count) a sixth of the second derivative at the knots: none where lines go straight */
};

static double step(const sn_function *f, sn_index from, sn_index to) { return fmax(LEAST_STEP, f->x[to] - f->x[from]); }

static double slope(const sn_function *f, sn_index i) { return (f->y[i + 1] - f->y[i]) / step(f, i, i + 1); }

/* ---- the spline ---------------------------------------------------------------------------------------------------------------- */

/* The second divided difference of points a, a + 1 and a + 2. */
static double bend(const sn_function *f, sn_index a) { return (slope(f, a + 1) - slope(f, a)) / step(f, a, a + 2); }

/* Rows of the tridiagonal system for s: h_(i-1) s_(i-1) + 2 (h_(i-1) + h_i) s_i + h_i s_(i+1) is the change of slope at knot i; at the ends
 * -h s_0 + h s_1 is h^2 times the third divided difference of the four points there. */
static void set_rows(const sn_function *f, double *diagonal, double *right) {
    sn_index last = f->count - 1;
    double first_step = step(f, 0, 1), last_step = step(f, last - 1, last);
    diagonal[0] = -first_step;
    diagonal[last] = -last_step;
    right[0] = right[last] = 0.0;
    for (sn_index i = 1; i < last; i++) {
        diagonal[i] = 2.0 * (step(f, i - 1, i) + step(f, i, i + 1));
        right[i] = slope(f, i) - slope(f, i - 1);
    }
    if (f->count < 4) return;
    right[0] = (bend(f, 1) - bend(f, 0)) * first_step * first_step / step(f, 0, 3);
    right[last] = -(bend(f, last - 2) - bend(f, last - 3)) * last_step * last_step / step(f, last - 3, last);
}

static void solve_rows(const sn_function *f, double *diagonal, double *s) {
    for (sn_index i = 1; i < f->count; i++) {
        double h = step(f, i - 1, i), factor = h / diagonal[i - 1];
        diagonal[i] -= factor * h;
        s[i] -= factor * s[i - 1];
    }
    s[f->count - 1] /= diagonal[f->count - 1];
    for (sn_index i = f->count - 2; i >= 0; i--) s[i] = (s[i] - step(f, i, i + 1) * s[i + 1]) / diagonal[i];
}

/* Forsythe, Malcolm, Moler 1977, ch. 4.4. */
static sn_status fit_spline(sn_function *f, sn_error *error) {
    if (f->count == 2) return SN_OK;
    double *diagonal = SN_NEW(double, f->count);
    if (diagonal == NULL) return sn_fail_memory(error, "a function");
    set_rows(f, diagonal, f->s);
    solve_rows(f, diagonal, f->s);
    free(diagonal);
    for (sn_index i = 0; i < f->count; i++)
        if (!isfinite(f->s[i])) return sn_fail(error, SN_ERROR_INPUT, "the numbers of a spline are too large");
    return SN_OK;
}

/* ---- all of them ----------------------------------------------------------------------------------------------------------------- */

static sn_status check_numbers(sn_function_kind kind, sn_function_numbers n, double scale, sn_error *error) {
    bool knots = kind != SN_FUNCTION_POLYNOMIAL;
    if (n.count < (knots ? 2 : 1))
        return sn_fail(error, SN_ERROR_INPUT, "a function needs %s", knots ? "at least two knots" : "a coefficient");
    if (!isfinite(scale)) return sn_fail(error, SN_ERROR_INPUT, "the factor of a function is not finite");
    for (sn_index i = 0; i < n.count; i++) {
        if (!isfinite(n.y[i]) || (knots && !isfinite(n.x[i])))
            return sn_fail(error, SN_ERROR_INPUT, "number %d of a function is not finite", (int)i + 1);
        if (knots && i > 0 && n.x[i] < n.x[i - 1])
            return sn_fail(error, SN_ERROR_INPUT, "knot %d of a function is less than the one before it; sort the knots", (int)i + 1);
    }
    return SN_OK;
}

sn_status sn_function_create(sn_function_kind kind, sn_function_numbers n, double scale, sn_function **out, sn_error *error) {
    *out = NULL;
    sn_status status = check_numbers(kind, n, scale, error);
    if (status != SN_OK) return status;
    bool knots = kind != SN_FUNCTION_POLYNOMIAL;
    sn_function *f = SN_NEW(sn_function, 1);
    double *numbers = SN_NEW(double, (knots ? 3 : 1) * (size_t)n.count);
    if (f == NULL || numbers == NULL) {
        free(f);
        free(numbers);
        return sn_fail_memory(error, "a function");
    }
    *f = (sn_function){kind, n.count, scale, numbers, knots ? numbers + n.count : NULL, knots ? numbers + 2 * n.count : NULL};
    memcpy(f->y, n.y, (size_t)n.count * sizeof *n.y);
    if (knots) memcpy(f->x, n.x, (size_t)n.count * sizeof *n.x);
    if (kind == SN_FUNCTION_SPLINE && (status = fit_spline(f, error)) != SN_OK) {
        sn_function_free(f);
        return status;
    }
    *out = f;
    return SN_OK;
}

static double polynomial_at(const sn_function *f, double t) {
    double value = 0.0;
    for (sn_index i = 0; i < f->count; i++) value = value * t + f->y[i];
    return value;
}

/* The last knot that is not past t. */
static sn_index find_knot(const sn_function *f, double t) {
    sn_index low = 0, high = f->count - 1;
    while (high - low > 1) {
        sn_index middle = low + (high - low) / 2;
        if (t < f->x[middle])
            high = middle;
        else
            low = middle;
    }
    return low;
}

static double knots_at(const sn_function *f, double t) {
    sn_index last = f->count - 1, i = find_knot(f, t);
    double h = step(f, i, i + 1), u = t - f->x[i], before = f->s[i], after = f->s[i + 1];
    double first_slope = slope(f, i) - h * (after + 2.0 * before);
    if (u <= 0.0) return f->y[i] + u * first_slope;
    if (t >= f->x[last]) return f->y[last] + (t - f->x[last]) * (slope(f, i) + h * (before + 2.0 * after));
    return f->y[i] + u * (first_slope + u * (3.0 * before + u * (after - before) / h));
}

double sn_function_at(const sn_function *f, double t) { return f->scale * (f->x == NULL ? polynomial_at(f, t) : knots_at(f, t)); }

bool sn_function_constant(const sn_function *f) { return f->scale == 0.0 || (f->x == NULL && f->count == 1); }

bool sn_function_identity(const sn_function *f) { return f->x == NULL && f->count == 2 && f->scale * f->y[0] == 1.0; }

void sn_function_free(sn_function *f) {
    if (f == NULL) return;
    free(f->y);
    free(f);
}
