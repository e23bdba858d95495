/*
 * sense.h -- sensors on a motion: readings of its joints, and the activations that they give.   rank 2
 *
 * [R18] = Romeo, Monteagudo, Sanchez-Quiros 2018, 4.2 and figures 15, 16. Lengths are metres, angles radians, times seconds.
 */
#ifndef SINEW_SENSE_H
#define SINEW_SENSE_H

#include "sinew/motion_clip.h"

/* ---- what is measured -------------------------------------------------------------------------------------------------------- */

typedef enum sn_sensor_kind {
    SN_SENSOR_ANGLE,                /* of a joint away from rest: about an axis, or in all */
    SN_SENSOR_ANGULAR_VELOCITY,     /* projected on an axis, or its size */
    SN_SENSOR_ANGULAR_ACCELERATION, /* the same */
    SN_SENSOR_POSITION,             /* of a point along an axis */
    SN_SENSOR_VELOCITY,             /* of a point: projected on an axis, or its size */
    SN_SENSOR_ACCELERATION,         /* the same */
    SN_SENSOR_DISTANCE              /* from one point to another: along an axis, or in all */
} sn_sensor_kind;
extern const char *const sn_sensor_kind_names[]; /* "angle", "angularVelocity", ...; NULL at the end */
/* Of its readings as people see them: "degrees", "degrees/s", "m", ... */
const char *sn_sensor_unit(sn_sensor_kind kind);
/* How many of that unit make one of the library's: 180/pi for angles, else 1. */
double sn_sensor_scale(sn_sensor_kind kind);

/* A point that a joint carries. */
typedef struct sn_sensor_place {
    char *joint;    /* owned; NULL = the point stays where it is in the world */
    char *at;       /* owned: its rest place is the centre of the joint of this name; NULL = see the next two */
    bool end;       /* its rest place is the end of the joint's segment */
    bool has_point; /* it is `point`; where nothing is told, the joint's centre */
    sn_vec3 point;  /* rest pose, world */
} sn_sensor_place;

/*
 * [R18]'s trigger. It fires when what it looks at rises above `threshold`: activation goes in a straight line from where it is to `level`
 * within `attack`, stays there for `hold`, and on until what it looks at has fallen below threshold - hysteresis; then it decays as
 * exp(-t / decay). What has once been fired comes to its level. Where the first sample is above the threshold, the level is there from the
 * beginning and nothing has fired. `below`: all with the sign of threshold and reading turned.
 */
typedef struct sn_trigger {
    bool below;
    double threshold, hysteresis;      /* of what it looks at; hysteresis >= 0 */
    double attack, hold, decay, level; /* s, s, s; all >= 0; level in [0,1] */
} sn_trigger;

typedef struct sn_sensor {
    char *name; /* owned; no two alike */
    sn_sensor_kind kind;
    sn_sensor_place place; /* of angles: the joint alone counts */
    sn_sensor_place other; /* DISTANCE: where to */
    char *reference;       /* owned; joint in whose frame (as it was at rest) all is measured; NULL = see the next */
    bool world;            /* in the world's; where neither is told, angles are measured in the parent's, all else in the world's */
    bool has_axis;
    sn_vec3 axis;                   /* unit; rest pose, world, and carried by the reference */
    double cutoff;                  /* Hz, of the filter; 0 = none; negative = that of all sensors */
    sn_index knot_count;            /* of the curve from reading to activation; 0 = there is none */
    double *readings, *activations; /* (knot_count) owned: ascending; in [0,1] */
    bool has_trigger;               /* looks at the curve's activation where there is a curve, else at the reading */
    sn_trigger trigger;
} sn_sensor;

typedef enum sn_combination { SN_COMBINE_MAX, SN_COMBINE_SUM, SN_COMBINE_PRODUCT, SN_COMBINE_MEAN } sn_combination;
extern const char *const sn_combination_names[]; /* "max", "sum", "product", "mean"; NULL at the end */

/* Each activation times its weight; mean: their sum over the sum of weights. What comes out is cut to [0,1]. */
typedef struct sn_sense_input {
    sn_index sensor;
    double weight;
} sn_sense_input;

typedef struct sn_sense_channel {
    char *name; /* owned; of a muscle, most often; no two alike */
    sn_combination combination;
    sn_index input_count;
    sn_sense_input *inputs; /* (input_count) owned */
    bool has_trigger;       /* looks at the combined activation */
    sn_trigger trigger;
    double floor; /* the activation is never below this; in [0,1] */
} sn_sense_channel;

typedef struct sn_sensors {
    char *name;    /* owned, nullable */
    double cutoff; /* Hz; 0 = no filter */
    sn_index sensor_count, channel_count;
    sn_sensor *sensors;         /* (sensor_count) owned */
    sn_sense_channel *channels; /* (channel_count) owned */
} sn_sensors;
void sn_sensors_free(sn_sensors *sensors); /* leaves all zeros */

/* ---- measuring ----------------------------------------------------------------------------------------------------------------- */

/* Moments at which a trigger has fired, between samples too. */
typedef struct sn_firings {
    sn_index count;
    double *times;   /* (count) owned: seconds, of the motion */
    bool from_start; /* it was on at the first sample */
} sn_firings;

/* One value a sample for each sensor and channel: sample k of the inner rate is at begin + k / (rate x stride). */
typedef struct sn_sense {
    double begin, rate; /* of what is put out: every stride-th sample */
    sn_index stride, sample_count;
    sn_index sensor_count, channel_count; /* done: fewer than there are where the trace has stopped it */
    double **readings;                    /* (sensor_count) x (sample_count): radians, metres, seconds; owned */
    double **sensed;                      /* (sensor_count) x (sample_count): in [0,1]; owned */
    sn_firings *sensor_firings;           /* (sensor_count) owned */
    double **activations;                 /* (channel_count) x (sample_count): in [0,1]; owned */
    sn_firings *channel_firings;          /* (channel_count) owned */
    double *cut;                          /* (channel_count) owned: share of the samples that were above 1 or below 0 */
} sn_sense;

typedef struct sn_sense_params {
    double rate;     /* of the output, Hz; 0 = the clip's, or its least multiple that is not below SN_SENSE_LEAST_OUTPUT */
    double cutoff;   /* Hz: instead of all cutoffs of the sensors; negative = theirs */
    sn_trace *trace; /* nullable: a step "sensor" each, then a step "channel" each */
} sn_sense_params;
#define SN_SENSE_PARAMS ((sn_sense_params){.cutoff = -1.0})

/* Between frames a motion goes along splines of the 5th degree: so the same motion is the same at any rate that can tell it. They are
 * sampled at a multiple of the output's rate which is neither below this, Hz, nor below the clip's; filtered (sn_clip_filter); and
 * differentiated by central differences over five samples, beyond the ends on the polynomial through five. A filter that is not below half
 * of the clip's rate has nothing to take, and is left out. */
#define SN_SENSE_LEAST_RATE 240.0
#define SN_SENSE_LEAST_OUTPUT 120.0

/*
 * Angles: of the rotation away from rest, in the frame of the reference; about an axis it is the twist of swing and twist
 * (Dobrowolski 2015), 2 atan2(v . axis, w), continued over whole turns; in all 2 atan2(|v|, |w|), 0 to pi. Velocity and acceleration of a
 * point are those seen from the reference. SN_ERROR_INPUT names a sensor whose joint or point the motion lacks.
 */
SN_MUST_CHECK sn_status sn_sense_run(const sn_sensors *sensors, const sn_clip *clip, const sn_sense_params *params, sn_sense *out,
                                     sn_error *error);
void sn_sense_free(sn_sense *sense); /* leaves all zeros */

#endif
