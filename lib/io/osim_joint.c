/* osim_joint.c -- joints of OpenSim's models as rows of moves, and the coordinates that they move by. */
#include "osim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const sn_vec3 AXES[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* ---- coordinates --------------------------------------------------------------------------------------------------------------------- */

/* What a file says a coordinate is; version 4 leaves it to the joint. */
typedef enum motion_type { NOT_SAID, ROTATIONAL, TRANSLATIONAL, COUPLED } motion_type;

typedef struct joint_reader {
    sn_osim *o;
    sn_osim_joint *joint;
    sn_index first; /* of its coordinates */
    motion_type said[6];
} joint_reader;

static sn_status make_coordinate(joint_reader *r, sn_span name, sn_index number, sn_skeleton_coordinate **out) {
    sn_osim *o = r->o;
    char spare[64];
    sn_span joint = sn_xml_attribute_text(o->tree, r->joint->element, "name");
    if (name.length == 0) {
        snprintf(spare, sizeof spare, "%.*s_coord_%d", (int)(joint.length < 40 ? joint.length : 40), joint.text != NULL ? joint.text : "",
                 (int)number);
        name = (sn_span){spare, strlen(spare)};
    }
    void *coordinates = o->out->coordinates;
    if (!sn_grow(&coordinates, &o->coordinate_capacity, (size_t)o->out->coordinate_count + 1, sizeof **out))
        return sn_fail_memory(o->error, "a coordinate");
    o->out->coordinates = coordinates;
    *out = &o->out->coordinates[o->out->coordinate_count++];
    **out = (sn_skeleton_coordinate){.name = sn_xml_copy(name), .low = -INFINITY, .high = INFINITY};
    if (joint.text != NULL) (*out)->joint = sn_xml_copy(joint);
    return (*out)->name != NULL && ((*out)->joint != NULL || joint.text == NULL) ? SN_OK : sn_fail_memory(o->error, "a coordinate");
}

static motion_type read_type(sn_span text) {
    return sn_span_is_like(text, "rotational")      ? ROTATIONAL
           : sn_span_is_like(text, "translational") ? TRANSLATIONAL
           : text.length > 0                        ? COUPLED
                                                    : NOT_SAID;
}

static sn_status read_coordinate(joint_reader *r, sn_index element) {
    const sn_osim *o = r->o;
    const sn_xml_tree *tree = o->tree;
    sn_index number = o->out->coordinate_count - r->first;
    sn_skeleton_coordinate *c = NULL;
    double range[2] = {-INFINITY, INFINITY};
    if (number == 6) return sn_xml_fail(tree, element, o->error, "a joint cannot have more than 6 coordinates");
    sn_status status = make_coordinate(r, sn_xml_attribute_text(tree, element, "name"), number, &c);
    if (status != SN_OK || c == NULL) return status;
    status = sn_xml_numbers(sn_xml_child_value(tree, element, "default_value"), 1, &c->rest, o->error);
    if (status == SN_OK) status = sn_xml_numbers(sn_xml_child_value(tree, element, "range"), 2, range, o->error);
    if (status == SN_OK) status = sn_xml_bool(sn_xml_child_value(tree, element, "locked"), &c->locked, o->error);
    if (status == SN_OK) status = sn_xml_bool(sn_xml_child_value(tree, element, "clamped"), &c->clamped, o->error);
    if (status == SN_OK && range[0] > range[1]) return sn_xml_fail(tree, element, o->error, "the range is upside down");
    c->low = range[0];
    c->high = range[1];
    r->said[number] = read_type(sn_xml_child_text(tree, element, "motion_type"));
    return status;
}

static sn_status read_coordinates(joint_reader *r) {
    const sn_xml_tree *tree = r->o->tree;
    sn_index list = sn_xml_child(tree, r->joint->element, "coordinates");
    if (list == SN_NONE) list = sn_xml_child(tree, sn_xml_child(tree, r->joint->element, "CoordinateSet"), "objects");
    sn_status status = SN_OK;
    for (sn_index i = sn_xml_child(tree, list, "Coordinate"); i != SN_NONE && status == SN_OK; i = sn_xml_next(tree, i, "Coordinate"))
        status = read_coordinate(r, i);
    return status;
}

/* A coordinate that turns, or shifts, by itself is an angle, or a length; `whole` = by itself. */
static void set_use(joint_reader *r, sn_index number, bool turns, bool whole) {
    sn_skeleton_coordinate *c = &r->o->out->coordinates[r->first + number];
    motion_type said = r->said[number];
    c->angular = c->angular || said == ROTATIONAL || (turns && said != TRANSLATIONAL);
    c->degrees = c->degrees || said == ROTATIONAL || (turns && whole && said == NOT_SAID);
}

/* ---- joints of a fixed kind ------------------------------------------------------------------------------------------------------------
 */

/* One step of a joint: coordinate `number` turns about an axis, or shifts along it. */
typedef struct step {
    bool turns;
    int axis, number;
} step;
typedef struct joint_kind {
    const char *name;
    int coordinate_count, step_count;
    step steps[6]; /* the outermost first */
} joint_kind;

static const joint_kind kinds[] = {
    {"WeldJoint", 0, 0, {{0}}},
    {"PinJoint", 1, 1, {{true, 2, 0}}},
    {"SliderJoint", 1, 1, {{false, 0, 0}}},
    {"UniversalJoint", 2, 2, {{true, 0, 0}, {true, 1, 1}}},
    {"BallJoint", 3, 3, {{true, 0, 0}, {true, 1, 1}, {true, 2, 2}}},
    {"GimbalJoint", 3, 3, {{true, 0, 0}, {true, 1, 1}, {true, 2, 2}}},
    {"PlanarJoint", 3, 3, {{false, 0, 1}, {false, 1, 2}, {true, 2, 0}}},
    {"FreeJoint", 6, 6, {{false, 0, 3}, {false, 1, 4}, {false, 2, 5}, {true, 0, 0}, {true, 1, 1}, {true, 2, 2}}},
};

static const joint_kind *find_kind(sn_span name) {
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (sn_span_is(name, kinds[i].name)) return &kinds[i];
    return NULL;
}

bool sn_osim_is_joint(sn_span name) { return name.length > 5 && memcmp(name.text + name.length - 5, "Joint", 5) == 0; }

static sn_status add_steps(joint_reader *r, const joint_kind *kind) {
    sn_index count = r->o->out->coordinate_count - r->first;
    sn_status status = SN_OK;
    sn_skeleton_coordinate *made;
    if (count > kind->coordinate_count)
        return sn_xml_fail(r->o->tree, r->joint->element, r->o->error, "the joint has %d coordinates; a %s has %d", (int)count, kind->name,
                           kind->coordinate_count);
    for (; count < kind->coordinate_count && status == SN_OK; count++) status = make_coordinate(r, (sn_span){NULL, 0}, count, &made);
    for (int i = 0; i < kind->step_count && status == SN_OK; i++) {
        const step *s = &kind->steps[i];
        sn_move move = {.kind = s->turns ? SN_MOVE_TURN : SN_MOVE_SHIFT, .axis = AXES[s->axis], .coordinates = {r->first + s->number}};
        set_use(r, s->number, s->turns, true);
        status = sn_skeleton_add_move(&r->joint->moves, move, r->o->error);
    }
    return status;
}

/* ---- custom joints
 * ------------------------------------------------------------------------------------------------------------------------ */

static sn_status find_coordinate(const joint_reader *r, sn_index axis, sn_span name, sn_index *out) {
    const sn_skeleton *s = r->o->out;
    for (*out = 0; *out < s->coordinate_count - r->first; (*out)++)
        if (sn_span_is(name, s->coordinates[r->first + *out].name)) return SN_OK;
    return sn_xml_fail(r->o->tree, axis, r->o->error, "the joint has no coordinate \"%.*s\"", (int)(name.length < 60 ? name.length : 60),
                       name.text);
}

/* The axis' function; where it has none, the coordinate itself, or nothing. */
static sn_status read_axis_function(const joint_reader *r, sn_index axis, bool moves, sn_function **out) {
    static const double LINE[] = {1.0, 0.0}, NOTHING[] = {0.0};
    sn_index element = sn_osim_find_function(r->o->tree, axis, "function");
    if (element != SN_NONE) return sn_osim_read_function(r->o->tree, element, 1.0, out, r->o->error);
    return sn_function_create(SN_FUNCTION_POLYNOMIAL, (sn_function_numbers){moves ? 2 : 1, NULL, moves ? LINE : NOTHING}, 1.0, out,
                              r->o->error);
}

static sn_status add_fixed(const joint_reader *r, bool turns, sn_vec3 axis, double by) {
    sn_move move = {.kind = SN_MOVE_FIXED, .fixed = sn_rigid_identity()};
    if (by == 0.0) return SN_OK;
    if (turns)
        move.fixed.rotation = sn_quat_axis_angle(axis, by);
    else
        move.fixed.translation = sn_scale(axis, by);
    return sn_skeleton_add_move(&r->joint->moves, move, r->o->error);
}

static sn_status add_axis(joint_reader *r, sn_index element, bool turns, sn_vec3 axis) {
    sn_span names = sn_xml_child_text(r->o->tree, element, "coordinates"), name = sn_xml_word(&names);
    sn_index number = SN_NONE;
    sn_function *function = NULL;
    if (sn_xml_word(&names).length > 0)
        return sn_xml_fail(r->o->tree, element, r->o->error, "an axis that several coordinates move is not read; one may");
    sn_status status = name.length > 0 ? find_coordinate(r, element, name, &number) : SN_OK;
    if (status == SN_OK) status = read_axis_function(r, element, number != SN_NONE, &function);
    if (status != SN_OK) return status;
    if (sn_function_constant(function)) {
        status = add_fixed(r, turns, axis, sn_function_at(function, 0.0));
    } else if (number == SN_NONE) {
        status = sn_xml_fail(r->o->tree, element, r->o->error, "the axis has a function and names no coordinate");
    } else {
        set_use(r, number, turns, sn_function_identity(function));
        sn_move move = {turns ? SN_MOVE_TURN : SN_MOVE_SHIFT, false, sn_rigid_identity(), axis, {r->first + number}, function};
        return sn_skeleton_add_move(&r->joint->moves, move, r->o->error);
    }
    sn_function_free(function);
    return status;
}

/* One of the six axes, by its name, of which `default_axis` is the number where the file gives none. */
static sn_status read_axis(joint_reader *r, sn_index transform, const char *name, bool turns, int default_axis) {
    const sn_xml_tree *tree = r->o->tree;
    sn_index element = sn_xml_child(tree, transform, "TransformAxis");
    while (element != SN_NONE && !sn_span_is(sn_xml_attribute_text(tree, element, "name"), name))
        element = sn_xml_next(tree, element, "TransformAxis");
    if (element == SN_NONE) return SN_OK;
    sn_vec3 axis = AXES[default_axis];
    sn_status status = sn_osim_vec3(r->o, element, "axis", &axis);
    if (status != SN_OK) return status;
    axis = sn_normalize(axis);
    if (!(sn_norm2(axis) > 0.0)) return sn_xml_fail(tree, element, r->o->error, "the axis has no length");
    return add_axis(r, element, turns, axis);
}

/* Shifts are along the parent's axes, so they come first; turns one after the other, each about axes that those before it have turned. */
static sn_status add_spatial_transform(joint_reader *r) {
    static const char *const names[] = {"translation1", "translation2", "translation3", "rotation1", "rotation2", "rotation3"};
    sn_index transform = sn_xml_child(r->o->tree, r->joint->element, "SpatialTransform");
    sn_status status = SN_OK;
    for (int i = 0; i < 6 && status == SN_OK; i++) status = read_axis(r, transform, names[i], i >= 3, i % 3);
    return status;
}

/* ---- any joint
 * ------------------------------------------------------------------------------------------------------------------------------ */

static sn_status add_rigid(const joint_reader *r, sn_rigid fixed) {
    return sn_skeleton_add_move(&r->joint->moves, (sn_move){.kind = SN_MOVE_FIXED, .fixed = fixed}, r->o->error);
}

/* In version 3 the coordinates of a reversed joint tell how its parent moves in its child; in version 4 only its place in the tree changes.
 */
static sn_status reverse_if_asked(const joint_reader *r, sn_index first) {
    bool reverse = false;
    const sn_xml_tree *tree = r->o->tree;
    sn_index element = r->joint->element;
    if (sn_xml_child(tree, element, "parent_body") == SN_NONE) return SN_OK;
    sn_status status = sn_xml_bool(sn_xml_child_value(tree, element, "reverse"), &reverse, r->o->error);
    if (reverse) sn_skeleton_reverse_moves(&r->joint->moves, first, r->joint->moves.move_count);
    return status;
}

sn_status sn_osim_read_joint(sn_osim *o, sn_osim_joint *joint, sn_rigid parent_frame, sn_rigid child_frame) {
    joint_reader r = {.o = o, .joint = joint, .first = o->out->coordinate_count};
    sn_span name = sn_xml_name(o->tree, joint->element);
    const joint_kind *kind = find_kind(name);
    if (kind == NULL && !sn_span_is(name, "CustomJoint"))
        return sn_xml_fail(
            o->tree, joint->element, o->error,
            "a joint of the kind %.*s is not read; Pin, Slider, Weld, Ball, Free, Universal, Gimbal, Planar and CustomJoint are",
            (int)(name.length < 60 ? name.length : 60), name.text);
    sn_status status = add_rigid(&r, parent_frame);
    sn_index first = joint->moves.move_count;
    if (status == SN_OK) status = read_coordinates(&r);
    if (status == SN_OK) status = kind != NULL ? add_steps(&r, kind) : add_spatial_transform(&r);
    if (status == SN_OK) status = reverse_if_asked(&r, first);
    return status == SN_OK ? add_rigid(&r, sn_rigid_inverse(child_frame)) : status;
}

/* ---- couplers
 * ---------------------------------------------------------------------------------------------------------------------------------- */

static sn_status find_any_coordinate(const sn_osim *o, sn_index element, const char *member, sn_index *out) {
    sn_span names = sn_xml_child_text(o->tree, element, member), name = sn_xml_word(&names);
    name = sn_osim_last_part(&name);
    if (name.length == 0 || sn_xml_word(&names).length > 0)
        return sn_xml_fail(o->tree, element, o->error, "a coupler needs one coordinate in %s", member);
    for (*out = 0; *out < o->out->coordinate_count; (*out)++)
        if (sn_span_is(name, o->out->coordinates[*out].name)) return SN_OK;
    return sn_xml_fail(o->tree, element, o->error, "the model has no coordinate \"%.*s\"", (int)(name.length < 60 ? name.length : 60),
                       name.text);
}

static sn_status read_coupler(sn_osim *o, sn_index element) {
    const sn_xml_tree *tree = o->tree;
    bool enforced = true, disabled = false;
    double scale = 1.0;
    sn_skeleton_coupler coupler = {0};
    sn_index function = sn_osim_find_function(tree, element, "coupled_coordinates_function");
    sn_status status = sn_xml_bool(sn_xml_child_value(tree, element, "isEnforced"), &enforced, o->error);
    if (status == SN_OK) status = sn_xml_bool(sn_xml_child_value(tree, element, "isDisabled"), &disabled, o->error);
    if (status != SN_OK || !enforced || disabled) return status;
    if (function == SN_NONE) return sn_xml_fail(tree, element, o->error, "a coupler without a function");
    status = sn_xml_numbers(sn_xml_child_value(tree, element, "scale_factor"), 1, &scale, o->error);
    if (status == SN_OK) status = find_any_coordinate(o, element, "independent_coordinate_names", &coupler.independent);
    if (status == SN_OK) status = find_any_coordinate(o, element, "dependent_coordinate_name", &coupler.dependent);
    if (status == SN_OK) status = sn_osim_read_function(tree, function, scale, &coupler.function, o->error);
    if (status != SN_OK) return status;
    void *couplers = o->out->couplers;
    if (!sn_grow(&couplers, &o->coupler_capacity, (size_t)o->out->coupler_count + 1, sizeof coupler)) {
        sn_function_free(coupler.function);
        return sn_fail_memory(o->error, "a coupler");
    }
    o->out->couplers = couplers;
    o->out->couplers[o->out->coupler_count++] = coupler;
    return SN_OK;
}

sn_status sn_osim_read_couplers(sn_osim *o) {
    static const char kind[] = "CoordinateCouplerConstraint";
    sn_status status = SN_OK;
    for (sn_index i = sn_xml_find(o->tree, o->model, SN_NONE, kind); i != SN_NONE && status == SN_OK;
         i = sn_xml_find(o->tree, o->model, i, kind)) {
        if (o->out->coupler_count == SN_OSIM_MOST)
            return sn_xml_fail(o->tree, i, o->error, "there are more than %d couplers", SN_OSIM_MOST);
        status = read_coupler(o, i);
    }
    return status;
}
