/*
 * muscle.h -- the muscle: mesh + roots + structure + fibres + attachments. Plain data, filled by the tools of the chain.   rank 1
 *
 * Coordinates are in the document's unit; multiply by meters_per_unit for metres. Everything is owned by the muscle.
 */
#ifndef SINEW_MUSCLE_H
#define SINEW_MUSCLE_H

#include "sinew/mesh.h"

/* Where fibres start ([R18] 3.1): a ring of vertices around the middle, in ring order, or any set of vertices. */
typedef struct sn_roots {
    sn_index count;      /* 0 = no roots section */
    sn_index *vertices;  /* (count) */
    char *rule;          /* "mid-section", "plane", "indices", ... */
} sn_roots;

/* The internal structure ([R18] 3.1): a tree of samples, parents before children; sample 0 is the root. */
typedef struct sn_structure {
    sn_index sample_count;   /* 0 = no structure section */
    sn_vec3 *positions;      /* (sample_count) */
    sn_index *parents;       /* (sample_count) SN_NONE for the root */
    sn_index *branches;      /* (sample_count) branch number; branch 0 holds the root */
    sn_vec3 *axes;           /* (sample_count) unit fibre axis delta at the sample; at the root the aligned mean of its children's */
    sn_index *vertex_sample; /* (vertex_count) the one sample that each surface vertex hangs on; SN_NONE only in a partial document */
    double spacing;          /* largest distance of neighbouring samples that was asked for */
} sn_structure;

/* A fibre through the volume. */
typedef struct sn_polyline {
    sn_index count;
    sn_vec3 *points;  /* (count) */
    double length;    /* 0 = not known */
    double pennation; /* angle against the line of action, radians; counts only where the length is known */
} sn_polyline;

/* A place where the muscle is known to attach: at one of its ends, 0 = origin, 1 = insertion. An end may have many. */
typedef struct sn_end_site { sn_vec3 point; int end; } sn_end_site;

/* Fibre directions at surface vertices ([R18] 3.2), and fibres through the volume ([K21] 4). */
typedef struct sn_fibers {
    sn_vec3 *directions; /* (vertex_count) unit and tangent; NULL = none */
    sn_index polyline_count;
    sn_polyline *polylines; /* (polyline_count) */
    char *field;            /* "tree", "harmonic", "fibers"; NULL = not known */
    double *confidence;     /* (vertex_count) of each direction, 0 (a guess) to 1; NULL = not known */
} sn_fibers;

/* Why a vertex is attached. The numbers are in documents. */
typedef enum sn_attach_reason {
    SN_REASON_PIN = 1,   /* the user named it */
    SN_REASON_AREA,      /* in an attachment area with landmarks around it */
    SN_REASON_CONTACT,   /* in or on the bone */
    SN_REASON_VOXEL,     /* in a cell that the bone's surface runs through */
    SN_REASON_PROXIMITY, /* near the bone */
    SN_REASON_NEAREST,   /* the bone is near the muscle, but nearer to no vertex than to this: the mesh is coarse there; or its tip runs
                          * to the bone and touches nothing */
    SN_REASON_FILLED,    /* in a gap or hole of the patch that the bone holds */
    SN_REASON_COUNT
} sn_attach_reason;
const char *sn_attach_reason_name(sn_attach_reason reason); /* "pin", "area", ...; NULL = there is no such reason */

/* The vertices that move with one bone ([K21] 3.3); a vertex belongs to one bone at most. */
/* Which end of the muscle an attachment is at, where who gave it said so. */
typedef enum sn_attachment_end { SN_END_UNKNOWN, SN_END_ORIGIN, SN_END_INSERTION } sn_attachment_end;
extern const char *const sn_attachment_end_names[]; /* "unknown", "origin", "insertion", NULL */

typedef struct sn_attachment {
    char *bone;
    sn_attachment_end end; /* as its areas are called; UNKNOWN also where they are called both */
    char *method;        /* "contact", "proximity", "contact+proximity", "pin", ... */
    sn_index count;
    sn_index *vertices;  /* (count) ascending */
    double *distances;   /* (count) signed distance to the bone, document units; NULL = not known */
    sn_index *reasons;   /* (count) sn_attach_reason; NULL = not known */
    double *confidence;  /* (count) in [0,1]; NULL = not known */
} sn_attachment;

/* How an attachment holds (lib/geom/attachments.c). Its end is what it holds and the surface joined to that within a tenth of the muscle's
 * length (between vertices far apart) of its middle: of a muscle with several tendons, the one that it is on. */
typedef struct sn_grip {
    sn_index patches; /* connected sets of its vertices */
    sn_index largest; /* vertices of the largest */
    double share;     /* of the area of its end, in (0, 1]; a vertex has a third of its triangles. NaN where that area is 0 */
} sn_grip;

/* What that means. Measured on the 1,023 attachments of 291 muscles by contact: the digitations of a serratus have 11 vertices a patch and
 * more, speckles of contact 5 and fewer. */
typedef enum sn_grip_quality {
    SN_GRIP_GOOD,
    SN_GRIP_SLIGHT,  /* less than 1 % of its end */
    SN_GRIP_SPECKLED /* four patches or more, of fewer than six vertices on average, none with more than half of the vertices */
} sn_grip_quality;
sn_grip_quality sn_grip_judge(const sn_attachment *attachment, const sn_grip *grip);

/* Where a muscle rubs on a neighbour: candidates for [R18] 4.3's external constraints, each from a vertex to a point of the target. */
typedef struct sn_external {
    char *target;         /* name of a muscle or an envelope */
    char *fascia;         /* "deep": surfaces that face each other; "superficial": held in by the envelope */
    sn_index count;
    sn_index *vertices;   /* (count) ascending */
    sn_index *triangles;  /* (count) of the target */
    double *barycentric;  /* (3 x count) of the point in its triangle; not negative, their sum is 1 */
    double *distances;    /* (count) rest distance to the point, document units; negative in the target */
    double *minimum;      /* (count) minimum distance, at most the rest distance */
    double *weights;      /* (3 x count) slide, soft, hard, each in [0,1] */
} sn_external;

/* What a document's sections are, as bits: which are there, which a tool has changed. */
typedef enum sn_section {
    SN_SECTION_MESH = 1, SN_SECTION_ROOTS = 2, SN_SECTION_STRUCTURE = 4, SN_SECTION_FIBERS = 8, SN_SECTION_ATTACHMENTS = 16,
    SN_SECTION_EXTERNALS = 32
} sn_section;

typedef struct sn_muscle {
    char *name;             /* nullable */
    double meters_per_unit; /* > 0 */
    sn_space space;
    sn_mesh mesh;
    sn_roots roots;
    sn_structure structure;
    sn_fibers fibers;
    bool has_attachments;   /* tells "none found" from "not looked for" */
    sn_index attachment_count;
    sn_attachment *attachments; /* (attachment_count) */
    bool has_externals;     /* tells "none found" from "not looked for" */
    sn_index external_count;
    sn_external *externals; /* (external_count) one for each target and fascia */
} sn_muscle;

void sn_roots_free(sn_roots *roots);
void sn_structure_free(sn_structure *structure);
void sn_fibers_free(sn_fibers *fibers);
void sn_attachments_free(sn_attachment *attachments, sn_index count);
void sn_externals_free(sn_external *externals, sn_index count);
/* What the weights of slide, soft and hard come to beside each other ([R18] eqs. 11-13): slide as it is, the rest shared by soft and hard;
 * 0 both where both are 0. */
void sn_external_blend(const double weights[3], double out[3]);
void sn_muscle_free(sn_muscle *muscle); /* frees what it owns and zeroes it */
unsigned sn_muscle_sections(const sn_muscle *muscle); /* the sections that are there: bits of sn_section */
/* How each attachment holds: grips (attachment_count). The muscle must be valid. */
SN_MUST_CHECK sn_status sn_muscle_grips(const sn_muscle *muscle, sn_grip *grips, sn_error *error);
/* The one bone that holds all attached vertices; NULL = none, or there are several. */
const char *sn_muscle_only_bone(const sn_muscle *muscle);
/* A copy of the mesh with the sections painted on it, for programs that know meshes only: "fiber" (3 numbers: the unit direction),
 * "sample" (the structure's sample that the vertex hangs on, -1 = none), "attachment" (the index of its bone, -1 = none; the bones are
 * its labels) and "root" (1 on roots). An attribute of the mesh that has one of these names gives way. */
SN_MUST_CHECK sn_status sn_muscle_paint(const sn_muscle *muscle, sn_mesh *out, sn_error *error);
/* Indices in range, arrays finite, the tree a tree (one root, parents before children), no vertex on two bones:
 * SN_ERROR_INPUT naming the section and the element. Sections may be absent. */
SN_MUST_CHECK sn_status sn_muscle_validate(const sn_muscle *muscle, sn_error *error);

#endif
