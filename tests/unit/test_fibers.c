/* test_fibers.c -- volume fibres in motion: lengths against analytic ones, the skinning blend, points in bones, tables, line frames. */
#include "shapes.h"
#include "sim_scene.h"

#include <stdio.h>
#include <unistd.h>

#include "sinew/fibers.h"
#include "sinew/io.h"
#include "sinew/rig.h"

/* ---- a muscle as slim as a tibialis anterior, with straight fibres --------------------------------------------------------------- */

enum { RINGS = 120, SECTORS = 24, FIBERS = 9, SEGMENTS = 15 };
static const double LENGTH = 0.25, RADIUS = 0.012;

/* A closed tube around the z axis. */
static sn_mesh tube(void) {
    sn_mesh mesh = shape_empty(RINGS * SECTORS + 2, 2 * RINGS * SECTORS);
    sn_index bottom = RINGS * SECTORS, top = bottom + 1;
    sn_triangle *t = mesh.triangles;
    mesh.positions[bottom] = sn_v3(0, 0, 0);
    mesh.positions[top] = sn_v3(0, 0, LENGTH);
    for (sn_index r = 0; r < RINGS; r++)
        for (sn_index k = 0; k < SECTORS; k++) {
            double turn = 2.0 * SN_PI * (k + 0.5 * (r % 2)) / SECTORS;
            mesh.positions[r * SECTORS + k] = sn_v3(RADIUS * cos(turn), RADIUS * sin(turn), LENGTH * r / (RINGS - 1.0));
        }
    for (sn_index k = 0; k < SECTORS; k++) {
        sn_index next = (k + 1) % SECTORS, last = (RINGS - 1) * SECTORS;
        *t++ = (sn_triangle){{bottom, next, k}};
        *t++ = (sn_triangle){{top, last + k, last + next}};
        for (sn_index r = 0; r + 1 < RINGS; r++) {
            sn_index a = r * SECTORS + k, b = r * SECTORS + next, c = a + SECTORS, d = b + SECTORS;
            *t++ = (sn_triangle){{a, b, r % 2 ? d : c}};
            *t++ = r % 2 ? (sn_triangle){{a, d, c}} : (sn_triangle){{b, d, c}};
        }
    }
    return mesh;
}

/* Fibres from 5 % to 95 % of the length, at radii from 0 to 0.8 R. */
static sn_fibers straight_fibers(void) {
    sn_fibers fibers = {.polyline_count = FIBERS, .polylines = SN_NEW(sn_polyline, FIBERS)};
    for (sn_index i = 0; i < FIBERS; i++) {
        sn_polyline *line = &fibers.polylines[i];
        *line = (sn_polyline){.count = SEGMENTS + 1, .points = SN_NEW(sn_vec3, SEGMENTS + 1)};
        double radius = 0.1 * i * RADIUS, turn = 2.4 * i;
        for (sn_index k = 0; k <= SEGMENTS; k++)
            line->points[k] = sn_v3(radius * cos(turn), radius * sin(turn), LENGTH * (0.05 + 0.9 * k / SEGMENTS));
    }
    return fibers;
}

typedef struct carried {
    sn_mesh mesh;
    sn_fibers fibers;
    sn_fiber_bundle bundle;
    sn_embedding embedding;
    sn_vec3 *surface, *points;
    double lengths[FIBERS];
} carried;

static carried carry(double cut) {
    carried c = {.mesh = tube(), .fibers = straight_fibers()};
    sn_embedding_params params = sn_embedding_defaults();
    params.cut = cut;
    assert_ok(sn_fiber_bundle_create(&c.fibers, &c.bundle, NULL));
    assert_ok(sn_embedding_build(&c.mesh, c.bundle.point_count, c.bundle.points, &params, &c.embedding, NULL));
    c.surface = SN_NEW(sn_vec3, c.mesh.vertex_count);
    c.points = SN_NEW(sn_vec3, c.bundle.point_count);
    return c;
}

static void move(carried *c, sn_vec3 (*map)(sn_vec3)) {
    for (sn_index v = 0; v < c->mesh.vertex_count; v++) c->surface[v] = map(c->mesh.positions[v]);
    sn_embedding_apply(&c->embedding, c->surface, NULL, c->points);
    sn_fiber_lengths(&c->bundle, c->points, c->lengths);
}

static void drop(carried *c) {
    sn_mesh_free(&c->mesh);
    sn_fibers_free(&c->fibers);
    sn_fiber_bundle_free(&c->bundle);
    sn_embedding_free(&c->embedding);
    free(c->surface);
    free(c->points);
}

/* Longer by 30 %, thinner so that the volume stays. */
static sn_vec3 stretch(sn_vec3 p) { return sn_v3(p.x / sqrt(1.3), p.y / sqrt(1.3), 1.3 * p.z); }
static sn_vec3 shear(sn_vec3 p) {
    return sn_v3(1.2 * p.x + 0.3 * p.y - 0.2 * p.z + 5.0, 0.8 * p.y + 0.4 * p.z - 2.0, 0.1 * p.x + 0.9 * p.z + 1.0);
}
static sn_vec3 stay(sn_vec3 p) { return p; }

#define BEND (40.0 / 180.0 * SN_PI)
/* An arc of 40 degrees over the length, with the axis as neutral line. */
static sn_vec3 bend(sn_vec3 p) {
    double radius = LENGTH / BEND, turn = p.z / radius;
    return sn_v3(radius - (radius - p.x) * cos(turn), p.y, (radius - p.x) * sin(turn));
}

static void test_affine_maps_are_followed_exactly(void **state) {
    (void)state;
    const double cuts[2] = {0.0, 3e-4};
    for (int i = 0; i < 2; i++) {
        carried c = carry(cuts[i]);
        move(&c, shear);
        for (sn_index k = 0; k < c.bundle.point_count; k++)
            assert_true(sn_distance(c.points[k], shear(c.bundle.points[k])) < 1e-9 * LENGTH);
        drop(&c);
    }
}

static void test_lengths_are_the_analytic_ones(void **state) {
    (void)state;
    const double cuts[2] = {0.0, 3e-4};
    for (int i = 0; i < 2; i++) {
        carried c = carry(cuts[i]);
        double worst = 0.0;
        move(&c, stay);
        for (sn_index f = 0; f < FIBERS; f++) assert_near(c.lengths[f], 0.9 * LENGTH, 1e-12);
        move(&c, stretch);
        for (sn_index f = 0; f < FIBERS; f++) assert_near(c.lengths[f], 1.3 * 0.9 * LENGTH, 1e-12);
        move(&c, bend);
        for (sn_index f = 0; f < FIBERS; f++) {
            double exact = 0.9 * (LENGTH - c.bundle.points[c.bundle.start[f]].x * BEND);
            worst = fmax(worst, fabs(c.lengths[f] / exact - 1.0));
        }
        print_message("bent by 40 degrees, cut %g: lengths off by %.3g %% at most\n", cuts[i], 100.0 * worst);
        assert_true(worst < 1e-3);
        drop(&c);
    }
}

/* Fibres through a fusiform muscle that is bent by 60 degrees keep inside of it, with and without the cut. */
static void test_bent_fibers_stay_inside(void **state) {
    (void)state;
    sn_muscle muscle = {.meters_per_unit = 1.0};
    fusiform shape = FUSIFORM;
    shape.rings = 60, shape.sectors = 32;
    make_surface(&shape, &muscle.mesh);
    sn_fill_params fill = sn_fill_defaults();
    sn_fill_report filled;
    assert_ok(sn_fill_fibers(&muscle, &fill, NULL, &muscle.fibers, &filled, NULL));
    sn_fiber_bundle bundle;
    assert_ok(sn_fiber_bundle_create(&muscle.fibers, &bundle, NULL));
    sn_vec3 *points = SN_NEW(sn_vec3, bundle.point_count);
    sn_mesh bent;
    assert_ok(sn_mesh_copy(&muscle.mesh, &bent, NULL));
    double radius = shape.length / (SN_PI / 3.0);
    for (sn_index v = 0; v < bent.vertex_count; v++) {
        sn_vec3 p = bent.positions[v];
        bent.positions[v] = sn_v3(radius - (radius - p.x) * cos(p.z / radius), p.y, (radius - p.x) * sin(p.z / radius));
    }
    sn_surface *surface;
    assert_ok(sn_surface_create(&bent, &surface, NULL));
    const double cuts[2] = {0.0, 3e-4};
    for (int i = 0; i < 2; i++) {
        sn_embedding_params params = sn_embedding_defaults();
        sn_embedding embedding;
        params.cut = cuts[i];
        assert_ok(sn_embedding_build(&muscle.mesh, bundle.point_count, bundle.points, &params, &embedding, NULL));
        sn_embedding_apply(&embedding, bent.positions, NULL, points);
        sn_index outside = 0;
        for (sn_index k = 0; k < bundle.point_count; k++)
            outside += sn_surface_signed_distance(surface, points[k], NULL) > 1e-9 * shape.length;
        assert_int_equal(bundle.point_count, 1600);
        assert_int_equal(outside, 0);
        sn_embedding_free(&embedding);
    }
    sn_surface_destroy(surface);
    sn_mesh_free(&bent);
    free(points);
    sn_fiber_bundle_free(&bundle);
    sn_muscle_free(&muscle);
}

static void test_bundles_refuse_what_is_no_fiber(void **state) {
    (void)state;
    sn_fiber_bundle bundle;
    sn_fibers fibers = {0};
    assert_int_equal(sn_fiber_bundle_create(&fibers, &bundle, NULL), SN_ERROR_INPUT);
    fibers = straight_fibers();
    fibers.polylines[3].points[2].y = NAN;
    assert_int_equal(sn_fiber_bundle_create(&fibers, &bundle, NULL), SN_ERROR_INPUT);
    for (sn_index k = 0; k <= SEGMENTS; k++) fibers.polylines[3].points[k] = sn_v3(0, 0, 0.1);
    assert_int_equal(sn_fiber_bundle_create(&fibers, &bundle, NULL), SN_ERROR_INPUT);
    assert_null(bundle.points);
    sn_fibers_free(&fibers);
}

/* ---- the blend ------------------------------------------------------------------------------------------------------------------- */

/* The fusiform of sim_scene.h in mm with three straight fibres from its upper bone, which is fixed, to its lower one. */
static void scene_with_fibers(sn_scene *scene, sn_fiber_bundle *bundle) {
    fusiform shape = FUSIFORM;
    shape.meters_per_unit = 1e-3;
    make_scene(scene, &shape);
    sn_fibers *fibers = &scene->muscles[0].rig.fibers;
    fibers->polyline_count = 3;
    fibers->polylines = SN_NEW(sn_polyline, 3);
    for (sn_index i = 0; i < 3; i++) {
        fibers->polylines[i] = (sn_polyline){.count = 5, .points = SN_NEW(sn_vec3, 5)};
        for (sn_index k = 0; k < 5; k++) fibers->polylines[i].points[k] = sn_v3(2.0 * i, 0.0, 190.0 - 45.0 * k);
    }
    assert_ok(sn_fiber_bundle_create(fibers, bundle, NULL));
}

/* All that simulate does: metres of the state, the document's unit, the weights with the cut. The map is in the document's unit. */
static void test_affine_states_are_followed_exactly(void **state) {
    (void)state;
    sn_scene scene;
    sn_fiber_bundle bundle;
    sn_embedding embedding;
    sn_embedding_params params = sn_embedding_defaults();
    scene_with_fibers(&scene, &bundle);
    const sn_mesh *mesh = &scene.muscles[0].rig.mesh;
    simulation s = start(&scene);
    sn_vec3 *surface = SN_NEW(sn_vec3, mesh->vertex_count), points[15];
    params.cut = 3e-4;
    assert_ok(sn_embedding_build(mesh, bundle.point_count, bundle.points, &params, &embedding, NULL));
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 p = sn_scale(shear(mesh->positions[v]), 1e-3);
        s.state->muscles[0].points[v] = (sn_point){p.x, p.y, p.z, 1.0};
    }
    sn_state_positions(s.model, s.state, 0, surface);
    sn_embedding_apply(&embedding, surface, NULL, points);
    for (sn_index k = 0; k < 15; k++) assert_true(sn_distance(points[k], shear(bundle.points[k])) < 1e-9 * 200.0);
    sn_embedding_free(&embedding);
    free(surface);
    sn_fiber_bundle_free(&bundle);
    finish(&s);
}

static void test_blend_is_between_the_bones(void **state) {
    (void)state;
    sn_scene scene;
    sn_fiber_bundle bundle;
    scene_with_fibers(&scene, &bundle);
    sn_vec3 points[15];
    for (int power = 1; power <= 3; power++) {
        sn_fiber_blend blend;
        assert_ok(sn_fiber_blend_create(&scene, &scene.muscles[0].rig, &bundle, power, &blend, NULL));
        sn_rigid pose = {sn_quat_axis_angle(sn_v3(1, 0, 0), 0.5), {0.01, 0.02, -0.03}};
        sn_fiber_blend_apply(&blend, &bundle, &pose, points);
        for (sn_index k = 0; k < 15; k++) {
            sn_vec3 rest = bundle.points[k], moved = sn_scale(sn_rigid_apply(pose, sn_scale(rest, 1e-3)), 1e3);
            sn_vec3 wanted = sn_lerp(rest, moved, pow(k % 5 / 4.0, power));
            assert_true(sn_distance(points[k], wanted) < 1e-10);
        }
        sn_fiber_blend_free(&blend);
    }
    sn_fiber_bundle_free(&bundle);
    sn_scene_free(&scene);
}

static void test_blend_needs_attachments_and_an_exponent(void **state) {
    (void)state;
    sn_scene scene;
    sn_fiber_bundle bundle;
    sn_fiber_blend blend;
    scene_with_fibers(&scene, &bundle);
    assert_int_equal(sn_fiber_blend_create(&scene, &scene.muscles[0].rig, &bundle, 0.0, &blend, NULL), SN_ERROR_USAGE);
    assert_int_equal(sn_fiber_blend_create(&scene, &scene.muscles[0].rig, &bundle, NAN, &blend, NULL), SN_ERROR_USAGE);
    scene.muscles[0].rig.attachments[0].count = scene.muscles[0].rig.attachments[1].count = 0;
    assert_int_equal(sn_fiber_blend_create(&scene, &scene.muscles[0].rig, &bundle, 1.0, &blend, NULL), SN_ERROR_INPUT);
    sn_fiber_bundle_free(&bundle);
    sn_scene_free(&scene);
}

/* ---- bones ------------------------------------------------------------------------------------------------------------------------ */

/* A cube of 1 that never moves and a sphere of 2 mm, in mm, that a joint carries away by 10 m. */
static void test_points_in_bones(void **state) {
    (void)state;
    sn_scene scene;
    fusiform shape = FUSIFORM;
    make_scene(&scene, &shape);
    scene.bones[0].mesh = shape_cube();
    scene.bones[1].mesh = shape_sphere(40, 80);
    scene.bones[1].meters_per_unit = 2e-3;
    sn_bone_probe *probe;
    assert_ok(sn_bone_probe_create(&scene, &probe, NULL));
    const sn_rigid away = {{1, 0, 0, 0}, {10, 0, 0}};
    /* cm: in the cube, 0.1 m deep; outside; in the sphere's centre; in the cube, where the sphere was; nowhere */
    const sn_vec3 points[5] = {{50, 50, 10}, {50, 50, -10}, {1000, 0, 0}, {0.1, 0.1, 0.1}, {NAN, 0, 0}};
    sn_penetration p = sn_bone_probe_points(probe, &away, 5, points, 0.01);
    assert_int_equal(p.inside, 3);
    assert_int_equal(p.bone, 0);
    assert_near(p.deepest, 0.1, 1e-12);
    p = sn_bone_probe_points(probe, &away, 1, &points[2], 0.01);
    assert_int_equal(p.bone, 1);
    assert_near(p.deepest, 2e-3, 2e-5);
    p = sn_bone_probe_points(probe, &away, 1, &points[1], 0.01);
    assert_true(p.inside == 0 && p.deepest == 0.0 && p.bone == SN_NONE);
    sn_bone_probe_destroy(probe);
    sn_scene_free(&scene);
}

/* Of points along a line most are told by their neighbours; each alone is looked at, and that comes to the same numbers. */
static void test_points_along_a_line_are_told_as_each_alone(void **state) {
    (void)state;
    enum { POINTS = 400 };
    sn_scene scene;
    fusiform shape = FUSIFORM;
    make_scene(&scene, &shape);
    scene.bones[0].mesh = shape_cube();
    scene.bones[1].mesh = shape_sphere(40, 80);
    scene.bones[1].meters_per_unit = 0.2; /* it overlaps the cube */
    sn_bone_probe *probe;
    assert_ok(sn_bone_probe_create(&scene, &probe, NULL));
    sn_surface *cube, *ball;
    assert_ok(sn_surface_create(&scene.bones[0].mesh, &cube, NULL));
    assert_ok(sn_surface_create(&scene.bones[1].mesh, &ball, NULL));
    const sn_rigid still = sn_rigid_identity();
    uint64_t seed = 3;
    for (int line = 0; line < 30; line++) {
        sn_vec3 points[POINTS], from, to;
        double ends[6];
        for (int k = 0; k < 6; k++) ends[k] = 2.0 * sn_random(&seed) - 0.5;
        from = sn_v3(ends[0], ends[1], ends[2]), to = sn_v3(ends[3], ends[4], ends[5]);
        sn_penetration each = {.bone = SN_NONE};
        for (int i = 0; i < POINTS; i++) {
            points[i] = sn_lerp(from, to, (double)i / (POINTS - 1));
            sn_penetration one = sn_bone_probe_points(probe, &still, 1, &points[i], 1.0);
            double by_cube = sn_surface_signed_distance(cube, points[i], NULL);
            double by_ball = sn_surface_signed_distance(ball, sn_scale(points[i], 5.0), NULL) * 0.2;
            assert_int_equal(one.inside, by_cube < 0.0 || by_ball < 0.0);
            if (one.inside) assert_true(fabs(one.deepest + fmin(by_cube, by_ball)) < 1e-12);
            each.inside += one.inside;
            if (one.deepest > each.deepest) each.deepest = one.deepest, each.bone = one.bone;
        }
        sn_penetration all = sn_bone_probe_points(probe, &still, POINTS, points, 1.0);
        assert_int_equal(all.inside, each.inside);
        assert_true(all.deepest == each.deepest && all.bone == each.bone);
    }
    sn_surface_destroy(cube);
    sn_surface_destroy(ball);
    sn_bone_probe_destroy(probe);
    sn_scene_free(&scene);
}

/* ---- tables and frames -------------------------------------------------------------------------------------------------------------- */

static char folder[256];

static int make_folder(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/sinew-fibers-XXXXXX", base != NULL ? base : "/tmp");
    return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state) {
    (void)state;
    return rmdir(folder);
}

/* The numbers of a table: rows x columns; the text in front of them goes to `head`. */
static void table_of(const char *name, int rows, int columns, const double *values, int rounds, char *head, double *out) {
    char path[320];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    const char *names[] = {"time", "a muscle.1", "a muscle.2"};
    const sn_table_params params = {
        .title = "a title", .rows = rows, .columns = columns, .names = names, .smoothed_from = 1, .rounds = rounds};
    sn_table *table;
    assert_ok(sn_table_create(path, &params, &table, NULL));
    for (int i = 0; i < rows; i++) assert_ok(sn_table_append(table, values + i * columns, NULL));
    assert_int_equal(access(path, F_OK), -1);
    assert_ok(sn_table_commit(table, NULL));
    sn_blob blob;
    assert_ok(sn_blob_read(path, &blob, NULL));
    const char *at = strstr(blob.data, "time"), *end = blob.data + blob.size;
    at = strchr(at, '\n') + 1;
    memcpy(head, blob.data, (size_t)(at - blob.data));
    head[at - blob.data] = '\0';
    for (int i = 0; i < rows * columns; i++) {
        assert_true(sn_scan_number(at, end, &at, &out[i]));
        assert_int_equal(*at++, (i + 1) % columns ? '\t' : '\n');
    }
    assert_ptr_equal(at, end);
    sn_blob_free(&blob);
    unlink(path);
}

static void test_tables_hold_the_numbers(void **state) {
    (void)state;
    const double values[6] = {0.0, 1.0 / 3.0, -1e-300, 1.0 / 24.0, 2e22, 5.0};
    double out[6];
    char head[512];
    table_of("t.tsv", 2, 3, values, 0, head, out);
    assert_string_equal(head, "time\ta_muscle.1\ta_muscle.2\n");
    assert_memory_equal(values, out, sizeof values);
    table_of("t.sto", 2, 3, values, 0, head, out);
    assert_string_equal(head, "a_title\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\nUnits are S.I. units (second, meters, Newtons, "
                              "...)\nAngles are in degrees.\n\nendheader\ntime\ta_muscle.1\ta_muscle.2\n");
    assert_memory_equal(values, out, sizeof values);
}

/* The filter written down as the paper has it, over all rows at once, five times; the table does it row by row. */
static void test_smoothing_is_the_papers(void **state) {
    (void)state;
    enum { ROWS = 40, ROUNDS = 5 };
    uint64_t random = 5;
    for (int rows = 1; rows <= ROWS; rows += rows < 8 ? 1 : 16) {
        double values[ROWS][3], out[ROWS][3], wanted[ROWS][3], before[ROWS][3];
        char head[512];
        for (int i = 0; i < rows; i++) values[i][0] = i * i, values[i][1] = sn_random(&random), values[i][2] = sn_random(&random);
        memcpy(wanted, values, sizeof wanted);
        for (int round = 0; round < ROUNDS; round++) {
            memcpy(before, wanted, sizeof before);
            for (int i = 1; i + 1 < rows; i++)
                for (int k = 1; k < 3; k++) wanted[i][k] = (before[i - 1][k] + 4.0 * before[i][k] + before[i + 1][k]) / 6.0;
        }
        table_of("t.tsv", rows, 3, &values[0][0], ROUNDS, head, &out[0][0]);
        assert_memory_equal(out, wanted, (size_t)rows * sizeof *out);
    }
}

/* A smooth curve with noise that alternates by 1 mm: the second difference, 4 mm from the noise alone, falls by 3^5. */
static void test_smoothing_bounds_the_second_difference(void **state) {
    (void)state;
    enum { ROWS = 91 };
    double values[ROWS][2], out[ROWS][2], worst = 0.0;
    char head[512];
    for (int i = 0; i < ROWS; i++) values[i][0] = i / 24.0, values[i][1] = 0.25 + 0.02 * sin(i / 30.0) + (i % 2 ? 1e-3 : -1e-3);
    table_of("t.tsv", ROWS, 2, &values[0][0], 5, head, &out[0][0]);
    for (int i = 7; i + 7 < ROWS; i++) worst = fmax(worst, fabs(out[i - 1][1] - 2.0 * out[i][1] + out[i + 1][1]));
    assert_true(worst < 0.02 / 900.0 + 4.1e-3 / 243.0);
    assert_true(out[0][1] == values[0][1] && out[ROWS - 1][1] == values[ROWS - 1][1]);
}

static double number_at(const sn_blob *blob, size_t offset) {
    double value;
    const char *data = strstr(blob->data, "encoding=\"raw\">\n_");
    assert_non_null(data);
    memcpy(&value, data + strlen("encoding=\"raw\">\n_") + offset, sizeof value);
    return value;
}

static void test_line_frames(void **state) {
    (void)state;
    char prefix[300], path[340];
    snprintf(prefix, sizeof prefix, "%s/a&b-fibers", folder);
    const sn_index start[3] = {0, 2, 5};
    const sn_vec3 points[5] = {{0, 0, 0}, {0, 0, 2}, {1, 0, 0}, {1, 0, 1}, {1, 0.25, 1}};
    const double rest[2] = {1.0, 2.5}, lengths[2] = {2.0, 1.25};
    sn_line_frames *frames;
    assert_ok(sn_line_frames_create(prefix, 2, start, rest, &frames, NULL));
    assert_ok(sn_line_frames_append(frames, 3, 0.125, points, lengths, NULL));
    assert_ok(sn_line_frames_append(frames, 4, 1.0 / 6.0, points, lengths, NULL));
    assert_ok(sn_line_frames_commit(frames, NULL));
    sn_blob blob;
    snprintf(path, sizeof path, "%s.pvd", prefix);
    assert_ok(sn_blob_read(path, &blob, NULL));
    assert_non_null(strstr(blob.data, "<DataSet timestep=\"0.125\" part=\"0\" file=\"a&amp;b-fibers.0003.vtp\"/>"));
    assert_non_null(strstr(blob.data, "a&amp;b-fibers.0004.vtp"));
    sn_blob_free(&blob);
    unlink(path);
    for (int i = 3; i < 5; i++) {
        snprintf(path, sizeof path, "%s.%04d.vtp", prefix, i);
        assert_ok(sn_blob_read(path, &blob, NULL));
        assert_non_null(strstr(blob.data, "NumberOfPoints=\"5\" NumberOfVerts=\"0\" NumberOfLines=\"2\""));
        assert_near(number_at(&blob, 8 + 8 * 13), 0.25, 0.0); /* y of the last point */
        size_t measures = 8 + 24 * 5 + 8 + 8 * 5 + 8 + 8 * 2;
        assert_near(number_at(&blob, measures + 8 + 8), 1.25, 0.0);
        assert_near(number_at(&blob, measures + 2 * 8 + 2 * 8 + 8), 0.5, 0.0);
        sn_blob_free(&blob);
        unlink(path);
    }
}

static void test_an_aborted_table_leaves_nothing(void **state) {
    (void)state;
    char path[320];
    snprintf(path, sizeof path, "%s/t.tsv", folder);
    const char *names[] = {"time"};
    const double row[1] = {0.0};
    sn_table *table;
    sn_table_params params = {.title = "t", .rows = 1, .columns = 1, .names = names, .smoothed_from = 1, .rounds = 5};
    assert_ok(sn_table_create(path, &params, &table, NULL));
    assert_ok(sn_table_append(table, row, NULL));
    sn_table_abort(table);
    assert_int_equal(access(path, F_OK), -1);
    snprintf(path, sizeof path, "%s/none/t.tsv", folder);
    assert_int_equal(sn_table_create(path, &params, &table, NULL), SN_ERROR_IO);
    assert_null(table);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_affine_maps_are_followed_exactly),
        cmocka_unit_test(test_lengths_are_the_analytic_ones),
        cmocka_unit_test(test_bent_fibers_stay_inside),
        cmocka_unit_test(test_bundles_refuse_what_is_no_fiber),
        cmocka_unit_test(test_affine_states_are_followed_exactly),
        cmocka_unit_test(test_blend_is_between_the_bones),
        cmocka_unit_test(test_blend_needs_attachments_and_an_exponent),
        cmocka_unit_test(test_points_in_bones),
        cmocka_unit_test(test_points_along_a_line_are_told_as_each_alone),
        cmocka_unit_test_setup_teardown(test_tables_hold_the_numbers, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_smoothing_is_the_papers, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_smoothing_bounds_the_second_difference, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_line_frames, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_an_aborted_table_leaves_nothing, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
