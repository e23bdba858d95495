/* structure.c -- the internal structure of a muscle ([R18] 3.1): traverse, prune, re-sample, connect. */
#include "sinew/rig.h"

#include <stdlib.h>

#include "tips.h"
#include "tree.h"

/* Levels of slabs lie this share of the length apart. */
#define SLAB_SHARE (1.0 / 60.0)
/* A sample that is moved inside goes no deeper than this share of the length. */
#define DEPTH_SHARE 0.05
/* A leaf this near to the surface, as a share of the box diagonal, is on it: the fronts at the tips are single vertices. */
#define ON_SURFACE 1e-9

typedef struct building {
    const sn_muscle *muscle;
    const sn_mesh *mesh;
    const sn_structure_params *params;
    sn_trace *trace;
    sn_topology topology;
    surface_survey survey;
    tips tips;
    double spacing;
    tree tree;
    inside_step inside;
    sn_index pruned;
    sn_structure structure;
} building;

/* ---- before ------------------------------------------------------------------------------------------------------------- */

static sn_status check_request(const building *b, sn_error *error) {
    const sn_roots *roots = &b->muscle->roots;
    if (!(b->params->spacing >= 0.0) || !isfinite(b->params->spacing))
        return sn_fail(error, SN_ERROR_USAGE, "the spacing must be a length greater than 0");
    if (!(b->params->prune >= 0.0) || !isfinite(b->params->prune))
        return sn_fail(error, SN_ERROR_USAGE, "the share of the length to prune must be 0 or more");
    if (roots->count < 1) return sn_fail(error, SN_ERROR_INPUT, "the muscle has no roots; run root-select on it first");
    for (sn_index i = 0; i < roots->count; i++)
        if (roots->vertices[i] < 0 || roots->vertices[i] >= b->mesh->vertex_count)
            return sn_fail(error, SN_ERROR_INPUT, "root %d is vertex %d, which the mesh does not have; run root-select again", (int)i,
                           (int)roots->vertices[i]);
    return SN_OK;
}

static sn_status check_all_reached(const building *b, sn_error *error) {
    for (sn_index v = 0; v < b->mesh->vertex_count; v++) {
        if (isfinite(b->tree.distance[v])) continue;
        bool unused = b->topology.corner_start[v] == b->topology.corner_start[v + 1];
        sn_fail(error, SN_ERROR_INPUT,
                unused
                    ? "no triangle uses vertex %d, so nothing can hold it; run mesh-clean, which drops such vertices"
                    : "vertex %d is on another component of the surface than the roots; run mesh-clean --keep largest, or choose roots on "
                      "every component",
                (int)v);
        if (error) error->element = v;
        return SN_ERROR_INPUT;
    }
    return SN_OK;
}

static sn_status prepare(building *b, sn_error *error) {
    sn_status status = sn_mesh_validate(b->mesh, error);
    if (!status) status = check_request(b, error);
    if (!status) status = sn_topology_build(b->mesh, &b->topology, error);
    if (!status) status = survey_surface(b->mesh, &b->topology, &b->survey, error);
    if (!status) status = find_tips(b->mesh, &b->topology, b->survey.main_vertex, NULL, &b->tips, error);
    if (!status) status = tree_create(b->mesh, &b->topology, &b->muscle->roots, &b->tree, error);
    if (!status) status = check_all_reached(b, error);
    b->spacing = b->params->spacing > 0.0 ? b->params->spacing : 2.0 * sn_mesh_mean_edge(b->mesh, &b->topology);
    if (!status && b->params->spacing > b->tips.length)
        status =
            sn_fail(error, SN_ERROR_USAGE,
                    "a spacing of %g is longer than the muscle (%g from tip to tip); give a smaller one, or a unit with it (as in 6mm)",
                    b->params->spacing, b->tips.length);
    if (!status && !(b->spacing > 0.0)) status = sn_fail(error, SN_ERROR_INPUT, "all edges of the mesh have length 0; clean it first");
    return status;
}

/* ---- the steps ------------------------------------------------------------------------------------------------------------ */

static sn_status grow_tree(building *b, sn_error *error) {
    sn_status status = b->params->metric == SN_METRIC_HOPS ? traverse_hops(&b->tree, &b->muscle->roots, b->trace, error)
                                                           : traverse_slabs(&b->tree, SLAB_SHARE * b->tips.length, b->trace, error);
    if (!status && b->params->prune > 0.0) {
        status = prune_tree(&b->tree, b->params->prune * b->tips.length, b->trace, &b->pruned, error);
        tree_compact(&b->tree);
    }
    return status;
}

/* Once the tree stands it is resampled; where the trace stopped before, its fronts are the samples. */
static sn_status make_structure(building *b, sn_error *error) {
    sn_status status = grow_tree(b, error);
    bool has_inside = isfinite(b->survey.genus); /* an open surface has none */
    b->inside = (inside_step){
        .mesh = has_inside && !b->params->keep_outside ? b->mesh : NULL, .reach = DEPTH_SHARE * b->tips.length, .trace = b->trace};
    if (status == SN_OK) return resample_tree(&b->tree, b->spacing, &b->inside, b->trace, &b->structure, error);
    if (status != SN_STOPPED) return status;
    status = tree_as_structure(&b->tree, &b->structure, error);
    return status ? status : SN_STOPPED;
}

/* ---- axes --------------------------------------------------------------------------------------------------------------- */

/* The mean of the axes of the root's children, each turned to agree with the first: they point at the root from opposite sides. */
static sn_vec3 root_axis(const sn_structure *s) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = 1; i < s->sample_count; i++)
        if (s->parents[i] == 0) sum = sn_add_scaled(sum, s->axes[i], sn_dot(sum, s->axes[i]) < 0.0 ? -1.0 : 1.0);
    return sn_normalize(sum);
}

/* delta_i = (b_parent - b_i) / |b_parent - b_i| ([R18] 3.2); a sample on its parent takes the parent's axis. */
static void set_axes(sn_structure *s) {
    for (sn_index i = 1; i < s->sample_count; i++) s->axes[i] = sn_normalize(sn_sub(s->positions[s->parents[i]], s->positions[i]));
    s->axes[0] = root_axis(s);
    for (sn_index i = 1; i < s->sample_count && sn_norm2(s->axes[0]) == 0.0; i++) s->axes[0] = s->axes[i];
    if (sn_norm2(s->axes[0]) == 0.0) s->axes[0] = sn_v3(0, 0, 1); /* a root alone */
    for (sn_index i = 1; i < s->sample_count; i++)
        if (sn_norm2(s->axes[i]) == 0.0) s->axes[i] = s->axes[s->parents[i]];
}

/* ---- report --------------------------------------------------------------------------------------------------------------- */

static bool touches_triangle(const sn_mesh *mesh, sn_index triangle, sn_vec3 point, double reach) {
    const sn_index *v = mesh->triangles[triangle].v;
    sn_vec3 closest = sn_closest_on_triangle(point, mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]], NULL);
    return sn_distance(closest, point) <= reach;
}

/* Leaves that lie on a triangle at one of their own vertices count as inside. */
static void accept_leaves_on_surface(const building *b, const bool *leaf, int *winding) {
    const sn_structure *s = &b->structure;
    double reach = ON_SURFACE * sn_box_diagonal(sn_mesh_box(b->mesh));
    for (sn_index v = 0; v < b->mesh->vertex_count; v++) {
        sn_index own = s->vertex_sample[v];
        if (own == SN_NONE || !leaf[own]) continue;
        for (sn_index k = b->topology.corner_start[v]; winding[own] == 0 && k < b->topology.corner_start[v + 1]; k++)
            winding[own] = touches_triangle(b->mesh, b->topology.vertex_triangles[k], s->positions[own], reach);
    }
}

/* Which samples have no child. */
static bool *mark_leaves(const sn_structure *s) {
    bool *leaf = SN_NEW(bool, s->sample_count);
    for (sn_index i = 0; leaf && i < s->sample_count; i++) leaf[i] = true;
    for (sn_index i = 1; leaf && i < s->sample_count; i++) leaf[s->parents[i]] = false;
    return leaf;
}

static sn_status count_outside(const building *b, const bool *leaf, sn_index *outside, sn_error *error) {
    if (!isfinite(b->survey.genus)) return SN_OK; /* an open surface has no inside */
    const sn_structure *s = &b->structure;
    int *winding = SN_NEW(int, s->sample_count);
    if (!winding) return sn_fail_memory(error, "the test for samples outside the volume");
    sn_status status = count_windings(b->mesh, s->sample_count, s->positions, winding, error);
    if (!status) accept_leaves_on_surface(b, leaf, winding);
    *outside = 0;
    for (sn_index i = 0; i < s->sample_count; i++) *outside += winding[i] == 0;
    free(winding);
    return status;
}

static void count_tree(const sn_structure *s, const bool *leaf, sn_structure_report *r) {
    r->samples = s->sample_count;
    for (sn_index i = 0; i < s->sample_count; i++) {
        r->leaves += leaf[i];
        if (s->branches[i] >= r->branches) r->branches = s->branches[i] + 1;
        if (i > 0) r->longest_link = fmax(r->longest_link, sn_distance(s->positions[i], s->positions[s->parents[i]]));
    }
}

static sn_status fill_report(const building *b, sn_structure_report *r, sn_error *error) {
    *r = (sn_structure_report){
        .vertices = b->mesh->vertex_count, .pruned = b->pruned, .moved = b->inside.moved, .spacing = b->spacing, .outside = SN_NONE};
    r->length = b->tips.length;
    r->genus = b->survey.genus;
    for (sn_index v = 0; v < b->mesh->vertex_count; v++) r->unconnected += b->structure.vertex_sample[v] == SN_NONE;
    bool *leaf = mark_leaves(&b->structure);
    if (!leaf) return sn_fail_memory(error, "the report of a structure");
    count_tree(&b->structure, leaf, r);
    sn_status status = count_outside(b, leaf, &r->outside, error);
    free(leaf);
    return status;
}

/* ---- all together ------------------------------------------------------------------------------------------------------------ */

sn_structure_params sn_structure_defaults(void) { return (sn_structure_params){.spacing = 0.0, .prune = 0.03}; }

sn_status sn_structure_build(const sn_muscle *muscle, const sn_structure_params *params, sn_trace *trace, sn_structure *out,
                             sn_structure_report *report, sn_error *error) {
    *out = (sn_structure){0};
    if (report) *report = (sn_structure_report){.outside = SN_NONE};
    if (sn_trace_stopped(trace)) return SN_STOPPED;
    building b = {.muscle = muscle, .mesh = &muscle->mesh, .params = params, .trace = trace};
    sn_status status = prepare(&b, error);
    if (!status) status = make_structure(&b, error);
    bool usable = (status == SN_OK || status == SN_STOPPED) && b.structure.sample_count > 0;
    if (usable) {
        b.structure.spacing = b.spacing;
        set_axes(&b.structure);
    }
    if (usable && report) {
        sn_status reported = fill_report(&b, report, error);
        if (reported) status = reported;
    }
    if (status == SN_OK || status == SN_STOPPED)
        *out = b.structure;
    else
        sn_structure_free(&b.structure);
    inside_step_free(&b.inside);
    tree_free(&b.tree);
    sn_topology_free(&b.topology);
    return status;
}
