/* clip_models.c -- models of bodies on joints, alone or moved by columns of numbers, as clips. */
#include "clip_reader.h"

/* A model's lengths in metres, and a rate that the user gives. */
static void take_options(const sn_clip_options *options, sn_clip *clip) {
    double scale = options->meters_per_unit;
    clip->meters_per_unit_of_source = scale;
    if (options->rate > 0.0) clip->rate = options->rate;
    for (sn_index i = 0; i < clip->joint_count && scale != 1.0; i++) {
        sn_clip_joint *joint = &clip->joints[i];
        joint->rest = sn_scale(joint->rest, scale);
        for (sn_index f = 0; f < clip->frame_count; f++) joint->poses[f].translation = sn_scale(joint->poses[f].translation, scale);
    }
    for (sn_index i = 0; i < clip->coordinate_count && scale != 1.0; i++) {
        sn_clip_coordinate *coordinate = &clip->coordinates[i];
        for (sn_index f = 0; *coordinate->unit == 'm' && f < clip->frame_count; f++) coordinate->values[f] *= scale;
    }
}

static sn_status animate(const sn_clip_source *source, const sn_skeleton *skeleton, const sn_columns *columns, sn_clip *out,
                         sn_error *error) {
    const sn_blob *model = columns != NULL ? source->skeleton : source->motion;
    sn_status status = sn_skeleton_animate(skeleton, columns, out, error);
    if (status != SN_OK) return status;
    take_options(&source->options, out);
    if (source->options.bones == NULL) return SN_OK;
    status = sn_model_bones_find(skeleton, model->name, &source->options, error);
    if (status != SN_OK) sn_error_set_file(error, model->name);
    return status;
}

sn_status sn_osim_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_skeleton skeleton;
    sn_status status = sn_osim_parse(source->motion, &skeleton, error);
    if (status == SN_OK) status = animate(source, &skeleton, NULL, out, error);
    sn_skeleton_free(&skeleton);
    return status;
}

sn_status sn_mjcf_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_skeleton skeleton;
    sn_status status = sn_mjcf_parse(source->motion, &skeleton, error);
    if (status == SN_OK) status = animate(source, &skeleton, NULL, out, error);
    sn_skeleton_free(&skeleton);
    return status;
}

sn_status sn_storage_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_skeleton skeleton;
    sn_columns columns = {0};
    const sn_blob *model = source->skeleton;
    sn_status status = sn_mjcf_detect(model) ? sn_mjcf_parse(model, &skeleton, error) : sn_osim_parse(model, &skeleton, error);
    if (status == SN_OK) status = sn_storage_parse(source->motion, &columns, error);
    if (status == SN_OK) status = animate(source, &skeleton, &columns, out, error);
    sn_columns_free(&columns);
    sn_skeleton_free(&skeleton);
    return status;
}
