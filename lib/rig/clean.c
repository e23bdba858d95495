/*
 * clean.c -- from any surface to a closed, oriented 2-manifold (methods.md 1): a table of stages, each counted and traced.
 */
#include "cleaning.h"

#include <stdlib.h>
#include <string.h>

sn_clean_params sn_clean_defaults(void) {
    return (sn_clean_params){.weld = 1e-6,
                             .close_cracks = true,
                             .make_manifold = true,
                             .keep = 1,
                             .max_hole = SN_INDEX_MAX,
                             .outward = true,
                             .watch_crossings = true,
                             .seconds = 30.0,
                             .most_lost = 0.05};
}

void sn_clean_report_free(sn_clean_report *report) {
    free(report->dropped);
    report->dropped = NULL;
    report->dropped_count = 0;
}

sn_status sn_cleaning_look(sn_cleaning *c) { return sn_mesh_inspect(c->mesh, &c->found, c->error); }

sn_status sn_cleaning_need_triangles(const sn_cleaning *c, const char *after) {
    if (c->mesh->triangle_count > 0) return SN_OK;
    return sn_fail(c->error, SN_ERROR_INPUT, "no triangle with an area is left %s; is this a surface?", after);
}

bool sn_cleaning_is_flat(const sn_mesh_report *found) {
    return found->closed && fabs(found->volume) <= SN_TINY_VOLUME * found->area * found->diagonal;
}

/* ---- stages ----------------------------------------------------------------------------------------------------------- */

/* Welding must not undo a closed manifold: coincident vertices where it touches itself are there on purpose. Where whole triangles
 * of several bodies coincide, two share a wall or are the same twice, and welding shows it. */
static bool welding_helps(const sn_mesh_report *before, const sn_mesh_report *after) {
    bool was_whole = before->closed && before->manifold, is_whole = after->closed && after->manifold;
    bool shares_wall = before->components > 1 && after->duplicate_triangles > before->duplicate_triangles;
    return is_whole || !was_whole || shares_wall;
}

static sn_status weld(sn_cleaning *c) {
    sn_mesh copy;
    sn_index welded = 0;
    sn_status status = sn_mesh_copy(c->mesh, &copy, c->error);
    if (status != SN_OK) return status;
    c->report->weld_tolerance = c->params->weld * c->found.diagonal;
    status = sn_weld(&copy, c->report->weld_tolerance, &welded, NULL, c->error);
    sn_mesh_report after = c->found;
    if (status == SN_OK && welded > 0) status = sn_mesh_inspect(&copy, &after, c->error);
    if (status == SN_OK && welded > 0 && welding_helps(&c->found, &after)) {
        sn_mesh_free(c->mesh);
        *c->mesh = copy;
        copy = (sn_mesh){0};
        c->report->welded += welded;
        c->found = after;
    }
    sn_mesh_free(&copy);
    if (status == SN_OK) status = sn_cleaning_need_triangles(c, "after joining vertices that coincide");
    return status == SN_OK ? sn_stop_if(SN_TRACE(c->trace, "weld", sn_trace_number("welded", c->report->welded))) : status;
}

static sn_status drop_bad(sn_cleaning *c) {
    sn_clean_report *r = c->report;
    sn_status status = SN_OK;
    if (c->found.degenerate_triangles > 0 || c->found.duplicate_triangles > 0 || c->found.unused_vertices > 0) {
        sn_index unused = 0, degenerate = 0, duplicate = 0;
        status = sn_drop_bad_triangles(c->mesh, &degenerate, &duplicate, c->error);
        if (status == SN_OK) status = sn_cleaning_need_triangles(c, "without degenerate ones");
        if (status == SN_OK) status = sn_drop_unused_vertices(c->mesh, &unused, c->error);
        if (status == SN_OK) status = sn_cleaning_look(c);
        r->degenerate += degenerate;
        r->duplicate += duplicate;
        r->unused += unused;
    }
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "drop", sn_trace_number("degenerate", r->degenerate), sn_trace_number("duplicate", r->duplicate),
                               sn_trace_number("unused", r->unused)));
}

static sn_status make_manifold(sn_cleaning *c) {
    if (!c->params->make_manifold) return SN_OK;
    sn_manifold_report done = {.orientable = true};
    sn_status status = SN_OK;
    if (!c->found.manifold || !c->found.oriented) {
        status = sn_make_manifold(c->mesh, &done, c->error);
        if (status == SN_OK) status = sn_cleaning_need_triangles(c, "of the manifold part");
        if (status == SN_OK) status = sn_cleaning_look(c);
    }
    c->report->wall_triangles += done.wall_triangles;
    c->report->flipped_triangles += done.flipped;
    c->report->split_vertices += done.split_vertices;
    c->report->stitched_edges += done.stitched_edges;
    c->report->orientable = c->report->orientable && done.orientable;
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "manifold", sn_trace_number("wall_triangles", done.wall_triangles),
                               sn_trace_number("flipped", done.flipped), sn_trace_number("split_vertices", done.split_vertices),
                               sn_trace_number("stitched_edges", done.stitched_edges)));
}

/* Filling a crack along a straight edge makes triangles without area; dropping them splits their neighbours instead. */
static sn_status fill_holes(sn_cleaning *c) {
    sn_clean_report *r = c->report;
    if (c->params->max_hole == 0) return SN_OK;
    sn_index left = c->found.boundary_edges;
    sn_status status = SN_OK;
    if (left > 0) {
        sn_index filled = 0;
        status = sn_fill_holes(c->mesh, c->params->max_hole, c->trace, &filled, &left, c->error);
        r->holes_filled += filled;
        if (status != SN_OK) return status;
        status = sn_cleaning_look(c);
        sn_index degenerate = 0, duplicate = 0;
        if (status == SN_OK && c->found.degenerate_triangles > 0) {
            status = sn_drop_bad_triangles(c->mesh, &degenerate, &duplicate, c->error);
            if (status == SN_OK) status = sn_cleaning_look(c);
            r->degenerate += degenerate;
            r->duplicate += duplicate;
        }
    }
    if (status != SN_OK) return status;
    return sn_stop_if(
        SN_TRACE(c->trace, "holes", sn_trace_number("filled", r->holes_filled), sn_trace_number("boundary_left", c->found.boundary_edges)));
}

sn_status sn_cleaning_outward(sn_cleaning *c) {
    if (!c->params->outward) return SN_OK;
    sn_status status = SN_OK;
    if (!c->found.outward && c->found.oriented) {
        sn_index flipped = 0;
        status = sn_orient_outward(c->mesh, &flipped, c->error);
        if (status == SN_OK) status = sn_cleaning_look(c);
        c->report->flipped_components += flipped;
    }
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "outward", sn_trace_number("flipped_components", c->report->flipped_components)));
}

/* Borders that were joined the wrong way round may leave a surface with one side. */
static sn_status find_sides(const sn_mesh *mesh, bool *two_sided, sn_error *error) {
    sn_mesh copy;
    sn_manifold_report done = {.orientable = true};
    sn_status status = sn_mesh_copy(mesh, &copy, error);
    if (status == SN_OK) status = sn_make_manifold(&copy, &done, error);
    *two_sided = done.orientable;
    sn_mesh_free(&copy);
    return status;
}

/* Worth having: less border, no edge that carries more triangles than two, and two sides still. */
static sn_status closing_helps(const sn_cleaning *c, const sn_mesh *closed, const sn_mesh_report *after, bool *helps) {
    bool before = true, now = true;
    *helps = after->boundary_edges < c->found.boundary_edges && after->nonmanifold_edges <= c->found.nonmanifold_edges;
    sn_status status = *helps ? find_sides(closed, &now, c->error) : SN_OK;
    if (status == SN_OK && *helps && !now) status = find_sides(c->mesh, &before, c->error);
    *helps = *helps && (now || !before);
    return status;
}

static sn_status try_closing(sn_cleaning *c, sn_crack_report *done) {
    sn_mesh copy;
    sn_mesh_report after = c->found;
    sn_index unused = 0;
    bool helps = false;
    sn_status status = sn_mesh_copy(c->mesh, &copy, c->error);
    if (status == SN_OK) status = sn_close_cracks(&copy, c->params->crack * c->found.diagonal, done, c->error);
    if (status == SN_OK) status = sn_drop_unused_vertices(&copy, &unused, c->error);
    if (status == SN_OK && done->vertices > 0) status = sn_mesh_inspect(&copy, &after, c->error);
    if (status == SN_OK) status = closing_helps(c, &copy, &after, &helps);
    if (status == SN_OK && helps) {
        sn_mesh_free(c->mesh);
        *c->mesh = copy;
        copy = (sn_mesh){0};
        c->found = after;
    } else {
        *done = (sn_crack_report){0};
    }
    sn_mesh_free(&copy);
    return status;
}

static sn_status close_cracks(sn_cleaning *c) {
    if (!c->params->close_cracks) return SN_OK;
    sn_crack_report done = {0};
    sn_status status = c->found.boundary_edges > 0 ? try_closing(c, &done) : SN_OK;
    c->report->crack_vertices += done.vertices;
    c->report->crack_width = fmax(c->report->crack_width, done.widest);
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "cracks", sn_trace_number("vertices", done.vertices), sn_trace_number("widest", done.widest)));
}

/* ---- stages that come once -------------------------------------------------------------------------------------------------- */

static sn_status remove_intersections(sn_cleaning *c) {
    if (!c->params->remove_intersections) return SN_OK;
    sn_index left = 0, before = 0;
    sn_status status = sn_count_self_intersections(c->mesh, &before, c->error);
    if (status == SN_OK)
        status = sn_remove_self_intersections(c->mesh, c->params->seconds, &left, &c->report->intersections_late, c->error);
    if (status == SN_OK && left < before) status = sn_cleaning_look(c);
    if (status == SN_OK && left < before) status = sn_cleaning_outward(c); /* what crosses hides which side is out */
    if (status != SN_OK) return status;
    c->found.self_intersections = left;
    return sn_stop_if(SN_TRACE(c->trace, "intersections", sn_trace_number("before", before), sn_trace_number("left", left)));
}

/* ---- the whole -------------------------------------------------------------------------------------------------------------- */

typedef sn_status (*stage)(sn_cleaning *);

/* Done again while they change something: a body that a cut has made may share a wall with another. */
static const stage repairs[] = {weld, drop_bad, close_cracks, make_manifold, sn_cleaning_keep, fill_holes, sn_cleaning_outward};
static const stage wishes[] = {sn_cleaning_undo_crossings, remove_intersections, sn_cleaning_measure_loss, sn_cleaning_wrap,
                               sn_cleaning_refine};
#define MOST_PASSES 4

static double count_changes(const sn_clean_report *r) {
    double cuts = (double)r->welded + r->degenerate + r->duplicate + r->crack_vertices + r->wall_triangles + r->split_vertices;
    return cuts + r->stitched_edges + r->holes_filled + r->flipped_triangles + r->flipped_components + r->dropped_count;
}

static sn_status run_stages(sn_cleaning *c, const stage *stages, size_t count) {
    sn_status status = SN_OK;
    for (size_t i = 0; status == SN_OK && i < count; i++) status = stages[i](c);
    return status;
}

static sn_status repair(sn_cleaning *c) {
    double before = -1.0;
    sn_status status = SN_OK;
    for (int pass = 0; status == SN_OK && pass < MOST_PASSES && count_changes(c->report) != before; pass++) {
        before = count_changes(c->report);
        status = run_stages(c, repairs, sizeof repairs / sizeof *repairs);
    }
    return status;
}

/* Squares of coordinates must stay within the range of a double. */
#define GREATEST_EXTENT 1e100

static sn_status check_extent(const sn_cleaning *c) {
    double diagonal = c->found.diagonal;
    if (diagonal > 0.0 && diagonal < GREATEST_EXTENT) return SN_OK;
    if (diagonal == 0.0) return sn_fail(c->error, SN_ERROR_INPUT, "all vertices are at one place; there is no surface to clean");
    return sn_fail(c->error, SN_ERROR_INPUT, "the surface is %g wide, more than can be computed with; are its coordinates right?",
                   diagonal);
}

static sn_status prepare(sn_cleaning *c) {
    sn_status status = sn_cleaning_look(c);
    if (status == SN_OK) status = check_extent(c);
    if (status == SN_OK && (c->params->count_intersections || c->params->remove_intersections)) {
        status = sn_count_self_intersections(c->mesh, &c->found.self_intersections, c->error);
    }
    c->report->before = c->found;
    return status;
}

/* The input without vertices that are not finite: they have no distance from anything. */
static sn_status take_finite(const sn_mesh *mesh, const sn_clean_params *params, sn_mesh *finite, sn_index *dropped, sn_error *error) {
    sn_status status = sn_mesh_copy(mesh, finite, error);
    if (status == SN_OK && params->repair_nonfinite)
        status = sn_drop_nonfinite_vertices(finite, dropped, error);
    else if (status == SN_OK)
        status = sn_mesh_validate(mesh, error);
    if (status != SN_OK || finite->triangle_count > 0) return status;
    return sn_fail(error, SN_ERROR_INPUT,
                   mesh->triangle_count == 0 ? "the mesh has no triangles; a surface is needed"
                                             : "every triangle has a coordinate that is not finite");
}

static bool report_input(const sn_cleaning *c) {
    return SN_TRACE(c->trace, "input", sn_trace_number("vertices", c->found.vertices), sn_trace_number("triangles", c->found.triangles),
                    sn_trace_number("nonfinite", c->report->nonfinite_vertices));
}

bool sn_cleaning_is_same(const sn_mesh *a, const sn_mesh *b) {
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           memcmp(a->positions, b->positions, (size_t)a->vertex_count * sizeof *a->positions) == 0 &&
           memcmp(a->triangles, b->triangles, (size_t)a->triangle_count * sizeof *a->triangles) == 0;
}

static sn_status compare(sn_cleaning *c) {
    double lost = 0.0;
    sn_status status = sn_one_sided_distance(c->mesh, c->input, &c->report->moved, c->error);
    if (status == SN_OK) status = sn_one_sided_distance(c->input, c->mesh, &lost, c->error);
    c->report->hausdorff = fmax(c->report->moved, lost);
    return status;
}

/* A stage that was stopped in the middle has not looked at what it did. */
static sn_status conclude(sn_cleaning *c, const sn_mesh *mesh, bool stopped) {
    c->report->unchanged = sn_cleaning_is_same(mesh, c->mesh);
    sn_status status = stopped ? sn_cleaning_look(c) : SN_OK;
    if (status == SN_OK) status = sn_cleaning_report_crossings(c);
    if (status == SN_OK && !c->report->unchanged) status = compare(c);
    c->report->after = c->found;
    c->report->flat = sn_cleaning_is_flat(&c->found);
    return status;
}

sn_status sn_clean(const sn_mesh *mesh, const sn_clean_params *params, sn_trace *trace, sn_mesh *out, sn_clean_report *report,
                   sn_error *error) {
    *report = (sn_clean_report){.orientable = true};
    *out = (sn_mesh){0};
    sn_mesh finite = {0};
    sn_cleaning c = {.params = params, .trace = trace, .input = &finite, .mesh = out, .report = report, .error = error};
    sn_status status = take_finite(mesh, params, &finite, &report->nonfinite_vertices, error);
    if (status == SN_OK) status = sn_mesh_copy(&finite, out, error);
    if (status == SN_OK) status = prepare(&c);
    bool ready = status == SN_OK;
    if (ready && sn_trace_stopped(trace)) status = SN_STOPPED;
    if (status == SN_OK) status = sn_stop_if(report_input(&c));
    if (status == SN_OK) status = repair(&c);
    if (status == SN_OK) status = run_stages(&c, wishes, sizeof wishes / sizeof *wishes);
    if (status == SN_OK || status == SN_STOPPED) {
        sn_status concluded = conclude(&c, mesh, status == SN_STOPPED);
        if (concluded != SN_OK) status = concluded;
    }
    sn_mesh_free(&finite);
    if (status == SN_OK || status == SN_STOPPED) return status;
    sn_mesh_free(out);
    sn_clean_report_free(report);
    return status;
}
