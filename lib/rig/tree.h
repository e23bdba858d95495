/*
 * tree.h -- the traversal tree of [R18] 3.1: fronts of surface vertices, each with a sample at their mean. Private to lib/rig.
 *
 * Traversal makes it, pruning thins it, resampling replaces it. Traversal is one choice among possible ones; what follows only asks that
 * parents come before children and that every vertex is in exactly one front.
 */
#ifndef SINEW_RIG_TREE_H
#define SINEW_RIG_TREE_H

#include "sinew/mesh.h"
#include "sinew/muscle.h"
#include "sinew/trace.h"

typedef struct tree {
    const sn_mesh *mesh;
    const sn_topology *topology;
    sn_vec3 origin;   /* sums are relative to it: far from 0 they would cancel */
    sn_index count;   /* fronts; never more than vertices, which is what every array has room for */
    sn_index *parent; /* (count) SN_NONE for the root, which is front 0 */
    sn_index *depth;  /* (count) links from the root */
    sn_index *size;   /* (count) vertices in it; 0 = pruned away */
    sn_index *first;  /* (count) its first vertex, SN_NONE = empty */
    sn_index *last;   /* (count) its last vertex */
    sn_vec3 *sum;     /* (count) of its vertices' positions relative to origin */
    double *sum2;     /* (count) of their squares */
    sn_index *front;  /* (vertex_count) the front that holds each vertex; SN_NONE = not visited */
    sn_index *next;   /* (vertex_count) the next vertex of the same front */
} tree;

SN_MUST_CHECK sn_status tree_create(const sn_mesh *mesh, const sn_topology *topology, tree *out, sn_error *error);
void tree_free(tree *t);

/* A new front of these vertices under parent; returns its index. */
sn_index tree_add_front(tree *t, sn_index parent, sn_index count, const sn_index *vertices);
sn_vec3 tree_position(const tree *t, sn_index front); /* mean of its vertices */
double tree_radius(const tree *t, sn_index front);    /* root mean square distance of its vertices from their mean */
void tree_compact(tree *t);                           /* drop empty fronts; the others keep their order */

/* Traverse by hops: F0 = roots; the unvisited neighbours of all fronts fall into connected components, each a new front, child of the one
 * it shares most edges with (ties to the lower index). Trace stage "front". lib/rig/traverse.c */
SN_MUST_CHECK sn_status traverse_hops(tree *t, const sn_roots *roots, sn_trace *trace, sn_error *error);

/* Take away branches, lowest first, while height < max(least_height, radius of the front at their split): their vertices join the sibling.
 * The last branch on a side of the roots stays. Height is along the surface: how much farther from the roots it reaches than its split.
 * Trace stage "prune". Leaves empty fronts. lib/rig/prune.c */
SN_MUST_CHECK sn_status prune_tree(tree *t, const sn_roots *roots, double least_height, sn_trace *trace, sn_index *pruned, sn_error *error);

/* Branch number of every front (count): a front continues the branch of its parent where it is the only child. Returns how many; branch 0
 * has the root and parents' branches come first. children (count) is set too: how many each front has. */
sn_index number_branches(const tree *t, sn_index *branch, sn_index *children);

/* Replace the fronts by samples at equal steps of arc length, at most `spacing`, along each branch, and hang every vertex on the nearest
 * sample of its branch or of the branch's split. Trace stages "branch", "resample", "connect". lib/rig/resample.c */
SN_MUST_CHECK sn_status resample_tree(const tree *t, double spacing, sn_trace *trace, sn_structure *out, sn_error *error);

/* The tree as it stands, one sample a front: what a stopped run leaves. */
SN_MUST_CHECK sn_status tree_as_structure(const tree *t, sn_structure *out, sn_error *error);

/* Room for `samples` of a structure over `vertices`, all vertices unconnected. */
SN_MUST_CHECK sn_status structure_alloc(sn_index samples, sn_index vertices, sn_structure *out, sn_error *error);

/* How often the closed surface winds around each point: 1 inside, 0 outside. lib/rig/inside.c */
SN_MUST_CHECK sn_status count_windings(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, int *winding, sn_error *error);

#endif
