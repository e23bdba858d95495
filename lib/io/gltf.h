/*
 * gltf.h -- files of glTF 2, as JSON and as GLB. Private to lib/io.
 *
 * gltf.c opens one and knows its extensions, gltf_buffer.c has its bytes, gltf_accessor.c the numbers in them, gltf_node.c the transforms
 * of its nodes and what skins do to them, gltf_mesh.c its surfaces. Written because assimp passes over what moves geometry: required
 * extensions, numbers that are no floats, skins, instances.
 */
#ifndef SINEW_IO_GLTF_H
#define SINEW_IO_GLTF_H

#include "json.h"
#include "sinew/io.h"

/* p -> M p + t: rows of M with t behind. */
typedef struct sn_gltf_transform {
    double m[3][4];
} sn_gltf_transform;

typedef struct sn_gltf_node {
    sn_index parent, depth; /* SN_NONE = a root */
    sn_gltf_transform local;
    sn_index mesh, skin; /* SN_NONE = none */
    bool visited;
} sn_gltf_node;

/* Not to be copied: values point to each other. */
typedef struct sn_gltf {
    const sn_gltf_source *source;
    sn_json_tree *tree;
    sn_json_value top, accessors, views, buffers, nodes, meshes, skins;
    const char *binary; /* the second chunk of a GLB */
    size_t binary_size;
    sn_index buffer_count, node_count;
    sn_blob *blobs;  /* (buffer_count) those that were read */
    bool *available; /* (buffer_count) */
    sn_gltf_node *node;
} sn_gltf;

/* gltf.c. An extension that the file requires and that nobody here knows is an error. Close it also on failure. */
SN_MUST_CHECK sn_status sn_gltf_open(sn_gltf *g, const sn_gltf_source *source, sn_error *error);
void sn_gltf_close(sn_gltf *g);
/* A whole number, also one that is written 1.0, in [0, most]; *out stays where it is absent. */
SN_MUST_CHECK sn_status sn_gltf_get_whole(const sn_json_value *value, double most, size_t *out, sn_error *error);
SN_MUST_CHECK sn_status sn_gltf_get_index(const sn_json_value *value, sn_index count, sn_index *out, sn_error *error);
/* A list of such indices; none where it is absent. */
SN_MUST_CHECK sn_status sn_gltf_get_indices(const sn_json_value *value, sn_index count, sn_index *out_count, sn_index **out,
                                            sn_error *error);
/* How many an array of the top level has; 0 = it is absent. */
SN_MUST_CHECK sn_status sn_gltf_count(const sn_json_value *list, sn_index *out, sn_error *error);
/* The member of an object's "extensions". */
bool sn_gltf_has_extension(const sn_json_value *object, const char *name);

/* gltf_buffer.c: the bytes of a buffer view. stride: 0 = packed. */
typedef struct sn_gltf_view {
    const unsigned char *bytes;
    size_t size, stride;
} sn_gltf_view;
SN_MUST_CHECK sn_status sn_gltf_read_view(sn_gltf *g, sn_index view, sn_gltf_view *out, sn_error *error);

/* Types of components (glTF 2.0, 3.6.2.2). */
enum { SN_GLTF_BYTE = 5120, SN_GLTF_UNSIGNED_BYTE, SN_GLTF_SHORT, SN_GLTF_UNSIGNED_SHORT, SN_GLTF_UNSIGNED_INT = 5125, SN_GLTF_FLOAT };

/* gltf_accessor.c: rows of numbers; normalized ones in [-1,1]. Sparse ones are filled in. */
typedef struct sn_gltf_numbers {
    double *values; /* (count x width) owned; NULL on failure */
    int width;
    sn_index count;
    int type; /* of the components: SN_GLTF_... */
    bool normalized;
} sn_gltf_numbers;
/* Unsigned whole numbers. */
bool sn_gltf_is_index(int type);
/* `value` has components that it must not have; wanted: what it should have. */
sn_status sn_gltf_refuse_type(const sn_json_value *value, int type, bool normalized, const char *wanted, sn_error *error);
SN_MUST_CHECK sn_status sn_gltf_read_numbers(sn_gltf *g, sn_index accessor, sn_gltf_numbers *out, sn_error *error);

/* gltf_node.c */
SN_MUST_CHECK sn_status sn_gltf_read_nodes(sn_gltf *g, sn_error *error);
sn_gltf_transform sn_gltf_multiply(const sn_gltf_transform *a, const sn_gltf_transform *b);
/* Scale, then turn (x y z w, of any length above 0), then translate. */
sn_gltf_transform sn_gltf_compose(const double translation[3], const double rotation[4], const double scale[3]);
sn_gltf_transform sn_gltf_world(const sn_gltf *g, sn_index node);
/* Joints that carry a vertex, by their number in the skin; none: all of them are asked. */
typedef struct sn_gltf_joints {
    bool *used; /* (count) */
    sn_index count;
} sn_gltf_joints;
/* Where a skin has the mesh that is bound to it, in the pose of the file's nodes; where they are not in the pose that it was bound in,
 * *posed, as it was bound, where the uppermost of those joints has it. */
SN_MUST_CHECK sn_status sn_gltf_place_skin(sn_gltf *g, sn_index skin, const sn_gltf_joints *joints, sn_gltf_transform *out, bool *posed,
                                           sn_error *error);

#endif
