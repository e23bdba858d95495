/*
 * contacts.c -- contact of muscles with bones, as simulate takes and tells it.
 */
#include "contacts.h"

#include "sinew/distance_field.h"
#include "sinew/io.h"

bool contacts_wanted(const cli *c, const contact_choices *given) {
    static const char *const of_contact[] = {"margin", "grid-cell", "grid-cache", "friction", "resolve", "contact-samples"};
    if (given->on && given->off) cli_usage_error(c, "--contact and --no-contact exclude each other");
    for (size_t i = 0; given->off && i < sizeof of_contact / sizeof *of_contact; i++)
        if (cli_given(c, of_contact[i])) cli_usage_error(c, "--no-contact and --%s exclude each other", of_contact[i]);
    if (cli_given(c, "contact-samples") && given->samples == 2) cli_usage_error(c, "--contact-samples is 0, 1 or 3");
    return given->on;
}

void contacts_apply(const cli *c, const contact_choices *given, sn_scene *scene) {
    sn_contact_settings *contact = &scene->contact;
    if (given->on) contact->enabled = true;
    if (given->off) contact->enabled = false;
    if (cli_given(c, "margin")) contact->margin = sn_length_meters(given->margin, 1.0);
    if (cli_given(c, "grid-cell")) contact->cell = sn_length_meters(given->cell, 1.0);
    if (cli_given(c, "friction")) contact->friction = given->friction;
    if (cli_given(c, "resolve")) contact->resolve = given->resolve;
    if (cli_given(c, "contact-samples")) contact->samples = (sn_index)given->samples;
    static const char *const idle[] = {"margin", "grid-cell", "grid-cache", "friction", "resolve", "contact-samples"};
    for (size_t i = 0; !contact->enabled && i < sizeof idle / sizeof *idle; i++)
        if (cli_given(c, idle[i])) cli_warn(c, "--%s has no effect: contact is off (--contact turns it on)", idle[i]);
    if (contact->enabled && contact->friction > 0.0 && scene->solver.method != SN_SOLVER_XPBD)
        cli_warn(c, "friction is felt under the solver xpbd alone");
}

/* ---- fields ----------------------------------------------------------------------------------------------------------------------- */

/* What was done to a bone so that it has an inside. */
static void tell_of_bone(const contact_run *run, const sn_scene_bone *bone, const sn_distance_field *field) {
    const sn_solid_report *r = &field->report;
    if (r->inside_out) cli_tell(run->c, "bone \"%s\" is inside out: it is taken the other way round", bone->name);
    if (r->volume == 0.0)
        cli_warn(run->c, "bone \"%s\" encloses nothing: muscles keep its margin, but nothing is inside of it", bone->name);
}

static sn_status take_field(void *user, const sn_scene_bone *bone, const sn_mesh *mesh, const sn_distance_field_params *params,
                            sn_distance_field *out, sn_error *error) {
    contact_run *run = user;
    bool was_read = false;
    double started = cli_seconds();
    sn_status status = sn_distance_field_cached(run->cache, mesh, params, out, &was_read, error);
    run->seconds += cli_seconds() - started;
    run->read += was_read;
    run->built += !was_read;
    if (status == SN_OK) tell_of_bone(run, bone, out);
    return status;
}

sn_status contacts_model(contact_run *run, const sn_scene *scene, sn_pool *pool, sn_model **out, sn_error *error) {
    const sn_model_options options = {.pool = pool, .fields = take_field, .user = run};
    return sn_model_create_with(scene, &options, out, error);
}

/* ---- what is said ------------------------------------------------------------------------------------------------------------------ */

void contacts_log(const sn_model *model, const sn_statistics *s, const sn_plan_muscle *plan, sn_json *json) {
    if (plan->groups[SN_ROWS_CONTACT].rows == 0) return;
    sn_json_integer(json, "contacts", s->contacts);
    sn_json_number(json, "penetration", s->penetration);
    if (s->penetration_bone == SN_NONE) return;
    sn_json_integer(json, "penetration_vertex", s->penetration_vertex);
    sn_json_text(json, "penetration_bone", model->scene->bones[s->penetration_bone].name);
}

void contacts_plan_muscle(const sn_model *model, const sn_plan_muscle *plan, sn_json *json) {
    if (!model->scene->contact.enabled) return;
    sn_json_array(json, "bonesInReach");
    for (sn_index i = 0; i < plan->bone_count; i++) sn_json_text(json, NULL, model->scene->bones[plan->bones[i]].name);
    sn_json_close(json);
    sn_json_integer(json, "bonesLeftOut", model->scene->bone_count - plan->bone_count);
}

void contacts_plan(const contact_run *run, const sn_model *model, sn_json *json) {
    const sn_scene *scene = model->scene;
    if (!scene->contact.enabled) return;
    sn_json_object(json, "contact");
    sn_json_integer(json, "fieldsBuilt", run->built);
    sn_json_integer(json, "fieldsRead", run->read);
    sn_json_number(json, "fieldSeconds", run->seconds);
    sn_json_array(json, "fields");
    for (sn_index b = 0; b < scene->bone_count; b++) {
        const sn_distance_field *field = sn_model_field(model, b);
        if (field == NULL) continue;
        sn_json_object(json, NULL);
        sn_json_text(json, "bone", scene->bones[b].name);
        sn_json_number(json, "cell", field->cell);
        sn_json_integer(json, "bytes", (int64_t)sn_distance_field_bytes(field));
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_close(json);
}
