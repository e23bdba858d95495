/* bone_document.c -- bones in scene and motion documents: { "name", "mesh", "units", "joint" }. */
#include "motion_document.h"

#include <stdlib.h>
#include <string.h>

/* ---- reading ---------------------------------------------------------------------------------------------------------- */

sn_status sn_units_parse(const sn_json_value *value, double *out, sn_error *error) {
    if (sn_json_has(value) && !sn_json_is_text(value)) return sn_json_get_number(value, SN_JSON_POSITIVE, INFINITY, out, error);
    static const char *const names[] = {"m", "cm", "mm", "um", "in", "ft", NULL};
    static const double meters[] = {1.0, 0.01, 0.001, 1e-6, 0.0254, 0.3048};
    int choice = -1;
    sn_status status = sn_json_get_choice(value, names, &choice, error);
    if (status == SN_OK && choice >= 0) *out = meters[choice];
    return status;
}

static sn_status parse_joint(const sn_json_value *value, const sn_motion *motion, sn_index *out, sn_error *error) {
    char *name = NULL;
    sn_status status = sn_json_get_text(value, &name, error);
    if (status != SN_OK || name == NULL) return status;
    for (sn_index i = 0; i < motion->joint_count && *out == SN_NONE; i++)
        if (strcmp(motion->joints[i].name, name) == 0) *out = i;
    if (*out == SN_NONE) status = sn_json_complain(value, error, "the motion has no joint \"%s\"", name);
    free(name);
    return status;
}

sn_status sn_bone_parse(const sn_json_value *value, const char *const *known, const sn_motion *motion, sn_motion_bone *out,
                        sn_error *error) {
    sn_json_value name = sn_json_member(value, "name"), mesh = sn_json_member(value, "mesh"), units = sn_json_member(value, "units"),
                  joint = sn_json_member(value, "joint");
    *out = (sn_motion_bone){.joint = SN_NONE};
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&name, "the name of the bone", error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_require(&mesh, "the file of the bone's surface", error);
    if (status == SN_OK) status = sn_json_get_text(&mesh, &out->path, error);
    if (status == SN_OK) status = sn_units_parse(&units, &out->meters_per_unit, error);
    if (status == SN_OK) status = parse_joint(&joint, motion, &out->joint, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

/* The mesh is named from the document, and found from the working directory. */
static sn_status locate(const sn_json_value *bone, sn_motion_bone *out, sn_error *error) {
    char *path = sn_path_beside(sn_json_name(bone->tree), out->path);
    if (path == NULL) return sn_fail_memory(error, "a path");
    free(out->path);
    out->path = path;
    return SN_OK;
}

sn_status sn_motion_bones_parse(const sn_json_value *list, sn_motion *motion, sn_error *error) {
    static const char *const known[] = {"name", "mesh", "units", "joint", NULL};
    if (!sn_json_has(list)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(list, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((motion->bones = SN_NEW(sn_motion_bone, count)) == NULL) return sn_fail_memory(error, "bones");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value bone = sn_json_element(list, i);
        motion->bone_count = i + 1;
        status = sn_bone_parse(&bone, known, motion, &motion->bones[i], error);
        if (status == SN_OK) status = locate(&bone, &motion->bones[i], error);
    }
    return status;
}

/* ---- the surface ------------------------------------------------------------------------------------------------------ */

/* What is wrong with its file, and whose it is. */
static sn_status bone_fail(const sn_motion_bone *bone, const sn_error *why, sn_status status, sn_error *error) {
    sn_fail_at(error, status, why->file[0] != '\0' ? why->file : bone->path, why->line, "bone \"%s\": %s", bone->name, why->text);
    return status;
}

sn_status sn_motion_bone_load(const sn_motion_bone *bone, double fallback, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    sn_error why = {0};
    *out = (sn_mesh){0};
    *frame = (sn_mesh_frame){0};
    sn_status status = sn_file_check(bone->path, &why);
    if (status == SN_OK) status = sn_mesh_read(bone->path, out, frame, &why);
    if (status == SN_OK) status = sn_mesh_validate(out, &why);
    if (status != SN_OK) {
        sn_mesh_free(out);
        return bone_fail(bone, &why, status, error);
    }
    sn_mesh_convert(out, 1.0, frame->up == SN_UP_Y);
    frame->up = SN_UP_Z;
    if (bone->meters_per_unit > 0.0) frame->meters_per_unit = bone->meters_per_unit;
    if (!(frame->meters_per_unit > 0.0)) frame->meters_per_unit = fallback;
    return SN_OK;
}

/* ---- writing ---------------------------------------------------------------------------------------------------------- */

/* One bone: its mesh from a document at `document`. */
static sn_status write_bone(const sn_motion_bone *bone, const sn_motion *motion, const char *document, sn_json *json, sn_error *error) {
    char *uri = sn_path_from(document, bone->path);
    if (uri == NULL) return sn_fail_memory(error, "a path");
    sn_json_object_line(json, NULL);
    sn_json_text(json, "name", bone->name);
    sn_json_text(json, "mesh", uri);
    if (bone->meters_per_unit > 0.0) sn_json_number(json, "units", bone->meters_per_unit);
    if (bone->joint != SN_NONE) sn_json_text(json, "joint", motion->joints[bone->joint].name);
    sn_json_close(json);
    free(uri);
    return SN_OK;
}

sn_status sn_motion_bones_write(const sn_motion *motion, const char *document, sn_json *json, sn_error *error) {
    sn_status status = SN_OK;
    if (motion->bone_count == 0) return SN_OK;
    sn_json_array(json, "bones");
    for (sn_index b = 0; b < motion->bone_count && status == SN_OK; b++)
        status = write_bone(&motion->bones[b], motion, document, json, error);
    sn_json_close(json);
    return status;
}
