/* sense_sample.c -- a clip between its frames, along splines. */
#include <stdlib.h>
#include <string.h>

#include "sense.h"
#include "spline.h"

enum { PARTS = sizeof(sn_rigid) / sizeof(double) };

/* The numbers that a pose is made of. */
static double part_of(const sn_rigid *pose, int part) { return ((const double *)pose)[part]; }
static void set_part(sn_rigid *pose, int part, double value) { ((double *)pose)[part] = value; }

/* How the samples come from coefficients: the same for every joint. */
typedef struct sampling {
    const sn_clip *clip;
    sn_spline spline;
    sn_index count;  /* of samples */
    sn_index *first; /* (count) */
    double *weights; /* (count) x SN_SPLINE_MOST */
    sn_rigid *local; /* (frames) */
    double *values;  /* (frames) */
} sampling;

static sn_status prepare(const sn_clip *clip, double rate, sn_index count, sampling *s, sn_error *error) {
    *s = (sampling){.clip = clip, .count = count};
    s->first = SN_NEW(sn_index, count);
    s->weights = sn_alloc((size_t)count * SN_SPLINE_MOST, sizeof(double));
    s->local = SN_NEW(sn_rigid, clip->frame_count);
    s->values = SN_NEW(double, clip->frame_count);
    if (s->first == NULL || s->weights == NULL || s->local == NULL || s->values == NULL) return sn_fail_memory(error, "a motion's samples");
    sn_status status = sn_spline_create(clip->frame_count, &s->spline, error);
    for (sn_index k = 0; k < count && status == SN_OK; k++) {
        double frame = k * clip->rate / rate;
        sn_spline_weights(&s->spline, frame, &s->first[k], s->weights + (size_t)k * SN_SPLINE_MOST);
    }
    return status;
}

static void release(sampling *s) {
    sn_spline_free(&s->spline);
    free(s->first);
    free(s->weights);
    free(s->local);
    free(s->values);
}

/* Away from rest in the parent's frame, and how far the centre has moved there, as sn_clip_to_local has it; on one hemisphere. */
static void take_local(const sn_clip *clip, sn_index j, sn_rigid *local) {
    const sn_clip_joint *joint = &clip->joints[j];
    const sn_rigid *parent = joint->parent != SN_NONE ? clip->joints[joint->parent].poses : NULL;
    for (sn_index f = 0; f < clip->frame_count; f++) {
        sn_rigid pose = joint->poses[f];
        if (parent != NULL) pose = sn_rigid_compose(sn_rigid_inverse(parent[f]), pose);
        pose.translation = sn_sub(sn_rigid_apply(pose, joint->rest), joint->rest);
        sn_quat q = pose.rotation;
        if (f > 0 && sn_quat_dot(local[f - 1].rotation, q) < 0.0) pose.rotation = (sn_quat){-q.w, -q.x, -q.y, -q.z};
        local[f] = pose;
    }
}

/* One of a pose's numbers. */
static void sample_part(sampling *s, int part, sn_rigid *out) {
    for (sn_index f = 0; f < s->clip->frame_count; f++) s->values[f] = part_of(&s->local[f], part);
    sn_spline_solve(&s->spline, s->values);
    for (sn_index k = 0; k < s->count; k++) {
        const double *weights = s->weights + (size_t)k * SN_SPLINE_MOST;
        double sum = 0.0;
        for (int i = 0; i <= s->spline.degree; i++) sum += weights[i] * s->values[s->first[k] + i];
        set_part(&out[k], part, sum);
    }
}

static sn_status sample_joint(sampling *s, sn_index j, sn_clip_joint *out, sn_error *error) {
    const sn_clip_joint *joint = &s->clip->joints[j];
    take_local(s->clip, j, s->local);
    for (int part = 0; part < PARTS; part++) sample_part(s, part, out->poses);
    for (sn_index k = 0; k < s->count; k++) out->poses[k].rotation = sn_quat_normalize(out->poses[k].rotation);
    out->parent = joint->parent;
    out->rest = joint->rest;
    out->placeless = joint->placeless;
    out->rest_rotation = joint->rest_rotation;
    out->has_end = joint->has_end;
    out->end = joint->end;
    out->name = sn_strdup(joint->name);
    return out->name != NULL ? SN_OK : sn_fail_memory(error, "a name");
}

/* ---- beyond the ends ------------------------------------------------------------------------------------------------------------------
 */

/* The pose before those at near, near + step, ... (count), on a polynomial through five of them; no spline of noise goes astray so soon. */
static sn_rigid pose_before(const sn_rigid *near, sn_index step, sn_index count) {
    static const double weights[5][5] = {{1}, {2, -1}, {3, -3, 1}, {4, -6, 4, -1}, {5, -10, 10, -5, 1}};
    int last = count < 5 ? (int)count - 1 : 4;
    sn_rigid out = sn_rigid_identity();
    for (int part = 0; part < PARTS; part++) {
        double sum = 0.0;
        for (int i = 0; i <= last; i++) sum += weights[last][i] * part_of(&near[i * step], part);
        set_part(&out, part, sum);
    }
    out.rotation = sn_quat_normalize(out.rotation);
    return out;
}

sn_status sn_sense_pad(sn_clip *clip, sn_error *error) {
    sn_index count = clip->frame_count, whole = count + 2 * SN_SENSE_PADDING;
    for (sn_index j = 0; j < clip->joint_count; j++) {
        sn_rigid *poses = sn_realloc(clip->joints[j].poses, (size_t)whole, sizeof *poses);
        if (poses == NULL) return sn_fail_memory(error, "a motion's samples");
        clip->joints[j].poses = poses;
        memmove(poses + SN_SENSE_PADDING, poses, (size_t)count * sizeof *poses);
        for (sn_index k = 1; k <= SN_SENSE_PADDING; k++) {
            sn_index first = SN_SENSE_PADDING - k, last = SN_SENSE_PADDING + count - 1 + k;
            poses[first] = pose_before(&poses[first + 1], 1, count);
            poses[last] = pose_before(&poses[last - 1], -1, count);
        }
    }
    clip->frame_count = whole;
    return SN_OK;
}

sn_status sn_sense_sample(const sn_clip *clip, double rate, sn_index count, sn_clip *out, sn_error *error) {
    sampling s;
    *out = (sn_clip){0};
    sn_status status = prepare(clip, rate, count, &s, error);
    if (status == SN_OK) status = sn_clip_create(count, clip->joint_count, 0, out, error);
    out->rate = rate;
    for (sn_index j = 0; j < clip->joint_count && status == SN_OK; j++) status = sample_joint(&s, j, &out->joints[j], error);
    if (status == SN_OK) sn_clip_to_world(out);
    if (status != SN_OK) sn_clip_free(out);
    release(&s);
    return status;
}
