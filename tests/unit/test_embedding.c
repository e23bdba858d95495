/* test_embedding.c -- mean value coordinates: exact on affine maps, also next to edges and vertices; the same for any threads. */
#include "shapes.h"

#include <stdio.h>
#include <unistd.h>

#include "sinew/io.h"

/* A sphere drawn out to an ellipsoid with a dent: about 2 across. */
static sn_mesh bean(sn_index rows) {
    sn_mesh mesh = shape_sphere(rows, 2 * rows);
    for (sn_index v = 0; v < mesh.vertex_count; v++) {
        sn_vec3 p = mesh.positions[v];
        mesh.positions[v] = sn_v3(0.5 * p.x + 0.3 * p.z * p.z, 0.6 * p.y, p.z);
    }
    return mesh;
}

/* Points well inside the bean: on the way from its axis to the surface. */
static void inner_points(const sn_mesh *mesh, sn_index count, sn_vec3 *points) {
    uint64_t state = 7;
    for (sn_index i = 0; i < count; i++) {
        sn_vec3 p = mesh->positions[(sn_index)(sn_random(&state) * mesh->vertex_count)];
        points[i] = sn_lerp(sn_v3(0.3 * p.z * p.z, 0.0, p.z), p, 0.9 * sn_random(&state));
    }
}

static sn_vec3 affine(sn_vec3 p) {
    return sn_v3(1.3 * p.x - 0.4 * p.y + 0.2 * p.z + 3.0, 0.5 * p.x + 0.8 * p.y - 1.0, -0.3 * p.x + 0.1 * p.y + 2.0 * p.z + 0.5);
}

/* Largest distance of a point that followed the surface through the affine map from where the map itself puts it. */
static double affine_error(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding *embedding) {
    sn_vec3 *moved = calloc((size_t)mesh->vertex_count, sizeof *moved), *out = calloc((size_t)count, sizeof *out);
    double worst = 0.0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) moved[v] = affine(mesh->positions[v]);
    sn_embedding_apply(embedding, moved, NULL, out);
    for (sn_index i = 0; i < count; i++) worst = fmax(worst, sn_distance(out[i], affine(points[i])));
    free(moved);
    free(out);
    return worst;
}

static void test_affine_maps_are_followed(void **state) {
    (void)state;
    enum { COUNT = 64 };
    sn_mesh mesh = bean(24);
    sn_vec3 points[COUNT];
    inner_points(&mesh, COUNT, points);
    const double cuts[2] = {0.0, 3e-4};
    for (int k = 0; k < 2; k++) {
        sn_embedding_params params = sn_embedding_defaults();
        params.cut = cuts[k];
        sn_embedding embedding;
        assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding, NULL));
        assert_true(embedding.report.error < 1e-13);
        assert_true(affine_error(&mesh, COUNT, points, &embedding) < 1e-12);
        assert_true((embedding.report.dropped_worst > 0.0) == (cuts[k] > 0.0));
        sn_embedding_free(&embedding);
    }
    sn_mesh_free(&mesh);
}

/* Before any correction the formulas themselves reproduce the point: they are mean value coordinates, not merely corrected noise. */
static void test_formulas_have_linear_precision(void **state) {
    (void)state;
    enum { COUNT = 64 };
    sn_mesh mesh = bean(24);
    sn_vec3 points[COUNT];
    inner_points(&mesh, COUNT, points);
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding;
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding, NULL));
    assert_true(embedding.report.correction < 1e-10);
    sn_embedding_free(&embedding);
    sn_mesh_free(&mesh);
}

/* At the centre of a regular octahedron all six weights are equal. */
static void test_octahedron(void **state) {
    (void)state;
    const sn_vec3 corners[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const sn_triangle sides[8] = {{{0, 2, 4}}, {{2, 1, 4}}, {{1, 3, 4}}, {{3, 0, 4}}, {{2, 0, 5}}, {{1, 2, 5}}, {{3, 1, 5}}, {{0, 3, 5}}};
    sn_mesh mesh = shape_of(6, corners, 8, sides);
    const sn_vec3 centre = {0, 0, 0};
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding;
    assert_ok(sn_embedding_build(&mesh, 1, &centre, &params, &embedding, NULL));
    for (int k = 0; k < 6; k++) assert_near(embedding.rows[0].weights[k], 1.0 / 6.0, 1e-14);
    sn_embedding_free(&embedding);
    sn_mesh_free(&mesh);
}

/* On vertices, edges and faces, and from 1e-12 to 1e-3 beside them: the places where the plain formulas are wrong by the size itself. */
static void test_points_on_and_beside_the_surface(void **state) {
    (void)state;
    enum { PLACES = 3, OFFSETS = 8, TRIANGLES = 40, COUNT = PLACES * OFFSETS * TRIANGLES };
    const double offsets[OFFSETS] = {0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3};
    sn_mesh mesh = bean(16);
    sn_vec3 *points = malloc(COUNT * sizeof *points);
    sn_index n = 0;
    for (sn_index t = 0; t < TRIANGLES; t++) {
        const sn_index *v = mesh.triangles[t * 7].v;
        sn_vec3 a = mesh.positions[v[0]], b = mesh.positions[v[1]], c = mesh.positions[v[2]];
        sn_vec3 places[PLACES] = {a, sn_lerp(a, b, 0.37), sn_scale(sn_add(a, sn_add(b, c)), 1.0 / 3.0)};
        for (int k = 0; k < PLACES; k++)
            for (int o = 0; o < OFFSETS; o++) points[n++] = sn_lerp(places[k], sn_v3(0.1, 0.0, 0.0), offsets[o]);
    }
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding;
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding, NULL));
    assert_true(embedding.report.near_points >= COUNT / 2);
    assert_true(embedding.report.near_points < COUNT);
    assert_true(affine_error(&mesh, COUNT, points, &embedding) < 1e-9 * sn_box_diagonal(sn_mesh_box(&mesh)));
    sn_embedding_free(&embedding);
    free(points);
    sn_mesh_free(&mesh);
}

/* No weight may be large: a moved vertex must not throw the point about. */
static void test_weights_stay_moderate(void **state) {
    (void)state;
    enum { COUNT = 200 };
    sn_mesh mesh = bean(16);
    sn_vec3 points[COUNT];
    uint64_t random = 11;
    for (sn_index i = 0; i < COUNT; i++) {
        const sn_index *v = mesh.triangles[(sn_index)(sn_random(&random) * mesh.triangle_count)].v;
        sn_vec3 on = sn_lerp(mesh.positions[v[0]], mesh.positions[v[1]], sn_random(&random));
        points[i] = sn_lerp(on, sn_v3(0.1, 0.0, 0.0), pow(10.0, -12.0 * sn_random(&random)));
    }
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding;
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding, NULL));
    for (sn_index i = 0; i < COUNT; i++) {
        double size = 0.0;
        for (sn_index k = 0; k < embedding.rows[i].count; k++) size += fabs(embedding.rows[i].weights[k]);
        assert_true(size < 3.0);
    }
    sn_embedding_free(&embedding);
    sn_mesh_free(&mesh);
}

/* The row with its weights below the cut dropped and the rest made to sum to 1 again, as one would do without moments. */
static sn_vec3 plainly_cut(const sn_embedding_row *row, double cut, const sn_vec3 *positions) {
    sn_vec3 sum = {0, 0, 0};
    double weight = 0.0;
    for (sn_index k = 0; k < row->count; k++) {
        if (fabs(row->weights[k]) < cut) continue;
        sum = sn_add_scaled(sum, positions[k], row->weights[k]);
        weight += row->weights[k];
    }
    return sn_scale(sum, 1.0 / weight);
}

/* As slim as a muscle: 6 long, 0.6 and 1.2 across. */
static sn_vec3 slim(sn_vec3 p) { return sn_v3(0.5 * p.x, p.y, 3.0 * p.z); }

/* Bent by 60 degrees over its length, the cut moves points by 0.1 % of the size on average against all weights, and by far less than
 * plain renormalising does. */
static void test_cut_in_bending(void **state) {
    (void)state;
    enum { COUNT = 60 };
    sn_mesh mesh = bean(60);
    sn_vec3 points[COUNT], all[COUNT], few[COUNT], *bent = calloc((size_t)mesh.vertex_count, sizeof *bent);
    inner_points(&mesh, COUNT, points);
    for (sn_index i = 0; i < COUNT; i++) points[i] = slim(points[i]);
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v] = slim(mesh.positions[v]);
    for (sn_index v = 0; v < mesh.vertex_count; v++) {
        sn_vec3 p = mesh.positions[v];
        double turn = SN_PI / 3.0 / 6.0 * p.z;
        bent[v] = sn_v3(p.x * cos(turn) + p.z * sin(turn), p.y, p.z * cos(turn) - p.x * sin(turn));
    }
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding dense, cut;
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &dense, NULL));
    params.cut = 1e-4;
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &cut, NULL));
    assert_true(cut.report.weights < (int64_t)COUNT * mesh.vertex_count * 2 / 3);
    sn_embedding_apply(&dense, bent, NULL, all);
    sn_embedding_apply(&cut, bent, NULL, few);
    double sum = 0.0, plain = 0.0;
    for (int i = 0; i < COUNT; i++) {
        sum += sn_distance(all[i], few[i]);
        plain += sn_distance(all[i], plainly_cut(&dense.rows[i], params.cut, bent));
    }
    print_message("mean error of the cut %.3g of the size, of plain renormalising %.3g\n",
                  sum / COUNT / sn_box_diagonal(sn_mesh_box(&mesh)), plain / COUNT / sn_box_diagonal(sn_mesh_box(&mesh)));
    assert_true(sum / COUNT < 1e-3 * sn_box_diagonal(sn_mesh_box(&mesh)));
    assert_true(sum < 0.5 * plain);
    sn_embedding_free(&dense);
    sn_embedding_free(&cut);
    free(bent);
    sn_mesh_free(&mesh);
}

static void test_threads_give_the_same_bits(void **state) {
    (void)state;
    enum { COUNT = 50 };
    sn_mesh mesh = bean(16);
    sn_vec3 points[COUNT], moved[2][COUNT];
    inner_points(&mesh, COUNT, points);
    sn_embedding embedding[2];
    for (int k = 0; k < 2; k++) {
        sn_embedding_params params = sn_embedding_defaults();
        params.pool = k == 0 ? NULL : sn_pool_create(3);
        assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding[k], NULL));
        sn_embedding_apply(&embedding[k], mesh.positions, params.pool, moved[k]);
        sn_pool_destroy(params.pool);
    }
    assert_memory_equal(moved[0], moved[1], sizeof moved[0]);
    for (int i = 0; i < COUNT; i++) {
        assert_int_equal(embedding[0].rows[i].count, embedding[1].rows[i].count);
        size_t bytes = (size_t)embedding[0].rows[i].count * sizeof(double);
        assert_memory_equal(embedding[0].rows[i].weights, embedding[1].rows[i].weights, bytes);
    }
    sn_embedding_free(&embedding[0]);
    sn_embedding_free(&embedding[1]);
    sn_mesh_free(&mesh);
}

/* Rows of all vertices and rows with a list, side by side in any order, of any length: the plain sum to rounding, on any threads. */
static void test_apply_is_the_weighted_sum(void **state) {
    (void)state;
    enum { MOST = 37, POINTS = 21 };
    uint64_t random = 3;
    sn_pool *pool = sn_pool_create(2);
    for (sn_index n = 1; n <= MOST; n++) {
        sn_vec3 positions[MOST], out[2][POINTS];
        sn_index list[MOST];
        sn_embedding_row rows[POINTS];
        sn_embedding embedding = {.point_count = POINTS, .vertex_count = n, .rows = rows};
        for (sn_index v = 0; v < n; v++) positions[v] = sn_v3(sn_random(&random), sn_random(&random), sn_random(&random));
        for (sn_index v = 0; v < n; v++) list[v] = n - 1 - v;
        for (sn_index i = 0; i < POINTS; i++) {
            rows[i] = (sn_embedding_row){.count = n, .vertices = i % 5 == 1 ? list : NULL, .weights = calloc((size_t)n, sizeof(double))};
            for (sn_index k = 0; k < n; k++) rows[i].weights[k] = sn_random(&random) - 0.3;
        }
        sn_embedding_apply(&embedding, positions, NULL, out[0]);
        sn_embedding_apply(&embedding, positions, pool, out[1]);
        assert_memory_equal(out[0], out[1], sizeof out[0]);
        for (sn_index i = 0; i < POINTS; i++) {
            sn_vec3 sum = {0, 0, 0};
            for (sn_index k = 0; k < n; k++) sum = sn_add_scaled(sum, positions[rows[i].vertices ? list[k] : k], rows[i].weights[k]);
            assert_true(sn_distance(sum, out[0][i]) < 1e-14 * n);
            free(rows[i].weights);
        }
    }
    sn_pool_destroy(pool);
}

static void test_bad_input(void **state) {
    (void)state;
    sn_mesh mesh = bean(6);
    sn_vec3 point = {NAN, 0, 0};
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding;
    assert_int_equal(sn_embedding_build(&mesh, 1, &point, &params, &embedding, NULL), SN_ERROR_INPUT);
    point = sn_v3(0.1, 0, 0);
    params.cut = 0.5;
    assert_int_equal(sn_embedding_build(&mesh, 1, &point, &params, &embedding, NULL), SN_ERROR_USAGE);
    params.cut = 0.0;
    for (sn_index v = 0; v < mesh.vertex_count; v++) mesh.positions[v].z = 0.0;
    assert_int_equal(sn_embedding_build(&mesh, 1, &point, &params, &embedding, NULL), SN_ERROR_INPUT);
    sn_mesh_free(&mesh);
}

static void test_hash_names_what_matters(void **state) {
    (void)state;
    sn_mesh mesh = bean(6);
    sn_vec3 point = {0.1, 0, 0};
    sn_embedding_params params = sn_embedding_defaults();
    char first[SN_HASH_LENGTH], second[SN_HASH_LENGTH];
    assert_ok(sn_embedding_hash(&mesh, 1, &point, &params, first, NULL));
    assert_ok(sn_embedding_hash(&mesh, 1, &point, &params, second, NULL));
    assert_string_equal(first, second);
    params.cut = 1e-4;
    assert_ok(sn_embedding_hash(&mesh, 1, &point, &params, second, NULL));
    assert_string_not_equal(first, second);
    params.cut = 0.0;
    mesh.positions[3].x += 1e-9;
    assert_ok(sn_embedding_hash(&mesh, 1, &point, &params, second, NULL));
    assert_string_not_equal(first, second);
    sn_mesh_free(&mesh);
}

/* Kept and read again the weights are the same bits; for another hash, and cut short at any byte, they are refused. */
static void test_file(void **state) {
    (void)state;
    enum { COUNT = 3 };
    sn_mesh mesh = bean(6);
    sn_vec3 points[COUNT];
    inner_points(&mesh, COUNT - 1, points);
    points[COUNT - 1] = mesh.positions[5];
    sn_embedding_params params = sn_embedding_defaults();
    sn_embedding embedding, again;
    char path[] = "/tmp/test_embedding_XXXXXX", hash[SN_HASH_LENGTH];
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    assert_ok(sn_embedding_build(&mesh, COUNT, points, &params, &embedding, NULL));
    assert_ok(sn_embedding_hash(&mesh, COUNT, points, &params, hash, NULL));
    sn_output *output;
    assert_ok(sn_output_open(path, false, &output, NULL));
    assert_ok(sn_embedding_save(&embedding, hash, output, NULL));
    assert_ok(sn_output_commit(output, NULL));
    sn_blob blob;
    assert_ok(sn_blob_read(path, &blob, NULL));
    assert_ok(sn_embedding_load(&blob, hash, &again, NULL));
    for (int i = 0; i < COUNT; i++)
        assert_memory_equal(again.rows[i].weights, embedding.rows[i].weights, (size_t)embedding.rows[i].count * sizeof(double));
    assert_null(again.rows[0].vertices);
    assert_memory_equal(again.rows[COUNT - 1].vertices, embedding.rows[COUNT - 1].vertices, 7 * sizeof(sn_index));
    sn_embedding_free(&again);
    assert_int_equal(sn_embedding_load(&blob, "sha256:0", &again, NULL), SN_ERROR_INPUT);
    size_t whole = blob.size;
    for (blob.size = 0; blob.size < whole; blob.size++) assert_int_equal(sn_embedding_load(&blob, hash, &again, NULL), SN_ERROR_INPUT);
    sn_blob_free(&blob);
    unlink(path);
    sn_embedding_free(&embedding);
    sn_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_affine_maps_are_followed),
        cmocka_unit_test(test_formulas_have_linear_precision),
        cmocka_unit_test(test_octahedron),
        cmocka_unit_test(test_points_on_and_beside_the_surface),
        cmocka_unit_test(test_weights_stay_moderate),
        cmocka_unit_test(test_cut_in_bending),
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_apply_is_the_weighted_sum),
        cmocka_unit_test(test_bad_input),
        cmocka_unit_test(test_file),
        cmocka_unit_test(test_hash_names_what_matters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
