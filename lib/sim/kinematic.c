/*
 * kinematic.c -- attached vertices: they follow their bone rigidly and exactly, or a surface.   [K21] 3.3, [R18] 4.2
 *
 * Their inverse mass is 0, so that no projection moves them, and each substep puts them at pose(rest) anew. Of a frozen muscle all vertices
 * are such points, each at its own place.
 */
#include "rows.h"

#include <stdlib.h>
#include <string.h>

/* The vertices of an attachment become kinematic points of a new site. */
static sn_site *add_points(const sn_build *build, const sn_attachment *attachment) {
    sn_model_muscle *m = build->model;
    sn_site *site = &m->sites[m->site_count++];
    *site = (sn_site){.joint = SN_NONE, .surface = SN_NONE, .begin = m->kinematic_count, .centre = {0, 0, 0}};
    for (sn_index i = 0; i < attachment->count; i++) {
        sn_index v = attachment->vertices[i];
        m->kinematic_mass[m->kinematic_count] = 1.0 / m->inverse_mass[v];
        m->kinematic_points[m->kinematic_count++] = v;
        m->inverse_mass[v] = 0.0;
        site->centre = sn_add_scaled(site->centre, m->rest[v], 1.0 / attachment->count);
    }
    site->end = m->kinematic_count;
    return site;
}

/* An attachment farther from its surface than this share of the muscle's diagonal is likely to be meant otherwise: another unit, place or
 * mesh. */
static const double FAR_FROM_SURFACE = 0.1;

static sn_index nearest_to_centre(const sn_model_muscle *m, const sn_site *site) {
    sn_index nearest = site->begin;
    for (sn_index k = site->begin + 1; k < site->end; k++)
        if (sn_distance(m->rest[m->kinematic_points[k]], site->centre) < sn_distance(m->rest[m->kinematic_points[nearest]], site->centre))
            nearest = k;
    return site->first_follower + (nearest - site->begin);
}

/* The points of a site follow a surface of the scene. */
static sn_status follow(const sn_build *build, sn_site *site, sn_error *error) {
    sn_model_muscle *m = build->model;
    const sn_scene_surface *surface = &build->scene->surfaces[site->surface];
    sn_index count = site->end - site->begin;
    double farthest;
    sn_vec3 *points = SN_NEW(sn_vec3, count);
    if (points == NULL) return sn_fail_memory(error, "attachments");
    for (sn_index i = 0; i < count; i++) points[i] = m->rest[m->kinematic_points[site->begin + i]];
    site->first_follower = m->follower_count;
    sn_status status = sn_followers_bind(surface, count, points, m->followers + site->first_follower, &farthest, error);
    free(points);
    if (status != SN_OK) return status;
    m->follower_count += count;
    m->pose_count = build->scene->motion.joint_count;
    site->middle = nearest_to_centre(m, site);
    if (farthest > FAR_FROM_SURFACE * m->diagonal)
        sn_log(SN_LOG_WARNING, "muscle \"%s\": a vertex attached to the surface \"%s\" is %.3g mm away from it; see units and rest shapes",
               build->source->name, surface->name, 1e3 * farthest);
    return SN_OK;
}

static sn_status add_site(const sn_build *build, const sn_attachment *attachment, sn_error *error) {
    sn_carrier carrier = sn_scene_carrier(build->scene, attachment->bone);
    if (carrier.kind == SN_CARRIER_NONE)
        return sn_fail(error, SN_ERROR_INPUT,
                       "muscle \"%s\" is attached to bone \"%s\", which the scene does not have; add it to \"bones\"", build->source->name,
                       attachment->bone != NULL ? attachment->bone : "");
    if (attachment->count == 0) return SN_OK;
    sn_site *site = add_points(build, attachment);
    if (carrier.kind == SN_CARRIER_BONE) site->joint = build->scene->bones[carrier.index].joint;
    if (carrier.kind == SN_CARRIER_JOINT) site->joint = carrier.index;
    if (carrier.kind != SN_CARRIER_SURFACE) return SN_OK;
    site->surface = carrier.index;
    return follow(build, site, error);
}

/* All vertices of a frozen muscle are one site. */
static sn_status freeze(const sn_build *build, sn_error *error) {
    sn_model_muscle *m = build->model;
    sn_attachment all = {.count = m->vertex_count, .vertices = SN_NEW(sn_index, m->vertex_count)};
    if (all.vertices == NULL) return sn_fail_memory(error, "a frozen muscle");
    for (sn_index v = 0; v < all.count; v++) all.vertices[v] = v;
    add_points(build, &all)->frozen = true;
    free(all.vertices);
    m->follower_count = m->vertex_count;
    return SN_OK;
}

/* Vertices of attachments to surfaces. */
static size_t count_followers(const sn_scene *scene, const sn_muscle *rig) {
    size_t count = 0;
    for (sn_index i = 0; i < rig->attachment_count; i++)
        if (sn_scene_carrier(scene, rig->attachments[i].bone).kind == SN_CARRIER_SURFACE) count += (size_t)rig->attachments[i].count;
    return count;
}

sn_status sn_kinematics_build(const sn_build *build, sn_error *error) {
    const sn_muscle *rig = &build->source->rig;
    sn_model_muscle *m = build->model;
    size_t count = 0;
    bool frozen = build->source->frozen.sample_count > 0;
    for (sn_index i = 0; i < rig->attachment_count; i++) count += (size_t)rig->attachments[i].count;
    if (frozen) count = (size_t)m->vertex_count;
    m->kinematic_points = SN_NEW(sn_index, count);
    m->kinematic_mass = SN_NEW(double, count);
    m->sites = SN_NEW(sn_site, frozen ? 1 : rig->attachment_count);
    m->followers = SN_NEW(sn_follower, frozen ? count : count_followers(build->scene, rig));
    if (m->kinematic_points == NULL || m->kinematic_mass == NULL || m->sites == NULL || m->followers == NULL)
        return sn_fail_memory(error, "attachments");
    sn_status status = frozen ? freeze(build, error) : SN_OK;
    for (sn_index i = 0; i < rig->attachment_count && !frozen && status == SN_OK; i++)
        status = add_site(build, &rig->attachments[i], error);
    build->plan->kinematic = m->kinematic_count;
    return status;
}

static void put(sn_point *point, sn_vec3 position) { point->x = position.x, point->y = position.y, point->z = position.z; }

static void aim_at_bones(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    for (sn_index i = 0; i < m->site_count; i++) {
        sn_index joint = m->sites[i].joint;
        s->inputs->poses[i] = joint == SN_NONE    ? sn_rigid_identity()
                              : at->poses != NULL ? at->poses[joint]
                                                  : sn_motion_run_in_pose(&scene->motion, joint, at->time, at->share);
    }
}

static void aim_at_surfaces(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    for (sn_index i = 0; i < m->site_count; i++) {
        const sn_site *site = &m->sites[i];
        if (site->surface == SN_NONE) continue;
        const sn_scene_surface *surface = &scene->surfaces[site->surface];
        for (sn_index f = site->first_follower; f < site->first_follower + site->end - site->begin; f++)
            s->inputs->targets[f] = sn_follower_place(surface, at, &m->followers[f]);
        s->inputs->poses[i] = sn_follower_pose(surface, at, &m->followers[site->middle]);
    }
}

sn_surface_moment sn_kinematics_moment(sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    sn_surface_moment all = *at;
    if (all.poses != NULL) return all;
    sn_motion_run_in_poses(&scene->motion, at->time, at->share, s->inputs->joint_poses);
    all.poses = s->inputs->joint_poses;
    return all;
}

/* Along its track; on the way to it from rest in a run-in. */
static void aim_at_track(const sn_model_muscle *m, sn_muscle_state *s, const sn_surface_moment *at) {
    for (sn_index v = 0; v < m->vertex_count; v++) {
        sn_vec3 there = sn_vertex_track_at(&m->source->frozen, at->time, v);
        s->inputs->targets[v] = at->share >= 1.0 ? there : sn_lerp(m->rest[v], there, at->share);
    }
    s->inputs->poses[0] = sn_rigid_identity();
}

void sn_kinematics_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    if (m->source->frozen.sample_count > 0) {
        aim_at_track(m, s, at);
        return;
    }
    aim_at_bones(m, s, scene, at);
    if (m->follower_count == 0) return;
    sn_surface_moment all = sn_kinematics_moment(s, scene, at);
    aim_at_surfaces(m, s, scene, &all);
}

/* Has each of its points a target of its own? */
static bool follows(const sn_site *site) { return site->surface != SN_NONE || site->frozen; }

/* A bone that never moves leaves its points alone, to the last bit. */
static sn_vec3 carried(const sn_model_muscle *m, const sn_muscle_state *s, sn_index site, sn_vec3 rest) {
    bool still = m->sites[site].joint == SN_NONE && m->sites[site].surface == SN_NONE;
    return still ? rest : sn_rigid_apply(s->inputs->poses[site], rest);
}

sn_vec3 sn_kinematics_target(const sn_model_muscle *m, const sn_muscle_state *s, sn_index site, sn_index k) {
    const sn_site *at = &m->sites[site];
    if (follows(at)) return s->inputs->targets[at->first_follower + k - at->begin];
    return carried(m, s, site, m->rest[m->kinematic_points[k]]);
}

static bool followers_moved(const sn_model_muscle *m, const sn_muscle_state *s, sn_index site) {
    for (sn_index k = m->sites[site].begin; k < m->sites[site].end; k++) {
        sn_vec3 target = sn_kinematics_target(m, s, site, k), point = sn_point_position(&s->points[m->kinematic_points[k]]);
        if (target.x != point.x || target.y != point.y || target.z != point.z) return true;
    }
    return false;
}

bool sn_kinematics_moved(const sn_model_muscle *m, const sn_muscle_state *s) {
    if (m->site_count == 0) return false;
    if (memcmp(s->inputs->poses, s->inputs->placed, (size_t)m->site_count * sizeof *s->inputs->poses) != 0) return true;
    for (sn_index i = 0; i < m->site_count; i++)
        if (follows(&m->sites[i]) && followers_moved(m, s, i)) return true;
    return false;
}

static void place(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points) {
    for (sn_index i = 0; i < m->site_count; i++)
        for (sn_index k = m->sites[i].begin; k < m->sites[i].end; k++)
            put(&points[m->kinematic_points[k]], sn_kinematics_target(m, s, i, k));
}

void sn_kinematics_place(const sn_model_muscle *m, sn_muscle_state *s) {
    if (m->site_count > 0) memcpy(s->inputs->placed, s->inputs->poses, (size_t)m->site_count * sizeof *s->inputs->placed);
    place(m, s, s->points);
}

/* Where the poses of all sites would carry a rest point, each weighted by 1 / (squared distance to the site + edge^2). */
static sn_vec3 blend(const sn_model_muscle *m, const sn_muscle_state *s, sn_vec3 rest) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    double weights = 0.0;
    for (sn_index i = 0; i < m->site_count; i++) {
        double weight = 1.0 / (sn_norm2(sn_sub(rest, m->sites[i].centre)) + m->mean_edge * m->mean_edge);
        sum = sn_add_scaled(sum, sn_sub(carried(m, s, i, rest), rest), weight);
        weights += weight;
    }
    return weights > 0.0 ? sn_add_scaled(rest, sum, 1.0 / weights) : rest;
}

void sn_kinematics_carry(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points) {
    for (sn_index i = 0; i < m->point_count; i++) put(&points[i], blend(m, s, m->rest[i]));
    place(m, s, points);
}

/* ---- the motion of the bones ------------------------------------------------------------------------------------------------ */

/* A motion about an axis that the attached points say nothing of (all of them lie on it) is none: this share of their spread is added to
 * the matrix of the fit. */
static const double LEAST_SPREAD = 1e-10;

typedef struct carried_point {
    sn_vec3 middle, velocity; /* half way through the step */
    double mass;
} carried_point;

static carried_point carried_point_of(const sn_model_muscle *m, const sn_muscle_state *s, sn_index k, double h) {
    sn_index v = m->kinematic_points[k];
    return (carried_point){.middle = sn_add_scaled(sn_point_position(&s->points[v]), s->velocities[v], -0.5 * h),
                           .velocity = s->velocities[v],
                           .mass = m->kinematic_mass[k]};
}

/* Means over the attached points: where, and how fast. */
static void find_middle(const sn_model_muscle *m, const sn_muscle_state *s, double h, sn_bone_motion *bones) {
    double mass = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++) {
        carried_point p = carried_point_of(m, s, k, h);
        bones->middle = sn_add_scaled(bones->middle, p.middle, p.mass);
        bones->velocity = sn_add_scaled(bones->velocity, p.velocity, p.mass);
        mass += p.mass;
    }
    bones->middle = sn_scale(bones->middle, 1.0 / mass);
    bones->velocity = sn_scale(bones->velocity, 1.0 / mass);
}

/* sum += mass (r.r - r rT) */
static void add_inertia(sn_mat3 *sum, sn_vec3 r, double mass) {
    const double c[3] = {r.x, r.y, r.z};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) sum->m[i][j] += mass * ((i == j ? sn_norm2(r) : 0.0) - c[i] * c[j]);
}

/* a^-1 b by Cramer's rule; zero where a is singular. */
static sn_vec3 solve3(const sn_mat3 *a, sn_vec3 b) {
    sn_vec3 column[3];
    for (int c = 0; c < 3; c++) column[c] = sn_v3(a->m[0][c], a->m[1][c], a->m[2][c]);
    double size = sn_dot(column[0], sn_cross(column[1], column[2]));
    if (!(fabs(size) > 0.0)) return sn_v3(0, 0, 0);
    return sn_scale(sn_v3(sn_dot(b, sn_cross(column[1], column[2])), sn_dot(column[0], sn_cross(b, column[2])),
                          sn_dot(column[0], sn_cross(column[1], b))),
                    1.0 / size);
}

/* The turn b that makes the sum of mass |velocity - b x r|^2 least: (sum mass (r.r - r rT)) b = sum mass r x velocity. */
static sn_vec3 find_turn(const sn_model_muscle *m, const sn_muscle_state *s, double h, const sn_bone_motion *bones) {
    sn_mat3 spread = {0};
    sn_vec3 moment = sn_v3(0, 0, 0);
    for (sn_index k = 0; k < m->kinematic_count; k++) {
        carried_point p = carried_point_of(m, s, k, h);
        sn_vec3 r = sn_sub(p.middle, bones->middle);
        add_inertia(&spread, r, p.mass);
        moment = sn_add_scaled(moment, sn_cross(r, sn_sub(p.velocity, bones->velocity)), p.mass);
    }
    double least = LEAST_SPREAD * (spread.m[0][0] + spread.m[1][1] + spread.m[2][2]);
    for (int i = 0; i < 3; i++) spread.m[i][i] += least;
    return solve3(&spread, moment);
}

/* Attached points nearly on a line say little of a turn about it: where it would move a point of the muscle so many times faster than any
 * that is attached, it is that of another motion, of bones against each other. */
static const double MOST_TURNED = 4.0;

static sn_vec3 bound_turn(const sn_model_muscle *m, const sn_muscle_state *s, const sn_bone_motion *bones, sn_vec3 turn) {
    double attached = 0.0, turned = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++)
        attached = fmax(attached, sn_norm2(sn_sub(s->velocities[m->kinematic_points[k]], bones->velocity)));
    for (sn_index i = 0; i < m->point_count; i++)
        turned = fmax(turned, sn_norm2(sn_cross(turn, sn_sub(sn_point_position(&s->points[i]), bones->middle))));
    double most = MOST_TURNED * sqrt(attached), found = sqrt(turned);
    return found > most ? sn_scale(turn, most / found) : turn;
}

static bool bones_rest(const sn_model_muscle *m, const sn_muscle_state *s) {
    for (sn_index k = 0; k < m->kinematic_count; k++)
        if (sn_norm2(s->velocities[m->kinematic_points[k]]) > 0.0) return false;
    return true;
}

void sn_kinematics_watch_bones(const sn_model_muscle *m, sn_muscle_state *s, double h, double most) {
    sn_vec3 before = s->inputs->bones.velocity;
    sn_bone_motion *bones = &s->inputs->bones;
    *bones = (sn_bone_motion){.rate = 0.0};
    if (bones_rest(m, s)) return;
    find_middle(m, s, h, bones);
    if (most > 0.0 && !(sn_distance(bones->velocity, before) <= most)) return;
    bones->turn = sn_scale(bound_turn(m, s, bones, find_turn(m, s, h, bones)), h);
    bones->rate = 1.0 / h;
}

sn_vec3 sn_bone_motion_at(const sn_bone_motion *bones, sn_vec3 x) {
    sn_vec3 b = bones->turn;
    if (bones->rate == 0.0) return sn_v3(0, 0, 0);
    /* (1 + [b]x / 2) d = w */
    sn_vec3 w = sn_add_scaled(bones->velocity, sn_cross(b, sn_sub(x, bones->middle)), bones->rate);
    sn_vec3 d = sn_add_scaled(sn_add_scaled(w, sn_cross(b, w), -0.5), b, 0.25 * sn_dot(b, w));
    return sn_scale(d, 1.0 / (1.0 + 0.25 * sn_norm2(b)));
}

sn_vec3 sn_damped_velocity(const sn_muscle_state *s, sn_index point, double keep) {
    sn_vec3 bones = sn_bone_motion_at(&s->inputs->bones, sn_point_position(&s->points[point]));
    return sn_add_scaled(bones, sn_sub(s->velocities[point], bones), keep);
}

void sn_kinematics_limit_speed(const sn_model_muscle *m, sn_muscle_state *s, double most) {
    if (!(most > 0.0) || m->kinematic_count == 0) return;
    for (sn_index i = 0; i < m->point_count; i++) {
        if (s->points[i].w == 0.0) continue;
        sn_vec3 bones = sn_bone_motion_at(&s->inputs->bones, sn_point_position(&s->points[i])), v = sn_sub(s->velocities[i], bones);
        double square = fmin(sn_norm2(v), sn_norm2(s->velocities[i])); /* one that the bones leave behind is not drawn after them */
        if (square > most * most) s->velocities[i] = sn_add_scaled(bones, v, most / sn_norm(v));
    }
}
