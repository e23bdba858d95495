/*
 * bvh.c -- Biovision's BVH: a hierarchy of joints with offsets and channels, then a line of numbers for each frame.
 *
 * The rest pose has no rotation: all joints' frames are the world's. A joint's rotation channels multiply in the order in which they stand;
 * those of one axis twice are allowed. (M. Meredith, S. Maddock: Motion capture file formats explained, 2001.)
 */
#include "clip_reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "document.h"

enum { MOST_CHANNELS = 8 }; /* of a joint: six, and room for files that repeat one */

/* Positions come first, so that kind < 3 is a position and kind % 3 the axis. */
static const char *const channel_names[] = {"Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation"};
enum { CHANNEL_KINDS = sizeof channel_names / sizeof *channel_names };

typedef struct bvh_joint {
    sn_index parent;
    sn_vec3 offset, end; /* metres; of the end from the joint */
    bool has_offset, has_end;
    int channel_count;
    unsigned char channels[MOST_CHANNELS];
    sn_index first_channel; /* in the order of the file */
    int64_t line;
} bvh_joint;

typedef struct bvh {
    sn_reader reader;
    double meters_per_unit;
    sn_name_list names;
    bvh_joint *joints;
    size_t capacity;
    sn_index joint_count, channel_count;
    sn_index open; /* the joint whose braces are open; SN_NONE = outside of all */
    double rate;
    int64_t frames;
} bvh;

bool sn_bvh_is(const sn_blob *blob) { return sn_span_is_like(sn_clip_first_word(blob), "HIERARCHY"); }

/* ---- the hierarchy ------------------------------------------------------------------------------------------------------------------ */

static sn_status expected(bvh *b, const char *what) {
    char found[48];
    const char *at = sn_reader_find_line(&b->reader) ? sn_reader_found(&b->reader, found) : "the end of the file";
    return sn_reader_fail(&b->reader, SN_NONE, "expected %s, found %s", what, at);
}

static sn_status expect_brace(bvh *b) {
    sn_reader before = b->reader;
    if (sn_span_is(sn_clip_word(&b->reader), "{")) return SN_OK;
    b->reader = before;
    return expected(b, "'{'");
}

/* The rest of the line is the name; a brace may stand behind it. */
static sn_status read_name(bvh *b, const char *keyword) {
    sn_span rest = sn_reader_rest(&b->reader);
    if (rest.length > 0 && rest.text[rest.length - 1] == '{') {
        b->reader.at = rest.text + --rest.length;
        while (rest.length > 0 && strchr(" \t", rest.text[rest.length - 1]) != NULL) rest.length--;
    }
    if (rest.length == 0) return sn_reader_fail(&b->reader, SN_NONE, "%s has no name", keyword);
    char *name = sn_strndup(rest.text, rest.length);
    bool added = name != NULL && sn_name_list_add(&b->names, name, true);
    if (added && strcmp(b->names.items[b->names.count - 1], name) != 0)
        sn_log(SN_LOG_WARNING, "%s:%lld: the joint '%.80s' becomes '%.80s': names are clean text, and no two alike", b->reader.blob->name,
               (long long)b->reader.line, name, b->names.items[b->names.count - 1]);
    free(name);
    return added ? SN_OK : sn_fail_memory(b->reader.error, "a name");
}

static sn_status open_joint(bvh *b, bool root) {
    const char *keyword = root ? "ROOT" : "JOINT";
    if (root != (b->open == SN_NONE))
        return sn_reader_fail(&b->reader, SN_NONE,
                              root ? "ROOT stands inside of a joint; it is missing a '}' before" : "JOINT stands outside of a ROOT");
    if (b->joint_count == SN_LIST_LIMIT) return sn_reader_fail(&b->reader, SN_NONE, "there are more than %d joints", SN_LIST_LIMIT);
    if (!sn_grow((void **)&b->joints, &b->capacity, (size_t)b->joint_count + 1, sizeof *b->joints))
        return sn_fail_memory(b->reader.error, "joints");
    b->joints[b->joint_count] = (bvh_joint){.parent = b->open, .first_channel = b->channel_count, .line = b->reader.line};
    sn_status status = read_name(b, keyword);
    if (status == SN_OK) status = expect_brace(b);
    if (status == SN_OK) b->open = b->joint_count++;
    return status;
}

static sn_status read_offset(bvh *b, sn_vec3 *out) {
    sn_status status = sn_reader_position(&b->reader, out);
    if (status == SN_OK && !sn_finite3(*out)) return sn_reader_fail(&b->reader, SN_NONE, "the offset is not finite");
    *out = sn_scale(*out, b->meters_per_unit);
    return status;
}

static sn_status read_end_site(bvh *b) {
    bvh_joint *joint = &b->joints[b->open];
    sn_reader_rest(&b->reader); /* "Site", or a name */
    if (b->reader.at > b->reader.blob->data && b->reader.at[-1] == '{') b->reader.at--;
    sn_status status = expect_brace(b);
    if (status == SN_OK && !sn_span_is_like(sn_clip_word(&b->reader), "OFFSET")) status = expected(b, "OFFSET in an End Site");
    if (status == SN_OK) status = read_offset(b, &joint->end);
    if (status == SN_OK && !sn_span_is(sn_clip_word(&b->reader), "}")) status = expected(b, "'}' behind an End Site");
    joint->has_end = true;
    return status;
}

static int channel_kind(sn_span word) {
    for (int k = 0; k < CHANNEL_KINDS; k++)
        if (sn_span_is_like(word, channel_names[k])) return k;
    return -1;
}

/* How many of the first `count` channels are of this kind. */
static int earlier(const bvh_joint *joint, int count, int kind) {
    int found = 0;
    for (int k = 0; k < count; k++) found += joint->channels[k] == kind;
    return found;
}

static sn_status read_channels(bvh *b) {
    bvh_joint *joint = &b->joints[b->open];
    int64_t count;
    char found[48];
    if (joint->channel_count > 0) return sn_reader_fail(&b->reader, SN_NONE, "CHANNELS stands twice in one joint");
    if (!sn_reader_integer(&b->reader, &count) || count < 0 || count > MOST_CHANNELS)
        return sn_reader_fail(&b->reader, SN_NONE, "expected the number of channels, 0 to %d", MOST_CHANNELS);
    for (int64_t i = 0; i < count; i++) {
        const char *at = sn_reader_found(&b->reader, found);
        int kind = channel_kind(sn_reader_word(&b->reader));
        if (kind < 0)
            return sn_reader_fail(&b->reader, SN_NONE, "expected channel %d of %d (Xposition, Zrotation, ...), found %s", (int)i + 1,
                                  (int)count, at);
        if (kind < 3 && earlier(joint, joint->channel_count, kind) > 0)
            return sn_reader_fail(&b->reader, SN_NONE, "%s stands twice among the channels of one joint", channel_names[kind]);
        joint->channels[joint->channel_count++] = (unsigned char)kind;
    }
    b->channel_count += (sn_index)count;
    return SN_OK;
}

static sn_status close_joint(bvh *b) {
    const bvh_joint *joint = &b->joints[b->open];
    if (!joint->has_offset) return sn_reader_fail(&b->reader, SN_NONE, "the joint '%.80s' has no OFFSET", b->names.items[b->open]);
    b->open = joint->parent;
    return SN_OK;
}

/* A statement of the open joint. */
static sn_status read_member(bvh *b, sn_span word) {
    bvh_joint *joint = &b->joints[b->open];
    if (sn_span_is_like(word, "OFFSET")) {
        if (joint->has_offset) return sn_reader_fail(&b->reader, SN_NONE, "OFFSET stands twice in one joint");
        joint->has_offset = true;
        return read_offset(b, &joint->offset);
    }
    if (sn_span_is_like(word, "CHANNELS")) return read_channels(b);
    if (sn_span_is_like(word, "End")) return read_end_site(b);
    if (sn_span_is(word, "}")) return close_joint(b);
    return sn_reader_fail(&b->reader, SN_NONE, "'%.*s' stands where OFFSET, CHANNELS, JOINT, End Site or '}' is expected",
                          (int)(word.length < 40 ? word.length : 40), word.text);
}

/* Up to the word MOTION. */
static sn_status read_hierarchy(bvh *b) {
    sn_status status = SN_OK;
    sn_clip_word(&b->reader); /* HIERARCHY */
    while (status == SN_OK) {
        sn_span word = sn_clip_word(&b->reader);
        if (word.length == 0) return sn_reader_fail(&b->reader, SN_NONE, "the file ends in its hierarchy; it is cut off");
        if (sn_span_is_like(word, "ROOT") || sn_span_is_like(word, "JOINT"))
            status = open_joint(b, sn_span_is_like(word, "ROOT"));
        else if (b->open != SN_NONE)
            status = read_member(b, word);
        else if (sn_span_is_like(word, "MOTION"))
            break;
        else
            status = sn_reader_fail(&b->reader, SN_NONE, "'%.*s' stands where ROOT or MOTION is expected",
                                    (int)(word.length < 40 ? word.length : 40), word.text);
    }
    if (status == SN_OK && b->channel_count == 0) return sn_reader_fail(&b->reader, SN_NONE, "no joint has a channel: nothing moves");
    return status;
}

/* ---- the frames' head ---------------------------------------------------------------------------------------------------------------- */

/* The value of a line "NAME: value"; the colon may be apart. */
static sn_status read_field(bvh *b, const char *name, sn_span *out) {
    if (!sn_reader_find_line(&b->reader)) return expected(b, name);
    sn_span line = sn_reader_rest(&b->reader);
    size_t length = strlen(name);
    if (line.length < length || !sn_span_is_like((sn_span){line.text, length}, name))
        return sn_reader_fail(&b->reader, SN_NONE, "expected '%s:', found '%.*s'", name, (int)(line.length < 40 ? line.length : 40),
                              line.text);
    while (length < line.length && strchr(" \t:", line.text[length]) != NULL) length++;
    *out = (sn_span){line.text + length, line.length - length};
    return SN_OK;
}

/* Frames a second of a frame time: a whole number where that is what its digits mean (0.0083333 is 1/120). */
static double rate_of(sn_span text, double seconds) {
    const char *point = memchr(text.text, '.', text.length), *end = text.text + text.length;
    double whole = floor(1.0 / seconds + 0.5), half_digit = 0.5;
    for (const char *c = point != NULL ? point + 1 : end; c < end && *c >= '0' && *c <= '9'; c++) half_digit *= 0.1;
    bool plain = memchr(text.text, 'e', text.length) == NULL && memchr(text.text, 'E', text.length) == NULL;
    return plain && whole >= 1.0 && fabs(1.0 / whole - seconds) <= half_digit ? whole : 1.0 / seconds;
}

static sn_status read_motion_head(bvh *b) {
    sn_span frames = {0}, time = {0};
    const char *next;
    double seconds = 0.0;
    sn_status status = read_field(b, "Frames", &frames);
    if (status != SN_OK) return status;
    if (!sn_scan_integer(frames.text, frames.text + frames.length, &next, &b->frames) || next != frames.text + frames.length ||
        b->frames < 1)
        return sn_reader_fail(&b->reader, SN_NONE, "expected a number of frames, at least 1, behind 'Frames:'");
    status = read_field(b, "Frame Time", &time);
    if (status != SN_OK) return status;
    if (!sn_scan_number(time.text, time.text + time.length, &next, &seconds) || next != time.text + time.length || !(seconds >= 1e-6) ||
        !(seconds <= 1e6))
        return sn_reader_fail(&b->reader, SN_NONE, "expected the seconds of a frame, 1e-6 to 1e6, behind 'Frame Time:'");
    b->rate = rate_of(time, seconds);
    return SN_OK;
}

/* ---- the frames ---------------------------------------------------------------------------------------------------------------------- */

static sn_status read_frame(bvh *b, sn_clip *clip, sn_index frame, const double *scales) {
    sn_reader *r = &b->reader;
    if (!sn_reader_find_line(r))
        return sn_reader_fail(r, frame, "the file ends after %d of %lld frames; it is cut off", frame, (long long)b->frames);
    for (sn_index c = 0; c < b->channel_count; c++) {
        double value;
        if (sn_reader_at_line_end(r))
            return sn_reader_fail(r, frame, "frame %d has %d numbers; the channels are %d", frame, c, b->channel_count);
        sn_status status = sn_clip_number(r, "a channel's value", &value);
        if (status != SN_OK) return status;
        clip->coordinates[c].values[frame] = value * scales[c];
    }
    if (!sn_reader_at_line_end(r))
        return sn_reader_fail(r, frame, "frame %d has more than %d numbers, the channels", frame, b->channel_count);
    sn_reader_next_line(r);
    return SN_OK;
}

static sn_status read_frames(bvh *b, sn_clip *clip) {
    double *scales = SN_NEW(double, b->channel_count);
    sn_status status = scales != NULL ? SN_OK : sn_fail_memory(b->reader.error, "channels");
    for (sn_index j = 0; j < b->joint_count && status == SN_OK; j++)
        for (int k = 0; k < b->joints[j].channel_count; k++)
            scales[b->joints[j].first_channel + k] = b->joints[j].channels[k] < 3 ? b->meters_per_unit : SN_DEGREE;
    for (sn_index f = 0; f < clip->frame_count && status == SN_OK; f++) status = read_frame(b, clip, f, scales);
    if (status == SN_OK && sn_reader_find_line(&b->reader))
        status = sn_reader_fail(&b->reader, SN_NONE, "the file goes on behind its %lld frames; is 'Frames:' wrong?", (long long)b->frames);
    free(scales);
    return status;
}

/* ---- the clip ------------------------------------------------------------------------------------------------------------------------ */

/* A rotation that stands a second time (Euler angles about Z, X, Z) is told by a number behind its name. */
static bool describe_channel(const bvh_joint *joint, int k, const char *name, sn_clip_coordinate *out) {
    int kind = joint->channels[k], times = earlier(joint, k, kind);
    char channel[32];
    snprintf(channel, sizeof channel, times > 0 ? "%s%d" : "%s", channel_names[kind], times + 1);
    out->name = sn_clip_channel_name(name, channel);
    out->unit = sn_strdup(kind < 3 ? "m" : "rad");
    return out->name != NULL && out->unit != NULL;
}

/* Rest places, names and coordinates. */
static sn_status describe(const bvh *b, sn_clip *clip) {
    bool enough = true;
    for (sn_index j = 0; j < b->joint_count && enough; j++) {
        const bvh_joint *from = &b->joints[j];
        sn_clip_joint *to = &clip->joints[j];
        to->parent = from->parent;
        to->rest = from->parent == SN_NONE ? from->offset : sn_add(clip->joints[from->parent].rest, from->offset);
        to->has_end = from->has_end;
        if (from->has_end) to->end = sn_add(to->rest, from->end);
        enough = (to->name = sn_strdup(b->names.items[j])) != NULL;
        for (int k = 0; k < from->channel_count && enough; k++)
            enough = describe_channel(from, k, to->name, &clip->coordinates[from->first_channel + k]);
    }
    return enough ? SN_OK : sn_fail_memory(b->reader.error, "joints");
}

/* How far the joint's centre is from its rest place, where its position channels are added to its OFFSET, or stand in its place. */
static sn_vec3 shift_at(const bvh_joint *joint, const sn_clip *clip, sn_index frame, bool add) {
    const double offset[3] = {joint->offset.x, joint->offset.y, joint->offset.z};
    double shift[3] = {0};
    for (int k = 0; k < joint->channel_count; k++) {
        int kind = joint->channels[k];
        if (kind < 3) shift[kind] = clip->coordinates[joint->first_channel + k].values[frame] - (add ? 0.0 : offset[kind]);
    }
    return sn_v3(shift[0], shift[1], shift[2]);
}

/* Some programs write a joint's whole translation, others what is added to its OFFSET: whatever moves it less in the first frame. */
static bool adds(const bvh_joint *joint, const sn_clip *clip, sn_clip_positions positions) {
    if (positions != SN_POSITIONS_AUTO) return positions == SN_POSITIONS_ADD;
    return sn_norm(shift_at(joint, clip, 0, true)) <= sn_norm(shift_at(joint, clip, 0, false));
}

static void pose_joint(const bvh_joint *joint, sn_clip *clip, sn_rigid *local, sn_clip_positions positions) {
    bool add = adds(joint, clip, positions);
    for (sn_index f = 0; f < clip->frame_count; f++) {
        sn_quat q = sn_quat_identity();
        for (int k = 0; k < joint->channel_count; k++)
            if (joint->channels[k] >= 3)
                q = sn_quat_multiply(q, sn_clip_turn(joint->channels[k] - 3, clip->coordinates[joint->first_channel + k].values[f]));
        local[f] = (sn_rigid){sn_quat_normalize(q), shift_at(joint, clip, f, add)};
    }
}

static sn_status make_clip(bvh *b, const sn_clip_source *source, sn_clip *clip) {
    sn_status status = describe(b, clip);
    if (status == SN_OK) status = read_frames(b, clip);
    if (status != SN_OK) return status;
    for (sn_index j = 0; j < b->joint_count; j++) pose_joint(&b->joints[j], clip, clip->joints[j].poses, source->options.positions);
    sn_clip_to_world(clip);
    clip->rate = source->options.rate > 0.0 ? source->options.rate : b->rate;
    clip->meters_per_unit_of_source = b->meters_per_unit;
    return SN_OK;
}

sn_status sn_bvh_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    bvh b = {.reader = sn_clip_open(source->motion, error), .meters_per_unit = source->options.meters_per_unit, .open = SN_NONE};
    *out = (sn_clip){0};
    sn_status status = read_hierarchy(&b);
    if (status == SN_OK) status = read_motion_head(&b);
    if (status == SN_OK && b.frames > (int64_t)(source->motion->size / (2 * (size_t)b.channel_count) + 1))
        status = sn_reader_fail(&b.reader, SN_NONE, "%lld frames of %d channels do not fit into the file; it is cut off",
                                (long long)b.frames, b.channel_count);
    if (status == SN_OK) status = sn_clip_reserve(&b.reader, b.frames, b.joint_count, b.channel_count, out);
    if (status == SN_OK) status = make_clip(&b, source, out);
    if (status != SN_OK) sn_clip_free(out);
    sn_name_list_free(&b.names);
    free(b.joints);
    return status;
}
