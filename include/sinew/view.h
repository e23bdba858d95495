/*
 * view.h -- pictures of rigs: a plain description of what to draw, a camera, and a renderer to an RGB image.   rank 3
 *
 * No window and no GPU: rays are cast with geom.h's surface search. Everything in a view is in metres, z up; a camera looks without
 * perspective, so that lengths can be read from the picture. The same view gives the same bytes on any number of threads.
 */
#ifndef SINEW_VIEW_H
#define SINEW_VIEW_H

#include "sinew/geom.h"
#include "sinew/scene.h"
#include "sinew/sim.h"

typedef struct sn_color {
    double r, g, b;
} sn_color; /* sRGB, each in [0,1] */

/* ---- images --------------------------------------------------------------------------------------------------------- */

#define SN_IMAGE_SIDE_MAX 16384 /* pixels */

typedef struct sn_image {
    sn_index width, height;
    uint8_t *rgb; /* (height x width x 3) top row first; owned */
} sn_image;

SN_MUST_CHECK sn_status sn_image_alloc(sn_image *image, sn_index width, sn_index height, sn_color fill, sn_error *error);
void sn_image_free(sn_image *image);
/* Encode as an 8-bit RGB PNG (lib/view/png.c). *data is owned by the caller: free(). */
SN_MUST_CHECK sn_status sn_image_to_png(const sn_image *image, unsigned char **data, size_t *size, sn_error *error);

/* ---- text: a stroke font of our own (lib/view/text.c) ---------------------------------------------------------------- */

typedef struct sn_text_style {
    double size;   /* height of a capital, pixels */
    double weight; /* the stroke's thickness relative to the font's own: 1 = regular, 1.6 = bold */
    sn_color color;
} sn_text_style;

/* Draw text with its baseline starting at pixel (x, y). Text is UTF-8; what is outside ASCII shows as a box. */
void sn_text_draw(sn_image *image, double x, double y, sn_text_style style, const char *text);
double sn_text_width(double size, const char *text); /* pixels */

/* ---- what a picture shows ---------------------------------------------------------------------------------------------- */

/* Things that a muscle can show, as bits. */
typedef enum sn_view_show {
    SN_SHOW_SURFACE = 1,
    SN_SHOW_ROOTS = 2,
    SN_SHOW_STRUCTURE = 4,
    SN_SHOW_FIBERS = 8,
    SN_SHOW_ATTACHMENTS = 16,
    SN_SHOW_BONES = 32,
    SN_SHOW_WIRE = 64,
    SN_SHOW_JOINTS = 256,     /* of a motion: its stick figure */
    SN_SHOW_ENVELOPES = 512,  /* of a scene: its surfaces, envelopes and driven meshes, translucent */
    SN_SHOW_FIELDS = 1024,    /* of a scene: sections through the distance fields of its bones */
    SN_SHOW_EXTERNALS = 2048, /* of a muscle: in place of attachments, which target each vertex has as its nearest */
    SN_SHOW_ALL_BONES = 4096, /* of a scene: also bones that no muscle is attached to */
    SN_SHOW_AUTO = 128        /* the sections that are there, drawn so that they can be told apart */
} sn_view_show;

/* Colours of bones by their names, in the order in which they were first asked for. All zeros = empty. */
typedef struct sn_palette {
    size_t count, capacity;
    char **names; /* (count) owned */
} sn_palette;
void sn_palette_free(sn_palette *palette);
/* The colour of a name, which is the palette's from now on. */
SN_MUST_CHECK sn_status sn_palette_color(sn_palette *palette, const char *name, sn_color *color, sn_error *error);

typedef struct sn_view_mesh {
    char *name; /* nullable: of the muscle, bone or surface that it is */
    bool focus; /* the camera looks at such meshes alone, where a view has any */
    sn_index vertex_count, triangle_count;
    sn_vec3 *positions;     /* (vertex_count) */
    sn_triangle *triangles; /* (triangle_count) */
    sn_color color;
    double opacity; /* in (0,1]: 1 = solid; else every layer of it is blended over what lies behind */
    double gloss;   /* 0 = chalk, 1 = wet */
    bool wire;      /* draw the edges of its triangles too */
    sn_index paint_count;
    sn_color *paints; /* (paint_count) */
    sn_index *paint;  /* (vertex_count) index of the vertex's paint, SN_NONE = plain; NULL = no paint */
    sn_color *colors; /* (vertex_count) a colour of each vertex, blended between them; NULL = none; they go before paint */
} sn_view_mesh;

/* A capsule from a to b; a sphere where a equals b. */
typedef struct sn_view_tube {
    sn_vec3 a, b;
    double radius; /* as a share of the picture's longer side: thickness on paper, the same under any zoom */
    sn_color color;
} sn_view_tube;

typedef enum sn_view_mark { SN_MARK_AREA, SN_MARK_LINE, SN_MARK_DOT, SN_MARK_RING } sn_view_mark;

/* A line of the legend. */
typedef struct sn_view_entry {
    char *text;
    char *detail; /* nullable: a count or so, in brackets behind the text; a sheet whose tiles differ in it leaves it out */
    sn_view_mark mark;
    sn_color color;
} sn_view_entry;

/* A scale of colours from 0 to high; what is above has the last one. */
typedef struct sn_view_scale {
    char *text; /* what it measures, with its unit; NULL = no scale */
    double high;
    bool open; /* there is more above `high` */
} sn_view_scale;

/* A picture's content; an empty one is all zeros. Owns everything in it. */
typedef struct sn_view {
    char *title, *subtitle; /* nullable */
    size_t mesh_count, mesh_capacity, tube_count, tube_capacity, entry_count, entry_capacity;
    sn_view_mesh *meshes;
    sn_view_tube *tubes;
    sn_view_entry *entries;
    sn_view_scale scale;
    size_t ring_count, ring_capacity;
    sn_vec3 *rings;         /* (ring_count) places to draw a ring around, also where they are hidden; they belong to the lettering */
    bool attachments_shown; /* bones have the colours of the attachments to them */
    sn_palette own_palette;
    sn_palette *palette; /* nullable, borrowed: one for views whose bones are to have the same colours; NULL = own_palette */
} sn_view;

void sn_view_free(sn_view *view); /* frees what it owns and zeroes it */
/* Where a mesh goes: each point p of it to pose(meters_per_unit x p). */
typedef struct sn_placement {
    double meters_per_unit;
    const sn_rigid *pose; /* metres; NULL = as it lies */
} sn_placement;

/* Add a copy of a valid mesh. Colour, opacity 1, gloss 0 and no paint; *out (nullable) lets the caller change that and lives until the
 * next mesh is added. */
SN_MUST_CHECK sn_status sn_view_add_mesh(sn_view *view, const sn_mesh *mesh, sn_placement placement, sn_color color, sn_view_mesh **out,
                                         sn_error *error);
SN_MUST_CHECK sn_status sn_view_add_tube(sn_view *view, sn_view_tube tube, sn_error *error);
/* Add a line to the legend; one with the same text and colour is not added again. */
SN_MUST_CHECK sn_status sn_view_add_entry(sn_view *view, sn_view_mark mark, sn_color color, const char *text, sn_error *error);
/* The same with a detail (nullable); where a line is added again with another one, it loses its detail. */
SN_MUST_CHECK sn_status sn_view_add_entry_detail(sn_view *view, sn_view_mark mark, sn_color color, const char *text, const char *detail,
                                                 sn_error *error);
SN_MUST_CHECK sn_status sn_view_add_ring(sn_view *view, sn_vec3 at, sn_error *error);
/* Have the camera look at the meshes whose names match (sn_pattern_matches: * and ?), and at those of earlier calls. Returns how many
 * match. */
size_t sn_view_focus(sn_view *view, const char *pattern);
/* The colour of a scale at t: 0 = its start, 1 and above = its end; NaN = its end. */
sn_color sn_scale_color(double t);

/* ---- builders (lib/view/show_muscle.c, show_scene.c, show_state.c) ------------------------------------------------------- */

/* A muscle document, also a partial one: surface, roots purple, branches green, connections blue ([R18] figure 2), fibre directions
 * as short lines along the surface, attachments in one colour per bone. `show` is bits of sn_view_show. Sets the title and the
 * subtitle (counts) where there is none yet. */
SN_MUST_CHECK sn_status sn_view_add_muscle(sn_view *view, const sn_muscle *muscle, unsigned show, sn_error *error);
/* A bone, as sn_view_add_mesh; name (nullable) goes into the legend. It is ivory, tinted with its name's colour where attachments to it are
 * shown in this view. */
SN_MUST_CHECK sn_status sn_view_add_bone(sn_view *view, const char *name, const sn_mesh *mesh, sn_placement placement, sn_error *error);

/* Surfaces by name that rows lie on, or that a section goes through. */
typedef struct sn_view_target {
    const char *name;
    const sn_mesh *mesh;
    double meters_per_unit;
} sn_view_target;
typedef struct sn_view_targets {
    sn_index count;
    const sn_view_target *items; /* (count) */
} sn_view_targets;

/* The muscle's external rows, coloured by what acts most in them (sn_external_blend: slide, soft, hard): from vertex to target, which is
 * drawn translucent, or a dot where the target is not given. SN_ERROR_INPUT where a target is not the mesh that its rows were found on. */
SN_MUST_CHECK sn_status sn_view_add_externals(sn_view *view, const sn_muscle *muscle, const sn_view_targets *targets, sn_error *error);

/* A section as in [R18] figure 11. */
typedef struct sn_view_section {
    const sn_muscle *muscle;
    const sn_view_targets *targets, *bones; /* of the targets those that the muscle has rows on are drawn */
    sn_vec3 point, normal;                  /* of the plane, metres; any length > 0 */
    double depth;                           /* rows that start within it of the plane are drawn, on the plane; metres */
} sn_view_section;
/* Outlines of the muscle, its targets and the bones in a plane, and rows near it as sn_view_add_externals has them. SN_ERROR_INPUT where
 * the plane does not cut the muscle. */
SN_MUST_CHECK sn_status sn_view_add_section(sn_view *view, const sn_view_section *section, sn_error *error);

/* A scene at a time in seconds: bones in their pose, muscles coloured by activation. positions (nullable; muscle_count; entries
 * nullable): the muscle's vertices at that time, in metres; without, the muscle is at rest. SN_SHOW_AUTO is muscles, bones and surfaces
 * here; structure and fibre directions show only at rest, which they belong to; fibres through the volume show where they are: beside
 * positions they must be that time's, in metres, or none. Bones are drawn as sn_view_draws_bone says. */
SN_MUST_CHECK sn_status sn_view_add_scene(sn_view *view, const sn_scene *scene, double time, const sn_vec3 *const *positions, unsigned show,
                                          sn_error *error);

/* Is a bone of the scene drawn? With SN_SHOW_ALL_BONES each; else those that an enabled muscle is attached to, by their own or their
 * joint's name, or each where that is none of them. */
bool sn_view_draws_bone(const sn_scene *scene, sn_index bone, unsigned show);

/* What a state is coloured by: the errors of a kind of rows (sn_row_kind, which come first), or contact at the vertices. */
typedef enum sn_state_figure {
    SN_FIGURE_ROWS = 0, /* to SN_ROW_KINDS - 1 */
    SN_FIGURE_PRESSURE = SN_ROW_KINDS,
    SN_FIGURE_PENETRATION,
    SN_FIGURES
} sn_state_figure;
const char *sn_state_figure_name(sn_state_figure figure); /* "mesh", ..., "contact", "pressure", "penetration" */

/* What of a state is shown. */
typedef struct sn_state_look {
    sn_state_figure figure;
    double range;  /* the end of the scale of colours; NaN = sn_view_state_range */
    unsigned show; /* bits of sn_view_show */
} sn_state_look;

/* The muscles of a simulation at a state's points, coloured by the error |C| of their rows of one kind (sim.h: units of
 * sn_statistics): the surface by the greatest error of the rows at each vertex, or for internal and radial rows the edges inside a
 * translucent surface. SN_ROWS_VOLUME colours by sn_volume_moves, SN_FIGURE_PRESSURE
 * and SN_FIGURE_PENETRATION by sn_contact_pressures (kPa) and sn_contact_depths (mm). The worst row has a ring. SN_SHOW_STRUCTURE draws the
 * internal edges under mesh errors too, on the same scale; SN_SHOW_BONES the bones at the state's time; SN_SHOW_AUTO is the surface here.
 * Sets title and subtitle where there is none yet. */
SN_MUST_CHECK sn_status sn_view_add_state(sn_view *view, const sn_model *model, const sn_state *state, const sn_state_look *look,
                                          sn_error *error);
/* A round number at or above 98 of 100 errors of the rows of a kind; above all of them where those are 0; 1 where all are. */
SN_MUST_CHECK sn_status sn_view_state_range(const sn_model *model, const sn_state *state, sn_state_figure figure, double *range,
                                            sn_error *error);
/* The moment that a state has reached, in frames: a part of one where it was stopped inside a frame. */
double sn_view_state_frame(const sn_model *model, const sn_state *state);

/* ---- motions (lib/view/show_motion.c) ------------------------------------------------------------------------------------- */

/* A motion at a time, s, as a stick figure: a dot at each joint's centre, a line from its parent's, a line to the end of its segment; one
 * colour for those named left, one for those named right ("Left...", "..._l", "lfemur" beside "rfemur"). A joint's centre is its rest
 * place, or the point of a hinge; a joint with neither is not drawn, and its children hang on the nearest joint that is. meshes (nullable;
 * motion->bone_count; those without a triangle are left out): the bones' surfaces in the rest pose, m, drawn where the joint takes
 * them. `show`: SN_SHOW_JOINTS, SN_SHOW_BONES, SN_SHOW_WIRE; SN_SHOW_AUTO is both, the bones translucent. */
SN_MUST_CHECK sn_status sn_view_add_motion(sn_view *view, const sn_motion *motion, const sn_mesh *meshes, double time, unsigned show,
                                           sn_error *error);
/* Joints whose centre is not known. */
sn_index sn_motion_placeless(const sn_motion *motion);
/* Grow a box by the centres and ends of all joints at a time. */
SN_MUST_CHECK sn_status sn_motion_extend(const sn_motion *motion, double time, sn_box *box, sn_error *error);
sn_box sn_view_box(const sn_view *view); /* of its meshes and tubes; low > high where there is nothing */
/* A grid of lines a round number of metres apart on the floor of a box, and a line of the legend that tells its height. */
SN_MUST_CHECK sn_status sn_view_add_ground(sn_view *view, sn_box box, sn_error *error);

/* ---- camera (lib/view/camera.c) ------------------------------------------------------------------------------------------- */

typedef struct sn_camera {
    sn_vec3 right, up, back; /* orthonormal; back points from the subject to the viewer */
    sn_box extent;           /* what must be in the picture, in the camera's frame (right, up, back), metres; grown by include */
    double zoom;             /* 1 = all of the extent */
} sn_camera;

/* Look from azimuth (0 = from the front, that is from -y; 90 = from the right, +x) and elevation (90 = from above), in degrees. */
sn_camera sn_camera_from(double azimuth, double elevation);
/* Look along the axis in which the subject is least extended, its long axis along the picture's width (or height, where portrait).
 * spin turns the subject about its long axis, degrees. A subject without extent is seen from the front. */
sn_camera sn_camera_auto(const sn_view *view, bool portrait, double spin);
void sn_camera_include(sn_camera *camera, const sn_view *view); /* grow the extent by all of the view's meshes and tubes */

/* ---- pictures ---------------------------------------------------------------------------------------------------------------- */

typedef struct sn_view_options {
    sn_index width, height; /* pixels, of the picture, or of one tile of a sheet; default 800 x 600 */
    int samples;            /* rays per pixel side: samples^2 rays; 1..8; default 3 */
    int threads;            /* 0 = all */
    sn_color background;    /* default near white */
    bool legend;            /* title, captions, legend, scale bar; default true */
    sn_index columns;       /* of a sheet; 0 = as square as it gets */
} sn_view_options;

sn_view_options sn_view_defaults(void);

typedef struct sn_tile {
    const sn_view *view;
    const sn_camera *camera;
    const char *caption; /* nullable */
} sn_tile;

/* What a picture shows. */
typedef struct sn_sheet {
    sn_index tile_count;
    const sn_tile *tiles;         /* (tile_count) */
    const char *title, *subtitle; /* nullable */
} sn_sheet;

/* One picture of the options' size, or a contact sheet: tiles of that size in rows, each with its caption and scale bar, one title and
 * one legend. SN_ERROR_INPUT where all views are empty. */
SN_MUST_CHECK sn_status sn_sheet_render(const sn_sheet *sheet, const sn_view_options *options, sn_image *out, sn_error *error);

#endif
