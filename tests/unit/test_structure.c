/* The internal structure: tree, leaves, spacing, connections, pruning, and every partial result. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "rig_shapes.h"
#include "sinew/rig.h"

/* A muscle with roots; at a plane z = height where height > 0, else automatic. */
static sn_muscle rooted(sn_mesh mesh, double height) {
    sn_muscle m = {.meters_per_unit = 1, .mesh = mesh};
    sn_roots_params params = sn_roots_defaults();
    params.automatic = !(height > 0.0);
    params.selector = (sn_selector){.kind = SN_SELECT_PLANE, .point = {0, 0, height}, .other = {0, 0, 1}};
    sn_error error = {0};
    if (sn_roots_select(&m, &params, NULL, &m.roots, NULL, &error)) fail_msg("%s", error.text);
    return m;
}

static sn_structure_report build(sn_muscle *m, sn_structure_params params) {
    sn_structure_report report;
    sn_error error = {0};
    sn_structure_free(&m->structure);
    if (sn_structure_build(m, &params, NULL, &m->structure, &report, &error)) fail_msg("%s", error.text);
    if (sn_muscle_validate(m, &error)) fail_msg("%s", error.text);
    return report;
}

/* What holds for every finished structure. */
static void check(const sn_muscle *m, const sn_structure_report *r) {
    const sn_structure *s = &m->structure;
    assert_int_equal(s->parents[0], SN_NONE);
    assert_int_equal(s->branches[0], 0);
    assert_true(fabs(sn_norm(s->axes[0]) - 1.0) < 1e-12);
    for (sn_index i = 1; i < s->sample_count; i++) {
        sn_vec3 link = sn_sub(s->positions[s->parents[i]], s->positions[i]);
        assert_in_range(s->parents[i], 0, i - 1);
        assert_true(s->branches[i] >= s->branches[s->parents[i]]);
        assert_true(sn_norm(link) <= s->spacing * (1.0 + 1e-12));
        assert_true(fabs(sn_norm(s->axes[i]) - 1.0) < 1e-12);
        if (sn_norm(link) > 0.0) assert_true(sn_distance(s->axes[i], sn_normalize(link)) < 1e-12);
    }
    for (sn_index v = 0; v < m->mesh.vertex_count; v++) assert_in_range(s->vertex_sample[v], 0, s->sample_count - 1);
    assert_int_equal(r->samples, s->sample_count);
    assert_int_equal(r->unconnected, 0);
    assert_true(r->longest_link <= r->spacing * (1.0 + 1e-12));
}

static void a_spindle_has_a_straight_axis_and_two_leaves(void **state) {
    (void)state;
    sn_muscle m = rooted(spindle(31, 12, 0.2, 0.03), 0);
    sn_structure_report r = build(&m, (sn_structure_params){.spacing = 0.0101, .prune = 0.03});
    check(&m, &r);
    assert_int_equal(r.leaves, 2);
    assert_int_equal(r.branches, 3);
    assert_int_equal(r.samples, 21); /* 0.1 to each side at 0.0101 at most */
    assert_int_equal(r.outside, 0);
    for (sn_index i = 0; i < r.samples; i++) {
        sn_vec3 p = m.structure.positions[i];
        assert_true(hypot(p.x, p.y) < 1e-12);
        assert_true(fabs(m.structure.axes[i].z) > 1.0 - 1e-12);
    }
    sn_muscle_free(&m);
}

static void vertices_hang_on_the_nearest_sample_of_their_branch(void **state) {
    (void)state;
    sn_muscle m = rooted(spindle(31, 12, 0.2, 0.03), 0);
    build(&m, (sn_structure_params){.spacing = 0.0101, .prune = 0.03});
    const sn_structure *s = &m.structure;
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) {
        double z = m.mesh.positions[v].z;
        sn_vec3 own = s->positions[s->vertex_sample[v]];
        if (fabs(z) > 1e-9) assert_true(own.z * z >= -1e-12); /* never on the other side of the roots */
        for (sn_index i = 0; i < s->sample_count; i++)
            if (fabs(z) > 1e-9 && s->positions[i].z * z > 0.0)
                assert_true(sn_distance(own, m.mesh.positions[v]) <= sn_distance(s->positions[i], m.mesh.positions[v]) + 1e-12);
    }
    sn_muscle_free(&m);
}

static void a_fork_has_three_leaves(void **state) {
    (void)state;
    sn_muscle m = rooted(blocks(two_prongs), 10.5);
    sn_structure_report r = build(&m, sn_structure_defaults());
    check(&m, &r);
    assert_int_equal(r.leaves, 3);
    assert_int_equal(r.branches, 5);                     /* the root, the stem's two sides, two prongs */
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) { /* prong tips hang on samples of their own prong */
        sn_vec3 p = m.mesh.positions[v], q = m.structure.positions[m.structure.vertex_sample[v]];
        if (p.z > 28.0) assert_true((p.x < 14.0) == (q.x < 14.0));
    }
    sn_muscle_free(&m);
}

static void a_knob_is_pruned_unless_all_is_kept(void **state) {
    (void)state;
    sn_muscle m = rooted(blocks(knobbed_bar), 10.5);
    sn_structure_report pruned = build(&m, sn_structure_defaults());
    check(&m, &pruned);
    assert_int_equal(pruned.leaves, 2);
    assert_true(pruned.pruned > 0);
    sn_structure_report all = build(&m, (sn_structure_params){.spacing = 0, .prune = 0});
    check(&m, &all);
    assert_true(all.leaves > 2);
    assert_int_equal(all.pruned, 0);
    sn_muscle_free(&m);
}

static void roots_at_one_end_grow_one_way(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(31, 12, 0.2, 0.03)};
    m.roots = (sn_roots){.count = 1, .vertices = SN_NEW(sn_index, 1), .rule = sn_strdup("indices")};
    sn_structure_report r = build(&m, (sn_structure_params){.spacing = 0.0101, .prune = 0.03});
    check(&m, &r);
    assert_int_equal(r.leaves, 1);
    assert_int_equal(r.branches, 1);
    assert_int_equal(r.samples, 21);
    sn_muscle_free(&m);
}

static void a_share_of_one_still_leaves_both_sides(void **state) {
    (void)state;
    sn_muscle m = rooted(blocks(two_prongs), 10.5);
    /* the two prongs make one branch between them: outside, and too far from either for short links */
    sn_structure_report r = build(&m, (sn_structure_params){.spacing = 0, .prune = 1.0, .keep_outside = true});
    check(&m, &r);
    assert_int_equal(r.leaves, 2);
    assert_true(r.outside > 0);
    r = build(&m, (sn_structure_params){.spacing = 0, .prune = 1.0});
    assert_int_equal(r.outside, 0);
    assert_int_equal(r.leaves, 2);
    sn_muscle_free(&m);
}

static void handles_are_reported(void **state) {
    (void)state;
    sn_muscle m = rooted(blocks(hoop), 0);
    sn_structure_report r = build(&m, sn_structure_defaults());
    check(&m, &r);
    assert_true(r.genus == 1.0);
    sn_muscle_free(&m);
}

/* ---- errors ---------------------------------------------------------------------------------------------------------------------- */

static void expect_failure(const sn_muscle *m, sn_structure_params params, sn_status expected, const char *word) {
    sn_structure structure;
    sn_error error = {0};
    assert_int_equal(sn_structure_build(m, &params, NULL, &structure, NULL, &error), expected);
    assert_int_equal(structure.sample_count, 0);
    if (!strstr(error.text, word)) fail_msg("\"%s\" does not say %s", error.text, word);
}

static void bad_input_says_what_would_help(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(31, 12, 0.2, 0.03)};
    expect_failure(&m, sn_structure_defaults(), SN_ERROR_INPUT, "root-select");
    sn_muscle_free(&m);

    m = rooted(joined(spindle(31, 12, 0.2, 0.03), spindle(5, 6, 0.2, 0.03)), 0);
    expect_failure(&m, sn_structure_defaults(), SN_ERROR_INPUT, "mesh-clean --keep largest");
    sn_muscle_free(&m);

    m = rooted(spindle(31, 12, 0.2, 0.03), 0);
    expect_failure(&m, (sn_structure_params){.spacing = 1e-9, .prune = 0.03}, SN_ERROR_USAGE, "spacing");
    expect_failure(&m, (sn_structure_params){.spacing = 5.0, .prune = 0.03}, SN_ERROR_USAGE, "longer than the muscle");
    expect_failure(&m, (sn_structure_params){.spacing = NAN, .prune = 0.03}, SN_ERROR_USAGE, "spacing");
    expect_failure(&m, (sn_structure_params){.spacing = 0.01, .prune = -1.0}, SN_ERROR_USAGE, "prune");
    m.roots.vertices[0] = m.mesh.vertex_count;
    expect_failure(&m, sn_structure_defaults(), SN_ERROR_INPUT, "root-select");
    sn_muscle_free(&m);
}

/* ---- the trace --------------------------------------------------------------------------------------------------------------------- */

typedef struct steps {
    int fronts, slabs, prunes, branches, resamples, connects, moves;
    sn_index vertices;
} steps;

static void count_step(void *user, int64_t number, const char *stage, const sn_trace_value *values, int count) {
    steps *s = user;
    (void)number;
    s->fronts += strcmp(stage, "front") == 0;
    s->slabs += strcmp(stage, "slab") == 0;
    s->prunes += strcmp(stage, "prune") == 0;
    s->moves += strcmp(stage, "inside") == 0;
    s->branches += strcmp(stage, "branch") == 0;
    s->resamples += strcmp(stage, "resample") == 0;
    s->connects += strcmp(stage, "connect") == 0;
    for (int i = 0; i < count; i++)
        if ((strcmp(stage, "front") == 0 || strcmp(stage, "slab") == 0) && values[i].kind == SN_TRACE_INDICES)
            s->vertices += values[i].count;
}

static void the_trace_shows_every_step(void **state) {
    (void)state;
    for (int metric = SN_METRIC_SLABS; metric <= SN_METRIC_HOPS; metric++) {
        sn_muscle m = rooted(blocks(knobbed_bar), 10.5);
        sn_structure_report r;
        steps seen = {0};
        sn_trace trace = {.receive = count_step, .user = &seen, .stop_after = -1};
        sn_structure_params params = sn_structure_defaults();
        params.metric = (sn_structure_metric)metric;
        assert_int_equal(sn_structure_build(&m, &params, &trace, &m.structure, &r, NULL), SN_OK);
        assert_true((seen.slabs > 0) == (metric == SN_METRIC_SLABS));
        assert_true((seen.fronts > 0) == (metric == SN_METRIC_HOPS));
        assert_int_equal(seen.vertices, m.mesh.vertex_count); /* every vertex is visited once */
        assert_int_equal(seen.prunes, r.pruned);
        assert_int_equal(seen.moves, r.moved);
        assert_int_equal(seen.branches, r.branches);
        assert_int_equal(seen.resamples, r.branches);
        assert_int_equal(seen.connects, r.branches);
        sn_muscle_free(&m);
    }
}

static void stopping_anywhere_leaves_a_valid_part(void **state) {
    (void)state;
    sn_muscle m = rooted(blocks(knobbed_bar), 10.5);
    sn_structure_params params = sn_structure_defaults();
    sn_status status = SN_STOPPED;
    for (int64_t n = 0; status == SN_STOPPED; n++) {
        sn_trace trace = {.stop_after = n};
        sn_structure_report r;
        sn_structure_free(&m.structure);
        status = sn_structure_build(&m, &params, &trace, &m.structure, &r, NULL);
        assert_true(trace.steps <= n && n < 2000);
        assert_int_equal(sn_muscle_validate(&m, NULL), SN_OK);
        assert_true((m.structure.sample_count > 0) == (n > 0));
        if (n == 1) assert_int_equal(m.structure.sample_count, 1); /* the root's front alone */
    }
    assert_true(status == SN_OK);
    sn_muscle_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spindle_has_a_straight_axis_and_two_leaves),
        cmocka_unit_test(vertices_hang_on_the_nearest_sample_of_their_branch),
        cmocka_unit_test(a_fork_has_three_leaves),
        cmocka_unit_test(a_knob_is_pruned_unless_all_is_kept),
        cmocka_unit_test(roots_at_one_end_grow_one_way),
        cmocka_unit_test(a_share_of_one_still_leaves_both_sides),
        cmocka_unit_test(handles_are_reported),
        cmocka_unit_test(bad_input_says_what_would_help),
        cmocka_unit_test(the_trace_shows_every_step),
        cmocka_unit_test(stopping_anywhere_leaves_a_valid_part),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
