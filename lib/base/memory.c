/* memory.c -- checked allocation and the scratch arena. */
#include "sinew/base.h"

#include <stdalign.h>
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

/* ---- arena ---------------------------------------------------------------------------------------------------------- */

enum { ARENA_ALIGNMENT = 64 };

typedef struct arena_block {
    struct arena_block *next;
    size_t size, used; /* bytes of payload */
    size_t before;     /* bytes in use in all earlier blocks, for the peak */
    alignas(ARENA_ALIGNMENT) unsigned char payload[];
} arena_block;

struct sn_arena {
    arena_block *first, *current;
    size_t peak;
};

static arena_block *new_block(size_t size) {
    size = (size + ARENA_ALIGNMENT - 1) / ARENA_ALIGNMENT * ARENA_ALIGNMENT;
    arena_block *block = aligned_alloc(ARENA_ALIGNMENT, sizeof(arena_block) + size);
    if (block == NULL) return NULL;
    memset(block, 0, sizeof *block);
    block->size = size;
    return block;
}

sn_arena *sn_arena_create(size_t first_block_bytes) {
    sn_arena *arena = SN_NEW(sn_arena, 1);
    if (arena == NULL) return NULL;
    arena->first = arena->current = new_block(first_block_bytes > 0 ? first_block_bytes : 4096);
    if (arena->first == NULL) {
        free(arena);
        return NULL;
    }
    return arena;
}

void sn_arena_destroy(sn_arena *arena) {
    if (arena == NULL) return;
    for (arena_block *block = arena->first; block != NULL;) {
        arena_block *next = block->next;
        free(block);
        block = next;
    }
    free(arena);
}

/* The next block that holds `bytes`: one kept from before, or a new one of at least twice the current size. */
static arena_block *next_block(sn_arena *arena, size_t bytes) {
    arena_block *current = arena->current;
    while (current->next != NULL) {
        arena_block *next = current->next;
        next->used = 0;
        next->before = current->before + current->used;
        if (next->size >= bytes) return next;
        current = next;
    }
    arena_block *block = new_block(bytes > 2 * current->size ? bytes : 2 * current->size);
    if (block == NULL) return NULL;
    block->before = current->before + current->used;
    current->next = block;
    return block;
}

void *sn_arena_take(sn_arena *arena, size_t count, size_t size) {
    size_t bytes;
    if (!product(count, size, &bytes)) return NULL;
    bytes = (bytes + ARENA_ALIGNMENT - 1) / ARENA_ALIGNMENT * ARENA_ALIGNMENT;
    if (arena->current->size - arena->current->used < bytes) {
        arena_block *block = next_block(arena, bytes);
        if (block == NULL) return NULL;
        arena->current = block;
    }
    arena_block *block = arena->current;
    void *taken = block->payload + block->used;
    block->used += bytes;
    if (block->before + block->used > arena->peak) arena->peak = block->before + block->used;
    memset(taken, 0, bytes);
    return taken;
}

sn_arena_mark sn_arena_here(const sn_arena *arena) { return (sn_arena_mark){arena->current, arena->current->used}; }

void sn_arena_release(sn_arena *arena, sn_arena_mark mark) {
    arena->current = mark.block;
    arena->current->used = mark.used;
}

size_t sn_arena_peak(const sn_arena *arena) { return arena->peak; }
