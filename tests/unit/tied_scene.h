/*
 * tied_scene.h -- muscles that touch, for the tests of external constraints: candidates as attach-detect finds them, made in memory.
 */
#ifndef TIED_SCENE_H
#define TIED_SCENE_H

#include "sim_scene.h"
#include "sinew/rig.h"

/* Types of external constraints: slide, soft, hard. */
static const double SLIDE[3] = {1, 0, 0}, SOFT[3] = {0, 1, 0}, HARD[3] = {0, 0, 1}, MIXED[3] = {0.5, 0.25, 0.75};

/* Within which vertices are tied, m. */
static const double TIED_REACH = 0.02;

/* Candidates of a muscle of the scene to meshes in its unit. */
static inline void tie_within(double reach, sn_scene_muscle *muscle, sn_index count, const sn_neighbour *targets, const double weights[3]) {
    sn_neighbours_params params = sn_neighbours_defaults();
    params.target_count = count, params.targets = targets;
    params.reach = reach / muscle->rig.meters_per_unit;
    memcpy(params.weights, weights, sizeof params.weights);
    sn_externals_free(muscle->rig.externals, muscle->rig.external_count);
    muscle->rig.has_externals = true;
    sn_neighbours_found found;
    assert_int_equal(sn_find_neighbours(&muscle->rig, &params, NULL, &found, NULL), SN_OK);
    muscle->rig.externals = found.items, muscle->rig.external_count = found.count; /* taken */
}

static inline void tie(sn_scene_muscle *muscle, sn_index count, const sn_neighbour *targets, const double weights[3]) {
    tie_within(TIED_REACH, muscle, count, targets, weights);
}

/* Each muscle of the scene to all others, and external constraints on. */
static inline void tie_all(double reach, sn_scene *scene, const double weights[3]) {
    sn_neighbour *others = SN_NEW(sn_neighbour, scene->muscle_count);
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        sn_index count = 0;
        for (sn_index k = 0; k < scene->muscle_count; k++)
            if (k != i) others[count++] = (sn_neighbour){scene->muscles[k].name, &scene->muscles[k].rig.mesh, false};
        tie_within(reach, &scene->muscles[i], count, others, weights);
        assert_true(scene->muscles[i].rig.external_count > 0);
    }
    scene->externals.enabled = true;
    free(others);
}

#endif
