/* memory.c -- checked allocation. */
#include "sinew/base.h"

#include <stdlib.h>
#include <string.h>

static bool product(size_t count, size_t size, size_t *bytes) {
    return !__builtin_mul_overflow(count, size, bytes) && *bytes <= PTRDIFF_MAX;
}

void *sn_alloc(size_t count, size_t size) {
    size_t bytes;
    if (!product(count, size, &bytes)) return NULL;
    return calloc(bytes > 0 ? bytes : 1, 1);
}

void *sn_realloc(void *block, size_t count, size_t size) {
    size_t bytes;
    if (!product(count, size, &bytes)) return NULL;
    return realloc(block, bytes > 0 ? bytes : 1);
}

bool sn_grow(void **block, size_t *capacity, size_t needed, size_t size) {
    if (needed <= *capacity) return true;
    size_t wanted = *capacity < 8 ? 8 : *capacity;
    while (wanted < needed) {
        if (wanted > SIZE_MAX / 2) return false;
        wanted *= 2;
    }
    void *grown = sn_realloc(*block, wanted, size);
    if (grown == NULL) return false;
    *block = grown;
    *capacity = wanted;
    return true;
}

char *sn_strndup(const char *text, size_t length) {
    char *copy = sn_alloc(length + 1, 1);
    if (copy != NULL) memcpy(copy, text, length);
    return copy;
}

char *sn_strdup(const char *text) { return text == NULL ? NULL : sn_strndup(text, strlen(text)); }
