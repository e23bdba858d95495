/* test_moment_arm.c -- moment arms: splines by least squares, sweeps, straps over cylinders, noise, other coordinates, gaps, comparisons;
 * and the tables that they come from. */
#include "documents.h"
#include "sinew/arm_files.h"

#include <math.h>

enum { MOST_ROWS = 1000, MOST_FIBERS = 8 };

/* A motion and what it does to some fibres. */
typedef struct study {
    sn_index rows, fibers, muscles, others;
    double theta[MOST_ROWS], values[MOST_FIBERS][MOST_ROWS], other_values[2][MOST_ROWS];
    const double *lengths[MOST_FIBERS];
    const char *names[MOST_FIBERS];
    sn_index muscle_of[MOST_FIBERS];
    sn_arm_other others_of[2];
    sn_arm_input input;
} study;

static study *new_study(sn_index rows, sn_index fibers, sn_index muscles) {
    static const char *const names[] = {"a", "b", "c", "d", "e", "f", "g", "h"};
    study *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->rows = rows;
    for (sn_index f = 0; f < fibers; f++) {
        s->lengths[f] = s->values[f];
        s->names[f] = names[f];
        s->muscle_of[f] = f % muscles;
    }
    for (int i = 0; i < 2; i++) s->others_of[i] = (sn_arm_other){i == 0 ? "knee" : "hip", s->other_values[i], SN_ARM_LEAST_ANGLE};
    s->input = (sn_arm_input){.row_count = rows,
                              .coordinate = s->theta,
                              .fiber_count = fibers,
                              .lengths = s->lengths,
                              .muscle_count = muscles,
                              .muscles = s->names,
                              .muscle_of = s->muscle_of,
                              .others = s->others_of};
    return s;
}

static sn_arms solve(const study *s, sn_index knots) {
    sn_arm_params params = SN_ARM_PARAMS;
    sn_arms arms;
    sn_error error = {0};
    params.knots = knots;
    if (sn_moment_arms(&s->input, &params, &arms, &error) != SN_OK) fail_msg("%s", error.text);
    return arms;
}

static void refuse(const study *s, sn_index knots, const char *words) {
    sn_arm_params params = SN_ARM_PARAMS;
    sn_arms arms;
    sn_error error = {0};
    params.knots = knots;
    if (sn_moment_arms(&s->input, &params, &arms, &error) == SN_OK) fail_msg("taken, not refused with '%s'", words);
    if (strstr(error.text, words) == NULL) fail_msg("'%s', not '%s'", error.text, words);
}

static double radians(double degrees) { return degrees * SN_PI / 180.0; }

static double normal(uint64_t *state) {
    double sum = -6.0;
    for (int i = 0; i < 12; i++) sum += sn_random(state);
    return sum;
}

/* ---- splines -------------------------------------------------------------------------------------------------------------------- */

static void a_cubic_is_a_spline_of_any_knots(void **state) {
    (void)state;
    double x[60], y[60], c[64];
    for (int i = 0; i < 60; i++) {
        x[i] = -1.0 + 3.0 * ((i * 37) % 60) / 59.0; /* in no order */
        y[i] = 0.3 - x[i] + 0.5 * x[i] * x[i] * x[i];
    }
    for (sn_index pieces = 1; pieces <= 12; pieces++) {
        sn_spline_fit *fit;
        assert_int_equal(sn_spline_fit_create(-1.0, 2.0, pieces, &fit, NULL), SN_OK);
        assert_int_equal(sn_spline_fit_size(fit), pieces + 3);
        assert_int_equal(sn_spline_fit_design(fit, 60, x, NULL), SN_OK);
        assert_true(sn_spline_fit_solve(fit, y, c) < 1e-22);
        for (double t = -1.0; t <= 2.0; t += 0.1) {
            double slope, value = sn_spline_fit_at(fit, c, t, &slope);
            assert_true(fabs(value - (0.3 - t + 0.5 * t * t * t)) < 1e-11);
            assert_true(fabs(slope - (1.5 * t * t - 1.0)) < 1e-9);
        }
        sn_spline_fit_destroy(fit);
    }
}

/* The slope is linear in y: the root of the sum of squares of what each y does to it. */
static void the_error_of_a_slope_is_what_the_values_do_to_it(void **state) {
    (void)state;
    double x[40], y[40] = {0}, c[16];
    sn_spline_fit *fit;
    for (int i = 0; i < 40; i++) x[i] = i * i / 1521.0;
    assert_int_equal(sn_spline_fit_create(0.0, 1.0, 4, &fit, NULL), SN_OK);
    assert_int_equal(sn_spline_fit_design(fit, 40, x, NULL), SN_OK);
    for (double t = 0.0; t <= 1.0; t += 0.25) {
        double sum = 0.0, slope;
        for (int i = 0; i < 40; i++) {
            y[i] = 1.0;
            sn_spline_fit_solve(fit, y, c);
            y[i] = 0.0;
            sn_spline_fit_at(fit, c, t, &slope);
            sum += slope * slope;
        }
        assert_true(fabs(sn_spline_fit_slope_error(fit, t) / sqrt(sum) - 1.0) < 1e-9);
    }
    sn_spline_fit_destroy(fit);
}

static void values_that_do_not_determine_a_spline_are_refused(void **state) {
    (void)state;
    double x[40];
    sn_spline_fit *fit;
    for (int i = 0; i < 40; i++) x[i] = i < 20 ? i / 100.0 : 0.8 + (i - 20) / 100.0;
    assert_int_equal(sn_spline_fit_create(0.0, 1.0, 8, &fit, NULL), SN_OK);
    assert_int_equal(sn_spline_fit_design(fit, 40, x, NULL), SN_ERROR_INPUT);
    for (int i = 0; i < 40; i++) x[i] = i % 3 / 2.0;
    assert_int_equal(sn_spline_fit_design(fit, 40, x, NULL), SN_ERROR_INPUT);
    sn_spline_fit_destroy(fit);
    assert_int_equal(sn_spline_fit_create(1.0, 1.0, 8, &fit, NULL), SN_ERROR_USAGE);
    assert_int_equal(sn_spline_fit_create(0.0, NAN, 8, &fit, NULL), SN_ERROR_USAGE);
}

/* ---- sweeps --------------------------------------------------------------------------------------------------------------------- */

static void sweeps_turn_where_the_coordinate_comes_back(void **state) {
    (void)state;
    /* rest at 0, up with a jitter, rest at 10, down to 2, up to 5 */
    const double x[] = {0, 0, 0, 1, 2, 1.8, 3, 5, 8, 10, 10, 10, 9.999, 7, 4, NAN, 2, 3, 5};
    sn_sweeps s;
    assert_int_equal(sn_sweeps_find(19, x, &s, NULL), SN_OK);
    assert_int_equal(s.count, 3);
    const sn_sweep expected[] = {{2, 9, true}, {12, 16, false}, {16, 18, true}};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(s.items[i].first, expected[i].first);
        assert_int_equal(s.items[i].last, expected[i].last);
        assert_int_equal(s.items[i].up, expected[i].up);
    }
    sn_sweeps_free(&s);
    const double still[] = {3, 3, 3, NAN};
    assert_int_equal(sn_sweeps_find(4, still, &s, NULL), SN_OK);
    assert_int_equal(s.count, 0);
    sn_sweeps_free(&s);
    const double down[] = {3, 2, 2.04, 1, 0};
    assert_int_equal(sn_sweeps_find(5, down, &s, NULL), SN_OK);
    assert_int_equal(s.count, 1);
    assert_false(s.items[0].up);
    sn_sweeps_free(&s);
}

/* ---- straps --------------------------------------------------------------------------------------------------------------------- */

/* A line from a point at distance d1 of an axis to one at d2, at an angle phi from the first, over a cylinder of radius r about it. */
static double strap_length(double d1, double d2, double r, double phi) {
    double free_angle = acos(r / d1) + acos(r / d2);
    if (phi < free_angle) return sqrt(d1 * d1 + d2 * d2 - 2.0 * d1 * d2 * cos(phi));
    return sqrt(d1 * d1 - r * r) + sqrt(d2 * d2 - r * r) + r * (phi - free_angle);
}

/* ... and its distance from the axis, which is the arm: of the line itself, or r. */
static double strap_arm(double d1, double d2, double r, double phi) {
    double free_angle = acos(r / d1) + acos(r / d2);
    return phi < free_angle ? d1 * d2 * sin(phi) / strap_length(d1, d2, r, phi) : r;
}

/* Extension by theta takes the insertion nearer: phi = 215 degrees - theta. */
static void a_strap_over_a_cylinder_has_its_radius_for_an_arm(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        double r = (double[]){0.005, 0.02, 0.05}[i], worst = 0.0;
        study *s = new_study(181, 1, 1);
        for (sn_index k = 0; k < 181; k++) {
            double theta = radians(k <= 90 ? k / 3.0 : (180 - k) / 3.0);
            s->theta[k] = theta;
            s->values[0][k] = strap_length(0.2, 0.1, r, radians(215.0) - theta);
        }
        sn_arms arms = solve(s, 0);
        for (sn_index k = 0; k < arms.sample_count; k++) {
            assert_true(radians(215.0) - arms.angles[k] >= acos(r / 0.2) + acos(r / 0.1)); /* it wraps all the way */
            worst = fmax(worst, fabs(arms.muscles[0].mean[k] / r - 1.0));
        }
        assert_true(worst < 1e-6);
        assert_true(arms.has_up && arms.has_down && arms.muscles[0].hysteresis < 1e-9);
        sn_arms_free(&arms);
        free(s);
    }
}

/* Where it leaves the cylinder the arm has a kink: within 1 % there too, and the wrap alone would be wrong by more. */
static void a_strap_that_lifts_off_is_followed(void **state) {
    (void)state;
    double worst = 0.0, spread = 0.0, r = 0.03;
    study *s = new_study(361, 1, 1);
    for (sn_index k = 0; k < 361; k++) {
        double theta = radians(k <= 180 ? k * 0.5 : (360 - k) * 0.5);
        s->theta[k] = theta;
        s->values[0][k] = strap_length(0.2, 0.1, r, radians(190.0) - theta);
    }
    sn_arms arms = solve(s, 0);
    for (sn_index k = 0; k < arms.sample_count; k++) {
        double arm = strap_arm(0.2, 0.1, r, radians(190.0) - arms.angles[k]);
        worst = fmax(worst, fabs(arms.muscles[0].mean[k] / arm - 1.0));
        spread = fmax(spread, arm / r);
    }
    assert_true(spread > 1.5);
    if (!(worst < 0.01)) fail_msg("off by %g %%", 100.0 * worst);
    sn_arms_free(&arms);
    free(s);
}

/* Two fibres at different depths: mean, spread, envelope. A cubic l has a quadratic arm. */
static void fibres_make_mean_spread_and_envelope(void **state) {
    (void)state;
    study *s = new_study(100, 3, 2); /* fibres 0 and 2 are of muscle 0 */
    for (sn_index k = 0; k < 100; k++) {
        double t = s->theta[k] = -0.5 + k / 99.0;
        s->values[0][k] = 0.3 - 0.02 * t;
        s->values[2][k] = 0.3 - 0.03 * t + 0.01 * t * t * t;
        s->values[1][k] = 0.2 + 0.05 * t;
    }
    sn_arms arms = solve(s, 2);
    const sn_muscle_arms *m = &arms.muscles[0];
    assert_int_equal(m->fiber_count, 2);
    assert_int_equal(m->knots, 2);
    for (sn_index k = 0; k < arms.sample_count; k++) {
        double t = arms.angles[k], a = 0.02, b = 0.03 - 0.03 * t * t;
        assert_true(fabs(m->mean[k] - 0.5 * (a + b)) < 1e-11);
        assert_true(fabs(m->spread[k] - fabs(a - b) / sqrt(2.0)) < 1e-11);
        assert_true(fabs(m->lower[k] - fmin(a, b)) < 1e-11 && fabs(m->upper[k] - fmax(a, b)) < 1e-11);
        assert_true(fabs(arms.muscles[1].mean[k] + 0.05) < 1e-11);
        assert_true(isnan(m->down[k]));
    }
    assert_true(isnan(m->hysteresis));
    assert_true(isnan(sn_arm_of_fiber(&arms, 0, 0.500001)) && fabs(sn_arm_of_muscle(&arms, 1, 0.1) + 0.05) < 1e-11);
    sn_arms_free(&arms);
    free(s);
}

/* ---- noise ---------------------------------------------------------------------------------------------------------------------- */

/* Over many draws the standard error is what the arms scatter by, but for a third: the knots are chosen by the same lengths. */
static void the_noise_told_is_what_arms_scatter_by(void **state) {
    (void)state;
    uint64_t seed = 5;
    double told = 0.0, square = 0.0;
    sn_index count = 0;
    for (int draw = 0; draw < 60; draw++) {
        study *s = new_study(200, 1, 1);
        for (sn_index k = 0; k < 200; k++) {
            double t = s->theta[k] = 1.5 * k / 199.0;
            s->values[0][k] = 0.25 - 0.03 * sin(t) + 2e-4 * normal(&seed);
        }
        sn_arms arms = solve(s, 0);
        assert_true(fabs(arms.muscles[0].residual - 2e-4) < 4e-5);
        for (sn_index k = 0; k < arms.sample_count; k++) {
            double off = arms.muscles[0].mean[k] - 0.03 * cos(arms.angles[k]);
            square += off * off;
            told += arms.muscles[0].noise[k] * arms.muscles[0].noise[k];
            count++;
        }
        sn_arms_free(&arms);
        free(s);
    }
    double ratio = sqrt(square / told);
    if (!(ratio > 0.75 && ratio < 1.6)) fail_msg("arms scatter by %g of what is told", ratio);
    assert_true(sqrt(square / count) < 0.1 * 0.03);
}

static void more_structure_takes_more_knots_and_noise_takes_fewer(void **state) {
    (void)state;
    sn_index knots[2];
    uint64_t seed = 9;
    for (int noisy = 0; noisy < 2; noisy++) {
        study *s = new_study(200, 1, 1);
        for (sn_index k = 0; k < 200; k++) {
            double t = s->theta[k] = 1.5 * k / 199.0;
            s->values[0][k] = 0.25 + 0.002 * sin(12.0 * t) + (noisy ? 2e-3 * normal(&seed) : 0.0);
        }
        sn_arms arms = solve(s, 0);
        knots[noisy] = arms.muscles[0].knots;
        sn_arms_free(&arms);
        free(s);
    }
    assert_true(knots[0] > 15 && knots[1] < 15);
}

/* ---- hysteresis ----------------------------------------------------------------------------------------------------------------- */

static void up_and_down_are_told_apart(void **state) {
    (void)state;
    study *s = new_study(161, 1, 1);
    for (sn_index k = 0; k < 161; k++) {
        double t = s->theta[k] = (k <= 80 ? k : 160 - k) / 80.0;
        s->values[0][k] = (k <= 80 ? 0.3 - 0.020 * t : 0.28 + 0.023 * (1.0 - t)) - 0.005 * t * t;
    }
    sn_arms arms = solve(s, 0);
    const sn_muscle_arms *m = &arms.muscles[0];
    for (sn_index k = 0; k < arms.sample_count; k++) {
        assert_true(fabs(m->up[k] - (0.020 + 0.010 * arms.angles[k])) < 1e-8);
        assert_true(fabs(m->down[k] - (0.023 + 0.010 * arms.angles[k])) < 1e-8);
    }
    assert_true(fabs(m->hysteresis - 0.003) < 1e-8 && fabs(m->hysteresis_rms - 0.003) < 1e-8);
    assert_true(m->sweep_residual < 1e-9 && m->residual > 1e-4);
    sn_arms_free(&arms);
    free(s);
}

/* ---- other coordinates ------------------------------------------------------------------------------------------------------------ */

static void fill_company(study *s, double share_along, double phase) {
    for (sn_index k = 0; k < s->rows; k++) {
        double t = 2.0 * SN_PI * k / 100.0;
        s->theta[k] = 0.4 * sin(t);
        s->other_values[0][k] = share_along * s->theta[k] + 0.3 * sin(phase * t);
        s->values[0][k] = 0.3 - 0.03 * s->theta[k];                                /* crosses the one */
        s->values[1][k] = 0.3 - 0.03 * s->theta[k] - 0.02 * s->other_values[0][k]; /* crosses both */
    }
    s->input.other_count = 1;
}

static void muscles_that_cross_others_have_no_moment_arm(void **state) {
    (void)state;
    study *s = new_study(400, 2, 2);
    fill_company(s, 0.8, 0.37);
    sn_arms arms = solve(s, 0);
    assert_true(arms.company[0].moves && arms.company[0].explained < 0.9);
    assert_int_equal(arms.muscles[0].kind, SN_ARM_ALONE);
    assert_true(arms.muscles[0].other_bound < 1e-6);
    assert_int_equal(arms.muscles[1].kind, SN_ARM_MIXED);
    assert_int_equal(arms.muscles[1].other, 0);
    assert_true(arms.muscles[1].other_bound > 0.8 * 0.02 * 0.5); /* truly 0.016 m */
    sn_arms_free(&arms);

    for (sn_index k = 0; k < s->rows; k++) {
        s->other_values[0][k] = 0.8 * s->theta[k]; /* along with it: nobody can tell for either muscle */
        s->values[1][k] = 0.3 - 0.03 * s->theta[k] - 0.02 * s->other_values[0][k];
    }
    arms = solve(s, 0);
    assert_true(arms.company[0].explained > 0.999);
    assert_int_equal(arms.muscles[0].kind, SN_ARM_WITH_IT);
    assert_int_equal(arms.muscles[1].kind, SN_ARM_WITH_IT);
    sn_arms_free(&arms);

    for (sn_index k = 0; k < s->rows; k++) s->other_values[0][k] = 0.001 * s->theta[k]; /* less than a degree: it does not move */
    arms = solve(s, 0);
    assert_false(arms.company[0].moves);
    assert_int_equal(arms.muscles[1].kind, SN_ARM_ALONE);
    sn_arms_free(&arms);
    free(s);
}

/* ---- what is missing -------------------------------------------------------------------------------------------------------------- */

static void gaps_have_no_arms_and_missing_lengths_are_left_out(void **state) {
    (void)state;
    study *s = new_study(120, 2, 1);
    for (sn_index k = 0; k < 120; k++) {
        double t = s->theta[k] = (k < 60 ? k : k + 40) / 160.0;
        s->values[0][k] = 0.3 - 0.02 * t;
        s->values[1][k] = k % 7 == 3 ? NAN : 0.3 - 0.02 * t;
    }
    s->theta[20] = NAN;
    sn_arms arms = solve(s, 0);
    sn_index none = 0;
    assert_true(fabs(arms.widest_gap - 41 / 160.0) < 1e-12 && fabs(arms.gap_from - 59 / 160.0) < 1e-12);
    for (sn_index k = 0; k < arms.sample_count; k++) {
        bool inside = arms.angles[k] > 59 / 160.0 && arms.angles[k] < 100 / 160.0;
        assert_int_equal(isnan(arms.muscles[0].mean[k]) != 0, inside);
        none += inside;
        if (!inside) assert_true(fabs(arms.muscles[0].lower[k] - 0.02) < 1e-9 && fabs(arms.muscles[0].upper[k] - 0.02) < 1e-9);
    }
    assert_int_equal(arms.gap_count, none);
    assert_int_equal(arms.muscles[0].missing, 17);
    sn_arms_free(&arms);
    free(s);
}

/* A fibre whose lengths end early has no arm behind their end, however well a cubic would go on; the others have. */
static void no_fibre_is_told_beyond_its_own_lengths(void **state) {
    (void)state;
    study *s = new_study(161, 2, 1);
    for (sn_index k = 0; k < 161; k++) {
        double t = s->theta[k] = (k <= 80 ? k : 160 - k) / 80.0;
        s->values[0][k] = 0.3 - 0.02 * t;
        s->values[1][k] = t > 0.6 || (t > 0.2 && t < 0.4) ? NAN : 0.3 - 0.03 * t;
    }
    sn_arms arms = solve(s, 2);
    const sn_muscle_arms *m = &arms.muscles[0];
    for (sn_index k = 0; k < arms.sample_count; k++) {
        double t = arms.angles[k];
        bool both = t <= 0.6 && !(t > 0.2 && t < 0.4);
        assert_int_equal(isnan(arms.fibers[1][k]) != 0, !both);
        assert_true(fabs(m->mean[k] - (both ? 0.025 : 0.02)) < 1e-9);
        assert_true(fabs(m->upper[k] - (both ? 0.03 : 0.02)) < 1e-9);
        assert_true(fabs(m->spread[k] - (both ? 0.01 / sqrt(2.0) : 0.0)) < 1e-9);
        assert_true(fabs(m->up[k] - (t <= 0.6 ? 0.025 : 0.02)) < 1e-9);
    }
    assert_true(isnan(sn_arm_of_fiber(&arms, 1, 0.61)) && fabs(sn_arm_of_muscle(&arms, 0, 0.61) - 0.02) < 1e-9);
    sn_arms_free(&arms);
    free(s);
}

static void what_cannot_be_fitted_is_refused(void **state) {
    (void)state;
    study *s = new_study(40, 1, 1);
    for (sn_index k = 0; k < 40; k++) {
        s->theta[k] = radians(0.02 * k);
        s->values[0][k] = 0.2;
    }
    refuse(s, 0, "moves by 0.78 degrees in all");
    for (sn_index k = 0; k < 40; k++) s->theta[k] = radians(10.0 * (k % 7));
    refuse(s, 0, "7 different values, and a fit needs 8");
    for (sn_index k = 0; k < 40; k++) s->theta[k] = radians(k);
    refuse(s, 22, "22 knots need 42 different values of the coordinate, and it takes 40");
    for (sn_index k = 0; k < 40; k++) s->theta[k] = radians(k < 20 ? k : k + 60);
    refuse(s, 13, "some lie where no row is");
    s->values[0][3] = 0.0;
    refuse(s, 0, "fibre 1 of \"a\" has a length of 0 m");
    s->values[0][3] = 0.2;
    for (sn_index k = 0; k < 36; k++) s->values[0][k] = NAN;
    refuse(s, 2, "fibre 1 of \"a\" has 4 lengths");
    for (sn_index k = 0; k < 40; k++) s->theta[k] = NAN;
    refuse(s, 0, "no row has");
    free(s);
}

/* Nothing depends on the order of rows but the sweeps; the same angle may come again and again. */
static void rows_may_come_in_any_order(void **state) {
    (void)state;
    study *a = new_study(100, 1, 1), *b = new_study(100, 1, 1);
    for (sn_index k = 0; k < 100; k++) {
        sn_index from = (k * 37) % 100;
        a->theta[k] = 0.01 * (k / 2);
        a->values[0][k] = 0.3 - 0.02 * sin(a->theta[k]) + (k % 2 ? 1e-5 : -1e-5);
        b->theta[from] = a->theta[k];
        b->values[0][from] = a->values[0][k];
    }
    sn_arms x = solve(a, 0), y = solve(b, 0);
    for (sn_index k = 0; k < x.sample_count; k++) {
        assert_true(fabs(x.muscles[0].mean[k] - y.muscles[0].mean[k]) < 1e-11);
        assert_true(fabs(x.muscles[0].mean[k] - 0.02 * cos(x.angles[k])) < 1e-4);
    }
    sn_arms_free(&x);
    sn_arms_free(&y);
    free(a);
    free(b);
}

static void a_trace_stops_after_a_muscle(void **state) {
    (void)state;
    study *s = new_study(40, 2, 2);
    for (sn_index k = 0; k < 40; k++) s->values[0][k] = s->values[1][k] = 0.2 - 0.01 * (s->theta[k] = 0.02 * k);
    for (sn_index stop = 0; stop <= 2; stop++) {
        sn_trace trace = {.stop_after = stop};
        sn_arm_params params = SN_ARM_PARAMS;
        sn_arms arms;
        params.trace = &trace;
        assert_int_equal(sn_moment_arms(&s->input, &params, &arms, NULL), SN_STOPPED);
        assert_int_equal(arms.muscle_count, stop);
        sn_arms_free(&arms);
    }
    free(s);
}

/* ---- against measured curves -------------------------------------------------------------------------------------------------------- */

static void bands_are_compared_by_area(void **state) {
    (void)state;
    study *s = new_study(100, 2, 1);
    for (sn_index k = 0; k < 100; k++) {
        s->theta[k] = k / 99.0;
        s->values[0][k] = 0.3 - 0.02 * s->theta[k];
        s->values[1][k] = 0.3 - 0.04 * s->theta[k];
    }
    sn_arms arms = solve(s, 0);
    double angles[] = {-0.1, 0.0, 0.5, 1.0, 1.2}, measured[] = {0.04, 0.04, 0.04, -0.04, 0.04}, lower[5], upper[5];
    for (int i = 0; i < 5; i++) {
        lower[i] = measured[i] - 0.01;
        upper[i] = measured[i] + 0.01;
    }
    sn_measured_arm m = {"a", 5, angles, measured, lower, upper};
    sn_arm_comparison c;
    assert_int_equal(sn_arm_compare(&arms, 0, &m, SN_ARM_SIGN_FROM, &c, NULL), SN_OK);
    assert_int_equal(c.points, 3);
    assert_int_equal(c.outside, 2);
    /* own band 0.02 .. 0.04, mean 0.03; measured 0.03 .. 0.05 twice, then -0.05 .. -0.03: weights 1/4, 1/2, 1/4 of the way */
    assert_true(fabs(c.overlap - (0.75 * 0.01) / (0.75 * 0.03 + 0.25 * 0.04)) < 1e-9);
    assert_true(fabs(c.rms - sqrt((2 * 1e-4 + 0.07 * 0.07) / 3)) < 1e-9);
    assert_true(fabs(c.bias - (0.07 - 0.02) / 3) < 1e-9);
    assert_int_equal(c.sign_points, 3);
    assert_true(fabs(c.sign - 2.0 / 3.0) < 1e-12);
    measured[1] = measured[2] = measured[3] = 0.03;
    for (int i = 0; i < 5; i++) lower[i] = upper[i] = NAN;
    assert_int_equal(sn_arm_compare(&arms, 0, &m, SN_ARM_SIGN_FROM, &c, NULL), SN_OK);
    assert_true(isnan(c.overlap) && isnan(c.inside) && c.rms < 1e-9 && c.sign == 1.0);
    m.count = 1; /* outside */
    assert_int_equal(sn_arm_compare(&arms, 0, &m, SN_ARM_SIGN_FROM, &c, NULL), SN_OK);
    assert_true(c.points == 0 && isnan(c.rms));
    sn_arms_free(&arms);
    free(s);
}

/* ---- files ---------------------------------------------------------------------------------------------------------------------- */

static sn_columns read_table(const char *text) {
    sn_columns out;
    sn_error error = {0};
    sn_blob blob = blob_of("t.tsv", text);
    if (sn_number_table_parse(&blob, &out, &error) != SN_OK) fail_msg("%ld: %s", (long)error.line, error.text);
    sn_blob_free(&blob);
    return out;
}

static void refuse_table(const char *text, int64_t line, const char *words) {
    sn_columns out;
    sn_error error = {0};
    sn_blob blob = blob_of("t.tsv", text);
    if (sn_number_table_parse(&blob, &out, &error) == SN_OK) fail_msg("taken, not refused with '%s'", words);
    if (strstr(error.text, words) == NULL || error.line != line)
        fail_msg("line %ld: '%s', not line %ld: '%s'", (long)error.line, error.text, (long)line, words);
    assert_non_null(strstr(error.file, "t.tsv"));
    sn_blob_free(&blob);
}

static void tables_are_read_whatever_parts_their_cells(void **state) {
    (void)state;
    const char *const texts[] = {"time\ta b\tc\n0\t1\t2\n0.5\t\t-3e-1\n", "\xef\xbb\xbf\"time\",\"a b\",c\r\n0, 1 ,2\r\n0.5,,-0.3\r\n",
                                 "# lengths\n\ntime;a b;c;\n0;1;2;\n\n0.5;nan;-0.3\n"};
    for (int i = 0; i < 3; i++) {
        sn_columns t = read_table(texts[i]);
        assert_int_equal(t.column_count, 2);
        assert_int_equal(t.row_count, 2);
        assert_string_equal(t.names[0], "a b");
        assert_true(t.times[1] == 0.5 && t.values[0] == 1.0 && t.values[1] == 2.0 && isnan(t.values[2]) && t.values[3] == -0.3);
        sn_columns_free(&t);
    }
    sn_columns t = read_table("angle  a\n1  2\n 0   3 \n");
    assert_null(t.times);
    assert_true(t.column_count == 2 && t.row_count == 2 && t.values[2] == 0.0 && t.values[3] == 3.0);
    sn_columns_free(&t);
    t = read_table("x\nversion=1\nnRows=1\nnColumns=2\ninDegrees=no\nendheader\ntime\ta\n0\t1\n");
    assert_true(t.degrees_told && !t.degrees);
    sn_columns_free(&t);
    t = read_table("x\nversion=3\nendheader\ntime\ta\n0\t1\n");
    assert_false(t.degrees_told);
    sn_columns_free(&t);
}

static void tables_that_are_none_are_refused_on_their_line(void **state) {
    (void)state;
    refuse_table("", 0, "no row of names");
    refuse_table("time\ta\n", 1, "no row of numbers");
    refuse_table("0\t1\n1\t2\n", 1, "stands where the names of the columns should");
    refuse_table("time\ta\n0\t1,5\n", 2, "write decimal points, not commas");
    refuse_table("time;a\n0;1\n1;1,5\n", 3, "write decimal points, not commas");
    refuse_table("time,a\n0,0,1,5\n", 2, "where commas are decimal marks, write points");
    refuse_table("time\ta\n0\t1\n1\n", 3, "1 cells and there are 2 columns");
    refuse_table("time\ta\n0\t1\n1\tmany\n", 3, "\"many\" is no number");
    refuse_table("time\ta\n0\t1\n0.2\t1\n0.1\t1\n", 0, "row 3 is at 0.1 s behind 0.2 s");
    refuse_table("time\ta\n0\t1\n0\t1\n", 0, "the times must ascend");
    refuse_table("time\ta\n0\t1\n\t1\n", 0, "the time of row 2 is not finite");
    refuse_table("time\n0\n", 1, "no column beside the time");
}

static void motions_are_looked_up_between_rows_and_not_beyond(void **state) {
    (void)state;
    sn_columns t = read_table("time\ta\n0\t0\n1\t10\n2\tnan\n3\t30\n4\t40\n12\t120\n13\t130\n");
    double step = sn_columns_median_step(&t);
    assert_true(step == 1.0);
    assert_true(sn_columns_at(&t, 0, step, 0.25) == 2.5 && sn_columns_at(&t, 0, step, 1.0) == 10.0);
    assert_true(isnan(sn_columns_at(&t, 0, step, 1.5)) && isnan(sn_columns_at(&t, 0, step, 2.5))); /* beside a value that is not there */
    assert_true(isnan(sn_columns_at(&t, 0, step, 8.0)));                                           /* in a gap */
    assert_true(sn_columns_at(&t, 0, step, 4.0005) == 40.0);                                       /* a rounded time */
    assert_true(isnan(sn_columns_at(&t, 0, step, -0.01)) && isnan(sn_columns_at(&t, 0, step, 13.1)));
    assert_true(sn_columns_at(&t, 0, step, -0.0005) == 0.0);
    sn_columns_free(&t);
}

static void names_of_columns_tell_what_they_hold(void **state) {
    (void)state;
    static const struct {
        const char *name, *stem;
        sn_column_kind kind;
    } cases[] = {{"biceps.12", "biceps", SN_COLUMN_FIBER},
                 {"biceps.blend.3", "biceps.blend", SN_COLUMN_FIBER},
                 {"/forceset/soleus_r|length", "soleus_r", SN_COLUMN_LENGTH},
                 {"elbow.angle", "elbow", SN_COLUMN_DEGREES},
                 {"ankle.rad", "ankle", SN_COLUMN_RADIANS},
                 {"pelvis_tx.m", "pelvis_tx", SN_COLUMN_METERS},
                 {"/jointset/ankle_r/ankle_angle_r/value", "ankle_angle_r", SN_COLUMN_VALUE},
                 {"/jointset/ankle_r/ankle_angle_r/speed", "/jointset/ankle_r/ankle_angle_r/speed", SN_COLUMN_OTHER},
                 {"/forceset/soleus_r|fiber_length", "/forceset/soleus_r|fiber_length", SN_COLUMN_OTHER},
                 {"soleus_r", "soleus_r", SN_COLUMN_PLAIN},
                 {".1", ".1", SN_COLUMN_PLAIN},
                 {"7", "7", SN_COLUMN_PLAIN}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *stem;
        size_t length;
        assert_int_equal(sn_column_read_name(cases[i].name, &stem, &length), cases[i].kind);
        assert_int_equal(length, strlen(cases[i].stem));
        assert_memory_equal(stem, cases[i].stem, length);
    }
    assert_true(sn_column_is_way("pelvis_tx", 9) && !sn_column_is_way("pelvis_tilt", 11));
}

static void refuse_measured(const char *text, bool is_way, const char *words) {
    sn_measured_choice choice = {.coordinate = "/jointset/knee_r/knee/value", .is_way = is_way};
    sn_measured_arms out;
    sn_error error = {0};
    sn_blob blob = blob_of("m.tsv", text);
    if (sn_measured_arms_parse(&blob, &choice, &out, &error) == SN_OK) fail_msg("taken, not refused with '%s'", words);
    if (strstr(error.text, words) == NULL) fail_msg("'%s', not '%s'", error.text, words);
    sn_blob_free(&blob);
}

static void measured_arms_are_read_in_their_units(void **state) {
    (void)state;
    sn_measured_choice choice = {.coordinate = "/jointset/knee_r/knee/value"};
    sn_measured_arms out;
    sn_error error = {0};
    sn_blob blob = blob_of(
        "m.tsv", "note\tcoordinate\tarm.mm\tsd.mm\tmuscle\tangle\nx\tknee\t30\t2\tb\t90\nx\tknee.rad\t20\t2\tb\t0\nx\thip\t1\t1\tb\t0\n"
                 "x\tknee\t-10\t\ta\t45\nx\tknee\tnan\t\ta\t45\n");
    if (sn_measured_arms_parse(&blob, &choice, &out, &error) != SN_OK) fail_msg("%s", error.text);
    assert_true(out.count == 2 && choice.skipped == 1);
    assert_string_equal(out.items[0].muscle, "a");
    assert_true(out.items[0].count == 1 && out.items[0].arms[0] == -0.01 && isnan(out.items[0].lower[0]));
    assert_true(fabs(out.items[0].angles[0] - SN_PI / 4) < 1e-15);
    assert_true(out.items[1].count == 2 && out.items[1].angles[0] == 0.0 && out.items[1].arms[0] == 0.02);
    assert_true(fabs(out.items[1].upper[1] - 0.032) < 1e-15 && fabs(out.items[1].lower[1] - 0.028) < 1e-15);
    sn_measured_arms_free(&out);
    sn_blob_free(&blob);
    refuse_measured("muscle\tangle\tarm\na\t10\t35\n", false, "is it in mm?");
    refuse_measured("muscle\tangle\na\t10\n", false, "no column arm (metres), arm.cm or arm.mm");
    refuse_measured("muscle\tarm\na\t0.01\n", false, "no column angle (degrees) or angle.rad");
    refuse_measured("muscle\tangle\tarm\na\t10\t0.03\n", true, "does not fit a coordinate that is a way");
    refuse_measured("muscle\tangle\tarm\tlower\na\t10\t0.03\t0.02\n", false, "both lower and upper");
    refuse_measured("muscle\tangle\tarm\tlower\tupper\na\t10\t0.03\t0.04\t0.02\n", false, "lower is above upper");
    refuse_measured("muscle\tangle\tarm\tsd\na\t10\t0.03\t-0.02\n", false, "deviation is negative");
    refuse_measured("muscle\tangle\tarm\tarm.mm\na\t10\t0.03\t30\n", false, "hold the same");
    refuse_measured("muscle\tcoordinate\tangle\tarm\na\thip\t10\t0.03\n", false, "no row is of the coordinate");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cubic_is_a_spline_of_any_knots),
        cmocka_unit_test(the_error_of_a_slope_is_what_the_values_do_to_it),
        cmocka_unit_test(values_that_do_not_determine_a_spline_are_refused),
        cmocka_unit_test(sweeps_turn_where_the_coordinate_comes_back),
        cmocka_unit_test(a_strap_over_a_cylinder_has_its_radius_for_an_arm),
        cmocka_unit_test(a_strap_that_lifts_off_is_followed),
        cmocka_unit_test(fibres_make_mean_spread_and_envelope),
        cmocka_unit_test(the_noise_told_is_what_arms_scatter_by),
        cmocka_unit_test(more_structure_takes_more_knots_and_noise_takes_fewer),
        cmocka_unit_test(up_and_down_are_told_apart),
        cmocka_unit_test(muscles_that_cross_others_have_no_moment_arm),
        cmocka_unit_test(gaps_have_no_arms_and_missing_lengths_are_left_out),
        cmocka_unit_test(no_fibre_is_told_beyond_its_own_lengths),
        cmocka_unit_test(what_cannot_be_fitted_is_refused),
        cmocka_unit_test(rows_may_come_in_any_order),
        cmocka_unit_test(a_trace_stops_after_a_muscle),
        cmocka_unit_test(bands_are_compared_by_area),
        cmocka_unit_test(tables_are_read_whatever_parts_their_cells),
        cmocka_unit_test(tables_that_are_none_are_refused_on_their_line),
        cmocka_unit_test(motions_are_looked_up_between_rows_and_not_beyond),
        cmocka_unit_test(names_of_columns_tell_what_they_hold),
        cmocka_unit_test(measured_arms_are_read_in_their_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
