/*
 * shapes.h -- small surfaces of known measures for the tests of the geometry.
 */
#ifndef TESTS_SHAPES_H
#define TESTS_SHAPES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/geom.h"

#define assert_ok(call)                                                                                                                    \
    do {                                                                                                                                   \
        sn_status status_ = (call);                                                                                                        \
        if (status_ != SN_OK) fail_msg("%s gave status %d", #call, (int)status_);                                                          \
    } while (0)
#define assert_near(a, b, tolerance)                                                                                                       \
    do {                                                                                                                                   \
        double a_ = (a), b_ = (b);                                                                                                         \
        if (!(fabs(a_ - b_) <= (tolerance))) fail_msg("%s = %.17g is not %s = %.17g", #a, a_, #b, b_);                                     \
    } while (0)

static inline sn_mesh shape_empty(sn_index vertices, sn_index triangles) {
    sn_mesh mesh;
    assert_ok(sn_mesh_alloc(&mesh, vertices, triangles, NULL));
    return mesh;
}

static inline sn_mesh shape_of(sn_index vertices, const sn_vec3 *positions, sn_index triangles, const sn_triangle *indices) {
    sn_mesh mesh = shape_empty(vertices, triangles);
    memcpy(mesh.positions, positions, (size_t)vertices * sizeof *positions);
    memcpy(mesh.triangles, indices, (size_t)triangles * sizeof *indices);
    return mesh;
}

/* The cube [0,1]^3: volume 1, area 6; two triangles a side. */
static inline sn_mesh shape_cube(void) {
    const sn_vec3 positions[8] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const sn_triangle triangles[12] = {{{0, 2, 1}}, {{0, 3, 2}}, {{4, 5, 6}}, {{4, 6, 7}}, {{0, 1, 5}}, {{0, 5, 4}},
                                       {{1, 2, 6}}, {{1, 6, 5}}, {{2, 3, 7}}, {{2, 7, 6}}, {{3, 0, 4}}, {{3, 4, 7}}};
    return shape_of(8, positions, 12, triangles);
}

/* A unit sphere of `rows` rings of `columns` vertices and two poles: 2 rows columns triangles, outwards. */
static inline sn_mesh shape_sphere(sn_index rows, sn_index columns) {
    sn_mesh mesh = shape_empty(rows * columns + 2, 2 * rows * columns);
    sn_index north = rows * columns, south = north + 1, t = 0;
    for (sn_index r = 0; r < rows; r++) {
        double polar = SN_PI * (r + 1) / (rows + 1);
        for (sn_index c = 0; c < columns; c++) {
            double turn = 2.0 * SN_PI * c / columns;
            mesh.positions[r * columns + c] = sn_v3(sin(polar) * cos(turn), sin(polar) * sin(turn), cos(polar));
        }
    }
    mesh.positions[north] = sn_v3(0, 0, 1);
    mesh.positions[south] = sn_v3(0, 0, -1);
    for (sn_index c = 0; c < columns; c++) {
        sn_index next = (c + 1) % columns, last = (rows - 1) * columns;
        mesh.triangles[t++] = (sn_triangle){{north, c, next}};
        mesh.triangles[t++] = (sn_triangle){{south, last + next, last + c}};
        for (sn_index r = 0; r + 1 < rows; r++) {
            sn_index a = r * columns + c, b = r * columns + next, below_a = a + columns, below_b = b + columns;
            mesh.triangles[t++] = (sn_triangle){{a, below_a, below_b}};
            mesh.triangles[t++] = (sn_triangle){{a, below_b, b}};
        }
    }
    return mesh;
}

/* Two meshes as one; `second` is scaled and moved. */
static inline sn_mesh shape_join(const sn_mesh *first, const sn_mesh *second, double scale, sn_vec3 move) {
    sn_mesh mesh = shape_empty(first->vertex_count + second->vertex_count, first->triangle_count + second->triangle_count);
    memcpy(mesh.positions, first->positions, (size_t)first->vertex_count * sizeof *mesh.positions);
    memcpy(mesh.triangles, first->triangles, (size_t)first->triangle_count * sizeof *mesh.triangles);
    for (sn_index i = 0; i < second->vertex_count; i++) {
        mesh.positions[first->vertex_count + i] = sn_add(sn_scale(second->positions[i], scale), move);
    }
    for (sn_index t = 0; t < second->triangle_count; t++) {
        for (int k = 0; k < 3; k++) { mesh.triangles[first->triangle_count + t].v[k] = second->triangles[t].v[k] + first->vertex_count; }
    }
    return mesh;
}

/* A Moebius strip of `columns` quads. */
static inline sn_mesh shape_moebius(sn_index columns) {
    sn_mesh mesh = shape_empty(2 * columns, 2 * columns);
    for (sn_index c = 0; c < columns; c++) {
        double turn = 2.0 * SN_PI * c / columns;
        for (int side = 0; side < 2; side++) {
            double across = side == 0 ? -0.3 : 0.3, radius = 1.0 + across * cos(0.5 * turn);
            mesh.positions[2 * c + side] = sn_v3(radius * cos(turn), radius * sin(turn), across * sin(0.5 * turn));
        }
        sn_index a = 2 * c, b = 2 * c + 1, p = a + 2, q = b + 2;
        if (c + 1 == columns) {
            p = 1;
            q = 0;
        }
        mesh.triangles[2 * c] = (sn_triangle){{a, p, b}};
        mesh.triangles[2 * c + 1] = (sn_triangle){{b, p, q}};
    }
    return mesh;
}

/* Remove triangle t. */
static inline void shape_drop(sn_mesh *mesh, sn_index t) {
    memmove(mesh->triangles + t, mesh->triangles + t + 1, (size_t)(mesh->triangle_count - t - 1) * sizeof *mesh->triangles);
    mesh->triangle_count--;
}

static inline void shape_flip(sn_mesh *mesh, sn_index t) {
    sn_index kept = mesh->triangles[t].v[1];
    mesh->triangles[t].v[1] = mesh->triangles[t].v[2];
    mesh->triangles[t].v[2] = kept;
}

static inline sn_mesh_report shape_inspect(const sn_mesh *mesh) {
    sn_mesh_report report;
    assert_ok(sn_mesh_inspect(mesh, &report, NULL));
    return report;
}

static inline bool shape_is_sound(const sn_mesh *mesh) {
    sn_mesh_report r = shape_inspect(mesh);
    return r.closed && r.manifold && r.oriented;
}

static inline bool shape_same(const sn_mesh *a, const sn_mesh *b) {
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           memcmp(a->positions, b->positions, (size_t)a->vertex_count * sizeof *a->positions) == 0 &&
           memcmp(a->triangles, b->triangles, (size_t)a->triangle_count * sizeof *a->triangles) == 0;
}

#endif
