/* rig_shapes.h -- closed surfaces made of formulas and of blocks, for the tests of rig generation. */
#ifndef RIG_SHAPES_H
#define RIG_SHAPES_H

#include <stdlib.h>

#include "sinew/mesh.h"

/* A spindle along z from -length/2 to length/2: `rings` circles of `sectors` vertices between two poles (vertices 0 and last). */
static inline sn_mesh spindle(sn_index rings, sn_index sectors, double length, double radius) {
    sn_mesh m = {0};
    if (sn_mesh_alloc(&m, rings * sectors + 2, 2 * rings * sectors, NULL)) abort();
    sn_index last = rings * sectors + 1, t = 0;
    m.positions[0] = sn_v3(0, 0, -0.5 * length);
    m.positions[last] = sn_v3(0, 0, 0.5 * length);
    for (sn_index i = 0; i < rings; i++) {
        double s = (i + 1.0) / (rings + 1.0), r = radius * pow(sin(SN_PI * s), 0.8);
        for (sn_index k = 0; k < sectors; k++) {
            double angle = 2.0 * SN_PI * k / sectors;
            sn_index here = 1 + i * sectors + k, next = 1 + i * sectors + (k + 1) % sectors;
            m.positions[here] = sn_v3(r * cos(angle), r * sin(angle), length * (s - 0.5));
            if (i == 0) m.triangles[t++] = (sn_triangle){{0, next, here}};
            if (i + 1 == rings) {
                m.triangles[t++] = (sn_triangle){{last, here, next}};
                continue;
            }
            m.triangles[t++] = (sn_triangle){{here, next, next + sectors}};
            m.triangles[t++] = (sn_triangle){{here, next + sectors, here + sectors}};
        }
    }
    return m;
}

/* Unit blocks: is the one whose low corner is (x, y, z) filled? Coordinates from 0 to BLOCKS - 1. */
enum { BLOCKS = 40, CORNERS = BLOCKS + 1 };
typedef bool (*block_function)(int x, int y, int z);

static inline bool block_at(block_function filled, const int p[3]) {
    for (int a = 0; a < 3; a++)
        if (p[a] < 0 || p[a] >= BLOCKS) return false;
    return filled(p[0], p[1], p[2]);
}

static inline sn_index block_corner(sn_mesh *m, sn_index *number, const int p[3]) {
    sn_index *n = &number[(p[0] * CORNERS + p[1]) * CORNERS + p[2]];
    if (*n == 0) {
        m->positions[m->vertex_count++] = sn_v3(p[0], p[1], p[2]);
        *n = m->vertex_count;
    }
    return *n - 1;
}

/* Two triangles for the side of block p towards axis, up or down, facing outwards. */
static inline void block_side(sn_mesh *m, sn_index *number, const int p[3], int axis, int up) {
    sn_index corner[4];
    for (int k = 0; k < 4; k++) {
        int q[3] = {p[0], p[1], p[2]};
        q[axis] += up;
        q[(axis + 1) % 3] += k == 1 || k == 2;
        q[(axis + 2) % 3] += k >= 2;
        corner[k] = block_corner(m, number, q);
    }
    int second = up ? 1 : 3, fourth = up ? 3 : 1;
    m->triangles[m->triangle_count++] = (sn_triangle){{corner[0], corner[second], corner[2]}};
    m->triangles[m->triangle_count++] = (sn_triangle){{corner[0], corner[2], corner[fourth]}};
}

/* The surface of all filled blocks; blocks must not touch in an edge or a corner only. */
static inline sn_mesh blocks(block_function filled) {
    sn_mesh m = {0};
    sn_index sides = 0, *number = SN_NEW(sn_index, CORNERS * CORNERS * CORNERS);
    for (int pass = 0; pass < 2; pass++) {
        if (pass == 1 && (!number || sn_mesh_alloc(&m, 4 * sides, 2 * sides, NULL))) abort();
        if (pass == 1) m.vertex_count = m.triangle_count = 0; /* count them up to what there is room for */
        for (int x = 0; x < BLOCKS; x++)
            for (int y = 0; y < BLOCKS; y++)
                for (int z = 0; z < BLOCKS; z++)
                    for (int side = 0; side < 6 && filled(x, y, z); side++) {
                        int p[3] = {x, y, z}, beside[3] = {x, y, z}, axis = side / 2, up = side % 2;
                        beside[axis] += up ? 1 : -1;
                        if (block_at(filled, beside)) continue;
                        if (pass == 0)
                            sides++;
                        else
                            block_side(&m, number, p, axis, up);
                    }
    }
    free(number);
    return m;
}

/* Two prongs above z = 22 on a stem below: three ends. */
static inline bool two_prongs(int x, int y, int z) {
    bool stem = z < 22 && x >= 8 && x < 20, prong = z >= 22 && z < 38 && ((x >= 8 && x < 12) || (x >= 16 && x < 20));
    return y >= 4 && y < 8 && (stem || prong);
}

/* A ring lying in the x-z plane: genus 1. */
static inline bool hoop(int x, int y, int z) {
    bool outside = x >= 4 && x < 36 && z >= 4 && z < 36, hole = x >= 12 && x < 28 && z >= 12 && z < 28;
    return y >= 4 && y < 10 && outside && !hole;
}

/* A square bar along z with a low knob on its side. */
static inline bool knobbed_bar(int x, int y, int z) {
    bool bar = x >= 8 && x < 14 && y >= 8 && y < 14, knob = x >= 14 && x < 19 && y >= 10 && y < 12 && z >= 28 && z < 30;
    return bar || knob;
}

/* Both surfaces in one mesh; what goes in is freed. */
static inline sn_mesh joined(sn_mesh a, sn_mesh b) {
    sn_mesh m = {0};
    if (sn_mesh_alloc(&m, a.vertex_count + b.vertex_count, a.triangle_count + b.triangle_count, NULL)) abort();
    for (sn_index v = 0; v < m.vertex_count; v++)
        m.positions[v] = v < a.vertex_count ? a.positions[v] : sn_add(b.positions[v - a.vertex_count], sn_v3(1000, 0, 0));
    for (sn_index t = 0; t < m.triangle_count; t++)
        for (int c = 0; c < 3; c++)
            m.triangles[t].v[c] = t < a.triangle_count ? a.triangles[t].v[c] : b.triangles[t - a.triangle_count].v[c] + a.vertex_count;
    sn_mesh_free(&a);
    sn_mesh_free(&b);
    return m;
}

#endif
