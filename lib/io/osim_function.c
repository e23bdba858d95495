/* osim_function.c -- the functions of OpenSim's models. */
#include "osim.h"

#include <stdlib.h>

/* Functions within functions, each with a factor. */
enum { DEEPEST_FUNCTION = 16 };

/* <NAME><Kind>...</Kind></NAME> (version 3) or <Kind name="NAME">...</Kind> (version 4). */
sn_index sn_osim_find_function(const sn_xml_tree *tree, sn_index owner, const char *name) {
    sn_index wrapped = sn_xml_child(tree, owner, name);
    if (wrapped != SN_NONE) return sn_xml_child(tree, wrapped, NULL);
    sn_index i = sn_xml_child(tree, owner, NULL);
    while (i != SN_NONE && !sn_span_is(sn_xml_attribute_text(tree, i, "name"), name)) i = sn_xml_next(tree, i, NULL);
    return i;
}

static sn_status read_polynomial(const sn_xml_tree *tree, sn_index element, const char *member, double scale, sn_function **out,
                                 sn_error *error) {
    static const double LINE[] = {1.0, 0.0}, NOTHING[] = {0.0};
    sn_index count = 0;
    double *numbers = NULL;
    sn_status status = sn_xml_all_numbers(sn_xml_child_value(tree, element, member), &count, &numbers, error);
    if (status != SN_OK) return status;
    bool line = sn_xml_is(tree, element, "LinearFunction"), constant = sn_xml_is(tree, element, "Constant");
    if (count == 0) /* OpenSim's defaults */
        status =
            sn_function_create(SN_FUNCTION_POLYNOMIAL, (sn_function_numbers){line ? 2 : 1, NULL, line ? LINE : NOTHING}, scale, out, error);
    else if ((line && count != 2) || (constant && count != 1))
        status = sn_xml_fail(tree, element, error, "%s: %d numbers where %d are needed", member, (int)count, line ? 2 : 1);
    else
        status = sn_function_create(SN_FUNCTION_POLYNOMIAL, (sn_function_numbers){count, NULL, numbers}, scale, out, error);
    free(numbers);
    return status;
}

static sn_status read_knots(const sn_xml_tree *tree, sn_index element, sn_function_kind kind, double scale, sn_function **out,
                            sn_error *error) {
    sn_index x_count = 0, y_count = 0;
    double *x = NULL, *y = NULL;
    sn_error said = {0}; /* knows no line */
    sn_status status = sn_xml_all_numbers(sn_xml_child_value(tree, element, "x"), &x_count, &x, error);
    if (status == SN_OK) status = sn_xml_all_numbers(sn_xml_child_value(tree, element, "y"), &y_count, &y, error);
    if (status == SN_OK && x_count != y_count)
        status = sn_xml_fail(tree, element, error, "the function has %d numbers x and %d numbers y", (int)x_count, (int)y_count);
    if (status == SN_OK && (status = sn_function_create(kind, (sn_function_numbers){x_count, x, y}, scale, out, &said)) != SN_OK)
        status = status == SN_ERROR_INPUT ? sn_xml_fail(tree, element, error, "%s", said.text) : sn_fail_memory(error, "a function");
    free(x);
    free(y);
    return status;
}

static bool is_spline(const sn_xml_tree *tree, sn_index element) {
    return sn_xml_is(tree, element, "SimmSpline") || sn_xml_is(tree, element, "natCubicSpline") ||
           sn_xml_is(tree, element, "NatCubicSpline") || sn_xml_is(tree, element, "NaturalCubicSpline"); /* its older names */
}

sn_status sn_osim_read_function(const sn_xml_tree *tree, sn_index element, double scale, sn_function **out, sn_error *error) {
    *out = NULL;
    for (int depth = 0; sn_xml_is(tree, element, "MultiplierFunction"); depth++) {
        double factor = 1.0;
        sn_status status = sn_xml_numbers(sn_xml_child_value(tree, element, "scale"), 1, &factor, error);
        if (status != SN_OK) return status;
        sn_index inner = sn_osim_find_function(tree, element, "function");
        if (inner == SN_NONE || depth == DEEPEST_FUNCTION)
            return sn_xml_fail(tree, element, error, "a MultiplierFunction without a function of its own");
        scale *= factor;
        element = inner;
    }
    if (!isfinite(scale)) return sn_xml_fail(tree, element, error, "the scale of a function is not finite");
    if (sn_xml_is(tree, element, "Constant")) return read_polynomial(tree, element, "value", scale, out, error);
    if (sn_xml_is(tree, element, "LinearFunction") || sn_xml_is(tree, element, "PolynomialFunction"))
        return read_polynomial(tree, element, "coefficients", scale, out, error);
    if (is_spline(tree, element)) return read_knots(tree, element, SN_FUNCTION_SPLINE, scale, out, error);
    if (sn_xml_is(tree, element, "PiecewiseLinearFunction")) return read_knots(tree, element, SN_FUNCTION_LINES, scale, out, error);
    sn_span name = sn_xml_name(tree, element);
    return sn_xml_fail(tree, element, error,
                       "the function %.*s is not known; Constant, LinearFunction, PolynomialFunction, SimmSpline, PiecewiseLinearFunction "
                       "and MultiplierFunction are",
                       (int)(name.length < 60 ? name.length : 60), name.text);
}
