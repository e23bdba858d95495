/*
 * scene_choose.c -- one muscle of many: which others a run of it needs, and others that go as an earlier run has left them.
 */
#include "sinew/scene.h"

#include <stdlib.h>
#include <string.h>

static bool takes_part(const sn_scene_muscle *muscle) { return muscle->enabled && !muscle->unbound; }

static bool names(const sn_scene_muscle *muscle, const char *target) {
    for (sn_index i = 0; i < muscle->rig.external_count && target != NULL; i++)
        if (muscle->rig.externals[i].count > 0 && strcmp(muscle->rig.externals[i].target, target) == 0) return true;
    return false;
}

/* Does one of them hold on to the other? */
static bool are_tied(const sn_scene *scene, sn_index i, sn_index k) {
    const sn_scene_muscle *a = &scene->muscles[i], *b = &scene->muscles[k];
    if (!scene->externals.enabled || !takes_part(a) || !takes_part(b)) return false;
    return names(a, b->name) || names(b, a->name);
}

/* Number of ties from what is wanted: SN_NONE = there is no way. */
static void count_ties(const sn_scene *scene, const bool *wanted, sn_index *ties, sn_index *queue) {
    sn_index begin = 0, end = 0;
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        ties[i] = wanted[i] ? 0 : SN_NONE;
        if (wanted[i]) queue[end++] = i;
    }
    for (; begin < end; begin++)
        for (sn_index k = 0; k < scene->muscle_count; k++)
            if (ties[k] == SN_NONE && are_tied(scene, queue[begin], k)) ties[k] = ties[queue[begin]] + 1, queue[end++] = k;
}

sn_status sn_scene_choose(const sn_scene *scene, const bool *wanted, bool nearest, bool *needed, sn_error *error) {
    sn_index count = scene->muscle_count, *ties = SN_NEW(sn_index, 2 * (size_t)count);
    if (ties == NULL) return sn_fail_memory(error, "the choice of muscles");
    count_ties(scene, wanted, ties, ties + count);
    for (sn_index i = 0; i < count; i++) needed[i] = ties[i] != SN_NONE && (!nearest || ties[i] <= 2);
    free(ties);
    return SN_OK;
}

/* Attached vertices farther than this share of the diagonal from where their bones take them went with another motion, rate or unit. */
static const double MOST_AWAY = 1e-3;

/* Where a rigid bone or joint is at that time; false: it is none. */
static bool pose_of(const sn_scene *scene, const char *bone, double time, sn_rigid *out) {
    sn_carrier carrier = sn_scene_carrier(scene, bone);
    sn_index joint = carrier.kind == SN_CARRIER_BONE ? scene->bones[carrier.index].joint : carrier.index;
    if (carrier.kind != SN_CARRIER_BONE && carrier.kind != SN_CARRIER_JOINT) return false;
    *out = joint == SN_NONE ? sn_rigid_identity() : sn_motion_run_in_pose(&scene->motion, joint, time, 1.0);
    return true;
}

/* How far the attached vertices are from where rigid bones take them at that time, m, the greatest. */
static double farthest_from_bones(const sn_scene *scene, const sn_scene_muscle *m, const sn_vertex_track *track, double time) {
    double farthest = 0.0;
    for (sn_index i = 0; i < m->rig.attachment_count; i++) {
        const sn_attachment *a = &m->rig.attachments[i];
        sn_rigid pose;
        if (!pose_of(scene, a->bone, time, &pose)) continue;
        for (sn_index k = 0; k < a->count; k++) {
            sn_vec3 rest = sn_scale(m->rig.mesh.positions[a->vertices[k]], m->rig.meters_per_unit);
            farthest = fmax(farthest, sn_distance(sn_rigid_apply(pose, rest), sn_vertex_track_at(track, time, a->vertices[k])));
        }
    }
    return farthest;
}

/* At the first frame, one half way, and the last: between two a track goes straight where bones turn. */
static sn_status check_bones(const sn_scene *scene, const sn_scene_muscle *m, const sn_vertex_track *track, sn_error *error) {
    double size = m->rig.meters_per_unit * sn_box_diagonal(sn_mesh_box(&m->rig.mesh));
    const sn_index frames[3] = {scene->first_frame, scene->first_frame + (scene->last_frame - scene->first_frame) / 2, scene->last_frame};
    for (int k = 0; k < 3; k++) {
        double time = frames[k] / scene->rate;
        double away = farthest_from_bones(scene, m, track, time);
        if (!(away <= MOST_AWAY * size))
            return sn_fail(
                error, SN_ERROR_INPUT,
                "muscle \"%s\": at %g s its frames have attached vertices %.3g mm from where its bones take them; they are of another "
                "motion, rate or unit",
                m->name, time, 1e3 * away);
    }
    return SN_OK;
}

sn_status sn_scene_freeze(sn_scene *scene, sn_index muscle, sn_vertex_track *track, sn_error *error) {
    sn_scene_muscle *m = &scene->muscles[muscle];
    double first = scene->first_frame / scene->rate, last = scene->last_frame / scene->rate, slack = 1e-6;
    if (track->sample_count < 1 || track->vertex_count != m->rig.mesh.vertex_count)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": its frames have %ld vertices, it has %ld", m->name, (long)track->vertex_count,
                       (long)m->rig.mesh.vertex_count);
    if (first < track->times[0] - slack || last > track->times[track->sample_count - 1] + slack)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": its frames are from %g s to %g s, the run from %g s to %g s", m->name,
                       track->times[0], track->times[track->sample_count - 1], first, last);
    sn_status status = check_bones(scene, m, track, error);
    if (status != SN_OK) return status;
    m->frozen = *track;
    *track = (sn_vertex_track){0};
    m->stiffness_internal = m->stiffness_dihedral = m->stiffness_volume = m->least_area = 0.0;
    m->untouched = m->unseen = true;
    return SN_OK;
}
