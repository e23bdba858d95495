/* nodes.c -- what mesh-import says of nodes and animations, read like any file: nothing of it is believed. */
#include "nodes.h"

#include <stdlib.h>
#include <string.h>

typedef struct parser {
    sn_reader reader;
    sn_nodes *out;
    sn_error *error;
} parser;

static sn_status nonsense(const parser *p, const char *what) {
    return sn_fail(p->error, SN_ERROR_INTERNAL, "line %lld: %s", (long long)p->reader.line, what);
}

/* Numbers that the file has too, so that it is the file that is wrong. */
static sn_status not_finite(const parser *p, const char *what) {
    return sn_fail(p->error, SN_ERROR_INPUT, "%s is not finite; the file is damaged", what);
}

static bool read_index(parser *p, sn_index limit, sn_index *out) {
    int64_t value;
    if (!sn_reader_integer(&p->reader, &value) || value < -1 || value >= limit) return false;
    *out = value < 0 ? SN_NONE : (sn_index)value;
    return true;
}

/* Of the next line: `count` finite numbers. */
static sn_status read_numbers(parser *p, sn_index count, double *out, const char *what) {
    if (!sn_reader_next_line(&p->reader)) return nonsense(p, "numbers are missing");
    for (sn_index i = 0; i < count; i++) {
        if (!sn_reader_number(&p->reader, &out[i])) return nonsense(p, "a number is missing");
        if (!isfinite(out[i])) return not_finite(p, what);
    }
    return SN_OK;
}

static char *read_name(parser *p) {
    sn_span rest = sn_reader_rest(&p->reader);
    return sn_strndup(rest.text, rest.length);
}

static sn_status read_node(parser *p) {
    sn_nodes *out = p->out;
    sn_index parent;
    if (!read_index(p, out->node_count, &parent) || (parent == SN_NONE && out->node_count > 0))
        return nonsense(p, "a node without a parent");
    if (out->animation_count > 0 || out->node_count == SN_INDEX_MAX) return nonsense(p, "a node too many");
    void *nodes = out->nodes;
    if (!sn_grow(&nodes, &out->node_capacity, (size_t)out->node_count + 1, sizeof *out->nodes)) return sn_fail_memory(p->error, "nodes");
    out->nodes = nodes;
    sn_node *node = &out->nodes[out->node_count++];
    *node = (sn_node){.name = read_name(p), .parent = parent};
    if (node->name == NULL) return sn_fail_memory(p->error, "a node");
    return read_numbers(p, 12, &node->local.m[0][0], "the transform of a node");
}

static bool is_near(const sn_affine *a, const sn_affine *b) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (fabs(a->m[i][j] - b->m[i][j]) > 1e-3 * (1.0 + fabs(a->m[i][j]))) return false;
    return true;
}

/* All zeros: its mesh was flat when it was bound, which tells nothing. */
static sn_status read_bind(parser *p) {
    sn_index index;
    sn_affine bind, nothing = {{{0}}};
    if (!read_index(p, p->out->node_count, &index)) return nonsense(p, "a bone that is no node");
    sn_status status = read_numbers(p, 12, &bind.m[0][0], "the place of a bone");
    if (status != SN_OK || index == SN_NONE || memcmp(&bind, &nothing, sizeof bind) == 0) return status;
    sn_node *node = &p->out->nodes[index];
    if (node->bound) node->bound_apart = node->bound_apart || !is_near(&node->bind, &bind);
    if (!node->bound) node->bind = bind;
    node->bound = true;
    return SN_OK;
}

/* ---- animations --------------------------------------------------------------------------------------------------------------------- */

static sn_status read_track(parser *p, int64_t count, int kind, double ticks, sn_track *out) {
    sn_index width = sn_track_width(kind);
    /* a key takes two bytes for each of its numbers at least */
    if (count < 0 || (double)count * 2.0 * (width + 1) > (double)(p->reader.end - p->reader.at))
        return nonsense(p, "a wrong number of keys");
    out->times = SN_NEW(double, (size_t)count);
    out->values = SN_NEW(double, (size_t)count *(size_t)width);
    if (out->times == NULL || out->values == NULL) return sn_fail_memory(p->error, "keys");
    for (sn_index i = 0; i < (sn_index)count; i++) {
        double row[5];
        sn_status status = read_numbers(p, width + 1, row, "a key of an animation");
        if (status != SN_OK) return status;
        out->times[i] = row[0] / ticks;
        memcpy(&out->values[(size_t)i * (size_t)width], row + 1, (size_t)width * sizeof *row);
        out->count = i + 1;
        if (i > 0 && out->times[i] < out->times[i - 1])
            return sn_fail(p->error, SN_ERROR_INPUT, "the keys of an animation are not in the order of their times; export it again");
        if (kind == SN_TRACK_TURN && !(row[1] * row[1] + row[2] * row[2] + row[3] * row[3] + row[4] * row[4] > 1e-12))
            return sn_fail(p->error, SN_ERROR_INPUT, "a rotation of an animation is the quaternion 0, which is none; export it again");
    }
    return SN_OK;
}

static sn_status read_channel(parser *p, double ticks, sn_node_channel *out) {
    int64_t counts[SN_TRACK_COUNT];
    if (!sn_reader_next_line(&p->reader) || !sn_span_is(sn_reader_word(&p->reader), "channel")) return nonsense(p, "a channel is missing");
    if (!read_index(p, p->out->node_count, &out->node)) return nonsense(p, "a channel of no node");
    for (int k = 0; k < SN_TRACK_COUNT; k++)
        if (!sn_reader_integer(&p->reader, &counts[k])) return nonsense(p, "a channel without its number of keys");
    sn_status status = SN_OK;
    for (int k = 0; k < SN_TRACK_COUNT && status == SN_OK; k++) status = read_track(p, counts[k], k, ticks, &out->tracks[k]);
    return status;
}

static sn_status read_animation(parser *p) {
    sn_nodes *out = p->out;
    double ticks;
    int64_t channels;
    if (!sn_reader_number(&p->reader, &ticks) || !sn_reader_integer(&p->reader, &channels))
        return nonsense(p, "an animation without numbers");
    if (channels < 0 || (double)channels * 16.0 > (double)(p->reader.end - p->reader.at) || out->animation_count == SN_INDEX_MAX)
        return nonsense(p, "a wrong number of channels");
    void *animations = out->animations;
    if (!sn_grow(&animations, &out->animation_capacity, (size_t)out->animation_count + 1, sizeof *out->animations))
        return sn_fail_memory(p->error, "animations");
    out->animations = animations;
    sn_animation *a = &out->animations[out->animation_count++];
    *a = (sn_animation){.name = read_name(p), .ticks = isfinite(ticks) && ticks > 0.0 ? ticks : 0.0};
    a->channels = SN_NEW(sn_node_channel, (size_t)channels);
    if (a->name == NULL || a->channels == NULL) return sn_fail_memory(p->error, "an animation");
    sn_status status = SN_OK;
    for (int64_t k = 0; k < channels && status == SN_OK; k++) {
        a->channel_count = (sn_index)k + 1;
        status = read_channel(p, a->ticks > 0.0 ? a->ticks : 1.0, &a->channels[k]);
    }
    return status;
}

/* ---- all ---------------------------------------------------------------------------------------------------------------------------- */

static sn_status read_line(parser *p, bool *end) {
    sn_span word = sn_reader_word(&p->reader);
    if (sn_span_is(word, "node")) return read_node(p);
    if (sn_span_is(word, "bind")) return read_bind(p);
    if (sn_span_is(word, "animation")) return read_animation(p);
    *end = sn_span_is(word, "end");
    if (*end) return SN_OK;
    if (sn_span_is(word, "up")) {
        p->out->frame.up = sn_span_is(sn_reader_word(&p->reader), "y") ? SN_UP_Y : SN_UP_Z;
        return SN_OK;
    }
    double *unit = &p->out->frame.meters_per_unit;
    bool good = sn_span_is(word, "metersPerUnit") && sn_reader_number(&p->reader, unit) && *unit > 0.0 && isfinite(*unit);
    return good ? SN_OK : nonsense(p, "this is no such text");
}

sn_status sn_nodes_parse(const sn_blob *answer, sn_nodes *out, sn_error *error) {
    parser p = {.out = out, .error = error};
    bool end = false;
    *out = (sn_nodes){0};
    p.reader = (sn_reader){.blob = answer, .at = answer->data, .end = answer->data + answer->size, .line = 1};
    sn_status status =
        answer->size > 0 && sn_span_is(sn_reader_word(&p.reader), "sinew-nodes") ? SN_OK : nonsense(&p, "this is no such text");
    while (status == SN_OK && !end) status = sn_reader_next_line(&p.reader) ? read_line(&p, &end) : nonsense(&p, "the end is missing");
    if (status == SN_OK && out->node_count == 0) status = nonsense(&p, "there is no node");
    if (status != SN_OK) sn_nodes_free(out);
    return status;
}

static void free_animation(sn_animation *a) {
    for (sn_index k = 0; a->channels != NULL && k < a->channel_count; k++)
        for (int t = 0; t < SN_TRACK_COUNT; t++) {
            free(a->channels[k].tracks[t].times);
            free(a->channels[k].tracks[t].values);
        }
    free(a->channels);
    free(a->name);
}

void sn_nodes_free(sn_nodes *nodes) {
    for (sn_index i = 0; i < nodes->node_count; i++) free(nodes->nodes[i].name);
    for (sn_index i = 0; i < nodes->animation_count; i++) free_animation(&nodes->animations[i]);
    free(nodes->nodes);
    free(nodes->animations);
    *nodes = (sn_nodes){0};
}
