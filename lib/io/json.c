/* json.c -- JSON in: parse, typed access with the path in every error, pass on. The only user of jansson. */
#include "json.h"

#include <jansson.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One array of numbers: where it is in the text, and where its stand-in "[k]" is in the folded text. */
typedef struct span {
    size_t begin, end; /* from its '[' to behind its ']' */
    size_t folded;     /* of the stand-in's '[' */
    size_t count;      /* of numbers, at least one */
} span;

/* What warnings a tree has caused so far. */
typedef struct told_members {
    int64_t objects;
} told_members;

struct sn_json_tree {
    char *name; /* of the file */
    char *text;
    size_t size;
    json_t *root;
    span *spans; /* (span_count) ascending */
    size_t span_count, span_capacity;
    told_members *told; /* owned */
};

/* ---- the grammar of RFC 8259, as far as folding needs it -------------------------------------------------------------- */

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static const char *skip_blanks(const char *at, const char *end) {
    while (at < end && is_blank(*at)) at++;
    return at;
}

static const char *skip_digits(const char *at, const char *end) {
    while (at < end && is_digit(*at)) at++;
    return at;
}

/* Behind the quoted string that starts at `at`, or end where it is not closed. */
static const char *skip_string(const char *at, const char *end) {
    for (at++; at < end; at++) {
        if (*at == '"') return at + 1;
        if (*at == '\\') at++;
    }
    return end;
}

/* Could this many characters be a number too large for a double? Only those need a look. */
static bool may_overflow(const char *begin, const char *exponent, const char *end) { return end - exponent > 3 || exponent - begin > 300; }

/* Behind the number that starts at `at`; NULL = no number, or one beyond the range of a double: the parser proper says so. */
static const char *skip_number(const char *at, const char *end) {
    const char *begin = at, *digits;
    if (at < end && *at == '-') at++;
    digits = at;
    at = skip_digits(at, end);
    if (at == digits || (*digits == '0' && at - digits > 1)) return NULL;
    if (at < end && *at == '.') {
        digits = ++at;
        if ((at = skip_digits(at, end)) == digits) return NULL;
    }
    const char *exponent = at;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        if (at < end && (*at == '-' || *at == '+')) at++;
        digits = at;
        if ((at = skip_digits(at, end)) == digits) return NULL;
    }
    double value;
    const char *next;
    if (may_overflow(begin, exponent, at) && !(sn_scan_number(begin, at, &next, &value) && isfinite(value))) return NULL;
    return at;
}

/* Behind the array of numbers that starts at `at`, and how many they are; NULL = it is empty or holds something else. */
static const char *skip_number_array(const char *at, const char *end, size_t *count) {
    *count = 0;
    do {
        at = skip_number(skip_blanks(at + 1, end), end);
        if (at == NULL) return NULL;
        at = skip_blanks(at, end);
        ++*count;
    } while (at < end && *at == ',');
    return at < end && *at == ']' ? at + 1 : NULL;
}

/* ---- folding ---------------------------------------------------------------------------------------------------------- */

typedef struct folded {
    char *text;
    size_t size, capacity;
} folded;

static bool append(folded *to, const char *text, size_t size) {
    if (!sn_grow((void **)&to->text, &to->capacity, to->size + size + 1, 1)) return false;
    memcpy(to->text + to->size, text, size);
    to->size += size;
    return true;
}

static bool append_span(sn_json_tree *tree, folded *to, span found) {
    char stand_in[32];
    int length = snprintf(stand_in, sizeof stand_in, "[%zu]", tree->span_count);
    if (!sn_grow((void **)&tree->spans, &tree->span_capacity, tree->span_count + 1, sizeof *tree->spans)) return false;
    found.folded = to->size;
    tree->spans[tree->span_count++] = found;
    return append(to, stand_in, (size_t)length);
}

/* Every array of numbers in the text is replaced: so each array of one integer that the parser sees afterwards is a stand-in. */
static bool fold(sn_json_tree *tree, folded *to) {
    const char *end = tree->text + tree->size, *at = tree->text, *copied = at, *behind;
    while (at < end) {
        span found = {.begin = (size_t)(at - tree->text)};
        if (*at == '"') {
            at = skip_string(at, end);
        } else if (*at == '[' && (behind = skip_number_array(at, end, &found.count)) != NULL) {
            found.end = (size_t)(behind - tree->text);
            if (!append(to, copied, (size_t)(at - copied)) || !append_span(tree, to, found)) return false;
            at = copied = behind;
        } else {
            at++;
        }
    }
    return append(to, copied, (size_t)(end - copied));
}

/* Where a byte of the folded text is in the text. */
static size_t unfold(const sn_json_tree *tree, size_t position) {
    size_t low = 0, high = tree->span_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (tree->spans[middle].folded <= position)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0) return position;
    const span *last = &tree->spans[low - 1];
    char stand_in[32];
    size_t length = (size_t)snprintf(stand_in, sizeof stand_in, "[%zu]", low - 1);
    return position < last->folded + length ? last->begin : last->end + (position - last->folded - length);
}

/* Line, and column in characters, of a byte of the text. */
static void set_place(sn_error *error, const sn_json_tree *tree, size_t offset) {
    if (error == NULL) return;
    int64_t line = 1, column = 1;
    for (size_t i = 0; i < offset && i < tree->size; i++) {
        unsigned char c = (unsigned char)tree->text[i];
        if (c == '\n')
            line++, column = 1;
        else if ((c & 0xC0) != 0x80)
            column++;
    }
    error->line = line;
    error->column = column;
}

/* ---- parse ------------------------------------------------------------------------------------------------------------ */

bool sn_json_detect(const sn_blob *blob) {
    const char *end = blob->data + blob->size, *at = skip_blanks(blob->data + sn_byte_order_mark(blob->data, blob->size), end);
    return at < end && *at == '{';
}

static sn_status parse_failure(const sn_json_tree *tree, const json_error_t *problem, sn_error *error) {
    if (json_error_code(problem) == json_error_out_of_memory) return sn_fail_memory(error, "a JSON document");
    sn_status status = sn_fail_at(error, SN_ERROR_INPUT, tree->name, 1, "this is not valid JSON: %s", problem->text);
    set_place(error, tree, unfold(tree, problem->position > 0 ? (size_t)problem->position - 1 : 0));
    return status;
}

/* About what a text takes once it is parsed, in bytes (measured with jansson 2.14): an empty object of two characters takes 240. */
static double parsed_size(const folded *text) {
    enum { OBJECT = 240, ARRAY = 140, STRING = 96, VALUE = 48 };
    const char *at = text->text, *end = at + text->size;
    double size = (double)text->size;
    while (at < end) {
        size += *at == '{' ? OBJECT : *at == '[' ? ARRAY : *at == '"' ? STRING : *at == ',' ? VALUE : 0;
        at = *at == '"' ? skip_string(at, end) : at + 1;
    }
    return size;
}

/* No document may take more than ten times its size and 64 MB: of that the file, the text and the folded text take up to three times. */
static bool fits_memory(const sn_json_tree *tree, const folded *text) {
    enum { ALWAYS = 48 << 20, FACTOR = 7 };
    return parsed_size(text) + (double)tree->span_capacity * sizeof(span) <= FACTOR * (double)tree->size + ALWAYS;
}

static sn_status parse_folded(sn_json_tree *tree, sn_error *error) {
    folded text = {0};
    sn_status status = SN_OK;
    json_error_t problem;
    if (!fold(tree, &text)) {
        status = sn_fail_memory(error, "a JSON document");
    } else if (!fits_memory(tree, &text)) {
        status = sn_fail_at(
            error, SN_ERROR_INPUT, tree->name, 1,
            "the document is made of so many small parts that it would take more than ten times its size in memory; thin out its keys");
    } else if ((tree->root = json_loadb(text.text, text.size, JSON_REJECT_DUPLICATES, &problem)) == NULL) {
        status = parse_failure(tree, &problem, error);
    } else if (!json_is_object(tree->root)) {
        status = sn_fail_at(error, SN_ERROR_INPUT, tree->name, 1, "the document is not a JSON object: it should begin with '{'");
    }
    free(text.text);
    return status;
}

sn_status sn_json_parse(const sn_blob *blob, sn_json_tree **out, sn_error *error) {
    size_t skip = sn_byte_order_mark(blob->data, blob->size);
    *out = NULL;
    sn_json_tree *tree = SN_NEW(sn_json_tree, 1);
    if (tree == NULL) return sn_fail_memory(error, "a JSON document");
    tree->name = sn_strdup(blob->name != NULL ? blob->name : "");
    tree->size = blob->size - skip;
    tree->text = sn_alloc(tree->size + 1, 1);
    tree->told = SN_NEW(told_members, 1);
    sn_status status = SN_OK;
    if (tree->name == NULL || tree->text == NULL || tree->told == NULL) {
        status = sn_fail_memory(error, "a JSON document");
    } else {
        memcpy(tree->text, blob->data + skip, tree->size);
        status = parse_folded(tree, error);
    }
    if (status != SN_OK)
        sn_json_tree_free(tree);
    else
        *out = tree;
    return status;
}

void sn_json_tree_free(sn_json_tree *tree) {
    if (tree == NULL) return;
    json_decref(tree->root);
    free(tree->told);
    free(tree->spans);
    free(tree->text);
    free(tree->name);
    free(tree);
}

/* ---- walking ---------------------------------------------------------------------------------------------------------- */

const char *sn_json_name(const sn_json_tree *tree) { return tree->name; }

sn_json_value sn_json_top(const sn_json_tree *tree) { return (sn_json_value){.tree = tree, .node = tree->root}; }

bool sn_json_has(const sn_json_value *value) { return value->node != NULL && !json_is_null(value->node); }

sn_json_value sn_json_member(const sn_json_value *object, const char *key) {
    return (sn_json_value){.tree = object->tree, .node = json_object_get(object->node, key), .parent = object, .key = key};
}

/* The span that an array stands for; NULL = it is no array of numbers. */
static const span *span_of(const sn_json_value *value) {
    if (json_array_size(value->node) != 1) return NULL;
    const json_t *first = json_array_get(value->node, 0);
    size_t k = json_is_integer(first) ? (size_t)json_integer_value(first) : SIZE_MAX;
    return k < value->tree->span_count ? &value->tree->spans[k] : NULL;
}

/* A number of an array of numbers has no node: only its stand-in has. */
sn_json_value sn_json_element(const sn_json_value *array, sn_index i) {
    const json_t *node = span_of(array) == NULL ? json_array_get(array->node, (size_t)i) : NULL;
    return (sn_json_value){.tree = array->tree, .node = node, .parent = array, .element = i};
}

sn_index sn_json_length(const sn_json_value *array) {
    const span *numbers = span_of(array);
    size_t length = numbers != NULL ? numbers->count : json_array_size(array->node);
    return length < SN_INDEX_MAX ? (sn_index)length : SN_INDEX_MAX;
}

/* jansson's iterators are not const; nothing is changed through them. */
static json_t *iterable(const json_t *node) { return (json_t *)(uintptr_t)node; }

bool sn_json_next(const sn_json_value *object, sn_json_value *member) {
    json_t *node = iterable(object->node);
    void *at = member->key == NULL ? json_object_iter(node) : json_object_iter_next(node, json_object_key_to_iter(member->key));
    if (at == NULL) return false;
    *member = (sn_json_value){.tree = object->tree, .node = json_object_iter_value(at), .parent = object, .key = json_object_iter_key(at)};
    return true;
}

bool sn_json_is_bool(const sn_json_value *value) { return json_is_boolean(value->node); }
bool sn_json_is_number(const sn_json_value *value) { return json_is_number(value->node); }
bool sn_json_is_text(const sn_json_value *value) { return json_is_string(value->node); }
bool sn_json_is_array(const sn_json_value *value) { return json_is_array(value->node); }

/* ---- errors ----------------------------------------------------------------------------------------------------------- */

/* Behind any value of a text that has been parsed. */
static const char *skip_value(const char *at, const char *end) {
    int64_t depth = 0;
    do {
        if (*at == '"') {
            at = skip_string(at, end);
            continue;
        }
        if (*at == '[' || *at == '{')
            depth++;
        else if (*at == ']' || *at == '}')
            depth--;
        at++;
    } while (at < end && (depth > 0 || (!is_blank(*at) && *at != ',' && *at != ']' && *at != '}')));
    return at;
}

/* Start of the member's or element's value, given that of its parent; NULL = not found (a key that is written with escapes). */
static const char *find_child(const char *at, const char *end, const sn_json_value *value) {
    size_t length = value->key != NULL ? strlen(value->key) : 0;
    for (sn_index i = 0; at < end; i++) {
        at = skip_blanks(at + 1, end); /* behind '{', '[' or ',' */
        if (at >= end || *at == '}' || *at == ']') return NULL;
        bool found = i == value->element;
        if (value->key != NULL) {
            const char *key = at + 1;
            at = skip_string(at, end);
            found = (size_t)(at - key) == length + 1 && memcmp(key, value->key, length) == 0;
            at = skip_blanks(skip_blanks(at, end) + 1, end);
        }
        if (found) return at;
        at = skip_blanks(skip_value(at, end), end);
        if (at < end && *at != ',') return NULL; /* that was the last one */
    }
    return NULL;
}

static const char *find_value(const sn_json_value *value) {
    const char *end = value->tree->text + value->tree->size;
    if (value->parent == NULL) return skip_blanks(value->tree->text, end);
    const char *at = find_value(value->parent);
    return at != NULL ? find_child(at, end, value) : NULL;
}

static size_t append_text(char *to, size_t used, size_t size, const char *text) {
    for (; *text != '\0' && used + 1 < size; text++) to[used++] = (unsigned char)*text < ' ' ? '?' : *text;
    to[used] = '\0';
    return used;
}

static size_t write_path(const sn_json_value *value, char *path, size_t size) {
    if (value->parent == NULL) return append_text(path, 0, size, "");
    char element[24] = "";
    size_t used = write_path(value->parent, path, size);
    if (value->key == NULL)
        snprintf(element, sizeof element, "[%ld]", (long)value->element);
    else if (used > 0)
        used = append_text(path, used, size, ".");
    return append_text(path, used, size, value->key != NULL ? value->key : element);
}

/* What a value is, for a person. */
static void describe(const sn_json_value *value, char *text, size_t size) {
    const json_t *node = value->node;
    char number[40];
    if (json_is_string(node)) {
        size_t used = append_text(text, 0, size < 44 ? size : 44, "\"");
        used = append_text(text, used, size < 44 ? size : 44, json_string_value(node));
        append_text(text, used, size, used < 43 ? "\"" : "...\"");
    } else if (json_is_number(node)) {
        sn_format_number(json_number_value(node), number);
        append_text(text, 0, size, number);
    } else {
        const char *word = json_is_array(node)                                       ? "an array"
                           : json_is_object(node)                                    ? "an object"
                           : json_is_true(node)                                      ? "true"
                           : json_is_false(node)                                     ? "false"
                           : json_is_null(node)                                      ? "null"
                           : value->parent != NULL && span_of(value->parent) != NULL ? "a number"
                                                                                     : "nothing";
        append_text(text, 0, size, word);
    }
}

static sn_status complain_at(const sn_json_value *value, const char *place, sn_error *error, const char *message) {
    char path[256];
    size_t length = write_path(value, path, sizeof path);
    sn_status status = sn_fail_at(error, SN_ERROR_INPUT, value->tree->name, 0, "%s%s%s", path, length > 0 ? ": " : "", message);
    if (place == NULL && value->parent != NULL) place = find_value(value->parent); /* a missing member: where it is missing */
    if (place != NULL) set_place(error, value->tree, (size_t)(place - value->tree->text));
    return status;
}

sn_status sn_json_complain(const sn_json_value *value, sn_error *error, const char *format, ...) {
    char message[448];
    va_list list;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    return complain_at(value, find_value(value), error, message);
}

/* A member that was meant to be this one, which is not there. */
static const char *mistyped_member(const sn_json_value *value) {
    sn_json_value member = {0};
    if (value->node != NULL || value->parent == NULL || value->key == NULL || !json_is_object(value->parent->node)) return NULL;
    while (sn_json_next(value->parent, &member))
        if (sn_word_distance(member.key, SIZE_MAX, value->key) != INT_MAX) return member.key;
    return NULL;
}

sn_status sn_json_mismatch(const sn_json_value *value, sn_error *error, const char *expected, ...) {
    char wanted[256], found[64], message[448];
    va_list list;
    va_start(list, expected);
    vsnprintf(wanted, sizeof wanted, expected, list);
    va_end(list);
    describe(value, found, sizeof found);
    const char *mistyped = mistyped_member(value);
    snprintf(message, sizeof message, "expected %s, found %s%s%s%s", wanted, found, mistyped != NULL ? "; did you mean it by \"" : "",
             mistyped != NULL ? mistyped : "", mistyped != NULL ? "\"?" : "");
    return complain_at(value, find_value(value), error, message);
}

/* ---- typed access ----------------------------------------------------------------------------------------------------- */

/* Nothing to read, and nothing wrong: a member that is not there. (An element of an array is never optional.) */
static bool is_absent(const sn_json_value *value) { return value->key != NULL && !sn_json_has(value); }

sn_status sn_json_require(const sn_json_value *value, const char *expected, sn_error *error) {
    return sn_json_has(value) ? SN_OK : sn_json_mismatch(value, error, "%s", expected);
}

sn_status sn_json_expect_object(const sn_json_value *value, sn_error *error) {
    return json_is_object(value->node) ? SN_OK : sn_json_mismatch(value, error, "an object");
}

sn_status sn_json_expect_array(const sn_json_value *value, sn_error *error) {
    return json_is_array(value->node) ? SN_OK : sn_json_mismatch(value, error, "an array");
}

sn_status sn_json_expect_list(const sn_json_value *value, sn_index most, sn_index *count, sn_error *error) {
    sn_status status = sn_json_expect_array(value, error);
    *count = status == SN_OK ? sn_json_length(value) : 0;
    if (*count > most)
        status = sn_json_complain(value, error, "there are %ld entries; the most that sinew takes is %ld", (long)*count, (long)most);
    return status;
}

/* "a number in [0,1]", "a number of at least 0", "a number above 0", "a number" */
static const char *number_range(double low, double high, char *text, size_t size) {
    char from[40], to[40];
    sn_format_number(low, from);
    sn_format_number(high, to);
    if (low == SN_JSON_POSITIVE)
        snprintf(text, size, "a number above 0%s%s", isfinite(high) ? " and up to " : "", isfinite(high) ? to : "");
    else if (isfinite(low) && isfinite(high))
        snprintf(text, size, "a number in [%s,%s]", from, to);
    else if (isfinite(low))
        snprintf(text, size, "a number of at least %s", from);
    else if (isfinite(high))
        snprintf(text, size, "a number of at most %s", to);
    else
        snprintf(text, size, "a number");
    return text;
}

sn_status sn_json_get_number(const sn_json_value *value, double low, double high, double *out, sn_error *error) {
    if (is_absent(value)) return SN_OK;
    double number = json_number_value(value->node);
    char range[128];
    if (!json_is_number(value->node) || number < low || number > high)
        return sn_json_mismatch(value, error, "%s", number_range(low, high, range, sizeof range));
    *out = number;
    return SN_OK;
}

sn_status sn_json_get_integer(const sn_json_value *value, int64_t low, int64_t high, int64_t *out, sn_error *error) {
    if (is_absent(value)) return SN_OK;
    int64_t number = json_integer_value(value->node);
    if (!json_is_integer(value->node) || number < low || number > high)
        return sn_json_mismatch(value, error, "a whole number in [%lld,%lld]", (long long)low, (long long)high);
    *out = number;
    return SN_OK;
}

sn_status sn_json_get_index(const sn_json_value *value, sn_index low, sn_index high, sn_index *out, sn_error *error) {
    int64_t number = *out;
    sn_status status = sn_json_get_integer(value, low, high, &number, error);
    if (status == SN_OK) *out = (sn_index)number;
    return status;
}

sn_status sn_json_get_bool(const sn_json_value *value, bool *out, sn_error *error) {
    if (is_absent(value)) return SN_OK;
    if (!json_is_boolean(value->node)) return sn_json_mismatch(value, error, "true or false");
    *out = json_is_true(value->node);
    return SN_OK;
}

sn_status sn_json_get_text(const sn_json_value *value, char **out, sn_error *error) {
    if (is_absent(value)) return SN_OK;
    if (!json_is_string(value->node)) return sn_json_mismatch(value, error, "a text in quotes");
    char *copy = sn_strdup(json_string_value(value->node));
    if (copy == NULL) return sn_fail_memory(error, "a JSON document");
    free(*out);
    *out = copy;
    return SN_OK;
}

sn_status sn_json_get_choice(const sn_json_value *value, const char *const *choices, int *out, sn_error *error) {
    if (is_absent(value)) return SN_OK;
    const char *text = json_string_value(value->node);
    char list[200] = "";
    size_t used = 0;
    for (int i = 0; choices[i] != NULL; i++) {
        if (text != NULL && strcmp(text, choices[i]) == 0) {
            *out = i;
            return SN_OK;
        }
        used = append_text(list, used, sizeof list, i == 0 ? "\"" : choices[i + 1] != NULL ? ", \"" : " or \"");
        used = append_text(list, used, sizeof list, choices[i]);
        used = append_text(list, used, sizeof list, "\"");
    }
    const char *meant = text != NULL ? sn_nearest_word(text, SIZE_MAX, choices) : NULL;
    if (meant == NULL) return sn_json_mismatch(value, error, "%s", list);
    char found[64];
    describe(value, found, sizeof found);
    return sn_json_complain(value, error, "expected %s, found %s; did you mean \"%s\"?", list, found, meant);
}

sn_status sn_json_expect_format(const sn_json_value *top, const char *format, sn_index newest, sn_error *error) {
    sn_json_value kind = sn_json_member(top, "format"), version = sn_json_member(top, "version");
    const char *text = json_string_value(kind.node);
    int64_t number = 0;
    if (text == NULL || strcmp(text, format) != 0) return sn_json_mismatch(&kind, error, "\"%s\"", format);
    sn_status status = sn_json_require(&version, "the version of the format, a whole number", error);
    if (status == SN_OK) status = sn_json_get_integer(&version, 1, INT32_MAX, &number, error);
    if (status == SN_OK && number > newest)
        status = sn_json_complain(&version, error,
                                  "the document has version %ld, but sinew " SN_VERSION " knows versions up to %ld; use a newer sinew",
                                  (long)number, (long)newest);
    return status;
}

static bool is_known(const char *key, const char *const *known) {
    if (key[0] == '_' || strncmp(key, "x-", 2) == 0) return true;
    for (; *known != NULL; known++)
        if (strcmp(*known, key) == 0) return true;
    return false;
}

/* ---- members that nobody knows ------------------------------------------------------------------------------------------ */

static bool strict_documents;
void sn_documents_strict(bool strict) { strict_documents = strict; }

/* The member that this one was meant to be: one that is not there as well. */
static const char *meant_member(const sn_json_value *member, const char *const *known) {
    const char *nearest = NULL;
    int best = INT_MAX;
    for (; *known != NULL; known++) {
        int distance = sn_word_distance(member->key, SIZE_MAX, *known);
        if (distance >= best || json_object_get(member->parent->node, *known) != NULL) continue;
        best = distance;
        nearest = *known;
    }
    return nearest;
}

static sn_status fail_unknown(const sn_json_value *member, const char *const *known, sn_error *error) {
    const char *meant = meant_member(member, known);
    return sn_json_complain(member, error, "sinew knows no such member%s%s%s; a member of your own begins with '_' or \"x-\"",
                            meant != NULL ? ": did you mean \"" : "", meant != NULL ? meant : "", meant != NULL ? "\"?" : "");
}

/* The unknown members of an object, as far as they have room. */
typedef struct unknown_members {
    char names[320];
    size_t used;
    sn_error place; /* of the first */
} unknown_members;

static void add_unknown(const sn_json_value *member, const char *meant, unknown_members *list) {
    const size_t size = sizeof list->names;
    const char *at = list->used == 0 ? find_value(member) : NULL;
    if (at != NULL) set_place(&list->place, member->tree, (size_t)(at - member->tree->text));
    list->used = append_text(list->names, list->used, size, list->used > 0 ? ", " : "");
    list->used = append_text(list->names, list->used, size, member->key);
    if (meant == NULL) return;
    list->used = append_text(list->names, list->used, size, " (did you mean ");
    list->used = append_text(list->names, list->used, size, meant);
    list->used = append_text(list->names, list->used, size, "?)");
}

static void tell_unknown(const sn_json_value *object, const unknown_members *list, bool passed) {
    enum { MOST_TOLD = 20 };
    char path[256];
    int64_t *told = &object->tree->told->objects;
    if (list->used == 0 || ++*told > MOST_TOLD + 1) return;
    size_t length = write_path(object, path, sizeof path);
    if (*told > MOST_TOLD)
        sn_log(SN_LOG_WARNING, "%s:%lld: and more members, from here on, that sinew does not know", object->tree->name,
               (long long)list->place.line);
    else
        sn_log(SN_LOG_WARNING, "%s:%lld: %s%ssinew knows no member %s here; what it does not know it %s", object->tree->name,
               (long long)list->place.line, path, length > 0 ? ": " : "", list->names, passed ? "only passes on" : "leaves out");
}

/* One message an object, with the place of the first: a text full of unknown members must not cost a search for each. */
static sn_status check_members(const sn_json_value *object, const char *const *known, bool passed, sn_error *error) {
    sn_json_value member = {0};
    unknown_members list = {.used = 0};
    while (sn_json_next(object, &member)) {
        if (is_known(member.key, known)) continue;
        if (strict_documents) return fail_unknown(&member, known, error);
        if (list.used + 1 >= sizeof list.names) break;
        const char *meant = meant_member(&member, known);
        if (!passed || meant != NULL) add_unknown(&member, meant, &list);
    }
    tell_unknown(object, &list, passed);
    return SN_OK;
}

sn_status sn_json_check_members(const sn_json_value *object, const char *const *known, sn_error *error) {
    return check_members(object, known, false, error);
}

sn_status sn_json_check_passed(const sn_json_value *object, const char *const *known, sn_error *error) {
    return check_members(object, known, true, error);
}

/* ---- arrays of numbers ------------------------------------------------------------------------------------------------ */

/* A number of an array that does not fit: its own path, its own place. */
static sn_status bad_number(const sn_json_value *array, size_t element, const char *at, sn_error *error, const char *expected) {
    sn_json_value value = {.tree = array->tree, .parent = array, .element = (sn_index)element};
    const char *end = array->tree->text + array->tree->size;
    char message[160];
    snprintf(message, sizeof message, "expected %s, found %.*s", expected,
             (int)(skip_value(at, end) - at < 40 ? skip_value(at, end) - at : 40), at);
    return complain_at(&value, at, error, message);
}

/* The first element that keeps an array from being one of numbers. */
static sn_status not_numbers(const sn_json_value *array, sn_error *error) {
    if (!json_is_array(array->node)) return sn_json_mismatch(array, error, "an array of numbers");
    size_t i = 0;
    while (json_is_number(json_array_get(array->node, i))) i++;
    sn_json_value element = sn_json_element(array, (sn_index)i);
    return sn_json_mismatch(&element, error, "a number");
}

/* The numbers of an array, of the right count; *numbers is NULL for an empty one. */
static sn_status find_numbers(const sn_json_value *array, sn_index multiple, sn_index count, const span **numbers, sn_error *error) {
    *numbers = span_of(array);
    if (*numbers == NULL && (!json_is_array(array->node) || json_array_size(array->node) > 0)) return not_numbers(array, error);
    size_t found = *numbers != NULL ? (*numbers)->count : 0;
    if (found > SN_INDEX_MAX) return sn_json_complain(array, error, "%zu numbers are more than sinew can count", found);
    if (count >= 0 && found != (size_t)count)
        return sn_json_complain(array, error, "expected an array of %ld numbers, found one of %zu", (long)count, found);
    if (multiple > 1 && found % (size_t)multiple != 0)
        return sn_json_complain(array, error, "expected a multiple of %ld numbers, found %zu", (long)multiple, found);
    return SN_OK;
}

/* Folding has checked the grammar: between two numbers there are only blanks and a comma. */
static const char *next_number(const char *at) {
    while (is_blank(*at) || *at == ',' || *at == '[') at++;
    return at;
}

static void scan_numbers(const sn_json_value *array, const span *numbers, double *out) {
    const char *at = array->tree->text + numbers->begin, *end = array->tree->text + numbers->end;
    for (size_t i = 0; i < numbers->count; i++) {
        at = next_number(at);
        if (!sn_scan_number(at, end, &at, &out[i])) out[i] = 0.0; /* cannot be: see above */
    }
}

static sn_status scan_indices(const sn_json_value *array, const span *numbers, sn_index low, sn_index high, sn_index *out,
                              sn_error *error) {
    const char *at = array->tree->text + numbers->begin, *end = array->tree->text + numbers->end, *start;
    char expected[64];
    for (size_t i = 0; i < numbers->count; i++) {
        int64_t value;
        start = at = next_number(at);
        bool whole = sn_scan_integer(at, end, &at, &value) && *at != '.' && *at != 'e' && *at != 'E';
        if (whole && value >= low && value <= high) {
            out[i] = (sn_index)value;
            continue;
        }
        snprintf(expected, sizeof expected, "a whole number in [%ld,%ld]", (long)low, (long)high);
        return bad_number(array, i, start, error, high >= low ? expected : "no index");
    }
    return SN_OK;
}

sn_status sn_json_get_fixed(const sn_json_value *value, sn_index count, double *out, sn_error *error) {
    const span *numbers;
    if (is_absent(value)) return SN_OK;
    sn_status status = find_numbers(value, 1, count, &numbers, error);
    if (status == SN_OK && numbers != NULL) scan_numbers(value, numbers, out);
    return status;
}

sn_status sn_json_get_vec3(const sn_json_value *value, sn_vec3 *out, sn_error *error) {
    double xyz[3] = {out->x, out->y, out->z};
    sn_status status = sn_json_get_fixed(value, 3, xyz, error);
    if (status == SN_OK) *out = sn_v3(xyz[0], xyz[1], xyz[2]);
    return status;
}

sn_status sn_json_get_numbers(const sn_json_value *value, sn_index multiple, sn_index count, sn_index *out_count, double **out,
                              sn_error *error) {
    const span *numbers;
    sn_status status = find_numbers(value, multiple, count, &numbers, error);
    if (status != SN_OK) return status;
    size_t found = numbers != NULL ? numbers->count : 0;
    double *values = SN_NEW(double, found);
    if (values == NULL) return sn_fail_memory(error, "an array of numbers");
    if (numbers != NULL) scan_numbers(value, numbers, values);
    if (out_count != NULL) *out_count = (sn_index)found;
    *out = values;
    return SN_OK;
}

sn_status sn_json_get_indices(const sn_json_value *value, sn_index_rule rule, sn_index *out_count, sn_index **out, sn_error *error) {
    const span *numbers;
    sn_status status = find_numbers(value, rule.multiple, rule.count, &numbers, error);
    if (status != SN_OK) return status;
    size_t found = numbers != NULL ? numbers->count : 0;
    sn_index *values = SN_NEW(sn_index, found);
    if (values == NULL) return sn_fail_memory(error, "an array of indices");
    if (numbers != NULL) status = scan_indices(value, numbers, rule.low, rule.high, values, error);
    if (status != SN_OK) {
        free(values);
        return status;
    }
    if (out_count != NULL) *out_count = (sn_index)found;
    *out = values;
    return SN_OK;
}

/* ---- passing on ---------------------------------------------------------------------------------------------------------- */

static bool holds_object(const json_t *node) {
    const char *key;
    json_t *value;
    size_t i;
    if (json_is_array(node)) {
        json_array_foreach(node, i, value) if (json_is_object(value) || holds_object(value)) return true;
    } else if (json_is_object(node)) {
        json_object_foreach(iterable(node), key, value) if (json_is_object(value) || holds_object(value)) return true;
    }
    return false;
}

static void pass_object(sn_json *json, const char *key, const sn_json_value *value) {
    const char *name;
    json_t *node;
    /* what is listed, and has no parts of its own, goes on a line: as the writers of the sections do it */
    if (key == NULL && !holds_object(value->node))
        sn_json_object_line(json, key);
    else
        sn_json_object(json, key);
    json_object_foreach(iterable(value->node), name, node) {
        sn_json_value member = {.tree = value->tree, .node = node, .parent = value, .key = name};
        sn_json_pass(json, name, &member);
    }
    sn_json_close(json);
}

static void pass_array(sn_json *json, const char *key, const sn_json_value *value) {
    const span *numbers = span_of(value);
    if (numbers != NULL) {
        sn_json_number_text(json, key, value->tree->text + numbers->begin, numbers->end - numbers->begin);
        return;
    }
    sn_json_array(json, key);
    for (sn_index i = 0; i < sn_json_length(value); i++) {
        sn_json_value element = sn_json_element(value, i);
        sn_json_pass(json, NULL, &element);
    }
    sn_json_close(json);
}

void sn_json_pass(sn_json *json, const char *key, const sn_json_value *value) {
    switch (json_typeof(value->node)) {
    case JSON_OBJECT:
        pass_object(json, key, value);
        break;
    case JSON_ARRAY:
        pass_array(json, key, value);
        break;
    case JSON_STRING:
        sn_json_text(json, key, json_string_value(value->node));
        break;
    case JSON_INTEGER:
        sn_json_integer(json, key, json_integer_value(value->node));
        break;
    case JSON_REAL:
        sn_json_number(json, key, json_real_value(value->node));
        break;
    case JSON_TRUE:
    case JSON_FALSE:
        sn_json_bool(json, key, json_is_true(value->node));
        break;
    case JSON_NULL:
        sn_json_null(json, key);
        break;
    }
}
