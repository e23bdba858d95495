/* moment_arm.c -- -dl/dtheta of every fibre by splines over the coordinate; mean, spread and envelope of a muscle; its ways up and down. */
#include "moment_arm.h"

#include <stdlib.h>

#define NOISE_FLOOR 1e-10 /* m: what is left below this is rounding, no reason for more knots */
#define NEAR_BEST 1.05    /* of the best cross-validation */
#define GAP_OF_RANGE 0.1  /* without a row: a gap, if it is ... */
#define GAP_OF_STEP 4.0   /* ... as many times wider than the median step */

typedef struct run {
    const sn_arm_input *input;
    const sn_arm_params *params;
    sn_error *error;
    arm_way all, ways[2]; /* all rows; those up and those down */
    bool *in_gap;         /* (sample_count) */
    double widest;        /* without a row, and no gap yet */
    sn_arms *out;
} run;

/* ---- rows ----------------------------------------------------------------------------------------------------------------------- */

static sn_status take_all(run *r) {
    sn_index count = 0, *rows = SN_NEW(sn_index, r->input->row_count);
    for (sn_index i = 0; rows != NULL && i < r->input->row_count; i++)
        if (!isnan(r->input->coordinate[i])) rows[count++] = i;
    return sn_arm_way_make(r->input->coordinate, rows, count, &r->all, r->error);
}

/* Two sweeps that meet share the row at which they turn, if nothing rests there: each has it. */
static sn_status take_way(run *r, bool up, arm_way *way) {
    const sn_sweeps *sweeps = &r->out->sweeps;
    sn_index count = 0, *rows = SN_NEW(sn_index, (size_t)r->input->row_count + (size_t)sweeps->count);
    for (sn_index s = 0; rows != NULL && s < sweeps->count; s++) {
        if (sweeps->items[s].up != up) continue;
        for (sn_index i = sweeps->items[s].first; i <= sweeps->items[s].last; i++)
            if (!isnan(r->input->coordinate[i])) rows[count++] = i;
    }
    return sn_arm_way_make(r->input->coordinate, rows, count, way, r->error);
}

static sn_status check_range(const run *r) {
    double range = r->all.high - r->all.low;
    if (r->all.count == 0) return sn_fail(r->error, SN_ERROR_INPUT, "no row has both a coordinate and lengths");
    if (r->params->is_way && !(range >= SN_ARM_LEAST_WAY))
        return sn_fail(r->error, SN_ERROR_INPUT, "the coordinate moves by %.3g m in all, and an arm needs %g m", range, SN_ARM_LEAST_WAY);
    if (!r->params->is_way && !(range >= SN_ARM_LEAST_ANGLE))
        return sn_fail(r->error, SN_ERROR_INPUT, "the coordinate moves by %.3g degrees in all, and an arm needs %g degrees",
                       range * (180.0 / SN_PI), SN_ARM_LEAST_ANGLE * (180.0 / SN_PI));
    if (r->all.angles < SN_ARM_FEWEST_ANGLES)
        return sn_fail(r->error, SN_ERROR_INPUT, "the coordinate takes %d different values, and a fit needs %d", r->all.angles,
                       SN_ARM_FEWEST_ANGLES);
    if (r->params->knots > 0 && r->all.angles < 2 * (r->params->knots - 1))
        return sn_fail(r->error, SN_ERROR_INPUT, "%d knots need %d different values of the coordinate, and it takes %d; ask for fewer",
                       r->params->knots, 2 * (r->params->knots - 1), r->all.angles);
    return SN_OK;
}

/* As people count: the fibre's number in its muscle, from 1. */
static int number_of(const run *r, sn_index fiber) {
    int number = 1;
    for (sn_index f = 0; f < fiber; f++) number += r->input->muscle_of[f] == r->input->muscle_of[fiber];
    return number;
}

static sn_status check_lengths(const run *r) {
    for (sn_index f = 0; f < r->input->fiber_count; f++)
        for (sn_index i = 0; i < r->input->row_count; i++) {
            double length = r->input->lengths[f][i];
            if (!isnan(length) && !(length > 0.0 && isfinite(length)))
                return sn_fail(r->error, SN_ERROR_INPUT, "fibre %d of \"%s\" has a length of %g m", number_of(r, f),
                               r->input->muscles[r->input->muscle_of[f]], length);
        }
    return SN_OK;
}

/* ---- gaps ----------------------------------------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_step(const double *sorted, sn_index count, double *steps) {
    sn_index n = 0;
    for (sn_index i = 1; i < count; i++)
        if (sorted[i] > sorted[i - 1]) steps[n++] = sorted[i] - sorted[i - 1];
    qsort(steps, (size_t)n, sizeof *steps, compare);
    return n > 0 ? steps[n / 2] : 0.0;
}

static void mark_gaps(const run *r, const double *sorted) {
    sn_arms *out = r->out;
    for (sn_index i = 1; i < r->all.count; i++) {
        double gap = sorted[i] - sorted[i - 1];
        if (!(gap > r->widest)) continue;
        if (gap > out->widest_gap) {
            out->widest_gap = gap;
            out->gap_from = sorted[i - 1];
        }
        for (sn_index k = 0; k < out->sample_count; k++)
            if (out->angles[k] > sorted[i - 1] && out->angles[k] < sorted[i]) r->in_gap[k] = true;
    }
    for (sn_index k = 0; k < out->sample_count; k++) out->gap_count += r->in_gap[k];
}

static sn_status find_gaps(run *r) {
    sn_index count = r->all.count;
    double *sorted = SN_NEW(double, count), *steps = SN_NEW(double, count);
    r->in_gap = SN_NEW(bool, r->out->sample_count);
    bool enough = sorted != NULL && steps != NULL && r->in_gap != NULL;
    for (sn_index i = 0; enough && i < count; i++) sorted[i] = r->all.x[i];
    if (enough) {
        qsort(sorted, (size_t)count, sizeof *sorted, compare);
        r->widest = fmax(GAP_OF_RANGE * (r->all.high - r->all.low), GAP_OF_STEP * median_step(sorted, count, steps));
        mark_gaps(r, sorted);
    }
    free(sorted);
    free(steps);
    return enough ? SN_OK : sn_fail_memory(r->error, "the gaps of a coordinate");
}

/* ---- how many knots --------------------------------------------------------------------------------------------------------------- */

/* Generalised cross-validation of one muscle's fibres; NaN where some fibre cannot be fitted so. */
static sn_status cross_validate(const run *r, sn_index muscle, const sn_spline_fit *fit, double *score) {
    double coefficients[SN_ARM_MOST_KNOTS + 2], size = sn_spline_fit_size(fit);
    *score = 0.0;
    for (sn_index f = 0; f < r->input->fiber_count; f++) {
        arm_fit fitted;
        if (r->input->muscle_of[f] != muscle) continue;
        sn_status status = sn_arm_fit_values(fit, &r->all, r->input->lengths[f], coefficients, &fitted, r->error);
        if (status != SN_OK) return status;
        double left = fmax(fitted.left, fitted.count * NOISE_FLOOR * NOISE_FLOOR), free_values = fitted.count - size;
        *score += fitted.determined && free_values > 0.0 ? fitted.count * left / (free_values * free_values) : NAN;
    }
    return SN_OK;
}

/* The fewest pieces near the best. Those that the rows do not determine end the search. */
static sn_status choose_pieces(const run *r, sn_index muscle, sn_index *out) {
    double scores[SN_ARM_MOST_KNOTS], best = INFINITY;
    sn_index tried = 0;
    for (; tried + 1 < SN_ARM_MOST_KNOTS && sn_arm_way_holds(&r->all, tried + 1); tried++) {
        sn_index pieces = tried + 1;
        sn_spline_fit *fit = NULL;
        sn_status status = sn_arm_design(&r->all, &pieces, &fit, r->error);
        bool fits = fit != NULL && pieces == tried + 1;
        if (status == SN_OK && fits) status = cross_validate(r, muscle, fit, &scores[tried]);
        sn_spline_fit_destroy(fit);
        if (status != SN_OK) return status;
        if (!fits || isnan(scores[tried])) break;
        best = fmin(best, scores[tried]);
    }
    for (*out = 1; *out <= tried && !(scores[*out - 1] <= NEAR_BEST * best);) (*out)++;
    if (*out < tried) (*out)++; /* best for values; a slope that is as true as its error says wants one piece more */
    if (tried > 0) return SN_OK;
    return sn_fail(r->error, SN_ERROR_INPUT, "the rows of \"%s\" do not determine a fit", r->input->muscles[muscle]);
}

static sn_status make_fit(const run *r, sn_index muscle, sn_muscle_arms *m) {
    sn_index pieces = r->params->knots - 1;
    sn_status status = r->params->knots > 0 ? SN_OK : choose_pieces(r, muscle, &pieces);
    if (status != SN_OK) return status;
    m->knots = pieces + 1;
    status = sn_spline_fit_create(r->all.low, r->all.high, pieces, &m->fit, r->error);
    if (status == SN_OK) status = sn_spline_fit_design(m->fit, r->all.count, r->all.x, r->error);
    if (status == SN_ERROR_INPUT)
        return sn_fail(r->error, status, "%d knots are more than the rows determine, as some lie where no row is; ask for fewer", m->knots);
    return status;
}

/* ---- fibres --------------------------------------------------------------------------------------------------------------------- */

/* Sums over the fibres of a muscle. */
typedef struct tally {
    sn_index values, fibers;
    double left, variance; /* sum of squares from the fits; sum of the fibres' variances about them */
    double square;         /* about their means */
} tally;

static void measure_lengths(const run *r, const double *lengths, sn_muscle_arms *m, tally *t) {
    double mean = 0.0, square = 0.0, least = INFINITY, most = 0.0;
    sn_index count = 0;
    for (sn_index i = 0; i < r->all.count; i++) {
        double length = lengths[r->all.rows[i]], step = length - mean;
        if (isnan(length)) continue;
        mean += step / ++count;
        square += step * (length - mean);
        least = fmin(least, length);
        most = fmax(most, length);
    }
    m->missing += r->all.count - count;
    m->stretch = fmax(m->stretch, most / least);
    t->square += square;
}

/* Where a fibre has lengths: its least and greatest coordinate; sorted (rows of `way`) gets them all. Returns how many there are. */
static sn_index sort_coordinates(const arm_way *way, const double *lengths, double *sorted) {
    sn_index count = 0;
    for (sn_index i = 0; i < way->count; i++)
        if (!isnan(lengths[way->rows[i]])) sorted[count++] = way->x[i];
    qsort(sorted, (size_t)count, sizeof *sorted, compare);
    return count;
}

/* Nothing is told of a fibre beyond its own lengths, nor in gaps of its own. */
static void fill_arms(const run *r, sn_index fiber, const double *sorted, sn_index count) {
    sn_arms *out = r->out;
    out->fiber_low[fiber] = sorted[0];
    out->fiber_high[fiber] = sorted[count - 1];
    for (sn_index k = 0, next = 0; k < out->sample_count; k++) {
        double angle = out->angles[k];
        while (next < count && sorted[next] < angle) next++; /* the first that is not below */
        bool apart = next > 0 && next < count && sorted[next] > angle && sorted[next] - sorted[next - 1] > r->widest;
        out->fibers[fiber][k] = r->in_gap[k] || apart ? NAN : sn_arm_of_fiber(out, fiber, angle);
    }
}

static sn_status fit_lengths(const run *r, sn_index fiber, sn_muscle_arms *m, double *sorted, tally *t) {
    sn_arms *out = r->out;
    const double *lengths = r->input->lengths[fiber];
    arm_fit fitted;
    sn_index size = sn_spline_fit_size(m->fit);
    sn_status status = sn_arm_fit_values(m->fit, &r->all, lengths, out->coefficients[fiber], &fitted, r->error);
    if (status != SN_OK) return status;
    if (!fitted.determined || fitted.count <= size)
        return sn_fail(r->error, SN_ERROR_INPUT, "fibre %d of \"%s\" has %d lengths, which do not determine a fit by %d knots",
                       number_of(r, fiber), r->input->muscles[r->input->muscle_of[fiber]], fitted.count, m->knots);
    fill_arms(r, fiber, sorted, sort_coordinates(&r->all, lengths, sorted));
    measure_lengths(r, lengths, m, t);
    t->fibers++;
    t->values += fitted.count;
    t->left += fitted.left;
    t->variance += fitted.left / (fitted.count - size);
    return SN_OK;
}

static sn_status fit_fiber(const run *r, sn_index fiber, sn_muscle_arms *m, tally *t) {
    sn_arms *out = r->out;
    double *sorted = SN_NEW(double, r->all.count);
    out->fibers[fiber] = SN_NEW(double, out->sample_count);
    out->coefficients[fiber] = SN_NEW(double, sn_spline_fit_size(m->fit));
    bool enough = sorted != NULL && out->fibers[fiber] != NULL && out->coefficients[fiber] != NULL;
    sn_status status = enough ? fit_lengths(r, fiber, m, sorted, t) : sn_fail_memory(r->error, "the arms of fibres");
    free(sorted);
    return status;
}

static void sum_up_sample(const run *r, sn_index muscle, sn_index k, sn_muscle_arms *m) {
    double mean = 0.0, square = 0.0, least = INFINITY, most = -INFINITY;
    sn_index count = 0;
    for (sn_index f = 0; f < r->input->fiber_count; f++) {
        if (r->input->muscle_of[f] != muscle) continue;
        double arm = r->out->fibers[f][k], step = arm - mean;
        if (isnan(arm)) continue;
        mean += step / ++count;
        square += step * (arm - mean);
        least = fmin(least, arm);
        most = fmax(most, arm);
    }
    if (count == 0) mean = least = most = NAN;
    m->mean[k] = mean;
    m->spread[k] = count > 1 ? sqrt(square / (count - 1)) : 0.0 * mean;
    m->lower[k] = least;
    m->upper[k] = most;
}

static void sum_up(const run *r, sn_index muscle, const tally *t, sn_muscle_arms *m) {
    double least = INFINITY, most = -INFINITY, square = 0.0, sigma = sqrt(t->variance / t->fibers);
    sn_index count = 0;
    for (sn_index k = 0; k < r->out->sample_count; k++) {
        sum_up_sample(r, muscle, k, m);
        m->noise[k] = isnan(m->mean[k]) ? NAN : sigma * sn_spline_fit_slope_error(m->fit, r->out->angles[k]);
        if (isnan(m->mean[k])) continue;
        square += m->noise[k] * m->noise[k];
        least = fmin(least, m->mean[k]);
        most = fmax(most, m->mean[k]);
        count++;
    }
    if (count == 0) least = most = NAN; /* lengths between two samples alone */
    m->fiber_count = t->fibers;
    m->noise_mean = sqrt(square / count);
    m->range = most - least;
    m->largest = fmax(fabs(least), fabs(most));
    m->residual = m->sweep_residual = sqrt(t->left / t->values);
    m->variation = sqrt(t->square / t->values);
}

/* ---- one way alone -------------------------------------------------------------------------------------------------------------- */

/* Sums over the fibres that have lengths at an angle. */
typedef struct way_sums {
    double *arms;     /* (sample_count) */
    sn_index *counts; /* (sample_count) */
} way_sums;

static void add_slopes(const run *r, const arm_way *way, const double *lengths, const sn_spline_fit *fit, const double *coefficients,
                       way_sums *sums) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < way->count; i++) {
        if (isnan(lengths[way->rows[i]])) continue;
        low = fmin(low, way->x[i]);
        high = fmax(high, way->x[i]);
    }
    for (sn_index k = 0; k < r->out->sample_count; k++) {
        double slope, angle = r->out->angles[k];
        if (r->in_gap[k] || angle < low || angle > high) continue;
        sn_spline_fit_at(fit, coefficients, angle, &slope);
        sums->arms[k] -= slope;
        sums->counts[k]++;
    }
}

static sn_status add_fibers(const run *r, sn_index muscle, const arm_way *way, const sn_spline_fit *fit, way_sums *sums, tally *t) {
    double coefficients[SN_ARM_MOST_KNOTS + 2];
    for (sn_index f = 0; f < r->input->fiber_count; f++) {
        arm_fit fitted;
        if (r->input->muscle_of[f] != muscle) continue;
        sn_status status = sn_arm_fit_values(fit, way, r->input->lengths[f], coefficients, &fitted, r->error);
        if (status != SN_OK) return status;
        if (!fitted.determined) continue;
        add_slopes(r, way, r->input->lengths[f], fit, coefficients, sums);
        t->left += fitted.left;
        t->values += fitted.count;
    }
    return SN_OK;
}

/* The mean arm of the muscle's fibres by the rows of one way; NaN where they do not determine one. */
static sn_status fit_way(const run *r, sn_index muscle, const arm_way *way, double *arms, tally *t) {
    sn_index pieces = r->out->muscles[muscle].knots - 1;
    sn_spline_fit *fit = NULL;
    way_sums sums = {arms, SN_NEW(sn_index, r->out->sample_count)};
    sn_status status = sums.counts != NULL ? sn_arm_design(way, &pieces, &fit, r->error) : sn_fail_memory(r->error, "the arms of a way");
    if (status == SN_OK && fit != NULL) status = add_fibers(r, muscle, way, fit, &sums, t);
    for (sn_index k = 0; status == SN_OK && k < r->out->sample_count; k++) arms[k] = sums.counts[k] > 0 ? arms[k] / sums.counts[k] : NAN;
    free(sums.counts);
    sn_spline_fit_destroy(fit);
    return status;
}

static void measure_hysteresis(const run *r, sn_muscle_arms *m) {
    double most = 0.0, square = 0.0;
    sn_index count = 0;
    for (sn_index k = 0; k < r->out->sample_count; k++) {
        double apart = fabs(m->up[k] - m->down[k]);
        if (isnan(apart)) continue;
        most = fmax(most, apart);
        square += apart * apart;
        count++;
    }
    m->hysteresis = count > 0 ? most : NAN;
    m->hysteresis_rms = count > 0 ? sqrt(square / count) : NAN;
}

static sn_status fit_ways(const run *r, sn_index muscle, sn_muscle_arms *m) {
    tally t = {0};
    sn_status status = fit_way(r, muscle, &r->ways[0], m->up, &t);
    if (status == SN_OK) status = fit_way(r, muscle, &r->ways[1], m->down, &t);
    if (status != SN_OK) return status;
    if (r->out->has_up && r->out->has_down && t.values > 0) m->sweep_residual = sqrt(t.left / t.values);
    measure_hysteresis(r, m);
    return SN_OK;
}

/* ---- muscles -------------------------------------------------------------------------------------------------------------------- */

static bool make_arrays(sn_muscle_arms *m, sn_index samples) {
    double **all[] = {&m->mean, &m->spread, &m->lower, &m->upper, &m->noise, &m->up, &m->down};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if ((*all[i] = SN_NEW(double, samples)) == NULL) return false;
    return true;
}

static sn_status do_muscle(const run *r, sn_index muscle) {
    sn_muscle_arms *m = &r->out->muscles[muscle];
    tally t = {0};
    if (!make_arrays(m, r->out->sample_count)) return sn_fail_memory(r->error, "the arms of a muscle");
    sn_status status = make_fit(r, muscle, m);
    for (sn_index f = 0; f < r->input->fiber_count && status == SN_OK; f++)
        if (r->input->muscle_of[f] == muscle) status = fit_fiber(r, f, m, &t);
    if (status != SN_OK) return status;
    sum_up(r, muscle, &t, m);
    status = fit_ways(r, muscle, m);
    if (status == SN_OK) sn_arm_judge(r->out, r->params->is_way, m);
    return status;
}

static bool trace_muscle(const run *r, sn_index muscle) {
    const sn_muscle_arms *m = &r->out->muscles[muscle];
    return SN_TRACE(r->params->trace, "muscle", sn_trace_text("muscle", r->input->muscles[muscle]),
                    sn_trace_number("fibers", m->fiber_count), sn_trace_number("knots", m->knots), sn_trace_number("residual", m->residual),
                    sn_trace_number("noise", m->noise_mean), sn_trace_number("range", m->range));
}

static sn_status do_muscles(const run *r) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < r->input->muscle_count && status == SN_OK; i++) {
        if (sn_trace_stopped(r->params->trace)) return SN_STOPPED;
        status = do_muscle(r, i);
        if (status != SN_OK) continue;
        r->out->muscle_count++;
        if (trace_muscle(r, i)) status = SN_STOPPED;
    }
    return status;
}

/* ---- all ------------------------------------------------------------------------------------------------------------------------ */

static sn_status allocate(const run *r) {
    const sn_arm_input *input = r->input;
    sn_arms *out = r->out;
    out->sample_count = r->params->samples;
    out->fiber_count = input->fiber_count;
    out->other_count = input->other_count;
    out->angles = SN_NEW(double, out->sample_count);
    out->muscle_room = input->muscle_count;
    out->muscles = SN_NEW(sn_muscle_arms, input->muscle_count);
    out->fibers = SN_NEW(double *, input->fiber_count);
    out->coefficients = SN_NEW(double *, input->fiber_count);
    out->muscle_of = SN_NEW(sn_index, input->fiber_count);
    out->company = SN_NEW(sn_arm_company, input->other_count);
    out->fiber_low = SN_NEW(double, input->fiber_count);
    out->fiber_high = SN_NEW(double, input->fiber_count);
    if (!out->fiber_low || !out->fiber_high) return sn_fail_memory(r->error, "moment arms");
    if (!out->angles || !out->muscles || !out->fibers || !out->coefficients || !out->muscle_of || !out->company)
        return sn_fail_memory(r->error, "moment arms");
    for (sn_index f = 0; f < input->fiber_count; f++) out->muscle_of[f] = input->muscle_of[f];
    return SN_OK;
}

static void spread_angles(const run *r) {
    sn_arms *out = r->out;
    sn_index last = out->sample_count - 1;
    out->low = r->all.low;
    out->high = r->all.high;
    out->angle_count = r->all.angles;
    for (sn_index k = 0; k <= last; k++) out->angles[k] = k == last ? out->high : out->low + (out->high - out->low) * k / last;
}

static sn_status prepare(run *r) {
    sn_status status = take_all(r);
    if (status == SN_OK) status = check_range(r);
    if (status == SN_OK) status = check_lengths(r);
    if (status == SN_OK) status = allocate(r);
    if (status != SN_OK) return status;
    spread_angles(r);
    status = find_gaps(r);
    if (status == SN_OK) status = sn_sweeps_find(r->input->row_count, r->input->coordinate, &r->out->sweeps, r->error);
    if (status == SN_OK) status = take_way(r, true, &r->ways[0]);
    if (status == SN_OK) status = take_way(r, false, &r->ways[1]);
    if (status != SN_OK) return status;
    r->out->has_up = sn_arm_way_holds(&r->ways[0], 1);
    r->out->has_down = sn_arm_way_holds(&r->ways[1], 1);
    bool both = r->out->has_up && r->out->has_down;
    return sn_arm_company_find(r->input, both ? r->ways : &r->all, both ? 2 : 1, r->out->company, r->error);
}

sn_status sn_moment_arms(const sn_arm_input *input, const sn_arm_params *params, sn_arms *out, sn_error *error) {
    run r = {.input = input, .params = params, .error = error, .out = out};
    *out = (sn_arms){0};
    if (params->samples < 2 || (params->knots != 0 && (params->knots < 2 || params->knots > SN_ARM_MOST_KNOTS)))
        return sn_fail(error, SN_ERROR_USAGE, "arms need 2 samples or more, and 2 to %d knots", SN_ARM_MOST_KNOTS);
    sn_status status = prepare(&r);
    if (status == SN_OK) status = do_muscles(&r);
    sn_arm_way_free(&r.all);
    sn_arm_way_free(&r.ways[0]);
    sn_arm_way_free(&r.ways[1]);
    free(r.in_gap);
    if (status != SN_OK && status != SN_STOPPED) sn_arms_free(out);
    return status;
}

double sn_arm_of_fiber(const sn_arms *arms, sn_index fiber, double angle) {
    double slope;
    if (arms->coefficients[fiber] == NULL || !(angle >= arms->fiber_low[fiber] && angle <= arms->fiber_high[fiber])) return NAN;
    sn_spline_fit_at(arms->muscles[arms->muscle_of[fiber]].fit, arms->coefficients[fiber], angle, &slope);
    return -slope;
}

double sn_arm_of_muscle(const sn_arms *arms, sn_index muscle, double angle) {
    double sum = 0.0;
    sn_index count = 0;
    for (sn_index f = 0; f < arms->fiber_count; f++) {
        double arm = arms->muscle_of[f] == muscle ? sn_arm_of_fiber(arms, f, angle) : NAN;
        if (isnan(arm)) continue;
        sum += arm;
        count++;
    }
    return count > 0 ? sum / count : NAN;
}

static void free_muscle(sn_muscle_arms *m) {
    double *all[] = {m->mean, m->spread, m->lower, m->upper, m->noise, m->up, m->down};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    sn_spline_fit_destroy(m->fit);
}

void sn_arms_free(sn_arms *arms) {
    for (sn_index f = 0; f < arms->fiber_count; f++) {
        if (arms->fibers != NULL) free(arms->fibers[f]);
        if (arms->coefficients != NULL) free(arms->coefficients[f]);
    }
    /* a muscle that failed half way is not counted, but has its arrays: all that were asked for are looked at */
    for (sn_index i = 0; arms->muscles != NULL && i < arms->muscle_room; i++) free_muscle(&arms->muscles[i]);
    sn_sweeps_free(&arms->sweeps);
    free(arms->angles);
    free(arms->muscles);
    free(arms->fibers);
    free(arms->coefficients);
    free(arms->muscle_of);
    free(arms->fiber_low);
    free(arms->fiber_high);
    free(arms->company);
    *arms = (sn_arms){0};
}
