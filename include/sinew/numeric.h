/*
 * numeric.h -- curves, splines by least squares, robust fits, small eigenproblems (hides GSL).   rank 0
 */
#ifndef SINEW_NUMERIC_H
#define SINEW_NUMERIC_H

#include "sinew/vec.h"

/* A monotone interpolating curve through (x_i, y_i): Steffen's method, which never leaves the data's range between two knots;
 * two knots give a straight line, one a constant; outside its domain the end values hold. */
typedef struct sn_curve sn_curve;
/* x strictly ascending, x and y finite, count >= 1; both are copied. */
SN_MUST_CHECK sn_status sn_curve_create(sn_index count, const double *x, const double *y, sn_curve **out, sn_error *error);
void sn_curve_destroy(sn_curve *curve); /* NULL is fine */
double sn_curve_at(const sn_curve *curve, double x);

/* Eigenvalues (ascending) and unit eigenvectors (columns of vectors) of a symmetric 3 x 3 matrix; false if it is not finite. */
bool sn_eigen_symmetric3(const sn_mat3 *matrix, double values[3], sn_mat3 *vectors);

/* Robust straight-line fit y = intercept + slope x (bisquare weights); false for fewer than 3 points or constant x. */
bool sn_fit_line_robust(sn_index count, const double *x, const double *y, double *intercept, double *slope);

/* The sphere with the least sum of squared distances of points (count) from its surface: algebraic fit, then Levenberg-Marquardt on the
 * distances themselves. False for fewer than 4 points, or where they lie in a plane or do not tell the radius. */
bool sn_least_squares_sphere(sn_index count, const sn_vec3 *points, sn_vec3 *centre, double *radius);

/*
 * A cubic spline by least squares: `intervals` equal pieces of [low, high], so intervals + 3 coefficients (GSL's B-splines; normal
 * equations by Cholesky's method). One design serves any number of right sides.
 */
typedef struct sn_spline_fit sn_spline_fit;
/* low < high, both finite, intervals >= 1. */
SN_MUST_CHECK sn_status sn_spline_fit_create(double low, double high, sn_index intervals, sn_spline_fit **out, sn_error *error);
void sn_spline_fit_destroy(sn_spline_fit *fit);        /* NULL is fine */
sn_index sn_spline_fit_size(const sn_spline_fit *fit); /* number of coefficients */
/* Take x (count), each within [low, high], in any order, also the same again. SN_ERROR_INPUT: they do not determine the coefficients. */
SN_MUST_CHECK sn_status sn_spline_fit_design(sn_spline_fit *fit, sn_index count, const double *x, sn_error *error);
/* Coefficients (size) of the spline nearest to y (count of the design), finite; returns the sum of the squares of what is left. */
double sn_spline_fit_solve(const sn_spline_fit *fit, const double *y, double *coefficients);
/* Value and slope (nullable) at x, which is taken into [low, high]. */
double sn_spline_fit_at(const sn_spline_fit *fit, const double *coefficients, double x, double *slope);
/* Standard error of the slope at x where y has independent errors of standard deviation 1. */
double sn_spline_fit_slope_error(const sn_spline_fit *fit, double x);

/* The first `count` points of the Sobol sequence in [0,1)^dimensions, 1 to 40: out (count x dimensions). Evenly spread, always the same. */
SN_MUST_CHECK sn_status sn_sobol(sn_index dimensions, sn_index count, double *out, sn_error *error);

#endif
