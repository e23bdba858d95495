/* scene_build_write.c -- a draft as a scene document: what was chosen and no defaults; and the scene that this text is. */
#include "scene_build.h"

#include <stdlib.h>
#include <string.h>

/* ---- members ------------------------------------------------------------------------------------------------------------- */

static sn_status write_value(const char *text, const char *key, sn_json *json, sn_error *error) {
    sn_json_tree *tree = NULL;
    sn_status status = sn_draft_value_parse(text, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), value = sn_json_member(&top, "value");
    sn_json_pass(json, key, &value);
    sn_json_tree_free(tree);
    return SN_OK;
}

/* Length of the name of the object that a member is in; 0 = it is the muscle's own. */
static size_t group_of(const char *member) {
    const char *dot = strchr(member, '.');
    return dot != NULL ? (size_t)(dot - member) : 0;
}

/* Close the object that is open, and open that of the member, where they are not one. open: a member in it; NULL = none. */
static void change_group(const char **open, const char *member, sn_json *json) {
    size_t before = *open != NULL ? group_of(*open) : 0, group = group_of(member);
    char name[32];
    if (before == group && (group == 0 || strncmp(*open, member, group) == 0)) return;
    if (before > 0) sn_json_close(json);
    *open = member;
    if (group == 0 || group >= sizeof name) return;
    memcpy(name, member, group);
    name[group] = '\0';
    sn_json_object(json, name);
}

/* The settings from member `first` to `last`. */
static sn_status write_settings(const sn_draft_muscle *muscle, int first, int last, sn_json *json, sn_error *error) {
    const char *open = NULL;
    sn_status status = SN_OK;
    for (int i = first; i <= last && status == SN_OK; i++) {
        const char *member = sn_draft_members[i];
        size_t group = group_of(member);
        if (muscle->settings[i] == NULL) continue;
        change_group(&open, member, json);
        status = write_value(muscle->settings[i], group > 0 ? member + group + 1 : member, json, error);
    }
    change_group(&open, "", json);
    return status;
}

static bool is_set(const sn_draft_muscle *muscle, const char *member) {
    for (int i = 0; i < SN_DRAFT_MEMBERS; i++)
        if (strcmp(sn_draft_members[i], member) == 0) return muscle->settings[i] != NULL;
    return false;
}

/* ---- files --------------------------------------------------------------------------------------------------------------- */

/* A file as the document calls it. */
static sn_status write_path(const sn_scene_draft *draft, const char *key, const char *path, sn_json *json, sn_error *error) {
    char *uri = sn_path_from(draft->place, path);
    if (uri == NULL) return sn_fail_memory(error, "a path");
    sn_json_text(json, key, uri);
    free(uri);
    return SN_OK;
}

static sn_status write_channel(const sn_scene_draft *draft, const sn_draft_muscle *muscle, sn_json *json, sn_error *error) {
    if (!muscle->has_channel || is_set(muscle, "activation")) return SN_OK;
    sn_json_object(json, "activation");
    sn_status status = write_path(draft, "uri", draft->activation_path, json, error);
    sn_json_text(json, "channel", muscle->name);
    sn_json_close(json);
    return status;
}

/* ---- the document -------------------------------------------------------------------------------------------------------- */

static sn_status write_muscle(const sn_scene_draft *draft, const sn_draft_muscle *muscle, sn_json *json, sn_error *error) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", muscle->name);
    sn_status status = write_path(draft, "rig", muscle->path, json, error);
    if (status == SN_OK) status = write_channel(draft, muscle, json, error);
    if (status == SN_OK) status = write_settings(muscle, 0, SN_DRAFT_MEMBERS - 1, json, error);
    sn_json_close(json);
    return status;
}

static sn_status write_bone(const sn_scene_draft *draft, const sn_motion_bone *bone, sn_json *json, sn_error *error) {
    sn_json_object_line(json, NULL);
    sn_json_text(json, "name", bone->name);
    sn_status status = write_path(draft, "mesh", bone->path, json, error);
    if (bone->meters_per_unit > 0.0) sn_json_number(json, "units", bone->meters_per_unit);
    if (bone->joint != SN_NONE) sn_json_text(json, "joint", draft->motion.joints[bone->joint].name);
    sn_json_close(json);
    return status;
}

static sn_status write_envelopes(const sn_scene_draft *draft, sn_json *json, sn_error *error) {
    sn_status status = SN_OK;
    if (draft->envelope_count == 0) return SN_OK;
    sn_json_array(json, "surfaces");
    for (sn_index i = 0; i < draft->envelope_count && status == SN_OK; i++) {
        sn_json_object_line(json, NULL);
        sn_json_text(json, "name", draft->envelopes[i].name);
        if (draft->envelopes[i].solid) sn_json_bool(json, "contact", true);
        status = write_path(draft, "envelope", draft->envelopes[i].path, json, error);
        sn_json_close(json);
    }
    sn_json_close(json);
    return status;
}

static sn_status write_lists(const sn_scene_draft *draft, sn_json *json, sn_error *error) {
    sn_status status = SN_OK;
    sn_json_array(json, "bones");
    for (sn_index i = 0; i < draft->bone_count && status == SN_OK; i++)
        if (draft->bones[i].own) status = write_bone(draft, &draft->bones[i].bone, json, error);
    sn_json_close(json);
    if (status == SN_OK) status = write_envelopes(draft, json, error);
    sn_json_array(json, "muscles");
    for (sn_index i = 0; i < draft->muscle_count && status == SN_OK; i++)
        if (!draft->muscles[i].left_out) status = write_muscle(draft, &draft->muscles[i], json, error);
    sn_json_close(json);
    return status;
}

static void write_head(sn_json *json) {
    sn_json_text(json, "format", "sinew-scene");
    sn_json_integer(json, "version", 1);
}

static void write_solver(const sn_scene_draft *draft, sn_json *json) {
    sn_json_object(json, "solver");
    sn_json_text(json, "method", sn_solver_method_names[draft->method]);
    sn_json_close(json);
}

static sn_status write_document(const sn_scene_draft *draft, const sn_history_entry *entry, sn_json *json, sn_error *error) {
    sn_status status = SN_OK;
    sn_json_object(json, NULL);
    write_head(json);
    if (draft->name != NULL) sn_json_text(json, "name", draft->name);
    sn_json_number(json, "metersPerUnit", 1.0);
    sn_json_number(json, "rate", draft->rate);
    sn_json_indices(json, "frames", (const sn_index[2]){draft->first_frame, draft->last_frame}, 2);
    sn_json_number(json, "preroll", draft->preroll);
    sn_json_number(json, "runIn", draft->run_in);
    write_solver(draft, json);
    if (draft->contact) sn_json_bool(json, "contact", true);
    if (draft->externals) sn_json_bool(json, "externals", true);
    if (draft->motion_path != NULL) {
        sn_json_object(json, "motion");
        status = write_path(draft, "uri", draft->motion_path, json, error);
        sn_json_close(json);
    }
    if (status == SN_OK) status = write_lists(draft, json, error);
    sn_history_write(NULL, entry, json);
    return status;
}

/* ---- text in memory ------------------------------------------------------------------------------------------------------ */

/* What a document is written by. */
typedef struct task {
    const sn_scene_draft *draft;
    const sn_history_entry *entry; /* the whole; or: */
    const sn_draft_muscle *muscle; /* nullable: a probe of this muscle's ... */
    int member;                    /* ... member */
} task;

static sn_status write_probe(const task *t, sn_json *json, sn_error *error) {
    const sn_draft_muscle *muscle = t->muscle;
    bool enabled = strcmp(sn_draft_members[t->member], "enabled") == 0; /* a probe never is: its rig stays unread */
    sn_json_object(json, NULL);
    write_head(json);
    write_solver(t->draft, json);
    sn_json_array(json, "muscles");
    sn_json_object(json, NULL);
    sn_json_text(json, "name", muscle->name);
    sn_status status = write_path(t->draft, "rig", muscle->path, json, error);
    sn_json_bool(json, "enabled", false);
    if (status == SN_OK && !enabled) status = write_settings(muscle, t->member, t->member, json, error);
    sn_json_close(json);
    sn_json_close(json);
    return status;
}

static sn_status write_text(const task *t, sn_blob *out, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open_memory(&output, error);
    if (status != SN_OK) return status;
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) {
        sn_output_abort(output);
        return sn_fail_memory(error, "a scene");
    }
    status = t->muscle != NULL ? write_probe(t, json, error) : write_document(t->draft, t->entry, json, error);
    sn_status end = sn_json_end(json, status == SN_OK ? error : NULL);
    if (status == SN_OK) status = end;
    if (status == SN_OK) return sn_output_take(output, t->draft->place, out, error);
    sn_output_abort(output);
    return status;
}

sn_status sn_draft_probe(const sn_scene_draft *draft, const sn_draft_muscle *muscle, int member, sn_blob *out, sn_error *error) {
    return write_text(&(task){.draft = draft, .muscle = muscle, .member = member}, out, error);
}

/* The rigs of the muscles that are written, in their order; they are the scene's then. */
static sn_status read_back(sn_scene_draft *draft, const sn_blob *text, sn_scene *scene, sn_error *error) {
    sn_muscle *rigs = SN_NEW(sn_muscle, draft->muscle_count);
    sn_index count = 0;
    if (rigs == NULL) return sn_fail_memory(error, "the rigs");
    for (sn_index i = 0; i < draft->muscle_count; i++) {
        if (draft->muscles[i].left_out) continue;
        rigs[count++] = draft->muscles[i].rig;
        draft->muscles[i].rig = (sn_muscle){0};
    }
    sn_status status = sn_scene_parse_around(text, rigs, scene, error);
    for (sn_index i = 0; i < count; i++) sn_muscle_free(&rigs[i]);
    free(rigs);
    return status;
}

sn_status sn_draft_finish(sn_scene_draft *draft, const sn_history_entry *entry, sn_blob *text, sn_scene *scene, sn_error *error) {
    *text = (sn_blob){0};
    *scene = (sn_scene){0};
    sn_status status = write_text(&(task){.draft = draft, .entry = entry}, text, error);
    if (status == SN_OK) status = read_back(draft, text, scene, error);
    if (status != SN_OK) sn_blob_free(text);
    return status;
}
