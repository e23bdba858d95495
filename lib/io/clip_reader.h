/*
 * clip_reader.h -- what the readers of motion files share, and the table of them. Private to lib/io.
 *
 * A reader fills a clip in metres, in the axes of its file; clip_formats.c detects the format, turns y up to z up, and checks what comes
 * back. One file a format, one row in the table of clip_formats.c.
 */
#ifndef SINEW_IO_CLIP_READER_H
#define SINEW_IO_CLIP_READER_H

#include "mesh_reader.h"
#include "sinew/model_files.h"

/* What a reader works from; the options have the format's own unit and rate where the user gave none. */
typedef struct sn_clip_source {
    const sn_blob *motion;
    const sn_blob *skeleton; /* NULL = none was given */
    sn_clip_options options;
} sn_clip_source;

typedef struct sn_clip_format {
    const char *name;       /* "BVH" */
    double meters_per_unit; /* where neither file nor user says; 0 = the reader knows */
    bool up_y;              /* the format's convention; what the user says counts more */
    const char *skeleton;   /* the files it may need beside ("an .asf file"); NULL = it takes none */
    bool (*is)(const sn_blob *blob);
    /* Errors name file and line. *out is empty on failure. */
    sn_status (*read)(const sn_clip_source *source, sn_clip *out, sn_error *error);
} sn_clip_format;

bool sn_bvh_is(const sn_blob *blob);
SN_MUST_CHECK sn_status sn_bvh_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
bool sn_asf_is(const sn_blob *blob);
bool sn_amc_is(const sn_blob *blob);
SN_MUST_CHECK sn_status sn_asf_read(const sn_clip_source *source, sn_clip *out, sn_error *error); /* the rest pose alone */
SN_MUST_CHECK sn_status sn_amc_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
SN_MUST_CHECK sn_status sn_motion_document_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
/* Models alone are one frame, at rest (clip_models.c). */
SN_MUST_CHECK sn_status sn_osim_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
SN_MUST_CHECK sn_status sn_mjcf_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
SN_MUST_CHECK sn_status sn_storage_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
/* glTF, FBX and Collada, by mesh-import (clip_nodes.c). They know their axis. */
bool sn_gltf_is(const sn_blob *blob);
bool sn_fbx_is(const sn_blob *blob);
bool sn_collada_is(const sn_blob *blob);
bool sn_nodes_text_is(const sn_blob *blob); /* what mesh-import --motion writes */
SN_MUST_CHECK sn_status sn_nodes_read(const sn_clip_source *source, sn_clip *out, sn_error *error);
/* Fill options->bones->found from a skeleton; `model` is its file, options have its unit (model_bones.c). */
SN_MUST_CHECK sn_status sn_model_bones_find(const sn_skeleton *skeleton, const char *model, const sn_clip_options *options,
                                            sn_error *error);

/* ---- what text formats share (clip_formats.c) ----------------------------------------------------------------------------------- */

#define SN_DEGREE (SN_PI / 180.0)

/* A cursor at the start of a text, behind a byte order mark. */
sn_reader sn_clip_open(const sn_blob *blob, sn_error *error);
/* The first word of the text behind blanks and comments; its length is 0 where there is none. */
sn_span sn_clip_first_word(const sn_blob *blob);
/* The next word, on a line further on if need be; its length is 0 at the end of the file. */
sn_span sn_clip_word(sn_reader *reader);
/* Like sn_clip_create, within the share of memory that a file of this size may take, and at least a frame and a joint. */
SN_MUST_CHECK sn_status sn_clip_reserve(sn_reader *reader, int64_t frames, int64_t joints, int64_t coordinates, sn_clip *out);
/* One finite number, or an error that names what was found in the place of `what`. */
SN_MUST_CHECK sn_status sn_clip_number(sn_reader *reader, const char *what, double *out);
/* Turn by `angle` about axis 0, 1 or 2. */
sn_quat sn_clip_turn(int axis, double angle);
/* "JOINT.channel"; NULL = out of memory. */
char *sn_clip_channel_name(const char *joint, const char *channel);

#endif
