/* scene_build.c -- a first scene out of its parts: what rigs, motion, bones and activations are in it, and how they belong together. */
#include "scene_build.h"

#include "sinew/exact.h"

#include <stdlib.h>
#include <string.h>

/* ---- the draft ----------------------------------------------------------------------------------------------------------- */

void sn_draft_defaults(sn_scene_draft *draft) { *draft = (sn_scene_draft){.rate = 24.0, .method = SN_SOLVER_QN}; }

static void free_muscle(sn_draft_muscle *muscle) {
    free(muscle->name);
    free(muscle->path);
    sn_muscle_free(&muscle->rig);
    for (int i = 0; i < SN_DRAFT_MEMBERS; i++) free(muscle->settings[i]);
}

static void free_bone(sn_motion_bone *bone) {
    free(bone->name);
    free(bone->path);
}

void sn_draft_free(sn_scene_draft *draft) {
    for (sn_index i = 0; i < draft->muscle_count; i++) free_muscle(&draft->muscles[i]);
    for (sn_index i = 0; i < draft->bone_count; i++) free_bone(&draft->bones[i].bone);
    for (sn_index i = 0; i < draft->envelope_count; i++) {
        free(draft->envelopes[i].name);
        free(draft->envelopes[i].path);
    }
    free(draft->muscles);
    free(draft->bones);
    free(draft->envelopes);
    free(draft->motion_path);
    free(draft->activation_path);
    sn_motion_free(&draft->motion);
    sn_muscle_names_free(&draft->channels);
    sn_draft_defaults(draft);
}

/* ---- rigs ---------------------------------------------------------------------------------------------------------------- */

static sn_draft_muscle *find_muscle(const sn_scene_draft *draft, const char *name) {
    for (sn_index i = 0; i < draft->muscle_count; i++)
        if (strcmp(draft->muscles[i].name, name) == 0) return &draft->muscles[i];
    return NULL;
}

static sn_status load_rig(const char *path, sn_draft_muscle *out, sn_error *error) {
    const sn_read_options options = {.meters_per_unit = 1.0}; /* as a scene in metres reads them */
    sn_blob blob = {0};
    sn_document *document = NULL;
    sn_status status = sn_blob_read(path, &blob, error);
    if (status == SN_OK) status = sn_muscle_parse(&blob, &options, &out->rig, &document, error);
    if (status == SN_OK) status = sn_muscle_validate(&out->rig, error);
    if (status != SN_OK) sn_error_set_file(error, path);
    sn_document_free(document);
    sn_blob_free(&blob);
    if (status != SN_OK) return status;
    out->path = sn_strdup(path);
    out->name = sn_muscle_call(&out->rig, path);
    return out->path != NULL && out->name != NULL ? SN_OK : sn_fail_memory(error, "a rig");
}

sn_status sn_draft_add_rig(sn_scene_draft *draft, const char *path, sn_error *error) {
    sn_draft_muscle muscle = {0};
    void *muscles = draft->muscles;
    sn_status status = load_rig(path, &muscle, error);
    const sn_draft_muscle *other = status == SN_OK ? find_muscle(draft, muscle.name) : NULL;
    if (other != NULL)
        status = sn_fail_at(error, SN_ERROR_INPUT, path, 0, "holds the muscle \"%s\", and so does %s; leave one of the two out",
                            muscle.name, other->path);
    else if (status == SN_OK && draft->muscle_count >= SN_LIST_LIMIT)
        status = sn_fail(error, SN_ERROR_INPUT, "there are more than %d rigs, the most that a scene may have", SN_LIST_LIMIT);
    if (status == SN_OK && !sn_grow(&muscles, &draft->muscle_capacity, (size_t)draft->muscle_count + 1, sizeof muscle))
        status = sn_fail_memory(error, "the rigs");
    if (status != SN_OK) {
        free_muscle(&muscle);
        return status;
    }
    draft->muscles = muscles;
    draft->muscles[draft->muscle_count++] = muscle;
    return SN_OK;
}

/* ---- bones --------------------------------------------------------------------------------------------------------------- */

static sn_draft_bone *find_bone(const sn_scene_draft *draft, const char *name) {
    for (sn_index i = 0; i < draft->bone_count; i++)
        if (strcmp(draft->bones[i].bone.name, name) == 0) return &draft->bones[i];
    return NULL;
}

const sn_draft_bone *sn_draft_find_bone(const sn_scene_draft *draft, const char *name) { return find_bone(draft, name); }

static sn_index find_joint(const sn_motion *motion, const char *name) {
    for (sn_index i = 0; i < motion->joint_count; i++)
        if (strcmp(motion->joints[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_status append_bone(sn_scene_draft *draft, const sn_motion_bone *bone, bool own, sn_error *error) {
    void *bones = draft->bones;
    sn_draft_bone copy = {.bone = *bone, .own = own};
    copy.bone.name = sn_strdup(bone->name);
    copy.bone.path = sn_strdup(bone->path);
    bool enough = copy.bone.name != NULL && copy.bone.path != NULL;
    if (!enough || !sn_grow(&bones, &draft->bone_capacity, (size_t)draft->bone_count + 1, sizeof copy)) {
        free_bone(&copy.bone);
        return sn_fail_memory(error, "the bones");
    }
    draft->bones = bones;
    draft->bones[draft->bone_count++] = copy;
    return SN_OK;
}

sn_status sn_draft_add_bone(sn_scene_draft *draft, const sn_motion_bone *bone, sn_error *error) {
    sn_draft_bone *before = find_bone(draft, bone->name);
    if (before != NULL && before->own)
        return sn_fail_at(error, SN_ERROR_INPUT, bone->path, 0,
                          "is called \"%s\", and so is %s; attachments could not tell the two bones apart", bone->name, before->bone.path);
    if (before == NULL) {
        sn_motion_bone bound = *bone;
        bound.joint = find_joint(&draft->motion, bone->name);
        return append_bone(draft, &bound, true, error);
    }
    char *path = sn_strdup(bone->path);
    if (path == NULL) return sn_fail_memory(error, "a path");
    free(before->bone.path);
    before->bone.path = path;
    before->bone.meters_per_unit = bone->meters_per_unit;
    before->own = true;
    return SN_OK;
}

sn_status sn_draft_bind(sn_scene_draft *draft, const char *text, sn_error *error) {
    const char *equals = strrchr(text, '=');
    if (equals == NULL || equals == text || equals[1] == '\0')
        return sn_fail(error, SN_ERROR_USAGE, "'%s' is not PATTERN=JOINT: bones by their names, and the joint that moves them", text);
    sn_index joint = find_joint(&draft->motion, equals + 1), count = 0;
    if (joint == SN_NONE)
        return sn_fail(error, SN_ERROR_INPUT, "'%s': the motion has no joint \"%s\"; rig-view draws the joints that it has", text,
                       equals + 1);
    char *pattern = sn_strndup(text, (size_t)(equals - text));
    if (pattern == NULL) return sn_fail_memory(error, "a pattern");
    for (sn_index i = 0; i < draft->bone_count; i++) {
        sn_draft_bone *b = &draft->bones[i];
        if (!sn_pattern_matches(pattern, b->bone.name)) continue;
        b->own = b->own || b->bone.joint != joint;
        b->bone.joint = joint;
        count++;
    }
    free(pattern);
    return count > 0 ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "'%s': there is no bone of that name", text);
}

/* ---- envelopes ----------------------------------------------------------------------------------------------------------- */

static const char *find_envelope(const sn_scene_draft *draft, const char *name) {
    for (sn_index i = 0; i < draft->envelope_count; i++)
        if (strcmp(draft->envelopes[i].name, name) == 0) return draft->envelopes[i].path;
    return NULL;
}

/* "skin.envelope.json" -> "skin". Allocated; NULL = out of memory. */
static char *call_envelope(const char *path) {
    static const char ending[] = ".envelope.json";
    const char *slash = strrchr(path, '/'), *file = slash != NULL ? slash + 1 : path;
    size_t length = strlen(file), tail = sizeof ending - 1;
    return length > tail && strcmp(file + length - tail, ending) == 0 ? sn_strndup(file, length - tail) : sn_path_stem(path);
}

sn_status sn_draft_add_envelope(sn_scene_draft *draft, const char *name, const char *path, sn_error *error) {
    struct sn_draft_envelope added = {.name = name != NULL ? sn_strdup(name) : call_envelope(path), .path = sn_strdup(path)};
    void *envelopes = draft->envelopes;
    bool enough = added.name != NULL && added.path != NULL;
    const sn_draft_bone *bone = enough ? find_bone(draft, added.name) : NULL;
    const char *other = bone != NULL ? bone->bone.path : enough ? find_envelope(draft, added.name) : NULL;
    sn_status status = SN_OK;
    if (other != NULL)
        status =
            sn_fail_at(error, SN_ERROR_INPUT, path, 0,
                       "is called \"%s\", and so is %s; attachments could not tell the two apart: name it by NAME=FILE", added.name, other);
    else if (!enough || !sn_grow(&envelopes, &draft->envelope_capacity, (size_t)draft->envelope_count + 1, sizeof added))
        status = sn_fail_memory(error, "the envelopes");
    if (status != SN_OK) {
        free(added.name);
        free(added.path);
        return status;
    }
    draft->envelopes = envelopes;
    draft->envelopes[draft->envelope_count++] = added;
    return SN_OK;
}

sn_status sn_draft_touch(sn_scene_draft *draft, const char *name, sn_error *error) {
    for (sn_index i = 0; i < draft->envelope_count; i++) {
        if (strcmp(draft->envelopes[i].name, name) != 0) continue;
        draft->envelopes[i].solid = true;
        return SN_OK;
    }
    return sn_fail(error, SN_ERROR_USAGE, "there is no envelope \"%s\"; name one of those given by --envelope", name);
}

const char *sn_draft_missing_bone(const sn_scene_draft *draft, const sn_draft_muscle *muscle) {
    for (sn_index i = 0; i < muscle->rig.attachment_count; i++) {
        const char *name = muscle->rig.attachments[i].bone;
        bool there = find_bone(draft, name) != NULL || find_envelope(draft, name) != NULL || find_joint(&draft->motion, name) != SN_NONE;
        if (!there) return name;
    }
    return NULL;
}

/* ---- the motion ---------------------------------------------------------------------------------------------------------- */

static void extend(const double *times, sn_index count, double *first, double *last) {
    if (count == 0) return;
    *first = fmin(*first, times[0]);
    *last = fmax(*last, times[count - 1]);
}

sn_status sn_draft_spread(sn_scene_draft *draft, sn_error *error) {
    double first = 0.0, last = 0.0;
    for (sn_index j = 0; j < draft->motion.joint_count; j++) {
        const sn_joint *joint = &draft->motion.joints[j];
        if (joint->kind == SN_JOINT_HINGE) {
            extend(joint->angle.times, joint->angle.count, &first, &last);
        } else if (joint->key_count > 0) {
            first = fmin(first, joint->keys[0].time);
            last = fmax(last, joint->keys[joint->key_count - 1].time);
        }
    }
    double begin = floor(first * draft->rate + 1e-6), end = ceil(last * draft->rate - 1e-6);
    if (!(fabs(begin) <= SN_FRAME_LIMIT) || !(fabs(end) <= SN_FRAME_LIMIT))
        return sn_fail(error, SN_ERROR_INPUT, "the motion goes from %g s to %g s: too many frames at %g a second", first, last,
                       draft->rate);
    draft->first_frame = (sn_index)begin;
    draft->last_frame = (sn_index)end;
    return SN_OK;
}

sn_status sn_draft_put_motion(sn_scene_draft *draft, sn_motion *motion, double rate, const char *path, sn_error *error) {
    sn_status status = SN_OK;
    draft->motion = *motion;
    *motion = (sn_motion){0};
    draft->rate = rate;
    if ((draft->motion_path = sn_strdup(path)) == NULL) return sn_fail_memory(error, "a path");
    for (sn_index i = 0; i < draft->motion.bone_count && status == SN_OK; i++)
        status = append_bone(draft, &draft->motion.bones[i], false, error);
    return status == SN_OK ? sn_draft_spread(draft, error) : status;
}

sn_status sn_draft_take_motion(sn_scene_draft *draft, const char *path, sn_error *error) {
    sn_blob blob = {0};
    sn_motion motion = {0};
    char *name = NULL;
    double rate = 0.0;
    sn_status status = sn_blob_read(path, &blob, error);
    const char *format = status == SN_OK && !sn_motion_document_detect(&blob) ? sn_clip_detect(&blob) : NULL;
    if (format != NULL)
        status = sn_fail_at(error, SN_ERROR_INPUT, path, 0, "is %s; make a motion document of it with motion-import or motion-fit", format);
    if (status == SN_OK) status = sn_motion_document_parse(&blob, &motion, &name, &rate, error);
    sn_blob_free(&blob);
    free(name);
    return status == SN_OK ? sn_draft_put_motion(draft, &motion, rate, path, error) : status;
}

/* Where the joint turns about, in the rest pose; the origin where nothing tells. */
static sn_vec3 centre_of(const sn_joint *joint) {
    if (joint->has_rest) return joint->rest;
    return joint->kind == SN_JOINT_HINGE ? joint->point : sn_v3(0, 0, 0);
}

sn_status sn_draft_away(const sn_scene_draft *draft, double *angle, double *distance, sn_error *error) {
    const sn_motion *motion = &draft->motion;
    *angle = *distance = 0.0;
    sn_rigid *poses = SN_NEW(sn_rigid, motion->joint_count);
    if (poses == NULL) return sn_fail_memory(error, "the joints' poses");
    sn_motion_poses(motion, draft->first_frame / draft->rate, poses);
    for (sn_index i = 0; i < draft->bone_count; i++) {
        sn_index j = draft->bones[i].bone.joint;
        if (j == SN_NONE) continue;
        sn_vec3 centre = centre_of(&motion->joints[j]);
        *angle = fmax(*angle, 2.0 * sn_acos(fmin(fabs(poses[j].rotation.w), 1.0)));
        *distance = fmax(*distance, sn_distance(sn_rigid_apply(poses[j], centre), centre));
    }
    free(poses);
    return SN_OK;
}

/* ---- activations --------------------------------------------------------------------------------------------------------- */

sn_status sn_draft_take_activations(sn_scene_draft *draft, const char *path, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status == SN_OK) status = sn_activation_names_parse(&blob, &draft->channels, error);
    sn_blob_free(&blob);
    if (status != SN_OK) return status;
    if ((draft->activation_path = sn_strdup(path)) == NULL) return sn_fail_memory(error, "a path");
    for (sn_index i = 0; i < draft->channels.count; i++) {
        sn_draft_muscle *muscle = find_muscle(draft, draft->channels.names[i]);
        if (muscle != NULL) muscle->has_channel = true;
    }
    return SN_OK;
}
