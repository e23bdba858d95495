/* sense.c -- sensors measured over a motion, and the activations that they give. */
#include "sense.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/numeric.h"

const char *const sn_sensor_kind_names[] = {
    "angle", "angularVelocity", "angularAcceleration", "position", "velocity", "acceleration", "distance", NULL};
const char *const sn_combination_names[] = {"max", "sum", "product", "mean", NULL};

const char *sn_sensor_unit(sn_sensor_kind kind) {
    static const char *const units[] = {"degrees", "degrees/s", "degrees/s^2", "m", "m/s", "m/s^2", "m"};
    return units[kind];
}

double sn_sensor_scale(sn_sensor_kind kind) { return kind <= SN_SENSOR_ANGULAR_ACCELERATION ? 180.0 / SN_PI : 1.0; }

/* ---- memory ------------------------------------------------------------------------------------------------------------------------ */

static void free_place(sn_sensor_place *place) {
    free(place->joint);
    free(place->at);
}

void sn_sensors_free(sn_sensors *sensors) {
    for (sn_index i = 0; i < sensors->sensor_count; i++) {
        sn_sensor *sensor = &sensors->sensors[i];
        free(sensor->name);
        free_place(&sensor->place);
        free_place(&sensor->other);
        free(sensor->reference);
        free(sensor->readings);
        free(sensor->activations);
    }
    for (sn_index i = 0; i < sensors->channel_count; i++) {
        free(sensors->channels[i].name);
        free(sensors->channels[i].inputs);
    }
    free(sensors->sensors);
    free(sensors->channels);
    free(sensors->name);
    *sensors = (sn_sensors){0};
}

static void free_rows(double **rows, sn_firings *firings, sn_index count) {
    for (sn_index i = 0; i < count; i++) {
        if (rows != NULL) free(rows[i]);
        if (firings != NULL) free(firings[i].times);
    }
    free(rows);
    free(firings);
}

void sn_sense_free(sn_sense *sense) {
    free_rows(sense->readings, NULL, sense->sensor_count);
    free_rows(sense->sensed, sense->sensor_firings, sense->sensor_count);
    free_rows(sense->activations, sense->channel_firings, sense->channel_count);
    free(sense->cut);
    *sense = (sn_sense){0};
}

static sn_status allocate(const sn_sensors *sensors, sn_sense *out, sn_error *error) {
    out->readings = SN_NEW(double *, sensors->sensor_count);
    out->sensed = SN_NEW(double *, sensors->sensor_count);
    out->sensor_firings = SN_NEW(sn_firings, sensors->sensor_count);
    out->activations = SN_NEW(double *, sensors->channel_count);
    out->channel_firings = SN_NEW(sn_firings, sensors->channel_count);
    out->cut = SN_NEW(double, sensors->channel_count);
    bool enough = out->readings && out->sensed && out->sensor_firings && out->activations && out->channel_firings && out->cut;
    return enough ? SN_OK : sn_fail_memory(error, "readings");
}

/* ---- the motion at one rate, under each filter ------------------------------------------------------------------------------------- */

typedef struct filtered {
    double cutoff;
    sn_clip fine;
} filtered;

typedef struct run {
    const sn_sensors *sensors;
    const sn_clip *clip;
    const sn_sense_params *params;
    double rate; /* inner */
    sn_index count;
    filtered *motions; /* (motion_count) */
    sn_index motion_count;
    size_t motion_capacity;
} run;

static double cutoff_of(const run *r, const sn_sensor *sensor) {
    double cutoff = r->params->cutoff >= 0.0 ? r->params->cutoff : sensor->cutoff >= 0.0 ? sensor->cutoff : r->sensors->cutoff;
    return cutoff < 0.5 * r->clip->rate ? cutoff : 0.0;
}

static sn_status motion_under(run *r, double cutoff, const sn_clip **out, sn_error *error) {
    for (sn_index i = 0; i < r->motion_count; i++) {
        *out = &r->motions[i].fine;
        if (r->motions[i].cutoff == cutoff) return SN_OK;
    }
    if (!sn_grow((void **)&r->motions, &r->motion_capacity, (size_t)r->motion_count + 1, sizeof *r->motions))
        return sn_fail_memory(error, "a filtered motion");
    filtered *motion = &r->motions[r->motion_count++];
    *motion = (filtered){.cutoff = cutoff};
    *out = &motion->fine;
    sn_status status = sn_sense_sample(r->clip, r->rate, r->count, &motion->fine, error);
    if (status == SN_OK && cutoff > 0.0) status = sn_clip_filter(&motion->fine, cutoff, NULL, error);
    return status == SN_OK ? sn_sense_pad(&motion->fine, error) : status;
}

/* ---- one sensor, one channel ---------------------------------------------------------------------------------------------------- */

static sn_status apply_curve(const sn_sensor *sensor, const double *readings, sn_index count, double *out, sn_error *error) {
    sn_curve *curve;
    sn_status status = sn_curve_create(sensor->knot_count, sensor->readings, sensor->activations, &curve, error);
    for (sn_index k = 0; k < count && status == SN_OK; k++) out[k] = fmin(fmax(sn_curve_at(curve, readings[k]), 0.0), 1.0);
    sn_curve_destroy(curve);
    return status;
}

/* A sensor with neither curve nor trigger measures, and activates nothing. */
static sn_status activate(const sn_sensor *sensor, const run *r, double *readings, double *out, sn_firings *firings, sn_error *error) {
    sn_status status = SN_OK;
    const double *seen = readings;
    double *curved = NULL;
    if (sensor->knot_count > 0) {
        if ((curved = SN_NEW(double, r->count)) == NULL) return sn_fail_memory(error, "an activation");
        status = apply_curve(sensor, readings, r->count, curved, error);
        seen = curved;
    }
    if (status == SN_OK && sensor->has_trigger)
        status = sn_trigger_run(&sensor->trigger, &(sn_series){seen, r->count, r->clip->begin, r->rate}, out, firings, error);
    else if (status == SN_OK && curved != NULL)
        memcpy(out, curved, (size_t)r->count * sizeof *out);
    free(curved);
    return status;
}

static sn_status check_finite(const sn_sensor *sensor, const double *readings, sn_index count, sn_error *error) {
    for (sn_index k = 0; k < count; k++)
        if (!isfinite(readings[k]))
            return sn_fail(error, SN_ERROR_INPUT, "sensor \"%s\": its reading is not a finite number; is its point too far away?",
                           sensor->name);
    return SN_OK;
}

static sn_status sense(run *r, sn_index i, sn_sense *out, sn_error *error) {
    const sn_sensor *sensor = &r->sensors->sensors[i];
    const sn_clip *fine = NULL;
    sn_sense_bound bound;
    out->readings[i] = SN_NEW(double, r->count);
    out->sensed[i] = SN_NEW(double, r->count);
    out->sensor_count = i + 1;
    if (out->readings[i] == NULL || out->sensed[i] == NULL) return sn_fail_memory(error, "readings");
    sn_status status = sn_sense_bind(sensor, r->clip, &bound, error);
    if (status == SN_OK) status = motion_under(r, cutoff_of(r, sensor), &fine, error);
    if (status == SN_OK) status = sn_sense_read(&bound, fine, out->readings[i], error);
    if (status == SN_OK) status = check_finite(sensor, out->readings[i], r->count, error);
    return status == SN_OK ? activate(sensor, r, out->readings[i], out->sensed[i], &out->sensor_firings[i], error) : status;
}

static double combine(const sn_sense_channel *channel, double *const *sensed, sn_index k) {
    double sum = 0.0, product = 1.0, most = -INFINITY, weights = 0.0;
    for (sn_index i = 0; i < channel->input_count; i++) {
        double weight = channel->inputs[i].weight, value = weight * sensed[channel->inputs[i].sensor][k];
        sum += value;
        product *= value;
        most = fmax(most, value);
        weights += weight;
    }
    return channel->combination == SN_COMBINE_MAX    ? most
           : channel->combination == SN_COMBINE_SUM  ? sum
           : channel->combination == SN_COMBINE_MEAN ? sum / weights
                                                     : product;
}

static sn_status feed(const run *r, sn_index i, sn_sense *out, sn_error *error) {
    const sn_sense_channel *channel = &r->sensors->channels[i];
    double *values = out->activations[i] = SN_NEW(double, r->count), *level = SN_NEW(double, r->count);
    sn_index cut = 0;
    sn_status status = SN_OK;
    out->channel_count = i + 1;
    if (values == NULL || level == NULL) {
        free(level);
        return sn_fail_memory(error, "an activation");
    }
    for (sn_index k = 0; k < r->count; k++) {
        double value = combine(channel, out->sensed, k);
        cut += value > 1.0 || value < 0.0;
        level[k] = values[k] = fmin(fmax(value, 0.0), 1.0);
    }
    out->cut[i] = cut / (double)r->count;
    if (channel->has_trigger)
        status = sn_trigger_run(&channel->trigger, &(sn_series){level, r->count, r->clip->begin, r->rate}, values, &out->channel_firings[i],
                                error);
    for (sn_index k = 0; k < r->count; k++) values[k] = fmax(values[k], channel->floor);
    free(level);
    return status;
}

/* ---- all of them ------------------------------------------------------------------------------------------------------------------- */

static void range_of(const double *values, sn_index count, double *least, double *most) {
    *least = *most = values[0];
    for (sn_index k = 1; k < count; k++) {
        *least = fmin(*least, values[k]);
        *most = fmax(*most, values[k]);
    }
}

static bool trace_sensor(const run *r, sn_index i, const sn_sense *out) {
    const sn_sensor *sensor = &r->sensors->sensors[i];
    double least, most, scale = sn_sensor_scale(sensor->kind);
    range_of(out->readings[i], r->count, &least, &most);
    return SN_TRACE(r->params->trace, "sensor", sn_trace_text("sensor", sensor->name), sn_trace_text("unit", sn_sensor_unit(sensor->kind)),
                    sn_trace_number("least", least * scale), sn_trace_number("greatest", most * scale),
                    sn_trace_number("fired", out->sensor_firings[i].count));
}

static bool trace_channel(const run *r, sn_index i, const sn_sense *out) {
    double least, most;
    range_of(out->activations[i], r->count, &least, &most);
    return SN_TRACE(r->params->trace, "channel", sn_trace_text("channel", r->sensors->channels[i].name), sn_trace_number("least", least),
                    sn_trace_number("greatest", most), sn_trace_number("fired", out->channel_firings[i].count));
}

static sn_status measure(run *r, sn_sense *out, sn_error *error) {
    sn_status status = allocate(r->sensors, out, error);
    for (sn_index i = 0; i < r->sensors->sensor_count && status == SN_OK; i++) {
        if (sn_trace_stopped(r->params->trace)) return SN_STOPPED;
        status = sense(r, i, out, error);
        if (status == SN_OK && trace_sensor(r, i, out)) status = SN_STOPPED;
    }
    for (sn_index i = 0; i < r->sensors->channel_count && status == SN_OK; i++) {
        status = feed(r, i, out, error);
        if (status == SN_OK && trace_channel(r, i, out)) status = SN_STOPPED;
    }
    return status;
}

/* Times are multiples of 1/rate only to rounding. */
static const double SAME_TIME = 1e-6;

static sn_status choose_rates(const sn_clip *clip, const sn_sense_params *params, sn_sense *out, sn_error *error) {
    double times = fmax(1.0, ceil(SN_SENSE_LEAST_OUTPUT / clip->rate - SAME_TIME));
    out->begin = clip->begin;
    out->rate = params->rate > 0.0 ? params->rate : clip->rate * times;
    double stride = fmax(1.0, ceil(fmax(SN_SENSE_LEAST_RATE, clip->rate) / out->rate - SAME_TIME));
    double count = floor((clip->frame_count - 1) / clip->rate * out->rate * stride + SAME_TIME) + 1.0;
    if (!(count < SN_INDEX_MAX / 2) || !(stride < SN_INDEX_MAX / 2))
        return sn_fail(error, SN_ERROR_INPUT, "at %g Hz the motion would have %g samples; choose another rate", out->rate * stride, count);
    out->stride = (sn_index)stride;
    out->sample_count = (sn_index)count;
    return SN_OK;
}

sn_status sn_sense_run(const sn_sensors *sensors, const sn_clip *clip, const sn_sense_params *params, sn_sense *out, sn_error *error) {
    run r = {.sensors = sensors, .clip = clip, .params = params};
    *out = (sn_sense){0};
    sn_status status = choose_rates(clip, params, out, error);
    r.rate = out->rate * out->stride;
    r.count = out->sample_count;
    if (status == SN_OK) status = measure(&r, out, error);
    for (sn_index i = 0; i < r.motion_count; i++) sn_clip_free(&r.motions[i].fine);
    free(r.motions);
    if (status != SN_OK && status != SN_STOPPED) sn_sense_free(out);
    return status;
}
