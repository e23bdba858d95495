/*
 * contact_patch.c -- surfaces of the scene that muscles keep out of: their triangles, and which of those come near which muscle over the
 * motion.   bodies.md 2
 */
#include "contact.h"

#include <stdlib.h>

/* Vertices nearer to each other than this share of the diagonal are one: hosts split them at seams. */
static const double ONE_PLACE = 1e-7;

/* ---- before the motion is looked at -------------------------------------------------------------------------------------------------- */

/* The mesh with one vertex at each place; vertices (of the new mesh): the first of the old ones there. */
static sn_status join_vertices(const sn_mesh *mesh, sn_mesh *joined, sn_index **vertices, sn_error *error) {
    sn_index count, *numbers = SN_NEW(sn_index, mesh->vertex_count);
    sn_status status = numbers != NULL ? sn_mesh_copy(mesh, joined, error) : sn_fail_memory(error, "a surface");
    if (status == SN_OK) status = sn_weld(joined, ONE_PLACE * sn_box_diagonal(sn_mesh_box(mesh)), &count, numbers, error);
    if (status == SN_OK && (*vertices = SN_NEW(sn_index, joined->vertex_count)) == NULL) status = sn_fail_memory(error, "a surface");
    for (sn_index v = mesh->vertex_count; v-- > 0 && status == SN_OK;)
        if (numbers[v] != SN_NONE) (*vertices)[numbers[v]] = v;
    free(numbers);
    return status;
}

/* Triangles of pieces that have no rim: closed (triangle_count). Returns how many; -1 = out of memory. */
static sn_index find_closed(const sn_mesh *mesh, const sn_topology *topology, bool *closed) {
    sn_index *piece = SN_NEW(sn_index, mesh->triangle_count), count = 0;
    sn_index pieces = piece != NULL ? sn_mesh_components(mesh, topology, piece) : 0;
    bool *open = SN_NEW(bool, pieces);
    bool enough = piece != NULL && open != NULL;
    for (sn_index e = 0; enough && e < topology->edge_count; e++)
        if (topology->edges[e].triangle_count != 2) open[piece[topology->edges[e].triangle[0]]] = true;
    for (sn_index t = 0; enough && t < mesh->triangle_count; t++) count += closed[t] = !open[piece[t]];
    free(piece);
    free(open);
    return enough ? count : -1;
}

/* Each closed piece with its inside inside, a cavity within another as it is; open pieces have no inside and stay. */
static sn_status turn_pieces(sn_mesh *mesh, const bool *closed, sn_index count, sn_index *turned, sn_error *error) {
    sn_mesh part = *mesh; /* lends all but its triangles */
    if ((part.triangles = SN_NEW(sn_triangle, count)) == NULL) return sn_fail_memory(error, "a surface");
    part.triangle_count = 0;
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        if (closed[t]) part.triangles[part.triangle_count++] = mesh->triangles[t];
    sn_status status = sn_orient_outward(&part, turned, error);
    for (sn_index t = 0, next = 0; t < mesh->triangle_count && status == SN_OK; t++)
        if (closed[t]) mesh->triangles[t] = part.triangles[next++];
    free(part.triangles);
    return status;
}

/* Inside out counts as right side out, where there is an inside. */
static sn_status turn_outwards(sn_mesh *mesh, const char *name, sn_error *error) {
    sn_topology topology;
    sn_index turned = 0;
    sn_status status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    bool *closed = SN_NEW(bool, mesh->triangle_count);
    sn_index count = closed != NULL ? find_closed(mesh, &topology, closed) : -1;
    if (count < 0)
        status = sn_fail_memory(error, "a surface");
    else if (count > 0)
        status = turn_pieces(mesh, closed, count, &turned, error);
    free(closed);
    sn_topology_free(&topology);
    if (status == SN_OK && turned > 0)
        sn_log(SN_LOG_INFO, "surface \"%s\" is inside out, or %ld of its pieces: what is closed is taken the other way round", name,
               (long)turned);
    return status;
}

static double thickness_of(const sn_mesh *mesh) {
    sn_mesh_report report;
    if (sn_mesh_inspect(mesh, &report, NULL) != SN_OK || !report.closed) return 0.0;
    return sn_thickness(report.volume, report.area);
}

static sn_status make_surface(const sn_scene_surface *source, sn_contact_surface *out, sn_error *error) {
    sn_mesh joined = {0};
    if (!source->loaded) return sn_fail(error, SN_ERROR_INPUT, "it is not loaded");
    sn_status status = join_vertices(&source->envelope.mesh, &joined, &out->vertices, error);
    if (status == SN_OK) status = turn_outwards(&joined, source->name, error);
    if (status == SN_OK) {
        out->thickness = thickness_of(&joined);
        status = sn_moving_create(&joined, &out->moving, error);
    }
    sn_mesh_free(&joined);
    if (status != SN_OK) return status;
    out->positions = SN_NEW(sn_vec3, out->moving.vertex_count);
    out->boxes = SN_NEW(sn_box, sn_moving_box_count(&out->moving));
    return out->positions != NULL && out->boxes != NULL ? SN_OK : sn_fail_memory(error, "a surface");
}

static sn_status complain(const char *name, sn_status status, sn_error *error) {
    if (error == NULL || status != SN_ERROR_INPUT) return status;
    sn_error why = *error;
    return sn_fail(error, status, "surface \"%s\" cannot be touched: %s; mesh-clean mends that, or leave its \"contact\" out", name,
                   why.text);
}

sn_status sn_contact_surfaces_make(const sn_scene *scene, struct sn_contact_plan *plan, sn_error *error) {
    plan->surface_count = scene->surface_count;
    plan->surfaces = SN_NEW(sn_contact_surface, scene->surface_count);
    if (plan->surfaces == NULL) return sn_fail_memory(error, "contact");
    for (sn_index i = 0; i < scene->surface_count && plan->voxels == NULL; i++) {
        sn_contact_surface *surface = &plan->surfaces[i];
        if (!scene->surfaces[i].solid) continue;
        sn_status status = make_surface(&scene->surfaces[i], surface, error);
        if (status != SN_OK) return complain(scene->surfaces[i].name, status, error);
        surface->first_leaf = plan->leaf_count;
        plan->leaf_count += sn_moving_leaf_count(&surface->moving);
    }
    plan->touched = SN_NEW(bool, (size_t)scene->muscle_count *(size_t)plan->leaf_count);
    return plan->touched != NULL ? SN_OK : sn_fail_memory(error, "contact");
}

void sn_contact_surfaces_free(struct sn_contact_plan *plan) {
    for (sn_index i = 0; plan->surfaces != NULL && i < plan->surface_count; i++) {
        sn_moving_free(&plan->surfaces[i].moving);
        free(plan->surfaces[i].vertices);
        free(plan->surfaces[i].positions);
        free(plan->surfaces[i].boxes);
    }
    free(plan->surfaces);
    free(plan->touched);
}

/* ---- over the motion ----------------------------------------------------------------------------------------------------------------- */

static bool *touched_by(const struct sn_contact_plan *plan, sn_index muscle, sn_index surface) {
    return plan->touched + (size_t)muscle * (size_t)plan->leaf_count + plan->surfaces[surface].first_leaf;
}

void sn_contact_surfaces_look(const sn_scene *scene, const sn_surface_moment *at, const sn_box *boxes, struct sn_contact_plan *plan) {
    for (sn_index i = 0; i < plan->surface_count; i++) {
        sn_contact_surface *surface = &plan->surfaces[i];
        if (surface->moving.triangle_count == 0) continue;
        for (sn_index v = 0; v < surface->moving.vertex_count; v++)
            surface->positions[v] = sn_scene_surface_vertex(&scene->surfaces[i], at, surface->vertices[v]);
        sn_moving_fit(&surface->moving, surface->positions, surface->boxes);
        for (sn_index m = 0; m < plan->muscle_count; m++)
            if (boxes[m].low.x <= boxes[m].high.x) sn_moving_touch(&surface->moving, surface->boxes, &boxes[m], touched_by(plan, m, i));
    }
}

/* ---- after it ------------------------------------------------------------------------------------------------------------------------ */

bool sn_contact_surface_near(const struct sn_contact_plan *plan, sn_index muscle, sn_index surface) {
    const sn_moving *moving = &plan->surfaces[surface].moving;
    if (moving->triangle_count == 0) return false;
    const bool *touched = touched_by(plan, muscle, surface);
    for (sn_index leaf = 0; leaf < sn_moving_leaf_count(moving); leaf++)
        if (touched[leaf]) return true;
    return false;
}

sn_status sn_patch_make(const struct sn_contact_plan *plan, sn_index muscle, sn_index surface, sn_patch *out, sn_error *error) {
    const sn_contact_surface *whole = &plan->surfaces[surface];
    const bool *touched = touched_by(plan, muscle, surface);
    bool *keep = SN_NEW(bool, whole->moving.triangle_count);
    out->vertices = SN_NEW(sn_index, whole->moving.vertex_count);
    if (keep == NULL || out->vertices == NULL) {
        free(keep);
        return sn_fail_memory(error, "contact");
    }
    for (sn_index t = 0; t < whole->moving.triangle_count; t++) keep[t] = touched[sn_moving_leaf(&whole->moving, t)];
    sn_status status = sn_moving_part(&whole->moving, keep, &out->moving, out->vertices, error);
    free(keep);
    if (status != SN_OK) return status;
    for (sn_index v = 0; v < out->moving.vertex_count; v++) out->vertices[v] = whole->vertices[out->vertices[v]];
    void *fitted = sn_realloc(out->vertices, (size_t)out->moving.vertex_count, sizeof *out->vertices);
    if (fitted != NULL) out->vertices = fitted;
    return SN_OK;
}

void sn_patch_free(sn_patch *patch) {
    if (patch == NULL) return;
    sn_moving_free(&patch->moving);
    free(patch->vertices);
    free(patch);
}
