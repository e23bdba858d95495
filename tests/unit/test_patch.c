/*
 * test_patch.c -- what bones hold by distance as areas: patches out of speckles, tendons that slide in a groove, tips that touch nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "shapes.h"
#include "sinew/rig.h"

enum { MOST_BONES = 4 };

typedef struct fixture {
    sn_muscle muscle;
    sn_mesh meshes[MOST_BONES];
    sn_attach_bone bones[MOST_BONES];
    sn_attach_params params;
    sn_attachment_list attachments;
    sn_attach_report report;
} fixture;

static int set_up(void **state) {
    fixture *f = SN_NEW(fixture, 1);
    f->muscle.meters_per_unit = 0.001;
    f->params = sn_attach_defaults();
    f->params.bones = f->bones;
    *state = f;
    return 0;
}

static void forget(fixture *f) {
    sn_attachments_free(f->attachments.items, f->attachments.count);
    sn_attach_report_free(&f->report);
    f->attachments = (sn_attachment_list){0};
}

static void clear(fixture *f) {
    forget(f);
    sn_mesh_free(&f->muscle.mesh);
    for (int i = 0; i < MOST_BONES; i++) sn_mesh_free(&f->meshes[i]);
    f->params.bone_count = 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    clear(f);
    free(f);
    return 0;
}

static sn_mesh box(sn_vec3 low, sn_vec3 high) {
    sn_mesh mesh = shape_cube();
    for (int i = 0; i < 8; i++) {
        sn_vec3 p = mesh.positions[i];
        mesh.positions[i] = sn_v3(p.x > 0 ? high.x : low.x, p.y > 0 ? high.y : low.y, p.z > 0 ? high.z : low.z);
    }
    return mesh;
}

static void add_bone(fixture *f, const char *name, sn_mesh mesh) {
    sn_index b = f->params.bone_count++;
    f->meshes[b] = mesh;
    f->bones[b] = (sn_attach_bone){name, &f->meshes[b], true};
}

static void detect(fixture *f, bool raw) {
    sn_error error = {0};
    forget(f);
    f->params.raw = raw;
    if (sn_attach_detect(&f->muscle, &f->params, NULL, &f->attachments, &f->report, &error) != SN_OK) fail_msg("%s", error.text);
}

static const sn_attachment *held_by(const fixture *f, const char *bone) {
    for (sn_index i = 0; i < f->attachments.count; i++)
        if (strcmp(f->attachments.items[i].bone, bone) == 0) return &f->attachments.items[i];
    return NULL;
}

/* Connected pieces, counted by the library's own judge of grips, not by what made them. */
static sn_index pieces_of(const fixture *f, const char *bone) {
    sn_grip grips[MOST_BONES];
    sn_muscle muscle = f->muscle;
    muscle.attachment_count = f->attachments.count;
    muscle.attachments = f->attachments.items;
    assert_int_equal(sn_muscle_grips(&muscle, grips, NULL), SN_OK);
    return grips[held_by(f, bone) - f->attachments.items].patches;
}

/* ---- speckles ---------------------------------------------------------------------------------------------------------------- */

/* A sheet of 40 x 30 mm that faces down, on a bone below z = 0: in a disc it touches but at one vertex of `gaps`; beside it lie crumbs. */
static const double DISC = 9.0;

static bool in_disc(sn_vec3 p) { return sn_distance(sn_v3(p.x, p.y, 0), sn_v3(20, 15, 0)) < DISC; }

static void make_sheet(fixture *f, double spacing, int gaps) {
    sn_index columns = (sn_index)(40 / spacing), rows = (sn_index)(30 / spacing);
    uint64_t random = 5;
    f->muscle.mesh = shape_empty((columns + 1) * (rows + 1), 2 * columns * rows);
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        sn_vec3 p = sn_v3(spacing * (v % (columns + 1)), spacing * (v / (columns + 1)), 0.9 * spacing);
        bool crumb = sn_random(&random) < 0.01 && !in_disc(p), gap = sn_random(&random) * gaps < 1.0;
        if (in_disc(p)) p.z = gap ? 0.4 * spacing : -0.1;
        if (crumb) p.z = -0.1;
        f->muscle.mesh.positions[v] = p;
    }
    for (sn_index q = 0; q < columns * rows; q++) {
        sn_index a = q / columns * (columns + 1) + q % columns, b = a + 1, c = a + columns + 1, d = c + 1;
        f->muscle.mesh.triangles[2 * q] = (sn_triangle){{a, d, b}};
        f->muscle.mesh.triangles[2 * q + 1] = (sn_triangle){{a, c, d}};
    }
}

static double overlap_with_disc(const fixture *f, const sn_attachment *a) {
    double both = 0, either = 0;
    sn_index next = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        bool held = next < a->count && a->vertices[next] == v, meant = in_disc(f->muscle.mesh.positions[v]);
        next += held;
        both += held && meant;
        either += held || meant;
    }
    return both / either;
}

static void speckles_become_one_patch(void **state) {
    fixture *f = *state;
    static const double spacings[3] = {2.0, 1.0, 0.5};
    for (int s = 0; s < 3; s++)
        for (int gaps = 3; gaps <= 12; gaps *= 2) {
            clear(f);
            make_sheet(f, spacings[s], gaps);
            add_bone(f, "bone", box(sn_v3(-10, -10, -20), sn_v3(50, 40, 0)));
            detect(f, true);
            sn_index raw_count = held_by(f, "bone")->count, raw_pieces = pieces_of(f, "bone");
            double raw_overlap = overlap_with_disc(f, held_by(f, "bone"));
            assert_true(raw_pieces >= 2);
            detect(f, false);
            const sn_attachment *a = held_by(f, "bone");
            const sn_attach_patch *p = &f->report.pairs[0].patch;
            assert_int_equal(pieces_of(f, "bone"), 1);
            assert_true(overlap_with_disc(f, a) > 0.85 && overlap_with_disc(f, a) > raw_overlap);
            assert_int_equal(p->pieces_before, raw_pieces);
            assert_int_equal(p->pieces, 1);
            assert_int_equal(p->holes, 0);
            assert_true(p->filled.vertices > 0 && p->filled.area > 0.0);
            assert_true(abs(a->count - (raw_count + p->filled.vertices - p->dropped.vertices)) <= p->moved.vertices);
            for (sn_index i = 0; i < a->count; i++)
                if (a->reasons[i] == SN_REASON_FILLED)
                    assert_true(a->confidence[i] > 0.0 && a->confidence[i] <= 0.25 && a->distances[i] > 0.0);
        }
}

/* Two areas of one bone, both large: none is a crumb, and the way between them is no hole. */
static void two_areas_stay_two(void **state) {
    fixture *f = *state;
    make_sheet(f, 1.0, 1000000);
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++) {
        sn_vec3 *p = &f->muscle.mesh.positions[v];
        p->z = p->x < 8.5 || p->x > 31.5 ? -0.1 : 3.0;
    }
    add_bone(f, "bone", box(sn_v3(-10, -10, -20), sn_v3(50, 40, 0)));
    detect(f, true);
    sn_index count = held_by(f, "bone")->count;
    detect(f, false);
    assert_int_equal(pieces_of(f, "bone"), 2);
    assert_int_equal(held_by(f, "bone")->count, count);
    assert_int_equal(f->report.pairs[0].patch.dropped.vertices, 0);
}

/* ---- a tendon in a groove ------------------------------------------------------------------------------------------------------ */

/* The radius of a muscle with a long tendon at its upper end, by the way along it, in mm. */
static double radius_at(double z) {
    if (z < 100) return 2.5;
    if (z < 140) return 2.5 + 17.5 * (0.5 - 0.5 * cos(SN_PI * (z - 100) / 40));
    if (z < 220) return 20;
    if (z < 270) return 3 + 17 * (0.5 + 0.5 * cos(SN_PI * (z - 220) / 50));
    return 3;
}

static sn_mesh make_tube(int around, double step) {
    sn_index rings = (sn_index)(300 / step) + 1, low = rings * around, high = low + 1;
    sn_mesh mesh = shape_empty(high + 1, 2 * around * rings);
    sn_index t = 0;
    for (sn_index r = 0; r < rings; r++)
        for (int i = 0; i < around; i++) {
            double angle = 2 * SN_PI * i / around, radius = radius_at(r * step);
            mesh.positions[r * around + i] = sn_v3(radius * cos(angle), radius * sin(angle), r * step);
        }
    mesh.positions[low] = sn_v3(0, 0, -1);
    mesh.positions[high] = sn_v3(0, 0, (rings - 1) * step + 1);
    for (int i = 0; i < around; i++) {
        sn_index j = (i + 1) % around, last = (rings - 1) * around;
        mesh.triangles[t++] = (sn_triangle){{low, j, i}};
        mesh.triangles[t++] = (sn_triangle){{high, last + i, last + j}};
        for (sn_index r = 0; r + 1 < rings; r++) {
            sn_index a = r * around + i, b = r * around + j, c = a + around, d = b + around;
            mesh.triangles[t++] = (sn_triangle){{a, b, d}};
            mesh.triangles[t++] = (sn_triangle){{a, d, c}};
        }
    }
    return mesh;
}

/* A groove along z: a floor and two walls that the tendon is pressed into. */
static sn_mesh make_groove(double z0, double z1) {
    sn_mesh floor = box(sn_v3(-20, -30, z0), sn_v3(20, -2.2, z1)), left = box(sn_v3(-20, -29, z0 + 1), sn_v3(-2.3, 1, z1 - 1)),
            right = box(sn_v3(2.3, -29, z0 + 1), sn_v3(20, 1, z1 - 1));
    sn_mesh half = shape_join(&floor, &left, 1, sn_v3(0, 0, 0)), all = shape_join(&half, &right, 1, sn_v3(0, 0, 0));
    sn_mesh_free(&floor), sn_mesh_free(&left), sn_mesh_free(&right), sn_mesh_free(&half);
    return all;
}

static void make_arm(fixture *f, int density, double groove) {
    clear(f);
    f->muscle.mesh = make_tube(12 * density, 4.0 / density);
    add_bone(f, "scapula", box(sn_v3(-20, -20, -20), sn_v3(20, 20, 4.5)));
    add_bone(f, "humerus", make_groove(groove, groove + 45));
    add_bone(f, "radius", box(sn_v3(-20, -20, 293), sn_v3(20, 20, 320)));
}

static void a_tendon_slides_in_its_groove_and_attaches_at_its_end(void **state) {
    fixture *f = *state;
    for (int density = 1; density <= 3; density++)
        for (int place = 25; place <= 45; place += 10) {
            make_arm(f, density, place);
            detect(f, true);
            assert_true(held_by(f, "humerus")->count > 20);
            detect(f, false);
            assert_null(held_by(f, "humerus"));
            assert_true(f->report.pairs[1].sliding && f->report.pairs[1].slid.vertices > 20 && f->report.pairs[1].vertices == 0);
            assert_false(f->report.pairs[0].sliding || f->report.pairs[2].sliding);
            assert_non_null(held_by(f, "radius"));
            const sn_attachment *end = held_by(f, "scapula");
            for (sn_index i = 0; i < end->count; i++) assert_true(f->muscle.mesh.positions[end->vertices[i]].z < 10);
        }
}

/* The bone with the groove holds the end as well, as the humerus of a radial extensor does: the end stays, the groove goes. */
static void of_one_bone_the_end_stays_and_the_groove_goes(void **state) {
    fixture *f = *state;
    make_arm(f, 2, 35);
    sn_mesh both = shape_join(&f->meshes[1], &f->meshes[0], 1, sn_v3(0, 0, 0));
    sn_mesh_free(&f->meshes[1]);
    f->meshes[1] = both;
    f->bones[0] = f->bones[1];
    f->bones[1] = f->bones[2];
    f->params.bone_count = 2;
    detect(f, false);
    const sn_attachment *end = held_by(f, "humerus");
    assert_true(f->report.pairs[0].sliding && f->report.pairs[0].slid.vertices > 20);
    assert_true(end != NULL && end->count > 10);
    for (sn_index i = 0; i < end->count; i++) assert_true(f->muscle.mesh.positions[end->vertices[i]].z < 10);
}

/* A bed along the tendon that begins at the very tip, with nothing held beyond: the bone that the tendon runs on to takes the tip; without
 * one the bed keeps its end, as long as it is wide. A bed along the belly stays. */
static void a_tendon_slides_in_its_bed_and_ends_on_the_next_bone(void **state) {
    fixture *f = *state;
    for (int density = 1; density <= 3; density++)
        for (int beyond = 0; beyond < 2; beyond++) {
            make_arm(f, density, 0.5);
            sn_mesh_free(&f->meshes[1]);
            f->meshes[1] = make_groove(0.5, 90);
            sn_mesh_free(&f->meshes[0]);
            f->meshes[0] = box(sn_v3(-20, -20, -60), sn_v3(20, 20, beyond ? -1.2 : -40));
            f->muscle.mesh.positions[f->muscle.mesh.vertex_count - 2].z = -1.1; /* the tip, 0.1 mm from the bone beyond */
            detect(f, true);
            const sn_attachment *bed = held_by(f, "humerus");
            assert_non_null(bed);
            double farthest = 0.0;
            for (sn_index i = 0; i < bed->count; i++) farthest = fmax(farthest, f->muscle.mesh.positions[bed->vertices[i]].z);
            assert_true(farthest > 80);
            detect(f, false);
            bed = held_by(f, "humerus");
            assert_true(f->report.pairs[1].sliding && f->report.pairs[1].slid.vertices > 20);
            assert_int_equal(f->report.pairs[0].tip, beyond);
            if (beyond) {
                assert_null(bed);
                assert_non_null(held_by(f, "scapula"));
            } else {
                assert_non_null(bed);
                for (sn_index i = 0; i < bed->count; i++) assert_true(f->muscle.mesh.positions[bed->vertices[i]].z < 30);
            }
            assert_false(f->report.pairs[2].sliding);
        }
}

/* A bone beside the slope from tendon to belly, between bones at both ends: with fibres from tip to tip, which pass it, it is let go, with
 * fibres that end at it, it stays; so it does without fibres. */
static void fibres_tell_where_a_muscle_passes(void **state) {
    fixture *f = *state;
    for (int fibers = 0; fibers < 3; fibers++) {
        make_arm(f, 3, 35);
        sn_mesh_free(&f->meshes[1]);
        f->meshes[1] = box(sn_v3(-20, -40, 98), sn_v3(20, -2.0, 108));
        sn_vec3 passing[2] = {{0, 0, 1}, {0, 0, 299}}, ending[2] = {{0, -3, 103}, {0, 0, 299}};
        sn_polyline lines[2] = {{.count = 2, .points = passing}, {.count = 2, .points = fibers == 2 ? ending : passing}};
        f->muscle.fibers.polyline_count = fibers == 0 ? 0 : 2;
        f->muscle.fibers.polylines = lines;
        detect(f, false);
        bool held = held_by(f, "humerus") != NULL, sliding = f->report.pairs[1].sliding;
        f->muscle.fibers = (sn_fibers){0};
        assert_int_equal(held, fibers != 1);
        assert_int_equal(sliding, fibers == 1);
    }
}

/* A bone along the belly, and a groove that nothing is held beyond, are attachments for all that is known. */
static void a_belly_on_a_bone_does_not_slide(void **state) {
    fixture *f = *state;
    make_arm(f, 2, 150);
    detect(f, false);
    assert_non_null(held_by(f, "humerus"));
    assert_false(f->report.pairs[1].sliding);
    make_arm(f, 2, 35);
    f->bones[0] = f->bones[1];
    f->bones[1] = f->bones[2];
    f->params.bone_count = 2;
    detect(f, false);
    assert_non_null(held_by(f, "humerus"));
}

/* What the user pinned to a bone stays. */
static void pins_do_not_slide(void **state) {
    fixture *f = *state;
    make_arm(f, 2, 35);
    sn_index pinned = 0;
    for (sn_index v = 0; v < f->muscle.mesh.vertex_count; v++)
        if (fabs(f->muscle.mesh.positions[v].z - 50) < 1.1 && f->muscle.mesh.positions[v].y < -2.3) pinned = v;
    sn_attach_pin pin = {.bone = "humerus", .selector = {.kind = SN_SELECT_INDICES, .count = 1, .indices = &pinned}};
    f->params.pin_count = 1;
    f->params.pins = &pin;
    detect(f, false);
    assert_true(held_by(f, "humerus")->count > 20);
    f->params.pin_count = 0;
}

/* ---- tips ---------------------------------------------------------------------------------------------------------------------- */

/* The tube, on the scapula, and a radius that its other end comes to within `gap` of. */
static void make_gap(fixture *f, double gap) {
    clear(f);
    f->muscle.mesh = make_tube(24, 2.0);
    add_bone(f, "scapula", box(sn_v3(-20, -20, -20), sn_v3(20, 20, 4.5)));
    add_bone(f, "radius", box(sn_v3(-20, -20, 301 + gap), sn_v3(20, 20, 340)));
}

static void a_tip_that_touches_nothing_is_taken_by_the_bone_it_runs_to(void **state) {
    fixture *f = *state;
    for (double gap = 3; gap < 14; gap += 5) {
        make_gap(f, gap);
        detect(f, true);
        assert_null(held_by(f, "radius"));
        detect(f, false);
        const sn_attachment *a = held_by(f, "radius");
        assert_non_null(a);
        assert_string_equal(a->method, "nearest");
        assert_true(f->report.pairs[1].tip && !f->report.pairs[0].tip && fabs(f->report.pairs[1].nearest - gap) < 1e-9);
        for (sn_index i = 0; i < a->count; i++) {
            assert_true(f->muscle.mesh.positions[a->vertices[i]].z > 290);
            assert_true(a->confidence[i] > 0.0 && a->confidence[i] <= 0.25);
        }
    }
    make_gap(f, 20); /* more than 5 % of its length */
    detect(f, false);
    assert_null(held_by(f, "radius"));
}

/* Two bones as near, a bone beside the belly, or contact alone: nothing is guessed. */
static void a_tip_that_runs_plainly_to_no_bone_is_left(void **state) {
    fixture *f = *state;
    make_gap(f, 5);
    add_bone(f, "ulna", box(sn_v3(-20, 6, 280), sn_v3(20, 20, 340)));
    detect(f, false);
    assert_null(held_by(f, "radius"));
    assert_null(held_by(f, "ulna"));
    make_gap(f, 5);
    f->params.methods = SN_ATTACH_CONTACT;
    detect(f, false);
    assert_null(held_by(f, "radius"));
    f->params.methods = sn_attach_defaults().methods;
    make_gap(f, 40);
    add_bone(f, "humerus", box(sn_v3(-20, -40, 150), sn_v3(20, -26, 220)));
    detect(f, false);
    assert_null(held_by(f, "humerus"));
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(speckles_become_one_patch),
        TEST(two_areas_stay_two),
        TEST(a_tendon_slides_in_its_groove_and_attaches_at_its_end),
        TEST(of_one_bone_the_end_stays_and_the_groove_goes),
        TEST(a_tendon_slides_in_its_bed_and_ends_on_the_next_bone),
        TEST(fibres_tell_where_a_muscle_passes),
        TEST(a_belly_on_a_bone_does_not_slide),
        TEST(pins_do_not_slide),
        TEST(a_tip_that_touches_nothing_is_taken_by_the_bone_it_runs_to),
        TEST(a_tip_that_runs_plainly_to_no_bone_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
