/*
 * attach_voxels.c -- the boundary voxels of a bone ([K21] 3.2): its box in equal cells, marked where a triangle runs through.
 *
 * A triangle and a cell overlap unless one of 13 axes separates them (Akenine-Moeller 2001).
 */
#include "attach.h"

#include <stdlib.h>

static void cell_size(const sn_voxels *v, double size[3]) {
    sn_vec3 all = sn_sub(v->box.high, v->box.low);
    size[0] = all.x / v->size[0];
    size[1] = all.y / v->size[1];
    size[2] = all.z / v->size[2];
}

/* The cell of a coordinate along one axis; the far face of the box belongs to the last cell. */
static sn_index cell_along(double x, double low, double size, sn_index count) {
    double cell = size > 0.0 ? floor((x - low) / size) : 0.0;
    return (sn_index)fmin(fmax(cell, 0.0), count - 1);
}

static size_t cell_number(const sn_voxels *v, sn_index i, sn_index j, sn_index k) {
    return ((size_t)k * (size_t)v->size[1] + (size_t)j) * (size_t)v->size[0] + (size_t)i;
}

/* Does the plane across axis keep the triangle (relative to the cell's centre) apart from the cell of half size h? */
static bool separates(sn_vec3 axis, const sn_vec3 corner[3], sn_vec3 h) {
    double a = sn_dot(axis, corner[0]), b = sn_dot(axis, corner[1]), c = sn_dot(axis, corner[2]);
    double radius = h.x * fabs(axis.x) + h.y * fabs(axis.y) + h.z * fabs(axis.z);
    return fmin(a, fmin(b, c)) > radius || fmax(a, fmax(b, c)) < -radius;
}

static bool overlaps(const sn_vec3 triangle[3], sn_vec3 centre, sn_vec3 h) {
    static const sn_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    sn_vec3 corner[3];
    for (int k = 0; k < 3; k++) corner[k] = sn_sub(triangle[k], centre);
    for (int k = 0; k < 3; k++) {
        if (separates(axes[k], corner, h)) return false;
        sn_vec3 side = sn_sub(corner[(k + 1) % 3], corner[k]);
        for (int a = 0; a < 3; a++)
            if (separates(sn_cross(axes[a], side), corner, h)) return false;
    }
    return !separates(sn_area_vector(corner[0], corner[1], corner[2]), corner, h);
}

static void mark_triangle(sn_voxels *v, const sn_vec3 corner[3], const double size[3]) {
    sn_vec3 low = sn_min3(corner[0], sn_min3(corner[1], corner[2])), high = sn_max3(corner[0], sn_max3(corner[1], corner[2]));
    sn_vec3 h = sn_scale(sn_v3(size[0], size[1], size[2]), 0.5), start = v->box.low;
    sn_index first[3] = {cell_along(low.x, start.x, size[0], v->size[0]), cell_along(low.y, start.y, size[1], v->size[1]),
                         cell_along(low.z, start.z, size[2], v->size[2])};
    sn_index last[3] = {cell_along(high.x, start.x, size[0], v->size[0]), cell_along(high.y, start.y, size[1], v->size[1]),
                        cell_along(high.z, start.z, size[2], v->size[2])};
    for (sn_index k = first[2]; k <= last[2]; k++)
        for (sn_index j = first[1]; j <= last[1]; j++)
            for (sn_index i = first[0]; i <= last[0]; i++) {
                sn_vec3 centre = sn_add(start, sn_v3((i + 0.5) * size[0], (j + 0.5) * size[1], (k + 0.5) * size[2]));
                size_t cell = cell_number(v, i, j, k);
                if (overlaps(corner, centre, h)) v->boundary[cell / 8] |= (unsigned char)(1u << cell % 8);
            }
}

/* Cells as near to cubes as whole numbers allow; a flat box has one layer. */
static void choose_size(sn_voxels *v, sn_index cells) {
    sn_vec3 all = sn_sub(v->box.high, v->box.low);
    double side[3] = {all.x, all.y, all.z}, content = 1.0, left = cells;
    int axes = 0;
    for (int k = 0; k < 3; k++)
        if (side[k] > 0.0) content *= side[k], axes++;
    double cube = axes > 0 ? sn_quick_pow(content / left, 1.0 / axes) : 1.0;
    for (int k = 0; k < 3; k++) v->size[k] = (sn_index)fmin(fmax(round(side[k] / cube), 1.0), 4096.0);
}

sn_status sn_voxels_build(const sn_mesh *bone, sn_index cells, sn_voxels *out, sn_error *error) {
    *out = (sn_voxels){.box = sn_mesh_box(bone)};
    choose_size(out, cells);
    size_t count = cell_number(out, 0, 0, out->size[2]);
    out->boundary = sn_alloc(count / 8 + 1, 1);
    if (out->boundary == NULL) return sn_fail_memory(error, "the voxels of a bone");
    double size[3];
    cell_size(out, size);
    for (sn_index t = 0; t < bone->triangle_count; t++) {
        sn_vec3 corner[3];
        for (int k = 0; k < 3; k++) corner[k] = bone->positions[bone->triangles[t].v[k]];
        mark_triangle(out, corner, size);
    }
    return SN_OK;
}

void sn_voxels_free(sn_voxels *voxels) {
    free(voxels->boundary);
    *voxels = (sn_voxels){0};
}

bool sn_voxels_on_boundary(const sn_voxels *v, sn_vec3 p) {
    double size[3];
    if (v->boundary == NULL || sn_box_gap((sn_box){p, p}, v->box) > 0.0) return false;
    cell_size(v, size);
    size_t cell = cell_number(v, cell_along(p.x, v->box.low.x, size[0], v->size[0]), cell_along(p.y, v->box.low.y, size[1], v->size[1]),
                              cell_along(p.z, v->box.low.z, size[2], v->size[2]));
    return v->boundary[cell / 8] >> cell % 8 & 1;
}
