/* spread.c -- an even subset of a mesh's vertices, so that a dense mesh shows as many marks as a coarse one. */
#include "show.h"

#include <stdlib.h>

typedef struct spread {
    const sn_mesh *mesh;
    sn_vec3 origin;
    double radius;
    size_t buckets;        /* a power of two */
    sn_index *head, *next; /* accepted vertices by grid cell */
} spread;

typedef struct cell {
    int64_t x, y, z;
} cell;

static cell cell_of(const spread *s, sn_vec3 p) {
    return (cell){(int64_t)floor((p.x - s->origin.x) / s->radius), (int64_t)floor((p.y - s->origin.y) / s->radius),
                  (int64_t)floor((p.z - s->origin.z) / s->radius)};
}

static size_t bucket_of(const spread *s, cell c) {
    uint64_t h = (uint64_t)c.x * 73856093u ^ (uint64_t)c.y * 19349663u ^ (uint64_t)c.z * 83492791u;
    return (size_t)(h ^ h >> 17) & (s->buckets - 1);
}

static bool is_free(const spread *s, sn_vec3 p) {
    cell c = cell_of(s, p);
    for (int k = 0; k < 27; k++) {
        cell near = {c.x + k % 3 - 1, c.y + k / 3 % 3 - 1, c.z + k / 9 - 1};
        for (sn_index v = s->head[bucket_of(s, near)]; v != SN_NONE; v = s->next[v])
            if (sn_distance(s->mesh->positions[v], p) < s->radius) return false;
    }
    return true;
}

static sn_index accept_vertices(spread *s, sn_index *out) {
    sn_index count = 0;
    for (size_t b = 0; b < s->buckets; b++) s->head[b] = SN_NONE;
    for (sn_index v = 0; v < s->mesh->vertex_count; v++) {
        sn_vec3 p = s->mesh->positions[v];
        if (!is_free(s, p)) continue;
        size_t b = bucket_of(s, cell_of(s, p));
        s->next[v] = s->head[b];
        s->head[b] = v;
        out[count++] = v;
    }
    return count;
}

/* Every so manieth vertex: for what has no area. */
static sn_index every(const sn_mesh *mesh, sn_index target, sn_index *out) {
    sn_index step = (mesh->vertex_count - 1) / target + 1, count = 0;
    for (sn_index v = 0; v < mesh->vertex_count; v += step) out[count++] = v;
    return count;
}

sn_status spread_vertices(const sn_mesh *mesh, sn_index target, sn_index *count, sn_index **out, double *radius, sn_error *error) {
    spread s = {.mesh = mesh, .origin = sn_mesh_box(mesh).low, .buckets = 4096};
    /* a greedy Poisson disc packing of radius r holds about 0.7 points per r^2 */
    s.radius = sqrt(0.7 * sn_mesh_area(mesh) / target);
    bool degenerate = !(s.radius > 1e-6 * sn_box_diagonal(sn_mesh_box(mesh))) || !isfinite(s.radius);
    while (s.buckets < (size_t)target * 2) s.buckets *= 2;
    s.head = SN_NEW(sn_index, s.buckets);
    s.next = SN_NEW(sn_index, mesh->vertex_count);
    sn_index *kept = SN_NEW(sn_index, mesh->vertex_count);
    *radius = degenerate ? 0.0 : s.radius;
    *out = kept;
    if (s.head && s.next && kept)
        *count = degenerate || mesh->vertex_count <= target ? every(mesh, target, kept) : accept_vertices(&s, kept);
    bool done = s.head && s.next && kept;
    free(s.head);
    free(s.next);
    if (done) return SN_OK;
    free(kept);
    *out = NULL;
    return sn_fail_memory(error, "the spreading of marks");
}
