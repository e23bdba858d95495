/* test_topology.c -- adjacency of a mesh against what it must be, and against a slow and simple count on random soups. */
#include "shapes.h"

static void build(const sn_mesh *mesh, sn_topology *topology) { assert_ok(sn_topology_build(mesh, topology, NULL)); }

static void a_tetrahedron_has_six_edges_in_order(void **state) {
    (void)state;
    const sn_vec3 positions[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const sn_triangle triangles[4] = {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}};
    const sn_index ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    sn_mesh mesh = shape_of(4, positions, 4, triangles);
    sn_topology topology;
    build(&mesh, &topology);
    assert_int_equal(topology.edge_count, 6);
    for (sn_index e = 0; e < 6; e++) {
        assert_int_equal(topology.edges[e].v[0], ends[e][0]);
        assert_int_equal(topology.edges[e].v[1], ends[e][1]);
        assert_int_equal(topology.edges[e].triangle_count, 2);
    }
    assert_int_equal(topology.edges[0].triangle[0], 0);
    assert_int_equal(topology.edges[0].triangle[1], 1);
    assert_int_equal(topology.edges[0].opposite[0], 2);
    assert_int_equal(topology.edges[0].opposite[1], 3);
    assert_int_equal(topology.triangle_edges[0][0], 3); /* opposite to corner 0 of 0 2 1 lies 2-1 */
    sn_topology_free(&topology);
    sn_mesh_free(&mesh);
}

static void a_repeated_index_has_no_edges(void **state) {
    (void)state;
    const sn_vec3 positions[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const sn_triangle triangles[2] = {{{0, 1, 2}}, {{1, 1, 2}}};
    sn_mesh mesh = shape_of(3, positions, 2, triangles);
    sn_topology topology;
    build(&mesh, &topology);
    assert_int_equal(topology.edge_count, 3);
    for (int k = 0; k < 3; k++) assert_int_equal(topology.triangle_edges[1][k], SN_NONE);
    assert_int_equal(topology.edges[2].triangle_count, 1);
    sn_topology_free(&topology);
    sn_mesh_free(&mesh);
}

static void components_are_numbered_by_their_lowest_triangle(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), two = shape_join(&cube, &cube, 1.0, sn_v3(3, 0, 0));
    sn_triangle kept = two.triangles[0];
    two.triangles[0] = two.triangles[23]; /* the second cube now has the lowest triangle */
    two.triangles[23] = kept;
    sn_topology topology;
    build(&two, &topology);
    sn_index component[24];
    assert_int_equal(sn_mesh_components(&two, &topology, component), 2);
    assert_int_equal(component[0], 0);
    assert_int_equal(component[1], 1);
    assert_int_equal(component[12], 0);
    assert_int_equal(component[23], 1);
    sn_topology_free(&topology);
    sn_mesh_free(&two);
    sn_mesh_free(&cube);
}

/* Triangles around a ring in an order that makes long chains of joins. */
static void components_of_a_shuffled_strip_are_one(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(30, 60);
    uint64_t seed = 7;
    for (sn_index t = sphere.triangle_count - 1; t > 0; t--) {
        sn_index other = (sn_index)(sn_random(&seed) * (t + 1));
        sn_triangle kept = sphere.triangles[t];
        sphere.triangles[t] = sphere.triangles[other];
        sphere.triangles[other] = kept;
    }
    sn_topology topology;
    build(&sphere, &topology);
    sn_index *component = SN_NEW(sn_index, sphere.triangle_count);
    assert_int_equal(sn_mesh_components(&sphere, &topology, component), 1);
    for (sn_index t = 0; t < sphere.triangle_count; t++) assert_int_equal(component[t], 0);
    free(component);
    sn_topology_free(&topology);
    sn_mesh_free(&sphere);
}

static bool has_edge(sn_triangle t, sn_index a, sn_index b) {
    if (t.v[0] == t.v[1] || t.v[1] == t.v[2] || t.v[2] == t.v[0]) return false;
    int found = 0;
    for (int k = 0; k < 3; k++) found += t.v[k] == a || t.v[k] == b;
    return found == 2;
}

static void check_edge(const sn_mesh *mesh, const sn_topology *topology, sn_index a, sn_index b) {
    sn_index count = 0, first = SN_NONE;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!has_edge(mesh->triangles[t], a, b)) continue;
        if (count++ == 0) first = t;
    }
    sn_index e = sn_topology_edge(topology, a, b);
    assert_int_equal(e, sn_topology_edge(topology, b, a));
    if (count == 0) {
        assert_int_equal(e, SN_NONE);
        return;
    }
    assert_true(e >= 0 && e < topology->edge_count);
    assert_int_equal(topology->edges[e].triangle_count, count);
    assert_int_equal(topology->edges[e].triangle[0], first);
}

static void check_lists(const sn_mesh *mesh, const sn_topology *topology) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        for (sn_index i = topology->vertex_start[v]; i < topology->vertex_start[v + 1]; i++) {
            if (i > topology->vertex_start[v]) assert_true(topology->neighbours[i - 1] < topology->neighbours[i]);
            assert_int_equal(topology->vertex_edges[i], sn_topology_edge(topology, v, topology->neighbours[i]));
        }
        for (sn_index i = topology->corner_start[v]; i < topology->corner_start[v + 1]; i++) {
            const sn_index *corner = mesh->triangles[topology->vertex_triangles[i]].v;
            assert_true(corner[0] == v || corner[1] == v || corner[2] == v);
            if (i > topology->corner_start[v]) assert_true(topology->vertex_triangles[i - 1] <= topology->vertex_triangles[i]);
        }
    }
    assert_int_equal(topology->corner_start[mesh->vertex_count], 3 * mesh->triangle_count);
    assert_int_equal(topology->vertex_start[mesh->vertex_count], 2 * topology->edge_count);
}

static void random_soups_agree_with_a_simple_count(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int round = 0; round < 50; round++) {
        sn_mesh soup = shape_empty(9, 1 + round);
        for (sn_index t = 0; t < soup.triangle_count; t++) {
            for (int k = 0; k < 3; k++) soup.triangles[t].v[k] = (sn_index)(sn_random(&seed) * 9);
        }
        sn_topology topology;
        build(&soup, &topology);
        for (sn_index a = 0; a < 9; a++) {
            for (sn_index b = a + 1; b < 9; b++) check_edge(&soup, &topology, a, b);
        }
        check_lists(&soup, &topology);
        sn_topology_free(&topology);
        sn_mesh_free(&soup);
    }
}

static void a_mesh_without_triangles_has_no_edges(void **state) {
    (void)state;
    sn_mesh points = shape_empty(3, 0);
    sn_topology topology;
    build(&points, &topology);
    assert_int_equal(topology.edge_count, 0);
    assert_int_equal(topology.vertex_start[3], 0);
    sn_topology_free(&topology);
    sn_topology_free(&topology);
    sn_mesh_free(&points);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tetrahedron_has_six_edges_in_order),
        cmocka_unit_test(a_repeated_index_has_no_edges),
        cmocka_unit_test(components_are_numbered_by_their_lowest_triangle),
        cmocka_unit_test(components_of_a_shuffled_strip_are_one),
        cmocka_unit_test(random_soups_agree_with_a_simple_count),
        cmocka_unit_test(a_mesh_without_triangles_has_no_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
