/*
 * tree.h -- the traversal tree of [R18] 3.1: fronts of the surface, each with a sample at its centre. Private to lib/rig.
 *
 * A traversal makes it (hops.c: vertices an edge at a time; slabs.c: faces cut by levels of distance), pruning thins it, resampling
 * replaces it. What follows a traversal only asks that parents come before children and that every vertex is in exactly one front. A front
 * need not hold a vertex: slabs of a coarse mesh may lie within its triangles.
 */
#ifndef SINEW_RIG_TREE_H
#define SINEW_RIG_TREE_H

#include "sinew/geom.h"
#include "sinew/muscle.h"

typedef struct tree {
    const sn_mesh *mesh;
    const sn_topology *topology;
    sn_vec3 origin;       /* sums are relative to it: far from 0 they would cancel */
    double *distance;     /* (vertex_count) along the surface from the roots */
    sn_index *part;       /* (vertex_count) connected part of the surface without the roots, by its lowest vertex; SN_INDEX_MAX = a root */
    sn_index *front;      /* (vertex_count) the front that holds each vertex; SN_NONE = not visited */
    sn_index *next;       /* (vertex_count) the next vertex of the same front */
    sn_index count;       /* fronts; never more than the capacity the tree was reserved for */
    sn_index *parent;     /* (count) SN_NONE for the root, which is front 0 */
    sn_index *depth;      /* (count) links from the root */
    sn_index *side;       /* (count) the part it is in; SN_INDEX_MAX for the root */
    sn_index *first;      /* (count) its first vertex, SN_NONE = none */
    sn_index *last;       /* (count) its last vertex */
    double *weight;       /* (count) its vertices' number, or its area; 0 = pruned away */
    sn_vec3 *sum;         /* (count) weight times position relative to origin */
    double *sum2;         /* (count) weight times its square */
    double *distance_sum; /* (count) weight times distance */
    double *reach;        /* (count) greatest distance in it */
} tree;

/* A tree over the surface with distances and parts; room for fronts comes with tree_reserve. lib/rig/tree.c */
SN_MUST_CHECK sn_status tree_create(const sn_mesh *mesh, const sn_topology *topology, const sn_roots *roots, tree *out, sn_error *error);
SN_MUST_CHECK sn_status tree_reserve(tree *t, sn_index fronts, sn_error *error);
void tree_free(tree *t);

sn_index tree_add_front(tree *t, sn_index parent);              /* an empty front; returns its index */
void tree_add_vertex(tree *t, sn_index front, sn_index vertex); /* list it there: weighs nothing */
sn_vec3 tree_position(const tree *t, sn_index front);           /* weighted mean */
double tree_radius(const tree *t, sn_index front);              /* root mean square distance from that mean */
void tree_compact(tree *t);                                     /* drop pruned fronts; the others keep their order */

/* Traverse by hops ([R18] to the letter): F0 = roots; the unvisited neighbours of all fronts fall into connected components, each a new
 * front, child of the one it shares most edges with (ties to the lower index). Trace stage "front". lib/rig/hops.c */
SN_MUST_CHECK sn_status traverse_hops(tree *t, const sn_roots *roots, sn_trace *trace, sn_error *error);

/* Traverse by slabs: faces cut by levels of the distance from the roots `step` apart; each connected slab is a front, child of the slab it
 * touches towards the roots: the Reeb tree of the distance. Trace stage "slab". lib/rig/slabs.c */
SN_MUST_CHECK sn_status traverse_slabs(tree *t, double step, sn_trace *trace, sn_error *error);

/* Take away branches, lowest first, while height < max(least_height, radius of the front at their split): their vertices join the sibling.
 * The last branch on a side of the roots stays. Height is along the surface: how much farther from the roots it reaches than its split.
 * Trace stage "prune". Leaves pruned fronts with weight 0. lib/rig/prune.c */
SN_MUST_CHECK sn_status prune_tree(tree *t, double least_height, sn_trace *trace, sn_index *pruned, sn_error *error);

/* Branch number of every front (count): a front continues the branch of its parent where it is the only child. Returns how many; branch 0
 * has the root and parents' branches come first. children (count) is set too: how many each front has. */
sn_index number_branches(const tree *t, sn_index *branch, sn_index *children);

/* What moves points that lie outside the volume to its middle; all zeros does nothing. */
typedef struct inside_step {
    const sn_mesh *mesh; /* NULL = leave points where they are */
    double reach;        /* go no deeper than this */
    sn_trace *trace;     /* stage "inside", a step for each point moved */
    sn_surface *surface; /* made when the first point is found outside; inside_step_free ends it */
    sn_index moved;
} inside_step;

/* Move each of the points that is outside to mid-thickness: from its closest surface point half-way to the other side, or less far where
 * that is outside too. lib/rig/inside.c */
SN_MUST_CHECK sn_status move_inside(inside_step *step, sn_index count, sn_vec3 *points, sn_error *error);
void inside_step_free(inside_step *step);

/* Replace the fronts by samples at equal steps of arc length, at most `spacing`, along each branch, move those inside that are not, and
 * hang every vertex on the nearest sample of its branch or of the branch's split. Trace stages "branch", "resample", "inside", "connect".
 * lib/rig/resample.c */
SN_MUST_CHECK sn_status resample_tree(const tree *t, double spacing, inside_step *inside, sn_trace *trace, sn_structure *out,
                                      sn_error *error);

/* The tree as it stands, one sample a front: what a stopped run leaves. */
SN_MUST_CHECK sn_status tree_as_structure(const tree *t, sn_structure *out, sn_error *error);

/* Room for `samples` of a structure over `vertices`, all vertices unconnected. */
SN_MUST_CHECK sn_status structure_alloc(sn_index samples, sn_index vertices, sn_structure *out, sn_error *error);

/* +1 or -1 where the triangle lies over or under q, seen along z, and faces up or down; else 0. Neighbours agree on which of them has a
 * point of their common edge. lib/rig/windings.c */
int triangle_over(const sn_mesh *mesh, sn_triangle t, sn_vec3 q);

/* How often the closed surface winds around each point: 1 inside, 0 outside. lib/rig/windings.c */
SN_MUST_CHECK sn_status count_windings(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, int *winding, sn_error *error);

#endif
