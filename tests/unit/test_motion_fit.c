/* test_motion_fit.c -- spheres against known ones, what a table means, and that a fit depends on how a motion moves, not on its rest pose.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sinew/io.h"
#include "sinew/numeric.h"

/* ---- spheres ------------------------------------------------------------------------------------------------------------------- */

enum { RINGS = 12, SECTORS = 16 };

/* A cap of a sphere of radius 1 about the origin: `share` of the way from the pole to the other one. */
static sn_mesh cap(double share) {
    sn_mesh mesh = {0};
    assert_int_equal(sn_mesh_alloc(&mesh, RINGS * SECTORS, 2 * (RINGS - 1) * SECTORS, NULL), SN_OK);
    sn_index t = 0;
    for (sn_index r = 0; r < RINGS; r++)
        for (sn_index s = 0; s < SECTORS; s++) {
            double a = SN_PI * share * (r + 0.5) / RINGS, b = 2.0 * SN_PI * s / SECTORS;
            mesh.positions[r * SECTORS + s] = sn_v3(sin(a) * cos(b), sin(a) * sin(b), cos(a));
            sn_index next = r * SECTORS + (s + 1) % SECTORS, here = r * SECTORS + s;
            if (r + 1 == RINGS) continue;
            mesh.triangles[t++] = (sn_triangle){{here, here + SECTORS, next}};
            mesh.triangles[t++] = (sn_triangle){{next, here + SECTORS, next + SECTORS}};
        }
    return mesh;
}

static sn_fit_patch patch_of(const sn_mesh *mesh) {
    return (sn_fit_patch){mesh->vertex_count, mesh->triangle_count, mesh->positions, mesh->triangles};
}

static void move(sn_mesh *mesh, double scale, sn_vec3 by) {
    for (sn_index i = 0; i < mesh->vertex_count; i++) mesh->positions[i] = sn_add(sn_scale(mesh->positions[i], scale), by);
}

/* In every unit, far from the origin too: to rounding. */
static void a_cap_gives_its_sphere(void **state) {
    (void)state;
    static const double scales[] = {1.0, 0.023, 23.0, 1e-5};
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++)
        for (double share = 0.2; share < 1.0; share += 0.3) {
            sn_mesh mesh = cap(share);
            sn_vec3 centre = sn_scale(sn_v3(-40, 3, 900), scales[k]);
            sn_fit_sphere found;
            move(&mesh, scales[k], centre);
            const sn_fit_patch patch = patch_of(&mesh);
            assert_int_equal(sn_fit_sphere_robust(&patch, &found, NULL), SN_OK);
            assert_true(sn_distance(found.centre, centre) < 1e-8 * scales[k]);
            assert_true(fabs(found.radius - scales[k]) < 1e-8 * scales[k]);
            assert_int_equal(found.used, RINGS * SECTORS);
            /* a cap to the angle a has (1 - cos a) / 2 of the area; facets and the missing pole take a little */
            double area = 0.5 * (1.0 - cos(SN_PI * share * (RINGS - 0.5) / RINGS));
            assert_true(found.coverage < area && found.coverage > 0.85 * area);
            sn_mesh_free(&mesh);
        }
}

/* The least squares of the distances themselves: the mean of the signed offsets is zero, which no algebraic fit has. */
static void noise_is_averaged_by_distance(void **state) {
    (void)state;
    sn_mesh mesh = cap(0.5);
    uint64_t seed = 7;
    sn_vec3 centre;
    double radius, sum = 0.0;
    for (sn_index i = 0; i < mesh.vertex_count; i++) mesh.positions[i] = sn_scale(mesh.positions[i], 1.0 + 0.1 * (sn_random(&seed) - 0.5));
    assert_true(sn_least_squares_sphere(mesh.vertex_count, mesh.positions, &centre, &radius));
    for (sn_index i = 0; i < mesh.vertex_count; i++) sum += sn_distance(mesh.positions[i], centre) - radius;
    assert_true(fabs(sum / mesh.vertex_count) < 1e-9);
    assert_true(sn_norm(centre) < 0.02 && fabs(radius - 1.0) < 0.02);
    sn_mesh_free(&mesh);
}

/* A neck: a tenth of the vertices lie off by a third of the radius; they are left out and do not move the centre. */
static void what_lies_off_is_left_out(void **state) {
    (void)state;
    sn_mesh mesh = cap(0.7);
    sn_fit_sphere found;
    for (sn_index i = 0; i < mesh.vertex_count; i += 10) mesh.positions[i] = sn_scale(mesh.positions[i], 1.0 + 0.3 * (1 + i % 3));
    const sn_fit_patch patch = patch_of(&mesh);
    assert_int_equal(sn_fit_sphere_robust(&patch, &found, NULL), SN_OK);
    assert_int_equal(found.used, mesh.vertex_count - (mesh.vertex_count + 9) / 10);
    assert_true(sn_norm(found.centre) < 1e-9 && fabs(found.radius - 1.0) < 1e-9);
    sn_mesh_free(&mesh);
}

static void assert_refused(const sn_fit_patch *patch, const char *why) {
    sn_fit_sphere found;
    sn_error error = {0};
    assert_int_equal(sn_fit_sphere_robust(patch, &found, &error), SN_ERROR_INPUT);
    if (strstr(error.text, why) == NULL) fail_msg("'%s' does not say '%s'", error.text, why);
}

static void what_is_no_sphere_is_refused(void **state) {
    (void)state;
    sn_mesh mesh = cap(0.9);
    sn_fit_patch patch = patch_of(&mesh);
    patch.point_count = 3;
    patch.triangle_count = 0;
    assert_refused(&patch, "3 vertices are too few");
    patch = patch_of(&mesh);
    patch.triangle_count = 0;
    assert_refused(&patch, "cover too little");
    for (sn_index i = 0; i < mesh.vertex_count; i++) mesh.positions[i].z *= 3.0; /* an egg */
    assert_refused(&patch, "no sphere");
    for (sn_index i = 0; i < mesh.vertex_count; i++) mesh.positions[i].z = 0.25; /* a disc */
    assert_refused(&patch, "lie flat");
    for (sn_index i = 0; i < mesh.vertex_count; i++) mesh.positions[i] = sn_v3(1, 2, 3); /* a point */
    assert_refused(&patch, "lie flat");
    sn_mesh_free(&mesh);
}

/* ---- tables ------------------------------------------------------------------------------------------------------------------- */

static sn_status parse(const char *text, sn_fit_table *table, sn_error *error) {
    sn_blob blob = {.name = (char[]){"t.tsv"}, .data = (char *)(uintptr_t)text, .size = strlen(text)};
    return sn_fit_table_parse(&blob, table, error);
}

static void patterns_match_as_they_should(void **state) {
    (void)state;
    static const struct {
        const char *pattern, *name;
        bool matches;
    } cases[] = {{"*", "", true},          {"*", "abc", true},     {"abc", "abc", true},    {"abc", "abcd", false}, {"a?c", "abc", true},
                 {"a?c", "ac", false},     {"*_b", "a_b_b", true}, {"*b*c", "abc", true},   {"*b*c", "acb", false}, {"", "a", false},
                 {"a*b*a", "abab", false}, {"a**", "a", true},     {"Left*", "left", false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(sn_fit_matches(cases[i].pattern, cases[i].name), cases[i].matches);
    /* as many stars as a line holds must not take a power of its length */
    char pattern[2001] = "", name[2001] = "";
    for (int i = 0; i < 1000; i++) memcpy(pattern + 2 * i, "*a", 2);
    memset(name, 'a', 2000);
    pattern[1999] = 'b';
    assert_false(sn_fit_matches(pattern, name));
}

static void sides_stand_for_two_rows(void **state) {
    (void)state;
    sn_fit_table t;
    assert_int_equal(
        parse("units\tcm\njoint\tfoot_{side}\thip_{side}\t{S}foot\tpoint {+}10,0,{-}2\njoint\thip_{side}\tpelvis\t{s}hip\tpoint 0,0,1\n"
              "joint\tpelvis\t-\troot\tpoint 0,0,0\nbone\t{Side}*\thip_{side}\nbone\t*\tpelvis\tin\n",
              &t, NULL),
        SN_OK);
    static const char *const names[] = {"pelvis", "hip_left", "hip_right", "foot_left", "foot_right"};
    assert_int_equal(t.joint_count, 5);
    for (sn_index j = 0; j < 5; j++) assert_string_equal(t.points[j].name, names[j]);
    assert_int_equal(t.joints[4].parent, 2);
    assert_string_equal(t.points[4].source, "Rfoot");
    assert_true(sn_distance(t.points[4].rule.point, sn_v3(-0.1, 0, 0.02)) < 1e-15);
    assert_true(sn_distance(t.points[3].rule.point, sn_v3(0.1, 0, -0.02)) < 1e-15);
    assert_int_equal(t.bones[sn_fit_table_row(&t, "Right_femur")].joint, 2);
    assert_int_equal(t.bones[sn_fit_table_row(&t, "Sacrum")].joint, 0);
    assert_true(t.bones[2].meters_per_unit == 0.0254);
    sn_fit_table_free(&t);
}

static void bad_tables_name_their_line(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
        int64_t line;
    } cases[] = {
        {"", "no row \"joint\"", 0},
        {"joint\ta\t-\tr\tpoint 0,0,0\n", "no row \"bone\"", 0},
        {"joint\ta\tb\tr\tpoint 0,0,0\njoint\tb\ta\tr\tpoint 0,0,0\njoint\tr\t-\tr\tpoint 0,0,0\nbone\t*\ta\n", "circle", 1},
        {"joint\ta\ta\tr\tpoint 0,0,0\nbone\t*\ta\n", "circle", 1},
        {"joint\ta\t-\tr\tpoint 0,0,0\n\njoint\ta\t-\tr\tpoint 0,0,0\nbone\t*\ta\n", "already the name of line 1", 3},
        {"joint\ta\t-\tr\tpoint 0,0,0\njoint\tb\t-\tr\tpoint 0,0,0\nbone\t*\ta\n", "has no parent", 2},
        {"joint\ta\t-\t-\tpoint 0,0,0\nbone\t*\ta\n", "neither a parent nor a source", 1},
        {"joint\ta\t-\tr\tpoint 0,0\nbone\t*\ta\n", "is no point", 1},
        {"joint\ta\t-\tr\tpoint 0,0,nan\nbone\t*\ta\n", "is no point", 1},
        {"joint\ta\t-\tr\tcentre 0,0,0\nbone\t*\ta\n", "is no rule", 1},
        {"joint\ta\t-\tr\tsphere\nbone\t*\ta\n", "needs a selection", 1},
        {"joint\ta\t-\tr\taxis f\nbone\t*\ta\n", "needs two selections", 1},
        {"joint\ta\t-\tr\tmean f g\nbone\t*\ta\n", "too much", 1},
        {"joint\ta\t-\tr\tmean f@ball:0,0,0,-1\nbone\t*\ta\n", "is no region", 1},
        {"joint\ta\t-\tr\tmean f@far:0,0,0,1\nbone\t*\ta\n", "no length", 1},
        {"joint\ta\t-\tr\tpoint 0,0,0\nbone\t*\tb\n", "names the joint \"b\"", 2},
        {"joint\ta\t-\tr\tpoint 0,0,0\tz\nbone\t*\ta\n", "names the joint or place \"z\"", 1},
        {"joint\ta\t-\tr\tpoint 0,0,0\ta>a\nbone\t*\ta\n", "to itself", 1},
        {"joint\ta\t-\tr\tpoint 0,0,0\t-\ta\nbone\t*\ta\n", "aside", 1},
        {"joint\ta\t-\tr\tpoint 0,0,0\nbone\t*\ta\tmiles\n", "is no unit", 2},
        {"units\tmm\nunits\tmm\n", "told before", 2},
        {"joint\ta_{Seite}\t-\tr\tpoint 0,0,0\n", "braces", 1},
        {"bones\t*\ta\n", "no kind of row", 1},
        {"bone\t*\n", "has, with tabs", 1},
        {"bone\t\ta\n", "is empty", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sn_fit_table t;
        sn_error error = {0};
        assert_int_equal(parse(cases[i].text, &t, &error), SN_ERROR_INPUT);
        if (strstr(error.text, cases[i].says) == NULL || error.line != cases[i].line || strcmp(error.file, "t.tsv") != 0)
            fail_msg("case %zu: %s:%lld: %s", i, error.file, (long long)error.line, error.text);
        assert_null(t.points);
    }
}

/* ---- fits --------------------------------------------------------------------------------------------------------------------- */

enum { FRAMES = 30, JOINTS = 5 };

/* A trunk with two legs of two joints; ends tell where the last segments end. */
static const char *const names[JOINTS] = {"trunk", "lhip", "lknee", "rhip", "rknee"};
static const sn_index parents[JOINTS] = {SN_NONE, 0, 1, 0, 3};
static const sn_vec3 rests[JOINTS] = {{0, 0, 1}, {0.1, 0, 0.9}, {0.12, -0.02, 0.5}, {-0.1, 0, 0.9}, {-0.11, -0.03, 0.5}};
static const sn_vec3 ends[JOINTS] = {{0, 0.05, 1.5}, {0, 0, 0}, {0.13, 0, 0.05}, {0, 0, 0}, {-0.1, 0.01, 0.05}};

static const char table_text[] =
    "joint\ttrunk\t-\ttrunk\tpoint 0,0,1\thead\tlhip\njoint\tlhip\ttrunk\tlhip\tpoint 0.1,0,0.9\tlknee\trhip\n"
    "joint\tlknee\tlhip\tlknee\tpoint 0.12,-0.02,0.5\tlankle\trhip\njoint\trhip\ttrunk\trhip\tpoint -0.1,0,0.9\trknee\tlhip\n"
    "joint\trknee\trhip\trknee\tpoint -0.11,-0.03,0.5\trankle\tlhip\n"
    "place\thead\ttrunk.end\tpoint 0,0.05,1.5\nplace\tlankle\tlknee.end\tpoint 0.13,0,0.05\n"
    "place\trankle\trknee.end\tpoint -0.1,0.01,0.05\nbone\t*\ttrunk\nleg\tlhip\tlknee\tlknee\n";

static sn_quat some_turn(uint64_t *seed) {
    sn_quat q = {sn_random(seed) - 0.5, sn_random(seed) - 0.5, sn_random(seed) - 0.5, sn_random(seed) - 0.5};
    return sn_quat_normalize(q);
}

/* Joints that turn about their centres at random and slowly, the root on its way. */
static sn_clip random_motion(uint64_t seed) {
    sn_clip clip;
    assert_int_equal(sn_clip_create(FRAMES, JOINTS, 0, &clip, NULL), SN_OK);
    clip.rate = 24.0;
    clip.format = "test";
    for (sn_index j = 0; j < JOINTS; j++) {
        sn_quat goal = some_turn(&seed);
        clip.joints[j].name = sn_strdup(names[j]);
        clip.joints[j].parent = parents[j];
        clip.joints[j].rest = rests[j];
        clip.joints[j].has_end = sn_norm2(ends[j]) > 0.0;
        clip.joints[j].end = ends[j];
        for (sn_index f = 0; f < FRAMES; f++)
            clip.joints[j].poses[f] = (sn_rigid){sn_quat_slerp(sn_quat_identity(), goal, (double)f / FRAMES),
                                                 j == 0 ? sn_v3(0.1 * f, 0.01 * f * f, 0.02 * f) : sn_v3(0, 0, 0)};
    }
    sn_clip_to_world(&clip);
    return clip;
}

/* The same motion told from another rest pose: turns (JOINTS) is what each segment has been turned by, world. */
static void retell(sn_clip *clip, const sn_quat *turns) {
    sn_vec3 centres[JOINTS];
    sn_rigid away[JOINTS];
    for (sn_index j = 0; j < JOINTS; j++) {
        sn_clip_joint *joint = &clip->joints[j];
        sn_vec3 arm = joint->parent != SN_NONE ? sn_sub(joint->rest, clip->joints[joint->parent].rest) : sn_v3(0, 0, 0);
        centres[j] = joint->parent != SN_NONE ? sn_add(centres[joint->parent], sn_quat_rotate(turns[joint->parent], arm)) : joint->rest;
        away[j] = (sn_rigid){turns[j], sn_sub(centres[j], sn_quat_rotate(turns[j], joint->rest))};
    }
    for (sn_index j = 0; j < JOINTS; j++) {
        sn_clip_joint *joint = &clip->joints[j];
        for (sn_index f = 0; f < FRAMES; f++) {
            joint->poses[f] = sn_rigid_compose(joint->poses[f], sn_rigid_inverse(away[j]));
            joint->poses[f].rotation = sn_quat_normalize(joint->poses[f].rotation);
        }
        joint->end = sn_rigid_apply(away[j], joint->end);
    }
    for (sn_index j = 0; j < JOINTS; j++) clip->joints[j].rest = centres[j];
}

typedef struct fitted {
    sn_fit_table table;
    sn_mesh bone;
    sn_fit_body body;
    sn_fit_result result;
} fitted;

static fitted fit_to(const char *text, const sn_clip *source, bool align) {
    fitted f = {.bone = cap(0.9)};
    const sn_fit_params params = {.align = align, .scale = 0.0, .ground = false};
    sn_error error = {0};
    if (parse(text, &f.table, &error) != SN_OK) fail_msg("%s", error.text);
    const sn_fit_bone bone = {.name = "bone", .path = "bone.obj", .mesh = &f.bone, .meters_per_unit = 1.0};
    if (sn_fit_body_create(&f.table, 1, &bone, &f.body, &error) != SN_OK) fail_msg("%s", error.text);
    if (sn_motion_fit(&f.body, source, &params, &f.result, &error) != SN_OK) fail_msg("%s", error.text);
    return f;
}

static void free_fitted(fitted *f) {
    sn_fit_result_free(&f->result);
    sn_fit_body_free(&f->body);
    sn_fit_table_free(&f->table);
    sn_mesh_free(&f->bone);
}

static double pose_difference(sn_rigid a, sn_rigid b, sn_vec3 at) {
    double away = sn_distance(sn_rigid_apply(a, at), sn_rigid_apply(b, at));
    return fmax(away, 1.0 - fabs(sn_quat_dot(a.rotation, b.rotation)));
}

static double clip_difference(const sn_clip *a, const sn_clip *b) {
    double most = 0.0;
    for (sn_index j = 0; j < JOINTS; j++)
        for (sn_index f = 0; f < FRAMES; f++)
            most = fmax(most, pose_difference(a->joints[j].poses[f], b->joints[j].poses[f], a->joints[j].rest));
    return most;
}

/* A body that is the source itself moves as the source does. */
static void the_source_fits_itself(void **state) {
    (void)state;
    sn_clip source = random_motion(3);
    for (int align = 0; align < 2; align++) {
        fitted f = fit_to(table_text, &source, align == 1);
        assert_true(fabs(f.result.scale - 1.0) < 1e-12);
        assert_true(clip_difference(&f.result.clip, &source) < 1e-12);
        free_fitted(&f);
    }
    sn_clip_free(&source);
}

/* The source's rest pose turned at random as a whole, so that it faces elsewhere and lies down: directions aside tell all of that. */
static void any_rest_pose_gives_the_same_motion(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        uint64_t random = seed;
        sn_clip source = random_motion(seed), told = random_motion(seed);
        sn_quat turns[JOINTS];
        sn_quat whole = some_turn(&random);
        for (sn_index j = 0; j < JOINTS; j++) turns[j] = whole;
        retell(&told, turns);
        fitted f = fit_to(table_text, &told, true);
        assert_true(clip_difference(&f.result.clip, &source) < 1e-11);
        free_fitted(&f);
        sn_clip_free(&told);
        sn_clip_free(&source);
    }
}

/* Segments turned by the least rotation away from the body's (T pose, A pose), and the whole by any: the legs need no direction aside. */
static void least_turns_are_undone(void **state) {
    (void)state;
    static const char plain[] =
        "joint\ttrunk\t-\ttrunk\tpoint 0,0,1\thead\tlhip\njoint\tlhip\ttrunk\tlhip\tpoint 0.1,0,0.9\njoint\tlknee\tlhip\tlknee\tpoint "
        "0.12,-0.02,0.5\tlankle\njoint\trhip\ttrunk\trhip\tpoint -0.1,0,0.9\njoint\trknee\trhip\trknee\tpoint "
        "-0.11,-0.03,0.5\trankle\nplace\thead\ttrunk.end\tpoint 0,0.05,1.5\nplace\tlankle\tlknee.end\tpoint 0.13,0,0.05\n"
        "place\trankle\trknee.end\tpoint -0.1,0.01,0.05\nbone\t*\ttrunk\n";
    for (uint64_t seed = 1; seed <= 20; seed++) {
        uint64_t random = seed;
        sn_clip source = random_motion(seed), told = random_motion(seed);
        sn_quat turns[JOINTS] = {{1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
        for (sn_index hip = 1; hip <= 3; hip += 2) {
            sn_vec3 segment = sn_normalize(sn_sub(rests[hip + 1], rests[hip]));
            sn_vec3 across = sn_normalize(sn_cross(segment, sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, 0.3)));
            turns[hip] = turns[hip + 1] = sn_quat_axis_angle(across, 2.0 * sn_random(&random));
        }
        sn_quat whole = some_turn(&random);
        for (sn_index j = 0; j < JOINTS; j++) turns[j] = sn_quat_multiply(whole, turns[j]);
        retell(&told, turns);
        fitted f = fit_to(plain, &told, true);
        assert_true(clip_difference(&f.result.clip, &source) < 1e-11);
        free_fitted(&f);
        f = fit_to(plain, &told, false); /* and not by itself */
        assert_true(clip_difference(&f.result.clip, &source) > 1e-3);
        free_fitted(&f);
        sn_clip_free(&told);
        sn_clip_free(&source);
    }
}

/* Another body: joints stay together, segments point as the source's do, and the hip's way is scaled by the legs. */
static void another_body_keeps_directions_and_joints(void **state) {
    (void)state;
    static const char body[] =
        "units\tcm\njoint\ttrunk\t-\ttrunk\tpoint 5,0,60\thead\tlhip\njoint\tlhip\ttrunk\tlhip\tpoint "
        "9,1,50\tlknee\njoint\tlknee\tlhip\tlknee\t"
        "point 9,0,20\tlankle\njoint\trhip\ttrunk\trhip\tpoint -1,0,50\trknee\njoint\trknee\trhip\trknee\tpoint -2,0,21\trankle\n"
        "place\thead\ttrunk.end\tpoint 5,3,90\nplace\tlankle\tlknee.end\tpoint 9,0,2\nplace\trankle\trknee.end\tpoint -1,1,1\n"
        "bone\t*\ttrunk\nleg\tlhip\tlknee\tlknee\n";
    sn_clip source = random_motion(11);
    fitted f = fit_to(body, &source, true);
    const sn_clip *clip = &f.result.clip;
    assert_true(fabs(f.result.scale - sn_norm(sn_v3(0, 0.01, 0.3)) / sn_distance(rests[1], rests[2])) < 1e-12);
    for (sn_index k = 0; k < FRAMES; k++) {
        for (sn_index j = 1; j < JOINTS; j++) {
            const sn_clip_joint *joint = &clip->joints[j];
            assert_true(sn_distance(sn_rigid_apply(joint->poses[k], joint->rest),
                                    sn_rigid_apply(clip->joints[joint->parent].poses[k], joint->rest)) < 1e-14);
        }
        for (sn_index j = 0; j < JOINTS; j++) {
            sn_index next = j == 1 || j == 3 ? j + 1 : SN_NONE;
            sn_vec3 own_end = next != SN_NONE ? clip->joints[next].rest : clip->joints[j].end,
                    end = next != SN_NONE ? rests[next] : ends[j];
            sn_vec3 own = sn_quat_rotate(clip->joints[j].poses[k].rotation, sn_normalize(sn_sub(own_end, clip->joints[j].rest)));
            assert_true(sn_distance(own, sn_quat_rotate(source.joints[j].poses[k].rotation, sn_normalize(sn_sub(end, rests[j])))) < 1e-12);
        }
        sn_vec3 hip = sn_rigid_apply(clip->joints[1].poses[k], clip->joints[1].rest);
        assert_true(sn_distance(hip, sn_scale(sn_rigid_apply(source.joints[1].poses[k], rests[1]), f.result.scale)) < 1e-14);
    }
    free_fitted(&f);
    sn_clip_free(&source);
}

static void a_source_that_lacks_a_joint_is_refused(void **state) {
    (void)state;
    sn_clip source = random_motion(1);
    sn_fit_table table;
    sn_mesh mesh = cap(0.9);
    sn_fit_body body;
    sn_fit_result result;
    sn_error error = {0};
    const sn_fit_bone bone = {.name = "bone", .path = "bone.obj", .mesh = &mesh, .meters_per_unit = 1.0};
    assert_int_equal(parse("joint\ta\t-\tHips|pelvis\tpoint 0,0,0\t-\nbone\t*\ta\n", &table, NULL), SN_OK);
    assert_int_equal(sn_fit_body_create(&table, 1, &bone, &body, NULL), SN_OK);
    assert_int_equal(sn_motion_fit(&body, &source, &SN_FIT_DEFAULTS, &result, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "Hips|pelvis"));
    assert_null(result.clip.joints);
    sn_fit_body_free(&body);
    sn_fit_table_free(&table);
    sn_mesh_free(&mesh);
    sn_clip_free(&source);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cap_gives_its_sphere),
        cmocka_unit_test(noise_is_averaged_by_distance),
        cmocka_unit_test(what_lies_off_is_left_out),
        cmocka_unit_test(what_is_no_sphere_is_refused),
        cmocka_unit_test(patterns_match_as_they_should),
        cmocka_unit_test(sides_stand_for_two_rows),
        cmocka_unit_test(bad_tables_name_their_line),
        cmocka_unit_test(the_source_fits_itself),
        cmocka_unit_test(any_rest_pose_gives_the_same_motion),
        cmocka_unit_test(least_turns_are_undone),
        cmocka_unit_test(another_body_keeps_directions_and_joints),
        cmocka_unit_test(a_source_that_lacks_a_joint_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
