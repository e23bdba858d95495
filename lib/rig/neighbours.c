/*
 * neighbours.c -- where a muscle rubs on its neighbours: candidates for external constraints ([R18] 4.3, fig. 11).
 *
 * Deep fascia joins surfaces that face each other; superficial fascia holds in what faces no neighbour: there the normals of the muscle
 * and of the envelope agree. First every target is asked what each vertex finds on it; then each vertex keeps the nearest of its targets
 * that nothing hides. The vertices are tried in parallel, the results listed in order.
 */
#include "attach.h"

#include <stdlib.h>
#include <string.h>

enum { VERTICES_PER_CHUNK = 256 };
/* The ends of a line of sight lie on surfaces, and this share of it near them does not count. */
static const double SIGHT_ENDS = 1e-6;
/* A vertex that has entered a surface sees out of it where it comes out within so many times its depth: near the place where it went in. */
static const double WAY_OUT = 2.0;

/* What a vertex finds on a target; triangle SN_NONE = nothing. */
typedef struct found {
    sn_closest closest;
    double distance; /* signed */
} found;

typedef enum fate { KEPT, HIDDEN, SURPLUS } fate;

typedef struct candidate {
    sn_index vertex, target;
    found found;
    unsigned char fate;
} candidate;

/* A surface that is a target, or may hide one. */
typedef struct body {
    const sn_mesh *mesh;
    sn_surface *surface; /* NULL = out of reach: neither searched nor in the way */
    sn_box box;
    bool hides;
    double outward; /* 1, or -1 where its faces look inwards */
} body;

typedef struct search {
    const sn_muscle *muscle;
    const sn_neighbours_params *params;
    sn_pool *pool;
    double reach;
    sn_vec3 *normals; /* (vertex_count) of the muscle */
    bool *faces;      /* (vertex_count) it has a deep neighbour */
    found *found;     /* (vertex_count) on the target under search */
    sn_index body_count;
    body *bodies; /* (body_count) the targets, the obstacles, the muscle */
    /* of the target under search */
    sn_index target;
    sn_vec3 *target_normals; /* (vertex_count of the target) */
    bool superficial;
    /* of deep fascia: by target, then vertex */
    size_t candidate_count, candidate_capacity;
    candidate *candidates;
    size_t *first; /* (vertex_count + 1) where a vertex's begin in `order` */
    size_t *order; /* (candidate_count) candidates by vertex, then target; sorted by distance */
    sn_neighbours_found *out;
} search;

sn_neighbours_params sn_neighbours_defaults(void) {
    return (sn_neighbours_params){.reach = -1.0, .opposing = 0.2, .most = 2, .weights = {1.0, 0.0, 0.0}};
}

void sn_neighbours_free(sn_neighbours_found *list) {
    sn_externals_free(list->items, list->count);
    *list = (sn_neighbours_found){0};
}

/* ---- one vertex and one target ---------------------------------------------------------------------------------------------------- */

/* Interpolated between the corners: the same from every triangle that a point belongs to. */
static sn_vec3 normal_at(const search *s, const sn_closest *c) {
    const sn_index *v = s->bodies[s->target].mesh->triangles[c->triangle].v;
    sn_vec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) sum = sn_add_scaled(sum, s->target_normals[v[k]], c->barycentric[k]);
    return sn_normalize(sum);
}

/* Deep fascia joins what lies before a vertex; a vertex that has entered the target looks out of it through its own muscle. */
static bool lies_before(const search *s, sn_index v, const found *f) {
    sn_vec3 way = sn_sub(f->closest.point, s->muscle->mesh.positions[v]);
    return f->distance <= 0.0 || sn_dot(way, s->normals[v]) >= 0.0;
}

static found look(const search *s, sn_index v) {
    sn_vec3 p = s->muscle->mesh.positions[v];
    const body *b = &s->bodies[s->target];
    found f = {.closest = {.triangle = SN_NONE}};
    if (sn_box_gap((sn_box){p, p}, b->box) > s->reach) return f;
    f.closest = sn_surface_closest(b->surface, p, s->reach);
    if (f.closest.triangle == SN_NONE) return f;
    double agree = sn_dot(s->normals[v], normal_at(s, &f.closest));
    bool fits = s->superficial ? agree > s->params->opposing : agree < -s->params->opposing;
    if (fits) f.distance = sn_surface_signed_distance(b->surface, p, NULL);
    if (!fits || (!s->superficial && !lies_before(s, v, &f))) f.closest.triangle = SN_NONE;
    return f;
}

static void look_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    search *s = user;
    for (sn_index v = begin; v < end; v++) {
        if (s->superficial && s->faces[v])
            s->found[v].closest.triangle = SN_NONE;
        else
            s->found[v] = look(s, v);
    }
}

/* ---- lists of what was found ------------------------------------------------------------------------------------------------------- */

static double weight(search *s, int kind, sn_index v) {
    const double *map = s->params->maps[kind];
    if (map == NULL) return s->params->weights[kind];
    if (map[v] < 0.0 || map[v] > 1.0) s->out->clamped++;
    return fmin(fmax(map[v], 0.0), 1.0);
}

static void store(search *s, sn_index v, const found *f, sn_external *e) {
    size_t k = (size_t)e->count++;
    e->vertices[k] = v;
    e->triangles[k] = f->closest.triangle;
    memcpy(&e->barycentric[3 * k], f->closest.barycentric, sizeof f->closest.barycentric);
    e->distances[k] = f->distance;
    e->minimum[k] = fmin(s->params->minimum, f->distance); /* at rest nothing is pushed */
    for (int w = 0; w < 3; w++) e->weights[3 * k + (size_t)w] = weight(s, w, v);
}

/* The next item of the list, with room for `count` vertices. */
static sn_status open_item(search *s, sn_index target, size_t count, sn_external **out, sn_error *error) {
    sn_external *e = *out = &s->out->items[s->out->count++];
    e->target = sn_strdup(s->params->targets[target].name);
    e->fascia = sn_strdup(s->superficial ? "superficial" : "deep");
    e->vertices = SN_NEW(sn_index, count);
    e->triangles = SN_NEW(sn_index, count);
    e->barycentric = SN_NEW(double, 3 * count);
    e->distances = SN_NEW(double, count);
    e->minimum = SN_NEW(double, count);
    e->weights = SN_NEW(double, 3 * count);
    bool complete = e->target && e->fascia && e->vertices && e->triangles && e->barycentric && e->distances && e->minimum && e->weights;
    return complete ? SN_OK : sn_fail_memory(error, "neighbours");
}

static size_t count_found(const search *s) {
    size_t count = 0;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) count += s->found[v].closest.triangle != SN_NONE;
    return count;
}

static sn_status list_superficial(search *s, sn_error *error) {
    size_t count = count_found(s);
    if (count == 0) return SN_OK;
    sn_external *e;
    sn_status status = open_item(s, s->target, count, &e, error);
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count && status == SN_OK; v++)
        if (s->found[v].closest.triangle != SN_NONE) store(s, v, &s->found[v], e);
    return status;
}

static sn_status note_deep(search *s, sn_error *error) {
    size_t count = count_found(s);
    if (!sn_grow((void **)&s->candidates, &s->candidate_capacity, s->candidate_count + count, sizeof *s->candidates))
        return sn_fail_memory(error, "neighbours");
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++)
        if (s->found[v].closest.triangle != SN_NONE)
            s->candidates[s->candidate_count++] = (candidate){.vertex = v, .target = s->target, .found = s->found[v]};
    return SN_OK;
}

/* ---- one target -------------------------------------------------------------------------------------------------------------------- */

static bool trace_target(const search *s, sn_trace *trace) {
    sn_index count = 0, *vertices = sn_trace_wanted(trace) ? SN_NEW(sn_index, s->muscle->mesh.vertex_count) : NULL;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count && vertices != NULL; v++)
        if (s->found[v].closest.triangle != SN_NONE) vertices[count++] = v;
    bool stop = SN_TRACE(trace, "neighbour", sn_trace_text("target", s->params->targets[s->target].name),
                         sn_trace_text("fascia", s->superficial ? "superficial" : "deep"), sn_trace_indices("vertices", vertices, count));
    free(vertices);
    return stop;
}

static sn_status search_target(search *s, sn_index t, bool superficial, sn_trace *trace, sn_error *error) {
    const body *b = &s->bodies[t];
    s->target = t;
    s->superficial = superficial;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) s->found[v].closest.triangle = SN_NONE;
    if (b->surface != NULL) {
        s->target_normals = SN_NEW(sn_vec3, b->mesh->vertex_count);
        if (s->target_normals == NULL) return sn_fail_memory(error, "neighbours");
        sn_mesh_vertex_normals(b->mesh, s->target_normals);
        sn_parallel_for(s->pool, s->muscle->mesh.vertex_count, VERTICES_PER_CHUNK, look_range, s);
        free(s->target_normals);
    }
    sn_status status = superficial ? list_superficial(s, error) : note_deep(s, error);
    return status == SN_OK && trace_target(s, trace) ? SN_STOPPED : status;
}

/* ---- the nearest targets of each vertex that nothing hides -------------------------------------------------------------------------- */

/* From a point, along a unit direction, over a length. */
typedef struct sight {
    sn_vec3 from, direction;
    double length;
} sight;

static bool comes_out(const body *b, const sight *line, const sn_ray_hit *hit) {
    const sn_index *v = b->mesh->triangles[hit->triangle].v;
    sn_vec3 area = sn_area_vector(b->mesh->positions[v[0]], b->mesh->positions[v[1]], b->mesh->positions[v[2]]);
    if (!(b->outward * sn_dot(area, line->direction) > 0.0)) return false;
    return hit->distance <= WAY_OUT * sn_surface_closest(b->surface, line->from, INFINITY).distance;
}

static bool crosses(const body *b, const sight *line) {
    double ends = SIGHT_ENDS * line->length;
    sn_ray_hit hit = sn_surface_ray(b->surface, line->from, line->direction, ends, line->length - ends);
    if (hit.triangle == SN_NONE) return false;
    if (!comes_out(b, line, &hit)) return true;
    return sn_surface_ray(b->surface, line->from, line->direction, hit.distance + ends, line->length - ends).triangle != SN_NONE;
}

/* Does the line from a vertex to its target cross another surface, or the muscle itself? Muscles overlap at rest: leaving one that the
 * vertex has entered a little is no crossing. */
static bool is_hidden(const search *s, const candidate *c) {
    sn_vec3 from = s->muscle->mesh.positions[c->vertex], to = c->found.closest.point, way = sn_sub(to, from);
    double length = sn_norm(way);
    if (!(length > SIGHT_ENDS * s->reach)) return false;
    const sight line = {from, sn_scale(way, 1.0 / length), length};
    sn_box box = {sn_min3(from, to), sn_max3(from, to)};
    for (sn_index i = 0; i < s->body_count; i++) {
        const body *b = &s->bodies[i];
        bool own = i == s->body_count - 1;
        if (i == c->target || !b->hides || b->surface == NULL || sn_box_gap(box, b->box) > 0.0) continue;
        if (own && c->found.distance <= 0.0) continue; /* it looks back through its own muscle */
        if (crosses(b, &line)) return true;
    }
    return false;
}

static double gap(const search *s, size_t k) { return s->candidates[k].found.closest.distance; }

/* Nearest first; of equally near ones the target given first. */
static void sort_by_distance(const search *s, size_t *order, size_t count) {
    for (size_t i = 1; i < count; i++) {
        size_t moved = order[i], k = i;
        for (; k > 0 && gap(s, order[k - 1]) > gap(s, moved); k--) order[k] = order[k - 1];
        order[k] = moved;
    }
}

static void choose_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    search *s = user;
    for (sn_index v = begin; v < end; v++) {
        size_t *order = &s->order[s->first[v]], count = s->first[v + 1] - s->first[v];
        sn_index kept = 0;
        sort_by_distance(s, order, count);
        for (size_t k = 0; k < count; k++) {
            candidate *c = &s->candidates[order[k]];
            bool full = s->params->most > 0 && kept == s->params->most;
            c->fate = full ? SURPLUS : !s->params->hidden && is_hidden(s, c) ? HIDDEN : KEPT;
            kept += c->fate == KEPT;
        }
        s->faces[v] = kept > 0;
    }
}

/* The candidates by vertex. */
static sn_status order_candidates(search *s, sn_error *error) {
    size_t vertices = (size_t)s->muscle->mesh.vertex_count;
    s->first = SN_NEW(size_t, vertices + 1);
    s->order = SN_NEW(size_t, s->candidate_count);
    size_t *next = SN_NEW(size_t, vertices + 1);
    if (s->first != NULL && s->order != NULL && next != NULL) {
        for (size_t k = 0; k < s->candidate_count; k++) s->first[s->candidates[k].vertex + 1]++;
        for (size_t v = 0; v < vertices; v++) s->first[v + 1] += s->first[v];
        memcpy(next, s->first, (vertices + 1) * sizeof *next);
        for (size_t k = 0; k < s->candidate_count; k++) s->order[next[s->candidates[k].vertex]++] = k;
    }
    free(next);
    return s->first != NULL && s->order != NULL && next != NULL ? SN_OK : sn_fail_memory(error, "neighbours");
}

/* Candidates begin..end are those of one target. */
static sn_status list_target(search *s, size_t begin, size_t end, sn_error *error) {
    size_t kept = 0;
    for (size_t k = begin; k < end; k++) {
        kept += s->candidates[k].fate == KEPT;
        s->out->hidden += s->candidates[k].fate == HIDDEN;
        s->out->surplus += s->candidates[k].fate == SURPLUS;
    }
    if (kept == 0) return SN_OK;
    sn_external *e;
    sn_status status = open_item(s, s->candidates[begin].target, kept, &e, error);
    for (size_t k = begin; k < end && status == SN_OK; k++)
        if (s->candidates[k].fate == KEPT) store(s, s->candidates[k].vertex, &s->candidates[k].found, e);
    return status;
}

static sn_status choose_deep(search *s, sn_error *error) {
    sn_status status = order_candidates(s, error);
    if (status != SN_OK) return status;
    s->superficial = false;
    sn_parallel_for(s->pool, s->muscle->mesh.vertex_count, VERTICES_PER_CHUNK, choose_range, s);
    for (size_t begin = 0, end; begin < s->candidate_count && status == SN_OK; begin = end) {
        for (end = begin; end < s->candidate_count && s->candidates[end].target == s->candidates[begin].target;) end++;
        status = list_target(s, begin, end, error);
    }
    return status;
}

/* ---- all of them ------------------------------------------------------------------------------------------------------------------ */

static sn_status check_params(const search *s, sn_error *error) {
    const sn_neighbours_params *p = s->params;
    for (int w = 0; w < 3; w++) {
        if (!(p->weights[w] >= 0.0 && p->weights[w] <= 1.0))
            return sn_fail(error, SN_ERROR_USAGE, "the weights of slide, soft and hard constraints must be within 0 to 1");
        for (sn_index v = 0; p->maps[w] != NULL && v < s->muscle->mesh.vertex_count; v++)
            if (!isfinite(p->maps[w][v])) return sn_fail(error, SN_ERROR_INPUT, "the map of a weight is not finite at vertex %d", v);
    }
    if (!isfinite(p->reach) || !isfinite(p->minimum)) return sn_fail(error, SN_ERROR_USAGE, "the reach must be a finite number");
    return SN_OK;
}

static sn_status check_targets(const search *s, sn_error *error) {
    sn_error reason = {0};
    for (sn_index t = 0; t < s->params->target_count; t++) {
        for (sn_index other = 0; other < t; other++)
            if (strcmp(s->params->targets[t].name, s->params->targets[other].name) == 0)
                return sn_fail(error, SN_ERROR_INPUT, "target \"%s\" is given twice; give each a name of its own",
                               s->params->targets[t].name);
        sn_status status = sn_mesh_validate(s->params->targets[t].mesh, &reason);
        if (status != SN_OK) return sn_fail(error, status, "target \"%s\": %s", s->params->targets[t].name, reason.text);
    }
    for (sn_index i = 0; i < s->params->obstacle_count; i++) {
        sn_status status = sn_mesh_validate(s->params->obstacles[i], &reason);
        if (status != SN_OK) return sn_fail(error, status, "obstacle %d: %s", i + 1, reason.text);
    }
    return SN_OK;
}

/* plain: only rays are cast at it */
static sn_status open_body(const search *s, body *b, bool plain, sn_error *error) {
    b->box = sn_mesh_box(b->mesh);
    b->outward = sn_mesh_volume(b->mesh) < 0.0 ? -1.0 : 1.0;
    if (sn_box_gap(b->box, sn_mesh_box(&s->muscle->mesh)) > s->reach) return SN_OK;
    return plain ? sn_surface_create_plain(b->mesh, &b->surface, error) : sn_surface_create(b->mesh, &b->surface, error);
}

static sn_status open_bodies(search *s, sn_error *error) {
    const sn_neighbours_params *p = s->params;
    sn_error reason = {0};
    sn_status status = SN_OK;
    for (sn_index t = 0; t < p->target_count && status == SN_OK; t++) {
        body *b = &s->bodies[s->body_count++];
        *b = (body){.mesh = p->targets[t].mesh, .hides = !p->targets[t].envelope};
        status = open_body(s, b, false, &reason);
        s->out->culled += status == SN_OK && b->surface == NULL;
        if (status != SN_OK) return sn_fail(error, status, "target \"%s\": %s", p->targets[t].name, reason.text);
    }
    for (sn_index i = 0; i <= p->obstacle_count && status == SN_OK; i++) {
        body *b = &s->bodies[s->body_count++];
        *b = (body){.mesh = i < p->obstacle_count ? p->obstacles[i] : &s->muscle->mesh, .hides = true};
        status = open_body(s, b, true, error);
    }
    return status;
}

static sn_status prepare(search *s, sn_error *error) {
    sn_status status = sn_mesh_validate(&s->muscle->mesh, error);
    if (status == SN_OK) status = check_params(s, error);
    if (status == SN_OK) status = check_targets(s, error);
    if (status != SN_OK) return status;
    s->reach = s->params->reach >= 0.0 ? s->params->reach : 0.005 / s->muscle->meters_per_unit;
    s->normals = SN_NEW(sn_vec3, s->muscle->mesh.vertex_count);
    s->faces = SN_NEW(bool, s->muscle->mesh.vertex_count);
    s->found = SN_NEW(found, s->muscle->mesh.vertex_count);
    s->bodies = SN_NEW(body, (size_t)s->params->target_count + (size_t)s->params->obstacle_count + 1);
    s->out->items = SN_NEW(sn_external, 2 * (size_t)s->params->target_count);
    s->pool = sn_pool_create(s->params->threads); /* without one the loops run on this thread */
    if (!s->normals || !s->faces || !s->found || !s->bodies || !s->out->items) return sn_fail_memory(error, "neighbours");
    sn_mesh_vertex_normals(&s->muscle->mesh, s->normals);
    return open_bodies(s, error);
}

static void count_without(search *s) {
    for (sn_index i = 0; i < s->out->count; i++)
        for (sn_index k = 0; k < s->out->items[i].count; k++) s->faces[s->out->items[i].vertices[k]] = true;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) s->out->without += !s->faces[v];
}

static void close_search(search *s) {
    for (sn_index i = 0; i < s->body_count; i++) sn_surface_destroy(s->bodies[i].surface);
    sn_pool_destroy(s->pool);
    free(s->bodies);
    free(s->normals);
    free(s->faces);
    free(s->found);
    free(s->candidates);
    free(s->first);
    free(s->order);
}

sn_status sn_find_neighbours(const sn_muscle *muscle, const sn_neighbours_params *params, sn_trace *trace, sn_neighbours_found *out,
                             sn_error *error) {
    search s = {.muscle = muscle, .params = params, .out = out};
    *out = (sn_neighbours_found){0};
    sn_status status = prepare(&s, error);
    if (status == SN_OK && sn_trace_stopped(trace)) status = SN_STOPPED;
    for (sn_index t = 0; t < params->target_count && status == SN_OK; t++) status = search_target(&s, t, false, trace, error);
    if (status == SN_OK || status == SN_STOPPED) {
        sn_status chosen = choose_deep(&s, error);
        if (chosen != SN_OK) status = chosen;
    }
    for (sn_index t = 0; t < params->target_count && status == SN_OK; t++)
        if (params->targets[t].envelope) status = search_target(&s, t, true, trace, error); /* once it is known who faces whom */
    if (status == SN_OK || status == SN_STOPPED)
        count_without(&s);
    else
        sn_neighbours_free(out);
    close_search(&s);
    return status;
}
