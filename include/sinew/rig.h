/*
 * rig.h -- clean, roots, structure, fibre flow, attachments: one params struct and one report each.   rank 2
 *
 * Each function reads a muscle (or a mesh) and makes one section. Coordinates and lengths are in the document's unit.
 * Each returns SN_STOPPED with a valid partial section where the trace asked to stop.
 */
#ifndef SINEW_RIG_H
#define SINEW_RIG_H

#include "sinew/geom.h"
#include "sinew/muscle.h"
#include "sinew/thread.h"

/* ---- clean (methods.md 1; lib/rig/clean.c) -------------------------------------------------------------------------- */

typedef struct sn_clean_params {
    double weld;               /* join vertices closer than this share of the box diagonal; 0 = exactly equal ones only; default 1e-6 */
    bool close_cracks;         /* default true: join borders that run side by side */
    double crack;              /* cracks up to this share of the diagonal; 0, the default = as wide as the mesh says (sn_close_cracks) */
    bool repair_nonfinite;     /* drop vertices with NaN or infinity, and their triangles, instead of failing */
    bool make_manifold;        /* default true */
    sn_index keep;             /* how many of the largest components to keep; 1 by default; 0 = all */
    sn_index max_hole;         /* fill holes of up to this many edges; 0 = none; default SN_INDEX_MAX = any */
    bool outward;              /* turn the outside outside; default true */
    bool count_intersections;  /* count self-intersections for the report; default false: it costs more than all the rest */
    bool watch_crossings;      /* default true: where a step makes triangles, count crossings and undo what makes more than there were */
    bool remove_intersections; /* replace triangles that cross, in a child process */
    double seconds;            /* that it may take; default 30 */
    double most_lost;          /* share of the area whose loss is too much; default 0.05 */
    bool full;                 /* wrap what the steps before cannot close, or what would lose too much */
    double wrap;               /* always wrap, with this offset as a share of the diagonal; 0 = not, or with 0.002 where `full` asks */
    double edge_length;        /* remesh to edges of about this length, document units; 0 = leave */
    sn_index triangles;        /* decimate to at most this many; 0 = leave */
    sn_index smooth;           /* rounds of smoothing */
    bool flip_slivers;         /* flip edges where that rids the surface of slivers */
} sn_clean_params;

typedef struct sn_dropped_component {
    sn_index triangles;
    double area, volume;
    sn_vec3 centre;
} sn_dropped_component;

typedef struct sn_clean_report {
    sn_mesh_report before, after;
    double weld_tolerance; /* document units */
    sn_index nonfinite_vertices, welded, degenerate, duplicate, unused;
    sn_index crack_vertices; /* joined or put into an edge where borders ran side by side */
    double crack_width;      /* the widest gap closed; document units */
    sn_index wall_triangles; /* of fins and walls inside, dropped where more than two triangles met on an edge */
    sn_index flipped_triangles, split_vertices, stitched_edges, holes_filled, flipped_components, decimated_triangles, flipped_slivers;
    bool orientable, unchanged; /* unchanged: same vertices and triangles in the same order */
    bool flat;                  /* closed, but no volume to speak of: a sheet folded onto itself */
    sn_index dropped_count;
    sn_dropped_component *dropped; /* (dropped_count) largest area first; owned */
    double lost_area;              /* of the input that is neither on the output's surface nor inside it; before any wish below */
    double lost_share;             /* of the input's area */
    bool wrapped;
    double wrap_offset, wrap_alpha; /* document units; 0 = not wrapped */
    sn_index crossings_made;        /* pairs that cross in the output beyond those of the input; 0 = no more than there were */
    bool crossings_uncounted;       /* too many triangles lie on one another to count how many cross */
    sn_index
        undone_crossings;    /* pairs that a step had made and that were taken back: cut out and filled anew, or the step was held there */
    bool intersections_late; /* the time was up before all were removed */
    double volume_change;    /* relative, by remeshing, decimation and smoothing, after volume was put back; NaN = open */
    double moved;            /* greatest distance of the output from the input's surface; document units */
    double hausdorff;        /* the same both ways: what was dropped counts too */
} sn_clean_report;

sn_clean_params sn_clean_defaults(void);
SN_MUST_CHECK sn_status sn_clean(const sn_mesh *mesh, const sn_clean_params *params, sn_trace *trace, sn_mesh *out, sn_clean_report *report,
                                 sn_error *error);
void sn_clean_report_free(sn_clean_report *report);

/* ---- selectors (lib/rig/select.c): shared by root-select and attach-detect --pin ------------------------------------- */

typedef enum sn_selector_kind {
    SN_SELECT_INDICES,
    SN_SELECT_NEAR,
    SN_SELECT_SPHERE,
    SN_SELECT_BOX,
    SN_SELECT_PLANE,
    SN_SELECT_HALF,
    SN_SELECT_PAINTED
} sn_selector_kind;

/* Coordinates in the document's unit. */
typedef struct sn_selector {
    sn_selector_kind kind;
    sn_index count;          /* INDICES: how many; NEAR: how many nearest vertices */
    const sn_index *indices; /* INDICES */
    sn_vec3 point;           /* NEAR, SPHERE: centre; BOX: low corner; PLANE, HALF: a point of the plane */
    sn_vec3 other;           /* BOX: high corner; PLANE, HALF: normal (any length > 0) */
    double radius;           /* SPHERE */
    const char *attribute;   /* PAINTED: name of the scalar or colour; a vertex counts where it is > threshold */
    double threshold;
} sn_selector;

/* Vertices of mesh that the selector takes. PLANE: the ring of vertices along the section nearest the point, in ring order, on the
 * side against the normal; HALF: all vertices with (p - point) . normal >= 0; the others ascending. Nothing selected is SN_ERROR_INPUT. */
SN_MUST_CHECK sn_status sn_select_vertices(const sn_mesh *mesh, const sn_topology *topology, const sn_selector *selector, sn_index *count,
                                           sn_index **vertices, sn_error *error);

/* ---- roots (methods.md 2; lib/rig/roots.c) -------------------------------------------------------------------------- */

/* What the ends of a muscle were taken from, from the least to the most trusted. */
typedef enum sn_ends_source {
    SN_ENDS_TIPS,
    SN_ENDS_EIGEN,
    SN_ENDS_ATTACHMENTS, /* found by contact or proximity, and trusted */
    SN_ENDS_PINS,
    SN_ENDS_AREAS, /* attachments with landmarks */
    SN_ENDS_SITES  /* given by hand for this run */
} sn_ends_source;
extern const char *const sn_ends_source_names[]; /* "tips", "eigenfunction", "attachments", "pins", "areas", "sites"; NULL at the end */

enum { SN_ENDS_WHY = 400 };
/* How the two ends were chosen (lib/rig/ends.c). */
typedef struct sn_ends_choice {
    sn_ends_source source; /* the least trusted of what is used, tips aside */
    const char *from;      /* its name, static */
    bool known[2];         /* of each end: false = it is a tip, as nothing known is there */
    sn_index patches[2];   /* of attachments, in each end */
    bool refused;          /* attachments were found, and are not trusted to be the ends */
    bool unused;           /* areas, pins or sites are there, but make no ends, or only one: worth a warning */
    char why[SN_ENDS_WHY]; /* why what is better was not used; empty = the best was used */
} sn_ends_choice;

typedef struct sn_roots_params {
    bool automatic; /* true (default): the mid-section ring; false: selector */
    sn_selector selector;
    bool eigenfunction;       /* tips are the extremes of the Fiedler eigenfunction; default false: the vertices farthest from each other */
    sn_index site_count;      /* known sites of both ends come before all else; 0 = none */
    const sn_end_site *sites; /* (site_count) */
} sn_roots_params;

typedef struct sn_roots_report {
    sn_index count;
    bool ring;              /* the roots are one closed loop of edges */
    sn_index parts;         /* connected parts of the surface without the roots; 2 = separates */
    double centroid_offset; /* distance of the ring's mean from the volume centroid */
    double length;          /* L: tip-to-tip length along the surface */
    double level;           /* area quantile of the chosen contour; NaN for manual selection */
    double genus;           /* of the surface; NaN where it is not closed */
    sn_index components;    /* of the surface; the automatic ring is on the one with most triangles */
    sn_ends_choice ends;    /* what the automatic selection took the ends from */
    double span;       /* of the ring along the muscle: 0 = all of it is equally far from both ends, 1 = it reaches from one to the other;
                        * NaN for manual selection */
    bool right;        /* automatic: a closed ring that parts the surface in two and the best known ends from each other, spans a third or
                        * less and lies a tenth of the way or more from both ends */
    bool section;      /* automatic: across the straight line between the ends, as no contour of their field has a right ring */
    bool between_tips; /* automatic: no ring parts the best known ends; one between the tips was looked for, though flow and fibres go by
                        * those ends */
    bool fallback;     /* automatic: nothing is right, and what came nearest was taken */
} sn_roots_report;

sn_roots_params sn_roots_defaults(void);
SN_MUST_CHECK sn_status sn_roots_select(const sn_muscle *muscle, const sn_roots_params *params, sn_trace *trace, sn_roots *out,
                                        sn_roots_report *report, sn_error *error);

/* ---- structure (methods.md 3; lib/rig/structure.c) ------------------------------------------------------------------- */

typedef enum sn_structure_metric {
    SN_METRIC_SLABS, /* distance along the surface: the same tree at any mesh density */
    SN_METRIC_HOPS   /* [R18]: edges from the roots */
} sn_structure_metric;

typedef struct sn_structure_params {
    double spacing; /* largest distance of neighbouring samples; 0 = twice the mean edge length */
    double prune;   /* branches lower than this share of L go (and lower than the radius at their split); default 0.03; 0 = keep all */
    sn_structure_metric metric; /* of the traversal; default slabs */
    bool keep_outside;          /* leave samples that lie outside the volume where they are; default false */
} sn_structure_params;

typedef struct sn_structure_report {
    sn_index samples, branches, leaves, pruned, vertices, unconnected;
    sn_index outside; /* samples outside the volume; -1 = not known: the surface is open */
    sn_index moved;   /* how often a sample was moved inside */
    double spacing, longest_link, length;
    double genus; /* > 0: branches of a mesh with handles are not to be trusted */
} sn_structure_report;

sn_structure_params sn_structure_defaults(void);
/* Needs roots. Every vertex of the roots' component gets exactly one sample; a vertex of another component is SN_ERROR_INPUT. */
SN_MUST_CHECK sn_status sn_structure_build(const sn_muscle *muscle, const sn_structure_params *params, sn_trace *trace, sn_structure *out,
                                           sn_structure_report *report, sn_error *error);

/* ---- fibre flow (methods.md 4; lib/rig/fiber_flow.c) ------------------------------------------------------------------ */

typedef enum sn_flow_field {
    SN_FIELD_AUTO,     /* harmonic where both ends are known by sites, attachment areas or pins, else tree */
    SN_FIELD_TREE,     /* the axes of nearby samples ([R18] 3.2) */
    SN_FIELD_HARMONIC, /* the gradient of a harmonic field between the muscle's ends */
    SN_FIELD_FIBERS    /* the tangent of the nearest of given fibres ([K21] 3.1) */
} sn_flow_field;
extern const char *const sn_flow_field_names[]; /* "auto", "tree", "harmonic", "fibers"; NULL at the end */

typedef enum sn_flow_weights { SN_FLOW_INVERSE_SQUARE, SN_FLOW_PAPER } sn_flow_weights;

typedef struct sn_flow_params {
    sn_flow_field field;      /* default AUTO */
    sn_flow_weights weights;  /* default 1/(d^2 + eps^2); PAPER: d */
    sn_index smooth;          /* steps of axis diffusion; default 3 */
    bool align;               /* treat directions as axes when averaging; default true; false = the paper to the letter */
    sn_index site_count;      /* known sites of both ends; 0 = none: the ends are attachments that are known or trusted, else tips */
    const sn_end_site *sites; /* (site_count) */
    sn_index polyline_count;  /* FIBERS */
    const sn_polyline *polylines;
} sn_flow_params;

typedef struct sn_flow_report {
    sn_flow_field field;                                       /* that was used */
    sn_ends_choice ends;                                       /* of a harmonic field; of others what it would run between */
    sn_index vertices, by_field, by_neighbours, by_convention; /* the rule that gave each vertex its direction */
    double max_normal_dot;                                     /* max |f . n| */
    double mean_angle, percentile95_angle;                     /* between neighbours' axes, radians */
    double roots_angle;                                        /* mean over the edges at the roots, radians; NaN without roots */
    double mean_confidence;
    sn_index low_confidence; /* vertices below 0.5 */
    double farthest_fiber;   /* FIBERS: greatest distance of a vertex from the fibre it took its direction from */
} sn_flow_report;

sn_flow_params sn_flow_defaults(void);
/* TREE needs a structure. out->directions: unit, tangent, finite at every vertex; out->confidence: 0 to 1; polylines of the muscle are not
 * touched. */
SN_MUST_CHECK sn_status sn_flow_fibers(const sn_muscle *muscle, const sn_flow_params *params, sn_trace *trace, sn_fibers *out,
                                       sn_flow_report *report, sn_error *error);

/* ---- attachments (methods.md 6; lib/rig/attach*.c) -------------------------------------------------------------------- */

typedef enum sn_attach_method { SN_ATTACH_CONTACT = 1, SN_ATTACH_PROXIMITY = 2 } sn_attach_method; /* bits: may be combined */

typedef struct sn_attach_bone {
    const char *name;
    const sn_mesh *mesh; /* in the muscle's unit */
    bool if_nearby;      /* holds vertices only if the pair rule says so; false: the user means this bone */
} sn_attach_bone;

typedef struct sn_attach_pin {
    const char *bone;
    sn_selector selector;
} sn_attach_pin;

/* What the landmarks of an area are. A boundary closes: its last step is about as long as the others. A line, as an insertion along a
 * ridge, does not: with steps of length W in all, the longest M, and G from the last landmark to the first (of three landmarks G is the
 * longest side), landmarks are a line where there are two of them; G >= 0.98 W; G > 2 M and G > 0.8 W; G > 4 M and G > 0.5 W; or all lie
 * within 1 % of their length from a straight line. Eight and more are smoothed (1:2:1) before W and M are measured, as they may be noisy.
 */
typedef enum sn_area_kind { SN_AREA_AUTO, SN_AREA_BOUNDARY, SN_AREA_LINE } sn_area_kind;
extern const char *const sn_area_kind_names[]; /* "auto", "boundary", "line"; NULL at the end */

/* An attachment area ([K21] 3.3): landmarks in order along its boundary, or along a line, on the bone or the muscle. */
typedef struct sn_landmark_area {
    char *bone;
    char *name; /* nullable */
    sn_index count;
    sn_vec3 *landmarks; /* (count) in the muscle's unit */
} sn_landmark_area;
void sn_landmark_areas_free(sn_landmark_area *areas, sn_index count);
/* Which end an area of this name (nullable) is at: the one that one of its words names: origin, origins, insertion or insertions, in any
 * case and place. Words are parted by anything but letters, and by a capital behind a small letter. UNKNOWN and *doubtful where it names
 * both ends, denies one (no, non, not, without), or has a word that only resembles these (lib/rig/attach_name.c). */
sn_attachment_end sn_area_end(const char *name, bool *doubtful);

typedef struct sn_attach_params {
    sn_index bone_count;
    const sn_attach_bone *bones; /* (bone_count) those that may hold vertices by contact or proximity */
    unsigned methods;            /* bits of sn_attach_method; default both; 0 = pins and areas only */
    double distance;             /* proximity: vertices closer than this; < 0 (default) = 0.1 mean edges with contact, 1 mean edge alone */
    sn_index voxels;      /* contact also where the vertex is in a cell that the bone's surface runs through, of about this many cells
                           * in the bone's box ([K21] 3.2); 0 (default) = exact contact only */
    double pair_distance; /* the pair rule: a bone with if_nearby holds vertices only where the muscle penetrates it, or more than */
    double pair_share;    /* pair_share (default 0.008) of its area lies within pair_distance of it; < 0 (default) = 2 mm */
    sn_index pin_count;
    const sn_attach_pin *pins; /* taken first: a pinned vertex stays with its bone */
    sn_index area_count;
    const sn_landmark_area *areas; /* taken next, in their order; their bones hold nothing by contact or proximity */
    double landmark_reach;  /* an area with a landmark farther from the muscle is left out, an error where nothing else is to be done;
                             * < 0 (default) = 10 mm */
    sn_area_kind area_kind; /* default auto: by the test above */
    bool raw;               /* vertices as the rules found them: no patches, no tips, and what slides is kept; default false */
    double line_width;      /* of the band along a line, document units; < 0 (default) = the mean distance of its landmarks from the muscle;
                             * the triangles that the line runs through are in the band in any case */
    int threads;            /* 0 = all */
} sn_attach_params;

/* What a stage did to the vertices of a bone. */
typedef struct sn_attach_change {
    sn_index vertices;
    double area; /* of these, document units squared; a vertex has a third of its triangles */
} sn_attach_change;

/* How what a bone holds by distance became patches: pieces (connected sets of its vertices) and holes in them, before and after; what was
 * taken to fill gaps and holes, dropped as crumbs, and taken or let go to smooth borders. All 0 with raw. */
typedef struct sn_attach_patch {
    sn_index pieces_before, pieces;
    sn_index holes_before, holes;
    sn_attach_change filled, dropped, moved;
} sn_attach_patch;

typedef struct sn_attach_pair {
    sn_index bone;         /* index into the bones given */
    sn_index vertices;     /* that the bone has in the end */
    bool culled;           /* its box is out of reach: not searched */
    bool nearby;           /* it may hold vertices: the pair rule says so, or it is meant */
    bool penetrates;       /* the muscle's surface is partly in the bone; known only where the pair rule was asked */
    bool sliding;          /* what it holds, or a piece of that, looks like a tendon that slides over the bone */
    bool tip;              /* it touches the muscle nowhere, and holds the tip that runs to it */
    sn_attach_change slid; /* let go, as it slides */
    sn_attach_patch patch;
    double nearest;    /* least signed distance of a vertex to the bone; where culled the distance of the boxes, a lower bound */
    double area_share; /* of the muscle's surface within pair_distance of the bone; NaN where it was not needed to decide */
    double position;   /* of what it holds along the muscle, 0 at one tip, 1 at the other; NaN where it holds nothing */
    double girth;      /* of the muscle there: area per length, relative to where that is largest; NaN where it holds nothing */
} sn_attach_pair;

/* How an area came out. */
typedef struct sn_attach_area {
    sn_index area;     /* index into the areas given */
    sn_index vertices; /* in its patch */
    bool reordered;    /* its boundary crossed itself: the landmarks were put into the order of the shortest tour */
    bool coarse;       /* its boundary encloses no vertex: the nearest vertex of each landmark was taken; or its band is more than twice as
                        * wide as the line */
    bool line;         /* it is the band along a line */
    bool doubtful;     /* auto: a boundary that closes by more than twice its longest step, or a line that bends back (G < 0.8 W) */
    bool left_out;     /* a landmark, `far`, lies beyond the reach */
    sn_index far;      /* index of the landmark that is farthest from the muscle */
    double farthest;   /* landmark from the muscle, document units */
    double boundary;   /* length of the boundary, or of the line */
    double width;      /* of the band that was asked for, document units; 0 of boundaries, and of lines that lie on the muscle */
    double mean_width; /* of the band that was taken: its area by its length; 0 of boundaries */
    double area_share; /* of the muscle's surface */
    sn_attachment_end end; /* that its name says */
    bool end_doubtful;     /* its name looks like an end's and is not taken for one */
    sn_attach_change lost; /* of its patch, what stays with pins, and with areas given before on another bone or at another end */
    sn_index lost_to;      /* the first of these areas, an index into the areas given; SN_NONE = pins only, or nothing is lost */
} sn_attach_area;

typedef struct sn_attachment_list {
    sn_index count;
    sn_attachment *items; /* (count) free with sn_attachments_free */
} sn_attachment_list;

typedef struct sn_attach_report {
    sn_index pair_count;
    sn_attach_pair *pairs; /* (pair_count) one per bone, in the order given; fewer only where the trace stopped; owned */
    sn_index area_count;
    sn_attach_area *areas; /* (area_count) in the order given; fewer only where the trace stopped; owned */
    sn_index attached;     /* vertices in all */
    double distance;       /* the distance of proximity in use, document units; 0 without */
    double pair_distance;  /* of the pair rule in use, document units */
    double landmark_reach; /* in use, document units; 0 without areas */
} sn_attach_report;

sn_attach_params sn_attach_defaults(void);
/* A vertex within reach of several bones goes to the nearest (signed distance; ties to the bone given first). Bones with no vertex
 * are left out. A bone whose areas are at different ends has an attachment for each. Each attached vertex has a reason and a confidence: 1
 * for pins and areas; else by how deep in or how near the bone it is, lower where another bone is about as near, and halved where the pair
 * looks like a sliding tendon (lib/rig/attach.c). Trace steps: landmark, geodesic, tour, patch; pair, bone. */
SN_MUST_CHECK sn_status sn_attach_detect(const sn_muscle *muscle, const sn_attach_params *params, sn_trace *trace, sn_attachment_list *out,
                                         sn_attach_report *report, sn_error *error);
void sn_attach_report_free(sn_attach_report *report);

/* ---- neighbours for external constraints ([R18] 4.3; lib/rig/neighbours.c) ---------------------------------------------- */

typedef struct sn_neighbour {
    const char *name;
    const sn_mesh *mesh; /* in the muscle's unit */
    bool envelope;       /* holds the muscle in where no other target lies before it (superficial fascia); hides nothing */
} sn_neighbour;

typedef struct sn_neighbours_params {
    sn_index target_count;
    const sn_neighbour *targets; /* (target_count) names differ */
    sn_index obstacle_count;
    const sn_mesh *const *obstacles; /* (obstacle_count) bones, say, in the muscle's unit: they hide what lies behind them */
    double reach;                    /* how far a target's surface may be; < 0 (default) = 5 mm */
    double opposing;                 /* surfaces face each other where n . n' < -opposing; default 0.2; n . n' > opposing: held in */
    sn_index most;                   /* deep targets of a vertex, the nearest ones; default 2; 0 = all */
    bool hidden;                     /* keep targets that lie behind another surface; default false */
    double minimum;                  /* minimum distance, document units; default 0 */
    double weights[3];               /* slide, soft, hard in [0,1]; default 1, 0, 0 */
    const double *maps[3];           /* (vertex_count) instead of a weight, per vertex, finite, cut to [0,1]; nullable */
    int threads;                     /* 0 = all */
} sn_neighbours_params;

typedef struct sn_neighbours_found {
    sn_index count;
    sn_external *items;       /* (count) by fascia, then in the order of the targets; owned */
    sn_index culled;          /* targets whose boxes are out of reach: not searched */
    sn_index hidden, surplus; /* pairs of vertex and deep target left out: behind another surface; beyond the `most` nearest */
    sn_index without;         /* vertices without any target */
    sn_index clamped;         /* values of maps, on vertices with a target, that were not within [0,1] */
} sn_neighbours_found;

sn_neighbours_params sn_neighbours_defaults(void);
void sn_neighbours_free(sn_neighbours_found *list);
/* For every vertex the closest point on each target within reach: where the surfaces face each other (deep fascia: the normals oppose,
 * a target that is not entered lies before the vertex, and the line to it crosses no other target, no obstacle and not the muscle itself),
 * the nearest `most` of them; or, for a vertex that faces no target, where an envelope's normal agrees (superficial fascia). A trace step
 * for each target and fascia; stopped, *out holds what the targets searched until then give. The same in any order of the targets but
 * for the order of the items, unless two are equally near. */
SN_MUST_CHECK sn_status sn_find_neighbours(const sn_muscle *muscle, const sn_neighbours_params *params, sn_trace *trace,
                                           sn_neighbours_found *out, sn_error *error);

/* The weights by rule: near its attachments a muscle is tendon and held (soft or hard), farther it is belly and slides. slide
 * (vertex_count) is 0 on attached vertices and rises smoothly (3 t^2 - 2 t^3) to 1 at a distance along the surface; a vertex that no
 * attachment reaches along the surface has 1. distance > 0, document units. SN_ERROR_INPUT where nothing is attached. */
SN_MUST_CHECK sn_status sn_tendon_slide(const sn_muscle *muscle, double distance, double *slide, sn_error *error);
/* What a tenth of the muscle's length is, as that distance: the default. The length is that between vertices far apart. */
double sn_tendon_default(const sn_muscle *muscle);

/* ---- fibres through the volume (methods.md 5; lib/rig/fiber_fill.c) ----------------------------------------------------------- */

typedef enum sn_fill_template {
    SN_FILL_PARALLEL,  /* from end to end, side by side */
    SN_FILL_PENNATE,   /* from one side (x = 0) obliquely to the other (x = 1) */
    SN_FILL_BIPENNATE, /* from both sides obliquely to a tendon in the middle (x = 1/2) */
    SN_FILL_FAN,       /* together at the end with the smaller section */
    SN_FILL_CURVED,    /* end to end, bowed towards x = 1 */
    SN_FILL_USER       /* Bezier curves of the caller's */
} sn_fill_template;

typedef enum sn_fill_map { SN_FILL_HARMONIC, SN_FILL_MEAN_VALUE } sn_fill_map;

/* Where fibres end: attachments on at least two bones, vertices that the caller names, or the tips of the structure or the surface. */
typedef enum sn_fill_ends_kind { SN_FILL_ENDS_ATTACHMENTS, SN_FILL_ENDS_GIVEN, SN_FILL_ENDS_TIPS } sn_fill_ends_kind;

/* From a fibre, in mean spacings: beyond that the volume is empty. */
#define SN_FILL_FAR 5.0
#define SN_FILL_FIBERS 100  /* fibres, where nobody asks for more or fewer */
#define SN_FILL_SEGMENTS 15 /* of each, likewise */
/* Length over the distance of its ends, against that of the muscle: from then on a fibre bends much. */
#define SN_FILL_BENT 1.5

/* A Bezier curve of any degree in the unit square x [0,1]; z runs from the origins to the insertions. */
typedef struct sn_fill_curve {
    sn_index count;
    const sn_vec3 *points;
} sn_fill_curve;

typedef struct sn_fill_params {
    sn_index fibers, segments; /* default 100 of 15 */
    sn_fill_template template;
    double angle;         /* pennate, bipennate: against the line of action, radians in (0, pi/2); default 20 degrees */
    double narrow;        /* fan: width at the narrow end as a share; default 0.25 */
    double bow;           /* curved: 0 to 1; default 0.5 */
    double turn;          /* turn of the template about the line of action, radians; 0 = x along the widest way of the section */
    sn_index curve_count; /* user: at least 1; a fibre has the shape of the curves, blended by how near their starts are to its seed */
    const sn_fill_curve *curves;
    sn_index bend_count;           /* parallel, fan, curved: superficial fibres that bend the template (Kohout and Cholt 2017); 0 = none */
    const sn_polyline *bend_lines; /* (bend_count) along the muscle, within 5 % of the box diagonal from its surface, in either direction */
    sn_fill_map map;
    sn_index smooth;                        /* rounds of smoothing along each fibre before it is divided; default 0 */
    bool pull;                              /* default true: bring vertices that lie outside in */
    sn_index origin_count, insertion_count; /* > 0 both: the ends */
    const sn_index *origin, *insertion;
    bool use_attachments; /* default true */
    bool spread;          /* default true: a parallel template that nothing bends, mapped harmonically, between attachments has its fibres'
                           * ends spread evenly over the attachment areas */
    sn_pool *pool;        /* NULL = the caller's thread; the fibres are the same */
} sn_fill_params;

typedef struct sn_fill_report {
    sn_index fibers, vertices;
    sn_index leaves;                    /* tips of the structure that the fibres' ends cover */
    sn_index levels, loops, most_loops; /* slices: in all, and on one level */
    sn_fill_ends_kind ends;
    sn_ends_choice chosen;                  /* the same, finer */
    bool closed;                            /* every edge has two triangles */
    sn_index outside_before, outside_after; /* fibre vertices outside the volume, before and after the pull */
    double farthest;                        /* that one lay outside */
    double mean_length, least_length, greatest_length;
    double length_deviation;                   /* of the lengths from their mean: root of the sum of squares over their number less one */
    bool spread;                               /* the fibres' ends are spread over the attachment areas */
    double areas[2];                           /* of the origin and the insertion, where they are */
    double mean_pennation, greatest_pennation; /* radians, against the line of slice centroids, by length */
    double action_length;                      /* of the line of slice centroids */
    double area;                               /* of the widest level */
    double density;                            /* fibres through that level per area */
    sn_index leaves_reached;                   /* ends of branches of slices where at least one fibre ends */
    sn_index leaf_loops;                       /* ends of branches of slices */
    double bend_farthest;                      /* that a point of bend_lines lay from the surface */
    bool flux;      /* slices are laid by the field's flux: by the length of their rims fibres turned more (lib/rig/fill_rim.c) */
    double spacing; /* mean, of the fibres: root of the volume over their length in all; 0 where there is no volume */
    double empty;   /* share of the volume farther than SN_FILL_FAR spacings from every fibre (lib/rig/fill_judge.c); of more than
                     * SN_FILL_FIBERS fibres: spacings that so many would have */
    double
        outside; /* share of the fibres' length in segments whose middle is outside of a closed surface, by more than 1 % of its diagonal */
    double greatest_bend; /* of a fibre: its length over the distance of its ends */
    double muscle_bend; /* of the muscle: the way along its surface between its two far ends over the diagonal of its box; 0 where no fibre
                         * is bent much */
    sn_index bent;      /* fibres whose bend is over SN_FILL_BENT, and so many times that of the muscle */
} sn_fill_report;

sn_fill_params sn_fill_defaults(void);
/* Fibres through the inside of the roots' component, or of the largest without roots. Only out->polylines is made; each has its length and
 * pennation. A closed surface is best; an open one is judged by its winding number. */
SN_MUST_CHECK sn_status sn_fill_fibers(const sn_muscle *muscle, const sn_fill_params *params, sn_trace *trace, sn_fibers *out,
                                       sn_fill_report *report, sn_error *error);

#endif
