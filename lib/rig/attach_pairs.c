/*
 * attach_pairs.c -- is this bone near this muscle? Vertices alone miss a bone between them: the surface is sampled densely.
 *
 * Each triangle is cut into k x k equal ones, no longer than the spacing; their centres are the samples, and each stands for its area.
 */
#include "attach.h"

#include <stdlib.h>

enum { SAMPLES = 8192, TRIANGLES_PER_CHUNK = 128, MOST_CUTS = 256 };

typedef struct probe {
    const sn_bone_search *search;
    double distance, spacing;
    double *near_area; /* (chunks) */
    bool *inside;      /* (chunks) */
} probe;

typedef struct tally {
    double area;
    bool inside;
} tally;

static void test_sample(const probe *p, sn_vec3 point, double area, tally *t) {
    const sn_bone_search *s = p->search;
    double gap = sn_box_gap((sn_box){point, point}, s->box);
    if (gap > p->distance) return;
    if (sn_surface_closest(s->surface, point, p->distance).triangle == SN_NONE) return;
    t->area += area;
    if (gap == 0.0 && !t->inside) t->inside = sn_surface_signed_distance(s->surface, point, NULL) <= 0.0;
}

static double longest_side(const sn_vec3 corner[3]) {
    double longest = 0.0;
    for (int k = 0; k < 3; k++) longest = fmax(longest, sn_distance(corner[k], corner[(k + 1) % 3]));
    return longest;
}

static bool out_of_reach(const probe *p, const sn_vec3 corner[3]) {
    sn_box box = {sn_min3(corner[0], sn_min3(corner[1], corner[2])), sn_max3(corner[0], sn_max3(corner[1], corner[2]))};
    return sn_box_gap(box, p->search->box) > p->distance;
}

static void test_triangle(const probe *p, sn_index triangle, tally *t) {
    const sn_mesh *mesh = p->search->muscle;
    sn_vec3 corner[3];
    for (int k = 0; k < 3; k++) corner[k] = mesh->positions[mesh->triangles[triangle].v[k]];
    if (out_of_reach(p, corner)) return;
    int cuts = (int)fmin(fmax(ceil(longest_side(corner) / p->spacing), 1.0), MOST_CUTS);
    sn_vec3 u = sn_scale(sn_sub(corner[1], corner[0]), 1.0 / cuts), v = sn_scale(sn_sub(corner[2], corner[0]), 1.0 / cuts);
    double area = 0.5 * sn_norm(sn_cross(u, v));
    for (int i = 0; i < cuts; i++) {
        for (int j = 0; i + j < cuts; j++) {
            sn_vec3 at = sn_add_scaled(sn_add_scaled(corner[0], u, i), v, j), step = sn_add(u, v);
            test_sample(p, sn_add_scaled(at, step, 1.0 / 3.0), area, t);
            if (i + j < cuts - 1) test_sample(p, sn_add_scaled(at, step, 2.0 / 3.0), area, t); /* the one that points the other way */
        }
    }
}

static void test_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const probe *p = user;
    tally t = {0};
    for (sn_index i = begin; i < end; i++) test_triangle(p, i, &t);
    p->near_area[chunk] = t.area;
    p->inside[chunk] = t.inside;
}

sn_status sn_probe_pair(const sn_bone_search *search, double distance, double area, sn_pair_probe *out, sn_error *error) {
    sn_index triangles = search->muscle->triangle_count, chunks = sn_chunk_count(triangles, TRIANGLES_PER_CHUNK);
    probe p = {.search = search, .distance = distance, .spacing = sqrt(2.0 * area / SAMPLES)};
    *out = (sn_pair_probe){0};
    if (!(area > 0.0)) return SN_OK; /* nothing to sample: the share of nothing is nothing */
    p.near_area = SN_NEW(double, chunks);
    p.inside = SN_NEW(bool, chunks);
    if (p.near_area != NULL && p.inside != NULL) {
        sn_parallel_for(search->pool, triangles, TRIANGLES_PER_CHUNK, test_range, &p);
        for (sn_index c = 0; c < chunks; c++) {
            out->area_share += p.near_area[c] / area;
            out->penetrates = out->penetrates || p.inside[c];
        }
    }
    bool complete = p.near_area != NULL && p.inside != NULL;
    free(p.near_area);
    free(p.inside);
    return complete ? SN_OK : sn_fail_memory(error, "the samples of a muscle");
}
