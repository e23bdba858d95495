/*
 * fit.c -- the motion of a source on the joints of a body.
 */
#include <stdlib.h>
#include <string.h>

#include "fit_align.h"

static sn_status find_sources(const sn_fit_body *body, const sn_clip *source, sn_fit_result *out, sn_error *error) {
    const sn_fit_table *table = body->table;
    for (sn_index p = 0; p < table->point_count; p++) {
        const sn_fit_point *point = &table->points[p];
        bool end = false, joint = p < table->joint_count;
        sn_index found = point->source != NULL ? sn_fit_find_source(source, point->source, &end) : SN_NONE;
        if (point->source != NULL && (found == SN_NONE || (joint && end)))
            return sn_fail_at(error, SN_ERROR_INPUT, table->name, point->line,
                              "\"%s\": the motion has no joint \"%s\"%s; motion-import --list tells its joints", point->name, point->source,
                              end ? " but only its end" : "");
        if (found != SN_NONE && !end && source->joints[found].placeless)
            return sn_fail_at(
                error, SN_ERROR_INPUT, table->name, point->line,
                "\"%s\": the motion does not tell where its joint \"%s\" is at rest (\"rest\"), without which nothing can be fitted",
                point->name, source->joints[found].name);
        if (joint) out->sources[p] = found;
    }
    return SN_OK;
}

static sn_quat local_turn(const sn_clip *clip, sn_index j, sn_index f) {
    sn_index parent = clip->joints[j].parent;
    sn_quat q = clip->joints[j].poses[f].rotation;
    return parent == SN_NONE ? q : sn_quat_multiply(sn_quat_conjugate(clip->joints[parent].poses[f].rotation), q);
}

sn_status sn_fit_idle_sources(const sn_fit_result *result, const sn_clip *source, bool *out, sn_error *error) {
    static const double STILL = 3.8e-5; /* 1 - cos of half a degree: a turn of one */
    bool *drives = SN_NEW(bool, source->joint_count);
    if (drives == NULL) return sn_fail_memory(error, "the joints");
    for (sn_index j = 0; j < result->clip.joint_count; j++)
        if (result->sources[j] != SN_NONE) drives[result->sources[j]] = true;
    for (sn_index j = 0; j < source->joint_count; j++) {
        out[j] = false;
        sn_quat first = local_turn(source, j, 0);
        for (sn_index f = 0; f < source->frame_count && !out[j] && !drives[j]; f++)
            out[j] = fabs(sn_quat_dot(first, local_turn(source, j, f))) < 1.0 - STILL;
    }
    free(drives);
    return SN_OK;
}

/* ---- the clip -------------------------------------------------------------------------------------------------------------------------
 */

static sn_status copy_coordinates(const sn_clip *source, sn_clip *out, sn_error *error) {
    for (sn_index c = 0; c < source->coordinate_count; c++) {
        out->coordinates[c].name = sn_strdup(source->coordinates[c].name);
        out->coordinates[c].unit = sn_strdup(source->coordinates[c].unit);
        if (out->coordinates[c].name == NULL || out->coordinates[c].unit == NULL) return sn_fail_memory(error, "a coordinate");
        memcpy(out->coordinates[c].values, source->coordinates[c].values, (size_t)source->frame_count * sizeof(double));
    }
    return SN_OK;
}

static sn_status add_bones(const sn_fit_body *body, sn_clip *out, sn_error *error) {
    out->bones = SN_NEW(sn_motion_bone, body->bone_count);
    if (out->bones == NULL) return sn_fail_memory(error, "the bones");
    for (sn_index b = 0; b < body->bone_count; b++) {
        const sn_fit_bone *bone = &body->bones[b];
        if (bone->joint == SN_NONE) continue;
        sn_motion_bone *to = &out->bones[out->bone_count++];
        *to = (sn_motion_bone){
            .name = sn_strdup(bone->name), .path = sn_strdup(bone->path), .meters_per_unit = bone->meters_per_unit, .joint = bone->joint};
        if (to->name == NULL || to->path == NULL) return sn_fail_memory(error, "the bones");
    }
    return SN_OK;
}

static sn_status name_joints(const sn_fit_body *body, const sn_clip *source, sn_fit_result *out, sn_error *error) {
    const sn_fit_table *table = body->table;
    for (sn_index j = 0; j < table->joint_count; j++) {
        const sn_fit_joint *from = &table->joints[j];
        sn_clip_joint *to = &out->clip.joints[j];
        to->name = sn_strdup(table->points[j].name);
        if (to->name == NULL) return sn_fail_memory(error, "a name");
        to->parent = from->parent;
        to->rest = body->places[j].centre;
        if (out->sources[j] != SN_NONE)
            to->rest_rotation = sn_quat_normalize(sn_quat_multiply(out->alignment[j], source->joints[out->sources[j]].rest_rotation));
        to->has_end = from->along.given && !from->along.level && from->along.from == j && from->along.to >= table->joint_count;
        if (to->has_end) to->end = body->places[from->along.to].centre;
    }
    return SN_OK;
}

static sn_status start_clip(const sn_fit_body *body, const sn_clip *source, sn_fit_result *out, sn_error *error) {
    sn_clip *clip = &out->clip;
    sn_status status = sn_clip_create(source->frame_count, body->table->joint_count, source->coordinate_count, clip, error);
    if (status != SN_OK) return status;
    clip->rate = source->rate;
    clip->format = source->format;
    clip->meters_per_unit_of_source = source->meters_per_unit_of_source;
    clip->name = sn_strdup(source->name);
    if (source->name != NULL && clip->name == NULL) return sn_fail_memory(error, "a name");
    status = copy_coordinates(source, clip, error);
    if (status == SN_OK) status = add_bones(body, clip, error);
    return status == SN_OK ? name_joints(body, source, out, error) : status;
}

/* ---- the fit ----------------------------------------------------------------------------------------------------------------------------
 */

static sn_status align(const sn_fit_body *body, const sn_clip *source, bool aligned, sn_fit_result *out, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index j = 0; j < body->table->joint_count && status == SN_OK; j++) {
        sn_index parent = body->table->joints[j].parent;
        sn_quat start = parent != SN_NONE ? out->alignment[parent] : sn_quat_identity();
        out->alignment[j] = start;
        if (aligned) status = sn_fit_align_joint(body, source, j, start, &out->alignment[j], error);
    }
    return status;
}

static void measure_legs(const sn_fit_body *body, const sn_clip *source, sn_fit_result *out) {
    const sn_fit_table *table = body->table;
    for (sn_index l = 0; l < table->leg_count; l++)
        for (int k = 0; k < 2; k++) {
            sn_index a = table->legs[l].joints[k], b = table->legs[l].joints[k + 1];
            out->leg += sn_distance(body->places[a].centre, body->places[b].centre) / table->leg_count;
            out->source_leg += sn_distance(source->joints[out->sources[a]].rest, source->joints[out->sources[b]].rest) / table->leg_count;
        }
}

static sn_status choose_scale(const sn_fit_body *body, const sn_clip *source, double scale, sn_fit_result *out, sn_error *error) {
    measure_legs(body, source, out);
    out->scale = scale > 0.0 ? scale : out->source_leg > 0.0 ? out->leg / out->source_leg : 1.0;
    if (scale > 0.0 || body->table->leg_count == 0 || (out->leg > 0.0 && out->source_leg > 0.0)) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, body->table->name, body->table->legs[0].line, "the legs have no length %s; give --scale",
                      out->leg > 0.0 ? "in the source" : "on the body");
}

/* Where the middle of the hips is in frame f; the root where the table names no leg. */
static sn_vec3 anchor(const sn_fit_table *table, const sn_clip *clip, const sn_index *sources, sn_index f) {
    sn_vec3 sum = {0, 0, 0};
    sn_index count = table->leg_count > 0 ? table->leg_count : 1;
    for (sn_index l = 0; l < count; l++) {
        sn_index j = table->leg_count > 0 ? table->legs[l].joints[0] : 0;
        const sn_clip_joint *joint = &clip->joints[sources != NULL ? sources[j] : j];
        sum = sn_add_scaled(sum, sn_rigid_apply(joint->poses[f], joint->rest), 1.0 / count);
    }
    return sum;
}

/* Frame f with the root at its rest place: rotations of the source, centres carried by the body's parents. */
static void turn_joints(const sn_clip *source, sn_fit_result *out, sn_index f) {
    for (sn_index j = 0; j < out->clip.joint_count; j++) {
        sn_clip_joint *joint = &out->clip.joints[j];
        const sn_rigid *parent = joint->parent != SN_NONE ? &out->clip.joints[joint->parent].poses[f] : NULL;
        sn_quat turn = out->sources[j] != SN_NONE
                           ? sn_quat_multiply(source->joints[out->sources[j]].poses[f].rotation, sn_quat_conjugate(out->alignment[j]))
                           : parent->rotation;
        sn_vec3 centre = parent != NULL ? sn_rigid_apply(*parent, joint->rest) : joint->rest;
        turn = sn_quat_normalize(turn);
        joint->poses[f] = (sn_rigid){turn, sn_sub(centre, sn_quat_rotate(turn, joint->rest))};
    }
}

static void shift_frame(sn_clip *clip, sn_index f, sn_vec3 by) {
    for (sn_index j = 0; j < clip->joint_count; j++)
        clip->joints[j].poses[f].translation = sn_add(clip->joints[j].poses[f].translation, by);
}

static void pose(const sn_fit_body *body, const sn_clip *source, sn_fit_result *out) {
    for (sn_index f = 0; f < source->frame_count; f++) {
        turn_joints(source, out, f);
        sn_vec3 goal = sn_scale(anchor(body->table, source, out->sources, f), out->scale);
        shift_frame(&out->clip, f, sn_sub(goal, anchor(body->table, &out->clip, NULL, f)));
    }
}

sn_status sn_motion_fit(const sn_fit_body *body, const sn_clip *source, const sn_fit_params *params, sn_fit_result *out, sn_error *error) {
    sn_index count = body->table->joint_count;
    *out = (sn_fit_result){.sources = SN_NEW(sn_index, count), .alignment = SN_NEW(sn_quat, count)};
    sn_status status = out->sources != NULL && out->alignment != NULL ? SN_OK : sn_fail_memory(error, "the fit");
    if (status == SN_OK) status = find_sources(body, source, out, error);
    if (status == SN_OK) status = align(body, source, params->align, out, error);
    if (status == SN_OK) status = choose_scale(body, source, params->scale, out, error);
    if (status == SN_OK) status = start_clip(body, source, out, error);
    if (status == SN_OK) pose(body, source, out);
    if (status == SN_OK && params->ground) status = sn_fit_put_on_floor(body, source, out, error);
    if (status == SN_OK) status = sn_clip_validate(&out->clip, error);
    if (status != SN_OK) sn_fit_result_free(out);
    return status;
}

void sn_fit_result_free(sn_fit_result *result) {
    sn_clip_free(&result->clip);
    free(result->sources);
    free(result->alignment);
    *result = (sn_fit_result){0};
}

/* ---- angles ----------------------------------------------------------------------------------------------------------------------------
 */

sn_fit_range sn_fit_joint_range(const sn_clip *fitted, sn_index joint) {
    sn_fit_range range;
    for (int k = 0; k < 4; k++) {
        range.low[k] = INFINITY;
        range.high[k] = -INFINITY;
    }
    for (sn_index f = 0; f < fitted->frame_count; f++) {
        sn_quat q = local_turn(fitted, joint, f);
        sn_vec3 axis = q.w < 0.0 ? sn_v3(-q.x, -q.y, -q.z) : sn_v3(q.x, q.y, q.z);
        double angle = 2.0 * sn_quick_atan2(sn_norm(axis), fabs(q.w));
        axis = sn_scale(sn_normalize(axis), angle);
        const double values[4] = {angle, axis.x, axis.y, axis.z};
        for (int k = 0; k < 4; k++) {
            range.low[k] = fmin(range.low[k], values[k]);
            range.high[k] = fmax(range.high[k], values[k]);
        }
    }
    return range;
}
