/*
 * cgal_bridge.h -- the few CGAL algorithms that sinew uses, behind plain arrays; private to lib/geom.
 *
 * CGAL may crash or hang on input that it does not expect, so the C side (bridge.c) validates first: indices in range, no
 * repeated index in a triangle, coordinates finite and scaled to the unit box, at least one triangle. No exception crosses: each
 * function catches all and returns SN_ERROR_INTERNAL. The C side counts anew what comes back.
 */
#ifndef SINEW_GEOM_CGAL_BRIDGE_H
#define SINEW_GEOM_CGAL_BRIDGE_H

#include "sinew/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An indexed triangle surface; arrays are the owner's and made by sn_alloc. */
typedef struct sn_bridge_mesh {
    sn_index vertex_count, triangle_count;
    double *points;            /* (vertex_count x 3) in the unit box */
    sn_index *triangles;       /* (triangle_count x 3) */
    sn_index *vertex_origin;   /* (vertex_count) output only: the input vertex it comes from; SN_NONE = new, with no single one */
    sn_index *triangle_origin; /* (triangle_count) output only: the input triangle with the same first corner; SN_NONE = new */
} sn_bridge_mesh;

typedef struct sn_bridge_orientation {
    sn_index split_vertices; /* vertices added by cutting at edges and vertices that are not manifold */
    sn_index stitched_edges; /* pairs of coincident border edges joined */
} sn_bridge_orientation;

/* Orient a soup of triangles, cut it where it is not manifold, stitch borders that coincide. Triangles keep their number and order. */
sn_status sn_bridge_make_manifold(const sn_bridge_mesh *in, sn_bridge_mesh *out, sn_bridge_orientation *report, sn_error *error);

/* Called after each filled hole; true = stop here. */
typedef bool (*sn_bridge_hole_function)(void *user, sn_index edges, sn_index triangles);

/* Fill every border cycle of at most max_edges edges of an oriented manifold; new triangles come after the old ones. */
sn_status sn_bridge_fill_holes(const sn_bridge_mesh *in, sn_index max_edges, sn_bridge_hole_function filled, void *user,
                               sn_bridge_mesh *out, sn_error *error);

/* Collapse edges in the order of the quadric error (Garland, Heckbert 1997) of an oriented manifold until it has at most
 * `target` triangles or no edge is left that may go. bounded: no collapse may turn a triangle over; with it, edges at vertices that are
 * held (vertex_count; nullable) stay. */
sn_status sn_bridge_decimate(const sn_bridge_mesh *in, sn_index target, bool bounded, const bool *held, sn_bridge_mesh *out,
                             sn_error *error);

/* Pairs of triangles that meet in more than the corners and edges that they share; exact predicates; any soup. SN_NONE: more than
 * most_tests (0 = any number) pairs lie near each other. crosses (triangle_count, nullable): set for both of a pair of which one is made
 * (nullable: any). */
sn_status sn_bridge_find_intersections(const sn_bridge_mesh *in, int64_t most_tests, const bool *made, bool *crosses, sn_index *pairs,
                                       sn_error *error);

/* A closed oriented manifold around any soup: `offset` away from it, reaching only where a ball of radius `alpha` can come from outside. */
sn_status sn_bridge_wrap(const sn_bridge_mesh *in, double alpha, double offset, sn_bridge_mesh *out, sn_error *error);

/* Triangles with edges of about edge_length in place of those of an oriented manifold; triangles at vertices that are held
 * (vertex_count; nullable) are left out: no more than their outer edges may be split or shortened. */
sn_status sn_bridge_remesh(const sn_bridge_mesh *in, double edge_length, unsigned iterations, const bool *held, sn_bridge_mesh *out,
                           sn_error *error);

/* A closed oriented manifold without the triangles that cross, new ones in their place where that works. It may take for ever. */
sn_status sn_bridge_remove_intersections(const sn_bridge_mesh *in, sn_bridge_mesh *out, sn_error *error);

#ifdef __cplusplus
}
#endif
#endif
