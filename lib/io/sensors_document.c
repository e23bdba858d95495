/*
 * sensors_document.c -- sensors and the channels that they feed, read from a document; an entry with a word in braces is one of each side,
 * a muscle with '*' or '?' is all that match it.
 */
#include "sensors_document.h"

#include <stdlib.h>
#include <string.h>

/* More than any body has; what is told once may stand for many. */
enum { MOST_SENSORS = 4096, MOST_MUSCLES = 4096, MOST_CHANNELS = 1 << 14, MOST_INPUTS = 1 << 18, MOST_COMPARISONS = 1 << 22 };

typedef struct reader {
    sn_sides sides;
    sn_muscle_names muscles; /* of the document, where the caller names none */
    const sn_muscle_names *known;
    bool *fed; /* (known->count): has a channel */
    sn_sensors *out;
    size_t sensor_capacity, channel_capacity;
    sn_index input_count, comparisons;
    sn_name_index sensor_names;
    bool *used;         /* (sensor_count) */
    sn_naming no_match; /* patterns that no muscle matches, names that are no muscle's */
} reader;

/* ---- triggers ---------------------------------------------------------------------------------------------------------------------- */

/* Times are told in seconds, thresholds in `unit` of the library's. */
static sn_status parse_trigger(const sn_json_value *value, double unit, sn_trigger *out, sn_error *error) {
    static const char *const known[] = {"threshold", "hysteresis", "when", "attack", "hold", "decay", "level", NULL};
    static const char *const senses[] = {"above", "below", NULL};
    sn_json_value threshold = sn_json_member(value, "threshold"), hysteresis = sn_json_member(value, "hysteresis"),
                  when = sn_json_member(value, "when"), decay = sn_json_member(value, "decay"), level = sn_json_member(value, "level"),
                  attack = sn_json_member(value, "attack"), hold = sn_json_member(value, "hold");
    int sense = 0;
    *out = (sn_trigger){.level = 1.0};
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    if (status == SN_OK) status = sn_json_require(&threshold, "what the reading must pass", error);
    if (status == SN_OK) status = sn_json_get_number(&threshold, -1e12, 1e12, &out->threshold, error);
    if (status == SN_OK) status = sn_json_get_number(&hysteresis, 0.0, 1e12, &out->hysteresis, error);
    if (status == SN_OK) status = sn_json_get_choice(&when, senses, &sense, error);
    if (status == SN_OK) status = sn_json_get_number(&attack, 0.0, 1e6, &out->attack, error);
    if (status == SN_OK) status = sn_json_get_number(&hold, 0.0, 1e6, &out->hold, error);
    if (status == SN_OK) status = sn_json_require(&decay, "the time constant of the decay, in seconds", error);
    if (status == SN_OK) status = sn_json_get_number(&decay, 0.0, 1e6, &out->decay, error);
    if (status == SN_OK) status = sn_json_get_number(&level, 0.0, 1.0, &out->level, error);
    out->below = sense == 1;
    out->threshold /= unit;
    out->hysteresis /= unit;
    return status;
}

/* ---- sensors ----------------------------------------------------------------------------------------------------------------------- */

/* A direction, or "x", "-z", ...; a unit vector. */
static sn_status parse_axis(const sn_json_value *value, sn_side side, sn_sensor *out, sn_error *error) {
    static const char *const names[] = {"x", "y", "z", "-x", "-y", "-z", NULL};
    sn_json_value axis;
    int choice = 0;
    sn_status status = sn_side_value(value, side, &axis, error);
    if (status != SN_OK || !sn_json_has(&axis)) return status;
    out->has_axis = true;
    if (sn_json_is_text(&axis)) {
        status = sn_json_get_choice(&axis, names, &choice, error);
        double sign = choice < 3 ? 1.0 : -1.0;
        out->axis = sn_v3(choice % 3 == 0 ? sign : 0.0, choice % 3 == 1 ? sign : 0.0, choice % 3 == 2 ? sign : 0.0);
        return status;
    }
    status = sn_json_get_vec3(&axis, &out->axis, error);
    out->axis = sn_normalize(out->axis);
    if (status == SN_OK && !(sn_norm2(out->axis) > 0.0)) status = sn_json_complain(&axis, error, "the axis has no length");
    return status;
}

/* [x,y,z]; "end", of the joint's segment; or the name of the joint whose centre it is. */
static sn_status parse_point(const sn_json_value *value, sn_side side, sn_sensor_place *out, sn_error *error) {
    sn_json_value point;
    sn_status status = sn_side_value(value, side, &point, error);
    if (status != SN_OK || !sn_json_has(&point)) return status;
    if (!sn_json_is_text(&point)) {
        out->has_point = true;
        return sn_json_get_vec3(&point, &out->point, error);
    }
    status = sn_side_text(&point, side, &out->at, error);
    if (status == SN_OK && strcmp(out->at, "end") == 0) {
        out->end = true;
        free(out->at);
        out->at = NULL;
    }
    return status;
}

/* The joint by its name; "world" is none. */
static sn_status parse_joint(const sn_json_value *value, sn_side side, char **out, bool *world, sn_error *error) {
    sn_status status = sn_side_text(value, side, out, error);
    *world = status == SN_OK && *out != NULL && strcmp(*out, "world") == 0;
    if (!*world) return status;
    free(*out);
    *out = NULL;
    return SN_OK;
}

static sn_status parse_place(const sn_json_value *value, sn_side side, sn_sensor_place *out, sn_error *error) {
    sn_json_value joint = sn_json_member(value, "joint"), point = sn_json_member(value, "point");
    bool world = false;
    sn_status status = sn_json_require(&joint, "the name of a joint, or \"world\"", error);
    if (status == SN_OK) status = parse_joint(&joint, side, &out->joint, &world, error);
    if (status == SN_OK) status = parse_point(&point, side, out, error);
    if (status == SN_OK && world && !out->has_point && out->at == NULL)
        status = sn_json_complain(value, error, "a place in the world needs \"point\": [x,y,z]");
    if (status == SN_OK && world && out->end) status = sn_json_complain(&point, error, "the world has no end");
    return status;
}

/* A joint that turns. */
static sn_status parse_turning(const sn_json_value *joint, sn_side side, sn_sensor_place *out, sn_error *error) {
    bool world = false;
    sn_status status = sn_json_require(joint, "the name of a joint", error);
    if (status == SN_OK) status = parse_joint(joint, side, &out->joint, &world, error);
    return status == SN_OK && world ? sn_json_complain(joint, error, "the world has no angles") : status;
}

static sn_status parse_to(const sn_json_value *to, sn_side side, sn_sensor_place *out, sn_error *error) {
    static const char *const known[] = {"joint", "point", NULL};
    bool world = false;
    sn_status status = sn_json_require(to, "where the distance goes to: a joint's name, or {\"joint\", \"point\"}", error);
    if (status != SN_OK) return status;
    if (!sn_json_is_text(to)) {
        status = sn_json_expect_object(to, error);
        if (status == SN_OK) status = sn_json_check_members(to, known, error);
        return status == SN_OK ? parse_place(to, side, out, error) : status;
    }
    status = parse_joint(to, side, &out->joint, &world, error);
    if (status == SN_OK && world) status = sn_json_complain(to, error, "a place in the world needs \"point\": [x,y,z]");
    return status;
}

/* [[reading, activation], ...]; unit: of readings told. */
static sn_status parse_curve(const sn_json_value *value, sn_side side, double unit, sn_sensor *out, sn_error *error) {
    sn_json_value curve;
    sn_index count;
    sn_status status = sn_side_value(value, side, &curve, error);
    if (status != SN_OK || !sn_json_has(&curve)) return status;
    status = sn_json_expect_list(&curve, SN_LIST_LIMIT, &count, error);
    if (status == SN_OK && count < 2) status = sn_json_complain(&curve, error, "a curve needs two knots [reading, activation] or more");
    if (status != SN_OK) return status;
    out->readings = SN_NEW(double, count);
    out->activations = SN_NEW(double, count);
    if (out->readings == NULL || out->activations == NULL) return sn_fail_memory(error, "a curve");
    out->knot_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value knot = sn_json_element(&curve, i);
        double pair[2] = {0};
        status = sn_json_require(&knot, "a knot [reading, activation]", error);
        if (status == SN_OK) status = sn_json_get_fixed(&knot, 2, pair, error);
        if (status == SN_OK && !(pair[1] >= 0.0 && pair[1] <= 1.0))
            status = sn_json_complain(&knot, error, "the activation %g is not in [0,1]", pair[1]);
        out->readings[i] = pair[0] / unit;
        out->activations[i] = pair[1];
        if (status == SN_OK && i > 0 && !(out->readings[i] > out->readings[i - 1]))
            status = sn_json_complain(&knot, error, "the reading is not greater than that of the knot before it");
    }
    return status;
}

/* Its curve and trigger; thresholds behind a curve are activations. */
static sn_status parse_response(const sn_json_value *value, sn_side side, sn_sensor *out, sn_error *error) {
    sn_json_value curve = sn_json_member(value, "curve"), trigger = sn_json_member(value, "trigger");
    double unit = sn_sensor_scale(out->kind);
    sn_status status = parse_curve(&curve, side, unit, out, error);
    if (status != SN_OK || !sn_json_has(&trigger)) return status;
    out->has_trigger = true;
    return parse_trigger(&trigger, out->knot_count > 0 ? 1.0 : unit, &out->trigger, error);
}

static bool is_angular(sn_sensor_kind kind) { return kind <= SN_SENSOR_ANGULAR_ACCELERATION; }

static sn_status check_members(const sn_json_value *value, sn_sensor_kind kind, sn_error *error) {
    static const char *const of_rotations[] = {"name",   "type",          "joint", "relativeTo", "axis",
                                               "filter", "metersPerUnit", "curve", "trigger",    NULL};
    static const char *const of_points[] = {"name", "type", "joint", "point", "relativeTo", "axis", "filter", "curve", "trigger", NULL};
    static const char *const of_two[] = {"name", "type", "joint", "point", "to", "relativeTo", "axis", "filter", "curve", "trigger", NULL};
    return sn_json_check_members(value, is_angular(kind) ? of_rotations : kind == SN_SENSOR_DISTANCE ? of_two : of_points, error);
}

/* What is measured: which joint or points, seen from where, along what. */
static sn_status parse_measure(const sn_json_value *value, sn_side side, sn_sensor *out, sn_error *error) {
    sn_json_value to = sn_json_member(value, "to"), reference = sn_json_member(value, "relativeTo"), axis = sn_json_member(value, "axis"),
                  joint = sn_json_member(value, "joint"), filter = sn_json_member(value, "filter");
    sn_status status =
        is_angular(out->kind) ? parse_turning(&joint, side, &out->place, error) : parse_place(value, side, &out->place, error);
    if (status == SN_OK && out->kind == SN_SENSOR_DISTANCE) status = parse_to(&to, side, &out->other, error);
    if (status == SN_OK) status = parse_joint(&reference, side, &out->reference, &out->world, error);
    if (status == SN_OK && out->kind == SN_SENSOR_POSITION)
        status = sn_json_require(&axis, "the direction along which the position is told", error);
    if (status == SN_OK) status = parse_axis(&axis, side, out, error);
    out->cutoff = -1.0;
    return status == SN_OK ? sn_json_get_number(&filter, 0.0, 1e5, &out->cutoff, error) : status;
}

static sn_status parse_sensor(const sn_json_value *value, sn_side side, sn_sensor *out, sn_error *error) {
    sn_json_value name = sn_json_member(value, "name"), type = sn_json_member(value, "type");
    int kind = 0;
    sn_status status = sn_side_text(&name, side, &out->name, error);
    if (status == SN_OK) status = sn_json_require(&type, "what the sensor measures", error);
    if (status == SN_OK) status = sn_json_get_choice(&type, sn_sensor_kind_names, &kind, error);
    out->kind = (sn_sensor_kind)kind;
    if (status == SN_OK) status = parse_measure(value, side, out, error);
    if (status == SN_OK) status = parse_response(value, side, out, error);
    if (status == SN_OK && side.side <= 0) status = check_members(value, out->kind, error); /* once, not for each side */
    return status;
}

/* Once, or once for each side where its name has a word in braces. */
static sn_status parse_sensor_entry(reader *r, const sn_json_value *value, sn_error *error) {
    sn_json_value name = sn_json_member(value, "name");
    char *text = NULL;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&name, "the name of the sensor", error);
    if (status == SN_OK) status = sn_json_get_text(&name, &text, error);
    if (status != SN_OK) return status;
    bool sided = sn_text_has_side(text) && r->sides.count > 0;
    free(text);
    for (sn_index k = 0; k < (sided ? r->sides.count : 1) && status == SN_OK; k++) {
        sn_sensors *out = r->out;
        if (out->sensor_count >= MOST_SENSORS)
            return sn_json_complain(value, error, "there are more than %d sensors, all sides counted", MOST_SENSORS);
        if (!sn_grow((void **)&out->sensors, &r->sensor_capacity, (size_t)out->sensor_count + 1, sizeof *out->sensors))
            return sn_fail_memory(error, "sensors");
        sn_sensor *sensor = &out->sensors[out->sensor_count++];
        *sensor = (sn_sensor){0};
        status = parse_sensor(value, (sn_side){&r->sides, sided ? k : SN_NONE}, sensor, error);
    }
    return status;
}

static const char *sensor_name(const void *data, sn_index i) { return ((const sn_sensors *)data)->sensors[i].name; }
static const char *channel_name(const void *data, sn_index i) { return ((const sn_sensors *)data)->channels[i].name; }

static sn_status parse_sensors(reader *r, const sn_json_value *list, sn_error *error) {
    sn_index count = 0;
    sn_status status = sn_json_require(list, "a list of sensors", error);
    if (status == SN_OK) status = sn_json_expect_list(list, SN_LIST_LIMIT, &count, error);
    if (status == SN_OK && count == 0) status = sn_json_complain(list, error, "there is no sensor");
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_json_value sensor = sn_json_element(list, i);
        status = parse_sensor_entry(r, &sensor, error);
    }
    if (status == SN_OK) status = sn_name_index_create(r->out->sensor_count, sensor_name, r->out, &r->sensor_names, error);
    const char *twin = status == SN_OK ? sn_name_index_twin(&r->sensor_names) : NULL;
    if (twin != NULL) status = sn_json_complain(list, error, "two sensors have the name \"%s\"", twin);
    if (status == SN_OK && (r->used = SN_NEW(bool, r->out->sensor_count)) == NULL) status = sn_fail_memory(error, "sensors");
    return status;
}

/* ---- channels: what feeds them ------------------------------------------------------------------------------------------------- */

/* A sensor's name, or { "sensor", "weight" }. */
static sn_status parse_input(reader *r, const sn_json_value *value, sn_side side, sn_sense_input *out, sn_error *error) {
    static const char *const known[] = {"sensor", "weight", NULL};
    bool bare = sn_json_is_text(value);
    sn_json_value name = bare ? *value : sn_json_member(value, "sensor"), weight = sn_json_member(value, "weight");
    char *text = NULL;
    out->weight = 1.0;
    sn_status status = bare ? SN_OK : sn_json_expect_object(value, error);
    if (status == SN_OK && !bare && side.side <= 0) status = sn_json_check_members(value, known, error);
    if (status == SN_OK) status = sn_json_require(&name, "the name of a sensor", error);
    if (status == SN_OK) status = sn_side_text(&name, side, &text, error);
    if (status == SN_OK && !bare) status = sn_json_get_number(&weight, -1e6, 1e6, &out->weight, error);
    if (status == SN_OK && (out->sensor = sn_name_index_find(&r->sensor_names, text)) == SN_NONE)
        status = sn_json_complain(&name, error, "there is no sensor \"%s\"", text);
    free(text);
    if (status != SN_OK) return status;
    const sn_sensor *sensor = &r->out->sensors[out->sensor];
    r->used[out->sensor] = true;
    if (sensor->knot_count > 0 || sensor->has_trigger) return SN_OK;
    return sn_json_complain(&name, error, "the sensor \"%s\" activates nothing: it has neither a curve nor a trigger", sensor->name);
}

static sn_status parse_inputs(reader *r, const sn_json_value *value, sn_side side, sn_sense_channel *out, sn_error *error) {
    bool one = sn_json_is_text(value);
    sn_index count = 1;
    double weights = 0.0;
    sn_status status = sn_json_require(value, "the sensors that feed the channel", error);
    if (status == SN_OK && !one) status = sn_json_expect_list(value, SN_LIST_LIMIT, &count, error);
    if (status == SN_OK && count == 0) status = sn_json_complain(value, error, "no sensor feeds the channel");
    if (status == SN_OK && (out->inputs = SN_NEW(sn_sense_input, count)) == NULL) status = sn_fail_memory(error, "a channel");
    if (status != SN_OK) return status;
    out->input_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value input = one ? *value : sn_json_element(value, i);
        status = parse_input(r, &input, side, &out->inputs[i], error);
        weights += out->inputs[i].weight;
    }
    if (status == SN_OK && out->combination == SN_COMBINE_MEAN && !(weights > 0.0))
        status = sn_json_complain(value, error, "the weights of a mean have the sum %g, which is not above 0", weights);
    return status;
}

/* All of a channel but its name. */
static sn_status parse_feed(reader *r, const sn_json_value *value, sn_side side, sn_sense_channel *out, sn_error *error) {
    static const char *const known[] = {"muscles", "sensors", "combine", "floor", "trigger", NULL};
    sn_json_value sensors = sn_json_member(value, "sensors"), combine = sn_json_member(value, "combine"),
                  floor = sn_json_member(value, "floor"), trigger = sn_json_member(value, "trigger");
    int choice = 0;
    sn_status status = side.side <= 0 ? sn_json_check_members(value, known, error) : SN_OK;
    if (status == SN_OK) status = sn_json_get_choice(&combine, sn_combination_names, &choice, error);
    out->combination = (sn_combination)choice;
    if (status == SN_OK) status = parse_inputs(r, &sensors, side, out, error);
    if (status == SN_OK) status = sn_json_get_number(&floor, 0.0, 1.0, &out->floor, error);
    out->has_trigger = sn_json_has(&trigger);
    return status == SN_OK && out->has_trigger ? parse_trigger(&trigger, 1.0, &out->trigger, error) : status;
}

/* ---- channels: which they are ---------------------------------------------------------------------------------------------------- */

static sn_status add_channel(reader *r, const sn_json_value *at, const char *name, const sn_sense_channel *like, sn_error *error) {
    sn_sensors *out = r->out;
    size_t size = (size_t)like->input_count * sizeof *like->inputs;
    if (out->channel_count >= MOST_CHANNELS || (r->input_count += like->input_count) > MOST_INPUTS)
        return sn_json_complain(at, error, "there are more than %d channels, or more than %d sensors in all of them", MOST_CHANNELS,
                                MOST_INPUTS);
    if (!sn_grow((void **)&out->channels, &r->channel_capacity, (size_t)out->channel_count + 1, sizeof *out->channels))
        return sn_fail_memory(error, "channels");
    sn_sense_channel *channel = &out->channels[out->channel_count++];
    *channel = *like;
    channel->name = sn_strdup(name);
    if ((channel->inputs = SN_NEW(sn_sense_input, like->input_count)) != NULL) memcpy(channel->inputs, like->inputs, size);
    return channel->name != NULL && channel->inputs != NULL ? SN_OK : sn_fail_memory(error, "channels");
}

/* The channels of one name or pattern. */
static sn_status add_muscles(reader *r, const sn_json_value *at, const char *pattern, const sn_sense_channel *like, sn_error *error) {
    bool exact = strpbrk(pattern, "*?") == NULL;
    sn_index matches = 0, known = r->known != NULL ? r->known->count : 0;
    sn_status status = SN_OK;
    if (!exact && known == 0)
        return sn_json_complain(at, error,
                                "\"%s\" is a pattern, but there are no muscles that it could match: list them in \"muscles\" of the "
                                "document, or give --muscles",
                                pattern);
    if ((r->comparisons += known) > MOST_COMPARISONS) return sn_json_complain(at, error, "there are too many patterns");
    for (sn_index i = 0; i < known && status == SN_OK; i++) {
        if (exact ? strcmp(pattern, r->known->names[i]) != 0 : !sn_pattern_matches(pattern, r->known->names[i])) continue;
        matches++;
        r->fed[i] = true;
        if (!exact) status = add_channel(r, at, r->known->names[i], like, error);
    }
    if (matches == 0 && known > 0) sn_naming_add(&r->no_match, pattern);
    return exact && status == SN_OK ? add_channel(r, at, pattern, like, error) : status;
}

static sn_status parse_channel(reader *r, const sn_json_value *value, sn_side side, sn_error *error) {
    sn_json_value muscles = sn_json_member(value, "muscles");
    bool one = sn_json_is_text(&muscles);
    sn_sense_channel like = {0};
    sn_status status = parse_feed(r, value, side, &like, error);
    for (sn_index i = 0; i < (one ? 1 : sn_json_length(&muscles)) && status == SN_OK; i++) {
        sn_json_value pattern = one ? muscles : sn_json_element(&muscles, i);
        char *text = NULL;
        status = sn_json_require(&pattern, "the name of a muscle, or a pattern", error);
        if (status == SN_OK) status = sn_side_text(&pattern, side, &text, error);
        if (status == SN_OK) status = add_muscles(r, &pattern, text, &like, error);
        free(text);
    }
    free(like.inputs);
    return status;
}

/* Has one of the muscles a word in braces? */
static sn_status ask_for_sides(const sn_json_value *muscles, bool *sided, sn_error *error) {
    bool one = sn_json_is_text(muscles);
    sn_index count = 1;
    sn_status status = sn_json_require(muscles, "the muscles that the channel is for", error);
    if (status == SN_OK && !one) status = sn_json_expect_list(muscles, SN_LIST_LIMIT, &count, error);
    if (status == SN_OK && count == 0) status = sn_json_complain(muscles, error, "names no muscle");
    *sided = false;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value muscle = one ? *muscles : sn_json_element(muscles, i);
        char *text = NULL;
        status = sn_json_require(&muscle, "the name of a muscle, or a pattern", error);
        if (status == SN_OK) status = sn_json_get_text(&muscle, &text, error);
        *sided = *sided || (text != NULL && sn_text_has_side(text));
        free(text);
    }
    return status;
}

static sn_status parse_channel_entry(reader *r, const sn_json_value *value, sn_error *error) {
    sn_json_value muscles = sn_json_member(value, "muscles");
    bool sided = false;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = ask_for_sides(&muscles, &sided, error);
    sided = sided && r->sides.count > 0;
    for (sn_index k = 0; k < (sided ? r->sides.count : 1) && status == SN_OK; k++)
        status = parse_channel(r, value, (sn_side){&r->sides, sided ? k : SN_NONE}, error);
    return status;
}

/* Without channels, each sensor that activates is one. */
static sn_status make_channels(reader *r, const sn_json_value *top, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < r->out->sensor_count && status == SN_OK; i++) {
        const sn_sensor *sensor = &r->out->sensors[i];
        sn_sense_input input = {i, 1.0};
        r->used[i] = true;
        if (sensor->knot_count == 0 && !sensor->has_trigger) continue;
        status = add_channel(r, top, sensor->name, &(sn_sense_channel){.input_count = 1, .inputs = &input}, error);
    }
    return status;
}

static sn_status parse_channels(reader *r, const sn_json_value *top, sn_error *error) {
    sn_json_value list = sn_json_member(top, "channels");
    sn_index count;
    sn_name_index names;
    if (!sn_json_has(&list)) return make_channels(r, top, error);
    sn_status status = sn_json_expect_list(&list, SN_LIST_LIMIT, &count, error);
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_json_value channel = sn_json_element(&list, i);
        status = parse_channel_entry(r, &channel, error);
    }
    if (status != SN_OK) return status;
    status = sn_name_index_create(r->out->channel_count, channel_name, r->out, &names, error);
    const char *twin = status == SN_OK ? sn_name_index_twin(&names) : NULL;
    if (twin != NULL) status = sn_json_complain(&list, error, "the muscle \"%s\" has two channels; combine their sensors in one", twin);
    sn_name_index_free(&names);
    return status;
}

/* ---- the document ------------------------------------------------------------------------------------------------------------------ */

/* A muscle's name; with a word in braces that of each side. */
static sn_status parse_muscle(const sn_json_value *value, const sn_sides *sides, sn_muscle_names *out, size_t *capacity, sn_error *error) {
    char *text = NULL;
    sn_status status = sn_json_require(value, "the name of a muscle", error);
    if (status == SN_OK) status = sn_json_get_text(value, &text, error);
    if (status != SN_OK) return status;
    bool sided = sn_text_has_side(text) && sides->count > 0;
    free(text);
    for (sn_index k = 0; k < (sided ? sides->count : 1) && status == SN_OK; k++) {
        if (out->count >= MOST_MUSCLES)
            return sn_json_complain(value, error, "there are more than %d muscles, all sides counted", MOST_MUSCLES);
        if (!sn_grow((void **)&out->names, capacity, (size_t)out->count + 1, sizeof *out->names)) return sn_fail_memory(error, "names");
        out->names[out->count++] = NULL;
        status = sn_side_text(value, (sn_side){sides, sided ? k : SN_NONE}, &out->names[out->count - 1], error);
    }
    return status;
}

static sn_status parse_muscle_list(const sn_json_value *list, const sn_sides *sides, sn_muscle_names *out, sn_error *error) {
    sn_index count = 0;
    size_t capacity = 0;
    if (!sn_json_has(list)) return SN_OK;
    sn_status status = sn_json_expect_list(list, SN_LIST_LIMIT, &count, error);
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_json_value name = sn_json_element(list, i);
        status = parse_muscle(&name, sides, out, &capacity, error);
    }
    return status;
}

static void warn(const reader *r, const char *document) {
    sn_naming idle = {0}, still = {0}, no_match = r->no_match;
    for (sn_index i = 0; i < r->out->sensor_count; i++) {
        const sn_sensor *sensor = &r->out->sensors[i];
        if (!r->used[i] && (sensor->knot_count > 0 || sensor->has_trigger)) sn_naming_add(&idle, sensor->name);
    }
    for (sn_index i = 0; r->known != NULL && i < r->known->count; i++)
        if (!r->fed[i]) sn_naming_add(&still, r->known->names[i]);
    if (idle.count > 0)
        sn_log(SN_LOG_WARNING, "%s: no channel takes the sensor%s %s", document, idle.count > 1 ? "s" : "", sn_naming_text(&idle));
    if (no_match.count > 0) sn_log(SN_LOG_WARNING, "%s: there is no muscle %s", document, sn_naming_text(&no_match));
    if (still.count > 0)
        sn_log(SN_LOG_WARNING, "%s: %d of %d muscles have no channel: %s", document, (int)still.count, (int)r->known->count,
               sn_naming_text(&still));
}

static sn_status parse_head(reader *r, const sn_json_value *top, sn_error *error) {
    static const char *const known[] = {"format", "version", "name",    "description", "filter",
                                        "sides",  "muscles", "sensors", "channels",    NULL};
    sn_json_value name = sn_json_member(top, "name"), filter = sn_json_member(top, "filter"), sides = sn_json_member(top, "sides"),
                  muscles = sn_json_member(top, "muscles"), unit = sn_json_member(top, "metersPerUnit");
    double meters = 1.0;
    sn_status status = sn_json_expect_format(top, "sinew-sensors", 1, error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, &meters, error);
    if (status == SN_OK && meters != 1.0) status = sn_json_complain(&unit, error, "sensors measure in metres, whatever a scene's unit");
    if (status == SN_OK) status = sn_json_check_members(top, known, error);
    if (status == SN_OK) status = sn_json_get_text(&name, &r->out->name, error);
    if (status == SN_OK) status = sn_json_get_number(&filter, 0.0, 1e5, &r->out->cutoff, error);
    if (status == SN_OK) status = sn_sides_parse(&sides, &r->sides, error);
    if (status == SN_OK) status = parse_muscle_list(&muscles, &r->sides, &r->muscles, error);
    if (status == SN_OK && r->known == NULL && r->muscles.count > 0) r->known = &r->muscles;
    if (status == SN_OK && r->known != NULL && (r->fed = SN_NEW(bool, r->known->count)) == NULL) status = sn_fail_memory(error, "names");
    return status;
}

sn_status sn_sensors_parse(const sn_blob *blob, const sn_muscle_names *muscles, sn_sensors *out, sn_error *error) {
    reader r = {.known = muscles, .out = out};
    sn_json_tree *tree = NULL;
    *out = (sn_sensors){0};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), sensors = sn_json_member(&top, "sensors");
    status = parse_head(&r, &top, error);
    if (status == SN_OK) status = parse_sensors(&r, &sensors, error);
    if (status == SN_OK) status = parse_channels(&r, &top, error);
    if (status == SN_OK && out->channel_count == 0)
        status = sn_json_complain(&sensors, error, "nothing is activated: no sensor has a curve or a trigger, or \"channels\" is empty");
    if (status == SN_OK) warn(&r, blob->name);
    sn_json_tree_free(tree);
    sn_sides_free(&r.sides);
    sn_muscle_names_free(&r.muscles);
    sn_name_index_free(&r.sensor_names);
    free(r.fed);
    free(r.used);
    if (status != SN_OK) sn_sensors_free(out);
    return status;
}
