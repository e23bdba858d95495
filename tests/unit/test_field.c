/* Harmonic fields and distances along edges and surfaces: maximum principle, symmetry, linear precision, shortest paths. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "rig_shapes.h"
#include "sinew/geom.h"

static sn_topology topology_of(const sn_mesh *mesh) {
    sn_topology t;
    if (sn_topology_build(mesh, &t, NULL)) abort();
    return t;
}

static double *harmonic_between(const sn_mesh *mesh, sn_index a, sn_index b) {
    sn_topology t = topology_of(mesh);
    double *u = SN_NEW(double, mesh->vertex_count);
    assert_int_equal(sn_harmonic_field(mesh, &t, &(sn_fixed_values){2, (sn_index[]){a, b}, (double[]){0.0, 1.0}}, u, NULL), SN_OK);
    sn_topology_free(&t);
    return u;
}

static void between_two_poles_it_rises_ring_by_ring(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 16 };
    sn_mesh m = spindle(RINGS, SECTORS, 0.2, 0.03);
    double *u = harmonic_between(&m, 0, m.vertex_count - 1);
    assert_true(u[0] == 0.0 && u[m.vertex_count - 1] == 1.0);
    for (sn_index i = 0; i < RINGS; i++)
        for (sn_index k = 0; k < SECTORS; k++) {
            sn_index v = 1 + i * SECTORS + k, below = i == 0 ? 0 : v - SECTORS;
            assert_true(u[v] > u[below] && u[v] < 1.0);
            assert_true(fabs(u[v] - u[1 + i * SECTORS]) < 1e-9); /* rotational symmetry */
        }
    assert_true(fabs(u[1 + (RINGS / 2) * SECTORS] - 0.5) < 1e-9); /* and that of the two ends */
    free(u);
    sn_mesh_free(&m);
}

/* u = x on the rim of a flat sheet of acute triangles gives u = x inside: cotangent weights reproduce linear fields. */
static void a_flat_sheet_gives_a_linear_field(void **state) {
    (void)state;
    enum { SIDE = 9 };
    sn_mesh m = {0};
    assert_int_equal(sn_mesh_alloc(&m, SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1), NULL), SN_OK);
    sn_index fixed[SIDE * SIDE], count = 0, t = 0;
    double values[SIDE * SIDE], u[SIDE * SIDE];
    for (sn_index i = 0; i < SIDE * SIDE; i++) {
        sn_index x = i % SIDE, y = i / SIDE;
        bool rim = x == 0 || y == 0 || x == SIDE - 1 || y == SIDE - 1;
        double jitter = rim ? 0.0 : 0.1;
        m.positions[i] = sn_v3(x - 0.5 * y + jitter * sin(3.0 * i), sqrt(0.75) * y + jitter * cos(5.0 * i), 0);
        if (rim) {
            fixed[count] = i;
            values[count++] = m.positions[i].x;
        }
        if (x == SIDE - 1 || y == SIDE - 1) continue;
        m.triangles[t++] = (sn_triangle){{i, i + 1, i + SIDE + 1}};
        m.triangles[t++] = (sn_triangle){{i, i + SIDE + 1, i + SIDE}};
    }
    sn_topology topology = topology_of(&m);
    assert_int_equal(sn_harmonic_field(&m, &topology, &(sn_fixed_values){count, fixed, values}, u, NULL), SN_OK);
    for (sn_index i = 0; i < SIDE * SIDE; i++) assert_true(fabs(u[i] - m.positions[i].x) < 1e-12);
    sn_topology_free(&topology);
    sn_mesh_free(&m);
}

static void what_no_fixed_vertex_reaches_is_nan(void **state) {
    (void)state;
    sn_mesh m = joined(spindle(5, 6, 1, 0.2), spindle(5, 6, 1, 0.2));
    double *u = harmonic_between(&m, 0, 31);
    for (sn_index v = 0; v < m.vertex_count; v++) assert_true(isnan(u[v]) == (v > 31));
    free(u);
    sn_mesh_free(&m);
}

static void bad_fixed_values_are_rejected(void **state) {
    (void)state;
    sn_mesh m = spindle(3, 4, 1, 0.2);
    sn_topology t = topology_of(&m);
    double *u = SN_NEW(double, m.vertex_count);
    assert_int_equal(sn_harmonic_field(&m, &t, &(sn_fixed_values){1, (sn_index[]){99}, (double[]){0}}, u, NULL), SN_ERROR_INPUT);
    assert_int_equal(sn_harmonic_field(&m, &t, &(sn_fixed_values){1, (sn_index[]){1}, (double[]){NAN}}, u, NULL), SN_ERROR_INPUT);
    assert_int_equal(sn_edge_distance(&m, &t, 1, (sn_index[]){-1}, u, NULL), SN_ERROR_INPUT);
    free(u);
    sn_topology_free(&t);
    sn_mesh_free(&m);
}

/* Along edges: one neighbour lies before each vertex by the length of the edge between, and no edge is a short cut. */
static void distances_are_those_of_shortest_paths(void **state) {
    (void)state;
    sn_mesh m = joined(blocks(two_prongs), spindle(3, 4, 1, 0.2));
    sn_topology t = topology_of(&m);
    double *distance = SN_NEW(double, m.vertex_count);
    assert_int_equal(sn_edge_distance(&m, &t, 2, (sn_index[]){7, 7}, distance, NULL), SN_OK);
    for (sn_index v = 0; v < m.vertex_count; v++) {
        if (v >= m.vertex_count - 14) { /* the other component */
            assert_true(isinf(distance[v]));
            continue;
        }
        bool reached = v == 7 && distance[v] == 0.0;
        for (sn_index k = t.vertex_start[v]; k < t.vertex_start[v + 1]; k++) {
            double through = distance[t.neighbours[k]] + sn_distance(m.positions[v], m.positions[t.neighbours[k]]);
            assert_true(distance[v] <= through);
            reached = reached || distance[v] == through;
        }
        assert_true(reached);
    }
    free(distance);
    sn_topology_free(&t);
    sn_mesh_free(&m);
}

/* The slowest vibration of a spindle: its extremes are the poles, it vanishes on the equator, and the start gives its sign. */
static void the_fiedler_eigenfunction_has_its_extremes_at_the_poles(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 16 };
    sn_mesh m = spindle(RINGS, SECTORS, 0.2, 0.03);
    sn_topology t = topology_of(&m);
    double *u = SN_NEW(double, m.vertex_count);
    for (int turned = 0; turned < 2; turned++) {
        for (sn_index v = 0; v < m.vertex_count; v++) u[v] = (turned ? -1.0 : 1.0) * (m.positions[v].z + 0.3 * m.positions[v].x);
        assert_int_equal(sn_fiedler_field(&m, &t, u, NULL), SN_OK);
        double low = turned ? u[m.vertex_count - 1] : u[0], high = turned ? u[0] : u[m.vertex_count - 1];
        for (sn_index v = 0; v < m.vertex_count; v++) assert_true(u[v] >= low - 1e-9 * high && u[v] <= high * (1.0 + 1e-9));
        for (sn_index k = 0; k < SECTORS; k++) assert_true(fabs(u[1 + (RINGS / 2) * SECTORS + k]) < 1e-2 * high);
    }
    free(u);
    sn_topology_free(&t);
    sn_mesh_free(&m);
}

/* From a straight row of sources the distance on a flat sheet is the height above the row, however the triangles lie. */
static void fast_marching_is_exact_from_a_line(void **state) {
    (void)state;
    enum { SIDE = 12 };
    sn_mesh m = {0};
    assert_int_equal(sn_mesh_alloc(&m, SIDE * SIDE, 2 * (SIDE - 1) * (SIDE - 1), NULL), SN_OK);
    sn_index row[SIDE], t = 0;
    for (sn_index i = 0; i < SIDE * SIDE; i++) {
        sn_index x = i % SIDE, y = i / SIDE;
        if (y == 0) row[x] = i;
        m.positions[i] = sn_v3(x - 0.5 * y, sqrt(0.75) * y + (y > 0 ? 0.1 * cos(5.0 * i) : 0.0), 0);
        if (x == SIDE - 1 || y == SIDE - 1) continue;
        m.triangles[t++] = (sn_triangle){{i, i + 1, i + SIDE + 1}};
        m.triangles[t++] = (sn_triangle){{i, i + SIDE + 1, i + SIDE}};
    }
    sn_topology topology = topology_of(&m);
    double distance[SIDE * SIDE];
    assert_int_equal(sn_geodesic_distance(&m, &topology, SIDE, row, distance, NULL), SN_OK);
    for (sn_index i = 0; i < SIDE * SIDE; i++) /* but on the left, where the sheet overhangs its row, the wave comes round the corner */
        if (i % SIDE >= i / SIDE) assert_true(fabs(distance[i] - m.positions[i].y) < 1e-9);
    sn_topology_free(&topology);
    sn_mesh_free(&m);
}

/* Between the poles of a spindle: within 1 % of the length of its profile, where edges that zigzag are longer. */
static void fast_marching_finds_the_profile(void **state) {
    (void)state;
    sn_mesh m = spindle(63, 48, 0.2, 0.03);
    sn_topology t = topology_of(&m);
    double *distance = SN_NEW(double, m.vertex_count), profile = 0.0;
    assert_int_equal(sn_geodesic_distance(&m, &t, 1, (sn_index[]){0}, distance, NULL), SN_OK);
    for (sn_index ring = 0, before = 0; ring <= 63; ring++) {
        sn_index here = ring < 63 ? 1 + 48 * ring : m.vertex_count - 1;
        profile += sn_distance(m.positions[before], m.positions[here]);
        before = here;
        if (ring % 9 == 0) assert_true(fabs(distance[here] - profile) < 0.01 * profile);
    }
    for (sn_index v = 1; v < m.vertex_count; v++) { /* no vertex but the source is lowest among its neighbours */
        bool lower = false;
        for (sn_index k = t.vertex_start[v]; k < t.vertex_start[v + 1]; k++) lower = lower || distance[t.neighbours[k]] <= distance[v];
        assert_true(lower);
    }
    free(distance);
    sn_topology_free(&t);
    sn_mesh_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(between_two_poles_it_rises_ring_by_ring),
        cmocka_unit_test(a_flat_sheet_gives_a_linear_field),
        cmocka_unit_test(what_no_fixed_vertex_reaches_is_nan),
        cmocka_unit_test(bad_fixed_values_are_rejected),
        cmocka_unit_test(distances_are_those_of_shortest_paths),
        cmocka_unit_test(fast_marching_is_exact_from_a_line),
        cmocka_unit_test(fast_marching_finds_the_profile),
        cmocka_unit_test(the_fiedler_eigenfunction_has_its_extremes_at_the_poles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
