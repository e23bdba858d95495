/*
 * blocks.c -- gather a symmetric sparse matrix block by block; no block is stored twice.
 */
#include "blocks.h"

#include <stdlib.h>
#include <string.h>

double *sn_blocks_at(sn_blocks *b, sn_index row, sn_index column) {
    for (sn_index i = b->last[row]; i != SN_NONE; i = b->blocks[i].next)
        if (b->blocks[i].column == column) return b->blocks[i].value;
    if (b->count == SN_INDEX_MAX || !sn_grow((void **)&b->blocks, &b->capacity, (size_t)b->count + 1, sizeof *b->blocks)) return NULL;
    b->blocks[b->count] = (sn_block){.row = row, .column = column, .next = b->last[row]};
    b->last[row] = b->count;
    return b->blocks[b->count++].value;
}

sn_index sn_blocks_find(const sn_blocks *b, sn_index row, sn_index column) {
    sn_index i = b->last[row];
    while (b->blocks[i].column != column) i = b->blocks[i].next;
    return i;
}

bool sn_blocks_create(sn_blocks *b, int size, sn_index rows) {
    *b = (sn_blocks){.size = size, .rows = rows, .last = SN_NEW(sn_index, rows)};
    if (b->last == NULL) return false;
    for (sn_index i = 0; i < rows; i++) b->last[i] = SN_NONE;
    for (sn_index i = 0; i < rows; i++)
        if (sn_blocks_at(b, i, i) == NULL) return false;
    return true;
}

void sn_blocks_clear(sn_blocks *b) {
    for (sn_index i = 0; i < b->count; i++) memset(b->blocks[i].value, 0, sizeof b->blocks[i].value);
}

void sn_blocks_free(sn_blocks *b) {
    free(b->blocks);
    free(b->last);
    free(b->entries);
    *b = (sn_blocks){0};
}

bool sn_blocks_close(sn_blocks *b) {
    int64_t whole = (int64_t)b->size * b->size, diagonal = (int64_t)b->size * (b->size + 1) / 2, entries = 0;
    for (sn_index i = 0; i < b->count; i++)
        if (b->blocks[i].column < b->rows) entries += i < b->rows ? diagonal : whole;
    if (entries > SN_INDEX_MAX) return false;
    b->entry_count = (sn_index)entries;
    b->entries = SN_NEW(sn_entry, entries);
    return b->entries != NULL;
}

void sn_blocks_entries(sn_blocks *b, sn_index count, const sn_index *first, const double *stiffness, const double *masses) {
    sn_index size = b->size;
    sn_entry *next = b->entries;
    for (sn_index i = 0; i < b->count; i++) {
        const sn_block *block = &b->blocks[i];
        if (block->column >= b->rows) continue;
        double k = sn_blocks_stiffness(count, first, stiffness, block->row);
        for (sn_index r = 0; r < size; r++) {
            for (sn_index c = 0; c < (i < b->rows ? r + 1 : size); c++) {
                double mass = i < b->rows && r == c ? masses[i] : 0.0;
                *next++ = (sn_entry){size * block->row + r, size * block->column + c, k * block->value[size * r + c] + mass};
            }
        }
    }
}
