/*
 * show_externals.c -- candidates for external constraints ([R18] 4.3): vertices by target, rows by what acts in them, in space and in a
 * section as in [R18] figure 11.
 */
#include "show.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double ROW_RADIUS = 0.0011, ROW_DOT_RADIUS = 0.0026, OUTLINE_RADIUS = 0.0016;
static const double TARGET_OPACITY = 0.25;
static const double BONE_REACH = 0.1; /* share of the muscle's box's diagonal within which a section shows bones */
/* A row whose ends are farther apart than its rest distance tells, by more than this share of the box's diagonal, is of another mesh. */
static const double SAME_PLACE = 1e-6;
static const sn_color COLOR_OUTLINE = {0.30, 0.28, 0.24}, COLOR_SLIDE = {0.13, 0.45, 0.85}, COLOR_SOFT = {0.10, 0.62, 0.30},
                      COLOR_HARD = {0.85, 0.12, 0.12}, COLOR_IDLE = {0.45, 0.45, 0.45};

static sn_status add_target_entry(sn_view *view, const sn_muscle *muscle, sn_index i, sn_view_mark mark, sn_error *error) {
    const sn_external *e = &muscle->externals[i];
    bool superficial = e->fascia && strcmp(e->fascia, "superficial") == 0;
    char text[192], detail[24];
    snprintf(text, sizeof text, "%s %s", superficial ? "held in by" : "faces", e->target);
    snprintf(detail, sizeof detail, "%d", e->count);
    return sn_view_add_entry_detail(view, mark, hue_color((size_t)i), text, detail, error);
}

/* ---- vertices by target -------------------------------------------------------------------------------------------------------- */

sn_status paint_externals(sn_view *view, sn_view_mesh *mesh, const sn_muscle *muscle, sn_error *error) {
    double *nearest = SN_NEW(double, mesh->vertex_count);
    mesh->paints = SN_NEW(sn_color, muscle->external_count);
    mesh->paint = SN_NEW(sn_index, mesh->vertex_count);
    sn_status status = nearest && mesh->paints && mesh->paint ? SN_OK : sn_fail_memory(error, "the neighbours' paint");
    for (sn_index v = 0; v < mesh->vertex_count && !status; v++) mesh->paint[v] = SN_NONE;
    if (!status) mesh->paint_count = muscle->external_count;
    for (sn_index i = 0; i < muscle->external_count && !status; i++) {
        const sn_external *e = &muscle->externals[i];
        mesh->paints[i] = hue_color((size_t)i);
        for (sn_index k = 0; k < e->count; k++) {
            sn_index v = e->vertices[k];
            double distance = fabs(e->distances[k]);
            if (mesh->paint[v] != SN_NONE && nearest[v] <= distance) continue;
            mesh->paint[v] = i;
            nearest[v] = distance;
        }
        status = add_target_entry(view, muscle, i, SN_MARK_AREA, error);
    }
    free(nearest);
    return status;
}

/* ---- rows ------------------------------------------------------------------------------------------------------------------------ */

static const sn_view_target *find_target(const sn_view_targets *targets, const char *name) {
    for (sn_index i = 0; i < targets->count; i++)
        if (strcmp(targets->items[i].name, name) == 0) return &targets->items[i];
    return NULL;
}

/* What rows are told apart by: 0 slide, 1 soft, 2 hard, whichever acts most; 3 none does. */
enum { ROW_TYPES = 4 };
static const sn_color *const row_colors[ROW_TYPES] = {&COLOR_SLIDE, &COLOR_SOFT, &COLOR_HARD, &COLOR_IDLE};

static int row_type(const sn_external *e, sn_index k) {
    double acts[3];
    int most = 0;
    sn_external_blend(&e->weights[3 * (size_t)k], acts);
    for (int w = 1; w < 3; w++)
        if (acts[w] > acts[most]) most = w;
    return acts[most] > 0.0 ? most : 3;
}

/* The point of the target, metres. SN_ERROR_INPUT where the target's mesh is not the one that the row was found on. */
static sn_status target_point(const sn_muscle *muscle, const sn_external *e, sn_index k, const sn_view_target *target, sn_vec3 *out,
                              sn_error *error) {
    sn_index triangle = e->triangles[k];
    double size = sn_box_diagonal(sn_mesh_box(&muscle->mesh)) * muscle->meters_per_unit;
    *out = (sn_vec3){0, 0, 0};
    for (int c = 0; c < 3 && triangle < target->mesh->triangle_count; c++)
        *out = sn_add_scaled(*out, target->mesh->positions[target->mesh->triangles[triangle].v[c]],
                             target->meters_per_unit * e->barycentric[3 * (size_t)k + (size_t)c]);
    double distance = sn_distance(*out, sn_scale(muscle->mesh.positions[e->vertices[k]], muscle->meters_per_unit));
    if (triangle < target->mesh->triangle_count && fabs(distance - fabs(e->distances[k]) * muscle->meters_per_unit) <= SAME_PLACE * size)
        return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "the rows on target \"%s\" were found on another mesh than that of its rig; find them anew",
                   e->target);
}

static sn_status add_row_entries(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    static const char *const texts[ROW_TYPES] = {"row: slide", "row: soft", "row: hard", "row without weight"};
    bool there[ROW_TYPES] = {false};
    sn_status status = SN_OK;
    for (sn_index i = 0; i < muscle->external_count; i++)
        for (sn_index k = 0; k < muscle->externals[i].count; k++) there[row_type(&muscle->externals[i], k)] = true;
    for (int type = 0; type < ROW_TYPES && !status; type++)
        if (there[type]) status = sn_view_add_entry(view, SN_MARK_LINE, *row_colors[type], texts[type], error);
    return status;
}

static sn_status add_target_mesh(sn_view *view, const sn_view_target *target, sn_index i, sn_error *error) {
    sn_view_mesh *mesh;
    sn_status status =
        sn_view_add_mesh(view, target->mesh, (sn_placement){target->meters_per_unit, NULL}, hue_color((size_t)i), &mesh, error);
    if (!status) mesh->opacity = TARGET_OPACITY;
    return status;
}

static sn_status add_rows(sn_view *view, const sn_muscle *muscle, sn_index i, const sn_view_target *target, sn_error *error) {
    const sn_external *e = &muscle->externals[i];
    sn_status status = target ? add_target_mesh(view, target, i, error) : SN_OK;
    for (sn_index k = 0; k < e->count && !status; k++) {
        sn_vec3 from = sn_scale(muscle->mesh.positions[e->vertices[k]], muscle->meters_per_unit), to = from;
        if (target) status = target_point(muscle, e, k, target, &to, error);
        double radius = target ? ROW_RADIUS : ROW_DOT_RADIUS;
        if (!status) status = sn_view_add_tube(view, (sn_view_tube){from, to, radius, *row_colors[row_type(e, k)]}, error);
    }
    return status;
}

sn_status sn_view_add_externals(sn_view *view, const sn_muscle *muscle, const sn_view_targets *targets, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < muscle->external_count && !status; i++)
        status = add_rows(view, muscle, i, find_target(targets, muscle->externals[i].target), error);
    return status ? status : add_row_entries(view, muscle, error);
}

/* ---- a section --------------------------------------------------------------------------------------------------------------------- */

typedef struct cut {
    const sn_view_section *section;
    sn_vec3 normal; /* unit */
} cut;

static double height(const cut *c, sn_vec3 p) { return sn_dot(sn_sub(p, c->section->point), c->normal); }
static sn_vec3 onto(const cut *c, sn_vec3 p) { return sn_add_scaled(p, c->normal, -height(c, p)); }

/* Where the plane cuts a surface. */
static sn_status add_outline(sn_view *view, const cut *c, const sn_mesh *mesh, double unit, sn_color color, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index t = 0; t < mesh->triangle_count && !status; t++) {
        sn_vec3 ends[3];
        int found = 0;
        for (int k = 0; k < 3; k++) {
            sn_vec3 a = sn_scale(mesh->positions[mesh->triangles[t].v[k]], unit),
                    b = sn_scale(mesh->positions[mesh->triangles[t].v[(k + 1) % 3]], unit);
            double ha = height(c, a), hb = height(c, b);
            if ((ha >= 0.0) != (hb >= 0.0)) ends[found++] = sn_add_scaled(a, sn_sub(b, a), ha / (ha - hb));
        }
        if (found == 2) status = sn_view_add_tube(view, (sn_view_tube){ends[0], ends[1], OUTLINE_RADIUS, color}, error);
    }
    return status;
}

/* Rows that start near the plane, drawn on it. */
static sn_status add_cut_rows(sn_view *view, const cut *c, const sn_muscle *muscle, sn_index i, const sn_view_target *target,
                              sn_error *error) {
    const sn_external *e = &muscle->externals[i];
    sn_status status = SN_OK;
    for (sn_index k = 0; k < e->count && !status; k++) {
        sn_vec3 from = sn_scale(muscle->mesh.positions[e->vertices[k]], muscle->meters_per_unit), to = from;
        if (fabs(height(c, from)) > c->section->depth) continue;
        if (target) status = target_point(muscle, e, k, target, &to, error);
        const sn_view_tube row = {onto(c, from), onto(c, to), target ? ROW_RADIUS : ROW_DOT_RADIUS, *row_colors[row_type(e, k)]};
        if (!status) status = sn_view_add_tube(view, row, error);
    }
    return status;
}

static sn_status add_cut_target(sn_view *view, const cut *c, sn_index i, sn_error *error) {
    const sn_muscle *muscle = c->section->muscle;
    const sn_view_target *target = find_target(c->section->targets, muscle->externals[i].target);
    size_t before = view->tube_count;
    sn_status status = SN_OK;
    if (target) status = add_outline(view, c, target->mesh, target->meters_per_unit, hue_color((size_t)i), error);
    if (!status) status = add_cut_rows(view, c, muscle, i, target, error);
    return status || view->tube_count == before ? status : add_target_entry(view, muscle, i, SN_MARK_LINE, error);
}

/* Far bones would make the picture small. */
static bool is_near(const sn_muscle *muscle, const sn_view_target *bone) {
    sn_box a = sn_mesh_box(&muscle->mesh), b = sn_mesh_box(bone->mesh);
    double most = BONE_REACH * sn_box_diagonal(a) * muscle->meters_per_unit;
    sn_vec3 above = sn_sub(sn_scale(b.low, bone->meters_per_unit), sn_scale(a.high, muscle->meters_per_unit));
    sn_vec3 below = sn_sub(sn_scale(a.low, muscle->meters_per_unit), sn_scale(b.high, bone->meters_per_unit));
    sn_vec3 apart = sn_max3(above, below);
    return apart.x <= most && apart.y <= most && apart.z <= most;
}

sn_status sn_view_add_section(sn_view *view, const sn_view_section *section, sn_error *error) {
    const sn_muscle *muscle = section->muscle;
    const cut c = {section, sn_normalize(section->normal)};
    sn_status status = add_outline(view, &c, &muscle->mesh, muscle->meters_per_unit, COLOR_MUSCLE, error);
    if (!status && view->tube_count == 0) return sn_fail(error, SN_ERROR_INPUT, "the plane of the section does not cut the muscle");
    if (!status) status = sn_view_add_entry(view, SN_MARK_LINE, COLOR_MUSCLE, muscle->name ? muscle->name : "the muscle", error);
    for (sn_index i = 0; i < section->bones->count && !status; i++)
        if (is_near(muscle, &section->bones->items[i]))
            status = add_outline(view, &c, section->bones->items[i].mesh, section->bones->items[i].meters_per_unit, COLOR_OUTLINE, error);
    for (sn_index i = 0; i < muscle->external_count && !status; i++) status = add_cut_target(view, &c, i, error);
    return status ? status : add_row_entries(view, muscle, error);
}
