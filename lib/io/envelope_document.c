/*
 * envelope_document.c -- the envelope document: a mesh, names of bones, and which of them carry each vertex.
 */
#include "document.h"

#include <stdlib.h>
#include <string.h>

#define FORMAT "sinew-envelope"
enum { NEWEST_VERSION = 1 };

/* ---- reading ------------------------------------------------------------------------------------------------------------------ */

static sn_status parse_bones(const sn_json_value *list, sn_envelope *out, sn_error *error) {
    sn_index count;
    sn_status status = sn_json_require(list, "the names of the bones", error);
    if (status == SN_OK) status = sn_json_expect_list(list, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if (count == 0) return sn_json_complain(list, error, "an envelope is bound to at least one bone");
    if ((out->bones = SN_NEW(char *, count)) == NULL) return sn_fail_memory(error, "the bones of an envelope");
    out->bone_count = count;
    for (sn_index b = 0; b < count && status == SN_OK; b++) {
        sn_json_value name = sn_json_element(list, b);
        status = sn_json_require(&name, "the name of a bone", error);
        if (status == SN_OK) status = sn_json_get_text(&name, &out->bones[b], error);
    }
    return status;
}

/* How many bones carry each vertex, and which with what weights, one vertex behind the other. */
typedef struct influence_lists {
    sn_index *counts, *bones;
    double *weights;
    sn_index total;
} influence_lists;

static void deal(const influence_lists *lists, sn_envelope *out) {
    sn_index next = 0;
    for (sn_index v = 0; v < out->mesh.vertex_count; v++) {
        sn_influence *influence = &out->influences[v];
        influence->count = lists->counts[v];
        for (sn_index k = 0; k < influence->count; k++, next++) {
            influence->bones[k] = lists->bones[next];
            influence->weights[k] = lists->weights[next];
        }
    }
}

static sn_status parse_lists(const sn_json_value *value, sn_envelope *out, influence_lists *lists, sn_error *error) {
    sn_json_value counts = sn_json_member(value, "counts"), bones = sn_json_member(value, "bones"),
                  weights = sn_json_member(value, "weights");
    sn_index vertices = out->mesh.vertex_count;
    sn_status status = sn_json_get_indices(&counts, (sn_index_rule){1, vertices, 1, SN_INFLUENCE_LIMIT}, NULL, &lists->counts, error);
    if (status != SN_OK) return status;
    int64_t total = 0;
    for (sn_index v = 0; v < vertices; v++) total += lists->counts[v];
    if (total > SN_INDEX_MAX) return sn_json_complain(value, error, "there are more weights than sinew can count");
    lists->total = (sn_index)total;
    const sn_index_rule rule = {1, lists->total, 0, out->bone_count - 1};
    status = sn_json_get_indices(&bones, rule, NULL, &lists->bones, error);
    return status == SN_OK ? sn_json_get_numbers(&weights, 1, lists->total, NULL, &lists->weights, error) : status;
}

static sn_status parse_influences(const sn_json_value *value, sn_envelope *out, sn_error *error) {
    static const char *const known[] = {"counts", "bones", "weights", NULL};
    influence_lists lists = {0};
    sn_status status = sn_json_require(value, "the weights of the vertices", error);
    if (status == SN_OK) status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = parse_lists(value, out, &lists, error);
    if (status == SN_OK && (out->influences = SN_NEW(sn_influence, out->mesh.vertex_count)) == NULL)
        status = sn_fail_memory(error, "the weights of an envelope");
    if (status == SN_OK) {
        deal(&lists, out);
        status = sn_json_check_members(value, known, error);
    }
    free(lists.counts);
    free(lists.bones);
    free(lists.weights);
    return status;
}

static sn_status parse_head(const sn_json_value *top, sn_envelope *out, double *meters_per_unit, sn_error *error) {
    sn_json_value name = sn_json_member(top, "name"), unit = sn_json_member(top, "metersPerUnit"), method = sn_json_member(top, "method"),
                  reach = sn_json_member(top, "reach");
    int choice = SN_ENVELOPE_BLEND;
    sn_status status = sn_json_expect_format(top, FORMAT, NEWEST_VERSION, error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, meters_per_unit, error);
    if (status == SN_OK) status = sn_json_get_choice(&method, sn_envelope_method_names, &choice, error);
    if (status == SN_OK) status = sn_json_get_number(&reach, SN_JSON_POSITIVE, INFINITY, &out->reach, error);
    out->method = (sn_envelope_method)choice;
    out->reach *= *meters_per_unit;
    return status;
}

static sn_status parse_document(const sn_json_value *top, sn_envelope *out, sn_error *error) {
    static const char *const known[] = {"format", "version", "name",       "metersPerUnit", "method", "reach",
                                        "mesh",   "bones",   "influences", "history",       NULL};
    sn_json_value mesh = sn_json_member(top, "mesh"), bones = sn_json_member(top, "bones"), influences = sn_json_member(top, "influences");
    double meters_per_unit = 1.0;
    sn_status status = parse_head(top, out, &meters_per_unit, error);
    if (status == SN_OK) status = sn_json_require(&mesh, "the envelope's mesh", error);
    if (status == SN_OK) status = sn_parse_mesh(&mesh, &out->mesh, error);
    if (status == SN_OK) status = parse_bones(&bones, out, error);
    if (status == SN_OK) status = parse_influences(&influences, out, error);
    if (status == SN_OK) status = sn_json_check_members(top, known, error);
    if (status != SN_OK) return status;
    if (meters_per_unit != 1.0) sn_mesh_convert(&out->mesh, meters_per_unit, false);
    status = sn_envelope_validate(out, error);
    if (status != SN_OK) sn_error_set_file(error, sn_json_name(top->tree));
    return status;
}

sn_status sn_envelope_parse(const sn_blob *blob, sn_envelope *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    *out = (sn_envelope){.reach = SN_ENVELOPE_REACH};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status == SN_OK) {
        sn_json_value top = sn_json_top(tree);
        status = parse_document(&top, out, error);
    }
    if (status != SN_OK) sn_envelope_free(out);
    sn_json_tree_free(tree);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------------------ */

static sn_status flatten(const sn_envelope *envelope, influence_lists *lists, sn_error *error) {
    sn_index vertices = envelope->mesh.vertex_count;
    lists->counts = SN_NEW(sn_index, vertices);
    lists->bones = sn_alloc((size_t)vertices * SN_INFLUENCE_LIMIT, sizeof *lists->bones);
    lists->weights = sn_alloc((size_t)vertices * SN_INFLUENCE_LIMIT, sizeof *lists->weights);
    if (lists->counts == NULL || lists->bones == NULL || lists->weights == NULL) return sn_fail_memory(error, "the weights of an envelope");
    for (sn_index v = 0; v < vertices; v++) {
        const sn_influence *influence = &envelope->influences[v];
        lists->counts[v] = influence->count;
        for (sn_index k = 0; k < influence->count; k++, lists->total++) {
            lists->bones[lists->total] = influence->bones[k];
            lists->weights[lists->total] = influence->weights[k];
        }
    }
    return SN_OK;
}

static void write_influences(const influence_lists *lists, sn_index vertex_count, sn_json *json) {
    sn_json_object(json, "influences");
    sn_json_indices(json, "counts", lists->counts, (size_t)vertex_count);
    sn_json_indices(json, "bones", lists->bones, (size_t)lists->total);
    sn_json_numbers(json, "weights", lists->weights, (size_t)lists->total);
    sn_json_close(json);
}

static void write_members(const sn_envelope *envelope, const influence_lists *lists, sn_json *json) {
    sn_json_text(json, "format", FORMAT);
    sn_json_integer(json, "version", NEWEST_VERSION);
    if (envelope->name != NULL) sn_json_text(json, "name", envelope->name);
    sn_json_number(json, "metersPerUnit", 1.0);
    sn_json_text(json, "method", sn_envelope_method_names[envelope->method]);
    sn_json_number(json, "reach", envelope->reach);
    sn_mesh_document_write(&envelope->mesh, json);
    sn_json_array(json, "bones");
    for (sn_index b = 0; b < envelope->bone_count; b++) sn_json_text(json, NULL, envelope->bones[b]);
    sn_json_close(json);
    write_influences(lists, envelope->mesh.vertex_count, json);
}

sn_status sn_envelope_write(const sn_envelope *envelope, const sn_history_entry *entry, const sn_blob *history_from, sn_output *output,
                            sn_error *error) {
    sn_json_tree *before = NULL;
    influence_lists lists = {0};
    sn_status status = sn_envelope_validate(envelope, error);
    if (status == SN_OK && history_from != NULL) status = sn_json_parse(history_from, &before, error);
    if (status == SN_OK) status = flatten(envelope, &lists, error);
    sn_json *json = status == SN_OK ? sn_json_begin(output, true) : NULL;
    if (status == SN_OK && json == NULL) status = sn_fail_memory(error, "an envelope document");
    if (status == SN_OK) {
        sn_json_object(json, NULL);
        write_members(envelope, &lists, json);
        sn_history_write(before, entry, json);
        status = sn_json_end(json, error);
    }
    free(lists.counts);
    free(lists.bones);
    free(lists.weights);
    sn_json_tree_free(before);
    return status;
}
