/*
 * moment_arm.h -- the rows of one way of a coordinate, and fits to them. Private to lib/motion.
 */
#ifndef SN_MOTION_MOMENT_ARM_H
#define SN_MOTION_MOMENT_ARM_H

#include "sinew/moment_arm.h"

/* Rows to fit to, in order: all of them, or those of the sweeps one way. */
typedef struct arm_way {
    sn_index count;
    sn_index *rows;   /* (count) owned */
    double *x;        /* (count) owned: the coordinate there */
    double low, high; /* of x */
    sn_index angles;  /* different values in x */
} arm_way;
/* Takes rows, also where it fails. */
SN_MUST_CHECK sn_status sn_arm_way_make(const double *coordinate, sn_index *rows, sn_index count, arm_way *out, sn_error *error);
void sn_arm_way_free(arm_way *way); /* leaves all zeros */
/* Is there room for `pieces` pieces, with four angles for each? */
bool sn_arm_way_holds(const arm_way *way, sn_index pieces);

/* A fit to some values at a way's rows. */
typedef struct arm_fit {
    sn_index count; /* values */
    double left;    /* sum of the squares of what is left */
    bool determined;
} arm_fit;
/* Fit `values` (by row; NaN = not there) with the pieces of `whole`, which is designed for all rows of the way and spans it. */
SN_MUST_CHECK sn_status sn_arm_fit_values(const sn_spline_fit *whole, const arm_way *way, const double *values, double *coefficients,
                                          arm_fit *out, sn_error *error);
/* Pieces of [low, high] of the way, at most `pieces`, that its rows determine: *out, NULL where there are none. */
SN_MUST_CHECK sn_status sn_arm_design(const arm_way *way, sn_index *pieces, sn_spline_fit **out, sn_error *error);

/* How the others move (lib/motion/arm_company.c): company (other_count). ways: those that are fitted alone. */
SN_MUST_CHECK sn_status sn_arm_company_find(const sn_arm_input *input, const arm_way *ways, int way_count, sn_arm_company *company,
                                            sn_error *error);
/* What they can have done to the muscle: kind, other, other_bound. way: the coordinate is one. */
void sn_arm_judge(const sn_arms *arms, bool is_way, sn_muscle_arms *muscle);

#endif
