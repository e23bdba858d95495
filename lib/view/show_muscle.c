/* show_muscle.c -- a muscle document as a picture: every section in the colours of [R18] figure 2. */
#include "show.h"

#include <stdio.h>
#include <stdlib.h>

enum { CONNECTIONS = 1500 };
static const double ROOT_RADIUS = 0.0045, BRANCH_RADIUS = 0.0034, SAMPLE_RADIUS = 0.0051, CONNECTION_RADIUS = 0.0006;
static const double SEEN_THROUGH = 0.30; /* opacity of a surface with something inside */

/* ---- words -------------------------------------------------------------------------------------------------------------------- */

typedef struct phrase {
    char text[256];
    int length;
} phrase;

/* ", 26 408 triangles": digits in threes from five digits on. */
static void phrase_count(phrase *p, int64_t count, const char *one, const char *many) {
    char digits[32];
    if (count >= 1000000)
        snprintf(digits, sizeof digits, "%d %03d %03d", (int)(count / 1000000), (int)(count / 1000 % 1000), (int)(count % 1000));
    else if (count >= 10000)
        snprintf(digits, sizeof digits, "%d %03d", (int)(count / 1000), (int)(count % 1000));
    else
        snprintf(digits, sizeof digits, "%d", (int)count);
    int room = (int)sizeof p->text - p->length;
    int written = snprintf(p->text + p->length, (size_t)room, "%s%s %s", p->length ? ", " : "", digits, count == 1 ? one : many);
    p->length += written < room ? written : room - 1;
}

static sn_index branch_count(const sn_structure *structure) {
    sn_index most = SN_NONE;
    for (sn_index i = 0; i < structure->sample_count; i++) most = structure->branches[i] > most ? structure->branches[i] : most;
    return most + 1;
}

static sn_status name_view(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    if (!view->title && muscle->name && !(view->title = sn_strdup(muscle->name))) return sn_fail_memory(error, "the title");
    if (view->subtitle) return SN_OK;
    phrase p = {{0}, 0};
    phrase_count(&p, muscle->mesh.vertex_count, "vertex", "vertices");
    phrase_count(&p, muscle->mesh.triangle_count, "triangle", "triangles");
    if (muscle->roots.count) phrase_count(&p, muscle->roots.count, "root", "roots");
    if (muscle->structure.sample_count) {
        phrase_count(&p, muscle->structure.sample_count, "sample", "samples");
        phrase_count(&p, branch_count(&muscle->structure), "branch", "branches");
    }
    if (muscle->has_attachments) phrase_count(&p, muscle->attachment_count, "attachment", "attachments");
    view->subtitle = sn_strdup(p.text);
    return view->subtitle ? SN_OK : sn_fail_memory(error, "the subtitle");
}

/* ---- sections ------------------------------------------------------------------------------------------------------------------- */

static sn_vec3 vertex(const sn_muscle *muscle, sn_index v) { return sn_scale(muscle->mesh.positions[v], muscle->meters_per_unit); }

static sn_status show_roots(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < muscle->roots.count && !status; i++) {
        sn_vec3 p = vertex(muscle, muscle->roots.vertices[i]);
        status = sn_view_add_tube(view, (sn_view_tube){p, p, ROOT_RADIUS, COLOR_ROOTS}, error);
    }
    return status ? status : sn_view_add_entry(view, SN_MARK_DOT, COLOR_ROOTS, "fibre roots", error);
}

static sn_status show_branches(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    const sn_structure *s = &muscle->structure;
    sn_status status = SN_OK;
    for (sn_index i = 0; i < s->sample_count && !status; i++) {
        sn_vec3 p = sn_scale(s->positions[i], muscle->meters_per_unit);
        status = sn_view_add_tube(view, (sn_view_tube){p, p, SAMPLE_RADIUS, COLOR_BRANCH}, error);
        if (status || s->parents[i] == SN_NONE) continue;
        sn_vec3 q = sn_scale(s->positions[s->parents[i]], muscle->meters_per_unit);
        status = sn_view_add_tube(view, (sn_view_tube){q, p, BRANCH_RADIUS, COLOR_BRANCH}, error);
    }
    return status ? status : sn_view_add_entry(view, SN_MARK_LINE, COLOR_BRANCH, "internal branches", error);
}

static sn_status show_connections(sn_view *view, const sn_muscle *muscle, sn_error *error) {
    sn_index count = 0, *marks = NULL;
    double spacing;
    sn_status status = spread_vertices(&muscle->mesh, CONNECTIONS, &count, &marks, &spacing, error);
    for (sn_index i = 0; i < count && !status; i++) {
        sn_index sample = muscle->structure.vertex_sample[marks[i]];
        if (sample == SN_NONE) continue;
        sn_vec3 from = sn_scale(muscle->structure.positions[sample], muscle->meters_per_unit);
        status = sn_view_add_tube(view, (sn_view_tube){from, vertex(muscle, marks[i]), CONNECTION_RADIUS, COLOR_CONNECTION}, error);
    }
    free(marks);
    if (status) return status;
    char detail[64];
    snprintf(detail, sizeof detail, "%d of %d", count, muscle->mesh.vertex_count);
    return sn_view_add_entry_detail(view, SN_MARK_LINE, COLOR_CONNECTION, "connections", count < muscle->mesh.vertex_count ? detail : NULL,
                                    error);
}

static sn_status show_attachments(sn_view *view, sn_view_mesh *mesh, const sn_muscle *muscle, sn_error *error) {
    mesh->paints = SN_NEW(sn_color, muscle->attachment_count);
    mesh->paint = SN_NEW(sn_index, mesh->vertex_count);
    if (!mesh->paints || !mesh->paint) return sn_fail_memory(error, "the attachments' paint");
    mesh->paint_count = muscle->attachment_count;
    for (sn_index v = 0; v < mesh->vertex_count; v++) mesh->paint[v] = SN_NONE;
    view->attachments_shown = true;
    sn_status status = SN_OK;
    for (sn_index i = 0; i < muscle->attachment_count && !status; i++) {
        const sn_attachment *a = &muscle->attachments[i];
        status = sn_palette_color(palette_of(view), a->bone, &mesh->paints[i], error);
        if (status) break;
        for (sn_index k = 0; k < a->count; k++) mesh->paint[a->vertices[k]] = i;
        char text[160], detail[16];
        snprintf(text, sizeof text, "on %s", a->bone);
        snprintf(detail, sizeof detail, "%d", a->count);
        status = sn_view_add_entry_detail(view, SN_MARK_AREA, mesh->paints[i], text, detail, error);
    }
    return status;
}

/* ---- the whole -------------------------------------------------------------------------------------------------------------------- */

/* What the document holds; where it holds fibre directions they are the newest, and the inside gives way to them. */
static unsigned automatic(const sn_muscle *muscle) {
    unsigned sections = sn_muscle_sections(muscle), show = SN_SHOW_SURFACE;
    if (sections & SN_SECTION_ROOTS) show |= SN_SHOW_ROOTS;
    if (sections & SN_SECTION_FIBERS) show |= SN_SHOW_FIBERS;
    if (sections & SN_SECTION_STRUCTURE && !(sections & SN_SECTION_FIBERS)) show |= SN_SHOW_STRUCTURE;
    if (sections & SN_SECTION_ATTACHMENTS) show |= SN_SHOW_ATTACHMENTS;
    return show;
}

static sn_status show_surface(sn_view *view, const sn_muscle *muscle, unsigned show, sn_color color, sn_error *error) {
    sn_view_mesh *mesh;
    sn_status status = sn_view_add_mesh(view, &muscle->mesh, (sn_placement){muscle->meters_per_unit, NULL}, color, &mesh, error);
    if (!status) status = name_mesh(view, muscle->name, error);
    if (status) return status;
    bool inside = show & SN_SHOW_STRUCTURE && muscle->structure.sample_count > 0;
    if (show & SN_SHOW_FIBERS && muscle->fibers.polyline_count > 0) inside = true;
    mesh->opacity = inside ? SEEN_THROUGH : 1.0;
    mesh->gloss = 0.6;
    mesh->wire = (show & SN_SHOW_WIRE) != 0;
    if (show & SN_SHOW_EXTERNALS) return paint_externals(view, mesh, muscle, error);
    return show & SN_SHOW_ATTACHMENTS ? show_attachments(view, mesh, muscle, error) : SN_OK;
}

sn_status show_rig(sn_view *view, const sn_muscle *muscle, unsigned show, sn_color color, sn_error *error) {
    sn_status status = SN_OK;
    if (show & (SN_SHOW_SURFACE | SN_SHOW_WIRE | SN_SHOW_ATTACHMENTS | SN_SHOW_EXTERNALS))
        status = show_surface(view, muscle, show, color, error);
    if (!status && show & SN_SHOW_ROOTS && muscle->roots.count > 0) status = show_roots(view, muscle, error);
    bool structure = show & SN_SHOW_STRUCTURE && muscle->structure.sample_count > 0;
    if (!status && structure) status = show_branches(view, muscle, error);
    if (!status && structure && muscle->structure.vertex_sample) status = show_connections(view, muscle, error);
    bool fibers = muscle->fibers.directions || muscle->fibers.polyline_count > 0;
    if (!status && show & SN_SHOW_FIBERS && fibers) status = show_fibers(view, muscle, error);
    return status;
}

sn_status sn_view_add_muscle(sn_view *view, const sn_muscle *muscle, unsigned show, sn_error *error) {
    if (show & SN_SHOW_AUTO) show |= automatic(muscle);
    sn_status status = name_view(view, muscle, error);
    return status ? status : show_rig(view, muscle, show, COLOR_MUSCLE, error);
}

sn_status sn_view_add_bone(sn_view *view, const char *name, const sn_mesh *mesh, sn_placement placement, sn_error *error) {
    sn_view_mesh *added;
    const sn_color color = bone_color(view, name);
    sn_status status = sn_view_add_mesh(view, mesh, placement, color, &added, error);
    if (status) return status;
    added->gloss = 0.25;
    status = name_mesh(view, name, error);
    return name && !status ? sn_view_add_entry(view, SN_MARK_AREA, color, name, error) : status;
}
