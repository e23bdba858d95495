/* fill_document.c -- what a user gives to fiber-fill: a fibre template, and where fibres end. */
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

sn_status sn_fiber_ends_parse(const sn_blob *blob, sn_index vertex_count, sn_fiber_ends *out, sn_error *error) {
    static const char *const known[] = {"format", "version", "name", "origin", "insertion", NULL};
    sn_json_tree *tree = NULL;
    *out = (sn_fiber_ends){0};
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), origin = sn_json_member(&top, "origin"), insertion = sn_json_member(&top, "insertion");
    status = sn_json_expect_format(&top, "sinew-fiber-ends", NEWEST_ENDS, error);
    if (status == SN_OK) status = sn_json_check_members(&top, known, error);
    if (status == SN_OK)
        status = sn_json_get_indices(&origin, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->origin_count, &out->origin, error);
    if (status == SN_OK)
        status =
            sn_json_get_indices(&insertion, (sn_index_rule){1, -1, 0, vertex_count - 1}, &out->insertion_count, &out->insertion, error);
    if (status == SN_OK && (out->origin_count == 0 || out->insertion_count == 0))
        status = sn_json_complain(&top, error, "\"origin\" and \"insertion\" must each list at least one vertex");
    sn_json_tree_free(tree);
    if (status != SN_OK) sn_fiber_ends_free(out);
    return status;
}

void sn_fiber_ends_free(sn_fiber_ends *ends) {
    free(ends->origin);
    free(ends->insertion);
    *ends = (sn_fiber_ends){0};
}
