/*
 * contact_scene.h -- bones with surfaces for the tests of contact, made in memory: capsules, balls and boxes that stand, turn or come.
 */
#ifndef CONTACT_SCENE_H
#define CONTACT_SCENE_H

#include "sim_scene.h"

/* ---- surfaces ------------------------------------------------------------------------------------------------------------- */

/* A capsule: all points within `radius` of the segment between its ends; a ball where they are one. */
typedef struct capsule {
    sn_vec3 end[2];
    double radius;
} capsule;

static inline double capsule_distance(const capsule *c, sn_vec3 p) {
    sn_vec3 along = sn_sub(c->end[1], c->end[0]);
    double length2 = sn_norm2(along), t = length2 > 0.0 ? sn_dot(sn_sub(p, c->end[0]), along) / length2 : 0.0;
    return sn_distance(p, sn_add_scaled(c->end[0], along, fmin(fmax(t, 0.0), 1.0))) - c->radius;
}

/* Point k of ring r: rings 1 to 2 n - 1 from pole to pole, each of 4 n points. */
static inline sn_vec3 capsule_point(const capsule *c, sn_index n, sn_index ring, sn_index k) {
    sn_vec3 axis = sn_sub(c->end[1], c->end[0]), up, x, y;
    up = sn_norm2(axis) > 0.0 ? sn_normalize(axis) : sn_v3(0, 0, 1);
    x = sn_normalize(sn_cross(fabs(up.z) < 0.9 ? sn_v3(0, 0, 1) : sn_v3(1, 0, 0), up));
    y = sn_cross(up, x);
    double polar = 0.5 * SN_PI * ring / n, around = 0.5 * SN_PI * k / n, out = sn_sin(polar);
    sn_vec3 away = sn_add_scaled(sn_scale(x, out * sn_cos(around)), y, out * sn_sin(around));
    away = sn_add_scaled(away, up, -sn_cos(polar));
    return sn_add_scaled(c->end[ring > n], away, c->radius);
}

/* About n points on a quarter of a circle; the capsule's flanks have one row of quads. */
static inline void make_capsule(const capsule *c, sn_index n, sn_mesh *mesh) {
    bool ball = sn_norm2(sn_sub(c->end[1], c->end[0])) == 0.0;
    sn_index around = 4 * n, rings = 2 * n - 1 + !ball, poles = rings * around;
    assert_int_equal(sn_mesh_alloc(mesh, poles + 2, 2 * around * rings, NULL), SN_OK);
    for (sn_index i = 0; i < rings; i++) /* the middle ring twice, at either end, where it is no ball */
        for (sn_index k = 0; k < around; k++) {
            sn_index ring = ball || i < n ? i + 1 : i;
            sn_vec3 p = capsule_point(c, n, ring, k);
            if (!ball && i == n) p = sn_add(p, sn_sub(c->end[1], c->end[0]));
            mesh->positions[i * around + k] = p;
        }
    mesh->positions[poles] = capsule_point(c, n, 0, 0);
    mesh->positions[poles + 1] = capsule_point(c, n, 2 * n, 0);
    sn_triangle *t = mesh->triangles;
    for (sn_index k = 0; k < around; k++) {
        sn_index next = (k + 1) % around, last = (rings - 1) * around;
        *t++ = (sn_triangle){{poles, next, k}};
        *t++ = (sn_triangle){{poles + 1, last + k, last + next}};
        for (sn_index i = 0; i + 1 < rings; i++) {
            sn_index a = i * around + k, b = i * around + next;
            *t++ = (sn_triangle){{a, b, a + around}};
            *t++ = (sn_triangle){{b, b + around, a + around}};
        }
    }
}

static inline void make_box(sn_vec3 low, sn_vec3 high, sn_mesh *mesh) {
    static const sn_index faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    assert_int_equal(sn_mesh_alloc(mesh, 8, 12, NULL), SN_OK);
    for (int i = 0; i < 8; i++) mesh->positions[i] = sn_v3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    for (int i = 0; i < 12; i++) mesh->triangles[i] = (sn_triangle){{faces[i][0], faces[i][1], faces[i][2]}};
}

/* ---- scenes --------------------------------------------------------------------------------------------------------------- */

/* Contact is on, and the bones that the scene has so far, which have no surface, are not felt. */
static inline void turn_contact_on(sn_scene *scene) {
    scene->contact.enabled = true;
    for (sn_index b = 0; b < scene->bone_count; b++) scene->bones[b].passable = true;
}

/* A bone without surface yet; a joint of its own where keys (key_count, of time and pose; taken) are given. */
static inline sn_mesh *add_solid(sn_scene *scene, const char *name, sn_pose_key *keys, sn_index key_count) {
    scene->bones = sn_realloc(scene->bones, (size_t)scene->bone_count + 1, sizeof *scene->bones);
    sn_scene_bone *bone = &scene->bones[scene->bone_count++];
    *bone = (sn_scene_bone){.name = sn_strdup(name), .uri = sn_strdup("solid.stl"), .meters_per_unit = 1.0, .joint = SN_NONE};
    if (keys == NULL) return &bone->mesh;
    sn_motion *motion = &scene->motion;
    motion->joints = sn_realloc(motion->joints, (size_t)motion->joint_count + 1, sizeof *motion->joints);
    bone->joint = motion->joint_count;
    motion->joints[motion->joint_count++] =
        (sn_joint){.name = sn_strdup(name), .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = key_count, .keys = keys};
    return &bone->mesh;
}

static inline sn_scene_surface *add_surface(sn_scene *scene, sn_scene_surface_kind what) {
    scene->surfaces = sn_realloc(scene->surfaces, (size_t)scene->surface_count + 1, sizeof *scene->surfaces);
    sn_scene_surface *s = &scene->surfaces[scene->surface_count++];
    *s = (sn_scene_surface){.name = sn_strdup("skin"), .uri = sn_strdup("memory"), .kind = what, .loaded = true, .solid = true};
    return s;
}

typedef sn_vec3 path_of(sn_vec3 rest, double time);

/* A host's frames: samples in `seconds`, each vertex where `move` has it. */
static inline void drive(sn_scene_surface *s, sn_index samples, double seconds, path_of *move) {
    const sn_mesh *mesh = &s->envelope.mesh;
    s->track = (sn_vertex_track){samples, mesh->vertex_count, SN_NEW(double, samples),
                                 SN_NEW(float, 3 * (size_t)samples * (size_t)mesh->vertex_count)};
    for (sn_index i = 0; i < samples; i++) {
        s->track.times[i] = seconds * i / (samples - 1);
        for (sn_index v = 0; v < mesh->vertex_count; v++) {
            float *p = s->track.positions + 3 * (i * mesh->vertex_count + v);
            sn_vec3 at = move(mesh->positions[v], s->track.times[i]);
            p[0] = (float)at.x, p[1] = (float)at.y, p[2] = (float)at.z;
        }
    }
}

static inline sn_rigid shifted(sn_vec3 by) { return (sn_rigid){sn_quat_identity(), by}; }

/* From rest to `by` between two times, s. */
static inline sn_pose_key *keys_to(double begin, double end, sn_rigid by) {
    sn_pose_key *keys = SN_NEW(sn_pose_key, 2);
    keys[0] = (sn_pose_key){begin, sn_rigid_identity()};
    keys[1] = (sn_pose_key){end, by};
    return keys;
}

#endif
