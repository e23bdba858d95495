/*
 * attach.c -- which vertices of a muscle move with which bone ([K21] 3.3): pins, contact, proximity.
 */
#include "sinew/rig.h"

#include <stdlib.h>
#include <string.h>

/* Why a vertex is attached; a bone's method is the union over its vertices. */
enum { RULE_PIN = 1, RULE_CONTACT = 2, RULE_PROXIMITY = 4 };

enum { VERTICES_PER_CHUNK = 256 };

/* A detection under way. A "holder" is what a vertex may hang on: the bones in the order given, then bones that only pins name. */
typedef struct detection {
    const sn_muscle *muscle;
    sn_index bone_count;
    const sn_attach_bone *bones;
    const sn_attach_params *params;
    sn_topology topology;
    sn_box box;   /* of the muscle */
    double reach; /* proximity: closer than this; 0 without */
    sn_index holder_count;
    const char **holders;  /* (holder_count) names; borrowed */
    sn_index *holder_of;   /* (vertex_count) SN_NONE = free */
    double *distance;      /* (vertex_count) signed, to the holder; NaN = not known */
    unsigned char *rule;   /* (vertex_count) the RULE_ that attached it */
    double *chunk_nearest; /* (chunks) */
} detection;

/* ---- boxes --------------------------------------------------------------------------------------------------------------- */

/* Distance of two boxes, 0 where they overlap; a point is a box without size. */
static double box_gap(sn_box a, sn_box b) {
    sn_vec3 apart = sn_max3(sn_sub(a.low, b.high), sn_sub(b.low, a.high));
    return sn_norm(sn_max3(apart, sn_v3(0, 0, 0)));
}

/* ---- set-up ---------------------------------------------------------------------------------------------------------------- */

sn_attach_params sn_attach_defaults(void) {
    return (sn_attach_params){.methods = SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY, .distance = -1.0};
}

static sn_status check_bone(const detection *d, sn_index b, sn_error *error) {
    sn_error reason = {0};
    for (sn_index other = 0; other < b; other++) {
        if (strcmp(d->bones[other].name, d->bones[b].name) == 0)
            return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\" is given twice; give each bone a name of its own", d->bones[b].name);
    }
    sn_status status = sn_mesh_validate(d->bones[b].mesh, &reason);
    return status == SN_OK ? SN_OK : sn_fail(error, status, "bone \"%s\": %s", d->bones[b].name, reason.text);
}

static sn_status check_input(const detection *d, sn_error *error) {
    sn_status status = sn_mesh_validate(&d->muscle->mesh, error);
    for (sn_index b = 0; b < d->bone_count && status == SN_OK; b++) status = check_bone(d, b, error);
    if (status == SN_OK && !isfinite(d->params->distance))
        status = sn_fail(error, SN_ERROR_USAGE, "the distance of attachment must be a finite number");
    return status;
}

/* [K21] takes the mean edge length; together with contact that covers up to six times the true area, a tenth of it does not. */
static double default_reach(const detection *d) {
    double edge = sn_mesh_mean_edge(&d->muscle->mesh, &d->topology);
    return d->params->methods & SN_ATTACH_CONTACT ? 0.1 * edge : edge;
}

static sn_index find_holder(const detection *d, const char *name) {
    for (sn_index h = 0; h < d->holder_count; h++) {
        if (strcmp(d->holders[h], name) == 0) return h;
    }
    return SN_NONE;
}

static void name_holders(detection *d) {
    for (sn_index b = 0; b < d->bone_count; b++) d->holders[d->holder_count++] = d->bones[b].name;
    for (sn_index p = 0; p < d->params->pin_count; p++) {
        if (find_holder(d, d->params->pins[p].bone) == SN_NONE) d->holders[d->holder_count++] = d->params->pins[p].bone;
    }
}

static sn_status set_up(detection *d, sn_error *error) {
    sn_status status = check_input(d, error);
    if (status == SN_OK) status = sn_topology_build(&d->muscle->mesh, &d->topology, error);
    if (status != SN_OK) return status;
    sn_index vertices = d->muscle->mesh.vertex_count;
    d->holders = SN_NEW(const char *, (size_t)d->bone_count + (size_t)d->params->pin_count);
    d->holder_of = SN_NEW(sn_index, vertices);
    d->distance = SN_NEW(double, vertices);
    d->rule = SN_NEW(unsigned char, vertices);
    d->chunk_nearest = SN_NEW(double, sn_chunk_count(vertices, VERTICES_PER_CHUNK));
    if (d->holders == NULL || d->holder_of == NULL || d->distance == NULL || d->rule == NULL || d->chunk_nearest == NULL)
        return sn_fail_memory(error, "attachments");
    for (sn_index v = 0; v < vertices; v++) {
        d->holder_of[v] = SN_NONE;
        d->distance[v] = NAN;
    }
    d->box = sn_mesh_box(&d->muscle->mesh);
    if (d->params->methods & SN_ATTACH_PROXIMITY) d->reach = d->params->distance >= 0.0 ? d->params->distance : default_reach(d);
    name_holders(d);
    return SN_OK;
}

static void tear_down(detection *d) {
    sn_topology_free(&d->topology);
    free(d->holders);
    free(d->holder_of);
    free(d->distance);
    free(d->rule);
    free(d->chunk_nearest);
}

/* ---- pins ------------------------------------------------------------------------------------------------------------------- */

static sn_status apply_pin(detection *d, const sn_attach_pin *pin, sn_error *error) {
    sn_index count, *vertices = NULL, holder = find_holder(d, pin->bone);
    sn_error reason = {0};
    sn_status status = sn_select_vertices(&d->muscle->mesh, &d->topology, &pin->selector, &count, &vertices, &reason);
    if (status != SN_OK) return sn_fail(error, status, "pin to \"%s\": %s", pin->bone, reason.text);
    for (sn_index i = 0; i < count; i++) {
        if (d->rule[vertices[i]] == RULE_PIN) continue; /* the pin given first holds it */
        d->rule[vertices[i]] = RULE_PIN;
        d->holder_of[vertices[i]] = holder;
    }
    free(vertices);
    return SN_OK;
}

static bool holds_any(const detection *d, sn_index holder) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == holder) return true;
    }
    return false;
}

/* ---- one bone ---------------------------------------------------------------------------------------------------------------- */

typedef struct bone_search {
    detection *d;
    sn_index bone;
    const sn_surface *surface;
    sn_box box; /* of the bone */
} bone_search;

/* Signed distance of a vertex to the bone; INFINITY where it is outside and farther than `limit`. */
static double distance_within(const bone_search *s, sn_vec3 p, double limit) {
    double gap = box_gap((sn_box){p, p}, s->box);
    if (gap > limit) return INFINITY;
    if (gap > 0.0) return sn_surface_closest(s->surface, p, limit).distance; /* out of the box is outside */
    return sn_surface_signed_distance(s->surface, p, NULL);
}

static int rule_for(const detection *d, double distance) {
    if ((d->params->methods & SN_ATTACH_CONTACT) && distance <= 0.0) return RULE_CONTACT;
    if ((d->params->methods & SN_ATTACH_PROXIMITY) && distance < d->reach) return RULE_PROXIMITY;
    return 0;
}

static void offer(detection *d, sn_index v, sn_index bone, double distance) {
    if (d->rule[v] == RULE_PIN) {
        if (d->holder_of[v] == bone) d->distance[v] = distance;
        return;
    }
    int rule = rule_for(d, distance);
    if (rule == 0 || (d->holder_of[v] != SN_NONE && !(distance < d->distance[v]))) return;
    d->holder_of[v] = bone;
    d->distance[v] = distance;
    d->rule[v] = (unsigned char)rule;
}

/* A vertex needs its distance only if that is within reach, or may be the nearest of its chunk, or it is pinned to this bone. */
static void search_vertices(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const bone_search *s = user;
    detection *d = s->d;
    double nearest = INFINITY;
    for (sn_index v = begin; v < end; v++) {
        bool pinned_here = d->rule[v] == RULE_PIN && d->holder_of[v] == s->bone;
        double limit = pinned_here ? INFINITY : fmax(d->reach, nearest);
        double distance = distance_within(s, d->muscle->mesh.positions[v], limit);
        nearest = fmin(nearest, distance);
        offer(d, v, s->bone, distance);
    }
    d->chunk_nearest[chunk] = nearest;
}

static sn_status search_bone(detection *d, sn_pool *pool, sn_index bone, sn_box box, double *nearest, sn_error *error) {
    sn_surface *surface = NULL;
    sn_error reason = {0};
    sn_status status = sn_surface_create(d->bones[bone].mesh, &surface, &reason);
    if (status != SN_OK) return sn_fail(error, status, "bone \"%s\": %s", d->bones[bone].name, reason.text);
    bone_search search = {.d = d, .bone = bone, .surface = surface, .box = box};
    sn_index vertices = d->muscle->mesh.vertex_count;
    sn_parallel_for(pool, vertices, VERTICES_PER_CHUNK, search_vertices, &search);
    *nearest = INFINITY;
    for (sn_index c = 0; c < sn_chunk_count(vertices, VERTICES_PER_CHUNK); c++) *nearest = fmin(*nearest, d->chunk_nearest[c]);
    sn_surface_destroy(surface);
    return SN_OK;
}

/* A bone whose box is out of reach can hold nothing: no search structure is built for it. */
static sn_status try_bone(detection *d, sn_pool *pool, sn_index bone, sn_attach_pair *pair, sn_error *error) {
    sn_box box = sn_mesh_box(d->bones[bone].mesh);
    *pair = (sn_attach_pair){.bone = bone, .nearest = box_gap(d->box, box)};
    pair->culled = pair->nearest > d->reach && !holds_any(d, bone);
    return pair->culled ? SN_OK : search_bone(d, pool, bone, box, &pair->nearest, error);
}

/* ---- results --------------------------------------------------------------------------------------------------------------------- */

/* The vertices that a holder has now, ascending, in list (vertex_count). */
static sn_index held_vertices(const detection *d, sn_index holder, sn_index *list) {
    sn_index count = 0;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == holder) list[count++] = v;
    }
    return count;
}

static bool trace_bone(const detection *d, const sn_attach_pair *pair, sn_index *scratch, sn_trace *trace) {
    sn_index count = sn_trace_wanted(trace) ? held_vertices(d, pair->bone, scratch) : 0;
    return SN_TRACE(trace, "bone", sn_trace_text("bone", d->bones[pair->bone].name), sn_trace_number("culled", pair->culled),
                    sn_trace_number("nearest", pair->nearest), sn_trace_indices("vertices", scratch, count));
}

static sn_status try_bones(detection *d, sn_trace *trace, sn_attach_report *report, sn_error *error) {
    sn_status status = SN_OK;
    sn_pool *pool = sn_pool_create(d->params->threads); /* without one the loop runs on this thread */
    sn_index *scratch = SN_NEW(sn_index, d->muscle->mesh.vertex_count);
    if (scratch == NULL) status = sn_fail_memory(error, "attachments");
    for (sn_index b = 0; b < d->bone_count && status == SN_OK; b++) {
        if (sn_trace_stopped(trace))
            status = SN_STOPPED;
        else
            status = try_bone(d, pool, b, &report->pairs[b], error);
        if (status != SN_OK) break;
        report->pair_count++;
        if (trace_bone(d, &report->pairs[b], scratch, trace)) status = SN_STOPPED;
    }
    free(scratch);
    sn_pool_destroy(pool);
    return status;
}

static const char *method_name(unsigned rules) {
    static const char *const names[8] = {"none",      "pin",           "contact",           "pin+contact",
                                         "proximity", "pin+proximity", "contact+proximity", "pin+contact+proximity"};
    return names[rules & 7u];
}

/* Distances are there if all of them are known: not for pins to a bone without a mesh. */
static void fill_distances(const detection *d, sn_attachment *a) {
    for (sn_index i = 0; i < a->count; i++) {
        a->distances[i] = d->distance[a->vertices[i]];
        if (!isnan(a->distances[i])) continue;
        free(a->distances);
        a->distances = NULL;
        return;
    }
}

static sn_status fill_attachment(const detection *d, sn_index holder, sn_index count, sn_attachment *out, sn_error *error) {
    unsigned rules = 0;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == holder) rules |= d->rule[v];
    }
    out->bone = sn_strdup(d->holders[holder]);
    out->method = sn_strdup(method_name(rules));
    out->vertices = SN_NEW(sn_index, count);
    out->distances = SN_NEW(double, count);
    if (out->bone == NULL || out->method == NULL || out->vertices == NULL || out->distances == NULL)
        return sn_fail_memory(error, "attachments");
    out->count = held_vertices(d, holder, out->vertices);
    fill_distances(d, out);
    return SN_OK;
}

/* One attachment for each holder that holds anything. */
static sn_status collect(const detection *d, sn_index *count, sn_attachment **out, sn_attach_report *report, sn_error *error) {
    sn_status status = SN_OK;
    sn_index *held = SN_NEW(sn_index, d->holder_count);
    sn_attachment *list = SN_NEW(sn_attachment, d->holder_count);
    sn_index made = 0;
    if (held == NULL || list == NULL) status = sn_fail_memory(error, "attachments");
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count && status == SN_OK; v++) {
        if (d->holder_of[v] == SN_NONE) continue;
        held[d->holder_of[v]]++;
        report->attached++;
    }
    for (sn_index p = 0; p < report->pair_count && status == SN_OK; p++) report->pairs[p].vertices = held[report->pairs[p].bone];
    for (sn_index h = 0; h < d->holder_count && status == SN_OK; h++) {
        if (held[h] > 0) status = fill_attachment(d, h, held[h], &list[made++], error);
    }
    free(held);
    if (status != SN_OK) {
        sn_attachments_free(list, made);
        return status;
    }
    *count = made;
    *out = list;
    return SN_OK;
}

sn_status sn_attach_detect(const sn_muscle *muscle, sn_index bone_count, const sn_attach_bone *bones, const sn_attach_params *params,
                           sn_trace *trace, sn_index *count, sn_attachment **out, sn_attach_report *report, sn_error *error) {
    *count = 0;
    *out = NULL;
    *report = (sn_attach_report){0};
    detection d = {.muscle = muscle, .bone_count = bone_count, .bones = bones, .params = params};
    sn_status status = set_up(&d, error);
    report->distance = d.reach;
    for (sn_index p = 0; p < params->pin_count && status == SN_OK; p++) status = apply_pin(&d, &params->pins[p], error);
    if (status == SN_OK && (report->pairs = SN_NEW(sn_attach_pair, bone_count)) == NULL) status = sn_fail_memory(error, "attachments");
    if (status == SN_OK) status = try_bones(&d, trace, report, error);
    bool stopped = status == SN_STOPPED;
    if (status == SN_OK || stopped) status = collect(&d, count, out, report, error);
    tear_down(&d);
    if (status != SN_OK) sn_attach_report_free(report);
    return status == SN_OK && stopped ? SN_STOPPED : status;
}

void sn_attach_report_free(sn_attach_report *report) {
    free(report->pairs);
    *report = (sn_attach_report){0};
}
