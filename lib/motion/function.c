/* function.c -- functions of one variable: polynomials, straight lines between knots, and OpenSim's spline. */
#include "sinew/skeleton.h"

#include <stdlib.h>

/* Knots nearer than this count as so far apart: what OpenSim does with knots that fall together. */
static const double LEAST_STEP = 1e-7;

struct sn_function {
    sn_function_kind kind;
    sn_index count;
    double scale;
    double *x, *y;     /* (count) knots; or coefficients in y, the highest power first */
    double *b, *c, *d; /* (count) between knots i and i + 1: y + u (b + u (c + u d)), u = t - x */
};

/* ---- the spline ---------------------------------------------------------------------------------------------------------------- */

static double step(const sn_function *f, sn_index from, sn_index to) { return fmax(LEAST_STEP, f->x[to] - f->x[from]); }

static double slope(const sn_function *f, sn_index i) { return (f->y[i + 1] - f->y[i]) / step(f, i, i + 1); }

/* (x_c - x_a) times the second divided difference of the points a, b = a + 1 and c = a + 2, over x_c - x_a */
static double bend(const sn_function *f, sn_index a) { return (slope(f, a + 1) - slope(f, a)) / step(f, a, a + 2); }

/* Rows of the tridiagonal system for s_i, a sixth of the second derivative at knot i: h_(i-1) s_(i-1) + 2 (h_(i-1) + h_i) s_i + h_i s_(i+1)
 * is the change of slope; at the ends -h s_0 + h s_1 is h^2 times the third divided difference of the four points there. */
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
static void fit_spline(sn_function *f) {
    sn_index last = f->count - 1;
    if (f->count == 2) {
        f->b[0] = f->b[1] = slope(f, 0);
        return;
    }
    set_rows(f, f->b, f->c);
    solve_rows(f, f->b, f->c);
    double end_step = step(f, last - 1, last);
    f->b[last] = slope(f, last - 1) + end_step * (f->c[last - 1] + 2.0 * f->c[last]);
    for (sn_index i = 0; i < last; i++) {
        double h = step(f, i, i + 1);
        f->b[i] = slope(f, i) - h * (f->c[i + 1] + 2.0 * f->c[i]);
        f->d[i] = (f->c[i + 1] - f->c[i]) / h;
    }
    for (sn_index i = 0; i <= last; i++) f->c[i] *= 3.0;
}

static void fit_lines(sn_function *f) {
    for (sn_index i = 0; i + 1 < f->count; i++) f->b[i] = slope(f, i);
    f->b[f->count - 1] = f->b[f->count - 2];
}

/* ---- all of them ----------------------------------------------------------------------------------------------------------------- */

static sn_status check_numbers(sn_function_kind kind, sn_index count, const double *x, const double *y, double scale, sn_error *error) {
    bool knots = kind != SN_FUNCTION_POLYNOMIAL;
    if (count < (knots ? 2 : 1)) return sn_fail(error, SN_ERROR_INPUT, "a function needs %s", knots ? "at least two knots" : "a coefficient");
    if (!isfinite(scale)) return sn_fail(error, SN_ERROR_INPUT, "the factor of a function is not finite");
    for (sn_index i = 0; i < count; i++) {
        if (!isfinite(y[i]) || (knots && !isfinite(x[i])))
            return sn_fail(error, SN_ERROR_INPUT, "number %d of a function is not finite", (int)i + 1);
        if (knots && i > 0 && x[i] < x[i - 1])
            return sn_fail(error, SN_ERROR_INPUT, "knot %d of a function is less than the one before it; sort the knots", (int)i + 1);
    }
    return SN_OK;
}

sn_status sn_function_create(sn_function_kind kind, sn_index count, const double *x, const double *y, double scale, sn_function **out,
                             sn_error *error) {
    *out = NULL;
    sn_status status = check_numbers(kind, count, x, y, scale, error);
    if (status != SN_OK) return status;
    sn_function *f = SN_NEW(sn_function, 1);
    double *numbers = SN_NEW(double, 5 * (size_t)count);
    if (f == NULL || numbers == NULL) {
        free(f);
        free(numbers);
        return sn_fail_memory(error, "a function");
    }
    *f = (sn_function){kind, count, scale, numbers, numbers + count, numbers + 2 * count, numbers + 3 * count, numbers + 4 * count};
    for (sn_index i = 0; i < count; i++) {
        f->x[i] = kind != SN_FUNCTION_POLYNOMIAL ? x[i] : 0.0;
        f->y[i] = y[i];
    }
    if (kind == SN_FUNCTION_SPLINE) fit_spline(f);
    if (kind == SN_FUNCTION_LINES) fit_lines(f);
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
    sn_index last = f->count - 1;
    if (t <= f->x[0]) return f->y[0] + (t - f->x[0]) * f->b[0];
    if (t >= f->x[last]) return f->y[last] + (t - f->x[last]) * f->b[last];
    sn_index i = find_knot(f, t);
    double u = t - f->x[i];
    return f->y[i] + u * (f->b[i] + u * (f->c[i] + u * f->d[i]));
}

double sn_function_at(const sn_function *f, double t) {
    return f->scale * (f->kind == SN_FUNCTION_POLYNOMIAL ? polynomial_at(f, t) : knots_at(f, t));
}

bool sn_function_constant(const sn_function *f) { return f->scale == 0.0 || (f->kind == SN_FUNCTION_POLYNOMIAL && f->count == 1); }

bool sn_function_identity(const sn_function *f) {
    return f->kind == SN_FUNCTION_POLYNOMIAL && f->count == 2 && f->scale * f->y[0] == 1.0;
}

void sn_function_free(sn_function *f) {
    if (f == NULL) return;
    free(f->x);
    free(f);
}
