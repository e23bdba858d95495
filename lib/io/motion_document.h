/* motion_document.h -- joints and channels in scene, motion and activation documents. Private to lib/io. */
#ifndef SINEW_IO_MOTION_DOCUMENT_H
#define SINEW_IO_MOTION_DOCUMENT_H

#include "document.h"

/* What turns a document's times and lengths into seconds and metres. */
typedef struct sn_clock {
    double rate;            /* frames per second, for keys given by frame */
    double meters_per_unit; /* of points and translations */
    sn_index first_frame,
        last_frame;    /* where "degreesPerFrame" begins and ends: frames of the scene, whatever the rate of its motion document */
    double scene_rate; /* of these two; 0 = there is no scene */
} sn_clock;

/* The q with q x factor == value, where there is one: so a number that was scaled on reading is written as it was. */
double sn_unscale(double value, double factor);

/* The motion of a scene: { "joints": [...] }, or { "uri": "x.motion.json" }, a document of its own. */
SN_MUST_CHECK sn_status sn_motion_parse(const sn_json_value *value, sn_clock clock, sn_motion *out, sn_error *error);
void sn_motion_write(const sn_motion *motion, double meters_per_unit, sn_json *json);

/* "units": "mm", or metres per unit as a number (bone_document.c). */
SN_MUST_CHECK sn_status sn_units_parse(const sn_json_value *value, double *out, sn_error *error);
/* A bone (bone_document.c) with its known members, its path as it is written; *out is the caller's to free, also where this fails. */
SN_MUST_CHECK sn_status sn_bone_parse(const sn_json_value *value, const char *const *known, const sn_motion *motion, sn_motion_bone *out,
                                      sn_error *error);
/* The bones of a motion document, whose joints have been read; their paths from the working directory. */
SN_MUST_CHECK sn_status sn_motion_bones_parse(const sn_json_value *list, sn_motion *motion, sn_error *error);
/* document: where the document will be; NULL, "-": it goes to standard output. */
SN_MUST_CHECK sn_status sn_motion_bones_write(const sn_motion *motion, const char *document, sn_json *json, sn_error *error);

/* The members of an activation document, NULL at the end. */
extern const char *const sn_activation_members[];
/* An activation: a number, { "keys": [[time, activation], ...] }, or { "uri": ..., "channel": ... } (fallback: the muscle's name). */
SN_MUST_CHECK sn_status sn_activation_parse(const sn_json_value *value, sn_clock clock, const char *fallback, sn_channel *out,
                                            sn_error *error);
void sn_activation_write(const sn_channel *channel, sn_json *json);

#endif
