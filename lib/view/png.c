/* png.c -- an image as PNG bytes: the only user of libpng. */
#include "sinew/view.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

typedef struct png_bytes {
    unsigned char *data;
    size_t size, capacity;
} png_bytes;

static void append(png_structp png, png_bytep data, png_size_t size) {
    png_bytes *bytes = png_get_io_ptr(png);
    if (size > SIZE_MAX - bytes->size || !sn_grow((void **)&bytes->data, &bytes->capacity, bytes->size + size, 1))
        png_error(png, "out of memory");
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

static void flush(png_structp png) { (void)png; }

/* libpng leaves by longjmp on errors; no local that changes after setjmp is read behind it. */
static void failed(png_structp png, png_const_charp text) {
    sn_error *error = png_get_error_ptr(png);
    sn_fail(error, strcmp(text, "out of memory") == 0 ? SN_ERROR_MEMORY : SN_ERROR_INTERNAL, "encoding the picture failed: %s", text);
    png_longjmp(png, 1);
}

static void warned(png_structp png, png_const_charp text) {
    (void)png;
    sn_log(SN_LOG_WARNING, "libpng: %s", text);
}

static bool encode(png_structp png, png_infop info, const sn_image *image, png_bytes *bytes) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, bytes, append, flush);
    png_set_IHDR(png, info, (png_uint_32)image->width, (png_uint_32)image->height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (sn_index y = 0; y < image->height; y++) png_write_row(png, image->rgb + 3 * (size_t)y * (size_t)image->width);
    png_write_end(png, NULL);
    return true;
}

sn_status sn_image_to_png(const sn_image *image, unsigned char **data, size_t *size, sn_error *error) {
    sn_error own = {0};
    png_bytes bytes = {0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &own, failed, warned);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool done = info && encode(png, info, image, &bytes);
    png_destroy_write_struct(&png, &info);
    if (!done) {
        free(bytes.data);
        return own.code ? sn_fail(error, own.code, "%s", own.text) : sn_fail_memory(error, "the PNG encoder");
    }
    *data = bytes.data;
    *size = bytes.size;
    return SN_OK;
}
