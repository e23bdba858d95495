/*
 * section_view.c -- candidates for external constraints as rig-view draws them: which rigs they lie on, and where a section goes.
 */
#include "section_view.h"

#include <stdlib.h>
#include <string.h>

void rigs_free(rig_list *rigs) {
    for (size_t i = 0; i < rigs->files.count; i++) {
        if (rigs->muscles) sn_muscle_free(&rigs->muscles[i]);
        if (rigs->names) free(rigs->names[i]);
    }
    free(rigs->muscles);
    free(rigs->names);
    bones_free(&rigs->files);
    *rigs = (rig_list){0};
}

static sn_status load_rig(const cli *c, const bone *file, sn_muscle *out, char **name, sn_error *error) {
    sn_document *document = NULL;
    sn_blob blob = {0};
    sn_read_options options = c->read;
    options.mesh = NULL;
    options.asked = false; /* what was asked for is the input's */
    sn_status status = sn_blob_read(file->file, &blob, error);
    if (status == SN_OK) status = sn_muscle_parse(&blob, &options, out, &document, error);
    if (status != SN_OK) sn_error_set_file(error, file->file);
    sn_blob_free(&blob);
    sn_document_free(document);
    if (status == SN_OK) *name = sn_strdup(file->named || out->name == NULL ? file->name : out->name);
    return status == SN_OK && *name == NULL ? sn_fail_memory(error, "the neighbours") : status;
}

sn_status rigs_load(const cli *c, const cli_list *lists, rig_list *out, sn_error *error) {
    static const cli_list none = {0};
    out->files.rigs = true;
    sn_status status = bones_name(c, &none, lists, &out->files, error);
    if (status != SN_OK) return status;
    out->muscles = SN_NEW(sn_muscle, out->files.count);
    out->names = SN_NEW(char *, out->files.count);
    if (out->muscles == NULL || out->names == NULL) return sn_fail_memory(error, "the neighbours");
    for (size_t i = 0; i < out->files.count && status == SN_OK; i++)
        status = load_rig(c, &out->files.items[i], &out->muscles[i], &out->names[i], error);
    return status;
}

/* items (count of files) is the caller's. */
static sn_view_targets list_targets(const rig_list *rigs, sn_view_target *items) {
    for (size_t i = 0; i < rigs->files.count; i++)
        items[i] = (sn_view_target){rigs->names[i], &rigs->muscles[i].mesh, rigs->muscles[i].meters_per_unit};
    return (sn_view_targets){(sn_index)rigs->files.count, items};
}

sn_status rows_add(sn_view *view, const sn_muscle *muscle, const rig_list *rigs, sn_error *error) {
    sn_view_target *items = SN_NEW(sn_view_target, rigs->files.count);
    if (items == NULL) return sn_fail_memory(error, "the neighbours");
    const sn_view_targets targets = list_targets(rigs, items);
    sn_status status = sn_view_add_externals(view, muscle, &targets, error);
    free(items);
    return status;
}

/* ---- the section --------------------------------------------------------------------------------------------------------------- */

/* 0, 1, 2 for x, y, z; -1 = none of them. */
static int axis_of(const char *plane) {
    static const char axes[] = "xyz";
    const char *axis = plane[0] != '\0' && plane[1] == '\0' ? strchr(axes, plane[0]) : NULL;
    return axis != NULL ? (int)(axis - axes) : -1;
}

void section_check(const cli *c, const char *plane, sn_length depth) {
    double n[6];
    if (plane == NULL && depth.value >= 0.0) cli_usage_error(c, "--cut-depth needs --cut");
    if (plane == NULL || axis_of(plane) >= 0) return;
    if (sn_parse_numbers(plane, 6, n, NULL) != SN_OK || !(sn_norm(sn_v3(n[3], n[4], n[5])) > 0.0))
        cli_usage_error(c, "--cut: '%s' is no plane; write px,py,pz,nx,ny,nz, a point and a normal, or x, y or z", plane);
}

sn_camera section_camera(const char *plane) {
    double n[6];
    int axis = axis_of(plane);
    sn_camera camera = sn_camera_from(0.0, 0.0);
    sn_vec3 back = sn_v3(axis == 0, axis == 1, axis == 2);
    if (axis < 0 && sn_parse_numbers(plane, 6, n, NULL) == SN_OK) back = sn_normalize(sn_v3(n[3], n[4], n[5]));
    sn_vec3 up = fabs(back.z) < 0.99 ? sn_v3(0, 0, 1) : sn_v3(0, 1, 0);
    camera.back = back;
    camera.right = sn_normalize(sn_cross(up, back));
    camera.up = sn_cross(back, camera.right);
    return camera;
}

static void set_plane(const sn_muscle *muscle, const section_request *request, sn_view_section *section) {
    double n[6];
    int axis = axis_of(request->plane);
    sn_box box = sn_mesh_box(&muscle->mesh);
    section->point = sn_scale(sn_add(box.low, box.high), 0.5 * muscle->meters_per_unit);
    section->normal = sn_v3(axis == 0, axis == 1, axis == 2);
    if (axis >= 0 || sn_parse_numbers(request->plane, 6, n, NULL) != SN_OK) return;
    section->point = sn_scale(sn_v3(n[0], n[1], n[2]), muscle->meters_per_unit);
    section->normal = sn_v3(n[3], n[4], n[5]);
}

static sn_view_targets list_bones(const sn_muscle *muscle, const bone_list *bones, sn_view_target *items) {
    for (size_t i = 0; i < bones->count; i++) {
        const bone *b = &bones->items[i];
        items[i] = (sn_view_target){b->name, &b->mesh, b->own_unit > 0.0 ? b->own_unit : muscle->meters_per_unit};
    }
    return (sn_view_targets){(sn_index)bones->count, items};
}

sn_status section_add(sn_view *view, const sn_muscle *muscle, const section_request *request, sn_error *error) {
    sn_view_target *items = SN_NEW(sn_view_target, request->rigs->files.count), *bones = SN_NEW(sn_view_target, request->bones->count);
    double depth = cli_length(request->depth, muscle->meters_per_unit);
    sn_view_section section = {.muscle = muscle};
    sn_status status = items && bones ? SN_OK : sn_fail_memory(error, "the section");
    if (status == SN_OK && muscle->name != NULL && (view->title = sn_strdup(muscle->name)) == NULL)
        status = sn_fail_memory(error, "the title");
    if (status == SN_OK) {
        const sn_view_targets targets = list_targets(request->rigs, items), skeleton = list_bones(muscle, request->bones, bones);
        section.targets = &targets;
        section.bones = &skeleton;
        section.depth = (depth >= 0.0 ? depth : sn_mesh_mean_side(&muscle->mesh)) * muscle->meters_per_unit;
        set_plane(muscle, request, &section);
        status = sn_view_add_section(view, &section, error);
    }
    free(items);
    free(bones);
    return status;
}
