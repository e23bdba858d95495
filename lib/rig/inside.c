/*
 * inside.c -- bring samples that lie outside the volume back to its middle. The centre of a slab of an arched sheet lies under the arch.
 *
 * The way in starts at the closest surface point and goes on straight through it; half-way to the other side is mid-thickness. Where that
 * is outside too (the surface crosses itself, a ray grazes an edge), half of it is tried, and so on: just behind the surface is inside.
 */
#include <stdlib.h>

#include "tree.h"

#define ON_SURFACE 1e-9  /* from a point this near to the surface, as a share of the box diagonal, the way to it has no direction */
#define JUST_BEHIND 1e-3 /* of the diagonal */
enum { MAX_HALVINGS = 24 };

typedef struct way_in {
    sn_index point; /* which of the points */
    sn_closest closest;
    sn_vec3 to; /* mid-thickness */
} way_in;

/* The ways that still lead nowhere inside, and scratch. */
typedef struct ways_in {
    sn_index count;
    way_in *items;   /* (points) of which count are used */
    sn_vec3 *points; /* (points) that are moved */
    sn_vec3 *tried;  /* (points) */
    int *winding;    /* (points) */
    double diagonal; /* of the mesh's box */
} ways_in;

/* ---- one way in ------------------------------------------------------------------------------------------------------------- */

static sn_vec3 face_normal(const sn_mesh *mesh, sn_index triangle) {
    const sn_index *v = mesh->triangles[triangle].v;
    return sn_normalize(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

static bool is_on_surface(const way_in *way, double diagonal) { return way->closest.distance <= ON_SURFACE * diagonal; }

/* Half the way from a surface point to the surface beyond, but no farther than the reach: from a tip the other side is the other tip. 0
 * where the ray meets none. */
static double half_thickness(const inside_step *step, sn_vec3 from, sn_vec3 direction, double diagonal) {
    sn_ray_hit hit = sn_surface_ray(step->surface, from, direction, 1e-6 * diagonal, 2.0 * diagonal);
    return hit.triangle == SN_NONE ? 0.0 : fmin(0.5 * hit.distance, step->reach);
}

/* A point on the surface, such as the centre of the last slab at a tip, only goes behind it. */
static void aim(const inside_step *step, way_in *way, sn_vec3 onwards, double diagonal) {
    double half = half_thickness(step, way->closest.point, onwards, diagonal);
    if (half == 0.0) {
        onwards = sn_neg(face_normal(step->mesh, way->closest.triangle));
        half = half_thickness(step, way->closest.point, onwards, diagonal);
    }
    if (half == 0.0 || is_on_surface(way, diagonal)) half = JUST_BEHIND * diagonal;
    way->to = sn_add_scaled(way->closest.point, onwards, half);
}

static sn_vec3 smooth_normal(const sn_mesh *mesh, const sn_vec3 *normals, const sn_closest *c) {
    const sn_index *v = mesh->triangles[c->triangle].v;
    sn_vec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) sum = sn_add_scaled(sum, normals[v[k]], c->barycentric[k]);
    return sn_normalize(sum);
}

/* ---- all of them -------------------------------------------------------------------------------------------------------------- */

static sn_status find_ways(inside_step *step, sn_index point_count, ways_in *ways, sn_error *error) {
    sn_status status = count_windings(step->mesh, point_count, ways->points, ways->winding, error);
    for (sn_index i = 0; i < point_count && !status; i++) {
        sn_vec3 p = ways->points[i];
        if (ways->winding[i] != 0) continue;
        if (!step->surface && (status = sn_surface_create_plain(step->mesh, &step->surface, error)) != SN_OK) break;
        way_in way = {.point = i, .closest = sn_surface_closest(step->surface, p, INFINITY)};
        sn_vec3 onwards = is_on_surface(&way, ways->diagonal) ? sn_v3(0, 0, 0) : sn_normalize(sn_sub(way.closest.point, p));
        aim(step, &way, onwards, ways->diagonal);
        ways->items[ways->count++] = way;
    }
    return status;
}

/* Ways that ran along the surface: from an edge, the mean normal leads inside where those of its faces do not. */
static sn_status aim_by_mean_normal(inside_step *step, ways_in *ways, sn_error *error) {
    sn_index count = ways->count;
    sn_vec3 *normals = count > 0 ? SN_NEW(sn_vec3, step->mesh->vertex_count) : NULL;
    if (count > 0 && !normals) return sn_fail_memory(error, "the samples outside the volume");
    if (count > 0) sn_mesh_vertex_normals(step->mesh, normals);
    for (way_in *way = ways->items; way < ways->items + count; way++)
        aim(step, way, sn_neg(smooth_normal(step->mesh, normals, &way->closest)), ways->diagonal);
    free(normals);
    return SN_OK;
}

/* Around a crease that crosses itself there is no inside: start from the middle of the face. */
static void aim_from_face(inside_step *step, ways_in *ways) {
    for (way_in *way = ways->items; way < ways->items + ways->count; way++) {
        const sn_index *v = step->mesh->triangles[way->closest.triangle].v;
        const sn_vec3 *p = step->mesh->positions;
        way->closest.point = sn_scale(sn_add(p[v[0]], sn_add(p[v[1]], p[v[2]])), 1.0 / 3.0);
        aim(step, way, sn_neg(face_normal(step->mesh, way->closest.triangle)), ways->diagonal);
    }
}

/* Go as far as is inside, by halves; the ways that never are stay. */
static sn_status follow_ways(inside_step *step, ways_in *ways, sn_error *error) {
    double share = 1.0;
    for (int halving = 0; halving < MAX_HALVINGS && ways->count > 0; halving++, share *= 0.5) {
        for (sn_index i = 0; i < ways->count; i++) ways->tried[i] = sn_lerp(ways->items[i].closest.point, ways->items[i].to, share);
        sn_status status = count_windings(step->mesh, ways->count, ways->tried, ways->winding, error);
        if (status) return status;
        sn_index left = 0;
        for (sn_index i = 0; i < ways->count; i++) {
            if (ways->winding[i] == 0) {
                ways->items[left++] = ways->items[i];
                continue;
            }
            sn_vec3 *point = &ways->points[ways->items[i].point];
            double moved = sn_distance(*point, ways->tried[i]);
            *point = ways->tried[i];
            step->moved++;
            if (SN_TRACE(step->trace, "inside", sn_trace_number("point", ways->items[i].point), sn_trace_number("moved", moved),
                         sn_trace_number("x", point->x), sn_trace_number("y", point->y), sn_trace_number("z", point->z)))
                return SN_STOPPED;
        }
        ways->count = left;
    }
    return SN_OK;
}

sn_status move_inside(inside_step *step, sn_index count, sn_vec3 *points, sn_error *error) {
    if (!step->mesh || count == 0) return SN_OK;
    ways_in ways = {.points = points, .diagonal = sn_box_diagonal(sn_mesh_box(step->mesh))};
    ways.items = SN_NEW(way_in, count);
    ways.tried = SN_NEW(sn_vec3, count);
    ways.winding = SN_NEW(int, count);
    bool enough = ways.items && ways.tried && ways.winding;
    sn_status status = enough ? find_ways(step, count, &ways, error) : sn_fail_memory(error, "the samples outside the volume");
    if (!status) status = follow_ways(step, &ways, error);
    if (!status) status = aim_by_mean_normal(step, &ways, error);
    if (!status) status = follow_ways(step, &ways, error);
    if (!status) aim_from_face(step, &ways);
    if (!status) status = follow_ways(step, &ways, error);
    free(ways.items);
    free(ways.tried);
    free(ways.winding);
    return status;
}

void inside_step_free(inside_step *step) {
    sn_surface_destroy(step->surface);
    step->surface = NULL;
}
