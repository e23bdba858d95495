/* motion_view.c -- motion documents in pictures: which frames there are, the bones' surfaces, words, the common floor. */
#include "motion_view.h"
#include "sinew/motion_clip.h"
#include "sinew/thread.h"

#include <stdio.h>
#include <stdlib.h>

/* A motion document as it is drawn. */
typedef struct document {
    sn_motion motion;
    char *name; /* nullable */
    double rate;
    int64_t first, last; /* frames within its keys, from its first to its last */
    sn_mesh *meshes;     /* (motion.bone_count) m, world, rest pose; NULL = none are shown */
    sn_box box;          /* of all joints over the motion */
} document;

static void document_free(document *d) {
    for (sn_index b = 0; d->meshes && b < d->motion.bone_count; b++) sn_mesh_free(&d->meshes[b]);
    free(d->meshes);
    free(d->name);
    sn_motion_free(&d->motion);
}

/* ---- the bones' surfaces -------------------------------------------------------------------------------------------------- */

typedef struct loading {
    document *document;
    sn_status *statuses;   /* (bone_count) */
    sn_error *errors;      /* (bone_count) */
    sn_mesh_frame *frames; /* (bone_count) */
} loading;

static void load_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    loading *l = user;
    for (sn_index b = begin; b < end; b++) {
        sn_mesh *mesh = &l->document->meshes[b];
        l->statuses[b] = sn_motion_bone_load(&l->document->motion.bones[b], 1.0, mesh, &l->frames[b], &l->errors[b]);
        sn_mesh_convert(mesh, l->frames[b].meters_per_unit, false);
    }
}

/* All of them, in parallel; the first that failed, in the document's order, is the error. */
static sn_status load_bones(document *d, int threads, sn_error *error) {
    sn_index count = d->motion.bone_count;
    loading l = {d, SN_NEW(sn_status, count), SN_NEW(sn_error, count), SN_NEW(sn_mesh_frame, count)};
    sn_space_seen seen = sn_space_begin();
    d->meshes = SN_NEW(sn_mesh, count);
    sn_pool *pool = l.statuses && l.errors && l.frames && d->meshes ? sn_pool_create(threads) : NULL;
    sn_status status = pool ? SN_OK : sn_fail_memory(error, "the bones");
    if (!status) sn_parallel_for(pool, count, 2, load_range, &l);
    for (sn_index b = 0; b < count && !status; b++) {
        status = l.statuses[b];
        if (status)
            *error = l.errors[b];
        else
            status = sn_space_take(&seen, l.frames[b].space, d->motion.bones[b].name, error);
    }
    sn_pool_destroy(pool);
    free(l.statuses);
    free(l.errors);
    free(l.frames);
    return status;
}

/* ---- the document ------------------------------------------------------------------------------------------------------------ */

/* Frames at f / rate within the keys. */
static sn_status set_span(document *d, sn_error *error) {
    double first = 0.0, frames = sn_clip_frames_of(&d->motion, d->rate);
    for (sn_index j = 0; j < d->motion.joint_count; j++) {
        const sn_joint *joint = &d->motion.joints[j];
        if (joint->key_count > 0) first = fmin(first, joint->keys[0].time);
        if (joint->kind == SN_JOINT_HINGE && joint->angle.count > 0) first = fmin(first, joint->angle.times[0]);
    }
    first = ceil(first * d->rate - 1e-6);
    if (!(fabs(first) < SN_FRAME_LIMIT) || !(frames < SN_FRAME_LIMIT))
        return sn_fail(error, SN_ERROR_INPUT, "the motion has %g frames at %g Hz; that is too long", frames, d->rate);
    d->first = (int64_t)first;
    d->last = d->first + (int64_t)frames - 1;
    return SN_OK;
}

static sn_status set_box(document *d, sn_error *error) {
    d->box = (sn_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    sn_status status = SN_OK;
    for (int64_t f = d->first; f <= d->last && !status; f++) status = sn_motion_extend(&d->motion, (double)f / d->rate, &d->box, error);
    return status;
}

static sn_status open_document(const motion_request *request, const sn_blob *blob, document *d, sn_error *error) {
    bool surfaces = (request->show & (SN_SHOW_AUTO | SN_SHOW_BONES)) != 0;
    sn_status status = sn_motion_document_parse(blob, &d->motion, &d->name, &d->rate, error);
    if (!status) status = set_span(d, error);
    if (!status && surfaces && d->motion.bone_count > 0) status = load_bones(d, request->c->threads, error);
    if (!status) status = set_box(d, error);
    sn_index placeless = status ? 0 : sn_motion_placeless(&d->motion);
    if (placeless > 0)
        cli_warn(request->c, "%s: %d of %d joints are not drawn: the document does not tell where they are (\"rest\")", request->path,
                 placeless, d->motion.joint_count);
    return status;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------------------- */

static sn_status name_picture(const document *d, int64_t frame, bool alone, motion_picture *out, sn_error *error) {
    char moment[64], text[160];
    snprintf(moment, sizeof moment, "frame %lld, %.2f s", (long long)frame, (double)frame / d->rate);
    snprintf(text, sizeof text, "%d joint%s, %s", d->motion.joint_count, d->motion.joint_count == 1 ? "" : "s", moment);
    out->caption = sn_strdup(moment);
    if (alone) out->view.subtitle = sn_strdup(text);
    if (d->name) out->view.title = sn_strdup(d->name);
    bool enough = out->caption && (!alone || out->view.subtitle) && (!d->name || out->view.title);
    return enough ? SN_OK : sn_fail_memory(error, "the words of a picture");
}

static sn_status draw_frame(const motion_request *request, const document *d, int64_t frame, bool alone, motion_picture *out,
                            sn_error *error) {
    if (frame < d->first || frame > d->last)
        return sn_fail(error, SN_ERROR_INPUT, "frame %lld is not among those of the motion: %lld to %lld at %g Hz", (long long)frame,
                       (long long)d->first, (long long)d->last, d->rate);
    sn_status status = name_picture(d, frame, alone, out, error);
    return status ? status : sn_view_add_motion(&out->view, &d->motion, d->meshes, (double)frame / d->rate, request->show, error);
}

/* Under all that is drawn; as high as the lowest joint of the motion where that is lower. */
static sn_status add_ground(const document *d, motion_picture *pictures, sn_index count, sn_error *error) {
    sn_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    sn_status status = SN_OK;
    for (sn_index i = 0; i < count; i++) {
        sn_box one = sn_view_box(&pictures[i].view);
        box = (sn_box){sn_min3(box.low, one.low), sn_max3(box.high, one.high)};
    }
    box.low.z = fmin(box.low.z, d->box.low.z);
    for (sn_index i = 0; i < count && !status; i++) status = sn_view_add_ground(&pictures[i].view, box, error);
    return status;
}

static frame_list chosen_frames(const motion_request *request, const document *d) {
    return request->frames.count > 0 ? request->frames : frames_spread(request->spread > 0 ? request->spread : 1, d->first, d->last);
}

void motion_pictures_free(motion_picture *pictures, sn_index count) {
    for (sn_index i = 0; pictures && i < count; i++) {
        sn_view_free(&pictures[i].view);
        free(pictures[i].caption);
    }
    free(pictures);
}

sn_status motion_pictures(const motion_request *request, const sn_blob *blob, motion_picture **out, sn_index *count, sn_error *error) {
    document d = {0};
    frame_list frames = {0};
    *out = NULL;
    *count = 0;
    sn_status status = open_document(request, blob, &d, error);
    if (!status) frames = chosen_frames(request, &d);
    if (!status && !(*out = SN_NEW(motion_picture, frames.count))) status = sn_fail_memory(error, "the pictures");
    if (!status) *count = frames.count;
    for (sn_index i = 0; i < frames.count && !status; i++)
        status = draw_frame(request, &d, frames.items[i], frames.count == 1, &(*out)[i], error);
    if (!status) status = add_ground(&d, *out, frames.count, error);
    document_free(&d);
    if (!status) return SN_OK;
    motion_pictures_free(*out, *count);
    *out = NULL;
    *count = 0;
    return status;
}
