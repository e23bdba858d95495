/*
 * sim_extremes.c -- the table of numerics.md 5, both columns; the rows with bones in the way are in extremes_contact.h, those with muscles
 * tied to each other in extremes_tied.h. Usage: sim_extremes [--all] [--solver xpbd|qn] [--group NAME] [MUSCLE-DOCUMENT ...]; groups:
 * stiffness activation contraction motion starts models meshes place steps cycle contact tied
 *
 * On the generated fusiform muscle, or on the documents: the last of their attachments moves, the others stay. Without --all a short form,
 * for every day. In every case the muscle stays finite and within 2 L of where its bones have been; and besides, under
 *
 *   qn     60 frames or more after the inputs are back to normal it is at rest to 1e-6 L; where it does not come back to rest, its energy
 * is at most 1 % above that of a converged solve of the same scene xpbd   60 frames or more after the inputs are back to normal it is
 * within 5e-2 L of rest
 *
 * Both run with their default settings. Prints tab-separated lines (case, solver, verdict, farthest point over L, error, remark), then
 * "N passed, N failed".
 */
#include "../unit/sim_inside.h"
#include "sinew/io.h"

#include <stdio.h>

static int passed, failed;
static sn_solver_method solver; /* of the column that is being run */
static bool all_of_it;
static bool wanted[2] = {true, true}; /* which columns: xpbd, qn */

static const char *subject; /* path of a muscle document; NULL = the fusiform muscle */

static void add_bone(sn_scene *scene, const char *name, sn_index joint) {
    scene->bones[scene->bone_count++] =
        (sn_scene_bone){.name = sn_strdup(name), .uri = sn_strdup("bone.stl"), .meters_per_unit = 1.0, .joint = joint};
}

/* Bones for all attachments of the document; the last moves with hinge 0, about the x axis through its middle. */
static void load_subject(sn_scene *scene) {
    const sn_read_options options = {0};
    sn_blob blob = {0};
    sn_document *document = NULL;
    sn_error error = {0};
    sn_scene_defaults(scene);
    scene->name = sn_strdup("test");
    scene->muscles = SN_NEW(sn_scene_muscle, 1);
    scene->muscle_count = 1;
    sn_scene_muscle *m = scene->muscles;
    *m = (sn_scene_muscle){.name = sn_strdup("muscle"), .uri = sn_strdup(subject)};
    sn_scene_muscle_defaults(m);
    if (sn_blob_read(subject, &blob, &error) != SN_OK || sn_muscle_parse(&blob, &options, &m->rig, &document, &error) != SN_OK)
        fail_msg("%s: %s", subject, error.text);
    sn_document_free(document);
    sn_blob_free(&blob);
    scene->bones = SN_NEW(sn_scene_bone, m->rig.attachment_count);
    sn_index last = m->rig.attachment_count - 1;
    for (sn_index i = 0; i <= last; i++) add_bone(scene, m->rig.attachments[i].bone, i == last ? 0 : SN_NONE);
    const sn_attachment *moving = &m->rig.attachments[last];
    sn_vec3 middle = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < moving->count; i++)
        middle = sn_add_scaled(middle, m->rig.mesh.positions[moving->vertices[i]], m->rig.meters_per_unit / moving->count);
    scene->motion.joint_count = 1;
    scene->motion.joints = SN_NEW(sn_joint, 1);
    scene->motion.joints[0] =
        (sn_joint){.name = sn_strdup("hinge"), .parent = SN_NONE, .kind = SN_JOINT_HINGE, .axis = {1, 0, 0}, .point = middle};
}

static void make_subject(sn_scene *scene) {
    if (subject == NULL)
        make_scene(scene, &FUSIFORM);
    else
        load_subject(scene);
    scene->solver = sn_solver_defaults(solver);
}

static void line(const char *name, const char *verdict, double far, double error, const char *remark) {
    printf("%s\t%s\t%s\t%.2e\t%.2e\t%s\n", name, solver == SN_SOLVER_QN ? "qn" : "xpbd", verdict, far, error, remark);
    fflush(stdout);
}

static void verdict(const char *name, bool good, double far, double error, const char *remark) {
    line(name, good ? "passed" : "FAILED", far, error, remark);
    if (good)
        passed++;
    else
        failed++;
}

/* How far from rest a muscle may be when all is over. */
static double most_error(void) { return solver == SN_SOLVER_QN ? 1e-6 : 5e-2; }

/* qn: solved until nothing moves, or for very long. */
static void converge(sn_scene *scene) {
    scene->solver.iterations = all_of_it ? 400 : 100;
    scene->solver.tolerance = 1e-8;
}

/* Phi without inertia: with an endless step there is none. J */
static double energy(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    const sn_objective objective = objective_of(s, 1e12);
    sn_vec3 *gradient = SN_NEW(sn_vec3, m->point_count);
    double found = sn_objective_evaluate(&objective, s->state->muscles[0].points, gradient);
    free(gradient);
    return found;
}

/* Is `found` no more than 1 % above `converged`? What is too little to bend anything by 1e-6 counts as nothing. */
static bool same_energy(const simulation *s, double found, double converged) {
    const sn_model_muscle *m = &s->model->muscles[0];
    return found <= 1.01 * converged + 1e-12 * inputs_of(s)->stiffness * m->diagonal * m->diagonal;
}

static sn_vec3 position_of(const simulation *s, sn_index muscle, sn_index point) {
    return sn_point_position(&s->state->muscles[muscle].points[point]);
}

/* The box of the attached points, grown by where they are now. */
static void grow_of(const simulation *s, sn_index muscle, sn_box *box) {
    const sn_model_muscle *m = &s->model->muscles[muscle];
    for (sn_index i = 0; i < m->kinematic_count; i++) {
        box->low = sn_min3(box->low, position_of(s, muscle, m->kinematic_points[i]));
        box->high = sn_max3(box->high, position_of(s, muscle, m->kinematic_points[i]));
    }
}

static void grow(const simulation *s, sn_box *box) { grow_of(s, 0, box); }

/* Greatest distance of a point from the box, over L; infinite where a point is not finite. */
static double farthest_of(const simulation *s, sn_index muscle, sn_box box) {
    const sn_model_muscle *m = &s->model->muscles[muscle];
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = position_of(s, muscle, i);
        if (!sn_finite3(p)) return INFINITY;
        most = fmax(most, sn_distance(p, sn_max3(box.low, sn_min3(p, box.high))));
    }
    return most / m->diagonal;
}

static double farthest(const simulation *s, sn_box box) { return farthest_of(s, 0, box); }

/* RMS distance from the rest pose, over L. */
static double rest_error_of(const simulation *s, sn_index muscle) {
    const sn_model_muscle *m = &s->model->muscles[muscle];
    double sum = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) sum += sn_norm2(sn_sub(position_of(s, muscle, i), m->rest[i]));
    return sqrt(sum / m->point_count) / m->diagonal;
}

static double rest_error(const simulation *s) { return rest_error_of(s, 0); }

static const sn_box NOWHERE = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Returns the greatest distance of a point from the box, which grows with the attached points. */
static double run_in(simulation *s, sn_index frames, sn_box *box) {
    double far = 0.0;
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        grow(s, box);
        far = fmax(far, farthest(s, *box));
    }
    return far;
}

static double run(simulation *s, sn_index frames) {
    sn_box box = NOWHERE;
    return run_in(s, frames, &box);
}

/* ---- stiffness, step, activation ------------------------------------------------------------------------------------------ */

/* Greatest distance of a free point from free flight, v <- v + h g, x <- x + h v, over L. */
static double flight_error(const simulation *s, sn_vec3 gravity, sn_index steps) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double h = s->model->substep_duration, speed = 0.0, way = 0.0, most = 0.0;
    for (sn_index i = 0; i < steps; i++) {
        speed += h;
        way += h * speed;
    }
    for (sn_index i = 0; i < m->point_count; i++)
        if (m->inverse_mass[i] > 0.0) most = fmax(most, sn_distance(position(s, i), sn_add_scaled(m->rest[i], gravity, way)));
    return most / m->diagonal;
}

static void stiffness_and_step(void) {
    static const double stiffness[] = {0, 1, 1e3, 5e5, 1e9, 1e12}, steps[] = {1.0 / 24, 1.0 / 240, 1e-3, 1e-5};
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 4; j++) {
            sn_scene scene;
            char name[80];
            make_subject(&scene);
            scene.muscles[0].stiffness_relaxed = scene.muscles[0].stiffness_active = stiffness[i];
            scene.muscles[0].activation.constant = 0.5;
            set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 20.0 * steps[j], -0.5);
            scene.rate = 1.0 / (steps[j] * sn_solver_substeps(&scene.solver));
            if (stiffness[i] == 0.0) scene.gravity = sn_v3(0.1, -0.2, 0.3), scene.muscles[0].damping = 0.0; /* its bones move */
            simulation s = start(&scene);
            double far = run(&s, 20),
                   flight = stiffness[i] == 0.0 ? flight_error(&s, scene.gravity, 20 * sn_solver_substeps(&scene.solver)) : 0.0;
            snprintf(name, sizeof name, "stiffness %g N/m, step %.3g s", stiffness[i], steps[j]);
            verdict(name, flight < 1e-9 && far < (stiffness[i] == 0.0 ? INFINITY : 2.0), far, flight,
                    stiffness[i] == 0.0 ? "error: against free flight" : "");
            finish(&s);
        }
    }
}

static void activations(void) {
    static const double levels[] = {0, 0.5, 0.95, 0.99};
    for (int law = 0; law < (all_of_it ? 3 : 1); law++) {
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                sn_scene scene;
                char name[80];
                make_subject(&scene);
                scene.muscles[0].law = (sn_fiber_law)law;
                scene.muscles[0].contraction = 0.99;
                scene.muscles[0].rest_activation = levels[j] / 0.99;
                set_keys(&scene.muscles[0].activation, 0.0, levels[j] / 0.99, 0.5, levels[i] / 0.99);
                simulation s = start(&scene);
                double far = run(&s, 24);
                snprintf(name, sizeof name, "a %g from a0 %g, law %s", levels[i], levels[j], sn_fiber_law_names[scene.muscles[0].law]);
                double longer = (1.0 - levels[i]) / (1.0 - levels[j]); /* a muscle at rest at a0 = 0.99 wants to be 100 times as long */
                if (scene.muscles[0].law == SN_LAW_ISOCHORIC) longer = fmax(longer, sqrt(1.0 / longer)); /* or ten times as wide */
                verdict(name, far < 2.0 * fmax(1.0, longer), far, 0.0, "");
                finish(&s);
            }
        }
    }
}

static void too_much_contraction(void) {
    sn_scene scene;
    sn_model *model = NULL;
    sn_error error = {0};
    make_subject(&scene);
    scene.muscles[0].contraction = 0.995;
    bool refused = sn_model_create(&scene, &model, &error) == SN_ERROR_INPUT && strstr(error.text, scene.muscles[0].name) != NULL &&
                   strstr(error.text, "0.99") != NULL;
    verdict("contraction above 0.99 is refused", refused, 0.0, 0.0, error.text);
    sn_model_destroy(model);
    sn_scene_free(&scene);
}

/* ---- violent motion, and back ------------------------------------------------------------------------------------------------ */

/* The moving bone jumps `away` at the first frame and is back after frames_away. */
static void jump_away(sn_scene *scene, sn_rigid away, sn_index frames_away) {
    sn_joint *joint = &scene->motion.joints[0];
    double back = frames_away / scene->rate, instant = 1e-6;
    sn_pose_key *keys = SN_NEW(sn_pose_key, 4);
    keys[0] = (sn_pose_key){1.0 / 24 - instant, sn_rigid_identity()};
    keys[1] = (sn_pose_key){1.0 / 24, away};
    keys[2] = (sn_pose_key){1.0 / 24 + back - instant, away};
    keys[3] = (sn_pose_key){1.0 / 24 + back, sn_rigid_identity()};
    *joint = (sn_joint){.name = joint->name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 4, .keys = keys};
}

/* Energy of the converged run just before the bone jumps back. */
static double energy_away(sn_rigid away, sn_index frames_away) {
    sn_scene scene;
    make_subject(&scene);
    jump_away(&scene, away, frames_away);
    converge(&scene);
    simulation s = start(&scene);
    run(&s, frames_away);
    double found = energy(&s);
    finish(&s);
    return found;
}

static void move_and_return(const char *name, sn_rigid away, sn_index frames_away, double limit) {
    sn_scene scene;
    char remark[120] = "";
    make_subject(&scene);
    jump_away(&scene, away, frames_away);
    simulation s = start(&scene);
    sn_box box = NOWHERE;
    double far = run_in(&s, frames_away, &box);
    bool good = true;
    if (solver == SN_SOLVER_QN) {
        double found = energy(&s), converged = energy_away(away, frames_away);
        good = same_energy(&s, found, converged);
        snprintf(remark, sizeof remark, "energy away %.4g J, converged %.4g J", found, converged);
    }
    far = fmax(far, run_in(&s, 1 + 60, &box));
    double error = rest_error(&s);
    verdict(name, good && far < limit && error < most_error(), far, error, remark);
    finish(&s);
}

static double subject_size(void) {
    sn_scene scene;
    make_subject(&scene);
    const sn_muscle *rig = &scene.muscles[0].rig;
    double size = sn_box_diagonal(sn_mesh_box(&rig->mesh)) * rig->meters_per_unit;
    sn_scene_free(&scene);
    return size;
}

static void violent_motion(void) {
    sn_rigid turn = {sn_quat_axis_angle(sn_v3(1, 0, 0), SN_PI / 2), {0, 0, 0}};
    sn_rigid away = {sn_quat_identity(), {50.0 * subject_size(), 0, 0}};
    move_and_return("an end teleports by 90 degrees for 36 frames", turn, 36, 2.0);
    move_and_return("an end jumps 50 L away for 20 frames", away, 20, 2.0);
}

/* ---- ugly starts ----------------------------------------------------------------------------------------------------------------- */

typedef struct placing {
    sn_vec3 centre;
    double size; /* L */
    uint64_t random;
} placing;

static double spread(placing *p) { return sn_random(&p->random) - 0.5; }

static sn_vec3 flattened(sn_vec3 p, placing *by) { return sn_v3(p.x, by->centre.y, p.z); }
static sn_vec3 mirrored(sn_vec3 p, placing *by) { return sn_v3(2.0 * by->centre.x - p.x, p.y, p.z); }
static sn_vec3 in_one_point(sn_vec3 p, placing *by) {
    (void)p;
    return by->centre;
}
static sn_vec3 shaken(sn_vec3 p, placing *by) { return sn_add_scaled(p, sn_v3(spread(by), spread(by), spread(by)), 0.1 * by->size); }
static sn_vec3 anywhere(sn_vec3 p, placing *by) {
    (void)p;
    return sn_add_scaled(by->centre, sn_v3(spread(by), spread(by), spread(by)), by->size);
}

static void start_from(const char *name, sn_vec3 (*place)(sn_vec3 rest, placing *by)) {
    sn_scene scene;
    make_subject(&scene);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    placing by = {.centre = {0, 0, 0}, .size = m->diagonal, .random = 1};
    for (sn_index i = 0; i < m->point_count; i++) by.centre = sn_add_scaled(by.centre, m->rest[i], 1.0 / m->point_count);
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = place(m->rest[i], &by);
        if (m->inverse_mass[i] > 0.0) s.state->muscles[0].points[i] = (sn_point){p.x, p.y, p.z, m->inverse_mass[i]};
    }
    double far = run(&s, 120), error = rest_error(&s);
    verdict(name, far < 2.0 && error < most_error(), far, error, "");
    finish(&s);
}

static void ugly_starts(void) {
    start_from("start: all points coincide", in_one_point);
    start_from("start: flattened to a plane", flattened);
    start_from("start: mirrored", mirrored);
    start_from("start: random points in a box of size L", anywhere);
    start_from("start: every point moved by up to L/20", shaken);
}

/* ---- ugly models: what a model says is changed after it has been made --------------------------------------------------------- */

static void uneven_masses(sn_model_muscle *m) {
    for (sn_index i = 0; i < m->point_count; i += 2) m->inverse_mass[i] *= 1e-6;
}
static void lost_lengths(sn_model_muscle *m) {
    for (sn_index r = 0; r < m->distance_start[SN_DISTANCE_KINDS]; r += 50) memset(m->distance_terms[r], 0, sizeof *m->distance_terms);
}
static void tiny_lengths(sn_model_muscle *m) {
    for (sn_index r = 0; r < m->distance_start[SN_DISTANCE_KINDS]; r++)
        for (int k = 0; k < SN_LAW_TERMS; k++) m->distance_terms[r][k] *= 1e-6;
}
static void twice_the_volume(sn_model_muscle *m) { m->rest_volume *= 2.0; }

/* The subject, changed before or after its model was made, bent within half a second and then held. */
typedef struct ugly {
    const char *name;
    void (*scene)(sn_scene *scene);        /* nullable */
    void (*model)(sn_model_muscle *model); /* nullable */
} ugly;

static simulation bend(sn_scene *scene, const ugly *by, bool converged, double *far) {
    make_subject(scene);
    if (by->scene != NULL) by->scene(scene);
    if (converged) converge(scene);
    set_keys(&scene->motion.joints[0].angle, 0.0, 0.0, 0.5, -0.3);
    simulation s = start(scene);
    if (by->model != NULL) {
        by->model(&s.model->muscles[0]);
        sn_state_destroy(s.model, s.state);
        assert_int_equal(sn_state_create(s.model, &s.state, NULL), SN_OK);
    }
    *far = run(&s, 12 + (all_of_it ? 60 : 24));
    return s;
}

/* qn: is the simulation at an equilibrium: does it keep its energy to 0.1 % when it is solved for much longer? */
static bool is_equilibrium(simulation *s, double found) {
    s->model->muscles[0].iterations = 400;
    s->model->muscles[0].tolerance = 1e-8;
    run(s, 12);
    return fabs(energy(s) / found - 1.0) < 1e-3;
}

static void with_ugly(const ugly *by) {
    sn_scene scene, reference;
    double far, unused;
    char remark[120] = "";
    simulation s = bend(&scene, by, false, &far);
    bool good = far < 2.0;
    if (solver == SN_SOLVER_QN) {
        simulation r = bend(&reference, by, true, &unused);
        double found = energy(&s), converged = energy(&r);
        bool same = same_energy(&s, found, converged), other = !same && is_equilibrium(&s, found);
        good = good && (same || other);
        snprintf(remark, sizeof remark, "energy %.4g J, converged %.4g J%s", found, converged, other ? ": another equilibrium" : "");
        finish(&r);
    }
    verdict(by->name, good, far, 0.0, remark);
    finish(&s);
}

static void ugly_models(void) {
    static const ugly MODELS[] = {{"masses in the ratio of a million", NULL, uneven_masses},
                                  {"a fiftieth of the rest lengths 0", NULL, lost_lengths},
                                  {"rest lengths a thousandth", NULL, tiny_lengths},
                                  {"twice the volume", NULL, twice_the_volume}};
    for (size_t i = 0; i < sizeof MODELS / sizeof *MODELS; i++) with_ugly(&MODELS[i]);
}

/* ---- ugly meshes ----------------------------------------------------------------------------------------------------------------- */

static bool is_attached(const sn_muscle *rig, sn_index vertex) {
    for (sn_index a = 0; a < rig->attachment_count; a++)
        for (sn_index i = 0; i < rig->attachments[a].count; i++)
            if (rig->attachments[a].vertices[i] == vertex) return true;
    return false;
}

/* The triangle in the middle of the muscle, of which no vertex is attached: the nearest to the middle of the box. */
static const sn_index *middle_triangle(const sn_muscle *rig) {
    const sn_mesh *mesh = &rig->mesh;
    sn_box box = sn_mesh_box(mesh);
    sn_vec3 middle = sn_scale(sn_add(box.low, box.high), 0.5);
    const sn_index *best = NULL;
    double least = INFINITY;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double away = sn_distance(mesh->positions[v[0]], middle);
        if (away >= least || is_attached(rig, v[0]) || is_attached(rig, v[1]) || is_attached(rig, v[2])) continue;
        least = away;
        best = v;
    }
    assert_non_null(best);
    return best;
}

/* Of the other triangle at the edge of v0 and v1. */
static sn_index vertex_across(const sn_mesh *mesh, const sn_index *v) {
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++)
            if (mesh->triangles[t].v[i] == v[1] && mesh->triangles[t].v[(i + 1) % 3] == v[0]) return mesh->triangles[t].v[(i + 2) % 3];
    return SN_NONE;
}

static void duplicate_vertex(sn_scene *scene) {
    sn_mesh *mesh = &scene->muscles[0].rig.mesh;
    const sn_index *v = middle_triangle(&scene->muscles[0].rig);
    mesh->positions[v[0]] = mesh->positions[v[1]];
}
static void make_sliver(sn_scene *scene) {
    sn_mesh *mesh = &scene->muscles[0].rig.mesh;
    const sn_index *v = middle_triangle(&scene->muscles[0].rig);
    sn_vec3 middle = sn_scale(sn_add(mesh->positions[v[1]], mesh->positions[v[2]]), 0.5);
    sn_vec3 out = sn_normalize(sn_sub(mesh->positions[v[0]], middle));
    mesh->positions[v[0]] = sn_add_scaled(middle, out, 1e-6 * sn_distance(mesh->positions[v[1]], mesh->positions[v[2]]));
}
/* The two triangles at an edge on one another: theta0 = pi. */
static void fold_flat(sn_scene *scene) {
    sn_mesh *mesh = &scene->muscles[0].rig.mesh;
    const sn_index *v = middle_triangle(&scene->muscles[0].rig);
    sn_index across = vertex_across(mesh, v);
    if (across == SN_NONE || is_attached(&scene->muscles[0].rig, across)) fail_msg("no free hinge in the middle");
    sn_vec3 middle = sn_scale(sn_add(mesh->positions[v[0]], mesh->positions[v[1]]), 0.5);
    mesh->positions[across] = sn_add_scaled(middle, sn_sub(mesh->positions[v[2]], middle), 0.8);
}

/* Greatest change of the energy over a billionth of a mean edge of one vertex's way through its place at rest, over that within a
 * tenth of an edge: a jump leaves it near 1, and so does a wall thinner than that. */
static double energy_jump(simulation *s, sn_index vertex, sn_vec3 along) {
    sn_point *p = &s->state->muscles[0].points[vertex];
    const sn_point kept = *p;
    double here = energy(s), widest = 0.0, jump = 0.0, edge = s->model->muscles[0].mean_edge;
    for (int i = -20; i <= 20; i++) {
        double t = i * 0.005 * edge;
        *p = (sn_point){kept.x + t * along.x, kept.y + t * along.y, kept.z + t * along.z, kept.w};
        widest = fmax(widest, fabs(energy(s) - here));
    }
    for (int i = -1; i <= 1; i += 2) {
        double t = i * 1e-9 * edge;
        *p = (sn_point){kept.x + t * along.x, kept.y + t * along.y, kept.z + t * along.z, kept.w};
        jump = fmax(jump, fabs(energy(s) - here));
    }
    *p = kept;
    return jump / widest;
}

static void energy_continuous(const ugly *by) {
    sn_scene scene;
    char name[80];
    make_subject(&scene);
    by->scene(&scene);
    sn_index vertex = middle_triangle(&scene.muscles[0].rig)[0];
    simulation s = start(&scene);
    double jump = energy_jump(&s, vertex, sn_normalize(sn_v3(0.3, -0.5, 0.8)));
    snprintf(name, sizeof name, "%s: energy is continuous", by->name);
    verdict(name, jump < 1e-2, 0.0, jump, "error: jump over the range of the energy");
    finish(&s);
}

/* A free vertex is carried round an edge, through the place where its triangle lies on the other: theta - theta0 passes pi. */
static void fold_through(void) {
    sn_scene scene;
    make_subject(&scene);
    const sn_index *v = middle_triangle(&scene.muscles[0].rig);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_index across = vertex_across(&scene.muscles[0].rig.mesh, v);
    sn_vec3 a = m->rest[v[0]], axis = sn_normalize(sn_sub(m->rest[v[1]], a)), arm = sn_sub(m->rest[across], a);
    double last = NAN, jump = 0.0, low = INFINITY, high = 0.0;
    enum { PARTS = 20000 };
    for (int i = 0; i <= PARTS; i++) {
        sn_vec3 at = sn_add(a, sn_quat_rotate(sn_quat_axis_angle(axis, 2.0 * SN_PI * i / PARTS), arm));
        sn_point *p = &s.state->muscles[0].points[across];
        *p = (sn_point){at.x, at.y, at.z, p->w};
        double here = 0.0, k = sn_row_stiffness(m, &s.state->muscles[0], SN_ROWS_DIHEDRAL);
        for (sn_index r = 0; r < m->hinge_count; r++) { /* the hinge of that edge alone: the others meet collapsed triangles on the way */
            const sn_index *q = m->hinges[r].point;
            if (!((q[0] == v[0] && q[1] == v[1]) || (q[0] == v[1] && q[1] == v[0]))) continue;
            sn_vec3 x[4], g[4];
            double c = 0.0;
            for (int j = 0; j < 4; j++) x[j] = position(&s, q[j]);
            if (sn_hinge_constraint(x, m->hinge_angles[r], &c, g)) here = 0.5 * k * c * c;
        }
        if (i > 0) jump = fmax(jump, fabs(here - last));
        low = fmin(low, here), high = fmax(high, here);
        last = here;
    }
    /* k/2 C^2 with |C| <= pi changes by at most k pi dC = 4 pi / parts of its range a part */
    verdict("fold through pi: energy is continuous", high > 0.0 && jump <= 1.1 * 4.0 / PARTS * (high - low), 0.0, jump / (high - low),
            "error: greatest change in 1/20000 of a turn over the range");
    finish(&s);
}

static void ugly_meshes(void) {
    static const ugly MESHES[] = {{"duplicate vertex", duplicate_vertex, NULL},
                                  {"sliver, height over edge 1e-6", make_sliver, NULL},
                                  {"a hinge at pi", fold_flat, NULL}};
    for (size_t i = 0; i < sizeof MESHES / sizeof *MESHES; i++) {
        with_ugly(&MESHES[i]);
        if (solver == SN_SOLVER_QN) energy_continuous(&MESHES[i]);
    }
    fold_through();
}

/* ---- turned, and a kilometre away ------------------------------------------------------------------------------------------------ */

static void turn_vectors(sn_index count, sn_vec3 *vectors, sn_quat by) {
    for (sn_index i = 0; vectors != NULL && i < count; i++) vectors[i] = sn_quat_rotate(by, vectors[i]);
}

static void transform(sn_scene *scene, sn_rigid by) {
    sn_muscle *rig = &scene->muscles[0].rig;
    double unit = rig->meters_per_unit;
    const sn_rigid in_units = {by.rotation, sn_scale(by.translation, 1.0 / unit)};
    for (sn_index v = 0; v < rig->mesh.vertex_count; v++) rig->mesh.positions[v] = sn_rigid_apply(in_units, rig->mesh.positions[v]);
    for (sn_index i = 0; i < rig->structure.sample_count; i++)
        rig->structure.positions[i] = sn_rigid_apply(in_units, rig->structure.positions[i]);
    turn_vectors(rig->structure.sample_count, rig->structure.axes, by.rotation);
    turn_vectors(rig->fibers.directions != NULL ? rig->mesh.vertex_count : 0, rig->fibers.directions, by.rotation);
    scene->motion.joints[0].axis = sn_quat_rotate(by.rotation, scene->motion.joints[0].axis);
    scene->motion.joints[0].point = sn_rigid_apply(by, scene->motion.joints[0].point);
    scene->gravity = sn_quat_rotate(by.rotation, scene->gravity);
}

static void a_kilometre_away(void) {
    const sn_rigid by = {sn_quat_normalize((sn_quat){0.3, -0.5, 0.7, 0.2}), {600, -700, 400}};
    sn_scene scenes[2];
    simulation s[2];
    double far = 0.0, most = 0.0;
    for (int i = 0; i < 2; i++) {
        make_subject(&scenes[i]);
        set_keys(&scenes[i].motion.joints[0].angle, 0.0, 0.0, 1.0, -0.5);
        set_keys(&scenes[i].muscles[0].activation, 0.0, 0.0, 1.0, 0.7);
        scenes[i].gravity = sn_v3(0, -9.81, 0);
        if (i == 1) transform(&scenes[i], by);
        if (solver == SN_SOLVER_QN) converge(&scenes[i]), scenes[i].solver.tolerance = 1e-9, scenes[i].solver.iterations = 2000;
        s[i] = start(&scenes[i]);
        far = fmax(far, run(&s[i], 24));
    }
    for (sn_index i = 0; i < s[0].model->muscles[0].point_count; i++)
        most = fmax(most, sn_distance(sn_rigid_apply(by, position(&s[0], i)), position(&s[1], i)));
    most /= s[0].model->muscles[0].diagonal;
    verdict("turned and moved 1 km away", far < 2.0 && most < 1e-7, far, most, "error: greatest difference");
    for (int i = 0; i < 2; i++) finish(&s[i]);
}

/* ---- for ever and ever ------------------------------------------------------------------------------------------------------------- */

/* The bone swings and the muscle contracts, both with a period of 20 frames: frame `frames` against frame 100. */
static void cyclic(sn_index frames) {
    enum { PERIOD = 20, EARLY = 100 };
    sn_scene scene;
    char name[80];
    make_subject(&scene);
    sn_channel *channels[2] = {&scene.motion.joints[0].angle, &scene.muscles[0].activation};
    for (int c = 0; c < 2; c++) {
        *channels[c] = (sn_channel){.count = frames + 1, .times = SN_NEW(double, frames + 1), .values = SN_NEW(double, frames + 1)};
        for (sn_index i = 0; i <= frames; i++) {
            double phase = 0.5 - 0.5 * cos(2.0 * SN_PI * (i % PERIOD) / PERIOD);
            channels[c]->times[i] = i / scene.rate;
            channels[c]->values[i] = c == 0 ? -0.4 * phase : 0.8 * phase;
        }
    }
    if (solver == SN_SOLVER_QN) converge(&scene); /* what is left of a step depends on the steps before it */
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    sn_vec3 *early = SN_NEW(sn_vec3, m->point_count);
    double far = run(&s, EARLY), most = 0.0; /* the bone's way is over by then */
    for (sn_index i = 0; i < m->point_count; i++) early[i] = position(&s, i);
    far = fmax(far, run(&s, frames - EARLY));
    for (sn_index i = 0; i < m->point_count; i++) most = fmax(most, sn_distance(position(&s, i), early[i]));
    most /= m->diagonal;
    snprintf(name, sizeof name, "cyclic motion: frame %d against frame 100", (int)frames);
    if (solver == SN_SOLVER_QN)
        verdict(name, far < 2.0 && most < 1e-6, far, most, "error: greatest difference");
    else
        line(name, "reported", far, most, "error: greatest difference");
    free(early);
    finish(&s);
}

/* ---- half the step, four times --------------------------------------------------------------------------------------------------- */

/* Four halvings of the step of a smooth bend, from so many substeps a frame on. Between steps that damp a muscle's swinging away and those
 * that resolve it the halvings bring it in, and have no order (the biceps from 1 substep on: 0.9, 0.6, 0.1, 0.3, 0.6, 0.75, 0.84): then the
 * second ladder counts. */
enum { HALVINGS = 4 };
typedef struct ladder {
    int frames, first;
    double tolerance; /* qn */
} ladder;
static const ladder LADDERS[] = {{12, 1, 1e-9}, {4, 64, 1e-10}};

/* Where the muscle is after a smooth bend, with so many substeps; qn: each solved until nothing moves. */
static void bend_smoothly(const ladder *by, sn_index substeps, sn_vec3 *points, sn_index *count, double *diagonal) {
    int keys = by->frames * (by->first << HALVINGS);
    sn_scene scene;
    make_subject(&scene);
    scene.solver.substeps = substeps;
    if (solver == SN_SOLVER_QN) converge(&scene), scene.solver.tolerance = by->tolerance, scene.solver.iterations = 2000;
    scene.muscles[0].stiffness_relaxed = 500.0; /* numerics.md 8's: stiffer ones only follow their bones */
    sn_channel *angle = &scene.motion.joints[0].angle;
    *angle = (sn_channel){.count = keys + 1, .times = SN_NEW(double, keys + 1), .values = SN_NEW(double, keys + 1)};
    for (int i = 0; i <= keys; i++) {
        double t = (double)i / keys;
        angle->times[i] = by->frames / scene.rate * t, angle->values[i] = -0.5 * t * t * (3.0 - 2.0 * t);
    }
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[0];
    step_frames(&s, by->frames, NULL);
    *count = m->point_count, *diagonal = m->diagonal;
    for (sn_index i = 0; i < m->point_count; i++) points[i] = position(&s, i);
    finish(&s);
}

/* e(h), the change from h to h/2, of each halving. */
static void measure_changes(const ladder *by, double changes[HALVINGS]) {
    sn_index n = 0;
    double diagonal = 1.0;
    sn_vec3 *at[2];
    sn_scene scene;
    make_subject(&scene);
    size_t room = (size_t)scene.muscles[0].rig.mesh.vertex_count + (size_t)scene.muscles[0].rig.structure.sample_count;
    sn_scene_free(&scene);
    for (int i = 0; i < 2; i++) at[i] = SN_NEW(sn_vec3, room);
    for (int k = 0; k <= HALVINGS; k++) {
        double sum = 0.0;
        bend_smoothly(by, by->first << k, at[k % 2], &n, &diagonal);
        for (sn_index i = 0; i < n; i++) sum += sn_norm2(sn_sub(at[0][i], at[1][i]));
        if (k > 0) changes[k - 1] = sqrt(sum / n) / diagonal;
    }
    for (int i = 0; i < 2; i++) free(at[i]);
}

/* p = log2(e(h) / e(h/2)) */
static void halved_steps(void) {
    double changes[HALVINGS], mean = NAN;
    char remark[120];
    for (int l = 0; l < 2 && !(mean >= 0.6 && mean <= 1.2); l++) {
        measure_changes(&LADDERS[l], changes);
        mean = log2(changes[0] / changes[HALVINGS - 1]) / (HALVINGS - 1);
        snprintf(remark, sizeof remark, "order %.2f in the mean, from %d substeps on; error: the last change", mean, LADDERS[l].first);
    }
    if (solver == SN_SOLVER_QN)
        verdict("h halved four times", mean >= 0.6 && mean <= 1.2, 0.0, changes[HALVINGS - 1], remark);
    else
        line("h halved four times", "reported", 0.0, changes[HALVINGS - 1], remark);
}

#include "extremes_contact.h"
#include "extremes_tied.h"

static void cycles(void) { cyclic(all_of_it ? 10000 : 300); }

static const struct {
    const char *name;
    void (*run)(void);
    bool long_form; /* with --all only */
} GROUPS[] = {{"stiffness", stiffness_and_step, false},
              {"activation", activations, false},
              {"contraction", too_much_contraction, false},
              {"motion", violent_motion, false},
              {"starts", ugly_starts, false},
              {"models", ugly_models, false},
              {"meshes", ugly_meshes, false},
              {"place", a_kilometre_away, false},
              {"steps", halved_steps, true},
              {"cycle", cycles, false},
              {"contact", contacts, false},
              {"tied", couplings, false}};

static const char *wanted_group; /* NULL: all of them */

static void all_cases(void) {
    for (int column = 0; column < 2; column++) {
        if (!wanted[column]) continue;
        solver = column == 0 ? SN_SOLVER_XPBD : SN_SOLVER_QN;
        for (size_t i = 0; i < sizeof GROUPS / sizeof *GROUPS; i++)
            if ((all_of_it || !GROUPS[i].long_form) && (wanted_group == NULL || strcmp(wanted_group, GROUPS[i].name) == 0)) GROUPS[i].run();
    }
}

/* Takes the options off; returns where the documents begin. */
static int read_options(int argc, char **argv) {
    int i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--all") == 0)
            all_of_it = true;
        else if (strcmp(argv[i], "--solver") == 0 && i + 1 < argc)
            i++, wanted[0] = strcmp(argv[i], "xpbd") == 0, wanted[1] = strcmp(argv[i], "qn") == 0;
        else if (strcmp(argv[i], "--group") == 0 && i + 1 < argc)
            wanted_group = argv[++i];
        else
            fail_msg("unknown option %s; see the head of sim_extremes.c", argv[i]);
    }
    return i;
}

int main(int argc, char **argv) {
    int first = read_options(argc, argv);
    if (argc <= first) all_cases();
    for (int i = first; i < argc; i++) {
        subject = argv[i];
        all_cases();
    }
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
