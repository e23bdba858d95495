/* chain.c -- what the tools of the rig chain share: one document in, one out, with its history and report. */
#include "cli_given.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/rig.h"

/* One field of a line of fields parted by tabs. */
static void print_field(sn_output *output, const char *text) {
    for (; *text != '\0'; text++) sn_output_write(output, (unsigned char)*text < ' ' ? " " : text, 1, NULL);
}

sn_status cli_list_meshes(const sn_blob *blob, sn_error *error) {
    sn_mesh mesh = {0};
    sn_mesh_part *parts = NULL;
    sn_output *output = NULL;
    sn_index count = 0;
    sn_status status = sn_mesh_parse(blob, true, &mesh, error);
    if (status == SN_OK) status = sn_mesh_parts(&mesh, &parts, &count, error);
    if (status == SN_OK) status = sn_output_open("-", false, &output, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_output_print(output, "%d\t", i + 1);
        print_field(output, parts[i].name);
        status = sn_output_print(output, "\t%d\t%d\n", parts[i].vertices, parts[i].triangles);
    }
    if (output != NULL) status = sn_output_commit(output, error);
    free(parts);
    sn_mesh_free(&mesh);
    return status == SN_OK ? SN_STOPPED : status;
}

/* FNV-1a. */
static uint64_t mix(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 0x100000001b3U;
    return hash;
}

/* What an attachment adds to the number of its bone: the vertices, at which end, and whether by hand. */
static uint64_t mix_attachment(uint64_t hash, const sn_attachment *a) {
    hash = mix(hash, &a->end, sizeof a->end);
    hash = mix(hash, a->vertices, (size_t)a->count * sizeof *a->vertices);
    return a->reasons != NULL ? mix(hash, a->reasons, (size_t)a->count * sizeof *a->reasons) : hash;
}

static cli_held *find_held(cli_held *list, size_t count, const char *bone) {
    for (size_t i = 0; i < count; i++)
        if (strcmp(list[i].bone, bone) == 0) return &list[i];
    return NULL;
}

static void free_held(cli_held *list, size_t count) {
    for (size_t i = 0; i < count && list != NULL; i++) free(list[i].bone);
    free(list);
}

/* What each bone holds, in the order of the document. */
static sn_status list_held(const sn_muscle *muscle, cli_held **out, size_t *out_count, sn_error *error) {
    size_t count = 0;
    cli_held *list = SN_NEW(cli_held, muscle->attachment_count);
    sn_status status = list != NULL ? SN_OK : sn_fail_memory(error, "the attachments");
    for (sn_index i = 0; i < muscle->attachment_count && status == SN_OK; i++) {
        const sn_attachment *a = &muscle->attachments[i];
        cli_held *held = find_held(list, count, a->bone);
        if (held == NULL) {
            held = &list[count];
            *held = (cli_held){.bone = sn_strdup(a->bone), .hash = 0xcbf29ce484222325U};
            if (held->bone == NULL) status = sn_fail_memory(error, "the attachments");
            count += held->bone != NULL;
        }
        held->hash = mix_attachment(held->hash, a);
    }
    *out = list;
    *out_count = count;
    return status;
}

sn_status cli_load(cli *c, cli_muscle *out, sn_error *error) {
    sn_blob blob = {0};
    *out = (cli_muscle){0};
    sn_status status = sn_blob_read(c->inputs.items[0], &blob, error);
    if (status != SN_OK) return status;
    sn_hash(blob.data, blob.size, c->input_hash);
    status = c->list ? cli_list_meshes(&blob, error) : sn_muscle_parse(&blob, &c->read, &out->muscle, &out->document, error);
    if (status != SN_OK && status != SN_STOPPED) sn_error_set_file(error, blob.name);
    sn_blob_free(&blob);
    return status == SN_OK ? list_held(&out->muscle, &out->held_before, &out->held_count, error) : status;
}

sn_status cli_check_space(const sn_muscle *muscle, sn_space space, const char *file, sn_error *error) {
    sn_space_seen seen = sn_space_begin();
    sn_status status = sn_space_take(&seen, muscle->space, muscle->name != NULL ? muscle->name : "the muscle", error);
    return status == SN_OK && file != NULL ? sn_space_take(&seen, space, file, error) : status;
}

void cli_free(cli_muscle *muscle) {
    sn_document_free(muscle->document);
    sn_muscle_free(&muscle->muscle);
    free_held(muscle->held_before, muscle->held_count);
    *muscle = (cli_muscle){0};
}

/* ---- history ----------------------------------------------------------------------------------------------------------------- */

/* Canonical arguments of the options that change the result, in the order of the tool's table. */
typedef struct canonical {
    char **items; /* (count), each owned */
    size_t count, capacity;
} canonical;

static void free_canonical(canonical *args) {
    for (size_t i = 0; i < args->count; i++) free(args->items[i]);
    free(args->items);
}

static sn_status add_arg(canonical *args, char *text, sn_error *error) {
    if (text == NULL || !sn_grow((void **)&args->items, &args->capacity, args->count + 1, sizeof *args->items)) {
        free(text);
        return sn_fail_memory(error, "the history");
    }
    args->items[args->count++] = text;
    return SN_OK;
}

/* "NAME=FILE" or "FILE" with the file's content hash in place of its name. */
static sn_status add_file(canonical *args, const char *value, sn_error *error) {
    const char *equals = strchr(value, '='), *file = equals != NULL ? equals + 1 : value;
    sn_blob blob = {0};
    sn_status status = sn_blob_read(file, &blob, error);
    if (status != SN_OK) return status;
    char hash[SN_HASH_LENGTH];
    sn_hash(blob.data, blob.size, hash);
    sn_blob_free(&blob);
    size_t prefix = (size_t)(file - value);
    char *text = sn_alloc(prefix + sizeof hash, 1);
    if (text != NULL) {
        memcpy(text, value, prefix);
        memcpy(text + prefix, hash, sizeof hash);
    }
    return add_arg(args, text, error);
}

/* The hash that the tool makes of a list of files. */
static sn_status add_files(const cli *c, canonical *args, const char *value, sn_error *error) {
    char hash[SN_HASH_LENGTH];
    sn_status status = c->hash_files(c->hash_user, value, hash, error);
    return status == SN_OK ? add_arg(args, sn_strdup(hash), error) : status;
}

/* Numbers and lengths in their shortest form, so that 0.10 and 1e-1 leave the same history. */
static char *canonical_value(const cli_option *option, const char *value) {
    char buffer[48];
    sn_length length;
    double number;
    if (option->kind == CLI_NUMBER && sn_parse_number(value, &number, NULL) == SN_OK) {
        sn_format_number(number, buffer);
        return sn_strdup(buffer);
    }
    if (option->kind == CLI_LENGTH && sn_parse_length(value, &length, NULL) == SN_OK) {
        int used = sn_format_number(length.meters > 0.0 ? length.value * length.meters : length.value, buffer);
        snprintf(buffer + used, sizeof buffer - (size_t)used, "%s", length.meters > 0.0 ? "m" : "");
        return sn_strdup(buffer);
    }
    return sn_strdup(value);
}

static sn_status add_option(const cli *c, canonical *args, const cli_given_option *given, sn_error *error) {
    const cli_option *option = given->option;
    char name[80];
    snprintf(name, sizeof name, "--%s", option->name);
    sn_status status = add_arg(args, sn_strdup(name), error);
    if (status != SN_OK || given->value == NULL) return status;
    for (const char *const *word = option->choices; option->kind == CLI_TEXT && word != NULL && *word != NULL; word++)
        if (strcmp(*word, given->value) == 0) return add_arg(args, sn_strdup(given->value), error);
    if (option->flags & CLI_FILES) return add_files(c, args, given->value, error);
    if (option->flags & CLI_FILE) return add_file(args, given->value, error);
    return add_arg(args, canonical_value(option, given->value), error);
}

/* True if a later occurrence of the same option overrules this one. */
static bool overruled(const cli *c, int index) {
    const cli_option *option = c->given[index].option;
    if (option->kind == CLI_LIST) return false;
    for (int i = index + 1; i < c->given_count; i++)
        if (c->given[i].option == option) return true;
    return false;
}

static sn_status collect(const cli *c, canonical *args, sn_error *error) {
    const cli_option *option;
    for (int k = 0; (option = cli_option_at(c->tool, k)) != NULL; k++) {
        if (!(option->flags & CLI_RESULT)) continue;
        for (int i = 0; i < c->given_count; i++) {
            if (c->given[i].option != option || overruled(c, i)) continue;
            sn_status status = add_option(c, args, &c->given[i], error);
            if (status != SN_OK) return status;
        }
    }
    return SN_OK;
}

sn_status cli_history_make(const cli *c, cli_history *out, sn_error *error) {
    canonical args = {0};
    *out = (cli_history){0};
    sn_status status = collect(c, &args, error);
    if (status != SN_OK) {
        free_canonical(&args);
        return status;
    }
    out->args = args.items;
    out->entry = (sn_history_entry){
        .tool = c->tool->name, .arg_count = (int)args.count, .args = (const char *const *)args.items, .input = c->input_hash};
    return SN_OK;
}

void cli_history_free(cli_history *history) {
    free_canonical(&(canonical){.items = history->args, .count = (size_t)history->entry.arg_count});
    *history = (cli_history){0};
}

/* ---- saving ------------------------------------------------------------------------------------------------------------------- */

static sn_status write_document(cli *c, const cli_muscle *muscle, unsigned changed, sn_output *output, sn_error *error) {
    cli_history history = {0};
    sn_status status = c->history ? cli_history_make(c, &history, error) : SN_OK;
    const sn_write_options options = {changed, &history.entry, !c->history};
    if (status == SN_OK) status = sn_muscle_write(&muscle->muscle, muscle->document, &options, output, error);
    cli_history_free(&history);
    return status;
}

/* Does a section still hold? What it was made from must not have changed since, unless it has been made anew. */
static bool holds(unsigned changed, sn_section section, unsigned made_from) { return (changed & section) || !(changed & made_from); }

/* The bare mesh; with the sections that hold painted on it where the format has attributes. */
static sn_status write_mesh(const sn_muscle *muscle, unsigned changed, sn_mesh_format format, sn_output *output, sn_error *error) {
    if (!sn_mesh_format_has_attributes(format)) return sn_mesh_write(&muscle->mesh, format, SN_ENCODING_DEFAULT, output, error);
    const unsigned mesh = SN_SECTION_MESH, roots = mesh | SN_SECTION_ROOTS, structure = roots | SN_SECTION_STRUCTURE;
    sn_muscle shown = *muscle; /* borrows everything */
    if (!holds(changed, SN_SECTION_ROOTS, mesh)) shown.roots.count = 0;
    if (!holds(changed, SN_SECTION_STRUCTURE, roots)) shown.structure.sample_count = 0;
    if (!holds(changed, SN_SECTION_FIBERS, structure)) shown.fibers.directions = NULL;
    if (!holds(changed, SN_SECTION_ATTACHMENTS, mesh)) shown.attachment_count = 0;
    sn_mesh painted;
    sn_status status = sn_muscle_paint(&shown, &painted, error);
    if (status != SN_OK) return status;
    status = sn_mesh_write(&painted, format, SN_ENCODING_DEFAULT, output, error);
    sn_mesh_free(&painted);
    return status;
}

/* ---- what is older than the attachments ---------------------------------------------------------------------------------------- */

typedef struct later {
    const char *section, *tool;
} later;

enum { LATER = 4 };
static const later later_sections[LATER] = {
    {"roots", "root-select"}, {"structure", "build-structure"}, {"fiber directions", "fiber-flow"}, {"fibers", "fiber-fill"}};

/* Bits of later_sections that the attachments would be the ends of. */
static unsigned made_from_ends(const sn_muscle *muscle) {
    bool automatic = muscle->roots.count > 0 && muscle->roots.rule != NULL && strcmp(muscle->roots.rule, "mid-section") == 0;
    bool given = muscle->fibers.field != NULL && strcmp(muscle->fibers.field, "fibers") == 0;
    unsigned bits = automatic ? 1U : 0U;
    if (automatic && muscle->structure.sample_count > 0) bits |= 2U;
    if (muscle->fibers.directions != NULL && !given) bits |= 4U;
    if (muscle->fibers.polyline_count > 0) bits |= 8U;
    return bits;
}

/* "a, b and c" of the names that the bits say. */
static void join_later(unsigned bits, bool tools, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < LATER && used < size; i++) {
        if (!(bits & 1U << i)) continue;
        bool last = bits >> i == 1U;
        const char *name = tools ? later_sections[i].tool : later_sections[i].section;
        used += (size_t)snprintf(text + used, size - used, "%s%s", used == 0 ? "" : last ? " and " : ", ", name);
    }
}

enum { NAMES = 160, CHANGES = 3 * NAMES + 8 };

/* Adds a bone to "new: a, b" as long as there is room. */
static void add_name(char text[NAMES], const char *how, const char *bone) {
    size_t used = strlen(text);
    int length = snprintf(text + used, NAMES - used, "%s%s", used == 0 ? how : ", ", bone);
    if ((size_t)length >= NAMES - used) memcpy(text + NAMES - 5, ", ...", 5), text[NAMES - 1] = '\0';
}

/* "new: a; changed: b, c; gone: d": the bones that hold other vertices than before, or at another end. Empty where none does. */
static void describe_changes(const cli_muscle *muscle, cli_held *now, size_t count, char text[CHANGES]) {
    char parts[3][NAMES] = {"", "", ""};
    for (size_t i = 0; i < count; i++) {
        const cli_held *before = find_held(muscle->held_before, muscle->held_count, now[i].bone);
        if (before == NULL)
            add_name(parts[0], "new: ", now[i].bone);
        else if (before->hash != now[i].hash)
            add_name(parts[1], "changed: ", now[i].bone);
    }
    for (size_t i = 0; i < muscle->held_count; i++)
        if (find_held(now, count, muscle->held_before[i].bone) == NULL) add_name(parts[2], "gone: ", muscle->held_before[i].bone);
    const char *first = parts[0][0] != '\0' && (parts[1][0] != '\0' || parts[2][0] != '\0') ? "; " : "";
    const char *second = parts[1][0] != '\0' && parts[2][0] != '\0' ? "; " : "";
    snprintf(text, CHANGES, "%s%s%s%s%s", parts[0], first, parts[1], second, parts[2]);
}

static sn_status note_stale(cli *c, const cli_muscle *muscle, unsigned changed, sn_error *error) {
    char sections[80], tools[80], changes[CHANGES];
    cli_held *now = NULL;
    size_t count = 0;
    if (!(changed & SN_SECTION_ATTACHMENTS)) return SN_OK;
    sn_status status = list_held(&muscle->muscle, &now, &count, error);
    if (status == SN_OK) describe_changes(muscle, now, count, changes);
    free_held(now, count);
    if (status != SN_OK || changes[0] == '\0') return status;
    c->stale = made_from_ends(&muscle->muscle);
    if (c->stale == 0) return SN_OK;
    join_later(c->stale, false, sections, sizeof sections);
    join_later(c->stale, true, tools, sizeof tools);
    if (muscle->held_count == 0)
        cli_warn(c, "%s were made without these attachments, which are known now: run %s again", sections, tools);
    else
        cli_warn(c, "%s were made with other attachments (%s): run %s again", sections, changes, tools);
    return SN_OK;
}

static void report_stale(sn_json *json, unsigned stale) {
    if (stale == 0) return;
    sn_json_array(json, "stale");
    for (int i = 0; i < LATER; i++)
        if (stale & 1U << i) sn_json_text(json, NULL, later_sections[i].section);
    sn_json_close(json);
    sn_json_array(json, "runAgain");
    for (int i = 0; i < LATER; i++)
        if (stale & 1U << i) sn_json_text(json, NULL, later_sections[i].tool);
    sn_json_close(json);
}

sn_status cli_save(cli *c, const cli_muscle *muscle, unsigned changed, sn_error *error) {
    sn_mesh_format format = sn_mesh_format_from_name(c->output);
    sn_output *output = NULL;
    sn_status status = sn_output_open(c->output, false, &output, error);
    if (status != SN_OK) return status;
    if (format != SN_MESH_UNKNOWN)
        status = write_mesh(&muscle->muscle, changed, format, output, error);
    else
        status = write_document(c, muscle, changed, output, error);
    if (status != SN_OK) {
        sn_output_abort(output);
        return status;
    }
    status = note_stale(c, muscle, changed, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

/* ---- report --------------------------------------------------------------------------------------------------------------------- */

sn_status cli_report(cli *c, cli_report_writer write, const void *data, sn_error *error) {
    if (c->report == NULL) return SN_OK;
    sn_output *output = NULL;
    sn_status status = sn_output_open(c->report, false, &output, error);
    if (status != SN_OK) return status;
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) {
        sn_output_abort(output);
        return sn_fail_memory(error, "the report");
    }
    sn_json_object(json, NULL);
    sn_json_text(json, "format", "sinew-report");
    sn_json_text(json, "tool", c->tool->name);
    sn_json_text(json, "version", SN_VERSION);
    sn_json_number(json, "seconds", cli_seconds() - c->started);
    report_stale(json, c->stale);
    write(json, data);
    sn_json_close(json);
    status = sn_json_end(json, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

void cli_report_mesh(sn_json *json, const sn_mesh_report *report) {
    const struct {
        const char *name;
        sn_index value;
    } counts[] = {
        {"vertices", report->vertices},
        {"triangles", report->triangles},
        {"edges", report->edges},
        {"components", report->components},
        {"unusedVertices", report->unused_vertices},
        {"duplicateVertices", report->duplicate_vertices},
        {"degenerateTriangles", report->degenerate_triangles},
        {"duplicateTriangles", report->duplicate_triangles},
        {"sliverTriangles", report->sliver_triangles},
        {"boundaryEdges", report->boundary_edges},
        {"boundaryLoops", report->boundary_loops},
        {"nonManifoldEdges", report->nonmanifold_edges},
        {"nonManifoldVertices", report->nonmanifold_vertices},
        {"inconsistentEdges", report->inconsistent_edges},
    };
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) sn_json_integer(json, counts[i].name, counts[i].value);
    if (report->self_intersections >= 0) sn_json_integer(json, "selfIntersections", report->self_intersections);
    sn_json_number(json, "genus", report->genus);
    sn_json_number(json, "area", report->area);
    sn_json_number(json, "volume", report->volume);
    sn_json_number(json, "diagonal", report->diagonal);
    sn_json_vec3(json, "boxLow", report->box.low);
    sn_json_vec3(json, "boxHigh", report->box.high);
    sn_json_number(json, "edgeMin", report->edge_min);
    sn_json_number(json, "edgeMean", report->edge_mean);
    sn_json_number(json, "edgeMax", report->edge_max);
    sn_json_number(json, "worstQuality", report->worst_quality);
    sn_json_bool(json, "closed", report->closed);
    sn_json_bool(json, "manifold", report->manifold);
    sn_json_bool(json, "oriented", report->oriented);
    sn_json_bool(json, "outward", report->outward);
}

/* ---- ends --------------------------------------------------------------------------------------------------------------------- */

const char *const cli_ends_words[] = {"auto", NULL};

void cli_take_ends(const char **ends) {
    if (*ends != NULL && strcmp(*ends, cli_ends_words[0]) == 0) *ends = NULL;
}

void cli_report_ends(sn_json *json, const struct sn_ends_choice *choice) {
    sn_json_text(json, "ends", choice->from);
    sn_json_integer(json, "endsKnown", choice->known[0] + choice->known[1]);
    if (choice->why[0] != '\0') sn_json_text(json, "endsWhy", choice->why);
}

void cli_say_ends(const cli *c, const struct sn_ends_choice *choice) {
    int known = choice->known[0] + choice->known[1];
    if (choice->unused)
        cli_warn(c, "the ends are taken from %s%s: %s", choice->from, known == 1 ? " and a tip" : "", choice->why);
    else if (choice->refused && choice->why[0] != '\0')
        cli_tell(c, "the ends are taken from %s: %s", choice->from, choice->why);
    else
        cli_say(c, "the ends are taken from %s%s%s", choice->from, choice->why[0] != '\0' ? ": " : "", choice->why);
}
