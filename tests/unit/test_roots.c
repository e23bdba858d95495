/* Roots: the ring around the middle on shapes where it is known, and every manual selector. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "rig_shapes.h"
#include "sinew/rig.h"

static sn_roots select_roots(sn_muscle *m, const sn_roots_params *params, sn_roots_report *report) {
    sn_roots roots;
    sn_error error = {0};
    if (sn_roots_select(m, params, NULL, &roots, report, &error)) fail_msg("%s", error.text);
    return roots;
}

static sn_roots automatic(sn_muscle *m, sn_roots_report *report) {
    sn_roots_params params = sn_roots_defaults();
    return select_roots(m, &params, report);
}

static sn_roots by_hand(sn_muscle *m, sn_selector selector, sn_roots_report *report) {
    return select_roots(m, &(sn_roots_params){.selector = selector}, report);
}

static sn_status try_by_hand(const sn_muscle *m, sn_selector selector, sn_error *error) {
    sn_roots roots;
    return sn_roots_select(m, &(sn_roots_params){.selector = selector}, NULL, &roots, NULL, error);
}

/* ---- automatic -------------------------------------------------------------------------------------------------------------- */

static void a_spindle_is_cut_at_its_middle_ring(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 12 };
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03)};
    sn_roots_report report;
    sn_roots roots = automatic(&m, &report);
    assert_int_equal(roots.count, SECTORS);
    assert_string_equal(roots.rule, "mid-section");
    sn_index first = 1 + (RINGS / 2) * SECTORS; /* lowest vertex of the middle ring, then its lower neighbour, round to the higher one */
    for (sn_index i = 0; i < SECTORS; i++) assert_int_equal(roots.vertices[i], first + i);
    assert_true(report.ring && report.parts == 2 && !report.fallback && report.ends.source == SN_ENDS_TIPS);
    assert_true(report.centroid_offset < 1e-9 && report.genus == 0.0 && report.components == 1);
    assert_true(report.length > 0.2 && report.length < 0.25);
    sn_roots_free(&roots);
    sn_muscle_free(&m);
}

static void a_fork_is_separated_too(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = blocks(two_prongs)};
    sn_roots_report report;
    sn_roots roots = automatic(&m, &report);
    assert_true(report.ring && report.parts == 2);
    assert_true(report.centroid_offset < 0.1 * report.length);
    sn_roots_free(&roots);
    sn_muscle_free(&m);
}

static void scale_does_not_matter(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = blocks(two_prongs)};
    sn_roots small = automatic(&m, NULL);
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) m.mesh.positions[v] = sn_scale(m.mesh.positions[v], 1024.0);
    sn_roots large = automatic(&m, NULL);
    assert_int_equal(small.count, large.count);
    assert_memory_equal(small.vertices, large.vertices, (size_t)small.count * sizeof(sn_index));
    sn_roots_free(&small);
    sn_roots_free(&large);
    sn_muscle_free(&m);
}

static sn_attachment attach_at(const char *bone, sn_index vertex) {
    sn_attachment a = {.bone = sn_strdup(bone), .method = sn_strdup("pin"), .count = 1, .vertices = SN_NEW(sn_index, 1)};
    a.vertices[0] = vertex;
    return a;
}

/* How far along z the vertices lie from each other. */
static double height_of(const sn_muscle *m, const sn_roots *roots) {
    double low = INFINITY, high = -INFINITY;
    for (sn_index i = 0; i < roots->count; i++) {
        low = fmin(low, m->mesh.positions[roots->vertices[i]].z);
        high = fmax(high, m->mesh.positions[roots->vertices[i]].z);
    }
    return high - low;
}

static sn_muscle pinned_spindle(sn_index rings, sn_index sectors, sn_index count, const sn_index *pins) {
    static const char *const bones[] = {"radius", "humerus", "ulna"};
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(rings, sectors, 0.2, 0.03), .has_attachments = true, .attachment_count = count};
    m.attachments = SN_NEW(sn_attachment, count);
    for (sn_index i = 0; i < count; i++) m.attachments[i] = attach_at(bones[i], pins[i]);
    return m;
}

/* Pins at both ends are the ends, whatever the order of their bones: two at one end are one end. */
static void attachments_are_the_ends_where_they_are_at_both(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 12, TOP = 1 + (RINGS - 2) * SECTORS };
    const sn_index pins[] = {TOP, 3, TOP + SECTORS / 2}, other[] = {TOP + SECTORS / 2, TOP, 3};
    sn_muscle m = pinned_spindle(RINGS, SECTORS, 3, pins), turned = pinned_spindle(RINGS, SECTORS, 3, other);
    sn_roots_report report, turned_report;
    sn_roots roots = automatic(&m, &report), same = automatic(&turned, &turned_report);
    assert_true(report.ends.source == SN_ENDS_PINS && report.ends.known[0] && report.ends.known[1] && !report.ends.unused);
    assert_true(report.ends.patches[0] == 1 && report.ends.patches[1] == 2); /* the end at 0 has the lowest vertex */
    assert_true(report.right && !report.fallback && report.span < 0.1 && height_of(&m, &roots) < 0.02);
    assert_true(turned_report.ends.patches[0] == 1 && turned_report.ends.patches[1] == 2);
    assert_int_equal(roots.count, same.count);
    assert_memory_equal(roots.vertices, same.vertices, (size_t)roots.count * sizeof(sn_index));
    sn_roots_free(&roots);
    sn_roots_free(&same);
    sn_muscle_free(&m);
    sn_muscle_free(&turned);
}

/* Two bones near the same end, or one: the other end is the tip, and the ring runs around the muscle. */
static void attachments_at_one_end_leave_the_other_to_its_tip(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 12, TOP = 1 + (RINGS - 2) * SECTORS };
    const sn_index pins[] = {TOP, TOP + SECTORS / 2};
    for (sn_index count = 1; count <= 2; count++) {
        sn_muscle m = pinned_spindle(RINGS, SECTORS, count, pins);
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_true(report.ends.source == SN_ENDS_PINS && report.ends.known[0] && !report.ends.known[1] && report.ends.unused);
        assert_non_null(strstr(report.ends.why, count == 1 ? "one only" : "all lie at one end"));
        assert_true(report.right && roots.count == SECTORS && height_of(&m, &roots) < 1e-9);
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* Contact that holds a speck of each end is not trusted, and why is said; a compact patch at each end is. */
static void found_attachments_must_be_trusted(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 12, TOP = 1 + (RINGS - 2) * SECTORS };
    for (int compact = 0; compact < 2; compact++) {
        sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        for (int k = 0; k < 2; k++) {
            sn_index count = compact ? 3 * SECTORS : 4, first = k == 0 ? 1 : TOP - 3 * SECTORS;
            m.attachments[k] = (sn_attachment){
                .bone = sn_strdup(k ? "a" : "b"), .method = sn_strdup("contact"), .count = count, .vertices = SN_NEW(sn_index, count)};
            for (sn_index i = 0; i < count; i++) m.attachments[k].vertices[i] = first + (compact ? i : 2 * i);
        }
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, compact ? SN_ENDS_ATTACHMENTS : SN_ENDS_TIPS);
        assert_true(!report.ends.unused && report.right);
        if (!compact) assert_non_null(strstr(report.ends.why, "scattered"));
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* Vertices of a spindle's rings [first, last) and of every sector but each `gap`th, held by contact. */
static sn_attachment touch(const char *bone, sn_index sectors, sn_index first, sn_index last, sn_index gap) {
    sn_attachment a = {.bone = sn_strdup(bone), .method = sn_strdup("contact"), .vertices = SN_NEW(sn_index, sectors * (last - first))};
    for (sn_index v = 0; v < sectors * (last - first); v++)
        if (gap == 0 || v % sectors % gap != 0) a.vertices[a.count++] = 1 + first * sectors + v;
    return a;
}

/* One bone holds an end by three heads of like size: they are trusted, as specks of the same number of vertices are not. */
static void heads_of_like_size_are_trusted(void **state) {
    (void)state;
    enum { RINGS = 60, SECTORS = 24 };
    for (int specks = 0; specks < 2; specks++) {
        sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        m.attachments[0] = touch("rib", SECTORS, 3, 6, specks ? 2 : 8);
        m.attachments[1] = touch("scapula", SECTORS, RINGS - 5, RINGS - 1, 0);
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, specks ? SN_ENDS_TIPS : SN_ENDS_ATTACHMENTS);
        if (!specks) assert_true(report.ends.patches[0] == 3 && report.ends.patches[1] == 1 && report.right);
        if (specks) assert_non_null(strstr(report.ends.why, "scattered"));
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* Contact around the muscle at both ends of a stretch: the ends as long as little of the muscle lies beyond them, and why not is said. */
static void attachments_that_leave_much_beyond_them_are_no_ends(void **state) {
    (void)state;
    enum { RINGS = 60, SECTORS = 24 };
    for (sn_index from = 2; from <= 18; from += 8) {
        sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        m.attachments[0] = touch("a", SECTORS, from, from + 3, 0);
        m.attachments[1] = touch("b", SECTORS, RINGS - 4, RINGS - 1, 0);
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, from < 18 ? SN_ENDS_ATTACHMENTS : SN_ENDS_TIPS);
        if (from == 18) assert_non_null(strstr(report.ends.why, "beyond them"));
        assert_true(report.right && !report.between_tips);
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* The end that a document tells of contact is obeyed: the insertion may come first, and trust is not asked for. */
static void a_told_end_of_contact_is_obeyed(void **state) {
    (void)state;
    enum { RINGS = 60, SECTORS = 24 };
    for (int told = 0; told < 3; told++) { /* the far end of three is the origin; and, of both, the insertion */
        sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        m.attachments[0] = touch("a", SECTORS, told == 2 ? 20 : 2, told == 2 ? 23 : 5, 0);
        m.attachments[1] = touch("b", SECTORS, RINGS - 6, RINGS - 1, 0);
        m.attachments[1].end = SN_END_ORIGIN;
        if (told > 0) m.attachments[0].end = SN_END_INSERTION;
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, told > 0 ? SN_ENDS_AREAS : SN_ENDS_ATTACHMENTS);
        assert_true(report.ends.known[0] && report.ends.known[1] && report.right);
        sn_roots_free(&roots);
        sn_flow_params fp = sn_flow_defaults();
        sn_flow_report flow;
        sn_fibers fibers;
        fp.field = SN_FIELD_HARMONIC;
        assert_int_equal(sn_flow_fibers(&m, &fp, NULL, &fibers, &flow, NULL), SN_OK);
        assert_true(fibers.directions[1 + 30 * SECTORS].z < -0.5); /* from the origin on */
        sn_fibers_free(&fibers);
        sn_muscle_free(&m);
    }
}

/* Contact at the tips of both prongs, and of a tendon that passes the same bone further down: the prongs are one end, the stem's foot is
 * the other, and what passes is neither; whichever bone comes first. */
static void heads_on_one_bone_are_one_end(void **state) {
    (void)state;
    for (int order = 0; order < 2; order++) {
        sn_muscle m = {.meters_per_unit = 1, .mesh = blocks(two_prongs), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        for (int k = 0; k < 2; k++)
            m.attachments[k] = (sn_attachment){.bone = sn_strdup(k == order ? "above" : "below"),
                                               .method = sn_strdup("contact"),
                                               .vertices = SN_NEW(sn_index, m.mesh.vertex_count)};
        sn_box box = sn_mesh_box(&m.mesh);
        for (sn_index v = 0; v < m.mesh.vertex_count; v++) {
            sn_vec3 p = m.mesh.positions[v];
            bool tip = p.z > (p.x < 14.0 ? 31.0 : 35.0),
                 passes = p.y < 4.5 && p.z > box.low.z + 6.5 && p.z < box.low.z + 9.5 && p.x > 11.0 && p.x < 17.0;
            sn_attachment *a = &m.attachments[tip || passes ? order : 1 - order];
            if (tip || passes || p.z < box.low.z + 2.5) a->vertices[a->count++] = v;
        }
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, SN_ENDS_ATTACHMENTS);
        assert_int_equal(report.ends.patches[0] + report.ends.patches[1], 3);
        assert_true(report.ends.patches[0] != 0 && report.ends.patches[1] != 0 && report.right);
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* Two areas in the lower half of a muscle: both are ends if they are called so, in either order; else they are one end of it. */
static void areas_are_the_ends_that_they_are_called(void **state) {
    (void)state;
    enum { RINGS = 31, SECTORS = 12 };
    for (int called = 0; called < 3; called++) { /* not; the lower one the insertion; the origin */
        sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(RINGS, SECTORS, 0.2, 0.03), .has_attachments = true, .attachment_count = 2};
        m.attachments = SN_NEW(sn_attachment, 2);
        for (int k = 0; k < 2; k++) {
            sn_attachment *a = &m.attachments[k];
            *a = (sn_attachment){
                .bone = sn_strdup(k ? "a" : "b"), .method = sn_strdup("area"), .count = SECTORS, .vertices = SN_NEW(sn_index, SECTORS)};
            a->end = called == 0 ? SN_END_UNKNOWN : (called == 1) == (k == 0) ? SN_END_INSERTION : SN_END_ORIGIN;
            for (sn_index i = 0; i < SECTORS; i++) a->vertices[i] = 1 + (k ? 16 : 5) * SECTORS + i;
        }
        sn_roots_report report;
        sn_roots roots = automatic(&m, &report);
        assert_int_equal(report.ends.source, SN_ENDS_AREAS);
        assert_true(report.ends.known[0] && report.ends.known[1] == (called > 0));
        assert_int_equal(report.ends.patches[0], called > 0 ? 1 : 2);
        assert_int_equal(report.ends.patches[1], called > 0 ? 1 : 0);
        sn_roots_free(&roots);
        sn_muscle_free(&m);
    }
}

/* A section across a hoop has two curves and parts nothing; what is found is a ring around one end. */
static void a_hoop_is_reported_as_one(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = blocks(hoop)};
    sn_roots_report report;
    sn_roots roots = automatic(&m, &report);
    assert_true(report.genus == 1.0 && report.ring && roots.count >= 3);
    sn_roots_free(&roots);
    sn_muscle_free(&m);
}

static void the_largest_component_gets_the_ring(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = joined(spindle(5, 6, 1, 0.2), spindle(31, 12, 1, 0.2))};
    sn_roots_report report;
    sn_roots roots = automatic(&m, &report);
    assert_int_equal(report.components, 2);
    for (sn_index i = 0; i < roots.count; i++) assert_true(roots.vertices[i] >= 32);
    sn_roots_free(&roots);
    sn_muscle_free(&m);
}

static void an_open_sheet_is_an_error_that_helps(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1};
    sn_roots roots;
    sn_error error = {0};
    sn_roots_params params = sn_roots_defaults();
    assert_int_equal(sn_mesh_alloc(&m.mesh, 3, 1, NULL), SN_OK);
    m.mesh.positions[1] = sn_v3(1, 0, 0);
    m.mesh.positions[2] = sn_v3(0, 1, 0);
    m.mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
    assert_int_equal(sn_roots_select(&m, &params, NULL, &roots, NULL, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "mesh-clean"));
    assert_int_equal(roots.count, 0);
    sn_muscle_free(&m);
}

static void stopping_anywhere_leaves_all_or_nothing(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(15, 8, 0.2, 0.03)};
    sn_roots_params params = sn_roots_defaults();
    sn_roots whole = automatic(&m, NULL);
    sn_status status = SN_STOPPED;
    for (int64_t n = 0; status == SN_STOPPED; n++) {
        sn_trace trace = {.stop_after = n};
        sn_roots roots;
        status = sn_roots_select(&m, &params, &trace, &roots, NULL, NULL);
        assert_true(trace.steps <= n && n < 1000);
        assert_int_equal(roots.count, status == SN_STOPPED ? 0 : whole.count);
        sn_roots_free(&roots);
    }
    assert_int_equal(status, SN_OK);
    sn_roots_free(&whole);
    sn_muscle_free(&m);
}

/* ---- by hand ------------------------------------------------------------------------------------------------------------------ */

static void a_plane_gives_the_ring_of_the_nearest_section(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = blocks(two_prongs)};
    sn_roots_report report;
    sn_selector plane = {.kind = SN_SELECT_PLANE, .point = {10, 6, 30.5}, .other = {0, 0, 3}}; /* through both prongs, near the first */
    sn_roots roots = by_hand(&m, plane, &report);
    assert_true(report.ring && report.parts == 2);
    assert_string_equal(roots.rule, "plane");
    assert_int_equal(roots.count, 16); /* around 4 x 4 blocks */
    for (sn_index i = 0; i < roots.count; i++) {
        sn_vec3 p = m.mesh.positions[roots.vertices[i]];
        assert_true(p.z == 30.0 && p.x <= 12.0); /* on the side against the normal */
        assert_true(roots.vertices[i] >= roots.vertices[0]);
    }
    assert_true(roots.vertices[1] < roots.vertices[roots.count - 1]);
    sn_roots_free(&roots);
    sn_muscle_free(&m);
}

static void selectors_take_what_they_say(void **state) {
    (void)state;
    enum { SECTORS = 12 };
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(31, SECTORS, 0.2, 0.03)};
    sn_attribute *paint = sn_mesh_add_attribute(&m.mesh, "belly", 1);
    assert_non_null(paint);
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) paint->values[v] = fabs(m.mesh.positions[v].z) < 0.001;
    sn_roots_report report;
    const sn_index middle = 1 + 15 * SECTORS, last = m.mesh.vertex_count - 1;
    const struct {
        sn_selector selector;
        sn_index count, first;
        bool ring;
    } cases[] = {
        {{.kind = SN_SELECT_INDICES, .count = 4, .indices = (sn_index[]){9, 3, 9, 5}}, 3, 3, false},
        {{.kind = SN_SELECT_NEAR, .count = 1, .point = {0, 0, -1}}, 1, 0, false},
        {{.kind = SN_SELECT_NEAR, .count = 1 + SECTORS, .point = {0, 0, 1}}, 1 + SECTORS, last - SECTORS, false},
        {{.kind = SN_SELECT_SPHERE, .point = {0, 0, -0.1}, .radius = 1e-3}, 1, 0, false},
        {{.kind = SN_SELECT_BOX, .point = {-1, -1, -0.001}, .other = {1, 1, 0.001}}, SECTORS, middle, true},
        {{.kind = SN_SELECT_HALF, .point = {0, 0, 0.0999}, .other = {0, 0, 2}}, 1, last, false},
        {{.kind = SN_SELECT_PAINTED, .attribute = "belly", .threshold = 0.5}, SECTORS, middle, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_roots roots = by_hand(&m, cases[i].selector, &report);
        assert_int_equal(roots.count, cases[i].count);
        assert_int_equal(roots.vertices[0], cases[i].first);
        assert_int_equal(report.ring, cases[i].ring); /* a set that is one loop is put in ring order */
        assert_int_equal(report.parts, cases[i].ring ? 2 : 1);
        assert_true(isnan(report.level));
        sn_roots_free(&roots);
    }
    sn_muscle_free(&m);
}

static void bad_selections_are_named(void **state) {
    (void)state;
    sn_muscle m = {.meters_per_unit = 1, .mesh = spindle(5, 6, 0.2, 0.03)};
    sn_error error = {0};
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_INDICES, .count = 1, .indices = (sn_index[]){32}}, &error),
                     SN_ERROR_INPUT);
    assert_int_equal(error.element, 32);
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_SPHERE, .point = {9, 9, 9}, .radius = 1}, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "sphere"));
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_PLANE, .point = {9, 9, 9}, .other = {0, 0, 1}}, &error),
                     SN_ERROR_INPUT);
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_PLANE}, &error), SN_ERROR_USAGE);
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_PAINTED, .attribute = "red"}, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "\"red\""));
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_NEAR, .count = 33}, &error), SN_ERROR_INPUT);
    assert_int_equal(try_by_hand(&m, (sn_selector){.kind = SN_SELECT_NEAR, .count = 1, .point = {NAN, 0, 0}}, &error), SN_ERROR_USAGE);
    sn_muscle_free(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spindle_is_cut_at_its_middle_ring),
        cmocka_unit_test(a_fork_is_separated_too),
        cmocka_unit_test(scale_does_not_matter),
        cmocka_unit_test(attachments_are_the_ends_where_they_are_at_both),
        cmocka_unit_test(attachments_at_one_end_leave_the_other_to_its_tip),
        cmocka_unit_test(found_attachments_must_be_trusted),
        cmocka_unit_test(heads_of_like_size_are_trusted),
        cmocka_unit_test(attachments_that_leave_much_beyond_them_are_no_ends),
        cmocka_unit_test(a_told_end_of_contact_is_obeyed),
        cmocka_unit_test(areas_are_the_ends_that_they_are_called),
        cmocka_unit_test(heads_on_one_bone_are_one_end),
        cmocka_unit_test(a_hoop_is_reported_as_one),
        cmocka_unit_test(the_largest_component_gets_the_ring),
        cmocka_unit_test(an_open_sheet_is_an_error_that_helps),
        cmocka_unit_test(stopping_anywhere_leaves_all_or_nothing),
        cmocka_unit_test(a_plane_gives_the_ring_of_the_nearest_section),
        cmocka_unit_test(selectors_take_what_they_say),
        cmocka_unit_test(bad_selections_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
