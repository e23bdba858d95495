/*
 * samples.c -- which samples of the internal structure become points.
 *
 * A sample on which no vertex hangs would be a joint in the middle of nowhere: under pressure its chain buckles there to any side, under no
 * force but its own inertia, and a solve creeps after it without end. It is left out; its neighbours are joined to each other instead, as
 * if it and the first that is kept below it (at the root), or the next one above it (elsewhere), were one.
 */
#include "rows.h"

#include <stdlib.h>

/* The points of the samples on which vertices hang; returns how many there are. */
static sn_index number_samples(sn_build *build) {
    const sn_structure *structure = &build->source->rig.structure;
    sn_index n = structure->sample_count, next = build->model->vertex_count;
    for (sn_index i = 0; i < n; i++) build->sample_points[i] = SN_NONE;
    for (sn_index v = 0; v < build->model->vertex_count; v++) {
        sn_index sample = structure->vertex_sample[v];
        if (sample != SN_NONE) build->sample_points[sample] = next;
    }
    for (sn_index i = 0; i < n; i++)
        if (build->sample_points[i] != SN_NONE) build->sample_points[i] = next++;
    return next - build->model->vertex_count;
}

/* The kept sample that stands for the parent of each; SN_NONE: nothing is above it. stands_for (samples): scratch. */
static void join_kept(sn_build *build, sn_index *stands_for) {
    const sn_structure *structure = &build->source->rig.structure;
    for (sn_index i = 0; i < structure->sample_count; i++) {
        sn_index parent = structure->parents[i], above = parent == SN_NONE ? SN_NONE : stands_for[parent];
        bool kept = build->sample_points[i] != SN_NONE;
        stands_for[i] = kept ? i : above;
        build->sample_parents[i] = kept ? above : SN_NONE;
        for (; kept && parent != SN_NONE && stands_for[parent] == SN_NONE; parent = structure->parents[parent]) stands_for[parent] = i;
    }
}

sn_status sn_samples_build(sn_build *build, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_index n = build->plan->samples, *scratch = SN_NEW(sn_index, n);
    build->sample_points = SN_NEW(sn_index, n);
    build->sample_parents = SN_NEW(sn_index, n);
    m->samples = SN_NEW(sn_index, n);
    if (scratch == NULL || build->sample_points == NULL || build->sample_parents == NULL || m->samples == NULL) {
        free(scratch);
        return sn_fail_memory(error, "the internal structure");
    }
    if (n > 0) {
        build->plan->samples = number_samples(build);
        build->plan->bare_samples = n - build->plan->samples;
        join_kept(build, scratch);
    }
    for (sn_index i = 0; i < n; i++)
        if (build->sample_points[i] != SN_NONE) m->samples[build->sample_points[i] - m->vertex_count] = i;
    free(scratch);
    return SN_OK;
}

void sn_samples_release(sn_build *build) {
    free(build->sample_points);
    free(build->sample_parents);
    build->sample_points = build->sample_parents = NULL;
}

/* The mean over the vertices that hang on each sample; at least one does on those that are points. */
static void spread_to_samples(sn_build *build, sn_index *hung) {
    const sn_structure *structure = &build->source->rig.structure;
    sn_index first = build->model->vertex_count, count = build->model->point_count;
    for (sn_index v = 0; count > first && v < first; v++) {
        sn_index sample = structure->vertex_sample[v], point = sample != SN_NONE ? build->sample_points[sample] : SN_NONE;
        if (point == SN_NONE) continue;
        build->tendon[point] += build->tendon[v];
        hung[point]++;
    }
    for (sn_index p = first; p < count; p++) build->tendon[p] /= hung[p] > 0 ? hung[p] : 1;
}

sn_status sn_tendons_of_points(sn_build *build, sn_error *error) {
    if (build->source->tendon_map == NULL) return SN_OK;
    sn_index *hung = SN_NEW(sn_index, build->model->point_count);
    build->tendon = SN_NEW(double, build->model->point_count);
    if (hung == NULL || build->tendon == NULL) {
        free(hung);
        return sn_fail_memory(error, "the tendons of a muscle");
    }
    const double *values = sn_mesh_attribute(&build->source->rig.mesh, build->source->tendon_map)->values;
    for (sn_index v = 0; v < build->model->vertex_count; v++) build->tendon[v] = values[v];
    spread_to_samples(build, hung);
    free(hung);
    return SN_OK;
}
