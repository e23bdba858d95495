/*
 * attach.c -- which vertices of a muscle move with which bone ([K21] 3.3): pins, areas, contact, proximity, and how sure that is.
 */
#include "attach_detection.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VERTICES_PER_CHUNK = 256 };

/* ---- set-up ---------------------------------------------------------------------------------------------------------------- */

sn_attach_params sn_attach_defaults(void) {
    return (sn_attach_params){.methods = SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY,
                              .distance = -1.0,
                              .pair_distance = -1.0,
                              .pair_share = 0.008,
                              .landmark_reach = -1.0,
                              .line_width = -1.0};
}

static sn_status check_bone(const detection *d, sn_index b, sn_error *error) {
    sn_error reason = {0};
    for (sn_index other = 0; other < b; other++) {
        if (strcmp(d->params->bones[other].name, d->params->bones[b].name) == 0)
            return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\" is given twice; give each bone a name of its own", d->params->bones[b].name);
    }
    sn_status status = sn_mesh_validate(d->params->bones[b].mesh, &reason);
    return status == SN_OK ? SN_OK : sn_fail(error, status, "bone \"%s\": %s", d->params->bones[b].name, reason.text);
}

static sn_status check_input(const detection *d, sn_error *error) {
    sn_status status = sn_mesh_validate(&d->muscle->mesh, error);
    for (sn_index b = 0; b < d->params->bone_count && status == SN_OK; b++) status = check_bone(d, b, error);
    if (status == SN_OK && !isfinite(d->params->distance))
        status = sn_fail(error, SN_ERROR_USAGE, "the distance of attachment must be a finite number");
    if (status == SN_OK && d->params->voxels < 0) status = sn_fail(error, SN_ERROR_USAGE, "the number of voxels cannot be negative");
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

static sn_index add_holder(detection *d, const char *name) {
    sn_index found = find_holder(d, name);
    if (found != SN_NONE) return found;
    d->holders[d->holder_count] = name;
    return d->holder_count++;
}

/* Where bones are given, an area's bone must be one of them: anything else is a slip of the pen. */
static sn_status name_holders(detection *d, sn_error *error) {
    for (sn_index b = 0; b < d->params->bone_count; b++) d->holders[d->holder_count++] = d->params->bones[b].name;
    for (sn_index a = 0; a < d->params->area_count; a++) {
        const char *name = d->params->areas[a].bone;
        if (d->params->bone_count > 0 && (find_holder(d, name) == SN_NONE || find_holder(d, name) >= d->params->bone_count))
            return sn_fail(error, SN_ERROR_INPUT,
                           "the landmarks name bone \"%s\", which is not among the bones given; give its mesh, or correct the name", name);
        d->has_area[add_holder(d, name)] = true;
    }
    for (sn_index p = 0; p < d->params->pin_count; p++) add_holder(d, d->params->pins[p].bone);
    return SN_OK;
}

static sn_status allocate(detection *d, sn_error *error) {
    sn_index vertices = d->muscle->mesh.vertex_count;
    size_t holders = (size_t)d->params->bone_count + (size_t)d->params->pin_count + (size_t)d->params->area_count;
    d->holders = SN_NEW(const char *, holders);
    d->has_area = SN_NEW(bool, holders);
    d->holder_of = SN_NEW(sn_index, vertices);
    d->area_of = SN_NEW(sn_index, vertices);
    d->distance = SN_NEW(double, vertices);
    d->runner_up = SN_NEW(double, vertices);
    d->reason = SN_NEW(unsigned char, vertices);
    d->candidate = SN_NEW(double, vertices);
    d->list = SN_NEW(sn_index, vertices);
    d->chunk_nearest = SN_NEW(double, sn_chunk_count(vertices, VERTICES_PER_CHUNK));
    d->vertex_area = SN_NEW(double, vertices);
    d->along = SN_NEW(double, vertices);
    d->report->pairs = SN_NEW(sn_attach_pair, d->params->bone_count);
    d->report->areas = SN_NEW(sn_attach_area, d->params->area_count);
    bool complete = d->holders && d->has_area && d->holder_of && d->area_of && d->distance && d->runner_up && d->reason && d->candidate &&
                    d->list && d->chunk_nearest && d->vertex_area && d->along && d->report->pairs && d->report->areas;
    return complete ? SN_OK : sn_fail_memory(error, "attachments");
}

static sn_status set_up(detection *d, sn_error *error) {
    sn_status status = check_input(d, error);
    if (status == SN_OK) status = sn_topology_build(&d->muscle->mesh, &d->topology, error);
    if (status == SN_OK) status = allocate(d, error);
    if (status != SN_OK) return status;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        d->holder_of[v] = SN_NONE;
        d->area_of[v] = SN_NONE;
        d->distance[v] = NAN;
        d->runner_up[v] = INFINITY;
    }
    d->box = sn_mesh_box(&d->muscle->mesh);
    d->area = sn_mesh_area(&d->muscle->mesh);
    sn_mesh_vertex_areas(&d->muscle->mesh, d->vertex_area);
    if (d->params->methods & SN_ATTACH_PROXIMITY) d->reach = d->params->distance >= 0.0 ? d->params->distance : default_reach(d);
    d->pair_distance = d->params->pair_distance >= 0.0 ? d->params->pair_distance : 0.002 / d->muscle->meters_per_unit;
    d->report->distance = d->reach;
    d->report->pair_distance = d->pair_distance;
    return name_holders(d, error);
}

static void tear_down(detection *d) {
    sn_topology_free(&d->topology);
    free(d->holders);
    free(d->has_area);
    free(d->holder_of);
    free(d->area_of);
    free(d->distance);
    free(d->runner_up);
    free(d->reason);
    free(d->candidate);
    free(d->list);
    free(d->chunk_nearest);
    free(d->vertex_area);
    free(d->along);
    free(d->fiber_ends);
}

/* ---- pins and areas --------------------------------------------------------------------------------------------------------- */

void attach_hold(detection *d, sn_index v, sn_index holder, double distance, sn_attach_reason reason) {
    d->holder_of[v] = holder;
    d->distance[v] = distance;
    d->reason[v] = (unsigned char)reason;
}

bool attach_is_given(const detection *d, sn_index v) { return d->reason[v] == SN_REASON_PIN || d->reason[v] == SN_REASON_AREA; }

static sn_status apply_pin(detection *d, const sn_attach_pin *pin, sn_error *error) {
    sn_index count, *vertices = NULL, holder = find_holder(d, pin->bone);
    sn_error reason = {0};
    sn_status status = sn_select_vertices(&d->muscle->mesh, &d->topology, &pin->selector, &count, &vertices, &reason);
    if (status != SN_OK) return sn_fail(error, status, "pin to \"%s\": %s", pin->bone, reason.text);
    for (sn_index i = 0; i < count; i++)
        if (!attach_is_given(d, vertices[i])) attach_hold(d, vertices[i], holder, NAN, SN_REASON_PIN); /* the pin given first holds it */
    free(vertices);
    return SN_OK;
}

/* The end that the area is at which took a vertex; of others unknown. */
static sn_attachment_end end_at(const detection *d, sn_index v) {
    return d->area_of[v] == SN_NONE ? SN_END_UNKNOWN : d->report->areas[d->area_of[v]].end;
}

/* A vertex of an area that is given already: to the same bone at the same end by an area before, that changes nothing. */
static void note_lost(const detection *d, sn_index v, sn_index holder, sn_attach_area *report) {
    sn_index other = d->area_of[v];
    if (other != SN_NONE && d->holder_of[v] == holder && end_at(d, v) == report->end) return;
    report->lost.vertices++;
    report->lost.area += d->vertex_area[v];
    if (other != SN_NONE && (report->lost_to == SN_NONE || other < report->lost_to)) report->lost_to = other;
}

static void take_area(detection *d, sn_index number, const bool *inside, sn_attach_area *report) {
    sn_index holder = find_holder(d, d->params->areas[number].bone);
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (!inside[v]) continue;
        if (attach_is_given(d, v)) {
            note_lost(d, v, holder, report);
            continue;
        }
        attach_hold(d, v, holder, NAN, SN_REASON_AREA);
        d->area_of[v] = number;
    }
}

static sn_status apply_area(detection *d, const sn_area_ground *ground, sn_index number, bool *inside, sn_error *error) {
    const sn_landmark_area *area = &d->params->areas[number];
    sn_attach_area *report = &d->report->areas[number];
    *report = (sn_attach_area){.area = number, .lost_to = SN_NONE};
    report->end = sn_area_end(area->name, &report->end_doubtful);
    if (sn_trace_stopped(d->trace)) return SN_STOPPED;
    sn_status status = sn_area_patch(ground, area, d->trace, inside, report, error);
    if (status != SN_OK && status != SN_STOPPED) return status;
    d->report->area_count = number + 1;
    take_area(d, number, inside, report);
    return status;
}

bool attach_holds_by_distance(const detection *d, sn_index bone) { return d->params->methods != 0 && !d->has_area[bone]; }

/* Where every area is too far off, and nothing else is to be done, it is a slip: of the unit, mostly. */
static sn_status check_areas(const detection *d, sn_error *error) {
    bool more = d->params->pin_count > 0;
    for (sn_index a = 0; a < d->report->area_count; a++) more = more || !d->report->areas[a].left_out;
    for (sn_index b = 0; b < d->params->bone_count; b++) more = more || attach_holds_by_distance(d, b);
    if (more) return SN_OK;
    const sn_attach_area *area = &d->report->areas[0];
    const sn_landmark_area *given = &d->params->areas[area->area];
    double mm = 1e3 * d->muscle->meters_per_unit;
    return sn_fail(
        error, SN_ERROR_INPUT,
        "area \"%.60s\" on bone \"%.60s\": landmark %d lies %.3g mm off the muscle, and the limit is %.3g mm; check its unit, or "
        "raise the limit with --landmark-distance",
        given->name != NULL ? given->name : "(no name)", given->bone, (int)area->far + 1, area->farthest * mm,
        d->report->landmark_reach * mm);
}

static sn_status apply_areas(detection *d, sn_error *error) {
    if (d->params->area_count == 0) return SN_OK;
    sn_area_ground ground = {0};
    bool *inside = SN_NEW(bool, d->muscle->mesh.vertex_count);
    sn_status status = inside != NULL ? sn_area_ground_create(d->muscle, &d->topology, &ground, error) : sn_fail_memory(error, "areas");
    ground.reach = d->params->landmark_reach >= 0.0 ? d->params->landmark_reach : 0.010 / d->muscle->meters_per_unit;
    ground.kind = d->params->area_kind;
    ground.line_width = d->params->line_width;
    d->report->landmark_reach = ground.reach;
    for (sn_index a = 0; a < d->params->area_count && status == SN_OK; a++) status = apply_area(d, &ground, a, inside, error);
    if (status == SN_OK) status = check_areas(d, error);
    sn_area_ground_free(&ground);
    free(inside);
    return status;
}

sn_index attach_held(const detection *d, sn_index holder, sn_index *list) {
    sn_index count = 0;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == holder) list[count++] = v;
    }
    return count;
}

/* ---- one bone: the distance of every vertex ------------------------------------------------------------------------------------ */

typedef struct bone_distances {
    detection *d;
    sn_index bone;
    double reach;
    const sn_bone_search *search;
} bone_distances;

/* Signed distance of a vertex to the bone; INFINITY where it is outside and farther than `limit`. */
static double distance_within(const sn_bone_search *s, sn_vec3 p, double limit) {
    double gap = sn_box_gap((sn_box){p, p}, s->box);
    if (gap > limit) return INFINITY;
    if (gap > 0.0) return sn_surface_closest(s->surface, p, limit).distance; /* out of the box is outside */
    return sn_surface_signed_distance(s->surface, p, NULL);
}

/* A vertex needs its distance only if that is within reach, or may be the nearest of its chunk, or it was given to this bone. */
static void measure_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const bone_distances *m = user;
    detection *d = m->d;
    double nearest = INFINITY;
    for (sn_index v = begin; v < end; v++) {
        bool given_here = attach_is_given(d, v) && d->holder_of[v] == m->bone;
        double limit = given_here ? INFINITY : fmax(m->reach, nearest);
        d->candidate[v] = distance_within(m->search, d->muscle->mesh.positions[v], limit);
        if (given_here) d->distance[v] = d->candidate[v];
        nearest = fmin(nearest, d->candidate[v]);
    }
    d->chunk_nearest[chunk] = nearest;
}

double attach_measure(detection *d, const sn_bone_search *search, sn_index bone, double reach) {
    bone_distances m = {.d = d, .bone = bone, .reach = reach, .search = search};
    sn_index vertices = d->muscle->mesh.vertex_count;
    double nearest = INFINITY;
    sn_parallel_for(search->pool, vertices, VERTICES_PER_CHUNK, measure_range, &m);
    for (sn_index c = 0; c < sn_chunk_count(vertices, VERTICES_PER_CHUNK); c++) nearest = fmin(nearest, d->chunk_nearest[c]);
    return nearest;
}

/* ---- one bone: what it holds ------------------------------------------------------------------------------------------------------ */

static bool asks_pair_rule(const detection *d, sn_index bone) {
    return d->params->bones[bone].if_nearby && attach_holds_by_distance(d, bone);
}

/* How far from a bone anything is looked for. */
static double bone_reach(const detection *d, sn_index bone) {
    return asks_pair_rule(d, bone) ? fmax(d->reach, d->pair_distance) : d->reach;
}

/* A free vertex, or one that a farther bone holds. */
static void offer(detection *d, sn_index v, sn_index bone, sn_attach_reason reason) {
    double distance = d->candidate[v];
    if (attach_is_given(d, v)) return;
    if (d->holder_of[v] == SN_NONE) {
        attach_hold(d, v, bone, distance, reason);
    } else if (distance < d->distance[v]) {
        d->runner_up[v] = d->distance[v];
        attach_hold(d, v, bone, distance, reason);
    } else {
        d->runner_up[v] = fmin(d->runner_up[v], distance);
    }
}

static int reason_for(const detection *d, sn_index v, const sn_voxels *voxels) {
    double distance = d->candidate[v];
    if ((d->params->methods & SN_ATTACH_CONTACT) && distance <= 0.0) return SN_REASON_CONTACT;
    if ((d->params->methods & SN_ATTACH_CONTACT) && sn_voxels_at(voxels, d->muscle->mesh.positions[v])) return SN_REASON_VOXEL;
    if ((d->params->methods & SN_ATTACH_PROXIMITY) && distance < d->reach) return SN_REASON_PROXIMITY;
    return 0;
}

static sn_index offer_all(detection *d, sn_index bone, const sn_voxels *voxels) {
    sn_index offered = 0;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        int reason = reason_for(d, v, voxels);
        if (reason == 0) continue;
        offer(d, v, bone, (sn_attach_reason)reason);
        offered++;
    }
    return offered;
}

/* The rule found the bone nearby, but no vertex is in reach: those within the rule's distance, or else the nearest one. */
static void offer_nearest(detection *d, sn_index bone, double nearest) {
    double limit = fmax(d->pair_distance, nearest);
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (d->candidate[v] <= limit) offer(d, v, bone, SN_REASON_NEAREST);
}

/* The cells that the bone's surface runs through, as [K21] 3.2 sees it. */
static sn_status make_voxels(const detection *d, const sn_mesh *bone, sn_voxels *out, sn_error *error) {
    sn_index size[3];
    sn_voxels_in_all(sn_mesh_box(bone), d->params->voxels, size);
    return sn_voxels_create(bone, size, out, error);
}

static sn_status hold_bone(detection *d, const sn_bone_search *search, const sn_attach_pair *pair, sn_error *error) {
    sn_voxels voxels = {0};
    if (!attach_holds_by_distance(d, pair->bone)) return SN_OK;
    if (d->params->voxels > 0 && (d->params->methods & SN_ATTACH_CONTACT)) {
        sn_status status = make_voxels(d, search->bone, &voxels, error);
        if (status != SN_OK) return status;
    }
    bool both = (d->params->methods & SN_ATTACH_CONTACT) && (d->params->methods & SN_ATTACH_PROXIMITY);
    if (offer_all(d, pair->bone, &voxels) == 0 && both && d->params->bones[pair->bone].if_nearby)
        offer_nearest(d, pair->bone, pair->nearest);
    sn_voxels_free(&voxels);
    return SN_OK;
}

/* The pair rule: a vertex in the bone decides at once; else dense samples do. */
static sn_status judge(detection *d, const sn_bone_search *search, sn_attach_pair *pair, sn_error *error) {
    pair->nearby = true;
    if (!asks_pair_rule(d, pair->bone)) return SN_OK;
    pair->penetrates = pair->nearest <= 0.0;
    if (!pair->penetrates) {
        sn_pair_probe probe;
        sn_status status = sn_probe_pair(search, d->pair_distance, d->area, &probe, error);
        if (status != SN_OK) return status;
        pair->penetrates = probe.penetrates;
        pair->area_share = probe.area_share;
        pair->nearby = probe.penetrates || probe.area_share > d->params->pair_share;
    }
    return SN_TRACE(d->trace, "pair", sn_trace_text("bone", d->params->bones[pair->bone].name), sn_trace_number("nearest", pair->nearest),
                    sn_trace_number("penetrates", pair->penetrates), sn_trace_number("areaShare", pair->area_share),
                    sn_trace_number("nearby", pair->nearby))
               ? SN_STOPPED
               : SN_OK;
}

static sn_status search_bone(detection *d, sn_pool *pool, sn_attach_pair *pair, sn_box box, sn_error *error) {
    const sn_attach_bone *bone = &d->params->bones[pair->bone];
    sn_surface *surface = NULL;
    sn_error reason = {0};
    sn_status status = sn_surface_create(bone->mesh, &surface, &reason);
    if (status != SN_OK) return sn_fail(error, status, "bone \"%s\": %s", bone->name, reason.text);
    sn_bone_search search = {.muscle = &d->muscle->mesh, .bone = bone->mesh, .surface = surface, .box = box, .pool = pool};
    pair->nearest = attach_measure(d, &search, pair->bone, bone_reach(d, pair->bone));
    status = judge(d, &search, pair, error);
    if (status == SN_OK && pair->nearby) status = hold_bone(d, &search, pair, error);
    sn_surface_destroy(surface);
    return status;
}

bool attach_holds_any(const detection *d, sn_index holder) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == holder) return true;
    }
    return false;
}

/* A bone whose box is out of reach can hold nothing: no search structure is built for it. */
static sn_status try_bone(detection *d, sn_pool *pool, sn_index bone, sn_attach_pair *pair, sn_error *error) {
    sn_box box = sn_mesh_box(d->params->bones[bone].mesh);
    *pair = (sn_attach_pair){.bone = bone, .nearest = sn_box_gap(d->box, box), .area_share = NAN, .position = NAN, .girth = NAN};
    pair->culled = pair->nearest > bone_reach(d, bone) && !attach_holds_any(d, bone);
    return pair->culled ? SN_OK : search_bone(d, pool, pair, box, error);
}

static bool trace_bone(const detection *d, const sn_attach_pair *pair) {
    sn_index count = sn_trace_wanted(d->trace) ? attach_held(d, pair->bone, d->list) : 0;
    return SN_TRACE(d->trace, "bone", sn_trace_text("bone", d->params->bones[pair->bone].name), sn_trace_number("culled", pair->culled),
                    sn_trace_number("nearest", pair->nearest), sn_trace_indices("vertices", d->list, count));
}

static sn_status try_bones(detection *d, sn_error *error) {
    sn_status status = SN_OK;
    sn_pool *pool = sn_pool_create(d->params->threads); /* without one the loop runs on this thread */
    for (sn_index b = 0; b < d->params->bone_count && status == SN_OK; b++) {
        if (sn_trace_stopped(d->trace)) {
            status = SN_STOPPED;
            break;
        }
        status = try_bone(d, pool, b, &d->report->pairs[b], error);
        if (status != SN_OK && status != SN_STOPPED) break;
        d->report->pair_count++;
        if (status == SN_OK && trace_bone(d, &d->report->pairs[b])) status = SN_STOPPED;
    }
    sn_pool_destroy(pool);
    return status;
}

/* ---- results --------------------------------------------------------------------------------------------------------------------- */

/* The vertices of one holder at one end: an attachment of its own. */
typedef struct hold {
    sn_index holder, count;
    sn_attachment_end end;
} hold;

static bool is_of(const detection *d, const hold *h, sn_index v) { return d->holder_of[v] == h->holder && end_at(d, v) == h->end; }

/* The methods that the vertices came by, joined with '+'. */
static void join_methods(const detection *d, const hold *h, char *text, size_t size) {
    unsigned reasons = 0;
    size_t used = 0;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (is_of(d, h, v)) reasons |= 1u << d->reason[v];
    for (int r = 1; r < SN_REASON_COUNT && used < size; r++)
        if (reasons & 1u << r)
            used += (size_t)snprintf(text + used, size - used, "%s%s", used > 0 ? "+" : "", sn_attach_reason_name((sn_attach_reason)r));
}

/* Distances are there if all of them are known: not for bones without a mesh. */
static void fill_distances(const detection *d, sn_attachment *a) {
    for (sn_index i = 0; i < a->count; i++) {
        a->distances[i] = d->distance[a->vertices[i]];
        if (!isnan(a->distances[i])) continue;
        free(a->distances);
        a->distances = NULL;
        return;
    }
}

/* A vertex that no rule found by its own distance. */
static bool is_guess(const detection *d, sn_index v) {
    sn_index holder = d->holder_of[v];
    if (d->reason[v] == SN_REASON_FILLED) return true;
    return d->reason[v] == SN_REASON_NEAREST && holder < d->report->pair_count && d->report->pairs[holder].tip;
}

/* How sure it is that a vertex moves with its bone. Given by the user: 1. In the bone: 0.5 on its surface to 1 at a depth of the pair
 * distance. Near it: 0.5 on the surface to 0 at the reach. Times 0.5 where another bone is as near, up to 1 where that one is farther by
 * the pair distance. Filled, or at a tip that touches nothing: a quarter at most. Times 0.5 where the pair looks like a sliding tendon and
 * is kept. */
static double confidence_of(const detection *d, sn_index v, bool sliding) {
    double scale = fmax(d->pair_distance, 1e-300), distance = d->distance[v];
    if (attach_is_given(d, v)) return 1.0;
    double reach = fmax(d->reason[v] == SN_REASON_PROXIMITY ? d->reach : scale, distance);
    double depth = distance <= 0.0 ? 0.5 + 0.5 * fmin(1.0, -distance / scale) : 0.5 * (1.0 - distance / reach);
    if (is_guess(d, v)) depth = fmax(0.05, fmin(0.25, depth));
    double margin = 0.5 + 0.5 * fmin(1.0, (d->runner_up[v] - distance) / scale);
    return depth * margin * (sliding ? 0.5 : 1.0);
}

static bool is_sliding(const detection *d, sn_index holder) {
    return d->params->raw && holder < d->report->pair_count &&
           d->report->pairs[holder].sliding; /* the pairs are in the order of the bones */
}

static void list_vertices(const detection *d, const hold *h, sn_attachment *out) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (!is_of(d, h, v)) continue;
        out->vertices[out->count] = v;
        out->reasons[out->count] = d->reason[v];
        out->confidence[out->count++] = confidence_of(d, v, is_sliding(d, h->holder));
    }
}

static sn_status fill_attachment(const detection *d, const hold *h, sn_attachment *out, sn_error *error) {
    char method[96] = "";
    join_methods(d, h, method, sizeof method);
    out->bone = sn_strdup(d->holders[h->holder]);
    out->end = h->end;
    out->method = sn_strdup(method);
    out->vertices = SN_NEW(sn_index, h->count);
    out->distances = SN_NEW(double, h->count);
    out->reasons = SN_NEW(sn_index, h->count);
    out->confidence = SN_NEW(double, h->count);
    if (!out->bone || !out->method || !out->vertices || !out->distances || !out->reasons || !out->confidence)
        return sn_fail_memory(error, "attachments");
    list_vertices(d, h, out);
    fill_distances(d, out);
    return SN_OK;
}

enum { ENDS = SN_END_INSERTION + 1 };

static void count_vertices(const detection *d, hold *holds) {
    for (sn_index i = 0; i < ENDS * d->holder_count; i++) holds[i] = (hold){i / ENDS, 0, (sn_attachment_end)(i % ENDS)};
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == SN_NONE) continue;
        holds[ENDS * d->holder_of[v] + (sn_index)end_at(d, v)].count++;
        d->report->attached++;
    }
    for (sn_index p = 0; p < d->report->pair_count; p++) {
        sn_attach_pair *pair = &d->report->pairs[p];
        for (int end = 0; end < ENDS; end++) pair->vertices += holds[ENDS * pair->bone + end].count;
    }
}

/* One attachment for each holder that holds anything, and for each end that its areas tell. */
static sn_status collect(const detection *d, sn_attachment_list *out, sn_error *error) {
    hold *holds = SN_NEW(hold, ENDS * d->holder_count);
    sn_attachment *list = SN_NEW(sn_attachment, ENDS * d->holder_count);
    sn_index made = 0;
    sn_status status = holds != NULL && list != NULL ? SN_OK : sn_fail_memory(error, "attachments");
    if (status == SN_OK) count_vertices(d, holds);
    for (sn_index i = 0; i < ENDS * d->holder_count && status == SN_OK; i++)
        if (holds[i].count > 0) status = fill_attachment(d, &holds[i], &list[made++], error);
    free(holds);
    if (status != SN_OK) {
        sn_attachments_free(list, made);
        return status;
    }
    *out = (sn_attachment_list){made, list};
    return SN_OK;
}

/* What distance alone cannot tell: areas instead of speckles, what slides, and tips that touch nothing. */
static sn_status judge_holds(detection *d, sn_error *error) {
    bool any = false, raw = d->params->raw, both = d->params->methods == (SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY);
    for (sn_index i = 0; i < d->report->pair_count; i++) any = any || attach_holds_any(d, d->report->pairs[i].bone);
    sn_status status = any ? attach_find_along(d, error) : SN_OK;
    if (status == SN_OK && any && !raw) status = attach_make_patches(d, error);
    if (status == SN_OK && any) status = attach_find_sliding(d, !raw, error);
    if (status == SN_OK && any && !raw) status = attach_let_runs_go(d, error);
    if (status == SN_OK && any && !raw && both) status = attach_take_tips(d, error);
    return status;
}

sn_status sn_attach_detect(const sn_muscle *muscle, const sn_attach_params *params, sn_trace *trace, sn_attachment_list *out,
                           sn_attach_report *report, sn_error *error) {
    *out = (sn_attachment_list){0};
    *report = (sn_attach_report){0};
    detection d = {.muscle = muscle, .params = params, .trace = trace, .report = report};
    sn_status status = set_up(&d, error);
    for (sn_index p = 0; p < params->pin_count && status == SN_OK; p++) status = apply_pin(&d, &params->pins[p], error);
    if (status == SN_OK) status = apply_areas(&d, error);
    if (status == SN_OK) status = try_bones(&d, error);
    if (status == SN_OK) status = judge_holds(&d, error);
    bool stopped = status == SN_STOPPED;
    if (status == SN_OK || stopped) status = collect(&d, out, error);
    tear_down(&d);
    if (status != SN_OK) sn_attach_report_free(report);
    return status == SN_OK && stopped ? SN_STOPPED : status;
}

void sn_attach_report_free(sn_attach_report *report) {
    free(report->pairs);
    free(report->areas);
    *report = (sn_attach_report){0};
}

void sn_landmark_areas_free(sn_landmark_area *areas, sn_index count) {
    for (sn_index i = 0; i < count && areas != NULL; i++) {
        free(areas[i].bone);
        free(areas[i].name);
        free(areas[i].landmarks);
    }
    free(areas);
}
