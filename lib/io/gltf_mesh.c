/* gltf_mesh.c -- the surfaces of a glTF file, node by node: primitives, morph targets, skins, instances (gltf.h). */
#include "gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INSTANCING "EXT_mesh_gpu_instancing"
#define DRACO "KHR_draco_mesh_compression"

/* glTF 2.0, 3.7.2.1: modes of a primitive */
enum { TRIANGLES = 4, STRIP, FAN };

/* A mesh as it is in its own space, and who uses it. */
typedef struct surface {
    double *positions; /* (3 x vertex_count) */
    float *colours;    /* (4 x vertex_count); NULL = none yet */
    sn_index *corners;
    size_t vertex_count, vertex_capacity, colour_capacity, corner_count, corner_capacity;
    sn_gltf_joints joints; /* those that carry a vertex */
    const double *weights; /* (weight_count) of morph targets */
    sn_index weight_count;
} surface;

static void free_surface(surface *s) {
    free(s->positions);
    free(s->colours);
    free(s->corners);
    free(s->joints.used);
}

/* ---- numbers of a primitive ---------------------------------------------------------------------------------------------------------- */

/* The accessor of an attribute; *out is SN_NONE where there is none. */
static sn_status find_accessor(sn_gltf *g, const sn_json_value *object, const char *key, sn_index *out, sn_error *error) {
    sn_json_value value = sn_json_member(object, key);
    sn_index count = 0;
    *out = SN_NONE;
    sn_status status = sn_gltf_count(&g->accessors, &count, error);
    return status == SN_OK ? sn_gltf_get_index(&value, count, out, error) : status;
}

/* What components may be: by glTF 2.0, 3.7.2.1, and by KHR_mesh_quantization for places. */
typedef enum component_kind { PLACES, INDICES, JOINTS, WEIGHTS } component_kind;

/* Of these rows of numbers; count < 0: as many as there are. */
typedef struct shape {
    const char *key;
    int width;
    sn_index count;
    component_kind kind;
} shape;

static sn_status check_kind(const sn_json_value *value, component_kind kind, const sn_gltf_numbers *n, sn_error *error) {
    static const char *const wanted[] = {"places are floats, bytes or shorts", "indices are unsigned whole numbers",
                                         "joints are unsigned bytes or shorts",
                                         "weights are floats, or normalized unsigned bytes or shorts"};
    bool real = n->type == SN_GLTF_FLOAT, index = sn_gltf_is_index(n->type), wide = n->type == SN_GLTF_UNSIGNED_INT;
    bool good = kind == PLACES    ? !wide
                : kind == INDICES ? index && !n->normalized
                : kind == JOINTS  ? index && !wide && !n->normalized
                                  : real || (index && !wide && n->normalized);
    return good ? SN_OK : sn_gltf_refuse_type(value, n->type, n->normalized, wanted[kind], error);
}

/* No values where the attribute is absent. */
static sn_status read_attribute(sn_gltf *g, const sn_json_value *object, shape wanted, sn_gltf_numbers *out, sn_error *error) {
    sn_index accessor;
    *out = (sn_gltf_numbers){0};
    sn_status status = find_accessor(g, object, wanted.key, &accessor, error);
    if (status != SN_OK || accessor == SN_NONE) return status;
    status = sn_gltf_read_numbers(g, accessor, out, error);
    if (status != SN_OK) return status;
    sn_json_value value = sn_json_member(object, wanted.key);
    status = check_kind(&value, wanted.kind, out, error);
    if (status == SN_OK && out->width == wanted.width && (wanted.count < 0 || out->count == wanted.count)) return SN_OK;
    if (status == SN_OK)
        status = sn_json_complain(&value, error, "is %d rows of %d numbers, not %d of %d", (int)out->count, out->width,
                                  (int)(wanted.count >= 0 ? wanted.count : out->count), wanted.width);
    free(out->values);
    *out = (sn_gltf_numbers){0};
    return status;
}

/* Positions must have numbers: an accessor without any stands for what an extension has packed. */
static sn_status check_positions(sn_gltf *g, const sn_json_value *primitive, const sn_json_value *attributes, sn_error *error) {
    sn_index accessor;
    sn_status status = find_accessor(g, attributes, "POSITION", &accessor, error);
    if (status != SN_OK || accessor == SN_NONE) return status;
    sn_json_value object = sn_json_element(&g->accessors, accessor), view = sn_json_member(&object, "bufferView");
    sn_json_value sparse = sn_json_member(&object, "sparse");
    if (sn_json_has(&view) || sn_json_has(&sparse)) return SN_OK;
    if (sn_gltf_has_extension(primitive, DRACO))
        return sn_fail(error, SN_ERROR_INPUT, "has its meshes packed by the extension %s, which is not read; export it without compression",
                       DRACO);
    return sn_json_complain(&object, error,
                            "has no numbers, and positions are said to be there; an extension that is not read may have them");
}

/* ---- vertices ------------------------------------------------------------------------------------------------------------------------ */

static sn_status add_morphs(sn_gltf *g, const sn_json_value *primitive, const surface *s, sn_gltf_numbers *positions, sn_error *error) {
    sn_json_value targets = sn_json_member(primitive, "targets");
    sn_index target_count = 0;
    sn_status status = sn_gltf_count(&targets, &target_count, error);
    for (sn_index i = 0; i < target_count && i < s->weight_count && status == SN_OK; i++) {
        sn_gltf_numbers moves;
        sn_json_value target = sn_json_element(&targets, i);
        if (s->weights[i] == 0.0) continue;
        status = read_attribute(g, &target, (shape){"POSITION", 3, positions->count, PLACES}, &moves, error);
        for (size_t k = 0; moves.values != NULL && k < 3 * (size_t)positions->count; k++)
            positions->values[k] += s->weights[i] * moves.values[k];
        free(moves.values);
    }
    return status;
}

static sn_status add_positions(surface *s, const sn_gltf_numbers *positions, sn_error *error) {
    size_t needed = s->vertex_count + (size_t)positions->count;
    if (needed >= SN_INDEX_MAX) return sn_fail(error, SN_ERROR_INPUT, "the file has more vertices than sinew can count");
    if (!sn_grow((void **)&s->positions, &s->vertex_capacity, needed, 3 * sizeof *s->positions))
        return sn_fail_memory(error, "the vertices");
    memcpy(s->positions + 3 * s->vertex_count, positions->values, 3 * sizeof(double) * (size_t)positions->count);
    s->vertex_count = needed;
    return SN_OK;
}

static float to_channel(double c) { return c >= 0.0 && c <= 1.0 ? (float)c : c > 1.0 ? 1.0f : 0.0f; }

/* White where a primitive has no colours and another of the mesh has. */
static sn_status fill_colours(surface *s, const sn_gltf_numbers *colours, sn_index count, sn_error *error) {
    size_t first = s->vertex_count - (size_t)count, width = (size_t)colours->width;
    size_t begin = s->colours != NULL ? first : 0;
    if (s->colours == NULL && colours->values == NULL) return SN_OK;
    if (!sn_grow((void **)&s->colours, &s->colour_capacity, s->vertex_count, 4 * sizeof *s->colours))
        return sn_fail_memory(error, "the colours");
    for (size_t i = begin; i < s->vertex_count; i++)
        for (size_t k = 0; k < 4; k++) {
            bool told = i >= first && colours->values != NULL && k < width;
            s->colours[4 * i + k] = told ? to_channel(colours->values[(i - first) * width + k]) : 1.0f;
        }
    return SN_OK;
}

static sn_status add_colours(sn_gltf *g, surface *s, const sn_json_value *attributes, sn_index count, sn_error *error) {
    sn_gltf_numbers colours = {0};
    sn_index accessor;
    sn_status status = find_accessor(g, attributes, "COLOR_0", &accessor, error);
    if (status == SN_OK && accessor != SN_NONE) status = sn_gltf_read_numbers(g, accessor, &colours, error);
    if (status == SN_OK && colours.values != NULL && (colours.count != count || colours.width < 3 || colours.width > 4))
        status = sn_fail(error, SN_ERROR_INPUT, "colours are %d rows of %d numbers, for %d vertices", (int)colours.count, colours.width,
                         (int)count);
    if (status == SN_OK) status = fill_colours(s, &colours, count, error);
    free(colours.values);
    return status;
}

/* ---- joints that carry something -------------------------------------------------------------------------------------------------------
 */

static sn_status mark_used(sn_gltf_joints *j, const double *joints, const double *weights, size_t count, sn_error *error) {
    for (size_t i = 0; i < count; i++) {
        if (!(weights[i] > 0.0) || !(joints[i] >= 0.0 && joints[i] < 65536.0)) continue;
        sn_index joint = (sn_index)joints[i], room = j->count;
        if (joint >= room) {
            bool *more = sn_realloc(j->used, (size_t)joint + 1, sizeof *more);
            if (more == NULL) return sn_fail_memory(error, "the joints");
            memset(more + room, 0, (size_t)(joint + 1 - room) * sizeof *more);
            *j = (sn_gltf_joints){more, joint + 1};
        }
        j->used[joint] = true;
    }
    return SN_OK;
}

/* Sets of four joints a vertex: JOINTS_0, JOINTS_1, ... */
static sn_status add_joints(sn_gltf *g, surface *s, const sn_json_value *attributes, sn_index count, sn_error *error) {
    sn_status status = SN_OK;
    bool more = true;
    for (int set = 0; status == SN_OK && more && set < 64; set++) {
        char joints_key[24], weights_key[24];
        sn_gltf_numbers joints = {0}, weights = {0};
        snprintf(joints_key, sizeof joints_key, "JOINTS_%d", set);
        snprintf(weights_key, sizeof weights_key, "WEIGHTS_%d", set);
        status = read_attribute(g, attributes, (shape){joints_key, 4, count, JOINTS}, &joints, error);
        if (status == SN_OK) status = read_attribute(g, attributes, (shape){weights_key, 4, count, WEIGHTS}, &weights, error);
        more = joints.values != NULL && weights.values != NULL;
        if (status == SN_OK && more) status = mark_used(&s->joints, joints.values, weights.values, 4 * (size_t)count, error);
        free(joints.values);
        free(weights.values);
    }
    return status;
}

/* ---- faces --------------------------------------------------------------------------------------------------------------------------- */

/* The corners of triangle i: 3.7.2.1 of the specification. */
static void corners_of(size_t mode, size_t i, size_t out[3]) {
    size_t odd = i % 2;
    if (mode == TRIANGLES) out[0] = 3 * i, out[1] = 3 * i + 1, out[2] = 3 * i + 2;
    if (mode == STRIP) out[0] = i, out[1] = i + 1 + odd, out[2] = i + 2 - odd;
    if (mode == FAN) out[0] = i + 1, out[1] = i + 2, out[2] = 0;
}

/* indices: of the primitive's vertices, NULL = all of them in order. Strips turn around by triangles of two equal corners: dropped. */
static sn_status add_corners(surface *s, size_t mode, const double *indices, size_t count, sn_index vertices, sn_error *error) {
    size_t triangles = mode == TRIANGLES ? count / 3 : count >= 3 ? count - 2 : 0, first = s->vertex_count - (size_t)vertices;
    if (mode == TRIANGLES && count % 3 != 0)
        return sn_fail(error, SN_ERROR_INPUT, "a mesh of triangles has %zu corners, which is no multiple of 3", count);
    if (!sn_grow((void **)&s->corners, &s->corner_capacity, s->corner_count + 3 * triangles, sizeof *s->corners))
        return sn_fail_memory(error, "the faces");
    for (size_t i = 0; i < triangles; i++) {
        size_t at[3];
        corners_of(mode, i, at);
        for (int k = 0; k < 3; k++) {
            double index = indices != NULL ? indices[at[k]] : (double)at[k];
            if (!(index >= 0.0 && index < (double)vertices))
                return sn_fail(error, SN_ERROR_INPUT, "a face names vertex %.10g of %d", index, (int)vertices);
            s->corners[s->corner_count + (size_t)k] = (sn_index)(first + (size_t)index);
        }
        const sn_index *c = s->corners + s->corner_count;
        if (mode == TRIANGLES || (c[0] != c[1] && c[1] != c[2] && c[2] != c[0])) s->corner_count += 3;
    }
    return s->corner_count < SN_INDEX_MAX ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "the file has more faces than sinew can count");
}

static sn_status add_faces(sn_gltf *g, surface *s, const sn_json_value *primitive, size_t mode, sn_index vertices, sn_error *error) {
    sn_gltf_numbers indices;
    sn_status status = read_attribute(g, primitive, (shape){"indices", 1, -1, INDICES}, &indices, error);
    size_t count = indices.values != NULL ? (size_t)indices.count : (size_t)vertices;
    if (status == SN_OK) status = add_corners(s, mode, indices.values, count, vertices, error);
    free(indices.values);
    return status;
}

/* ---- meshes -------------------------------------------------------------------------------------------------------------------------- */

static sn_status add_vertices(sn_gltf *g, surface *s, const sn_json_value *primitive, sn_index *count, sn_error *error) {
    sn_json_value attributes = sn_json_member(primitive, "attributes");
    sn_gltf_numbers positions = {0};
    sn_status status = check_positions(g, primitive, &attributes, error);
    if (status == SN_OK) status = read_attribute(g, &attributes, (shape){"POSITION", 3, -1, PLACES}, &positions, error);
    *count = positions.count;
    if (status == SN_OK && *count > 0) status = add_morphs(g, primitive, s, &positions, error);
    if (status == SN_OK && *count > 0) status = add_positions(s, &positions, error);
    if (status == SN_OK && *count > 0) status = add_colours(g, s, &attributes, *count, error);
    if (status == SN_OK && *count > 0) status = add_joints(g, s, &attributes, *count, error);
    free(positions.values);
    return status;
}

static sn_status add_primitive(sn_gltf *g, surface *s, const sn_json_value *primitive, sn_error *error) {
    sn_json_value mode_value = sn_json_member(primitive, "mode");
    size_t mode = TRIANGLES;
    sn_index count = 0;
    sn_status status = sn_gltf_get_whole(&mode_value, FAN, &mode, error);
    if (status != SN_OK || mode < TRIANGLES) return status; /* points and lines */
    status = add_vertices(g, s, primitive, &count, error);
    return status == SN_OK && count > 0 ? add_faces(g, s, primitive, mode, count, error) : status;
}

static sn_status add_primitives(sn_gltf *g, surface *s, const sn_json_value *mesh, sn_error *error) {
    sn_json_value primitives = sn_json_member(mesh, "primitives");
    sn_index count = 0;
    sn_status status = sn_gltf_count(&primitives, &count, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value primitive = sn_json_element(&primitives, i);
        status = add_primitive(g, s, &primitive, error);
    }
    return status;
}

/* The node's weights go before the mesh's. */
static sn_status read_surface(sn_gltf *g, const sn_json_value *node, const sn_json_value *mesh, surface *s, sn_error *error) {
    sn_json_value own = sn_json_member(node, "weights"), common = sn_json_member(mesh, "weights");
    const sn_json_value *weights = sn_json_has(&own) ? &own : &common;
    double *numbers = NULL;
    sn_status status = sn_json_has(weights) ? sn_json_get_numbers(weights, 1, -1, &s->weight_count, &numbers, error) : SN_OK;
    s->weights = numbers;
    if (status == SN_OK) status = add_primitives(g, s, mesh, error);
    s->weights = NULL;
    free(numbers);
    return status;
}

/* ---- instances ----------------------------------------------------------------------------------------------------------------------- */

typedef struct instances {
    sn_gltf_numbers translations, rotations, scales; /* no values: none */
    sn_index count;                                  /* SN_NONE = the node has none: it is there once */
} instances;

static void free_instances(instances *n) {
    free(n->translations.values);
    free(n->rotations.values);
    free(n->scales.values);
}

/* One of the three; they have equally many rows. */
static sn_status read_moves(sn_gltf *g, const sn_json_value *attributes, shape wanted, instances *n, sn_gltf_numbers *out,
                            sn_error *error) {
    wanted.count = n->count;
    sn_status status = read_attribute(g, attributes, wanted, out, error);
    if (status == SN_OK && out->values != NULL) n->count = out->count;
    return status;
}

static sn_status read_instances(sn_gltf *g, const sn_json_value *node, instances *n, sn_error *error) {
    *n = (instances){.count = SN_NONE};
    if (!sn_gltf_has_extension(node, INSTANCING)) return SN_OK;
    sn_json_value extensions = sn_json_member(node, "extensions"), extension = sn_json_member(&extensions, INSTANCING);
    sn_json_value attributes = sn_json_member(&extension, "attributes"), skin = sn_json_member(node, "skin");
    sn_status status = read_moves(g, &attributes, (shape){"TRANSLATION", 3, 0, PLACES}, n, &n->translations, error);
    if (status == SN_OK) status = read_moves(g, &attributes, (shape){"ROTATION", 4, 0, PLACES}, n, &n->rotations, error);
    if (status == SN_OK) status = read_moves(g, &attributes, (shape){"SCALE", 3, 0, PLACES}, n, &n->scales, error);
    if (status == SN_OK && n->count < 0)
        status =
            sn_json_complain(&extension, error, "has neither TRANSLATION nor ROTATION nor SCALE: how many instances there are is not told");
    if (status == SN_OK && sn_json_has(&skin))
        status = sn_json_complain(&extension, error, "is not read where the node has a skin too; export the instances as nodes");
    return status;
}

static sn_gltf_transform instance_transform(const instances *n, sn_index i) {
    static const double none[3] = {0, 0, 0}, upright[4] = {0, 0, 0, 1}, one[3] = {1, 1, 1};
    const double *t = n->translations.values, *r = n->rotations.values, *s = n->scales.values;
    size_t row = (size_t)i;
    return sn_gltf_compose(t != NULL ? t + 3 * row : none, r != NULL ? r + 4 * row : upright, s != NULL ? s + 3 * row : one);
}

/* ---- parts --------------------------------------------------------------------------------------------------------------------------- */

/* Who takes the parts. */
typedef struct taker {
    sn_gltf_sink sink;
    void *context;
} taker;

static double determinant(const sn_gltf_transform *t) {
    const double(*m)[4] = t->m;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* A copy of the surface, moved; what a mirroring would turn inside out is turned back. Adding zero makes -0 equal 0. */
static sn_status tell_part(const taker *to, const surface *s, const sn_gltf_transform *t, sn_gltf_part *part, sn_error *error) {
    part->positions = SN_NEW(double, 3 * s->vertex_count);
    part->corners = SN_NEW(sn_index, s->corner_count);
    part->colours = s->colours;
    part->vertex_count = (sn_index)s->vertex_count;
    part->corner_count = (sn_index)s->corner_count;
    bool enough = part->positions != NULL && part->corners != NULL, mirrored = determinant(t) < 0.0;
    for (size_t i = 0; enough && i < s->vertex_count; i++)
        for (size_t k = 0; k < 3; k++) {
            const double *p = s->positions + 3 * i;
            part->positions[3 * i + k] = t->m[k][0] * p[0] + t->m[k][1] * p[1] + t->m[k][2] * p[2] + t->m[k][3] + 0.0;
        }
    for (size_t i = 0; enough && i < s->corner_count; i++) part->corners[i] = s->corners[mirrored ? i - i % 3 + 2 - i % 3 : i];
    sn_status status = enough ? to->sink(to->context, part, error) : sn_fail_memory(error, "the vertices");
    free(part->positions);
    free(part->corners);
    return status;
}

/* Where the node has its mesh; a skin, and not the node, where it has one. */
static sn_status place(sn_gltf *g, sn_index index, const surface *s, const char *name, sn_gltf_transform *out, sn_error *error) {
    bool posed = false;
    *out = sn_gltf_world(g, index);
    if (g->node[index].skin == SN_NONE) return SN_OK;
    sn_status status = sn_gltf_place_skin(g, g->node[index].skin, &s->joints, out, &posed, error);
    if (status == SN_OK && posed)
        sn_log(SN_LOG_WARNING,
               "the joints of '%.100s' are not as its skin was bound: the mesh is as bound, where its uppermost joint has it", name);
    return status;
}

static sn_status tell_instances(sn_gltf *g, const taker *to, const surface *s, const instances *n, sn_gltf_part *part, sn_error *error) {
    sn_gltf_transform world;
    sn_status status = place(g, part->node, s, *part->node_name != '\0' ? part->node_name : part->mesh_name, &world, error);
    part->instance = SN_NONE;
    if (status == SN_OK && n->count == SN_NONE) return tell_part(to, s, &world, part, error);
    for (sn_index i = 0; i < n->count && status == SN_OK; i++) {
        sn_gltf_transform own = instance_transform(n, i), t = sn_gltf_multiply(&world, &own);
        part->instance = i;
        status = tell_part(to, s, &t, part, error);
    }
    return status;
}

static sn_status get_name(const sn_json_value *object, char **out, sn_error *error) {
    sn_json_value value = sn_json_member(object, "name");
    sn_status status = sn_json_get_text(&value, out, error);
    if (status == SN_OK && *out == NULL && (*out = sn_strdup("")) == NULL) status = sn_fail_memory(error, "a name");
    return status;
}

static sn_status tell_node(sn_gltf *g, const taker *to, sn_index index, sn_error *error) {
    sn_json_value node = sn_json_element(&g->nodes, index), mesh = sn_json_element(&g->meshes, g->node[index].mesh);
    char *node_name = NULL, *mesh_name = NULL;
    surface s = {0};
    instances n = {.count = SN_NONE};
    sn_status status = get_name(&node, &node_name, error);
    if (status == SN_OK) status = get_name(&mesh, &mesh_name, error);
    if (status == SN_OK) status = read_surface(g, &node, &mesh, &s, error);
    if (status == SN_OK) status = read_instances(g, &node, &n, error);
    sn_gltf_part part = {.node_name = node_name, .mesh_name = mesh_name, .node = index, .mesh = g->node[index].mesh};
    if (status == SN_OK && s.corner_count > 0) status = tell_instances(g, to, &s, &n, &part, error);
    free_surface(&s);
    free_instances(&n);
    free(node_name);
    free(mesh_name);
    return status;
}

/* ---- the scene ----------------------------------------------------------------------------------------------------------------------- */

typedef struct stack {
    sn_index *items;
    size_t count, capacity;
} stack;

/* In their order: the last goes on first. */
static sn_status push(stack *s, const sn_index *items, sn_index count, sn_error *error) {
    if (!sn_grow((void **)&s->items, &s->capacity, s->count + (size_t)count, sizeof *s->items)) return sn_fail_memory(error, "the nodes");
    for (sn_index i = count - 1; i >= 0; i--) s->items[s->count++] = items[i];
    return SN_OK;
}

static sn_status push_list(sn_gltf *g, stack *s, const sn_json_value *list, sn_error *error) {
    sn_index *items, count;
    sn_status status = sn_gltf_get_indices(list, g->node_count, &count, &items, error);
    if (status == SN_OK) status = push(s, items, count, error);
    free(items);
    return status;
}

/* The nodes of the scene to show, else of the first; all roots where there are no scenes. */
static sn_status push_roots(sn_gltf *g, stack *s, sn_error *error) {
    sn_json_value scenes = sn_json_member(&g->top, "scenes"), chosen = sn_json_member(&g->top, "scene");
    sn_index count, which = 0;
    sn_status status = sn_gltf_count(&scenes, &count, error);
    if (status == SN_OK) status = sn_gltf_get_index(&chosen, count, &which, error);
    if (status != SN_OK) return status;
    if (count > 0) {
        sn_json_value scene = sn_json_element(&scenes, which), nodes = sn_json_member(&scene, "nodes");
        return push_list(g, s, &nodes, error);
    }
    for (sn_index i = g->node_count - 1; i >= 0 && status == SN_OK; i--)
        if (g->node[i].parent == SN_NONE) status = push(s, &i, 1, error);
    return status;
}

static sn_status walk(sn_gltf *g, const taker *to, stack *s, sn_error *error) {
    sn_status status = push_roots(g, s, error);
    while (s->count > 0 && status == SN_OK) {
        sn_index index = s->items[--s->count];
        if (g->node[index].visited) return sn_fail(error, SN_ERROR_INPUT, "nodes[%d]: is in the scene twice", (int)index);
        g->node[index].visited = true;
        sn_json_value node = sn_json_element(&g->nodes, index), children = sn_json_member(&node, "children");
        if (g->node[index].mesh != SN_NONE) status = tell_node(g, to, index, error);
        if (status == SN_OK) status = push_list(g, s, &children, error);
    }
    return status;
}

sn_status sn_gltf_read(const sn_gltf_source *source, sn_gltf_sink sink, void *context, sn_error *error) {
    sn_gltf g;
    stack s = {0};
    taker to = {sink, context};
    sn_status status = sn_gltf_open(&g, source, error);
    if (status == SN_OK) status = sn_gltf_read_nodes(&g, error);
    if (status == SN_OK) status = walk(&g, &to, &s, error);
    free(s.items);
    sn_gltf_close(&g);
    return status;
}
