/* activation_document.c -- activations over time, a channel each, as a scene takes them. */
#include <stdlib.h>

#include "document.h"

/* What is put out: every stride-th sample. */
static sn_index output_count(const sn_sense *sense) { return (sense->sample_count - 1) / sense->stride + 1; }

static void write_channel(const sn_sense *sense, const char *name, const double *activations, const double *times, double *values,
                          sn_json *json) {
    sn_index count = output_count(sense);
    for (sn_index k = 0; k < count; k++) values[k] = activations[(size_t)k * (size_t)sense->stride];
    sn_json_object(json, name);
    sn_json_numbers(json, "times", times, (size_t)count);
    sn_json_numbers(json, "values", values, (size_t)count);
    sn_json_close(json);
}

static sn_status write_document(const sn_sensors *sensors, const sn_sense *sense, const sn_history_entry *entry, double *numbers,
                                sn_output *output, sn_error *error) {
    sn_index count = output_count(sense);
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return sn_fail_memory(error, "an activation document");
    for (sn_index k = 0; k < count; k++) numbers[k] = sense->begin + k / sense->rate;
    sn_json_object(json, NULL);
    sn_json_text(json, "format", "sinew-activation");
    sn_json_integer(json, "version", 1);
    if (sensors->name != NULL) sn_json_text(json, "name", sensors->name);
    sn_json_object(json, "channels");
    for (sn_index i = 0; i < sense->channel_count; i++)
        write_channel(sense, sensors->channels[i].name, sense->activations[i], numbers, numbers + count, json);
    sn_json_close(json);
    sn_history_write(NULL, entry, json);
    return sn_json_end(json, error);
}

sn_status sn_activation_document_write(const sn_sensors *sensors, const sn_sense *sense, const sn_history_entry *entry, sn_output *output,
                                       sn_error *error) {
    double *numbers = sn_alloc((size_t)output_count(sense) * 2, sizeof *numbers);
    if (numbers == NULL) return sn_fail_memory(error, "an activation document");
    sn_status status = write_document(sensors, sense, entry, numbers, output, error);
    free(numbers);
    return status;
}
