/*
 * section.h -- where a level of a scalar field cuts a surface: curves, and the rings of vertices beside them. Private to lib/rig.
 *
 * A vertex is low where u < level, high otherwise (NaN counts as high), so a vertex never lies on the level. The curve passes through
 * the edges whose ends differ; every cut triangle links exactly two of them.
 */
#ifndef SINEW_RIG_SECTION_H
#define SINEW_RIG_SECTION_H

#include "sinew/geom.h"

/* One connected curve: cut edges first .. first + count - 1 of the section, in order along it. */
typedef struct section_curve {
    sn_index first, count;
    bool closed;
    sn_vec3 mean; /* of the curve, by length */
} section_curve;

/* A section and its scratch memory: one may be cut again and again. All zeros is an empty one; section_free ends it. */
typedef struct section {
    const sn_mesh *mesh;
    const sn_topology *topology;
    const double *u;
    double level;
    sn_index curve_count, cut_count;
    section_curve *curves;
    sn_index *cut_edges; /* (cut_count) */
    size_t curve_capacity;
    bool *low; /* (vertex_count) on the low side: a byte each, so that a cut reads little memory */
    uint32_t stamp;
    uint32_t *edge_stamp;   /* (edge_count) */
    uint32_t *vertex_stamp; /* (vertex_count) for section_ring and section_parts */
    sn_index *stack;        /* (vertex_count) for section_parts */
} section;

SN_MUST_CHECK sn_status section_create(const sn_mesh *mesh, const sn_topology *topology, section *out, sn_error *error);
void section_free(section *s);

/* Find the curves of {u = level}, in the order of their lowest edge. */
SN_MUST_CHECK sn_status section_cut(section *s, const double *u, double level, sn_error *error);

typedef enum section_side { SECTION_LOW, SECTION_HIGH } section_side;

/* Vertices on one side of a curve, in order along it, each step an edge; ring has room for curve->count. A walk that visits a vertex twice
 * is cut there and its longest simple part kept; *simple tells whether that was needed not at all. Returns how many. */
sn_index section_ring(section *s, const section_curve *curve, section_side side, sn_index *ring, bool *simple);

/* Turn a closed ring so that it starts at its lowest vertex and goes towards the lower one of that vertex's two neighbours. */
void section_ring_canonical(sn_index count, sn_index *ring);

/* Do consecutive vertices share edges, the last with the first, with no vertex twice? */
bool section_ring_closed(section *s, sn_index count, const sn_index *ring);

/* Connected parts of the surface, without `count` vertices, that touch those vertices. */
sn_index section_parts(section *s, sn_index count, const sn_index *vertices);

/* Do these vertices part those where value is 0 from those where it is 1: is there no way along edges past them, and are some of
 * either not among them? */
bool section_separates(section *s, sn_index count, const sn_index *vertices, const sn_fixed_values *ends);

#endif
