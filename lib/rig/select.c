/* Vertex selectors ([R18] 3.1: "the user manually selects the root vertices"). */
#include "sinew/rig.h"

#include <stdlib.h>
#include <string.h>

#include "section.h"

static bool is_inside(const sn_mesh *mesh, const sn_selector *s, sn_index vertex) {
    sn_vec3 p = mesh->positions[vertex];
    switch (s->kind) {
    case SN_SELECT_SPHERE:
        return sn_distance(p, s->point) <= s->radius;
    case SN_SELECT_BOX:
        return p.x >= s->point.x && p.x <= s->other.x && p.y >= s->point.y && p.y <= s->other.y && p.z >= s->point.z && p.z <= s->other.z;
    case SN_SELECT_HALF:
        return sn_dot(sn_sub(p, s->point), s->other) >= 0.0;
    default:
        return false;
    }
}

static const char *kind_name(sn_selector_kind kind) {
    static const char *const names[] = {"list of indices", "nearest-vertices", "sphere", "box", "plane", "half-space", "painted"};
    return names[kind];
}

static sn_status fail_empty(const sn_selector *s, sn_error *error) {
    return sn_fail(error, SN_ERROR_INPUT, "the %s selection takes no vertex; check its place and size, in the document's unit",
                   kind_name(s->kind));
}

/* The vertices of flags that are set, ascending. */
static sn_status collect(const bool *flags, sn_index vertex_count, const sn_selector *s, sn_index *count, sn_index **vertices,
                         sn_error *error) {
    sn_index n = 0;
    for (sn_index v = 0; v < vertex_count; v++) n += flags[v];
    if (n == 0) return fail_empty(s, error);
    if (!(*vertices = SN_NEW(sn_index, n))) return sn_fail_memory(error, "the selected vertices");
    for (sn_index v = 0, i = 0; v < vertex_count; v++)
        if (flags[v]) (*vertices)[i++] = v;
    *count = n;
    return SN_OK;
}

/* ---- by index, by shape, by paint ----------------------------------------------------------------------------------- */

static sn_status flag_indices(const sn_mesh *mesh, const sn_selector *s, bool *flags, sn_error *error) {
    for (sn_index i = 0; i < s->count; i++) {
        sn_index v = s->indices[i];
        if (v < 0 || v >= mesh->vertex_count) {
            sn_fail(error, SN_ERROR_INPUT, "vertex %d is selected, but the mesh has vertices 0 to %d", (int)v, (int)mesh->vertex_count - 1);
            if (error) error->element = v;
            return SN_ERROR_INPUT;
        }
        flags[v] = true;
    }
    return SN_OK;
}

static sn_status flag_painted(const sn_mesh *mesh, const sn_selector *s, bool *flags, sn_error *error) {
    const sn_attribute *a = s->attribute ? sn_mesh_attribute(mesh, s->attribute) : NULL;
    if (!a)
        return sn_fail(error, SN_ERROR_INPUT, "the mesh has no vertex attribute \"%s\"; painted selections need one in the PLY file",
                       s->attribute ? s->attribute : "");
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        for (sn_index c = 0; c < a->components; c++)
            if (a->values[(size_t)v * (size_t)a->components + (size_t)c] > s->threshold) flags[v] = true;
    return SN_OK;
}

typedef struct ranked {
    double distance2;
    sn_index vertex;
} ranked;

static int compare_ranked(const void *left, const void *right) {
    const ranked *a = left, *b = right;
    if (a->distance2 != b->distance2) return a->distance2 < b->distance2 ? -1 : 1;
    return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

static sn_status flag_near(const sn_mesh *mesh, const sn_selector *s, bool *flags, sn_error *error) {
    if (s->count < 1 || s->count > mesh->vertex_count)
        return sn_fail(error, SN_ERROR_INPUT, "the %d nearest vertices are asked for; the mesh has %d", (int)s->count,
                       (int)mesh->vertex_count);
    ranked *list = SN_NEW(ranked, mesh->vertex_count);
    if (!list) return sn_fail_memory(error, "the nearest vertices");
    for (sn_index v = 0; v < mesh->vertex_count; v++) list[v] = (ranked){sn_norm2(sn_sub(mesh->positions[v], s->point)), v};
    qsort(list, (size_t)mesh->vertex_count, sizeof *list, compare_ranked);
    for (sn_index i = 0; i < s->count; i++) flags[list[i].vertex] = true;
    free(list);
    return SN_OK;
}

static sn_status flag(const sn_mesh *mesh, const sn_selector *s, bool *flags, sn_error *error) {
    if (s->kind == SN_SELECT_INDICES) return flag_indices(mesh, s, flags, error);
    if (s->kind == SN_SELECT_PAINTED) return flag_painted(mesh, s, flags, error);
    if (s->kind == SN_SELECT_NEAR) return flag_near(mesh, s, flags, error);
    for (sn_index v = 0; v < mesh->vertex_count; v++) flags[v] = is_inside(mesh, s, v);
    return SN_OK;
}

/* ---- the ring along a plane ----------------------------------------------------------------------------------------- */

/* Closed curves before open ones (borders of an open mesh), then the one whose mean is nearest the point. */
static const section_curve *nearest_curve(const section *s, sn_vec3 point) {
    const section_curve *best = NULL;
    for (sn_index i = 0; i < s->curve_count; i++) {
        const section_curve *curve = &s->curves[i];
        bool better = !best || (curve->closed && !best->closed) ||
                      (curve->closed == best->closed && sn_distance(curve->mean, point) < sn_distance(best->mean, point));
        if (better) best = curve;
    }
    return best;
}

static sn_status ring_along_plane(section *cut, const sn_selector *s, const double *height, sn_index *count, sn_index **vertices,
                                  sn_error *error) {
    sn_status status = section_cut(cut, height, 0.0, error);
    if (status) return status;
    const section_curve *curve = nearest_curve(cut, s->point);
    if (!curve) return fail_empty(s, error);
    sn_index *ring = SN_NEW(sn_index, curve->count);
    if (!ring) return sn_fail_memory(error, "the ring along the plane");
    bool simple;
    *count = section_ring(cut, curve, SECTION_LOW, ring, &simple);
    if (curve->closed) section_ring_canonical(*count, ring);
    *vertices = ring;
    return SN_OK;
}

static sn_status select_plane(const sn_mesh *mesh, const sn_topology *topology, const sn_selector *s, sn_index *count, sn_index **vertices,
                              sn_error *error) {
    sn_vec3 normal = sn_normalize(s->other);
    section cut = {0};
    double *height = SN_NEW(double, mesh->vertex_count);
    sn_status status = height ? section_create(mesh, topology, &cut, error) : sn_fail_memory(error, "the heights over the plane");
    if (status) goto done;
    for (sn_index v = 0; v < mesh->vertex_count; v++) height[v] = sn_dot(sn_sub(mesh->positions[v], s->point), normal);
    status = ring_along_plane(&cut, s, height, count, vertices, error);
done:
    section_free(&cut);
    free(height);
    return status;
}

static sn_status check_selector(const sn_selector *s, sn_error *error) {
    if (!sn_finite3(s->point) || !sn_finite3(s->other) || !isfinite(s->radius) || isnan(s->threshold))
        return sn_fail(error, SN_ERROR_USAGE, "the %s selection has a number that is not finite", kind_name(s->kind));
    if ((s->kind == SN_SELECT_PLANE || s->kind == SN_SELECT_HALF) && !(sn_norm2(sn_normalize(s->other)) > 0.0))
        return sn_fail(error, SN_ERROR_USAGE, "the normal of the %s selection is zero; give a direction", kind_name(s->kind));
    return SN_OK;
}

sn_status sn_select_vertices(const sn_mesh *mesh, const sn_topology *topology, const sn_selector *selector, sn_index *count,
                             sn_index **vertices, sn_error *error) {
    *count = 0;
    *vertices = NULL;
    sn_status status = check_selector(selector, error);
    if (status) return status;
    if (selector->kind == SN_SELECT_PLANE) return select_plane(mesh, topology, selector, count, vertices, error);
    bool *flags = SN_NEW(bool, mesh->vertex_count);
    if (!flags) return sn_fail_memory(error, "the selected vertices");
    status = flag(mesh, selector, flags, error);
    if (!status) status = collect(flags, mesh->vertex_count, selector, count, vertices, error);
    free(flags);
    return status;
}
