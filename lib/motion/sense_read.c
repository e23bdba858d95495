/*
 * sense_read.c -- readings of one sensor: angles and points seen from its reference, and their derivatives by central differences.
 */
#include <stdlib.h>

#include "sense.h"

/* A rotation by half a turn about an axis across has no twist: below this squared size of its share, the last angle goes on. */
static const double LEAST_TWIST = 1e-18;

/* ---- differences over five samples ------------------------------------------------------------------------------------------------ */

/* (x_-2 - 8 x_-1 + 8 x_1 - x_2) / 12 h: wrong by h^4/30 of the 5th derivative. */
static sn_vec3 first_derivative(const sn_vec3 *x, double rate) {
    return sn_scale(sn_sub(sn_scale(sn_sub(x[1], x[-1]), 8.0), sn_sub(x[2], x[-2])), rate / 12.0);
}

/* (-x_-2 + 16 x_-1 - 30 x_0 + 16 x_1 - x_2) / 12 h^2: wrong by h^4/90 of the 6th. From differences to x_0, which do not cancel. */
static sn_vec3 second_derivative(const sn_vec3 *x, double rate) {
    sn_vec3 near = sn_add(sn_sub(x[1], x[0]), sn_sub(x[-1], x[0])), far = sn_add(sn_sub(x[2], x[0]), sn_sub(x[-2], x[0]));
    return sn_scale(sn_sub(sn_scale(near, 16.0), far), rate * rate / 12.0);
}

/* The vector of q' q* or q'' q*, at q_0, in the reference's frame. */
static sn_vec3 half_turning(const sn_quat *q, double rate, bool second) {
    sn_vec3 v[2 * SN_SENSE_PADDING + 1], *here = v + SN_SENSE_PADDING;
    for (int k = -SN_SENSE_PADDING; k <= SN_SENSE_PADDING; k++) {
        sn_quat turn = sn_quat_multiply(q[k], sn_quat_conjugate(q[0]));
        here[k] = sn_scale(sn_v3(turn.x, turn.y, turn.z), turn.w < 0.0 ? -1.0 : 1.0); /* q and -q are one rotation */
    }
    return second ? second_derivative(here, rate) : first_derivative(here, rate);
}

/* ---- points ------------------------------------------------------------------------------------------------------------------------ */

static sn_rigid pose_of(const sn_clip *clip, sn_index joint, sn_index frame) {
    return joint != SN_NONE ? clip->joints[joint].poses[frame] : sn_rigid_identity();
}

/* In the reference's frame: in the world as it was when the reference was at rest. */
static sn_vec3 place_at(const sn_sense_bound *b, const sn_sense_point *point, const sn_clip *clip, sn_index frame) {
    sn_vec3 place = sn_rigid_apply(pose_of(clip, point->joint, frame), point->rest);
    return b->reference == SN_NONE ? place : sn_rigid_apply(sn_rigid_inverse(pose_of(clip, b->reference, frame)), place);
}

static double size_or_share(const sn_sensor *sensor, sn_vec3 v) { return sensor->has_axis ? sn_dot(v, sensor->axis) : sn_norm(v); }

static sn_status read_point(const sn_sense_bound *b, const sn_clip *fine, double *readings, sn_error *error) {
    sn_index count = fine->frame_count - 2 * SN_SENSE_PADDING;
    sn_vec3 *places = SN_NEW(sn_vec3, fine->frame_count);
    const sn_sensor *sensor = b->sensor;
    if (places == NULL) return sn_fail_memory(error, "the places of a point");
    const sn_vec3 *first = places + SN_SENSE_PADDING;
    for (sn_index f = 0; f < fine->frame_count; f++) {
        places[f] = place_at(b, &b->place, fine, f);
        if (sensor->kind == SN_SENSOR_DISTANCE) places[f] = sn_sub(place_at(b, &b->other, fine, f), places[f]);
    }
    for (sn_index k = 0; k < count; k++) {
        sn_vec3 v = sensor->kind == SN_SENSOR_VELOCITY       ? first_derivative(first + k, fine->rate)
                    : sensor->kind == SN_SENSOR_ACCELERATION ? second_derivative(first + k, fine->rate)
                                                             : first[k];
        readings[k] = size_or_share(sensor, v);
    }
    free(places);
    return SN_OK;
}

/* ---- rotations --------------------------------------------------------------------------------------------------------------------- */

static void read_twist(const sn_quat *q, sn_index count, sn_vec3 axis, double *readings) {
    double last = 0.0;
    for (sn_index k = 0; k < count; k++) {
        double along = q[k].x * axis.x + q[k].y * axis.y + q[k].z * axis.z, angle = last;
        if (along * along + q[k].w * q[k].w > LEAST_TWIST) {
            angle = 2.0 * sn_quick_atan2(along, q[k].w);
            angle += 2.0 * SN_PI * floor((last - angle) / (2.0 * SN_PI) + 0.5); /* at first within half a turn, then next to the last */
        }
        readings[k] = last = angle;
    }
}

static double whole_angle(sn_quat q) { return 2.0 * sn_quick_atan2(sn_norm(sn_v3(q.x, q.y, q.z)), fabs(q.w)); }

/* Angular velocity is 2 q' q*, its derivative the vector of 2 q'' q*: q' q'* has none. */
static sn_status read_rotation(const sn_sense_bound *b, const sn_clip *fine, double *readings, sn_error *error) {
    sn_index count = fine->frame_count - 2 * SN_SENSE_PADDING;
    const sn_sensor *sensor = b->sensor;
    sn_quat *q = SN_NEW(sn_quat, fine->frame_count);
    if (q == NULL) return sn_fail_memory(error, "the rotations of a joint");
    const sn_quat *first = q + SN_SENSE_PADDING;
    for (sn_index f = 0; f < fine->frame_count; f++)
        q[f] = sn_quat_multiply(sn_quat_conjugate(pose_of(fine, b->reference, f).rotation), pose_of(fine, b->place.joint, f).rotation);
    if (sensor->kind == SN_SENSOR_ANGLE && sensor->has_axis) read_twist(first, count, sensor->axis, readings);
    for (sn_index k = 0; k < count; k++) {
        if (sensor->kind != SN_SENSOR_ANGLE)
            readings[k] = 2.0 * size_or_share(sensor, half_turning(first + k, fine->rate, sensor->kind == SN_SENSOR_ANGULAR_ACCELERATION));
        else if (!sensor->has_axis)
            readings[k] = whole_angle(first[k]);
    }
    free(q);
    return SN_OK;
}

sn_status sn_sense_read(const sn_sense_bound *b, const sn_clip *fine, double *readings, sn_error *error) {
    bool angular = b->sensor->kind <= SN_SENSOR_ANGULAR_ACCELERATION;
    return angular ? read_rotation(b, fine, readings, error) : read_point(b, fine, readings, error);
}
