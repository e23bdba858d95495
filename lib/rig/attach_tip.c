/*
 * attach_tip.c -- tips that touch nothing: a muscle that plainly runs to a bone is held by it there, rather than by one bone alone.
 */
#include "attach_detection.h"

#include <stdlib.h>

/* A tip is free where nothing holds this share of the muscle's length at it. */
static const double FREE_SHARE = 0.1;
/* The bone lies within this share of the length of the tip, the next one at least so many times as far, and of the muscle what is nearest
 * to it lies within the last share of the length. */
static const double REACH_SHARE = 0.05, CLEARLY_FARTHER = 1.5, NEAREST_SHARE = 0.1;
/* What is taken: so much of the length farther from the bone than the nearest vertex. */
static const double DEPTH_SHARE = 0.015;

double attach_from_tip(const detection *d, int end, sn_index v) { return end == 0 ? d->along[v] : 1.0 - d->along[v]; }

static bool is_free_tip(const detection *d, int end) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (d->holder_of[v] != SN_NONE && attach_from_tip(d, end, v) < FREE_SHARE) return false;
    return true;
}

static bool may_take(const detection *d, sn_index bone) { return attach_holds_by_distance(d, bone) && !attach_holds_any(d, bone); }

/* Distance of the tip to a bone; INFINITY where that is beyond the limit. */
static sn_status measure_gap(const detection *d, sn_index bone, int end, double limit, double *gap, sn_error *error) {
    sn_vec3 tip = d->muscle->mesh.positions[d->tip[end]];
    const sn_mesh *mesh = d->params->bones[bone].mesh;
    *gap = INFINITY;
    if (sn_box_gap((sn_box){tip, tip}, sn_mesh_box(mesh)) > limit) return SN_OK;
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create_plain(mesh, &surface, error);
    if (status != SN_OK) return status;
    sn_closest closest = sn_surface_closest(surface, tip, limit);
    if (closest.triangle != SN_NONE) *gap = closest.distance;
    sn_surface_destroy(surface);
    return SN_OK;
}

/* The bone that the tip plainly runs to; SN_NONE = none, or it cannot be told which. */
static sn_status find_bone(const detection *d, int end, sn_index *bone, sn_error *error) {
    double reach = REACH_SHARE * d->length, nearest = INFINITY, second = INFINITY;
    sn_status status = SN_OK;
    *bone = SN_NONE;
    for (sn_index b = 0; b < d->params->bone_count && status == SN_OK; b++) {
        double gap = INFINITY;
        if (may_take(d, b)) status = measure_gap(d, b, end, CLEARLY_FARTHER * reach, &gap, error);
        if (gap < nearest) {
            second = nearest;
            nearest = gap;
            *bone = b;
        } else {
            second = fmin(second, gap);
        }
    }
    if (!(nearest <= reach) || second < CLEARLY_FARTHER * nearest) *bone = SN_NONE;
    return status;
}

sn_status attach_next_bone(const detection *d, sn_index than, int end, sn_index *bone, sn_error *error) {
    double nearest = REACH_SHARE * d->length, own;
    *bone = SN_NONE;
    sn_status status = measure_gap(d, than, end, nearest, &own, error);
    nearest = fmin(nearest, own);
    for (sn_index b = 0; b < d->params->bone_count && status == SN_OK; b++) {
        double gap = INFINITY;
        if (b != than && may_take(d, b)) status = measure_gap(d, b, end, nearest, &gap, error);
        if (!(gap < nearest)) continue;
        nearest = gap;
        *bone = b;
    }
    return status;
}

/* The vertex nearest to the bone, of candidate. */
static sn_index nearest_vertex(const detection *d) {
    sn_index best = 0;
    for (sn_index v = 1; v < d->muscle->mesh.vertex_count; v++)
        if (d->candidate[v] < d->candidate[best]) best = v;
    return best;
}

/* From the nearest vertex on, what is joined to it and hardly farther from the bone. */
static sn_status take(detection *d, sn_index bone, int end, sn_index start, sn_error *error) {
    const sn_topology *t = &d->topology;
    double limit = d->candidate[start] + fmax(DEPTH_SHARE * d->length, sn_mesh_mean_edge(&d->muscle->mesh, t));
    sn_index *stack = SN_NEW(sn_index, t->vertex_count), height = 0;
    if (stack == NULL) return sn_fail_memory(error, "attachments");
    attach_hold(d, start, bone, d->candidate[start], SN_REASON_NEAREST);
    stack[height++] = start;
    while (height > 0) {
        sn_index v = stack[--height];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (d->holder_of[w] != SN_NONE || !(d->candidate[w] <= limit) || !(attach_from_tip(d, end, w) < NEAREST_SHARE)) continue;
            attach_hold(d, w, bone, d->candidate[w], SN_REASON_NEAREST);
            stack[height++] = w;
        }
    }
    free(stack);
    return SN_OK;
}

sn_status attach_take_tip(detection *d, sn_index bone, int end, sn_error *error) {
    const sn_mesh *mesh = d->params->bones[bone].mesh;
    sn_bone_search search = {.muscle = &d->muscle->mesh, .bone = mesh, .box = sn_mesh_box(mesh)};
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(mesh, &surface, error);
    if (status != SN_OK) return status;
    search.surface = surface;
    sn_attach_pair *pair = &d->report->pairs[bone];
    double nearest = attach_measure(d, &search, bone, 2.0 * REACH_SHARE * d->length);
    sn_index start = nearest_vertex(d);
    if (isfinite(nearest) && d->holder_of[start] == SN_NONE && attach_from_tip(d, end, start) < NEAREST_SHARE) {
        status = take(d, bone, end, start, error);
        pair->tip = true;
        pair->culled = false;
        pair->nearest = nearest;
    }
    sn_surface_destroy(surface);
    return status;
}

sn_status attach_take_tips(detection *d, sn_error *error) {
    bool free_tip[2];
    sn_status status = SN_OK;
    if (!(d->length > 0.0)) return SN_OK;
    for (int end = 0; end < 2; end++) free_tip[end] = is_free_tip(d, end);
    for (int end = 0; end < 2 && status == SN_OK; end++) {
        sn_index bone = SN_NONE;
        if (free_tip[end]) status = find_bone(d, end, &bone, error);
        if (status == SN_OK && bone != SN_NONE) status = attach_take_tip(d, bone, end, error);
    }
    return status;
}
