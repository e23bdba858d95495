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

/* new_index (vertex_count): the place of each vertex, ascending over the first of each place; SN_NONE = dropped. Triangles must not
 * use a dropped vertex. `count` places in all. */
void sn_mesh_renumber(sn_mesh *mesh, const sn_index *new_index, sn_index count);

/* Representative of every point: the lowest representative within `tolerance` (0 = exactly equal), or the point itself where there
 * is none. Representatives are therefore farther apart than tolerance. */
SN_MUST_CHECK sn_status sn_find_representatives(const sn_mesh *mesh, double tolerance, sn_index *representative, sn_error *error);

/* The order of triangles in which those with the same three vertices, in any order, follow one another, lowest first: order and
 * triples (triangle_count); triples are ascending. */
SN_MUST_CHECK sn_status sn_sort_triples(const sn_mesh *mesh, sn_index *order, sn_triangle *triples, sn_error *error);
bool sn_same_triple(sn_triangle a, sn_triangle b);

/* inverted (component_count): true where a component must be flipped to enclose positive volume; one inside others that is wound
 * the other way round is a cavity and stays. */
SN_MUST_CHECK sn_status sn_find_inverted(const sn_mesh *mesh, sn_index component_count, const sn_index *component, bool *inverted,
                                         sn_error *error);

/* Drop fins and walls inside (sn_make_manifold); counts their triangles. */
SN_MUST_CHECK sn_status sn_drop_walls(sn_mesh *mesh, sn_index *dropped, sn_error *error);

#endif
