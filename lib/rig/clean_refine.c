/*
 * clean_refine.c -- what is done to a sound surface on request: remeshing, decimation, smoothing, flips. All keep the volume,
 * and each is done gentler, or left undone, where it would make crossings.
 */
#include "cleaning.h"

#include <stdlib.h>

static bool is_sound(const sn_mesh_report *found) { return found->manifold && found->oriented; }

static sn_status need_sound(const sn_cleaning *c, const char *what) {
    if (is_sound(&c->found)) return SN_OK;
    return sn_fail(c->error, SN_ERROR_INPUT, "only an oriented manifold can be %s; leave out --no-manifold, or %s", what,
                   what[0] == 'd' ? "--triangles" : "--edge-length");
}

/* ---- a step, gentler where it makes crossings ----------------------------------------------------------------------------------- */

#define MOST_TRIES 4

/* What a step does to a mesh, and to how many things; vertices that are held (nullable) are left alone. */
typedef sn_status (*work)(const sn_cleaning *c, sn_mesh *mesh, const bool *held, sn_index *count, sn_error *error);

typedef struct refinement {
    work run;
    double volume; /* to be put back; NaN = not */
    bool optional; /* better left undone than making crossings */
    sn_index count;
} refinement;

static sn_status run_once(const sn_cleaning *c, refinement *step, sn_mesh *mesh, const bool *held, sn_error *error) {
    sn_status status = step->run(c, mesh, held, &step->count, error);
    bool restores = c->found.closed && !isnan(step->volume);
    return status == SN_OK && restores ? sn_restore_volume(mesh, step->volume, error) : status;
}

/* The triangles of `after` that cross because the step made them. */
static sn_status find_crossing_part(const sn_mesh *start, const sn_mesh *after, sn_mesh *part, sn_error *error) {
    sn_index pairs = 0, count = 0;
    bool *is_new = SN_NEW(bool, after->triangle_count), *crosses = SN_NEW(bool, after->triangle_count);
    sn_status status = is_new != NULL && crosses != NULL ? SN_OK : sn_fail_memory(error, "taking back crossings");
    if (status == SN_OK) status = sn_find_new_triangles(start, after, is_new, error);
    if (status == SN_OK) status = sn_find_self_intersections(after, 0, is_new, crosses, &pairs, error);
    if (status == SN_OK) status = sn_mesh_copy(after, part, error);
    for (sn_index t = 0; status == SN_OK && t < after->triangle_count; t++) {
        if (crosses[t]) part->triangles[count++] = after->triangles[t];
    }
    if (status == SN_OK) part->triangle_count = count;
    free(crosses);
    free(is_new);
    return status;
}

/* Hold, too, the vertices of the start within reach of triangles that cross after it. */
static sn_status hold_more(const sn_mesh *start, const sn_mesh *after, double reach, bool *held, sn_error *error) {
    sn_mesh part = {0};
    sn_surface *surface = NULL;
    sn_status status = find_crossing_part(start, after, &part, error);
    if (status == SN_OK && part.triangle_count > 0) status = sn_surface_create_plain(&part, &surface, error);
    for (sn_index v = 0; surface != NULL && v < start->vertex_count; v++) {
        held[v] = held[v] || sn_surface_closest(surface, start->positions[v], reach).triangle != SN_NONE;
    }
    sn_surface_destroy(surface);
    sn_mesh_free(&part);
    return status;
}

/* The mesh before the step, its crossings, the fewest after a try, and what is held in the next. */
typedef struct tries {
    sn_mesh start;
    sn_index before, fewest;
    bool *held; /* (start.vertex_count) */
} tries;

/* Another try that leaves alone what crosses after the best one; a failure of a gentler one is not the step's. */
static sn_status try_gentler(sn_cleaning *c, refinement *step, tries *t, double reach) {
    sn_mesh tried = {0};
    refinement gentler = *step;
    sn_index pairs = 0;
    sn_error why = {0};
    sn_status status = hold_more(&t->start, c->mesh, reach, t->held, c->error);
    if (status == SN_OK) status = sn_mesh_copy(&t->start, &tried, c->error);
    if (status == SN_OK && run_once(c, &gentler, &tried, t->held, &why) == SN_OK) {
        status = sn_count_self_intersections(&tried, &pairs, c->error);
        if (status == SN_OK && pairs < t->fewest) {
            sn_mesh_free(c->mesh);
            *c->mesh = tried;
            tried = (sn_mesh){0};
            t->fewest = pairs;
            *step = gentler;
        }
    }
    sn_mesh_free(&tried);
    return status;
}

static sn_status take_back(sn_cleaning *c, refinement *step, tries *t) {
    sn_index made = t->fewest;
    sn_status status = SN_OK;
    double reach = fmax(c->found.edge_mean, c->params->edge_length);
    for (int i = 0; status == SN_OK && t->fewest > t->before && i < MOST_TRIES; i++) status = try_gentler(c, step, t, i * reach);
    if (status == SN_OK && t->fewest > t->before && step->optional) {
        sn_mesh_free(c->mesh);
        *c->mesh = t->start;
        t->start = (sn_mesh){0};
        t->fewest = t->before;
        step->count = 0;
    }
    c->report->undone_crossings += made - t->fewest;
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "uncross", sn_trace_number("before", t->before), sn_trace_number("made", made),
                               sn_trace_number("left", t->fewest)));
}

/* Run the step on the mesh and look; where it makes crossings, gentler. */
static sn_status watch(sn_cleaning *c, refinement *step) {
    tries t = {.fewest = -1};
    sn_status status = sn_cleaning_count_crossings(c);
    t.before = c->found.self_intersections;
    if (status == SN_OK && t.before >= 0) status = sn_mesh_copy(c->mesh, &t.start, c->error);
    if (status == SN_OK) status = run_once(c, step, c->mesh, NULL, c->error);
    if (status == SN_OK && t.before >= 0) status = sn_find_self_intersections(c->mesh, 0, NULL, NULL, &t.fewest, c->error);
    if (status == SN_OK && t.fewest > t.before) {
        t.held = SN_NEW(bool, t.start.vertex_count);
        status = t.held != NULL ? take_back(c, step, &t) : sn_fail_memory(c->error, "taking back crossings");
    }
    free(t.held);
    sn_mesh_free(&t.start);
    sn_status looked = status == SN_OK || status == SN_STOPPED ? sn_cleaning_look(c) : status;
    c->found.self_intersections = t.fewest;
    return looked == SN_OK ? status : looked;
}

static sn_status run_step(sn_cleaning *c, refinement *step) {
    if (c->params->watch_crossings) return watch(c, step);
    sn_status status = run_once(c, step, c->mesh, NULL, c->error);
    return status == SN_OK ? sn_cleaning_look(c) : status;
}

/* ---- the steps ------------------------------------------------------------------------------------------------------------------ */

static sn_status run_remesh(const sn_cleaning *c, sn_mesh *mesh, const bool *held, sn_index *count, sn_error *error) {
    (void)count;
    return sn_remesh(mesh, c->params->edge_length, held, error);
}

static sn_status remesh(sn_cleaning *c, double volume) {
    if (c->params->edge_length <= 0.0) return SN_OK;
    sn_index before = c->mesh->triangle_count;
    refinement step = {.run = run_remesh, .volume = volume};
    sn_status status = need_sound(c, "remeshed");
    if (status == SN_OK) status = run_step(c, &step);
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "remesh", sn_trace_number("before", before), sn_trace_number("after", c->mesh->triangle_count),
                               sn_trace_number("volume", c->found.volume)));
}

/* Fewer crossings are no reason to have more triangles than were asked for. */
static sn_status run_decimate(const sn_cleaning *c, sn_mesh *mesh, const bool *held, sn_index *count, sn_error *error) {
    (void)count;
    sn_status status = sn_decimate(mesh, c->params->triangles, held, error);
    if (status != SN_OK || held == NULL || mesh->triangle_count <= c->params->triangles) return status;
    return sn_fail(error, SN_ERROR_INTERNAL, "too much is held for so few triangles");
}

static sn_status decimate(sn_cleaning *c, double volume) {
    if (c->params->triangles == 0) return SN_OK;
    sn_index before = c->mesh->triangle_count;
    refinement step = {.run = run_decimate, .volume = volume};
    sn_status status = SN_OK;
    if (before > c->params->triangles) {
        status = need_sound(c, "decimated");
        if (status == SN_OK) status = run_step(c, &step);
    }
    c->report->decimated_triangles = before - c->mesh->triangle_count;
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "decimate", sn_trace_number("before", before), sn_trace_number("after", c->mesh->triangle_count),
                               sn_trace_number("volume", c->found.volume)));
}

static sn_status run_smooth(const sn_cleaning *c, sn_mesh *mesh, const bool *held, sn_index *count, sn_error *error) {
    (void)count;
    return sn_smooth(mesh, c->params->smooth, held, error);
}

static sn_status smooth(sn_cleaning *c, double volume) {
    if (c->params->smooth == 0) return SN_OK;
    refinement step = {.run = run_smooth, .volume = volume, .optional = true};
    sn_status status = run_step(c, &step);
    if (status != SN_OK) return status;
    return sn_stop_if(
        SN_TRACE(c->trace, "smooth", sn_trace_number("rounds", c->params->smooth), sn_trace_number("volume", c->found.volume)));
}

static sn_status run_flips(const sn_cleaning *c, sn_mesh *mesh, const bool *held, sn_index *count, sn_error *error) {
    (void)c;
    return sn_flip_slivers(mesh, held, count, error);
}

/* Flips between triangles that are nearly coplanar: the volume needs no putting back. */
static sn_status flip_slivers(sn_cleaning *c, double volume) {
    (void)volume;
    if (!c->params->flip_slivers || !is_sound(&c->found)) return SN_OK;
    sn_index before = c->found.sliver_triangles;
    refinement step = {.run = run_flips, .volume = NAN, .optional = true};
    sn_status status = before > 0 ? run_step(c, &step) : SN_OK;
    c->report->flipped_slivers = step.count;
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "slivers", sn_trace_number("before", before),
                               sn_trace_number("flipped", c->report->flipped_slivers), sn_trace_number("left", c->found.sliver_triangles)));
}

sn_status sn_cleaning_refine(sn_cleaning *c) {
    double volume = c->found.volume;
    sn_status (*const steps[])(sn_cleaning *, double) = {remesh, decimate, smooth, flip_slivers};
    sn_status status = SN_OK;
    for (size_t i = 0; status == SN_OK && i < sizeof steps / sizeof *steps; i++) status = steps[i](c, volume);
    bool measurable = c->found.closed && volume != 0.0;
    c->report->volume_change = measurable ? c->found.volume / volume - 1.0 : NAN;
    return status;
}
