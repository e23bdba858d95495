/*
 * xpbd.h -- inside lib/sim: what the back end `xpbd` remembers of one muscle.
 */
#ifndef SN_SIM_XPBD_H
#define SN_SIM_XPBD_H

#include "rows.h"

/* Lambdas of the rows; in single precision the points during a substep, relative to an origin (one), and 6 dV/dx. */
#define SN_XPBD_ARRAYS(X)                                                                                                                  \
    X(double, distance_lambda, m->distance_start[SN_DISTANCE_KINDS], SN_KEPT)                                                              \
    X(double, hinge_lambda, m->hinge_count, SN_KEPT)                                                                                       \
    X(sn_vec3, volume_gradient, m->keeps_volume ? m->vertex_count : 0, SN_LEFT)                                                            \
    X(sn_single_point, single_points, m->single ? m->point_count : 0, SN_KEPT)                                                             \
    X(sn_vec3, origin, m->single ? 1 : 0, SN_KEPT)                                                                                         \
    X(sn_single_point, single_gradient, m->single && m->keeps_volume ? m->vertex_count : 0, SN_LEFT)

/* What the back end remembers of one muscle. */
typedef struct sn_xpbd {
#define SN_XPBD_MEMBER(type, name, count, kept) type *name;
    SN_XPBD_ARRAYS(SN_XPBD_MEMBER)
#undef SN_XPBD_MEMBER
    double volume_lambda; /* of the volume row */
} sn_xpbd;

static inline sn_xpbd *sn_xpbd_of(const sn_muscle_state *s) { return s->memory; }

#endif
