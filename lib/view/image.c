/* image.c -- the image and its pixels. */
#include "image.h"

#include <stdlib.h>

static uint8_t to_byte(double value) { return (uint8_t)(fmin(fmax(value, 0.0), 1.0) * 255.0 + 0.5); }

sn_status sn_image_alloc(sn_image *image, sn_index width, sn_index height, sn_color fill, sn_error *error) {
    *image = (sn_image){0};
    if (width < 1 || height < 1 || width > SN_IMAGE_SIDE_MAX || height > SN_IMAGE_SIDE_MAX)
        return sn_fail(error, SN_ERROR_USAGE, "a picture of %d x %d pixels is out of range: each side must be 1 to %d", width, height,
                       SN_IMAGE_SIDE_MAX);
    size_t pixels = (size_t)width * (size_t)height;
    image->rgb = sn_alloc(pixels, 3);
    if (!image->rgb) return sn_fail_memory(error, "the picture");
    image->width = width;
    image->height = height;
    const uint8_t bytes[3] = {to_byte(fill.r), to_byte(fill.g), to_byte(fill.b)};
    for (size_t i = 0; i < 3 * pixels; i++) image->rgb[i] = bytes[i % 3];
    return SN_OK;
}

void sn_image_free(sn_image *image) {
    free(image->rgb);
    *image = (sn_image){0};
}

void image_blend(sn_image *image, sn_index x, sn_index y, sn_color color, double coverage) {
    if (x < 0 || y < 0 || x >= image->width || y >= image->height || !(coverage > 0.0)) return;
    uint8_t *pixel = image->rgb + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    const double channels[3] = {color.r, color.g, color.b};
    for (int c = 0; c < 3; c++) pixel[c] = to_byte((1.0 - coverage) * pixel[c] / 255.0 + coverage * channels[c]);
}

/* Distance from p to the segment a..b, in the plane. */
static double segment_distance(double px, double py, double ax, double ay, double bx, double by) {
    double dx = bx - ax, dy = by - ay, length2 = dx * dx + dy * dy;
    double t = length2 > 0.0 ? fmin(fmax(((px - ax) * dx + (py - ay) * dy) / length2, 0.0), 1.0) : 0.0;
    return sn_length2(px - ax - t * dx, py - ay - t * dy);
}

void image_lines(sn_image *image, size_t count, const image_line *lines, double radius, sn_color color) {
    if (count == 0) return;
    double low_x = INFINITY, low_y = INFINITY, high_x = -INFINITY, high_y = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        low_x = fmin(low_x, fmin(lines[i].ax, lines[i].bx));
        high_x = fmax(high_x, fmax(lines[i].ax, lines[i].bx));
        low_y = fmin(low_y, fmin(lines[i].ay, lines[i].by));
        high_y = fmax(high_y, fmax(lines[i].ay, lines[i].by));
    }
    sn_index x0 = (sn_index)fmax(floor(low_x - radius - 1.0), 0.0), y0 = (sn_index)fmax(floor(low_y - radius - 1.0), 0.0);
    sn_index x1 = (sn_index)fmin(ceil(high_x + radius + 1.0), image->width - 1.0);
    sn_index y1 = (sn_index)fmin(ceil(high_y + radius + 1.0), image->height - 1.0);
    for (sn_index y = y0; y <= y1; y++)
        for (sn_index x = x0; x <= x1; x++) {
            double nearest = INFINITY;
            for (size_t i = 0; i < count; i++)
                nearest = fmin(nearest, segment_distance(x + 0.5, y + 0.5, lines[i].ax, lines[i].ay, lines[i].bx, lines[i].by));
            image_blend(image, x, y, color, fmin(fmax(radius + 0.5 - nearest, 0.0), 1.0));
        }
}

void image_rectangle(sn_image *image, sn_index x, sn_index y, sn_index width, sn_index height, sn_color color) {
    for (sn_index row = y; row < y + height; row++)
        for (sn_index column = x; column < x + width; column++) image_blend(image, column, row, color, 1.0);
}

void image_paste(sn_image *image, const sn_image *other, sn_index x, sn_index y) {
    for (sn_index row = 0; row < other->height && y + row < image->height; row++)
        for (sn_index column = 0; column < other->width && x + column < image->width; column++)
            for (int c = 0; c < 3; c++)
                image->rgb[3 * ((size_t)(y + row) * (size_t)image->width + (size_t)(x + column)) + (size_t)c] =
                    other->rgb[3 * ((size_t)row * (size_t)other->width + (size_t)column) + (size_t)c];
}
