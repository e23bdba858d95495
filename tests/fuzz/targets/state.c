/*
 * state.c -- states of a simulation under libFuzzer, coverage-guided (make fuzz): the first byte chooses a model (tests/fuzz/states.h), the
 * others are what follows the model's fingerprint. The header in front of them is always right, so that the checksum hides nothing.
 */
#include "../states.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct opened {
    sn_scene scene;
    simulation run;
    char *bytes; /* (size) a good state */
    size_t size;
} opened;

/* Each is made once, for all inputs. */
static opened *open_model(int number) {
    static opened models[MODEL_COUNT];
    opened *o = &models[number];
    if (o->bytes != NULL) return o;
    make_model(&MODELS[number], &o->scene, &o->run);
    if (sn_state_pack(o->run.model, o->run.state, &o->bytes, &o->size, NULL) != SN_OK) abort();
    return o;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    sn_status status;
    sn_error error;
    if (size == 0 || data[0] >= MODEL_COUNT) return -1;
    opened *o = open_model(data[0]);
    if (size - 1 > o->size - MOMENT) return -1; /* what is missing at the end is as in a good state */
    char *forged = malloc(o->size);
    if (forged == NULL) return 0;
    memcpy(forged, o->bytes, o->size);
    memcpy(forged + MOMENT, data + 1, size - 1);
    seal(forged, o->size);
    const char *fault = try_state(&o->run, forged, o->size, &status, &error);
    free(forged);
    if (fault == NULL) return 0;
    fprintf(stderr, "reader: %s; '%s'\n", fault, error.text);
    abort();
}
