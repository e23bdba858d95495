/*
 * architecture.c -- fibre length, pennation and physiological cross-section area of a rigged muscle, with and without its tendons.
 */
#include "sinew/architecture.h"

#include "levels.h"
#include "sinew/exact.h"

#include <stdlib.h>

enum { STEPS = 4 };    /* places on each segment where a fibre is asked whether it is in tendon */
#define END_SHARE 0.2  /* of a fibre's length: what shows its direction at an end */
#define ROUNDING 1e-12 /* of a length: what adding it up in another order may change */

const char *const sn_tendon_names[] = {"none", "thickness", "painted", "given", NULL};

typedef struct measuring {
    const sn_muscle *muscle;
    const sn_architecture_params *params;
    sn_topology topology;
    levels levels;
    sn_surface *surface;
    double *lengths, *bellies;   /* (fibres) */
    double *pennation[2];        /* (fibres) */
    const sn_attribute *painted; /* NULL = it is not in use */
} measuring;

sn_architecture_params sn_architecture_defaults(void) {
    return (sn_architecture_params){.tendon = SN_TENDON_THICKNESS, .thin = 0.15, .slender = 2.5};
}

/* ---- what is asked for ------------------------------------------------------------------------------------------------------ */

static sn_status check_params(const sn_architecture_params *p, sn_error *error) {
    if (!(p->thin > 0.0 && p->thin < 1.0)) return sn_fail(error, SN_ERROR_USAGE, "the share that is thin must be between 0 and 1");
    if (!(p->slender > 0.0 && isfinite(p->slender))) return sn_fail(error, SN_ERROR_USAGE, "the slenderness of a tendon must be above 0");
    for (int end = 0; p->tendon == SN_TENDON_GIVEN && end < 2; end++) {
        double length = p->ends[end].length;
        if (!(length >= 0.0 && isfinite(length))) return sn_fail(error, SN_ERROR_USAGE, "the length of a tendon must not be below 0");
        if (p->ends[end].is_share && length > 1.0)
            return sn_fail(error, SN_ERROR_USAGE, "the share of a tendon must not be above 1 (100 %%)");
    }
    return SN_OK;
}

static sn_status find_painted(measuring *m, sn_error *error) {
    if (m->params->tendon != SN_TENDON_PAINTED) return SN_OK;
    const sn_mesh *mesh = &m->muscle->mesh;
    m->painted = sn_mesh_attribute(mesh, SN_TENDON_ATTRIBUTE);
    if (m->painted == NULL || m->painted->components != 1)
        return sn_fail(error, SN_ERROR_INPUT, "the mesh has no painted map \"" SN_TENDON_ATTRIBUTE "\" of one number per vertex");
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        if (!(m->painted->values[v] >= 0.0 && m->painted->values[v] <= 1.0))
            return sn_fail(error, SN_ERROR_INPUT,
                           "the painted map \"" SN_TENDON_ATTRIBUTE
                           "\" is %g at vertex %ld; it must be in [0,1]: a map of 0 to 255 must be "
                           "divided by 255",
                           m->painted->values[v], (long)v);
    return SN_OK;
}

static double fiber_length(const sn_polyline *line) {
    double length = 0.0;
    for (sn_index k = 1; k < line->count; k++) length += sn_distance(line->points[k - 1], line->points[k]);
    return length;
}

static sn_status measure_lengths(measuring *m, sn_error *error) {
    const sn_fibers *fibers = &m->muscle->fibers;
    if (fibers->polyline_count == 0)
        return sn_fail(error, SN_ERROR_INPUT, "the muscle has no fibres through its volume to measure; fiber-fill makes them");
    for (sn_index i = 0; i < fibers->polyline_count; i++) {
        m->lengths[i] = fiber_length(&fibers->polylines[i]);
        if (!(m->lengths[i] > 0.0)) return sn_fail(error, SN_ERROR_INPUT, "fibre %ld has no length", (long)i);
    }
    return SN_OK;
}

/* ---- the map ---------------------------------------------------------------------------------------------------------------- */

/* A patch between two levels is what the loops around it are, on average. */
static void map_by_loops(const levels *l, const double *loop, double *map) {
    for (sn_index v = 0; v < l->mesh->vertex_count; v++) {
        sn_index node = l->vertex_node[v], count = l->link_start[node + 1] - l->link_start[node];
        double sum = 0.0;
        for (sn_index k = l->link_start[node]; k < l->link_start[node + 1]; k++)
            sum += l->links[k] < l->loop_count ? loop[l->links[k]] : 0.0;
        map[v] = count > 0 ? sum / count : 0.0;
    }
}

static sn_status map_by_thickness(measuring *m, double *map, sn_error *error) {
    double *loop = SN_NEW(double, (size_t)m->levels.loop_count + 1);
    sn_status status = loop != NULL ? SN_OK : sn_fail_memory(error, "the tendons of the muscle");
    if (status == SN_OK) status = levels_find_tendons(&m->levels, m->params->thin, m->params->slender, loop, error);
    if (status == SN_OK) map_by_loops(&m->levels, loop, map);
    free(loop);
    return status;
}

/* Is the place `at` of a fibre, by length from its origin, in one of the tendons given by hand? */
static double given_at(const measuring *m, sn_index fiber, double at) {
    double length = m->lengths[fiber], tendon[2];
    for (int end = 0; end < 2; end++) tendon[end] = m->params->ends[end].length * (m->params->ends[end].is_share ? length : 1.0);
    return at < tendon[0] || at > length - tendon[1] ? 1.0 : 0.0;
}

/* A vertex is what the fibre nearest to it is. */
static double given_at_vertex(const measuring *m, sn_vec3 p) {
    const sn_fibers *fibers = &m->muscle->fibers;
    double least = INFINITY, value = 0.0;
    for (sn_index i = 0; i < fibers->polyline_count; i++) {
        const sn_polyline *line = &fibers->polylines[i];
        double way = 0.0;
        for (sn_index k = 0; k + 1 < line->count; k++) {
            sn_vec3 d = sn_sub(line->points[k + 1], line->points[k]);
            double square = sn_norm2(d), t = square > 0.0 ? fmin(fmax(sn_dot(sn_sub(p, line->points[k]), d) / square, 0.0), 1.0) : 0.0;
            double off = sn_norm2(sn_sub(p, sn_add_scaled(line->points[k], d, t)));
            if (off < least) least = off, value = given_at(m, i, way + t * sqrt(square));
            way += sqrt(square);
        }
    }
    return value;
}

static sn_status make_map(measuring *m, double *map, sn_error *error) {
    const sn_mesh *mesh = &m->muscle->mesh;
    if (m->params->tendon == SN_TENDON_THICKNESS) return map_by_thickness(m, map, error);
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        if (m->painted != NULL) map[v] = m->painted->values[v];
        if (m->params->tendon == SN_TENDON_GIVEN) map[v] = given_at_vertex(m, mesh->positions[v]);
    }
    return SN_OK;
}

/* ---- along a fibre ------------------------------------------------------------------------------------------------------------ */

/* A value of the vertices at the surface's closest point. */
static double at_surface(const measuring *m, const double *values, sn_vec3 p) {
    sn_closest at = sn_surface_closest(m->surface, p, INFINITY);
    if (at.triangle == SN_NONE) return NAN;
    const sn_index *v = m->muscle->mesh.triangles[at.triangle].v;
    return at.barycentric[0] * values[v[0]] + at.barycentric[1] * values[v[1]] + at.barycentric[2] * values[v[2]];
}

static sn_vec3 point_along(const sn_polyline *line, double at) {
    double way = 0.0;
    for (sn_index k = 0; k + 1 < line->count; k++) {
        double step = sn_distance(line->points[k], line->points[k + 1]);
        if (step > 0.0 && (way + step >= at || k + 2 == line->count))
            return sn_lerp(line->points[k], line->points[k + 1], fmin(fmax((at - way) / step, 0.0), 1.0));
        way += step;
    }
    return line->points[line->count - 1];
}

/* The part of a fibre in the belly: its length, and where it begins and ends. */
typedef struct belly_part {
    double length, begin, end;
} belly_part;

static double tendon_at(const measuring *m, const double *map, sn_index fiber, double at) {
    if (m->params->tendon == SN_TENDON_NONE) return 0.0;
    if (m->params->tendon == SN_TENDON_GIVEN) return given_at(m, fiber, at);
    double value = at_surface(m, map, point_along(&m->muscle->fibers.polylines[fiber], at));
    return isnan(value) ? 0.0 : value;
}

static belly_part find_belly(const measuring *m, const double *map, sn_index fiber) {
    double length = m->lengths[fiber];
    sn_index count = STEPS * (m->muscle->fibers.polylines[fiber].count - 1);
    belly_part part = {0.0, length, 0.0};
    for (sn_index i = 0; i < count; i++) {
        double from = length * i / count, to = length * (i + 1) / count, tendon = tendon_at(m, map, fiber, 0.5 * (from + to));
        part.length += (1.0 - tendon) * (to - from);
        if (tendon >= 0.5) continue;
        part.begin = fmin(part.begin, from);
        part.end = to;
    }
    if (!(part.end > part.begin)) part = (belly_part){0.0, 0.0, length}; /* all of it tendon: measured from tip to tip */
    return part;
}

/* The angle between the fibre's direction at one of its ends and the line of action there. */
static double pennation_at(const measuring *m, sn_index fiber, double end, double inwards) {
    const sn_polyline *line = &m->muscle->fibers.polylines[fiber];
    sn_vec3 p = point_along(line, end), d = sn_sub(point_along(line, inwards), p);
    double along = at_surface(m, m->levels.along, p);
    if (isnan(along)) return 0.0;
    sn_vec3 action = levels_direction(&m->levels, along);
    return sn_quick_atan2(sn_norm(sn_cross(d, action)), fabs(sn_dot(d, action)));
}

static void measure_fibers(measuring *m, const double *map) {
    for (sn_index i = 0; i < m->muscle->fibers.polyline_count; i++) {
        belly_part part = find_belly(m, map, i);
        double reach = END_SHARE * (part.end - part.begin);
        m->bellies[i] = part.length;
        m->pennation[0][i] = pennation_at(m, i, part.begin, part.begin + reach);
        m->pennation[1][i] = pennation_at(m, i, part.end, part.end - reach);
    }
}

/* ---- figures -------------------------------------------------------------------------------------------------------------------- */

/* Of the values above `floor`; *count of them. */
static sn_spread spread_of(sn_index number, const double *values, double floor, sn_index *count) {
    sn_spread s = {0.0, 0.0, INFINITY, -INFINITY};
    double squares = 0.0;
    *count = 0;
    for (sn_index i = 0; i < number; i++) {
        if (!(values[i] > floor)) continue;
        (*count)++;
        s.mean += values[i];
        s.least = fmin(s.least, values[i]);
        s.greatest = fmax(s.greatest, values[i]);
    }
    if (*count == 0) return (sn_spread){0};
    s.mean /= *count;
    for (sn_index i = 0; i < number; i++)
        if (values[i] > floor) squares += (values[i] - s.mean) * (values[i] - s.mean);
    s.deviation = sqrt(squares / *count);
    return s;
}

/* Share of the volume in tendon: sections by what their rims are. */
static sn_status measure_tendon_volume(const measuring *m, const double *map, double *out, sn_error *error) {
    const levels *l = &m->levels;
    double *sum = SN_NEW(double, (size_t)l->loop_count + 1), *weight = SN_NEW(double, (size_t)l->loop_count + 1), all = 0.0, tendon = 0.0;
    if (sum != NULL && weight != NULL) {
        for (sn_index t = 0; t < l->mesh->triangle_count; t++) {
            const sn_index *v = l->mesh->triangles[t].v;
            for (sn_index k = l->piece_start[t]; k < l->piece_start[t + 1]; k++) {
                sum[l->piece[k]] += (map[v[0]] + map[v[1]] + map[v[2]]) / 3.0;
                weight[l->piece[k]] += 1.0;
            }
        }
        for (sn_index i = 0; i < l->loop_count; i++) {
            all += l->loops[i].area;
            tendon += weight[i] > 0.0 ? l->loops[i].area * sum[i] / weight[i] : 0.0;
        }
    }
    bool made = sum != NULL && weight != NULL;
    *out = all > 0.0 ? tendon / all : 0.0;
    free(sum);
    free(weight);
    return made ? SN_OK : sn_fail_memory(error, "the tendons of the muscle");
}

static double share_in_tendon(const measuring *m) {
    double all = 0.0, belly = 0.0;
    for (sn_index i = 0; i < m->muscle->fibers.polyline_count; i++) {
        all += m->lengths[i];
        belly += m->bellies[i];
    }
    if (belly >= (1.0 - ROUNDING) * all) return 0.0;
    return fmin(1.0 - belly / all, 1.0);
}

static void summarise(const measuring *m, sn_architecture *out) {
    sn_index count = out->fibers = m->muscle->fibers.polyline_count, used;
    const sn_topology *topology = &m->topology;
    out->closed = true;
    for (sn_index e = 0; e < topology->edge_count; e++) out->closed = out->closed && topology->edges[e].triangle_count == 2;
    out->volume = fabs(sn_mesh_volume(&m->muscle->mesh));
    out->length = spread_of(count, m->lengths, 0.0, &used);
    out->belly = spread_of(count, m->bellies, 1e-9 * out->length.mean, &out->belly_fibers);
    for (int end = 0; end < 2; end++) out->pennation[end] = spread_of(count, m->pennation[end], -1.0, &used);
    out->mean_pennation = 0.5 * (out->pennation[0].mean + out->pennation[1].mean);
    out->tendon = m->params->tendon;
    out->tendon_share = share_in_tendon(m);
    double cosine = sn_cos(out->mean_pennation);
    out->area = out->volume / out->length.mean * cosine;
    out->belly_area = out->belly_fibers > 0 ? out->volume * (1.0 - out->tendon_volume) / out->belly.mean * cosine : 0.0;
}

/* ---- the whole ------------------------------------------------------------------------------------------------------------------ */

static sn_status measuring_alloc(measuring *m, sn_architecture *out, sn_error *error) {
    size_t count = (size_t)m->muscle->fibers.polyline_count + 1;
    m->lengths = SN_NEW(double, count);
    m->bellies = SN_NEW(double, count);
    m->pennation[0] = SN_NEW(double, count);
    m->pennation[1] = SN_NEW(double, count);
    out->map = SN_NEW(double, m->muscle->mesh.vertex_count);
    bool made = m->lengths != NULL && m->bellies != NULL && m->pennation[0] != NULL && m->pennation[1] != NULL && out->map != NULL;
    return made ? SN_OK : sn_fail_memory(error, "the architecture of the muscle");
}

static void measuring_free(measuring *m) {
    sn_surface_destroy(m->surface);
    levels_free(&m->levels);
    sn_topology_free(&m->topology);
    free(m->lengths);
    free(m->bellies);
    free(m->pennation[0]);
    free(m->pennation[1]);
}

sn_status sn_architecture_measure(const sn_muscle *muscle, const sn_architecture_params *params, sn_architecture *out, sn_error *error) {
    measuring m = {.muscle = muscle, .params = params};
    *out = (sn_architecture){0};
    sn_status status = check_params(params, error);
    if (status == SN_OK) status = sn_mesh_validate(&muscle->mesh, error);
    if (status == SN_OK) status = find_painted(&m, error);
    if (status == SN_OK) status = measuring_alloc(&m, out, error);
    if (status == SN_OK) status = measure_lengths(&m, error);
    if (status == SN_OK) status = sn_topology_build(&muscle->mesh, &m.topology, error);
    if (status == SN_OK) status = levels_build(&muscle->mesh, &m.topology, &m.levels, error);
    if (status == SN_OK) status = sn_surface_create_plain(&muscle->mesh, &m.surface, error);
    if (status == SN_OK) status = make_map(&m, out->map, error);
    if (status == SN_OK) {
        measure_fibers(&m, out->map);
        status = measure_tendon_volume(&m, out->map, &out->tendon_volume, error);
    }
    if (status == SN_OK) summarise(&m, out);
    measuring_free(&m);
    if (status != SN_OK) sn_architecture_free(out);
    return status;
}

void sn_architecture_free(sn_architecture *architecture) {
    free(architecture->map);
    *architecture = (sn_architecture){0};
}
