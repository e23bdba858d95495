/* test_view.c -- pictures: what is where, in which colour, the same on any number of threads, and nothing that breaks the renderer. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/view.h"

static const sn_color RED = {0.8, 0.1, 0.1}, BLUE = {0.1, 0.1, 0.9}, WHITE = {1, 1, 1};

/* ---- shapes --------------------------------------------------------------------------------------------------------------------- */

/* A closed ellipsoid of n rings and 2n sectors with half axes a (x), b (y), c (z). */
static sn_mesh ellipsoid(sn_index n, double a, double b, double c) {
    sn_mesh mesh = {0};
    sn_index sectors = 2 * n, t = 0;
    assert_int_equal(sn_mesh_alloc(&mesh, n * sectors + 2, 2 * n * sectors, NULL), SN_OK);
    for (sn_index i = 0; i < n * sectors; i++) {
        double polar = SN_PI * (i / sectors + 1) / (n + 1), turn = 2.0 * SN_PI * (i % sectors) / sectors;
        mesh.positions[i] = sn_v3(a * sin(polar) * cos(turn), b * sin(polar) * sin(turn), c * cos(polar));
    }
    sn_index north = n * sectors, south = north + 1;
    mesh.positions[north] = sn_v3(0, 0, c);
    mesh.positions[south] = sn_v3(0, 0, -c);
    for (sn_index s = 0; s < sectors; s++) {
        sn_index next = (s + 1) % sectors, last = (n - 1) * sectors;
        mesh.triangles[t++] = (sn_triangle){{north, s, next}};
        mesh.triangles[t++] = (sn_triangle){{south, last + next, last + s}};
        for (sn_index r = 0; r + 1 < n; r++) {
            mesh.triangles[t++] = (sn_triangle){{r * sectors + s, (r + 1) * sectors + s, (r + 1) * sectors + next}};
            mesh.triangles[t++] = (sn_triangle){{r * sectors + s, (r + 1) * sectors + next, r * sectors + next}};
        }
    }
    assert_int_equal(t, mesh.triangle_count);
    return mesh;
}

/* A muscle with every section: a spindle along z, a chain of samples in it, fibres along it, its ends on two bones. */
static sn_muscle spindle(void) {
    sn_muscle m = {.name = sn_strdup("spindle"), .meters_per_unit = 0.001, .mesh = ellipsoid(20, 20, 15, 80)};
    const sn_index samples = 9, vertices = m.mesh.vertex_count;
    m.structure = (sn_structure){.sample_count = samples, .positions = SN_NEW(sn_vec3, samples), .parents = SN_NEW(sn_index, samples)};
    m.structure.branches = SN_NEW(sn_index, samples);
    m.structure.axes = SN_NEW(sn_vec3, samples);
    m.structure.vertex_sample = SN_NEW(sn_index, vertices);
    m.fibers.directions = SN_NEW(sn_vec3, vertices);
    m.roots = (sn_roots){.vertices = SN_NEW(sn_index, vertices), .rule = sn_strdup("indices")};
    m.has_attachments = true;
    m.attachment_count = 2;
    m.attachments = SN_NEW(sn_attachment, 2);
    for (int a = 0; a < 2; a++)
        m.attachments[a] = (sn_attachment){.bone = sn_strdup(a ? "lower" : "upper"), .vertices = SN_NEW(sn_index, vertices)};
    for (sn_index i = 0; i < samples; i++) {
        m.structure.positions[i] = sn_v3(0, 0, 70.0 - 17.5 * i);
        m.structure.parents[i] = i - 1;
        m.structure.axes[i] = sn_v3(0, 0, 1);
    }
    for (sn_index v = 0; v < vertices; v++) {
        sn_vec3 p = m.mesh.positions[v], n = sn_normalize(sn_v3(p.x / 400, p.y / 225, p.z / 6400));
        m.structure.vertex_sample[v] = (sn_index)fmin(fmax(round((70.0 - p.z) / 17.5), 0.0), 8.0);
        m.fibers.directions[v] = sn_normalize(sn_sub(sn_v3(0, 0.01, 1), sn_scale(n, sn_dot(n, sn_v3(0, 0.01, 1)))));
        if (fabs(p.z) < 7.0) m.roots.vertices[m.roots.count++] = v;
        if (fabs(p.z) > 65.0) {
            sn_attachment *a = &m.attachments[p.z < 0.0];
            a->vertices[a->count++] = v;
        }
    }
    return m;
}

/* ---- helpers -------------------------------------------------------------------------------------------------------------------- */

static const uint8_t *pixel(const sn_image *image, sn_index x, sn_index y) { return image->rgb + 3 * (y * image->width + x); }
static bool same_pixel(const uint8_t *a, const uint8_t *b) { return memcmp(a, b, 3) == 0; }

static sn_view_options small_options(void) {
    sn_view_options o = sn_view_defaults();
    o.width = 200;
    o.height = 150;
    o.background = WHITE;
    return o;
}

/* The view alone, without any text. */
static sn_status draw(const sn_view *view, const sn_camera *camera, sn_view_options o, sn_image *out, sn_error *error) {
    const sn_tile tile = {view, camera, NULL};
    o.legend = false;
    return sn_sheet_render(&(sn_sheet){1, &tile, NULL, NULL}, &o, out, error);
}

static sn_image render(const sn_view *view, sn_camera camera, sn_view_options o) {
    sn_image image;
    sn_error error = {0};
    sn_camera_include(&camera, view);
    assert_int_equal(draw(view, &camera, o, &image, &error), SN_OK);
    return image;
}

static sn_view_mesh *add_ball(sn_view *view, double radius, sn_vec3 centre, sn_color color) {
    sn_mesh mesh = ellipsoid(24, radius, radius, radius);
    sn_rigid pose = {sn_quat_identity(), centre};
    sn_view_mesh *added;
    assert_int_equal(sn_view_add_mesh(view, &mesh, (sn_placement){1.0, &pose}, color, &added, NULL), SN_OK);
    sn_mesh_free(&mesh);
    return added;
}

/* ---- what is where ----------------------------------------------------------------------------------------------------------------- */

static void red_ball_in_the_middle(void **state) {
    (void)state;
    sn_view view = {0};
    add_ball(&view, 0.1, sn_v3(3, -2, 7), RED);
    sn_image image = render(&view, sn_camera_from(0, 0), small_options());
    const uint8_t *middle = pixel(&image, 100, 75), *corner = pixel(&image, 0, 0);
    assert_true(middle[0] > 120 && middle[1] < 80 && middle[2] < 80);
    assert_true(corner[0] > 240 && corner[0] == corner[1] && corner[1] == corner[2]);
    /* the diameter takes 92 % of the height, within a pixel of contour each side */
    sn_index first = SN_NONE, last = SN_NONE;
    for (sn_index y = 0; y < 150; y++)
        if (pixel(&image, 100, y)[1] < 200) {
            first = first == SN_NONE ? y : first;
            last = y;
        }
    assert_in_range(last - first + 1, 136, 140);
    assert_in_range(first, 5, 7);
    sn_image_free(&image);
    sn_view_free(&view);
}

static void nearer_hides_farther_from_every_side(void **state) {
    (void)state;
    const struct {
        double azimuth, elevation;
        sn_vec3 towards;
    } views[] = {{0, 0, {0, -1, 0}},   {90, 0, {1, 0, 0}}, {180, 0, {0, 1, 0}},
                 {270, 0, {-1, 0, 0}}, {0, 90, {0, 0, 1}}, {0, -90, {0, 0, -1}}};
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        sn_view view = {0};
        add_ball(&view, 0.1, sn_v3(0, 0, 0), BLUE);
        add_ball(&view, 0.05, sn_scale(views[i].towards, 0.3), RED);
        sn_image image = render(&view, sn_camera_from(views[i].azimuth, views[i].elevation), small_options());
        const uint8_t *middle = pixel(&image, 100, 75), *ring = pixel(&image, 100 + 55, 75);
        assert_true(middle[0] > middle[2] + 60);
        assert_true(ring[2] > ring[0] + 60);
        sn_image_free(&image);
        sn_view_free(&view);
    }
}

static void solid_hides_and_glass_shows(void **state) {
    (void)state;
    for (int glass = 0; glass < 2; glass++) {
        sn_view view = {0};
        add_ball(&view, 0.1, sn_v3(0, 0, 0), RED)->opacity = glass ? 0.3 : 1.0;
        sn_view_tube tube = {sn_v3(0, 0, 0), sn_v3(0, 0, 0), 0.1, BLUE};
        assert_int_equal(sn_view_add_tube(&view, tube, NULL), SN_OK);
        sn_image image = render(&view, sn_camera_from(0, 0), small_options());
        const uint8_t *middle = pixel(&image, 100, 75);
        assert_true(glass ? middle[2] > middle[0] + 20 : middle[0] > middle[2] + 60);
        sn_image_free(&image);
        sn_view_free(&view);
    }
}

/* A tube's radius is a share of the picture's longer side, whatever the zoom. */
static void tubes_keep_their_thickness(void **state) {
    (void)state;
    for (double zoom = 1.0; zoom < 5.0; zoom *= 2.0) {
        sn_view view = {0};
        sn_view_tube tube = {sn_v3(-1, 0, 0), sn_v3(1, 0, 0), 0.1, BLUE};
        assert_int_equal(sn_view_add_tube(&view, tube, NULL), SN_OK);
        sn_camera camera = sn_camera_from(0, 0);
        camera.zoom = zoom;
        sn_image image = render(&view, camera, small_options());
        int covered = 0;
        for (sn_index y = 0; y < 150; y++) covered += pixel(&image, 100, y)[0] < 150;
        assert_in_range(covered, 38, 42); /* 2 x 0.1 x 200 */
        sn_image_free(&image);
        sn_view_free(&view);
    }
}

static void painted_vertices_have_their_colour(void **state) {
    (void)state;
    sn_muscle m = spindle();
    sn_view view = {0};
    assert_int_equal(sn_view_add_muscle(&view, &m, SN_SHOW_SURFACE | SN_SHOW_ATTACHMENTS, NULL), SN_OK);
    assert_int_equal(view.entry_count, 2);
    assert_non_null(strstr(view.entries[0].text, "upper"));
    sn_view_options o = small_options();
    o.width = 100;
    sn_image image = render(&view, sn_camera_from(0, 0), o);
    const uint8_t *upper = pixel(&image, 50, 14), *middle = pixel(&image, 50, 75), *lower = pixel(&image, 50, 136);
    assert_true(upper[0] > upper[1] && upper[1] > upper[2] + 40); /* amber */
    assert_true(middle[0] > middle[1] + 80);                      /* muscle */
    assert_true(lower[1] > lower[0] + 40 && lower[2] > lower[0]); /* teal */
    sn_image_free(&image);
    sn_view_free(&view);
    sn_muscle_free(&m);
}

static void the_long_axis_lies_along_the_picture(void **state) {
    (void)state;
    sn_mesh mesh = ellipsoid(16, 0.02, 0.05, 0.2);
    sn_quat turn = sn_quat_axis_angle(sn_normalize(sn_v3(1, 2, -1)), 0.8);
    sn_rigid pose = {turn, sn_v3(10, 0, 0)};
    sn_vec3 length = sn_quat_rotate(turn, sn_v3(0, 0, 1)), thin = sn_quat_rotate(turn, sn_v3(1, 0, 0));
    sn_view view = {0};
    assert_int_equal(sn_view_add_mesh(&view, &mesh, (sn_placement){1.0, &pose}, RED, NULL, NULL), SN_OK);
    sn_camera wide = sn_camera_auto(&view, false, 0.0), tall = sn_camera_auto(&view, true, 0.0), turned = sn_camera_auto(&view, true, 90.0);
    assert_true(fabs(sn_dot(wide.right, length)) > 1.0 - 1e-6 && fabs(sn_dot(wide.back, thin)) > 1.0 - 1e-6);
    assert_true(fabs(sn_dot(tall.up, length)) > 1.0 - 1e-6 && fabs(sn_dot(tall.back, thin)) > 1.0 - 1e-6);
    assert_true(fabs(sn_dot(turned.up, length)) > 1.0 - 1e-6 && fabs(sn_dot(turned.back, thin)) < 1e-6);
    const sn_camera *cameras[] = {&wide, &tall, &turned};
    for (int i = 0; i < 3; i++) {
        sn_vec3 cross = sn_cross(cameras[i]->right, cameras[i]->up);
        assert_true(sn_distance(cross, cameras[i]->back) < 1e-9); /* right-handed: nothing is mirrored */
    }
    sn_mesh_free(&mesh);
    sn_view_free(&view);
}

/* ---- the same picture every time ----------------------------------------------------------------------------------------- */

static void any_number_of_threads_gives_the_same_bytes(void **state) {
    (void)state;
    sn_muscle m = spindle();
    sn_view view = {0};
    unsigned all = SN_SHOW_SURFACE | SN_SHOW_ROOTS | SN_SHOW_STRUCTURE | SN_SHOW_FIBERS | SN_SHOW_ATTACHMENTS | SN_SHOW_WIRE;
    assert_int_equal(sn_view_add_muscle(&view, &m, all, NULL), SN_OK);
    sn_view_options o = small_options();
    o.threads = 1;
    sn_image one = render(&view, sn_camera_from(30, 20), o);
    for (o.threads = 2; o.threads < 6; o.threads++) {
        sn_image many = render(&view, sn_camera_from(30, 20), o);
        assert_memory_equal(one.rgb, many.rgb, 3 * 200 * 150);
        sn_image_free(&many);
    }
    sn_image_free(&one);
    sn_view_free(&view);
    sn_muscle_free(&m);
}

/* ---- words and files ----------------------------------------------------------------------------------------------------- */

static sn_index ink(const sn_image *image) {
    sn_index count = 0;
    for (sn_index i = 0; i < image->width * image->height; i++) count += image->rgb[3 * i] < 128;
    return count;
}

static void every_character_leaves_its_own_ink(void **state) {
    (void)state;
    sn_image images[127];
    for (int c = 33; c < 127; c++) {
        char text[2] = {(char)c, 0};
        assert_int_equal(sn_image_alloc(&images[c], 48, 48, WHITE, NULL), SN_OK);
        sn_text_draw(&images[c], 8, 34, (sn_text_style){24, 1.0, {0, 0, 0}}, text);
        assert_true(ink(&images[c]) > 4);
        assert_true(sn_text_width(24, text) <= 24.0);
        for (int other = 33; other < c; other++) assert_true(memcmp(images[c].rgb, images[other].rgb, 3 * 48 * 48) != 0);
    }
    for (int c = 33; c < 127; c++) sn_image_free(&images[c]);
    assert_true(sn_text_width(10, "") == 0.0);
    assert_true(sn_text_width(10, "\xc3\xa9") == sn_text_width(10, "\xe2\x82\xac")); /* one box for one character */
}

static void text_outside_the_picture_is_cut(void **state) {
    (void)state;
    sn_image image;
    assert_int_equal(sn_image_alloc(&image, 20, 10, WHITE, NULL), SN_OK);
    sn_text_draw(&image, -500, 5, (sn_text_style){8, 1.0, {0, 0, 0}}, "far to the left");
    sn_text_draw(&image, 500, 5, (sn_text_style){8, 1.0, {0, 0, 0}}, "far to the right");
    assert_int_equal(ink(&image), 0);
    sn_text_draw(&image, -3, 30, (sn_text_style){50, 1.0, {0, 0, 0}}, "W");
    assert_true(ink(&image) > 0);
    sn_image_free(&image);
}

static void the_legend_names_what_is_drawn(void **state) {
    (void)state;
    sn_muscle m = spindle();
    sn_view view = {0};
    assert_int_equal(sn_view_add_muscle(&view, &m, SN_SHOW_SURFACE | SN_SHOW_ROOTS, NULL), SN_OK);
    assert_string_equal(view.title, "spindle");
    assert_non_null(strstr(view.subtitle, "802 vertices, 1600 triangles"));
    sn_camera camera = sn_camera_from(0, 0);
    sn_camera_include(&camera, &view);
    sn_tile tile = {&view, &camera, NULL};
    sn_view_options o = sn_view_defaults();
    for (int legend = 0; legend < 2; legend++) {
        o.legend = legend == 1;
        sn_image image;
        assert_int_equal(sn_sheet_render(&(sn_sheet){1, &tile, view.title, view.subtitle}, &o, &image, NULL), SN_OK);
        assert_int_equal(image.width, 800);
        assert_int_equal(image.height, 600);
        int purple = 0, dark = 0; /* the roots' dot in the lower left, the title in the upper left */
        for (sn_index y = 0; y < 600; y++)
            for (sn_index x = 0; x < 200; x++) {
                const uint8_t *p = pixel(&image, x, y);
                purple += y > 560 && p[2] > 150 && p[1] < 60 && p[0] > 90;
                dark += y < 40 && p[0] < 60 && p[1] < 60 && p[2] < 60;
            }
        assert_true(legend ? purple > 20 && dark > 100 : purple == 0 && dark == 0);
        sn_image_free(&image);
    }
    sn_view_free(&view);
    sn_muscle_free(&m);
}

static void a_sheet_holds_all_its_tiles(void **state) {
    (void)state;
    sn_view views[3] = {{0}};
    sn_camera camera = sn_camera_from(0, 0);
    sn_tile tiles[3];
    for (int i = 0; i < 3; i++) {
        add_ball(&views[i], 0.1, sn_v3(0, 0, 0), i == 1 ? BLUE : RED);
        tiles[i] = (sn_tile){&views[i], &camera, "tile"};
    }
    sn_camera_include(&camera, &views[0]);
    sn_view_options o = small_options();
    o.legend = false;
    o.columns = 2;
    sn_image image;
    assert_int_equal(sn_sheet_render(&(sn_sheet){3, tiles, NULL, NULL}, &o, &image, NULL), SN_OK);
    assert_in_range(image.width, 400, 412);
    assert_in_range(image.height, 300, 312);
    assert_true(pixel(&image, 100, 75)[0] > 120 && pixel(&image, 300, 75)[2] > 120 && pixel(&image, 100, 230)[0] > 120);
    assert_true(same_pixel(pixel(&image, 300, 230), pixel(&image, 390, 290))); /* the empty fourth */
    sn_image_free(&image);
    for (int i = 0; i < 3; i++) sn_view_free(&views[i]);
}

/* A row of empty-looking tiles with captions and legend entries; the caller frees the image. */
static sn_image captioned_sheet(sn_index count, const char *const *captions, const char *const *entries) {
    sn_view views[16] = {{0}};
    sn_tile tiles[16];
    sn_camera camera = sn_camera_from(0, 0);
    for (sn_index i = 0; i < count; i++) {
        add_ball(&views[i], 0.1, sn_v3(0, 0, 0), RED);
        assert_int_equal(sn_view_add_entry(&views[i], SN_MARK_AREA, RED, entries[i], NULL), SN_OK);
        tiles[i] = (sn_tile){&views[i], &camera, captions[i]};
    }
    sn_camera_include(&camera, &views[0]);
    sn_view_options o = small_options();
    o.columns = 4;
    sn_image image;
    assert_int_equal(sn_sheet_render(&(sn_sheet){count, tiles, NULL, NULL}, &o, &image, NULL), SN_OK);
    for (sn_index i = 0; i < count; i++) sn_view_free(&views[i]);
    return image;
}

static bool same_images(const sn_image *a, const sn_image *b) {
    return a->width == b->width && a->height == b->height && memcmp(a->rgb, b->rgb, 3 * (size_t)a->width * (size_t)a->height) == 0;
}

/* Left and right, first and second: names of muscles differ in their last letters, and stay apart where they are too long for a tile. */
static void long_captions_keep_their_ends(void **state) {
    (void)state;
    static const char *const names[] = {
        "musculus_flexor_digitorum_profundus_caput_humerale_L", "musculus_flexor_digitorum_prefundus_caput_humerale_L",
        "musculus_flexor_digitorum_profundus_caput_humerale_R", "pusculus_flexor_digitorum_profundus_caput_humerale_L"};
    const char *entries[] = {"a", "a"};
    sn_image images[4];
    for (int i = 0; i < 4; i++) images[i] = captioned_sheet(2, (const char *[]){names[i], names[i]}, entries);
    assert_true(same_images(&images[0], &images[1])); /* they differ in the middle, which is left out */
    assert_false(same_images(&images[0], &images[2]));
    assert_false(same_images(&images[0], &images[3]));
    for (int i = 0; i < 4; i++) sn_image_free(&images[i]);
}

/* Colours that mean something else in every tile would fill the page. */
static void a_sheet_lists_common_entries_only(void **state) {
    (void)state;
    const char *captions[16], *apart[16], *few[16];
    char texts[16][32];
    for (int i = 0; i < 16; i++) {
        snprintf(texts[i], sizeof texts[i], "on bone number %d", i);
        captions[i] = "tile";
        apart[i] = texts[i];
        few[i] = "other colours differ from tile to tile";
    }
    sn_image many = captioned_sheet(16, captions, apart), one = captioned_sheet(16, captions, few);
    assert_int_equal(many.height, one.height);
    assert_false(same_images(&many, &one)); /* the swatch of what differs is grey */
    sn_image twelve = captioned_sheet(12, captions, apart), twelve_alike = captioned_sheet(12, captions, few);
    assert_true(twelve.height > twelve_alike.height); /* twelve are still listed */
    sn_image_free(&many);
    sn_image_free(&one);
    sn_image_free(&twelve);
    sn_image_free(&twelve_alike);
}

/* Counts differ from tile to tile; what is counted has one line. */
static void details_that_differ_are_left_out_of_a_sheet(void **state) {
    (void)state;
    static const char *const details[3][2] = {{"1 of 2", "1 of 3"}, {NULL, NULL}, {"1 of 2", "1 of 2"}};
    sn_image images[3];
    for (int k = 0; k < 3; k++) {
        sn_view views[2] = {{0}};
        sn_tile tiles[2];
        sn_camera camera = sn_camera_from(0, 0);
        for (int i = 0; i < 2; i++) {
            add_ball(&views[i], 0.1, sn_v3(0, 0, 0), RED);
            assert_int_equal(sn_view_add_entry_detail(&views[i], SN_MARK_LINE, RED, "connections", details[k][i], NULL), SN_OK);
            tiles[i] = (sn_tile){&views[i], &camera, NULL};
        }
        sn_camera_include(&camera, &views[0]);
        sn_view_options o = small_options();
        assert_int_equal(sn_sheet_render(&(sn_sheet){2, tiles, NULL, NULL}, &o, &images[k], NULL), SN_OK);
        for (int i = 0; i < 2; i++) sn_view_free(&views[i]);
    }
    assert_true(same_images(&images[0], &images[1]));
    assert_false(same_images(&images[0], &images[2]));
    for (int k = 0; k < 3; k++) sn_image_free(&images[k]);
}

static void an_entry_added_with_another_detail_loses_it(void **state) {
    (void)state;
    sn_view view = {0};
    assert_int_equal(sn_view_add_entry_detail(&view, SN_MARK_LINE, RED, "on ulna", "12", NULL), SN_OK);
    assert_int_equal(sn_view_add_entry_detail(&view, SN_MARK_LINE, RED, "on ulna", "12", NULL), SN_OK);
    assert_string_equal(view.entries[0].detail, "12");
    assert_int_equal(sn_view_add_entry_detail(&view, SN_MARK_LINE, RED, "on ulna", "13", NULL), SN_OK);
    assert_null(view.entries[0].detail);
    assert_int_equal(sn_view_add_entry(&view, SN_MARK_LINE, WHITE, "on ulna", NULL), SN_OK);
    assert_int_equal(view.entry_count, 2); /* another colour is another thing */
    sn_view_free(&view);
}

/* The colours of its vertices go over the mesh's own, and the scale's start and end are told apart. */
static void vertex_colours_are_drawn(void **state) {
    (void)state;
    sn_view view = {0};
    add_ball(&view, 0.1, sn_v3(0, 0, 0), RED);
    sn_view_mesh *mesh = &view.meshes[0];
    mesh->colors = SN_NEW(sn_color, mesh->vertex_count);
    for (sn_index i = 0; i < mesh->vertex_count; i++) mesh->colors[i] = sn_scale_color(mesh->positions[i].x > 0.0 ? 1.0 : 0.0);
    sn_camera camera = sn_camera_from(0, 0);
    sn_camera_include(&camera, &view);
    sn_view_options o = small_options();
    sn_image image;
    assert_int_equal(draw(&view, &camera, o, &image, NULL), SN_OK);
    const uint8_t *low = pixel(&image, 2 * image.width / 5, image.height / 2), *high = pixel(&image, 3 * image.width / 5, image.height / 2);
    assert_true(low[2] > low[0]);                        /* blue */
    assert_true(high[0] > high[1] && high[2] > high[1]); /* purple */
    sn_image_free(&image);
    sn_view_free(&view);
}

/* Whatever the order in which muscles and pictures name them, and also in a scene. */
static void a_bone_has_one_colour_in_all_views_of_a_palette(void **state) {
    (void)state;
    sn_muscle first = spindle(), second = spindle();
    char *name = second.attachments[0].bone;
    second.attachments[0].bone = second.attachments[1].bone;
    second.attachments[1].bone = name;
    sn_palette palette = {0};
    sn_view views[3] = {{.palette = &palette}, {.palette = &palette}, {.palette = &palette}};
    sn_scene_bone bone = {.name = (char[]){"lower"}, .meters_per_unit = 1.0, .mesh = ellipsoid(4, 1, 1, 1), .joint = SN_NONE};
    sn_scene_muscle muscle = {.name = (char[]){"m"}, .rig = second, .enabled = true};
    sn_scene scene = {.bone_count = 1, .bones = &bone, .muscle_count = 1, .muscles = &muscle, .rate = 24.0};
    assert_int_equal(sn_view_add_muscle(&views[0], &first, SN_SHOW_AUTO, NULL), SN_OK);
    assert_int_equal(sn_view_add_muscle(&views[1], &second, SN_SHOW_AUTO, NULL), SN_OK);
    assert_int_equal(sn_view_add_bone(&views[1], "lower", &bone.mesh, (sn_placement){1.0, NULL}, NULL), SN_OK);
    assert_int_equal(sn_view_add_scene(&views[2], &scene, 0.0, NULL, SN_SHOW_AUTO | SN_SHOW_ATTACHMENTS, NULL), SN_OK);
    const sn_color *paints[] = {views[0].meshes[0].paints, views[1].meshes[0].paints, views[2].meshes[1].paints};
    for (int i = 0; i < 2; i++) {
        assert_memory_equal(&paints[0][i], &paints[1][1 - i], sizeof(sn_color));
        assert_memory_equal(&paints[1][i], &paints[2][i], sizeof(sn_color));
    }
    assert_memory_equal(&views[1].meshes[1].color, &views[2].meshes[0].color, sizeof(sn_color)); /* the bones themselves */
    assert_int_equal(palette.count, 2);
    for (int i = 0; i < 3; i++) sn_view_free(&views[i]);
    sn_palette_free(&palette);
    sn_mesh_free(&bone.mesh);
    sn_muscle_free(&first);
    sn_muscle_free(&second);
}

static void a_palette_has_other_colours_for_other_names(void **state) {
    (void)state;
    sn_palette palette = {0};
    sn_color colors[100];
    for (int i = 0; i < 100; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        assert_int_equal(sn_palette_color(&palette, name, &colors[i], NULL), SN_OK);
        for (int k = 0; k < i; k++) assert_memory_not_equal(&colors[i], &colors[k], sizeof(sn_color));
    }
    sn_palette_free(&palette);
}

static void edges_of_glass_are_seen(void **state) {
    (void)state;
    int darkest[2];
    for (int wire = 0; wire < 2; wire++) {
        sn_view view = {0};
        sn_view_mesh *ball = add_ball(&view, 0.1, sn_v3(0, 0, 0), RED);
        ball->opacity = 0.2;
        ball->wire = wire;
        sn_image image = render(&view, sn_camera_from(0, 0), small_options());
        darkest[wire] = 255;
        for (sn_index x = 85; x < 115; x++) { /* near the middle, where the surface is thinnest to look through */
            int red = pixel(&image, x, 75)[0];
            darkest[wire] = red < darkest[wire] ? red : darkest[wire];
        }
        sn_image_free(&image);
        sn_view_free(&view);
    }
    assert_true(darkest[1] < darkest[0] - 30);
}

static void the_camera_aims_at_what_is_in_focus(void **state) {
    (void)state;
    sn_view view = {0};
    const char *names[] = {"biceps", "radius", NULL};
    for (int i = 0; i < 3; i++) add_ball(&view, 0.1, sn_v3(i, 0, 0), RED);
    for (int i = 0; i < 2; i++) view.meshes[i].name = sn_strdup(names[i]);
    assert_int_equal(sn_view_focus(&view, "ulna"), 0);
    sn_camera all = sn_camera_from(0, 0), one = all, two = all;
    sn_camera_include(&all, &view);
    assert_true(fabs(all.extent.high.x - 2.1) < 0.01);
    assert_int_equal(sn_view_focus(&view, "rad*"), 1);
    sn_camera_include(&one, &view);
    assert_true(fabs(one.extent.low.x - 0.9) < 0.01 && fabs(one.extent.high.x - 1.1) < 0.01);
    assert_int_equal(sn_view_focus(&view, "biceps"), 1);
    sn_camera_include(&two, &view);
    assert_true(fabs(two.extent.low.x + 0.1) < 0.01 && fabs(two.extent.high.x - 1.1) < 0.01);
    sn_view_free(&view);
}

static void libpng_reads_back_the_same_pixels(void **state) {
    (void)state;
    sn_image image;
    assert_int_equal(sn_image_alloc(&image, 37, 11, WHITE, NULL), SN_OK);
    uint64_t seed = 5;
    for (sn_index i = 0; i < 3 * 37 * 11; i++) image.rgb[i] = (uint8_t)(256.0 * sn_random(&seed));
    unsigned char *data;
    size_t size;
    assert_int_equal(sn_image_to_png(&image, &data, &size, NULL), SN_OK);
    png_image png = {.version = PNG_IMAGE_VERSION};
    uint8_t back[3 * 37 * 11];
    assert_true(png_image_begin_read_from_memory(&png, data, size));
    assert_int_equal(png.width, 37);
    assert_int_equal(png.height, 11);
    png.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&png, NULL, back, 0, NULL));
    assert_memory_equal(back, image.rgb, sizeof back);
    free(data);
    sn_image_free(&image);
}

/* ---- partial, odd and bad input ------------------------------------------------------------------------------------------ */

static void draw_whole(const sn_muscle *m, unsigned show) {
    sn_view view = {0};
    sn_error error = {0};
    assert_int_equal(sn_view_add_muscle(&view, m, show, &error), SN_OK);
    const sn_camera cameras[] = {sn_camera_auto(&view, false, 0.0), sn_camera_auto(&view, true, 45.0), sn_camera_from(0, 90),
                                 sn_camera_from(90, 0)};
    sn_view_options o = small_options();
    o.samples = 1;
    for (size_t i = 0; i < sizeof cameras / sizeof *cameras; i++) {
        sn_image image = render(&view, cameras[i], o);
        sn_image_free(&image);
    }
    sn_view_free(&view);
}

static void partial_documents_are_drawn(void **state) {
    (void)state;
    const unsigned everything = SN_SHOW_AUTO | SN_SHOW_STRUCTURE | SN_SHOW_FIBERS;
    sn_muscle m = spindle();
    for (sn_index v = 0; v < m.mesh.vertex_count; v += 2) m.structure.vertex_sample[v] = SN_NONE;
    draw_whole(&m, everything);
    free(m.structure.vertex_sample);
    m.structure.vertex_sample = NULL;
    draw_whole(&m, everything);
    m.structure.sample_count = 1;
    draw_whole(&m, everything);
    for (sn_index v = 0; v < m.mesh.vertex_count; v++) m.fibers.directions[v] = sn_v3(0, 0, 0);
    draw_whole(&m, everything);
    sn_muscle bare = {.meters_per_unit = 1.0, .mesh = m.mesh};
    draw_whole(&bare, everything);
    sn_muscle_free(&m);
}

static void odd_shapes_are_drawn(void **state) {
    (void)state;
    const sn_vec3 shapes[][3] = {
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},                                 /* one triangle */
        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},                                 /* a point */
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}},                                 /* a line */
        {{1e30, 0, 0}, {1e30, 1e30, 0}, {0, 0, -1e30}},                    /* large */
        {{0, 0, 0}, {1e-6, 0, 1e30}, {0, 1e-6, -1e30}},                    /* a needle: seen end on its depth is all */
        {{0, 0, 0}, {1e-200, 0, 1e100}, {0, 1e-200, -1e100}},              /* worse */
        {{1e-30, 0, 0}, {0, 1e-30, 0}, {0, 0, 1e-30}},                     /* small */
        {{1e6, 1e6, 1e6}, {1e6 + 1e-3, 1e6, 1e6}, {1e6, 1e6 + 1e-3, 1e6}}, /* far from the origin */
    };
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        sn_muscle m = {.meters_per_unit = 1.0};
        assert_int_equal(sn_mesh_alloc(&m.mesh, 3, 1, NULL), SN_OK);
        memcpy(m.mesh.positions, shapes[i], sizeof shapes[i]);
        m.mesh.triangles[0] = (sn_triangle){{0, 1, 2}};
        m.fibers.directions = SN_NEW(sn_vec3, 3);
        for (int k = 0; k < 3; k++) m.fibers.directions[k] = sn_v3(1, 0, 0);
        draw_whole(&m, SN_SHOW_AUTO | SN_SHOW_WIRE);
        sn_muscle_free(&m);
    }
}

static void what_cannot_be_drawn_is_refused(void **state) {
    (void)state;
    sn_view view = {0};
    sn_error error = {0};
    sn_image image;
    sn_mesh mesh = ellipsoid(4, 1e308, 1e308, 1e308);
    assert_int_equal(sn_view_add_mesh(&view, &mesh, (sn_placement){1.0, NULL}, RED, NULL, NULL), SN_OK);
    sn_camera camera = sn_camera_from(30, 30);
    sn_camera_include(&camera, &view);
    sn_view_options o = small_options();
    assert_int_equal(draw(&view, &camera, o, &image, &error), SN_ERROR_INPUT);
    assert_non_null(strstr(error.text, "too large"));
    o.width = 0;
    assert_int_equal(draw(&view, &camera, o, &image, &error), SN_ERROR_USAGE);
    o = small_options();
    o.samples = 9;
    assert_int_equal(draw(&view, &camera, o, &image, &error), SN_ERROR_USAGE);
    sn_view nothing = {0};
    sn_tile tile = {&nothing, &camera, NULL};
    o.samples = 1;
    assert_int_equal(sn_sheet_render(&(sn_sheet){1, &tile, NULL, NULL}, &o, &image, &error), SN_ERROR_INPUT);
    sn_mesh_free(&mesh);
    sn_view_free(&view);
}

/* ---- scenes -------------------------------------------------------------------------------------------------------------- */

static void scenes_pose_bones_and_deform_muscles(void **state) {
    (void)state;
    sn_pose_key key = {0.0, {sn_quat_identity(), {0.5, 0, 0}}};
    sn_joint joint = {.name = (char[]){"j"}, .parent = SN_NONE, .kind = SN_JOINT_POSE, .key_count = 1, .keys = &key};
    sn_scene_bone bone = {.name = (char[]){"b"}, .meters_per_unit = 0.01, .mesh = ellipsoid(4, 1, 1, 1), .joint = 0};
    sn_scene_muscle muscle = {.name = (char[]){"m"}, .rig = spindle(), .activation = {.constant = 1.0}, .enabled = true};
    sn_scene scene = {.bone_count = 1, .bones = &bone, .muscle_count = 1, .muscles = &muscle, .motion = {1, &joint}, .rate = 24.0};
    sn_vec3 *moved = SN_NEW(sn_vec3, muscle.rig.mesh.vertex_count);
    for (sn_index v = 0; v < muscle.rig.mesh.vertex_count; v++) moved[v] = sn_v3(0.25, v, 2);
    const sn_vec3 *positions[] = {moved};
    sn_view view = {0};
    assert_int_equal(sn_view_add_scene(&view, &scene, 0.0, NULL, SN_SHOW_AUTO, NULL), SN_OK);
    assert_int_equal(view.mesh_count, 2);
    sn_vec3 rest = sn_scale(bone.mesh.positions[3], 0.01);
    assert_true(sn_distance(view.meshes[0].positions[3], sn_add(rest, sn_v3(0.5, 0, 0))) < 1e-12);
    assert_true(sn_distance(view.meshes[1].positions[3], sn_scale(muscle.rig.mesh.positions[3], 0.001)) < 1e-12);
    sn_view_free(&view);
    assert_int_equal(sn_view_add_scene(&view, &scene, 0.0, positions, SN_SHOW_AUTO | SN_SHOW_ATTACHMENTS, NULL), SN_OK);
    assert_true(sn_distance(view.meshes[1].positions[3], sn_v3(0.25, 3, 2)) < 1e-12);
    assert_int_equal(view.meshes[1].paint_count, 2);
    sn_view_free(&view);
    unsigned inside = SN_SHOW_AUTO | SN_SHOW_STRUCTURE | SN_SHOW_FIBERS;
    assert_int_equal(sn_view_add_scene(&view, &scene, 0.0, NULL, inside, NULL), SN_OK);
    assert_true(view.tube_count > 1000 && view.meshes[1].opacity < 1.0);
    sn_view_free(&view);
    assert_int_equal(sn_view_add_scene(&view, &scene, 0.0, positions, inside, NULL), SN_OK);
    assert_true(view.tube_count == 0 && view.meshes[1].opacity == 1.0);
    sn_view_free(&view);
    free(moved);
    sn_mesh_free(&bone.mesh);
    sn_muscle_free(&muscle.rig);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(red_ball_in_the_middle),
        cmocka_unit_test(nearer_hides_farther_from_every_side),
        cmocka_unit_test(solid_hides_and_glass_shows),
        cmocka_unit_test(tubes_keep_their_thickness),
        cmocka_unit_test(painted_vertices_have_their_colour),
        cmocka_unit_test(the_long_axis_lies_along_the_picture),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(every_character_leaves_its_own_ink),
        cmocka_unit_test(text_outside_the_picture_is_cut),
        cmocka_unit_test(the_legend_names_what_is_drawn),
        cmocka_unit_test(a_sheet_holds_all_its_tiles),
        cmocka_unit_test(long_captions_keep_their_ends),
        cmocka_unit_test(a_sheet_lists_common_entries_only),
        cmocka_unit_test(details_that_differ_are_left_out_of_a_sheet),
        cmocka_unit_test(an_entry_added_with_another_detail_loses_it),
        cmocka_unit_test(vertex_colours_are_drawn),
        cmocka_unit_test(a_bone_has_one_colour_in_all_views_of_a_palette),
        cmocka_unit_test(a_palette_has_other_colours_for_other_names),
        cmocka_unit_test(edges_of_glass_are_seen),
        cmocka_unit_test(the_camera_aims_at_what_is_in_focus),
        cmocka_unit_test(libpng_reads_back_the_same_pixels),
        cmocka_unit_test(partial_documents_are_drawn),
        cmocka_unit_test(odd_shapes_are_drawn),
        cmocka_unit_test(what_cannot_be_drawn_is_refused),
        cmocka_unit_test(scenes_pose_bones_and_deform_muscles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
