/*
 * selector.c -- a selector as a user writes it: "KIND:ARGUMENTS".
 */
#include "selector.h"

#include <stdlib.h>
#include <string.h>

/* ---- one parser per form of argument; `rule` holds the kind ------------------------------------------------------------- */

static sn_status parse_indices(const char *list, selector *out, sn_error *error) {
    sn_index capacity = 1;
    for (const char *c = list; *c != '\0'; c++) capacity += *c == ',';
    out->indices = SN_NEW(sn_index, capacity);
    if (out->indices == NULL) return sn_fail_memory(error, "a selector");
    const char *end = list + strlen(list);
    for (const char *c = list;; c++) {
        int64_t index = 0;
        if (!sn_scan_integer(c, end, &c, &index) || (*c != ',' && *c != '\0'))
            return sn_fail(error, SN_ERROR_USAGE, "needs vertex numbers separated by commas, as in indices:3,4,5");
        if (index < 0 || index > SN_INDEX_MAX)
            return sn_fail(error, SN_ERROR_USAGE, "vertex %lld cannot be; vertices count from 0", (long long)index);
        out->indices[out->rule.count++] = (sn_index)index;
        if (*c == '\0') break;
    }
    out->rule.indices = out->indices;
    return SN_OK;
}

/* Exactly `count` finite numbers; `form` shows how they are written. */
static sn_status parse_numbers(const char *list, size_t count, double *out, const char *form, sn_error *error) {
    if (sn_parse_numbers(list, count, out, NULL) == SN_OK) return SN_OK;
    return sn_fail(error, SN_ERROR_USAGE, "needs %zu numbers: %s", count, form);
}

static sn_status parse_near(const char *list, selector *out, sn_error *error) {
    double n[4] = {0, 0, 0, 1};
    if (sn_parse_numbers(list, 4, n, NULL) != SN_OK) {
        n[3] = 1;
        sn_status status = parse_numbers(list, 3, n, "near:x,y,z or near:x,y,z,n", error);
        if (status != SN_OK) return status;
    }
    if (!(n[3] >= 1) || n[3] > SN_INDEX_MAX || n[3] != floor(n[3]))
        return sn_fail(error, SN_ERROR_USAGE, "the number of vertices to take must be a whole number of at least 1");
    out->rule.point = sn_v3(n[0], n[1], n[2]);
    out->rule.count = (sn_index)n[3];
    return SN_OK;
}

static sn_status parse_sphere(const char *list, selector *out, sn_error *error) {
    double n[4];
    sn_status status = parse_numbers(list, 4, n, "sphere:x,y,z,r", error);
    if (status != SN_OK) return status;
    if (!(n[3] > 0)) return sn_fail(error, SN_ERROR_USAGE, "the radius must be greater than 0");
    out->rule.point = sn_v3(n[0], n[1], n[2]);
    out->rule.radius = n[3];
    return SN_OK;
}

static sn_status parse_box(const char *list, selector *out, sn_error *error) {
    double n[6];
    sn_status status = parse_numbers(list, 6, n, "box:x0,y0,z0,x1,y1,z1", error);
    if (status != SN_OK) return status;
    sn_vec3 a = sn_v3(n[0], n[1], n[2]), b = sn_v3(n[3], n[4], n[5]);
    out->rule.point = sn_min3(a, b);
    out->rule.other = sn_max3(a, b);
    return SN_OK;
}

static sn_status parse_plane(const char *list, selector *out, sn_error *error) {
    double n[6];
    sn_status status = parse_numbers(list, 6, n, "px,py,pz,nx,ny,nz (a point of the plane and its normal)", error);
    if (status != SN_OK) return status;
    out->rule.point = sn_v3(n[0], n[1], n[2]);
    out->rule.other = sn_normalize(sn_v3(n[3], n[4], n[5]));
    if (!(sn_norm2(out->rule.other) > 0)) return sn_fail(error, SN_ERROR_USAGE, "the normal of the plane must not be zero");
    return SN_OK;
}

static sn_status parse_painted(const char *text, selector *out, sn_error *error) {
    const char *sign = strrchr(text, '>');
    size_t length = sign != NULL ? (size_t)(sign - text) : strlen(text);
    if (length == 0) return sn_fail(error, SN_ERROR_USAGE, "needs the name of a painted map, as in painted:red or painted:red>127");
    if (sign != NULL && sn_parse_number(sign + 1, &out->rule.threshold, NULL) != SN_OK)
        return sn_fail(error, SN_ERROR_USAGE, "needs a number behind '>', as in painted:red>127");
    out->attribute = sn_strndup(text, length);
    if (out->attribute == NULL) return sn_fail_memory(error, "a selector");
    out->rule.attribute = out->attribute;
    return SN_OK;
}

/* ---- the table of kinds ---------------------------------------------------------------------------------------------------- */

static const struct {
    const char *name;
    sn_selector_kind kind;
    sn_status (*parse)(const char *arguments, selector *out, sn_error *error);
} kinds[] = {
    {"indices", SN_SELECT_INDICES, parse_indices}, {"near", SN_SELECT_NEAR, parse_near},
    {"sphere", SN_SELECT_SPHERE, parse_sphere},    {"box", SN_SELECT_BOX, parse_box},
    {"plane", SN_SELECT_PLANE, parse_plane},       {"half", SN_SELECT_HALF, parse_plane},
    {"painted", SN_SELECT_PAINTED, parse_painted},
};

sn_status selector_parse(const char *text, selector *out, sn_error *error) {
    *out = (selector){0};
    const char *colon = strchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : 0;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strlen(kinds[i].name) != length || strncmp(kinds[i].name, text, length) != 0) continue;
        sn_error reason = {0};
        out->rule.kind = kinds[i].kind;
        sn_status status = kinds[i].parse(colon + 1, out, &reason);
        if (status == SN_OK) return SN_OK;
        selector_free(out);
        return sn_fail(error, status, "selector \"%s\": %s", text, reason.text);
    }
    return sn_fail(error, SN_ERROR_USAGE,
                   "\"%s\" is not a selector; they start with indices: near: sphere: box: plane: half: or painted:", text);
}

void selector_free(selector *s) {
    free(s->indices);
    free(s->attribute);
    *s = (selector){0};
}
