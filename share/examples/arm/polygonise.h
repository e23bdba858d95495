/*
 * polygonise.h -- the zero surface of a shape as a closed triangle mesh, by marching tetrahedra on a cubic lattice.
 *
 * Every cube is cut into the six tetrahedra around its main diagonal (Kuhn's triangulation), the same way in every cube: the result is
 * a closed oriented manifold by construction (Doi and Koide 1991). Its triangles are poor; remesh.h makes them good.
 */
#ifndef ARM_POLYGONISE_H
#define ARM_POLYGONISE_H

#include <stdlib.h>
#include <string.h>

#include "shape.h"

/* An edge of Kuhn's triangulation leaves its lower corner in one of 7 directions: the bits of 1..7 are steps in x, y, z. */
enum { LATTICE_DIRECTIONS = 8 };

typedef struct lattice {
    const shape *shape;
    sn_vec3 origin;
    double step;
    sn_index size[3]; /* corners along x, y, z */
    double *values;   /* f at every corner */
    sn_index *cut;    /* (corners x LATTICE_DIRECTIONS) vertex on the edge plus one; 0 = none yet */
    sn_vec3 *positions;
    sn_triangle *triangles;
    size_t vertex_count, vertex_capacity, triangle_count, triangle_capacity;
} lattice;

static size_t lattice_corner(const lattice *l, sn_index x, sn_index y, sn_index z) {
    return ((size_t)z * (size_t)l->size[1] + (size_t)y) * (size_t)l->size[0] + (size_t)x;
}

static sn_vec3 lattice_point(const lattice *l, size_t corner) {
    size_t nx = (size_t)l->size[0], ny = (size_t)l->size[1];
    return sn_add_scaled(l->origin, sn_v3((double)(corner % nx), (double)(corner / nx % ny), (double)(corner / nx / ny)), l->step);
}

static size_t lattice_offset(const lattice *l, int bits) { return lattice_corner(l, bits & 1, bits >> 1 & 1, bits >> 2 & 1); }

static sn_status lattice_create(lattice *l, const shape *s, double step, sn_error *error) {
    *l = (lattice){.shape = s, .step = step, .origin = sn_sub(s->box.low, sn_v3(1.5 * step, 1.5 * step, 1.5 * step))};
    sn_vec3 cells = sn_scale(sn_sub(s->box.high, l->origin), 1.0 / step);
    l->size[0] = (sn_index)cells.x + 3;
    l->size[1] = (sn_index)cells.y + 3;
    l->size[2] = (sn_index)cells.z + 3;
    size_t corners = (size_t)l->size[0] * (size_t)l->size[1] * (size_t)l->size[2];
    l->values = SN_NEW(double, corners);
    l->cut = SN_NEW(sn_index, corners * LATTICE_DIRECTIONS);
    if (!l->values || !l->cut) return sn_fail_memory(error, "the lattice");
    for (size_t i = 0; i < corners; i++) l->values[i] = shape_distance(s, lattice_point(l, i));
    return SN_OK;
}

static void lattice_free(lattice *l) {
    free(l->values);
    free(l->cut);
    free(l->positions);
    free(l->triangles);
}

/* The vertex where the surface cuts the edge from corner `base + low` to `base + high` (bits of low are a subset of those of high).
 * It keeps away from the ends, so that no two vertices coincide. */
static bool lattice_cut(lattice *l, size_t base, int low, int high, sn_index *vertex) {
    size_t a = base + lattice_offset(l, low), b = base + lattice_offset(l, high);
    sn_index *cut = &l->cut[a * LATTICE_DIRECTIONS + (size_t)(high ^ low)];
    if (!*cut) {
        if (!sn_grow((void **)&l->positions, &l->vertex_capacity, l->vertex_count + 1, sizeof *l->positions)) return false;
        double t = fmin(0.95, fmax(0.05, l->values[a] / (l->values[a] - l->values[b])));
        l->positions[l->vertex_count++] = sn_lerp(lattice_point(l, a), lattice_point(l, b), t);
        *cut = (sn_index)l->vertex_count;
    }
    *vertex = *cut - 1;
    return true;
}

/* Add triangle a, b, c so that it faces along `outward`. */
static bool lattice_triangle(lattice *l, sn_index a, sn_index b, sn_index c, sn_vec3 outward) {
    if (!sn_grow((void **)&l->triangles, &l->triangle_capacity, l->triangle_count + 1, sizeof *l->triangles)) return false;
    bool outwards = sn_dot(sn_area_vector(l->positions[a], l->positions[b], l->positions[c]), outward) > 0.0;
    l->triangles[l->triangle_count++] = outwards ? (sn_triangle){{a, b, c}} : (sn_triangle){{a, c, b}};
    return true;
}

/* One tetrahedron: corners in ascending order of their bits, each a subset of the next. */
static bool lattice_tetrahedron(lattice *l, size_t base, const int corner[4]) {
    int in[4], out[4], in_count = 0, out_count = 0;
    sn_vec3 outward = {0, 0, 0};
    sn_index cut[4];
    for (int i = 0; i < 4; i++) {
        size_t index = base + lattice_offset(l, corner[i]);
        bool inside = l->values[index] < 0.0;
        if (inside)
            in[in_count++] = i;
        else
            out[out_count++] = i;
    }
    if (in_count == 0 || out_count == 0) return true;
    for (int i = 0; i < in_count; i++)
        outward = sn_add_scaled(outward, lattice_point(l, base + lattice_offset(l, corner[in[i]])), -1.0 / in_count);
    for (int i = 0; i < out_count; i++)
        outward = sn_add_scaled(outward, lattice_point(l, base + lattice_offset(l, corner[out[i]])), 1.0 / out_count);
    int cuts = 0;
    for (int i = 0; i < in_count; i++)
        for (int k = 0; k < out_count; k++) {
            int o = i & 1 ? out[out_count - 1 - k] : out[k]; /* every other row backwards: four cuts come in cyclic order */
            int low = in[i] < o ? in[i] : o, high = in[i] < o ? o : in[i];
            if (!lattice_cut(l, base, corner[low], corner[high], &cut[cuts++])) return false;
        }
    return lattice_triangle(l, cut[0], cut[1], cut[2], outward) && (cuts == 3 || lattice_triangle(l, cut[0], cut[2], cut[3], outward));
}

/* A cube none of whose corners differs in sign from the others is skipped. */
static bool lattice_cube(lattice *l, size_t base) {
    static const int tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};
    int inside = 0;
    for (int i = 0; i < 8; i++) inside += l->values[base + lattice_offset(l, i)] < 0.0;
    if (inside == 0 || inside == 8) return true;
    for (int i = 0; i < 6; i++)
        if (!lattice_tetrahedron(l, base, tetrahedra[i])) return false;
    return true;
}

static bool lattice_march(lattice *l) {
    for (sn_index z = 0; z + 1 < l->size[2]; z++)
        for (sn_index y = 0; y + 1 < l->size[1]; y++)
            for (sn_index x = 0; x + 1 < l->size[0]; x++)
                if (!lattice_cube(l, lattice_corner(l, x, y, z))) return false;
    return true;
}

/* The surface of s on a lattice of `step` metres. */
static sn_status polygonise(const shape *s, double step, sn_mesh *out, sn_error *error) {
    lattice l;
    sn_status status = lattice_create(&l, s, step, error);
    if (status == SN_OK && !lattice_march(&l)) status = sn_fail_memory(error, "the polygonised surface");
    if (status == SN_OK) status = sn_mesh_alloc(out, (sn_index)l.vertex_count, (sn_index)l.triangle_count, error);
    if (status == SN_OK) {
        memcpy(out->positions, l.positions, l.vertex_count * sizeof *l.positions);
        memcpy(out->triangles, l.triangles, l.triangle_count * sizeof *l.triangles);
    }
    lattice_free(&l);
    return status;
}

#endif
