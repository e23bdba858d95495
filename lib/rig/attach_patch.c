/*
 * attach_patch.c -- attachment areas instead of speckles: what a bone holds by distance becomes compact patches.
 *
 * Contact of two surfaces that were made apart is speckled. For each bone, in order: gaps narrower than twice the closing distance are
 * closed along the surface (dilate, erode), holes are filled, crumbs are dropped, the border is smoothed by its vertices' neighbours.
 * Only free vertices are taken; vertices that the user gave, and those of other bones, stay.
 */
#include "attach_detection.h"

#include <stdlib.h>
#include <string.h>

/* Gaps are closed over so many mean edges, or this share of the muscle's length where that is more. */
static const double CLOSING_EDGES = 1.5, CLOSING_SHARE = 0.005;
/* A hole is smaller than this share of what the bone holds. */
static const double HOLE_SHARE = 0.5;
/* A crumb is smaller than the former share of what the bone holds; all crumbs together are at most the latter. */
static const double CRUMB_SHARE = 0.05, CRUMBS_SHARE = 0.2;
/* A vertex whose neighbourhood is held by less than the former share goes, one by more than the latter comes. */
static const double LEAVE_SHARE = 0.4, JOIN_SHARE = 0.6;
/* A round of smoothing leaves at least so much of the area, or takes none away. */
static const double KEPT_SHARE = 0.95;
enum { SMOOTHING_ROUNDS = 3, SMALL_PIECE = 6 };

/* One bone's patch under work. */
typedef struct patch {
    detection *d;
    sn_index bone;
    bool *inside;         /* (vertices) */
    sn_index *piece;      /* (vertices) of the set that was walked last */
    sn_index *stack;      /* (vertices) */
    double *piece_area;   /* (vertices) by piece */
    sn_index *piece_size; /* (vertices) by piece */
    double *near, *far;   /* (vertices) distances */
    bool *next;           /* (vertices) */
    double *gap;          /* (vertices) signed distance to the bone; NaN = not asked for yet */
    sn_vec3 *normals;     /* (vertices) of the muscle */
    sn_surface *surface;  /* of the bone */
    double reach;         /* gaps are closed over this; a vertex that joins at the border is no farther from the bone */
} patch;

static sn_index vertices_of(const patch *p) { return p->d->muscle->mesh.vertex_count; }

static sn_status open_patch(detection *d, patch *p, sn_error *error) {
    sn_index n = d->muscle->mesh.vertex_count;
    *p = (patch){.d = d,
                 .inside = SN_NEW(bool, n),
                 .piece = SN_NEW(sn_index, n),
                 .stack = SN_NEW(sn_index, n),
                 .piece_area = SN_NEW(double, n),
                 .piece_size = SN_NEW(sn_index, n),
                 .near = SN_NEW(double, n),
                 .far = SN_NEW(double, n),
                 .next = SN_NEW(bool, n),
                 .gap = SN_NEW(double, n),
                 .normals = SN_NEW(sn_vec3, n)};
    bool complete =
        p->inside && p->piece && p->stack && p->piece_area && p->piece_size && p->near && p->far && p->next && p->gap && p->normals;
    return complete ? SN_OK : sn_fail_memory(error, "patches");
}

static void close_patch(patch *p) {
    free(p->inside);
    free(p->piece);
    free(p->stack);
    free(p->piece_area);
    free(p->piece_size);
    free(p->near);
    free(p->far);
    free(p->next);
    free(p->gap);
    free(p->normals);
}

/* ---- pieces ------------------------------------------------------------------------------------------------------------ */

static void walk_piece(patch *p, const bool *set, bool value, sn_index start, sn_index number) {
    const sn_topology *t = &p->d->topology;
    sn_index height = 0;
    p->piece_area[number] = 0.0;
    p->piece_size[number] = 0;
    p->piece[start] = number;
    p->stack[height++] = start;
    while (height > 0) {
        sn_index v = p->stack[--height];
        p->piece_area[number] += p->d->vertex_area[v];
        p->piece_size[number]++;
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (set[w] != value || p->piece[w] != SN_NONE) continue;
            p->piece[w] = number;
            p->stack[height++] = w;
        }
    }
}

/* The connected pieces of the vertices where set has the value. */
static sn_index find_pieces(patch *p, const bool *set, bool value) {
    sn_index count = 0;
    for (sn_index v = 0; v < vertices_of(p); v++) p->piece[v] = SN_NONE;
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (set[v] == value && p->piece[v] == SN_NONE) walk_piece(p, set, value, v, count++);
    return count;
}

static double area_inside(const patch *p) {
    double area = 0.0;
    for (sn_index v = 0; v < vertices_of(p); v++) area += p->inside[v] ? p->d->vertex_area[v] : 0.0;
    return area;
}

static bool is_free(const patch *p, sn_index v) { return p->d->holder_of[v] == SN_NONE; }

static double gap_at(patch *p, sn_index v) {
    if (isnan(p->gap[v])) p->gap[v] = sn_surface_signed_distance(p->surface, p->d->muscle->mesh.positions[v], NULL);
    return p->gap[v];
}

/* Does the muscle face the bone at a vertex? On the far side of a tendon it does not, near as the bone is. */
static bool faces_bone(const patch *p, sn_index v) {
    sn_vec3 at = p->d->muscle->mesh.positions[v];
    return sn_dot(sn_sub(sn_surface_closest(p->surface, at, INFINITY).point, at), p->normals[v]) > 0.0;
}

/* May a vertex join where it is not in a hole? */
static bool may_join(patch *p, sn_index v) {
    return is_free(p, v) && (gap_at(p, v) <= 0.0 || (gap_at(p, v) <= p->reach && faces_bone(p, v)));
}

/* next (by piece of the complement): a hole: all of it free, some of it beside the patch, and not too large. */
static void find_holes(patch *p, sn_index count, double largest) {
    const sn_topology *t = &p->d->topology;
    memset(p->next, 0, (size_t)vertices_of(p) * sizeof *p->next);
    for (sn_index v = 0; v < vertices_of(p); v++)
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1] && !p->inside[v]; k++)
            if (p->inside[t->neighbours[k]]) p->next[p->piece[v]] = true;
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (!p->inside[v] && !is_free(p, v) && p->d->holder_of[v] != p->bone) p->next[p->piece[v]] = false;
    for (sn_index i = 0; i < count; i++) p->next[i] = p->next[i] && p->piece_area[i] < largest;
}

static sn_index count_holes(patch *p) {
    sn_index count = find_pieces(p, p->inside, false), holes = 0;
    find_holes(p, count, HOLE_SHARE * area_inside(p));
    for (sn_index i = 0; i < count; i++) holes += p->next[i];
    return holes;
}

/* ---- the steps --------------------------------------------------------------------------------------------------------- */

static void note(const patch *p, sn_index v, sn_attach_change *change) {
    change->vertices++;
    change->area += p->d->vertex_area[v];
}

static void take(patch *p, sn_index v, sn_attach_change *change) {
    p->inside[v] = true;
    note(p, v, change);
}

static void drop(patch *p, sn_index v, sn_attach_change *change) {
    p->inside[v] = false;
    note(p, v, change);
}

/* Distance along edges from the vertices where set has the value; INFINITY everywhere where there are none. */
static sn_status distance_from(patch *p, const bool *set, bool value, double *out, sn_error *error) {
    sn_index count = 0;
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (set[v] == value) p->stack[count++] = v;
    for (sn_index v = 0; v < vertices_of(p) && count == 0; v++) out[v] = INFINITY;
    return count == 0 ? SN_OK : sn_edge_distance(&p->d->muscle->mesh, &p->d->topology, count, p->stack, out, error);
}

static double closing_distance(const detection *d) {
    return fmax(CLOSING_EDGES * sn_mesh_mean_edge(&d->muscle->mesh, &d->topology), CLOSING_SHARE * d->length);
}

static sn_status close_gaps(patch *p, sn_attach_change *filled, sn_error *error) {
    sn_status status = distance_from(p, p->inside, true, p->near, error);
    if (status != SN_OK) return status;
    for (sn_index v = 0; v < vertices_of(p); v++) p->next[v] = p->near[v] <= p->reach;
    status = distance_from(p, p->next, false, p->far, error);
    for (sn_index v = 0; v < vertices_of(p) && status == SN_OK; v++)
        if (!p->inside[v] && p->next[v] && p->far[v] > p->reach && isfinite(p->far[v]) && may_join(p, v)) take(p, v, filled);
    return status;
}

static void fill_holes(patch *p, sn_attach_change *filled) {
    sn_index count = find_pieces(p, p->inside, false);
    find_holes(p, count, HOLE_SHARE * area_inside(p));
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (!p->inside[v] && is_free(p, v) && p->next[p->piece[v]]) take(p, v, filled);
}

/* The smallest piece that is not marked in next; SN_NONE = none. */
static sn_index smallest_left(const patch *p, sn_index count) {
    sn_index best = SN_NONE;
    for (sn_index i = 0; i < count; i++)
        if (!p->next[i] && (best == SN_NONE || p->piece_area[i] < p->piece_area[best])) best = i;
    return best;
}

/* What the user gave is no crumb: its piece counts as too large. */
static void protect_given(patch *p) {
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (p->inside[v] && attach_is_given(p->d, v)) p->piece_area[p->piece[v]] = INFINITY;
}

static void drop_crumbs(patch *p, sn_attach_change *dropped) {
    double all = area_inside(p), gone = 0.0;
    sn_index count = find_pieces(p, p->inside, true), left = count;
    memset(p->next, 0, (size_t)vertices_of(p) * sizeof *p->next);
    protect_given(p);
    for (; left > 1; left--) {
        sn_index i = smallest_left(p, count);
        if (!(p->piece_area[i] < CRUMB_SHARE * all) || gone + p->piece_area[i] > CRUMBS_SHARE * all) break;
        gone += p->piece_area[i];
        p->next[i] = true;
    }
    for (sn_index v = 0; v < vertices_of(p); v++)
        if (p->inside[v] && p->next[p->piece[v]]) drop(p, v, dropped);
}

/* Of a vertex and its neighbours, the share that is inside: by number, as where triangles are uneven areas would have the large ones
 * decide. */
static double share_around(const patch *p, sn_index v) {
    const sn_topology *t = &p->d->topology;
    sn_index all = 1 + t->vertex_start[v + 1] - t->vertex_start[v], inside = p->inside[v];
    for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) inside += p->inside[t->neighbours[k]];
    return (double)inside / all;
}

/* Would the proposed set part a piece in two, or lose more than KEPT_SHARE leaves of the area? */
static bool harms(patch *p) {
    double kept = 0.0;
    sn_index before = find_pieces(p, p->inside, true);
    if (find_pieces(p, p->next, true) > before) return true;
    for (sn_index v = 0; v < vertices_of(p); v++) kept += p->next[v] ? p->d->vertex_area[v] : 0.0;
    return kept < KEPT_SHARE * area_inside(p);
}

/* A small piece, and one that the user gave a part of, loses nothing. */
static void propose(patch *p, bool leave) {
    for (sn_index v = 0; v < vertices_of(p); v++) {
        double share = share_around(p, v);
        bool keeps = p->inside[v] && (!leave || p->piece_size[p->piece[v]] < SMALL_PIECE || attach_is_given(p->d, v));
        p->next[v] = p->inside[v] ? keeps || share >= LEAVE_SHARE : share > JOIN_SHARE && may_join(p, v);
    }
}

/* A round that would do harm only adds. */
static void smooth_border(patch *p, sn_attach_change *moved) {
    find_pieces(p, p->inside, true);
    propose(p, true);
    if (harms(p)) {
        find_pieces(p, p->inside, true);
        propose(p, false);
    }
    for (sn_index v = 0; v < vertices_of(p); v++) {
        if (p->next[v] == p->inside[v]) continue;
        note(p, v, moved);
        p->inside[v] = p->next[v];
    }
}

/* ---- one bone ---------------------------------------------------------------------------------------------------------- */

static void let_go(detection *d, sn_index v) {
    d->holder_of[v] = SN_NONE;
    d->reason[v] = 0;
    d->distance[v] = NAN;
    d->runner_up[v] = INFINITY;
}

/* A vertex that steps took and gave back, or the other way round, is as it was. */
static void apply(patch *p) {
    detection *d = p->d;
    for (sn_index v = 0; v < vertices_of(p); v++) {
        bool held = d->holder_of[v] == p->bone;
        if (p->inside[v] && !held) attach_hold(d, v, p->bone, gap_at(p, v), SN_REASON_FILLED);
        if (!p->inside[v] && held) let_go(d, v);
    }
}

static sn_status work_on(patch *p, sn_attach_patch *report, sn_error *error) {
    report->pieces_before = find_pieces(p, p->inside, true);
    report->holes_before = count_holes(p);
    sn_status status = close_gaps(p, &report->filled, error);
    if (status != SN_OK) return status;
    fill_holes(p, &report->filled);
    drop_crumbs(p, &report->dropped);
    for (int i = 0; i < SMOOTHING_ROUNDS; i++) smooth_border(p, &report->moved);
    fill_holes(p, &report->filled);
    drop_crumbs(p, &report->dropped);
    report->pieces = find_pieces(p, p->inside, true);
    report->holes = count_holes(p);
    apply(p);
    return SN_OK;
}

static sn_status make_patch(patch *p, sn_attach_pair *pair, sn_error *error) {
    p->bone = pair->bone;
    for (sn_index v = 0; v < vertices_of(p); v++) {
        p->inside[v] = p->d->holder_of[v] == p->bone;
        p->gap[v] = NAN;
    }
    sn_status status = sn_surface_create(p->d->params->bones[p->bone].mesh, &p->surface, error);
    if (status == SN_OK) status = work_on(p, &pair->patch, error);
    sn_surface_destroy(p->surface);
    p->surface = NULL;
    return status;
}

sn_status attach_make_patches(detection *d, sn_error *error) {
    patch p;
    sn_status status = open_patch(d, &p, error);
    if (status == SN_OK) sn_mesh_vertex_normals(&d->muscle->mesh, p.normals);
    p.reach = closing_distance(d);
    for (sn_index i = 0; i < d->report->pair_count && status == SN_OK; i++) {
        sn_attach_pair *pair = &d->report->pairs[i];
        if (!attach_holds_by_distance(d, pair->bone) || !attach_holds_any(d, pair->bone)) continue;
        status = make_patch(&p, pair, error);
    }
    close_patch(&p);
    return status;
}

/* ---- for the other stages ----------------------------------------------------------------------------------------------- */

sn_status attach_pieces(const detection *d, sn_index bone, sn_index *piece, sn_index *count, sn_error *error) {
    const sn_topology *t = &d->topology;
    sn_index *stack = SN_NEW(sn_index, t->vertex_count), height = 0;
    *count = 0;
    if (stack == NULL) return sn_fail_memory(error, "patches");
    for (sn_index v = 0; v < t->vertex_count; v++) piece[v] = SN_NONE;
    for (sn_index start = 0; start < t->vertex_count; start++) {
        if (d->holder_of[start] != bone || piece[start] != SN_NONE) continue;
        piece[start] = *count;
        for (stack[height++] = start; height > 0;) {
            sn_index v = stack[--height];
            for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
                sn_index w = t->neighbours[k];
                if (d->holder_of[w] != bone || piece[w] != SN_NONE) continue;
                piece[w] = *count;
                stack[height++] = w;
            }
        }
        (*count)++;
    }
    free(stack);
    return SN_OK;
}
