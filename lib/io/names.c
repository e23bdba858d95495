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

/* How many underscores behind `name` make it unlike all others, the fewest; one pass, as thousands may be alike. SIZE_MAX = out of memory.
 */
static size_t fewest_underscores(const sn_name_list *list, const char *name) {
    size_t length = strlen(name), fewest = 0;
    bool *taken = SN_NEW(bool, list->count + 1); /* so many are free that one of them is */
    if (taken == NULL) return SIZE_MAX;
    for (size_t i = 0; i < list->count; i++) {
        if (strncmp(list->items[i], name, length) != 0) continue;
        size_t more = strspn(list->items[i] + length, "_");
        if (list->items[i][length + more] == '\0' && more < list->count) taken[more] = true;
    }
    while (taken[fewest]) fewest++;
    free(taken);
    return fewest;
}

bool sn_name_list_add(sn_name_list *list, const char *name, bool spaces) {
    char *clean = clean_name(name, spaces, list->count + 1); /* so many underscores are needed at most */
    size_t more = clean != NULL ? fewest_underscores(list, clean) : SIZE_MAX;
    if (more == SIZE_MAX || !sn_grow((void **)&list->items, &list->capacity, list->count + 1, sizeof *list->items)) {
        free(clean);
        return false;
    }
    memset(clean + strlen(clean), '_', more);
    list->items[list->count++] = clean;
    return true;
}

void sn_name_list_free(sn_name_list *list) {
    for (size_t i = 0; i < list->count; i++) free(list->items[i]);
    free(list->items);
    *list = (sn_name_list){0};
}
