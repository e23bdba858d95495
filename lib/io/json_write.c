/* json_write.c -- JSON out: a streaming writer with one fixed layout, so that equal content is equal bytes. */
#include "json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One open object or array. */
typedef struct scope {
    bool array;
    bool inside_line; /* everything in it goes on one line */
    bool broken;      /* something in it began a new line, so its bracket does too */
    bool any;         /* it has a member or element */
} scope;

struct sn_json {
    sn_output *output;
    bool pretty;
    size_t depth, capacity;
    scope *scopes; /* (depth) outermost first */
    size_t used;
    sn_status status; /* of the first failure; everything after it is dropped */
    sn_error error;
    char buffer[1 << 15];
};

sn_json *sn_json_begin(sn_output *output, bool pretty) {
    sn_json *json = SN_NEW(sn_json, 1);
    if (json == NULL) return NULL;
    json->output = output;
    json->pretty = pretty;
    return json;
}

/* ---- bytes ------------------------------------------------------------------------------------------------------------ */

static void flush(sn_json *json) {
    if (json->status == SN_OK && json->used > 0) json->status = sn_output_write(json->output, json->buffer, json->used, &json->error);
    json->used = 0;
}

static void put(sn_json *json, const char *text, size_t size) {
    if (size > sizeof json->buffer - json->used) flush(json);
    if (size <= sizeof json->buffer) {
        memcpy(json->buffer + json->used, text, size);
        json->used += size;
    } else if (json->status == SN_OK) {
        json->status = sn_output_write(json->output, text, size, &json->error);
    }
}

static void put_char(sn_json *json, char c) { put(json, &c, 1); }

static void put_break(sn_json *json, size_t depth) {
    put_char(json, '\n');
    for (size_t i = 0; i < depth; i++) put(json, "  ", 2);
}

static void put_number(sn_json *json, double value) {
    char text[40] = "null";
    int length = isfinite(value) ? sn_format_number(value, text) : 4;
    put(json, text, (size_t)length);
}

static void put_integer(sn_json *json, int64_t value) {
    char text[24];
    size_t at = sizeof text;
    uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    do text[--at] = (char)('0' + rest % 10);
    while ((rest /= 10) > 0);
    if (value < 0) text[--at] = '-';
    put(json, text + at, sizeof text - at);
}

/* ---- texts ------------------------------------------------------------------------------------------------------------ */

/* Length of the UTF-8 sequence at text; 0 = not one: overlong forms, surrogates and beyond U+10FFFF are none (RFC 3629, 4). */
static size_t utf8_length(const unsigned char *text) {
    unsigned char a = text[0], b;
    if (a < 0x80) return 1;
    if (a < 0xC2 || a > 0xF4) return 0;
    b = text[1];
    unsigned char low = a == 0xE0 ? 0xA0 : a == 0xF0 ? 0x90 : 0x80, high = a == 0xED ? 0x9F : a == 0xF4 ? 0x8F : 0xBF;
    if (b < low || b > high) return 0;
    size_t length = a < 0xE0 ? 2 : a < 0xF0 ? 3 : 4;
    for (size_t i = 2; i < length; i++)
        if ((text[i] & 0xC0) != 0x80) return 0;
    return length;
}

static void put_escaped(sn_json *json, unsigned char c) {
    static const char letters[] = "btnvfr"; /* 8 to 13 */
    char text[8];
    bool has_letter = c >= 8 && c <= 13 && c != 11;
    int length = has_letter ? snprintf(text, sizeof text, "\\%c", letters[c - 8]) : snprintf(text, sizeof text, "\\u%04x", c);
    put(json, text, (size_t)length);
}

static void put_text(sn_json *json, const char *text) {
    const unsigned char *at = (const unsigned char *)text;
    put_char(json, '"');
    while (*at != '\0') {
        size_t length = utf8_length(at);
        if (length == 0)
            put(json, "\xEF\xBF\xBD", 3); /* U+FFFD */
        else if (*at == '"' || *at == '\\')
            put(json, (char[2]){'\\', (char)*at}, 2);
        else if (*at < 0x20)
            put_escaped(json, *at);
        else
            put(json, (const char *)at, length);
        at += length > 0 ? length : 1;
    }
    put_char(json, '"');
}

/* ---- layout ----------------------------------------------------------------------------------------------------------- */

/* Comma, line break or blank, and key: what stands before a value. */
static void lead(sn_json *json, const char *key, bool own_line) {
    scope *in = json->depth > 0 ? &json->scopes[json->depth - 1] : NULL;
    bool on_line = !json->pretty || (in != NULL && in->inside_line);
    if (in != NULL) {
        bool line = !on_line && (key != NULL || own_line);
        if (in->any) put_char(json, ',');
        if (line)
            put_break(json, json->depth);
        else if (in->any && json->pretty && key != NULL)
            put_char(json, ' ');
        in->broken = in->broken || line;
        in->any = true;
    }
    if (key == NULL) return;
    put_text(json, key);
    put(json, ": ", json->pretty ? 2 : 1);
}

static void open_scope(sn_json *json, const char *key, bool array, bool line) {
    bool inherits = json->depth > 0 && json->scopes[json->depth - 1].inside_line;
    lead(json, key, !array);
    if (!sn_grow((void **)&json->scopes, &json->capacity, json->depth + 1, sizeof *json->scopes)) {
        if (json->status == SN_OK) json->status = sn_fail_memory(&json->error, "JSON output");
        return;
    }
    json->scopes[json->depth++] = (scope){.array = array, .inside_line = line || inherits};
    put_char(json, array ? '[' : '{');
}

void sn_json_object(sn_json *json, const char *key) { open_scope(json, key, false, false); }
void sn_json_object_line(sn_json *json, const char *key) { open_scope(json, key, false, true); }
void sn_json_array(sn_json *json, const char *key) { open_scope(json, key, true, false); }

void sn_json_close(sn_json *json) {
    if (json->depth == 0) return; /* only after a failure to open */
    scope in = json->scopes[--json->depth];
    if (in.broken) put_break(json, json->depth);
    put_char(json, in.array ? ']' : '}');
}

/* ---- values ----------------------------------------------------------------------------------------------------------- */

static void put_word(sn_json *json, const char *key, const char *word) {
    lead(json, key, false);
    put(json, word, strlen(word));
}

void sn_json_null(sn_json *json, const char *key) { put_word(json, key, "null"); }

void sn_json_bool(sn_json *json, const char *key, bool value) { put_word(json, key, value ? "true" : "false"); }

void sn_json_number_text(sn_json *json, const char *key, const char *text, size_t size) {
    const char *end = text + size;
    lead(json, key, false);
    while (text < end) {
        const char *run = text;
        while (text < end && (unsigned char)*text > ' ') text++;
        put(json, run, (size_t)(text - run));
        while (text < end && (unsigned char)*text <= ' ') text++;
    }
}

void sn_json_number(sn_json *json, const char *key, double value) {
    lead(json, key, false);
    put_number(json, value);
}

void sn_json_integer(sn_json *json, const char *key, int64_t value) {
    lead(json, key, false);
    put_integer(json, value);
}

void sn_json_text(sn_json *json, const char *key, const char *text) {
    lead(json, key, false);
    if (text != NULL)
        put_text(json, text);
    else
        put(json, "null", 4);
}

void sn_json_numbers(sn_json *json, const char *key, const double *values, size_t count) {
    lead(json, key, false);
    put_char(json, '[');
    for (size_t i = 0; i < count; i++) {
        if (i > 0) put_char(json, ',');
        put_number(json, values[i]);
    }
    put_char(json, ']');
}

void sn_json_vec3(sn_json *json, const char *key, sn_vec3 value) {
    sn_json_numbers(json, key, (const double[3]){value.x, value.y, value.z}, 3);
}

void sn_json_indices(sn_json *json, const char *key, const sn_index *values, size_t count) {
    lead(json, key, false);
    put_char(json, '[');
    for (size_t i = 0; i < count; i++) {
        if (i > 0) put_char(json, ',');
        put_integer(json, values[i]);
    }
    put_char(json, ']');
}

sn_status sn_json_end(sn_json *json, sn_error *error) {
    while (json->depth > 0) sn_json_close(json);
    put_char(json, '\n');
    flush(json);
    sn_status status = json->status;
    if (status != SN_OK && error != NULL) *error = json->error;
    free(json->scopes);
    free(json);
    return status;
}
