/*
 * clean_keep.c -- which components of a surface stay.
 */
#include "cleaning.h"

#include <stdlib.h>

/* Six times the volume of a triangle with the origin; relative to `centre`. */
static double six_volumes(sn_vec3 a, sn_vec3 b, sn_vec3 c, sn_vec3 centre) {
    return sn_dot(sn_sub(a, centre), sn_cross(sn_sub(b, centre), sn_sub(c, centre)));
}

/* Area, volume and area centre of each component. */
static void measure_components(const sn_cleaning *c, const sn_index *component, sn_index count, sn_dropped_component *measure) {
    sn_vec3 centre = sn_lerp(c->found.box.low, c->found.box.high, 0.5);
    for (sn_index t = 0; t < c->mesh->triangle_count; t++) {
        const sn_index *v = c->mesh->triangles[t].v;
        sn_vec3 p = c->mesh->positions[v[0]], q = c->mesh->positions[v[1]], r = c->mesh->positions[v[2]];
        sn_dropped_component *m = &measure[component[t]];
        double area = 0.5 * sn_norm(sn_area_vector(p, q, r));
        m->triangles++;
        m->area += area;
        m->volume += six_volumes(p, q, r, centre) / 6.0;
        m->centre = sn_add_scaled(m->centre, sn_add(p, sn_add(q, r)), area / 3.0);
    }
    for (sn_index i = 0; i < count; i++) {
        if (measure[i].area > 0.0) measure[i].centre = sn_scale(measure[i].centre, 1.0 / measure[i].area);
    }
}

/* A component's number beside its area, to be sorted by area, largest first; equal ones keep their order. */
typedef struct ranked {
    double area;
    sn_index number;
} ranked;

static int larger_first(const void *left, const void *right) {
    const ranked *a = left, *b = right;
    if (a->area != b->area) return a->area > b->area ? -1 : 1;
    return (a->number > b->number) - (a->number < b->number);
}

static int larger_dropped_first(const void *left, const void *right) {
    const sn_dropped_component *a = left, *b = right;
    if (a->area != b->area) return a->area > b->area ? -1 : 1;
    if (a->centre.x != b->centre.x) return a->centre.x < b->centre.x ? -1 : 1;
    if (a->centre.y != b->centre.y) return a->centre.y < b->centre.y ? -1 : 1;
    return (a->centre.z > b->centre.z) - (a->centre.z < b->centre.z);
}

/* Which components stay (by number); the others are listed. */
static void keep_first(sn_cleaning *c, const ranked *order, sn_index count, const sn_dropped_component *measure, bool *stays) {
    for (sn_index i = 0; i < count; i++) {
        stays[order[i].number] = i < c->params->keep;
        if (i >= c->params->keep) c->report->dropped[c->report->dropped_count++] = measure[order[i].number];
    }
}

static sn_status keep_largest(sn_cleaning *c, const sn_topology *topology) {
    sn_index triangles = c->mesh->triangle_count, count = 0;
    sn_index *component = SN_NEW(sn_index, triangles);
    bool *keep = SN_NEW(bool, triangles);
    if (component != NULL) count = sn_mesh_components(c->mesh, topology, component);
    sn_dropped_component *measure = SN_NEW(sn_dropped_component, count);
    ranked *order = SN_NEW(ranked, count);
    bool *stays = SN_NEW(bool, count);
    sn_dropped_component *dropped = sn_realloc(c->report->dropped, (size_t)c->report->dropped_count + (size_t)count, sizeof *dropped);
    if (dropped != NULL) c->report->dropped = dropped;
    bool enough = component && keep && measure && order && stays && dropped;
    if (enough) {
        measure_components(c, component, count, measure);
        for (sn_index i = 0; i < count; i++) order[i] = (ranked){measure[i].area, i};
        qsort(order, (size_t)count, sizeof *order, larger_first);
        keep_first(c, order, count, measure, stays);
        for (sn_index t = 0; t < triangles; t++) keep[t] = stays[component[t]];
        sn_mesh_keep_triangles(c->mesh, keep);
        qsort(c->report->dropped, (size_t)c->report->dropped_count, sizeof *dropped, larger_dropped_first);
    }
    free(component);
    free(keep);
    free(measure);
    free(order);
    free(stays);
    return enough ? SN_OK : sn_fail_memory(c->error, "sorting components");
}

sn_status sn_cleaning_keep(sn_cleaning *c) {
    sn_index before = c->found.components;
    sn_status status = SN_OK;
    if (c->params->keep > 0 && before > c->params->keep) {
        sn_topology topology;
        sn_index unused = 0;
        status = sn_topology_build(c->mesh, &topology, c->error);
        if (status == SN_OK) status = keep_largest(c, &topology);
        sn_topology_free(&topology);
        if (status == SN_OK) status = sn_drop_unused_vertices(c->mesh, &unused, c->error);
        if (status == SN_OK) status = sn_cleaning_look(c);
    }
    if (status != SN_OK) return status;
    return sn_stop_if(
        SN_TRACE(c->trace, "components", sn_trace_number("found", before), sn_trace_number("dropped", c->report->dropped_count)));
}
