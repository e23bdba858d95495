/* test_sim_tendons.c -- a map that tells tendon from muscle: what is tendon does not contract, what has no map is as before. */
#include "sim_inside.h"

/* Tendon above the middle (z = 0.1 m), held by the upper bone alone; fully active. */
static void make_half(sn_scene *scene, sn_solver_method method, sn_stretch stretch) {
    make_scene(scene, &FUSIFORM);
    scene->solver = sn_solver_defaults(method);
    sn_scene_muscle *m = &scene->muscles[0];
    m->rig.attachments[1].count = 0; /* nothing holds the lower end */
    m->stretch = stretch;
    m->activation.constant = 1.0;
    sn_attribute *map = sn_mesh_add_attribute(&m->rig.mesh, "cord", 1);
    assert_non_null(map);
    for (sn_index v = 0; v < m->rig.mesh.vertex_count; v++) map->values[v] = m->rig.mesh.positions[v].z > 0.1 ? 1.0 : 0.0;
}

static void name_map(sn_scene *scene, const char *name) { scene->muscles[0].tendon_map = sn_strdup(name); }

static bool row_within(const sn_model_muscle *m, sn_index row, double low, double high) {
    const sn_index *p = m->distances[row].point;
    for (int i = 0; i < 2; i++)
        if (!(m->rest[p[i]].z > low && m->rest[p[i]].z < high)) return false;
    return true;
}

/* Edges on the surface, inside, and between the two. */
static void goals_in_tendon_are_rest_lengths(void **state) {
    (void)state;
    sn_scene scene;
    make_half(&scene, SN_SOLVER_XPBD, SN_STRETCH_SPRINGS);
    name_map(&scene, "cord");
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++) {
        sn_index tendon = 0, belly = 0;
        for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
            const sn_index *p = m->distances[r].point;
            double rest = sn_distance(m->rest[p[0]], m->rest[p[1]]), goal = inputs_of(&s)->goals[r];
            if (row_within(m, r, 0.13, 1.0)) {
                assert_true(fabs(goal / rest - 1.0) < 1e-12);
                tendon++;
            }
            if (row_within(m, r, -1.0, 0.07)) {
                assert_true(goal == sn_goal_length(SN_LAW_PROJECTED, m->distance_terms[r], 0.5, 0.0, 1.0));
                belly += goal < 0.9 * rest;
            }
        }
        assert_true(tendon > 1 && belly > 1);
    }
    finish(&s);
}

/* A belly that runs out into a cord 12 mm thick from z = 0.14 m on: in a thick one the pressure of the belly would stretch it. */
static void thin_out(sn_scene *scene) {
    sn_muscle *rig = &scene->muscles[0].rig;
    for (sn_index v = 0; v < rig->mesh.vertex_count; v++) {
        sn_vec3 *p = &rig->mesh.positions[v];
        double around = sn_length2(p->x, p->y), t = fmin(fmax((p->z - 0.1) / 0.04, 0.0), 1.0), r = 0.03 - 0.024 * t * t * (3.0 - 2.0 * t);
        rig->mesh.attributes[0].values[v] = p->z >= 0.14 ? 1.0 : 0.0;
        if (p->z < 0.1 || around == 0.0) continue;
        *p = sn_v3(p->x * r / around, p->y * r / around, p->z);
        if (p->z >= 0.14) rig->fibers.directions[v] = sn_v3(0, 0, 1);
    }
}

/* Mean length, over rest, of surface edges that run along the muscle. */
static double mean_stretch(const simulation *s, const sn_topology *topology, double low, double high) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double sum = 0.0;
    sn_index count = 0;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        const sn_index *v = topology->edges[e].v;
        sn_vec3 a = m->rest[v[0]], b = m->rest[v[1]];
        if (fmin(a.z, b.z) < low || fmax(a.z, b.z) > high || fabs(a.z - b.z) < 0.5 * sn_distance(a, b)) continue;
        sum += sn_distance(position(s, v[0]), position(s, v[1])) / sn_distance(a, b);
        count++;
    }
    assert_true(count > 50);
    return sum / count;
}

/* Without the map both shorten. What xpbd leaves of the tendon's stretch after its iterations is much. */
static void a_tendon_keeps_its_length_while_the_belly_contracts(void **state) {
    (void)state;
    const struct {
        sn_solver_method method;
        sn_stretch stretch;
    } runs[] = {{SN_SOLVER_QN, SN_STRETCH_SPRINGS}, {SN_SOLVER_QN, SN_STRETCH_MEMBRANE}, {SN_SOLVER_XPBD, SN_STRETCH_SPRINGS}};
    for (int i = 0; i < 3; i++)
        for (int mapped = 0; mapped < 2; mapped++) {
            sn_scene scene;
            sn_topology topology = {0};
            make_half(&scene, runs[i].method, runs[i].stretch);
            thin_out(&scene);
            if (mapped) name_map(&scene, "cord");
            assert_int_equal(sn_topology_build(&scene.muscles[0].rig.mesh, &topology, NULL), SN_OK);
            simulation s = start(&scene);
            step_frames(&s, 48, NULL);
            double tendon = mean_stretch(&s, &topology, 0.14, 0.19), belly = mean_stretch(&s, &topology, 0.02, 0.1);
            if (mapped) assert_true(tendon > 0.98 && tendon < (runs[i].method == SN_SOLVER_QN ? 1.025 : 1.25));
            if (!mapped) assert_true(tendon < 0.8);
            assert_true(belly < 0.93);
            sn_topology_free(&topology);
            finish(&s);
        }
}

/* An attribute that the scene does not name, and a map that is muscle everywhere, leave every bit as it was. */
static void without_tendon_nothing_changes(void **state) {
    (void)state;
    for (int method = 0; method < 2; method++) {
        sn_scene scenes[3];
        simulation runs[3];
        for (int i = 0; i < 3; i++) {
            make_half(&scenes[i], method ? SN_SOLVER_QN : SN_SOLVER_XPBD, SN_STRETCH_SPRINGS);
            sn_mesh *mesh = &scenes[i].muscles[0].rig.mesh;
            if (i == 0) sn_mesh_remove_attribute(mesh, "cord");
            for (sn_index v = 0; i == 2 && v < mesh->vertex_count; v++) mesh->attributes[0].values[v] = 0.0;
            if (i == 2) name_map(&scenes[i], "cord");
            runs[i] = start(&scenes[i]);
            if (i < 2) assert_null(runs[i].model->muscles[0].distance_share);
            step_frames(&runs[i], 8, NULL);
        }
        for (int i = 1; i < 3; i++) assert_same_muscle(&runs[0], 0, &runs[i], 0);
        for (int i = 0; i < 3; i++) finish(&runs[i]);
    }
}

static void a_map_that_is_none_is_refused(void **state) {
    (void)state;
    const double wrong[] = {-0.1, 1.1, 255.0, NAN, INFINITY};
    for (int i = 0; i < 6; i++) {
        sn_scene scene;
        sn_model *model = NULL;
        sn_error error = {0};
        make_half(&scene, SN_SOLVER_QN, SN_STRETCH_SPRINGS);
        name_map(&scene, i < 5 ? "cord" : "chord");
        if (i < 5) scene.muscles[0].rig.mesh.attributes[0].values[3] = wrong[i];
        assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
        assert_non_null(strstr(error.text, i < 5 ? "vertex 3" : "chord"));
        sn_scene_free(&scene);
    }
}

/* Both maps at once: their shares are multiplied. */
static void tendon_takes_from_the_share_of_activation(void **state) {
    (void)state;
    sn_scene scene;
    make_half(&scene, SN_SOLVER_XPBD, SN_STRETCH_SPRINGS);
    sn_mesh *mesh = &scene.muscles[0].rig.mesh;
    sn_attribute *share = sn_mesh_add_attribute(mesh, "share", 1);
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        share->values[v] = 0.5;
        mesh->attributes[0].values[v] = 0.25;
    }
    scene.muscles[0].activation_map = sn_strdup("share");
    name_map(&scene, "cord");
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    for (sn_index r = m->distance_start[SN_ROWS_MESH]; r < m->distance_start[SN_DISTANCE_KINDS]; r++)
        assert_true(m->distance_share[r] == 0.5 * 0.75);
    finish(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(goals_in_tendon_are_rest_lengths),
        cmocka_unit_test(a_tendon_keeps_its_length_while_the_belly_contracts),
        cmocka_unit_test(without_tendon_nothing_changes),
        cmocka_unit_test(a_map_that_is_none_is_refused),
        cmocka_unit_test(tendon_takes_from_the_share_of_activation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
