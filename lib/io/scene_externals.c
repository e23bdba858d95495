/*
 * scene_externals.c -- the external constraints of a scene document: true, or { "stiffness", "slide", "soft", "hard", "minimum", "resolve"
 * }; false of a muscle leaves out its own, and those of others to it.
 */
#include "scene_externals.h"

/* "slide": false leaves such rows out; so does "externals" of a muscle. */
static sn_status parse_type(const sn_json_value *object, const char *name, bool *left_out, sn_error *error) {
    sn_json_value value = sn_json_member(object, name);
    bool acts = !*left_out;
    sn_status status = sn_json_get_bool(&value, &acts, error);
    *left_out = !acts;
    return status;
}

sn_status sn_scene_externals_parse(const sn_json_value *value, sn_external_settings *out, sn_error *error) {
    static const char *const known[] = {"enabled", "stiffness", "slide", "soft", "hard", "minimum", "resolve", NULL};
    if (!sn_json_has(value)) return SN_OK;
    if (sn_json_is_bool(value)) return sn_json_get_bool(value, &out->enabled, error);
    sn_json_value enabled = sn_json_member(value, "enabled"), stiffness = sn_json_member(value, "stiffness"),
                  resolve = sn_json_member(value, "resolve");
    out->enabled = true;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_bool(&enabled, &out->enabled, error);
    if (status == SN_OK) status = sn_json_get_number(&stiffness, 0.0, 1e12, &out->stiffness, error);
    if (status == SN_OK) status = sn_json_get_number(&resolve, 0.0, 1e6, &out->resolve, error);
    if (status == SN_OK) status = parse_type(value, "slide", &out->no_slide, error);
    if (status == SN_OK) status = parse_type(value, "soft", &out->no_soft, error);
    if (status == SN_OK) status = parse_type(value, "hard", &out->no_hard, error);
    if (status == SN_OK) status = parse_type(value, "minimum", &out->no_minimum, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

sn_status sn_scene_externals_left_out(const sn_json_value *object, bool *left_out, sn_error *error) {
    return parse_type(object, "externals", left_out, error);
}

void sn_scene_externals_write(const sn_scene *scene, sn_json *json) {
    const sn_external_settings *externals = &scene->externals;
    if (!externals->enabled) {
        sn_json_bool(json, "externals", false);
        return;
    }
    sn_json_object(json, "externals");
    sn_json_number(json, "stiffness", externals->stiffness);
    sn_json_bool(json, "slide", !externals->no_slide);
    sn_json_bool(json, "soft", !externals->no_soft);
    sn_json_bool(json, "hard", !externals->no_hard);
    sn_json_bool(json, "minimum", !externals->no_minimum);
    sn_json_number(json, "resolve", externals->resolve);
    sn_json_close(json);
}
