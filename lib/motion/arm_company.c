/* arm_company.c -- how the other coordinates of a motion move beside one, and what that can have done to a muscle's arm. */
#include "moment_arm.h"

#include <stdlib.h>

enum { MOST_PIECES = SN_ARM_MOST_KNOTS - 1 }; /* no fewer than a muscle may have: it takes up no more of what another coordinate does */
#define ALONG 0.99                            /* explained by this share: it moves along */
#define NOTHING_APART 1e-9                    /* of its range */
#define BOUND_SHARE 0.05                      /* of the muscle's largest arm */
#define BOUND_ARM 5e-4                        /* m */
#define BOUND_OF_WAY 0.01

const char *const sn_arm_kind_names[] = {"alone", "alongWithIt", "mixed", NULL};

typedef struct sums {
    sn_index count;
    double left, slope, mean, square; /* of what is left, of slopes, and the values' own */
} sums;

static void add_slopes(const sn_spline_fit *fit, const arm_way *way, const double *values, const double *coefficients, sums *s) {
    for (sn_index i = 0; i < way->count; i++) {
        double slope, value = values[way->rows[i]];
        if (isnan(value)) continue;
        sn_spline_fit_at(fit, coefficients, way->x[i], &slope);
        s->slope += slope * slope;
        s->count++;
        double step = value - s->mean; /* Welford */
        s->mean += step / s->count;
        s->square += step * (value - s->mean);
    }
}

static sn_status add_way(const arm_way *way, const double *values, sums *s, sn_error *error) {
    sn_index pieces = MOST_PIECES;
    double coefficients[MOST_PIECES + 3];
    sn_spline_fit *fit = NULL;
    arm_fit fitted;
    sn_status status = sn_arm_design(way, &pieces, &fit, error);
    if (status == SN_OK && fit != NULL) status = sn_arm_fit_values(fit, way, values, coefficients, &fitted, error);
    if (status == SN_OK && fit != NULL && fitted.determined) {
        s->left += fitted.left;
        add_slopes(fit, way, values, coefficients, s);
    }
    sn_spline_fit_destroy(fit);
    return status;
}

/* Of the values at rows that are used. */
static double range_of(const sn_arm_input *input, const double *values) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < input->row_count; i++) {
        if (isnan(input->coordinate[i]) || isnan(values[i])) continue;
        low = fmin(low, values[i]);
        high = fmax(high, values[i]);
    }
    return low <= high ? high - low : 0.0;
}

sn_status sn_arm_company_find(const sn_arm_input *input, const arm_way *ways, int way_count, sn_arm_company *company, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index c = 0; c < input->other_count && status == SN_OK; c++) {
        const sn_arm_other *other = &input->others[c];
        company[c] = (sn_arm_company){.range = range_of(input, other->values), .explained = NAN};
        company[c].moves = company[c].range >= other->least;
        if (!company[c].moves) continue;
        sums s = {0};
        for (int w = 0; w < way_count && status == SN_OK; w++) status = add_way(&ways[w], other->values, &s, error);
        if (s.count == 0) continue; /* too few values beside the coordinate's to say anything: it may have done anything */
        company[c].apart = sqrt(s.left / s.count);
        company[c].slope = sqrt(s.slope / s.count);
        company[c].explained = s.square > 0.0 ? fmax(0.0, 1.0 - s.left / s.square) : 1.0;
    }
    return status;
}

static double bound_of(const sn_arm_company *c, double residual) {
    if (!(c->apart > NOTHING_APART * c->range)) return INFINITY;
    return residual / c->apart * c->slope;
}

void sn_arm_judge(const sn_arms *arms, bool is_way, sn_muscle_arms *muscle) {
    double enough = fmax(is_way ? BOUND_OF_WAY : BOUND_ARM, BOUND_SHARE * muscle->largest);
    muscle->kind = SN_ARM_ALONE;
    muscle->other = SN_NONE;
    for (sn_index i = 0; i < arms->other_count; i++) {
        const sn_arm_company *c = &arms->company[i];
        if (!c->moves) continue;
        double bound = bound_of(c, muscle->sweep_residual);
        if (muscle->other != SN_NONE && !(bound > muscle->other_bound)) continue;
        muscle->other = i;
        muscle->other_bound = bound;
    }
    if (muscle->other == SN_NONE || muscle->other_bound <= enough) return;
    muscle->kind = arms->company[muscle->other].explained < ALONG ? SN_ARM_MIXED : SN_ARM_WITH_IT;
}
