/*
 * attach_run.c -- tendons that run along a bone: an attachment lies where a tendon ends, not along it.
 *
 * A tendon is what lies at a tip of the muscle and is thin. A patch that follows it for several times the tendon's own girth is a bed that
 * it slides in: the groove of the long head of biceps, the radius under the radial extensors.
 */
#include "attach_detection.h"

#include <stdlib.h>

/* A tendon reaches from a tip to where the muscle is this share as thick as its belly. A patch runs along it where the patch, as far as it
 * is on the tendon, is RUN times as long as the tendon's girth, and LEAST_RUN of the muscle's length. Of 148 muscles
 * of a man seven have such a bed: biceps' long heads, radial extensors and an ulnar head of flexor carpi ulnaris. On the dog four pairs go
 * by this, of which two are attachments: peroneus longus, thin as it is on the fibula. */
static const double THIN = 0.3, RUN = 3.0, LEAST_RUN = 0.08;
/* At the tip: as far from it as this share of the length. */
static const double AT_TIP = 0.05;
/* What the patch holds off the tendon goes with it where it is a smaller share of the patch than this. */
static const double REST = 0.5;

/* A piece of what one bone holds, and how far along from one tip it is. */
typedef struct run {
    sn_index number; /* among the pieces of the bone */
    int end;
    double tendon;    /* how far from the tip the tendon reaches, share of the length */
    double low, high; /* of what is on the tendon, shares of the length from the tip */
    double on, all;   /* areas: on the tendon, and of the piece */
    double girth;     /* of the tendon there, document units */
} run;

/* Share of the length from the tip to the first slice that is not thin. */
static double tendon_length(const girth_profile *p, int end) {
    int slices = 0;
    while (slices < GIRTH_SLICES && p->girth[end == 0 ? slices : GIRTH_SLICES - 1 - slices] < THIN) slices++;
    return (double)slices / GIRTH_SLICES;
}

/* The mean girth of the muscle between two shares of its length from a tip, document units. */
static double mean_girth(const detection *d, const girth_profile *p, const run *r) {
    int first = (int)(r->low * GIRTH_SLICES), last = (int)fmin(r->high * GIRTH_SLICES, GIRTH_SLICES - 1);
    double sum = 0.0;
    for (int i = first; i <= last; i++) sum += p->girth[r->end == 0 ? i : GIRTH_SLICES - 1 - i];
    return sum / (last - first + 1) * p->largest * GIRTH_SLICES / 6.0 / d->length;
}

/* Measures a piece; false where it does not run along the tendon of that end, or the user gave a part of it. */
static bool runs_along(const detection *d, const girth_profile *p, const sn_index *number, run *r) {
    r->low = INFINITY;
    r->high = -INFINITY;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (number[v] != r->number) continue;
        double at = attach_from_tip(d, r->end, v);
        if (attach_is_given(d, v)) return false;
        r->all += d->vertex_area[v];
        if (!(at <= r->tendon)) continue;
        r->on += d->vertex_area[v];
        r->low = fmin(r->low, at);
        r->high = fmax(r->high, at);
    }
    if (!(r->high - r->low >= LEAST_RUN)) return false;
    r->girth = mean_girth(d, p, r);
    return (r->high - r->low) * d->length >= RUN * r->girth;
}

/* Does another bone hold the muscle nearer to the tip, or at it? */
static bool is_held_beyond(const detection *d, sn_index bone, const run *r) {
    double limit = fmax(r->low, AT_TIP);
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (d->holder_of[v] != SN_NONE && d->holder_of[v] != bone && attach_from_tip(d, r->end, v) < limit) return true;
    return false;
}

/* Lets go of the piece from `keep` of the length from the tip on; what goes is of no piece any more. */
static void let_go(detection *d, const run *r, sn_index *number, double keep, sn_attach_pair *pair) {
    bool whole = r->on >= REST * r->all;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        double at = number[v] == r->number ? attach_from_tip(d, r->end, v) : NAN;
        if (!(at > keep && (whole || at <= r->tendon))) continue;
        attach_let_slide(d, v, pair);
        number[v] = SN_NONE;
    }
}

/* The end of the tendon: what another bone holds; or a bone takes that the tendon runs on to; or as much of the bed as is as long as it is
 * wide. */
static sn_status end_run(detection *d, const run *r, sn_index *number, sn_attach_pair *pair, sn_error *error) {
    bool both = d->params->methods == (SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY);
    sn_index next = SN_NONE;
    sn_status status = SN_OK;
    bool beyond = is_held_beyond(d, pair->bone, r);
    if (!beyond && both) status = attach_next_bone(d, pair->bone, r->end, &next, error);
    if (status != SN_OK) return status;
    bool ends_here = !beyond && next == SN_NONE;
    let_go(d, r, number, ends_here ? r->low + r->girth / d->length : -1.0, pair);
    return next != SN_NONE ? attach_take_tip(d, next, r->end, error) : SN_OK;
}

/* Where other bones hold the muscle along it: low and high. */
static void find_others(const detection *d, sn_index bone, double range[2]) {
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (d->holder_of[v] == SN_NONE || d->holder_of[v] == bone || isnan(d->along[v])) continue;
        range[0] = fmin(range[0], d->along[v]);
        range[1] = fmax(range[1], d->along[v]);
    }
}

/* What else a bone holds that the tendon runs along, between what others hold, goes too where it is less than what slides, or fibres pass.
 */
static void let_rest_go(detection *d, sn_attach_pair *pair) {
    double range[2], area = 0.0, low = INFINITY, high = -INFINITY;
    find_others(d, pair->bone, range);
    sn_index count = attach_held(d, pair->bone, d->list);
    for (sn_index i = 0; i < count; i++) {
        sn_index v = d->list[i];
        if (!(d->along[v] > range[0] && d->along[v] < range[1]) || attach_is_given(d, v)) return;
        area += d->vertex_area[v];
        low = fmin(low, d->along[v]);
        high = fmax(high, d->along[v]);
    }
    if (area >= pair->slid.area && !attach_fibers_pass(d, low, high)) return;
    for (sn_index i = 0; i < count; i++) attach_let_slide(d, d->list[i], pair);
}

static sn_status judge_bone(detection *d, const girth_profile *p, sn_attach_pair *pair, sn_error *error) {
    sn_index count = 0, *number = SN_NEW(sn_index, d->muscle->mesh.vertex_count);
    sn_status status = number != NULL ? attach_pieces(d, pair->bone, number, &count, error) : sn_fail_memory(error, "attachments");
    double slid = pair->slid.area;
    for (sn_index i = 0; i < 2 * count && status == SN_OK; i++) {
        run r = {.number = i / 2, .end = i % 2};
        r.tendon = tendon_length(p, r.end);
        if (runs_along(d, p, number, &r)) status = end_run(d, &r, number, pair, error);
    }
    if (status == SN_OK && pair->slid.area > slid) let_rest_go(d, pair);
    free(number);
    return status;
}

sn_status attach_let_runs_go(detection *d, sn_error *error) {
    girth_profile p;
    sn_status status = SN_OK;
    if (!(d->length > 0.0)) return SN_OK;
    attach_measure_girth(d, &p);
    for (sn_index i = 0; i < d->report->pair_count && status == SN_OK; i++) {
        sn_attach_pair *pair = &d->report->pairs[i];
        if (!pair->tip && attach_holds_by_distance(d, pair->bone) && attach_holds_any(d, pair->bone))
            status = judge_bone(d, &p, pair, error);
    }
    return status;
}
