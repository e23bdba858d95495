/*
 * frames.h -- inside lib/sim: how each point of a muscle has turned since rest. What is known of the rest shape is carried along by it.
 */
#ifndef SN_SIM_FRAMES_H
#define SN_SIM_FRAMES_H

#include "sinew/sim.h"

enum { SN_SECTION_OVERLAP = 4 }; /* sections that a point belongs to, at most */

/* Overlapping sections of the rest shape, and scratch. One muscle each. */
typedef struct sn_frames {
    const sn_model_muscle *model;
    sn_index count;                         /* sections */
    sn_index *centres;                      /* (count) vertices */
    sn_index (*member)[SN_SECTION_OVERLAP]; /* (points) sections of a point, the nearest first; SN_NONE behind the last */
    double (*weight)[SN_SECTION_OVERLAP];   /* (points) theirs, 1 in sum */
    double *total;                          /* (count) sum of weights */
    sn_vec3 *rest_middle, *middle;          /* (count) weighted means of the positions at rest and now, m */
    sn_mat3 *spread;                        /* (count) sum of rest position times position, about the middles, m^2 */
    sn_quat *turn;                          /* (count) from rest to now */
    sn_vec3 *rest_normals, *normals;        /* (vertices) */
} sn_frames;

/* Up to `most` sections; false: no memory. */
bool sn_frames_create(const sn_model_muscle *m, sn_index most, sn_frames *out);
void sn_frames_free(sn_frames *f);
/* turns (points) at these points (points): R(turn) takes directions of the rest shape to where they point now. */
void sn_frames_turn(sn_frames *f, const sn_point *points, sn_quat *turns);

#endif
