/*
 * flow_nearest.c -- the tangent of the nearest fibre at every vertex ([K21] 3.1). Runs of segments are looked at only where their box is
 * nearer than the best so far, the run that served the vertex before first: neighbours in a file are most often neighbours in space.
 */
#include <stdlib.h>

#include "flow.h"

enum { RUN = 8 }; /* segments in a run */

typedef struct run {
    const sn_vec3 *points; /* count + 1 */
    sn_index count;        /* segments */
    sn_box box;
} run;

typedef struct nearest {
    double distance2;
    sn_vec3 tangent;
} nearest;

static run *make_runs(sn_index line_count, const sn_polyline *lines, sn_index *count) {
    size_t total = 0;
    for (sn_index i = 0; i < line_count; i++) total += (size_t)lines[i].count / RUN + 1;
    run *runs = SN_NEW(run, total);
    *count = 0;
    for (sn_index i = 0; runs && i < line_count; i++)
        for (sn_index first = 0; first + 1 < lines[i].count; first += RUN) {
            sn_index left = lines[i].count - 1 - first;
            run *r = &runs[(*count)++];
            *r = (run){.points = lines[i].points + first, .count = left < RUN ? left : RUN};
            r->box.low = r->box.high = r->points[0];
            for (sn_index k = 1; k <= r->count; k++) {
                r->box.low = sn_min3(r->box.low, r->points[k]);
                r->box.high = sn_max3(r->box.high, r->points[k]);
            }
        }
    return runs;
}

static double box_distance2(const sn_box *box, sn_vec3 p) {
    sn_vec3 inside = sn_max3(box->low, sn_min3(box->high, p));
    return sn_norm2(sn_sub(p, inside));
}

static void look_along(const run *r, sn_vec3 point, nearest *best) {
    for (sn_index k = 0; k < r->count; k++) {
        sn_vec3 along = sn_sub(r->points[k + 1], r->points[k]), from = sn_sub(point, r->points[k]);
        double length2 = sn_norm2(along);
        if (!(length2 > 0.0)) continue;
        double t = fmin(1.0, fmax(0.0, sn_dot(from, along) / length2));
        double distance2 = sn_norm2(sn_sub(from, sn_scale(along, t)));
        if (!(distance2 < best->distance2)) continue;
        best->distance2 = distance2;
        best->tangent = along;
    }
}

sn_status nearest_tangents(const sn_mesh *mesh, sn_index count, const sn_polyline *polylines, sn_vec3 *directions, double *farthest,
                           sn_error *error) {
    sn_index run_count = 0, last = 0;
    run *runs = make_runs(count, polylines, &run_count);
    if (!runs) return sn_fail_memory(error, "the fibres");
    *farthest = 0.0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 point = mesh->positions[v];
        nearest best = {.distance2 = INFINITY};
        if (run_count > 0) look_along(&runs[last], point, &best);
        for (sn_index i = 0; i < run_count; i++) {
            if (!(box_distance2(&runs[i].box, point) < best.distance2)) continue;
            double before = best.distance2;
            look_along(&runs[i], point, &best);
            if (best.distance2 < before) last = i;
        }
        directions[v] = best.tangent;
        *farthest = fmax(*farthest, sqrt(best.distance2));
    }
    free(runs);
    return SN_OK;
}
