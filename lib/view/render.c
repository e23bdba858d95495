/*
 * render.c -- the picture, band by band: solid meshes by rays, tubes over them, translucent meshes in front, contours, filter.
 *
 * Each pixel has samples x samples rays on a regular grid. A band of rows knows nothing of its neighbours: it casts its own margin.
 */
#include "render.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { BAND_ROWS = 8, GLASS_LAYERS = 24 };
static const double WIRE_OPACITY = 0.7; /* of edges on a translucent surface, which would be as faint as it is */

typedef struct picture {
    const sn_view_options *options;
    sn_image *image;
    frame frame;
    layer solid, glass;
    size_t tube_count;
    tube *tubes;
    tint background;
    double epsilon; /* how far below a translucent layer the next one may lie */
    atomic_bool out_of_memory;
} picture;

sn_view_options sn_view_defaults(void) {
    return (sn_view_options){.width = 800, .height = 600, .samples = 3, .background = {0.972, 0.968, 0.960}, .legend = true};
}

/* A little darker towards the lower edge: the subject stands before something. */
static tint background_at(const picture *p, double y) {
    double t = fmin(fmax(y / p->frame.height, 0.0), 1.0);
    return tint_scale(p->background, (float)(0.90 + 0.10 * t));
}

static void cast_solid(const picture *p, band *b) {
    for (sn_index row = 0; row < b->height; row++)
        for (sn_index column = 0; column < b->width; column++) {
            double x = b->left + column * b->step, y = b->top - row * b->step;
            sample *s = &b->samples[(size_t)row * (size_t)b->width + (size_t)column];
            *s = (sample){background_at(p, y), -INFINITY, -INFINITY, SN_NONE};
            layer_hit hit;
            if (!layer_cast(&p->solid, x, y, INFINITY, -INFINITY, &hit)) continue;
            tint albedo = hit.behind ? tint_scale(hit.albedo, 0.55f) : hit.albedo;
            *s = (sample){shade(albedo, hit.normal, hit.open, hit.gloss), hit.z, hit.z, hit.id};
        }
}

/* Opacity of a thin shell grows with the slant of the view: 1 - (1 - a)^(1/cos). */
static float shell_opacity(const layer_hit *hit) {
    double opacity = hit->painted ? 0.5 + 0.5 * hit->opacity : hit->opacity;
    double slant = fmax(hit->normal.z, 0.1);
    if (hit->wired) opacity = fmax(opacity, WIRE_OPACITY);
    return (float)((hit->behind ? 0.7 : 1.0) * (1.0 - sn_quick_pow(1.0 - opacity, 1.0 / slant)));
}

/* Front to back through the translucent layers down to what is solid. */
static void cast_glass(const picture *p, band *b) {
    if (!p->glass.surface) return;
    for (sn_index row = 0; row < b->height; row++)
        for (sn_index column = 0; column < b->width; column++) {
            double x = b->left + column * b->step, y = b->top - row * b->step, near = INFINITY;
            sample *s = &b->samples[(size_t)row * (size_t)b->width + (size_t)column];
            tint sum = {0, 0, 0};
            float through = 1.0f;
            layer_hit hit;
            for (int i = 0; i < GLASS_LAYERS && through > 0.01f && layer_cast(&p->glass, x, y, near, s->depth, &hit); i++) {
                if (i == 0 && hit.z > s->front) {
                    s->front = hit.z;
                    s->id = hit.id;
                }
                float opacity = shell_opacity(&hit);
                tint light = tint_scale(shade(hit.albedo, hit.normal, hit.open, hit.gloss), through * opacity);
                sum = (tint){sum.r + light.r, sum.g + light.g, sum.b + light.b};
                through *= 1.0f - opacity;
                near = hit.z - p->epsilon;
            }
            s->color = (tint){sum.r + through * s->color.r, sum.g + through * s->color.g, sum.b + through * s->color.b};
        }
}

/* How much a contour runs between this sample and the neighbour behind it, against the opposite neighbour: 0..1. */
static float contour_step(const sample *here, const sample *next, const sample *opposite) {
    if (next->front == -INFINITY) return 1.0f;
    if (!(next->front < here->front)) return 0.0f;
    const float threshold = 4.0f; /* pixels of depth */
    float slope = opposite->front == -INFINITY ? 0.0f : fmaxf(opposite->front - here->front, 0.0f);
    float gap = here->front - slope - next->front;
    return fminf(fmaxf((gap - threshold) / (3.0f * threshold), 0.0f), 1.0f);
}

static float contour_at(const band *b, sn_index row, sn_index column, sn_index reach) {
    const sample *here = &b->samples[(size_t)row * (size_t)b->width + (size_t)column];
    if (here->id < 0) return 0.0f;
    const ptrdiff_t steps[4] = {reach, -reach, (ptrdiff_t)reach * b->width, -(ptrdiff_t)reach * b->width};
    float strongest = 0.0f;
    for (int i = 0; i < 4; i++) strongest = fmaxf(strongest, contour_step(here, here + steps[i], here - steps[i]));
    return strongest;
}

/* Average the samples of each pixel; `margin` samples around the band serve the contours. */
static void filter(const picture *p, const band *b, sn_index first_row, sn_index rows, sn_index margin) {
    const sn_index n = p->options->samples;
    const float share = 1.0f / (float)(n * n);
    for (sn_index y = 0; y < rows; y++)
        for (sn_index x = 0; x < p->image->width; x++) {
            tint sum = {0, 0, 0};
            for (sn_index k = 0; k < n * n; k++) {
                sn_index row = margin + y * n + k / n, column = margin + x * n + k % n;
                const sample *s = &b->samples[(size_t)row * (size_t)b->width + (size_t)column];
                float light = share * (1.0f - 0.55f * contour_at(b, row, column, margin));
                sum = (tint){sum.r + s->color.r * light, sum.g + s->color.g * light, sum.b + s->color.b * light};
            }
            uint8_t *pixel = p->image->rgb + 3 * ((size_t)(first_row + y) * (size_t)p->image->width + (size_t)x);
            pixel[0] = (uint8_t)(channel_to_srgb(sum.r) * 255.0 + 0.5);
            pixel[1] = (uint8_t)(channel_to_srgb(sum.g) * 255.0 + 0.5);
            pixel[2] = (uint8_t)(channel_to_srgb(sum.b) * 255.0 + 0.5);
        }
}

static void render_band(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    picture *p = user;
    const sn_index n = p->options->samples, margin = n / 2 > 1 ? n / 2 : 1;
    band b = {.width = p->image->width * n + 2 * margin, .height = (end - begin) * n + 2 * margin, .step = 1.0 / n};
    b.left = (0.5 - margin) * b.step;
    b.top = p->frame.height - begin - (0.5 - margin) * b.step;
    b.samples = SN_NEW(sample, (size_t)b.width * (size_t)b.height);
    if (!b.samples) {
        atomic_store(&p->out_of_memory, true);
        return;
    }
    cast_solid(p, &b);
    tubes_draw(&b, p->tube_count, p->tubes);
    cast_glass(p, &b);
    filter(p, &b, begin, end - begin, margin);
    free(b.samples);
}

static sn_status place_tubes(picture *p, const sn_view *view, sn_error *error) {
    p->tubes = SN_NEW(tube, view->tube_count);
    if (!p->tubes) return sn_fail_memory(error, "the lines of the picture");
    double side = fmax(p->frame.width, p->frame.height);
    for (size_t i = 0; i < view->tube_count; i++) {
        const sn_view_tube *t = &view->tubes[i];
        p->tubes[i] = (tube){frame_apply(&p->frame, t->a), frame_apply(&p->frame, t->b), fmax(t->radius * side, 0.35), tint_from(t->color)};
        if (!sn_finite3(p->tubes[i].a) || !sn_finite3(p->tubes[i].b))
            return sn_fail(error, SN_ERROR_INPUT, "the subject is too large to draw: its coordinates overflow");
    }
    p->tube_count = view->tube_count;
    return SN_OK;
}

static sn_status prepare(picture *p, const sn_view *view, const sn_camera *camera, inset clear, sn_pool *pool, sn_error *error) {
    sn_status status = frame_set(&p->frame, camera, p->image->width, p->image->height, clear, error);
    if (!status) status = place_tubes(p, view, error);
    if (!status) status = layer_build(&p->solid, view, &p->frame, true, error);
    if (!status) status = layer_build(&p->glass, view, &p->frame, false, error);
    if (!status) status = layer_occlude(&p->solid, NULL, pool, error);
    if (!status) status = layer_occlude(&p->glass, &p->solid, pool, error);
    p->background = tint_from(p->options->background);
    p->epsilon = fmax(0.01, p->glass.surface ? 1e-6 * sn_box_diagonal(p->glass.box) : 0.0);
    return status;
}

sn_status picture_render(const sn_tile *tile, const sn_view_options *options, inset clear, sn_pool *pool, sn_image *image,
                         sn_error *error) {
    picture p = {.options = options, .image = image};
    sn_status status = SN_OK;
    if (options->samples < 1 || options->samples > 8)
        status = sn_fail(error, SN_ERROR_USAGE, "%d samples per pixel side is out of range: 1 to 8", options->samples);
    if (!status) status = prepare(&p, tile->view, tile->camera, clear, pool, error);
    if (!status) sn_parallel_for(pool, image->height, BAND_ROWS, render_band, &p);
    if (!status && atomic_load(&p.out_of_memory)) status = sn_fail_memory(error, "the picture's samples");
    layer_free(&p.solid);
    layer_free(&p.glass);
    free(p.tubes);
    return status;
}
