/*
 * fit_feet.c -- how far feet slide while they stand.
 */
#include <stdlib.h>

#include "fit_align.h"

/* ---- stances ---------------------------------------------------------------------------------------------------------------------------
 */

typedef struct foot_work {
    const sn_fit_body *body;
    const sn_fit_result *fit;
    const sn_clip *source;
    sn_index frames;
    sn_fit_contact *contacts; /* (frames) of one foot */
    bool *stands;             /* (frames) from this frame to the next */
    sn_vec3 *way;             /* (frames) of a point of contact, over one stance */
} foot_work;

/* Horizontal step of the vertex that is lowest in frame f, to the next frame. */
static sn_vec3 slip(const foot_work *w, sn_index f) {
    const sn_fit_contact *contact = &w->contacts[f];
    const sn_fit_bone *bone = &w->body->bones[contact->bone];
    sn_vec3 next = sn_rigid_apply(w->fit->clip.joints[bone->joint].poses[f + 1], bone->mesh->positions[contact->vertex]);
    return sn_v3(next.x - contact->at.x, next.y - contact->at.y, 0.0);
}

/* The same of the source, scaled. */
static sn_vec3 source_slip(const foot_work *w, sn_index top, sn_index f) {
    sn_vec3 step = sn_fit_source_step(w->body, w->fit, w->source, top, f);
    return sn_v3(w->fit->scale * step.x, w->fit->scale * step.y, 0.0);
}

/* One step more on the way: the farthest that it is now from where it was since `first`. */
static double walk_on(foot_work *w, sn_index first, sn_index f, sn_vec3 step) {
    double farthest = 0.0;
    w->way[f + 1] = sn_add(w->way[f], step);
    for (sn_index k = first; k <= f; k++) farthest = fmax(farthest, sn_distance(w->way[f + 1], w->way[k]));
    return farthest;
}

static sn_fit_stance measure_stance(foot_work *w, sn_index top, sn_index first, sn_index last) {
    sn_fit_stance stance = {.first = first, .last = last};
    w->way[first] = sn_v3(0, 0, 0);
    for (sn_index f = first; f < last; f++) {
        sn_vec3 step = slip(w, f);
        stance.path += sn_norm(step);
        stance.travel = fmax(stance.travel, walk_on(w, first, f, step));
    }
    for (sn_index f = first; f < last; f++) stance.source_travel = fmax(stance.source_travel, walk_on(w, first, f, source_slip(w, top, f)));
    return stance;
}

static sn_status find_stances(foot_work *w, sn_fit_foot *foot, sn_error *error) {
    size_t capacity = 0;
    for (sn_index f = 0; f + 1 < w->frames; f++) {
        if (!w->stands[f]) continue;
        sn_index first = f;
        while (f + 1 < w->frames && w->stands[f]) f++;
        void *stances = foot->stances;
        if (!sn_grow(&stances, &capacity, (size_t)foot->stance_count + 1, sizeof *foot->stances))
            return sn_fail_memory(error, "the stances");
        foot->stances = stances;
        foot->stances[foot->stance_count++] = measure_stance(w, foot->joint, first, f);
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

static sn_status measure_foot(foot_work *w, const sn_fit_foot_params *params, sn_fit_foot *foot, sn_error *error) {
    const sn_fit_table *table = w->body->table;
    if (!sn_fit_contacts(w->body, &w->fit->clip, foot->joint, w->contacts))
        return sn_fail_at(error, SN_ERROR_INPUT, table->name, 0, "the foot \"%s\" has no bone", table->points[foot->joint].name);
    find_lowest(w, foot);
    double limit = w->fit->floor ? params->height : foot->lowest + params->height;
    sn_fit_stands(w->body, w->fit, w->source, foot->joint, params->speed, w->stands);
    for (sn_index f = 0; f + 1 < w->frames; f++)
        w->stands[f] = w->stands[f] && w->contacts[f].at.z <= limit && w->contacts[f + 1].at.z <= limit;
    return find_stances(w, foot, error);
}

sn_status sn_fit_feet(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, const sn_fit_foot_params *params,
                      sn_fit_foot **out, sn_error *error) {
    sn_index count = body->table->foot_count, frames = source->frame_count;
    foot_work w = {.body = body,
                   .fit = fit,
                   .source = source,
                   .frames = frames,
                   .contacts = SN_NEW(sn_fit_contact, frames),
                   .stands = SN_NEW(bool, frames),
                   .way = SN_NEW(sn_vec3, frames)};
    *out = SN_NEW(sn_fit_foot, count);
    sn_status status = *out != NULL && w.contacts != NULL && w.stands != NULL && w.way != NULL ? SN_OK : sn_fail_memory(error, "the feet");
    for (sn_index k = 0; k < count && status == SN_OK; k++) {
        (*out)[k].joint = body->table->feet[k].joint;
        status = measure_foot(&w, params, &(*out)[k], error);
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
