/* gltf_node.c -- the transforms of the nodes of a glTF file, and where skins have their meshes (gltf.h). */
#include "gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Two placements are one where they differ by less than this times their own size: IBMs are single precision. */
#define POSE_TOLERANCE 1e-4

/* ---- transforms ---------------------------------------------------------------------------------------------------------------------- */

sn_gltf_transform sn_gltf_multiply(const sn_gltf_transform *a, const sn_gltf_transform *b) {
    sn_gltf_transform c;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            c.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0.0);
    return c;
}

sn_gltf_transform sn_gltf_compose(const double translation[3], const double rotation[4], const double scale[3]) {
    double n = rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2] + rotation[3] * rotation[3];
    double f = n > 0.0 ? 2.0 / n : 0.0, x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    const double turn[3][3] = {{1 - f * (y * y + z * z), f * (x * y - z * w), f * (x * z + y * w)},
                               {f * (x * y + z * w), 1 - f * (x * x + z * z), f * (y * z - x * w)},
                               {f * (x * z - y * w), f * (y * z + x * w), 1 - f * (x * x + y * y)}};
    sn_gltf_transform t;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) t.m[i][j] = turn[i][j] * scale[j];
        t.m[i][3] = translation[i];
    }
    return t;
}

/* Sixteen numbers by columns. */
static sn_gltf_transform from_columns(const double *numbers) {
    sn_gltf_transform t;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) t.m[i][j] = numbers[4 * j + i];
    return t;
}

sn_gltf_transform sn_gltf_world(const sn_gltf *g, sn_index node) {
    sn_gltf_transform t = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    for (; node != SN_NONE; node = g->node[node].parent) t = sn_gltf_multiply(&g->node[node].local, &t);
    return t;
}

/* ---- nodes --------------------------------------------------------------------------------------------------------------------------- */

static sn_status read_local(const sn_json_value *object, sn_gltf_transform *out, sn_error *error) {
    double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    sn_json_value m = sn_json_member(object, "matrix"), t = sn_json_member(object, "translation");
    sn_json_value r = sn_json_member(object, "rotation"), s = sn_json_member(object, "scale");
    sn_status status = sn_json_get_fixed(&m, 16, matrix, error);
    if (status == SN_OK) status = sn_json_get_fixed(&t, 3, translation, error);
    if (status == SN_OK) status = sn_json_get_fixed(&r, 4, rotation, error);
    if (status == SN_OK) status = sn_json_get_fixed(&s, 3, scale, error);
    if (status == SN_OK && matrix[3] * matrix[3] + matrix[7] * matrix[7] + matrix[11] * matrix[11] + fabs(matrix[15] - 1.0) > 1e-6)
        status = sn_json_complain(&m, error, "is a perspective, not a transform of a node");
    *out = sn_json_has(&m) ? from_columns(matrix) : sn_gltf_compose(translation, rotation, scale);
    return status;
}

static sn_status adopt(sn_gltf *g, sn_index parent, const sn_json_value *object, sn_error *error) {
    sn_json_value value = sn_json_member(object, "children");
    sn_index *children, count;
    sn_status status = sn_gltf_get_indices(&value, g->node_count, &count, &children, error);
    for (sn_index k = 0; k < count && status == SN_OK; k++) {
        if (g->node[children[k]].parent != SN_NONE || children[k] == parent)
            status = sn_json_complain(&value, error, "node %d hangs on two nodes", (int)children[k]);
        else
            g->node[children[k]].parent = parent;
    }
    free(children);
    return status;
}

static sn_status read_node(sn_gltf *g, sn_index i, sn_error *error) {
    sn_json_value object = sn_json_element(&g->nodes, i), mesh = sn_json_member(&object, "mesh"), skin = sn_json_member(&object, "skin");
    sn_index meshes, skins;
    sn_gltf_node *node = &g->node[i];
    sn_status status = sn_gltf_count(&g->meshes, &meshes, error);
    if (status == SN_OK) status = sn_gltf_count(&g->skins, &skins, error);
    if (status == SN_OK) status = sn_gltf_get_index(&mesh, meshes, &node->mesh, error);
    if (status == SN_OK) status = sn_gltf_get_index(&skin, skins, &node->skin, error);
    if (status == SN_OK) status = read_local(&object, &node->local, error);
    return status == SN_OK ? adopt(g, i, &object, error) : status;
}

/* How far each is below its root; a node that is none's child and yet never reached from a root hangs on itself. Every chain is walked to
 * what is known, twice: linear. */
static sn_status measure_depths(sn_gltf *g, sn_error *error) {
    for (sn_index i = 0; i < g->node_count; i++) {
        sn_index above = 0, at = i;
        while (at != SN_NONE && g->node[at].depth == SN_NONE && above <= g->node_count) {
            at = g->node[at].parent;
            above++;
        }
        if (above > g->node_count) return sn_fail(error, SN_ERROR_INPUT, "nodes[%d]: hangs on itself", (int)i);
        sn_index depth = above + (at != SN_NONE ? g->node[at].depth + 1 : 0);
        for (at = i; at != SN_NONE && g->node[at].depth == SN_NONE; at = g->node[at].parent) g->node[at].depth = --depth;
    }
    return SN_OK;
}

sn_status sn_gltf_read_nodes(sn_gltf *g, sn_error *error) {
    sn_status status = SN_OK;
    if ((g->node = SN_NEW(sn_gltf_node, g->node_count)) == NULL) return sn_fail_memory(error, "the nodes");
    for (sn_index i = 0; i < g->node_count; i++)
        g->node[i] = (sn_gltf_node){.parent = SN_NONE, .depth = SN_NONE, .mesh = SN_NONE, .skin = SN_NONE};
    for (sn_index i = 0; i < g->node_count && status == SN_OK; i++) status = read_node(g, i, error);
    return status == SN_OK ? measure_depths(g, error) : status;
}

/* ---- skins --------------------------------------------------------------------------------------------------------------------------- */

typedef struct skin {
    sn_index *joints, count;
    sn_gltf_numbers matrices; /* (16 x count); no values = identities */
} skin;

static void free_skin(skin *s) {
    free(s->joints);
    free(s->matrices.values);
}

static sn_status read_skin(sn_gltf *g, sn_index index, skin *s, sn_error *error) {
    sn_json_value object = sn_json_element(&g->skins, index), joints = sn_json_member(&object, "joints");
    sn_json_value matrices = sn_json_member(&object, "inverseBindMatrices");
    sn_index accessors = 0, accessor = SN_NONE;
    sn_status status = sn_gltf_get_indices(&joints, g->node_count, &s->count, &s->joints, error);
    if (status == SN_OK && s->count == 0) status = sn_json_complain(&object, error, "has no joints");
    if (status == SN_OK) status = sn_gltf_count(&g->accessors, &accessors, error);
    if (status == SN_OK) status = sn_gltf_get_index(&matrices, accessors, &accessor, error);
    if (status == SN_OK && accessor != SN_NONE) status = sn_gltf_read_numbers(g, accessor, &s->matrices, error);
    if (status == SN_OK && accessor != SN_NONE && (s->matrices.width != 16 || s->matrices.count < s->count))
        status = sn_json_complain(&matrices, error, "are %d rows of %d numbers, not a matrix for each of %d joints", (int)s->matrices.count,
                                  s->matrices.width, (int)s->count);
    return status;
}

/* Joint j of the skin times its inverse bind matrix: where it has the mesh. */
static sn_gltf_transform placement(const sn_gltf *g, const skin *s, sn_index j) {
    sn_gltf_transform world = sn_gltf_world(g, s->joints[j]);
    if (s->matrices.values == NULL) return world;
    sn_gltf_transform inverse_bind = from_columns(s->matrices.values + (size_t)16 * (size_t)j);
    return sn_gltf_multiply(&world, &inverse_bind);
}

static bool differ(const sn_gltf_transform *a, const sn_gltf_transform *b) {
    double size[2] = {0.0, 0.0}, difference[2] = {0.0, 0.0}; /* of the matrix and of the translation */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            size[j == 3] = fmax(size[j == 3], fmax(fabs(a->m[i][j]), fabs(b->m[i][j])));
            difference[j == 3] = fmax(difference[j == 3], fabs(a->m[i][j] - b->m[i][j]));
        }
    return difference[0] > POSE_TOLERANCE * size[0] || difference[1] > POSE_TOLERANCE * fmax(size[1], size[0]);
}

static bool carries(const sn_gltf_joints *joints, sn_index j) { return joints->used == NULL || (j < joints->count && joints->used[j]); }

static sn_index uppermost(const sn_gltf *g, const skin *s, const sn_gltf_joints *joints) {
    sn_index best = SN_NONE;
    for (sn_index j = 0; j < s->count; j++)
        if (carries(joints, j) && (best == SN_NONE || g->node[s->joints[j]].depth < g->node[s->joints[best]].depth)) best = j;
    return best;
}

/* The placement by joint `first`; do the others that carry something have it elsewhere? */
static sn_gltf_transform compare(const sn_gltf *g, const skin *s, const sn_gltf_joints *joints, sn_index first, bool *posed) {
    sn_gltf_transform out = placement(g, s, first);
    for (sn_index j = 0; j < s->count && !*posed; j++) {
        if (!carries(joints, j)) continue;
        sn_gltf_transform other = placement(g, s, j);
        *posed = differ(&out, &other);
    }
    return out;
}

sn_status sn_gltf_place_skin(sn_gltf *g, sn_index index, const sn_gltf_joints *joints, sn_gltf_transform *out, bool *posed,
                             sn_error *error) {
    static const sn_gltf_joints all = {0};
    skin s = {0};
    *posed = false;
    sn_status status = read_skin(g, index, &s, error);
    if (status == SN_OK && uppermost(g, &s, joints) == SN_NONE) joints = &all;
    if (status == SN_OK) *out = compare(g, &s, joints, uppermost(g, &s, joints), posed);
    free_skin(&s);
    return status;
}
