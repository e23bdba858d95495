/* test_moving.c -- nearest points and sides of a surface whose vertices move, held against Embree and the whole mesh. */
#include "sim_scene.h"

#include "sinew/moving.h"

#include <stdlib.h>

/* A surface, a shape of it, and what asks it. */
typedef struct fixture {
    sn_mesh mesh; /* as deformed */
    sn_moving moving;
    sn_box *boxes;
    sn_moving_shape shape;
} fixture;

static sn_vec3 bent(sn_vec3 p) { return sn_v3(p.x + 1.5 * p.z * p.z, p.y * (1.0 + 2.0 * p.z), p.z - 0.6 * p.x); }

static void make(fixture *f, bool deform) {
    fusiform shape = FUSIFORM;
    make_surface(&shape, &f->mesh);
    assert_int_equal(sn_moving_create(&f->mesh, &f->moving, NULL), SN_OK);
    for (sn_index v = 0; v < f->mesh.vertex_count && deform; v++) f->mesh.positions[v] = bent(f->mesh.positions[v]);
    f->boxes = SN_NEW(sn_box, sn_moving_box_count(&f->moving));
    sn_moving_fit(&f->moving, f->mesh.positions, f->boxes);
    f->shape = (sn_moving_shape){&f->moving, f->mesh.positions, f->boxes};
}

static void unmake(fixture *f) {
    sn_moving_free(&f->moving);
    sn_mesh_free(&f->mesh);
    free(f->boxes);
}

static double drawn(uint64_t *seed) {
    *seed = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

/* A point in twice the box. */
static sn_vec3 draw(const sn_mesh *mesh, uint64_t *seed) {
    sn_box box = sn_mesh_box(mesh);
    sn_vec3 size = sn_sub(box.high, box.low);
    return sn_v3(box.low.x + size.x * (2.0 * drawn(seed) - 0.5), box.low.y + size.y * (2.0 * drawn(seed) - 0.5),
                 box.low.z + size.z * (2.0 * drawn(seed) - 0.5));
}

static void distance_and_side_are_those_of_the_whole_surface(void **state) {
    (void)state;
    fixture f;
    make(&f, true);
    sn_surface *surface;
    assert_int_equal(sn_surface_create(&f.mesh, &surface, NULL), SN_OK);
    uint64_t seed = 7;
    int inside = 0;
    for (int i = 0; i < 4000; i++) {
        sn_vec3 p = draw(&f.mesh, &seed), gradient;
        sn_closest foot = sn_moving_closest(&f.shape, (sn_index)(drawn(&seed) * f.mesh.triangle_count), p);
        double side = sn_moving_side(&f.shape, &foot, p, &gradient), right = sn_surface_signed_distance(surface, p, NULL);
        assert_true(fabs(side - right) <= 1e-14);
        assert_true(fabs(sn_norm(gradient) - 1.0) < 1e-12);
        inside += side < 0.0;
        sn_closest beyond = sn_moving_closest(&f.shape, 0, sn_add_scaled(p, gradient, -side));
        assert_true(beyond.distance < 1e-12); /* down the gradient is the surface */
    }
    assert_true(inside > 100);
    sn_surface_destroy(surface);
    unmake(&f);
}

static void the_search_ends_alike_wherever_it_starts(void **state) {
    (void)state;
    fixture f;
    make(&f, true);
    uint64_t seed = 11;
    const sn_index starts[] = {0, f.mesh.triangle_count - 1, SN_NONE, SN_INDEX_MAX, f.mesh.triangle_count / 3};
    for (int i = 0; i < 500; i++) {
        sn_vec3 p = i % 2 ? draw(&f.mesh, &seed) : f.mesh.positions[i % f.mesh.vertex_count]; /* on a vertex many triangles are as near */
        sn_closest first = sn_moving_closest(&f.shape, starts[0], p);
        for (int k = 1; k < 5; k++) {
            sn_closest other = sn_moving_closest(&f.shape, starts[k], p);
            assert_int_equal(other.triangle, first.triangle);
            assert_true(other.distance == first.distance);
        }
    }
    unmake(&f);
}

static void a_short_walk_finds_the_nearest_point(void **state) {
    (void)state;
    fixture f;
    make(&f, true);
    uint64_t seed = 13;
    int same = 0, count = 0;
    for (int i = 0; i < 2000; i++) {
        const sn_index *v = f.mesh.triangles[(sn_index)(drawn(&seed) * f.mesh.triangle_count)].v;
        sn_vec3 p = sn_add_scaled(f.mesh.positions[v[0]], sn_sub(draw(&f.mesh, &seed), f.mesh.positions[v[0]]), 0.02);
        sn_vec3 q = sn_add_scaled(p, sn_sub(draw(&f.mesh, &seed), p), 0.02);
        sn_closest from = sn_moving_closest(&f.shape, 0, p), walked = sn_moving_walk(&f.shape, from.triangle, q),
                   right = sn_moving_closest(&f.shape, 0, q);
        assert_true(walked.distance >= right.distance);
        same += walked.distance == right.distance, count++;
    }
    assert_true(same >= 0.9 * count); /* what is left are other minima: behind a crease, on the other side of the middle */
    unmake(&f);
}

static void a_part_knows_its_neighbours_and_its_rim(void **state) {
    (void)state;
    fixture f;
    make(&f, false);
    sn_index n = f.moving.triangle_count, *vertices = SN_NEW(sn_index, f.moving.vertex_count);
    bool *keep = SN_NEW(bool, n);
    sn_box half = sn_mesh_box(&f.mesh);
    half.low.z = 0.5 * (half.low.z + half.high.z);
    bool *touched = SN_NEW(bool, sn_moving_leaf_count(&f.moving));
    sn_moving_touch(&f.moving, f.boxes, &half, touched);
    for (sn_index t = 0; t < n; t++) keep[t] = touched[sn_moving_leaf(&f.moving, t)];
    sn_moving part;
    assert_int_equal(sn_moving_part(&f.moving, keep, &part, vertices, NULL), SN_OK);
    assert_true(part.triangle_count > n / 3 && part.triangle_count < n);
    sn_vec3 *positions = SN_NEW(sn_vec3, part.vertex_count);
    for (sn_index v = 0; v < part.vertex_count; v++) positions[v] = f.mesh.positions[vertices[v]];
    sn_box *boxes = SN_NEW(sn_box, sn_moving_box_count(&part));
    sn_moving_fit(&part, positions, boxes);
    sn_moving_shape shape = {&part, positions, boxes};
    uint64_t seed = 17;
    sn_index rims = 0;
    for (sn_index v = 0; v < part.vertex_count; v++) rims += part.rim[v];
    assert_true(rims > 4 && rims < part.vertex_count / 2);
    for (int i = 0; i < 1000; i++) { /* in the box of what is kept the nearest point and the side are the whole surface's */
        sn_vec3 p = draw(&f.mesh, &seed);
        sn_closest whole = sn_moving_closest(&f.shape, 0, p), here = sn_moving_closest(&shape, 0, p);
        assert_true(here.distance >= whole.distance);
        if (whole.point.z < half.low.z) continue;
        assert_true(here.distance == whole.distance);
        assert_true(sn_moving_side(&shape, &here, p, NULL) == sn_moving_side(&f.shape, &whole, p, NULL));
    }
    sn_vec3 below = sn_v3(0.0, 0.0, half.low.z - 0.3 * (half.high.z - half.low.z)); /* inside the whole, but beyond the rim of the part */
    sn_closest foot = sn_moving_closest(&shape, 0, below);
    assert_true(sn_moving_side(&shape, &foot, below, NULL) > 0.0);
    sn_moving_free(&part);
    free(vertices), free(keep), free(touched), free(positions), free(boxes);
    unmake(&f);
}

static void what_has_no_two_sides_is_refused(void **state) {
    (void)state;
    sn_vec3 corners[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
    sn_triangle turned[2] = {{{0, 1, 2}}, {{0, 1, 3}}}, three[3] = {{{0, 1, 2}}, {{1, 0, 3}}, {{0, 1, 4}}};
    sn_mesh mesh = {.vertex_count = 5, .triangle_count = 2, .positions = corners, .triangles = turned};
    sn_moving moving;
    sn_error error;
    assert_int_equal(sn_moving_create(&mesh, &moving, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "opposite sides"));
    mesh.triangle_count = 3, mesh.triangles = three;
    assert_int_equal(sn_moving_create(&mesh, &moving, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "3 triangles"));
}

/* Without an area anywhere there is still a nearest point, and no number that is not one. */
static void a_collapsed_surface_is_survived(void **state) {
    (void)state;
    fixture f;
    make(&f, false);
    for (sn_index v = 0; v < f.mesh.vertex_count; v++) f.mesh.positions[v] = sn_v3(1, 2, 3);
    sn_moving_fit(&f.moving, f.mesh.positions, f.boxes);
    sn_vec3 gradient;
    sn_closest foot = sn_moving_closest(&f.shape, 5, sn_v3(1, 2, 5));
    assert_true(sn_moving_side(&f.shape, &foot, sn_v3(1, 2, 5), &gradient) == 2.0 && gradient.z == 1.0);
    foot = sn_moving_closest(&f.shape, 5, sn_v3(1, 2, 3));
    assert_true(sn_moving_side(&f.shape, &foot, sn_v3(1, 2, 3), &gradient) == 0.0 && sn_norm(gradient) == 0.0);
    unmake(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distance_and_side_are_those_of_the_whole_surface),
        cmocka_unit_test(the_search_ends_alike_wherever_it_starts),
        cmocka_unit_test(a_short_walk_finds_the_nearest_point),
        cmocka_unit_test(a_part_knows_its_neighbours_and_its_rim),
        cmocka_unit_test(what_has_no_two_sides_is_refused),
        cmocka_unit_test(a_collapsed_surface_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
