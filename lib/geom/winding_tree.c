/*
 * winding_tree.c -- fast winding numbers (Barill, Dickson, Schmidt, Levin & Jacobson 2018): from afar a cluster of triangles looks like
 * one dipole, the sum of its area vectors in their common centre.
 */
#include "winding_tree.h"

#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "sinew/geom.h"

enum { LEAF_TRIANGLES = 16 };

/* A cluster is far where the point is this many of its radii away; 2 is usual, more costs little and is more exact. */
static const double far_radii = 3.0;

struct sn_cluster {
    sn_vec3 centre, area; /* mean of the triangles' centres, weighted by area; sum of area vectors */
    double radius;        /* of a ball round the centre that holds the triangles */
};

static sn_vec3 triangle_centre(const sn_mesh *mesh, sn_triangle t) {
    sn_vec3 sum = sn_add(sn_add(mesh->positions[t.v[0]], mesh->positions[t.v[1]]), mesh->positions[t.v[2]]);
    return sn_scale(sum, 1.0 / 3.0);
}

static sn_status sort_along_curve(sn_mesh *mesh, sn_error *error) {
    sn_index *order = SN_NEW(sn_index, mesh->triangle_count);
    sn_triangle *sorted = SN_NEW(sn_triangle, mesh->triangle_count);
    sn_status status = order != NULL && sorted != NULL ? sn_curve_order(mesh, order, error) : sn_fail_memory(error, "a search structure");
    for (sn_index t = 0; t < mesh->triangle_count && status == SN_OK; t++) sorted[t] = mesh->triangles[order[t]];
    if (status == SN_OK) memcpy(mesh->triangles, sorted, (size_t)mesh->triangle_count * sizeof *sorted);
    free(order);
    free(sorted);
    return status;
}

/* ---- clusters ----------------------------------------------------------------------------------------------------------------- */

static struct sn_cluster measure_cluster(const sn_mesh *mesh, sn_index begin, sn_index end) {
    struct sn_cluster c = {0};
    double total = 0.0;
    for (sn_index t = begin; t < end; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 area = sn_scale(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]), 0.5);
        double size = sn_norm(area);
        c.area = sn_add(c.area, area);
        c.centre = sn_add_scaled(c.centre, triangle_centre(mesh, mesh->triangles[t]), size);
        total += size;
    }
    c.centre = total > 0.0 ? sn_scale(c.centre, 1.0 / total) : mesh->positions[mesh->triangles[begin].v[0]];
    for (sn_index t = begin; t < end; t++) {
        for (int k = 0; k < 3; k++) c.radius = fmax(c.radius, sn_distance(c.centre, mesh->positions[mesh->triangles[t].v[k]]));
    }
    return c;
}

static void build_clusters(sn_winding_tree *tree, sn_index node, int level, sn_index begin, sn_index end) {
    tree->clusters[node] = measure_cluster(tree->mesh, begin, end);
    if (level == tree->depth) return;
    sn_index middle = begin + (end - begin) / 2;
    build_clusters(tree, 2 * node, level + 1, begin, middle);
    build_clusters(tree, 2 * node + 1, level + 1, middle, end);
}

sn_status sn_winding_tree_build(sn_mesh *mesh, sn_winding_tree *out, sn_error *error) {
    *out = (sn_winding_tree){.mesh = mesh};
    if (mesh->triangle_count == 0) return SN_OK;
    sn_status status = sort_along_curve(mesh, error);
    if (status != SN_OK) return status;
    while (mesh->triangle_count >> out->depth > LEAF_TRIANGLES) out->depth++;
    out->clusters = SN_NEW(struct sn_cluster, (size_t)1 << (out->depth + 1));
    if (out->clusters == NULL) return sn_fail_memory(error, "a search structure");
    build_clusters(out, 1, 0, 0, mesh->triangle_count);
    return SN_OK;
}

void sn_winding_tree_free(sn_winding_tree *tree) {
    free(tree->clusters);
    *tree = (sn_winding_tree){0};
}

/* ---- queries -------------------------------------------------------------------------------------------------------------------- */

static double exact_angle(const sn_mesh *mesh, sn_index begin, sn_index end, sn_vec3 p) {
    double sum = 0.0;
    for (sn_index t = begin; t < end; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sum += sn_solid_angle(sn_sub(mesh->positions[v[0]], p), sn_sub(mesh->positions[v[1]], p), sn_sub(mesh->positions[v[2]], p));
    }
    return sum;
}

static double cluster_angle(const sn_winding_tree *tree, sn_index node, int level, sn_index begin, sn_index end, sn_vec3 p) {
    const struct sn_cluster *c = &tree->clusters[node];
    sn_vec3 away = sn_sub(c->centre, p);
    double distance = sn_norm(away);
    if (distance > far_radii * c->radius) return sn_dot(away, c->area) / (distance * distance * distance);
    if (level == tree->depth) return exact_angle(tree->mesh, begin, end, p);
    sn_index middle = begin + (end - begin) / 2;
    return cluster_angle(tree, 2 * node, level + 1, begin, middle, p) + cluster_angle(tree, 2 * node + 1, level + 1, middle, end, p);
}

double sn_winding_tree_number(const sn_winding_tree *tree, sn_vec3 point) {
    if (tree->clusters == NULL) return 0.0;
    double number = cluster_angle(tree, 1, 0, 0, tree->mesh->triangle_count, point) / (4.0 * SN_PI);
    double from_half = fabs(fabs(number) - floor(fabs(number)) - 0.5);
    return from_half > 0.1 ? number : sn_winding_number(tree->mesh, point); /* too close to call */
}
