/*
 * tendon_map.c -- tendon told from muscle by thickness.
 *
 * A section is thin where its area is below a share of its belly's: of the widest section, shared out to the branches where the muscle
 * splits, in proportion to the widest section of each; so the digits of a flat muscle are not thin, and the four tendons of an extensor
 * are. A thin part is tendon where it is long for its width; a rounded tip and the corner of a sheet are thin, too, but short. What hangs
 * on a tendon away from the belly is tendon as well (it may widen into a bone), unless a second belly does.
 */
#include "levels.h"

#include <stdlib.h>

#define SECOND_BELLY 0.5 /* of the first: a digastric muscle has two */

typedef struct walk {
    const levels *l;
    sn_index count;    /* nodes reached */
    sn_index *order;   /* (count) parents before children */
    sn_index *parent;  /* (node_count) SN_NONE for the first; nodes not reached are their own */
    sn_index *above;   /* (node_count) the next loop on the way to the belly; SN_NONE = none */
    double *widest;    /* (node_count) area of the widest loop from here on */
    double *shares;    /* (node_count) sum of that over its children */
    double *belly;     /* (node_count) what its area is compared with */
    sn_index *run;     /* (loop_count) union-find of thin loops */
    sn_index *extent;  /* (2 x loop_count) lowest and highest level of a run */
    double *width;     /* (loop_count) sum of half perimeters of a run */
    sn_index *members; /* (loop_count) loops of a run */
} walk;

static void walk_free(walk *w) {
    free(w->order);
    free(w->parent);
    free(w->above);
    free(w->widest);
    free(w->shares);
    free(w->belly);
    free(w->run);
    free(w->extent);
    free(w->width);
    free(w->members);
}

static sn_status walk_alloc(walk *w, sn_error *error) {
    size_t nodes = (size_t)w->l->node_count + 1, loops = (size_t)w->l->loop_count + 1;
    w->order = SN_NEW(sn_index, nodes);
    w->parent = SN_NEW(sn_index, nodes);
    w->above = SN_NEW(sn_index, nodes);
    w->widest = SN_NEW(double, nodes);
    w->shares = SN_NEW(double, nodes);
    w->belly = SN_NEW(double, nodes);
    w->run = SN_NEW(sn_index, loops);
    w->extent = SN_NEW(sn_index, 2 * loops);
    w->width = SN_NEW(double, loops);
    w->members = SN_NEW(sn_index, loops);
    bool made = w->order != NULL && w->parent != NULL && w->above != NULL && w->widest != NULL && w->shares != NULL && w->belly != NULL;
    made = made && w->run != NULL && w->extent != NULL && w->width != NULL && w->members != NULL;
    return made ? SN_OK : sn_fail_memory(error, "the tendons of the muscle");
}

static bool is_loop(const walk *w, sn_index node) { return node < w->l->loop_count; }

static sn_index widest_loop(const levels *l) {
    sn_index best = 0;
    for (sn_index i = 1; i < l->loop_count; i++)
        if (l->loops[i].area > l->loops[best].area) best = i;
    return best;
}

/* Every node by the shortest way from the belly. */
static void spread(walk *w, sn_index belly) {
    const levels *l = w->l;
    for (sn_index i = 0; i < l->node_count; i++) w->parent[i] = i;
    w->order[w->count++] = belly;
    w->parent[belly] = w->above[belly] = SN_NONE;
    for (sn_index i = 0; i < w->count; i++) {
        sn_index node = w->order[i];
        for (sn_index k = l->link_start[node]; k < l->link_start[node + 1]; k++) {
            sn_index next = l->links[k];
            if (w->parent[next] != next) continue;
            w->parent[next] = node;
            w->above[next] = is_loop(w, node) ? node : w->above[node];
            w->order[w->count++] = next;
        }
    }
}

static void compare_with_bellies(walk *w) {
    for (sn_index i = w->count - 1; i >= 0; i--) {
        sn_index node = w->order[i], parent = w->parent[node];
        if (is_loop(w, node)) w->widest[node] = fmax(w->widest[node], w->l->loops[node].area);
        if (parent == SN_NONE) continue;
        w->widest[parent] = fmax(w->widest[parent], w->widest[node]);
        w->shares[parent] += w->widest[node];
    }
    for (sn_index i = 0; i < w->count; i++) {
        sn_index node = w->order[i], parent = w->parent[node];
        double own = is_loop(w, node) ? w->l->loops[node].area : 0.0;
        bool splits = parent != SN_NONE && parent != w->order[0] && w->shares[parent] > 0.0; /* the first goes on to both sides */
        double share = splits ? w->widest[node] / w->shares[parent] : 1.0;
        w->belly[node] = fmax(own, parent != SN_NONE ? share * w->belly[parent] : 0.0);
    }
}

static sn_index find(sn_index *link, sn_index i) {
    while (link[i] != i) i = link[i] = link[link[i]];
    return i;
}

static void join_runs(walk *w, double thin, bool *is_thin) {
    const levels *l = w->l;
    for (sn_index i = 0; i < l->loop_count; i++) w->run[i] = i;
    for (sn_index i = 0; i < w->count; i++) {
        sn_index node = w->order[i];
        if (!is_loop(w, node)) continue;
        is_thin[node] = l->loops[node].area < thin * w->belly[node];
        sn_index above = w->above[node];
        if (is_thin[node] && above != SN_NONE && is_thin[above]) w->run[find(w->run, node)] = find(w->run, above);
    }
}

/* Is the run long for its width? */
static bool is_long(const walk *w, sn_index run, double slender) {
    double length = (w->extent[2 * run + 1] - w->extent[2 * run] + 1) * w->l->step;
    return w->members[run] > 0 && length >= slender * w->width[run] / w->members[run];
}

static void measure_runs(walk *w, const bool *is_thin) {
    const levels *l = w->l;
    for (sn_index i = 0; i < l->loop_count; i++) {
        if (!is_thin[i]) continue;
        sn_index run = find(w->run, i), level = l->loops[i].level;
        if (w->members[run]++ == 0) w->extent[2 * run] = w->extent[2 * run + 1] = level;
        if (level < w->extent[2 * run]) w->extent[2 * run] = level;
        if (level > w->extent[2 * run + 1]) w->extent[2 * run + 1] = level;
        w->width[run] += 0.5 * l->loops[i].perimeter;
    }
}

sn_status levels_find_tendons(const levels *l, double thin, double slender, double *loop, sn_error *error) {
    walk w = {.l = l};
    bool *is_thin = SN_NEW(bool, (size_t)l->loop_count + 1);
    sn_status status = is_thin != NULL ? walk_alloc(&w, error) : sn_fail_memory(error, "the tendons of the muscle");
    for (sn_index i = 0; i < l->loop_count; i++) loop[i] = 0.0;
    if (status == SN_OK && l->loop_count > 0) {
        spread(&w, widest_loop(l));
        compare_with_bellies(&w);
        join_runs(&w, thin, is_thin);
        measure_runs(&w, is_thin);
        for (sn_index i = 0; i < w.count; i++) {
            sn_index node = w.order[i];
            if (!is_loop(&w, node)) continue;
            bool hangs = w.above[node] != SN_NONE && loop[w.above[node]] > 0.0 && w.widest[node] < SECOND_BELLY * w.belly[node];
            if (hangs || (is_thin[node] && is_long(&w, find(w.run, node), slender))) loop[node] = 1.0;
        }
    }
    free(is_thin);
    walk_free(&w);
    return status;
}
