/* rig-view -- draw a muscle document, a mesh, a motion, a scene or frames of a simulation as a PNG picture. */
#include "bones.h"
#include "cli.h"
#include "motion_view.h"
#include "others.h"
#include "section_view.h"
#include "sinew/sim.h"
#include "sinew/view.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- options ---------------------------------------------------------------------------------------------------------------- */

static struct {
    const char *size, *camera, *show, *views, *background, *title, *frames, *frame, *error;
    double zoom, range, rate;
    int64_t samples, columns, substeps, frame_count;
    int law, scheme, solver, precision, stretch, preconditioner;
    int64_t contact_samples;
    bool legend, all_bones, contact, no_contact, externals, no_externals;
    const char *cut;
    sn_length cut_depth;
    cli_list bones, bone_lists, states, neighbours, focus, muscles;
} given = {.cut_depth = {-1.0, 0.0}, .camera = "auto", .zoom = 1.0, .samples = 9, .legend = true};

/* The words of --show. */
static const char *const show_names[] = {"surface", "roots",  "structure", "fibers", "attachments", "bones", "wire",
                                         "auto",    "joints", "envelopes", "fields", "externals",   NULL};
/* The words of --error (sn_state_figure_name), --camera, --views and --background. */
static const char *const error_names[] = {"mesh",   "internal", "radial",  "dihedral", "area",        "membrane",
                                          "volume", "external", "contact", "pressure", "penetration", NULL};
static const char *const camera_names[] = {"auto", "front", "back", "left", "right", "top", "bottom", NULL};
static const char *const background_names[] = {"white", "grey", "black", NULL};

static const cli_option options[] = {
    {.kind = CLI_HEADING, .help = "What is drawn:"},
    {0, "show", "LIST", CLI_TEXT, &given.show, 0, 0, 0, show_names,
     "any of surface, roots, structure, fibers, attachments, externals, bones, joints, envelopes, fields, wire, with commas (default: what "
     "is\n"
     "there)"},
    {'b', "bone", "[NAME=]FILE", CLI_LIST, &given.bones, CLI_READS | CLI_FILE, 0, 0, NULL,
     "draw the bone in FILE, in the muscle's unit, with every muscle"},
    {0, "bones", "LIST", CLI_LIST, &given.bone_lists, 0, 0, 0, NULL,
     "a text file with a bone a line: FILE, or NAME, a tab and FILE; relative to LIST"},
    {0, "all-bones", NULL, CLI_FLAG, &given.all_bones, 0, 0, 0, NULL,
     "draw bones of a list or scene to which no muscle is attached, too (default: those it is attached to, if any)"},
    {0, "neighbours", "LIST", CLI_LIST, &given.neighbours, 0, 0, 0, NULL,
     "rigs that the externals' rows lie on, as for attach-detect --muscles: with --show externals or --cut they are drawn too"},
    {0, "cut", "PLANE", CLI_TEXT, &given.cut, 0, 0, 0, NULL,
     "a section of a muscle, its neighbours and bones, and rows near it: px,py,pz,nx,ny,nz in the document's unit, or x, y or z: across "
     "its\n"
     "middle"},
    {0, "cut-depth", "LENGTH", CLI_LENGTH, &given.cut_depth, 0, 0, 0, NULL, "rows so near to the plane are drawn (default: a mean edge)"},
    {0, "frames", "PATH", CLI_TEXT, &given.frames, 0, 0, 0, NULL,
     "PC2 point cache of the scene's one muscle, or folder with MUSCLE.pc2 for each"},
    {0, "muscle", "NAME", CLI_LIST, &given.muscles, 0, 0, 0, NULL,
     "of a scene draw this muscle alone (* and ? match); may be given again and again"},
    {0, "frame", "LIST", CLI_TEXT, &given.frame, 0, 0, 0, NULL,
     "frames of the scene or motion to draw, one tile each: 0,12,24 or 0:90:15 (default: its first)"},
    {0, "frame-count", "N", CLI_INTEGER, &given.frame_count, 0, 1, FRAMES_MAX, NULL,
     "draw N frames, evenly from the first to the last of the scene or motion"},
    {.kind = CLI_HEADING, .help = "States of a scene:"},
    {0, "state", "FILE", CLI_LIST, &given.states, CLI_READS, 0, 0, NULL,
     "draw the scene at a state of simulate, coloured by constraint error; one tile each"},
    {0, "error", "LIST", CLI_TEXT, &given.error, 0, 0, 0, error_names,
     "which error: mesh (default), internal, radial, dihedral, area, membrane, volume, external, contact; or pressure, penetration;\n"
     "several with commas, one tile each"},
    {0, "range", "NUMBER", CLI_NUMBER, &given.range, 0, 1e-300, 1e300, NULL,
     "end of the colours (default: a round number that few rows exceed, the same for all states)"},
    {0, "scheme", "SCHEME", CLI_CHOICE, &given.scheme, 0, 0, 0, sn_scheme_names, "as simulate was told: guarded, romeo or kohout"},
    {0, "solver", "METHOD", CLI_CHOICE, &given.solver, 0, 0, 0, sn_solver_method_names, "as simulate was told: xpbd or qn"},
    {0, "precision", "PRECISION", CLI_CHOICE, &given.precision, 0, 0, 0, sn_precision_names, "as simulate was told: double or single"},
    {0, "stretch", "MODEL", CLI_CHOICE, &given.stretch, 0, 0, 0, sn_stretch_names, "as simulate was told: springs or membrane"},
    {0, "preconditioner", "MATRIX", CLI_CHOICE, &given.preconditioner, 0, 0, 0, sn_preconditioning_names,
     "as simulate was told: scalar, corotated or two-level"},
    {0, "law", "LAW", CLI_CHOICE, &given.law, 0, 0, 0, sn_fiber_law_names, "as simulate was told: projected, paper or isochoric"},
    {0, "substeps", "N", CLI_AUTO, &given.substeps, 0, 1, 1e6, NULL, "as simulate was told"},
    {0, "rate", "N", CLI_NUMBER, &given.rate, 0, 1e-6, 1e6, NULL, "as simulate was told"},
    {0, "contact", NULL, CLI_FLAG, &given.contact, 0, 0, 0, NULL, "as simulate was told"},
    {0, "no-contact", NULL, CLI_FLAG, &given.no_contact, 0, 0, 0, NULL, "as simulate was told"},
    {0, "contact-samples", "N", CLI_INTEGER, &given.contact_samples, 0, 0, 3, NULL, "as simulate was told"},
    {0, "externals", NULL, CLI_FLAG, &given.externals, 0, 0, 0, NULL, "as simulate was told"},
    {0, "no-externals", NULL, CLI_FLAG, &given.no_externals, 0, 0, 0, NULL, "as simulate was told"},
    {.kind = CLI_HEADING, .help = "From where:"},
    {0, "camera", "VIEW", CLI_TEXT, &given.camera, 0, 0, 0, camera_names,
     "auto (default: across the long axis), front, back, left, right, top, bottom, or AZIMUTH:ELEVATION in degrees"},
    {0, "views", "N|LIST", CLI_TEXT, &given.views, 0, 0, 0, camera_names + 1,
     "several tiles: N turns of the camera, or a list such as front,left,30:20"},
    {0, "focus", "NAME", CLI_LIST, &given.focus, 0, 0, 0, NULL,
     "aim the camera at muscles or bones alone: names with commas, * and ? stand for any characters and any one"},
    {0, "zoom", "FACTOR", CLI_NUMBER, &given.zoom, 0, 0.01, 1000, NULL, "enlarge about the middle (default 1: all is in the picture)"},
    {.kind = CLI_HEADING, .help = "The picture:"},
    {0, "size", "WxH", CLI_TEXT, &given.size, 0, 0, 0, NULL,
     "pixels of the picture (default 800x600), or of a tile where there are several (480 wide)"},
    {0, "columns", "N", CLI_INTEGER, &given.columns, 0, 1, 1000, NULL, "tiles in a row (default: as square as it gets)"},
    {0, "title", "TEXT", CLI_TEXT, &given.title, 0, 0, 0, NULL, "title (default: the muscle's or scene's name)"},
    {0, "no-legend", NULL, CLI_CLEAR, &given.legend, 0, 0, 0, NULL, "leave out title, captions, legend and scale bar"},
    {0, "background", "COLOUR", CLI_TEXT, &given.background, 0, 0, 0, background_names,
     "#rrggbb, white, grey or black (default: a warm near white)"},
    {0, "samples", "N", CLI_INTEGER, &given.samples, 0, 1, 64, NULL, "rays for each pixel, rounded up to a square (default 9)"},
};

static const cli_tool tool = {
    .name = "rig-view",
    .summary = "Draw muscle documents, meshes, motions, scenes, frames and states of a simulation as a PNG picture.",
    .shared = CLI_TAKES_INPUTS | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_UNITS | CLI_HAS_THREADS | CLI_HAS_SPACE,
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .writes = ".png",
    .notes = "INPUT is a muscle document, a bare mesh (OBJ, PLY, STL, OFF, VTK, VTP), a motion document or a scene;\n"
             "nothing or \"-\" is standard input.\n"
             "Several inputs, views or frames make a contact sheet.",
};

/* ---- words into values ---------------------------------------------------------------------------------------------------------- */

static const unsigned show_bits[] = {SN_SHOW_SURFACE,     SN_SHOW_ROOTS,     SN_SHOW_STRUCTURE, SN_SHOW_FIBERS,
                                     SN_SHOW_ATTACHMENTS, SN_SHOW_BONES,     SN_SHOW_WIRE,      SN_SHOW_AUTO,
                                     SN_SHOW_JOINTS,      SN_SHOW_ENVELOPES, SN_SHOW_FIELDS,    SN_SHOW_EXTERNALS};

/* The bit of one word of --show; 0 = no such word. */
static unsigned show_bit(const char *word, size_t length) {
    for (size_t i = 0; show_names[i] != NULL; i++)
        if (strlen(show_names[i]) == length && memcmp(show_names[i], word, length) == 0) return show_bits[i];
    return 0;
}

static unsigned parse_show(const cli *c, const char *text) {
    if (!text) return SN_SHOW_AUTO;
    unsigned show = 0;
    while (*text) {
        size_t length = strcspn(text, ",");
        unsigned bit = show_bit(text, length);
        if (!bit) cli_no_such_value(c, "show", text, length, show_names);
        show |= bit;
        text += length + (text[length] == ',');
    }
    /* wire alone means: the surface with its edges */
    return show & SN_SHOW_WIRE && !(show & ~(unsigned)SN_SHOW_WIRE) ? show | SN_SHOW_AUTO : show;
}

static void parse_size(const cli *c, sn_view_options *o) {
    const char *by = given.size ? strchr(given.size, 'x') : NULL;
    char width_text[16] = "";
    int64_t width = 0, height = 0;
    if (!given.size) return;
    if (by) snprintf(width_text, sizeof width_text, "%.*s", (int)(by - given.size < 15 ? by - given.size : 15), given.size);
    if (!by || sn_parse_integer(width_text, 16, SN_IMAGE_SIDE_MAX, &width, NULL) != SN_OK ||
        sn_parse_integer(by + 1, 16, SN_IMAGE_SIDE_MAX, &height, NULL) != SN_OK)
        cli_usage_error(c, "--size: '%s' is not WIDTHxHEIGHT with both from 16 to %d, as in 800x600", given.size, SN_IMAGE_SIDE_MAX);
    o->width = (sn_index)width;
    o->height = (sn_index)height;
}

static sn_color parse_color(const cli *c, const char *text) {
    unsigned r, g, b;
    if (strcmp(text, "white") == 0) return (sn_color){1, 1, 1};
    if (strcmp(text, "grey") == 0 || strcmp(text, "gray") == 0) return (sn_color){0.5, 0.5, 0.5};
    if (strcmp(text, "black") == 0) return (sn_color){0, 0, 0};
    bool hexadecimal = *text == '#' && strlen(text) == 7 && strspn(text + 1, "0123456789abcdefABCDEF") == 6;
    if (!hexadecimal || sscanf(text, "#%2x%2x%2x", &r, &g, &b) != 3)
        cli_usage_error(c, "--background: '%s' is no colour; write #rrggbb, white, grey or black", text);
    return (sn_color){r / 255.0, g / 255.0, b / 255.0};
}

/* One way to look at the subject. */
typedef struct look {
    bool automatic;
    double azimuth, elevation, spin; /* degrees */
    char caption[40];                /* "" = the only one */
} look;

static look parse_look(const cli *c, const char *option, const char *text, size_t length) {
    static const struct {
        const char *name;
        double azimuth, elevation;
    } names[] = {{"front", 0, 0}, {"right", 90, 0}, {"back", 180, 0}, {"left", 270, 0}, {"top", 0, 90}, {"bottom", 0, -90}};
    char word[40];
    snprintf(word, sizeof word, "%.*s", (int)(length < 39 ? length : 39), text);
    look l = {.automatic = strcmp(word, "auto") == 0};
    snprintf(l.caption, sizeof l.caption, "%s", word);
    if (l.automatic) return l;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i].name, word) == 0) {
            l.azimuth = names[i].azimuth;
            l.elevation = names[i].elevation;
            return l;
        }
    double angles[2];
    char *colon = strchr(word, ':');
    if (colon) *colon = ',';
    if (sn_parse_numbers(word, 2, angles, NULL) != SN_OK || fabs(angles[0]) > 3600.0 || fabs(angles[1]) > 90.0)
        cli_usage_error(c, "--%s: '%s' is no view; write auto, front, back, left, right, top, bottom or AZIMUTH:ELEVATION as in 30:20",
                        option, l.caption);
    l.azimuth = angles[0];
    l.elevation = angles[1];
    return l;
}

typedef struct looks {
    sn_index count;
    look items[64];
} looks;

static looks parse_looks(const cli *c) {
    looks all = {1, {parse_look(c, "camera", given.camera, strlen(given.camera))}};
    int64_t turns;
    if (!given.views) {
        all.items[0].caption[0] = 0;
    } else if (sn_parse_integer(given.views, 1, 64, &turns, NULL) == SN_OK) {
        all.count = (sn_index)turns;
        for (sn_index i = 1; i < all.count; i++) all.items[i] = all.items[0];
        for (sn_index i = 0; i < all.count; i++) {
            double turn = 360.0 * i / all.count;
            all.items[i].spin = turn;
            all.items[i].azimuth += turn;
            snprintf(all.items[i].caption, sizeof all.items[i].caption, "turned %.4g deg", turn);
        }
    } else {
        const char *text = given.views;
        for (all.count = 0; *text; all.count++) {
            if (all.count == 64) cli_usage_error(c, "--views: more than 64 views");
            size_t length = strcspn(text, ",");
            all.items[all.count] = parse_look(c, "views", text, length);
            text += length + (text[length] == ',');
        }
        if (all.count == 0) cli_usage_error(c, "--views: an empty list");
    }
    return all;
}

enum { KINDS_MAX = 2 * SN_ROW_KINDS };
typedef struct kind_list {
    sn_index count;
    sn_state_figure items[KINDS_MAX];
} kind_list;

static _Noreturn void no_such_kind(const cli *c, const char *text, size_t length) {
    cli_no_such_value(c, "error", text, length, error_names);
}

/* The figures of --error. */
static kind_list parse_kinds(const cli *c) {
    kind_list all = {0, {(sn_state_figure)SN_ROWS_MESH}};
    const char *text = given.error ? given.error : "mesh";
    for (size_t length; *text; text += length + (text[length] == ',')) {
        length = strcspn(text, ",");
        int kind = 0;
        while (kind < SN_FIGURES && (strlen(sn_state_figure_name((sn_state_figure)kind)) != length ||
                                     strncmp(sn_state_figure_name((sn_state_figure)kind), text, length) != 0))
            kind++;
        if (kind == SN_FIGURES) no_such_kind(c, text, length);
        if (all.count == KINDS_MAX) cli_usage_error(c, "--error: more than %d kinds", KINDS_MAX);
        all.items[all.count++] = (sn_state_figure)kind;
    }
    if (all.count == 0) cli_usage_error(c, "--error: an empty list");
    return all;
}

/* ---- contents: what there is to look at -------------------------------------------------------------------------------------------- */

typedef struct content {
    sn_view view;
    char *caption;
    sn_index group; /* contents of one group share their cameras */
    bool upright;   /* the automatic camera keeps z up: a body in motion */
} content;

typedef struct album {
    const cli *c;
    unsigned show;
    size_t count, capacity;
    content *items;
    sn_index group_count;
    bone_list bones;
    rig_list rigs; /* --neighbours */
    sn_palette palette;
} album;

static sn_status album_add(album *a, content *item, sn_error *error) {
    if (!sn_grow((void **)&a->items, &a->capacity, a->count + 1, sizeof *a->items)) {
        sn_view_free(&item->view);
        free(item->caption);
        return sn_fail_memory(error, "the pictures");
    }
    a->items[a->count++] = *item;
    return SN_OK;
}

static void album_free(album *a) {
    for (size_t i = 0; i < a->count; i++) {
        sn_view_free(&a->items[i].view);
        free(a->items[i].caption);
    }
    bones_free(&a->bones);
    rigs_free(&a->rigs);
    sn_palette_free(&a->palette);
    free(given.focus.items);
    free(given.neighbours.items);
    free(a->items);
    free(given.bones.items);
    free(given.bone_lists.items);
    free(given.states.items);
}

/* File name without folder and extensions. */
static char *caption_of(const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *ends[] = {".muscle.json", ".scene.json", ".motion.json", ".json", ".ply", ".obj", ".stl", ".off", ".vtk", ".vtp"};
    size_t length = strlen(name);
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        if (length > strlen(ends[i]) && strcmp(name + length - strlen(ends[i]), ends[i]) == 0)
            return sn_strndup(name, length - strlen(ends[i]));
    return sn_strdup(strcmp(name, "-") == 0 ? "standard input" : name);
}

static bool is_attached(const sn_muscle *muscle, const char *name) {
    for (sn_index i = 0; i < muscle->attachment_count; i++)
        if (strcmp(muscle->attachments[i].bone, name) == 0) return true;
    return false;
}

/* Is the muscle attached to any bone of a list? Then the others of lists are left out, but not those that were named one by one. */
static bool leaves_out(const album *a, const sn_muscle *muscle) {
    for (size_t i = 0; i < a->bones.count && !given.all_bones; i++)
        if (is_attached(muscle, a->bones.items[i].name)) return true;
    return false;
}

static void tell_left_out(const album *a, sn_index count, const char *what) {
    if (count > 0)
        cli_say(a->c, "%d %s not drawn, as no muscle of %s is attached to %s; --all-bones draws all", count,
                count == 1 ? "bone is" : "bones are", what, count == 1 ? "it" : "them");
}

static sn_status add_bones(album *a, const sn_muscle *muscle, sn_view *view, sn_error *error) {
    const bool some = leaves_out(a, muscle);
    sn_index left_out = 0;
    sn_status status = SN_OK;
    for (size_t i = 0; i < a->bones.count && !status; i++) {
        const bone *b = &a->bones.items[i];
        double unit = b->own_unit > 0.0 ? b->own_unit : muscle->meters_per_unit;
        if (some && b->list && !is_attached(muscle, b->name))
            left_out++;
        else
            status = sn_view_add_bone(view, b->name, &b->mesh, (sn_placement){unit, NULL}, error);
    }
    tell_left_out(a, left_out, muscle->name ? muscle->name : "the document");
    return status;
}

static sn_status add_rig(album *a, const sn_muscle *muscle, sn_view *view, sn_error *error) {
    const section_request request = {given.cut, given.cut_depth, &a->bones, &a->rigs};
    if (given.cut) return section_add(view, muscle, &request, error);
    sn_status status = sn_view_add_muscle(view, muscle, a->show, error);
    if (!status && a->show & SN_SHOW_EXTERNALS) status = rows_add(view, muscle, &a->rigs, error);
    return status ? status : add_bones(a, muscle, view, error);
}

static sn_status add_muscle(album *a, const sn_blob *blob, const char *path, sn_error *error) {
    sn_muscle muscle;
    sn_document *document = NULL;
    content item = {.view.palette = &a->palette, .caption = caption_of(path), .group = a->group_count++};
    sn_status status = sn_muscle_parse(blob, &a->c->read, &muscle, &document, error);
    sn_document_free(document);
    if (!status && !item.caption) status = sn_fail_memory(error, "a caption");
    if (!status) status = sn_mesh_validate(&muscle.mesh, error);
    if (!status) status = bones_check_spaces(&a->bones, &muscle, error);
    for (size_t i = 0; i < a->rigs.files.count && !status; i++)
        status = cli_check_space(&muscle, a->rigs.muscles[i].space, a->rigs.names[i], error);
    if (!status && a->show & SN_SHOW_EXTERNALS && !muscle.has_externals)
        cli_warn(a->c, "%s has no externals; attach-detect --muscles finds them", path);
    if (!status) status = add_rig(a, &muscle, &item.view, error);
    sn_muscle_free(&muscle);
    if (!status) return album_add(a, &item, error);
    sn_view_free(&item.view);
    free(item.caption);
    return status;
}

/* ---- scenes and their frames ------------------------------------------------------------------------------------------------------ */

typedef struct caches {
    sn_index count;      /* muscles of the scene */
    sn_pc2_data *data;   /* (count) positions NULL = none */
    sn_pc2_data *fibers; /* (count) of the fibres' vertices; positions NULL = none */
    sn_vec3 **positions; /* (count) of the frame shown, in metres; NULL = at rest */
} caches;

static void caches_free(caches *k) {
    for (sn_index i = 0; i < k->count; i++) {
        if (k->data) sn_pc2_free(&k->data[i]);
        if (k->fibers) sn_pc2_free(&k->fibers[i]);
        if (k->positions) free(k->positions[i]);
    }
    free(k->data);
    free(k->fibers);
    free(k->positions);
}

static bool is_folder(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* Where the frames of a muscle are; NULL = out of memory. A '/' in its name is a '_' in the file's. */
static char *cache_path(const char *frames, const char *muscle) {
    if (!is_folder(frames)) return sn_strdup(frames);
    size_t room = strlen(frames) + strlen(muscle) + 8;
    char *path = sn_alloc(room, 1);
    if (!path) return NULL;
    snprintf(path, room, "%s/%s.pc2", frames, muscle);
    for (char *at = path + strlen(frames) + 1; *at; at++)
        if (*at == '/') *at = '_';
    return path;
}

static sn_status load_cache(const sn_scene_muscle *muscle, sn_pc2_data *data, sn_vec3 **positions, sn_error *error) {
    char *path = cache_path(given.frames, muscle->name);
    if (!path) return sn_fail_memory(error, "a path");
    sn_status status = sn_pc2_read(path, data, error);
    if (!status && data->point_count != muscle->rig.mesh.vertex_count)
        status = sn_fail(error, SN_ERROR_INPUT, "the frames have %d points, but muscle '%s' has %d vertices; they belong to another rig",
                         data->point_count, muscle->name, muscle->rig.mesh.vertex_count);
    if (!status && data->sample_count < 1) status = sn_fail(error, SN_ERROR_INPUT, "there are no frames in it");
    if (!status && !(*positions = SN_NEW(sn_vec3, data->point_count))) status = sn_fail_memory(error, "a frame");
    if (status) sn_error_set_file(error, path);
    free(path);
    return status;
}

/* "path-fibers.pc2" for "path.pc2"; NULL = out of memory. */
static char *fiber_path(const char *path) {
    size_t length = strlen(path), tail = strlen(".pc2");
    if (length > tail && strcmp(path + length - tail, ".pc2") == 0) length -= tail;
    char *text = sn_alloc(length + sizeof "-fibers.pc2", 1);
    if (text) snprintf(text, length + sizeof "-fibers.pc2", "%.*s-fibers.pc2", (int)length, path);
    return text;
}

static sn_index count_fiber_points(const sn_fibers *fibers) {
    sn_index count = 0;
    for (sn_index i = 0; i < fibers->polyline_count; i++) count += fibers->polylines[i].count;
    return count;
}

/* The frames that simulate --fibers writes beside the muscle's. Fibres that have none are at rest, not where the muscle is: drop them. */
static sn_status load_fiber_cache(sn_scene_muscle *muscle, sn_pc2_data *data, sn_error *error) {
    char *frames = cache_path(given.frames, muscle->name), *path = frames ? fiber_path(frames) : NULL;
    struct stat there;
    sn_status status = path ? SN_OK : sn_fail_memory(error, "a path");
    if (!status && stat(path, &there) == 0) {
        status = sn_pc2_read(path, data, error);
        sn_index points = count_fiber_points(&muscle->rig.fibers);
        if (!status && (data->point_count != points || data->sample_count < 1))
            status = sn_fail(error, SN_ERROR_INPUT, "the frames have %d points, but the fibres of muscle '%s' have %d", data->point_count,
                             muscle->name, points);
        if (status) sn_error_set_file(error, path);
    } else if (!status) {
        sn_fibers none = {.polylines = muscle->rig.fibers.polylines, .polyline_count = muscle->rig.fibers.polyline_count};
        sn_fibers_free(&none);
        muscle->rig.fibers.polylines = NULL;
        muscle->rig.fibers.polyline_count = 0;
    }
    free(frames);
    free(path);
    return status;
}

static sn_status load_caches(const sn_scene *scene, caches *k, sn_error *error) {
    *k = (caches){.count = scene->muscle_count};
    k->data = SN_NEW(sn_pc2_data, k->count);
    k->fibers = SN_NEW(sn_pc2_data, k->count);
    k->positions = SN_NEW(sn_vec3 *, k->count);
    if (!k->data || !k->fibers || !k->positions) return sn_fail_memory(error, "the frames");
    sn_index enabled = 0;
    for (sn_index i = 0; i < scene->muscle_count; i++) enabled += scene->muscles[i].enabled;
    if (given.frames && enabled > 1 && !is_folder(given.frames))
        return sn_fail(error, SN_ERROR_USAGE, "--frames: the scene has %d muscles; name the folder that holds their caches", enabled);
    sn_status status = SN_OK;
    for (sn_index i = 0; i < k->count && given.frames && !status; i++) {
        if (!scene->muscles[i].enabled) continue;
        status = load_cache(&scene->muscles[i], &k->data[i], &k->positions[i], error);
        if (!status) status = load_fiber_cache(&scene->muscles[i], &k->fibers[i], error);
    }
    return status;
}

/* Vertices of the fibres at a sample, in metres as the muscle's are. */
static sn_status set_fibers(sn_scene_muscle *muscle, const sn_pc2_data *data, double sample, sn_error *error) {
    if (!(sample < data->sample_count))
        return sn_fail(error, SN_ERROR_INPUT, "the fibres of muscle '%s' have fewer frames than it has", muscle->name);
    const float *x = data->positions + (size_t)sample * 3 * (size_t)data->point_count;
    for (sn_index i = 0; i < muscle->rig.fibers.polyline_count; i++)
        for (sn_index j = 0; j < muscle->rig.fibers.polylines[i].count; j++, x += 3)
            muscle->rig.fibers.polylines[i].points[j] =
                sn_scale(sn_v3((double)x[0], (double)x[1], (double)x[2]), muscle->rig.meters_per_unit);
    return SN_OK;
}

/* Copy out the positions of a frame, in metres. */
static sn_status set_frame(const sn_scene *scene, caches *k, int64_t frame, sn_error *error) {
    for (sn_index m = 0; m < k->count; m++) {
        const sn_pc2_data *data = &k->data[m];
        if (!k->positions[m]) continue;
        double step = data->sample_rate > 0.0 ? data->sample_rate : 1.0, sample = round(((double)frame - data->start_frame) / step);
        if (!(sample >= 0.0 && sample < data->sample_count))
            return sn_fail(error, SN_ERROR_INPUT, "frame %lld is not among those of muscle '%s': %.9g to %.9g", (long long)frame,
                           scene->muscles[m].name, data->start_frame, data->start_frame + (data->sample_count - 1) * step);
        const float *from = data->positions + (size_t)sample * 3 * (size_t)data->point_count;
        double unit = scene->muscles[m].rig.meters_per_unit;
        for (sn_index i = 0; i < data->point_count; i++) {
            const float *x = from + 3 * (size_t)i;
            sn_vec3 p = sn_scale(sn_v3((double)x[0], (double)x[1], (double)x[2]), unit);
            if (!sn_finite3(p))
                return sn_fail(error, SN_ERROR_INPUT, "muscle '%s' is not finite in frame %lld", scene->muscles[m].name, (long long)frame);
            k->positions[m][i] = p;
        }
        sn_status status = k->fibers[m].positions ? set_fibers(&scene->muscles[m], &k->fibers[m], sample, error) : SN_OK;
        if (status) return status;
    }
    return SN_OK;
}

/* scene_path: NULL where the scene has several frames in the album; a lone one has the scene's name, and its moment as the subtitle. */
static sn_status add_frame(album *a, const sn_scene *scene, caches *k, int64_t frame, const char *scene_path, sn_error *error) {
    content item = {.view.palette = &a->palette, .group = a->group_count};
    double time = (double)frame / scene->rate;
    char text[64];
    snprintf(text, sizeof text, "frame %lld, %.2f s", (long long)frame, time);
    item.caption = scene_path ? caption_of(scene_path) : sn_strdup(text);
    sn_status status = item.caption ? set_frame(scene, k, frame, error) : sn_fail_memory(error, "a caption");
    if (!status) status = sn_view_add_scene(&item.view, scene, time, (const sn_vec3 *const *)k->positions, a->show, error);
    if (!status && scene_path && !(item.view.subtitle = sn_strdup(text))) status = sn_fail_memory(error, "the subtitle");
    if (!status) return album_add(a, &item, error);
    sn_view_free(&item.view);
    free(item.caption);
    return status;
}

/* ---- states of a scene -------------------------------------------------------------------------------------------------------------- */

typedef struct stills {
    sn_model *model;
    kind_list kinds;
    double ranges[KINDS_MAX];
    sn_state **states; /* (given.states.count) */
} stills;

static void stills_free(stills *s) {
    for (int i = 0; s->states && i < given.states.count; i++) sn_state_destroy(s->model, s->states[i]);
    free(s->states);
    sn_model_destroy(s->model);
}

/* What changes the rows or the time, as simulate has it. */
static void apply_settings(const cli *c, sn_scene *scene) {
    if (cli_given(c, "solver"))
        sn_solver_change(&scene->solver, (sn_solver_method)given.solver);
    else if ((cli_given(c, "scheme") && given.scheme != SN_SCHEME_GUARDED) ||
             (cli_given(c, "precision") && given.precision != SN_PRECISION_DOUBLE))
        sn_solver_change(&scene->solver, SN_SOLVER_XPBD);
    if (cli_given(c, "precision")) scene->solver.precision = (sn_precision)given.precision;
    if (cli_given(c, "preconditioner")) scene->solver.preconditioner = (sn_preconditioning)given.preconditioner;
    for (sn_index i = 0; cli_given(c, "stretch") && i < scene->muscle_count; i++) scene->muscles[i].stretch = (sn_stretch)given.stretch;
    if (cli_given(c, "scheme")) scene->solver.scheme = (sn_scheme)given.scheme;
    if (cli_given(c, "substeps")) scene->solver.substeps = (sn_index)given.substeps;
    if (cli_given(c, "rate")) scene->rate = given.rate;
    if (given.contact || given.no_contact) scene->contact.enabled = given.contact;
    if (given.externals || given.no_externals) scene->externals.enabled = given.externals;
    if (cli_given(c, "contact-samples")) scene->contact.samples = (sn_index)given.contact_samples;
    for (sn_index i = 0; cli_given(c, "law") && i < scene->muscle_count; i++) scene->muscles[i].law = (sn_fiber_law)given.law;
}

static sn_status load_state(stills *s, int number, sn_error *error) {
    const char *path = given.states.items[number];
    sn_blob blob = {0};
    sn_status status = sn_state_create(s->model, &s->states[number], error);
    if (!status) status = sn_blob_read(path, &blob, error);
    if (!status) status = sn_state_unpack(s->model, blob.data, blob.size, s->states[number], error);
    if (status) sn_error_set_file(error, path);
    sn_blob_free(&blob);
    return status;
}

/* One scale for all states, so that they can be compared. */
static sn_status set_ranges(const cli *c, stills *s, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index k = 0; k < s->kinds.count; k++) {
        s->ranges[k] = cli_given(c, "range") ? given.range : 0.0;
        for (int i = 0; i < given.states.count && !cli_given(c, "range") && !status; i++) {
            double range = 0.0;
            status = sn_view_state_range(s->model, s->states[i], s->kinds.items[k], &range, error);
            s->ranges[k] = fmax(s->ranges[k], range);
        }
    }
    return status;
}

/* "frame 12", "frame 12:3" or "frame 12:3:2": as --stop-after of simulate has it. */
static char *state_caption(const sn_state *state) {
    char text[96];
    int length = snprintf(text, sizeof text, "frame %d", (int)state->frame);
    int substep = (int)state->substep + (state->iteration > 0 ? 1 : 0); /* the one that iterations are done of, else the last done */
    if (substep > 0) length += snprintf(text + length, sizeof text - (size_t)length, ":%d", substep);
    if (state->iteration > 0) snprintf(text + length, sizeof text - (size_t)length, ":%d", (int)state->iteration);
    return sn_strdup(text);
}

/* A tile: its caption tells the moment, and the worst row where there are several tiles. */
static sn_status add_state(album *a, const stills *s, const sn_state *state, sn_index kind, sn_error *error) {
    content item = {.view.palette = &a->palette, .group = a->group_count, .caption = state_caption(state)};
    sn_status status = item.caption ? SN_OK : sn_fail_memory(error, "a caption");
    const sn_state_look what = {s->kinds.items[kind], s->ranges[kind], a->show};
    if (!status) status = sn_view_add_state(&item.view, s->model, state, &what, error);
    if (!status) {
        char text[512];
        bool alone = given.states.count == 1 && s->kinds.count == 1;
        snprintf(text, sizeof text, "%s; %s", item.caption, item.view.subtitle);
        char **place = alone ? &item.view.subtitle : &item.caption;
        free(*place);
        if (!(*place = sn_strdup(text))) status = sn_fail_memory(error, "a caption");
    }
    if (!status) return album_add(a, &item, error);
    sn_view_free(&item.view);
    free(item.caption);
    return status;
}

static sn_status add_states(album *a, sn_scene *scene, sn_error *error) {
    stills s = {.kinds = parse_kinds(a->c)};
    apply_settings(a->c, scene);
    sn_status status = sn_model_create(scene, &s.model, error);
    if (!status && !(s.states = SN_NEW(sn_state *, given.states.count))) status = sn_fail_memory(error, "the states");
    for (int i = 0; i < given.states.count && !status; i++) status = load_state(&s, i, error);
    if (!status) status = set_ranges(a->c, &s, error);
    for (int i = 0; i < given.states.count && !status; i++)
        for (sn_index k = 0; k < s.kinds.count && !status; k++) status = add_state(a, &s, s.states[i], k, error);
    stills_free(&s);
    return status;
}

/* ---- scenes -------------------------------------------------------------------------------------------------------------- */

static sn_status add_frames(album *a, const sn_scene *scene, const char *path, sn_error *error) {
    caches k = {0};
    frame_list frames = frames_parse(a->c, given.frame);
    if (frames.count == 0) frames = frames_spread(given.frame_count > 0 ? given.frame_count : 1, scene->first_frame, scene->last_frame);
    sn_status status = load_caches(scene, &k, error);
    for (sn_index i = 0; i < frames.count && !status; i++)
        status = add_frame(a, scene, &k, frames.items[i], frames.count == 1 ? path : NULL, error);
    caches_free(&k);
    return status;
}

static void tell_scene_bones(const album *a, const sn_scene *scene) {
    const unsigned drawing = given.states.count > 0 ? SN_SHOW_BONES : SN_SHOW_BONES | SN_SHOW_AUTO;
    sn_index left_out = 0;
    for (sn_index i = 0; i < scene->bone_count && a->show & drawing; i++) left_out += !sn_view_draws_bone(scene, i, a->show);
    tell_left_out(a, left_out, "the scene");
}

static sn_status add_scene(album *a, const sn_blob *blob, const char *path, sn_error *error) {
    sn_scene scene = {0};
    sn_status status = sn_scene_parse(blob, true, &scene, error);
    if (status) return status;
    if (a->bones.count > 0) cli_warn(a->c, "--bone is for muscle documents; %s brings its own bones", path);
    const other_choices some = {.muscles = given.muscles};
    status = given.states.count > 0 ? others_apply(a->c, &some, &scene, error) : others_leave_out(a->c, &given.muscles, &scene, error);
    if (!status) status = given.states.count > 0 ? add_states(a, &scene, error) : add_frames(a, &scene, path, error);
    a->group_count++;
    if (!status) tell_scene_bones(a, &scene);
    sn_scene_free(&scene);
    return status;
}

/* ---- motions -------------------------------------------------------------------------------------------------------------- */

static sn_status add_motion(album *a, const sn_blob *blob, const char *path, sn_error *error) {
    motion_request request = {
        .c = a->c, .path = path, .show = a->show, .frames = frames_parse(a->c, given.frame), .spread = given.frame_count};
    motion_picture *pictures;
    sn_index count;
    sn_status status = motion_pictures(&request, blob, &pictures, &count, error);
    if (status) return status;
    if (a->bones.count > 0) cli_warn(a->c, "--bone is for muscle documents; %s brings its own bones", path);
    for (sn_index i = 0; i < count && !status; i++) {
        content item = {.view = pictures[i].view, .caption = pictures[i].caption, .group = a->group_count, .upright = true};
        pictures[i] = (motion_picture){0}; /* the album's now */
        if (count == 1) {
            free(item.caption);
            item.caption = caption_of(path);
        }
        status = album_add(a, &item, error);
    }
    a->group_count++;
    motion_pictures_free(pictures, count);
    return status;
}

/* ---- inputs --------------------------------------------------------------------------------------------------------------- */

/* A motion of another format is no mesh either: say how it is drawn. */
static sn_status add_other(album *a, const sn_blob *blob, const char *path, sn_error *error) {
    const char *motion = sn_mesh_detect(blob) == SN_MESH_UNKNOWN ? sn_clip_detect(blob) : NULL;
    if (motion) return sn_fail(error, SN_ERROR_INPUT, "this is %s; make a motion document of it with motion-import, and draw that", motion);
    return add_muscle(a, blob, path, error);
}

static sn_status add_input(album *a, const char *path, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(path, &blob, error);
    if (status) return status;
    bool scene = sn_scene_detect(&blob), motion = sn_motion_document_detect(&blob);
    if (!scene && given.states.count > 0)
        status = sn_fail(error, SN_ERROR_INPUT, "--state needs the scene that was simulated, and this is none");
    else if ((scene || motion) && (cli_given(a->c, "units") || cli_given(a->c, "up") || cli_given(a->c, "mesh")))
        status = sn_fail(error, SN_ERROR_USAGE, "a %s document says its units; --units, --up and --mesh are for bare meshes",
                         scene ? "scene" : "motion");
    else if ((scene || motion) && given.cut)
        status = sn_fail(error, SN_ERROR_INPUT, "--cut goes through muscle documents, and this is none");
    else
        status = scene ? add_scene(a, &blob, path, error) : motion ? add_motion(a, &blob, path, error) : add_other(a, &blob, path, error);
    if (status) sn_error_set_file(error, blob.name);
    sn_blob_free(&blob);
    return status;
}

/* ---- what the camera looks at ---------------------------------------------------------------------------------------------- */

/* No picture has anything of that name: say which name was meant. */
static sn_status fail_focus(const album *a, const char *name, sn_error *error) {
    size_t count = 0, room = 1;
    for (size_t i = 0; i < a->count; i++) room += a->items[i].view.mesh_count;
    const char **names = SN_NEW(const char *, room); /* NULL at the end */
    if (!names) return sn_fail_memory(error, "the names");
    for (size_t i = 0; i < a->count; i++)
        for (size_t m = 0; m < a->items[i].view.mesh_count; m++)
            if (a->items[i].view.meshes[m].name) names[count++] = a->items[i].view.meshes[m].name;
    const char *meant = sn_nearest_word(name, strlen(name), names);
    sn_status status = sn_fail(error, SN_ERROR_INPUT, "--focus: no muscle or bone that is drawn is called '%s'%s%s%s%s", name,
                               meant ? "; did you mean " : "", meant ? meant : "", meant ? "?" : "",
                               !meant && !given.all_bones ? "; bones that no muscle is attached to are drawn by --all-bones" : "");
    free(names);
    return status;
}

static sn_status focus_on(album *a, const char *name, sn_error *error) {
    size_t found = 0;
    for (size_t i = 0; i < a->count; i++) found += sn_view_focus(&a->items[i].view, name);
    return found > 0 ? SN_OK : fail_focus(a, name, error);
}

/* Names joined by commas; one with a comma in it can be written with a '?'. */
static sn_status focus(album *a, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < given.focus.count; i++)
        for (const char *text = given.focus.items[i]; *text && !status;) {
            size_t length = strcspn(text, ",");
            char *name = sn_strndup(text, length);
            if (!name) return sn_fail_memory(error, "a name");
            if (length > 0) status = focus_on(a, name, error);
            free(name);
            text += length + (text[length] == ',');
        }
    return status;
}

/* ---- cameras ------------------------------------------------------------------------------------------------------------- */

/* Stages of one muscle belong together: their extents are nearly the same. */
static bool same_place(const sn_camera *a, const sn_camera *b) {
    double size = sn_box_diagonal(a->extent);
    return sn_distance(a->extent.low, b->extent.low) < 0.15 * size && sn_distance(a->extent.high, b->extent.high) < 0.15 * size;
}

static void join_groups(album *a) {
    for (size_t i = 1; i < a->count; i++) {
        sn_camera here = sn_camera_from(0, 0), before = here;
        sn_camera_include(&here, &a->items[i].view);
        sn_camera_include(&before, &a->items[i - 1].view);
        if (same_place(&before, &here)) a->items[i].group = a->items[i - 1].group;
    }
}

/* From the front or the right, whichever shows a group wider. */
static sn_camera upright_camera(const album *a, sn_index group, double spin) {
    double widths[2];
    for (int i = 0; i < 2; i++) {
        sn_camera camera = sn_camera_from(90.0 * i, 0.0);
        for (size_t k = 0; k < a->count; k++)
            if (a->items[k].group == group) sn_camera_include(&camera, &a->items[k].view);
        widths[i] = camera.extent.high.x - camera.extent.low.x;
    }
    return sn_camera_from(spin + (widths[1] > widths[0] ? 90.0 : 0.0), 0.0);
}

static sn_camera camera_for(const album *a, sn_index group, const look *l, const sn_view_options *o) {
    sn_camera camera = sn_camera_from(l->azimuth, l->elevation);
    bool oriented = !l->automatic;
    if (given.cut && l->automatic) camera = section_camera(given.cut), oriented = true;
    for (size_t i = 0; i < a->count; i++) {
        if (a->items[i].group != group) continue;
        if (!oriented)
            camera =
                a->items[i].upright ? upright_camera(a, group, l->spin) : sn_camera_auto(&a->items[i].view, o->height > o->width, l->spin);
        oriented = true;
        sn_camera_include(&camera, &a->items[i].view);
    }
    camera.zoom = given.zoom;
    return camera;
}

/* ---- the sheet ----------------------------------------------------------------------------------------------------------- */

static const char *common_text(const album *a, bool title) {
    const char *first = title ? a->items[0].view.title : a->items[0].view.subtitle;
    for (size_t i = 1; i < a->count; i++) {
        const char *text = title ? a->items[i].view.title : a->items[i].view.subtitle;
        if (!first || !text || strcmp(first, text) != 0) return NULL;
    }
    return first;
}

typedef struct caption {
    char text[256];
} caption;

static caption tile_caption(const album *a, size_t item, const look *l) {
    caption out = {{0}};
    const char *name = a->count > 1 && a->items[item].caption ? a->items[item].caption : "";
    snprintf(out.text, sizeof out.text, "%s%s%s", name, *name && *l->caption ? ", " : "", l->caption);
    return out;
}

/* As high as the tallest subject needs, with room for a caption. */
static sn_index tile_height(size_t count, const sn_camera *cameras, sn_index width) {
    double tallest = 0.0;
    for (size_t i = 0; i < count; i++) {
        sn_vec3 size = sn_sub(cameras[i].extent.high, cameras[i].extent.low);
        if (size.x > 0.0) tallest = fmax(tallest, size.y / size.x);
    }
    return (sn_index)fmin(fmax(width * tallest + 64.0, 0.35 * width), width);
}

static sn_status draw(const album *a, const looks *views, sn_view_options *o, sn_image *image, sn_error *error) {
    size_t count = a->count * (size_t)views->count;
    sn_tile *tiles = SN_NEW(sn_tile, count);
    sn_camera *cameras = SN_NEW(sn_camera, count);
    caption *captions = SN_NEW(caption, count);
    sn_status status = tiles && cameras && captions ? SN_OK : sn_fail_memory(error, "the tiles");
    for (size_t i = 0; i < count && !status; i++) {
        size_t item = i / (size_t)views->count;
        const look *l = &views->items[i % (size_t)views->count];
        cameras[i] = camera_for(a, a->items[item].group, l, o);
        captions[i] = tile_caption(a, item, l);
        tiles[i] = (sn_tile){&a->items[item].view, &cameras[i], captions[i].text[0] ? captions[i].text : NULL};
    }
    if (!status && count > 1 && !given.size) o->height = tile_height(count, cameras, o->width);
    if (!o->columns && a->count > 1 && views->count > 1) o->columns = views->count;
    const char *title = given.title ? given.title : common_text(a, true);
    const sn_sheet sheet = {(sn_index)count, tiles, title, common_text(a, false)};
    if (!status) status = sn_sheet_render(&sheet, o, image, error);
    free(tiles);
    free(cameras);
    free(captions);
    return status;
}

static sn_status save(const cli *c, const sn_image *image, sn_output *output, sn_error *error) {
    unsigned char *data = NULL;
    size_t size = 0;
    sn_status status = sn_image_to_png(image, &data, &size, error);
    if (!status) status = sn_output_write(output, data, size, error);
    free(data);
    if (!status) cli_say(c, "%d x %d pixels", image->width, image->height);
    return status;
}

static sn_view_options picture_options(const cli *c, bool sheet) {
    sn_view_options o = sn_view_defaults();
    if (sheet) o.width = 480, o.height = 360;
    parse_size(c, &o);
    if (given.background) o.background = parse_color(c, given.background);
    o.samples = (int)ceil(sqrt((double)given.samples));
    o.threads = c->threads;
    o.legend = given.legend;
    o.columns = (sn_index)given.columns;
    return o;
}

/* Options that mean nothing together. */
static void check_options(const cli *c) {
    static const char *const names[] = {"error",   "range",          "scheme", "solver",   "precision",
                                        "stretch", "preconditioner", "law",    "substeps", "rate"};
    section_check(c, given.cut, given.cut_depth);
    if (given.neighbours.count > 0 && !given.cut && !(parse_show(c, given.show) & SN_SHOW_EXTERNALS))
        cli_usage_error(c, "--neighbours are drawn with --show externals or --cut");
    if (given.frame && given.frame_count > 0) cli_usage_error(c, "--frame and --frame-count both say which frames: leave out one");
    if (given.states.count > 0 && (given.frames || given.frame || given.frame_count > 0))
        cli_usage_error(c, "--state shows its own frame: leave out --frames, --frame and --frame-count");
    for (size_t i = 0; i < sizeof names / sizeof *names && given.states.count == 0; i++)
        if (cli_given(c, names[i])) cli_usage_error(c, "--%s needs --state FILE", names[i]);
}

static sn_status view_rigs(const cli *c, sn_error *error) {
    static const char *const standard_input[] = {"-"};
    cli_list inputs = c->inputs.count ? c->inputs : (cli_list){1, (const char **)(uintptr_t)standard_input};
    album a = {.c = c, .show = parse_show(c, given.show) | (given.all_bones ? SN_SHOW_ALL_BONES : 0)};
    looks views = parse_looks(c);
    sn_output *output = NULL;
    sn_image image = {0};
    picture_options(c, false); /* wrong words are told before any work */
    frames_parse(c, given.frame);
    parse_kinds(c);
    check_options(c);
    sn_status status = sn_output_open(c->output, false, &output, error);
    if (!status && sn_output_is_terminal(output))
        cli_usage_error(c, "a picture is not for a terminal; give -o FILE.png or redirect the output");
    if (!status) status = bones_name(c, &given.bones, &given.bone_lists, &a.bones, error);
    if (!status) status = bones_load(&a.bones, c->threads, error);
    if (!status) status = rigs_load(c, &given.neighbours, &a.rigs, error);
    for (int i = 0; i < inputs.count && !status; i++) status = add_input(&a, inputs.items[i], error);
    if (!status) status = focus(&a, error);
    if (!status) {
        join_groups(&a);
        sn_view_options o = picture_options(c, a.count * (size_t)views.count > 1);
        status = draw(&a, &views, &o, &image, error);
    }
    if (!status) status = save(c, &image, output, error);
    if (status)
        sn_output_abort(output);
    else
        status = sn_output_commit(output, error);
    sn_image_free(&image);
    album_free(&a);
    return status;
}

int main(int argc, char **argv) {
    cli c;
    sn_error error = {0};
    cli_start(&c, &tool, argc, argv);
    return cli_finish(&c, view_rigs(&c, &error), &error);
}
