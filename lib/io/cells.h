/* cells.h -- tables of text: rows of cells under a row of names. Private to lib/io. */
#ifndef SN_IO_CELLS_H
#define SN_IO_CELLS_H

#include "mesh_reader.h"

typedef struct sn_cells {
    const sn_blob *blob;
    sn_error *error;
    sn_text_lines lines;
    int64_t line; /* of the row that was read last */
    char mark;    /* between cells: tab, semicolon, comma; a blank = any blanks */
    sn_index column_count;
    char **names; /* (column_count) owned */
} sn_cells;

/* Reads the names. Errors name the file. */
SN_MUST_CHECK sn_status sn_cells_begin(const sn_blob *blob, sn_cells *out, sn_error *error);
/* The cells of the next row: out (column_count); *more = false at the end of the file. An error where there are more or fewer cells. */
SN_MUST_CHECK sn_status sn_cells_next(sn_cells *cells, sn_span *out, bool *more);
/* A number; NaN of an empty cell. */
SN_MUST_CHECK sn_status sn_cells_number(const sn_cells *cells, sn_index column, sn_span cell, double *out);
/* SN_ERROR_INPUT at the row that was read last. */
sn_status sn_cells_fail(const sn_cells *cells, const char *format, ...) SN_PRINTF(2, 3);
void sn_cells_free(sn_cells *cells);

#endif
