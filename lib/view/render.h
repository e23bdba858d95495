/*
 * render.h -- the parts of the renderer: private to lib/view.
 *
 * Inside the renderer everything is in the picture's own frame: x right and y up in pixels from the lower left corner, z towards the
 * viewer in pixels. Colours are linear. Rays go along -z.
 */
#ifndef SINEW_VIEW_RENDER_H
#define SINEW_VIEW_RENDER_H

#include "sinew/thread.h"
#include "sinew/view.h"

typedef struct tint {
    float r, g, b;
} tint; /* linear light */

tint tint_from(sn_color color);
double channel_to_srgb(double linear); /* 0..1 */

static inline tint tint_mix(tint a, tint b, float t) { return (tint){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t}; }
static inline tint tint_scale(tint a, float s) { return (tint){a.r * s, a.g * s, a.b * s}; }

/* World to picture. */
typedef struct frame {
    sn_vec3 right, up, back, centre; /* centre: in the camera's frame */
    double pixels_per_meter;
    double x, y;          /* where the centre comes to lie */
    double width, height; /* of the picture */
} frame;
/* Pixels of the picture that the subject keeps clear of: they are for text. */
typedef struct inset {
    double top, bottom;
} inset;
SN_MUST_CHECK sn_status frame_set(frame *f, const sn_camera *camera, double width, double height, inset clear, sn_error *error);
sn_vec3 frame_apply(const frame *f, sn_vec3 world);

/* Light that a surface with unit normal n (towards the viewer where seen from its outside) sends to the viewer. open: share of the sky
 * that it sees. */
tint shade(tint albedo, sn_vec3 n, float open, float gloss);

/* ---- layers (layer.c): all solid meshes of a view in one, all translucent ones in another --------------------------------- */

typedef struct layer_part {
    tint color;
    float opacity, gloss;
    bool wire, graded; /* graded: its vertices have colours of their own */
    sn_index id;
} layer_part;

typedef struct layer {
    sn_mesh mesh;
    sn_vec3 *normals; /* (vertex_count) */
    float *open;      /* (vertex_count) share of the sky seen from outside */
    sn_index *paint;  /* (vertex_count) into paints, SN_NONE = plain */
    sn_index *part;   /* (triangle_count) into parts */
    size_t part_count, paint_count;
    layer_part *parts;
    tint *paints;
    tint *tints; /* (vertex_count) of graded parts; NULL = none is */
    sn_box box;
    sn_surface *surface; /* NULL = nothing to hit */
} layer;

SN_MUST_CHECK sn_status layer_build(layer *l, const sn_view *view, const frame *f, bool solid, sn_error *error);
void layer_free(layer *l);
/* Fill `open` by casting rays against the layer itself and, where not NULL, `other`. */
SN_MUST_CHECK sn_status layer_occlude(layer *l, const layer *other, sn_pool *pool, sn_error *error);

/* What a ray hits at (x, y), going down from z = near. false = nothing above z = far. */
typedef struct layer_hit {
    float z;
    sn_vec3 normal; /* towards the viewer */
    tint albedo;
    float open, gloss, opacity;
    bool behind;         /* the surface is seen from its inner side */
    bool painted, wired; /* wired: on an edge that is drawn */
    sn_index id;
} layer_hit;
bool layer_cast(const layer *l, double x, double y, double near, double far, layer_hit *hit);

/* ---- samples of a band of rows ---------------------------------------------------------------------------------------------- */

typedef struct sample {
    tint color;
    float depth; /* z of the nearest solid thing; -INFINITY = background */
    float front; /* z of the nearest thing, translucent ones too */
    sn_index id; /* of the mesh in front; SN_NONE = background, -2 = a tube */
} sample;

typedef struct band {
    sn_index width, height; /* samples */
    double left, top, step; /* centre of sample (0, 0), distance between samples; pixels */
    sample *samples;        /* (height x width) top row first */
} band;

/* Render a tile's view, without its caption, into an image that is there. */
SN_MUST_CHECK sn_status picture_render(const sn_tile *tile, const sn_view_options *options, inset clear, sn_pool *pool, sn_image *image,
                                       sn_error *error);

/* Draw the capsules with depth test (tubes.c). */
typedef struct tube {
    sn_vec3 a, b;
    double radius;
    tint color;
} tube;
void tubes_draw(band *b, size_t count, const tube *tubes);

#endif
