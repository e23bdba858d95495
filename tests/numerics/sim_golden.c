/*
 * sim_golden.c -- one hash of a run's end under each back end, the same from 1, 2 and 4 threads, from a run that is watched and from one
 * that stops anywhere, in the middle of a substep too, and goes on from bytes, of muscles that are tied from one with these in another
 * order; and the same as in tests/data/golden.txt, whatever the
 * machine and the build. Prints "hash SOLVER HASH" for each, then "N passed, N failed".
 *
 *   sim_golden [FILE]              compare with FILE instead
 *   sim_golden --hashes THREADS    print the hashes of that many threads and do nothing else: tests/golden, `make golden-accept`
 */
#include "../unit/contact_scene.h"
#include "../unit/tied_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int passed, failed;

static const struct {
    const char *name;
    sn_solver_method method;
    sn_preconditioning preconditioner;
    sn_stretch stretch; /* of the muscles that can have it */
    sn_precision precision;
    sn_scheme scheme;
    sn_hinge_rule hinges;
    bool contact;    /* with distance fields */
    sn_index voxels; /* with voxels, so many along each axis of a bone; 0 = none */
    bool tied;       /* side by side, each to the other two: one group */
} SOLVERS[] = {{.name = "xpbd", .method = SN_SOLVER_XPBD},
               {.name = "xpbd-single", .method = SN_SOLVER_XPBD, .precision = SN_PRECISION_SINGLE},
               {.name = "xpbd-kohout", .method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_KOHOUT},
               {.name = "xpbd-kohout-printed", .method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_KOHOUT, .hinges = SN_HINGES_PRINTED},
               {.name = "xpbd-kohout-single", .method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_KOHOUT, .precision = SN_PRECISION_SINGLE},
               {.name = "xpbd-kohout-voxels", .method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_KOHOUT, .voxels = 16},
               {.name = "qn-scalar", .method = SN_SOLVER_QN},
               {.name = "qn-corotated", .method = SN_SOLVER_QN, .preconditioner = SN_PRECONDITION_COROTATED},
               {.name = "qn-two-level", .method = SN_SOLVER_QN, .preconditioner = SN_PRECONDITION_TWO_LEVEL},
               {.name = "qn-membrane", .method = SN_SOLVER_QN, .stretch = SN_STRETCH_MEMBRANE},
               {.name = "xpbd-contact", .method = SN_SOLVER_XPBD, .contact = true},
               {.name = "xpbd-single-contact", .method = SN_SOLVER_XPBD, .precision = SN_PRECISION_SINGLE, .contact = true},
               {.name = "qn-scalar-contact", .method = SN_SOLVER_QN, .contact = true},
               {.name = "qn-corotated-contact", .method = SN_SOLVER_QN, .preconditioner = SN_PRECONDITION_COROTATED, .contact = true},
               {.name = "qn-two-level-contact", .method = SN_SOLVER_QN, .preconditioner = SN_PRECONDITION_TWO_LEVEL, .contact = true},
               {.name = "xpbd-tied", .method = SN_SOLVER_XPBD, .tied = true},
               {.name = "xpbd-romeo-tied", .method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_ROMEO, .tied = true},
               {.name = "xpbd-tied-contact", .method = SN_SOLVER_XPBD, .contact = true, .tied = true},
               {.name = "qn-scalar-tied", .method = SN_SOLVER_QN, .tied = true},
               {.name = "qn-two-level-tied", .method = SN_SOLVER_QN, .preconditioner = SN_PRECONDITION_TWO_LEVEL, .tied = true},
               {.name = "qn-scalar-tied-contact", .method = SN_SOLVER_QN, .contact = true, .tied = true}};
static int solver; /* index of SOLVERS */

/* The lower bone is a cube that lies in the muscles at rest, and is swung through them. */
static void collide(sn_scene *scene) {
    scene->contact.enabled = true;
    scene->contact.voxels = SOLVERS[solver].voxels;
    scene->bones[0].passable = true;
    give_bone_cube(&scene->bones[1], sn_v3(0, 0.04, 0.08), 0.02);
}

/* A rod that comes into the muscles and turns, and a ball in them at rest: margins that grow, samples, friction under xpbd. */
static void add_bones(sn_scene *scene) {
    capsule rod = {{{0.055, -0.08, 0.1}, {0.055, 0.08, 0.1}}, 0.02}, ball = {{{-0.04, 0, 0.1}, {-0.04, 0, 0.1}}, 0.02};
    sn_quat turn = sn_quat_axis_angle(sn_v3(0, 0, 1), 0.3);
    turn_contact_on(scene);
    scene->contact.friction = SOLVERS[solver].method == SN_SOLVER_XPBD ? 0.3 : 0.0;
    scene->contact.resolve = 0.3;
    scene->contact.samples = 1;
    make_capsule(&rod, 6, add_solid(scene, "rod", keys_to(0.0, 0.4, (sn_rigid){turn, {-0.02, 0, 0}}), 2));
    make_capsule(&ball, 6, add_solid(scene, "ball", NULL, 0));
}

/* The order of the muscles in the scene turned round. */
static void turn_round(sn_scene *scene) {
    sn_scene_muscle first = scene->muscles[0];
    scene->muscles[0] = scene->muscles[2], scene->muscles[2] = first;
}

/* Three muscles that use every kind of row, every law, and every factor on a row. */
static void make_everything(sn_scene *scene) {
    fusiform small = FUSIFORM, other = FUSIFORM;
    small.rings = 13, small.sectors = 11, small.structure = false;
    if (SOLVERS[solver].tied) small.offset.x = 0.062, other.offset = sn_v3(0.031, 0.054, 0);
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(SOLVERS[solver].method);
    scene->solver.preconditioner = SOLVERS[solver].preconditioner;
    scene->solver.precision = SOLVERS[solver].precision;
    scene->solver.scheme = SOLVERS[solver].scheme;
    scene->solver.hinges = SOLVERS[solver].hinges;
    if (SOLVERS[solver].method == SN_SOLVER_QN) scene->solver.substeps = 2;
    if (SOLVERS[solver].voxels > 0) collide(scene);
    add_muscle(scene, "isochoric", &small);
    add_muscle(scene, "paper", &other);
    if (SOLVERS[solver].tied) tie_all(TIED_REACH, scene, MIXED);
    scene->muscles[0].anisotropy = SOLVERS[solver].method == SN_SOLVER_XPBD ? SN_ANISOTROPY_PBD : SN_ANISOTROPY_XPBD;
    scene->muscles[1].law = SN_LAW_ISOCHORIC;
    scene->muscles[1].anisotropy = SN_ANISOTROPY_XPBD;
    scene->muscles[0].stretch = scene->muscles[1].stretch = SOLVERS[solver].stretch;
    scene->muscles[2].law = SN_LAW_PAPER;
    scene->muscles[2].iterations = 3;
    for (int i = 0; i < 3; i++) set_keys(&scene->muscles[i].activation, 0.0, 0.0, 0.5, 0.6 + 0.2 * i);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, -1.0);
    scene->gravity = sn_v3(0, -9.81, 0);
    if (SOLVERS[solver].contact) add_bones(scene);
}

static void ignore(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    (void)user, (void)number, (void)stage, (void)values, (void)value_count;
}

/* Away to other memory and back, as a state file does. */
static void pass_through_bytes(simulation *s) {
    char *bytes;
    size_t size;
    assert_int_equal(sn_state_pack(s->model, s->state, &bytes, &size, NULL), SN_OK);
    sn_state_destroy(s->model, s->state);
    assert_int_equal(sn_state_create(s->model, &s->state, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s->model, bytes, size, s->state, NULL), SN_OK);
    free(bytes);
}

/* Where the first and the second piece of a frame end. */
static void stop_at(sn_step_options *options, int piece, sn_index frame) {
    bool qn = SOLVERS[solver].method == SN_SOLVER_QN;
    options->stop_substep = qn ? 1 + piece : 3 + 5 * piece + frame % 4;
    options->stop_iteration = qn ? 1 + (3 * piece + frame) % 9 : 1 + (piece + frame) % 2;
}

/* Of a run. */
enum { PLAIN = 0, WATCHED = 1, STOPS = 2, TURNED = 4 };

/* 12 frames; with STOPS, each of them in pieces. The hash of positions and velocities of all points; of TURNED in the order of the others.
 */
static void run(int threads, int how, char hash[SN_HASH_LENGTH]) {
    sn_scene scene;
    bool watched = how & WATCHED, stops = how & STOPS;
    make_everything(&scene);
    if (how & TURNED) turn_round(&scene);
    simulation s = start(&scene);
    sn_trace trace = {.receive = ignore, .stop_after = -1};
    sn_step_options options = {.pool = sn_pool_create(threads), .trace = watched ? &trace : NULL};
    for (sn_index frame = 0; frame < 12; frame++) {
        for (int piece = 0; stops && piece < 2; piece++) {
            stop_at(&options, piece, frame);
            assert_int_equal(sn_step(s.model, s.state, &options, NULL), SN_STOPPED);
            pass_through_bytes(&s);
        }
        options.stop_substep = options.stop_iteration = 0;
        assert_int_equal(sn_step(s.model, s.state, &options, NULL), SN_OK);
    }
    char hashes[3 * 2 * SN_HASH_LENGTH];
    for (sn_index i = 0; i < 3; i++) {
        const sn_index of = how & TURNED ? 2 - i : i;
        size_t n = (size_t)s.model->muscles[of].point_count;
        sn_hash(s.state->muscles[of].points, n * sizeof(sn_point), hashes + (size_t)(2 * i) * SN_HASH_LENGTH);
        sn_hash(s.state->muscles[of].velocities, n * sizeof(sn_vec3), hashes + (size_t)(2 * i + 1) * SN_HASH_LENGTH);
    }
    sn_hash(hashes, sizeof hashes, hash);
    sn_pool_destroy(options.pool);
    finish(&s);
}

static void count(const char *name, bool good, const char *verdict) {
    printf("%-19s %-40s %s\n", SOLVERS[solver].name, name, verdict);
    if (good)
        passed++;
    else
        failed++;
}

static void compare(const char *name, const char *one, const char *other) {
    bool same = memcmp(one, other, SN_HASH_LENGTH) == 0;
    count(name, same, same ? "the same" : "FAILED: not the same");
}

/* With the line "SOLVER HASH" of the file. */
static void compare_with_file(const char *file, const char *hash) {
    char name[64], accepted[SN_HASH_LENGTH + 1];
    const char *verdict = "FAILED: no accepted hash";
    FILE *in = fopen(file, "r");
    while (in != NULL && fscanf(in, "%63s %72s", name, accepted) == 2)
        if (strcmp(name, SOLVERS[solver].name) == 0)
            verdict = strcmp(accepted, hash) == 0 ? "the same" : "FAILED: other bits than accepted (if they should be: make golden-accept)";
    if (in != NULL) fclose(in);
    count(file, strcmp(verdict, "the same") == 0, verdict);
}

static void print_hash(int threads, char hash[SN_HASH_LENGTH]) {
    run(threads, PLAIN, hash);
    printf("hash %s %s\n", SOLVERS[solver].name, hash);
}

static void all_runs(const char *file) {
    char hash[SN_HASH_LENGTH], other[SN_HASH_LENGTH];
    print_hash(1, hash);
    compare_with_file(file, hash);
    for (int threads = 2; threads <= 4; threads += 2) {
        run(threads, PLAIN, other);
        compare(threads == 2 ? "2 threads" : "4 threads", hash, other);
    }
    run(2, WATCHED, other);
    compare("watched", hash, other);
    run(1, STOPS, other);
    compare("stopped, packed and continued", hash, other);
    if (!SOLVERS[solver].tied) return;
    run(2, TURNED, other);
    compare("muscles in another order", hash, other);
}

int main(int argc, char **argv) {
    int threads = argc == 3 && strcmp(argv[1], "--hashes") == 0 ? atoi(argv[2]) : 0;
    const char *file = argc > 1 ? argv[1] : "tests/data/golden.txt";
    char hash[SN_HASH_LENGTH];
    for (solver = 0; solver < (int)(sizeof SOLVERS / sizeof *SOLVERS); solver++) {
        if (threads > 0)
            print_hash(threads, hash);
        else
            all_runs(file);
    }
    if (threads <= 0) printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
