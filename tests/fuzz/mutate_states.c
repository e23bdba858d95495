/*
 * mutate_states.c -- forged states under right checksums: mutate_states [COUNT [FIRST]], or mutate_states --seeds FOLDER
 *
 * States of small models of every back end, between two frames and in the middle of one, are given other numbers, flipped and spliced, from
 * seeds: case n is always the same state. Each must be refused with one line and leave the state as it was, or be taken, come back from
 * being packed, and go on by a step. The sanitizers watch over the rest (make CONFIG=sanitize).
 * --seeds writes the good states to FOLDER/state as tests/fuzz/targets/state.c takes them.
 */
#include "states.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

/* Of the processor, for one case: a limit against hanging, which judges no speed. */
enum { SECONDS_UNTIL_HANGING = 30 };
/* One state of so many that are taken is packed and taken again: most of the time goes into checksums. */
enum { TAKEN_AGAIN = 5 };

/* Where a good state stopped: frames, then substeps and iterations of the next one. */
static const sn_index STOPS[][3] = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {2, 0, 1}, {1, 1, 2}};
enum { STOP_COUNT = sizeof STOPS / sizeof *STOPS };

typedef struct packed {
    char *bytes;
    size_t size;
} packed;

typedef struct seed {
    sn_scene scene;
    simulation run;
    packed good[STOP_COUNT];
    packed now; /* run.state as it is */
} seed;

static seed seeds[MODEL_COUNT];
static long passed, failed, taken, current_case;

static void give_up(const char *what) {
    printf("%s\n0 passed, 1 failed\n", what);
    exit(1);
}

static packed pack(const simulation *run) {
    packed out = {0};
    if (sn_state_pack(run->model, run->state, &out.bytes, &out.size, NULL) != SN_OK) give_up("a state cannot be packed");
    return out;
}

static packed pack_anew(const simulation *run, packed old) {
    free(old.bytes);
    return pack(run);
}

/* ---- good states ---------------------------------------------------------------------------------------------------- */

static packed make_good(simulation *run, const sn_index stop[3]) {
    bool middle = stop[1] + stop[2] > 0;
    sn_step_options options = {.stop_substep = stop[1] + (stop[2] > 0), .stop_iteration = stop[2]};
    sn_state_reset(run->model, run->state);
    for (sn_index i = 0; i < stop[0]; i++)
        if (sn_step(run->model, run->state, NULL, NULL) != SN_OK) give_up("a step fails");
    if (middle && sn_step(run->model, run->state, &options, NULL) != SN_STOPPED) give_up("a step does not stop");
    return pack(run);
}

static void make_seeds(void) {
    for (int i = 0; i < MODEL_COUNT; i++) {
        make_model(&MODELS[i], &seeds[i].scene, &seeds[i].run);
        for (int k = 0; k < STOP_COUNT; k++) seeds[i].good[k] = make_good(&seeds[i].run, STOPS[k]);
        seeds[i].now = pack(&seeds[i].run);
    }
}

static void free_seeds(void) {
    for (int i = 0; i < MODEL_COUNT; i++) {
        for (int k = 0; k < STOP_COUNT; k++) free(seeds[i].good[k].bytes);
        free(seeds[i].now.bytes);
        finish(&seeds[i].run);
    }
}

/* The number of the model, then all that follows its fingerprint. */
static void write_seeds(const char *folder) {
    char path[512];
    snprintf(path, sizeof path, "%s/state", folder);
    mkdir(folder, 0777);
    mkdir(path, 0777);
    for (int i = 0; i < MODEL_COUNT; i++) {
        for (int k = 0; k < STOP_COUNT; k++) {
            snprintf(path, sizeof path, "%s/state/%d-%d", folder, i, k);
            FILE *file = fopen(path, "wb");
            if (file == NULL) give_up("cannot write the seeds");
            fputc(i, file);
            fwrite(seeds[i].good[k].bytes + MOMENT, 1, seeds[i].good[k].size - MOMENT, file);
            if (fclose(file) != 0) give_up("cannot write the seeds");
        }
    }
}

/* ---- forgery -------------------------------------------------------------------------------------------------------- */

/* xorshift64* */
static uint64_t next(uint64_t *state) {
    *state ^= *state >> 12, *state ^= *state << 25, *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1dULL;
}

static size_t below(uint64_t *state, size_t limit) { return (size_t)(next(state) >> 11) % limit; }

/* Single numbers come first, arrays after them; every second time one of the former, mostly on a boundary of numbers. */
static size_t choose_place(uint64_t *state, const packed *p, size_t length) {
    enum { NUMBERS = 284 }; /* bytes of the moment and of the first group's single numbers, about */
    size_t room = p->size - MOMENT - length, at = below(state, below(state, 2) == 0 ? NUMBERS : room);
    if (below(state, 4) > 0) at -= at % 4;
    if (below(state, 2) > 0) at += 3; /* behind the flags */
    return MOMENT + (at < room ? at : room);
}

static void put(packed *p, uint64_t *state, const void *value, size_t length) {
    memcpy(p->bytes + choose_place(state, p, length), value, length);
}

static void put_number(packed *p, uint64_t *state) {
    static const double VALUES[] = {NAN,  INFINITY, -INFINITY, 0.0,  -0.0,   1.0,    -1.0,    0.5,   1.0 + 1e-12,
                                    1e30, -1e30,    1e300,     1e-9, 5e-324, 1e-300, 1.7e308, 1e154, -1e-3};
    double value = VALUES[below(state, sizeof VALUES / sizeof *VALUES)];
    put(p, state, &value, sizeof value);
}

static void put_float(packed *p, uint64_t *state) {
    static const float VALUES[] = {NAN, INFINITY, 0.0F, -1.0F, 1e30F, 3e38F, 1e-40F};
    float value = VALUES[below(state, sizeof VALUES / sizeof *VALUES)];
    put(p, state, &value, sizeof value);
}

static void put_integer(packed *p, uint64_t *state) {
    static const int32_t VALUES[] = {0, 1, 2, 3, 4, 5, 7, 8, 9, 16, 255, 65535, -1, -2, -8, INT32_MAX, INT32_MIN, INT32_MAX - 1, 100000000};
    int32_t value = VALUES[below(state, sizeof VALUES / sizeof *VALUES)];
    put(p, state, &value, sizeof value);
}

static void put_count(packed *p, uint64_t *state) {
    static const int64_t VALUES[] = {-1, INT64_MAX, INT64_MIN, INT64_MAX / 2, 1LL << 40};
    int64_t value = VALUES[below(state, sizeof VALUES / sizeof *VALUES)];
    put(p, state, &value, sizeof value);
}

static void put_byte(packed *p, uint64_t *state) {
    char value = (char)below(state, below(state, 2) == 0 ? 4 : 256);
    put(p, state, &value, sizeof value);
}

static void flip_bit(packed *p, uint64_t *state) { p->bytes[choose_place(state, p, 1)] ^= (char)(1 << below(state, 8)); }

/* A part of another state of the same model, in its place. */
static void splice(packed *p, uint64_t *state, const seed *from) {
    const packed *other = &from->good[below(state, STOP_COUNT)];
    size_t at = choose_place(state, p, 1);
    memcpy(p->bytes + at, other->bytes + at, below(state, p->size - at + 1));
}

/* One block over another. */
static void copy_block(packed *p, uint64_t *state) {
    size_t length = 8 * (1 + below(state, 64)), from = choose_place(state, p, length);
    memmove(p->bytes + choose_place(state, p, length), p->bytes + from, length);
}

static void forge(packed *p, uint64_t *state, const seed *from) {
    switch (below(state, 10)) {
    case 0:
    case 1:
    case 2:
        put_number(p, state);
        break;
    case 3:
        put_float(p, state);
        break;
    case 4:
    case 5:
        put_integer(p, state);
        break;
    case 6:
        put_count(p, state);
        break;
    case 7:
        put_byte(p, state);
        break;
    case 8:
        flip_bit(p, state);
        break;
    default:
        if (below(state, 2) == 0)
            splice(p, state, from);
        else
            copy_block(p, state);
        break;
    }
}

/* ---- cases ---------------------------------------------------------------------------------------------------------- */

static const struct itimerval LIMIT = {.it_value = {SECONDS_UNTIL_HANGING, 0}}, NO_LIMIT = {0};

static void on_alarm(int signal_number) {
    (void)signal_number;
    char text[64];
    int length = snprintf(text, sizeof text, "case %ld hangs\n0 passed, 1 failed\n", current_case);
    if (length > 0 && write(STDOUT_FILENO, text, (size_t)length) > 0) _exit(1);
    _exit(1);
}

/* What was refused has left the state as it was. */
static const char *check_untouched(seed *s) {
    packed after = pack(&s->run);
    bool same = after.size == s->now.size && memcmp(after.bytes, s->now.bytes, after.size) == 0;
    free(s->now.bytes);
    s->now = after;
    return same ? NULL : "it was refused, and has changed the state";
}

/* What was taken is a good state: packed, it is taken again. */
static const char *check_taken(seed *s, const packed *p) {
    sn_error error = {0};
    if (sn_state_unpack(s->run.model, p->bytes, p->size, s->run.state, &error) != SN_OK) return "it is taken once, and then refused";
    packed again = pack(&s->run);
    sn_status status = sn_state_unpack(s->run.model, again.bytes, again.size, s->run.state, &error);
    free(again.bytes);
    return status == SN_OK ? NULL : "it is taken, and refused when it has been packed";
}

static bool try_packed(seed *s, const packed *p, const char *name) {
    sn_status status;
    sn_error error;
    setitimer(ITIMER_PROF, &LIMIT, NULL);
    const char *fault = try_state(&s->run, p->bytes, p->size, &status, &error);
    if (fault == NULL && status != SN_OK) fault = check_untouched(s);
    if (fault == NULL && status == SN_OK && current_case % TAKEN_AGAIN == 0) fault = check_taken(s, p);
    if (status == SN_OK) s->now = pack_anew(&s->run, s->now);
    setitimer(ITIMER_PROF, &NO_LIMIT, NULL);
    passed += fault == NULL;
    failed += fault != NULL;
    taken += status == SN_OK;
    if (fault != NULL) printf("case %ld (%s): %s; '%s'\n", current_case, name, fault, error.text);
    return status == SN_OK;
}

static void try_case(long number) {
    uint64_t state = (uint64_t)number * 0x9e3779b97f4a7c15ULL + 1;
    int model = (int)(number % MODEL_COUNT);
    seed *s = &seeds[model];
    const packed *good = &s->good[below(&state, STOP_COUNT)];
    packed p = {.bytes = malloc(good->size), .size = good->size};
    if (p.bytes == NULL) give_up("out of memory");
    memcpy(p.bytes, good->bytes, p.size);
    current_case = number;
    for (size_t i = 0, count = 1 + below(&state, 3); i < count; i++) forge(&p, &state, s);
    seal(p.bytes, p.size);
    try_packed(s, &p, MODELS[model].name);
    free(p.bytes);
}

int main(int argc, char **argv) {
    bool seeds_only = argc > 2 && strcmp(argv[1], "--seeds") == 0;
    long count = argc > 1 ? strtol(argv[1], NULL, 10) : 10000, first = argc > 2 ? strtol(argv[2], NULL, 10) : 0;
    signal(SIGPROF, on_alarm);
    setvbuf(stdout, NULL, _IOLBF, 0);
    make_seeds();
    if (seeds_only) {
        write_seeds(argv[2]);
        return 0;
    }
    current_case = -1;
    for (int i = 0; i < MODEL_COUNT; i++)
        for (int k = 0; k < STOP_COUNT; k++)
            if (!try_packed(&seeds[i], &seeds[i].good[k], MODELS[i].name))
                failed++, printf("%s: a good state was refused\n", MODELS[i].name);
    taken = 0;
    for (long i = 0; i < count; i++) try_case(first + i);
    printf("%ld forged states, of which %ld were such as a run may come to\n", count, taken);
    free_seeds();
    printf("%ld passed, %ld failed\n", passed, failed);
    return failed > 0;
}
