/*
 * sim_scene.h -- scenes for the tests of the simulation, made in memory: a fusiform muscle between two bones, one of them on a hinge.
 *
 * The muscle is numerics.md 8's: a closed shell of rings around the z axis, radius R sin(pi s)^0.8, L = 0.2 m, R = 0.03 m.
 */
#ifndef SIM_SCENE_H
#define SIM_SCENE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/sim.h"

typedef struct fusiform {
    sn_index rings, sectors; /* rings between the two tip vertices */
    double length, radius;
    double meters_per_unit;
    bool structure, fibers;
    double pinned; /* share of the length at each end that is attached; 0 = none */
    sn_vec3 offset;
} fusiform;

static const fusiform FUSIFORM = {
    .rings = 24, .sectors = 16, .length = 0.2, .radius = 0.03, .meters_per_unit = 1.0, .structure = true, .fibers = true, .pinned = 0.08};

static void make_surface(const fusiform *f, sn_mesh *mesh) {
    sn_index n = f->rings * f->sectors + 2, bottom = n - 2, top = n - 1;
    assert_int_equal(sn_mesh_alloc(mesh, n, 2 * f->rings * f->sectors, NULL), SN_OK);
    for (sn_index r = 0; r < f->rings; r++) {
        double s = (r + 1.0) / (f->rings + 1.0), radius = f->radius * sn_pow(sn_sin(SN_PI * s), 0.8);
        for (sn_index k = 0; k < f->sectors; k++) {
            double angle = 2.0 * SN_PI * (k + 0.5 * (r % 2)) / f->sectors;
            mesh->positions[r * f->sectors + k] = sn_v3(radius * sn_cos(angle), radius * sn_sin(angle), s * f->length);
        }
    }
    mesh->positions[bottom] = sn_v3(0, 0, 0);
    mesh->positions[top] = sn_v3(0, 0, f->length);
    for (sn_index i = 0; i < n; i++) mesh->positions[i] = sn_scale(sn_add(mesh->positions[i], f->offset), 1.0 / f->meters_per_unit);
    sn_triangle *t = mesh->triangles;
    for (sn_index k = 0; k < f->sectors; k++) {
        sn_index next = (k + 1) % f->sectors, last = (f->rings - 1) * f->sectors;
        *t++ = (sn_triangle){{bottom, next, k}};
        *t++ = (sn_triangle){{top, last + k, last + next}};
        for (sn_index r = 0; r + 1 < f->rings; r++) {
            sn_index a = r * f->sectors + k, b = r * f->sectors + next, c = a + f->sectors, d = b + f->sectors;
            if (r % 2 == 0) {
                *t++ = (sn_triangle){{a, b, c}};
                *t++ = (sn_triangle){{b, d, c}};
            } else {
                *t++ = (sn_triangle){{a, b, d}};
                *t++ = (sn_triangle){{a, d, c}};
            }
        }
    }
}

/* A chain of samples on the axis, one per third ring, the middle one first. */
static void make_structure(const fusiform *f, sn_muscle *muscle) {
    sn_structure *s = &muscle->structure;
    sn_index half = f->rings / 6, n = 2 * half + 1;
    s->sample_count = n;
    s->positions = SN_NEW(sn_vec3, n);
    s->parents = SN_NEW(sn_index, n);
    s->branches = SN_NEW(sn_index, n);
    s->axes = SN_NEW(sn_vec3, n);
    s->vertex_sample = SN_NEW(sn_index, muscle->mesh.vertex_count);
    for (sn_index i = 0; i < n; i++) {
        double step = i <= half ? i : half - i; /* 0, 1, 2, ... upwards, then -1, -2, ... downwards */
        sn_vec3 p = sn_v3(0, 0, f->length * (0.5 + step / (2.0 * half + 2.0)));
        s->positions[i] = sn_scale(sn_add(p, f->offset), 1.0 / f->meters_per_unit);
        s->parents[i] = i == 0 ? SN_NONE : i == half + 1 ? 0 : i - 1;
        s->axes[i] = sn_v3(0, 0, 1);
        s->branches[i] = i > half;
    }
    for (sn_index v = 0; v < muscle->mesh.vertex_count; v++) {
        s->vertex_sample[v] = 0;
        for (sn_index i = 1; i < n; i++)
            if (sn_distance(muscle->mesh.positions[v], s->positions[i]) <
                sn_distance(muscle->mesh.positions[v], s->positions[s->vertex_sample[v]]))
                s->vertex_sample[v] = i;
    }
}

static void make_fibers(const fusiform *f, sn_muscle *muscle) {
    const sn_mesh *mesh = &muscle->mesh;
    muscle->fibers.directions = SN_NEW(sn_vec3, mesh->vertex_count);
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 p = sn_sub(sn_scale(mesh->positions[v], f->meters_per_unit), f->offset);
        double s = p.z / f->length, radius = sn_length2(p.x, p.y);
        double slope = radius > 0.0 ? 0.8 * f->radius * sn_pow(sn_sin(SN_PI * s), -0.2) * sn_cos(SN_PI * s) * SN_PI / f->length : 0.0;
        sn_vec3 along = radius > 0.0 ? sn_v3(slope * p.x / radius, slope * p.y / radius, 1.0) : sn_v3(1, 0, 0);
        muscle->fibers.directions[v] = sn_normalize(along);
    }
}

static void attach_end(const fusiform *f, sn_muscle *muscle, const char *bone, bool upper) {
    sn_attachment *a = &muscle->attachments[muscle->attachment_count++];
    *a = (sn_attachment){.bone = sn_strdup(bone), .method = sn_strdup("pin"), .vertices = SN_NEW(sn_index, muscle->mesh.vertex_count)};
    for (sn_index v = 0; v < muscle->mesh.vertex_count; v++) {
        double s = (muscle->mesh.positions[v].z * f->meters_per_unit - f->offset.z) / f->length;
        if (upper ? s > 1.0 - f->pinned : s < f->pinned) a->vertices[a->count++] = v;
    }
}

static void make_muscle(const fusiform *f, sn_muscle *muscle) {
    muscle->name = sn_strdup("fusiform");
    muscle->meters_per_unit = f->meters_per_unit;
    make_surface(f, &muscle->mesh);
    if (f->structure) make_structure(f, muscle);
    if (f->fibers) make_fibers(f, muscle);
    muscle->has_attachments = true;
    muscle->attachments = SN_NEW(sn_attachment, 2);
    if (f->pinned > 0.0) attach_end(f, muscle, "upper", true);
    if (f->pinned > 0.0) attach_end(f, muscle, "lower", false);
}

/* A cube of 12 triangles in place of what mesh the bone has, and its half width, m. */
static inline void give_bone_cube(sn_scene_bone *bone, sn_vec3 middle, double half) {
    static const sn_index faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    sn_mesh_free(&bone->mesh);
    assert_int_equal(sn_mesh_alloc(&bone->mesh, 8, 12, NULL), SN_OK);
    for (int i = 0; i < 8; i++) {
        sn_vec3 corner = sn_add(middle, sn_v3(i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half));
        bone->mesh.positions[i] = sn_scale(corner, 1.0 / bone->meters_per_unit);
    }
    for (int i = 0; i < 12; i++) bone->mesh.triangles[i] = (sn_triangle){{faces[i][0], faces[i][1], faces[i][2]}};
}

static void add_muscle(sn_scene *scene, const char *name, const fusiform *f) {
    scene->muscles = sn_realloc(scene->muscles, (size_t)scene->muscle_count + 1, sizeof *scene->muscles);
    sn_scene_muscle *m = &scene->muscles[scene->muscle_count++];
    *m = (sn_scene_muscle){.name = sn_strdup(name), .uri = sn_strdup("memory")};
    sn_scene_muscle_defaults(m);
    make_muscle(f, &m->rig);
}

static inline void set_keys(sn_channel *channel, double time0, double value0, double time1, double value1) {
    sn_channel_free(channel);
    *channel = (sn_channel){.count = 2, .times = SN_NEW(double, 2), .values = SN_NEW(double, 2)};
    channel->times[0] = time0, channel->values[0] = value0;
    channel->times[1] = time1, channel->values[1] = value1;
}

/* Bones "upper" (fixed) and "lower" (on hinge 0, about the x axis through the lower tip); one muscle. */
static inline void make_scene(sn_scene *scene, const fusiform *f) {
    sn_scene_defaults(scene);
    scene->solver = sn_solver_defaults(SN_SOLVER_XPBD); /* tests of qn say so */
    scene->name = sn_strdup("test");
    scene->bone_count = 2;
    scene->bones = SN_NEW(sn_scene_bone, 2);
    scene->bones[0] = (sn_scene_bone){.name = sn_strdup("upper"), .uri = sn_strdup("upper.stl"), .meters_per_unit = 1.0, .joint = SN_NONE};
    scene->bones[1] = (sn_scene_bone){.name = sn_strdup("lower"), .uri = sn_strdup("lower.stl"), .meters_per_unit = 1.0, .joint = 0};
    scene->motion.joint_count = 1;
    scene->motion.joints = SN_NEW(sn_joint, 1);
    scene->motion.joints[0] =
        (sn_joint){.name = sn_strdup("hinge"), .parent = SN_NONE, .kind = SN_JOINT_HINGE, .axis = {1, 0, 0}, .point = f->offset};
    add_muscle(scene, "fusiform", f);
}

/* Turn and move the whole scene of one muscle. */
static inline void turn_and_move(sn_scene *scene, sn_rigid by) {
    sn_muscle *rig = &scene->muscles[0].rig;
    for (sn_index i = 0; i < rig->mesh.vertex_count; i++) {
        rig->mesh.positions[i] = sn_rigid_apply(by, rig->mesh.positions[i]);
        rig->fibers.directions[i] = sn_quat_rotate(by.rotation, rig->fibers.directions[i]);
    }
    for (sn_index i = 0; i < rig->structure.sample_count; i++) {
        rig->structure.positions[i] = sn_rigid_apply(by, rig->structure.positions[i]);
        rig->structure.axes[i] = sn_quat_rotate(by.rotation, rig->structure.axes[i]);
    }
    scene->motion.joints[0].axis = sn_quat_rotate(by.rotation, scene->motion.joints[0].axis);
    scene->motion.joints[0].point = sn_rigid_apply(by, scene->motion.joints[0].point);
}

/* A model and its state. */
typedef struct simulation {
    sn_scene *scene;
    sn_model *model;
    sn_state *state;
} simulation;

static inline simulation start(sn_scene *scene) {
    simulation s = {.scene = scene};
    sn_error error = {0};
    if (sn_model_create(scene, &s.model, &error) != SN_OK) fail_msg("%s", error.text);
    if (sn_state_create(s.model, &s.state, &error) != SN_OK) fail_msg("%s", error.text);
    return s;
}

static inline void step_frames(simulation *s, sn_index frames, const sn_step_options *options) {
    for (sn_index i = 0; i < frames; i++) assert_int_equal(sn_step(s->model, s->state, options, NULL), SN_OK);
}

static inline void finish(simulation *s) {
    sn_state_destroy(s->model, s->state);
    sn_model_destroy(s->model);
    sn_scene_free(s->scene);
}

/* Muscle i of one run is, to the bit, muscle k of another. */
static inline void assert_same_muscle(const simulation *a, sn_index i, const simulation *b, sn_index k) {
    size_t n = (size_t)a->model->muscles[i].point_count;
    assert_memory_equal(a->state->muscles[i].points, b->state->muscles[k].points, n * sizeof(sn_point));
    assert_memory_equal(a->state->muscles[i].velocities, b->state->muscles[k].velocities, n * sizeof(sn_vec3));
}

/* Step until it is told to stop, and go on with another state, through bytes. */
static inline void stop_and_reload(simulation *s, const sn_step_options *stop) {
    char *bytes;
    size_t size;
    assert_int_equal(sn_step(s->model, s->state, stop, NULL), SN_STOPPED);
    assert_int_equal(sn_state_pack(s->model, s->state, &bytes, &size, NULL), SN_OK);
    sn_state_destroy(s->model, s->state);
    assert_int_equal(sn_state_create(s->model, &s->state, NULL), SN_OK);
    assert_int_equal(sn_state_unpack(s->model, bytes, size, s->state, NULL), SN_OK);
    free(bytes);
}

static inline sn_vec3 position(const simulation *s, sn_index point) { return sn_point_position(&s->state->muscles[0].points[point]); }

/* Greatest distance of any point from its rest position. */
static inline double greatest_move(const simulation *s) {
    const sn_model_muscle *m = &s->model->muscles[0];
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) most = fmax(most, sn_distance(position(s, i), m->rest[i]));
    return most;
}

#endif
