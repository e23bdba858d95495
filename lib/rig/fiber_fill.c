/* fiber_fill.c -- the volume of a muscle decomposed into fibres ([K21] 4; after Kohout and Kukacka 2014). */
#include <stdlib.h>

#include "fill.h"
#include "tree.h"

enum { LEVELS_A_SEGMENT = 5, LEAST_LEVELS = 31 };
#define MUCH_TURNING (120.0 * SN_PI / 180.0) /* of a fibre from end to end: from then on slices by flux are tried */
#define LEAST_SHARE 0.8                      /* of the fibres that an end of the muscle had: heads keep about what their areas give them */
#define FEW_FIBERS 0.04                      /* of all: so many fewer do not count */
#define LESS_TURNING 0.95                    /* of what it was: so much less is better */
#define ON_SURFACE 1e-9                      /* of the box diagonal: nearer than that is not outside */

typedef struct filling {
    const sn_muscle *muscle;
    const sn_fill_params *params;
    fill_levels levels;
    fill_bend bend;     /* count 0 = none */
    fill_uv *seeds;     /* (fibers) */
    fill_areas areas;   /* members NULL = fibres are not spread over areas */
    sn_polyline *lines; /* (fibers) */
    double *z;          /* (fibers x (segments + 1)) */
    double diagonal, mean_edge;
    bool closed;
    bool flux;           /* slices by the field's flux on a finer surface */
    sn_status *statuses; /* (chunks of the loop at hand) */
} filling;

/* ---- what is asked for --------------------------------------------------------------------------------------------------------- */

sn_fill_params sn_fill_defaults(void) {
    return (sn_fill_params){.fibers = SN_FILL_FIBERS,
                            .segments = SN_FILL_SEGMENTS,
                            .angle = 20.0 * SN_PI / 180.0,
                            .narrow = 0.25,
                            .bow = 0.5,
                            .smooth = 0,
                            .pull = true,
                            .use_attachments = true,
                            .spread = true};
}

static sn_status check_curves(const sn_fill_params *p, sn_error *error) {
    if (p->curve_count < 1) return sn_fail(error, SN_ERROR_USAGE, "a fibre template of one's own needs at least one curve");
    for (sn_index i = 0; i < p->curve_count; i++) {
        const sn_fill_curve *curve = &p->curves[i];
        if (curve->count < 2 || curve->count > FILL_CURVE_POINTS)
            return sn_fail(error, SN_ERROR_INPUT, "curve %d of the template has %d control points, not 2 to %d", i, curve->count,
                           FILL_CURVE_POINTS);
        for (sn_index k = 0; k < curve->count; k++) {
            sn_vec3 q = curve->points[k];
            if (!(q.x >= 0.0 && q.x <= 1.0 && q.y >= 0.0 && q.y <= 1.0 && q.z >= 0.0 && q.z <= 1.0))
                return sn_fail(error, SN_ERROR_INPUT, "control point %d of curve %d of the template lies outside the unit cube", k, i);
        }
        if (!(curve->points[curve->count - 1].z > curve->points[0].z))
            return sn_fail(error, SN_ERROR_INPUT, "curve %d of the template does not rise: its last z must be above its first", i);
    }
    return SN_OK;
}

static sn_status check_params(const sn_fill_params *p, sn_error *error) {
    if (p->fibers < 1 || p->fibers > 1000000) return sn_fail(error, SN_ERROR_USAGE, "the number of fibres must be in 1 to 1000000");
    if (p->segments < 1 || p->segments > 1000) return sn_fail(error, SN_ERROR_USAGE, "a fibre must have 1 to 1000 segments");
    if (!(p->angle > 0.0 && p->angle < 0.5 * SN_PI))
        return sn_fail(error, SN_ERROR_USAGE, "the pennation angle must be between 0 and 90 degrees");
    if (!(p->narrow > 0.0 && p->narrow <= 1.0))
        return sn_fail(error, SN_ERROR_USAGE, "the fan's narrow end must be in (0, 1] of its wide one");
    if (!(p->bow >= -1.0 && p->bow <= 1.0) || !isfinite(p->turn)) return sn_fail(error, SN_ERROR_USAGE, "the bow must be in [-1, 1]");
    if (p->bend_count > 0 && p->template != SN_FILL_PARALLEL && p->template != SN_FILL_FAN && p->template != SN_FILL_CURVED)
        return sn_fail(error, SN_ERROR_USAGE, "only templates that run from end to end can be bent: parallel, fan and curved");
    return p->template == SN_FILL_USER ? check_curves(p, error) : SN_OK;
}

/* ---- one fibre -------------------------------------------------------------------------------------------------------------------- */

/* A node on a level: in the slice of its loop; false where the slices end before. */
bool fill_place(const fill_levels *levels, sn_fill_map map, sn_index level, fill_uv guide, fill_uv at, sn_vec3 *out) {
    sn_index loop = fill_carry(levels, level, guide, &at), hint = 0;
    if (loop == SN_NONE) return false;
    const fill_loop *l = &levels->loops[loop];
    *out = map == SN_FILL_HARMONIC ? fill_slice_at(&l->slice, at, &hint) : fill_mean_value_at(l->rim, l->wide, at);
    return true;
}

static bool place_on_level(const filling *f, sn_index level, fill_uv guide, fill_uv at, sn_vec3 *out) {
    return fill_place(&f->levels, f->params->map, level, guide, at, out);
}

/* The level at or below z, not the last one. */
static sn_index level_below(const fill_levels *l, double z) {
    sn_index low = 0, high = l->level_count - 2;
    while (low < high) {
        sn_index middle = low + (high - low + 1) / 2;
        if (l->z[middle] <= z)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static bool place(const filling *f, fill_uv guide, fill_node node, sn_vec3 *out) {
    const fill_levels *l = &f->levels;
    sn_index i = level_below(l, node.z);
    double step = l->z[i + 1] - l->z[i], t = step > 0.0 ? (node.z - l->z[i]) / step : 0.0;
    sn_vec3 a, b;
    if (t < 1e-12) return place_on_level(f, i, guide, node.at, out);
    if (t > 1.0 - 1e-12) return place_on_level(f, i + 1, guide, node.at, out);
    if (!place_on_level(f, i, guide, node.at, &a) || !place_on_level(f, i + 1, guide, node.at, &b)) return false;
    *out = sn_lerp(a, b, t);
    return true;
}

void fill_smooth(sn_index count, sn_vec3 *p, sn_index rounds) {
    for (sn_index r = 0; r < rounds; r++) {
        sn_vec3 before = p[0];
        for (sn_index i = 1; i + 1 < count; i++) {
            sn_vec3 here = p[i];
            p[i] = sn_lerp(here, sn_lerp(before, p[i + 1], 0.5), 0.5);
            before = here;
        }
    }
}

double fill_divide(const fill_line *line, sn_index segments, sn_vec3 *out, double *out_z) {
    sn_index count = line->count;
    const sn_vec3 *p = line->points;
    const double *z = line->z;
    double length = 0.0, way = 0.0;
    for (sn_index i = 1; i < count; i++) length += sn_distance(p[i - 1], p[i]);
    sn_index at = 0;
    for (sn_index k = 0; k <= segments; k++) {
        double goal = length * (double)k / (double)segments;
        while (at + 2 < count && way + sn_distance(p[at], p[at + 1]) < goal) {
            way += sn_distance(p[at], p[at + 1]);
            at++;
        }
        double step = sn_distance(p[at], p[at + 1]), t = step > 0.0 ? fmin((goal - way) / step, 1.0) : 0.0;
        out[k] = sn_lerp(p[at], p[at + 1], t);
        out_z[k] = z[at] + t * (z[at + 1] - z[at]);
    }
    return length;
}

/* Where the fibre is nearest to the trunk: that decides which head it takes. */
static fill_uv at_trunk(const filling *f, sn_index count, const fill_node *nodes) {
    double trunk = f->levels.z[f->levels.trunk];
    sn_index best = 0;
    for (sn_index i = 1; i < count; i++)
        if (fabs(nodes[i].z - trunk) < fabs(nodes[best].z - trunk)) best = i;
    return nodes[best].at;
}

static void lead_fiber(const filling *f, sn_index fiber) {
    fill_node nodes[TEMPLATE_NODES];
    sn_vec3 points[TEMPLATE_NODES];
    double z[TEMPLATE_NODES];
    sn_index given = fill_template_fiber(f->params, &f->levels, f->seeds[fiber], fiber, nodes), count = 0;
    if (f->bend.count > 0) fill_bend_nodes(&f->bend, given, nodes);
    fill_uv guide = at_trunk(f, given, nodes);
    for (sn_index i = 0; i < given; i++)
        if (place(f, guide, nodes[i], &points[count])) z[count++] = nodes[i].z;
    sn_polyline *line = &f->lines[fiber];
    if (count < 2) {
        line->count = 0;
        return;
    }
    fill_smooth(count, points, f->params->smooth);
    (void)fill_divide(&(fill_line){count, points, z}, f->params->segments, line->points,
                      f->z + (size_t)fiber * (size_t)(f->params->segments + 1));
}

static void lead_fibers(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const filling *f = user;
    (void)chunk;
    for (sn_index i = begin; i < end; i++) lead_fiber(f, i);
}

/* ---- slices -------------------------------------------------------------------------------------------------------------- */

static void build_slices(void *user, sn_index begin, sn_index end, sn_index chunk) {
    filling *f = user;
    for (sn_index i = begin; i < end; i++) {
        fill_loop *loop = &f->levels.loops[i];
        if (loop->reached && !f->statuses[chunk]) f->statuses[chunk] = fill_slice_build(loop->rim, loop->wide, &loop->slice, NULL);
    }
}

enum { SLICES_A_CHUNK = 4, FIBERS_A_CHUNK = 8 };

static sn_status map_slices(filling *f, sn_error *error) {
    if (f->params->map != SN_FILL_HARMONIC) return SN_OK;
    sn_index chunks = sn_chunk_count(f->levels.loop_count, SLICES_A_CHUNK);
    f->statuses = SN_NEW(sn_status, chunks);
    if (!f->statuses) return sn_fail_memory(error, "the slices of the muscle");
    sn_parallel_for(f->params->pool, f->levels.loop_count, SLICES_A_CHUNK, build_slices, f);
    bool failed = false;
    for (sn_index i = 0; i < chunks; i++) failed |= f->statuses[i] != SN_OK;
    free(f->statuses);
    return failed ? sn_fail_memory(error, "the slices of the muscle") : SN_OK;
}

/* ---- nothing outside ----------------------------------------------------------------------------------------------------- */

/* Inwards from the closest point of the surface, less and less deep until it is inside; in the end on the surface itself. */
static sn_vec3 pulled(const filling *f, const sn_surface *surface, sn_vec3 p, const sn_closest *at) {
    sn_vec3 inwards = sn_normalize(sn_sub(at->point, p));
    double depth = 0.5 * f->mean_edge;
    for (int i = 0; i < 24; i++, depth *= 0.5) {
        sn_vec3 q = sn_add_scaled(at->point, inwards, depth);
        if (sn_surface_signed_distance(surface, q, NULL) < 0.0) return q;
    }
    return at->point;
}

static sn_status pull_point(const filling *f, const sn_surface *surface, sn_index fiber, sn_index vertex, sn_trace *trace,
                            sn_fill_report *report) {
    sn_vec3 *p = &f->lines[fiber].points[vertex];
    sn_closest at;
    double off = sn_surface_signed_distance(surface, *p, &at);
    if (off <= ON_SURFACE * f->diagonal) return SN_OK;
    report->outside_before++;
    report->farthest = fmax(report->farthest, off);
    if (f->params->pull) *p = pulled(f, surface, *p, &at);
    if (sn_surface_signed_distance(surface, *p, NULL) > ON_SURFACE * f->diagonal) report->outside_after++;
    bool stop =
        SN_TRACE(trace, "pull", sn_trace_number("fiber", fiber), sn_trace_number("vertex", vertex), sn_trace_number("distance", off));
    return stop ? SN_STOPPED : SN_OK;
}

/* On a closed surface a cheap count of windings says which vertices need a look at all. */
static sn_status find_suspects(const filling *f, sn_index count, const sn_vec3 *points, int *winding, sn_index *suspects, sn_error *error) {
    if (f->closed) {
        sn_status status = count_windings(&f->muscle->mesh, count, points, winding, error);
        if (status) return status;
    }
    *suspects = 0;
    for (sn_index i = 0; i < count; i++) *suspects += winding[i] == 0;
    return SN_OK;
}

static sn_status pull_suspects(const filling *f, const int *winding, sn_trace *trace, sn_fill_report *report, sn_error *error) {
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(&f->muscle->mesh, &surface, error);
    sn_index n = 0;
    for (sn_index i = 0; i < f->params->fibers && !status; i++)
        for (sn_index k = 0; k < f->lines[i].count && !status; k++, n++)
            if (winding[n] == 0) status = pull_point(f, surface, i, k, trace, report);
    sn_surface_destroy(surface);
    return status;
}

static sn_status keep_inside(const filling *f, sn_trace *trace, sn_fill_report *report, sn_error *error) {
    sn_index count = 0, suspects = 0;
    for (sn_index i = 0; i < f->params->fibers; i++) count += f->lines[i].count;
    sn_vec3 *points = SN_NEW(sn_vec3, count);
    int *winding = SN_NEW(int, count);
    sn_status status = points && winding ? SN_OK : sn_fail_memory(error, "the fibres");
    if (!status) {
        sn_index n = 0;
        for (sn_index i = 0; i < f->params->fibers; i++)
            for (sn_index k = 0; k < f->lines[i].count; k++) points[n++] = f->lines[i].points[k];
        report->vertices = count;
        status = find_suspects(f, count, points, winding, &suspects, error);
    }
    if (!status && suspects > 0) status = pull_suspects(f, winding, trace, report, error);
    free(points);
    free(winding);
    return status;
}

/* ---- measures ------------------------------------------------------------------------------------------------------------ */

/* The direction of the line of slice centroids at z, over a few levels: single centroids jump where loops split. */
static sn_vec3 action_at(const fill_levels *l, double z) {
    sn_index i = level_below(l, z), low = i > 2 ? i - 2 : 0, high = i + 3 < l->level_count ? i + 3 : l->level_count - 1;
    return sn_normalize(sn_sub(l->centre[high], l->centre[low]));
}

static void measure_fiber(const filling *f, sn_index fiber) {
    sn_polyline *line = &f->lines[fiber];
    const double *z = f->z + (size_t)fiber * (size_t)(f->params->segments + 1);
    double length = 0.0, turned = 0.0;
    for (sn_index k = 1; k < line->count; k++) {
        sn_vec3 d = sn_sub(line->points[k], line->points[k - 1]), action = action_at(&f->levels, 0.5 * (z[k - 1] + z[k]));
        double step = sn_norm(d);
        length += step;
        turned += step * sn_quick_atan2(sn_norm(sn_cross(d, action)), fabs(sn_dot(d, action)));
    }
    line->length = length;
    line->pennation = length > 0.0 ? turned / length : 0.0;
}

static sn_status measure_fibers(const filling *f, sn_trace *trace) {
    for (sn_index i = 0; i < f->params->fibers; i++) {
        measure_fiber(f, i);
        if (SN_TRACE(trace, "fiber", sn_trace_number("number", i), sn_trace_number("length", f->lines[i].length),
                     sn_trace_number("pennation", f->lines[i].pennation)))
            return SN_STOPPED;
    }
    return SN_OK;
}

/* Of the lengths, of a sample; 0 for a single fibre. */
static double deviation(const filling *f, const sn_fill_report *r) {
    double sum = 0.0;
    for (sn_index i = 0; i < f->params->fibers; i++)
        if (f->lines[i].count > 0) sum += (f->lines[i].length - r->mean_length) * (f->lines[i].length - r->mean_length);
    return r->fibers > 1 ? sqrt(sum / (double)(r->fibers - 1)) : 0.0;
}

static void summarise(const filling *f, sn_fill_report *r) {
    const fill_levels *l = &f->levels;
    double lengths = 0.0, turned = 0.0;
    r->least_length = INFINITY;
    for (sn_index i = 0; i < f->params->fibers; i++) {
        const sn_polyline *line = &f->lines[i];
        if (line->count == 0) continue;
        r->fibers++;
        lengths += line->length;
        turned += line->length * line->pennation;
        r->least_length = fmin(r->least_length, line->length);
        r->greatest_length = fmax(r->greatest_length, line->length);
        r->greatest_pennation = fmax(r->greatest_pennation, line->pennation);
    }
    if (r->fibers == 0) r->least_length = 0.0;
    r->mean_length = r->fibers > 0 ? lengths / (double)r->fibers : 0.0;
    r->length_deviation = deviation(f, r);
    r->mean_pennation = lengths > 0.0 ? turned / lengths : 0.0;
    r->levels = l->level_count;
    r->action_length = l->length;
    for (sn_index i = 0; i < l->level_count; i++) {
        double area = 0.0;
        sn_index loops = 0;
        for (sn_index k = l->first[i]; k < l->first[i + 1]; k++) {
            if (!l->loops[k].reached) continue;
            area += l->loops[k].area;
            loops++;
        }
        r->loops += loops;
        if (loops > r->most_loops) r->most_loops = loops;
        r->area = fmax(r->area, area);
    }
    r->density = r->area > 0.0 ? (double)r->fibers / r->area : 0.0;
}

/* ---- the whole ----------------------------------------------------------------------------------------------------------- */

static sn_status filling_alloc(filling *f, sn_error *error) {
    sn_index fibers = f->params->fibers, points = f->params->segments + 1;
    if ((int64_t)fibers * points > SN_INDEX_MAX / 3) return sn_fail(error, SN_ERROR_USAGE, "more fibre vertices than sinew can count");
    f->seeds = SN_NEW(fill_uv, fibers);
    f->lines = SN_NEW(sn_polyline, fibers);
    f->z = SN_NEW(double, (size_t)fibers *(size_t)points);
    if (!f->seeds || !f->lines || !f->z) return sn_fail_memory(error, "the fibres");
    for (sn_index i = 0; i < fibers; i++) {
        f->lines[i].count = points;
        if (!(f->lines[i].points = SN_NEW(sn_vec3, points))) return sn_fail_memory(error, "the fibres");
    }
    return SN_OK;
}

static void filling_free(filling *f) {
    fill_levels_free(&f->levels);
    fill_bend_free(&f->bend);
    for (int k = 0; k < 2; k++) free(f->areas.member[k]);
    free(f->seeds);
    free(f->z);
    for (sn_index i = 0; f->lines && i < f->params->fibers; i++) free(f->lines[i].points);
    free(f->lines);
}

static sn_index levels_wanted(const sn_fill_params *p) {
    sn_index wanted = LEVELS_A_SEGMENT * (p->segments < TEMPLATE_NODES ? p->segments : TEMPLATE_NODES) + 1;
    return wanted < LEAST_LEVELS ? LEAST_LEVELS : wanted > TEMPLATE_NODES ? TEMPLATE_NODES : wanted;
}

static bool is_spread(const sn_fill_params *p, sn_fill_ends_kind ends) {
    return p->spread && ends == SN_FILL_ENDS_ATTACHMENTS && p->template == SN_FILL_PARALLEL && p->bend_count == 0 &&
           p->map == SN_FILL_HARMONIC;
}

static void mark_members(filling *f, const fill_ends *ends, const char *attached) {
    bool known[2] = {false, false};
    for (sn_index i = 0; i < ends->count; i++) known[ends->values[i] != 0.0] |= attached[ends->vertices[i]];
    for (sn_index i = 0; i < ends->count; i++) {
        int side = ends->values[i] != 0.0;
        f->areas.member[side][ends->vertices[i]] = attached[ends->vertices[i]] || !known[side];
    }
}

/* Fibres lead from origin to insertion within one piece of the surface: areas of a piece that has one end alone get none. has (triangles x
 * 2) and piece (triangles) are scratch. */
static void leave_one_ended(filling *f, const sn_topology *topology, sn_index *piece, bool (*has)[2]) {
    const sn_mesh *mesh = &f->muscle->mesh;
    (void)sn_mesh_components(mesh, topology, piece);
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 2; k++) has[piece[t]][k] |= f->areas.member[k][mesh->triangles[t].v[c]];
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3 && !(has[piece[t]][0] && has[piece[t]][1]); c++)
            f->areas.member[0][mesh->triangles[t].v[c]] = f->areas.member[1][mesh->triangles[t].v[c]] = 0;
}

static sn_status keep_two_ended(filling *f, const sn_topology *topology, sn_error *error) {
    sn_index *piece = SN_NEW(sn_index, f->muscle->mesh.triangle_count);
    bool(*has)[2] = sn_alloc((size_t)f->muscle->mesh.triangle_count, sizeof *has);
    bool made = piece && has;
    if (made) leave_one_ended(f, topology, piece, has);
    free(piece);
    free(has);
    return made ? SN_OK : sn_fail_memory(error, "the attachment areas");
}

/* What of the attachments serves as ends. Where a head without one ends at its tip no fibre goes there; an end without any is what stands
 * for it. */
static sn_status find_areas(filling *f, const sn_topology *topology, const fill_ends *ends, sn_error *error) {
    const sn_muscle *m = f->muscle;
    char *attached = SN_NEW(char, m->mesh.vertex_count);
    f->areas.mesh = &m->mesh;
    for (int k = 0; k < 2; k++) f->areas.member[k] = SN_NEW(char, m->mesh.vertex_count);
    bool made = attached && f->areas.member[0] && f->areas.member[1];
    for (sn_index i = 0; made && i < m->attachment_count; i++)
        for (sn_index k = 0; k < m->attachments[i].count; k++) attached[m->attachments[i].vertices[k]] = 1;
    if (made) mark_members(f, ends, attached);
    free(attached);
    return made ? keep_two_ended(f, topology, error) : sn_fail_memory(error, "the attachment areas");
}

/* The levels of the field. */
static sn_status cut_field(filling *f, const fill_field *field, sn_trace *trace, sn_fill_report *report, sn_error *error) {
    const fill_levels_params params = {levels_wanted(f->params), f->params->turn, f->flux};
    sn_status status = fill_levels_build(field, &params, trace, &f->levels, error);
    if (!status && f->params->bend_count > 0) status = fill_bend_measure(field, f->params, &f->bend, &report->bend_farthest, error);
    return status;
}

static sn_status slice_between(filling *f, const sn_topology *topology, const fill_ends *ends, sn_trace *trace, sn_fill_report *report,
                               sn_error *error) {
    sn_mesh finer = {0};
    sn_topology around = {0};
    fill_fixed fixed = {ends->count, SN_NEW(sn_index, ends->count), SN_NEW(double, ends->count)};
    double *u = NULL;
    sn_status status = fixed.vertices && fixed.values ? SN_OK : sn_fail_memory(error, "the fibres");
    for (sn_index i = 0; i < ends->count && !status; i++) {
        fixed.vertices[i] = ends->vertices[i];
        fixed.values[i] = ends->values[i];
    }
    if (!status && f->flux) status = fill_refine(&f->muscle->mesh, topology, &fixed, &finer, &around, error);
    bool is_finer = finer.triangle_count > 0;
    const sn_mesh *mesh = is_finer ? &finer : &f->muscle->mesh;
    if (!status && !(u = SN_NEW(double, mesh->vertex_count))) status = sn_fail_memory(error, "the fibres");
    const fill_field field = {mesh, is_finer ? &around : topology, u};
    const sn_fixed_values values = {fixed.count, fixed.vertices, fixed.values};
    if (!status) status = sn_harmonic_field(mesh, field.topology, &values, u, error);
    if (!status) status = cut_field(f, &field, trace, report, error);
    free(fixed.vertices);
    free(fixed.values);
    free(u);
    sn_topology_free(&around);
    sn_mesh_free(&finer);
    return status;
}

static sn_status lead_from_seeds(filling *f, sn_fill_report *report, sn_error *error) {
    sn_status status = fill_make_seeds(&f->levels, f->params, f->seeds, report, error);
    if (!status) sn_parallel_for(f->params->pool, f->params->fibers, FIBERS_A_CHUNK, lead_fibers, f);
    return status;
}

/* Ends of the muscle, and those of them that a path leads to. */
static sn_status count_ends(const fill_levels *l, sn_index fibers, const fill_path *paths, sn_fill_report *report, sn_error *error) {
    bool *reached = SN_NEW(bool, l->loop_count);
    if (!reached) return sn_fail_memory(error, "the fibres");
    for (sn_index i = 0; i < fibers; i++)
        for (int k = 0; k < 2; k++) reached[paths[i].loop[k]] = true;
    for (sn_index i = 0; i < l->loop_count; i++) {
        if (!l->loops[i].reached || (l->loops[i].level != 0 && l->loops[i].level != l->level_count - 1)) continue;
        report->leaf_loops++;
        report->leaves_reached += reached[i];
    }
    free(reached);
    return SN_OK;
}

static sn_status lead_between_areas(filling *f, sn_fill_report *report, sn_error *error) {
    const sn_fill_params *p = f->params;
    fill_path *paths = SN_NEW(fill_path, p->fibers);
    sn_status status = paths ? fill_spread_ends(&f->levels, &f->areas, p, paths, error) : sn_fail_memory(error, "the fibres");
    const fill_leading lead = {.levels = &f->levels,
                               .mesh = &f->muscle->mesh,
                               .diagonal = f->diagonal,
                               .closed = f->closed,
                               .fibers = p->fibers,
                               .segments = p->segments,
                               .smooth = p->smooth,
                               .paths = paths,
                               .lines = f->lines,
                               .z = f->z,
                               .pool = p->pool};
    if (!status) status = count_ends(&f->levels, p->fibers, paths, report, error);
    if (!status) status = fill_lead_paths(&lead, error);
    for (int k = 0; k < 2; k++) report->areas[k] = fill_area(f->areas.mesh, f->areas.member[k]);
    report->spread = !status;
    free(paths);
    return status;
}

/* Those that lie between the ends are handed over; the others did not find their way. */
static sn_status hand_over(filling *f, sn_fibers *out, sn_error *error) {
    sn_polyline *lines = SN_NEW(sn_polyline, f->params->fibers);
    if (!lines) return sn_fail_memory(error, "the fibres");
    out->polylines = lines;
    for (sn_index i = 0; i < f->params->fibers; i++) {
        if (f->lines[i].count == 0 || !(f->lines[i].length > 0.0)) continue;
        lines[out->polyline_count++] = f->lines[i];
        f->lines[i].points = NULL;
    }
    return SN_OK;
}

/* Slices between the ends, and fibres through them. */
static sn_status lay_fibers(filling *f, const sn_topology *topology, const fill_ends *ends, sn_trace *trace, sn_fill_report *report,
                            sn_error *error) {
    sn_status status = slice_between(f, topology, ends, trace, report, error);
    if (!status && is_spread(f->params, ends->kind)) status = find_areas(f, topology, ends, error);
    if (!status) status = filling_alloc(f, error);
    if (!status) status = map_slices(f, error);
    if (!status && f->bend.count > 0) status = fill_bend_find(&f->levels, f->params, f->diagonal, &f->bend, error);
    if (!status) status = f->areas.mesh ? lead_between_areas(f, report, error) : lead_from_seeds(f, report, error);
    return status;
}

/* ---- fibres that turn aside ---------------------------------------------------------------------------------------------------- */

/* How much the fibres turn from end to end on average, radians; infinite where one is missing. */
static double mean_turning(const filling *f) {
    double sum = 0.0;
    for (sn_index i = 0; i < f->params->fibers; i++) {
        const sn_polyline *line = &f->lines[i];
        if (line->count == 0) return INFINITY;
        for (sn_index k = 1; k + 1 < line->count; k++) {
            sn_vec3 a = sn_sub(line->points[k], line->points[k - 1]), b = sn_sub(line->points[k + 1], line->points[k]);
            sum += sn_quick_atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b));
        }
    }
    return sum / (double)f->params->fibers;
}

/* Fibres at the end of the muscle that has the fewest. */
static sn_status count_fewest(const filling *f, sn_index *fewest, sn_error *error) {
    const fill_levels *l = &f->levels;
    const sn_index ends[2] = {0, l->level_count - 1};
    sn_index *count = SN_NEW(sn_index, l->loop_count);
    if (!count) return sn_fail_memory(error, "the fibres");
    for (sn_index i = 0; i < f->params->fibers; i++)
        for (int k = 0; k < 2; k++) {
            fill_uv at = f->seeds[i];
            sn_index loop = fill_carry(l, ends[k], at, &at);
            if (loop != SN_NONE) count[loop]++;
        }
    *fewest = f->params->fibers;
    for (int k = 0; k < 2; k++)
        for (sn_index i = l->first[ends[k]]; i < l->first[ends[k] + 1]; i++)
            if (l->loops[i].reached && count[i] < *fewest) *fewest = count[i];
    free(count);
    return SN_OK;
}

static void take_other(filling *f, filling *other, const sn_fill_report *of_other, sn_fill_report *report) {
    filling kept = *f;
    *f = *other;
    *other = kept;
    report->leaf_loops = of_other->leaf_loops;
    report->leaves_reached = of_other->leaves_reached;
    report->bend_farthest = of_other->bend_farthest;
    report->flux = true;
}

/* Slices by length make fibres turn aside where a part of the muscle without an end of its own widens them; by flux they pass it. What
 * turns less is kept; where the surface is rough for its size that is the former. */
static sn_status try_flux(filling *f, const sn_topology *topology, const fill_ends *ends, sn_fill_report *report, sn_error *error) {
    filling other = {.muscle = f->muscle, .params = f->params, .diagonal = f->diagonal, .mean_edge = f->mean_edge, .closed = f->closed};
    sn_fill_report its = {0};
    sn_error failure = {0};
    other.flux = true;
    sn_status status = lay_fibers(&other, topology, ends, NULL, &its, &failure);
    sn_index fewest[2] = {0, 0};
    if (!status) status = count_fewest(f, &fewest[0], &failure);
    if (!status) status = count_fewest(&other, &fewest[1], &failure);
    int64_t reached = (int64_t)its.leaves_reached * report->leaf_loops, before = (int64_t)report->leaves_reached * its.leaf_loops;
    bool shared = reached >= before && fewest[1] + FEW_FIBERS * f->params->fibers >= LEAST_SHARE * fewest[0];
    if (!status && shared && mean_turning(&other) < LESS_TURNING * mean_turning(f)) take_other(f, &other, &its, report);
    filling_free(&other);
    if (status != SN_ERROR_MEMORY) return SN_OK; /* the others are good */
    *error = failure;
    return status;
}

static sn_status fill_between(filling *f, const sn_topology *topology, const fill_ends *ends, sn_trace *trace, sn_fill_report *report,
                              sn_error *error) {
    sn_status status = lay_fibers(f, topology, ends, trace, report, error);
    if (status || report->spread || mean_turning(f) < MUCH_TURNING) return status;
    return try_flux(f, topology, ends, report, error);
}

static sn_status fill(filling *f, const sn_topology *topology, sn_trace *trace, sn_fibers *out, sn_fill_report *report, sn_error *error) {
    fill_ends ends = {0};
    sn_status status = fill_find_ends(f->muscle, topology, f->params, trace, &ends, error);
    report->ends = ends.kind;
    report->chosen = ends.choice;
    report->leaves = ends.leaves;
    if (!status) status = fill_between(f, topology, &ends, trace, report, error);
    fill_ends_free(&ends);
    if (status) return status;
    status = keep_inside(f, trace, report, error);
    if (status && status != SN_STOPPED) return status;
    sn_status measured = measure_fibers(f, status ? NULL : trace);
    if (!status) status = measured;
    summarise(f, report);
    sn_status handed = hand_over(f, out, error);
    if (!handed) handed = fill_judge(&f->muscle->mesh, topology, out, report, error);
    return handed ? handed : status;
}

sn_status sn_fill_fibers(const sn_muscle *muscle, const sn_fill_params *params, sn_trace *trace, sn_fibers *out, sn_fill_report *report,
                         sn_error *error) {
    sn_topology topology = {0};
    filling f = {.muscle = muscle, .params = params};
    *out = (sn_fibers){0};
    *report = (sn_fill_report){0};
    sn_status status = check_params(params, error);
    if (!status) status = sn_mesh_validate(&muscle->mesh, error);
    if (!status) status = sn_topology_build(&muscle->mesh, &topology, error);
    if (status) return status;
    f.diagonal = sn_box_diagonal(sn_mesh_box(&muscle->mesh));
    f.mean_edge = sn_mesh_mean_edge(&muscle->mesh, &topology);
    f.closed = true;
    for (sn_index e = 0; e < topology.edge_count; e++) f.closed &= topology.edges[e].triangle_count == 2;
    report->closed = f.closed;
    status = sn_trace_stopped(trace) ? SN_STOPPED : fill(&f, &topology, trace, out, report, error);
    filling_free(&f);
    sn_topology_free(&topology);
    return status;
}
