/*
 * scene_contact.c -- the contact of a scene document: true, or { "margin", "cell", "friction", "resolve", "samples", "collision", "voxels",
 * "voxelsTotal", "boneHits" }; false of a bone or a muscle leaves it out.
 */
#include "scene_contact.h"
#include "sinew/voxels.h"

static sn_status parse_samples(const sn_json_value *value, sn_index *out, sn_error *error) {
    sn_index count = *out;
    sn_status status = sn_json_get_index(value, 0, 3, &count, error);
    if (status == SN_OK && count == 2) return sn_json_complain(value, error, "expected 0, 1 or 3 points in a triangle, found 2");
    *out = count;
    return status;
}

static sn_status parse_voxels(const sn_json_value *object, sn_contact_settings *out, sn_error *error) {
    sn_json_value collision_name = sn_json_member(object, "collision"), hits_name = sn_json_member(object, "boneHits"),
                  voxels = sn_json_member(object, "voxels"), total = sn_json_member(object, "voxelsTotal");
    int collision = (int)out->collision, hits = (int)out->bone_hits;
    sn_status status = sn_json_get_choice(&collision_name, sn_collision_names, &collision, error);
    if (status == SN_OK) status = sn_json_get_choice(&hits_name, sn_bone_hits_names, &hits, error);
    if (status == SN_OK) status = sn_json_get_index(&voxels, 1, SN_MOST_VOXELS_ALONG, &out->voxels, error);
    if (status == SN_OK) status = sn_json_get_index(&total, 1, SN_MOST_VOXELS, &out->voxels_total, error);
    out->collision = (sn_collision)collision;
    out->bone_hits = (sn_bone_hits)hits;
    return status;
}

sn_status sn_contact_parse(const sn_json_value *value, sn_contact_settings *out, sn_error *error) {
    static const char *const known[] = {"enabled",   "margin", "cell",        "friction", "resolve", "samples",
                                        "collision", "voxels", "voxelsTotal", "boneHits", NULL};
    if (!sn_json_has(value)) return SN_OK;
    if (sn_json_is_bool(value)) return sn_json_get_bool(value, &out->enabled, error);
    sn_json_value enabled = sn_json_member(value, "enabled"), margin = sn_json_member(value, "margin"),
                  cell = sn_json_member(value, "cell"), friction = sn_json_member(value, "friction"),
                  resolve = sn_json_member(value, "resolve"), samples = sn_json_member(value, "samples");
    out->enabled = true;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_bool(&enabled, &out->enabled, error);
    if (status == SN_OK) status = sn_json_get_number(&margin, SN_JSON_POSITIVE, INFINITY, &out->margin, error);
    if (status == SN_OK) status = sn_json_get_number(&cell, SN_JSON_POSITIVE, INFINITY, &out->cell, error);
    if (status == SN_OK) status = sn_json_get_number(&friction, 0.0, INFINITY, &out->friction, error);
    if (status == SN_OK) status = sn_json_get_number(&resolve, 0.0, INFINITY, &out->resolve, error);
    if (status == SN_OK) status = parse_samples(&samples, &out->samples, error);
    if (status == SN_OK) status = parse_voxels(value, out, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

sn_status sn_contact_left_out_parse(const sn_json_value *object, bool *left_out, sn_error *error) {
    sn_json_value value = sn_json_member(object, "contact");
    bool takes_part = !*left_out;
    sn_status status = sn_json_get_bool(&value, &takes_part, error);
    *left_out = !takes_part;
    return status;
}

static void write_voxels(const sn_contact_settings *contact, sn_json *json) {
    if (contact->voxels_total > 0)
        sn_json_integer(json, "voxelsTotal", contact->voxels_total);
    else
        sn_json_integer(json, "voxels", contact->voxels > 0 ? contact->voxels : SN_DEFAULT_VOXELS);
    sn_json_text(json, "boneHits", sn_bone_hits_names[contact->bone_hits]);
}

void sn_contact_write(const sn_scene *scene, sn_json *json) {
    const sn_contact_settings *contact = &scene->contact;
    sn_collision collision = sn_scene_collision(scene);
    if (!contact->enabled) {
        sn_json_bool(json, "contact", false);
        return;
    }
    sn_json_object(json, "contact");
    if (contact->margin > 0.0) sn_json_number(json, "margin", contact->margin);
    if (contact->cell > 0.0) sn_json_number(json, "cell", contact->cell);
    sn_json_number(json, "friction", contact->friction);
    sn_json_number(json, "resolve", contact->resolve);
    sn_json_integer(json, "samples", contact->samples);
    sn_json_text(json, "collision", sn_collision_names[collision]);
    if (collision == SN_COLLISION_VOXEL) write_voxels(contact, json);
    sn_json_close(json);
}
