/*
 * clip_formats.c -- motion files of any format: which it is, by content; its reader; the same frame of reference for all.
 */
#include "clip_reader.h"

#include <stdlib.h>
#include <string.h>

#include "document.h"

/* The first that recognises a file reads it. */
static const sn_clip_format formats[] = {
    {"motion document", 0.0, false, NULL, sn_motion_document_detect, sn_motion_document_read},
    {"BVH", 0.01, true, NULL, sn_bvh_is, sn_bvh_read},
    {"AMC", 0.0254, true, "an .asf file", sn_amc_is, sn_amc_read},
    {"ASF", 0.0254, true, NULL, sn_asf_is, sn_asf_read},
    {"OSIM", 1.0, true, NULL, sn_osim_detect, sn_osim_read},
    {"MJCF", 1.0, false, NULL, sn_mjcf_detect, sn_mjcf_read},
    {"MOT", 1.0, true, "its model, an .osim file or one of MuJoCo's,", sn_storage_detect, sn_storage_read},
    {"glTF", 0.0, false, NULL, sn_gltf_is, sn_nodes_read},
    {"FBX", 0.0, false, NULL, sn_fbx_is, sn_nodes_read},
    {"Collada", 0.0, false, NULL, sn_collada_is, sn_nodes_read},
    {"nodes", 0.0, false, NULL, sn_nodes_text_is, sn_nodes_read},
};
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

static const sn_clip_format *find_format(const sn_blob *blob) {
    for (int i = 0; i < FORMAT_COUNT; i++)
        if (formats[i].is(blob)) return &formats[i];
    return NULL;
}

const char *sn_clip_detect(const sn_blob *blob) {
    const sn_clip_format *format = find_format(blob);
    return format != NULL ? format->name : NULL;
}

static sn_status check_source(const sn_clip_format *format, const sn_blob *motion, const sn_blob *skeleton, sn_error *error) {
    if (format == NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, motion->name, 0,
                          "holds no motion that is known; known are BVH, AMC with its ASF, MOT and STO with "
                          "their OSIM, models of MuJoCo, glTF, FBX, Collada, and motion documents");
    if (skeleton != NULL && format->skeleton == NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, motion->name, 0, "has its skeleton in it: %s takes none from another file", format->name);
    if (skeleton == NULL && format->skeleton != NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, motion->name, 0, "tells no skeleton; name %s with --skeleton", format->skeleton);
    return SN_OK;
}

sn_status sn_clip_parse(const sn_blob *motion, const sn_blob *skeleton, const sn_clip_options *options, sn_clip *out, sn_error *error) {
    const sn_clip_format *format = find_format(motion);
    *out = (sn_clip){0};
    sn_status status = check_source(format, motion, skeleton, error);
    if (status != SN_OK) return status;
    sn_clip_source source = {.motion = motion, .skeleton = skeleton, .options = *options};
    if (!(source.options.meters_per_unit > 0.0)) source.options.meters_per_unit = format->meters_per_unit;
    if (options->bones != NULL) *options->bones->found = (sn_model_bones){0};
    status = format->read(&source, out, error);
    if (status == SN_OK && options->bones != NULL && options->bones->found->bones == NULL)
        status = sn_fail(error, SN_ERROR_INPUT, "has no meshes of bones: %s is no model; OpenSim's and MuJoCo's are", format->name);
    if (status == SN_OK && options->animation != NULL && out->animation_count == 0)
        status = sn_fail(error, SN_ERROR_INPUT, "has no animations to choose from: it is %s", format->name);
    if (status == SN_OK) {
        /* columns of numbers stand in the axes of the model that they move */
        bool up_y = format->up_y && !(skeleton != NULL && sn_mjcf_detect(skeleton));
        out->format = format->name;
        if (options->up == SN_UP_Y || (options->up == SN_UP_UNKNOWN && up_y)) sn_clip_turn_y_up(out);
        if (out->name == NULL) out->name = sn_path_stem(motion->name);
        status = sn_clip_validate(out, error);
    }
    if (status != SN_OK) {
        sn_error_set_file(error, motion->name);
        sn_clip_free(out);
    }
    return status;
}

/* ---- what text formats share ----------------------------------------------------------------------------------------------------- */

sn_reader sn_clip_open(const sn_blob *blob, sn_error *error) { return sn_reader_of(blob, error); }

sn_span sn_clip_word(sn_reader *reader) { return sn_reader_find_line(reader) ? sn_reader_word(reader) : (sn_span){reader->at, 0}; }

sn_span sn_clip_first_word(const sn_blob *blob) {
    sn_reader reader = sn_clip_open(blob, NULL);
    return sn_clip_word(&reader);
}

sn_status sn_clip_reserve(sn_reader *reader, int64_t frames, int64_t joints, int64_t coordinates, sn_clip *out) {
    *out = (sn_clip){0};
    if (frames < 1) return sn_reader_fail(reader, SN_NONE, "there is no frame");
    if (joints < 1) return sn_reader_fail(reader, SN_NONE, "there is no joint");
    double a_frame = (double)joints * sizeof(sn_rigid) + (double)coordinates * sizeof(double);
    double fixed = (double)joints * sizeof(sn_clip_joint) + (double)coordinates * sizeof(sn_clip_coordinate);
    if (frames > SN_INDEX_MAX / 2 || !sn_reader_may_take(reader, (double)frames * a_frame + fixed))
        return sn_reader_fail(reader, SN_NONE, "%lld frames of %lld joints need more than ten times the memory of the file; it is damaged",
                              (long long)frames, (long long)joints);
    return sn_clip_create((sn_index)frames, (sn_index)joints, (sn_index)coordinates, out, reader->error);
}

sn_status sn_clip_number(sn_reader *reader, const char *what, double *out) {
    char found[48];
    const char *at = sn_reader_found(reader, found);
    if (!sn_reader_number(reader, out) || !isfinite(*out))
        return sn_reader_fail(reader, SN_NONE, "expected %s, a finite number, found %s", what, at);
    return SN_OK;
}

sn_quat sn_clip_turn(int axis, double angle) {
    double sine, cosine;
    sn_quick_sincos(0.5 * angle, &sine, &cosine);
    return (sn_quat){cosine, axis == 0 ? sine : 0.0, axis == 1 ? sine : 0.0, axis == 2 ? sine : 0.0};
}

char *sn_clip_channel_name(const char *joint, const char *channel) {
    size_t length = strlen(joint), size = length + strlen(channel) + 2;
    char *name = sn_alloc(size, 1);
    if (name == NULL) return NULL;
    memcpy(name, joint, length);
    name[length] = '.';
    memcpy(name + length + 1, channel, size - length - 1);
    return name;
}
