/* codec.h -- bytes as VTK's XML files hold them: plain, as base64, packed with zlib; and gzip. */
#ifndef SN_IO_CODEC_H
#define SN_IO_CODEC_H

#include "sinew/io.h"

/* Bytes to be read in order, plain or as base64. A group padded with '=' may be followed by another: headers are encoded by themselves. */
typedef struct sn_byte_source {
    const unsigned char *at, *end; /* of the file; may move to `at` behind what was read */
    bool base64;
    unsigned char pending[3]; /* decoded, not yet read */
    int pending_first, pending_count;
} sn_byte_source;

/* Read `size` bytes to `out`. false = the source ends before, or holds what is not base64. */
bool sn_byte_source_read(sn_byte_source *source, void *out, size_t size);
/* The most bytes that can still be read. */
size_t sn_byte_source_left(const sn_byte_source *source);

/* Unpack one zlib block of exactly `size` bytes. false = it is damaged, or of another size. */
bool sn_unpack(const void *packed, size_t packed_size, void *out, size_t size);

bool sn_gzip_is(const void *data, size_t size);
/* Unpack a gzip file of any number of members; *out, owned by the caller, has a 0 behind its *out_size bytes. SN_ERROR_INPUT = it is
 * damaged, cut short, or larger than `most` bytes; nothing is said of it in an error. */
SN_MUST_CHECK sn_status sn_gunzip(const void *packed, size_t packed_size, size_t most, char **out, size_t *out_size);

#endif
