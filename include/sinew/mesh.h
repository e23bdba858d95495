/*
 * mesh.h -- the indexed triangle mesh: storage, adjacency, measures, defects.   rank 1
 */
#ifndef SINEW_MESH_H
#define SINEW_MESH_H

#include "sinew/vec.h"

typedef struct sn_triangle { sn_index v[3]; } sn_triangle; /* counter-clockwise seen from outside */
/* Does its boundary run from a to b? */
static inline bool sn_triangle_runs(const sn_triangle *t, sn_index a, sn_index b) {
    return (t->v[0] == a && t->v[1] == b) || (t->v[1] == a && t->v[2] == b) || (t->v[2] == a && t->v[0] == b);
}

/* One number, or a few, per vertex: a painted map, a colour, a custom PLY property. */
typedef struct sn_attribute {
    char *name;         /* as in the file: "red", "activation_share", ... ; owned */
    sn_index components; /* >= 1 */
    bool integer;       /* written as unsigned char where all values fit 0..255 (colours), else as int */
    double *values;     /* (vertex_count x components); owned */
    sn_index label_count;
    char **labels;      /* (label_count) what the values 0, 1, ... stand for (bones); owned; NULL = nothing */
} sn_attribute;

/* Vertices keep the order of their file. Coordinates are in whatever unit the holder says (sn_muscle: document units). */
typedef struct sn_mesh {
    sn_index vertex_count, triangle_count;
    sn_vec3 *positions;     /* (vertex_count) */
    sn_triangle *triangles; /* (triangle_count) */
    sn_index attribute_count;
    sn_attribute *attributes;  /* (attribute_count) */
    sn_index group_count;
    char **group_names;        /* (group_count) names of OBJ groups or objects */
    sn_index *triangle_group;  /* (triangle_count) index of its group or SN_NONE; NULL when group_count is 0 */
} sn_mesh;

/* An empty mesh is all zeros: sn_mesh m = {0}. */
SN_MUST_CHECK sn_status sn_mesh_alloc(sn_mesh *mesh, sn_index vertex_count, sn_index triangle_count, sn_error *error);
SN_MUST_CHECK sn_status sn_mesh_copy(const sn_mesh *from, sn_mesh *to, sn_error *error);
/* A new zeroed attribute; NULL = out of memory. name is copied. The pointer lives until the next one is added. */
sn_attribute *sn_mesh_add_attribute(sn_mesh *mesh, const char *name, sn_index components);
void sn_mesh_remove_attribute(sn_mesh *mesh, const char *name); /* nothing where there is none */
/* A copy of text as the attribute's next label; false = out of memory. */
bool sn_attribute_add_label(sn_attribute *attribute, const char *text);
const sn_attribute *sn_mesh_attribute(const sn_mesh *mesh, const char *name); /* NULL = none of that name */
void sn_mesh_free(sn_mesh *mesh); /* frees what it owns and zeroes it; an empty mesh is fine */
/* Every index in range, every coordinate finite, at least one triangle: what every algorithm asks of its input.
 * SN_ERROR_INPUT with the first offending vertex or triangle in error->element. */
SN_MUST_CHECK sn_status sn_mesh_validate(const sn_mesh *mesh, sn_error *error);
/* Keep the triangles t with keep[t] (triangle_count), in their order, with their groups; vertices stay. */
void sn_mesh_keep_triangles(sn_mesh *mesh, const bool *keep);

/* ---- adjacency ---------------------------------------------------------------------------------------------------- */

/* One undirected edge, v[0] < v[1]. */
typedef struct sn_edge {
    sn_index v[2];
    sn_index triangle[2]; /* the first two triangles on it; SN_NONE = none. On a closed manifold both are set */
    sn_index opposite[2]; /* the third vertex of each; SN_NONE = none */
    sn_index triangle_count;
} sn_edge;

/* All adjacency of a mesh; vertex lists are in ascending order of their entries. Edges are sorted by (v[0], v[1]). */
typedef struct sn_topology {
    sn_index vertex_count, triangle_count, edge_count;
    sn_edge *edges;                 /* (edge_count) */
    sn_index (*triangle_edges)[3];  /* (triangle_count) edge opposite to corner 0, 1, 2; SN_NONE x 3 where an index is repeated */
    sn_index *vertex_start;         /* (vertex_count + 1) into neighbours and vertex_edges */
    sn_index *neighbours;           /* (2 edge_count) adjacent vertices */
    sn_index *vertex_edges;         /* (2 edge_count) the edge to each neighbour */
    sn_index *corner_start;         /* (vertex_count + 1) into vertex_triangles */
    sn_index *vertex_triangles;     /* (3 triangle_count) incident triangles */
} sn_topology;
SN_MUST_CHECK sn_status sn_topology_build(const sn_mesh *mesh, sn_topology *out, sn_error *error); /* a valid mesh, any defects */
void sn_topology_free(sn_topology *topology);
sn_index sn_topology_edge(const sn_topology *topology, sn_index a, sn_index b); /* edge between a and b, or SN_NONE */

/* Connected components over shared edges: component (triangle_count) numbered by lowest triangle; returns how many. */
sn_index sn_mesh_components(const sn_mesh *mesh, const sn_topology *topology, sn_index *component);

/* ---- measures ----------------------------------------------------------------------------------------------------- */

typedef struct sn_box { sn_vec3 low, high; } sn_box; /* empty: low > high */
#define SN_EMPTY_BOX ((sn_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}})
static inline void sn_box_add(sn_box *box, sn_vec3 p) {
    box->low = sn_min3(box->low, p);
    box->high = sn_max3(box->high, p);
}
/* How far they are apart; 0: they meet. */
static inline double sn_box_gap(sn_box a, sn_box b) {
    sn_vec3 apart = sn_max3(sn_sub(a.low, b.high), sn_sub(b.low, a.high));
    return sn_norm(sn_max3(apart, sn_v3(0, 0, 0)));
}
static inline bool sn_boxes_meet(const sn_box *a, const sn_box *b) {
    return a->low.x <= b->high.x && b->low.x <= a->high.x && a->low.y <= b->high.y && b->low.y <= a->high.y && a->low.z <= b->high.z &&
           b->low.z <= a->high.z;
}
sn_box sn_mesh_box(const sn_mesh *mesh);
double sn_box_diagonal(sn_box box); /* 0 for an empty box */
double sn_mesh_area(const sn_mesh *mesh);
void sn_mesh_vertex_areas(const sn_mesh *mesh, double *areas); /* a third of the triangles around each vertex: areas (vertex_count) */
/* V = 1/6 sum p_i . (p_j x p_k), relative to the box centre: far from the origin the plain sum cancels. */
double sn_mesh_volume(const sn_mesh *mesh);
sn_vec3 sn_mesh_volume_centroid(const sn_mesh *mesh); /* of the enclosed volume; area centroid where |V| is tiny */
double sn_mesh_mean_edge(const sn_mesh *mesh, const sn_topology *topology);
/* Mean side of the triangles, which needs no topology: edges inside of the surface count twice; 0 without triangles. */
double sn_mesh_mean_side(const sn_mesh *mesh);
/* Area-weighted unit vertex normals (vertex_count); zero where the area sum vanishes. */
void sn_mesh_vertex_normals(const sn_mesh *mesh, sn_vec3 *normals);

/* ---- anatomical spaces (lib/geom/space.c) ------------------------------------------------------------------------------ */

/* Which way the axes of a scan's coordinates point: left, posterior, superior; or right, anterior, superior. A turn by half about z is
 * between the two, so that one file of each puts a muscle beside the other side's bone. */
typedef enum sn_space { SN_SPACE_UNKNOWN, SN_SPACE_LPS, SN_SPACE_RAS } sn_space;
const char *sn_space_name(sn_space space);         /* "LPS", "RAS"; NULL of an unknown one */
sn_space sn_space_from_name(const char *name);     /* that, or SN_SPACE_UNKNOWN */
/* What a header says by SPACE=LPS or SPACE=RAS, as 3D Slicer writes it into comments and titles: text (size) is the file's beginning. */
sn_space sn_space_find(const char *text, size_t size);
/* The space of all that is read from here on and is no document, whatever headers say (SN_SPACE_UNKNOWN = as they say, the default); set
 * before anything is read, as by --space. */
void sn_space_tell(sn_space space);
sn_space sn_space_told(void);
/* Of the file `name`, whose header says `header`: what was told, else that. A warning in the log where the two differ. */
sn_space sn_space_settle(const char *name, sn_space header);

/* The space of a command's inputs so far, and who told it. */
typedef struct sn_space_seen {
    sn_space space;
    char name[160]; /* "" = sn_space_tell */
} sn_space_seen;
static inline sn_space_seen sn_space_begin(void) { return (sn_space_seen){sn_space_told(), ""}; }
/* One more input. SN_ERROR_INPUT where it is in another space than one before: both are named. */
SN_MUST_CHECK sn_status sn_space_take(sn_space_seen *seen, sn_space space, const char *name, sn_error *error);

/* ---- defects ------------------------------------------------------------------------------------------------------ */

#define SN_SLIVER_QUALITY 0.05

typedef struct sn_mesh_report {
    sn_index vertices, triangles, edges, components;
    sn_index unused_vertices, duplicate_vertices;       /* exactly equal coordinates */
    sn_index degenerate_triangles, duplicate_triangles; /* repeated index or zero area; the same three vertices */
    sn_index sliver_triangles;                          /* not degenerate, but of a quality below SN_SLIVER_QUALITY */
    sn_index boundary_edges, boundary_loops, nonmanifold_edges, nonmanifold_vertices, inconsistent_edges;
    sn_index self_intersections; /* pairs of triangles that cross; -1 = not computed */
    double genus;                /* summed over components; NaN where the surface is not a closed manifold */
    double area, volume, diagonal;
    sn_box box;
    double edge_min, edge_mean, edge_max;
    double worst_quality;        /* min over triangles of 4 sqrt(3) area / (a^2+b^2+c^2): 1 equilateral, 0 degenerate */
    bool closed, manifold, oriented, outward;
} sn_mesh_report;
SN_MUST_CHECK sn_status sn_mesh_inspect(const sn_mesh *mesh, sn_mesh_report *out, sn_error *error);
/* Warn of a bone of which more than a hundredth speaks against itself (triangles that stand twice, opposite windings, edges in more than
 * two triangles), so that what is inside of it cannot be told. */
SN_MUST_CHECK sn_status sn_mesh_warn_of_sides(const sn_mesh *mesh, const char *name, sn_error *error);

#endif
