/* test_distance_field.c -- tabulated signed distances: exact, continuous, right of sign on every kind of surface, and kept in files. */
#include "shapes.h"

#include <stdio.h>
#include <unistd.h>

#include "sinew/distance_field.h"
#include "sinew/io.h"

/* ---- surfaces ----------------------------------------------------------------------------------------------------------------- */

enum { RINGS = 96, AROUND = 48 };
static const double ring_radius = 1.0, tube_radius = 0.35;

static sn_mesh torus(void) {
    sn_mesh mesh = shape_empty(RINGS * AROUND, 2 * RINGS * AROUND);
    for (sn_index r = 0; r < RINGS; r++) {
        for (sn_index a = 0; a < AROUND; a++) {
            double u = 2.0 * SN_PI * r / RINGS, v = 2.0 * SN_PI * a / AROUND, out = ring_radius + tube_radius * cos(v);
            mesh.positions[r * AROUND + a] = sn_v3(out * cos(u), out * sin(u), tube_radius * sin(v));
            sn_index i = r * AROUND + a, j = (r + 1) % RINGS * AROUND + a, up = (a + 1) % AROUND - a;
            mesh.triangles[2 * i] = (sn_triangle){{i, j, j + up}};
            mesh.triangles[2 * i + 1] = (sn_triangle){{i, j + up, i + up}};
        }
    }
    return mesh;
}

static double torus_distance(sn_vec3 p) { return hypot(hypot(p.x, p.y) - ring_radius, p.z) - tube_radius; }
static double sphere_distance(sn_vec3 p) { return sn_norm(p) - 1.0; }

/* Of the box [0, size]. */
static double box_distance(sn_vec3 p, sn_vec3 size) {
    sn_vec3 d =
        sn_v3(fabs(p.x - 0.5 * size.x) - 0.5 * size.x, fabs(p.y - 0.5 * size.y) - 0.5 * size.y, fabs(p.z - 0.5 * size.z) - 0.5 * size.z);
    return sn_norm(sn_max3(d, sn_v3(0, 0, 0))) + fmin(fmax(d.x, fmax(d.y, d.z)), 0.0);
}
static double cube_distance(sn_vec3 p) { return box_distance(p, sn_v3(1, 1, 1)); }
static double plate_distance(sn_vec3 p) { return box_distance(p, sn_v3(1, 1, 0.03)); }

static sn_mesh plate(void) {
    sn_mesh mesh = shape_cube();
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v].z *= 0.03;
    return mesh;
}

static void turn(sn_mesh *mesh) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) shape_flip(mesh, t);
}

static sn_distance_field field_of(const sn_mesh *mesh, double cell) {
    sn_distance_field_params params = sn_distance_field_defaults(cell);
    sn_distance_field field;
    sn_error error = {0};
    if (sn_distance_field_create(mesh, &params, &field, &error) != SN_OK) fail_msg("%s", error.text);
    assert_true(sn_distance_field_is_valid(&field));
    return field;
}

static sn_vec3 random_in(sn_box box, uint64_t *state) {
    sn_vec3 size = sn_sub(box.high, box.low);
    sn_vec3 share = sn_v3(sn_random(state), sn_random(state), sn_random(state));
    return sn_add(box.low, sn_v3(size.x * share.x, size.y * share.y, size.z * share.z));
}

/* ---- values ------------------------------------------------------------------------------------------------------------------- */

/* Corner (i, j, k) of brick b. */
static double corner_value(const sn_distance_field *f, sn_index b, sn_index i, sn_index j, sn_index k) {
    return (double)f->values[(size_t)b * SN_BRICK_VALUES + (size_t)(i + SN_BRICK_CORNERS * (j + SN_BRICK_CORNERS * k))];
}

static sn_vec3 corner_point(const sn_distance_field *f, sn_index place, sn_index i, sn_index j, sn_index k) {
    const sn_index *n = f->bricks;
    sn_vec3 at =
        sn_v3(SN_BRICK_CELLS * (place % n[0]) + i, SN_BRICK_CELLS * (place / n[0] % n[1]) + j, SN_BRICK_CELLS * (place / n[0] / n[1]) + k);
    return sn_add_scaled(f->origin, at, f->cell);
}

/* Every corner within the band holds the distance that the search structure gives, whose signs come from pseudonormals. */
static void expect_exact_corners(const sn_mesh *mesh, const sn_distance_field *f) {
    sn_surface *surface;
    sn_index looked_at = 0;
    assert_ok(sn_surface_create(mesh, &surface, NULL));
    for (sn_index place = 0; place < f->bricks[0] * f->bricks[1] * f->bricks[2]; place++) {
        for (sn_index c = 0; f->brick[place] != SN_NONE && c < SN_BRICK_VALUES; c++) {
            sn_index i = c % SN_BRICK_CORNERS, j = c / SN_BRICK_CORNERS % SN_BRICK_CORNERS, k = c / (SN_BRICK_CORNERS * SN_BRICK_CORNERS);
            double exact = sn_surface_signed_distance(surface, corner_point(f, place, i, j, k), NULL);
            if (fabs(exact) > f->band) continue;
            assert_near(corner_value(f, f->brick[place], i, j, k), exact, 1e-7 * fabs(exact) + 1e-12);
            looked_at++;
        }
    }
    assert_true(looked_at > 1000);
    sn_surface_destroy(surface);
}

/* Within the band a trilinear interpolant is off by a share of the cell; the mesh by `sag`. Signs are right beyond both. */
static void expect_analytic(const sn_mesh *mesh, double (*distance)(sn_vec3), double cell, double sag) {
    sn_distance_field f = field_of(mesh, cell);
    uint64_t state = 5;
    expect_exact_corners(mesh, &f);
    for (int i = 0; i < 20000; i++) {
        sn_vec3 p = random_in(sn_distance_field_box(&f), &state);
        double exact = distance(p), phi = sn_distance_field_at(&f, p, NULL);
        if (fabs(exact) < 3.0 * cell - sag) assert_near(phi, exact, 0.5 * cell + sag);
        if (fabs(exact) > 0.3 * cell + sag) assert_true((phi < 0.0) == (exact < 0.0));
        assert_true(fabs(phi) <= fabs(exact) + 4.0 * cell);
    }
    sn_distance_field_free(&f);
}

static void test_analytic_shapes(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(47, 96), ring = torus(), cube = shape_cube(), thin = plate();
    expect_analytic(&sphere, sphere_distance, 0.06, 2e-3);
    expect_analytic(&ring, torus_distance, 0.05, 2e-3);
    expect_analytic(&cube, cube_distance, 0.04, 1e-9);
    expect_analytic(&thin, plate_distance, 0.01, 1e-9);
    sn_mesh_free(&sphere);
    sn_mesh_free(&ring);
    sn_mesh_free(&cube);
    sn_mesh_free(&thin);
}

/* Smooth and well resolved, the interpolant is much better than half a cell: its error goes with the cell's square. */
static void test_error_falls_with_the_square_of_the_cell(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(95, 192);
    double worst[2] = {0.0, 0.0};
    for (int k = 0; k < 2; k++) {
        double cell = k == 0 ? 0.1 : 0.05;
        sn_distance_field f = field_of(&sphere, cell);
        uint64_t random = 3;
        for (int i = 0; i < 20000; i++) {
            sn_vec3 p = random_in(sn_distance_field_box(&f), &random);
            if (fabs(sphere_distance(p)) < 0.1) worst[k] = fmax(worst[k], fabs(sn_distance_field_at(&f, p, NULL) - sphere_distance(p)));
        }
        sn_distance_field_free(&f);
    }
    assert_true(worst[0] < 0.05 * 0.1);
    assert_true(worst[1] < 0.35 * worst[0]);
    sn_mesh_free(&sphere);
}

/* ---- the interpolant --------------------------------------------------------------------------------------------------------------- */

/* Central differences within one cell of the finest kind: the interpolant is of degree one along each axis, so they are exact. */
static void test_gradient_is_that_of_the_interpolant(void **state) {
    (void)state;
    sn_mesh ring = torus();
    sn_distance_field f = field_of(&ring, 0.04);
    uint64_t random = 11;
    for (int i = 0; i < 20000; i++) {
        sn_vec3 p = random_in(sn_distance_field_box(&f), &random), g, q = sn_scale(sn_sub(p, f.origin), 1.0 / f.cell);
        double h = 1e-3 * f.cell, d[3];
        double edge = fmin(fabs(q.x - round(q.x)), fmin(fabs(q.y - round(q.y)), fabs(q.z - round(q.z))));
        if (edge < 2e-3) continue;
        sn_distance_field_at(&f, p, &g);
        for (int k = 0; k < 3; k++) {
            sn_vec3 step = sn_v3(k == 0 ? h : 0.0, k == 1 ? h : 0.0, k == 2 ? h : 0.0);
            d[k] = (sn_distance_field_at(&f, sn_add(p, step), NULL) - sn_distance_field_at(&f, sn_sub(p, step), NULL)) / (2.0 * h);
        }
        assert_true(sn_distance(g, sn_v3(d[0], d[1], d[2])) < 1e-9);
    }
    sn_distance_field_free(&f);
    sn_mesh_free(&ring);
}

/* A step of a millionth of a cell through a face between cells, bricks, or a brick and the coarse grid. */
static void expect_no_steps(const sn_mesh *mesh, double cell) {
    sn_distance_field f = field_of(mesh, cell);
    uint64_t random = 17;
    sn_index to_coarse = 0;
    for (int i = 0; i < 60000; i++) {
        sn_vec3 p = random_in(sn_distance_field_box(&f), &random), q = sn_scale(sn_sub(p, f.origin), 1.0 / (SN_BRICK_CELLS * cell));
        double h = 1e-6 * cell, *along[3] = {&p.x, &p.y, &p.z};
        const double low[3] = {f.origin.x, f.origin.y, f.origin.z}, at[3] = {q.x, q.y, q.z};
        int k = i % 3;
        double face = round(at[k]);
        if (face < 1.0 || face > f.bricks[k] - 1) continue;
        *along[k] = low[k] + face * SN_BRICK_CELLS * cell - h;
        double below = sn_distance_field_at(&f, p, NULL);
        *along[k] += 2.0 * h;
        assert_near(sn_distance_field_at(&f, p, NULL), below, 20.0 * h);
        to_coarse += fabs(below) > f.band;
    }
    assert_true(to_coarse > 1000);
    for (int i = 0; i < 60000; i++) {
        sn_vec3 a = random_in(sn_distance_field_box(&f), &random), b = random_in(sn_distance_field_box(&f), &random);
        b = sn_lerp(a, b, sn_random(&random) * sn_random(&random) * sn_random(&random));
        double rise = fabs(sn_distance_field_at(&f, a, NULL) - sn_distance_field_at(&f, b, NULL));
        assert_true(rise <= 5.0 * sn_distance(a, b) + 1e-9);
    }
    sn_distance_field_free(&f);
}

static void test_it_is_continuous(void **state) {
    (void)state;
    sn_mesh ring = torus(), cube = shape_cube(), sphere = shape_sphere(31, 64);
    sn_mesh pieces = shape_join(&sphere, &cube, 0.7, sn_v3(0.5, 0.6, 0.2));
    expect_no_steps(&ring, 0.03);
    expect_no_steps(&cube, 0.02);
    expect_no_steps(&pieces, 0.025);
    sn_mesh_free(&ring);
    sn_mesh_free(&cube);
    sn_mesh_free(&sphere);
    sn_mesh_free(&pieces);
}

/* From the centre of a ball outwards: the distance grows, and the gradient points out, through the coarse grid and the bricks. */
static void test_deep_points_know_the_way_out(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(63, 128);
    sn_distance_field f = field_of(&sphere, 0.02);
    uint64_t random = 23;
    assert_near(sn_distance_field_at(&f, sn_v3(0, 0, 0), NULL), -1.0, 0.05);
    for (int i = 0; i < 500; i++) {
        sn_vec3 d = sn_normalize(random_in((sn_box){{-1, -1, -1}, {1, 1, 1}}, &random)), g;
        double before = -INFINITY;
        for (double r = 0.15; r < 1.08; r += 0.005) {
            double phi = sn_distance_field_at(&f, sn_scale(d, r), &g);
            assert_near(phi, r - 1.0, 0.012);
            assert_true(phi > before && sn_dot(g, d) > 0.3 * sn_norm(g));
            before = phi;
        }
    }
    sn_distance_field_free(&f);
    sn_mesh_free(&sphere);
}

/* Beyond the grid: above the band, below the truth. The reject is never wrong, and not idle. */
static void test_far_points(void **state) {
    (void)state;
    sn_mesh ring = torus();
    sn_distance_field f = field_of(&ring, 0.04);
    sn_surface *surface;
    sn_index rejected = 0;
    uint64_t random = 29;
    assert_ok(sn_surface_create(&ring, &surface, NULL));
    for (int i = 0; i < 20000; i++) {
        sn_vec3 p = random_in((sn_box){{-3, -3, -3}, {3, 3, 3}}, &random), g;
        sn_box box = sn_distance_field_box(&f);
        double exact = sn_surface_signed_distance(surface, p, NULL), phi = sn_distance_field_at(&f, p, &g);
        bool outside = sn_norm2(sn_sub(p, sn_max3(box.low, sn_min3(box.high, p)))) > 0.0;
        if (outside) assert_true(phi > f.band && phi <= exact && fabs(sn_norm(g) - 1.0) < 1e-12);
        for (double d = 0.0; d < 1.0; d += 0.19) {
            bool farther = sn_distance_field_farther(&f, p, d);
            assert_false(farther && exact <= d);
            rejected += farther;
            if (exact > d + 2.0 * SN_COARSE_CELLS * f.cell && !outside) assert_true(farther);
        }
    }
    assert_true(rejected > 10000);
    assert_true(isnan(sn_distance_field_at(&f, sn_v3(NAN, 0, 0), NULL)));
    assert_false(sn_distance_field_farther(&f, sn_v3(NAN, 0, 0), 1.0));
    assert_true(sn_distance_field_at(&f, sn_v3(1e200, 0, 0), NULL) > 1e199);
    sn_surface_destroy(surface);
    sn_distance_field_free(&f);
    sn_mesh_free(&ring);
}

static void test_many_at_once(void **state) {
    (void)state;
    enum { COUNT = 500 };
    sn_mesh cube = shape_cube();
    sn_distance_field f = field_of(&cube, 0.05);
    sn_vec3 points[COUNT], gradients[COUNT], g;
    double values[COUNT];
    uint64_t random = 31;
    for (int i = 0; i < COUNT; i++) points[i] = random_in((sn_box){{-1, -1, -1}, {2, 2, 2}}, &random);
    sn_distance_field_at_all(&f, COUNT, points, values, gradients);
    for (int i = 0; i < COUNT; i++) {
        assert_true(values[i] == sn_distance_field_at(&f, points[i], &g));
        assert_memory_equal(&g, &gradients[i], sizeof g);
    }
    sn_distance_field_at_all(&f, COUNT, points, values, NULL);
    assert_true(values[0] == sn_distance_field_at(&f, points[0], NULL));
    sn_distance_field_free(&f);
    sn_mesh_free(&cube);
}

/* ---- surfaces as they are kept --------------------------------------------------------------------------------------------------------
 */

static void expect_same_values(const sn_distance_field *a, const sn_distance_field *b) {
    assert_int_equal(a->brick_count, b->brick_count);
    assert_memory_equal(a->bricks, b->bricks, sizeof a->bricks);
    size_t places = (size_t)a->bricks[0] * (size_t)a->bricks[1] * (size_t)a->bricks[2];
    size_t coarse = (size_t)(2 * a->bricks[0] + 1) * (size_t)(2 * a->bricks[1] + 1) * (size_t)(2 * a->bricks[2] + 1);
    assert_memory_equal(a->brick, b->brick, places * sizeof *a->brick);
    assert_memory_equal(a->coarse, b->coarse, coarse * sizeof *a->coarse);
    assert_memory_equal(a->values, b->values, (size_t)a->brick_count * SN_BRICK_VALUES * sizeof *a->values);
}

static void test_inside_out_and_doubled(void **state) {
    (void)state;
    sn_mesh ring = torus(), turned = torus(), doubled = shape_join(&ring, &ring, 1.0, sn_v3(0, 0, 0));
    turn(&turned);
    sn_mesh opposed = shape_join(&ring, &turned, 1.0, sn_v3(0, 0, 0));
    sn_distance_field f = field_of(&ring, 0.05);
    assert_false(f.report.inside_out);
    const sn_mesh *kinds[3] = {&turned, &doubled, &opposed};
    for (int i = 0; i < 3; i++) {
        sn_distance_field g = field_of(kinds[i], 0.05);
        expect_same_values(&f, &g);
        assert_true(g.report.inside_out == (i == 0));
        assert_int_equal(g.report.dropped_triangles, i > 0 ? ring.triangle_count : 0);
        assert_near(g.report.volume, f.report.volume, 1e-12);
        sn_distance_field_free(&g);
    }
    sn_distance_field_free(&f);
    sn_mesh_free(&ring);
    sn_mesh_free(&turned);
    sn_mesh_free(&doubled);
    sn_mesh_free(&opposed);
}

/* A second layer a hundredth of a cell within the first bounds nothing, nor does a wall across, nor what overlaps. */
static void test_layers_within_are_not_felt(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(23, 48), layers = shape_join(&sphere, &sphere, 0.9995, sn_v3(0, 0, 0));
    sn_mesh overlap = shape_join(&sphere, &sphere, 1.0, sn_v3(0.6, 0, 0));
    sn_distance_field f = field_of(&sphere, 0.08), g = field_of(&layers, 0.08), h = field_of(&overlap, 0.08);
    expect_same_values(&f, &g);
    assert_int_equal(g.report.inner_triangles, sphere.triangle_count);
    assert_true(h.report.inner_triangles > sphere.triangle_count / 4);
    /* the nearest of the boundary is the circle of radius 0.954 where the spheres meet; then the far side of the second */
    assert_near(sn_distance_field_at(&h, sn_v3(0.3, 0, 0), NULL), -0.954, 0.05);
    assert_near(sn_distance_field_at(&h, sn_v3(1.0, 0, 0), NULL), -0.6, 0.03); /* on the wall of the first */
    sn_distance_field_free(&f);
    sn_distance_field_free(&g);
    sn_distance_field_free(&h);
    sn_mesh_free(&sphere);
    sn_mesh_free(&layers);
    sn_mesh_free(&overlap);
}

/* A cavity is outside; also where all of it is inside out. Two shells that both look outwards are one solid. */
static void test_nested_spheres(void **state) {
    (void)state;
    sn_mesh outer = shape_sphere(23, 48), inner = shape_sphere(23, 48), solid = shape_join(&outer, &inner, 0.5, sn_v3(0, 0, 0));
    turn(&inner);
    sn_mesh hollow = shape_join(&outer, &inner, 0.5, sn_v3(0, 0, 0)), turned = shape_join(&outer, &inner, 0.5, sn_v3(0, 0, 0));
    turn(&turned);
    sn_distance_field f = field_of(&hollow, 0.06), g = field_of(&turned, 0.06), h = field_of(&solid, 0.06);
    assert_near(sn_distance_field_at(&f, sn_v3(0, 0, 0), NULL), 0.5, 0.04);
    assert_near(sn_distance_field_at(&f, sn_v3(0, 0.75, 0), NULL), -0.25, 0.04);
    expect_same_values(&f, &g);
    assert_true(g.report.inside_out && !f.report.inside_out && f.report.inner_triangles == 0);
    assert_near(sn_distance_field_at(&h, sn_v3(0, 0, 0), NULL), -1.0, 0.05);
    assert_near(sn_distance_field_at(&h, sn_v3(0, 0, 0.5), NULL), -0.5, 0.03);
    assert_int_equal(h.report.inner_triangles, inner.triangle_count);
    sn_distance_field_free(&f);
    sn_distance_field_free(&g);
    sn_distance_field_free(&h);
    sn_mesh_free(&outer);
    sn_mesh_free(&inner);
    sn_mesh_free(&solid);
    sn_mesh_free(&hollow);
    sn_mesh_free(&turned);
}

/* A half sphere, either way around, is closed by its disc; one with a long border by a cone to its middle. */
static void test_open_cup(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        bool turned = kind == 1;
        sn_index columns = kind == 2 ? 208 : 64;
        sn_mesh cup = shape_sphere(31, columns);
        bool *keep = calloc((size_t)cup.triangle_count, sizeof *keep);
        for (sn_index t = 0; t < cup.triangle_count; t++) {
            const sn_index *v = cup.triangles[t].v;
            keep[t] = cup.positions[v[0]].z + cup.positions[v[1]].z + cup.positions[v[2]].z < -1e-9;
        }
        sn_mesh_keep_triangles(&cup, keep);
        free(keep);
        if (turned) turn(&cup);
        sn_distance_field f = field_of(&cup, 0.04);
        assert_int_equal(f.report.caps, 1);
        assert_int_equal(f.report.cap_triangles, kind == 2 ? columns : columns - 2);
        assert_true(f.report.inside_out == turned);
        assert_near(f.report.volume, 2.0 / 3.0 * SN_PI, 0.02);
        uint64_t random = 37;
        for (int i = 0; i < 5000; i++) {
            sn_vec3 p = random_in(f.box, &random);
            double exact = p.z > 0.0 ? p.z : fmax(sn_norm(p) - 1.0, p.z);
            if (fabs(exact) > 0.02 && sn_norm(p) < 1.1) assert_true((sn_distance_field_at(&f, p, NULL) < 0.0) == (exact < 0.0));
        }
        sn_distance_field_free(&f);
        sn_mesh_free(&cup);
    }
}

/* The disc cut into the shape of a horseshoe: the cap of least area does not bridge its mouth, as a cone would. */
static void test_cap_follows_a_bent_border(void **state) {
    (void)state;
    sn_mesh ring = torus();
    bool *keep = calloc((size_t)ring.triangle_count, sizeof *keep);
    for (sn_index t = 0; t < ring.triangle_count; t++) keep[t] = ring.positions[ring.triangles[t].v[0]].z < 0.0 || t / 2 / AROUND < 24;
    sn_mesh_keep_triangles(&ring, keep);
    free(keep);
    sn_distance_field f = field_of(&ring, 0.04);
    assert_int_equal(f.report.caps, 1);
    assert_true(sn_distance_field_at(&f, sn_v3(0, 0, 0), NULL) > 0.5);
    assert_true(sn_distance_field_at(&f, sn_v3(-1, 0, -0.1), NULL) < -0.05); /* in the open half, below its cap */
    assert_true(sn_distance_field_at(&f, sn_v3(-1, 0, 0.3), NULL) > 0.1);    /* where the tube is missing */
    sn_distance_field_free(&f);
    sn_mesh_free(&ring);
}

/* Nine rings in one mesh, every third inside out: each is solid, the gaps between them are not. */
static void test_many_pieces(void **state) {
    (void)state;
    enum { PIECES = 9 };
    sn_mesh ring = torus(), turned = torus(), all = torus();
    turn(&turned);
    for (int i = 1; i < PIECES; i++) {
        sn_mesh more = shape_join(&all, i % 3 == 0 ? &turned : &ring, 1.0 + 0.02 * i, sn_v3(0, 0.05 * i, 0.9 * i));
        sn_mesh_free(&all);
        all = more;
    }
    sn_distance_field f = field_of(&all, 0.08);
    assert_int_equal(f.report.turned, 2);
    assert_false(f.report.inside_out);
    uint64_t random = 41;
    for (int i = 0; i < 20000; i++) {
        sn_vec3 p = random_in(f.box, &random);
        double exact = INFINITY;
        for (int k = 0; k < PIECES; k++) {
            double scale = 1.0 + 0.02 * k;
            exact = fmin(exact, scale * torus_distance(sn_scale(sn_sub(p, sn_v3(0, 0.05 * k, 0.9 * k)), 1.0 / scale)));
        }
        double phi = sn_distance_field_at(&f, p, NULL);
        if (fabs(exact) > 0.02) assert_true((phi < 0.0) == (exact < 0.0));
        if (fabs(exact) < 0.24) assert_near(phi, exact, 0.04);
    }
    sn_distance_field_free(&f);
    sn_mesh_free(&ring);
    sn_mesh_free(&turned);
    sn_mesh_free(&all);
}

/* A triangle wound the wrong way among right ones, and one that is missing. */
static void test_badly_wound(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(31, 64), worse = shape_sphere(31, 64);
    sn_distance_field f = field_of(&sphere, 0.05);
    for (sn_index t = 100; t < 200; t += 10) shape_flip(&worse, t);
    shape_drop(&worse, 400);
    sn_distance_field g = field_of(&worse, 0.05);
    assert_true(g.report.caps > 0);
    uint64_t random = 43;
    for (int i = 0; i < 5000; i++) {
        sn_vec3 p = random_in(f.box, &random);
        assert_near(sn_distance_field_at(&f, p, NULL), sn_distance_field_at(&g, p, NULL), 0.005);
    }
    sn_distance_field_free(&f);
    sn_distance_field_free(&g);
    sn_mesh_free(&sphere);
    sn_mesh_free(&worse);
}

/* One triangle, and a folded sheet, enclose nothing: the distance is never negative. */
static void test_a_sheet_has_no_inside(void **state) {
    (void)state;
    const sn_vec3 corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.2}};
    const sn_triangle triangle[1] = {{{0, 1, 2}}};
    sn_mesh sheet = shape_of(3, corners, 1, triangle);
    sn_distance_field f = field_of(&sheet, 0.05);
    uint64_t random = 47;
    for (int i = 0; i < 5000; i++) {
        sn_vec3 p = random_in(sn_distance_field_box(&f), &random);
        double exact = sn_distance(p, sn_closest_on_triangle(p, corners[0], corners[1], corners[2], NULL)),
               phi = sn_distance_field_at(&f, p, NULL);
        assert_true(phi >= 0.0);
        if (exact < 0.15) assert_near(phi, exact, 0.03);
    }
    assert_near(f.report.volume, 0.0, 1e-15);
    sn_distance_field_free(&f);
    sn_mesh_free(&sheet);
}

/* One-sided: there is no telling inside from outside, but a distance there is. */
static void test_a_strip_of_one_side(void **state) {
    (void)state;
    sn_mesh strip = shape_moebius(40);
    sn_distance_field f = field_of(&strip, 0.1);
    for (sn_index t = 0; t < strip.triangle_count; t++) {
        const sn_index *v = strip.triangles[t].v;
        sn_vec3 sum = sn_add(strip.positions[v[0]], sn_add(strip.positions[v[1]], strip.positions[v[2]]));
        assert_near(sn_distance_field_at(&f, sn_scale(sum, 1.0 / 3.0), NULL), 0.0, 0.06);
    }
    sn_distance_field_free(&f);
    sn_mesh_free(&strip);
}

/* ---- what cannot be ------------------------------------------------------------------------------------------------------------------ */

static void expect_refused(const sn_mesh *mesh, double cell, double band, sn_status status, const char *word) {
    sn_distance_field_params params = {.cell = cell, .band = band};
    sn_distance_field f;
    sn_error error = {0};
    assert_int_equal(sn_distance_field_create(mesh, &params, &f, &error), status);
    if (strstr(error.text, word) == NULL) fail_msg("'%s' does not say '%s'", error.text, word);
    assert_null(f.values);
    assert_null(f.brick);
}

static void test_refusals(void **state) {
    (void)state;
    sn_mesh cube = shape_cube(), empty = {0}, flat = shape_cube(), holed = shape_cube(), far = shape_cube();
    for (sn_index v = 0; v < flat.vertex_count; v++) flat.positions[v] = sn_v3(flat.positions[v].x, 0, 0);
    for (sn_index v = 0; v < far.vertex_count; v++) far.positions[v].x += 1e9;
    holed.positions[3].y = NAN;
    expect_refused(&empty, 0.1, 3.0, SN_ERROR_INPUT, "");
    expect_refused(&flat, 0.1, 3.0, SN_ERROR_INPUT, "area");
    expect_refused(&holed, 0.1, 3.0, SN_ERROR_INPUT, "");
    const double cells[] = {0.0, -1.0, NAN, INFINITY, 1e12};
    for (int i = 0; i < 5; i++) expect_refused(&cube, cells[i], 3.0, SN_ERROR_USAGE, "cell");
    const double bands[] = {0.0, 0.9, 17.0, NAN};
    for (int i = 0; i < 4; i++) expect_refused(&cube, 0.1, bands[i], SN_ERROR_USAGE, "band");
    expect_refused(&cube, 1e-5, 3.0, SN_ERROR_USAGE, "fits");
    expect_refused(&cube, 1e-8, 3.0, SN_ERROR_USAGE, "fits");
    expect_refused(&cube, 1e-300, 3.0, SN_ERROR_USAGE, "told apart");
    expect_refused(&far, 0.05, 3.0, SN_ERROR_USAGE, "origin");
    sn_mesh_free(&cube);
    sn_mesh_free(&flat);
    sn_mesh_free(&holed);
    sn_mesh_free(&far);
}

/* Cells much larger than the surface: a brick in all. */
static void test_large_cells(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    sn_distance_field f = field_of(&cube, 10.0);
    assert_int_equal(f.bricks[0] * f.bricks[1] * f.bricks[2], 8 * (f.bricks[0] > 1) + (f.bricks[0] == 1));
    assert_true(sn_distance_field_at(&f, sn_v3(30, 0.5, 0.5), NULL) > 20.0);
    sn_distance_field_free(&f);
    sn_mesh_free(&cube);
}

static void test_memory_goes_with_the_area(void **state) {
    (void)state;
    sn_mesh sphere = shape_sphere(31, 64);
    sn_distance_field coarse = field_of(&sphere, 0.04), fine = field_of(&sphere, 0.02);
    double ratio = (double)fine.brick_count / coarse.brick_count;
    assert_true(ratio > 3.3 && ratio < 4.6); /* 8 if it went with the volume */
    assert_true(3 * fine.brick_count < 2 * fine.bricks[0] * fine.bricks[1] * fine.bricks[2]);
    assert_true(sn_distance_field_bytes(&fine) > (size_t)fine.brick_count * SN_BRICK_VALUES * sizeof(float));
    sn_distance_field_free(&coarse);
    sn_distance_field_free(&fine);
    sn_mesh_free(&sphere);
}

static void test_threads_give_the_same_bits(void **state) {
    (void)state;
    sn_mesh ring = torus(), cube = shape_cube(), both = shape_join(&ring, &cube, 1.0, sn_v3(0.5, 0, 0));
    sn_distance_field first = field_of(&both, 0.06);
    for (int threads = 2; threads <= 4; threads += 2) {
        sn_distance_field_params params = sn_distance_field_defaults(0.06);
        sn_distance_field f;
        params.pool = sn_pool_create(threads);
        assert_ok(sn_distance_field_create(&both, &params, &f, NULL));
        expect_same_values(&first, &f);
        assert_memory_equal(&first.report, &f.report, sizeof f.report);
        sn_distance_field_free(&f);
        sn_pool_destroy(params.pool);
    }
    sn_distance_field_free(&first);
    sn_mesh_free(&ring);
    sn_mesh_free(&cube);
    sn_mesh_free(&both);
}

/* ---- files ----------------------------------------------------------------------------------------------------------------------------
 */

static sn_blob saved(const sn_distance_field *f, const char *hash) {
    sn_output *output;
    sn_blob blob;
    assert_ok(sn_output_open_memory(&output, NULL));
    assert_ok(sn_distance_field_save(f, hash, output, NULL));
    assert_ok(sn_output_take(output, "x.field", &blob, NULL));
    return blob;
}

static void expect_unreadable(const sn_blob *blob, const char *hash) {
    sn_distance_field f;
    sn_error error = {0};
    assert_int_equal(sn_distance_field_load(blob, hash, &f, &error), SN_ERROR_INPUT);
    assert_true(error.text[0] != '\0' && strcmp(error.file, blob->name) == 0);
    assert_null(f.values);
}

enum { CHECKSUM_AT = 16 + SN_HASH_LENGTH, HEAD_AT = CHECKSUM_AT + SN_HASH_LENGTH, COUNTS_AT = HEAD_AT + 96, TABLES_AT = COUNTS_AT + 48 };

/* Another word at `at`, under a right checksum. */
static void expect_forged_refused(const sn_blob *blob, const char *hash, size_t at, const void *word, size_t size) {
    sn_blob forged = {.name = blob->name, .data = malloc(blob->size + 1), .size = blob->size};
    memcpy(forged.data, blob->data, blob->size);
    memcpy(forged.data + at, word, size);
    sn_hash(forged.data + HEAD_AT, forged.size - HEAD_AT, forged.data + CHECKSUM_AT);
    expect_unreadable(&forged, hash);
    free(forged.data);
}

static void test_files(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    sn_distance_field_params params = sn_distance_field_defaults(0.3);
    sn_distance_field f = field_of(&cube, 0.3), again;
    char hash[SN_HASH_LENGTH], other[SN_HASH_LENGTH];
    assert_ok(sn_distance_field_hash(&cube, &params, hash, NULL));
    sn_blob blob = saved(&f, hash);
    assert_ok(sn_distance_field_load(&blob, hash, &again, NULL));
    expect_same_values(&f, &again);
    assert_memory_equal(&f.report, &again.report, sizeof f.report);
    assert_true(f.cell == again.cell && f.band == again.band);
    assert_memory_equal(&f.origin, &again.origin, sizeof f.origin);
    assert_memory_equal(&f.box, &again.box, sizeof f.box);
    sn_distance_field_free(&again);
    params.cell = 0.31;
    assert_ok(sn_distance_field_hash(&cube, &params, other, NULL));
    assert_string_not_equal(hash, other);
    expect_unreadable(&blob, other);
    cube.positions[0].x = -1e-9;
    params.cell = 0.3;
    assert_ok(sn_distance_field_hash(&cube, &params, other, NULL));
    assert_string_not_equal(hash, other);

    size_t whole = blob.size, step = whole / 500 + 1;
    for (blob.size = 0; blob.size < whole; blob.size += blob.size < 400 ? 1 : step) expect_unreadable(&blob, hash);
    blob.size = whole;
    for (size_t at = 0; at < whole; at += at < 400 ? 1 : step) {
        if (at == 16 + SN_HASH_LENGTH - 1 || at == HEAD_AT - 1) continue; /* the ends of the texts: looked at as ends */
        blob.data[at] = (char)(blob.data[at] ^ 4);
        expect_unreadable(&blob, hash);
        blob.data[at] = (char)(blob.data[at] ^ 4);
    }
    sn_blob_free(&blob);
    sn_distance_field_free(&f);
    sn_mesh_free(&cube);
}

static void test_forged_files(void **state) {
    (void)state;
    sn_mesh cube = shape_cube();
    sn_distance_field f = field_of(&cube, 0.1);
    const char *hash = "sha256:0";
    sn_blob blob = saved(&f, hash);
    const float bad[] = {NAN, INFINITY, 1e30f};
    const double bad_real[] = {NAN, INFINITY, 0.0, -1.0, 1e300};
    const sn_index bad_count[] = {-1, 0, 1 << 30, 0x7fffffff, f.bricks[0] + 1};
    size_t places = (size_t)f.bricks[0] * (size_t)f.bricks[1] * (size_t)f.bricks[2];
    for (int i = 0; i < 3; i++) expect_forged_refused(&blob, hash, blob.size - 4, &bad[i], 4);
    for (int i = 0; i < 3; i++) expect_forged_refused(&blob, hash, TABLES_AT + 4 * places, &bad[i], 4);
    for (int i = 0; i < 5; i++) expect_forged_refused(&blob, hash, HEAD_AT, &bad_real[i], 8);      /* cell */
    for (int i = 0; i < 5; i++) expect_forged_refused(&blob, hash, HEAD_AT + 8, &bad_real[i], 8);  /* band */
    for (int i = 0; i < 2; i++) expect_forged_refused(&blob, hash, HEAD_AT + 16, &bad_real[i], 8); /* origin */
    for (int i = 0; i < 5; i++) expect_forged_refused(&blob, hash, COUNTS_AT, &bad_count[i], 4);
    for (int i = 0; i < 4; i++) expect_forged_refused(&blob, hash, COUNTS_AT + 12, &bad_count[i], 4);
    sn_index first = 0;
    while (f.brick[first] == SN_NONE) first++;
    const sn_index bad_brick[] = {1, SN_NONE, 0x7fffffff, -2};
    for (int i = 0; i < 4; i++) expect_forged_refused(&blob, hash, TABLES_AT + 4 * (size_t)first, &bad_brick[i], 4);
    sn_blob_free(&blob);
    sn_distance_field_free(&f);
    sn_mesh_free(&cube);
}

static int warnings;
static void count_warning(void *user, sn_log_level level, const char *text) {
    (void)user;
    (void)text;
    warnings += level == SN_LOG_WARNING;
}

static void write_over(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_true(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void expect_cached(const char *folder, const sn_mesh *mesh, bool read, int warned) {
    sn_distance_field_params params = sn_distance_field_defaults(0.1);
    sn_distance_field f, fresh = field_of(mesh, 0.1);
    bool was_read;
    warnings = 0;
    assert_ok(sn_distance_field_cached(folder, mesh, &params, &f, &was_read, NULL));
    expect_same_values(&fresh, &f);
    assert_true(was_read == read);
    assert_int_equal(warnings, warned);
    sn_distance_field_free(&f);
    sn_distance_field_free(&fresh);
}

static void test_cache(void **state) {
    (void)state;
    char base[] = "/tmp/test_field_XXXXXX", folder[64], path[256], hash[SN_HASH_LENGTH];
    sn_mesh cube = shape_cube();
    sn_distance_field_params params = sn_distance_field_defaults(0.1);
    assert_non_null(mkdtemp(base));
    snprintf(folder, sizeof folder, "%s/fields", base);
    assert_ok(sn_distance_field_hash(&cube, &params, hash, NULL));
    snprintf(path, sizeof path, "%s/%s.field", folder, hash + strlen("sha256:"));
    sn_log_set(count_warning, NULL);
    expect_cached(NULL, &cube, false, 0);
    expect_cached(folder, &cube, false, 0);
    expect_cached(folder, &cube, true, 0);
    write_over(path, "SINEWDISTANCE01\nthis is not one");
    expect_cached(folder, &cube, false, 1);
    expect_cached(folder, &cube, true, 0);
    assert_int_equal(truncate(path, 1000), 0);
    expect_cached(folder, &cube, false, 1);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
    write_over(folder, "in the way");
    expect_cached(folder, &cube, false, 1); /* it cannot be kept */
    sn_log_set(NULL, NULL);
    unlink(folder);
    rmdir(base);
    sn_mesh_free(&cube);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_analytic_shapes),
        cmocka_unit_test(test_error_falls_with_the_square_of_the_cell),
        cmocka_unit_test(test_gradient_is_that_of_the_interpolant),
        cmocka_unit_test(test_it_is_continuous),
        cmocka_unit_test(test_deep_points_know_the_way_out),
        cmocka_unit_test(test_far_points),
        cmocka_unit_test(test_many_at_once),
        cmocka_unit_test(test_inside_out_and_doubled),
        cmocka_unit_test(test_layers_within_are_not_felt),
        cmocka_unit_test(test_nested_spheres),
        cmocka_unit_test(test_open_cup),
        cmocka_unit_test(test_cap_follows_a_bent_border),
        cmocka_unit_test(test_many_pieces),
        cmocka_unit_test(test_badly_wound),
        cmocka_unit_test(test_a_sheet_has_no_inside),
        cmocka_unit_test(test_a_strip_of_one_side),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_large_cells),
        cmocka_unit_test(test_memory_goes_with_the_area),
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_forged_files),
        cmocka_unit_test(test_cache),
    };
    return cmocka_run_group_tests_name("distance_field", tests, NULL, NULL);
}
