/*
 * attach_slide.c -- tendons that slide: an attachment lies where a muscle ends, not where it passes.
 */
#include "attach_detection.h"
#include "tips.h"

#include <stdlib.h>

enum { SLICES = GIRTH_SLICES };

/* A fibre that ends within this share of the length of a patch ends at it. */
static const double FIBER_MARGIN = 0.02;

/* ---- the muscle from tip to tip ----------------------------------------------------------------------------------------- */

/* How far along the vertex nearest to a point is. */
static double along_at(const detection *d, sn_vec3 point) {
    const sn_mesh *mesh = &d->muscle->mesh;
    sn_index best = SN_NONE;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        if (isnan(d->along[v])) continue;
        if (best == SN_NONE || sn_distance(mesh->positions[v], point) < sn_distance(mesh->positions[best], point)) best = v;
    }
    return best == SN_NONE ? NAN : d->along[best];
}

static sn_status place_fibers(detection *d, sn_error *error) {
    const sn_fibers *f = &d->muscle->fibers;
    if (f->polyline_count == 0) return SN_OK;
    if ((d->fiber_ends = SN_NEW(double, 2 * (size_t)f->polyline_count)) == NULL) return sn_fail_memory(error, "the ends of the fibres");
    for (sn_index i = 0; i < f->polyline_count; i++) {
        const sn_polyline *line = &f->polylines[i];
        d->fiber_ends[2 * i] = line->count > 0 ? along_at(d, line->points[0]) : NAN;
        d->fiber_ends[2 * i + 1] = line->count > 0 ? along_at(d, line->points[line->count - 1]) : NAN;
    }
    return SN_OK;
}

bool attach_fibers_pass(const detection *d, double low, double high) {
    bool before = false, behind = false;
    for (sn_index i = 0; d->fiber_ends != NULL && i < 2 * d->muscle->fibers.polyline_count; i++) {
        double at = d->fiber_ends[i];
        if (at >= low - FIBER_MARGIN && at <= high + FIBER_MARGIN) return false;
        before = before || at < low;
        behind = behind || at > high;
    }
    return before && behind;
}

sn_status attach_find_along(detection *d, sn_error *error) {
    const sn_mesh *mesh = &d->muscle->mesh;
    surface_survey survey;
    tips ends;
    double *other = SN_NEW(double, mesh->vertex_count);
    sn_status status = other != NULL ? survey_surface(mesh, &d->topology, &survey, error) : sn_fail_memory(error, "attachments");
    if (status == SN_OK) status = find_tips(mesh, &d->topology, survey.main_vertex, NULL, &ends, error);
    if (status == SN_OK) status = sn_edge_distance(mesh, &d->topology, 1, &ends.end[0], d->along, error);
    if (status == SN_OK) status = sn_edge_distance(mesh, &d->topology, 1, &ends.end[1], other, error);
    if (status == SN_OK) {
        for (int k = 0; k < 2; k++) d->tip[k] = ends.end[k];
        d->length = ends.length;
        for (sn_index v = 0; v < mesh->vertex_count; v++) d->along[v] = d->along[v] / (d->along[v] + other[v]);
    }
    free(other);
    return status == SN_OK ? place_fibers(d, error) : status;
}

static int slice_of(double along) { return (int)fmin(along * SLICES, SLICES - 1); }

void attach_measure_girth(const detection *d, girth_profile *p) {
    const sn_mesh *mesh = &d->muscle->mesh;
    *p = (girth_profile){.largest = 0.0};
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double area = sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
        for (int k = 0; k < 3; k++)
            if (!isnan(d->along[v[k]])) p->girth[slice_of(d->along[v[k]])] += area;
    }
    for (int i = 0; i < SLICES; i++) p->largest = fmax(p->largest, p->girth[i]);
    for (int i = 0; i < SLICES && p->largest > 0.0; i++) p->girth[i] /= p->largest;
}

static void place_pair(const detection *d, const girth_profile *p, sn_attach_pair *pair) {
    double position = 0.0, girth = 0.0;
    sn_index count = attach_held(d, pair->bone, d->list), placed = 0;
    for (sn_index i = 0; i < count; i++) {
        double along = d->along[d->list[i]];
        if (isnan(along)) continue;
        position += along;
        girth += p->girth[slice_of(along)];
        placed++;
    }
    if (placed == 0) return;
    pair->position = position / placed;
    pair->girth = girth / placed;
}

static bool was_given(const detection *d, sn_index bone) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (d->holder_of[v] == bone && attach_is_given(d, v)) return true;
    return false;
}

/* Whole pairs, for those who keep what slides: less than a fifth as thick as the belly, with bones that hold nearer to both tips. */
static bool looks_sliding(const detection *d, const sn_attach_pair *pair) {
    bool before = false, behind = false;
    for (sn_index p = 0; p < d->report->pair_count; p++) {
        before = before || d->report->pairs[p].position < pair->position - 0.05;
        behind = behind || d->report->pairs[p].position > pair->position + 0.05;
    }
    return pair->girth < 0.2 && before && behind && !was_given(d, pair->bone);
}

/* ---- piece by piece ---------------------------------------------------------------------------------------------------- */

/* A piece slides where what it lies on is less than this share as thick as the muscle's belly, and the muscle is held by more than
 * BEYOND of the length nearer to both tips. On the dog 18 of the 22 pairs that go by this are no attachments, where one of five is in all;
 * at a fifth it is 20 of 37. */
static const double TENDON_GIRTH = 0.15, BEYOND = 0.05;
/* The same where the document has fibres, and they pass the piece and end on both sides of it. */
static const double PASSED_GIRTH = 0.3;
/* The thickness at a piece is that of the surface joined to it within this share of the length beyond its ends. */
static const double BAND_MARGIN = 0.02;

typedef struct piece {
    sn_index bone, number;    /* the latter among those of the bone */
    double low, high, middle; /* along the muscle; the middle weighs by area */
    double area;
} piece;

typedef struct piece_list {
    size_t count, capacity;
    piece *items;
} piece_list;

static void place_piece(const detection *d, const sn_index *number, piece *p) {
    p->low = INFINITY;
    p->high = -INFINITY;
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++) {
        if (number[v] != p->number || isnan(d->along[v])) continue;
        p->area += d->vertex_area[v];
        p->middle += d->along[v] * d->vertex_area[v];
        p->low = fmin(p->low, d->along[v]);
        p->high = fmax(p->high, d->along[v]);
    }
    p->middle = p->area > 0.0 ? p->middle / p->area : NAN; /* of another component: before and behind nothing */
}

static sn_status list_pieces(const detection *d, sn_index bone, sn_index *number, piece_list *list, sn_error *error) {
    sn_index count = 0;
    sn_status status = attach_pieces(d, bone, number, &count, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        if (!sn_grow((void **)&list->items, &list->capacity, list->count + 1, sizeof *list->items))
            return sn_fail_memory(error, "attachments");
        list->items[list->count] = (piece){.bone = bone, .number = i};
        place_piece(d, number, &list->items[list->count++]);
    }
    return status;
}

/* Area by length of the surface around a piece, relative to that of the thickest twentieth of the muscle. */
static sn_status girth_at(const detection *d, const piece *p, const sn_index *number, double largest, double *girth, sn_error *error) {
    const sn_topology *t = &d->topology;
    sn_index *stack = SN_NEW(sn_index, t->vertex_count), height = 0;
    bool *seen = SN_NEW(bool, t->vertex_count);
    double area = 0.0, low = fmax(p->low - BAND_MARGIN, 0.0), high = fmin(p->high + BAND_MARGIN, 1.0);
    sn_status status = stack != NULL && seen != NULL ? SN_OK : sn_fail_memory(error, "attachments");
    for (sn_index v = 0; v < t->vertex_count && status == SN_OK; v++) {
        if (number[v] != p->number) continue;
        seen[v] = true;
        stack[height++] = v;
    }
    while (height > 0) {
        sn_index v = stack[--height];
        area += d->vertex_area[v];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (seen[w] || !(d->along[w] >= low && d->along[w] <= high)) continue;
            seen[w] = true;
            stack[height++] = w;
        }
    }
    free(stack);
    free(seen);
    *girth = largest > 0.0 ? 6.0 * area / ((high - low) * SLICES) / largest : NAN; /* `largest` counts each triangle's double area thrice */
    return status;
}

/* What is held nearer to both tips need not be of other bones, but one side is: a bone that is passed may hold the end as well. */
static bool is_passed(const piece_list *list, const piece *p) {
    bool before = false, behind = false, other = false;
    for (size_t i = 0; i < list->count; i++) {
        bool is_before = list->items[i].middle<p->middle - BEYOND, is_behind = list->items[i].middle> p->middle + BEYOND;
        before = before || is_before;
        behind = behind || is_behind;
        other = other || ((is_before || is_behind) && list->items[i].bone != p->bone);
    }
    return before && behind && other;
}

void attach_let_slide(detection *d, sn_index v, sn_attach_pair *pair) {
    pair->sliding = true;
    pair->slid.vertices++;
    pair->slid.area += d->vertex_area[v];
    d->holder_of[v] = SN_NONE;
    d->reason[v] = 0;
    d->distance[v] = NAN;
    d->runner_up[v] = INFINITY;
}

static void let_go(detection *d, const piece *p, const sn_index *number, sn_attach_pair *pair) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (number[v] == p->number) attach_let_slide(d, v, pair);
}

static bool any_given(const detection *d, const piece *p, const sn_index *number) {
    for (sn_index v = 0; v < d->muscle->mesh.vertex_count; v++)
        if (number[v] == p->number && attach_is_given(d, v)) return true;
    return false;
}

/* Of one bone, the pieces that slide; the list is of all bones' pieces as they were before. */
static sn_status let_go_of(detection *d, const piece_list *list, double largest, sn_attach_pair *pair, sn_error *error) {
    sn_index count = 0, *number = SN_NEW(sn_index, d->muscle->mesh.vertex_count);
    sn_status status = number != NULL ? attach_pieces(d, pair->bone, number, &count, error) : sn_fail_memory(error, "attachments");
    for (size_t i = 0; i < list->count && status == SN_OK; i++) {
        const piece *p = &list->items[i];
        double girth = NAN;
        if (p->bone != pair->bone || !is_passed(list, p) || any_given(d, p, number)) continue;
        status = girth_at(d, p, number, largest, &girth, error);
        double limit = attach_fibers_pass(d, p->low, p->high) ? PASSED_GIRTH : TENDON_GIRTH;
        if (status == SN_OK && girth < limit) let_go(d, p, number, pair);
    }
    free(number);
    return status;
}

static sn_status let_pieces_go(detection *d, double largest, sn_error *error) {
    piece_list list = {0};
    sn_index *number = SN_NEW(sn_index, d->muscle->mesh.vertex_count);
    sn_status status = number != NULL ? SN_OK : sn_fail_memory(error, "attachments");
    for (sn_index h = 0; h < d->holder_count && status == SN_OK; h++) status = list_pieces(d, h, number, &list, error);
    for (sn_index i = 0; i < d->report->pair_count && status == SN_OK; i++) {
        sn_attach_pair *pair = &d->report->pairs[i];
        if (attach_holds_by_distance(d, pair->bone) && attach_holds_any(d, pair->bone)) status = let_go_of(d, &list, largest, pair, error);
    }
    free(list.items);
    free(number);
    return status;
}

sn_status attach_find_sliding(detection *d, bool lets_go, sn_error *error) {
    sn_attach_report *r = d->report;
    girth_profile p;
    if (!(d->length > 0.0)) return SN_OK;
    attach_measure_girth(d, &p);
    for (sn_index i = 0; i < r->pair_count; i++) place_pair(d, &p, &r->pairs[i]);
    if (lets_go) return let_pieces_go(d, p.largest, error);
    for (sn_index i = 0; i < r->pair_count; i++) r->pairs[i].sliding = looks_sliding(d, &r->pairs[i]);
    return SN_OK;
}
