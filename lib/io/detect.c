/* detect.c -- which kind of document a JSON text is, without parsing it all: looks for the top-level members "format" and "asset". */
#include "clip_reader.h"
#include "import.h"

#include <string.h>

typedef struct scan {
    const char *at, *end;
} scan;

static void skip_blanks(scan *s) {
    while (s->at < s->end && strchr(" \t\r\n", *s->at) && *s->at) s->at++;
}

/* Over a string that begins at *at; false = it does not end. */
static bool skip_string(scan *s) {
    for (s->at++; s->at < s->end && *s->at != '"'; s->at++)
        if (*s->at == '\\') s->at++;
    if (s->at >= s->end) return false;
    s->at++;
    return true;
}

/* Over one value up to the comma or brace behind it. */
static bool skip_value(scan *s) {
    int depth = 0;
    while (s->at < s->end) {
        char c = *s->at;
        if (depth == 0 && (c == ',' || c == '}')) return true;
        if (c == '"') {
            if (!skip_string(s)) return false;
            continue;
        }
        if (c == '[' || c == '{') depth++;
        if (c == ']' || c == '}') depth--;
        s->at++;
    }
    return false;
}

static bool take(scan *s, char c) {
    skip_blanks(s);
    if (s->at >= s->end || *s->at != c) return false;
    s->at++;
    skip_blanks(s);
    return true;
}

static bool equals(const char *text, const char *end, const char *quoted) {
    return (size_t)(end - text) == strlen(quoted) && memcmp(text, quoted, strlen(quoted)) == 0;
}

/* The first of the wanted members on the top level; the scan then stands at its value. -1 = none, or this is no JSON object. */
static int find_member(scan *s, const sn_blob *blob, int count, const char *const *wanted) {
    *s = (scan){blob->data, blob->data + blob->size};
    s->at += sn_byte_order_mark(blob->data, blob->size);
    if (!take(s, '{')) return -1;
    while (s->at < s->end && *s->at == '"') {
        const char *key = s->at;
        if (!skip_string(s)) return -1;
        const char *key_end = s->at;
        if (!take(s, ':')) return -1;
        for (int i = 0; i < count; i++)
            if (equals(key, key_end, wanted[i])) return i;
        if (!skip_value(s) || !take(s, ',')) return -1;
    }
    return -1;
}

/* Is the document's "format" this word, with its quotes? */
static bool has_format(const sn_blob *blob, const char *quoted) {
    static const char *const wanted[] = {"\"format\""};
    scan s;
    if (find_member(&s, blob, 1, wanted) != 0 || s.at >= s.end || *s.at != '"') return false;
    const char *value = s.at;
    return skip_string(&s) && equals(value, s.at, quoted);
}

bool sn_scene_detect(const sn_blob *blob) { return has_format(blob, "\"sinew-scene\""); }
bool sn_envelope_detect(const sn_blob *blob) { return has_format(blob, "\"sinew-envelope\""); }

bool sn_motion_document_detect(const sn_blob *blob) { return has_format(blob, "\"sinew-motion\""); }

bool sn_gltf_detect(const sn_blob *blob) {
    static const char *const wanted[] = {"\"format\"", "\"asset\""};
    scan s;
    return find_member(&s, blob, 2, wanted) == 1 && s.at < s.end && *s.at == '{';
}
