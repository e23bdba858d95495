/*
 * edit.h -- taking elements out of a mesh with all that hangs on them, and what counts as degenerate; private to lib/geom.
 */
#ifndef SINEW_GEOM_EDIT_H
#define SINEW_GEOM_EDIT_H

#include "sinew/mesh.h"

/* A triangle whose height is below this share of its longest edge has no usable normal. */
#define SN_DEGENERATE_HEIGHT 1e-12

bool sn_triangle_repeats_index(sn_triangle triangle);
bool sn_triangle_is_degenerate(const sn_mesh *mesh, sn_triangle triangle); /* a repeated index or no area */

/* 4 sqrt(3) area / (a^2 + b^2 + c^2): 1 for an equilateral triangle, 0 for a degenerate one. */
double sn_triangle_quality(sn_vec3 a, sn_vec3 b, sn_vec3 c);
int sn_triangle_longest_edge(const sn_mesh *mesh, sn_triangle triangle); /* by its opposite corner; the first of equal ones */

/* new_index (vertex_count): the place of each vertex, ascending over the first of each place; SN_NONE = dropped. Triangles must not
 * use a dropped vertex. `count` places in all. */
void sn_mesh_renumber(sn_mesh *mesh, const sn_index *new_index, sn_index count);

/* Representative of every point: the lowest representative within `tolerance` (0 = exactly equal), or the point itself where there
 * is none. Representatives are therefore farther apart than tolerance. */
SN_MUST_CHECK sn_status sn_find_representatives(const sn_mesh *mesh, double tolerance, sn_index *representative, sn_error *error);

/* Each vertex's representative becomes the representative's new number, in place (sn_mesh_renumber); returns how many there are. A
 * representative stands for itself and has the lowest index of its cluster. */
sn_index sn_number_representatives(sn_index count, sn_index *map);
/* Drop triangles that name a vertex twice. */
SN_MUST_CHECK sn_status sn_drop_collapsed(sn_mesh *mesh, sn_error *error);
/* Room for more vertices and triangles, with attributes and groups; the counts stay. false = out of memory. */
bool sn_mesh_make_room(sn_mesh *mesh, sn_index vertices, sn_index triangles);
/* Give `to` zeroed attributes and the groups of `from`, no triangle in any yet; false = out of memory. */
bool sn_mesh_copy_names(const sn_mesh *from, sn_mesh *to);

/* The order of triangles in which those with the same three vertices, in any order, follow one another, lowest first: order and
 * triples (triangle_count); triples are ascending. */
SN_MUST_CHECK sn_status sn_sort_triples(const sn_mesh *mesh, sn_index *order, sn_triangle *triples, sn_error *error);
bool sn_same_triple(sn_triangle a, sn_triangle b);

/* inverted (component_count): true where a component must be flipped to enclose positive volume; one inside others that is wound
 * the other way round is a cavity and stays. */
SN_MUST_CHECK sn_status sn_find_inverted(const sn_mesh *mesh, sn_index component_count, const sn_index *component, bool *inverted,
                                         sn_error *error);

/* The part of sn_mesh_inspect that says whether a surface is a manifold, and no more: edges, boundary, non-manifold and inconsistent ones,
 * loops, non-manifold vertices. A third of the time. SN_ERROR_INPUT where the mesh is not valid. */
SN_MUST_CHECK sn_status sn_mesh_look_at_edges(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error);

/* Drop fins and walls inside (sn_make_manifold); counts their triangles. */
SN_MUST_CHECK sn_status sn_drop_walls(sn_mesh *mesh, sn_index *dropped, sn_error *error);

#endif
