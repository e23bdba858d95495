/* model_bones.c -- the mesh files that show a model's bodies: where they are, what the bones are called, their place in the rest pose. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "clip_reader.h"
#include "document.h"

/* Bytes of a bone's name: a file is called by it, with a number and an ending behind. */
enum { LONGEST_NAME = 200, LONGEST_PATH = 4096 };

/* ---- files ------------------------------------------------------------------------------------------------------------------------- */

static bool is_file(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

/* Behind the last slash of either kind: models are written on Windows too. */
static const char *last_part(const char *path) {
    const char *part = path;
    for (const char *c = path; *c != '\0'; c++)
        if (*c == '/' || *c == '\\') part = c + 1;
    return part;
}

/* "FOLDER/SUB/FILE", if that is a file; SUB may be empty, FOLDER too: the working directory. */
static bool try_path(const char *folder, const char *sub, const char *file, char *path) {
    const char *between = *folder != '\0' && folder[strlen(folder) - 1] != '/' ? "/" : "";
    int length = snprintf(path, LONGEST_PATH, "%s%s%s%s%s", folder, between, sub, *sub != '\0' ? "/" : "", file);
    return length > 0 && length < LONGEST_PATH && is_file(path);
}

/* A file as the model calls it: in the folders that were named, beside the model, in its Geometry; and there without its own folders. */
static bool find_file(const sn_bone_search *search, const char *model, const char *wanted, char *path) {
    char file[LONGEST_PATH], beside[LONGEST_PATH] = "";
    const char *slash = strrchr(model, '/');
    size_t length = strlen(wanted), folder = slash != NULL ? (size_t)(slash - model) + 1 : 0;
    if (length >= sizeof file || folder >= sizeof beside) return false;
    for (size_t i = 0; i <= length; i++) file[i] = wanted[i] == '\\' ? '/' : wanted[i];
    memcpy(beside, model, folder);
    if (*file == '/' && try_path("", "", file, path)) return true;
    for (int pass = 0; pass < 2; pass++) {
        const char *name = pass == 0 ? file : last_part(file);
        if (*name == '\0' || *name == '/') continue;
        for (int i = 0; i < search->folder_count; i++)
            if (try_path(search->folders[i], "", name, path)) return true;
        if (try_path(beside, "", name, path) || try_path(beside, "Geometry", name, path)) return true;
    }
    return false;
}

/* ---- names ------------------------------------------------------------------------------------------------------------------------- */

/* The bones so far; of each the name that it was to have, and the number behind it. */
typedef struct naming {
    sn_model_bones *out;
    char **wanted;    /* (mesh_count) owned */
    sn_index *number; /* (mesh_count) 1 = none was needed */
} naming;

/* Fit to name a file: no folders, no control characters, not hidden, not too long. */
static char *fit_name(const char *text) {
    size_t length = strlen(text);
    for (; length > LONGEST_NAME || (length > 0 && length < strlen(text) && ((unsigned char)text[length] & 0xC0) == 0x80); length--) {}
    char *name = length > 0 ? sn_strndup(text, length) : sn_strdup("bone");
    for (char *c = name; name != NULL && *c != '\0'; c++)
        if (*c == '/' || *c == '\\' || (unsigned char)*c < ' ' || *c == 0x7f || (*c == '.' && c == name)) *c = '_';
    return name;
}

static bool is_taken(const sn_model_bones *out, const char *name) {
    for (sn_index i = 0; i < out->count; i++)
        if (strcmp(out->bones[i].name, name) == 0) return true;
    return false;
}

/* `wanted`, or with _2, _3, ... behind it where that is taken. */
static char *distinct_name(naming *n, const char *wanted) {
    char name[LONGEST_NAME + 16];
    sn_index number = 1;
    for (sn_index i = n->out->count; i-- > 0 && number == 1;)
        if (strcmp(n->wanted[i], wanted) == 0) number = n->number[i] + 1; /* so that many of one name take no more than one try each */
    snprintf(name, sizeof name, "%s", wanted);
    while (number > 1 || is_taken(n->out, name)) {
        if (number < 2) number = 2;
        snprintf(name, sizeof name, "%s_%d", wanted, (int)number);
        if (!is_taken(n->out, name)) break;
        number++;
    }
    n->number[n->out->count] = number;
    return sn_strdup(name);
}

/* OpenSim calls a mesh by its body and a number, MuJoCo by what it shows: the file tells it there. */
static char *wanted_name(const sn_skeleton *s, const sn_skeleton_mesh *mesh) {
    char *stem = s->up_y ? sn_path_stem(last_part(mesh->file)) : NULL;
    char *name = fit_name(stem != NULL ? stem : mesh->name);
    free(stem);
    return name;
}

/* ---- bones ------------------------------------------------------------------------------------------------------------------------- */

static bool same_vec3(sn_vec3 a, sn_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* The same file at the same place: models name one for being seen and one for being hit. */
static bool repeats(const sn_skeleton_mesh *a, const sn_skeleton_mesh *b) {
    const sn_quat p = a->frame.rotation, q = b->frame.rotation;
    return a->body == b->body && strcmp(a->file, b->file) == 0 && same_vec3(a->scale, b->scale) &&
           same_vec3(a->frame.translation, b->frame.translation) && p.w == q.w && p.x == q.x && p.y == q.y && p.z == q.z;
}

static bool is_repeated(const sn_skeleton *s, sn_index index) {
    for (sn_index i = 0; i < index; i++)
        if (repeats(&s->meshes[i], &s->meshes[index])) return true;
    return false;
}

static sn_status add_bone(naming *n, const sn_skeleton *s, const sn_skeleton_mesh *mesh, const sn_rigid *frames, const char *path,
                          sn_error *error) {
    sn_model_bones *out = n->out;
    sn_model_bone *bone = &out->bones[out->count];
    sn_rigid body = mesh->body != SN_NONE ? frames[mesh->body] : sn_rigid_identity();
    if (mesh->scale.x == 0.0 || mesh->scale.y == 0.0 || mesh->scale.z == 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "the mesh \"%.100s\" has a scale of 0, which leaves nothing of it", mesh->file);
    if (out->count == SN_LIST_LIMIT) return sn_fail(error, SN_ERROR_INPUT, "the model has more than %d meshes", (int)SN_LIST_LIMIT);
    n->wanted[out->count] = wanted_name(s, mesh);
    *bone = (sn_model_bone){.joint = mesh->body, .scale = mesh->scale, .frame = sn_rigid_compose(body, mesh->frame)};
    bone->name = n->wanted[out->count] != NULL ? distinct_name(n, n->wanted[out->count]) : NULL;
    bone->path = sn_strdup(path);
    out->count++;
    return bone->name != NULL && bone->path != NULL ? SN_OK : sn_fail_memory(error, "a bone");
}

static sn_status find_bones(naming *n, const sn_skeleton *s, const sn_rigid *frames, const char *model, const sn_bone_search *search,
                            sn_error *error) {
    sn_status status = SN_OK;
    char path[LONGEST_PATH];
    for (sn_index i = 0; i < s->mesh_count && status == SN_OK; i++) {
        const sn_skeleton_mesh *mesh = &s->meshes[i];
        if (is_repeated(s, i)) continue;
        if (find_file(search, model, mesh->file, path))
            status = add_bone(n, s, mesh, frames, path, error);
        else if (n->out->missing++ == 0 && (n->out->first_missing = sn_strdup(mesh->file)) == NULL)
            status = sn_fail_memory(error, "a name");
    }
    return status;
}

static sn_status say_missing(const sn_model_bones *out, const char *model, sn_error *error) {
    int missing = (int)out->missing, all = missing + (int)out->count;
    if (all == 0) return sn_fail(error, SN_ERROR_INPUT, "the model names no mesh file that shows a body");
    if (out->count == 0)
        return sn_fail(error, SN_ERROR_INPUT, "none of the model's %d mesh files is there, the first is %.200s; name their folder", all,
                       out->first_missing);
    if (missing > 0)
        sn_log(SN_LOG_WARNING, "%s: %d of the model's %d mesh files are not there and are left out, the first is %.200s", model, missing,
               all, out->first_missing);
    return SN_OK;
}

sn_status sn_model_bones_find(const sn_skeleton *s, const char *model, const sn_clip_options *options, sn_error *error) {
    sn_model_bones *out = options->bones->found;
    naming n = {.out = out, .wanted = SN_NEW(char *, s->mesh_count), .number = SN_NEW(sn_index, s->mesh_count)};
    double *rest = SN_NEW(double, s->coordinate_count);
    sn_rigid *frames = SN_NEW(sn_rigid, s->body_count);
    *out = (sn_model_bones){.bones = SN_NEW(sn_model_bone, s->mesh_count), .meters_per_unit = options->meters_per_unit};
    out->up_y = options->up == SN_UP_UNKNOWN ? s->up_y : options->up == SN_UP_Y;
    bool enough = n.wanted != NULL && n.number != NULL && rest != NULL && frames != NULL && out->bones != NULL;
    sn_status status = enough ? SN_OK : sn_fail_memory(error, "bones");
    if (status == SN_OK) {
        sn_skeleton_rest(s, rest);
        sn_skeleton_frames(s, rest, frames);
        status = find_bones(&n, s, frames, model, options->bones, error);
    }
    if (status == SN_OK) status = say_missing(out, model, error);
    for (sn_index i = 0; n.wanted != NULL && i < out->count; i++) free(n.wanted[i]);
    free(n.wanted);
    free(n.number);
    free(rest);
    free(frames);
    return status;
}

/* What is said per vertex would not turn with it: normals. */
static void drop_attributes(sn_mesh *mesh) {
    while (mesh->attribute_count > 0) sn_mesh_remove_attribute(mesh, mesh->attributes[mesh->attribute_count - 1].name);
}

sn_status sn_model_bones_load(const sn_model_bones *bones, sn_index index, sn_mesh *out, sn_error *error) {
    const sn_model_bone *bone = &bones->bones[index];
    sn_vec3 scale = bone->scale;
    sn_status status = sn_mesh_read(bone->path, out, NULL, error);
    if (status != SN_OK) return status;
    drop_attributes(out);
    for (sn_index v = 0; v < out->vertex_count; v++) {
        sn_vec3 p = out->positions[v];
        out->positions[v] = sn_rigid_apply(bone->frame, sn_v3(scale.x * p.x, scale.y * p.y, scale.z * p.z));
    }
    sn_mesh_convert(out, bones->meters_per_unit, bones->up_y);
    for (sn_index t = 0; scale.x * scale.y * scale.z < 0.0 && t < out->triangle_count; t++) { /* mirrored: the outside stays outside */
        sn_index corner = out->triangles[t].v[1];
        out->triangles[t].v[1] = out->triangles[t].v[2];
        out->triangles[t].v[2] = corner;
    }
    status = sn_mesh_validate(out, error);
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, bone->path);
    sn_mesh_free(out);
    return status;
}

void sn_model_bones_free(sn_model_bones *bones) {
    for (sn_index i = 0; i < bones->count; i++) {
        free(bones->bones[i].name);
        free(bones->bones[i].path);
    }
    free(bones->bones);
    free(bones->first_missing);
    *bones = (sn_model_bones){0};
}
