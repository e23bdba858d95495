/*
 * clean.c -- from any surface to a closed, oriented 2-manifold (methods.md 1): a table of stages, each counted and traced.
 */
#include "sinew/rig.h"

#include <stdlib.h>
#include <string.h>

sn_clean_params sn_clean_defaults(void) {
    return (sn_clean_params){.weld = 1e-6, .make_manifold = true, .keep = 1, .max_hole = SN_INDEX_MAX, .outward = true};
}

void sn_clean_report_free(sn_clean_report *report) {
    free(report->dropped);
    report->dropped = NULL;
    report->dropped_count = 0;
}

/* What the stages share. `found` describes the mesh as it is: a stage that changes it looks again. */
typedef struct cleaning {
    const sn_clean_params *params;
    sn_trace *trace;
    sn_mesh *mesh;
    sn_mesh_report found;
    sn_clean_report *report;
    sn_error *error;
} cleaning;

static sn_status look(cleaning *c) { return sn_mesh_inspect(c->mesh, &c->found, c->error); }

static sn_status stop_if(bool stop) { return stop ? SN_STOPPED : SN_OK; }

static sn_status need_triangles(const cleaning *c, const char *after) {
    if (c->mesh->triangle_count > 0) return SN_OK;
    return sn_fail(c->error, SN_ERROR_INPUT, "no triangle with an area is left %s; is this a surface?", after);
}

/* ---- stages ----------------------------------------------------------------------------------------------------------- */

/* Welding must not undo a closed manifold: coincident vertices where it touches itself are there on purpose. Where whole triangles
 * of several bodies coincide, two share a wall or are the same twice, and welding shows it. */
static bool welding_helps(const sn_mesh_report *before, const sn_mesh_report *after) {
    bool was_whole = before->closed && before->manifold, is_whole = after->closed && after->manifold;
    bool shares_wall = before->components > 1 && after->duplicate_triangles > before->duplicate_triangles;
    return is_whole || !was_whole || shares_wall;
}

static sn_status weld(cleaning *c) {
    sn_mesh copy;
    sn_index welded = 0;
    sn_status status = sn_mesh_copy(c->mesh, &copy, c->error);
    if (status != SN_OK) return status;
    status = sn_weld(&copy, c->params->weld * c->found.diagonal, &welded, NULL, c->error);
    sn_mesh_report after = c->found;
    if (status == SN_OK && welded > 0) status = sn_mesh_inspect(&copy, &after, c->error);
    if (status == SN_OK && welded > 0 && welding_helps(&c->found, &after)) {
        sn_mesh_free(c->mesh);
        *c->mesh = copy;
        copy = (sn_mesh){0};
        c->report->welded = welded;
        c->found = after;
    }
    sn_mesh_free(&copy);
    if (status == SN_OK) status = need_triangles(c, "after joining vertices that coincide");
    return status == SN_OK ? stop_if(SN_TRACE(c->trace, "weld", sn_trace_number("welded", c->report->welded))) : status;
}

static sn_status drop_bad(cleaning *c) {
    sn_clean_report *r = c->report;
    sn_status status = SN_OK;
    if (c->found.degenerate_triangles > 0 || c->found.duplicate_triangles > 0 || c->found.unused_vertices > 0) {
        sn_index unused = 0;
        status = sn_drop_bad_triangles(c->mesh, &r->degenerate, &r->duplicate, c->error);
        if (status == SN_OK) status = need_triangles(c, "without degenerate ones");
        if (status == SN_OK) status = sn_drop_unused_vertices(c->mesh, &unused, c->error);
        if (status == SN_OK) status = look(c);
        r->unused += unused;
    }
    if (status != SN_OK) return status;
    return stop_if(SN_TRACE(c->trace, "drop", sn_trace_number("degenerate", r->degenerate), sn_trace_number("duplicate", r->duplicate),
                            sn_trace_number("unused", r->unused)));
}

static sn_status make_manifold(cleaning *c) {
    if (!c->params->make_manifold) return SN_OK;
    sn_manifold_report done = {.orientable = true};
    sn_status status = SN_OK;
    if (!c->found.manifold || !c->found.oriented) {
        status = sn_make_manifold(c->mesh, &done, c->error);
        if (status == SN_OK) status = need_triangles(c, "of the manifold part");
        if (status == SN_OK) status = look(c);
    }
    c->report->wall_triangles = done.wall_triangles;
    c->report->flipped_triangles = done.flipped;
    c->report->split_vertices = done.split_vertices;
    c->report->stitched_edges = done.stitched_edges;
    c->report->orientable = done.orientable;
    if (status != SN_OK) return status;
    return stop_if(SN_TRACE(c->trace, "manifold", sn_trace_number("wall_triangles", done.wall_triangles),
                            sn_trace_number("flipped", done.flipped), sn_trace_number("split_vertices", done.split_vertices),
                            sn_trace_number("stitched_edges", done.stitched_edges)));
}

/* ---- components --------------------------------------------------------------------------------------------------------- */

/* Six times the volume of a triangle with the origin; relative to `centre`. */
static double six_volumes(sn_vec3 a, sn_vec3 b, sn_vec3 c, sn_vec3 centre) {
    return sn_dot(sn_sub(a, centre), sn_cross(sn_sub(b, centre), sn_sub(c, centre)));
}

/* Area, volume and area centre of each component. */
static void measure_components(const cleaning *c, const sn_index *component, sn_index count, sn_dropped_component *measure) {
    sn_vec3 centre = sn_lerp(c->found.box.low, c->found.box.high, 0.5);
    for (sn_index t = 0; t < c->mesh->triangle_count; t++) {
        const sn_index *v = c->mesh->triangles[t].v;
        sn_vec3 p = c->mesh->positions[v[0]], q = c->mesh->positions[v[1]], r = c->mesh->positions[v[2]];
        sn_dropped_component *m = &measure[component[t]];
        double area = 0.5 * sn_norm(sn_area_vector(p, q, r));
        m->triangles++;
        m->area += area;
        m->volume += six_volumes(p, q, r, centre) / 6.0;
        m->centre = sn_add_scaled(m->centre, sn_add(p, sn_add(q, r)), area / 3.0);
    }
    for (sn_index i = 0; i < count; i++) {
        if (measure[i].area > 0.0) measure[i].centre = sn_scale(measure[i].centre, 1.0 / measure[i].area);
    }
}

/* A component's number beside its area, to be sorted by area, largest first; equal ones keep their order. */
typedef struct ranked {
    double area;
    sn_index number;
} ranked;

static int larger_first(const void *left, const void *right) {
    const ranked *a = left, *b = right;
    if (a->area != b->area) return a->area > b->area ? -1 : 1;
    return (a->number > b->number) - (a->number < b->number);
}

static void keep_ranked(cleaning *c, const sn_index *component, const ranked *order, sn_index count, const sn_dropped_component *measure,
                        bool *keep_component, bool *keep) {
    for (sn_index i = 0; i < count; i++) {
        keep_component[order[i].number] = i < c->params->keep;
        if (i >= c->params->keep) c->report->dropped[c->report->dropped_count++] = measure[order[i].number];
    }
    for (sn_index t = 0; t < c->mesh->triangle_count; t++) keep[t] = keep_component[component[t]];
    sn_mesh_keep_triangles(c->mesh, keep);
}

static sn_status keep_largest(cleaning *c, const sn_topology *topology) {
    sn_index triangles = c->mesh->triangle_count, count = 0;
    sn_index *component = SN_NEW(sn_index, triangles);
    bool *keep = SN_NEW(bool, triangles);
    if (component != NULL) count = sn_mesh_components(c->mesh, topology, component);
    sn_dropped_component *measure = SN_NEW(sn_dropped_component, count);
    ranked *order = SN_NEW(ranked, count);
    bool *keep_component = SN_NEW(bool, count);
    c->report->dropped = SN_NEW(sn_dropped_component, count);
    bool enough = component && keep && measure && order && keep_component && c->report->dropped;
    if (enough) {
        measure_components(c, component, count, measure);
        for (sn_index i = 0; i < count; i++) order[i] = (ranked){measure[i].area, i};
        qsort(order, (size_t)count, sizeof *order, larger_first);
        keep_ranked(c, component, order, count, measure, keep_component, keep);
    }
    free(component);
    free(keep);
    free(measure);
    free(order);
    free(keep_component);
    return enough ? SN_OK : sn_fail_memory(c->error, "sorting components");
}

static sn_status keep_components(cleaning *c) {
    sn_index before = c->found.components;
    sn_status status = SN_OK;
    if (c->params->keep > 0 && before > c->params->keep) {
        sn_topology topology;
        sn_index unused = 0;
        status = sn_topology_build(c->mesh, &topology, c->error);
        if (status == SN_OK) status = keep_largest(c, &topology);
        sn_topology_free(&topology);
        if (status == SN_OK) status = sn_drop_unused_vertices(c->mesh, &unused, c->error);
        if (status == SN_OK) status = look(c);
    }
    if (status != SN_OK) return status;
    return stop_if(
        SN_TRACE(c->trace, "components", sn_trace_number("found", before), sn_trace_number("dropped", c->report->dropped_count)));
}

/* ---- stages, continued ---------------------------------------------------------------------------------------------------- */

/* Filling a crack along a straight edge makes triangles without area; dropping them splits their neighbours instead. */
static sn_status fill_holes(cleaning *c) {
    sn_clean_report *r = c->report;
    if (c->params->max_hole == 0) return SN_OK;
    sn_index left = c->found.boundary_edges;
    sn_status status = SN_OK;
    if (left > 0) {
        status = sn_fill_holes(c->mesh, c->params->max_hole, c->trace, &r->holes_filled, &left, c->error);
        if (status != SN_OK) return status;
        status = look(c);
        sn_index degenerate = 0, duplicate = 0;
        if (status == SN_OK && c->found.degenerate_triangles > 0) {
            status = sn_drop_bad_triangles(c->mesh, &degenerate, &duplicate, c->error);
            if (status == SN_OK) status = look(c);
            r->degenerate += degenerate;
            r->duplicate += duplicate;
        }
    }
    if (status != SN_OK) return status;
    return stop_if(
        SN_TRACE(c->trace, "holes", sn_trace_number("filled", r->holes_filled), sn_trace_number("boundary_left", c->found.boundary_edges)));
}

static sn_status orient_outward(cleaning *c) {
    if (!c->params->outward) return SN_OK;
    sn_status status = SN_OK;
    if (!c->found.outward && c->found.oriented) {
        status = sn_orient_outward(c->mesh, &c->report->flipped_components, c->error);
        if (status == SN_OK) status = look(c);
    }
    if (status != SN_OK) return status;
    return stop_if(SN_TRACE(c->trace, "outward", sn_trace_number("flipped_components", c->report->flipped_components)));
}

static sn_status decimate(cleaning *c) {
    if (c->params->triangles == 0) return SN_OK;
    sn_index before = c->mesh->triangle_count;
    sn_status status = SN_OK;
    if (before > c->params->triangles) {
        if (!c->found.manifold || !c->found.oriented) {
            return sn_fail(c->error, SN_ERROR_INPUT, "only an oriented manifold can be decimated; leave out --no-manifold, or --triangles");
        }
        status = sn_decimate(c->mesh, c->params->triangles, c->error);
        if (status == SN_OK) status = look(c);
    }
    c->report->decimated_triangles = before - c->mesh->triangle_count;
    if (status != SN_OK) return status;
    return stop_if(SN_TRACE(c->trace, "decimate", sn_trace_number("before", before), sn_trace_number("after", c->mesh->triangle_count)));
}

/* ---- the whole -------------------------------------------------------------------------------------------------------------- */

static sn_status (*const stages[])(cleaning *) = {weld, drop_bad, make_manifold, keep_components, fill_holes, orient_outward, decimate};

/* Squares of coordinates must stay within the range of a double. */
#define GREATEST_EXTENT 1e100

static sn_status check_extent(const cleaning *c) {
    double diagonal = c->found.diagonal;
    if (diagonal > 0.0 && diagonal < GREATEST_EXTENT) return SN_OK;
    if (diagonal == 0.0) return sn_fail(c->error, SN_ERROR_INPUT, "all vertices are at one place; there is no surface to clean");
    return sn_fail(c->error, SN_ERROR_INPUT, "the surface is %g wide, more than can be computed with; are its coordinates right?",
                   diagonal);
}

static sn_status prepare(cleaning *c, const sn_mesh *mesh) {
    sn_status status = SN_OK;
    if (c->params->repair_nonfinite)
        status = sn_drop_nonfinite_vertices(c->mesh, &c->report->nonfinite_vertices, c->error);
    else
        status = sn_mesh_validate(mesh, c->error);
    if (status == SN_OK && c->mesh->triangle_count == 0) {
        status = sn_fail(c->error, SN_ERROR_INPUT,
                         mesh->triangle_count == 0 ? "the mesh has no triangles; a surface is needed"
                                                   : "every triangle has a coordinate that is not finite");
    }
    if (status == SN_OK) status = look(c);
    if (status == SN_OK) status = check_extent(c);
    if (status == SN_OK && c->params->count_intersections) {
        status = sn_count_self_intersections(c->mesh, &c->found.self_intersections, c->error);
    }
    c->report->before = c->found;
    return status;
}

static bool report_input(const cleaning *c) {
    return SN_TRACE(c->trace, "input", sn_trace_number("vertices", c->found.vertices), sn_trace_number("triangles", c->found.triangles),
                    sn_trace_number("nonfinite", c->report->nonfinite_vertices));
}

static bool is_same(const sn_mesh *a, const sn_mesh *b) {
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           memcmp(a->positions, b->positions, (size_t)a->vertex_count * sizeof *a->positions) == 0 &&
           memcmp(a->triangles, b->triangles, (size_t)a->triangle_count * sizeof *a->triangles) == 0;
}

/* Against the input without its non-finite vertices: they have no distance from anything. */
static sn_status compare(cleaning *c, const sn_mesh *mesh) {
    sn_mesh finite = {0};
    sn_index dropped = 0;
    sn_status status = sn_mesh_copy(mesh, &finite, c->error);
    if (status == SN_OK && c->params->repair_nonfinite) status = sn_drop_nonfinite_vertices(&finite, &dropped, c->error);
    double lost = 0.0;
    if (status == SN_OK) status = sn_one_sided_distance(c->mesh, &finite, &c->report->moved, c->error);
    if (status == SN_OK) status = sn_one_sided_distance(&finite, c->mesh, &lost, c->error);
    c->report->hausdorff = fmax(c->report->moved, lost);
    sn_mesh_free(&finite);
    return status;
}

static sn_status conclude(cleaning *c, const sn_mesh *mesh) {
    sn_status status = SN_OK;
    c->report->unchanged = is_same(mesh, c->mesh);
    if (!c->report->unchanged) status = look(c);
    c->found.self_intersections = c->report->before.self_intersections;
    if (status == SN_OK && c->params->count_intersections && !c->report->unchanged) {
        status = sn_count_self_intersections(c->mesh, &c->found.self_intersections, c->error);
    }
    if (status == SN_OK && !c->report->unchanged) status = compare(c, mesh);
    c->report->after = c->found;
    return status;
}

sn_status sn_clean(const sn_mesh *mesh, const sn_clean_params *params, sn_trace *trace, sn_mesh *out, sn_clean_report *report,
                   sn_error *error) {
    *report = (sn_clean_report){.orientable = true};
    cleaning c = {.params = params, .trace = trace, .mesh = out, .report = report, .error = error};
    sn_status status = sn_mesh_copy(mesh, out, error);
    if (status == SN_OK) status = prepare(&c, mesh);
    bool ready = status == SN_OK;
    if (ready && sn_trace_stopped(trace)) status = SN_STOPPED;
    if (status == SN_OK) status = stop_if(report_input(&c));
    for (size_t i = 0; status == SN_OK && i < sizeof stages / sizeof *stages; i++) status = stages[i](&c);
    if (status == SN_OK || status == SN_STOPPED) {
        sn_status concluded = conclude(&c, mesh);
        if (concluded != SN_OK) status = concluded;
    }
    if (status == SN_OK || status == SN_STOPPED) return status;
    sn_mesh_free(out);
    sn_clean_report_free(report);
    return status;
}
