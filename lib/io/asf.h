/* asf.h -- Acclaim's skeleton (ASF), from which its motions (AMC) are posed. Private to lib/io. */
#ifndef SINEW_IO_ASF_H
#define SINEW_IO_ASF_H

#include "clip_reader.h"

enum { SN_ASF_FREEDOMS = 6 };
extern const char *const sn_asf_freedom_names[SN_ASF_FREEDOMS]; /* tx ty tz rx ry rz: kind < 3 is a shift, kind % 3 the axis */

typedef struct sn_asf_bone {
    char *name;
    sn_index parent; /* in `bones`; SN_NONE = not in the hierarchy (yet); of the root too */
    sn_vec3 direction;
    double length; /* in the file's unit */
    sn_quat axis;  /* of the frame in which the degrees of freedom are told, in the world at rest */
    int freedom_count;
    unsigned char freedoms[SN_ASF_FREEDOMS]; /* in the order of their numbers in a motion; the first is applied first */
    bool limited;
    double limits[SN_ASF_FREEDOMS][2]; /* in the file's unit of angle */
    int64_t line;
} sn_asf_bone;

typedef struct sn_asf {
    sn_asf_bone *bones; /* (count) the first is the root */
    size_t capacity;
    sn_index count;
    sn_index *order;      /* (count) parents before children */
    sn_index *by_name;    /* (count) sorted */
    double length, angle; /* "length" of :units, and radians per unit of angle */
    sn_vec3 position;     /* of the root */
} sn_asf;

SN_MUST_CHECK sn_status sn_asf_parse(const sn_blob *blob, sn_asf *out, sn_error *error);
void sn_asf_free(sn_asf *asf);
sn_index sn_asf_find(const sn_asf *asf, sn_span name); /* by by_name; SN_NONE = there is none */
/* Joints at rest in metres, coordinates without values, for `frames` frames; joint i is bone order[i], and first_coordinate (count) tells
 * by bone which coordinate is its first. `reader` is at the motion, whose size bounds the memory. */
SN_MUST_CHECK sn_status sn_asf_make_clip(const sn_asf *asf, double meters_per_unit, sn_reader *reader, int64_t frames,
                                         sn_index *first_coordinate, sn_clip *out);

#endif
