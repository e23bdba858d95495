/*
 * clean_refine.c -- what is done to a sound surface on request: remeshing, decimation, smoothing, flips. All keep the volume.
 */
#include "cleaning.h"

static bool is_sound(const sn_mesh_report *found) { return found->manifold && found->oriented; }

static sn_status need_sound(const sn_cleaning *c, const char *what) {
    if (is_sound(&c->found)) return SN_OK;
    return sn_fail(c->error, SN_ERROR_INPUT, "only an oriented manifold can be %s; leave out --no-manifold, or %s", what,
                   what[0] == 'd' ? "--triangles" : "--edge-length");
}

/* Put the volume back that a step has taken, and look. */
static sn_status settle(sn_cleaning *c, double volume) {
    sn_status status = c->found.closed ? sn_restore_volume(c->mesh, volume, c->error) : SN_OK;
    if (status == SN_OK) status = sn_cleaning_look(c);
    return status;
}

static sn_status remesh(sn_cleaning *c, double volume) {
    if (c->params->edge_length <= 0.0) return SN_OK;
    sn_index before = c->mesh->triangle_count;
    sn_status status = need_sound(c, "remeshed");
    if (status == SN_OK) status = sn_remesh(c->mesh, c->params->edge_length, c->error);
    if (status == SN_OK) status = settle(c, volume);
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "remesh", sn_trace_number("before", before), sn_trace_number("after", c->mesh->triangle_count),
                               sn_trace_number("volume", c->found.volume)));
}

static sn_status decimate(sn_cleaning *c, double volume) {
    if (c->params->triangles == 0) return SN_OK;
    sn_index before = c->mesh->triangle_count;
    sn_status status = SN_OK;
    if (before > c->params->triangles) {
        status = need_sound(c, "decimated");
        if (status == SN_OK) status = sn_decimate(c->mesh, c->params->triangles, c->error);
        if (status == SN_OK) status = settle(c, volume);
    }
    c->report->decimated_triangles = before - c->mesh->triangle_count;
    if (status != SN_OK) return status;
    return sn_stop_if(SN_TRACE(c->trace, "decimate", sn_trace_number("before", before), sn_trace_number("after", c->mesh->triangle_count),
                               sn_trace_number("volume", c->found.volume)));
}

static sn_status smooth(sn_cleaning *c, double volume) {
    if (c->params->smooth == 0) return SN_OK;
    sn_status status = sn_smooth(c->mesh, c->params->smooth, c->error);
    if (status == SN_OK) status = settle(c, volume);
    if (status != SN_OK) return status;
    return sn_stop_if(
        SN_TRACE(c->trace, "smooth", sn_trace_number("rounds", c->params->smooth), sn_trace_number("volume", c->found.volume)));
}

/* Flips between triangles that are nearly coplanar: the volume needs no putting back. */
static sn_status flip_slivers(sn_cleaning *c, double volume) {
    (void)volume;
    if (!c->params->flip_slivers || !is_sound(&c->found)) return SN_OK;
    sn_index before = c->found.sliver_triangles;
    sn_status status = sn_flip_slivers(c->mesh, &c->report->flipped_slivers, c->error);
    if (status == SN_OK && c->report->flipped_slivers > 0) status = sn_cleaning_look(c);
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
