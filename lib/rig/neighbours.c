/*
 * neighbours.c -- where a muscle rubs on its neighbours: candidates for external constraints ([R18] 4.3, fig. 11).
 *
 * Deep fascia joins surfaces that face each other; superficial fascia holds in what faces no neighbour: there the normals of the muscle
 * and of the envelope agree. The vertices are tried in parallel, the results listed in order.
 */
#include "attach.h"

#include <stdlib.h>
#include <string.h>

enum { VERTICES_PER_CHUNK = 256 };

/* What a vertex finds on a target; triangle SN_NONE = nothing. */
typedef struct found {
    sn_closest closest;
    double distance; /* signed */
} found;

typedef struct search {
    const sn_muscle *muscle;
    const sn_neighbours_params *params;
    sn_pool *pool;
    double reach;
    sn_vec3 *normals; /* (vertex_count) of the muscle */
    bool *faces;      /* (vertex_count) it has a deep neighbour */
    found *found;     /* (vertex_count) on the target under search */
    /* of the target under search */
    const sn_neighbour *target;
    sn_vec3 *target_normals; /* (vertex_count of the target) */
    sn_surface *surface;
    sn_box box;
    bool superficial;
    /* results */
    sn_index count;
    sn_external *list; /* (2 x target_count) */
} search;

sn_neighbours_params sn_neighbours_defaults(void) {
    return (sn_neighbours_params){.reach = -1.0, .opposing = 0.2, .weights = {1.0, 0.0, 0.0}};
}

/* ---- one vertex --------------------------------------------------------------------------------------------------------------- */

/* Interpolated between the corners: the same from every triangle that a point belongs to. */
static sn_vec3 normal_at(const search *s, const sn_closest *c) {
    const sn_index *v = s->target->mesh->triangles[c->triangle].v;
    sn_vec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) sum = sn_add_scaled(sum, s->target_normals[v[k]], c->barycentric[k]);
    return sn_normalize(sum);
}

static found look(const search *s, sn_index v) {
    sn_vec3 p = s->muscle->mesh.positions[v];
    found f = {.closest = {.triangle = SN_NONE}};
    if (sn_box_gap((sn_box){p, p}, s->box) > s->reach) return f;
    f.closest = sn_surface_closest(s->surface, p, s->reach);
    if (f.closest.triangle == SN_NONE) return f;
    double agree = sn_dot(s->normals[v], normal_at(s, &f.closest));
    bool fits = s->superficial ? agree > s->params->opposing : agree < -s->params->opposing;
    if (fits)
        f.distance = sn_surface_signed_distance(s->surface, p, NULL);
    else
        f.closest.triangle = SN_NONE;
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

/* ---- one target ------------------------------------------------------------------------------------------------------------------ */

static double weight(const search *s, int kind, sn_index v) {
    const double *map = s->params->maps[kind];
    return map != NULL ? fmin(fmax(map[v], 0.0), 1.0) : s->params->weights[kind];
}

static void store(const search *s, sn_index v, sn_external *e) {
    size_t k = (size_t)e->count++;
    const found *f = &s->found[v];
    e->vertices[k] = v;
    e->triangles[k] = f->closest.triangle;
    memcpy(&e->barycentric[3 * k], f->closest.barycentric, sizeof f->closest.barycentric);
    e->distances[k] = f->distance;
    e->minimum[k] = fmin(s->params->minimum, f->distance); /* at rest nothing is pushed */
    for (int w = 0; w < 3; w++) e->weights[3 * k + (size_t)w] = weight(s, w, v);
}

static sn_status allocate_external(const search *s, size_t count, sn_external *e, sn_error *error) {
    e->target = sn_strdup(s->target->name);
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

static sn_status list_found(search *s, sn_error *error) {
    size_t count = 0;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) count += s->found[v].closest.triangle != SN_NONE;
    if (count == 0) return SN_OK;
    sn_external *e = &s->list[s->count++];
    sn_status status = allocate_external(s, count, e, error);
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count && status == SN_OK; v++) {
        if (s->found[v].closest.triangle == SN_NONE) continue;
        store(s, v, e);
        s->faces[v] = s->faces[v] || !s->superficial;
    }
    return status;
}

static bool trace_target(const search *s, sn_index before, sn_trace *trace) {
    const sn_external *e = s->count > before ? &s->list[before] : NULL;
    return SN_TRACE(trace, "neighbour", sn_trace_text("target", s->target->name),
                    sn_trace_text("fascia", s->superficial ? "superficial" : "deep"),
                    sn_trace_indices("vertices", e ? e->vertices : NULL, e ? e->count : 0));
}

static sn_status search_target(search *s, sn_index t, bool superficial, sn_trace *trace, sn_error *error) {
    sn_error reason = {0};
    sn_index before = s->count;
    s->target = &s->params->targets[t];
    s->superficial = superficial;
    s->box = sn_mesh_box(s->target->mesh);
    s->target_normals = SN_NEW(sn_vec3, s->target->mesh->vertex_count);
    if (s->target_normals == NULL) return sn_fail_memory(error, "neighbours");
    sn_mesh_vertex_normals(s->target->mesh, s->target_normals);
    sn_status status = sn_surface_create(s->target->mesh, &s->surface, &reason);
    if (status == SN_OK) {
        sn_parallel_for(s->pool, s->muscle->mesh.vertex_count, VERTICES_PER_CHUNK, look_range, s);
        status = list_found(s, error);
        sn_surface_destroy(s->surface);
    } else {
        sn_fail(error, status, "target \"%s\": %s", s->target->name, reason.text);
    }
    free(s->target_normals);
    return status == SN_OK && trace_target(s, before, trace) ? SN_STOPPED : status;
}

/* ---- all of them ------------------------------------------------------------------------------------------------------------------ */

static sn_status check_params(const sn_neighbours_params *p, sn_error *error) {
    for (int w = 0; w < 3; w++)
        if (!(p->weights[w] >= 0.0 && p->weights[w] <= 1.0))
            return sn_fail(error, SN_ERROR_USAGE, "the weights of slide, soft and hard constraints must be within 0 to 1");
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
    return SN_OK;
}

static sn_status prepare(search *s, sn_error *error) {
    sn_status status = sn_mesh_validate(&s->muscle->mesh, error);
    if (status == SN_OK) status = check_params(s->params, error);
    if (status == SN_OK) status = check_targets(s, error);
    if (status != SN_OK) return status;
    s->reach = s->params->reach >= 0.0 ? s->params->reach : 0.005 / s->muscle->meters_per_unit;
    s->normals = SN_NEW(sn_vec3, s->muscle->mesh.vertex_count);
    s->faces = SN_NEW(bool, s->muscle->mesh.vertex_count);
    s->found = SN_NEW(found, s->muscle->mesh.vertex_count);
    s->list = SN_NEW(sn_external, 2 * (size_t)s->params->target_count);
    s->pool = sn_pool_create(s->params->threads); /* without one the loop runs on this thread */
    if (!s->normals || !s->faces || !s->found || !s->list) return sn_fail_memory(error, "neighbours");
    sn_mesh_vertex_normals(&s->muscle->mesh, s->normals);
    return SN_OK;
}

sn_status sn_find_neighbours(const sn_muscle *muscle, const sn_neighbours_params *params, sn_trace *trace, sn_index *count,
                             sn_external **out, sn_error *error) {
    search s = {.muscle = muscle, .params = params};
    *count = 0;
    *out = NULL;
    sn_status status = prepare(&s, error);
    if (status == SN_OK && sn_trace_stopped(trace)) status = SN_STOPPED;
    for (sn_index t = 0; t < params->target_count && status == SN_OK; t++) status = search_target(&s, t, false, trace, error);
    for (sn_index t = 0; t < params->target_count && status == SN_OK; t++)
        if (params->targets[t].envelope) status = search_target(&s, t, true, trace, error); /* once it is known who faces whom */
    if (status == SN_OK || status == SN_STOPPED) {
        *count = s.count;
        *out = s.list;
    } else {
        sn_externals_free(s.list, s.count);
    }
    sn_pool_destroy(s.pool);
    free(s.normals);
    free(s.faces);
    free(s.found);
    return status;
}
