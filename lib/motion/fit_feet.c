/*
 * fit_feet.c -- where feet touch the ground, and how far they slide while they stand.
 */
#include <stdlib.h>

#include "fit_align.h"

static void lower(const sn_mesh *mesh, sn_rigid pose, sn_index bone, sn_fit_contact *out) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 p = sn_rigid_apply(pose, mesh->positions[v]);
        if (out->bone == SN_NONE || p.z < out->at.z) *out = (sn_fit_contact){p, bone, v};
    }
}

bool sn_fit_contacts(const sn_fit_body *body, const sn_clip *fitted, sn_index top, sn_fit_contact *out) {
    for (sn_index f = 0; f < fitted->frame_count; f++) out[f].bone = SN_NONE;
    for (sn_index b = 0; b < body->bone_count; b++) {
        const sn_fit_bone *bone = &body->bones[b];
        if (bone->joint == SN_NONE || !sn_fit_below(body->table, bone->joint, top)) continue;
        for (sn_index f = 0; f < fitted->frame_count; f++) lower(bone->mesh, fitted->joints[bone->joint].poses[f], b, &out[f]);
    }
    return out[0].bone != SN_NONE;
}

/* ---- stances ---------------------------------------------------------------------------------------------------------------------------
 */

typedef struct foot_work {
    sn_index frames;
    sn_fit_contact *contacts; /* (frames) */
    bool *stands;             /* (frames) from this frame to the next */
    sn_vec3 *way;             /* (frames) of the point of contact, over one stance */
} foot_work;

/* Horizontal step of the vertex that is lowest in frame f, to the next frame. */
static sn_vec3 slip(const sn_fit_body *body, const sn_clip *fitted, const sn_fit_contact *contact, sn_index f) {
    const sn_fit_bone *bone = &body->bones[contact->bone];
    sn_vec3 next = sn_rigid_apply(fitted->joints[bone->joint].poses[f + 1], bone->mesh->positions[contact->vertex]);
    return sn_v3(next.x - contact->at.x, next.y - contact->at.y, 0.0);
}

static sn_fit_stance measure_stance(const sn_fit_body *body, const sn_clip *fitted, foot_work *w, sn_index first, sn_index last) {
    sn_fit_stance stance = {first, last, 0.0, 0.0};
    sn_vec3 at = {0, 0, 0};
    w->way[first] = at;
    for (sn_index f = first; f < last; f++) {
        sn_vec3 step = slip(body, fitted, &w->contacts[f], f);
        stance.path += sn_norm(step);
        at = w->way[f + 1] = sn_add(at, step);
        for (sn_index k = first; k <= f; k++) stance.travel = fmax(stance.travel, sn_distance(at, w->way[k]));
    }
    return stance;
}

static sn_status find_stances(const sn_fit_body *body, const sn_clip *fitted, foot_work *w, sn_fit_foot *foot, sn_error *error) {
    size_t capacity = 0;
    for (sn_index f = 0; f + 1 < w->frames; f++) {
        if (!w->stands[f]) continue;
        sn_index first = f;
        while (f + 1 < w->frames && w->stands[f]) f++;
        void *stances = foot->stances;
        if (!sn_grow(&stances, &capacity, (size_t)foot->stance_count + 1, sizeof *foot->stances))
            return sn_fail_memory(error, "the stances");
        foot->stances = stances;
        foot->stances[foot->stance_count++] = measure_stance(body, fitted, w, first, f);
    }
    return SN_OK;
}

static void find_lowest(const foot_work *w, sn_fit_foot *foot) {
    foot->lowest = INFINITY;
    for (sn_index f = 0; f < w->frames; f++)
        if (w->contacts[f].at.z < foot->lowest) {
            foot->lowest = w->contacts[f].at.z;
            foot->lowest_frame = f;
        }
}

static sn_status measure_foot(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, const sn_fit_foot_params *params,
                              foot_work *w, sn_fit_foot *foot, sn_error *error) {
    if (!sn_fit_contacts(body, &fit->clip, foot->joint, w->contacts))
        return sn_fail_at(error, SN_ERROR_INPUT, body->table->name, 0, "the foot \"%s\" has no bone",
                          body->table->points[foot->joint].name);
    find_lowest(w, foot);
    double limit = fit->floor ? params->height : foot->lowest + params->height;
    sn_fit_stands(body, fit, source, foot->joint, params->speed, w->stands);
    for (sn_index f = 0; f + 1 < w->frames; f++)
        w->stands[f] = w->stands[f] && w->contacts[f].at.z <= limit && w->contacts[f + 1].at.z <= limit;
    return find_stances(body, &fit->clip, w, foot, error);
}

sn_status sn_fit_feet(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, const sn_fit_foot_params *params,
                      sn_fit_foot **out, sn_error *error) {
    sn_index count = body->table->foot_count, frames = source->frame_count;
    foot_work w = {frames, SN_NEW(sn_fit_contact, frames), SN_NEW(bool, frames), SN_NEW(sn_vec3, frames)};
    *out = SN_NEW(sn_fit_foot, count);
    sn_status status = *out != NULL && w.contacts != NULL && w.stands != NULL && w.way != NULL ? SN_OK : sn_fail_memory(error, "the feet");
    for (sn_index k = 0; k < count && status == SN_OK; k++) {
        (*out)[k].joint = body->table->feet[k].joint;
        status = measure_foot(body, fit, source, params, &w, &(*out)[k], error);
    }
    free(w.contacts);
    free(w.stands);
    free(w.way);
    if (status != SN_OK) {
        sn_fit_feet_free(*out, count);
        *out = NULL;
    }
    return status;
}

void sn_fit_feet_free(sn_fit_foot *feet, sn_index count) {
    for (sn_index k = 0; k < count && feet != NULL; k++) free(feet[k].stances);
    free(feet);
}
