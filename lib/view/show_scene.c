/* show_scene.c -- a scene at a time: posed bones, muscles at rest or deformed, redder the more they are active. */
#include "show.h"

#include <stdlib.h>
#include <string.h>

static sn_color activation_color(double activation) {
    const sn_color a = COLOR_RELAXED, b = COLOR_ACTIVE;
    return (sn_color){a.r + (b.r - a.r) * activation, a.g + (b.g - a.g) * activation, a.b + (b.b - a.b) * activation};
}

/* ---- bones ------------------------------------------------------------------------------------------------------------------ */

/* By the bone's own name, or by that of the joint that it moves with. */
static bool is_attached(const sn_scene *scene, const sn_muscle *rig, sn_index bone) {
    const sn_scene_bone *b = &scene->bones[bone];
    const char *joint = b->joint == SN_NONE ? NULL : scene->motion.joints[b->joint].name;
    for (sn_index i = 0; i < rig->attachment_count; i++) {
        const char *name = rig->attachments[i].bone;
        if (strcmp(name, b->name) == 0 || (joint && strcmp(name, joint) == 0)) return true;
    }
    return false;
}

static bool has_attached(const sn_scene *scene, sn_index bone) {
    for (sn_index m = 0; m < scene->muscle_count; m++)
        if (scene->muscles[m].enabled && is_attached(scene, &scene->muscles[m].rig, bone)) return true;
    return false;
}

bool sn_view_draws_bone(const sn_scene *scene, sn_index bone, unsigned show) {
    if (show & SN_SHOW_ALL_BONES || has_attached(scene, bone)) return true;
    sn_index other = 0;
    while (other < scene->bone_count && !has_attached(scene, other)) other++;
    return other == scene->bone_count;
}

/* Bones are drawn before muscles, and have the colours of what is attached to them. */
static sn_status take_colors(sn_view *view, const sn_scene *scene, sn_error *error) {
    sn_status status = SN_OK;
    view->attachments_shown = true;
    for (sn_index m = 0; m < scene->muscle_count; m++)
        for (sn_index i = 0; i < scene->muscles[m].rig.attachment_count && scene->muscles[m].enabled && !status; i++) {
            sn_color color;
            status = sn_palette_color(palette_of(view), scene->muscles[m].rig.attachments[i].bone, &color, error);
        }
    return status;
}

static sn_status show_scene_bone(sn_view *view, const sn_scene_bone *bone, const sn_rigid *pose, sn_error *error) {
    sn_status status = sn_view_add_bone(view, NULL, &bone->mesh, (sn_placement){bone->meters_per_unit, pose}, error);
    if (status) return status;
    view->meshes[view->mesh_count - 1].color = bone_color(view, bone->name);
    return name_mesh(view, bone->name, error);
}

sn_status show_bones(sn_view *view, const sn_scene *scene, double time, unsigned show, sn_error *error) {
    sn_rigid *poses = SN_NEW(sn_rigid, scene->motion.joint_count);
    if (!poses) return sn_fail_memory(error, "the bones' poses");
    sn_motion_poses(&scene->motion, time, poses);
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->bone_count && !status; i++) {
        const sn_scene_bone *bone = &scene->bones[i];
        if (bone->mesh.triangle_count == 0 || !sn_view_draws_bone(scene, i, show)) continue;
        status = show_scene_bone(view, bone, bone->joint == SN_NONE ? NULL : &poses[bone->joint], error);
    }
    free(poses);
    return status;
}

/* ---- surfaces --------------------------------------------------------------------------------------------------------------- */

static const double SHEER = 0.22; /* opacity of surfaces that lie over muscles */
static const sn_color COLOR_ENVELOPE = {0.45, 0.62, 0.72};

static sn_status show_envelope(sn_view *view, const sn_scene_surface *surface, const sn_surface_moment *at, bool wire, sn_error *error) {
    sn_mesh mesh = surface->envelope.mesh;
    sn_view_mesh *shown = NULL;
    if ((mesh.positions = SN_NEW(sn_vec3, mesh.vertex_count)) == NULL) return sn_fail_memory(error, "an envelope");
    sn_scene_surface_positions(surface, at, NULL, mesh.positions);
    sn_status status = sn_view_add_mesh(view, &mesh, (sn_placement){1.0, NULL}, COLOR_ENVELOPE, &shown, error);
    if (!status) shown->opacity = SHEER, shown->wire = wire;
    if (!status) status = name_mesh(view, surface->name, error);
    free(mesh.positions);
    return status ? status : sn_view_add_entry(view, SN_MARK_AREA, COLOR_ENVELOPE, surface->name, error);
}

sn_status show_envelopes(sn_view *view, const sn_scene *scene, double time, bool wire, sn_error *error) {
    sn_rigid *poses = SN_NEW(sn_rigid, scene->motion.joint_count);
    if (!poses) return sn_fail_memory(error, "the joints' poses");
    sn_motion_poses(&scene->motion, time, poses);
    const sn_surface_moment at = {poses, time, 1.0};
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->surface_count && !status; i++)
        if (scene->surfaces[i].loaded && scene->surfaces[i].envelope.mesh.triangle_count > 0)
            status = show_envelope(view, &scene->surfaces[i], &at, wire, error);
    free(poses);
    return status;
}

/* The rig with other vertices, in metres; it borrows all it keeps. Samples and directions belong to the rest shape: it has none. Fibres
 * through the volume are the frame's, in metres too. */
static sn_muscle deformed_rig(const sn_muscle *rig, const sn_vec3 *positions) {
    sn_muscle deformed = *rig;
    deformed.mesh.positions = (sn_vec3 *)(uintptr_t)positions; /* only read */
    deformed.meters_per_unit = 1.0;
    deformed.structure = (sn_structure){0};
    deformed.fibers = (sn_fibers){.polylines = rig->fibers.polylines, .polyline_count = rig->fibers.polyline_count};
    return deformed;
}

static sn_status show_muscle_at(sn_view *view, const sn_scene_muscle *muscle, double time, const sn_vec3 *positions, unsigned show,
                                sn_error *error) {
    sn_muscle rig = positions ? deformed_rig(&muscle->rig, positions) : muscle->rig;
    rig.name = muscle->name; /* only read */
    double activation = fmin(fmax(sn_muscle_activation(muscle, time), 0.0), 1.0);
    return show_rig(view, &rig, show, activation_color(activation), error);
}

sn_status sn_view_add_scene(sn_view *view, const sn_scene *scene, double time, const sn_vec3 *const *positions, unsigned show,
                            sn_error *error) {
    if (show & SN_SHOW_AUTO) show |= SN_SHOW_SURFACE | SN_SHOW_BONES | SN_SHOW_ENVELOPES;
    const unsigned of_scene = SN_SHOW_BONES | SN_SHOW_ENVELOPES | SN_SHOW_FIELDS | SN_SHOW_ALL_BONES;
    if (!view->title && scene->name && !(view->title = sn_strdup(scene->name))) return sn_fail_memory(error, "the title");
    sn_status status = show & SN_SHOW_ATTACHMENTS ? take_colors(view, scene, error) : SN_OK;
    if (!status && show & SN_SHOW_BONES) status = show_bones(view, scene, time, show, error);
    if (!status && show & SN_SHOW_FIELDS) status = show_distance_fields(view, scene, time, error);
    if (!status && show & SN_SHOW_ENVELOPES) status = show_envelopes(view, scene, time, (show & SN_SHOW_WIRE) != 0, error);
    bool shown = false;
    for (sn_index i = 0; i < scene->muscle_count && show & ~of_scene && !status; i++) {
        if (!scene->muscles[i].enabled) continue;
        shown = true;
        status = show_muscle_at(view, &scene->muscles[i], time, positions ? positions[i] : NULL, show, error);
    }
    if (!status && shown) status = sn_view_add_entry(view, SN_MARK_AREA, COLOR_RELAXED, "relaxed", error);
    if (!status && shown) status = sn_view_add_entry(view, SN_MARK_AREA, COLOR_ACTIVE, "active", error);
    return status;
}
