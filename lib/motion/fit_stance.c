/*
 * fit_stance.c -- where a foot touches the ground, and in which frames it stands, by the source.
 */
#include "fit_align.h"

/* ---- contacts ----------------------------------------------------------------------------------------------------------------------- */

static void lower(const sn_mesh *mesh, sn_rigid pose, sn_index bone, sn_fit_contact *out) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 p = sn_rigid_apply(pose, mesh->positions[v]);
        if (out->bone == SN_NONE || p.z < out->at.z) *out = (sn_fit_contact){p, bone, v};
    }
}

bool sn_fit_contacts(const sn_fit_body *body, const sn_clip *fitted, sn_index top, sn_fit_contact *out) {
    for (sn_index f = 0; f < fitted->frame_count; f++) out[f].bone = SN_NONE;
    for (sn_index b = 0; b < body->bone_count; b++) {
        const sn_fit_bone *bone = &body->bones[b];
        if (bone->joint == SN_NONE || !sn_fit_below(body->table, bone->joint, top)) continue;
        for (sn_index f = 0; f < fitted->frame_count; f++) lower(bone->mesh, fitted->joints[bone->joint].poses[f], b, &out[f]);
    }
    return out[0].bone != SN_NONE;
}

/* ---- standing ----------------------------------------------------------------------------------------------------------------------- */

sn_vec3 sn_fit_source_step(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, sn_index top, sn_index f) {
    double lowest = INFINITY;
    sn_vec3 step = {0, 0, 0};
    for (sn_index j = 0; j < body->table->joint_count; j++) {
        if (fit->sources[j] == SN_NONE || !sn_fit_below(body->table, j, top)) continue;
        const sn_clip_joint *joint = &source->joints[fit->sources[j]];
        for (int k = 0; k < 1 + joint->has_end; k++) {
            sn_vec3 rest = k == 0 ? joint->rest : joint->end, now = sn_rigid_apply(joint->poses[f], rest);
            if (!(now.z < lowest)) continue;
            lowest = now.z;
            step = sn_sub(sn_rigid_apply(joint->poses[f + 1], rest), now);
        }
    }
    return step;
}

/* A foot that goes on for less than this long between two stops has not left the ground: a capture jitters. Seconds. */
static const double SHORTEST_LEAVE = 0.05;

static void bridge(bool *stands, sn_index count, double most) {
    sn_index last = SN_NONE;
    for (sn_index f = 0; f < count; f++) {
        if (!stands[f]) continue;
        if (last != SN_NONE && f - last - 1 <= most)
            for (sn_index k = last + 1; k < f; k++) stands[k] = true;
        last = f;
    }
}

void sn_fit_stands(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, sn_index top, double speed, bool *out) {
    sn_index last = source->frame_count - 1;
    for (sn_index f = 0; f < last; f++) out[f] = sn_norm(sn_fit_source_step(body, fit, source, top, f)) * source->rate <= speed;
    out[last] = last > 0 ? out[last - 1] : true;
    bridge(out, last + 1, SHORTEST_LEAVE * source->rate);
}
