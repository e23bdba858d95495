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
    inside_step *inside;
    sn_trace *trace;
    sn_structure *out;
    sn_index branch_count;
    branch *branches;    /* (branch_count) */
    sn_index *branch_of; /* (fronts) */
    sn_index *fronts;    /* (fronts) by branch, from the root's side outwards */
    sn_vec3 *centres;    /* (fronts) */
    sn_index *by_branch; /* (vertex_count) vertices by branch */
    sn_index *start;     /* (branch_count + 1) into by_branch */
    sn_index sample_count;
    size_t sample_capacity;
    sn_vec3 *samples; /* (sample_count) by branch */
} resampling;

static sn_status resampling_alloc(resampling *r, sn_error *error) {
    size_t fronts = (size_t)r->tree->count;
    sn_index *children = SN_NEW(sn_index, fronts);
    r->branch_of = SN_NEW(sn_index, fronts);
    r->fronts = SN_NEW(sn_index, fronts);
    r->centres = SN_NEW(sn_vec3, fronts);
    r->by_branch = SN_NEW(sn_index, r->tree->mesh->vertex_count);
    bool enough = children && r->branch_of && r->fronts && r->centres && r->by_branch;
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
    free(r->centres);
    free(r->by_branch);
    free(r->start);
    free(r->samples);
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
    if (b->split == SN_NONE) return r->centres[r->fronts[b->first_front + i]];
    sn_index first = r->fronts[b->first_front];
    return r->centres[i == 0 ? r->tree->parent[first] : r->fronts[b->first_front + i - 1]];
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

/* Equal steps of arc length along the branch's polyline; its end exactly, since the branches below start there. */
static void place_samples(resampling *r, const branch *b, sn_index number) {
    sn_index steps = b->sample_count - (number == 0), at = 1, last = polyline_count(b) - 1;
    double before = 0.0; /* arc length of polyline point at - 1 */
    for (sn_index k = 0; k < b->sample_count; k++) {
        sn_index step = k + (number != 0);
        double target = steps > 0 ? b->length * step / steps : 0.0;
        while (at < last && before + sn_distance(polyline_point(r, b, at - 1), polyline_point(r, b, at)) < target) {
            before += sn_distance(polyline_point(r, b, at - 1), polyline_point(r, b, at));
            at++;
        }
        if (step == steps || last == 0) {
            r->samples[r->sample_count++] = polyline_point(r, b, last);
            continue;
        }
        sn_vec3 from = polyline_point(r, b, at - 1), to = polyline_point(r, b, at);
        double segment = sn_distance(from, to);
        r->samples[r->sample_count++] = sn_lerp(from, to, segment > 0.0 ? fmin(1.0, (target - before) / segment) : 0.0);
    }
}

static sn_status resample_branches(resampling *r, sn_error *error) {
    size_t total = 0;
    for (sn_index i = 0; i < r->branch_count; i++) total += (size_t)r->branches[i].sample_count;
    if (!sn_grow((void **)&r->samples, &r->sample_capacity, total, sizeof *r->samples)) return sn_fail_memory(error, "the samples");
    bool stop = false;
    for (sn_index i = 0; i < r->branch_count && !stop; i++) {
        branch *b = &r->branches[i];
        b->first_sample = r->sample_count;
        place_samples(r, b, i);
        stop = SN_TRACE(r->trace, "resample", sn_trace_number("branch", i), sn_trace_number("first_sample", b->first_sample),
                        sn_trace_number("samples", b->sample_count));
        if (stop) r->branch_count = i + 1;
    }
    return stop ? SN_STOPPED : SN_OK;
}

/* ---- inside, and close again ------------------------------------------------------------------------------------------------ */

/* What sample k of a branch hangs on: the one before it, or the last of the branch's split. SN_NONE for the root. */
static sn_index sample_parent(const resampling *r, const branch *b, sn_index k) {
    if (k > 0 || b->split == SN_NONE) return b->first_sample + k - 1;
    const branch *split = &r->branches[b->split];
    return split->first_sample + split->sample_count - 1;
}

/* How many samples it takes between sample k of the branch and its parent to bring them near enough. */
static sn_index missing_between(const resampling *r, const branch *b, sn_index k) {
    sn_index parent = sample_parent(r, b, k);
    if (parent == SN_NONE) return 0;
    double steps = ceil(sn_distance(r->samples[b->first_sample + k], r->samples[parent]) / (r->spacing * (1.0 + 1e-12)));
    return steps > 1.0 ? (sn_index)fmin(steps - 1.0, MAX_SAMPLES) : 0;
}

static sn_index count_missing(const resampling *r) {
    double total = 0.0;
    for (sn_index i = 0; i < r->branch_count; i++)
        for (sn_index k = 0; k < r->branches[i].sample_count; k++) total += missing_between(r, &r->branches[i], k);
    return (sn_index)fmin(total, MAX_SAMPLES);
}

/* Copy all samples to `wider`, with new ones at equal steps in links that are too long; the new ones are moved inside. */
static sn_status widen(resampling *r, sn_index missing, sn_vec3 *wider, sn_vec3 *added, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < r->branch_count; i++)
        for (sn_index k = 0; k < r->branches[i].sample_count; k++) {
            const branch *b = &r->branches[i];
            sn_index parent = sample_parent(r, b, k), between = missing_between(r, b, k);
            for (sn_index n = 1; n <= between; n++)
                added[count++] = sn_lerp(r->samples[parent], r->samples[b->first_sample + k], n / (between + 1.0));
        }
    sn_status status = move_inside(r->inside, missing, added, error);
    if (status) return status;
    sn_index to = 0;
    count = 0;
    sn_index *between = SN_NEW(sn_index, r->sample_count); /* before the samples are renumbered */
    if (!between) return sn_fail_memory(error, "the samples");
    for (sn_index i = 0, s = 0; i < r->branch_count; i++)
        for (sn_index k = 0; k < r->branches[i].sample_count; k++) between[s++] = missing_between(r, &r->branches[i], k);
    for (sn_index i = 0; i < r->branch_count; i++) {
        branch *b = &r->branches[i];
        sn_index first = to, from = b->first_sample;
        for (sn_index k = 0; k < b->sample_count; k++) {
            for (sn_index n = 0; n < between[from + k]; n++) wider[to++] = added[count++];
            wider[to++] = r->samples[from + k];
        }
        b->first_sample = first;
        b->sample_count = to - first;
    }
    free(between);
    return SN_OK;
}

/* A sample that has moved may be too far from its parent: put others between, until none is. Where two arms of a fold face each other the
 * way between them is outside and no number of samples closes it: after some rounds it stays. */
enum { MAX_ROUNDS = 3 };

static sn_status close_links(resampling *r, sn_error *error) {
    for (int round = 0; round < MAX_ROUNDS; round++) {
        sn_index missing = count_missing(r);
        if (missing == 0 || missing > MAX_SAMPLES - r->sample_count) return SN_OK;
        sn_vec3 *wider = SN_NEW(sn_vec3, (size_t)r->sample_count + (size_t)missing), *added = SN_NEW(sn_vec3, missing);
        sn_status status = wider && added ? widen(r, missing, wider, added, error) : sn_fail_memory(error, "the samples");
        free(added);
        if (status) {
            free(wider);
            return status;
        }
        free(r->samples);
        r->samples = wider;
        r->sample_count += missing;
    }
    return SN_OK;
}

static sn_status bring_inside(resampling *r, sn_error *error) {
    if (!r->inside->mesh) return SN_OK;
    sn_status status = move_inside(r->inside, r->sample_count, r->samples, error);
    return status ? status : close_links(r, error);
}

/* ---- the structure ------------------------------------------------------------------------------------------------------------ */

static sn_status write_samples(const resampling *r, sn_error *error) {
    sn_status status = structure_alloc(r->sample_count, r->tree->mesh->vertex_count, r->out, error);
    if (status) return status;
    for (sn_index i = 0; i < r->branch_count; i++) {
        const branch *b = &r->branches[i];
        for (sn_index k = 0; k < b->sample_count; k++) {
            sn_index sample = b->first_sample + k;
            r->out->positions[sample] = r->samples[sample];
            r->out->parents[sample] = sample_parent(r, b, k);
            r->out->branches[sample] = i;
        }
    }
    r->out->sample_count = r->sample_count;
    return SN_OK;
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

static sn_status stop_at_fronts(const resampling *r, sn_error *error) {
    sn_status status = tree_as_structure(r->tree, r->out, error);
    return status ? status : SN_STOPPED;
}

static sn_status replace_fronts(resampling *r, sn_error *error) {
    list_fronts(r);
    list_vertices(r);
    for (sn_index f = 0; f < r->tree->count; f++) r->centres[f] = tree_position(r->tree, f);
    sn_status status = move_inside(r->inside, r->tree->count, r->centres, error);
    if (status == SN_STOPPED) return stop_at_fronts(r, error);
    if (!status) status = measure_branches(r, error);
    if (status) return status;
    if (trace_branches(r)) return stop_at_fronts(r, error);
    status = resample_branches(r, error);
    if (!status) status = bring_inside(r, error);
    if (status && status != SN_STOPPED) return status;
    sn_status written = write_samples(r, error);
    if (status || written) return written ? written : status;
    return connect_branches(r) ? SN_STOPPED : SN_OK;
}

sn_status resample_tree(const tree *t, double spacing, inside_step *inside, sn_trace *trace, sn_structure *out, sn_error *error) {
    resampling r = {.tree = t, .spacing = spacing, .inside = inside, .trace = trace, .out = out};
    *out = (sn_structure){0};
    sn_status status = resampling_alloc(&r, error);
    if (!status) status = replace_fronts(&r, error);
    resampling_free(&r);
    return status;
}
