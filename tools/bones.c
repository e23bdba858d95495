/*
 * bones.c -- the bones, or the muscles, that a tool is given: one by one, a line each in a list, or all of a folder.
 */
#include "bones.h"
#include "folder.h"
#include "sinew/thread.h"

#include <stdlib.h>
#include <string.h>

void bones_free(bone_list *list) {
    for (size_t i = 0; i < list->count; i++) {
        free(list->items[i].name);
        free(list->items[i].file);
        sn_mesh_free(&list->items[i].mesh);
    }
    free(list->items);
    *list = (bone_list){0};
}

/* ---- naming ----------------------------------------------------------------------------------------------------------------- */

/* "bones/humerus.stl" -> "humerus" */
static char *base_name(const char *file) {
    const char *slash = strrchr(file, '/'), *start = slash != NULL ? slash + 1 : file, *dot = strrchr(start, '.');
    return dot != NULL && dot > start ? sn_strndup(start, (size_t)(dot - start)) : sn_strdup(start);
}

/* Takes ownership of name (NULL: the base name) and file. */
static sn_status add_bone(bone_list *list, char *name, char *file, const char *list_name, sn_error *error) {
    void *items = list->items;
    bool named = name != NULL;
    if (name == NULL && file != NULL) name = base_name(file);
    if (name == NULL || file == NULL || !sn_grow(&items, &list->capacity, list->count + 1, sizeof *list->items)) {
        free(name);
        free(file);
        return sn_fail_memory(error, "the bones");
    }
    list->items = items;
    list->items[list->count++] = (bone){.name = name, .file = file, .named = named, .list = list_name};
    return SN_OK;
}

static sn_status add_bone_option(const cli *c, bone_list *list, const char *text, sn_error *error) {
    char *name = NULL;
    const char *file = text;
    if (strchr(text, '=') != NULL && !cli_split(text, &name, &file)) cli_usage_error(c, "--bone %s: write NAME=FILE or FILE", text);
    return add_bone(list, name, sn_strdup(file), NULL, error);
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

static const char *kind_of(const bone_list *list) { return list->rigs ? "muscle" : "bone"; }

static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/* One line of a list, from text up to end: "FILE", "NAME<TAB>FILE", a comment or nothing. */
static sn_status add_list_line(bone_list *list, const char *list_name, int64_t line, const char *text, const char *end, sn_error *error) {
    while (text < end && is_space(*text)) text++;
    while (end > text && is_space(end[-1])) end--;
    if (text == end || *text == '#') return SN_OK;
    const char *tab = memchr(text, '\t', (size_t)(end - text)), *file = tab != NULL ? tab : text;
    while (is_space(*file)) file++;
    if (memchr(file, '\t', (size_t)(end - file)) != NULL || memchr(text, '\0', (size_t)(end - text)) != NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, list_name, line, "not a %s: write FILE, or NAME, one tab, FILE", kind_of(list));
    char *name = tab != NULL ? sn_strndup(text, (size_t)(tab - text)) : NULL;
    return add_bone(list, name, beside(list_name, file, (size_t)(end - file)), list_name, error);
}

static sn_status add_list_file(bone_list *list, const char *list_name, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(list_name, &blob, error);
    size_t before = list->count;
    sn_text_lines lines = sn_text_lines_of(blob.data, blob.size);
    for (const char *text, *end; status == SN_OK && sn_text_next_line(&lines, &text, &end);)
        status = add_list_line(list, list_name, lines.line, text, end, error);
    if (status == SN_OK && list->count == before)
        status =
            sn_fail_at(error, SN_ERROR_INPUT, list_name, 0, "names no %s; write the file of a %s a line", kind_of(list), kind_of(list));
    sn_blob_free(&blob);
    return status;
}

static bool is_mesh(const char *name) { return sn_mesh_format_from_name(name) != SN_MESH_UNKNOWN; }

static bool is_rig(const char *name) {
    size_t length = strlen(name), tail = strlen(".muscle.json");
    return length > tail && strcmp(name + length - tail, ".muscle.json") == 0;
}

static sn_status add_folder(bone_list *list, const char *folder, sn_error *error) {
    char **paths;
    int count;
    sn_status status = folder_list(folder, list->rigs ? is_rig : is_mesh, &paths, &count, error);
    if (status == SN_OK && count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, folder, 0, "no %s is in it",
                            list->rigs ? "rig (*.muscle.json)" : "mesh (.obj .ply .stl .off .vtk .vtp)");
    for (int i = 0; i < count && status == SN_OK; i++) {
        char *path = paths[i];
        paths[i] = NULL; /* the list has it now */
        status = add_bone(list, NULL, path, folder, error);
    }
    folder_free(paths, count);
    return status;
}

sn_status bones_name(const cli *c, const cli_list *files, const cli_list *lists, bone_list *out, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < files->count && status == SN_OK; i++) status = add_bone_option(c, out, files->items[i], error);
    for (int i = 0; i < lists->count && status == SN_OK; i++)
        status = folder_is(lists->items[i]) ? add_folder(out, lists->items[i], error) : add_list_file(out, lists->items[i], error);
    return status;
}

/* ---- loading ------------------------------------------------------------------------------------------------------------------ */

/* To the unit asked for and z up. */
static void convert(const bone_list *list, bone *b, sn_mesh_frame frame) {
    double unit = list->given_unit > 0.0 ? list->given_unit : frame.meters_per_unit;
    bool up_y = list->up_given || frame.up == SN_UP_UNKNOWN ? list->up_y : frame.up == SN_UP_Y;
    b->own_unit = frame.meters_per_unit;
    b->space = frame.space;
    b->scale = unit > 0.0 && list->meters_per_unit > 0.0 ? unit / list->meters_per_unit : 1.0;
    sn_mesh_convert(&b->mesh, b->scale, up_y);
}

static void load_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    bone_list *list = user;
    for (sn_index i = begin; i < end; i++) {
        bone *b = &list->items[i];
        sn_mesh_frame frame;
        b->status = sn_mesh_read(b->file, &b->mesh, &frame, &b->error);
        if (b->status == SN_OK) b->status = sn_mesh_validate(&b->mesh, &b->error);
        if (b->status == SN_OK)
            convert(list, b, frame);
        else
            sn_error_set_file(&b->error, b->file);
    }
}

sn_status bones_load(bone_list *list, int threads, sn_error *error) {
    sn_pool *pool = sn_pool_create(threads);
    sn_parallel_for(pool, (sn_index)list->count, 2, load_range, list);
    sn_pool_destroy(pool);
    for (size_t i = 0; i < list->count; i++) {
        if (list->items[i].status == SN_OK) continue;
        *error = list->items[i].error;
        return list->items[i].status;
    }
    return SN_OK;
}

sn_status bones_check_spaces(const bone_list *list, const sn_muscle *muscle, sn_error *error) {
    sn_space_seen seen = sn_space_begin();
    sn_status status = SN_OK;
    if (muscle != NULL) status = sn_space_take(&seen, muscle->space, muscle->name != NULL ? muscle->name : "the muscle", error);
    for (size_t i = 0; i < list->count && status == SN_OK; i++)
        status = sn_space_take(&seen, list->items[i].space, list->items[i].name, error);
    return status;
}

/* ---- the history ---------------------------------------------------------------------------------------------------------------- */

typedef struct text {
    size_t size, capacity;
    char *data;
} text;

static bool append(text *t, const char *word) {
    size_t length = strlen(word);
    if (!sn_grow((void **)&t->data, &t->capacity, t->size + length + 1, 1)) return false;
    memcpy(t->data + t->size, word, length);
    t->size += length;
    return true;
}

/* "NAME" and, of a bone in use, a tab and the hash of its file. */
static sn_status append_bone(text *t, const bone *b, sn_error *error) {
    char hash[SN_HASH_LENGTH] = "";
    sn_blob blob = {0};
    if (b->used) {
        sn_status status = sn_blob_read(b->file, &blob, error);
        if (status != SN_OK) return status;
        sn_hash(blob.data, blob.size, hash);
        sn_blob_free(&blob);
    }
    bool enough = append(t, b->name) && append(t, "\t") && append(t, hash) && append(t, "\n");
    return enough ? SN_OK : sn_fail_memory(error, "the history");
}

sn_status bones_hash(const void *user, const char *value, char out[SN_HASH_LENGTH], sn_error *error) {
    const bone_list *list = user;
    text all = {0};
    sn_status status = SN_OK;
    for (size_t i = 0; i < list->count && status == SN_OK; i++)
        if (list->items[i].list != NULL && strcmp(list->items[i].list, value) == 0) status = append_bone(&all, &list->items[i], error);
    if (status == SN_OK) sn_hash(all.data != NULL ? all.data : "", all.size, out);
    free(all.data);
    return status;
}
