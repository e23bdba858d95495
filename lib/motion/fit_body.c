/*
 * fit_body.c -- a body for a motion: which joint each bone hangs on, and where its joints' centres are.
 */
#include "sinew/motion_fit.h"

#include <stdlib.h>
#include <string.h>

/* ---- selections ------------------------------------------------------------------------------------------------------------------- */

/* Vertices and triangles of all bones that match, together; a selection out of them. */
typedef struct gathered {
    sn_index point_count, triangle_count, bone_count;
    sn_vec3 *points;
    sn_triangle *triangles;
    bool *chosen; /* (point_count) */
} gathered;

static void free_gathered(gathered *g) {
    free(g->points);
    free(g->triangles);
    free(g->chosen);
}

static void append_mesh(const sn_mesh *mesh, gathered *g) {
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        g->triangles[g->triangle_count++] = (sn_triangle){{v[0] + g->point_count, v[1] + g->point_count, v[2] + g->point_count}};
    }
    memcpy(g->points + g->point_count, mesh->positions, (size_t)mesh->vertex_count * sizeof *g->points);
    g->point_count += mesh->vertex_count;
}

static sn_status gather(const sn_fit_body *body, const char *pattern, gathered *g, sn_error *error) {
    size_t points = 0, triangles = 0;
    for (sn_index b = 0; b < body->bone_count; b++) {
        if (!sn_fit_matches(pattern, body->bones[b].name)) continue;
        g->bone_count++;
        points += (size_t)body->bones[b].mesh->vertex_count;
        triangles += (size_t)body->bones[b].mesh->triangle_count;
    }
    if (g->bone_count == 0) return sn_fail(error, SN_ERROR_INPUT, "no bone has a name like \"%s\"", pattern);
    if (points > SN_INDEX_MAX || triangles > SN_INDEX_MAX) return sn_fail_memory(error, "a selection");
    g->points = SN_NEW(sn_vec3, points);
    g->triangles = SN_NEW(sn_triangle, triangles);
    g->chosen = SN_NEW(bool, points);
    if (g->points == NULL || g->triangles == NULL || g->chosen == NULL) return sn_fail_memory(error, "a selection");
    for (sn_index b = 0; b < body->bone_count; b++)
        if (sn_fit_matches(pattern, body->bones[b].name)) append_mesh(body->bones[b].mesh, g);
    for (sn_index i = 0; i < g->point_count; i++) g->chosen[i] = true;
    return SN_OK;
}

static void narrow(const sn_fit_region *region, gathered *g) {
    double farthest = -INFINITY;
    for (sn_index i = 0; i < g->point_count; i++)
        if (g->chosen[i]) farthest = fmax(farthest, sn_dot(region->vector, g->points[i]));
    for (sn_index i = 0; i < g->point_count; i++) {
        bool within = region->kind == SN_FIT_BALL ? sn_distance(g->points[i], region->vector) <= region->length
                                                  : sn_dot(region->vector, g->points[i]) >= farthest - region->length;
        g->chosen[i] = g->chosen[i] && within;
    }
}

/* The chosen vertices alone, and the triangles that have no other corners. */
static sn_status compress(gathered *g, sn_error *error) {
    sn_index *place = SN_NEW(sn_index, g->point_count), points = 0, triangles = 0;
    if (place == NULL) return sn_fail_memory(error, "a selection");
    for (sn_index i = 0; i < g->point_count; i++) {
        place[i] = points;
        if (g->chosen[i]) g->points[points++] = g->points[i];
    }
    for (sn_index t = 0; t < g->triangle_count; t++) {
        const sn_index *v = g->triangles[t].v;
        if (g->chosen[v[0]] && g->chosen[v[1]] && g->chosen[v[2]])
            g->triangles[triangles++] = (sn_triangle){{place[v[0]], place[v[1]], place[v[2]]}};
    }
    g->point_count = points;
    g->triangle_count = triangles;
    free(place);
    return SN_OK;
}

static sn_status select_part(const sn_fit_body *body, const sn_fit_selection *selection, gathered *g, sn_error *error) {
    *g = (gathered){0};
    sn_status status = gather(body, selection->bones, g, error);
    for (sn_index i = 0; i < selection->region_count && status == SN_OK; i++) narrow(&selection->regions[i], g);
    if (status == SN_OK) status = compress(g, error);
    if (status == SN_OK && g->point_count == 0)
        status = sn_fail(error, SN_ERROR_INPUT, "no vertex of \"%s\" lies in the region; are units and axes those of the body?",
                         selection->bones);
    return status;
}

/* ---- rules ------------------------------------------------------------------------------------------------------------------------- */

static sn_vec3 mean_of(const gathered *g) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = 0; i < g->point_count; i++) sum = sn_add(sum, g->points[i]);
    return sn_scale(sum, 1.0 / g->point_count);
}

/* What one selection of a rule gives: its mean, or the centre of its sphere. */
static sn_status place_part(const sn_fit_body *body, const sn_fit_rule *rule, sn_index s, sn_fit_place *out, sn_vec3 *at, sn_error *error) {
    gathered g;
    sn_status status = select_part(body, &rule->selections[s], &g, error);
    if (status == SN_OK && (rule->kind == SN_FIT_MEAN || rule->kind == SN_FIT_MIDDLE)) {
        *at = mean_of(&g);
    } else if (status == SN_OK) {
        const sn_fit_patch patch = {g.point_count, g.triangle_count, g.points, g.triangles};
        status = sn_fit_sphere_robust(&patch, &out->spheres[s], error);
        *at = out->spheres[s].centre;
        out->sphere_count = s + 1;
    }
    free_gathered(&g);
    return status;
}

static sn_status find_place(const sn_fit_body *body, const sn_fit_point *point, sn_fit_place *out, sn_error *error) {
    const sn_fit_rule *rule = &point->rule;
    sn_index count = sn_fit_rule_selections(rule->kind);
    sn_vec3 parts[2] = {rule->point, rule->point};
    sn_status status = SN_OK;
    sn_error inner = {0};
    for (sn_index s = 0; s < count && status == SN_OK; s++) status = place_part(body, rule, s, out, &parts[s], &inner);
    if (status != SN_OK) return sn_fail_at(error, status, body->table->name, point->line, "\"%s\": %s", point->name, inner.text);
    out->centre = count == 2 ? sn_lerp(parts[0], parts[1], 0.5) : parts[0];
    return SN_OK;
}

/* ---- the body ----------------------------------------------------------------------------------------------------------------------- */

static sn_status bind_bones(sn_fit_body *body, sn_error *error) {
    sn_index bound = 0;
    for (sn_index b = 0; b < body->bone_count; b++) {
        sn_fit_bone *bone = &body->bones[b];
        bone->row = sn_fit_table_row(body->table, bone->name);
        bone->joint = bone->row != SN_NONE ? body->table->bones[bone->row].joint : SN_NONE;
        bound += bone->row != SN_NONE;
    }
    if (bound > 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, body->table->name, 0, "no row binds any of the %d bones; are these the bones of another body?",
                      body->bone_count);
}

sn_status sn_fit_body_create(const sn_fit_table *table, sn_index count, const sn_fit_bone *bones, sn_fit_body *out, sn_error *error) {
    *out = (sn_fit_body){.table = table, .bones = SN_NEW(sn_fit_bone, count), .places = SN_NEW(sn_fit_place, table->point_count)};
    sn_status status = out->bones != NULL && out->places != NULL ? SN_OK : sn_fail_memory(error, "the body");
    if (status == SN_OK && count > 0) memcpy(out->bones, bones, (size_t)count * sizeof *bones);
    if (status == SN_OK) out->bone_count = count;
    if (status == SN_OK) status = bind_bones(out, error);
    for (sn_index p = 0; p < table->point_count && status == SN_OK; p++)
        status = find_place(out, &table->points[p], &out->places[p], error);
    if (status != SN_OK) sn_fit_body_free(out);
    return status;
}

void sn_fit_body_free(sn_fit_body *body) {
    free(body->bones);
    free(body->places);
    *body = (sn_fit_body){0};
}
