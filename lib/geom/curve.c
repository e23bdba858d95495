/*
 * curve.c -- triangles in the order of a space-filling curve.
 */
#include "curve.h"

#include <stdlib.h>

typedef struct placed_triangle {
    uint64_t code; /* of the centre along the curve */
    const sn_triangle *triangle;
    sn_index number;
} placed_triangle;

/* Spread 21 bits so that two zeros follow each. */
static uint64_t spread_bits(uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffffULL;
    x = (x | x << 16) & 0x001f0000ff0000ffULL;
    x = (x | x << 8) & 0x100f00f00f00f00fULL;
    x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
    return (x | x << 2) & 0x1249249249249249ULL;
}

static sn_vec3 centre_of(const sn_mesh *mesh, sn_triangle t) {
    sn_vec3 sum = sn_add(sn_add(mesh->positions[t.v[0]], mesh->positions[t.v[1]]), mesh->positions[t.v[2]]);
    return sn_scale(sum, 1.0 / 3.0);
}

/* Morton code of a point of the box. */
static uint64_t curve_code(sn_vec3 p, sn_vec3 low, double scale) {
    sn_vec3 q = sn_scale(sn_sub(p, low), scale);
    return spread_bits((uint64_t)q.x) | spread_bits((uint64_t)q.y) << 1 | spread_bits((uint64_t)q.z) << 2;
}

static int by_code(const void *a, const void *b) {
    const placed_triangle *p = a, *q = b;
    if (p->code != q->code) return p->code < q->code ? -1 : 1;
    for (int k = 0; k < 3; k++)
        if (p->triangle->v[k] != q->triangle->v[k]) return p->triangle->v[k] < q->triangle->v[k] ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

sn_status sn_curve_order(const sn_mesh *mesh, sn_index *order, sn_error *error) {
    placed_triangle *placed = SN_NEW(placed_triangle, mesh->triangle_count);
    if (placed == NULL) return sn_fail_memory(error, "a search structure");
    sn_box box = sn_mesh_box(mesh);
    sn_vec3 size = sn_sub(box.high, box.low);
    double largest = fmax(size.x, fmax(size.y, size.z)), scale = largest > 0.0 ? 2097151.0 / largest : 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        placed[t] =
            (placed_triangle){curve_code(sn_max3(centre_of(mesh, mesh->triangles[t]), box.low), box.low, scale), &mesh->triangles[t], t};
    qsort(placed, (size_t)mesh->triangle_count, sizeof *placed, by_code);
    for (sn_index i = 0; i < mesh->triangle_count; i++) order[i] = placed[i].number;
    free(placed);
    return SN_OK;
}
