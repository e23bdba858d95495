/* vtp_array.h -- one array of a VTK XML file: where its values lie, and how to read them one after the other. */
#ifndef SN_IO_VTP_ARRAY_H
#define SN_IO_VTP_ARRAY_H

#include "mesh_reader.h"
#include "scalar.h"

/* What holds for all arrays of a file. */
typedef struct sn_vtp_layout {
    bool big_endian, long_header; /* header_type UInt64 */
    char compressor[64];          /* "" = none */
    bool has_appended, appended_base64;
    size_t appended_begin; /* the byte behind the '_' */
} sn_vtp_layout;

typedef enum sn_vtp_place { SN_VTP_TEXT, SN_VTP_INLINE, SN_VTP_APPENDED } sn_vtp_place;

typedef struct sn_vtp_array {
    char *name;   /* owned */
    int section;  /* as vtp.c numbers them */
    bool numeric; /* its type is one of numbers */
    sn_scalar type;
    int64_t components;
    sn_vtp_place place;
    size_t begin, end; /* bytes of the file between its tags */
    int64_t line;      /* of begin */
    int64_t offset;    /* into the appended data */
} sn_vtp_array;

/* An open array. One at a time: it moves the reader's cursor. */
typedef struct sn_vtp_values {
    sn_reader *reader;
    const char *what; /* for messages */
    bool text, big_endian;
    sn_scalar type;
    const unsigned char *bytes;
    size_t count, next;   /* next: how many were read, also of text */
    unsigned char *owned; /* unpacked bytes; NULL where they are read in place */
} sn_vtp_values;

/* Open an array that must have `least` values; what it unpacks to is bounded by sn_reader_may_take. Close it also after a failure. */
SN_MUST_CHECK sn_status sn_vtp_open(sn_reader *reader, const sn_vtp_layout *layout, const sn_vtp_array *array, int64_t least,
                                    const char *what, sn_vtp_values *out);
SN_MUST_CHECK sn_status sn_vtp_next(sn_vtp_values *values, double *out);
/* All values of the array must have been read; an error that names both counts. */
SN_MUST_CHECK sn_status sn_vtp_expect_end(sn_vtp_values *values);
void sn_vtp_close(sn_vtp_values *values);

#endif
