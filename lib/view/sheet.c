/* sheet.c -- pictures with words: title, captions, legend, scale bar; several of them on a contact sheet. */
#include "image.h"
#include "render.h"

#include <stdio.h>
#include <string.h>

/* Measures of the text on the page, in pixels. */
typedef struct typography {
    double unit; /* 1 at 600 pixels of height */
    sn_color ink, pale, paper;
} typography;

static typography typography_for(const sn_view_options *options, double width, double height) {
    sn_color b = options->background;
    bool dark = 0.3 * b.r + 0.59 * b.g + 0.11 * b.b < 0.45;
    double unit = fmin(fmax(fmin(width, height) / 600.0, 0.62), 4.0);
    sn_color ink = dark ? (sn_color){0.93, 0.93, 0.92} : (sn_color){0.13, 0.13, 0.15};
    sn_color pale = dark ? (sn_color){0.70, 0.70, 0.69} : (sn_color){0.40, 0.40, 0.42};
    return (typography){unit, ink, pale, b};
}

/* ---- words ------------------------------------------------------------------------------------------------------------------ */

enum { TEXT_ROOM = 512 };

/* The start of the character that byte `at` of UTF-8 text belongs to. */
static size_t character_start(const char *text, size_t at) {
    while (at > 0 && ((unsigned char)text[at] & 0xC0) == 0x80) at--;
    return at;
}

/* Text in at most `width` pixels: dots stand for what is left out of its middle, as names often differ at their ends alone. */
static void fit_text(const char *text, double size, double width, char cut[TEXT_ROOM]) {
    size_t length = strlen(text), kept = length < TEXT_ROOM - 5 ? length : TEXT_ROOM - 5;
    snprintf(cut, TEXT_ROOM, "%s", text);
    while (kept > 2 && (kept < length || sn_text_width(size, cut) > width)) {
        kept--;
        size_t head = character_start(text, (kept + 1) / 2), tail = character_start(text, length - kept / 2);
        snprintf(cut, TEXT_ROOM, "%.*s...%s", (int)head, text, text + tail);
        if (sn_text_width(size, cut) <= width) break;
    }
}

/* Where a line of text goes: its baseline's start, and the width that it may take. Pixels. */
typedef struct text_place {
    double x, y, width;
} text_place;

/* Text with a halo of paper: it may stand before the subject. */
static void draw_text(sn_image *image, typography t, text_place at, sn_text_style style, const char *text) {
    char cut[TEXT_ROOM];
    fit_text(text, style.size, at.width, cut);
    sn_text_draw(image, at.x, at.y, (sn_text_style){style.size, style.weight + 2.4, t.paper}, cut);
    sn_text_draw(image, at.x, at.y, style, cut);
}

static void draw_title(sn_image *image, typography t, const char *title, const char *subtitle) {
    text_place at = {18.0 * t.unit, 14.0 * t.unit, image->width - 36.0 * t.unit};
    if (title) {
        at.y += 13.0 * t.unit;
        draw_text(image, t, at, (sn_text_style){12.5 * t.unit, 1.5, t.ink}, title);
    }
    if (subtitle) {
        at.y += (title ? 20.0 : 11.0) * t.unit;
        draw_text(image, t, at, (sn_text_style){8.5 * t.unit, 1.0, t.pale}, subtitle);
    }
}

static double title_height(typography t, const char *title, const char *subtitle) {
    return title || subtitle ? (14.0 + (title ? 13.0 : 0.0) + (subtitle ? (title ? 20.0 : 11.0) : 0.0) + 10.0) * t.unit : 0.0;
}

/* ---- legend ------------------------------------------------------------------------------------------------------------------ */

/* A circle about (x, y). */
static void draw_ring(sn_image *image, double x, double y, double radius, double width, sn_color color) {
    enum { SIDES = 28 };
    image_line lines[SIDES];
    for (int i = 0; i < SIDES; i++) {
        double a = 2.0 * SN_PI * i / SIDES, b = 2.0 * SN_PI * (i + 1) / SIDES;
        lines[i] = (image_line){x + radius * sn_cos(a), y + radius * sn_sin(a), x + radius * sn_cos(b), y + radius * sn_sin(b)};
    }
    image_lines(image, SIDES, lines, width, color);
}

static void draw_mark(sn_image *image, typography t, double x, double y, sn_view_mark mark, sn_color color) {
    double size = 10.0 * t.unit, middle = y - 0.4 * size;
    if (mark == SN_MARK_RING) {
        draw_ring(image, x + 0.5 * size, middle, 0.45 * size, 0.7 * t.unit, color);
    } else if (mark == SN_MARK_DOT) {
        image_lines(image, 1, &(image_line){x + 0.5 * size, middle, x + 0.5 * size, middle}, 0.45 * size, color);
    } else if (mark == SN_MARK_LINE) {
        image_lines(image, 1, &(image_line){x, middle, x + size, middle}, 0.25 * size + 0.7 * t.unit, t.pale);
        image_lines(image, 1, &(image_line){x, middle, x + size, middle}, 0.25 * size, color);
    } else {
        image_line rows[5];
        for (int i = 0; i < 5; i++) {
            double row = middle + (i - 2) * 0.16 * size;
            rows[i] = (image_line){x + 0.12 * size, row, x + 0.88 * size, row};
        }
        image_lines(image, 5, rows, 0.16 * size + 0.7 * t.unit, t.pale);
        image_lines(image, 5, rows, 0.16 * size, color);
    }
}

/* A line of the page's legend: an entry of a view, with or without its detail. */
typedef struct legend_line {
    const sn_view_entry *entry;
    bool detailed;
} legend_line;

static void legend_text(const legend_line *line, char text[TEXT_ROOM]) {
    if (line->detailed && line->entry->detail)
        snprintf(text, TEXT_ROOM, "%s (%s)", line->entry->text, line->entry->detail);
    else
        snprintf(text, TEXT_ROOM, "%s", line->entry->text);
}

/* Lay the legend out in rows from the top; returns its height. image NULL = only measure. */
static double legend_rows(sn_image *image, typography t, size_t count, const legend_line *lines, double width, double top) {
    double left = 18.0 * t.unit, x = left, row = 19.0 * t.unit, y = top + row, text_size = 8.5 * t.unit;
    for (size_t i = 0; i < count; i++) {
        char text[TEXT_ROOM];
        legend_text(&lines[i], text);
        double needed = 18.0 * t.unit + sn_text_width(text_size, text);
        if (x > left && x + needed > width - left) {
            x = left;
            y += row;
        }
        if (image) {
            draw_mark(image, t, x, y, lines[i].entry->mark, lines[i].entry->color);
            const text_place at = {x + 18.0 * t.unit, y, width - left - x - 18.0 * t.unit};
            draw_text(image, t, at, (sn_text_style){text_size, 1.0, t.ink}, text);
        }
        x += needed + 20.0 * t.unit;
    }
    return count ? y - top : 0.0;
}

static bool is_same_entry(const sn_view_entry *a, const sn_view_entry *b) {
    bool same_color = !(fabs(a->color.r - b->color.r) + fabs(a->color.g - b->color.g) + fabs(a->color.b - b->color.b) > 0.0);
    return strcmp(a->text, b->text) == 0 && same_color;
}

static bool is_same_detail(const sn_view_entry *a, const sn_view_entry *b) {
    return a->detail && b->detail ? strcmp(a->detail, b->detail) == 0 : a->detail == b->detail;
}

/* Add a line for an entry, or see that it has one; a line whose entries differ in detail says none. Returns how many lines there are. */
static size_t collect_entry(const sn_view_entry *entry, size_t count, size_t room, legend_line *lines) {
    for (size_t k = 0; k < count; k++)
        if (is_same_entry(lines[k].entry, entry)) {
            lines[k].detailed = lines[k].detailed && is_same_detail(lines[k].entry, entry);
            return count;
        }
    if (count < room) lines[count++] = (legend_line){entry, true};
    return count;
}

/* The entries of all tiles, each once. Returns how many; they are borrowed. */
static size_t collect_entries(sn_index tile_count, const sn_tile *tiles, size_t room, legend_line *lines) {
    size_t count = 0;
    for (sn_index i = 0; i < tile_count; i++)
        for (size_t e = 0; e < tiles[i].view->entry_count; e++) count = collect_entry(&tiles[i].view->entries[e], count, room, lines);
    return count;
}

static sn_index tiles_with(sn_index tile_count, const sn_tile *tiles, const sn_view_entry *entry) {
    sn_index count = 0;
    for (sn_index i = 0; i < tile_count; i++)
        for (size_t e = 0; e < tiles[i].view->entry_count; e++)
            if (is_same_entry(&tiles[i].view->entries[e], entry)) {
                count++;
                break;
            }
    return count;
}

/* Keep the entries that hold for half of the tiles or more; where others go, `rest` says so. Returns how many are left. */
static size_t keep_common_entries(sn_index tile_count, const sn_tile *tiles, size_t count, legend_line *lines, const sn_view_entry *rest) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (2 * tiles_with(tile_count, tiles, lines[i].entry) >= tile_count) lines[kept++] = lines[i];
    if (kept < count) lines[kept++] = (legend_line){rest, false};
    return kept;
}

/* ---- scale bar ------------------------------------------------------------------------------------------------------------------ */

/* The longest of 1, 2, 5 x 10^k metres that takes at most a fifth of the width, lower right. */
static void draw_scale_bar(sn_image *image, typography t, const frame *f, double right, double y) {
    double most = 0.2 * f->width / f->pixels_per_meter, power = sn_pow(10.0, floor(sn_log10(most)));
    if (!(most > 1e-9) || !(most < 1e6)) return;
    double length = power * (most >= 5.0 * power ? 5.0 : most >= 2.0 * power ? 2.0 : 1.0), pixels = length * f->pixels_per_meter;
    char text[48];
    const char *unit = length >= 0.9 ? "m" : length >= 0.009 ? "cm" : length >= 0.9e-3 ? "mm" : "um";
    double in_unit = length * (length >= 0.9 ? 1.0 : length >= 0.009 ? 1e2 : length >= 0.9e-3 ? 1e3 : 1e6);
    snprintf(text, sizeof text, "%.4g %s", in_unit, unit);
    double size = 8.0 * t.unit, tick = 3.0 * t.unit;
    const image_line lines[3] = {
        {right - pixels, y, right, y}, {right - pixels, y - tick, right - pixels, y + tick}, {right, y - tick, right, y + tick}};
    image_lines(image, 3, lines, 2.0 * t.unit, t.paper);
    image_lines(image, 3, lines, 0.6 * t.unit, t.pale);
    const text_place at = {right - 0.5 * (pixels + sn_text_width(size, text)), y - 6.0 * t.unit, INFINITY};
    draw_text(image, t, at, (sn_text_style){size, 1.0, t.pale}, text);
}

/* ---- colour scale and rings ------------------------------------------------------------------------------------------------------- */

/* Lower left: what is measured, a bar of its colours from 0 to the end of the scale. */
static void draw_color_scale(sn_image *image, typography t, const sn_view_scale *scale, double left, double y, double width) {
    if (!scale->text) return;
    enum { STEPS = 120 };
    double bar = 0.3 * width, high = 7.0 * t.unit, size = 8.0 * t.unit;
    char end[48];
    snprintf(end, sizeof end, "%.4g%s", scale->high, scale->open ? " and more" : "");
    const sn_text_style pale = {size, 1.0, t.pale}, ink = {size, 1.0, t.ink};
    draw_text(image, t, (text_place){left, y, INFINITY}, pale, "0");
    draw_text(image, t, (text_place){left + bar + 26.0 * t.unit, y, INFINITY}, pale, end);
    draw_text(image, t, (text_place){left, y - 14.0 * t.unit, 0.62 * width}, ink, scale->text);
    for (int i = 0; i < STEPS; i++) {
        double middle = y - 0.5 * size, from = left + 16.0 * t.unit + bar * i / STEPS;
        image_lines(image, 1, &(image_line){from, middle, from + bar / STEPS, middle}, 0.5 * high, sn_scale_color((i + 0.5) / STEPS));
    }
}

/* Height that the bars below the subject need, in units of type. */
static double scale_room(const sn_view *view) { return view->scale.text ? 40.0 : 24.0; }

static void draw_rings(sn_image *image, typography t, const frame *f, const sn_view *view) {
    for (size_t i = 0; i < view->ring_count; i++) {
        sn_vec3 at = frame_apply(f, view->rings[i]);
        double y = image->height - at.y;
        if (!(at.x >= 0.0 && at.x <= image->width && y >= 0.0 && y <= image->height)) continue; /* zoomed out of the picture */
        draw_ring(image, at.x, y, 8.0 * t.unit, 2.6 * t.unit, t.paper);
        draw_ring(image, at.x, y, 8.0 * t.unit, 0.9 * t.unit, t.ink);
    }
}

/* ---- pages ------------------------------------------------------------------------------------------------------------------------ */

/* Most entries looked at, and most that the legend of a sheet may list before it is cut down to the common ones. */
enum { ENTRIES_MAX = 64, SHEET_ENTRIES_MAX = 12 };

typedef struct page {
    sn_index count, columns, rows;
    const sn_tile *tiles;
    const char *title, *subtitle;
    const sn_view_options *options;
    size_t entry_count;
    legend_line entries[ENTRIES_MAX];
    typography type;
    sn_pool *pool;
} page;

static sn_status single_page(page *g, sn_image *out, sn_error *error) {
    const sn_view_options *options = g->options;
    sn_status status = sn_image_alloc(out, options->width, options->height, options->background, error);
    if (status) return status;
    double legend = legend_rows(NULL, g->type, g->entry_count, g->entries, out->width, 0.0);
    double bottom = (legend > 0.0 ? 14.0 * g->type.unit + legend : 0.0) + 6.0 * g->type.unit;
    inset clear = {0, 0};
    if (options->legend)
        clear = (inset){title_height(g->type, g->title, g->subtitle), bottom + scale_room(g->tiles[0].view) * g->type.unit};
    status = picture_render(&g->tiles[0], options, clear, g->pool, out, error);
    frame f;
    if (status || !options->legend) return status;
    status = frame_set(&f, g->tiles[0].camera, out->width, out->height, clear, error);
    draw_title(out, g->type, g->title, g->subtitle);
    legend_rows(out, g->type, g->entry_count, g->entries, out->width, out->height - 14.0 * g->type.unit - legend);
    if (status) return status;
    double left = 18.0 * g->type.unit, base = out->height - bottom - 6.0 * g->type.unit;
    draw_scale_bar(out, g->type, &f, out->width - left, base);
    draw_color_scale(out, g->type, &g->tiles[0].view->scale, left, base, out->width);
    draw_rings(out, g->type, &f, g->tiles[0].view);
    return SN_OK;
}

static sn_status draw_tile(const page *g, const sn_tile *tile, sn_image *out, sn_index x, sn_index y, sn_error *error) {
    const sn_view_options *options = g->options;
    sn_image image;
    sn_status status = sn_image_alloc(&image, options->width, options->height, options->background, error);
    if (status) return status;
    typography t = typography_for(options, 1.35 * image.width, 1.35 * image.height);
    inset clear = {0, 0};
    if (options->legend) clear = (inset){tile->caption ? 30.0 * t.unit : 0.0, (scale_room(tile->view) + 2.0) * t.unit};
    frame f;
    status = picture_render(tile, options, clear, g->pool, &image, error);
    if (!status) status = frame_set(&f, tile->camera, image.width, image.height, clear, error);
    if (!status && options->legend) {
        double left = 12.0 * t.unit;
        const text_place at = {left, 22.0 * t.unit, image.width - 2.0 * left};
        if (tile->caption) draw_text(&image, t, at, (sn_text_style){9.0 * t.unit, 1.15, t.ink}, tile->caption);
        draw_scale_bar(&image, t, &f, image.width - left, image.height - 10.0 * t.unit);
        draw_color_scale(&image, t, &tile->view->scale, left, image.height - 10.0 * t.unit, image.width);
        draw_rings(&image, t, &f, tile->view);
    }
    if (!status) image_paste(out, &image, x, y);
    sn_image_free(&image);
    return status;
}

static sn_status sheet_page(page *g, sn_image *out, sn_error *error) {
    const sn_view_options *options = g->options;
    const double gap = fmax(round(3.0 * g->type.unit), 1.0);
    double width = g->columns * (options->width + gap) - gap, top = 0.0, bottom = 0.0;
    if (options->legend) {
        top = ceil(title_height(g->type, g->title, g->subtitle));
        double legend = legend_rows(NULL, g->type, g->entry_count, g->entries, width, 0.0);
        bottom = legend > 0.0 ? ceil(legend + 14.0 * g->type.unit) : 0.0;
    }
    double height = top + g->rows * (options->height + gap) - gap + bottom;
    sn_status status = sn_image_alloc(out, (sn_index)fmin(width, 1e6), (sn_index)fmin(height, 1e6), options->background, error);
    for (sn_index i = 0; i < g->count && !status; i++) {
        sn_index x = (sn_index)(i % g->columns * (options->width + gap)), y = (sn_index)(top + i / g->columns * (options->height + gap));
        status = draw_tile(g, &g->tiles[i], out, x, y, error);
    }
    if (status || !options->legend) return status;
    draw_title(out, g->type, g->title, g->subtitle);
    legend_rows(out, g->type, g->entry_count, g->entries, width, height - bottom);
    return SN_OK;
}

/* As square as it gets: the sheet's sides in pixels differ least. */
static sn_index automatic_columns(sn_index count, const sn_view_options *options) {
    sn_index best = 1;
    double least = INFINITY;
    for (sn_index columns = 1; columns <= count; columns++) {
        sn_index rows = (count - 1) / columns + 1;
        double shape = fabs(sn_ln((double)columns * options->width / (1.7 * rows * options->height)));
        shape += 0.15 * (rows * columns - count);
        if (shape < least) {
            least = shape;
            best = columns;
        }
    }
    return best;
}

sn_status sn_sheet_render(const sn_sheet *sheet, const sn_view_options *options, sn_image *out, sn_error *error) {
    const sn_tile *tiles = sheet->tiles;
    sn_index tile_count = sheet->tile_count;
    *out = (sn_image){0};
    bool empty = true;
    for (sn_index i = 0; i < tile_count; i++) empty = empty && tiles[i].view->mesh_count == 0 && tiles[i].view->tube_count == 0;
    if (empty) return sn_fail(error, SN_ERROR_INPUT, "there is nothing to draw: the input holds none of what is to be shown");
    if (options->width < 1 || options->height < 1 || options->width > SN_IMAGE_SIDE_MAX || options->height > SN_IMAGE_SIDE_MAX)
        return sn_image_alloc(out, options->width, options->height, options->background, error);
    page g = {.count = tile_count, .tiles = tiles, .title = sheet->title, .subtitle = sheet->subtitle, .options = options};
    g.columns =
        options->columns > 0 ? (options->columns < tile_count ? options->columns : tile_count) : automatic_columns(tile_count, options);
    g.rows = (tile_count - 1) / g.columns + 1;
    char rest_text[] = "other colours differ from tile to tile";
    const sn_view_entry rest = {.mark = SN_MARK_AREA, .color = {0.75, 0.75, 0.75}, .text = rest_text};
    g.entry_count = options->legend ? collect_entries(tile_count, tiles, ENTRIES_MAX, g.entries) : 0;
    if (tile_count > 1 && g.entry_count > SHEET_ENTRIES_MAX)
        g.entry_count = keep_common_entries(tile_count, tiles, g.entry_count, g.entries, &rest);
    g.type = tile_count == 1 ? typography_for(options, options->width, options->height)
                             : typography_for(options, 0.6 * g.columns * options->width + 120.0, 0.6 * g.rows * options->height + 240.0);
    g.pool = sn_pool_create(options->threads);
    if (!g.pool) return sn_fail_memory(error, "the renderer's threads");
    sn_status status = tile_count == 1 ? single_page(&g, out, error) : sheet_page(&g, out, error);
    sn_pool_destroy(g.pool);
    if (status) sn_image_free(out);
    return status;
}
