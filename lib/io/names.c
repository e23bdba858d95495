/* names.c -- names of attributes as files can hold them: one line of clean text each, no two alike. */
#include "mesh_reader.h"

#include <stdlib.h>
#include <string.h>

/* Bytes of the UTF-8 character at text; 0 where there is none: no longer form than needed, no surrogate, nothing that XML forbids. */
static size_t character_length(const char *text) {
    const unsigned char *c = (const unsigned char *)text;
    size_t length = c[0] < 0x80                   ? 1
                    : c[0] >= 0xc2 && c[0] < 0xe0 ? 2
                    : c[0] >= 0xe0 && c[0] < 0xf0 ? 3
                    : c[0] >= 0xf0 && c[0] < 0xf5 ? 4
                                                  : 0;
    for (size_t i = 1; i < length; i++) {
        if ((c[i] & 0xc0) != 0x80) return 0;
    }
    bool bad = (c[0] == 0xe0 && c[1] < 0xa0) || (c[0] == 0xed && c[1] >= 0xa0) || (c[0] == 0xf0 && c[1] < 0x90) ||
               (c[0] == 0xf4 && c[1] >= 0x90) || (c[0] == 0xef && c[1] == 0xbf && c[2] >= 0xbe);
    return bad ? 0 : length;
}

static bool is_safe(const char *text, bool spaces) {
    unsigned char c = (unsigned char)*text;
    return c >= ' ' && c != 0x7f && c != '\\' && (c != ' ' || spaces);
}

/* Room is left for `spare` more characters. */
static char *clean_name(const char *name, bool spaces, size_t spare) {
    size_t length = 0;
    char *clean = sn_alloc(strlen(name) + spare + 2, 1);
    if (clean == NULL) return NULL;
    while (*name != '\0') {
        size_t size = character_length(name);
        if (size == 0 || !is_safe(name, spaces)) {
            clean[length++] = '_';
            name++;
        } else {
            memcpy(clean + length, name, size);
            length += size;
            name += size;
        }
    }
    if (length == 0) clean[0] = '_';
    return clean;
}

static bool is_taken(const sn_name_list *list, const char *name) {
    for (size_t i = 0; i < list->count; i++) {
        if (strcmp(list->items[i], name) == 0) return true;
    }
    return false;
}

bool sn_name_list_add(sn_name_list *list, const char *name, bool spaces) {
    char *clean = clean_name(name, spaces, list->count + 1); /* so many underscores are needed at most */
    if (clean == NULL || !sn_grow((void **)&list->items, &list->capacity, list->count + 1, sizeof *list->items)) {
        free(clean);
        return false;
    }
    size_t length = strlen(clean);
    while (is_taken(list, clean)) clean[length++] = '_';
    list->items[list->count++] = clean;
    return true;
}

void sn_name_list_free(sn_name_list *list) {
    for (size_t i = 0; i < list->count; i++) free(list->items[i]);
    free(list->items);
    *list = (sn_name_list){0};
}
