/* eigen_tips.c -- the ends of a muscle by the slowest vibration of its surface. Apart from tips.c: its users need no sparse solver. */
#include <stdlib.h>

#include "tips.h"

static void take_extremes(sn_index count, const double *u, tips *out) {
    sn_index low = 0, high = 0;
    for (sn_index v = 1; v < count; v++) {
        if (u[v] < u[low]) low = v;
        if (u[v] > u[high]) high = v;
    }
    out->end[0] = low < high ? low : high;
    out->end[1] = low < high ? high : low;
}

sn_status find_tips_by_eigenfunction(const sn_mesh *mesh, const sn_topology *topology, const surface_survey *survey, sn_trace *trace,
                                     tips *out, sn_error *error) {
    *out = (tips){.eigen = true};
    if (survey->components != 1)
        return sn_fail(
            error, SN_ERROR_INPUT,
            "the surface has %d components, and an eigenfunction needs one; run mesh-clean --keep largest, or take the tips by sweeps",
            (int)survey->components);
    double *u = SN_NEW(double, mesh->vertex_count);
    if (!u) return sn_fail_memory(error, "the slowest vibration of the surface");
    sn_status status = sn_geodesic_distance(mesh, topology, 1, &survey->main_vertex, u, error);
    if (!status) status = sn_fiedler_field(mesh, topology, u, error);
    if (!status) {
        take_extremes(mesh->vertex_count, u, out);
        status = sn_geodesic_distance(mesh, topology, 1, &out->end[0], u, error);
        out->length = u[out->end[1]];
    }
    if (!status && SN_TRACE(trace, "eigenfunction", sn_trace_number("from", out->end[0]), sn_trace_number("to", out->end[1]),
                            sn_trace_number("length", out->length)))
        status = SN_STOPPED;
    free(u);
    return status;
}
