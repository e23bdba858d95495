/*
 * mjcf.c -- MuJoCo's models: the tree of bodies with their joints and meshes.
 *
 * An attribute that an element does not have is its class's: its own class, else the childclass of the body that holds it, else the
 * nameless one of all; and what a class does not say, the class around it does.
 */
#include "sinew/model_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "xml_tree.h"

enum { MOST = 4096, MOST_CLASSES = 1024 };
static const double RADIANS_PER_DEGREE = SN_PI / 180.0;

/* An asset's mesh. */
typedef struct mesh_asset {
    sn_span name;
    sn_index element;
} mesh_asset;

typedef struct mjcf {
    const sn_xml_tree *tree;
    sn_error *error;
    sn_skeleton *out;
    bool degrees, auto_limits;
    char euler[4]; /* order of the angles: xyz turn with the frame, XYZ do not */
    sn_span mesh_folder;
    sn_index classes[MOST_CLASSES]; /* elements "default", the outermost first */
    sn_index class_count;
    mesh_asset *assets;
    size_t asset_count, asset_capacity, body_capacity, coordinate_capacity, mesh_capacity;
} mjcf;

/* Where in the tree of bodies an element is: in which body, turned and shifted by frames around it, of which childclass. */
typedef struct scope {
    sn_index body;
    sn_rigid frame;
    sn_span childclass;
} scope;

static sn_status too_many(const mjcf *m, sn_index element, const char *what) {
    return sn_xml_fail(m->tree, element, m->error, "there are more than %d %s", (int)MOST, what);
}

/* ---- classes ----------------------------------------------------------------------------------------------------------------------- */

static sn_status read_classes(mjcf *m) {
    static const char kind[] = "default";
    for (sn_index i = sn_xml_find(m->tree, 0, SN_NONE, kind); i != SN_NONE; i = sn_xml_find(m->tree, 0, i, kind)) {
        if (m->class_count == MOST_CLASSES)
            return sn_xml_fail(m->tree, i, m->error, "there are more than %d default classes", (int)MOST_CLASSES);
        m->classes[m->class_count++] = i;
    }
    return SN_OK;
}

static bool same_span(sn_span a, sn_span b) { return a.length == b.length && memcmp(a.text, b.text, a.length) == 0; }

/* The class of that name; an outermost one is also "main". */
static sn_index find_class(const mjcf *m, sn_span name) {
    for (sn_index i = 0; i < m->class_count; i++) {
        sn_span own = sn_xml_attribute_text(m->tree, m->classes[i], "class");
        bool outermost = m->tree->elements[m->classes[i]].parent == 0;
        if (own.text != NULL ? same_span(own, name) : outermost && sn_span_is(name, "main")) return m->classes[i];
    }
    return SN_NONE;
}

static sn_span of_classes(const mjcf *m, sn_index class_element, const char *kind, const char *attribute) {
    for (; class_element > 0; class_element = m->tree->elements[class_element].parent)
        for (sn_index i = sn_xml_child(m->tree, class_element, kind); i != SN_NONE; i = sn_xml_next(m->tree, i, kind)) {
            sn_span value = sn_xml_attribute_text(m->tree, i, attribute);
            if (value.text != NULL) return value;
        }
    return (sn_span){NULL, 0};
}

static sn_span look_up(const mjcf *m, sn_index element, sn_span childclass, const char *attribute) {
    sn_span value = sn_xml_attribute_text(m->tree, element, attribute), kind = sn_xml_name(m->tree, element);
    sn_span name = sn_xml_attribute_text(m->tree, element, "class");
    char kind_name[16] = "";
    if (value.text != NULL || kind.length >= sizeof kind_name) return value;
    memcpy(kind_name, kind.text, kind.length);
    if (name.text == NULL) name = childclass.text != NULL ? childclass : (sn_span){"main", 4};
    return of_classes(m, find_class(m, name), kind_name, attribute);
}

static sn_status check_class(const mjcf *m, sn_index element, const char *attribute) {
    sn_span name = sn_xml_attribute_text(m->tree, element, attribute);
    if (name.text == NULL || sn_span_is(name, "main") || find_class(m, name) != SN_NONE) return SN_OK;
    return sn_xml_fail(m->tree, element, m->error, "there is no default class \"%.*s\"", (int)(name.length < 60 ? name.length : 60),
                       name.text);
}

/* ---- places ---------------------------------------------------------------------------------------------------------------------------
 */

static double angle(const mjcf *m, double value) { return m->degrees ? value * RADIANS_PER_DEGREE : value; }

static sn_quat from_euler(const mjcf *m, const double *angles) {
    sn_quat q = sn_quat_identity();
    for (int i = 0; i < 3; i++) {
        char c = m->euler[i];
        int axis = (c | 32) - 'x';
        sn_quat next = sn_quat_axis_angle(sn_v3(axis == 0, axis == 1, axis == 2), angle(m, angles[i]));
        q = c >= 'x' ? sn_quat_multiply(q, next) : sn_quat_multiply(next, q);
    }
    return q;
}

/* The least turn of z onto the direction; upside down: about x. */
static sn_quat from_z(sn_vec3 z) {
    sn_quat q = {1.0 + z.z, -z.y, z.x, 0.0};
    return sn_quat_dot(q, q) > 1e-20 ? sn_quat_normalize(q) : (sn_quat){0, 1, 0, 0};
}

/* Turn z onto the z axis first, then about it. */
static sn_quat from_axes(sn_vec3 x, sn_vec3 y) {
    x = sn_normalize(x);
    y = sn_normalize(sn_sub(y, sn_scale(x, sn_dot(x, y))));
    sn_quat q = from_z(sn_cross(x, y));
    sn_vec3 now = sn_quat_rotate(sn_quat_conjugate(q), x);
    return sn_quat_multiply(q, sn_quat_axis_angle(sn_v3(0, 0, 1), sn_atan2(now.y, now.x)));
}

/* One of the ways to write an orientation: how many numbers it has. */
typedef struct way {
    const char *name;
    sn_index count;
} way;
static const way ways[] = {{"quat", 4}, {"axisangle", 4}, {"euler", 3}, {"xyaxes", 6}, {"zaxis", 3}};

static bool make_rotation(const mjcf *m, size_t which, const double *n, sn_quat *out) {
    sn_vec3 a = sn_normalize(sn_v3(n[0], n[1], n[2])), b = sn_v3(n[3], n[4], n[5]);
    bool good = which == 2 || sn_norm2(a) > 0.0;
    if (which == 0) {
        *out = sn_quat_normalize((sn_quat){n[0], n[1], n[2], n[3]});
        return n[0] != 0.0 || n[1] != 0.0 || n[2] != 0.0 || n[3] != 0.0;
    }
    if (which == 1) *out = sn_quat_axis_angle(a, angle(m, n[3]));
    if (which == 2) *out = from_euler(m, n);
    if (which == 3) {
        *out = from_axes(a, b);
        good = good && sn_norm2(sn_cross(a, sn_normalize(b))) > 1e-20;
    }
    if (which == 4) *out = from_z(a);
    return good;
}

static sn_status read_rotation(const mjcf *m, sn_index element, sn_span childclass, sn_quat *out) {
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        sn_span text = look_up(m, element, childclass, ways[i].name);
        double numbers[6] = {0};
        if (text.length == 0) continue;
        sn_status status = sn_xml_numbers((sn_xml_value){m->tree, element, ways[i].name, text}, ways[i].count, numbers, m->error);
        if (status == SN_OK && !make_rotation(m, i, numbers, out))
            return sn_xml_fail(m->tree, element, m->error, "%s: no orientation is given by a vector without length", ways[i].name);
        return status;
    }
    return SN_OK;
}

static sn_xml_value find_value(const mjcf *m, sn_index element, sn_span childclass, const char *name) {
    return (sn_xml_value){m->tree, element, name, look_up(m, element, childclass, name)};
}

static sn_status read_vec3(const mjcf *m, sn_index element, sn_span childclass, const char *name, sn_vec3 *out) {
    double xyz[3] = {out->x, out->y, out->z};
    sn_status status = sn_xml_numbers(find_value(m, element, childclass, name), 3, xyz, m->error);
    *out = sn_v3(xyz[0], xyz[1], xyz[2]);
    return status;
}

static sn_status read_place(const mjcf *m, sn_index element, sn_span childclass, sn_rigid *out) {
    *out = sn_rigid_identity();
    sn_status status = read_vec3(m, element, childclass, "pos", &out->translation);
    return status == SN_OK ? read_rotation(m, element, childclass, &out->rotation) : status;
}

/* ---- joints
 * ------------------------------------------------------------------------------------------------------------------------------ */

/* A coordinate called NAME and ending. */
static sn_status add_coordinate(mjcf *m, sn_index element, const char *ending, bool angular, sn_skeleton_coordinate **out) {
    sn_span name = sn_xml_attribute_text(m->tree, element, "name");
    char spare[32];
    if (name.length == 0) {
        snprintf(spare, sizeof spare, "joint_%d", (int)m->out->coordinate_count + 1);
        name = (sn_span){spare, strlen(spare)};
    }
    void *coordinates = m->out->coordinates;
    if (m->out->coordinate_count == 6 * MOST) return too_many(m, element, "joints");
    if (!sn_grow(&coordinates, &m->coordinate_capacity, (size_t)m->out->coordinate_count + 1, sizeof **out))
        return sn_fail_memory(m->error, "a joint");
    m->out->coordinates = coordinates;
    *out = &m->out->coordinates[m->out->coordinate_count++];
    **out = (sn_skeleton_coordinate){.angular = angular, .degrees = angular, .low = -INFINITY, .high = INFINITY};
    char *own = sn_xml_copy(name), *full = own != NULL ? sn_alloc(strlen(own) + strlen(ending) + 1, 1) : NULL;
    if (full != NULL) {
        memcpy(full, own, strlen(own));
        memcpy(full + strlen(own), ending, strlen(ending));
    }
    (*out)->joint = own;
    (*out)->name = full;
    return full != NULL ? SN_OK : sn_fail_memory(m->error, "a joint");
}

static sn_status add_fixed(const mjcf *m, sn_index body, sn_rigid fixed) {
    return sn_skeleton_add_move(&m->out->bodies[body], (sn_move){.kind = SN_MOVE_FIXED, .fixed = fixed}, m->error);
}

static sn_status add_shift(const mjcf *m, sn_index body, sn_vec3 by) { return add_fixed(m, body, (sn_rigid){sn_quat_identity(), by}); }

/* Three coordinates: a rotation vector. */
static sn_status add_spin(mjcf *m, sn_index element, sn_index body) {
    static const char *const endings[] = {"_rx", "_ry", "_rz"};
    sn_index first = m->out->coordinate_count;
    sn_skeleton_coordinate *c;
    sn_status status = SN_OK;
    for (int i = 0; i < 3 && status == SN_OK; i++) status = add_coordinate(m, element, endings[i], true, &c);
    sn_move move = {.kind = SN_MOVE_SPIN, .coordinates = {first, first + 1, first + 2}};
    return status == SN_OK ? sn_skeleton_add_move(&m->out->bodies[body], move, m->error) : status;
}

/* MuJoCo's free joint replaces the body's place; ours moves it away from there, in the world's axes. */
static sn_status add_free(mjcf *m, sn_index element, sn_index body) {
    static const char *const endings[] = {"_tx", "_ty", "_tz"};
    sn_skeleton_body *b = &m->out->bodies[body];
    sn_rigid rest = b->moves[0].fixed;
    sn_status status = SN_OK;
    if (b->parent != SN_NONE || b->move_count != 1)
        return sn_xml_fail(m->tree, element, m->error, "a free joint beside others, or in a body that is in another one");
    b->moves[0].fixed.rotation = sn_quat_identity();
    for (int i = 0; i < 3 && status == SN_OK; i++) {
        sn_skeleton_coordinate *c;
        sn_move move = {.kind = SN_MOVE_SHIFT, .axis = sn_v3(i == 0, i == 1, i == 2), .coordinates = {m->out->coordinate_count}};
        status = add_coordinate(m, element, endings[i], false, &c);
        if (status == SN_OK) status = sn_skeleton_add_move(b, move, m->error);
    }
    if (status == SN_OK) status = add_spin(m, element, body);
    return status == SN_OK ? add_fixed(m, body, (sn_rigid){rest.rotation, {0, 0, 0}}) : status;
}

/* limited="auto", the default, is what a range makes it. A range does not clamp: it is a limit that forces keep. */
static sn_status read_range(const mjcf *m, sn_index element, sn_span childclass, sn_skeleton_coordinate *c) {
    sn_span limited = look_up(m, element, childclass, "limited"), range = look_up(m, element, childclass, "range");
    double ends[2] = {0, 0};
    if (range.length == 0 || sn_span_is(limited, "false") || (limited.text == NULL && !m->auto_limits)) return SN_OK;
    sn_status status = sn_xml_numbers((sn_xml_value){m->tree, element, "range", range}, 2, ends, m->error);
    if (status != SN_OK) return status;
    if (ends[0] > ends[1]) return sn_xml_fail(m->tree, element, m->error, "the range is upside down");
    c->low = c->angular ? angle(m, ends[0]) : ends[0];
    c->high = c->angular ? angle(m, ends[1]) : ends[1];
    return SN_OK;
}

/* A hinge or a slide: by the coordinate less its reference. */
static sn_status add_axis(mjcf *m, sn_index element, sn_index body, const scope *s, bool turns) {
    sn_vec3 axis = {0, 0, 1};
    double reference = 0.0;
    sn_skeleton_coordinate *c = NULL;
    sn_move move = {.kind = turns ? SN_MOVE_TURN : SN_MOVE_SHIFT, .coordinates = {m->out->coordinate_count}};
    sn_status status = add_coordinate(m, element, "", turns, &c);
    if (status == SN_OK) status = read_vec3(m, element, s->childclass, "axis", &axis);
    if (status == SN_OK) status = sn_xml_numbers(find_value(m, element, s->childclass, "ref"), 1, &reference, m->error);
    if (status == SN_OK && c != NULL) status = read_range(m, element, s->childclass, c);
    if (status != SN_OK || c == NULL) return status;
    move.axis = sn_normalize(sn_quat_rotate(s->frame.rotation, axis));
    if (!(sn_norm2(move.axis) > 0.0)) return sn_xml_fail(m->tree, element, m->error, "the axis has no length");
    c->rest = turns ? angle(m, reference) : reference;
    const double line[] = {1.0, -c->rest};
    if (c->rest != 0.0)
        status = sn_function_create(SN_FUNCTION_POLYNOMIAL, (sn_function_numbers){2, NULL, line}, 1.0, &move.function, m->error);
    return status == SN_OK ? sn_skeleton_add_move(&m->out->bodies[body], move, m->error) : status;
}

static sn_status read_joint(mjcf *m, sn_index element, const scope *s) {
    sn_span type = look_up(m, element, s->childclass, "type");
    sn_vec3 centre = {0, 0, 0};
    bool hinge = type.text == NULL || sn_span_is(type, "hinge"), ball = sn_span_is_like(type, "ball");
    sn_skeleton_body *body = &m->out->bodies[s->body];
    sn_status status = check_class(m, element, "class");
    if (status != SN_OK) return status;
    if (sn_xml_is(m->tree, element, "freejoint") || sn_span_is(type, "free")) return add_free(m, element, s->body);
    if (sn_span_is(type, "slide")) return add_axis(m, element, s->body, s, false);
    if (!hinge && !ball) return sn_xml_fail(m->tree, element, m->error, "a joint of another type than hinge, slide, ball and free");
    status = read_vec3(m, element, s->childclass, "pos", &centre);
    centre = sn_rigid_apply(s->frame, centre);
    if (body->move_count == 1) body->centre = centre; /* of its first joint */
    if (status == SN_OK) status = add_shift(m, s->body, centre);
    if (status == SN_OK) status = ball ? add_spin(m, element, s->body) : add_axis(m, element, s->body, s, true);
    return status == SN_OK ? add_shift(m, s->body, sn_neg(centre)) : status;
}

/* ---- meshes
 * --------------------------------------------------------------------------------------------------------------------------------- */

static sn_status read_assets(mjcf *m) {
    for (sn_index list = sn_xml_child(m->tree, 0, "asset"); list != SN_NONE; list = sn_xml_next(m->tree, list, "asset"))
        for (sn_index i = sn_xml_child(m->tree, list, "mesh"); i != SN_NONE; i = sn_xml_next(m->tree, i, "mesh")) {
            sn_span name = sn_xml_attribute_text(m->tree, i, "name"), file = sn_xml_attribute_text(m->tree, i, "file");
            void *assets = m->assets;
            if (m->asset_count == MOST) return too_many(m, i, "meshes");
            if (!sn_grow(&assets, &m->asset_capacity, m->asset_count + 1, sizeof *m->assets)) return sn_fail_memory(m->error, "a mesh");
            m->assets = assets;
            if (name.text == NULL) { /* the file's name without its folder and ending */
                for (size_t k = file.length; k > 0 && name.text == NULL; k--)
                    if (file.text[k - 1] == '/') name = (sn_span){file.text + k, file.length - k};
                if (name.text == NULL) name = file;
                const char *dot = name.length > 0 ? memrchr(name.text, '.', name.length) : NULL;
                if (dot != NULL) name.length = (size_t)(dot - name.text);
            }
            m->assets[m->asset_count++] = (mesh_asset){name, i};
        }
    return SN_OK;
}

static char *path_in(sn_span folder, sn_span file) {
    char *name = sn_xml_copy(file), *start = folder.length > 0 && *name != '/' ? sn_xml_copy(folder) : NULL;
    size_t a = start != NULL ? strlen(start) : 0, b = name != NULL ? strlen(name) : 0;
    char *path = name != NULL ? sn_alloc(a + b + 2, 1) : NULL;
    if (path != NULL) {
        if (a > 0) memcpy(path, start, a);
        if (a > 0 && path[a - 1] != '/') path[a++] = '/';
        memcpy(path + a, name, b);
    }
    free(start);
    free(name);
    return path;
}

/* MuJoCo first takes the mesh out of its own reference frame (refpos, refquat), then scales it. */
static sn_status apply_reference(const mjcf *m, sn_index asset, sn_skeleton_mesh *mesh) {
    double q[4] = {1, 0, 0, 0};
    sn_vec3 s = mesh->scale, place = {0, 0, 0};
    sn_status status = read_vec3(m, asset, (sn_span){NULL, 0}, "refpos", &place);
    if (status == SN_OK) status = sn_xml_numbers(find_value(m, asset, (sn_span){NULL, 0}, "refquat"), 4, q, m->error);
    if (status != SN_OK) return status;
    sn_quat turned = {q[0], q[1], q[2], q[3]};
    if (!(sn_quat_dot(turned, turned) > 0.0)) return sn_xml_fail(m->tree, asset, m->error, "refquat has no length");
    turned = sn_quat_conjugate(sn_quat_normalize(turned));
    if ((q[1] != 0.0 || q[2] != 0.0 || q[3] != 0.0) && (s.x != s.y || s.x != s.z))
        return sn_xml_fail(m->tree, asset, m->error, "a mesh with refquat that is scaled unevenly is not read; turn its file");
    place = sn_quat_rotate(turned, place);
    sn_rigid reference = {turned, sn_v3(-s.x * place.x, -s.y * place.y, -s.z * place.z)};
    mesh->frame = sn_rigid_compose(mesh->frame, reference);
    return SN_OK;
}

static sn_status read_geom(mjcf *m, sn_index element, const scope *s) {
    sn_span mesh_name = look_up(m, element, s->childclass, "mesh"), name = sn_xml_attribute_text(m->tree, element, "name");
    sn_span type = look_up(m, element, s->childclass, "type");
    sn_skeleton_mesh mesh = {.body = s->body, .scale = {1, 1, 1}};
    size_t which = 0;
    sn_status status = check_class(m, element, "class");
    if (mesh_name.length == 0 || status != SN_OK) return status;
    while (which < m->asset_count && !same_span(m->assets[which].name, mesh_name)) which++;
    if (which == m->asset_count)
        return sn_xml_fail(m->tree, element, m->error, "there is no mesh \"%.*s\" among the assets",
                           (int)(mesh_name.length < 100 ? mesh_name.length : 100), mesh_name.text);
    if (m->out->mesh_count == 4 * MOST) return too_many(m, element, "meshes on each body");
    sn_index asset = m->assets[which].element;
    sn_span file = sn_xml_attribute_text(m->tree, asset, "file");
    /* made of numbers in the model, or by a rule; of another type: a primitive that MuJoCo fits to the mesh */
    if (file.length == 0 || !sn_span_is(type, "mesh")) return SN_OK;
    status = read_vec3(m, asset, (sn_span){NULL, 0}, "scale", &mesh.scale);
    if (status == SN_OK) status = read_place(m, element, s->childclass, &mesh.frame);
    mesh.frame = sn_rigid_compose(s->frame, mesh.frame);
    if (status == SN_OK) status = apply_reference(m, asset, &mesh);
    void *meshes = m->out->meshes;
    if (status != SN_OK) return status;
    if (!sn_grow(&meshes, &m->mesh_capacity, (size_t)m->out->mesh_count + 1, sizeof mesh)) return sn_fail_memory(m->error, "a mesh");
    m->out->meshes = meshes;
    mesh.name = sn_xml_copy(name.length > 0 ? name : mesh_name);
    mesh.file = path_in(m->mesh_folder, file);
    m->out->meshes[m->out->mesh_count++] = mesh;
    return mesh.name != NULL && mesh.file != NULL ? SN_OK : sn_fail_memory(m->error, "a mesh");
}

/* ---- bodies
 * ----------------------------------------------------------------------------------------------------------------------------------- */

static sn_status read_body(mjcf *m, sn_index element, scope outer);

/* Children of a body, of a frame in it, or of the world: joints first, wherever they stand. */
static sn_status read_children(mjcf *m, sn_index element, scope s, bool joints) {
    const sn_xml_tree *tree = m->tree;
    sn_status status = SN_OK;
    for (sn_index i = sn_xml_child(tree, element, NULL); i != SN_NONE && status == SN_OK; i = sn_xml_next(tree, i, NULL)) {
        bool joint = sn_xml_is(tree, i, "joint") || sn_xml_is(tree, i, "freejoint");
        if (joint && s.body == SN_NONE) status = sn_xml_fail(tree, i, m->error, "a joint that is in no body");
        if (joint && joints && status == SN_OK) status = read_joint(m, i, &s);
        if (!joints && sn_xml_is(tree, i, "geom")) status = read_geom(m, i, &s);
        if (!joints && sn_xml_is(tree, i, "body")) status = read_body(m, i, s);
        if (sn_xml_is(tree, i, "replicate")) return sn_xml_fail(tree, i, m->error, "replicate is not read; write the bodies out");
        if (sn_xml_is(tree, i, "frame")) {
            scope inner = s;
            sn_rigid place;
            sn_span childclass = sn_xml_attribute_text(tree, i, "childclass");
            status = read_place(m, i, (sn_span){"", 0}, &place);
            inner.frame = sn_rigid_compose(s.frame, place);
            if (childclass.text != NULL) inner.childclass = childclass;
            if (status == SN_OK) status = check_class(m, i, "childclass");
            if (status == SN_OK) status = read_children(m, i, inner, joints);
        }
    }
    return status;
}

static sn_status new_body(mjcf *m, sn_index element, sn_index parent) {
    void *bodies = m->out->bodies;
    sn_span name = sn_xml_attribute_text(m->tree, element, "name");
    char spare[32];
    if (m->out->body_count == MOST) return too_many(m, element, "bodies");
    if (!sn_grow(&bodies, &m->body_capacity, (size_t)m->out->body_count + 1, sizeof *m->out->bodies))
        return sn_fail_memory(m->error, "a body");
    m->out->bodies = bodies;
    snprintf(spare, sizeof spare, "body_%d", (int)m->out->body_count + 1);
    sn_skeleton_body *body = &m->out->bodies[m->out->body_count++];
    *body = (sn_skeleton_body){.name = name.length > 0 ? sn_xml_copy(name) : sn_strdup(spare), .parent = parent};
    return body->name != NULL ? SN_OK : sn_fail_memory(m->error, "a body");
}

static sn_status read_body(mjcf *m, sn_index element, scope outer) {
    sn_rigid place;
    sn_span childclass = sn_xml_attribute_text(m->tree, element, "childclass");
    scope s = {m->out->body_count, sn_rigid_identity(), childclass.text != NULL ? childclass : outer.childclass};
    sn_status status = new_body(m, element, outer.body);
    if (status == SN_OK) status = check_class(m, element, "childclass");
    if (status == SN_OK) status = read_place(m, element, (sn_span){"", 0}, &place);
    if (status == SN_OK) status = add_fixed(m, s.body, sn_rigid_compose(outer.frame, place));
    if (status == SN_OK) status = read_children(m, element, s, true);
    return status == SN_OK ? read_children(m, element, s, false) : status;
}

/* ---- all
 * ------------------------------------------------------------------------------------------------------------------------------------------
 */

static sn_status read_compiler(mjcf *m, sn_index element) {
    const sn_xml_tree *tree = m->tree;
    sn_span unit = sn_xml_attribute_text(tree, element, "angle"), order = sn_xml_attribute_text(tree, element, "eulerseq"),
            folder = sn_xml_attribute_text(tree, element, "meshdir"), assets = sn_xml_attribute_text(tree, element, "assetdir");
    if (sn_span_is(sn_xml_attribute_text(tree, element, "coordinate"), "global"))
        return sn_xml_fail(tree, element, m->error, "coordinate=\"global\" is not read; MuJoCo itself has dropped it");
    if (unit.text != NULL) {
        m->degrees = sn_span_is(unit, "degree");
        if (!m->degrees && !sn_span_is(unit, "radian")) return sn_xml_fail(tree, element, m->error, "angle is neither degree nor radian");
    }
    if (order.text != NULL) {
        bool good = order.length == 3;
        for (size_t i = 0; i < 3 && good; i++) good = memchr("xyzXYZ", order.text[i], 6) != NULL;
        if (!good) return sn_xml_fail(tree, element, m->error, "eulerseq is no three of x, y, z, X, Y, Z");
        memcpy(m->euler, order.text, 3);
    }
    if (folder.text == NULL) folder = assets;
    if (folder.text != NULL) m->mesh_folder = folder;
    return sn_xml_bool(sn_xml_attribute_value(tree, element, "autolimits"), &m->auto_limits, m->error);
}

static sn_status read_model(mjcf *m) {
    const sn_xml_tree *tree = m->tree;
    sn_span name = sn_xml_attribute_text(tree, 0, "model");
    sn_index world = sn_xml_child(tree, 0, "worldbody");
    scope outside = {SN_NONE, sn_rigid_identity(), {NULL, 0}};
    sn_status status = SN_OK;
    if (!sn_xml_is(tree, 0, "mujoco")) return sn_xml_fail(tree, 0, m->error, "not a model of MuJoCo: its root is not mujoco");
    if (name.length > 0 && (m->out->name = sn_xml_copy(name)) == NULL) return sn_fail_memory(m->error, "a model");
    if (sn_xml_find(tree, 0, SN_NONE, "include") != SN_NONE)
        sn_log(SN_LOG_WARNING, "%s: files that the model includes are not read", tree->blob->name);
    for (sn_index i = sn_xml_child(tree, 0, "compiler"); i != SN_NONE && status == SN_OK; i = sn_xml_next(tree, i, "compiler"))
        status = read_compiler(m, i);
    if (status == SN_OK) status = read_classes(m);
    if (status == SN_OK) status = read_assets(m);
    for (; world != SN_NONE && status == SN_OK; world = sn_xml_next(tree, world, "worldbody"))
        status = read_children(m, world, outside, false);
    return status == SN_OK ? sn_skeleton_finish(m->out, m->error) : status;
}

bool sn_mjcf_detect(const sn_blob *blob) {
    size_t reach = blob->size < 4096 ? blob->size : 4096;
    return memmem(blob->data, reach, "<mujoco", 7) != NULL;
}

sn_status sn_mjcf_parse(const sn_blob *blob, sn_skeleton *out, sn_error *error) {
    sn_xml_tree tree;
    *out = (sn_skeleton){0};
    sn_status status = sn_xml_tree_parse(blob, &tree, error);
    mjcf m = {.tree = &tree, .error = error, .out = out, .degrees = true, .auto_limits = true, .euler = "xyz"};
    if (status == SN_OK) status = read_model(&m);
    free(m.assets);
    sn_xml_tree_free(&tree);
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_skeleton_free(out);
    return status;
}
