/*
 * measure.c -- box, area, volume, centroid, edge length, normals.
 */
#include "sinew/mesh.h"

#include <string.h>

typedef struct corners {
    sn_vec3 a, b, c;
} corners;

static corners corners_of(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return (corners){mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]};
}

sn_box sn_mesh_box(const sn_mesh *mesh) {
    sn_box box = {sn_v3(INFINITY, INFINITY, INFINITY), sn_v3(-INFINITY, -INFINITY, -INFINITY)};
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        box.low = sn_min3(box.low, mesh->positions[i]);
        box.high = sn_max3(box.high, mesh->positions[i]);
    }
    return box;
}

double sn_box_diagonal(sn_box box) {
    if (!(box.low.x <= box.high.x && box.low.y <= box.high.y && box.low.z <= box.high.z)) return 0.0;
    return sn_distance(box.low, box.high);
}

static sn_vec3 box_centre(const sn_mesh *mesh) {
    sn_box box = sn_mesh_box(mesh);
    return box.low.x <= box.high.x ? sn_lerp(box.low, box.high, 0.5) : sn_v3(0, 0, 0);
}

double sn_mesh_area(const sn_mesh *mesh) {
    double twice = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        corners p = corners_of(mesh, t);
        twice += sn_norm(sn_area_vector(p.a, p.b, p.c));
    }
    return 0.5 * twice;
}

void sn_mesh_vertex_areas(const sn_mesh *mesh, double *areas) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) areas[v] = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double third = sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]])) / 6.0;
        for (int k = 0; k < 3; k++) areas[v[k]] += third;
    }
}

/* Six times the signed volume of the tetrahedron of a triangle and the origin. */
static double six_volumes(corners p) { return sn_dot(p.a, sn_cross(p.b, p.c)); }

static corners relative_to(corners p, sn_vec3 origin) { return (corners){sn_sub(p.a, origin), sn_sub(p.b, origin), sn_sub(p.c, origin)}; }

double sn_mesh_volume(const sn_mesh *mesh) {
    sn_vec3 centre = box_centre(mesh);
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) sum += six_volumes(relative_to(corners_of(mesh, t), centre));
    return sum / 6.0;
}

/* A volume below this share of area x diagonal is that of a sheet or of an open surface: rounding decides its centroid. */
#define TINY_VOLUME 1e-9

sn_vec3 sn_mesh_volume_centroid(const sn_mesh *mesh) {
    sn_vec3 centre = box_centre(mesh), by_volume = sn_v3(0, 0, 0), by_area = sn_v3(0, 0, 0);
    double volume = 0.0, area = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        corners p = relative_to(corners_of(mesh, t), centre);
        sn_vec3 sum = sn_add(p.a, sn_add(p.b, p.c));
        double six = six_volumes(p), twice = sn_norm(sn_area_vector(p.a, p.b, p.c));
        volume += six / 6.0;
        area += twice / 2.0;
        by_volume = sn_add_scaled(by_volume, sum, six / 24.0);
        by_area = sn_add_scaled(by_area, sum, twice / 6.0);
    }
    if (fabs(volume) > TINY_VOLUME * area * sn_box_diagonal(sn_mesh_box(mesh))) return sn_add_scaled(centre, by_volume, 1.0 / volume);
    return area > 0.0 ? sn_add_scaled(centre, by_area, 1.0 / area) : centre;
}

double sn_mesh_mean_edge(const sn_mesh *mesh, const sn_topology *topology) {
    double sum = 0.0;
    for (sn_index e = 0; e < topology->edge_count; e++) {
        sum += sn_distance(mesh->positions[topology->edges[e].v[0]], mesh->positions[topology->edges[e].v[1]]);
    }
    return topology->edge_count > 0 ? sum / topology->edge_count : 0.0;
}

double sn_mesh_mean_side(const sn_mesh *mesh) {
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        corners p = corners_of(mesh, t);
        sum += sn_distance(p.a, p.b) + sn_distance(p.b, p.c) + sn_distance(p.c, p.a);
    }
    return mesh->triangle_count > 0 ? sum / (3.0 * mesh->triangle_count) : 0.0;
}

void sn_mesh_vertex_normals(const sn_mesh *mesh, sn_vec3 *normals) {
    if (mesh->vertex_count > 0) memset(normals, 0, (size_t)mesh->vertex_count * sizeof *normals);
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        corners p = corners_of(mesh, t);
        sn_vec3 area = sn_area_vector(p.a, p.b, p.c);
        for (int k = 0; k < 3; k++) {
            sn_vec3 *normal = &normals[mesh->triangles[t].v[k]];
            *normal = sn_add(*normal, area);
        }
    }
    for (sn_index i = 0; i < mesh->vertex_count; i++) normals[i] = sn_normalize(normals[i]);
}
