/*
 * clip_filter.c -- a low-pass without lag, and another rate, for rotations, shifts and coordinates of a clip.
 *
 * Both work on poses in the parents' frames (sn_clip_to_local): there a joint that only turns has no shift, and keeps none.
 */
#include "sinew/motion_clip.h"

#include <stdlib.h>

/* A filtered quaternion shorter than this says nothing of a direction: the frame keeps its own. */
static const double SHORTEST_QUATERNION = 1e-3;
/* What lies beyond an end must last until the start of the filter is forgotten: to 1e-6 of it after this many periods of the cutoff (its
 * slowest pole decays by exp(-0.383 w t)); 4 periods leave 1e-4 of it. A cutoff that asks for more samples than the limit is refused. */
static const double PERIODS_OF_PADDING = 6.0, LEAST_PERIODS = 4.0, MOST_PADDING = 1e5;

/* ---- continuity -------------------------------------------------------------------------------------------------------------- */

static sn_quat negate(sn_quat q) { return (sn_quat){-q.w, -q.x, -q.y, -q.z}; }

/* q and -q are one rotation: of the two the nearer to the frame before. */
static void keep_hemisphere(sn_rigid *local, sn_index count) {
    for (sn_index f = 1; f < count; f++)
        if (sn_quat_dot(local[f - 1].rotation, local[f].rotation) < 0.0) local[f].rotation = negate(local[f].rotation);
}

/* An angle goes on where it turns over. */
static void unwrap(double *values, sn_index count) {
    for (sn_index f = 1; f < count; f++) values[f] += 2.0 * SN_PI * floor((values[f - 1] - values[f]) / (2.0 * SN_PI) + 0.5);
}

static bool is_angle(const sn_clip_coordinate *coordinate) { return coordinate->unit[0] == 'r'; }

static bool rotation_jumps(const sn_rigid *local, sn_index f, double least_cosine) {
    return fabs(sn_quat_dot(local[f - 1].rotation, local[f].rotation)) <= least_cosine;
}

static bool angle_jumps(const double *values, sn_index f) { return fabs(values[f] - values[f - 1]) > SN_CLIP_JUMP; }

/* ---- the filter -------------------------------------------------------------------------------------------------------------- */

typedef struct biquad {
    double b0, b1, b2, a1, a2;
} biquad;

typedef struct low_pass {
    biquad stages[2];
    sn_index padding; /* samples beyond each end */
    double *buffer;   /* (2 padding + frame_count) */
} low_pass;

/* Butterworth's poles of order 4 lie at pi/8 and 3 pi/8 from the real axis; bilinear transform of the cutoff k = tan(pi f / rate). */
static biquad design_stage(double k, double pole) {
    double damped = 2.0 * sn_cos(pole) * k, scale = 1.0 / (1.0 + damped + k * k);
    return (biquad){k * k * scale, 2.0 * k * k * scale, k * k * scale, 2.0 * (k * k - 1.0) * scale, (1.0 - damped + k * k) * scale};
}

/* Two passes have 1/(1 + (w/w_c)^8): 1/sqrt 2 at w where w_c is w / (sqrt 2 - 1)^(1/8). */
static sn_status design(const sn_clip *clip, double cutoff, low_pass *out, sn_error *error) {
    double k = sn_tan(SN_PI * cutoff / clip->rate) / sqrt(sqrt(sqrt(sqrt(2.0) - 1.0)));
    if (LEAST_PERIODS * clip->rate / cutoff > MOST_PADDING)
        return sn_fail(error, SN_ERROR_INPUT, "a filter of %g Hz is too low for %g samples a second: choose %.2g Hz or more, or 0 for none",
                       cutoff, clip->rate, 1.01 * LEAST_PERIODS * clip->rate / MOST_PADDING);
    double padding = fmin(PERIODS_OF_PADDING * clip->rate / cutoff, MOST_PADDING);
    *out = (low_pass){.stages = {design_stage(k, SN_PI / 8.0), design_stage(k, 3.0 * SN_PI / 8.0)}, .padding = (sn_index)ceil(padding)};
    out->buffer = SN_NEW(double, (size_t)clip->frame_count + 2 * (size_t)out->padding);
    return out->buffer != NULL ? SN_OK : sn_fail_memory(error, "a filter");
}

/* One pass over values in the order that step (1 or -1) says, begun as if the first value had always been there. */
static void pass(const biquad *s, double *values, sn_index count, sn_index step) {
    double *x = step > 0 ? values : values + count - 1;
    double z1 = (1.0 - s->b0) * *x, z2 = (s->b2 - s->a2) * *x;
    for (sn_index i = 0; i < count; i++, x += step) {
        double y = s->b0 * *x + z1;
        z1 = s->b1 * *x - s->a1 * y + z2;
        z2 = s->b2 * *x - s->a2 * y;
        *x = y;
    }
}

/* Sample i >= 0 of values (last + 1), 0 at both ends, that go on as their point reflection: odd about each end, of period 2 last. */
static double reflected(const double *values, sn_index last, sn_index i) {
    sn_index at = i % (2 * last);
    return at > last ? -values[2 * last - at] : values[at];
}

/*
 * Filter count samples that lie stride doubles apart. The straight line from the first to the last goes through any such filter: what is
 * left without it is 0 at both ends, and goes on beyond each as its point reflection, again and again. So the ends keep their values.
 */
static void smooth(const low_pass *filter, double *samples, sn_index count, sn_index stride) {
    if (count < 3) return;
    const sn_index last = count - 1, whole = count + 2 * filter->padding;
    double *inside = filter->buffer + filter->padding, first = samples[0], slope = (samples[(size_t)last * (size_t)stride] - first) / last;
    for (sn_index i = 1; i < last; i++) inside[i] = samples[(size_t)i * (size_t)stride] - (first + slope * i);
    inside[0] = inside[last] = 0.0;
    for (sn_index i = 1; i <= filter->padding; i++) {
        inside[-i] = -reflected(inside, last, i);
        inside[last + i] = reflected(inside, last, last + i);
    }
    for (int direction = 1; direction >= -1; direction -= 2)
        for (int s = 0; s < 2; s++) pass(&filter->stages[s], filter->buffer, whole, direction);
    for (sn_index i = 1; i < last; i++) samples[(size_t)i * (size_t)stride] = inside[i] + (first + slope * i);
}

/* count poses without a jump; old (count) holds their rotations. */
static void smooth_piece(const low_pass *filter, sn_rigid *local, sn_index count, const sn_quat *old) {
    enum { STRIDE = sizeof(sn_rigid) / sizeof(double) };
    double *first = &local->rotation.w;
    for (int k = 0; k < STRIDE; k++) smooth(filter, first + k, count, STRIDE);
    for (sn_index f = 0; f < count; f++) {
        bool lost = !(sn_quat_dot(local[f].rotation, local[f].rotation) > SHORTEST_QUATERNION * SHORTEST_QUATERNION);
        local[f].rotation = sn_quat_normalize(lost ? old[f] : local[f].rotation);
    }
}

static void smooth_joint(const low_pass *filter, sn_rigid *local, sn_index count, sn_quat *old) {
    const double least = sn_cos(0.5 * SN_CLIP_JUMP);
    keep_hemisphere(local, count);
    for (sn_index f = 0; f < count; f++) old[f] = local[f].rotation;
    for (sn_index begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count; end++) { /* jumps are those of the old rotations */
            if (rotation_jumps(local, end, least)) break;
        }
        smooth_piece(filter, local + begin, end - begin, old + begin);
    }
}

static void smooth_coordinate(const low_pass *filter, sn_clip_coordinate *coordinate, sn_index count) {
    bool angle = is_angle(coordinate);
    double *values = coordinate->values;
    if (angle) unwrap(values, count);
    for (sn_index begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count; end++)
            if (angle && angle_jumps(values, end)) break;
        smooth(filter, values + begin, end - begin, 1);
    }
}

/* true = the trace stops here. */
static bool smooth_all(const low_pass *filter, sn_clip *clip, sn_quat *old, sn_trace *trace) {
    for (sn_index j = 0; j < clip->joint_count; j++) {
        if (sn_trace_stopped(trace)) return true;
        smooth_joint(filter, clip->joints[j].poses, clip->frame_count, old);
        if (SN_TRACE(trace, "filter", sn_trace_text("joint", clip->joints[j].name))) return true;
    }
    for (sn_index c = 0; c < clip->coordinate_count; c++) smooth_coordinate(filter, &clip->coordinates[c], clip->frame_count);
    return SN_TRACE(trace, "filter", sn_trace_number("coordinates", clip->coordinate_count));
}

sn_status sn_clip_filter(sn_clip *clip, double cutoff, sn_trace *trace, sn_error *error) {
    low_pass filter = {0};
    if (!(cutoff > 0.0 && cutoff < 0.5 * clip->rate))
        return sn_fail(error, SN_ERROR_USAGE, "a cutoff of %g Hz is not below %g Hz, half of the rate", cutoff, 0.5 * clip->rate);
    sn_quat *old = SN_NEW(sn_quat, clip->frame_count);
    sn_status status = old != NULL ? design(clip, cutoff, &filter, error) : sn_fail_memory(error, "a filter");
    if (status == SN_OK) {
        sn_clip_to_local(clip);
        if (smooth_all(&filter, clip, old, trace)) status = SN_STOPPED;
        sn_clip_to_world(clip);
    }
    free(filter.buffer);
    free(old);
    return status;
}

/* ---- another rate --------------------------------------------------------------------------------------------------------------- */

/* Where a new frame lies between two old ones: from `frame`, `share` of the way to the next. */
typedef struct place {
    sn_index frame;
    double share;
} place;

/* Times that differ by rounding alone are the same. */
static const double SAME_TIME = 1e-9;

static place place_of(sn_index frame, double step, sn_index count) {
    double at = frame * step, low = floor(at + SAME_TIME);
    if (low >= count - 1) return (place){count - 1, 0.0};
    return (place){(sn_index)low, at - low > SAME_TIME ? at - low : 0.0};
}

static void resample_joint(const sn_rigid *from, sn_index count, double step, sn_rigid *to, sn_index new_count) {
    const double least = sn_cos(0.5 * SN_CLIP_JUMP);
    for (sn_index f = 0; f < new_count; f++) {
        place p = place_of(f, step, count);
        const sn_rigid *a = &from[p.frame], *b = a + (p.share > 0.0);
        if (p.share > 0.0 && rotation_jumps(from, p.frame + 1, least))
            to[f] = p.share < 0.5 ? *a : *b;
        else if (p.share > 0.0)
            to[f] = (sn_rigid){sn_quat_slerp(a->rotation, b->rotation, p.share), sn_lerp(a->translation, b->translation, p.share)};
        else
            to[f] = *a;
    }
}

static void resample_coordinate(const sn_clip_coordinate *from, sn_index count, double step, double *to, sn_index new_count) {
    const double *v = from->values;
    for (sn_index f = 0; f < new_count; f++) {
        place p = place_of(f, step, count);
        if (p.share > 0.0 && is_angle(from) && angle_jumps(v, p.frame + 1))
            to[f] = v[p.frame + (p.share >= 0.5)];
        else
            to[f] = p.share > 0.0 ? v[p.frame] + p.share * (v[p.frame + 1] - v[p.frame]) : v[p.frame];
    }
}

/* The frames of `with` in clip, and the old ones in `with`. */
static void swap_frames(sn_clip *clip, sn_clip *with) {
    for (sn_index j = 0; j < clip->joint_count; j++) {
        sn_rigid *poses = clip->joints[j].poses;
        clip->joints[j].poses = with->joints[j].poses;
        with->joints[j].poses = poses;
    }
    for (sn_index c = 0; c < clip->coordinate_count; c++) {
        double *values = clip->coordinates[c].values;
        clip->coordinates[c].values = with->coordinates[c].values;
        with->coordinates[c].values = values;
    }
    clip->frame_count = with->frame_count;
}

sn_status sn_clip_resample(sn_clip *clip, double rate, sn_error *error) {
    double frames = floor((clip->frame_count - 1) * (rate / clip->rate) + SAME_TIME) + 1.0, step = clip->rate / rate;
    sn_clip other;
    if (!(rate > 0.0) || !(frames < SN_INDEX_MAX / 2))
        return sn_fail(error, SN_ERROR_USAGE, "at %g Hz the motion would have %g frames", rate, frames);
    sn_status status = sn_clip_create((sn_index)frames, clip->joint_count, clip->coordinate_count, &other, error);
    if (status != SN_OK) return status;
    sn_clip_to_local(clip);
    for (sn_index j = 0; j < clip->joint_count; j++)
        resample_joint(clip->joints[j].poses, clip->frame_count, step, other.joints[j].poses, other.frame_count);
    for (sn_index c = 0; c < clip->coordinate_count; c++) {
        if (is_angle(&clip->coordinates[c])) unwrap(clip->coordinates[c].values, clip->frame_count);
        resample_coordinate(&clip->coordinates[c], clip->frame_count, step, other.coordinates[c].values, other.frame_count);
    }
    swap_frames(clip, &other);
    clip->rate = rate;
    sn_clip_to_world(clip);
    sn_clip_free(&other);
    return SN_OK;
}
