/*
 * attach_line.c -- landmarks in a row: an area that is a line, as along a linea aspera, is the band of the line's own width.
 */
#include "attach.h"

#include <stdlib.h>

/* ---- a line, or a boundary that closes? ------------------------------------------------------------------------------------ */

/* From so many landmarks on their zigzag is smoothed before it is measured; corners of fewer are corners. */
enum { SMOOTHED = 8 };

/* Of all landmarks within this share of the line's length from a straight line it does not matter in which order they are. */
static const double STRAIGHT = 0.01;

/* A landmark, averaged with its two neighbours (1:2:1) where there are many; the first and the last stay. */
static sn_vec3 smoothed(const sn_landmark_area *area, sn_index i) {
    const sn_vec3 *p = area->landmarks;
    if (area->count < SMOOTHED || i == 0 || i == area->count - 1) return p[i];
    return sn_add(sn_scale(p[i], 0.5), sn_add(sn_scale(p[i - 1], 0.25), sn_scale(p[i + 1], 0.25)));
}

static void measure_walk(const sn_landmark_area *area, sn_landmark_walk *walk) {
    *walk = (sn_landmark_walk){.closing = sn_distance(area->landmarks[0], area->landmarks[area->count - 1])};
    for (sn_index i = 0; i + 1 < area->count; i++) {
        double step = sn_distance(smoothed(area, i), smoothed(area, i + 1));
        walk->length += step;
        walk->longest = fmax(walk->longest, step);
    }
}

/* Of three landmarks the longest side closes: they have no order. */
static void measure_triangle(const sn_landmark_area *area, sn_landmark_walk *walk) {
    double side[3], sum = 0.0;
    walk->closing = 0.0;
    for (int k = 0; k < 3; k++) {
        side[k] = sn_distance(area->landmarks[k], area->landmarks[(k + 1) % 3]);
        walk->closing = fmax(walk->closing, side[k]);
        sum += side[k];
    }
    walk->length = sum - walk->closing;
}

static void find_ends(const sn_landmark_area *area, sn_index ends[2]) {
    double most = -1.0;
    for (sn_index i = 0; i < area->count; i++)
        for (sn_index j = i + 1; j < area->count; j++) {
            double apart = sn_distance(area->landmarks[i], area->landmarks[j]);
            if (!(apart > most)) continue;
            most = apart;
            ends[0] = i;
            ends[1] = j;
        }
}

static bool all_in_a_row(const sn_landmark_area *area) {
    sn_index ends[2] = {0, 0};
    find_ends(area, ends);
    sn_vec3 from = area->landmarks[ends[0]], along = sn_sub(area->landmarks[ends[1]], from);
    double squared = sn_dot(along, along);
    if (!(squared > 0.0)) return false;
    for (sn_index i = 0; i < area->count; i++) {
        sn_vec3 to = sn_sub(area->landmarks[i], from);
        if (sn_norm(sn_add_scaled(to, along, -sn_dot(to, along) / squared)) > STRAIGHT * sqrt(squared)) return false;
    }
    return true;
}

bool sn_landmarks_in_line(const sn_landmark_area *area, sn_landmark_walk *walk) {
    measure_walk(area, walk);
    if (area->count < 3) return true;
    if (area->count == 3) measure_triangle(area, walk);
    if (!(walk->closing > 0.0)) return false;
    if (walk->closing >= 0.98 * walk->length) return true;
    if (walk->closing > 2.0 * walk->longest && walk->closing > 0.8 * walk->length) return true;
    if (walk->closing > 4.0 * walk->longest && walk->closing > 0.5 * walk->length) return true;
    return all_in_a_row(area);
}

/* ---- the order of landmarks in a straight row ------------------------------------------------------------------------------- */

bool sn_line_order(const sn_landmark_area *area, sn_index *order) {
    bool moved = false;
    sn_index ends[2] = {0, 0};
    if (area->count < 3 || !all_in_a_row(area)) return false;
    find_ends(area, ends);
    sn_vec3 along = sn_sub(area->landmarks[ends[1]], area->landmarks[ends[0]]);
    for (sn_index i = 1; i < area->count; i++)
        for (sn_index k = i; k > 0; k--) {
            sn_index a = order[k - 1], b = order[k];
            if (!(sn_dot(sn_sub(area->landmarks[b], area->landmarks[a]), along) < 0.0)) break;
            order[k - 1] = b;
            order[k] = a;
            moved = true;
        }
    for (sn_index i = 0; moved && i < area->count; i++)
        if (order[i] != area->count - 1 - i) return true;
    return false; /* back to front is an order, too */
}

/* ---- the band ------------------------------------------------------------------------------------------------------------ */

static double distance_to_segment(sn_vec3 p, sn_vec3 a, sn_vec3 b) {
    sn_vec3 along = sn_sub(b, a);
    double squared = sn_dot(along, along), t = squared > 0.0 ? sn_dot(sn_sub(p, a), along) / squared : 0.0;
    return sn_distance(p, sn_add_scaled(a, along, fmin(fmax(t, 0.0), 1.0)));
}

static bool is_near(const sn_line *line, sn_vec3 p) {
    for (sn_index i = 0; i < line->count; i++)
        for (sn_index k = 0; k < line->paths[i].count; k++)
            if (distance_to_segment(p, line->paths[i].segments[k].from, line->paths[i].segments[k].to) <= 0.5 * line->width) return true;
    return false;
}

/* The corners of the triangles that the line runs through. */
static sn_index start_band(const sn_area_ground *ground, const sn_line *line, bool *inside, sn_index *stack) {
    sn_index height = 0;
    for (sn_index i = 0; i < line->count; i++)
        for (sn_index k = 0; k < line->paths[i].count; k++)
            for (int corner = 0; corner < 3; corner++) {
                sn_index v = ground->muscle->mesh.triangles[line->paths[i].segments[k].triangle].v[corner];
                if (inside[v]) continue;
                inside[v] = true;
                stack[height++] = v;
            }
    return height;
}

sn_status sn_line_band(const sn_area_ground *ground, const sn_line *line, bool *inside, double *area, sn_error *error) {
    const sn_topology *t = ground->topology;
    sn_index *stack = SN_NEW(sn_index, t->vertex_count);
    if (stack == NULL) return sn_fail_memory(error, "the band of a line");
    sn_index height = start_band(ground, line, inside, stack);
    while (height > 0) {
        sn_index v = stack[--height];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (inside[w] || !is_near(line, ground->muscle->mesh.positions[w])) continue;
            inside[w] = true;
            stack[height++] = w;
        }
    }
    free(stack);
    *area = 0.0;
    for (sn_index v = 0; v < t->vertex_count; v++) *area += inside[v] ? ground->vertex_area[v] : 0.0;
    return SN_OK;
}
