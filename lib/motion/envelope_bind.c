/*
 * envelope_bind.c -- which bones carry a vertex of an envelope, and with what weights: by its distances to their surfaces.
 */
#include "sinew/envelope.h"

#include <stdlib.h>
#include <string.h>

enum { GRAIN = 64, CANDIDATES = SN_INFLUENCE_LIMIT + 1 };

/* The share of the way over which a weight bends at either end. */
static const double EASE = 0.2;

/* A bone that is searched. */
typedef struct bind_bone {
    sn_surface *surface;
    sn_box box;
} bind_bone;

/* The nearest bones of a vertex, one a joint, ascending by distance; of two alike the first bone. */
typedef struct candidates {
    sn_index count;
    sn_index bones[CANDIDATES];
    double distances[CANDIDATES];
} candidates;

typedef struct bind_work {
    const sn_mesh *mesh;
    const sn_envelope_bone *bones;
    const sn_envelope_params *params;
    sn_index bone_count;
    bind_bone *searched; /* (bone_count) */
    sn_influence *influences;
} bind_work;

/* ---- the nearest bones -------------------------------------------------------------------------------------------------------- */

static double box_distance(const sn_box *box, sn_vec3 p) {
    return sn_norm(sn_max3(sn_max3(sn_sub(box->low, p), sn_sub(p, box->high)), sn_v3(0, 0, 0)));
}

/* Nothing at this distance or beyond can come to carry the vertex. */
static double horizon(const candidates *near, double reach) {
    if (near->count == 0) return INFINITY;
    double limit = near->distances[0] + reach;
    return near->count == CANDIDATES ? fmin(limit, near->distances[CANDIDATES - 1]) : limit;
}

static void remove_candidate(candidates *near, sn_index k) {
    for (near->count--; k < near->count; k++) {
        near->bones[k] = near->bones[k + 1];
        near->distances[k] = near->distances[k + 1];
    }
}

/* Bones come in ascending order: what is as near as one before it goes behind it. */
static void add_candidate(candidates *near, const sn_envelope_bone *bones, sn_index bone, double distance) {
    for (sn_index k = 0; k < near->count; k++) {
        if (bones[near->bones[k]].joint != bones[bone].joint) continue;
        if (near->distances[k] <= distance) return;
        remove_candidate(near, k);
        break;
    }
    if (near->count == CANDIDATES) near->count--;
    sn_index at = near->count++;
    for (; at > 0 && near->distances[at - 1] > distance; at--) {
        near->bones[at] = near->bones[at - 1];
        near->distances[at] = near->distances[at - 1];
    }
    near->bones[at] = bone;
    near->distances[at] = distance;
}

static candidates find_candidates(const bind_work *w, sn_vec3 point) {
    candidates near = {0};
    for (sn_index b = 0; b < w->bone_count; b++) {
        double limit = horizon(&near, w->params->reach);
        if (box_distance(&w->searched[b].box, point) > limit) continue;
        sn_closest closest = sn_surface_closest(w->searched[b].surface, point, limit);
        if (closest.triangle != SN_NONE) add_candidate(&near, w->bones, b, closest.distance);
    }
    return near;
}

/* ---- weights ------------------------------------------------------------------------------------------------------------------ */

/* Of a bone that is `farther` than the nearest: 1 at 0, 0 from reach on (envelope.h). */
static double share(double farther, double reach) {
    double t = 0.5 * (1.0 - farther / reach);
    if (!(t > 0.0)) return 0.0;
    double w = t < EASE ? t * t / (2.0 * EASE * (1.0 - EASE)) : (t - 0.5 * EASE) / (1.0 - EASE);
    return w / (1.0 - w);
}

static sn_influence weigh(const candidates *near, double reach) {
    sn_influence out = {0};
    double shares[CANDIDATES] = {0}, sum = 0.0;
    for (sn_index k = 0; k < near->count; k++) shares[k] = share(near->distances[k] - near->distances[0], reach);
    double fifth = shares[CANDIDATES - 1] < shares[0] ? shares[CANDIDATES - 1] : 0.0; /* five that are equally near: the first four */
    for (sn_index k = 0; k < near->count && k < SN_INFLUENCE_LIMIT && shares[k] - fifth > 0.0; k++) sum += shares[k] - fifth;
    for (sn_index k = 0; k < near->count && k < SN_INFLUENCE_LIMIT; k++) {
        double weight = (shares[k] - fifth) / sum;
        if (!(weight > 0.0)) break;
        out.bones[out.count] = near->bones[k];
        out.weights[out.count++] = weight;
    }
    if (out.count == 1) out.weights[0] = 1.0;
    return out;
}

static void bind_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const bind_work *w = user;
    (void)chunk;
    for (sn_index v = begin; v < end; v++) {
        candidates near = find_candidates(w, w->mesh->positions[v]);
        w->influences[v] = weigh(&near, w->params->reach);
        if (w->params->clearance != NULL) w->params->clearance[v] = near.distances[0];
    }
}

/* ---- the whole ---------------------------------------------------------------------------------------------------------------- */

static sn_status check_bones(sn_index bone_count, const sn_envelope_bone *bones, const sn_envelope_params *params, sn_error *error) {
    if (bone_count < 1) return sn_fail(error, SN_ERROR_INPUT, "there is no bone to bind the envelope to");
    if (!(params->reach > 0.0) || !isfinite(params->reach))
        return sn_fail(error, SN_ERROR_USAGE, "the reach of an envelope is a length above 0, not %g", params->reach);
    for (sn_index b = 0; b < bone_count; b++) {
        sn_status status = sn_mesh_validate(bones[b].mesh, error);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

static sn_status open_bones(bind_work *w, sn_error *error) {
    sn_status status = SN_OK;
    if ((w->searched = SN_NEW(bind_bone, w->bone_count)) == NULL) return sn_fail_memory(error, "the bones of an envelope");
    for (sn_index b = 0; b < w->bone_count && status == SN_OK; b++) {
        w->searched[b].box = sn_mesh_box(w->bones[b].mesh);
        status = sn_surface_create_plain(w->bones[b].mesh, &w->searched[b].surface, error);
    }
    return status;
}

static sn_status fill(const bind_work *w, sn_envelope *out, sn_error *error) {
    *out = (sn_envelope){.method = w->params->method, .reach = w->params->reach, .bone_count = w->bone_count};
    out->bones = SN_NEW(char *, w->bone_count);
    out->influences = SN_NEW(sn_influence, w->mesh->vertex_count);
    if (out->bones == NULL || out->influences == NULL) return sn_fail_memory(error, "an envelope");
    for (sn_index b = 0; b < w->bone_count; b++)
        if ((out->bones[b] = sn_strdup(w->bones[b].name)) == NULL) return sn_fail_memory(error, "an envelope");
    return sn_mesh_copy(w->mesh, &out->mesh, error);
}

/* True where the trace stops. */
static bool trace_bones(const bind_work *w, const sn_envelope *envelope) {
    for (sn_index b = 0; b < w->bone_count && (sn_trace_wanted(w->params->trace) || sn_trace_stopped(w->params->trace)); b++) {
        sn_index alone = 0, shared = 0;
        for (sn_index v = 0; v < envelope->mesh.vertex_count; v++)
            for (sn_index k = 0; k < envelope->influences[v].count; k++)
                if (envelope->influences[v].bones[k] == b) (*(envelope->influences[v].count == 1 ? &alone : &shared))++;
        if (SN_TRACE(w->params->trace, "bone", sn_trace_text("name", w->bones[b].name), sn_trace_number("alone", alone),
                     sn_trace_number("shared", shared)))
            return true;
    }
    return false;
}

sn_status sn_envelope_bind(const sn_mesh *mesh, sn_index bone_count, const sn_envelope_bone *bones, const sn_envelope_params *params,
                           sn_envelope *out, sn_error *error) {
    bind_work work = {.mesh = mesh, .bones = bones, .params = params, .bone_count = bone_count};
    *out = (sn_envelope){0};
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK) status = check_bones(bone_count, bones, params, error);
    if (status == SN_OK) status = open_bones(&work, error);
    if (status == SN_OK) status = fill(&work, out, error);
    if (status == SN_OK) {
        work.influences = out->influences;
        sn_parallel_for(params->pool, mesh->vertex_count, GRAIN, bind_range, &work);
        status = sn_envelope_validate(out, error);
    }
    if (status == SN_OK && trace_bones(&work, out)) status = SN_OK; /* nothing is left to be done */
    for (sn_index b = 0; work.searched != NULL && b < bone_count; b++) sn_surface_destroy(work.searched[b].surface);
    free(work.searched);
    if (status != SN_OK) sn_envelope_free(out);
    return status;
}
