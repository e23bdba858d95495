/*
 * levels.c -- sections of a muscle along its length.
 *
 * As in slabs.c what is cut is the surface, not the set of its vertices: a piece is where one level crosses one triangle, and pieces hang
 * together over the edges that the level crosses. So the sections hardly depend on the mesh.
 */
#include "levels.h"

#include "tips.h"

#include <stdlib.h>

#include "sinew/sets.h"

enum { LEVELS = 160 };

/* ---- the field ------------------------------------------------------------------------------------------------------------ */

/* The vertices just below the curve half-way between the tips. */
static sn_index middle_vertices(const levels *l, double half, sn_index *out) {
    sn_index count = 0;
    for (sn_index v = 0; v < l->mesh->vertex_count; v++) {
        bool beside = false;
        for (sn_index k = l->topology->vertex_start[v]; l->along[v] < half && k < l->topology->vertex_start[v + 1]; k++)
            beside = beside || l->along[l->topology->neighbours[k]] >= half;
        if (beside) out[count++] = v;
    }
    return count;
}

/* From the distance to a tip to the signed one from the middle. */
static sn_status turn_to_middle(levels *l, double half, sn_error *error) {
    sn_index *middle = SN_NEW(sn_index, l->mesh->vertex_count);
    double *from_middle = SN_NEW(double, l->mesh->vertex_count);
    sn_status status = middle != NULL && from_middle != NULL ? SN_OK : sn_fail_memory(error, "the length of the muscle");
    sn_index count = status == SN_OK ? middle_vertices(l, half, middle) : 0;
    if (status == SN_OK && count == 0) status = sn_fail(error, SN_ERROR_INPUT, "the muscle's surface has no length to measure along");
    if (status == SN_OK) status = sn_geodesic_distance(l->mesh, l->topology, count, middle, from_middle, error);
    for (sn_index v = 0; status == SN_OK && v < l->mesh->vertex_count; v++)
        l->along[v] = !isfinite(from_middle[v]) ? NAN : l->along[v] < half ? -from_middle[v] : from_middle[v];
    free(middle);
    free(from_middle);
    return status;
}

static sn_status make_field(levels *l, sn_error *error) {
    surface_survey survey;
    tips ends = {0};
    double high = -INFINITY;
    l->along = SN_NEW(double, l->mesh->vertex_count);
    l->low = INFINITY;
    if (l->along == NULL) return sn_fail_memory(error, "the length of the muscle");
    sn_status status = survey_surface(l->mesh, l->topology, &survey, error);
    if (status == SN_OK) status = find_tips(l->mesh, l->topology, survey.main_vertex, NULL, &ends, error);
    if (status == SN_OK) status = sn_geodesic_distance(l->mesh, l->topology, 1, &ends.end[0], l->along, error);
    if (status == SN_OK) status = turn_to_middle(l, 0.5 * ends.length, error);
    for (sn_index v = 0; status == SN_OK && v < l->mesh->vertex_count; v++) {
        if (isnan(l->along[v])) continue;
        l->low = fmin(l->low, l->along[v]);
        high = fmax(high, l->along[v]);
    }
    l->level_count = LEVELS;
    l->step = (high - l->low) / LEVELS;
    if (status == SN_OK && !(l->step > 0.0 && isfinite(l->step)))
        status = sn_fail(error, SN_ERROR_INPUT, "the muscle's surface has no length to measure along");
    return status;
}

static double level_at(const levels *l, sn_index level) { return l->low + (level + 0.5) * l->step; }

static void find_bands(levels *l) {
    for (sn_index v = 0; v < l->mesh->vertex_count; v++) {
        l->band[v] = SN_NONE;
        if (isnan(l->along[v])) continue;
        sn_index band = (sn_index)floor((l->along[v] - l->low) / l->step + 0.5);
        l->band[v] = band < 0 ? 0 : band > l->level_count ? l->level_count : band;
    }
}

/* ---- pieces and patches ----------------------------------------------------------------------------------------- */

static sn_index lowest_band(const levels *l, const sn_index *v) {
    sn_index a = l->band[v[0]] < l->band[v[1]] ? l->band[v[0]] : l->band[v[1]];
    return a < l->band[v[2]] ? a : l->band[v[2]];
}

static sn_index highest_band(const levels *l, const sn_index *v) {
    sn_index a = l->band[v[0]] > l->band[v[1]] ? l->band[v[0]] : l->band[v[1]];
    return a > l->band[v[2]] ? a : l->band[v[2]];
}

static sn_index piece_at(const levels *l, sn_index triangle, sn_index level) {
    return l->piece_start[triangle] + level - lowest_band(l, l->mesh->triangles[triangle].v);
}

static sn_status number_pieces(levels *l, sn_error *error) {
    int64_t count = 0;
    l->piece_start = SN_NEW(sn_index, (size_t)l->mesh->triangle_count + 1);
    if (l->piece_start == NULL) return sn_fail_memory(error, "the sections of the muscle");
    for (sn_index t = 0; t < l->mesh->triangle_count; t++) {
        const sn_index *v = l->mesh->triangles[t].v;
        l->piece_start[t] = (sn_index)count;
        count += highest_band(l, v) - lowest_band(l, v);
        if (count >= SN_INDEX_MAX / 4)
            return sn_fail(error, SN_ERROR_INPUT,
                           "the surface is too large to be cut into sections; decimate it with mesh-clean --triangles");
    }
    l->piece_start[l->mesh->triangle_count] = (sn_index)count;
    l->piece = SN_NEW(sn_index, (size_t)count + 1);
    return l->piece != NULL ? SN_OK : sn_fail_memory(error, "the sections of the muscle");
}

static void order_ends(const levels *l, const sn_edge *edge, sn_index end[2]) {
    bool rises = l->band[edge->v[0]] <= l->band[edge->v[1]];
    end[0] = edge->v[rises ? 0 : 1];
    end[1] = edge->v[rises ? 1 : 0];
}

/* Join pieces over edges and vertices within a band; a vertex stands for its patch until it is numbered. */
static void join_all(levels *l) {
    for (sn_index i = 0; i < l->piece_start[l->mesh->triangle_count]; i++) l->piece[i] = i;
    for (sn_index v = 0; v < l->mesh->vertex_count; v++) l->vertex_node[v] = v;
    for (sn_index e = 0; e < l->topology->edge_count; e++) {
        const sn_edge *edge = &l->topology->edges[e];
        sn_index end[2];
        order_ends(l, edge, end);
        if (l->band[end[0]] == l->band[end[1]]) sn_join_sets(l->vertex_node, end[0], end[1]);
        for (sn_index k = l->band[end[0]]; edge->triangle[1] != SN_NONE && k < l->band[end[1]]; k++)
            sn_join_sets(l->piece, piece_at(l, edge->triangle[0], k), piece_at(l, edge->triangle[1], k));
    }
}

/* Numbers for the sets of a forest whose roots are lowest, from `first` on in their order; returns the next one. */
static sn_index number_sets(sn_index count, sn_index *link, sn_index first) {
    sn_index next = first;
    for (sn_index i = 0; i < count; i++) link[i] = link[i] == i ? next++ : link[link[i]];
    return next;
}

/* ---- sections --------------------------------------------------------------------------------------------------------------- */

/* What is summed over a loop; places are relative to `origin`, for far from 0 the sums would cancel. */
typedef struct loop_sums {
    sn_vec3 cross, chord, centre;
} loop_sums;

static sn_vec3 crossing(const levels *l, sn_index low, sn_index high, sn_index level) {
    double a = l->along[low], b = l->along[high], t = b > a ? (level_at(l, level) - a) / (b - a) : 0.5;
    return sn_lerp(l->mesh->positions[low], l->mesh->positions[high], fmin(fmax(t, 0.0), 1.0));
}

/* The segment of a level in a triangle: from where the triangle's boundary rises through it to where it falls. */
static void cut_triangle(const levels *l, const sn_index *v, sn_index level, sn_vec3 out[2]) {
    for (int i = 0; i < 3; i++) {
        sn_index a = v[i], b = v[(i + 1) % 3];
        if (l->band[a] <= level && l->band[b] > level) out[0] = crossing(l, a, b, level);
        if (l->band[b] <= level && l->band[a] > level) out[1] = crossing(l, b, a, level);
    }
}

static void add_piece(const levels *l, sn_index triangle, sn_index level, sn_vec3 origin, loop_sums *sums) {
    sn_vec3 p[2] = {{0, 0, 0}, {0, 0, 0}};
    sn_index loop = l->piece[piece_at(l, triangle, level)];
    cut_triangle(l, l->mesh->triangles[triangle].v, level, p);
    sn_vec3 a = sn_sub(p[0], origin), b = sn_sub(p[1], origin);
    double length = sn_distance(a, b);
    sums[loop].cross = sn_add(sums[loop].cross, sn_cross(a, b));
    sums[loop].chord = sn_add(sums[loop].chord, sn_sub(b, a));
    sums[loop].centre = sn_add_scaled(sums[loop].centre, sn_add(a, b), 0.5 * length);
    l->loops[loop].perimeter += length;
    l->loops[loop].level = level;
}

/* Area about the middle of the rim: of a closed one the same about any point. */
static void finish_loop(level_loop *loop, const loop_sums *sums, sn_vec3 origin) {
    sn_vec3 centre = loop->perimeter > 0.0 ? sn_scale(sums->centre, 1.0 / loop->perimeter) : sn_v3(0, 0, 0);
    loop->area = 0.5 * sn_norm(sn_sub(sums->cross, sn_cross(centre, sums->chord)));
    loop->centre = sn_add(centre, origin);
}

static sn_status measure_loops(levels *l, sn_error *error) {
    loop_sums *sums = SN_NEW(loop_sums, (size_t)l->loop_count + 1);
    l->loops = SN_NEW(level_loop, (size_t)l->loop_count + 1);
    sn_box box = sn_mesh_box(l->mesh);
    sn_vec3 origin = sn_lerp(box.low, box.high, 0.5);
    bool made = sums != NULL && l->loops != NULL;
    for (sn_index t = 0; made && t < l->mesh->triangle_count; t++) {
        const sn_index *v = l->mesh->triangles[t].v;
        for (sn_index k = lowest_band(l, v); k < highest_band(l, v); k++) add_piece(l, t, k, origin, sums);
    }
    for (sn_index i = 0; made && i < l->loop_count; i++) finish_loop(&l->loops[i], &sums[i], origin);
    free(sums);
    return made ? SN_OK : sn_fail_memory(error, "the sections of the muscle");
}

/* ---- what hangs on what ------------------------------------------------------------------------------------------------------ */

/* The nodes that an edge runs through, from its lower end to its higher one: patch, loops, patch. */
static void link_edge(levels *l, const sn_edge *edge, sn_index *fill) {
    sn_index end[2], last;
    order_ends(l, edge, end);
    last = l->vertex_node[end[0]];
    for (sn_index k = l->band[end[0]]; k <= l->band[end[1]]; k++) {
        sn_index node = k < l->band[end[1]] ? l->piece[piece_at(l, edge->triangle[0], k)] : l->vertex_node[end[1]];
        if (l->links != NULL) {
            l->links[fill[last]++] = node;
            l->links[fill[node]++] = last;
        } else {
            fill[last]++;
            fill[node]++;
        }
        last = node;
    }
}

static void link_edges(levels *l, sn_index *fill) {
    for (sn_index e = 0; e < l->topology->edge_count; e++) {
        const sn_edge *edge = &l->topology->edges[e];
        if (l->band[edge->v[0]] != l->band[edge->v[1]]) link_edge(l, edge, fill);
    }
}

static sn_status link_nodes(levels *l, sn_error *error) {
    l->link_start = SN_NEW(sn_index, (size_t)l->node_count + 1);
    sn_index *fill = SN_NEW(sn_index, (size_t)l->node_count + 1);
    bool made = l->link_start != NULL && fill != NULL;
    if (made) link_edges(l, fill); /* counts */
    for (sn_index i = 0; made && i < l->node_count; i++) {
        l->link_start[i + 1] = l->link_start[i] + fill[i];
        fill[i] = l->link_start[i];
    }
    made = made && (l->links = SN_NEW(sn_index, (size_t)l->link_start[l->node_count] + 1)) != NULL;
    if (made) link_edges(l, fill);
    free(fill);
    return made ? SN_OK : sn_fail_memory(error, "the sections of the muscle");
}

/* ---- the line of centroids ----------------------------------------------------------------------------------------------------- */

static sn_status find_centres(levels *l, sn_error *error) {
    double *weight = SN_NEW(double, l->level_count);
    l->centre = SN_NEW(sn_vec3, l->level_count);
    if (weight == NULL || l->centre == NULL) {
        free(weight);
        return sn_fail_memory(error, "the line of action");
    }
    for (sn_index i = 0; i < l->loop_count; i++) {
        sn_index k = l->loops[i].level;
        weight[k] += l->loops[i].area;
        if (weight[k] > 0.0) l->centre[k] = sn_lerp(l->centre[k], l->loops[i].centre, l->loops[i].area / weight[k]);
    }
    free(weight);
    return SN_OK;
}

/* The outermost levels, of caps and of fronts that reach the end askew, do not show a direction: the window stays off them. */
sn_vec3 levels_direction(const levels *l, double along) {
    double at = (along - l->low) / l->step - 0.5;
    sn_index reach = l->level_count / 10, first = l->level_count / 12, last = l->level_count - 1 - first;
    double low = fmin(fmax(at - reach, first), last - 2 * reach);
    sn_index from = (sn_index)(low + 0.5);
    return sn_normalize(sn_sub(l->centre[from + 2 * reach], l->centre[from]));
}

/* ---- the whole ----------------------------------------------------------------------------------------------------------------- */

sn_status levels_build(const sn_mesh *mesh, const sn_topology *topology, levels *out, sn_error *error) {
    *out = (levels){.mesh = mesh, .topology = topology};
    levels *l = out;
    sn_status status = make_field(l, error);
    l->band = SN_NEW(sn_index, mesh->vertex_count);
    l->vertex_node = SN_NEW(sn_index, mesh->vertex_count);
    if (status == SN_OK && (l->band == NULL || l->vertex_node == NULL)) status = sn_fail_memory(error, "the sections of the muscle");
    if (status == SN_OK) find_bands(l);
    if (status == SN_OK) status = number_pieces(l, error);
    if (status == SN_OK) {
        join_all(l);
        l->loop_count = number_sets(l->piece_start[mesh->triangle_count], l->piece, 0);
        l->node_count = number_sets(mesh->vertex_count, l->vertex_node, l->loop_count);
        status = measure_loops(l, error);
    }
    if (status == SN_OK) status = link_nodes(l, error);
    if (status == SN_OK) status = find_centres(l, error);
    if (status != SN_OK) levels_free(out);
    return status;
}

void levels_free(levels *l) {
    free(l->along);
    free(l->band);
    free(l->piece_start);
    free(l->piece);
    free(l->loops);
    free(l->vertex_node);
    free(l->link_start);
    free(l->links);
    free(l->centre);
    *l = (levels){0};
}
