/*
 * distance_field_file.c -- distance fields kept in files, so that they need not be built again.
 *
 * "SINEWDISTANCE01\n" (16 bytes); the content hash of what the field was built from, and the hash of all that follows, as text, each padded
 * with 0 to 72 bytes. Then float64: cell, band, origin (3), box (6), volume. uint32: bricks (3), count of bricks with values, the report
 * (8). Then what each brick is (int32 each), the coarse corners and the bricks' values (float32 each). All little-endian.
 */
#include "bytes.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/distance_field.h"
#include "sinew/io.h"

enum { SIGNATURE = 16, REALS = 12, INTEGERS = 12, TABLES = SIGNATURE + 2 * SN_HASH_LENGTH + 8 * REALS + 4 * INTEGERS };
enum { CHECKED = SIGNATURE + 2 * SN_HASH_LENGTH }; /* from here on the second hash holds */
static const char signature[SIGNATURE + 1] = "SINEWDISTANCE01\n";

/* Words of 32 bits: the file's order is that of the machines that this runs on, or is turned. */
static void put_words(unsigned char *to, const void *from, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t word;
        memcpy(&word, (const unsigned char *)from + 4 * i, 4);
        sn_put_u32(to + 4 * i, word);
    }
}

static void get_words(void *to, const unsigned char *from, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t word = sn_get_u32(from + 4 * i);
        memcpy((unsigned char *)to + 4 * i, &word, 4);
    }
}

static size_t brick_places(const sn_distance_field *f) { return (size_t)f->bricks[0] * (size_t)f->bricks[1] * (size_t)f->bricks[2]; }

static size_t coarse_places(const sn_distance_field *f) {
    return (2 * (size_t)f->bricks[0] + 1) * (2 * (size_t)f->bricks[1] + 1) * (2 * (size_t)f->bricks[2] + 1);
}

static size_t value_places(const sn_distance_field *f) { return (size_t)f->brick_count * SN_BRICK_VALUES; }

/* ---- writing --------------------------------------------------------------------------------------------------------------- */

static void put_head(const sn_distance_field *f, unsigned char *at) {
    const sn_solid_report *r = &f->report;
    const double reals[REALS] = {f->cell,      f->band,      f->origin.x,   f->origin.y,   f->origin.z,   f->box.low.x,
                                 f->box.low.y, f->box.low.z, f->box.high.x, f->box.high.y, f->box.high.z, r->volume};
    const sn_index integers[INTEGERS] = {
        f->bricks[0], f->bricks[1],     f->bricks[2], f->brick_count, r->joined_vertices, r->dropped_triangles,
        r->caps,      r->cap_triangles, r->turned,    r->inside_out,  r->inner_triangles, r->boundary_triangles};
    for (int i = 0; i < REALS; i++, at += 8) sn_put_f64(at, reals[i]);
    for (int i = 0; i < INTEGERS; i++, at += 4) sn_put_u32(at, (uint32_t)integers[i]);
}

sn_status sn_distance_field_save(const sn_distance_field *field, const char *hash, sn_output *output, sn_error *error) {
    size_t places = brick_places(field), coarse = coarse_places(field), values = value_places(field);
    size_t size = TABLES + 4 * (places + coarse + values);
    unsigned char *bytes = SN_NEW(unsigned char, size), *tables = bytes + TABLES;
    if (bytes == NULL) return sn_fail_memory(error, "writing a distance field");
    memcpy(bytes, signature, SIGNATURE);
    strncpy((char *)bytes + SIGNATURE, hash, SN_HASH_LENGTH - 1);
    put_head(field, bytes + CHECKED);
    put_words(tables, field->brick, places);
    put_words(tables + 4 * places, field->coarse, coarse);
    put_words(tables + 4 * (places + coarse), field->values, values);
    sn_hash(bytes + CHECKED, size - CHECKED, (char *)bytes + SIGNATURE + SN_HASH_LENGTH);
    sn_status status = sn_output_write(output, bytes, size, error);
    free(bytes);
    return status;
}

/* ---- reading --------------------------------------------------------------------------------------------------------------- */

static void get_head(sn_distance_field *f, const unsigned char *at) {
    double reals[REALS];
    sn_index integers[INTEGERS];
    for (int i = 0; i < REALS; i++, at += 8) reals[i] = sn_get_f64(at);
    for (int i = 0; i < INTEGERS; i++, at += 4) integers[i] = (sn_index)sn_get_u32(at);
    f->cell = reals[0];
    f->band = reals[1];
    f->origin = sn_v3(reals[2], reals[3], reals[4]);
    f->box = (sn_box){sn_v3(reals[5], reals[6], reals[7]), sn_v3(reals[8], reals[9], reals[10])};
    memcpy(f->bricks, integers, sizeof f->bricks);
    f->brick_count = integers[3];
    f->report = (sn_solid_report){integers[4],      integers[5],  integers[6],  integers[7], integers[8],
                                  integers[9] != 0, integers[10], integers[11], reals[11]};
}

/* The sizes that the head tells are those of a file of `left` bytes behind it; every number is small enough to be multiplied then. */
static bool sizes_fit(const sn_distance_field *f, size_t left) {
    size_t words = left / 4, places = 1;
    for (int k = 0; k < 3; k++) {
        if (f->bricks[k] < 1 || (size_t)f->bricks[k] > words / places) return false;
        places *= (size_t)f->bricks[k];
    }
    if (left % 4 != 0 || f->brick_count < 0 || (size_t)f->brick_count > places || (size_t)f->brick_count > words / SN_BRICK_VALUES)
        return false;
    return words == places + coarse_places(f) + value_places(f);
}

static sn_status read_tables(sn_distance_field *f, const unsigned char *at, sn_error *error) {
    size_t places = brick_places(f), coarse = coarse_places(f), values = value_places(f);
    f->brick = SN_NEW(sn_index, places);
    f->coarse = SN_NEW(float, coarse);
    f->values = SN_NEW(float, values);
    if (f->brick == NULL || f->coarse == NULL || f->values == NULL) return sn_fail_memory(error, "a distance field");
    get_words(f->brick, at, places);
    get_words(f->coarse, at + 4 * places, coarse);
    get_words(f->values, at + 4 * (places + coarse), values);
    return SN_OK;
}

static bool checksum_holds(const sn_blob *blob) {
    char checksum[SN_HASH_LENGTH] = {0};
    sn_hash(blob->data + CHECKED, blob->size - CHECKED, checksum);
    return strncmp(blob->data + SIGNATURE + SN_HASH_LENGTH, checksum, SN_HASH_LENGTH) == 0;
}

static sn_status damaged(const sn_blob *blob, sn_error *error) {
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "the file of a distance field is damaged; remove it and it is made anew");
}

sn_status sn_distance_field_load(const sn_blob *blob, const char *hash, sn_distance_field *out, sn_error *error) {
    *out = (sn_distance_field){0};
    if (blob->size < TABLES || memcmp(blob->data, signature, SIGNATURE) != 0)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "this is no file of a distance field");
    if (strncmp(blob->data + SIGNATURE, hash, SN_HASH_LENGTH) != 0)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "this distance field is of another surface, or of other cells");
    if (!checksum_holds(blob)) return damaged(blob, error);
    get_head(out, (const unsigned char *)blob->data + CHECKED);
    sn_status status = SN_OK;
    if (!sizes_fit(out, blob->size - TABLES)) status = damaged(blob, error);
    if (status == SN_OK) status = read_tables(out, (const unsigned char *)blob->data + TABLES, error);
    if (status == SN_OK && !sn_distance_field_is_valid(out)) status = damaged(blob, error);
    if (status != SN_OK) sn_distance_field_free(out);
    return status;
}
