/*
 * geom.h -- repair, simplify, closest point, ray, inside/outside, fields on a surface.   rank 1
 *
 * Behind it: CGAL (repair, simplification), Embree (closest point, rays), CHOLMOD (fields). Every function validates its input
 * before a library sees it, and re-checks what the library gave back.
 */
#ifndef SINEW_GEOM_H
#define SINEW_GEOM_H

#include "sinew/mesh.h"
#include "sinew/trace.h"

/* ---- repair (lib/geom/weld.c; CGAL behind lib/geom/cgal_*.cpp) ------------------------------------------------------ */

/* Join vertices closer than `tolerance`: the lowest index of a cluster stands for it, the others go, triangles that collapse go;
 * clean input keeps vertices and order exactly. new_index (vertex_count before; nullable) maps old to new. */
SN_MUST_CHECK sn_status sn_weld(sn_mesh *mesh, double tolerance, sn_index *welded, sn_index *new_index, sn_error *error);
/* Drop all but the first of triangles with the same three vertices, and triangles with a repeated index or no area (height below
 * 1e-12 of the longest edge). One that has its middle corner on an edge of its neighbour gives way to a split of the neighbour, so
 * that no crack opens. */
SN_MUST_CHECK sn_status sn_drop_bad_triangles(sn_mesh *mesh, sn_index *degenerate, sn_index *duplicate, sn_error *error);
/* Join borders that run side by side: a border vertex that lies closer than `tolerance` to another border vertex is joined with it (the
 * lower index stays), one that lies that close to a border edge splits the triangle there. tolerance 0 = as the mesh says: closer than
 * a quarter of the shortest border edge at either. */
typedef struct sn_crack_report {
    sn_index vertices; /* joined, or put into an edge */
    double widest;     /* the widest gap closed */
} sn_crack_report;
SN_MUST_CHECK sn_status sn_close_cracks(sn_mesh *mesh, double tolerance, sn_crack_report *report, sn_error *error);
/* Drop vertices that no triangle uses; the rest keep their order. */
SN_MUST_CHECK sn_status sn_drop_unused_vertices(sn_mesh *mesh, sn_index *dropped, sn_error *error);
/* Drop vertices with a coordinate that is not finite, and the triangles on them. Indices must be in range. */
SN_MUST_CHECK sn_status sn_drop_nonfinite_vertices(sn_mesh *mesh, sn_index *dropped, sn_error *error);
/* Drop fins and walls inside, orient the soup, duplicate non-manifold vertices, stitch borders (CGAL PMP). A closed oriented manifold
 * comes back unchanged. A fin or wall is a patch whose edges all carry three triangles or one: without it they carry two or none; the
 * smallest goes first. */
typedef struct sn_manifold_report {
    sn_index wall_triangles, flipped, split_vertices, stitched_edges;
    bool orientable; /* false: one-sided, like a Moebius strip; it was cut */
} sn_manifold_report;
SN_MUST_CHECK sn_status sn_make_manifold(sn_mesh *mesh, sn_manifold_report *report, sn_error *error);
/* Fill boundary loops of at most max_edges edges (0 = any); boundary edges are recounted after it. */
SN_MUST_CHECK sn_status sn_fill_holes(sn_mesh *mesh, sn_index max_edges, sn_trace *trace, sn_index *filled, sn_index *boundary_left,
                                      sn_error *error);
/* A closed oriented manifold in *out around the triangles of any soup, however broken (Portaneri et al. 2022, Alpha wrapping with an
 * offset): parts nearer than 2 offset become one body, holes narrower than 2 alpha are bridged. Its vertices are then drawn back towards
 * the soup, to a quarter of the offset from it, or as far as no triangles cross. Without attributes: sn_carry_attributes. Deterministic. */
SN_MUST_CHECK sn_status sn_wrap(const sn_mesh *mesh, double alpha, double offset, sn_mesh *out, sn_error *error);
/* Edges of about edge_length all over an oriented manifold (Botsch, Kobbelt 2004); attributes follow by closest point. SN_ERROR_USAGE
 * where that would take more than ten million triangles, or so few that no surface would be left. Triangles at vertices that are held
 * (vertex_count; NULL = none) are left as they are, here and in the steps below; only their outer edges are split or shortened here. */
SN_MUST_CHECK sn_status sn_remesh(sn_mesh *mesh, double edge_length, const bool *held, sn_error *error);
/* Rounds of smoothing by uniform weights, a step in and a step out (Taubin 1995, lambda 0.5, mu -0.53). Borders, and
 * vertices that are held, stay where they are. */
SN_MUST_CHECK sn_status sn_smooth(sn_mesh *mesh, sn_index rounds, const bool *held, sn_error *error);
/* Move a closed surface along its normals until it encloses `volume` again, by a tenth of the mean edge at most. */
SN_MUST_CHECK sn_status sn_restore_volume(sn_mesh *mesh, double volume, sn_error *error);
/* Slivers, triangles with a quality (sn_mesh_report) below SN_SLIVER_QUALITY, are flipped away where the surface stays what it is: the
 * normals of the two triangles on their longest edge turn by less than 5 degrees. Vertices stay. */
SN_MUST_CHECK sn_status sn_flip_slivers(sn_mesh *mesh, const bool *held, sn_index *flipped, sn_error *error);
/* Values painted on vertices and groups of triangles of `from` to `to`, which lies near it, by closest point: numbers are interpolated,
 * integers (labels, colours) taken from the nearest corner. `to` has none yet, or those of `from` in their order. */
SN_MUST_CHECK sn_status sn_carry_attributes(const sn_mesh *from, sn_mesh *to, sn_error *error);
/* Quadric edge collapse to at most target_triangles; attributes follow by closest point. */
SN_MUST_CHECK sn_status sn_decimate(sn_mesh *mesh, sn_index target_triangles, const bool *held, sn_error *error);
/* Flip components so that each encloses positive volume (a closed component inside another stays as it is if it is a cavity). */
SN_MUST_CHECK sn_status sn_orient_outward(sn_mesh *mesh, sn_index *flipped, sn_error *error);
/* Number of pairs of triangles that cross (CGAL; exact predicates on the coordinates as they are): that meet in more than the corners and
 * edges that they share. Vertices at one place are one corner here: where a surface touches itself it does not cross itself. */
SN_MUST_CHECK sn_status sn_count_self_intersections(const sn_mesh *mesh, sn_index *pairs, sn_error *error);
/* The same, given up with *pairs = SN_NONE after looking at most_tests pairs whose boxes meet (0 = any number); and, in crosses
 * (triangle_count, nullable, set to false before), the triangles of pairs of which one is `made` (triangle_count; nullable = any). */
SN_MUST_CHECK sn_status sn_find_self_intersections(const sn_mesh *mesh, int64_t most_tests, const bool *made, bool *crosses,
                                                   sn_index *pairs, sn_error *error);
/* Triangles that `old` has none of: is_new (triangle_count of mesh). Corners are compared by place, in any order. */
SN_MUST_CHECK sn_status sn_find_new_triangles(const sn_mesh *old, const sn_mesh *mesh, bool *is_new, sn_error *error);

typedef struct sn_undo_params {
    const sn_mesh *before; /* what the mesh was made of */
    double most_area;      /* of `before` that may be lost, by sn_lost_area with this reach */
    double reach;
} sn_undo_params;
/* Cut triangles that `before` does not have out of a closed oriented manifold where they cross any, with what they cross, and fill the
 * holes anew, wider and wider, until none is left; no vertex that stays moves. A cut is taken only where it leaves fewer crossings, as many
 * components, no more handles, and the volume within 5 %. *left is how many pairs there are. */
SN_MUST_CHECK sn_status sn_undo_crossings(sn_mesh *mesh, const sn_undo_params *params, sn_index *left, sn_error *error);
/* Replace triangles that cross in a closed oriented manifold (CGAL, experimental there): in a child process, ended after `seconds` of
 * processor time. The mesh is changed only where the result is a closed oriented manifold with fewer crossings; *left is what remains,
 * *ended_early tells that the time was up. Attributes follow by closest point. */
SN_MUST_CHECK sn_status sn_remove_self_intersections(sn_mesh *mesh, double seconds, sn_index *left, bool *ended_early, sn_error *error);
/* Area of triangles of `from` that `to` has lost: centres farther than `reach` from its surface, and not inside it. */
SN_MUST_CHECK sn_status sn_lost_area(const sn_mesh *from, const sn_mesh *to, double reach, double *out, sn_error *error);
/* Greatest distance of a sample of `from` (vertices and triangle centres) to the surface of `to`, exact closest points. */
SN_MUST_CHECK sn_status sn_one_sided_distance(const sn_mesh *from, const sn_mesh *to, double *out, sn_error *error);

/* ---- surface queries (lib/geom/embree.c) ---------------------------------------------------------------------------- */

typedef struct sn_surface sn_surface;

typedef struct sn_closest {
    sn_index triangle; /* SN_NONE = nothing within reach */
    double barycentric[3];
    sn_vec3 point;
    double distance;
} sn_closest;

typedef struct sn_ray_hit {
    sn_index triangle; /* SN_NONE = missed */
    double u, v;       /* barycentric of corners 1 and 2 */
    double distance;   /* along the unit direction */
} sn_ray_hit;

/* A search structure over mesh (which must outlive it and keep still). */
SN_MUST_CHECK sn_status sn_surface_create(const sn_mesh *mesh, sn_surface **out, sn_error *error);
/* The same for closest points and rays only: cheaper, because nobody asks whether the surface closes or crosses itself. Its signed
 * distance is never negative, and it does not know that it is closed. */
SN_MUST_CHECK sn_status sn_surface_create_plain(const sn_mesh *mesh, sn_surface **out, sn_error *error);
void sn_surface_destroy(sn_surface *surface); /* NULL is fine */
/* Exact (double) closest point within max_distance (INFINITY = any); ties go to the lowest triangle. Thread safe. */
sn_closest sn_surface_closest(const sn_surface *surface, sn_vec3 point, double max_distance);
/* Signed distance, negative inside: angle-weighted pseudonormals on closed pieces (Baerentzen & Aanaes 2005), winding number on open ones
 * and on those that cross themselves. Overlapping pieces are one body; inside out counts as right side out. Thread safe. */
double sn_surface_signed_distance(const sn_surface *surface, sn_vec3 point, sn_closest *closest /* nullable */);
/* First hit with near < t < far, in double; ties go to the lowest triangle, and no ray slips through between two that share an edge. Thread
 * safe. */
sn_ray_hit sn_surface_ray(const sn_surface *surface, sn_vec3 origin, sn_vec3 direction, double near, double far);

/* ---- inside/outside without a search structure (lib/geom/winding.c) ------------------------------------------------- */

/* Generalised winding number of a point (Jacobson 2013): about 1 inside, 0 outside, also on open meshes. O(triangles). */
double sn_winding_number(const sn_mesh *mesh, sn_vec3 point);
/* Closest point on a triangle. */
sn_vec3 sn_closest_on_triangle(sn_vec3 point, sn_vec3 a, sn_vec3 b, sn_vec3 c, double barycentric[3]);

/* ---- fields on a surface (lib/geom/field.c eigen.c distance.c geodesic.c) ------------------------------------------------ */

/* What a field is to be at some vertices. */
typedef struct sn_fixed_values {
    sn_index count;
    const sn_index *vertices; /* (count) */
    const double *values;     /* (count) finite */
} sn_fixed_values;

/* The weight of an edge in the cotangent Laplacian: w = (cot alpha + cot beta) / 2 over the angles opposite to it, kept within 1e-3 and
 * 1e3. What flows along an edge (i, j) of a field u is w (u_i - u_j). */
double sn_edge_weight(const sn_mesh *mesh, const sn_edge *edge);
/* Harmonic field u (vertex_count) with u = value at the fixed vertices: cotangent Laplacian, weights clamped below at 1e-3.
 * Vertices of components without a fixed vertex get NaN. */
SN_MUST_CHECK sn_status sn_harmonic_field(const sn_mesh *mesh, const sn_topology *topology, const sn_fixed_values *fixed, double *u,
                                          sn_error *error);
/* The Fiedler eigenfunction of the cotangent Laplacian of a surface of one component: its extremes are the far ends of the shape. On entry
 * u (vertex_count) is where the iteration starts, not constant; its sign decides that of the result. */
SN_MUST_CHECK sn_status sn_fiedler_field(const sn_mesh *mesh, const sn_topology *topology, double *u, sn_error *error);
/* Shortest distance along edges from a set of source vertices (Dijkstra). distance (vertex_count), unreached = INFINITY. */
SN_MUST_CHECK sn_status sn_edge_distance(const sn_mesh *mesh, const sn_topology *topology, sn_index source_count, const sn_index *sources,
                                         double *distance, sn_error *error);
/* Distance along the surface from a set of source vertices by fast marching (Kimmel, Sethian 1998): exact on flat pieces from a straight
 * line of sources; unlike edge distance it hardly depends on the mesh. distance (vertex_count), unreached = INFINITY. No vertex but a
 * source lies lower than all its neighbours. */
SN_MUST_CHECK sn_status sn_geodesic_distance(const sn_mesh *mesh, const sn_topology *topology, sn_index source_count,
                                             const sn_index *sources, double *distance, sn_error *error);

/* ---- paths over a surface (lib/geom/surface_path.c) -------------------------------------------------------------------- */

/* A piece of a path: straight, within one triangle, between two points of it. */
typedef struct sn_path_segment {
    sn_index triangle;
    sn_index edge; /* that it leaves the triangle by, into the next segment's; SN_NONE for the last */
    sn_vec3 from, to;
} sn_path_segment;

typedef struct sn_surface_path {
    sn_index count;
    sn_path_segment *segments; /* (count) */
    double length;
} sn_surface_path;

/* Finds short paths on one mesh, one after the other; mesh and topology must outlive it. */
typedef struct sn_path_finder sn_path_finder;
SN_MUST_CHECK sn_status sn_path_finder_create(const sn_mesh *mesh, const sn_topology *topology, sn_path_finder **out, sn_error *error);
void sn_path_finder_destroy(sn_path_finder *finder); /* NULL is fine */
/* A nearly shortest path from one point of the surface to another: the shortest of those that cross edges at a few points inside each
 * (Lanthier, Maheshwari & Sack 1997, with A*), straightened within its triangles; at most 1 % too long on a sheet. It never runs through
 * a vertex: every vertex is on one side of it. `turn` shifts the points, so that paths of different turn share none, and meet only by
 * crossing. No way there: SN_ERROR_INPUT. *out is the caller's. */
SN_MUST_CHECK sn_status sn_path_find(sn_path_finder *finder, const sn_closest *from, const sn_closest *to, sn_index turn,
                                     sn_surface_path *out, sn_error *error);
void sn_surface_path_free(sn_surface_path *path);

#endif
