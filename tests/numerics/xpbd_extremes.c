/*
 * xpbd_extremes.c -- numerics.md 5, column `xpbd`, the cases without bones in the way. Usage: xpbd_extremes [--single] [MUSCLE-DOCUMENT
 * ...]
 *
 * On the generated fusiform muscle, or on the documents: the last of their attachments moves, the others stay. A case passes when every
 * frame is finite, no point is ever farther than 2 L from where the muscle's bones have been, and, where the inputs go back to normal, the
 * muscle does too. Prints a table, then "N passed, N failed".
 */
#include "../unit/sim_scene.h"
#include "sinew/io.h"

#include <stdio.h>

static int passed, failed;

static const char *subject; /* path of a muscle document; NULL = the fusiform muscle */
static sn_precision precision;

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
    scene->solver.precision = precision;
}

static void verdict(const char *name, bool good, double far, double error) {
    printf("%-58s %s  farthest %.2e L  error %.2e\n", name, good ? "passed" : "FAILED", far, error);
    if (good)
        passed++;
    else
        failed++;
}

/* The box of the attached points, grown by where they are now. */
static void grow(const simulation *s, sn_box *box) {
    const sn_model_muscle *m = &s->model->muscles[0];
    for (sn_index i = 0; i < m->kinematic_count; i++) {
        box->low = sn_min3(box->low, position(s, m->kinematic_points[i]));
        box->high = sn_max3(box->high, position(s, m->kinematic_points[i]));
    }
}

/* Greatest distance of a point from the box, over L; infinite where a point is not finite. */
static double farthest(const simulation *s, sn_box box) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = position(s, i);
        if (!sn_finite3(p)) return INFINITY;
        most = fmax(most, sn_distance(p, sn_max3(box.low, sn_min3(p, box.high))));
    }
    return most / m->diagonal;
}

/* RMS distance from the rest pose, over L. */
static double rest_error(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double sum = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) sum += sn_norm2(sn_sub(position(s, i), m->rest[i]));
    return sqrt(sum / m->point_count) / m->diagonal;
}

static double run(simulation *s, sn_index frames) {
    sn_box box = {sn_v3(INFINITY, INFINITY, INFINITY), sn_v3(-INFINITY, -INFINITY, -INFINITY)};
    double far = 0.0;
    for (sn_index i = 0; i < frames; i++) {
        step_frames(s, 1, NULL);
        grow(s, &box);
        far = fmax(far, farthest(s, box));
    }
    return far;
}

/* ---- stiffness, step, activation ------------------------------------------------------------------------------------------ */

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
            scene.rate = 1.0 / (steps[j] * scene.solver.substeps);
            simulation s = start(&scene);
            double far = run(&s, 20);
            snprintf(name, sizeof name, "stiffness %g N/m, step %.3g s", stiffness[i], steps[j]);
            verdict(name, far < 2.0, far, 0.0);
            finish(&s);
        }
    }
}

static void activations(void) {
    static const double levels[] = {0, 0.5, 0.95, 0.99};
    for (int law = 0; law < 3; law++) {
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
                snprintf(name, sizeof name, "a %g from a0 %g, law %s", levels[i], levels[j], sn_fiber_law_name(scene.muscles[0].law));
                double longer = (1.0 - levels[i]) / (1.0 - levels[j]); /* a muscle at rest at a0 = 0.99 wants to be 100 times as long */
                verdict(name, far < 2.0 * fmax(1.0, longer), far, 0.0);
                finish(&s);
            }
        }
    }
}

/* ---- violent motion, and back ------------------------------------------------------------------------------------------------ */

static void move_and_return(const char *name, sn_rigid away, sn_index frames_away, double limit) {
    sn_scene scene;
    make_subject(&scene);
    sn_joint *joint = &scene.motion.joints[0];
    double back = frames_away / scene.rate, instant = 1e-6;
    sn_pose_key *keys = SN_NEW(sn_pose_key, 4);
    keys[0] = (sn_pose_key){1.0 / 24 - instant, sn_rigid_identity()};
    keys[1] = (sn_pose_key){1.0 / 24, away};
    keys[2] = (sn_pose_key){1.0 / 24 + back - instant, away};
    keys[3] = (sn_pose_key){1.0 / 24 + back, sn_rigid_identity()};
    *joint = (sn_joint){.name = joint->name, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 4, .keys = keys};
    simulation s = start(&scene);
    double far = run(&s, 1 + frames_away + 60), error = rest_error(&s);
    verdict(name, far < limit && error < 5e-2, far, error);
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
    move_and_return("an end teleports by 90 degrees for 12 frames", turn, 12, 2.0);
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
    verdict(name, far < 2.0 && error < 5e-2, far, error);
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

static void with_model(const char *name, void (*spoil)(sn_model_muscle *)) {
    sn_scene scene;
    make_subject(&scene);
    set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.5, -0.3);
    simulation s = start(&scene);
    spoil(&s.model->muscles[0]);
    sn_state_destroy(s.model, s.state);
    assert_int_equal(sn_state_create(s.model, &s.state, NULL), SN_OK);
    double far = run(&s, 36);
    verdict(name, far < 2.0, far, 0.0);
    finish(&s);
}

static void ugly_models(void) {
    with_model("masses in the ratio of a million", uneven_masses);
    with_model("a fiftieth of the rest lengths 0", lost_lengths);
    with_model("rest lengths a thousandth", tiny_lengths);
    with_model("twice the volume", twice_the_volume);
}

/* ---- half the step, four times: reported ------------------------------------------------------------------------------------- */

static void halved_steps(void) {
    sn_vec3 *last = NULL;
    double before = 0.0;
    for (sn_index substeps = 16; substeps <= 256; substeps *= 2) {
        sn_scene scene;
        make_subject(&scene);
        scene.solver.substeps = substeps;
        set_keys(&scene.motion.joints[0].angle, 0.0, 0.0, 0.5, -0.5);
        simulation s = start(&scene);
        const sn_model_muscle *m = &s.model->muscles[0];
        double sum = 0.0;
        step_frames(&s, 6, NULL);
        if (last == NULL) last = SN_NEW(sn_vec3, m->point_count);
        for (sn_index i = 0; i < m->point_count; i++) {
            sum += sn_norm2(sn_sub(position(&s, i), last[i]));
            last[i] = position(&s, i);
        }
        double change = sqrt(sum / m->point_count) / m->diagonal;
        if (substeps > 32)
            printf("reported: from %d to %d substeps the change is %.2e L, the observed order %.2f\n", (int)substeps / 2, (int)substeps,
                   change, log2(before / change));
        before = change;
        finish(&s);
    }
    free(last);
}

static void all_cases(void) {
    stiffness_and_step();
    activations();
    violent_motion();
    ugly_starts();
    ugly_models();
    if (subject != NULL) halved_steps();
}

int main(int argc, char **argv) {
    int first = argc > 1 && strcmp(argv[1], "--single") == 0 ? 2 : 1;
    if (first == 2) precision = SN_PRECISION_SINGLE;
    if (argc == first) all_cases();
    for (int i = first; i < argc; i++) {
        subject = argv[i];
        printf("%s\n", subject);
        all_cases();
    }
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
