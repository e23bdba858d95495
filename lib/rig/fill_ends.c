/* fill_ends.c -- where fibres begin and end: attachment areas, given vertices, or the tips of the structure's leaves. */
#include <stdlib.h>

#include "ends.h"
#include "fill.h"

#define CAP_SHARE 0.01 /* of the box diagonal: a tip is a cap of that radius; at a single vertex the field is singular */
#define NEAR_TIPS 0.6  /* of the surface's length */

static void add_end(fill_ends *out, char *taken, sn_index vertex, double value) {
    if (taken[vertex]) return;
    taken[vertex] = 1;
    out->vertices[out->count] = vertex;
    out->values[out->count++] = value;
}

static bool has_both(const fill_ends *out) {
    bool low = false, high = false;
    for (sn_index i = 0; i < out->count; i++) {
        low |= out->values[i] == 0.0;
        high |= out->values[i] == 1.0;
    }
    return low && high;
}

/* What the search works on. */
typedef struct search {
    const sn_muscle *muscle;
    const sn_topology *topology;
    char *taken;    /* (vertex_count) */
    sn_index *work; /* (vertex_count) */
    double *u;      /* (vertex_count) */
    sn_index tip_count;
    sn_index *tips;   /* (tip_count) vertices */
    sn_index *leaves; /* (tip_count) samples, or SN_NONE */
    double *sides;    /* (tip_count) 0 or 1 */
} search;

static bool search_alloc(search *s) {
    sn_index vertices = s->muscle->mesh.vertex_count, most = s->muscle->structure.sample_count + 2;
    s->taken = SN_NEW(char, vertices);
    s->work = SN_NEW(sn_index, vertices);
    s->u = SN_NEW(double, vertices);
    s->tips = SN_NEW(sn_index, most);
    s->leaves = SN_NEW(sn_index, most);
    s->sides = SN_NEW(double, most);
    return s->taken && s->work && s->u && s->tips && s->leaves && s->sides;
}

static void search_free(search *s) {
    free(s->taken);
    free(s->work);
    free(s->u);
    free(s->tips);
    free(s->leaves);
    free(s->sides);
}

/* ---- tips ----------------------------------------------------------------------------------------------------------------- */

/* The vertex of a leaf that reaches farthest beyond its parent; SN_NONE where no vertex hangs on it. */
static sn_index leaf_tip(const sn_muscle *m, sn_index leaf) {
    const sn_structure *s = &m->structure;
    sn_vec3 from = s->positions[s->parents[leaf]], along = sn_sub(s->positions[leaf], from);
    sn_index best = SN_NONE;
    double farthest = -INFINITY;
    for (sn_index v = 0; v < m->mesh.vertex_count; v++) {
        if (s->vertex_sample[v] != leaf) continue;
        double reach = sn_dot(sn_sub(m->mesh.positions[v], from), along);
        if (reach <= farthest) continue;
        farthest = reach;
        best = v;
    }
    return best;
}

static void find_leaves(search *s) {
    const sn_structure *t = &s->muscle->structure;
    for (sn_index i = 1; i < t->sample_count; i++) {
        bool leaf = true;
        for (sn_index k = i + 1; k < t->sample_count && leaf; k++) leaf = t->parents[k] != i;
        sn_index tip = leaf ? leaf_tip(s->muscle, i) : SN_NONE;
        if (tip == SN_NONE) continue;
        s->leaves[s->tip_count] = i;
        s->tips[s->tip_count++] = tip;
    }
}

/* Sides of the roots: 0 for the part of the surface that holds the first tip, 1 for the other; false where they do not part it in two. */
static bool sides_of_roots(search *s) {
    const sn_topology *t = s->topology;
    const sn_roots *roots = &s->muscle->roots;
    if (roots->count == 0 || s->tip_count == 0) return false;
    for (sn_index v = 0; v < t->vertex_count; v++) s->taken[v] = 0;
    for (sn_index i = 0; i < roots->count; i++) s->taken[roots->vertices[i]] = 1;
    if (s->taken[s->tips[0]]) return false;
    sn_index top = 0;
    s->work[top++] = s->tips[0];
    s->taken[s->tips[0]] = 2;
    while (top > 0) {
        sn_index v = s->work[--top];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (s->taken[w]) continue;
            s->taken[w] = 2;
            s->work[top++] = w;
        }
    }
    bool both = false;
    for (sn_index i = 0; i < s->tip_count; i++) {
        s->sides[i] = s->taken[s->tips[i]] == 2 ? 0.0 : 1.0;
        both |= s->sides[i] == 1.0;
    }
    return both;
}

/* The surface's own two ends. */
static sn_status surface_ends(const search *s, sn_trace *trace, tips *two, sn_error *error) {
    surface_survey survey;
    sn_status status = survey_surface(&s->muscle->mesh, s->topology, &survey, error);
    sn_index seed = s->muscle->roots.count > 0 ? s->muscle->roots.vertices[0] : survey.main_vertex;
    return status ? status : find_tips(&s->muscle->mesh, s->topology, seed, trace, two, error);
}

/* Sides by the field between the two ends of the surface; a side without leaves has that end for its tip. */
static sn_status sides_of_ends(search *s, const tips *two, sn_error *error) {
    const double values[2] = {0.0, 1.0};
    sn_status status = sn_harmonic_field(&s->muscle->mesh, s->topology, &(sn_fixed_values){2, two->end, values}, s->u, error);
    if (status) return status;
    bool both[2] = {false, false};
    for (sn_index i = 0; i < s->tip_count; i++) {
        s->sides[i] = s->u[s->tips[i]] < 0.5 ? 0.0 : 1.0;
        both[s->sides[i] == 1.0] = true;
    }
    for (int k = 0; k < 2; k++) {
        if (both[k]) continue;
        s->leaves[s->tip_count] = SN_NONE;
        s->sides[s->tip_count] = values[k];
        s->tips[s->tip_count++] = two->end[k];
    }
    return SN_OK;
}

/* How far apart the tips of the two sides are, straight. */
static double tip_distance(const search *s) {
    double farthest = 0.0;
    for (sn_index i = 0; i < s->tip_count; i++)
        for (sn_index k = 0; k < i; k++)
            if (s->sides[i] != s->sides[k])
                farthest = fmax(farthest, sn_distance(s->muscle->mesh.positions[s->tips[i]], s->muscle->mesh.positions[s->tips[k]]));
    return farthest;
}

/* On a sheet the roots may part its faces, and then the tips are no ends: tips much nearer to each other, along the surface, than its own
 * ends give way to these. */
static sn_status doubt_tips(search *s, sn_trace *trace, sn_error *error) {
    if (tip_distance(s) >= NEAR_TIPS * sn_box_diagonal(sn_mesh_box(&s->muscle->mesh))) return SN_OK;
    tips two;
    sn_status status = surface_ends(s, trace, &two, error);
    double farthest = 0.0;
    for (sn_index i = 0; i < s->tip_count && !status; i++) {
        if (s->sides[i] != 0.0) continue;
        status = sn_edge_distance(&s->muscle->mesh, s->topology, 1, &s->tips[i], s->u, error);
        for (sn_index k = 0; k < s->tip_count && !status; k++)
            if (s->sides[k] != 0.0 && isfinite(s->u[s->tips[k]])) farthest = fmax(farthest, s->u[s->tips[k]]);
    }
    if (status || farthest >= NEAR_TIPS * two.length) return status;
    for (s->tip_count = 0; s->tip_count < 2; s->tip_count++) {
        s->leaves[s->tip_count] = SN_NONE;
        s->tips[s->tip_count] = two.end[s->tip_count];
        s->sides[s->tip_count] = s->tip_count;
    }
    return SN_OK;
}

/* The vertices around a tip, connected, within the cap's radius. */
static void add_cap(const search *s, sn_index tip, double value, double radius, fill_ends *out) {
    const sn_topology *t = s->topology;
    const sn_vec3 *p = s->muscle->mesh.positions;
    if (s->taken[tip]) return;
    sn_index first = out->count;
    add_end(out, s->taken, tip, value);
    for (sn_index i = first; i < out->count; i++) {
        sn_index v = out->vertices[i];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++)
            if (sn_distance(p[t->neighbours[k]], p[tip]) <= radius) add_end(out, s->taken, t->neighbours[k], value);
    }
}

static sn_status cap_tips(search *s, fill_ends *out, const bool *skip, sn_trace *trace) {
    double radius = CAP_SHARE * sn_box_diagonal(sn_mesh_box(&s->muscle->mesh));
    for (sn_index i = 0; i < s->tip_count; i++) {
        if (skip && skip[i]) continue;
        add_cap(s, s->tips[i], s->sides[i], radius, out);
        if (SN_TRACE(trace, "tip", sn_trace_number("vertex", s->tips[i]), sn_trace_number("value", s->sides[i]))) return SN_STOPPED;
    }
    return SN_OK;
}

static sn_status find_tip_ends(search *s, sn_trace *trace, fill_ends *out, sn_error *error) {
    if (s->muscle->structure.sample_count > 1) find_leaves(s);
    sn_status status = SN_OK;
    if (sides_of_roots(s)) {
        status = doubt_tips(s, trace, error);
    } else {
        tips two;
        status = surface_ends(s, trace, &two, error);
        if (!status) status = sides_of_ends(s, &two, error);
    }
    if (status) return status;
    for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) s->taken[v] = 0;
    out->leaves = s->tip_count;
    out->kind = SN_FILL_ENDS_TIPS;
    return cap_tips(s, out, NULL, trace);
}

/* ---- attachments ------------------------------------------------------------------------------------------------------------ */

/* A leaf is served where an attached vertex of its end hangs on its branch. */
static void find_served(const search *s, const fill_ends *out, bool *served) {
    const sn_structure *t = &s->muscle->structure;
    for (sn_index i = 0; i < s->tip_count; i++)
        for (sn_index k = 0; k < out->count && !served[i]; k++) {
            if (out->values[k] != s->sides[i]) continue;
            sn_index sample = t->sample_count > 0 ? t->vertex_sample[out->vertices[k]] : SN_NONE;
            served[i] = s->leaves[i] == SN_NONE || (sample != SN_NONE && t->branches[sample] == t->branches[s->leaves[i]]);
        }
}

/* Which way round the tips' sides are, by the field between the known ends. */
static sn_status turn_sides(search *s, const ends *known, sn_error *error) {
    const sn_fixed_values fixed = {known->count, known->vertices, known->values};
    sn_status status = sn_harmonic_field(&s->muscle->mesh, s->topology, &fixed, s->u, error);
    for (sn_index i = 0; i < s->tip_count && !status; i++) s->sides[i] = s->u[s->tips[i]] >= 0.5;
    return status;
}

/* The known ends; where they were found only, leaves that they do not serve keep their tips. */
static sn_status take_known(search *s, const ends *known, fill_ends *out, sn_trace *trace, sn_error *error) {
    bool *served = SN_NEW(bool, (size_t)s->tip_count + 1);
    sn_status status = served ? turn_sides(s, known, error) : sn_fail_memory(error, "the ends of the fibres");
    if (!status) {
        out->count = 0;
        for (sn_index v = 0; v < s->muscle->mesh.vertex_count; v++) s->taken[v] = 0;
        for (sn_index i = 0; i < known->count; i++) add_end(out, s->taken, known->vertices[i], known->values[i]);
        out->kind = SN_FILL_ENDS_ATTACHMENTS;
        find_served(s, out, served);
        for (sn_index i = 0; i < s->tip_count && known->choice.source != SN_ENDS_ATTACHMENTS; i++) served[i] = true;
        status = cap_tips(s, out, served, trace);
    }
    free(served);
    return status;
}

/* What every tool takes for the ends (ends_choose); tips are those of the structure's leaves. */
static sn_status find_best(search *s, fill_ends *out, sn_trace *trace, sn_error *error) {
    surface_survey survey;
    tips shape;
    ends known;
    sn_status status = ends_alloc(s->muscle->mesh.vertex_count, &known, error);
    if (!status) status = survey_surface(&s->muscle->mesh, s->topology, &survey, error);
    if (!status) status = find_tips(&s->muscle->mesh, s->topology, survey.main_vertex, NULL, &shape, error);
    const ends_surface surface = {&s->muscle->mesh, s->topology, &shape};
    if (!status) status = ends_choose(&surface, s->muscle, 0, NULL, &known, error);
    bool attached = !status && known.choice.source >= SN_ENDS_ATTACHMENTS;
    if (!status) status = find_tip_ends(s, attached ? NULL : trace, out, error);
    out->choice = known.choice;
    if (!status && attached) status = take_known(s, &known, out, trace, error);
    ends_free(&known);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------------------------------------------ */

static sn_status take_given(search *s, const sn_fill_params *params, fill_ends *out, sn_error *error) {
    const sn_index *lists[2] = {params->origin, params->insertion};
    const sn_index counts[2] = {params->origin_count, params->insertion_count};
    for (int k = 0; k < 2; k++)
        for (sn_index i = 0; i < counts[k]; i++) {
            sn_index v = lists[k][i];
            if (v < 0 || v >= s->muscle->mesh.vertex_count)
                return sn_fail(error, SN_ERROR_INPUT, "the %s names vertex %d, but the surface has %d", k == 0 ? "origin" : "insertion", v,
                               s->muscle->mesh.vertex_count);
            add_end(out, s->taken, v, k);
        }
    out->kind = SN_FILL_ENDS_GIVEN;
    if (has_both(out)) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "origin and insertion must each have a vertex that the other does not have");
}

static sn_status find(search *s, const sn_fill_params *params, sn_trace *trace, fill_ends *out, sn_error *error) {
    out->choice = (sn_ends_choice){.source = SN_ENDS_TIPS, .from = sn_ends_source_names[SN_ENDS_TIPS]};
    if (params->use_attachments && params->origin_count == 0 && params->insertion_count == 0) return find_best(s, out, trace, error);
    if (params->origin_count == 0 && params->insertion_count == 0) return find_tip_ends(s, trace, out, error);
    out->choice = (sn_ends_choice){.source = SN_ENDS_SITES, .from = "given", .known = {true, true}};
    return take_given(s, params, out, error);
}

sn_status fill_find_ends(const sn_muscle *muscle, const sn_topology *topology, const sn_fill_params *params, sn_trace *trace,
                         fill_ends *out, sn_error *error) {
    search s = {.muscle = muscle, .topology = topology};
    *out = (fill_ends){.vertices = SN_NEW(sn_index, muscle->mesh.vertex_count), .values = SN_NEW(double, muscle->mesh.vertex_count)};
    sn_status status = search_alloc(&s) && out->vertices && out->values ? SN_OK : sn_fail_memory(error, "the ends of the fibres");
    if (!status) status = find(&s, params, trace, out, error);
    search_free(&s);
    if (status) fill_ends_free(out);
    return status;
}

void fill_ends_free(fill_ends *out) {
    free(out->vertices);
    free(out->values);
    *out = (fill_ends){0};
}
