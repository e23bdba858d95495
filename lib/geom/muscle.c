/* muscle.c -- the muscle as data: what is there, whether it can be trusted, and its end. */
#include "sinew/muscle.h"

#include <stdlib.h>
#include <string.h>

/* ---- the end ---------------------------------------------------------------------------------------------------------- */

void sn_roots_free(sn_roots *roots) {
    free(roots->vertices);
    free(roots->rule);
    *roots = (sn_roots){0};
}

void sn_structure_free(sn_structure *structure) {
    free(structure->positions);
    free(structure->parents);
    free(structure->branches);
    free(structure->axes);
    free(structure->vertex_sample);
    *structure = (sn_structure){0};
}

void sn_fibers_free(sn_fibers *fibers) {
    for (sn_index i = 0; i < fibers->polyline_count && fibers->polylines != NULL; i++) free(fibers->polylines[i].points);
    free(fibers->polylines);
    free(fibers->directions);
    free(fibers->confidence);
    free(fibers->field);
    *fibers = (sn_fibers){0};
}

void sn_attachments_free(sn_attachment *attachments, sn_index count) {
    for (sn_index i = 0; i < count && attachments != NULL; i++) {
        free(attachments[i].bone);
        free(attachments[i].method);
        free(attachments[i].vertices);
        free(attachments[i].distances);
        free(attachments[i].reasons);
        free(attachments[i].confidence);
    }
    free(attachments);
}

void sn_externals_free(sn_external *externals, sn_index count) {
    for (sn_index i = 0; i < count && externals != NULL; i++) {
        free(externals[i].target);
        free(externals[i].fascia);
        free(externals[i].vertices);
        free(externals[i].triangles);
        free(externals[i].barycentric);
        free(externals[i].distances);
        free(externals[i].minimum);
        free(externals[i].weights);
    }
    free(externals);
}

void sn_external_blend(const double weights[3], double out[3]) {
    double both = weights[1] + weights[2], rest = both > 0.0 ? (1.0 - weights[0]) / both : 0.0;
    out[0] = weights[0];
    out[1] = rest * weights[1];
    out[2] = rest * weights[2];
}

const char *const sn_attachment_end_names[] = {"unknown", "origin", "insertion", NULL};

const char *sn_attach_reason_name(sn_attach_reason reason) {
    static const char *const names[SN_REASON_COUNT] = {NULL, "pin", "area", "contact", "voxel", "proximity", "nearest", "filled"};
    return reason > 0 && reason < SN_REASON_COUNT ? names[reason] : NULL;
}

void sn_muscle_free(sn_muscle *muscle) {
    free(muscle->name);
    sn_mesh_free(&muscle->mesh);
    sn_roots_free(&muscle->roots);
    sn_structure_free(&muscle->structure);
    sn_fibers_free(&muscle->fibers);
    sn_attachments_free(muscle->attachments, muscle->attachment_count);
    sn_externals_free(muscle->externals, muscle->external_count);
    *muscle = (sn_muscle){0};
}

unsigned sn_muscle_sections(const sn_muscle *muscle) {
    unsigned sections = 0;
    if (muscle->mesh.vertex_count > 0) sections |= SN_SECTION_MESH;
    if (muscle->roots.count > 0) sections |= SN_SECTION_ROOTS;
    if (muscle->structure.sample_count > 0) sections |= SN_SECTION_STRUCTURE;
    if (muscle->fibers.directions != NULL || muscle->fibers.polyline_count > 0) sections |= SN_SECTION_FIBERS;
    if (muscle->has_attachments || muscle->attachment_count > 0) sections |= SN_SECTION_ATTACHMENTS;
    if (muscle->has_externals || muscle->external_count > 0) sections |= SN_SECTION_EXTERNALS;
    return sections;
}

/* ---- painting ------------------------------------------------------------------------------------------------------------ */

/* An attribute of this name, all its values `value`; one that is there already is replaced. NULL = out of memory. */
static sn_attribute *paint(sn_mesh *mesh, const char *name, sn_index components, double value) {
    sn_mesh_remove_attribute(mesh, name);
    sn_attribute *attribute = sn_mesh_add_attribute(mesh, name, components);
    if (attribute == NULL) return NULL;
    attribute->integer = components == 1;
    size_t count = (size_t)mesh->vertex_count * (size_t)components;
    for (size_t i = 0; i < count; i++) attribute->values[i] = value;
    return attribute;
}

static bool paint_fibers(const sn_muscle *muscle, sn_mesh *mesh) {
    if (muscle->fibers.directions == NULL) return true;
    sn_attribute *attribute = paint(mesh, "fiber", 3, 0.0);
    for (sn_index v = 0; attribute != NULL && v < mesh->vertex_count; v++) {
        sn_vec3 d = muscle->fibers.directions[v];
        double *value = &attribute->values[3 * (size_t)v];
        value[0] = d.x, value[1] = d.y, value[2] = d.z;
    }
    return attribute != NULL;
}

static bool paint_samples(const sn_muscle *muscle, sn_mesh *mesh) {
    if (muscle->structure.sample_count == 0) return true;
    sn_attribute *attribute = paint(mesh, "sample", 1, -1.0);
    for (sn_index v = 0; attribute != NULL && v < mesh->vertex_count; v++) {
        attribute->values[v] = (double)muscle->structure.vertex_sample[v];
    }
    return attribute != NULL;
}

static bool paint_attachments(const sn_muscle *muscle, sn_mesh *mesh) {
    if (muscle->attachment_count == 0) return true;
    sn_attribute *attribute = paint(mesh, "attachment", 1, -1.0);
    for (sn_index i = 0; attribute != NULL && i < muscle->attachment_count; i++) {
        const sn_attachment *attachment = &muscle->attachments[i];
        for (sn_index k = 0; k < attachment->count; k++) attribute->values[attachment->vertices[k]] = (double)i;
        if (!sn_attribute_add_label(attribute, attachment->bone)) return false;
    }
    return attribute != NULL;
}

static bool paint_roots(const sn_muscle *muscle, sn_mesh *mesh) {
    if (muscle->roots.count == 0) return true;
    sn_attribute *attribute = paint(mesh, "root", 1, 0.0);
    for (sn_index i = 0; attribute != NULL && i < muscle->roots.count; i++) attribute->values[muscle->roots.vertices[i]] = 1.0;
    return attribute != NULL;
}

sn_status sn_muscle_paint(const sn_muscle *muscle, sn_mesh *out, sn_error *error) {
    sn_status status = sn_mesh_copy(&muscle->mesh, out, error);
    if (status != SN_OK) return status;
    if (paint_fibers(muscle, out) && paint_samples(muscle, out) && paint_attachments(muscle, out) && paint_roots(muscle, out)) return SN_OK;
    sn_mesh_free(out);
    return sn_fail_memory(error, "a painted mesh");
}

/* ---- validation ------------------------------------------------------------------------------------------------------- */

static sn_status fail_element(sn_error *error, sn_index element, const char *section, const char *what) {
    sn_status status = sn_fail(error, SN_ERROR_INPUT, "%s %ld %s", section, (long)element, what);
    if (error != NULL) error->element = element;
    return status;
}

static sn_status check_roots(const sn_muscle *muscle, sn_index *seen, sn_error *error) {
    const sn_roots *roots = &muscle->roots;
    if (roots->count < 0 || (roots->count > 0 && roots->vertices == NULL))
        return sn_fail(error, SN_ERROR_INPUT, "roots: the section has no vertices");
    for (sn_index i = 0; i < roots->count; i++) {
        sn_index v = roots->vertices[i];
        if (v < 0 || v >= muscle->mesh.vertex_count)
            return sn_fail(error, SN_ERROR_INPUT, "roots: entry %ld names vertex %ld, but the mesh has %ld vertices", (long)i, (long)v,
                           (long)muscle->mesh.vertex_count);
        if (seen[v] != 0) return fail_element(error, v, "roots: vertex", "is named twice");
        seen[v] = 1;
    }
    return SN_OK;
}

static sn_status check_sample(const sn_structure *structure, sn_index i, sn_error *error) {
    const char *section = "structure: sample";
    sn_index parent = structure->parents[i];
    if (!sn_finite3(structure->positions[i])) return fail_element(error, i, section, "has a position that is not finite");
    if (!sn_finite3(structure->axes[i])) return fail_element(error, i, section, "has an axis that is not finite");
    if (structure->branches[i] < 0) return fail_element(error, i, section, "has a negative branch");
    if (i == 0 && parent != SN_NONE) return fail_element(error, i, section, "is the first and so the root, but has a parent");
    if (i == 0 && structure->branches[0] != 0) return fail_element(error, i, section, "is the root, but not on branch 0");
    if (i > 0 && parent == SN_NONE) return fail_element(error, i, section, "is a second root: a structure is one tree");
    if (i > 0 && (parent < 0 || parent >= i)) return fail_element(error, i, section, "has a parent that does not come before it");
    return SN_OK;
}

static sn_status check_structure(const sn_muscle *muscle, sn_error *error) {
    const sn_structure *structure = &muscle->structure;
    if (structure->sample_count == 0) return SN_OK;
    if (structure->sample_count < 0 || structure->positions == NULL || structure->parents == NULL || structure->branches == NULL ||
        structure->axes == NULL || structure->vertex_sample == NULL)
        return sn_fail(error, SN_ERROR_INPUT, "structure: the section is incomplete");
    if (!isfinite(structure->spacing) || structure->spacing < 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "structure: spacing is not a length");
    for (sn_index i = 0; i < structure->sample_count; i++) {
        sn_status status = check_sample(structure, i, error);
        if (status != SN_OK) return status;
    }
    for (sn_index v = 0; v < muscle->mesh.vertex_count; v++) {
        sn_index sample = structure->vertex_sample[v];
        if (sample != SN_NONE && (sample < 0 || sample >= structure->sample_count))
            return fail_element(error, v, "structure: vertex", "hangs on a sample that is not there");
    }
    return SN_OK;
}

static sn_status check_fibers(const sn_muscle *muscle, sn_error *error) {
    const sn_fibers *fibers = &muscle->fibers;
    for (sn_index v = 0; v < muscle->mesh.vertex_count && fibers->directions != NULL; v++)
        if (!sn_finite3(fibers->directions[v])) return fail_element(error, v, "fibers: vertex", "has a direction that is not finite");
    for (sn_index v = 0; v < muscle->mesh.vertex_count && fibers->confidence != NULL; v++)
        if (!(fibers->confidence[v] >= 0.0 && fibers->confidence[v] <= 1.0))
            return fail_element(error, v, "fibers: vertex", "has a confidence that is not between 0 and 1");
    if (fibers->polyline_count < 0 || (fibers->polyline_count > 0 && fibers->polylines == NULL))
        return sn_fail(error, SN_ERROR_INPUT, "fibers: the polylines are missing");
    for (sn_index i = 0; i < fibers->polyline_count; i++) {
        const sn_polyline *line = &fibers->polylines[i];
        if (line->count < 2 || line->points == NULL) return fail_element(error, i, "fibers: polyline", "has fewer than two points");
        for (sn_index k = 0; k < line->count; k++)
            if (!sn_finite3(line->points[k])) return fail_element(error, i, "fibers: polyline", "has a point that is not finite");
    }
    return SN_OK;
}

/* seen: for each vertex 1 + the attachment that has named it, 0 = none yet. */
static sn_status check_attachment(const sn_muscle *muscle, sn_index i, sn_index *seen, sn_error *error) {
    const sn_attachment *attachment = &muscle->attachments[i];
    const char *bone = attachment->bone;
    if (bone == NULL || *bone == '\0') return fail_element(error, i, "attachments: entry", "names no bone");
    if (attachment->count < 0 || (attachment->count > 0 && attachment->vertices == NULL))
        return fail_element(error, i, "attachments: entry", "has no vertices");
    for (sn_index k = 0; k < attachment->count; k++) {
        sn_index v = attachment->vertices[k];
        if (v < 0 || v >= muscle->mesh.vertex_count)
            return sn_fail(error, SN_ERROR_INPUT, "attachments: bone '%s' names vertex %ld, but the mesh has %ld vertices", bone, (long)v,
                           (long)muscle->mesh.vertex_count);
        if (k > 0 && v <= attachment->vertices[k - 1])
            return sn_fail(error, SN_ERROR_INPUT, "attachments: the vertices of bone '%s' do not ascend at vertex %ld", bone, (long)v);
        if (seen[v] != 0)
            return sn_fail(error, SN_ERROR_INPUT, "attachments: vertex %ld is held by bone '%s' and again by bone '%s'", (long)v,
                           muscle->attachments[seen[v] - 1].bone, bone);
        if (attachment->distances != NULL && !isfinite(attachment->distances[k]))
            return sn_fail(error, SN_ERROR_INPUT, "attachments: bone '%s' has a distance that is not finite", bone);
        if (attachment->reasons != NULL && sn_attach_reason_name((sn_attach_reason)attachment->reasons[k]) == NULL)
            return sn_fail(error, SN_ERROR_INPUT, "attachments: bone '%s' has a reason that is none of 1 to %d", bone, SN_REASON_COUNT - 1);
        if (attachment->confidence != NULL && !(attachment->confidence[k] >= 0.0 && attachment->confidence[k] <= 1.0))
            return sn_fail(error, SN_ERROR_INPUT, "attachments: bone '%s' has a confidence that is not within [0,1]", bone);
        seen[v] = i + 1;
    }
    return SN_OK;
}

static sn_status check_attachments(const sn_muscle *muscle, sn_index *seen, sn_error *error) {
    if (muscle->attachment_count < 0 || (muscle->attachment_count > 0 && muscle->attachments == NULL))
        return sn_fail(error, SN_ERROR_INPUT, "attachments: the section is incomplete");
    memset(seen, 0, (size_t)muscle->mesh.vertex_count * sizeof *seen);
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        sn_status status = check_attachment(muscle, i, seen, error);
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

static sn_status fail_external(const sn_external *e, const char *what, sn_error *error) {
    return sn_fail(error, SN_ERROR_INPUT, "externals: target '%s' %s", e->target, what);
}

static bool in_unit_range(const double values[3]) {
    for (int i = 0; i < 3; i++)
        if (!(values[i] >= 0.0 && values[i] <= 1.0)) return false;
    return true;
}

static sn_status check_external(const sn_muscle *muscle, sn_index i, sn_error *error) {
    const sn_external *e = &muscle->externals[i];
    if (e->target == NULL || *e->target == '\0') return fail_element(error, i, "externals: entry", "names no target");
    bool complete = e->vertices && e->triangles && e->barycentric && e->distances && e->minimum && e->weights;
    if (e->count < 0 || (e->count > 0 && !complete)) return fail_element(error, i, "externals: entry", "is incomplete");
    for (sn_index k = 0; k < e->count; k++) {
        const double *b = &e->barycentric[3 * (size_t)k];
        if (e->vertices[k] < 0 || e->vertices[k] >= muscle->mesh.vertex_count || (k > 0 && e->vertices[k] <= e->vertices[k - 1]))
            return fail_external(e, "has vertices that do not ascend, or that the mesh does not have", error);
        if (e->triangles[k] < 0) return fail_external(e, "has a triangle that cannot be", error);
        if (!in_unit_range(b) || fabs(b[0] + b[1] + b[2] - 1.0) > 1e-6)
            return fail_external(e, "has barycentric coordinates that are no point of a triangle", error);
        if (!isfinite(e->distances[k]) || !isfinite(e->minimum[k])) return fail_external(e, "has a distance that is not finite", error);
        if (!in_unit_range(&e->weights[3 * (size_t)k])) return fail_external(e, "has a weight that is not within [0,1]", error);
    }
    return SN_OK;
}

static sn_status check_externals(const sn_muscle *muscle, sn_error *error) {
    if (muscle->external_count < 0 || (muscle->external_count > 0 && muscle->externals == NULL))
        return sn_fail(error, SN_ERROR_INPUT, "externals: the section is incomplete");
    sn_status status = SN_OK;
    for (sn_index i = 0; i < muscle->external_count && status == SN_OK; i++) status = check_external(muscle, i, error);
    return status;
}

sn_status sn_muscle_validate(const sn_muscle *muscle, sn_error *error) {
    if (!isfinite(muscle->meters_per_unit) || muscle->meters_per_unit <= 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "metersPerUnit is not a number above 0; write 1 for metres, 0.001 for millimetres");
    sn_status status = sn_mesh_validate(&muscle->mesh, error);
    if (status != SN_OK) return status;
    sn_index *seen = SN_NEW(sn_index, muscle->mesh.vertex_count);
    if (seen == NULL) return sn_fail_memory(error, "checking a muscle");
    status = check_roots(muscle, seen, error);
    if (status == SN_OK) status = check_structure(muscle, error);
    if (status == SN_OK) status = check_fibers(muscle, error);
    if (status == SN_OK) status = check_attachments(muscle, seen, error);
    if (status == SN_OK) status = check_externals(muscle, error);
    free(seen);
    return status;
}
