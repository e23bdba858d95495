/* motion_document.c -- joints and channels: read from scene, motion and activation documents, written into a scene. */
#include "motion_document.h"

#include "clip_reader.h"

#include <stdlib.h>
#include <string.h>

static const double RADIANS_PER_DEGREE = SN_PI / 180.0;
static const char *const joint_types[] = {"hinge", "pose", NULL}; /* in the order of sn_joint_kind */

double sn_unscale(double value, double factor) {
    double q = value / factor, low = q, high = q;
    for (int step = 0; step < 3; step++) {
        if (low * factor == value) return low;
        if (high * factor == value) return high;
        low = nextafter(low, -INFINITY);
        high = nextafter(high, INFINITY);
    }
    return q;
}

/* Unit already to rounding: then it stays as it is, and reading what was written gives the same bits. */
static bool is_unit(double squared_length) { return fabs(squared_length - 1.0) <= 1e-15; }

static sn_status parse_interpolation(const sn_json_value *object, sn_interpolation *out, sn_error *error) {
    sn_json_value member = sn_json_member(object, "interpolation");
    int choice = (int)*out;
    sn_status status = sn_json_get_choice(&member, sn_interpolation_names, &choice, error);
    *out = (sn_interpolation)choice;
    return status;
}

/* ---- keys ------------------------------------------------------------------------------------------------------------- */

/* "time" in seconds, or "frame". */
static sn_status parse_time(const sn_json_value *key, sn_clock clock, double *out, sn_error *error) {
    sn_json_value time = sn_json_member(key, "time"), frame = sn_json_member(key, "frame");
    if (sn_json_has(&time) == sn_json_has(&frame)) return sn_json_complain(key, error, "expected either \"time\" (seconds) or \"frame\"");
    if (sn_json_has(&time)) return sn_json_get_number(&time, -INFINITY, INFINITY, out, error);
    double number = 0.0;
    sn_status status = sn_json_get_number(&frame, -INFINITY, INFINITY, &number, error);
    *out = number / clock.rate;
    return status;
}

/* How the values of a channel are written. */
typedef struct value_kind {
    const char *name; /* of the member in a key that is an object */
    double scale, low, high;
} value_kind;

/* [time, value], or { "time" or "frame", and the value by its name }. */
static sn_status parse_key(const sn_json_value *key, value_kind kind, sn_clock clock, double *time, double *value, sn_error *error) {
    double pair[2] = {0};
    sn_status status;
    if (sn_json_is_array(key)) {
        status = sn_json_get_fixed(key, 2, pair, error);
        if (status == SN_OK && (pair[1] < kind.low || pair[1] > kind.high))
            status = sn_json_complain(key, error, "expected [time, %s], the latter in [%g,%g], found %g", kind.name, kind.low, kind.high,
                                      pair[1]);
    } else if ((status = sn_json_expect_object(key, error)) == SN_OK) {
        const char *const known[] = {"time", "frame", kind.name, NULL};
        sn_json_value number = sn_json_member(key, kind.name);
        status = parse_time(key, clock, &pair[0], error);
        if (status == SN_OK) status = sn_json_check_members(key, known, error);
        if (status == SN_OK) status = sn_json_require(&number, "a number", error);
        if (status == SN_OK) status = sn_json_get_number(&number, kind.low, kind.high, &pair[1], error);
    }
    *time = pair[0];
    *value = pair[1] * kind.scale;
    return status;
}

static sn_status alloc_channel(sn_index count, sn_channel *out, sn_error *error) {
    out->times = SN_NEW(double, count);
    out->values = SN_NEW(double, count);
    if (out->times == NULL || out->values == NULL) return sn_fail_memory(error, "a channel");
    out->count = count;
    return SN_OK;
}

static sn_status parse_keys(const sn_json_value *keys, value_kind kind, sn_clock clock, sn_channel *out, sn_error *error) {
    sn_status status = sn_json_expect_array(keys, error);
    if (status != SN_OK) return status;
    sn_index count = sn_json_length(keys);
    if (count == 0) return sn_json_complain(keys, error, "there is no key; a constant is written as a number");
    status = alloc_channel(count, out, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value key = sn_json_element(keys, i);
        status = parse_key(&key, kind, clock, &out->times[i], &out->values[i], error);
        if (status == SN_OK && i > 0 && !(out->times[i] > out->times[i - 1]))
            status = sn_json_complain(&key, error, "the key is not later than the one before it; sort the keys by time");
    }
    return status;
}

/* ---- joints: hinges --------------------------------------------------------------------------------------------------- */

/* A constant turn a frame, from 0 at the first frame to the last. */
static sn_status ramp(double degrees_per_frame, sn_clock clock, sn_channel *out, sn_error *error) {
    double frames = (double)clock.last_frame - clock.first_frame;
    if (frames <= 0.0) return SN_OK;
    sn_status status = alloc_channel(2, out, error);
    if (status != SN_OK) return status;
    out->times[0] = clock.first_frame / clock.scene_rate;
    out->times[1] = clock.last_frame / clock.scene_rate;
    out->values[1] = degrees_per_frame * frames * RADIANS_PER_DEGREE;
    return SN_OK;
}

static sn_status parse_angle(const sn_json_value *joint, sn_clock clock, sn_joint *out, sn_error *error) {
    sn_json_value keys = sn_json_member(joint, "keys"), speed = sn_json_member(joint, "degreesPerFrame"),
                  constant = sn_json_member(joint, "degrees");
    double number = 0.0;
    int given = sn_json_has(&keys) + sn_json_has(&speed) + sn_json_has(&constant);
    if (given > 1) return sn_json_complain(joint, error, "expected only one of \"keys\", \"degreesPerFrame\" and \"degrees\"");
    sn_status status = parse_interpolation(joint, &out->angle.interpolation, error);
    if (status != SN_OK) return status;
    if (sn_json_has(&keys)) return parse_keys(&keys, (value_kind){"degrees", RADIANS_PER_DEGREE, -1e6, 1e6}, clock, &out->angle, error);
    if (sn_json_has(&speed) && !(clock.scene_rate > 0.0))
        return sn_json_complain(&speed, error, "only the frames of a scene tell where this begins and ends; give \"keys\"");
    status = sn_json_get_number(sn_json_has(&speed) ? &speed : &constant, -1e6, 1e6, &number, error);
    if (status == SN_OK && sn_json_has(&speed)) return ramp(number, clock, &out->angle, error);
    out->angle.constant = number * RADIANS_PER_DEGREE;
    return status;
}

static sn_status parse_hinge(const sn_json_value *joint, sn_clock clock, sn_joint *out, sn_error *error) {
    sn_json_value axis = sn_json_member(joint, "axis"), point = sn_json_member(joint, "point");
    sn_status status = sn_json_require(&axis, "the direction [x,y,z] to turn about", error);
    if (status == SN_OK) status = sn_json_get_vec3(&axis, &out->axis, error);
    if (status == SN_OK) status = sn_json_require(&point, "a point [x,y,z] on the axis", error);
    if (status == SN_OK) status = sn_json_get_vec3(&point, &out->point, error);
    if (status != SN_OK) return status;
    if (!is_unit(sn_norm2(out->axis))) out->axis = sn_normalize(out->axis);
    if (!(sn_norm2(out->axis) > 0.0)) return sn_json_complain(&axis, error, "the axis has no length");
    out->point = sn_scale(out->point, clock.meters_per_unit);
    return parse_angle(joint, clock, out, error);
}

/* ---- joints: poses ---------------------------------------------------------------------------------------------------- */

/* Unit quaternion of a rotation matrix (Shepperd 1978: from its largest component, which never cancels). */
static sn_quat quat_from_matrix(const sn_mat3 *r) {
    const double(*m)[3] = r->m;
    double trace = m[0][0] + m[1][1] + m[2][2];
    sn_quat q;
    if (trace > m[0][0] && trace > m[1][1] && trace > m[2][2])
        q = (sn_quat){1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
    else if (m[0][0] >= m[1][1] && m[0][0] >= m[2][2])
        q = (sn_quat){m[2][1] - m[1][2], 1.0 + 2.0 * m[0][0] - trace, m[0][1] + m[1][0], m[2][0] + m[0][2]};
    else if (m[1][1] >= m[2][2])
        q = (sn_quat){m[0][2] - m[2][0], m[0][1] + m[1][0], 1.0 + 2.0 * m[1][1] - trace, m[1][2] + m[2][1]};
    else
        q = (sn_quat){m[1][0] - m[0][1], m[2][0] + m[0][2], m[1][2] + m[2][1], 1.0 + 2.0 * m[2][2] - trace};
    return sn_quat_normalize(q);
}

/* Columns orthonormal and right-handed, to the precision of matrices that were float once. */
static bool is_rotation(const sn_mat3 *r) {
    sn_vec3 x = sn_v3(r->m[0][0], r->m[1][0], r->m[2][0]), y = sn_v3(r->m[0][1], r->m[1][1], r->m[2][1]),
            z = sn_v3(r->m[0][2], r->m[1][2], r->m[2][2]);
    double off = fabs(sn_norm2(x) - 1.0) + fabs(sn_norm2(y) - 1.0) + fabs(sn_dot(x, y)) + sn_distance(sn_cross(x, y), z);
    return off <= 1e-4;
}

static sn_status parse_matrix(const sn_json_value *value, sn_rigid *out, sn_error *error) {
    double m[16] = {0};
    sn_status status = sn_json_get_fixed(value, 16, m, error);
    if (status != SN_OK) return status;
    sn_mat3 r = {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}};
    if (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || m[15] != 1.0)
        return sn_json_complain(value, error,
                                "the last row of the matrix is not 0, 0, 0, 1 (rows are written one after the other, the "
                                "translation in the last column)");
    if (!is_rotation(&r)) return sn_json_complain(value, error, "the matrix scales, shears or mirrors; a bone moves rigidly");
    *out = (sn_rigid){quat_from_matrix(&r), sn_v3(m[3], m[7], m[11])};
    return SN_OK;
}

static sn_status parse_rotation(const sn_json_value *value, sn_quat *out, sn_error *error) {
    double q[4] = {1, 0, 0, 0};
    sn_status status = sn_json_get_fixed(value, 4, q, error);
    if (status != SN_OK) return status;
    *out = (sn_quat){q[0], q[1], q[2], q[3]};
    double squared = sn_quat_dot(*out, *out);
    if (!(fabs(squared - 1.0) <= 2e-3))
        return sn_json_complain(value, error, "the quaternion [w,x,y,z] has the length %g, not 1", sqrt(squared));
    if (!is_unit(squared)) *out = sn_quat_normalize(*out);
    return SN_OK;
}

static sn_status parse_pose_key(const sn_json_value *key, sn_clock clock, sn_pose_key *out, sn_error *error) {
    static const char *const known[] = {"time", "frame", "matrix", "rotation", "translation", NULL};
    sn_json_value matrix = sn_json_member(key, "matrix"), rotation = sn_json_member(key, "rotation"),
                  translation = sn_json_member(key, "translation");
    out->pose = sn_rigid_identity();
    sn_status status = sn_json_expect_object(key, error);
    if (status == SN_OK) status = parse_time(key, clock, &out->time, error);
    if (status == SN_OK) status = sn_json_check_members(key, known, error);
    if (status != SN_OK) return status;
    if (sn_json_has(&matrix)) {
        if (sn_json_has(&rotation) || sn_json_has(&translation))
            return sn_json_complain(key, error, "expected either \"matrix\", or \"rotation\" and \"translation\"");
        status = parse_matrix(&matrix, &out->pose, error);
    } else {
        status = parse_rotation(&rotation, &out->pose.rotation, error);
        if (status == SN_OK) status = sn_json_get_vec3(&translation, &out->pose.translation, error);
    }
    out->pose.translation = sn_scale(out->pose.translation, clock.meters_per_unit);
    return status;
}

static sn_status parse_pose(const sn_json_value *joint, sn_clock clock, sn_joint *out, sn_error *error) {
    sn_json_value keys = sn_json_member(joint, "keys");
    sn_status status = sn_json_expect_array(&keys, error);
    if (status == SN_OK) status = parse_interpolation(joint, &out->interpolation, error);
    if (status != SN_OK) return status;
    sn_index count = sn_json_length(&keys);
    if (count == 0) return sn_json_complain(&keys, error, "there is no key");
    if ((out->keys = SN_NEW(sn_pose_key, count)) == NULL) return sn_fail_memory(error, "the keys of a joint");
    out->key_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value key = sn_json_element(&keys, i);
        status = parse_pose_key(&key, clock, &out->keys[i], error);
        if (status == SN_OK && i > 0 && !(out->keys[i].time > out->keys[i - 1].time))
            status = sn_json_complain(&key, error, "the key is not later than the one before it; sort the keys by time");
    }
    return status;
}

/* ---- joints ----------------------------------------------------------------------------------------------------------- */

/* The joint of that name among the first `count`. */
static sn_index find_joint(const sn_motion *motion, sn_index count, const char *name) {
    for (sn_index i = 0; i < count; i++)
        if (strcmp(motion->joints[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_status parse_name_and_parent(const sn_json_value *joint, sn_motion *motion, sn_error *error) {
    sn_joint *out = &motion->joints[joint->element];
    sn_json_value name = sn_json_member(joint, "name"), parent = sn_json_member(joint, "parent");
    char *parent_name = NULL;
    out->parent = SN_NONE;
    sn_status status = sn_json_require(&name, "the name of the joint", error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK && find_joint(motion, joint->element, out->name) != SN_NONE)
        status = sn_json_complain(&name, error, "a joint before it has the same name \"%s\"", out->name);
    if (status == SN_OK) status = sn_json_get_text(&parent, &parent_name, error);
    if (status == SN_OK && parent_name != NULL && (out->parent = find_joint(motion, joint->element, parent_name)) == SN_NONE)
        status =
            sn_json_complain(&parent, error, "there is no joint \"%s\" before this one; list parents before their children", parent_name);
    free(parent_name);
    return status;
}

/* Places in the rest pose, which importers tell: "rest" and "restRotation" of the joint's frame, "end" of its segment. */
static sn_status parse_rest(const sn_json_value *joint, sn_clock clock, sn_joint *out, sn_error *error) {
    sn_json_value rest = sn_json_member(joint, "rest"), rotation = sn_json_member(joint, "restRotation"),
                  end = sn_json_member(joint, "end");
    out->has_rest = sn_json_has(&rest);
    out->has_end = sn_json_has(&end);
    out->rest_rotation = sn_quat_identity();
    sn_status status = sn_json_get_vec3(&rest, &out->rest, error);
    if (status == SN_OK) status = parse_rotation(&rotation, &out->rest_rotation, error);
    if (status == SN_OK) status = sn_json_get_vec3(&end, &out->end, error);
    out->rest = sn_scale(out->rest, clock.meters_per_unit);
    out->end = sn_scale(out->end, clock.meters_per_unit);
    return status;
}

static sn_status parse_joint(const sn_json_value *joint, sn_clock clock, sn_motion *motion, sn_error *error) {
    static const char *const known[] = {"name",    "parent",        "type", "axis",         "point", "keys", "degreesPerFrame",
                                        "degrees", "interpolation", "rest", "restRotation", "end",   NULL};
    sn_joint *out = &motion->joints[joint->element];
    sn_json_value type = sn_json_member(joint, "type");
    int kind = SN_JOINT_HINGE;
    sn_status status = sn_json_expect_object(joint, error);
    if (status == SN_OK) status = parse_name_and_parent(joint, motion, error);
    if (status == SN_OK) status = sn_json_require(&type, "\"hinge\" or \"pose\"", error);
    if (status == SN_OK) status = sn_json_get_choice(&type, joint_types, &kind, error);
    if (status == SN_OK) status = sn_json_check_members(joint, known, error);
    if (status != SN_OK) return status;
    out->kind = (sn_joint_kind)kind;
    status = parse_rest(joint, clock, out, error);
    if (status != SN_OK) return status;
    return out->kind == SN_JOINT_HINGE ? parse_hinge(joint, clock, out, error) : parse_pose(joint, clock, out, error);
}

static sn_status parse_joints(const sn_json_value *joints, sn_clock clock, sn_motion *out, sn_error *error) {
    if (!sn_json_has(joints)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(joints, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((out->joints = SN_NEW(sn_joint, count)) == NULL) return sn_fail_memory(error, "joints");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value joint = sn_json_element(joints, i);
        out->joint_count = i + 1;
        status = parse_joint(&joint, clock, out, error);
    }
    return status;
}

/* ---- coordinates ---------------------------------------------------------------------------------------------------------- */

static const char *const coordinate_units[] = {"", "rad", "m", NULL};

static sn_status parse_coordinate(const sn_json_value *value, sn_clock clock, sn_coordinate *out, sn_error *error) {
    static const char *const known[] = {"name", "unit", "rate", "values", NULL};
    sn_json_value name = sn_json_member(value, "name"), unit = sn_json_member(value, "unit"), rate = sn_json_member(value, "rate"),
                  values = sn_json_member(value, "values");
    int choice = 0;
    out->rate = clock.rate;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&name, "the name of the coordinate", error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_get_choice(&unit, coordinate_units, &choice, error);
    if (status == SN_OK) status = sn_json_get_number(&rate, SN_JSON_POSITIVE, INFINITY, &out->rate, error);
    if (status == SN_OK) status = sn_json_get_numbers(&values, 1, -1, &out->count, &out->values, error);
    if (status == SN_OK && out->count == 0) status = sn_json_complain(&values, error, "there is no sample");
    if (status == SN_OK && (out->unit = sn_strdup(coordinate_units[choice])) == NULL) status = sn_fail_memory(error, "a unit");
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

static sn_status parse_coordinates(const sn_json_value *list, sn_clock clock, sn_motion *out, sn_error *error) {
    enum { MOST_COORDINATES = 8 * SN_LIST_LIMIT };
    if (!sn_json_has(list)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(list, MOST_COORDINATES, &count, error);
    if (status != SN_OK) return status;
    if ((out->coordinates = SN_NEW(sn_coordinate, count)) == NULL) return sn_fail_memory(error, "coordinates");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value coordinate = sn_json_element(list, i);
        out->coordinate_count = i + 1;
        status = parse_coordinate(&coordinate, clock, &out->coordinates[i], error);
    }
    return status;
}

static sn_status parse_members(const sn_json_value *motion, sn_clock clock, sn_motion *out, sn_error *error) {
    sn_json_value joints = sn_json_member(motion, "joints"), coordinates = sn_json_member(motion, "coordinates"),
                  bones = sn_json_member(motion, "bones");
    sn_status status = parse_joints(&joints, clock, out, error);
    if (status == SN_OK) status = parse_coordinates(&coordinates, clock, out, error);
    return status == SN_OK ? sn_motion_bones_parse(&bones, out, error) : status;
}

/* ---- documents ------------------------------------------------------------------------------------------------------------ */

/* A JSON document that another one names. */
static sn_status read_beside(const sn_json_value *uri, sn_json_tree **out, sn_error *error) {
    char *text = NULL, *path = NULL;
    sn_blob blob = {0};
    *out = NULL;
    sn_status status = sn_json_get_text(uri, &text, error);
    if (status == SN_OK && (path = sn_path_beside(sn_json_name(uri->tree), text)) == NULL) status = sn_fail_memory(error, "a path");
    if (status == SN_OK) status = sn_blob_read_named(path, &blob, error);
    if (status == SN_OK) status = sn_json_parse(&blob, out, error);
    sn_blob_free(&blob);
    free(path);
    free(text);
    return status;
}

/* A motion document has a unit and a rate of its own, or those that *clock comes with. */
static sn_status parse_motion_document(const sn_json_tree *tree, sn_clock *clock, sn_motion *out, sn_error *error) {
    static const char *const known[] = {"format", "version",     "name",  "metersPerUnit", "rate",
                                        "joints", "coordinates", "bones", "history",       NULL};
    sn_json_value top = sn_json_top(tree), unit = sn_json_member(&top, "metersPerUnit"), rate = sn_json_member(&top, "rate");
    sn_status status = sn_json_expect_format(&top, "sinew-motion", 1, error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, &clock->meters_per_unit, error);
    if (status == SN_OK) status = sn_json_get_number(&rate, SN_JSON_POSITIVE, INFINITY, &clock->rate, error);
    if (status == SN_OK) status = parse_members(&top, *clock, out, error);
    return status == SN_OK ? sn_json_check_members(&top, known, error) : status;
}

/* What stands in the scene itself. */
static sn_status parse_inline_motion(const sn_json_value *value, sn_clock clock, sn_motion *out, sn_error *error) {
    static const char *const known[] = {"joints", "coordinates", "bones", NULL};
    sn_status status = parse_members(value, clock, out, error);
    return status == SN_OK ? sn_json_check_members(value, known, error) : status;
}

sn_status sn_motion_parse(const sn_json_value *value, sn_clock clock, sn_motion *out, sn_error *error) {
    static const char *const known[] = {"uri", NULL};
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value uri = sn_json_member(value, "uri");
    sn_status status = sn_json_expect_object(value, error);
    if (status != SN_OK || !sn_json_has(&uri)) return status == SN_OK ? parse_inline_motion(value, clock, out, error) : status;
    sn_json_tree *tree = NULL;
    status = sn_json_check_members(value, known, error);
    if (status == SN_OK) status = read_beside(&uri, &tree, error);
    if (status == SN_OK) status = parse_motion_document(tree, &clock, out, error);
    sn_json_tree_free(tree);
    return status;
}

/* A motion document as a clip: its joints at each frame of its rate. */
static sn_status sample(const sn_clip_source *source, const sn_motion *motion, double rate, sn_clip *out, sn_error *error) {
    sn_reader reader = sn_clip_open(source->motion, error);
    sn_status status = sn_motion_validate(motion, error);
    if (status != SN_OK) return status;
    double frames = sn_clip_frames_of(motion, rate),
           frame = (double)motion->joint_count * sizeof(sn_rigid) + (double)motion->coordinate_count * sizeof(double);
    if (!(frames < SN_INDEX_MAX / 2) || !sn_reader_may_take(&reader, frames * frame))
        return sn_fail_at(error, SN_ERROR_INPUT, source->motion->name, 0, "its last key is %g frames behind the first: too long to sample",
                          frames);
    return sn_clip_from_motion(motion, rate, out, error);
}

static sn_status parse_named(const sn_blob *blob, sn_clock *clock, sn_motion *motion, char **name, sn_error *error) {
    sn_json_tree *tree = NULL;
    *motion = (sn_motion){0};
    *name = NULL;
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status == SN_OK) status = parse_motion_document(tree, clock, motion, error);
    if (status == SN_OK) {
        sn_json_value top = sn_json_top(tree), member = sn_json_member(&top, "name");
        status = sn_json_get_text(&member, name, error);
    }
    sn_json_tree_free(tree);
    return status;
}

sn_status sn_motion_document_parse(const sn_blob *blob, sn_motion *out, char **name, double *rate, sn_error *error) {
    sn_clock clock = {.rate = 24.0, .meters_per_unit = 1.0};
    sn_status status = parse_named(blob, &clock, out, name, error);
    if (status == SN_OK) status = sn_motion_validate(out, error);
    *rate = clock.rate;
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_motion_free(out);
    free(*name);
    *name = NULL;
    return status;
}

sn_status sn_motion_document_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    const double *unit = &source->options.meters_per_unit;
    sn_clock clock = {.rate = 24.0, .meters_per_unit = *unit > 0.0 ? *unit : 1.0};
    sn_motion motion;
    char *name;
    *out = (sn_clip){0};
    sn_status status = parse_named(source->motion, &clock, &motion, &name, error);
    if (status == SN_OK && *unit > 0.0 && fabs(*unit - clock.meters_per_unit) > 1e-9 * *unit)
        status = sn_fail_at(error, SN_ERROR_USAGE, source->motion->name, 0, "a motion document says its unit, here %g m, not %g m",
                            clock.meters_per_unit, *unit);
    if (source->options.rate > 0.0) clock.rate = source->options.rate;
    if (status == SN_OK) status = sample(source, &motion, clock.rate, out, error);
    if (status == SN_OK) {
        out->name = name;
        out->meters_per_unit_of_source = clock.meters_per_unit;
        name = NULL;
    }
    free(name);
    sn_motion_free(&motion);
    return status;
}

/* ---- activations ------------------------------------------------------------------------------------------------------ */

const char *const sn_activation_members[] = {"format", "version", "name", "channels", "history", NULL};

static const value_kind activation_kind = {"activation", 1.0, 0.0, 1.0};

/* { "times": [...], "values": [...] } */
static sn_status parse_samples(const sn_json_value *channel, sn_channel *out, sn_error *error) {
    static const char *const known[] = {"times", "values", "interpolation", NULL};
    sn_json_value times = sn_json_member(channel, "times"), values = sn_json_member(channel, "values");
    sn_status status = sn_json_expect_object(channel, error);
    if (status == SN_OK) status = sn_json_check_members(channel, known, error);
    if (status == SN_OK) status = parse_interpolation(channel, &out->interpolation, error);
    if (status == SN_OK) status = sn_json_get_numbers(&times, 1, -1, &out->count, &out->times, error);
    if (status == SN_OK) status = sn_json_get_numbers(&values, 1, out->count, NULL, &out->values, error);
    if (status == SN_OK && out->count == 0) status = sn_json_complain(&times, error, "there is no sample");
    for (sn_index i = 0; i < out->count && status == SN_OK; i++) {
        if (out->values[i] < 0.0 || out->values[i] > 1.0)
            status = sn_json_complain(&values, error, "sample %ld is %g; an activation is in [0,1]", (long)i, out->values[i]);
        else if (i > 0 && !(out->times[i] > out->times[i - 1]))
            status = sn_json_complain(&times, error, "sample %ld is not later than the one before it", (long)i);
    }
    return status;
}

static sn_status parse_channel_document(const sn_json_tree *tree, const char *name, sn_channel *out, sn_error *error) {
    sn_json_value top = sn_json_top(tree), format = sn_json_member(&top, "format"), channels = sn_json_member(&top, "channels");
    sn_status status = sn_json_has(&format) ? sn_json_expect_format(&top, "sinew-activation", 1, error) : SN_OK;
    if (status == SN_OK) status = sn_json_expect_object(&channels, error);
    if (status == SN_OK) status = sn_json_check_members(&top, sn_activation_members, error);
    if (status != SN_OK) return status;
    sn_json_value channel = sn_json_member(&channels, name);
    if (!sn_json_has(&channel)) return sn_json_complain(&channels, error, "there is no channel \"%s\"", name);
    return parse_samples(&channel, out, error);
}

static sn_status parse_channel_reference(const sn_json_value *value, const char *fallback, sn_channel *out, sn_error *error) {
    static const char *const known[] = {"uri", "channel", NULL};
    sn_json_value uri = sn_json_member(value, "uri"), channel = sn_json_member(value, "channel");
    sn_json_tree *tree = NULL;
    char *name = NULL;
    sn_status status = sn_json_get_text(&channel, &name, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    if (status == SN_OK) status = read_beside(&uri, &tree, error);
    if (status == SN_OK) status = parse_channel_document(tree, name != NULL ? name : fallback, out, error);
    sn_json_tree_free(tree);
    free(name);
    return status;
}

sn_status sn_activation_parse(const sn_json_value *value, sn_clock clock, const char *fallback, sn_channel *out, sn_error *error) {
    static const char *const known[] = {"keys", "interpolation", NULL};
    if (!sn_json_has(value)) return SN_OK;
    if (sn_json_is_number(value)) return sn_json_get_number(value, 0.0, 1.0, &out->constant, error);
    sn_json_value uri = sn_json_member(value, "uri"), keys = sn_json_member(value, "keys");
    sn_status status = sn_json_expect_object(value, error);
    if (status != SN_OK)
        return sn_json_mismatch(value, error, "a number in [0,1], {\"keys\": [[time, activation], ...]} or {\"uri\", \"channel\"}");
    if (sn_json_has(&uri)) return parse_channel_reference(value, fallback, out, error);
    status = sn_json_check_members(value, known, error);
    if (status == SN_OK) status = parse_interpolation(value, &out->interpolation, error);
    return status == SN_OK ? parse_keys(&keys, activation_kind, clock, out, error) : status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------------- */

static void write_keys(const sn_channel *channel, double scale, sn_json *json) {
    sn_json_array(json, "keys");
    for (sn_index i = 0; i < channel->count; i++)
        sn_json_numbers(json, NULL, (const double[2]){channel->times[i], sn_unscale(channel->values[i], scale)}, 2);
    sn_json_close(json);
    sn_json_text(json, "interpolation", sn_interpolation_names[channel->interpolation]);
}

void sn_activation_write(const sn_channel *channel, sn_json *json) {
    if (channel->count == 0) {
        sn_json_number(json, "activation", channel->constant);
        return;
    }
    sn_json_object(json, "activation");
    write_keys(channel, 1.0, json);
    sn_json_close(json);
}

static sn_vec3 unscale_point(sn_vec3 p, double factor) {
    return sn_v3(sn_unscale(p.x, factor), sn_unscale(p.y, factor), sn_unscale(p.z, factor));
}

static void write_hinge(const sn_joint *joint, double meters_per_unit, sn_json *json) {
    sn_json_vec3(json, "axis", joint->axis);
    sn_json_vec3(json, "point", unscale_point(joint->point, meters_per_unit));
    if (joint->angle.count > 0)
        write_keys(&joint->angle, RADIANS_PER_DEGREE, json);
    else
        sn_json_number(json, "degrees", sn_unscale(joint->angle.constant, RADIANS_PER_DEGREE));
}

/* The frame of a document's rate where that says the same time exactly. */
static void write_time(double time, double rate, sn_json *json) {
    double frame = floor(time * rate + 0.5);
    if (rate > 0.0 && fabs(frame) < 1e9 && frame / rate == time)
        sn_json_integer(json, "frame", (int64_t)frame);
    else
        sn_json_number(json, "time", time);
}

/* rate 0: keys tell their time. */
static void write_pose(const sn_joint *joint, double meters_per_unit, double rate, sn_json *json) {
    sn_json_array(json, "keys");
    for (sn_index i = 0; i < joint->key_count; i++) {
        const sn_pose_key *key = &joint->keys[i];
        const sn_quat q = key->pose.rotation;
        sn_json_object_line(json, NULL);
        write_time(key->time, rate, json);
        sn_json_numbers(json, "rotation", (const double[4]){q.w, q.x, q.y, q.z}, 4);
        sn_json_vec3(json, "translation", unscale_point(key->pose.translation, meters_per_unit));
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_text(json, "interpolation", sn_interpolation_names[joint->interpolation]);
}

static void write_rest(const sn_joint *joint, double meters_per_unit, sn_json *json) {
    const sn_quat q = joint->rest_rotation;
    if (joint->has_rest) {
        sn_json_vec3(json, "rest", unscale_point(joint->rest, meters_per_unit));
        sn_json_numbers(json, "restRotation", (const double[4]){q.w, q.x, q.y, q.z}, 4);
    }
    if (joint->has_end) sn_json_vec3(json, "end", unscale_point(joint->end, meters_per_unit));
}

static void write_joints(const sn_motion *motion, double meters_per_unit, double rate, sn_json *json) {
    sn_json_array(json, "joints");
    for (sn_index i = 0; i < motion->joint_count; i++) {
        const sn_joint *joint = &motion->joints[i];
        sn_json_object(json, NULL);
        sn_json_text(json, "name", joint->name);
        if (joint->parent != SN_NONE) sn_json_text(json, "parent", motion->joints[joint->parent].name);
        sn_json_text(json, "type", joint_types[joint->kind]);
        write_rest(joint, meters_per_unit, json);
        if (joint->kind == SN_JOINT_HINGE)
            write_hinge(joint, meters_per_unit, json);
        else
            write_pose(joint, meters_per_unit, rate, json);
        sn_json_close(json);
    }
    sn_json_close(json);
}

/* rate: of the document; coordinates of another one tell theirs. */
static void write_coordinates(const sn_motion *motion, double rate, sn_json *json) {
    if (motion->coordinate_count == 0) return;
    sn_json_array(json, "coordinates");
    for (sn_index i = 0; i < motion->coordinate_count; i++) {
        const sn_coordinate *coordinate = &motion->coordinates[i];
        sn_json_object(json, NULL);
        sn_json_text(json, "name", coordinate->name);
        sn_json_text(json, "unit", coordinate->unit);
        if (coordinate->rate != rate) sn_json_number(json, "rate", coordinate->rate);
        sn_json_numbers(json, "values", coordinate->values, (size_t)coordinate->count);
        sn_json_close(json);
    }
    sn_json_close(json);
}

void sn_motion_write(const sn_motion *motion, double meters_per_unit, sn_json *json) {
    sn_json_object(json, "motion");
    write_joints(motion, meters_per_unit, 0.0, json);
    write_coordinates(motion, 0.0, json);
    sn_json_close(json);
}

static sn_status write_document(const sn_motion *motion, const sn_motion_head *head, const sn_json_tree *before, sn_output *output,
                                sn_error *error) {
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return sn_fail_memory(error, "a motion document");
    sn_json_object(json, NULL);
    sn_json_text(json, "format", "sinew-motion");
    sn_json_integer(json, "version", 1);
    if (head->name != NULL) sn_json_text(json, "name", head->name);
    sn_json_number(json, "metersPerUnit", 1.0);
    sn_json_number(json, "rate", head->rate);
    write_joints(motion, 1.0, head->rate, json);
    write_coordinates(motion, head->rate, json);
    sn_status status = sn_motion_bones_write(motion, head->path, json, error);
    sn_history_write(before, head->entry, json);
    sn_status end = sn_json_end(json, error);
    return status == SN_OK ? end : status;
}

sn_status sn_motion_document_write(const sn_motion *motion, const sn_motion_head *head, sn_output *output, sn_error *error) {
    sn_json_tree *before = NULL;
    sn_status status = sn_motion_validate(motion, error);
    if (status == SN_OK && head->history_from != NULL) status = sn_json_parse(head->history_from, &before, error);
    if (status == SN_OK) status = write_document(motion, head, before, output, error);
    sn_json_tree_free(before);
    return status;
}
