/*
 * contact_build.c -- the rows of contact of one muscle: which of its points are held out of which bones and surfaces, and by which margin.
 * bodies.md 2
 *
 * Points that a bone carries have none, and the vertices around an attachment none against that bone, and those that move as one with it:
 * the muscle grows out of it there.
 */
#include "contact.h"

#include <stdlib.h>
#include <string.h>

/* Vertices as near to an attachment as so many edges do not feel its bone. */
enum { EDGES_AROUND_ATTACHMENT = 2 };
/* Of the muscle's mean edge (bodies.md 2). */
static const double DEFAULT_MARGIN = 0.1;
/* A surface that passes by farther in a step than this share of the thinner of the two could pass through (numerics.md 7). */
static const double SAFE_WAY = 0.3;
/* A muscle of which such a share is inside a bone or surface at rest lies in it, as in a skin, and is not to be held out. */
static const double SHARE_INSIDE = 0.9;

/* What a row is held out of, at rest. */
typedef struct rest_collider {
    const sn_distance_field *field;
    sn_moving_shape patch, whole; /* of a surface: field is NULL */
} rest_collider;

/* What the rows of one muscle are made in. */
typedef struct contact_work {
    const sn_build *build;
    sn_contacts *contacts;
    rest_collider rest; /* of the collider at hand */
    bool *excluded;     /* (vertex_count) by the bone at hand */
    sn_index *front;    /* (vertex_count) room */
} contact_work;

/* ---- what is excluded ----------------------------------------------------------------------------------------------------------- */

static sn_index exclude(contact_work *w, sn_index vertex, sn_index count) {
    if (w->excluded[vertex]) return count;
    w->excluded[vertex] = true;
    w->front[count] = vertex;
    return count + 1;
}

/* The vertices on this bone, and those up to two edges from them. */
static void exclude_attachment(contact_work *w, const sn_attachment *attachment) {
    const sn_topology *t = w->build->topology;
    sn_index count = 0, begin = 0;
    for (sn_index i = 0; i < attachment->count; i++) count = exclude(w, attachment->vertices[i], count);
    for (int edges = 0; edges < EDGES_AROUND_ATTACHMENT; edges++) {
        sn_index end = count;
        for (sn_index i = begin; i < end; i++)
            for (sn_index k = t->vertex_start[w->front[i]]; k < t->vertex_start[w->front[i] + 1]; k++)
                count = exclude(w, t->neighbours[k], count);
        begin = end;
    }
}

/* Is this attachment to the bone, or to another that moves as one with it? From scene->bone_count on: to the surface? */
static bool holds_to(const sn_scene *scene, const sn_attachment *attachment, sn_index bone) {
    sn_carrier carrier = sn_scene_carrier(scene, attachment->bone);
    if (bone >= scene->bone_count) return carrier.kind == SN_CARRIER_SURFACE && carrier.index == bone - scene->bone_count;
    if (carrier.kind == SN_CARRIER_BONE) return carrier.index == bone || scene->bones[carrier.index].joint == scene->bones[bone].joint;
    return carrier.kind == SN_CARRIER_JOINT && carrier.index == scene->bones[bone].joint;
}

static void find_excluded(contact_work *w, sn_index bone) {
    const sn_muscle *rig = &w->build->source->rig;
    memset(w->excluded, 0, (size_t)w->build->model->vertex_count * sizeof *w->excluded);
    for (sn_index i = 0; i < rig->attachment_count; i++)
        if (holds_to(w->build->scene, &rig->attachments[i], bone)) exclude_attachment(w, &rig->attachments[i]);
}

/* ---- rows ------------------------------------------------------------------------------------------------------------------------ */

/* Where the whole surface has a point inside, and the patch may not know it: its nearest point there may be where it was cut off. Deep
 * points are taken to be as far in as the patch is from them, so that they stay when they come to face it. */
static double margin_of_surface(const rest_collider *rest, sn_vec3 at, double most) {
    sn_closest in_whole = sn_moving_closest(&rest->whole, 0, at), in_patch = sn_moving_closest(&rest->patch, 0, at);
    double whole = sn_moving_side(&rest->whole, &in_whole, at, NULL), patch = sn_moving_side(&rest->patch, &in_patch, at, NULL);
    return whole < 0.0 ? fmin(whole, -in_patch.distance) : fmin(most, fmin(whole, patch));
}

/* What it had at rest, where that is less than what is asked. */
static float margin_of(const contact_work *w, const sn_contact_row *row) {
    sn_vec3 at = sn_v3(0, 0, 0);
    for (int i = 0; i < 3; i++) at = sn_add_scaled(at, w->build->model->rest[row->point[i]], (double)row->weight[i]);
    if (w->rest.field == NULL) return (float)margin_of_surface(&w->rest, at, w->contacts->margin);
    return (float)fmin(w->contacts->margin, sn_distance_field_at(w->rest.field, at, NULL));
}

static void add_row(contact_work *w, sn_contact_row row) {
    row.margin = margin_of(w, &row);
    w->contacts->rows[w->build->model->contact_count++] = row;
}

static void add_vertices(contact_work *w) {
    const sn_model_muscle *m = w->build->model;
    for (sn_index v = 0; v < m->vertex_count; v++)
        if (m->inverse_mass[v] > 0.0 && !w->excluded[v]) add_row(w, (sn_contact_row){.point = {v, v, v}, .weight = {1.0f, 0.0f, 0.0f}});
}

/* The middle of each triangle, or three points half way from it to the corners. */
static void add_samples(contact_work *w) {
    const sn_model_muscle *m = w->build->model;
    const float third = 1.0f / 3.0f, far = 1.0f / 6.0f, near = 2.0f / 3.0f;
    sn_index samples = w->build->scene->contact.samples;
    for (sn_index t = 0; t < m->triangle_count && samples > 0; t++) {
        const sn_index *v = m->triangles[t].v;
        bool held = w->excluded[v[0]] || w->excluded[v[1]] || w->excluded[v[2]];
        bool is_free = m->inverse_mass[v[0]] > 0.0 || m->inverse_mass[v[1]] > 0.0 || m->inverse_mass[v[2]] > 0.0;
        if (held || !is_free || !(m->rest_area[t] > 0.0)) continue;
        sn_contact_row row = {.point = {v[0], v[1], v[2]}, .weight = {third, third, third}};
        if (samples == 1) add_row(w, row);
        for (int i = 0; i < 3 && samples == 3; i++) {
            for (int k = 0; k < 3; k++) row.weight[k] = k == i ? near : far;
            add_row(w, row);
        }
    }
}

/* ---- their order: what is near to each other stands together, so that blocks of rows can be passed over -------------------------------
 */

typedef struct placed_row {
    uint32_t place; /* along a space-filling curve */
    sn_index number;
    sn_contact_row row;
} placed_row;

static int compare_places(const void *a, const void *b) {
    const placed_row *p = a, *q = b;
    if (p->place != q->place) return p->place < q->place ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

/* The bits of x, y and z in turn (Morton 1966), ten of each: where in the box a point is. */
static uint32_t place_of(const sn_box *box, sn_vec3 p) {
    enum { BITS = 10 };
    sn_vec3 size = sn_sub(box->high, box->low), away = sn_sub(p, box->low);
    const double shares[3] = {away.x / fmax(size.x, 1e-30), away.y / fmax(size.y, 1e-30), away.z / fmax(size.z, 1e-30)};
    uint32_t place = 0;
    for (int bit = BITS; bit-- > 0;)
        for (int i = 0; i < 3; i++) {
            uint32_t cell = (uint32_t)(fmin(fmax(shares[i], 0.0), 1.0) * ((1 << BITS) - 1));
            place = place << 1 | (cell >> bit & 1u);
        }
    return place;
}

static bool sort_rows(const contact_work *w, sn_index begin) {
    const sn_model_muscle *m = w->build->model;
    sn_contact_row *rows = w->contacts->rows + begin;
    sn_index count = m->contact_count - begin;
    placed_row *sorted = SN_NEW(placed_row, count);
    sn_box box = SN_EMPTY_BOX;
    if (sorted == NULL) return false;
    for (sn_index v = 0; v < m->vertex_count; v++) sn_box_add(&box, m->rest[v]);
    for (sn_index i = 0; i < count; i++) sorted[i] = (placed_row){place_of(&box, m->rest[rows[i].point[0]]), i, rows[i]};
    qsort(sorted, (size_t)count, sizeof *sorted, compare_places);
    for (sn_index i = 0; i < count; i++) rows[i] = sorted[i].row;
    free(sorted);
    return true;
}

static double thickness_of(const sn_model_muscle *m) {
    double area = 0.0;
    for (sn_index t = 0; t < m->triangle_count; t++) area += m->rest_area[t];
    double thickness = sn_thickness(m->rest_volume, area);
    return thickness > 0.0 ? thickness : m->mean_edge; /* an open sheet has no volume */
}

/* Of the rows from begin on, those of vertices. A muscle is dragged along and torn by what it lies in, were it held out of that. */
static bool lies_inside(const contact_work *w, sn_index bone, sn_index begin) {
    sn_index inside = 0, count = w->build->model->contact_count - begin;
    for (sn_index r = begin; r < begin + count; r++) inside += w->contacts->rows[r].margin < 0.0f;
    if (count == 0 || (double)inside < SHARE_INSIDE * (double)count) return false;
    sn_log(SN_LOG_WARNING, "muscle \"%s\" lies in \"%s\" at rest, with %ld of %ld free vertices: it is not held out of that",
           w->build->source->name, sn_scene_touched_name(w->build->scene, bone), (long)inside, (long)count);
    return true;
}

/* Rows of the muscle's points and this collider, which gets their numbers and a place where there are any. */
static bool add_rows(contact_work *w, sn_collider collider) {
    sn_model_muscle *m = w->build->model;
    bool by_voxels = w->contacts->by_voxels;
    collider.begin = m->contact_count;
    if (!by_voxels) find_excluded(w, collider.bone); /* [K21] spares fixed points alone, and it has no samples */
    add_vertices(w);
    if (!by_voxels && lies_inside(w, collider.bone, collider.begin)) {
        m->contact_count = collider.begin;
        return true;
    }
    if (!by_voxels) add_samples(w);
    collider.end = m->contact_count;
    if (collider.end == collider.begin) return true;
    if (!by_voxels && !sort_rows(w, collider.begin)) return false;
    w->contacts->colliders[m->collider_count++] = collider;
    return true;
}

static bool add_bone(contact_work *w, sn_index bone) {
    const struct sn_contact_plan *plan = w->build->contact;
    sn_model_muscle *m = w->build->model;
    double thinner = fmin(thickness_of(m), plan->thickness[bone] > 0.0 ? plan->thickness[bone] : INFINITY);
    w->rest = (rest_collider){.field = &plan->fields[bone]};
    return add_rows(w, (sn_collider){.bone = bone,
                                     .joint = w->build->scene->bones[bone].joint,
                                     .field = &plan->fields[bone],
                                     .voxels = plan->voxels != NULL ? &plan->voxels[bone] : NULL,
                                     .limit = SAFE_WAY * thinner});
}

/* ---- surfaces ------------------------------------------------------------------------------------------------------------------------ */

static sn_index muscle_of(const sn_build *build) { return (sn_index)(build->source - build->scene->muscles); }

/* A surface, or a part of it, at rest. */
typedef struct rest_shape {
    sn_vec3 *positions;
    sn_box *boxes;
} rest_shape;

static sn_moving_shape lay(const sn_scene_surface *surface, const sn_moving *moving, const sn_index *vertices, rest_shape *room) {
    room->positions = SN_NEW(sn_vec3, moving->vertex_count);
    room->boxes = SN_NEW(sn_box, sn_moving_box_count(moving));
    if (room->positions == NULL || room->boxes == NULL) return (sn_moving_shape){.moving = NULL};
    for (sn_index v = 0; v < moving->vertex_count; v++) room->positions[v] = surface->envelope.mesh.positions[vertices[v]];
    sn_moving_fit(moving, room->positions, room->boxes);
    return (sn_moving_shape){moving, room->positions, room->boxes};
}

/* Its rows; *made: it has some, and owns the patch. */
static bool add_patch_rows(contact_work *w, sn_index surface, sn_patch *patch, bool *made) {
    const sn_contact_surface *whole = &w->build->contact->surfaces[surface];
    sn_model_muscle *m = w->build->model;
    sn_index colliders = m->collider_count;
    rest_shape rooms[2] = {{NULL, NULL}, {NULL, NULL}};
    w->rest = (rest_collider){.patch = lay(patch->surface, &patch->moving, patch->vertices, &rooms[0]),
                              .whole = lay(patch->surface, &whole->moving, whole->vertices, &rooms[1])};
    bool enough = w->rest.patch.moving != NULL && w->rest.whole.moving != NULL;
    double thickness = whole->thickness;
    if (enough)
        enough = add_rows(w, (sn_collider){.bone = w->build->contact->bone_count + surface,
                                           .joint = SN_NONE,
                                           .patch = patch,
                                           .limit = SAFE_WAY * fmin(thickness_of(m), thickness > 0.0 ? thickness : INFINITY)});
    for (int i = 0; i < 2; i++) free(rooms[i].positions), free(rooms[i].boxes);
    *made = m->collider_count > colliders;
    return enough;
}

static bool add_patch(contact_work *w, sn_index surface) {
    sn_model_muscle *m = w->build->model;
    sn_patch *patch = SN_NEW(sn_patch, 1);
    bool made = false, enough = patch != NULL && sn_patch_make(w->build->contact, muscle_of(w->build), surface, patch, NULL) == SN_OK;
    sn_index first = m->contact_count;
    if (enough) {
        *patch =
            (sn_patch){&w->build->scene->surfaces[surface], patch->moving, patch->vertices, m->patch_points, m->patch_boxes, m->feet_count};
        enough = add_patch_rows(w, surface, patch, &made);
    }
    if (!made) {
        sn_patch_free(patch);
        return enough;
    }
    m->patch_points += patch->moving.vertex_count;
    m->patch_boxes += sn_moving_box_count(&patch->moving);
    m->feet_count += m->contact_count - first;
    m->pose_count = w->build->scene->motion.joint_count;
    return enough;
}

/* ---- the whole --------------------------------------------------------------------------------------------------------------------- */

static const bool *reach_of(const sn_build *build) {
    const struct sn_contact_plan *plan = build->contact;
    return plan->reach + (size_t)muscle_of(build) * (size_t)plan->bone_count;
}

static sn_index count_colliders(const sn_build *build) {
    const bool *reach = reach_of(build);
    sn_index count = 0;
    for (sn_index b = 0; b < build->contact->bone_count; b++) count += reach[b];
    for (sn_index i = 0; i < build->contact->surface_count; i++) count += sn_contact_surface_near(build->contact, muscle_of(build), i);
    return count;
}

static bool make_room(contact_work *w, sn_index colliders) {
    sn_model_muscle *m = w->build->model;
    size_t samples = (size_t)w->build->scene->contact.samples * (size_t)m->triangle_count;
    return (w->contacts->colliders = SN_NEW(sn_collider, colliders)) &&
           (w->contacts->rows = SN_NEW(sn_contact_row, (size_t)colliders * ((size_t)m->vertex_count + samples))) &&
           (w->excluded = SN_NEW(bool, m->vertex_count)) && (w->front = SN_NEW(sn_index, m->vertex_count)) &&
           (w->build->plan->bones = SN_NEW(sn_index, colliders));
}

/* The rows' arrays as long as they are, and what is touched for the plan. */
static void settle(contact_work *w) {
    sn_model_muscle *m = w->build->model;
    sn_plan_muscle *plan = w->build->plan;
    void *fitted = sn_realloc(w->contacts->rows, (size_t)m->contact_count, sizeof *w->contacts->rows);
    if (fitted != NULL) w->contacts->rows = fitted;
    for (sn_index i = 0; i < m->collider_count; i++) plan->bones[plan->bone_count++] = w->contacts->colliders[i].bone;
    for (sn_index r = 0; r < m->contact_count; r++) {
        double depth = -(double)w->contacts->rows[r].margin;
        plan->overlaps += depth > 0.0;
        plan->overlap = fmax(plan->overlap, depth);
    }
}

/* Voxels know no margin: rows tell how much deeper than at rest a vertex is. */
static void use_voxels(const sn_contact_settings *asked, sn_contacts *contacts) {
    contacts->by_voxels = true;
    contacts->bone_hits = asked->bone_hits;
    contacts->margin = contacts->friction = contacts->resolve = 0.0;
}

sn_status sn_contacts_build(const sn_build *build, sn_row_kind kind, sn_error *error) {
    sn_model_muscle *m = build->model;
    const sn_contact_settings *asked = &build->scene->contact;
    if (build->plan->groups[kind].reason != SN_RUNS) return SN_OK;
    contact_work w = {.build = build, .contacts = SN_NEW(sn_contacts, 1)};
    if ((m->own[kind] = w.contacts) == NULL) return sn_fail_memory(error, "contact");
    w.contacts->margin = asked->margin > 0.0 ? asked->margin : DEFAULT_MARGIN * m->mean_edge;
    w.contacts->friction = asked->friction;
    w.contacts->begin = build->scene->first_frame / build->scene->rate;
    w.contacts->resolve = asked->resolve;
    if (build->contact->voxels != NULL) use_voxels(asked, w.contacts);
    bool made = make_room(&w, count_colliders(build));
    for (sn_index b = 0; made && b < build->contact->bone_count; b++)
        if (reach_of(build)[b]) made = add_bone(&w, b);
    for (sn_index i = 0; made && i < build->contact->surface_count; i++)
        if (sn_contact_surface_near(build->contact, muscle_of(build), i)) made = add_patch(&w, i);
    if (made) settle(&w);
    free(w.excluded);
    free(w.front);
    build->plan->groups[kind].rows = m->contact_count;
    return made ? SN_OK : sn_fail_memory(error, "contact");
}

sn_index sn_model_patch_size(const sn_model *model, sn_index muscle, sn_index surface) {
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
        if (m->source != &model->scene->muscles[muscle]) continue;
        for (sn_index c = 0; c < m->collider_count; c++) {
            const sn_collider *collider = &sn_contacts_of(m)->colliders[c];
            if (collider->bone == model->scene->bone_count + surface) return collider->patch->moving.triangle_count;
        }
    }
    return 0;
}

void sn_contacts_destroy(sn_model_muscle *m, sn_row_kind kind) {
    sn_contacts *contacts = m->own[kind];
    if (contacts == NULL) return;
    for (sn_index c = 0; contacts->colliders != NULL && c < m->collider_count; c++) sn_patch_free(contacts->colliders[c].patch);
    free(contacts->colliders);
    free(contacts->rows);
    free(contacts);
    m->own[kind] = NULL;
}

sn_left_out sn_contacts_reason(const sn_build *build) {
    if (build->contact == NULL || build->source->untouched) return SN_OUT_SETTING;
    return count_colliders(build) > 0 ? SN_RUNS : SN_OUT_NO_BONE;
}
