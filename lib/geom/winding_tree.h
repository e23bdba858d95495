/*
 * winding_tree.h -- winding numbers of many points, in about logarithmic time each. Private to lib/geom.
 */
#ifndef SINEW_WINDING_TREE_H
#define SINEW_WINDING_TREE_H

#include "sinew/mesh.h"

/* Solid angle, in steradians, of the triangle (a,b,c) seen from the origin: positive where it turns its back. 0 from its own plane. */
double sn_solid_angle(sn_vec3 a, sn_vec3 b, sn_vec3 c);

/* Triangles in the order of a space-filling curve, and what clusters of consecutive ones look like from afar. */
typedef struct sn_winding_tree {
    const sn_mesh *mesh;
    struct sn_cluster *clusters; /* (1 << (depth + 1)) a binary heap: cluster 1 holds all triangles, 2i and 2i + 1 the halves of i */
    int depth;                   /* of the leaves */
} sn_winding_tree;

/* Sorts the triangles of mesh, which must outlive the tree and keep still. An empty mesh is fine. */
SN_MUST_CHECK sn_status sn_winding_tree_build(sn_mesh *mesh, sn_winding_tree *out, sn_error *error);
void sn_winding_tree_free(sn_winding_tree *tree);
/* The winding number: exact within 0.1 of n + 1/2, where it decides, and elsewhere to about 0.02. */
double sn_winding_tree_number(const sn_winding_tree *tree, sn_vec3 point);

#endif
