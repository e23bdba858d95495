/*
 * nodes.h -- trees of nodes and their animations, as glTF, FBX and Collada have them. Private to lib/io.
 *
 * mesh-import tells them (tools/mesh-import.c states its text), import.c asks it; nodes.c reads its answer, nodes_gltf.c what it cannot
 * tell of glTF, nodes_clip.c makes a clip of one animation.
 */
#ifndef SINEW_IO_NODES_H
#define SINEW_IO_NODES_H

#include "clip_reader.h"

/* p -> M p + t: rows of M with t behind. */
typedef struct sn_affine {
    double m[3][4];
} sn_affine;

typedef struct sn_node {
    char *name; /* owned; may be empty */
    sn_index parent;
    sn_affine local;  /* to the parent, at rest */
    bool bound;       /* a mesh's bone */
    sn_affine bind;   /* bound: its world frame when the mesh was bound */
    bool bound_apart; /* meshes were bound in different poses: bind is the first one's */
} sn_node;

/* Keys of a position, a turn (w x y z) or a scale. */
typedef struct sn_track {
    sn_index count;
    double *times;  /* (count) seconds, none before the one before it; owned */
    double *values; /* (count x width); owned */
    bool step;      /* keeps a key's value until the next */
} sn_track;

enum { SN_TRACK_POSITION, SN_TRACK_TURN, SN_TRACK_SCALE, SN_TRACK_COUNT };

typedef struct sn_node_channel {
    sn_index node; /* SN_NONE = of no node of the scene */
    sn_track tracks[SN_TRACK_COUNT];
} sn_node_channel;

typedef struct sn_animation {
    char *name;
    double ticks; /* a second; 0 = the file does not say */
    sn_index channel_count;
    sn_node_channel *channels;
} sn_animation;

typedef struct sn_nodes {
    sn_mesh_frame frame;
    sn_index node_count, animation_count;
    sn_node *nodes; /* (node_count) parents before children; all owned */
    sn_animation *animations;
    size_t node_capacity, animation_capacity;
} sn_nodes;

static inline sn_index sn_track_width(int track) { return track == SN_TRACK_TURN ? 4 : 3; }

/* Ask mesh-import. Errors are one sentence, whatever it does. */
SN_MUST_CHECK sn_status sn_import_nodes(const sn_blob *blob, sn_nodes *out, sn_error *error);
/* The text of mesh-import --motion. SN_ERROR_INTERNAL: it is not of that form. *out is empty on failure. */
SN_MUST_CHECK sn_status sn_nodes_parse(const sn_blob *answer, sn_nodes *out, sn_error *error);
void sn_nodes_free(sn_nodes *nodes); /* leaves all zeros */

/* Interpolation of an animation's tracks out of a glTF file, which assimp leaves out; *curves counts those that are told by cubic splines.
 * What assimp would misread, keys that are no floats, is refused. */
SN_MUST_CHECK sn_status sn_gltf_interpolation(const sn_blob *file, sn_nodes *nodes, sn_index animation, sn_index *curves, sn_error *error);

/* A clip of one animation, SN_NONE = of none: the rest pose. In metres, in the file's axes. */
typedef struct sn_nodes_clip_options {
    sn_index animation;
    double rate;            /* frames a second; 0 = as nodes and keys suggest */
    double meters_per_unit; /* of the clip's source */
    bool curves;            /* the file may tell more between keys than nodes do */
    const char *name;       /* of the file, for warnings */
    size_t file_size;
} sn_nodes_clip_options;
SN_MUST_CHECK sn_status sn_nodes_clip(const sn_nodes *nodes, const sn_nodes_clip_options *options, sn_clip *out, sn_error *error);

#endif
