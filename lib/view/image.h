/* image.h -- drawing in the plane: private to lib/view. Pixel (x, y) covers [x, x+1) x [y, y+1), y down. */
#ifndef SINEW_VIEW_IMAGE_H
#define SINEW_VIEW_IMAGE_H

#include "sinew/view.h"

typedef struct image_line {
    double ax, ay, bx, by;
} image_line;

/* Mix color into one pixel; outside the image nothing happens. */
void image_blend(sn_image *image, sn_index x, sn_index y, sn_color color, double coverage);
/* Round-ended lines drawn as one shape, so that where they cross nothing is blended twice. */
void image_lines(sn_image *image, size_t count, const image_line *lines, double radius, sn_color color);
void image_rectangle(sn_image *image, sn_index x, sn_index y, sn_index width, sn_index height, sn_color color);
/* Copy other into image with its top left corner at (x, y) >= 0; what does not fit is cut. */
void image_paste(sn_image *image, const sn_image *other, sn_index x, sn_index y);

#endif
