/* bone_frames.c -- the bones' surfaces, posed at each frame: a point cache or a sequence for each, or all of them as VTP. */
#include "bone_frames.h"
#include "earlier.h"
#include "frame_files.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- where they go ---------------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end) {
    size_t length = strlen(text), tail = strlen(end);
    return length > tail && strcmp(text + length - tail, end) == 0;
}

static bool same_folder(const char *a, const char *b) {
    struct stat one, other;
    return a != NULL && b != NULL && stat(a, &one) == 0 && stat(b, &other) == 0 && one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

static sn_status check_names(const bone_request *request, const sn_scene *scene, sn_error *error) {
    bool shared = same_folder(request->path, request->output);
    for (sn_index b = 0; b < scene->bone_count; b++) {
        const char *name = scene->bones[b].name;
        for (sn_index i = 0; i < b; i++)
            if (frame_names_clash(name, scene->bones[i].name, ""))
                return sn_fail(error, SN_ERROR_INPUT, "the bones \"%s\" and \"%s\" would share a file of frames; rename one",
                               scene->bones[i].name, name);
        for (sn_index i = 0; shared && i < scene->muscle_count; i++)
            if (scene->muscles[i].enabled && frame_names_clash(name, scene->muscles[i].name, ""))
                return sn_fail(error, SN_ERROR_INPUT,
                               "the bone and the muscle \"%s\" would share a file of frames; give the bones a "
                               "folder of their own",
                               name);
    }
    return SN_OK;
}

/* ---- where the bones are ---------------------------------------------------------------------------------------------------- */

/* Seconds; in the middle of a frame the end of the substep at hand, whose poses the muscles have. */
static double time_of(const bone_run *run, const sn_state *state) {
    double frame = state->frame;
    if (state->substep > 0 || state->iteration > 0) frame += (double)(state->substep + (state->iteration > 0)) / run->substeps - 1.0;
    return frame / run->scene->rate;
}

/* The vertices of a bone in units of `unit` m. One that never moves stays as its file has it. */
static void pose_bone(const bone_run *run, const sn_scene_bone *bone, double unit, sn_vec3 *out) {
    const sn_rigid *pose = bone->joint != SN_NONE ? &run->poses[bone->joint] : NULL;
    for (sn_index i = 0; i < bone->mesh.vertex_count; i++) {
        sn_vec3 p = bone->mesh.positions[i];
        if (pose != NULL || unit != bone->meters_per_unit) {
            p = sn_scale(p, bone->meters_per_unit);
            if (pose != NULL) p = sn_rigid_apply(*pose, p);
            p = sn_v3(p.x / unit, p.y / unit, p.z / unit);
        }
        out[i] = p;
    }
}

/* Is there one to go on with? */
static sn_status resume_bone(bone_run *run, const bone_request *request, sn_index b, sn_error *error) {
    const sn_scene_bone *bone = &run->scene->bones[b];
    bone_target *t = &run->targets[b];
    bool goes_on = false;
    pose_bone(run, bone, bone->meters_per_unit, t->mesh.positions);
    sn_status status = request->ply ? earlier_sequence(t->path, &t->mesh, request->resume, &goes_on, error)
                                    : sn_pc2_resume(t->path, bone->mesh.vertex_count, request->resume, t->mesh.positions, &t->cache, error);
    run->continued += goes_on || t->cache != NULL;
    return status;
}

/* ---- a file for each bone ------------------------------------------------------------------------------------------------------ */

static sn_status open_bone(bone_run *run, const bone_request *request, sn_index b, sn_error *error) {
    const sn_scene_bone *bone = &run->scene->bones[b];
    bone_target *t = &run->targets[b];
    t->path = frame_path(request->path, bone->name, request->ply ? "" : ".pc2");
    if (t->path == NULL) return sn_fail_memory(error, "the frames of the bones");
    if (request->output != NULL && strcmp(t->path, request->output) == 0)
        return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\": its frames and the muscle's would both be %s", bone->name, t->path);
    sn_status status = request->ply ? frame_sequence_check(t->path, ".ply", &request->range, error) : SN_OK;
    if (status == SN_OK) status = sn_mesh_copy(&bone->mesh, &t->mesh, error);
    if (status == SN_OK && request->resume != NULL) status = resume_bone(run, request, b, error);
    if (status != SN_OK || request->ply || t->cache != NULL) return status;
    return sn_pc2_create(t->path, bone->mesh.vertex_count, request->range.first, 1.0, &t->cache, error);
}

static sn_status open_folder(bone_run *run, const bone_request *request, sn_error *error) {
    sn_status status = frame_folder_make(request->path, error);
    if (status == SN_OK) status = check_names(request, run->scene, error);
    if (status == SN_OK && (run->targets = SN_NEW(bone_target, run->scene->bone_count)) == NULL)
        status = sn_fail_memory(error, "the frames of the bones");
    for (sn_index b = 0; b < run->scene->bone_count && status == SN_OK; b++) status = open_bone(run, request, b, error);
    return status == SN_OK ? earlier_whole(request->path, run->continued, run->scene->bone_count, error) : status;
}

/* ---- all in one ------------------------------------------------------------------------------------------------------------------ */

/* The muscles' own, where all have the same: their frames are in it. Else metres. */
static double common_unit(const sn_scene *scene) {
    double unit = 0.0;
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        if (!scene->muscles[i].enabled) continue;
        double own = scene->muscles[i].rig.meters_per_unit;
        if (unit > 0.0 && own != unit) return 1.0;
        unit = own;
    }
    return unit > 0.0 ? unit : 1.0;
}

/* The triangles of all bones, and each vertex's bone as a number with its name. */
static sn_status join_bones(const sn_scene *scene, sn_mesh *all, sn_error *error) {
    int64_t vertices = 0, triangles = 0;
    for (sn_index b = 0; b < scene->bone_count; b++) {
        vertices += scene->bones[b].mesh.vertex_count;
        triangles += scene->bones[b].mesh.triangle_count;
    }
    if (vertices > SN_INDEX_MAX || triangles > SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "the bones are too many for one file");
    sn_status status = sn_mesh_alloc(all, (sn_index)vertices, (sn_index)triangles, error);
    if (status != SN_OK) return status;
    sn_attribute *number = sn_mesh_add_attribute(all, "bone", 1);
    bool enough = number != NULL;
    sn_index v = 0, t = 0;
    for (sn_index b = 0; b < scene->bone_count && enough; b++) {
        const sn_mesh *mesh = &scene->bones[b].mesh;
        for (sn_index k = 0; k < mesh->triangle_count; k++, t++)
            for (int i = 0; i < 3; i++) all->triangles[t].v[i] = v + mesh->triangles[k].v[i];
        for (sn_index k = 0; k < mesh->vertex_count; k++) number->values[v++] = b;
        enough = sn_attribute_add_label(number, scene->bones[b].name);
    }
    if (enough) number->integer = true;
    return enough ? SN_OK : sn_fail_memory(error, "the bones");
}

static sn_status open_collection(bone_run *run, const cli *c, const bone_request *request, sn_error *error) {
    char *prefix = sn_strndup(request->path, strlen(request->path) - strlen(".pvd"));
    sn_status status = prefix != NULL ? join_bones(run->scene, &run->all, error) : sn_fail_memory(error, "the frames of the bones");
    bool goes_on;
    if (status == SN_OK) status = frame_sequence_check(prefix, ".vtp", &request->range, error);
    if (status == SN_OK) status = sn_mesh_frames_create(prefix, &run->frames, error);
    if (status == SN_OK && request->resume != NULL) status = sn_mesh_frames_resume(run->frames, request->resume, &goes_on, error);
    run->meters_per_unit = common_unit(run->scene);
    cli_say(c, "%s: %d bones, %g m a unit", request->path, run->scene->bone_count, run->meters_per_unit);
    free(prefix);
    return status;
}

/* ---- frames -------------------------------------------------------------------------------------------------------------------- */

sn_status bone_frames_open(bone_run *run, const cli *c, const bone_request *request, const sn_scene *scene, sn_error *error) {
    if (request->path == NULL) return SN_OK;
    if (*request->path == '\0' || strcmp(request->path, "-") == 0) cli_usage_error(c, "--bone-frames needs a folder or NAME.pvd");
    bool collection = ends_with(request->path, ".pvd");
    if (collection && request->ply) cli_usage_error(c, "--bone-frames NAME.pvd is VTP: --format ply needs a folder");
    if (scene->bone_count == 0) return sn_fail(error, SN_ERROR_INPUT, "the scene has no bones whose frames could be written");
    *run = (bone_run){.scene = scene, .substeps = sn_solver_substeps(&scene->solver)};
    if ((run->poses = SN_NEW(sn_rigid, scene->motion.joint_count)) == NULL) return sn_fail_memory(error, "the bones' poses");
    if (request->resume != NULL) sn_motion_poses(&scene->motion, time_of(run, request->at), run->poses);
    return collection ? open_collection(run, c, request, error) : open_folder(run, request, error);
}

static sn_status write_bone(bone_run *run, sn_index b, sn_index frame, sn_error *error) {
    bone_target *t = &run->targets[b];
    pose_bone(run, &run->scene->bones[b], run->scene->bones[b].meters_per_unit, t->mesh.positions);
    if (t->cache == NULL) return frame_write_ply(t->path, frame, &t->mesh, error);
    sn_status status = sn_pc2_append(t->cache, t->mesh.positions, error);
    return status == SN_OK ? sn_pc2_publish(t->cache, error) : status;
}

sn_status bone_frames_write(bone_run *run, const sn_state *state, sn_error *error) {
    if (run->scene == NULL) return SN_OK;
    double time = time_of(run, state);
    sn_status status = SN_OK;
    sn_vec3 *at = run->all.positions;
    sn_motion_poses(&run->scene->motion, time, run->poses);
    for (sn_index b = 0; run->targets != NULL && b < run->scene->bone_count && status == SN_OK; b++)
        status = write_bone(run, b, state->frame, error);
    for (sn_index b = 0; run->frames != NULL && b < run->scene->bone_count; b++) {
        pose_bone(run, &run->scene->bones[b], run->meters_per_unit, at);
        at += run->scene->bones[b].mesh.vertex_count;
    }
    return status == SN_OK && run->frames != NULL ? sn_mesh_frames_append(run->frames, state->frame, time, &run->all, error) : status;
}

/* What is done is kept, whatever becomes of the others: the first failure is told. */
sn_status bone_frames_commit(bone_run *run, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index b = 0; run->targets != NULL && b < run->scene->bone_count; b++) {
        sn_pc2 *cache = run->targets[b].cache;
        run->targets[b].cache = NULL;
        sn_status committed = cache != NULL ? sn_pc2_commit(cache, status == SN_OK ? error : NULL) : SN_OK;
        if (status == SN_OK) status = committed;
    }
    if (run->frames == NULL) return status;
    sn_mesh_frames *frames = run->frames;
    run->frames = NULL;
    sn_status committed = sn_mesh_frames_commit(frames, status == SN_OK ? error : NULL);
    return status == SN_OK ? committed : status;
}

void bone_frames_free(bone_run *run) {
    for (sn_index b = 0; run->targets != NULL && b < run->scene->bone_count; b++) {
        sn_pc2_abort(run->targets[b].cache);
        sn_mesh_free(&run->targets[b].mesh);
        free(run->targets[b].path);
    }
    sn_mesh_frames_abort(run->frames);
    sn_mesh_free(&run->all);
    free(run->targets);
    free(run->poses);
    *run = (bone_run){0};
}
