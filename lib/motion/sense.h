/*
 * sense.h -- what the parts of sn_sense_run share. Private to lib/motion.
 */
#ifndef SN_MOTION_SENSE_H
#define SN_MOTION_SENSE_H

#include "sinew/sense.h"

/* Samples beyond each end, for central differences over five. */
enum { SN_SENSE_PADDING = 2 };

/* A clip's joints, without its coordinates, at k / rate seconds after its first frame, k < count: by splines of the 5th degree through
 * quaternions and shifts in the parents' frames (sn_clip_to_local). */
SN_MUST_CHECK sn_status sn_sense_sample(const sn_clip *clip, double rate, sn_index count, sn_clip *out, sn_error *error);
/* SN_SENSE_PADDING samples more at each end; afterwards frame SN_SENSE_PADDING is the first one. */
SN_MUST_CHECK sn_status sn_sense_pad(sn_clip *clip, sn_error *error);

/* A sensor's place in a clip: a joint, SN_NONE = the world; the point in the rest pose. */
typedef struct sn_sense_point {
    sn_index joint;
    sn_vec3 rest;
} sn_sense_point;
typedef struct sn_sense_bound {
    const sn_sensor *sensor;
    sn_index reference; /* SN_NONE = the world */
    sn_sense_point place, other;
} sn_sense_bound;
/* SN_ERROR_INPUT names the sensor and what the clip lacks. */
SN_MUST_CHECK sn_status sn_sense_bind(const sn_sensor *sensor, const sn_clip *clip, sn_sense_bound *out, sn_error *error);

/* fine: padded; readings (frames without the padding). */
SN_MUST_CHECK sn_status sn_sense_read(const sn_sense_bound *bound, const sn_clip *fine, double *readings, sn_error *error);

/* Values (count) that are 1/rate apart, the first one at `begin`. */
typedef struct sn_series {
    const double *values;
    sn_index count;
    double begin, rate;
} sn_series;

/* What a trigger makes of a series: out (count). */
SN_MUST_CHECK sn_status sn_trigger_run(const sn_trigger *trigger, const sn_series *series, double *out, sn_firings *firings,
                                       sn_error *error);

#endif
