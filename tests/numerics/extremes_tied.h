/*
 * extremes_tied.h -- the rows of numerics.md 5 with external constraints; part of sim_extremes.c.
 *
 * The subject and its double beside it, a hair apart along the way that the subject is thinnest, each tied to the other by every type of
 * row; between the same bones. In every case all of both stays finite and within 2 L of the bones, and back to normal both come to rest in
 * 200 frames: a pair that was pulled 50 L apart takes longer than a muscle alone. Under xpbd what slides beside a neighbour that is pulled
 * by 50 L, on a plane that is found once a step, goes up to 10 L along; and rest is to 1e-1 L, as folds stay.
 */
#ifndef EXTREMES_TIED_H
#define EXTREMES_TIED_H

#include "../unit/tied_scene.h"

/* Across it, anywhere along it: its double, so far away, lies on it as far as it bends. */
static double thickest(const sn_muscle *rig) {
    double most = 0.0, heights[2];
    for (int k = 0; k <= 20; k++) {
        heights_at(rig, STAND_LENGTH * k / 20.0, 0.05 * STAND_LENGTH, heights);
        most = fmax(most, heights[1] - heights[0]);
    }
    return most;
}

/* The double: of the fusiform, or of the document; side: 1 or -1, which one along x. */
static void add_double(sn_scene *scene, double side) {
    fusiform other = FUSIFORM;
    if (subject == NULL) {
        other.offset.x = side * (2.0 * FUSIFORM.radius + 0.001);
        add_muscle(scene, "double", &other);
        return;
    }
    sn_scene from;
    load_subject(&from);
    scene->muscles = sn_realloc(scene->muscles, 2, sizeof *scene->muscles);
    scene->muscles[scene->muscle_count++] = from.muscles[0]; /* taken */
    from.muscle_count = 0;
    sn_scene_free(&from);
    sn_muscle *rig = &scene->muscles[1].rig;
    free(scene->muscles[1].name);
    scene->muscles[1].name = sn_strdup("double");
    stand_on(rig);
    sn_vec3 way = sn_scale(across(side * (thickest(rig) + 0.001)), 1.0 / rig->meters_per_unit);
    for (sn_index v = 0; v < rig->mesh.vertex_count; v++) rig->mesh.positions[v] = sn_add(rig->mesh.positions[v], way);
    for (sn_index i = 0; i < rig->structure.sample_count; i++) rig->structure.positions[i] = sn_add(rig->structure.positions[i], way);
}

static double tied_reach(const sn_scene *scene) {
    return subject == NULL ? TIED_REACH : fmax(0.005, 2.0 * mean_edge_of(&scene->muscles[0].rig));
}

static void make_tied(sn_scene *scene, const double weights[3]) {
    make_subject(scene);
    add_double(scene, 1.0);
    scene->solver = sn_solver_defaults(solver);
    tie_all(tied_reach(scene), scene, weights);
}

/* Greatest distance of a point of any muscle from where the bones have been, over L; and RMS from rest, over L, of the worst. */
typedef struct both {
    double far, error;
} both;

static both run_both(simulation *s, sn_index frames, sn_box *box) {
    both sum = {0, 0};
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        for (sn_index k = 0; k < s->model->muscle_count; k++) grow_of(s, k, box);
        for (sn_index k = 0; k < s->model->muscle_count; k++) sum.far = fmax(sum.far, farthest_of(s, k, *box));
    }
    for (sn_index k = 0; k < s->model->muscle_count; k++) sum.error = fmax(sum.error, rest_error_of(s, k));
    return sum;
}

/* A document's pair may come to rest in another place: it has several equilibria, and that is told. */
static void tied_verdict(const char *name, simulation *s, both sum, bool good, bool rests) {
    char remark[160];
    sn_index rows = 0;
    for (sn_index k = 0; k < s->model->muscle_count; k++) rows += s->model->muscles[k].external_count;
    snprintf(remark, sizeof remark, "tied: %d rows, smallest triangle %.3f and %.3f", (int)rows,
             s->state->muscles[0].statistics.smallest_triangle, s->state->muscles[1].statistics.smallest_triangle);
    good = good && rows > 0 && s->model->group_count == 1;
    if (good && !rests && subject != NULL)
        line(name, "reported", sum.far, sum.error, remark);
    else
        verdict(name, good && rests, sum.far, sum.error, remark);
    finish(s);
}

/* The neighbour alone: the subject's bones stay where they are. */
static void neighbour_moves(const char *name, const double weights[3], sn_rigid away, sn_index frames, double limit) {
    sn_scene scene;
    make_tied(&scene, weights);
    for (sn_index a = 0; a < scene.muscles[0].rig.attachment_count; a++) {
        free(scene.muscles[0].rig.attachments[a].bone);
        scene.muscles[0].rig.attachments[a].bone = sn_strdup(scene.bones[0].name);
    }
    scene.bones[0].joint = SN_NONE;
    jump_away(&scene, away, frames);
    simulation s = start(&scene);
    sn_box box = NOWHERE;
    both gone = run_both(&s, frames, &box), back = run_both(&s, 1 + 200, &box);
    back.far = fmax(gone.far, back.far);
    tied_verdict(name, &s, back, back.far < limit, back.error < 2.0 * most_error());
}

/* Both are bent and come back, where one of them is another: heavier, softer, harder. */
typedef struct unlike {
    const char *name;
    double mass, stiffness; /* of the neighbour, over the subject's */
} unlike;

static void bent_beside(const unlike *by) {
    sn_scene scene;
    make_tied(&scene, MIXED);
    scene.muscles[1].density *= by->mass;
    scene.muscles[1].stiffness_relaxed *= by->stiffness;
    scene.muscles[1].stiffness_active *= by->stiffness;
    jump_away(&scene, (sn_rigid){sn_quat_axis_angle(sn_v3(1, 0, 0), -0.3), {0, 0, 0}}, 36);
    simulation s = start(&scene);
    sn_box box = NOWHERE;
    both gone = run_both(&s, 36, &box), back = run_both(&s, 1 + 90, &box);
    back.far = fmax(gone.far, back.far);
    tied_verdict(by->name, &s, back, back.far < 2.0, true);
}

/* All that tension has against the pair: a bone that presses between, and both contract. */
static void tied_and_pressed(void) {
    sn_scene scene;
    make_soft(&scene, FUSIFORM.pinned);
    sn_scene_muscle *m = &scene.muscles[0];
    if (subject == NULL) {
        fusiform other = FUSIFORM;
        other.rings = 17, other.sectors = 12, other.structure = false, other.offset.x = -2.0 * FUSIFORM.radius - 0.001;
        add_muscle(&scene, "double", &other);
    } else {
        add_double(&scene, -1.0);
        hold_by_the_ends(&scene.muscles[1].rig);
        stand_on(&scene.muscles[0].rig);
    }
    m = scene.muscles;
    m[1].stiffness_relaxed = m[1].stiffness_active = 500.0;
    tie_all(tied_reach(&scene), &scene, SLIDE);
    add_rod(&scene, 0.052, 0.1, 0.02, keys_to(0.0, 0.5, shifted(across(-0.012))), 2);
    for (int k = 0; k < 2; k++) set_keys(&m[k].activation, 0.5, 0.0, 1.5, 1.0);
    simulation s = start(&scene);
    pressing sum = {0};
    press(&s, 60, &sum);
    both found = {sum.far, 0};
    tied_verdict("tied: slide 1 beside a bone, activation 0 to 1", &s, found, sum.far < 2.0 && sum.deepest < 1e-6 && sum.touches > 0, true);
}

/* All points of the neighbour in one: nothing to slide on, and no normals. */
static void target_in_a_point(void) {
    sn_scene scene;
    make_tied(&scene, MIXED);
    simulation s = start(&scene);
    const sn_model_muscle *m = &s.model->muscles[1];
    for (sn_index i = 0; i < m->point_count; i++)
        if (m->inverse_mass[i] > 0.0)
            s.state->muscles[1].points[i] = (sn_point){m->rest[0].x, m->rest[0].y, m->rest[0].z, m->inverse_mass[i]};
    sn_box box = NOWHERE;
    both sum = run_both(&s, 120, &box);
    tied_verdict("tied: the target starts in one point", &s, sum, sum.far < 2.0, sum.error < 2.0 * most_error());
}

static void target_missing(void) {
    sn_scene scene;
    sn_model *model = NULL;
    sn_error error = {0};
    make_tied(&scene, MIXED);
    free(scene.muscles[0].rig.externals[0].target);
    scene.muscles[0].rig.externals[0].target = sn_strdup("nobody");
    bool refused = sn_model_create(&scene, &model, &error) == SN_ERROR_INPUT && strstr(error.text, "nobody") != NULL;
    verdict("tied: a target that is not there is refused", refused, 0.0, 0.0, error.text);
    sn_model_destroy(model);
    sn_scene_free(&scene);
}

static void couplings(void) {
    static const unlike NEIGHBOURS[] = {{"tied: a neighbour a million times as heavy", 1e6, 1.0},
                                        {"tied: a neighbour a millionth as heavy", 1e-6, 1.0},
                                        {"tied: a neighbour a million times as stiff", 1.0, 1e6},
                                        {"tied: a neighbour a millionth as stiff", 1.0, 1e-6}};
    sn_rigid turn = {sn_quat_axis_angle(sn_v3(1, 0, 0), SN_PI / 2), {0, 0, 0}};
    sn_rigid away = {sn_quat_identity(), {50.0 * subject_size(), 0, 0}};
    neighbour_moves("tied: the neighbour's end turns by 90 degrees for 36 frames", MIXED, turn, 36, 2.0);
    neighbour_moves("tied: the neighbour's end jumps 50 L away for 20 frames", SLIDE, away, 20, solver == SN_SOLVER_QN ? 3.0 : 10.0);
    neighbour_moves("tied, hard: the neighbour's end jumps 50 L away for 20 frames", HARD, away, 20, 2.0);
    for (size_t i = 0; i < sizeof NEIGHBOURS / sizeof *NEIGHBOURS; i++) bent_beside(&NEIGHBOURS[i]);
    tied_and_pressed();
    target_in_a_point();
    target_missing();
}

#endif
