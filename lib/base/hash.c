/* hash.c -- SHA-256 of contents (the only user of libmd). */
#include "sinew/base.h"

#include <sha2.h>
#include <string.h>

void sn_hash(const void *data, size_t size, char out[SN_HASH_LENGTH]) {
    char digits[SHA256_DIGEST_STRING_LENGTH];
    SHA256Data(data, size, digits);
    memcpy(out, "sha256:", 7);
    memcpy(out + 7, digits, 65);
}
