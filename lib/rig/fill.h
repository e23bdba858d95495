/*
 * fill.h -- how the inside of a muscle is cut into slices and fibres are led through them ([K21] 4; Kohout and Kukacka 2014). Private to
 * lib/rig.
 *
 * A harmonic field u runs from 0 at the fibres' origins to 1 at their insertions. Its level curves are loops; each loop is the rim of a
 * slice, and every slice is the image of the unit square. Fibre templates are curves in the unit square x [0,1].
 */
#ifndef SINEW_RIG_FILL_H
#define SINEW_RIG_FILL_H

#include "sinew/rig.h"

enum { RIM = 64 }; /* points of a loop; a multiple of 4 */

/* ---- ends (fill_ends.c) --------------------------------------------------------------------------------------------------- */

/* Vertices where u is 0 and 1. */
typedef struct fill_ends {
    sn_index count;
    sn_index *vertices; /* (count) */
    double *values;     /* (count) 0 or 1 */
    sn_index leaves;    /* tips of the structure among them, or served by an attachment */
    sn_fill_ends_kind kind;
    sn_ends_choice choice;
} fill_ends;

SN_MUST_CHECK sn_status fill_find_ends(const sn_muscle *muscle, const sn_topology *topology, const sn_fill_params *params, sn_trace *trace,
                                       fill_ends *out, sn_error *error);
void fill_ends_free(fill_ends *ends);

/* ---- a finer surface (fill_refine.c) ------------------------------------------------------------------------------------------- */

/* Values that a field has at some vertices; a vertex is listed once. */
typedef struct fill_fixed {
    sn_index count;
    sn_index *vertices; /* (count) */
    double *values;     /* (count) 0 or 1 */
} fill_fixed;

/* The surface with each triangle in four, again and again until there are enough of them; its first vertices are those of `mesh`. fixed
 * grows by the middles between ends of one value. *out, *out_topology: empty where `mesh` has enough; the caller's to free, also on
 * failure. */
SN_MUST_CHECK sn_status fill_refine(const sn_mesh *mesh, const sn_topology *topology, fill_fixed *fixed, sn_mesh *out,
                                    sn_topology *out_topology, sn_error *error);

/* ---- slices (fill_slice.c) ------------------------------------------------------------------------------------------------ */

/* A point of the unit square. */
typedef struct fill_uv {
    double x, y;
} fill_uv;

/* The square's image: a triangulation of the polygon and where its vertices lie in the square. */
typedef struct fill_slice {
    sn_index vertex_count, triangle_count;
    sn_vec3 *positions;       /* (vertex_count) in space; the first RIM are the rim */
    fill_uv *square;          /* (vertex_count) */
    sn_index (*triangles)[3]; /* (triangle_count) */
    sn_index (*across)[3];    /* (triangle_count) the triangle beyond the edge opposite to corner 0, 1, 2; SN_NONE = the rim */
} fill_slice;

/* The square's boundary in RIM points, anticlockwise from (0,0); `wide` points on each side along x, RIM / 2 - wide on each along y. */
void fill_square_rim(int wide, fill_uv out[RIM]);
/* Harmonic map of the polygon onto the square, its rim onto the boundary: one to one, so that its inverse never leaves the polygon. */
SN_MUST_CHECK sn_status fill_slice_build(const sn_vec3 rim[RIM], int wide, fill_slice *out, sn_error *error);
/* Where a point of the square lies in space; *hint is a triangle to begin the search at. */
sn_vec3 fill_slice_at(const fill_slice *slice, fill_uv at, sn_index *hint);
/* The same by planar mean value coordinates, as in the paper: leaves the polygon where it is concave. */
sn_vec3 fill_mean_value_at(const sn_vec3 rim[RIM], int wide, fill_uv at);
void fill_slice_free(fill_slice *slice);

/* ---- levels (fill_levels.c) ----------------------------------------------------------------------------------------------- */

/* What lies in a strip of one loop's square goes to a strip of another's. turn: quarter turns that bring the strips' direction to x. */
typedef struct fill_link {
    sn_index loop;
    int turn_from, turn_to;
    double from[2], to[2];
} fill_link;

typedef struct fill_loop {
    sn_index level;
    int wide;    /* rim points on each side of the square along x */
    double side; /* share of the loop that such a side takes */
    sn_vec3 rim[RIM];
    sn_vec3 centroid, normal; /* of the polygon; normal along rising u */
    double area;
    sn_index link_count; /* links away from the trunk */
    fill_link *links;
    bool reached; /* from the trunk */
    fill_slice slice;
} fill_loop;

typedef struct fill_levels {
    sn_index level_count, loop_count, trunk; /* trunk: the level that fibres are led away from */
    double *u;                               /* (level_count) ascending */
    double *z;                               /* (level_count) 0 to 1: arc length of the line of slice centroids */
    sn_vec3 *centre;                         /* (level_count) mean of the slices' centroids by area: the line of action */
    sn_index *first;                         /* (level_count + 1) loops of level i are first[i] .. first[i + 1] - 1 */
    fill_loop *loops;                        /* (loop_count) */
    fill_link *roots;                        /* (root_count) from the whole square to the loops of the trunk */
    sn_index root_count;
    double length;       /* of the line of centroids */
    double width, depth; /* of the widest slice of the trunk, along x and y */
} fill_levels;

/* The harmonic field that fibres follow. */
typedef struct fill_field {
    const sn_mesh *mesh;
    const sn_topology *topology;
    const double *u; /* (vertex_count) 0 at the origin, 1 at the insertion */
} fill_field;

typedef struct fill_levels_params {
    sn_index count; /* of the levels */
    double turn;    /* of the square about the line of action, radians */
    bool flux;      /* rims at equal steps of the field's flux through their loops, not of these loops' length */
} fill_levels_params;

SN_MUST_CHECK sn_status fill_levels_build(const fill_field *field, const fill_levels_params *params, sn_trace *trace, fill_levels *out,
                                          sn_error *error);
/* The loop of `level` and the place in its square of what is at `at` of the trunk; SN_NONE where the slices end before. Where loops split
 * the way of `guide` is taken, `at` kept within its share: a fibre that moves across does not change over to another head. */
sn_index fill_carry(const fill_levels *levels, sn_index level, fill_uv guide, fill_uv *at);
void fill_levels_free(fill_levels *levels);

/* ---- seeds (fill_seeds.c) --------------------------------------------------------------------------------------------------- */

/* Where params->fibers fibres start from, in [0,1]^2: for templates that run from end to end the places where they pass the trunk, evenly
 * over its real section and so that every end gets one where there are enough. Sets leaf_loops and leaves_reached. */
SN_MUST_CHECK sn_status fill_make_seeds(const fill_levels *levels, const sn_fill_params *params, fill_uv *seeds, sn_fill_report *report,
                                        sn_error *error);

/* Places of the trunk that are even over its section; the first of them are, too. */
SN_MUST_CHECK sn_status fill_even_places(const fill_levels *levels, const sn_fill_params *params, sn_index count, fill_uv *out,
                                         sn_error *error);

/* ---- templates (fill_template.c) -------------------------------------------------------------------------------------------- */

/* A point of a fibre in the template: the square and z. */
typedef struct fill_node {
    fill_uv at;
    double z;
} fill_node;

enum { TEMPLATE_NODES = 129, FILL_CURVE_POINTS = 32 }; /* at most: nodes of one fibre, control points of a curve */

/* x on a level of a fibre with seed x, of a template that runs from end to end: grows with the seed. */
double fill_template_across(const sn_fill_params *params, const fill_levels *levels, double seed, sn_index level);
/* Nodes of one fibre for a seed in [0,1]^2, along the fibre. levels give the sizes that angles need. */
sn_index fill_template_fiber(const sn_fill_params *params, const fill_levels *levels, fill_uv seed, sn_index fiber,
                             fill_node nodes[TEMPLATE_NODES]);

/* ---- bending (fill_bend.c) ---------------------------------------------------------------------------------------------------- */

/* A superficial fibre that the user gives. */
typedef struct fill_bend_line {
    double *values;               /* (its points) u beside each */
    sn_index first, middle, last; /* levels that cut it; middle: of those the nearest to the trunk */
    fill_uv *path;                /* (level_count) in the trunk's square; first .. last */
    fill_uv *bend;                /* (level_count) path against the template */
} fill_bend_line;

typedef struct fill_bend {
    sn_index count;
    fill_bend_line *lines; /* (count) */
} fill_bend;

/* Where params->bend_lines lie in the field; *farthest: grows to how far from the surface. SN_ERROR_INPUT where one does. */
SN_MUST_CHECK sn_status fill_bend_measure(const fill_field *field, const sn_fill_params *params, fill_bend *out, double *farthest,
                                          sn_error *error);
/* Their paths and bends, once the slices are there. SN_ERROR_INPUT where one does not run along the muscle. */
SN_MUST_CHECK sn_status fill_bend_find(const fill_levels *levels, const sn_fill_params *params, double diagonal, fill_bend *bend,
                                       sn_error *error);
/* Bend a fibre of the template, a node a level. */
void fill_bend_nodes(const fill_bend *bend, sn_index level_count, fill_node *nodes);
void fill_bend_free(fill_bend *bend);

/* ---- from area to area (fill_areas.c, fill_match.c, fill_spread.c, fill_lead.c) ------------------------------------------------------ */

/* The attachment areas at both ends. */
typedef struct fill_areas {
    const sn_mesh *mesh;
    char *member[2]; /* (vertex_count) 1 = the vertex is of an origin's, an insertion's area */
} fill_areas;

/* Of the surface that is nearer to members (vertex_count; 0 or 1) than to other corners of its triangles. */
double fill_area(const sn_mesh *mesh, const char *member);
/* `count` points of that area, evenly: each stands for an equal share. SN_ERROR_INPUT where it is 0. */
SN_MUST_CHECK sn_status fill_sample_area(const sn_mesh *mesh, const char *member, sn_index count, sn_vec3 *out, sn_error *error);

/* Points of any dimension. */
typedef struct fill_features {
    sn_index width;       /* the dimension */
    const double *values; /* (count x width) */
} fill_features;

/* match (count): which of `to` each of `from` is paired with, each with one, so that the sum of squared distances is least; nearly so for
 * more than 256. */
SN_MUST_CHECK sn_status fill_match(sn_index count, const fill_features *from, const fill_features *to, sn_index *match, sn_error *error);

/* A fibre from area to area; of two: at the origin, at the insertion. */
typedef struct fill_path {
    sn_vec3 end[2];   /* on the areas */
    fill_uv way[2];   /* place of the trunk that leads there */
    sn_index loop[2]; /* of the first and the last level, before the area */
    double radius[2]; /* of a disc as large as that loop's slice */
} fill_path;

/* params->fibers paths, their ends even over the areas. */
SN_MUST_CHECK sn_status fill_spread_ends(const fill_levels *levels, const fill_areas *areas, const sn_fill_params *params, fill_path *paths,
                                         sn_error *error);

typedef struct fill_leading {
    const fill_levels *levels;
    const sn_mesh *mesh;
    double diagonal; /* of its box */
    bool closed;
    sn_index fibers, segments, smooth;
    const fill_path *paths; /* (fibers) */
    sn_polyline *lines;     /* (fibers) their points are written */
    double *z;              /* (fibers x (segments + 1)) written */
    sn_pool *pool;
} fill_leading;

SN_MUST_CHECK sn_status fill_lead_paths(const fill_leading *lead, sn_error *error);

/* ---- how well they fill (fill_judge.c) ----------------------------------------------------------------------------------------- */

/* Sets spacing, empty, greatest_bend, muscle_bend and bent of the report; the fibres have their lengths. */
SN_MUST_CHECK sn_status fill_judge(const sn_mesh *mesh, const sn_topology *topology, const sn_fibers *fibers, sn_fill_report *report,
                                   sn_error *error);

/* ---- fibres (fiber_fill.c) ------------------------------------------------------------------------------------------------------- */

/* Where the place `at` of the trunk's square lies on a level, by the way of `guide` (fill_carry); false where the slices end before. */
bool fill_place(const fill_levels *levels, sn_fill_map map, sn_index level, fill_uv guide, fill_uv at, sn_vec3 *out);

/* A line whose points have a z each. */
typedef struct fill_line {
    sn_index count;
    const sn_vec3 *points; /* (count) */
    const double *z;       /* (count) */
} fill_line;

/* Points (segments + 1) at equal steps along the line, and their z. Returns the length. */
double fill_divide(const fill_line *line, sn_index segments, sn_vec3 *out, double *out_z);
/* Rounds of smoothing; the ends stay. */
void fill_smooth(sn_index count, sn_vec3 *points, sn_index rounds);

#endif
