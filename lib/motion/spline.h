/*
 * spline.h -- splines of the 5th degree through evenly spaced values. Private to lib/motion.
 */
#ifndef SN_MOTION_SPLINE_H
#define SN_MOTION_SPLINE_H

#include "sinew/base.h"

enum { SN_SPLINE_DEGREE = 5, SN_SPLINE_MOST = SN_SPLINE_DEGREE + 1 };

/* The splines through values at 0, 1, ..., count - 1 that have no knot at the two next to each end (de Boor 1978: "not a knot"): what is
 * a polynomial of the 5th degree comes back as such, beyond the ends too. Fewer than six values give the polynomial through them. */
typedef struct sn_spline {
    sn_index count;
    int degree;
    double *factors; /* (count) x (2 degree + 1): of the banded matrix that makes coefficients from values */
} sn_spline;

SN_MUST_CHECK sn_status sn_spline_create(sn_index count, sn_spline *out, sn_error *error);
void sn_spline_free(sn_spline *spline);
/* Values (count) become coefficients, in place. */
void sn_spline_solve(const sn_spline *spline, double *values);
/* The weights (degree + 1) of the coefficients *first, *first + 1, ... at x; a little beyond the ends too. */
void sn_spline_weights(const sn_spline *spline, double x, sn_index *first, double weights[SN_SPLINE_MOST]);

#endif
