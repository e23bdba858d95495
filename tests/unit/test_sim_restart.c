/*
 * test_sim_restart.c -- a state read back: every number that no run comes to is refused, whatever the checksum says, and nothing is
 * changed.
 */
#include "sim_inside.h"

typedef struct numbers {
    sn_state *state;
    sn_group_state *group; /* the first */
    sn_muscle_state *muscle;
    sn_inputs *inputs;
    sn_qn *qn;     /* as the back end is */
    sn_xpbd *xpbd; /* the same */
    sn_index points;
} numbers;

/* ---- what may be wrong with one ------------------------------------------------------------------------------------------------- */

static void set_byte(bool *flag, int value) { memset(flag, value, 1); }

static void frame_beyond(numbers n) { n.state->frame = SN_FRAME_LIMIT + 1; }
static void frame_below(numbers n) { n.state->frame = INT32_MIN; }
static void substep_negative(numbers n) { n.state->substep = -1; }
static void substep_beyond(numbers n) { n.state->substep = 2; }
static void substep_greatest(numbers n) { n.state->substep = INT32_MAX; }
static void iteration_negative(numbers n) { n.state->iteration = -1; }
static void iteration_beyond(numbers n) { n.state->iteration = 6; }
static void pairs_negative(numbers n) { n.qn->pair_count = -1; }
static void pairs_too_many(numbers n) { n.qn->pair_count = 9; }
static void next_pair_beyond(numbers n) { n.qn->pair_count = 8, n.qn->pair_next = 8; }
static void next_pair_negative(numbers n) { n.qn->pair_count = 8, n.qn->pair_next = INT32_MIN; }
static void next_pair_elsewhere(numbers n) { n.qn->pair_count = 1, n.qn->pair_next = 3; }
static void product_zero(numbers n) { n.qn->pair_products[0] = 0.0; }
static void product_negative(numbers n) { n.qn->pair_products[0] = -1.0; }
static void product_nan(numbers n) { n.qn->pair_products[0] = NAN; }
static void pair_infinite(numbers n) { n.qn->pair_steps[1].y = INFINITY; }
static void change_nan(numbers n) { n.qn->pair_changes[1].z = NAN; }
static void stopped_unknown(numbers n) { n.qn->stopped = (sn_stop_reason)4; }
static void stopped_negative(numbers n) { n.qn->stopped = (sn_stop_reason)-1; }
static void flag_two(numbers n) { set_byte(&n.qn->turned, 2); }
static void flag_high(numbers n) { set_byte(&n.qn->torn, 255); }
static void torn_and_turned(numbers n) { n.qn->torn = n.qn->turned = true; }
static void guard_two(numbers n) { set_byte(&n.inputs->guarded[3], 2); }
static void still_negative(numbers n) { n.group->still = -1; }
static void count_negative(numbers n) { n.muscle->statistics.skipped_edges = -1; }
static void count_full(numbers n) { n.muscle->statistics.iterations = INT64_MAX; }
static void activation_nan(numbers n) { n.inputs->activation = NAN; }
static void activation_above(numbers n) { n.inputs->activation = 1.5; }
static void contraction_below(numbers n) { n.inputs->contraction = -0.1; }
static void stiffness_negative(numbers n) { n.inputs->stiffness = -1.0; }
static void stiffness_infinite(numbers n) { n.inputs->stiffness = INFINITY; }
static void goal_nan(numbers n) { n.inputs->volume_goal = NAN; }
static void lambda_nan(numbers n) { n.xpbd->volume_lambda = NAN; }
static void factor_negative(numbers n) { n.qn->factor_stiffness[0] = -1.0; }
static void factor_infinite(numbers n) { n.qn->factor_stiffness[0] = INFINITY; }
static void residual_negative(numbers n) { n.muscle->statistics.residual = -1.0; }
static void position_nan(numbers n) { n.muscle->points[n.points - 1].y = NAN; }
static void weight_other(numbers n) { n.muscle->points[n.points - 1].w *= 1.0 + 1e-15; }
static void weight_zero(numbers n) { n.muscle->points[n.points - 1].w = 0.0; }
static void velocity_infinite(numbers n) { n.muscle->velocities[0].x = -INFINITY; }
static void lambda_of_a_row(numbers n) { n.xpbd->hinge_lambda[0] = NAN; }
static void target_nan(numbers n) { n.qn->target[2].x = NAN; }
static void pose_long(numbers n) { n.inputs->placed[0].rotation.w = 2.0; }
static void pose_away(numbers n) { n.inputs->placed[0].translation.x = NAN; }
static void frame_of_no_length(numbers n) { n.qn->turns[n.points - 1] = (sn_quat){0.5, 0, 0, 0}; }
static void section_nan(numbers n) { n.qn->section_points[0].x = NAN; }
static void single_weight(numbers n) { n.xpbd->single_points[n.points - 1].w *= 2.0F; }
static void single_nan(numbers n) { n.xpbd->single_points[0].z = NAN; }
static void origin_infinite(numbers n) { n.xpbd->origin->x = INFINITY; }

/* Of any model; then of those of qn alone, and so on. */
typedef enum needs { ANY, XPBD, QN, COROTATED, TWO_LEVEL, SINGLE, KINDS } needs;

static const struct {
    void (*forge)(numbers n);
    const char *word; /* of the error */
    needs needs;
} FORGERIES[] = {
    {frame_beyond, "frame 100000001", ANY},
    {frame_below, "frame -2147483648", ANY},
    {substep_negative, "substep 0", ANY},
    {substep_beyond, "substep 3", ANY},
    {substep_greatest, "substep 2147483648", ANY},
    {iteration_negative, "iteration -1", ANY},
    {iteration_beyond, "iteration 6", ANY},
    {pairs_negative, "pair_count", QN},
    {pairs_too_many, "pair_count", QN},
    {next_pair_beyond, "pair_next", QN},
    {next_pair_negative, "pair_next", QN},
    {next_pair_elsewhere, "pair_next", QN},
    {product_zero, "pair_products", QN},
    {product_negative, "pair_products", QN},
    {product_nan, "pair_products", QN},
    {pair_infinite, "pair_steps", QN},
    {change_nan, "pair_changes", QN},
    {stopped_unknown, "stopped", QN},
    {stopped_negative, "stopped", QN},
    {flag_two, "turned", QN},
    {flag_high, "torn", QN},
    {torn_and_turned, "torn", COROTATED},
    {guard_two, "guarded", QN},
    {still_negative, "still", ANY},
    {count_negative, "skipped_edges", ANY},
    {count_full, "iterations", ANY},
    {activation_nan, "activation", ANY},
    {activation_above, "activation", ANY},
    {contraction_below, "contraction", ANY},
    {stiffness_negative, "stiffness", ANY},
    {stiffness_infinite, "stiffness", ANY},
    {goal_nan, "volume_goal", ANY},
    {lambda_nan, "volume_lambda", XPBD},
    {factor_negative, "factor_stiffness", QN},
    {factor_infinite, "factor_stiffness", QN},
    {residual_negative, "residual", ANY},
    {position_nan, "points", ANY},
    {weight_other, "points", ANY},
    {weight_zero, "points", ANY},
    {velocity_infinite, "velocities", ANY},
    {lambda_of_a_row, "hinge_lambda", XPBD},
    {target_nan, "target", QN},
    {pose_long, "placed", ANY},
    {pose_away, "placed", ANY},
    {frame_of_no_length, "turns", COROTATED},
    {section_nan, "section_points", TWO_LEVEL},
    {single_weight, "points", SINGLE},
    {single_nan, "single_points", SINGLE},
    {origin_infinite, "origin", SINGLE},
};

/* ---- the tests -------------------------------------------------------------------------------------------------------------- */

static void make_kind(needs kind, sn_scene *scene, simulation *out) {
    fusiform small = FUSIFORM;
    small.rings = 8, small.sectors = 6, small.pinned = 0.15;
    make_scene(scene, &small);
    scene->solver = sn_solver_defaults(kind == ANY || kind == XPBD || kind == SINGLE ? SN_SOLVER_XPBD : SN_SOLVER_QN);
    if (kind == SINGLE) scene->solver.precision = SN_PRECISION_SINGLE;
    if (kind == COROTATED) scene->solver.preconditioner = SN_PRECONDITION_COROTATED;
    if (kind == TWO_LEVEL) scene->solver.preconditioner = SN_PRECONDITION_TWO_LEVEL;
    scene->solver.substeps = 2;
    scene->solver.iterations = 6;
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, -0.5);
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 1.0, 0.5);
    *out = start(scene);
}

/* A whole frame and four iterations of the next: there are pairs. */
static void run_a_little(simulation *s) {
    sn_step_options stop = {.stop_substep = 1, .stop_iteration = 4};
    sn_state_reset(s->model, s->state);
    step_frames(s, 1, NULL);
    assert_int_equal(sn_step(s->model, s->state, &stop, NULL), SN_STOPPED);
}

static bool applies(needs of, needs kind) {
    return of == ANY || of == kind || (of == QN && (kind == COROTATED || kind == TWO_LEVEL)) || (of == XPBD && kind == SINGLE);
}

static numbers numbers_of(const simulation *s) {
    return (numbers){.state = s->state,
                     .group = &s->state->groups[0],
                     .muscle = &s->state->muscles[0],
                     .inputs = inputs_of(s),
                     .qn = qn_of(s),
                     .xpbd = xpbd_of(s),
                     .points = s->model->muscles[0].point_count};
}

/* Forged in a run, packed (which makes the checksum right) and read into another: refused with a word on what is wrong, and nothing of it
 * taken. */
static void refuse(simulation *forged, simulation *reader, size_t number) {
    char *bytes = NULL, *before = NULL, *after = NULL;
    size_t size = 0, size_before = 0, size_after = 0;
    sn_error error = {0};
    FORGERIES[number].forge(numbers_of(forged));
    assert_int_equal(sn_state_pack(forged->model, forged->state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_pack(reader->model, reader->state, &before, &size_before, NULL), SN_OK);
    if (sn_state_unpack(reader->model, bytes, size, reader->state, &error) != SN_ERROR_INPUT)
        fail_msg("forgery %d is taken (%s)", (int)number, FORGERIES[number].word);
    if (strstr(error.text, FORGERIES[number].word) == NULL) fail_msg("forgery %d: %s", (int)number, error.text);
    assert_int_equal(sn_state_pack(reader->model, reader->state, &after, &size_after, NULL), SN_OK);
    assert_int_equal(size_before, size_after);
    assert_memory_equal(before, after, size_before);
    free(bytes);
    free(before);
    free(after);
}

/* One model, its own state saved so that it is good again after each forgery. */
static void refuse_all(needs kind) {
    sn_scene scenes[2];
    simulation forged, reader;
    char *good = NULL;
    size_t size = 0;
    make_kind(kind, &scenes[0], &forged);
    make_kind(kind, &scenes[1], &reader);
    run_a_little(&forged);
    step_frames(&reader, 2, NULL);
    if (kind == QN) assert_true(qn_of(&forged)->pair_count > 1);
    assert_int_equal(sn_state_pack(forged.model, forged.state, &good, &size, NULL), SN_OK);
    for (size_t i = 0; i < sizeof FORGERIES / sizeof *FORGERIES; i++) {
        if (!applies(FORGERIES[i].needs, kind)) continue;
        assert_int_equal(sn_state_unpack(forged.model, good, size, forged.state, NULL), SN_OK);
        refuse(&forged, &reader, i);
    }
    free(good);
    finish(&forged);
    finish(&reader);
}

static void what_no_run_comes_to_is_refused_and_changes_nothing(void **state) {
    (void)state;
    for (int kind = 0; kind < KINDS; kind++) refuse_all((needs)kind);
}

/* Stiffness, contraction and goals are those of the activation, not what a file says; the rest comes back to the bit. */
static void inputs_are_made_anew(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation forged, reader;
    char *bytes = NULL, *good = NULL, *again = NULL;
    size_t size = 0;
    make_kind(QN, &scenes[0], &forged);
    make_kind(QN, &scenes[1], &reader);
    run_a_little(&forged);
    assert_int_equal(sn_state_pack(forged.model, forged.state, &good, &size, NULL), SN_OK);
    inputs_of(&forged)->stiffness *= 1e9;
    inputs_of(&forged)->contraction = 0.75;
    inputs_of(&forged)->volume_goal = 40.0;
    assert_int_equal(sn_state_pack(forged.model, forged.state, &bytes, &size, NULL), SN_OK);
    assert_memory_not_equal(bytes, good, size);
    assert_int_equal(sn_state_unpack(reader.model, bytes, size, reader.state, NULL), SN_OK);
    assert_int_equal(sn_state_pack(reader.model, reader.state, &again, &size, NULL), SN_OK);
    assert_memory_equal(again, good, size);
    free(bytes);
    free(good);
    free(again);
    finish(&forged);
    finish(&reader);
}

/* Why the last substep ended comes back too: a muscle that sleeps from then on goes on saying it. */
static void the_reason_to_stop_comes_back(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    char *bytes = NULL;
    size_t size = 0;
    for (int k = 0; k < 2; k++) make_kind(QN, &scenes[k], &runs[k]);
    step_frames(&runs[0], 1, NULL);
    qn_of(&runs[0])->stopped = runs[0].state->muscles[0].statistics.stop_reason = SN_STOP_TOLERANCE;
    assert_int_equal(sn_state_pack(runs[0].model, runs[0].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(runs[1].model, bytes, size, runs[1].state, NULL), SN_OK);
    assert_int_equal(runs[1].state->muscles[0].statistics.stop_reason, SN_STOP_TOLERANCE);
    free(bytes);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

static void the_next_frame_is_the_one_a_state_is_in_or_the_one_after(void **state) {
    (void)state;
    assert_int_equal(sn_state_next_frame(&(sn_state){.frame = 4}), 5);
    assert_int_equal(sn_state_next_frame(&(sn_state){.frame = 4, .substep = 1}), 4);
    assert_int_equal(sn_state_next_frame(&(sn_state){.frame = 4, .iteration = 1}), 4);
    assert_int_equal(sn_state_next_frame(&(sn_state){.frame = -1}), 0);
}

/* Their differences, and the one after the last, are whole numbers of 32 bits too. */
static void frames_have_bounds(void **state) {
    (void)state;
    const sn_index bad[][2] = {{0, SN_FRAME_LIMIT + 1}, {-SN_FRAME_LIMIT - 1, 0}, {INT32_MIN, INT32_MAX}};
    sn_scene scene;
    simulation s;
    make_kind(ANY, &scene, &s);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sn_error error = {0};
        scene.first_frame = bad[i][0], scene.last_frame = bad[i][1];
        assert_int_equal(sn_scene_validate(&scene, &error), SN_ERROR_INPUT);
        assert_non_null(strstr(error.text, "must be within -100000000 and 100000000"));
    }
    scene.first_frame = -SN_FRAME_LIMIT, scene.last_frame = SN_FRAME_LIMIT;
    assert_int_equal(sn_scene_validate(&scene, NULL), SN_OK);
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_no_run_comes_to_is_refused_and_changes_nothing),
        cmocka_unit_test(inputs_are_made_anew),
        cmocka_unit_test(the_reason_to_stop_comes_back),
        cmocka_unit_test(frames_have_bounds),
        cmocka_unit_test(the_next_frame_is_the_one_a_state_is_in_or_the_one_after),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
