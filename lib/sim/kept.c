/*
 * kept.c -- the cursor that states are saved and read with, and what numbers of each type may be.
 */
#include "kept.h"

/* ---- a cursor that counts, writes or reads ---------------------------------------------------------------------------------- */

void sn_cursor_pass(sn_cursor *c, void *data, size_t size) {
    if ((c->from != NULL || c->to != NULL) && (c->short_of || size > c->size - c->at)) {
        c->short_of = true;
        return;
    }
    if (c->from != NULL && size > 0) memcpy(data, c->from + c->at, size);
    if (c->to != NULL && size > 0) memcpy(c->to + c->at, data, size);
    c->at += size;
}

/* ---- what every number may be ----------------------------------------------------------------------------------------------- */

bool sn_sound_flag(const bool *flag) {
    unsigned char byte;
    memcpy(&byte, flag, sizeof byte);
    return byte <= 1;
}

bool sn_sound_numbers(const double *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && isfinite(values[i]);
    return sound;
}

bool sn_sound_vectors(const sn_vec3 *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_finite3(values[i]);
    return sound;
}

bool sn_sound_points(const sn_point *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_finite3(sn_point_position(&values[i])) && isfinite(values[i].w);
    return sound;
}

bool sn_sound_single_points(const sn_single_point *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++)
        sound = sound && isfinite(values[i].x) && isfinite(values[i].y) && isfinite(values[i].z) && isfinite(values[i].w);
    return sound;
}

bool sn_sound_flags(const bool *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_sound_flag(&values[i]);
    return sound;
}

bool sn_sound_indices(const sn_index *values, size_t count) {
    (void)values;
    (void)count;
    return true;
}

bool sn_sound_unit(sn_quat q) { return fabs(sn_quat_dot(q, q) - 1.0) <= 1e-3; }

bool sn_sound_turns(const sn_quat *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && (sn_sound_unit(values[i]) || sn_quat_dot(values[i], values[i]) == 0.0);
    return sound;
}

bool sn_sound_boxes(const sn_box *values, size_t count) {
    (void)values, (void)count;
    return true;
}

bool sn_sound_poses(const sn_rigid *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_sound_unit(values[i].rotation) && sn_finite3(values[i].translation);
    return sound;
}
