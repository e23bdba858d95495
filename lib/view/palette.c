/* palette.c -- one colour a bone, by name, in all views that share a palette. */
#include "show.h"

#include <stdlib.h>
#include <string.h>

enum { PICKED = 8 };
/* How much of its colour a bone shows: the attachments, in the full colour, must stand out where they lie on it. */
static const double TINT = 0.45;

void sn_palette_free(sn_palette *palette) {
    for (size_t i = 0; i < palette->count; i++) free(palette->names[i]);
    free(palette->names);
    *palette = (sn_palette){0};
}

sn_color hue_color(size_t i) {
    double hue = 0.12 + 0.6180339887498949 * (double)i, value = i / PICKED % 2 == 0 ? 0.92 : 0.62;
    double part[3];
    for (int k = 0; k < 3; k++) {
        double t = hue + k / 3.0, wave = fabs(2.0 * (t - floor(t)) - 1.0); /* 1 at the hue, 0 opposite */
        part[k] = value * (0.30 + 0.70 * fmin(fmax(3.0 * wave - 1.0, 0.0), 1.0));
    }
    return (sn_color){part[0], part[1], part[2]};
}

/* The first few are picked by eye; the others are like nothing before them by their hues. */
static sn_color color_of(size_t i) {
    static const sn_color colors[PICKED] = {{0.93, 0.68, 0.16}, {0.10, 0.62, 0.60}, {0.88, 0.45, 0.62}, {0.60, 0.73, 0.22},
                                            {0.30, 0.70, 0.88}, {0.90, 0.46, 0.15}, {0.56, 0.52, 0.88}, {0.55, 0.45, 0.33}};
    return i < PICKED ? colors[i] : hue_color(i);
}

static size_t find(const sn_palette *palette, const char *name) {
    size_t i = 0;
    while (i < palette->count && strcmp(palette->names[i], name) != 0) i++;
    return i;
}

sn_status sn_palette_color(sn_palette *palette, const char *name, sn_color *color, sn_error *error) {
    size_t i = find(palette, name);
    *color = color_of(i);
    if (i < palette->count) return SN_OK;
    char *copy = sn_strdup(name);
    if (!copy || !sn_grow((void **)&palette->names, &palette->capacity, palette->count + 1, sizeof *palette->names)) {
        free(copy);
        return sn_fail_memory(error, "the bones' colours");
    }
    palette->names[palette->count++] = copy;
    return SN_OK;
}

sn_palette *palette_of(sn_view *view) { return view->palette ? view->palette : &view->own_palette; }

sn_color bone_color(sn_view *view, const char *name) {
    const sn_palette *palette = palette_of(view);
    size_t i = view->attachments_shown && name ? find(palette, name) : palette->count;
    const sn_color ivory = COLOR_BONE, full = color_of(i);
    if (i == palette->count) return ivory;
    return (sn_color){ivory.r + (full.r - ivory.r) * TINT, ivory.g + (full.g - ivory.g) * TINT, ivory.b + (full.b - ivory.b) * TINT};
}

sn_status name_mesh(sn_view *view, const char *name, sn_error *error) {
    sn_view_mesh *mesh = &view->meshes[view->mesh_count - 1];
    free(mesh->name);
    mesh->name = name ? sn_strdup(name) : NULL;
    return mesh->name || !name ? SN_OK : sn_fail_memory(error, "a name in the picture");
}
