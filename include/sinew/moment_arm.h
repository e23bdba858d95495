/*
 * moment_arm.h -- moment arms out of lengths over a coordinate: -dl/dtheta by splines, sweep by sweep; against measured curves.   rank 2
 *
 * The arm of a line about a coordinate is r = -dl/dtheta, l its length, all other coordinates held (Delp and Loan 1995; An et al. 1984,
 * "tendon excursion"). Lengths are metres. A coordinate is in radians, its arms in metres; or, where it is a way, in metres, its arms
 * without a unit.
 */
#ifndef SINEW_MOMENT_ARM_H
#define SINEW_MOMENT_ARM_H

#include "sinew/numeric.h"
#include "sinew/trace.h"

/* ---- sweeps --------------------------------------------------------------------------------------------------------------------- */

/* Rows first .. last, over which a coordinate goes one way. */
typedef struct sn_sweep {
    sn_index first, last;
    bool up;
} sn_sweep;

typedef struct sn_sweeps {
    sn_index count;
    sn_sweep *items; /* (count) owned, in order */
} sn_sweeps;

#define SN_SWEEP_TURN 0.05  /* a way back of this share of the whole range, or more, is a sweep of its own */
#define SN_SWEEP_STILL 1e-3 /* rows that stay within this share of the range of where a sweep turns belong to no sweep */
/* Part the rows by where x turns. Rows that are NaN are passed over. A coordinate that does not move has no sweep. */
SN_MUST_CHECK sn_status sn_sweeps_find(sn_index count, const double *x, sn_sweeps *out, sn_error *error);
void sn_sweeps_free(sn_sweeps *sweeps); /* leaves all zeros */

/* ---- arms ----------------------------------------------------------------------------------------------------------------------- */

/* Another coordinate of the same motion. */
typedef struct sn_arm_other {
    const char *name;
    const double *values; /* (row_count) radians or metres; NaN = not told there */
    double least;         /* it moves where its range is this or more */
} sn_arm_other;

typedef struct sn_arm_input {
    sn_index row_count;
    const double *coordinate; /* (row_count) in the order of the motion; NaN = the row is not used */
    sn_index fiber_count;
    const double *const *lengths; /* (fiber_count) x (row_count) metres; NaN = not told there */
    sn_index muscle_count;
    const char *const *muscles; /* (muscle_count) */
    const sn_index *muscle_of;  /* (fiber_count) */
    sn_index other_count;
    const sn_arm_other *others; /* (other_count) */
} sn_arm_input;

typedef struct sn_arm_params {
    sn_index knots;   /* of each spline, both ends among them; 0 = by rule, muscle by muscle (see sn_moment_arms) */
    sn_index samples; /* angles at which arms are told, evenly from the least to the greatest; at least 2 */
    bool is_way;      /* the coordinate is a way in metres, no angle */
    sn_trace *trace;  /* nullable: a step "muscle" each */
} sn_arm_params;
#define SN_ARM_PARAMS ((sn_arm_params){.samples = 91})
#define SN_ARM_LEAST_ANGLE (SN_PI / 180.0) /* the coordinate must move by this */
#define SN_ARM_LEAST_WAY 1e-3              /* m; or by this */

enum { SN_ARM_MOST_KNOTS = 41, SN_ARM_FEWEST_ANGLES = 8 };

/* What is known of a muscle's dependence on the other coordinates. */
typedef enum sn_arm_kind {
    SN_ARM_ALONE,   /* no other known coordinate moves, or those that do can have changed the arm by less than the bound */
    SN_ARM_WITH_IT, /* one moves along with the coordinate: what it does cannot be told apart */
    SN_ARM_MIXED    /* one moves, and at one angle the lengths differ as they would where the muscle depends on it */
} sn_arm_kind;
extern const char *const sn_arm_kind_names[]; /* "alone", "alongWithIt", "mixed"; NULL at the end */

/* Arrays of (sample_count), over the fibres that have lengths there: NaN where there is no row near, see sn_arms.gap_count. */
typedef struct sn_muscle_arms {
    sn_index fiber_count, knots;
    double *mean, *spread, *lower, *upper; /* over the fibres: mean, standard deviation (n - 1; 0 of one), least, greatest */
    double *noise;                         /* standard error of a fibre's arm, root mean square over the fibres */
    double *up, *down;                     /* mean of the fits to one way alone; NaN beyond its angles, and where there is none */
    double residual;                       /* m, root mean square of lengths from the fits, all rows and fibres */
    double sweep_residual;                 /* the same from the fits to either way alone, where there are both */
    double variation;                      /* m, root mean square of lengths from their means */
    double stretch;                        /* greatest over least length of a fibre, at most */
    double noise_mean;                     /* root mean square of noise */
    double range, largest;                 /* of the mean arm: greatest - least; greatest size */
    double hysteresis, hysteresis_rms;     /* greatest and root mean square of |up - down|; NaN where there are not both */
    sn_index missing;                      /* lengths of its fibres that are not told */
    sn_arm_kind kind;
    sn_index other;     /* which of the others decided; SN_NONE */
    double other_bound; /* what that one can have added to the arm; infinity = anything */
    sn_spline_fit *fit; /* of all rows */
} sn_muscle_arms;

/* How another coordinate moves. */
typedef struct sn_arm_company {
    double range;     /* greatest - least */
    double explained; /* share of its variance that is a curve of the coordinate's, 0 to 1; NaN where it does not move */
    double apart;     /* root mean square of what is not */
    double slope;     /* root mean square of the slope of that curve */
    bool moves;
} sn_arm_company;

typedef struct sn_arms {
    sn_index sample_count, fiber_count, muscle_count, other_count; /* muscle_count: done; fewer than asked where the trace has stopped it */
    double low, high;                                              /* of the coordinate */
    sn_index angle_count;                                          /* different values that it has */
    double *angles;                                                /* (sample_count) */
    sn_index gap_count;                                            /* samples in a gap: a tenth of the range or more without a row */
    double widest_gap, gap_from;
    sn_sweeps sweeps;
    bool has_up, has_down;          /* enough rows for a fit to that way alone */
    sn_index muscle_room;           /* muscles that were asked for */
    sn_muscle_arms *muscles;        /* (muscle_room) owned; the first muscle_count are done */
    double **fibers;                /* (fiber_count) x (sample_count): arms; owned; NULL of a muscle that was not done */
    double **coefficients;          /* (fiber_count) of the fits of all rows; owned */
    sn_index *muscle_of;            /* (fiber_count) owned */
    double *fiber_low, *fiber_high; /* (fiber_count) owned: where a fibre's lengths begin and end, over the coordinate */
    sn_arm_company *company;        /* (other_count) owned */
} sn_arms;

/*
 * Fit and differentiate. Splines are cubic, of equally spaced knots from the least to the greatest coordinate. By rule the number of knots
 * is one more than the least one whose generalised cross-validation (Craven and Wahba 1979: n RSS / (n - p)^2, summed over the muscle's
 * fibres, p coefficients) is within 5 % of the best (what is best for values is too stiff for slopes), among 2 to SN_ARM_MOST_KNOTS knots
 * that leave four different angles for each piece. With both ways, each is fitted alone too, by as many knots where its rows allow. A fibre
 * that misses lengths is fitted to those that it has.
 *
 * The bound on another coordinate c: if an arm of a about c were there, lengths at one angle would differ by a u, u the root mean square of
 * what is no curve of theta in c. So a is no larger than (sweep_residual) / u, and what it adds to -dl/dtheta no larger than that times the
 * root mean square of dc/dtheta. SN_ARM_ALONE: below 0.5 mm (of a way: 0.01), or 5 % of the muscle's largest arm.
 *
 * SN_ERROR_INPUT: the coordinate moves too little, has too few angles for the knots, a fibre misses too many lengths, a length is not
 * positive. SN_STOPPED with what is done where the trace says so.
 */
SN_MUST_CHECK sn_status sn_moment_arms(const sn_arm_input *input, const sn_arm_params *params, sn_arms *out, sn_error *error);
/* Of a fibre, or the mean of a muscle's that have one, at a value of the coordinate where lengths begin before and end behind it; else NaN.
 */
double sn_arm_of_fiber(const sn_arms *arms, sn_index fiber, double angle);
double sn_arm_of_muscle(const sn_arms *arms, sn_index muscle, double angle);
void sn_arms_free(sn_arms *arms); /* leaves all zeros */

/* ---- against measured curves ---------------------------------------------------------------------------------------------------- */

/* One muscle's, as it was measured. */
typedef struct sn_measured_arm {
    char *muscle; /* owned */
    sn_index count;
    double *angles;               /* (count) owned, ascending: radians or metres */
    double *arms, *lower, *upper; /* (count) owned; lower and upper NaN where no band was measured */
} sn_measured_arm;

typedef struct sn_measured_arms {
    sn_index count;
    sn_measured_arm *items; /* (count) owned */
} sn_measured_arms;
void sn_measured_arms_free(sn_measured_arms *all); /* leaves all zeros */

/* NaN: could not be told. Integrals over the measured angles are by the trapezoidal rule. */
typedef struct sn_arm_comparison {
    sn_index points, outside; /* measured angles that have an arm here; those that have none */
    double low, high;         /* of those compared */
    double rms, bias;         /* of mean - measured */
    double overlap;           /* area that both bands cover, over the area that either does; 0 to 1 */
    double inside;            /* share of the points at which the mean lies within the measured band */
    double sign;              /* share of the points with the same sign, among those where both are larger than `sign_from` */
    sn_index sign_points;
} sn_arm_comparison;
#define SN_ARM_SIGN_FROM 1e-3 /* m; of a way 0.01 */
/* Bands are the least and greatest arm of the muscle's fibres, and the measured ones. */
SN_MUST_CHECK sn_status sn_arm_compare(const sn_arms *arms, sn_index muscle, const sn_measured_arm *measured, double sign_from,
                                       sn_arm_comparison *out, sn_error *error);

#endif
