/*
 * attach-detect.c -- find the vertices of a muscle that move with each bone.
 */
#include "cli.h"
#include "selector.h"
#include "sinew/thread.h"

#include <stdlib.h>
#include <string.h>

static const char *const method_names[] = {"both", "contact", "proximity", "none", NULL};
static const unsigned method_bits[] = {SN_ATTACH_CONTACT | SN_ATTACH_PROXIMITY, SN_ATTACH_CONTACT, SN_ATTACH_PROXIMITY, 0};
static const char *const unit_names[] = {"m", "cm", "mm", NULL};
static const double unit_meters[] = {1.0, 0.01, 0.001};
static const char *const up_names[] = {"z", "y", NULL};

static cli_list bone_texts, list_files, pin_texts;
static int method, bone_unit = -1, bone_up; /* bone_unit -1: the muscle's */
static sn_length distance = {-1.0, 0.0};

static const cli_option options[] = {
    {'b', "bone", "[NAME=]FILE", CLI_LIST, &bone_texts, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "a bone's mesh, any number of times; NAME is the file's base name by default"},
    {0, "bones", "LIST", CLI_LIST, &list_files, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "a text file with a bone a line: FILE, or NAME, a tab and FILE; relative to LIST"},
    {0, "pin", "NAME=SELECTOR", CLI_LIST, &pin_texts, CLI_RESULT, 0, 0, NULL,
     "attach the selected vertices to bone NAME, which needs no mesh, before all else"},
    {'m', "method", "METHOD", CLI_CHOICE, &method, CLI_RESULT, 0, 0, method_names,
     "contact (on or in the bone), proximity (closer than --distance), both (default), none (pins only)"},
    {'d', "distance", "LENGTH", CLI_LENGTH, &distance, CLI_RESULT, 0, 0, NULL,
     "reach of proximity (default: 0.1 mean edge lengths with contact, 1 alone)"},
    {0, "bone-units", "UNIT", CLI_CHOICE, &bone_unit, CLI_RESULT, 0, 0, unit_names,
     "unit of the bones: m, cm or mm (default: the muscle's)"},
    {0, "bone-up", "AXIS", CLI_CHOICE, &bone_up, CLI_RESULT, 0, 0, up_names,
     "up axis of the bones: z, or y, turned to z (default: as --up)"},
};

static const cli_tool tool = {
    .name = "attach-detect",
    .summary = "Find the vertices of a muscle that move with each bone.",
    .shared = CLI_CHAIN | CLI_HAS_THREADS,
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .notes = "SELECTOR: indices:3,4,5  near:x,y,z[,n]  sphere:x,y,z,r  box:x0,y0,z0,x1,y1,z1  plane:px,py,pz,nx,ny,nz\n"
             "          half:px,py,pz,nx,ny,nz  painted:NAME[>T]; in the document's unit",
};

/* ---- the bones that were named ------------------------------------------------------------------------------------------- */

typedef struct bone {
    char *name, *file; /* owned */
    sn_mesh mesh;      /* in the muscle's unit once loaded */
    double scale;      /* from its own unit to the muscle's */
    sn_status status;  /* of its loading, with error */
    sn_error error;
} bone;

typedef struct bone_list {
    size_t count, capacity;
    bone *items;
    double meters_per_unit; /* of the muscle */
    double own_unit;        /* --bone-units in metres; 0 = not given */
    bool up_y, up_given;
} bone_list;

static void free_bones(bone_list *list) {
    for (size_t i = 0; i < list->count; i++) {
        free(list->items[i].name);
        free(list->items[i].file);
        sn_mesh_free(&list->items[i].mesh);
    }
    free(list->items);
}

/* "bones/humerus.stl" -> "humerus" */
static char *base_name(const char *file) {
    const char *slash = strrchr(file, '/'), *start = slash != NULL ? slash + 1 : file, *dot = strrchr(start, '.');
    return dot != NULL && dot > start ? sn_strndup(start, (size_t)(dot - start)) : sn_strdup(start);
}

/* Takes ownership of name (NULL: the base name) and file. */
static sn_status add_bone(bone_list *list, char *name, char *file, sn_error *error) {
    void *items = list->items;
    if (name == NULL && file != NULL) name = base_name(file);
    if (name == NULL || file == NULL || !sn_grow(&items, &list->capacity, list->count + 1, sizeof *list->items)) {
        free(name);
        free(file);
        return sn_fail_memory(error, "the bones");
    }
    list->items = items;
    list->items[list->count++] = (bone){.name = name, .file = file};
    return SN_OK;
}

static sn_status add_bone_option(const cli *c, bone_list *list, const char *text, sn_error *error) {
    char *name = NULL;
    const char *file = text;
    if (strchr(text, '=') != NULL && !cli_split(text, &name, &file)) cli_usage_error(c, "--bone %s: write NAME=FILE or FILE", text);
    return add_bone(list, name, sn_strdup(file), error);
}

/* file as seen from the folder of list_name; absolute paths stay. */
static char *beside(const char *list_name, const char *file, size_t length) {
    const char *slash = strrchr(list_name, '/');
    size_t folder = slash != NULL && file[0] != '/' ? (size_t)(slash + 1 - list_name) : 0;
    char *path = sn_alloc(folder + length + 1, 1);
    if (path == NULL) return NULL;
    memcpy(path, list_name, folder);
    memcpy(path + folder, file, length);
    return path;
}

static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/* One line of a list, from text up to end: "FILE", "NAME<TAB>FILE", a comment or nothing. */
static sn_status add_list_line(bone_list *list, const char *list_name, int64_t line, const char *text, const char *end, sn_error *error) {
    while (text < end && is_space(*text)) text++;
    while (end > text && is_space(end[-1])) end--;
    if (text == end || *text == '#') return SN_OK;
    const char *tab = memchr(text, '\t', (size_t)(end - text)), *file = tab != NULL ? tab : text;
    while (is_space(*file)) file++;
    if (memchr(file, '\t', (size_t)(end - file)) != NULL || memchr(text, '\0', (size_t)(end - text)) != NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, list_name, line, "not a bone: write FILE, or NAME, one tab, FILE");
    char *name = tab != NULL ? sn_strndup(text, (size_t)(tab - text)) : NULL;
    return add_bone(list, name, beside(list_name, file, (size_t)(end - file)), error);
}

static sn_status add_list_file(bone_list *list, const char *list_name, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(list_name, &blob, error);
    int64_t line = 1;
    size_t before = list->count;
    for (const char *text = blob.data, *all = text + blob.size; text < all && status == SN_OK; line++) {
        const char *end = memchr(text, '\n', (size_t)(all - text));
        if (end == NULL) end = all;
        status = add_list_line(list, list_name, line, text, end, error);
        text = end + 1;
    }
    if (status == SN_OK && list->count == before)
        status = sn_fail_at(error, SN_ERROR_INPUT, list_name, 0, "names no bone; write the file of a bone a line");
    sn_blob_free(&blob);
    return status;
}

static sn_status name_bones(const cli *c, bone_list *list, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < bone_texts.count && status == SN_OK; i++) status = add_bone_option(c, list, bone_texts.items[i], error);
    for (int i = 0; i < list_files.count && status == SN_OK; i++) status = add_list_file(list, list_files.items[i], error);
    return status;
}

/* ---- loading them ----------------------------------------------------------------------------------------------------------- */

/* To the muscle's unit and z up: from what was asked for, else what the bone's file says, else what the muscle has. */
static void convert(const bone_list *list, bone *b, sn_mesh_frame frame) {
    double unit = list->own_unit > 0.0 ? list->own_unit : frame.meters_per_unit;
    bool up_y = list->up_given || frame.up == SN_UP_UNKNOWN ? list->up_y : frame.up == SN_UP_Y;
    b->scale = unit > 0.0 ? unit / list->meters_per_unit : 1.0;
    sn_mesh_convert(&b->mesh, b->scale, up_y);
}

static void load_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    bone_list *list = user;
    for (sn_index i = begin; i < end; i++) {
        bone *b = &list->items[i];
        sn_mesh_frame frame;
        b->status = sn_mesh_read_frame(b->file, &b->mesh, &frame, &b->error);
        if (b->status == SN_OK)
            convert(list, b, frame);
        else
            sn_error_set_file(&b->error, b->file);
    }
}

/* In parallel: a whole skeleton is read for every muscle. The first bone that failed, in the order given, is the error. */
static sn_status load_bones(const cli *c, bone_list *list, double meters_per_unit, sn_error *error) {
    list->meters_per_unit = meters_per_unit;
    list->own_unit = bone_unit >= 0 ? unit_meters[bone_unit] : 0.0;
    list->up_given = cli_given(c, "bone-up");
    list->up_y = cli_given(c, "bone-up") ? bone_up == 1 : c->read.up_y;
    sn_pool *pool = sn_pool_create(c->threads);
    sn_parallel_for(pool, (sn_index)list->count, 2, load_range, list);
    sn_pool_destroy(pool);
    for (size_t i = 0; i < list->count; i++) {
        if (list->items[i].status == SN_OK) continue;
        *error = list->items[i].error;
        return list->items[i].status;
    }
    return SN_OK;
}

/* ---- pins ---------------------------------------------------------------------------------------------------------------------- */

typedef struct pin_list {
    int count;
    sn_attach_pin *pins; /* (count) what the library sees; bone is owned here */
    selector *selectors; /* (count) */
} pin_list;

static void free_pins(pin_list *list) {
    for (int i = 0; i < list->count; i++) {
        free((char *)list->pins[i].bone);
        selector_free(&list->selectors[i]);
    }
    free(list->pins);
    free(list->selectors);
}

static sn_status parse_pins(const cli *c, pin_list *list, sn_error *error) {
    list->pins = SN_NEW(sn_attach_pin, pin_texts.count);
    list->selectors = SN_NEW(selector, pin_texts.count);
    if (list->pins == NULL || list->selectors == NULL) return sn_fail_memory(error, "the pins");
    for (int i = 0; i < pin_texts.count; i++) {
        char *name = NULL;
        const char *text = NULL;
        sn_error reason = {0};
        if (!cli_split(pin_texts.items[i], &name, &text)) cli_usage_error(c, "--pin %s: write NAME=SELECTOR", pin_texts.items[i]);
        sn_status status = selector_parse(text, &list->selectors[i], &reason);
        list->pins[i] = (sn_attach_pin){.bone = name, .selector = list->selectors[i].rule};
        list->count++;
        if (status == SN_ERROR_USAGE) cli_usage_error(c, "--pin %s: %s", name, reason.text);
        if (status != SN_OK) return sn_fail_memory(error, "the pins");
    }
    return SN_OK;
}

/* ---- the report ------------------------------------------------------------------------------------------------------------------- */

typedef struct outcome {
    const bone_list *bones;
    const sn_muscle *muscle;
    sn_attach_report report;
} outcome;

static void write_report(sn_json *json, const void *data) {
    const outcome *o = data;
    sn_json_text(json, "method", method_names[method]);
    sn_json_number(json, "distance", o->report.distance);
    sn_json_number(json, "metersPerUnit", o->muscle->meters_per_unit);
    sn_json_integer(json, "vertices", o->muscle->mesh.vertex_count);
    sn_json_integer(json, "attached", o->report.attached);
    sn_json_array(json, "attachments");
    for (sn_index i = 0; i < o->muscle->attachment_count; i++) {
        const sn_attachment *a = &o->muscle->attachments[i];
        sn_json_object(json, NULL);
        sn_json_text(json, "bone", a->bone);
        sn_json_text(json, "method", a->method);
        sn_json_integer(json, "vertices", a->count);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_array(json, "pairs");
    for (sn_index i = 0; i < o->report.pair_count; i++) {
        const sn_attach_pair *pair = &o->report.pairs[i];
        sn_json_object(json, NULL);
        sn_json_text(json, "bone", o->bones->items[pair->bone].name);
        sn_json_integer(json, "vertices", pair->vertices);
        sn_json_number(json, "nearest", pair->nearest);
        sn_json_bool(json, "culled", pair->culled);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void say_attachments(const cli *c, const sn_muscle *muscle) {
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        const sn_attachment *a = &muscle->attachments[i];
        cli_say(c, "%s: %ld vertices by %s", a->bone, (long)a->count, a->method);
    }
}

/* ---- nothing found: what would help ----------------------------------------------------------------------------------------------------
 */

static double box_gap(sn_box a, sn_box b) {
    sn_vec3 apart = sn_max3(sn_sub(a.low, b.high), sn_sub(b.low, a.high));
    return sn_norm(sn_max3(apart, sn_v3(0, 0, 0)));
}

/* The unit in which a bone's box would meet the muscle's where it does not now; -1 = none. */
static int fitting_unit(const outcome *o, const bone *b) {
    sn_box muscle = sn_mesh_box(&o->muscle->mesh), now = sn_mesh_box(&b->mesh);
    if (box_gap(muscle, now) == 0.0) return -1;
    for (int unit = 0; unit_names[unit] != NULL; unit++) {
        double factor = unit_meters[unit] / o->muscle->meters_per_unit / b->scale;
        sn_box box = {sn_scale(now.low, factor), sn_scale(now.high, factor)};
        if (box_gap(muscle, box) == 0.0 && sn_box_diagonal(box) < 1e3 * sn_box_diagonal(muscle)) return unit;
    }
    return -1;
}

static void warn_nothing(const cli *c, const outcome *o) {
    const sn_attach_pair *nearest = NULL;
    for (sn_index i = 0; i < o->report.pair_count; i++) {
        const sn_attach_pair *pair = &o->report.pairs[i];
        int unit = pair->culled ? fitting_unit(o, &o->bones->items[pair->bone]) : -1;
        if (unit >= 0) {
            cli_warn(c, "nothing attached; the bones lie far from the muscle, but would meet it with --bone-units %s", unit_names[unit]);
            return;
        }
        if (nearest == NULL || pair->nearest < nearest->nearest) nearest = pair;
    }
    if (nearest == NULL) {
        cli_warn(c, "nothing attached: no bone was looked at");
        return;
    }
    double millimetres = nearest->nearest * o->muscle->meters_per_unit * 1e3;
    const char *bone_name = o->bones->items[nearest->bone].name;
    if (nearest->culled)
        cli_warn(c, "nothing attached; the nearest bone, %s, is at least %.3g mm away: check --bone-units and --units, or raise --distance",
                 bone_name, millimetres);
    else
        cli_warn(c, "nothing attached; the nearest bone, %s, is %.3g mm away: a larger --distance would reach it", bone_name, millimetres);
}

/* ---- the work -------------------------------------------------------------------------------------------------------------------------
 */

static sn_status detect(cli *c, sn_muscle *muscle, const pin_list *pins, outcome *o, sn_error *error) {
    sn_attach_params params = sn_attach_defaults();
    params.methods = method_bits[method];
    params.distance = cli_length(distance, muscle->meters_per_unit);
    params.pin_count = pins->count;
    params.pins = pins->pins;
    params.threads = c->threads;
    sn_attach_bone *bones = SN_NEW(sn_attach_bone, o->bones->count);
    if (bones == NULL) return sn_fail_memory(error, "the bones");
    for (size_t i = 0; i < o->bones->count; i++) bones[i] = (sn_attach_bone){o->bones->items[i].name, &o->bones->items[i].mesh};
    sn_attachments_free(muscle->attachments, muscle->attachment_count);
    muscle->attachment_count = 0;
    muscle->has_attachments = true;
    sn_status status = sn_attach_detect(muscle, (sn_index)o->bones->count, bones, &params, &c->trace, &muscle->attachment_count,
                                        &muscle->attachments, &o->report, error);
    free(bones);
    return status;
}

static sn_status work(cli *c, sn_error *error) {
    bone_list bones = {0};
    pin_list pins = {0};
    cli_muscle document = {0};
    outcome o = {.bones = &bones, .muscle = &document.muscle};
    sn_status status = parse_pins(c, &pins, error);
    if (status == SN_OK) status = name_bones(c, &bones, error);
    if (status == SN_OK) status = cli_load(c, &document, error);
    if (status == SN_OK) status = load_bones(c, &bones, document.muscle.meters_per_unit, error);
    if (status == SN_OK) status = detect(c, &document.muscle, &pins, &o, error);
    if (status == SN_OK || status == SN_STOPPED) {
        if (o.report.attached == 0) warn_nothing(c, &o);
        say_attachments(c, &document.muscle);
        status = cli_save(c, &document, SN_SECTION_ATTACHMENTS, error);
    }
    if (status == SN_OK) status = cli_report(c, write_report, &o, error);
    sn_attach_report_free(&o.report);
    cli_free(&document);
    free_pins(&pins);
    free_bones(&bones);
    return status;
}

static void check_usage(const cli *c) {
    if (bone_texts.count == 0 && list_files.count == 0 && pin_texts.count == 0)
        cli_usage_error(c, "no bone and no pin; name bones with --bone or --bones, or vertices with --pin");
    if (method_bits[method] == 0 && pin_texts.count == 0) cli_usage_error(c, "--method none attaches pins only; give a --pin");
    if (distance.value >= 0.0 && !(method_bits[method] & SN_ATTACH_PROXIMITY))
        cli_usage_error(c, "--distance has no meaning with --method %s", method_names[method]);
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
    return cli_finish(&c, status, &error);
}
