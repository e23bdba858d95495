/*
 * nodes_gltf.c -- how a glTF file interpolates its keys, and of what its keys are: out of its JSON, as assimp 5.2 passes over the one and
 * misreads the other.
 */
#include "nodes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"

enum { FLOAT = 5126, LIST_LIMIT = 1 << 20 };

typedef struct gltf {
    sn_json_value top, nodes, accessors, samplers;
    sn_nodes *out;
    sn_animation *animation;
    sn_index *channel_of; /* (node_count) of the animation; SN_NONE = none */
    sn_index *sorted;     /* (node_count) nodes by name */
    sn_index curves;
} gltf;

/* The JSON of a file: all of it, or the first chunk of a GLB. */
static sn_blob json_of(const sn_blob *file) {
    const unsigned char *b = (const unsigned char *)file->data;
    if (file->size < 20 || memcmp(b, "glTF", 4) != 0) return *file;
    size_t length = (size_t)b[12] | (size_t)b[13] << 8 | (size_t)b[14] << 16 | (size_t)b[15] << 24;
    return (sn_blob){file->name, file->data + 20, length < file->size - 20 ? length : file->size - 20};
}

static sn_index index_member(const sn_json_value *object, const char *key) {
    sn_json_value value = sn_json_member(object, key);
    sn_index out = SN_NONE;
    return sn_json_get_index(&value, 0, SN_INDEX_MAX - 1, &out, NULL) == SN_OK ? out : SN_NONE;
}

/* An element of a list of objects; absent where there is none. */
static sn_json_value entry(const sn_json_value *list, sn_index i) {
    if (!sn_json_is_array(list) || i == SN_NONE || i >= sn_json_length(list)) return (sn_json_value){.tree = list->tree};
    return sn_json_element(list, i);
}

static bool is_text(const sn_json_value *object, const char *key, const char *wanted) {
    sn_json_value value = sn_json_member(object, key);
    char *text = NULL;
    bool same = sn_json_get_text(&value, &text, NULL) == SN_OK && text != NULL && strcmp(text, wanted) == 0;
    free(text);
    return same;
}

/* ---- nodes by name ------------------------------------------------------------------------------------------------------------------- */

static int compare_nodes(const void *a, const void *b, void *nodes) {
    const sn_node *n = nodes;
    return strcmp(n[*(const sn_index *)a].name, n[*(const sn_index *)b].name);
}

static sn_index find_node(const gltf *g, const char *name) {
    sn_index low = 0, high = g->out->node_count;
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        int order = strcmp(g->out->nodes[g->sorted[middle]].name, name);
        if (order == 0) return g->sorted[middle];
        if (order < 0) low = middle + 1;
        if (order > 0) high = middle;
    }
    return SN_NONE;
}

/* The channel of the file's node: assimp calls it by its name, or by its number where it has none. */
static sn_node_channel *find_channel(const gltf *g, sn_index node) {
    sn_json_value object = entry(&g->nodes, node), name = sn_json_member(&object, "name");
    char *text = NULL, spare[32];
    snprintf(spare, sizeof spare, "nodes[%d]", (int)node);
    if (sn_json_get_text(&name, &text, NULL) != SN_OK) return NULL;
    sn_index found = find_node(g, text != NULL && *text != '\0' ? text : spare);
    free(text);
    return found != SN_NONE && g->channel_of[found] != SN_NONE ? &g->animation->channels[g->channel_of[found]] : NULL;
}

/* ---- channels -------------------------------------------------------------------------------------------------------------------------
 */

static sn_status read_channel(gltf *g, const sn_json_value *channel, sn_error *error) {
    static const char *const paths[SN_TRACK_COUNT] = {"translation", "rotation", "scale"};
    sn_json_value target = sn_json_member(channel, "target"), sampler = entry(&g->samplers, index_member(channel, "sampler"));
    int track = 0;
    while (track < SN_TRACK_COUNT && !is_text(&target, "path", paths[track])) track++;
    if (track == SN_TRACK_COUNT || index_member(&target, "node") == SN_NONE) return SN_OK; /* weights, extensions */
    sn_json_value output = entry(&g->accessors, index_member(&sampler, "output"));
    if (index_member(&output, "componentType") != FLOAT)
        return sn_fail(error, SN_ERROR_INPUT, "keys of an animation are integers, which are not read; export them as floats");
    bool step = is_text(&sampler, "interpolation", "STEP"), curve = is_text(&sampler, "interpolation", "CUBICSPLINE");
    sn_node_channel *found = find_channel(g, index_member(&target, "node"));
    if (found == NULL && step)
        return sn_fail(error, SN_ERROR_INPUT,
                       "an animation moves a node in steps, and which one is not clear; give the nodes names of their own");
    if (found != NULL) found->tracks[track].step = step;
    g->curves += curve;
    return SN_OK;
}

static sn_status prepare(gltf *g, sn_error *error) {
    sn_index count = g->out->node_count;
    g->channel_of = SN_NEW(sn_index, count);
    g->sorted = SN_NEW(sn_index, count);
    if (g->channel_of == NULL || g->sorted == NULL) return sn_fail_memory(error, "nodes");
    for (sn_index i = 0; i < count; i++) {
        g->channel_of[i] = SN_NONE;
        g->sorted[i] = i;
    }
    qsort_r(g->sorted, (size_t)count, sizeof *g->sorted, compare_nodes, g->out->nodes);
    for (sn_index k = 0; k < g->animation->channel_count; k++)
        if (g->animation->channels[k].node != SN_NONE) g->channel_of[g->animation->channels[k].node] = k;
    return SN_OK;
}

static sn_status read_channels(gltf *g, sn_index animation, sn_error *error) {
    sn_json_value animations = sn_json_member(&g->top, "animations"), chosen = entry(&animations, animation);
    sn_json_value channels = sn_json_member(&chosen, "channels");
    g->nodes = sn_json_member(&g->top, "nodes");
    g->accessors = sn_json_member(&g->top, "accessors");
    g->samplers = sn_json_member(&chosen, "samplers");
    if (!sn_json_is_array(&channels) || sn_json_length(&animations) != g->out->animation_count)
        return sn_fail(error, SN_ERROR_INPUT, "its animations are not what its importer makes of them; export it again");
    sn_index count = 0;
    sn_status status = sn_json_expect_list(&channels, LIST_LIMIT, &count, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value channel = sn_json_element(&channels, i);
        status = read_channel(g, &channel, error);
    }
    return status;
}

sn_status sn_gltf_interpolation(const sn_blob *file, sn_nodes *nodes, sn_index animation, sn_index *curves, sn_error *error) {
    sn_blob text = json_of(file);
    sn_json_tree *tree = NULL;
    gltf g = {.out = nodes, .animation = &nodes->animations[animation]};
    sn_status status = sn_json_parse(&text, &tree, error);
    if (status == SN_OK) {
        g.top = sn_json_top(tree);
        status = prepare(&g, error);
    }
    if (status == SN_OK) status = read_channels(&g, animation, error);
    *curves = g.curves;
    free(g.channel_of);
    free(g.sorted);
    sn_json_tree_free(tree);
    return status;
}
