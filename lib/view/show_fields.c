/* show_fields.c -- the distance fields of a scene's bones, as sections through their middles: inside, outside, and lines of equal distance.
 */
#include "show.h"

#include "sinew/distance_field.h"

#include <stdlib.h>

enum { SECTION_CELLS = 240 }; /* along the longer side */
/* Cells of a field along a bone's diagonal, where the scene leaves them open; lines of equal distance in a section. */
static const double FIELD_CELLS = 200.0, SECTION_LINES = 16.0;
static const sn_color COLOR_INSIDE = {0.20, 0.38, 0.74}, COLOR_OUTSIDE = {0.95, 0.62, 0.24}, COLOR_BORDER = {0.10, 0.10, 0.12};
/* Room around a bone, as a share of its diagonal. */
static const double AROUND = 0.06;

/* A plane of a bone's frame: from a corner along two axes. */
typedef struct section {
    sn_vec3 corner, along, across; /* along: the longest side of the bone's box; the third axis is its shortest */
    sn_index columns, rows;
} section;

static double part(sn_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static sn_vec3 unit(int axis) { return sn_v3(axis == 0, axis == 1, axis == 2); }

static section section_of(const sn_box *box) {
    sn_vec3 size = sn_sub(box->high, box->low), room = sn_scale(sn_v3(1, 1, 1), AROUND * sn_norm(size));
    int longest = 0, shortest = 0;
    for (int i = 1; i < 3; i++) {
        if (part(size, i) > part(size, longest)) longest = i;
        if (part(size, i) <= part(size, shortest)) shortest = i;
    }
    if (shortest == longest) shortest = (longest + 1) % 3;
    int other = 3 - longest - shortest;
    double length = part(size, longest) + 2.0 * room.x, width = part(size, other) + 2.0 * room.x;
    sn_vec3 corner = sn_sub(box->low, room);
    double lift = 0.5 * (part(box->low, shortest) + part(box->high, shortest)) - part(corner, shortest);
    return (section){.corner = sn_add_scaled(corner, unit(shortest), lift),
                     .along = sn_scale(unit(longest), length),
                     .across = sn_scale(unit(other), width),
                     .columns = SECTION_CELLS + 1,
                     .rows = (sn_index)ceil(SECTION_CELLS * width / length) + 1};
}

static sn_status make_sheet(const section *s, sn_mesh *out, sn_error *error) {
    sn_status status = sn_mesh_alloc(out, s->columns * s->rows, 2 * (s->columns - 1) * (s->rows - 1), error);
    if (status) return status;
    for (sn_index r = 0; r < s->rows; r++)
        for (sn_index c = 0; c < s->columns; c++)
            out->positions[r * s->columns + c] =
                sn_add_scaled(sn_add_scaled(s->corner, s->along, c / (s->columns - 1.0)), s->across, r / (s->rows - 1.0));
    sn_triangle *t = out->triangles;
    for (sn_index r = 0; r + 1 < s->rows; r++)
        for (sn_index c = 0; c + 1 < s->columns; c++) {
            sn_index a = r * s->columns + c, b = a + s->columns;
            *t++ = (sn_triangle){{a, a + 1, b + 1}};
            *t++ = (sn_triangle){{a, b + 1, b}};
        }
    return SN_OK;
}

/* Darker at each line of equal distance; the surface itself is black. */
static sn_color color_at(double phi, double step, double width) {
    sn_color base = phi < 0.0 ? COLOR_INSIDE : COLOR_OUTSIDE;
    if (fabs(phi) < 0.5 * width) return COLOR_BORDER;
    double line = fabs(phi) / step, off = fabs(line - floor(line + 0.5)) * step, light = off < 0.5 * width ? 0.72 : 1.0;
    double pale = 0.55 * fmin(fabs(phi) / (0.5 * SECTION_LINES * step), 1.0);
    return (sn_color){light * (base.r + pale * (1.0 - base.r)), light * (base.g + pale * (1.0 - base.g)),
                      light * (base.b + pale * (1.0 - base.b))};
}

static sn_status add_section(sn_view *view, const sn_distance_field *field, const sn_rigid *pose, sn_error *error) {
    section s = section_of(&field->box);
    sn_mesh sheet = {0};
    sn_view_mesh *shown = NULL;
    double width = sn_norm(s.along) / SECTION_CELLS, step = sn_norm(s.across) / SECTION_LINES;
    sn_status status = make_sheet(&s, &sheet, error);
    if (!status) status = sn_view_add_mesh(view, &sheet, (sn_placement){1.0, pose}, COLOR_INSIDE, &shown, error);
    if (!status && !(shown->colors = SN_NEW(sn_color, sheet.vertex_count))) status = sn_fail_memory(error, "a section");
    for (sn_index v = 0; !status && v < sheet.vertex_count; v++)
        shown->colors[v] = color_at(sn_distance_field_at(field, sheet.positions[v], NULL), step, width);
    sn_mesh_free(&sheet);
    return status;
}

static sn_status show_field_of(sn_view *view, const sn_scene *scene, sn_index bone, const sn_rigid *pose, sn_error *error) {
    const sn_scene_bone *source = &scene->bones[bone];
    sn_mesh mesh = {0};
    sn_distance_field field = {0};
    sn_status status = sn_mesh_copy(&source->mesh, &mesh, error);
    for (sn_index v = 0; !status && v < mesh.vertex_count; v++) mesh.positions[v] = sn_scale(mesh.positions[v], source->meters_per_unit);
    double cell = scene->contact.cell > 0.0 ? scene->contact.cell : sn_box_diagonal(sn_mesh_box(&mesh)) / FIELD_CELLS;
    sn_distance_field_params params = sn_distance_field_defaults(cell);
    if (!status) status = sn_distance_field_create(&mesh, &params, &field, error);
    if (!status) status = add_section(view, &field, pose, error);
    sn_distance_field_free(&field);
    sn_mesh_free(&mesh);
    if (!status || !error) return status;
    sn_error why = *error;
    return sn_fail(error, status, "bone \"%s\": %s", source->name, why.text);
}

sn_status show_distance_fields(sn_view *view, const sn_scene *scene, double time, sn_error *error) {
    sn_rigid *poses = SN_NEW(sn_rigid, scene->motion.joint_count);
    if (!poses) return sn_fail_memory(error, "the joints' poses");
    sn_motion_poses(&scene->motion, time, poses);
    sn_status status = SN_OK;
    for (sn_index b = 0; b < scene->bone_count && !status; b++) {
        const sn_scene_bone *bone = &scene->bones[b];
        if (bone->passable || bone->mesh.triangle_count == 0) continue;
        status = show_field_of(view, scene, b, bone->joint == SN_NONE ? NULL : &poses[bone->joint], error);
    }
    free(poses);
    if (!status) status = sn_view_add_entry(view, SN_MARK_AREA, COLOR_INSIDE, "inside of a bone", error);
    if (!status) status = sn_view_add_entry(view, SN_MARK_AREA, COLOR_OUTSIDE, "outside", error);
    return status;
}
