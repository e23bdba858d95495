/* xml_tree.c -- the tree of xml_tree.h, built by one walk over the file. */
#include "xml_tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Models have some ten thousand; this bounds memory where a file is nothing but tags. */
enum { MOST_ELEMENTS = 1 << 19, MOST_LINES = INT32_MAX, MOST_NUMBERS = 1 << 18 };

typedef struct builder {
    sn_xml_tree *tree;
    sn_error *error;
} builder;

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/* ---- built ----------------------------------------------------------------------------------------------------------------------- */

/* Places are bytes: a file of two bytes a character would be read wrong. */
static bool stands_there(const sn_blob *blob, const sn_xml_tag *tag) {
    size_t length = strlen(tag->name);
    return blob->size - tag->begin > length && memcmp(blob->data + tag->begin + 1, tag->name, length) == 0;
}

static sn_status on_start(void *user, const sn_xml_tag *tag) {
    builder *b = user;
    sn_xml_tree *tree = b->tree;
    if (!stands_there(tree->blob, tag))
        return sn_fail_at(b->error, SN_ERROR_INPUT, tree->blob->name, tag->line, "the file is not in UTF-8; convert it");
    if (tree->count == MOST_ELEMENTS || tag->line >= MOST_LINES)
        return sn_fail_at(b->error, SN_ERROR_INPUT, tree->blob->name, tag->line, "the file has more than %d elements; no model needs that",
                          (int)MOST_ELEMENTS);
    void *elements = tree->elements;
    if (!sn_grow(&elements, &tree->capacity, (size_t)tree->count + 1, sizeof *tree->elements)) return sn_fail_memory(b->error, "a model");
    tree->elements = elements;
    sn_index index = tree->count++;
    tree->elements[index] = (sn_xml_element){tag->begin, tag->end, tag->end, (int32_t)tag->line, tree->open, SN_NONE, SN_NONE};
    if (tree->last != SN_NONE)
        tree->elements[tree->last].next = index;
    else if (tree->open != SN_NONE)
        tree->elements[tree->open].child = index;
    tree->open = index;
    tree->last = SN_NONE;
    return SN_OK;
}

static sn_status on_end(void *user, const sn_xml_tag *tag) {
    sn_xml_tree *tree = ((builder *)user)->tree;
    sn_xml_element *element = &tree->elements[tree->open];
    element->close = tag->begin > element->text ? tag->begin : element->text;
    tree->last = tree->open;
    tree->open = element->parent;
    return SN_OK;
}

sn_status sn_xml_tree_parse(const sn_blob *blob, sn_xml_tree *out, sn_error *error) {
    *out = (sn_xml_tree){.blob = blob, .open = SN_NONE, .last = SN_NONE};
    builder b = {out, error};
    sn_status status = sn_xml_walk(blob, on_start, on_end, &b, error);
    if (status != SN_OK) sn_xml_tree_free(out);
    return status;
}

void sn_xml_tree_free(sn_xml_tree *tree) {
    free(tree->elements);
    *tree = (sn_xml_tree){0};
}

/* ---- elements ---------------------------------------------------------------------------------------------------------------------- */

sn_status sn_xml_fail(const sn_xml_tree *tree, sn_index element, sn_error *error, const char *format, ...) {
    sn_error said = {0};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(said.text, sizeof said.text, format, arguments);
    va_end(arguments);
    for (char *c = said.text; *c != '\0'; c++)
        if ((unsigned char)*c < ' ') *c = ' '; /* words of the file may hold anything */
    return sn_fail_at(error, SN_ERROR_INPUT, tree->blob->name, element != SN_NONE ? tree->elements[element].line : 0, "%s", said.text);
}

sn_span sn_xml_name(const sn_xml_tree *tree, sn_index element) {
    if (element == SN_NONE) return (sn_span){"", 0};
    const char *name = tree->blob->data + tree->elements[element].begin + 1;
    size_t length = 0;
    while (!is_blank(name[length]) && name[length] != '>' && name[length] != '/') length++;
    return (sn_span){name, length};
}

bool sn_xml_is(const sn_xml_tree *tree, sn_index element, const char *name) { return sn_span_is(sn_xml_name(tree, element), name); }

static sn_index first_of(const sn_xml_tree *tree, sn_index element, const char *name) {
    while (element != SN_NONE && name != NULL && !sn_xml_is(tree, element, name)) element = tree->elements[element].next;
    return element;
}

sn_index sn_xml_child(const sn_xml_tree *tree, sn_index element, const char *name) {
    return element == SN_NONE ? SN_NONE : first_of(tree, tree->elements[element].child, name);
}

sn_index sn_xml_next(const sn_xml_tree *tree, sn_index element, const char *name) {
    return element == SN_NONE ? SN_NONE : first_of(tree, tree->elements[element].next, name);
}

sn_index sn_xml_find(const sn_xml_tree *tree, sn_index within, sn_index after, const char *name) {
    if (within == SN_NONE) return SN_NONE;
    size_t end = tree->elements[within].close;
    for (sn_index i = after == SN_NONE ? within + 1 : after + 1; i < tree->count && tree->elements[i].begin < end; i++)
        if (sn_xml_is(tree, i, name)) return i;
    return SN_NONE;
}

/* ---- text -------------------------------------------------------------------------------------------------------------------------- */

static bool starts(sn_span s, const char *with) {
    size_t length = strlen(with);
    return s.length >= length && memcmp(s.text, with, length) == 0;
}

static void skip(sn_span *s, size_t count) {
    s->text += count;
    s->length -= count;
}

sn_span sn_xml_text(const sn_xml_tree *tree, sn_index element) {
    if (element == SN_NONE) return (sn_span){NULL, 0};
    const sn_xml_element *e = &tree->elements[element];
    sn_span s = {tree->blob->data + e->text, e->close - e->text};
    while (s.length > 0 && (is_blank(*s.text) || starts(s, "<!--"))) {
        if (is_blank(*s.text)) {
            skip(&s, 1);
            continue;
        }
        do skip(&s, 1);
        while (s.length > 0 && !starts(s, "-->"));
        skip(&s, s.length < 3 ? s.length : 3);
    }
    const char *tag = s.length > 0 ? memchr(s.text, '<', s.length) : NULL;
    if (tag != NULL) s.length = (size_t)(tag - s.text);
    while (s.length > 0 && is_blank(s.text[s.length - 1])) s.length--;
    return s;
}

sn_span sn_xml_child_text(const sn_xml_tree *tree, sn_index element, const char *name) {
    return sn_xml_text(tree, sn_xml_child(tree, element, name));
}

/* The parser has found the tag well formed: NAME = "VALUE", blanks between. */
sn_span sn_xml_attribute_text(const sn_xml_tree *tree, sn_index element, const char *name) {
    if (element == SN_NONE) return (sn_span){NULL, 0};
    sn_span tag = sn_xml_name(tree, element);
    const char *at = tag.text + tag.length, *end = tree->blob->data + tree->elements[element].text;
    while (at < end) {
        while (at < end && is_blank(*at)) at++;
        const char *start = at;
        while (at < end && *at != '=' && !is_blank(*at)) at++;
        sn_span found = {start, (size_t)(at - start)};
        while (at < end && *at != '"' && *at != '\'') at++;
        const char *close = at < end ? memchr(at + 1, *at, (size_t)(end - at - 1)) : NULL;
        if (close == NULL) break;
        if (sn_span_is(found, name)) return (sn_span){at + 1, (size_t)(close - at - 1)};
        at = close + 1;
    }
    return (sn_span){NULL, 0};
}

char *sn_xml_copy(sn_span s) {
    static const char *const entities[] = {"&lt;", "&gt;", "&amp;", "&quot;", "&apos;"};
    static const char characters[] = "<>&\"'";
    char *copy = sn_alloc(s.length + 1, 1);
    for (size_t length = 0; copy != NULL && s.length > 0;) {
        size_t which = 0;
        while (which < 5 && !starts(s, entities[which])) which++;
        copy[length++] = which < 5 ? characters[which] : *s.text;
        skip(&s, which < 5 ? strlen(entities[which]) : 1);
    }
    return copy;
}

sn_span sn_xml_word(sn_span *s) {
    while (s->length > 0 && is_blank(*s->text)) skip(s, 1);
    sn_span word = {s->text, 0};
    while (s->length > 0 && !is_blank(*s->text)) {
        word.length++;
        skip(s, 1);
    }
    return word;
}

/* ---- numbers ------------------------------------------------------------------------------------------------------------------------- */

sn_xml_value sn_xml_child_value(const sn_xml_tree *tree, sn_index element, const char *name) {
    return (sn_xml_value){tree, element, name, sn_xml_child_text(tree, element, name)};
}

sn_xml_value sn_xml_attribute_value(const sn_xml_tree *tree, sn_index element, const char *name) {
    return (sn_xml_value){tree, element, name, sn_xml_attribute_text(tree, element, name)};
}

static sn_status read_number(const sn_xml_value *value, sn_span word, double *out, sn_error *error) {
    const char *next;
    if (sn_scan_number(word.text, word.text + word.length, &next, out) && next == word.text + word.length && isfinite(*out)) return SN_OK;
    return sn_xml_fail(value->tree, value->element, error, "%s: \"%.*s\" is no finite number", value->name,
                       (int)(word.length < 40 ? word.length : 40), word.text);
}

sn_status sn_xml_all_numbers(sn_xml_value value, sn_index *count, double **out, sn_error *error) {
    sn_span rest = value.text;
    size_t capacity = 0;
    void *numbers = NULL;
    sn_status status = SN_OK;
    *count = 0;
    *out = NULL;
    while (status == SN_OK) {
        sn_span word = sn_xml_word(&rest);
        if (word.length == 0) break;
        if (*count == MOST_NUMBERS) {
            status = sn_xml_fail(value.tree, value.element, error, "%s: more than %d numbers", value.name, (int)MOST_NUMBERS);
        } else if (!sn_grow(&numbers, &capacity, (size_t)*count + 1, sizeof **out)) {
            status = sn_fail_memory(error, "numbers of a model");
        } else {
            status = read_number(&value, word, (double *)numbers + *count, error);
            (*count)++;
        }
    }
    if (status == SN_OK) {
        *out = numbers;
        return SN_OK;
    }
    free(numbers);
    return status;
}

sn_status sn_xml_numbers(sn_xml_value value, sn_index count, double *out, sn_error *error) {
    sn_span rest = value.text, words = value.text;
    sn_index found = 0;
    for (sn_span word = sn_xml_word(&rest); word.length > 0; word = sn_xml_word(&rest)) found++;
    if (found == 0) return SN_OK;
    if (found != count)
        return sn_xml_fail(value.tree, value.element, error, "%s: %d numbers where %d are needed", value.name, (int)found, (int)count);
    sn_status status = SN_OK;
    for (sn_index i = 0; i < count && status == SN_OK; i++) { status = read_number(&value, sn_xml_word(&words), &out[i], error); }
    return status;
}

sn_status sn_xml_bool(sn_xml_value value, bool *out, sn_error *error) {
    sn_span span = value.text;
    if (span.length == 0) return SN_OK;
    bool yes = sn_span_is_like(span, "true") || sn_span_is(span, "1"), no = sn_span_is_like(span, "false") || sn_span_is(span, "0");
    if (!yes && !no) return sn_xml_fail(value.tree, value.element, error, "%s: expected true or false", value.name);
    *out = yes;
    return SN_OK;
}
