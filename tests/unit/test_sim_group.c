/* test_sim_group.c -- one factor for a group of muscles (precondition.c): against each muscle alone, and against a dense matrix of own. */
#include "sim_scene.h"

#include "../../lib/sim/qn.h"

static const double STEP = 1.0 / 24.0;

/* Two small muscles of their own stiffness, held at one end each or both; points of the group one after the other. */
typedef struct group {
    sn_scene scene;
    simulation s;
    const sn_model_muscle *members[2];
    sn_index first[3];
    double stiffness[2], volume_stiffness[2];
    sn_preconditioner *joint;
    sn_quat *turns;             /* (points) of no particular order */
    sn_vec3 *in, *out, *volume; /* (points) */
    uint64_t random;
} group;

static sn_vec3 random_vector(uint64_t *random) {
    double x = sn_random(random) - 0.5, y = sn_random(random) - 0.5, z = sn_random(random) - 0.5;
    return sn_v3(x, y, z);
}

static void make_vectors(group *g) {
    sn_index n = g->first[2];
    g->turns = SN_NEW(sn_quat, n);
    g->in = SN_NEW(sn_vec3, n);
    g->out = SN_NEW(sn_vec3, n);
    g->volume = SN_NEW(sn_vec3, n);
    for (sn_index i = 0; i < n; i++) {
        g->in[i] = random_vector(&g->random);
        int member = i >= g->first[1];
        sn_vec3 gradient = sn_scale(random_vector(&g->random), 1e-4);
        g->volume[i] = i - g->first[member] < g->members[member]->vertex_count ? gradient : sn_v3(0, 0, 0);
        g->turns[i] = sn_quat_axis_angle(sn_normalize(random_vector(&g->random)), 2.0 * sn_random(&g->random));
    }
}

static void make_group(group *g, sn_preconditioning preconditioner) {
    fusiform small = FUSIFORM, other = FUSIFORM;
    small.rings = 8, small.sectors = 6; /* with samples, which the volume's row reaches through A^-1 */
    other.rings = 7, other.sectors = 5, other.structure = false;
    *g = (group){.stiffness = {500.0, 3000.0}, .volume_stiffness = {2e12, 5e11}, .random = 29};
    make_scene(&g->scene, &small);
    add_muscle(&g->scene, "other", &other);
    g->scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    g->scene.solver.preconditioner = preconditioner;
    g->s = start(&g->scene);
    for (int i = 0; i < 2; i++) {
        g->members[i] = &g->s.model->muscles[i];
        g->first[i + 1] = g->first[i] + g->members[i]->point_count;
    }
    make_vectors(g);
    assert_int_equal(sn_preconditioner_create(2, g->members, &g->joint, NULL), SN_OK);
}

static void free_group(group *g) {
    sn_preconditioner_destroy(g->joint);
    free(g->turns);
    free(g->in);
    free(g->out);
    free(g->volume);
    finish(&g->s);
}

static bool is_free(const group *g, sn_index point) {
    int member = point >= g->first[1];
    return g->members[member]->inverse_mass[point - g->first[member]] > 0.0;
}

static void update(group *g, bool turned) {
    double factored_for[2] = {NAN, NAN};
    bool changed;
    assert_true(sn_preconditioner_update(g->joint, STEP, g->stiffness, turned ? g->turns : NULL, factored_for, &changed));
    assert_true(changed && factored_for[0] == g->stiffness[0] && factored_for[1] == g->stiffness[1]);
}

static double largest(sn_index count, const sn_vec3 *a) {
    double most = 0.0;
    for (sn_index i = 0; i < count; i++) most = fmax(most, sn_norm(a[i]));
    return most;
}

/* ---- against each member alone ---------------------------------------------------------------------------------------------- */

/* What a member does alone with its part of `in`: found (points of the member). */
static void apply_alone(const group *g, int member, bool turned, bool corrected, sn_vec3 *found) {
    sn_preconditioner *alone;
    double factored_for = NAN;
    bool changed;
    sn_index first = g->first[member];
    assert_int_equal(sn_preconditioner_create(1, &g->members[member], &alone, NULL), SN_OK);
    assert_true(sn_preconditioner_update(alone, STEP, &g->stiffness[member], turned ? g->turns + first : NULL, &factored_for, &changed));
    if (corrected) sn_preconditioner_correct(alone, g->members[member]->rest, STEP, &g->stiffness[member]);
    sn_preconditioner_set_volume(alone, g->volume + first, &g->volume_stiffness[member]);
    assert_true(sn_preconditioner_apply(alone, g->in + first, found));
    sn_preconditioner_destroy(alone);
}

static void correct(const group *g) {
    sn_vec3 *rest = SN_NEW(sn_vec3, g->first[2]);
    for (int k = 0; k < 2; k++) memcpy(rest + g->first[k], g->members[k]->rest, (size_t)g->members[k]->point_count * sizeof *rest);
    sn_preconditioner_correct(g->joint, rest, STEP, g->stiffness);
    free(rest);
}

static void members_are_as_if_alone(void **state) {
    (void)state;
    static const sn_preconditioning MATRICES[] = {SN_PRECONDITION_SCALAR, SN_PRECONDITION_COROTATED, SN_PRECONDITION_TWO_LEVEL};
    for (int k = 0; k < 3; k++) {
        group g;
        make_group(&g, MATRICES[k]);
        bool turned = MATRICES[k] == SN_PRECONDITION_COROTATED, corrected = MATRICES[k] == SN_PRECONDITION_TWO_LEVEL;
        update(&g, turned);
        if (corrected) correct(&g);
        for (int member = 0; member < 2 && corrected; member++)
            g.volume_stiffness[member] = 0.0; /* deflation is without its coarse space */
        sn_preconditioner_set_volume(g.joint, g.volume, g.volume_stiffness);
        sn_vec3 *alone = SN_NEW(sn_vec3, g.first[2]);
        for (int member = 0; member < 2; member++) apply_alone(&g, member, turned, corrected, alone + g.first[member]);
        for (int again = 0; again < 2; again++) { /* the first solve finds the volumes' too */
            assert_true(sn_preconditioner_apply(g.joint, g.in, g.out));
            for (sn_index i = 0; i < g.first[2]; i++) assert_true(sn_distance(g.out[i], alone[i]) <= 1e-12 * largest(g.first[2], alone));
        }
        free(alone);
        free_group(&g);
    }
}

/* ---- against a dense matrix --------------------------------------------------------------------------------------------------- */

/* The matrix over all points of the group, carried ones too: (3 points) squared. */
typedef struct dense {
    const group *g;
    double *a;
    sn_index first;
    double stiffness;
    bool turned;
} dense;

static void add_entry(dense *d, sn_index i, sn_index j, int r, int c, double value) {
    d->a[(size_t)(3 * i + r) * 3 * (size_t)d->g->first[2] + (size_t)(3 * j + c)] += value;
}

/* scale K KT on each axis; or, turned, R_i (scale g gT + half of that on each axis, for hinges) R_jT. */
static bool add_dense_row(void *user, const sn_rest_row *row) {
    dense *d = user;
    for (int i = 0; i < row->count; i++) {
        for (int j = 0; j < row->count; j++) {
            sn_index p = d->first + row->point[i], q = d->first + row->point[j];
            double k = d->stiffness * row->scale, all_round = k * row->weight[i] * row->weight[j];
            sn_vec3 gi = row->gradient[i], gj = row->gradient[j];
            for (int c = 0; c < 3; c++) {
                sn_vec3 axis = sn_v3(c == 0, c == 1, c == 2), column = sn_scale(axis, all_round);
                if (d->turned) {
                    sn_vec3 back = sn_quat_rotate(sn_quat_conjugate(d->g->turns[q]), axis);
                    column = sn_scale(gi, k * sn_dot(gj, back));
                    if (row->count == 4) column = sn_add_scaled(column, back, 0.5 * all_round);
                    column = sn_quat_rotate(d->g->turns[p], column);
                }
                add_entry(d, p, q, 0, c, column.x);
                add_entry(d, p, q, 1, c, column.y);
                add_entry(d, p, q, 2, c, column.z);
            }
        }
    }
    return true;
}

static dense make_dense(const group *g, bool turned) {
    size_t n = 3 * (size_t)g->first[2];
    dense d = {.g = g, .a = SN_NEW(double, n *n), .turned = turned};
    for (int k = 0; k < 2; k++) {
        d.first = g->first[k], d.stiffness = g->stiffness[k];
        assert_true(sn_rows_at(g->members[k], g->members[k]->rest, add_dense_row, &d));
        for (sn_index i = 0; i < g->members[k]->point_count; i++)
            for (int c = 0; c < 3 && is_free(g, d.first + i); c++)
                add_entry(&d, d.first + i, d.first + i, c, c, 1.0 / (g->members[k]->inverse_mass[i] * STEP * STEP));
        for (sn_index i = g->first[k]; i < g->first[k + 1]; i++)
            for (sn_index j = g->first[k]; j < g->first[k + 1]; j++) {
                const double gi[3] = {g->volume[i].x, g->volume[i].y, g->volume[i].z};
                const double gj[3] = {g->volume[j].x, g->volume[j].y, g->volume[j].z};
                for (int e = 0; e < 9; e++) add_entry(&d, i, j, e / 3, e % 3, g->volume_stiffness[k] * gi[e / 3] * gj[e % 3]);
            }
    }
    return d;
}

/* The greatest |A x - b| of a free point. */
static double misfit(const dense *d, const sn_vec3 *x, const sn_vec3 *b) {
    size_t n = 3 * (size_t)d->g->first[2];
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        if (!is_free(d->g, (sn_index)(i / 3))) continue;
        double sum = 0.0;
        for (size_t j = 0; j < n; j++) sum += d->a[i * n + j] * (&x[j / 3].x)[j % 3];
        most = fmax(most, fabs(sum - (&b[i / 3].x)[i % 3]));
    }
    return most;
}

/* The second time the members are softer: the factor of other stiffnesses must not outlive them. */
static void the_factor_is_that_of_the_dense_matrix(void **state) {
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        group g;
        make_group(&g, turned ? SN_PRECONDITION_COROTATED : SN_PRECONDITION_SCALAR);
        double size = largest(g.first[2], g.in);
        dense before = make_dense(&g, turned);
        for (int again = 0; again < 2; again++) {
            for (int k = 0; k < 2 && again == 1; k++) g.stiffness[k] *= 0.2;
            update(&g, turned);
            sn_preconditioner_set_volume(g.joint, g.volume, g.volume_stiffness);
            assert_true(sn_preconditioner_apply(g.joint, g.in, g.out));
            dense now = make_dense(&g, turned);
            assert_true(misfit(&now, g.out, g.in) < 1e-9 * size);
            assert_true(again == 0 || misfit(&before, g.out, g.in) > 1e-2 * size);
            free(now.a);
        }
        free(before.a);
        free_group(&g);
    }
}

/* Carried points move: A_fk jump, of members and volumes. -A_ff^-1 of it is where the free points go: no force is left. */
static void jumps_push_the_free_points(void **state) {
    (void)state;
    group g;
    make_group(&g, SN_PRECONDITION_SCALAR);
    update(&g, false);
    dense d = make_dense(&g, false);
    sn_vec3 *jump = SN_NEW(sn_vec3, g.first[2]), *force = SN_NEW(sn_vec3, g.first[2]);
    for (sn_index i = 0; i < g.first[2]; i++)
        if (!is_free(&g, i)) jump[i] = random_vector(&g.random);
    sn_preconditioner_add_jump(g.joint, jump, g.volume, g.volume_stiffness, force);
    sn_preconditioner_set_volume(g.joint, g.volume, g.volume_stiffness);
    assert_true(sn_preconditioner_apply(g.joint, force, g.out));
    for (sn_index i = 0; i < g.first[2]; i++) {
        g.out[i] = is_free(&g, i) ? sn_neg(g.out[i]) : jump[i];
        g.in[i] = sn_v3(0, 0, 0);
    }
    double size = largest(g.first[2], force);
    assert_true(size > 0.0 && misfit(&d, g.out, g.in) < 1e-9 * size);
    free(jump);
    free(force);
    free(d.a);
    free_group(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(members_are_as_if_alone),
        cmocka_unit_test(the_factor_is_that_of_the_dense_matrix),
        cmocka_unit_test(jumps_push_the_free_points),
    };
    return cmocka_run_group_tests_name("group", tests, NULL, NULL);
}
