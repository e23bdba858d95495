/*
 * states.h -- small models of every back end, whose states are forged, and the seal on a state: its checksum.
 */
#ifndef FUZZ_STATES_H
#define FUZZ_STATES_H

#include "../unit/contact_scene.h"
#include "../unit/tied_scene.h"

#include <stdio.h>

/* As in restart.c: magic and version, the checksum of what follows, the model's fingerprint, then the frame. */
enum { SEAL = 12 + sizeof(int32_t), HEADER = SEAL + SN_HASH_LENGTH, MOMENT = HEADER + SN_HASH_LENGTH };

typedef struct state_model {
    const char *name;
    sn_solver_method method;
    sn_precision precision;
    sn_preconditioning preconditioner;
    sn_stretch stretch;
    sn_index substeps, iterations;
    bool contact;    /* with distance fields */
    sn_index voxels; /* with voxels, so many along each axis of a bone; 0 = none */
    bool tied;       /* to each other */
} state_model;

static const state_model MODELS[] = {
    {"xpbd", SN_SOLVER_XPBD, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, false, 0, false},
    {"xpbd, single", SN_SOLVER_XPBD, SN_PRECISION_SINGLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, false, 0, false},
    {"xpbd, voxels", SN_SOLVER_XPBD, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, false, 8, false},
    {"qn, scalar", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 2, 6, false, 0, false},
    {"qn, scalar, membrane", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_MEMBRANE, 2, 6, false, 0, false},
    {"qn, corotated", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_COROTATED, SN_STRETCH_SPRINGS, 2, 6, false, 0, false},
    {"qn, two-level", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_TWO_LEVEL, SN_STRETCH_SPRINGS, 2, 6, false, 0, false},
    {"xpbd, contact", SN_SOLVER_XPBD, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, true, 0, false},
    {"xpbd, single, contact", SN_SOLVER_XPBD, SN_PRECISION_SINGLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, true, 0, false},
    {"qn, contact", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 2, 6, true, 0, false},
    {"xpbd, tied", SN_SOLVER_XPBD, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 4, 3, false, 0, true},
    {"qn, tied", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_SCALAR, SN_STRETCH_SPRINGS, 2, 6, false, 0, true},
    {"qn, two-level, tied, contact", SN_SOLVER_QN, SN_PRECISION_DOUBLE, SN_PRECONDITION_TWO_LEVEL, SN_STRETCH_SPRINGS, 2, 6, true, 0, true},
};
enum { MODEL_COUNT = sizeof MODELS / sizeof *MODELS };

/* Two muscles of a few rings, one of them without internal structure and with fewer iterations, between two bones that turn. */
static void make_model(const state_model *from, sn_scene *scene, simulation *out) {
    fusiform small = FUSIFORM, bare = FUSIFORM;
    small.rings = 6, small.sectors = 4, small.pinned = 0.2;
    bare.rings = 3, bare.sectors = 3, bare.structure = false, bare.pinned = 0.2;
    if (from->tied) bare.offset.x = 0.04;
    make_scene(scene, &small);
    add_muscle(scene, "bare", &bare);
    scene->solver = sn_solver_defaults(from->method);
    scene->solver.precision = from->precision;
    scene->solver.preconditioner = from->preconditioner;
    scene->solver.substeps = from->substeps;
    scene->solver.iterations = from->iterations;
    scene->solver.threads = 1;
    scene->muscles[1].iterations = 1;
    scene->last_frame = 8;
    for (sn_index i = 0; i < scene->muscle_count; i++) scene->muscles[i].stretch = from->stretch;
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 0.3, 1.0);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.3, 0.5);
    if (from->voxels > 0) {
        scene->solver.scheme = SN_SCHEME_KOHOUT;
        scene->contact.enabled = true;
        scene->contact.voxels = from->voxels;
        scene->bones[0].passable = true;
        give_bone_cube(&scene->bones[1], sn_v3(0, 0.03, 0.08), 0.02);
    }
    if (from->tied) tie_all(2.0 * TIED_REACH, scene, MIXED);
    if (from->contact) {
        capsule rod = {{{0.055, -0.08, 0.1}, {0.055, 0.08, 0.1}}, 0.02};
        turn_contact_on(scene);
        scene->contact.resolve = 0.2;
        make_capsule(&rod, 4, add_solid(scene, "rod", keys_to(0.0, 0.2, shifted(sn_v3(-0.02, 0, 0))), 2));
    }
    *out = start(scene);
}

/* Make the checksum right. */
static void seal(char *bytes, size_t size) {
    char hash[SN_HASH_LENGTH];
    sn_hash(bytes + HEADER, size - HEADER, hash);
    memcpy(bytes + SEAL, hash, sizeof hash);
}

/* Read a state; where it is taken, take a step from it. What is wrong with the answer; NULL = nothing. */
static const char *try_state(simulation *s, const char *bytes, size_t size, sn_status *status, sn_error *error) {
    *error = (sn_error){0};
    *status = sn_state_unpack(s->model, bytes, size, s->state, error);
    if (*status == SN_OK) return sn_step(s->model, s->state, NULL, error) == SN_OK ? NULL : "no step leads on from it";
    if (*status != SN_ERROR_INPUT && *status != SN_ERROR_USAGE) return "the status is none of bad input"; /* usage: of another rate */
    return error->text[0] == '\0' || strpbrk(error->text, "\r\n") != NULL ? "the error is not one line" : NULL;
}

#endif
