/* sensor_names.c -- the names in sensors documents: sides, lists of muscles, what stands twice. */
#include "sensors_document.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- sides ------------------------------------------------------------------------------------------------------------------------- */

void sn_sides_free(sn_sides *sides) {
    for (sn_index w = 0; w < SN_SIDE_WORDS; w++) {
        free(sides->words[w]);
        for (sn_index k = 0; k < SN_SIDES; k++) free(sides->values[w][k]);
    }
    *sides = (sn_sides){0};
}

static sn_status parse_word(const sn_json_value *list, const char *word, sn_sides *out, sn_error *error) {
    sn_index count, w = out->word_count;
    sn_status status = sn_json_expect_list(list, SN_SIDES, &count, error);
    if (status != SN_OK) return status;
    if (w == SN_SIDE_WORDS) return sn_json_complain(list, error, "there are more than %d words for the sides", SN_SIDE_WORDS);
    if (count == 0 || (w > 0 && count != out->count))
        return sn_json_complain(list, error, "expected %s", w > 0 ? "as many sides as in the list before it" : "at least one side");
    out->word_count = w + 1;
    out->count = count;
    if ((out->words[w] = sn_strdup(word)) == NULL) return sn_fail_memory(error, "the sides");
    for (sn_index k = 0; k < count && status == SN_OK; k++) {
        sn_json_value value = sn_json_element(list, k);
        status = sn_json_require(&value, "what stands for a side in names", error);
        if (status == SN_OK) status = sn_json_get_text(&value, &out->values[w][k], error);
    }
    return status;
}

sn_status sn_sides_parse(const sn_json_value *value, sn_sides *out, sn_error *error) {
    *out = (sn_sides){0};
    if (!sn_json_has(value)) return SN_OK;
    if (sn_json_is_array(value)) return parse_word(value, "side", out, error);
    sn_status status = sn_json_expect_object(value, error);
    sn_json_value member = {0};
    while (status == SN_OK && sn_json_next(value, &member)) status = parse_word(&member, member.key, out, error);
    return status;
}

bool sn_text_has_side(const char *text) { return strchr(text, '{') != NULL; }

/* The word from text on up to a brace; SN_NONE = the sides have no such word. */
static sn_index find_word(const sn_sides *sides, const char *text, size_t length) {
    for (sn_index w = 0; w < sides->word_count; w++)
        if (strlen(sides->words[w]) == length && memcmp(sides->words[w], text, length) == 0) return w;
    return SN_NONE;
}

/* Append what stands for the word in braces at *text; SN_NONE as the side: of none. */
static sn_status replace_word(const sn_json_value *value, sn_side side, const char **text, char *name, size_t size, sn_error *error) {
    const char *end = strchr(*text, '}');
    size_t length = end != NULL ? (size_t)(end - *text - 1) : 0, used = strlen(name);
    sn_index word = side.side != SN_NONE && end != NULL ? find_word(side.sides, *text + 1, length) : SN_NONE;
    if (word == SN_NONE && side.side == SN_NONE)
        return sn_json_complain(value, error, "there is no side here for \"%s\": \"sides\" is missing, or the entry is one for all sides",
                                *text);
    if (word == SN_NONE) return sn_json_complain(value, error, "\"sides\" has no word for \"%s\"", *text);
    snprintf(name + used, size - used, "%s", side.sides->values[word][side.side]);
    *text = end + 1;
    return SN_OK;
}

sn_status sn_side_text(const sn_json_value *value, sn_side side, char **out, sn_error *error) {
    char *text = NULL, name[SN_NAME_LENGTH + 2] = "";
    sn_status status = sn_json_get_text(value, &text, error);
    if (status != SN_OK || text == NULL) return status;
    for (const char *at = text; *at != '\0' && status == SN_OK;) {
        size_t used = strlen(name);
        if (*at == '{')
            status = replace_word(value, side, &at, name, sizeof name, error);
        else if (used + 1 < sizeof name)
            name[used] = *at++; /* the rest is zeros */
        else
            at++;
    }
    free(text);
    if (status == SN_OK && (name[0] == '\0' || strlen(name) > SN_NAME_LENGTH))
        status = sn_json_complain(value, error, "a name has from 1 to %d characters", SN_NAME_LENGTH);
    if (status != SN_OK) return status;
    free(*out);
    return (*out = sn_strdup(name)) != NULL ? SN_OK : sn_fail_memory(error, "a name");
}

sn_status sn_side_value(const sn_json_value *value, sn_side side, sn_json_value *out, sn_error *error) {
    sn_json_value first = {0};
    *out = *value;
    if (!sn_json_has(value) || sn_json_is_array(value) || sn_json_is_text(value) || !sn_json_next(value, &first)) return SN_OK;
    if (side.side == SN_NONE) return sn_json_complain(value, error, "told by sides, but the entry is one for all sides");
    *out = sn_json_member(value, side.sides->values[0][side.side]);
    if (sn_json_has(out)) return SN_OK;
    return sn_json_complain(value, error, "nothing is told for the side \"%s\"", side.sides->values[0][side.side]);
}

/* ---- lists of names ---------------------------------------------------------------------------------------------------------------- */

static int compare_names(const void *a, const void *b) {
    const struct sn_indexed_name *x = a, *y = b;
    int order = strcmp(x->name, y->name);
    return order != 0 ? order : (x->at > y->at) - (x->at < y->at);
}

sn_status sn_name_index_create(sn_index count, const char *(*name_of)(const void *data, sn_index i), const void *data, sn_name_index *out,
                               sn_error *error) {
    *out = (sn_name_index){.count = count, .names = sn_alloc((size_t)count, sizeof *out->names)};
    if (out->names == NULL) return sn_fail_memory(error, "names");
    for (sn_index i = 0; i < count; i++) out->names[i] = (struct sn_indexed_name){name_of(data, i), i};
    qsort(out->names, (size_t)count, sizeof *out->names, compare_names);
    return SN_OK;
}

void sn_name_index_free(sn_name_index *index) {
    free(index->names);
    *index = (sn_name_index){0};
}

sn_index sn_name_index_find(const sn_name_index *index, const char *name) {
    sn_index low = 0, high = index->count;
    while (low < high) {
        sn_index middle = low + (high - low) / 2;
        if (strcmp(index->names[middle].name, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low < index->count && strcmp(index->names[low].name, name) == 0 ? index->names[low].at : SN_NONE;
}

const char *sn_name_index_twin(const sn_name_index *index) {
    for (sn_index i = 1; i < index->count; i++)
        if (strcmp(index->names[i - 1].name, index->names[i].name) == 0) return index->names[i].name;
    return NULL;
}

void sn_naming_add(sn_naming *naming, const char *name) {
    enum { NAMED = 5 };
    size_t used = strlen(naming->text);
    if (naming->count++ < NAMED) snprintf(naming->text + used, sizeof naming->text - used, "%s%.50s", used > 0 ? ", " : "", name);
}

const char *sn_naming_text(sn_naming *naming) {
    enum { NAMED = 5 };
    size_t used = strlen(naming->text);
    if (naming->count > NAMED) snprintf(naming->text + used, sizeof naming->text - used, " and %d more", (int)(naming->count - NAMED));
    return naming->text;
}

/* ---- names of muscles -------------------------------------------------------------------------------------------------------------- */

void sn_muscle_names_free(sn_muscle_names *list) {
    for (sn_index i = 0; i < list->count; i++) free(list->names[i]);
    free(list->names);
    *list = (sn_muscle_names){0};
}

static sn_status parse_scene_names(const sn_json_value *muscles, sn_muscle_names *out, sn_error *error) {
    sn_index count;
    sn_status status = sn_json_expect_list(muscles, SN_LIST_LIMIT, &count, error);
    if (status == SN_OK && (out->names = SN_NEW(char *, count)) == NULL) status = sn_fail_memory(error, "names");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value muscle = sn_json_element(muscles, i), name = sn_json_member(&muscle, "name");
        out->count = i + 1;
        status = sn_json_require(&name, "the name of the muscle, which its channel is called by", error);
        if (status == SN_OK) status = sn_json_get_text(&name, &out->names[i], error);
    }
    return status;
}

static sn_status parse_scene(const sn_blob *blob, sn_muscle_names *out, sn_error *error) {
    sn_json_tree *tree = NULL;
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status != SN_OK) return status;
    sn_json_value top = sn_json_top(tree), muscles = sn_json_member(&top, "muscles");
    status = sn_json_expect_format(&top, "sinew-scene", 1, error);
    if (status == SN_OK) status = parse_scene_names(&muscles, out, error);
    sn_json_tree_free(tree);
    return status;
}

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

static sn_status parse_line(const sn_blob *blob, const char *from, const char *to, sn_muscle_names *out, size_t *capacity,
                            sn_error *error) {
    while (from < to && is_blank(*from)) from++;
    while (from < to && is_blank(to[-1])) to--;
    if (from == to || *from == '#') return SN_OK;
    if (out->count >= SN_LIST_LIMIT || to - from > SN_NAME_LENGTH || memchr(from, '\0', (size_t)(to - from)) != NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is neither a scene nor a list of at most %d muscles, one a line",
                          SN_LIST_LIMIT);
    if (!sn_grow((void **)&out->names, capacity, (size_t)out->count + 1, sizeof *out->names)) return sn_fail_memory(error, "names");
    out->names[out->count] = sn_strndup(from, (size_t)(to - from));
    return out->names[out->count++] != NULL ? SN_OK : sn_fail_memory(error, "names");
}

static sn_status parse_lines(const sn_blob *blob, sn_muscle_names *out, sn_error *error) {
    sn_status status = SN_OK;
    size_t capacity = 0;
    sn_text_lines lines = sn_text_lines_of(blob->data, blob->size);
    for (const char *text, *end; status == SN_OK && sn_text_next_line(&lines, &text, &end);)
        status = parse_line(blob, text, end, out, &capacity, error);
    return status;
}

sn_status sn_muscle_names_parse(const sn_blob *blob, sn_muscle_names *out, sn_error *error) {
    *out = (sn_muscle_names){0};
    sn_status status = sn_json_detect(blob) ? parse_scene(blob, out, error) : parse_lines(blob, out, error);
    if (status == SN_OK && out->count == 0) status = sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "names no muscle");
    if (status != SN_OK) {
        sn_error_set_file(error, blob->name);
        sn_muscle_names_free(out);
    }
    return status;
}
