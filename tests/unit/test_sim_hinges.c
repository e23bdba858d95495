/* test_sim_hinges.c -- the hinges of the scheme `kohout`: by the rule of the published program, and by the printed equations, bounded. */
#include "sim_scene.h"

/* One hinge: triangles (0,1,2) and (1,0,3), all points free or the first two attached. */
static void make_hinge(sn_scene *scene, const sn_vec3 rest[4], sn_hinge_rule rule, bool attached) {
    make_scene(scene, &FUSIFORM);
    sn_muscle *rig = &scene->muscles[0].rig;
    scene->solver =
        (sn_solver_settings){.method = SN_SOLVER_XPBD, .scheme = SN_SCHEME_KOHOUT, .hinges = rule, .substeps = 1, .iterations = 1};
    sn_muscle_free(rig);
    *rig = (sn_muscle){.meters_per_unit = 1.0, .has_attachments = true};
    assert_int_equal(sn_mesh_alloc(&rig->mesh, 4, 2, NULL), SN_OK);
    for (int i = 0; i < 4; i++) rig->mesh.positions[i] = rest[i];
    rig->mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
    rig->mesh.triangles[1] = (sn_triangle){{1, 0, 3}};
    if (!attached) return;
    rig->attachments = SN_NEW(sn_attachment, 1);
    rig->attachment_count = 1;
    rig->attachments[0] =
        (sn_attachment){.bone = sn_strdup("upper"), .method = sn_strdup("pin"), .count = 2, .vertices = SN_NEW(sn_index, 2)};
    rig->attachments[0].vertices[1] = 1;
}

static void put_points(simulation *s, const sn_vec3 points[4]) {
    for (int i = 0; i < 4; i++) {
        sn_point *p = &s->state->muscles[0].points[i];
        p->x = points[i].x, p->y = points[i].y, p->z = points[i].z;
    }
}

static double next_random(void) {
    static uint64_t seed = 12345;
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    return (double)(seed >> 11) / 9007199254740992.0;
}

/* An edge of about `size` along x, its two triangles bent by `angle`, every coordinate off by some of it. */
static void random_hinge(double size, double angle, sn_vec3 p[4]) {
    p[0] = sn_v3(0, 0, 0), p[1] = sn_v3(1, 0, 0), p[2] = sn_v3(0.5, 0.9, 0), p[3] = sn_v3(0.5, -0.9 * cos(angle), -0.9 * sin(angle));
    for (int i = 0; i < 4; i++) p[i] = sn_scale(sn_add(p[i], sn_v3(0.2 * next_random(), 0.2 * next_random(), 0.2 * next_random())), size);
}

/* ---- the program, as it computes (Mueller et al. 2007, appendix A): relative to p1, in millimetres -------------------------------- */

static double angle_between_normals(const sn_vec3 p[4]) {
    sn_vec3 n1 = sn_normalize(sn_cross(sn_sub(p[1], p[0]), sn_sub(p[2], p[0])));
    sn_vec3 n2 = sn_normalize(sn_cross(sn_sub(p[0], p[1]), sn_sub(p[3], p[1])));
    return acos(sn_dot(n1, n2));
}

/* (x cross n + d (m cross x)) / |y| */
static sn_vec3 turned(sn_vec3 x, sn_vec3 n, sn_vec3 m, double d, double length) {
    return sn_scale(sn_add_scaled(sn_cross(x, n), sn_cross(m, x), d), 1.0 / length);
}

/* Moves of the four points, mm; the factor lambda, mm^2. False: it leaves the hinge out. */
static bool moves_of_program(const sn_vec3 at[4], double phi0, const double w[4], sn_vec3 moves[4], double *lambda) {
    sn_vec3 p2 = sn_sub(at[1], at[0]), p3 = sn_sub(at[2], at[0]), p4 = sn_sub(at[3], at[0]);
    sn_vec3 c23 = sn_cross(p2, p3), c24 = sn_cross(p2, p4), n1 = sn_normalize(c23), n2 = sn_normalize(c24);
    double d = sn_dot(n1, n2), a23 = sn_norm(c23), a24 = sn_norm(c24), sum = 0.0, weights = 0.0;
    if (d > 1.0 - 1e-10 || d < -1.0 + 1e-10) return false;
    sn_vec3 q[4];
    q[2] = turned(p2, n2, n1, d, a23);
    q[3] = turned(p2, n1, n2, d, a24);
    q[1] = sn_scale(sn_add(turned(p3, n2, n1, d, a23), turned(p4, n1, n2, d, a24)), -1.0);
    q[0] = sn_scale(sn_add(q[1], sn_add(q[2], q[3])), -1.0);
    for (int i = 0; i < 4; i++) sum += sn_norm2(q[i]), weights += w[i];
    *lambda = -4.0 * 0.9 * sqrt(1.0 - d * d) * (acos(d) - (SN_PI - phi0)) / (fmax(1e-4, sum) * weights);
    if (*lambda < 0.1 || *lambda > 10.0) return false;
    for (int i = 0; i < 4; i++) moves[i] = sn_scale(q[i], *lambda * w[i]);
    return true;
}

static void check_hinge(double size, double rest_angle, double angle, bool attached, int seen[2]) {
    const double w[4] = {attached ? 0.0 : 1.0, attached ? 0.0 : 1.0, 1.0, 1.0};
    sn_vec3 rest[4], at[4], in_mm[4], moves[4] = {{0}};
    double lambda = 0.0;
    random_hinge(size, rest_angle, rest);
    random_hinge(size, angle, at);
    for (int i = 0; i < 4; i++) in_mm[i] = sn_scale(at[i], 1000.0);
    bool acts = moves_of_program(in_mm, angle_between_normals(rest), w, moves, &lambda);
    if (fabs(lambda - 0.1) < 1e-6 || fabs(lambda - 10.0) < 1e-6) return; /* rounding decides */
    sn_scene scene;
    make_hinge(&scene, rest, SN_HINGES_SCHEME, attached);
    simulation s = start(&scene);
    put_points(&s, at);
    sn_project(s.model, s.state, 0, SN_ROWS_DIHEDRAL);
    for (int i = 0; i < 4; i++) {
        sn_vec3 want = acts ? sn_add_scaled(at[i], moves[i], 1e-3) : at[i];
        assert_true(sn_distance(position(&s, i), want) <= (acts ? 1e-9 * size : 0.0));
    }
    seen[acts]++;
    finish(&s);
}

static void published_hinges_are_the_programs(void **state) {
    (void)state;
    static const double sizes[] = {0.3e-3, 2e-3, 6e-3};
    for (int k = 0; k < 3; k++) {
        for (int attached = 0; attached < 2; attached++) {
            int seen[2] = {0, 0};
            for (int i = 0; i < 60; i++) {
                double rest = 2.4 * (next_random() - 0.5);
                check_hinge(sizes[k], rest, i % 3 == 0 ? rest : 5.0 * (next_random() - 0.5), attached != 0, seen);
            }
            assert_true(seen[0] >= 5);
            assert_true(k == 0 || seen[1] >= 5); /* below a millimetre lambda is hardly ever 0.1 mm^2 */
        }
    }
}

/* A flat hinge has no gradient, and one that is less bent than at rest is left alone. */
static void published_hinges_act_in_one_sense(void **state) {
    (void)state;
    static const double angles[] = {0.0, 0.1, 0.3};
    const sn_vec3 rest[4] = {{0, 0, 0}, {2e-3, 0, 0}, {1e-3, 2e-3, 0}, {1e-3, -1.8e-3, -0.8e-3}};
    for (int i = 0; i < 3; i++) {
        const sn_vec3 at[4] = {rest[0], rest[1], rest[2], {1e-3, -2e-3 * cos(angles[i]), -2e-3 * sin(angles[i])}};
        for (int rule = SN_HINGES_PUBLISHED; rule <= SN_HINGES_PRINTED; rule++) {
            sn_scene scene;
            make_hinge(&scene, rest, (sn_hinge_rule)rule, false);
            simulation s = start(&scene);
            put_points(&s, at);
            sn_project(s.model, s.state, 0, SN_ROWS_DIHEDRAL);
            bool moved = false;
            for (int k = 0; k < 4; k++) moved = moved || sn_distance(position(&s, k), at[k]) > 0.0;
            assert_int_equal(moved, rule == SN_HINGES_PRINTED);
            finish(&s);
        }
    }
}

/* The printed equations have no limit: arms of a hundred edges, off by 3 rad, would move by a hundred. */
static void printed_hinges_move_no_point_far(void **state) {
    (void)state;
    const sn_vec3 rest[4] = {{0, 0, 0}, {2e-3, 0, 0}, {1e-3, 2e-3, 0}, {1e-3, -2e-3, 0}};
    const sn_vec3 at[4] = {rest[0], rest[1], {1e-3, 0.2, 0}, {1e-3, 0.19, 0.01}};
    sn_scene scene;
    make_hinge(&scene, rest, SN_HINGES_PRINTED, false);
    simulation s = start(&scene);
    double farthest = 0.0, most = 0.2 * s.model->muscles[0].mean_edge;
    put_points(&s, at);
    sn_project(s.model, s.state, 0, SN_ROWS_DIHEDRAL);
    for (int i = 0; i < 4; i++) farthest = fmax(farthest, sn_distance(position(&s, i), at[i]));
    assert_true(fabs(farthest - most) < 1e-9 * most);
    finish(&s);
}

/* ---- muscles ------------------------------------------------------------------------------------------------------------------- */

static double greatest_difference(const simulation *a, const simulation *b) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++) most = fmax(most, sn_distance(position(a, i), position(b, i)));
    return most / a->model->muscles[0].diagonal;
}

static simulation start_muscle(sn_scene *scene, const fusiform *f, sn_hinge_rule rule, sn_precision precision, sn_index iterations) {
    make_scene(scene, f);
    scene->solver.scheme = SN_SCHEME_KOHOUT;
    scene->solver.hinges = rule;
    scene->solver.precision = precision;
    scene->solver.substeps = 1;
    scene->solver.iterations = iterations;
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 45.0 / 24.0, SN_PI / 2.0); /* 2 degrees a frame */
    return start(scene);
}

/* The limits are in millimetres whatever the document's unit is, and the same in both precisions until a hinge is at a limit. */
static void the_unit_and_the_precision_do_not_matter(void **state) {
    (void)state;
    fusiform in_mm = FUSIFORM;
    in_mm.meters_per_unit = 1e-3;
    for (int rule = SN_HINGES_PUBLISHED; rule <= SN_HINGES_PRINTED; rule++) {
        sn_scene scenes[3];
        simulation s[3];
        for (int k = 0; k < 3; k++) {
            s[k] = start_muscle(&scenes[k], k == 1 ? &in_mm : &FUSIFORM, (sn_hinge_rule)rule, (sn_precision)(k == 2), 3);
            step_frames(&s[k], 4, NULL);
        }
        assert_true(greatest_difference(&s[0], &s[1]) < 1e-9);
        assert_true(greatest_difference(&s[0], &s[2]) < 1e-4);
        for (int k = 0; k < 3; k++) finish(&s[k]);
    }
}

static void both_rules_stay_finite(void **state) {
    (void)state;
    for (int rule = SN_HINGES_PUBLISHED; rule <= SN_HINGES_PRINTED; rule++) {
        for (int k = 0; k < 4; k++) {
            sn_scene scene;
            simulation s = start_muscle(&scene, &FUSIFORM, (sn_hinge_rule)rule, (sn_precision)(k / 2), k % 2 == 0 ? 1 : 10);
            step_frames(&s, 45, NULL);
            const sn_statistics *st = &s.state->muscles[0].statistics;
            assert_int_equal(st->nan_points, 0);
            assert_true(fabs(st->volume_error) < 0.05);
            finish(&s);
        }
    }
}

static void other_schemes_have_no_choice(void **state) {
    (void)state;
    for (int scheme = SN_SCHEME_GUARDED; scheme <= SN_SCHEME_KOHOUT; scheme++) {
        for (int rule = SN_HINGES_SCHEME; rule <= SN_HINGES_PRINTED; rule++) {
            sn_scene scene;
            sn_model *model = NULL;
            sn_error error = {0};
            make_scene(&scene, &FUSIFORM);
            scene.solver.scheme = (sn_scheme)scheme;
            scene.solver.hinges = (sn_hinge_rule)rule;
            bool good = scheme == SN_SCHEME_KOHOUT || rule == SN_HINGES_SCHEME;
            assert_int_equal(sn_model_create(&scene, &model, &error), good ? SN_OK : SN_ERROR_INPUT);
            if (!good) assert_non_null(strstr(error.text, "solver.hinges"));
            sn_model_destroy(model);
            sn_scene_free(&scene);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published_hinges_are_the_programs),
        cmocka_unit_test(published_hinges_act_in_one_sense),
        cmocka_unit_test(printed_hinges_move_no_point_far),
        cmocka_unit_test(the_unit_and_the_precision_do_not_matter),
        cmocka_unit_test(both_rules_stay_finite),
        cmocka_unit_test(other_schemes_have_no_choice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
