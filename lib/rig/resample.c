/* resample.c -- from fronts to evenly spaced samples, and every surface vertex on one of them ([R18] 3.1, "re-sample" and "connect"). */
#include <stdlib.h>

#include "tree.h"

/* More samples than this are a spacing in the wrong unit. */
#define MAX_SAMPLES 1000000

sn_status structure_alloc(sn_index samples, sn_index vertices, sn_structure *out, sn_error *error) {
    *out = (sn_structure){0};
    out->positions = SN_NEW(sn_vec3, samples);
    out->parents = SN_NEW(sn_index, samples);
    out->branches = SN_NEW(sn_index, samples);
    out->axes = SN_NEW(sn_vec3, samples);
    out->vertex_sample = SN_NEW(sn_index, vertices);
    if (!out->positions || !out->parents || !out->branches || !out->axes || !out->vertex_sample) {
        sn_structure_free(out);
        return sn_fail_memory(error, "the internal structure");
    }
    for (sn_index v = 0; v < vertices; v++) out->vertex_sample[v] = SN_NONE;
    return SN_OK;
}

sn_index number_branches(const tree *t, sn_index *branch, sn_index *children) {
    for (sn_index f = 0; f < t->count; f++) children[f] = 0;
    for (sn_index f = 1; f < t->count; f++) children[t->parent[f]]++;
    sn_index count = 0;
    for (sn_index f = 0; f < t->count; f++) branch[f] = f > 0 && children[t->parent[f]] == 1 ? branch[t->parent[f]] : count++;
    return count;
}

sn_status tree_as_structure(const tree *t, sn_structure *out, sn_error *error) {
    sn_index *children = SN_NEW(sn_index, t->count);
    sn_status status = children ? structure_alloc(t->count, t->mesh->vertex_count, out, error) : sn_fail_memory(error, "the branches");
    if (!status) {
        number_branches(t, out->branches, children);
        for (sn_index f = 0; f < t->count; f++) {
            out->positions[f] = tree_position(t, f);
            out->parents[f] = t->parent[f];
        }
        for (sn_index v = 0; v < t->mesh->vertex_count; v++) out->vertex_sample[v] = t->front[v];
        out->sample_count = t->count;
    }
    free(children);
    return status;
}

/* ---- branches as polylines --------------------------------------------------------------------------------------------- */

typedef struct branch {
    sn_index split; /* the parent branch; SN_NONE for branch 0 */
    sn_index front_count;
    sn_index first_front; /* into resampling.fronts; the polyline starts at the split's front before them, if there is one */
    sn_index first_sample, sample_count;
    double length; /* from the split to the end, through the fronts' samples */
} branch;

typedef struct resampling {
    const tree *tree;
    double spacing;
    sn_trace *trace;
    sn_structure *out;
    sn_index branch_count;
    branch *branches;    /* (branch_count) */
    sn_index *branch_of; /* (fronts) */
    sn_index *fronts;    /* (fronts) by branch, from the root's side outwards */
    sn_index *by_branch; /* (vertex_count) vertices by branch */
    sn_index *start;     /* (branch_count + 1) into by_branch */
} resampling;

static sn_status resampling_alloc(resampling *r, sn_error *error) {
    size_t fronts = (size_t)r->tree->count;
    sn_index *children = SN_NEW(sn_index, fronts);
    r->branch_of = SN_NEW(sn_index, fronts);
    r->fronts = SN_NEW(sn_index, fronts);
    r->by_branch = SN_NEW(sn_index, r->tree->mesh->vertex_count);
    bool enough = children && r->branch_of && r->fronts && r->by_branch;
    if (enough) {
        r->branch_count = number_branches(r->tree, r->branch_of, children);
        r->branches = SN_NEW(branch, r->branch_count);
        r->start = SN_NEW(sn_index, (size_t)r->branch_count + 1);
        enough = r->branches && r->start;
    }
    free(children);
    return enough ? SN_OK : sn_fail_memory(error, "the branches of the structure");
}

static void resampling_free(resampling *r) {
    free(r->branches);
    free(r->branch_of);
    free(r->fronts);
    free(r->by_branch);
    free(r->start);
}

static void list_fronts(resampling *r) {
    const tree *t = r->tree;
    for (sn_index f = 0; f < t->count; f++) r->branches[r->branch_of[f]].front_count++;
    for (sn_index b = 0, sum = 0; b < r->branch_count; b++) {
        r->branches[b].first_front = sum;
        sum += r->branches[b].front_count;
        r->branches[b].front_count = 0;
    }
    for (sn_index f = 0; f < t->count; f++) {
        branch *b = &r->branches[r->branch_of[f]];
        if (b->front_count == 0) b->split = f == 0 ? SN_NONE : r->branch_of[t->parent[f]];
        r->fronts[b->first_front + b->front_count++] = f;
    }
}

static void list_vertices(resampling *r) {
    const tree *t = r->tree;
    for (sn_index v = 0; v < t->mesh->vertex_count; v++) r->start[r->branch_of[t->front[v]] + 1]++;
    for (sn_index b = 0; b < r->branch_count; b++) r->start[b + 1] += r->start[b];
    for (sn_index v = 0; v < t->mesh->vertex_count; v++) r->by_branch[r->start[r->branch_of[t->front[v]]]++] = v;
    for (sn_index b = r->branch_count; b > 0; b--) r->start[b] = r->start[b - 1];
    r->start[0] = 0;
}

/* Point i of the branch's polyline: the split's sample first, where there is one. */
static sn_index polyline_count(const branch *b) { return b->front_count + (b->split != SN_NONE); }
static sn_vec3 polyline_point(const resampling *r, const branch *b, sn_index i) {
    if (b->split == SN_NONE) return tree_position(r->tree, r->fronts[b->first_front + i]);
    sn_index first = r->fronts[b->first_front];
    return tree_position(r->tree, i == 0 ? r->tree->parent[first] : r->fronts[b->first_front + i - 1]);
}

/* Branch 0 keeps the root as its first sample; other branches begin one step from their split's last one. */
static sn_status measure_branches(resampling *r, sn_error *error) {
    double total = 0.0;
    for (sn_index i = 0; i < r->branch_count; i++) {
        branch *b = &r->branches[i];
        for (sn_index k = 1; k < polyline_count(b); k++) b->length += sn_distance(polyline_point(r, b, k - 1), polyline_point(r, b, k));
        double steps = polyline_count(b) < 2 ? 0.0 : fmax(1.0, ceil(b->length / r->spacing));
        total += steps;
        if (!(total < MAX_SAMPLES))
            return sn_fail(error, SN_ERROR_USAGE,
                           "a spacing of %g gives more than %d samples; give a larger one, or a unit with it (as in 6mm)", r->spacing,
                           MAX_SAMPLES);
        b->sample_count = (sn_index)steps + (i == 0);
        b->first_sample = i == 0 ? 0 : b[-1].first_sample + b[-1].sample_count;
    }
    return SN_OK;
}

static bool trace_branches(const resampling *r) {
    for (sn_index i = 0; i < r->branch_count; i++) {
        const branch *b = &r->branches[i];
        if (SN_TRACE(r->trace, "branch", sn_trace_number("branch", i), sn_trace_number("parent", b->split),
                     sn_trace_number("length", b->length), sn_trace_indices("fronts", r->fronts + b->first_front, b->front_count)))
            return true;
    }
    return false;
}

/* ---- samples ------------------------------------------------------------------------------------------------------------ */

static void place_samples(const resampling *r, const branch *b, sn_index number) {
    sn_structure *out = r->out;
    sn_index steps = b->sample_count - (number == 0), at = 1;
    double before = 0.0; /* arc length of polyline point at - 1 */
    for (sn_index k = 0; k < b->sample_count; k++) {
        sn_index sample = b->first_sample + k, step = k + (number != 0);
        const branch *split = k == 0 && b->split != SN_NONE ? &r->branches[b->split] : NULL;
        out->parents[sample] = split ? split->first_sample + split->sample_count - 1 : sample - 1; /* -1 = none at the root */
        out->branches[sample] = number;
        double target = steps > 0 ? b->length * step / steps : 0.0;
        sn_index last = polyline_count(b) - 1;
        while (at < last && before + sn_distance(polyline_point(r, b, at - 1), polyline_point(r, b, at)) < target) {
            before += sn_distance(polyline_point(r, b, at - 1), polyline_point(r, b, at));
            at++;
        }
        if (step == steps || last == 0) {
            out->positions[sample] = polyline_point(r, b, last); /* exactly: the branches below start here */
            continue;
        }
        sn_vec3 from = polyline_point(r, b, at - 1), to = polyline_point(r, b, at);
        double segment = sn_distance(from, to);
        out->positions[sample] = sn_lerp(from, to, segment > 0.0 ? fmin(1.0, (target - before) / segment) : 0.0);
    }
    out->sample_count += b->sample_count;
}

static bool resample_branches(const resampling *r) {
    for (sn_index i = 0; i < r->branch_count; i++) {
        const branch *b = &r->branches[i];
        place_samples(r, b, i);
        if (SN_TRACE(r->trace, "resample", sn_trace_number("branch", i), sn_trace_number("first_sample", b->first_sample),
                     sn_trace_number("samples", b->sample_count)))
            return true;
    }
    return false;
}

/* ---- connections ---------------------------------------------------------------------------------------------------------- */

static void offer(const sn_structure *s, sn_vec3 point, sn_index sample, sn_index *best, double *best_distance) {
    double distance = sn_norm2(sn_sub(s->positions[sample], point));
    if (*best != SN_NONE && !(distance < *best_distance)) return;
    *best = sample;
    *best_distance = distance;
}

/* The nearest sample of the branch or of its split; ties to the lower. Roots alone in branch 0 stay with the root. */
static sn_index nearest_sample(const resampling *r, const branch *b, sn_vec3 point) {
    sn_index best = SN_NONE;
    double best_distance = 0.0;
    if (b->split != SN_NONE) {
        const branch *split = &r->branches[b->split];
        offer(r->out, point, split->first_sample + split->sample_count - 1, &best, &best_distance);
    }
    for (sn_index k = 0; k < b->sample_count; k++) offer(r->out, point, b->first_sample + k, &best, &best_distance);
    return best;
}

static bool connect_branches(const resampling *r) {
    for (sn_index i = 0; i < r->branch_count; i++) {
        for (sn_index k = r->start[i]; k < r->start[i + 1]; k++) {
            sn_index v = r->by_branch[k];
            r->out->vertex_sample[v] = nearest_sample(r, &r->branches[i], r->tree->mesh->positions[v]);
        }
        if (SN_TRACE(r->trace, "connect", sn_trace_number("branch", i),
                     sn_trace_indices("vertices", r->by_branch + r->start[i], r->start[i + 1] - r->start[i])))
            return true;
    }
    return false;
}

/* ---- all together ----------------------------------------------------------------------------------------------------------- */

static sn_status replace_fronts(resampling *r, sn_error *error) {
    list_fronts(r);
    list_vertices(r);
    sn_status status = measure_branches(r, error);
    if (status) return status;
    if (trace_branches(r)) {
        status = tree_as_structure(r->tree, r->out, error);
        return status ? status : SN_STOPPED;
    }
    const branch *last = &r->branches[r->branch_count - 1];
    status = structure_alloc(last->first_sample + last->sample_count, r->tree->mesh->vertex_count, r->out, error);
    if (status) return status;
    return resample_branches(r) || connect_branches(r) ? SN_STOPPED : SN_OK;
}

sn_status resample_tree(const tree *t, double spacing, sn_trace *trace, sn_structure *out, sn_error *error) {
    resampling r = {.tree = t, .spacing = spacing, .trace = trace, .out = out};
    *out = (sn_structure){0};
    sn_status status = resampling_alloc(&r, error);
    if (!status) status = replace_fronts(&r, error);
    resampling_free(&r);
    return status;
}
