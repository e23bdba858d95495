/* tips.c -- components and genus by Euler's formula, ends by repeated sweeps along the surface. */
#include "tips.h"

#include <stdlib.h>

/* ---- survey --------------------------------------------------------------------------------------------------------- */

/* chi = V - E + F = 2 (components - genus) on closed surfaces. */
static double genus_of(const sn_topology *t, sn_index components) {
    sn_index used = 0;
    for (sn_index v = 0; v < t->vertex_count; v++) used += t->corner_start[v + 1] > t->corner_start[v];
    for (sn_index e = 0; e < t->edge_count; e++)
        if (t->edges[e].triangle_count != 2) return NAN;
    return (double)components - 0.5 * ((double)used - (double)t->edge_count + (double)t->triangle_count);
}

static sn_index lowest_vertex(const sn_mesh *mesh, const sn_index *component, sn_index which) {
    sn_index lowest = SN_INDEX_MAX;
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; component[t] == which && c < 3; c++)
            if (mesh->triangles[t].v[c] < lowest) lowest = mesh->triangles[t].v[c];
    return lowest;
}

sn_status survey_surface(const sn_mesh *mesh, const sn_topology *topology, surface_survey *out, sn_error *error) {
    sn_index *component = SN_NEW(sn_index, mesh->triangle_count), *size = SN_NEW(sn_index, mesh->triangle_count);
    sn_status status = SN_OK;
    if (component && size) {
        out->components = sn_mesh_components(mesh, topology, component);
        out->genus = genus_of(topology, out->components);
        sn_index largest = 0;
        for (sn_index t = 0; t < mesh->triangle_count; t++) size[component[t]]++;
        for (sn_index c = 1; c < out->components; c++)
            if (size[c] > size[largest]) largest = c;
        out->main_vertex = lowest_vertex(mesh, component, largest);
    } else {
        status = sn_fail_memory(error, "the components of the surface");
    }
    free(component);
    free(size);
    return status;
}

/* ---- tips ----------------------------------------------------------------------------------------------------------- */

enum { MAX_SWEEPS = 32 }; /* the length grows with every sweep but the last; real muscles need three to six */
#define CONVERGED_GROWTH 1e-3

static sn_index farthest(sn_index count, const double *distance) {
    sn_index best = SN_NONE;
    for (sn_index v = 0; v < count; v++)
        if (isfinite(distance[v]) && (best == SN_NONE || distance[v] > distance[best])) best = v;
    return best;
}

sn_status find_tips(const sn_mesh *mesh, const sn_topology *topology, sn_index seed, sn_trace *trace, tips *out, sn_error *error) {
    double *distance = SN_NEW(double, mesh->vertex_count);
    if (!distance) return sn_fail_memory(error, "the distances along the surface");
    sn_index here = seed, ends[2] = {seed, seed};
    double length = 0.0;
    sn_status status = SN_OK;
    for (int sweep = 0; sweep < MAX_SWEEPS && !status; sweep++) {
        status = sn_geodesic_distance(mesh, topology, 1, &here, distance, error);
        if (status) break;
        sn_index there = farthest(mesh->vertex_count, distance);
        double reach = distance[there];
        bool converged = sweep > 1 && reach <= length * (1.0 + CONVERGED_GROWTH);
        if (reach > length || sweep == 0) {
            ends[0] = here;
            ends[1] = there;
            length = reach;
        }
        if (SN_TRACE(trace, "sweep", sn_trace_number("from", here), sn_trace_number("to", there), sn_trace_number("length", reach)))
            status = SN_STOPPED;
        if (converged) break;
        here = there;
    }
    free(distance);
    *out = (tips){.end = {ends[0] < ends[1] ? ends[0] : ends[1], ends[0] < ends[1] ? ends[1] : ends[0]}, .length = length};
    return status;
}
