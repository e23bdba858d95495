/*
 * architecture.h -- what a rig says of a muscle's architecture: fibre length, pennation, physiological cross-section area; what of the
 * muscle is tendon.   rank 2
 *
 * Everything comes from the `fibers` section and the surface, however the fibres were made. Coordinates, lengths, areas and volumes are in
 * the document's unit, angles in radians.
 */
#ifndef SINEW_ARCHITECTURE_H
#define SINEW_ARCHITECTURE_H

#include "sinew/muscle.h"

/* The vertex attribute of the mesh that tells tendon from muscle: one number per vertex, 0 = muscle to 1 = tendon. */
#define SN_TENDON_ATTRIBUTE "tendon"

/* Where it comes from what is tendon. The words are in sn_tendon_names. */
typedef enum sn_tendon_source {
    SN_TENDON_NONE,      /* nothing is */
    SN_TENDON_THICKNESS, /* long thin ends (lib/rig/tendon_map.c) */
    SN_TENDON_PAINTED,   /* SN_TENDON_ATTRIBUTE of the mesh */
    SN_TENDON_GIVEN      /* the first and the last part of every fibre, by hand */
} sn_tendon_source;
extern const char *const sn_tendon_names[]; /* "none", "thickness", "painted", "given", NULL */

/* How much of each fibre is tendon at one of its ends. */
typedef struct sn_tendon_end {
    double length; /* document units, or a share of the fibre's length; >= 0 */
    bool is_share;
} sn_tendon_end;

typedef struct sn_architecture_params {
    sn_tendon_source tendon; /* default: by thickness */
    sn_tendon_end ends[2];   /* given: at the origin (a fibre's first point), at the insertion (its last) */
    double thin;             /* by thickness: section over the belly's below which a part is thin; in (0, 1); default 0.15 */
    double slender;          /* by thickness: a thin part is tendon from this many of its own half perimeters on; > 0; default 2.5 */
} sn_architecture_params;

typedef struct sn_spread {
    double mean, deviation, least, greatest; /* deviation: over all fibres of this muscle; 0 where there is one */
} sn_spread;

typedef struct sn_architecture {
    sn_index fibers;
    double volume;           /* of the surface; that of an open one is a guess */
    bool closed;             /* is it closed? */
    sn_spread length;        /* of the fibres from tip to tip, along them */
    sn_spread pennation[2];  /* at the origin and at the insertion, by fibre */
    double mean_pennation;   /* of both ends of all fibres */
    double area;             /* physiological cross-section area: volume / mean length x cos(mean pennation) */
    sn_tendon_source tendon; /* as it was in use */
    sn_index belly_fibers;   /* fibres that have a part in the belly */
    sn_spread belly;         /* length of those parts, over the belly fibres; all 0 where there are none */
    double tendon_share;     /* of all fibres' length that lies in tendon */
    double tendon_volume;    /* share of the volume */
    double belly_area;       /* volume of the belly / mean belly length x cos(mean pennation); 0 without belly fibres */
    double *map;             /* (vertex_count) 0 = muscle to 1 = tendon; owned */
} sn_architecture;

sn_architecture_params sn_architecture_defaults(void);
/*
 * Measure the fibres of a muscle.
 *
 * Pennation is the angle between a fibre's direction at its end and the force-generating axis (Lieber, Friden 2000; Ward et al. 2009
 * measured it at the distal tendon): here the muscle's line of action, the line through the centroids of its sections, at the level where
 * the fibre ends. The end's direction is that of its first fifth. Where there is tendon, a fibre ends where it enters that: its tendon is
 * part of the line. Axes have no sign: angles are in [0, pi/2]. The area is eq. 1 of Lieber and Friden 2000 without the density.
 *
 * SN_ERROR_INPUT: there are no fibres, one has no length, the surface has no section, or a painted map is not one number in [0, 1] per
 * vertex; SN_ERROR_USAGE: a parameter is out of range. The muscle must be valid.
 */
SN_MUST_CHECK sn_status sn_architecture_measure(const sn_muscle *muscle, const sn_architecture_params *params, sn_architecture *out,
                                                sn_error *error);
void sn_architecture_free(sn_architecture *architecture); /* frees what it owns and zeroes it */

#endif
