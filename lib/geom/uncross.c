/*
 * uncross.c -- crossings that repair has made, taken back: what crosses is cut out, and the hole filled anew.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "edit.h"

/* ---- which triangles are new ---------------------------------------------------------------------------------------------- */

/* The triangles of both, those of `old` first, with one vertex for each place. */
static sn_status join_by_place(const sn_mesh *old, const sn_mesh *mesh, sn_mesh *joined, sn_error *error) {
    if (old->vertex_count > SN_INDEX_MAX - mesh->vertex_count || old->triangle_count > SN_INDEX_MAX / 3 - mesh->triangle_count) {
        return sn_fail(error, SN_ERROR_INPUT, "the surface is too large to be compared with another");
    }
    sn_index vertices = old->vertex_count + mesh->vertex_count, triangles = old->triangle_count + mesh->triangle_count;
    sn_status status = sn_mesh_alloc(joined, vertices, triangles, error);
    if (status != SN_OK) return status;
    memcpy(joined->positions, old->positions, (size_t)old->vertex_count * sizeof *old->positions);
    memcpy(joined->positions + old->vertex_count, mesh->positions, (size_t)mesh->vertex_count * sizeof *mesh->positions);
    sn_index *place = SN_NEW(sn_index, vertices);
    status = place != NULL ? sn_find_representatives(joined, 0.0, place, error) : sn_fail_memory(error, "comparing surfaces");
    for (sn_index t = 0; status == SN_OK && t < triangles; t++) {
        bool is_old = t < old->triangle_count;
        const sn_index *v = is_old ? old->triangles[t].v : mesh->triangles[t - old->triangle_count].v;
        for (int k = 0; k < 3; k++) joined->triangles[t].v[k] = place[is_old ? v[k] : v[k] + old->vertex_count];
    }
    free(place);
    return status;
}

/* Of the triangles at one place, old ones come first (the sort is stable), and each of them stands for one of the others. */
static void mark_new(const sn_index *order, const sn_triangle *triples, sn_index count, sn_index old_count, bool *is_new) {
    sn_index known = 0;
    for (sn_index i = 0; i < count; i++) {
        if (i == 0 || !sn_same_triple(triples[order[i - 1]], triples[order[i]])) known = 0;
        if (order[i] < old_count)
            known++;
        else
            is_new[order[i] - old_count] = known-- <= 0;
    }
}

sn_status sn_find_new_triangles(const sn_mesh *old, const sn_mesh *mesh, bool *is_new, sn_error *error) {
    sn_mesh joined = {0};
    sn_status status = join_by_place(old, mesh, &joined, error);
    sn_index *order = SN_NEW(sn_index, joined.triangle_count);
    sn_triangle *triples = SN_NEW(sn_triangle, joined.triangle_count);
    if (status == SN_OK && (order == NULL || triples == NULL)) status = sn_fail_memory(error, "comparing surfaces");
    if (status == SN_OK) status = sn_sort_triples(&joined, order, triples, error);
    if (status == SN_OK) mark_new(order, triples, joined.triangle_count, old->triangle_count, is_new);
    free(order);
    free(triples);
    sn_mesh_free(&joined);
    return status;
}

/* ---- cutting ---------------------------------------------------------------------------------------------------------------- */

/* All that hang on a marked vertex are cut as well. */
static void cut_at(const sn_mesh *mesh, const bool *marked, bool *cut) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        if (marked[v[0]] || marked[v[1]] || marked[v[2]]) cut[t] = true;
    }
}

static void widen(const sn_mesh *mesh, bool *marked, bool *cut) {
    memset(marked, 0, (size_t)mesh->vertex_count * sizeof *marked);
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; cut[t] && k < 3; k++) marked[mesh->triangles[t].v[k]] = true;
    }
    cut_at(mesh, marked, cut);
}

/* Vertices where borders of the cut meet: more than two of their edges have one side cut and one not. true = there are some. */
static bool mark_pinched(const sn_topology *topology, const bool *cut, sn_index *borders, bool *marked) {
    bool some = false;
    memset(borders, 0, (size_t)topology->vertex_count * sizeof *borders);
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_edge *edge = &topology->edges[e];
        if (edge->triangle_count != 2 || cut[edge->triangle[0]] == cut[edge->triangle[1]]) continue;
        borders[edge->v[0]]++;
        borders[edge->v[1]]++;
    }
    for (sn_index v = 0; v < topology->vertex_count; v++) {
        marked[v] = borders[v] > 2;
        some = some || marked[v];
    }
    return some;
}

/* Widen by rings, then until what is left is a manifold with a border. */
static sn_status shape_cut(const sn_mesh *mesh, int rings, bool *cut, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    bool *marked = SN_NEW(bool, mesh->vertex_count);
    sn_index *borders = SN_NEW(sn_index, mesh->vertex_count);
    if (marked != NULL && borders != NULL) {
        for (int i = 0; i < rings; i++) widen(mesh, marked, cut);
        while (mark_pinched(&topology, cut, borders, marked)) cut_at(mesh, marked, cut);
    } else {
        status = sn_fail_memory(error, "taking back crossings");
    }
    free(borders);
    free(marked);
    sn_topology_free(&topology);
    return status;
}

static double area_of(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return 0.5 * sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* Of the pieces into which a component falls (piece: component of what is left; whole: component before) the largest stays. */
static sn_status keep_pieces(const sn_mesh *left, const sn_index *whole, const sn_index *piece, sn_index pieces, bool *keep,
                             sn_error *error) {
    sn_index most = 0;
    for (sn_index t = 0; t < left->triangle_count; t++) most = whole[t] > most ? whole[t] : most;
    double *area = SN_NEW(double, pieces);
    sn_index *largest = SN_NEW(sn_index, (size_t)most + 1); /* piece + 1; 0 = none yet */
    bool enough = area != NULL && largest != NULL;
    for (sn_index t = 0; enough && t < left->triangle_count; t++) area[piece[t]] += area_of(left, t);
    for (sn_index t = 0; enough && t < left->triangle_count; t++) {
        sn_index *best = &largest[whole[t]];
        if (*best == 0 || area[piece[t]] > area[*best - 1]) *best = piece[t] + 1;
    }
    for (sn_index t = 0; enough && t < left->triangle_count; t++) keep[t] = piece[t] == largest[whole[t]] - 1;
    free(area);
    free(largest);
    return enough ? SN_OK : sn_fail_memory(error, "taking back crossings");
}

/* Take the cut triangles out, and the pieces that they leave behind. `whole` (triangle_count) follows. */
static sn_status take_out(sn_mesh *mesh, const bool *cut, sn_index *whole, sn_error *error) {
    sn_topology topology = {0};
    sn_index count = 0;
    bool *keep = SN_NEW(bool, mesh->triangle_count);
    sn_index *piece = SN_NEW(sn_index, mesh->triangle_count);
    sn_status status = keep != NULL && piece != NULL ? SN_OK : sn_fail_memory(error, "taking back crossings");
    for (sn_index t = 0; status == SN_OK && t < mesh->triangle_count; t++) {
        keep[t] = !cut[t];
        if (keep[t]) whole[count++] = whole[t];
    }
    if (status == SN_OK) {
        sn_mesh_keep_triangles(mesh, keep);
        status = sn_topology_build(mesh, &topology, error);
    }
    if (status == SN_OK) {
        sn_index pieces = sn_mesh_components(mesh, &topology, piece);
        status = keep_pieces(mesh, whole, piece, pieces, keep, error);
    }
    if (status == SN_OK) sn_mesh_keep_triangles(mesh, keep);
    sn_topology_free(&topology);
    free(piece);
    free(keep);
    return status;
}

static sn_status cut_out(sn_mesh *mesh, const bool *cut, sn_error *error) {
    sn_topology topology;
    sn_index unused = 0;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index *whole = SN_NEW(sn_index, mesh->triangle_count);
    if (whole != NULL) {
        sn_mesh_components(mesh, &topology, whole);
        status = take_out(mesh, cut, whole, error);
    } else {
        status = sn_fail_memory(error, "taking back crossings");
    }
    free(whole);
    sn_topology_free(&topology);
    if (status == SN_OK) status = sn_drop_unused_vertices(mesh, &unused, error);
    return status;
}

static sn_status fill_again(sn_mesh *mesh, sn_mesh_report *now, sn_error *error) {
    sn_index filled = 0, left = 0, degenerate = 0, duplicate = 0;
    sn_status status = sn_fill_holes(mesh, SN_INDEX_MAX, NULL, &filled, &left, error);
    if (status == SN_OK) status = sn_mesh_inspect(mesh, now, error);
    if (status != SN_OK || now->degenerate_triangles == 0) return status;
    status = sn_drop_bad_triangles(mesh, &degenerate, &duplicate, error);
    return status == SN_OK ? sn_mesh_inspect(mesh, now, error) : status;
}

/* ---- trying ----------------------------------------------------------------------------------------------------------------- */

#define MOST_ROUNDS 16
#define MOST_RINGS 6
/* Share of the volume that a cut may change: where more of it goes, a part of the body has. */
#define MOST_VOLUME 0.05

typedef struct undoing {
    const sn_undo_params *params;
    sn_mesh *mesh;
    sn_mesh_report found; /* of the mesh */
    sn_index pairs;
    double gone;        /* area of the input that was lost to start with */
    bool guilty;        /* some triangle is to be cut */
    bool *is_new, *cut; /* (triangle_count) */
} undoing;

static bool is_sound(const sn_mesh_report *found) { return found->closed && found->manifold && found->oriented; }

/* New triangles that cross any, and those that they cross. */
static sn_status find_guilty(undoing *u, sn_error *error) {
    sn_index count = u->mesh->triangle_count;
    free(u->is_new);
    free(u->cut);
    u->is_new = SN_NEW(bool, count);
    u->cut = SN_NEW(bool, count);
    if (u->is_new == NULL || u->cut == NULL) return sn_fail_memory(error, "taking back crossings");
    sn_status status = sn_find_new_triangles(u->params->before, u->mesh, u->is_new, error);
    if (status == SN_OK) status = sn_find_self_intersections(u->mesh, 0, u->is_new, u->cut, &u->pairs, error);
    u->guilty = status == SN_OK && memchr(u->cut, true, (size_t)count * sizeof *u->cut) != NULL;
    return status;
}

/* Worth having: as whole as before, no more handles, fewer crossings, and not too much of what there was gone. */
static sn_status judge(const undoing *u, const sn_mesh *tried, const sn_mesh_report *now, bool *better, sn_error *error) {
    double gone = 0.0;
    sn_index pairs = 0;
    *better = false;
    if (!is_sound(now) || now->components != u->found.components || now->genus > u->found.genus ||
        fabs(now->volume - u->found.volume) > MOST_VOLUME * fabs(u->found.volume))
        return SN_OK;
    sn_status status = sn_lost_area(u->params->before, tried, u->params->reach, &gone, error);
    if (status == SN_OK && gone - u->gone <= u->params->most_area) {
        status = sn_find_self_intersections(tried, 0, NULL, NULL, &pairs, error);
        *better = pairs < u->pairs;
    }
    return status;
}

static sn_status try_cut(undoing *u, int rings, bool *better, sn_error *error) {
    sn_mesh tried;
    sn_mesh_report now = {0};
    sn_status status = sn_mesh_copy(u->mesh, &tried, error);
    *better = false;
    if (status == SN_OK) status = shape_cut(&tried, rings, u->cut, error);
    if (status == SN_OK) status = cut_out(&tried, u->cut, error);
    if (status == SN_OK && tried.triangle_count > 0) {
        status = fill_again(&tried, &now, error);
        if (status == SN_OK) status = judge(u, &tried, &now, better, error);
    }
    if (*better) {
        u->found = now;
        sn_mesh_replace(u->mesh, &tried);
    }
    sn_mesh_free(&tried);
    return status;
}

sn_status sn_undo_crossings(sn_mesh *mesh, const sn_undo_params *params, sn_index *left, sn_error *error) {
    undoing u = {.params = params, .mesh = mesh};
    sn_status status = sn_mesh_inspect(mesh, &u.found, error);
    if (status == SN_OK) status = sn_lost_area(params->before, mesh, params->reach, &u.gone, error);
    if (status == SN_OK) status = find_guilty(&u, error);
    int rings = 0;
    for (int round = 0; status == SN_OK && is_sound(&u.found) && u.guilty; round++) {
        bool better = false;
        if (round == MOST_ROUNDS || rings > MOST_RINGS) break;
        status = try_cut(&u, rings, &better, error);
        if (!better) rings++;
        if (status == SN_OK) status = find_guilty(&u, error);
    }
    *left = u.pairs;
    free(u.is_new);
    free(u.cut);
    return status;
}
