/*
 * restart.c -- a state as bytes, and back: a run that stops anywhere and goes on from there gives the bits of one that did not.
 *
 *   "sinew state\n"  version (4 bytes)  hash of all that follows (72 bytes)
 *   hash of the model (72 bytes)  frame, substep, iteration, muscles (4 bytes each)
 *   per muscle: counters, inputs, lambda of the volume, and the arrays of SN_STATE_ARRAYS that are kept
 *
 * Numbers are as the machine has them; the version tells a machine of the other byte order. Inputs, goals and statistics are made anew.
 * A checksum keeps chance away, not malice: whatever it says, every number is held to what it may be before any of them is taken.
 */
#include "qn.h"

#include <stdlib.h>
#include <string.h>

static const char MAGIC[12] = "sinew state\n";
enum { VERSION = 3, HEADER = sizeof MAGIC + sizeof(int32_t) + SN_HASH_LENGTH };

/* ---- a cursor that counts, writes or reads ---------------------------------------------------------------------------------- */

typedef struct cursor {
    const char *from; /* what it reads */
    char *to;         /* or writes; both NULL = it only counts */
    size_t at, size;
    bool short_of; /* fewer bytes than the state needs */
} cursor;

static void pass(cursor *c, void *data, size_t size) {
    if ((c->from != NULL || c->to != NULL) && (c->short_of || size > c->size - c->at)) {
        c->short_of = true;
        return;
    }
    if (c->from != NULL && size > 0) memcpy(data, c->from + c->at, size);
    if (c->to != NULL && size > 0) memcpy(c->to + c->at, data, size);
    c->at += size;
}

/* Of shares that are interpolated. */
static const double ROUNDING = 1e-9;

static bool is_flag(const bool *flag) {
    unsigned char byte;
    memcpy(&byte, flag, sizeof byte);
    return byte <= 1;
}

/* Of what happened in one frame: there is always room for more. */
static bool is_count(int64_t count) { return count >= 0 && count <= INT64_MAX / 2; }

/* Parts of a substep that are done, and the step at hand, which is one of the halves that there are. */
static bool is_progress(const sn_model_muscle *m, const sn_progress *p) {
    bool power = p->size >= 0 && p->size <= SN_SUBSTEP_PARTS && (p->size & (p->size - 1)) == 0;
    bool fits = p->parts >= 0 && p->parts <= SN_SUBSTEP_PARTS && (p->parts == SN_SUBSTEP_PARTS || p->parts + p->size <= SN_SUBSTEP_PARTS);
    bool asleep = p->size == 0 && (p->parts == 0 || p->parts == SN_SUBSTEP_PARTS) && p->iteration == 0;
    bool whole = m->quasi_newton || p->size == 0 || p->size == SN_SUBSTEP_PARTS;
    return power && fits && whole && (asleep || (p->size > 0 && p->parts % p->size == 0)) && p->iteration >= 0 &&
           p->iteration < m->iterations && p->spent >= 0;
}

static bool is_motion(const sn_bone_motion *b) {
    return sn_finite3(b->middle) && sn_finite3(b->velocity) && sn_finite3(b->turn) && b->rate >= 0.0 && isfinite(b->rate);
}

/* Numbers of one muscle `s` of model `m` that are kept: member, and what holds of it in every state that a run comes to. Each one's
 * condition may rely on those before it. Of a flag nothing but its byte may be looked at until that is known to be 0 or 1. */
#define KEPT_NUMBERS(X)                                                                                                                    \
    X(statistics.skipped_edges, is_count(s->statistics.skipped_edges))                                                                     \
    X(statistics.skipped_hinges, is_count(s->statistics.skipped_hinges))                                                                   \
    X(statistics.clamped_hinges, is_count(s->statistics.clamped_hinges))                                                                   \
    X(statistics.held_triangles, is_count(s->statistics.held_triangles))                                                                   \
    X(statistics.skipped_triangles, is_count(s->statistics.skipped_triangles))                                                             \
    X(statistics.iterations, is_count(s->statistics.iterations))                                                                           \
    X(statistics.rejected_steps, is_count(s->statistics.rejected_steps))                                                                   \
    X(statistics.refactorisations, is_count(s->statistics.refactorisations))                                                               \
    X(statistics.steps, is_count(s->statistics.steps))                                                                                     \
    X(statistics.halvings, is_count(s->statistics.halvings))                                                                               \
    X(statistics.torn_substeps, is_count(s->statistics.torn_substeps))                                                                     \
    X(statistics.restarts, is_count(s->statistics.restarts))                                                                               \
    X(volume_lambda, isfinite(s->volume_lambda))                                                                                           \
    X(activation, s->activation >= -ROUNDING && s->activation <= 1.0 + ROUNDING)                                                           \
    X(contraction, s->contraction >= -ROUNDING && s->contraction <= 1.0 + ROUNDING)                                                        \
    X(stiffness, s->stiffness >= 0.0 && isfinite(s->stiffness))                                                                            \
    X(volume_goal, isfinite(s->volume_goal))                                                                                               \
    X(energy, true) /* found anew before it is read */                                                                                     \
    X(factor_stiffness, isnan(s->factor_stiffness) || (s->factor_stiffness >= 0.0 && isfinite(s->factor_stiffness)))                       \
    X(statistics.residual, !(s->statistics.residual < 0.0)) /* NaN: inside a substep */                                                    \
    X(progress, is_progress(m, &s->progress))                                                                                              \
    X(bones, is_motion(&s->bones))                                                                                                         \
    X(stretch_before, s->stretch_before >= 0.0) /* infinite: torn already */                                                               \
    X(abrupt, is_flag(&s->abrupt))                                                                                                         \
    X(still, s->still >= 0)                                                                                                                \
    X(pair_count, s->pair_count >= 0 && s->pair_count <= (m->quasi_newton ? SN_QN_MEMORY : 0))                                             \
    X(pair_next, s->pair_count < SN_QN_MEMORY ? s->pair_next == s->pair_count : s->pair_next >= 0 && s->pair_next < SN_QN_MEMORY)          \
    X(stopped, s->stopped == SN_STOP_ITERATIONS || (m->quasi_newton && s->stopped > SN_STOP_ITERATIONS && s->stopped <= SN_STOP_FAILED))   \
    X(turned, is_flag(&s->turned) && (m->corotated || m->two_level || !s->turned))                                                         \
    X(torn, is_flag(&s->torn) && (!s->torn || (m->quasi_newton && !s->turned)))

static void pass_muscle(cursor *c, const sn_model_muscle *m, sn_muscle_state *s) {
#define PASS_NUMBER(member, holds) pass(c, &s->member, sizeof s->member);
#define PASS_ARRAY(type, name, count, kept)                                                                                                \
    if (kept) pass(c, s->name, (size_t)(count) * sizeof(type));
    KEPT_NUMBERS(PASS_NUMBER)
    SN_STATE_ARRAYS(PASS_ARRAY)
#undef PASS_NUMBER
#undef PASS_ARRAY
}

/* What a state fits: the rest shapes and the rows, by the list of the model's arrays. */
#define COUNT_FITTED(type, name, count, nullable, fitted) +(fitted)
enum { FITTED_ARRAYS = 0 SN_MODEL_ARRAYS(COUNT_FITTED) };
#undef COUNT_FITTED

static sn_status fingerprint(const sn_model *model, char out[SN_HASH_LENGTH], sn_error *error) {
    size_t size = (size_t)model->muscle_count * FITTED_ARRAYS * SN_HASH_LENGTH;
    char *hashes = sn_alloc(size + 1, 1), *next = hashes;
    if (hashes == NULL) return sn_fail_memory(error, "the state");
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
#define HASH(type, name, count, nullable, fitted)                                                                                          \
    if (fitted) sn_hash(m->name, (size_t)(count) * sizeof(type), next), next += SN_HASH_LENGTH;
        SN_MODEL_ARRAYS(HASH)
#undef HASH
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
    cursor write = {.to = *bytes, .at = HEADER, .size = *size};
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

/* The model that it was made for, against this one. */
static sn_status check_fit(const sn_model *model, const char *bytes, size_t size, sn_error *error) {
    char own[SN_HASH_LENGTH];
    size_t needed = 0;
    sn_status status = fingerprint(model, own, error);
    if (status == SN_OK) status = packed_size(model, own, &needed, error);
    if (status != SN_OK) return status;
    if (size == needed && memcmp(bytes + HEADER, own, SN_HASH_LENGTH) == 0) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT,
                   "this state is another scene's, or was made under another scheme or solver: its constraints are not the same");
}

/* ---- what every number may be ----------------------------------------------------------------------------------------------- */

/* Of arrays by the type of their elements: a type without a rule does not compile. */

static bool sound_numbers(const double *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && isfinite(values[i]);
    return sound;
}

static bool sound_vectors(const sn_vec3 *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_finite3(values[i]);
    return sound;
}

static bool sound_points(const sn_point *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && sn_finite3(sn_point_position(&values[i])) && isfinite(values[i].w);
    return sound;
}

static bool sound_single_points(const sn_single_point *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++)
        sound = sound && isfinite(values[i].x) && isfinite(values[i].y) && isfinite(values[i].z) && isfinite(values[i].w);
    return sound;
}

static bool sound_flags(const bool *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && is_flag(&values[i]);
    return sound;
}

/* A product of rotations, each a unit to within the 1e-6 that a scene may have it off. */
static bool is_unit(sn_quat q) { return fabs(sn_quat_dot(q, q) - 1.0) <= 1e-3; }

/* Zeros: nothing has turned yet. */
static bool sound_turns(const sn_quat *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && (is_unit(values[i]) || sn_quat_dot(values[i], values[i]) == 0.0);
    return sound;
}

static bool sound_poses(const sn_rigid *values, size_t count) {
    bool sound = true;
    for (size_t i = 0; i < count; i++) sound = sound && is_unit(values[i].rotation) && sn_finite3(values[i].translation);
    return sound;
}

#define SOUND(values, count)                                                                                                               \
    _Generic((values),                                                                                                                     \
        double *: sound_numbers,                                                                                                           \
        sn_vec3 *: sound_vectors,                                                                                                          \
        sn_point *: sound_points,                                                                                                          \
        sn_single_point *: sound_single_points,                                                                                            \
        bool *: sound_flags,                                                                                                               \
        sn_quat *: sound_turns,                                                                                                            \
        sn_rigid *: sound_poses)((values), (count))

/* Points are as heavy as the model's. */
static bool weights_fit(const sn_model_muscle *m, const sn_muscle_state *s) {
    for (sn_index i = 0; i < m->point_count; i++) {
        if (s->points[i].w != m->inverse_mass[i]) return false;
        if (m->single && s->single_points[i].w != sn_single_weight(m, i)) return false;
    }
    return true;
}

/* What L-BFGS divides by. */
static bool pairs_curve(const sn_muscle_state *s) {
    for (sn_index i = 0; i < s->pair_count; i++)
        if (!(s->pair_products[i] > 0.0)) return false;
    return true;
}

/* A matrix that turns with a muscle has frames; none where no point is free. */
static bool has_turned(const sn_model_muscle *m, const sn_muscle_state *s) {
    if (!s->turned || !m->corotated || m->kinematic_count >= m->point_count) return true;
    for (sn_index i = 0; i < m->point_count; i++)
        if (!is_unit(s->turns[i])) return false;
    return true;
}

/* How many elements of an array are ever read. */
static size_t checked_count(int kept, size_t count, const sn_muscle_state *s) {
    return kept == SN_KEPT_LIVE ? count / SN_QN_MEMORY * (size_t)s->pair_count : count;
}

/* The first member that no run leaves like this; NULL = all is well. */
static const char *find_fault(const sn_model_muscle *m, const sn_muscle_state *s) {
#define CHECK_NUMBER(member, holds)                                                                                                        \
    if (!(holds)) return #member;
#define CHECK_ARRAY(type, name, count, kept)                                                                                               \
    if (kept && !SOUND(s->name, checked_count(kept, (size_t)(count), s))) return #name;
    KEPT_NUMBERS(CHECK_NUMBER)
    SN_STATE_ARRAYS(CHECK_ARRAY)
#undef CHECK_NUMBER
#undef CHECK_ARRAY
    if (!weights_fit(m, s)) return "points";
    if (!pairs_curve(s)) return "pair_products";
    return has_turned(m, s) ? NULL : "turns";
}

static bool has_iteration(const sn_model *model, sn_index iteration) {
    bool has = iteration == 0;
    int64_t steps = model->halves ? SN_SUBSTEP_PARTS + SN_MOST_HALVINGS : 1; /* in the smallest parts, and those that were given up */
    for (sn_index i = 0; i < model->muscle_count; i++) has = has || (iteration > 0 && iteration < steps * model->muscles[i].iterations);
    return has;
}

static sn_status check_moment(const sn_model *model, const sn_state *read, sn_index muscles, sn_error *error) {
    sn_index substeps = sn_solver_substeps(&model->scene->solver);
    if (muscles != model->muscle_count)
        return sn_fail(error, SN_ERROR_INPUT, "this state says that it has %ld muscles, and holds %ld; write it anew", (long)muscles,
                       (long)model->muscle_count);
    if (read->frame < -SN_FRAME_LIMIT || read->frame > SN_FRAME_LIMIT)
        return sn_fail(error, SN_ERROR_INPUT, "this state is of frame %ld, and frames go from %d to %d; write it anew", (long)read->frame,
                       -SN_FRAME_LIMIT, SN_FRAME_LIMIT);
    if (read->substep < 0 || read->substep >= substeps)
        return sn_fail(error, SN_ERROR_INPUT, "this state stopped in substep %lld of its frame; the scene has %ld, and must have as many",
                       (long long)read->substep + 1, (long)substeps);
    if (!has_iteration(model, read->iteration))
        return sn_fail(error, SN_ERROR_INPUT,
                       "this state stopped after iteration %ld of a substep, and the scene has no more of them than "
                       "that; give it as many as it had",
                       (long)read->iteration);
    return SN_OK;
}

static sn_status check_numbers(const sn_model *model, const sn_state *read, sn_error *error) {
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const char *fault = find_fault(&model->muscles[i], &read->muscles[i]);
        if (fault == NULL) continue;
        const char *name = model->muscles[i].source->name;
        return sn_fail(error, SN_ERROR_INPUT, "this state is damaged: %s of muscle \"%s\" is nothing that a run comes to; write it anew",
                       fault, name != NULL ? name : "(unnamed)");
    }
    return SN_OK;
}

/* ---- a state that holds nothing but what is kept ---------------------------------------------------------------------------- */

static bool make_kept(const sn_model_muscle *m, sn_muscle_state *s) {
    bool made = true;
#define MAKE(type, name, count, kept)                                                                                                      \
    if (kept) made = (s->name = SN_NEW(type, count)) != NULL && made;
    SN_STATE_ARRAYS(MAKE)
#undef MAKE
    return made;
}

static void free_kept(sn_muscle_state *s) {
#define FREE(type, name, count, kept) free(s->name); /* NULL where it is not kept */
    SN_STATE_ARRAYS(FREE)
#undef FREE
}

static void free_read(const sn_model *model, sn_state *read) {
    for (sn_index i = 0; read->muscles != NULL && i < model->muscle_count; i++) free_kept(&read->muscles[i]);
    free(read->muscles);
}

/* All of the bytes, checked. */
static sn_status read_state(const sn_model *model, const char *bytes, size_t size, sn_state *read, sn_error *error) {
    char hash[SN_HASH_LENGTH];
    sn_index muscles = 0;
    bool made = (read->muscles = SN_NEW(sn_muscle_state, model->muscle_count)) != NULL;
    for (sn_index i = 0; made && i < model->muscle_count; i++) made = make_kept(&model->muscles[i], &read->muscles[i]);
    if (!made) return sn_fail_memory(error, "the state");
    cursor c = {.from = bytes, .at = HEADER, .size = size};
    pass_state(&c, model, read, hash, &muscles);
    sn_status status = check_moment(model, read, muscles, error);
    return status == SN_OK ? check_numbers(model, read, error) : status;
}

/* Stiffness, contraction and goals of the activation that the state stopped with. */
static void make_inputs(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_scene_muscle source = *m->source;
    sn_model_muscle held = *m;
    source.activation = (sn_channel){.constant = s->activation};
    held.source = &source;
    s->activation = s->goal_contraction = s->goal_ratio = NAN;
    sn_inputs_update(&held, s, 0.0);
}

static void take_muscle(const sn_model_muscle *m, const sn_muscle_state *read, sn_muscle_state *s) {
#define TAKE_NUMBER(member, holds) s->member = read->member;
#define TAKE_ARRAY(type, name, count, kept)                                                                                                \
    if (kept && (count) > 0) memcpy(s->name, read->name, (size_t)(count) * sizeof(type));
    KEPT_NUMBERS(TAKE_NUMBER)
    SN_STATE_ARRAYS(TAKE_ARRAY)
#undef TAKE_NUMBER
#undef TAKE_ARRAY
    s->statistics.stop_reason = s->stopped;
    make_inputs(m, s);
    sn_statistics_measure(m, s);
}

sn_status sn_state_unpack(const sn_model *model, const char *bytes, size_t size, sn_state *state, sn_error *error) {
    sn_state read = {0};
    sn_status status = check_header(bytes, size, error);
    if (status == SN_OK) status = check_fit(model, bytes, size, error);
    if (status == SN_OK) status = read_state(model, bytes, size, &read, error);
    if (status == SN_OK) {
        state->frame = read.frame, state->substep = read.substep, state->iteration = read.iteration;
        for (sn_index i = 0; i < model->muscle_count; i++) take_muscle(&model->muscles[i], &read.muscles[i], &state->muscles[i]);
    }
    free_read(model, &read);
    return status;
}

sn_index sn_state_next_frame(const sn_state *state) { return state->frame + (state->substep == 0 && state->iteration == 0 ? 1 : 0); }
