/*
 * repair.c -- manifold, holes, decimation, self-intersections: what sinew asks of CGAL, with validation before and recounting after,
 * and with everything that hangs on vertices and triangles carried over.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "cgal_bridge.h"
#include "edit.h"

/* ---- to the bridge and back ------------------------------------------------------------------------------------------ */

/* The unit box's place in the mesh's coordinates: p = centre + size q. */
typedef struct frame {
    sn_vec3 centre;
    double size;
} frame;

static void bridge_free(sn_bridge_mesh *mesh) {
    free(mesh->points);
    free(mesh->triangles);
    free(mesh->vertex_origin);
    free(mesh->triangle_origin);
    *mesh = (sn_bridge_mesh){0};
}

static sn_status find_frame(const sn_mesh *mesh, frame *out, sn_error *error) {
    sn_status status = sn_mesh_validate(mesh, error);
    if (status != SN_OK) return status;
    sn_box box = sn_mesh_box(mesh);
    *out = (frame){sn_lerp(box.low, box.high, 0.5), sn_box_diagonal(box)};
    if (out->size > 0.0 && isfinite(out->size)) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "the surface has no extent that can be computed with (diagonal %g)", out->size);
}

/* Triangles with a repeated index must be gone: CGAL does not expect them. */
static sn_status check_indices(const sn_mesh *mesh, sn_error *error) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!sn_triangle_repeats_index(mesh->triangles[t])) continue;
        return sn_fail(error, SN_ERROR_INPUT, "triangle %d names a vertex twice; drop degenerate triangles first", t);
    }
    return SN_OK;
}

static sn_status to_bridge(const sn_mesh *mesh, sn_bridge_mesh *out, frame *where, sn_error *error) {
    *out = (sn_bridge_mesh){.vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count};
    sn_status status = find_frame(mesh, where, error);
    if (status != SN_OK) return status;
    out->points = sn_alloc((size_t)mesh->vertex_count, 3 * sizeof *out->points);
    out->triangles = sn_alloc((size_t)mesh->triangle_count, 3 * sizeof *out->triangles);
    if (out->points == NULL || out->triangles == NULL) {
        bridge_free(out);
        return sn_fail_memory(error, "repairing a mesh");
    }
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        sn_vec3 q = sn_scale(sn_sub(mesh->positions[i], where->centre), 1.0 / where->size);
        memcpy(out->points + 3 * (size_t)i, (double[]){q.x, q.y, q.z}, 3 * sizeof(double));
    }
    memcpy(out->triangles, mesh->triangles, (size_t)mesh->triangle_count * sizeof *mesh->triangles);
    return SN_OK;
}

/* A vertex that the library left where it was gets the very coordinates it had. */
static sn_vec3 position_back(const sn_mesh *before, const sn_bridge_mesh *in, const sn_bridge_mesh *out, frame where, sn_index i) {
    sn_index origin = out->vertex_origin[i];
    const double *q = out->points + 3 * (size_t)i;
    bool unmoved = origin != SN_NONE && memcmp(q, in->points + 3 * (size_t)origin, 3 * sizeof *q) == 0;
    return unmoved ? before->positions[origin] : sn_add_scaled(where.centre, sn_v3(q[0], q[1], q[2]), where.size);
}

static sn_status check_back(const sn_bridge_mesh *out, sn_error *error) {
    for (size_t i = 0; i < 3 * (size_t)out->vertex_count; i++) {
        if (!isfinite(out->points[i]))
            return sn_fail(error, SN_ERROR_INTERNAL, "the repair library returned a coordinate that is not finite");
    }
    for (size_t i = 0; i < 3 * (size_t)out->triangle_count; i++) {
        if (out->triangles[i] < 0 || out->triangles[i] >= out->vertex_count) {
            return sn_fail(error, SN_ERROR_INTERNAL, "the repair library returned an index out of range");
        }
    }
    return SN_OK;
}

static bool copy_names(const sn_mesh *before, sn_mesh *after) {
    for (sn_index i = 0; i < before->attribute_count; i++) {
        sn_attribute *copy = sn_mesh_add_attribute(after, before->attributes[i].name, before->attributes[i].components);
        if (copy == NULL) return false;
        copy->integer = before->attributes[i].integer;
    }
    if (before->group_count == 0) return true;
    after->triangle_group = SN_NEW(sn_index, after->triangle_count);
    after->group_names = SN_NEW(char *, before->group_count);
    if (after->triangle_group == NULL || after->group_names == NULL) return false;
    after->group_count = before->group_count;
    for (sn_index i = 0; i < before->group_count; i++) {
        after->group_names[i] = sn_strdup(before->group_names[i]);
        if (after->group_names[i] == NULL && before->group_names[i] != NULL) return false;
    }
    return true;
}

static void carry_attributes(const sn_mesh *before, const sn_index *vertex_origin, sn_mesh *after) {
    for (sn_index a = 0; a < before->attribute_count; a++) {
        size_t components = (size_t)before->attributes[a].components;
        for (sn_index i = 0; i < after->vertex_count; i++) {
            if (vertex_origin[i] == SN_NONE) continue;
            memcpy(after->attributes[a].values + (size_t)i * components,
                   before->attributes[a].values + (size_t)vertex_origin[i] * components, components * sizeof(double));
        }
    }
}

/* *after is the mesh that came back, with the attributes and groups of the vertices and triangles that it came from. */
static sn_status from_bridge(const sn_mesh *before, const sn_bridge_mesh *in, const sn_bridge_mesh *out, frame where, sn_mesh *after,
                             sn_error *error) {
    sn_status status = check_back(out, error);
    if (status == SN_OK) status = sn_mesh_alloc(after, out->vertex_count, out->triangle_count, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < out->vertex_count; i++) after->positions[i] = position_back(before, in, out, where, i);
    memcpy(after->triangles, out->triangles, (size_t)out->triangle_count * sizeof *after->triangles);
    if (!copy_names(before, after)) {
        sn_mesh_free(after);
        return sn_fail_memory(error, "repairing a mesh");
    }
    carry_attributes(before, out->vertex_origin, after);
    for (sn_index t = 0; after->triangle_group != NULL && t < after->triangle_count; t++) {
        sn_index origin = out->triangle_origin[t];
        after->triangle_group[t] = origin != SN_NONE ? before->triangle_group[origin] : SN_NONE;
    }
    return SN_OK;
}

static void replace(sn_mesh *mesh, sn_mesh *by) {
    sn_mesh_free(mesh);
    *mesh = *by;
    *by = (sn_mesh){0};
}

/* ---- manifold --------------------------------------------------------------------------------------------------------- */

static bool same_direction(const sn_mesh *mesh, const sn_edge *edge) {
    bool forward[2] = {false, false};
    for (int side = 0; side < 2; side++) {
        const sn_index *v = mesh->triangles[edge->triangle[side]].v;
        for (int k = 0; k < 3; k++) forward[side] |= v[k] == edge->v[0] && v[(k + 1) % 3] == edge->v[1];
    }
    return forward[0] == forward[1];
}

/* Give every triangle a side so that neighbours across manifold edges agree: possible on a two-sided surface only. side and
 * queue (triangle_count) are scratch. */
static bool can_be_oriented(const sn_mesh *mesh, const sn_topology *topology, signed char *side, sn_index *queue) {
    for (sn_index seed = 0; seed < mesh->triangle_count; seed++) {
        if (side[seed] != 0) continue;
        sn_index head = 0, tail = 0;
        side[seed] = 1;
        queue[tail++] = seed;
        while (head < tail) {
            sn_index t = queue[head++];
            for (int k = 0; k < 3; k++) {
                sn_index e = topology->triangle_edges[t][k];
                if (e == SN_NONE || topology->edges[e].triangle_count != 2) continue;
                const sn_edge *edge = &topology->edges[e];
                sn_index other = edge->triangle[0] == t ? edge->triangle[1] : edge->triangle[0];
                signed char wanted = same_direction(mesh, edge) ? (signed char)-side[t] : side[t];
                if (side[other] == 0)
                    queue[tail++] = other;
                else if (side[other] != wanted)
                    return false;
                side[other] = wanted;
            }
        }
    }
    return true;
}

static void flip(sn_triangle *triangle) {
    sn_index kept = triangle->v[1];
    triangle->v[1] = triangle->v[2];
    triangle->v[2] = kept;
}

static double twice_area(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* Where most of a component was turned, turn it all back: the smaller part was the wrong one. was_flipped (triangle_count). */
static sn_status keep_majority(sn_mesh *mesh, bool *was_flipped, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index *component = SN_NEW(sn_index, mesh->triangle_count);
    sn_index count = component != NULL ? sn_mesh_components(mesh, &topology, component) : 0;
    double *balance = SN_NEW(double, count);
    if (component != NULL && balance != NULL) {
        for (sn_index t = 0; t < mesh->triangle_count; t++) {
            balance[component[t]] += was_flipped[t] ? twice_area(mesh, t) : -twice_area(mesh, t);
        }
        for (sn_index t = 0; t < mesh->triangle_count; t++) {
            if (balance[component[t]] <= 0.0) continue;
            flip(&mesh->triangles[t]);
            was_flipped[t] = !was_flipped[t];
        }
    } else {
        status = sn_fail_memory(error, "orienting a mesh");
    }
    free(balance);
    free(component);
    sn_topology_free(&topology);
    return status;
}

/* Turn the triangles of the other side; the rest of the mesh is not touched. */
static sn_status turn_sides(sn_mesh *mesh, const signed char *side, sn_index *flipped, sn_error *error) {
    bool *was_flipped = SN_NEW(bool, mesh->triangle_count);
    if (was_flipped == NULL) return sn_fail_memory(error, "orienting a mesh");
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        was_flipped[t] = side[t] < 0;
        if (was_flipped[t]) flip(&mesh->triangles[t]);
    }
    sn_status status = keep_majority(mesh, was_flipped, error);
    for (sn_index t = 0; t < mesh->triangle_count; t++) *flipped += was_flipped[t];
    free(was_flipped);
    return status;
}

/* A two-sided surface whose edges carry one or two triangles can be oriented in place; turn = false only looks. */
static sn_status orient_in_place(sn_mesh *mesh, bool turn, sn_manifold_report *report, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    signed char *side = SN_NEW(signed char, mesh->triangle_count);
    sn_index *queue = SN_NEW(sn_index, mesh->triangle_count);
    if (side != NULL && queue != NULL) {
        report->orientable = can_be_oriented(mesh, &topology, side, queue);
        if (report->orientable && turn) status = turn_sides(mesh, side, &report->flipped, error);
    } else {
        status = sn_fail_memory(error, "orienting a mesh");
    }
    free(side);
    free(queue);
    sn_topology_free(&topology);
    return status;
}

static sn_status settle_orientation(const sn_bridge_mesh *in, const sn_bridge_mesh *out, sn_mesh *mesh, sn_index *flipped,
                                    sn_error *error) {
    bool *was_flipped = SN_NEW(bool, mesh->triangle_count);
    if (was_flipped == NULL) return sn_fail_memory(error, "orienting a mesh");
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_index second = out->vertex_origin[out->triangles[3 * (size_t)t + 1]];
        was_flipped[t] = second != in->triangles[3 * (size_t)out->triangle_origin[t] + 1];
    }
    sn_status status = keep_majority(mesh, was_flipped, error);
    for (sn_index t = 0; t < mesh->triangle_count; t++) *flipped += was_flipped[t];
    free(was_flipped);
    return status;
}

static sn_status orient_and_stitch(sn_mesh *mesh, sn_manifold_report *report, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_bridge_orientation done = {0};
    sn_mesh after = {0};
    frame where;
    sn_status status = to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_make_manifold(&in, &out, &done, error);
    if (status == SN_OK) status = from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = settle_orientation(&in, &out, &after, &report->flipped, error);
    if (status == SN_OK) {
        report->split_vertices = done.split_vertices;
        report->stitched_edges = done.stitched_edges;
        replace(mesh, &after);
    }
    sn_mesh_free(&after);
    bridge_free(&in);
    bridge_free(&out);
    return status;
}

sn_status sn_make_manifold(sn_mesh *mesh, sn_manifold_report *report, sn_error *error) {
    *report = (sn_manifold_report){.orientable = true};
    sn_mesh_report found;
    sn_status status = sn_mesh_inspect(mesh, &found, error);
    if (status == SN_OK && found.nonmanifold_edges > 0) {
        status = sn_drop_walls(mesh, &report->wall_triangles, error);
        if (status == SN_OK && report->wall_triangles > 0) status = sn_mesh_inspect(mesh, &found, error);
    }
    bool manifold = found.nonmanifold_edges == 0 && found.nonmanifold_vertices == 0;
    if (status != SN_OK || mesh->triangle_count == 0 || (manifold && found.inconsistent_edges == 0)) return status;
    status = orient_in_place(mesh, manifold, report, error);
    if (status == SN_OK && !(manifold && report->orientable)) status = orient_and_stitch(mesh, report, error);
    return status;
}

/* ---- holes ------------------------------------------------------------------------------------------------------------ */

typedef struct hole_count {
    sn_trace *trace;
    sn_index filled;
} hole_count;

static bool hole_filled(void *user, sn_index edges, sn_index triangles) {
    hole_count *count = user;
    count->filled++;
    return SN_TRACE(count->trace, "hole", sn_trace_number("edges", edges), sn_trace_number("triangles", triangles));
}

static sn_status fill_by_library(sn_mesh *mesh, sn_index max_edges, hole_count *count, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    frame where;
    sn_status status = to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_fill_holes(&in, max_edges, hole_filled, count, &out, error);
    bool stopped = status == SN_STOPPED;
    if (status == SN_OK || stopped) status = from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) replace(mesh, &after);
    bridge_free(&in);
    bridge_free(&out);
    return status == SN_OK && stopped ? SN_STOPPED : status;
}

/* The hole's border, run so that new triangles on it are oriented as the old ones: next (vertex_count), SN_NONE off the border.
 * Returns its number of edges. On an oriented manifold no vertex has two. */
static sn_index find_border(const sn_mesh *mesh, const sn_topology *topology, sn_index *next) {
    sn_index edges = 0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) next[v] = SN_NONE;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            sn_index e = topology->triangle_edges[t][k];
            if (e == SN_NONE || topology->edges[e].triangle_count != 1) continue;
            next[mesh->triangles[t].v[(k + 2) % 3]] = mesh->triangles[t].v[(k + 1) % 3];
            edges++;
        }
    }
    return edges;
}

/* Edges of the loop through `start`; 0 where it does not close. */
static sn_index loop_length(const sn_index *next, sn_index start, sn_index most) {
    sn_index length = 0;
    for (sn_index v = start; length <= most; v = next[v]) {
        if (v == SN_NONE) return 0;
        if (v == start && length > 0) return length;
        length++;
    }
    return 0;
}

/* Room for more vertices and triangles; attributes and groups with it. */
static bool make_room(sn_mesh *mesh, sn_index vertices, sn_index triangles) {
    size_t v = (size_t)mesh->vertex_count + (size_t)vertices, t = (size_t)mesh->triangle_count + (size_t)triangles;
    sn_vec3 *positions = sn_realloc(mesh->positions, v, sizeof *positions);
    if (positions != NULL) mesh->positions = positions;
    sn_triangle *grown = sn_realloc(mesh->triangles, t, sizeof *grown);
    if (grown != NULL) mesh->triangles = grown;
    bool enough = positions != NULL && grown != NULL;
    for (sn_index a = 0; a < mesh->attribute_count; a++) {
        double *values = sn_realloc(mesh->attributes[a].values, v * (size_t)mesh->attributes[a].components, sizeof *values);
        if (values != NULL) mesh->attributes[a].values = values;
        enough = enough && values != NULL;
    }
    if (mesh->triangle_group == NULL) return enough;
    sn_index *group = sn_realloc(mesh->triangle_group, t, sizeof *group);
    if (group != NULL) mesh->triangle_group = group;
    return enough && group != NULL;
}

static void add_triangle(sn_mesh *mesh, sn_index a, sn_index b, sn_index c) {
    if (mesh->triangle_group != NULL) mesh->triangle_group[mesh->triangle_count] = SN_NONE;
    mesh->triangles[mesh->triangle_count++] = (sn_triangle){{a, b, c}};
}

/* A new vertex at the mean of a loop, its attributes the means of the loop's. */
static sn_index add_loop_centre(sn_mesh *mesh, const sn_index *next, sn_index start, sn_index length) {
    sn_index centre = mesh->vertex_count++;
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index i = 0, v = start; i < length; i++, v = next[v]) sum = sn_add_scaled(sum, mesh->positions[v], 1.0 / length);
    mesh->positions[centre] = sum;
    for (sn_index a = 0; a < mesh->attribute_count; a++) {
        size_t components = (size_t)mesh->attributes[a].components;
        double *values = mesh->attributes[a].values;
        for (size_t c = 0; c < components; c++) {
            double mean = 0.0;
            for (sn_index i = 0, v = start; i < length; i++, v = next[v]) mean += values[(size_t)v * components + c] / length;
            values[(size_t)centre * components + c] = mesh->attributes[a].integer ? round(mean) : mean;
        }
    }
    return centre;
}

/* Close a loop that the library would not: three edges by a triangle, more by a fan around their mean. */
static void close_loop(sn_mesh *mesh, sn_index *next, sn_index start, sn_index length) {
    sn_index second = next[start], third = next[second], centre = SN_NONE;
    if (length > 3)
        centre = add_loop_centre(mesh, next, start, length);
    else
        add_triangle(mesh, start, second, third);
    for (sn_index i = 0, v = start; i < length; i++) {
        sn_index after = next[v];
        if (centre != SN_NONE) add_triangle(mesh, v, after, centre);
        next[v] = SN_NONE; /* done */
        v = after;
    }
}

/* Does a loop of three run around a triangle that stands alone? Closing it would double the triangle. */
static bool is_lone_triangle(const sn_topology *topology, const sn_index *next, sn_index start) {
    sn_index e = sn_topology_edge(topology, start, next[start]);
    const sn_index *other = topology->triangle_edges[topology->edges[e].triangle[0]];
    return topology->edges[other[0]].triangle_count == 1 && topology->edges[other[1]].triangle_count == 1 &&
           topology->edges[other[2]].triangle_count == 1;
}

static sn_status close_by_fans(sn_mesh *mesh, sn_index max_edges, hole_count *count, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    sn_index before = mesh->vertex_count, *next = SN_NEW(sn_index, before);
    sn_index edges = next != NULL ? find_border(mesh, &topology, next) : 0;
    if (next == NULL || !make_room(mesh, edges / 3 + 1, edges + 1)) status = sn_fail_memory(error, "filling holes");
    for (sn_index v = 0; status == SN_OK && v < before; v++) {
        sn_index length = next[v] != SN_NONE ? loop_length(next, v, edges) : 0;
        if (length < 3 || length > max_edges || (length == 3 && is_lone_triangle(&topology, next, v))) continue;
        close_loop(mesh, next, v, length);
        if (hole_filled(count, length, length > 3 ? length : 1)) status = SN_STOPPED;
    }
    free(next);
    sn_topology_free(&topology);
    return status;
}

sn_status sn_fill_holes(sn_mesh *mesh, sn_index max_edges, sn_trace *trace, sn_index *filled, sn_index *boundary_left, sn_error *error) {
    *filled = *boundary_left = 0;
    sn_mesh_report found;
    sn_status status = sn_mesh_inspect(mesh, &found, error);
    if (status != SN_OK) return status;
    *boundary_left = found.boundary_edges;
    bool fillable = found.nonmanifold_edges == 0 && found.nonmanifold_vertices == 0 && found.oriented;
    if (found.boundary_edges == 0 || !fillable) return SN_OK;
    hole_count count = {.trace = trace};
    sn_index most = max_edges > 0 ? max_edges : SN_INDEX_MAX;
    status = fill_by_library(mesh, most, &count, error);
    if (status == SN_OK) status = close_by_fans(mesh, most, &count, error);
    *filled = count.filled;
    sn_status recounted = status == SN_OK || status == SN_STOPPED ? sn_mesh_inspect(mesh, &found, error) : status;
    *boundary_left = found.boundary_edges;
    return recounted == SN_OK ? status : recounted;
}

/* ---- decimation ------------------------------------------------------------------------------------------------------- */

/* Values at the closest point of the old surface; the group of its triangle. */
static void carry_by_closest_point(const sn_mesh *before, const sn_surface *surface, sn_mesh *after) {
    for (sn_index i = 0; i < after->vertex_count; i++) {
        sn_closest closest = sn_surface_closest(surface, after->positions[i], INFINITY);
        for (sn_index a = 0; a < before->attribute_count && closest.triangle != SN_NONE; a++) {
            const sn_attribute *from = &before->attributes[a];
            for (sn_index c = 0; c < from->components; c++) {
                double value = 0.0;
                for (int k = 0; k < 3; k++) {
                    sn_index v = before->triangles[closest.triangle].v[k];
                    value += closest.barycentric[k] * from->values[(size_t)v * (size_t)from->components + (size_t)c];
                }
                after->attributes[a].values[(size_t)i * (size_t)from->components + (size_t)c] = from->integer ? round(value) : value;
            }
        }
    }
    for (sn_index t = 0; after->triangle_group != NULL && t < after->triangle_count; t++) {
        const sn_index *v = after->triangles[t].v;
        sn_vec3 sum = sn_add(after->positions[v[0]], sn_add(after->positions[v[1]], after->positions[v[2]]));
        sn_closest closest = sn_surface_closest(surface, sn_scale(sum, 1.0 / 3.0), INFINITY);
        after->triangle_group[t] = closest.triangle != SN_NONE ? before->triangle_group[closest.triangle] : SN_NONE;
    }
}

static sn_status carry_over(const sn_mesh *before, sn_mesh *after, sn_error *error) {
    if (before->attribute_count == 0 && before->group_count == 0) return SN_OK;
    sn_surface *surface = NULL;
    sn_status status = sn_surface_create(before, &surface, error);
    if (status == SN_OK) carry_by_closest_point(before, surface, after);
    sn_surface_destroy(surface);
    return status;
}

static sn_status collapse_edges(sn_mesh *mesh, sn_index target, bool bounded, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_mesh after = {0};
    frame where;
    sn_status status = to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = check_indices(mesh, error);
    if (status == SN_OK) status = sn_bridge_decimate(&in, target, bounded, &out, error);
    if (status == SN_OK) status = from_bridge(mesh, &in, &out, where, &after, error);
    if (status == SN_OK) status = carry_over(mesh, &after, error);
    if (status == SN_OK) replace(mesh, &after);
    sn_mesh_free(&after);
    bridge_free(&in);
    bridge_free(&out);
    return status;
}

sn_status sn_decimate(sn_mesh *mesh, sn_index target_triangles, sn_error *error) {
    if (target_triangles < 4)
        return sn_fail(error, SN_ERROR_USAGE, "a closed surface needs at least 4 triangles, not %d", target_triangles);
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK && mesh->triangle_count > target_triangles) status = collapse_edges(mesh, target_triangles, true, error);
    if (status == SN_OK && mesh->triangle_count > target_triangles) status = collapse_edges(mesh, target_triangles, false, error);
    return status;
}

/* ---- self-intersections ----------------------------------------------------------------------------------------------- */

sn_status sn_count_self_intersections(const sn_mesh *mesh, sn_index *pairs, sn_error *error) {
    *pairs = 0;
    sn_bridge_mesh in = {0};
    frame where;
    sn_status status = to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_count_intersections(&in, pairs, error);
    bridge_free(&in);
    return status;
}
