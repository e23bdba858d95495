/*
 * blocks.h -- inside lib/sim: a symmetric sparse matrix of blocks of 1 x 1 or 3 x 3 numbers, as the sum of rows K KT is gathered.
 */
#ifndef SN_SIM_BLOCKS_H
#define SN_SIM_BLOCKS_H

#include "sinew/sparse.h"

typedef struct sn_block {
    sn_index row, column; /* row >= column within the matrix; a column of rows or more is outside of it: kept for products only */
    sn_index next;        /* block of the same row, or SN_NONE */
    double value[9];      /* size x size, row-major */
} sn_block;

typedef struct sn_blocks {
    int size;      /* 1 or 3 */
    sn_index rows; /* of blocks; the first `rows` blocks are the diagonal */
    sn_index count;
    size_t capacity;
    sn_block *blocks; /* (count) */
    sn_index *last;   /* (rows) the newest block of each row */
    sn_index entry_count;
    sn_entry *entries; /* (entry_count) what sn_blocks_entries made */
} sn_blocks;

/* A matrix of zeros; false: no memory. */
bool sn_blocks_create(sn_blocks *b, int size, sn_index rows);
void sn_blocks_clear(sn_blocks *b); /* the blocks stay, as zeros */
void sn_blocks_free(sn_blocks *b);
/* Where the block (row, column) is, made where it is missing; NULL: no memory. The next call may move it. */
double *sn_blocks_at(sn_blocks *b, sn_index row, sn_index column);
/* Which block is (row, column); it must be there. */
sn_index sn_blocks_find(const sn_blocks *b, sn_index row, sn_index column);
/* Make room for the entries of all blocks inside of the matrix, the lower triangle; false: no memory, or too many. */
bool sn_blocks_close(sn_blocks *b);
/* entries = stiffness x matrix + masses (rows) on the diagonal; stiffness (count) of the rows from first (count + 1) of each. */
void sn_blocks_entries(sn_blocks *b, sn_index count, const sn_index *first, const double *stiffness, const double *masses);
/* That of a row. */
static inline double sn_blocks_stiffness(sn_index count, const sn_index *first, const double *stiffness, sn_index row) {
    sn_index k = 0;
    while (k + 1 < count && row >= first[k + 1]) k++;
    return stiffness[k];
}

#endif
