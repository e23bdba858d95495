/*
 * exact.h -- elementary functions with the same bits on every machine.   rank 0
 *
 * The C library's exp, log, sin, ... are rounded almost always, not always, and glibc picks their code when the program starts: the last
 * bit of a result depends on whether the processor multiplies and adds in one step. What reaches an output calls none of them. sqrt, fabs,
 * floor, fmod, ldexp, ... are exact or correctly rounded everywhere and stay the C library's; a length in the plane is sqrt(x*x + y*y).
 */
#ifndef SINEW_EXACT_H
#define SINEW_EXACT_H

#include "sinew/base.h"

/* ---- correctly rounded --------------------------------------------------------------------------------------------------------- */

/*
 * The double nearest to the true value, over the whole range, subnormal results too; NaN, infinities, zeros and their signs as C17 Annex F
 * has them; errno is left alone. By MPFR (Fousse et al. 2007), some microseconds a call: for what is
 * evaluated once a frame, a bone or a fibre. Any thread may call them.
 */
double sn_exp(double x);
double sn_ln(double x); /* sn_log is for messages */
double sn_log2(double x);
double sn_log10(double x);
double sn_sin(double x);
double sn_cos(double x);
void sn_sincos(double x, double *sine, double *cosine);
double sn_tan(double x);
double sn_acos(double x);
double sn_atan2(double y, double x);
double sn_pow(double x, double y);

/* ---- nearly rounded ------------------------------------------------------------------------------------------------------------- */

/*
 * For what is evaluated for every vertex, edge or pixel: the same bits everywhere because only + - * / make them. atan2 and log take about
 * as long as the C library's, exp and pow two to four times as long (20 to 95 ns). Wrong by what each states in units of the last place
 * (test_exact measures it). NaN, infinities, zeros and their signs as C17 Annex F has them.
 */

/* The angle of the vector (x, y) in [-pi, pi], within 2.5 units. */
double sn_quick_atan2(double y, double x);
/* e^x within 1 unit. */
double sn_quick_exp(double x);
/* ln x within 1 unit; of a subnormal x within 2. */
double sn_quick_log(double x);
/* x^y for x >= 0 and y > 0, finite: within 2 + 3 |y ln x| units. */
double sn_quick_pow(double x, double y);
/* Within 1 unit each, for |x| <= 1e4; beyond that by sn_sincos. */
void sn_quick_sincos(double x, double *sine, double *cosine);

#endif
