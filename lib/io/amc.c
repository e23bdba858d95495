/*
 * amc.c -- Acclaim's motion file: frames of angles for the bones of a skeleton (asf.c).
 *
 * A frame is its number on a line, then a line for each bone that moves: its name and a number for each of its degrees of freedom.
 */
#include <stdlib.h>
#include <string.h>

#include "asf.h"

/* The format has no word for it that all files use; the data of Carnegie Mellon, most of what there is, are taken at 120 Hz. */
static const double USUAL_RATE = 120.0;

typedef struct amc {
    sn_reader reader;
    const sn_asf *asf;
    bool complete;   /* :FULLY-SPECIFIED: every bone stands in every frame; else one that does not keeps its place */
    double angle;    /* radians per unit */
    double meters;   /* per unit of length */
    double rate;     /* 0 = not said */
    sn_index *first; /* (bones) coordinate */
    sn_index *seen;  /* (bones) the last frame that told the bone, from 1 */
    int64_t beyond;  /* angles outside of their limits */
} amc;

/* ---- frames ---------------------------------------------------------------------------------------------------------------------------
 */

/* A number alone on its line begins a frame. */
static bool at_frame(sn_reader reader, int64_t *number) { return sn_reader_integer(&reader, number) && sn_reader_at_line_end(&reader); }

static int64_t count_frames(sn_reader reader) {
    int64_t count = 0, number;
    while (sn_reader_find_line(&reader)) {
        count += at_frame(reader, &number);
        sn_reader_rest(&reader);
    }
    return count;
}

static sn_status read_head(amc *a) {
    sn_reader *r = &a->reader;
    while (sn_reader_find_line(r) && *r->at == ':') {
        sn_span word = sn_reader_word(r);
        if (sn_span_is_like(word, ":FULLY-SPECIFIED")) a->complete = true;
        if (sn_span_is_like(word, ":DEGREES")) a->angle = SN_DEGREE;
        if (sn_span_is_like(word, ":RADIANS")) a->angle = 1.0;
        if (sn_span_is_like(word, ":SAMPLES-PER-SECOND")) {
            sn_status status = sn_clip_number(r, "the frames of a second", &a->rate);
            if (status != SN_OK) return status;
            if (!(a->rate >= 1e-6 && a->rate <= 1e6))
                return sn_reader_fail(r, SN_NONE, "%g frames a second are not within 1e-6 to 1e6", a->rate);
        }
        sn_reader_rest(r);
    }
    return SN_OK;
}

static sn_status read_values(amc *a, const sn_asf_bone *bone, sn_index frame, sn_clip_coordinate *coordinates) {
    sn_reader *r = &a->reader;
    for (int k = 0; k < bone->freedom_count; k++) {
        bool turns = bone->freedoms[k] >= 3;
        double value = 0.0;
        if (sn_reader_at_line_end(r))
            return sn_reader_fail(r, frame, "'%.80s' has %d numbers; its degrees of freedom are %d", bone->name, k, bone->freedom_count);
        sn_status status = sn_clip_number(r, "an angle or a length", &value);
        if (status != SN_OK) return status;
        value *= turns ? a->angle : a->meters;
        coordinates[k].values[frame] = value;
        double unit = turns ? a->asf->angle : a->meters, slack = 1e-6;
        a->beyond += bone->limited && (value < bone->limits[k][0] * unit - slack || value > bone->limits[k][1] * unit + slack);
    }
    if (!sn_reader_at_line_end(r))
        return sn_reader_fail(r, frame, "'%.80s' has more numbers than its %d degrees of freedom", bone->name, bone->freedom_count);
    return SN_OK;
}

static sn_status read_bone_line(amc *a, sn_index frame, sn_clip *clip) {
    sn_span word = sn_reader_word(&a->reader);
    sn_index bone = sn_asf_find(a->asf, word);
    if (bone == SN_NONE)
        return sn_reader_fail(&a->reader, frame, "the skeleton has no bone '%.*s'; is it another capture's?",
                              (int)(word.length < 40 ? word.length : 40), word.text);
    if (a->seen[bone] == frame + 1)
        return sn_reader_fail(&a->reader, frame, "'%.80s' stands twice in this frame", a->asf->bones[bone].name);
    a->seen[bone] = frame + 1;
    return read_values(a, &a->asf->bones[bone], frame, clip->coordinates + a->first[bone]);
}

/* What no line of the frame told: an error, or as in the frame before. */
static sn_status fill_frame(const amc *a, sn_index frame, sn_clip *clip) {
    for (sn_index b = 0; b < a->asf->count; b++) {
        const sn_asf_bone *bone = &a->asf->bones[b];
        if (a->seen[b] == frame + 1 || bone->freedom_count == 0) continue;
        if (a->complete)
            return sn_reader_fail(&a->reader, frame, "frame %d does not tell '%.80s', though it is :FULLY-SPECIFIED", frame, bone->name);
        for (int k = 0; k < bone->freedom_count && frame > 0; k++) {
            double *values = clip->coordinates[a->first[b] + k].values;
            values[frame] = values[frame - 1];
        }
    }
    return SN_OK;
}

static sn_status read_frame(amc *a, sn_index frame, int64_t *last, sn_clip *clip) {
    sn_reader *r = &a->reader;
    int64_t number = 0, next;
    sn_status status = SN_OK;
    if (!sn_reader_find_line(r) || !at_frame(*r, &number))
        return sn_reader_fail(r, frame, "expected the number of a frame on a line of its own");
    if (frame > 0 && number != *last + 1)
        return sn_reader_fail(r, frame, "frame %lld follows frame %lld; frames are missing", (long long)number, (long long)*last);
    *last = number;
    sn_reader_rest(r);
    while (status == SN_OK && sn_reader_find_line(r) && !at_frame(*r, &next)) status = read_bone_line(a, frame, clip);
    return status == SN_OK ? fill_frame(a, frame, clip) : status;
}

static sn_status read_frames(amc *a, sn_clip *clip) {
    sn_status status = SN_OK;
    int64_t last = 0;
    for (sn_index f = 0; f < clip->frame_count && status == SN_OK; f++) status = read_frame(a, f, &last, clip);
    if (status == SN_OK && a->beyond > 0)
        sn_log(SN_LOG_INFO, "%s: %lld angles lie beyond the limits of the skeleton", a->reader.blob->name, (long long)a->beyond);
    return status;
}

/* ---- poses ----------------------------------------------------------------------------------------------------------------------------
 */

static void pose_bone(const sn_asf_bone *bone, const sn_clip_coordinate *coordinates, sn_index frames, sn_rigid *local) {
    sn_quat back = sn_quat_conjugate(bone->axis);
    for (sn_index f = 0; f < frames; f++) {
        double shift[3] = {0};
        sn_quat q = sn_quat_identity();
        for (int k = 0; k < bone->freedom_count; k++) {
            int kind = bone->freedoms[k];
            double value = coordinates[k].values[f];
            if (kind < 3)
                shift[kind] = value;
            else
                q = sn_quat_multiply(sn_clip_turn(kind - 3, value), q);
        }
        q = sn_quat_multiply(sn_quat_multiply(bone->axis, q), back);
        local[f] = (sn_rigid){sn_quat_normalize(q), sn_quat_rotate(bone->axis, sn_v3(shift[0], shift[1], shift[2]))};
    }
}

static sn_status read_motion(amc *a, const sn_clip_source *source, sn_clip *out) {
    const sn_asf *asf = a->asf;
    sn_status status = read_head(a);
    if (status == SN_OK)
        status = sn_asf_make_clip(asf, source->options.meters_per_unit, &a->reader, count_frames(a->reader), a->first, out);
    a->meters = out->meters_per_unit_of_source;
    if (status == SN_OK) status = read_frames(a, out);
    if (status != SN_OK) return status;
    for (sn_index j = 0; j < asf->count; j++)
        pose_bone(&asf->bones[asf->order[j]], out->coordinates + a->first[asf->order[j]], out->frame_count, out->joints[j].poses);
    sn_clip_to_world(out);
    double rate = source->options.rate > 0.0 ? source->options.rate : a->rate;
    out->rate_assumed = !(rate > 0.0);
    out->rate = out->rate_assumed ? USUAL_RATE : rate;
    return SN_OK;
}

sn_status sn_amc_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_asf asf;
    *out = (sn_clip){0};
    sn_status status = sn_asf_parse(source->skeleton, &asf, error);
    if (status != SN_OK) return status;
    amc a = {.reader = sn_clip_open(source->motion, error),
             .asf = &asf,
             .angle = asf.angle,
             .first = SN_NEW(sn_index, asf.count),
             .seen = SN_NEW(sn_index, asf.count)};
    status = a.first != NULL && a.seen != NULL ? read_motion(&a, source, out) : sn_fail_memory(error, "bones");
    if (status != SN_OK) sn_clip_free(out);
    free(a.first);
    free(a.seen);
    sn_asf_free(&asf);
    return status;
}
