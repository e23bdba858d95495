/*
 * kinematic.c -- attached vertices: they follow their bone rigidly and exactly.   [K21] 3.3
 *
 * Their inverse mass is 0, so that no projection moves them, and each substep puts them at pose(rest) anew.
 */
#include "rows.h"

#include <string.h>

/* The bone's index in the scene, or SN_NONE. */
static sn_index find_bone(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->bone_count; i++)
        if (scene->bones[i].name != NULL && name != NULL && strcmp(scene->bones[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_status add_site(const sn_build *build, const sn_attachment *attachment, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_index bone = find_bone(build->scene, attachment->bone);
    if (bone == SN_NONE)
        return sn_fail(error, SN_ERROR_INPUT,
                       "muscle \"%s\" is attached to bone \"%s\", which the scene does not have; add it to \"bones\"", build->source->name,
                       attachment->bone != NULL ? attachment->bone : "");
    if (attachment->count == 0) return SN_OK;
    sn_site *site = &m->sites[m->site_count++];
    *site = (sn_site){.joint = build->scene->bones[bone].joint, .begin = m->kinematic_count, .centre = {0, 0, 0}};
    for (sn_index i = 0; i < attachment->count; i++) {
        sn_index v = attachment->vertices[i];
        m->kinematic_points[m->kinematic_count++] = v;
        m->inverse_mass[v] = 0.0;
        site->centre = sn_add_scaled(site->centre, m->rest[v], 1.0 / attachment->count);
    }
    site->end = m->kinematic_count;
    return SN_OK;
}

sn_status sn_kinematics_build(const sn_build *build, sn_error *error) {
    const sn_muscle *rig = &build->source->rig;
    sn_model_muscle *m = build->model;
    size_t count = 0;
    for (sn_index i = 0; i < rig->attachment_count; i++) count += (size_t)rig->attachments[i].count;
    m->kinematic_points = SN_NEW(sn_index, count);
    m->sites = SN_NEW(sn_site, rig->attachment_count);
    if (m->kinematic_points == NULL || m->sites == NULL) return sn_fail_memory(error, "attachments");
    for (sn_index i = 0; i < rig->attachment_count; i++) {
        sn_status status = add_site(build, &rig->attachments[i], error);
        if (status != SN_OK) return status;
    }
    build->plan->kinematic = m->kinematic_count;
    return SN_OK;
}

static sn_vec3 carried(const sn_site *site, const sn_rigid *poses, sn_vec3 rest) {
    return site->joint == SN_NONE ? rest : sn_rigid_apply(poses[site->joint], rest);
}

static void put(sn_point *point, sn_vec3 position) { point->x = position.x, point->y = position.y, point->z = position.z; }

static sn_rigid pose_of(const sn_site *site, const sn_rigid *poses) {
    return site->joint == SN_NONE ? sn_rigid_identity() : poses[site->joint];
}

bool sn_kinematics_moved(const sn_model_muscle *m, const sn_muscle_state *s, const sn_rigid *poses) {
    for (sn_index i = 0; i < m->site_count; i++) {
        const sn_rigid pose = pose_of(&m->sites[i], poses);
        if (memcmp(&pose, &s->placed[i], sizeof pose) != 0) return true;
    }
    return false;
}

void sn_kinematics_place(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *poses) {
    for (sn_index i = 0; i < m->site_count; i++) {
        const sn_site *site = &m->sites[i];
        s->placed[i] = pose_of(site, poses);
        for (sn_index k = site->begin; k < site->end; k++) {
            sn_index v = m->kinematic_points[k];
            put(&s->points[v], carried(site, poses, m->rest[v]));
        }
    }
}

/* Where the poses of all sites would carry a rest point, each weighted by 1 / (squared distance to the site + edge^2). */
static sn_vec3 blend(const sn_model_muscle *m, const sn_rigid *poses, sn_vec3 rest) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    double weights = 0.0;
    for (sn_index i = 0; i < m->site_count; i++) {
        double weight = 1.0 / (sn_norm2(sn_sub(rest, m->sites[i].centre)) + m->mean_edge * m->mean_edge);
        sum = sn_add_scaled(sum, sn_sub(carried(&m->sites[i], poses, rest), rest), weight);
        weights += weight;
    }
    return weights > 0.0 ? sn_add_scaled(rest, sum, 1.0 / weights) : rest;
}

void sn_kinematics_carry(const sn_model_muscle *m, sn_muscle_state *s, const sn_rigid *poses) {
    for (sn_index i = 0; i < m->point_count; i++) put(&s->points[i], blend(m, poses, m->rest[i]));
    sn_kinematics_place(m, s, poses);
}

/* Of the attached points, on average. */
static sn_vec3 velocity_of_bones(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index k = 0; k < m->kinematic_count; k++) sum = sn_add(sum, s->velocities[m->kinematic_points[k]]);
    return m->kinematic_count > 0 ? sn_scale(sum, 1.0 / m->kinematic_count) : sum;
}

void sn_kinematics_limit_speed(const sn_model_muscle *m, sn_muscle_state *s, double most) {
    sn_vec3 bones = velocity_of_bones(m, s);
    if (!(most > 0.0) || m->kinematic_count == 0) return;
    if (sn_norm(bones) > most) bones = sn_v3(0, 0, 0); /* that is a jump, not a motion */
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 v = sn_sub(s->velocities[i], bones);
        double square = sn_norm2(v);
        if (square > most * most) s->velocities[i] = sn_add_scaled(bones, v, most / sqrt(square));
    }
}
