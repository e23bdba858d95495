/* scene-build.c -- a first scene out of its parts: rigs, bones, a motion or a model with its motion, activations, settings by pattern. */
#include "bones.h"
#include "folder.h"
#include "grips.h"
#include "model_bones.h"
#include "scene_list.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* More names than this are counted in a message, not told. */
enum { NAMES_TOLD = 8 };

static const char *motion_file, *model_file, *bones_dir, *activation_file, *frames, *name;
static cli_list bone_texts, bone_lists, envelopes, solids, bone_paths, bindings, settings;
static double rate, preroll, run_in;
static int units, method = SN_SOLVER_QN;
static bool skip_unattached, list, contact, externals;

static const cli_option options[] = {
    {0, "motion", "FILE", CLI_TEXT, &motion_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "the motion document; its bones, rate and frames are the scene's. With --model: the .mot or .sto that moves it"},
    {0, "model", "FILE", CLI_TEXT, &model_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "take bones, joints and motion of an OpenSim or MuJoCo model (.osim, .xml)"},
    {0, "bones-dir", "DIR", CLI_TEXT, &bones_dir, 0, 0, 0, NULL,
     "with --model: write its bones and its motion document into DIR (default: OUTPUT, with .bones for .scene.json)"},
    {0, "bone-path", "DIR", CLI_LIST, &bone_paths, 0, 0, 0, NULL,
     "with --model: look for its mesh files in DIR first (default: beside the model, and in Geometry there)"},
    {'b', "bone", "[NAME=]FILE", CLI_LIST, &bone_texts, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "a bone beside those of the motion, or in the place of its namesake; may be given again and again"},
    {0, "bones", "LIST", CLI_LIST, &bone_lists, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "bones: every mesh of a folder, or a file with a bone a line"},
    {0, "units", "UNIT", CLI_CHOICE, &units, CLI_RESULT, 0, 0, cli_unit_names,
     "unit of the files of --bone and --bones (default: what they say, else m)"},
    {0, "envelope", "[NAME=]FILE", CLI_LIST, &envelopes, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "an envelope over the bones, which muscles may be attached to by NAME (default: its file's); may be given again and again"},
    {0, "keep-out", "NAME", CLI_LIST, &solids, CLI_RESULT, 0, 0, NULL,
     "muscles keep out of the envelope NAME, where the scene has contact; may be given again and again"},
    {0, "bind", "PATTERN=JOINT", CLI_LIST, &bindings, CLI_RESULT, 0, 0, NULL,
     "bones that JOINT moves (default: as the motion says; a bone of --bone or --bones by the joint of its name)"},
    {0, "activation", "FILE", CLI_TEXT, &activation_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "activation document: a muscle takes the channel of its name"},
    {0, "set", "PATTERN.MEMBER=VALUE", CLI_LIST, &settings, CLI_RESULT, 0, 0, NULL,
     "set a member of all muscles of the pattern, as in '*.tone=0.05'; a later one goes before an earlier one"},
    {0, "frames", "A:B", CLI_TEXT, &frames, CLI_RESULT, 0, 0, NULL, "first and last frame (default: those of the motion)"},
    {0, "rate", "HZ", CLI_NUMBER, &rate, CLI_RESULT, 1e-3, 1e5, NULL, "frames a second (default: the motion's; without one 24)"},
    {0, "preroll", "S", CLI_NUMBER, &preroll, CLI_RESULT, 0, 1e6, NULL,
     "settle for S seconds before the first frame (default: 2 where that is away from rest, else 0)"},
    {0, "run-in", "S", CLI_NUMBER, &run_in, CLI_RESULT, 0, 1e6, NULL,
     "in S seconds of the preroll the bones go from rest to the first frame (default: half of the preroll where that is away from rest)"},
    {0, "solver", "METHOD", CLI_CHOICE, &method, CLI_RESULT, 0, 0, sn_solver_method_names, "xpbd or qn (default)"},
    {0, "contact", NULL, CLI_FLAG, &contact, CLI_RESULT, 0, 0, NULL, "in the scene muscles keep out of bones"},
    {0, "externals", NULL, CLI_FLAG, &externals, CLI_RESULT, 0, 0, NULL, "in the scene the external constraints of the rigs act"},
    {0, "name", "TEXT", CLI_TEXT, &name, CLI_RESULT, 0, 0, NULL, "the scene's name (default: its file's)"},
    {0, "skip-unattached", NULL, CLI_FLAG, &skip_unattached, CLI_RESULT, 0, 0, NULL,
     "leave out muscles that are attached to bones which the scene has not got, with a warning (otherwise an error names them all)"},
    {0, "list", NULL, CLI_FLAG, &list, 0, 0, 0, NULL, "print what would be in the scene, and write nothing"},
};

static const cli_tool tool = {"scene-build",
                              "build a scene from rigs, bones, a motion, activations",
                              CLI_TAKES_INPUTS | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_REPORT | CLI_HAS_HISTORY | CLI_HAS_SPACE,
                              options,
                              sizeof options / sizeof *options,
                              "An input is a rig, or a folder: every .muscle.json in it.",
                              ".json"};

/* What one run holds. */
typedef struct job {
    cli c;
    sn_scene_draft draft;
    char *name, *folder; /* of the scene; for what is made of a model */
    bone_list bones;
    sn_blob model, model_motion;
    sn_clip clip;
    sn_model_bones model_bones;
    double away_angle, away_distance;
    sn_index left_out, voiceless, unheard; /* muscles; muscles without a channel; channels without a muscle */
    sn_blob text;
    sn_scene scene;
} job;

/* ---- names in messages ---------------------------------------------------------------------------------------------------------- */

/* "a, b and 4 more", as it grows. */
typedef struct name_row {
    char text[600];
    size_t used;
    sn_index count;
} name_row;

static void add_name(name_row *row, const char *format, const char *first, const char *second) {
    char one[256];
    if (row->count++ >= NAMES_TOLD) return;
    snprintf(one, sizeof one, format, first, second);
    int more = snprintf(row->text + row->used, sizeof row->text - row->used, "%s%s", row->count > 1 ? ", " : "", one);
    row->used = row->used + (size_t)more < sizeof row->text ? row->used + (size_t)more : sizeof row->text - 1;
}

static const char *told(name_row *row) {
    if (row->count > NAMES_TOLD) snprintf(row->text + row->used, sizeof row->text - row->used, " and %d more", row->count - NAMES_TOLD);
    return row->text;
}

/* ---- rigs ----------------------------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *ending) {
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcmp(text + length - tail, ending) == 0;
}

static bool is_rig(const char *file) { return ends_with(file, ".muscle.json"); }

static sn_status add_folder(job *j, const char *folder, sn_error *error) {
    char **paths;
    int count;
    sn_status status = folder_list(folder, is_rig, &paths, &count, error);
    bool here = strcmp(folder, ".") == 0 || strcmp(folder, "./") == 0;
    if (status == SN_OK && count == 0) status = sn_fail_at(error, SN_ERROR_INPUT, folder, 0, "no rig (.muscle.json) is in it");
    for (int i = 0; i < count && status == SN_OK; i++) status = sn_draft_add_rig(&j->draft, paths[i] + (here ? strlen("./") : 0), error);
    folder_free(paths, count);
    return status;
}

static sn_status add_rigs(job *j, sn_error *error) {
    const cli_list *inputs = &j->c.inputs;
    sn_status status = SN_OK;
    if (inputs->count == 0 && model_file == NULL && motion_file == NULL) cli_usage_error(&j->c, "name the rigs, or a folder of them");
    for (int i = 0; i < inputs->count && status == SN_OK; i++) {
        if (strcmp(inputs->items[i], "-") == 0) cli_usage_error(&j->c, "a scene names its rigs by their files: '-' is none");
        status =
            folder_is(inputs->items[i]) ? add_folder(j, inputs->items[i], error) : sn_draft_add_rig(&j->draft, inputs->items[i], error);
    }
    return status;
}

/* ---- a model's motion ------------------------------------------------------------------------------------------------------------ */

/* "walk.scene.json" -> "walk"; also of other endings. */
static char *stem_of(const char *path) {
    const char *slash = strrchr(path, '/'), *start = slash != NULL ? slash + 1 : path;
    const char *end = ends_with(start, ".scene.json") ? start + strlen(start) - strlen(".scene.json") : strrchr(start, '.');
    return sn_strndup(start, end != NULL && end > start ? (size_t)(end - start) : strlen(start));
}

/* Where what is made of a model goes. */
static sn_status name_folder(job *j, sn_error *error) {
    const char *output = j->c.output, *slash = strrchr(output, '/');
    if (bones_dir != NULL) {
        j->folder = sn_strdup(bones_dir);
    } else if (j->name == NULL) {
        if (!list) cli_usage_error(&j->c, "--model writes bones: name their folder with --bones-dir, or the scene with -o");
        j->folder = sn_strdup("bones");
    } else {
        size_t head = slash != NULL ? (size_t)(slash - output) + 1 : 0, size = head + strlen(j->name) + sizeof ".bones";
        if ((j->folder = sn_alloc(size, 1)) != NULL) snprintf(j->folder, size, "%.*s%s.bones", (int)head, output, j->name);
    }
    return j->folder != NULL ? SN_OK : sn_fail_memory(error, "a path");
}

static sn_status read_model(job *j, sn_error *error) {
    sn_bone_search search = {.folders = bone_paths.items, .folder_count = bone_paths.count, .found = &j->model_bones};
    const sn_clip_options chosen = {.bones = &search};
    sn_status status = sn_blob_read(model_file, &j->model, error);
    if (status == SN_OK && !sn_osim_detect(&j->model) && !sn_mjcf_detect(&j->model))
        status =
            sn_fail_at(error, SN_ERROR_INPUT, model_file, 0, "is no model of OpenSim or MuJoCo; give motion documents by --motion alone");
    if (status == SN_OK && motion_file != NULL) status = sn_blob_read(motion_file, &j->model_motion, error);
    if (status != SN_OK) return status;
    const sn_blob *moves = motion_file != NULL ? &j->model_motion : &j->model;
    status = sn_clip_parse(moves, motion_file != NULL ? &j->model : NULL, &chosen, &j->clip, error);
    if (status == SN_OK && j->clip.rate_assumed)
        cli_tell(&j->c, "%s tells no rate: taken as %g Hz; motion-import --source-rate tells another", moves->name, j->clip.rate);
    return status;
}

/* The model's bones where they will be. */
static sn_status list_bones(const job *j, sn_motion *motion, sn_error *error) {
    motion->bones = SN_NEW(sn_motion_bone, j->model_bones.count);
    if (motion->bones == NULL) return sn_fail_memory(error, "the bones");
    for (sn_index i = 0; i < j->model_bones.count; i++) {
        const sn_model_bone *from = &j->model_bones.bones[i];
        sn_motion_bone *to = &motion->bones[motion->bone_count++];
        *to = (sn_motion_bone){.name = sn_strdup(from->name),
                               .path = model_bones_path(j->folder, from->name, ".ply"),
                               .meters_per_unit = 1.0,
                               .joint = from->joint};
        if (to->name == NULL || to->path == NULL) return sn_fail_memory(error, "the bones");
    }
    return SN_OK;
}

static sn_status take_model(job *j, sn_error *error) {
    sn_motion motion = {0};
    sn_status status = name_folder(j, error);
    if (status == SN_OK) status = read_model(j, error);
    if (status == SN_OK) status = sn_clip_to_motion(&j->clip, &motion, error);
    if (status == SN_OK) status = list_bones(j, &motion, error);
    char *stem = stem_of(motion_file != NULL ? motion_file : model_file);
    char *path = stem != NULL && j->folder != NULL ? model_bones_path(j->folder, stem, ".motion.json") : NULL;
    if (status == SN_OK && path == NULL) status = sn_fail_memory(error, "a path");
    if (status == SN_OK) status = sn_draft_put_motion(&j->draft, &motion, j->clip.rate, path, error);
    free(path);
    free(stem);
    sn_motion_free(&motion);
    return status;
}

static sn_status write_motion(job *j, const sn_motion *motion, const sn_history_entry *entry, sn_error *error) {
    const sn_motion_head head = {.name = j->clip.name, .path = j->draft.motion_path, .rate = j->clip.rate, .entry = entry};
    sn_output *output = NULL;
    sn_status status = sn_output_open(j->draft.motion_path, false, &output, error);
    if (status == SN_OK) status = sn_motion_document_write(motion, &head, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

/* Its bones and its motion document, which the scene names. */
static sn_status save_model(job *j, const sn_history_entry *entry, sn_error *error) {
    sn_motion motion = {0};
    sn_status status = model_bones_save(&j->c, &j->model_bones, j->folder, &j->clip, error);
    if (status == SN_OK) status = sn_clip_to_motion(&j->clip, &motion, error);
    if (status == SN_OK) status = write_motion(j, &motion, entry, error);
    sn_motion_free(&motion);
    return status;
}

/* ---- bones ---------------------------------------------------------------------------------------------------------------------- */

static sn_status add_bones(job *j, sn_error *error) {
    double unit = cli_given(&j->c, "units") ? cli_unit_meters[units] : 0.0;
    sn_status status = bones_name(&j->c, &bone_texts, &bone_lists, &j->bones, error);
    for (size_t i = 0; i < j->bones.count && status == SN_OK; i++) {
        bone *b = &j->bones.items[i];
        const sn_motion_bone added = {.name = b->name, .path = b->file, .meters_per_unit = unit};
        const sn_draft_bone *replaced = sn_draft_find_bone(&j->draft, b->name);
        b->used = true;
        if (replaced != NULL && !replaced->own) cli_say(&j->c, "bone \"%s\": %s instead of %s", b->name, b->file, replaced->bone.path);
        status = sn_draft_add_bone(&j->draft, &added, error);
    }
    for (int i = 0; i < bindings.count && status == SN_OK; i++) {
        status = sn_draft_bind(&j->draft, bindings.items[i], error);
        if (status == SN_ERROR_USAGE) cli_usage_error(&j->c, "--bind: %s", error->text);
    }
    return status;
}

static sn_status add_envelopes(job *j, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < envelopes.count && status == SN_OK; i++) {
        const char *text = envelopes.items[i], *equals = strchr(text, '='), *slash = strchr(text, '/');
        bool named = equals != NULL && equals > text && (slash == NULL || equals < slash);
        if ((named ? equals[1] : text[0]) == '\0') cli_usage_error(&j->c, "--envelope: '%s' names no file", text);
        char *called = named ? sn_strndup(text, (size_t)(equals - text)) : NULL;
        if (named && called == NULL) return sn_fail_memory(error, "a name");
        status = sn_draft_add_envelope(&j->draft, called, named ? equals + 1 : text, error);
        free(called);
    }
    return status;
}

static sn_status mark_solids(job *j, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < solids.count && status == SN_OK; i++) {
        status = sn_draft_touch(&j->draft, solids.items[i], error);
        if (status == SN_ERROR_USAGE) cli_usage_error(&j->c, "--keep-out: %s", error->text);
    }
    return status;
}

/* Muscles on bones that are not there: all of them at once. */
static sn_status check_attachments(job *j, sn_error *error) {
    name_row row = {0};
    for (sn_index i = 0; i < j->draft.muscle_count; i++) {
        sn_draft_muscle *m = &j->draft.muscles[i];
        const char *missing = sn_draft_missing_bone(&j->draft, m);
        if (missing != NULL) add_name(&row, "%s to %s", m->name, missing);
        m->left_out = missing != NULL;
    }
    j->left_out = row.count;
    if (row.count == 0) return SN_OK;
    if (row.count == j->draft.muscle_count || !skip_unattached)
        return sn_fail(error, SN_ERROR_INPUT,
                       "%d of %d muscles are attached to bones that are not there: %s; name those with --bone or --bones, or --envelope%s",
                       row.count, j->draft.muscle_count, told(&row),
                       skip_unattached ? "" : ", or leave the muscles out with --skip-unattached");
    cli_warn(&j->c, "%d of %d muscles are left out, attached to bones that are not there: %s", row.count, j->draft.muscle_count,
             told(&row));
    return SN_OK;
}

/* Bones on no joint; returns how many. */
static sn_index still_bones(const job *j, name_row *row) {
    for (sn_index i = 0; i < j->draft.bone_count; i++)
        if (j->draft.bones[i].bone.joint == SN_NONE) add_name(row, "%s", j->draft.bones[i].bone.name, NULL);
    return row->count;
}

/* A motion that moves nothing is a mistake. */
static sn_status check_motion(job *j, sn_error *error) {
    name_row still = {0};
    if (j->draft.motion_path == NULL || j->draft.motion.joint_count == 0 || still_bones(j, &still) < j->draft.bone_count) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, j->draft.motion_path, 0,
                      "moves none of the %d bones, as no joint has the name of one (the first joint is \"%s\"); bind them with --bind "
                      "PATTERN=JOINT",
                      j->draft.bone_count, j->draft.motion.joints[0].name);
}

static void tell_of_bones(const job *j) {
    name_row still = {0};
    if (j->draft.motion_path != NULL && still_bones(j, &still) > 0)
        cli_tell(&j->c, "%d of %d bones are on no joint and stand still: %s", still.count, j->draft.bone_count, told(&still));
}

/* ---- activations ---------------------------------------------------------------------------------------------------------------- */

static bool is_muscle(const job *j, const char *channel) {
    for (sn_index i = 0; i < j->draft.muscle_count; i++)
        if (strcmp(j->draft.muscles[i].name, channel) == 0) return true;
    return false;
}

static sn_status take_activations(job *j, sn_error *error) {
    name_row unheard = {0}, voiceless = {0};
    if (activation_file == NULL) return SN_OK;
    sn_status status = sn_draft_take_activations(&j->draft, activation_file, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < j->draft.channels.count; i++)
        if (!is_muscle(j, j->draft.channels.names[i])) add_name(&unheard, "%s", j->draft.channels.names[i], NULL);
    for (sn_index i = 0; i < j->draft.muscle_count; i++)
        if (!j->draft.muscles[i].has_channel) add_name(&voiceless, "%s", j->draft.muscles[i].name, NULL);
    j->unheard = unheard.count;
    j->voiceless = voiceless.count;
    if (voiceless.count == j->draft.muscle_count) /* none, too */
        return sn_fail_at(error, SN_ERROR_INPUT, activation_file, 0, "has no channel of any muscle's name; its channels: %s",
                          told(&unheard));
    if (unheard.count > 0)
        cli_warn(&j->c, "%s: %d of %d channels are no muscle's: %s", activation_file, unheard.count, j->draft.channels.count,
                 told(&unheard));
    if (voiceless.count > 0)
        cli_warn(&j->c, "%d of %d muscles have no channel in %s and stay at rest unless --set says otherwise: %s", voiceless.count,
                 j->draft.muscle_count, activation_file, told(&voiceless));
    return SN_OK;
}

static sn_status set_members(job *j, sn_error *error) {
    for (int i = 0; i < settings.count; i++) {
        sn_status status = sn_draft_set(&j->draft, settings.items[i], error);
        if (status == SN_ERROR_USAGE) cli_usage_error(&j->c, "--set: %s", error->text);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

/* ---- time ----------------------------------------------------------------------------------------------------------------------- */

static void choose_frames(job *j) {
    const char *text = frames, *end = frames + strlen(frames);
    int64_t first = 0, last = 0;
    bool right = sn_scan_integer(text, end, &text, &first) && *text++ == ':' && sn_scan_integer(text, end, &text, &last) && text == end;
    if (!right || first < -SN_FRAME_LIMIT || last > SN_FRAME_LIMIT || last < first)
        cli_usage_error(&j->c, "--frames: '%s' is not A:B, two frames", frames);
    bool beyond = first < j->draft.first_frame || last > j->draft.last_frame;
    if (beyond && j->draft.motion_path != NULL)
        cli_tell(&j->c, "the motion has frames %d to %d at %g a second; outside of them it stands still", j->draft.first_frame,
                 j->draft.last_frame, j->draft.rate);
    j->draft.first_frame = (sn_index)first;
    j->draft.last_frame = (sn_index)last;
}

/* Less than this is the first frame of a motion that begins at rest. */
static const double LEAST_ANGLE = 0.1 * SN_PI / 180.0, LEAST_DISTANCE = 1e-4;

static bool starts_away(const job *j) { return j->away_angle > LEAST_ANGLE || j->away_distance > LEAST_DISTANCE; }

static void tell_of_start(const job *j) {
    double degrees = j->away_angle * (180.0 / SN_PI);
    const sn_scene_draft *d = &j->draft;
    if (!starts_away(j)) return;
    if (d->run_in > 0.0)
        cli_tell(&j->c,
                 "at frame %d bones are up to %.0f degrees and %.3g m from rest: they go there in the first %g s of a preroll of %g s",
                 d->first_frame, degrees, j->away_distance, d->run_in, d->preroll);
    else
        cli_warn(&j->c,
                 "at frame %d bones are up to %.0f degrees and %.3g m from rest, and begin there; --run-in takes them there from rest",
                 d->first_frame, degrees, j->away_distance);
}

/* Where the first frame is away from rest, the preroll goes there: two seconds, half of them on the way, for which an elbow's 120 degrees
 * have been tried (tests/cli/bodies.bats). */
static void choose_preroll(job *j) {
    const cli *c = &j->c;
    bool away = starts_away(j);
    double before = cli_given(c, "preroll") ? preroll : cli_given(c, "run-in") ? 2.0 * run_in : away ? 2.0 : 0.0;
    double moving = cli_given(c, "run-in") ? run_in : away ? 0.5 * before : 0.0;
    if (moving > before) cli_usage_error(c, "--run-in: %g s are more than the preroll, %g s, of which they are a part", moving, before);
    j->draft.preroll = before;
    j->draft.run_in = moving;
}

static sn_status choose_time(job *j, sn_error *error) {
    sn_status status = SN_OK;
    if (rate > 0.0) {
        j->draft.rate = rate;
        status = sn_draft_spread(&j->draft, error);
    }
    if (status == SN_OK && frames != NULL) choose_frames(j);
    if (status == SN_OK) status = sn_draft_away(&j->draft, &j->away_angle, &j->away_distance, error);
    if (status != SN_OK) return status;
    choose_preroll(j);
    return SN_OK;
}

static void tell_of_draft(const job *j) {
    tell_of_bones(j);
    tell_of_start(j);
}

/* ---- what has come of it --------------------------------------------------------------------------------------------------------- */

/* What is attached lies on its bone. Farther from it than this share of the muscle's diagonal, on average, the two are not of one place;
 * what was pinned may be off the bone, where an aponeurosis leaves it, but no farther than the muscle is long. */
static const double FARTHEST = 0.05, FARTHEST_PINNED = 1.0;

static bool is_pinned(const sn_attachment *a, sn_index i) {
    return a->reasons != NULL ? a->reasons[i] == SN_REASON_PIN : a->method != NULL && strcmp(a->method, "pin") == 0;
}

/* Mean distance, m, of those of the attached points that are pinned, or of those that are not, from the surface of the bone, in metres. */
static double mean_distance(const sn_muscle *rig, const sn_attachment *a, bool pinned, const sn_surface *surface) {
    double sum = 0.0;
    sn_index count = 0;
    for (sn_index i = 0; i < a->count; i++) {
        if (is_pinned(a, i) != pinned) continue;
        sn_vec3 p = sn_scale(rig->mesh.positions[a->vertices[i]], rig->meters_per_unit);
        sum += sn_surface_closest(surface, p, INFINITY).distance;
        count++;
    }
    return count > 0 ? sum / count : 0.0;
}

static void check_place(const job *j, const sn_scene_muscle *m, const sn_attachment *a, const sn_surface *surface, sn_index *count) {
    double size = m->rig.meters_per_unit * sn_box_diagonal(sn_mesh_box(&m->rig.mesh));
    for (int pinned = 0; pinned < 2; pinned++) {
        double distance = mean_distance(&m->rig, a, pinned, surface);
        if (!(distance > size * (pinned ? FARTHEST_PINNED : FARTHEST)) || (*count)++ >= NAMES_TOLD) continue;
        cli_warn(&j->c, "muscle \"%s\": what is %s to %s lies %.3g m from it: another unit, or another rest pose?", m->name,
                 pinned ? "pinned" : "attached", a->bone, distance);
    }
}

/* The muscles on one bone. */
static void check_places(const job *j, const char *name_of_bone, const sn_surface *surface, sn_index *count) {
    for (sn_index i = 0; i < j->scene.muscle_count; i++) {
        const sn_scene_muscle *m = &j->scene.muscles[i];
        for (sn_index a = 0; a < m->rig.attachment_count; a++)
            if (strcmp(m->rig.attachments[a].bone, name_of_bone) == 0) check_place(j, m, &m->rig.attachments[a], surface, count);
    }
}

/* How far the vertices of an envelope are from the bones that carry them most, over those of the bones seen so far. */
typedef struct envelope_place {
    double sum; /* m */
    sn_index count;
} envelope_place;

static void add_places(const sn_envelope *envelope, const char *name_of_bone, const sn_surface *surface, envelope_place *place) {
    for (sn_index v = 0; v < envelope->mesh.vertex_count; v++) {
        if (strcmp(envelope->bones[envelope->influences[v].bones[0]], name_of_bone) != 0) continue;
        place->sum += sn_surface_closest(surface, envelope->mesh.positions[v], INFINITY).distance;
        place->count++;
    }
}

static bool carries_any(const job *j, const char *name_of_bone) {
    for (sn_index i = 0; i < j->scene.surface_count; i++)
        for (sn_index b = 0; b < j->scene.surfaces[i].envelope.bone_count; b++)
            if (strcmp(j->scene.surfaces[i].envelope.bones[b], name_of_bone) == 0) return true;
    return false;
}

static void warn_of_envelopes(const job *j, const envelope_place *places) {
    for (sn_index i = 0; i < j->scene.surface_count; i++) {
        const sn_scene_surface *surface = &j->scene.surfaces[i];
        double distance = places[i].count > 0 ? places[i].sum / places[i].count : 0.0;
        if (distance > FARTHEST * sn_box_diagonal(sn_mesh_box(&surface->envelope.mesh)))
            cli_warn(
                &j->c,
                "envelope \"%s\": it lies %.3g m from the bones that carry it, on average: was it bound to bones of another rest pose?",
                surface->name, distance);
    }
}

static bool holds_any(const job *j, const char *name_of_bone) {
    for (sn_index i = 0; i < j->scene.muscle_count; i++)
        for (sn_index a = 0; a < j->scene.muscles[i].rig.attachment_count; a++)
            if (strcmp(j->scene.muscles[i].rig.attachments[a].bone, name_of_bone) == 0) return true;
    return false;
}

static sn_status check_bone_place(job *j, sn_scene_bone *held, envelope_place *places, sn_index *count, sn_error *error) {
    sn_surface *surface = NULL;
    if (held->mesh.triangle_count == 0 || (!holds_any(j, held->name) && !carries_any(j, held->name))) return SN_OK;
    sn_mesh_convert(&held->mesh, held->meters_per_unit, false);
    sn_status status = sn_surface_create_plain(&held->mesh, &surface, error);
    if (status != SN_OK) return status;
    check_places(j, held->name, surface, count);
    for (sn_index i = 0; i < j->scene.surface_count; i++)
        if (j->scene.surfaces[i].kind == SN_SURFACE_ENVELOPE) add_places(&j->scene.surfaces[i].envelope, held->name, surface, &places[i]);
    sn_surface_destroy(surface);
    return SN_OK;
}

static sn_status check_bone_places(job *j, sn_error *error) {
    envelope_place *places = SN_NEW(envelope_place, j->scene.surface_count);
    sn_status status = places != NULL ? SN_OK : sn_fail_memory(error, "the envelopes");
    sn_index count = 0;
    for (sn_index b = 0; b < j->scene.bone_count && status == SN_OK; b++)
        status = check_bone_place(j, &j->scene.bones[b], places, &count, error);
    if (count > NAMES_TOLD) cli_warn(&j->c, "and %d more attachments lie far from their bones", count - NAMES_TOLD);
    if (status == SN_OK) warn_of_envelopes(j, places);
    free(places);
    return status;
}

static sn_status check_grips(job *j, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < j->scene.muscle_count && status == SN_OK; i++) {
        const sn_scene_muscle *m = &j->scene.muscles[i];
        if (!m->enabled) continue; /* its rig is not read */
        if (m->rig.attachment_count == 0)
            cli_warn(&j->c, "muscle \"%s\" is attached to no bone and moves freely (attach-detect attaches it)", m->name);
        else
            status = grips_warn(&j->c, m->name, &m->rig, error);
    }
    return status;
}

/* ---- writing --------------------------------------------------------------------------------------------------------------------- */

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    sn_json_number(json, "rate", j->draft.rate);
    sn_json_indices(json, "frames", (const sn_index[2]){j->draft.first_frame, j->draft.last_frame}, 2);
    sn_json_number(json, "preroll", j->draft.preroll);
    sn_json_number(json, "runIn", j->draft.run_in);
    sn_json_number(json, "awayDegrees", j->away_angle * (180.0 / SN_PI));
    sn_json_number(json, "awayDistance", j->away_distance);
    sn_json_integer(json, "joints", j->draft.motion.joint_count);
    sn_json_integer(json, "bones", j->scene.bone_count);
    sn_json_integer(json, "envelopes", j->scene.surface_count);
    sn_json_integer(json, "muscles", j->scene.muscle_count);
    sn_json_integer(json, "musclesLeftOut", j->left_out);
    sn_json_integer(json, "musclesWithoutChannel", j->voiceless);
    sn_json_integer(json, "channelsWithoutMuscle", j->unheard);
}

/* For the history: one hash over the names and contents of all rigs. */
static sn_status hash_rigs(job *j, sn_error *error) {
    sn_status status = SN_OK;
    char *all = SN_NEW(char, (size_t)j->draft.muscle_count *SN_HASH_LENGTH + 1);
    if (all == NULL) return sn_fail_memory(error, "the history");
    for (sn_index i = 0; i < j->draft.muscle_count && status == SN_OK; i++) {
        sn_blob blob = {0};
        status = sn_blob_read(j->draft.muscles[i].path, &blob, error);
        if (status == SN_OK) sn_hash(blob.data, blob.size, all + (size_t)i * SN_HASH_LENGTH);
        sn_blob_free(&blob);
    }
    if (status == SN_OK) sn_hash(all, (size_t)j->draft.muscle_count * SN_HASH_LENGTH, j->c.input_hash);
    free(all);
    return status;
}

static sn_status make_history(job *j, cli_history *out, sn_error *error) {
    *out = (cli_history){0};
    if (!j->c.history) return SN_OK;
    j->c.hash_files = bones_hash;
    j->c.hash_user = &j->bones;
    sn_status status = hash_rigs(j, error);
    return status == SN_OK ? cli_history_make(&j->c, out, error) : status;
}

static sn_status write_scene(job *j, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(j->c.output, false, &output, error);
    if (status == SN_OK) status = sn_output_write(output, j->text.data, j->text.size, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status save(job *j, sn_error *error) {
    cli_history history;
    sn_status status = make_history(j, &history, error);
    const sn_history_entry *entry = j->c.history ? &history.entry : NULL;
    if (status == SN_OK && model_file != NULL) status = save_model(j, entry, error);
    if (status == SN_OK) status = sn_draft_finish(&j->draft, entry, &j->text, &j->scene, error);
    cli_history_free(&history);
    if (status == SN_OK) tell_of_draft(j);
    if (status == SN_OK) status = check_grips(j, error);
    if (status == SN_OK) status = check_bone_places(j, error);
    if (status == SN_OK) status = write_scene(j, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

/* ---- work ------------------------------------------------------------------------------------------------------------------------ */

/* Paths in the scene are from there. */
static sn_status check_folder(const job *j, sn_error *error) {
    const char *slash = strrchr(j->c.output, '/');
    if (list || slash == NULL || slash == j->c.output) return SN_OK;
    char *folder = sn_strndup(j->c.output, (size_t)(slash - j->c.output));
    if (folder == NULL) return sn_fail_memory(error, "a path");
    bool there = folder_is(folder);
    free(folder);
    return there ? SN_OK : sn_fail_at(error, SN_ERROR_IO, j->c.output, 0, "its folder is not there; make that first");
}

/* A scene in the place of a file that it names would be gone with what it needs. */
static void refuse_input(const job *j, const char *path) {
    struct stat output, input;
    if (path == NULL || stat(j->c.output, &output) != 0 || !S_ISREG(output.st_mode) || stat(path, &input) != 0) return;
    if (output.st_dev == input.st_dev && output.st_ino == input.st_ino)
        cli_usage_error(&j->c, "--output %s: the scene names this file, and would take its place", j->c.output);
}

static void check_output(const job *j) {
    if (list) return;
    refuse_input(j, motion_file);
    refuse_input(j, model_file);
    refuse_input(j, activation_file);
    for (sn_index i = 0; i < j->draft.muscle_count; i++) refuse_input(j, j->draft.muscles[i].path);
    for (sn_index i = 0; i < j->draft.bone_count; i++) refuse_input(j, j->draft.bones[i].bone.path);
    for (sn_index i = 0; i < j->draft.envelope_count; i++) refuse_input(j, j->draft.envelopes[i].path);
}

static sn_status name_scene(job *j, sn_error *error) {
    bool standard = strcmp(j->c.output, "-") == 0;
    sn_draft_defaults(&j->draft);
    j->draft.contact = contact, j->draft.externals = externals;
    j->draft.place = j->c.output;
    j->draft.method = (sn_solver_method)method;
    if (model_file == NULL && (bones_dir != NULL || bone_paths.count > 0))
        cli_usage_error(&j->c, "--bones-dir and --bone-path are for --model, which was not given");
    if (!standard && (j->name = stem_of(j->c.output)) == NULL) return sn_fail_memory(error, "a name");
    j->draft.name = name != NULL ? name : j->name;
    return SN_OK;
}

static sn_status collect(job *j, sn_error *error) {
    sn_status status = name_scene(j, error);
    if (status == SN_OK) status = check_folder(j, error);
    if (status == SN_OK) status = add_rigs(j, error);
    if (status == SN_OK && model_file != NULL)
        status = take_model(j, error);
    else if (status == SN_OK && motion_file != NULL)
        status = sn_draft_take_motion(&j->draft, motion_file, error);
    if (status == SN_OK) status = add_bones(j, error);
    if (status == SN_OK) status = add_envelopes(j, error);
    if (status == SN_OK) status = mark_solids(j, error);
    if (status == SN_OK) status = check_attachments(j, error);
    if (status == SN_OK) status = check_motion(j, error);
    if (status == SN_OK) status = take_activations(j, error);
    if (status == SN_OK) status = set_members(j, error);
    return status == SN_OK ? choose_time(j, error) : status;
}

static sn_status build(job *j, sn_error *error) {
    sn_status status = collect(j, error);
    if (status != SN_OK) return status;
    check_output(j);
    if (list) {
        tell_of_draft(j);
        return scene_list_print(&j->draft, error);
    }
    status = save(j, error);
    if (status == SN_OK)
        cli_say(&j->c, "%d muscles on %d bones, %d joints, frames %d to %d at %g a second", j->scene.muscle_count, j->scene.bone_count,
                j->draft.motion.joint_count, j->draft.first_frame, j->draft.last_frame, j->draft.rate);
    return status;
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    sn_status status = build(&j, &error);
    sn_scene_free(&j.scene);
    sn_blob_free(&j.text);
    sn_draft_free(&j.draft);
    bones_free(&j.bones);
    sn_clip_free(&j.clip);
    sn_model_bones_free(&j.model_bones);
    sn_blob_free(&j.model);
    sn_blob_free(&j.model_motion);
    free(j.name);
    free(j.folder);
    return cli_finish(&j.c, status, &error);
}
