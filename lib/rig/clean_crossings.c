/*
 * clean_crossings.c -- no more crossings than there were: counted where repair has made triangles, and taken back.
 */
#include "cleaning.h"

#include <stdlib.h>

/* Pairs of boxes that meet, in all and for each triangle: a surface has about twenty for each, a heap of triangles at one place half as
 * many as there are triangles, and nobody waits for those (three million take seconds). */
#define MOST_TESTS 3000000
#define MOST_TESTS_EACH 100
/* Share of the area that may be cut out, whatever may be lost otherwise. */
#define MOST_CUT 0.05

/* -1 = not counted. */
static sn_status count_crossings(const sn_cleaning *c, const sn_mesh *mesh, sn_index *pairs) {
    bool asked = c->params->count_intersections || c->params->remove_intersections;
    int64_t most = MOST_TESTS + (int64_t)MOST_TESTS_EACH * mesh->triangle_count;
    return sn_find_self_intersections(mesh, asked ? 0 : most, NULL, NULL, pairs, c->error);
}

sn_status sn_cleaning_count_crossings(sn_cleaning *c) {
    if (c->found.self_intersections >= 0) return SN_OK;
    return count_crossings(c, c->mesh, &c->found.self_intersections);
}

static sn_status count_input(sn_cleaning *c) {
    if (c->report->before.self_intersections >= 0) return SN_OK;
    return count_crossings(c, c->input, &c->report->before.self_intersections);
}

bool sn_cleaning_has_more_crossings(const sn_cleaning *c) {
    sn_index before = c->report->before.self_intersections, now = c->found.self_intersections;
    return before >= 0 && now > before;
}

/* Triangles of the input have no crossings but those that they had, wherever vertices were joined or cut. */
static sn_status find_made(const sn_cleaning *c, bool *some, sn_error *error) {
    bool *is_new = SN_NEW(bool, c->mesh->triangle_count);
    sn_status status =
        is_new != NULL ? sn_find_new_triangles(c->input, c->mesh, is_new, error) : sn_fail_memory(error, "comparing surfaces");
    *some = false;
    for (sn_index t = 0; status == SN_OK && t < c->mesh->triangle_count; t++) *some = *some || is_new[t];
    free(is_new);
    return status;
}

static sn_status undo(sn_cleaning *c) {
    sn_index made = c->found.self_intersections, left = made;
    sn_undo_params params = {c->input, fmin(c->params->most_lost, MOST_CUT) * c->report->before.area,
                             SN_LOST_REACH * c->report->before.diagonal};
    sn_status status = sn_undo_crossings(c->mesh, &params, &left, c->error);
    if (status == SN_OK && left < made) status = sn_cleaning_look(c);
    if (status != SN_OK) return status;
    c->found.self_intersections = left;
    c->report->undone_crossings += made - left;
    return sn_stop_if(SN_TRACE(c->trace, "uncross", sn_trace_number("before", c->report->before.self_intersections),
                               sn_trace_number("made", made), sn_trace_number("left", left)));
}

sn_status sn_cleaning_undo_crossings(sn_cleaning *c) {
    bool some = false;
    if (!c->params->watch_crossings || sn_cleaning_is_same(c->input, c->mesh)) return SN_OK;
    sn_status status = find_made(c, &some, c->error);
    if (status != SN_OK || !some) return status;
    status = count_input(c);
    if (status == SN_OK && c->report->before.self_intersections >= 0) status = sn_cleaning_count_crossings(c);
    return status == SN_OK && sn_cleaning_has_more_crossings(c) ? undo(c) : status;
}

sn_status sn_cleaning_report_crossings(sn_cleaning *c) {
    sn_clean_report *r = c->report;
    bool some = false;
    if (r->unchanged) {
        c->found.self_intersections = r->before.self_intersections;
        return SN_OK;
    }
    sn_status status = c->params->watch_crossings ? find_made(c, &some, c->error) : SN_OK;
    if (status == SN_OK && some) status = count_input(c);
    if (status == SN_OK && r->before.self_intersections >= 0) status = sn_cleaning_count_crossings(c);
    r->crossings_uncounted = some && (r->before.self_intersections < 0 || c->found.self_intersections < 0);
    r->crossings_made = sn_cleaning_has_more_crossings(c) ? c->found.self_intersections - r->before.self_intersections : 0;
    return status;
}
