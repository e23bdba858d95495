/*
 * prune.c -- take twigs off the traversal tree, lowest first.
 *
 * Fronts one edge wide fall apart at every irregularity of the mesh; what falls off and dies within the thickness of the muscle is no
 * branch of its own. Height is measured along the surface from the roots, so that a zigzag of samples does not make a twig look long.
 */
#include <stdlib.h>

#include "tree.h"

/* A branch stands out by more than this many radii of its split. With 1.1, 251 of 253 real muscles keep their number of leaves at four
 * densities of their mesh; with 1.0, 247; with 1.2, 250. */
#define LEAST_RADII 1.1

/* A branch that ends in a leaf, named by its first front. */
typedef struct twig {
    double height;
    sn_index start;
} twig;

typedef struct pruning {
    tree *tree;
    sn_trace *trace;
    double least_height;
    sn_index *children; /* (count) */
    sn_index *child;    /* (count) first child */
    sn_index *sibling;  /* (count) next child of the same parent */
    double *reach;      /* (count) greatest distance in the subtree */
    sn_index *votes;    /* (count) all 0 between uses */
    twig *heap;         /* (count) lowest first, then lowest index */
    twig *kept;         /* (count) too high when they were looked at */
    sn_index heap_count, kept_count, pruned;
} pruning;

/* ---- setting up --------------------------------------------------------------------------------------------------------- */

static bool pruning_alloc(pruning *p) {
    size_t fronts = (size_t)p->tree->count;
    p->children = SN_NEW(sn_index, fronts);
    p->child = SN_NEW(sn_index, fronts);
    p->sibling = SN_NEW(sn_index, fronts);
    p->reach = SN_NEW(double, fronts);
    p->votes = SN_NEW(sn_index, fronts);
    p->heap = SN_NEW(twig, 2 * fronts); /* every merge adds one, every front merges once at most */
    p->kept = SN_NEW(twig, 2 * fronts);
    return p->children && p->child && p->sibling && p->reach && p->votes && p->heap && p->kept;
}

static void pruning_free(pruning *p) {
    free(p->children);
    free(p->child);
    free(p->sibling);
    free(p->reach);
    free(p->votes);
    free(p->heap);
    free(p->kept);
}

static void link_children(pruning *p) {
    tree *t = p->tree;
    for (sn_index f = 0; f < t->count; f++) p->child[f] = p->sibling[f] = SN_NONE;
    for (sn_index f = t->count - 1; f > 0; f--) { /* from behind, so that the lists ascend */
        sn_index parent = t->parent[f];
        p->sibling[f] = p->child[parent];
        p->child[parent] = f;
        p->children[parent]++;
    }
}

static void measure_reach(pruning *p) {
    tree *t = p->tree;
    for (sn_index f = t->count - 1; f >= 0; f--) {
        p->reach[f] = fmax(p->reach[f], t->reach[f]);
        if (f > 0) p->reach[t->parent[f]] = fmax(p->reach[t->parent[f]], p->reach[f]);
    }
}

/* ---- the heap of twigs ---------------------------------------------------------------------------------------------------- */

static bool comes_before(twig a, twig b) { return a.height < b.height || (a.height == b.height && a.start < b.start); }

static void push_twig(pruning *p, twig item) {
    sn_index i = p->heap_count++;
    for (; i > 0 && comes_before(item, p->heap[(i - 1) / 2]); i = (i - 1) / 2) p->heap[i] = p->heap[(i - 1) / 2];
    p->heap[i] = item;
}

static twig pop_twig(pruning *p) {
    twig first = p->heap[0], last = p->heap[--p->heap_count];
    sn_index i = 0;
    for (sn_index c = 1; c < p->heap_count; c = 2 * i + 1) {
        if (c + 1 < p->heap_count && comes_before(p->heap[c + 1], p->heap[c])) c++;
        if (!comes_before(p->heap[c], last)) break;
        p->heap[i] = p->heap[c];
        i = c;
    }
    p->heap[i] = last;
    return first;
}

/* The first front of the branch that f is in: just below a split, or below the root. SN_NONE for the root. */
static sn_index branch_start(const pruning *p, sn_index f) {
    if (f == 0) return SN_NONE;
    while (p->tree->parent[f] != 0 && p->children[p->tree->parent[f]] == 1) f = p->tree->parent[f];
    return f;
}

static double twig_height(const pruning *p, sn_index start) {
    sn_index split = p->tree->parent[start];
    return p->reach[start] - p->tree->distance_sum[split] / p->tree->weight[split];
}

static void add_twig(pruning *p, sn_index leaf) {
    sn_index start = branch_start(p, leaf);
    if (start != SN_NONE) push_twig(p, (twig){twig_height(p, start), start});
}

/* ---- pruning one ----------------------------------------------------------------------------------------------------------- */

/* May `other` take in the vertices of `start`? Both hang on the same split; at the roots also on the same side of them. */
static bool is_partner(const pruning *p, sn_index start, sn_index other) {
    return other != start && (p->tree->parent[start] != 0 || p->tree->side[other] == p->tree->side[start]);
}

static bool has_partner(const pruning *p, sn_index start) {
    for (sn_index c = p->child[p->tree->parent[start]]; c != SN_NONE; c = p->sibling[c])
        if (is_partner(p, start, c)) return true;
    return false;
}

/* Which child of `split` front f descends from; SN_NONE if from none. */
static sn_index climb(const tree *t, sn_index f, sn_index split) {
    while (t->depth[f] > t->depth[split] + 1) f = t->parent[f];
    return f != split && t->parent[f] == split ? f : SN_NONE;
}

/* Edges between the twig and the subtrees of its siblings, counted into votes (clear = false) or cleared. */
static void vote(pruning *p, sn_index start, bool clear) {
    const tree *t = p->tree;
    const sn_topology *topology = t->topology;
    sn_index split = t->parent[start];
    for (sn_index f = start; f != SN_NONE; f = p->child[f])
        for (sn_index v = t->first[f]; v != SN_NONE; v = t->next[v])
            for (sn_index k = topology->vertex_start[v]; k < topology->vertex_start[v + 1]; k++) {
                sn_index c = climb(t, t->front[topology->neighbours[k]], split);
                if (c == SN_NONE || c == start) continue;
                p->votes[c] = clear ? 0 : p->votes[c] + 1;
            }
}

/* The sibling that shares most edges with the twig, then the one nearest to it, then the lowest. */
static sn_index choose_partner(pruning *p, sn_index start) {
    const tree *t = p->tree;
    sn_index best = SN_NONE;
    double best_distance = 0.0;
    vote(p, start, false);
    for (sn_index c = p->child[t->parent[start]]; c != SN_NONE; c = p->sibling[c]) {
        if (!is_partner(p, start, c)) continue;
        double distance = sn_distance(tree_position(t, c), tree_position(t, start));
        if (best == SN_NONE || p->votes[c] > p->votes[best] || (p->votes[c] == p->votes[best] && distance < best_distance)) {
            best = c;
            best_distance = distance;
        }
    }
    vote(p, start, true);
    return best;
}

static sn_index nearest_child(const pruning *p, sn_index front, sn_vec3 point) {
    sn_index best = SN_NONE;
    double best_distance = 0.0;
    for (sn_index c = p->child[front]; c != SN_NONE; c = p->sibling[c]) {
        double distance = sn_distance(tree_position(p->tree, c), point);
        if (best == SN_NONE || distance < best_distance) {
            best = c;
            best_distance = distance;
        }
    }
    return best;
}

static void join_front(pruning *p, sn_index from, sn_index to) {
    tree *t = p->tree;
    for (sn_index v = t->first[from]; v != SN_NONE; v = t->next[v]) t->front[v] = to;
    if (t->first[to] == SN_NONE)
        t->first[to] = t->first[from];
    else if (t->first[from] != SN_NONE)
        t->next[t->last[to]] = t->first[from];
    if (t->last[from] != SN_NONE) t->last[to] = t->last[from];
    t->first[from] = t->last[from] = SN_NONE;
    t->weight[to] += t->weight[from];
    t->sum[to] = sn_add(t->sum[to], t->sum[from]);
    t->sum2[to] += t->sum2[from];
    t->distance_sum[to] += t->distance_sum[from];
    t->weight[from] = 0.0;
    p->reach[to] = fmax(p->reach[to], p->reach[from]);
}

static void unlink_child(pruning *p, sn_index child) {
    sn_index parent = p->tree->parent[child], *link = &p->child[parent];
    while (*link != child) link = &p->sibling[*link];
    *link = p->sibling[child];
    p->children[parent]--;
}

/* Walk down the twig and the partner side by side; each front of the twig joins the one beside it. */
static void join_twig(pruning *p, sn_index start, sn_index partner) {
    unlink_child(p, start);
    sn_index to = partner;
    for (sn_index f = start; f != SN_NONE;) {
        sn_index below = p->child[f];
        join_front(p, f, to);
        f = below;
        if (f == SN_NONE) break;
        sn_index onwards = nearest_child(p, to, tree_position(p->tree, f));
        if (onwards != SN_NONE) to = onwards;
    }
}

/* Where a split has become a bend, the branch below it that ends in a leaf now starts higher. */
static void add_merged_twig(pruning *p, sn_index split) {
    if (split == 0 || p->children[split] != 1) return;
    sn_index f = split;
    while (p->children[f] == 1) f = p->child[f];
    if (p->children[f] == 0) add_twig(p, f);
}

static bool prune_twig(pruning *p, twig item) {
    sn_index split = p->tree->parent[item.start], partner = choose_partner(p, item.start);
    join_twig(p, item.start, partner);
    p->pruned++;
    add_merged_twig(p, split);
    return SN_TRACE(p->trace, "prune", sn_trace_number("branch", item.start), sn_trace_number("split", split),
                    sn_trace_number("height", item.height), sn_trace_number("joins", partner));
}

/* ---- all of them ------------------------------------------------------------------------------------------------------------ */

/* Branches that have merged since they were put aside are there again, longer. */
static bool is_current(const pruning *p, sn_index start) { return p->tree->weight[start] > 0.0 && branch_start(p, start) == start; }

static bool is_low(const pruning *p, twig item) {
    sn_index split = p->tree->parent[item.start];
    return item.height < fmax(p->least_height, LEAST_RADII * tree_radius(p->tree, split)) && has_partner(p, item.start);
}

/* One pass over the heap; what is too high is put aside, since its split may still grow. */
static sn_status prune_pass(pruning *p) {
    p->kept_count = 0;
    while (p->heap_count > 0) {
        twig item = pop_twig(p);
        if (!is_current(p, item.start)) continue;
        item.height = twig_height(p, item.start); /* what has joined it or its split since may have changed it */
        if (!is_low(p, item))
            p->kept[p->kept_count++] = item;
        else if (prune_twig(p, item))
            return SN_STOPPED;
    }
    return SN_OK;
}

static sn_status prune_all(pruning *p) {
    for (sn_index f = 0; f < p->tree->count; f++)
        if (p->children[f] == 0) add_twig(p, f);
    for (sn_index before = -1; before != p->pruned;) {
        before = p->pruned;
        sn_status status = prune_pass(p);
        if (status) return status;
        for (sn_index i = 0; i < p->kept_count; i++) push_twig(p, p->kept[i]);
    }
    return SN_OK;
}

sn_status prune_tree(tree *t, double least_height, sn_trace *trace, sn_index *pruned, sn_error *error) {
    pruning p = {.tree = t, .trace = trace, .least_height = least_height};
    sn_status status = pruning_alloc(&p) ? SN_OK : sn_fail_memory(error, "the pruning of the structure");
    if (!status) {
        link_children(&p);
        measure_reach(&p);
        status = prune_all(&p);
    }
    *pruned = p.pruned;
    pruning_free(&p);
    return status;
}
