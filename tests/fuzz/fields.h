/*
 * fields.h -- files of distance fields under right hashes, and what must hold of one that was read.
 */
#ifndef TESTS_FUZZ_FIELDS_H
#define TESTS_FUZZ_FIELDS_H

#include <math.h>
#include <string.h>

#include "sinew/io.h"

/* What the seed says that it was built from. */
#define FIELD_HASH "sha256:0"
enum { FIELD_NAME_AT = 16, FIELD_CHECKSUM_AT = FIELD_NAME_AT + SN_HASH_LENGTH, FIELD_CHECKED = FIELD_CHECKSUM_AT + SN_HASH_LENGTH };

/* Put the right name and checksum into a file that is long enough to have them. */
static inline void field_forge(const sn_blob *blob) {
    if (blob->size < FIELD_CHECKED) return;
    memset(blob->data + FIELD_NAME_AT, 0, SN_HASH_LENGTH);
    memcpy(blob->data + FIELD_NAME_AT, FIELD_HASH, sizeof FIELD_HASH);
    sn_hash(blob->data + FIELD_CHECKED, blob->size - FIELD_CHECKED, blob->data + FIELD_CHECKSUM_AT);
}

/* What is wrong with a field that was read; NULL = nothing: values are finite within the grid, also on its faces, and outside. */
static inline const char *field_fault(const sn_distance_field *f) {
    sn_box box = sn_distance_field_box(f);
    uint64_t state = 1;
    if (!sn_distance_field_is_valid(f)) return "the field is not valid";
    for (int i = 0; i < 200; i++) {
        sn_vec3 size = sn_sub(box.high, box.low), g;
        double share[3];
        for (int k = 0; k < 3; k++) share[k] = fmin(1.1, fmax(-0.1, floor(16.0 * sn_random(&state)) / 12.0 - 0.1 + 0.1 * (i % 2)));
        sn_vec3 p = sn_add(box.low, sn_v3(share[0] * size.x, share[1] * size.y, share[2] * size.z));
        if (!isfinite(sn_distance_field_at(f, p, &g)) || !sn_finite3(g)) return "a value is not finite";
        sn_distance_field_farther(f, p, 0.0);
    }
    return NULL;
}

#endif
