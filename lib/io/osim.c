/* osim.c -- OpenSim's models: bodies, frames, joints between them, meshes; the tree that they make. */
#include "osim.h"

#include <stdlib.h>
#include <string.h>

/* Frames fixed to frames. */
enum { DEEPEST_FRAME = 32 };

/* ---- places
 * ------------------------------------------------------------------------------------------------------------------------------ */

sn_status sn_osim_vec3(const sn_osim *o, sn_index element, const char *name, sn_vec3 *out) {
    double xyz[3] = {out->x, out->y, out->z};
    sn_index child = sn_xml_child(o->tree, element, name);
    const sn_xml_value value = {o->tree, child != SN_NONE ? child : element, name, sn_xml_text(o->tree, child)};
    sn_status status = sn_xml_numbers(value, 3, xyz, o->error);
    *out = sn_v3(xyz[0], xyz[1], xyz[2]);
    return status;
}

sn_quat sn_osim_rotation(sn_vec3 angles) {
    sn_quat x = sn_quat_axis_angle(sn_v3(1, 0, 0), angles.x), y = sn_quat_axis_angle(sn_v3(0, 1, 0), angles.y),
            z = sn_quat_axis_angle(sn_v3(0, 0, 1), angles.z);
    return sn_quat_multiply(sn_quat_multiply(x, y), z);
}

/* A place from two children: where it is, and its three angles. */
static sn_status read_place(const sn_osim *o, sn_index element, const char *where, const char *turned, sn_rigid *out) {
    sn_vec3 angles = {0, 0, 0};
    *out = sn_rigid_identity();
    sn_status status = sn_osim_vec3(o, element, where, &out->translation);
    if (status == SN_OK) status = sn_osim_vec3(o, element, turned, &angles);
    out->rotation = sn_osim_rotation(angles);
    return status;
}

static bool same_span(sn_span a, sn_span b) {
    return a.text != NULL && b.text != NULL && a.length == b.length && memcmp(a.text, b.text, a.length) == 0;
}

sn_index sn_osim_find_body(const sn_osim *o, sn_span name, bool *is_ground) {
    *is_ground = sn_span_is(name, "ground");
    for (sn_index i = 0; i < o->out->body_count; i++)
        if (same_span(name, sn_xml_attribute_text(o->tree, o->bodies[i], "name"))) return i;
    return SN_NONE;
}

sn_span sn_osim_last_part(sn_span *path) {
    while (path->length > 0 && path->text[path->length - 1] == '/') path->length--;
    size_t start = path->length;
    while (start > 0 && path->text[start - 1] != '/') start--;
    sn_span last = {path->text + start, path->length - start};
    path->length = start > 0 ? start - 1 : 0;
    return last;
}

/* The frame of this name: of the owner that the path names, else of the element that asks, else any. */
static const sn_osim_frame *find_frame(const sn_osim *o, sn_index from, sn_span name, sn_span owner, bool any) {
    const sn_osim_frame *own = NULL, *other = NULL;
    for (size_t i = 0; i < o->frame_count; i++) {
        const sn_osim_frame *f = &o->frames[i];
        if (!same_span(f->name, name)) continue;
        if (owner.length > 0 && same_span(f->owner, owner)) return f;
        if (own == NULL && f->owner_element == from) own = f;
        if (other == NULL) other = f;
    }
    return own != NULL || !any ? own : other;
}

/* What a place is fixed to: another element's name, or the element that it is a part of. */
typedef struct anchor {
    sn_index from, element; /* element: of a body, the ground or a frame; SN_NONE = not found yet */
    sn_span socket;
} anchor;

static sn_index part_of(const sn_osim *o, sn_index element) {
    sn_index list = o->tree->elements[element].parent;
    return list == SN_NONE ? SN_NONE : o->tree->elements[list].parent;
}

/* To the element that the socket names; *body where that is one. */
static sn_status follow_socket(const sn_osim *o, anchor *a, sn_index *body, bool *is_ground) {
    sn_span path = a->socket, last = sn_osim_last_part(&path), owner = sn_osim_last_part(&path);
    *body = SN_NONE;
    *is_ground = false;
    a->element = SN_NONE;
    if (sn_span_is(last, "..")) {
        a->element = part_of(o, a->from);
        for (sn_index i = 0; i < o->out->body_count; i++)
            if (o->bodies[i] == a->element) *body = i;
        *is_ground = sn_xml_is(o->tree, a->element, "Ground");
        if (*body != SN_NONE || *is_ground || sn_xml_is(o->tree, a->element, "PhysicalOffsetFrame")) return SN_OK;
    }
    const sn_osim_frame *frame = find_frame(o, a->from, last, owner, false);
    if (frame == NULL && ((*body = sn_osim_find_body(o, last, is_ground)) != SN_NONE || *is_ground)) return SN_OK;
    if (frame == NULL) frame = find_frame(o, a->from, last, owner, true);
    a->element = frame != NULL ? frame->element : SN_NONE;
    if (frame != NULL) return SN_OK;
    return sn_xml_fail(o->tree, a->from, o->error, "there is no body or frame \"%.*s\"",
                       (int)(a->socket.length < 100 ? a->socket.length : 100), a->socket.text != NULL ? a->socket.text : "");
}

sn_status sn_osim_resolve(const sn_osim *o, sn_index from, sn_span socket, sn_osim_place *out) {
    anchor a = {from, SN_NONE, socket};
    bool is_ground = false;
    *out = (sn_osim_place){SN_NONE, sn_rigid_identity()};
    for (int depth = 0; depth < DEEPEST_FRAME; depth++) {
        sn_status status = follow_socket(o, &a, &out->body, &is_ground);
        if (status != SN_OK || out->body != SN_NONE || is_ground) return status;
        const sn_osim_frame *frame = o->frames;
        while (frame->element != a.element) frame++;
        out->local = sn_rigid_compose(frame->local, out->local);
        a = (anchor){a.element, SN_NONE, sn_xml_child_text(o->tree, a.element, "socket_parent")};
        if (a.socket.length == 0) a.socket = sn_xml_child_text(o->tree, a.from, "socket_parent_connectee_name");
        if (a.socket.length == 0) a.socket = (sn_span){"..", 2};
    }
    return sn_xml_fail(o->tree, from, o->error, "frames are fixed to frames without an end");
}

/* ---- bodies and frames
 * ----------------------------------------------------------------------------------------------------------------------- */

static sn_status too_many(const sn_osim *o, sn_index element, const char *what) {
    return sn_xml_fail(o->tree, element, o->error, "there are more than %d %s", (int)SN_OSIM_MOST, what);
}

static sn_status add_body(sn_osim *o, sn_index element) {
    sn_span name = sn_xml_attribute_text(o->tree, element, "name");
    if (name.length == 0) return sn_xml_fail(o->tree, element, o->error, "a body without a name");
    if (sn_span_is(name, "ground")) return SN_OK;
    if (o->out->body_count == SN_OSIM_MOST) return too_many(o, element, "bodies");
    size_t index = (size_t)o->out->body_count, capacity = o->body_capacity;
    void *bodies = o->out->bodies, *elements = o->bodies;
    bool enough = sn_grow(&bodies, &capacity, index + 1, sizeof *o->out->bodies);
    o->out->bodies = bodies;
    enough = enough && sn_grow(&elements, &o->body_capacity, index + 1, sizeof *o->bodies);
    o->bodies = elements;
    if (!enough) return sn_fail_memory(o->error, "a body");
    o->bodies[index] = element;
    o->out->bodies[index] = (sn_skeleton_body){.name = sn_xml_copy(name), .parent = SN_NONE};
    o->out->body_count++;
    return o->out->bodies[index].name != NULL ? SN_OK : sn_fail_memory(o->error, "a body");
}

static sn_status read_bodies(sn_osim *o) {
    sn_index list = sn_xml_child(o->tree, sn_xml_child(o->tree, o->model, "BodySet"), "objects");
    sn_status status = SN_OK;
    for (sn_index i = sn_xml_child(o->tree, list, "Body"); i != SN_NONE && status == SN_OK; i = sn_xml_next(o->tree, i, "Body"))
        status = add_body(o, i);
    if (status == SN_OK && o->out->body_count == 0) return sn_xml_fail(o->tree, o->model, o->error, "the model has no body");
    return status;
}

static sn_status read_frames(sn_osim *o) {
    static const char kind[] = "PhysicalOffsetFrame";
    for (sn_index i = sn_xml_find(o->tree, o->model, SN_NONE, kind); i != SN_NONE; i = sn_xml_find(o->tree, o->model, i, kind)) {
        void *frames = o->frames;
        if (o->frame_count == 4 * SN_OSIM_MOST) return too_many(o, i, "frames on each body");
        if (!sn_grow(&frames, &o->frame_capacity, o->frame_count + 1, sizeof *o->frames)) return sn_fail_memory(o->error, "a frame");
        o->frames = frames;
        sn_osim_frame *f = &o->frames[o->frame_count++];
        *f = (sn_osim_frame){.name = sn_xml_attribute_text(o->tree, i, "name"), .element = i, .owner_element = part_of(o, i)};
        f->owner = sn_xml_attribute_text(o->tree, f->owner_element, "name");
        sn_status status = read_place(o, i, "translation", "orientation", &f->local);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

/* ---- joints
 * -------------------------------------------------------------------------------------------------------------------------------------- */

static sn_status new_joint(sn_osim *o, sn_index element, sn_osim_joint **out) {
    void *joints = o->joints;
    if (o->joint_count == SN_OSIM_MOST) return too_many(o, element, "joints");
    if (!sn_grow(&joints, &o->joint_capacity, o->joint_count + 1, sizeof **out)) return sn_fail_memory(o->error, "a joint");
    o->joints = joints;
    *out = &o->joints[o->joint_count++];
    **out = (sn_osim_joint){.element = element};
    return SN_OK;
}

/* Version 3: the joint is a part of its child, and tells where it is on both. */
static sn_status read_joint_3(sn_osim *o, sn_index element, sn_index child) {
    sn_osim_joint *joint = NULL;
    sn_rigid parent_frame, child_frame;
    sn_span name = sn_xml_child_text(o->tree, element, "parent_body");
    bool is_ground = false;
    sn_status status = new_joint(o, element, &joint);
    if (status == SN_OK) status = read_place(o, element, "location_in_parent", "orientation_in_parent", &parent_frame);
    if (status == SN_OK) status = read_place(o, element, "location", "orientation", &child_frame);
    if (status != SN_OK || joint == NULL) return status;
    joint->child = child;
    joint->parent = sn_osim_find_body(o, name, &is_ground);
    if (joint->parent == SN_NONE && !is_ground)
        return sn_xml_fail(o->tree, element, o->error, "there is no body \"%.*s\" for the joint's parent",
                           (int)(name.length < 100 ? name.length : 100), name.text != NULL ? name.text : "");
    return sn_osim_read_joint(o, joint, parent_frame, child_frame);
}

/* Version 4: the joint names two frames. */
static sn_status read_joint_4(sn_osim *o, sn_index element) {
    sn_osim_joint *joint = NULL;
    sn_osim_place parent, child;
    sn_span parent_name = sn_xml_child_text(o->tree, element, "socket_parent_frame"),
            child_name = sn_xml_child_text(o->tree, element, "socket_child_frame");
    if (parent_name.length == 0) parent_name = sn_xml_child_text(o->tree, element, "socket_parent_frame_connectee_name");
    if (child_name.length == 0) child_name = sn_xml_child_text(o->tree, element, "socket_child_frame_connectee_name");
    if (parent_name.length == 0 || child_name.length == 0)
        return sn_xml_fail(o->tree, element, o->error, "the joint names no parent frame or no child frame");
    sn_status status = new_joint(o, element, &joint);
    if (status == SN_OK) status = sn_osim_resolve(o, element, parent_name, &parent);
    if (status == SN_OK) status = sn_osim_resolve(o, element, child_name, &child);
    if (status != SN_OK || joint == NULL) return status;
    joint->parent = parent.body;
    joint->child = child.body;
    return sn_osim_read_joint(o, joint, parent.local, child.local);
}

static sn_status read_joints(sn_osim *o) {
    const sn_xml_tree *tree = o->tree;
    sn_index list = sn_xml_child(tree, sn_xml_child(tree, o->model, "JointSet"), "objects");
    sn_status status = SN_OK;
    for (sn_index i = sn_xml_child(tree, list, NULL); i != SN_NONE && status == SN_OK; i = sn_xml_next(tree, i, NULL))
        if (sn_osim_is_joint(sn_xml_name(tree, i))) status = read_joint_4(o, i);
    for (sn_index body = 0; body < o->out->body_count && status == SN_OK; body++) {
        sn_index joint = sn_xml_child(tree, sn_xml_child(tree, o->bodies[body], "Joint"), NULL);
        if (joint != SN_NONE) status = read_joint_3(o, joint, body);
    }
    return status;
}

/* ---- the tree
 * -------------------------------------------------------------------------------------------------------------------------------------- */

typedef struct placing {
    sn_osim *o;
    sn_index *rank; /* (body_count) place of a body in the order of the tree; SN_NONE = not placed yet */
    sn_skeleton_body *ordered;
    sn_index placed;
} placing;

static bool is_placed(const placing *p, sn_index body) { return body == SN_NONE || p->rank[body] != SN_NONE; }

static void place(placing *p, sn_index body, sn_index parent, sn_osim_joint *joint) {
    sn_skeleton_body *b = &p->o->out->bodies[body], *to = &p->ordered[p->placed];
    *to = (sn_skeleton_body){.name = b->name, .parent = parent == SN_NONE ? SN_NONE : p->rank[parent]};
    b->name = NULL;
    if (joint != NULL) {
        to->moves = joint->moves.moves;
        to->move_count = joint->moves.move_count;
        joint->moves = (sn_skeleton_body){0};
        joint->used = true;
    }
    p->rank[body] = p->placed++;
}

/* Place what hangs on what is placed; a joint may be gone through from either end. */
static void place_reachable(placing *p) {
    for (sn_index before = -1; before < p->placed;) {
        before = p->placed;
        for (size_t i = 0; i < p->o->joint_count; i++) {
            sn_osim_joint *joint = &p->o->joints[i];
            bool parent = is_placed(p, joint->parent), child = is_placed(p, joint->child);
            if (joint->used || parent == child) continue;
            if (child) sn_skeleton_reverse_moves(&joint->moves, 0, joint->moves.move_count);
            place(p, child ? joint->parent : joint->child, child ? joint->child : joint->parent, joint);
        }
    }
}

static sn_status place_all(placing *p) {
    sn_osim *o = p->o;
    place_reachable(p);
    for (sn_index body = 0; body < o->out->body_count; body++) {
        if (is_placed(p, body)) continue;
        sn_log(SN_LOG_WARNING, "%s: body \"%s\" is on no joint that leads to the ground; it stays at the ground's origin",
               o->tree->blob->name, o->out->bodies[body].name);
        place(p, body, SN_NONE, NULL);
        place_reachable(p);
    }
    for (size_t i = 0; i < o->joint_count; i++)
        if (!o->joints[i].used)
            return sn_xml_fail(o->tree, o->joints[i].element, o->error,
                               "the joint closes a loop of bodies, which coordinates alone cannot move; take one joint of the loop out");
    return SN_OK;
}

static sn_status order_bodies(sn_osim *o) {
    sn_index count = o->out->body_count;
    placing p = {.o = o, .rank = SN_NEW(sn_index, count), .ordered = SN_NEW(sn_skeleton_body, count)};
    sn_status status = p.rank != NULL && p.ordered != NULL ? SN_OK : sn_fail_memory(o->error, "bodies");
    for (sn_index i = 0; i < count && status == SN_OK; i++) p.rank[i] = SN_NONE;
    if (status == SN_OK) status = place_all(&p);
    if (p.placed == count) { /* names and moves have all gone over */
        free(o->out->bodies);
        o->out->bodies = p.ordered;
        for (sn_index i = 0; i < o->out->mesh_count; i++)
            if (o->out->meshes[i].body != SN_NONE) o->out->meshes[i].body = p.rank[o->out->meshes[i].body];
    } else {
        free(p.ordered);
    }
    free(p.rank);
    return status;
}

/* ---- meshes
 * --------------------------------------------------------------------------------------------------------------------------------------------
 */

static sn_status add_mesh(sn_osim *o, sn_index element, sn_span file, sn_skeleton_mesh mesh) {
    void *meshes = o->out->meshes;
    sn_span name = sn_xml_attribute_text(o->tree, element, "name");
    if (o->out->mesh_count == 4 * SN_OSIM_MOST) return too_many(o, element, "meshes on each body");
    if (!sn_grow(&meshes, &o->mesh_capacity, (size_t)o->out->mesh_count + 1, sizeof mesh)) return sn_fail_memory(o->error, "a mesh");
    o->out->meshes = meshes;
    mesh.file = sn_xml_copy(file);
    mesh.name = sn_xml_copy(name.length > 0 ? name : file);
    o->out->meshes[o->out->mesh_count++] = mesh;
    return mesh.file != NULL && mesh.name != NULL ? SN_OK : sn_fail_memory(o->error, "a mesh");
}

static sn_status read_meshes_4(sn_osim *o) {
    for (sn_index i = sn_xml_find(o->tree, o->model, SN_NONE, "Mesh"); i != SN_NONE; i = sn_xml_find(o->tree, o->model, i, "Mesh")) {
        sn_span file = sn_xml_child_text(o->tree, i, "mesh_file"), socket = sn_xml_child_text(o->tree, i, "socket_frame");
        sn_osim_place where;
        sn_skeleton_mesh mesh = {.scale = {1, 1, 1}};
        if (file.length == 0) continue;
        sn_status status = sn_osim_vec3(o, i, "scale_factors", &mesh.scale);
        if (status == SN_OK) status = sn_osim_resolve(o, i, socket.length > 0 ? socket : (sn_span){"..", 2}, &where);
        if (status == SN_OK) {
            mesh.body = where.body;
            mesh.frame = where.local;
            status = add_mesh(o, i, file, mesh);
        }
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

/* Version 3: six numbers, rotations about x, y, z and where it is. */
static sn_status read_transform_3(const sn_osim *o, sn_index element, sn_rigid *out, sn_vec3 *scale) {
    double six[6] = {0};
    sn_status status = sn_xml_numbers(sn_xml_child_value(o->tree, element, "transform"), 6, six, o->error);
    *out = (sn_rigid){sn_osim_rotation(sn_v3(six[0], six[1], six[2])), sn_v3(six[3], six[4], six[5])};
    *scale = sn_v3(1, 1, 1);
    return status == SN_OK ? sn_osim_vec3(o, element, "scale_factors", scale) : status;
}

static sn_vec3 times(sn_vec3 a, sn_vec3 b) { return sn_v3(a.x * b.x, a.y * b.y, a.z * b.z); }

/* The body's own scale and transform lie over those of each of its meshes. */
static sn_status read_meshes_3(sn_osim *o, sn_index element, sn_index body) {
    static const char kind[] = "DisplayGeometry";
    sn_index visible = sn_xml_child(o->tree, element, "VisibleObject");
    sn_rigid outer = sn_rigid_identity(), inner;
    sn_vec3 outer_scale = {1, 1, 1}, inner_scale;
    sn_status status = visible != SN_NONE ? read_transform_3(o, visible, &outer, &outer_scale) : SN_OK;
    for (sn_index i = sn_xml_find(o->tree, visible, SN_NONE, kind); i != SN_NONE && status == SN_OK;
         i = sn_xml_find(o->tree, visible, i, kind)) {
        sn_span file = sn_xml_child_text(o->tree, i, "geometry_file");
        status = read_transform_3(o, i, &inner, &inner_scale);
        inner.translation = times(outer_scale, inner.translation);
        sn_skeleton_mesh mesh = {.body = body, .scale = times(outer_scale, inner_scale), .frame = sn_rigid_compose(outer, inner)};
        if (status == SN_OK && file.length > 0) status = add_mesh(o, i, file, mesh);
    }
    return status;
}

static sn_status read_meshes(sn_osim *o) {
    sn_status status = read_meshes_4(o);
    sn_index list = sn_xml_child(o->tree, sn_xml_child(o->tree, o->model, "BodySet"), "objects");
    for (sn_index i = sn_xml_child(o->tree, list, "Body"); i != SN_NONE && status == SN_OK; i = sn_xml_next(o->tree, i, "Body")) {
        bool is_ground;
        sn_index body = sn_osim_find_body(o, sn_xml_attribute_text(o->tree, i, "name"), &is_ground);
        status = read_meshes_3(o, i, body);
    }
    return status;
}

/* ---- all
 * --------------------------------------------------------------------------------------------------------------------------------------------------
 */

static sn_status check_document(const sn_osim *o) {
    double version = 0.0;
    if (!sn_xml_is(o->tree, 0, "OpenSimDocument"))
        return sn_xml_fail(o->tree, 0, o->error, "not an OpenSim document: its root is not OpenSimDocument");
    sn_status status = sn_xml_numbers(sn_xml_attribute_value(o->tree, 0, "Version"), 1, &version, o->error);
    if (status == SN_OK && version > 0.0 && version < 20000.0)
        return sn_xml_fail(o->tree, 0, o->error, "the document is of version %.0f; open it in OpenSim 3 or 4 and save it again", version);
    if (status == SN_OK && o->model == SN_NONE) return sn_xml_fail(o->tree, 0, o->error, "the document holds no model");
    return status;
}

static sn_status read_model(sn_osim *o) {
    sn_span name = sn_xml_attribute_text(o->tree, o->model, "name");
    if (name.length > 0 && (o->out->name = sn_xml_copy(name)) == NULL) return sn_fail_memory(o->error, "a model");
    o->out->up_y = true;
    sn_status status = read_bodies(o);
    if (status == SN_OK) status = read_frames(o);
    if (status == SN_OK) status = read_joints(o);
    if (status == SN_OK) status = sn_osim_read_couplers(o);
    if (status == SN_OK) status = read_meshes(o);
    if (status == SN_OK) status = order_bodies(o);
    return status == SN_OK ? sn_skeleton_finish(o->out, o->error) : status;
}

static void free_reader(sn_osim *o) {
    for (size_t i = 0; i < o->joint_count; i++) sn_skeleton_free_body(&o->joints[i].moves);
    free(o->joints);
    free(o->frames);
    free(o->bodies);
}

bool sn_osim_detect(const sn_blob *blob) {
    size_t reach = blob->size < 4096 ? blob->size : 4096;
    return memmem(blob->data, reach, "<OpenSimDocument", 16) != NULL;
}

sn_status sn_osim_parse(const sn_blob *blob, sn_skeleton *out, sn_error *error) {
    sn_xml_tree tree;
    *out = (sn_skeleton){0};
    sn_status status = sn_xml_tree_parse(blob, &tree, error);
    sn_osim o = {.tree = &tree, .error = error, .out = out, .model = SN_NONE};
    if (status == SN_OK) {
        o.model = sn_xml_find(&tree, 0, SN_NONE, "Model");
        status = check_document(&o);
    }
    if (status == SN_OK) status = read_model(&o);
    free_reader(&o);
    sn_xml_tree_free(&tree);
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_skeleton_free(out);
    return status;
}
