/*
 * fiber_flow.c -- fibre direction at every surface vertex ([R18] 3.2): the axes of nearby samples, averaged, projected on the surface; or
 * those of a harmonic field, or of given fibres.
 *
 * Directions are axes: delta changes sign across the roots, so vectors are turned to agree before any averaging. Without that the flow near
 * the roots is 20-28 degrees off between neighbours, with it 4-6.
 */
#include "sinew/rig.h"

#include <stdlib.h>

#include "flow.h"

/* The projection of a direction this nearly normal to the surface says nothing: the tips, where fibres leave the surface. */
#define VANISHING 1e-2
/* eps of 1 / (d^2 + eps^2), as a share of the box diagonal: a vertex on its sample must not divide by zero. */
#define WEIGHT_EPSILON 1e-3

/* Within this share of L of a tip every method is far off: confidence falls to 0 there. */
#define TIP_SHARE 0.08
#define LOW_CONFIDENCE 0.5

typedef enum rule { RULE_NONE, RULE_FIELD, RULE_NEIGHBOURS, RULE_CONVENTION } rule;

typedef struct flow {
    const sn_muscle *muscle;
    const sn_mesh *mesh;
    const sn_structure *structure;
    const sn_flow_params *params;
    sn_trace *trace;
    sn_topology topology;
    sn_flow_field field;
    ends ends; /* where the field asks for them */
    double farthest_fiber;
    double epsilon;
    sn_index *child_start; /* (sample_count + 1) into child_list */
    sn_index *child_list;
    sn_index *vertex_start; /* (sample_count + 1) into vertex_list */
    sn_index *vertex_list;  /* (vertex_count) */
    sn_vec3 *normals;       /* (vertex_count) unit */
    sn_vec3 *directions;    /* (vertex_count) */
    sn_vec3 *scratch;       /* (vertex_count) */
    double *confidence;     /* (vertex_count) */
    unsigned char *rules;   /* (vertex_count) rule */
} flow;

static sn_status check_structure(const sn_muscle *muscle, sn_error *error) {
    const sn_structure *s = &muscle->structure;
    if (s->sample_count < 1) return sn_fail(error, SN_ERROR_INPUT, "the muscle has no structure; run build-structure on it first");
    for (sn_index v = 0; v < muscle->mesh.vertex_count; v++) {
        if (s->vertex_sample[v] >= 0 && s->vertex_sample[v] < s->sample_count) continue;
        sn_fail(error, SN_ERROR_INPUT, "vertex %d hangs on no sample of the structure; run build-structure to its end first", (int)v);
        if (error) error->element = v;
        return SN_ERROR_INPUT;
    }
    return SN_OK;
}

static sn_status check_fibers(const sn_flow_params *params, sn_error *error) {
    for (sn_index i = 0; i < params->polyline_count; i++) {
        const sn_polyline *line = &params->polylines[i];
        bool finite = true;
        double length = 0.0;
        for (sn_index k = 0; k < line->count && finite; k++) {
            finite = sn_finite3(line->points[k]);
            if (k > 0) length += sn_distance(line->points[k - 1], line->points[k]);
        }
        if (!finite) return sn_fail(error, SN_ERROR_INPUT, "fibre %d has a point that is not finite", (int)i + 1);
        if (length > 0.0) return SN_OK;
    }
    return sn_fail(error, SN_ERROR_INPUT, "there is no fibre with two different points to take directions from");
}

/* AUTO: harmonic where the ends are known. Patches of merely detected bone contact are poor ends: not used for it. */
static sn_status choose_field(flow *f, sn_error *error) {
    f->field = f->params->field;
    if (f->params->smooth < 0) return sn_fail(error, SN_ERROR_USAGE, "the number of smoothing steps must be 0 or more");
    if (f->field == SN_FIELD_AUTO || f->field == SN_FIELD_HARMONIC) {
        sn_status status = flow_find_ends(f->muscle, &f->topology, f->params, &f->ends, error);
        if (status) return status;
    }
    if (f->field == SN_FIELD_AUTO) f->field = ends_known(&f->ends.choice) ? SN_FIELD_HARMONIC : SN_FIELD_TREE;
    if (f->field == SN_FIELD_TREE) return check_structure(f->muscle, error);
    return f->field == SN_FIELD_FIBERS ? check_fibers(f->params, error) : SN_OK;
}

/* ---- normals -------------------------------------------------------------------------------------------------------------- */

/* The normal of the largest triangle at the vertex; zero where all are degenerate. */
static sn_vec3 largest_triangle_normal(const flow *f, sn_index vertex) {
    sn_vec3 best = {0, 0, 0};
    for (sn_index k = f->topology.corner_start[vertex]; k < f->topology.corner_start[vertex + 1]; k++) {
        const sn_index *v = f->mesh->triangles[f->topology.vertex_triangles[k]].v;
        sn_vec3 area = sn_area_vector(f->mesh->positions[v[0]], f->mesh->positions[v[1]], f->mesh->positions[v[2]]);
        if (sn_norm2(area) > sn_norm2(best)) best = area;
    }
    return sn_normalize(best);
}

static sn_vec3 neighbours_normal(const flow *f, sn_index vertex) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index k = f->topology.vertex_start[vertex]; k < f->topology.vertex_start[vertex + 1]; k++)
        sum = sn_add(sum, f->normals[f->topology.neighbours[k]]);
    return sn_normalize(sum);
}

/* Area-weighted normals; where the areas cancel, those of the largest triangle, then of the neighbours, then z. */
static void set_normals(flow *f) {
    sn_mesh_vertex_normals(f->mesh, f->normals);
    for (sn_index v = 0; v < f->mesh->vertex_count; v++) {
        sn_vec3 *n = &f->normals[v];
        if (sn_norm2(*n) == 0.0) *n = largest_triangle_normal(f, v);
        if (sn_norm2(*n) == 0.0) *n = neighbours_normal(f, v);
        if (sn_norm2(*n) == 0.0) *n = sn_v3(0, 0, 1);
    }
}

/* ---- directions at one vertex ------------------------------------------------------------------------------------------------ */

/* Unit projection on the tangent plane of the vertex; zero where it vanishes. */
static sn_vec3 project(sn_vec3 direction, sn_vec3 normal) {
    sn_vec3 d = sn_normalize(direction);
    sn_vec3 tangent = sn_add_scaled(d, normal, -sn_dot(d, normal));
    if (sn_norm2(tangent) < VANISHING * VANISHING) return sn_v3(0, 0, 0);
    tangent = sn_normalize(tangent);
    return sn_normalize(sn_add_scaled(tangent, normal, -sn_dot(tangent, normal))); /* again: the first left rounding behind */
}

/* Any tangent, by convention: the coordinate axis that is most nearly tangent, projected. */
static sn_vec3 conventional_tangent(sn_vec3 n) {
    sn_vec3 axis = fabs(n.x) <= fabs(n.y) && fabs(n.x) <= fabs(n.z) ? sn_v3(1, 0, 0)
                   : fabs(n.y) <= fabs(n.z)                         ? sn_v3(0, 1, 0)
                                                                    : sn_v3(0, 0, 1);
    return project(axis, n);
}

static double agreement(const flow *f, sn_vec3 a, sn_vec3 b) { return f->params->align && sn_dot(a, b) < 0.0 ? -1.0 : 1.0; }

static double sample_weight(const flow *f, sn_vec3 point, sn_index sample) {
    double d = sn_distance(point, f->structure->positions[sample]);
    return f->params->weights == SN_FLOW_PAPER ? d : 1.0 / (d * d + f->epsilon * f->epsilon);
}

/* f = sum over the sample, its parent and its children of w_n delta_n. The paper's delta is that of a link, so that the root has none:
 * without alignment it is left out. */
static sn_vec3 tree_direction(const flow *f, sn_index vertex) {
    const sn_structure *s = f->structure;
    sn_vec3 point = f->mesh->positions[vertex], sum = {0, 0, 0};
    sn_index own = s->vertex_sample[vertex];
    sn_vec3 reference = s->axes[own];
    if (own > 0 || f->params->align || s->sample_count == 1) sum = sn_scale(reference, sample_weight(f, point, own));
    sn_index parent = s->parents[own];
    if (parent > 0 || (parent == 0 && f->params->align))
        sum = sn_add_scaled(sum, s->axes[parent], agreement(f, reference, s->axes[parent]) * sample_weight(f, point, parent));
    for (sn_index k = f->child_start[own]; k < f->child_start[own + 1]; k++) {
        sn_index child = f->child_list[k];
        sum = sn_add_scaled(sum, s->axes[child], agreement(f, reference, s->axes[child]) * sample_weight(f, point, child));
    }
    return sum;
}

/* The sum of the neighbours' axes, each laid into the tangent plane of the vertex and turned to agree with reference (zero: with the
 * first). */
static sn_vec3 neighbour_sum(const flow *f, sn_index vertex, sn_vec3 reference) {
    sn_vec3 sum = {0, 0, 0}, normal = f->normals[vertex];
    for (sn_index k = f->topology.vertex_start[vertex]; k < f->topology.vertex_start[vertex + 1]; k++) {
        sn_index w = f->topology.neighbours[k];
        if (f->rules[w] == RULE_NONE) continue;
        sn_vec3 tangent = sn_add_scaled(f->directions[w], normal, -sn_dot(f->directions[w], normal));
        if (sn_norm2(reference) == 0.0) reference = tangent;
        sum = sn_add_scaled(sum, tangent, agreement(f, reference, tangent));
    }
    return sum;
}

/* ---- the steps ---------------------------------------------------------------------------------------------------------------- */

static sn_status gather_directions(flow *f, sn_error *error) {
    const flow_input in = {f->muscle, &f->topology, f->params, f->trace};
    if (f->field == SN_FIELD_HARMONIC) return harmonic_directions(&in, &f->ends, f->directions, error);
    if (f->field == SN_FIELD_FIBERS)
        return nearest_tangents(f->mesh, f->params->polyline_count, f->params->polylines, f->directions, &f->farthest_fiber, error);
    for (sn_index v = 0; v < f->mesh->vertex_count; v++) f->directions[v] = tree_direction(f, v);
    return SN_OK;
}

/* On the tangent planes; returns how many vanish there. */
static sn_index lay_down(flow *f) {
    sn_index missing = 0;
    for (sn_index v = 0; v < f->mesh->vertex_count; v++) {
        f->directions[v] = project(f->directions[v], f->normals[v]);
        f->rules[v] = sn_norm2(f->directions[v]) > 0.0 ? RULE_FIELD : RULE_NONE;
        missing += f->rules[v] == RULE_NONE;
    }
    return missing;
}

/* One ring of vertices without a direction takes it from the neighbours that have one; returns how many did. */
static sn_index ask_neighbours(flow *f, sn_index *missing, sn_index *missing_count) {
    sn_index left = 0, before = *missing_count;
    for (sn_index i = 0; i < before; i++)
        f->scratch[missing[i]] = project(neighbour_sum(f, missing[i], sn_v3(0, 0, 0)), f->normals[missing[i]]);
    for (sn_index i = 0; i < before; i++) {
        sn_index v = missing[i];
        f->directions[v] = f->scratch[v];
        if (sn_norm2(f->directions[v]) > 0.0)
            f->rules[v] = RULE_NEIGHBOURS;
        else
            missing[left++] = v;
    }
    *missing_count = left;
    return before - left;
}

static sn_status fill_missing(flow *f, sn_index count, sn_error *error) {
    sn_index *missing = SN_NEW(sn_index, count);
    if (!missing) return sn_fail_memory(error, "the vertices without a direction");
    sn_index left = 0;
    for (sn_index v = 0; v < f->mesh->vertex_count; v++)
        if (f->rules[v] == RULE_NONE) missing[left++] = v;
    while (left > 0 && ask_neighbours(f, missing, &left) > 0) {}
    for (sn_index i = 0; i < left; i++) {
        f->directions[missing[i]] = conventional_tangent(f->normals[missing[i]]);
        f->rules[missing[i]] = RULE_CONVENTION;
    }
    free(missing);
    return SN_OK;
}

/* One step of axis diffusion: the mean axis of the vertex and its neighbours, back on the tangent plane. */
static void smooth_once(flow *f) {
    for (sn_index v = 0; v < f->mesh->vertex_count; v++) {
        sn_vec3 sum = sn_add(f->directions[v], neighbour_sum(f, v, f->directions[v]));
        sn_vec3 moved = project(sum, f->normals[v]);
        f->scratch[v] = sn_norm2(moved) > 0.0 ? moved : f->directions[v];
    }
    sn_vec3 *swap = f->directions;
    f->directions = f->scratch;
    f->scratch = swap;
}

const char *const sn_flow_field_names[] = {"auto", "tree", "harmonic", "fibers", NULL};

static sn_status run(flow *f, sn_error *error) {
    sn_status gathered = gather_directions(f, error);
    if (gathered && gathered != SN_STOPPED) return gathered;
    sn_index missing = lay_down(f);
    bool stop =
        gathered == SN_STOPPED || SN_TRACE(f->trace, sn_flow_field_names[f->field], sn_trace_number("vertices", f->mesh->vertex_count),
                                           sn_trace_number("vanishing", missing));
    if (missing > 0) { /* also when stopped: what is written has a direction everywhere */
        sn_status status = fill_missing(f, missing, error);
        if (status) return status;
    }
    if (stop || SN_TRACE(f->trace, "neighbours", sn_trace_number("filled", missing))) return SN_STOPPED;
    for (sn_index i = 0; i < f->params->smooth; i++) {
        smooth_once(f);
        if (SN_TRACE(f->trace, "smooth", sn_trace_number("pass", i + 1))) return SN_STOPPED;
    }
    return SN_OK;
}

/* ---- confidence ------------------------------------------------------------------------------------------------------------------ */

/* The vertex that lies farthest out on each leaf of the structure; without one, the two ends of the shape. Returns how many. */
static sn_status find_all_tips(const flow *f, sn_index *tip, sn_index *count, double *length, sn_error *error) {
    const sn_structure *s = f->structure;
    surface_survey survey;
    tips shape;
    sn_status status = survey_surface(f->mesh, &f->topology, &survey, error);
    if (!status) status = find_tips(f->mesh, &f->topology, survey.main_vertex, NULL, &shape, error);
    if (status) return status;
    *length = shape.length;
    tip[0] = shape.end[0];
    tip[1] = shape.end[1];
    *count = 2;
    for (sn_index i = 0; i < s->sample_count; i++) {
        if (f->child_start[i] < f->child_start[i + 1]) continue;
        sn_index best = SN_NONE;
        double farthest = 0.0;
        for (sn_index k = f->vertex_start[i]; k < f->vertex_start[i + 1]; k++) {
            sn_index v = f->vertex_list[k];
            double out = -sn_dot(s->axes[i], sn_sub(f->mesh->positions[v], s->positions[i]));
            if (best != SN_NONE && !(out > farthest)) continue;
            best = v;
            farthest = out;
        }
        if (best != SN_NONE) tip[(*count)++] = best;
    }
    return SN_OK;
}

/* How well the neighbours' axes agree with that of the vertex: 1 = all parallel. */
static double agreement_around(const flow *f, sn_index vertex) {
    sn_index first = f->topology.vertex_start[vertex], last = f->topology.vertex_start[vertex + 1];
    double sum = 0.0;
    for (sn_index k = first; k < last; k++) sum += fabs(sn_dot(f->directions[vertex], f->directions[f->topology.neighbours[k]]));
    return last > first ? sum / (double)(last - first) : 0.0;
}

/* The rule's own share, times how far the tips are (8 % of L or more is far), times how well the neighbours agree. */
static sn_status set_confidence(flow *f, sn_error *error) {
    static const double shares[] = {[RULE_NONE] = 0.0, [RULE_FIELD] = 1.0, [RULE_NEIGHBOURS] = 0.5, [RULE_CONVENTION] = 0.0};
    sn_index *tip = SN_NEW(sn_index, (size_t)f->structure->sample_count + 2), count = 0;
    double length = 0.0;
    sn_status status = tip ? find_all_tips(f, tip, &count, &length, error) : sn_fail_memory(error, "the tips of the muscle");
    if (!status) status = sn_geodesic_distance(f->mesh, &f->topology, count, tip, f->confidence, error);
    for (sn_index v = 0; !status && v < f->mesh->vertex_count; v++) {
        double near = length > 0.0 ? fmin(1.0, f->confidence[v] / (TIP_SHARE * length)) : 0.0;
        f->confidence[v] = fmin(1.0, shares[f->rules[v]] * near * agreement_around(f, v));
    }
    free(tip);
    return status;
}

/* ---- report -------------------------------------------------------------------------------------------------------------------- */

static int compare_numbers(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

static double axis_angle(sn_vec3 a, sn_vec3 b) { return sn_quick_atan2(sn_norm(sn_cross(a, b)), fabs(sn_dot(a, b))); }

/* Angles between the axes at the two ends of each edge. */
static sn_status measure_angles(const flow *f, sn_flow_report *r, sn_error *error) {
    sn_index count = f->topology.edge_count;
    double *angles = SN_NEW(double, count), sum = 0.0;
    if (!angles) return sn_fail_memory(error, "the angles of the flow");
    for (sn_index e = 0; e < count; e++) {
        const sn_index *v = f->topology.edges[e].v;
        angles[e] = axis_angle(f->directions[v[0]], f->directions[v[1]]);
        sum += angles[e];
    }
    qsort(angles, (size_t)count, sizeof *angles, compare_numbers);
    r->mean_angle = count > 0 ? sum / count : 0.0;
    r->percentile95_angle = count > 0 ? angles[(sn_index)(0.95 * (count - 1))] : 0.0;
    free(angles);
    return SN_OK;
}

/* Over the edges at root vertices: where a tree's directions turn round. */
static double angle_at_roots(const flow *f) {
    double sum = 0.0;
    sn_index count = 0;
    for (sn_index i = 0; i < f->muscle->roots.count; i++) {
        sn_index v = f->muscle->roots.vertices[i];
        for (sn_index k = f->topology.vertex_start[v]; k < f->topology.vertex_start[v + 1]; k++, count++)
            sum += axis_angle(f->directions[v], f->directions[f->topology.neighbours[k]]);
    }
    return count > 0 ? sum / count : NAN;
}

static sn_status fill_report(const flow *f, sn_flow_report *r, sn_error *error) {
    *r = (sn_flow_report){.vertices = f->mesh->vertex_count, .field = f->field, .ends = f->ends.choice, .farthest_fiber = f->farthest_fiber};
    double confidence = 0.0;
    for (sn_index v = 0; v < f->mesh->vertex_count; v++) {
        r->by_field += f->rules[v] == RULE_FIELD;
        r->by_neighbours += f->rules[v] == RULE_NEIGHBOURS;
        r->by_convention += f->rules[v] == RULE_CONVENTION;
        r->low_confidence += f->confidence[v] < LOW_CONFIDENCE;
        confidence += f->confidence[v];
        r->max_normal_dot = fmax(r->max_normal_dot, fabs(sn_dot(f->directions[v], f->normals[v])));
    }
    r->mean_confidence = confidence / (double)f->mesh->vertex_count;
    r->roots_angle = angle_at_roots(f);
    return measure_angles(f, r, error);
}

/* ---- all together ----------------------------------------------------------------------------------------------------------------- */

static void list_children(flow *f) {
    const sn_structure *s = f->structure;
    for (sn_index i = 1; i < s->sample_count; i++) f->child_start[s->parents[i] + 1]++;
    for (sn_index i = 0; i < s->sample_count; i++) f->child_start[i + 1] += f->child_start[i];
    for (sn_index i = 1; i < s->sample_count; i++) f->child_list[f->child_start[s->parents[i]]++] = i;
    for (sn_index i = s->sample_count; i > 0; i--) f->child_start[i] = f->child_start[i - 1];
    f->child_start[0] = 0;
}

/* Vertices by sample. */
static void list_vertices(flow *f) {
    const sn_structure *s = f->structure;
    for (sn_index v = 0; s->sample_count > 0 && v < f->mesh->vertex_count; v++)
        if (s->vertex_sample[v] != SN_NONE) f->vertex_start[s->vertex_sample[v] + 1]++;
    for (sn_index i = 0; i < s->sample_count; i++) f->vertex_start[i + 1] += f->vertex_start[i];
    for (sn_index v = 0; s->sample_count > 0 && v < f->mesh->vertex_count; v++)
        if (s->vertex_sample[v] != SN_NONE) f->vertex_list[f->vertex_start[s->vertex_sample[v]]++] = v;
    for (sn_index i = s->sample_count; i > 0; i--) f->vertex_start[i] = f->vertex_start[i - 1];
    f->vertex_start[0] = 0;
}

static sn_status prepare(flow *f, sn_error *error) {
    sn_status status = sn_mesh_validate(f->mesh, error);
    if (!status) status = sn_topology_build(f->mesh, &f->topology, error);
    if (!status) status = choose_field(f, error);
    if (status) return status;
    size_t n = (size_t)f->mesh->vertex_count, samples = (size_t)f->structure->sample_count;
    f->child_start = SN_NEW(sn_index, samples + 1);
    f->child_list = SN_NEW(sn_index, samples);
    f->vertex_start = SN_NEW(sn_index, samples + 1);
    f->vertex_list = SN_NEW(sn_index, n);
    f->confidence = SN_NEW(double, n);
    f->normals = SN_NEW(sn_vec3, n);
    f->directions = SN_NEW(sn_vec3, n);
    f->scratch = SN_NEW(sn_vec3, n);
    f->rules = SN_NEW(unsigned char, n);
    if (!f->child_start || !f->child_list || !f->vertex_start || !f->vertex_list || !f->confidence || !f->normals || !f->directions ||
        !f->scratch || !f->rules)
        return sn_fail_memory(error, "the fibre directions");
    f->epsilon = fmax(WEIGHT_EPSILON * sn_box_diagonal(sn_mesh_box(f->mesh)), 1e-150);
    list_children(f);
    list_vertices(f);
    set_normals(f);
    return SN_OK;
}

static void flow_free(flow *f) {
    ends_free(&f->ends);
    sn_topology_free(&f->topology);
    free(f->child_start);
    free(f->child_list);
    free(f->vertex_start);
    free(f->vertex_list);
    free(f->confidence);
    free(f->normals);
    free(f->directions);
    free(f->scratch);
    free(f->rules);
}

sn_flow_params sn_flow_defaults(void) { return (sn_flow_params){.weights = SN_FLOW_INVERSE_SQUARE, .smooth = 3, .align = true}; }

sn_status sn_flow_fibers(const sn_muscle *muscle, const sn_flow_params *params, sn_trace *trace, sn_fibers *out, sn_flow_report *report,
                         sn_error *error) {
    *out = (sn_fibers){0};
    if (report) *report = (sn_flow_report){0};
    if (sn_trace_stopped(trace)) return SN_STOPPED;
    flow f = {.muscle = muscle, .mesh = &muscle->mesh, .structure = &muscle->structure, .params = params, .trace = trace};
    sn_status status = prepare(&f, error);
    if (!status) status = run(&f, error);
    if (status == SN_OK || status == SN_STOPPED) {
        sn_status judged = set_confidence(&f, error);
        if (judged) status = judged;
    }
    if (report && (status == SN_OK || status == SN_STOPPED)) {
        sn_status reported = fill_report(&f, report, error);
        if (reported) status = reported;
    }
    if (status == SN_OK || status == SN_STOPPED) {
        out->field = sn_strdup(sn_flow_field_names[f.field]);
        if (out->field) {
            out->directions = f.directions;
            out->confidence = f.confidence;
            f.directions = NULL;
            f.confidence = NULL;
        } else {
            status = sn_fail_memory(error, "the fibre directions");
        }
    }
    flow_free(&f);
    return status;
}
