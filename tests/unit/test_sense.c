/*
 * test_sense.c -- sensors on motions whose readings are known in closed form; what curves, triggers and channels make of them; sensors
 * documents with sides and patterns.
 */
#include "documents.h"

#include <math.h>

#include "sinew/sense.h"

/* ---- motions with known derivatives ---------------------------------------------------------------------------------------------------
 */

/* A scalar of time and its first two derivatives. */
typedef struct course {
    double value, rate, acceleration;
} course;
typedef course (*course_function)(double t);

static course uniform(double t) { return (course){0.3 + 1.7 * t, 1.7, 0.0}; }
static course accelerated(double t) { return (course){0.2 - 0.4 * t + 0.9 * t * t, -0.4 + 1.8 * t, 1.8}; }
static course harmonic(double t) {
    double w = 2.0 * SN_PI;
    return (course){0.8 * sin(w * t + 0.3), 0.8 * w * cos(w * t + 0.3), -0.8 * w * w * sin(w * t + 0.3)};
}
static const course_function courses[] = {uniform, accelerated, harmonic};

static const sn_vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.48, -0.6, 0.64}, {-2.0 / 3, 1.0 / 3, 2.0 / 3}};
enum { AXES = sizeof axes / sizeof *axes, COURSES = sizeof courses / sizeof *courses };

/* Joints "root" and "arm", its child. */
static sn_clip pair(double rate, double seconds) {
    sn_clip clip;
    assert_int_equal(sn_clip_create((sn_index)floor(seconds * rate + 0.5) + 1, 2, 0, &clip, NULL), SN_OK);
    clip.rate = rate;
    clip.joints[0].name = sn_strdup("root");
    clip.joints[1].name = sn_strdup("arm");
    clip.joints[1].parent = 0;
    clip.joints[0].rest = sn_v3(0.1, -0.2, 0.9);
    clip.joints[1].rest = sn_v3(0.3, 0.1, 1.2);
    clip.joints[1].has_end = true;
    clip.joints[1].end = sn_v3(0.3, 0.1, 1.6);
    return clip;
}

/* Everything is shifted along the axis. */
static sn_clip shifted(double rate, double seconds, course_function f, sn_vec3 axis) {
    sn_clip clip = pair(rate, seconds);
    for (sn_index k = 0; k < clip.frame_count; k++)
        for (sn_index j = 0; j < 2; j++) clip.joints[j].poses[k].translation = sn_scale(axis, f(k / rate).value);
    return clip;
}

/* The root wanders; the arm turns about the axis through its centre by the course, as the root has it. */
static sn_clip turned(double rate, double seconds, course_function f, sn_vec3 axis) {
    sn_clip clip = pair(rate, seconds);
    for (sn_index k = 0; k < clip.frame_count; k++) {
        double t = k / rate;
        clip.joints[0].poses[k] = (sn_rigid){sn_quat_axis_angle(sn_v3(0.6, 0, 0.8), 0.7 * sin(3.0 * t)), sn_v3(0.2 * t, 0.1, 0)};
        clip.joints[1].poses[k] = (sn_rigid){sn_quat_axis_angle(axis, f(t).value), {0, 0, 0}};
    }
    sn_clip_to_world(&clip);
    return clip;
}

static sn_sensor sensor_of(sn_sensor_kind kind, const char *joint, const sn_vec3 *axis) {
    sn_sensor sensor = {.name = sn_strdup("s"), .kind = kind, .cutoff = -1.0};
    sensor.place.joint = joint != NULL ? sn_strdup(joint) : NULL;
    sensor.has_axis = axis != NULL;
    if (axis != NULL) sensor.axis = *axis;
    return sensor;
}

/* Sensors of one sensor that feeds one channel. Takes what the sensor owns. */
static sn_sensors alone(sn_sensor sensor) {
    sn_sensors sensors = {.sensor_count = 1, .channel_count = 1, .sensors = SN_NEW(sn_sensor, 1), .channels = SN_NEW(sn_sense_channel, 1)};
    sensors.sensors[0] = sensor;
    sensors.channels[0] = (sn_sense_channel){.name = sn_strdup("m"), .input_count = 1, .inputs = SN_NEW(sn_sense_input, 1)};
    sensors.channels[0].inputs[0] = (sn_sense_input){0, 1.0};
    return sensors;
}

static sn_sense run(sn_sensors *sensors, const sn_clip *clip, double rate) {
    sn_sense sense;
    sn_error error = {0};
    sn_sense_params params = SN_SENSE_PARAMS;
    params.rate = rate;
    if (sn_sense_run(sensors, clip, &params, &sense, &error) != SN_OK) fail_msg("%s", error.text);
    return sense;
}

/* The readings of one sensor are those expected, within a share of the greatest, or of 1 where that is less; from the first sample to the
 * last. Where the rate is so low that a second has less than 50 frames, within a hundredth next to the ends. */
static void assert_readings(const sn_clip *clip, sn_sensor sensor, course_function f, int derivative, bool size, double share) {
    sn_sensors sensors = alone(sensor);
    sn_sense sense = run(&sensors, clip, 0.0);
    double worst = 0.0, greatest = 1.0, at = 0.0, seconds = (clip->frame_count - 1) / clip->rate;
    for (sn_index k = 0; k < sense.sample_count; k++) greatest = fmax(greatest, fabs(sense.readings[0][k]));
    for (sn_index k = 0; k < sense.sample_count; k++) {
        double t = k / (sense.rate * sense.stride), allowed = clip->rate < 50.0 && (t < 0.2 || t > seconds - 0.2) ? 0.01 : share;
        course c = f(t);
        double expected = derivative == 0 ? c.value : derivative == 1 ? c.rate : c.acceleration;
        double wrong = fabs(sense.readings[0][k] - (size ? fabs(expected) : expected)) / (allowed * greatest);
        if (wrong > worst) {
            worst = wrong;
            at = t;
        }
    }
    if (!(worst <= 1.0)) fail_msg("kind %d, %g Hz: wrong by %g times what is allowed at %g s", (int)sensor.kind, clip->rate, worst, at);
    assert_true(sense.sample_count >= 240);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
}

static const double rates[] = {24.0, 60.0, 120.0, 240.0, 300.0};
enum { RATES = sizeof rates / sizeof *rates };

static void points_are_read_to_a_thousandth(void **state) {
    (void)state;
    for (int a = 0; a < AXES; a++)
        for (int c = 0; c < COURSES; c++)
            for (int r = 0; r < RATES; r++) {
                sn_clip clip = shifted(rates[r], 2.0, courses[c], axes[a]);
                assert_readings(&clip, sensor_of(SN_SENSOR_VELOCITY, "arm", &axes[a]), courses[c], 1, false, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_VELOCITY, "arm", NULL), courses[c], 1, true, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ACCELERATION, "arm", &axes[a]), courses[c], 2, false, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ACCELERATION, "root", NULL), courses[c], 2, true, 1e-3);
                sn_sensor place = sensor_of(SN_SENSOR_POSITION, "root", &axes[a]);
                place.place.has_point = true; /* the origin at rest */
                assert_readings(&clip, place, courses[c], 0, false, 1e-6);
                sn_clip_free(&clip);
            }
}

static void joints_are_read_to_a_thousandth(void **state) {
    (void)state;
    for (int a = 0; a < AXES; a++)
        for (int c = 0; c < COURSES; c++)
            for (int r = 0; r < RATES; r++) {
                sn_clip clip = turned(rates[r], 2.0, courses[c], axes[a]);
                assert_readings(&clip, sensor_of(SN_SENSOR_ANGLE, "arm", &axes[a]), courses[c], 0, false, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ANGULAR_VELOCITY, "arm", &axes[a]), courses[c], 1, false, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ANGULAR_VELOCITY, "arm", NULL), courses[c], 1, true, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ANGULAR_ACCELERATION, "arm", &axes[a]), courses[c], 2, false, 1e-3);
                assert_readings(&clip, sensor_of(SN_SENSOR_ANGULAR_ACCELERATION, "arm", NULL), courses[c], 2, true, 1e-3);
                sn_clip_free(&clip);
            }
}

/* In all: 0 to pi, whatever the sign; here below a half turn. */
static course small(double t) { return (course){0.8 * sin(2.0 * SN_PI * t), 0.0, 0.0}; }

static void whole_angle_is_of_any_axis(void **state) {
    (void)state;
    for (int a = 0; a < AXES; a++) {
        sn_clip clip = turned(60.0, 2.0, small, axes[a]);
        assert_readings(&clip, sensor_of(SN_SENSOR_ANGLE, "arm", NULL), small, 0, true, 1e-3);
        sn_clip_free(&clip);
    }
}

/* Off its axis: a turn about z is none about x, and a motion along x has no velocity along y. */
static course nothing(double t) { return (course){0.0 * t, 0.0, 0.0}; }

static void what_is_across_is_not_read(void **state) {
    (void)state;
    sn_clip spin = turned(60.0, 2.0, uniform, sn_v3(0, 0, 1)), slide = shifted(60.0, 2.0, harmonic, sn_v3(1, 0, 0));
    for (int kind = SN_SENSOR_ANGLE; kind <= SN_SENSOR_ANGULAR_ACCELERATION; kind++)
        assert_readings(&spin, sensor_of((sn_sensor_kind)kind, "arm", &axes[0]), nothing, 0, false, 1e-4);
    assert_readings(&slide, sensor_of(SN_SENSOR_VELOCITY, "arm", &axes[1]), nothing, 0, false, 1e-6);
    assert_readings(&slide, sensor_of(SN_SENSOR_ACCELERATION, "arm", &axes[1]), nothing, 0, false, 1e-6);
    sn_clip_free(&spin);
    sn_clip_free(&slide);
}

/* The end of the arm, 0.4 above its centre, turns about x: on a circle. Relative to the arm itself it is at rest. */
static course end_speed(double t) { return (course){0.0, fabs(0.4 * harmonic(t).rate), 0.0}; }
static course end_height(double t) { return (course){1.2 + 0.4 * cos(harmonic(t).value), 0.0, 0.0}; }

static void points_turn_with_their_joint(void **state) {
    (void)state;
    sn_clip clip = turned(120.0, 2.0, harmonic, axes[0]);
    sn_sensor speed = sensor_of(SN_SENSOR_VELOCITY, "arm", NULL), height = sensor_of(SN_SENSOR_POSITION, "arm", &axes[2]),
              own = sensor_of(SN_SENSOR_VELOCITY, "arm", NULL);
    speed.place.end = height.place.end = own.place.end = true;
    speed.reference = sn_strdup("root");
    height.reference = sn_strdup("root");
    own.reference = sn_strdup("arm");
    assert_readings(&clip, speed, end_speed, 1, false, 2e-3); /* a sine of a sine: four times as fast */
    assert_readings(&clip, height, end_height, 0, false, 1e-4);
    assert_readings(&clip, own, nothing, 0, false, 1e-6);
    sn_clip_free(&clip);
}

/* From the root's centre to the arm's end: the law of cosines, in any frame. */
static course from_root(double t) {
    double angle = harmonic(t).value; /* about x, through the arm's centre */
    return (course){
        sqrt(0.2 * 0.2 + (0.3 - 0.4 * sin(angle)) * (0.3 - 0.4 * sin(angle)) + (0.3 + 0.4 * cos(angle)) * (0.3 + 0.4 * cos(angle))), 0, 0};
}
static course upwards(double t) { return (course){0.3 + 0.4 * cos(harmonic(t).value), 0, 0}; }

static void distances_are_of_points_in_motion(void **state) {
    (void)state;
    sn_clip clip = turned(120.0, 2.0, harmonic, axes[0]);
    for (int projected = 0; projected < 2; projected++) {
        sn_sensor sensor = sensor_of(SN_SENSOR_DISTANCE, "root", projected ? &axes[2] : NULL);
        sensor.other.joint = sn_strdup("arm");
        sensor.other.end = true;
        sensor.reference = sn_strdup("root");
        assert_readings(&clip, sensor, projected ? upwards : from_root, 0, false, 1e-4);
    }
    sn_clip_free(&clip);
}

/* An angle goes on beyond half a turn, and a whole one. */
static void twist_goes_on_over_whole_turns(void **state) {
    (void)state;
    sn_clip clip = turned(60.0, 2.0, accelerated, axes[3]);
    for (sn_index k = 0; k < clip.frame_count; k++) {
        clip.joints[0].poses[k] = sn_rigid_identity();
        clip.joints[1].poses[k] = sn_clip_about(clip.joints[1].rest, (sn_rigid){sn_quat_axis_angle(axes[3], 8.0 * k / 60.0), {0, 0, 0}});
    }
    sn_sensors sensors = alone(sensor_of(SN_SENSOR_ANGLE, "arm", &axes[3]));
    sn_sense sense = run(&sensors, &clip, 60.0);
    assert_true(fabs(sense.readings[0][sense.sample_count - 1] - 16.0) < 1e-6);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void world_and_parent_are_other_references(void **state) {
    (void)state;
    sn_clip clip = turned(60.0, 1.0, harmonic, axes[2]);
    sn_sensor in_world = sensor_of(SN_SENSOR_ANGLE, "arm", NULL);
    in_world.world = true;
    sn_sensors of_parent = alone(sensor_of(SN_SENSOR_ANGLE, "arm", NULL)), of_world = alone(in_world);
    sn_sense a = run(&of_parent, &clip, 60.0), b = run(&of_world, &clip, 60.0);
    double apart = 0.0;
    for (sn_index k = 0; k < 61; k++) {
        sn_index at = k * b.stride;
        const sn_quat q = clip.joints[1].poses[k].rotation;
        double expected = 2.0 * atan2(sqrt(q.x * q.x + q.y * q.y + q.z * q.z), fabs(q.w));
        assert_true(fabs(b.readings[0][at] - expected) < 1e-9);
        apart = fmax(apart, fabs(a.readings[0][at] - b.readings[0][at]));
    }
    assert_true(apart > 0.1);
    sn_sense_free(&a);
    sn_sense_free(&b);
    sn_sensors_free(&of_parent);
    sn_sensors_free(&of_world);
    sn_clip_free(&clip);
}

/* ---- the same motion at other rates ---------------------------------------------------------------------------------------------------
 */

/* A gait of sorts: up to 2.8 Hz. */
static course gait(double t) {
    double w = 2.0 * SN_PI;
    return (course){0.5 * sin(0.9 * w * t) + 0.2 * sin(1.8 * w * t + 1.0) + 0.08 * sin(2.8 * w * t + 2.0), 0, 0};
}

static sn_sensor curved(sn_sensor_kind kind, const sn_vec3 *axis, double low, double high) {
    sn_sensor sensor = sensor_of(kind, "arm", axis);
    sensor.knot_count = 3;
    sensor.readings = SN_NEW(double, 3);
    sensor.activations = SN_NEW(double, 3);
    sensor.readings[0] = low;
    sensor.readings[1] = 0.5 * (low + high);
    sensor.readings[2] = high;
    sensor.activations[1] = 0.3;
    sensor.activations[2] = 1.0;
    return sensor;
}

static sn_sensor tip(sn_sensor sensor) {
    sensor.place.end = true;
    return sensor;
}

static sn_sensor triggered(sn_sensor_kind kind, const sn_vec3 *axis, double threshold) {
    sn_sensor sensor = sensor_of(kind, "arm", axis);
    sensor.has_trigger = true;
    sensor.trigger = (sn_trigger){.threshold = threshold, .hysteresis = 0.1 * threshold, .attack = 0.04, .decay = 0.2, .level = 1.0};
    return sensor;
}

/* Largest difference of the channel's activation between the clip at two rates, as a share of its range; a quarter of it within the first
 * and the last frame of the coarsest rate, where nothing lies beyond: what is fast comes out by 3.4 % wrong there at 24 Hz. */
static double disagreement(sn_sensor sensor, double cutoff, double rate, bool *fires) {
    int kind = (int)sensor.kind;
    sn_clip dense = turned(960.0, 4.0, gait, axes[3]), clip = turned(rate, 4.0, gait, axes[3]);
    sn_sensors sensors = alone(sensor);
    sensors.cutoff = cutoff;
    sn_sense exact = run(&sensors, &dense, 120.0), sense = run(&sensors, &clip, 120.0);
    double worst = 0.0, least = INFINITY, most = -INFINITY;
    for (sn_index k = 0; k <= 480; k++) {
        double a = exact.activations[0][k * exact.stride], b = sense.activations[0][k * sense.stride];
        bool at_end = k <= 5 || k >= 475;
        worst = fmax(worst, fabs(a - b) * (at_end ? 0.25 : 1.0));
        least = fmin(least, a);
        most = fmax(most, a);
    }
    *fires = sense.sensor_firings[0].count == exact.sensor_firings[0].count && exact.sensor_firings[0].count > 1;
    sn_sense_free(&exact);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&dense);
    sn_clip_free(&clip);
    if (!(most - least > 0.5)) fail_msg("kind %d: the activation goes from %g to %g only", kind, least, most);
    return worst / (most - least);
}

static void rates_agree_within_a_hundredth(void **state) {
    (void)state;
    const double samplings[] = {24.0, 60.0, 240.0}, cutoffs[] = {0.0, 6.0};
    bool fires;
    for (int c = 0; c < 2; c++)
        for (int r = 0; r < 3; r++) {
            double angle = disagreement(curved(SN_SENSOR_ANGLE, &axes[3], -0.5, 0.5), cutoffs[c], samplings[r], &fires),
                   speed = disagreement(curved(SN_SENSOR_ANGULAR_VELOCITY, &axes[3], -3.0, 4.0), cutoffs[c], samplings[r], &fires),
                   change = disagreement(curved(SN_SENSOR_ANGULAR_ACCELERATION, &axes[3], -40.0, 40.0), cutoffs[c], samplings[r], &fires),
                   point = disagreement(tip(curved(SN_SENSOR_ACCELERATION, NULL, 0.0, 20.0)), cutoffs[c], samplings[r], &fires),
                   fired = disagreement(triggered(SN_SENSOR_ANGULAR_VELOCITY, &axes[3], 2.0), cutoffs[c], samplings[r], &fires);
            if (!(fmax(fmax(angle, speed), fmax(change, fmax(point, fired))) < (cutoffs[c] > 0.0 ? 0.001 : 0.01)))
                fail_msg("%g Hz, filter %g: %g %g %g %g %g", samplings[r], cutoffs[c], angle, speed, change, point, fired);
            assert_true(fires);
        }
}

/* ---- triggers -------------------------------------------------------------------------------------------------------------------------
 */

/* The arm goes up by 1 m/s for a second, and down for a second, so that its reading passes 0.6 at 0.6 s and falls below 0.5 at 1.5 s. */
static sn_clip tent(void) {
    sn_clip clip = pair(240.0, 3.0);
    for (sn_index k = 0; k < clip.frame_count; k++) {
        double t = k / 240.0, z = t < 1.0 ? t : t < 2.0 ? 2.0 - t : 0.0;
        clip.joints[1].poses[k].translation = sn_v3(0, 0, z);
    }
    return clip;
}

static sn_sensor height_trigger(sn_trigger trigger) {
    sn_sensor sensor = sensor_of(SN_SENSOR_POSITION, "arm", &axes[2]);
    sensor.place.has_point = true;
    sensor.has_trigger = true;
    sensor.trigger = trigger;
    return sensor;
}

static double activation_at(const sn_sense *sense, double t) {
    return sense->activations[0][(sn_index)floor(t * sense->rate * sense->stride + 0.5)];
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance)) fail_msg("%g is not %g", found, expected);
}

static void trigger_rises_holds_and_decays(void **state) {
    (void)state;
    sn_clip clip = tent();
    sn_sensors sensors =
        alone(height_trigger((sn_trigger){.threshold = 0.6, .hysteresis = 0.1, .attack = 0.2, .decay = 0.25, .level = 0.8}));
    sn_sense sense = run(&sensors, &clip, 240.0);
    assert_int_equal(sense.sensor_firings[0].count, 1);
    assert_false(sense.sensor_firings[0].from_start);
    assert_near(sense.sensor_firings[0].times[0], 0.6, 1e-4);
    assert_near(activation_at(&sense, 0.55), 0.0, 0.0);
    assert_near(activation_at(&sense, 0.7), 0.4, 1e-3);
    assert_near(activation_at(&sense, 0.8), 0.8, 1e-3);
    assert_near(activation_at(&sense, 1.4), 0.8, 0.0); /* below the threshold, but not by the hysteresis */
    assert_near(activation_at(&sense, 1.75), 0.8 * exp(-1.0), 1e-3);
    assert_near(activation_at(&sense, 2.5), 0.8 * exp(-4.0), 1e-3);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void short_pulse_comes_to_its_level_and_is_held(void **state) {
    (void)state;
    sn_clip clip = tent();
    sn_sensors sensors = alone(height_trigger((sn_trigger){.threshold = 0.95, .attack = 0.3, .hold = 0.4, .decay = 0.1, .level = 1.0}));
    sn_sense sense = run(&sensors, &clip, 240.0);
    double fired = sense.sensor_firings[0].times[0]; /* below again a tenth of a second later */
    assert_near(fired, 0.95, 2e-3);
    assert_near(activation_at(&sense, 1.25), 1.0, 0.01);
    assert_near(activation_at(&sense, 1.64), 1.0, 0.0);
    assert_near(activation_at(&sense, 1.75), exp(-1.0), 0.03);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void trigger_below_and_from_the_start(void **state) {
    (void)state;
    sn_clip clip = tent();
    sn_sensors sensors =
        alone(height_trigger((sn_trigger){.below = true, .threshold = 0.4, .hysteresis = 0.2, .attack = 0.1, .decay = 0.2, .level = 1.0}));
    sn_sense sense = run(&sensors, &clip, 240.0);
    assert_true(sense.sensor_firings[0].from_start);
    assert_int_equal(sense.sensor_firings[0].count, 1);
    assert_near(sense.sensor_firings[0].times[0], 1.6, 1e-4);
    assert_near(activation_at(&sense, 0.0), 1.0, 0.0);
    assert_near(activation_at(&sense, 0.6), 1.0, 1e-3);
    assert_near(activation_at(&sense, 0.8), exp(-1.0), 1e-3);
    double before = exp(-5.0); /* it rises from where it is */
    assert_near(activation_at(&sense, 1.65), before + 0.5 * (1.0 - before), 2e-3);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

/* A noise of 4 cm around the threshold fires many times; a hysteresis of twice that, once. */
static void hysteresis_swallows_noise(void **state) {
    (void)state;
    uint64_t seed = 5;
    sn_clip clip = tent();
    for (sn_index k = 0; k < clip.frame_count; k++) clip.joints[1].poses[k].translation.z += 0.08 * (sn_random(&seed) - 0.5);
    for (int swallowed = 0; swallowed < 2; swallowed++) {
        sn_sensors sensors = alone(height_trigger((sn_trigger){.threshold = 0.6, .hysteresis = swallowed ? 0.12 : 0.0, .level = 1.0}));
        sn_sense sense = run(&sensors, &clip, 240.0);
        assert_true(swallowed ? sense.sensor_firings[0].count == 1 : sense.sensor_firings[0].count > 3);
        sn_sense_free(&sense);
        sn_sensors_free(&sensors);
    }
    sn_clip_free(&clip);
}

/* ---- channels -------------------------------------------------------------------------------------------------------------------------
 */

/* Two sensors that activate by z and by 1 - z of the tent, weighted 0.5 and 1. */
static sn_sensors two(sn_combination combination) {
    sn_sensors sensors = alone(sensor_of(SN_SENSOR_POSITION, "arm", &axes[2]));
    sensors.sensors = sn_realloc(sensors.sensors, 2, sizeof(sn_sensor));
    sensors.sensors[1] = sensor_of(SN_SENSOR_POSITION, "arm", &axes[2]);
    sensors.sensor_count = 2;
    for (int i = 0; i < 2; i++) {
        sn_sensor *sensor = &sensors.sensors[i];
        sensor->place.has_point = true;
        sensor->knot_count = 2;
        sensor->readings = SN_NEW(double, 2);
        sensor->activations = SN_NEW(double, 2);
        sensor->readings[1] = 1.0;
        sensor->activations[1 - i] = 1.0;
    }
    sn_sense_channel *channel = &sensors.channels[0];
    free(channel->inputs);
    channel->inputs = SN_NEW(sn_sense_input, 2);
    channel->input_count = 2;
    channel->combination = combination;
    channel->inputs[0] = (sn_sense_input){0, 0.5};
    channel->inputs[1] = (sn_sense_input){1, 1.0};
    return sensors;
}

static void channels_combine_weighted_sensors(void **state) {
    (void)state;
    sn_clip clip = tent();
    const double expected[] = {0.7, 0.15 + 0.7, 0.15 * 0.7, (0.15 + 0.7) / 1.5}; /* max, sum, product, mean at z = 0.3 */
    for (int c = 0; c < 4; c++) {
        sn_sensors sensors = two((sn_combination)c);
        sn_sense sense = run(&sensors, &clip, 240.0);
        assert_near(activation_at(&sense, 0.3), expected[c], 1e-9);
        assert_true(sense.cut[0] == 0.0);
        sn_sense_free(&sense);
        sn_sensors_free(&sensors);
    }
    sn_sensors sensors = two(SN_COMBINE_SUM); /* 4 z + (1 - z) / 2 */
    sensors.channels[0].inputs[0].weight = 4.0;
    sensors.channels[0].inputs[1].weight = -0.5;
    sensors.channels[0].floor = 0.1;
    sn_sense sense = run(&sensors, &clip, 240.0);
    assert_near(activation_at(&sense, 0.0), 0.1, 0.0);
    assert_near(activation_at(&sense, 0.2), 0.4, 1e-9);
    assert_near(activation_at(&sense, 0.9), 1.0, 0.0);
    assert_true(sense.cut[0] > 0.6 && sense.cut[0] < 0.9);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void channel_has_a_trigger_of_its_own(void **state) {
    (void)state;
    sn_clip clip = tent();
    sn_sensors sensors = two(SN_COMBINE_PRODUCT); /* z (1 - z) / 2: above 0.12 from 0.4 to 0.6, and again from 1.4 to 1.6 */
    sensors.channels[0].has_trigger = true;
    sensors.channels[0].trigger = (sn_trigger){.threshold = 0.12, .decay = 0.05, .level = 1.0};
    sn_sense sense = run(&sensors, &clip, 240.0);
    assert_int_equal(sense.channel_firings[0].count, 2);
    assert_near(sense.channel_firings[0].times[0], 0.4, 1e-3);
    assert_near(sense.channel_firings[0].times[1], 1.4, 1e-3);
    assert_near(activation_at(&sense, 0.5), 1.0, 0.0);
    assert_near(activation_at(&sense, 0.65), exp(-1.0), 0.01);
    sn_sense_free(&sense);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

/* ---- edges ----------------------------------------------------------------------------------------------------------------------------
 */

/* One frame, two, ... fewer than a spline of the 5th degree or five differences need. */
static void short_motions_have_readings(void **state) {
    (void)state;
    for (sn_index frames = 1; frames <= 8; frames++) {
        sn_clip clip = shifted(240.0, (frames - 1) / 240.0, uniform, axes[0]);
        assert_int_equal(clip.frame_count, frames);
        sn_sensors sensors = alone(sensor_of(SN_SENSOR_VELOCITY, "arm", &axes[0]));
        sn_sense sense = run(&sensors, &clip, 0.0);
        assert_int_equal(sense.sample_count, frames);
        for (sn_index k = 0; k < frames; k++) assert_near(sense.readings[0][k], frames > 1 ? 1.7 : 0.0, 1e-9);
        sn_sense_free(&sense);
        sn_sensors_free(&sensors);
        sn_clip_free(&clip);
    }
}

static void samples_lie_on_frames(void **state) {
    (void)state;
    const double of[] = {24.0, 25.0, 60.0, 100.0, 120.0, 240.0, 1000.0}, expected[] = {120.0, 125.0, 120.0, 200.0, 120.0, 240.0, 1000.0};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        sn_clip clip = shifted(of[i], 1.0, uniform, axes[0]);
        sn_sensors sensors = alone(sensor_of(SN_SENSOR_VELOCITY, "arm", &axes[0]));
        sn_sense sense = run(&sensors, &clip, 0.0);
        assert_near(sense.rate, expected[i], 0.0);
        assert_true(sense.rate * sense.stride >= fmax(SN_SENSE_LEAST_RATE, of[i]));
        assert_int_equal((sense.sample_count - 1) / sense.stride, (sn_index)sense.rate);
        sn_sense_free(&sense);
        sn_sensors_free(&sensors);
        sn_clip_free(&clip);
    }
}

/* Noise does not go wild at the ends, where differences need more than there is. */
static void ends_are_no_wilder_than_the_middle(void **state) {
    (void)state;
    uint64_t seed = 11;
    for (int filtered = 0; filtered < 2; filtered++) {
        sn_clip clip = shifted(120.0, 2.0, harmonic, axes[0]);
        for (sn_index j = 0; j < 2; j++)
            for (sn_index k = 0; k < clip.frame_count; k++) clip.joints[j].poses[k].translation.x += 1e-3 * (sn_random(&seed) - 0.5);
        sn_sensors sensors = alone(sensor_of(SN_SENSOR_ACCELERATION, "root", &axes[0]));
        sensors.cutoff = filtered ? 10.0 : 0.0;
        sn_sense sense = run(&sensors, &clip, 0.0);
        double middle = 0.0, ends = 0.0;
        for (sn_index k = 0; k < sense.sample_count; k++) {
            bool at_end = k < 24 || k >= sense.sample_count - 24;
            double *worst = at_end ? &ends : &middle;
            *worst = fmax(*worst, fabs(sense.readings[0][k]));
        }
        if (!(ends < 2.0 * middle)) fail_msg("%g at the ends, %g between them", ends, middle);
        sn_sense_free(&sense);
        sn_sensors_free(&sensors);
        sn_clip_free(&clip);
    }
}

static void assert_refused(sn_sensor sensor, const char *why) {
    sn_clip clip = tent();
    sn_sensors sensors = alone(sensor);
    sn_sense sense;
    sn_error error = {0};
    sn_sense_params params = SN_SENSE_PARAMS;
    assert_int_equal(sn_sense_run(&sensors, &clip, &params, &sense, &error), SN_ERROR_INPUT);
    assert_contains(error.text, why);
    assert_null(sense.readings);
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void what_the_motion_lacks_is_named(void **state) {
    (void)state;
    assert_refused(sensor_of(SN_SENSOR_ANGLE, "leg", NULL), "sensor \"s\": the motion has no joint \"leg\"");
    sn_sensor sensor = sensor_of(SN_SENSOR_VELOCITY, "root", NULL);
    sensor.place.end = true;
    assert_refused(sensor, "tells no end of joint \"root\"");
    sensor = sensor_of(SN_SENSOR_VELOCITY, "root", NULL);
    sensor.reference = sn_strdup("trunk");
    assert_refused(sensor, "no joint \"trunk\"");
    assert_refused(sensor_of(SN_SENSOR_VELOCITY, NULL, NULL), "needs a \"point\"");
}

static void trace_stops_with_what_is_done(void **state) {
    (void)state;
    sn_clip clip = tent();
    sn_sensors sensors = two(SN_COMBINE_MAX);
    sn_sense_params params = SN_SENSE_PARAMS;
    for (int64_t steps = 0; steps <= 3; steps++) {
        sn_trace trace = {.stop_after = steps};
        sn_sense sense;
        params.trace = &trace;
        assert_int_equal(sn_sense_run(&sensors, &clip, &params, &sense, NULL), SN_STOPPED);
        assert_int_equal(sense.sensor_count, steps < 2 ? steps : 2);
        assert_int_equal(sense.channel_count, steps < 3 ? 0 : 1);
        sn_sense_free(&sense);
    }
    sn_sensors_free(&sensors);
    sn_clip_free(&clip);
}

static void patterns_match_as_a_shell_does(void **state) {
    (void)state;
    assert_true(sn_pattern_matches("*", "") && sn_pattern_matches("a*", "a") && sn_pattern_matches("*_l", "vastus_med_l"));
    assert_true(sn_pattern_matches("vastus_*_?", "vastus_med_l") && sn_pattern_matches("*a*b*", "xaxbx"));
    assert_true(sn_pattern_matches("a*ab", "aab") && sn_pattern_matches("a*bc", "abbc") && sn_pattern_matches("**", "x"));
    assert_false(sn_pattern_matches("", "a") || sn_pattern_matches("?", "") || sn_pattern_matches("vastus_*_?", "vastus_med"));
    assert_false(sn_pattern_matches("a*b", "abc") || sn_pattern_matches("A", "a") || sn_pattern_matches("*a", "ab"));
}

/* ---- documents ------------------------------------------------------------------------------------------------------------------------
 */

static const char body[] =
    "{\"format\": \"sinew-sensors\", \"version\": 1, \"name\": \"body\", \"filter\": 6, \"sides\": {\"side\": [\"l\", \"r\"], \"Side\": "
    "[\"left\", \"right\"]},\n"
    "\"muscles\": [\"vastus_med_l\", \"vastus_lat_l\", \"vastus_med_r\", \"soleus_{side}\", \"deltoid_l\"],\n"
    "\"sensors\": [\n"
    "{\"name\": \"knee_{side}\", \"type\": \"angle\", \"joint\": \"{Side}Tibia\", \"relativeTo\": \"{Side}Femur\", \"axis\": \"-x\", "
    "\"curve\": [[0, 0], [90, 1]]},\n"
    "{\"name\": \"strike_{side}\", \"type\": \"velocity\", \"joint\": \"{Side}Foot\", \"point\": {\"l\": [1, 2, 3], \"r\": \"end\"}, "
    "\"filter\": 15, \"axis\": {\"l\": [0, 3, 4], \"r\": \"z\"},\n"
    "\"trigger\": {\"threshold\": 0.4, \"hysteresis\": 0.3, \"when\": \"below\", \"attack\": 0.02, \"hold\": 0.1, \"decay\": 0.2, "
    "\"level\": 0.7}},\n"
    "{\"name\": \"turn\", \"type\": \"angularVelocity\", \"joint\": \"root\", \"relativeTo\": \"world\", \"trigger\": {\"threshold\": 180, "
    "\"decay\": 1}},\n"
    "{\"name\": \"reach\", \"type\": \"distance\", \"joint\": \"hand\", \"point\": \"fingers\", \"to\": {\"joint\": \"world\", \"point\": "
    "[0, 0, 1]}}],\n"
    "\"channels\": [\n"
    "{\"muscles\": \"vastus_*_{side}\", \"sensors\": [\"knee_{side}\", {\"sensor\": \"strike_{side}\", \"weight\": 0.5}], \"combine\": "
    "\"sum\", \"floor\": 0.05},\n"
    "{\"muscles\": [\"soleus_{side}\", \"plantaris_{side}\"], \"sensors\": \"strike_{side}\", \"trigger\": {\"threshold\": 0.5, \"decay\": "
    "0.1}}]}\n";

static sn_status parse(const char *text, sn_sensors *out, sn_error *error) {
    sn_blob blob = blob_of("a.sensors.json", text);
    *error = (sn_error){0};
    sn_status status = sn_sensors_parse(&blob, NULL, out, error);
    sn_blob_free(&blob);
    return status;
}

static void document_is_written_out_for_sides_and_patterns(void **state) {
    (void)state;
    sn_sensors s;
    sn_error error;
    if (parse(body, &s, &error) != SN_OK) fail_msg("%s", error.text);
    assert_string_equal(s.name, "body");
    assert_int_equal(s.sensor_count, 6);
    const char *names[] = {"knee_l", "knee_r", "strike_l", "strike_r", "turn", "reach"};
    for (int i = 0; i < 6; i++) assert_string_equal(s.sensors[i].name, names[i]);
    assert_string_equal(s.sensors[1].place.joint, "rightTibia");
    assert_string_equal(s.sensors[1].reference, "rightFemur");
    assert_true(s.sensors[0].axis.x == -1.0 && s.sensors[0].cutoff < 0.0 && s.cutoff == 6.0);
    assert_near(s.sensors[0].readings[1], SN_PI / 2.0, 1e-15);
    assert_true(s.sensors[2].place.has_point && s.sensors[2].place.point.z == 3.0 && s.sensors[3].place.end);
    assert_true(s.sensors[2].axis.y == 0.6 && s.sensors[3].axis.z == 1.0 && s.sensors[2].cutoff == 15.0);
    const sn_trigger *t = &s.sensors[3].trigger;
    assert_true(t->below && t->threshold == 0.4 && t->hysteresis == 0.3 && t->attack == 0.02 && t->hold == 0.1 && t->decay == 0.2 &&
                t->level == 0.7);
    assert_true(s.sensors[4].world && s.sensors[4].reference == NULL);
    assert_near(s.sensors[4].trigger.threshold, SN_PI, 1e-15);
    assert_null(s.sensors[5].other.joint);
    assert_string_equal(s.sensors[5].place.at, "fingers");
    const char *channels[] = {"vastus_med_l", "vastus_lat_l", "vastus_med_r", "soleus_l", "plantaris_l", "soleus_r", "plantaris_r"};
    assert_int_equal(s.channel_count, 7);
    for (int i = 0; i < 7; i++) assert_string_equal(s.channels[i].name, channels[i]);
    assert_int_equal(s.channels[2].inputs[0].sensor, 1);
    assert_int_equal(s.channels[2].inputs[1].sensor, 3);
    assert_true(s.channels[2].inputs[1].weight == 0.5 && s.channels[2].combination == SN_COMBINE_SUM && s.channels[2].floor == 0.05);
    assert_true(s.channels[3].has_trigger && s.channels[3].trigger.threshold == 0.5);
    assert_contains(logged, "no channel takes the sensor turn\n");
    assert_contains(logged, "there is no muscle plantaris_l, plantaris_r\n");
    assert_contains(logged, "1 of 6 muscles have no channel: deltoid_l\n");
    sn_sensors_free(&s);
}

static void without_channels_each_sensor_is_one(void **state) {
    (void)state;
    sn_sensors s;
    sn_error error;
    assert_int_equal(
        parse("{\"format\": \"sinew-sensors\", \"version\": 1, \"sensors\": [{\"name\": \"a\", \"type\": \"angle\", \"joint\": "
              "\"x\", \"curve\": [[0, 0], [1, 1]]}, {\"name\": \"b\", \"type\": \"velocity\", \"joint\": \"x\"}]}",
              &s, &error),
        SN_OK);
    assert_int_equal(s.channel_count, 1);
    assert_string_equal(s.channels[0].name, "a");
    assert_string_equal(logged, "");
    sn_sensors_free(&s);
}

static void names_of_muscles_come_from_scenes_and_lists(void **state) {
    (void)state;
    sn_muscle_names names;
    sn_error error = {0};
    sn_blob list = blob_of("muscles.txt", "# a body\n a b \r\n\nc"),
            scene = blob_of("a.scene.json", "{\"format\": \"sinew-scene\", \"version\": 1, "
                                            "\"muscles\": [{\"name\": \"m\"}, {\"name\": \"n\"}]}"),
            nameless = blob_of("b.scene.json", "{\"format\": \"sinew-scene\", \"version\": 1, \"muscles\": [{\"rig\": \"m\"}]}");
    assert_int_equal(sn_muscle_names_parse(&list, &names, &error), SN_OK);
    assert_true(names.count == 2 && strcmp(names.names[0], "a b") == 0 && strcmp(names.names[1], "c") == 0);
    sn_muscle_names_free(&names);
    assert_int_equal(sn_muscle_names_parse(&scene, &names, &error), SN_OK);
    assert_true(names.count == 2 && strcmp(names.names[1], "n") == 0);
    sn_muscle_names_free(&names);
    assert_int_equal(sn_muscle_names_parse(&nameless, &names, &error), SN_ERROR_INPUT);
    assert_contains(error.text, "muscles[0].name");
    sn_blob_free(&list);
    sn_blob_free(&scene);
    sn_blob_free(&nameless);
}

/* The body with one thing replaced is refused, with a word about it. */
static void assert_wrong(const char *old, const char *new, const char *why) {
    char *text = replace(body, old, new);
    sn_sensors s;
    sn_error error;
    if (parse(text, &s, &error) == SN_OK) fail_msg("taken: %s", new);
    assert_contains(error.text, why);
    assert_contains(error.file, "a.sensors.json");
    assert_null(s.sensors);
    free(text);
}

static void what_is_wrong_is_said_with_its_place(void **state) {
    (void)state;
    assert_wrong("sinew-sensors", "sinew-scene", "sinew-sensors");
    assert_wrong("\"filter\": 6", "\"metersPerUnit\": 0.001", "metersPerUnit: sensors measure in metres");
    assert_wrong("\"angle\"", "\"angel\"", "sensors[0].type");
    assert_wrong("[[0, 0], [90, 1]]", "[[0, 0], [0, 1]]", "not greater than");
    assert_wrong("[90, 1]", "[90, 1.5]", "not in [0,1]");
    assert_wrong("[[0, 0], [90, 1]]", "[[0, 0]]", "two knots");
    assert_wrong("\"sensor\": \"strike_{side}\"", "\"sensor\": \"strike_{sied}\"", "no word for \"{sied}\"");
    assert_wrong("\"sensor\": \"strike_{side}\"", "\"sensor\": \"stirke_{side}\"", "there is no sensor \"stirke_l\"");
    assert_wrong("\"sensors\": \"strike_{side}\"", "\"sensors\": []", "no sensor feeds the channel");
    assert_wrong("\"sensors\": \"strike_{side}\"", "\"sensors\": \"reach\"", "activates nothing");
    assert_wrong("\"name\": \"knee_{side}\"", "\"name\": \"knee\"", "no side here for \"{Side}Tibia\"");
    assert_wrong("\"name\": \"turn\"", "\"name\": \"knee_l\"", "two sensors have the name \"knee_l\"");
    assert_wrong("soleus_{side}", "vastus_med_{side}", "\"vastus_med_l\" has two channels");
    assert_wrong("\"r\": \"end\"", "\"x\": \"end\"", "nothing is told for the side \"r\"");
    assert_wrong("[\"left\", \"right\"]", "[\"left\"]", "as many sides");
    assert_wrong("\"decay\": 0.2, ", "", "time constant");
    assert_wrong("\"threshold\": 0.4, ", "", "what the reading must pass");
    assert_wrong("[0, 3, 4]", "[0, 0, 0]", "no length");
    assert_wrong("\"joint\": \"root\"", "\"joint\": \"world\"", "the world has no angles");
    assert_wrong("\"muscles\": [\"vastus_med_l\", \"vastus_lat_l\", \"vastus_med_r\", \"soleus_{side}\", \"deltoid_l\"],", "",
                 "no muscles that it could match");
    assert_wrong("\"sensors\": \"strike_{side}\"", "\"combine\": \"mean\", \"sensors\": [{\"sensor\": \"turn\", \"weight\": 0}]",
                 "above 0");
}

static void unknown_members_are_told_once(void **state) {
    (void)state;
    char *text = replace(body, "\"relativeTo\": \"{Side}Femur\"", "\"relativTo\": \"{Side}Femur\"");
    sn_sensors s;
    sn_error error;
    assert_int_equal(parse(text, &s, &error), SN_OK);
    const char *at = strstr(logged, "relativTo");
    assert_non_null(at);
    assert_null(strstr(at + 1, "relativTo"));
    sn_sensors_free(&s);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_read_to_a_thousandth),
        cmocka_unit_test(joints_are_read_to_a_thousandth),
        cmocka_unit_test(whole_angle_is_of_any_axis),
        cmocka_unit_test(what_is_across_is_not_read),
        cmocka_unit_test(points_turn_with_their_joint),
        cmocka_unit_test(distances_are_of_points_in_motion),
        cmocka_unit_test(twist_goes_on_over_whole_turns),
        cmocka_unit_test(world_and_parent_are_other_references),
        cmocka_unit_test(rates_agree_within_a_hundredth),
        cmocka_unit_test(trigger_rises_holds_and_decays),
        cmocka_unit_test(short_pulse_comes_to_its_level_and_is_held),
        cmocka_unit_test(trigger_below_and_from_the_start),
        cmocka_unit_test(hysteresis_swallows_noise),
        cmocka_unit_test(channels_combine_weighted_sensors),
        cmocka_unit_test(channel_has_a_trigger_of_its_own),
        cmocka_unit_test(short_motions_have_readings),
        cmocka_unit_test(samples_lie_on_frames),
        cmocka_unit_test(ends_are_no_wilder_than_the_middle),
        cmocka_unit_test(what_the_motion_lacks_is_named),
        cmocka_unit_test(trace_stops_with_what_is_done),
        cmocka_unit_test(patterns_match_as_a_shell_does),
        cmocka_unit_test_setup(document_is_written_out_for_sides_and_patterns, forget_log),
        cmocka_unit_test_setup(without_channels_each_sensor_is_one, forget_log),
        cmocka_unit_test_setup(names_of_muscles_come_from_scenes_and_lists, forget_log),
        cmocka_unit_test_setup(what_is_wrong_is_said_with_its_place, forget_log),
        cmocka_unit_test_setup(unknown_members_are_told_once, forget_log),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
