/* clip_nodes.c -- glTF, FBX and Collada as clips: which animation of a file, its unit and axis. */
#include <stdlib.h>
#include <string.h>

#include "import.h"
#include "nodes.h"

static bool is_kind(const sn_blob *blob, const char *kind) {
    const char *found = sn_import_detect(blob);
    return found != NULL && strcmp(found, kind) == 0;
}

bool sn_gltf_is(const sn_blob *blob) { return is_kind(blob, "glb") || is_kind(blob, "gltf"); }
bool sn_fbx_is(const sn_blob *blob) { return is_kind(blob, "fbx"); }
bool sn_collada_is(const sn_blob *blob) { return is_kind(blob, "dae"); }

bool sn_nodes_text_is(const sn_blob *blob) {
    static const char first[] = "sinew-nodes 1\n";
    return blob->size >= sizeof first - 1 && memcmp(blob->data, first, sizeof first - 1) == 0;
}

/* By its name, else by its number from 1. */
static sn_index find_animation(const sn_nodes *nodes, const char *which) {
    int64_t number;
    const char *end = which + strlen(which), *next;
    for (sn_index i = 0; i < nodes->animation_count; i++)
        if (strcmp(nodes->animations[i].name, which) == 0) return i;
    if (!sn_scan_integer(which, end, &next, &number) || next != end || number < 1 || number > nodes->animation_count) return SN_NONE;
    return (sn_index)number - 1;
}

static sn_status choose_animation(const sn_nodes *nodes, const sn_clip_source *source, sn_index *out, sn_error *error) {
    const char *which = source->options.animation;
    *out = nodes->animation_count > 0 ? 0 : SN_NONE;
    if (which != NULL) *out = *which != '\0' ? find_animation(nodes, which) : SN_NONE; /* one without a name has a number */
    if (which != NULL && *out == SN_NONE)
        return sn_fail(error, SN_ERROR_INPUT, "has no animation \"%.100s\"; it has %d, which --list lists", which,
                       (int)nodes->animation_count);
    if (which == NULL && nodes->animation_count > 1)
        sn_log(SN_LOG_WARNING, "%s: the first of %d animations is taken, \"%.100s\"; --animation names another", source->motion->name,
               (int)nodes->animation_count, nodes->animations[0].name);
    return SN_OK;
}

static double seconds_of(const sn_animation *a) {
    double begin = INFINITY, end = -INFINITY;
    for (sn_index c = 0; c < a->channel_count; c++)
        for (int t = 0; t < SN_TRACK_COUNT; t++) {
            const sn_track *track = &a->channels[c].tracks[t];
            if (track->count > 1) begin = fmin(begin, track->times[0]);
            if (track->count > 1) end = fmax(end, track->times[track->count - 1]);
        }
    return end > begin ? end - begin : 0.0;
}

static sn_status list_animations(const sn_nodes *nodes, sn_clip *out, sn_error *error) {
    out->animations = SN_NEW(sn_clip_animation, nodes->animation_count);
    if (out->animations == NULL) return sn_fail_memory(error, "animations");
    for (sn_index i = 0; i < nodes->animation_count; i++) {
        out->animations[i] = (sn_clip_animation){sn_strdup(nodes->animations[i].name), seconds_of(&nodes->animations[i])};
        if (out->animations[i].name == NULL) return sn_fail_memory(error, "animations");
        out->animation_count++;
    }
    return SN_OK;
}

/* Between keys: of glTF what its samplers say, of the others what only their own programs know. */
static sn_status read_curves(const sn_clip_source *source, sn_nodes *nodes, sn_nodes_clip_options *options, sn_error *error) {
    sn_index curves = 0;
    options->curves = !sn_gltf_is(source->motion);
    if (options->curves || options->animation == SN_NONE) return SN_OK;
    sn_status status = sn_gltf_interpolation(source->motion, nodes, options->animation, &curves, error);
    options->curves = curves > 0;
    return status;
}

static sn_status animate(const sn_clip_source *source, sn_nodes *nodes, sn_clip *out, sn_error *error) {
    double given = source->options.meters_per_unit;
    sn_nodes_clip_options options = {.rate = source->options.rate, .name = source->motion->name, .file_size = source->motion->size};
    options.meters_per_unit = given > 0.0 ? given : nodes->frame.meters_per_unit > 0.0 ? nodes->frame.meters_per_unit : 1.0;
    sn_status status = choose_animation(nodes, source, &options.animation, error);
    if (status == SN_OK) status = read_curves(source, nodes, &options, error);
    if (status == SN_OK) status = sn_nodes_clip(nodes, &options, out, error);
    if (status == SN_OK) status = list_animations(nodes, out, error);
    if (status != SN_OK) return status;
    if (!(given > 0.0) && !(nodes->frame.meters_per_unit > 0.0))
        sn_log(SN_LOG_WARNING, "%s: says no unit; taken as metres, --units tells another", source->motion->name);
    /* what the file says of its axis; what the user says is done for every format alike */
    if (source->options.up == SN_UP_UNKNOWN && nodes->frame.up != SN_UP_Z) sn_clip_turn_y_up(out);
    return SN_OK;
}

/* What mesh-import has said to a file. */
static sn_status read_text(const sn_blob *text, sn_nodes *out, sn_error *error) {
    sn_error detail = {0};
    sn_status status = sn_nodes_parse(text, out, &detail);
    if (status == SN_OK) return SN_OK;
    return sn_fail_at(error, status == SN_ERROR_INTERNAL ? SN_ERROR_INPUT : status, text->name, 0, "%s", detail.text);
}

sn_status sn_nodes_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_nodes nodes;
    *out = (sn_clip){0};
    sn_status status =
        sn_nodes_text_is(source->motion) ? read_text(source->motion, &nodes, error) : sn_import_nodes(source->motion, &nodes, error);
    if (status == SN_OK) status = animate(source, &nodes, out, error);
    sn_nodes_free(&nodes);
    if (status != SN_OK) sn_clip_free(out);
    return status;
}
