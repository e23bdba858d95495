/*
 * external_build.c -- external constraints from the candidates of the documents (attach-detect): which muscles they tie to each other, and
 * the rows of each.   [R18] 4.3, methods.md 8.5
 */
#include "external.h"

#include <stdlib.h>
#include <string.h>

#include "group.h"

/* A candidate whose point is farther from the distance that it tells than this share of the muscle's diagonal was made for another shape.
 */
static const double OTHER_SHAPE = 0.01;

/* ---- names -------------------------------------------------------------------------------------------------------------------------- */

/* What a candidate's target is. */
typedef struct aim {
    sn_index muscle;  /* of the model; SN_NONE: it is none */
    sn_index touched; /* a bone or a surface; SN_NONE */
} aim;

static sn_index find_muscle(const sn_model *model, const char *name) {
    for (sn_index i = 0; i < model->muscle_count; i++)
        if (model->muscles[i].source->name != NULL && strcmp(model->muscles[i].source->name, name) == 0) return i;
    return SN_NONE;
}

/* Of the scene, and left out of it. */
static bool is_left_out(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->muscle_count; i++)
        if (scene->muscles[i].name != NULL && strcmp(scene->muscles[i].name, name) == 0) return !scene->muscles[i].enabled;
    return false;
}

static sn_status find_aim(const sn_model *model, const sn_model_muscle *m, const sn_external *e, aim *out, sn_error *error) {
    const sn_scene *scene = model->scene;
    *out = (aim){find_muscle(model, e->target), SN_NONE};
    if (out->muscle != SN_NONE || is_left_out(scene, e->target)) return SN_OK;
    sn_carrier carrier = sn_scene_carrier(scene, e->target);
    if (carrier.kind == SN_CARRIER_BONE) out->touched = carrier.index;
    if (carrier.kind == SN_CARRIER_SURFACE) out->touched = scene->bone_count + carrier.index;
    if (out->touched != SN_NONE) return SN_OK;
    return sn_fail(
        error, SN_ERROR_INPUT,
        "muscle \"%s\": its external constraints are to \"%s\", which the scene does not have; add it, or leave the muscle's out with "
        "\"externals\": false",
        m->source->name, e->target);
}

/* ---- which muscles touch ------------------------------------------------------------------------------------------------------------ */

static bool takes_part(const sn_model_muscle *m) { return !m->source->unbound; }

static bool runs(const sn_model *model, const sn_model_muscle *m) {
    return model->plan.muscles[m->source - model->scene->muscles].groups[SN_ROWS_EXTERNAL].reason == SN_RUNS;
}

/* What the types of a candidate that are on come to. */
static void weigh(const sn_external_settings *settings, const double told[3], double out[SN_EXTERNAL_TYPES]) {
    const double on[SN_EXTERNAL_TYPES] = {settings->no_slide ? 0.0 : told[0], settings->no_soft ? 0.0 : told[1],
                                          settings->no_hard ? 0.0 : told[2]};
    sn_external_blend(on, out);
}

static bool is_frozen(const sn_model_muscle *m) { return m->source->frozen.sample_count > 0; }

static bool is_attached(const sn_muscle *rig, sn_index vertex) {
    for (sn_index i = 0; i < rig->attachment_count; i++)
        for (sn_index k = 0; k < rig->attachments[i].count; k++)
            if (rig->attachments[i].vertices[k] == vertex) return true;
    return false;
}

/* Does a vertex move by itself, or would it if its muscle were not frozen? */
static bool is_free(const sn_model_muscle *m, sn_index vertex) {
    return is_frozen(m) ? !is_attached(&m->source->rig, vertex) : m->inverse_mass[vertex] > 0.0;
}

/* Does a candidate of a free vertex do anything? */
static bool acts(const sn_model *model, const sn_model_muscle *m, const sn_external *e, sn_index k) {
    double weights[SN_EXTERNAL_TYPES];
    weigh(&model->scene->externals, e->weights + 3 * k, weights);
    bool pulls = weights[0] > 0.0 || weights[1] > 0.0 || weights[2] > 0.0;
    return is_free(m, e->vertices[k]) && (pulls || !model->scene->externals.no_minimum); /* all 0: the minimum alone */
}

static bool any_acts(const sn_model *model, const sn_model_muscle *m, const sn_external *e) {
    for (sn_index k = 0; k < e->count; k++)
        if (acts(model, m, e, k)) return true;
    return false;
}

sn_status sn_externals_join(const sn_model *model, sn_index *parents, sn_error *error) {
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
        const sn_muscle *rig = &m->source->rig;
        for (sn_index k = 0; k < rig->external_count && runs(model, m); k++) {
            aim at;
            sn_status status = find_aim(model, m, &rig->externals[k], &at, error);
            if (status != SN_OK) return status;
            if (at.muscle == i)
                sn_log(SN_LOG_WARNING, "muscle \"%s\": its externals name itself as a target, which binds nothing; it is passed over",
                       m->source->name);
            if (at.muscle != SN_NONE && at.muscle != i && takes_part(&model->muscles[at.muscle]) && any_acts(model, m, &rig->externals[k]))
                sn_join_sets(parents, i, at.muscle);
        }
    }
    return SN_OK;
}

/* ---- what the rows of a group are made in ------------------------------------------------------------------------------------------- */

/* A candidate of one vertex. */
typedef struct found {
    sn_index vertex, target, triangle; /* of the target's mesh as the document has it */
    double barycentric[3], weights[3], distance, minimum;
    sn_index order; /* in which the document has it */
} found;

/* Where the triangles (count) of a target's mesh are in the moving one; SN_NONE = left out. */
typedef struct place_list {
    sn_index count, *of;
} place_list;

typedef struct work {
    sn_model *model;
    sn_group *g;
    place_list *places; /* (target_count) */
    size_t capacity;
    found *found; /* of the muscle at hand */
    size_t found_capacity;
    sn_index found_count;
    sn_vec3 *rest; /* of the targets that move by themselves, (target_points) */
    sn_box *boxes; /* (target_boxes) at rest */
} work;

static const sn_external_target *target_of(const work *w, sn_index i) { return &w->g->targets[i]; }

/* The vertices of a target at rest. */
static const sn_vec3 *rest_of(const work *w, const sn_external_target *t) {
    return t->member != SN_NONE ? w->g->members[t->member]->rest : w->rest + t->first_point;
}

static sn_moving_shape rest_shape(const work *w, const sn_external_target *t) {
    return (sn_moving_shape){&t->moving, rest_of(w, t), w->boxes + t->first_box};
}

/* ---- targets ------------------------------------------------------------------------------------------------------------------------ */

static sn_index member_of(const sn_group *g, sn_index muscle) {
    for (sn_index i = 0; i < g->count; i++)
        if (g->muscles[i] == muscle) return i;
    return SN_NONE;
}

/* The mesh of a bone or a surface in metres; its positions are made, the rest is lent. */
static sn_status lend_mesh(const sn_scene *scene, sn_index touched, sn_mesh *out, sn_error *error) {
    bool is_bone = touched < scene->bone_count;
    const sn_mesh *mesh = is_bone ? &scene->bones[touched].mesh : &scene->surfaces[touched - scene->bone_count].envelope.mesh;
    double unit = is_bone ? scene->bones[touched].meters_per_unit : 1.0;
    *out = *mesh;
    if (mesh->triangle_count == 0)
        return sn_fail(error, SN_ERROR_INPUT, "\"%s\" has no surface that muscles could be tied to", sn_scene_touched_name(scene, touched));
    if ((out->positions = SN_NEW(sn_vec3, mesh->vertex_count)) == NULL) return sn_fail_memory(error, "external constraints");
    for (sn_index v = 0; v < mesh->vertex_count; v++) out->positions[v] = sn_scale(mesh->positions[v], unit);
    return SN_OK;
}

/* Of an envelope, which goes along with the muscles' bones, what is near to the group: within the box of each member and a quarter of its
 * diagonal around it. Of a bone, and of a surface that goes as its own frames say, all: muscles go along it as far as others take them, and
 * where it ended they would slide on its rim. */
static const double ROOM = 0.25;

static bool is_whole(const sn_scene *scene, sn_index touched) {
    return touched < scene->bone_count || scene->surfaces[touched - scene->bone_count].kind == SN_SURFACE_DRIVEN;
}

static sn_status keep_near(const work *w, const sn_mesh *mesh, const sn_moving *whole, sn_external_target *t, sn_error *error) {
    sn_box *boxes = SN_NEW(sn_box, sn_moving_box_count(whole));
    bool *touched = SN_NEW(bool, sn_moving_leaf_count(whole)), *keep = SN_NEW(bool, whole->triangle_count), any = false;
    sn_status status = SN_OK;
    if (boxes == NULL || touched == NULL || keep == NULL) {
        status = sn_fail_memory(error, "external constraints");
        goto cleanup;
    }
    if (is_whole(w->model->scene, t->touched))
        for (sn_index i = 0; i < whole->triangle_count; i++) any = keep[i] = true;
    sn_moving_fit(whole, mesh->positions, boxes);
    for (sn_index i = 0; i < w->g->count && !any; i++) {
        const sn_model_muscle *m = w->g->members[i];
        sn_box box = SN_EMPTY_BOX;
        double room = ROOM * m->diagonal;
        for (sn_index v = 0; v < m->vertex_count; v++) sn_box_add(&box, m->rest[v]);
        box = (sn_box){sn_sub(box.low, sn_v3(room, room, room)), sn_add(box.high, sn_v3(room, room, room))};
        sn_moving_touch(whole, boxes, &box, touched);
    }
    for (sn_index i = 0; i < whole->triangle_count; i++) any = (keep[i] = keep[i] || touched[sn_moving_leaf(whole, i)]) || any;
    if (!any) keep[0] = true;
    status = sn_moving_part(whole, keep, &t->moving, t->vertices, error);
cleanup:
    free(boxes);
    free(touched);
    free(keep);
    return status;
}

static sn_status make_own_target(work *w, sn_external_target *t, sn_error *error) {
    sn_mesh mesh;
    sn_moving whole = {0};
    sn_status status = lend_mesh(w->model->scene, t->touched, &mesh, error);
    if (status != SN_OK) return status;
    if ((t->vertices = SN_NEW(sn_index, mesh.vertex_count)) == NULL) status = sn_fail_memory(error, "external constraints");
    if (status == SN_OK) status = sn_moving_create_any(&mesh, &whole, error);
    if (status == SN_OK) status = keep_near(w, &mesh, &whole, t, error);
    if (status == SN_OK) {
        t->first_point = w->g->target_points;
        w->g->target_points += t->moving.vertex_count;
        sn_vec3 *rest = sn_realloc(w->rest, (size_t)w->g->target_points, sizeof *rest);
        if (rest == NULL) status = sn_fail_memory(error, "external constraints");
        if (rest != NULL) w->rest = rest;
        for (sn_index v = 0; rest != NULL && v < t->moving.vertex_count; v++) rest[t->first_point + v] = mesh.positions[t->vertices[v]];
    }
    sn_moving_free(&whole);
    free(mesh.positions);
    return status;
}

static sn_status make_member_target(const work *w, sn_external_target *t, sn_error *error) {
    const sn_model_muscle *m = w->g->members[t->member];
    sn_mesh mesh = {.vertex_count = m->vertex_count, .triangle_count = m->triangle_count, .positions = m->rest, .triangles = m->triangles};
    return sn_moving_create_any(&mesh, &t->moving, error);
}

static sn_index triangles_of(const work *w, const sn_external_target *t) {
    const sn_scene *scene = w->model->scene;
    if (t->member != SN_NONE) return w->g->members[t->member]->triangle_count;
    return t->touched < scene->bone_count ? scene->bones[t->touched].mesh.triangle_count
                                          : scene->surfaces[t->touched - scene->bone_count].envelope.mesh.triangle_count;
}

static bool is_closed(const sn_moving *moving) {
    bool closed = true;
    for (sn_index i = 0; i < moving->vertex_count && closed; i++) closed = !moving->rim[i];
    return closed;
}

static bool place_triangles(const work *w, const sn_external_target *t, place_list *out) {
    *out = (place_list){triangles_of(w, t), SN_NEW(sn_index, triangles_of(w, t))};
    if (out->of == NULL) return false;
    for (sn_index i = 0; i < out->count; i++) out->of[i] = SN_NONE;
    for (sn_index i = 0; i < t->moving.triangle_count; i++) out->of[t->moving.sources[i]] = i;
    return true;
}

static sn_status add_boxes(work *w, sn_external_target *t, sn_error *error) {
    t->first_box = w->g->target_boxes;
    w->g->target_boxes += sn_moving_box_count(&t->moving);
    sn_box *boxes = sn_realloc(w->boxes, (size_t)w->g->target_boxes, sizeof *boxes);
    if (boxes == NULL) return sn_fail_memory(error, "external constraints");
    w->boxes = boxes;
    sn_moving_fit(&t->moving, rest_of(w, t), boxes + t->first_box);
    return SN_OK;
}

/* The number of this target of the group, made where it is missing. */
static sn_status take_target(work *w, const aim *at, sn_index *number, sn_error *error) {
    sn_group *g = w->g;
    sn_index member = at->muscle != SN_NONE ? member_of(g, at->muscle) : SN_NONE;
    for (*number = 0; *number < g->target_count; ++*number)
        if (g->targets[*number].member == member && g->targets[*number].touched == at->touched) return SN_OK;
    size_t targets = w->capacity, places = w->capacity;
    if (!sn_grow((void **)&g->targets, &targets, (size_t)g->target_count + 1, sizeof *g->targets) ||
        !sn_grow((void **)&w->places, &places, (size_t)g->target_count + 1, sizeof *w->places))
        return sn_fail_memory(error, "external constraints");
    w->capacity = targets;
    sn_external_target *t = &g->targets[g->target_count];
    *t = (sn_external_target){.member = member, .touched = at->touched};
    w->places[g->target_count++] = (place_list){0};
    sn_status status = member != SN_NONE ? make_member_target(w, t, error) : make_own_target(w, t, error);
    t->closed = status == SN_OK && is_closed(&t->moving);
    if (status == SN_OK) status = add_boxes(w, t, error);
    if (status == SN_OK && !place_triangles(w, t, &w->places[*number])) status = sn_fail_memory(error, "external constraints");
    return status;
}

/* ---- candidates --------------------------------------------------------------------------------------------------------------------- */

/* It lies on the target where the document says; else it was made for another shape. */
static sn_status check_found(const work *w, const sn_model_muscle *m, const sn_external *e, const found *f, sn_error *error) {
    sn_moving_shape shape = rest_shape(w, target_of(w, f->target));
    sn_index place = f->triangle < w->places[f->target].count ? w->places[f->target].of[f->triangle] : SN_NONE;
    sn_closest at = {.triangle = place, .barycentric = {f->barycentric[0], f->barycentric[1], f->barycentric[2]}};
    if (f->triangle < w->places[f->target].count && place == SN_NONE) return SN_OK; /* far away, and left out */
    double off = place != SN_NONE ? fabs(sn_distance(sn_moving_point(&shape, &at), m->rest[f->vertex]) - fabs(f->distance)) : INFINITY;
    if (off <= OTHER_SHAPE * m->diagonal) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT,
                   "muscle \"%s\": its external constraints to \"%s\" were made for another mesh (vertex %ld); run attach-detect again",
                   m->source->name, e->target, (long)f->vertex);
}

static sn_status add_candidates(work *w, const sn_model_muscle *m, const sn_external *e, sn_index target, sn_error *error) {
    double unit = m->source->rig.meters_per_unit;
    sn_status status = SN_OK;
    for (sn_index k = 0; k < e->count && status == SN_OK; k++) {
        if (!acts(w->model, m, e, k)) continue;
        if (!sn_grow((void **)&w->found, &w->found_capacity, (size_t)w->found_count + 1, sizeof *w->found))
            return sn_fail_memory(error, "external constraints");
        found f = {.vertex = e->vertices[k],
                   .target = target,
                   .triangle = e->triangles[k],
                   .distance = unit * e->distances[k],
                   .minimum = unit * e->minimum[k],
                   .order = w->found_count};
        memcpy(f.barycentric, e->barycentric + 3 * k, sizeof f.barycentric);
        memcpy(f.weights, e->weights + 3 * k, sizeof f.weights);
        status = check_found(w, m, e, &f, error);
        if (status == SN_OK && w->places[target].of[f.triangle] != SN_NONE) w->found[w->found_count++] = f;
    }
    return status;
}

/* By vertex, the nearest first, of those as near the first target. */
static int compare_found(const void *a, const void *b) {
    const found *p = a, *q = b;
    if (p->vertex != q->vertex) return p->vertex < q->vertex ? -1 : 1;
    double near = fabs(p->distance), far = fabs(q->distance);
    if (near != far) return near < far ? -1 : 1;
    if (p->target != q->target) return p->target < q->target ? -1 : 1;
    return (p->order > q->order) - (p->order < q->order); /* deep and superficial fascia to one target */
}

static sn_status find_candidates(work *w, const sn_model_muscle *m, sn_error *error) {
    const sn_muscle *rig = &m->source->rig;
    sn_status status = SN_OK;
    w->found_count = 0;
    for (sn_index i = 0; i < rig->external_count && runs(w->model, m) && status == SN_OK; i++) {
        aim at;
        sn_index target;
        status = find_aim(w->model, m, &rig->externals[i], &at, error);
        bool there = at.touched != SN_NONE || (at.muscle != SN_NONE && takes_part(&w->model->muscles[at.muscle]));
        bool itself = at.muscle != SN_NONE && &w->model->muscles[at.muscle] == m;
        if (status != SN_OK || !there || itself || !any_acts(w->model, m, &rig->externals[i])) continue;
        status = take_target(w, &at, &target, error);
        if (status == SN_OK) status = add_candidates(w, m, &rig->externals[i], target, error);
    }
    if (status == SN_OK && w->found_count > 1) qsort(w->found, (size_t)w->found_count, sizeof *w->found, compare_found);
    return status;
}

/* ---- rows ---------------------------------------------------------------------------------------------------------------------------- */

void sn_external_frame(const sn_moving_shape *shape, sn_index triangle, sn_vec3 axes[3]) {
    const sn_index *v = shape->moving->triangles[triangle].v;
    sn_vec3 a = shape->positions[v[0]], b = shape->positions[v[1]], c = shape->positions[v[2]];
    axes[2] = sn_normalize(sn_area_vector(a, b, c));
    axes[0] = sn_normalize(sn_sub(b, a));
    axes[1] = sn_cross(axes[2], axes[0]);
}

/* The distance to the nearest of all its targets at rest; to each of them into all->rest_sides. */
static double nearest_distance(const work *w, sn_externals *all, const sn_external_row *row, sn_vec3 at) {
    double best = INFINITY;
    for (sn_index c = row->begin; c < row->end; c++) {
        sn_moving_shape shape = rest_shape(w, target_of(w, all->candidates[c]));
        sn_closest foot = sn_moving_closest(&shape, row->triangle, at);
        double side = all->rest_sides[c] = sn_moving_side(&shape, &foot, at, NULL);
        if (fabs(side) < fabs(best)) best = side;
    }
    return best;
}

static void bind_row(const work *w, const sn_model_muscle *m, sn_externals *all, const found *f, sn_external_row *row) {
    sn_moving_shape shape = rest_shape(w, target_of(w, f->target));
    sn_closest at = {.triangle = w->places[f->target].of[f->triangle],
                     .barycentric = {f->barycentric[0], f->barycentric[1], f->barycentric[2]}};
    sn_vec3 axes[3], away = sn_sub(m->rest[f->vertex], sn_moving_point(&shape, &at));
    row->point = f->vertex;
    row->triangle = at.triangle;
    memcpy(row->barycentric, f->barycentric, sizeof row->barycentric);
    weigh(&w->model->scene->externals, f->weights, row->weights);
    sn_external_frame(&shape, at.triangle, axes);
    row->offset = sn_v3(sn_dot(away, axes[0]), sn_dot(away, axes[1]), sn_dot(away, axes[2]));
    row->bound = sn_norm(away);
    row->distance = nearest_distance(w, all, row, m->rest[f->vertex]);
    bool least = !w->model->scene->externals.no_minimum && row->weights[SN_EXTERNAL_SLIDE] < 1.0;
    row->least = least ? fmin(f->minimum, row->distance) : -INFINITY;
}

/* A vertex of a frozen muscle is of use to others alone: one of its targets (found from begin to end) must be a muscle that is not. */
static bool is_of_use(const work *w, const sn_model_muscle *m, sn_index begin, sn_index end) {
    bool use = !is_frozen(m);
    for (sn_index i = begin; i < end && !use; i++) {
        sn_index member = target_of(w, w->found[i].target)->member;
        use = member != SN_NONE && !is_frozen(w->g->members[member]);
    }
    return use;
}

static sn_status make_rows(const work *w, sn_model_muscle *m, sn_error *error) {
    sn_externals *all = SN_NEW(sn_externals, 1);
    if ((m->own[SN_ROWS_EXTERNAL] = all) == NULL) return sn_fail_memory(error, "external constraints");
    all->factor = w->model->scene->externals.stiffness;
    all->rows = SN_NEW(sn_external_row, w->found_count);
    all->candidates = SN_NEW(sn_index, w->found_count);
    all->rest_sides = SN_NEW(double, w->found_count);
    if (all->rows == NULL || all->candidates == NULL || all->rest_sides == NULL) return sn_fail_memory(error, "external constraints");
    for (sn_index first = 0, next; first < w->found_count; first = next) {
        for (next = first; next < w->found_count && w->found[next].vertex == w->found[first].vertex;) next++;
        if (!is_of_use(w, m, first, next)) continue;
        sn_external_row *row = &all->rows[m->external_count++];
        row->begin = all->candidate_count;
        for (sn_index i = first; i < next; i++) all->candidates[all->candidate_count++] = w->found[i].target;
        row->end = all->candidate_count;
        bind_row(w, m, all, &w->found[first], row);
    }
    return SN_OK;
}

static void tell_plan(const work *w, sn_model_muscle *m) {
    sn_plan_muscle *plan = &w->model->plan.muscles[m->source - w->model->scene->muscles];
    sn_plan_group *group = &plan->groups[SN_ROWS_EXTERNAL];
    group->rows = m->external_count;
    group->bytes = (size_t)m->external_count * sn_rows_external.bytes(m);
    const sn_externals *all = sn_externals_of(m);
    for (sn_index r = 0; r < m->external_count; r++) {
        plan->ties_inside += all->rows[r].distance < 0.0;
        plan->deepest_tie = fmax(plan->deepest_tie, -all->rows[r].distance);
    }
    plan->model_bytes += sn_rows_external.own_bytes(m, SN_ROWS_EXTERNAL);
    if (group->reason == SN_RUNS && group->rows == 0) group->reason = SN_OUT_NO_TARGET;
}

sn_status sn_externals_build(sn_model *model, sn_group *g, sn_error *error) {
    work w = {.model = model, .g = g};
    sn_status status = SN_OK;
    for (sn_index i = 0; i < g->count && status == SN_OK; i++) {
        sn_model_muscle *m = &model->muscles[g->muscles[i]];
        status = find_candidates(&w, m, error);
        if (status == SN_OK && w.found_count > 0) status = make_rows(&w, m, error);
        if (status == SN_OK) tell_plan(&w, m);
        g->row_count += m->external_count;
    }
    for (sn_index i = 0; i < g->target_count && w.places != NULL; i++) free(w.places[i].of);
    free(w.places);
    free(w.found);
    free(w.rest);
    free(w.boxes);
    return status;
}

void sn_external_targets_free(sn_group *g) {
    for (sn_index i = 0; i < g->target_count; i++) {
        sn_moving_free(&g->targets[i].moving);
        free(g->targets[i].vertices);
    }
    free(g->targets);
}
