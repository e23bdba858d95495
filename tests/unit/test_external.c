/* test_external.c -- external constraints (external*.c, group.c): weights, energies, momentum, groups, what slides and what is held,
 * targets that move by themselves, order of muscles, stopping, sleep, and all of it off. */
#include "contact_scene.h"

#include "../../lib/sim/external.h"
#include "../../lib/sim/qn.h"
#include "sim_inside.h"
#include "tied_scene.h"

static const sn_solver_method METHODS[2] = {SN_SOLVER_XPBD, SN_SOLVER_QN};

/* Two spindles side by side, 2 mm apart, between the same bones. */
static void make_pair(sn_scene *scene, sn_solver_method method, const double weights[3]) {
    fusiform small = FUSIFORM, other;
    small.rings = 15, small.sectors = 10, small.structure = false;
    other = small;
    other.offset.x += 0.062;
    make_scene(scene, &small);
    add_muscle(scene, "neighbour", &other);
    scene->solver = sn_solver_defaults(method);
    for (int i = 0; i < 2; i++) scene->muscles[i].stiffness_relaxed = scene->muscles[i].stiffness_active = 2000.0;
    tie_all(TIED_REACH, scene, weights);
}

static void bend(sn_scene *scene, double angle) { set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.4, angle); }

static double greatest_error(const simulation *s, sn_index muscle) {
    return sn_rows_residual(&s->model->muscles[muscle], &s->state->muscles[muscle], SN_ROWS_EXTERNAL, NULL).max;
}

/* ---- groups and rows --------------------------------------------------------------------------------------------------------------- */

static void weights_are_those_of_the_paper(void **state) {
    (void)state;
    static const double told[4][3] = {{1, 0, 0}, {0, 0.5, 0.5}, {0.5, 0.25, 0.75}, {0.25, 0, 0}};
    static const double right[4][3] = {{1, 0, 0}, {0, 0.5, 0.5}, {0.5, 0.125, 0.375}, {0.25, 0, 0}}; /* eqs 11 to 13 */
    for (int i = 0; i < 4; i++) {
        sn_scene scene;
        make_pair(&scene, SN_SOLVER_QN, told[i]);
        simulation s = start(&scene);
        const sn_externals *all = sn_externals_of(&s.model->muscles[0]);
        for (sn_index r = 0; r < s.model->muscles[0].external_count; r++)
            for (int k = 0; k < 3; k++) assert_true(fabs(all->rows[r].weights[k] - right[i][k]) < 1e-15);
        finish(&s);
    }
}

static void muscles_that_touch_are_one_group_and_rest_is_rest(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        fusiform lone = FUSIFORM;
        make_pair(&scene, METHODS[i], MIXED);
        lone.offset.x -= 0.2;
        add_muscle(&scene, "lone", &lone);
        simulation s = start(&scene);
        assert_int_equal(s.model->group_count, 2);
        assert_int_equal(s.model->muscles[0].group, s.model->muscles[1].group);
        assert_true(s.model->muscles[2].group != s.model->muscles[0].group);
        assert_true(s.model->muscles[0].coupled && !s.model->muscles[2].coupled);
        assert_true(s.model->plan.muscles[0].groups[SN_ROWS_EXTERNAL].rows > 8);
        assert_int_equal(s.model->plan.muscles[2].groups[SN_ROWS_EXTERNAL].reason, SN_OUT_NO_TARGET);
        step_frames(&s, 12, NULL);
        for (sn_index k = 0; k < 3; k++) {
            const sn_model_muscle *m = &s.model->muscles[k];
            for (sn_index v = 0; v < m->point_count; v++)
                assert_true(sn_distance(m->rest[v], sn_point_position(&s.state->muscles[k].points[v])) < 1e-10);
        }
        assert_true(greatest_error(&s, 0) < 1e-9 && greatest_error(&s, 1) < 1e-9);
        finish(&s);
    }
}

/* The energy's slope along random ways of all points of both muscles. */
static void gradients_are_of_the_energy(void **state) {
    (void)state;
    const double *const types[] = {SLIDE, SOFT, HARD, MIXED};
    for (int type = 0; type < 4; type++) {
        sn_scene scene;
        make_pair(&scene, SN_SOLVER_QN, types[type]);
        simulation s = start(&scene);
        const sn_group *g = &s.model->groups[0];
        const sn_group_state *all = &s.state->groups[0];
        sn_index n = g->point_count;
        sn_point *at = SN_NEW(sn_point, n);
        sn_vec3 *gradient = SN_NEW(sn_vec3, n), *way = SN_NEW(sn_vec3, n), sum = {0, 0, 0};
        uint64_t random = 3;
        memcpy(at, all->points, (size_t)n * sizeof *at);
        for (sn_index i = 0; i < n; i++) {
            at[i].x += 4e-3 * (sn_random(&random) - 0.5), at[i].y += 4e-3 * (sn_random(&random) - 0.5),
                at[i].z += 4e-3 * (sn_random(&random) - 0.5);
            way[i] = sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, sn_random(&random) - 0.5);
        }
        for (sn_index k = 0; k < 2; k++) {
            double energies[2], slope = 0.0, step = 1e-8;
            memset(gradient, 0, (size_t)n * sizeof *gradient);
            sn_index first = g->first[k];
            const sn_model_muscle *m = g->members[k];
            sn_rows_external.energy(m, all->members[k], SN_ROWS_EXTERNAL, at + first, 100.0, (sn_forces){&gradient[first].x, 3});
            for (sn_index i = 0; i < n; i++) slope += sn_dot(gradient[i], way[i]), sum = sn_add(sum, gradient[i]);
            for (int side = 0; side < 2; side++) {
                for (sn_index i = 0; i < n; i++)
                    sn_put(&at[i], sn_add_scaled(sn_point_position(&at[i]), way[i], side == 0 ? -step : 2.0 * step));
                energies[side] = sn_rows_external.energy(m, all->members[k], SN_ROWS_EXTERNAL, at + first, 100.0, (sn_forces){NULL, 3});
            }
            for (sn_index i = 0; i < n; i++) sn_put(&at[i], sn_add_scaled(sn_point_position(&at[i]), way[i], -step));
            assert_true(fabs(slope) > 1e-6);
            assert_true(fabs((energies[1] - energies[0]) / (2.0 * step) - slope) < 1e-5 * (1.0 + fabs(slope)));
        }
        assert_true(sn_norm(sum) < 1e-12); /* what pulls one way pulls the other */
        free(at), free(gradient), free(way);
        finish(&s);
    }
}

/* [R18] to the letter: of one sweep over one row each vertex moves by eq. 14, less its compliance, and nothing else moves at all. */
static void one_way_moves_the_vertex_alone_by_the_mean_of_its_types(void **state) {
    (void)state;
    sn_scene scene;
    make_pair(&scene, SN_SOLVER_XPBD, MIXED);
    scene.solver.scheme = SN_SCHEME_ROMEO;
    scene.externals.no_minimum = true;
    simulation s = start(&scene);
    const sn_group *g = &s.model->groups[0];
    sn_group_state *all = &s.state->groups[0];
    assert_true(g->one_way && s.model->muscles[0].external_count > 8);
    for (sn_index i = 0; i < g->point_count; i++) /* off their places, each a little otherwise */
        sn_put(&all->points[i],
               sn_add(sn_point_position(&all->points[i]), sn_v3(1e-3 * sn_sin(i), 1e-3 * sn_cos(2.0 * i), 5e-4 * sn_sin(3.0 * i))));
    sn_point *before = SN_NEW(sn_point, g->point_count);
    memcpy(before, all->points, (size_t)g->point_count * sizeof *before);
    sn_externals_begin(g, all);
    sn_externals_update(g, all, 0);
    const sn_sweep how = {.compliance = 3e-4, .one_way = true};
    const sn_model_muscle *m = g->members[0];
    const sn_externals *rows = sn_externals_of(m);
    sn_rows_external.sweep(m, all->members[0], SN_ROWS_EXTERNAL, &how);
    const sn_external_hold *holds = sn_external_holds_of(all->members[0]);
    sn_index moved = 0;
    for (sn_index r = 0; r < m->external_count; r++) {
        const sn_external_row *row = &rows->rows[r];
        sn_vec3 places[2], p = sn_point_position(&before[row->point]);
        for (int k = 0; k < 2; k++) {
            const sn_external_foot *foot = k == 0 ? &holds[r].slide : &holds[r].bound;
            places[k] = foot->place;
            for (int c = 0; c < 3; c++) places[k] = sn_add_scaled(places[k], sn_point_position(&before[foot->point[c]]), foot->weight[c]);
        }
        sn_vec3 n = holds[r].normal, away = sn_sub(p, places[1]);
        sn_vec3 slide = sn_scale(n, row->distance - sn_dot(n, sn_sub(p, places[0])));
        sn_vec3 soft = sn_scale(sn_normalize(away), row->bound - sn_norm(away)), hard = sn_sub(sn_add(places[1], holds[r].offset), p);
        sn_vec3 mean = sn_add(sn_scale(slide, 0.5), sn_add(sn_scale(soft, 0.125), sn_scale(hard, 0.375)));
        double share = before[row->point].w / (before[row->point].w + how.compliance / rows->factor);
        sn_vec3 right = sn_add_scaled(p, mean, share), now = sn_point_position(&all->points[row->point]);
        assert_true(sn_distance(now, right) < 1e-15 && sn_distance(now, p) > 1e-6);
    }
    for (sn_index i = 0; i < g->point_count; i++) moved += memcmp(&before[i], &all->points[i], sizeof *before) != 0;
    assert_int_equal(moved, m->external_count);
    free(before);
    finish(&s);
}

/* Under the paper's scheme a target does not feel what slides on it: its frames are those of a run in which nothing is tied to it. */
static void one_way_leaves_the_target_alone(void **state) {
    (void)state;
    sn_scene scenes[2];
    simulation runs[2];
    for (int k = 0; k < 2; k++) {
        make_pair(&scenes[k], SN_SOLVER_XPBD, MIXED);
        scenes[k].solver.scheme = SN_SCHEME_ROMEO;
        scenes[k].externals.enabled = k == 1;
        bend(&scenes[k], 0.5);
        sn_externals_free(scenes[k].muscles[1].rig.externals, scenes[k].muscles[1].rig.external_count);
        scenes[k].muscles[1].rig.externals = NULL, scenes[k].muscles[1].rig.external_count = 0;
        runs[k] = start(&scenes[k]);
        step_frames(&runs[k], 8, NULL);
    }
    assert_true(runs[1].model->muscles[0].external_count > 8);
    assert_same_muscle(&runs[0], 1, &runs[1], 1);
    assert_true(sn_distance(sn_point_position(&runs[0].state->muscles[0].points[40]),
                            sn_point_position(&runs[1].state->muscles[0].points[40])) > 1e-5);
    for (int k = 0; k < 2; k++) finish(&runs[k]);
}

/* Free muscles, of which one is hit: what the one loses the other gains. */
static void momentum_of_a_free_pair_is_kept(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        fusiform small = FUSIFORM, other;
        small.rings = 9, small.sectors = 8, small.structure = false, small.pinned = 0.0;
        other = small;
        other.offset.x += 0.062;
        make_scene(&scene, &small);
        add_muscle(&scene, "neighbour", &other);
        scene.solver = sn_solver_defaults(METHODS[i]);
        for (int k = 0; k < 2; k++) {
            scene.muscles[k].stiffness_relaxed = scene.muscles[k].stiffness_active = 2000.0;
            scene.muscles[k].damping = 0.0;
        }
        tie_all(TIED_REACH, &scene, MIXED);
        simulation s = start(&scene);
        for (sn_index v = 0; v < s.model->muscles[0].point_count; v++) s.state->muscles[0].velocities[v] = sn_v3(-0.1, 0.02, 0.0);
        double mass = s.model->muscles[0].mass;
        step_frames(&s, 6, NULL);
        sn_vec3 sum = {0, 0, 0}, second = {0, 0, 0};
        for (sn_index k = 0; k < 2; k++)
            for (sn_index v = 0; v < s.model->muscles[k].point_count; v++) {
                sn_vec3 p = sn_scale(s.state->muscles[k].velocities[v], 1.0 / s.model->muscles[k].inverse_mass[v]);
                sum = sn_add(sum, p);
                if (k == 1) second = sn_add(second, p);
            }
        double most = METHODS[i] == SN_SOLVER_QN ? 1e-3 : 1e-10; /* qn stops at its tolerance */
        assert_true(sn_distance(sum, sn_scale(sn_v3(-0.1, 0.02, 0.0), mass)) < most * 0.1 * mass);
        assert_true(second.x < -0.01 * mass); /* it has been pulled along */
        finish(&s);
    }
}

/* ---- what slides, what is held ------------------------------------------------------------------------------------------------------- */

/* From the point that row r of the first muscle is bound to, to its vertex: now or at rest. */
static sn_vec3 away(const simulation *s, sn_index r, bool at_rest) {
    const sn_model_muscle *m = &s->model->muscles[0];
    const sn_externals *all = sn_externals_of(m);
    const sn_external_row *row = &all->rows[r];
    const sn_external_target *t = &s->model->groups[m->group].targets[all->candidates[row->begin]];
    const sn_muscle_state *other = s->state->groups[m->group].members[t->member];
    sn_vec3 u = at_rest ? m->rest[row->point] : sn_point_position(&s->state->muscles[0].points[row->point]);
    for (int k = 0; k < 3; k++) {
        sn_index v = t->moving.triangles[row->triangle].v[k];
        sn_vec3 p = at_rest ? s->model->groups[m->group].members[t->member]->rest[v] : sn_point_position(&other->points[v]);
        u = sn_add_scaled(u, p, -row->barycentric[k]);
    }
    return u;
}

/* How far the vertices have gone from their places beside the neighbour in the mean, m. */
static double mean_slip(const simulation *s) {
    double sum = 0.0;
    sn_index count = s->model->muscles[0].external_count;
    for (sn_index r = 0; r < count; r++) sum += sn_distance(away(s, r, false), away(s, r, true)) / count;
    return sum;
}

static double mean_error(const simulation *s) {
    double sum = 0.0;
    sn_index count = s->model->muscles[0].external_count;
    double *errors = SN_NEW(double, count);
    sn_row_errors(s->model, s->state, 0, SN_ROWS_EXTERNAL, errors);
    for (sn_index r = 0; r < count; r++) sum += errors[r] * s->model->muscles[0].mean_edge / count;
    free(errors);
    return sum;
}

/* The first one's lower end goes 3 cm along it, the neighbour stays: what slides keeps its distance and moves along, what is soft or hard
 * keeps its point. */
static void what_slides_keeps_its_distance_and_what_is_held_its_point(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        const double *const types[] = {SLIDE, SOFT, HARD};
        double slip[4], error[4];
        for (int k = 0; k < 4; k++) {
            sn_scene scene;
            make_pair(&scene, METHODS[i], types[k % 3]);
            for (int e = 0; e < 2; e++) {
                sn_attachment *end = &scene.muscles[1].rig.attachments[e];
                free(end->bone);
                end->bone = sn_strdup("upper");
            }
            scene.motion.joints[0].point = sn_v3(0.0, 0.2, 0.0);
            bend(&scene, -0.15);
            if (k == 3) scene.externals.stiffness = 1e-9; /* as good as not there */
            simulation s = start(&scene);
            step_frames(&s, 14, NULL);
            slip[k] = mean_slip(&s), error[k] = mean_error(&s);
            assert_false(s.state->muscles[0].statistics.torn || s.state->muscles[1].statistics.torn);
            finish(&s);
        }
        assert_true(slip[0] > 0.003 && slip[2] < 0.25 * slip[0]);
        for (int k = 0; k < 3; k++) assert_true(error[k] < 0.3 * error[3]);
    }
}

/* ---- order, threads, stopping, off ----------------------------------------------------------------------------------------------------
 */

static void the_order_of_muscles_does_not_matter(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_pair(&scenes[k], METHODS[i], MIXED);
            bend(&scenes[k], 0.6);
            if (k == 1) {
                sn_scene_muscle first = scenes[k].muscles[0];
                scenes[k].muscles[0] = scenes[k].muscles[1], scenes[k].muscles[1] = first;
            }
            runs[k] = start(&scenes[k]);
            step_frames(&runs[k], 8, NULL);
        }
        assert_same_muscle(&runs[0], 0, &runs[1], 1);
        assert_same_muscle(&runs[0], 1, &runs[1], 0);
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

static void a_step_goes_on_where_it_stopped(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_pair(&scenes[k], METHODS[i], MIXED);
            bend(&scenes[k], 0.8);
            scenes[k].solver.iterations = 3;
            runs[k] = start(&scenes[k]);
        }
        for (int frame = 0; frame < 8; frame++) {
            const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 1 + frame % 2};
            step_frames(&runs[0], 1, NULL);
            stop_and_reload(&runs[1], &stop);
            step_frames(&runs[1], 1, NULL);
            for (sn_index k = 0; k < 2; k++) assert_same_muscle(&runs[0], k, &runs[1], k);
        }
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

/* Switched off, with a stiffness of 0, of a muscle that has none of it, with all types off or all weights 0: each is as no candidates. */
static void off_is_absent(void **state) {
    (void)state;
    static const double none[3] = {0, 0, 0};
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[6];
        simulation runs[6];
        for (int k = 0; k < 6; k++) {
            make_pair(&scenes[k], METHODS[i], k == 5 ? none : MIXED);
            bend(&scenes[k], 0.6);
            sn_external_settings *e = &scenes[k].externals;
            if (k == 0)
                for (int j = 0; j < 2; j++) {
                    sn_externals_free(scenes[k].muscles[j].rig.externals, scenes[k].muscles[j].rig.external_count);
                    scenes[k].muscles[j].rig.externals = NULL, scenes[k].muscles[j].rig.external_count = 0;
                }
            if (k == 1) e->enabled = false;
            if (k == 2) e->stiffness = 0.0;
            if (k == 3) scenes[k].muscles[1].unbound = true;
            if (k == 4) e->no_slide = e->no_soft = e->no_hard = e->no_minimum = true;
            if (k == 5) e->no_minimum = true;
            runs[k] = start(&scenes[k]);
            assert_int_equal(runs[k].model->group_count, 2);
            step_frames(&runs[k], 6, NULL);
            for (sn_index m = 0; m < 2; m++) {
                assert_same_muscle(&runs[0], m, &runs[k], m);
                assert_int_equal(runs[k].model->muscles[m].external_count, 0);
                assert_int_equal(sn_group_state_bytes(runs[0].model, &runs[0].model->groups[m]),
                                 sn_group_state_bytes(runs[k].model, &runs[k].model->groups[m]));
            }
        }
        for (int k = 0; k < 6; k++) finish(&runs[k]);
    }
}

static void what_is_not_there_is_named(void **state) {
    (void)state;
    sn_scene scene;
    sn_model *model;
    sn_error error;
    make_pair(&scene, SN_SOLVER_QN, SLIDE);
    free(scene.muscles[0].rig.externals[0].target);
    scene.muscles[0].rig.externals[0].target = sn_strdup("nobody");
    assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "nobody"));
    sn_scene_free(&scene);
    make_pair(&scene, SN_SOLVER_QN, SLIDE);
    scene.muscles[0].rig.externals[0].distances[3] += 0.05; /* of another shape */
    assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "attach-detect"));
    sn_scene_free(&scene);
    make_pair(&scene, SN_SOLVER_QN, SLIDE); /* one that is left out is not missed */
    scene.muscles[1].enabled = false;
    simulation s = start(&scene);
    assert_int_equal(s.model->muscles[0].external_count, 0);
    step_frames(&s, 2, NULL);
    finish(&s);
}

/* ---- targets that move by themselves ---------------------------------------------------------------------------------------------------
 */

/* A spindle that no bone holds. */
static void make_free(sn_scene *scene, sn_solver_method method) {
    fusiform small = FUSIFORM;
    small.rings = 15, small.sectors = 10, small.structure = false, small.pinned = 0.0;
    make_scene(scene, &small);
    scene->solver = sn_solver_defaults(method);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 2000.0;
    scene->muscles[0].damping = 0.0;
}

/* A free spindle beside a plate of bone that goes as the keys say; its candidates are to the plate. */
static void make_beside(sn_scene *scene, sn_solver_method method, const double weights[3], sn_pose_key *keys) {
    make_free(scene, method);
    sn_mesh *plate = add_solid(scene, "plate", keys, 2);
    make_box(sn_v3(0.032, -0.4, -0.3), sn_v3(0.06, 0.4, 0.5), plate);
    const sn_neighbour target = {"plate", plate, false};
    tie(&scene->muscles[0], 1, &target, weights);
    assert_true(scene->muscles[0].rig.external_count == 1 && scene->muscles[0].rig.externals[0].count > 4);
    scene->externals.enabled = true;
}

static void sliding_along_a_plane_is_free(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_beside(&scene, METHODS[i], SLIDE, keys_to(0.0, 1.0, shifted(sn_v3(0, 0, 0))));
        scene.externals.no_minimum = true;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        for (sn_index v = 0; v < m->point_count; v++) s.state->muscles[0].velocities[v] = sn_v3(0.0, 0.05, 0.1);
        step_frames(&s, 12, NULL);
        for (sn_index v = 0; v < m->point_count; v++) {
            sn_vec3 right = sn_add(m->rest[v], sn_scale(sn_v3(0.0, 0.05, 0.1), 0.5));
            assert_true(sn_distance(sn_point_position(&s.state->muscles[0].points[v]), right) < 1e-9);
        }
        finish(&s);
    }
}

/* Beside a ball that spins about its middle: it is where it was, to its facets, and nobody is dragged along. */
static void what_slides_on_a_ball_does_not_feel_it_spin(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_free(&scene, METHODS[i]);
        const sn_vec3 middle = {0.082, 0.0, 0.1};
        sn_pose_key *keys = SN_NEW(sn_pose_key, 241); /* so many that it stays where it is between them, too */
        for (int k = 0; k <= 240; k++) {
            sn_quat turn = sn_quat_axis_angle(sn_normalize(sn_v3(1, 2, 3)), 2.0 * k / 240.0);
            keys[k] = (sn_pose_key){k / 240.0, {turn, sn_sub(middle, sn_quat_rotate(turn, middle))}};
        }
        capsule round = {{middle, middle}, 0.05};
        sn_mesh *ball = add_solid(&scene, "ball", keys, 241);
        make_capsule(&round, 24, ball);
        const sn_neighbour target = {"ball", ball, false};
        tie(&scene.muscles[0], 1, &target, SLIDE);
        scene.externals.enabled = true;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        const sn_externals *all = sn_externals_of(m);
        assert_true(m->external_count > 4);
        step_frames(&s, 24, NULL);
        for (sn_index r = 0; r < m->external_count; r++) {
            sn_vec3 at = sn_point_position(&s.state->muscles[0].points[all->rows[r].point]);
            assert_true(fabs(sn_distance(at, middle) - 0.05 - all->rows[r].distance) < 4e-4); /* facets are 0.05 mm off, at a slant more */
            assert_true(sn_distance(at, m->rest[all->rows[r].point]) < 1e-3);                 /* the ball's surface has come by 0.1 m */
        }
        finish(&s);
    }
}

/* Past the end of a plate the nearest point is its rim: a vertex that comes so far keeps its distance to that, and nothing jumps. */
static void past_the_border_of_a_target_the_rim_is_nearest(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_free(&scene, METHODS[i]);
        scene.last_frame = 48;
        sn_mesh *plate = add_solid(&scene, "plate", NULL, 0);
        make_box(sn_v3(0.032, -0.4, -0.3), sn_v3(0.06, 0.4, 0.13), plate);
        const sn_neighbour target = {"plate", plate, false};
        tie(&scene.muscles[0], 1, &target, SLIDE);
        scene.externals.enabled = true;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        for (sn_index v = 0; v < m->point_count; v++) s.state->muscles[0].velocities[v] = sn_v3(0.0, 0.0, 0.06);
        double fastest = 0.0, highest = 0.0;
        for (int frame = 0; frame < 36; frame++) {
            step_frames(&s, 1, NULL);
            for (sn_index v = 0; v < m->point_count; v++) fastest = fmax(fastest, sn_norm(s.state->muscles[0].velocities[v]));
        }
        for (sn_index r = 0; r < m->external_count; r++)
            highest = fmax(highest, s.state->muscles[0].points[sn_externals_of(m)->rows[r].point].z);
        assert_true(highest > 0.132 && fastest < 0.2); /* some are past the plate's end */
        assert_true(greatest_error(&s, 0) * m->mean_edge < 2e-3 && !s.state->muscles[0].statistics.torn);
        finish(&s);
    }
}

static sn_vec3 going_by(sn_vec3 p, double time) { return sn_v3(p.x, p.y, p.z - 0.6 * time); }

/* A driven sheet beside the muscle, 1.2 m long, in squares of 0.05 m, goes by under it: far from where it was at rest there is still sheet.
 */
static void a_driven_sheet_that_goes_by_has_no_end_where_it_was_near_at_rest(void **state) {
    (void)state;
    enum { ACROSS = 9, ALONG = 25 };
    sn_scene scene;
    make_free(&scene, SN_SOLVER_QN);
    scene.last_frame = 24;
    sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
    sn_mesh *sheet = &s->envelope.mesh;
    assert_int_equal(sn_mesh_alloc(sheet, ACROSS * ALONG, 2 * (ACROSS - 1) * (ALONG - 1), NULL), SN_OK);
    for (sn_index v = 0; v < ACROSS * ALONG; v++) sheet->positions[v] = sn_v3(0.032, 0.05 * (v % ACROSS) - 0.2, 0.05 * (v / ACROSS) - 0.3);
    for (sn_index i = 0, t = 0; t < sheet->triangle_count; i++) {
        if (i % ACROSS == ACROSS - 1) continue;
        sheet->triangles[t++] = (sn_triangle){{i, i + ACROSS, i + 1}};
        sheet->triangles[t++] = (sn_triangle){{i + 1, i + ACROSS, i + ACROSS + 1}};
    }
    drive(s, 25, 1.0, going_by);
    const sn_neighbour target = {s->name, sheet, false};
    tie(&scene.muscles[0], 1, &target, SLIDE);
    scene.externals.enabled = true;
    simulation sim = start(&scene);
    const sn_model_muscle *m = &sim.model->muscles[0];
    assert_true(m->external_count > 4);
    step_frames(&sim, 24, NULL);
    for (sn_index v = 0; v < m->point_count; v++)
        assert_true(sn_distance(sn_point_position(&sim.state->muscles[0].points[v]), m->rest[v]) < 1e-6);
    finish(&sim);
}

/* Two plates that go on from each other at z = 0.1, a muscle beside both. */
static void make_beside_two(sn_scene *scene) {
    fusiform small = FUSIFORM;
    small.rings = 15, small.sectors = 10, small.structure = false, small.pinned = 0.0;
    make_scene(scene, &small);
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    sn_mesh *low = add_solid(scene, "low", NULL, 0);
    make_box(sn_v3(0.032, -0.4, -0.3), sn_v3(0.06, 0.4, 0.1), low);
    sn_mesh *high = add_solid(scene, "high", NULL, 0);
    low = &scene->bones[scene->bone_count - 2].mesh; /* it may have moved */
    make_box(sn_v3(0.032, -0.4, 0.1), sn_v3(0.06, 0.4, 0.5), high);
    const sn_neighbour targets[2] = {{"low", low, false}, {"high", high, false}};
    tie(&scene->muscles[0], 2, targets, SLIDE);
    scene->externals.enabled = true;
}

/* The row of a vertex that is bound to the first target and has the other, too. */
static sn_index row_of_two(const simulation *s) {
    const sn_externals *all = sn_externals_of(&s->model->muscles[0]);
    for (sn_index r = 0; r < s->model->muscles[0].external_count; r++)
        if (all->rows[r].end - all->rows[r].begin == 2) return r;
    fail_msg("no vertex has two targets");
    return 0;
}

/* Over the border of a target a vertex slides onto the next, and only there: not to and fro where both are as near. */
static void targets_switch_where_one_is_much_nearer(void **state) {
    (void)state;
    sn_scene scene;
    make_beside_two(&scene);
    simulation s = start(&scene);
    sn_index r = row_of_two(&s), v = sn_externals_of(&s.model->muscles[0])->rows[r].point;
    static const double over[] = {-0.006, -0.001, 0.001, 0.006, 0.001, -0.001, -0.006};
    static const int is_high[] = {0, 0, 0, 1, 1, 1, 0};
    for (int i = 0; i < 7; i++) {
        s.state->groups[0].previous[v] = sn_v3(0.03, 0.0, 0.1 + over[i]);
        sn_externals_find(&s.model->groups[0], &s.state->groups[0]);
        const sn_index *slides_on = &s.state->muscles[0].inputs->slides_on[r];
        const sn_external_target *on = &s.model->groups[0].targets[*slides_on];
        assert_int_equal(on->touched == scene.bone_count - 1, is_high[i]);
        sn_externals_find(&s.model->groups[0], &s.state->groups[0]); /* asked again, as where a run goes on, it says the same */
        assert_ptr_equal(&s.model->groups[0].targets[*slides_on], on);
    }
    finish(&s);
}

/* What a vertex was outside of at rest, and is within now, comes before a target that it slides on and that is nearer. */
static void what_was_entered_comes_before_what_is_near(void **state) {
    (void)state;
    sn_scene scene;
    make_beside_two(&scene);
    simulation s = start(&scene);
    sn_index r = row_of_two(&s), v = sn_externals_of(&s.model->muscles[0])->rows[r].point;
    static const double at[][2] = {
        {0.03, 0.094}, {0.036, 0.1039}, {0.030, 0.094}}; /* beside the low one; 4 mm in the high one, 3.9 mm off the low one */
    static const int is_high[] = {0, 1, 0};
    for (int i = 0; i < 3; i++) {
        s.state->groups[0].previous[v] = sn_v3(at[i][0], 0.0, at[i][1]);
        sn_externals_find(&s.model->groups[0], &s.state->groups[0]);
        const sn_external_target *on = &s.model->groups[0].targets[s.state->muscles[0].inputs->slides_on[r]];
        assert_int_equal(on->touched == scene.bone_count - 1, is_high[i]);
    }
    sn_put(&s.state->muscles[0].points[v], sn_v3(0.036, 0.0, 0.1039));
    sn_externals_measure(&s.model->groups[0], &s.state->groups[0]);
    assert_float_equal(s.state->muscles[0].statistics.entered, 0.0039, 1e-9); /* out by its end, which is the nearest */
    assert_int_equal(s.state->muscles[0].statistics.entered_vertex, v);
    finish(&s);
}

/* The plate turns and moves: what hangs on it by hard constraints alone goes along, to what its inertia allows. */
static void what_is_hard_goes_along_with_a_bone(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        sn_rigid by = {sn_quat_axis_angle(sn_v3(0, 0, 1), 0.5), {0.05, 0.02, 0.1}};
        make_beside(&scene, METHODS[i], HARD, keys_to(0.0, 0.5, by));
        scene.muscles[0].damping = 5.0;
        scene.last_frame = 48;
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        step_frames(&s, 48, NULL);
        double most = 0.0;
        for (sn_index v = 0; v < m->point_count; v++)
            most = fmax(most, sn_distance(sn_point_position(&s.state->muscles[0].points[v]), sn_rigid_apply(by, m->rest[v])));
        assert_true(most < 0.02);
        assert_true(greatest_error(&s, 0) * m->mean_edge < 1e-3);
        finish(&s);
    }
}

/* Under a rigid motion of all there is no row has an error. */
static void rigid_motion_costs_nothing(void **state) {
    (void)state;
    sn_scene scene;
    sn_rigid by = {sn_quat_axis_angle(sn_normalize(sn_v3(1, 2, 3)), 1.3), {0.3, -0.2, 0.1}};
    make_pair(&scene, SN_SOLVER_QN, MIXED);
    simulation s = start(&scene);
    sn_group_state *g = &s.state->groups[0];
    for (sn_index v = 0; v < s.model->groups[0].point_count; v++) {
        g->previous[v] = sn_rigid_apply(by, sn_point_position(&g->points[v]));
        sn_put(&g->points[v], g->previous[v]);
    }
    sn_externals_find(&s.model->groups[0], g);
    for (sn_index k = 0; k < 2; k++) assert_true(greatest_error(&s, k) * s.model->muscles[k].mean_edge < 1e-10);
    finish(&s);
}

/* Two spindles whose vertices are about 3 mm apart, of which one is pushed 5 mm towards the other. */
static void what_enters_a_neighbour_is_measured_and_named(void **state) {
    (void)state;
    sn_scene scene;
    make_pair(&scene, SN_SOLVER_QN, SLIDE);
    simulation s = start(&scene);
    const sn_group *g = &s.model->groups[0];
    sn_group_state *points = &s.state->groups[0];
    sn_index pushed = g->muscles[0] == 0 ? 0 : 1; /* which member the fusiform is */
    for (sn_index v = 0; v < g->point_count; v++) points->previous[v] = sn_point_position(&points->points[v]);
    sn_externals_find(g, points);
    sn_externals_measure(g, points);
    for (int k = 0; k < 2; k++) {
        const sn_statistics *at_rest = &s.state->muscles[k].statistics;
        assert_true(at_rest->entered == 0.0 && at_rest->entered_vertex == SN_NONE);
    }
    for (sn_index v = g->first[pushed]; v < g->first[pushed + 1]; v++)
        sn_put(&points->points[v], sn_add(points->previous[v], sn_v3(0.005, 0, 0)));
    sn_externals_measure(g, points);
    for (int k = 0; k < 2; k++) {
        const sn_statistics *now = &s.state->muscles[k].statistics;
        assert_float_equal(now->entered, 0.002, 3e-4);
        assert_string_equal(sn_model_target_name(s.model, k, now->entered_target), s.model->muscles[1 - k].source->name);
    }
    finish(&s);
}

/* The deepest of two muscles in each other, against what they slide on where they are now, m. */
static double deepest_inside(simulation *s) {
    const sn_group *g = &s->model->groups[0];
    sn_group_state *points = &s->state->groups[0];
    double deepest = 0.0;
    for (sn_index v = 0; v < g->point_count; v++) points->previous[v] = sn_point_position(&points->points[v]);
    sn_externals_find(g, points);
    for (sn_index k = 0; k < 2; k++) {
        const sn_model_muscle *m = &s->model->muscles[k];
        const sn_external_hold *holds = sn_external_holds_of(&s->state->muscles[k]);
        for (sn_index r = 0; r < m->external_count; r++) {
            sn_vec3 u = sn_point_position(&s->state->muscles[k].points[sn_externals_of(m)->rows[r].point]);
            for (int c = 0; c < 3; c++)
                u = sn_add_scaled(u, sn_point_position(&s->state->muscles[k].points[holds[r].slide.point[c]]), -holds[r].slide.weight[c]);
            deepest = fmax(deepest, -sn_dot(holds[r].normal, u));
        }
    }
    return deepest;
}

/* Two spindles that are 4 mm deep in each other stay so, or come apart in the time that is asked for, and no sooner. */
static void what_overlaps_at_rest_stays_or_comes_apart_in_time(void **state) {
    (void)state;
    for (int i = 0; i < 4; i++) {
        sn_scene scene;
        fusiform small = FUSIFORM, other;
        small.rings = 15, small.sectors = 10, small.structure = false;
        other = small;
        other.offset.x += 0.056;
        make_scene(&scene, &small);
        add_muscle(&scene, "neighbour", &other);
        scene.solver = sn_solver_defaults(METHODS[i % 2]);
        scene.last_frame = 60;
        for (int k = 0; k < 2; k++) scene.muscles[k].stiffness_relaxed = scene.muscles[k].stiffness_active = 500.0;
        tie_all(TIED_REACH, &scene, SLIDE);
        if (i >= 2) scene.externals.resolve = 1.0;
        simulation s = start(&scene);
        assert_true(s.model->plan.muscles[0].ties_inside > 0);
        double at_rest = deepest_inside(&s);
        assert_true(at_rest > 0.001 &&
                    fabs(at_rest - fmax(s.model->plan.muscles[0].deepest_tie, s.model->plan.muscles[1].deepest_tie)) < 1e-9);
        step_frames(&s, 12, NULL);
        double half = deepest_inside(&s);
        step_frames(&s, 36, NULL);
        double end = deepest_inside(&s);
        if (i < 2) assert_true(fabs(half - at_rest) < 0.05 * at_rest && fabs(end - at_rest) < 0.05 * at_rest);
        if (i >= 2)
            assert_true(half > 0.3 * at_rest && half < 0.8 * at_rest &&
                        end < 0.25 * at_rest); /* as far as rows of ten times their stiffness press them */
        for (int k = 0; k < 2; k++) assert_false(s.state->muscles[k].statistics.torn);
        finish(&s);
    }
}

/* What a step held on to where it began says nothing of where it ends: half a turn of all there is enters nothing, and what is pushed after
 * it has entered as without it. */
static void what_has_entered_is_measured_where_it_is_now(void **state) {
    (void)state;
    sn_scene scene;
    sn_rigid by = {sn_quat_axis_angle(sn_v3(0, 0, 1), 3.141592653589793), {0, 0, 0}};
    make_pair(&scene, SN_SOLVER_QN, SLIDE);
    simulation s = start(&scene);
    const sn_group *g = &s.model->groups[0];
    sn_group_state *points = &s.state->groups[0];
    sn_index pushed = g->muscles[0] == 0 ? 0 : 1;
    for (sn_index v = 0; v < g->point_count; v++) {
        points->previous[v] = sn_point_position(&points->points[v]);
        sn_put(&points->points[v], sn_rigid_apply(by, points->previous[v]));
    }
    sn_externals_measure(g, points);
    for (int k = 0; k < 2; k++) assert_true(s.state->muscles[k].statistics.entered == 0.0);
    for (sn_index v = g->first[pushed]; v < g->first[pushed + 1]; v++)
        sn_put(&points->points[v], sn_add(sn_point_position(&points->points[v]), sn_v3(-0.005, 0, 0)));
    sn_externals_measure(g, points);
    for (int k = 0; k < 2; k++) assert_float_equal(s.state->muscles[k].statistics.entered, 0.002, 3e-4);
    finish(&s);
}

static void a_group_sleeps_and_wakes_as_one(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_pair(&scene, METHODS[i], MIXED);
        scene.last_frame = 40;
        set_keys(&scene.motion.joints[0].angle, 1.0, 0.0, 1.3, 0.5);
        simulation s = start(&scene);
        step_frames(&s, 24, NULL);
        for (int k = 0; k < 2; k++) assert_true(s.state->muscles[k].statistics.asleep);
        step_frames(&s, 4, NULL);
        for (int k = 0; k < 2; k++) assert_false(s.state->muscles[k].statistics.asleep);
        finish(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_those_of_the_paper),
        cmocka_unit_test(muscles_that_touch_are_one_group_and_rest_is_rest),
        cmocka_unit_test(gradients_are_of_the_energy),
        cmocka_unit_test(one_way_moves_the_vertex_alone_by_the_mean_of_its_types),
        cmocka_unit_test(one_way_leaves_the_target_alone),
        cmocka_unit_test(momentum_of_a_free_pair_is_kept),
        cmocka_unit_test(what_slides_keeps_its_distance_and_what_is_held_its_point),
        cmocka_unit_test(the_order_of_muscles_does_not_matter),
        cmocka_unit_test(a_step_goes_on_where_it_stopped),
        cmocka_unit_test(off_is_absent),
        cmocka_unit_test(what_is_not_there_is_named),
        cmocka_unit_test(sliding_along_a_plane_is_free),
        cmocka_unit_test(what_slides_on_a_ball_does_not_feel_it_spin),
        cmocka_unit_test(past_the_border_of_a_target_the_rim_is_nearest),
        cmocka_unit_test(a_driven_sheet_that_goes_by_has_no_end_where_it_was_near_at_rest),
        cmocka_unit_test(targets_switch_where_one_is_much_nearer),
        cmocka_unit_test(what_was_entered_comes_before_what_is_near),
        cmocka_unit_test(what_is_hard_goes_along_with_a_bone),
        cmocka_unit_test(rigid_motion_costs_nothing),
        cmocka_unit_test(what_enters_a_neighbour_is_measured_and_named),
        cmocka_unit_test(what_overlaps_at_rest_stays_or_comes_apart_in_time),
        cmocka_unit_test(what_has_entered_is_measured_where_it_is_now),
        cmocka_unit_test(a_group_sleeps_and_wakes_as_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
