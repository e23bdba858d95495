/* shade.c -- colour spaces, the frame, and the light: a key from the upper left, a soft fill from the right, sky over warm ground. */
#include "render.h"

static float to_linear(double srgb) {
    double c = fmin(fmax(srgb, 0.0), 1.0);
    return (float)(c <= 0.04045 ? c / 12.92 : sn_quick_pow((c + 0.055) / 1.055, 2.4));
}

tint tint_from(sn_color color) { return (tint){to_linear(color.r), to_linear(color.g), to_linear(color.b)}; }

double channel_to_srgb(double linear) {
    double c = fmin(fmax(linear, 0.0), 1.0);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * sn_quick_pow(c, 1.0 / 2.4) - 0.055;
}

sn_status frame_set(frame *f, const sn_camera *camera, double width, double height, inset clear, sn_error *error) {
    const double margin = 0.92; /* share of the room that the subject fills */
    sn_box box = camera->extent;
    bool empty = !(box.low.x <= box.high.x);
    sn_vec3 size = empty ? sn_v3(0, 0, 0) : sn_sub(box.high, box.low);
    if (!isfinite(sn_norm(size)) || !(camera->zoom > 0.0))
        return sn_fail(error, SN_ERROR_INPUT, "the subject is too large to draw: its coordinates overflow");
    double room = fmax(height - clear.top - clear.bottom, 0.25 * height);
    double scale = fmax(size.x / width, size.y / room) / margin;
    if (!(scale > 0.0)) scale = fmax(size.z / width, 1e-300);
    *f = (frame){.right = camera->right, .up = camera->up, .back = camera->back, .width = width, .height = height};
    f->centre = empty ? size : sn_lerp(box.low, box.high, 0.5);
    f->pixels_per_meter = isfinite(camera->zoom / scale) ? camera->zoom / scale : 1.0;
    f->x = 0.5 * width;
    f->y = 0.5 * (height - clear.top - clear.bottom) + clear.bottom;
    return SN_OK;
}

sn_vec3 frame_apply(const frame *f, sn_vec3 world) {
    sn_vec3 q = sn_v3(sn_dot(world, f->right), sn_dot(world, f->up), sn_dot(world, f->back));
    q = sn_scale(sn_sub(q, f->centre), f->pixels_per_meter);
    return sn_v3(q.x + f->x, q.y + f->y, q.z);
}

static float clamp01(double value) { return (float)fmin(fmax(value, 0.0), 1.0); }

tint shade(tint albedo, sn_vec3 n, float open, float gloss) {
    static const sn_vec3 KEY = {-0.4523, 0.6031, 0.6569}, FILL = {0.8018, 0.0535, 0.5952}; /* unit */
    static const sn_vec3 HALF = {-0.2485, 0.3313, 0.9102};                                 /* between KEY and the viewer (0,0,1) */
    /* wrapped diffuse: light creeps a little around the form, as it does in flesh */
    float key = clamp01((sn_dot(n, KEY) + 0.25) / 1.25), fill = clamp01(sn_dot(n, FILL));
    float sky = (float)(0.5 + 0.5 * n.y);
    float crevice = 0.35f + 0.65f * open;
    tint light = {0.86f * key * crevice + 0.13f * fill * open + (0.20f + 0.12f * sky) * open,
                  0.83f * key * crevice + 0.14f * fill * open + (0.19f + 0.15f * sky) * open,
                  0.78f * key * crevice + 0.17f * fill * open + (0.19f + 0.18f * sky) * open};
    double h = fmax(sn_dot(n, HALF), 0.0), h2 = h * h, h4 = h2 * h2, h8 = h4 * h4, h16 = h8 * h8;
    float shine = gloss * open * (float)(0.20 * h16 * h16 + 0.05 * h8);
    return (tint){albedo.r * light.r + shine, albedo.g * light.g + shine, albedo.b * light.b + shine};
}
