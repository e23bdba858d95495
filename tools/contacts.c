/*
 * contacts.c -- contact of muscles with bones, as simulate takes and tells it.
 */
#include "contacts.h"

#include "sinew/distance_field.h"
#include "sinew/io.h"
#include "sinew/voxels.h"

#include <string.h>

/* What says nothing without contact. */
static const char *const OF_CONTACT[] = {"margin",          "grid-cell", "grid-cache", "friction", "resolve",
                                         "contact-samples", "collision", "voxels",     "bone-hits"};
enum { OF_CONTACT_COUNT = sizeof OF_CONTACT / sizeof *OF_CONTACT };

bool contacts_wanted(const cli *c, const contact_choices *given) {
    if (given->on && given->off) cli_usage_error(c, "--contact and --no-contact exclude each other");
    for (int i = 0; given->off && i < OF_CONTACT_COUNT; i++)
        if (cli_given(c, OF_CONTACT[i])) cli_usage_error(c, "--no-contact and --%s exclude each other", OF_CONTACT[i]);
    if (cli_given(c, "contact-samples") && given->samples == 2) cli_usage_error(c, "--contact-samples is 0, 1 or 3");
    return given->on;
}

/* "N" or "total:N". */
static void apply_voxels(const cli *c, const contact_choices *given, sn_contact_settings *contact) {
    static const char TOTAL[] = "total:";
    if (!cli_given(c, "voxels")) return;
    bool in_all = strncmp(given->voxels, TOTAL, sizeof TOTAL - 1) == 0;
    const char *number = given->voxels + (in_all ? sizeof TOTAL - 1 : 0), *end = number + strlen(number);
    int64_t value = 0, most = in_all ? SN_MOST_VOXELS : SN_MOST_VOXELS_ALONG;
    if (!sn_scan_integer(number, end, &number, &value) || number != end || value < 1 || value > most)
        cli_usage_error(c, "--voxels %s: write N, 1 to %d along each axis, or total:N, 1 to %d in all", given->voxels, SN_MOST_VOXELS_ALONG,
                        SN_MOST_VOXELS);
    contact->voxels = in_all ? 0 : (sn_index)value;
    contact->voxels_total = in_all ? (sn_index)value : 0;
}

/* Options that another collision, or another scheme, has a use for. */
static void warn_of_idle(const cli *c, const sn_scene *scene) {
    static const char *const of_fields[] = {"margin", "friction", "resolve", "contact-samples"};
    static const char *const of_voxels[] = {"voxels", "bone-hits"};
    bool by_voxels = sn_scene_collision(scene) == SN_COLLISION_VOXEL;
    for (size_t i = 0; by_voxels && i < sizeof of_fields / sizeof *of_fields; i++)
        if (cli_given(c, of_fields[i]))
            cli_warn(c, "--%s has no effect: the collision is by voxels (--collision field is not)", of_fields[i]);
    for (size_t i = 0; !by_voxels && i < sizeof of_voxels / sizeof *of_voxels; i++)
        if (cli_given(c, of_voxels[i]))
            cli_warn(c, "--%s has no effect: the collision is by distance fields (--collision voxel is not)", of_voxels[i]);
    for (sn_index i = 0; by_voxels && i < scene->surface_count; i++)
        if (scene->surfaces[i].solid)
            cli_warn(c, "surface \"%s\" is not felt: the collision is by voxels, of bones alone", scene->surfaces[i].name);
    if (scene->solver.method == SN_SOLVER_XPBD && scene->solver.scheme == SN_SCHEME_ROMEO)
        cli_warn(c, "the scheme romeo has no contact: muscles enter bones as they do without");
}

void contacts_apply(const cli *c, const contact_choices *given, sn_scene *scene) {
    sn_contact_settings *contact = &scene->contact;
    if (given->on) contact->enabled = true;
    if (given->off) contact->enabled = false;
    if (cli_given(c, "margin")) contact->margin = sn_length_meters(given->margin, 1.0);
    if (cli_given(c, "grid-cell")) contact->cell = sn_length_meters(given->cell, 1.0);
    if (cli_given(c, "friction")) contact->friction = given->friction;
    if (cli_given(c, "resolve")) contact->resolve = scene->externals.resolve = given->resolve;
    if (cli_given(c, "contact-samples")) contact->samples = (sn_index)given->samples;
    if (cli_given(c, "collision")) contact->collision = (sn_collision)given->collision;
    if (cli_given(c, "bone-hits")) contact->bone_hits = (sn_bone_hits)given->bone_hits;
    apply_voxels(c, given, contact);
    for (int i = 0; !contact->enabled && i < OF_CONTACT_COUNT; i++)
        if (cli_given(c, OF_CONTACT[i]) && !(scene->externals.enabled && strcmp(OF_CONTACT[i], "resolve") == 0))
            cli_warn(c, "--%s has no effect: contact is off (--contact turns it on)", OF_CONTACT[i]);
    for (sn_index i = 0; !contact->enabled && !given->off && i < scene->surface_count; i++)
        if (scene->surfaces[i].solid)
            cli_warn(c, "surface \"%s\" is not felt: contact is off (--contact turns it on)", scene->surfaces[i].name);
    if (contact->enabled) warn_of_idle(c, scene);
    if (contact->enabled && contact->friction > 0.0 && scene->solver.method != SN_SOLVER_XPBD)
        cli_warn(c, "friction is felt under the solver xpbd alone");
}

/* ---- fields ----------------------------------------------------------------------------------------------------------------------- */

/* Between corners farther apart than this share of a bone's thinnest side it is hardly seen. */
static const double COARSE = 0.25;

/* What was done to a bone so that it has an inside, and whether its field can show it. */
static void tell_of_bone(const contact_run *run, const sn_scene_bone *bone, const sn_distance_field *field) {
    const sn_solid_report *r = &field->report;
    sn_vec3 size = sn_sub(field->box.high, field->box.low);
    double thinnest = fmin(size.x, fmin(size.y, size.z));
    if (r->volume > 0.0 && field->cell > COARSE * thinnest)
        cli_warn(run->c,
                 "bone \"%s\": cells of %.3g mm are too coarse for a bone that is %.3g mm thin: muscles go into it; choose a smaller "
                 "--grid-cell",
                 bone->name, 1e3 * field->cell, 1e3 * thinnest);
    if (r->inside_out) cli_tell(run->c, "bone \"%s\" is inside out: it is taken the other way round", bone->name);
    if (r->volume == 0.0 && !run->by_voxels)
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
    run->by_voxels = sn_scene_collision(scene) == SN_COLLISION_VOXEL;
    sn_status status = sn_model_create_with(scene, &options, out, error);
    for (sn_index b = 0; status == SN_OK && b < scene->bone_count; b++) {
        const sn_voxels *voxels = sn_model_voxels(*out, b);
        if (voxels != NULL && voxels->inside == 0)
            cli_warn(run->c, "bone \"%s\" encloses no voxel: only those that its surface runs through stop muscles", scene->bones[b].name);
    }
    return status;
}

/* ---- what is said ------------------------------------------------------------------------------------------------------------------ */

void contacts_log(const sn_model *model, const sn_statistics *s, const sn_plan_muscle *plan, sn_json *json) {
    if (plan->groups[SN_ROWS_CONTACT].rows == 0) return;
    sn_json_integer(json, "contacts", s->contacts);
    sn_json_number(json, "overlap", s->overlap);
    sn_json_number(json, "penetration", s->penetration);
    if (s->leaps > 0) sn_json_integer(json, "leaps", s->leaps);
    if (s->penetration_bone == SN_NONE) return;
    sn_json_integer(json, "penetration_vertex", s->penetration_vertex);
    sn_json_text(json, "penetration_bone", sn_scene_touched_name(model->scene, s->penetration_bone));
}

static bool tied_by_corotated(const sn_model *model) {
    const sn_solver_settings *solver = &model->scene->solver;
    return sn_model_tied(model) && solver->method == SN_SOLVER_QN && solver->preconditioner == SN_PRECONDITION_COROTATED;
}

/* Muscles in what they are tied to. */
static void say_ties(const cli *c, const sn_model *model) {
    sn_index inside = 0, muscles = 0;
    double deepest = 0.0;
    for (sn_index i = 0; i < model->plan.muscle_count; i++) {
        const sn_plan_muscle *plan = &model->plan.muscles[i];
        inside += plan->ties_inside, muscles += plan->ties_inside > 0;
        deepest = fmax(deepest, plan->deepest_tie);
    }
    if (tied_by_corotated(model))
        cli_warn(c, "muscles that are tied to each other go by the scalar matrix: the corotated one knows one muscle alone");
    if (inside > 0)
        cli_tell(c, "at rest %d vertices of %d muscle%s lie in what they are tied to, %.3g mm deep at most%s", (int)inside, (int)muscles,
                 muscles == 1 ? "" : "s", 1e3 * deepest, model->scene->externals.resolve > 0.0 ? "" : " (--resolve takes them out)");
}

void contacts_say(const cli *c, const sn_model *model, const sn_state *state) {
    sn_index overlaps = 0, muscles = 0;
    double before = 0.0, left = 0.0;
    for (sn_index i = 0; i < model->plan.muscle_count; i++) {
        const sn_plan_muscle *plan = &model->plan.muscles[i];
        overlaps += plan->overlaps;
        muscles += plan->overlaps > 0;
        before = fmax(before, plan->overlap);
    }
    for (sn_index i = 0; i < model->muscle_count; i++) left = fmax(left, state->muscles[i].statistics.overlap);
    if (overlaps > 0)
        cli_tell(c, "at rest %d vertices of %d muscle%s lie in bones, %.3g mm deep at most; now %.3g mm%s", (int)overlaps, (int)muscles,
                 muscles == 1 ? "" : "s", 1e3 * before, 1e3 * left,
                 model->scene->contact.resolve > 0.0 ? "" : " (--resolve takes them out)");
    say_ties(c, model);
}

/* In reach; surfaces are counted after the bones. */
static sn_index count_bones(const sn_model *model, const sn_plan_muscle *plan) {
    sn_index count = 0;
    for (sn_index i = 0; i < plan->bone_count; i++) count += plan->bones[i] < model->scene->bone_count;
    return count;
}

/* The patches of surfaces that come near it. */
static void plan_patches(const sn_model *model, const sn_plan_muscle *plan, sn_json *json) {
    if (count_bones(model, plan) == plan->bone_count) return;
    sn_json_array(json, "surfacesInReach");
    for (sn_index i = 0; i < plan->bone_count; i++) {
        sn_index surface = plan->bones[i] - model->scene->bone_count;
        if (surface < 0) continue;
        sn_json_object(json, NULL);
        sn_json_text(json, "surface", model->scene->surfaces[surface].name);
        sn_json_integer(json, "triangles", sn_model_patch_size(model, (sn_index)(plan - model->plan.muscles), surface));
        sn_json_integer(json, "ofTriangles", model->scene->surfaces[surface].envelope.mesh.triangle_count);
        sn_json_close(json);
    }
    sn_json_close(json);
}

void contacts_plan_muscle(const sn_model *model, const sn_plan_muscle *plan, sn_json *json) {
    if (!model->scene->contact.enabled) return;
    sn_json_array(json, "bonesInReach");
    for (sn_index i = 0; i < plan->bone_count; i++)
        if (plan->bones[i] < model->scene->bone_count) sn_json_text(json, NULL, model->scene->bones[plan->bones[i]].name);
    sn_json_close(json);
    plan_patches(model, plan, json);
    sn_json_integer(json, "bonesLeftOut", model->scene->bone_count - count_bones(model, plan));
    sn_json_integer(json, "overlapsAtRest", plan->overlaps);
    sn_json_number(json, "deepestAtRest", plan->overlap);
}

/* What a program with a byte for each cell takes, as [K21] fig. 3 counts, stands beside what they take here. */
static void plan_voxels(const sn_model *model, sn_json *json) {
    const sn_scene *scene = model->scene;
    if (sn_scene_collision(scene) != SN_COLLISION_VOXEL) return;
    sn_json_array(json, "voxels");
    for (sn_index b = 0; b < scene->bone_count; b++) {
        const sn_voxels *voxels = sn_model_voxels(model, b);
        if (voxels == NULL) continue;
        sn_json_object(json, NULL);
        sn_json_text(json, "bone", scene->bones[b].name);
        sn_json_indices(json, "size", voxels->size, 3);
        sn_json_integer(json, "cells", sn_voxels_count(voxels));
        sn_json_integer(json, "boundary", voxels->boundary);
        sn_json_integer(json, "inside", voxels->inside);
        sn_json_integer(json, "bytes", (int64_t)sn_voxels_bytes(voxels));
        sn_json_integer(json, "bytesPublished", sn_voxels_count(voxels));
        sn_json_close(json);
    }
    sn_json_close(json);
}

void contacts_plan(const contact_run *run, const sn_model *model, sn_json *json) {
    const sn_scene *scene = model->scene;
    if (!scene->contact.enabled) return;
    sn_json_object(json, "contact");
    sn_json_text(json, "collision", sn_collision_names[sn_scene_collision(scene)]);
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
    plan_voxels(model, json);
    sn_json_close(json);
}
