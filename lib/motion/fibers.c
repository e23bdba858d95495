/* fibers.c -- the fibres of a muscle in one array, and their lengths. */
#include "sinew/fibers.h"

#include <stdlib.h>

static sn_status check_fibers(const sn_fibers *fibers, int64_t *points, sn_error *error) {
    *points = 0;
    if (fibers->polyline_count == 0) return sn_fail(error, SN_ERROR_INPUT, "the muscle has no fibres (fiber-fill makes them)");
    for (sn_index i = 0; i < fibers->polyline_count; i++) {
        const sn_polyline *line = &fibers->polylines[i];
        if (line->count < 2) return sn_fail(error, SN_ERROR_INPUT, "fibre %d has fewer than two points", i);
        for (sn_index k = 0; k < line->count; k++)
            if (!sn_finite3(line->points[k])) return sn_fail(error, SN_ERROR_INPUT, "fibre %d has a point that is not finite", i);
        *points += line->count;
    }
    return *points <= SN_INDEX_MAX ? SN_OK : sn_fail(error, SN_ERROR_MEMORY, "more fibre vertices than sinew can count");
}

static sn_status check_lengths(const sn_fiber_bundle *bundle, sn_error *error) {
    for (sn_index i = 0; i < bundle->fiber_count; i++)
        if (!(bundle->rest_length[i] > 0.0)) return sn_fail(error, SN_ERROR_INPUT, "fibre %d has no length", i);
    return SN_OK;
}

sn_status sn_fiber_bundle_create(const sn_fibers *fibers, sn_fiber_bundle *out, sn_error *error) {
    int64_t points;
    *out = (sn_fiber_bundle){0};
    sn_status status = check_fibers(fibers, &points, error);
    if (status != SN_OK) return status;
    out->fiber_count = fibers->polyline_count;
    out->point_count = (sn_index)points;
    out->start = SN_NEW(sn_index, out->fiber_count + 1);
    out->points = SN_NEW(sn_vec3, out->point_count);
    out->rest_length = SN_NEW(double, out->fiber_count);
    if (out->start == NULL || out->points == NULL || out->rest_length == NULL) {
        sn_fiber_bundle_free(out);
        return sn_fail_memory(error, "the fibres");
    }
    for (sn_index i = 0; i < out->fiber_count; i++) {
        const sn_polyline *line = &fibers->polylines[i];
        for (sn_index k = 0; k < line->count; k++) out->points[out->start[i] + k] = line->points[k];
        out->start[i + 1] = out->start[i] + line->count;
    }
    sn_fiber_lengths(out, out->points, out->rest_length);
    status = check_lengths(out, error);
    if (status != SN_OK) sn_fiber_bundle_free(out);
    return status;
}

void sn_fiber_bundle_free(sn_fiber_bundle *bundle) {
    free(bundle->start);
    free(bundle->points);
    free(bundle->rest_length);
    *bundle = (sn_fiber_bundle){0};
}

void sn_fiber_lengths(const sn_fiber_bundle *bundle, const sn_vec3 *points, double *lengths) {
    for (sn_index i = 0; i < bundle->fiber_count; i++) {
        lengths[i] = 0.0;
        for (sn_index k = bundle->start[i] + 1; k < bundle->start[i + 1]; k++) lengths[i] += sn_distance(points[k - 1], points[k]);
    }
}
