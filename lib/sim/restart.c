/*
 * restart.c -- a state as bytes, and back: a run that stops anywhere and goes on from there gives the bits of one that did not.
 *
 *   "sinew state\n"  version (4 bytes)  hash of all that follows (72 bytes)
 *   hash of the model (72 bytes)  frame, substep, iteration, muscles (4 bytes each)
 *   per group: numbers of the group, of its members, of the back end; then in the same order the arrays that are kept
 *
 * Each part has its list (state.h, and one of the back end's own). Numbers are as the machine has them; the version tells a machine of the
 * other byte order. Inputs, goals and statistics are made anew. A checksum keeps chance away, not malice: whatever it says, every number is
 * held to what it may be before any of them is taken.
 */
#include "backend.h"
#include "contact.h"
#include "external.h"

static const char MAGIC[12] = "sinew state\n";
enum { VERSION = 7, HEADER = sizeof MAGIC + sizeof(int32_t) + SN_HASH_LENGTH };

/* ---- the numbers of a group and of its members ------------------------------------------------------------------------------ */

/* Of shares that are interpolated. */
static const double ROUNDING = 1e-9;

/* Of what happened in one frame: there is always room for more. */
static bool is_count(int64_t count) { return count >= 0 && count <= INT64_MAX / 2; }

/* Parts of a substep that are done, and the step at hand, which is one of the halves that there are. */
static bool is_progress(const sn_group *g, const sn_progress *p) {
    bool power = p->size >= 0 && p->size <= SN_SUBSTEP_PARTS && (p->size & (p->size - 1)) == 0;
    bool fits = p->parts >= 0 && p->parts <= SN_SUBSTEP_PARTS && (p->parts == SN_SUBSTEP_PARTS || p->parts + p->size <= SN_SUBSTEP_PARTS);
    bool asleep = p->size == 0 && (p->parts == 0 || p->parts == SN_SUBSTEP_PARTS) && p->iteration == 0;
    bool cut = g->members[0]->quasi_newton || g->members[0]->contact_count > 0;
    bool whole = cut || p->size == 0 || p->size == SN_SUBSTEP_PARTS;
    return power && fits && whole && (asleep || (p->size > 0 && p->parts % p->size == 0)) && p->iteration >= 0 &&
           p->iteration < g->iterations && p->spent >= 0;
}

static bool is_motion(const sn_bone_motion *b) {
    return sn_finite3(b->middle) && sn_finite3(b->velocity) && sn_finite3(b->turn) && b->rate >= 0.0 && isfinite(b->rate);
}

#define GROUP_NUMBERS(X)                                                                                                                   \
    X(progress, is_progress(g, &part->progress))                                                                                           \
    X(still, part->still >= 0)

#define STATISTICS_NUMBERS(X)                                                                                                              \
    X(statistics.skipped_edges, is_count(part->statistics.skipped_edges))                                                                  \
    X(statistics.skipped_hinges, is_count(part->statistics.skipped_hinges))                                                                \
    X(statistics.clamped_hinges, is_count(part->statistics.clamped_hinges))                                                                \
    X(statistics.held_triangles, is_count(part->statistics.held_triangles))                                                                \
    X(statistics.skipped_triangles, is_count(part->statistics.skipped_triangles))                                                          \
    X(statistics.iterations, is_count(part->statistics.iterations))                                                                        \
    X(statistics.rejected_steps, is_count(part->statistics.rejected_steps))                                                                \
    X(statistics.refactorisations, is_count(part->statistics.refactorisations))                                                            \
    X(statistics.steps, is_count(part->statistics.steps))                                                                                  \
    X(statistics.halvings, is_count(part->statistics.halvings))                                                                            \
    X(statistics.leaps, is_count(part->statistics.leaps))                                                                                  \
    X(statistics.torn_substeps, is_count(part->statistics.torn_substeps))                                                                  \
    X(statistics.restarts, is_count(part->statistics.restarts))                                                                            \
    X(statistics.residual, !(part->statistics.residual < 0.0)) /* NaN: inside a substep */

#define INPUT_NUMBERS(X)                                                                                                                   \
    X(activation, part->activation >= -ROUNDING && part->activation <= 1.0 + ROUNDING)                                                     \
    X(contraction, part->contraction >= -ROUNDING && part->contraction <= 1.0 + ROUNDING)                                                  \
    X(stiffness, part->stiffness >= 0.0 && isfinite(part->stiffness))                                                                      \
    X(volume_goal, isfinite(part->volume_goal))                                                                                            \
    X(bones, is_motion(&part->bones))                                                                                                      \
    X(resolve_begin, isfinite(part->resolve_begin))                                                                                        \
    X(parted, part->parted >= 0.0 && part->parted <= 1.0)

static void pass_member_numbers(sn_cursor *c, sn_muscle_state *s) {
    {
        sn_muscle_state *part = s;
        STATISTICS_NUMBERS(SN_PASS_NUMBER)
    }
    sn_inputs *part = s->inputs;
    INPUT_NUMBERS(SN_PASS_NUMBER)
}

static void pass_member_arrays(sn_cursor *c, const sn_model_muscle *m, sn_muscle_state *s) {
    sn_inputs *part = s->inputs;
    SN_INPUT_ARRAYS(SN_PASS_ARRAY)
}

static void pass_group(sn_cursor *c, const sn_backend *backend, const sn_group *g, sn_group_state *part) {
    GROUP_NUMBERS(SN_PASS_NUMBER)
    for (sn_index i = 0; i < g->count; i++) pass_member_numbers(c, part->members[i]);
    backend->pass_numbers(c, g, part);
    SN_POINT_ARRAYS(SN_PASS_ARRAY)
    for (sn_index i = 0; i < g->count; i++) pass_member_arrays(c, g->members[i], part->members[i]);
    backend->pass_arrays(c, g, part);
}

/* Points are as heavy as the model's. */
static bool weights_fit(const sn_model_muscle *m, const sn_muscle_state *s) {
    for (sn_index i = 0; i < m->point_count; i++)
        if (s->points[i].w != m->inverse_mass[i]) return false;
    return true;
}

/* The first member that no run leaves like this; NULL = all is well. */
static const char *member_fault(const sn_model_muscle *m, const sn_muscle_state *s) {
    {
        const sn_muscle_state *part = s;
        STATISTICS_NUMBERS(SN_CHECK_NUMBER)
    }
    const sn_inputs *part = s->inputs;
    INPUT_NUMBERS(SN_CHECK_NUMBER)
    SN_INPUT_ARRAYS(SN_CHECK_ARRAY)
    return weights_fit(m, s) ? NULL : "points";
}

/* The first member of the group's own, or of the back end's. */
static const char *group_fault(const sn_backend *backend, const sn_group *g, const sn_group_state *part) {
    GROUP_NUMBERS(SN_CHECK_NUMBER)
    SN_POINT_ARRAYS(SN_CHECK_ARRAY)
    if (!sn_externals_sound(g, part)) return "slides_on";
    return backend->fault(g, part);
}

static void take_member(const sn_model_muscle *m, const sn_muscle_state *from, sn_muscle_state *s) {
    {
        const sn_muscle_state *read = from;
        sn_muscle_state *part = s;
        STATISTICS_NUMBERS(SN_TAKE_NUMBER)
    }
    const sn_inputs *read = from->inputs;
    sn_inputs *part = s->inputs;
    INPUT_NUMBERS(SN_TAKE_NUMBER)
    SN_INPUT_ARRAYS(SN_TAKE_ARRAY)
    sn_patches_fit(m, s);
}

/* What external constraints hold on to, for whoever looks at a state that was read: in a step what they do since its start, else where the
 * points are. A step finds it anew. */
static void find_externals(const sn_group *g, sn_group_state *s) {
    bool inside = s->progress.parts < SN_SUBSTEP_PARTS && s->progress.size > 0;
    sn_vec3 *previous = s->previous, *points = g->row_count > 0 && !inside ? SN_NEW(sn_vec3, g->point_count) : NULL;
    for (sn_index i = 0; points != NULL && i < g->point_count; i++) points[i] = sn_point_position(&s->points[i]);
    if (points != NULL) s->previous = points;
    sn_externals_find(g, s);
    s->previous = previous;
    free(points);
}

static void take_group(const sn_backend *backend, const sn_group *g, const sn_group_state *read, sn_group_state *part) {
    GROUP_NUMBERS(SN_TAKE_NUMBER)
    SN_POINT_ARRAYS(SN_TAKE_ARRAY)
    for (sn_index i = 0; i < g->count; i++) take_member(g->members[i], read->members[i], part->members[i]);
    find_externals(g, part);
    backend->take(g, read, part);
}

/* ---- the whole state ---------------------------------------------------------------------------------------------------------- */

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

/* What a state says of itself beside its groups. */
typedef struct head {
    char hash[SN_HASH_LENGTH]; /* of the model that it fits */
    sn_index muscles;
    double rate; /* frames a second of the scene */
} head;

static void pass_state(sn_cursor *c, const sn_model *model, sn_state *state, head *h) {
    const sn_backend *backend = sn_backend_of(model->scene);
    sn_cursor_pass(c, h->hash, SN_HASH_LENGTH);
    sn_cursor_pass(c, &state->frame, sizeof state->frame);
    sn_cursor_pass(c, &state->substep, sizeof state->substep);
    sn_cursor_pass(c, &state->iteration, sizeof state->iteration);
    sn_cursor_pass(c, &h->muscles, sizeof h->muscles);
    for (sn_index i = 0; i < model->group_count; i++) pass_group(c, backend, &model->groups[i], &state->groups[i]);
    sn_cursor_pass(c, &h->rate, sizeof h->rate);
}

/* Bytes of a packed state of this model; `state` is any of its, and only looked at. */
static size_t packed_size(const sn_model *model, const sn_state *state) {
    head h;
    sn_state copy = *state;
    sn_cursor count = {.at = HEADER};
    pass_state(&count, model, &copy, &h);
    return count.at;
}

/* ---- out -------------------------------------------------------------------------------------------------------------------- */

sn_status sn_state_pack(const sn_model *model, const sn_state *state, char **bytes, size_t *size, sn_error *error) {
    sn_state copy = *state; /* the cursor only reads from it here */
    head h = {.muscles = model->muscle_count, .rate = model->scene->rate};
    int32_t version = VERSION;
    sn_status status = fingerprint(model, h.hash, error);
    if (status != SN_OK) return status;
    *size = packed_size(model, state);
    if ((*bytes = sn_alloc(*size, 1)) == NULL) return sn_fail_memory(error, "the state");
    sn_cursor write = {.to = *bytes, .at = HEADER, .size = *size};
    pass_state(&write, model, &copy, &h);
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

/* The model that it was made for, against this one; `state` is any of its. */
static sn_status check_fit(const sn_model *model, const sn_state *state, const char *bytes, size_t size, sn_error *error) {
    char own[SN_HASH_LENGTH];
    sn_status status = fingerprint(model, own, error);
    if (status != SN_OK) return status;
    if (size == packed_size(model, state) && memcmp(bytes + HEADER, own, SN_HASH_LENGTH) == 0) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT,
                   "this state is another scene's, or was made under another scheme or solver: its constraints are not the same");
}

static bool has_iteration(const sn_model *model, sn_index iteration) {
    bool has = iteration == 0;
    bool cuts = model->halves || model->contact != NULL;
    int64_t steps = cuts ? SN_SUBSTEP_PARTS + SN_MOST_HALVINGS : 1; /* in the smallest parts, and those that were given up */
    for (sn_index i = 0; i < model->muscle_count; i++) has = has || (iteration > 0 && iteration < steps * model->muscles[i].iterations);
    return has;
}

static sn_status check_moment(const sn_model *model, const sn_state *read, const head *h, sn_error *error) {
    sn_index substeps = sn_most_substeps(model);
    if (h->muscles != model->muscle_count)
        return sn_fail(error, SN_ERROR_INPUT, "this state says that it has %ld muscles, and holds %ld; write it anew", (long)h->muscles,
                       (long)model->muscle_count);
    if (h->rate != model->scene->rate)
        return sn_fail(error, SN_ERROR_USAGE, "this state was made at %g frames a second, and the scene has %g; go on with --rate %g",
                       h->rate, model->scene->rate, h->rate);
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

static sn_status tell_fault(const sn_model_muscle *m, const char *fault, sn_error *error) {
    const char *name = m->source->name;
    return sn_fail(error, SN_ERROR_INPUT, "this state is damaged: %s of muscle \"%s\" is nothing that a run comes to; write it anew", fault,
                   name != NULL ? name : "(unnamed)");
}

static sn_status check_numbers(const sn_model *model, const sn_state *read, sn_error *error) {
    const sn_backend *backend = sn_backend_of(model->scene);
    for (sn_index i = 0; i < model->group_count; i++) {
        const sn_group *g = &model->groups[i];
        const char *fault = group_fault(backend, g, &read->groups[i]);
        if (fault != NULL) return tell_fault(g->members[0], fault, error);
        for (sn_index k = 0; k < g->count; k++)
            if ((fault = member_fault(g->members[k], read->groups[i].members[k])) != NULL) return tell_fault(g->members[k], fault, error);
    }
    return SN_OK;
}

/* All of the bytes, checked. */
static sn_status read_state(const sn_model *model, const char *bytes, size_t size, sn_state *read, sn_error *error) {
    head h = {.muscles = 0};
    sn_cursor c = {.from = bytes, .at = HEADER, .size = size};
    pass_state(&c, model, read, &h);
    sn_status status = check_moment(model, read, &h, error);
    return status == SN_OK ? check_numbers(model, read, error) : status;
}

/* Stiffness, contraction and goals of the activation that the state stopped with. */
static void make_inputs(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_scene_muscle source = *m->source;
    sn_model_muscle held = *m;
    source.activation = (sn_channel){.constant = s->inputs->activation};
    held.source = &source;
    s->inputs->activation = s->inputs->goal_contraction = s->inputs->goal_ratio = NAN;
    sn_inputs_update(&held, s, 0.0);
}

static void take_state(const sn_model *model, const sn_state *read, sn_state *state) {
    const sn_backend *backend = sn_backend_of(model->scene);
    state->frame = read->frame, state->substep = read->substep, state->iteration = read->iteration;
    for (sn_index i = 0; i < model->group_count; i++) take_group(backend, &model->groups[i], &read->groups[i], &state->groups[i]);
    for (sn_index i = 0; i < model->muscle_count; i++) {
        make_inputs(&model->muscles[i], &state->muscles[i]);
        sn_statistics_measure(&model->muscles[i], &state->muscles[i]);
    }
    for (sn_index i = 0; i < model->group_count; i++) sn_externals_measure(&model->groups[i], &state->groups[i]);
}

sn_status sn_state_unpack(const sn_model *model, const char *bytes, size_t size, sn_state *state, sn_error *error) {
    sn_state *read = NULL;
    sn_status status = check_header(bytes, size, error);
    if (status == SN_OK) status = check_fit(model, state, bytes, size, error);
    if (status == SN_OK) status = sn_state_make(model, true, &read, error);
    if (status == SN_OK) status = read_state(model, bytes, size, read, error);
    if (status == SN_OK) take_state(model, read, state);
    sn_state_destroy(model, read);
    return status;
}

sn_index sn_state_next_frame(const sn_state *state) { return state->frame + (state->substep == 0 && state->iteration == 0 ? 1 : 0); }
