/*
 * attach-detect.c -- find the vertices of a muscle that move with each bone.
 */
#include "bones.h"
#include "cli.h"
#include "grips.h"
#include "neighbours.h"
#include "selector.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const method_names[] = {"both", "contact", "proximity", "area", "none", NULL};
static const unsigned method_bits[] = {SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY, SN_ATTACH_CONTACT, SN_ATTACH_PROXIMITY, 0, 0};
enum { METHOD_AREA = 3, METHOD_NONE = 4 };
static const char *const pair_names[] = {"nearby", "all", NULL};

static cli_list bone_texts, list_files, pin_texts;
static int method, pairs, area_kind, bone_unit = -1, bone_up; /* bone_unit -1: the muscle's */
static sn_length distance = {-1.0, 0.0}, pair_distance = {-1.0, 0.0}, landmark_distance = {-1.0, 0.0}, line_width = {-1.0, 0.0};
static int64_t voxels;
static bool raw;
static const char *landmark_file;
static neighbour_request neighbours = {.reach = {-1.0, 0.0}, .minimum = {-1.0, 0.0}, .tendon = {-1.0, 0.0}, .targets = 2, .hold = 1};
static int tendons;
static const char *const tendon_names[] = {"soft", "hard", NULL};

static const cli_option options[] = {
    {.kind = CLI_HEADING, .help = "Bones:"},
    {'b', "bone", "[NAME=]FILE", CLI_LIST, &bone_texts, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "a bone's mesh, any number of times, taken as meant; NAME is the file's base name by default"},
    {0, "bones", "LIST", CLI_LIST, &list_files, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "a text file with a bone a line: FILE, or NAME, a tab and FILE, relative to LIST; or a folder of meshes"},
    {0, "pairs", "RULE", CLI_CHOICE, &pairs, CLI_RESULT, 0, 0, pair_names,
     "which bones of LIST may hold vertices: nearby (in the muscle, or 0.8 % of its area near; default), all"},
    {0, "pair-distance", "LENGTH", CLI_LENGTH, &pair_distance, CLI_RESULT, 0, 0, NULL, "what is near for --pairs nearby (default 2mm)"},
    {0, "bone-units", "UNIT", CLI_CHOICE, &bone_unit, CLI_RESULT, 0, 0, cli_unit_names,
     "unit of the bones and landmarks: m, cm or mm (default: the muscle's)"},
    {0, "bone-up", "AXIS", CLI_CHOICE, &bone_up, CLI_RESULT, 0, 0, cli_up_names,
     "up axis of the bones and landmarks: z, or y, turned to z (default: as --up)"},
    {.kind = CLI_HEADING, .help = "Which vertices:"},
    {0, "pin", "NAME=SELECTOR", CLI_LIST, &pin_texts, CLI_RESULT, 0, 0, NULL,
     "attach the selected vertices to bone NAME, which needs no mesh, before all else"},
    {0, "landmarks", "FILE", CLI_TEXT, &landmark_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "attachment areas by landmarks around them, or along a line: lines of bone, area, x, y, z with tabs, or JSON"},
    {0, "landmark-distance", "LENGTH", CLI_LENGTH, &landmark_distance, CLI_RESULT, 0, 0, NULL,
     "an area with a landmark farther from the muscle is left out (default 10mm)"},
    {0, "area-kind", "KIND", CLI_CHOICE, &area_kind, CLI_RESULT, 0, 0, sn_area_kind_names,
     "what the landmarks of an area are: a boundary that closes, a line, or either, as they lie (auto; default)"},
    {0, "line-width", "LENGTH", CLI_LENGTH, &line_width, CLI_RESULT, 0, 0, NULL,
     "width of an area along a line (default: the mean distance of its landmarks from the muscle)"},
    {'m', "method", "METHOD", CLI_CHOICE, &method, CLI_RESULT, 0, 0, method_names,
     "for bones without areas: contact (on or in the bone), proximity (closer than --distance), both (default); area and none: nothing"},
    {'d', "distance", "LENGTH", CLI_LENGTH, &distance, CLI_RESULT, 0, 0, NULL,
     "reach of proximity (default: 0.1 mean edge lengths with contact, 1 alone)"},
    {0, "voxels", "N", CLI_INTEGER, &voxels, CLI_RESULT, 1, 134217728, NULL,
     "contact also in the cells that the bone's surface runs through, of about N in its box"},
    {0, "raw", NULL, CLI_FLAG, &raw, CLI_RESULT, 0, 0, NULL,
     "keep the vertices as the rules found them: no patches, no tips that touch nothing, and what slides stays"},
    {.kind = CLI_HEADING, .help = "Neighbours, for external constraints:"},
    {0, "glue", "[NAME=]FILE", CLI_LIST, &neighbours.glue, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "another muscle (document or mesh), any number of times: find where the surfaces face each other"},
    {0, "muscles", "LIST", CLI_LIST, &neighbours.lists, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "a folder of rigs (*.muscle.json), or a text file with a muscle a line: FILE, or NAME, a tab and FILE; those near by box are "
     "searched"},
    {0, "envelope", "[NAME=]FILE", CLI_TEXT, &neighbours.envelope, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "a mesh that envelops the skeleton: the same, and it holds in what faces nothing else"},
    {0, "skeleton", "[NAME=]FILE", CLI_TEXT, &neighbours.envelope, CLI_RESULT | CLI_FILE, 0, 0, NULL, "the same as --envelope"},
    {0, "reach", "LENGTH", CLI_LENGTH, &neighbours.reach, CLI_RESULT, 0, 0, NULL, "how far a neighbour may be (default 5mm)"},
    {0, "targets", "N", CLI_INTEGER, &neighbours.targets, CLI_RESULT, 0, 1000, NULL,
     "most neighbours of a vertex, the nearest that it faces; 0: all (default 2)"},
    {0, "obstacles", "LIST", CLI_LIST, &neighbours.obstacles, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "bones, as for --bones, that hide neighbours behind them as the bones given for attachments do"},
    {0, "hidden", NULL, CLI_FLAG, &neighbours.hidden, CLI_RESULT, 0, 0, NULL, "keep neighbours that lie behind another muscle or a bone"},
    {0, "minimum-distance", "LENGTH", CLI_LENGTH, &neighbours.minimum, CLI_RESULT, 0, 0, NULL,
     "what is kept from a neighbour, where it is so at rest (default 0)"},
    {0, "weights", "SOURCE", CLI_CHOICE, &neighbours.source, CLI_RESULT, 0, 0, weight_source_names,
     "uniform: --slide, --soft, --hard (default); painted: maps of these names; rule: tendons are held, bellies slide"},
    {0, "slide", "W", CLI_TEXT, &neighbours.weights[0], CLI_RESULT, 0, 0, NULL,
     "weight of sliding: 0 to 1, or the name of a painted map (default 1)"},
    {0, "soft", "W", CLI_TEXT, &neighbours.weights[1], CLI_RESULT, 0, 0, NULL, "weight of the soft constraint (default 0)"},
    {0, "hard", "W", CLI_TEXT, &neighbours.weights[2], CLI_RESULT, 0, 0, NULL, "weight of the hard constraint (default 0)"},
    {0, "tendons", "TYPE", CLI_CHOICE, &tendons, CLI_RESULT, 0, 0, tendon_names, "how --weights rule holds tendons: soft (default), hard"},
    {0, "tendon-length", "LENGTH", CLI_LENGTH, &neighbours.tendon, CLI_RESULT, 0, 0, NULL,
     "how far from attachments --weights rule sees tendon (default: a tenth of the muscle's length)"},
};

static const cli_tool tool = {
    .name = "attach-detect",
    .summary = "Find the vertices of a muscle that move with each bone.",
    .shared = CLI_CHAIN | CLI_HAS_THREADS,
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .writes = CLI_WRITES_MUSCLE,
    .notes = "SELECTOR: indices:3,4,5  near:x,y,z[,n]  sphere:x,y,z,r  box:x0,y0,z0,x1,y1,z1  plane:px,py,pz,nx,ny,nz\n"
             "          half:px,py,pz,nx,ny,nz  painted:NAME[>T]; in the document's unit",
};

/* ---- what is asked for ------------------------------------------------------------------------------------------------ */

static bool wants_attachments(void) { return bone_texts.count > 0 || list_files.count > 0 || pin_texts.count > 0 || landmark_file != NULL; }

static bool wants_neighbours(void) { return neighbours_wanted(&neighbours); }

/* ---- pins ------------------------------------------------------------------------------------------------------------- */

typedef struct pin_list {
    int count;
    char **bones;        /* (count) their names */
    sn_attach_pin *pins; /* (count) what the library sees */
    selector *selectors; /* (count) */
} pin_list;

static void free_pins(pin_list *list) {
    for (int i = 0; i < list->count; i++) {
        free(list->bones[i]);
        selector_free(&list->selectors[i]);
    }
    free(list->bones);
    free(list->pins);
    free(list->selectors);
}

static sn_status parse_pins(const cli *c, pin_list *list, sn_error *error) {
    list->bones = SN_NEW(char *, pin_texts.count);
    list->pins = SN_NEW(sn_attach_pin, pin_texts.count);
    list->selectors = SN_NEW(selector, pin_texts.count);
    if (list->bones == NULL || list->pins == NULL || list->selectors == NULL) return sn_fail_memory(error, "the pins");
    for (int i = 0; i < pin_texts.count; i++) {
        char **name = &list->bones[i];
        const char *text = NULL;
        sn_error reason = {0};
        if (!cli_split(pin_texts.items[i], name, &text)) cli_usage_error(c, "--pin %s: write NAME=SELECTOR", pin_texts.items[i]);
        sn_status status = selector_parse(text, &list->selectors[i], &reason);
        list->pins[i] = (sn_attach_pin){.bone = *name, .selector = list->selectors[i].rule};
        list->count++;
        if (status == SN_ERROR_USAGE) cli_usage_error(c, "--pin %s: %s", *name, reason.text);
        if (status != SN_OK) return sn_fail_memory(error, "the pins");
    }
    return SN_OK;
}

/* ---- landmarks -------------------------------------------------------------------------------------------------------- */

/* Into the muscle's unit, z up. */
static void convert_landmarks(const bone_list *bones, double meters_per_unit, sn_landmarks *landmarks) {
    double unit = landmarks->meters_per_unit > 0.0 ? landmarks->meters_per_unit : bones->given_unit;
    double scale = unit > 0.0 ? unit / meters_per_unit : 1.0;
    for (sn_index a = 0; a < landmarks->count; a++)
        for (sn_index i = 0; i < landmarks->areas[a].count; i++) {
            sn_vec3 *p = &landmarks->areas[a].landmarks[i];
            if (bones->up_y) *p = sn_v3(p->x, -p->z, p->y);
            *p = sn_scale(*p, scale);
        }
}

static sn_status load_landmarks(const bone_list *bones, const sn_muscle *muscle, sn_landmarks *out, sn_error *error) {
    if (landmark_file == NULL) return SN_OK;
    sn_status status = sn_landmarks_read(landmark_file, out, error);
    if (status == SN_OK) status = cli_check_space(muscle, out->space, landmark_file, error);
    if (status == SN_OK) convert_landmarks(bones, muscle->meters_per_unit, out);
    return status;
}

/* ---- the report ------------------------------------------------------------------------------------------------------- */

typedef struct outcome {
    bone_list bones;
    sn_landmarks landmarks;
    const sn_muscle *muscle;
    sn_attach_report report;
    neighbour_result neighbours;
} outcome;

static double mean(const double *values, sn_index count) {
    double sum = 0.0;
    for (sn_index i = 0; i < count && values != NULL; i++) sum += values[i];
    return values != NULL && count > 0 ? sum / count : NAN;
}

static void write_attachments(sn_json *json, const sn_muscle *muscle) {
    sn_json_array(json, "attachments");
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        const sn_attachment *a = &muscle->attachments[i];
        sn_json_object(json, NULL);
        sn_json_text(json, "bone", a->bone);
        if (a->end != SN_END_UNKNOWN) sn_json_text(json, "end", sn_attachment_end_names[a->end]);
        sn_json_text(json, "method", a->method);
        sn_json_integer(json, "vertices", a->count);
        sn_json_number(json, "confidence", mean(a->confidence, a->count));
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_change(sn_json *json, const char *name, const sn_attach_change *change) {
    sn_json_object(json, name);
    sn_json_integer(json, "vertices", change->vertices);
    sn_json_number(json, "area", change->area);
    sn_json_close(json);
}

static void write_patch(sn_json *json, const sn_attach_pair *pair) {
    sn_json_bool(json, "tip", pair->tip);
    write_change(json, "slid", &pair->slid);
    sn_json_integer(json, "piecesBefore", pair->patch.pieces_before);
    sn_json_integer(json, "pieces", pair->patch.pieces);
    sn_json_integer(json, "holesBefore", pair->patch.holes_before);
    sn_json_integer(json, "holes", pair->patch.holes);
    write_change(json, "filled", &pair->patch.filled);
    write_change(json, "dropped", &pair->patch.dropped);
    write_change(json, "moved", &pair->patch.moved);
}

static void write_pair(sn_json *json, const outcome *o, const sn_attach_pair *pair) {
    sn_json_object(json, NULL);
    sn_json_text(json, "bone", o->bones.items[pair->bone].name);
    sn_json_integer(json, "vertices", pair->vertices);
    sn_json_number(json, "nearest", pair->nearest);
    sn_json_bool(json, "culled", pair->culled);
    if (!pair->culled) {
        sn_json_bool(json, "nearby", pair->nearby);
        if (isfinite(pair->area_share)) sn_json_number(json, "areaShare", pair->area_share);
        if (isfinite(pair->position)) sn_json_number(json, "position", pair->position);
        if (isfinite(pair->girth)) sn_json_number(json, "girth", pair->girth);
        if (isfinite(pair->position)) sn_json_bool(json, "looksSliding", pair->sliding);
        if ((isfinite(pair->position) || pair->tip) && !raw) write_patch(json, pair);
    }
    sn_json_close(json);
}

static void write_area(sn_json *json, const outcome *o, const sn_attach_area *area) {
    const sn_landmark_area *given = &o->landmarks.areas[area->area];
    sn_json_object(json, NULL);
    sn_json_text(json, "bone", given->bone);
    sn_json_text(json, "area", given->name);
    sn_json_integer(json, "landmarks", given->count);
    sn_json_integer(json, "vertices", area->vertices);
    sn_json_number(json, "areaShare", area->area_share);
    sn_json_number(json, "boundary", area->boundary);
    sn_json_number(json, "farthest", area->farthest);
    sn_json_bool(json, "leftOut", area->left_out);
    sn_json_bool(json, "reordered", area->reordered);
    sn_json_bool(json, "coarse", area->coarse);
    if (area->end != SN_END_UNKNOWN) sn_json_text(json, "end", sn_attachment_end_names[area->end]);
    sn_json_bool(json, "endDoubtful", area->end_doubtful);
    if (!area->left_out) write_change(json, "lost", &area->lost);
    if (!area->left_out) sn_json_text(json, "kind", sn_area_kind_names[area->line ? SN_AREA_LINE : SN_AREA_BOUNDARY]);
    if (!area->left_out) sn_json_bool(json, "doubtful", area->doubtful);
    if (area->line) sn_json_number(json, "width", area->width);
    if (area->line) sn_json_number(json, "meanWidth", area->mean_width);
    sn_json_close(json);
}

static void write_report(sn_json *json, const void *data) {
    const outcome *o = data;
    sn_json_text(json, "method", method_names[method]);
    sn_json_number(json, "distance", o->report.distance);
    sn_json_number(json, "pairDistance", o->report.pair_distance);
    sn_json_number(json, "metersPerUnit", o->muscle->meters_per_unit);
    sn_json_integer(json, "vertices", o->muscle->mesh.vertex_count);
    sn_json_integer(json, "attached", o->report.attached);
    write_attachments(json, o->muscle);
    sn_json_array(json, "areas");
    for (sn_index i = 0; i < o->report.area_count; i++) write_area(json, o, &o->report.areas[i]);
    sn_json_close(json);
    sn_json_array(json, "pairs");
    for (sn_index i = 0; i < o->report.pair_count; i++) write_pair(json, o, &o->report.pairs[i]);
    sn_json_close(json);
    if (wants_neighbours()) neighbours_write(json, &o->neighbours, o->muscle);
}

static const char *area_name(const outcome *o, const sn_attach_area *area) {
    const sn_landmark_area *given = &o->landmarks.areas[area->area];
    return given->name != NULL ? given->name : given->bone;
}

static void say_area(const cli *c, const outcome *o, const sn_attach_area *area) {
    double mm = 1e3 * o->muscle->meters_per_unit;
    const char *name = area_name(o, area);
    if (area->line)
        cli_say(c, "area %s: a line %.3g mm long, its band %.3g mm wide", name, area->boundary * mm, area->mean_width * mm);
    else if (!area->left_out)
        cli_say(c, "area %s: a boundary %.3g mm long", name, area->boundary * mm);
}

/* What became of what the rules found. */
static void say_pair(const cli *c, const outcome *o, const sn_attach_pair *pair) {
    const sn_attach_patch *p = &pair->patch;
    const char *bone_name = o->bones.items[pair->bone].name;
    double mm = 1e3 * o->muscle->meters_per_unit, mm2 = mm * mm;
    if (p->filled.vertices + p->dropped.vertices + p->moved.vertices > 0)
        cli_say(
            c,
            "%s: %d pieces with %d holes became %d with %d: %d vertices (%.3g mm2) filled, %d (%.3g mm2) dropped, %d (%.3g mm2) moved at "
            "borders",
            bone_name, (int)p->pieces_before, (int)p->holes_before, (int)p->pieces, (int)p->holes, (int)p->filled.vertices,
            p->filled.area * mm2, (int)p->dropped.vertices, p->dropped.area * mm2, (int)p->moved.vertices, p->moved.area * mm2);
    if (pair->slid.vertices > 0)
        cli_say(c, "%s: %d vertices (%.3g mm2) let go, as a tendon slides there", bone_name, (int)pair->slid.vertices,
                pair->slid.area * mm2);
    if (pair->tip) cli_say(c, "%s: the tip that runs to it, %.3g mm away", bone_name, pair->nearest * mm);
}

static void say_results(const cli *c, const outcome *o) {
    const sn_muscle *muscle = o->muscle;
    for (sn_index i = 0; i < muscle->attachment_count && wants_attachments(); i++) {
        const sn_attachment *a = &muscle->attachments[i];
        const char *end = a->end != SN_END_UNKNOWN ? sn_attachment_end_names[a->end] : NULL;
        cli_say(c, "%s: %ld vertices by %s%s%s", a->bone, (long)a->count, a->method, end != NULL ? ", " : "", end != NULL ? end : "");
    }
    for (sn_index i = 0; i < o->report.pair_count; i++) say_pair(c, o, &o->report.pairs[i]);
    for (sn_index i = 0; i < o->report.area_count; i++) say_area(c, o, &o->report.areas[i]);
    if (wants_neighbours()) neighbours_say(c, &o->neighbours, muscle);
}

/* ---- warnings --------------------------------------------------------------------------------------------------------- */

static void warn_of_line(const cli *c, const char *name, const sn_attach_area *area, double mm) {
    if (area->coarse)
        cli_warn(c, "area %s: it is a line %.3g mm wide, and its band is %.3g mm wide on average: the mesh is coarser than the line", name,
                 area->width * mm, area->mean_width * mm);
    if (area->doubtful)
        cli_warn(c, "area %s: its landmarks were taken for a line that bends back; where they go around an area, give --area-kind boundary",
                 name);
    if (area->reordered) cli_warn(c, "area %s: its landmarks are not in their order along the line; they were put into it", name);
}

static void warn_of_boundary(const cli *c, const char *name, const sn_attach_area *area) {
    if (area->reordered)
        cli_warn(c, "area %s: its boundary crosses itself in the order given; the landmarks were put into the order of the shortest tour",
                 name);
    if (area->coarse)
        cli_warn(c, "area %s: its boundary encloses no vertex; the nearest vertex of each landmark was taken; a finer mesh would help",
                 name);
    if (area->doubtful)
        cli_warn(c,
                 "area %s: its boundary was closed by more than twice its longest step; where the landmarks are a line, give --area-kind "
                 "line",
                 name);
}

/* What pins and areas before it have of an area. */
static void warn_of_overlap(cli *c, const outcome *o, const sn_attach_area *area) {
    const char *name = area_name(o, area), *bone_name = o->landmarks.areas[area->area].bone;
    char holder[160] = "pins";
    int lost = (int)area->lost.vertices, all = (int)area->vertices;
    if (lost == 0) return;
    if (area->lost_to != SN_NONE) {
        const sn_landmark_area *other = &o->landmarks.areas[area->lost_to];
        snprintf(holder, sizeof holder, "area %.60s on bone %.60s", other->name != NULL ? other->name : "(no name)", other->bone);
    }
    if (lost == all)
        cli_shortfall(c, "area %s on bone %s holds nothing: all of its %d vertices stay with %s, which comes first", name, bone_name, all,
                      holder);
    else
        cli_warn(c, "area %s on bone %s: %d of its %d vertices stay with %s, which comes first", name, bone_name, lost, all, holder);
}

static void warn_of_end(const cli *c, const outcome *o, const sn_attach_area *area) {
    if (area->end_doubtful)
        cli_warn(c, "area %s on bone %s: its name is taken for no end of the muscle; where it is one, call it origin or insertion",
                 area_name(o, area), o->landmarks.areas[area->area].bone);
}

static void warn_of_area(cli *c, const outcome *o, const sn_attach_area *area) {
    const char *name = area_name(o, area);
    double mm = 1e3 * o->muscle->meters_per_unit;
    if (area->left_out) {
        cli_shortfall(c,
                      "area %s on bone %s is left out, and the bone holds nothing by it: landmark %d lies %.3g mm off the muscle, and the "
                      "limit is %.3g mm; raise it with --landmark-distance, or correct the landmark",
                      name, o->landmarks.areas[area->area].bone, (int)area->far + 1, area->farthest * mm, o->report.landmark_reach * mm);
        return;
    }
    warn_of_overlap(c, o, area);
    warn_of_end(c, o, area);
    if (area->line)
        warn_of_line(c, name, area, mm);
    else
        warn_of_boundary(c, name, area);
    if (area->area_share > 0.3)
        cli_warn(c, "area %s: it is %.0f %% of the muscle's surface; does its boundary run around the muscle, not around a patch of it?",
                 name, 100.0 * area->area_share);
}

static void warn_of_areas(cli *c, const outcome *o) {
    for (sn_index i = 0; i < o->report.area_count; i++) warn_of_area(c, o, &o->report.areas[i]);
}

static const char *name_of(const outcome *o) { return o->muscle->name != NULL ? o->muscle->name : "(no name)"; }

/* The names of the bones of some pairs, in one line. */
static void name_pairs(const outcome *o, bool (*is_meant)(const sn_attach_pair *pair), char names[512]) {
    size_t used = 0, size = 512;
    names[0] = '\0';
    for (sn_index i = 0; i < o->report.pair_count && used < size; i++) {
        const sn_attach_pair *pair = &o->report.pairs[i];
        if (is_meant(pair))
            used += (size_t)snprintf(names + used, size - used, "%s%s", used > 0 ? ", " : "", o->bones.items[pair->bone].name);
    }
    if (used >= size) memcpy(names + size - 6, ", ...", 6);
}

static bool pair_slides(const sn_attach_pair *pair) { return pair->sliding; }
static bool pair_is_tip(const sn_attach_pair *pair) { return pair->tip; }

static void warn_of_sliding(const cli *c, const outcome *o) {
    char names[512];
    name_pairs(o, pair_slides, names);
    if (names[0] == '\0') return;
    if (raw)
        cli_warn(
            c,
            "muscle \"%s\": what it holds looks like a tendon that slides over: %s; where it does, leave the bone out, or give its area "
            "by landmarks",
            name_of(o), names);
    else
        cli_warn(
            c,
            "muscle \"%s\": a tendon looks as if it slides over: %s; what it touches there was let go; where it attaches, give its area by "
            "landmarks, or --raw",
            name_of(o), names);
}

static void warn_of_tips(const cli *c, const outcome *o) {
    char names[512];
    name_pairs(o, pair_is_tip, names);
    if (names[0] != '\0')
        cli_warn(c, "muscle \"%s\": it runs to %s and touches nothing there; its tip was taken, with low confidence", name_of(o), names);
}

/* The unit in which a bone's box would meet the muscle's where it does not now; -1 = none. */
static int fitting_unit(const outcome *o, const bone *b) {
    sn_box muscle = sn_mesh_box(&o->muscle->mesh), now = sn_mesh_box(&b->mesh);
    if (sn_box_gap(muscle, now) == 0.0) return -1;
    for (int unit = 0; cli_unit_names[unit] != NULL; unit++) {
        double factor = cli_unit_meters[unit] / o->muscle->meters_per_unit / b->scale;
        sn_box box = {sn_scale(now.low, factor), sn_scale(now.high, factor)};
        if (sn_box_gap(muscle, box) == 0.0 && sn_box_diagonal(box) < 1e3 * sn_box_diagonal(muscle)) return unit;
    }
    return -1;
}

/* Nothing found: what would help. */
static void warn_nothing(const cli *c, const outcome *o) {
    const sn_attach_pair *nearest = NULL;
    for (sn_index i = 0; i < o->report.pair_count; i++) {
        const sn_attach_pair *pair = &o->report.pairs[i];
        int unit = pair->culled ? fitting_unit(o, &o->bones.items[pair->bone]) : -1;
        if (unit >= 0) {
            cli_warn(c, "muscle \"%s\": nothing attached; the bones lie far from the muscle, but would meet it with --bone-units %s",
                     name_of(o), cli_unit_names[unit]);
            return;
        }
        if (nearest == NULL || pair->nearest < nearest->nearest) nearest = pair;
    }
    if (nearest == NULL) {
        cli_warn(c, "muscle \"%s\": nothing attached: no bone was looked at", name_of(o));
        return;
    }
    double millimetres = nearest->nearest * o->muscle->meters_per_unit * 1e3;
    const char *bone_name = o->bones.items[nearest->bone].name;
    if (nearest->culled)
        cli_warn(
            c,
            "muscle \"%s\": nothing attached; the nearest bone, %s, is at least %.3g mm away: check --bone-units and --units, or raise "
            "--distance",
            name_of(o), bone_name, millimetres);
    else
        cli_warn(c, "muscle \"%s\": nothing attached; the nearest bone, %s, is %.3g mm away: a larger --distance would reach it%s",
                 name_of(o), bone_name, millimetres, nearest->nearby ? "" : ", with --pairs all");
}

/* Contact asks what is inside of a bone. */
static sn_status warn_of_bones(const outcome *o, sn_error *error) {
    sn_status status = SN_OK;
    for (size_t i = 0; i < o->bones.count && status == SN_OK && (method_bits[method] & SN_ATTACH_CONTACT); i++)
        if (o->bones.items[i].used) status = sn_mesh_warn_of_sides(&o->bones.items[i].mesh, o->bones.items[i].name, error);
    return status;
}

static sn_status warn(cli *c, const outcome *o, bool stopped, sn_error *error) {
    sn_status status = warn_of_bones(o, error);
    if (status != SN_OK) return status;
    warn_of_areas(c, o);
    warn_of_sliding(c, o);
    warn_of_tips(c, o);
    if (!wants_attachments() || stopped) return SN_OK;
    if (o->report.attached == 0) warn_nothing(c, o);
    return grips_warn(c, o->muscle->name, o->muscle, error);
}

/* ---- bones ------------------------------------------------------------------------------------------------------------ */

/* The history knows the contents of the bones that were looked at, and only the names of those out of reach. */
static void mark_used(outcome *o) {
    for (size_t i = 0; i < o->bones.count; i++) o->bones.items[i].used = true;
    for (sn_index i = 0; i < o->report.pair_count; i++)
        if (o->report.pairs[i].culled) o->bones.items[o->report.pairs[i].bone].used = false;
}

static sn_status detect(cli *c, sn_muscle *muscle, const pin_list *pins, outcome *o, sn_error *error) {
    sn_attach_params params = sn_attach_defaults();
    params.methods = method_bits[method];
    params.distance = cli_length(distance, muscle->meters_per_unit);
    params.voxels = (sn_index)voxels;
    params.raw = raw;
    params.pair_distance = cli_length(pair_distance, muscle->meters_per_unit);
    params.pin_count = pins->count;
    params.pins = pins->pins;
    params.area_count = o->landmarks.count;
    params.areas = o->landmarks.areas;
    params.landmark_reach = cli_length(landmark_distance, muscle->meters_per_unit);
    params.area_kind = (sn_area_kind)area_kind;
    params.line_width = cli_length(line_width, muscle->meters_per_unit);
    params.threads = c->threads;
    sn_attach_bone *bones = SN_NEW(sn_attach_bone, o->bones.count);
    if (bones == NULL) return sn_fail_memory(error, "the bones");
    for (size_t i = 0; i < o->bones.count; i++) {
        const bone *b = &o->bones.items[i];
        bones[i] = (sn_attach_bone){b->name, &b->mesh, b->list != NULL && strcmp(pair_names[pairs], "nearby") == 0};
    }
    params.bone_count = (sn_index)o->bones.count;
    params.bones = bones;
    sn_attachments_free(muscle->attachments, muscle->attachment_count);
    muscle->has_attachments = true;
    sn_attachment_list found;
    sn_status status = sn_attach_detect(muscle, &params, &c->trace, &found, &o->report, error);
    muscle->attachment_count = found.count;
    muscle->attachments = found.items;
    free(bones);
    if (status == SN_OK || status == SN_STOPPED) mark_used(o);
    return status;
}

static void set_bone_frame(const cli *c, const sn_muscle *muscle, bone_list *bones) {
    bones->meters_per_unit = muscle->meters_per_unit;
    bones->given_unit = bone_unit >= 0 ? cli_unit_meters[bone_unit] : 0.0;
    bones->up_given = cli_given(c, "bone-up");
    bones->up_y = cli_given(c, "bone-up") ? bone_up == 1 : c->read.up_y;
}

static sn_status attach(cli *c, sn_muscle *muscle, const pin_list *pins, outcome *o, sn_error *error) {
    sn_status status = bones_load(&o->bones, c->threads, error);
    if (status == SN_OK) status = bones_check_spaces(&o->bones, muscle, error);
    if (status == SN_OK) status = load_landmarks(&o->bones, muscle, &o->landmarks, error);
    return status == SN_OK ? detect(c, muscle, pins, o, error) : status;
}

/* ---- lists of files in the history ------------------------------------------------------------------------------------ */

static sn_status hash_list(const void *user, const char *value, char out[SN_HASH_LENGTH], sn_error *error) {
    const outcome *o = user;
    return neighbours_listed(&o->neighbours, value) ? neighbours_hash(&o->neighbours, value, out, error)
                                                    : bones_hash(&o->bones, value, out, error);
}

/* ---- the work --------------------------------------------------------------------------------------------------------- */

static sn_status work(cli *c, sn_error *error) {
    pin_list pins = {0};
    cli_muscle document = {0};
    outcome o = {.muscle = &document.muscle};
    unsigned changed = (wants_attachments() ? SN_SECTION_ATTACHMENTS : 0) | (wants_neighbours() ? SN_SECTION_EXTERNALS : 0);
    c->hash_files = hash_list;
    c->hash_user = &o;
    sn_status status = parse_pins(c, &pins, error);
    if (status == SN_OK) status = bones_name(c, &bone_texts, &list_files, &o.bones, error);
    if (status == SN_OK) status = neighbours_name(c, &neighbours, &o.neighbours, error);
    if (status == SN_OK) status = cli_load(c, &document, error);
    if (status == SN_OK) set_bone_frame(c, &document.muscle, &o.bones);
    if (status == SN_OK && wants_attachments()) status = attach(c, &document.muscle, &pins, &o, error);
    if (status == SN_OK && wants_neighbours()) status = neighbours_find(c, &neighbours, &o.bones, &document.muscle, &o.neighbours, error);
    if (status == SN_OK || status == SN_STOPPED) {
        sn_status warned = warn(c, &o, status == SN_STOPPED, error);
        say_results(c, &o);
        status = warned == SN_OK ? cli_save(c, &document, changed, error) : warned;
    }
    if (status == SN_OK) status = cli_report(c, write_report, &o, error);
    c->hash_user = NULL; /* the bones go now */
    sn_attach_report_free(&o.report);
    sn_landmarks_free(&o.landmarks);
    cli_free(&document);
    free_pins(&pins);
    neighbours_free(&o.neighbours);
    bones_free(&o.bones);
    return status;
}

static void check_weights(const cli *c) {
    for (int k = 0; k < 3; k++) {
        double value;
        const char *text = neighbours.weights[k];
        if (text == NULL) continue;
        if (!wants_neighbours()) cli_usage_error(c, "--%s is for neighbours; give --glue, --muscles or --envelope", weight_names[k]);
        if (neighbours.source != WEIGHTS_UNIFORM)
            cli_usage_error(c, "--%s has no meaning with --weights %s", weight_names[k], weight_source_names[neighbours.source]);
        if (sn_parse_number(text, &value, NULL) == SN_OK && !(value >= 0.0 && value <= 1.0))
            cli_usage_error(c, "--%s %s: a weight is within 0 to 1", weight_names[k], text);
    }
}

static void check_neighbours(const cli *c) {
    static const char *const names[] = {"reach", "minimum-distance", "targets", "obstacles", "hidden", "weights"};
    static const char *const of_rule[] = {"tendons", "tendon-length"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (cli_given(c, names[i]) && !wants_neighbours())
            cli_usage_error(c, "--%s is for neighbours; give --glue, --muscles or --envelope", names[i]);
    for (size_t i = 0; i < sizeof of_rule / sizeof *of_rule; i++)
        if (cli_given(c, of_rule[i]) && neighbours.source != WEIGHTS_RULE) cli_usage_error(c, "--%s needs --weights rule", of_rule[i]);
    if (cli_given(c, "envelope") && cli_given(c, "skeleton")) cli_usage_error(c, "--skeleton is --envelope: give one of them");
    if (neighbours.tendon.value == 0.0) cli_usage_error(c, "--tendon-length: 0 would be no tendon; for that it is --weights uniform");
    neighbours.hold = tendons + 1;
    check_weights(c);
}

static void check_usage(const cli *c) {
    if (!wants_attachments() && !wants_neighbours())
        cli_usage_error(
            c, "nothing to attach to; name bones with --bone or --bones, vertices with --pin, areas with --landmarks, or neighbours "
               "with --glue, --muscles or --envelope");
    if (method == METHOD_NONE && pin_texts.count == 0 && wants_attachments())
        cli_usage_error(c, "--method none attaches pins only; give a --pin");
    if (method == METHOD_NONE && landmark_file != NULL)
        cli_usage_error(c, "--method none attaches pins only; for --landmarks it is --method area");
    if ((cli_given(c, "area-kind") || cli_given(c, "line-width")) && landmark_file == NULL)
        cli_usage_error(c, "--%s is for areas; give their --landmarks", cli_given(c, "line-width") ? "line-width" : "area-kind");
    if (cli_given(c, "line-width") && area_kind == SN_AREA_BOUNDARY)
        cli_usage_error(c, "--line-width has no meaning with --area-kind boundary");
    if (method == METHOD_AREA && landmark_file == NULL) cli_usage_error(c, "--method area attaches areas; give their --landmarks");
    if (distance.value >= 0.0 && !(method_bits[method] & SN_ATTACH_PROXIMITY))
        cli_usage_error(c, "--distance has no meaning with --method %s", method_names[method]);
    if (voxels > 0 && !(method_bits[method] & SN_ATTACH_CONTACT))
        cli_usage_error(c, "--voxels has no meaning with --method %s", method_names[method]);
    if ((cli_given(c, "pairs") || cli_given(c, "pair-distance")) && list_files.count == 0)
        cli_usage_error(c, "--pairs is for the bones of a --bones LIST; those of --bone are taken as meant");
    if (raw && (method == METHOD_NONE || method == METHOD_AREA))
        cli_usage_error(c, "--raw has no meaning with --method %s", method_names[method]);
    check_neighbours(c);
}

int main(int argc, char **argv) {
    cli c;
    sn_error error = {0};
    cli_start(&c, &tool, argc, argv);
    check_usage(&c);
    sn_status status = work(&c, &error);
    free(bone_texts.items);
    free(list_files.items);
    free(pin_texts.items);
    free(neighbours.glue.items);
    free(neighbours.lists.items);
    free(neighbours.obstacles.items);
    return cli_finish(&c, status, &error);
}
