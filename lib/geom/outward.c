/*
 * outward.c -- which components are inside out, and turning them.
 */
#include "sinew/geom.h"

#include <stdlib.h>

#include "edit.h"
#include "order.h"

/* The mesh's triangles sorted by component, so that each component can be looked at as a mesh of its own. */
typedef struct parts {
    sn_index count;
    sn_vec3 *positions;
    sn_index *start; /* (count + 1) into triangles */
    sn_triangle *triangles;
    sn_box *boxes;   /* (count) */
    double *volumes; /* (count) signed */
} parts;

static void parts_free(parts *p) {
    free(p->start);
    free(p->triangles);
    free(p->boxes);
    free(p->volumes);
}

static sn_mesh part_mesh(const parts *p, sn_index c) {
    return (sn_mesh){.triangle_count = p->start[c + 1] - p->start[c], .triangles = p->triangles + p->start[c], .positions = p->positions};
}

static sn_box part_box(const parts *p, sn_index c) {
    sn_box box = {sn_v3(INFINITY, INFINITY, INFINITY), sn_v3(-INFINITY, -INFINITY, -INFINITY)};
    for (sn_index t = p->start[c]; t < p->start[c + 1]; t++) {
        for (int k = 0; k < 3; k++) {
            box.low = sn_min3(box.low, p->positions[p->triangles[t].v[k]]);
            box.high = sn_max3(box.high, p->positions[p->triangles[t].v[k]]);
        }
    }
    return box;
}

static double part_volume(const parts *p, sn_index c) {
    sn_vec3 centre = sn_lerp(p->boxes[c].low, p->boxes[c].high, 0.5);
    double six = 0.0;
    for (sn_index t = p->start[c]; t < p->start[c + 1]; t++) {
        const sn_index *v = p->triangles[t].v;
        sn_vec3 a = sn_sub(p->positions[v[0]], centre), b = sn_sub(p->positions[v[1]], centre), d = sn_sub(p->positions[v[2]], centre);
        six += sn_dot(a, sn_cross(b, d));
    }
    return six / 6.0;
}

static sn_status parts_create(const sn_mesh *mesh, sn_index count, const sn_index *component, parts *p, sn_error *error) {
    *p = (parts){.count = count, .positions = mesh->positions};
    p->start = SN_NEW(sn_index, (size_t)count + 1);
    p->triangles = SN_NEW(sn_triangle, mesh->triangle_count);
    p->boxes = SN_NEW(sn_box, count);
    p->volumes = SN_NEW(double, count);
    sn_index *order = SN_NEW(sn_index, mesh->triangle_count);
    bool enough = p->start && p->triangles && p->boxes && p->volumes && order;
    if (enough) {
        sn_counting_sort(mesh->triangle_count, NULL, component, count, p->start, order);
        for (sn_index i = 0; i < mesh->triangle_count; i++) p->triangles[i] = mesh->triangles[order[i]];
        for (sn_index c = 0; c < count; c++) {
            p->boxes[c] = part_box(p, c);
            p->volumes[c] = part_volume(p, c);
        }
    }
    free(order);
    if (enough) return SN_OK;
    parts_free(p);
    return sn_fail_memory(error, "sorting components");
}

static bool box_inside(sn_box inner, sn_box outer) {
    return inner.low.x > outer.low.x && inner.low.y > outer.low.y && inner.low.z > outer.low.z && inner.high.x < outer.high.x &&
           inner.high.y < outer.high.y && inner.high.z < outer.high.z;
}

/* How many other components surround component c. */
static sn_index depth_of(const parts *p, sn_index c) {
    sn_index depth = 0;
    sn_vec3 point = p->positions[p->triangles[p->start[c]].v[0]];
    for (sn_index other = 0; other < p->count; other++) {
        if (other == c || !box_inside(p->boxes[c], p->boxes[other])) continue;
        sn_mesh around = part_mesh(p, other);
        depth += fabs(sn_winding_number(&around, point)) > 0.5;
    }
    return depth;
}

sn_status sn_find_inverted(const sn_mesh *mesh, sn_index component_count, const sn_index *component, bool *inverted, sn_error *error) {
    parts p;
    sn_status status = parts_create(mesh, component_count, component, &p, error);
    if (status != SN_OK) return status;
    for (sn_index c = 0; c < component_count; c++) inverted[c] = p.volumes[c] < 0.0 && depth_of(&p, c) % 2 == 0;
    parts_free(&p);
    return SN_OK;
}

static void flip(sn_triangle *triangle) {
    sn_index kept = triangle->v[1];
    triangle->v[1] = triangle->v[2];
    triangle->v[2] = kept;
}

sn_status sn_orient_outward(sn_mesh *mesh, sn_index *flipped, sn_error *error) {
    *flipped = 0;
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index *component = SN_NEW(sn_index, mesh->triangle_count);
    sn_index count = component != NULL ? sn_mesh_components(mesh, &topology, component) : 0;
    bool *inverted = SN_NEW(bool, count);
    status = component != NULL && inverted != NULL ? sn_find_inverted(mesh, count, component, inverted, error)
                                                   : sn_fail_memory(error, "orienting components");
    for (sn_index c = 0; status == SN_OK && c < count; c++) *flipped += inverted[c];
    for (sn_index t = 0; status == SN_OK && t < mesh->triangle_count; t++) {
        if (inverted[component[t]]) flip(&mesh->triangles[t]);
    }
    free(inverted);
    free(component);
    sn_topology_free(&topology);
    return status;
}
