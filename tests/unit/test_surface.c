/*
 * test_surface.c -- closest points, signed distances and rays against brute force and against shapes with known answers.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "sinew/geom.h"
#include "sinew/thread.h"

static double between(uint64_t *seed, double low, double high) { return low + (high - low) * sn_random(seed); }
static sn_vec3 random_point(uint64_t *seed, double half) {
    double x = between(seed, -half, half), y = between(seed, -half, half), z = between(seed, -half, half);
    return sn_v3(x, y, z);
}
static sn_vec3 random_direction(uint64_t *seed) {
    sn_vec3 d;
    do d = random_point(seed, 1);
    while (sn_norm(d) > 1 || sn_norm(d) < 0.1);
    return sn_normalize(d);
}

/* ---- shapes --------------------------------------------------------------------------------------------------------------- */

/* A globe of 2 rings x sectors triangles, closed and outwards. bump = 0: all vertices at `radius` from the centre. */
static sn_mesh globe(sn_index rings, sn_index sectors, sn_vec3 centre, double radius, double bump) {
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_alloc(&mesh, rings * sectors + 2, 2 * rings * sectors, NULL), SN_OK);
    sn_index south = rings * sectors, north = south + 1, t = 0;
    for (sn_index r = 0; r < rings; r++) {
        for (sn_index s = 0; s < sectors; s++) {
            double latitude = SN_PI * ((r + 1.0) / (rings + 1.0) - 0.5), longitude = 2 * SN_PI * s / sectors;
            double here = radius * (1 + bump * sin(3 * longitude) * cos(5 * latitude));
            sn_vec3 d = sn_v3(cos(latitude) * cos(longitude), cos(latitude) * sin(longitude), sin(latitude));
            mesh.positions[r * sectors + s] = sn_add_scaled(centre, d, here);
            sn_index next = (s + 1) % sectors, a = r * sectors + s, b = r * sectors + next;
            if (r == 0) mesh.triangles[t++] = (sn_triangle){{south, b, a}};
            if (r == rings - 1) mesh.triangles[t++] = (sn_triangle){{north, a, b}};
            if (r == rings - 1) continue;
            mesh.triangles[t++] = (sn_triangle){{a, b, b + sectors}};
            mesh.triangles[t++] = (sn_triangle){{a, b + sectors, a + sectors}};
        }
    }
    mesh.positions[south] = sn_add_scaled(centre, sn_v3(0, 0, -1), radius);
    mesh.positions[north] = sn_add_scaled(centre, sn_v3(0, 0, 1), radius);
    assert_int_equal(t, mesh.triangle_count);
    return mesh;
}

static void turn_inside_out(sn_mesh *mesh) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_index swap = mesh->triangles[t].v[1];
        mesh->triangles[t].v[1] = mesh->triangles[t].v[2];
        mesh->triangles[t].v[2] = swap;
    }
}

static sn_mesh join(const sn_mesh *a, const sn_mesh *b) {
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_alloc(&mesh, a->vertex_count + b->vertex_count, a->triangle_count + b->triangle_count, NULL), SN_OK);
    memcpy(mesh.positions, a->positions, (size_t)a->vertex_count * sizeof *a->positions);
    memcpy(mesh.positions + a->vertex_count, b->positions, (size_t)b->vertex_count * sizeof *b->positions);
    memcpy(mesh.triangles, a->triangles, (size_t)a->triangle_count * sizeof *a->triangles);
    for (sn_index t = 0; t < b->triangle_count; t++) {
        for (int k = 0; k < 3; k++) mesh.triangles[a->triangle_count + t].v[k] = b->triangles[t].v[k] + a->vertex_count;
    }
    return mesh;
}

static sn_mesh cube(void) {
    static const sn_triangle triangles[12] = {{{0, 2, 1}}, {{1, 2, 3}}, {{4, 5, 6}}, {{5, 7, 6}}, {{0, 1, 4}}, {{1, 5, 4}},
                                              {{2, 6, 3}}, {{3, 6, 7}}, {{0, 4, 2}}, {{2, 4, 6}}, {{1, 3, 5}}, {{3, 7, 5}}};
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_alloc(&mesh, 8, 12, NULL), SN_OK);
    for (int i = 0; i < 8; i++) mesh.positions[i] = sn_v3(i & 1, i >> 1 & 1, i >> 2 & 1);
    memcpy(mesh.triangles, triangles, sizeof triangles);
    return mesh;
}

static sn_surface *surface_of(const sn_mesh *mesh) {
    sn_surface *surface = NULL;
    sn_error error = {0};
    if (sn_surface_create(mesh, &surface, &error) != SN_OK) fail_msg("%s", error.text);
    return surface;
}

static sn_closest brute_force(const sn_mesh *mesh, sn_vec3 p) {
    sn_closest best = {.triangle = SN_NONE, .distance = INFINITY};
    double best2 = INFINITY;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 q = sn_closest_on_triangle(p, mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]], NULL);
        double distance2 = sn_norm2(sn_sub(q, p));
        if (!(distance2 < best2)) continue;
        best2 = distance2;
        best = (sn_closest){.triangle = t, .point = q, .distance = sqrt(distance2)};
    }
    return best;
}

/* ---- closest points --------------------------------------------------------------------------------------------------------- */

static void assert_like_brute_force(const sn_mesh *mesh, const sn_surface *surface, sn_vec3 p) {
    sn_closest expected = brute_force(mesh, p), got = sn_surface_closest(surface, p, INFINITY);
    assert_int_equal(got.triangle, expected.triangle);
    assert_true(got.distance == expected.distance);
    assert_memory_equal(&got.point, &expected.point, sizeof got.point);
}

/* All of `points` points: on the surface's vertices, near it, about its size away, and far out. */
static void compare_with_brute_force(const sn_mesh *mesh, sn_vec3 centre, double size, int points, uint64_t seed) {
    sn_surface *surface = surface_of(mesh);
    for (int i = 0; i < points; i++) {
        sn_vec3 vertex = mesh->positions[(sn_index)(sn_random(&seed) * mesh->vertex_count)];
        double reach = size * pow(10, between(&seed, -9, 1));
        sn_vec3 from = i % 4 == 0 ? centre : vertex;
        assert_like_brute_force(mesh, surface, i % 16 == 1 ? vertex : sn_add_scaled(from, random_point(&seed, 1), reach));
    }
    for (int power = 2; power < 12; power++)
        assert_like_brute_force(mesh, surface, sn_add_scaled(centre, random_direction(&seed), size * pow(10, power)));
    sn_surface_destroy(surface);
}

static void closest_point_like_brute_force(void **state) {
    (void)state;
    sn_mesh mesh = globe(40, 30, sn_v3(0, 0, 0), 0.1, 0.3);
    compare_with_brute_force(&mesh, sn_v3(0, 0, 0), 0.1, 10000, 1);
    sn_mesh_free(&mesh);
}

/* 1 km from the origin, micrometres and light-seconds large, and a flake a millionth as thick as it is wide. */
static void closest_point_in_odd_places(void **state) {
    (void)state;
    const sn_vec3 far = {1000, -1000, 1000};
    sn_mesh mesh = globe(20, 20, far, 0.1, 0.3);
    compare_with_brute_force(&mesh, far, 0.1, 2000, 2);
    sn_mesh_free(&mesh);
    const double sizes[] = {1e-30, 1e-6, 3e8, 1e30};
    for (int i = 0; i < 4; i++) {
        mesh = globe(10, 10, sn_v3(0, 0, 0), sizes[i], 0.3);
        compare_with_brute_force(&mesh, sn_v3(0, 0, 0), sizes[i], 1000, 3);
        sn_mesh_free(&mesh);
    }
    mesh = globe(20, 20, sn_v3(0, 0, 0), 1, 0.3);
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v].z *= 1e-6;
    compare_with_brute_force(&mesh, sn_v3(0, 0, 0), 1, 2000, 4);
    sn_mesh_free(&mesh);
}

/* A mesh of one point has no size; degenerate triangles are found like any other. */
static void closest_point_on_degenerate_meshes(void **state) {
    (void)state;
    sn_vec3 positions[4] = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {4, 2, 3}};
    sn_triangle triangles[3] = {{{0, 1, 2}}, {{0, 0, 3}}, {{1, 2, 3}}};
    sn_mesh mesh = {.vertex_count = 4, .triangle_count = 1, .positions = positions, .triangles = triangles};
    for (mesh.triangle_count = 1; mesh.triangle_count <= 3; mesh.triangle_count++) {
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 5;
        for (int i = 0; i < 100; i++) {
            sn_vec3 p = random_point(&seed, 5);
            assert_like_brute_force(&mesh, surface, p);
            assert_true(sn_surface_signed_distance(surface, p, NULL) > 0);
        }
        assert_true(sn_surface_signed_distance(surface, positions[0], NULL) == 0);
        sn_surface_destroy(surface);
    }
}

static void ties_go_to_the_lowest_triangle(void **state) {
    (void)state;
    sn_mesh mesh = cube();
    sn_surface *surface = surface_of(&mesh);
    assert_int_equal(sn_surface_closest(surface, sn_v3(0.5, 0.5, 0.5), INFINITY).triangle, 0);
    for (int corner = 0; corner < 8; corner++) {
        sn_vec3 p = sn_lerp(sn_v3(0.5, 0.5, 0.5), mesh.positions[corner], 3);
        sn_index lowest = 0;
        while (mesh.triangles[lowest].v[0] != corner && mesh.triangles[lowest].v[1] != corner && mesh.triangles[lowest].v[2] != corner)
            lowest++;
        assert_int_equal(sn_surface_closest(surface, p, INFINITY).triangle, lowest);
    }
    sn_surface_destroy(surface);
    sn_mesh_free(&mesh);
}

static void closest_point_within_reach(void **state) {
    (void)state;
    sn_mesh mesh = cube();
    sn_surface *surface = surface_of(&mesh);
    const sn_vec3 p = {0.5, 0.5, 3};
    assert_int_equal(sn_surface_closest(surface, p, 1.999).triangle, SN_NONE);
    assert_int_equal(sn_surface_closest(surface, p, 2).triangle, 2);
    assert_int_equal(sn_surface_closest(surface, p, 0).triangle, SN_NONE);
    assert_int_equal(sn_surface_closest(surface, p, -1).triangle, SN_NONE);
    assert_int_equal(sn_surface_closest(surface, p, NAN).triangle, SN_NONE);
    assert_int_equal(sn_surface_closest(surface, sn_v3(NAN, 0, 0), INFINITY).triangle, SN_NONE);
    assert_int_equal(sn_surface_closest(surface, sn_v3(0, INFINITY, 0), INFINITY).triangle, SN_NONE);
    assert_true(sn_surface_closest(surface, sn_v3(0.25, 0.25, 1), 0).distance == 0);
    sn_surface_destroy(surface);
    sn_mesh_free(&mesh);
}

/* ---- signed distance ------------------------------------------------------------------------------------------------------------ */

/* Over faces, edges and corners of the unit cube, by its formula. */
static double cube_distance(sn_vec3 p) {
    sn_vec3 d = sn_v3(fabs(p.x - 0.5) - 0.5, fabs(p.y - 0.5) - 0.5, fabs(p.z - 0.5) - 0.5);
    sn_vec3 out = sn_max3(d, sn_v3(0, 0, 0));
    return sn_norm(out) + fmin(fmax(d.x, fmax(d.y, d.z)), 0);
}

static void signed_distance_of_a_cube(void **state) {
    (void)state;
    sn_mesh mesh = cube();
    for (int turned = 0; turned < 2; turned++) {
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 6;
        for (int i = 0; i < 5000; i++) {
            sn_vec3 p = sn_add(sn_v3(0.5, 0.5, 0.5), random_point(&seed, 1));
            if (i % 3 == 0) p.x = p.y; /* into the planes of edges and corners too */
            assert_true(fabs(sn_surface_signed_distance(surface, p, NULL) - cube_distance(p)) < 1e-14);
        }
        sn_surface_destroy(surface);
        turn_inside_out(&mesh);
    }
    sn_mesh_free(&mesh);
}

/* Very near a bumpy surface, where counting crossings of a ray goes wrong: the sign is that of the winding number. */
static void sign_near_the_surface(void **state) {
    (void)state;
    const sn_vec3 places[2] = {{0, 0, 0}, {1000, 1000, 1000}};
    for (int i = 0; i < 2; i++) {
        sn_mesh mesh = globe(20, 20, places[i], 0.1, 0.3);
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 7;
        for (int k = 0; k < 3000; k++) {
            const sn_index *v = mesh.triangles[(sn_index)(sn_random(&seed) * mesh.triangle_count)].v;
            sn_vec3 on = sn_lerp(mesh.positions[v[0]], sn_lerp(mesh.positions[v[1]], mesh.positions[v[2]], sn_random(&seed)),
                                 k % 3 == 0 ? 0.0 : sn_random(&seed));
            sn_vec3 p = sn_add_scaled(on, random_direction(&seed), pow(10, between(&seed, -8, -2)));
            double distance = sn_surface_signed_distance(surface, p, NULL);
            assert_int_equal(distance<0, sn_winding_number(&mesh, p)> 0.5);
        }
        sn_surface_destroy(surface);
        sn_mesh_free(&mesh);
    }
}

/* Two overlapping bodies are one, also where the nearest surface is that of the other body inside this one. */
static void signed_distance_of_overlapping_bodies(void **state) {
    (void)state;
    sn_mesh a = globe(20, 20, sn_v3(0, 0, 0), 1, 0), b = globe(20, 20, sn_v3(1, 0, 0), 1, 0), both = join(&a, &b);
    sn_surface *surface = surface_of(&both);
    uint64_t seed = 8;
    for (int i = 0; i < 3000; i++) {
        sn_vec3 p = random_point(&seed, 2);
        bool inside = sn_winding_number(&a, p) > 0.5 || sn_winding_number(&b, p) > 0.5;
        assert_int_equal(sn_surface_signed_distance(surface, p, NULL) < 0, inside);
    }
    sn_surface_destroy(surface);
    sn_mesh_free(&a), sn_mesh_free(&b), sn_mesh_free(&both);
}

static void signed_distance_of_a_shell(void **state) {
    (void)state;
    sn_mesh outer = globe(20, 20, sn_v3(0, 0, 0), 2, 0), inner = globe(20, 20, sn_v3(0, 0, 0), 1, 0);
    turn_inside_out(&inner);
    sn_mesh shell = join(&outer, &inner);
    sn_surface *surface = surface_of(&shell);
    assert_true(sn_surface_signed_distance(surface, sn_v3(0, 0.1, 0), NULL) > 0);
    assert_true(sn_surface_signed_distance(surface, sn_v3(0, 1.5, 0), NULL) < 0);
    assert_true(sn_surface_signed_distance(surface, sn_v3(0, 2.5, 0), NULL) > 0);
    sn_surface_destroy(surface);
    sn_mesh_free(&outer), sn_mesh_free(&inner), sn_mesh_free(&shell);
}

/* A vertex pulled through the other side, and a spike bent back into the body: nearest points on a surface that crosses itself face
 * either way, also far from the crossing. */
static void signed_distance_of_a_crossed_mesh(void **state) {
    (void)state;
    for (int shape = 0; shape < 2; shape++) {
        sn_mesh mesh = globe(12, 12, sn_v3(0, 0, 0), 1, 0.2);
        mesh.positions[50 + shape] = sn_scale(mesh.positions[50 + shape], shape == 0 ? -2.5 : -0.9);
        if (shape == 1) mesh.positions[63] = sn_scale(mesh.positions[63], 3);
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 12;
        for (int i = 0; i < 5000; i++) {
            sn_vec3 p = random_point(&seed, 3);
            assert_int_equal(sn_surface_signed_distance(surface, p, NULL) < 0, fabs(sn_winding_number(&mesh, p)) > 0.5);
        }
        sn_surface_destroy(surface);
        sn_mesh_free(&mesh);
    }
}

/* A globe with a hole and a triangle turned over: the winding number still knows the inside. */
static void signed_distance_of_an_open_mesh(void **state) {
    (void)state;
    sn_mesh mesh = globe(20, 20, sn_v3(0, 0, 0), 1, 0);
    mesh.triangle_count -= 10;
    mesh.triangles[7] = (sn_triangle){{mesh.triangles[7].v[0], mesh.triangles[7].v[2], mesh.triangles[7].v[1]}};
    for (int turned = 0; turned < 2; turned++) {
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 9;
        for (int i = 0; i < 1000; i++) {
            sn_vec3 d = random_direction(&seed);
            if (d.z > 0.8) d.z = -d.z; /* away from the hole */
            sn_closest closest;
            assert_true(sn_surface_signed_distance(surface, sn_scale(d, 0.8), &closest) < 0);
            assert_true(closest.distance > 0 && closest.triangle != SN_NONE);
            assert_true(sn_surface_signed_distance(surface, sn_scale(d, 1.2), NULL) > 0);
        }
        sn_surface_destroy(surface);
        turn_inside_out(&mesh);
    }
    sn_mesh_free(&mesh);
}

/* With thousands of triangles far ones are summed by clusters; the verdict is that of the exact sum. */
static void signed_distance_of_a_large_open_mesh(void **state) {
    (void)state;
    for (int cut = 1; cut < 6; cut++) {
        sn_mesh mesh = globe(40, 40, sn_v3(0, 0, 0), 1, 0.3);
        mesh.triangle_count -= cut * 500;
        double top = -2;
        for (sn_index t = 0; t < 3 * mesh.triangle_count; t++) top = fmax(top, mesh.positions[mesh.triangles[t / 3].v[t % 3]].z);
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 13;
        for (int i = 0; i < 2000; i++) {
            sn_vec3 p = random_point(&seed, 1.2);
            if (p.z > top) continue; /* above the cut nothing is inside, by definition */
            bool inside = fabs(sn_winding_number(&mesh, p)) > 0.5;
            assert_int_equal(sn_surface_signed_distance(surface, p, NULL) < 0, inside);
        }
        sn_surface_destroy(surface);
        sn_mesh_free(&mesh);
    }
}

/* Two equal triangles back to back close, but enclose nothing. */
static void signed_distance_of_a_folded_sheet(void **state) {
    (void)state;
    sn_vec3 positions[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    sn_triangle triangles[2] = {{{0, 1, 2}}, {{0, 2, 1}}};
    sn_mesh mesh = {.vertex_count = 3, .triangle_count = 2, .positions = positions, .triangles = triangles};
    sn_surface *surface = surface_of(&mesh);
    for (int side = -1; side <= 1; side += 2) assert_true(sn_surface_signed_distance(surface, sn_v3(0.25, 0.25, side), NULL) == 1);
    assert_true(sn_surface_signed_distance(surface, sn_v3(0.25, 0.25, 0), NULL) == 0);
    sn_surface_destroy(surface);
}

/* ---- rays --------------------------------------------------------------------------------------------------------------------- */

/* From inside, towards vertices and edges too, every ray meets the surface; the place agrees with the triangle that it names. */
static void rays_do_not_leak(void **state) {
    (void)state;
    const sn_vec3 places[2] = {{0, 0, 0}, {1000, -1000, 1000}};
    for (int i = 0; i < 2; i++) {
        sn_mesh mesh = globe(15, 16, places[i], 0.1, 0.3);
        sn_surface *surface = surface_of(&mesh);
        uint64_t seed = 10;
        for (int k = 0; k < 20000; k++) {
            const sn_index *v = mesh.triangles[k % mesh.triangle_count].v;
            sn_vec3 target = sn_lerp(mesh.positions[v[0]], mesh.positions[v[1]], k % 2 == 0 ? 0 : sn_random(&seed));
            sn_vec3 direction = sn_scale(sn_sub(target, places[i]), 7);
            sn_ray_hit hit = sn_surface_ray(surface, places[i], direction, 0, INFINITY);
            assert_true(hit.triangle != SN_NONE);
            const sn_index *w = mesh.triangles[hit.triangle].v;
            sn_vec3 ab = sn_sub(mesh.positions[w[1]], mesh.positions[w[0]]), ac = sn_sub(mesh.positions[w[2]], mesh.positions[w[0]]);
            sn_vec3 by_corners = sn_add_scaled(sn_add_scaled(mesh.positions[w[0]], ab, hit.u), ac, hit.v);
            sn_vec3 by_distance = sn_add_scaled(places[i], sn_normalize(direction), hit.distance);
            assert_true(sn_distance(by_corners, by_distance) < 1e-6);
            assert_true(sn_distance(by_distance, target) < 1e-6);
        }
        sn_surface_destroy(surface);
        sn_mesh_free(&mesh);
    }
}

static void rays_have_ends(void **state) {
    (void)state;
    sn_mesh mesh = cube();
    sn_surface *surface = surface_of(&mesh);
    const sn_vec3 from = {0.3, 0.4, -5}, up = {0, 0, 2};
    assert_true(fabs(sn_surface_ray(surface, from, up, 0, INFINITY).distance - 5) < 1e-5);
    assert_true(fabs(sn_surface_ray(surface, from, up, 5.5, INFINITY).distance - 6) < 1e-5);
    assert_int_equal(sn_surface_ray(surface, from, up, 0, 4.9).triangle, SN_NONE);
    assert_int_equal(sn_surface_ray(surface, from, up, 6.1, INFINITY).triangle, SN_NONE);
    assert_int_equal(sn_surface_ray(surface, from, sn_neg(up), 0, INFINITY).triangle, SN_NONE);
    assert_int_equal(sn_surface_ray(surface, from, sn_v3(0, 0, 0), 0, INFINITY).triangle, SN_NONE);
    assert_int_equal(sn_surface_ray(surface, sn_v3(0, 0, NAN), up, 0, INFINITY).triangle, SN_NONE);
    /* from the moon, with a metre's accuracy of the origin's own digits */
    assert_true(fabs(sn_surface_ray(surface, sn_v3(0.3, 0.4, -4e8), up, 0, INFINITY).distance - 4e8) < 1e-5);
    sn_surface_destroy(surface);
    sn_mesh_free(&mesh);
}

/* ---- the world around ------------------------------------------------------------------------------------------------------------ */

static void bad_meshes_are_refused(void **state) {
    (void)state;
    sn_vec3 positions[3] = {{0, 0, 0}, {1, NAN, 0}, {0, 1, 0}};
    sn_triangle triangles[1] = {{{0, 1, 2}}};
    sn_mesh mesh = {.vertex_count = 3, .triangle_count = 1, .positions = positions, .triangles = triangles};
    sn_surface *surface = NULL;
    sn_error error = {0};
    assert_int_equal(sn_surface_create(&mesh, &surface, &error), SN_ERROR_INPUT);
    assert_null(surface);
    positions[1].y = 0;
    triangles[0].v[2] = 3;
    assert_int_equal(sn_surface_create(&mesh, &surface, &error), SN_ERROR_INPUT);
    mesh.triangle_count = 0;
    assert_int_equal(sn_surface_create(&mesh, &surface, &error), SN_ERROR_INPUT);
    sn_surface_destroy(NULL);
}

/* Denormals are flushed inside only: half of the smallest normal number is still not zero afterwards. */
static void floating_point_mode_is_the_callers(void **state) {
    (void)state;
    sn_mesh mesh = cube();
    sn_surface *surface = surface_of(&mesh);
    volatile double tiny = 2.2250738585072014e-308, half = 0.5;
    assert_true(tiny * half > 0);
    assert_true(sn_surface_signed_distance(surface, sn_v3(0.5, 0.5, 0.25), NULL) == -0.25);
    assert_true(tiny * half > 0);
    assert_true(sn_surface_ray(surface, sn_v3(0.3, 0.3, 9), sn_v3(0, 0, -1), 0, INFINITY).triangle != SN_NONE);
    assert_true(tiny * half > 0);
    sn_surface_destroy(surface);
    sn_mesh_free(&mesh);
}

/* Without an inside the closest points are the same, and distances have no sign. */
static void a_plain_surface_has_no_inside(void **state) {
    (void)state;
    sn_mesh mesh = globe(20, 20, sn_v3(0, 0, 0), 1, 0.3);
    sn_surface *full = surface_of(&mesh), *plain = NULL;
    assert_int_equal(sn_surface_create_plain(&mesh, &plain, NULL), SN_OK);
    uint64_t seed = 5;
    for (int i = 0; i < 500; i++) {
        sn_vec3 p = random_point(&seed, 1.5);
        sn_closest a = sn_surface_closest(full, p, INFINITY), b = sn_surface_closest(plain, p, INFINITY);
        assert_true(a.triangle == b.triangle && a.distance == b.distance);
        assert_true(sn_surface_signed_distance(plain, p, NULL) == fabs(sn_surface_signed_distance(full, p, NULL)));
    }
    sn_surface_destroy(full);
    sn_surface_destroy(plain);
    sn_mesh_free(&mesh);
}

enum { PARALLEL_POINTS = 2000 };
typedef struct parallel_work {
    const sn_surface *surface;
    sn_vec3 points[PARALLEL_POINTS];
    sn_closest closest[PARALLEL_POINTS];
    double distances[PARALLEL_POINTS];
} parallel_work;

static void measure_points(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    parallel_work *work = user;
    for (sn_index i = begin; i < end; i++)
        work->distances[i] = sn_surface_signed_distance(work->surface, work->points[i], &work->closest[i]);
}

static void threads_agree(void **state) {
    (void)state;
    static parallel_work one, four;
    sn_mesh mesh = globe(30, 30, sn_v3(0, 0, 0), 1, 0.3);
    sn_surface *surface = surface_of(&mesh);
    uint64_t seed = 11;
    for (int i = 0; i < PARALLEL_POINTS; i++) one.points[i] = four.points[i] = random_point(&seed, 1.5);
    one.surface = four.surface = surface;
    sn_parallel_for(NULL, PARALLEL_POINTS, 64, measure_points, &one);
    sn_pool *pool = sn_pool_create(4);
    assert_non_null(pool);
    sn_parallel_for(pool, PARALLEL_POINTS, 64, measure_points, &four);
    sn_pool_destroy(pool);
    assert_memory_equal(one.distances, four.distances, sizeof one.distances);
    for (int i = 0; i < PARALLEL_POINTS; i++) assert_int_equal(one.closest[i].triangle, four.closest[i].triangle);
    sn_surface_destroy(surface);
    sn_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closest_point_like_brute_force),
        cmocka_unit_test(closest_point_in_odd_places),
        cmocka_unit_test(closest_point_on_degenerate_meshes),
        cmocka_unit_test(ties_go_to_the_lowest_triangle),
        cmocka_unit_test(closest_point_within_reach),
        cmocka_unit_test(signed_distance_of_a_cube),
        cmocka_unit_test(sign_near_the_surface),
        cmocka_unit_test(signed_distance_of_overlapping_bodies),
        cmocka_unit_test(signed_distance_of_a_shell),
        cmocka_unit_test(signed_distance_of_a_crossed_mesh),
        cmocka_unit_test(signed_distance_of_an_open_mesh),
        cmocka_unit_test(signed_distance_of_a_large_open_mesh),
        cmocka_unit_test(signed_distance_of_a_folded_sheet),
        cmocka_unit_test(rays_do_not_leak),
        cmocka_unit_test(rays_have_ends),
        cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(floating_point_mode_is_the_callers),
        cmocka_unit_test(threads_agree),
        cmocka_unit_test(a_plain_surface_has_no_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
