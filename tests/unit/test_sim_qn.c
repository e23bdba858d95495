/* test_sim_qn.c -- back end `qn`: its gradient, its equilibrium against xpbd's, rest, free flight, wrecked starts, threads, stops. */
#include "../../lib/sim/skin.h"
#include "sim_inside.h"

static void make_newton(sn_scene *scene, const fusiform *f) {
    make_scene(scene, f);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->muscles[0].contraction = 0.3;
    set_keys(&scene->muscles[0].activation, 0.0, 0.0, 1.0, 1.0);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 1.0, -30.0 * SN_PI / 180.0);
}

static const sn_statistics *statistics(const simulation *s) { return &s->state->muscles[0].statistics; }

static double greatest_difference(const simulation *a, const simulation *b) {
    double most = 0.0;
    for (sn_index i = 0; i < a->model->muscles[0].point_count; i++) most = fmax(most, sn_distance(position(a, i), position(b, i)));
    return most;
}

/* dPhi/dx = (Phi(x + e) - Phi(x - e)) / 2e for every kind of row, at a crumpled pose, where barriers act too. */
static void the_gradient_is_that_of_the_energy(void **state) {
    (void)state;
    sn_scene scene;
    make_newton(&scene, &FUSIFORM);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_muscle_state *ms = &s.state->muscles[0];
    uint64_t random = 11;
    inputs_of(&s)->volume_goal = 1.2;
    for (sn_index r = 0; r < m->area_count; r++) inputs_of(&s)->guarded[r] = true;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_point *p = &ms->points[i];
        qn_of(&s)->target[i] = m->rest[i];
        if (p->w == 0.0) continue;
        p->x += 3e-3 * (sn_random(&random) - 0.5), p->y += 3e-3 * (sn_random(&random) - 0.5), p->z += 3e-3 * (sn_random(&random) - 0.5);
    }
    const sn_objective objective = objective_of(&s, 1.0 / 24.0);
    sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count), *other = SN_NEW(sn_vec3, m->point_count);
    sn_objective_evaluate(&objective, ms->points, gradient);
    double largest = 0.0, worst = 0.0, e = 1e-8;
    for (sn_index i = 0; i < m->point_count; i++) {
        double *coordinates[3] = {&ms->points[i].x, &ms->points[i].y, &ms->points[i].z};
        const double found[3] = {gradient[i].x, gradient[i].y, gradient[i].z};
        for (int c = 0; c < 3; c++) {
            double at = *coordinates[c];
            if (ms->points[i].w == 0.0) {
                assert_true(found[c] == 0.0);
                continue;
            }
            *coordinates[c] = at + e;
            double high = sn_objective_evaluate(&objective, ms->points, other);
            *coordinates[c] = at - e;
            double low = sn_objective_evaluate(&objective, ms->points, other);
            *coordinates[c] = at;
            largest = fmax(largest, fabs(found[c]));
            worst = fmax(worst, fabs((high - low) / (2.0 * e) - found[c]));
        }
    }
    assert_true(worst < 1e-5 * largest); /* what differences of an energy of this size can tell */
    free(gradient);
    free(other);
    finish(&s);
}

/* ---- the skin: all kinds of rows of a closed surface together ---------------------------------------------------------------------- */

static const sn_row_kind SKIN[] = {SN_ROWS_MESH, SN_ROWS_DIHEDRAL, SN_ROWS_AREA, SN_ROWS_VOLUME};

static void crumple(const simulation *s, double by, uint64_t seed) {
    const sn_model_muscle *m = &s->model->muscles[0];
    uint64_t random = seed;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_point *p = &s->state->muscles[0].points[i];
        if (p->w == 0.0) continue;
        p->x += by * (sn_random(&random) - 0.5), p->y += by * (sn_random(&random) - 0.5), p->z += by * (sn_random(&random) - 0.5);
    }
}

/* Energy, gradient and dV/dx of the skin at the state's points are the sums of its kinds'. */
static void compare_skin(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_muscle_state *ms = &s->state->muscles[0];
    sn_vec3 *one = SN_NEW(sn_vec3, m->point_count), *all = SN_NEW(sn_vec3, m->point_count), *volume = SN_NEW(sn_vec3, m->point_count);
    double sum = 0.0, most = 0.0, size = 0.0, volumes = 0.0, largest = 0.0;
    assert_true(m->skin_edge_count > 0 && m->skin_triangle_count == m->triangle_count);
    for (size_t k = 0; k < sizeof SKIN / sizeof *SKIN; k++) {
        assert_true(sn_skin_has(m, SKIN[k]));
        sum += sn_rows_energy(m, ms, SKIN[k], ms->points, (sn_forces){&one->x, 3});
    }
    for (sn_index v = 0; v < m->vertex_count && m->keeps_volume; v++) volume[v] = ms->inputs->volume_gradient[v];
    double energy = sn_skin_evaluate(m, ms, ms->points, (sn_forces){&all->x, 3});
    for (sn_index i = 0; i < m->point_count; i++) {
        most = fmax(most, sn_distance(one[i], all[i]));
        size = fmax(size, sn_norm(one[i]));
    }
    assert_true(isfinite(energy) && fabs(energy - sum) <= 1e-12 * sum);
    assert_true(size > 0.0 && most <= 1e-11 * size);
    if (m->keeps_volume) sn_skin_volume_gradient(m, ms);
    for (sn_index v = 0; v < m->vertex_count && m->keeps_volume; v++) {
        volumes = fmax(volumes, sn_distance(volume[v], ms->inputs->volume_gradient[v]));
        largest = fmax(largest, sn_norm(volume[v]));
    }
    assert_true(volumes <= 1e-11 * largest);
    free(one);
    free(all);
    free(volume);
}

static void the_skin_is_the_sum_of_its_kinds(void **state) {
    (void)state;
    for (int variant = 0; variant < 6; variant++) {
        sn_scene scene;
        make_newton(&scene, &FUSIFORM);
        sn_scene_muscle *muscle = &scene.muscles[0];
        if (variant == 1) muscle->stiffness_volume = 0.0;
        if (variant == 2) muscle->least_area = 0.0;
        if (variant == 3) muscle->stiffness_scaled = false;
        if (variant == 4) muscle->anisotropy = SN_ANISOTROPY_XPBD;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        inputs_of(&s)->volume_goal = 1.2;
        for (sn_index r = 0; r < m->area_count; r++) inputs_of(&s)->guarded[r] = variant != 5 || r % 3 != 0;
        for (uint64_t seed = 1; seed <= 5; seed++) { /* from a dent to a wreck */
            crumple(&s, 1e-3 * (double)(seed * seed), seed);
            compare_skin(&s);
        }
        sn_point *points = s.state->muscles[0].points; /* a triangle on a line, an edge without length, and a fold back */
        const sn_index *v = m->triangles[m->triangle_count / 2].v, *u = m->triangles[m->triangle_count / 3].v;
        if (points[v[1]].w > 0.0) sn_put(&points[v[1]], sn_point_position(&points[v[0]]));
        if (points[u[2]].w > 0.0) sn_put(&points[u[2]], sn_lerp(sn_point_position(&points[u[0]]), sn_point_position(&points[u[1]]), 0.5));
        compare_skin(&s);
        finish(&s);
    }
}

/* Nothing is kept for those that have none. */
static void what_has_no_skin(void **state) {
    (void)state;
    for (int variant = 0; variant < 4; variant++) {
        sn_scene scene;
        make_newton(&scene, &FUSIFORM);
        if (variant == 0) scene.muscles[0].stretch = SN_STRETCH_MEMBRANE;
        if (variant == 1) scene.muscles[0].stiffness_dihedral = 0.0;
        if (variant == 2) sn_solver_change(&scene.solver, SN_SOLVER_XPBD);
        if (variant == 3) scene.muscles[0].rig.mesh.triangle_count--; /* a hole */
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        assert_int_equal(m->skin_edge_count, 0);
        assert_int_equal(m->skin_triangle_count, 0);
        for (size_t k = 0; k < sizeof SKIN / sizeof *SKIN; k++) assert_false(sn_skin_has(m, SKIN[k]));
        finish(&s);
    }
}

static void rest_stays_at_rest(void **state) {
    (void)state;
    for (int law = 0; law < 3; law++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver = sn_solver_defaults(SN_SOLVER_QN);
        scene.muscles[0].law = (sn_fiber_law)law;
        scene.muscles[0].rest_activation = scene.muscles[0].activation.constant = 0.8;
        simulation s = start(&scene);
        step_frames(&s, 5, NULL);
        assert_true(greatest_move(&s) < 1e-9);
        finish(&s);
    }
}

/* Without stiffness a step is y = x + h (v + h g) e^(-c h), to rounding. */
static void no_stiffness_is_free_flight(void **state) {
    (void)state;
    fusiform f = FUSIFORM;
    sn_scene scene;
    f.pinned = 0.0;
    make_scene(&scene, &f);
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    scene.gravity = sn_v3(0, 0, -9.81);
    scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = 0.0;
    simulation s = start(&scene);
    step_frames(&s, 10, NULL);
    double h = 1.0 / 24.0, keep = exp(-scene.muscles[0].damping * h), speed = 0.0, way = 0.0;
    for (int i = 0; i < 10; i++) {
        speed = speed * keep - 9.81 * h;
        way += speed * h;
    }
    for (sn_index i = 0; i < s.model->muscles[0].point_count; i++)
        assert_true(fabs(position(&s, i).z - s.model->muscles[0].rest[i].z - way) < 1e-9);
    finish(&s);
}

/* Run the usual motion to its end with these settings. */
static simulation run_usual(sn_scene *scene, sn_solver_settings solver, sn_index frames) {
    make_newton(scene, &FUSIFORM);
    scene->solver = solver;
    simulation s = start(scene);
    step_frames(&s, frames, NULL);
    return s;
}

/* Ten iterations a frame stay within 1e-4 L of the converged steps (numerics.md 2: 5e-4 at 5). */
static void few_iterations_are_close_to_convergence(void **state) {
    (void)state;
    sn_scene few_scene, exact_scene;
    sn_solver_settings few = sn_solver_defaults(SN_SOLVER_QN), exact = few;
    exact.iterations = 400;
    exact.tolerance = 1e-9;
    simulation a = run_usual(&few_scene, few, 24), b = run_usual(&exact_scene, exact, 24);
    assert_int_equal(statistics(&b)->nan_points, 0);
    assert_true(statistics(&b)->stop_reason == SN_STOP_TOLERANCE || statistics(&b)->stop_reason == SN_STOP_STALLED);
    assert_true(greatest_difference(&a, &b) < 1e-4 * a.model->muscles[0].diagonal);
    assert_true(greatest_move(&b) > 0.005);
    finish(&a);
    finish(&b);
}

/* Two methods, one implicit Euler step: XPBD iterated to convergence and qn agree where rows are soft enough for XPBD to converge (k h^2 w
 * of order 1), up to the square of the motion: XPBD sums its corrections along the gradients of the iterates, not of the end. */
static void xpbd_converges_to_the_same_step(void **state) {
    (void)state;
    simulation s[2];
    sn_scene scene[2];
    for (int i = 0; i < 2; i++) {
        sn_scene *at = &scene[i];
        make_scene(at, &FUSIFORM);
        at->solver = sn_solver_defaults(i == 0 ? SN_SOLVER_XPBD : SN_SOLVER_QN);
        at->solver.substeps = 1;
        at->solver.iterations = i == 0 ? 4000 : 500;
        at->solver.tolerance = 1e-12;
        at->muscles[0].stiffness_relaxed = at->muscles[0].stiffness_active = 2.0;
        at->muscles[0].stiffness_volume = 40.0;
        at->gravity = sn_v3(0, 0.02, 0);
        s[i] = start(at);
        step_frames(&s[i], 3, NULL);
    }
    double moved = greatest_move(&s[1]) / s[0].model->muscles[0].diagonal;
    assert_true(moved > 5e-4);
    assert_true(greatest_difference(&s[0], &s[1]) < 1e-6 * s[0].model->muscles[0].diagonal);
    finish(&s[0]);
    finish(&s[1]);
}

/* numerics.md 5: from coincident, flattened, random and mirrored points back to rest. */
static void wrecked_starts_recover(void **state) {
    (void)state;
    for (int wreck = 0; wreck < 4; wreck++) {
        sn_scene scene;
        make_scene(&scene, &FUSIFORM);
        scene.solver = sn_solver_defaults(SN_SOLVER_QN);
        scene.solver.iterations = 30;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        uint64_t random = 5;
        for (sn_index i = 0; i < m->point_count; i++) {
            sn_point *p = &s.state->muscles[0].points[i];
            if (p->w == 0.0) continue;
            if (wreck == 0) p->x = 0.001, p->y = 0.002, p->z = 0.1;
            if (wreck == 1) p->x = 0.0;
            if (wreck == 2) p->x = 0.1 * sn_random(&random), p->y = 0.1 * sn_random(&random), p->z = 0.2 * sn_random(&random);
            if (wreck == 3) p->x = -p->x;
        }
        step_frames(&s, 60, NULL);
        assert_int_equal(statistics(&s)->nan_points, 0);
        double away = greatest_move(&s) / m->diagonal;
        assert_true(away < 1e-6);
        finish(&s);
    }
}

/* A tip that jumps by 90 degrees and back: nothing is lost, and the muscle comes back to rest. */
static void a_teleported_bone_is_survived(void **state) {
    (void)state;
    sn_scene scene;
    make_scene(&scene, &FUSIFORM);
    scene.solver = sn_solver_defaults(SN_SOLVER_QN);
    sn_channel *angle = &scene.motion.joints[0].angle;
    *angle = (sn_channel){.count = 4, .times = SN_NEW(double, 4), .values = SN_NEW(double, 4)};
    const double times[] = {0.9, 0.901, 1.5, 1.501};
    for (int i = 0; i < 4; i++) angle->times[i] = times[i], angle->values[i] = i == 1 || i == 2 ? SN_PI / 2 : 0.0;
    simulation s = start(&scene);
    step_frames(&s, 30, NULL);
    assert_true(greatest_move(&s) > 0.01 && greatest_move(&s) < 2.0 * s.model->muscles[0].diagonal);
    step_frames(&s, 90, NULL);
    assert_int_equal(statistics(&s)->nan_points, 0);
    assert_true(greatest_move(&s) < 1e-6 * s.model->muscles[0].diagonal);
    finish(&s);
}

static void threads_change_no_bit(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation s[2];
    for (int i = 0; i < 2; i++) {
        make_newton(&scenes[i], &FUSIFORM);
        add_muscle(&scenes[i], "second", &FUSIFORM);
        s[i] = start(&scenes[i]);
        sn_pool *pool = i == 0 ? NULL : sn_pool_create(3);
        step_frames(&s[i], 8, &(sn_step_options){.pool = pool});
        sn_pool_destroy(pool);
    }
    for (int k = 0; k < 2; k++)
        assert_memory_equal(s[0].state->muscles[k].points, s[1].state->muscles[k].points,
                            (size_t)s[0].model->muscles[k].point_count * sizeof(sn_point));
    finish(&s[0]);
    finish(&s[1]);
}

/* What a kind costs is measured by many calls: each begins from zero. */
static void a_measured_gradient_does_not_grow(void **state) {
    (void)state;
    sn_scene scene;
    make_newton(&scene, &FUSIFORM);
    simulation s = start(&scene);
    step_frames(&s, 2, NULL);
    const sn_qn *qn = sn_qn_of(&s.state->groups[0]);
    size_t size = (size_t)s.model->muscles[0].point_count * sizeof(sn_point);
    sn_point *once = malloc(size);
    assert_non_null(once);
    sn_project(s.model, s.state, 0, SN_ROWS_MESH);
    memcpy(once, qn->forces, size);
    for (int i = 0; i < 10; i++) sn_project(s.model, s.state, 0, SN_ROWS_MESH);
    assert_memory_equal(once, qn->forces, size);
    free(once);
    finish(&s);
}

/* Stopped after an iteration of a frame, packed, unpacked into a fresh state and continued: the bits of the run that was not stopped. */
static void a_stop_changes_no_bit(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation s[3];
    for (int i = 0; i < 3; i++) {
        make_newton(&scenes[i], &FUSIFORM);
        s[i] = start(&scenes[i]);
    }
    step_frames(&s[0], 10, NULL);
    step_frames(&s[1], 6, NULL); /* in the middle of the way from one factor to the next */
    assert_int_equal(sn_step(s[1].model, s[1].state, &(sn_step_options){.stop_substep = 1, .stop_iteration = 4}, NULL), SN_STOPPED);
    char *bytes;
    size_t size;
    assert_int_equal(sn_state_pack(s[1].model, s[1].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s[2].model, bytes, size, s[2].state, NULL), SN_OK);
    free(bytes);
    for (int i = 1; i < 3; i++) {
        step_frames(&s[i], 4, NULL);
        assert_memory_equal(s[0].state->muscles[0].points, s[i].state->muscles[0].points,
                            (size_t)s[0].model->muscles[0].point_count * sizeof(sn_point));
    }
    for (int i = 0; i < 3; i++) finish(&s[i]);
}

/* Stopped where the tolerance has ended the step, but not its iterations: the residual, too, is that of the run that was not stopped. */
static void a_stop_after_the_tolerance_changes_no_residual(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation s[3];
    for (int i = 0; i < 3; i++) {
        make_newton(&scenes[i], &FUSIFORM);
        scenes[i].solver.tolerance = 1e-3;
        s[i] = start(&scenes[i]);
    }
    sn_index last = s[0].model->muscles[0].iterations - 1;
    step_frames(&s[0], 3, NULL);
    step_frames(&s[1], 2, NULL);
    assert_int_equal(sn_step(s[1].model, s[1].state, &(sn_step_options){.stop_substep = 1, .stop_iteration = last}, NULL), SN_STOPPED);
    assert_int_equal(qn_of(&s[1])->stopped, SN_STOP_TOLERANCE);
    char *bytes;
    size_t size;
    assert_int_equal(sn_state_pack(s[1].model, s[1].state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s[2].model, bytes, size, s[2].state, NULL), SN_OK);
    free(bytes);
    assert_true(statistics(&s[0])->residual > 0.0);
    for (int i = 1; i < 3; i++) {
        step_frames(&s[i], 1, NULL);
        assert_true(statistics(&s[i])->residual == statistics(&s[0])->residual);
    }
    for (int i = 0; i < 3; i++) finish(&s[i]);
}

/* Stiffness 5e5 -> 5e7 refactors about once per doubling, not once per frame. */
static void the_factor_is_kept_while_stiffness_changes_little(void **state) {
    (void)state;
    sn_scene scene;
    make_newton(&scene, &FUSIFORM);
    simulation s = start(&scene);
    int64_t refactored = 0;
    for (int frame = 0; frame < 24; frame++) {
        step_frames(&s, 1, NULL);
        refactored += statistics(&s)->refactorisations;
    }
    assert_in_range(refactored, 4, 8); /* log2(100) = 6.6 */
    finish(&s);
}

/* A bone that jumps tears the muscle: under every matrix it stays whole, and a run that stops in the middle of it goes on to the same bits.
 */
static void jumps_under_every_matrix(void **state) {
    (void)state;
    for (int matrix = SN_PRECONDITION_SCALAR; matrix <= SN_PRECONDITION_TWO_LEVEL; matrix++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_scene(&scenes[k], &FUSIFORM);
            scenes[k].solver = sn_solver_defaults(SN_SOLVER_QN);
            scenes[k].solver.preconditioner = (sn_preconditioning)matrix;
            scenes[k].solver.substeps = 1;
            scenes[k].motion.joints[0].point = sn_v3(0, 0, 0.1);
            set_keys(&scenes[k].motion.joints[0].angle, 1.5 / 24, 0.0, 1.5 / 24 + 1e-6, -1.4);
            runs[k] = start(&scenes[k]);
            step_frames(&runs[k], 1, NULL);
        }
        const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 4};
        assert_int_equal(sn_step(runs[1].model, runs[1].state, &stop, NULL), SN_STOPPED);
        for (int k = 0; k < 2; k++) step_frames(&runs[k], 1, NULL);
        const sn_muscle_state *s = &runs[0].state->muscles[0];
        assert_true(qn_of(&runs[0])->torn && s->statistics.refactorisations > 1);
        assert_true(s->statistics.nan_points == 0 && s->statistics.smallest_triangle > 0.05);
        size_t bytes = (size_t)runs[0].model->muscles[0].point_count * sizeof *s->points;
        assert_memory_equal(s->points, runs[1].state->muscles[0].points, bytes);
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

/* A bone that folds a muscle in its middle, by 40 degrees a frame. */
static void make_folded(sn_scene *scene, sn_index substeps, sn_preconditioning matrix) {
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->solver.substeps = substeps;
    scene->solver.preconditioner = matrix;
    scene->motion.joints[0].point = sn_v3(0, 0, 0.1);
    set_keys(&scene->motion.joints[0].angle, 1.0 / 24, 0.0, 3.0 / 24, -1.4);
}

typedef struct tally {
    int64_t work, steps, halvings; /* iterations, and 4 for each factor */
} tally;

static tally step_and_count(simulation *s, sn_index frames) {
    tally sum = {0};
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        sum.work += statistics(s)->iterations + 4 * statistics(s)->refactorisations;
        sum.steps += statistics(s)->steps;
        sum.halvings += statistics(s)->halvings;
    }
    return sum;
}

/* Where a step would tear the muscle, and only there, it is taken in halves; a number of substeps is that number. */
static void a_step_that_is_too_long_is_halved(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation s[3];
    tally t[3];
    for (int k = 0; k < 3; k++) {
        make_folded(&scenes[k], k == 0 ? SN_SUBSTEPS_AUTO : k == 1 ? 1 : 4, SN_PRECONDITION_SCALAR);
        s[k] = start(&scenes[k]);
        t[k] = step_and_count(&s[k], 5);
    }
    assert_true(t[0].halvings > 0 && t[0].steps > 5 && t[0].steps <= 5 * SN_SUBSTEP_PARTS);
    assert_true(t[1].steps == 5 && t[2].steps == 20 && t[1].halvings == 0 && t[2].halvings == 0);
    assert_true(4 * t[0].work <= 5 * t[1].work); /* of a fold that snaps: which step is halved depends on the last bits */
    assert_true(statistics(&s[0])->smallest_triangle > 0.05);
    t[0] = step_and_count(&s[0], 3); /* the bone stands still again */
    assert_true(t[0].steps == 3 && t[0].halvings == 0);
    for (int k = 0; k < 3; k++) finish(&s[k]);
}

static void ignore(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    (void)user, (void)number, (void)stage, (void)values, (void)value_count;
}

/* Stopped after any iteration of a frame with halved steps, packed and unpacked elsewhere; or watched: the same bits. */
static void halved_steps_are_stopped_at_any_iteration(void **state) {
    (void)state;
    for (int matrix = SN_PRECONDITION_SCALAR; matrix <= SN_PRECONDITION_TWO_LEVEL; matrix++) {
        sn_scene scenes[3];
        simulation s[3];
        for (int k = 0; k < 3; k++) {
            make_folded(&scenes[k], SN_SUBSTEPS_AUTO, (sn_preconditioning)matrix);
            s[k] = start(&scenes[k]);
        }
        size_t bytes = (size_t)s[0].model->muscles[0].point_count * sizeof(sn_point);
        sn_trace trace = {.receive = ignore, .stop_after = -1};
        for (sn_index frame = 1; frame <= 4; frame++) {
            step_frames(&s[0], 1, NULL);
            step_frames(&s[2], 1, &(sn_step_options){.trace = &trace});
            sn_status status = SN_STOPPED;
            for (sn_index i = frame; status == SN_STOPPED; i += 3) {
                char *packed;
                size_t size;
                status = sn_step(s[1].model, s[1].state, &(sn_step_options){.stop_substep = 1, .stop_iteration = i}, NULL);
                assert_int_equal(sn_state_pack(s[1].model, s[1].state, &packed, &size, NULL), SN_OK);
                sn_state_destroy(s[1].model, s[1].state);
                assert_int_equal(sn_state_create(s[1].model, &s[1].state, NULL), SN_OK);
                assert_int_equal(sn_state_unpack(s[1].model, packed, size, s[1].state, NULL), SN_OK);
                free(packed);
            }
            assert_int_equal(status, SN_OK);
            for (int k = 1; k < 3; k++) {
                assert_memory_equal(s[0].state->muscles[0].points, s[k].state->muscles[0].points, bytes);
                assert_true(statistics(&s[k])->halvings == statistics(&s[0])->halvings);
            }
        }
        for (int k = 0; k < 3; k++) finish(&s[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_gradient_is_that_of_the_energy),
        cmocka_unit_test(rest_stays_at_rest),
        cmocka_unit_test(no_stiffness_is_free_flight),
        cmocka_unit_test(few_iterations_are_close_to_convergence),
        cmocka_unit_test(xpbd_converges_to_the_same_step),
        cmocka_unit_test(wrecked_starts_recover),
        cmocka_unit_test(a_teleported_bone_is_survived),
        cmocka_unit_test(threads_change_no_bit),
        cmocka_unit_test(a_measured_gradient_does_not_grow),
        cmocka_unit_test(a_stop_changes_no_bit),
        cmocka_unit_test(a_stop_after_the_tolerance_changes_no_residual),
        cmocka_unit_test(jumps_under_every_matrix),
        cmocka_unit_test(the_skin_is_the_sum_of_its_kinds),
        cmocka_unit_test(what_has_no_skin),
        cmocka_unit_test(a_step_that_is_too_long_is_halved),
        cmocka_unit_test(halved_steps_are_stopped_at_any_iteration),
        cmocka_unit_test(the_factor_is_kept_while_stiffness_changes_little),
    };
    return cmocka_run_group_tests_name("qn", tests, NULL, NULL);
}
