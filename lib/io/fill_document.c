/* fill_document.c -- what a user gives to fiber-fill: a fibre template, and where fibres end. */
#include <math.h>
#include <stdlib.h>

#include "document.h"

enum { NEWEST_TEMPLATE = 1, NEWEST_ENDS = 1 };

/* ---- template ------------------------------------------------------------------------------------------------------------------- */

static sn_status parse_curve(const sn_json_value *value, sn_polyline *out, sn_error *error) {
    static const char *const known[] = {"points", NULL};
    sn_json_value points = sn_json_member(value, "points");
    double *coordinates = NULL;
    sn_index count = 0;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_numbers(&points, 3, -1, &count, &coordinates, error);
    if (status != SN_OK) return status;
    out->points = (sn_vec3 *)coordinates;
    out->count = count / 3;
    return sn_json_check_members(value, known, error);
}

static sn_status parse_template(const sn_json_value *top, sn_fibers *out, sn_error *error) {
    static const char *const known[] = {"format", "version", "name", "curves", NULL};
    sn_json_value curves = sn_json_member(top, "curves");
    sn_index count = 0;
    sn_status status = sn_json_expect_format(top, "sinew-fiber-template", NEWEST_TEMPLATE, error);
    if (status == SN_OK) status = sn_json_check_members(top, known, error);
    if (status == SN_OK) status = sn_json_require(&curves, "an array of curves", error);
    if (status == SN_OK) status = sn_json_expect_list(&curves, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if (count == 0) return sn_json_complain(&curves, error, "a template needs at least one curve");
    if ((out->polylines = SN_NEW(sn_polyline, count)) == NULL) return sn_fail_memory(error, "a fibre template");
    out->polyline_count = count;
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value curve = sn_json_element(&curves, i);
        status = parse_curve(&curve, &out->polylines[i], error);
    }
    return status;
}

sn_status sn_fiber_template_parse(const sn_blob *blob, sn_fibers *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    *out = (sn_fibers){0};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree);
    status = parse_template(&top, out, error);
    sn_json_tree_free(tree);
    if (status != SN_OK) sn_fibers_free(out);
    return status;
}

/* ---- ends ------------------------------------------------------------------------------------------------------------------------ */

static sn_status parse_ends(const sn_json_value *top, sn_index vertex_count, sn_fiber_ends *out, sn_error *error) {
    static const char *const known[] = {"format", "version", "name", "origin", "insertion", NULL};
    sn_json_value origin = sn_json_member(top, "origin"), insertion = sn_json_member(top, "insertion");
    sn_status status = sn_json_expect_format(top, "sinew-fiber-ends", NEWEST_ENDS, error);
    if (status == SN_OK) status = sn_json_check_members(top, known, error);
    if (status == SN_OK)
        status = sn_json_get_indices(&origin, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->origin_count, &out->origin, error);
    if (status == SN_OK)
        status =
            sn_json_get_indices(&insertion, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->insertion_count, &out->insertion, error);
    if (status == SN_OK && (out->origin_count == 0 || out->insertion_count == 0))
        status = sn_json_complain(top, error, "\"origin\" and \"insertion\" must each list at least one vertex");
    return status;
}

static sn_index nearest_vertex(const sn_mesh *mesh, sn_vec3 point) {
    sn_index best = 0;
    double least = INFINITY;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 d = sn_sub(mesh->positions[v], point);
        double square = sn_dot(d, d);
        if (square < least) least = square, best = v;
    }
    return best;
}

/* The vertices nearest to the fibres' first points, or their last. */
static sn_status find_end(const sn_fibers *fibers, const sn_mesh *mesh, bool last, sn_index *count, sn_index **out) {
    bool *marked = SN_NEW(bool, mesh->vertex_count);
    *out = SN_NEW(sn_index, fibers->polyline_count);
    *count = 0;
    for (sn_index i = 0; i < fibers->polyline_count && marked != NULL; i++) {
        const sn_polyline *line = &fibers->polylines[i];
        marked[nearest_vertex(mesh, line->points[last ? line->count - 1 : 0])] = true;
    }
    for (sn_index v = 0; v < mesh->vertex_count && marked != NULL && *out != NULL; v++)
        if (marked[v]) (*out)[(*count)++] = v;
    bool enough = marked != NULL && *out != NULL;
    free(marked);
    return enough ? SN_OK : SN_ERROR_MEMORY;
}

static sn_status find_ends(const sn_blob *blob, const sn_mesh *mesh, sn_fiber_ends *out, sn_error *error) {
    sn_fibers fibers;
    sn_status status = sn_polylines_parse(blob, &fibers, error);
    if (status != SN_OK) return status;
    status = find_end(&fibers, mesh, false, &out->origin_count, &out->origin);
    if (status == SN_OK) status = find_end(&fibers, mesh, true, &out->insertion_count, &out->insertion);
    sn_fibers_free(&fibers);
    return status == SN_OK ? SN_OK : sn_fail_memory(error, "the ends of the fibres");
}

sn_status sn_fiber_ends_parse(const sn_blob *blob, const sn_mesh *mesh, sn_fiber_ends *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    bool lines = sn_polylines_detect(blob);
    *out = (sn_fiber_ends){0};
    sn_status status = lines ? SN_OK : sn_json_parse(blob, &tree, error);
    if (status == SN_OK && !lines) {
        sn_json_value top = sn_json_top(tree), fibers = sn_json_member(&top, "fibers"), polylines = sn_json_member(&top, "polylines");
        lines = sn_json_has(&fibers) || sn_json_has(&polylines);
        if (!lines) status = parse_ends(&top, mesh->vertex_count, out, error);
    }
    if (status == SN_OK && lines) status = find_ends(blob, mesh, out, error);
    sn_json_tree_free(tree);
    if (status != SN_OK) sn_fiber_ends_free(out);
    return status;
}

void sn_fiber_ends_free(sn_fiber_ends *ends) {
    free(ends->origin);
    free(ends->insertion);
    *ends = (sn_fiber_ends){0};
}
