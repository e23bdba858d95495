/* test_sim_two_level.c -- the coarse space of the two-level matrix (numerics.md 7), and what the matrix may not change. */
#include "sim_inside.h"

#include "../../lib/sim/two_level.h"

static void use(sn_scene *scene, sn_preconditioning preconditioner) {
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.preconditioner = preconditioner;
}

/* A bend about x, or a twist about the muscle's axis. */
static void move(sn_scene *scene, sn_preconditioning preconditioner, sn_stretch stretch, bool twist) {
    use(scene, preconditioner);
    scene->muscles[0].stretch = stretch;
    if (twist) scene->motion.joints[0].axis = sn_v3(0, 0, 1);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, -1.0);
}

/* ---- the coarse space ------------------------------------------------------------------------------------------------------- */

static sn_vec3 random_vector(uint64_t *random, double size) {
    double x = sn_random(random) - 0.5, y = sn_random(random) - 0.5, z = sn_random(random) - 0.5;
    return sn_scale(sn_v3(x, y, z), 2.0 * size);
}

/* A structured muscle somewhere else than at rest, and its coarse space. */
typedef struct coarse {
    sn_scene scene;
    simulation s;
    const sn_model_muscle *m;
    sn_two_level t;
    sn_vec3 *at; /* (points) */
} coarse;

static const double STEP = 1.0 / 24.0, STIFFNESS = 700.0;

static void make_coarse(coarse *c) {
    uint64_t random = 11;
    use(&c->scene, SN_PRECONDITION_TWO_LEVEL);
    c->s = start(&c->scene);
    c->m = &c->s.model->muscles[0];
    c->at = SN_NEW(sn_vec3, c->m->point_count);
    sn_quat turn = sn_quat_axis_angle(sn_v3(0.6, 0.8, 0), 1.1);
    for (sn_index i = 0; i < c->m->point_count; i++)
        c->at[i] = sn_add(sn_add(sn_quat_rotate(turn, c->m->rest[i]), sn_v3(2, -1, 3)), random_vector(&random, 1e-3));
    assert_true(sn_two_level_create(c->m, &c->t));
    sn_two_level_update(&c->t, c->at, STEP, STIFFNESS);
}

static void free_coarse(coarse *c) {
    sn_two_level_free(&c->t);
    free(c->at);
    finish(&c->s);
}

/* H of Gauss and Newton times a motion of the free points, row by row. */
typedef struct product {
    const sn_model_muscle *m;
    const sn_vec3 *in;
    sn_vec3 *out;
} product;

static bool add_row_product(void *user, const sn_rest_row *row) {
    product *p = user;
    double along = 0.0;
    for (int i = 0; i < row->count; i++) along += sn_dot(row->gradient[i], p->in[row->point[i]]);
    for (int i = 0; i < row->count; i++) {
        sn_vec3 *out = &p->out[row->point[i]];
        if (p->m->inverse_mass[row->point[i]] > 0.0) *out = sn_add_scaled(*out, row->gradient[i], STIFFNESS * row->scale * along);
    }
    return true;
}

static void multiply(const coarse *c, const sn_vec3 *in, sn_vec3 *out) {
    product p = {c->m, in, out};
    for (sn_index i = 0; i < c->m->point_count; i++)
        out[i] = c->m->inverse_mass[i] > 0.0 ? sn_scale(in[i], 1.0 / (c->m->inverse_mass[i] * STEP * STEP)) : sn_v3(0, 0, 0);
    sn_rows_at(c->m, c->at, add_row_product, &p);
}

static double largest(sn_index count, const sn_vec3 *a) {
    double most = 0.0;
    for (sn_index i = 0; i < count; i++) most = fmax(most, sn_norm(a[i]));
    return most;
}

/* Gradients of hinges are those of the constraint bit for bit, those of springs to rounding, also where the muscle is not at rest. */
static bool compare_with_constraint(void *user, const sn_rest_row *row) {
    const coarse *c = user;
    sn_vec3 p[4], g[4];
    double value;
    for (int i = 0; i < row->count; i++) p[i] = c->at[row->point[i]];
    if (row->count == 4) {
        assert_true(sn_hinge_constraint(p, 0.0, &value, g));
        assert_memory_equal(g, row->gradient, sizeof g);
    } else {
        assert_true(sn_distance_constraint(p[0], p[1], 0.0, &value, g));
        assert_true(sn_distance(g[0], row->gradient[0]) < 1e-14 && sn_distance(g[1], row->gradient[1]) < 1e-14);
    }
    return true;
}

static void rows_have_the_gradients_of_constraints(void **state) {
    (void)state;
    coarse c;
    make_coarse(&c);
    assert_true(sn_rows_at(c.m, c.at, compare_with_constraint, &c));
    free_coarse(&c);
}

/* All sections turned alike about one centre move the free points as one rigid body, and the others not at all. */
static void modes_hold_rigid_motions(void **state) {
    (void)state;
    coarse c;
    make_coarse(&c);
    assert_true(c.t.count >= 8 && c.t.size == 6 * c.t.count);
    const sn_vec3 shift = {0.3, -0.2, 0.1}, spin = {0.7, 0.4, -0.9};
    for (sn_index k = 0; k < c.t.count; k++) {
        sn_vec3 moved = sn_add(shift, sn_cross(spin, c.t.middle[k]));
        const double amount[6] = {moved.x, moved.y, moved.z, spin.x, spin.y, spin.z};
        memcpy(c.t.amount + 6 * k, amount, sizeof amount);
    }
    sn_vec3 *out = SN_NEW(sn_vec3, c.m->point_count);
    sn_two_level_add(&c.t, 1.0, out);
    for (sn_index i = 0; i < c.m->point_count; i++) {
        sn_vec3 rigid = c.m->inverse_mass[i] > 0.0 ? sn_add(shift, sn_cross(spin, c.at[i])) : sn_v3(0, 0, 0);
        assert_true(sn_distance(out[i], rigid) < 1e-12);
    }
    free(out);
    free_coarse(&c);
}

/* (ZT H Z)^-1 ZT H Z c is c: of any motion that the sections can make the coarse solve finds the force's answer. */
static void what_sections_can_do_is_solved_exactly(void **state) {
    (void)state;
    coarse c;
    make_coarse(&c);
    uint64_t random = 3;
    size_t n = (size_t)c.m->point_count;
    sn_vec3 *in = SN_NEW(sn_vec3, n), *force = SN_NEW(sn_vec3, n), *out = SN_NEW(sn_vec3, n);
    for (int trial = 0; trial < 5; trial++) {
        memset(in, 0, n * sizeof *in);
        memset(out, 0, n * sizeof *out);
        for (sn_index k = 0; k < c.t.size; k++) c.t.amount[k] = sn_random(&random) - 0.5;
        sn_two_level_add(&c.t, 1.0, in);
        multiply(&c, in, force);
        sn_two_level_solve(&c.t, force);
        sn_two_level_add(&c.t, 1.0, out);
        double size = largest(c.m->point_count, in);
        for (size_t i = 0; i < n; i++) out[i] = sn_sub(out[i], in[i]);
        assert_true(size > 0.1 && largest(c.m->point_count, out) < 1e-8 * size);
    }
    free(in);
    free(force);
    free(out);
    free_coarse(&c);
}

/* A coarse space whose columns depend on each other, as of a muscle with one free vertex: finite, and still exact on that vertex. */
static void dependent_modes_are_left_out(void **state) {
    (void)state;
    coarse c;
    make_coarse(&c);
    sn_index only = SN_NONE;
    for (sn_index i = 0; i < c.m->vertex_count; i++) {
        if (!(c.m->inverse_mass[i] > 0.0)) continue;
        if (only == SN_NONE) only = i;
        if (i != only) c.t.weight[i][0] = c.t.weight[i][1] = 0.0;
    }
    for (sn_index i = c.m->vertex_count; i < c.m->point_count; i++) c.t.weight[i][0] = c.t.weight[i][1] = 0.0;
    sn_two_level_update(&c.t, c.at, STEP, STIFFNESS);
    sn_index kept = 0;
    for (sn_index k = 0; k < c.t.size; k++) kept += c.t.inverse[k] > 0.0;
    assert_int_equal(kept, 3);
    free_coarse(&c);
}

/* ---- the matrix ------------------------------------------------------------------------------------------------------------- */

static void the_solution_does_not_change(void **state) {
    (void)state;
    for (int stretch = 0; stretch < 2; stretch++) {
        static const sn_preconditioning MATRICES[2] = {SN_PRECONDITION_SCALAR, SN_PRECONDITION_TWO_LEVEL};
        sn_scene scenes[2];
        simulation s[2];
        for (int k = 0; k < 2; k++) {
            move(&scenes[k], MATRICES[k], (sn_stretch)stretch, false);
            set_keys(&scenes[k].muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
            scenes[k].solver.iterations = 500;
            scenes[k].solver.tolerance = 1e-9;
            s[k] = start(&scenes[k]);
            step_frames(&s[k], 12, NULL);
        }
        double most = 0.0;
        for (sn_index i = 0; i < s[0].model->muscles[0].point_count; i++)
            most = fmax(most, sn_distance(position(&s[0], i), position(&s[1], i)));
        assert_true(most < 1e-6 * s[0].model->muscles[0].diagonal);
        finish(&s[0]);
        finish(&s[1]);
    }
}

static int64_t iterations_of(sn_preconditioning preconditioner) {
    sn_scene scene;
    int64_t sum = 0;
    move(&scene, preconditioner, SN_STRETCH_SPRINGS, true);
    scene.solver.iterations = 500;
    scene.solver.tolerance = 1e-7;
    simulation s = start(&scene);
    for (int frame = 0; frame < 24; frame++) {
        step_frames(&s, 1, NULL);
        sum += s.state->muscles[0].statistics.iterations;
    }
    finish(&s);
    return sum;
}

/* What it is for: a structured muscle that is twisted needs less than two thirds of the iterations. */
static void a_twist_takes_fewer_iterations(void **state) {
    (void)state;
    int64_t scalar = iterations_of(SN_PRECONDITION_SCALAR), two_level = iterations_of(SN_PRECONDITION_TWO_LEVEL);
    if (!(3 * two_level < 2 * scalar)) fail_msg("%d iterations with the scalar matrix, %d with two levels", (int)scalar, (int)two_level);
}

/* Stopped in the middle of a substep, packed, unpacked elsewhere: where the sections were comes along. */
static void a_stop_changes_no_bit(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    for (int k = 0; k < 2; k++) {
        move(&scenes[k], SN_PRECONDITION_TWO_LEVEL, SN_STRETCH_SPRINGS, true);
        s[k] = start(&scenes[k]);
        step_frames(&s[k], 5, NULL);
    }
    const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 2};
    char *bytes;
    size_t size;
    assert_int_equal(sn_step(s[0].model, s[0].state, &stop, NULL), SN_STOPPED);
    assert_true(qn_of(&s[0])->turned); /* or the test says nothing about sections */
    assert_int_equal(sn_state_pack(s[0].model, s[0].state, &bytes, &size, NULL), SN_OK);
    sn_state_destroy(s[0].model, s[0].state);
    assert_int_equal(sn_state_create(s[0].model, &s[0].state, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s[0].model, bytes, size, s[0].state, NULL), SN_OK);
    free(bytes);
    step_frames(&s[0], 3, NULL);
    step_frames(&s[1], 3, NULL);
    size_t points = (size_t)s[0].model->muscles[0].point_count * sizeof(sn_point);
    assert_memory_equal(s[0].state->muscles[0].points, s[1].state->muscles[0].points, points);
    finish(&s[0]);
    finish(&s[1]);
}

/* A muscle that no bone holds goes by the scalar matrix: the same bits. */
static void a_free_muscle_has_no_sections(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    fusiform f = FUSIFORM;
    f.pinned = 0.0;
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &f);
        scenes[k].solver = sn_solver_defaults(SN_SOLVER_QN);
        scenes[k].solver.preconditioner = k == 0 ? SN_PRECONDITION_SCALAR : SN_PRECONDITION_TWO_LEVEL;
        set_keys(&scenes[k].muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
        s[k] = start(&scenes[k]);
        step_frames(&s[k], 5, NULL);
    }
    size_t points = (size_t)s[0].model->muscles[0].point_count * sizeof(sn_point);
    assert_memory_equal(s[0].state->muscles[0].points, s[1].state->muscles[0].points, points);
    finish(&s[0]);
    finish(&s[1]);
}

/* Random points, and all in one: the switch goes back to the scalar matrix, and the muscle comes back. */
static void wrecks_recover(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        sn_scene scene;
        use(&scene, SN_PRECONDITION_TWO_LEVEL);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        uint64_t random = 17;
        for (sn_index i = 0; i < m->point_count; i++) {
            sn_vec3 p = kind == 0 ? random_vector(&random, 0.2) : sn_v3(0, 0, 0.1);
            sn_point *point = &s.state->muscles[0].points[i];
            if (m->inverse_mass[i] > 0.0) point->x = p.x, point->y = p.y, point->z = p.z;
        }
        step_frames(&s, 60, NULL);
        assert_true(greatest_move(&s) < 1e-6 * m->diagonal);
        finish(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_have_the_gradients_of_constraints),
        cmocka_unit_test(modes_hold_rigid_motions),
        cmocka_unit_test(what_sections_can_do_is_solved_exactly),
        cmocka_unit_test(dependent_modes_are_left_out),
        cmocka_unit_test(the_solution_does_not_change),
        cmocka_unit_test(a_twist_takes_fewer_iterations),
        cmocka_unit_test(a_stop_changes_no_bit),
        cmocka_unit_test(a_free_muscle_has_no_sections),
        cmocka_unit_test(wrecks_recover),
    };
    return cmocka_run_group_tests_name("two-level", tests, NULL, NULL);
}
