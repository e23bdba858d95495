/*
 * contact_reach.c -- which bones, and which parts of surfaces, come near which muscle over the motion, by boxes; and the distance fields of
 * those bones.   bodies.md 2
 *
 * A muscle is taken to stay in the box around where each bone that it is attached to would carry all of its rest shape, and some room
 * around that. The rest of the scene's bones it never hears of. All of the motion is looked at, whatever frames are simulated and at which
 * rate: which rows there are must not depend on where a run begins or ends, so that another may go on with its state.
 */
#include "contact.h"

#include <stdlib.h>

/* Room around a muscle, as a share of its diagonal: it bulges, swings, and is pushed aside. */
static const double ROOM = 0.15;
/* Looks at the motion a second, and how many there are at most; on the way from rest to the motion, of a run-in, at so many places of it.
 */
static const double LOOKS_A_SECOND = 60.0;
enum { MOST_LOOKS = 100000, RUN_IN_PLACES = 16, RUN_IN_SHARES = 4 };
/* Cells of a field along a bone's diagonal, at most, where the scene leaves the cell open; and the smallest such cell, m. */
static const double MOST_CELLS = 400.0, LEAST_CELL = 1e-4;
/* Of the finest mean edge in reach (bodies.md 2); and through a bone, so that a phalanx beside a coarse muscle has an inside. */
static const double CELLS_PER_EDGE = 3.0, CELLS_PER_THICKNESS = 6.0;

typedef struct reach_work {
    const sn_scene *scene;
    struct sn_contact_plan *plan;
    sn_box *bones, *muscles; /* at rest, m */
    sn_box *swept;           /* the muscles at a moment, with room around them; empty: no part in contact */
    double *edges;           /* mean ones of the muscles, m */
    sn_rigid *poses;         /* room for those of all joints */
} reach_work;

/* ---- boxes ---------------------------------------------------------------------------------------------------------------------- */

static sn_box mesh_box(const sn_mesh *mesh, double unit) {
    sn_box box = sn_mesh_box(mesh);
    return (sn_box){sn_scale(box.low, unit), sn_scale(box.high, unit)};
}

/* Grow `box` by another one that has been carried by a joint (SN_NONE: it has not). */
static void extend_by(sn_box *box, const sn_box *rest, const sn_rigid *poses, sn_index joint) {
    for (int corner = 0; corner < 8 && rest->low.x <= rest->high.x; corner++) {
        sn_vec3 p = sn_v3(corner & 1 ? rest->high.x : rest->low.x, corner & 2 ? rest->high.y : rest->low.y,
                          corner & 4 ? rest->high.z : rest->low.z);
        sn_box_add(box, joint == SN_NONE ? p : sn_rigid_apply(poses[joint], p));
    }
}

/* The joint that an attachment goes with; SN_NONE also where it is a surface. */
static sn_index joint_of(const sn_scene *scene, const sn_attachment *attachment) {
    sn_carrier carrier = sn_scene_carrier(scene, attachment->bone);
    if (carrier.kind == SN_CARRIER_JOINT) return carrier.index;
    return carrier.kind == SN_CARRIER_BONE ? scene->bones[carrier.index].joint : SN_NONE;
}

/* Where an attachment to a surface goes: everywhere that the surface's own vertices go, roughly. */
static void extend_by_surface(const reach_work *w, sn_index surface, const sn_surface_moment *at, sn_box *box) {
    const sn_scene_surface *s = &w->scene->surfaces[surface];
    sn_index n = s->envelope.mesh.vertex_count, step = n / 200 + 1;
    for (sn_index v = 0; v < n; v += step) sn_box_add(box, sn_scene_surface_vertex(s, at, v));
}

static sn_box muscle_box(const reach_work *w, sn_index muscle, const sn_surface_moment *at) {
    const sn_muscle *rig = &w->scene->muscles[muscle].rig;
    const sn_box *rest = &w->muscles[muscle];
    sn_box box = SN_EMPTY_BOX;
    for (sn_index i = 0; i < rig->attachment_count; i++) {
        sn_carrier carrier = sn_scene_carrier(w->scene, rig->attachments[i].bone);
        if (carrier.kind == SN_CARRIER_SURFACE)
            extend_by_surface(w, carrier.index, at, &box);
        else
            extend_by(&box, rest, at->poses, joint_of(w->scene, &rig->attachments[i]));
    }
    if (rig->attachment_count == 0) box = *rest;
    double room = ROOM * sn_box_diagonal(*rest);
    box.low = sn_sub(box.low, sn_v3(room, room, room));
    box.high = sn_add(box.high, sn_v3(room, room, room));
    return box;
}

/* ---- over the motion -------------------------------------------------------------------------------------------------------------- */

static bool takes_part(const sn_scene_muscle *muscle) { return muscle->enabled && !muscle->untouched; }

static void look_at_bone(const reach_work *w, sn_index b) {
    sn_box bone = SN_EMPTY_BOX;
    extend_by(&bone, &w->bones[b], w->poses, w->scene->bones[b].joint);
    for (sn_index i = 0; i < w->plan->muscle_count; i++) {
        bool *near = &w->plan->reach[(size_t)i * (size_t)w->plan->bone_count + (size_t)b];
        *near = *near || sn_boxes_meet(&w->swept[i], &bone);
    }
}

static void look(const reach_work *w, double time, double share) {
    const sn_scene *scene = w->scene;
    sn_motion_run_in_poses(&scene->motion, time, share, w->poses);
    const sn_surface_moment at = {w->poses, time, share};
    for (sn_index i = 0; i < scene->muscle_count; i++) w->swept[i] = takes_part(&scene->muscles[i]) ? muscle_box(w, i, &at) : SN_EMPTY_BOX;
    for (sn_index b = 0; b < scene->bone_count; b++)
        if (!scene->bones[b].passable) look_at_bone(w, b);
    sn_contact_surfaces_look(scene, &at, w->swept, w->plan);
}

/* From where to where something moves, s. */
typedef struct span {
    double begin, end;
} span;

static void extend_span(span *s, const double *times, sn_index count) {
    if (count == 0) return;
    s->begin = fmin(s->begin, times[0]);
    s->end = fmax(s->end, times[count - 1]);
}

static span span_of(const sn_scene *scene) {
    span all = {0.0, 0.0};
    for (sn_index j = 0; j < scene->motion.joint_count; j++) {
        const sn_joint *joint = &scene->motion.joints[j];
        extend_span(&all, joint->angle.times, joint->kind == SN_JOINT_HINGE ? joint->angle.count : 0);
        if (joint->kind == SN_JOINT_HINGE || joint->key_count == 0) continue;
        extend_span(&all, &joint->keys[0].time, 1);
        extend_span(&all, &joint->keys[joint->key_count - 1].time, 1);
    }
    for (sn_index i = 0; i < scene->surface_count; i++)
        extend_span(&all, scene->surfaces[i].track.times, scene->surfaces[i].track.sample_count);
    return all;
}

/* ---- moments at which something turns: a bone at its keys, a surface at its frames ------------------------------------------------------
 */

/* Of all joints and surfaces, ascending; owned by the caller. */
typedef struct turns {
    sn_index count;
    double *times;
} turns;

static void add_turns(turns *all, const double *times, sn_index count) {
    for (sn_index i = 0; i < count; i++, all->count++)
        if (all->times != NULL) all->times[all->count] = times[i];
}

/* Into all->times, or, NULL, counts alone. */
static void collect_turns(const sn_scene *scene, turns *all) {
    all->count = 0;
    for (sn_index j = 0; j < scene->motion.joint_count; j++) {
        const sn_joint *joint = &scene->motion.joints[j];
        if (joint->kind == SN_JOINT_HINGE) add_turns(all, joint->angle.times, joint->angle.count);
        for (sn_index k = 0; joint->kind != SN_JOINT_HINGE && k < joint->key_count; k++) add_turns(all, &joint->keys[k].time, 1);
    }
    for (sn_index i = 0; i < scene->surface_count; i++)
        if (scene->surfaces[i].solid) add_turns(all, scene->surfaces[i].track.times, scene->surfaces[i].track.sample_count);
}

static int compare_times(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Each time once. */
static sn_status find_turns(const sn_scene *scene, turns *all, sn_error *error) {
    *all = (turns){0};
    collect_turns(scene, all);
    if ((all->times = SN_NEW(double, all->count)) == NULL) return sn_fail_memory(error, "contact");
    collect_turns(scene, all);
    qsort(all->times, (size_t)all->count, sizeof *all->times, compare_times);
    sn_index count = 0;
    for (sn_index i = 0; i < all->count; i++)
        if (count == 0 || all->times[i] != all->times[count - 1]) all->times[count++] = all->times[i];
    all->count = count;
    return SN_OK;
}

/* Evenly, and where something turns: what comes near for a frame alone is seen at any rate. */
static sn_status look_through(const reach_work *w, sn_error *error) {
    turns at;
    sn_status status = find_turns(w->scene, &at, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < at.count && i < MOST_LOOKS; i++) look(w, at.times[i], 1.0);
    free(at.times);
    span all = span_of(w->scene);
    double looks = fmin(ceil((all.end - all.begin) * LOOKS_A_SECOND), MOST_LOOKS);
    for (double i = 0.0; i < looks; i++) look(w, all.begin + (all.end - all.begin) * i / looks, 1.0);
    look(w, all.end, 1.0);
    for (int i = 0; w->scene->run_in > 0.0 && i < RUN_IN_PLACES * RUN_IN_SHARES; i++)
        look(w, all.begin + (all.end - all.begin) * (i / RUN_IN_SHARES) / RUN_IN_PLACES, i % RUN_IN_SHARES / (double)RUN_IN_SHARES);
    return SN_OK;
}

/* ---- fields ----------------------------------------------------------------------------------------------------------------------- */

/* The finest mean edge of the muscles that a bone comes near; 0 = none. */
static double finest_edge(const reach_work *w, sn_index bone) {
    double finest = 0.0;
    for (sn_index i = 0; i < w->plan->muscle_count; i++)
        if (w->plan->reach[(size_t)i * (size_t)w->plan->bone_count + (size_t)bone] && (finest == 0.0 || w->edges[i] < finest))
            finest = w->edges[i];
    return finest;
}

/* In metres, in its rest place. */
static sn_status scaled_mesh(const sn_scene_bone *bone, sn_mesh *out, sn_error *error) {
    sn_status status = sn_mesh_copy(&bone->mesh, out, error);
    for (sn_index v = 0; status == SN_OK && v < out->vertex_count; v++)
        out->positions[v] = sn_scale(out->positions[v], bone->meters_per_unit);
    return status;
}

/* As the scene says, or fine enough for the muscles and the bone, but no finer than is of use. */
static double choose_cell(const reach_work *w, sn_index bone, double edge) {
    double told = w->scene->contact.cell, thickness = w->plan->thickness[bone], cell = edge / CELLS_PER_EDGE;
    if (told > 0.0) return told;
    if (thickness > 0.0) cell = fmin(cell, thickness / CELLS_PER_THICKNESS);
    return fmax(fmax(cell, sn_box_diagonal(w->bones[bone]) / MOST_CELLS), LEAST_CELL);
}

/* From its mesh in metres. */
static sn_status take_field(const reach_work *w, const sn_model_options *options, sn_index bone, const sn_mesh *mesh, double edge,
                            sn_error *error) {
    const sn_scene_bone *source = &w->scene->bones[bone];
    w->plan->thickness[bone] = sn_thickness(sn_mesh_volume(mesh), sn_mesh_area(mesh));
    sn_distance_field_params params = sn_distance_field_defaults(choose_cell(w, bone, edge));
    params.pool = options->pool;
    sn_status status = options->fields != NULL ? options->fields(options->user, source, mesh, &params, &w->plan->fields[bone], error)
                                               : sn_distance_field_create(mesh, &params, &w->plan->fields[bone], error);
    if (status == SN_OK && w->plan->voxels != NULL) status = sn_contact_voxels_make(w->scene, mesh, &w->plan->voxels[bone], error);
    return status;
}

static sn_status make_field(const reach_work *w, const sn_model_options *options, sn_index bone, double edge, sn_error *error) {
    sn_mesh mesh = {0};
    sn_status status = scaled_mesh(&w->scene->bones[bone], &mesh, error);
    if (status == SN_OK) status = sn_mesh_warn_of_sides(&mesh, w->scene->bones[bone].name, error);
    if (status == SN_OK) status = take_field(w, options, bone, &mesh, edge, error);
    sn_mesh_free(&mesh);
    if (status == SN_OK || error == NULL) return status;
    sn_error why = *error;
    return sn_fail(error, status, "bone \"%s\": %s", w->scene->bones[bone].name, why.text);
}

static sn_status make_fields(const reach_work *w, const sn_model_options *options, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index b = 0; b < w->plan->bone_count && status == SN_OK; b++) {
        double edge = finest_edge(w, b);
        if (edge > 0.0) status = make_field(w, options, b, edge, error);
    }
    return status;
}

/* ---- the whole ---------------------------------------------------------------------------------------------------------------------- */

static sn_status check_meshes(const sn_scene *scene, sn_error *error) {
    for (sn_index b = 0; b < scene->bone_count; b++)
        if (!scene->bones[b].passable && scene->bones[b].mesh.triangle_count == 0)
            return sn_fail(error, SN_ERROR_INPUT,
                           "bone \"%s\" has no surface to touch; give it one, or leave it out of contact with \"contact\": false",
                           scene->bones[b].name);
    return SN_OK;
}

static bool make_room(reach_work *w) {
    struct sn_contact_plan *plan = w->plan;
    plan->muscle_count = w->scene->muscle_count;
    plan->bone_count = w->scene->bone_count;
    return (plan->reach = SN_NEW(bool, (size_t)plan->muscle_count *(size_t)plan->bone_count)) &&
           (plan->fields = SN_NEW(sn_distance_field, plan->bone_count)) && (plan->thickness = SN_NEW(double, plan->bone_count)) &&
           (sn_scene_collision(w->scene) != SN_COLLISION_VOXEL || (plan->voxels = SN_NEW(sn_voxels, plan->bone_count))) &&
           (w->bones = SN_NEW(sn_box, plan->bone_count)) && (w->muscles = SN_NEW(sn_box, plan->muscle_count)) &&
           (w->swept = SN_NEW(sn_box, plan->muscle_count)) && (w->edges = SN_NEW(double, plan->muscle_count)) &&
           (w->poses = SN_NEW(sn_rigid, w->scene->motion.joint_count));
}

static void measure_rest(reach_work *w) {
    for (sn_index b = 0; b < w->plan->bone_count; b++) w->bones[b] = mesh_box(&w->scene->bones[b].mesh, w->scene->bones[b].meters_per_unit);
    for (sn_index i = 0; i < w->plan->muscle_count; i++) {
        const sn_muscle *rig = &w->scene->muscles[i].rig;
        w->muscles[i] = mesh_box(&rig->mesh, rig->meters_per_unit);
        w->edges[i] = rig->meters_per_unit * sn_mesh_mean_side(&rig->mesh);
    }
}

sn_status sn_contact_plan_create(const sn_scene *scene, const sn_model_options *options, struct sn_contact_plan **out, sn_error *error) {
    *out = NULL;
    if (!scene->contact.enabled) return SN_OK;
    sn_status status = check_meshes(scene, error);
    if (status != SN_OK) return status;
    reach_work w = {.scene = scene, .plan = SN_NEW(struct sn_contact_plan, 1)};
    if (w.plan == NULL || !make_room(&w)) status = sn_fail_memory(error, "contact");
    if (status == SN_OK) status = sn_contact_surfaces_make(scene, w.plan, error);
    if (status == SN_OK) {
        measure_rest(&w);
        status = look_through(&w, error);
    }
    if (status == SN_OK) status = make_fields(&w, options, error);
    free(w.bones);
    free(w.muscles);
    free(w.swept);
    free(w.edges);
    free(w.poses);
    if (status == SN_OK)
        *out = w.plan;
    else
        sn_contact_plan_destroy(w.plan);
    return status;
}

const sn_distance_field *sn_model_field(const sn_model *model, sn_index bone) {
    const struct sn_contact_plan *plan = model->contact;
    return plan != NULL && plan->fields[bone].values != NULL ? &plan->fields[bone] : NULL;
}

const sn_voxels *sn_model_voxels(const sn_model *model, sn_index bone) {
    const struct sn_contact_plan *plan = model->contact;
    return plan != NULL && plan->voxels != NULL && plan->voxels[bone].marked != NULL ? &plan->voxels[bone] : NULL;
}

void sn_contact_plan_destroy(struct sn_contact_plan *plan) {
    if (plan == NULL) return;
    for (sn_index b = 0; plan->fields != NULL && b < plan->bone_count; b++) sn_distance_field_free(&plan->fields[b]);
    for (sn_index b = 0; plan->voxels != NULL && b < plan->bone_count; b++) sn_voxels_free(&plan->voxels[b]);
    sn_contact_surfaces_free(plan);
    free(plan->fields);
    free(plan->voxels);
    free(plan->reach);
    free(plan->thickness);
    free(plan);
}
