/* test_contact_surface.c -- contact with surfaces that change their shape (contact_patch.c, contact_surface.c): held against the same
 * surface as a bone; what swells, flaps, jumps; friction, sleep, stopping, and contact off. */
#include "contact_scene.h"

#include "../../lib/sim/contact.h"
#include "sim_inside.h"

static const sn_solver_method METHODS[2] = {SN_SOLVER_XPBD, SN_SOLVER_QN};
static const double ROD = 0.02, AWAY = 0.002, DEPTH = 0.01, SECONDS = 0.3;

typedef enum kind { AS_BONE, AS_ENVELOPE, AS_DRIVEN } kind;

static void make_soft(sn_scene *scene, sn_solver_method method) {
    fusiform small = FUSIFORM;
    small.rings = 15, small.sectors = 10, small.structure = false;
    make_scene(scene, &small);
    turn_contact_on(scene);
    scene->solver = sn_solver_defaults(method);
    scene->muscles[0].stiffness_relaxed = scene->muscles[0].stiffness_active = 500.0;
}

/* All of it goes with one joint. */
static void bind_to_joint(sn_scene_surface *s, sn_index joint) {
    sn_envelope *e = &s->envelope;
    e->bone_count = 1;
    e->bones = SN_NEW(char *, 1);
    e->bones[0] = sn_strdup("carrier");
    e->influences = SN_NEW(sn_influence, e->mesh.vertex_count);
    for (sn_index v = 0; v < e->mesh.vertex_count; v++) e->influences[v] = (sn_influence){.count = 1, .bones = {0}, .weights = {1.0}};
    s->joints = SN_NEW(sn_index, 1);
    s->joints[0] = joint;
}

static sn_vec3 pressing(sn_vec3 p, double time) { return sn_v3(p.x - (DEPTH + AWAY) * fmin(time / SECONDS, 1.0), p.y, p.z); }

/* A rod across the fusiform's middle, which comes to be DEPTH deep in where its surface was. */
static void make_pressed(sn_scene *scene, sn_solver_method method, kind what) {
    capsule rod = {{{0.03 + ROD + AWAY, -0.08, 0.1}, {0.03 + ROD + AWAY, 0.08, 0.1}}, ROD};
    make_soft(scene, method);
    sn_pose_key *keys = keys_to(0.0, SECONDS, shifted(sn_v3(-(DEPTH + AWAY), 0, 0)));
    make_capsule(&rod, 8, add_solid(scene, "rod", keys, 2));
    if (what == AS_BONE) return;
    scene->bones[2].passable = true;
    sn_scene_surface *s = add_surface(scene, what == AS_ENVELOPE ? SN_SURFACE_ENVELOPE : SN_SURFACE_DRIVEN);
    make_capsule(&rod, 8, &s->envelope.mesh);
    if (what == AS_ENVELOPE)
        bind_to_joint(s, scene->bones[2].joint);
    else
        drive(s, 10, SECONDS, pressing);
}

/* The deepest free vertex in the rod, against the whole of its surface, m; negative: all are outside. */
static double deepest_in(const simulation *s, const sn_mesh *mesh) {
    const sn_model_muscle *m = &s->model->muscles[0];
    sn_surface *surface;
    double deepest = -INFINITY;
    assert_int_equal(sn_surface_create(mesh, &surface, NULL), SN_OK);
    for (sn_index v = 0; v < m->vertex_count; v++)
        if (m->inverse_mass[v] > 0.0)
            deepest = fmax(deepest, -sn_surface_signed_distance(surface, sn_point_position(&s->state->muscles[0].points[v]), NULL));
    sn_surface_destroy(surface);
    return deepest;
}

/* The surface at a time, in place of its rest shape. */
static sn_mesh shape_at(const sn_scene *scene, double time) {
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_copy(&scene->surfaces[0].envelope.mesh, &mesh, NULL), SN_OK);
    sn_rigid *poses = SN_NEW(sn_rigid, scene->motion.joint_count);
    sn_motion_run_in_poses(&scene->motion, time, 1.0, poses);
    const sn_surface_moment at = {poses, time, 1.0};
    sn_scene_surface_positions(&scene->surfaces[0], &at, NULL, mesh.positions);
    free(poses);
    return mesh;
}

static double deepest_at(const simulation *s, const sn_scene *scene, double time) {
    sn_mesh mesh = shape_at(scene, time);
    double deepest = deepest_in(s, &mesh);
    sn_mesh_free(&mesh);
    return deepest;
}

/* ---- against bones ------------------------------------------------------------------------------------------------------------- */

/* The field of a bone is interpolated, an envelope is exact: little lies between the two where muscles have given way by 10 mm. */
static void a_rigid_surface_is_as_a_bone(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[3];
        simulation runs[3];
        for (int k = 0; k < 3; k++) {
            make_pressed(&scenes[k], METHODS[i], (kind)k);
            scenes[k].contact.cell = 5e-4;
            runs[k] = start(&scenes[k]);
            step_frames(&runs[k], 14, NULL);
        }
        const sn_model_muscle *m = &runs[0].model->muscles[0];
        double far = 0.0, same = 0.0;
        for (sn_index v = 0; v < m->vertex_count; v++) {
            sn_vec3 p[3];
            for (int k = 0; k < 3; k++) p[k] = sn_point_position(&runs[k].state->muscles[0].points[v]);
            far = fmax(far, sn_distance(p[0], p[1]));
            same = fmax(same, sn_distance(p[1], p[2]));
        }
        assert_true(far < (i == 0 ? 1e-4 : 5e-4));  /* qn ends each step by its tolerance, wherever it is on a floppy way by then */
        assert_true(same < (i == 0 ? 1e-6 : 5e-4)); /* a host's frames are floats */
        assert_true(greatest_move(&runs[1]) > 0.005);
        assert_true(abs(runs[0].state->muscles[0].statistics.contacts - runs[1].state->muscles[0].statistics.contacts) <= 6);
        for (int k = 1; k < 3; k++) {
            assert_true(deepest_at(&runs[k], &scenes[k], 14.0 / 24.0) < 1e-9);
            assert_int_equal(runs[k].model->plan.muscles[0].bone_count, 1);
            assert_string_equal(sn_scene_touched_name(&scenes[k], runs[k].model->plan.muscles[0].bones[0]), "skin");
        }
        for (int k = 0; k < 3; k++) finish(&runs[k]);
    }
}

/* Slopes of the energy, along random ways of all points, as the gradient says. */
static void gradients_are_of_the_energy(void **state) {
    (void)state;
    sn_scene scene;
    make_pressed(&scene, SN_SOLVER_QN, AS_DRIVEN);
    scene.contact.samples = 1;
    simulation s = start(&scene);
    step_frames(&s, 5, NULL);
    const sn_model_muscle *m = &s.model->muscles[0];
    const sn_muscle_state *muscle = &s.state->muscles[0];
    assert_true(muscle->inputs->near_count > 20);
    sn_point *at = SN_NEW(sn_point, m->point_count);
    sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count), *way = SN_NEW(sn_vec3, m->point_count);
    uint64_t random = 5;
    for (int trial = 0; trial < 10; trial++) {
        double energies[2], slope = 0.0, step = 1e-8, k = 5e3;
        memset(gradient, 0, (size_t)m->point_count * sizeof *gradient);
        memcpy(at, muscle->points, (size_t)m->point_count * sizeof *at);
        for (sn_index i = 0; i < m->point_count; i++) {
            at[i].x += 2e-3 * sn_random(&random);
            way[i] = sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, sn_random(&random) - 0.5);
        }
        assert_true(sn_rows_contact.energy(m, muscle, SN_ROWS_CONTACT, at, k, (sn_forces){&gradient->x, 3}) > 0.0);
        for (sn_index i = 0; i < m->point_count; i++) slope += sn_dot(gradient[i], way[i]);
        for (int side = 0; side < 2; side++) {
            for (sn_index i = 0; i < m->point_count; i++)
                sn_put(&at[i], sn_add_scaled(sn_point_position(&at[i]), way[i], side == 0 ? -step : 2.0 * step));
            energies[side] = sn_rows_contact.energy(m, muscle, SN_ROWS_CONTACT, at, k, (sn_forces){NULL, 3});
        }
        assert_true(fabs((energies[1] - energies[0]) / (2.0 * step) - slope) < 1e-5 * (1.0 + fabs(slope)));
    }
    free(at);
    free(gradient);
    free(way);
    finish(&s);
}

/* ---- surfaces that change ------------------------------------------------------------------------------------------------------- */

static const sn_vec3 HEART = {0.05, 0.0, 0.1};
/* A ball that swells by half in half a second. */
static sn_vec3 swelling(sn_vec3 p, double time) { return sn_add_scaled(HEART, sn_sub(p, HEART), 1.0 + 0.5 * fmin(2.0 * time, 1.0)); }
/* A plate that is through the muscle within one frame. */
static sn_vec3 jumping(sn_vec3 p, double time) { return sn_v3(p.x - 0.1 * fmin(fmax(24.0 * time - 3.0, 0.0), 1.0), p.y, p.z); }
static sn_vec3 collapsing(sn_vec3 p, double time) { return time > 0.2 ? HEART : p; }

static void make_ball(sn_scene *scene, sn_solver_method method, double radius, path_of *move) {
    capsule ball = {{HEART, HEART}, radius};
    make_soft(scene, method);
    sn_scene_surface *s = add_surface(scene, SN_SURFACE_DRIVEN);
    make_capsule(&ball, 8, &s->envelope.mesh);
    drive(s, 25, 1.0, move);
}

static void what_swells_pushes_and_is_not_entered(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_ball(&scene, METHODS[i], 0.018, swelling);
        simulation s = start(&scene);
        for (int frame = 1; frame <= 20; frame++) {
            step_frames(&s, 1, NULL);
            assert_true(deepest_at(&s, &scene, frame / 24.0) < 1e-9);
            assert_false(s.state->muscles[0].statistics.torn);
        }
        assert_true(s.state->muscles[0].statistics.contacts > 0);
        assert_true(s.state->muscles[0].statistics.penetration == 0.0);
        assert_true(greatest_move(&s) > 0.004);
        finish(&s);
    }
}

/* What a host deforms so that nothing is left of it moves nothing, and gives no number that is not one. */
static void what_collapses_is_survived(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_ball(&scene, METHODS[i], 0.03, collapsing);
        simulation s = start(&scene);
        step_frames(&s, 20, NULL);
        assert_int_equal(s.state->muscles[0].statistics.nan_points, 0);
        assert_true(greatest_move(&s) < 0.005);
        finish(&s);
    }
}

/* The muscle lies over the plate's way; the plate is 4 mm thick and goes 100 mm within one frame. */
static void what_jumps_carries_the_muscle_along(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scene;
        make_soft(&scene, METHODS[i]);
        sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
        make_box(sn_v3(0.036, -0.05, 0.06), sn_v3(0.04, 0.05, 0.14), &s->envelope.mesh);
        drive(s, 25, 1.0, jumping);
        simulation run = start(&scene);
        step_frames(&run, 3, NULL);
        assert_true(greatest_move(&run) < 1e-3);
        step_frames(&run, 1, NULL);
        const sn_model_muscle *m = &run.model->muscles[0];
        sn_index behind = 0, there = 0;
        for (sn_index v = 0; v < m->vertex_count; v++) {
            sn_vec3 rest = m->rest[v], p = sn_point_position(&run.state->muscles[0].points[v]);
            if (fabs(rest.z - 0.1) > 0.03 || !(m->inverse_mass[v] > 0.0)) continue;
            there++;
            behind += p.x > -0.064;
        }
        assert_true(there > 20);
        assert_int_equal(behind, 0); /* none has let it through */
        assert_true(deepest_at(&run, &scene, 4.0 / 24.0) < 1e-9);
        finish(&run);
    }
}

/* Each part of such a way is shorter than what contact follows, or it is counted. */
static sn_vec3 leaping(sn_vec3 p, double time) { return sn_v3(p.x - 3.0 * fmin(fmax(24.0 * time - 3.0, 0.0), 1.0), p.y, p.z); }

static void what_leaps_too_far_is_counted(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int far = 0; far < 2; far++) {
            sn_scene scene;
            make_soft(&scene, METHODS[i]);
            sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
            make_box(sn_v3(0.036, -0.05, 0.06), sn_v3(0.04, 0.05, 0.14), &s->envelope.mesh);
            drive(s, 25, 1.0, far ? leaping : jumping);
            simulation run = start(&scene);
            step_frames(&run, 3, NULL);
            assert_int_equal(run.state->muscles[0].statistics.leaps, 0);
            step_frames(&run, 1, NULL);
            assert_int_equal(run.state->muscles[0].statistics.leaps > 0, far);
            assert_int_equal(run.state->muscles[0].statistics.nan_points, 0);
            step_frames(&run, 1, NULL);
            assert_int_equal(run.state->muscles[0].statistics.leaps, 0); /* of one frame */
            finish(&run);
        }
}

/* A skin that shrinks onto the muscle within it leaves that alone; one that has it half inside pushes. */
static sn_vec3 passing(sn_vec3 p, double time) { return sn_v3(p.x - 0.02 * fmin(4.0 * time, 1.0), p.y, p.z); }

static void what_lies_in_a_skin_is_not_held_out_of_it(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int half = 0; half < 2; half++) {
            sn_scene scene;
            make_soft(&scene, METHODS[i]);
            sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
            make_box(sn_v3(half ? 0.01 : -0.1, -0.1, -0.1), sn_v3(0.1, 0.1, 0.4), &s->envelope.mesh);
            drive(s, 25, 1.0, passing);
            simulation run = start(&scene);
            assert_int_equal(run.model->plan.muscles[0].groups[SN_ROWS_CONTACT].rows > 0, half);
            step_frames(&run, 10, NULL);
            assert_int_equal(greatest_move(&run) > 1e-3, half);
            finish(&run);
        }
}

/* ---- what it shares with bones ---------------------------------------------------------------------------------------------------- */

/* In the middle of a substep, through bytes and in another state; the statistics of one are looked at in every iteration. */
static void a_step_goes_on_where_it_stopped(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[2];
        simulation runs[2];
        for (int k = 0; k < 2; k++) {
            make_ball(&scenes[k], METHODS[i], 0.018, swelling);
            scenes[k].solver.iterations = 3;
            runs[k] = start(&scenes[k]);
        }
        for (int frame = 0; frame < 12; frame++) {
            const sn_step_options stop = {.stop_substep = 1, .stop_iteration = 1 + frame % 2};
            double *depths = SN_NEW(double, runs[1].model->muscles[0].vertex_count);
            step_frames(&runs[0], 1, NULL);
            stop_and_reload(&runs[1], &stop);
            sn_contact_depths(runs[1].model, runs[1].state, 0, depths);
            free(depths);
            step_frames(&runs[1], 1, NULL);
            assert_same_muscle(&runs[0], 0, &runs[1], 0);
        }
        for (int k = 0; k < 2; k++) finish(&runs[k]);
    }
}

/* What a state that was read tells of depths is what the state told that was written. */
static void a_state_that_is_read_knows_its_surfaces(void **state) {
    (void)state;
    sn_scene scene;
    make_ball(&scene, SN_SOLVER_QN, 0.018, swelling);
    scene.contact.resolve = 0.0;
    simulation s = start(&scene);
    step_frames(&s, 9, NULL);
    sn_state *other;
    char *bytes;
    size_t size;
    sn_point *moved_point = &s.state->muscles[0].points[s.model->muscles[0].vertex_count / 2];
    sn_index n = s.model->muscles[0].vertex_count;
    double *depths[2] = {SN_NEW(double, n), SN_NEW(double, n)}, most = 0.0;
    sn_put(moved_point, sn_add(HEART, sn_v3(-0.02, 0, 0)));
    assert_int_equal(sn_state_pack(s.model, s.state, &bytes, &size, NULL), SN_OK);
    assert_int_equal(sn_state_create(s.model, &other, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s.model, bytes, size, other, NULL), SN_OK);
    sn_contact_depths(s.model, s.state, 0, depths[0]);
    sn_contact_depths(s.model, other, 0, depths[1]);
    for (sn_index v = 0; v < n; v++) most = fmax(most, depths[0][v]);
    assert_true(most > 0.002 && most < 0.01);
    assert_memory_equal(depths[0], depths[1], (size_t)n * sizeof **depths);
    sn_state_destroy(s.model, other);
    free(depths[0]), free(depths[1]), free(bytes);
    finish(&s);
}

static sn_vec3 coming(sn_vec3 p, double time) { return sn_v3(p.x - 0.02 * fmin(fmax((time - 1.0) / 0.4, 0.0), 1.0), p.y, p.z); }
static sn_vec3 staying(sn_vec3 p, double time) {
    (void)time;
    return p;
}

static void sleepers_wake_for_what_comes(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int comes = 0; comes < 2; comes++) {
            sn_scene scene;
            make_ball(&scene, METHODS[i], 0.015, comes ? coming : staying);
            sn_vertex_track_free(&scene.surfaces[0].track);
            drive(&scene.surfaces[0], 49, 2.0, comes ? coming : staying);
            scene.last_frame = 40;
            simulation s = start(&scene);
            step_frames(&s, 24, NULL);
            assert_true(s.state->muscles[0].statistics.asleep);
            step_frames(&s, 14, NULL);
            assert_int_equal(s.state->muscles[0].statistics.asleep, !comes);
            assert_int_equal(greatest_move(&s) > 1e-3, comes);
            assert_true(deepest_at(&s, &scene, 38.0 / 24.0) < 1e-9);
            finish(&s);
        }
}

/* A surface that nobody is to touch, one far away, and contact off: the same bits and bytes as none at all. */
static void off_is_absent(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        sn_scene scenes[4];
        simulation runs[4];
        for (int k = 0; k < 4; k++) {
            make_ball(&scenes[k], METHODS[i], 0.03, swelling);
            set_keys(&scenes[k].motion.joints[0].angle, 0.0, 0.0, 0.3, -0.4);
        }
        sn_scene_surface_free(&scenes[0].surfaces[0]);
        scenes[0].surface_count = 0;
        scenes[1].surfaces[0].solid = false;
        scenes[2].contact.enabled = false;
        for (sn_index v = 0; v < 3 * 25 * scenes[3].surfaces[0].track.vertex_count; v++) scenes[3].surfaces[0].track.positions[v] += 9.0f;
        for (int k = 0; k < 4; k++) {
            runs[k] = start(&scenes[k]);
            step_frames(&runs[k], 8, NULL);
            assert_int_equal(runs[k].model->muscles[0].contact_count, 0);
            assert_same_muscle(&runs[0], 0, &runs[k], 0);
            assert_int_equal(sn_group_state_bytes(runs[0].model, &runs[0].model->groups[0]),
                             sn_group_state_bytes(runs[k].model, &runs[k].model->groups[0]));
        }
        for (int k = 0; k < 4; k++) finish(&runs[k]);
    }
}

/* A muscle that hangs on the surface does not feel it around there, and what overlaps at rest stays as it is. */
static void what_hangs_on_it_does_not_feel_it_there(void **state) {
    (void)state;
    sn_scene scene;
    make_ball(&scene, SN_SOLVER_QN, 0.03, staying);
    sn_attachment *lower = &scene.muscles[0].rig.attachments[1];
    free(lower->bone);
    lower->bone = sn_strdup("skin");
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    const sn_contacts *contacts = sn_contacts_of(m);
    double top = 0.0, spacing = FUSIFORM.length / 16.0, lowest = INFINITY;
    for (sn_index i = 0; i < lower->count; i++) top = fmax(top, m->rest[lower->vertices[i]].z);
    for (sn_index r = 0; r < m->contact_count; r++) lowest = fmin(lowest, m->rest[contacts->rows[r].point[0]].z);
    assert_true(fabs(lowest - (top + 3.0 * spacing)) < 1e-9);
    assert_true(s.model->plan.muscles[0].overlaps >= 4);
    step_frames(&s, 20, NULL);
    assert_true(greatest_move(&s) < 1e-4);
    assert_true(s.state->muscles[0].statistics.overlap > 0.004);
    assert_true(s.state->muscles[0].statistics.penetration == 0.0);
    finish(&s);
}

/* Seams, at which a host has split vertices, are no rim; a surface that is turned inside out has its inside where it was. */
static void seams_and_turned_surfaces_do_not_matter(void **state) {
    (void)state;
    sn_scene scenes[3];
    simulation runs[3];
    for (int k = 0; k < 3; k++) {
        make_ball(&scenes[k], SN_SOLVER_QN, 0.018, swelling);
        sn_scene_surface *s = &scenes[k].surfaces[0];
        sn_mesh *mesh = &s->envelope.mesh, split = {0};
        for (sn_index t = 0; k == 1 && t < mesh->triangle_count; t++) {
            sn_index *v = mesh->triangles[t].v, last = v[1];
            v[1] = v[2], v[2] = last;
        }
        if (k == 2) { /* each triangle for itself */
            assert_int_equal(sn_mesh_alloc(&split, 3 * mesh->triangle_count, mesh->triangle_count, NULL), SN_OK);
            for (sn_index c = 0; c < split.vertex_count; c++) {
                split.positions[c] = mesh->positions[mesh->triangles[c / 3].v[c % 3]];
                split.triangles[c / 3].v[c % 3] = c;
            }
            sn_mesh_free(mesh);
            *mesh = split;
            sn_vertex_track_free(&s->track);
            drive(s, 25, 1.0, swelling);
        }
        runs[k] = start(&scenes[k]);
        step_frames(&runs[k], 16, NULL);
        assert_true(greatest_move(&runs[k]) > 0.004);
    }
    const sn_model_muscle *m = &runs[0].model->muscles[0];
    for (int k = 1; k < 3; k++)
        for (sn_index v = 0; v < m->vertex_count; v++)
            assert_true(sn_distance(sn_point_position(&runs[0].state->muscles[0].points[v]),
                                    sn_point_position(&runs[k].state->muscles[0].points[v])) < 1e-5);
    for (int k = 0; k < 3; k++) finish(&runs[k]);
}

/* Beside a muscle a ball that is inside out, and far away a large one that is not: each piece has an inside of its own; a cavity stays one.
 */
static void add_piece(sn_mesh *mesh, const capsule *ball, bool inside_out) {
    sn_mesh more = {0};
    make_capsule(ball, 8, &more);
    sn_index vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    mesh->positions = sn_realloc(mesh->positions, (size_t)(vertices + more.vertex_count), sizeof *mesh->positions);
    mesh->triangles = sn_realloc(mesh->triangles, (size_t)(triangles + more.triangle_count), sizeof *mesh->triangles);
    for (sn_index v = 0; v < more.vertex_count; v++) mesh->positions[mesh->vertex_count++] = more.positions[v];
    for (sn_index t = 0; t < more.triangle_count; t++) {
        const sn_index *v = more.triangles[t].v;
        mesh->triangles[mesh->triangle_count++] =
            (sn_triangle){{vertices + v[0], vertices + v[inside_out ? 2 : 1], vertices + v[inside_out ? 1 : 2]}};
    }
    sn_mesh_free(&more);
}

static void each_piece_is_turned_for_itself(void **state) {
    (void)state;
    sn_scene scene;
    make_ball(&scene, SN_SOLVER_QN, 0.018, swelling);
    sn_scene_surface *s = &scene.surfaces[0];
    sn_mesh_free(&s->envelope.mesh);
    sn_vertex_track_free(&s->track);
    const capsule balls[3] = {{{HEART, HEART}, 0.018}, {{{1, 0, 0}, {1, 0, 0}}, 0.2}, {{{1, 0, 0}, {1, 0, 0}}, 0.1}};
    for (int k = 0; k < 3; k++) add_piece(&s->envelope.mesh, &balls[k], k != 1);
    drive(s, 25, 1.0, swelling);
    simulation run = start(&scene);
    step_frames(&run, 16, NULL);
    assert_int_equal(run.model->plan.muscles[0].overlaps, 0);
    assert_true(greatest_move(&run) > 0.004);
    finish(&run);
}

/* In one frame of a thousand a second alone the plate is in the muscle: it is in reach. */
static sn_vec3 flashing(sn_vec3 p, double time) { return sn_v3(p.x - (fabs(time - 0.108) < 5e-4 ? 0.3 : 0.0), p.y, p.z); }

static void what_comes_for_a_frame_is_in_reach(void **state) {
    (void)state;
    sn_scene scene;
    make_soft(&scene, SN_SOLVER_QN);
    sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
    make_box(sn_v3(0.3, -0.05, 0.06), sn_v3(0.304, 0.05, 0.14), &s->envelope.mesh);
    drive(s, 201, 0.2, flashing);
    simulation run = start(&scene);
    assert_int_equal(run.model->muscles[0].collider_count, 1);
    finish(&run);
}

/* The patch is a part of the surface: whether a muscle lies in it at rest is asked of all of it, and it stays there. */
static void margins_are_of_the_whole_surface(void **state) {
    (void)state;
    sn_scene scene;
    make_soft(&scene, SN_SOLVER_QN);
    sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
    const capsule around = {{{0, 0, -0.25}, {0, 0, -0.25}}, 0.4}; /* up to three quarters of the muscle */
    make_capsule(&around, 8, &s->envelope.mesh);
    s->envelope.mesh.positions[0] = sn_v3(0.036, 0, 0.05); /* a thorn that comes near */
    drive(s, 2, 1.0, staying);
    simulation run = start(&scene);
    const sn_model_muscle *m = &run.model->muscles[0];
    const sn_contacts *contacts = sn_contacts_of(m);
    sn_surface *whole;
    assert_int_equal(sn_surface_create(&s->envelope.mesh, &whole, NULL), SN_OK);
    assert_int_equal(m->collider_count, 1);
    assert_true(contacts->colliders[0].patch->moving.triangle_count < s->envelope.mesh.triangle_count / 4);
    for (sn_index r = 0; r < m->contact_count; r++) {
        double distance = sn_surface_signed_distance(whole, m->rest[contacts->rows[r].point[0]], NULL);
        assert_true((double)contacts->rows[r].margin < fmin(contacts->margin, distance) + 1e-6);
    }
    assert_in_range(run.model->plan.muscles[0].overlaps, m->contact_count / 2, m->contact_count * 9 / 10);
    step_frames(&run, 20, NULL);
    assert_true(greatest_move(&run) < 1e-4);
    sn_surface_destroy(whole);
    finish(&run);
}

static void what_has_no_two_sides_is_refused(void **state) {
    (void)state;
    sn_scene scene;
    make_ball(&scene, SN_SOLVER_QN, 0.03, staying);
    sn_index *v = scene.surfaces[0].envelope.mesh.triangles[7].v, last = v[1];
    v[1] = v[2], v[2] = last;
    sn_model *model;
    sn_error error;
    assert_int_equal(sn_model_create(&scene, &model, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "skin"));
    assert_non_null(strstr(error.text, "mesh-clean"));
    sn_scene_free(&scene);
}

/* A plate under the muscle that a host moves sideways: with friction it takes the muscle's underside along, without it does not. */
static sn_vec3 rubbing(sn_vec3 p, double time) { return sn_v3(p.x, p.y + 0.02 * fmin(2.0 * time, 1.0), p.z); }

static void friction_takes_along(void **state) {
    (void)state;
    double along[2];
    for (int k = 0; k < 2; k++) {
        sn_scene scene;
        make_soft(&scene, SN_SOLVER_XPBD);
        sn_scene_surface *s = add_surface(&scene, SN_SURFACE_DRIVEN);
        make_box(sn_v3(0.025, -0.08, 0.05), sn_v3(0.045, 0.08, 0.15), &s->envelope.mesh);
        drive(s, 25, 1.0, rubbing);
        scene.contact.resolve = 0.1;
        scene.contact.friction = k == 0 ? 0.0 : 2.0;
        simulation run = start(&scene);
        const sn_model_muscle *m = &run.model->muscles[0];
        step_frames(&run, 12, NULL);
        along[k] = 0.0;
        for (sn_index v = 0; v < m->vertex_count; v++)
            if (m->rest[v].x > 0.027) along[k] = fmax(along[k], run.state->muscles[0].points[v].y - m->rest[v].y);
        finish(&run);
    }
    assert_true(along[0] < 0.003);
    assert_true(along[1] > 0.008 && along[1] < 0.021);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rigid_surface_is_as_a_bone),
        cmocka_unit_test(gradients_are_of_the_energy),
        cmocka_unit_test(what_swells_pushes_and_is_not_entered),
        cmocka_unit_test(what_collapses_is_survived),
        cmocka_unit_test(what_jumps_carries_the_muscle_along),
        cmocka_unit_test(what_leaps_too_far_is_counted),
        cmocka_unit_test(what_lies_in_a_skin_is_not_held_out_of_it),
        cmocka_unit_test(a_step_goes_on_where_it_stopped),
        cmocka_unit_test(a_state_that_is_read_knows_its_surfaces),
        cmocka_unit_test(sleepers_wake_for_what_comes),
        cmocka_unit_test(off_is_absent),
        cmocka_unit_test(what_hangs_on_it_does_not_feel_it_there),
        cmocka_unit_test(seams_and_turned_surfaces_do_not_matter),
        cmocka_unit_test(each_piece_is_turned_for_itself),
        cmocka_unit_test(what_comes_for_a_frame_is_in_reach),
        cmocka_unit_test(margins_are_of_the_whole_surface),
        cmocka_unit_test(what_has_no_two_sides_is_refused),
        cmocka_unit_test(friction_takes_along),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
