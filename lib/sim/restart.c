/*
 * restart.c -- a state as bytes, and back: a run that stops anywhere and goes on from there gives the bits of one that did not.
 *
 *   "sinew state\n"  version (4 bytes)  hash of all that follows (72 bytes)
 *   hash of the model (72 bytes)  frame, substep, iteration, muscles (4 bytes each)
 *   per muscle: counters, inputs, lambda of the volume, and the arrays of SN_STATE_ARRAYS that are kept
 *
 * Numbers are as the machine has them; the version tells a machine of the other byte order. Goals and statistics are made anew.
 */
#include "rows.h"

#include <stdlib.h>
#include <string.h>

static const char MAGIC[12] = "sinew state\n";
enum { VERSION = 3, HEADER = sizeof MAGIC + sizeof(int32_t) + SN_HASH_LENGTH };

/* ---- a cursor that counts, writes or reads ---------------------------------------------------------------------------------- */

typedef struct cursor {
    char *bytes; /* NULL = only count */
    size_t at, size;
    bool reading, short_of; /* short_of: fewer bytes than the state needs */
} cursor;

static void pass(cursor *c, void *data, size_t size) {
    if (c->bytes != NULL && (c->short_of || size > c->size - c->at)) {
        c->short_of = true;
        return;
    }
    if (c->bytes != NULL && size > 0 && c->reading) memcpy(data, c->bytes + c->at, size);
    if (c->bytes != NULL && size > 0 && !c->reading) memcpy(c->bytes + c->at, data, size);
    c->at += size;
}

static void pass_muscle(cursor *c, const sn_model_muscle *m, sn_muscle_state *s) {
    sn_statistics *st = &s->statistics;
    int64_t *counters[] = {&st->skipped_edges, &st->skipped_hinges, &st->clamped_hinges,   &st->held_triangles, &st->skipped_triangles,
                           &st->iterations,    &st->rejected_steps, &st->refactorisations, &st->restarts,       &st->torn_substeps};
    for (size_t i = 0; i < sizeof counters / sizeof *counters; i++) pass(c, counters[i], sizeof *counters[i]);
    double *numbers[] = {&s->volume_lambda, &s->activation, &s->contraction,      &s->stiffness,
                         &s->volume_goal,   &s->energy,     &s->factor_stiffness, &st->residual};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) pass(c, numbers[i], sizeof *numbers[i]);
    pass(c, &s->still, sizeof s->still);
    pass(c, &s->pair_count, sizeof s->pair_count);
    pass(c, &s->pair_next, sizeof s->pair_next);
    pass(c, &s->stopped, sizeof s->stopped);
    pass(c, &s->turned, sizeof s->turned);
    pass(c, &s->torn, sizeof s->torn);
#define PASS(type, name, count, kept)                                                                                                      \
    if (kept) pass(c, s->name, (size_t)(count) * sizeof(type));
    SN_STATE_ARRAYS(PASS)
#undef PASS
}

/* What a state fits: the rest shapes and the rows. */
static sn_status fingerprint(const sn_model *model, char out[SN_HASH_LENGTH], sn_error *error) {
    size_t size = (size_t)model->muscle_count * 4 * SN_HASH_LENGTH;
    char *hashes = sn_alloc(size + 1, 1), *next = hashes;
    if (hashes == NULL) return sn_fail_memory(error, "the state");
    for (sn_index i = 0; i < model->muscle_count; i++, next += 4 * SN_HASH_LENGTH) {
        const sn_model_muscle *m = &model->muscles[i];
        sn_hash(m->rest, (size_t)m->point_count * sizeof *m->rest, next);
        sn_hash(m->inverse_mass, (size_t)m->point_count * sizeof *m->inverse_mass, next + SN_HASH_LENGTH);
        sn_hash(m->distances, (size_t)m->distance_start[SN_DISTANCE_KINDS] * sizeof *m->distances, next + 2 * SN_HASH_LENGTH);
        sn_hash(m->hinges, (size_t)m->hinge_count * sizeof *m->hinges, next + 3 * SN_HASH_LENGTH);
    }
    sn_hash(hashes, size, out);
    free(hashes);
    return SN_OK;
}

static void pass_state(cursor *c, const sn_model *model, sn_state *state, char hash[SN_HASH_LENGTH], sn_index *muscles) {
    pass(c, hash, SN_HASH_LENGTH);
    pass(c, &state->frame, sizeof state->frame);
    pass(c, &state->substep, sizeof state->substep);
    pass(c, &state->iteration, sizeof state->iteration);
    pass(c, muscles, sizeof *muscles);
    for (sn_index i = 0; i < model->muscle_count; i++) pass_muscle(c, &model->muscles[i], &state->muscles[i]);
}

/* Bytes of a packed state of this model. */
static sn_status packed_size(const sn_model *model, char hash[SN_HASH_LENGTH], size_t *size, sn_error *error) {
    sn_state none = {.muscles = SN_NEW(sn_muscle_state, model->muscle_count)};
    sn_index muscles = model->muscle_count;
    cursor count = {.at = HEADER};
    if (none.muscles == NULL) return sn_fail_memory(error, "the state");
    pass_state(&count, model, &none, hash, &muscles);
    free(none.muscles);
    *size = count.at;
    return SN_OK;
}

/* ---- out -------------------------------------------------------------------------------------------------------------------- */

sn_status sn_state_pack(const sn_model *model, const sn_state *state, char **bytes, size_t *size, sn_error *error) {
    char hash[SN_HASH_LENGTH];
    sn_state copy = *state; /* the cursor only reads from it here */
    sn_index muscles = model->muscle_count;
    int32_t version = VERSION;
    sn_status status = fingerprint(model, hash, error);
    if (status == SN_OK) status = packed_size(model, hash, size, error);
    if (status != SN_OK) return status;
    if ((*bytes = sn_alloc(*size, 1)) == NULL) return sn_fail_memory(error, "the state");
    cursor write = {.bytes = *bytes, .at = HEADER, .size = *size};
    pass_state(&write, model, &copy, hash, &muscles);
    memcpy(*bytes, MAGIC, sizeof MAGIC);
    memcpy(*bytes + sizeof MAGIC, &version, sizeof version);
    sn_hash(*bytes + HEADER, *size - HEADER, *bytes + sizeof MAGIC + sizeof version);
    return SN_OK;
}

/* ---- in --------------------------------------------------------------------------------------------------------------------- */

static sn_status check_header(const char *bytes, size_t size, sn_error *error) {
    int32_t version;
    char hash[SN_HASH_LENGTH];
    if (size < HEADER || memcmp(bytes, MAGIC, sizeof MAGIC) != 0)
        return sn_fail(error, SN_ERROR_INPUT, "this is not a state (simulate --state writes one)");
    memcpy(&version, bytes + sizeof MAGIC, sizeof version);
    if (version != VERSION)
        return sn_fail(error, SN_ERROR_INPUT,
                       "this state has version %ld, or comes from a machine of another byte order; known is version %d", (long)version,
                       VERSION);
    sn_hash(bytes + HEADER, size - HEADER, hash);
    if (memcmp(hash, bytes + sizeof MAGIC + sizeof version, SN_HASH_LENGTH) != 0)
        return sn_fail(error, SN_ERROR_INPUT, "this state is damaged: its checksum is wrong; write it anew");
    return SN_OK;
}

/* The model that it was made for, against this one: nothing has been written to a state before this holds. */
static sn_status check_fit(const sn_model *model, const char *bytes, size_t size, sn_error *error) {
    char own[SN_HASH_LENGTH];
    sn_index moment[3]; /* frame, substep, iteration */
    size_t needed = 0;
    sn_status status = fingerprint(model, own, error);
    if (status == SN_OK) status = packed_size(model, own, &needed, error);
    if (status != SN_OK) return status;
    if (size != needed || memcmp(bytes + HEADER, own, SN_HASH_LENGTH) != 0)
        return sn_fail(error, SN_ERROR_INPUT,
                       "this state is another scene's, or was made under another scheme or solver: its constraints are not the same");
    memcpy(moment, bytes + HEADER + SN_HASH_LENGTH, sizeof moment);
    if (moment[1] < 0 || moment[2] < 0 || moment[1] >= model->scene->solver.substeps)
        return sn_fail(error, SN_ERROR_INPUT, "this state stopped in substep %ld of its frame; the scene has %ld, and must have as many",
                       (long)moment[1] + 1, (long)model->scene->solver.substeps);
    return SN_OK;
}

sn_status sn_state_unpack(const sn_model *model, const char *bytes, size_t size, sn_state *state, sn_error *error) {
    char hash[SN_HASH_LENGTH];
    sn_index muscles;
    sn_status status = check_header(bytes, size, error);
    if (status == SN_OK) status = check_fit(model, bytes, size, error);
    if (status != SN_OK) return status;
    cursor read = {.bytes = (char *)bytes, .at = HEADER, .size = size, .reading = true};
    pass_state(&read, model, state, hash, &muscles);
    for (sn_index i = 0; i < model->muscle_count; i++) {
        sn_muscle_state *s = &state->muscles[i];
        s->goal_contraction = s->goal_ratio = NAN;
        sn_distance_goals(&model->muscles[i], s);
        sn_statistics_measure(&model->muscles[i], s);
    }
    return SN_OK;
}
