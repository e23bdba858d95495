/*
 * roots.c -- where fibres start: the ring of vertices around the middle (methods.md 2), or the user's own selection.
 *
 * A harmonic field between the muscle's ends has exactly the contours that one would draw across it by hand: the ring beside the one that
 * passes nearest to the volume centroid parts the surface in two.
 */
#include "sinew/rig.h"

#include <stdlib.h>
#include <string.h>

#include "ends.h"
#include "section.h"
#include "tips.h"

#define NEAR_CENTROID 0.10    /* a ring between sites or attachments must lie within this share of L of the centroid */
#define GOOD_SPAN 0.2         /* near the centroid, a ring that spans no more of the way from end to end is taken before others */
#define CAP 0.1               /* a ring nearer to an end than this share of the way is no section but a cap around it */
#define MOST_SPAN (1.0 / 3.0) /* a ring that spans more runs along the muscle */

typedef struct selection {
    const sn_muscle *muscle;
    const sn_roots_params *params;
    const sn_mesh *mesh;
    sn_topology topology;
    section cut;
    surface_survey survey;
    tips tips;
    sn_vec3 centroid;
    sn_trace *trace;
    ends ends;
    double *u;     /* (vertex_count) the field whose contours are tried */
    double *along; /* (vertex_count) 0 at one end, 1 at the other */
    sn_roots_report report;
    sn_index count;
    sn_index *vertices;
} selection;

/* ---- the field between the ends ----------------------------------------------------------------------------------------- */

/* known: the best known ends; else the tips. */
static sn_status find_ends(selection *s, bool known, sn_error *error) {
    const ends_surface surface = {s->mesh, &s->topology, &s->tips};
    sn_status status;
    if (known) {
        status = ends_choose(&surface, s->muscle, s->params->site_count, s->params->sites, &s->ends, error);
    } else {
        ends_say(&s->ends.choice, "%s: no ring around the muscle parts them", s->ends.choice.from);
        s->ends.choice.unused = true;
        memset(s->ends.choice.patches, 0, sizeof s->ends.choice.patches);
        status = ends_from_tips(&surface, &s->ends, error);
    }
    s->report.ends = s->ends.choice;
    return status;
}

/* Where each vertex lies along the muscle: d0 / (d0 + d1) of its distances along the surface from both ends; NaN off their component. */
static sn_status find_along(selection *s, sn_error *error) {
    double *distance[2] = {s->along, SN_NEW(double, s->mesh->vertex_count)};
    sn_index *end = SN_NEW(sn_index, s->ends.count);
    sn_status status = distance[1] && end ? SN_OK : sn_fail_memory(error, "the distances from the muscle's ends");
    for (int k = 0; k < 2 && !status; k++) {
        sn_index count = 0;
        for (sn_index i = 0; i < s->ends.count; i++)
            if (s->ends.values[i] == k) end[count++] = s->ends.vertices[i];
        status = sn_geodesic_distance(s->mesh, &s->topology, count, end, distance[k], error);
    }
    for (sn_index v = 0; v < s->mesh->vertex_count && !status; v++) {
        double sum = s->along[v] + distance[1][v];
        s->along[v] = isfinite(sum) && sum > 0.0 ? s->along[v] / sum : NAN;
    }
    free(distance[1]);
    free(end);
    return status;
}

static sn_status harmonic_between(selection *s, sn_error *error) {
    const ends *e = &s->ends;
    sn_status status = sn_harmonic_field(s->mesh, &s->topology, &(sn_fixed_values){e->count, e->vertices, e->values}, s->u, error);
    if (!status && SN_TRACE(s->trace, "field", sn_trace_text("ends", e->choice.from), sn_trace_indices("fixed", e->vertices, e->count)))
        status = SN_STOPPED;
    return status;
}

/* Heights along the straight line between the middles of the ends: their levels cut across it. */
static void height_between(selection *s) {
    sn_vec3 origin = s->mesh->positions[s->ends.vertices[0]], sum[2] = {{0, 0, 0}, {0, 0, 0}};
    double count[2] = {0.0, 0.0};
    for (sn_index i = 0; i < s->ends.count; i++) {
        int k = s->ends.values[i] != 0.0;
        sum[k] = sn_add(sum[k], sn_sub(s->mesh->positions[s->ends.vertices[i]], origin));
        count[k] += 1.0;
    }
    sn_vec3 axis = sn_normalize(sn_sub(sn_scale(sum[1], 1.0 / fmax(count[1], 1.0)), sn_scale(sum[0], 1.0 / fmax(count[0], 1.0))));
    for (sn_index v = 0; v < s->mesh->vertex_count; v++)
        s->u[v] = isnan(s->along[v]) ? NAN : sn_dot(sn_sub(s->mesh->positions[v], origin), axis);
}

/* ---- what a right ring is --------------------------------------------------------------------------------------------- */

/* Where the ring lies on the way from end to end: the mean of its vertices. */
static double place_of(const selection *s, sn_index count, const sn_index *ring) {
    double sum = 0.0;
    for (sn_index i = 0; i < count; i++) sum += s->along[ring[i]];
    return sum / (double)count;
}

static double span_of(const selection *s, sn_index count, const sn_index *ring) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < count; i++) {
        low = fmin(low, s->along[ring[i]]);
        high = fmax(high, s->along[ring[i]]);
    }
    return high >= low ? high - low : NAN;
}

/* A ring around the muscle: not one along it, nor one around a part of it or the cap of an end. */
static bool is_right(selection *s, double most, sn_index count, const sn_index *ring) {
    const sn_fixed_values fixed = {s->ends.count, s->ends.vertices, s->ends.values};
    if (!(fabs(place_of(s, count, ring) - 0.5) <= 0.5 - CAP)) return false;
    return span_of(s, count, ring) <= most && section_ring_closed(&s->cut, count, ring) && section_parts(&s->cut, count, ring) == 2 &&
           section_separates(&s->cut, count, ring, &fixed);
}

/* ---- area quantiles of the field ------------------------------------------------------------------------------------- */

typedef struct weighted {
    double u, area;
} weighted;

typedef struct quantiles {
    sn_index count;
    weighted *items; /* by u; area becomes the cumulated share of the surface */
} quantiles;

static int compare_weighted(const void *left, const void *right) {
    const weighted *a = left, *b = right;
    if (a->u != b->u) return a->u < b->u ? -1 : 1;
    return (a->area > b->area) - (a->area < b->area);
}

static sn_status quantiles_build(const sn_mesh *mesh, const double *u, quantiles *q, sn_error *error) {
    double *area = SN_NEW(double, mesh->vertex_count);
    *q = (quantiles){.items = SN_NEW(weighted, mesh->vertex_count)};
    if (!area || !q->items) {
        free(area);
        return sn_fail_memory(error, "the area quantiles of a field");
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double twice = sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
        for (int c = 0; c < 3; c++) area[v[c]] += twice / 6.0;
    }
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        if (isfinite(u[v])) q->items[q->count++] = (weighted){u[v], area[v]};
    free(area);
    qsort(q->items, (size_t)q->count, sizeof *q->items, compare_weighted);
    double sum = 0.0;
    for (sn_index i = 0; i < q->count; i++) sum = q->items[i].area += sum;
    for (sn_index i = 0; i < q->count && sum > 0.0; i++) q->items[i].area /= sum;
    return SN_OK;
}

/* The level below which `share` of the area lies, between two values of the field; NaN where nothing lies above. */
static double quantile_level(const quantiles *q, double share) {
    sn_index low = 0, high = q->count;
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        if (q->items[middle].area < share)
            low = middle + 1;
        else
            high = middle;
    }
    for (sn_index i = low; i + 1 < q->count; i++)
        if (q->items[i + 1].u > q->items[low].u) return 0.5 * (q->items[low].u + q->items[i + 1].u);
    return NAN;
}

/* ---- candidates ------------------------------------------------------------------------------------------------------- */

typedef struct candidate {
    double offset; /* from the volume centroid to the ring's mean */
    double share, level;
    sn_index curve;
    section_side side;
} candidate;

typedef struct candidates {
    size_t count, capacity;
    candidate *items;
} candidates;

/* Which curves count, from the strict rule to the lenient one. */
typedef struct search {
    double first, last, step; /* area shares */
    bool single;              /* only levels whose contour is one closed curve, only rings that are simple as they are */
    section_side last_side;   /* beside the curves: low and high, or nearest, too */
} search;

static int compare_candidates(const void *left, const void *right) {
    const candidate *a = left, *b = right;
    if (a->offset != b->offset) return a->offset < b->offset ? -1 : 1;
    if (a->share != b->share) return a->share < b->share ? -1 : 1;
    if (a->curve != b->curve) return a->curve < b->curve ? -1 : 1;
    return (a->side > b->side) - (a->side < b->side);
}

static sn_vec3 vertex_mean(const sn_mesh *mesh, sn_index count, const sn_index *vertices) {
    sn_vec3 origin = mesh->positions[vertices[0]], sum = {0, 0, 0};
    for (sn_index i = 0; i < count; i++) sum = sn_add(sum, sn_sub(mesh->positions[vertices[i]], origin));
    return sn_add_scaled(origin, sum, 1.0 / (double)count);
}

/* Both rings of every curve of the section that was just cut. */
static bool add_candidates(selection *s, const search *how, double share, candidates *list) {
    if (how->single && (s->cut.curve_count != 1 || !s->cut.curves[0].closed)) return true;
    for (sn_index c = 0; c < s->cut.curve_count; c++)
        for (int side = SECTION_LOW; side <= (int)how->last_side; side++) {
            if (!s->cut.curves[c].closed) continue;
            bool simple;
            sn_index count = section_ring(&s->cut, &s->cut.curves[c], (section_side)side, s->vertices, &simple);
            if (count < 3 || (how->single && !simple)) continue;
            if (!sn_grow((void **)&list->items, &list->capacity, list->count + 1, sizeof *list->items)) return false;
            double offset = sn_distance(vertex_mean(s->mesh, count, s->vertices), s->centroid);
            list->items[list->count++] = (candidate){offset, share, s->cut.level, c, (section_side)side};
        }
    return true;
}

static sn_status gather(selection *s, const search *how, const double *u, const quantiles *q, candidates *list, sn_error *error) {
    double before = NAN;
    int steps = (int)lround((how->last - how->first) / how->step);
    for (int i = 0; i <= steps; i++) {
        double share = how->first + how->step * i, level = quantile_level(q, share);
        if (isnan(level) || level == before) continue;
        before = level;
        sn_status status = section_cut(&s->cut, u, level, error);
        if (status) return status;
        if (!add_candidates(s, how, share, list)) return sn_fail_memory(error, "the candidate rings");
        if (SN_TRACE(s->trace, "contour", sn_trace_number("share", share), sn_trace_number("level", level),
                     sn_trace_number("curves", s->cut.curve_count), sn_trace_number("candidates", (double)list->count)))
            return SN_STOPPED;
    }
    if (list->count > 0) qsort(list->items, list->count, sizeof *list->items, compare_candidates);
    return SN_OK;
}

static sn_status rebuild_ring(selection *s, const candidate *c, const double *u, sn_index *count, sn_error *error) {
    sn_status status = section_cut(&s->cut, u, c->level, error);
    bool simple;
    if (!status) *count = section_ring(&s->cut, &s->cut.curves[c->curve], c->side, s->vertices, &simple);
    return status;
}

static void take_ring(selection *s, const candidate *c, sn_index count) {
    section_ring_canonical(count, s->vertices);
    s->count = count;
    s->report.ring = section_ring_closed(&s->cut, count, s->vertices);
    s->report.level = c->share;
}

/* What a ring must be; any: it is enough that it separates the surface in exactly two. */
typedef struct demand {
    double span; /* at most */
    double near; /* to the centroid, as a share of L */
    bool any;
    bool nearest; /* rings of the vertices nearest to a curve count, too */
} demand;

/* The candidate nearest to the centroid whose ring is what is asked for. */
static sn_status first_separating(selection *s, const candidates *list, const demand *asked, sn_error *error) {
    for (size_t i = 0; i < list->count; i++) {
        if (list->items[i].offset > asked->near * s->tips.length) return SN_OK;
        sn_index count = 0;
        sn_status status = rebuild_ring(s, &list->items[i], s->u, &count, error);
        if (status) return status;
        sn_index parts = section_parts(&s->cut, count, s->vertices);
        bool good = parts == 2 && (asked->any || is_right(s, asked->span, count, s->vertices));
        bool stop = SN_TRACE(s->trace, "ring", sn_trace_number("share", list->items[i].share), sn_trace_number("parts", parts),
                             sn_trace_number("offset", list->items[i].offset), sn_trace_indices("vertices", s->vertices, count));
        if (good) {
            take_ring(s, &list->items[i], count);
            return SN_OK; /* even if this was the last step allowed: it is complete */
        }
        if (stop) return SN_STOPPED;
    }
    return SN_OK;
}

/* A ring along the levels of s->u; asked->any: in the end any closed one. */
static sn_status search_ring(selection *s, const demand *asked, sn_error *error) {
    static const search searches[] = {{0.10, 0.90, 0.01, true, 0}, {0.10, 0.90, 0.01, false, 0}, {0.02, 0.98, 0.001, false, 0}};
    quantiles q = {0};
    candidates list = {0};
    s->count = 0;
    sn_status status = quantiles_build(s->mesh, s->u, &q, error);
    for (size_t i = 0; i < sizeof searches / sizeof *searches && !status && s->count == 0; i++) {
        list.count = 0;
        search how = searches[i];
        how.last_side = asked->nearest ? SECTION_NEAREST : SECTION_HIGH;
        status = gather(s, &how, s->u, &q, &list, error);
        if (!status) status = first_separating(s, &list, asked, error);
    }
    if (!status && asked->any && s->count == 0 && list.count > 0) { /* nothing separates: the nearest closed ring */
        sn_index count = 0;
        status = rebuild_ring(s, &list.items[0], s->u, &count, error);
        if (!status) take_ring(s, &list.items[0], count);
    }
    free(list.items);
    free(q.items);
    return status;
}

/* A right ring between the ends, if there is one: along a contour of their field, else across the line between them; near the centroid
 * before others. */
static sn_status right_ring(selection *s, bool known, sn_error *error) {
    static const struct {
        demand asked;
        bool section;
    } order[] = {{{GOOD_SPAN, NEAR_CENTROID, false, false}, false}, {{MOST_SPAN, NEAR_CENTROID, false, false}, false},
                 {{MOST_SPAN, NEAR_CENTROID, false, false}, true},  {{MOST_SPAN, NEAR_CENTROID, false, true}, true},
                 {{MOST_SPAN, NEAR_CENTROID, false, true}, false},  {{MOST_SPAN, INFINITY, false, true}, false},
                 {{MOST_SPAN, INFINITY, false, true}, true}};
    sn_status status = find_ends(s, known, error);
    if (!status) status = find_along(s, error);
    s->count = 0;
    for (size_t i = 0; i < sizeof order / sizeof *order && !status && s->count == 0; i++) {
        s->report.section = order[i].section;
        if (i == 0 || order[i].section != order[i - 1].section) {
            if (order[i].section)
                height_between(s);
            else
                status = harmonic_between(s, error);
        }
        if (!status) status = search_ring(s, &order[i].asked, error);
    }
    s->report.section &= s->count > 0;
    return status;
}

/* Nothing is right: what comes nearest to it, between the tips. */
static sn_status next_best(selection *s, sn_error *error) {
    static const demand any = {INFINITY, INFINITY, true, false};
    sn_status status = harmonic_between(s, error);
    return status ? status : search_ring(s, &any, error);
}

static sn_status search_all(selection *s, sn_error *error) {
    sn_status status = right_ring(s, true, error);
    s->report.right = !status && s->count > 0;
    s->report.between_tips = !status && s->count == 0 && s->ends.choice.source >= SN_ENDS_ATTACHMENTS;
    if (s->report.between_tips) status = right_ring(s, false, error);
    s->report.fallback = !status && s->count == 0;
    if (!status && s->count == 0) status = next_best(s, error);
    if (!status && s->count > 0) s->report.span = span_of(s, s->count, s->vertices);
    return status;
}

static sn_status select_automatic(selection *s, sn_error *error) {
    s->u = SN_NEW(double, s->mesh->vertex_count);
    s->along = SN_NEW(double, s->mesh->vertex_count);
    s->vertices = SN_NEW(sn_index, s->mesh->vertex_count > s->topology.edge_count ? s->mesh->vertex_count : s->topology.edge_count);
    sn_status status = ends_alloc(s->mesh->vertex_count, &s->ends, error);
    if (!status)
        status = s->u && s->along && s->vertices ? search_all(s, error) : sn_fail_memory(error, "the field between the muscle's ends");
    if (!status && s->count == 0)
        status = sn_fail(error, SN_ERROR_INPUT,
                         "no closed ring of vertices runs around the muscle's middle; close the mesh with mesh-clean, or choose the roots "
                         "by hand with --plane or --indices");
    ends_free(&s->ends);
    free(s->u);
    free(s->along);
    return status;
}

/* ---- by hand ------------------------------------------------------------------------------------------------------------ */

/* The first of the vertex's neighbours that is flagged, and how many are. */
static sn_index flagged_neighbours(const sn_topology *t, const bool *flags, sn_index vertex, sn_index *first) {
    sn_index count = 0;
    *first = SN_NONE;
    for (sn_index k = t->vertex_start[vertex]; k < t->vertex_start[vertex + 1]; k++)
        if (flags[t->neighbours[k]] && count++ == 0) *first = t->neighbours[k];
    return count;
}

/* Walk round the selected vertices, if each has exactly two of the others beside it; returns how many were met. */
static sn_index walk_loop(const selection *s, bool *selected, sn_index *walk) {
    sn_index next, count = 0;
    for (sn_index i = 0; i < s->count; i++)
        if (flagged_neighbours(&s->topology, selected, s->vertices[i], &next) != 2) return 0;
    for (sn_index here = s->vertices[0]; here != SN_NONE; here = next) {
        selected[here] = false;
        walk[count++] = here;
        flagged_neighbours(&s->topology, selected, here, &next);
    }
    return count;
}

/* A selection that is one loop of edges is a ring, and is put in ring order. */
static sn_status order_if_loop(selection *s, sn_error *error) {
    bool *selected = SN_NEW(bool, s->mesh->vertex_count);
    sn_index *walk = SN_NEW(sn_index, s->count);
    sn_status status = selected && walk ? SN_OK : sn_fail_memory(error, "the order of the roots");
    for (sn_index i = 0; !status && i < s->count; i++) selected[s->vertices[i]] = true;
    s->report.ring = !status && walk_loop(s, selected, walk) == s->count && section_ring_closed(&s->cut, s->count, walk);
    if (s->report.ring) {
        memcpy(s->vertices, walk, (size_t)s->count * sizeof *walk);
        section_ring_canonical(s->count, s->vertices);
    }
    free(selected);
    free(walk);
    return status;
}

static sn_status select_manual(selection *s, const sn_selector *selector, sn_error *error) {
    sn_status status = sn_select_vertices(s->mesh, &s->topology, selector, &s->count, &s->vertices, error);
    if (!status && selector->kind == SN_SELECT_PLANE)
        s->report.ring = section_ring_closed(&s->cut, s->count, s->vertices);
    else if (!status)
        status = order_if_loop(s, error);
    if (!status) SN_TRACE(s->trace, "select", sn_trace_indices("vertices", s->vertices, s->count)); /* a stop here comes when all is done */
    return status;
}

/* ---- all together --------------------------------------------------------------------------------------------------------- */

static const char *rule_name(const sn_roots_params *params) {
    static const char *const names[] = {"indices", "near", "sphere", "box", "plane", "half", "painted"};
    return params->automatic ? "mid-section" : names[params->selector.kind];
}

static sn_status prepare(selection *s, sn_error *error) {
    sn_status status = sn_mesh_validate(s->mesh, error);
    if (!status) status = sn_topology_build(s->mesh, &s->topology, error);
    if (!status) status = section_create(s->mesh, &s->topology, &s->cut, error);
    if (!status) status = survey_surface(s->mesh, &s->topology, &s->survey, error);
    if (!status)
        status = s->params->eigenfunction ? find_tips_by_eigenfunction(s->mesh, &s->topology, &s->survey, s->trace, &s->tips, error)
                                          : find_tips(s->mesh, &s->topology, s->survey.main_vertex, s->trace, &s->tips, error);
    s->centroid = sn_mesh_volume_centroid(s->mesh);
    s->report.level = NAN;
    s->report.span = NAN;
    return status;
}

static void fill_report(selection *s) {
    sn_roots_report *r = &s->report;
    r->count = s->count;
    r->genus = s->survey.genus;
    r->components = s->survey.components;
    r->length = s->tips.length;
    if (s->count == 0) return;
    r->parts = section_parts(&s->cut, s->count, s->vertices);
    r->centroid_offset = sn_distance(vertex_mean(s->mesh, s->count, s->vertices), s->centroid);
}

static sn_status hand_over(selection *s, const sn_roots_params *params, sn_roots *out, sn_error *error) {
    sn_index *exact = sn_realloc(s->vertices, (size_t)s->count, sizeof *exact);
    if (exact) s->vertices = exact;
    out->rule = sn_strdup(rule_name(params));
    if (!out->rule) return sn_fail_memory(error, "the roots");
    out->count = s->count;
    out->vertices = s->vertices;
    s->vertices = NULL;
    return SN_OK;
}

sn_roots_params sn_roots_defaults(void) { return (sn_roots_params){.automatic = true}; }

sn_status sn_roots_select(const sn_muscle *muscle, const sn_roots_params *params, sn_trace *trace, sn_roots *out, sn_roots_report *report,
                          sn_error *error) {
    *out = (sn_roots){0};
    if (report) *report = (sn_roots_report){.level = NAN, .span = NAN};
    if (sn_trace_stopped(trace)) return SN_STOPPED;
    selection s = {.muscle = muscle, .params = params, .mesh = &muscle->mesh, .trace = trace};
    sn_status status = prepare(&s, error);
    if (!status) status = params->automatic ? select_automatic(&s, error) : select_manual(&s, &params->selector, error);
    if (!status) {
        fill_report(&s);
        status = hand_over(&s, params, out, error);
    }
    if (report) *report = s.report;
    section_free(&s.cut);
    sn_topology_free(&s.topology);
    free(s.vertices);
    return status;
}
