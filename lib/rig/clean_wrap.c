/*
 * clean_wrap.c -- how much of a surface its repair has lost, and a wrap around it where that is too much.
 */
#include "cleaning.h"

#include <string.h>

/* What a wrap asks for where the user does not: its offset as a share of the diagonal. */
#define USUAL_OFFSET 0.002
/* Holes of up to ten offsets are bridged. */
#define ALPHA_OFFSETS 5.0
#define MOST_WIDENINGS 3

/* Nothing is lost where nothing was taken away. */
static bool takes_away(const sn_clean_report *r) {
    return r->dropped_count > 0 || r->wall_triangles > 0 || r->duplicate > 0 || r->degenerate > 0 || r->undone_crossings > 0 || r->wrapped;
}

sn_status sn_cleaning_measure_loss(sn_cleaning *c) {
    sn_clean_report *r = c->report;
    sn_status status = SN_OK;
    r->lost_area = 0.0;
    if (takes_away(r)) status = sn_lost_area(c->input, c->mesh, SN_LOST_REACH * r->before.diagonal, &r->lost_area, c->error);
    r->lost_share = r->before.area > 0.0 ? r->lost_area / r->before.area : 0.0;
    return status;
}

/* ---- wrap --------------------------------------------------------------------------------------------------------------- */

static bool is_whole(const sn_mesh_report *found) { return found->closed && found->manifold && found->oriented; }

/* Is the surface as it is now less than what was asked for? */
static bool falls_short(const sn_cleaning *c) {
    bool crossed = sn_cleaning_has_more_crossings(c) || (c->params->remove_intersections && c->found.self_intersections > 0);
    bool whole = is_whole(&c->found) && c->report->orientable && !sn_cleaning_is_flat(&c->found) && !crossed;
    return !whole || c->report->lost_share > c->params->most_lost;
}

/* The triangles of both, without what the library does not expect. */
static sn_status join_soups(const sn_mesh *a, const sn_mesh *b, sn_mesh *out, sn_error *error) {
    if (a->vertex_count > SN_INDEX_MAX - b->vertex_count || a->triangle_count > SN_INDEX_MAX / 3 - b->triangle_count) {
        return sn_fail(error, SN_ERROR_INPUT, "the surface is too large to be wrapped");
    }
    sn_status status = sn_mesh_alloc(out, a->vertex_count + b->vertex_count, a->triangle_count + b->triangle_count, error);
    if (status != SN_OK) return status;
    memcpy(out->positions, a->positions, (size_t)a->vertex_count * sizeof *a->positions);
    memcpy(out->positions + a->vertex_count, b->positions, (size_t)b->vertex_count * sizeof *b->positions);
    memcpy(out->triangles, a->triangles, (size_t)a->triangle_count * sizeof *a->triangles);
    for (sn_index t = 0; t < b->triangle_count; t++) {
        for (int k = 0; k < 3; k++) out->triangles[a->triangle_count + t].v[k] = b->triangles[t].v[k] + a->vertex_count;
    }
    sn_index degenerate = 0, duplicate = 0;
    return sn_drop_bad_triangles(out, &degenerate, &duplicate, error);
}

/* What there was, and what exact repair makes of all of it: a wrap around the two reaches no open inside. A surface with one side has no
 * inside: it is cut and filled to no purpose, and wrapped as it is. */
static sn_status gather_soup(sn_cleaning *c, sn_mesh *soup) {
    sn_clean_params all = *c->params;
    all.keep = 0;
    all.full = all.watch_crossings = all.remove_intersections = all.count_intersections = all.flip_slivers = false;
    all.wrap = all.edge_length = 0.0;
    all.triangles = all.smooth = 0;
    sn_mesh repaired = {0};
    sn_clean_report ignored = {0};
    sn_status status = sn_clean(c->input, &all, NULL, &repaired, &ignored, c->error);
    if (status == SN_OK && !ignored.orientable) repaired.vertex_count = repaired.triangle_count = 0;
    if (status == SN_OK) status = join_soups(&repaired, c->input, soup, c->error);
    sn_clean_report_free(&ignored);
    sn_mesh_free(&repaired);
    return status;
}

/* Do to the wrap what was done to the surface: `w` is the cleaning with the wrap in the surface's place. */
static sn_status finish_wrap(sn_cleaning *w) {
    w->report->wrapped = w->report->orientable = true;
    sn_status status = sn_cleaning_look(w);
    if (status == SN_OK) status = sn_cleaning_keep(w);
    if (status == SN_OK) status = sn_cleaning_outward(w);
    if (status == SN_OK) status = sn_cleaning_measure_loss(w);
    if (status == SN_OK && w->report->before.self_intersections >= 0) status = sn_cleaning_count_crossings(w);
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(w->trace, "wrap", sn_trace_number("offset", w->report->wrap_offset),
                               sn_trace_number("alpha", w->report->wrap_alpha), sn_trace_number("lost", w->report->lost_share)));
}

/* A wrap that no one has asked for must be whole where the surface was not, or lose clearly less of it. */
static bool is_better(const sn_cleaning *w, const sn_cleaning *than) {
    bool whole = is_whole(&w->found), was_whole = is_whole(&than->found) && than->report->orientable && !sn_cleaning_is_flat(&than->found);
    return !falls_short(w) || (whole && (!was_whole || w->report->lost_share < 0.9 * than->report->lost_share));
}

static void take(sn_cleaning *c, sn_cleaning *w) {
    sn_mesh_free(c->mesh);
    *c->mesh = *w->mesh;
    *w->mesh = (sn_mesh){0};
    sn_clean_report_free(c->report);
    *c->report = *w->report;
    *w->report = (sn_clean_report){0};
    c->found = w->found;
}

static sn_status wrap(sn_cleaning *c, const sn_mesh *soup, double share) {
    sn_mesh around = {0};
    sn_clean_report report = *c->report;
    report.dropped = NULL;
    report.dropped_count = 0;
    report.wrap_offset = share * report.before.diagonal;
    report.wrap_alpha = ALPHA_OFFSETS * report.wrap_offset;
    sn_cleaning w = *c;
    w.mesh = &around;
    w.report = &report;
    sn_status status = sn_wrap(soup, report.wrap_alpha, report.wrap_offset, &around, c->error);
    if (status == SN_OK) status = sn_carry_attributes(c->input, &around, c->error);
    if (status == SN_OK) status = finish_wrap(&w);
    bool stopped = status == SN_STOPPED;
    if ((status == SN_OK || stopped) && (c->params->wrap > 0.0 || is_better(&w, c))) take(c, &w);
    sn_clean_report_free(&report);
    sn_mesh_free(&around);
    return status;
}

/* Pieces too far from one another for the usual offset are joined by a wider one. */
static sn_status wrap_wider_and_wider(sn_cleaning *c, const sn_mesh *soup) {
    sn_status status = SN_OK;
    for (int i = 0; status == SN_OK && i < MOST_WIDENINGS && falls_short(c); i++) status = wrap(c, soup, USUAL_OFFSET * (double)(1 << i));
    return status;
}

sn_status sn_cleaning_wrap(sn_cleaning *c) {
    bool asked = c->params->wrap > 0.0;
    if (!asked && !(c->params->full && falls_short(c))) return SN_OK;
    sn_mesh soup = {0};
    sn_status status = gather_soup(c, &soup);
    if (status == SN_OK) status = asked ? wrap(c, &soup, c->params->wrap) : wrap_wider_and_wider(c, &soup);
    sn_mesh_free(&soup);
    return status;
}
