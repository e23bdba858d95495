/* document.c -- the muscle document: parse every section into a muscle, write it back with what is not ours untouched. */
#include "document.h"

#include <stdlib.h>
#include <string.h>

#define FORMAT "sinew-muscle"
enum { NEWEST_VERSION = 1 };

_Static_assert(sizeof(sn_vec3) == 3 * sizeof(double), "flat arrays of numbers are arrays of points");
_Static_assert(sizeof(sn_triangle) == 3 * sizeof(sn_index), "flat arrays of indices are arrays of triangles");

struct sn_document {
    sn_json_tree *tree; /* NULL = it was a bare mesh */
};

/* ---- paths ------------------------------------------------------------------------------------------------------------ */

char *sn_path_beside(const char *document, const char *uri) {
    const char *slash = document != NULL && *uri != '/' ? strrchr(document, '/') : NULL;
    size_t folder = slash != NULL ? (size_t)(slash - document) + 1 : 0, length = strlen(uri);
    char *path = sn_alloc(folder + length + 1, 1);
    if (path == NULL) return NULL;
    if (folder > 0) memcpy(path, document, folder);
    memcpy(path + folder, uri, length);
    return path;
}

/* Length of what two paths begin with alike, whole folders of it. */
static size_t shared_folders(const char *a, const char *b) {
    size_t shared = 0;
    for (size_t i = 0; a[i] != '\0' && a[i] == b[i]; i++)
        if (a[i] == '/') shared = i + 1;
    return shared;
}

/* From the root; as it is where that cannot be found out. */
static char *absolute_path(const char *path) {
    char *absolute = realpath(path, NULL);
    return absolute != NULL ? absolute : sn_strdup(path);
}

char *sn_path_from(const char *document, const char *path) {
    const char *slash = document != NULL && *path != '/' && *document != '/' ? strrchr(document, '/') : NULL;
    if (slash == NULL) return *path != '/' && document != NULL && *document == '/' ? absolute_path(path) : sn_strdup(path);
    size_t shared = shared_folders(document, path), up = 0, length = strlen(path + shared);
    for (const char *c = document + shared; c <= slash; c++) up += *c == '/';
    if (strstr(document + shared, "../") != NULL) return absolute_path(path); /* what it is up there is not in the text */
    char *out = sn_alloc(3 * up + length + 1, 1);
    if (out == NULL) return NULL;
    for (size_t i = 0; i < up; i++) memcpy(out + 3 * i, "../", 3);
    memcpy(out + 3 * up, path + shared, length);
    return out;
}

char *sn_path_stem(const char *path) {
    if (path == NULL || *path == '<' || *path == '\0') return NULL;
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path, *dot = strrchr(name, '.');
    return sn_strndup(name, dot != NULL && dot > name ? (size_t)(dot - name) : strlen(name));
}

char *sn_muscle_call(const sn_muscle *rig, const char *path) {
    if (rig->name != NULL) return sn_strdup(rig->name);
    char *name = sn_path_stem(path), *middle = name != NULL ? strstr(name, ".muscle") : NULL;
    if (middle != NULL && strcmp(middle, ".muscle") == 0) *middle = '\0';
    return name;
}

/* ---- reading: mesh ---------------------------------------------------------------------------------------------------- */

static sn_status parse_attribute(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    sn_json_value components = sn_json_member(value, "components"), integer = sn_json_member(value, "integer"),
                  values = sn_json_member(value, "values");
    static const char *const known[] = {"components", "integer", "values", NULL};
    sn_index count = 1;
    bool is_integer = false;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_check_passed(value, known, error);
    if (status == SN_OK) status = sn_json_get_index(&components, 1, 64, &count, error);
    if (status == SN_OK) status = sn_json_get_bool(&integer, &is_integer, error);
    if (status == SN_OK) status = sn_json_require(&values, "an array of numbers", error);
    if (status == SN_OK && mesh->vertex_count > SN_INDEX_MAX / count)
        status = sn_json_complain(value, error, "the attribute has more numbers than sinew can count");
    if (status != SN_OK) return status;
    sn_attribute *attribute = sn_mesh_add_attribute(mesh, value->key, count);
    if (attribute == NULL) return sn_fail_memory(error, "a mesh attribute");
    attribute->integer = is_integer;
    return sn_json_get_fixed(&values, mesh->vertex_count * count, attribute->values, error);
}

static sn_status parse_attributes(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value attribute = {0};
    sn_status status = sn_json_expect_object(value, error);
    while (status == SN_OK && sn_json_next(value, &attribute)) {
        if (mesh->attribute_count >= SN_LIST_LIMIT)
            return sn_json_complain(value, error, "there are more than %d attributes", SN_LIST_LIMIT);
        status = parse_attribute(&attribute, mesh, error);
    }
    return status;
}

/* Names of OBJ groups, and the group of each triangle. */
static sn_status parse_groups(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    static const char *const known[] = {"names", "triangles", NULL};
    sn_json_value names = sn_json_member(value, "names"), triangles = sn_json_member(value, "triangles");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_check_passed(value, known, error);
    if (status == SN_OK) status = sn_json_expect_array(&names, error);
    if (status != SN_OK) return status;
    sn_index count = sn_json_length(&names);
    if (count == 0) return SN_OK;
    if ((mesh->group_names = SN_NEW(char *, count)) == NULL) return sn_fail_memory(error, "mesh groups");
    mesh->group_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value name = sn_json_element(&names, i);
        status = sn_json_get_text(&name, &mesh->group_names[i], error);
    }
    if (status != SN_OK) return status;
    return sn_json_get_indices(&triangles, (sn_index_rule){1, mesh->triangle_count, SN_NONE, count - 1}, NULL, &mesh->triangle_group,
                               error);
}

static sn_status parse_inline_mesh(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    sn_json_value vertices = sn_json_member(value, "vertices"), triangles = sn_json_member(value, "triangles"),
                  attributes = sn_json_member(value, "attributes"), groups = sn_json_member(value, "groups");
    sn_index count = 0;
    double *coordinates = NULL;
    sn_index *corners = NULL;
    sn_status status = sn_json_get_numbers(&vertices, 3, -1, &count, &coordinates, error);
    if (status != SN_OK) return status;
    mesh->positions = (sn_vec3 *)coordinates;
    mesh->vertex_count = count / 3;
    status = sn_json_get_indices(&triangles, (sn_index_rule){3, -1, 0, mesh->vertex_count - 1}, &count, &corners, error);
    if (status != SN_OK) return status;
    mesh->triangles = (sn_triangle *)corners;
    mesh->triangle_count = count / 3;
    if ((status = parse_attributes(&attributes, mesh, error)) != SN_OK) return status;
    return parse_groups(&groups, mesh, error);
}

/* The hash is written with "sha256:" before it or without. */
static sn_status check_hash(const sn_json_value *value, const sn_blob *blob, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    char *wanted = NULL, actual[SN_HASH_LENGTH];
    sn_status status = sn_json_get_text(value, &wanted, error);
    if (status != SN_OK) return status;
    sn_hash(blob->data, blob->size, actual);
    const char *digits = strchr(actual, ':') + 1;
    if (strcmp(wanted, actual) != 0 && strcmp(wanted, digits) != 0)
        status = sn_json_complain(value, error,
                                  "'%s' has changed since this document was written (its hash is %.12s...); build the document anew",
                                  blob->name, digits);
    free(wanted);
    return status;
}

static sn_status parse_mesh_reference(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    sn_json_value member = sn_json_member(value, "uri"), hash = sn_json_member(value, "sha256");
    char *uri = NULL, *path = NULL;
    sn_blob blob = {0};
    sn_status status = sn_json_get_text(&member, &uri, error);
    if (status == SN_OK && (path = sn_path_beside(sn_json_name(value->tree), uri)) == NULL) status = sn_fail_memory(error, "a path");
    if (status == SN_OK) status = sn_blob_read_named(path, &blob, error);
    if (status == SN_OK) status = check_hash(&hash, &blob, error);
    if (status == SN_OK) status = sn_mesh_parse(&blob, false, mesh, error);
    sn_blob_free(&blob);
    free(path);
    free(uri);
    return status;
}

sn_status sn_parse_mesh(const sn_json_value *value, sn_mesh *mesh, sn_error *error) {
    static const char *const of_file[] = {"uri", "sha256", NULL}, *const own[] = {"vertices", "triangles", "attributes", "groups", NULL};
    sn_json_value uri = sn_json_member(value, "uri");
    sn_status status = sn_json_expect_object(value, error);
    if (status != SN_OK) return status;
    status = sn_json_has(&uri) ? parse_mesh_reference(value, mesh, error) : parse_inline_mesh(value, mesh, error);
    return status == SN_OK ? sn_json_check_passed(value, sn_json_has(&uri) ? of_file : own, error) : status;
}

/* ---- reading: what the tools of the chain add ------------------------------------------------------------------------- */

static sn_status parse_roots(const sn_json_value *value, sn_index vertex_count, sn_roots *roots, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    static const char *const known[] = {"vertices", "rule", NULL};
    sn_json_value vertices = sn_json_member(value, "vertices"), rule = sn_json_member(value, "rule");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK)
        status = sn_json_get_indices(&vertices, (sn_index_rule){1, -1, 0, vertex_count - 1}, &roots->count, &roots->vertices, error);
    if (status == SN_OK) status = sn_json_get_text(&rule, &roots->rule, error);
    return status == SN_OK ? sn_json_check_passed(value, known, error) : status;
}

/* The vertices of one sample; each vertex hangs on one. */
static sn_status parse_sample_vertices(const sn_json_value *value, sn_index vertex_count, sn_index sample, sn_index *vertex_sample,
                                       sn_error *error) {
    sn_index count = 0, *vertices = NULL;
    sn_status status = sn_json_get_indices(value, (sn_index_rule){1, -1, 0, vertex_count - 1}, &count, &vertices, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_index *of_vertex = &vertex_sample[vertices[i]];
        if (*of_vertex != SN_NONE)
            status = sn_json_complain(value, error, "vertex %ld already hangs on sample %ld; a vertex has one sample", (long)vertices[i],
                                      (long)*of_vertex);
        *of_vertex = sample;
    }
    free(vertices);
    return status;
}

static sn_status parse_sample(const sn_json_value *value, sn_index vertex_count, sn_structure *out, sn_error *error) {
    static const char *const known[] = {"position", "axis", "parent", "branch", "vertices", NULL};
    sn_index i = value->element;
    sn_json_value position = sn_json_member(value, "position"), axis = sn_json_member(value, "axis"),
                  parent = sn_json_member(value, "parent"), branch = sn_json_member(value, "branch"),
                  vertices = sn_json_member(value, "vertices");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&position, "a point [x,y,z]", error);
    if (status == SN_OK) status = sn_json_get_vec3(&position, &out->positions[i], error);
    if (status == SN_OK) status = sn_json_require(&parent, "the index of a sample before this one, or -1", error);
    if (status == SN_OK) status = sn_json_get_index(&parent, SN_NONE, i - 1, &out->parents[i], error);
    if (status == SN_OK) status = sn_json_get_index(&branch, 0, SN_INDEX_MAX, &out->branches[i], error);
    if (status == SN_OK) status = sn_json_get_vec3(&axis, &out->axes[i], error);
    if (status == SN_OK) status = sn_json_check_passed(value, known, error);
    return status == SN_OK ? parse_sample_vertices(&vertices, vertex_count, i, out->vertex_sample, error) : status;
}

static sn_status alloc_structure(sn_index sample_count, sn_index vertex_count, sn_structure *out, sn_error *error) {
    out->sample_count = sample_count;
    out->positions = SN_NEW(sn_vec3, sample_count);
    out->parents = SN_NEW(sn_index, sample_count);
    out->branches = SN_NEW(sn_index, sample_count);
    out->axes = SN_NEW(sn_vec3, sample_count);
    out->vertex_sample = SN_NEW(sn_index, vertex_count);
    if (out->positions == NULL || out->parents == NULL || out->branches == NULL || out->axes == NULL || out->vertex_sample == NULL)
        return sn_fail_memory(error, "the structure");
    for (sn_index v = 0; v < vertex_count; v++) out->vertex_sample[v] = SN_NONE;
    return SN_OK;
}

static sn_status parse_structure(const sn_json_value *value, sn_index vertex_count, sn_structure *out, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    static const char *const known[] = {"samples", "spacing", NULL};
    sn_json_value samples = sn_json_member(value, "samples"), spacing = sn_json_member(value, "spacing");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_expect_array(&samples, error);
    if (status == SN_OK) status = sn_json_get_number(&spacing, 0.0, INFINITY, &out->spacing, error);
    sn_index count = status == SN_OK ? sn_json_length(&samples) : 0;
    if (count > 0) status = alloc_structure(count, vertex_count, out, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value sample = sn_json_element(&samples, i);
        status = parse_sample(&sample, vertex_count, out, error);
    }
    return status == SN_OK ? sn_json_check_passed(value, known, error) : status;
}

static sn_status parse_polyline(const sn_json_value *value, sn_polyline *out, sn_error *error) {
    static const char *const known[] = {"points", "length", "pennation", NULL};
    sn_json_value points = sn_json_member(value, "points");
    double *coordinates = NULL;
    sn_index count = 0;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_numbers(&points, 3, -1, &count, &coordinates, error);
    if (status != SN_OK) return status;
    out->points = (sn_vec3 *)coordinates;
    out->count = count / 3;
    sn_json_value length = sn_json_member(value, "length"), pennation = sn_json_member(value, "pennation");
    status = sn_json_check_passed(value, known, error);
    if (status == SN_OK) status = sn_json_get_number(&length, 0.0, INFINITY, &out->length, error);
    return status == SN_OK ? sn_json_get_number(&pennation, 0.0, SN_PI, &out->pennation, error) : status;
}

sn_status sn_parse_polylines(const sn_json_value *value, sn_fibers *out, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_status status = sn_json_expect_array(value, error);
    if (status != SN_OK) return status;
    sn_index count = sn_json_length(value);
    if ((out->polylines = SN_NEW(sn_polyline, count)) == NULL) return sn_fail_memory(error, "the fibres");
    out->polyline_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value polyline = sn_json_element(value, i);
        status = parse_polyline(&polyline, &out->polylines[i], error);
    }
    return status;
}

static sn_status parse_fibers(const sn_json_value *value, sn_index vertex_count, sn_fibers *out, sn_error *error) {
    static const char *const known[] = {"directions", "polylines", "field", "confidence", NULL};
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value directions = sn_json_member(value, "directions"), polylines = sn_json_member(value, "polylines"),
                  field = sn_json_member(value, "field"), confidence = sn_json_member(value, "confidence");
    double *coordinates = NULL;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK && sn_json_has(&directions)) {
        if (vertex_count > SN_INDEX_MAX / 3) return sn_json_complain(&directions, error, "more numbers than sinew can count");
        status = sn_json_get_numbers(&directions, 3, 3 * vertex_count, NULL, &coordinates, error);
        out->directions = (sn_vec3 *)coordinates;
    }
    if (status == SN_OK) status = sn_json_get_text(&field, &out->field, error);
    if (status == SN_OK && sn_json_has(&confidence))
        status = sn_json_get_numbers(&confidence, 1, vertex_count, NULL, &out->confidence, error);
    if (status == SN_OK) status = sn_json_check_passed(value, known, error);
    return status == SN_OK ? sn_parse_polylines(&polylines, out, error) : status;
}

/* A word; absent = not known. */
static sn_status parse_end(const sn_json_value *value, sn_attachment_end *out, sn_error *error) {
    int choice = -1;
    sn_status status = sn_json_get_choice(value, sn_attachment_end_names + SN_END_ORIGIN, &choice, error);
    if (status == SN_OK && choice >= 0) *out = (sn_attachment_end)(SN_END_ORIGIN + choice);
    return status;
}

static sn_status parse_attachment(const sn_json_value *value, sn_index vertex_count, sn_attachment *out, sn_error *error) {
    static const char *const known[] = {"bone", "end", "vertices", "method", "distances", "reasons", "confidence", NULL};
    sn_json_value bone = sn_json_member(value, "bone"), end = sn_json_member(value, "end"), method = sn_json_member(value, "method"),
                  vertices = sn_json_member(value, "vertices"), distances = sn_json_member(value, "distances"),
                  reasons = sn_json_member(value, "reasons"), confidence = sn_json_member(value, "confidence");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&bone, "the name of a bone", error);
    if (status == SN_OK) status = sn_json_get_text(&bone, &out->bone, error);
    if (status == SN_OK) status = parse_end(&end, &out->end, error);
    if (status == SN_OK) status = sn_json_get_text(&method, &out->method, error);
    if (status == SN_OK)
        status = sn_json_get_indices(&vertices, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->count, &out->vertices, error);
    if (status == SN_OK && sn_json_has(&distances)) status = sn_json_get_numbers(&distances, 1, out->count, NULL, &out->distances, error);
    if (status == SN_OK && sn_json_has(&reasons))
        status = sn_json_get_indices(&reasons, (sn_index_rule){1, out->count, 1, SN_REASON_COUNT - 1}, NULL, &out->reasons, error);
    if (status == SN_OK && sn_json_has(&confidence))
        status = sn_json_get_numbers(&confidence, 1, out->count, NULL, &out->confidence, error);
    return status == SN_OK ? sn_json_check_passed(value, known, error) : status;
}

static sn_status parse_attachments(const sn_json_value *value, sn_muscle *muscle, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(value, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((muscle->attachments = SN_NEW(sn_attachment, count)) == NULL) return sn_fail_memory(error, "attachments");
    muscle->attachment_count = count;
    muscle->has_attachments = true;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value attachment = sn_json_element(value, i);
        status = parse_attachment(&attachment, muscle->mesh.vertex_count, &muscle->attachments[i], error);
    }
    return status;
}

/* A word; absent = NULL. */
static sn_status parse_fascia(const sn_json_value *value, char **out, sn_error *error) {
    static const char *const words[] = {"deep", "superficial", NULL};
    int choice = -1;
    sn_status status = sn_json_get_choice(value, words, &choice, error);
    if (status != SN_OK || choice < 0) return status;
    *out = sn_strdup(words[choice]);
    return *out != NULL ? SN_OK : sn_fail_memory(error, "externals");
}

static sn_status parse_external(const sn_json_value *value, sn_index vertex_count, sn_external *out, sn_error *error) {
    static const char *const known[] = {"target",    "fascia",           "vertices", "triangles", "barycentric",
                                        "distances", "minimumDistances", "weights",  NULL};
    sn_json_value target = sn_json_member(value, "target"), fascia = sn_json_member(value, "fascia"),
                  vertices = sn_json_member(value, "vertices"), triangles = sn_json_member(value, "triangles"),
                  barycentric = sn_json_member(value, "barycentric"), distances = sn_json_member(value, "distances"),
                  minimum = sn_json_member(value, "minimumDistances"), weights = sn_json_member(value, "weights");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&target, "the name of a muscle or an envelope", error);
    if (status == SN_OK) status = sn_json_get_text(&target, &out->target, error);
    if (status == SN_OK) status = parse_fascia(&fascia, &out->fascia, error);
    if (status == SN_OK)
        status = sn_json_get_indices(&vertices, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->count, &out->vertices, error);
    if (status == SN_OK && out->count > SN_INDEX_MAX / 3) return sn_json_complain(value, error, "more numbers than sinew can count");
    sn_index count = out->count;
    if (status == SN_OK) status = sn_json_get_indices(&triangles, (sn_index_rule){1, count, 0, SN_INDEX_MAX}, NULL, &out->triangles, error);
    if (status == SN_OK) status = sn_json_get_numbers(&barycentric, 3, 3 * count, NULL, &out->barycentric, error);
    if (status == SN_OK) status = sn_json_get_numbers(&distances, 1, count, NULL, &out->distances, error);
    if (status == SN_OK) status = sn_json_get_numbers(&minimum, 1, count, NULL, &out->minimum, error);
    if (status == SN_OK) status = sn_json_get_numbers(&weights, 3, 3 * count, NULL, &out->weights, error);
    return status == SN_OK ? sn_json_check_passed(value, known, error) : status;
}

static int compare_externals(const void *a, const void *b) {
    const sn_external *const *p = a, *const *q = b;
    int order = strcmp((*p)->target, (*q)->target);
    return order != 0 ? order : strcmp((*p)->fascia != NULL ? (*p)->fascia : "", (*q)->fascia != NULL ? (*q)->fascia : "");
}

/* One for each target and fascia: of two for one vertex it would be a toss which acts. */
static sn_status refuse_twins(const sn_json_value *value, const sn_muscle *muscle, sn_error *error) {
    sn_index count = muscle->external_count;
    const sn_external **sorted = sn_alloc((size_t)count, sizeof *sorted);
    if (sorted == NULL) return sn_fail_memory(error, "externals");
    for (sn_index i = 0; i < count; i++) sorted[i] = &muscle->externals[i];
    if (count > 1) qsort(sorted, (size_t)count, sizeof *sorted, compare_externals);
    sn_status status = SN_OK;
    for (sn_index i = 1; i < count && status == SN_OK; i++)
        if (compare_externals(&sorted[i - 1], &sorted[i]) == 0)
            status = sn_json_complain(value, error, "has the target \"%s\" twice; put its vertices in one list", sorted[i]->target);
    free(sorted);
    return status;
}

static sn_status parse_externals(const sn_json_value *value, sn_muscle *muscle, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(value, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((muscle->externals = SN_NEW(sn_external, count)) == NULL) return sn_fail_memory(error, "externals");
    muscle->external_count = count;
    muscle->has_externals = true;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value external = sn_json_element(value, i);
        status = parse_external(&external, muscle->mesh.vertex_count, &muscle->externals[i], error);
    }
    return status == SN_OK ? refuse_twins(value, muscle, error) : status;
}

/* ---- reading: the document -------------------------------------------------------------------------------------------- */

/* Every member of a muscle document. */
static const char *const members[] = {"format",    "version", "name",        "metersPerUnit", "space",   "mesh", "roots",
                                      "structure", "fibers",  "attachments", "externals",     "history", NULL};

static sn_status check_history(const sn_json_value *value, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_status status = sn_json_expect_array(value, error);
    for (sn_index i = 0; status == SN_OK && i < sn_json_length(value); i++) {
        sn_json_value entry = sn_json_element(value, i);
        status = sn_json_expect_object(&entry, error);
    }
    return status;
}

static sn_status parse_space(const sn_json_value *value, sn_space *out, sn_error *error) {
    static const char *const words[] = {"LPS", "RAS", NULL};
    int choice = -1;
    sn_status status = sn_json_get_choice(value, words, &choice, error);
    if (status == SN_OK && choice >= 0) *out = sn_space_from_name(words[choice]);
    return status;
}

static sn_status parse_sections(const sn_json_value *top, sn_muscle *out, sn_error *error) {
    sn_json_value name = sn_json_member(top, "name"), unit = sn_json_member(top, "metersPerUnit"), mesh = sn_json_member(top, "mesh"),
                  roots = sn_json_member(top, "roots"), structure = sn_json_member(top, "structure"),
                  fibers = sn_json_member(top, "fibers"), attachments = sn_json_member(top, "attachments"),
                  externals = sn_json_member(top, "externals"), history = sn_json_member(top, "history");
    sn_status status = sn_json_expect_format(top, FORMAT, NEWEST_VERSION, error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_require(&unit, "the metres per unit of the coordinates, such as 0.001", error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, &out->meters_per_unit, error);
    sn_json_value space = sn_json_member(top, "space");
    if (status == SN_OK) status = parse_space(&space, &out->space, error);
    if (status == SN_OK) status = sn_parse_mesh(&mesh, &out->mesh, error);
    if (status == SN_OK) status = parse_roots(&roots, out->mesh.vertex_count, &out->roots, error);
    if (status == SN_OK) status = parse_structure(&structure, out->mesh.vertex_count, &out->structure, error);
    if (status == SN_OK) status = parse_fibers(&fibers, out->mesh.vertex_count, &out->fibers, error);
    if (status == SN_OK) status = parse_attachments(&attachments, out, error);
    if (status == SN_OK) status = parse_externals(&externals, out, error);
    if (status == SN_OK) status = check_history(&history, error);
    return status == SN_OK ? sn_json_check_passed(top, members, error) : status;
}

static sn_status parse_document(const sn_blob *blob, sn_muscle *out, sn_document *document, sn_error *error) {
    sn_status status = sn_json_parse(blob, &document->tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(document->tree);
    status = parse_sections(&top, out, error);
    return status == SN_OK ? sn_muscle_validate(out, error) : status;
}

/* ---- reading: a bare mesh --------------------------------------------------------------------------------------------- */

/* A muscle is between a millimetre and some metres long: what is not has probably another unit. */
static void warn_of_size(const char *name, const sn_mesh *mesh, double meters_per_unit) {
    double meters = sn_box_diagonal(sn_mesh_box(mesh)) * meters_per_unit;
    if (!isfinite(meters) || meters == 0.0 || (meters >= 0.001 && meters <= 5.0)) return;
    sn_log(SN_LOG_WARNING, "%s: the mesh is %.3g m across where one unit is %g m; name its unit with --units m, cm or mm", name, meters,
           meters_per_unit);
}

/* The unit and the axis that were asked for, else those of the file, else metres and z. */
static void take_frame(sn_mesh_frame frame, const sn_read_options *options, sn_muscle *out) {
    bool up_y = options->up_given || frame.up == SN_UP_UNKNOWN ? options->up_y : frame.up == SN_UP_Y;
    sn_mesh_convert(&out->mesh, 1.0, up_y);
    out->meters_per_unit = options->meters_per_unit > 0.0 ? options->meters_per_unit : frame.meters_per_unit;
    if (!(out->meters_per_unit > 0.0)) out->meters_per_unit = 1.0;
    out->space = frame.space;
}

static sn_status parse_bare_mesh(const sn_blob *blob, const sn_read_options *options, sn_muscle *out, sn_error *error) {
    sn_mesh_frame frame;
    sn_status status = sn_mesh_parse_frame(blob, options->allow_nonfinite, &out->mesh, &frame, error);
    if (status == SN_OK && options->mesh != NULL) status = sn_mesh_select(&out->mesh, options->mesh, error);
    if (status != SN_OK) return status;
    take_frame(frame, options, out);
    bool named = options->mesh != NULL && out->mesh.group_count == 1 && *out->mesh.group_names[0] != '\0';
    out->name = named ? sn_strdup(out->mesh.group_names[0]) : sn_path_stem(blob->name);
    warn_of_size(blob->name, &out->mesh, out->meters_per_unit);
    return options->allow_nonfinite ? SN_OK : sn_muscle_validate(out, error);
}

/* A document says its unit, and z is up in it: what was asked for can only be the same. */
static sn_status check_asked(const sn_read_options *options, const sn_muscle *muscle, sn_error *error) {
    double unit = options->meters_per_unit, own = muscle->meters_per_unit;
    if (!options->asked) return SN_OK;
    if (unit > 0.0 && fabs(unit - own) > 1e-9 * own)
        return sn_fail(error, SN_ERROR_USAGE, "a muscle document says its unit, here %g m, not %g m; --units is for bare meshes", own,
                       unit);
    if (muscle->space != SN_SPACE_UNKNOWN && sn_space_told() != SN_SPACE_UNKNOWN && sn_space_told() != muscle->space)
        return sn_fail(error, SN_ERROR_USAGE, "a muscle document says its space, here %s, not %s; --space is for what is no document",
                       sn_space_name(muscle->space), sn_space_name(sn_space_told()));
    if (options->up_given && options->up_y) return sn_fail(error, SN_ERROR_USAGE, "a muscle document has z up; --up y is for bare meshes");
    return SN_OK;
}

sn_status sn_muscle_parse(const sn_blob *blob, const sn_read_options *options, sn_muscle *out, sn_document **document, sn_error *error) {
    static const sn_read_options defaults = {0};
    *out = (sn_muscle){0};
    *document = SN_NEW(sn_document, 1);
    if (*document == NULL) return sn_fail_memory(error, "a document");
    if (options == NULL) options = &defaults;
    bool bare = !sn_json_detect(blob) || sn_import_detect(blob) != NULL; /* glTF is JSON too */
    sn_status status = bare ? parse_bare_mesh(blob, options, out, error)
                       : options->mesh != NULL
                           ? sn_fail(error, SN_ERROR_USAGE, "a muscle document holds one mesh; --mesh is for bare meshes")
                           : parse_document(blob, out, *document, error);
    if (status == SN_OK && !bare) status = check_asked(options, out, error);
    if (out->space == SN_SPACE_UNKNOWN) out->space = sn_space_told();
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_muscle_free(out);
    sn_document_free(*document);
    *document = NULL;
    return status;
}

void sn_document_free(sn_document *document) {
    if (document == NULL) return;
    sn_json_tree_free(document->tree);
    free(document);
}

/* ---- writing: sections ------------------------------------------------------------------------------------------------ */

static void write_points(sn_json *json, const char *key, const sn_vec3 *points, sn_index count) {
    sn_json_numbers(json, key, points != NULL ? &points->x : NULL, 3 * (size_t)count);
}

static void write_groups(const sn_mesh *mesh, sn_json *json) {
    sn_json_object(json, "groups");
    sn_json_array(json, "names");
    for (sn_index i = 0; i < mesh->group_count; i++) sn_json_text(json, NULL, mesh->group_names[i]);
    sn_json_close(json);
    sn_json_indices(json, "triangles", mesh->triangle_group, (size_t)mesh->triangle_count);
    sn_json_close(json);
}

static void write_attributes(const sn_mesh *mesh, sn_json *json) {
    sn_json_object(json, "attributes");
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        const sn_attribute *attribute = &mesh->attributes[i];
        sn_json_object(json, attribute->name);
        sn_json_integer(json, "components", attribute->components);
        sn_json_bool(json, "integer", attribute->integer);
        sn_json_numbers(json, "values", attribute->values, (size_t)mesh->vertex_count * (size_t)attribute->components);
        sn_json_close(json);
    }
    sn_json_close(json);
}

void sn_mesh_document_write(const sn_mesh *mesh, sn_json *json) {
    sn_json_object(json, "mesh");
    write_points(json, "vertices", mesh->positions, mesh->vertex_count);
    sn_json_indices(json, "triangles", mesh->triangles != NULL ? mesh->triangles->v : NULL, 3 * (size_t)mesh->triangle_count);
    if (mesh->attribute_count > 0) write_attributes(mesh, json);
    if (mesh->group_count > 0) write_groups(mesh, json);
    sn_json_close(json);
}

static sn_status write_mesh(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    (void)error;
    sn_mesh_document_write(&muscle->mesh, json);
    return SN_OK;
}

static sn_status write_roots(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    (void)error;
    sn_json_object(json, "roots");
    sn_json_indices(json, "vertices", muscle->roots.vertices, (size_t)muscle->roots.count);
    if (muscle->roots.rule != NULL) sn_json_text(json, "rule", muscle->roots.rule);
    sn_json_close(json);
    return SN_OK;
}

/* The vertices of each sample, ascending: those of sample i are vertices[start[i]] to vertices[start[i + 1] - 1]. */
static void group_by_sample(const sn_structure *structure, sn_index vertex_count, sn_index *start, sn_index *vertices) {
    const sn_index *sample = structure->vertex_sample;
    for (sn_index v = 0; v < vertex_count; v++)
        if (sample[v] != SN_NONE) start[sample[v]]++;
    for (sn_index i = 0; i < structure->sample_count; i++) start[i + 1] += start[i]; /* start[i]: behind the last of sample i */
    for (sn_index v = vertex_count - 1; v >= 0; v--) /* from behind, so that start[i] ends as the first of sample i */
        if (sample[v] != SN_NONE) vertices[--start[sample[v]]] = v;
}

static void write_sample(const sn_structure *structure, sn_index i, const sn_index *vertices, sn_index count, sn_json *json) {
    sn_json_object_line(json, NULL);
    sn_json_vec3(json, "position", structure->positions[i]);
    sn_json_integer(json, "parent", structure->parents[i]);
    sn_json_integer(json, "branch", structure->branches[i]);
    sn_json_vec3(json, "axis", structure->axes[i]);
    sn_json_indices(json, "vertices", vertices, (size_t)count);
    sn_json_close(json);
}

static sn_status write_structure(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    const sn_structure *structure = &muscle->structure;
    sn_index vertex_count = muscle->mesh.vertex_count;
    sn_index *start = SN_NEW(sn_index, (size_t)structure->sample_count + 1), *vertices = SN_NEW(sn_index, vertex_count);
    sn_status status = SN_OK;
    if (start == NULL || vertices == NULL) {
        status = sn_fail_memory(error, "writing the structure");
    } else {
        group_by_sample(structure, vertex_count, start, vertices);
        sn_json_object(json, "structure");
        sn_json_array(json, "samples");
        for (sn_index i = 0; i < structure->sample_count; i++)
            write_sample(structure, i, vertices + start[i], start[i + 1] - start[i], json);
        sn_json_close(json);
        sn_json_number(json, "spacing", structure->spacing);
        sn_json_close(json);
    }
    free(start);
    free(vertices);
    return status;
}

static sn_status write_fibers(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    const sn_fibers *fibers = &muscle->fibers;
    (void)error;
    sn_json_object(json, "fibers");
    if (fibers->directions != NULL) write_points(json, "directions", fibers->directions, muscle->mesh.vertex_count);
    if (fibers->field != NULL) sn_json_text(json, "field", fibers->field);
    if (fibers->confidence != NULL) sn_json_numbers(json, "confidence", fibers->confidence, (size_t)muscle->mesh.vertex_count);
    if (fibers->polyline_count > 0) {
        sn_json_array(json, "polylines");
        for (sn_index i = 0; i < fibers->polyline_count; i++) {
            sn_json_object_line(json, NULL);
            write_points(json, "points", fibers->polylines[i].points, fibers->polylines[i].count);
            if (fibers->polylines[i].length > 0.0) {
                sn_json_number(json, "length", fibers->polylines[i].length);
                sn_json_number(json, "pennation", fibers->polylines[i].pennation);
            }
            sn_json_close(json);
        }
        sn_json_close(json);
    }
    sn_json_close(json);
    return SN_OK;
}

static sn_status write_attachments(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    (void)error;
    sn_json_array(json, "attachments");
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        const sn_attachment *attachment = &muscle->attachments[i];
        sn_json_object_line(json, NULL);
        sn_json_text(json, "bone", attachment->bone);
        if (attachment->end != SN_END_UNKNOWN) sn_json_text(json, "end", sn_attachment_end_names[attachment->end]);
        sn_json_indices(json, "vertices", attachment->vertices, (size_t)attachment->count);
        if (attachment->method != NULL) sn_json_text(json, "method", attachment->method);
        if (attachment->distances != NULL) sn_json_numbers(json, "distances", attachment->distances, (size_t)attachment->count);
        if (attachment->reasons != NULL) sn_json_indices(json, "reasons", attachment->reasons, (size_t)attachment->count);
        if (attachment->confidence != NULL) sn_json_numbers(json, "confidence", attachment->confidence, (size_t)attachment->count);
        sn_json_close(json);
    }
    sn_json_close(json);
    return SN_OK;
}

static sn_status write_externals(const sn_muscle *muscle, sn_json *json, sn_error *error) {
    (void)error;
    sn_json_array(json, "externals");
    for (sn_index i = 0; i < muscle->external_count; i++) {
        const sn_external *e = &muscle->externals[i];
        size_t count = (size_t)e->count;
        sn_json_object_line(json, NULL);
        sn_json_text(json, "target", e->target);
        if (e->fascia != NULL) sn_json_text(json, "fascia", e->fascia);
        sn_json_indices(json, "vertices", e->vertices, count);
        sn_json_indices(json, "triangles", e->triangles, count);
        sn_json_numbers(json, "barycentric", e->barycentric, 3 * count);
        sn_json_numbers(json, "distances", e->distances, count);
        sn_json_numbers(json, "minimumDistances", e->minimum, count);
        sn_json_numbers(json, "weights", e->weights, 3 * count);
        sn_json_close(json);
    }
    sn_json_close(json);
    return SN_OK;
}

/* ---- writing: the document -------------------------------------------------------------------------------------------- */

/* The sections in the order of the document, what writes each, and the sections that a change of it makes stale. */
static const struct section {
    unsigned bit;
    const char *key;
    sn_status (*write)(const sn_muscle *muscle, sn_json *json, sn_error *error);
    unsigned stale;
} sections[] = {
    {SN_SECTION_MESH, "mesh", write_mesh,
     SN_SECTION_ROOTS | SN_SECTION_STRUCTURE | SN_SECTION_FIBERS | SN_SECTION_ATTACHMENTS | SN_SECTION_EXTERNALS},
    {SN_SECTION_ROOTS, "roots", write_roots, SN_SECTION_STRUCTURE | SN_SECTION_FIBERS},
    {SN_SECTION_STRUCTURE, "structure", write_structure, SN_SECTION_FIBERS},
    {SN_SECTION_FIBERS, "fibers", write_fibers, 0},
    {SN_SECTION_ATTACHMENTS, "attachments", write_attachments, 0},
    {SN_SECTION_EXTERNALS, "externals", write_externals, 0},
};
enum { SECTION_COUNT = sizeof sections / sizeof *sections };

static bool is_known_member(const char *key) {
    for (size_t i = 0; members[i] != NULL; i++)
        if (strcmp(key, members[i]) == 0) return true;
    return false;
}

/* The document as it was read, or NULL. */
static const sn_json_tree *tree_of(const sn_document *document) { return document != NULL ? document->tree : NULL; }

static unsigned sections_in(const sn_json_tree *tree) {
    if (tree == NULL) return 0;
    unsigned found = 0;
    sn_json_value top = sn_json_top(tree);
    for (size_t i = 0; i < SECTION_COUNT; i++) {
        sn_json_value section = sn_json_member(&top, sections[i].key);
        if (sn_json_has(&section)) found |= sections[i].bit;
    }
    return found;
}

/* The sections that no longer hold after a change, each named in the log. */
static unsigned find_stale(unsigned there, unsigned changed) {
    unsigned stale = 0;
    for (size_t i = 0; i < SECTION_COUNT; i++) {
        unsigned fallen = changed & sections[i].bit ? sections[i].stale & there & ~changed & ~stale : 0;
        for (size_t k = 0; k < SECTION_COUNT; k++)
            if (fallen & sections[k].bit)
                sn_log(SN_LOG_WARNING, "the section \"%s\" is dropped: the new %s makes it stale", sections[k].key, sections[i].key);
        stale |= fallen;
    }
    return stale;
}

/* Those sections of muscle that will be written from it, for validation: the others may refer to a mesh that is no more. */
static sn_muscle written_part(const sn_muscle *muscle, unsigned from_muscle) {
    sn_muscle part = *muscle;
    if (!(from_muscle & SN_SECTION_ROOTS)) part.roots = (sn_roots){0};
    if (!(from_muscle & SN_SECTION_STRUCTURE)) part.structure = (sn_structure){0};
    if (!(from_muscle & SN_SECTION_FIBERS)) part.fibers = (sn_fibers){0};
    if (!(from_muscle & SN_SECTION_ATTACHMENTS)) part.attachment_count = 0;
    if (!(from_muscle & SN_SECTION_EXTERNALS)) part.external_count = 0;
    return part;
}

static sn_status write_sections(const sn_muscle *muscle, const sn_json_tree *tree, unsigned from_tree, unsigned from_muscle, sn_json *json,
                                sn_error *error) {
    sn_json_value top = {0};
    if (tree != NULL) top = sn_json_top(tree);
    for (size_t i = 0; i < SECTION_COUNT; i++) {
        if (from_tree & sections[i].bit) {
            sn_json_value section = sn_json_member(&top, sections[i].key);
            sn_json_pass(json, sections[i].key, &section);
        } else if (from_muscle & sections[i].bit) {
            sn_status status = sections[i].write(muscle, json, error);
            if (status != SN_OK) return status;
        }
    }
    return SN_OK;
}

static void pass_unknown_members(const sn_json_tree *tree, sn_json *json) {
    if (tree == NULL) return;
    sn_json_value top = sn_json_top(tree), member = {0};
    while (sn_json_next(&top, &member))
        if (!is_known_member(member.key)) sn_json_pass(json, member.key, &member);
}

static void write_history_entry(const sn_history_entry *entry, sn_json *json) {
    sn_json_object_line(json, NULL);
    sn_json_text(json, "tool", entry->tool);
    sn_json_text(json, "version", SN_VERSION);
    sn_json_array(json, "args");
    for (int i = 0; i < entry->arg_count; i++) sn_json_text(json, NULL, entry->args[i]);
    sn_json_close(json);
    if (entry->input != NULL) sn_json_text(json, "input", entry->input);
    sn_json_close(json);
}

void sn_history_write(const sn_json_tree *tree, const sn_history_entry *entry, sn_json *json) {
    sn_json_value top = {0}, history = {0};
    if (tree != NULL) {
        top = sn_json_top(tree);
        history = sn_json_member(&top, "history");
    }
    if (!sn_json_has(&history) && entry == NULL) return;
    sn_json_array(json, "history");
    for (sn_index i = 0; i < sn_json_length(&history); i++) {
        sn_json_value old = sn_json_element(&history, i);
        sn_json_pass(json, NULL, &old);
    }
    if (entry != NULL) write_history_entry(entry, json);
    sn_json_close(json);
}

sn_status sn_muscle_write(const sn_muscle *muscle, const sn_document *document, const sn_write_options *options, sn_output *output,
                          sn_error *error) {
    const sn_json_tree *tree = tree_of(document);
    unsigned changed = options->changed;
    unsigned in_tree = sections_in(tree), in_muscle = sn_muscle_sections(muscle);
    unsigned stale = find_stale(in_tree | in_muscle, changed);
    unsigned from_tree = in_tree & ~changed & ~stale, from_muscle = in_muscle & ~stale & (tree != NULL ? changed : ~0U);
    sn_muscle part = written_part(muscle, from_muscle);
    sn_status status = sn_muscle_validate(&part, error);
    if (status != SN_OK) return status;
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return sn_fail_memory(error, "writing a document");
    sn_json_object(json, NULL);
    sn_json_text(json, "format", FORMAT);
    sn_json_integer(json, "version", NEWEST_VERSION);
    if (muscle->name != NULL) sn_json_text(json, "name", muscle->name);
    sn_json_number(json, "metersPerUnit", muscle->meters_per_unit);
    if (muscle->space != SN_SPACE_UNKNOWN) sn_json_text(json, "space", sn_space_name(muscle->space));
    status = write_sections(muscle, tree, from_tree, from_muscle, json, error);
    pass_unknown_members(tree, json);
    if (!options->drop_history) sn_history_write(tree, options->entry, json);
    sn_status ended = sn_json_end(json, status == SN_OK ? error : NULL);
    return status != SN_OK ? status : ended;
}
