/* test_architecture.c -- fibre lengths, pennation, cross-section areas and tendons of generated muscles with known answers. */
#include "shapes.h"

#include "rig_shapes.h"

#include "sinew/architecture.h"

#define DEGREES (180.0 / SN_PI)

/* ---- shapes --------------------------------------------------------------------------------------------------------------- */

/* Half of its sides; z from 0 to length. A box of cells, n along x, y and z. */
typedef struct box_shape {
    double size[3];
    sn_index cells[3];
} box_shape;

static sn_index box_corner(const box_shape *b, sn_mesh *m, sn_index *number, const sn_index at[3]) {
    sn_index *n = &number[(at[0] * (b->cells[1] + 1) + at[1]) * (b->cells[2] + 1) + at[2]];
    if (*n == 0) {
        double p[3];
        for (int a = 0; a < 3; a++) p[a] = b->size[a] * at[a] / b->cells[a];
        m->positions[m->vertex_count++] = sn_v3(p[0], p[1], p[2]);
        *n = m->vertex_count;
    }
    return *n - 1;
}

static void box_side(const box_shape *b, sn_mesh *m, sn_index *number, int axis, sn_index level) {
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (sn_index i = 0; i < b->cells[u]; i++)
        for (sn_index k = 0; k < b->cells[v]; k++) {
            sn_index c[4];
            for (int n = 0; n < 4; n++) {
                sn_index at[3];
                at[axis] = level;
                at[u] = i + (n == 1 || n == 2);
                at[v] = k + (n >= 2);
                c[n] = box_corner(b, m, number, at);
            }
            int second = level > 0 ? 1 : 3, fourth = level > 0 ? 3 : 1;
            m->triangles[m->triangle_count++] = (sn_triangle){{c[0], c[second], c[2]}};
            m->triangles[m->triangle_count++] = (sn_triangle){{c[0], c[2], c[fourth]}};
        }
}

static sn_mesh box(box_shape b) {
    sn_index sides = 4 * (b.cells[0] * b.cells[1] + b.cells[1] * b.cells[2] + b.cells[2] * b.cells[0]);
    sn_index corners = (b.cells[0] + 1) * (b.cells[1] + 1) * (b.cells[2] + 1), *number = SN_NEW(sn_index, corners);
    sn_mesh m = {0};
    if (number == NULL || sn_mesh_alloc(&m, 3 * sides, sides, NULL)) abort();
    m.vertex_count = m.triangle_count = 0;
    for (int axis = 0; axis < 3; axis++) {
        box_side(&b, &m, number, axis, 0);
        box_side(&b, &m, number, axis, b.cells[axis]);
    }
    free(number);
    return m;
}

/* A belly with a cylindrical tendon at each end, on a lathe: the poles of `spindle` at the ends of the tendons. */
typedef struct tendinous {
    double tendon[2], belly, thin, wide; /* lengths, radii */
} tendinous;

static double radius_at(const tendinous *s, double z) {
    double share = (z - s->tendon[0]) / s->belly;
    return share <= 0.0 || share >= 1.0 ? s->thin : s->thin + (s->wide - s->thin) * sqrt(sin(SN_PI * share));
}

static double length_of(const tendinous *s) { return s->tendon[0] + s->belly + s->tendon[1]; }

/* Share of the length where the belly has less than 0.15 of its widest section. */
static double thin_belly(const tendinous *s) {
    double root = (sqrt(0.15) * s->wide - s->thin) / (s->wide - s->thin);
    return 2.0 * asin(root * root) / SN_PI * s->belly / length_of(s);
}

static sn_mesh lathe(const tendinous *s, sn_index rings, sn_index sectors) {
    double length = length_of(s);
    sn_mesh m = spindle(rings, sectors, length, 1.0);
    for (sn_index v = 0; v < m.vertex_count; v++) {
        sn_vec3 p = m.positions[v];
        double z = p.z + 0.5 * length, around = sn_length2(p.x, p.y), r = around > 1e-9 ? radius_at(s, z) / around : 0.0;
        m.positions[v] = sn_v3(r * p.x, r * p.y, z);
    }
    return m;
}

/* ---- fibres ----------------------------------------------------------------------------------------------------------------- */

typedef struct rig {
    sn_muscle muscle;
    sn_architecture a;
    sn_architecture_params params;
    sn_error error;
} rig;

static rig rig_of(sn_mesh mesh, sn_index fibers) {
    rig r = {.muscle = {.meters_per_unit = 0.001, .mesh = mesh}, .params = sn_architecture_defaults()};
    r.muscle.fibers.polylines = SN_NEW(sn_polyline, fibers);
    if (r.muscle.fibers.polylines == NULL) abort();
    return r;
}

enum { POINTS = 16 };

static void add_fiber(rig *r, sn_vec3 from, sn_vec3 to) {
    sn_polyline *line = &r->muscle.fibers.polylines[r->muscle.fibers.polyline_count++];
    line->count = POINTS;
    line->points = SN_NEW(sn_vec3, POINTS);
    if (line->points == NULL) abort();
    for (sn_index k = 0; k < POINTS; k++) line->points[k] = sn_lerp(from, to, k / (POINTS - 1.0));
}

static sn_status measure(rig *r) { return sn_architecture_measure(&r->muscle, &r->params, &r->a, &r->error); }

static void rig_end(rig *r) {
    sn_architecture_free(&r->a);
    sn_muscle_free(&r->muscle);
}

/* Fibres along the lathe, which fill every section alike. */
static rig tendinous_rig(const tendinous *s, sn_index rings, sn_index sectors) {
    rig r = rig_of(lathe(s, rings, sectors), 16);
    for (int i = 0; i < 16; i++) {
        add_fiber(&r, sn_v3(0, 0, 0), sn_v3(0, 0, length_of(s)));
        for (sn_index k = 0; k < POINTS; k++) {
            sn_vec3 *p = &r.muscle.fibers.polylines[i].points[k];
            double reach = 0.9 * sqrt((i + 0.5) / 16.0) * radius_at(s, p->z);
            p->x = reach * cos(2.4 * i);
            p->y = reach * sin(2.4 * i);
        }
    }
    return r;
}

static const box_shape STRAP = {{24, 12, 160}, {12, 6, 80}}, SHEET = {{100, 2, 80}, {50, 1, 40}};

static rig strap_rig(const box_shape *shape) {
    rig r = rig_of(box(*shape), 9);
    for (int i = 0; i < 9; i++) {
        double x = shape->size[0] * (i % 3 + 0.5) / 3, y = shape->size[1] * (i / 3 + 0.5) / 3;
        add_fiber(&r, sn_v3(x, y, 0), sn_v3(x, y, shape->size[2]));
    }
    return r;
}

/* ---- length, pennation, area ---------------------------------------------------------------------------------------------------- */

/* Along a strap: the area is that of its section. */
static void a_strap_has_the_area_of_its_section(void **state) {
    (void)state;
    rig r = strap_rig(&STRAP);
    assert_ok(measure(&r));
    assert_int_equal(r.a.fibers, 9);
    assert_true(r.a.closed);
    assert_near(r.a.volume, 24.0 * 12 * 160, 1e-6);
    assert_near(r.a.length.mean, 160.0, 1e-9);
    assert_near(r.a.length.deviation, 0.0, 1e-9);
    assert_near(r.a.mean_pennation * DEGREES, 0.0, 0.1);
    assert_near(r.a.area, r.a.volume / 160, 1e-3);
    assert_true(r.a.tendon == SN_TENDON_THICKNESS && r.a.tendon_share == 0.0 && r.a.tendon_volume == 0.0);
    assert_near(r.a.belly.mean, 160.0, 1e-9);
    assert_near(r.a.belly_area, r.a.area, 1e-9);
    rig_end(&r);
}

/* From one side of a slab obliquely to the other, as far as whole fibres fit. */
static void a_pennate_slab_has_its_angle_at_both_ends(void **state) {
    (void)state;
    const double angles[] = {10, 20, 30};
    for (int n = 0; n < 3; n++) {
        double angle = angles[n] / DEGREES, rise = 24 / tan(angle);
        rig r = rig_of(box((box_shape){{24, 12, 260}, {12, 6, 130}}), 20);
        for (int i = 0; i < 20; i++) {
            double z = (260 - rise) * (i + 0.5) / 20, y = 12 * (i % 4 + 0.5) / 4;
            add_fiber(&r, sn_v3(0, y, z), sn_v3(24, y, z + rise));
        }
        assert_ok(measure(&r));
        assert_near(r.a.length.mean, 24 / sin(angle), 1e-9);
        for (int end = 0; end < 2; end++) {
            assert_near(r.a.pennation[end].mean * DEGREES, angles[n], 1.0);
            assert_true(r.a.pennation[end].deviation * DEGREES < 1.0);
        }
        assert_near(r.a.area / (260.0 * 24 * 12 / (24 / sin(angle)) * cos(angle)), 1.0, 0.02);
        rig_end(&r);
    }
}

/* The angle is one of axes: a fibre told from insertion to origin has it the other way round. */
static void the_ends_are_those_of_the_fibres(void **state) {
    (void)state;
    double seen[2][2];
    for (int turned = 0; turned < 2; turned++) {
        rig r = rig_of(box(STRAP), 1);
        add_fiber(&r, sn_v3(4, 6, turned ? 150 : 10), sn_v3(4, 6, turned ? 10 : 150));
        sn_vec3 *p = r.muscle.fibers.polylines[0].points;
        for (int k = 0; k < POINTS; k++) p[k].x += 12 * pow((p[k].z - 10) / 140, 4); /* bowed towards the high end */
        assert_ok(measure(&r));
        for (int end = 0; end < 2; end++) seen[turned][end] = r.a.pennation[end].mean;
        rig_end(&r);
    }
    assert_true(seen[0][0] * DEGREES < 1.0 && seen[0][1] * DEGREES > 10.0);
    assert_near(seen[0][0], seen[1][1], 1e-6);
    assert_near(seen[0][1], seen[1][0], 1e-6);
}

static void spreads_are_those_of_the_fibres(void **state) {
    (void)state;
    rig r = rig_of(box(STRAP), 3);
    for (int i = 0; i < 3; i++) add_fiber(&r, sn_v3(6 + 6 * i, 6, 80 - 20 * (i + 1)), sn_v3(6 + 6 * i, 6, 80 + 20 * (i + 1)));
    assert_ok(measure(&r));
    assert_near(r.a.length.mean, 80.0, 1e-9);
    assert_near(r.a.length.least, 40.0, 1e-9);
    assert_near(r.a.length.greatest, 120.0, 1e-9);
    assert_near(r.a.length.deviation, sqrt(3200.0 / 3), 1e-9);
    rig_end(&r);
}

/* ---- tendons by thickness ---------------------------------------------------------------------------------------------------------- */

static void thin_ends_are_tendon_at_any_density(void **state) {
    (void)state;
    const tendinous shapes[] = {{{50, 50}, 100, 2.4, 12}, {{0, 70}, 130, 2, 10}, {{20, 90}, 90, 3, 15}};
    for (int s = 0; s < 3; s++)
        for (sn_index n = 0; n < 3; n++) {
            rig r = tendinous_rig(&shapes[s], 40 << n, 12 << n);
            double truth = (shapes[s].tendon[0] + shapes[s].tendon[1]) / length_of(&shapes[s]), ends = thin_belly(&shapes[s]);
            assert_ok(measure(&r));
            assert_near(r.a.tendon_share, truth, 0.04);
            assert_near(r.a.tendon_share, truth + ends, 0.02); /* the belly's own tips are as thin */
            assert_near(r.a.belly.mean, shapes[s].belly, 0.04 * length_of(&shapes[s]));
            assert_true(r.a.tendon_volume < 0.15 && r.a.tendon_volume > 0.01);
            assert_true(r.a.belly_area > r.a.area * 1.2);
            rig_end(&r);
        }
}

/* Rounded and pointed tips, a strap, sheets, are muscle all along. */
static void what_has_no_tendon_gets_none(void **state) {
    (void)state;
    rig plain[3] = {rig_of(spindle(40, 16, 160, 14), 1), strap_rig(&STRAP), strap_rig(&SHEET)};
    add_fiber(&plain[0], sn_v3(0, 0, -80), sn_v3(0, 0, 80));
    for (int i = 0; i < 3; i++) {
        assert_ok(measure(&plain[i]));
        assert_true(plain[i].a.tendon_share < 0.005);
        assert_true(plain[i].a.tendon_volume < 0.005);
        rig_end(&plain[i]);
    }
}

/* A belly with three digits as thick as it is together; one with three thin cords; a thick second belly behind a cord. */
static bool digits(int x, int y, int z) {
    bool belly = z < 18 && x >= 4 && x < 34, digit = z >= 18 && x >= 4 && x < 34 && (x - 4) % 12 < 6;
    return y >= 16 && y < 24 && (belly || digit);
}

static bool cords(int x, int y, int z) {
    bool belly = z < 18 && x >= 4 && x < 34 && y >= 14 && y < 26, cord = x >= 4 && (x - 4) % 14 < 2 && x < 34 && y >= 19 && y < 21;
    return belly || (z >= 18 && cord);
}

static bool two_bellies(int x, int y, int z) {
    bool belly = (z < 13 || z >= 27) && x >= 14 && x < 26 && y >= 14 && y < 26, cord = x >= 14 && x < 16 && y >= 19 && y < 21;
    return belly || cord;
}

static void where_a_muscle_splits_its_branches_share_the_belly(void **state) {
    (void)state;
    const block_function shape[] = {digits, cords, two_bellies};
    const sn_vec3 from[] = {{6, 20, 1}, {5, 20, 1}, {15, 20, 1}}, to[] = {{6, 20, 39}, {5, 20, 39}, {15, 20, 39}};
    /* blocks of 1 in 40; where a cord meets a flat face, fronts need as much as the belly's width to spread over that */
    const double truth[] = {0.0, 22.0 / 40, 14.0 / 40}, tolerance[] = {0.005, 0.08, 0.15};
    for (int i = 0; i < 3; i++) {
        rig r = rig_of(blocks(shape[i]), 1);
        add_fiber(&r, from[i], to[i]);
        assert_ok(measure(&r));
        assert_near(r.a.tendon_share, truth[i], tolerance[i]);
        rig_end(&r);
    }
}

/* Far from the origin, turned and told in another order the same comes out. */
static void the_place_does_not_matter(void **state) {
    (void)state;
    const tendinous shape = {{50, 50}, 100, 2.4, 12};
    double share[2], pennation[2];
    for (int moved = 0; moved < 2; moved++) {
        rig r = tendinous_rig(&shape, 80, 24);
        sn_quat turn = sn_quat_axis_angle(sn_normalize(sn_v3(1, 2, 3)), 1.0);
        sn_rigid place = moved ? (sn_rigid){turn, {1e4, -2e4, 3e4}} : sn_rigid_identity();
        for (sn_index v = 0; v < r.muscle.mesh.vertex_count; v++)
            r.muscle.mesh.positions[v] = sn_rigid_apply(place, r.muscle.mesh.positions[v]);
        for (sn_index i = 0; i < 16; i++)
            for (sn_index k = 0; k < POINTS; k++)
                r.muscle.fibers.polylines[i].points[k] = sn_rigid_apply(place, r.muscle.fibers.polylines[i].points[k]);
        assert_ok(measure(&r));
        share[moved] = r.a.tendon_share;
        pennation[moved] = r.a.mean_pennation * DEGREES;
        rig_end(&r);
    }
    assert_near(share[0], share[1], 0.01);
    assert_near(pennation[0], pennation[1], 0.5);
}

/* ---- tendons by paint and by hand --------------------------------------------------------------------------------------------------- */

static double *paint(rig *r, sn_index components) {
    sn_attribute *a = sn_mesh_add_attribute(&r->muscle.mesh, SN_TENDON_ATTRIBUTE, components);
    if (a == NULL) abort();
    r->params.tendon = SN_TENDON_PAINTED;
    return a->values;
}

static void painted_tendon_counts(void **state) {
    (void)state;
    rig r = strap_rig(&STRAP);
    double *map = paint(&r, 1);
    for (sn_index v = 0; v < r.muscle.mesh.vertex_count; v++) map[v] = r.muscle.mesh.positions[v].z > 120.5 ? 1.0 : 0.0;
    assert_ok(measure(&r));
    assert_near(r.a.tendon_share, 0.25, 0.01);
    assert_near(r.a.tendon_volume, 0.25, 0.01);
    assert_near(r.a.belly_area, r.a.area, 0.02 * r.a.area); /* three quarters of the volume over three quarters of the length */
    for (sn_index v = 0; v < r.muscle.mesh.vertex_count; v++) assert_true(r.a.map[v] == map[v]);
    rig_end(&r);
}

static void a_painted_map_that_is_none_is_refused(void **state) {
    (void)state;
    const double wrong[] = {-0.01, 1.01, 255.0, NAN, INFINITY};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        rig r = strap_rig(&STRAP);
        paint(&r, 1)[7] = wrong[i];
        assert_int_equal(measure(&r), SN_ERROR_INPUT);
        assert_null(r.a.map);
        rig_end(&r);
    }
    rig r = strap_rig(&STRAP);
    r.params.tendon = SN_TENDON_PAINTED;
    assert_int_equal(measure(&r), SN_ERROR_INPUT); /* there is none */
    paint(&r, 3);
    assert_int_equal(measure(&r), SN_ERROR_INPUT); /* a colour */
    rig_end(&r);
}

static void tendons_by_hand_are_cut_off(void **state) {
    (void)state;
    rig r = strap_rig(&STRAP);
    r.params.tendon = SN_TENDON_GIVEN;
    r.params.ends[0] = (sn_tendon_end){0.1, true};
    r.params.ends[1] = (sn_tendon_end){40.0, false};
    assert_ok(measure(&r));
    assert_near(r.a.belly.mean, 160 * 0.9 - 40, 160.0 / 60);
    assert_near(r.a.tendon_volume, 0.1 + 0.25, 0.02);
    for (sn_index v = 0; v < r.muscle.mesh.vertex_count; v++) {
        double z = r.muscle.mesh.positions[v].z;
        assert_true(r.a.map[v] == (z < 16.0 || z > 120.0 ? 1.0 : 0.0));
    }
    sn_architecture_free(&r.a);
    r.params.ends[1].length = 500.0; /* nothing is left */
    assert_ok(measure(&r));
    assert_int_equal(r.a.belly_fibers, 0);
    assert_true(r.a.belly.mean == 0.0 && r.a.belly_area == 0.0 && r.a.tendon_share == 1.0);
    rig_end(&r);
}

static void wrong_parameters_are_refused(void **state) {
    (void)state;
    rig r = strap_rig(&STRAP);
    const sn_architecture_params good = r.params;
    const double wrong[] = {-1.0, NAN, INFINITY, 1.5};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        r.params = good;
        r.params.tendon = SN_TENDON_GIVEN;
        r.params.ends[i % 2] = (sn_tendon_end){wrong[i], true};
        assert_int_equal(measure(&r), SN_ERROR_USAGE);
        r.params = good;
        r.params.thin = wrong[i];
        assert_int_equal(measure(&r), SN_ERROR_USAGE);
    }
    r.params = good;
    r.params.slender = 0.0;
    assert_int_equal(measure(&r), SN_ERROR_USAGE);
    r.params = good;
    for (sn_index k = 0; k < POINTS; k++) r.muscle.fibers.polylines[4].points[k] = sn_v3(1, 1, 1);
    assert_int_equal(measure(&r), SN_ERROR_INPUT); /* a fibre without length */
    for (sn_index i = 0; i < 9; i++) free(r.muscle.fibers.polylines[i].points);
    r.muscle.fibers.polyline_count = 0;
    assert_int_equal(measure(&r), SN_ERROR_INPUT);
    rig_end(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_strap_has_the_area_of_its_section),
        cmocka_unit_test(a_pennate_slab_has_its_angle_at_both_ends),
        cmocka_unit_test(the_ends_are_those_of_the_fibres),
        cmocka_unit_test(spreads_are_those_of_the_fibres),
        cmocka_unit_test(thin_ends_are_tendon_at_any_density),
        cmocka_unit_test(what_has_no_tendon_gets_none),
        cmocka_unit_test(where_a_muscle_splits_its_branches_share_the_belly),
        cmocka_unit_test(the_place_does_not_matter),
        cmocka_unit_test(painted_tendon_counts),
        cmocka_unit_test(a_painted_map_that_is_none_is_refused),
        cmocka_unit_test(tendons_by_hand_are_cut_off),
        cmocka_unit_test(wrong_parameters_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
