/* gltf.c -- a file of glTF 2 is opened: its JSON, the chunks of a GLB, and what its extensions ask for (gltf.h). */
#include "gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bytes.h"

enum { LIST_LIMIT = 1 << 24, CHUNK_JSON = 0x4e4f534a, CHUNK_BINARY = 0x004e4942 };

/* ---- numbers of the JSON ------------------------------------------------------------------------------------------------------------- */

sn_status sn_gltf_get_whole(const sn_json_value *value, double most, size_t *out, sn_error *error) {
    double number = -1.0;
    sn_status status = sn_json_get_number(value, 0.0, most, &number, error);
    if (status != SN_OK || number < 0.0) return status;
    if (floor(number) != number) return sn_json_mismatch(value, error, "a whole number");
    *out = (size_t)number;
    return SN_OK;
}

sn_status sn_gltf_get_index(const sn_json_value *value, sn_index count, sn_index *out, sn_error *error) {
    size_t number = 0;
    if (!sn_json_has(value)) return SN_OK;
    if (count == 0) return sn_json_complain(value, error, "names what is not there");
    sn_status status = sn_gltf_get_whole(value, (double)count - 1.0, &number, error);
    if (status == SN_OK) *out = (sn_index)number;
    return status;
}

sn_status sn_gltf_get_indices(const sn_json_value *value, sn_index count, sn_index *out_count, sn_index **out, sn_error *error) {
    double *numbers = NULL;
    *out = NULL;
    *out_count = 0;
    if (!sn_json_has(value)) return SN_OK;
    sn_status status = sn_json_get_numbers(value, 1, -1, out_count, &numbers, error);
    if (status == SN_OK && (*out = SN_NEW(sn_index, *out_count)) == NULL) status = sn_fail_memory(error, "a list");
    for (sn_index i = 0; i < *out_count && status == SN_OK; i++) {
        if (!(numbers[i] >= 0.0 && numbers[i] < (double)count) || floor(numbers[i]) != numbers[i])
            status = sn_json_complain(value, error, "names %.10g of %d", numbers[i], (int)count);
        else
            (*out)[i] = (sn_index)numbers[i];
    }
    free(numbers);
    if (status == SN_OK) return SN_OK;
    free(*out);
    *out = NULL;
    return status;
}

sn_status sn_gltf_count(const sn_json_value *list, sn_index *out, sn_error *error) {
    *out = 0;
    return sn_json_has(list) ? sn_json_expect_list(list, LIST_LIMIT, out, error) : SN_OK;
}

bool sn_gltf_has_extension(const sn_json_value *object, const char *name) {
    sn_json_value extensions = sn_json_member(object, "extensions"), extension = sn_json_member(&extensions, name);
    return sn_json_has(&extension);
}

/* ---- extensions ---------------------------------------------------------------------------------------------------------------------- */

/* Those that leave surfaces alone, or that are known here; a '*' at the end stands for anything. */
static const char *const harmless[] = {"KHR_mesh_quantization",
                                       "EXT_mesh_gpu_instancing",
                                       "KHR_materials_*",
                                       "EXT_materials_*",
                                       "ADOBE_materials_*",
                                       "FB_material_*",
                                       "MSFT_packing_*",
                                       "KHR_texture_*",
                                       "EXT_texture_*",
                                       "MSFT_texture_dds",
                                       "KHR_lights_*",
                                       "EXT_lights_*",
                                       "KHR_techniques_webgl",
                                       "KHR_xmp*",
                                       "AGI_stk_metadata",
                                       "EXT_structural_metadata",
                                       "EXT_mesh_features",
                                       "EXT_mesh_manifold",
                                       "EXT_feature_metadata",
                                       "EXT_instance_features",
                                       "KHR_audio*",
                                       "KHR_animation_pointer",
                                       NULL};

/* Whose data may have a copy that is not packed; if not, the accessor that has none names them. */
static const char *const packed[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", NULL};

static bool is_listed(const char *name, const char *const *list) {
    for (; *list != NULL; list++) {
        size_t length = strlen(*list);
        bool any = (*list)[length - 1] == '*';
        if (any ? strncmp(name, *list, length - 1) == 0 : strcmp(name, *list) == 0) return true;
    }
    return false;
}

static sn_status refuse_extension(const char *name, sn_error *error) {
    if (is_listed(name, packed))
        return sn_fail(error, SN_ERROR_INPUT,
                       "requires the extension %s, which packs its meshes and is not read; export it without compression", name);
    return sn_fail(
        error, SN_ERROR_INPUT,
        "requires the extension %.100s, which is not known, so that its geometry may be another; export it without, or as OBJ or PLY",
        name);
}

static sn_status check_required(const sn_json_value *top, sn_error *error) {
    sn_json_value list = sn_json_member(top, "extensionsRequired");
    sn_index count = 0;
    sn_status status = sn_gltf_count(&list, &count, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value entry = sn_json_element(&list, i);
        char *name = NULL;
        status = sn_json_get_text(&entry, &name, error);
        if (status == SN_OK && name != NULL && !is_listed(name, harmless)) status = refuse_extension(name, error);
        free(name);
    }
    return status;
}

/* Those that a file may use without requiring them and that would show another surface. */
static void warn_used(const sn_json_value *top) {
    static const char *const names[] = {"CESIUM_RTC", "KHR_node_visibility", "EXT_node_visibility", "KHR_displacement_mapping_pbr", NULL};
    sn_json_value list = sn_json_member(top, "extensionsUsed");
    sn_index count = 0;
    if (sn_gltf_count(&list, &count, NULL) != SN_OK) return;
    for (sn_index i = 0; i < count; i++) {
        sn_json_value entry = sn_json_element(&list, i);
        char *name = NULL;
        if (sn_json_get_text(&entry, &name, NULL) == SN_OK && name != NULL && is_listed(name, names))
            sn_log(SN_LOG_WARNING, "the extension %s, which the file uses, is not read: it may move or hide what is taken as it stands",
                   name);
        free(name);
    }
}

/* ---- chunks -------------------------------------------------------------------------------------------------------------------------- */

static bool is_binary(const sn_blob *file) { return file->size >= 4 && memcmp(file->data, "glTF", 4) == 0; }

static sn_status cut_short(sn_error *error) {
    return sn_fail(error, SN_ERROR_INPUT, "begins like a glTF file but does not go on like one; it is damaged or cut short");
}

/* The JSON of a GLB, and its second chunk. */
static sn_status split(const sn_blob *file, sn_blob *json, sn_blob *binary, sn_error *error) {
    const unsigned char *b = (const unsigned char *)file->data;
    *json = *file;
    if (!is_binary(file)) return SN_OK;
    if (file->size < 20) return cut_short(error);
    size_t size = sn_get_u32(b + 8), length = sn_get_u32(b + 12);
    if (sn_get_u32(b + 4) != 2)
        return sn_fail(error, SN_ERROR_INPUT, "is a GLB of version %lu, and 2 is read; export it again", (unsigned long)sn_get_u32(b + 4));
    if (size > file->size || size < 20 || length > size - 20 || sn_get_u32(b + 16) != CHUNK_JSON) return cut_short(error);
    *json = (sn_blob){file->name, file->data + 20, length};
    size_t next = 20 + length;
    if (size - next < 8) return SN_OK;
    size_t more = sn_get_u32(b + next);
    if (sn_get_u32(b + next + 4) != CHUNK_BINARY) return SN_OK; /* some extension's own */
    if (more > size - next - 8) return cut_short(error);
    *binary = (sn_blob){file->name, file->data + next + 8, more};
    return SN_OK;
}

/* ---- open ---------------------------------------------------------------------------------------------------------------------------- */

static sn_status open_lists(sn_gltf *g, sn_error *error) {
    g->accessors = sn_json_member(&g->top, "accessors");
    g->views = sn_json_member(&g->top, "bufferViews");
    g->buffers = sn_json_member(&g->top, "buffers");
    g->nodes = sn_json_member(&g->top, "nodes");
    g->meshes = sn_json_member(&g->top, "meshes");
    g->skins = sn_json_member(&g->top, "skins");
    sn_status status = sn_gltf_count(&g->buffers, &g->buffer_count, error);
    if (status == SN_OK) status = sn_gltf_count(&g->nodes, &g->node_count, error);
    if (status != SN_OK) return status;
    g->blobs = SN_NEW(sn_blob, g->buffer_count);
    g->available = SN_NEW(bool, g->buffer_count);
    return g->blobs != NULL && g->available != NULL ? SN_OK : sn_fail_memory(error, "the buffers");
}

/* A file may ask for a later minor version of which nothing is known. */
static sn_status check_version(const sn_json_value *top, sn_error *error) {
    sn_json_value asset = sn_json_member(top, "asset"), least = sn_json_member(&asset, "minVersion"),
                  own = sn_json_member(&asset, "version");
    bool asks = sn_json_has(&least);
    char *text = NULL;
    sn_status status = sn_json_get_text(asks ? &least : &own, &text, error);
    if (status == SN_OK && text != NULL && ((strncmp(text, "2.", 2) != 0 && strcmp(text, "2") != 0) || (asks && strcmp(text, "2.0") != 0)))
        status = sn_fail(error, SN_ERROR_INPUT, "is glTF of version %.20s, and 2.0 is read; export it as that", text);
    free(text);
    return status;
}

static sn_status parse(const sn_blob *file, sn_blob *binary, sn_json_tree **tree, sn_error *error) {
    sn_blob json;
    sn_status status = split(file, &json, binary, error);
    return status == SN_OK ? sn_json_parse(&json, tree, error) : status;
}

sn_status sn_gltf_open(sn_gltf *g, const sn_gltf_source *source, sn_error *error) {
    sn_blob binary = {0};
    *g = (sn_gltf){.source = source};
    sn_status status = parse(source->file, &binary, &g->tree, error);
    if (status != SN_OK) return status;
    g->binary = binary.data;
    g->binary_size = binary.size;
    g->top = sn_json_top(g->tree);
    status = check_version(&g->top, error);
    if (status == SN_OK) status = check_required(&g->top, error);
    if (status == SN_OK) warn_used(&g->top);
    return status == SN_OK ? open_lists(g, error) : status;
}

void sn_gltf_close(sn_gltf *g) {
    for (sn_index i = 0; i < g->buffer_count && g->blobs != NULL && g->available != NULL; i++)
        if (g->available[i]) sn_blob_free(&g->blobs[i]);
    free(g->blobs);
    free(g->available);
    free(g->node);
    sn_json_tree_free(g->tree);
    *g = (sn_gltf){0};
}

/* ---- what others ask before they read a file ----------------------------------------------------------------------------------------- */

bool sn_gltf_is_old(const sn_blob *file) {
    if (is_binary(file)) return file->size >= 8 && sn_get_u32((const unsigned char *)file->data + 4) == 1;
    sn_json_tree *tree = NULL;
    char *version = NULL;
    if (sn_json_parse(file, &tree, NULL) == SN_OK) {
        sn_json_value top = sn_json_top(tree), asset = sn_json_member(&top, "asset"), value = sn_json_member(&asset, "version");
        if (sn_json_get_text(&value, &version, NULL) != SN_OK) version = NULL;
    }
    bool old = version != NULL && (strncmp(version, "1.", 2) == 0 || strcmp(version, "1") == 0);
    free(version);
    sn_json_tree_free(tree);
    return old;
}

static bool lacks_matrices(const sn_json_value *top) {
    sn_json_value skins = sn_json_member(top, "skins");
    sn_index count = 0;
    if (sn_gltf_count(&skins, &count, NULL) != SN_OK) return false;
    for (sn_index i = 0; i < count; i++) {
        sn_json_value skin = sn_json_element(&skins, i), matrices = sn_json_member(&skin, "inverseBindMatrices");
        if (!sn_json_has(&matrices)) return true;
    }
    return false;
}

sn_status sn_gltf_check(const sn_blob *file, bool *unbound, sn_error *error) {
    sn_json_tree *tree = NULL;
    sn_blob binary = {0};
    *unbound = false;
    sn_status status = parse(file, &binary, &tree, error);
    if (status == SN_OK) {
        sn_json_value top = sn_json_top(tree);
        status = check_required(&top, error);
        *unbound = lacks_matrices(&top);
    }
    sn_json_tree_free(tree);
    return status;
}
