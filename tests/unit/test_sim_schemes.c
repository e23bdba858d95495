/* test_sim_schemes.c -- the schemes, the forms of anisotropy, maps and curves, least areas; restart; what is off is absent. */
#include "sim_inside.h"

#include <malloc.h>

static const sn_statistics *statistics(const simulation *s) { return &s->state->muscles[0].statistics; }

/* One free triangle: the smallest scene that has a row. */
static void make_triangle(sn_scene *scene, sn_scheme scheme, sn_anisotropy anisotropy, sn_vec3 fiber) {
    sn_scene_defaults(scene);
    scene->name = sn_strdup("triangle");
    scene->solver = (sn_solver_settings){.method = SN_SOLVER_XPBD, .scheme = scheme, .substeps = 1, .iterations = 1};
    scene->muscles = SN_NEW(sn_scene_muscle, 1);
    scene->muscle_count = 1;
    sn_scene_muscle *m = scene->muscles;
    *m = (sn_scene_muscle){.name = sn_strdup("triangle"), .uri = sn_strdup("memory")};
    sn_scene_muscle_defaults(m);
    m->anisotropy = anisotropy;
    m->least_area = 0.0;
    m->damping = 0.0;
    m->rig.meters_per_unit = 1.0;
    assert_int_equal(sn_mesh_alloc(&m->rig.mesh, 3, 1, NULL), SN_OK);
    m->rig.mesh.positions[1] = sn_v3(1, 0, 0);
    m->rig.mesh.positions[2] = sn_v3(0, 1, 0);
    m->rig.mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
    m->rig.fibers.directions = SN_NEW(sn_vec3, 3);
    for (int i = 0; i < 3; i++) m->rig.fibers.directions[i] = fiber;
}

/* [K21] eq. 1 with eq. 9: a single projection of an edge of length l, rest length 1, points of equal mass, moves each by k (l - 1) / 2. The
 * edge 0-1 comes first; w = 1, so lambda is the move of point 0. */
static void kohout_is_a_plain_projection_times_k(void **state) {
    (void)state;
    static const double angles[] = {0.0, 30.0, 60.0, 90.0};
    for (int i = 0; i < 4; i++) {
        double angle = angles[i] * SN_PI / 180.0;
        sn_scene scene;
        make_triangle(&scene, SN_SCHEME_KOHOUT, SN_ANISOTROPY_SCHEME, sn_v3(cos(angle), 0, sin(angle)));
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        assert_true(m->inverse_mass[0] == 1.0 && m->inverse_mass[1] == 1.0);
        sn_point *p = s.state->muscles[0].points;
        p[1].x = 1.2;
        double k = 1.0 - cos(angle);
        assert_int_equal(m->distances[0].point[0] + m->distances[0].point[1], 1); /* the edge 0-1 */
        sn_project(s.model, s.state, 0, SN_ROWS_MESH);
        assert_true(fabs(xpbd_of(&s)->distance_lambda[0] + k * 0.2 / 2.0) < 1e-12);
        finish(&s);
    }
}

/* The XPBD form: alpha / k. One projection from rest takes lambda = -(l - 1) / (w0 + w1 + alpha / (k h^2)). */
static void anisotropy_in_xpbd_form_divides_the_compliance(void **state) {
    (void)state;
    double angle = 60.0 * SN_PI / 180.0;
    sn_scene scene;
    make_triangle(&scene, SN_SCHEME_ROMEO, SN_ANISOTROPY_XPBD, sn_v3(cos(angle), 0, sin(angle)));
    scene.muscles[0].stiffness_relaxed = 1.0;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    double h = s.model->substep_duration, w = m->inverse_mass[0] + m->inverse_mass[1];
    s.state->muscles[0].points[1].x = 1.2;
    sn_project(s.model, s.state, 0, SN_ROWS_MESH);
    assert_true(fabs(xpbd_of(&s)->distance_lambda[0] + 0.2 / (w + 1.0 / (0.5 * h * h))) < 1e-12);
    finish(&s);
}

/* [K21] alg. 2 line 12: the velocity times 0.99 in each step. */
static void kohout_damps_by_a_factor_per_step(void **state) {
    (void)state;
    sn_scene scene;
    make_triangle(&scene, SN_SCHEME_KOHOUT, SN_ANISOTROPY_NONE, sn_v3(0, 0, 1));
    simulation s = start(&scene);
    for (int i = 0; i < 3; i++) s.state->muscles[0].velocities[i] = sn_v3(0, 0, 1);
    step_frames(&s, 10, NULL);
    for (int i = 0; i < 3; i++) assert_true(fabs(s.state->muscles[0].velocities[i].z - pow(0.99, 10)) < 1e-12);
    finish(&s);
}

static void schemes_leave_out_what_their_papers_do_not_have(void **state) {
    (void)state;
    static const bool has[3][SN_ROW_KINDS] = {{true, true, true, true, true, false, true},
                                              {true, true, true, false, false, false, true},
                                              {false, false, true, true, false, false, true}};
    for (int scheme = 0; scheme < 3; scheme++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver.scheme = (sn_scheme)scheme;
        simulation s = start(&scene);
        for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
            bool off = (kind == SN_ROWS_CONTACT && scheme != SN_SCHEME_ROMEO) || (kind == SN_ROWS_EXTERNAL && scheme != SN_SCHEME_KOHOUT);
            sn_left_out lacks = off ? SN_OUT_SETTING : SN_OUT_SCHEME;
            assert_int_equal(s.model->plan.muscles[0].groups[kind].reason, has[scheme][kind] ? SN_RUNS : lacks);
            assert_true((s.model->plan.muscles[0].groups[kind].rows > 0) == has[scheme][kind]);
        }
        step_frames(&s, 6, NULL);
        assert_true(greatest_move(&s) < 1e-9); /* and rest is rest */
        finish(&s);
    }
}

/* A crushed muscle: without the row triangles collapse, with it none is left much below the least area. */
static void no_triangle_collapses(void **state) {
    (void)state;
    double smallest[2];
    for (int held = 0; held < 2; held++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.muscles[0].least_area = held ? 0.5 : 0.0;
        scene.muscles[0].contraction = 0.9;
        set_keys(&scene.muscles[0].activation, 0.0, 0.0, 0.5, 1.0);
        simulation s = start(&scene);
        smallest[held] = 1.0;
        for (int frame = 0; frame < 36; frame++) {
            step_frames(&s, 1, NULL);
            smallest[held] = fmin(smallest[held], statistics(&s)->smallest_triangle);
        }
        finish(&s);
    }
    assert_true(smallest[0] < 0.2);
    assert_true(smallest[1] > 0.4);
}

static void paint(sn_scene *scene, const char *name, double lower, double upper) {
    sn_mesh *mesh = &scene->muscles[0].rig.mesh;
    sn_attribute *map = sn_mesh_add_attribute(mesh, name, 1);
    assert_non_null(map);
    for (sn_index v = 0; v < mesh->vertex_count; v++) map->values[v] = mesh->positions[v].z > 0.1 ? upper : lower;
}

/* A tendon (share 0) keeps its goal lengths; the belly (share 1) has those of a muscle without a map. */
static void a_map_keeps_the_tendon_from_contracting(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    paint(&scene, "share", 1.0, 0.0);
    scene.muscles[0].activation_map = sn_strdup("share");
    scene.muscles[0].activation.constant = 1.0;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_index tendon = 0, belly = 0;
    for (sn_index r = m->distance_start[SN_ROWS_MESH]; r < m->distance_start[SN_ROWS_MESH + 1]; r++) {
        const sn_index *p = m->distances[r].point;
        double rest = sn_distance(m->rest[p[0]], m->rest[p[1]]), goal = inputs_of(&s)->goals[r];
        double whole = sn_goal_length(SN_LAW_PROJECTED, m->distance_terms[r], 0.5, 0.0, 1.0);
        if (m->rest[p[0]].z > 0.1 && m->rest[p[1]].z > 0.1) tendon += fabs(goal / rest - 1.0) < 1e-12;
        if (m->rest[p[0]].z <= 0.1 && m->rest[p[1]].z <= 0.1) belly += goal == whole && goal < rest;
    }
    assert_true(tendon > 100 && belly > 100);
    finish(&s);
}

/* The softness of a row is one over the mean of the map at its ends (and over its share of the area, switched off here). */
static void a_map_scales_the_stiffness(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    paint(&scene, "stiffness", 4.0, 4.0);
    scene.muscles[0].stiffness_map = sn_strdup("stiffness");
    scene.muscles[0].stiffness_scaled = false;
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index r = m->distance_start[SN_ROWS_RADIAL]; r < m->distance_start[SN_DISTANCE_KINDS]; r++)
        assert_true(m->distance_softness[r] == 0.25);
    assert_null(m->hinge_softness);
    finish(&s);
}

/* A curve of stiffness passes through its knots, and between two of them runs in log scale. */
static void a_curve_of_stiffness_passes_through_its_knots(void **state) {
    (void)state;
    static const double levels[] = {0.0, 0.5, 1.0}, wanted[] = {1e5, 1e6, 1e7};
    for (int i = 0; i < 3; i++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.muscles[0].stiffness_curve = (sn_knots){2, SN_NEW(double, 2), SN_NEW(double, 2)};
        scene.muscles[0].stiffness_curve.x[1] = 1.0;
        scene.muscles[0].stiffness_curve.y[0] = 1e5;
        scene.muscles[0].stiffness_curve.y[1] = 1e7;
        scene.muscles[0].activation.constant = levels[i];
        simulation s = start(&scene);
        assert_true(fabs(inputs_of(&s)->stiffness / wanted[i] - 1.0) < 1e-12);
        finish(&s);
    }
}

/* Off leaves no array, no byte: what the scene switches off is as if it had never been. */
static void off_equals_absent(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &FUSIFORM);
        set_keys(&scenes[k].muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
        scenes[k].muscles[0].stiffness_scaled = false;
        scenes[k].muscles[0].least_area = 0.0;
    }
    paint(&scenes[0], "unused", 0.5, 0.5);
    scenes[0].muscles[0].anisotropy = SN_ANISOTROPY_NONE;
    for (int k = 0; k < 2; k++) {
        runs[k] = start(&scenes[k]);
        const sn_model_muscle *m = &runs[k].model->muscles[0];
        assert_true(m->distance_softness == NULL && m->distance_gain == NULL && m->distance_share == NULL && m->hinge_softness == NULL);
        assert_true(m->areas == NULL && m->area_scales == NULL);
        step_frames(&runs[k], 6, NULL);
    }
    const sn_plan_muscle *p = runs[0].model->plan.muscles, *q = runs[1].model->plan.muscles;
    assert_true(p->model_bytes == q->model_bytes && p->state_bytes == q->state_bytes);
    size_t size = (size_t)runs[0].model->muscles[0].point_count * sizeof(sn_point);
    assert_memory_equal(runs[0].state->muscles[0].points, runs[1].state->muscles[0].points, size);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

/* Every array of a model is there unless it may be left out, and as long as its count says: the allocator, which rounds a block up by
 * less than 48 bytes, holds no more of it. Returns the bytes of all. */
static size_t check_arrays(const sn_model_muscle *m) {
    size_t bytes = sizeof *m;
#define CHECK(type, name, count, nullable, fitted)                                                                                         \
    if (!(nullable) && (count) > 0) assert_non_null(m->name);                                                                              \
    if (m->name != NULL) {                                                                                                                 \
        size_t size = (size_t)(count) * sizeof(type), held = malloc_usable_size(m->name);                                                  \
        assert_true(held >= size && held < size + 48);                                                                                     \
        bytes += size;                                                                                                                     \
    }
    SN_MODEL_ARRAYS(CHECK)
#undef CHECK
    return bytes;
}

/* The plan's bytes are those that were allocated, under every option that adds an array or leaves one out. */
static void the_plan_counts_what_is_allocated(void **state) {
    (void)state;
    fusiform bare = FUSIFORM;
    bare.structure = false, bare.pinned = 0.0;
    for (int k = 0; k < 5; k++) {
        sn_scene scene;
        make_scene(&scene, k == 1 ? &bare : &FUSIFORM);
        paint(&scene, "map", 0.5, 0.5);
        scene.solver = sn_solver_defaults(k < 4 ? SN_SOLVER_XPBD : SN_SOLVER_QN);
        if (k == 1) scene.muscles[0].activation_map = sn_strdup("map"), scene.muscles[0].anisotropy = SN_ANISOTROPY_PBD;
        if (k == 2) scene.solver.precision = SN_PRECISION_SINGLE;
        if (k == 3) scene.solver.scheme = SN_SCHEME_KOHOUT;
        if (k == 4) scene.muscles[0].stretch = SN_STRETCH_MEMBRANE, scene.muscles[0].stiffness_map = sn_strdup("map");
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        assert_true((m->distance_gain != NULL) == (k == 1 || k == 3) && (m->distance_share != NULL) == (k == 1));
        assert_true((m->area_pairs != NULL) == (k == 2) && (m->own[SN_ROWS_MEMBRANE] != NULL) == (k == 4));
        size_t own = sn_rows_membrane.own_bytes(m, SN_ROWS_MEMBRANE);
        assert_true((own > 0) == (k == 4));
        assert_int_equal(s.model->plan.muscles[0].model_bytes, check_arrays(m) + own);
        finish(&s);
    }
}

/* Every number of a packed state comes back; a flipped bit, a missing byte and another model are found. */
static void a_state_survives_and_damage_is_found(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    char *bytes = NULL, *again = NULL;
    size_t size = 0, size_again = 0;
    sn_error error = {0};
    for (int k = 0; k < 2; k++) {
        make_scene(&scenes[k], &FUSIFORM);
        set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, 1.0, -0.5);
        runs[k] = start(&scenes[k]);
    }
    sn_step_options stop = {.stop_substep = 7, .stop_iteration = 1};
    step_frames(&runs[0], 2, NULL);
    assert_int_equal(sn_step(runs[0].model, runs[0].state, &stop, NULL), SN_STOPPED);
    assert_int_equal(sn_state_pack(runs[0].model, runs[0].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(runs[1].model, bytes, size, runs[1].state, NULL), SN_OK);
    assert_int_equal(runs[1].state->frame, 3);
    assert_int_equal(sn_state_pack(runs[1].model, runs[1].state, &again, &size_again, NULL), SN_OK);
    assert_int_equal(size, size_again);
    assert_memory_equal(bytes, again, size);
    for (size_t at = 0; at < size; at += size / 97 + 1) {
        bytes[at] ^= 16;
        assert_int_equal(sn_state_unpack(runs[1].model, bytes, size, runs[1].state, &error), SN_ERROR_INPUT);
        bytes[at] ^= 16;
    }
    for (size_t less = 0; less < size; less += size / 13)
        assert_int_equal(sn_state_unpack(runs[1].model, bytes, less, runs[1].state, &error), SN_ERROR_INPUT);
    free(bytes);
    free(again);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kohout_is_a_plain_projection_times_k),
        cmocka_unit_test(anisotropy_in_xpbd_form_divides_the_compliance),
        cmocka_unit_test(kohout_damps_by_a_factor_per_step),
        cmocka_unit_test(schemes_leave_out_what_their_papers_do_not_have),
        cmocka_unit_test(no_triangle_collapses),
        cmocka_unit_test(a_map_keeps_the_tendon_from_contracting),
        cmocka_unit_test(a_map_scales_the_stiffness),
        cmocka_unit_test(a_curve_of_stiffness_passes_through_its_knots),
        cmocka_unit_test(off_equals_absent),
        cmocka_unit_test(the_plan_counts_what_is_allocated),
        cmocka_unit_test(a_state_survives_and_damage_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
