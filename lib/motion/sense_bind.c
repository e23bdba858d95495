/* sense_bind.c -- the joints and points that a sensor names, in a motion. */
#include <string.h>

#include "sense.h"

static sn_index find_joint(const sn_clip *clip, const char *name) {
    for (sn_index j = 0; j < clip->joint_count; j++)
        if (strcmp(clip->joints[j].name, name) == 0) return j;
    return SN_NONE;
}

static sn_status need_joint(const sn_sensor *sensor, const sn_clip *clip, const char *name, sn_index *out, sn_error *error) {
    *out = find_joint(clip, name);
    if (*out != SN_NONE) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "sensor \"%s\": the motion has no joint \"%s\"; --list names those that it has", sensor->name,
                   name);
}

static bool is_angular(sn_sensor_kind kind) { return kind <= SN_SENSOR_ANGULAR_ACCELERATION; }

static sn_status bind_place(const sn_sensor *sensor, const sn_sensor_place *place, const sn_clip *clip, sn_sense_point *out,
                            sn_error *error) {
    sn_index at = SN_NONE;
    sn_status status = SN_OK;
    *out = (sn_sense_point){SN_NONE, place->point};
    if (place->joint != NULL) status = need_joint(sensor, clip, place->joint, &out->joint, error);
    if (status == SN_OK && place->at != NULL) status = need_joint(sensor, clip, place->at, &at, error);
    if (status != SN_OK || place->has_point) return status;
    if (at == SN_NONE) at = out->joint;
    if (at == SN_NONE) return sn_fail(error, SN_ERROR_INPUT, "sensor \"%s\": a place in the world needs a \"point\"", sensor->name);
    if (place->end && !clip->joints[at].has_end)
        return sn_fail(error, SN_ERROR_INPUT, "sensor \"%s\": the motion tells no end of joint \"%s\"; give \"point\": [x,y,z]",
                       sensor->name, clip->joints[at].name);
    if (!place->end && !is_angular(sensor->kind) && clip->joints[at].placeless)
        return sn_fail(error, SN_ERROR_INPUT,
                       "sensor \"%s\": the motion does not tell where joint \"%s\" is at rest; give \"point\": [x,y,z]", sensor->name,
                       clip->joints[at].name);
    out->rest = place->end ? clip->joints[at].end : clip->joints[at].rest;
    return SN_OK;
}

/* What is fixed to that which it is measured from was meant to be something else. */
static void warn_of_rest(const sn_sense_bound *b, const sn_clip *clip) {
    const sn_sensor *sensor = b->sensor;
    sn_index from = sensor->kind == SN_SENSOR_DISTANCE ? b->other.joint : b->reference;
    if (b->place.joint == from)
        sn_log(SN_LOG_WARNING,
               "sensor \"%s\" reads the same all the time: what it measures and what that is measured from are both fixed to %s",
               sensor->name, from != SN_NONE ? clip->joints[from].name : "the world");
}

sn_status sn_sense_bind(const sn_sensor *sensor, const sn_clip *clip, sn_sense_bound *out, sn_error *error) {
    *out = (sn_sense_bound){.sensor = sensor, .reference = SN_NONE, .other = {SN_NONE, {0, 0, 0}}};
    sn_status status = bind_place(sensor, &sensor->place, clip, &out->place, error);
    if (status == SN_OK && sensor->kind == SN_SENSOR_DISTANCE) status = bind_place(sensor, &sensor->other, clip, &out->other, error);
    if (status == SN_OK && sensor->reference != NULL)
        status = need_joint(sensor, clip, sensor->reference, &out->reference, error);
    else if (status == SN_OK && is_angular(sensor->kind) && !sensor->world && out->place.joint != SN_NONE)
        out->reference = clip->joints[out->place.joint].parent;
    if (status == SN_OK) warn_of_rest(out, clip);
    return status;
}
