/* show.h -- the colours of things, and what the builders share: private to lib/view. */
#ifndef SINEW_VIEW_SHOW_H
#define SINEW_VIEW_SHOW_H

#include "sinew/view.h"

static const sn_color COLOR_MUSCLE = {0.69, 0.25, 0.20}, COLOR_RELAXED = {0.64, 0.36, 0.32}, COLOR_ACTIVE = {0.76, 0.13, 0.10};
static const sn_color COLOR_BONE = {0.95, 0.91, 0.82}, COLOR_ROOTS = {0.56, 0.12, 0.78}, COLOR_BRANCH = {0.10, 0.72, 0.25};
static const sn_color COLOR_CONNECTION = {0.16, 0.42, 0.92}, COLOR_FIBER = {0.98, 0.87, 0.76};

/* Colour number i of as many as it takes: hues a golden section of the circle apart, darker in every second turn of eight (palette.c). */
sn_color hue_color(size_t i);
sn_palette *palette_of(sn_view *view);
sn_color bone_color(sn_view *view, const char *name); /* name is nullable */
/* Name the mesh that was added last; name is nullable. */
SN_MUST_CHECK sn_status name_mesh(sn_view *view, const char *name, sn_error *error);

/* About `target` vertices, evenly spread over the surface (Poisson disc, in index order); all where there are fewer. *radius is the
 * least distance kept, 0 = none. *out (*count) is owned by the caller. */
SN_MUST_CHECK sn_status spread_vertices(const sn_mesh *mesh, sn_index target, sn_index *count, sn_index **out, double *radius,
                                        sn_error *error);

/* Fibre directions as short lines that follow them along the surface, and fibres through the volume (fibers.c). */
SN_MUST_CHECK sn_status show_fibers(sn_view *view, const sn_muscle *muscle, sn_error *error);

/* Its vertices in one colour per target, that of the nearest one of each, with lines for the legend (show_externals.c). */
SN_MUST_CHECK sn_status paint_externals(sn_view *view, sn_view_mesh *mesh, const sn_muscle *muscle, sn_error *error);

/* A scene's bones that sn_view_draws_bone has, as they lie at a time, s. */
SN_MUST_CHECK sn_status show_bones(sn_view *view, const sn_scene *scene, double time, unsigned show, sn_error *error);
/* Sections through the distance fields of its bones that muscles may touch, as the scene's contact has them. */
SN_MUST_CHECK sn_status show_distance_fields(sn_view *view, const sn_scene *scene, double time, sn_error *error);
/* Its loaded surfaces, translucent; wire: with their edges. */
SN_MUST_CHECK sn_status show_envelopes(sn_view *view, const sn_scene *scene, double time, bool wire, sn_error *error);

/* The sections of a muscle that `show` names and that are there, its surface in a colour. */
SN_MUST_CHECK sn_status show_rig(sn_view *view, const sn_muscle *muscle, unsigned show, sn_color color, sn_error *error);

#endif
